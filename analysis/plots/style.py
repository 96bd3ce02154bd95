"""Figures as files: the same bytes for the same numbers, whatever the user's matplotlib settings."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Collection
from functools import partial
from typing import TYPE_CHECKING, Literal

from lure.analysis.drawing import Draw as Draw
from lure.record import described, quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes as Axes

# Colours and small helpers shared by the figures.

# Okabe and Ito: told apart under every common colour-vision deficiency, and in grey by their lightness
BLUE, VERMILLION, GREEN, PURPLE, GREY = "#0072b2", "#d55e00", "#009e73", "#aa4499", "#7f7f7f"
LEGEND = {"fontsize": "small", "framealpha": 0.85}
Place = Literal["best", "center", "lower left", "lower right", "upper left", "upper right"]
_SUPERSCRIPTS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")


def axes_or_new(ax: Axes | None) -> Axes:
    """``ax`` itself, or the axes of a new pyplot figure (shown by a notebook, never by this module)."""
    if ax is not None:
        return ax
    from matplotlib import pyplot

    return pyplot.subplots()[1]


def ink(ax: Axes) -> str:
    """The colour of the words on some axes: what is drawn in it is seen on whatever stands behind, white or black."""
    return str(ax.xaxis.label.get_color())


def number(value: float, digits: int = 4) -> str:
    """A number for a label, with a power of ten where needed; plain text draws ten times faster than mathtext."""
    if not math.isfinite(value):
        return "∞" if value > 0 else "−∞"
    mantissa, _, exponent = f"{value:.{digits}g}".replace("-", "−").partition("e")
    return f"{mantissa}×{power_of_ten(int(exponent.replace('−', '-')))}" if exponent else mantissa


def power_of_ten(exponent: int) -> str:
    """``10`` with a raised exponent, as plain text."""
    return "10" + str(exponent).translate(_SUPERSCRIPTS)


def finish_axes(ax: Axes, xlabel: str = "", ylabel: str = "", *, legend: Place | None = None) -> Axes:
    """Label axes whose limits are settled, ticks with powers of ten as plain text; a legend where a place is given."""
    from matplotlib.ticker import AutoLocator, FuncFormatter, MaxNLocator, NullLocator

    if xlabel:
        ax.set_xlabel(xlabel)
    if ylabel:
        ax.set_ylabel(ylabel)
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
    if legend is not None:
        ax.legend(loc=legend, **LEGEND)
    return ax


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


# Two axes one above the other in the place of one, whatever lays the figure out.

_GAP = 0.03  # share of the height of the place


def panels(ax: Axes | None, share: float) -> tuple[Axes, Axes]:
    """``ax``, made less high, and new axes below it that share its x-axis.

    In the place of a subplot the two stand in a grid of their own, which constrained and tight layouts know how to
    treat; axes put down by hand are cut in two where they are.

    ``ax``: whose place the two take; None for a new figure.  ``share``: height of the axes below, relative to those
    above.
    """
    above = axes_or_new(ax)
    spec, figure = above.get_subplotspec(), above.figure
    if spec is None:
        box = above.get_position(original=True)
        low = share / (1 + share) * (1 - _GAP) * box.height
        high = box.height - low - _GAP * box.height
        above.set_position((box.x0, box.y1 - high, box.width, high))
        return above, figure.add_axes((box.x0, box.y0, box.width, low), sharex=above)
    grid = spec.subgridspec(2, 1, height_ratios=(1, share), hspace=2 * _GAP)
    above.set_subplotspec(grid[0])
    return above, figure.add_subplot(grid[1], sharex=above)


INK = "#20242a"
_SETTINGS: dict[str, object] = {
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.7,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": 10,
    "figure.dpi": 100,
    "font.size": 9,
    "legend.labelcolor": INK,
    "legend.borderpad": 0.3,
    "legend.edgecolor": "none",
    "legend.handlelength": 1.6,
    "lines.markeredgewidth": 1.0,
    "path.simplify_threshold": 0.4,
    "svg.fonttype": "path",
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
}
_LONG_NUMBER = re.compile(r"-?\d+\.\d{3,}")
_PATH_DATA = re.compile(r' d="[^"]*"')


@described(frozen=True, kw_only=True, slots=True)
class Picture:
    """A figure as an SVG document and a PNG image, both on white; empty what was not asked for."""

    svg: str = quantity("The document", default="")
    png: bytes = quantity("The image", default=b"")

    def file(self, suffix: str) -> bytes:
        """The file whose name ends so, ``.svg`` or ``.png``."""
        return self.svg.encode() if suffix.lower() == ".svg" else self.png


def render(
    draw: Draw, *, name: str, size: tuple[float, float] = (4.4, 3.2), suffixes: Collection[str] = (".svg", ".png")
) -> Picture:
    """Draw on the axes of a fresh figure and return it as SVG and PNG, or as one of them.

    Parameters
    ----------
    draw : callable
        Draws on the axes it is given as ``ax``, e.g. ``partial(plot_spectrum, scheme)``.
    name : str
        Salts the identifiers in the SVG, so that two figures on one page do not share them.
    size : tuple of float
        Width and height [inch].
    suffixes : collection of str
        Which files are wanted.

    Notes
    -----
    Deterministic: matplotlib's own defaults instead of the user's, no date, salted identifiers.  Settings are restored,
    and pyplot is not involved.
    """
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure
    from matplotlib.style import context

    svg, png = io.StringIO(), io.BytesIO()
    with rc_context(), context(["default", {**_SETTINGS, "svg.hashsalt": name}]):
        figure = Figure(figsize=size)
        figure.subplots_adjust(left=0.17, right=0.97, bottom=0.15, top=0.92)
        draw(ax=figure.add_subplot())
        # the canvases directly: savefig would lay everything out once more for each file
        if ".svg" in suffixes:
            FigureCanvasSVG(figure).print_svg(svg, metadata=dict.fromkeys(("Date", "Creator", "Format", "Type")))
        if ".png" in suffixes:
            figure.dpi = 180
            FigureCanvasAgg(figure).print_png(png, metadata={"Software": None})
    return Picture(svg=_shortened(svg.getvalue()), png=png.getvalue())


def _shortened(svg: str) -> str:
    """The SVG with coordinates to a hundredth of a point."""
    return _PATH_DATA.sub(lambda data: _LONG_NUMBER.sub(_two_decimals, data.group()), svg)


def _two_decimals(match: re.Match[str]) -> str:
    return f"{float(match.group()):.2f}".rstrip("0").rstrip(".")
