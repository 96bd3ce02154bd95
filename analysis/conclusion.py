"""What follows for the real motion: the energy theorem, and the conclusion in words."""

from __future__ import annotations

from dataclasses import dataclass

from analysis.criteria.damping import destabilising_example
from analysis.evidence import Evidence, Verdict
from lure.scenario import Scenario
from lure.upwind import UpwindScheme


@dataclass(frozen=True, kw_only=True, slots=True)
class Proof:
    """One argument and what it shows.

    Attributes
    ----------
    title : str
        Name of the argument.
    model : str
        ``"rod"``, ``"scheme"`` or ``"rod and scheme"``.
    sector : str
        The class of laws it covers.
    evidence : Evidence
        What it rests on.
    argument : str
        The argument in a few sentences.
    """

    title: str
    model: str
    sector: str
    evidence: Evidence
    argument: str


@dataclass(frozen=True, kw_only=True, slots=True)
class Conclusion:
    """What was shown of the closed loop, in words.

    Attributes
    ----------
    verdict : Verdict
        PROVED, REFUTED or INCONCLUSIVE.
    statement : str
        What converges to what.
    stationary_set : str
        The equilibria, without load.
    resting_place : str
        What decides where the rod comes to rest, without load.
    assumptions : tuple of str
        Hypotheses, each with how it was checked or that it is assumed.
    not_shown : tuple of str
        What must not be read into it.
    proofs : tuple of Proof
        The arguments, empty unless PROVED.
    """

    verdict: Verdict
    statement: str
    stationary_set: str
    resting_place: str
    assumptions: tuple[str, ...]
    not_shown: tuple[str, ...]
    proofs: tuple[Proof, ...]

    def __bool__(self) -> bool:
        raise TypeError("a conclusion has three answers; compare conclusion.verdict")

    def __str__(self) -> str:
        return f"{self.verdict}: {self.statement}"


_HALF_LINE = (
    "the half-line {rod undeformed and at rest, z <= 0}: every position with its end at the obstacle or short of "
    "it; not "
    "a single point"
)
_ENERGY = Proof(
    title="energy argument",
    model="rod",
    sector="[0, inf)",
    evidence=Evidence.CERTIFIED,
    argument=(
        "The energy falls at the rate k v(t,0)^2, so the wave that reaches the dashpot is square integrable over "
        "all time; "
        "through the reflection |a| < 1 so are the waves at the contact, the contact stress and z'. The energy of the "
        "waves, an integral over the last transit, tends to zero. Integrated, the boundary relations give "
        "z = constant - (A/k) int p + o(1), so z converges, and its limit is a zero of the law."
    ),
)
_DISCRETE_ENERGY = Proof(
    title="discrete energy argument",
    model="scheme",
    sector="[0, inf)",
    evidence=Evidence.CERTIFIED,
    argument=(
        "(h/2c) sum y_i^2 + 2 d P(z) falls at half the sum of the squared jumps between neighbours plus (1 - a^2)/2 "
        "times "
        "the square of the wave at the dashpot, a positive definite form in the waves and the contact stress; the "
        "three steps "
        "of the energy argument then carry over, for every number of cells."
    ),
)


def conclusion(scheme: UpwindScheme, scenario: Scenario) -> Conclusion:
    """Conclusion for the rod and for its scheme with the rod's own compliance law.

    For ``k > 0`` the energy theorem (``notebooks/notes/0005-energy-theorem.md``) holds for every continuous law with
    ``z p(z) >= 0`` that is locally Lipschitz or nondecreasing; its hypotheses are exact statements about the
    parameters.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme, with its rod.
    scenario : Scenario
        The loads: with one, what is said is about the same loop without it.
    """
    rod = scheme.rod
    damping = rod.exact["damping"]
    set_of_rest, resting = (
        _HALF_LINE,
        (
            "zeta = z + (position the waves would still move the end to) never increases, falls by (A/k) times the "
            "impulse of "
            "the contact stress, and ends as the resting place; a motion that never touches rests at zeta(0)"
        ),
    )
    if not scenario.free:
        set_of_rest = f"without load, {set_of_rest}"
        resting = f"none is claimed under the load of this run; without load, {resting}"
    if damping == 0:
        return Conclusion(
            verdict=Verdict.INCONCLUSIVE,
            statement=(
                "With k = 0 nothing dissipates and the zero eigenvalue is double: the theorems used here do not "
                "apply. Waves "
                "persist in the rod, and a rod that leaves the obstacle at constant speed never comes back. Give k > 0."
            ),
            stationary_set=set_of_rest,
            resting_place="none is claimed",
            assumptions=("k > 0: fails, k = 0 exactly",),
            not_shown=("whether any motion comes to rest",),
            proofs=(),
        )
    if damping < 0:
        example = destabilising_example(rod, None, rod.law.sector)
        return Conclusion(
            verdict=Verdict.REFUTED,
            statement=(
                "The loop is not absolutely stable: the dashpot feeds energy in "
                f"(k = {rod.damping:g} N s/m), and {example}. In the rod itself the energy never falls, whatever the "
                "law: without load no motion that starts with energy comes to rest."
            ),
            stationary_set=set_of_rest,
            resting_place="none is claimed",
            assumptions=("k > 0: fails, decided from the exact value of k",),
            not_shown=("that every motion diverges",),
            proofs=(),
        )
    return Conclusion(
        verdict=Verdict.PROVED,
        statement=(
            "Without load, every motion of finite energy comes to rest at some z <= 0, in the rod and in its "
            f"{scheme.cells}-cell scheme, for the compliance law of this rod and for every other stiffness of it. "
            f"Which z depends "
            "on the start: the motion converges to a half-line of equilibria, to one of its points."
            + _about_load(scenario)
        ),
        stationary_set=set_of_rest,
        resting_place=resting,
        assumptions=_assumptions(scheme),
        not_shown=_not_shown(scenario),
        proofs=(_ENERGY, _DISCRETE_ENERGY),
    )


def _about_load(scenario: Scenario) -> str:
    if scenario.free:
        return ""
    return " About the motion under the load of this run nothing is claimed."


def _assumptions(scheme: UpwindScheme) -> tuple[str, ...]:
    rod = scheme.rod
    regular = "locally Lipschitz (m >= 1)" if rod.law.locally_lipschitz else "continuous and nondecreasing (m < 1)"
    return (
        f"0 < k < inf: checked on the exact value, k = {rod.damping:g} N s/m (|a| < 1)",
        f"p >= 0, p = 0 exactly for z <= 0, {regular}: checked, normal compliance with m = {rod.exponent:g}",
        "no load, g = 0 and f = 0: the theorem is about the free loop",
        "initial data of finite energy, u0 in H1 and u1 in L2: assumed",
        "the rod obeys the linear wave equation with a linear dashpot; the law does not change with time: assumed",
    )


def _not_shown(scenario: Scenario) -> tuple[str, ...]:
    rows = [
        "no single equilibrium attracts all motions: where a motion ends depends on its start",
        "no rate: how fast a motion with contact comes to rest is not bounded by the theorem",
        "what the scheme shows at a given number of cells is about the scheme; its damping is mostly numerical",
    ]
    if not scenario.free:
        rows.insert(
            0,
            "nothing about the forced motion: free flight contracts nothing, and a steady pull moves the rod away "
            "for good",
        )
    return tuple(rows)
