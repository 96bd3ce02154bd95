"""Motions of any object on one figure: the rod itself, its scheme, a Galerkin space, a cellular network."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from analysis.plots.obstacle import draw_obstacle
from analysis.plots.run import envelope
from analysis.plots.style import BLUE, GREEN, GREY, LEGEND, VERMILLION, axes_or_new, finish_axes, number
from lure.cellular.motion import CellularMotion
from lure.galerkin import Convergence, GalerkinRun
from lure.motion import Motion
from lure.structured import StructuredMotion

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
Contacts = tuple[tuple[float, float], ...]
_SAMPLES = 2001
_LINES = 12
_TICKS = 6


def plot_motion(motion: Motion | GalerkinRun | StructuredMotion | CellularMotion, *, ax: Axes | None = None) -> Axes:
    """A motion as it is natural to see it, under a title that says what moved and on which evidence.

    Parameters
    ----------
    motion : Motion, GalerkinRun, StructuredMotion or CellularMotion
        Of a rod: the end ``u(t, L)``, the obstacle, and contacts shaded.  Of cells: the output of each against time,
        from 13 cells on as a picture; cells in the plane are taken row by row.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from lure import builtin_system, exact_motion
    >>> system = builtin_system("paper-rod")
    >>> motion = exact_motion(system.rod, system.scenario, 1e-3)
    >>> plot_motion(motion, ax=Figure().subplots()).get_title(loc="left")
    'the rod itself (computed)'
    """
    axes = axes_or_new(ax)
    if isinstance(motion, CellularMotion):
        return _cells(axes, motion)
    return _end(axes, motion)


def _end(axes: Axes, motion: Motion | GalerkinRun | StructuredMotion) -> Axes:
    t, u, gap, contacts, title = _seen(motion)
    for i, (start, end) in enumerate(contacts):
        label = f"contact ({len(contacts)})" if i == 0 else None
        axes.axvspan(start, end, color=VERMILLION, alpha=0.25, lw=0, label=label)
    axes.plot(*envelope(t, u), color=BLUE, lw=1.1, label="end u(t, L)")
    draw_obstacle(axes, gap, (float(u.min()), float(u.max())), lw=1.1, ls="--")
    axes.set_xlim(float(t[0]), float(t[-1]))
    axes.set_xlabel("t [s]")
    axes.set_ylabel("u(t, L) [m]")
    axes.legend(loc="best", **LEGEND)
    axes.set_title(title, fontsize="medium", loc="left", y=1.04)
    finish_axes(axes)
    return axes


def _seen(motion: Motion | GalerkinRun | StructuredMotion) -> tuple[Array, Array, float, Contacts, str]:
    """Instants, the end, the gap, the contacts, and what moved."""
    if isinstance(motion, Motion):
        t = np.linspace(motion.since, motion.until, _SAMPLES)
        contacts = tuple((hit.start, hit.end) for hit in motion.impacts)
        return t, motion.end_displacement(t), motion.rod.gap, contacts, "the rod itself (computed)"
    if isinstance(motion, GalerkinRun):
        space = motion.model.space
        title = f"Galerkin space {space.name}, m = {space.order}, not the rod (observed)"
        spans = tuple((touch.start, touch.end) for touch in motion.contacts)
        return motion.t, motion.u_end, motion.model.rod.gap, spans, title
    gap = motion.scheme.rod.gap
    title = f"upwind scheme, N = {motion.scheme.cells}, not the rod (observed)"
    return motion.t, motion.z + gap, gap, motion.contacts, title


def _cells(axes: Axes, motion: CellularMotion) -> Axes:
    outputs = motion.output.reshape(motion.t.size, -1)
    count = outputs.shape[1]
    if count <= _LINES:
        shades = np.linspace(0.25, 1.0, count)
        for i in range(count):
            axes.plot(motion.t, outputs[:, i], color=BLUE, alpha=float(shades[i]), lw=1.1)
        axes.set_ylabel("output f(x) of each cell")
    else:
        edges = np.arange(count + 1) - 0.5
        mesh = axes.pcolormesh(_between(motion.t), edges, outputs.T, cmap="viridis", rasterized=True)
        bar = axes.figure.colorbar(mesh, ax=axes, pad=0.02)
        bar.set_label("output f(x)")
        axes.set_ylabel("cell" if motion.x.ndim == 2 else "cell, row by row")
    axes.set_xlabel("t [unit of time of the templates]")
    axes.set_title(f"{count} cells (observed)", fontsize="medium", loc="left", y=1.04)
    finish_axes(axes)
    return axes


def _between(t: Array) -> Array:
    """Edges of the stretches around instants."""
    middles = 0.5 * (t[1:] + t[:-1])
    return np.concatenate((t[:1], middles, t[-1:]))


def plot_convergence(found: Convergence, *, ax: Axes | None = None) -> Axes:
    """Errors of Galerkin spaces against the element length, with the slopes of order 1 and 2.

    Parameters
    ----------
    found : Convergence
        From :func:`lure.galerkin.convergence`.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.  Orders are what these runs show; they prove no rate.
    """
    axes = axes_or_new(ax)
    h = np.array(found.widths)
    h1, l2 = (np.array([getattr(error, name) for error in found.errors]) for name in ("h1", "l2"))
    axes.loglog(h, h1, "o-", color=BLUE, lw=1.1, ms=4, label="H1 error of u [m^½]")
    axes.loglog(h, l2, "s-", color=GREEN, lw=1.1, ms=4, label="L2 error of v [m^(3/2)/s]")
    for order, dashes in ((1, ":"), (2, "--")):
        axes.loglog(h, h1[0] * (h / h[0]) ** order, color=GREY, lw=0.9, ls=dashes, label=f"order {order}")
    axes.set_xlabel("element length h [m]")
    axes.set_ylabel("error")
    axes.legend(loc="best", **LEGEND)
    axes.set_title("Galerkin spaces against a known motion (observed)", fontsize="medium", loc="left")
    finish_axes(axes)
    shown = h[:: max(1, -(-h.size // _TICKS))]
    axes.set_xticks(shown, [number(value) for value in shown])
    axes.minorticks_off()
    return axes
