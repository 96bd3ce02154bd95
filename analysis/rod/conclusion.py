"""What follows for the real motion: the verdict by ``lure.analysis.questions.conclusion``, and where it ends.

The verdict, the class and the first sentence are those of the certificates; what is added says where a motion ends.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import cast

from lure.analysis.certificates import codes
from lure.analysis.certificates.checker import Proved, Refuted
from lure.analysis.certificates.drafts import complete_and_check, guarded
from lure.analysis.questions.conclusion import Conclusion as SearchResult
from lure.analysis.questions.conclusion import conclusion_of, undecided
from lure.analysis.questions.problem import Problem
from lure.analysis.rod.certificates import energy_theorem_draft, negative_damping_draft
from lure.analysis.rod.popov import destabilising_example, without_damping
from lure.analysis.rod.theory import energy_draft, margins, negative_draft
from lure.analysis.verdict import CriterionResult, Evidence, Verdict
from lure.analysis.wording import interval, plants_words
from lure.classes import NonlinearityClass, Sector
from lure.record import Record, quantity
from lure.rod.discretisation import UpwindScheme
from lure.rod.family import Interval, RodFamily
from lure.rod.scenario import Scenario
from lure.rod.transfer import RodPlant


class Proof(Record):
    """One argument and what it shows."""

    title: str = quantity("Name of the argument")
    model: str = quantity("What it is about, the rod or the scheme")
    meaning: str = quantity("What is proved of the motions, by the certificate")
    sector: str = quantity("The sector of the certificate")
    evidence: Evidence = quantity("What it rests on")
    argument: str = quantity("The argument in a few sentences")


class Conclusion(Record):
    """What was shown of the closed loop, in words."""

    rod: SearchResult = quantity("What follows from the certificate for the rod")
    scheme: SearchResult = quantity("What follows from the certificate for the scheme")
    statement: str = quantity("The whole of it")
    stationary_set: str = quantity("The equilibria, without load")
    resting_place: str = quantity("What decides where the rod comes to rest, without load")
    assumptions: tuple[str, ...] = quantity("Hypotheses, each with how it was checked or that it is assumed")
    not_shown: tuple[str, ...] = quantity("What must not be read into it")
    proofs: tuple[Proof, ...] = quantity("The arguments, empty unless PROVED")

    @property
    def found(self) -> SearchResult:
        """What follows for the rod; for its scheme where nothing is decided of that."""
        return self.scheme if self.scheme.verdict is Verdict.INCONCLUSIVE else self.rod

    @property
    def certificates(self) -> tuple[Proved, ...]:
        """The proofs that the checker accepted, of the rod first."""
        return tuple(one.shown for one in (self.rod, self.scheme) if isinstance(one.shown, Proved))

    @property
    def verdict(self) -> Verdict:
        """PROVED, REFUTED or INCONCLUSIVE."""
        return self.found.verdict

    @property
    def headline(self) -> str:
        """The verdict in one sentence; what is proved for the rod's own nonlinearity without naming that."""
        if self.verdict is not Verdict.PROVED or self.found.shown is None:
            return self.found.headline
        return f"{_without_load(self.found.meaning)}{plants_words(self.found.shown.certificate['system'])}."

    def __bool__(self) -> bool:
        raise TypeError("a conclusion has three answers; compare conclusion.verdict")

    def __str__(self) -> str:
        return f"{self.verdict}: {self.statement}"


_HALF_LINE = (
    "the half-line {rod undeformed and at rest, z <= 0}: every position with its end at the obstacle or short of "
    "it; not "
    "a single point"
)
_RESTING = (
    "zeta = z + (position the waves would still move the end to) never increases, falls by (A/k) times the impulse of "
    "the contact stress, and ends as the resting place; a motion that never touches rests at zeta(0)"
)
_UNDER_LOAD = " About the motion under the load of this run nothing is claimed."
_ARGUMENTS = {
    "rod": (
        "energy argument",
        "The energy falls at the rate k v(t,0)^2, so the wave that reaches the dashpot is square integrable over all "
        "time; through the reflection |a| < 1 so are the waves at the contact, the contact stress and z'. The energy "
        "of the waves, an integral over the last transit, tends to zero. Integrated, the boundary relations give z = "
        "constant - (A/k) int p + o(1), so z converges, and its limit is a zero of the nonlinearity.",
    ),
    "scheme": (
        "discrete energy argument",
        "(h/2c) sum y_i^2 + 2 d P(z) falls at half the sum of the squared jumps between neighbours plus (1 - a^2)/2 "
        "times the square of the wave at the dashpot, a positive definite form in the waves and the contact stress; "
        "the three steps of the energy argument then carry over, for every number of cells.",
    ),
}


def conclusion(scheme: UpwindScheme, scenario: Scenario, intervals: Mapping[str, Interval] | None = None) -> Conclusion:
    """Conclusion for the rod and for its scheme with the rod's own compliance law, as far as the checker accepts it.

    For ``k > 0`` the energy theorem (``notebooks/notes/0005-energy-theorem.md``) holds for every continuous
    nonlinearity with ``z p(z) >= 0`` that is locally Lipschitz or nondecreasing.  Its certificate is about locally
    Lipschitz nonlinearities: with ``m < 1`` nothing is concluded.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme, with its rod.
    scenario : Scenario
        The loads: with one, what is said is about the same loop without it.
    intervals : Mapping of str to (Fraction, Fraction), optional
        Of parameters: then all that is concluded is about every rod with parameters in these.
    """
    blocks: tuple[Block, Block] = (RodPlant(scheme.rod), scheme)
    if intervals:
        blocks = RodFamily(scheme.rod, intervals), RodFamily(scheme.rod, intervals, scheme.cells)
    rod, discrete = (concluded(block, offered(block)) for block in blocks)
    found = discrete if discrete.verdict is Verdict.INCONCLUSIVE else rod
    proved = found.verdict is Verdict.PROVED
    resting = _RESTING if proved else "none is claimed"
    if not scenario.free:
        resting = "none is claimed under the load of this run" + (f"; without load, {resting}" if proved else "")
    return Conclusion(
        rod=rod,
        scheme=discrete,
        statement=_statement(scheme, found, discrete, blocks[1]) + ("" if scenario.free else _UNDER_LOAD),
        stationary_set=_HALF_LINE if scenario.free else f"without load, {_HALF_LINE}",
        resting_place=resting,
        assumptions=_assumptions(scheme, blocks[1]) if proved else (_failing(scheme, blocks[1]),),
        not_shown=_not_shown(scheme, scenario, found.verdict),
        proofs=(_proof("rod", rod), _proof("scheme", discrete)) if proved else (),
    )


Block = RodPlant | UpwindScheme | RodFamily


def offered(block: Block) -> Proved | Refuted | str:
    """What the checker accepts of the motions of a block, or why that is nothing."""
    if isinstance(block, RodFamily):
        whole = guarded("rods", lambda: complete_and_check(negative_draft(block) or energy_draft(block)))
        return whole if isinstance(whole, Proved | Refuted) else str(whole.detail)
    damping, sector = block.rod.exact["damping"], block.rod.nonlinearity.sector
    if damping == 0:
        return cast("CriterionResult", without_damping("popov", block, sector)).reason
    draft = energy_theorem_draft(block) if damping > 0 else negative_damping_draft(block, sector)
    found = guarded("rod", lambda: complete_and_check(draft))
    return found if isinstance(found, Proved | Refuted) else str(found)


def concluded(block: Block, shown: Proved | Refuted | str) -> SearchResult:
    """The verdict on a block: on every nonlinearity without upper bound, and on the rod's own.

    ``shown``: what the checker accepted of it, or why that is nothing.
    """
    law = None if isinstance(block, RodFamily) and "compliance" in block.intervals else block.rod.nonlinearity
    asked = Problem.about(block, NonlinearityClass(sector=Sector(0, math.inf)), nonlinearity=law)
    if isinstance(shown, str):
        return undecided(asked, shown, code=codes.NO_MULTIPLIER if _damped(block) else codes.UNDAMPED)
    return conclusion_of(asked, shown)


def _damped(block: Block) -> bool:
    low = block.bounds("damping")[0] if isinstance(block, RodFamily) else block.rod.exact["damping"]
    return low > 0


def _statement(scheme: UpwindScheme, found: SearchResult, second: SearchResult, block: Block) -> str:
    said = _without_load(found.sentence)
    if isinstance(block, RodFamily):
        middle = "What is drawn, computed and simulated here is the rod in the middle of the intervals."
        too = f" {second.meaning}, too ({second.evidence})." if found.verdict is Verdict.PROVED else ""
        margin = margins(block) if found.verdict is Verdict.PROVED else ""
        return " ".join(filter(None, (said + too, margin, middle)))
    if found.verdict is Verdict.PROVED:
        return (
            f"{said} {second.meaning}, too ({second.evidence}). Where it comes to rest depends on its start: the "
            "motion converges to one point of a half-line of equilibria."
        )
    if found.verdict is Verdict.REFUTED:
        example = destabilising_example(scheme.rod, None, scheme.rod.nonlinearity.sector)
        return (
            f"{found.headline} The dashpot feeds energy in (k = {scheme.rod.damping:g} N s/m), and {example}. In the "
            "rod itself the energy never falls, whatever the nonlinearity: without load no motion that starts with "
            "energy comes to rest."
        )
    return said


def _without_load(sentence: str) -> str:
    return f"Without load, {sentence[0].lower()}{sentence[1:]}"


def _proof(model: str, found: SearchResult) -> Proof:
    """The argument behind a certificate, with what that says."""
    shown = cast("Proved", found.shown)
    title, argument = _ARGUMENTS[model]
    return Proof(
        title=title,
        model=model,
        meaning=found.meaning,
        sector=interval(shown.certificate["laws"]["sector"]),
        evidence=found.evidence,
        argument=argument,
    )


def _assumptions(scheme: UpwindScheme, block: Block) -> tuple[str, ...]:
    rod, which = scheme.rod, f"on the exact value, k = {scheme.rod.damping:g} N s/m"
    if isinstance(block, RodFamily):
        which = f"for every rod with {block.ranges}"
    return (
        f"0 < k < inf: checked {which} (|a| < 1)",
        "p >= 0, p = 0 exactly for z <= 0, locally Lipschitz (m >= 1): checked, normal compliance with "
        f"m = {rod.exponent:g}",
        "no load, g = 0 and f = 0: the theorem is about the free loop",
        "initial data of finite energy, u0 in H1 and u1 in L2: assumed",
        "the rod obeys the linear wave equation with a linear dashpot; the nonlinearity does not change with time: "
        "assumed",
    )


def _failing(scheme: UpwindScheme, block: Block) -> str:
    """The hypothesis that stands in the way of a proof."""
    if isinstance(block, RodFamily):
        return f"k > 0: fails for some rod with {block.ranges}"
    damping = scheme.rod.exact["damping"]
    if damping > 0:
        return f"p locally Lipschitz (m >= 1): fails, m = {scheme.rod.exponent:g}"
    return "k > 0: fails, k = 0 exactly" if damping == 0 else "k > 0: fails, decided from the exact value of k"


def _not_shown(scheme: UpwindScheme, scenario: Scenario, verdict: Verdict) -> tuple[str, ...]:
    if verdict is Verdict.REFUTED:
        return ("that every motion diverges",)
    if verdict is Verdict.INCONCLUSIVE:
        paper = (
            "; note 5 proves it of continuous nondecreasing ones too, its certificate is about locally Lipschitz ones"
        )
        return ("whether any motion comes to rest" + (paper if scheme.rod.exact["damping"] > 0 else ""),)
    forced = (
        "nothing about the forced motion: free flight contracts nothing, and a steady pull moves the rod away for good"
    )
    return (
        *(() if scenario.free else (forced,)),
        "no single equilibrium attracts all motions: where a motion ends depends on its start",
        "no rate: how fast a motion with contact comes to rest is not bounded by the theorem",
        "what the scheme shows at a given number of cells is about the scheme; its damping is mostly numerical",
    )
