"""Whether a polynomial is positive on ``[0, inf)`` or on ``[-1, 1]``, by its isolated roots; and whether two agree."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

from flint import fmpq_poly

from analysis.certificates.second.reading import require, tick
from analysis.polynomial import X, positive_from_zero, positive_root_count
from analysis.trigonometric import nonnegative_on_circle, positive_on_circle

Need = Literal["positive", "nonnegative", "decaying"]


def holds_from_zero(p: fmpq_poly, full: int, need: Need, *, allowed: int = 1) -> bool:
    """Whether an inequality holds on ``[0, inf]``.

    Parameters
    ----------
    p : fmpq_poly
        The left-hand side times a positive polynomial.
    full : int
        The degree ``p`` has if the left-hand side does not tend to 0.
    need : {"positive", "nonnegative", "decaying"}
        Positive with its limits; not negative; positive, and tending to 0 no faster than ``full - allowed`` says.
    allowed : int
        By how much the degree may fall short for ``decaying``.
    """
    if need == "nonnegative":
        return _nonnegative(p)
    return positive_from_zero(p) and p.degree() >= full - (allowed if need == "decaying" else 0)


def holds_on_circle(p: fmpq_poly, need: Need) -> bool:
    """The same for a polynomial in ``c = cos w`` on ``[-1, 1]``, where nothing can decay."""
    return nonnegative_on_circle(p) if need == "nonnegative" else positive_on_circle(p)


def require_same(written: fmpq_poly, own: fmpq_poly, factors: Iterable[fmpq_poly]) -> None:
    """Check that two polynomials agree but for a positive number and powers of factors that are positive anyway.

    Parameters
    ----------
    written, own : fmpq_poly
        From the file, and built here.
    factors : iterable of fmpq_poly
        Polynomials positive on the open half-line; ``x`` itself is understood.

    Raises
    ------
    NotShown
        They do not agree.
    """
    left, right = written, own
    for factor in (X, *factors):
        left, right = _without(left, factor), _without(right, factor)
    a, b = left[max(left.degree(), 0)], right[max(right.degree(), 0)]
    same = left.degree() == right.degree() and a * b >= 0 and left * b == right * a
    require(bool(same), "the coefficients are not those of the inequality")


def half_line(p: fmpq_poly) -> fmpq_poly:
    """``(1 + x)^deg p((1 - x)/(1 + x))``: ``c = cos w`` with ``x = tan^2(w/2)``."""
    degree, total = p.degree(), fmpq_poly([])
    for i, c in enumerate(p.coeffs()):
        tick()
        total += c * fmpq_poly([1, -1]) ** i * fmpq_poly([1, 1]) ** (degree - i)
    return total


def _nonnegative(p: fmpq_poly) -> bool:
    """Whether ``p(x) >= 0`` for every ``x >= 0``: no positive root of odd multiplicity, and the sign right far out."""
    if p.degree() < 0:
        return True
    _, factors = p.numer().factor_squarefree()
    odd = [fmpq_poly(factor) for factor, multiplicity in factors if int(multiplicity) % 2]
    return bool(p[p.degree()] > 0) and all(positive_root_count(factor) == 0 for factor in odd)


def _without(p: fmpq_poly, factor: fmpq_poly) -> fmpq_poly:
    while factor.degree() > 0 and p.degree() >= factor.degree() and (p % factor).degree() < 0:
        p = p // factor
    return p
