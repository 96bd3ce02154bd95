"""Piecewise linear graphs through the origin: everything about them is exact and read off the points."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.exact import exact_number
from lure.laws.law import number_text
from lure.sector import Sector, SlopeBounds


@dataclass(frozen=True, slots=True)
class Graph:
    """A continuous piecewise linear function with ``phi(0) = 0``.

    Attributes
    ----------
    knots, values : tuple of Fraction
        Points of the graph in ascending order, the origin among them.
    slopes : tuple of Fraction
        Slope left of the first knot, between the knots, right of the last: one more than there are knots.
    table : NDArray[np.float64]
        Rows for floats: the knots; then for each of the slopes the point of its segment nearest to 0, the value and the
        primitive there, and the slope itself.
    """

    knots: tuple[Fraction, ...]
    values: tuple[Fraction, ...]
    slopes: tuple[Fraction, ...]
    table: tuple[NDArray[np.float64], ...] = field(init=False, repr=False, compare=False)

    @classmethod
    def through(cls, points: Sequence[tuple[Fraction, Fraction]], left: Fraction, right: Fraction) -> Graph:
        """The graph through ascending points with these slopes outside them; the origin is added if it lies on it."""
        x, y = [point[0] for point in points], [point[1] for point in points]
        if 0 not in x:
            place = bisect_left(x, Fraction(0))
            x.insert(place, Fraction(0))
            y.insert(place, Fraction(0))
        inner = [(y1 - y0) / (x1 - x0) for (x0, y0), (x1, y1) in pairwise(zip(x, y, strict=True))]
        return cls(tuple(x), tuple(y), (left, *inner, right))

    def __post_init__(self) -> None:
        for i, slope in enumerate(self.slopes):
            exact_number(slope, f"slope {i + 1} of the graph")
        last = len(self.knots) - 1
        anchors = [min(i, last) if i == 0 or self.knots[i - 1] < 0 else i - 1 for i in range(len(self.slopes))]
        integrals = self._integrals()
        columns = [(self.knots[a], self.values[a], integrals[a], s) for a, s in zip(anchors, self.slopes, strict=True)]
        rows = (self.knots, *zip(*columns, strict=True))
        object.__setattr__(self, "table", tuple(np.array([float(number) for number in row]) for row in rows))

    def _integrals(self) -> list[Fraction]:
        """``int_0^knot phi`` at each knot."""
        sums = [Fraction(0)]
        for (x0, x1), (y0, y1) in zip(pairwise(self.knots), pairwise(self.values), strict=True):
            sums.append(sums[-1] + (x1 - x0) * (y0 + y1) / 2)
        origin = sums[self.knots.index(Fraction(0))]
        return [total - origin for total in sums]

    @property
    def kinks(self) -> tuple[Fraction, ...]:
        """Where the slope changes."""
        return tuple(x for x, (s0, s1) in zip(self.knots, pairwise(self.slopes), strict=True) if s0 != s1)

    @property
    def chords(self) -> list[tuple[Fraction, str]]:
        """Every value at which ``phi(sigma)/sigma`` can be extreme, with where: it is monotone between these places."""
        at_zero = self.knots.index(Fraction(0))
        ends = [(self.slopes[0], "as sigma -> -inf"), (self.slopes[-1], "as sigma -> inf")]
        ends += [(self.slopes[at_zero], "as sigma -> 0-"), (self.slopes[at_zero + 1], "as sigma -> 0+")]
        return ends + [
            (y / x, f"at sigma = {number_text(x)}") for x, y in zip(self.knots, self.values, strict=True) if x != 0
        ]

    @property
    def sector(self) -> Sector:
        """The tightest sector."""
        chords = [chord for chord, _ in self.chords]
        return Sector(min(chords), max(chords))

    @property
    def slope_bounds(self) -> SlopeBounds:
        """The tightest slope bounds."""
        return SlopeBounds(min(self.slopes), max(self.slopes))

    @property
    def is_line(self) -> bool:
        """Whether the graph is a straight line."""
        return len(set(self.slopes)) == 1

    @property
    def odd(self) -> bool:
        """Whether the graph is its own mirror image in the origin."""
        return self.slopes[0] == self.slopes[-1] and all(self.exact(-x) == -self.exact(x) for x in self.knots)

    def exact(self, sigma: Fraction) -> Fraction:
        """The value at an exact point, exactly."""
        i = bisect_left(self.knots, sigma)
        anchor = min(i, len(self.knots) - 1)
        return self.values[anchor] + self.slopes[i] * (sigma - self.knots[anchor])

    def __call__(self, sigma: ArrayLike) -> NDArray[np.float64]:
        """Values, elementwise."""
        x, (x0, y0, _, s) = self._segments(sigma)
        with np.errstate(over="ignore", invalid="ignore"):
            return np.where(np.isnan(x) | (s != 0), y0 + s * (x - x0), y0)

    def slope(self, sigma: ArrayLike) -> NDArray[np.float64]:
        """Slopes, elementwise; at a kink the one from the left."""
        x, (_, _, _, s) = self._segments(sigma)
        return np.where(np.isnan(x), x, s)

    def primitive(self, sigma: ArrayLike) -> NDArray[np.float64]:
        """``int_0^sigma phi``, elementwise."""
        x, (x0, y0, p0, s) = self._segments(sigma)
        with np.errstate(over="ignore", invalid="ignore"):
            step = x - x0
            flat = np.where(np.isnan(x) | (y0 != 0), y0 * step, 0.0)
            return np.where(s != 0, p0 + step * (y0 + 0.5 * s * step), p0 + flat)

    def shifted(self, gain: Fraction) -> Graph:
        """The graph of ``phi(sigma) - gain sigma``."""
        values = tuple(y - gain * x for x, y in zip(self.knots, self.values, strict=True))
        return Graph(self.knots, values, tuple(s - gain for s in self.slopes))

    def _segments(self, sigma: ArrayLike) -> tuple[NDArray[np.float64], tuple[NDArray[np.float64], ...]]:
        x = np.asarray(sigma, dtype=float)
        i = np.searchsorted(self.table[0], x, side="left")
        return x, tuple(row[i] for row in self.table[1:])
