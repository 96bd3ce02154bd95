"""Tsypkin's criterion: discrete time, a monotone law in a sector, one causal difference."""

from __future__ import annotations

import math
from fractions import Fraction

from flint import fmpq_poly

from analysis.answer import Answer
from analysis.criteria.difference_answers import Bound, Form, class_answer, largest_answer
from analysis.trigonometric import Laurent
from lure.rational import RationalBlock
from lure.sector import SlopeBounds


def _slopes(lower: Bound, upper: Bound, feedthrough: Fraction) -> SlopeBounds:
    """Monotone is enough, unless the algebraic loop needs a bound on the slope from above."""
    return SlopeBounds(lower, upper if feedthrough < 0 else math.inf)


TSYPKIN = Form(
    name="tsypkin",
    theorem="Tsypkin's criterion (Ya. Z. Tsypkin, Soviet Physics Doklady 9 (1964) 263-266; with a Lyapunov function: "
    "V. Kapila, W. M. Haddad, IEEE Trans. Automatic Control 41 (1996) 149-152)",
    formula="1/k + Re[(1 + q (1 - z^-1)) H(z)] > 0",
    difference=Laurent(fmpq_poly([-1, 1]), 1),
    loss=Fraction(0),
    slopes=_slopes,
)


def tsypkin_largest(block: RationalBlock, *, lower: Fraction = Fraction(0)) -> Answer:
    r"""Largest sector that Tsypkin's criterion proves for monotone laws.

    In ``sigma = H mu``, ``mu = -phi(sigma)`` the origin is globally asymptotically stable for every time-invariant
    nondecreasing ``phi`` in the sector ``[0, k]`` if ``H`` is stable and for some ``q >= 0``

    .. math:: 1/k + \mathrm{Re}\,[(1 + q\,(1 - z^{-1}))\, H(z)] > 0 \quad (|z| = 1).

    The slope of ``phi`` may exceed ``k``; only where the feedthrough ``D`` is negative is it bounded by ``k`` here, for
    the algebraic loop to have a solution.  With another ``lower`` the criterion is that of ``H/(1 + lower H)``,
    ``phi - lower sigma`` and ``k - lower``.

    Parameters
    ----------
    block : RationalBlock
        In discrete time, with the gain ``lower`` stable, hidden modes included.
    lower : Fraction
        Lower end of the sector and of the slope.

    Returns
    -------
    Answer
        ``largest``: both ends decided exactly; at ``high`` no ``q >= 0`` is left.  Nothing follows beyond: the
        criterion is sufficient only.

    Raises
    ------
    InputError
        The block is in continuous time.
    AssumptionError
        The block is not stable with the gain ``lower``.

    Notes
    -----
    Why: ``phi(y_t) (y_t - y_{t-1}) >= Phi(y_t) - Phi(y_{t-1})`` for the convex primitive ``Phi >= 0`` of ``phi``.

    Examples
    --------
    >>> block = RationalBlock([Fraction("0.1"), 0], [1, Fraction("-1.8"), Fraction("0.81")], dt=1)
    >>> print(f"{tsypkin_largest(block).largest.low:.6f}")
    3.800000
    """
    return largest_answer(block, TSYPKIN, lower=lower)


def tsypkin_criterion(block: RationalBlock, bounds: SlopeBounds) -> Answer:
    """Whether Tsypkin's criterion proves the laws of slope at least ``bounds.lower`` in the sector of both bounds.

    Parameters
    ----------
    block : RationalBlock
        In discrete time, with the gain ``bounds.lower`` stable, hidden modes included.
    bounds : SlopeBounds
        Finite bounds; see :func:`tsypkin_largest` for the class.

    Returns
    -------
    Answer
        PROVED, or INCONCLUSIVE, which says nothing about the loop.
    """
    return class_answer(block, TSYPKIN, bounds)
