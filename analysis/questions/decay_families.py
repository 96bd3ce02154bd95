"""Rates of decay for every plant of a box of parameters: the circle criterion on boxes, and one slower plant."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, partial
from itertools import islice
from typing import Any

from lure.analysis.certificates.blocks import paced
from lure.analysis.certificates.checker import Proved, Refuted
from lure.analysis.certificates.systems import class_entry, system_of
from lure.analysis.inequality.box_polynomials import poles
from lure.analysis.questions import families
from lure.analysis.questions.decay_channels import accepted
from lure.analysis.questions.problem import Problem
from lure.analysis.theorems.table import row_of
from lure.analysis.theorems.weighted import WeightedCircle
from lure.analysis.wording import class_words, plants_words
from lure.arrays import np, optimize
from lure.classes import Diagonal
from lure.errors import AssumptionError, InputError
from lure.plants.family import PlantFamily, Point, Term
from lure.plants.rational import RationalPlant

_GAINS, _CORNERS = 9, 16


@dataclass
class BoxOfPlants:
    """The searches for one nonlinearity and plants with parameters, at a rate.

    Attributes
    ----------
    asked : Problem
        The question, about a ``PlantFamily`` and a class with finite bounds.
    """

    asked: Problem
    close = Fraction(1, 10**4)

    def __post_init__(self) -> None:
        own = self.asked.nonlinearity_class
        if math.inf in map(abs, (own.sector.lower, own.sector.upper)):
            raise InputError(
                f"the class {own} has no uniform rate without finite bounds; give a sector with two numbers"
            )
        if self.asked.refusals or self.asked.untested or self.asked.rough:
            raise InputError("with parameters rates are shown of classes of locally Lipschitz nonlinearities")

    @property
    def plants(self) -> PlantFamily:
        """The plants."""
        assert isinstance(self.asked.plant, PlantFamily), "made for those"
        return self.asked.plant

    @property
    def discrete(self) -> bool:
        """Whether in discrete time."""
        return self.plants.dt is not None

    @cached_property
    def base(self) -> dict[str, Any]:
        """What all drafts have in common."""
        return {"system": system_of(self.plants), "laws": class_entry(self.asked.nonlinearity_class, unbounded=True)}

    @property
    def classes(self) -> Diagonal:
        """The class."""
        return Diagonal((self.asked.nonlinearity_class,))

    @property
    def words(self) -> str:
        """The class and the box in words."""
        return class_words(self.base["laws"]) + plants_words(self.base["system"])

    def prove(self, rate: Fraction) -> Proved | None:
        """What is accepted of a rate."""
        own, weighted = self.asked.nonlinearity_class.sector, self._weighted(rate)
        search = families.Search(weighted, row_of("circle", weighted))
        try:
            tree = search.tree(self.base["laws"], Fraction(own.lower), Fraction(own.upper))
        except AssumptionError:
            return None
        draft = families.draft(self.plants, search.row, self.base["laws"], tree)
        found = accepted({**draft, "rate": str(rate)})
        return found if isinstance(found, Proved) else None

    def expected(self, easy: Fraction, hard: Fraction) -> float:
        """Where the circle criterion seems to end, between two rates, for the worst of some plants."""
        low, high = (Fraction(end) for end in self.asked.nonlinearity_class.gains)
        points = (self.plants.middle, *islice(self.plants.corners, _CORNERS))
        ends = [end_of(WeightedCircle(plant=self.plants.at(p), lower=low, upper=high), easy, hard) for p in points]
        return max(ends) if self.discrete else min(ends)

    def _weighted(self, rate: Fraction) -> PlantFamily:
        """The plants of the solutions times ``e^(a t)``, or ``r^-t``."""
        turned = paced(self.base["system"], rate)
        terms = list[Term]()
        for one in turned["terms"]:
            top, bottom = (tuple(map(Fraction, one[side])) for side in ("numerator", "denominator"))
            terms.append((tuple(one["powers"]), top, bottom))
        step = True if self.plants.any_period else self.plants.dt
        return PlantFamily(dict(zip(self.plants.names, self.plants.box, strict=True)), terms, step)

    @cached_property
    def _slowest(self) -> tuple[Point, Fraction, float]:
        """A plant and a constant gain with the slowest mode found, and its rate in floating point."""
        low, high = (Fraction(end) for end in self.asked.nonlinearity_class.gains)
        gains = [low + (high - low) * Fraction(i, _GAINS - 1) for i in range(_GAINS)]
        found = [(families.least(self.plants, partial(self._rate, gain)), gain) for gain in gains]
        ((point, rate), gain) = min(found, key=lambda one: one[0][1])
        return point, gain, rate

    def _rate(self, gain: Fraction, plant: RationalPlant) -> float:
        """How fast the loop with a constant gain decays: the more the better."""
        roots = poles(plant, gain)
        return float(-np.max(np.abs(roots) if self.discrete else roots.real, initial=-math.inf))

    @property
    def slowest(self) -> tuple[float, Fraction]:
        """The rate of the slowest constant gain, in floating point, and the gain."""
        _, gain, rate = self._slowest
        return (-rate if self.discrete else rate), gain

    @property
    def fastest(self) -> float:
        """A rate that no proof exceeds, where no gain has one: nothing is then proved."""
        return 0.0

    def refute(self, rate: Fraction) -> Refuted | None:
        """What is accepted against a rate."""
        point, gain, _ = self._slowest
        inner = {"proof": {"method": "linear-gain", "gain": str(gain)}}
        draft = {**families.member_draft(self.plants, point, inner), **self.base}
        draft |= {"verdict": "REFUTED", "theorem": "counterexample"}
        found = accepted({**draft, "rate": str(rate)}) if rate else accepted(draft) or accepted({**draft, "rate": "0"})
        return found if isinstance(found, Refuted) else None

    @property
    def patterns(self) -> Iterator[tuple[Fraction, dict[str, Any]]]:
        """Gains that jump are not looked at."""
        return iter(())

    def by_multipliers(self, _end: Fraction | None, _known: Fraction | None) -> Iterator[tuple[Fraction, Proved]]:
        """Zames-Falb multipliers are not looked at."""
        return iter(())

    def lasting(self) -> None:
        """Members that do not decay, but for constant gains, are not looked at."""


def end_of(circle: WeightedCircle, easy: Fraction, hard: Fraction) -> float:
    """Where the circle criterion seems to end for one plant, between two rates, on the side that it serves.

    Parameters
    ----------
    circle : WeightedCircle
        The criterion.
    easy, hard : Fraction
        The rates.
    """
    ends = float(easy), float(hard)
    if circle.margin(ends[0]) <= 0:
        return ends[0]
    if circle.margin(ends[1]) > 0:
        return ends[1]
    return float(optimize.brentq(lambda rate: max(circle.margin(rate), -1.0), *ends, xtol=1e-14, rtol=1e-12))
