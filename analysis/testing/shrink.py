"""From a point that violates to the simplest number that does, as plainly."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

_PLAIN = (1.0, 2.0, 0.5, 3.0, 10.0, 0.1, 5.0, 0.2, 1.5, 100.0, 0.01, 1000.0, 0.001)
_SHARE = 0.2
_DIGITS = 17
_HALF = 0.5


def simplest_point(
    excess: Callable[[float], float], worst: tuple[float, float], *, size: float, unit: float = 1.0
) -> float:
    """A number of few digits with a violation worth showing.

    Parameters
    ----------
    excess : callable
        How far a point violates, positive if it does; ``-inf`` where nothing is asserted.
    worst : (excess, sigma)
        The violation to begin with.
    size : float
        Size of the bounds: a violation of a fifth of it is worth showing, however large the worst is.
    unit : float
        Power of ten in which plain numbers are tried.
    """
    enough = _enough(worst[0], size)
    for sigma in _points(worst[1], unit):
        if excess(sigma) >= enough:
            return sigma
    return worst[1]


def simplest_pair(
    excess: Callable[[float, float], float], worst: tuple[float, float, float], *, size: float, unit: float = 1.0
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
    unit : float
        Power of ten in which plain numbers are tried.
    """
    enough = _enough(worst[0], size)
    for pair in _pairs(worst[1], worst[2], unit):
        if excess(*pair) >= enough:
            return pair
    return worst[1], worst[2]


def _enough(worst: float, size: float) -> float:
    return _SHARE * min(worst, size) if size > 0 else _SHARE * min(worst, 1.0)


def _points(worst: float, unit: float) -> Iterator[float]:
    for plain in _plain(unit):
        yield plain
        yield -plain
    for digits in range(1, _DIGITS + 1):
        step = _step(worst, digits)
        steps = round(worst / step)
        for number in (steps, steps + 1, steps - 1):
            yield float(f"{number * step:.{digits}g}")


def _pairs(low: float, high: float, unit: float) -> Iterator[tuple[float, float]]:
    for plain in _plain(unit):
        for sign in (1.0, -1.0) if high > 0 else (-1.0, 1.0):
            first, second = sorted((0.0, sign * plain))
            yield first, second
            first, second = sorted((sign * plain, sign * 2 * plain))
            yield first, second
            first, second = sorted((sign * _HALF * plain, sign * plain))
            yield first, second
    middle = 0.5 * low + 0.5 * high
    for digits in range(1, _DIGITS + 1):
        step = _step(max(abs(low), abs(high)), digits)
        numbers = [math.floor(middle / step) + shift for shift in (-1, 0, 1, 2)]
        grid = [float(f"{number * step:.{digits}g}") for number in numbers]
        for i, j in ((1, 2), (0, 1), (2, 3), (0, 2), (1, 3)):
            if grid[i] < grid[j]:
                yield grid[i], grid[j]


def _plain(unit: float) -> list[float]:
    """The plainest numbers, in a unit."""
    return [float(f"{plain * unit:.3g}") for plain in _PLAIN]


def _step(value: float, digits: int) -> float:
    """The last of so many decimal digits of a number."""
    return float(f"1e{math.floor(math.log10(abs(value))) - digits + 1}") or 5e-324 if value else 1e-12
