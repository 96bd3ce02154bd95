r"""The inequality of a theorem on the imaginary axis: polynomials, with cosines and sines where there are delays.

Everything is multiplied by ``|d|^2`` and by the denominators ``(a^2 + w^2)^n`` of the multiplier, which are positive:

.. math:: F = \mathrm{Re}[M\,(n \bar d + |d|^2/w) + i\omega\theta\, n \bar d].
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction

from flint import fmpq_poly

from analysis.certificates.second.shifting import Shifted
from analysis.polynomial import X, even_odd, to_fmpq

ONE = fmpq_poly([1])
ZERO = fmpq_poly([])


@dataclass(frozen=True, slots=True)
class Axis:
    """``e(x) + i omega o(x)``, ``x = omega^2``: a real polynomial in ``s`` at ``s = i omega``."""

    e: fmpq_poly
    o: fmpq_poly

    @classmethod
    def of(cls, p: fmpq_poly) -> Axis:
        """``p(i omega)``."""
        return cls(*even_odd(p))

    def __add__(self, other: Axis) -> Axis:
        return Axis(self.e + other.e, self.o + other.o)

    def __mul__(self, other: Axis) -> Axis:
        return Axis(self.e * other.e - X * self.o * other.o, self.e * other.o + self.o * other.e)

    def conjugate(self) -> Axis:
        """The complex conjugate."""
        return Axis(self.e, -self.o)


@dataclass(frozen=True, kw_only=True, slots=True)
class Multiplier:
    """``(sum_tau m_tau exp(-i omega tau)) / below + i omega theta`` on the axis.

    Attributes
    ----------
    terms : mapping of Fraction to Axis
        ``m_tau`` for each delay, 0 among them.
    below : fmpq_poly
        In ``x = omega^2``, positive for ``x >= 0``.
    theta : Fraction
        Weight of the Popov term, which acts on ``H`` alone.
    growth : int
        Degree in ``x`` by which the multiplier grows.
    factors : tuple of fmpq_poly
        The factors of ``below``.
    """

    terms: Mapping[Fraction, Axis] = field(default_factory=lambda: {Fraction(0): Axis(ONE, ZERO)})
    below: fmpq_poly = field(default_factory=lambda: ONE)
    theta: Fraction = Fraction(0)
    growth: int = 0
    factors: tuple[fmpq_poly, ...] = ()


@dataclass(frozen=True, kw_only=True, slots=True)
class Curve:
    """``F = sum_tau U(x) cos(tau omega) + omega V(x) sin(tau omega)``, ``x = omega^2``, over ``omega >= 0``.

    Attributes
    ----------
    terms : mapping of Fraction to (U, V)
        For each ``tau >= 0``.
    full : int
        Degree in ``x`` that keeps the inequality away from 0 as ``omega`` grows.
    divided : bool
        Critical case: all is divided by ``x``, in ``U`` already; the sines stand for ``V sin(tau omega)/omega``.
    """

    terms: Mapping[Fraction, tuple[fmpq_poly, fmpq_poly]]
    full: int
    divided: bool

    @property
    def polynomial(self) -> fmpq_poly | None:
        """``F`` as a polynomial in ``x``; None if there are delays."""
        return None if any(self.terms) else self.terms[Fraction(0)][0]


def curve(block: Shifted, multiplier: Multiplier, ease: Fraction) -> Curve:
    r"""The inequality with ``1/w = ease``.

    Parameters
    ----------
    block : Shifted
        In continuous time.
    multiplier : Multiplier
        ``M`` and ``theta``.
    ease : Fraction
        ``1/w``, 0 for every finite ``w`` at once and for laws without bound.
    """
    d = Axis.of(block.d)
    square = d * d.conjugate()
    eased = Axis(to_fmpq(ease) * square.e, ZERO)
    sums: dict[Fraction, Axis] = {Fraction(0): Axis(ZERO, ZERO)}
    for delay, m in multiplier.terms.items():
        _add(sums, delay, m * eased)
    for delay, n in block.n:
        cross = Axis.of(n) * d.conjugate()
        for further, m in multiplier.terms.items():
            _add(sums, delay + further, m * cross)
        weight = to_fmpq(multiplier.theta) * multiplier.below
        _add(sums, delay, Axis(weight * (-X * cross.o), weight * cross.e))
    full = square.e.degree() + multiplier.below.degree() + multiplier.growth
    divided = block.case == "critical"
    terms = {tau: (f.e // X if divided else f.e, f.o) for tau, f in sums.items()}
    return Curve(terms=terms, full=full - divided, divided=divided)


def off_axis(block: Shifted, alpha: Fraction, ease: Fraction) -> tuple[fmpq_poly, int]:
    """``Re[(1 + i alpha)(H + ease)] |d|^2`` as a polynomial in ``omega``, not in its square; and its full degree."""
    d = Axis.of(block.d)
    square = (d * d.conjugate()).e
    cross = Axis.of(block.n[0][1]) * d.conjugate()
    even = cross.e + to_fmpq(ease) * square
    return even(X * X) - to_fmpq(alpha) * X * cross.o(X * X), 2 * square.degree()


def kernels(theta: Fraction, terms: Iterable[tuple[Fraction, Fraction | tuple[Fraction, int, int]]]) -> Multiplier:
    r"""``1 - sum_j c_j h_j + theta s``.

    Parameters
    ----------
    theta : Fraction
        Weight of the Popov term.
    terms : iterable
        ``c_j`` with a delay, ``h = exp(-s delay)``, or with ``(a, n, side)``, ``h = (a/(a + side s))^n``, side 1 or -1.
    """
    listed = list(terms)
    orders: dict[Fraction, int] = {}
    for _, kernel in listed:
        if isinstance(kernel, tuple):
            orders[kernel[0]] = max(orders.get(kernel[0], 0), kernel[1])
    below = ONE
    for rate, order in orders.items():
        below *= _square(rate) ** order
    sums = {Fraction(0): Axis(below, ZERO)}
    for c, kernel in listed:
        if isinstance(kernel, tuple):
            rate, order, side = kernel
            # (a/(a + s))^n = a^n (a - s)^n / (a^2 + x)^n on the axis
            top = Axis.of(fmpq_poly([to_fmpq(rate), -side]) ** order)
            rest = below // _square(rate) ** order * to_fmpq(-c * rate**order)
            sums[Fraction(0)] += Axis(rest * top.e, rest * top.o)
        else:
            sums[kernel] = sums.get(kernel, Axis(ZERO, ZERO)) + Axis(to_fmpq(-c) * below, ZERO)
    return Multiplier(terms=sums, below=below, theta=theta, factors=tuple(_square(rate) for rate in orders))


def _square(rate: Fraction) -> fmpq_poly:
    return fmpq_poly([to_fmpq(rate * rate), 1])


def _add(sums: dict[Fraction, Axis], delay: Fraction, value: Axis) -> None:
    """Add ``value exp(-i omega delay)``; only its real part counts, so that the sign of the delay may be turned."""
    if delay < 0:
        delay, value = -delay, value.conjugate()
    sums[delay] = sums.get(delay, Axis(ZERO, ZERO)) + value
