"""The kinds of block a question can be about: rational, with dead time, too large for exact polynomials, measured."""

from __future__ import annotations

import math

from lure.analysis.certificates.theory import theory_of
from lure.analysis.inequality.plant import TransferPolynomials
from lure.analysis.numerics.doubles import double_below
from lure.analysis.numerics.precision import ball, outward
from lure.analysis.questions.certifying import refuted_witness
from lure.analysis.questions.problem import Problem
from lure.analysis.questions.state_space import growing_gain, state_space_answer
from lure.analysis.theorems.table import Theorem
from lure.analysis.verdict import Answer, Bracket, Evidence, Verdict, Witness
from lure.classes import NonlinearityClass, Sector, SlopeBounds
from lure.errors import AssumptionError, InputError
from lure.plants.block import StructuredPlant
from lure.plants.delay import DelayPlant
from lure.plants.frequency_data import FrequencyData
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace

REFUSED = "does not apply"
NOT_NEEDED = "not needed"
EXPECTED = (AssumptionError, InputError, OverflowError, ModuleNotFoundError)  # said by the question itself


def hurwitz(asked: Problem) -> Bracket:
    """Supremum of the ``k`` such that every linear gain in ``[lower, k]`` is stable (in the critical case: but 0)."""
    block = asked.plant
    if isinstance(block, RationalPlant):
        from lure.analysis.inequality.gains import hurwitz_limit

        if (
            TransferPolynomials.of(block).shifted(asked.lower).case == "unstable"
        ):  # lower itself, a member of every class
            return outward(ball(asked.lower), ball(asked.lower))
        return hurwitz_limit(block, asked.lower)
    if isinstance(block, StateSpace):
        witness = growing_gain(block, asked.lower)
        return Bracket(double_below(asked.lower), math.inf if witness is None else witness.k)
    _from_zero(asked)
    if isinstance(block, DelayPlant):
        from lure.analysis.theorems.dead_time import hurwitz_limit as with_dead_time

        return with_dead_time(block)
    if isinstance(block, StructuredPlant):
        return theory_of(block).hurwitz()
    return Bracket(0.0, math.inf)


def critical(asked: Problem) -> bool:
    """Whether the loop with the gain ``lower`` has a pole at 0 (``z = 1``): laws of the class add equilibria."""
    block = asked.plant
    if isinstance(block, RationalPlant):
        return TransferPolynomials.of(block).shifted(asked.lower).case == "critical"
    if isinstance(block, DelayPlant):
        return block.denominator[-1] == 0
    return isinstance(block, StructuredPlant) and theory_of(block).critical


def answer_of(row: Theorem, asked: Problem) -> Answer | str:
    """What one criterion says, before the checker has seen it; that it refuses or fails, and why, as text.

    Raises
    ------
    TimeoutError
        The time allowed is over.
    """
    from lure.analysis.certificates.sealing import Failure, guarded

    try:
        found = guarded(row.name, lambda: _largest(row, asked), passing=(*EXPECTED, TimeoutError))
    except (AssumptionError, InputError, ModuleNotFoundError) as refusal:
        return str(refusal)
    return f"the search failed: {found}" if isinstance(found, Failure) else found


def _largest(row: Theorem, asked: Problem) -> Answer:
    block = asked.plant
    if isinstance(block, RationalPlant | DelayPlant):
        return row.reach(block, lower=asked.lower, odd=asked.odd)
    if isinstance(block, StructuredPlant):
        return theory_of(block).largest(row.name)
    if isinstance(block, StateSpace):
        return state_space_answer(block, row.name, asked.lower)
    from lure.analysis.inequality.samples import largest_sampled

    return largest_sampled(block, row.name)


def rank(answer: Answer) -> tuple[bool, bool, float, float]:
    """Proofs first, refusals last, farther reach before shorter."""
    silent = answer.theorem in (REFUSED, NOT_NEEDED)
    return answer.verdict is not Verdict.PROVED, silent, -answer.largest.low, -answer.largest.high


def linear_witnesses(asked: Problem, limit: Bracket) -> list[Witness]:
    """The smallest destabilising linear gain of the class, if there is one."""
    block, found = asked.plant, None
    if isinstance(block, RationalPlant):
        from lure.analysis.counterexamples.linear import linear_witness

        found = linear_witness(block, lower=asked.lower)
    elif isinstance(block, StateSpace):
        found = growing_gain(block, asked.lower)
    elif isinstance(block, DelayPlant) and limit.high < math.inf:
        found = _dead_time_gain(block, limit)
    return [] if found is None else [refuted_witness(asked, found)]


def nonlinear_witnesses(asked: Problem) -> list[Witness]:
    """Other destabilising members of the class, with more than a simulation behind them.

    Raises
    ------
    TimeoutError
        The time allowed is over.
    """
    from lure.analysis.certificates.sealing import Failure, guarded
    from lure.analysis.counterexamples.search import refute

    block = asked.plant
    if not isinstance(block, RationalPlant):
        return []
    kind = {"slope": asked.question == "slope", "odd": asked.odd, "time_varying": asked.time_varying}
    passing = (*EXPECTED, TimeoutError)
    found = guarded("refute", lambda: refute(block, lower=asked.lower, **kind), passing=passing)
    if isinstance(found, Failure):
        return []
    strong = (each for each in found if each.kind != "linear gain" and each.evidence > Evidence.OBSERVED)
    return [refuted_witness(asked, witness) for witness in strong]


def _dead_time_gain(block: DelayPlant, limit: Bracket) -> Witness:
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


def _from_zero(asked: Problem) -> None:
    if asked.lower != 0:
        raise AssumptionError(
            f"for a {type(asked.plant).__name__} the classes begin at 0; got lower = {float(asked.lower):g}: close a "
            "loop with that gain in the model first"
        )


def silent(name: str, asked: Problem, reason: str, *, theorem: str = REFUSED) -> Answer:
    """The answer of a criterion that says nothing: it refuses, it failed, or it was not asked."""
    lower = float(asked.lower)
    computed, sampled = isinstance(asked.plant, StateSpace), isinstance(asked.plant, FrequencyData)
    slope = SlopeBounds(lower, math.inf) if asked.question == "slope" else None
    return Answer(
        criterion=name,
        theorem=theorem,
        largest=Bracket(lower, math.inf),
        law_class=NonlinearityClass(sector=Sector(lower, math.inf), slope=slope, odd=asked.odd),
        verdict=Verdict.INCONCLUSIVE,
        evidence=Evidence.OBSERVED if sampled else Evidence.COMPUTED if computed else Evidence.CERTIFIED,
        reason=reason,
    )
