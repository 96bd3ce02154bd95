"""Polynomials with rational coefficients: exact root counts in half-planes, on lines, and sign tests on half-lines."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise, zip_longest
from typing import cast

from flint import acb, arb, ctx, fmpq, fmpq_poly, fmpz_poly

from lure.analysis.numerics.precision import working_precision

X = fmpq_poly([0, 1])
SHORT = 30  # up to this degree Routh's array is quicker than the roots
STURM = 8  # up to this degree Sturm's chain is


def from_descending(coefficients: Sequence[Fraction]) -> fmpq_poly:
    """The polynomial with these coefficients, highest power first."""
    return fmpq_poly([fmpq(c.numerator, c.denominator) for c in reversed(coefficients)])


def to_descending(p: fmpq_poly) -> list[Fraction]:
    """Coefficients, highest power first; ``[0]`` for the zero polynomial."""
    return [to_fraction(c) for c in reversed(p.coeffs())] or [Fraction(0)]


def to_fraction(value: fmpq) -> Fraction:
    """The same number as a ``Fraction``."""
    return Fraction(int(value.p), int(value.q))


def to_fmpq(value: Fraction | int | float) -> fmpq:
    """The same number as an ``fmpq``; a float means the double it is."""
    exact = value if isinstance(value, Fraction) else Fraction(value)
    return fmpq(exact.numerator, exact.denominator)


def exact_midpoint(value: arb) -> Fraction:
    """The midpoint of a ball, exactly."""
    mantissa, exponent = value.mid().man_exp()
    shift = int(exponent)
    return Fraction(int(mantissa) << shift) if shift >= 0 else Fraction(int(mantissa), 1 << -shift)


def even_odd(p: fmpq_poly) -> tuple[fmpq_poly, fmpq_poly]:
    """``(e, o)`` with ``p(i w) = e(w^2) + i w o(w^2)``."""
    signed = [c * (-1 if i % 4 >= 2 else 1) for i, c in enumerate(p.coeffs())]
    return fmpq_poly(signed[0::2]), fmpq_poly(signed[1::2])


def real_roots(p: fmpq_poly) -> list[arb]:
    """Disjoint balls around the distinct real roots of ``p``, not the zero polynomial, in ascending order.

    Every real root lies in one of the balls, every ball holds one, and each is either exactly zero or without zero.
    """
    roots: list[arb] = []
    rest = _primitive(p // p.gcd(p.derivative())) if p.degree() > 0 else fmpz_poly([1])
    if int(rest[0]) == 0:
        roots, rest = [arb(0)], rest // fmpz_poly([0, 1])
    if rest.degree() > 0:
        found = _refined(rest, lambda root: root.imag != 0 or root.real != 0)
        roots += [root.real for root in found if root.imag == 0]
    return sorted(roots, key=lambda root: exact_midpoint(root))


def root_sizes(p: fmpq_poly) -> list[float]:
    """Magnitudes of the distinct roots of ``p``, in floating point."""
    if p.degree() <= 0:
        return []
    squarefree = _primitive(p // p.gcd(p.derivative()))
    return [float(abs(root).mid()) for root in _refined(squarefree, lambda _root: True)]


def positive_root_count(p: fmpq_poly) -> int:
    """Number of distinct roots of ``p``, not the zero polynomial, in ``(0, inf)``."""
    if _one_sign(p):
        return 0
    if p.degree() <= STURM:
        return _by_sturm(p)
    return sum(bool(root > 0) for root in real_roots(p))


def _by_sturm(p: fmpq_poly) -> int:
    """The same by the changes of sign in Sturm's chain, at 0 less those at infinity."""
    while p[0] == 0:
        p = p // X
    a, b = p, p.derivative()
    starts, ends = [a[0] > 0], [a[a.degree()] > 0]
    while b.degree() >= 0:
        if b[0] != 0:
            starts.append(b[0] > 0)
        ends.append(b[b.degree()] > 0)
        a, b = b, -(a % b)
    return sum(one != other for one, other in pairwise(starts)) - sum(one != other for one, other in pairwise(ends))


def positive_from_zero(p: fmpq_poly) -> bool:
    """Whether ``p(x) > 0`` for every ``x >= 0``."""
    return p.degree() >= 0 and bool(p[0] > 0) and positive_root_count(p) == 0


@dataclass(frozen=True, slots=True)
class RootCounts:
    """Roots of a polynomial with multiplicity: left of the imaginary axis, on it, right of it."""

    left: int
    axis: int
    right: int


def root_counts(p: fmpq_poly) -> RootCounts:
    """Exact number of roots left of, on and right of the imaginary axis.

    The factor shared by ``p(s)`` and ``p(-s)`` holds the roots on the axis and the pairs symmetric to it; the rest has
    no root on the axis, so that balls around its roots decide their side.

    Raises
    ------
    ValueError
        ``p`` is the zero polynomial.
    """
    degree = p.degree()
    if degree < 0:
        raise ValueError("the zero polynomial has no count of roots")
    changes = _routh([int(c) for c in p.numer().coeffs()]) if degree <= SHORT else None
    if changes is not None:
        return RootCounts(degree - changes, 0, changes)
    mirrored = fmpq_poly([-c if i % 2 else c for i, c in enumerate(p.coeffs())])
    shared = p.gcd(mirrored)
    axis = _axis_roots(shared)
    right = (shared.degree() - axis) // 2
    for factor, multiplicity in (p // shared).numer().factor_squarefree()[1]:
        if factor.degree() > 0:
            decided = _refined(factor, lambda root: bool(root.real != 0))
            right += int(multiplicity) * sum(bool(root.real > 0) for root in decided)
    return RootCounts(degree - axis - right, axis, right)


def is_hurwitz(p: fmpq_poly) -> bool:
    """Whether every root of ``p`` has negative real part; a nonzero constant has none."""
    if p.degree() < 0 or any(c == 0 for c in p.coeffs()) or not _one_sign(p):
        return False
    return root_counts(p).left == p.degree()


def _routh(ascending: list[int]) -> int | None:
    """Changes of sign in the first column of Routh's array, the roots right of the axis; None where that has a zero."""
    rest = ascending[::-1]
    a, b = rest[::2], rest[1::2]
    signs = [a[0] > 0]
    while b:
        if not b[0]:
            return None
        signs.append(b[0] > 0)
        pivot, low = abs(b[0]), a[0] if b[0] > 0 else -a[0]
        row = [pivot * x - low * y for x, y in zip_longest(a[1:], b[1:], fillvalue=0)]
        shared = math.gcd(*row) or 1
        a, b = b, [x // shared for x in row]
    return sum(one != other for one, other in pairwise(signs))


def _axis_roots(p: fmpq_poly) -> int:
    """Roots on the imaginary axis, with multiplicity, of a polynomial whose roots are symmetric to it."""
    count = 0
    _, factors = p.numer().factor_squarefree()
    for factor, multiplicity in factors:
        at_zero = 0
        q = fmpq_poly(factor)
        if q[0] == 0:
            at_zero, q = 1, q // X
        even, odd = even_odd(q)
        half = even.gcd(odd) if odd.degree() >= 0 else even
        count += int(multiplicity) * (at_zero + 2 * positive_root_count(half))
    return count


def _refined(p: fmpz_poly, decided: Callable[[acb], bool]) -> list[acb]:
    """Isolating balls of the roots of a squarefree ``p``, narrowed until each is decided."""
    bits = max(64, ctx.prec)
    while True:
        with working_precision(bits):
            roots = [root for root, _ in cast("list[tuple[acb, int]]", p.complex_roots())]
        if all(decided(root) for root in roots):
            return roots
        bits *= 2


def _primitive(p: fmpq_poly) -> fmpz_poly:
    whole = p.numer()
    return whole // fmpz_poly([whole.content()])


def _one_sign(p: fmpq_poly) -> bool:
    """Descartes: coefficients of one sign leave no positive root."""
    return len({bool(c > 0) for c in p.coeffs() if c != 0}) <= 1
