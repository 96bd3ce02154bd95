"""Popov's inequality of a rational block as polynomials in ``x = omega^2``, with the exact tests that decide it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from flint import fmpq

from analysis.criteria.checks import check_plant
from analysis.doubles import double_above, double_below
from analysis.evidence import INFINITE, Bracket
from analysis.multiplier_search import Cut, Found, search
from analysis.plant import Plant
from analysis.polynomial import positive_from_zero, to_fmpq, to_fraction
from analysis.polynomial_family import PolynomialFamily
from lure.errors import AssumptionError
from lure.rational import RationalBlock

TRIES = 100
CONCLUSION = "0 is globally asymptotically stable for every law of the class"


@dataclass(frozen=True, slots=True)
class Reach:
    """How far a multiplier goes: every finite ``k`` if ``found`` is None.

    ``theta`` is infinite, and no multiplier, where each finite ``k`` needs a larger one; None if none was certified.
    """

    theta: Fraction | float | None
    found: Found | None = None


@dataclass(frozen=True, slots=True)
class PopovInequality:
    """``1/k + Re[(1 + i omega theta) H] > 0`` on ``[0, inf]`` for the shifted block, ``k = upper - lower``."""

    plant: Plant
    lower: Fraction
    family: PolynomialFamily

    @classmethod
    def of(cls, block: RationalBlock, lower: Fraction, criterion: str = "Popov's criterion") -> PopovInequality:
        """The inequality of a block.

        Raises
        ------
        AssumptionError
            The block is in discrete time, or the shifted block is neither stable nor critical.
        """
        if isinstance(block, RationalBlock) and block.dt is not None:
            raise AssumptionError(
                f"{criterion} is about continuous time, and the block has dt = {float(block.dt):g} s; ask for "
                "circle, tsypkin or zames-falb instead"
            )
        plant = check_plant(block, lower=lower)
        h = plant.hidden
        visible = Plant(block, plant.n // h, plant.d // h, h // h, plant.degree - h.degree())
        response = visible.response()
        return cls(plant, lower, PolynomialFamily(response.D, response.U, response.W))

    @classmethod
    def of_stable(cls, block: RationalBlock, lower: Fraction, criterion: str) -> PopovInequality:
        """The inequality for a criterion that does not cover the critical case.

        Raises
        ------
        AssumptionError
            As :meth:`of`, or the shifted block has a pole at 0.
        """
        inequality = cls.of(block, lower, criterion)
        if inequality.plant.case != "stable":
            raise AssumptionError(
                f"{criterion} needs a stable block, and this one has a pole at 0; give a positive lower slope bound, "
                "or ask Popov's"
            )
        return inequality

    @property
    def direct(self) -> fmpq:
        """The direct term ``D`` of the shifted block."""
        return self.family.at_infinity.u

    def holds(self, theta: Fraction, upper: float | Fraction) -> bool:
        """Whether the inequality proves the sector ``[lower, upper]``, exactly.

        For ``upper = inf`` either ``1 + theta s`` serves ``H - D`` and the finite sector ``[0, 1/D]``, or ``D = 0``,
        ``theta >= 0`` and ``Re[..] >= eps/(1 + omega^2)``, and no mode is hidden.
        """
        p = to_fmpq(theta)
        if upper != math.inf:
            level = -1 / to_fmpq(Fraction(upper) - self.lower)
            return bool(self.direct > level) and self.family.exceeds(p, level)
        if self.direct > 0:
            return self.family.exceeds(p, fmpq(0))
        if theta < 0 or self.direct < 0 or self.plant.hidden.degree() > 0:
            return False
        least = self.family.level(p, fmpq(0))
        return positive_from_zero(least) and least.degree() >= self.family.D.degree() - 1

    def reach(self, *, nonnegative: bool = False) -> Reach:
        """The best multiplier, and how far it goes."""
        cuts = [*self.family.first_cuts(), Cut(self.direct, fmpq(0))]  # 1 + k D > 0, or the loop may have no solution
        if self.direct >= 0:
            theta = self.family.everywhere(cuts, nonnegative=nonnegative)
            if theta is not None:
                return Reach(to_fraction(theta))
            if all(cut.w >= 0 for cut in cuts) and self.family.rises_for_ever():
                return Reach(math.inf)
            if not nonnegative and all(cut.w <= 0 for cut in cuts) and self.family.mirrored.rises_for_ever():
                return Reach(-math.inf)
        found = search(self.family, cuts, self.level_of_a_double, nonnegative=nonnegative)
        return Reach(None if found.theta is None else to_fraction(found.theta), found)

    def serving(self, best: Reach, upper: float | Fraction) -> Fraction:
        """A multiplier for ``[lower, upper]``, from the best one."""
        if best.theta is None:
            return Fraction(0)
        candidates: list[Fraction]
        if isinstance(best.theta, float):
            start = Fraction(1 if best.theta > 0 else -1)
            candidates = [start * Fraction(4) ** power for power in range(-8, TRIES)]
        else:
            start = best.theta
            candidates = [start * Fraction(c) for c in ("1", "9/8", "2", "7/8")] if start else [start, Fraction(1)]
        return next((theta for theta in candidates if self.holds(theta, upper)), start)

    def largest(self, best: Reach) -> Bracket:
        """How far that is: the largest ``upper`` as a bracket, both ends exact statements."""
        if best.found is None:
            return INFINITE
        top = to_fraction(best.found.summit.value)
        high = double_above(self.lower - 1 / top) if top < 0 else math.inf
        if best.theta is None:
            return Bracket(double_below(self.lower), high)
        return Bracket(double_below(self.lower - 1 / to_fraction(best.found.level)), high)

    def level_of_a_double(self, level: fmpq) -> fmpq:
        """A level not above a negative one that belongs to a double ``lower - 1/level``, where there is one."""
        upper = Fraction(double_below(self.lower - 1 / to_fraction(level)))
        return -1 / to_fmpq(upper - self.lower) if upper > self.lower else level
