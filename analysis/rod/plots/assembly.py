"""Figures of the motion of rods with several contacts: how far each has closed, its force, and the energy."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lure.analysis.plots.style import (
    BLUE,
    GREEN,
    GREY,
    LEGEND,
    PURPLE,
    VERMILLION,
    axes_or_new,
    finish_axes,
    padded,
    panels,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lure.rod.assembly_motion import AssemblyMotion

_LINES = ((BLUE, "-"), (VERMILLION, (0, (5, 1.5))), (GREEN, (0, (1, 1))), (PURPLE, (0, (4, 1.2, 1, 1.2))))
_SAMPLES = 2001


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
        for i, (colour, dashes) in enumerate(_LINES[: len(gaps)]):
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
        lines = [*lines[: len(_LINES) - 1], ("obstacle", motion.obstacle(t))]
    for (colour, dashes), (name, values) in zip(_LINES, lines, strict=False):
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
