"""Rods with several contacts themselves, not their scheme: the energy theorem, its certificate, and one motion."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from lure.analysis.certificates.checker import Proved
from lure.analysis.certificates.drafts import checked
from lure.analysis.report.parts import ContradictionError, FigureSpec
from lure.errors import AssumptionError, InputError, Reason
from lure.rod.assembly import RodAssembly
from lure.rod.transfer import certificate_parameters

if TYPE_CHECKING:
    from lure.rod.assembly_motion import AssemblyMotion


def of_the_rods(assembly: RodAssembly) -> tuple[str, Proved | None]:
    """What a report on their scheme says of the rods themselves, and what the checker accepted; None if nothing.

    Parameters
    ----------
    assembly : RodAssembly
        The rods.
    """
    head = f"All other answers are about the upwind scheme. Of the rods themselves, {assembly.words}, "
    try:
        shown = rods_at_rest(assembly)
    except AssumptionError as refused:
        return f"{head}nothing is proved: {refused}.", None
    laws = "whatever the pressures are, if they oppose the closing of their contacts and are locally Lipschitz"
    return f"{head}it is proved without loads that {shown.certificate['conclusion']}, {laws} (certified).", shown


def followed(assembly: RodAssembly) -> tuple[tuple[str, ...], tuple[FigureSpec, ...]]:
    """What a report says and draws of one motion of the rods themselves; nothing if none is asked for.

    Parameters
    ----------
    assembly : RodAssembly
        The rods, with what acts on each and how it starts.

    Raises
    ------
    ContradictionError
        Without loads the energy grows by more than the error of its balance: a bug.
    """
    if not assembly.scenarios:
        return (), ()
    from lure.analysis.rod.plots import plot_assembly_contacts, plot_assembly_ends, plot_assembly_energy
    from lure.rod.assembly_motion import assembly_motion

    try:
        motion = assembly_motion(assembly)
    except (AssumptionError, InputError) as refused:
        return (f"the rods themselves were not followed: {refused}",), ()
    energy = motion.energies(np.linspace(0.0, motion.until, 401))
    free, damped = all(one.free for one in assembly.scenarios), all(rod.damping >= 0 for rod in assembly.rods)
    if free and damped and float(np.diff(energy).max()) > 1e-9 * float(energy.max()):
        raise ContradictionError(
            f"the energy of {assembly.words} grows along a motion without loads, which is proved not to happen: "
            "please report the file"
        )
    note = "Computed without a grid, of this motion alone."
    drawn = (
        ("rods-contacts", "The contacts of the rods", f"Contact where the upper curve is positive. {note}",
         plot_assembly_contacts),
        ("rods-ends", "The ends of the rods", note, plot_assembly_ends),
        ("rods-energy", "The energy of the rods", f"Lost in the dashpots, and in an obstacle that moves. {note}",
         plot_assembly_energy),
    )  # fmt: skip
    figures = [
        FigureSpec(name=name, section="simulation", title=title, caption=caption, draw=partial(draw, motion))
        for name, title, caption, draw in drawn
    ]
    return motion_sentences(motion), tuple(figures)


def motion_sentences(motion: AssemblyMotion) -> tuple[str, ...]:
    """What one motion showed: how long it was followed and how exactly, each contact, the energy.

    Parameters
    ----------
    motion : AssemblyMotion
        The motion.
    """
    energy = motion.energies([0.0, motion.until])
    said = [
        f"one motion of the rods themselves was followed for {motion.until:.4g} s without a grid (error about "
        f"{motion.error:.1g} m, energy balanced to {motion.energy_residual:.1g}); it proves nothing of others"
    ]
    for i, stretches in enumerate(motion.contacts, 1):
        if not stretches:
            said.append(f"contact {i} was never closed")
            continue
        times = "once" if len(stretches) == 1 else f"{len(stretches)} times"
        area, largest = motion.run.network.areas[i - 1], max(one.peak_stress for one in stretches)
        impulse = sum(one.impulse for one in stretches)
        said.append(
            f"contact {i} was closed {times}, first from {stretches[0].start:.6g} s on; its largest force was "
            f"{area * largest:.6g} N, its impulse {impulse:.6g} N s{'' if stretches[-1].closed else '; it still is'}"
        )
    said.append(f"the energy was {energy[0]:.6g} J at the start and {energy[-1]:.6g} J at the end")
    return tuple(said)


def rods_at_rest(assembly: RodAssembly) -> Proved:
    """That every motion of the rods comes to rest, for all pressures that oppose the closing of their contacts.

    A theorem about the partial differential equations (docs/theory/several-rods.md), for every stiffness: ``E' = - sum
    k v(t, 0)^2 - k_o w'^2``.  The pressures are locally Lipschitz functions of ``sigma_i`` with ``sigma_i p_i >= 0``,
    ``mu_i = -p_i``; the contact laws of the assembly are such.  Nothing is said of loads, or of a rate.

    Parameters
    ----------
    assembly : RodAssembly
        The rods.

    Returns
    -------
    Proved
        What the checker accepted; ``claim`` is the sentence, ``certificate`` the certificate.

    Raises
    ------
    AssumptionError
        A dashpot has ``k <= 0``: energy is not lost.

    Examples
    --------
    >>> from fractions import Fraction
    >>> from lure.rod import Rod
    >>> rod = Rod(youngs_modulus=210e9, density=7850, length=1, area=1e-4, damping=800, compliance=1)
    >>> one, none = (Fraction(1),) * 2, (Fraction(0),) * 2
    >>> between = RodAssembly(arrangement="both-ends", rods=(rod,), compliances=one, gaps=none)
    >>> print(rods_at_rest(between).certificate["conclusion"])
    every motion of finite energy comes to rest, and the pressure of every contact tends to 0
    """
    for number, rod in enumerate(assembly.rods, 1):
        if not rod.damping > 0:
            raise AssumptionError(
                f"[[rod]] number {number}: its damping is {rod.damping:g}, and the energy of the rods falls only where "
                "every dashpot damps; give a positive one",
                code=Reason.UNDAMPED,
            )
    pressure: dict[str, Any] = {
        "sector": ["0", "inf"],
        "slope": None,
        "odd": False,
        "time_varying": False,
        "linear": False,
    }
    plate = assembly.obstacle_damping
    found = checked(
        {
            "verdict": "PROVED",
            "numbers": "decimals as written",
            "system": {
                "kind": "rods",
                "arrangement": assembly.arrangement,
                "rods": [certificate_parameters(rod) for rod in assembly.rods],
                "obstacle": None if plate is None else str(plate),
            },
            "laws": {"channels": [pressure] * assembly.contacts, "repeated": False},
            "theorem": "rods-energy",
            "multiplier": {},
            "proof": {"method": "structure"},
        }
    )
    assert isinstance(found, Proved), "the draft says so"
    return found
