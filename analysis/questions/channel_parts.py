"""Loops side by side: channels of a plant that do not interact, answered as the loops that they are.

A solution of the whole is one of each loop at the same time, a repeated nonlinearity included: all of them are stable
if and only if each is, and the largest factor is the least of theirs.  Each is asked by the pipeline for such a loop,
that of one channel where its class is one of these, and what was accepted of them becomes one certificate.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any, NamedTuple, cast

from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.checker import OTHERS, Proved, Refuted
from lure.analysis.certificates.drafts import checked, guarded
from lure.analysis.certificates.systems import class_entry
from lure.analysis.inequality.checks import require_solution
from lure.analysis.inequality.shifted_loop import LARGEST
from lure.analysis.numerics.doubles import bound_below, double_above, double_below
from lure.analysis.questions.channel_refutations import constant_gains, refutation
from lure.analysis.questions.channels import channel_bound
from lure.analysis.questions.conclusion import Certification, conclusion_of, undecided
from lure.analysis.questions.largest import StabilityBound, Stopped
from lure.analysis.questions.problem import Problem, by_matrices, certifiable
from lure.analysis.theorems.table import BEST, Question
from lure.analysis.verdict import Bracket, CriterionResult, Evidence, Verdict
from lure.classes import DELAYS, SCALAR, Diagonal, NonlinearityClass
from lure.errors import AssumptionError, InputError
from lure.plants.delay_matrix import DelayMatrix
from lure.plants.multivariable import MultivariablePlant, Rows
from lure.plants.rational import RationalPlant

Answered = StabilityBound | Certification
Ask = Callable[[Sequence[Problem], float | None, Callable[[str, float], None]], list[Answered]]
PARTS = "parts"
_TITLE = "loops side by side, each by itself"
_BEYOND = (
    Fraction(0),
    Fraction(1, 2**40),
    Fraction(1, 2**30),
    Fraction(1, 2**20),
)  # a gain with other equilibria alone
_LEAST = 1e-2  # [s] for a part when the time is over


class Part(NamedTuple):
    """Channels and states that no others touch, counted from 0."""

    channels: tuple[int, ...]
    states: tuple[int, ...]

    @property
    def words(self) -> str:
        """The channels as they are counted."""
        return f"channel{'s' * (len(self.channels) > 1)} {', '.join(str(i + 1) for i in self.channels)}"

    @property
    def place(self) -> dict[str, Any]:
        """As in a certificate."""
        return {"channels": [i + 1 for i in self.channels], "states": [i + 1 for i in self.states]}


def parts_of(problems: Sequence[Problem]) -> list[Part]:
    """The loops side by side of which a plant consists; none where it is one, or they are not asked about apart.

    Operators that act on several channels together join these.  Of ReLUs, whose classes of different factors do not
    contain one another, no largest factor is the least of several.

    Parameters
    ----------
    problems : sequence of Problem
        Questions about one plant.
    """
    first = problems[0].plant
    if not isinstance(first, MultivariablePlant | DelayMatrix):
        return []
    for one in problems:
        factors = one.kind != "class" and one.classes.rectified
        if one.plant is not first or (one.criterion, one.method) != (BEST, BEST) or factors or one.classes.performance:
            return []
    base, n, m = first.base if isinstance(first, DelayMatrix) else first, first.order, first.inputs
    late = [*first.late] if isinstance(first, DelayMatrix) else []
    inner = [*first.inner] if isinstance(first, DelayMatrix) else []
    sides = [(base.A, 0, 0), (base.B, 0, n), (base.C, n, 0), (base.D, n, n)]
    sides += [(C, n, 0) for _, C in late] + [(A, 0, 0) for A in inner]
    group = [*range(n + m)]  # states, then channels: the least of those that each is joined to

    def join(i: int, j: int) -> None:
        """Make one of two groups."""
        low, high = sorted((group[i], group[j]))
        group[:] = [low if one == high else one for one in group]

    for rows, down, right in sides:
        for i, row in enumerate(rows):
            for j in (j for j, v in enumerate(row) if v):
                join(down + i, right + j)
    for block in (block for one in problems for block in one.classes.operators):
        if problems[0].classes.classes[block[0]].operator not in (SCALAR, *DELAYS):
            for i in block[1:]:
                join(n + block[0], n + i)
    whole = [one for one in dict.fromkeys(group) if one in group[:n] and one in group[n:]]
    for one in {*group} - {*whole}:  # modes without a channel, channels without a state
        group[:] = [whole[0] if whole and each == one else each for each in group]
    found = [
        Part(*(tuple(i for i, g in enumerate(side) if g == one) for side in (group[n:], group[:n]))) for one in whole
    ]
    return sorted(found) if len(found) > 1 else []


def in_parts(
    problems: Sequence[Problem],
    parts: Sequence[Part],
    ask: Ask,
    seconds: float | None,
    progress: Callable[[str, float], None] | None,
) -> list[Answered] | None:
    """The answers to problems about loops side by side; None where a loop is refused, or nothing fits together.

    Parameters
    ----------
    problems : sequence of Problem
        The problems.
    parts : sequence of Part
        What :func:`parts_of` says of them.
    ask : callable
        Answers problems about one loop, in so many seconds, and tells each step.
    seconds : float or None
        Time allowed.
    progress : callable, optional
        Told each step and the share of the steps behind it.

    Raises
    ------
    ContradictionError
        What is proved and what is refuted overlap: a bug.
    """
    begun, tell, known, found = time.monotonic(), progress or (lambda _step, _done: None), {}, list[_Loop]()
    for k, part in enumerate(parts):
        left = None if seconds is None else (seconds - time.monotonic() + begun) / (len(parts) - k)

        def told(step: str, done: float, k: int = k, part: Part = part) -> None:
            """A step of this part."""
            tell(f"{part.words}: {step}", (k + done) / len(parts))

        try:
            asked = [_alone(one, part) for one in problems]
            key = tuple(one.text for one in asked)
            if key not in known:
                known[key] = _answers(asked, ask, None if left is None else max(left, _LEAST), told)
        except (AssumptionError, InputError):
            return None
        found.append(_Loop(part, asked, known[key], lambda one: ask([one], _left(begun, seconds), tell)[0]))
        if all(said.verdict is Verdict.REFUTED for said in known[key]):
            break  # of the others nothing more follows
    answers = [_whole(one, [loop.at(i) for loop in found]) for i, one in enumerate(problems)]
    return None if None in answers else cast("list[Answered]", answers)


def _left(begun: float, seconds: float | None) -> float | None:
    return None if seconds is None else max(seconds - time.monotonic() + begun, _LEAST)


def _answers(
    asked: Sequence[Problem], ask: Ask, seconds: float | None, tell: Callable[[str, float], None]
) -> list[Answered]:
    """Those of one channel and those of a list of classes apart, which say nothing of one another."""
    found = dict[int, Answered]()
    for several in (False, True):
        own = [i for i, one in enumerate(asked) if one.several is several]
        found |= zip(own, ask([asked[i] for i in own], seconds, tell), strict=True) if own else []
    return [found[i] for i in range(len(asked))]


# A part as a loop of its own.


def _alone(problem: Problem, part: Part) -> Problem:
    """The question about one part: about one channel where its class is one that is asked about there."""
    classes = [problem.classes.classes[i] for i in part.channels]
    plant = _plant(problem.plant, part)
    one = classes[0]
    if len(classes) == 1 and _is_plain(one) and _is_scalar(plant):
        entry = plant.channel(0, 0)
        block = (by_matrices(entry) or entry) if isinstance(entry, RationalPlant) else entry
        if problem.kind == "class":
            return replace(Problem.about(certifiable(block), one), name=problem.name)
        lower = Fraction((one.slope or one.sector).lower)
        if isinstance(block, RationalPlant):
            require_solution(block, lower)
        kind: Question = "sector" if one.slope is None else "slope"
        return Problem.largest(block, kind, lower=lower, odd=one.odd, time_varying=one.time_varying)
    sizes = [size for block in problem.classes.blocks if (size := len({*block} & {*part.channels}))]
    return replace(problem, plant=plant, classes=Diagonal(tuple(classes), repeated=tuple(sizes)), known=())


def _is_plain(one: NonlinearityClass) -> bool:
    """Whether the class is one of those whose largest is asked about one channel."""
    if one.linear or one.rectifier or one.memory or one.operator or one.gains[1] <= max(one.gains[0], 0):
        return False
    if one.slope is None:
        return not one.odd
    return not one.time_varying and (one.slope.lower, one.slope.upper) == (one.sector.lower, one.sector.upper)


def _is_scalar(plant: object) -> bool:
    """Whether the plant is one of one channel: with dead times strictly proper, none inside a feedback."""
    return not isinstance(plant, DelayMatrix) or not (plant.inner or any(map(any, plant.base.D)))


def _plant(plant: object, part: Part) -> MultivariablePlant | DelayMatrix:
    """The plant of a part."""

    def cut(rows: Rows, left: Sequence[int], right: Sequence[int]) -> Rows:
        """Some rows and columns."""
        return tuple(tuple(rows[i][j] for j in right) for i in left)

    assert isinstance(plant, MultivariablePlant | DelayMatrix), "asked of such plants"
    base, (own, x) = plant.base if isinstance(plant, DelayMatrix) else plant, part
    names = tuple(base.names[i] for i in own) if base.names else ()
    sides = cut(base.A, x, x), cut(base.B, x, own), cut(base.C, own, x), cut(base.D, own, own)
    found = MultivariablePlant(*sides, base.dt, names)
    if not isinstance(plant, DelayMatrix):
        return found
    inner = [cut(rows, x, x) for rows in plant.inner] or [()] * len(plant.late)
    late = [(tau, cut(rows, own, x), back) for (tau, rows), back in zip(plant.late, inner, strict=True)]
    late = [one for one in late if any(map(any, one[1])) or any(map(any, one[2]))]
    back = tuple(one[2] for one in late) if plant.inner else ()
    return DelayMatrix(found, tuple((tau, rows) for tau, rows, _ in late), back) if late else found


# What was accepted of the parts, as one certificate.


class _Loop(NamedTuple):
    """A part with the questions about it and their answers."""

    part: Part
    asked: list[Problem]
    answers: list[Answered]
    again: Callable[[Problem], Answered]

    def at(self, i: int) -> _Answer:
        """Of one question."""
        return _Answer(self.part, self.asked[i], self.answers[i], self.again)


class _Answer(NamedTuple):
    """The answer to a question about one part."""

    part: Part
    asked: Problem
    said: Answered
    again: Callable[[Problem], Answered]

    def factor(self, end: float | None, whole: Problem) -> Fraction | None:
        """The factor of the upper bounds that an end of the largest class is; None for no end."""
        if end is None or math.isinf(end):
            return None
        if self.asked.several:
            return Fraction(end)
        one = whole.classes.classes[self.part.channels[0]]
        return Fraction(end) / Fraction(one.gains[1])

    def proved(self, alpha: Fraction, whole: Problem) -> Proved | None:
        """What is accepted for the classes of a factor, or what was for larger ones; None where nothing was."""
        shown = self.said.proof if isinstance(self.said, StabilityBound) else self.said.shown
        if not isinstance(shown, Proved):
            return None
        if isinstance(self.said, Certification):
            return shown
        classes = whole.classes.scaled(alpha).classes
        own = [class_entry(classes[i], unbounded=False) for i in self.part.channels]
        laws = {**self.asked.class_entry, "channels": own} if self.asked.several else own[0]
        try:
            return cast("Proved", checked({**shown.certificate, "laws": laws}))
        except (Rejected, Malformed):
            pass
        exactly = _alone(replace(whole.scaled(alpha), kind="class", known=()), self.part)
        found = guarded(self.part.words, lambda: self.again(exactly), passing=(TimeoutError,))
        return found.shown if isinstance(found, Certification) and isinstance(found.shown, Proved) else shown


def _whole(problem: Problem, parts: Sequence[_Answer]) -> Answered | None:
    """The answer to a question, from those about its parts; None where what was accepted of them does not add up."""
    return _class(problem, parts) if problem.kind == "class" else _largest(problem, parts)


def _class(problem: Problem, parts: Sequence[_Answer]) -> Certification | None:
    said = [(one, cast("Certification", one.said)) for one in parts]
    against = next((one for one, found in said if found.verdict is Verdict.REFUTED), None)
    if against is not None:
        refuted = _refuted(problem, against, cast("Refuted", against.said.conclusion.shown), Fraction(1))
        follows = None if refuted is None else conclusion_of(problem, refuted[1])
        if follows is None or follows.shown is None or refuted is None:
            return None
        return Certification(conclusion=follows, detail=refuted[1].claim)
    open_ = [(one, found) for one, found in said if found.verdict is not Verdict.PROVED]
    failures = tuple(
        replace(each, search=f"{one.part.words}: {each.search}") for one, found in open_ for each in found.failures
    )
    if open_:
        one, found = open_[0]
        detail = f"{one.part.words}: {found.detail}"
        code = found.conclusion.code
        follows = undecided(problem, detail) if code is None else undecided(problem, detail, code=code)
        return Certification(conclusion=follows, detail=detail, failures=failures)
    proof = _proof(problem, parts, Fraction(1))
    if proof is None:
        return None
    return Certification(conclusion=conclusion_of(problem, proof), detail=proof.claim)


def _largest(problem: Problem, parts: Sequence[_Answer]) -> StabilityBound | None:
    said = [(one, cast("StabilityBound", one.said)) for one in parts]
    stopped: Stopped | None = next((found.stopped for _, found in said if found.stopped is not None), None)
    open_ = [(one, found) for one, found in said if found.verdict is not Verdict.PROVED]
    reason = f"{open_[0][0].part.words}: {open_[0][1].reason}" if open_ else ""
    against = _smallest(problem, parts)
    proof, answers = None, list[CriterionResult]()
    factors = [one.factor(found.largest.low, problem) for one, found in said]
    alpha = min((double_below(v) for v in factors if v is not None), default=LARGEST)
    if not open_ and alpha <= problem.classes.least:
        reason = "what is proved ends where the upper bound of a channel is not above its lower one"
    elif not open_:
        shown = _proof(problem, parts, Fraction(alpha))
        if shown is None:
            return None
        proof, classes = (Fraction(alpha), shown), problem.classes.scaled(Fraction(alpha))
        answers = [
            CriterionResult(
                criterion=PARTS,
                theorem=_TITLE,
                largest=Bracket(alpha, math.inf),
                nonlinearity_class=classes.classes[0],
                classes=classes,
                verdict=Verdict.PROVED,
                evidence=Evidence.CERTIFIED,
                parameters={one.part.words: f"{found.criterion}: {found.proved_text}" for one, found in said},
                reason=f"proved for the upper bounds times {bound_below(alpha)}",
                hypotheses=tuple(f"{name}: {how}" for name, how in shown.facts.items() if name != "class"),
                shown=shown,
            )
        ]
    bound = channel_bound(problem, proof, against, answers, reason=reason, stopped=stopped)
    return replace(bound, critical=proof is not None and any(found.critical for _, found in said))


def _smallest(problem: Problem, parts: Sequence[_Answer]) -> tuple[Fraction, Refuted] | None:
    """The smallest factor at which a part is refuted, and what refutes all of it; 0 where every factor is."""
    found = list[tuple[Fraction, _Answer, Refuted]]()
    for one in parts:
        said = cast("StabilityBound", one.said)
        alpha = one.factor(said.refuted_at, problem)
        shown = None if said.witness is None else said.witness.refutation
        if said.trivial is not None and said.trivial.refutation is not None:
            shown = said.trivial.refutation
        if alpha is None or shown is None:
            continue
        never = not one.asked.several and Fraction(said.refuted_at or 0) <= one.asked.lower
        found.append((Fraction(0) if never or alpha <= problem.classes.least else alpha, one, shown))
    for alpha, one, shown in sorted(found, key=lambda each: each[0]):
        refuted = _refuted(problem, one, shown, Fraction(double_above(alpha)))
        if refuted is not None:
            return refuted
    return None


def _refuted(problem: Problem, one: _Answer, shown: Refuted, alpha: Fraction) -> tuple[Fraction, Refuted] | None:
    """A factor from there on, 0 for each, and what is accepted against the classes of the whole."""
    proof, kind = shown.certificate["proof"], shown.certificate["system"]["kind"]
    within = alpha or Fraction(1)
    constant = proof["method"] in ("linear-gain", "linear-gains") and "growth" not in proof
    if constant and isinstance(problem.plant, MultivariablePlant):
        own = [Fraction(g) for g in (proof["gains"] if "gains" in proof else [proof["gain"]])]
        for more in _BEYOND:
            gains = list(problem.classes.lower)
            for i, gain in zip(one.part.channels, own, strict=True):
                gains[i] = gain * (1 + more)
            factor = Fraction(double_above(within * (1 + more))) if problem.kind != "class" else within
            found = refutation(problem, factor, constant_gains(gains))
            if found is not None:
                return (factor if alpha else alpha), found
    lifted = {"method": "part", **one.part.place, "kind": kind, "proof": dict(proof)}
    found = refutation(problem, within, lifted)
    return None if found is None or found.certificate["conclusion"] == OTHERS else (alpha, found)


def _proof(problem: Problem, parts: Sequence[_Answer], alpha: Fraction) -> Proved | None:
    """One certificate of what was accepted of each part; None where the checker does not accept it."""
    laws, entries = dict[int, Mapping[str, Any]](), list[dict[str, Any]]()
    for one in parts:
        shown = one.proved(alpha, problem)
        if shown is None:
            return None
        certificate = shown.certificate
        own = certificate["laws"]["channels"] if "channels" in certificate["laws"] else [certificate["laws"]]
        laws |= zip(one.part.channels, own, strict=True)
        held = {name: certificate[name] for name in ("theorem", "multiplier", "proof")}
        entries.append({**one.part.place, "kind": certificate["system"]["kind"], **held})
    each = [laws[i] for i in range(len(laws))]
    draft = {
        "verdict": "PROVED",
        "system": problem.system,
        "laws": {"channels": each, "repeated": _repeated(problem.classes, each)},
        "theorem": PARTS,
        "proof": {"method": PARTS, "parts": entries},
    }
    found = guarded(PARTS, lambda: checked(draft), passing=(TimeoutError,))
    return found if isinstance(found, Proved) else None


def _repeated(classes: Diagonal, laws: Sequence[Mapping[str, Any]]) -> bool | list[int]:
    """How many channels in turn have the same nonlinearity, as far as what is shown of them is of one class."""

    def sizes() -> Iterator[int]:
        """Block by block."""
        for block in classes.blocks:
            same = all(laws[i] == laws[block[0]] for i in block)
            yield from [len(block)] if same else [1] * len(block)

    found = [*sizes()]
    if len(found) in (1, len(laws)):
        return len(found) == 1
    return found
