"""From a system to its report: every analysis in turn, and the stop if two of them disagree."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction

from lure.analysis.certificates.checker import Proved, Refuted
from lure.analysis.certificates.drafts import complete_and_check, guarded
from lure.analysis.numerics.doubles import bound_below
from lure.analysis.report.parts import ContradictionError, versions
from lure.analysis.rod.certificates import circle_bound, inequality_draft, negative_damping_draft
from lure.analysis.rod.conclusion import conclusion
from lure.analysis.rod.confirmation import Confirmation, confirmation
from lure.analysis.rod.popov import response_check, rod_criteria
from lure.analysis.rod.report.model import Simulation, StabilityReport
from lure.analysis.rod.simulation import contradictions, simulate
from lure.analysis.rod.spectrum import rod_spectrum
from lure.analysis.verdict import CriterionResult, Verdict
from lure.errors import InputError
from lure.rod.discretisation import UpwindScheme, upwind
from lure.rod.parameters import Rod
from lure.rod.scenario import matching
from lure.rod.systems import RodSystem
from lure.rod.transfer import RodPlant

PACKAGES = ("numpy", "scipy", "control", "python-flint", "sympy", "matplotlib", "jinja2")
LARGEST_SIMULATED = 1000
DEFAULT_SIMULATED = 200
FRAMES = 160
_LEAST = Fraction(1, 10**150)

Progress = Callable[[str, float], None]


def build_report(system: RodSystem, *, progress: Progress | None = None, command: str | None = None) -> StabilityReport:
    """Everything the report says about ``system``, computed and cross-checked.

    Parameters
    ----------
    system : RodSystem
        The rod, its scenario and discretisation.
    progress : callable, optional
        Called as ``progress(stage, done)`` when a stage begins, with the share ``0 <= done <= 1`` of work behind it.
    command : str, optional
        The command that makes the report again; by default ``lure report`` and the name of the system.

    Returns
    -------
    StabilityReport
        The same for the same system, in every run.

    Raises
    ------
    ContradictionError
        A motion, of the rod or of its scheme, contradicts a verdict.
    InputError
        ``|k|/Z`` is below 1e-150 and not zero: nothing could be drawn.
    """
    _demand_drawable(system.rod)
    say = progress or (lambda _stage, _done: None)
    say("spectrum", 0.0)
    scheme = upwind(system.rod, system.cells, form=system.form)
    spectrum = rod_spectrum(scheme)
    say("frequency criteria", 0.05)
    criteria = checked_criteria(scheme, rod_criteria(scheme))
    concluded = conclusion(scheme, system.scenario, system.intervals)
    certificates = (*concluded.certificates, *(one.shown for one in criteria if one.shown is not None))
    say("responses computed twice", 0.15)
    response = response_check(scheme)
    say("simulation", 0.35)
    simulation = _simulation(system)
    say("exact motion of the rod", 0.6)
    confirmed = _confirmation(system, simulation)
    return StabilityReport(
        system=system,
        scheme=scheme,
        spectrum=spectrum,
        criteria=criteria,
        conclusion=concluded,
        certificates=certificates,
        matching=matching(system.rod, system.scenario),
        response=response,
        simulation=simulation,
        confirmation=confirmed,
        command=command or f"lure report {shlex.quote(system.name)}",
        versions=versions(*PACKAGES),
    )


def _demand_drawable(rod: Rod) -> None:
    ratio = Fraction(rod.damping) / Fraction(rod.impedance)
    if 0 < abs(ratio) < _LEAST:
        raise InputError(
            f"rod.damping is {rod.damping:g}, beside an impedance of {rod.impedance:g} N s/m: a report in "
            "doubles cannot hold both; give a damping of at least 1e-150 times the impedance, or 0"
        )


def _simulation(system: RodSystem) -> Simulation:
    cells = system.simulation_cells or min(system.cells, DEFAULT_SIMULATED)
    asked = system.simulation_cells or system.cells
    if asked > LARGEST_SIMULATED:
        reason = (
            f"a simulation of {asked} cells was not attempted (limit: {LARGEST_SIMULATED}); to see a coarser one, set "
            f"simulation.cells to {DEFAULT_SIMULATED}"
        )
        return Simulation(cells=None, trajectory=None, skipped=reason)
    scheme = upwind(system.rod, cells, form=system.form)
    try:
        trajectory = simulate(scheme, system.scenario, until=system.until, frames=FRAMES)
    except InputError as refusal:  # the verdicts do not rest on the simulation
        return Simulation(cells=None, trajectory=None, skipped=str(refusal))
    _demand_no(contradictions(trajectory), f"the simulation of {system.name}")
    return Simulation(cells=cells, trajectory=trajectory, skipped=None)


def _confirmation(system: RodSystem, simulation: Simulation) -> Confirmation:
    cells = simulation.cells or min(system.cells, LARGEST_SIMULATED)
    run = simulation.trajectory or str(simulation.skipped)
    found = confirmation(upwind(system.rod, cells, form=system.form), system.scenario, system.until, run)
    _demand_no(found.contradictions, f"the exact motion of {system.name}")
    return found


def _demand_no(contradictions: Sequence[str], what: str) -> None:
    if contradictions:
        raise ContradictionError(
            f"INTERNAL CONTRADICTION: {what} contradicts what was shown; one of the two is wrong, and no report is "
            f"written: {'; '.join(contradictions)}"
        )


def checked_criteria(scheme: UpwindScheme, results: Sequence[CriterionResult]) -> tuple[CriterionResult, ...]:
    """Results for the rod and its scheme with what the checker accepted of them; INCONCLUSIVE where it was nothing."""
    return tuple(_checked(scheme, result) for result in results)


def _checked(scheme: UpwindScheme, result: CriterionResult) -> CriterionResult:
    if result.verdict is Verdict.INCONCLUSIVE:
        return result
    block = scheme if result.model == "scheme" else RodPlant(scheme.rod)
    proved = result.verdict is Verdict.PROVED
    draft = inequality_draft(block, result) if proved else negative_damping_draft(block, result.sector)
    found = guarded(result.criterion, lambda: complete_and_check(draft))
    if isinstance(found, Proved | Refuted):
        return replace(result, shown=found)
    why, bound = str(found), circle_bound(scheme.rod) if proved and result.criterion == "circle" else None
    if bound is not None and bound <= result.sector.upper:
        why = (
            f"{result.reason}, and what the checker proves of the circle criterion, for any number of cells alike, "
            f"ends at the sector [0, {bound_below(bound)}]; ask Popov's for more"
        )
    return replace(result, verdict=Verdict.INCONCLUSIVE, reason=f"not certified: {why}")
