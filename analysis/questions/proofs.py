"""What the criteria propose for a problem, and what the checker makes of it: nothing is proved before that."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, cast

from lure.analysis.certificates import codes
from lure.analysis.certificates.drafts import Failure, check_for_class, complete_and_check, guarded
from lure.analysis.certificates.systems import class_entry
from lure.analysis.certificates.theory import Draft, theory_of
from lure.analysis.numerics.doubles import bound_below, double_below
from lure.analysis.questions import families
from lure.analysis.questions.problem import Problem
from lure.analysis.theorems.table import BEST, LAST, Theorem, Upper, row_of, theorems_for
from lure.analysis.verdict import Bracket, CriterionResult, Evidence, Verdict
from lure.classes import NonlinearityClass, Sector, SlopeBounds
from lure.errors import AssumptionError, InputError, Reason
from lure.exact import exact_number
from lure.plants.block import StructuredPlant
from lure.plants.delay import DelayPlant
from lure.plants.family import Box, PlantFamily
from lure.plants.frequency_data import FrequencyData
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Proved, Refuted
    from lure.analysis.certificates.proposals import Certified, Numbers

REFUSED = "does not apply"
NOT_NEEDED = "not needed"
EXPECTED = (AssumptionError, InputError, OverflowError, ModuleNotFoundError)  # said by the problem itself
LONG = "full effort"  # takes minutes

# How far a criterion reaches: of the classes ``[lower, k]`` the largest it proves.


def criterion_answer(row: Theorem, asked: Problem) -> CriterionResult | Failure:
    """What one criterion says, before the checker has seen it; or that it refuses or fails, and why.

    Raises
    ------
    TimeoutError
        The time allowed is over.
    """
    passing = (*EXPECTED, TimeoutError)
    try:
        found = guarded(row.name, lambda: _largest(row, asked, asked.lower), passing=passing)
    except (AssumptionError, InputError, ModuleNotFoundError) as refusal:
        return Failure(search=row.name, code=codes.code_for(refusal), detail=str(refusal))
    return replace(found, detail=f"the search failed: {found}") if isinstance(found, Failure) else found


def _largest(row: Theorem, asked: Problem, lower: Fraction) -> CriterionResult:
    """The largest class from ``lower`` on, by the means that there are for such a plant."""
    if isinstance(asked.block, StructuredPlant):
        return theory_of(asked.block).largest(row.name)
    if isinstance(asked.block, PlantFamily):
        return families.largest(asked.block, row, lower, partial(_class_to, asked, row), odd=asked.odd)
    return row.answer(asked.block, lower=lower, odd=asked.odd, named=asked.criterion != BEST)


def _class_to(asked: Problem, row: Theorem, upper: Upper) -> tuple[NonlinearityClass, dict[str, Any]]:
    """The class asked about with another upper end, and the same as it stands in a certificate."""
    top = math.inf if isinstance(upper, str) else upper
    slope = SlopeBounds(asked.lower, top) if asked.question == "slope" else None
    odd = asked.odd and (row.odd or row.only_odd)
    given = NonlinearityClass(sector=Sector(asked.lower, top), slope=slope, odd=odd, time_varying=asked.time_varying)
    return given, class_entry(given, unbounded=False)


def rank(answer: CriterionResult) -> tuple[bool, bool, float, float]:
    """Proofs first, refusals last, the larger sector before the smaller."""
    silent = answer.theorem in (REFUSED, NOT_NEEDED)
    return answer.verdict is not Verdict.PROVED, silent, -answer.largest.low, -answer.largest.high


def silent(
    name: str, asked: Problem, reason: str, *, theorem: str = REFUSED, code: Reason = Reason.NO_MULTIPLIER
) -> CriterionResult:
    """The answer of a criterion that says nothing: it refuses, it failed, or it was not asked."""
    lower = float(asked.lower)
    computed, sampled = isinstance(asked.plant, StateSpace), isinstance(asked.plant, FrequencyData)
    slope = SlopeBounds(lower, math.inf) if asked.question == "slope" else None
    return CriterionResult(
        criterion=name,
        theorem=theorem,
        largest=Bracket(lower, math.inf),
        nonlinearity_class=NonlinearityClass(sector=Sector(lower, math.inf), slope=slope, odd=asked.odd),
        verdict=Verdict.INCONCLUSIVE,
        evidence=Evidence.OBSERVED if sampled else Evidence.COMPUTED if computed else Evidence.CERTIFIED,
        reason=reason,
        code=code,
    )


def proved_answer(asked: Problem, answer: CriterionResult) -> CriterionResult:
    """The answer with what the checker accepted of it; INCONCLUSIVE where it accepted nothing.

    ``answer``: what a criterion says.

    Returns
    -------
    CriterionResult
        With ``proof``, and ``largest.low`` lowered to the class that was accepted.
    """
    computed = answer.evidence is Evidence.COMPUTED
    if isinstance(asked.block, PlantFamily):
        return _of_this_kind(asked, answer)
    if (answer.verdict is not Verdict.PROVED and not computed) or isinstance(asked.block, FrequencyData):
        return answer
    found = guarded(answer.criterion, lambda: _certified(asked, answer), passing=(TimeoutError,))
    if isinstance(found, Failure):
        return _uncertified(answer, found)
    largest, limited = answer.largest, answer.largest.low == math.inf and isinstance(found.upper, Fraction)
    if isinstance(found.upper, Fraction) and found.upper < largest.low:
        low = double_below(found.upper)
        largest = Bracket(low, max(low, largest.high))
    tried = f"{largest.low:g}".replace("e+", "e")
    reason = f"{tried} is the largest k for which a certificate was tried" if limited else answer.reason
    shown = replace(
        answer, largest=largest, shown=found.proved, search_limited=limited or answer.search_limited, reason=reason
    )
    return _as_certified(shown) if computed else shown


def _of_this_kind(asked: Problem, answer: CriterionResult) -> CriterionResult:
    """What is proved of all plants of a box, stated for time-varying nonlinearities where those are asked about."""
    if answer.proof is None or answer.nonlinearity_class.time_varying or not asked.time_varying:
        return answer
    wide = replace(answer.nonlinearity_class, time_varying=True)
    laws = {**answer.proof.certificate["laws"], "time_varying": True}
    again = {**answer.proof.certificate, "laws": laws}
    found = guarded(answer.criterion, lambda: complete_and_check(again), passing=(TimeoutError,))
    if isinstance(found, Failure):
        return _uncertified(answer, found)
    return replace(answer, nonlinearity_class=wide, shown=found)


def _as_certified(answer: CriterionResult) -> CriterionResult:
    """What was computed, as it was proved: class, multiplier and hypotheses are those of the certificate."""
    proof = cast("Proved", answer.shown)
    lower, theta = answer.nonlinearity_class.sector.lower, proof.certificate["multiplier"].get("theta")
    slope = None if answer.nonlinearity_class.slope is None else SlopeBounds(lower, answer.largest.low)
    own = replace(answer.nonlinearity_class, sector=Sector(lower, answer.largest.low), slope=slope)
    return replace(
        answer,
        nonlinearity_class=own,
        theta=0.0 if theta is None else float(Fraction(theta)),
        parameters=MappingProxyType(dict(proof.certificate["multiplier"])),
        verdict=Verdict.PROVED,
        evidence=Evidence.CERTIFIED,
        hypotheses=tuple(f"{name}: {fact}" for name, fact in proof.facts.items()),
        reason=answer.reason if answer.search_limited else "",
    )


def _uncertified(answer: CriterionResult, failure: Failure) -> CriterionResult:
    computed = "computed in floating point, " if answer.evidence is Evidence.COMPUTED else ""
    said = f"{computed}not certified: {failure}"
    return replace(answer, verdict=Verdict.INCONCLUSIVE, reason=said, code=failure.code.reason)


def _certified(asked: Problem, answer: CriterionResult, upper: Upper | None = None) -> Certified:
    """What the checker accepts of an answer, for nonlinearities that vary with time where those are asked about."""
    from lure.analysis.certificates.proposals import certified

    assert not isinstance(asked.block, FrequencyData | PlantFamily)
    wider = asked.time_varying and not answer.nonlinearity_class.time_varying
    wide = (
        replace(answer, nonlinearity_class=replace(answer.nonlinearity_class, time_varying=True)) if wider else answer
    )
    return certified(asked.block, wide, upper)


def endless_proof(asked: Problem, lower: Fraction) -> Proved | None:
    """What is accepted of the sector without an upper bound: every finite ``k`` is less than that.

    ``sigma^3`` lies in ``[0, inf]`` and in no ``[0, k]``.

    ``asked``: about a rational plant; for others None.  ``lower``: the lower end of the sector.
    """
    plant = asked.block
    if not isinstance(plant, RationalPlant):
        return None
    for row in reversed(theorems_for(plant, "sector", BEST, time_varying=asked.time_varying)):
        if not row.endless:
            continue
        try:
            answer = row.decide(plant, Sector(lower, math.inf))
        except AssumptionError:
            continue
        found = guarded(row.name, partial(_certified, asked, answer, "inf")) if _proves(answer) else None
        if found is not None and not isinstance(found, Failure) and found.upper == "inf":
            return found.proved
    return None


def _proves(answer: CriterionResult) -> bool:
    return answer.verdict is Verdict.PROVED


def restated(shown: Proved | Refuted, asked: Problem) -> Proved | Refuted:
    """What was accepted, stated for exactly the class asked about and the nonlinearity given, where that is accepted.

    ``shown``: what was accepted, of another class as a rule.
    """
    from lure.analysis.certificates.drafts import complete_and_check

    drafts: list[dict[str, Any]] = [{**shown.certificate, "laws": dict(asked.class_entry)}]
    if asked.nonlinearity_entry is not None and shown.certificate["verdict"] == "PROVED":
        drafts = [{**draft, "law": dict(asked.nonlinearity_entry)} for draft in (drafts[0], shown.certificate)] + drafts
    for draft in drafts:
        found = guarded("the class asked about", partial(complete_and_check, draft))
        if type(found) is type(shown):
            return found
    return shown


# Each criterion asked about exactly one class of nonlinearities, cheapest first.


@dataclass(frozen=True, slots=True)
class Candidate:
    """A criterion that serves a class, the upper end to certify, and what gives the answer."""

    name: str
    upper: Upper
    ask: Callable[[], CriterionResult]


def candidates(asked: Problem, *, finite: bool) -> Iterator[Candidate]:
    """The criteria that serve the class asked about.

    ``asked``: about a rational plant, one with dead time, or one of known structure; ``finite``: whether an infinite
    upper end means every nonlinearity with some finite bound.

    Raises
    ------
    InputError
        There is no such criterion.
    AssumptionError
        It does not apply to such a class or plant.
    """
    plant, nonlinearity_class = asked.plant, asked.nonlinearity_class
    found = theorems_for(plant, asked.question, asked.criterion, odd=asked.odd, time_varying=asked.time_varying)
    for row in found:
        for bounds in row.bounds(nonlinearity_class):
            upper: Upper = Fraction(bounds.upper) if bounds.upper != math.inf else "finite" if finite else "inf"
            last = row.stage == LAST
            if not (last and bounds.upper == math.inf and asked.criterion == BEST):  # it is about finite bounds
                name = f"{row.name}, {LONG}" if last else row.name
                yield Candidate(name, upper, partial(_decided, asked, row, bounds, finite=finite))
    slope = nonlinearity_class.slope
    if isinstance(plant, RationalPlant) and slope is not None and slope.upper != math.inf:
        for row in found:
            if row.thorough:
                ask = partial(row.decide, plant, slope, odd=asked.odd, thorough=True)
                yield Candidate(f"{row.name}, {LONG}", Fraction(slope.upper), ask)


def _decided(asked: Problem, row: Theorem, bounds: Sector | SlopeBounds, *, finite: bool) -> CriterionResult:
    """The answer about the class, or about the largest class if the class asked about is inside it."""
    plant = asked.block
    if isinstance(plant, RationalPlant):
        if not (finite and bounds.upper == math.inf):
            return row.decide(plant, bounds, odd=asked.odd)
        if bounds.lower == -math.inf:
            raise AssumptionError(
                "the class has no finite lower end, and no theorem here begins at -inf; give a lower bound",
                code=Reason.NO_LOWER_END,
            )
    if isinstance(plant, StructuredPlant) and bounds.lower == 0 and bounds.upper != math.inf:
        return theory_of(plant).inequality(row.name, Sector(0, bounds.upper))
    late = isinstance(plant, DelayPlant) and asked.question == "slope" and plant.strictly_proper
    shifted = isinstance(plant, RationalPlant) or (late and bounds.lower != -math.inf)
    lower = exact_number(bounds.lower, "lower") if shifted else Fraction(0)
    answer = _largest(row, asked, lower)
    if bounds.lower < answer.nonlinearity_class.sector.lower:
        raise AssumptionError(
            f"for such a block the classes begin at {float(answer.nonlinearity_class.sector.lower):g}; for a "
            f"DelayPlant or a "
            "rod close a loop with the lower gain in the model first",
            code=Reason.DEAD_TIME,
        )
    if _proves(answer) and bounds.upper > answer.largest.low:
        reason = f"what is proved ends at {bound_below(answer.largest.low)}"
        return replace(answer, verdict=Verdict.INCONCLUSIVE, reason=reason)
    return answer


Proposal = tuple[str, Callable[[], "Proved | Refuted | Failure | None"]]


def proposals(asked: Problem, numbers: Numbers) -> tuple[list[Proposal], list[Proposal]]:
    """The proofs to try of one class, cheapest first, and those that take minutes.

    ``numbers``: where the numbers came from.

    Returns
    -------
    tuple of list
        Names, and callables that return what the checker accepted, or a failure.
    """
    plant, method = asked.plant, asked.method
    if not asked.provable:
        return [], []
    if isinstance(plant, StructuredPlant):
        theory = theory_of(plant)
        if asked.criterion == BEST and method in ("best", "structure") and not asked.time_varying:
            return [(theory.argument, lambda: check_for_class(asked, {**theory.proof(), "numbers": numbers}))], []
        if plant.order is None and method not in ("best", "structure"):
            return [], []  # with infinitely many states there is no polynomial and no matrix
    if isinstance(plant, PlantFamily):
        asking = theorems_for(plant, asked.question, asked.criterion, odd=asked.odd, time_varying=asked.time_varying)
        return [
            (row.name, partial(_of_family, asked, row, numbers)) for row in asking if row.name not in families.UNUSED
        ], []
    if isinstance(plant, StateSpace) or (isinstance(plant, StructuredPlant) and method == "matrix"):
        from lure.analysis.certificates.by_matrices import class_drafts

        drafts = class_drafts(plant, asked.nonlinearity_class, asked.criterion, finite=asked.finite)
        return [(name, partial(_computed, asked, name, draft, numbers)) for name, draft in drafts], []
    each = [(one.name, partial(_proof, asked, one, numbers)) for one in candidates(asked, finite=asked.finite)]
    return [one for one in each if not one[0].endswith(LONG)], [one for one in each if one[0].endswith(LONG)]


def open_parts(asked: Problem) -> None:
    """Say where in the box of parameters nothing is proved; ``asked``: about one class and plants with parameters.

    Raises
    ------
    AssumptionError
        With the parts of the box.
    """
    family, laws = asked.plant, dict(asked.class_entry)
    assert isinstance(family, PlantFamily)
    searches = list[Callable[[Box], bool]]()
    for row in theorems_for(family, asked.question, asked.criterion, odd=asked.odd, time_varying=asked.time_varying)[
        :2
    ]:
        own = asked.nonlinearity_class
        bounds = own.slope if row.slope and own.slope is not None else own.sector
        upper: Upper = Fraction(bounds.upper) if bounds.upper != math.inf else "finite"
        if bounds.lower == -math.inf or row.name in families.UNUSED:
            continue
        search = families.Search(family, row, asked.odd)
        searches.append(partial(search.serves, laws, (Fraction(bounds.lower), upper)))

    def widest(box: Box) -> int:
        """The parameter of which the box holds the largest share."""
        return max(range(len(box)), key=lambda j: (box[j][1] - box[j][0]) / (family.box[j][1] - family.box[j][0]))

    if family.order_changes:
        return
    said = families.open_parts(family, lambda box: any(serves(box) for serves in searches), widest)
    raise AssumptionError(said, code=Reason.NO_MULTIPLIER)


def _of_family(asked: Problem, row: Theorem, numbers: Numbers) -> Proved | Refuted:
    """A proof by one criterion for all plants of a box."""
    assert isinstance(asked.plant, PlantFamily)
    given = asked.nonlinearity_class
    bounds = given.slope if row.slope and given.slope is not None else given.sector
    if bounds.lower == -math.inf:
        raise AssumptionError("with parameters the class needs a finite lower end", code=Reason.NO_LOWER_END)
    upper: Upper = Fraction(bounds.upper) if bounds.upper != math.inf else "finite"
    laws = {**asked.class_entry}
    shown = families.Search(asked.plant, row, asked.odd).proved(laws, Fraction(bounds.lower), upper)
    return check_for_class(asked, {**shown.certificate, "numbers": numbers})


def _proof(asked: Problem, candidate: Candidate, numbers: Numbers) -> Proved | Refuted | Failure:
    """A criterion asked, and what it proves put before the checker."""
    from lure.analysis.certificates.covers import cover_proof
    from lure.analysis.certificates.proposals import certified

    name, upper, answer = candidate.name, candidate.upper, candidate.ask()
    row, plant = row_of(answer.criterion, asked.plant), asked.block
    computed = answer.evidence is Evidence.COMPUTED and _all_gains(answer, upper)  # which the checker is to prove
    if not (_proves(answer) or computed) and not (row.linear and _all_gains(answer, upper)):
        return Failure(search=name, code=codes.NO_MULTIPLIER, detail=answer.reason or "it does not reach the class")
    if row.composed and not _solvable(asked):
        detail = f"{row.name} proves the class only for phi with which sigma + H(inf) phi(sigma) is increasing"
        return Failure(search=name, code=codes.SEVERAL_SOLUTIONS, detail=detail)
    if asked.method == "matrix":
        from lure.analysis.certificates.by_matrices import answer_draft

        by_matrix = answer_draft(plant, asked.nonlinearity_class, answer, finite=asked.finite)
        return check_for_class(asked, {**by_matrix, "numbers": numbers})
    assert not isinstance(plant, StateSpace | FrequencyData | PlantFamily)
    found = certified(plant, answer, upper, numbers=numbers)
    if found.upper != upper:
        detail = f"what {name} proves is accepted with the upper end {found.upper} in place of {upper}"
        return Failure(search=name, code=codes.PRECISION, detail=detail)
    draft = found.proved.certificate
    if asked.method == "cover" and draft["proof"]["method"] == "polynomial":
        return check_for_class(asked, {**draft, "proof": cover_proof(draft)})
    if asked.method not in ("best", draft["proof"]["method"]):
        detail = f"what {name} proves is shown by the method {draft['proof']['method']} here, not by {asked.method}"
        return Failure(search=name, code=codes.NOT_APPLICABLE, detail=detail)
    return check_for_class(asked, draft)


def _solvable(asked: Problem) -> bool:
    """Whether the class makes ``sigma + D phi(sigma)`` increasing, as some theorems assume where ``D != 0``."""
    plant, slope = asked.plant, asked.nonlinearity_class.slope
    if not isinstance(plant, RationalPlant) or plant.feedthrough == 0:
        return True
    ends = () if slope is None else (slope.lower, slope.upper)
    return bool(ends) and all(math.isfinite(end) and 1 + plant.feedthrough * Fraction(end) > 0 for end in ends)


def _all_gains(answer: CriterionResult, upper: Upper) -> bool:
    """Whether the linear gains up to that end are stable: no verdict on nonlinearities, and none is asked for."""
    low = answer.largest.low
    return low == math.inf if isinstance(upper, str) else upper <= low


def every_finite(asked: Problem) -> Failure | None:
    """Whether the class would be proved if each of its nonlinearities had a bound.

    ``asked``: about a class without an upper end.
    """
    infinite = isinstance(asked.plant, StructuredPlant) and asked.plant.order is None
    if infinite or isinstance(asked.plant, StateSpace | FrequencyData):
        return None
    for one in candidates(asked, finite=True):
        try:
            answer = one.ask()
        except AssumptionError:
            continue
        if _proves(answer) and answer.largest.low == math.inf:
            detail = f"{one.name} proves every finite upper bound, and the class has none"
            return Failure(search=one.name, code=codes.EVERY_FINITE, detail=detail)
    return None


def _computed(asked: Problem, name: str, draft: Callable[[], Draft], numbers: Numbers) -> Proved | Refuted | Failure:
    """A draft that floating point proposes; where it proposes none, that is a hint and nothing more."""
    try:
        return check_for_class(asked, {**draft(), "numbers": numbers})
    except AssumptionError as refusal:
        code = codes.code_for(refusal)
        unknown = code in (codes.NOT_APPLICABLE, codes.UNEXPECTED)
        return Failure(search=name, code=codes.COMPUTED if unknown else code, detail=str(refusal))
