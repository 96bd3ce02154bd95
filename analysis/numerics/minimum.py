"""The infimum of a rational function on the half-line, from all its stationary points, in ball arithmetic."""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Callable
from fractions import Fraction
from typing import Protocol, TypeVar, overload

from flint import arb, arb_series, fmpq_poly

from lure.analysis.numerics.polynomial import X, positive_from_zero, positive_root_count, real_roots, to_fmpq
from lure.analysis.numerics.precision import working_precision
from lure.record import described, quantity

# The least value of a smooth function on an interval, with a rigorous bracket.

SOFT_BOXES = 1_000
MAX_BOXES = 20_000
ORDER = 6


Number = TypeVar("Number", arb, arb_series)


class Function(Protocol):
    """A smooth function as an inclusion function.

    On a ball it contains the image of the ball; on a power series ``X + h`` the coefficient of ``h^j`` contains
    ``f_j(x) = f^(j)(x)/j!`` for every ``x`` in ``X``.
    """

    @overload
    def __call__(self, x: arb, /) -> arb: ...
    @overload
    def __call__(self, x: arb_series, /) -> arb_series: ...


@described(frozen=True, kw_only=True, slots=True)
class Minimum:
    """A bracket on ``min f`` and a point near the minimiser."""

    low: arb = quantity("``low <= min f <= high``, both exact numbers")
    high: arb
    where: arb = quantity("Point at which ``f <= high``")
    closed: bool = quantity("Whether the bracket reached the width asked for; it is valid either way")


def minimum(
    f: Function,
    low: arb,
    high: arb,
    *,
    width: Callable[[arb], arb],
    floor: arb | None = None,
) -> Minimum:
    r"""Branch and bound on ``[low, high]`` with balls: no sample can hide a dip.

    A box ``X`` with midpoint ``m`` and half width ``w`` is bounded below by the larger of ``f(X)`` and the Taylor bound
    ``f(m) - |f'(m)| w + min(f''(m)/2, 0) w^2 - sum |f_j(m)| w^j - |f_K(X)| w^K``.  A bound that is not finite is
    taken as
    minus infinity, so that a failure can only widen the bracket.

    Parameters
    ----------
    f : Function
        The function, on balls and on power series.
    low, high : arb
        Ends of the interval; a ball stands for every end in it, and the larger interval is searched.
    width : callable
        Bracket width to stop at, given the best upper bound so far.
    floor : arb, optional
        A lower bound on ``f`` known beforehand.

    Notes
    -----
    After 1 000 boxes it stops as soon as the sign of the minimum is known, after 20 000 in any case, with the bracket
    reached by then (``closed`` false).
    """
    left, right = low.lower(), high.upper()
    best, where = arb("inf"), left
    counter = itertools.count()
    heap: list[tuple[float, int, arb, arb, arb]] = []

    def offer(point: arb) -> None:
        """Keep the value at a point if it is the least so far."""
        nonlocal best, where
        upper = f(point).upper()
        if upper < best:
            best, where = upper, point

    def push(a: arb, b: arb) -> None:
        """Bound a box from below and queue it."""
        box = a.union(b)
        middle = box.mid()
        bound = f(box).lower()
        if not bound >= best - width(best):  # a box that is not looked into needs no better one
            offer(middle)
            by_taylor = _taylor_bound(f, box, middle)
            if by_taylor.is_finite() and not bound >= by_taylor:
                bound = by_taylor
        if floor is not None and not bound >= floor:
            bound = floor.lower()
        if not bound.is_finite():
            bound = arb("-inf")
        heapq.heappush(heap, (float(bound), next(counter), bound, a, b))

    offer(left)
    offer(right)
    push(left, right)
    for boxes in range(MAX_BOXES):
        _, _, bound, a, b = heap[0]
        if bound >= best - width(best):
            return Minimum(low=_least(heap, best), high=best, where=where, closed=True)
        if boxes >= SOFT_BOXES and (bound > 0 or best < 0):
            break
        heapq.heappop(heap)
        middle = a.union(b).mid()
        push(a, middle)
        push(middle, b)
    return Minimum(low=_least(heap, best), high=best, where=where, closed=False)


def _taylor_bound(f: Function, box: arb, middle: arb) -> arb:
    try:
        at_middle = _coefficients(f(arb_series([middle, 1], prec=ORDER)), ORDER)
        remainder = _coefficients(f(arb_series([box, 1], prec=ORDER + 1)), ORDER + 1)[ORDER]
    except (ValueError, ZeroDivisionError):  # a divisor that may vanish on the box, a series cut short
        return arb("-inf")
    half = (box - middle).abs_upper()
    curvature = at_middle[2].lower()
    bound = at_middle[0] - abs(at_middle[1]) * half - abs(remainder) * half**ORDER
    if not curvature >= 0:
        bound += curvature * half**2
    for power in range(3, ORDER):
        bound -= abs(at_middle[power]) * half**power
    return bound.lower()


def _coefficients(series: arb_series, count: int) -> list[arb]:
    if series.prec < count:  # what was cut off is unknown, not zero
        raise ValueError(f"a series of {series.prec} terms has no {count} coefficients")
    found = list(series.coeffs())
    return found + [arb(0)] * (count - len(found))


def _least(heap: list[tuple[float, int, arb, arb, arb]], best: arb) -> arb:
    # the heap is ordered by rounded keys: take the least bound itself
    least = best
    for entry in heap:
        if not entry[2] >= least:
            least = entry[2]
    return least.lower()


FIRST_BITS = 128
RELATIVE_BITS = 60


@described(frozen=True, kw_only=True, slots=True)
class Infimum:
    """A bracket on the infimum of ``U/D`` over ``[0, inf]``."""

    low: arb = quantity("``low <= inf U/D <= high``; equal where the infimum is 0")
    high: arb
    where: float = quantity("``x`` at which it is attained; ``inf`` if only in the limit")


def infimum(U: fmpq_poly, D: fmpq_poly) -> Infimum:
    r"""The infimum of ``U(x)/D(x)`` over ``x >= 0``, the limit at infinity included, to a relative width of ``2^-60``.

    It is attained at 0, at infinity or at a positive root of ``U' D - U D'``, all of which are enclosed; stationary
    points at which ``U`` vanishes too are told apart by a common divisor, so that an infimum of 0 is found as 0.

    ``U``, ``D``: ``D`` positive on ``(0, inf)`` and of at least the degree of ``U``; factors ``x`` of both are left
    out.

    Raises
    ------
    ValueError
        ``D`` is zero, ``D(0) < 0``, or ``U/D`` is not bounded at infinity.
    """
    while D.degree() > 0 and D[0] == 0 and U[0] == 0:
        U, D = U // X, D // X
    if not (D.degree() >= 0 and D[0] >= 0 and U.degree() <= D.degree()):
        raise ValueError("infimum needs D(0) >= 0 and U of at most the degree of D")
    if D[0] == 0 and U[0] < 0:
        return Infimum(low=arb("-inf"), high=arb("-inf"), where=0.0)
    ends = [(U[D.degree()] / D[D.degree()], math.inf)]
    ends = [(U[0] / D[0], 0.0), *ends] if D[0] > 0 else ends
    stationary = U.derivative() * D - U * D.derivative()
    touching = stationary.gcd(U) if stationary.degree() > 0 else fmpq_poly([1])
    rest = stationary // touching
    bits = FIRST_BITS
    while True:
        with working_precision(bits):
            found = [(arb(value), where) for value, where in ends]
            found += [(arb(0), float(x)) for x in real_roots(touching) if x > 0]
            if rest.degree() > 0:
                found += [(at(U, x) / at(D, x), float(x)) for x in real_roots(rest) if x > 0]
            low, high = found[0][0].lower(), found[0][0].upper()
            for value, _ in found[1:]:
                low, high = low.min(value.lower()), high.min(value.upper())
            if high - low <= abs(high) * arb(2) ** -RELATIVE_BITS:
                where = next(where for value, where in found if value.lower() <= high)
                return Infimum(low=low, high=high, where=where)
        bits *= 2


def positive_with_limits(p: fmpq_poly, degree: int) -> bool:
    """Whether ``p > 0`` on ``[0, inf)`` and ``p(x)/x^degree`` has a positive limit."""
    return p.degree() == degree and positive_from_zero(p)


def nonnegative_from_zero(p: fmpq_poly) -> bool:
    """Whether ``p(x) >= 0`` for every ``x >= 0``: it is zero, or its sign never changes and ends positive."""
    if p.degree() < 0:
        return True
    odd = [fmpq_poly(factor) for factor, multiplicity in p.numer().factor_squarefree()[1] if int(multiplicity) % 2]
    return bool(p[p.degree()] > 0) and all(positive_root_count(factor) == 0 for factor in odd)


def largest_below(p: fmpq_poly, q: fmpq_poly, guess: float, shift: Fraction = Fraction(0)) -> float | None:
    """A double ``k <= guess``, near it, with ``p + (k - shift) q > 0`` on ``[0, inf]``; None if none above ``shift``.

    Parameters
    ----------
    p, q : fmpq_poly
        ``p > 0`` on ``[0, inf]`` and of at least the degree of ``q``.
    guess : float
        The largest ``k`` of this kind or a little less, as a lower bound known by other means.
    shift : Fraction
        Where ``k`` counts from.

    Notes
    -----
    The test is exact, and independent of how ``guess`` was found.
    """
    k = guess
    step = math.ulp(guess)
    while k > shift:
        if positive_with_limits(p + to_fmpq(Fraction(k) - shift) * q, p.degree()):
            return k
        k -= step
        step *= 2
    return None


def at(p: fmpq_poly, x: Number) -> Number:
    """``p(x)`` for a ball or a power series ``x``."""
    total: Number = 0 * x
    for coefficient in reversed(p.coeffs()):
        total = total * x + arb(coefficient)
    return total


def sinc(x: Number) -> Number:
    """``sin(x)/x`` of a ball or a power series; a series needs a constant term that is not 0."""
    return x.sinc() if isinstance(x, arb) else x.sin() / x
