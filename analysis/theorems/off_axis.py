"""The off-axis circle criterion of Cho and Narendra, for nonlinearities of restricted slope."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

from lure.analysis.inequality.polynomial import PolynomialFamily, RationalInequality
from lure.analysis.numerics.polynomial import X
from lure.analysis.theorems.criterion import Criterion
from lure.analysis.verdict import CriterionResult
from lure.classes import SlopeBounds
from lure.errors import InputError
from lure.plants.rational import RationalPlant

NAME = "the off-axis circle criterion"


def off_axis_largest(block: RationalPlant, *, lower: Fraction = Fraction(0)) -> CriterionResult:
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
    CriterionResult
        ``largest``: both ends certified, as by :func:`lure.analysis.theorems.popov.popov_largest`, here with
        polynomials in
        ``omega``.  ``parameters``: ``alpha``; infinite where each finite ``k`` needs a larger one.

    Raises
    ------
    AssumptionError
        The block is in discrete time (no constant phase is available there), or the shifted block is not stable but
        for a simple pole at 0, with which ``alpha > 0`` and every solution converges to a point of the stationary set.
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
    return OFF_AXIS.largest(block, lower=lower)


def off_axis_criterion(block: RationalPlant, bounds: SlopeBounds, *, alpha: Fraction | None = None) -> CriterionResult:
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
    CriterionResult
        PROVED or INCONCLUSIVE; ``margin`` is the infimum over frequency of the left-hand side.

    Raises
    ------
    AssumptionError
        As :func:`off_axis_largest`; a bound is infinite.
    InputError
        ``alpha`` is not finite, or ``1 + k H(inf) = 0`` for some ``k`` within the bounds.
    """
    if alpha is not None and not math.isfinite(alpha):
        raise InputError(f"alpha is {alpha}; give a finite number, or None for the best one")
    given = None if alpha is None else {"alpha": Fraction(alpha)}
    return OFF_AXIS.decide(block, bounds, multiplier=given)


def _inequality(block: RationalPlant, lower: Fraction) -> RationalInequality:
    """The inequality with ``-Im H`` in the place of ``-omega Im H`` and ``omega`` in that of ``x``."""
    found = RationalInequality.of(block, lower, NAME, critical=True)
    D, U, W = (p(X * X) for p in (found.family.D, found.family.U, found.family.W))
    if found.grounds.critical:  # over omega, since -Im H grows like the residue over omega
        family = PolynomialFamily(X * D, X * U, W)
        return replace(found, family=family, weight="alpha", squared=False, nonnegative=True)
    return replace(found, family=PolynomialFamily(D, U, W // X), weight="alpha", squared=False)


OFF_AXIS = Criterion(
    name="off-axis-circle",
    title=NAME,
    theorem="off-axis circle criterion; Y.-S. Cho and K. S. Narendra, IEEE Trans. Automatic Control 13 (1968) 413-416; "
    "through multipliers of G. Zames and P. L. Falb, SIAM J. Control 6 (1968) 89-108",
    formula="1 + i alpha for omega > 0",
    inequality=_inequality,
    kind="straight line",
)
