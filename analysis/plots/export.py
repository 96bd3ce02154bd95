"""Figures as files: the same bytes for the same numbers, whatever the user's matplotlib settings."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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


class Draw(Protocol):
    """A plot function with its results bound, e.g. ``partial(plot_spectrum, scheme)``."""

    def __call__(self, *, ax: Axes) -> object:
        """Draw on ``ax``."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Picture:
    """A figure as an SVG document and a PNG image, both on white.

    Attributes
    ----------
    svg : str
        The document.
    png : bytes
        The image.
    """

    svg: str
    png: bytes


def render(draw: Draw, *, name: str, size: tuple[float, float] = (4.4, 3.2)) -> Picture:
    """Draw on the axes of a fresh figure and return it as SVG and PNG.

    Parameters
    ----------
    draw : callable
        Draws on the axes it is given as ``ax``, e.g. ``partial(plot_spectrum, scheme)``.
    name : str
        Salts the identifiers in the SVG, so that two figures on one page do not share them.
    size : tuple of float
        Width and height [inch].

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
        FigureCanvasSVG(figure).print_svg(svg, metadata=dict.fromkeys(("Date", "Creator", "Format", "Type")))
        figure.dpi = 180
        FigureCanvasAgg(figure).print_png(png, metadata={"Software": None})
    return Picture(svg=_shortened(svg.getvalue()), png=png.getvalue())


def _shortened(svg: str) -> str:
    """The SVG with coordinates to a hundredth of a point."""
    return _PATH_DATA.sub(lambda data: _LONG_NUMBER.sub(_two_decimals, data.group()), svg)


def _two_decimals(match: re.Match[str]) -> str:
    return f"{float(match.group()):.2f}".rstrip("0").rstrip(".")
