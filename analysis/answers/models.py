"""The kinds of block a question can be about: rational, with dead time, too large for exact polynomials, measured."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from analysis.answer import Answer
from analysis.answers.catalogue import BEST, Entry, Question, entries
from analysis.answers.certifying import proved_answer, refuted_witness
from analysis.answers.rods import rod_hurwitz, rod_largest
from analysis.evidence import Bracket, Evidence, Verdict
from analysis.plant import Plant
from analysis.witness import Witness
from lure.delay import DelayBlock
from lure.errors import AssumptionError, InputError
from lure.frequency_data import FrequencyData
from lure.law_class import LawClass
from lure.rational import RationalBlock
from lure.sector import Sector, SlopeBounds
from lure.state_space import StateSpaceBlock
from lure.upwind import UpwindScheme
from lure.waves import RodBlock

REFUSED = "does not apply"
EXPECTED = (AssumptionError, InputError, OverflowError)  # said by the question itself
Search = Literal["linear", "full"]
Block = RationalBlock | DelayBlock | StateSpaceBlock | FrequencyData | UpwindScheme | RodBlock


@dataclass(frozen=True, kw_only=True, slots=True)
class Asked:
    """A question: the largest ``k`` of the classes ``[lower, k]`` for a block."""

    block: Block
    question: Question
    criterion: str
    lower: Fraction
    odd: bool
    time_varying: bool
    search: Search


def hurwitz(asked: Asked) -> Bracket:
    """Supremum of the ``k`` such that every linear gain in ``[lower, k]`` is stable (in the critical case: but 0)."""
    block = asked.block
    if isinstance(block, RationalBlock):
        from analysis.criteria.hurwitz import hurwitz_limit

        return hurwitz_limit(block, asked.lower)
    _from_zero(asked)
    if isinstance(block, DelayBlock):
        from analysis.dead_time.criteria import hurwitz_limit as with_dead_time

        return with_dead_time(block)
    if isinstance(block, UpwindScheme | RodBlock):
        return rod_hurwitz(block)
    return Bracket(0.0, math.inf)


def critical(asked: Asked) -> bool:
    """Whether the loop with the gain ``lower`` has a pole at 0 (``z = 1``): laws of the class add equilibria."""
    block = asked.block
    if isinstance(block, RationalBlock):
        return Plant.of(block).shifted(asked.lower).case == "critical"
    if isinstance(block, DelayBlock):
        return block.denominator[-1] == 0
    return isinstance(block, UpwindScheme | RodBlock)


def proviso(asked: Asked, criterion: str) -> str:
    """What Popov's criterion for a sector assumes where the block has a direct term: the loop must define ``sigma``."""
    block = asked.block
    direct = block.feedthrough if isinstance(block, RationalBlock) else Fraction(0)
    if asked.question == "slope" or criterion != "popov" or direct == 0:
        return ""
    return f"for which sigma + D phi(sigma), D = {direct}, is increasing with a locally Lipschitz inverse"


def answers(asked: Asked) -> list[Answer]:
    """What each criterion says, farthest reach first; a refusal is an answer too."""
    asking = entries(asked.block, asked.question, asked.criterion, time_varying=asked.time_varying)
    found = [_said(entry, asked) for entry in asking]
    if not found:
        raise AssumptionError(f"no criterion called {asked.criterion} applies to this block; try {BEST}")
    return sorted((proved_answer(asked, answer) for answer in found), key=_rank)


def _said(entry: Entry, asked: Asked) -> Answer:
    """What one criterion says; that it refuses or fails is an answer too, and proves nothing."""
    from analysis.certificates.guard import Failure, guarded

    block = asked.block
    try:
        if isinstance(block, RationalBlock):
            found = guarded(
                entry.name, lambda: entry.largest(block, lower=asked.lower, odd=asked.odd), passing=EXPECTED
            )
        elif isinstance(block, DelayBlock):
            from analysis.dead_time.criteria import LARGEST

            found = guarded(entry.name, lambda: LARGEST[entry.name](block), passing=EXPECTED)
        elif isinstance(block, UpwindScheme | RodBlock):
            found = rod_largest(block, entry.name)
        elif isinstance(block, StateSpaceBlock):
            found = guarded(entry.name, lambda: _computed(block, entry.name), passing=EXPECTED)
        else:
            from analysis.sampled import largest_sampled

            found = largest_sampled(block, entry.name)
    except AssumptionError as refusal:
        return _refused(entry.name, asked, str(refusal))
    return _refused(entry.name, asked, f"the search failed: {found}") if isinstance(found, Failure) else found


def _rank(answer: Answer) -> tuple[bool, bool, float, float]:
    """Proofs first, refusals last, farther reach before shorter."""
    refused = answer.theorem == REFUSED
    return answer.verdict is not Verdict.PROVED, refused, -answer.largest.low, -answer.largest.high


def witnesses(asked: Asked, limit: Bracket) -> list[Witness]:
    """Destabilising members of the class, with more than a simulation behind them, smallest ``k`` first."""
    block, found = asked.block, list[Witness]()
    if isinstance(block, RationalBlock):
        from analysis.refutation.linear import linear_witness

        linear = linear_witness(block, lower=asked.lower)
        found += [linear] if linear is not None else []
        if asked.search == "full":
            from analysis.certificates.guard import Failure, guarded
            from analysis.refutation.search import refute

            kind = {"slope": asked.question == "slope", "odd": asked.odd, "time_varying": asked.time_varying}
            more = guarded("refute", lambda: refute(block, lower=asked.lower, **kind), passing=EXPECTED)
            found = found if isinstance(more, Failure) else list(more)
    elif isinstance(block, DelayBlock) and limit.high < math.inf:
        found = [_dead_time_gain(block, limit)]
    ranked = [refuted_witness(asked, witness) for witness in found if witness.evidence > Evidence.OBSERVED]
    return sorted(ranked, key=lambda witness: witness.k)


def _computed(block: StateSpaceBlock, name: str) -> Answer:
    if name != "popov" or block.dt is not None:
        raise AssumptionError(
            f"for a block of order {block.A.shape[0]} given by matrices only popov in continuous time is computed, not "
            f"{name}; give coefficients for the exact criteria"
        )
    from analysis.hamiltonian import popov_largest_computed

    return popov_largest_computed(block.A, block.B, block.C, block.D)


def _dead_time_gain(block: DelayBlock, limit: Bracket) -> Witness:
    return Witness(
        kind="linear gain",
        k=limit.high,
        evidence=Evidence.CERTIFIED,
        slope_restricted=True,
        odd=True,
        description=f"a linear gain of about {limit.middle:.9g} puts a root on the imaginary axis, so that the loop "
        "does not come to rest",
        data={"gain": [limit.low, limit.high], "block": str(block)},
    )


def _from_zero(asked: Asked) -> None:
    if asked.lower != 0:
        raise AssumptionError(
            f"for a {type(asked.block).__name__} the classes begin at 0; got lower = {float(asked.lower):g}: close a "
            "loop with that gain in the model first"
        )


def _refused(name: str, asked: Asked, reason: str) -> Answer:
    lower = float(asked.lower)
    slope = SlopeBounds(lower, math.inf) if asked.question == "slope" else None
    return Answer(
        criterion=name,
        theorem=REFUSED,
        largest=Bracket(lower, math.inf),
        law_class=LawClass(sector=Sector(lower, math.inf), slope=slope, odd=asked.odd),
        verdict=Verdict.INCONCLUSIVE,
        evidence=Evidence.CERTIFIED,
        reason=reason,
    )
