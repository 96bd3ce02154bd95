"""The circle criterion for a rational block, exact: every sign case of the sector, unstable and critical blocks too."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from types import MappingProxyType

from flint import arb

from lure.analysis.inequality.checks import check_plant, encirclement_condition, region, require_well_posed
from lure.analysis.inequality.gains import GainEnd, simplest_inside, unstable_gain
from lure.analysis.inequality.plant import Response, TransferPolynomials
from lure.analysis.numerics.doubles import double_below, text_above, text_below
from lure.analysis.numerics.minimum import Infimum, infimum, largest_below, positive_with_limits
from lure.analysis.numerics.polynomial import to_fmpq
from lure.analysis.numerics.precision import ball, outward, working_precision
from lure.analysis.verdict import INFINITE, Answer, Bracket, Evidence, Verdict
from lure.classes import NonlinearityClass, Sector
from lure.errors import AssumptionError
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


@dataclass(frozen=True, slots=True)
class CircleCase:
    """A question and what was computed for it.

    Attributes
    ----------
    block : RationalPlant
        The block as given.
    plant : TransferPolynomials
        The block shifted by the lower gain (mirrored: by the upper one).
    sector : Sector
        The sector as given, or the largest one.
    found : Infimum
        The infimum of the real part of ``plant``.
    unbounded : bool
        Whether ``plant`` is strictly positive real, so that an infinite end stands for the whole half-line.
    """

    block: RationalPlant
    plant: TransferPolynomials
    sector: Sector
    found: Infimum
    unbounded: bool

    @property
    def critical(self) -> bool:
        """Whether the shifted block has a pole at 0."""
        return self.plant.case == "critical"

    @property
    def omega(self) -> float:
        """Frequency of the infimum [rad/s; rad per sample]."""
        return self.plant.frequency(math.sqrt(self.found.where))


def circle_answer(case: CircleCase, reach: Bracket, verdict: Verdict) -> Answer:
    """The answer for a question, without its margin."""
    sector = case.sector
    bounds = {name: _text(bound) for name, bound in (("lower", sector.lower), ("upper", sector.upper))}
    return Answer(
        criterion="circle",
        theorem=CRITICAL if case.critical else PRINCIPAL,
        largest=reach,
        law_class=NonlinearityClass(sector=sector, time_varying=not case.critical),
        verdict=verdict,
        evidence=Evidence.CERTIFIED,
        needs=("time-invariant",) if case.critical else (),
        theta=0.0,
        multiplier="1",
        parameters=MappingProxyType({**bounds, "theta": "0"}),
        worst_frequency=case.omega,
        hypotheses=_hypotheses(case, verdict),
        reason=_success(case) if verdict is Verdict.PROVED else _nothing(case),
    )


def _success(case: CircleCase) -> str:
    if case.critical:
        return (
            f"the inequality holds at every frequency for {_named(case)}: every solution is bounded and, for "
            "time-invariant locally Lipschitz phi, converges to the stationary set (to 0 only if the shifted phi "
            "vanishes at 0 alone); for time-varying phi boundedness only"
        )
    return (
        f"the inequality holds at every frequency for {_named(case)}: 0 is globally exponentially stable for "
        "every phi(t, sigma) in it, time-varying phi included"
    )


def _nothing(case: CircleCase) -> str:
    return (
        f"the infimum of the real part, {float(case.found.low):.6g} at frequency {case.omega:.6g}, leaves no sector "
        "that double precision can name"
    )


def failure(case: CircleCase, margin: Bracket, reach: Bracket | None, gain: str | None) -> str:
    """Why a sector is not proved: by how much the inequality fails and where, and what would work."""
    failing = (
        f"the inequality fails by {-margin.middle:.6g} at frequency {case.omega:.6g}"
        if margin.high < 0
        else f"the inequality is not strict: its left-hand side comes down to 0 at frequency {case.omega:.6g}"
    )
    if gain is not None:
        return f"{failing}, and the linear gain {gain} of the sector is not stable"
    advice = "for laws that do not change with time, Popov's may reach further"
    if case.plant.discrete:
        advice = "for laws that do not change with time and have bounded slope, max_slope may reach further"
    if reach is not None and reach.low > case.sector.lower:
        reached = f"[{float(case.sector.lower):g}, k] with k up to {text_below(reach.low)}"
        advice = f"the criterion reaches the sectors {reached}: {advice}"
    return f"{failing}, from which nothing follows about the loop; {advice}"


def _hypotheses(case: CircleCase, verdict: Verdict) -> tuple[str, ...]:
    plant, proved = case.plant, verdict is Verdict.PROVED
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
        + ("tested exactly at every frequency" if proved else "not established"),
    ]
    if proved and not case.critical:
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
    if upper == math.inf and not case.unbounded:
        return f"every sector [{text_above(lower, 15)}, k] with finite k"
    return f"the sector [{text_above(lower, 15)}, {text_below(upper, 15)}]"


def _text(bound: float | Fraction) -> str:
    return f"{bound}" if abs(bound) == math.inf else f"{Fraction(bound)}"


BITS = 128


def circle_largest(block: RationalPlant, *, lower: Fraction = Fraction(0)) -> Answer:
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
    Answer
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
    lower = Fraction(lower)
    plant = check_plant(block, lower=lower)
    response = plant.response()
    found = infimum(response.U, response.D)
    reach = _reach(response, found, lower)
    spr = _holds(plant, response, math.inf)
    if reach.low > lower:
        return circle_answer(CircleCase(block, plant, Sector(lower, reach.low), found, spr), reach, Verdict.PROVED)
    return circle_answer(CircleCase(block, plant, Sector(lower, math.inf), found, spr), reach, Verdict.INCONCLUSIVE)


def circle_criterion(block: RationalPlant, sector: Sector) -> Answer:
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
    Answer
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
        raise AssumptionError("the circle criterion needs a sector with a finite end; got [-inf, inf]")
    mirrored = _mirror_needed(block, sector)
    used, lower, upper = block, sector.lower, sector.upper
    if mirrored:
        used = RationalPlant([-c for c in block.numerator], block.denominator, block.dt)
        lower, upper = -sector.upper, -sector.lower
    lower = Fraction(lower)
    require_well_posed(used, upper, lower=lower)
    plant = check_plant(used, lower=lower)
    response = plant.response()
    found = infimum(response.U, response.D)
    reach = _reach(response, found, lower)
    gain = None
    if _holds(plant, response, upper - lower):
        verdict = Verdict.PROVED
    else:
        gain = unstable_gain(used, Sector(lower, upper))
        verdict = Verdict.INCONCLUSIVE if gain is None else Verdict.REFUTED
    if mirrored:
        reach = Bracket(double_below(Fraction(sector.upper)) if verdict is Verdict.PROVED else -math.inf, math.inf)
    case = CircleCase(block, plant, sector, found, _holds(plant, response, math.inf))
    answer = circle_answer(case, reach, verdict)
    margin = _margin(found, upper - lower, holds=verdict is Verdict.PROVED)
    if verdict is Verdict.PROVED:
        return replace(answer, margin=margin)
    linear = None if gain is None else _linear_gain(gain, mirrored=mirrored)
    reason = failure(case, margin, None if mirrored else reach, linear)
    witness = None if linear is None else f"phi = {linear} sigma"
    return replace(answer, margin=margin, reason=reason, witness=witness)


def _mirror_needed(block: RationalPlant, sector: Sector) -> bool:
    if sector.lower == -math.inf:
        return True
    return sector.upper != math.inf and TransferPolynomials.of(block).shifted(Fraction(sector.upper)).case == "critical"


def _reach(response: Response, found: Infimum, lower: Fraction) -> Bracket:
    """The largest ``k``: ``low`` tested exactly, or at most ``lower`` if the criterion reaches no double above that."""
    if found.low >= 0:
        return INFINITE
    with working_precision(BITS):
        guess = outward(ball(lower) - 1 / found.low, ball(lower) - 1 / found.high)
        low = largest_below(response.D, response.U, guess.low, lower)
        return Bracket(outward(ball(lower), ball(lower)).low if low is None else low, guess.high)


def _holds(plant: TransferPolynomials, response: Response, width: Fraction | float) -> bool:
    """Whether ``1/width + Re P > 0`` on ``[0, inf]``; for an infinite width, ``P`` strictly positive real."""
    D, U = response.D, response.U
    if width != math.inf:
        return positive_with_limits(D + to_fmpq(width) * U, D.degree())
    if plant.hidden.degree() > 0:  # the proof without an upper bound needs a minimal realisation
        return False
    # Re P > 0 at every frequency, and w^2 Re P has a positive limit (in discrete time Re P itself)
    return positive_with_limits(U, U.degree()) and D.degree() - U.degree() <= (0 if plant.discrete else 1)


def _margin(found: Infimum, width: Fraction | float, *, holds: bool) -> Bracket:
    """The infimum of ``1/width + Re P``, its sign that of the exact test."""
    with working_precision(BITS):
        inverse_gain = arb(0) if width == math.inf else 1 / ball(width)
        margin = outward(found.low + inverse_gain, found.high + inverse_gain)
    return Bracket(max(margin.low, 0.0), margin.high) if holds else Bracket(margin.low, min(margin.high, 0.0))


def _linear_gain(gain: Fraction | GainEnd, *, mirrored: bool) -> str:
    sign = -1 if mirrored else 1
    return f"{sign * gain.value.middle:.10g}" if isinstance(gain, GainEnd) else f"{sign * gain}"
