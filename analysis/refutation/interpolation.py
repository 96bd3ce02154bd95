"""Laws through finitely many points, exact: which slopes and which sector they have."""

from __future__ import annotations

import bisect
import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction

from lure.errors import InputError

Point = tuple[Fraction, Fraction]


@dataclass(frozen=True, slots=True)
class PiecewiseLinear:
    r"""``phi`` linear between the points, and of slope ``tail`` outside them.

    Attributes
    ----------
    points : tuple of (sigma, phi)
        In ascending ``sigma``, one of them ``(0, 0)``.
    tail : Fraction
        Slope to the left of the first and to the right of the last point.
    """

    points: tuple[Point, ...]
    tail: Fraction

    @classmethod
    def through(cls, points: Iterable[Sequence[Fraction]], tail: Fraction, *, odd: bool = False) -> PiecewiseLinear:
        """The law through the points and ``(0, 0)``, for ``odd`` also through the mirrored points.

        Raises
        ------
        InputError
            Two points have the same ``sigma`` but not the same ``phi``: no law passes through both.
        """
        given = {(Fraction(s), Fraction(w)) for s, w in points} | {(Fraction(0), Fraction(0))}
        if odd:
            given |= {(-s, -w) for s, w in given}
        ordered = tuple(sorted(given))
        for (s, w), (t, v) in itertools.pairwise(ordered):
            if s == t:
                raise InputError(f"no law passes through both ({s}, {w}) and ({t}, {v}); give one value for each sigma")
        return cls(ordered, Fraction(tail))

    @property
    def slopes(self) -> tuple[Fraction, Fraction]:
        """Least and largest difference quotient of the law."""
        steps = [(v - w) / (t - s) for (s, w), (t, v) in itertools.pairwise(self.points)]
        return min([self.tail, *steps]), max([self.tail, *steps])

    @property
    def sector(self) -> tuple[Fraction, Fraction]:
        """Least and largest ``phi(sigma)/sigma``: attained at a point, next to zero or in the limit of a tail."""
        chords = [w / s for s, w in self.points if s != 0]
        ends = [self.tail, *chords] if chords else [self.tail]
        return min(ends), max(ends)

    @property
    def odd(self) -> bool:
        """Whether ``phi(-sigma) = -phi(sigma)``."""
        return {(-s, -w) for s, w in self.points} == set(self.points)

    def __call__(self, sigma: Fraction) -> Fraction:
        """``phi(sigma)``, exact."""
        place = bisect.bisect_left(self.points, (sigma,))
        if place == 0 or place == len(self.points):
            s, w = self.points[0 if place == 0 else -1]
            return w + self.tail * (sigma - s)
        (s, w), (t, v) = self.points[place - 1], self.points[place]
        return w + (v - w) * (sigma - s) / (t - s)
