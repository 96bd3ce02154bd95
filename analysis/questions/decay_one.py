"""Decay rates of one nonlinearity around a rational plant: what is proved at a rate, and slower members."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, partial
from typing import Any

from lure.analysis.certificates.checker import Proved, Refuted
from lure.analysis.certificates.drafts import guarded
from lure.analysis.certificates.systems import texts
from lure.analysis.counterexamples.scaled_orbits import ScaledOrbits
from lure.analysis.inequality.gains import simplest_between
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
from lure.analysis.questions.decay_families import end_of
from lure.analysis.questions.problem import Problem, by_matrices
from lure.analysis.theorems.weighted import WeightedCircle, WeightedKernels, WeightedTaps, closest
from lure.analysis.theorems.zames_falb_discrete import NAME as ZAMES_FALB
from lure.arrays import Reals, np
from lure.errors import InputError
from lure.plants.conversion import rational_if_moderate
from lure.plants.multivariable import MultivariablePlant
from lure.plants.rational import RationalPlant

CLOSE = Fraction(1, 10**6)  # where the bisection ends, relative to the rate of the slowest gain, or to 1
_SLACK = (1e-6, 5e-6, 2e-5, 1e-4, 1e-3, 1e-2)
_GRID, _ROUNDS = 129, 6


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
        """What is accepted against a rate.

        Parameters
        ----------
        rate : Fraction
            The rate.
        """
        return self.refuted_by(rate, {"method": "linear-gain", "gain": str(self.slowest[1])})
