"""A point, or two, at which a nonlinearity leaves a sector or slope bounds."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from fractions import Fraction

from lure.analysis.nonlinearity.bounds import nonlinearity_bounds
from lure.analysis.nonlinearity.pieces import Value, domain, known_nonlinearity
from lure.analysis.nonlinearity.rational import BITS, End
from lure.analysis.nonlinearity.result import Bound, Extreme, NonlinearityBounds, Quantity
from lure.analysis.numerics.precision import working_precision
from lure.analysis.verdict import Evidence, Verdict
from lure.arrays import np
from lure.classes import Sector, SlopeBounds
from lure.errors import InputError
from lure.exact import nearest_double
from lure.nonlinearities import Quantiser
from lure.record import Page, Record
from lure.record import quantity as declared
from lure.record.values import exact_text

_HALVINGS = 200


def _exact(value: Fraction) -> dict[str, object]:
    return {"exact": str(value), "double": nearest_double(value)}


class Violation(Record):
    """A chord slope, or a difference quotient, beyond a bound."""

    quantity: Quantity = declared("Whether it is ``phi(sigma)/sigma`` or ``(phi(x) - phi(y))/(x - y)``")
    points: tuple[Fraction, ...] = declared("``sigma``, or ``x`` and ``y``", plainly=lambda xs: [*map(_exact, xs)])
    value: Fraction = declared(
        "The chord slope or difference quotient, to about 40 digits where the nonlinearity has no rational values",
        plainly=_exact,
    )
    bound: Bound = declared("The bound that is passed", plainly=str)
    evidence: Evidence = declared(
        "CERTIFIED if exact or ball arithmetic shows that the value is beyond the bound, OBSERVED for a function that "
        "is known by the doubles it returns"
    )

    def _page(self) -> Page:
        ratio = "phi(sigma)/sigma" if self.quantity == "sector" else "(phi(x) - phi(y))/(x - y)"
        rows = [
            (ratio, exact_text(self.value, 10)),
            ("bound", exact_text(self.bound, 10)),
            ("at", ", ".join(exact_text(point, 17) for point in self.points)),
            ("evidence", self.evidence),
        ]
        verdict = "REFUTED" if self.evidence is Evidence.CERTIFIED else "OBSERVED"
        return Page(f"a {self.quantity} bound is passed", rows, verdict=verdict)

    def __str__(self) -> str:
        sign = ">" if self.value > self.bound else "<"
        said = f"{exact_text(self.value, 10)} {sign} {exact_text(self.bound, 10)} ({self.evidence})"
        if self.quantity == "sector":
            return f"phi(sigma)/sigma = {said} at sigma = {exact_text(self.points[0], 10)}"
        x, y = (exact_text(point, 17) for point in self.points)
        return f"the difference quotient is {said} between sigma = {x} and {y}"


def violation(
    nonlinearity: object,
    bounds: Sector | SlopeBounds,
    *,
    on: object = None,
    found: NonlinearityBounds | None = None,
    samples: int = 4001,
) -> Violation | None:
    """A point at which phi leaves a sector, or two between which it leaves slope bounds; None if none was found.

    That none was found proves nothing: ask ``nonlinearity_bounds(nonlinearity).within(bounds)``.

    Parameters
    ----------
    nonlinearity : nonlinearity of lure.nonlinearities, Expression, str or callable
        As for :func:`nonlinearity_bounds`.
    bounds : Sector or SlopeBounds
        What the nonlinearity may not leave.
    on : pair of numbers, optional
        The interval; all of R by default.
    found : NonlinearityBounds, optional
        What :func:`nonlinearity_bounds` found for the same nonlinearity and interval, to spare the work.
    samples : int
        For a callable.

    Raises
    ------
    InputError
        As for :func:`nonlinearity_bounds`.

    Examples
    --------
    >>> print(violation("sigma**3", Sector(0, 1), on=(-2, 2)))
    phi(sigma)/sigma = 4 > 1 (certified) at sigma = -2
    """
    interval = domain(on)
    known = nonlinearity_bounds(nonlinearity, on=on, samples=samples) if found is None else found
    if known.within(bounds) is not Verdict.REFUTED:
        return None
    quantity: Quantity = "sector" if isinstance(bounds, Sector) else "slope"
    low, high = (-math.inf, math.inf) if interval is None else interval
    with working_precision(BITS):
        value, evidence = _values(nonlinearity, low, high)
        ends = (
            (known.sector_lower, known.sector_upper) if quantity == "sector" else (known.slope_lower, known.slope_upper)
        )
        for sign, extreme, bound in ((-1, ends[0], bounds.lower), (1, ends[1], bounds.upper)):
            if extreme is None or bound in (math.inf, -math.inf) or sign * extreme.inner <= sign * bound:
                continue
            for points in _places(extreme, quantity):
                if all(low <= x <= high for x in points):
                    beyond = _beyond(value, points, sign, Fraction(bound))
                    if beyond is not None:
                        return Violation(
                            quantity=quantity, points=points, value=beyond, bound=Fraction(bound), evidence=evidence
                        )
    return None


def _values(nonlinearity: object, low: End, high: End) -> tuple[Callable[[Fraction], Value], Evidence]:
    if isinstance(nonlinearity, Quantiser):
        return nonlinearity.exact, Evidence.CERTIFIED
    known = known_nonlinearity(nonlinearity, low, high)
    if known is not None:
        return known.value, Evidence.CERTIFIED
    if not callable(nonlinearity):
        raise InputError(
            f"the nonlinearity is {nonlinearity!r:.60}; give a formula in sigma, a nonlinearity of "
            f"lure.nonlinearities, or "
            "a function"
        )
    function = nonlinearity
    return lambda x: Fraction(float(np.asarray(function(float(x))))), Evidence.OBSERVED


def _beyond(
    value: Callable[[Fraction], Value], points: tuple[Fraction, ...], sign: int, bound: Fraction
) -> Fraction | None:
    """The chord slope or difference quotient if it is certainly beyond the bound: its end nearest to the bound."""
    try:
        found = [value(x) for x in points]
    except InputError:
        return None
    spans = [part if isinstance(part, tuple) else (part, part) for part in found]
    if len(points) == 1:
        steps, width = spans[0], points[0]
    else:
        steps, width = (spans[1][0] - spans[0][1], spans[1][1] - spans[0][0]), points[1] - points[0]
    low, high = _pair(steps[0] / width, steps[1] / width)
    nearest = low if sign > 0 else high
    return nearest if sign * nearest > sign * bound else None


def _places(extreme: Extreme, quantity: Quantity) -> Iterator[tuple[Fraction, ...]]:
    """Points, or pairs, ever closer to where an extreme is taken or approached."""
    at = extreme.at
    if isinstance(at, tuple):
        yield from _around(_simple(*at), (-1, 1), quantity)
        if quantity == "slope":
            yield at
        return
    if isinstance(at, Fraction):
        yield from _around(at, (-1, 1), quantity)
        return
    place = at.rpartition(" ")[2]
    if place in ("inf", "-inf"):
        side = 1 if place == "inf" else -1
        for k in range(_HALVINGS):
            x = side * Fraction(2**k)
            yield (x,) if quantity == "sector" else _pair(x, x + side)
        return
    sides = (1,) if place.endswith("+") else (-1,) if place.endswith("-") else (-1, 1)
    try:
        centre = Fraction(place.rstrip("+-"))
    except ValueError:
        return
    yield from _around(centre, sides, quantity)


def _around(centre: Fraction, sides: tuple[int, ...], quantity: Quantity) -> Iterator[tuple[Fraction, ...]]:
    if quantity == "sector" and centre != 0:
        yield (centre,)
    for k in range(_HALVINGS):
        step = Fraction(1, 2**k) * max(Fraction(1), abs(centre))
        if quantity == "sector":
            yield from ((centre + side * step,) for side in sides if centre + side * step != 0)
            continue
        if len(sides) == 2:
            yield centre - step, centre + step
        yield from (_pair(centre, centre + side * step) for side in sides)
        yield from (_pair(centre + side * step, centre + 2 * side * step) for side in sides)


def _pair(x: Fraction, y: Fraction) -> tuple[Fraction, Fraction]:
    return (x, y) if x < y else (y, x)


def _simple(low: Fraction, high: Fraction) -> Fraction:
    """A number of few digits in an interval."""
    middle = (low + high) / 2
    for digits in range(1, 60):
        guess = middle.limit_denominator(10**digits)
        if low <= guess <= high:
            return guess
    return middle
