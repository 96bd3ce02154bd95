"""Where in a box of parameters a number is least: the corners, the middle, a few more points, then along one at a time.

In floating point: what is found is a plant to look at, and nothing follows of the others.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import lru_cache
from itertools import islice
from random import Random
from typing import Protocol, TypeVar

from lure.analysis.certificates.drafts import guarded
from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.box_polynomials import MOST_CORNERS
from lure.analysis.theorems.table import TABLE
from lure.analysis.verdict import CriterionResult
from lure.plants.delay import DelayPlant
from lure.plants.family import Box, PlantFamily, Point
from lure.plants.rational import RationalPlant

MOST_LOOKS, RANDOM = 40, 4
One = TypeVar("One", covariant=True)


class Many(Protocol[One]):
    """Plants with parameters in a box."""

    @property
    def box(self) -> Box:
        """The bounds of the parameters."""

    @property
    def middle(self) -> Point:
        """The middle of the box."""

    @property
    def corners(self) -> Iterator[Point]:
        """The corners of the box."""

    def at(self, point: Point, /) -> One:
        """The plant with these parameters."""


def least(family: Many[One], value: Callable[[One], float], *, looks: int = MOST_LOOKS) -> tuple[Point, float]:
    """A point of the box at which a number is about least, and the number.

    Parameters
    ----------
    family : PlantFamily or ChannelFamily
        The plants.
    value : callable
        The number for a plant.
    looks : int
        How many plants are looked at.
    """
    seen = dict[Point, float]()

    def at(point: Point) -> float:
        """The number at a point."""
        checkpoint()
        if point not in seen:
            seen[point] = value(family.at(point))
        return seen[point]

    dice = Random(1)
    points = [family.middle, *islice(family.corners, MOST_CORNERS)]
    for _ in range(RANDOM):
        points.append(tuple(low + (high - low) * Fraction(dice.randrange(65), 64) for low, high in family.box))
    best = min(points, key=at)
    step = Fraction(1, 4)
    while len(seen) < looks and step > Fraction(1, 2**20):
        near = [_moved(best, j, family.box, sign * step) for j in range(len(best)) for sign in (1, -1)]
        better = min(near, key=at)
        best, step = (better, step) if at(better) < at(best) else (best, step / 4)
    return best, at(best)


def _moved(point: Point, j: int, box: Box, share: Fraction) -> Point:
    low, high = box[j]
    return (*point[:j], min(max(point[j] + share * (high - low), low), high), *point[j + 1 :])


@lru_cache(maxsize=16)
def cheaply_worst(family: PlantFamily, lower: Fraction) -> Point:
    """The plant for which Popov's criterion, in discrete time the circle criterion, goes least far.

    ``lower``: lower end of the classes.
    """
    row = next(row for row in TABLE if row.name == ("popov" if family.dt is None else "circle"))

    def reach(plant: RationalPlant | DelayPlant) -> float:
        """How far the criterion reaches for one plant; ``inf`` where it fails."""
        found = guarded("the worst plant", lambda: row.answer(plant, lower=lower, odd=False), passing=(TimeoutError,))
        return found.largest.low if isinstance(found, CriterionResult) else math.inf

    return least(family, reach)[0]
