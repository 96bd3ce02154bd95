"""Popov and Nyquist plot of a rod with those of its scheme on the same axes."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from analysis.criteria.result import CriterionResult
from analysis.graphical.theta import searched_theta
from analysis.plots.curve import curve
from analysis.plots.nyquist import plot_nyquist
from analysis.plots.popov import plot_popov
from analysis.plots.style import BLUE, LEGEND, PURPLE
from lure.upwind import UpwindScheme
from lure.waves import RodBlock

if TYPE_CHECKING:
    from matplotlib.axes import Axes


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

    Returns
    -------
    Axes
        The axes drawn on.
    """
    block = RodBlock(scheme.rod)
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

    Returns
    -------
    Axes
        The axes drawn on.
    """
    axes = plot_nyquist(RodBlock(scheme.rod), result.sector, worst=result.worst_frequency, ax=ax)
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
