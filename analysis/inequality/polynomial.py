"""The inequality of a rational plant as polynomials, decided by exact root counts, its best multiplier searched for."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from typing import Any

from flint import arb, arb_poly, fmpq, fmpq_poly

from lure.analysis.inequality.checks import admitted_plant
from lure.analysis.inequality.gains import simplest_between
from lure.analysis.inequality.multiplier_search import CAP, Cut, admissible, choice, mixture, search
from lure.analysis.inequality.plant import TransferPolynomials
from lure.analysis.inequality.protocol import Best, Grounds, Multiplier, Proves
from lure.analysis.numerics.doubles import double_above, double_below
from lure.analysis.numerics.minimum import infimum, largest_below, nonnegative_from_zero
from lure.analysis.numerics.polynomial import (
    exact_midpoint,
    positive_from_zero,
    positive_root_count,
    real_roots,
    to_fmpq,
    to_fraction,
)
from lure.analysis.numerics.precision import ball, outward, working_precision
from lure.analysis.verdict import INFINITE, Bracket
from lure.plants.rational import RationalPlant
from lure.record import described, quantity

TRIES = 100
MARGIN_BITS = 128


@described(frozen=True, kw_only=True, slots=True)
class RationalInequality:
    """``1/(k - lower) + (U + theta W)/D > 0`` on ``[0, inf]`` with one weight ``theta``."""

    plant: TransferPolynomials = quantity("The plant shifted by ``lower``")
    lower: Fraction = quantity("Lower end of the classes")
    family: PolynomialFamily = quantity("``D``, ``U`` and ``W``")
    weight: str = quantity("Name of ``theta``", default="theta")
    nonnegative: bool = quantity("Whether only ``theta >= 0`` is admitted", default=False)
    squared: bool = quantity(
        "Whether the variable is ``omega^2`` (in discrete time ``tan^2(omega/2)``); else it is ``omega``", default=True
    )

    @classmethod
    def of(
        cls, block: RationalPlant, lower: Fraction, criterion: str, *, discrete: bool = False, critical: bool = False
    ) -> RationalInequality:
        """Popov's inequality of a plant, in discrete time that of the plant mapped by ``z = (1 + s)/(1 - s)``.

        Raises
        ------
        AssumptionError, InputError
            As ``admitted_plant`` of ``lure.analysis.inequality.checks``.
        """
        plant = admitted_plant(block, lower, criterion, discrete=discrete, critical=critical)
        response = plant.visible.response
        return cls(plant=plant, lower=lower, family=PolynomialFamily(response.D, response.U, response.W))

    @property
    def grounds(self) -> Grounds:
        """The shifted plant, decided by Sturm's theorem."""
        plant = self.plant
        shift = f" after the shift by {float(self.lower):g}" if self.lower else ""
        inside = "inside the unit circle" if plant.discrete else "in the open left half-plane"
        return Grounds(
            lower=self.lower,
            direct=self.direct,
            critical=plant.case == "critical",
            discrete=plant.discrete,
            poles=f"all poles {inside}{shift}, hidden modes too: checked by an exact count"
            if plant.case == "stable"
            else f"one simple pole at 0{shift} with residue {float(plant.residue):.6g} > 0, all others {inside}, "
            "hidden modes too: checked by exact counts",
            means="an exact root count",
        )

    @property
    def direct(self) -> Fraction:
        """The direct term ``D`` of the shifted plant."""
        given = self.plant.block.feedthrough
        return given / (1 + self.lower * given)

    @property
    def unweighted(self) -> RationalInequality:
        """The same without the weight: the circle criterion's."""
        return replace(self, family=replace(self.family, W=fmpq_poly([])))

    def decide(self, multiplier: Multiplier, upper: Fraction) -> bool:
        """Whether the multiplier proves the class ``[lower, upper]``, exactly."""
        level = -1 / (Fraction(upper) - self.lower)
        legal = not self.nonnegative or multiplier[self.weight] >= 0
        return legal and self.direct > level and self.family.exceeds(to_fmpq(multiplier[self.weight]), to_fmpq(level))

    def best(self, enough: Fraction | None = None) -> Best:
        """The best multiplier, and how far it goes."""
        if self.family.W.degree() < 0:
            return self._unweighted()
        cuts = [*self.family.first_cuts(), Cut(to_fmpq(self.direct), fmpq(0))]  # 1 + k D > 0, or no solution perhaps
        if self.direct >= 0:
            theta = self._for_every_finite(cuts)
            if theta is not None:
                return Best(multiplier={self.weight: theta}, largest=INFINITE)
        found = search(self.family, cuts, self.level_of_a_double, nonnegative=self.nonnegative)
        top = to_fraction(found.upper_bound.value)
        low = self.lower if found.theta is None else self.lower - 1 / to_fraction(found.level)
        return Best(
            multiplier=None if found.theta is None else {self.weight: to_fraction(found.theta)},
            largest=Bracket(double_below(low), double_above(self.lower - 1 / top) if top < 0 else math.inf),
            points=tuple(None if cut.x is None else to_fraction(cut.x) for cut in found.upper_bound.support),
            worst_frequency=self.frequency(None if (x := found.upper_bound.support[0].x) is None else to_fraction(x)),
        )

    def _unweighted(self) -> Best:
        """How far the inequality goes without a weight, from all its stationary points."""
        found = infimum(self.family.U, self.family.D)
        nothing: Multiplier = {self.weight: Fraction(0)}
        where: dict[str, Any] = {
            "points": (None if found.where == math.inf else Fraction(found.where),),
            "worst_frequency": self.frequency(found.where),
        }
        if found.low >= 0:
            return Best(multiplier=nothing, largest=INFINITE, **where)
        with working_precision(MARGIN_BITS):
            guess = outward(ball(self.lower) - 1 / found.low, ball(self.lower) - 1 / found.high)
        low = largest_below(self.family.D, self.family.U, guess.low, self.lower)
        if low is None:
            return Best(multiplier=None, largest=Bracket(double_below(self.lower), guess.high), **where)
        return Best(multiplier=nothing, largest=Bracket(low, guess.high), **where)

    def _for_every_finite(self, cuts: list[Cut]) -> Fraction | float | None:
        """A weight for every finite ``k``, infinite where it must grow with ``k``; None if none was found."""
        theta = self.family.everywhere(cuts, nonnegative=self.nonnegative)
        if theta is not None:
            return to_fraction(theta)
        if all(cut.w >= 0 for cut in cuts) and self.family.rises_for_ever():
            return math.inf
        if not self.nonnegative and all(cut.w <= 0 for cut in cuts) and self.family.mirrored.rises_for_ever():
            return -math.inf
        return None

    def serving(self, best: Best, proves: Proves) -> Multiplier:
        """The best multiplier or one beside it that proves a class; where none does, a finite one all the same."""
        start = Fraction(0) if best.multiplier is None else best.multiplier[self.weight]
        candidates: list[Fraction]
        if isinstance(start, float):
            start = Fraction(1 if start > 0 else -1)
            candidates = [start * Fraction(4) ** power for power in range(-8, TRIES)]
        else:
            candidates = [start * Fraction(c) for c in ("1", "9/8", "2", "7/8")] if start else [start, Fraction(1)]
        given: list[Multiplier] = [{self.weight: theta} for theta in candidates]
        return next((each for each in given if proves(each)), {self.weight: start})

    def least(self, multiplier: Multiplier, upper: Fraction | float) -> tuple[Bracket, float]:
        """The infimum over frequency of the left-hand side, and where it is attained [rad/s; rad per sample]."""
        return self.least_of(self.family, multiplier[self.weight], upper)

    def least_of(self, family: PolynomialFamily, theta: Fraction, upper: Fraction | float) -> tuple[Bracket, float]:
        """The same for another family: that of a second weight."""
        found = infimum(family.U + to_fmpq(theta) * family.W, family.D)
        with working_precision(MARGIN_BITS):
            inverse = arb(0) if upper == math.inf else 1 / ball(Fraction(upper) - self.lower)
            return outward(found.low + inverse, found.high + inverse), self.frequency(found.where)

    def frequency(self, x: Fraction | float | None) -> float:
        """The frequency [rad/s; rad per sample] at a value of the variable; None is infinity."""
        value = math.inf if x is None else float(x)
        return self.plant.frequency(math.sqrt(value) if self.squared else value)

    def level_of_a_double(self, level: fmpq) -> fmpq:
        """A level not above a negative one that belongs to a double ``lower - 1/level``, where there is one."""
        upper = Fraction(double_below(self.lower - 1 / to_fraction(level)))
        return -1 / to_fmpq(upper - self.lower) if upper > self.lower else level


@described(frozen=True, kw_only=True, slots=True)
class LossyInequality:
    """``1/K + (U + q (W - K V))/D > 0`` with ``q, V >= 0``, ``K = k - lower``: a loss that grows with the class.

    Where it holds for one ``K``, it holds with the same ``q`` for every smaller one.
    """

    base: RationalInequality = quantity("The same without loss")
    loss: fmpq_poly = quantity("``V``")

    @property
    def grounds(self) -> Grounds:
        """Those of the inequality without loss."""
        return self.base.grounds

    def at(self, upper: Fraction) -> RationalInequality:
        """The inequality with the loss of ``K = upper - lower``."""
        family = self.base.family
        return replace(
            self.base, family=replace(family, W=family.W - to_fmpq(Fraction(upper) - self.base.lower) * self.loss)
        )

    def best(self, enough: Fraction | None = None) -> Best:
        """The best weight: where the ``k`` that is reached with the loss of ``k'`` falls below ``k'``, by secants.

        With the loss of ``k'`` every class up to ``g(k')`` is reached, and ``g`` decreases: the largest class lies
        between ``k'`` and ``g(k')``.
        """
        found, start = self.base.unweighted.best(), float(self.base.lower)
        low, high = found.largest.low, math.inf
        if low == math.inf or not low > start:
            return found
        ends = [(low, math.inf), (math.inf, -math.inf)]  # k' and g(k'), below the crossing and above it
        k, left = low + CLOSED / 2 * (low - start), low
        for step in range(STEPS):
            lossy = self.at(Fraction(k))
            trial = lossy.best()
            reached = min(k, trial.largest.low)
            left, high = max(left, reached), min(high, max(k, trial.largest.high))
            if trial.multiplier is not None and reached > low:
                proves = partial(lossy.decide, upper=Fraction(reached))
                used = lossy.serving(trial, proves)
                low, found = (reached, replace(trial, multiplier=used)) if proves(used) else (low, found)
            if math.isfinite(high) and high - left <= CLOSED * (high - start):
                break
            ends[trial.largest.low <= k] = (k, trial.largest.low)
            k = min(high, start + 4 * (k - start)) if high == math.inf else _crossing(ends, left, high, step)
        return replace(found, largest=Bracket(low, high))

    def serving(self, best: Best, proves: Proves) -> Multiplier:
        """The best multiplier or one beside it that proves a class; where none does, a finite one all the same."""
        return self.base.serving(best, proves)

    def decide(self, multiplier: Multiplier, upper: Fraction) -> bool:
        """Whether the multiplier proves the class ``[lower, upper]``, exactly."""
        return self.at(upper).decide(multiplier, upper)

    def least(self, multiplier: Multiplier, upper: Fraction | float) -> tuple[Bracket, float]:
        """The infimum over frequency of the left-hand side, and where it is attained [rad per sample]."""
        return (self.base if upper == math.inf else self.at(Fraction(upper))).least(multiplier, upper)


STEPS = 90
CLOSED = 1e-11


def _crossing(ends: Sequence[tuple[float, float]], left: float, right: float, step: int) -> float:
    """Where the secant through two points meets the diagonal; every third step, the middle between two bounds."""
    (a, at_a), (b, at_b) = ends
    middle, rise, fall = left + (right - left) / 2, at_a - a, b - at_b
    if step % 3 == 2 or not (math.isfinite(rise) and math.isfinite(fall) and rise + fall > 0):
        return middle
    inside = (right - left) * SAFE
    return min(max(a + (b - a) * rise / (rise + fall), left + inside), right - inside)


SAFE = 1e-3


# ``(U + theta W)/D`` on ``[0, inf]`` for polynomials: exact levels, and points where a level fails.

LEVEL_ROUNDS = 30
GOLDEN_STEPS = 30
NEWTON_STEPS = 6
BITS = 160
NEAR = fmpq(1, 2**20)
CLOSE = fmpq(1, 2**90)


@dataclass(frozen=True, slots=True)
class PolynomialFamily:
    """``(U + theta W)/D`` on ``[0, inf]``, ``D > 0`` on ``(0, inf)``, no degree above that of ``D``.

    ``D(0) > 0``, or ``U(0) = D(0) = 0 < W(0)``: then a ``theta > 0`` sends it to infinity there, and no level counts.
    """

    D: fmpq_poly
    U: fmpq_poly
    W: fmpq_poly

    def exact(self, x: fmpq) -> Cut:
        """The cut of a point, exactly."""
        bottom = self.D(x) or fmpq(1)
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

        ``cuts``: known cuts; ``nonnegative``: whether only ``theta >= 0`` is admitted.
        """
        known = [CAP, *cuts, *self._edge_cuts()]
        for _ in range(LEVEL_ROUNDS):
            window = admissible(known, fmpq(0), nonnegative=nonnegative)
            if window is None:
                return None
            theta = choice(window)
            p = self.level(theta, fmpq(0))
            if nonnegative_from_zero(p):
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
        if self.W.degree() < 0 or not nonnegative_from_zero(self.W):
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
    found = real_roots(p) if p.degree() > 0 and positive_root_count(p) else []
    return [to_fmpq(exact_midpoint(root)) for root in found if root > 0]


def short_between(low: fmpq, high: fmpq) -> fmpq:
    """The simplest rational between two others."""
    first, last = (Fraction(int(end.p), int(end.q)) for end in (low, high))
    return to_fmpq(simplest_between(first, last))


def _positive_at(p: fmpq_poly, q: fmpq_poly, index: int) -> bool:
    """Whether ``p > 0`` at a root of ``q``, given by its place among the real ones; they share no root."""
    bits = 128
    while True:
        with working_precision(bits):
            there = arb_poly(p)(real_roots(q)[index])
            if there > 0 or there < 0:
                return bool(there > 0)
        bits *= 2
