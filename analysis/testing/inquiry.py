"""One question about one law: decided exactly where that is possible, searched for a violation elsewhere."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Literal

import numpy as np

from analysis.evidence import Evidence, Verdict
from analysis.testing.decision import Decision, decided, witness
from analysis.testing.domain import Domain, domain
from analysis.testing.measures import Chord, Limits, Mirror, Quotient, rounding
from analysis.testing.message import message, number
from analysis.testing.result import HISTORY, Checked, LawViolation, Violation
from analysis.testing.search import Worst, worst_pair, worst_point
from analysis.testing.shrink import simplest_pair, simplest_point
from analysis.testing.subject import Array, NotANumber, Subject, subject
from lure.errors import InputError
from lure.exact import Exact

_QUANTITIES = {
    "sector": "phi(sigma)/sigma",
    "slope": "the slope from sigma to sigma",
    "odd": "phi(sigma) + phi(-sigma)",
}
_FEWEST = 50


@dataclass(frozen=True, kw_only=True, slots=True)
class Search:
    """Where and how closely a law is looked at; see :func:`analysis.testing.assert_in_sector`."""

    on: tuple[Exact, Exact] | None
    samples: int
    breakpoints: tuple[float, ...]
    plot: str | PathLike[str] | None

    def __post_init__(self) -> None:
        if isinstance(self.samples, bool) or not isinstance(self.samples, int) or self.samples < _FEWEST:
            raise InputError(f"samples is {self.samples!r:.60}; give a whole number of at least {_FEWEST}")
        if self.plot is not None and Path(self.plot).suffix not in (".png", ".svg"):
            raise InputError(f"plot is {str(self.plot)!r:.60}; give a file name that ends in .png or .svg")


@dataclass(frozen=True, kw_only=True, slots=True)
class Inquiry:
    """What is asserted of a law; ``words`` say that it is so, and that it is not."""

    kind: Literal["sector", "slope", "odd"]
    words: tuple[str, str]
    limits: Limits
    search: Search


def run(phi: object, inquiry: Inquiry) -> Checked:
    """Answer, or raise.

    Parameters
    ----------
    phi : object
        The law, as :func:`analysis.testing.subject.subject` takes it.
    inquiry : Inquiry
        The question.

    Raises
    ------
    LawViolation
        The law does not have the property, or no value somewhere.
    InputError
        Something is not as described.
    """
    __tracebackhide__ = True
    where, law = domain(inquiry.search.on), subject(phi)
    try:
        known = decided(law, inquiry.kind, inquiry.limits, where.given) if law.known else Decision()
        violation = None
        if known.verdict is not Verdict.PROVED:
            violation = _found(law, inquiry, where, known)
    except NotANumber as error:
        raise LawViolation(_no_value(law, inquiry, error)) from None
    if violation is not None:
        if inquiry.search.plot is not None:
            violation.save(Path(inquiry.search.plot))
        raise LawViolation(message(violation), violation)
    if known.verdict is Verdict.REFUTED:
        exact = "" if inquiry.kind == "odd" else witness(law, inquiry.kind, inquiry.limits, where.given)
        raise LawViolation(f"{law.name} {inquiry.words[1]}: {exact or known.how}, though doubles do not show it")
    checked = _passed(law, inquiry, where, known)
    HISTORY.add(checked)
    return checked


def _passed(law: Subject, inquiry: Inquiry, where: Domain, known: Decision) -> Checked:
    slack = inquiry.limits.tolerance
    claim = f"{_claim(law, inquiry)}, to within {slack:g}" if slack else _claim(law, inquiry)
    if known.verdict is Verdict.PROVED:
        return Checked(claim=claim, evidence=Evidence.CERTIFIED, how=known.how, points=law.evaluations)
    how = f"no violation among {law.evaluations} values on {where}"
    how += f"; {known.how}" if known.how else ""
    return Checked(claim=claim, evidence=Evidence.OBSERVED, how=how, points=law.evaluations)


def _claim(law: Subject, inquiry: Inquiry) -> str:
    return f"{law.name} {inquiry.words[0]}"


def _found(law: Subject, inquiry: Inquiry, where: Domain, known: Decision) -> Violation | None:
    """The violation, at the simplest numbers that show it; None if there is none."""
    x = where.points(inquiry.search.samples, (*law.breakpoints, *inquiry.search.breakpoints))
    if known.total:
        x = x[np.isfinite(law.anyhow(x))]  # floating point may overflow where the law does not
    noise = rounding(law, x, where)
    if inquiry.kind == "slope":
        return _bad_slope(Quotient(subject=law, limits=inquiry.limits, noise=noise), x, inquiry, (where, known))
    if inquiry.kind == "odd":
        x = x[(-x >= where.low) & (-x <= where.high) & (x > 0)]
        if x.size == 0:
            raise InputError(f"on is {where}; oddness is about sigma and -sigma: give an interval with 0 inside")
        measure: Chord | Mirror = Mirror(subject=law, limits=inquiry.limits, noise=noise)
    else:
        if where.holds(0.0) and abs(law.at(0.0)) > noise:
            return _violation(inquiry, law, (0.0,), np.inf, (where, known))
        x = x[x != 0]
        measure = Chord(subject=law, limits=inquiry.limits, noise=noise)
    return _bad_point(measure, x, inquiry, (where, known))


def _bad_point(
    measure: Chord | Mirror, x: Array, inquiry: Inquiry, context: tuple[Domain, Decision]
) -> Violation | None:
    worst = worst_point(measure, x)
    if worst[0] <= 0:
        return None
    where = context[0]

    def excess(sigma: float) -> float:
        """How far a point violates."""
        mirrored = inquiry.kind == "odd" and not where.holds(-sigma)
        if sigma == 0 or not where.holds(sigma) or mirrored:
            return -np.inf
        point = np.array([sigma])
        try:
            value = measure.quantity(point)
        except NotANumber:
            return -np.inf
        return float((measure.limits.outside(value) - measure.allowance(point, value))[0])

    sigma = simplest_point(excess, (worst[0], worst[1][0]), size=measure.limits.size, unit=where.unit)
    found = float(measure.quantity(np.array([sigma]))[0])
    return _violation(inquiry, measure.subject, (sigma,), found, context, worst)


def _bad_slope(measure: Quotient, x: Array, inquiry: Inquiry, context: tuple[Domain, Decision]) -> Violation | None:
    worst = worst_pair(measure, x)
    if worst[0] <= 0:
        return None
    where, law = context[0], measure.subject

    def excess(low: float, high: float) -> float:
        """How far a pair violates."""
        if not (low < high and where.holds(low) and where.holds(high)):
            return -np.inf
        pair = np.array([low, high])
        try:
            phi = law(pair)
        except NotANumber:
            return -np.inf
        value = measure.quantity(pair, phi)
        return float((measure.limits.outside(value) - measure.allowance(pair, phi, value))[0])

    pair = simplest_pair(excess, (worst[0], worst[1][0], worst[1][1]), size=measure.limits.size, unit=where.unit)
    found = float(measure.quantity(np.array(pair), law(np.array(pair)))[0])
    return _violation(inquiry, law, pair, found, context, worst)


def _violation(  # noqa: PLR0913  (what was found where, and what else is known)
    inquiry: Inquiry,
    law: Subject,
    sigma: tuple[float, ...],
    found: float,
    context: tuple[Domain, Decision],
    worst: Worst | None = None,
) -> Violation:
    where, known = context
    how = f"Found in floating point, by a search of {law.evaluations} values on {where}."
    if worst is not None and worst[1] != sigma:
        places = " and ".join(map(number, worst[1]))
        how += f" The search began to shrink it from sigma = {places}."
    if known.verdict is Verdict.REFUTED:
        how += f" {known.how[0].upper()}{known.how[1:]} ({Evidence.CERTIFIED})."
    return Violation(
        kind=inquiry.kind,
        name=law.name,
        claim=_claim(law, inquiry),
        denial=f"{law.name} {inquiry.words[1]}",
        quantity=_QUANTITIES[inquiry.kind] if inquiry.kind != "slope" else "the slope of the chord",
        sigma=sigma,
        phi=tuple(law.at(point) for point in sigma),
        found=found,
        lower=inquiry.limits.lower,
        upper=inquiry.limits.upper,
        tolerance=inquiry.limits.tolerance,
        slope=_slope(law, sigma[0]) if inquiry.kind != "slope" else np.nan,
        on=(where.low, where.high),
        how=how,
        subject=law,
    )


def _slope(law: Subject, sigma: float) -> float:
    """A central difference quotient, nan where there is none: at a jump it grows as the step shrinks."""
    steps = [share * (abs(sigma) or 1e-3) for share in (1e-5, 1e-6)]
    try:
        wide, narrow = ((law.at(sigma + step) - law.at(sigma - step)) / (2 * step) for step in steps)
    except NotANumber:
        return float(np.nan)
    return narrow if abs(narrow - wide) <= 0.5 * abs(wide) else float(np.nan)


def _no_value(law: Subject, inquiry: Inquiry, error: NotANumber) -> str:
    def missing(sigma: float) -> float:
        """1 where the law has no value, 0 where it has."""
        try:
            law.at(sigma)
        except NotANumber:
            return 1.0
        return 0.0

    where = domain(inquiry.search.on)
    inside: Callable[[float], float] = lambda sigma: missing(sigma) if where.holds(sigma) else 0.0  # noqa: E731  (one line)
    sigma = simplest_point(inside, (1.0, error.sigma), size=1.0, unit=where.unit)
    try:
        law.at(sigma)
    except NotANumber as simpler:
        error = simpler
    return (
        f"it was not tested whether {_claim(law, inquiry)}: phi({number(error.sigma)}) {error}, and a law has a finite "
        "real value everywhere; name the interval on which this one has, on=(low, high)"
    )
