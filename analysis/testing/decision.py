"""What can be said of a known law without sampling it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from analysis.doubles import text_above, text_below
from analysis.evidence import Verdict
from analysis.testing.measures import Limits
from analysis.testing.parity import known_odd
from analysis.testing.subject import Subject
from lure.errors import AssumptionError, InputError
from lure.expressions import Expression
from lure.expressions.tree import is_total, names
from lure.laws.formula import ExpressionLaw
from lure.laws.properties import Standing, properties
from lure.sector import Sector, SlopeBounds

if TYPE_CHECKING:
    from analysis.bounds.result import Extreme


@dataclass(frozen=True, kw_only=True, slots=True)
class Decision:
    """A verdict for every ``sigma``, and in words what it rests on; INCONCLUSIVE with what stood in the way.

    ``total`` says that the law is known to have a value for every ``sigma``, whatever floating point makes of it.
    """

    verdict: Verdict = Verdict.INCONCLUSIVE
    how: str = ""
    total: bool = False


def decided(law: Subject, kind: str, limits: Limits, on: tuple[Fraction, Fraction] | None) -> Decision:
    """Whether a formula or a law of the library has a property, by exact or ball arithmetic.

    Parameters
    ----------
    law : Subject
        The law.
    kind : {"sector", "slope", "odd"}
        The property.
    limits : Limits
        Its bounds and the tolerance.
    on : tuple of Fraction or None
        The interval, None for all of R.
    """
    if kind == "odd":
        return _oddness(law.law, on)
    from analysis.bounds import law_bounds
    from analysis.bounds.result import above, below, stated

    try:
        bounds = law_bounds(law.law, on=on)
    except InputError as error:
        return Decision(how=f"for every sigma it was not decided: {error}")
    claim = _widened(kind, limits)
    verdict = bounds.within(claim)
    low, high = (
        (bounds.sector_lower, bounds.sector_upper) if kind == "sector" else (bounds.slope_lower, bounds.slope_upper)
    )
    if low is None or high is None:
        return Decision(
            how=f"for every sigma it was not decided: {bounds.notes[0]}" if bounds.notes else "", total=True
        )
    what = "phi(sigma)/sigma" if kind == "sector" else "the slope"
    everywhere = "for every sigma" if on is None else f"for every sigma of [{float(on[0]):g}, {float(on[1]):g}]"
    if verdict is Verdict.PROVED:
        ends = [f"{stated(end, side, certified=True)} {_place(end)}" for end, side in ((low, -1), (high, 1))]
        how = f"{everywhere} {what} is at least {ends[0].strip()} and at most {ends[1].strip()}"
        return Decision(verdict=verdict, how=how, total=True)
    if verdict is Verdict.REFUTED:
        broken = f"the supremum of {what} is {high}" if high.inner > claim.upper else f"the infimum of {what} is {low}"
        return Decision(verdict=verdict, how=broken, total=True)
    shown = f"[{text_below(float(below(low.outer)))}, {text_above(float(above(high.outer)))}]"
    return Decision(how=f"certified {everywhere} is only that {what} lies in {shown}", total=True)


def _place(end: Extreme) -> str:
    """Where a bound is reached or approached; nowhere that is known if it is infinite and something else was seen."""
    return "" if isinstance(end.outer, float) and not end.exact else end.where


def witness(law: Subject, kind: str, limits: Limits, on: tuple[Fraction, Fraction] | None) -> str:
    """An exact point, or pair, at which a known law breaks bounds that no double shows it to break; empty if none.

    Parameters
    ----------
    law : Subject
        The law.
    kind : {"sector", "slope"}
        The property.
    limits : Limits
        Its bounds and the tolerance.
    on : tuple of Fraction or None
        The interval, None for all of R.
    """
    from analysis.bounds import violation

    found = violation(law.law, _widened(kind, limits), on=on)
    if found is None:
        return ""
    places = [f"{float(point):.10g}" for point in found.points]
    what = "phi(sigma)/sigma" if kind == "sector" else "the slope"
    there = f"at sigma = {places[0]}" if len(places) == 1 else f"from sigma = {places[0]} to {places[1]}"
    beyond = float(abs(found.value - Fraction(found.bound)))
    return f"{what} passes the bound by {beyond:.2g} {there} ({found.evidence})"


def _widened(kind: str, limits: Limits) -> Sector | SlopeBounds:
    """The bounds, moved apart by the tolerance."""
    lower, upper = (
        bound if abs(bound) == math.inf else Fraction(bound) + side * Fraction(limits.tolerance)
        for bound, side in ((limits.lower, -1), (limits.upper, 1))
    )
    return Sector(lower, upper) if kind == "sector" else SlopeBounds(lower, upper)


def _oddness(law: object, on: tuple[Fraction, Fraction] | None) -> Decision:
    if isinstance(law, ExpressionLaw):
        odd = known_odd(law.expression, "sigma")
    elif isinstance(law, Expression):
        odd = known_odd(law, next(iter(names(law.tree)), law.variables[0]))
    else:
        try:
            known = properties(law).odd  # type: ignore[arg-type]  # a law of the library: what remains
        except AssumptionError:
            return Decision()
        odd = known.value if known.standing is Standing.CHECKED else None
    if odd is None:
        return Decision(total=True)
    if odd and not _has_values(law, on):
        return Decision(how="by its form it is odd where it has values, but that it has one everywhere was not shown")
    if odd:
        return Decision(verdict=Verdict.PROVED, how="for every sigma, by its form", total=True)
    return Decision(verdict=Verdict.REFUTED, how="the law is not odd, by its form", total=True)


def _has_values(law: object, on: tuple[Fraction, Fraction] | None) -> bool:
    """Whether a formula is known to have a value for every sigma, as a law of the library has."""
    from analysis.bounds.known import known_law
    from analysis.bounds.law import bounds_of_known, has_values

    if not isinstance(law, ExpressionLaw | Expression):
        return True
    if is_total((law if isinstance(law, Expression) else law.expression).tree):
        return True
    low, high = (-math.inf, math.inf) if on is None else on
    try:
        known = known_law(law, low, high)
        return known is not None and has_values(known, bounds_of_known(known, low, high))
    except InputError:
        return False
