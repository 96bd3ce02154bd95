"""Popov's criterion: the largest sector with the best multiplier, and one given sector."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from typing import Literal

from flint import fmpq

from lure.analysis.inequality.polynomial import RationalInequality
from lure.analysis.inequality.protocol import Multiplier
from lure.analysis.numerics.polynomial import positive_from_zero, to_fmpq
from lure.analysis.theorems.criterion import Criterion, sector_class
from lure.analysis.verdict import CriterionResult
from lure.classes import Sector
from lure.errors import InputError
from lure.plants.rational import RationalPlant

NAME = "Popov's criterion"


def popov_largest(
    block: RationalPlant, *, lower: Fraction = Fraction(0), sign: Literal["both", "nonnegative"] = "both"
) -> CriterionResult:
    r"""The largest ``k`` for which Popov's inequality holds on the sector ``[lower, k]``, with the best multiplier.

    For ``mu = -phi(sigma)``, ``sigma = H mu`` and ``lower = 0`` the inequality is

    .. math:: 1/k + \mathrm{Re}[(1 + i\omega\theta) H(i\omega)] > 0, \quad 0 \le \omega \le \infty,

    limits included.  It makes 0 globally asymptotically stable for every time-invariant locally Lipschitz ``phi`` in
    the sector if ``H`` is stable.  In the critical case (one simple pole at 0, residue positive) every solution is
    bounded and converges to a point of the stationary set: asymptotic stability of 0 only if ``phi`` vanishes at 0
    alone.  No multiplier reaches ``largest.high``, from which nothing follows for the loop.

    Parameters
    ----------
    block : RationalPlant
        A continuous-time block; hidden modes must be stable.
    lower : Fraction
        Lower end of the sector; the loop is shifted by it first.
    sign : {"both", "nonnegative"}
        Whether negative ``theta`` is admitted; it is legal for every finite ``k``.

    Returns
    -------
    CriterionResult
        ``largest.low``: certified by an exact root count of one polynomial in ``x = omega^2``; ``largest.high``: by the
        values at one or two rational ``x``, ``parameters["points"]``, exactly.  ``theta`` [s] belongs to
        ``largest.low``; it is infinite where each finite ``k`` needs a larger one.

    Raises
    ------
    AssumptionError
        The block is in discrete time, or the shifted block is neither stable nor critical.
    InputError
        ``1 + lower H(inf) = 0``.

    Notes
    -----
    Cutting planes on a concave function of ``theta``, see :mod:`lure.analysis.inequality.multiplier_search`; no grid.
    With a direct term ``D`` the theorem is applied to ``H - D`` and the sector ``[0, k/(1 + k D)]``: the inequality is
    the same, ``1 + k D > 0`` is required, and the composed nonlinearity must be a function (see ``hypotheses``).
    Negative ``theta`` is proved legal in ``notebooks/notes/0006-negative-theta.md``.

    Examples
    --------
    >>> answer = popov_largest(RationalPlant([1], [1, 3, 2, 0]))
    >>> answer.largest.low, answer.theta
    (6.0, 1.5)
    """
    inequality = _inequality(block, Fraction(lower))
    return POPOV.answer(replace(inequality, nonnegative=sign == "nonnegative"))


def popov_criterion(block: RationalPlant, sector: Sector, *, theta: float | Fraction | None = None) -> CriterionResult:
    r"""Popov's inequality for one sector ``[lower, upper]``, certified over all frequencies.

    Parameters
    ----------
    block : RationalPlant
        As for :func:`popov_largest`.
    sector : Sector
        ``lower`` finite.  ``upper = inf`` asks about every ``phi`` above the line of slope ``lower``, bounded by no
        gain; it needs ``Re[..] >= eps/(1 + omega^2)`` with ``theta >= 0`` and no hidden modes, or ``H(inf) > 0``.
    theta : float or Fraction, optional
        Multiplier [s], of either sign; a float means the double it is.  By default the best one.

    Returns
    -------
    CriterionResult
        PROVED or INCONCLUSIVE; ``margin`` is the infimum over frequency of the left-hand side, limits included.

    Raises
    ------
    AssumptionError
        As :func:`popov_largest`; ``lower`` is infinite.
    InputError
        ``theta`` is not finite, or ``1 + k H(inf) = 0`` for some ``k`` in the sector.

    Examples
    --------
    >>> print(popov_criterion(RationalPlant([1], [1, 3, 2, 0]), Sector(0, 5)).verdict)
    PROVED
    """
    if theta is not None and not math.isfinite(theta):
        raise InputError(f"theta is {theta}; give a finite number of seconds, or None for the best one")
    given = None if theta is None else {"theta": Fraction(theta)}
    return POPOV.decide(block, sector, multiplier=given)


def _inequality(block: RationalPlant, lower: Fraction) -> RationalInequality:
    return RationalInequality.of(block, lower, NAME, critical=True)


def _endless(base: RationalInequality, multiplier: Multiplier) -> bool:
    """Whether a multiplier serves the nonlinearities that no gain bounds.

    Either ``1 + theta s`` serves ``H - D`` and the finite sector ``[0, 1/D]``, or ``D = 0``, ``theta >= 0``,
    ``Re[..] >= eps/(1 + omega^2)``, and no mode is hidden.
    """
    theta, family = to_fmpq(multiplier["theta"]), base.family
    if base.direct > 0:
        return family.exceeds(theta, fmpq(0))
    if theta < 0 or base.direct < 0 or base.plant.hidden.degree() > 0:
        return False
    least = family.level(theta, fmpq(0))
    return positive_from_zero(least) and least.degree() >= family.D.degree() - 1


POPOV = Criterion(
    name="popov",
    title=NAME,
    theorem="Popov's criterion, theta of either sign: V. M. Popov, Automation and Remote Control 22 (1961) 857-875; "
    "M. A. Aizerman and F. R. Gantmacher, Absolute Stability of Regulator Systems, Holden-Day, 1964",
    formula="1 + theta s",
    inequality=_inequality,
    nonlinearities=sector_class,
    assumed="phi time-invariant, locally Lipschitz, in the sector: assumed of the class",
    needs=("time-invariant",),
    composed=True,
    endless=_endless,
)
