"""From a point that violates to the simplest number that does, as plainly."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

_PLAIN = (1.0, 2.0, 0.5, 3.0, 10.0, 0.1, 5.0, 0.2, 1.5, 100.0, 0.01, 1000.0, 0.001)
_SHARE = 0.2
_DIGITS = 17
_HALF = 0.5


def simplest_point(excess: Callable[[float], float], worst: tuple[float, float], size: float) -> float:
    """A number of few digits with a violation worth showing.

    Parameters
    ----------
    excess : callable
        How far a point violates, positive if it does; ``-inf`` where nothing is asserted.
    worst : (excess, sigma)
        The violation to begin with.
    size : float
        Size of the bounds: a violation of a fifth of it is worth showing, however large the worst is.
    """
    enough = _enough(worst[0], size)
    for sigma in _points(worst[1]):
        if excess(sigma) >= enough:
            return sigma
    return worst[1]


def simplest_pair(
    excess: Callable[[float, float], float], worst: tuple[float, float, float], size: float
) -> tuple[float, float]:
    """A pair of numbers of few digits with a violation worth showing.

    Parameters
    ----------
    excess : callable
        How far a pair violates, positive if it does.
    worst : (excess, sigma, sigma)
        The violation to begin with.
    size : float
        Size of the bounds.
    """
    enough = _enough(worst[0], size)
    for pair in _pairs(worst[1], worst[2]):
        if excess(*pair) >= enough:
            return pair
    return worst[1], worst[2]


def _enough(worst: float, size: float) -> float:
    return _SHARE * min(worst, size) if size > 0 else _SHARE * min(worst, 1.0)


def _points(worst: float) -> Iterator[float]:
    for plain in _PLAIN:
        yield plain
        yield -plain
    for digits in range(1, _DIGITS + 1):
        unit = _unit(worst, digits)
        steps = round(worst / unit)
        for number in (steps, steps + 1, steps - 1):
            yield float(f"{number * unit:.{digits}g}")


def _pairs(low: float, high: float) -> Iterator[tuple[float, float]]:
    for plain in _PLAIN:
        for sign in (1.0, -1.0) if high > 0 else (-1.0, 1.0):
            first, second = sorted((0.0, sign * plain))
            yield first, second
            first, second = sorted((sign * plain, sign * 2 * plain))
            yield first, second
            first, second = sorted((sign * _HALF * plain, sign * plain))
            yield first, second
    middle = 0.5 * low + 0.5 * high
    for digits in range(1, _DIGITS + 1):
        unit = _unit(max(abs(low), abs(high)), digits)
        numbers = [math.floor(middle / unit) + shift for shift in (-1, 0, 1, 2)]
        grid = [float(f"{number * unit:.{digits}g}") for number in numbers]
        for i, j in ((1, 2), (0, 1), (2, 3), (0, 2), (1, 3)):
            if grid[i] < grid[j]:
                yield grid[i], grid[j]


def _unit(value: float, digits: int) -> float:
    """The last of so many decimal digits of a number."""
    return float(f"1e{math.floor(math.log10(abs(value))) - digits + 1}") or 5e-324 if value else 1e-12
