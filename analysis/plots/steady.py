"""The amplitude of a steady response over frequency, with what is certified of it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from lure.analysis.plots.style import BLUE, GREY, LEGEND, VERMILLION, axes_or_new, finish_axes
from lure.analysis.questions.steady import SteadyResponse
from lure.analysis.verdict import Evidence
from lure.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_ROOM, _SHADE = 1.6, 0.25


def plot_steady(found: SteadyResponse, *, ax: Axes | None = None) -> Axes:
    """The largest ``|z(t)|`` over a period against the frequency of the input, both axes logarithmic.

    Blue bars: certified at that frequency.  The dashed curve is harmonic balance in floating point, and the shade
    between the bars is interpolated: at other frequencies nothing is certified.  Red crosses: computed alone.

    Parameters
    ----------
    found : SteadyResponse
        The answer, with an input.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.

    Raises
    ------
    InputError
        There is no response to draw.
    """
    rows = [row for row in found.response if row.omega and row.computed > 0]
    if not rows:
        raise InputError("the steady response has no amplitude at a frequency to draw; give forcing.amplitude")
    axes = axes_or_new(ax)
    omega, computed = np.array([row.omega for row in rows]), np.array([row.computed for row in rows])
    shown = [row for row in rows if row.evidence is Evidence.CERTIFIED and math.isfinite(row.amplitude.high)]
    at = np.array([row.omega for row in shown])
    low, high = (np.array([getattr(row.amplitude, end) for row in shown]) for end in ("low", "high"))
    if len(shown) > 1:
        label = "between them interpolated"
        axes.fill_between(at, np.maximum(low, computed.min() / 10), high, color=BLUE, alpha=_SHADE, lw=0, label=label)
    if len(rows) > 1:
        axes.plot(omega, computed, "--", color=GREY, lw=1, label="harmonic balance, computed")
    if shown:
        middle = (low + high) / 2
        axes.errorbar(
            at,
            middle,
            [middle - low, high - middle],
            fmt="_",
            color=BLUE,
            ms=7,
            capsize=3,
            label="certified, every start",
        )
    others = [row for row in rows if row not in shown]
    if others:
        axes.plot(
            [row.omega for row in others], [row.computed for row in others], "x", color=VERMILLION, label="computed"
        )
    axes.set_xscale("log")
    axes.set_yscale("log")
    top = max(float(computed.max()), float(high.max(initial=0.0)))
    axes.set_ylim(float(min(computed.min(), low[low > 0].min(initial=math.inf))) / _ROOM, top * _ROOM)
    unit = "" if found.forcing is None or not found.forcing.unit else f" [{found.forcing.unit}]"
    axes.set_xlabel("ω [rad/s]")
    axes.set_ylabel(f"largest |z| over a period{unit}")
    finish_axes(axes)
    axes.legend(loc="best", **LEGEND)
    return axes
