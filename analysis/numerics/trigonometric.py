"""Exact arithmetic on the unit circle: Laurent polynomials, their real parts in ``c = cos w``, signs and minima."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from flint import fmpq, fmpq_poly, fmpz_poly

from lure.analysis.numerics.evidence import Bracket
from lure.analysis.numerics.minimum import infimum, nonnegative_from_zero, positive_with_limits
from lure.analysis.numerics.precision import outward

ONE_MINUS_TWO_V = fmpq_poly([1, -2])
ONE_PLUS = fmpq_poly([1, 1])


@dataclass(frozen=True, slots=True)
class Laurent:
    """``z^-shift p(z)`` with rational coefficients; on ``|z| = 1`` its conjugate is ``z^shift p(1/z)``."""

    p: fmpq_poly
    shift: int = 0

    def __add__(self, other: Laurent) -> Laurent:
        shift = max(self.shift, other.shift)
        left = self.p * _power(shift - self.shift)
        return Laurent(left + other.p * _power(shift - other.shift), shift)

    def __mul__(self, other: Laurent) -> Laurent:
        return Laurent(self.p * other.p, self.shift + other.shift)

    def scaled(self, factor: Fraction) -> Laurent:
        """``factor`` times it."""
        return Laurent(fmpq(factor.numerator, factor.denominator) * self.p, self.shift)

    def conjugate(self) -> Laurent:
        """``z -> 1/z``: the complex conjugate on the unit circle."""
        degree = max(self.p.degree(), 0)
        return Laurent(fmpq_poly(list(reversed(_padded(self.p, degree)))), degree - self.shift)

    def real_part(self) -> fmpq_poly:
        """The polynomial ``P`` with ``Re = P(cos w)`` on ``z = exp(i w)``: ``z^j`` becomes the Chebyshev ``T_|j|``."""
        folded: dict[int, fmpq] = {}
        for i, value in enumerate(self.p.coeffs()):
            harmonic = abs(i - self.shift)
            folded[harmonic] = folded.get(harmonic, fmpq(0)) + value
        total = fmpq_poly([])
        for harmonic, value in folded.items():
            total += value * fmpq_poly(fmpz_poly.chebyshev_t(harmonic))
        return total


def positive_on_circle(p: fmpq_poly) -> bool:
    """Whether ``p(c) > 0`` for every ``c = cos w`` in ``[-1, 1]``, by an exact root count."""
    degree = max(p.degree(), 0)
    return positive_with_limits(_on_half_line(p, degree), degree)


def nonnegative_on_circle(p: fmpq_poly) -> bool:
    """Whether ``p(c) >= 0`` for every ``c`` in ``[-1, 1]``: no zero of odd order inside, and the sign right."""
    return nonnegative_from_zero(_on_half_line(p, max(p.degree(), 0)))


def least_on_circle(p: fmpq_poly, q: fmpq_poly) -> tuple[Bracket, float]:
    """A rigorous bracket on ``min p(c)/q(c)`` over ``c`` in ``[-1, 1]``, and the ``c`` near which it is attained.

    ``p``, ``q``: polynomials in ``c``; ``q > 0`` on ``[-1, 1]``.
    """
    degree = max(p.degree(), q.degree())
    found = infimum(_on_half_line(p, degree), _on_half_line(q, degree))
    where = -1.0 if found.where == math.inf else (1 - found.where) / (1 + found.where)
    return outward(found.low, found.high), where


def _on_half_line(p: fmpq_poly, degree: int) -> fmpq_poly:
    """``(1 + x)^degree p((1 - x)/(1 + x))``, ``x = tan^2(w/2) >= 0``; its coefficient of ``x^degree`` is ``p(-1)``."""
    in_v = p(ONE_MINUS_TWO_V)  # v = (1 - c)/2 = x/(1 + x)
    shifted = fmpq_poly(list(reversed(_padded(in_v, degree))))(ONE_PLUS)
    return fmpq_poly(list(reversed(_padded(shifted, degree))))


def _padded(p: fmpq_poly, degree: int) -> list[fmpq]:
    found = list(p.coeffs())
    return found + [fmpq(0)] * (degree + 1 - len(found))


def _power(exponent: int) -> fmpq_poly:
    return fmpq_poly([0] * exponent + [1])
