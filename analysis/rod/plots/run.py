"""One motion: where the end is, what the obstacle and the dashpot feel, and the energy."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from lure.analysis.plots.style import (
    BLUE,
    GREEN,
    LEGEND,
    PURPLE,
    VERMILLION,
    axes_or_new,
    finish_axes,
    note,
    number,
    padded,
    scaled_unit,
)
from lure.arrays import Reals as Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.gridspec import SubplotSpec

    from lure.analysis.rod.runs import SampledRun
    from lure.analysis.rod.runs.drawing import Film

# The obstacle in a plot of the end of the rod: a line, or a remark where it is too far away for the motion.

_FAR = 6.0


def draw_obstacle(
    axes: Axes,
    gap: float,
    span: tuple[float, float],
    *,
    corner: str = "upper left",
    **line: Any,  # noqa: ANN401  (what matplotlib takes)
) -> bool:
    """Draw it at ``u = gap`` [m] and fit the axis to it and the motion; False if it is only named.

    ``span``: least and largest displacement [m]; ``corner``: for the remark; ``line``: of the line, as for ``axhline``.
    """
    low, high = span
    near = gap - high <= _FAR * (high - low)
    if near:
        axes.axhline(gap, color=VERMILLION, label=f"obstacle at {number(gap)} m", **line)
        axes.set_ylim(*padded(min(low, gap), max(high, gap), 0.1))
    else:
        axes.set_ylim(*padded(low, high, 0.15))
        note(axes, f"obstacle at {number(gap)} m, outside this view", corner=corner)
    return near


def shade(axes: Axes, spans: Sequence[tuple[float, float]], label: str, *, height: float = 1.0) -> None:
    """Shade stretches of time in contact.

    ``axes``: time is the horizontal axis; ``spans``: first and last instant of each; ``label``: for the legend;
    ``height``: up to which share of the axes.
    """
    if spans:
        bars = [(start, end - start) for start, end in spans]
        shown = axes.broken_barh(bars, (0.0, height), transform=axes.get_xaxis_transform(), color=VERMILLION)
        shown.set(alpha=0.25, linewidth=0.5, zorder=0.5, label=label)


def draw_end(axes: Axes, t: Array, u: Array, gap: float) -> bool:
    """Draw ``u(t, L)`` and the obstacle; False if that is only named, as for :func:`draw_obstacle`.

    ``t``, ``u``: (n,) instants [s] and displacements there [m]; ``gap``: where the obstacle is [m].
    """
    axes.plot(*envelope(t, u), color=BLUE, lw=1.1, label="end u(t, L)")
    axes.set_xlim(float(t[0]), float(t[-1]))
    return draw_obstacle(axes, gap, (float(u.min()), float(u.max())), lw=1.1, ls="--")


# The whole rod in one picture: place against time, colour by velocity or stress; waves run along the diagonals.

Which = Literal["velocity", "stress"]
COLOURS: dict[Which, str] = {"velocity": "RdBu_r", "stress": "PuOr"}  # compression is orange
LABELS: dict[Which, str] = {"velocity": "velocity [m/s]", "stress": "stress E ∂u/∂x [Pa]"}


def plot_space_time(film: Film, which: Which, *, ax: Axes | None = None) -> Axes:
    """Velocity or stress along the rod against time, with the contacts at ``x = L`` marked.

    Parameters
    ----------
    film : Film
        A stretch of a motion.
    which : {"velocity", "stress"}
        What the colour means [m/s], [Pa]; tension is positive.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on, with a colour bar beside them.  A wave moves by ``L`` in one transit ``T``.
    """
    axes = axes_or_new(ax)
    values = film.along.v if which == "velocity" else film.run.rod.youngs_modulus * film.along.w
    top = colour_top(values)
    factor, unit = scaled_unit(float(film.t[-1]), "s")
    mesh = axes.pcolormesh(
        film.along.x,
        factor * film.t,
        values,
        cmap=COLOURS[which],
        vmin=-top,
        vmax=top,
        shading="gouraud",  # a front that runs between the points of the grid leaves no steps
        rasterized=True,
    )
    cut_off = "both" if top < float(np.abs(values).max()) else "neither"
    bar = axes.figure.colorbar(mesh, ax=axes, location="top", pad=0.03, fraction=0.06, aspect=30, extend=cut_off)
    bar.set_label(LABELS[which], loc="left")
    finish_axes(bar.ax)
    L, first, last = film.run.rod.length, float(film.t[0]), float(film.t[-1])
    for impact in film.run.impacts:
        if impact.end >= first and impact.start <= last:
            times = [factor * max(impact.start, first), factor * min(impact.end, last)]
            axes.plot([1.02 * L, 1.02 * L], times, color=VERMILLION, lw=4, solid_capstyle="butt", clip_on=False)
    axes.set_xlim(0.0, L)
    axes.set_ylim(factor * first, factor * last)
    return finish_axes(axes, "x [m]", f"t [{unit}]")


def space_time_page(film: Film, *, title: str, ax: Axes | None = None) -> list[Axes]:
    """Velocity and stress side by side, under a heading that says what moved.

    ``ax``: whose place the two take, by default a new figure.

    Returns
    -------
    list of Axes
        From left to right.
    """
    figure, spec = _cleared(ax, left=0.11, right=0.95, bottom=0.08, top=0.875)
    grid = spec.subgridspec(1, 2, wspace=0.14)
    drawn = [plot_space_time(film, which, ax=figure.add_subplot(grid[i])) for i, which in enumerate(LABELS)]
    drawn[1].set_ylabel("")
    drawn[1].tick_params(labelleft=False)
    drawn[1].yaxis.get_offset_text().set_visible(False)
    if any(impact.end >= film.t[0] and impact.start <= film.t[-1] for impact in film.run.impacts):
        drawn[1].text(1.0, -0.075, "▌contact", color=VERMILLION, transform=drawn[1].transAxes, ha="right", fontsize=8)
    first, last = float(film.t[0]), float(film.t[-1])
    whole = last - first >= film.run.until * (1.0 - 1e-9)
    part = "" if whole else f"; drawn: t = {number(first)} to {number(last)} s of {number(film.run.until)} s"
    head(figure, title, film.run, part)
    return drawn


def _cleared(ax: Axes | None, **margins: float) -> tuple[Figure, SubplotSpec]:
    """The figure of some axes with other margins, and the place of the axes in it, which are removed."""
    place = axes_or_new(ax)
    figure, spec = place.get_figure(root=True), place.get_subplotspec()
    assert figure is not None, "axes belong to a figure"
    assert spec is not None, "a page is drawn in the place of a subplot"
    figure.subplots_adjust(**margins)
    place.remove()
    return figure, spec


def colour_top(values: NDArray[np.float64]) -> float:
    """End of a symmetric colour scale: somewhat above the largest size, unless that is far above nearly all others.

    ``values``: what is coloured.
    """
    sizes = np.abs(values)
    largest, usual = float(sizes.max()), float(np.quantile(sizes, 0.99))
    return 1.3 * (usual if 0.0 < 4.0 * usual < largest else largest) or 1.0


_STRETCHES = 800
_LETTERS, _LINES = 12.5, 2  # of a heading, per inch and at most


def plot_run_end(run: SampledRun, *, ax: Axes | None = None) -> Axes:
    """Displacement ``u(t, L)`` of the contacting end, the obstacle, and contacts shaded.

    Parameters
    ----------
    run : SampledRun
        A motion.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.  An obstacle too far away for the scale of the motion is named, not drawn.
    """
    axes = axes_or_new(ax)
    seen = shade_contacts(run, axes)
    drawn = draw_end(axes, run.t, run.u_end, run.rod.gap)
    _finish(run, axes, "u(t, L) [m]")
    if seen or drawn:
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.0, **LEGEND)
    return axes


def plot_run_stress(run: SampledRun, *, ax: Axes | None = None) -> Axes:
    """Contact stress ``p``, positive in compression.

    Parameters
    ----------
    run : SampledRun
        A motion.
    ax : Axes, optional
        Where to draw; by default a new figure.
    """
    axes = axes_or_new(ax)
    axes.plot(*envelope(run.t, run.stress), color=VERMILLION, lw=1.1)
    top = float(run.stress.max())
    axes.set_ylim(*(padded(0.0, top) if top > 0.0 else (-0.05, 1.0)))
    if top == 0.0:
        axes.set_yticks([0.0])
        note(axes, "no contact" if not shade_contacts(run, axes) else "no contact at the samples", corner="upper left")
    _finish(run, axes, "contact stress\np [Pa]")
    return axes


def plot_run_dashpot(run: SampledRun, *, ax: Axes | None = None) -> Axes:
    """Force ``k u_t(t, 0)`` in the dashpot.

    Parameters
    ----------
    run : SampledRun
        A motion.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on, with a remark where the method does not give the force or there is no dashpot.
    """
    axes = axes_or_new(ax)
    if run.dashpot_force is not None:
        axes.plot(*envelope(run.t, run.dashpot_force), color=PURPLE, lw=1.1)
    else:
        note(axes, "no dashpot: the end is clamped" if run.subject == "rod" else "not given by this method")
    _finish(run, axes, "dashpot force\nk ∂u/∂t(t, 0) [N]")
    return axes


def plot_run_energy(run: SampledRun, *, ax: Axes | None = None) -> Axes:
    """Energy of the object that moves.

    Parameters
    ----------
    run : SampledRun
        A motion.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on, from zero; with a remark where the method does not give the energy.
    """
    axes = axes_or_new(ax)
    if run.energy is not None:
        axes.plot(*envelope(run.t, run.energy), color=GREEN, lw=1.3)
        top = float(run.energy.max())
        axes.set_ylim(0.0, 1.08 * top if top > 0.0 else 1.0)
    else:
        note(axes, "not given by this method")
    _finish(run, axes, "energy [J]")
    return axes


def run_page(run: SampledRun, *, title: str, energies: SampledRun | None = None, ax: Axes | None = None) -> list[Axes]:
    """The four of them above each other, over the same time, under a heading that says what moved.

    ``energies``: the same motion, sampled for its energy; ``ax``: whose place the four take, by default a new figure.

    Returns
    -------
    list of Axes
        From top to bottom.
    """
    figure, spec = _cleared(ax, left=0.15, right=0.97, bottom=0.07, top=0.885)
    grid = spec.subgridspec(4, 1, height_ratios=(1.7, 1, 1, 1), hspace=0.32)
    panels: tuple[tuple[Callable[..., Axes], SampledRun], ...] = (
        (plot_run_end, run),
        (plot_run_stress, run),
        (plot_run_dashpot, run),
        (plot_run_energy, energies or run),
    )
    drawn = []
    for i, (draw, shown) in enumerate(panels):
        axes = draw(shown, ax=figure.add_subplot(grid[i]))
        if i:
            shade_contacts(run, axes)
        if i < len(panels) - 1:
            axes.set_xlabel("")
            axes.tick_params(labelbottom=False)
            axes.xaxis.get_offset_text().set_visible(False)
        drawn.append(axes)
    head(figure, title, run)
    figure.align_ylabels(drawn)
    return drawn


def head(figure: Figure, title: str, run: SampledRun, part: str = "") -> None:
    """A heading: the system in at most two lines; what moved, and on which evidence.

    ``title``: the first line; ``part``: which part of the motion is drawn, in words, empty for all of it.
    """
    place, height = figure.text, figure.get_figheight()
    lines = textwrap.wrap(title, int(_LETTERS * figure.get_figwidth()))
    if len(lines) > _LINES:
        lines = [*lines[: _LINES - 1], lines[_LINES - 1][:-1] + "…"]
    place(0.02, 1.0 - 0.08 / height, "\n".join(lines), fontsize=9.5, fontweight="bold", va="top", linespacing=1.25)
    below = 0.08 + 0.17 * len(lines) + 0.04
    place(0.02, 1.0 - below / height, f"Motion of {run.about} ({run.evidence}){part}", fontsize="small", va="top")


def shade_contacts(run: SampledRun, axes: Axes) -> int:
    """Shade the contacts that fall in the time drawn; ``axes``: where time is the horizontal axis.

    Returns
    -------
    int
        How many there are.
    """
    first, last = float(run.t[0]), float(run.t[-1])
    spans = [
        (max(impact.start, first), min(impact.end, last))
        for impact in run.impacts
        if impact.end >= first and impact.start <= last
    ]
    shade(axes, spans, f"contact ({len(spans)})")
    return len(spans)


def envelope(t: Array, values: Array) -> tuple[Array, Array]:
    """The least and the largest value of each of 800 stretches, where there are more than 4000 points.

    ``t``, ``values``: (n,) a curve.
    """
    if len(t) <= 5 * _STRETCHES:
        return t, values
    edges = np.linspace(0, len(t), _STRETCHES + 1).astype(int)[:-1]
    size = np.diff(np.append(edges, len(t)))
    low, high = np.minimum.reduceat(values, edges), np.maximum.reduceat(values, edges)
    is_low, is_high = values == np.repeat(low, size), values == np.repeat(high, size)
    stretch = np.repeat(np.arange(_STRETCHES), size)
    picks = [np.flatnonzero(mask)[np.unique(stretch[mask], return_index=True)[1]] for mask in (is_low, is_high)]
    index = np.unique(np.concatenate([*picks, [0, len(t) - 1]]))
    return t[index], values[index]


def _finish(run: SampledRun, axes: Axes, label: str) -> None:
    axes.set_xlim(float(run.t[0]), float(run.t[-1]))
    finish_axes(axes, "t [s]", label)
