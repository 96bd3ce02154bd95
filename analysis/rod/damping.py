"""What the sign of the damping decides about the rod before any frequency is looked at."""

from __future__ import annotations

import math

from lure.analysis.verdict import Bracket, CriterionResult, Evidence, Model, Verdict
from lure.classes import NonlinearityClass, Sector
from lure.errors import AssumptionError
from lure.rod.discretisation import UpwindScheme
from lure.rod.parameters import Rod
from lure.rod.transfer import RodPlant


def model_of(block: UpwindScheme | RodPlant) -> tuple[Model, int | None]:
    """What a result about ``block`` is about, and its number of cells."""
    return ("scheme", block.cells) if isinstance(block, UpwindScheme) else ("rod", None)


def check_sector(sector: Sector) -> None:
    """Refuse a sector that the critical case does not admit.

    Raises
    ------
    AssumptionError
        The sector does not start at zero, or holds no positive slope.
    """
    if sector.lower != 0 or not sector.upper > 0:
        raise AssumptionError(
            f"the criteria for the rod need a sector [0, k] with k > 0; got {sector}: shift the loop first"
        )


def without_damping(name: str, block: UpwindScheme | RodPlant, sector: Sector) -> CriterionResult | None:
    """The answer for ``k <= 0``, where no criterion applies; None for ``k > 0``.

    ``k < 0`` is refuted by a member of the class.  For ``-Z < k < 0`` that is ``phi = 0``: the mode ``m = 0`` grows.
    For ``k < -Z`` it is any linear gain ``kappa > 0``: on ``s > 0``, ``1 + kappa H(s)`` is continuous, tends to minus
    infinity
    at 0 (the residue ``A/k`` is negative) and to 1 at infinity, so the loop has a positive real pole.
    """
    model, cells = model_of(block)
    damping = block.rod.exact["damping"]
    if damping > 0:
        return None
    if damping == 0:
        reason = (
            "the zero eigenvalue is double (damping k = 0): the critical case of Popov's theorem needs a simple "
            "one; nothing "
            "dissipates in the rod, and a rod that flies away never returns; give a damping k > 0"
        )
        verdict, evidence, witness = Verdict.INCONCLUSIVE, Evidence.CERTIFIED, None
    else:
        witness = destabilising_example(block.rod, cells, sector)
        reason = f"the dashpot feeds energy in (damping k = {float(damping):g} N s/m < 0): {witness}"
        verdict, evidence = Verdict.REFUTED, Evidence.CERTIFIED
    return CriterionResult(
        criterion=name,
        model=model,
        theorem=f"{name} criterion, which needs a dashpot that damps",
        nonlinearity_class=NonlinearityClass(sector=sector),
        largest=Bracket(0.0, math.inf),
        verdict=verdict,
        evidence=evidence,
        reason=reason,
        witness=witness,
    )


def destabilising_example(rod: Rod, cells: int | None, sector: Sector) -> str:
    """A member of the sector that destabilises a rod with ``k < 0``, in one sentence."""
    if rod.reflection < 0:
        period = 2.0 * rod.travel_time
        growth = RodPlant(rod).log_reflection
        rate = (
            growth / period if cells is None else rod.wave_speed * cells / rod.length * math.expm1(growth / (2 * cells))
        )
        return f"with phi = 0 (no contact) the rod recedes from the obstacle at a speed that grows as exp({rate:.6g} t)"
    slope = f"{float(sector.upper):g}" if math.isfinite(sector.upper) else f"{1.0 / rod.compliance:g}"
    return (
        f"with phi = {slope} sigma the loop has a positive real pole, because the residue of H at zero is "
        f"{rod.residue_at_zero:.6g} m/(Pa s) < 0"
    )
