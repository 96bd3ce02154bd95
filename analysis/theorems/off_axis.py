"""The off-axis circle criterion of Cho and Narendra, for laws of restricted slope."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from types import MappingProxyType

from flint import fmpq_poly

from lure.analysis.inequality.checks import finite_bounds, require_well_posed
from lure.analysis.inequality.polynomial import CONCLUSION, PolynomialFamily, PopovInequality, Reach, least_value
from lure.analysis.numerics.doubles import text_above, text_below
from lure.analysis.numerics.polynomial import X, to_fraction
from lure.analysis.verdict import Answer, Bracket, Evidence, Verdict
from lure.classes import NonlinearityClass, SlopeBounds
from lure.errors import InputError
from lure.plants.rational import RationalPlant

NAME = "the off-axis circle criterion"
THEOREM = (
    "off-axis circle criterion; Y.-S. Cho and K. S. Narendra, IEEE Trans. Automatic Control 13 (1968) 413-416; through "
    "multipliers of G. Zames and P. L. Falb, SIAM J. Control 6 (1968) 89-108"
)
FORMULA = "1 + i alpha for omega > 0"


def off_axis_largest(block: RationalPlant, *, lower: Fraction = Fraction(0)) -> Answer:
    r"""The largest ``k`` such that a line through ``-1/k`` has the Nyquist plot for ``omega >= 0`` on its right.

    For ``mu = -phi(sigma)``, ``sigma = H mu``, ``H`` stable and ``lower = 0`` it asks for a real ``alpha`` with

    .. math:: \mathrm{Re}[(1 + i\alpha)(H(i\omega) + 1/k)] > 0, \quad 0 \le \omega \le \infty,

    both ends included: ``H(0) + 1/k > 0`` and ``H(\infty) + 1/k > 0``.  Then 0 is globally asymptotically stable for
    every time-invariant ``phi`` with ``phi(0) = 0`` and slope in ``[lower, k]``, odd or not.  For ``alpha = 0`` it
    is the circle criterion.

    Parameters
    ----------
    block : RationalPlant
        A continuous-time block; hidden modes must be stable.
    lower : Fraction
        Lower slope bound; the loop is shifted by it first.

    Returns
    -------
    Answer
        ``largest``: both ends certified, as by :func:`lure.analysis.theorems.popov.popov_largest`, here with
        polynomials in
        ``omega``.  ``parameters``: ``alpha``; infinite where each finite ``k`` needs a larger one.

    Raises
    ------
    AssumptionError
        The block is in discrete time (no constant phase is available there), or the shifted block is not stable.
    InputError
        ``1 + lower H(inf) = 0``.

    Notes
    -----
    Why slopes suffice: near 0 and infinity ``G = H + 1/k`` is close to a positive number, and every phase from 0 to
    that of ``1 + i alpha`` keeps ``Re > 0``; in between products of ``(s + z_i)/(s + p_i)``, ``z_i < p_i < z_{i+1}`` in
    geometric progression, approach that phase, uniformly, and nowhere exceed it by more than their ripple.  Such a
    product is ``c + sum g_i s/(s + p_i)`` with ``c, g_i > 0``, a Zames-Falb multiplier ``1 - z`` with ``z >= 0``; for
    ``alpha < 0`` take its conjugate, which is anticausal.

    Examples
    --------
    >>> off_axis_largest(RationalPlant([1], [1, 3, 3, 1])).largest.low
    8.0
    """
    inequality = _inequality(block, Fraction(lower))
    best = inequality.reach()
    largest = inequality.largest(best)
    proved = best.theta is not None and largest.low > inequality.lower
    said = (
        "every finite k is proved"
        if best.found is None
        else f"every k up to {text_below(largest.low, 15)} is proved, and no straight line reaches "
        f"{text_above(largest.high, 15)}"
    )
    return Answer(
        criterion="off-axis-circle",
        theorem=THEOREM,
        largest=largest,
        law_class=NonlinearityClass.slope_restricted(inequality.lower, largest.low if proved else math.inf),
        verdict=Verdict.PROVED if proved else Verdict.INCONCLUSIVE,
        evidence=Evidence.CERTIFIED,
        needs=("slope", "time-invariant"),
        multiplier=FORMULA,
        parameters=MappingProxyType({} if best.theta is None else {"alpha": str(best.theta)}),
        worst_frequency=_worst(best),
        hypotheses=_hypotheses(inequality, holds=proved),
        reason=f"{said}; {CONCLUSION}" if proved else "no k that a double can state was reached",
    )


def off_axis_criterion(block: RationalPlant, bounds: SlopeBounds, *, alpha: Fraction | None = None) -> Answer:
    r"""The criterion for given slope bounds, certified over all frequencies.

    Parameters
    ----------
    block : RationalPlant
        See :func:`off_axis_largest`.
    bounds : SlopeBounds
        Finite slope bounds.
    alpha : Fraction, optional
        The multiplier is ``1 + i alpha``, of either sign; by default the best one.

    Returns
    -------
    Answer
        PROVED or INCONCLUSIVE; ``margin`` is the infimum over frequency of the left-hand side.

    Raises
    ------
    AssumptionError
        As :func:`off_axis_largest`; a bound is infinite.
    InputError
        ``alpha`` is not finite, or ``1 + k H(inf) = 0`` for some ``k`` within the bounds.
    """
    lower, upper = finite_bounds(bounds, NAME)
    if alpha is not None and not math.isfinite(alpha):
        raise InputError(f"alpha is {alpha}; give a finite number, or None for the best one")
    inequality = _inequality(block, lower)
    require_well_posed(block, upper, lower=lower)
    best = inequality.reach()
    used = inequality.serving(best, upper) if alpha is None else Fraction(alpha)
    holds = inequality.holds(used, upper)
    least = least_value(inequality.family, used)
    margin = least.bracket(1 / (upper - lower))
    if holds:
        margin = Bracket(max(margin.low, 0.0), margin.high)
    said = (
        f"the inequality holds at every frequency, the margin is {margin}; {CONCLUSION}"
        if holds
        else "the inequality fails with this line, from which nothing follows for the loop; with the best one the "
        f"largest k is {inequality.largest(best)}"
    )
    return Answer(
        criterion="off-axis-circle",
        theorem=THEOREM,
        largest=inequality.largest(best),
        law_class=NonlinearityClass.slope_restricted(bounds.lower, bounds.upper),
        verdict=Verdict.PROVED if holds else Verdict.INCONCLUSIVE,
        evidence=Evidence.CERTIFIED,
        needs=("slope", "time-invariant"),
        multiplier=FORMULA,
        parameters=MappingProxyType({"alpha": str(used)}),
        margin=margin,
        worst_frequency=math.inf if least.x is None else float(least.x),
        hypotheses=_hypotheses(inequality, holds=holds),
        reason=said,
    )


def _inequality(block: RationalPlant, lower: Fraction) -> PopovInequality:
    """The inequality with ``-Im H`` in the place of ``-omega Im H`` and ``omega`` in that of ``x``."""
    inequality = PopovInequality.of_stable(block, lower, NAME)
    found = inequality.family
    family = PolynomialFamily(_of_square(found.D), _of_square(found.U), X * _of_square(found.W // X))
    return replace(inequality, family=family)


def _of_square(p: fmpq_poly) -> fmpq_poly:
    """``p(t^2)``."""
    return p(X * X)


def _worst(best: Reach) -> float | None:
    if best.found is None:
        return None
    x = best.found.upper_bound.support[0].x
    return math.inf if x is None else float(to_fraction(x))


def _hypotheses(inequality: PopovInequality, *, holds: bool) -> tuple[str, ...]:
    return (
        "all poles in the open left half-plane, hidden modes too: checked by an exact count",
        f"inequality on [0, inf], ends included: {'holds, by an exact root count' if holds else 'not established'}",
        "1 + k H(inf) > 0: checked" if inequality.direct != 0 else "no direct term: checked",
        "phi time-invariant with slope within the bounds, phi(0) = 0: assumed of the class; it need not be odd",
    )
