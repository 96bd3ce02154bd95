"""The Jury-Lee criterion: discrete time, a law in a sector with slope bounded from above, one difference ahead."""

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
    """A bound from above is enough, unless the algebraic loop needs one from below."""
    return SlopeBounds(lower if feedthrough > 0 else -math.inf, upper)


JURY_LEE = Form(
    name="jury-lee",
    theorem="The Jury-Lee criterion (E. I. Jury, B. W. Lee, IEEE Trans. Automatic Control 9 (1964) 51-61)",
    formula="1/k + Re[(1 + q (z - 1)) H(z)] - (q k/2) |(z - 1) H(z)|^2 > 0",
    difference=Laurent(fmpq_poly([-1, 1])),
    loss=Fraction(1, 2),
    slopes=_slopes,
)


def jury_lee_largest(block: RationalBlock, *, lower: Fraction = Fraction(0)) -> Answer:
    r"""Largest sector that the Jury-Lee criterion proves for laws of slope at most ``k``.

    In ``sigma = H mu``, ``mu = -phi(sigma)`` the origin is globally asymptotically stable for every time-invariant
    ``phi`` in the sector ``[0, k]`` with ``(phi(x) - phi(y))/(x - y) <= k`` if ``H`` is stable and for some ``q >= 0``

    .. math:: 1/k + \mathrm{Re}\,[(1 + q\,(z - 1))\, H(z)] - \tfrac12 q k\, |(z - 1) H(z)|^2 > 0 \quad (|z| = 1).

    ``phi`` need not be monotone; only where the feedthrough ``D`` is positive is its slope bounded from below by
    ``lower`` here, for the algebraic loop to have a solution.  With another ``lower`` the criterion is that of
    ``H/(1 + lower H)``, ``phi - lower sigma`` and ``k - lower``.

    Parameters
    ----------
    block : RationalBlock
        In discrete time, with the gain ``lower`` stable, hidden modes included.
    lower : Fraction
        Lower end of the sector.

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
    Why: ``phi(y_t) (y_{t+1} - y_t) + (k/2) (y_{t+1} - y_t)^2 >= Phi(y_{t+1}) - Phi(y_t)`` for the primitive
    ``Phi >= 0`` of a ``phi`` with slope at most ``k``.

    Examples
    --------
    For ``H = (2 z + 0.92)/(z^2 - 0.5 z)`` it reaches 0.684932, the circle criterion 0.651041.

    >>> block = RationalBlock([2, Fraction("0.92")], [1, Fraction("-0.5"), 0], dt=1)
    >>> print(f"{jury_lee_largest(block).largest.low:.6f}")
    0.684932
    """
    return largest_answer(block, JURY_LEE, lower=lower)


def jury_lee_criterion(block: RationalBlock, bounds: SlopeBounds) -> Answer:
    """Whether the Jury-Lee criterion proves the laws of slope at most ``bounds.upper`` in the sector of both bounds.

    Parameters
    ----------
    block : RationalBlock
        In discrete time, with the gain ``bounds.lower`` stable, hidden modes included.
    bounds : SlopeBounds
        Finite bounds; see :func:`jury_lee_largest` for the class.

    Returns
    -------
    Answer
        PROVED, or INCONCLUSIVE, which says nothing about the loop.
    """
    return class_answer(block, JURY_LEE, bounds)
