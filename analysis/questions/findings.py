"""The verdict on the class asked about, from the table of classes."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Hashable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, TypeVar, cast

from lure.analysis.deadline import checkpoint, time_limit
from lure.analysis.numerics.doubles import double_below
from lure.analysis.questions.advice import serves, why
from lure.analysis.questions.certifying import proved_answer, restated, unbounded_proof
from lure.analysis.questions.conclusion import Conclusion, conclusion_of, undecided
from lure.analysis.questions.largest import StabilityBound, Stopped, meet
from lure.analysis.questions.models import (
    NOT_NEEDED,
    answer_of,
    critical,
    hurwitz,
    linear_witnesses,
    nonlinear_witnesses,
    rank,
    silent,
)
from lure.analysis.questions.problem import Problem, Subject
from lure.analysis.theorems.table import BEST, Theorem, theorems_for
from lure.analysis.verdict import Answer, Bracket, Verdict, Witness
from lure.classes import NonlinearityClass, Sector
from lure.errors import AssumptionError
from lure.plants.rational import RationalPlant

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Proved, Refuted

# What is found about some classes of laws for one block: cheap steps first, dear ones only where a gap is left.

Tell = Callable[[str, float], None]
T = TypeVar("T")
_LAST = 3  # the stage of the searches for nonlinear counterexamples
_ENOUGH = "what is proved and what is refuted meet without it"


@dataclass(slots=True)
class Findings:
    """What one question has found so far: true at any moment, complete when ``stopped`` is None at the end.

    Attributes
    ----------
    asked : Problem
        The question.
    hurwitz : Bracket
        Supremum of the ``k`` for which the linear gains in ``[lower, k]`` are stable; ``[lower, inf]`` until known.
    critical : bool
        Whether the loop has a pole at 0 with the least gain; True, the weaker conclusion, until known.
    answers : list of Answer
        Of the criteria asked so far.
    witnesses : list of Witness
        Destabilising members found so far.
    complete : bool
        Whether every step was made that could have found more.
    stopped : {"time", "interrupt"} or None
        What ended the search early.
    left_out : str
        The steps that could not be made, because a package is missing, and which.
    """

    asked: Problem
    hurwitz: Bracket
    critical: bool = True
    answers: list[Answer] = field(default_factory=list)
    witnesses: list[Witness] = field(default_factory=list)
    complete: bool = False
    stopped: Stopped | None = None
    left_out: str = ""

    @property
    def proved(self) -> float:
        """The end of the largest class proved, ``-inf`` for none."""
        return max((each.largest.low for each in self.answers if each.verdict is Verdict.PROVED), default=-math.inf)

    @property
    def refuted(self) -> float:
        """The end of the smallest class refuted, ``inf`` for none."""
        return min((witness.k for witness in self.witnesses), default=math.inf)

    @property
    def closed(self) -> bool:
        """Whether what is proved and what is refuted meet."""
        return meet(self.proved, self.refuted)


@dataclass(frozen=True, slots=True)
class _Step:
    """One piece of work for one question."""

    stage: int
    name: str
    findings: Findings
    work: Callable[[], None]


def find(asking: Sequence[Problem], *, seconds: float | None = None, tell: Tell | None = None) -> list[Findings]:
    """What is found for several questions about one block, stage by stage, the first question first in each.

    Parameters
    ----------
    asking : sequence of Problem
        The questions; what they have in common is computed once.
    seconds : float or None
        Time allowed.
    tell : callable, optional
        Told each step and the share of the steps behind it.

    Returns
    -------
    list of Findings
        In the order of the questions.

    Raises
    ------
    InputError, AssumptionError
        A question is no good, whatever the time.
    KeyboardInterrupt
        The user stopped the search before anything was found.
    """
    found = [Findings(asked, Bracket(_at_most(asked), math.inf)) for asked in asking]
    shared = _Shared()
    plans = [_steps(each, _theorems(each.asked), shared) for each in found]
    most = sum(len(_theorems(asked)) + 3 for asked in asking)
    try:
        with time_limit(seconds):
            for number, step in enumerate(heapq.merge(*plans, key=lambda step: step.stage)):
                checkpoint()
                if tell is not None:
                    tell(f"{_title(step.findings.asked)}: {step.name}", number / most)
                try:
                    step.work()
                except ModuleNotFoundError as missing:
                    step.findings.left_out += f"{step.name} left out: {missing}; "
    except TimeoutError:
        _stop(found, "time")
    except KeyboardInterrupt:
        if not any(each.answers or each.witnesses for each in found):
            raise
        _stop(found, "interrupt")
    for each in found:
        each.answers.sort(key=rank)
        each.witnesses.sort(key=lambda witness: witness.k)
    return found


def _at_most(asked: Problem) -> float:
    return double_below(asked.lower)


def _stop(found: list[Findings], why: Stopped) -> None:
    for each in found:
        each.stopped = None if each.complete or each.closed else why


def _theorems(asked: Problem) -> list[Theorem]:
    asking = theorems_for(asked.plant, asked.question, asked.criterion, odd=asked.odd, time_varying=asked.time_varying)
    if not asking:
        raise AssumptionError(f"no criterion called {asked.criterion} applies to this block; try {BEST}")
    return asking


def _title(asked: Problem) -> str:
    if asked.question == "sector":
        return "sector, time-varying" if asked.time_varying else "sector"
    return "slope, odd" if asked.odd else "slope"


class _Shared:
    """Results that several questions about one block have in common, each computed once."""

    def __init__(self) -> None:
        self._known: dict[Hashable, object] = {}
        self.slopes: dict[Fraction, float] = {}  # how far any class of restricted slope is proved, over its lower end

    def once(self, key: Hashable, compute: Callable[[], T]) -> T:
        """The result of that name, computed if it is not known."""
        if key not in self._known:
            self._known[key] = compute()
        return cast("T", self._known[key])


def _steps(found: Findings, asking: Sequence[Theorem], shared: _Shared) -> Iterator[_Step]:
    """The work for one question in ascending stages; what a closed gap makes needless is left out."""
    asked = found.asked
    yield _Step(0, "linear gains", found, lambda: _linear(found, shared))
    for row in asking:
        if row.stage > 0 and found.closed:
            found.answers.append(silent(row.name, asked, _ENOUGH, theorem=NOT_NEEDED))
        else:
            yield _Step(row.stage, row.name, found, partial(_criterion, found, row, shared))
    if asked.search == "full" and not found.closed:
        yield _Step(_LAST, "counterexamples", found, lambda: _counterexamples(found, shared))
    found.complete = True


def _linear(found: Findings, shared: _Shared) -> None:
    """The linear gains that are stable, and the first that is not."""
    asked = found.asked
    found.hurwitz = limit = shared.once(("hurwitz", asked.lower), lambda: hurwitz(asked))
    found.critical = shared.once(("critical", asked.lower), lambda: critical(asked))
    found.witnesses += shared.once(("linear", asked.lower), lambda: linear_witnesses(asked, limit))


def _criterion(found: Findings, row: Theorem, shared: _Shared) -> None:
    """One criterion, or what it said to another question that was the same to it."""
    asked = found.asked
    key = (row.name, asked.lower, asked.odd and row.odd)
    said = shared.once(key, lambda: answer_of(row, asked))
    if isinstance(said, str):
        found.answers.append(silent(row.name, asked, said))
        return
    wider = asked.time_varying and not said.law_class.time_varying
    said = shared.once((*key, wider), partial(proved_answer, asked, said))
    found.answers.append(said)
    if asked.question == "slope" and said.verdict is Verdict.PROVED:
        shared.slopes[asked.lower] = max(shared.slopes.get(asked.lower, -math.inf), said.largest.low)


def _counterexamples(found: Findings, shared: _Shared) -> None:
    """Nonlinear members of the class, unless it is known that there are none of the kind looked for.

    In continuous time the laws tried for time-invariant classes are odd and of restricted slope (see
    :func:`lure.analysis.counterexamples.oscillation.oscillation_witness`): none is unstable below what is proved of
    those.
    """
    asked = found.asked
    flow = isinstance(asked.plant, RationalPlant) and asked.plant.dt is None
    if flow and not asked.time_varying and meet(shared.slopes.get(asked.lower, -math.inf), found.refuted):
        return
    found.witnesses += nonlinear_witnesses(asked)


def asked_row(rows: list[StabilityBound], law_class: NonlinearityClass | None) -> StabilityBound | None:
    """The row whose class is that of the question, of the four in their order of the table."""
    if law_class is None:
        return None
    if law_class.time_varying:
        return rows[0]
    if law_class.slope is None:
        return rows[1]
    return rows[3] if law_class.odd else rows[2]


def decided(about: Subject, rows: list[StabilityBound]) -> Conclusion:
    """What follows for the class asked about, without one for the row that reaches farthest.

    Everything that the checker accepted of any row is tried; :func:`lure.analysis.questions.conclusion.conclusion_of`
    judges
    whether it fits.
    """
    law_class, asked = about.law_class, asked_row(rows, about.law_class)
    if law_class is None or asked is None:
        best = max(rows, key=lambda row: (row.verdict is Verdict.PROVED, row.largest.low, not row.time_varying))
        return best.conclusion
    inquiry = Problem.about(about.block, law_class, nonlinearity=about.law, membership=about.membership)
    ordered = [asked, *(row for row in rows if row is not asked)]
    missed: list[Conclusion] = []
    for proof in _proofs(about, ordered, law_class):
        found = conclusion_of(inquiry, restated(proof, inquiry), reach=proof)
        if found.verdict is Verdict.PROVED:
            return found
        missed.append(found)
    for row in ordered:
        for refuted, beside in pairwise((*row.refutations, None)):
            found = conclusion_of(inquiry, restated(cast("Refuted", refuted), inquiry), beside=beside)
            if found.verdict is Verdict.REFUTED:
                return found
    code, reason = why(asked, rows, law_class, missed)
    return undecided(inquiry, reason, code=code)


def _proofs(about: Subject, rows: list[StabilityBound], law_class: NonlinearityClass) -> Iterator[Proved]:
    """What was accepted of the rows, those that may serve; of laws without an upper bound beside every finite one."""
    for row in rows:
        end = law_class.slope.upper if row.question == "slope" and law_class.slope else law_class.sector.upper
        if row.proof is None or not serves(row, law_class) or row.largest.low < end:
            continue
        endless = _unbounded(about, row, law_class) if end == math.inf else None
        yield from (proof for proof in (endless, row.proof) if proof is not None)


def _unbounded(about: Subject, row: StabilityBound, law_class: NonlinearityClass) -> Proved | None:
    """What is accepted of the class without an upper bound: every finite ``k`` is less than that.

    ``sigma^3`` lies in ``[0, inf]`` and in no ``[0, k]``.
    """
    block = about.block
    if not isinstance(block, RationalPlant):
        return None
    sector = Sector(row.lower, math.inf)
    for theorem in reversed(theorems_for(block, "sector", BEST, time_varying=law_class.time_varying)):
        if not theorem.endless:
            continue
        with suppress(AssumptionError):
            found = unbounded_proof(block, theorem.decide(block, sector), time_varying=law_class.time_varying)
            if found is not None:
                return found
    return None
