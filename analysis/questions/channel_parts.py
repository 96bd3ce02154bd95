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
from functools import partial
from typing import Any, NamedTuple, cast

from flint import fmpq_mat

from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.checker import Proved, Refuted
from lure.analysis.certificates.drafts import checked, guarded
from lure.analysis.certificates.systems import class_entry, texts
from lure.analysis.inequality.checks import require_solution
from lure.analysis.inequality.shifted_loop import LARGEST
from lure.analysis.inequality.zero_modes import exact
from lure.analysis.numerics.doubles import bound_below, double_above, double_below
from lure.analysis.questions.channel_hypotheses import is_critical
from lure.analysis.questions.channel_members import members_refuting
from lure.analysis.questions.channel_refutations import constant_gains, orbits_refuting, refutation, switching_refuting
from lure.analysis.questions.channels import channel_bound
from lure.analysis.questions.conclusion import Certification, conclusion_of, undecided
from lure.analysis.questions.largest import StabilityBound, Stopped
from lure.analysis.questions.problem import Problem, by_matrices, certifiable
from lure.analysis.theorems.table import BEST, Question
from lure.analysis.verdict import Bracket, CriterionResult, Evidence, Verdict
from lure.arrays import np
from lure.classes import DELAYS, SCALAR, Diagonal, NonlinearityClass
from lure.errors import AssumptionError, InputError
from lure.plants.delay_matrix import DelayMatrix
from lure.plants.multivariable import MultivariablePlant, Rows, rational_rows
from lure.plants.rational import RationalPlant

Answered = StabilityBound | Certification
Ask = Callable[[Sequence[Problem], float | None, Callable[[str, float], None]], list[Answered]]
PARTS = "parts"
CASCADE = "cascade"
_TITLES = {PARTS: "loops side by side, each by itself", CASCADE: "loops that drive one another in turn, each by itself"}
_MOST_TURNED = 30  # states
_BEYOND = (
    Fraction(0),
    Fraction(1, 2**40),
    Fraction(1, 2**30),
    Fraction(1, 2**20),
)  # a gain with other equilibria alone
_BEFORE, _AFTER = Fraction(99, 100), 4.0  # where a cascade is searched, relative to where a part of it is refuted
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


class Split(NamedTuple):
    """Loops of which a plant consists: side by side, or each driven by those before it.

    Attributes
    ----------
    parts : list of Part
        The loops, each after those that drive it; none where the plant is one loop.
    plant : MultivariablePlant or DelayMatrix
        The plant with the states of the parts, and without what drives them.
    theorem : str
        Of the certificate: ``parts`` or ``cascade``.
    basis : Rows or None
        ``S`` of ``x = S z`` where the states are not those of the plant.
    """

    parts: list[Part]
    plant: MultivariablePlant | DelayMatrix
    theorem: str = PARTS
    basis: Rows | None = None


def splits_of(problems: Sequence[Problem]) -> Iterator[Split]:
    """The ways in which a plant is taken apart: into a cascade, and into loops side by side; none where it is one loop.

    Operators that act on several channels together join these.  Of ReLUs, whose classes of different factors do not
    contain one another, no largest factor is the least of several.

    ``problems``: questions about one plant.
    """
    first = problems[0].plant
    if not isinstance(first, MultivariablePlant | DelayMatrix):
        return
    for one in problems:
        factors = one.kind != "class" and one.classes.rectified
        if one.plant is not first or (one.criterion, one.method) != (BEST, BEST) or factors or one.classes.performance:
            return
    blocks = [block for one in problems for block in one.classes.operators]
    joint = [[*b] for b in blocks if problems[0].classes.classes[b[0]].operator not in (SCALAR, *DELAYS)]
    apart = _grouped(first, joint, directed=False)
    if isinstance(first, MultivariablePlant):
        for plant, basis in _in_states(first, joint):
            found = _grouped(plant, joint, directed=True)
            alone = _undriven(plant, found) if len(found) > len(apart) else None
            if alone is not None and _may_be_driven(problems):
                yield Split(found, alone, CASCADE, basis)
                break
    if apart:
        yield Split(apart, first)


def _in_states(
    plant: MultivariablePlant, joint: Sequence[list[int]]
) -> Iterator[tuple[MultivariablePlant, Rows | None]]:
    """The plant as it is, and in states in which it may be a cascade."""
    yield plant, None
    groups = _drives(plant, joint)
    other, basis = turned(plant, groups) if len(groups) > 1 else (None, None)
    if other is not None:
        yield other, basis


def _may_be_driven(problems: Sequence[Problem]) -> bool:
    """Whether a cascade may be proved: no channel has memory, and no pole is 0 with the gains at the lower bounds."""
    return not any(each.memory for one in problems for each in one.classes.classes) and not is_critical(problems[0])


def _grouped(plant: MultivariablePlant | DelayMatrix, joint: Sequence[list[int]], *, directed: bool) -> list[Part]:
    """Parts of the states and channels that entries join: both ways, where they are ``directed``, else at all.

    In order of what drives what, and what is first in the plant; none where there is one.
    """
    base, n, m = plant.base if isinstance(plant, DelayMatrix) else plant, plant.order, plant.inputs
    sides = [(base.A, 0, 0), (base.B, 0, n), (base.C, n, 0), (base.D, n, n)]
    if isinstance(plant, DelayMatrix):
        sides += [(C, n, 0) for _, C in plant.late] + [(A, 0, 0) for A in plant.inner]
    seen = np.eye(n + m, dtype=bool)
    for rows, down, right in sides:
        for i, row in enumerate(rows):
            for j in (j for j, v in enumerate(row) if v):
                seen[down + i, right + j] = True
    for block in joint:
        seen[np.ix_([n + i for i in block], [n + i for i in block])] = True
    seen = seen if directed else seen | seen.T
    for _ in range((n + m).bit_length()):
        seen = (seen.astype(int) @ seen) > 0
    both = seen & seen.T  # row i sees column j: j drives i
    group = [int(np.flatnonzero(row)[0]) for row in both]
    order = sorted(dict.fromkeys(group), key=lambda g: (int(seen[g].sum()), g))
    whole = [g for g in order if any(x == g for x in group[:n]) and any(x == g for x in group[n:])]
    if not whole:
        return []
    for g in (g for g in order if g not in whole):  # modes without a channel, channels without a state
        before = [one for one in whole if seen[g, one]]
        home = before[-1] if before else next((one for one in whole if seen[one, g]), whole[0])
        group = [home if x == g else x for x in group]
    found = [Part(*(tuple(i for i, x in enumerate(side) if x == g) for side in (group[n:], group[:n]))) for g in whole]
    return found if len(found) > 1 else []


def _undriven(plant: MultivariablePlant, parts: Sequence[Part]) -> MultivariablePlant | None:
    """The plant without what parts do to others; None where that is not to later ones, or at once."""
    of = [{i: k for k, part in enumerate(parts) for i in part[side]} for side in (0, 1)]

    def kept(rows: Rows, left: int, right: int) -> Rows:
        """The entries within a part."""
        return tuple(tuple(v * (of[left][i] == of[right][j]) for j, v in enumerate(row)) for i, row in enumerate(rows))

    sides = kept(plant.A, 1, 1), kept(plant.B, 1, 0), kept(plant.C, 0, 1), kept(plant.D, 0, 0)
    return MultivariablePlant(*sides, plant.dt, plant.names) if plant.dt is not None or sides[3] == plant.D else None


def _drives(plant: MultivariablePlant, joint: Sequence[list[int]]) -> list[list[int]]:
    """Groups of channels by the transfer matrix, each after those that drive it; one where there is no such order."""
    m, n = plant.inputs, plant.order
    if n > _MOST_TURNED:
        return []
    A, B, C, D = (exact(side) for side in (plant.A, plant.B, plant.C, plant.D))
    seen, moved = np.eye(m, dtype=bool), B
    for term in range(n + 1):
        shown = D if not term else C * moved
        moved = A * moved if term else moved
        seen |= np.array([[shown[i, j] != 0 for j in range(m)] for i in range(m)])
    for block in joint:
        seen[np.ix_(block, block)] = True
    for _ in range(m.bit_length()):
        seen = (seen.astype(int) @ seen) > 0
    groups = [[*map(int, np.flatnonzero(row))] for row in seen & seen.T]
    return sorted(map(list, dict.fromkeys(map(tuple, groups))), key=lambda g: (int(seen[g[0]].sum()), g))


def turned(plant: MultivariablePlant, groups: Sequence[Sequence[int]]) -> tuple[MultivariablePlant | None, Rows | None]:
    """The plant in states ``z``, ``x = S z``, of which those that the last groups move come first, and ``S``.

    ``groups``: channels, each group after those that drive it.

    Returns
    -------
    (MultivariablePlant, Rows) or (None, None)
        None where some state is moved by no channel.
    """
    A, B, C = (exact(side) for side in (plant.A, plant.B, plant.C))
    kept = list[list[Any]]()
    for j in (j for group in reversed(groups) for j in group):
        row = fmpq_mat([[B[i, j] for i in range(plant.order)]])
        while fmpq_mat([*kept, *row.tolist()]).rank() > len(kept):
            kept += row.tolist()
            row = row * A.transpose()
    if len(kept) < plant.order:
        return None, None
    S = fmpq_mat(kept).transpose()
    back = S.inv()
    sides = [rational_rows(side) for side in (back * A * S, back * B, C * S)]
    return MultivariablePlant(sides[0], sides[1], sides[2], plant.D, plant.dt, plant.names), rational_rows(S)


def in_parts(
    problems: Sequence[Problem],
    split: Split,
    ask: Ask,
    seconds: float | None,
    progress: Callable[[str, float], None] | None,
) -> list[Answered] | None:
    """The answers to problems about loops side by side; None where a loop is refused, or nothing fits together.

    Parameters
    ----------
    problems : sequence of Problem
        The problems.
    split : Split
        What :func:`splits_of` says of them.
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
    parts = split.parts
    for k, part in enumerate(parts):
        left = None if seconds is None else (seconds - time.monotonic() + begun) / (len(parts) - k)

        def told(step: str, done: float, k: int = k, part: Part = part) -> None:
            """A step of this part."""
            tell(f"{part.words}: {step}", (k + done) / len(parts))

        try:
            asked = [_alone(one, part, split) for one in problems]
            key = tuple(one.text for one in asked)
            if key not in known:
                known[key] = _answers(asked, ask, None if left is None else max(left, _LEAST), told)
        except (AssumptionError, InputError):
            return None
        found.append(_Loop(part, split, asked, known[key], lambda one: ask([one], _left(begun, seconds), tell)[0]))
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


def _alone(problem: Problem, part: Part, split: Split) -> Problem:
    """The question about one part: about one channel where its class is one that is asked about there."""
    classes = [problem.classes.classes[i] for i in part.channels]
    plant = _plant(split.plant, part)
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
    return not isinstance(plant, DelayMatrix) or not (plant.inner or plant.rates or any(map(any, plant.base.D)))


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
    split: Split
    asked: list[Problem]
    answers: list[Answered]
    again: Callable[[Problem], Answered]

    def at(self, i: int) -> _Answer:
        """Of one question."""
        return _Answer(self.part, self.split, self.asked[i], self.answers[i], self.again)


class _Answer(NamedTuple):
    """The answer to a question about one part."""

    part: Part
    split: Split
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
        exactly = _alone(replace(whole.scaled(alpha), kind="class", known=()), self.part, self.split)
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
                criterion=parts[0].split.theorem,
                theorem=_TITLES[parts[0].split.theorem],
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
        search = partial(_driven, problem, Fraction(double_below(alpha)) * _BEFORE, double_above(alpha) * _AFTER)
        driven = guarded("members of a cascade", search) if one.split.theorem == CASCADE else None
        if isinstance(driven, tuple):
            return driven
    return None


def _driven(problem: Problem, known: Fraction, most: float) -> tuple[Fraction, Refuted] | None:
    """Members of the whole of a cascade that refute it near the factor of those of a part: constant ones first."""
    found = members_refuting(problem, most=math.inf)
    if found is not None and found[0] <= most:
        return found
    return switching_refuting(problem, known, most) or orbits_refuting(problem, known, most)


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
    if one.split.theorem == CASCADE:
        return None
    lifted = {"method": "part", **one.part.place, "kind": kind, "proof": dict(proof)}
    found = refutation(problem, within, lifted)
    return None if found is None else (alpha, found)


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
    each, split, S = [laws[i] for i in range(len(laws))], parts[0].split, parts[0].split.basis
    draft = {
        "verdict": "PROVED",
        "system": problem.system,
        "laws": {"channels": each, "repeated": _repeated(problem.classes, each)},
        "theorem": split.theorem,
        "proof": {"method": PARTS, "parts": entries} | ({"basis": [texts(row) for row in S]} if S else {}),
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
