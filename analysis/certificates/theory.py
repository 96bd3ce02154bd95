"""What is known of a plant by its structure, as the general part asks for it: criteria, proofs and matrices."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any, Protocol

from lure.analysis.certificates.riccati import Rounded
from lure.analysis.theorems.table import Upper
from lure.analysis.verdict import Bracket, CriterionResult
from lure.classes import Sector
from lure.extensions import extension
from lure.plants.block import StructuredPlant

Draft = dict[str, Any]


class Theory(Protocol):
    """What is known of one structured plant; its room registers a function of the plant that makes it, as ``theory``.

    A draft is a certificate without what the checker fills in: nothing is proved before it has accepted that.
    """

    critical: bool  # whether the plant has a pole at 0
    argument: str  # the proof by structure of the largest class, in words

    def inequality(self, criterion: str, sector: Sector, theta: float | None = None) -> CriterionResult:
        """What a criterion says of one sector, with a multiplier [s] or the best one."""

    def largest(self, criterion: str) -> CriterionResult:
        """The largest sector ``[0, k]`` of a criterion; ``AssumptionError`` where it is none for the plant."""

    def hurwitz(self) -> Bracket:
        """The supremum of the stable linear gains."""

    def drafts(self, answer: CriterionResult, upper: Upper | None) -> Iterator[tuple[Upper, Draft]]:
        """Proofs of what a criterion answered, each with the upper end of its class; the largest class first."""

    def proof(self) -> Draft:
        """The proof by structure of the largest class; ``AssumptionError`` where a hypothesis fails."""

    def refutation(self) -> Draft | None:
        """The refutation of every class by structure; None where there is none."""

    def thetas(self) -> Iterator[Fraction]:
        """Popov multipliers [s] worth a try in a proof by matrices."""

    def matrices(self, theta: Fraction) -> Iterator[Rounded]:
        """Matrices ``P`` worth a try with a multiplier."""


def theory_of(plant: StructuredPlant) -> Theory:
    """The theory of a plant.

    Raises
    ------
    TypeError
        No room says what is known of it.
    """
    made = extension("theory", plant)
    if made is None:
        raise TypeError(f"nothing is registered as the theory of a {type(plant).__name__}")
    theory: Theory = made(plant)
    return theory
