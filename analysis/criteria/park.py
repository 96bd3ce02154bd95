"""The criterion of Yakubovich and Park for laws of restricted slope."""

from __future__ import annotations

import math
from fractions import Fraction
from types import MappingProxyType

from flint import fmpq

from analysis.answer import Answer
from analysis.criteria.checks import finite_bounds, require_well_posed
from analysis.criteria.park_search import Best, best_pair
from analysis.criteria.popov_inequality import CONCLUSION, PopovInequality, Reach
from analysis.doubles import double_above, double_below, text_above, text_below
from analysis.evidence import Bracket, Evidence, Verdict
from analysis.least_value import least_value
from analysis.polynomial import X, to_fmpq, to_fraction
from analysis.polynomial_family import PolynomialFamily
from lure.errors import InputError
from lure.law_class import LawClass
from lure.rational import RationalBlock
from lure.sector import SlopeBounds

NAME = "Park's criterion"
THEOREM = (
    "Yakubovich's criterion for restricted slope, found again by P. Park, IEEE Trans. Automatic Control 47 (2002) "
    "308-313; by J. Carrasco, W. P. Heath, A. Lanzon, Automatica 49 (2013) 1732-1740, a case of the theorem of "
    "G. Zames and P. L. Falb, SIAM J. Control 6 (1968) 89-108"
)
FORMULA = "1 + theta s - tau s^2"


def park_largest(block: RationalBlock, *, lower: Fraction = Fraction(0)) -> Answer:
    r"""The largest ``k`` for which the criterion proves the slope bounds ``[lower, k]``, with the best multiplier.

    For ``mu = -phi(sigma)``, ``sigma = H mu``, ``H`` stable and ``lower = 0`` it asks for ``tau >= 0`` and a real
    ``theta`` with

    .. math:: \mathrm{Re}[(1 + \tau\omega^2 + i\omega\theta)(H(i\omega) + 1/k)] > 0, \quad 0 \le \omega < \infty,

    the limit of the left-hand side over ``1 + tau omega^2`` positive, and ``1 + k H(inf) > 0`` (a condition of its own
    for ``tau = 0``).  Then 0 is globally asymptotically stable for every time-invariant ``phi`` with ``phi(0) = 0`` and
    slope in ``[lower, k]``, odd or not; for ``tau = 0`` it is Popov's criterion.

    Parameters
    ----------
    block : RationalBlock
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
    >>> park_largest(RationalBlock([1, 0, 0], [1, Fraction("0.2"), 6, Fraction("0.1"), 1])).largest.low
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
        law_class=LawClass.slope_restricted(inequality.lower, largest.low if proved else math.inf),
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
    block: RationalBlock, bounds: SlopeBounds, *, theta: Fraction | None = None, tau: Fraction | None = None
) -> Answer:
    r"""The criterion for given slope bounds, certified over all frequencies.

    Parameters
    ----------
    block : RationalBlock
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
        law_class=LawClass.slope_restricted(bounds.lower, bounds.upper),
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
