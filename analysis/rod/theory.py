"""What is known of the rod and its scheme, as the general part asks for it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction

from lure.analysis.certificates.riccati import Rounded
from lure.analysis.certificates.theory import Draft
from lure.analysis.rod.certificates import (
    criterion_drafts,
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
from lure.rod.discretisation import UpwindScheme
from lure.rod.transfer import RodPlant


@dataclass(frozen=True, slots=True)
class RodTheory:
    """The theory of a rod or its scheme, see :class:`lure.analysis.certificates.theory.Theory`.

    Attributes
    ----------
    plant : UpwindScheme or RodPlant
        The scheme, or the rod.
    critical : bool
        True: both have a simple pole at 0.
    argument : str
        The energy theorem.
    """

    plant: UpwindScheme | RodPlant
    critical: bool = True
    argument: str = "the energy of the rod"

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

        Parameters
        ----------
        criterion : {"popov", "circle"}
            The criterion.

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
