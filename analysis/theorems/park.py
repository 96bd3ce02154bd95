"""The criterion of Yakubovich and Park for laws of restricted slope."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from types import MappingProxyType
from typing import Literal

from flint import fmpq

from lure.analysis.inequality.checks import finite_bounds, require_well_posed
from lure.analysis.inequality.multiplier_search import Cut, SearchResult, search
from lure.analysis.inequality.polynomial import (
    CONCLUSION,
    PolynomialFamily,
    PopovInequality,
    Reach,
    least_value,
    short_between,
)
from lure.analysis.numerics.doubles import double_above, double_below, text_above, text_below
from lure.analysis.numerics.polynomial import X, to_fmpq, to_fraction
from lure.analysis.verdict import Answer, Bracket, Evidence, Verdict
from lure.classes import NonlinearityClass, SlopeBounds
from lure.errors import InputError
from lure.plants.rational import RationalPlant

# The best multiplier ``1 + theta s - tau s^2``: bisection in ``tau`` on exact cutting planes in ``theta``.
#
# For fixed ``tau`` the inequality is ``(U + theta W/(1 + tau x))/D > -1/k``, as in Popov's.  Its support, points
# ``x_i``
# with weights ``l_i`` such that ``sum l_i W/D = 0``, says more: no ``theta`` and ``tau`` exceed the level ``m`` unless
# ``S_0 + tau S_1 > 0``, ``S_j = sum l_i x_i^j (U/D - m)``.  So it tells on which side of ``tau`` to go on, and two
# supports with opposite answers bound the criterion's reach from above.

EXPANSIONS = 24
HALVINGS = 60
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


@dataclass(frozen=True, slots=True)
class Best:
    """``theta``, ``tau`` and the level they exceed, with a level that no pair exceeds; None where none was shown.

    A level of 0 stands for every negative one.  ``growing`` says what must grow with ``k`` then: ``theta``, whose
    sign is given, or ``tau``, with ``theta`` the ratio ``theta/tau``.
    """

    theta: fmpq | None
    tau: fmpq
    level: fmpq
    unreachable: fmpq | None = None
    growing: Literal["", "theta", "tau"] = ""


def best_pair(family: PolynomialFamily, scale: fmpq, rounded: Callable[[fmpq], fmpq]) -> Best:
    """The largest level that some ``theta`` and ``tau >= 0`` exceed.

    Parameters
    ----------
    family : PolynomialFamily
        ``D, U, W`` of a stable block.
    scale : fmpq
        A typical ``1/x``: where ``tau`` begins.
    rounded : callable
        As in :func:`lure.analysis.inequality.multiplier_search.search`.
    """
    return _Search(family, rounded, list(family.first_cuts())).run(scale)


@dataclass(slots=True)
class _Search:
    family: PolynomialFamily
    rounded: Callable[[fmpq], fmpq]
    raw: list[Cut]
    best: Best = Best(None, fmpq(0), fmpq(-1))
    low: tuple[fmpq, Support] | None = None
    high: tuple[fmpq, Support] | None = None

    def run(self, scale: fmpq) -> Best:
        """The best multiplier found."""
        if self._visit(fmpq(0)):
            return self.best
        tau = scale
        for _ in range(EXPANSIONS):
            if self._visit(tau):
                return self.best
            if self.high is not None and self.low is not None and self.low[0] > 0:
                break
            tau = tau * 16 if self.high is None else tau / 16
        for _ in range(HALVINGS if self.high is not None else 0):
            if self._closed() or self._visit(self._between()):
                break
        return self.best

    def _visit(self, tau: fmpq) -> bool:
        """Look at one ``tau``; whether nothing better is left."""
        stretched = self.family.stretched(tau)
        cuts = [_stretch(cut, tau) for cut in self.raw]
        direct = Cut(self.family.at_infinity.u, fmpq(0))
        found = search(stretched, [*cuts, direct], self.rounded)
        if found.theta is not None and (self.best.theta is None or found.level > self.best.level):
            self.best = Best(found.theta, tau, found.level, self.best.unreachable)
        self.raw = self._kept(found)
        if any(cut.x is None for cut in found.upper_bound.support):
            return self._at_infinity(found, stretched, tau)
        support = self._support(found)
        level = found.upper_bound.value * (1 - LOOSE)
        if support.moment(0, level) <= 0 and support.moment(1, level) <= 0:
            self._bound(level)
            return True
        if support.moment(1, found.upper_bound.value) > 0:
            self.low = (tau, support)
        else:
            self.high = (tau, support)
        return False

    def _kept(self, found: SearchResult) -> list[Cut]:
        theta = found.theta if found.theta is not None else fmpq(0)
        inner = sorted((cut for cut in found.cuts if cut.x is not None), key=lambda cut: cut.at(theta))
        points = [cut.x for cut in inner[:KEPT]]
        return [self.family.at_infinity, *(self.family.cut(x) for x in points if x is not None)]

    def _at_infinity(self, found: SearchResult, stretched: PolynomialFamily, tau: fmpq) -> bool:
        """Whether the bound is one that no multiplier moves: a level of 0, or ``1/k + D > 0``."""
        if not all(cut.w == 0 for cut in found.upper_bound.support):
            return False
        theta = stretched.everywhere(list(found.cuts)) if found.upper_bound.value == 0 else None
        if theta is not None:
            self.best = Best(theta, tau, fmpq(0))
        elif found.upper_bound.value < 0:
            self._bound(found.upper_bound.value)
        return True

    def _support(self, found: SearchResult) -> Support:
        """The support in terms of the unstretched functions."""
        cuts = tuple(self.family.exact(cut.x) for cut in found.upper_bound.support if cut.x is not None)
        if len(cuts) == 1:
            return Support(cuts, (fmpq(1),))
        return Support(cuts, (-cuts[1].w, cuts[0].w))

    def _bound(self, level: fmpq) -> None:
        self.best = Best(self.best.theta, self.best.tau, self.best.level, level)

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
        level = self.best.level * (1 - CLOSED)
        if level < 0 and jointly_infeasible((self.low[1], self.high[1]), level):
            self._bound(level)
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
THEOREM = (
    "Yakubovich's criterion for restricted slope, found again by P. Park, IEEE Trans. Automatic Control 47 (2002) "
    "308-313; by J. Carrasco, W. P. Heath, A. Lanzon, Automatica 49 (2013) 1732-1740, a case of the theorem of "
    "G. Zames and P. L. Falb, SIAM J. Control 6 (1968) 89-108"
)
FORMULA = "1 + theta s - tau s^2"


def park_largest(block: RationalPlant, *, lower: Fraction = Fraction(0)) -> Answer:
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
    Answer
        ``largest.low``: certified by an exact root count; ``largest.high``: no ``theta`` and ``tau`` reach it, by the
        values of ``H`` at up to four rational points; ``inf`` where none were found.  ``parameters``: ``theta`` [s] and
        ``tau`` [s^2], or ``tau: inf`` with the ratio ``theta/tau`` where each finite ``k`` needs larger ones.

    Raises
    ------
    AssumptionError
        The block is in discrete time, or the shifted block is not stable (the critical case needs ``lower > 0``).
    InputError
        ``1 + lower H(inf) = 0``.

    Notes
    -----
    For ``tau > 0`` write ``1 + theta s - tau s^2 = tau (a - s)(b + s)``, ``a, b > 0``.  On the axis it is a positive
    multiple of ``Z = (b + s)/(a + s)``, and of ``Z = (a - s)/(b - s)``.  The first, if ``b <= a``, is ``1 - z`` with
    ``z = (a - b) exp(-a t) >= 0`` for ``t > 0``; the second, if ``a <= b``, with ``z = (b - a) exp(b t) >= 0`` for
    ``t < 0``; both have ``int z = |a - b|/max(a, b) < 1``.  So ``Z`` is a Zames-Falb multiplier for monotone laws, and
    ``Re[Z (H + 1/k)]`` is bounded away from 0 on ``[0, inf]``: signals are square integrable, with a gain from the
    initial state, and hidden modes decay.  With a direct term, ``1 + k D > 0`` makes ``sigma + D phi(sigma)``
    invertible.

    Examples
    --------
    >>> park_largest(RationalPlant([1, 0, 0], [1, Fraction("0.2"), 6, Fraction("0.1"), 1])).largest.low
    0.788331477
    """
    inequality = PopovInequality.of_stable(block, Fraction(lower), NAME)
    best = _best(inequality)
    largest = _largest(inequality, best)
    proved = best.theta is not None and largest.low > inequality.lower
    said = (
        "every finite k is proved"
        if largest.low == math.inf
        else f"every k up to {text_below(largest.low, 15)} is proved, and no multiplier of this form reaches "
        f"{text_above(largest.high, 15)}"
        if proved
        else "no k that a double can state was reached"
    )
    return Answer(
        criterion="park",
        theorem=THEOREM,
        largest=largest,
        law_class=NonlinearityClass.slope_restricted(inequality.lower, largest.low if proved else math.inf),
        verdict=Verdict.PROVED if proved else Verdict.INCONCLUSIVE,
        evidence=Evidence.CERTIFIED,
        needs=("slope", "time-invariant"),
        theta=float(to_fraction(best.theta)) if best.theta is not None and not best.growing else None,
        multiplier=FORMULA,
        parameters=_parameters(best),
        hypotheses=_hypotheses(inequality, holds=proved),
        reason=f"{said}; {CONCLUSION}" if proved else said,
    )


def park_criterion(
    block: RationalPlant, bounds: SlopeBounds, *, theta: Fraction | None = None, tau: Fraction | None = None
) -> Answer:
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
    Answer
        PROVED or INCONCLUSIVE; ``margin`` is the infimum over frequency of the left-hand side over ``1 + tau omega^2``.

    Raises
    ------
    AssumptionError
        As :func:`park_largest`; a bound is infinite.
    InputError
        ``tau < 0``, only one of ``theta`` and ``tau``, or ``1 + k H(inf) = 0`` for some ``k`` within the bounds.
    """
    lower, upper = finite_bounds(bounds, NAME)
    if (theta is None) != (tau is None) or (tau is not None and tau < 0):
        raise InputError(f"{NAME} needs theta and tau >= 0 together, or neither; got theta = {theta}, tau = {tau}")
    inequality = PopovInequality.of_stable(block, lower, NAME)
    require_well_posed(block, upper, lower=lower)
    best = _best(inequality)
    used = (to_fmpq(theta), to_fmpq(tau)) if theta is not None and tau is not None else _pair(inequality, best, upper)
    level = -1 / to_fmpq(upper - lower)
    family = inequality.family.stretched(used[1])
    holds = bool(inequality.direct > level) and family.exceeds(used[0], level)
    least = least_value(family, to_fraction(used[0]))
    margin = least.bracket(1 / (upper - lower))
    if holds:
        margin = Bracket(max(margin.low, 0.0), margin.high)
    largest = _largest(inequality, best)
    said = (
        f"the inequality holds at every frequency, the margin is {margin}; {CONCLUSION}"
        if holds
        else "the inequality fails with this multiplier, from which nothing follows for the loop; with the best one "
        f"the largest k is {largest}"
    )
    return Answer(
        criterion="park",
        theorem=THEOREM,
        largest=largest,
        law_class=NonlinearityClass.slope_restricted(bounds.lower, bounds.upper),
        verdict=Verdict.PROVED if holds else Verdict.INCONCLUSIVE,
        evidence=Evidence.CERTIFIED,
        needs=("slope", "time-invariant"),
        theta=float(to_fraction(used[0])),
        multiplier=FORMULA,
        parameters=MappingProxyType({"theta": str(used[0]), "tau": str(used[1])}),
        margin=margin,
        worst_frequency=least.frequency,
        hypotheses=_hypotheses(inequality, holds=holds),
        reason=said,
    )


def _best(inequality: PopovInequality) -> Best:
    popov = inequality.reach()
    if popov.found is None:
        endless = isinstance(popov.theta, float)
        theta = Fraction(math.copysign(1, popov.theta or 0)) if endless else Fraction(popov.theta or 0)
        return Best(to_fmpq(theta), fmpq(0), fmpq(0), growing="theta" if endless else "")
    if inequality.family.U[0] >= 0:
        ratio = _steep(inequality.family).everywhere([])
        if ratio is not None:
            return Best(ratio, fmpq(1), fmpq(0), growing="tau")
    return best_pair(inequality.family, _time_scale(inequality) ** 2, inequality.level_of_a_double)


def _steep(family: PolynomialFamily) -> PolynomialFamily:
    """``U + r W/x``: if that is nonnegative, ``theta = r tau`` serves every finite ``k`` for ``tau`` large enough."""
    return PolynomialFamily(family.D, family.U, family.W // X)


def _time_scale(inequality: PopovInequality) -> fmpq:
    """A typical time constant: the geometric mean."""
    d = inequality.family.D
    ratio = abs(float(to_fraction(d[0]))), abs(float(to_fraction(d[d.degree()])))
    if d.degree() < 1 or not all(0 < value < math.inf for value in ratio):
        return fmpq(1)
    mean = (ratio[0] / ratio[1]) ** (-0.5 / d.degree())
    return to_fmpq(Fraction(mean).limit_denominator(10**6) or Fraction(mean))


def _pair(inequality: PopovInequality, best: Best, upper: Fraction) -> tuple[fmpq, fmpq]:
    """A multiplier for finite bounds."""
    if best.theta is None:
        return fmpq(0), fmpq(0)
    if best.growing == "theta":
        return to_fmpq(inequality.serving(Reach(math.copysign(math.inf, best.theta)), upper)), fmpq(0)
    if not best.growing:
        return best.theta, best.tau
    level = -1 / to_fmpq(upper - inequality.lower)
    tau = _time_scale(inequality) ** 2
    for _ in range(200):
        if inequality.family.stretched(tau).exceeds(best.theta * tau, level):
            break
        tau *= 16
    return best.theta * tau, tau


def _largest(inequality: PopovInequality, best: Best) -> Bracket:
    if best.theta is not None and best.level == 0:
        return Bracket(math.inf, math.inf)
    top = best.unreachable
    high = double_above(inequality.lower - 1 / to_fraction(top)) if top is not None and top < 0 else math.inf
    if best.theta is None:
        return Bracket(double_below(inequality.lower), high)
    return Bracket(double_below(inequality.lower - 1 / to_fraction(best.level)), high)


def _parameters(best: Best) -> MappingProxyType[str, object]:
    if best.theta is None:
        return MappingProxyType({})
    if best.growing == "tau":
        return MappingProxyType({"theta/tau": str(best.theta), "tau": "inf"})
    if best.growing == "theta":
        return MappingProxyType({"theta": "inf" if best.theta > 0 else "-inf", "tau": "0"})
    return MappingProxyType({"theta": str(best.theta), "tau": str(best.tau)})


def _hypotheses(inequality: PopovInequality, *, holds: bool) -> tuple[str, ...]:
    return (
        "all poles in the open left half-plane, hidden modes too: checked by an exact count",
        f"inequality on [0, inf], limit included: {'holds, by an exact root count' if holds else 'not established'}",
        "1 + k H(inf) > 0: checked" if inequality.direct != 0 else "no direct term: checked",
        "phi time-invariant with slope within the bounds, phi(0) = 0: assumed of the class; it need not be odd",
    )
