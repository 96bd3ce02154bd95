"""The whole rod in one picture: place against time, colour by velocity or stress; waves run along the diagonals."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from analysis.plots.run import head
from analysis.plots.style import VERMILLION, axes_or_new, finish_axes, number, scaled_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from analysis.runs.film import Film

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
    bar = axes.figure.colorbar(
        mesh, ax=axes, location="top", pad=0.03, fraction=0.06, aspect=30, extend=_cut_off(values, top)
    )
    bar.set_label(LABELS[which], loc="left")
    finish_axes(bar.ax)
    L, first, last = film.run.rod.length, float(film.t[0]), float(film.t[-1])
    for impact in film.run.impacts:
        if impact.end >= first and impact.start <= last:
            times = [factor * max(impact.start, first), factor * min(impact.end, last)]
            axes.plot([1.02 * L, 1.02 * L], times, color=VERMILLION, lw=4, solid_capstyle="butt", clip_on=False)
    axes.set_xlim(0.0, L)
    axes.set_ylim(factor * first, factor * last)
    axes.set_xlabel("x [m]")
    axes.set_ylabel(f"t [{unit}]")
    finish_axes(axes)
    return axes


def space_time_page(film: Film, *, title: str, ax: Axes | None = None) -> list[Axes]:
    """Velocity and stress side by side, under a heading that says what moved.

    Parameters
    ----------
    film : Film
        A stretch of a motion.
    title : str
        The heading.
    ax : Axes, optional
        Whose place the two take; by default a new figure.

    Returns
    -------
    list of Axes
        From left to right.
    """
    place = axes_or_new(ax)
    figure, spec = place.get_figure(root=True), place.get_subplotspec()
    assert figure is not None, "axes belong to a figure"
    assert spec is not None, "a page is drawn in the place of a subplot"
    figure.subplots_adjust(left=0.11, right=0.95, bottom=0.08, top=0.875)
    place.remove()
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


def colour_top(values: NDArray[np.float64]) -> float:
    """End of a symmetric colour scale: somewhat above the largest size, unless that is far above nearly all others.

    Parameters
    ----------
    values : ndarray
        What is coloured.
    """
    sizes = np.abs(values)
    largest, usual = float(sizes.max()), float(np.quantile(sizes, 0.99))
    return 1.3 * (usual if 0.0 < 4.0 * usual < largest else largest) or 1.0


def _cut_off(values: NDArray[np.float64], top: float) -> str:
    return "both" if top < float(np.abs(values).max()) else "neither"
