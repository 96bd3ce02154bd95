"""What an answer of the circle criterion says: conclusion, hypotheses, reasons, each with how it was checked."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from types import MappingProxyType

from analysis.answer import Answer
from analysis.criteria.encirclement import encirclement_condition, region
from analysis.criteria.hurwitz import simplest_inside
from analysis.doubles import text_above, text_below
from analysis.evidence import Bracket, Evidence, Verdict
from analysis.extremum import Infimum
from analysis.plant import Plant
from lure.law_class import LawClass
from lure.rational import RationalBlock
from lure.sector import Sector

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
    block : RationalBlock
        The block as given.
    plant : Plant
        The block shifted by the lower gain (mirrored: by the upper one).
    sector : Sector
        The sector as given, or the largest one.
    found : Infimum
        The infimum of the real part of ``plant``.
    unbounded : bool
        Whether ``plant`` is strictly positive real, so that an infinite end stands for the whole half-line.
    """

    block: RationalBlock
    plant: Plant
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
        law_class=LawClass(sector=sector, time_varying=not case.critical),
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
