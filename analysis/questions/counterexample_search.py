"""The searches for a law of a class that destabilises, put before the checker."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

from lure.analysis.certificates import codes
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.checker import Proved, Refuted
from lure.analysis.certificates.proposals import Numbers
from lure.analysis.certificates.refutations import refutation_draft
from lure.analysis.certificates.sealing import Failure, check_for_class
from lure.analysis.certificates.theory import theory_of
from lure.analysis.questions.problem import Problem
from lure.analysis.verdict import Evidence, Witness
from lure.errors import AssumptionError
from lure.plants.block import StructuredPlant
from lure.plants.delay import DelayPlant
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace


def linear_refutation(question: Problem, numbers: Numbers) -> Proved | Refuted | None:
    """A constant gain of the class with which the loop does not come to rest; or what the plant's structure refutes.

    Parameters
    ----------
    question : Problem
        The question.
    numbers : str
        Where the numbers came from.

    Returns
    -------
    Refuted or None
        None if every gain is stable, or the block has none that is looked at.
    """
    block = question.plant
    if isinstance(block, StructuredPlant):
        draft = theory_of(block).refutation()
        return None if draft is None else check_for_class(question, {**draft, "numbers": numbers})
    if isinstance(block, StateSpace):
        witness = _growing(block, question)
    elif isinstance(block, RationalPlant | DelayPlant):
        witness = _with_dead_time(block, question) if isinstance(block, DelayPlant) else _gain(block, question)
    else:
        return None
    if witness is None:
        return None
    return check_for_class(question, refutation_draft(block, witness, question.laws, numbers=numbers))


def counterexample(question: Problem, numbers: Numbers) -> Proved | Refuted | Failure | None:
    """A law of the class, not a constant gain, that destabilises.

    Parameters
    ----------
    question : Problem
        The question.
    numbers : str
        Where the numbers came from.

    Returns
    -------
    Refuted, Failure or None
        A failure where one was found that could not be proved; None where none was found.
    """
    from lure.analysis.counterexamples.search import refute

    block, asked = question.plant, question.law_class
    bounds = asked.slope or asked.sector
    if not isinstance(block, RationalPlant) or bounds.lower == -math.inf:
        return None
    found = refute(
        block,
        slope=asked.slope is not None,
        odd=asked.odd,
        time_varying=asked.time_varying,
        lower=Fraction(bounds.lower),
    )
    last: Failure | None = None
    for witness in found:
        if witness.kind == "linear gain":
            continue
        if witness.evidence is not Evidence.CERTIFIED:
            inside = witness.k <= bounds.upper
            last = _failure(codes.UNPROVED_ORBIT, str(witness)) if inside else last
            continue
        try:
            return check_for_class(question, refutation_draft(block, witness, question.laws, numbers=numbers))
        except (Rejected, AssumptionError) as refusal:  # beyond the class, as often as not
            last = _failure(codes.REJECTED, str(refusal)) if witness.k <= bounds.upper else last
    return last


def _failure(code: codes.Code, detail: str) -> Failure:
    return Failure(search="counterexamples", code=code, detail=detail)


def _growing(block: StateSpace, question: Problem) -> Witness | None:
    """The smallest gain of the class with which a motion of a block given by matrices grows."""
    from lure.analysis.questions.state_space import growing_gain

    bounds = question.law_class.slope or question.law_class.sector
    if bounds.lower == -math.inf:
        return None
    found = growing_gain(block, Fraction(bounds.lower))
    return found if found is not None and found.k <= bounds.upper else None


def _gain(block: RationalPlant, question: Problem) -> Witness | None:
    """The smallest gain of the sector that is not stable; for a sector without a lower end some gain."""
    from lure.analysis.counterexamples.linear import linear_witness
    from lure.analysis.inequality.gains import unstable_gain

    sector = question.law_class.sector
    if sector.lower != -math.inf:
        return linear_witness(block, lower=Fraction(sector.lower), bound=sector.upper)
    gain = unstable_gain(block, sector)
    if not isinstance(gain, Fraction):
        return None
    some = linear_witness(block, lower=gain)
    return None if some is None else replace(some, data={"gain": str(gain), "lower": str(gain - 1)})


def _with_dead_time(block: DelayPlant, question: Problem) -> Witness | None:
    from lure.analysis.questions.models import hurwitz, linear_witnesses

    asked = Problem.largest(block, "sector", lower=Fraction(0), search="linear")
    sector, found = question.law_class.sector, linear_witnesses(asked, hurwitz(asked))
    return found[0] if found and sector.lower <= found[0].k <= sector.upper else None
