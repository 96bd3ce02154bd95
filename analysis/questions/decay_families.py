"""Rates of decay for every plant of a box of parameters: circle and Popov's criterion on boxes, one slower plant."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, partial
from itertools import islice, product

from lure.analysis.certificates.blocks import paced
from lure.analysis.certificates.checker import Proved, Refuted
from lure.analysis.certificates.systems import texts
from lure.analysis.counterexamples.channel_gains import GainsAround
from lure.analysis.inequality.box_polynomials import poles
from lure.analysis.inequality.gains import simplest_between
from lure.analysis.questions import channel_families, families
from lure.analysis.questions.channel_problem import channel_problem
from lure.analysis.questions.decay_channels import RateSearch, SeveralChannels, accepted, require_bounds
from lure.analysis.questions.worst_plants import least
from lure.analysis.theorems.table import row_of
from lure.analysis.theorems.weighted import WeightedCircle
from lure.arrays import np, optimize
from lure.errors import AssumptionError, InputError
from lure.plants.channel_family import ChannelFamily
from lure.plants.channel_family import Term as ChannelTerm
from lure.plants.family import PlantFamily, Point, Term
from lure.plants.multivariable import MultivariablePlant
from lure.plants.parameters import Box
from lure.plants.rational import RationalPlant

_GAINS, _CORNERS, _VERTICES = 9, 16, 64
_BACK, _STEPS = 1e-4, (1e-4, 1e-3, 1e-2, 0.1, 0.5)  # relative: from what is refuted, and from where a theorem ends


@dataclass
class BoxOfPlants(RateSearch):
    """The searches for one nonlinearity with finite bounds and plants with parameters, a ``PlantFamily``, at a rate."""

    def __post_init__(self) -> None:
        own = self.asked.nonlinearity_class
        require_bounds(own)
        if self.asked.refusals or self.asked.untested or self.asked.rough:
            raise InputError("with parameters rates are shown of classes of locally Lipschitz nonlinearities")
        if self.plants.delay:
            raise InputError(
                "with parameters no rate is shown beside a dead time; give each parameter one number, or ask lure "
                "max-sector"
            )

    @property
    def plants(self) -> PlantFamily:
        """The plants."""
        assert isinstance(self.asked.plant, PlantFamily), "made for those"
        return self.asked.plant

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
        ends = [
            end_of(WeightedCircle(plant=self.plants.undelayed(p), lower=low, upper=high), easy, hard) for p in points
        ]
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
        found = [(least(self.plants, partial(self._rate, gain)), gain) for gain in gains]
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

    def refute(self, rate: Fraction) -> Refuted | None:
        """What is accepted against a rate."""
        point, gain, _ = self._slowest
        inner = {"proof": {"method": "linear-gain", "gain": str(gain)}}
        return self.refuted_by(rate, families.member_draft(self.plants, point, inner)["proof"])

    def by_multipliers(self, end: Fraction | None, known: Fraction | None) -> Iterator[tuple[Fraction, Proved]]:
        """What Popov's terms prove of the plants as ones of several channels, better than what is known."""
        own = self.asked.nonlinearity_class
        if end is None or self.discrete or own.time_varying or own.linear:
            return
        several = BoxOfChannels(channel_problem(self.plants.channels, [own]))
        for rate, shown in several.proofs(end):
            if known is None or rate > known:
                yield rate, shown


@dataclass
class BoxOfChannels(RateSearch):
    """The searches for several nonlinearities and plants with parameters, a ``ChannelFamily``, at a rate."""

    def __post_init__(self) -> None:
        self.require_functions()
        self.theorem = channel_families.criteria(self.asked)[0]

    @property
    def plants(self) -> ChannelFamily:
        """The plants."""
        return channel_families.family_of(self.asked)

    def _search(self, rate: float | Fraction) -> channel_families.BoxSearch:
        """That for the plants of the solutions times ``e^(a t)``, or ``r^-t``."""
        exact, terms = Fraction(rate), list[ChannelTerm]()
        for one in paced(self.base["system"], exact)["terms"]:
            A, B, C, D = (tuple(tuple(map(Fraction, row)) for row in one[side]) for side in "ABCD")
            terms.append(ChannelTerm(tuple(one["powers"]), Fraction(one["common"]), A, B, C, D))
        bounds, step = dict(zip(self.plants.names, self.plants.box, strict=True)), self.plants.dt
        family = ChannelFamily(bounds, terms, True if self.plants.any_period else step, self.plants.rates)
        return channel_families.BoxSearch(replace(self.asked, plant=family), self.theorem, exact)

    def proofs(self, end: Fraction | None) -> Iterator[tuple[Fraction, Proved]]:
        """A rate that is proved, near to where the theorem ends at the worst of some plants; better ones last.

        ``end``: a rate that is refuted.
        """
        neutral, best = Fraction(int(self.discrete)), self.fastest if end is None else float(end)
        outward = max(abs(best), 1e-3) * (1 if self.discrete else -1)
        easier = [float(neutral) + part * outward for part in (0, 1, 16, 256)]
        points = [self._slowest[0], self.plants.middle, *islice(self.plants.corners, 2 * _CORNERS)]
        best += (_BACK if best < neutral or not self.discrete else 0.0) * outward
        for point in dict.fromkeys(points):
            at = channel_families.place_of(self.plants, point)

            def serves(rate: float, at: Box = at) -> bool:
                """Whether the search finds a proof of the rate for a box of parameters."""
                return (rate > 0 or not self.discrete) and self._search(rate).serves(at)

            if serves(best):
                continue
            easy = next((rate for rate in easier if abs(rate - best) > 0 and serves(rate)), None)
            if easy is None:
                return
            while abs(easy - best) > float(self.close) / 4 * max(abs(easy), abs(best)):
                middle = (easy + best) / 2
                easy, best = (middle, best) if serves(middle) else (easy, middle)
            best = easy
        for step in _STEPS:
            rate = simplest_between(
                *sorted(Fraction(best + part * step * abs(outward) * (1 if self.discrete else -1)) for part in (1, 2))
            )
            search = self._search(rate)
            try:
                shown = search.accepted(Fraction(1), search.tree(Fraction(1)), self.base["system"])
            except AssumptionError:
                continue
            if shown is not None:
                yield rate, shown
                return

    @cached_property
    def _slowest(self) -> tuple[Point, Sequence[Fraction], float]:
        """A plant and constant gains with the slowest mode found, and its rate in floating point."""
        lower, upper = (
            np.array([float(v) for v in side]) for side in (self.asked.classes.lower, self.asked.classes.upper)
        )
        blocks = self.asked.classes.blocks
        shares = np.array(
            [*islice(product((0.0, 1.0), repeat=len(blocks)), _VERTICES), *np.full((1, len(blocks)), 0.5)]
        )
        gains = np.repeat(lower[None], len(shares), axis=0)
        for j, block in enumerate(blocks):
            gains[:, [*block]] += shares[:, [j]] * (upper - lower)[[*block]]

        def slowness(plant: MultivariablePlant) -> float:
            """The slowest rate over the constant gains, with its sign turned round: the least is looked for."""
            values = np.linalg.eigvals(GainsAround(*plant.doubles()).closed_by(gains))
            return -float((np.abs(values) if self.discrete else values.real).max())

        point, _ = least(self.plants, slowness)
        rate, found = SeveralChannels(replace(self.asked, plant=self.plants.at(point))).slowest
        return point, found, rate

    @property
    def slowest(self) -> tuple[float, Sequence[Fraction]]:
        """The rate of the slowest constant gains, in floating point, and the gains."""
        _, gains, rate = self._slowest
        return rate, gains

    def refute(self, rate: Fraction) -> Refuted | None:
        """What is accepted against a rate.

        Parameters
        ----------
        rate : Fraction
            The rate.
        """
        point, gains, _ = self._slowest
        inner = {"proof": {"method": "linear-gains", "gains": texts(gains)}}
        return self.refuted_by(rate, families.member_draft(self.plants, point, inner)["proof"], multiplier={})

    def by_multipliers(self, _end: Fraction | None, _known: Fraction | None) -> Iterator[tuple[Fraction, Proved]]:
        """Kernels are not looked at."""
        return iter(())


def end_of(circle: WeightedCircle, easy: Fraction, hard: Fraction) -> float:
    """Where the circle criterion seems to end for one plant, between two rates, on the side that it serves."""
    ends = float(easy), float(hard)
    if circle.margin(ends[0]) <= 0:
        return ends[0]
    if circle.margin(ends[1]) > 0:
        return ends[1]
    return float(optimize.brentq(lambda rate: max(circle.margin(rate), -1.0), *ends, xtol=1e-14, rtol=1e-12))
