"""Colours and small helpers shared by the figures."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes as Axes

# Okabe and Ito: told apart under every common colour-vision deficiency, and in grey by their lightness
BLUE, VERMILLION, GREEN, PURPLE, GREY = "#0072b2", "#d55e00", "#009e73", "#aa4499", "#7f7f7f"
LEGEND = {"fontsize": "small", "framealpha": 0.85}
_SUPERSCRIPTS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")


def axes_or_new(ax: Axes | None) -> Axes:
    """``ax`` itself, or the axes of a new pyplot figure (shown by a notebook, never by this module)."""
    if ax is not None:
        return ax
    from matplotlib import pyplot

    return pyplot.subplots()[1]


def number(value: float, digits: int = 4) -> str:
    """A number for a label, with a power of ten where needed; plain text draws ten times faster than mathtext."""
    if not math.isfinite(value):
        return "∞" if value > 0 else "−∞"
    mantissa, _, exponent = f"{value:.{digits}g}".replace("-", "−").partition("e")
    return f"{mantissa}×{power_of_ten(int(exponent.replace('−', '-')))}" if exponent else mantissa


def power_of_ten(exponent: int) -> str:
    """``10`` with a raised exponent, as plain text."""
    return "10" + str(exponent).translate(_SUPERSCRIPTS)


def finish_axes(ax: Axes) -> None:
    """Label the ticks of axes whose limits are settled, with powers of ten as plain text."""
    from matplotlib.ticker import AutoLocator, FuncFormatter, MaxNLocator, NullLocator

    for axis, limits in ((ax.xaxis, ax.get_xlim()), (ax.yaxis, ax.get_ylim())):
        if axis.get_scale() == "log":
            if limits[1] < 100.0 * limits[0]:
                continue
            axis.set_major_formatter(
                FuncFormatter(lambda value, _: power_of_ten(round(math.log10(value))) if value > 0 else "")
            )
            axis.set_minor_locator(NullLocator())
            continue
        if isinstance(axis.get_major_locator(), AutoLocator):
            axis.set_major_locator(MaxNLocator(6, steps=[1, 2, 2.5, 5, 10]))
        reference = _reference(*limits)
        largest = max(abs(limit - reference) for limit in limits)
        exponent = math.floor(math.log10(largest) + 1e-9) if largest else 0
        if -3 < exponent < 4 and not reference:
            continue
        formatter = FuncFormatter(partial(_in_units, 10.0**exponent, reference))
        base = f" {'+' if reference > 0 else '−'} {number(abs(reference), 10)}" if reference else ""
        formatter.set_offset_string(f"×{power_of_ten(exponent)}{base}")
        axis.set_major_formatter(formatter)


def _reference(low: float, high: float) -> float:
    """A round number to count from where an axis shows a small range far from zero; zero elsewhere."""
    span = abs(high - low)
    if not 0.0 < span < 0.002 * max(abs(low), abs(high)):
        return 0.0
    digits = -math.ceil(math.log10(span))
    return round(0.5 * (low + high), digits)


def _in_units(unit: float, reference: float, value: float, _: object) -> str:
    return f"{round((value - reference) / unit, 9) + 0.0:.4g}".replace("-", "−")  # + 0.0: no minus before a zero


def scaled_unit(largest: float, unit: str) -> tuple[float, str]:
    """The factor and the name of the unit in which quantities up to this size are drawn: a thousandth below 0.1."""
    return (1e3, f"m{unit}") if 0.0 < largest < 0.1 else (1.0, unit)


def room_below(bottom: float, top: float, entries: int) -> float:
    """A lower limit that leaves a strip for a legend with so many entries, where nothing is drawn."""
    return bottom - (0.05 + 0.075 * entries) * (top - bottom)


def padded(low: float, high: float, share: float = 0.06) -> tuple[float, float]:
    """An interval with a margin on both sides; a single point gets a margin of its own size."""
    room = share * (high - low) or share * abs(high) or 1.0
    return low - room, high + room


def note(ax: Axes, text: str, *, corner: str = "lower left") -> None:
    """A remark in a corner of the axes."""
    vertical, horizontal = corner.split()
    ax.text(
        {"left": 0.02, "right": 0.98}[horizontal],
        {"lower": 0.03, "upper": 0.97}[vertical],
        text,
        transform=ax.transAxes,
        ha="left" if horizontal == "left" else "right",
        va="bottom" if vertical == "lower" else "top",
        fontsize="small",
        bbox={"facecolor": ax.get_facecolor(), "alpha": 0.85, "edgecolor": "none", "pad": 1.5},
        zorder=5,
    )
