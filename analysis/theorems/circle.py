"""The circle criterion for a rational block, exact: every sign case of the sector, unstable and critical blocks too."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from types import MappingProxyType

from lure.analysis.inequality.checks import encirclement_condition, region, require_well_posed
from lure.analysis.inequality.gains import GainEnd, simplest_inside, unstable_gain
from lure.analysis.inequality.plant import TransferPolynomials
from lure.analysis.inequality.polynomial import RationalInequality
from lure.analysis.inequality.protocol import Best
from lure.analysis.numerics.doubles import double_below, text_above, text_below
from lure.analysis.numerics.minimum import positive_with_limits
from lure.analysis.verdict import Bracket, CriterionResult, Evidence, Verdict
from lure.analysis.wording import constant_gains
from lure.classes import NonlinearityClass, Sector
from lure.errors import AssumptionError, Reason
from lure.plants.rational import RationalPlant

# What an answer of the circle criterion says: conclusion, hypotheses, reasons, each with how it was checked.

PRINCIPAL = (
    "circle criterion: I. W. Sandberg, Bell System Technical Journal 43 (1964) 1601-1608; G. Zames, IEEE Trans. "
    "Automatic Control 11 (1966) 228-238 and 465-476; H. K. Khalil, Nonlinear Systems, 3rd ed., theorem 7.1"
)
CRITICAL = (
    "circle criterion in the critical case of a simple pole at 0 (Popov's inequality with theta = 0): M. A. Aizerman, "
    "F. R. Gantmacher, Absolute Stability of Regulator Systems, 1964; A. Kh. Gelig, G. A. Leonov, V. A. Yakubovich, "
    "Stability of Nonlinear Systems with Nonunique Equilibrium State, 1978"
)


@dataclass(frozen=True, kw_only=True, slots=True)
class CircleCase:
    """A question and what was computed for it.

    Attributes
    ----------
    block : RationalPlant
        The block as given; the inequality may be that of ``-H`` and ``[-upper, -lower]``.
    inequality : RationalInequality
        ``1/(k - lower) + Re P > 0``.
    sector : Sector
        The sector as given, or the largest one.
    best : Best
        How far the inequality goes.
    proved : bool
        Whether it proves the sector.
    """

    block: RationalPlant
    inequality: RationalInequality
    sector: Sector
    best: Best
    proved: bool

    @property
    def plant(self) -> TransferPolynomials:
        """The block shifted by the lower gain (mirrored: by the upper one)."""
        return self.inequality.plant

    @property
    def critical(self) -> bool:
        """Whether the shifted block has a pole at 0."""
        return self.plant.case == "critical"

    @property
    def omega(self) -> float:
        """Frequency of the infimum [rad/s; rad per sample]."""
        assert self.best.worst_frequency is not None
        return self.best.worst_frequency


def circle_answer(case: CircleCase) -> CriterionResult:
    """The answer for a question, as if nothing but the inequality were known."""
    sector = case.sector
    bounds = {name: f"{bound}" if abs(bound) == math.inf else f"{Fraction(bound)}"
              for name, bound in (("lower", sector.lower), ("upper", sector.upper))}  # fmt: skip
    return CriterionResult(
        criterion="circle",
        theorem=CRITICAL if case.critical else PRINCIPAL,
        largest=case.best.largest,
        nonlinearity_class=NonlinearityClass(sector=sector, time_varying=not case.critical),
        verdict=Verdict.PROVED if case.proved else Verdict.INCONCLUSIVE,
        evidence=Evidence.CERTIFIED,
        needs=("time-invariant",) if case.critical else (),
        theta=0.0,
        multiplier="1",
        parameters=MappingProxyType({**bounds, "theta": "0"}),
        worst_frequency=case.omega,
        hypotheses=_hypotheses(case),
        reason=_success(case) if case.proved else "no sector that double precision can name is reached",
    )


def _success(case: CircleCase) -> str:
    consequence = (
        "every solution is bounded and, for time-invariant locally Lipschitz phi, converges to the stationary set (to "
        "0 only if the shifted phi vanishes at 0 alone); for time-varying phi boundedness only"
        if case.critical
        else "0 is globally exponentially stable for every phi(t, sigma) in it, time-varying phi included"
    )
    return f"the inequality holds at every frequency for {_named(case)}: {consequence}"


def failure(case: CircleCase, margin: Bracket, largest: Bracket | None, gain: str | None) -> str:
    """Why a sector is not proved: by how much the inequality fails and where, and what would work."""
    failing = (
        f"the inequality fails by {-margin.middle:.6g} at frequency {case.omega:.6g}"
        if margin.high < 0
        else f"the inequality is not strict: its left-hand side comes down to 0 at frequency {case.omega:.6g}"
    )
    if gain is not None:
        return f"{failing}, and the linear gain {gain} of the sector is not stable"
    advice = "for nonlinearities that do not change with time, Popov's may reach further"
    if case.plant.discrete:
        advice = "for nonlinearities that do not change with time and have bounded slope, max_slope may reach further"
    if largest is not None and largest.low > case.sector.lower:
        proved = f"[{float(case.sector.lower):g}, k] with k up to {text_below(largest.low)}"
        advice = f"the criterion proves the sectors {proved}: {advice}"
    return f"{failing}, from which nothing follows about the loop; {advice}"


def _hypotheses(case: CircleCase) -> tuple[str, ...]:
    plant = case.plant
    zero = "z = 1" if plant.discrete else "s = 0"
    regular = "continuous in sigma" if plant.discrete else "piecewise continuous in t, locally Lipschitz in sigma"
    poles = (
        f"critical case: simple pole at {zero}, residue {float(plant.residue):.6g} > 0, all others strictly stable"
        if case.critical
        else "principal case: the loop is stable for a linear gain at an end of the sector"
    )
    found = [
        f"phi in {_named(case)}, {regular}: assumed of the class",
        f"{poles}: checked by exact root counts",
        f"Nyquist plot of H {region(case.sector)}, infinity included: "
        + ("tested exactly at every frequency" if case.proved else "not established"),
    ]
    if case.proved and not case.critical:
        found.append(encirclement_condition(case.block, case.sector, _inside(case.sector)))
    if case.block.feedthrough:
        found.append(
            "well posed: 1 + kappa H(inf) does not vanish for any gain of the sector (checked), and the loop equation "
            "sigma + H(inf) phi(t, sigma) = v is solved by one sigma (assumed of the class)"
        )
    return tuple(found)


def _inside(sector: Sector) -> Fraction:
    """A gain of the sector that is not zero."""
    gain = simplest_inside(sector)
    return gain or simplest_inside(Sector(0, sector.upper))


def _named(case: CircleCase) -> str:
    lower, upper = case.sector.lower, case.sector.upper
    if upper == math.inf and not _holds(case.inequality, math.inf):
        return f"every sector [{text_above(lower, 15)}, k] with finite k"
    return f"the sector [{text_above(lower, 15)}, {text_below(upper, 15)}]"


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
    best = inequality.best()
    proved = best.largest.low > lower
    sector = Sector(lower, best.largest.low if proved else math.inf)
    return circle_answer(CircleCase(block=block, inequality=inequality, sector=sector, best=best, proved=proved))


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
    mirrored = _mirror_needed(block, sector)
    used, lower, upper = block, sector.lower, sector.upper
    if mirrored:
        used = RationalPlant([-c for c in block.numerator], block.denominator, block.dt)
        lower, upper = -sector.upper, -sector.lower
    lower = Fraction(lower)
    require_well_posed(used, upper, lower=lower)
    inequality = _inequality(used, lower)
    best, proved = inequality.best(), _holds(inequality, upper)
    margin, _ = inequality.least({inequality.weight: Fraction(0)}, upper)
    if mirrored:
        largest = Bracket(double_below(Fraction(sector.upper)) if proved else -math.inf, math.inf)
        best = replace(best, largest=largest)
    case = CircleCase(block=block, inequality=inequality, sector=sector, best=best, proved=proved)
    if proved:
        return replace(circle_answer(case), margin=Bracket(max(margin.low, 0.0), margin.high))
    margin = Bracket(margin.low, min(margin.high, 0.0))
    gain = unstable_gain(used, Sector(lower, upper))
    linear = None if gain is None else _linear_gain(gain, mirrored=mirrored)
    return replace(
        circle_answer(case),
        margin=margin,
        verdict=Verdict.INCONCLUSIVE if gain is None else Verdict.REFUTED,
        reason=failure(case, margin, None if mirrored else best.largest, linear),
        witness=None if linear is None else constant_gains([linear]),
    )


def _inequality(block: RationalPlant, lower: Fraction) -> RationalInequality:
    discrete = isinstance(block, RationalPlant) and block.dt is not None
    return RationalInequality.of(block, lower, "the circle criterion", discrete=discrete, critical=True).unweighted


def _mirror_needed(block: RationalPlant, sector: Sector) -> bool:
    if sector.lower == -math.inf:
        return True
    return sector.upper != math.inf and TransferPolynomials.of(block).shifted(Fraction(sector.upper)).case == "critical"


def _holds(inequality: RationalInequality, upper: Fraction | float) -> bool:
    """Whether ``1/(upper - lower) + Re P > 0`` on ``[0, inf]``; for ``upper = inf``, ``P`` strictly positive real."""
    if upper != math.inf:
        return inequality.decide({inequality.weight: Fraction(0)}, Fraction(upper))
    plant, D, U = inequality.plant, inequality.family.D, inequality.family.U
    if plant.hidden.degree() > 0:  # the proof without an upper bound needs a minimal realisation
        return False
    # Re P > 0 at every frequency, and w^2 Re P has a positive limit (in discrete time Re P itself)
    return positive_with_limits(U, U.degree()) and D.degree() - U.degree() <= (0 if plant.discrete else 1)


def _linear_gain(gain: Fraction | GainEnd, *, mirrored: bool) -> str:
    sign = -1 if mirrored else 1
    return f"{sign * gain.value.middle:.10g}" if isinstance(gain, GainEnd) else f"{sign * gain}"
