"""Proofs by matrices asked for: of the circle and Popov's criterion, with the multipliers that are worth a try."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from functools import partial

from lure.analysis.certificates.matrix import matrix_draft
from lure.analysis.certificates.proposals import Numbers
from lure.analysis.certificates.theory import Draft, theory_of
from lure.analysis.questions.problem import Problem
from lure.analysis.theorems.table import Question, Theorem, Upper, row_of, theorems_for
from lure.analysis.verdict import Answer, Verdict
from lure.classes import NonlinearityClass, Sector, SlopeBounds
from lure.errors import AssumptionError
from lure.exact import exact_number
from lure.plants.block import StructuredPlant
from lure.plants.delay import DelayPlant
from lure.plants.frequency_data import FrequencyData
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace

# Each criterion asked about exactly one class of laws, cheapest first.

Ask = Callable[[], Answer]
LONG = "full effort"  # takes minutes


def questions(
    block: RationalPlant | DelayPlant | StructuredPlant, law_class: NonlinearityClass, criterion: str, *, finite: bool
) -> Iterator[tuple[str, Upper, Ask]]:
    """The criteria that serve a class, each with the upper end to certify and a function that asks it.

    Parameters
    ----------
    block : RationalPlant, DelayPlant or StructuredPlant
        The block.
    law_class : NonlinearityClass
        The class.
    criterion : str
        A name, or ``best`` for all that apply.
    finite : bool
        Whether an infinite upper end means every law with some finite bound.

    Yields
    ------
    tuple of str, Fraction or str, callable
        The name, the upper end, and what gives the answer, PROVED where the whole class is.

    Raises
    ------
    InputError
        There is no such criterion.
    AssumptionError
        It does not apply to such a class or block.
    """
    question: Question = "sector" if law_class.slope is None else "slope"
    found = theorems_for(block, question, criterion, odd=law_class.odd, time_varying=law_class.time_varying)
    for row in found:
        for bounds in row.bounds(law_class):
            upper: Upper = Fraction(bounds.upper) if bounds.upper != math.inf else "finite" if finite else "inf"
            yield row.name, upper, _ask(block, row, bounds, law_class, finite=finite)
    slope = law_class.slope
    if isinstance(block, RationalPlant) and slope is not None and slope.upper != math.inf:
        for row in found:
            if row.thorough:
                ask = partial(row.decide, block, slope, odd=law_class.odd, thorough=True)
                yield f"{row.name}, {LONG}", Fraction(slope.upper), ask


def _ask(
    block: RationalPlant | DelayPlant | StructuredPlant,
    row: Theorem,
    bounds: Sector | SlopeBounds,
    law_class: NonlinearityClass,
    *,
    finite: bool,
) -> Ask:
    if isinstance(block, StructuredPlant):
        return lambda: _reaching(theory_of(block).largest(row.name), bounds)
    if isinstance(block, RationalPlant) and not (finite and bounds.upper == math.inf):
        return partial(row.decide, block, bounds, odd=law_class.odd)
    if isinstance(block, RationalPlant) and bounds.lower == -math.inf:
        return _endless
    lower = Fraction(0) if isinstance(block, DelayPlant) else exact_number(bounds.lower, "lower")
    return lambda: _reaching(row.reach(block, lower=lower, odd=law_class.odd), bounds)


def _endless() -> Answer:
    raise AssumptionError("the class has no finite lower end, and no theorem here begins at -inf; give a lower bound")


def _reaching(answer: Answer, bounds: Sector | SlopeBounds) -> Answer:
    """The answer about the largest class, if the class asked about is inside it."""
    if bounds.lower < answer.law_class.sector.lower:
        raise AssumptionError(
            f"for such a block the classes begin at {float(answer.law_class.sector.lower):g}; for a DelayPlant or a "
            "rod close a loop with the lower gain in the model first"
        )
    if answer.verdict is Verdict.PROVED and bounds.upper > answer.largest.low:
        reason = f"what is proved ends at {answer.largest.low:.10g}"
        return replace(answer, verdict=Verdict.INCONCLUSIVE, reason=reason)
    return answer


_GUESSES = ("1", "1/10", "10")  # [s]


def matrix_drafts(question: Problem, numbers: Numbers) -> Iterator[tuple[str, Callable[[], Draft]]]:
    """Drafts of proofs by matrices for a block without an exact criterion behind them, cheapest first.

    Parameters
    ----------
    question : Problem
        About a ``StateSpace``, or a ``StructuredPlant`` of finitely many states.
    numbers : str
        Where the numbers came from.

    Yields
    ------
    tuple of str, callable
        The name of the criterion, and what makes the draft or raises ``AssumptionError``.
    """
    wanted, varying = question.criterion, question.law_class.time_varying
    continuous = question.plant.dt is None
    if wanted in ("best", "circle"):
        yield "circle, by matrices", lambda: _draft(question, None, numbers)
    if wanted in ("best", "popov") and not varying and continuous:
        for theta in _thetas(question):
            yield f"popov, by matrices, theta = {float(theta):.6g}", partial(_draft, question, theta, numbers)


def draft_by_matrix(question: Problem, answer: Answer, numbers: Numbers) -> Draft:
    """A draft by a matrix for what a criterion proved.

    Parameters
    ----------
    question : Problem
        About a rational block.
    answer : Answer
        Of the circle or Popov's criterion, PROVED for the class.
    numbers : str
        Where the numbers came from.

    Raises
    ------
    AssumptionError
        It is another criterion, or no matrix was found.
    """
    row = row_of(answer.criterion, question.plant)
    if not row.matrix:
        raise AssumptionError(
            f"the criterion {answer.criterion} needs no matrix: --method polynomial or cover shows it"
        )
    theta = None
    if not row.time_varying:
        given = str(answer.parameters.get("theta", "0"))
        theta = Fraction(1) if "inf" in given else Fraction(given)
    return _draft(question, theta, numbers)


def _draft(question: Problem, theta: Fraction | None, numbers: Numbers) -> Draft:
    block, sector = question.plant, question.law_class.sector
    infinite = isinstance(block, StructuredPlant) and block.order is None
    if infinite or isinstance(block, DelayPlant | FrequencyData):
        raise AssumptionError(
            f"a proof by matrices is for blocks with finitely many states, not a {type(block).__name__}"
        )
    if sector.lower == -math.inf:
        raise AssumptionError("the class has no finite lower end, and a proof by matrices begins at one")
    endless: Upper = "finite" if question.finite else "inf"
    upper: Upper = endless if sector.upper == math.inf else Fraction(sector.upper)
    draft = matrix_draft(block, upper, lower=Fraction(sector.lower), theta=theta)
    return {**draft, "numbers": numbers}


def _thetas(question: Problem) -> Iterator[Fraction]:
    """Popov multipliers worth a try: those of its structure, the one that floating point finds best, some guesses."""
    block = question.plant
    if isinstance(block, StructuredPlant):
        yield from theory_of(block).thetas()
        return
    lower = question.law_class.sector.lower
    if not isinstance(block, StateSpace) or lower == -math.inf:
        return
    from lure.analysis.inequality.state_space import state_space_largest

    try:
        found = state_space_largest(block, "popov", lower=Fraction(lower))
    except AssumptionError:  # an eigenvalue at 0, perhaps: the matrix inequality has a critical case of its own
        yield from map(Fraction, _GUESSES)
        return
    if found.theta:
        yield Fraction(found.theta).limit_denominator(10**6) or Fraction(found.theta)
    else:
        yield from map(Fraction, _GUESSES)
