"""What is found for problems about one plant: cheap steps first, dear ones only where a gap is left."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from typing import TypeVar, cast

from lure.analysis.certificates.sealing import Failure
from lure.analysis.deadline import checkpoint, time_limit
from lure.analysis.numerics.doubles import double_below
from lure.analysis.questions.counterexample_search import critical, hurwitz, linear_witnesses, nonlinear_witnesses
from lure.analysis.questions.largest import Stopped, meet
from lure.analysis.questions.problem import Problem
from lure.analysis.questions.proofs import NOT_NEEDED, proved_answer, rank, reached, silent
from lure.analysis.theorems.table import BEST, LAST, Theorem, theorems_for
from lure.analysis.verdict import Answer, Bracket, Verdict, Witness
from lure.errors import AssumptionError, InputError, Reason
from lure.plants.rational import RationalPlant

Tell = Callable[[str, float], None]
T = TypeVar("T")
_COUNTER = 3  # the stage of the searches for nonlinear counterexamples
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


def find(asking: Sequence[Problem], seconds: float | None, tell: Tell | None) -> list[Findings]:
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
    AssumptionError
        A question is no good, whatever the time.
    InputError
        The same; or a gain or a frequency exceeds the range of doubles.
    KeyboardInterrupt
        The user stopped the search before anything was found.
    """
    found = [Findings(asked, Bracket(double_below(asked.lower), math.inf)) for asked in asking]
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
    except OverflowError:
        raise InputError(
            f"a gain or frequency of {asking[0].plant} exceeds the range of doubles, 1e-308 to 1e308; rescale the "
            "units",
            code=Reason.RANGE,
        ) from None
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
    searches = [_Step(_COUNTER, "counterexamples", found, lambda: _counterexamples(found, shared))]
    full = asked.search == "full"
    rows = [_Step(row.stage, row.name, found, partial(_criterion, found, row, shared)) for row in asking]
    late = full or asked.criterion != BEST
    rows = [step for step in rows if late or step.stage < LAST]
    for step in heapq.merge(rows, searches if full else [], key=lambda step: step.stage):
        if step.stage == 0 or not found.closed:
            yield step
        elif step.stage != _COUNTER:
            found.answers.append(silent(step.name, asked, _ENOUGH, theorem=NOT_NEEDED))
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
    said = shared.once(key, lambda: reached(row, asked))
    if isinstance(said, Failure):
        found.answers.append(silent(row.name, asked, said.detail, code=said.code.reason))
        return
    wider = asked.time_varying and not said.nonlinearity_class.time_varying
    said = shared.once((*key, wider), partial(proved_answer, asked, said))
    found.answers.append(said)
    if asked.question == "slope" and said.verdict is Verdict.PROVED:
        shared.slopes[asked.lower] = max(shared.slopes.get(asked.lower, -math.inf), said.largest.low)


def _counterexamples(found: Findings, shared: _Shared) -> None:
    """Nonlinear members of the class, unless it is known that there are none of the kind looked for.

    In continuous time the nonlinearities tried for time-invariant classes are odd and of restricted slope (see
    :func:`lure.analysis.counterexamples.oscillation.oscillation_witness`): none is unstable below what is proved of
    those.
    """
    asked = found.asked
    flow = isinstance(asked.plant, RationalPlant) and asked.plant.dt is None
    if flow and not asked.time_varying and meet(shared.slopes.get(asked.lower, -math.inf), found.refuted):
        return
    found.witnesses += nonlinear_witnesses(asked)
