"""The gains at which a root of ``d + kappa n`` reaches the axis: algebraic numbers, sorted, equal ones merged."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

from flint import arb, fmpq_mat, fmpq_poly

from analysis.evidence import Bracket
from analysis.extremum import value_at
from analysis.plant import Plant
from analysis.polynomial import X, even_odd, exact_midpoint, is_hurwitz, real_roots, to_fmpq, to_fraction
from analysis.precision import ball, outward, working_precision
from lure.rational import RationalBlock

FIRST_BITS = 128
RELATIVE_BITS = 72
BITS_BEFORE_ALGEBRA = 1024


@dataclass(frozen=True, kw_only=True, slots=True)
class GainEnd:
    """A gain at which roots lie on the axis.

    Attributes
    ----------
    value : Bracket
        The gain, to a relative width of 1e-15 or so; an infinite one stands for no end.
    exact : Fraction or None
        The same gain where it is known to be rational.
    frequencies : tuple of float
        Where roots lie on the axis [rad/s; rad per sample, at most pi]; ``inf`` where ``1 + kappa H(inf) = 0``.
    low, high : Fraction or None
        Rational bounds inside which no other such gain lies; None for an infinite end.
    """

    value: Bracket
    exact: Fraction | None = None
    frequencies: tuple[float, ...] = ()
    low: Fraction | None = None
    high: Fraction | None = None


@dataclass(frozen=True, slots=True)
class _Crossing:
    """A gain as a ball, with its exact value and the frequency of the mapped plant where known (None: a mark)."""

    gain: arb
    exact: Fraction | None
    omega: float | None


@dataclass(frozen=True, slots=True)
class _Curve:
    """Gains ``-U(x)/N(x)`` at the positive roots ``x = w^2`` of the squarefree ``I``; and those that need no root."""

    I: fmpq_poly  # noqa: E741  (the letter of the formula)
    U: fmpq_poly
    N: fmpq_poly
    rational: tuple[tuple[Fraction, float | None], ...]


@lru_cache(maxsize=256)
def gain_ends(block: RationalBlock, marks: tuple[Fraction, ...] = ()) -> tuple[GainEnd, ...] | None:
    r"""All real gains with a root of ``d + kappa n`` on the axis (or circle), ascending; None if no gain is stable.

    ``d + kappa n = 0`` at ``s = i w`` gives ``kappa = -U/N``, ``N = |n|^2``, ``U = Re(d conj n)``, at the real roots of
    ``Im(d conj n)``, a polynomial in ``x = w^2``; ``w = 0`` and ``w = inf`` give two rational gains.

    Parameters
    ----------
    block : RationalBlock
        The block.
    marks : tuple of Fraction
        Gains to be told apart from the others: each end is ``exact`` if it equals a mark, and without it otherwise.

    Notes
    -----
    None is returned where a hidden mode is not strictly stable or ``H`` is real on the whole axis (then roots are
    symmetric to it): no gain changes that.  Gains whose balls still overlap at 1024 bits are compared exactly, as
    eigenvalues of the multiplication by ``-U/N`` modulo the polynomial in ``x``.
    """
    plant = Plant.of(block)
    curve = _curve(plant, marks)
    if curve is None:
        return None
    found = []
    for group in _groups(curve):
        frequencies = sorted({plant.frequency(one.omega) for one in group if one.omega is not None})
        if frequencies:
            found.append(_end(plant, group, tuple(frequencies)))
    return tuple(found)


def _curve(plant: Plant, marks: Sequence[Fraction]) -> _Curve | None:
    n, d = plant.n // plant.hidden, plant.d // plant.hidden
    degree = plant.degree - plant.hidden.degree()
    if not is_hurwitz(plant.hidden):
        return None
    rational: list[tuple[Fraction, float | None]] = [(mark, None) for mark in marks]
    if n[0] != 0:
        rational.append((to_fraction(-d[0] / n[0]), 0.0))
    if n[degree] != 0:
        rational.append((to_fraction(-d[degree] / n[degree]), math.inf))
    (ne, no), (de, do) = even_odd(n), even_odd(d)
    N, U, imaginary = ne * ne + X * no * no, ne * de + X * no * do, do * ne - no * de
    if degree == 0:
        return _Curve(fmpq_poly([1]), U, N, tuple(rational))
    if imaginary.degree() < 0:
        return None
    imaginary = imaginary // imaginary.gcd(imaginary.derivative()) if imaginary.degree() > 0 else imaginary
    imaginary = imaginary // imaginary.gcd(N)  # a zero of n on the axis: no finite gain
    open_loop = imaginary.gcd(U)  # a pole on the axis: the gain is exactly zero
    rational += [(Fraction(0), float(x.sqrt())) for x in real_roots(open_loop) if x > 0]
    return _Curve(imaginary // open_loop, U, N, tuple(rational))


def _groups(curve: _Curve) -> list[list[_Crossing]]:
    """The crossings in ascending order of their gains, equal gains together."""
    bits = FIRST_BITS
    while True:
        with working_precision(bits):
            found = [_Crossing(ball(gain), gain, omega) for gain, omega in curve.rational]
            for x in real_roots(curve.I):
                if x > 0:
                    gain = -value_at(curve.U, x) / value_at(curve.N, x)
                    found.append(_Crossing(gain, None, float(x.sqrt())))
            fine = all(one.exact is not None or one.gain.rel_accuracy_bits() >= RELATIVE_BITS for one in found)
            groups = _by_overlap(found) if fine else []
            algebra = curve if bits >= BITS_BEFORE_ALGEBRA else None
            if fine and all(_all_equal(group, algebra) for group in groups):
                return groups
        bits *= 2


def _by_overlap(found: Sequence[_Crossing]) -> list[list[_Crossing]]:
    groups: list[list[_Crossing]] = []
    reach = arb("-inf")
    for one in sorted(found, key=lambda crossing: exact_midpoint(crossing.gain.lower())):
        if groups and not one.gain > reach:
            groups[-1].append(one)
        else:
            groups.append([one])
        reach = one.gain.upper() if not reach > one.gain.upper() else reach
    return groups


def _all_equal(group: Sequence[_Crossing], curve: _Curve | None) -> bool:
    """Whether all gains of a group are shown to be equal, irrational ones only with the help of ``curve``."""
    given = {one.exact for one in group if one.exact is not None}
    if len(group) == 1 or (len(given) == 1 and all(one.exact is not None for one in group)):
        return True
    if len(given) > 1 or curve is None:
        return False
    gains = _gain_polynomial(curve)
    if any(gains(to_fmpq(gain)) != 0 for gain in given):
        return False
    near = [root for root in real_roots(gains) if any(root.overlaps(one.gain) for one in group)]
    return len(near) == 1


def _gain_polynomial(curve: _Curve) -> fmpq_poly:
    """A squarefree polynomial whose roots hold every gain ``-U/N`` at a root of ``I``."""
    size = curve.I.degree()
    _, inverse, _ = (curve.N % curve.I).xgcd(curve.I)
    element = (-curve.U * inverse) % curve.I
    rows = []
    power = fmpq_poly([1])
    for _ in range(size):
        product = (power * element) % curve.I
        rows.append([product[j] for j in range(size)])
        power = power * X
    p = fmpq_mat(rows).charpoly()
    return p // p.gcd(p.derivative())


def _end(plant: Plant, group: Sequence[_Crossing], frequencies: tuple[float, ...]) -> GainEnd:
    exact = next((one.exact for one in group if one.exact is not None), None)
    with working_precision(FIRST_BITS):
        narrowest = max((one.gain for one in group), key=lambda gain: gain.rel_accuracy_bits())
        middle, radius = exact_midpoint(narrowest), exact_midpoint(narrowest.rad())
        low, high = middle - radius, middle + radius  # exact: rounded ends could swallow a mark
        if exact is None:
            candidate = simplest_between(low, high)
            short = candidate.numerator.bit_length() + candidate.denominator.bit_length() < RELATIVE_BITS // 2
            exact = candidate if short and _on_axis(plant, candidate) else None
        if exact is not None:
            low = high = exact
        return GainEnd(value=outward(ball(low), ball(high)), exact=exact, frequencies=frequencies, low=low, high=high)


def _on_axis(plant: Plant, gain: Fraction) -> bool:
    """Whether ``d + gain n`` has a root ``i w`` with ``0 < w < inf``."""
    even, odd = even_odd(plant.d + to_fmpq(gain) * plant.n)
    shared = even.gcd(odd)
    return shared.degree() > 0 and any(bool(root > 0) for root in real_roots(shared))


def simplest_between(low: Fraction, high: Fraction) -> Fraction:
    """The rational of smallest denominator in ``[low, high]``, ``low <= high``."""
    if low <= 0 <= high:
        return Fraction(0)
    if high < 0:
        return -simplest_between(-high, -low)
    terms: list[int] = []
    while True:
        whole = math.ceil(low)
        if whole <= high:
            terms.append(whole)
            break
        whole -= 1
        terms.append(whole)
        low, high = 1 / (high - whole), 1 / (low - whole)
    result = Fraction(terms.pop())
    while terms:
        result = terms.pop() + 1 / result
    return result
