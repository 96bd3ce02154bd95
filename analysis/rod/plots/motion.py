"""Motions of any object on one figure: the rod itself, its scheme, a Galerkin space, a cellular network.

Of rods with several contacts: how far each has closed, its force, and the energy.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from lure.analysis.plots.style import (
    BLUE,
    GREEN,
    GREY,
    LEGEND,
    PURPLE,
    VERMILLION,
    axes_or_new,
    finish_axes,
    number,
    padded,
    panels,
    room_below,
    scaled_unit,
)
from lure.analysis.rod.plots.run import colour_top, draw_end, envelope, shade
from lure.arrays import Reals as Array
from lure.errors import InputError
from lure.rod.cellular.motion import CellularMotion
from lure.rod.galerkin import Convergence, GalerkinRun
from lure.rod.motion import Motion
from lure.rod.scheme import StructuredMotion

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lure.analysis.rod.simulation import Trajectory
    from lure.rod.assembly_motion import AssemblyMotion

# The simulated motion: the contacting end, what decays, and the waves in space and time.

Surface = Literal["r1", "r2", "v"]
SURFACES: dict[Surface, str] = {
    "r1": "forward wave r₁ = v − c ∂u/∂x",
    "r2": "backward wave r₂ = v + c ∂u/∂x",
    "v": "velocity v",
}
Contacts = tuple[tuple[float, float], ...]
_SAMPLES = 2001
_LINES = 12
_TICKS = 6
_LINES_OF_RODS = ((BLUE, "-"), (VERMILLION, (0, (5, 1.5))), (GREEN, (0, (1, 1))), (PURPLE, (0, (4, 1.2, 1, 1.2))))


def plot_end_motion(trajectory: Trajectory, *, ax: Axes | None = None) -> Axes:
    """Displacement ``u(t, L)`` of the contacting end, with contact intervals shaded and the obstacle.

    Parameters
    ----------
    trajectory : Trajectory
        A simulation.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.  An obstacle too far away for the scale of the motion is named, not drawn.
    """
    axes = axes_or_new(ax)
    spans, end = [(contact.start, contact.end) for contact in trajectory.contacts], trajectory.u_end
    shade(axes, spans, f"contact ({len(spans)} interval{'s' if len(spans) > 1 else ''})")
    draw_end(axes, trajectory.t, end, float(end[0] - trajectory.z[0]))
    return finish_axes(axes, "t [s]", "u(t, L) [m]", legend="lower right")


def plot_decay(trajectory: Trajectory, *, ax: Axes | None = None) -> Axes:
    """Energy and, where there is one, Popov-Lyapunov function along a simulation, relative to their largest values.

    Parameters
    ----------
    trajectory : Trajectory
        A simulation.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on, logarithmic where the curves span more than a decade.
    """
    axes = axes_or_new(ax)
    t = trajectory.t
    least = 1.0
    curves = (("energy", trajectory.energy, BLUE, "-"), ("Popov–Lyapunov function", trajectory.lyapunov, PURPLE, "--"))
    for label, values, colour, dashes in curves:
        if values is None:
            continue
        top = float(np.max(values))
        if top > 0:
            share = values / top
            axes.plot(*envelope(t, share), color=colour, ls=dashes, lw=1.2, label=label)
            least = min(least, float(share.min()))
    if 0.0 < least < 0.1:
        axes.set_yscale("log")
        axes.set_ylim(max(0.5 * least, 1e-16), 2.0)
    axes.set_xlim(float(t[0]), float(t[-1]))
    finish_axes(axes, "t [s]", "share of the largest value")
    if axes.lines:
        axes.legend(loc="best", **LEGEND)
    else:
        axes.text(0.5, 0.5, "no energy: the rod stays at rest", transform=axes.transAxes, ha="center", color=GREY)
    return axes


def plot_rest(trajectory: Trajectory, *, ax: Axes | None = None) -> Axes:
    """Contact coordinate ``z`` and its deflated part ``zeta``, which never increases while no load acts.

    The two meet where the rod comes to rest.  Where the run is too short to show that, a small picture beside it shows
    the drift with the slowest decay of the scheme's spectrum.

    Parameters
    ----------
    trajectory : Trajectory
        A simulation.
    ax : Axes, optional
        Where to draw; by default a new figure.
    """
    axes = axes_or_new(ax)
    t, rest = trajectory.t, trajectory.rest_position
    factor, unit = scaled_unit(float(np.abs(trajectory.z).max()), "m")
    axes.plot(*envelope(t, factor * trajectory.z), color=BLUE, lw=1.0, label="z = u(t, L) − gap")
    if trajectory.zeta is not None:
        axes.plot(*envelope(t, factor * trajectory.zeta), color=GREEN, lw=1.4, ls="--", label="ζ")
    if rest is not None:
        axes.axhline(factor * rest, color=GREY, lw=0.8, ls=":", label="resting place")
    bottom, top = axes.get_ylim()
    axes.set_ylim(room_below(bottom, top, 3), top)
    axes.set_xlim(float(t[0]), float(t[-1]))
    axes.set_xlabel("t [s]")
    axes.set_ylabel(f"z and ζ [{unit}]", labelpad=1)
    axes.tick_params(axis="y", labelsize="small")
    finish_axes(axes, legend="lower left")
    if rest is not None and trajectory.rest_is_final:
        _drift(axes, trajectory, rest, factor)
    return axes


def _drift(axes: Axes, trajectory: Trajectory, rest: float, factor: float) -> None:
    """Where ``z`` goes after the run, in a small picture; none if it is there already, or if it rings longer."""
    from lure.analysis.rod.spectrum import rod_spectrum

    last = trajectory.t > 0.9 * trajectory.t[-1]
    end, span = float(np.mean(trajectory.z[last])), float(np.ptp(trajectory.z)) or 1.0
    rate = rod_spectrum(trajectory.scheme).decay_scheme
    rings = float(np.ptp(trajectory.z[last])) > 0.1 * abs(rest - end)
    if abs(rest - end) < 0.1 * span or rings or not 0.0 < rate < np.inf:
        return
    later = np.linspace(0.0, 5.0 / rate, 200)
    small = axes.inset_axes((0.62, 0.13, 0.36, 0.28))
    small.plot(later, factor * (rest + (end - rest) * np.exp(-rate * later)), color=BLUE, lw=1.0)
    small.axhline(factor * rest, color=GREY, lw=0.8, ls=":")
    small.set_xlim(0.0, float(later[-1]))
    small.set_title(f"afterwards, as exp(−{number(rate, 3)} t)", fontsize="x-small")
    small.set_xlabel("t [s]", fontsize="x-small", labelpad=1)
    small.tick_params(labelsize="x-small")
    finish_axes(small)


def plot_surface(trajectory: Trajectory, which: Surface, *, ax: Axes | None = None) -> Axes:
    """Space-time picture of a wave or of the velocity; a surface if ``ax`` is three-dimensional.

    Parameters
    ----------
    trajectory : Trajectory
        A simulation with frames.
    which : {"r1", "r2", "v"}
        Forward wave, backward wave, or velocity [m/s].
    ax : Axes or Axes3D, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on, with a colour bar beside them; its pointed ends say that larger values are cut off.

    Raises
    ------
    InputError
        ``which`` is none of the three.
    """
    if which not in SURFACES:
        raise InputError(f"which is {which!r}; give one of {', '.join(SURFACES)}")
    axes = axes_or_new(ax)
    values: NDArray[np.float64] = getattr(trajectory, f"frames_{which}")
    x, t = trajectory.frames_x, trajectory.frames_t
    if axes.name == "3d":
        space: Any = axes  # an Axes3D, which matplotlib does not type
        space.plot_surface(*np.meshgrid(x, t), values, cmap="viridis", rcount=60, ccount=60, linewidth=0)
        space.set_zlabel("[m/s]")
        axes.set_title(SURFACES[which], fontsize="medium")
    else:
        top = colour_top(values)
        mesh = axes.pcolormesh(x, t, values, cmap="RdBu_r", vmin=-top, vmax=top, shading="nearest", rasterized=True)
        clipped = "both" if top < float(np.abs(values).max()) else "neither"
        bar = axes.figure.colorbar(mesh, ax=axes, pad=0.02, fraction=0.2, extend=clipped)
        bar.set_label(f"{SURFACES[which]} [m/s]")
        finish_axes(bar.ax)
        axes.set_xlim(float(x[0]), float(x[-1]))  # the cells at the ends are halves: the rod ends there
    return finish_axes(axes, "x [m]", "t [s]")


def plot_motion(motion: Motion | GalerkinRun | StructuredMotion | CellularMotion, *, ax: Axes | None = None) -> Axes:
    """A motion as it is natural to see it, under a title that says what moved and on which evidence.

    Parameters
    ----------
    motion : Motion, GalerkinRun, StructuredMotion or CellularMotion
        Of a rod: the end ``u(t, L)``, the obstacle, and contacts shaded.  Of cells: the output of each against time,
        from 13 cells on as a picture; cells in the plane are taken row by row.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from lure.rod import builtin_system, exact_motion
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
    shade(axes, contacts, f"contact ({len(contacts)})")
    draw_end(axes, t, u, gap)
    axes.set_title(title, fontsize="medium", loc="left", y=1.04)
    return finish_axes(axes, "t [s]", "u(t, L) [m]", legend="best")


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
    return finish_axes(axes)


def _between(t: Array) -> Array:
    """Edges of the stretches around instants."""
    middles = 0.5 * (t[1:] + t[:-1])
    return np.concatenate((t[:1], middles, t[-1:]))


def plot_convergence(found: Convergence, *, ax: Axes | None = None) -> Axes:
    """Errors of Galerkin spaces against the element length, with the slopes of order 1 and 2.

    Parameters
    ----------
    found : Convergence
        From :func:`lure.rod.galerkin.convergence`.
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
    axes.set_title("Galerkin spaces against a known motion (observed)", fontsize="medium", loc="left")
    finish_axes(axes, "element length h [m]", "error", legend="best")
    shown = h[:: max(1, -(-h.size // _TICKS))]
    axes.set_xticks(shown, [number(value) for value in shown])
    axes.minorticks_off()
    return axes


def plot_assembly_contacts(motion: AssemblyMotion, *, ax: Axes | None = None) -> Axes:
    """How far each contact has closed, ``sigma_i - gap_i``, and below it the contact forces.

    Parameters
    ----------
    motion : AssemblyMotion
        The motion; of more than four contacts the first four are drawn.
    ax : Axes, optional
        Whose place the two take; by default a new figure.

    Returns
    -------
    Axes
        The upper axes; those of the forces share its times.
    """
    above, below = panels(ax, 1.0)
    t = np.linspace(0.0, motion.until, _SAMPLES)
    gaps = np.array([float(gap) for gap in motion.assembly.gaps])
    for axes, values in ((above, motion.sigma(t) - gaps), (below, motion.forces(t))):
        for i, (colour, dashes) in enumerate(_LINES_OF_RODS[: len(gaps)]):
            axes.plot(t, values[:, i], color=colour, ls=dashes, lw=1.1, label=f"contact {i + 1}")
        axes.axhline(0.0, color=GREY, lw=0.6, zorder=1)
        axes.set_ylim(*padded(float(min(values.min(), 0.0)), float(values.max()) or 1.0, 0.1))
    above.set_ylabel("σᵢ − gapᵢ [m]")
    below.set_ylabel("force Aᵢ pᵢ [N]")
    above.set_xlim(0.0, motion.until)
    above.tick_params(labelbottom=False)
    below.set_xlabel("t [s]")
    finish_axes(above)
    finish_axes(below)
    if len(gaps) > 1:
        above.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.0, **LEGEND)
    return above


def plot_assembly_ends(motion: AssemblyMotion, *, ax: Axes | None = None) -> Axes:
    """Displacements of the ends ``x = L`` that make contact, between two obstacles of ``x = 0`` too.

    Parameters
    ----------
    motion : AssemblyMotion
        The motion; of more than four rods the first four are drawn.
    ax : Axes, optional
        Where to draw; by default a new figure.
    """
    axes = axes_or_new(ax)
    t = np.linspace(0.0, motion.until, _SAMPLES)
    near, far = motion.ends(t)
    lines = [(f"rod {j + 1}, x = L", far[:, j]) for j in range(far.shape[1])]
    if motion.assembly.arrangement == "both-ends":
        lines = [("x = L", far[:, 0]), ("x = 0", near[:, 0])]
    if motion.assembly.obstacle_damping is not None:
        lines = [*lines[: len(_LINES_OF_RODS) - 1], ("obstacle", motion.obstacle(t))]
    for (colour, dashes), (name, values) in zip(_LINES_OF_RODS, lines, strict=False):
        axes.plot(t, values, color=colour, ls=dashes, lw=1.1, label=name)
    axes.set_xlim(0.0, motion.until)
    finish_axes(axes, "t [s]", "displacement [m]")
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.0, **LEGEND)
    return axes


def plot_assembly_energy(motion: AssemblyMotion, *, ax: Axes | None = None) -> Axes:
    """The energy of all rods and contacts over time.

    Parameters
    ----------
    motion : AssemblyMotion
        The motion.
    ax : Axes, optional
        Where to draw; by default a new figure.
    """
    axes = axes_or_new(ax)
    t = np.linspace(0.0, motion.until, 401)
    energy = motion.energies(t)
    axes.plot(t, energy, color=BLUE, lw=1.2)
    axes.set_xlim(0.0, motion.until)
    axes.set_ylim(0.0, 1.05 * float(energy.max()) or 1.0)
    return finish_axes(axes, "t [s]", "energy [J]")
