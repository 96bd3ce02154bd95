"""The one loop from problems to findings: each problem has a plan, a step of it proposes, and the checker decides."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, TypeVar, cast

from lure.analysis.certificates import codes
from lure.analysis.certificates.drafts import Failure, guarded
from lure.analysis.deadline import checkpoint, time_limit
from lure.analysis.inequality.gains import KALMAN
from lure.analysis.questions.advice import row_asked, serves
from lure.analysis.questions.channel_proofs import criteria_for
from lure.analysis.questions.channels import Factors, factor_steps
from lure.analysis.questions.channels import proposals as of_channels
from lure.analysis.questions.conclusion import Certification, conclusion_of
from lure.analysis.questions.counterexample_search import (
    counterexample,
    critical,
    hurwitz,
    linear_refutation,
    linear_witnesses,
    nonlinear_witnesses,
)
from lure.analysis.questions.largest import SoFar, StabilityBound, Stopped, meet
from lure.analysis.questions.problem import Problem
from lure.analysis.questions.proofs import (
    NOT_NEEDED,
    Proposal,
    criterion_answer,
    endless_proof,
    every_finite,
    open_parts,
    proposals,
    proved_answer,
    restated,
    silent,
)
from lure.analysis.theorems.table import BEST, LAST, Theorem, theorems_for
from lure.analysis.verdict import Bracket, Verdict, Witness
from lure.classes import NonlinearityClass
from lure.errors import AssumptionError, InputError, Reason
from lure.plants.delay import DelayPlant
from lure.plants.family import PlantFamily
from lure.plants.frequency_data import FrequencyData
from lure.plants.rational import RationalPlant
from lure.record import described, quantity

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Proved, Refuted
    from lure.analysis.certificates.proposals import Numbers

Tell = Callable[[str, float], None]
Bounds = Callable[[], list[StabilityBound]]
T = TypeVar("T")
GRACE = 1.0  # [s] to say what was found, when the time for the search is over
_COUNTER, _AFTER = 3, LAST + 1  # the stages of the searches for nonlinear counterexamples, of one class beside others
_ENOUGH = "what is proved and what is refuted meet without it"
_LESS = "another criterion has proved more than this one claims"


@described(slots=True, kw_only=True)
class Findings(SoFar):
    """What was found about a largest class."""

    hurwitz: Bracket = quantity(
        "Supremum of the ``k`` for which the linear gains in ``[lower, k]`` are stable; ``[lower, inf]`` until known"
    )
    critical: bool = quantity(
        "Whether the loop has a pole at 0 with the least gain; True, the weaker conclusion, until known", default=True
    )
    witnesses: list[Witness] = quantity("Destabilising members found so far", default_factory=list)

    @property
    def empty(self) -> bool:
        """Whether nothing was found."""
        return not self.answers and not self.witnesses

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
        return meet(self.proved, self.refuted, self.asked.lower)


@described(slots=True)
class Attempts:
    """What was tried for one class so far."""

    asked: Problem = quantity("The question")
    failures: list[Failure] = quantity(
        "The proposals that showed nothing, in the order they were made", default_factory=list
    )
    certification: Certification | None = quantity(
        "What follows from the first one that the checker accepted and that is about the class", default=None
    )
    stopped: bool = quantity(
        "Whether no further proposal is made, because the time is over or the search broke down", default=False
    )

    @property
    def closed(self) -> bool:
        """Whether nothing more is to be tried."""
        return self.stopped or self.certification is not None


Found = Findings | Factors | Attempts


@dataclass(frozen=True, slots=True)
class Step:
    """One piece of work for one problem."""

    stage: int
    name: str
    findings: Found
    work: Callable[[], None]


def search_for(  # noqa: PLR0913  (what a search is about, and how long and how far it goes)
    found: Sequence[Found],
    bounds: Bounds,
    *,
    seconds: float | None,
    numbers: Numbers,
    tell: Tell | None,
    brief: bool = False,
) -> None:
    """Make the steps of all plans, stage by stage, the first problem first in each, and write down what is found.

    Parameters
    ----------
    found : sequence of Findings, Factors or Attempts
        Of problems about one plant, empty; what they have in common is computed once.
    bounds : callable
        What follows for the largest classes once their steps are made; asked for one class beside them.
    seconds : float or None
        Time allowed.  One class beside largest ones is given a second more, to be decided by what was found for those.
    numbers : str
        Where the numbers came from, for certificates of one class.
    tell : callable, optional
        Told each step and the share of the steps behind it, 0 where that is not known.
    brief : bool
        Whether what a criterion claims of a largest class is left unproved where another has proved more.

    Raises
    ------
    AssumptionError
        A problem is no good, whatever the time.
    InputError
        The same; or a gain or a frequency exceeds the range of doubles.
    KeyboardInterrupt
        The user stopped the search before anything was found.
    """
    shared, beside = _Shared(brief=brief), not all(isinstance(each, Attempts) for each in found)
    plans, most = list[Iterator[Step]](), 0
    for each in found:
        if isinstance(each, Attempts):
            plans.append(_one_class(each, bounds if beside else None, numbers))
            most += beside
        elif isinstance(each, Factors):
            factors = [one for one in found if isinstance(one, Factors)]
            plans.append(_largest_factor(each, factors[: factors.index(each)]))
            most += len(criteria_for(each.asked)) + 2
        else:
            asking = _theorems(each.asked)
            plans.append(_largest_class(each, asking, shared))
            most += len(asking) + 3
    steps = enumerate(heapq.merge(*plans, key=lambda step: step.stage))
    try:
        for allowed, late in ((seconds, [each for each in found if not isinstance(each, Attempts)]), (GRACE, [])):
            try:
                with time_limit(allowed):
                    for number, step in steps:
                        _make(step, min(number / most, 1.0) if most else 0.0, tell)
                return
            except TimeoutError:
                _stop(late or found, "time")
    except OverflowError:
        raise InputError(
            f"a gain or frequency of {found[0].asked.plant} exceeds the range of doubles, 1e-308 to 1e308; rescale the "
            "units",
            code=Reason.RANGE,
        ) from None
    except KeyboardInterrupt:
        if all(isinstance(each, Attempts) or each.empty for each in found):
            raise
        _stop(found, "interrupt")


def _make(step: Step, done: float, tell: Tell | None) -> None:
    """One step, unless the search for its problem was stopped."""
    if step.findings.stopped:
        return
    checkpoint()
    if tell is not None:
        tell(f"{_title(step.findings.asked)}{step.name}", done)
    try:
        step.work()
    except ModuleNotFoundError as missing:
        assert not isinstance(step.findings, Attempts), "of one class every failure is kept"
        step.findings.left_out += f"{step.name} left out: {missing}; "


def _stop(found: Sequence[Found], why: Stopped) -> None:
    for each in found:
        if not isinstance(each, Attempts):
            each.stopped = None if each.complete or each.closed else why
        elif not each.closed:
            each.stopped = True
            detail = "the time allowed is over" if why == "time" else "interrupted"
            each.failures.append(Failure(search="the search", code=codes.OUT_OF_TIME, detail=detail))


def _theorems(asked: Problem) -> list[Theorem]:
    asking = theorems_for(asked.plant, asked.question, asked.criterion, odd=asked.odd, time_varying=asked.time_varying)
    if not asking:
        raise AssumptionError(f"no criterion called {asked.criterion} applies to this block; try {BEST}")
    return asking


def _title(asked: Problem) -> str:
    if asked.kind == "class" or asked.several:
        return ""
    if asked.question == "sector":
        return "sector, time-varying: " if asked.time_varying else "sector: "
    return "slope, odd: " if asked.odd else "slope: "


class _Shared:
    """Results that several questions about one block have in common, each computed once."""

    def __init__(self, *, brief: bool) -> None:
        self.brief = brief
        self._known: dict[Hashable, object] = {}
        # how far a class of restricted slope is proved, over its lower end and whether it is one of odd ones
        self.slopes: dict[tuple[Fraction, bool], float] = {}

    def once(self, key: Hashable, compute: Callable[[], T]) -> T:
        """The result of that name, computed if it is not known."""
        if key not in self._known:
            self._known[key] = compute()
        return cast("T", self._known[key])


# A largest class: criteria and searches for counterexamples, as long as what is proved and what is refuted do not meet.


def _largest_class(found: Findings, asking: Sequence[Theorem], shared: _Shared) -> Iterator[Step]:
    """The plan, in ascending stages; what a closed gap makes needless is left out."""
    asked = found.asked
    yield Step(0, "linear gains", found, lambda: _linear(found, shared))
    searches = [Step(_COUNTER, "counterexamples", found, lambda: _counterexamples(found, shared))]
    full = asked.search == "full"
    rows = [Step(row.stage, row.name, found, partial(_criterion, found, row, shared)) for row in asking]
    late = full or asked.criterion != BEST or asked.time_varying
    rows = [step for step in rows if late or step.stage < LAST]
    if shared.brief:  # what reaches farthest comes last in each stage
        rows = sorted(reversed(rows), key=lambda step: step.stage)
    for step in heapq.merge(rows, searches if full else [], key=lambda step: step.stage):
        if step.stage == 0 or not found.closed:
            yield step
        elif step.stage != _COUNTER:
            found.answers.append(silent(step.name, asked, _ENOUGH, theorem=NOT_NEEDED))
    if shared.brief:
        names = [row.name for row in asking]
        found.answers.sort(key=lambda answer: names.index(answer.criterion))
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
    if shared.brief and guarded(row.name, partial(_falls_short, row, found), passing=(TimeoutError,)) is True:
        found.answers.append(silent(row.name, asked, _LESS, theorem=NOT_NEEDED))
        return
    said = shared.once(key, lambda: criterion_answer(row, asked))
    if isinstance(said, Failure):
        found.answers.append(silent(row.name, asked, said.detail, code=said.code.reason))
        return
    if shared.brief and said.largest.low < found.proved:
        found.answers.append(silent(row.name, asked, _LESS, theorem=NOT_NEEDED))
        return
    wider = asked.time_varying and not said.nonlinearity_class.time_varying
    said = shared.once((*key, wider), partial(proved_answer, asked, said))
    found.answers.append(said)
    if asked.question == "slope" and said.verdict is Verdict.PROVED:
        kind = asked.lower, asked.odd
        shared.slopes[kind] = max(shared.slopes.get(kind, -math.inf), said.largest.low)


def _falls_short(row: Theorem, found: Findings) -> bool:
    """Whether a quick test shows that a criterion claims less than what is proved."""
    return not row.may_reach(found.asked.block, found.proved, lower=found.asked.lower)


def _counterexamples(found: Findings, shared: _Shared) -> None:
    """Nonlinear members of the class, unless it is known that there are none of the kind looked for.

    In continuous time the nonlinearities tried for time-invariant classes are of restricted slope, and odd up to order
    3 (see :mod:`lure.analysis.counterexamples.oscillation`): none is unstable below what is proved of those.
    """
    asked = found.asked
    if isinstance(asked.plant, RationalPlant) and asked.plant.dt is None and not asked.time_varying:
        kinds = (False, True) if asked.odd or asked.plant.order <= KALMAN else (False,)
        known = max(shared.slopes.get((asked.lower, odd), -math.inf) for odd in kinds)
        if meet(known, found.refuted, asked.lower):
            return
    found.witnesses += nonlinear_witnesses(asked)


def _largest_factor(found: Factors, earlier: Sequence[Factors]) -> Iterator[Step]:
    """The plan for several channels, one question after the other."""
    yield from (Step(0, name, found, work) for name, work in factor_steps(found, earlier))


# One class: what is proposed, until the checker accepts a certificate from which something follows for it.

Accepted = Callable[[], "Proved | Refuted | Failure | None"]


def _one_class(found: Attempts, bounds: Bounds | None, numbers: Numbers) -> Iterator[Step]:
    """The plan: what was accepted for largest classes, where there are such, or else searches of its own."""
    asked, stage = found.asked, 0 if bounds is None else _AFTER
    if bounds is not None:
        known = _known_of_channels if asked.several else _known
        yield Step(stage, "what was accepted for the largest classes", found, partial(known, found, bounds))
        if asked.several or not (asked.endless_below or _apart(asked.nonlinearity_class)):
            return
    for name, propose in _of_channels(asked, ()) if asked.several else _own(asked, numbers):
        if found.closed:
            return
        yield Step(stage, name, found, partial(_try, found, name, propose))


def _apart(asked: NonlinearityClass) -> bool:
    """Whether the slope bounds are not those of the sector, as they are of the largest classes."""
    ends = [(bounds.lower, bounds.upper) for bounds in (asked.sector, asked.slope) if bounds is not None]
    return ends[0] != ends[-1]


def _known_of_channels(found: Attempts, bounds: Bounds) -> None:
    """What was accepted for largest factors, and what the same criteria show of the factor 1."""
    for name, propose in _of_channels(found.asked, bounds()):
        if not found.closed:
            _try(found, name, propose)


def _of_channels(asked: Problem, rows: Sequence[StabilityBound]) -> Iterator[Proposal]:
    """Searches for these classes of several channels, and what was accepted for largest factors."""
    found = guarded("criteria", lambda: list(of_channels(asked, rows)))
    yield from [("criteria", lambda: found)] if isinstance(found, Failure) else found


def _own(asked: Problem, numbers: Numbers) -> Iterator[Proposal]:
    """Searches for this class, cheap ones first."""
    if isinstance(asked.plant, FrequencyData):
        return
    yield "linear gains", lambda: linear_refutation(asked, numbers)
    proposed = guarded("criteria", lambda: proposals(asked, numbers))
    cheap, dear = ([("criteria", lambda: proposed)], []) if isinstance(proposed, Failure) else proposed
    yield from cheap
    jumps = isinstance(asked.plant, DelayPlant) and asked.time_varying
    if (jumps or isinstance(asked.plant, RationalPlant | PlantFamily)) and asked.criterion == asked.method == BEST:
        yield "counterexamples", lambda: counterexample(asked, numbers)
    yield from dear
    if isinstance(asked.plant, PlantFamily) and asked.provable and asked.criterion == asked.method == BEST:
        yield "parts of the box", lambda: open_parts(asked)
    if asked.provable and not asked.finite and asked.nonlinearity_class.sector.upper == math.inf:
        yield "every finite bound", lambda: every_finite(asked)


def _try(
    found: Attempts, name: str, propose: Accepted, *, larger: Proved | None = None, beside: Refuted | None = None
) -> None:
    """One proposal: the answer, if the checker accepts it and something follows from it for the class; else a failure.

    Whatever happens in a search ends as a failure with a code; where the time is over, or what was accepted does not
    fit the question at all, the last one.
    """
    failure = shown = guarded(name, propose)
    if shown is not None and not isinstance(shown, Failure):
        follows = guarded(name, lambda: conclusion_of(found.asked, shown, larger=larger, beside=beside))
        if isinstance(follows, Failure):
            found.stopped, failure = True, follows
        elif follows.shown is not None:
            found.certification = Certification(conclusion=follows, detail=shown.claim, failures=tuple(found.failures))
            return
        else:
            failure = Failure(search=name, code=follows.code or codes.REJECTED, detail=follows.reason)
    if isinstance(failure, Failure):
        found.failures.append(failure)
        found.stopped = found.stopped or failure.code is codes.OUT_OF_TIME


def _known(found: Attempts, bounds: Bounds) -> None:
    """What was accepted for largest classes, of the one of this kind first; whether it fits is judged here."""
    asked, rows = found.asked, bounds()
    first = row_asked(rows, asked.nonlinearity_class)
    ordered = sorted(rows, key=lambda row: row is not first)
    for proof in _proofs(asked, ordered):
        if not found.closed:
            _try(found, proof.theorem, partial(restated, proof, asked), larger=proof)
    for row in ordered:
        for refuted, beside in pairwise((*row.refutations, None)):
            if not found.closed:
                _try(found, "counterexamples", partial(restated, cast("Refuted", refuted), asked), beside=beside)


def _proofs(asked: Problem, rows: list[StabilityBound]) -> Iterator[Proved]:
    """What was accepted of the rows that may serve; without an upper bound also what covers those beyond every one."""
    wanted = asked.nonlinearity_class
    for row in rows:
        end = wanted.slope.upper if row.question == "slope" and wanted.slope else wanted.sector.upper
        if row.proof is None or not serves(row, wanted) or row.largest.low < end:
            continue
        endless = endless_proof(asked, row.lower) if end == math.inf else None
        yield from (proof for proof in (endless, row.proof) if proof is not None)
