"""The least value of a smooth function on an interval, with a rigorous bracket."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable
from dataclasses import dataclass

from flint import arb

MAX_BOXES = 200_000


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
    value: Callable[[arb], arb],
    slope: Callable[[arb], arb],
    low: arb,
    high: arb,
    *,
    width: Callable[[arb], arb],
) -> Minimum:
    r"""Branch and bound on ``[low, high]`` with balls: no sample can hide a dip.

    A box ``X`` with midpoint ``m`` is bounded below by the larger of ``f(X)`` and ``f(m) + f'(X)(X - m)``; where
    ``f'(X)`` has one sign, by the value at the end it points to.  A bound that is not finite is taken as minus
    infinity, so that a failure can only widen the bracket.

    Parameters
    ----------
    value, slope : callable
        ``f`` and ``f'`` as inclusion functions: for every ball ``X`` the result contains the image of ``X``.
    low, high : arb
        Ends of the interval; a ball stands for every end in it, and the larger interval is searched.
    width : callable
        Bracket width to stop at, given the best upper bound so far.

    Notes
    -----
    Stops after 200 000 boxes with the bracket reached (``closed`` false).
    """
    left, right = low.lower(), high.upper()
    best = arb("inf")
    where = left
    counter = itertools.count()
    heap: list[tuple[float, int, arb, arb, arb]] = []

    def offer(point: arb) -> arb:
        nonlocal best, where
        here = value(point)
        upper = here.upper()
        if upper < best:
            best, where = upper, point
        return here

    def push(a: arb, b: arb) -> None:
        box = a.union(b)
        middle = box.mid()
        at_middle = offer(middle)
        bound = value(box).lower()
        gradient = slope(box)
        if gradient.is_finite():
            centred = (at_middle + gradient * (box - middle)).lower()
            if gradient >= 0:
                centred = offer(a).lower()
            elif gradient <= 0:
                centred = offer(b).lower()
            if centred.is_finite() and (not bound.is_finite() or centred > bound):
                bound = centred
        if not bound.is_finite():
            bound = arb("-inf")
        heapq.heappush(heap, (float(bound), next(counter), bound, a, b))

    offer(left)
    offer(right)
    push(left, right)
    for _ in range(MAX_BOXES):
        _, _, bound, a, b = heap[0]
        if bound >= best - width(best):
            return Minimum(low=_least(heap, best), high=best, where=where, closed=True)
        heapq.heappop(heap)
        middle = a.union(b).mid()
        push(a, middle)
        push(middle, b)
    return Minimum(low=_least(heap, best), high=best, where=where, closed=False)


def _least(heap: list[tuple[float, int, arb, arb, arb]], best: arb) -> arb:
    # the heap is ordered by rounded keys: take the least bound itself
    least = best
    for entry in heap:
        if not entry[2] >= least:
            least = entry[2]
    return least.lower()
