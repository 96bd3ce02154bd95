"""Popov and Nyquist plot of a rod with those of its scheme on the same axes."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from lure.analysis.graphical.supporting_proof import searched_theta
from lure.analysis.plots.frequency import curve, plot_nyquist, plot_popov
from lure.analysis.plots.style import (
    BLUE,
    GREEN,
    GREY,
    LEGEND,
    PURPLE,
    VERMILLION,
    axes_or_new,
    finish_axes,
    note,
    padded,
)
from lure.analysis.rod.spectrum import rod_spectrum, wave_mode
from lure.analysis.verdict import CriterionResult
from lure.rod.discretisation import UpwindScheme
from lure.rod.transfer import RodPlant

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# The spectrum of the scheme against that of the rod.

_MOST = 200


def plot_spectrum(scheme: UpwindScheme, *, ax: Axes | None = None) -> Axes:
    """Eigenvalues of the scheme and poles of the rod in the complex plane, closed form.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme; beyond 200 cells only the slowest frequencies are drawn, and the figure says so.
    ax : Axes, optional
        Where to draw; by default a new figure.
    """
    axes = axes_or_new(ax)
    axes.axvline(0.0, color=GREY, lw=0.6)
    if scheme.rod.reflection == 0.0:
        label = f"scheme: one Jordan block of size {2 * scheme.cells}"
        axes.plot([-scheme.rate], [0.0], "o", ms=6, color=BLUE, label=label)
        note(axes, "the matched rod has no wave poles")
    else:
        drawn = min(scheme.cells, _MOST)
        first = 0 if scheme.rod.reflection < 0 else 1
        ring = _with_conjugates([wave_mode(scheme.rod, m, scheme.cells) for m in range(first, drawn + 1)])
        rod = _with_conjugates([wave_mode(scheme.rod, m, None) for m in range(first, drawn + 1)])
        top = 1.1 * float(np.abs(ring.imag).max()) or scheme.rate
        rod = rod[np.abs(rod.imag) <= top]
        size = 4.0 if drawn <= 40 else 2.0
        axes.plot(ring.real, ring.imag, "o", ms=size, color=BLUE, label=f"scheme, N = {scheme.cells}")
        axes.plot(rod.real, rod.imag, "x", ms=size + 1, color=VERMILLION, label="rod")
        axes.set_xlim(*padded(float(ring.real.min()), max(0.0, float(ring.real.max())), 0.08))
        axes.set_ylim(-top, top)
        if drawn < scheme.cells:
            note(axes, f"modes up to {drawn} of {scheme.cells}")
    axes.plot([0.0], [0.0], "s", ms=5, color=GREEN, label="zero eigenvalue of both")
    return finish_axes(axes, "Re λ [1/s]", "Im λ [rad/s]", legend="center")


def plot_damping(scheme: UpwindScheme, *, ax: Axes | None = None) -> Axes:
    """Damping of the lowest oscillating modes, scheme against rod, on a logarithmic axis.

    The distance between the two marks of a mode is damping that the scheme has and the rod has not.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on; only a note for the matched rod, which has no modes, and where no mode decays.
    """
    axes = axes_or_new(ax)
    modes = [mode for mode in rod_spectrum(scheme).modes if mode.number > 0]
    pairs = [(mode.number, abs(mode.scheme.real), abs(mode.rod.real)) for mode in modes]
    for number, *ends in pairs:
        if min(ends) > 0:
            axes.plot([number, number], ends, color=GREY, lw=3, alpha=0.5)
    numbers = [pair[0] for pair in pairs]
    if any(pair[1] > 0 for pair in pairs):
        axes.set_yscale("log")
        ours, true = ([pair[i] or math.nan for pair in pairs] for i in (1, 2))
        axes.plot(numbers, ours, "o", color=BLUE, label=f"scheme, N = {scheme.cells}")
        axes.plot(numbers, true, "x", color=VERMILLION, label="rod")
        axes.legend(loc="best", **LEGEND)
        axes.set_xticks(numbers)
    else:
        note(axes, "no oscillating modes to compare")
    return finish_axes(axes, "elastic mode", "|Re λ| [1/s]")


def _with_conjugates(values: list[complex]) -> np.ndarray[tuple[int], np.dtype[np.complex128]]:
    upper = np.array(values, dtype=complex)
    return np.concatenate((upper, upper.conj()))


def plot_rod_popov(scheme: UpwindScheme, result: CriterionResult, *, ax: Axes | None = None) -> Axes:
    """Popov plot of a rod and of its scheme, with the line of the rod's multiplier.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme, and with it the rod.
    result : CriterionResult
        What Popov's criterion says of the rod.  Without a multiplier the line is the one that comes closest.
    ax : Axes, optional
        Where to draw; by default a new figure.
    """
    block = RodPlant(scheme.rod)
    if result.theta is None:
        omega, values = curve(block, None)
        seen = np.isfinite(values)
        theta = searched_theta(values.real[seen], (omega * values.imag)[seen], float(result.sector.upper))
        result = replace(result, theta=theta)
    axes = plot_popov(block, result, ax=ax)
    omega, values = curve(scheme, None)
    axes.plot(values.real, omega * values.imag, color=PURPLE, lw=1.3, ls=(0, (4, 2)), label=_name(scheme))
    return _named(axes)


def plot_rod_nyquist(scheme: UpwindScheme, result: CriterionResult, *, ax: Axes | None = None) -> Axes:
    """Nyquist plot of a rod and of its scheme, with the half-plane that the circle criterion forbids.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme, and with it the rod.
    result : CriterionResult
        What the circle criterion says of the rod.
    ax : Axes, optional
        Where to draw; by default a new figure.
    """
    axes = plot_nyquist(RodPlant(scheme.rod), result.sector, worst=result.worst_frequency, ax=ax)
    _, values = curve(scheme, None)
    axes.plot(values.real, values.imag, color=PURPLE, lw=1.3, ls=(0, (4, 2)), label=_name(scheme))
    return _named(axes)


def _name(scheme: UpwindScheme) -> str:
    return f"scheme, N = {scheme.cells}"


def _named(axes: Axes) -> Axes:
    """The curve of the rod by its name, and the legend anew."""
    next(line for line in axes.get_lines() if line.get_color() == BLUE).set_label("rod, ω > 0")
    axes.legend(loc="best", **LEGEND)
    return axes
