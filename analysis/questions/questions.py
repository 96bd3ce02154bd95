"""``max_sector`` and ``max_slope``: the largest class that is stable, and the smallest found that is not."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

from lure.analysis.certificates.codes import OUT_OF_TIME
from lure.analysis.counterexamples.linear import refutes_lower
from lure.analysis.deadline import check_seconds
from lure.analysis.inequality.checks import require_solution
from lure.analysis.questions.conclusion import Conclusion, MismatchError, conclusion_of, undecided
from lure.analysis.questions.findings import Findings, Tell, find
from lure.analysis.questions.largest import StabilityBound
from lure.analysis.questions.models import silent
from lure.analysis.questions.problem import Plant, Problem, Search, plant_given
from lure.analysis.questions.state_space import by_matrices
from lure.analysis.theorems.table import BEST
from lure.analysis.verdict import Answer, Bracket, Verdict, Witness
from lure.analysis.wording import proviso
from lure.classes import Diagonal, NonlinearityClass, Sector, SlopeBounds
from lure.errors import InputError
from lure.exact import Exact, exact_number
from lure.plants.frequency_data import FrequencyData
from lure.plants.rational import RationalPlant

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Proved, Refuted
    from lure.analysis.certificates.proposals import Numbers
    from lure.analysis.questions.certify import Certification


class ContradictionError(RuntimeError):
    """A proof and a refutation of the same class: one of the two is wrong, and neither is reported."""


def max_sector(  # noqa: PLR0913  (a block and six settings with defaults)
    block: object,
    *,
    criterion: str = BEST,
    lower: Exact = 0,
    time_varying: bool = False,
    search: Search = "linear",
    seconds: float | None = None,
    progress: Tell | None = None,
) -> StabilityBound:
    r"""The largest ``k`` such that the loop is stable for every ``phi`` in the sector ``[lower, k]``.

    .. math:: \sigma = H \mu, \qquad \mu = -\varphi(\sigma), \qquad
        \mathrm{lower}\, \sigma^2 \le \sigma\, \varphi(\sigma) \le k\, \sigma^2.

    Where the loop with the gain ``lower`` has a pole at 0, only convergence to the set of equilibria is claimed
    (boundedness if ``phi`` depends on time); see ``meaning`` and ``proviso`` of the answer.

    Parameters
    ----------
    block : RationalPlant, control or scipy.signal system, (numerator, denominator), (A, B, C, D)
        The linear block, whatever :func:`lure.as_plant` takes, or a ``StructuredPlant`` such as a rod.
    criterion : str
        ``circle``, ``popov``, ``hurwitz`` (linear gains only), or ``best``: the farthest of all that apply.
    lower : int, float, Fraction or Decimal
        Lower end of the sector; for an unstable block take one for which the linear loop is stable.
    time_varying : bool
        Whether ``phi`` may depend on time.
    search : {"linear", "full"}
        Where to look for destabilising members: among linear gains, or among all kinds known (seconds), as long as
        a gap is left.
    seconds : float or None
        Time allowed; when it is over the best answer so far is returned, with ``stopped = "time"``.
    progress : callable, optional
        Called as ``progress(step, done)`` when a step begins, ``0 <= done <= 1``.

    Returns
    -------
    StabilityBound
        With ``largest``, ``hurwitz``, ``verdict``, ``evidence``, ``theta``, ``refuted_at`` and more; ``bool()`` raises.

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
    return _largest(
        Problem.largest(
            _block(block),
            "sector",
            lower=exact_number(lower, "lower"),
            time_varying=time_varying,
            criterion=criterion,
            search=search,
        ),
        seconds,
        progress,
    )


def max_slope(  # noqa: PLR0913  (a block and six settings with defaults)
    block: object,
    *,
    odd: bool = False,
    criterion: str = BEST,
    lower: Exact = 0,
    search: Search = "full",
    seconds: float | None = None,
    progress: Tell | None = None,
) -> StabilityBound:
    r"""The largest ``k`` such that the loop is stable for every time-invariant ``phi`` with slope in ``[lower, k]``.

    .. math:: \sigma = H \mu, \qquad \mu = -\varphi(\sigma), \qquad \varphi(0) = 0, \\
        \mathrm{lower} \le \frac{\varphi(x) - \varphi(y)}{x - y} \le k \quad (x \ne y).

    Merely monotone and odd laws are kept apart: a bound for odd ones can be false for the others.

    Parameters
    ----------
    block : RationalPlant, control or scipy.signal system, (numerator, denominator), (A, B, C, D)
        The linear block, whatever :func:`lure.as_plant` takes, or a ``StructuredPlant`` such as a rod.
    odd : bool
        Whether ``phi(-sigma) = -phi(sigma)`` is assumed.
    criterion : str
        One of :data:`lure.analysis.theorems.table.CRITERIA`, or ``best``: the farthest of all that apply.
    lower : int, float, Fraction or Decimal
        Lower end of the slope.
    search : {"linear", "full"}
        Where to look for destabilising members: among linear gains, or for periodic orbits too (seconds), as long as
        a gap is left.
    seconds : float or None
        Time allowed; when it is over the best answer so far is returned, with ``stopped = "time"``.
    progress : callable, optional
        Called as ``progress(step, done)`` when a step begins, ``0 <= done <= 1``.

    Returns
    -------
    StabilityBound
        With ``largest``, ``refuted_at``, ``witness``, ``hurwitz``, ``verdict``, ``evidence``, ``multiplier`` and more.

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
    >>> found = max_slope(([1], [1, 2, 2, 1]), search="linear")
    >>> print(found.verdict, found.criterion, round(found.largest.low, 6), found.refuted_at)
    PROVED popov 3.0 3.0
    """
    _checked(criterion, search, seconds, odd=odd)
    return _largest(
        Problem.largest(
            _block(block),
            "slope",
            lower=exact_number(lower, "lower"),
            odd=odd,
            criterion=criterion,
            search=search,
        ),
        seconds,
        progress,
    )


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


def _block(block: object) -> Plant:
    found = plant_given(block)
    return (by_matrices(found) or found) if isinstance(found, RationalPlant) else found


def answer(
    problem: Problem, *, seconds: float | None = None, numbers: Numbers = "rationals", progress: Tell | None = None
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
    if problem.kind == "class":
        from lure.analysis.questions.certify import certification

        return certification(problem, seconds=seconds, numbers=numbers, progress=progress)
    return _largest(problem, seconds, progress)


def _largest(asked: Problem, seconds: float | None, progress: Tell | None) -> StabilityBound:
    if isinstance(asked.plant, RationalPlant):
        require_solution(asked.plant, asked.lower)
    return largest_of(found_for([asked], seconds=seconds, progress=progress)[0])


def found_for(
    asking: Sequence[Problem], *, seconds: float | None = None, progress: Tell | None = None
) -> list[Findings]:
    """What is found for questions about one block; numbers beyond the range of doubles are refused in a sentence.

    Parameters
    ----------
    asking : sequence of Problem
        The questions.
    seconds : float or None
        Time allowed.
    progress : callable, optional
        Told each step and the share done.

    Raises
    ------
    InputError
        A gain or a frequency exceeds that range.
    """
    try:
        return find(asking, seconds=seconds, tell=progress)
    except OverflowError:
        raise InputError(
            f"a gain or frequency of {asking[0].plant} exceeds the range of doubles, 1e-308 to 1e308; rescale the units"
        ) from None


def largest_of(findings: Findings) -> StabilityBound:
    """The answer to a question from what was found.

    Parameters
    ----------
    findings : Findings
        What was found, complete or not.

    Raises
    ------
    ContradictionError
        What is proved and what is refuted overlap: a bug.
    """
    asked, limit, against = findings.asked, findings.hurwitz, findings.witnesses
    found = findings.answers or [silent(asked.criterion, asked, "no criterion was asked")]
    best, first = found[0], against[0] if against else None
    if best.verdict is Verdict.PROVED:  # constant gains are laws of the class
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
        answers=tuple(findings.answers),
        reason=_reason(findings, best),
        conclusion=conclusion,
        stopped=findings.stopped,
        subject=asked.subject,
        trivial=trivial,
    )


def _reason(findings: Findings, best: Answer) -> str:
    """Why nothing more was shown: where nothing was, and the time is over, that."""
    if best.verdict is Verdict.PROVED:
        return best.reason
    if findings.stopped is None:
        return findings.left_out + best.reason
    return f"the time allowed is over ({OUT_OF_TIME.identifier})" if findings.stopped == "time" else "interrupted"


def _concluded(
    asked: Problem, best: Answer, shown: Proved | Refuted | None, trivial: Witness | None = None
) -> Conclusion:
    """What follows for the largest class, the one that the answer says is proved."""
    low, finite = best.largest.low, best.verdict is Verdict.PROVED and best.largest.low < math.inf
    sector = Sector(asked.lower, low if finite and asked.lower < Fraction(low) else math.inf)
    slope = SlopeBounds(sector.lower, sector.upper) if asked.question == "slope" else None
    law_class = NonlinearityClass(sector=sector, slope=slope, odd=asked.odd, time_varying=asked.time_varying)
    about = replace(asked, classes=Diagonal((law_class,)))
    if shown is None:
        return undecided(about, best.reason, evidence=best.evidence)
    found = conclusion_of(about, shown, beside=None if trivial is None else trivial.refutation)
    if found.verdict is Verdict.INCONCLUSIVE:
        raise MismatchError(f"{found} Please report the block {asked.plant}")
    return found
