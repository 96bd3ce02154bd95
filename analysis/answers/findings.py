"""What is found about some classes of laws for one block: cheap steps first, dear ones only where a gap is left."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from typing import TypeVar, cast

from analysis.answer import Answer
from analysis.answers.catalogue import BEST, Entry, entries
from analysis.answers.certifying import proved_answer
from analysis.answers.largest import Stopped, meet
from analysis.answers.models import (
    NOT_NEEDED,
    Asked,
    answer_of,
    critical,
    hurwitz,
    linear_witnesses,
    nonlinear_witnesses,
    rank,
    silent,
)
from analysis.deadline import checkpoint, time_limit
from analysis.doubles import double_below
from analysis.evidence import Bracket, Verdict
from analysis.witness import Witness
from lure.errors import AssumptionError
from lure.rational import RationalBlock

Tell = Callable[[str, float], None]
T = TypeVar("T")
_LAST = 3  # the stage of the searches for nonlinear counterexamples
_ENOUGH = "what is proved and what is refuted meet without it"


@dataclass(slots=True)
class Findings:
    """What one question has found so far: true at any moment, complete when ``stopped`` is None at the end.

    Attributes
    ----------
    asked : Asked
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
    """

    asked: Asked
    hurwitz: Bracket
    critical: bool = True
    answers: list[Answer] = field(default_factory=list)
    witnesses: list[Witness] = field(default_factory=list)
    complete: bool = False
    stopped: Stopped | None = None

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


def find(asking: Sequence[Asked], *, seconds: float | None = None, tell: Tell | None = None) -> list[Findings]:
    """What is found for several questions about one block, stage by stage, the first question first in each.

    Parameters
    ----------
    asking : sequence of Asked
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
    plans = [_steps(each, _entries(each.asked), shared) for each in found]
    most = sum(len(_entries(asked)) + 3 for asked in asking)
    try:
        with time_limit(seconds):
            for number, step in enumerate(heapq.merge(*plans, key=lambda step: step.stage)):
                checkpoint()
                if tell is not None:
                    tell(f"{_title(step.findings.asked)}: {step.name}", number / most)
                step.work()
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


def _at_most(asked: Asked) -> float:
    return double_below(asked.lower)


def _stop(found: list[Findings], why: Stopped) -> None:
    for each in found:
        each.stopped = None if each.complete or each.closed else why


def _entries(asked: Asked) -> list[Entry]:
    asking = entries(asked.block, asked.question, asked.criterion, time_varying=asked.time_varying)
    if not asking:
        raise AssumptionError(f"no criterion called {asked.criterion} applies to this block; try {BEST}")
    return asking


def _title(asked: Asked) -> str:
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


def _steps(found: Findings, asking: Sequence[Entry], shared: _Shared) -> Iterator[_Step]:
    """The work for one question in ascending stages; what a closed gap makes needless is left out."""
    asked = found.asked
    yield _Step(0, "linear gains", found, lambda: _linear(found, shared))
    for entry in asking:
        if entry.stage > 0 and found.closed:
            found.answers.append(silent(entry.name, asked, _ENOUGH, theorem=NOT_NEEDED))
        else:
            yield _Step(entry.stage, entry.name, found, partial(_criterion, found, entry, shared))
    if asked.search == "full" and not found.closed:
        yield _Step(_LAST, "counterexamples", found, lambda: _counterexamples(found, shared))
    found.complete = True


def _linear(found: Findings, shared: _Shared) -> None:
    """The linear gains that are stable, and the first that is not."""
    asked = found.asked
    found.hurwitz = limit = shared.once(("hurwitz", asked.lower), lambda: hurwitz(asked))
    found.critical = shared.once(("critical", asked.lower), lambda: critical(asked))
    found.witnesses += shared.once(("linear", asked.lower), lambda: linear_witnesses(asked, limit))


def _criterion(found: Findings, entry: Entry, shared: _Shared) -> None:
    """One criterion, or what it said to another question that was the same to it."""
    asked = found.asked
    key = (entry.name, asked.lower, asked.odd and entry.odd)
    said = shared.once(key, lambda: answer_of(entry, asked))
    if isinstance(said, str):
        found.answers.append(silent(entry.name, asked, said))
        return
    wider = asked.time_varying and not said.law_class.time_varying
    said = shared.once((*key, wider), partial(proved_answer, asked, said))
    found.answers.append(said)
    if asked.question == "slope" and said.verdict is Verdict.PROVED:
        shared.slopes[asked.lower] = max(shared.slopes.get(asked.lower, -math.inf), said.largest.low)


def _counterexamples(found: Findings, shared: _Shared) -> None:
    """Nonlinear members of the class, unless it is known that there are none of the kind looked for.

    In continuous time the laws tried for time-invariant classes are odd and of restricted slope (see
    :func:`analysis.refutation.oscillation.oscillation_witness`): none is unstable below what is proved of those.
    """
    asked = found.asked
    flow = isinstance(asked.block, RationalBlock) and asked.block.dt is None
    if flow and not asked.time_varying and meet(shared.slopes.get(asked.lower, -math.inf), found.refuted):
        return
    found.witnesses += nonlinear_witnesses(asked)
