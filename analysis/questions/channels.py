"""Several nonlinearities, one a channel: the largest factor of their classes that is proved, and one that is refuted.

Searches propose; what is said stands in a certificate that the checker accepted, about the plant and the classes asked
about, which are compared here before anything is worded.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import NamedTuple

from lure.analysis.certificates import codes
from lure.analysis.certificates.arithmetic import Rejected, eliminated
from lure.analysis.certificates.checker import Proved, Refuted
from lure.analysis.certificates.drafts import Failure, checked, contains, guarded
from lure.analysis.certificates.systems import class_entries
from lure.analysis.inequality.shifted_loop import LARGEST
from lure.analysis.numerics.doubles import bound_below, double_above, double_below
from lure.analysis.questions import channel_families
from lure.analysis.questions.channel_members import members_refuting, rays_refuting
from lure.analysis.questions.channel_problem import channel_plant, loop_plant
from lure.analysis.questions.channel_proofs import (
    KINDS,
    PARAMETRIC,
    STORED,
    Criterion,
    criteria_for,
    farthest,
    proved_whole,
)
from lure.analysis.questions.channel_refutations import (
    MEMBERS,
    RAMPS,
    RESTS,
    constant_gains,
    orbits_refuting,
    parameters_refuting,
    refutation,
    switching_refuting,
    unlimited,
    unsettled,
)
from lure.analysis.questions.conclusion import MismatchError, conclusion_of, undecided
from lure.analysis.questions.largest import SoFar, StabilityBound, Stopped
from lure.analysis.questions.problem import Problem
from lure.analysis.verdict import Bracket, CriterionResult, Evidence, Kind, Verdict, Witness
from lure.analysis.wording import counterexample, destroys, method_of, proviso
from lure.errors import AssumptionError, InputError, Reason
from lure.plants.channel_family import ChannelFamily
from lure.plants.delay_matrix import DelayMatrix
from lure.record import decimal_text, described, quantity

Tell = Callable[[str, float], None]
MOVING = ("switched-gains", "switched-gain", RAMPS, MEMBERS)
ORBITS = ("flow-orbit", "memory-orbit", "sampled-orbit", "orbit", RESTS)
RAY = "relu-ray"
_NO_MULTIPLIER = "no multiplier was found"
_MOST_ROUTH = 40  # states; beyond them exact arrays take a minute, and come after the criteria
_CLOSED, _NEAR = 1e-6, 1e-4  # relative: what is proved and what is refuted meet; rounding may leave so much
_RANGE = Fraction(10**140)  # of upper bounds: squares of a million times as much are doubles
_OPEN = 1e-2  # relative: a gap in which periodic solutions are searched for


def channel_bound(  # noqa: PLR0913  (what was found, and how the search ended)
    asked: Problem,
    proof: tuple[Fraction, Proved] | None,
    against: tuple[Fraction, Refuted] | None,
    answers: Sequence[CriterionResult] = (),
    *,
    reason: str = "",
    stopped: Stopped | None = None,
) -> StabilityBound:
    """The answer, from what the checker accepted, after it was compared with what was asked.

    Parameters
    ----------
    asked : Problem
        The question.
    proof, against : (Fraction, Proved) and (Fraction, Refuted), or None
        Factors, and what was accepted for the classes of those factors; 0 for gains in the classes of every factor.
    answers : sequence of CriterionResult
        Every criterion that was tried, that of the proof first.
    reason : str
        Why nothing more was shown.
    stopped : {"time", "interrupt"} or None
        What ended the search.

    Raises
    ------
    MismatchError
        A certificate is about another plant or other classes: a bug.
    ContradictionError
        What is proved and what is refuted overlap: a bug.
    """
    from lure.analysis.questions.answers import ContradictionError

    if proof is not None and against is not None and proof[0] >= against[0]:
        raise ContradictionError(f"the factor {proof[0]} is proved and {against[0]} refuted; please report the plant")
    never = against is not None and against[0] == 0
    low = 0.0 if proof is None else double_below(proof[0])
    high = None if against is None else double_above(against[0])
    jumps = against is not None and method_of(against[1]) in (*MOVING, *ORBITS)
    alone = asked.classes.rectified and not never  # ReLUs of other factors are other nonlinearities
    witness = None if against is None else _witness(against[1], double_above(against[0]))
    about = asked.scaled(Fraction(1) if proof is None else proof[0])
    told: tuple[Problem, Proved | Refuted | None] = (about, None if proof is None else proof[1])
    if never and against is not None:
        told = (asked, against[1])
    concluded = undecided(asked, reason) if told[1] is None else conclusion_of(*told)
    if (concluded.shown is None) != (told[1] is None):
        raise MismatchError(f"{concluded} Please report the plant")
    if against is not None and not never:
        beyond = conclusion_of(asked.scaled(against[0]), against[1])
        if beyond.verdict is not Verdict.REFUTED:
            raise MismatchError(f"{beyond} Please report the plant")
    limited = proof is not None and high is None and low > LARGEST / 8
    tried = [replace(one, search_limited=limited) for one in answers[:1]] + list(answers[1:])
    return StabilityBound(
        question="slope" if asked.kind == "slope" else "sector" if asked.kind == "sector" else asked.question,
        odd=asked.odd,
        time_varying=asked.time_varying,
        lower=Fraction(0),
        critical=proof is not None and "residue" in proof[1].facts,
        proviso="" if proof is None else proviso(proof[1]),
        criterion="" if proof is None else proof[1].theorem,
        largest=Bracket(low, math.inf if high is None or alone else max(low, high)),
        hurwitz=Bracket(
            0.0 if asked.classes.rectified else low, math.inf if high is None or jumps or alone else max(low, high)
        ),
        verdict=concluded.verdict,
        evidence=Evidence.CERTIFIED,
        theta=None,
        multiplier=None if not tried else tried[0].multiplier,
        parameters={} if not tried else tried[0].parameters,
        refuted_at=high,
        witness=witness,
        answers=tuple(tried),
        reason=reason,
        conclusion=concluded,
        stopped=stopped,
        classes=asked.classes,
    )


def _witness(shown: Refuted, factor: float) -> Witness:
    proof, at = shown.certificate["proof"], {}
    if proof["method"] == "member":
        named = zip(shown.certificate["system"]["parameters"], proof["at"], strict=True)
        proof, at = proof["proof"], {"parameters": {name: value for (name, *_), value in named}}
    if proof["method"] == "part":
        at, proof = {"channels": proof["channels"]}, proof["proof"]
    jumps, bends = (m := proof["method"]) in MOVING, m in ORBITS
    kinds: dict[str, Kind] = {RAMPS: "varying gain", "flow-orbit": "periodic orbit", "signal": "disturbance"}
    kinds |= {"delayed-gains": "delay", RAY: "ray", **dict.fromkeys(ORBITS, "periodic orbit"), RESTS: "equilibrium"}
    said = counterexample(shown)
    names = ["slopes", "inputs"] if m == "signal" else ["gains", "gain"]
    names = names if not bends else ["nonlinearities", "points", "gains", "state", "durations", "inputs", "u", "sigma"]
    return Witness(
        kind=kinds.get(m, "switched gain" if jumps else "linear gains"),
        k=factor,
        evidence=Evidence.CERTIFIED,
        slope_restricted=True,
        odd=not bends or bool(proof.get("half")),
        time_varying=jumps,
        description=f"a solution grows without bound, {said}" if m == RAY else f"{said} {destroys(shown)}",
        data=at | {name: proof[name] for name in names if name in proof},
        refutation=shown,
    )


def _answer(
    asked: Problem, criterion: Criterion, found: tuple[Fraction, Proved] | Failure | None, known: Fraction
) -> CriterionResult:
    """What one criterion shows of the classes, of which a factor is known before, beyond which it was asked."""
    if found is None or isinstance(found, Failure):
        beyond = f" that proves more than the factor {bound_below(known)}, which is proved" if known else ""
        return CriterionResult(
            criterion=criterion.name,
            theorem=criterion.row.title,
            largest=Bracket(0.0, math.inf),
            nonlinearity_class=asked.classes.classes[0],
            classes=asked.classes,
            verdict=Verdict.INCONCLUSIVE,
            evidence=Evidence.CERTIFIED,
            reason=_NO_MULTIPLIER + beyond if found is None else str(found.detail),
        )
    alpha, shown = found
    scaled = asked.classes.scaled(alpha)
    multiplier, row, (_, words, letter) = shown.certificate["multiplier"], criterion.row, KINDS[criterion.kind]
    return CriterionResult(
        criterion=criterion.name,
        theorem=row.title if row.linear else f"{row.title}, with {words}",
        largest=Bracket(double_below(alpha), math.inf),
        nonlinearity_class=scaled.classes[0],
        classes=scaled,
        verdict=Verdict.PROVED,
        evidence=Evidence.CERTIFIED,
        multiplier=None
        if row.linear
        else letter + " + s Theta" * (criterion.kind != STORED and any(map(Fraction, multiplier.get("theta", ())))),
        parameters=multiplier,
        reason=f"proved for the upper bounds times {bound_below(alpha)}",
        hypotheses=tuple(f"{name}: {how}" for name, how in shown.facts.items() if name != "class"),
        shown=shown,
    )


@described(slots=True)
class Factors(SoFar):
    """What was found about the largest factor."""

    against: tuple[Fraction, Refuted] | None = quantity("The smallest factor refuted, and by what", default=None)
    proofs: list[tuple[Fraction, Proved]] = quantity("The factors proved, and by what", default_factory=list)

    @property
    def closed(self) -> bool:
        """Whether nothing more is to be tried."""
        return self.complete

    @property
    def empty(self) -> bool:
        """Whether nothing was found."""
        return not self.proofs and self.against is None

    @property
    def known(self) -> Fraction:
        """The largest factor proved; 0 for none."""
        return max((factor for factor, _ in self.proofs), default=Fraction(0))

    @property
    def bound(self) -> StabilityBound:
        """What follows from it."""
        told = [one.reason for one in self.answers if one.verdict is not Verdict.PROVED]
        reason = "" if self.proofs else self.left_out + (told[-1] if told else "no criterion was asked")
        if self.stopped == "time" and not self.proofs:
            reason = f"the time allowed is over ({codes.OUT_OF_TIME.identifier})"
        answers = sorted(self.answers, key=lambda one: (one.verdict is not Verdict.PROVED, -one.largest.low))
        best = max(self.proofs, key=lambda one: one[0], default=None)
        return channel_bound(self.asked, best, self.against, answers, reason=reason, stopped=self.stopped)


def factor_steps(found: Factors, earlier: Sequence[Factors]) -> Iterator[tuple[str, Callable[[], None]]]:
    """The plan of one question: constant gains, then criteria while a gap is left, then switched gains.

    Parameters
    ----------
    found : Factors
        Of the question; each step writes down there what it finds.
    earlier : sequence of Factors
        Of questions about the same plant with steps before these: a proof of larger classes with the same bounds holds
        here too, and is searched for again only by criteria that see the difference.

    Raises
    ------
    InputError
        There is no such criterion, the loop is not well posed with the gains at the lower bounds, or an upper bound is
        not positive, so that no factor enlarges its class.
    """
    asked = found.asked
    if min(asked.classes.upper) <= 0 and asked.classes.performance is None:
        raise InputError("an upper bound is not positive; the largest factor is asked of classes with upper bounds > 0")
    require_well_posed(asked)
    before: StabilityBound | None = None
    criteria, said = criteria_for(asked), list[tuple[Fraction, Proved] | Failure | None]()
    family = isinstance(asked.plant, ChannelFamily)
    late = not family and loop_plant(asked.plant).order > _MOST_ROUTH

    def refute(name: str, search: Callable[[], tuple[Fraction, Refuted] | None]) -> None:
        """Make one search for a member; a failure leaves what was found before."""
        shown = guarded(name, search, passing=(TimeoutError,))
        found.against = shown if isinstance(shown, tuple) else found.against

    def gains() -> None:
        """Constant gains, or those that refute a larger question already."""
        nonlocal before
        rows = (each.bound for each in reversed(earlier) if each.complete)
        before = next((row for row in rows if _larger(row, asked)), None)
        with _left_to_criteria():
            found.against = None if late else _against(asked, before)
        if before is not None and (carried := _carried(asked, before)) is not None:
            found.proofs.append((carried.factor, carried.shown))
            found.answers.append(carried.answer)

    def ask(one: Criterion) -> None:
        """Ask one criterion for more than the factor that is known."""
        known = found.known
        said.append(guarded(one.name, partial(farthest, asked, one, known, most), passing=(TimeoutError,)))
        found.answers.append(_answer(asked, one, said[-1], known))
        if isinstance(said[-1], tuple):
            found.proofs.append(said[-1])

    yield "constant gains", gains
    if found.stopped is None and (found.against is None or found.against[0] != 0):
        most, kind = math.inf if found.against is None else float(found.against[0]), -1
        for one in criteria:
            enough = found.known >= most * (1 - (_NEAR if one.kind else _CLOSED))
            if one.kind == kind or enough or (before is not None and not _sees(one, asked, before)):
                continue
            yield one.name, partial(ask, one)
            if found.stopped is not None:
                return
            if isinstance(said[-1], tuple) and one.row.linear:
                break  # gains are decided as far as the boxes go
            if isinstance(said[-1], tuple) or (said[-1] is None and one.kind):
                kind = one.kind  # the others of this kind prove less
        if late:
            yield "constant gains", partial(refute, "constant gains", lambda: _against(asked, before))
            most = math.inf if found.against is None else float(found.against[0])
        if asked.classes.rectified and found.against is None:
            yield "rays of ReLUs", partial(refute, "rays of ReLUs", lambda: rays_refuting(asked, found.known))
        elif found.known < most * (1 - _NEAR):
            changing = parameters_refuting if family else switching_refuting
            yield "switched gains", partial(refute, "switched gains", lambda: changing(asked, found.known, most))
        most = math.inf if found.against is None else float(found.against[0])
        if found.known < most * (1 - _OPEN) and not family:
            yield (
                "periodic solutions",
                partial(refute, "periodic solutions", lambda: orbits_refuting(asked, found.known, most)),
            )
    found.complete = found.stopped is None


@contextmanager
def _left_to_criteria() -> Iterator[None]:
    """No search for gains where no theorem is for the classes: that is what the criteria then say."""
    try:
        yield
    except AssumptionError as error:
        if error.code is not Reason.NOT_APPLICABLE:
            raise


class _Carried(NamedTuple):
    """What was proved of larger classes, stated for these."""

    factor: Fraction
    shown: Proved
    answer: CriterionResult


def _carried(asked: Problem, before: StabilityBound) -> _Carried | None:
    """The proof of larger classes, stated for these where the checker accepts that."""
    if before.proof is None or before.classes is None:
        return None
    factor = Fraction(before.largest.low)
    draft = {**before.proof.certificate, "laws": asked.scaled(factor).class_entry}
    shown: Proved | Refuted = before.proof
    with suppress(Rejected):  # beside play and stop slopes may have another theorem than the sector that was proved
        shown = checked(draft)
    if not isinstance(shown, Proved):
        return None
    scaled = asked.classes.scaled(factor)
    found = replace(before.answers[0], nonlinearity_class=scaled.classes[0], classes=scaled, shown=shown)
    return _Carried(factor, shown, found)


def _sees(criterion: Criterion, asked: Problem, before: StabilityBound) -> bool:
    """Whether a criterion may prove more of these classes than it did of larger ones with the same bounds."""
    assert before.classes is not None, "of several channels"
    varying = [[one.time_varying for one in each.classes] for each in (asked.classes, before.classes)]
    row, tried = criterion.row, any(one.criterion == criterion.name for one in before.answers)
    return (
        row.slope
        or row.odd
        or not tried
        or (varying[0] != varying[1] and (not row.time_varying or criterion.kind == PARAMETRIC))
    )


def _against(asked: Problem, before: StabilityBound | None) -> tuple[Fraction, Refuted] | None:
    """Destabilising gains: those of the answer before, which lie in these classes too, else searched for."""
    shown = None if before is None else before.refutation
    if before is not None and before.classes is not None and before.classes.blocks == asked.classes.blocks:
        if shown is None:
            return None
        alpha = Fraction(before.refuted_at or 0)
        shown = refutation(asked, alpha or Fraction(1), shown.certificate["proof"])
        if shown is not None:
            return alpha, shown
    if isinstance(asked.plant, ChannelFamily):
        return channel_families.refuting(asked, partial(_against, before=None))
    gain = asked.classes.performance is not None and not asked.classes.rectified
    endless = unlimited(asked) if gain else None
    if endless is not None:
        return Fraction(0), endless
    return _at_once(asked) or members_refuting(asked, most=math.inf)


def _at_once(asked: Problem) -> tuple[Fraction, Refuted] | None:
    """What refutes the classes of every factor: the gains at the lower bounds, operators being 0 and delays none."""
    never = refutation(asked, Fraction(1), constant_gains(asked.classes.lower)) if unsettled(asked) else None
    return None if never is None else (Fraction(0), never)


def _larger(row: StabilityBound, asked: Problem) -> bool:
    """Whether the answer is complete and about classes that contain these, with the same bounds of the gains."""
    classes = row.classes
    same = classes is not None and (classes.lower, classes.upper) == (asked.classes.lower, asked.classes.upper)
    return same and row.stopped is None and classes is not None and contains(class_entries(classes), asked.class_entry)


def require_range(asked: Problem) -> None:
    """Refuse upper bounds whose squares, or those of whose factors, are no doubles, where factors are asked for.

    Raises
    ------
    InputError
        There is such a bound.
    """
    if asked.kind == "class" or not asked.several or asked.classes.performance is not None:
        return
    for i, end in enumerate(asked.classes.upper, 1):
        if end and not 1 / _RANGE < abs(end) < _RANGE:
            ends = f"between {decimal_text(1 / _RANGE)} and {decimal_text(_RANGE)}"
            raise InputError(
                f"the upper bound of channel {i} is {decimal_text(end)}, and factors of it are asked for; rescale the "
                f"units of sigma or phi, so that it is {ends}"
            )


def require_well_posed(asked: Problem) -> None:
    """Refuse a loop that has no one solution with the gains at the lower bounds: ``det(1 + D L) = 0``.

    Raises
    ------
    InputError
        It has none.
    """
    if isinstance(asked.plant, ChannelFamily | DelayMatrix):
        # left to the inequality, which holds for no plant that has none; with dead times nothing is shifted
        return
    H = channel_plant(asked.plant)
    lower = asked.classes.lower
    whole = [[(i == j) + v * g for j, (v, g) in enumerate(zip(row, lower, strict=True))] for i, row in enumerate(H.D)]
    if not any(lower) or not any(map(any, H.D)):
        return
    if eliminated([[Fraction(v) for v in row] for row in whole], [[] for _ in whole]) is None:
        gains = ", ".join(map(str, lower))
        raise InputError(
            f"the loop is not well posed: det(1 + D L) = 0 for the gains {gains} at the lower bounds; give a D or "
            "lower bounds for which sigma is determined"
        )


def proposals(
    asked: Problem, rows: Sequence[StabilityBound] = ()
) -> Iterator[tuple[str, Callable[[], Proved | Refuted | None]]]:
    """What to try for exactly these classes, in order: constant gains, each criterion, proofs of larger classes.

    ``rows``: what was accepted for largest factors.

    Raises
    ------
    InputError
        There is no such criterion, or the loop is not well posed with the gains at the lower bounds, and none is a
        member.
    """
    try:
        require_well_posed(asked)
    except InputError:
        if asked.classes.rectified:
            raise
        yield "constant gains", lambda: refutation(asked, Fraction(1), constant_gains(asked.classes.lower))
        return
    own = asked.class_entry
    if asked.classes.rectified:  # what was proved of other factors says nothing about these
        rows = ()

    family = isinstance(asked.plant, ChannelFamily)

    def against(search: channel_families.Against) -> tuple[Fraction, Refuted] | None:
        """What a search finds, of all plants of a family or of one."""
        return channel_families.refuting(asked, search) if family else search(asked)

    def gains() -> Refuted | None:
        """A member with constant gains that is not stable."""
        if rows:
            seen = (shown for row in rows for shown in row.refutations)
            return next((shown for shown in seen if contains(own, shown.certificate["laws"])), None)
        found = against(lambda one: _at_once(one) or members_refuting(one, most=1.0))
        return None if found is None else found[1]

    def jumping() -> Refuted | None:
        """One whose gains, or for a family whose parameters, jump."""
        found = parameters_refuting(asked, asked.classes.least, 1.0, whole=True) if family else None
        if not family:
            found = switching_refuting(asked, asked.classes.least, 1.0, whole=True)
        return None if found is None else found[1]

    def oscillating() -> Refuted | None:
        """One with a periodic solution."""
        found = against(lambda one: orbits_refuting(one, one.classes.least, 1.0, whole=True))
        return None if found is None else found[1]

    def whole(criterion: Criterion) -> Proved:
        """The proof of the class by one criterion."""
        shown = proved_whole(asked, criterion)
        if shown is None:
            raise AssumptionError(_NO_MULTIPLIER, code=Reason.NO_MULTIPLIER)
        return shown

    late = not family and loop_plant(asked.plant).order > _MOST_ROUTH and not rows
    if not late:
        yield "constant gains", gains
    larger = [row.proof for row in rows if row.proof is not None and contains(row.proof.certificate["laws"], own)]
    for criterion in criteria_for(asked) if larger or not rows else ():
        yield criterion.name, partial(whole, criterion)
    if late:
        yield "constant gains", gains
    moving = isinstance(asked.plant, ChannelFamily) and any(asked.plant.rates)
    if not rows and (asked.time_varying or moving):
        yield "switched gains", jumping
    if not rows:
        yield "periodic solutions", oscillating
    if family and not rows:
        yield "parts of the box", channel_families.BoxSearch(asked, channel_families.criteria(asked)[0]).parts
    if rows and not larger:
        yield (
            "the largest factor",
            partial(_ends_before, next((r for r in rows if r.classes == asked.classes), rows[-1])),
        )
    for shown in larger:
        yield shown.theorem, partial(_as_it_is, shown)


def _ends_before(row: StabilityBound) -> None:
    """Say why the largest factor is below 1."""
    if row.stopped is not None:
        raise TimeoutError("the time allowed is over")
    reached = f"what is proved ends at {row.proved_text} times the upper bounds" if row.proved_text else row.reason
    against = "" if row.refuted_at is None else f", and the smallest factor refuted is {row.refuted_text}"
    raise AssumptionError(reached + against, code=Reason.NO_MULTIPLIER)


def _as_it_is(shown: Proved) -> Proved:
    return shown
