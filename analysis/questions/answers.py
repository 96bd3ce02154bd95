"""``answer``: from a problem to its verdict, for the largest class of a kind and for one class alike."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache
from typing import TYPE_CHECKING, Any, cast

from lure.analysis.certificates import codes
from lure.analysis.certificates.drafts import Failure
from lure.analysis.counterexamples.linear import refutes_lower
from lure.analysis.deadline import check_seconds, time_limit
from lure.analysis.inequality.checks import require_solution
from lure.analysis.numerics.doubles import double_below
from lure.analysis.questions.advice import row_asked, why
from lure.analysis.questions.channel_parts import in_parts, splits_of
from lure.analysis.questions.channels import Factors, require_range
from lure.analysis.questions.conclusion import Certification, Conclusion, MismatchError, conclusion_of, undecided
from lure.analysis.questions.largest import StabilityBound
from lure.analysis.questions.one_late_channel import as_one_channel, bound_of_factors
from lure.analysis.questions.problem import Plant, Problem, Search, by_matrices, plant_given
from lure.analysis.questions.proofs import rank, silent
from lure.analysis.questions.search import Attempts, Findings, Found, Tell, search_for
from lure.analysis.theorems.table import BEST, Question
from lure.analysis.verdict import Bracket, CriterionResult, Verdict, Witness
from lure.analysis.wording import proviso
from lure.classes import Diagonal, NonlinearityClass, Sector, SlopeBounds
from lure.errors import InputError
from lure.exact import Exact, exact_number
from lure.plants.frequency_data import FrequencyData
from lure.plants.rational import RationalPlant

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Proved, Refuted
    from lure.analysis.certificates.proposals import Numbers


class ContradictionError(RuntimeError):
    """A proof and a refutation of the same class: one of the two is wrong, and neither is reported."""


def max_sector(  # noqa: PLR0913  (a block, classes and six settings with defaults)
    block: object,
    classes: Sequence[object] | Diagonal | None = None,
    *,
    criterion: str = BEST,
    lower: Exact = 0,
    time_varying: bool = False,
    search: Search = "linear",
    seconds: float | None = None,
    progress: Tell | None = None,
) -> StabilityBound:
    r"""The largest ``k`` such that the loop is stable for every ``phi`` in the sector ``[lower, k]``.

    .. math:: \sigma = H \mu, \qquad \mu = -\phi(\sigma), \qquad
        \mathrm{lower}\, \sigma^2 \le \sigma\, \phi(\sigma) \le k\, \sigma^2.

    Where the loop with the gain ``lower`` has a pole at 0, only convergence to the set of equilibria is claimed
    (boundedness if ``phi`` depends on time); see ``meaning`` and ``proviso`` of the answer.

    Parameters
    ----------
    block : RationalPlant, control or scipy.signal system, (numerator, denominator), (A, B, C, D)
        The linear block, whatever :func:`lure.as_plant` takes, or a ``StructuredPlant`` such as a rod.
    classes : sequence or Diagonal, optional
        For a plant with several channels: the class of each nonlinearity, in order, as ``Sector`` or
        ``NonlinearityClass``.  The answer is then the largest factor of all upper bounds.
    criterion : str
        ``circle``, ``popov``, ``homogeneous-lyapunov``, ``hurwitz`` (linear gains only), or ``best``: the farthest of
        all that apply.
    lower : int, float, Fraction or Decimal
        Lower end of the sector; for an unstable block take one for which the linear loop is stable.
    time_varying : bool
        Whether ``phi`` may depend on time.
    search : {"linear", "full"}
        Where to look for destabilising members: among linear gains, or among all kinds known (seconds to half a
        minute), as long as a gap is left.
    seconds : float or None
        Time allowed; when it is over the best answer so far is returned, with ``stopped = "time"``.
    progress : callable, optional
        Called as ``progress(step, done)`` when a step begins, ``0 <= done <= 1``.

    Returns
    -------
    StabilityBound
        With ``largest``, ``hurwitz``,
        ``verdict``, ``evidence``, ``theta``, ``refuted_at`` and more; ``bool()`` raises.

    Raises
    ------
    InputError
        The block or a number is no good, or there is no such criterion.
    AssumptionError
        The criterion does not apply to such a block or class.
    ContradictionError
        What is proved and what is refuted overlap: a bug.
    KeyboardInterrupt
        The user interrupted before anything was found; later, the best answer so far is returned, with ``stopped =
        "interrupt"``.

    Notes
    -----
    The criteria of one stage of the catalogue are asked only while what is proved and
    what is refuted do not meet; the others are listed in ``answers`` as not needed.

    Examples
    --------
    >>> found = max_sector(([1], [1, 3, 2, 0]), criterion="popov")
    >>> print(found.verdict, round(found.largest.low, 6), round(found.theta, 6))
    PROVED 6.0 1.5
    """
    _checked(criterion, search, seconds, time_varying=time_varying)
    if classes is not None:
        _only_classes(lower=lower, time_varying=time_varying)
        return _of_channels(block, classes, "sector", criterion, seconds, progress)
    more: dict[str, Any] = {"time_varying": time_varying, "criterion": criterion, "search": search}
    problem = Problem.largest(largest_plant(block), "sector", lower=exact_number(lower, "lower"), **more)
    return cast("StabilityBound", answer(problem, seconds=seconds, progress=progress))


def max_slope(  # noqa: PLR0913  (a block, classes and six settings with defaults)
    block: object,
    classes: Sequence[object] | Diagonal | None = None,
    *,
    odd: bool = False,
    criterion: str = BEST,
    lower: Exact = 0,
    search: Search = "full",
    seconds: float | None = None,
    progress: Tell | None = None,
) -> StabilityBound:
    r"""The largest ``k`` such that the loop is stable for every time-invariant ``phi`` with slope in ``[lower, k]``.

    .. math:: \sigma = H \mu, \qquad \mu = -\phi(\sigma), \qquad \phi(0) = 0, \\
        \mathrm{lower} \le \frac{\phi(x) - \phi(y)}{x - y} \le k \quad (x \ne y).

    Merely monotone and odd nonlinearities are kept apart: a bound for odd ones can be false for the others.

    Parameters
    ----------
    block : RationalPlant, control or scipy.signal system, (numerator, denominator), (A, B, C, D)
        The linear block, whatever :func:`lure.as_plant` takes, or a ``StructuredPlant`` such as a rod.
    classes : sequence or Diagonal, optional
        For a plant with several channels: the class of each nonlinearity, in order, as ``SlopeBounds`` or
        ``NonlinearityClass``.  The answer is then the largest factor of all upper bounds.
    odd : bool
        Whether ``phi(-sigma) = -phi(sigma)`` is assumed.
    criterion : str
        One of :data:`lure.analysis.theorems.table.CRITERIA`, or ``best``: the farthest of all that apply.
    lower : int, float, Fraction or Decimal
        Lower end of the slope.
    search : {"linear", "full"}
        Where to look for destabilising members: among linear gains, or for periodic orbits too (seconds to half a
        minute), as long as a gap is left.
    seconds : float or None
        Time allowed; when it is over the best answer so far is returned, with ``stopped = "time"``.
    progress : callable, optional
        Called as ``progress(step, done)`` when a step begins, ``0 <= done <= 1``.

    Returns
    -------
    StabilityBound
        With ``largest``, ``refuted_at``, ``witness``,
        ``hurwitz``, ``verdict``, ``evidence``, ``multiplier`` and more.

    Raises
    ------
    InputError, AssumptionError, ContradictionError, KeyboardInterrupt
        As :func:`max_sector`, whose notes hold here too.

    Examples
    --------
    >>> found = max_slope(([1], [1, 2, 2, 1]), search="linear")
    >>> print(found.verdict, found.criterion, round(found.largest.low, 6), found.refuted_at)
    PROVED popov 3.0 3.0
    """
    _checked(criterion, search, seconds, odd=odd)
    if classes is not None:
        _only_classes(lower=lower, odd=odd)
        return _of_channels(block, classes, "slope", criterion, seconds, progress)
    more: dict[str, Any] = {"odd": odd, "criterion": criterion, "search": search}
    problem = Problem.largest(largest_plant(block), "slope", lower=exact_number(lower, "lower"), **more)
    return cast("StabilityBound", answer(problem, seconds=seconds, progress=progress))


def _checked(criterion: object, search: object, seconds: object, **flags: object) -> None:
    """The options, before anything is computed from them."""
    for name, value in flags.items():
        if not isinstance(value, bool):
            raise InputError(f"{name} is {value!r:.40}; give True or False")
    if search not in ("linear", "full"):
        raise InputError(f"search is {search!r:.40}; give 'linear' or 'full'")
    if not isinstance(criterion, str):
        raise InputError(f"criterion is {criterion!r:.40}; give its name as text")
    check_seconds(seconds)


def _only_classes(**settings: object) -> None:
    """Refuse what the classes of several nonlinearities say themselves."""
    for name, value in settings.items():
        if value:
            raise InputError(f"{name} is given beside classes; say it in the class of each channel")


def _of_channels(  # noqa: PLR0913  (what the two questions share)
    block: object,
    classes: Sequence[object] | Diagonal,
    question: Question,
    criterion: str,
    seconds: float | None,
    progress: Tell | None,
) -> StabilityBound:
    from lure.analysis.questions.channel_problem import channel_problem

    problem = channel_problem(block, classes, kind=question, criterion=criterion, late=True)
    return cast("StabilityBound", answer(problem, seconds=seconds, progress=progress))


def largest_plant(block: object) -> Plant:
    """The plant of a question for a largest class: one of high order by its matrices.

    ``block``: as for :func:`max_sector`.
    """
    found = plant_given(block)
    return (by_matrices(found) or found) if isinstance(found, RationalPlant) else found


def answer(
    problem: Problem,
    *,
    seconds: float | None = None,
    numbers: Numbers = "rationals",
    progress: Tell | None = None,
    brief: bool = False,
) -> StabilityBound | Certification:
    """The answer to a problem: of the largest class a ``StabilityBound``, of one given class a ``Certification``.

    Parameters
    ----------
    problem : Problem
        The question.
    seconds : float or None
        Time allowed; when it is over the best answer so far is returned.
    numbers : {"rationals", "decimals as written", "doubles, exactly"}
        Where the numbers came from, for the certificate of a given class.
    progress : callable, optional
        Called as ``progress(step, done)`` when a step begins, ``0 <= done <= 1``; 0 where that is not known.
    brief : bool
        Whether a criterion is left unproved that claims less of a largest class than another has proved: verdict,
        bounds and criterion of the answer are the same, ``answers`` says less.

    Raises
    ------
    InputError, AssumptionError, ContradictionError, KeyboardInterrupt
        As :func:`max_sector`.

    Examples
    --------
    >>> problem = Problem.largest(RationalPlant([1], [1, 3, 2, 0]), "sector", lower=Fraction(0))
    >>> print(answer(problem).verdict)
    PROVED
    """
    if problem.kind != "class" and isinstance(problem.plant, RationalPlant):
        require_solution(problem.plant, problem.lower)
    return answers([problem], seconds=seconds, numbers=numbers, progress=progress, brief=brief)[0]


def answers(
    problems: Sequence[Problem],
    *,
    seconds: float | None = None,
    numbers: Numbers = "rationals",
    progress: Tell | None = None,
    brief: bool = False,
) -> list[StabilityBound | Certification]:
    """The answers to several problems about one plant; what they have in common is computed once.

    Parameters
    ----------
    problems : sequence of Problem
        The problems, larger classes before smaller ones.  One class that stands beside largest ones is decided by what
        was accepted for those, as far as they begin low enough.
    seconds : float or None
        Time allowed; when it is over the best answers so far are returned.
    numbers : {"rationals", "decimals as written", "doubles, exactly"}
        Where the numbers came from, for the certificate of a given class.
    progress : callable, optional
        As for :func:`answer`.
    brief : bool
        As for :func:`answer`.

    Raises
    ------
    InputError, AssumptionError, ContradictionError, KeyboardInterrupt
        As :func:`max_sector`.
    """

    def ask(own: Sequence[Problem], left: float | None, tell: Tell) -> list[StabilityBound | Certification]:
        """The answers about one of the loops of which the plant consists."""
        return answers(own, seconds=left, numbers=numbers, progress=tell, brief=brief)

    begun = time.monotonic()

    def left() -> float | None:
        """Of the seconds allowed."""
        return None if seconds is None else max(1e-9, seconds + begun - time.monotonic())

    for problem in problems:
        require_range(problem)
    for split in splits_of(problems):
        apart = in_parts(problems, split, ask, seconds, progress)
        if apart is not None:
            return apart
    try:
        with time_limit(left()):
            found = [_nothing_yet(as_one_channel(problem)) for problem in problems]
    except TimeoutError:  # in the count of the roots with the gain at the lower end
        found = [_nothing_yet(problem) for problem in problems]
    listed = any(isinstance(each, Attempts) and each.asked.several for each in found)

    @cache
    def bounds() -> list[StabilityBound]:
        """What follows for the largest classes, whose steps are made before those of one class; see :func:`_rows`."""
        return _rows(problems, found, factors=listed)

    search_for(found, bounds, seconds=left(), numbers=numbers, tell=progress, brief=brief)
    rows = iter(_rows(problems, found))
    answered = [certification_of(each, bounds()) if isinstance(each, Attempts) else next(rows) for each in found]
    moved = [each.asked.several != problem.several for problem, each in zip(problems, found, strict=True)]
    for i, (problem, each) in enumerate(zip(problems, found, strict=True)):
        if not isinstance(each, Attempts) or problem.several or answered[i].verdict is not Verdict.INCONCLUSIVE:
            continue
        if (moved[i] and problem.nonlinearity_class.sector.lower > 0) or (any(moved) and not moved[i]):
            alone = Attempts(problem)  # what is proved from 0 on may end a little higher; rows of lists serve no other
            search_for([alone], list, seconds=left(), numbers=numbers, tell=progress)
            answered[i] = answered[i] if alone.certification is None else alone.certification
    return answered


def _rows(problems: Sequence[Problem], found: Sequence[Found], *, factors: bool = False) -> list[StabilityBound]:
    """What follows for the largest classes.

    Of what was asked as a list of one, the row says so as of one channel, unless ``factors`` are wanted, which a class
    is held against that is asked about as such a list.
    """
    scalar = iter(_spread([largest_of(each) for each in found if isinstance(each, Findings)]))
    rows = []
    for problem, each in zip(problems, found, strict=True):
        if isinstance(each, Findings):
            rows += [] if factors else [next(scalar)]
        elif isinstance(each, Factors):
            as_asked = factors or each.asked.several == problem.several
            rows.append(each.bound if as_asked else bound_of_factors(problem, each))
    return rows


def _nothing_yet(problem: Problem) -> Found:
    if problem.kind == "class":
        return Attempts(problem, list(problem.refusals))
    return (
        Factors(problem)
        if problem.several
        else Findings(problem, hurwitz=Bracket(double_below(problem.lower), math.inf))
    )


# One class: from what was tried to the answer.


def certification_of(found: Attempts, rows: list[StabilityBound]) -> Certification:
    """The answer about one class: of what was accepted, or why nothing was, as a code.

    ``found``: what was tried; ``rows``: what is known of the largest classes beside it, empty where they were not asked
    about.
    """
    problem, failures = found.asked, found.failures
    if found.certification is not None:
        return found.certification
    if rows and not problem.several and not problem.endless_below:
        wanted = problem.nonlinearity_class
        code, detail = why(row_asked(rows, wanted), rows, wanted, failures)
        return Certification(conclusion=undecided(problem, detail, code=code), detail=detail, failures=tuple(failures))
    if not failures:
        failures = [Failure(search="all", code=codes.NOT_APPLICABLE, detail="no criterion serves such a class")]
    worst = min(reversed(failures), key=lambda failure: codes.WORST.index(failure.code))
    detail = f"{worst.search}: {worst.detail}"
    follows = undecided(problem, detail, code=worst.code)
    return Certification(conclusion=follows, detail=detail, failures=tuple(failures))


# The largest class: from what was found to the bound.


def largest_of(findings: Findings) -> StabilityBound:
    """The answer to a question from what was found; ``findings``: what was found, complete or not.

    Raises
    ------
    ContradictionError
        What is proved and what is refuted overlap: a bug.
    """
    asked, limit = findings.asked, findings.hurwitz
    against = sorted(findings.witnesses, key=lambda witness: witness.k)
    answers = sorted(findings.answers, key=rank)
    found = answers or [silent(asked.criterion, asked, "no criterion was asked")]
    best, first = found[0], against[0] if against else None
    if best.verdict is Verdict.PROVED:  # constant gains are nonlinearities of the class
        limit = Bracket(max(limit.low, min(best.largest.low, limit.high)), limit.high)
    refuted_at = None if first is None else first.k
    if best.verdict is Verdict.PROVED and refuted_at is not None and best.largest.low >= refuted_at:
        raise ContradictionError(
            f"{best.criterion} proves [{asked.lower}, {best.largest.low!r}], and {first} destabilises at "
            f"{refuted_at!r}; one of the two is wrong: please report the block {asked.plant}"
        )
    ceiling = min(limit.high, math.inf if refuted_at is None else refuted_at)
    if asked.criterion != BEST or isinstance(asked.plant, FrequencyData):
        ceiling = min(ceiling, best.largest.high)
    never = first is not None and (limit.high <= asked.lower or refutes_lower(first))
    refuted = first if never and first is not None and first.refutation is not None else None
    telling = next((one for one in against[1:] if one.refutation is not None), None) if refuted is not None else None
    witness, trivial = (first, None) if telling is None else (telling, refuted)
    shown = best.proof if refuted is None or witness is None else witness.refutation
    reached = Bracket(best.largest.low, max(best.largest.low, ceiling))
    conclusion = _concluded(asked, best, shown, trivial)
    return StabilityBound(
        question=asked.question,
        odd=asked.odd,
        time_varying=asked.time_varying,
        lower=asked.lower,
        critical=findings.critical,
        proviso="" if best.proof is None else proviso(best.proof),
        criterion=best.criterion,
        largest=reached,
        hurwitz=limit,
        verdict=conclusion.verdict,
        evidence=best.evidence if refuted is None else refuted.evidence,
        theta=best.theta,
        multiplier=best.multiplier,
        parameters=best.parameters,
        refuted_at=refuted_at,
        witness=witness,
        answers=tuple(answers),
        reason=_reason(findings, best),
        conclusion=conclusion,
        stopped=findings.stopped,
        subject=asked.subject,
        trivial=trivial,
    )


def _reason(findings: Findings, best: CriterionResult) -> str:
    """Why nothing more was shown: where nothing was, and the time is over, that."""
    if best.verdict is Verdict.PROVED:
        return best.reason
    if findings.stopped is None:
        return findings.left_out + best.reason
    return f"the time allowed is over ({codes.OUT_OF_TIME.identifier})" if findings.stopped == "time" else "interrupted"


def _concluded(
    asked: Problem, best: CriterionResult, shown: Proved | Refuted | None, trivial: Witness | None = None
) -> Conclusion:
    """What follows for the largest class, the one that the answer says is proved."""
    low, finite = best.largest.low, best.verdict is Verdict.PROVED and best.largest.low < math.inf
    sector = Sector(asked.lower, low if finite and asked.lower < Fraction(low) else math.inf)
    slope = SlopeBounds(sector.lower, sector.upper) if asked.question == "slope" else None
    nonlinearity_class = NonlinearityClass(sector=sector, slope=slope, odd=asked.odd, time_varying=asked.time_varying)
    about = replace(asked, classes=Diagonal((nonlinearity_class,)))
    if shown is None:
        return undecided(about, best.reason, evidence=best.evidence)
    found = conclusion_of(about, shown, beside=None if trivial is None else trivial.refutation)
    if found.verdict is Verdict.INCONCLUSIVE:
        raise MismatchError(f"{found} Please report the block {asked.plant}")
    return found


def _spread(rows: list[StabilityBound]) -> list[StabilityBound]:
    """A counterexample to a class refutes the larger ones before it too, if they begin at the same gain."""
    found = list(rows)
    for place in range(len(found) - 2, -1, -1):
        larger, smaller = found[place], found[place + 1]
        if smaller.refuted_at is None or larger.lower != smaller.lower:
            continue
        if smaller.trivial is not None and larger.trivial is None and larger.refuted_at == smaller.refuted_at:
            found[place] = replace(larger, trivial=smaller.trivial, witness=smaller.witness)
        elif larger.refuted_at is None or smaller.refuted_at < larger.refuted_at:
            low, high = larger.largest.low, smaller.refuted_at
            if larger.verdict is Verdict.PROVED and low >= high:
                raise ContradictionError(f"{larger.criterion} proves up to {low!r}, and {smaller.witness} at {high!r}")
            largest = Bracket(low, max(low, min(larger.largest.high, high)))
            witness, trivial = smaller.witness, smaller.trivial
            found[place] = replace(larger, refuted_at=high, witness=witness, trivial=trivial, largest=largest)
    return found
