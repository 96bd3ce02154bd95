"""The least value of a smooth function on an interval, with a rigorous bracket."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, overload

from flint import arb, arb_series

SOFT_BOXES = 1_000
MAX_BOXES = 20_000
ORDER = 6


class Function(Protocol):
    """A smooth function as an inclusion function.

    On a ball it contains the image of the ball; on a power series ``X + h`` the coefficient of ``h^j`` contains
    ``f_j(x) = f^(j)(x)/j!`` for every ``x`` in ``X``.
    """

    @overload
    def __call__(self, x: arb, /) -> arb: ...
    @overload
    def __call__(self, x: arb_series, /) -> arb_series: ...


@dataclass(frozen=True, kw_only=True, slots=True)
class Minimum:
    """A bracket on ``min f`` and a point near the minimiser.

    Attributes
    ----------
    low, high : arb
        ``low <= min f <= high``, both exact numbers.
    where : arb
        Point at which ``f <= high``.
    closed : bool
        Whether the bracket reached the width asked for; it is valid either way.
    """

    low: arb
    high: arb
    where: arb
    closed: bool


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
        offer(middle)
        bound = f(box).lower()
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
