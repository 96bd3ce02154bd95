"""What is known of a nonlinearity for every ``sigma``: bounds and oddness, by exact or ball arithmetic."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from lure.analysis.nonlinearity.result import Extreme
from lure.analysis.nonlinearity.shape import known_odd
from lure.analysis.numerics.doubles import text_above, text_below
from lure.analysis.testing.result import NonlinearityViolation
from lure.analysis.testing.search import Limits, Subject
from lure.analysis.verdict import Verdict
from lure.classes import Sector, SlopeBounds
from lure.errors import AssumptionError, InputError
from lure.expressions import Expression
from lure.expressions.tree import is_total, names
from lure.nonlinearities.formula import ExpressionNonlinearity
from lure.nonlinearities.properties import Provenance, properties


@dataclass(frozen=True, kw_only=True, slots=True)
class Decision:
    """A verdict for every ``sigma``, and in words what it rests on; INCONCLUSIVE with what stood in the way.

    ``total`` says that the nonlinearity is known to have a value for every ``sigma``, whatever doubles make of it.
    """

    verdict: Verdict = Verdict.INCONCLUSIVE
    how: str = ""
    total: bool = False


def decided(nonlinearity: Subject, kind: str, limits: Limits, on: tuple[Fraction, Fraction] | None) -> Decision:
    """Whether a formula or a nonlinearity of the library has a property, by exact or ball arithmetic.

    Parameters
    ----------
    nonlinearity : Subject
        The nonlinearity.
    kind : {"sector", "slope", "odd"}
        The property.
    limits : Limits
        Its bounds and the tolerance.
    on : tuple of Fraction or None
        The interval, None for all of R.

    Raises
    ------
    NonlinearityViolation
        The formula divides by zero at a point of the interval.
    """
    if kind == "odd":
        return _oddness(nonlinearity.nonlinearity, on)
    from lure.analysis.nonlinearity import nonlinearity_bounds
    from lure.analysis.nonlinearity.pieces import Undefined
    from lure.analysis.nonlinearity.result import above, below, stated

    try:
        bounds = nonlinearity_bounds(nonlinearity.nonlinearity, on=on)
    except Undefined as error:  # doubles may step over it: 1/0 is inf, and sign(inf) is 1
        raise NonlinearityViolation(
            f"{nonlinearity.name} has no value at sigma = {float(error.place):.10g}, where it divides by zero, and a "
            "nonlinearity has a finite real value everywhere; name the interval on which this one has, on=(low, high)"
        ) from None
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


def witness(nonlinearity: Subject, kind: str, limits: Limits, on: tuple[Fraction, Fraction] | None) -> str:
    """An exact point, or pair, at which a known graph breaks bounds that no double shows it to break; empty if none.

    Parameters
    ----------
    nonlinearity : Subject
        The nonlinearity.
    kind : {"sector", "slope"}
        The property.
    limits : Limits
        Its bounds and the tolerance.
    on : tuple of Fraction or None
        The interval, None for all of R.
    """
    from lure.analysis.nonlinearity import violation

    found = violation(nonlinearity.nonlinearity, _widened(kind, limits), on=on)
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


def _oddness(phi: object, on: tuple[Fraction, Fraction] | None) -> Decision:
    if isinstance(phi, ExpressionNonlinearity):
        odd = known_odd(phi.expression, "sigma")
    elif isinstance(phi, Expression):
        odd = known_odd(phi, next(iter(names(phi.tree)), phi.variables[0]))
    else:
        try:
            known = properties(phi).odd  # type: ignore[arg-type]  # a nonlinearity of the library: what remains
        except AssumptionError:
            return Decision()
        odd = known.value if known.provenance is Provenance.CHECKED else None
    if odd is None:
        return Decision(total=True)
    if odd and not _has_values(phi, on):
        return Decision(how="by its form it is odd where it has values, but that it has one everywhere was not shown")
    if odd:
        return Decision(verdict=Verdict.PROVED, how="for every sigma, by its form", total=True)
    return Decision(verdict=Verdict.REFUTED, how="the nonlinearity is not odd, by its form", total=True)


def _has_values(phi: object, on: tuple[Fraction, Fraction] | None) -> bool:
    """Whether a formula is known to have a value for every sigma, as a nonlinearity of the library has."""
    from lure.analysis.nonlinearity.bounds import bounds_of_known, has_values
    from lure.analysis.nonlinearity.pieces import known_nonlinearity

    if not isinstance(phi, ExpressionNonlinearity | Expression):
        return True
    if is_total((phi if isinstance(phi, Expression) else phi.expression).tree):
        return True
    low, high = (-math.inf, math.inf) if on is None else on
    try:
        known = known_nonlinearity(phi, low, high)
        return known is not None and has_values(known, bounds_of_known(known, low, high))
    except InputError:
        return False
