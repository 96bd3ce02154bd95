"""Popov's criterion: the largest sector with the best multiplier, and one given sector."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from types import MappingProxyType
from typing import Literal

from lure.analysis.inequality.checks import require_well_posed
from lure.analysis.inequality.polynomial import CONCLUSION, LeastValue, PopovInequality, Reach, least_value
from lure.analysis.numerics.doubles import text_above, text_below
from lure.analysis.numerics.polynomial import to_fraction
from lure.analysis.verdict import Answer, Bracket, Evidence, Verdict
from lure.classes import NonlinearityClass, Sector
from lure.errors import AssumptionError, InputError
from lure.plants.rational import RationalPlant

THEOREM = (
    "Popov's criterion, theta of either sign: V. M. Popov, Automation and Remote Control 22 (1961) 857-875; "
    "M. A. Aizerman and F. R. Gantmacher, Absolute Stability of Regulator Systems, Holden-Day, 1964"
)


def popov_largest(
    block: RationalPlant, *, lower: Fraction = Fraction(0), sign: Literal["both", "nonnegative"] = "both"
) -> Answer:
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
    Answer
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
    the same, ``1 + k D > 0`` is required, and the composed law must be a function (see ``hypotheses``).  Negative
    ``theta`` is proved legal in ``notebooks/notes/0006-negative-theta.md``.

    Examples
    --------
    >>> answer = popov_largest(RationalPlant([1], [1, 3, 2, 0]))
    >>> answer.largest.low, answer.theta
    (6.0, 1.5)
    """
    inequality = PopovInequality.of(block, Fraction(lower))
    return _reach_answer(inequality, inequality.reach(nonnegative=sign == "nonnegative"))


def popov_criterion(block: RationalPlant, sector: Sector, *, theta: float | Fraction | None = None) -> Answer:
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
    Answer
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
    if sector.lower == -math.inf:
        raise AssumptionError("Popov's criterion needs a finite lower end of the sector, and it is -inf; give a number")
    if theta is not None and not math.isfinite(theta):
        raise InputError(f"theta is {theta}; give a finite number of seconds, or None for the best one")
    lower = Fraction(sector.lower)
    inequality = PopovInequality.of(block, lower)
    require_well_posed(block, sector.upper, lower=lower)
    best = inequality.reach()
    used = inequality.serving(best, sector.upper) if theta is None else Fraction(theta)
    return _sector_answer(inequality, sector, used, best)


def _reach_answer(inequality: PopovInequality, best: Reach) -> Answer:
    """The answer about the largest ``k``."""
    largest = inequality.largest(best)
    proved = best.theta is not None and largest.low > inequality.lower
    if best.found is None:
        how = "one theta serves them all" if isinstance(best.theta, Fraction) else "the larger k, the larger |theta|"
        said = f"every finite k is proved, {how}; {_conclusion(inequality)}"
    elif proved:
        said = f"every k up to {text_below(largest.low, 15)} is proved, and no multiplier reaches "
        said += text_above(largest.high, 15)
        said = f"{said}; {_conclusion(inequality)}"
    else:
        said = "no k that a double can state was reached"
    return Answer(
        criterion="popov",
        theorem=THEOREM,
        largest=largest,
        law_class=NonlinearityClass(sector=Sector(inequality.lower, largest.low if proved else math.inf)),
        verdict=Verdict.PROVED if proved else Verdict.INCONCLUSIVE,
        evidence=Evidence.CERTIFIED,
        needs=("time-invariant",),
        theta=None if best.theta is None else float(best.theta),
        multiplier="1 + theta s",
        parameters=_parameters(best.theta, best),
        worst_frequency=None if best.found is None else _worst(best),
        hypotheses=_hypotheses(inequality, holds=proved),
        reason=said,
    )


def _sector_answer(inequality: PopovInequality, sector: Sector, theta: Fraction, best: Reach) -> Answer:
    """The answer about one sector and one multiplier."""
    inverse_gain = Fraction(0) if sector.upper == math.inf else 1 / (Fraction(sector.upper) - inequality.lower)
    least = least_value(inequality.family, theta)
    margin = least.bracket(inverse_gain)
    holds = inequality.holds(theta, sector.upper)
    if holds:
        margin = Bracket(max(margin.low, 0.0), margin.high)
    largest = inequality.largest(best)
    said = f"the inequality holds at every frequency, the margin is {margin}; {_conclusion(inequality)}"
    return Answer(
        criterion="popov",
        theorem=THEOREM,
        largest=largest,
        law_class=NonlinearityClass(sector=sector),
        verdict=Verdict.PROVED if holds else Verdict.INCONCLUSIVE,
        evidence=Evidence.CERTIFIED,
        needs=("time-invariant",),
        theta=float(theta),
        multiplier="1 + theta s",
        parameters=_parameters(theta, best),
        margin=margin,
        worst_frequency=least.frequency,
        hypotheses=_hypotheses(inequality, holds=holds),
        reason=said if holds else _shortfall(sector, least, margin, largest),
    )


def _parameters(theta: Fraction | float | None, best: Reach) -> Mapping[str, object]:
    found: dict[str, object] = {} if theta is None else {"theta": str(theta)}
    if best.found is not None:
        found["points"] = tuple("inf" if cut.x is None else str(cut.x) for cut in best.found.upper_bound.support)
    return MappingProxyType(found)


def _worst(best: Reach) -> float:
    assert best.found is not None
    x = best.found.upper_bound.support[0].x
    return math.inf if x is None else math.sqrt(to_fraction(x))


def _conclusion(inequality: PopovInequality) -> str:
    if inequality.plant.case == "stable":
        return CONCLUSION
    return (
        "every solution is bounded and converges to a point of the stationary set, 0 being asymptotically stable only "
        "if phi vanishes at 0 alone"
    )


def _shortfall(sector: Sector, least: LeastValue, margin: Bracket, largest: Bracket) -> str:
    if sector.upper == math.inf:
        return (
            "the inequality for laws that no gain bounds is not established; the sectors [lower, k] are proved for "
            f"every k up to {text_below(largest.low)}"
        )
    fails = f"fails by {-margin.high:.6g} at {least.frequency:.6g} rad/s" if margin.high < 0 else "is not strict"
    return (
        f"the inequality {fails} with this theta, from which nothing follows for the loop; with the best theta the "
        f"largest k is {largest}"
    )


def _hypotheses(inequality: PopovInequality, *, holds: bool) -> tuple[str, ...]:
    plant = inequality.plant
    shift = f" after the shift by {float(inequality.lower):g}" if inequality.lower else ""
    if plant.case == "stable":
        poles = f"all poles in the open left half-plane{shift}, hidden modes too: checked by an exact count"
    else:
        poles = (
            f"one simple pole at 0{shift} with residue {float(plant.residue):.6g} > 0, all others in the open left "
            "half-plane, hidden modes too: checked by exact counts"
        )
    checked = "holds, by an exact root count in omega^2" if holds else "not established"
    direct = (
        ("sigma + D phi(sigma) invertible with a locally Lipschitz inverse (H has a direct term D): assumed",)
        if inequality.direct != 0
        else ()
    )
    return (
        poles,
        f"inequality on [0, inf], limits included: {checked}",
        "phi time-invariant, locally Lipschitz, in the sector: assumed of the class",
        *direct,
    )
