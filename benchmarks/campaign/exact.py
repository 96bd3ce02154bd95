"""What the attacks compute exactly by themselves: polynomials, roots in balls, members of a class.

Nothing here comes from the searches or from a checker.  Polynomials are lists of fractions, highest power first.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from typing import Literal

import numpy as np
from flint import ctx, fmpq, fmpq_poly

from lure import NonlinearityClass

Poly = list[Fraction]
Where = Literal["stable", "origin", "unstable"]
PRECISION = 160


def times(*factors: Sequence[Fraction]) -> Poly:
    """The product of polynomials."""
    found = [Fraction(1)]
    for factor in factors:
        longer = [Fraction(0)] * (len(found) + len(factor) - 1)
        for i, a in enumerate(found):
            for j, b in enumerate(factor):
                longer[i + j] += a * b
        found = longer
    return found


def plus(p: Sequence[Fraction], q: Sequence[Fraction], g: Fraction = Fraction(1)) -> Poly:
    """``p + g q``."""
    size = max(len(p), len(q))
    a, b = ([Fraction(0)] * (size - len(side)) + list(side) for side in (p, q))
    return [x + g * y for x, y in zip(a, b, strict=True)]


@dataclass(frozen=True)
class Rational:
    """``n/d`` with its hidden modes, and a dead time; ``delay`` and ``discrete`` exclude each other here."""

    n: Poly
    d: Poly
    discrete: bool = False
    delay: Fraction = Fraction(0)

    @property
    def through(self) -> Fraction:
        """``H(inf)``."""
        return self.n[0] / self.d[0] if len(self.n) == len(self.d) else Fraction(0)

    def matrices(self) -> tuple[list[list[Fraction]], list[Fraction], list[Fraction], Fraction]:
        """The controllable companion form."""
        order, through = len(self.d) - 1, self.through
        below = [v / self.d[0] for v in self.d[1:]]
        rest = plus([v / self.d[0] for v in self.n], [Fraction(1), *below], -through)[-order:]
        rest = [Fraction(0)] * (order - len(rest)) + rest
        rows = [[Fraction(int(j == i + 1)) for j in range(order)] for i in range(order - 1)]
        rows.append([-v for v in reversed(below)])
        return rows, [Fraction(0)] * (order - 1) + [Fraction(1)], list(reversed(rest)), through

    def scaled(self, time: Fraction, gain: Fraction) -> Rational:
        """``gain H(time s)``; in discrete time the gain alone."""
        power = Fraction(1) if self.discrete else time

        def stretched(side: Poly) -> Poly:
            return [v * power ** (len(side) - 1 - i) for i, v in enumerate(side)]

        return replace(self, n=[gain * v for v in stretched(self.n)], d=stretched(self.d), delay=self.delay * power)


def where(p: Poly, *, discrete: bool) -> Where:
    """Whether all roots are stable, or all but a simple one at 0 (``z = 1``), or not; a root at infinity is not.

    In discrete time the unit disc is mapped to the left half plane, and a root -1 to infinity.
    """
    poly = fmpq_poly([fmpq(v.numerator, v.denominator) for v in reversed(p)])
    degree = len(p) - 1
    if discrete:
        up, down, found = fmpq_poly([1, 1]), fmpq_poly([1, -1]), fmpq_poly([])
        for power, c in enumerate(poly.coeffs()):
            found += c * up**power * down ** (degree - power)
        poly = found
    if poly.degree() < degree or degree == 0:
        return "unstable" if poly.degree() < degree else "stable"
    origin = poly[0] == 0
    if origin:
        poly = fmpq_poly(poly.coeffs()[1:])
    before = ctx.prec
    try:
        ctx.prec = PRECISION
        stable = all(root.real < 0 for root, _ in poly.complex_roots())
    finally:
        ctx.prec = before
    if not stable:
        return "unstable"
    return "origin" if origin else "stable"


def furthest(below: Poly, above: Poly, gains: np.ndarray, *, discrete: bool) -> np.ndarray:
    """How far the roots of ``below + g above`` go, roughly: real part, or modulus less 1; infinite for fewer roots."""
    order = len(below) - 1
    p, q = (np.array([0.0] * (order + 1 - len(side)) + [float(v) for v in side]) for side in (below, above))
    whole = p + gains[:, None] * q
    if not order:
        return np.full(len(gains), -math.inf)
    first = np.where(np.abs(whole[:, :1]) > 1e-12 * np.abs(p[0]), whole[:, :1], np.nan)
    companion = np.zeros((len(gains), order, order))
    companion[:, 1:, :-1] = np.eye(order - 1)
    companion[:, 0] = np.nan_to_num(-whole[:, 1:] / first)
    roots = np.linalg.eigvals(companion)
    found = np.abs(roots).max(axis=1) - 1 if discrete else roots.real.max(axis=1)
    return np.where(np.isnan(first[:, 0]), math.inf, found)


def gains_of(one: NonlinearityClass, *, most: float) -> tuple[Fraction, Fraction]:
    """The least and the largest constant gain of a class; infinite ends are replaced by large numbers."""
    ends = [one.sector, *([one.slope] if one.slope is not None else [])]
    low, high = max(bound.lower for bound in ends), min(bound.upper for bound in ends)
    low = Fraction(low) if low > -math.inf else min(Fraction(0), Fraction(high)) - Fraction(most)
    return low, (Fraction(high) if high < math.inf else max(Fraction(0), low) + Fraction(most))


def contains_gain(one: NonlinearityClass, gain: Fraction) -> bool:
    """Whether ``phi = gain sigma`` belongs to the class."""
    bounds = [one.sector, *([one.slope] if one.slope is not None else [])]
    return not one.rectifier and all(bound.lower <= gain <= bound.upper and abs(gain) < math.inf for bound in bounds)


@dataclass(frozen=True)
class Piecewise:
    """A piecewise linear function by its points and the slopes outside them."""

    points: tuple[tuple[Fraction, Fraction], ...]
    left: Fraction
    right: Fraction

    def pieces(self) -> Iterator[tuple[Fraction, Fraction]]:
        """``(slope, offset)`` of each, from the left."""
        if not self.points:
            yield self.left, Fraction(0)  # both slopes meet at 0
            yield self.right, Fraction(0)
            return
        (x, y), (u, v) = self.points[0], self.points[-1]
        yield self.left, y - self.left * x
        for (a, b), (c, e) in pairwise(self.points):
            slope = (e - b) / (c - a)
            yield slope, b - slope * a
        yield self.right, v - self.right * u

    def at(self, sigma: Fraction) -> Fraction:
        """Its value."""
        knots = [x for x, _ in self.points] or [Fraction(0)]
        slope, offset = list(self.pieces())[sum(sigma > x for x in knots)]
        return slope * sigma + offset

    def belongs(self, one: NonlinearityClass) -> bool:
        """Whether it is a member: its value at 0, its slopes, its sector, and whether it is odd."""
        if self.at(Fraction(0)) != 0 or one.linear or one.memory or one.operator or one.rectifier:
            return False
        slopes = [slope for slope, _ in self.pieces()]
        low, high = one.sector.lower, one.sector.upper
        if one.slope is not None and not all(one.slope.lower <= slope <= one.slope.upper for slope in slopes):
            return False
        near = [self.right if side > 0 else self.left for side in (1, -1)]  # of the pieces that end at infinity
        near += [y / x for x, y in self.points if x]
        small = min((abs(x) for x, _ in self.points if x), default=Fraction(1)) / 2
        near += [self.at(small) / small, self.at(-small) / -small]
        if not all(low <= share <= high for share in near):
            return False
        xs = [x for x, _ in self.points] or [Fraction(0)]
        tests = {abs(x) for x in xs} | {max(map(abs, xs)) + 1, Fraction(1)}
        return not one.odd or all(self.at(x) == -self.at(-x) for x in tests)


def floats(parts: tuple[list[list[Fraction]], list[Fraction], list[Fraction], Fraction]) -> tuple[np.ndarray, ...]:
    """``(A, b, c, d)`` as arrays."""
    A, b, c, d = parts
    order = len(b)
    entries = np.array([float(v) for row in A for v in row]).reshape(order, order)
    return entries, np.array([float(v) for v in b]), np.array([float(v) for v in c]), np.array(float(d))
