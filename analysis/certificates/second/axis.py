r"""The inequality of a theorem on the imaginary axis: polynomials, with cosines and sines where there are delays.

Everything is multiplied by ``|d|^2`` and by the denominators ``(a^2 + w^2)^n`` of the multiplier, which are positive:

.. math:: F = \mathrm{Re}[M\,(n \bar d + |d|^2/w) + i\omega\theta\, n \bar d].
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import product
from typing import Literal

from flint import fmpq, fmpq_poly

from lure.analysis.certificates.second.numerics import (
    X,
    even_odd,
    nonnegative_from_zero,
    nonnegative_on_circle,
    positive_from_zero,
    positive_on_circle,
    to_fmpq,
)
from lure.analysis.certificates.second.reading import require, tick
from lure.analysis.certificates.second.systems import Shifted

# Whether a polynomial is positive on ``[0, inf)`` or on ``[-1, 1]``, by its isolated roots; and whether two agree.

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
        return nonnegative_from_zero(p)
    return positive_from_zero(p) and p.degree() >= full - (allowed if need == "decaying" else 0)


def holds_on_circle(p: fmpq_poly, need: Need) -> bool:
    """The same for a polynomial in ``c = cos w`` on ``[-1, 1]``, where nothing can decay."""
    return nonnegative_on_circle(p) if need == "nonnegative" else positive_on_circle(p)


def require_same(written: fmpq_poly, own: fmpq_poly, factors: Iterable[fmpq_poly]) -> None:
    """Check that two polynomials agree but for a positive number and powers of factors that are positive anyway.

    ``written``, ``own``: from the file, and built here.  ``factors``: polynomials positive on the open half-line; ``x``
    itself is understood.

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


def _without(p: fmpq_poly, factor: fmpq_poly) -> fmpq_poly:
    while factor.degree() > 0 and p.degree() >= factor.degree() and (p % factor).degree() < 0:
        p = p // factor
    return p


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

    def times(self, p: fmpq_poly) -> Axis:
        """The product with a polynomial in ``x``, real on the axis."""
        return Axis(self.e * p, self.o * p)

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
    level : mapping of Fraction to fmpq
        In the critical case what ``U`` has left at ``x = 0``, before that; it adds up to 0.
    """

    terms: Mapping[Fraction, tuple[fmpq_poly, fmpq_poly]]
    full: int
    divided: bool
    level: Mapping[Fraction, fmpq] = field(default_factory=dict)

    @property
    def polynomial(self) -> fmpq_poly | None:
        """``F`` as a polynomial in ``x``; None if there are delays."""
        return None if any(self.terms) else self.terms[Fraction(0)][0]


def curve(block: Shifted, multiplier: Multiplier, inverse_gain: Fraction) -> Curve:
    r"""The inequality with ``1/w = inverse_gain``.

    Parameters
    ----------
    block : Shifted
        In continuous time.
    multiplier : Multiplier
        ``M`` and ``theta``.
    inverse_gain : Fraction
        ``1/w``, 0 for every finite ``w`` at once and for nonlinearities without bound.
    """
    parts = [(Fraction(0), Axis.of(block.d)), *((delay, Axis.of(q)) for delay, q in block.back)]
    sums: dict[Fraction, Axis] = {Fraction(0): Axis(ZERO, ZERO)}
    for (first, p), (second, q) in product(parts, repeat=2):
        square = (p * q.conjugate()).times(fmpq_poly([to_fmpq(inverse_gain)]))
        for delay, m in multiplier.terms.items():
            _add(sums, delay + first - second, m * square)
    for (delay, n), (second, q) in product(block.n, parts):
        tick()
        cross = Axis.of(n) * q.conjugate()
        for further, m in multiplier.terms.items():
            _add(sums, delay - second + further, m * cross)
        weight = to_fmpq(multiplier.theta) * multiplier.below
        _add(sums, delay - second, Axis(weight * (-X * cross.o), weight * cross.e))
    full = block.d.degree() + multiplier.below.degree() + multiplier.growth
    divided = block.case == "critical"
    terms = {tau: (f.e // X if divided else f.e, f.o) for tau, f in sums.items()}
    level = {tau: f.e[0] for tau, f in sums.items() if divided and f.e[0] != 0}
    require(sum(level.values(), fmpq(0)) == 0, "the inequality has a pole at 0")
    return Curve(terms=terms, full=full - divided, divided=divided, level=level)


def off_axis(block: Shifted, alpha: Fraction, inverse_gain: Fraction) -> tuple[fmpq_poly, int]:
    """``Re[(1 + i alpha)(H + inverse_gain)] |d|^2`` as a polynomial in ``omega``, not in ``omega^2``; its degree."""
    d = Axis.of(block.d)
    square = (d * d.conjugate()).e
    cross = Axis.of(block.n[0][1]) * d.conjugate()
    even = cross.e + to_fmpq(inverse_gain) * square
    found, full = even(X * X) - to_fmpq(alpha) * X * cross.o(X * X), 2 * square.degree()
    if block.case == "critical":  # Re[(1 + i alpha) rho/(i omega)] = alpha rho/omega
        power = 1 if alpha else 2
        return found // X**power, full - power
    return found, full


def kernels(theta: Fraction, terms: Iterable[tuple[Fraction, Fraction | tuple[Fraction, int, int]]]) -> Multiplier:
    r"""``1 - sum_j c_j h_j + theta s``.

    Parameters
    ----------
    theta : Fraction
        Weight of the Popov term.
    terms : iterable
        ``c_j`` with a delay, ``h = exp(-s delay)``, or with ``(a, n, side)``, ``h = (a/(a + side s))^n``, side 1 or -1.
    """
    sums, same = {Fraction(0): Axis(ONE, ZERO)}, dict[Fraction, list[tuple[Fraction, int, int]]]()
    for c, kernel in terms:
        if isinstance(kernel, tuple):
            rate, order, side = kernel
            same.setdefault(rate, []).append((c, order, side))
        else:
            sums[kernel] = sums.get(kernel, Axis(ZERO, ZERO)) + Axis(fmpq_poly([to_fmpq(-c)]), ZERO)
    top, below = _total([_of_rate(rate, group) for rate, group in same.items()])
    terms_over = {delay: m.times(below) for delay, m in sums.items()}
    terms_over[Fraction(0)] += top
    return Multiplier(terms=terms_over, below=below, theta=theta, factors=tuple(_square(rate) for rate in same))


Part = tuple[Axis, fmpq_poly]  # a fraction: top, and below in x = omega^2


def _of_rate(a: Fraction, group: list[tuple[Fraction, int, int]]) -> Part:
    """``-sum c (a/(a + side s))^n`` for kernels of one rate: ``(a/(a + s))^n = a^n (a - s)^n / (a^2 + x)^n``."""
    most = max(order for _, order, _ in group)
    total = Axis(ZERO, ZERO)
    for c, order, side in group:
        tick()
        rest = _square(a) ** (most - order) * to_fmpq(-c * a**order)
        total += Axis.of(fmpq_poly([to_fmpq(a), -side]) ** order).times(rest)
    return total, _square(a) ** most


def _total(parts: list[Part]) -> Part:
    """The sum of fractions by halves, so that large polynomials are multiplied a few times only."""
    tick()
    if len(parts) < 2:
        return parts[0] if parts else (Axis(ZERO, ZERO), ONE)
    (top, below), (other, beside) = _total(parts[: len(parts) // 2]), _total(parts[len(parts) // 2 :])
    return top.times(beside) + other.times(below), below * beside


def _square(rate: Fraction) -> fmpq_poly:
    return fmpq_poly([to_fmpq(rate * rate), 1])


def _add(sums: dict[Fraction, Axis], delay: Fraction, value: Axis) -> None:
    """Add ``value exp(-i omega delay)``; only its real part counts, so that the sign of the delay may be turned."""
    if delay < 0:
        delay, value = -delay, value.conjugate()
    sums[delay] = sums.get(delay, Axis(ZERO, ZERO)) + value
