"""The circle criterion for a rational block, exact: every sign case of the sector, unstable and critical blocks too."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from functools import partial

from lure.analysis.inequality.checks import encirclement_condition, region, require_well_posed
from lure.analysis.inequality.gains import GainEnd, simplest_inside, unstable_gain
from lure.analysis.inequality.plant import TransferPolynomials
from lure.analysis.inequality.polynomial import RationalInequality
from lure.analysis.inequality.protocol import Multiplier
from lure.analysis.numerics.doubles import double_below
from lure.analysis.numerics.minimum import nonnegative_from_zero, positive_with_limits
from lure.analysis.theorems.criterion import Criterion, sector_class
from lure.analysis.verdict import Bracket, CriterionResult, Verdict
from lure.analysis.wording import constant_gains
from lure.classes import Sector
from lure.errors import AssumptionError, Reason
from lure.plants.rational import RationalPlant

NAME = "the circle criterion"
PRINCIPAL = (
    "circle criterion: I. W. Sandberg, Bell System Technical Journal 43 (1964) 1601-1608; G. Zames, IEEE Trans. "
    "Automatic Control 11 (1966) 228-238 and 465-476; H. K. Khalil, Nonlinear Systems, 3rd ed., theorem 7.1"
)
CRITICAL = (
    "circle criterion in the critical case of a simple pole at 0 (Popov's inequality with theta = 0): M. A. Aizerman, "
    "F. R. Gantmacher, Absolute Stability of Regulator Systems, 1964; A. Kh. Gelig, G. A. Leonov, V. A. Yakubovich, "
    "Stability of Nonlinear Systems with Nonunique Equilibrium State, 1978"
)
CONCLUSIONS = (
    "0 is globally exponentially stable for every phi(t, sigma) of the class, time-varying phi included",
    "every solution is bounded and, for time-invariant locally Lipschitz phi, converges to the stationary set (to 0 "
    "only if the shifted phi vanishes at 0 alone); for time-varying phi boundedness only",
)
ADVICE = (
    "for nonlinearities that do not change with time, Popov's may prove more",
    "for nonlinearities that do not change with time and have bounded slope, max_slope may prove more",
)


def circle_largest(block: RationalPlant, *, lower: Fraction = Fraction(0)) -> CriterionResult:
    r"""The largest ``k`` for which the circle criterion covers the sector ``[lower, k]``, as an algebraic number.

    With ``P = H/(1 + lower H)`` the criterion reads ``1/(k - lower) + Re P(i w) > 0`` on ``[0, inf]``, so that
    ``k - lower = -1/inf Re P`` is the supremum, or every finite ``k`` where ``Re P >= 0``.

    Parameters
    ----------
    block : RationalPlant
        The block ``sigma = H mu``, ``mu = -phi(t, sigma)``, in continuous or discrete time.
    lower : Fraction
        Lower end of the sector, of either sign; for an unstable block a gain at which the loop is stable.

    Returns
    -------
    CriterionResult
        ``largest``: at ``low`` the inequality was tested exactly, at every frequency, apart from how it was found;
        ``high`` bounds the supremum to a relative width of 1e-10 in ``k - lower``.

    Raises
    ------
    InputError, AssumptionError
        As :func:`lure.analysis.inequality.checks.check_plant`.

    Notes
    -----
    Principal case: global exponential stability of 0, uniform over the class, for time-varying ``phi`` (piecewise
    continuous in ``t``).  Critical case: for time-invariant, locally Lipschitz ``phi`` every solution is bounded and
    converges to the stationary set ``{phi = 0}``, which is more than one point where ``phi`` vanishes elsewhere; for
    time-varying ``phi`` boundedness alone.  Above ``largest.high`` nothing follows about the loop.

    Examples
    --------
    Re H = (1 - x)/((1 - x)^2 + x), x = w^2, is least at x = 2 and equals -1/3 there.

    >>> print(f"{circle_largest(RationalPlant([1], [1, 1, 1])).largest.low:.12g}")
    3
    """
    inequality = _inequality(block, Fraction(lower))
    return _with_geometry(block, _criterion(inequality).answer(inequality))


def circle_may_reach(block: RationalPlant, upper: float, *, lower: Fraction) -> bool:
    """Whether the inequality of :func:`circle_largest` holds for ``k = upper``, exactly, and so for smaller ``k``.

    Parameters
    ----------
    block : RationalPlant
        As there.
    upper : float
        Upper end of the sector; ``inf`` asks whether ``Re P >= 0``, so that it holds for every finite ``k``.
    lower : Fraction
        Lower end.

    Raises
    ------
    InputError, AssumptionError
        As there.
    """
    inequality = _inequality(block, lower)
    if upper == math.inf:
        return nonnegative_from_zero(inequality.family.U)
    return inequality.decide({inequality.weight: Fraction(0)}, Fraction(upper))


def circle_criterion(block: RationalPlant, sector: Sector) -> CriterionResult:
    r"""The circle criterion for one sector ``[k1, k2]``, certified over all frequencies.

    The loop is shifted by ``k1`` to ``P = H/(1 + k1 H)``, exactly, and the criterion reads
    ``1/(k2 - k1) + Re P(i w) > 0`` on ``[0, inf]``; for ``k2 = inf``, ``P`` strictly positive real.  It is the
    classical one: the Nyquist plot of ``H`` stays clear of the disc on ``[-1/k1, -1/k2]`` and encircles it as often as
    ``H`` has unstable poles (``0 < k1``), stays right of ``-1/k2`` (``k1 = 0``) or inside the disc (``k1 < 0 < k2``).

    Parameters
    ----------
    block : RationalPlant
        The block ``sigma = H mu``, ``mu = -phi(t, sigma)``, in continuous or discrete time.
    sector : Sector
        Both ends of any sign; one may be infinite.

    Returns
    -------
    CriterionResult
        ``margin`` brackets the infimum of the left-hand side.  REFUTED where a linear gain of the sector is not
        stable, INCONCLUSIVE where the inequality fails and none is known.

    Raises
    ------
    InputError
        ``1 + kappa H(inf)`` vanishes for a gain of the sector.
    AssumptionError
        Both ends are infinite, or the loop at ``k1`` is not admitted by
        :func:`lure.analysis.inequality.checks.check_plant`.

    Notes
    -----
    Conclusions as for :func:`circle_largest`.  A sector ``[k1, k2]`` of ``H`` is the sector ``[-k2, -k1]`` of ``-H``:
    that is used for ``k1 = -inf`` and where the loop is critical at ``k2``.

    Examples
    --------
    >>> print(circle_criterion(RationalPlant([12], [1, 2, -3]), Sector(1, 2)).verdict)
    PROVED
    """
    if sector.lower == -math.inf and sector.upper == math.inf:
        raise AssumptionError(
            "the circle criterion needs a sector with a finite end; got [-inf, inf]", code=Reason.NO_LOWER_END
        )
    used, asked, mirrored = block, sector, _mirror_needed(block, sector)
    if mirrored:
        used = RationalPlant([-c for c in block.numerator], block.denominator, block.dt)
        asked = Sector(-sector.upper, -sector.lower)
    require_well_posed(used, asked.upper, lower=Fraction(asked.lower))
    answer = _criterion(_inequality(used, Fraction(asked.lower))).decide(used, asked)
    proved = answer.verdict is Verdict.PROVED
    if mirrored:
        turned = replace(answer.nonlinearity_class, sector=sector)
        reach = Bracket(double_below(Fraction(sector.upper)) if proved else -math.inf, math.inf)
        symmetry = f"-H and the sector {asked} in place of H and {sector}: the loop is the same"
        answer = replace(answer, nonlinearity_class=turned, largest=reach, hypotheses=(symmetry, *answer.hypotheses))
    answer = _with_geometry(block, answer)
    gain = None if proved else unstable_gain(used, asked)
    if gain is None:
        reason = answer.reason.partition("; ")[0] if mirrored else answer.reason
        return answer if proved else replace(answer, reason=f"{reason}; {ADVICE[block.dt is not None]}")
    linear = _linear_gain(gain, mirrored=mirrored)
    return replace(
        answer,
        verdict=Verdict.REFUTED,
        reason=f"the linear gain {linear} of the sector is not stable",
        witness=constant_gains([linear]),
    )


def _inequality(block: RationalPlant, lower: Fraction) -> RationalInequality:
    discrete = isinstance(block, RationalPlant) and block.dt is not None
    return RationalInequality.of(block, lower, NAME, discrete=discrete, critical=True).unweighted


def _criterion(inequality: RationalInequality) -> Criterion:
    """The criterion for one plant: the critical case has another theorem, about time-invariant nonlinearities."""
    grounds = inequality.grounds
    regular = "continuous in sigma" if grounds.discrete else "piecewise continuous in t, locally Lipschitz in sigma"
    return Criterion(
        name="circle",
        title=NAME,
        theorem=CRITICAL if grounds.critical else PRINCIPAL,
        formula="1",
        inequality=lambda _block, _lower: inequality,
        nonlinearities=partial(sector_class, time_varying=not grounds.critical),
        assumed=f"{{class}}, {regular}: assumed of the class",
        kind="",
        needs=("time-invariant",) if grounds.critical else (),
        composed=True,
        endless=_endless,
        conclusions=CONCLUSIONS,
    )


def _endless(base: RationalInequality, _multiplier: Multiplier) -> bool:
    """Whether ``P`` is strictly positive real, with no hidden modes: the proof needs a minimal realisation.

    ``Re P > 0`` at every frequency, and ``omega^2 Re P`` has a positive limit, in discrete time ``Re P`` itself.
    """
    if base.plant.hidden.degree() > 0:
        return False
    D, U = base.family.D, base.family.U
    return positive_with_limits(U, U.degree()) and D.degree() - U.degree() <= (0 if base.plant.discrete else 1)


def _with_geometry(block: RationalPlant, answer: CriterionResult) -> CriterionResult:
    """The answer with what a proof says of the Nyquist plot."""
    if answer.verdict is not Verdict.PROVED:
        return answer
    sector, every_finite = answer.sector, answer.margin is None and answer.sector.upper == math.inf
    found = [] if every_finite else [f"so the Nyquist plot of H stays {region(sector)}, infinity included"]
    if "time-invariant" not in answer.needs:
        inside = simplest_inside(sector) or simplest_inside(Sector(0, sector.upper))
        found.append(encirclement_condition(block, sector, inside))
    return replace(answer, hypotheses=(*answer.hypotheses, *found))


def _mirror_needed(block: RationalPlant, sector: Sector) -> bool:
    if sector.lower == -math.inf:
        return True
    return sector.upper != math.inf and TransferPolynomials.of(block).shifted(Fraction(sector.upper)).case == "critical"


def _linear_gain(gain: Fraction | GainEnd, *, mirrored: bool) -> str:
    sign = -1 if mirrored else 1
    return f"{sign * gain.value.middle:.10g}" if isinstance(gain, GainEnd) else f"{sign * gain}"
