"""One motion by all methods: the end of the rod above, the distance from the exact motion below."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from lure.analysis.plots.style import (
    BLUE,
    GREEN,
    GREY,
    INK,
    LEGEND,
    PURPLE,
    VERMILLION,
    axes_or_new,
    finish_axes,
    note,
    padded,
    panels,
    render,
    scaled_unit,
)
from lure.analysis.rod.plots.run import draw_obstacle, shade
from lure.arrays import Reals as Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lure.analysis.rod.comparison import Comparison, Row
    from lure.analysis.rod.confirmation import Confirmation, Side

# The motion of the rod and that of its scheme, on the same axes.


_LEAST = 1e-9


def plot_both_ends(confirmation: Confirmation, *, ax: Axes | None = None) -> Axes:
    """Contact coordinate ``z`` of the rod and of its scheme, with ``zeta`` of each where it is claimed never to rise.

    Parameters
    ----------
    confirmation : Confirmation
        The two motions; either may be missing.
    ax : Axes, optional
        Where to draw; by default a new figure.
    """
    axes = axes_or_new(ax)
    drawn = []
    largest = max(float(np.abs(side.curves.z).max()) for side, *_ in _sides(confirmation))
    factor, unit = scaled_unit(largest, "m")
    for side, name, colour, deflated in _sides(confirmation):
        curves = side.curves
        dashes = "-" if name == "rod" else (0, (5, 1.5))
        axes.plot(curves.t, factor * curves.z, color=colour, ls=dashes, lw=1.1, label=f"z, {name}")
        drawn.append(factor * curves.z)
        if curves.zeta is not None:
            style = "--" if name == "rod" else ":"
            axes.plot(curves.t, factor * curves.zeta, color=deflated, ls=style, lw=1.5, label=f"ζ, {name}")
            drawn.append(factor * curves.zeta)
    low, high = min(float(values.min()) for values in drawn), max(float(values.max()) for values in drawn)
    if low < 0.0 < high:
        axes.axhline(0.0, color=GREY, lw=0.8)
    bottom, top = padded(low, high, 0.12)
    bottom -= 0.2 * (top - bottom)  # room for the legend
    axes.set_ylim(bottom, top)
    axes.set_yticks(_round_ticks(bottom, top), minor=False)
    axes.set_ylim(bottom, top)
    axes.set_xlim(0.0, _last(confirmation))
    axes.set_xlabel("t [s]")
    axes.set_ylabel(f"z and ζ [{unit}]", labelpad=1)
    axes.tick_params(axis="y", labelsize="small")
    finish_axes(axes)
    axes.legend(loc="lower center", ncols=2, **LEGEND)
    return axes


def plot_both_decays(confirmation: Confirmation, *, ax: Axes | None = None) -> Axes:
    """Energy of the rod and of its scheme, and the Popov-Lyapunov function of each, relative to their start.

    Parameters
    ----------
    confirmation : Confirmation
        The two motions without load; either may be missing.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on, logarithmic where the curves span more than a decade; what is below 1e-9 is cut off.
    """
    axes = axes_or_new(ax)
    shares = []
    for side, name, colour, second in _sides(confirmation):
        for values, label, hue, style in (
            (side.curves.energy, "energy", colour, "-" if name == "rod" else "--"),
            (side.curves.lyapunov, "V", second, "-." if name == "rod" else ":"),
        ):
            if values is not None and values[0] > 0.0:
                share = np.asarray(values / values[0])
                shares.append(share)
                axes.plot(side.curves.t, share, color=hue, ls=style, lw=1.3, label=f"{label}, {name}")
    if shares:
        low, high = min(float(share.min()) for share in shares), max(float(share.max()) for share in shares)
        if low < 0.1 * high:
            axes.set_yscale("log")
            axes.set_ylim(max(0.5 * low, _LEAST * high), 2.0 * high)
        else:
            axes.set_ylim(*padded(min(low, 0.0), high, 0.1))
        axes.legend(loc="best", ncols=2, **LEGEND)
    else:
        axes.text(0.5, 0.5, "no energy: the rod stays at rest", transform=axes.transAxes, ha="center", color=GREY)
    axes.set_xlim(0.0, _last(confirmation))
    return finish_axes(axes, "t [s]", "share of the first value")


def _sides(confirmation: Confirmation) -> list[tuple[Side, str, str, str]]:
    pairs = ((confirmation.rod, "rod", BLUE, GREEN), (confirmation.scheme, "scheme", VERMILLION, PURPLE))
    return [(side, name, colour, second) for side, name, colour, second in pairs if side is not None]


def _round_ticks(bottom: float, top: float) -> Array:
    """Ticks whose last digits are not those of a rounding error."""
    from matplotlib.ticker import MaxNLocator

    ticks = np.asarray(MaxNLocator(6, steps=[1, 2, 2.5, 5, 10]).tick_values(bottom, top), dtype=float)
    ticks = ticks[(ticks >= bottom) & (ticks <= top)]
    return np.array([float(f"{tick:.12g}") for tick in ticks]) if len(ticks) else ticks


def _last(confirmation: Confirmation) -> float:
    return max(float(side.curves.t[-1]) for side, *_ in _sides(confirmation))


FileKind = Literal["svg", "png", "pdf"]

SIZE = (7.0, 5.4)
_COARSE_TO_FINE = ("#7fc4ec", BLUE, "#00335c")  # told apart by lightness
_SPACES = {"Galerkin P1": GREEN, "Galerkin P2": PURPLE, "Galerkin cosine": "#c28500"}
_DASHES = ("--", "-.", ":")
_BINS = (24, 120)
_COLUMNS = 4
_FLOOR = 1e-16
_PLACES = {"left": 0.1, "right": 0.975, "bottom": 0.1}
_TOP, _LINE = 0.93, 0.034  # of the figure: without a legend, and for each line of it


def plot_comparison(found: Comparison, *, ax: Axes | None = None) -> tuple[Axes, Axes]:
    """Displacement ``u(t, L)`` by every method, contacts of the rod shaded, and below it the errors on a log axis.

    Parameters
    ----------
    found : Comparison
        The comparison.
    ax : Axes, optional
        Where to draw; by default a new figure.  The place is shared out between it and new axes below it.

    Returns
    -------
    tuple of Axes
        Above and below.
    """
    above, below = panels(ax, 0.85)
    plot_comparison_end(found, ax=above)
    plot_comparison_error(found, ax=below)
    above.set_xlabel("")
    above.tick_params(labelbottom=False)
    above.xaxis.get_offset_text().set_visible(False)
    handles, labels = above.get_legend_handles_labels()
    above.legend(
        handles, labels, loc="lower right", bbox_to_anchor=(1.0, 1.03), ncols=_COLUMNS, **{**LEGEND, "framealpha": 0.0}
    )
    return above, below


def plot_comparison_end(found: Comparison, *, ax: Axes | None = None) -> Axes:
    """Displacement ``u(t, L)`` [m] by every method over the exact one, with the contacts of the rod shaded.

    Parameters
    ----------
    found : Comparison
        The comparison.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.  An obstacle too far away for the scale of the motion is named, not drawn.
    """
    axes = axes_or_new(ax)
    exact, gap = found.exact, found.rod.gap
    axes.plot(found.t, exact.u, color=INK, lw=2.6, alpha=0.45, label="exact")
    for row, style in _styled(found.rows):
        assert row.u is not None, "rows that were not run have no style"
        axes.plot(found.t, row.u, lw=1.1, label=row.label, **style)
    shade(axes, found.contacts, "contact of the rod")
    curves = [exact.u, *(row.u for row in found.rows if row.u is not None)]
    low, high = min(float(u.min()) for u in curves), max(float(u.max()) for u in curves)
    draw_obstacle(axes, gap, (low, high), corner="lower right", lw=1.0, ls=(0, (1, 2)))
    axes.set_xlim(float(found.t[0]), float(found.t[-1]))
    return finish_axes(axes, "t [s]", "u(t, L) [m]")


def plot_comparison_error(found: Comparison, *, ax: Axes | None = None) -> Axes:
    """Error of ``u(t, L)`` against the exact motion as a share of its amplitude, on a logarithmic axis.

    Drawn is the largest error in each of up to 120 equal stretches of time: the error itself passes through zero all
    the time.

    Parameters
    ----------
    found : Comparison
        The comparison.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on, in metres for a rod that stays at rest.
    """
    axes = axes_or_new(ax)
    exact = found.exact
    unit = exact.amplitude or 1.0
    edges = _edges(found)
    tops = []
    for row, style in _styled(found.rows):
        assert row.u is not None, "rows that were not run have no style"
        error = np.maximum(np.maximum.reduceat(np.abs(row.u - exact.u), edges[:-1]) / unit, _FLOOR)
        if float(error.max()) > _FLOOR:
            steps = np.append(error, error[-1])
            axes.plot(found.t[np.minimum(edges, found.t.size - 1)], steps, drawstyle="steps-post", lw=1.1, **style)
            tops.append((float(np.median(error)), float(error.max())))
    shade(axes, found.contacts, "")
    if tops:
        axes.set_yscale("log")
        low, high = 0.1 * min(usual for usual, _ in tops), 2.0 * max(top for _, top in tops)
        axes.set_ylim(min(low, 0.01 * high), high)
    if exact.event is not None:
        axes.axvline(exact.event.t, color=GREY, lw=0.9, ls=":")
        note(axes, f"dotted: first {exact.event.kind} of the exact motion", corner="lower right")
    axes.set_xlim(float(found.t[0]), float(found.t[-1]))
    return finish_axes(axes, "t [s]", "largest error [m]" if not exact.amplitude else "largest error / amplitude")


def comparison_file(found: Comparison, kind: FileKind) -> bytes:
    """The figure of :func:`plot_comparison` as a file."""
    draw = partial(_framed, found)
    if kind != "pdf":
        return render(draw, name="comparison", size=SIZE, suffixes=[f".{kind}"]).file(f".{kind}")
    from matplotlib import rc_context
    from matplotlib.backends.backend_pdf import FigureCanvasPdf
    from matplotlib.figure import Figure
    from matplotlib.style import context

    document = io.BytesIO()
    with rc_context(), context(["default", {"font.size": 9, "axes.linewidth": 0.7, "legend.edgecolor": "none"}]):
        figure = Figure(figsize=SIZE)
        draw(ax=figure.add_subplot())
        FigureCanvasPdf(figure).print_pdf(document, metadata={"CreationDate": None})
    return document.getvalue()


def _framed(found: Comparison, *, ax: Axes) -> None:
    figure = ax.get_figure(root=True)
    if figure is not None:
        lines = math.ceil((len(_styled(found.rows)) + 3) / _COLUMNS)
        figure.subplots_adjust(top=_TOP - _LINE * lines, **_PLACES)
    for axes in plot_comparison(found, ax=ax):
        axes.spines[["top", "right"]].set_visible(False)


def _styled(rows: Sequence[Row]) -> list[tuple[Row, dict[str, Any]]]:
    """The rows that were run, each with a colour and dashes of its own as far as they go."""
    run = [row for row in rows if row.u is not None]
    sizes = [row.size for row in run if row.family == "scheme"]
    styled: list[tuple[Row, dict[str, Any]]] = []
    for row in run:
        if row.family == "scheme":
            last = len(_COARSE_TO_FINE) - 1
            place = sizes.index(row.size)
            shade = round(last * place / (len(sizes) - 1)) if len(sizes) > 1 else 1
            dashes: Any = "-" if len(sizes) <= last + 1 or place % 2 == 0 else (0, (6, 1))
            styled.append((row, {"color": _COARSE_TO_FINE[shade], "ls": dashes}))
        else:
            among = [other.size for other in run if other.family == row.family]
            dashes = _DASHES[among.index(row.size) % len(_DASHES)]
            styled.append((row, {"color": _SPACES[row.family], "ls": dashes}))
    return styled


def _edges(found: Comparison) -> NDArray[np.intp]:
    """Indices at which stretches of about half a transit begin, and the number of samples."""
    count = int(np.clip(round(2.0 * found.until / found.rod.travel_time), *_BINS))
    return np.unique(np.linspace(0, found.t.size, min(count, found.t.size // 2) + 1).astype(np.intp))
