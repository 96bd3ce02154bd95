"""The least value over all frequencies for one multiplier, as a rigorous bracket."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from flint import arb, arb_poly, fmpq, fmpq_poly

from lure.analysis.inequality.checks import check_plant
from lure.analysis.inequality.gains import simplest_between
from lure.analysis.inequality.multiplier_search import CAP, Cut, SearchResult, admissible, choice, mixture, search
from lure.analysis.inequality.plant import TransferPolynomials
from lure.analysis.numerics.doubles import double_above, double_below
from lure.analysis.numerics.polynomial import (
    exact_midpoint,
    positive_from_zero,
    positive_root_count,
    real_roots,
    to_fmpq,
    to_fraction,
)
from lure.analysis.numerics.precision import ball, working_precision
from lure.analysis.verdict import INFINITE, Bracket
from lure.errors import AssumptionError
from lure.plants.rational import RationalPlant

# Popov's inequality of a rational block as polynomials in ``x = omega^2``, with the exact tests that decide it.

TRIES = 100
CONCLUSION = "0 is globally asymptotically stable for every law of the class"


@dataclass(frozen=True, slots=True)
class Reach:
    """How far a multiplier goes: every finite ``k`` if ``found`` is None.

    ``theta`` is infinite, and no multiplier, where each finite ``k`` needs a larger one; None if none was certified.
    """

    theta: Fraction | float | None
    found: SearchResult | None = None


@dataclass(frozen=True, slots=True)
class PopovInequality:
    """``1/k + Re[(1 + i omega theta) H] > 0`` on ``[0, inf]`` for the shifted block, ``k = upper - lower``."""

    plant: TransferPolynomials
    lower: Fraction
    family: PolynomialFamily

    @classmethod
    def of(cls, block: RationalPlant, lower: Fraction, criterion: str = "Popov's criterion") -> PopovInequality:
        """The inequality of a block.

        Raises
        ------
        AssumptionError
            The block is in discrete time, or the shifted block is neither stable nor critical.
        """
        if isinstance(block, RationalPlant) and block.dt is not None:
            raise AssumptionError(
                f"{criterion} is about continuous time, and the block has dt = {float(block.dt):g} s; ask for "
                "circle, tsypkin or zames-falb instead"
            )
        plant = check_plant(block, lower=lower)
        h = plant.hidden
        visible = TransferPolynomials(block, plant.n // h, plant.d // h, h // h, plant.degree - h.degree())
        response = visible.response()
        return cls(plant, lower, PolynomialFamily(response.D, response.U, response.W))

    @classmethod
    def of_stable(cls, block: RationalPlant, lower: Fraction, criterion: str) -> PopovInequality:
        """The inequality for a criterion that does not cover the critical case.

        Raises
        ------
        AssumptionError
            As :meth:`of`, or the shifted block has a pole at 0.
        """
        inequality = cls.of(block, lower, criterion)
        if inequality.plant.case != "stable":
            raise AssumptionError(
                f"{criterion} needs a stable block, and this one has a pole at 0; give a positive lower slope bound, "
                "or ask Popov's"
            )
        return inequality

    @property
    def direct(self) -> fmpq:
        """The direct term ``D`` of the shifted block."""
        return self.family.at_infinity.u

    def holds(self, theta: Fraction, upper: float | Fraction) -> bool:
        """Whether the inequality proves the sector ``[lower, upper]``, exactly.

        For ``upper = inf`` either ``1 + theta s`` serves ``H - D`` and the finite sector ``[0, 1/D]``, or ``D = 0``,
        ``theta >= 0`` and ``Re[..] >= eps/(1 + omega^2)``, and no mode is hidden.
        """
        p = to_fmpq(theta)
        if upper != math.inf:
            level = -1 / to_fmpq(Fraction(upper) - self.lower)
            return bool(self.direct > level) and self.family.exceeds(p, level)
        if self.direct > 0:
            return self.family.exceeds(p, fmpq(0))
        if theta < 0 or self.direct < 0 or self.plant.hidden.degree() > 0:
            return False
        least = self.family.level(p, fmpq(0))
        return positive_from_zero(least) and least.degree() >= self.family.D.degree() - 1

    def reach(self, *, nonnegative: bool = False) -> Reach:
        """The best multiplier, and how far it goes."""
        cuts = [*self.family.first_cuts(), Cut(self.direct, fmpq(0))]  # 1 + k D > 0, or the loop may have no solution
        if self.direct >= 0:
            theta = self.family.everywhere(cuts, nonnegative=nonnegative)
            if theta is not None:
                return Reach(to_fraction(theta))
            if all(cut.w >= 0 for cut in cuts) and self.family.rises_for_ever():
                return Reach(math.inf)
            if not nonnegative and all(cut.w <= 0 for cut in cuts) and self.family.mirrored.rises_for_ever():
                return Reach(-math.inf)
        found = search(self.family, cuts, self.level_of_a_double, nonnegative=nonnegative)
        return Reach(None if found.theta is None else to_fraction(found.theta), found)

    def serving(self, best: Reach, upper: float | Fraction) -> Fraction:
        """A multiplier for ``[lower, upper]``, from the best one."""
        if best.theta is None:
            return Fraction(0)
        candidates: list[Fraction]
        if isinstance(best.theta, float):
            start = Fraction(1 if best.theta > 0 else -1)
            candidates = [start * Fraction(4) ** power for power in range(-8, TRIES)]
        else:
            start = best.theta
            candidates = [start * Fraction(c) for c in ("1", "9/8", "2", "7/8")] if start else [start, Fraction(1)]
        return next((theta for theta in candidates if self.holds(theta, upper)), start)

    def largest(self, best: Reach) -> Bracket:
        """How far that is: the largest ``upper`` as a bracket, both ends exact statements."""
        if best.found is None:
            return INFINITE
        top = to_fraction(best.found.upper_bound.value)
        high = double_above(self.lower - 1 / top) if top < 0 else math.inf
        if best.theta is None:
            return Bracket(double_below(self.lower), high)
        return Bracket(double_below(self.lower - 1 / to_fraction(best.found.level)), high)

    def level_of_a_double(self, level: fmpq) -> fmpq:
        """A level not above a negative one that belongs to a double ``lower - 1/level``, where there is one."""
        upper = Fraction(double_below(self.lower - 1 / to_fraction(level)))
        return -1 / to_fmpq(upper - self.lower) if upper > self.lower else level


# ``(U + theta W)/D`` on ``[0, inf]`` for polynomials: exact levels, and points where a level fails.

LEVEL_ROUNDS = 30
GOLDEN_STEPS = 30
NEWTON_STEPS = 6
BITS = 160
NEAR = fmpq(1, 2**20)
CLOSE = fmpq(1, 2**90)


@dataclass(frozen=True, slots=True)
class PolynomialFamily:
    """``(U + theta W)/D`` on ``[0, inf]``, ``D > 0`` on ``[0, inf)``, no degree above that of ``D``."""

    D: fmpq_poly
    U: fmpq_poly
    W: fmpq_poly

    def exact(self, x: fmpq) -> Cut:
        """The cut of a point, exactly."""
        bottom = self.D(x)
        return Cut(self.U(x) / bottom, self.W(x) / bottom, x)

    def cut(self, x: fmpq) -> Cut:
        """The cut of a point, in numbers of moderate length."""
        found = self.exact(x)
        return Cut(_shortened(found.u), _shortened(found.w), x)

    def bound(self, support: Sequence[Cut]) -> fmpq:
        """The upper bound from the points of some cuts, exactly."""
        exact = [cut if cut.x is None else self.exact(cut.x) for cut in support]
        if len(exact) == 1 and support[0].w == 0 and exact[0].w != 0:
            return fmpq(0)
        return mixture(exact)

    @property
    def at_infinity(self) -> Cut:
        """The cut of the limit."""
        top = self.D.degree()
        return Cut(self.U[top] / self.D[top], self.W[top] / self.D[top])

    def first_cuts(self) -> list[Cut]:
        """Both ends, and two pairs of points around each root of ``W``: there ``theta`` has no say."""
        cuts = [self.cut(fmpq(0)), self.at_infinity]
        if self.W.degree() > 0:
            for root in real_roots(self.W):
                if root > 0:
                    x = to_fmpq(exact_midpoint(root))
                    cuts += [self.cut(short_between(x * (1 + a), x * (1 + b))) for a, b in _AROUND]
        return cuts

    def level(self, theta: fmpq, level: fmpq) -> fmpq_poly:
        """``U + theta W - level D``."""
        return self.U + theta * self.W - level * self.D

    def exceeds(self, theta: fmpq, level: fmpq) -> bool:
        """Whether ``inf (U + theta W)/D > level``, the limit at infinity included; exact."""
        p = self.level(theta, level)
        return p.degree() == self.D.degree() and positive_from_zero(p)

    def violations(self, theta: fmpq, level: fmpq) -> list[Cut]:
        """Cuts that show where ``level`` is not exceeded; none if :meth:`exceeds` holds."""
        p = self.level(theta, level)
        marks = _positive_roots(p)
        if p.degree() == self.D.degree() and p[0] > 0 and not marks:
            return []
        found = [self.cut(x) for x in self.dips(p, marks, theta)]
        return found or [*(self.cut(x) for x in marks), self.cut(fmpq(0)), self.at_infinity]

    def nearby(self, cuts: Sequence[Cut], theta: fmpq) -> list[Cut]:
        """Cuts of the local minima of ``(U + theta W)/D`` next to given points, by Newton's method."""
        over = self.level(theta, fmpq(0))
        slope = over.derivative() * self.D - over * self.D.derivative()
        found = []
        with working_precision(max(128, 8 * self.D.degree())):
            f, df = arb_poly(slope), arb_poly(slope.derivative())
            for cut in cuts:
                if cut.x is None or not cut.x > 0:
                    continue
                x = arb(cut.x)
                for _ in range(NEWTON_STEPS):
                    bend = df(x)
                    if not bend > 0:
                        break
                    x = (x - f(x) / bend).mid()
                if 0 < float(x) < math.inf:
                    found.append(self.cut(to_fmpq(float(x))))
        return found

    def dips(self, p: fmpq_poly, marks: list[fmpq], theta: fmpq) -> list[fmpq]:
        """A point for each interval on which ``p``, a level polynomial with roots near ``marks``, is negative."""
        ends = [fmpq(0), *marks]
        dips = []
        for i, left in enumerate(ends):
            last = i == len(marks)
            right = 2 * left + 1 if last else ends[i + 1]
            inside = (left + right) / 2
            if p(inside) < 0:
                dips.append(inside if last else self._lowest(theta, left, right, inside))
        return dips

    def _lowest(self, theta: fmpq, left: fmpq, right: fmpq, inside: fmpq) -> fmpq:
        """About where ``(U + theta W)/D`` is least between two points, by golden section; ``inside`` if that fails."""
        top = self.level(theta, fmpq(0))
        ratio = (math.sqrt(5.0) - 1) / 2
        with working_precision(max(128, 8 * self.D.degree())):
            over, under = arb_poly(top), arb_poly(self.D)
            a, b = ball(Fraction(int(left.p), int(left.q))), ball(Fraction(int(right.p), int(right.q)))

            def at(t: float) -> tuple[float, float]:
                """Value at a share of the interval, with the share."""
                x = (a + (b - a) * t).mid()
                y = over(x) / under(x)
                return (float(y), t) if y.is_finite() else (math.inf, t)

            low, high = 0.0, 1.0
            one, two = at(1 - ratio), at(ratio)
            for _ in range(GOLDEN_STEPS):
                if one[0] < two[0]:
                    high, two = two[1], one
                    one = at(high - ratio * (high - low))
                else:
                    low, one = one[1], two
                    two = at(low + ratio * (high - low))
            best = to_fmpq(min(one, two)[1])
        x = short_between(*(left + (right - left) * best * (1 + side * NEAR * NEAR) for side in (-1, 1)))
        return x if self.level(theta, fmpq(0))(x) / self.D(x) < top(inside) / self.D(inside) else inside

    def everywhere(self, cuts: list[Cut], *, nonnegative: bool = False) -> fmpq | None:
        """A ``theta`` with ``U + theta W >= 0`` on ``[0, inf)``; None if none was found.

        Parameters
        ----------
        cuts : list of Cut
            Known cuts.
        nonnegative : bool
            Whether only ``theta >= 0`` is admitted.
        """
        known = [CAP, *cuts, *self._edge_cuts()]
        for _ in range(LEVEL_ROUNDS):
            window = admissible(known, fmpq(0), nonnegative=nonnegative)
            if window is None:
                return None
            theta = choice(window)
            p = self.level(theta, fmpq(0))
            if is_nonnegative(p):
                return theta
            known += [self.cut(x) for x in self.dips(p, _positive_roots(p), theta)]
        return None

    def _edge_cuts(self) -> list[Cut]:
        """The leading coefficients at zero and at infinity, as cuts for the level 0 alone."""
        powers = [i for i in range(self.D.degree() + 1) if self.U[i] != 0 or self.W[i] != 0]
        return [Cut(self.U[i], self.W[i]) for i in (powers[0], powers[-1])] if powers else []

    @property
    def mirrored(self) -> PolynomialFamily:
        """The same for ``-theta``."""
        return PolynomialFamily(self.D, self.U, -self.W)

    def stretched(self, tau: fmpq) -> PolynomialFamily:
        """``(U + theta W/(1 + tau x))/D``."""
        stretch = fmpq_poly([1, tau])
        return PolynomialFamily(self.D * stretch, self.U * stretch, self.W)

    def rises_for_ever(self) -> bool:
        """Whether ``m`` tends to 0 or more for ``theta -> inf``: ``W >= 0``, and ``U >= 0`` where ``W/D`` vanishes."""
        if self.W.degree() < 0 or not is_nonnegative(self.W):
            return False
        ends = [self.cut(fmpq(0)), self.at_infinity]
        if any(end.w == 0 and end.u < 0 for end in ends):
            return False
        rest, shared = self.W, self.W.gcd(self.U)
        while shared.degree() > 0:
            rest = rest // shared
            shared = rest.gcd(self.U)
        return all(_positive_at(self.U, rest, i) for i, root in enumerate(real_roots(rest)) if root > 0)


_AROUND = [(-NEAR, -NEAR / 2), (-CLOSE, -CLOSE / 2), (CLOSE / 2, CLOSE), (NEAR / 2, NEAR)]


def _shortened(value: fmpq) -> fmpq:
    """A number next to another, with the same sign and of about 256 bits."""
    top, bottom = int(value.p), int(value.q)
    excess = min(top.bit_length(), bottom.bit_length()) - BITS
    return fmpq(top >> excess, bottom >> excess) if excess > 0 else value


def _positive_roots(p: fmpq_poly) -> list[fmpq]:
    """Points near the positive roots of a polynomial, in ascending order; as many as there are."""
    return [to_fmpq(exact_midpoint(root)) for root in real_roots(p) if root > 0] if p.degree() > 0 else []


def short_between(low: fmpq, high: fmpq) -> fmpq:
    """The simplest rational between two others."""
    first, last = (Fraction(int(end.p), int(end.q)) for end in (low, high))
    return to_fmpq(simplest_between(first, last))


def is_nonnegative(p: fmpq_poly) -> bool:
    """Whether ``p(x) >= 0`` for every ``x >= 0``."""
    if p.degree() < 0:
        return True
    if p[p.degree()] < 0:
        return False
    odd = [factor for factor, times in p.numer().factor_squarefree()[1] if int(times) % 2]
    return all(positive_root_count(fmpq_poly(factor)) == 0 for factor in odd if factor.degree() > 0)


def _positive_at(p: fmpq_poly, q: fmpq_poly, index: int) -> bool:
    """Whether ``p > 0`` at a root of ``q``, given by its place among the real ones; they share no root."""
    bits = 128
    while True:
        with working_precision(bits):
            there = arb_poly(p)(real_roots(q)[index])
            if there > 0 or there < 0:
                return bool(there > 0)
        bits *= 2


@dataclass(frozen=True, slots=True)
class LeastValue:
    """``low <= inf (U + theta W)/D <= high``, exactly; ``low`` None if no bound was found."""

    low: Fraction | None
    high: Fraction
    x: Fraction | None

    @property
    def frequency(self) -> float:
        """``sqrt(x)`` where the value is least, ``inf`` if only in the limit."""
        return math.inf if self.x is None else math.sqrt(self.x)

    def bracket(self, inverse_gain: Fraction = Fraction(0)) -> Bracket:
        """The bracket of the value plus ``inverse_gain`` in doubles."""
        low = -math.inf if self.low is None else double_below(self.low + inverse_gain)
        return Bracket(low, double_above(self.high + inverse_gain))


def least_value(family: PolynomialFamily, theta: Fraction) -> LeastValue:
    """The infimum of ``(U + theta W)/D`` on ``[0, inf]``, relative width about 1e-10, and where it is attained.

    Parameters
    ----------
    family : PolynomialFamily
        The functions.
    theta : Fraction
        The multiplier.
    """
    total = family.U + to_fmpq(theta) * family.W
    fixed = PolynomialFamily(family.D, total, fmpq_poly([]))
    start = [fixed.cut(fmpq(0)), fixed.at_infinity]
    lowest = min(start, key=lambda cut: cut.u)
    lowered = PolynomialFamily(family.D, total - lowest.u * family.D, fmpq_poly([]))
    found = search(lowered, lowered.first_cuts(), lambda level: level)
    low = None if found.theta is None else to_fraction(found.level + lowest.u)
    least = found.upper_bound.support[0]
    where: Cut = lowest if least is CAP else least
    return LeastValue(
        low, to_fraction(found.upper_bound.value + lowest.u), None if where.x is None else to_fraction(where.x)
    )
