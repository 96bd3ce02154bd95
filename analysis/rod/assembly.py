"""Rods with several contacts themselves, not their scheme: the energy theorem, its certificate, and one motion."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
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


def of_the_rods(assembly: RodAssembly) -> tuple[str, tuple[Proved, ...]]:
    """What a report on their scheme says of the rods themselves, and what the checker accepted."""
    head = f"All other answers are about the upwind scheme. Of the rods themselves, {assembly.words}, "
    try:
        shown = rods_at_rest(assembly)
    except AssumptionError as refused:
        return f"{head}nothing is proved: {refused}.", ()
    laws = "whatever the pressures are, if they oppose the closing of their contacts and are locally Lipschitz"
    varying = varying_pressures(assembly)
    ends = ", ".join(f"{float(Fraction(one['sector'][1])):.4g}" for one in varying.certificate["laws"]["channels"])
    return (
        f"{head}it is proved without loads that {shown.certificate['conclusion']}, {laws} (certified); and that every "
        f"motion comes to rest if the pressures change with time and p_i/sigma_i stays within [0, K_i], K = {ends} "
        "Pa/m, by the circle criterion (certified).",
        (shown, varying),
    )


def followed(assembly: RodAssembly) -> tuple[tuple[str, ...], tuple[FigureSpec, ...]]:
    """What a report says and draws of one motion of the rods themselves; nothing if none is asked for.

    ``assembly``: the rods, with what acts on each and how it starts.

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
    closed, lost = "Contact where the upper curve is positive.", "Lost in the dashpots, and in an obstacle that moves."
    drawn = (
        ("rods-contacts", "The contacts of the rods", f"{closed} {note}", plot_assembly_contacts),
        ("rods-ends", "The ends of the rods", note, plot_assembly_ends),
        ("rods-energy", "The energy of the rods", f"{lost} {note}", plot_assembly_energy),
    )
    figures = [
        FigureSpec(name=name, section="simulation", title=title, caption=caption, draw=partial(draw, motion))
        for name, title, caption, draw in drawn
    ]
    return motion_sentences(motion), tuple(figures)


def motion_sentences(motion: AssemblyMotion) -> tuple[str, ...]:
    """What one motion showed: how long it was followed and how exactly, each contact, the energy."""
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
    _demand_damping(assembly)
    return _shown(assembly, "rods-energy", ["inf"] * assembly.contacts, time_varying=False)


def varying_pressures(assembly: RodAssembly, bounds: Sequence[Fraction] | None = None) -> Proved:
    """That every motion of the rods comes to rest for all pressures below some slopes, which may change with time.

    The circle criterion for the partial differential equations, ``1/K_i + Re H(i omega) > 0`` with the areas as
    weights (docs/theory/several-rods.md), for ``0 <= sigma_i p_i(t, sigma_i) <= K_i sigma_i^2``, measurable in ``t``
    and locally Lipschitz in ``sigma_i``.  Above these slopes nothing follows: the energy of a contact may then be
    pumped.  Nothing is said of loads, or of a rate.

    Parameters
    ----------
    assembly : RodAssembly
        The rods.
    bounds : sequence of Fraction, optional
        ``K_i`` of each contact [Pa/m]; by default 99 per cent of what this criterion covers, ``E/L`` where that is any.

    Returns
    -------
    Proved
        What the checker accepted.

    Raises
    ------
    AssumptionError
        A dashpot has ``k <= 0``, or a bound is not covered.
    InputError
        There is not one bound a contact.

    Examples
    --------
    >>> from fractions import Fraction
    >>> from lure.rod import Rod
    >>> rod = Rod(youngs_modulus=1, density=1, length=1, area=1, damping=2, compliance=1)  # Z = 1: reach 1/3
    >>> pair = RodAssembly(arrangement="across-gap", rods=(rod, rod), compliances=(Fraction(1),), gaps=(Fraction(0),))
    >>> print(varying_pressures(pair, [Fraction(1, 7)]).certificate["conclusion"])
    every motion of finite energy comes to rest, and the pressure of every contact is square integrable
    """
    _demand_damping(assembly)
    reach = circle_reach(assembly)
    if bounds is None:
        stiffness = min(rod.exact["youngs_modulus"] / rod.exact["length"] for rod in assembly.rods)
        bounds = [stiffness if end is None else Fraction(99, 100) * end for end in reach]
    if len(bounds) != assembly.contacts:
        raise InputError(f"bounds has {len(bounds)} values for {assembly.contacts} contacts; give one for each")
    for number, (bound, end) in enumerate(zip(bounds, reach, strict=True), 1):
        if end is not None and not bound < end:
            raise AssumptionError(
                f"bound {number} is {float(bound):g} Pa/m, and the circle criterion covers pressures that change with "
                f"time below {float(end):g} Pa/m"
            )
    return _shown(assembly, "rods-circle", list(map(str, bounds)), time_varying=True)


def circle_reach(assembly: RodAssembly) -> tuple[Fraction | None, ...]:
    """For each contact the slope [Pa/m] below which the circle criterion covers it; None where it covers any.

    With ``l_j = (L/E) |k^2 - Z^2|/min(k, Z)^2`` of each rod: ``1/l_j`` against an obstacle, ``1/sum_j min(A) l_j/A_j``
    across a gap, and at both ends ``(E/L) min(k, Z)^2/max(2 Z^2, Z^2 + |k^2 - Z^2|)``.

    Parameters
    ----------
    assembly : RodAssembly
        Rods with ``k > 0``.
    """
    lags, areas = [], [rod.exact["area"] for rod in assembly.rods]
    for rod in assembly.rods:
        E, rho, L, A, k = (rod.exact[name] for name in ("youngs_modulus", "density", "length", "area", "damping"))
        Z2, both = A * A * rho * E, assembly.arrangement == "both-ends"
        lag = max(2 * Z2, Z2 + abs(k * k - Z2)) if both else abs(k * k - Z2)
        lags.append(L / E * lag / min(k * k, Z2))
    if assembly.arrangement == "both-ends":
        lags *= 2
    if assembly.arrangement == "across-gap":
        lags = [sum((min(areas) * lag / A for A, lag in zip(areas, lags, strict=True)), Fraction(0))]
    return tuple(1 / lag if lag else None for lag in lags)


def _demand_damping(assembly: RodAssembly) -> None:
    for number, rod in enumerate(assembly.rods, 1):
        if not rod.damping > 0:
            raise AssumptionError(
                f"[[rod]] number {number}: its damping is {rod.damping:g}, and the energy of the rods falls only where "
                "every dashpot damps; give a positive one",
                code=Reason.UNDAMPED,
            )


def _shown(assembly: RodAssembly, theorem: str, uppers: list[str], *, time_varying: bool) -> Proved:
    pressure: dict[str, Any] = {"slope": None, "odd": False, "time_varying": time_varying, "linear": False}
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
            "laws": {"channels": [{"sector": ["0", end], **pressure} for end in uppers], "repeated": False},
            "theorem": theorem,
            "multiplier": {},
            "proof": {"method": "structure"},
        }
    )
    assert isinstance(found, Proved), "the draft says so"
    return found
