"""The criterion of Yakubovich and Park for nonlinearities of restricted slope."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from flint import fmpq, fmpq_poly

from lure.analysis.inequality.multiplier_search import Cut, SearchResult, search
from lure.analysis.inequality.polynomial import PolynomialFamily, RationalInequality, short_between
from lure.analysis.inequality.protocol import Best, Grounds, Multiplier, Proves
from lure.analysis.numerics.doubles import double_above, double_below
from lure.analysis.numerics.polynomial import X, to_fmpq, to_fraction
from lure.analysis.theorems.criterion import Criterion
from lure.analysis.verdict import INFINITE, Bracket, CriterionResult
from lure.classes import SlopeBounds
from lure.errors import InputError
from lure.plants.rational import RationalPlant
from lure.record import described, quantity

# The best multiplier ``1 + theta s - tau s^2``: bisection in ``tau`` on exact cutting planes in ``theta``.
#
# For fixed ``tau`` the inequality is ``(U + theta W/(1 + tau x))/D > -1/k``, as in Popov's.  Its support, points
# ``x_i``
# with weights ``l_i`` such that ``sum l_i W/D = 0``, says more: no ``theta`` and ``tau`` exceed the level ``m`` unless
# ``S_0 + tau S_1 > 0``, ``S_j = sum l_i x_i^j (U/D - m)``.  So it tells on which side of ``tau`` to go on, and two
# supports with opposite answers bound the criterion's reach from above.

EXPANSIONS = 24
HALVINGS = 60
STEPS_UP = 200
KEPT = 32
LOOSE = fmpq(1, 10**11)
CLOSED = fmpq(1, 10**11)


@dataclass(frozen=True, slots=True)
class Support:
    """Points of ``[0, inf)`` with weights: ``sum l w = 0`` exactly."""

    cuts: tuple[Cut, ...]
    weights: tuple[fmpq, ...]

    def moment(self, power: int, level: fmpq) -> fmpq:
        """``S_j`` at a level."""
        total = fmpq(0)
        for cut, weight in zip(self.cuts, self.weights, strict=True):
            x = fmpq(0) if cut.x is None else cut.x
            total += weight * x**power * (cut.u - level)
        return total


@described(frozen=True, kw_only=True, slots=True)
class ParkInequality:
    """``1/(k - lower) + (U + theta W/(1 + tau x))/D > 0`` on ``[0, inf]`` with ``tau >= 0``."""

    base: RationalInequality = quantity("The same for ``tau = 0``")

    @classmethod
    def of(cls, block: RationalPlant, lower: Fraction) -> ParkInequality:
        """The inequality of a plant that is stable, or in the critical case."""
        return cls(base=RationalInequality.of(block, lower, NAME, critical=True))

    @property
    def time_scale(self) -> fmpq:
        """A typical time constant: the geometric mean."""
        d = self.base.family.D
        ratio = abs(float(to_fraction(d[0]))), abs(float(to_fraction(d[d.degree()])))
        if d.degree() < 1 or not all(0 < value < math.inf for value in ratio):
            return fmpq(1)
        mean = (ratio[0] / ratio[1]) ** (-0.5 / d.degree())
        return to_fmpq(Fraction(mean).limit_denominator(10**6) or Fraction(mean))

    @property
    def grounds(self) -> Grounds:
        """Those of Popov's inequality."""
        return self.base.grounds

    def best(self, enough: Fraction | None = None) -> Best:
        """The best multiplier: Popov's if that serves every finite ``k``, one with ``tau -> inf`` if that does."""
        popov, family = self.base.best(), self.base.family
        if popov.multiplier is not None and popov.largest.low == math.inf:
            return Best(multiplier={**popov.multiplier, "tau": Fraction(0)}, largest=INFINITE)
        if family.U[0] >= 0 or self.grounds.critical:  # x U + r W >= 0: theta = r tau serves every k for tau large
            ratio = PolynomialFamily(*self._over_tau).everywhere([])
            if ratio is not None:
                return Best(multiplier={"theta/tau": to_fraction(ratio), "tau": math.inf}, largest=INFINITE)
        return _Search(self.base, list(family.first_cuts())).run(self.time_scale**2)

    @property
    def _over_tau(self) -> tuple[fmpq_poly, fmpq_poly, fmpq_poly]:
        """``D, U, W/x``; in the critical case, where ``W(0)`` is the residue, times ``x``, and ``D`` any other."""
        family = self.base.family
        if self.grounds.critical:
            return family.D * (X + 1), X * family.U, family.W
        return family.D, family.U, family.W // X

    def serving(self, best: Best, proves: Proves) -> Multiplier:
        """The best multiplier or one beside it that proves a class; where none does, a finite one all the same."""
        if best.multiplier is None or isinstance(best.multiplier.get("theta"), float):
            used = self.base.serving(best, lambda given: proves({**given, "tau": Fraction(0)}))
            return {**used, "tau": Fraction(0)}
        if "theta" in best.multiplier:
            return {name: Fraction(value) for name, value in best.multiplier.items()}
        tau, ratio = to_fraction(self.time_scale) ** 2, Fraction(best.multiplier["theta/tau"])
        for _ in range(STEPS_UP):
            if proves({"theta": ratio * tau, "tau": tau}):
                break
            tau *= 16
        return {"theta": ratio * tau, "tau": tau}

    def decide(self, multiplier: Multiplier, upper: Fraction) -> bool:
        """Whether the multiplier proves the class ``[lower, upper]``, exactly."""
        level = -1 / (Fraction(upper) - self.base.lower)
        stretched = self.base.family.stretched(to_fmpq(multiplier["tau"]))
        return self.base.direct > level and stretched.exceeds(to_fmpq(multiplier["theta"]), to_fmpq(level))

    def least(self, multiplier: Multiplier, upper: Fraction | float) -> tuple[Bracket, float]:
        """The infimum over frequency of the left-hand side over ``1 + tau omega^2``, and where it is attained."""
        stretched = self.base.family.stretched(to_fmpq(multiplier["tau"]))
        return self.base.least_of(stretched, multiplier["theta"], upper)


@dataclass(slots=True)
class _Search:
    """The largest level that some ``theta`` and ``tau >= 0`` exceed; ``level`` 0 stands for every negative one."""

    popov: RationalInequality
    raw: list[Cut]
    theta: fmpq | None = None
    tau: fmpq = field(default_factory=fmpq)
    level: fmpq = field(default_factory=lambda: fmpq(-1))
    unreachable: fmpq | None = None
    low: tuple[fmpq, Support] | None = None
    high: tuple[fmpq, Support] | None = None

    def run(self, tau: fmpq) -> Best:
        """The best multiplier found, beginning at ``tau``."""
        done = self._visit(fmpq(0))
        for _ in range(EXPANSIONS):
            if done or self._visit(tau):
                return self._best()
            if self.high is not None and self.low is not None and self.low[0] > 0:
                break
            tau = tau * 16 if self.high is None else tau / 16
        for _ in range(HALVINGS if self.high is not None else 0):
            if self._closed() or self._visit(self._between()):
                break
        return self._best()

    def _best(self) -> Best:
        lower, top = self.popov.lower, self.unreachable
        found = None
        if self.theta is not None:
            found = {"theta": to_fraction(self.theta), "tau": to_fraction(self.tau)}
            if self.level == 0:
                return Best(multiplier=found, largest=INFINITE)
        high = double_above(lower - 1 / to_fraction(top)) if top is not None and top < 0 else math.inf
        low = lower if self.theta is None else lower - 1 / to_fraction(self.level)
        return Best(multiplier=found, largest=Bracket(double_below(low), high))

    def _visit(self, tau: fmpq) -> bool:
        """Look at one ``tau``; whether nothing better is left."""
        stretched = self.popov.family.stretched(tau)
        direct = Cut(to_fmpq(self.popov.direct), fmpq(0))
        found = search(stretched, [*(_stretch(cut, tau) for cut in self.raw), direct], self.popov.level_of_a_double)
        if found.theta is not None and (self.theta is None or found.level > self.level):
            self.theta, self.tau, self.level = found.theta, tau, found.level
        self.raw = self._kept(found)
        if any(cut.x is None for cut in found.upper_bound.support):
            return self._at_infinity(found, stretched, tau)
        support = self._support(found)
        level = found.upper_bound.value * (1 - LOOSE)
        if support.moment(0, level) <= 0 and support.moment(1, level) <= 0:
            self.unreachable = level
            return True
        if support.moment(1, found.upper_bound.value) > 0:
            self.low = (tau, support)
        else:
            self.high = (tau, support)
        return False

    def _kept(self, found: SearchResult) -> list[Cut]:
        theta = found.theta if found.theta is not None else fmpq(0)
        inner = sorted((cut for cut in found.cuts if cut.x is not None), key=lambda cut: cut.at(theta))
        family = self.popov.family
        return [family.at_infinity, *(family.cut(cut.x) for cut in inner[:KEPT] if cut.x is not None)]

    def _at_infinity(self, found: SearchResult, stretched: PolynomialFamily, tau: fmpq) -> bool:
        """Whether the bound is one that no multiplier moves: a level of 0, or ``1/k + D > 0``."""
        if not all(cut.w == 0 for cut in found.upper_bound.support):
            return False
        theta = stretched.everywhere(list(found.cuts)) if found.upper_bound.value == 0 else None
        if theta is not None:
            self.theta, self.tau, self.level = theta, tau, fmpq(0)
        elif found.upper_bound.value < 0:
            self.unreachable = found.upper_bound.value
        return True

    def _support(self, found: SearchResult) -> Support:
        """The support in terms of the unstretched functions."""
        exact = self.popov.family.exact
        cuts = tuple(exact(cut.x) for cut in found.upper_bound.support if cut.x is not None)
        return Support(cuts, (fmpq(1),) if len(cuts) == 1 else (-cuts[1].w, cuts[0].w))

    def _between(self) -> fmpq:
        assert self.low is not None
        assert self.high is not None
        ratio = float(self.high[0] / self.low[0]) ** 0.5
        root = self.low[0] * fmpq(int(ratio * 2**60), 2**60)
        gap = (self.high[0] - self.low[0]) / 16
        return short_between(root - min(gap, root / 16), root + gap)

    def _closed(self) -> bool:
        """Whether the two supports together bound every pair at a level next to the best one."""
        assert self.low is not None
        assert self.high is not None
        level = self.level * (1 - CLOSED)
        if level < 0 and jointly_infeasible((self.low[1], self.high[1]), level):
            self.unreachable = level
            return True
        return False


def jointly_infeasible(supports: Sequence[Support], level: fmpq) -> bool:
    """Whether some mixture of two supports has ``S_0 <= 0`` and ``S_1 <= 0``: then nothing exceeds the level."""
    one, two = supports
    a0, a1, b0, b1 = one.moment(0, level), one.moment(1, level), two.moment(0, level), two.moment(1, level)
    mixtures = [(fmpq(1), fmpq(0)), (fmpq(0), fmpq(1))]
    if a1 * b1 < 0:
        mixtures.append((abs(b1), abs(a1)))
    if a0 * b0 < 0:
        mixtures.append((abs(b0), abs(a0)))
    return any(p * a0 + q * b0 <= 0 and p * a1 + q * b1 <= 0 for p, q in mixtures)


def _stretch(cut: Cut, tau: fmpq) -> Cut:
    if cut.x is None:
        return cut if tau == 0 else Cut(cut.u, fmpq(0))
    return Cut(cut.u, cut.w / (1 + tau * cut.x), cut.x)


NAME = "Park's criterion"
PARK = Criterion(
    name="park",
    title=NAME,
    theorem="Yakubovich's criterion for restricted slope, found again by P. Park, IEEE Trans. Automatic Control 47 "
    "(2002) 308-313; by J. Carrasco, W. P. Heath, A. Lanzon, Automatica 49 (2013) 1732-1740, a case of the theorem of "
    "G. Zames and P. L. Falb, SIAM J. Control 6 (1968) 89-108",
    formula="1 + theta s - tau s^2",
    inequality=ParkInequality.of,
    kind="multiplier of this form",
)


def park_largest(block: RationalPlant, *, lower: Fraction = Fraction(0)) -> CriterionResult:
    r"""The largest ``k`` for which the criterion proves the slope bounds ``[lower, k]``, with the best multiplier.

    For ``mu = -phi(sigma)``, ``sigma = H mu``, ``H`` stable and ``lower = 0`` it asks for ``tau >= 0`` and a real
    ``theta`` with

    .. math:: \mathrm{Re}[(1 + \tau\omega^2 + i\omega\theta)(H(i\omega) + 1/k)] > 0, \quad 0 \le \omega < \infty,

    the limit of the left-hand side over ``1 + tau omega^2`` positive, and ``1 + k H(inf) > 0`` (a condition of its own
    for ``tau = 0``).  Then 0 is globally asymptotically stable for every time-invariant ``phi`` with ``phi(0) = 0`` and
    slope in ``[lower, k]``, odd or not; for ``tau = 0`` it is Popov's criterion.

    Parameters
    ----------
    block : RationalPlant
        A continuous-time block; hidden modes must be stable.
    lower : Fraction
        Lower slope bound; the loop is shifted by it first.

    Returns
    -------
    CriterionResult
        ``largest.low``: certified by an exact root count; ``largest.high``: no ``theta`` and ``tau`` reach it, by the
        values of ``H`` at up to four rational points; ``inf`` where none were found.  ``parameters``: ``theta`` [s] and
        ``tau`` [s^2], or ``tau: inf`` with the ratio ``theta/tau`` where each finite ``k`` needs larger ones.

    Raises
    ------
    AssumptionError
        The block is in discrete time, or the shifted block is not stable but for a simple pole at 0; with that, every
        solution converges to a point of the stationary set, and 0 attracts them only if ``phi`` vanishes at 0 alone.
    InputError
        ``1 + lower H(inf) = 0``.

    Notes
    -----
    For ``tau > 0`` write ``1 + theta s - tau s^2 = tau (a - s)(b + s)``, ``a, b > 0``.  On the axis it is a positive
    multiple of ``Z = (b + s)/(a + s)``, and of ``Z = (a - s)/(b - s)``.  The first, if ``b <= a``, is ``1 - z`` with
    ``z = (a - b) exp(-a t) >= 0`` for ``t > 0``; the second, if ``a <= b``, with ``z = (b - a) exp(b t) >= 0`` for
    ``t < 0``; both have ``int z = |a - b|/max(a, b) < 1``.  So ``Z`` is a Zames-Falb multiplier for monotone
    nonlinearities, and ``Re[Z (H + 1/k)]`` is bounded away from 0 on ``[0, inf]``: signals are square integrable, with
    a gain from the initial state, and hidden modes decay.  With a direct term, ``1 + k D > 0`` makes ``sigma + D
    phi(sigma)`` invertible.

    Examples
    --------
    >>> park_largest(RationalPlant([1, 0, 0], [1, Fraction("0.2"), 6, Fraction("0.1"), 1])).largest.low
    0.788331477
    """
    return PARK.largest(block, lower=lower)


def park_criterion(
    block: RationalPlant, bounds: SlopeBounds, *, theta: Fraction | None = None, tau: Fraction | None = None
) -> CriterionResult:
    r"""The criterion for given slope bounds, certified over all frequencies.

    Parameters
    ----------
    block : RationalPlant
        See :func:`park_largest`.
    bounds : SlopeBounds
        Finite; for ``upper = inf`` ask :func:`park_largest` whether every finite ``k`` is reached.
    theta, tau : Fraction, optional
        Multiplier [s], [s^2], both or neither; by default those of :func:`park_largest`.

    Returns
    -------
    CriterionResult
        PROVED or INCONCLUSIVE; ``margin`` is the infimum over frequency of the left-hand side over ``1 + tau omega^2``.

    Raises
    ------
    AssumptionError
        As :func:`park_largest`; a bound is infinite.
    InputError
        ``tau < 0``, only one of ``theta`` and ``tau``, or ``1 + k H(inf) = 0`` for some ``k`` within the bounds.
    """
    if (theta is None) != (tau is None) or (tau is not None and tau < 0):
        raise InputError(f"{NAME} needs theta and tau >= 0 together, or neither; got theta = {theta}, tau = {tau}")
    given = None if theta is None or tau is None else {"theta": Fraction(theta), "tau": Fraction(tau)}
    return PARK.decide(block, bounds, multiplier=given)
