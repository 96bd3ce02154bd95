"""The infimum of a rational function on the half-line, from all its stationary points, in ball arithmetic."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from flint import arb, fmpq_poly

from analysis.polynomial import positive_from_zero, real_roots, to_fmpq
from analysis.precision import working_precision

FIRST_BITS = 128
RELATIVE_BITS = 60


@dataclass(frozen=True, kw_only=True, slots=True)
class Infimum:
    """A bracket on the infimum of ``U/D`` over ``[0, inf]``.

    Attributes
    ----------
    low, high : arb
        ``low <= inf U/D <= high``; equal where the infimum is 0.
    where : float
        ``x`` at which it is attained; ``inf`` if only in the limit.
    """

    low: arb
    high: arb
    where: float


def infimum(U: fmpq_poly, D: fmpq_poly) -> Infimum:
    r"""The infimum of ``U(x)/D(x)`` over ``x >= 0``, the limit at infinity included, to a relative width of ``2^-60``.

    It is attained at 0, at infinity or at a positive root of ``U' D - U D'``, all of which are enclosed; stationary
    points at which ``U`` vanishes too are told apart by a common divisor, so that an infimum of 0 is found as 0.

    Parameters
    ----------
    U, D : fmpq_poly
        ``D`` positive on ``[0, inf)`` and of at least the degree of ``U``.

    Raises
    ------
    ValueError
        ``D(0)`` is not positive or ``U/D`` is not bounded at infinity.
    """
    if not (D.degree() >= 0 and D[0] > 0 and U.degree() <= D.degree()):
        raise ValueError("infimum needs D(0) > 0 and U of at most the degree of D")
    ends = [(U[0] / D[0], 0.0), (U[D.degree()] / D[D.degree()], math.inf)]
    stationary = U.derivative() * D - U * D.derivative()
    touching = stationary.gcd(U) if stationary.degree() > 0 else fmpq_poly([1])
    rest = stationary // touching
    bits = FIRST_BITS
    while True:
        with working_precision(bits):
            found = [(arb(value), where) for value, where in ends]
            found += [(arb(0), float(x)) for x in real_roots(touching) if x > 0]
            if rest.degree() > 0:
                found += [(value_at(U, x) / value_at(D, x), float(x)) for x in real_roots(rest) if x > 0]
            low, high = found[0][0].lower(), found[0][0].upper()
            for value, _ in found[1:]:
                low, high = low.min(value.lower()), high.min(value.upper())
            if high - low <= abs(high) * arb(2) ** -RELATIVE_BITS:
                where = next(where for value, where in found if value.lower() <= high)
                return Infimum(low=low, high=high, where=where)
        bits *= 2


def positive_with_limits(p: fmpq_poly, degree: int) -> bool:
    """Whether ``p > 0`` on ``[0, inf)`` and ``p(x)/x^degree`` has a positive limit."""
    return p.degree() == degree and positive_from_zero(p)


def nonnegative_from_zero(p: fmpq_poly) -> bool:
    """Whether ``p(x) >= 0`` for every ``x >= 0``: it is zero, or its sign never changes and ends positive."""
    if p.degree() < 0:
        return True
    if not p[p.degree()] > 0:
        return False
    for factor, multiplicity in p.numer().factor_squarefree()[1]:
        if multiplicity % 2 and any(bool(root > 0) for root in real_roots(fmpq_poly(factor))):
            return False
    return True


def largest_below(p: fmpq_poly, q: fmpq_poly, guess: float, shift: Fraction = Fraction(0)) -> float | None:
    """A double ``k <= guess``, near it, with ``p + (k - shift) q > 0`` on ``[0, inf]``; None if none above ``shift``.

    Parameters
    ----------
    p, q : fmpq_poly
        ``p > 0`` on ``[0, inf]`` and of at least the degree of ``q``.
    guess : float
        The largest ``k`` of this kind or a little less, as a lower bound known by other means.
    shift : Fraction
        Where ``k`` counts from.

    Notes
    -----
    The test is exact, and independent of how ``guess`` was found.
    """
    k = guess
    step = math.ulp(guess)
    while k > shift:
        if positive_with_limits(p + to_fmpq(Fraction(k) - shift) * q, p.degree()):
            return k
        k -= step
        step *= 2
    return None


def value_at(p: fmpq_poly, x: arb) -> arb:
    """``p(x)`` for a ball ``x``."""
    result = arb(0)
    for coefficient in reversed(p.coeffs()):
        result = result * x + arb(coefficient)
    return result
