"""The searches for a proof or a counterexample of one class, cheapest first; what they propose, the checker decides."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from typing import Any

from analysis.certificates.refutations import refutation_draft

from analysis.answer import Answer
from analysis.certificates import codes
from analysis.certificates.asking import questions
from analysis.certificates.checker import Proved, Refuted, Rejected, check, completed
from analysis.certificates.covers import cover_proof, has_delays
from analysis.certificates.guard import Failure, guarded
from analysis.certificates.multipliers import Upper, multipliers
from analysis.certificates.posing import Question
from analysis.certificates.proposals import Numbers, answer_draft, energy_draft
from analysis.evidence import Evidence, Verdict
from analysis.witness import Witness
from lure.delay import DelayBlock
from lure.errors import AssumptionError
from lure.frequency_data import FrequencyData
from lure.rational import RationalBlock
from lure.state_space import StateSpaceBlock
from lure.upwind import UpwindScheme
from lure.waves import RodBlock

Search = Callable[[], Proved | Refuted | Failure | None]
Draft = dict[str, Any]
_SEALED = ("hypotheses", "conclusion")


def searches(question: Question, *, method: str, numbers: Numbers) -> Iterator[tuple[str, Search]]:
    """What to try for a question, in order, each with its name.

    Parameters
    ----------
    question : Question
        The question.
    method : str
        The kind of proof, or ``best``.
    numbers : str
        Where the numbers came from.

    Yields
    ------
    tuple of str, callable
        The callable returns what the checker accepted, a failure, or None where there was nothing to find.
    """
    block, proofs = question.block, not question.rough
    if isinstance(block, FrequencyData):
        return
    yield "linear gains", lambda: _linear(question, numbers)
    if isinstance(block, RodBlock | UpwindScheme) and question.criterion == "best":
        yield "the energy of the rod", lambda: _sealed(question, energy_draft(block, numbers=numbers))
    elif isinstance(block, StateSpaceBlock):
        yield "matrices", lambda: _by_matrices(question, None, numbers)
    elif proofs and not isinstance(block, RodBlock):
        asked = guarded("criteria", lambda: list(_questions(question, finite=question.finite)))
        if isinstance(asked, Failure):
            yield "criteria", lambda: asked
            return
        for name, upper, ask in asked:
            yield name, lambda n=name, u=upper, a=ask: _proof(question, (n, u, a), method, numbers)  # type: ignore[misc]
    if isinstance(block, RationalBlock) and question.criterion == "best":
        yield "counterexamples", lambda: _counterexample(question, numbers)
    if proofs and not question.finite and question.law_class.sector.upper == math.inf:
        yield "every finite bound", lambda: _every_finite(question)


def _questions(question: Question, *, finite: bool) -> Iterator[tuple[str, Upper, Callable[[], Answer]]]:
    block = question.block
    assert isinstance(block, RationalBlock | DelayBlock | UpwindScheme)
    return questions(block, question.law_class, question.criterion, finite=finite)


def _proof(
    question: Question, asked: tuple[str, Upper, Callable[[], Answer]], method: str, numbers: Numbers
) -> Proved | Refuted | Failure:
    """A criterion asked, and what it proves put before the checker."""
    name, upper, ask = asked
    answer = ask()
    if answer.verdict is not Verdict.PROVED and not (answer.criterion == "hurwitz" and _all_gains(answer, upper)):
        return Failure(search=name, code=codes.NO_MULTIPLIER, detail=answer.reason or "it does not reach the class")
    if answer.criterion == "popov" and not _solvable(question):
        detail = "popov proves the class for the laws with which sigma + H(inf) phi(sigma) is increasing only"
        return Failure(search=name, code=codes.SEVERAL_SOLUTIONS, detail=detail)
    if method == "matrix":
        return _by_matrices(question, answer, numbers)
    block = question.block
    assert isinstance(block, RationalBlock | DelayBlock | UpwindScheme)
    first: Rejected | None = None
    draft = answer_draft(block, answer, upper, numbers=numbers)
    if method not in ("best", draft["proof"]["method"]):
        detail = (
            f"what {name} proves here is shown by the method {draft['proof']['method']}, and {method} was asked for"
        )
        return Failure(search=name, code=codes.NOT_APPLICABLE, detail=detail)
    for multiplier in multipliers(block, answer, upper):
        trial = {**draft, "multiplier": multiplier}
        if multiplier != draft["multiplier"] and has_delays(trial):
            trial["proof"] = cover_proof(trial)
        try:
            return _sealed(question, trial)
        except Rejected as refusal:
            first = first or refusal
    return Failure(search=name, code=codes.code_for(first or Rejected("nothing to propose")), detail=str(first))


def _solvable(question: Question) -> bool:
    """Whether the class makes ``sigma + D phi(sigma)`` increasing, as Popov's criterion assumes where ``D != 0``."""
    block, slope = question.block, question.law_class.slope
    if not isinstance(block, RationalBlock) or block.feedthrough == 0:
        return True
    ends = () if slope is None else (slope.lower, slope.upper)
    return bool(ends) and all(math.isfinite(end) and 1 + block.feedthrough * Fraction(end) > 0 for end in ends)


def _all_gains(answer: Answer, upper: Upper) -> bool:
    """Whether the linear gains up to that end are stable: no verdict on nonlinear laws, and none is asked for."""
    low = answer.largest.low
    return low == math.inf if isinstance(upper, str) else upper <= low


def _by_matrices(question: Question, answer: Answer | None, numbers: Numbers) -> Proved | Refuted | Failure:
    from analysis.certificates.matrix import matrix_draft

    block = question.block
    if not isinstance(block, RationalBlock | StateSpaceBlock | UpwindScheme):
        raise AssumptionError(
            f"a proof by matrices is for blocks with finitely many states, not a {type(block).__name__}"
        )
    raise NotImplementedError(matrix_draft)


def _linear(question: Question, numbers: Numbers) -> Proved | Refuted | Failure | None:
    """A linear gain of the class that destabilises."""
    from analysis.refutation.linear import linear_witness

    block, sector = question.block, question.law_class.sector
    if not isinstance(block, RationalBlock) or sector.lower == -math.inf:
        return None
    witness = linear_witness(block, lower=Fraction(sector.lower), bound=sector.upper)
    return None if witness is None else _refuted(question, witness, numbers)


def _counterexample(question: Question, numbers: Numbers) -> Proved | Refuted | Failure | None:
    """A law of the class, of any kind, that destabilises."""
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
        if witness.k > bounds.upper or witness.kind == "linear gain":
            continue
        if witness.evidence is not Evidence.CERTIFIED:
            last = Failure(search="counterexamples", code=codes.UNPROVED_ORBIT, detail=str(witness))
            continue
        try:
            return _refuted(question, witness, numbers)
        except Rejected as refusal:
            last = Failure(search="counterexamples", code=codes.REJECTED, detail=str(refusal))
    return last


def _refuted(question: Question, witness: Witness, numbers: Numbers) -> Proved | Refuted:
    draft = refutation_draft(question.block, witness, question.laws, numbers=numbers)
    return check(text_of_draft({**draft, "laws": dict(question.laws), "law": None}))


def _every_finite(question: Question) -> Failure | None:
    """Whether the class would be proved if each of its laws had a bound."""
    block = question.block
    if isinstance(block, RodBlock | StateSpaceBlock | FrequencyData):
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


def _sealed(question: Question, draft: Draft) -> Proved | Refuted:
    """What the checker makes of a draft, stated for exactly the class asked about; else for a larger one."""
    bare = {key: value for key, value in draft.items() if key not in _SEALED}
    law = None if question.law is None else dict(question.law)
    asked = {**bare, "laws": dict(question.laws), "law": law}
    try:
        return check(text_of_draft(asked))
    except Rejected:
        if not contains(bare["laws"], question.laws):
            raise
        return check(text_of_draft({**bare, "law": law}))


def text_of_draft(draft: Mapping[str, Any]) -> str:
    """The certificate of a draft, filled in by the checker, as the text it will have in a file.

    Parameters
    ----------
    draft : Mapping
        A certificate without what the checker fills in.
    """
    return json.dumps(completed(draft))


def contains(larger: Mapping[str, Any], smaller: Mapping[str, Any]) -> bool:
    """Whether every law of one class is in another, both as they stand in a certificate.

    Parameters
    ----------
    larger, smaller : Mapping
        ``laws`` of a certificate.
    """
    slope = larger["slope"] is None or (smaller["slope"] is not None and _inside(smaller["slope"], larger["slope"]))
    sector = _inside(smaller["sector"], larger["sector"])
    return (
        sector
        and slope
        and (smaller["odd"] or not larger["odd"])
        and (larger["time_varying"] or not smaller["time_varying"])
        and (smaller["linear"] or not larger["linear"])
    )


def _inside(inner: list[str], outer: list[str]) -> bool:
    below = outer[0] == "-inf" or (inner[0] != "-inf" and Fraction(outer[0]) <= Fraction(inner[0]))
    if outer[1] in ("inf", "finite") or inner[1] in ("inf", "finite"):
        return below and (outer[1] == "inf" or (outer[1] == "finite" and inner[1] != "inf"))
    return below and Fraction(inner[1]) <= Fraction(outer[1])
