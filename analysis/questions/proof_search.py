"""The searches for a proof or a counterexample of one class, cheapest first; what they propose, the checker decides."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import partial

from lure.analysis.certificates import codes
from lure.analysis.certificates.checker import Proved, Refuted
from lure.analysis.certificates.covers import cover_proof
from lure.analysis.certificates.proposals import Numbers, certified
from lure.analysis.certificates.sealing import Failure, check_for_class, guarded
from lure.analysis.certificates.theory import Draft, theory_of
from lure.analysis.questions.candidates import LONG, questions
from lure.analysis.questions.counterexample_search import counterexample, linear_refutation
from lure.analysis.questions.problem import Problem
from lure.analysis.theorems.table import Upper, row_of
from lure.analysis.verdict import Answer, Verdict
from lure.errors import AssumptionError
from lure.plants.block import StructuredPlant
from lure.plants.frequency_data import FrequencyData
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace

Search = Callable[[], Proved | Refuted | Failure | None]
Asked = tuple[str, Upper, Callable[[], Answer]]


def searches(question: Problem, *, numbers: Numbers) -> Iterator[tuple[str, Search]]:
    """What to try for a question, in order, each with its name.

    Parameters
    ----------
    question : Problem
        The question.
    numbers : str
        Where the numbers came from.

    Yields
    ------
    tuple of str, callable
        The callable returns what the checker accepted, a failure, or None where there was nothing to find.
    """
    block, proofs, method = question.plant, question.provable, question.method
    if isinstance(block, FrequencyData):
        return
    later: list[Asked] = []
    yield "linear gains", lambda: linear_refutation(question, numbers)
    if not proofs:
        pass
    elif isinstance(block, StructuredPlant) and question.criterion == "best" and method in ("best", "structure"):
        yield theory_of(block).argument, lambda: _by_structure(question, block, numbers)
    elif isinstance(block, StructuredPlant) and block.order is None:
        pass  # no criterion proves anything of infinitely many states
    elif isinstance(block, StateSpace) or (isinstance(block, StructuredPlant) and method == "matrix"):
        yield from _by_matrices(question, numbers)
    else:
        asked = guarded("criteria", lambda: list(_questions(question, finite=question.finite)))
        if isinstance(asked, Failure):
            yield "criteria", lambda: asked
            return
        later = [each for each in asked if each[0].endswith(LONG)]
        yield from _proofs(question, [each for each in asked if not each[0].endswith(LONG)], method, numbers)
    if isinstance(block, RationalPlant) and question.criterion == method == "best":
        yield "counterexamples", lambda: counterexample(question, numbers)
    yield from _proofs(question, later, method, numbers)
    if proofs and not question.finite and question.law_class.sector.upper == math.inf:
        yield "every finite bound", lambda: _every_finite(question)


def _proofs(question: Problem, asked: list[Asked], method: str, numbers: Numbers) -> Iterator[tuple[str, Search]]:
    for each in asked:
        yield each[0], partial(_proof, question, each, method, numbers)


def _questions(question: Problem, *, finite: bool) -> Iterator[Asked]:
    block = question.plant
    assert not isinstance(block, StateSpace | FrequencyData)
    return questions(block, question.law_class, question.criterion, finite=finite)


def _proof(question: Problem, asked: Asked, method: str, numbers: Numbers) -> Proved | Refuted | Failure:
    """A criterion asked, and what it proves put before the checker."""
    name, upper, ask = asked
    answer = ask()
    row = row_of(answer.criterion, question.plant)
    if answer.verdict is not Verdict.PROVED and not (row.linear and _all_gains(answer, upper)):
        return Failure(search=name, code=codes.NO_MULTIPLIER, detail=answer.reason or "it does not reach the class")
    if row.composed and not _solvable(question):
        detail = f"{row.name} proves the class for the laws with which sigma + H(inf) phi(sigma) is increasing only"
        return Failure(search=name, code=codes.SEVERAL_SOLUTIONS, detail=detail)
    if method == "matrix":
        from lure.analysis.questions.candidates import draft_by_matrix

        return check_for_class(question, draft_by_matrix(question, answer, numbers))
    block = question.plant
    assert not isinstance(block, StateSpace | FrequencyData)
    found = certified(block, answer, upper, numbers=numbers)
    if found.upper != upper:
        detail = f"what {name} proves is accepted with the upper end {found.upper} in place of {upper}"
        return Failure(search=name, code=codes.PRECISION, detail=detail)
    draft = found.proved.certificate
    if method == "cover" and draft["proof"]["method"] == "polynomial":
        return check_for_class(question, {**draft, "proof": cover_proof(draft)})
    if method not in ("best", draft["proof"]["method"]):
        detail = f"what {name} proves is shown by the method {draft['proof']['method']} here, not by {method}"
        return Failure(search=name, code=codes.NOT_APPLICABLE, detail=detail)
    return check_for_class(question, draft)


def _by_structure(question: Problem, block: StructuredPlant, numbers: Numbers) -> Proved | Refuted:
    return check_for_class(question, {**theory_of(block).proof(), "numbers": numbers})


def _solvable(question: Problem) -> bool:
    """Whether the class makes ``sigma + D phi(sigma)`` increasing, as some theorems assume where ``D != 0``."""
    block, slope = question.plant, question.law_class.slope
    if not isinstance(block, RationalPlant) or block.feedthrough == 0:
        return True
    ends = () if slope is None else (slope.lower, slope.upper)
    return bool(ends) and all(math.isfinite(end) and 1 + block.feedthrough * Fraction(end) > 0 for end in ends)


def _all_gains(answer: Answer, upper: Upper) -> bool:
    """Whether the linear gains up to that end are stable: no verdict on nonlinear laws, and none is asked for."""
    low = answer.largest.low
    return low == math.inf if isinstance(upper, str) else upper <= low


def _by_matrices(question: Problem, numbers: Numbers) -> Iterator[tuple[str, Search]]:
    from lure.analysis.questions.candidates import matrix_drafts

    for name, draft in matrix_drafts(question, numbers):
        yield name, partial(_computed, question, name, draft)


def _computed(question: Problem, name: str, draft: Callable[[], Draft]) -> Proved | Refuted | Failure:
    """A draft that floating point proposes; where it proposes none, that is a hint and nothing more."""
    try:
        return check_for_class(question, draft())
    except AssumptionError as refusal:
        code = codes.code_for(refusal)
        unknown = code in (codes.NOT_APPLICABLE, codes.UNEXPECTED)
        return Failure(search=name, code=codes.COMPUTED if unknown else code, detail=str(refusal))


def _every_finite(question: Problem) -> Failure | None:
    """Whether the class would be proved if each of its laws had a bound."""
    block = question.plant
    infinite = isinstance(block, StructuredPlant) and block.order is None
    if infinite or isinstance(block, StateSpace | FrequencyData):
        return None
    for name, _, ask in _questions(question, finite=True):
        try:
            answer = ask()
        except AssumptionError:
            continue
        if answer.verdict is Verdict.PROVED and answer.largest.low == math.inf:
            detail = f"{name} proves every finite upper bound, and the class has none"
            return Failure(search=name, code=codes.EVERY_FINITE, detail=detail)
    return None
