"""Every linear gain for which the loop is stable, exactly: the bound that no criterion for nonlinearities can pass."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

from flint import arb, fmpq_mat, fmpq_poly

from lure.analysis.inequality.plant import TransferPolynomials
from lure.analysis.numerics.minimum import at
from lure.analysis.numerics.polynomial import X, even_odd, exact_midpoint, is_hurwitz, real_roots, to_fmpq, to_fraction
from lure.analysis.numerics.precision import ball, outward, working_precision
from lure.analysis.verdict import INFINITE, Bracket, CriterionResult, Evidence, Verdict
from lure.analysis.wording import constant_gains
from lure.classes import NonlinearityClass, Sector
from lure.plants.rational import RationalPlant
from lure.record import Record, derived, plain, quantity

# The gains at which a root of ``d + kappa n`` reaches the axis: algebraic numbers, sorted, equal ones merged.

FIRST_BITS = 128
RELATIVE_BITS = 72
BITS_BEFORE_ALGEBRA = 1024
KALMAN = 3
"""Up to this order no slope-restricted nonlinearity destabilises below the first unstable gain (Barabanov 1988)."""


class GainEnd(Record):
    """A gain at which roots lie on the axis."""

    value: Bracket = quantity("The gain, to a relative width of 1e-15 or so; an infinite one stands for no end")
    exact: Fraction | None = quantity("The same gain where it is known to be rational", default=None)
    frequencies: tuple[float, ...] = quantity(
        "Where roots lie on the axis [rad/s; rad per sample, at most pi]; ``inf`` where ``1 + kappa H(inf) = 0``",
        default=(),
    )
    low: Fraction | None = quantity("No other such gain lies from here to ``high``; None if infinite", default=None)
    high: Fraction | None = quantity("The upper end of that interval, rational as well", default=None)


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
def gain_ends(block: RationalPlant, marks: tuple[Fraction, ...] = ()) -> tuple[GainEnd, ...] | None:
    r"""All real gains with a root of ``d + kappa n`` on the axis (or circle), ascending; None if no gain is stable.

    ``d + kappa n = 0`` at ``s = i w`` gives ``kappa = -U/N``, ``N = |n|^2``, ``U = Re(d conj n)``, at the real roots of
    ``Im(d conj n)``, a polynomial in ``x = w^2``; ``w = 0`` and ``w = inf`` give two rational gains.

    Parameters
    ----------
    block : RationalPlant
        The block.
    marks : tuple of Fraction
        Gains to be told apart from the others: each end is ``exact`` if it equals a mark, and without it otherwise.

    Notes
    -----
    None is returned where a hidden mode is not strictly stable or ``H`` is real on the whole axis (then roots are
    symmetric to it): no gain changes that.  Gains whose balls still overlap at 1024 bits are compared exactly, as
    eigenvalues of the multiplication by ``-U/N`` modulo the polynomial in ``x``.
    """
    plant = TransferPolynomials.of(block)
    curve = _curve(plant, marks)
    if curve is None:
        return None
    found = []
    for group in _groups(curve):
        frequencies = sorted({plant.frequency(one.omega) for one in group if one.omega is not None})
        if frequencies:
            found.append(_end(plant, group, tuple(frequencies)))
    return tuple(found)


def _curve(plant: TransferPolynomials, marks: Sequence[Fraction]) -> _Curve | None:
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
                    gain = -at(curve.U, x) / at(curve.N, x)
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


def _end(plant: TransferPolynomials, group: Sequence[_Crossing], frequencies: tuple[float, ...]) -> GainEnd:
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


def _on_axis(plant: TransferPolynomials, gain: Fraction) -> bool:
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
    (a, b), (c, d) = low.as_integer_ratio(), high.as_integer_ratio()
    p, q, p_next, q_next = 0, 1, 1, 0  # convergents of the terms so far
    while (whole := -(-a // b)) * d > c:
        whole -= 1
        p, q, p_next, q_next = p_next, q_next, whole * p_next + p, whole * q_next + q
        a, b, c, d = d, c - whole * d, b, a - whole * b  # 1/(high - whole), 1/(low - whole)
    return Fraction(whole * p_next + p, whole * q_next + q)


THEOREM = (
    "Nyquist's criterion by exact root counts: d + kappa n has all roots in the open left half-plane (open unit disc); "
    "H. Nyquist, Bell System Technical Journal 11 (1932) 126-147"
)


class GainInterval(Record):
    """An open interval of stable gains, as large as possible."""

    lower: GainEnd = quantity(
        "Its lower end, at which the loop is not stable; infinite where there is none",
        label="from",
        plainly=lambda end: plain(end.value),
        form=lambda end: end.value,
    )
    upper: GainEnd = quantity(
        "Its upper end", label="to", plainly=lambda end: plain(end.value), form=lambda end: end.value
    )
    sample: Fraction = quantity("A gain inside", label="a gain inside", form=str)
    _kind = "interval of stable gains"
    _title = "Stable linear gains, mu = -kappa sigma"
    _notes = ("Linear gains, by exact root counts (certified); nothing follows for nonlinear phi.",)

    @property
    @derived(label="")
    def evidence(self) -> Evidence:
        """CERTIFIED."""
        return Evidence.CERTIFIED

    def __str__(self) -> str:
        return f"({self.lower.value.middle:.6g}, {self.upper.value.middle:.6g})"


def is_stable_gain(block: RationalPlant, kappa: Fraction) -> bool:
    r"""Whether ``mu = -kappa sigma`` is stable: all roots of ``d + kappa n`` strictly inside, hidden modes too.

    Where ``1 + kappa H(inf) = 0`` the loop has no solution, and the answer is False.

    ``block``: the block ``sigma = H mu``; ``kappa``: the gain, of either sign.

    Examples
    --------
    >>> block = RationalPlant([1], [1, 3, 2, 0])
    >>> is_stable_gain(block, Fraction(5)), is_stable_gain(block, Fraction(6))
    (True, False)
    """
    plant = TransferPolynomials.of(block)
    p = plant.d + to_fmpq(kappa) * plant.n
    return p.degree() == plant.degree and is_hurwitz(p)


def gain_intervals(block: RationalPlant) -> tuple[GainInterval, ...]:
    r"""All real gains ``kappa`` for which the loop ``mu = -kappa sigma``, ``sigma = H mu`` is stable, ascending.

    Roots of ``d + kappa n`` depend continuously on ``kappa`` and can leave the open half-plane only through the axis
    (infinity included), at the gains of :func:`lure.analysis.inequality.gains.gain_ends`; one exact count between
    neighbours decides each interval.

    Parameters
    ----------
    block : RationalPlant
        The block; hidden modes that are not strictly stable leave no interval.

    Returns
    -------
    tuple of GainInterval
        Disjoint; the loop is unstable or marginal at every gain outside.

    Examples
    --------
    >>> print(*gain_intervals(RationalPlant([1], [1, 3, 2, 0])))
    (0, 6)
    """
    ends = gain_ends(block)
    if ends is None:
        return ()
    found = []
    for i in range(len(ends) + 1):
        sample = _sample(ends, i)
        if is_stable_gain(block, sample):
            lower = ends[i - 1] if i > 0 else GainEnd(value=Bracket(-math.inf, -math.inf))
            upper = ends[i] if i < len(ends) else GainEnd(value=INFINITE)
            found.append(GainInterval(lower=lower, upper=upper, sample=sample))
    return tuple(found)


def hurwitz_limit(block: RationalPlant, lower: Fraction = Fraction(0)) -> Bracket:
    r"""The supremum of the ``k`` such that every gain in ``[lower, k]`` is stable; ``lower`` itself if there is none.

    Where the loop is marginal at ``lower`` (a pole at 0, say) the gains are those of ``(lower, k]``.  Every gain above
    ``lower`` and strictly below the bracket's ``low`` is stable; its relative width is below 1e-12.

    Parameters
    ----------
    block : RationalPlant
        The block.
    lower : Fraction
        Least gain.

    Examples
    --------
    >>> print(hurwitz_limit(RationalPlant([1], [1, 3, 2, 0])))
    6
    """
    end = _upper_end(block, Fraction(lower))
    return outward(ball(lower), ball(lower)) if end is None else end.value


def hurwitz_largest(block: RationalPlant, *, lower: Fraction = Fraction(0)) -> CriterionResult:
    """The largest ``k`` for which every linear gain in ``[lower, k]`` is stable: a necessary condition for the class.

    The verdict is INCONCLUSIVE where that interval is not empty, for nothing is said about nonlinearities, and REFUTED
    by a linear gain where it is, or where ``lower`` itself is a gain that leaves solutions away from all equilibria.

    Parameters
    ----------
    block : RationalPlant
        The block.
    lower : Fraction
        Least gain; one simple pole at 0 (``z = 1``) with it is admitted.
    """
    lower = Fraction(lower)
    unstable = TransferPolynomials.of(block).shifted(lower).case == "unstable"
    end = None if unstable else _upper_end(block, lower)
    if end is None:
        gain = lower if unstable else _gain_above(block, lower)
        return _answer(
            Sector(lower, math.inf),
            outward(ball(lower), ball(lower)),
            Verdict.REFUTED,
            f"the gain {float(lower):g} is not stable"
            if unstable
            else f"no gain just above {float(lower):g} is stable",
            constant_gains([str(gain)]),
        )
    if end.high is None:
        return _answer(
            Sector(lower, math.inf),
            INFINITE,
            Verdict.INCONCLUSIVE,
            f"every linear gain above {float(lower):g} is stable; nothing follows for nonlinear phi",
        )
    low = math.nextafter(end.value.low, -math.inf)
    sector = Sector(lower, low) if low > lower else Sector(lower, end.high)
    exact = f" = {end.exact}" if end.exact is not None else ""
    where = ", ".join(f"{omega:.6g}" for omega in end.frequencies)
    reason = (
        f"linear gains are stable up to {end.value.middle:.10g}{exact}, where roots reach the axis at frequency "
        f"{where}; nothing follows for nonlinear phi, and no criterion can pass this bound"
    )
    return _answer(sector, Bracket(low, end.value.high), Verdict.INCONCLUSIVE, reason)


def hurwitz_criterion(block: RationalPlant, sector: Sector) -> CriterionResult:
    """Whether every linear gain in a finite or infinite sector is stable; REFUTED with a linear gain where not.

    The least gain may leave one simple pole at 0 (then the gains of ``(lower, upper]`` are asked about).

    Parameters
    ----------
    block : RationalPlant
        The block.
    sector : Sector
        The sector; an infinite ``lower`` is allowed.
    """
    gain = unstable_gain(block, sector)
    limit = INFINITE if sector.lower == -math.inf else hurwitz_limit(block, Fraction(sector.lower))
    if gain is not None:
        return _answer(
            sector, limit, Verdict.REFUTED, f"the linear gain {gain} is not stable", constant_gains([str(gain)])
        )
    reason = f"every linear gain in the sector {sector} is stable; nothing follows for nonlinear phi"
    return _answer(sector, limit, Verdict.INCONCLUSIVE, reason)


def unstable_gain(block: RationalPlant, sector: Sector) -> Fraction | GainEnd | None:
    """A gain of the sector for which the loop is not stable; None if there is none but perhaps ``sector.lower``.

    A gain at which the loop is only marginal counts as not stable, save ``sector.lower`` in the critical case, one
    simple pole at 0; it is returned as its :class:`GainEnd` where it may be irrational.

    Parameters
    ----------
    block : RationalPlant
        The block.
    sector : Sector
        The sector, with finite or infinite bounds.
    """
    marks = tuple(Fraction(bound) for bound in (sector.lower, sector.upper) if abs(bound) != math.inf)
    ends = gain_ends(block, marks)
    if ends is None:
        return simplest_inside(sector)
    inside = [end for end in ends if _within(end, sector)]
    for i in range(len(inside) + 1):
        low = inside[i - 1].high if i > 0 else _finite(sector.lower)
        high = inside[i].low if i < len(inside) else _finite(sector.upper)
        if low is not None and low == high:  # a mark that is an end itself
            continue
        sample = _between(low, high)
        if not is_stable_gain(block, sample):
            return sample
    lower = _finite(sector.lower)
    spared = lower if lower is not None and TransferPolynomials.of(block).shifted(lower).case == "critical" else None
    marginal = next((end for end in inside if end.exact is None or end.exact != spared), None)
    return marginal if marginal is None or marginal.exact is None else marginal.exact


def simplest_inside(sector: Sector) -> Fraction:
    """A simple rational strictly inside a sector."""
    return _between(_finite(sector.lower), _finite(sector.upper))


def _within(end: GainEnd, sector: Sector) -> bool:
    return end.low is not None and end.high is not None and sector.lower <= end.low and end.high <= sector.upper


def _finite(bound: float | Fraction) -> Fraction | None:
    return None if abs(bound) == math.inf else Fraction(bound)


def _between(low: Fraction | None, high: Fraction | None) -> Fraction:
    """A simple rational strictly between two bounds, None for infinity."""
    if low is None and high is None:
        return Fraction(0)
    if low is None:
        return Fraction(math.floor(high or 0) - 1)
    if high is None:
        return Fraction(math.ceil(low) + 1)
    third = (high - low) / 3
    return simplest_between(low + third, high - third)


def _sample(ends: Sequence[GainEnd], i: int) -> Fraction:
    """A gain between the ends ``i - 1`` and ``i``."""
    return _between(ends[i - 1].high if i > 0 else None, ends[i].low if i < len(ends) else None)


def _upper_end(block: RationalPlant, lower: Fraction) -> GainEnd | None:
    """Where the stable gains that begin at ``lower`` end; None if no gain just above it is stable."""
    ends = gain_ends(block, (lower,))
    if ends is None:
        return None
    above = [end for end in ends if end.low is not None and end.low > lower]
    at_lower = any(end.exact == lower for end in ends)
    sample = _between(lower, above[0].low if above else None) if at_lower else lower
    if not is_stable_gain(block, sample):
        return None
    return above[0] if above else GainEnd(value=INFINITE)


def _gain_above(block: RationalPlant, lower: Fraction) -> Fraction:
    ends = gain_ends(block, (lower,)) or ()
    above = [end for end in ends if end.low is not None and end.low > lower]
    return _between(lower, above[0].low if above else None)


def _answer(
    sector: Sector, largest: Bracket, verdict: Verdict, reason: str, witness: str | None = None
) -> CriterionResult:
    return CriterionResult(
        criterion="hurwitz",
        theorem=THEOREM,
        largest=largest,
        nonlinearity_class=NonlinearityClass(sector=sector),
        verdict=verdict,
        evidence=Evidence.CERTIFIED,
        hypotheses=("phi linear: phi = kappa sigma with a constant kappa", "root counts: exact, for every gain"),
        reason=reason,
        witness=witness,
    )
