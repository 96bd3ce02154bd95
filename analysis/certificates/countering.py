"""The searches for a law of a class that destabilises, put before the checker."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from typing import Any

from analysis.certificates import codes
from analysis.certificates.arithmetic import Rejected
from analysis.certificates.checker import Proved, Refuted
from analysis.certificates.guard import Failure
from analysis.certificates.posing import Question
from analysis.certificates.proposals import Numbers
from analysis.certificates.refutations import refutation_draft
from analysis.certificates.sealing import sealed
from analysis.certificates.systems import system_of
from analysis.evidence import Evidence
from analysis.witness import Witness
from lure.delay import DelayBlock
from lure.errors import AssumptionError
from lure.rational import RationalBlock
from lure.state_space import StateSpaceBlock
from lure.upwind import UpwindScheme
from lure.waves import RodBlock


def linear_refutation(question: Question, numbers: Numbers) -> Proved | Refuted | None:
    """A constant gain of the class with which the loop does not come to rest; of a rod, a dashpot that feeds energy in.

    Parameters
    ----------
    question : Question
        The question.
    numbers : str
        Where the numbers came from.

    Returns
    -------
    Refuted or None
        None if every gain is stable, or the block has none that is looked at.
    """
    block = question.block
    if isinstance(block, RodBlock | UpwindScheme):
        if block.rod.exact["damping"] >= 0:
            return None
        return sealed(question, _draft(block, {"method": "structure"}, question, numbers))
    if isinstance(block, StateSpaceBlock):
        witness = _growing(block, question)
    elif isinstance(block, RationalBlock | DelayBlock):
        witness = _with_dead_time(block, question) if isinstance(block, DelayBlock) else _gain(block, question)
    else:
        return None
    if witness is None:
        return None
    return sealed(question, refutation_draft(block, witness, question.laws, numbers=numbers))


def counterexample(question: Question, numbers: Numbers) -> Proved | Refuted | Failure | None:
    """A law of the class, not a constant gain, that destabilises.

    Parameters
    ----------
    question : Question
        The question.
    numbers : str
        Where the numbers came from.

    Returns
    -------
    Refuted, Failure or None
        A failure where one was found that could not be proved; None where none was found.
    """
    from analysis.refutation.search import refute

    block, asked = question.block, question.law_class
    bounds = asked.slope or asked.sector
    if not isinstance(block, RationalBlock) or bounds.lower == -math.inf:
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
            return sealed(question, refutation_draft(block, witness, question.laws, numbers=numbers))
        except (Rejected, AssumptionError) as refusal:  # beyond the class, as often as not
            last = _failure(codes.REJECTED, str(refusal)) if witness.k <= bounds.upper else last
    return last


def _failure(code: codes.Code, detail: str) -> Failure:
    return Failure(search="counterexamples", code=code, detail=detail)


def _growing(block: StateSpaceBlock, question: Question) -> Witness | None:
    """The smallest gain of the class with which a motion of a block given by matrices grows."""
    from analysis.answers.state_space import growing_gain

    bounds = question.law_class.slope or question.law_class.sector
    if bounds.lower == -math.inf:
        return None
    found = growing_gain(block, Fraction(bounds.lower))
    return found if found is not None and found.k <= bounds.upper else None


def _gain(block: RationalBlock, question: Question) -> Witness | None:
    """The smallest gain of the sector that is not stable; for a sector without a lower end some gain."""
    from analysis.criteria.hurwitz import unstable_gain
    from analysis.refutation.linear import linear_witness

    sector = question.law_class.sector
    if sector.lower != -math.inf:
        return linear_witness(block, lower=Fraction(sector.lower), bound=sector.upper)
    gain = unstable_gain(block, sector)
    if not isinstance(gain, Fraction):
        return None
    some = linear_witness(block, lower=gain)
    return None if some is None else replace(some, data={"gain": str(gain), "lower": str(gain - 1)})


def _with_dead_time(block: DelayBlock, question: Question) -> Witness | None:
    from analysis.answers.models import Asked, hurwitz, linear_witnesses

    asked = Asked(
        block=block,
        question="sector",
        criterion="best",
        lower=Fraction(0),
        odd=False,
        time_varying=False,
        search="linear",
    )
    sector, found = question.law_class.sector, linear_witnesses(asked, hurwitz(asked))
    return found[0] if found and sector.lower <= found[0].k <= sector.upper else None


def _draft(
    block: RodBlock | UpwindScheme, proof: dict[str, Any], question: Question, numbers: Numbers
) -> dict[str, Any]:
    return {
        "verdict": "REFUTED",
        "numbers": numbers,
        "system": system_of(block),
        "laws": dict(question.laws),
        "theorem": "counterexample",
        "proof": proof,
    }
