"""What is known of one rod, of all with parameters in intervals, and of their schemes, as the general part asks."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from typing import Any

from lure.analysis.certificates.checker import Proved
from lure.analysis.certificates.drafts import complete_and_check, guarded
from lure.analysis.certificates.riccati import Rounded
from lure.analysis.certificates.systems import class_entry, system_of
from lure.analysis.certificates.theory import Draft
from lure.analysis.rod.certificates import (
    SLACK,
    STRUCTURE,
    circle_bound,
    criterion_drafts,
    draft_of,
    energy_matrix,
    energy_theorem_draft,
    energy_theta,
    negative_damping_draft,
    popov_theta,
)
from lure.analysis.rod.popov import rod_circle_criterion, rod_popov_criterion
from lure.analysis.theorems.table import Upper
from lure.analysis.verdict import INFINITE, Bracket, CriterionResult, Verdict
from lure.classes import NonlinearityClass, Sector
from lure.errors import AssumptionError, Reason
from lure.record import described, quantity
from lure.rod.discretisation import UpwindScheme
from lure.rod.family import RodFamily
from lure.rod.transfer import RodPlant

# What is known of the rod and its scheme, as the general part asks for it.


@described(frozen=True, slots=True)
class RodTheory:
    """The theory of a rod or its scheme, see :class:`lure.analysis.certificates.theory.Theory`."""

    plant: UpwindScheme | RodPlant = quantity("The scheme, or the rod")
    critical: bool = quantity("True: both have a simple pole at 0", default=True)
    argument: str = quantity("The energy theorem", default="the energy of the rod")

    def inequality(self, criterion: str, sector: Sector, theta: float | None = None) -> CriterionResult:
        """Popov's or the circle criterion for one sector."""
        if criterion == "circle":
            return rod_circle_criterion(self.plant, sector)
        return rod_popov_criterion(self.plant, sector, theta=theta)

    def largest(self, criterion: str) -> CriterionResult:
        """The largest sector ``[0, k]`` of Popov's or the circle criterion for the rod or its scheme.

        For the rod itself, a partial differential equation, the inequality proves that every motion of finite energy
        comes to rest, its end at a zero of a time-invariant ``phi`` (note 11); of the scheme, that every motion
        converges to the set of equilibria.  Neither says which equilibrium, nor how fast.

        Raises
        ------
        AssumptionError
            The criterion is not one for the rod.
        """
        if criterion != "popov" and criterion != "circle":
            raise AssumptionError(f"for the rod and its scheme there are popov and circle, and no {criterion}")
        found = self.inequality(criterion, Sector(0, math.inf))
        largest = found.largest
        if 0 < largest.low < math.inf:  # asked of a sector strictly inside the largest one
            largest = Bracket(math.nextafter(largest.low, 0), largest.high)
            found = self.inequality(criterion, Sector(0, largest.low))
        elif largest.low == math.inf and found.verdict is Verdict.INCONCLUSIVE:  # Re H >= 0: 1/k is left for every k
            found = self.inequality(criterion, Sector(0, 1))
        proved = largest.low > 0 and found.verdict is Verdict.PROVED
        return replace(
            found,
            model="",
            largest=largest,
            nonlinearity_class=NonlinearityClass(sector=Sector(0, largest.low if largest.low > 0 else math.inf)),
            verdict=found.verdict if proved or found.verdict is Verdict.REFUTED else Verdict.INCONCLUSIVE,
            needs=("time-invariant",),
            margin=None,
            smallest_theta=None,
            reason=found.reason,
        )

    def hurwitz(self) -> Bracket:
        """Every gain is stable if the dashpot damps, since Popov's criterion covers them."""
        return INFINITE if self.plant.rod.exact["damping"] > 0 else Bracket(0.0, math.inf)

    def drafts(self, answer: CriterionResult, upper: Upper | None) -> Iterator[tuple[Upper, Draft]]:
        """Proofs of what a criterion answered."""
        return criterion_drafts(self.plant, answer, upper)

    def proof(self) -> Draft:
        """The energy theorem; without damping the energy does not fall."""
        if self.plant.rod.exact["damping"] == 0:
            raise AssumptionError("the dashpot has k = 0, and the energy does not fall", code=Reason.UNDAMPED)
        return energy_theorem_draft(self.plant)

    def refutation(self) -> Draft | None:
        """Of a dashpot that feeds energy in."""
        return negative_damping_draft(self.plant, Sector(0, math.inf)) if self.plant.rod.exact["damping"] < 0 else None

    def thetas(self) -> Iterator[Fraction]:
        """The multiplier that serves every scheme, and the one with which the energy is a proof."""
        if isinstance(self.plant, UpwindScheme):
            yield popov_theta(self.plant.rod)
            yield energy_theta(self.plant)

    def matrices(self, theta: Fraction) -> Iterator[Rounded]:
        """The energy, where it serves."""
        if isinstance(self.plant, UpwindScheme) and theta > 0:
            found = energy_matrix(self.plant, theta)
            yield from () if found is None else (found,)


# Rods with parameters in intervals: the theorems for all of them, by the two rods at which they are hardest.

_EVERY = NonlinearityClass(sector=Sector(0, math.inf))


@described(frozen=True, slots=True)
class FamilyTheory:
    """The theory of rods with parameters in intervals, see :class:`lure.analysis.certificates.theory.Theory`."""

    plant: RodFamily = quantity("The rods, or their schemes")
    critical: bool = quantity("True: all have a simple pole at 0", default=True)
    argument: str = quantity("The energy theorem", default="the energy of the rod")

    def inequality(self, criterion: str, sector: Sector, theta: float | None = None) -> CriterionResult:
        """Not asked of many rods."""
        raise AssumptionError(f"{criterion} is asked of one rod, and intervals mean many; give each one number")

    def largest(self, criterion: str) -> CriterionResult:
        """Not asked of many rods: the energy theorem covers every sector."""
        return self.inequality(criterion, _EVERY.sector)

    def hurwitz(self) -> Bracket:
        """Every gain is stable if all dashpots damp, by the energy theorem."""
        return INFINITE if self.plant.bounds("damping")[0] > 0 else Bracket(0.0, math.inf)

    def drafts(self, answer: CriterionResult, upper: Upper | None) -> Iterator[tuple[Upper, Draft]]:
        """None: no criterion answers."""
        return iter(())

    def proof(self) -> Draft:
        """The energy theorem; it needs that every dashpot damps."""
        return energy_draft(self.plant)

    def refutation(self) -> Draft | None:
        """Of one rod whose dashpot feeds energy in."""
        return negative_draft(self.plant)

    def thetas(self) -> Iterator[Fraction]:
        """None: no proof by matrices."""
        return iter(())

    def matrices(self, theta: Fraction) -> Iterator[Rounded]:
        """None."""
        return iter(())


def energy_draft(family: RodFamily) -> Draft:
    """The energy theorem for all rods in the sector ``[0, inf]``, with the contact law where it is one and linear.

    ``family``: the rods, or their schemes.

    Raises
    ------
    AssumptionError
        Some dashpot does not damp.
    """
    low, high = family.bounds("damping")
    if low <= 0:
        raise AssumptionError(
            f"the damping {'is' if low == high else 'may be anything from'} {float(low):g}"
            f"{'' if low == high else f' to {float(high):g}'}, and with k <= 0 the energy does not fall",
            code=Reason.UNDAMPED,
        )
    return energy_theorem_draft(family)


def negative_draft(family: RodFamily) -> Draft | None:
    """The refutation by the rod with the least damping, the others in the middle; None where that damps or is 0.

    ``family``: the rods, or their schemes.
    """
    low, _ = family.bounds("damping")
    if low >= 0:
        return None
    E, rho, L, A, _ = ((Fraction(a) + Fraction(b)) / 2 for _, a, b in _pairs(family))
    k = low if low * low != A * A * rho * E else low / 2  # -Z is no damping
    point = [E, rho, L, A, max(k, low)]
    proof = {"method": "member", "at": [str(v) for v in point], "proof": STRUCTURE}
    return {
        **draft_of(family, "counterexample", {}, class_entry(_EVERY, unbounded=True)),
        "verdict": "REFUTED",
        "proof": proof,
    }


def stiffest_contact(family: RodFamily) -> Proved | None:
    """The circle criterion for schemes of all rods, for contact laws that may change with time: the largest sector.

    ``[0, K]`` with ``K < (E/L) min(k, Z)^2/|k^2 - Z^2|`` for every rod, what the checker accepts of it; None where
    there is no bound, or it accepts nothing.

    ``family``: schemes, all damped.
    """
    ends = [circle_bound(rod) for rod in family.hardest]
    finite = [end for end in ends if end is not None]
    if not finite:
        return None
    own = NonlinearityClass(sector=Sector(0, (1 - SLACK) * min(finite)), time_varying=True)
    draft = draft_of(family, "rod-circle", {}, class_entry(own, unbounded=False))
    found = guarded("rod-circle", lambda: complete_and_check(draft))
    return found if isinstance(found, Proved) else None


def margins(family: RodFamily) -> str:
    """How much farther the parameters may vary, in their units; empty where nothing is proved.

    ``family``: the schemes of the rods.
    """
    low, high = family.bounds("damping")
    if low <= 0:
        return ""
    less = "" if low == high else f", {float(low):g} N s/m now,"
    said = (
        f"The damping{less} may be any positive number, and so may modulus, density, length, area and compliance: 100 "
        "% less and any number of times more; from a damping below 0 on a rod is refuted."
    )
    shown = stiffest_contact(family)
    if shown is None:
        return said
    stiffness = Fraction(shown.certificate["laws"]["sector"][1])
    more = float(stiffness * family.bounds("compliance")[0]) - 1
    if family.rod.exact["exponent"] != 1:
        compared = ""
    elif more >= 0:
        compared = f", {more * 100:.3g} % more than the stiffest of these contacts"
    else:
        compared = f", {1 + more:.3g} times the stiffest of these contacts"
    return (
        f"{said} For contacts whose law changes with time the circle criterion covers the schemes of all these rods up "
        f"to a stiffness of {_below(stiffness)} Pa/m{compared}."
    )


def _below(value: Fraction) -> str:
    """Four digits, rounded down."""
    digits = 10 ** (3 - math.floor(math.log10(float(value))))
    return f"{math.floor(value * Fraction(digits)) / digits:.4g}"


def _pairs(family: RodFamily) -> list[list[str]]:
    found: Any = system_of(family)["parameters"]
    return [list(map(str, one)) for one in found]
