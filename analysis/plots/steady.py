"""The amplitude of a steady response over frequency, with what is certified of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from lure.analysis.plots.style import BLUE, GREY, LEGEND, VERMILLION, axes_or_new, finish_axes
from lure.analysis.questions.steady import SteadyPoint, SteadyResponse
from lure.analysis.verdict import Evidence
from lure.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_ROOM, _SHADE = 1.6, 0.25


def plot_steady(found: SteadyResponse, *, ax: Axes | None = None) -> Axes:
    """The largest ``|z(t)|`` over a period against the frequency of the input, both axes logarithmic.

    Blue bars: certified at that frequency, whatever the start.  The dashed curve is harmonic balance in floating
    point, and the shade between the bars is interpolated: at other frequencies nothing is certified.  Red and grey
    bars: steady responses that exist, certified, where others may; whether they attract what is near is computed.
    Crosses: computed alone.

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
    shown = [row for row in rows if row.evidence is Evidence.CERTIFIED and math.isfinite(row.amplitude.high)]
    alone = [row for row in shown if row.alone]
    if len(alone) > 1:
        at, below, above = ([getattr(row, name) for row in alone] for name in ("omega", "low", "high"))
        axes.fill_between(at, below, above, color=BLUE, alpha=_SHADE, lw=0, label="between them interpolated")
        label = "harmonic balance, computed"
        axes.plot(at, [row.computed for row in alone], "--", color=GREY, lw=1, label=label)
    _bars(axes, alone, BLUE, "certified, from every start")
    _bars(
        axes,
        [row for row in shown if not row.alone and row.attracts],
        VERMILLION,
        "exists, and attracts what is near (computed)",
    )
    _bars(axes, [row for row in shown if not row.alone and not row.attracts], GREY, "exists, and repels (computed)")
    others = [row for row in rows if row not in shown]
    if others:
        at = [row.omega for row in others]
        axes.plot(at, [row.computed for row in others], "x", color="black", ms=4, label="computed")
    low, high = ([*(getattr(row, end) for row in shown), *(row.computed for row in rows)] for end in ("low", "high"))
    axes.set_ylim(min(value for value in low if value > 0) / _ROOM, max(high) * _ROOM)
    axes.set_xscale("log")
    axes.set_yscale("log")
    unit = "" if found.forcing is None or not found.forcing.unit else f" [{found.forcing.unit}]"
    axes.set_xlabel("ω [rad/s]")
    axes.set_ylabel(f"largest |z| over a period{unit}")
    _ticks(axes)
    finish_axes(axes)
    axes.legend(loc="best", **LEGEND)
    return axes


def _bars(axes: Axes, rows: Sequence[SteadyPoint], color: str, label: str) -> None:
    """What is certified of some solutions."""
    if rows:
        low, high = (np.array([getattr(row, end) for row in rows]) for end in ("low", "high"))
        middle, at = (low + high) / 2, [row.omega for row in rows]
        axes.errorbar(at, middle, [middle - low, high - middle], fmt="_", color=color, ms=7, capsize=3, label=label)


def _ticks(axes: Axes) -> None:
    """Plain numbers on axes of less than two decades."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    for axis, (low, high) in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
        if high < 100 * low:
            axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axis.set_minor_locator(NullLocator())
