"""Tsypkin's criterion, for odd nonlinearities too, and the Jury-Lee criterion: discrete time, one difference."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import partial

from flint import fmpq_poly

from lure.analysis.inequality.polynomial import LossyInequality, PolynomialFamily, RationalInequality
from lure.analysis.numerics.polynomial import X, even_odd
from lure.analysis.theorems.criterion import Bound, Criterion
from lure.analysis.verdict import CriterionResult
from lure.classes import NonlinearityClass, Sector, SlopeBounds
from lure.plants.rational import RationalPlant

# With ``z = (1 + i v)/(1 - i v)``, ``x = v^2`` and ``Re H = U/D``, ``-v Im H = W/D``, the parts that ``q`` multiplies:
#
# ``Re[(1 - z^-1) H] = 2 (x U + W)/(D (1 + x))``, ``Re[(1 + z^-1) H] = 2 (U - W)/(D (1 + x))``,
# ``Re[(z - 1) H] = 2 (W - x U)/(D (1 + x))``, and ``|(z - 1) H|^2 = 4 x |n|^2/(D (1 + x))``.

ASSUMED = "{class}, time-invariant, continuous where H(inf) is not 0: assumed"
STRETCH = 1 + X


def _weighted(
    block: RationalPlant,
    lower: Fraction,
    *,
    criterion: str,
    difference: Callable[[fmpq_poly, fmpq_poly], fmpq_poly],
) -> RationalInequality:
    """``1/k + Re[(1 + q Z) H] > 0`` on the circle, given ``D (1 + x) Re[Z H]/2`` from ``U`` and ``W``."""
    found = RationalInequality.of(block, lower, criterion, discrete=True, critical=True)
    D, U, W = found.family.D, found.family.U, found.family.W
    family = PolynomialFamily(STRETCH * D, STRETCH * U, 2 * difference(U, W))
    return replace(found, family=family, weight="q", nonnegative=True)


def _monotone(lower: Bound, upper: Bound, direct: Fraction, *, odd: bool = False) -> NonlinearityClass:
    """Monotone is enough, unless the algebraic loop needs a bound on the slope from above."""
    slope = SlopeBounds(lower, upper if direct < 0 else math.inf)
    return NonlinearityClass(sector=Sector(lower, upper), slope=slope, odd=odd)


TSYPKIN = Criterion(
    name="tsypkin",
    title="Tsypkin's criterion",
    theorem="Tsypkin's criterion (Ya. Z. Tsypkin, Soviet Physics Doklady 9 (1964) 263-266; with a Lyapunov function: "
    "V. Kapila, W. M. Haddad, IEEE Trans. Automatic Control 41 (1996) 149-152)",
    formula="1/k + Re[(1 + q (1 - z^-1)) H(z)] > 0",
    inequality=partial(_weighted, criterion="Tsypkin's criterion", difference=lambda U, W: X * U + W),
    nonlinearities=_monotone,
    assumed=ASSUMED,
    kind="weight q",
)


def tsypkin_largest(block: RationalPlant, *, lower: Fraction = Fraction(0)) -> CriterionResult:
    r"""Largest sector that Tsypkin's criterion proves for monotone nonlinearities.

    In ``sigma = H mu``, ``mu = -phi(sigma)`` the origin is globally asymptotically stable for every time-invariant
    nondecreasing ``phi`` in the sector ``[0, k]`` if ``H`` is stable and for some ``q >= 0``

    .. math:: 1/k + \mathrm{Re}\,[(1 + q\,(1 - z^{-1}))\, H(z)] > 0 \quad (|z| = 1).

    The slope of ``phi`` may exceed ``k``; only where the feedthrough ``D`` is negative is it bounded by ``k`` here, for
    the algebraic loop to have a solution.  With another ``lower`` the criterion is that of ``H/(1 + lower H)``,
    ``phi - lower sigma`` and ``k - lower``.

    Parameters
    ----------
    block : RationalPlant
        In discrete time, with the gain ``lower`` stable, hidden modes included.
    lower : Fraction
        Lower end of the sector and of the slope.

    Returns
    -------
    CriterionResult
        ``largest``: both ends decided exactly; at ``high`` no ``q >= 0`` is left.  Nothing follows beyond: the
        criterion is sufficient only.

    Raises
    ------
    InputError
        The block is in continuous time.
    AssumptionError
        The block is not stable with the gain ``lower``, but for a simple pole at ``z = 1``: with that, every solution
        converges to a point of the stationary set.

    Notes
    -----
    Why: ``phi(y_t) (y_t - y_{t-1}) >= Phi(y_t) - Phi(y_{t-1})`` for the convex primitive ``Phi >= 0`` of ``phi``.

    Examples
    --------
    >>> block = RationalPlant([Fraction("0.1"), 0], [1, Fraction("-1.8"), Fraction("0.81")], dt=1)
    >>> print(f"{tsypkin_largest(block).largest.low:.6f}")
    3.800000
    """
    return TSYPKIN.largest(block, lower=lower)


TSYPKIN_ODD = Criterion(
    name="tsypkin-odd",
    title="Tsypkin's criterion for odd nonlinearities",
    theorem="Tsypkin's criterion for odd nonlinearities (J. C. Willems, R. W. Brockett, IEEE Trans. Automatic Control "
    "13 (1968) 539-549)",
    formula="1/k + Re[(1 + q (1 + z^-1)) H(z)] > 0",
    inequality=partial(
        _weighted, criterion="Tsypkin's criterion for odd nonlinearities", difference=lambda U, W: U - W
    ),
    nonlinearities=partial(_monotone, odd=True),
    assumed=ASSUMED,
    kind="weight q",
    needs=("slope", "odd", "time-invariant"),
)


def tsypkin_odd_largest(block: RationalPlant, *, lower: Fraction = Fraction(0)) -> CriterionResult:
    r"""Largest sector that Tsypkin's criterion, with the sum of successive samples, proves for odd monotone ``phi``.

    In ``sigma = H mu``, ``mu = -phi(sigma)`` the origin is globally asymptotically stable for every time-invariant odd
    nondecreasing ``phi`` in the sector ``[0, k]`` if ``H`` is stable and for some ``q >= 0``

    .. math:: 1/k + \mathrm{Re}\,[(1 + q\,(1 + z^{-1}))\, H(z)] > 0 \quad (|z| = 1).

    Hypotheses on the slope, on the feedthrough and on ``lower`` are those of :func:`tsypkin_largest`.

    Parameters
    ----------
    block : RationalPlant
        In discrete time, with the gain ``lower`` stable, hidden modes included.
    lower : Fraction
        Lower end of the sector and of the slope.

    Returns
    -------
    CriterionResult
        ``largest``: both ends decided exactly; at ``high`` no ``q >= 0`` is left.  Nothing follows beyond, and nothing
        for nonlinearities that are not odd: the criterion is sufficient only.

    Raises
    ------
    InputError
        The block is in continuous time.
    AssumptionError
        The block is not stable with the gain ``lower``, but for a simple pole at ``z = 1``: with that, every solution
        converges to a point of the stationary set.

    Notes
    -----
    Why: the convex primitive ``Phi >= 0`` of an odd ``phi`` is even, so that ``phi(y_t) (y_t + y_{t-1}) >= Phi(y_t) -
    Phi(-y_{t-1}) = Phi(y_t) - Phi(y_{t-1})``.  It is Tsypkin's criterion for ``H(-z)``: ``y_t -> (-1)^t y_t`` maps odd
    nonlinearities to themselves.

    Examples
    --------
    ``H(-z)`` of the example of :func:`tsypkin_largest`.

    >>> block = RationalPlant([Fraction("-0.1"), 0], [1, Fraction("1.8"), Fraction("0.81")], dt=1)
    >>> print(f"{tsypkin_odd_largest(block).largest.low:.6f}")
    3.800000
    """
    return TSYPKIN_ODD.largest(block, lower=lower)


def _ahead(block: RationalPlant, lower: Fraction) -> LossyInequality:
    """``1/k + Re[(1 + q (z - 1)) H] - (q k/2) |(z - 1) H|^2 > 0`` on the circle."""
    base = _weighted(block, lower, criterion=JURY_LEE.title, difference=lambda U, W: W - X * U)
    even, odd = even_odd(base.plant.visible.n)
    loss = 2 * (even * even + X * odd * odd)  # times x, which D has been divided by where it has its root z = 1
    return LossyInequality(base=base, loss=loss if base.grounds.critical else X * loss)


def _not_too_steep(lower: Bound, upper: Bound, direct: Fraction) -> NonlinearityClass:
    """A bound from above is enough, unless the algebraic loop needs one from below."""
    slope = SlopeBounds(lower if direct > 0 else -math.inf, upper)
    return NonlinearityClass(sector=Sector(lower, upper), slope=slope)


JURY_LEE = Criterion(
    name="jury-lee",
    title="the Jury-Lee criterion",
    theorem="The Jury-Lee criterion (E. I. Jury, B. W. Lee, IEEE Trans. Automatic Control 9 (1964) 51-61)",
    formula="1/k + Re[(1 + q (z - 1)) H(z)] - (q k/2) |(z - 1) H(z)|^2 > 0",
    inequality=_ahead,
    nonlinearities=_not_too_steep,
    assumed=ASSUMED,
    kind="weight q",
)


def jury_lee_largest(block: RationalPlant, *, lower: Fraction = Fraction(0)) -> CriterionResult:
    r"""Largest sector that the Jury-Lee criterion proves for nonlinearities of slope at most ``k``.

    In ``sigma = H mu``, ``mu = -phi(sigma)`` the origin is globally asymptotically stable for every time-invariant
    ``phi`` in the sector ``[0, k]`` with ``(phi(x) - phi(y))/(x - y) <= k`` if ``H`` is stable and for some ``q >= 0``

    .. math:: 1/k + \mathrm{Re}\,[(1 + q\,(z - 1))\, H(z)] - \tfrac12 q k\, |(z - 1) H(z)|^2 > 0 \quad (|z| = 1).

    ``phi`` need not be monotone; only where the feedthrough ``D`` is positive is its slope bounded from below by
    ``lower`` here, for the algebraic loop to have a solution.  With another ``lower`` the criterion is that of
    ``H/(1 + lower H)``, ``phi - lower sigma`` and ``k - lower``.

    Parameters
    ----------
    block : RationalPlant
        In discrete time, with the gain ``lower`` stable, hidden modes included.
    lower : Fraction
        Lower end of the sector.

    Returns
    -------
    CriterionResult
        ``largest``: both ends decided exactly; at ``high`` no ``q >= 0`` is left.  Nothing follows beyond: the
        criterion is sufficient only.

    Raises
    ------
    InputError
        The block is in continuous time.
    AssumptionError
        The block is not stable with the gain ``lower``, but for a simple pole at ``z = 1``: with that, every solution
        converges to a point of the stationary set.

    Notes
    -----
    Why: ``phi(y_t) (y_{t+1} - y_t) + (k/2) (y_{t+1} - y_t)^2 >= Phi(y_{t+1}) - Phi(y_t)`` for the primitive
    ``Phi >= 0`` of a ``phi`` with slope at most ``k``.

    Examples
    --------
    For ``H = (2 z + 0.92)/(z^2 - 0.5 z)`` it reaches 0.684932, the circle criterion 0.651041.

    >>> block = RationalPlant([2, Fraction("0.92")], [1, Fraction("-0.5"), 0], dt=1)
    >>> print(f"{jury_lee_largest(block).largest.low:.6f}")
    0.684932
    """
    return JURY_LEE.largest(block, lower=lower)
