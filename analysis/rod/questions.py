"""The rod and its scheme as blocks of a question: what is certified of them elsewhere, in the form of an answer."""

from __future__ import annotations

import math

from lure.analysis.rod.popov import rod_circle_criterion, rod_popov_criterion
from lure.analysis.verdict import INFINITE, Answer, Bracket, Verdict
from lure.classes import NonlinearityClass, Sector
from lure.errors import AssumptionError
from lure.rod.discretisation import UpwindScheme
from lure.rod.transfer import RodPlant

_CRITERIA = {"popov": rod_popov_criterion, "circle": rod_circle_criterion}


def rod_largest(block: UpwindScheme | RodPlant, name: str) -> Answer:
    """The largest sector ``[0, k]`` of Popov's or the circle criterion for the rod or its scheme.

    For the rod itself the answer is INCONCLUSIVE whatever the inequality reaches: the verdict about the partial
    differential equation rests on the energy theorem, see :func:`lure.analysis.rod.conclusion.conclusion`.  That the
    inequality
    would suffice too is proved in note 11, and not used here.

    Parameters
    ----------
    block : UpwindScheme or RodPlant
        The scheme, or the rod.
    name : {"popov", "circle"}
        The criterion.

    Raises
    ------
    AssumptionError
        The criterion is not one for the rod.
    """
    if name not in _CRITERIA:
        raise AssumptionError(f"for the rod and its scheme there are popov and circle, and no {name}")
    found = _CRITERIA[name](block, Sector(0, math.inf))
    reach = found.largest_sector if found.largest_sector is not None else Bracket(0.0, math.inf)
    if 0 < reach.low < math.inf:  # asked of the largest sector, strictly inside its reach
        reach = Bracket(math.nextafter(reach.low, 0), reach.high)
        found = _CRITERIA[name](block, Sector(0, reach.low))
    scheme = isinstance(block, UpwindScheme)
    proved = scheme and reach.low > 0 and found.verdict is Verdict.PROVED
    pde = "the verdict about the rod itself rests on its energy theorem, not on this inequality: lure report"
    return Answer(
        criterion=name,
        theorem=f"{name} criterion in the critical case of a simple zero eigenvalue",
        largest=reach,
        law_class=NonlinearityClass(sector=Sector(0, reach.low if reach.low > 0 else math.inf)),
        verdict=found.verdict if proved or found.verdict is Verdict.REFUTED else Verdict.INCONCLUSIVE,
        evidence=found.evidence,
        needs=("time-invariant",),
        theta=found.theta,
        multiplier=None if found.theta is None else f"1 + {found.theta:.6g} s",
        worst_frequency=found.worst_frequency,
        hypotheses=found.hypotheses,
        reason=found.reason if scheme else pde,
        witness=found.witness,
    )


def rod_hurwitz(block: UpwindScheme | RodPlant) -> Bracket:
    """Supremum of the stable linear gains: every gain, if the dashpot damps, since Popov's criterion covers them.

    Parameters
    ----------
    block : UpwindScheme or RodPlant
        The scheme, or the rod.
    """
    return INFINITE if block.rod.exact["damping"] > 0 else Bracket(0.0, math.inf)
