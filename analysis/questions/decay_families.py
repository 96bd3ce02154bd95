"""Decay rates of one nonlinearity around a rational plant, or around every plant of a box of parameters.

What is proved at a rate, and slower members; of boxes by the circle and Popov's criterion, and one slower plant.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, partial
from itertools import islice, product
from typing import Any

from lure.analysis.certificates.blocks import paced
from lure.analysis.certificates.checker import Proved, Refuted
from lure.analysis.certificates.drafts import guarded
from lure.analysis.certificates.systems import texts
from lure.analysis.counterexamples.channel_gains import GainsAround
from lure.analysis.counterexamples.scaled_orbits import ScaledOrbits
from lure.analysis.inequality.box_polynomials import poles
from lure.analysis.inequality.gains import simplest_between
from lure.analysis.questions import channel_families, families
from lure.analysis.questions.channel_problem import channel_problem
from lure.analysis.questions.counterexample_search import counterexample
from lure.analysis.questions.decay_channels import (
    RateSearch,
    SeveralChannels,
    accepted,
    jumps,
    require_bounds,
    require_states,
)
from lure.analysis.questions.problem import Problem, by_matrices
from lure.analysis.questions.worst_plants import least
from lure.analysis.theorems.table import row_of
from lure.analysis.theorems.weighted import WeightedCircle, WeightedKernels, WeightedTaps, closest
from lure.analysis.theorems.zames_falb_discrete import NAME as ZAMES_FALB
from lure.arrays import Reals, np, optimize
from lure.errors import AssumptionError, InputError
from lure.plants.channel_family import ChannelFamily
from lure.plants.channel_family import Term as ChannelTerm
from lure.plants.conversion import rational_if_moderate
from lure.plants.family import PlantFamily, Point, Term
from lure.plants.multivariable import MultivariablePlant
from lure.plants.parameters import Box
from lure.plants.rational import RationalPlant

_GAINS, _CORNERS, _VERTICES = 9, 16, 64
_BACK, _STEPS = 1e-4, (1e-4, 1e-3, 1e-2, 0.1, 0.5)  # relative: from what is refuted, and from where a theorem ends
CLOSE = Fraction(1, 10**6)  # where the bisection ends, relative to the rate of the slowest gain, or to 1
_SLACK = (1e-6, 5e-6, 2e-5, 1e-4, 1e-3, 1e-2)
_GRID, _ROUNDS = 129, 6


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
        """What is accepted against a rate."""
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


def require_known(asked: Problem) -> None:
    """Refuse a nonlinearity whose class is not known.

    Raises
    ------
    InputError
        The class is not known.
    """
    if asked.refusals or asked.untested or asked.rough:
        why = next((one.detail for one in asked.refusals), "it is not known to be locally Lipschitz")
        raise InputError(f"decay rates are shown of nonlinearities whose class is known: {why}")


@dataclass
class OneChannel(RateSearch):
    """The searches for one nonlinearity, at a rate."""

    close = CLOSE

    def __post_init__(self) -> None:
        plant, own = rational_if_moderate(self.asked.plant), self.asked.nonlinearity_class
        long = plant is not self.asked.plant and isinstance(plant, RationalPlant) and by_matrices(plant) is not None
        if not isinstance(plant, RationalPlant) or long:
            raise InputError(
                "decay rates are shown of rational plants of moderate order, and of such with dead time, and this one "
                "is none; lure certify and lure max-sector decide whether the loop is stable"
            )
        require_known(self.asked)
        require_states(plant.order)
        self.asked = replace(self.asked, plant=plant)
        require_bounds(own)

    @cached_property
    def plant(self) -> RationalPlant:
        """The plant."""
        plant = self.asked.plant
        assert isinstance(plant, RationalPlant), "looked at when it was made"
        return plant

    def prove(self, rate: Fraction) -> Proved | None:
        """What is accepted of a rate."""
        linear = self.asked.nonlinearity_class.linear and not self.asked.time_varying
        theorem = {"theorem": "hurwitz" if linear else "circle", "proof": {"method": "polynomial"}}
        found = accepted({"verdict": "PROVED", **self.base, **theorem, "rate": str(rate)})
        return found if isinstance(found, Proved) else None

    def expected(self, easy: Fraction, hard: Fraction) -> float:
        """Where the circle criterion seems to end between a rate that it serves and another, on the side it serves."""
        own = self.asked.nonlinearity_class
        low, high = (Fraction(end) for end in own.gains)
        if own.linear and not self.asked.time_varying:
            return float(hard)
        return end_of(WeightedCircle(plant=self.plant, lower=low, upper=high), easy, hard)

    @cached_property
    def multipliers(self) -> WeightedTaps | WeightedKernels | None:
        """The search for Zames-Falb multipliers; None where the class has no slope bounds."""
        own = self.asked.nonlinearity_class
        if own.slope is None or own.time_varying or own.linear:
            return None
        low, high = Fraction(own.slope.lower), Fraction(own.slope.upper)
        search = WeightedTaps if self.discrete else WeightedKernels
        return search(plant=self.plant, lower=low, width=high - low, odd=own.odd)

    @property
    def patterns(self) -> Iterator[tuple[Fraction, dict[str, Any]]]:
        """Rates that a gain that jumps seems to have, and its proofs."""
        own = self.asked.nonlinearity_class
        ends = tuple(Fraction(end) for end in own.gains)
        plant, varying = MultivariablePlant.of_one_channel(self.plant), own.time_varying and not own.linear
        for rate, rows, proof in jumps(plant, ((ends[0],), (ends[1],)), (varying,), [range(1)], self.slowest[0]):
            yield rate, {"method": "switched-gain", "gains": [str(ends[row[0]]) for row in rows]} | proof

    def rescaled(self, known: float, most: float) -> Iterator[tuple[Fraction, dict[str, Any]]]:
        """Rates between two, and their proofs, by solutions that repeat on another scale."""
        own = self.asked.nonlinearity_class
        if not self.discrete or own.slope is None or own.time_varying or own.linear or self.plant.feedthrough:
            return
        if math.inf in map(abs, (own.slope.lower, own.slope.upper)):
            return
        low, high = Fraction(own.slope.lower), Fraction(own.slope.upper)
        for one in ScaledOrbits(self.plant, low, high, own.odd).better(known, most):
            sides = {"u": texts(one.u), "sigma": texts(one.sigma)}
            yield one.rate, {"method": "orbit", "scale": str(one.scale)} | sides

    def lasting(self) -> Refuted | None:
        """A member with a solution that does not decay, no constant gain; None if none is found."""
        found = guarded("counterexamples", partial(counterexample, self.asked, "rationals"), passing=(TimeoutError,))
        return found if isinstance(found, Refuted) else None

    def by_multipliers(self, end: Fraction | None, known: Fraction | None) -> Iterator[tuple[Fraction, Proved]]:
        """What Zames-Falb multipliers prove, better than what is known; beyond ``end`` nothing is true.

        Of a sector alone it is Popov's terms, of a loop with one channel among several.

        ``end``, ``known``: what no rate exceeds, and what is proved.
        """
        search, discrete = self.multipliers, self.discrete
        own, D = self.asked.nonlinearity_class, self.plant.feedthrough
        if search is None and not (discrete or own.time_varying or own.linear or D):
            several = channel_problem(MultivariablePlant.of_one_channel(self.plant), [own])
            yield from SeveralChannels(several).by_multipliers(end, known)
        if search is None or (end is None and not discrete):
            return
        best, one = float(end or 0), 1.0 if discrete else 0.0
        close = float(CLOSE) * (max(best, 1e-3) if discrete else best)
        easy = float(known) if known is not None else one + 1e-6 * (best - one)
        if not abs(easy - best) > close or (best >= 1 if discrete else best <= 0):
            return
        found = closest(search, best, easy, close, proved=known is not None)
        if found is None:
            return
        reached, size = found
        for step in _SLACK:
            ends = sorted(Fraction(reached + (easy - reached) * part) for part in (step, 1.5 * step))
            rate = simplest_between(*ends)
            multiplier = search.multiplier(float(rate), size)
            if multiplier is not None:
                theorem = {"theorem": ZAMES_FALB, "multiplier": multiplier, "proof": {"method": "polynomial"}}
                shown = accepted({"verdict": "PROVED", **self.base, **theorem, "rate": str(rate)})
                if isinstance(shown, Proved):
                    yield rate, shown
                    return

    @cached_property
    def slowest(self) -> tuple[float, Fraction]:
        """The rate of the slowest constant gain, in floating point, and the gain."""
        low, high = (Fraction(end) for end in self.asked.nonlinearity_class.gains)
        n, d = self.plant.numerator, self.plant.denominator
        top, bottom = [np.array([float(c) for c in side]) for side in (n, d)]
        top = np.concatenate([np.zeros(len(bottom) - len(top)), top])

        def slowness(gains: Reals) -> Reals:
            """The spectral abscissa or radius; infinite where the loop has no solution."""
            p = bottom + gains[:, None] * top
            lost = np.abs(p[:, 0]) <= 1e-14 * np.abs(p).max(axis=1)
            companion = np.zeros((len(gains), len(d) - 1, len(d) - 1))
            companion[:, 1:, :-1] = np.eye(len(d) - 2)
            companion[:, 0] = -p[:, 1:] / np.where(lost, 1.0, p[:, 0])[:, None]
            roots = np.linalg.eigvals(companion)
            values = np.max(np.abs(roots) if self.discrete else roots.real, axis=1, initial=-math.inf)
            return np.where(lost, math.inf, values)

        left, right, best, gain = float(low), float(high), -math.inf, float(low)
        for _ in range(_ROUNDS):
            grid = np.linspace(left, right, _GRID)
            values = slowness(grid)
            i = int(np.argmax(values))
            if values[i] > best:
                best, gain = float(values[i]), float(grid[i])
            left, right = grid[max(i - 1, 0)], grid[min(i + 1, _GRID - 1)]
        at_ends = slowness(np.array([float(low), float(high)]))
        as_slow = (g for g, v in zip((low, high), at_ends, strict=True) if v >= best - 1e-12 * abs(best))
        exact = next(as_slow, min(max(Fraction(gain), low), high))
        return (best if self.discrete else -best), exact

    def refute(self, rate: Fraction) -> Refuted | None:
        """What is accepted against a rate."""
        return self.refuted_by(rate, {"method": "linear-gain", "gain": str(self.slowest[1])})
