"""The search for self-oscillating loops with saturations and dead zones, in floating point: proposals, never proofs."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from analysis.refutation.following import Orbit, followed, settled
from analysis.refutation.harmonic import HarmonicBalance
from analysis.refutation.piecewise import PiecewiseLoop, saturation
from analysis.refutation.realisation import Realisation, doubles
from analysis.refutation.relay import Reals, RelayOrbit, RelayOrbits
from lure.errors import InputError

Slopes = Callable[[Fraction], tuple[Fraction, Fraction]]

STEEP = 1e4
RUNGS = 8
MISSES = 3
ROUGH = 2e-3
FINE = 2e-5
SHARES = (0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5)


@dataclass(frozen=True, slots=True)
class Oscillation:
    """A law with kinks at ``y = -1`` and ``y = 1`` and an orbit of its loop.

    Attributes
    ----------
    slopes : callable
        Slope between the kinks and slope outside them, for the value of a parameter.
    parameter : float
        The value at which the orbit is given.
    orbit : Orbit
        The orbit.
    """

    slopes: Slopes
    parameter: float
    orbit: Orbit

    @property
    def top(self) -> float:
        """The larger slope."""
        return float(max(self.slopes(Fraction(self.parameter))))


@dataclass(frozen=True, slots=True)
class OrbitSearch:
    """The search for one block without feedthrough.

    Attributes
    ----------
    system : Realisation
        The block.
    lower : Fraction
        Least slope.
    limit : float
        Slopes at or above it are not wanted.
    start : float
        Slopes at or below it are not worth a search.
    numerator, denominator : ndarray
        Of the block, descending powers.
    """

    system: Realisation
    lower: Fraction
    limit: float
    start: float
    numerator: Reals
    denominator: Reals

    def candidates(self) -> list[Oscillation]:
        """Orbits with the larger slope below the limit, smallest first."""
        found = list(self.saturations())
        found += self.balanced(min([self.limit, *(o.top for o in found)]))
        found = sorted((o for o in found if o.top < self.limit), key=lambda o: o.top)
        return sorted([*(self.improved(o) for o in found[:2]), *found], key=lambda o: o.top)

    def loop(self, slopes: Slopes, parameter: float) -> PiecewiseLoop:
        """The loop for a value of the parameter."""
        inner, outer = slopes(Fraction(parameter))
        return PiecewiseLoop.of(self.system, saturation(inner, outer))

    def follow(
        self, slopes: Slopes, start: float, orbit: Orbit, until: float, *, accuracy: float = ROUGH
    ) -> Oscillation | None:
        """The orbit at the smallest parameter it can be followed to."""
        found = followed(lambda p: self.loop(slopes, p), start, orbit, until=until, accuracy=accuracy)
        return None if found is None else Oscillation(slopes, found.parameter, found.orbit)

    def saturations(self) -> Iterator[Oscillation]:
        """Saturations with the slope ``lower`` outside, from relays on."""
        floor = float(self.lower)
        for counts in (((1, True), (2, False), (3, True)), ((5, True),)):
            any_found = False
            for relay in self.relays(floor, counts):
                for steep in (STEEP, 30.0):
                    size = floor + steep * max(1.0, self.start - floor)
                    begin = steepened(relay, size - floor, self.closed(floor), self.row)
                    found = self.follow(lambda p: (p, self.lower), size, begin, floor)
                    if found is not None:
                        any_found = any_found or found.top < self.limit
                        yield found
                        break
            if any_found:
                return

    def balanced(self, below: float) -> Iterator[Oscillation]:
        """Saturations and dead zones from harmonic balance, at ever smaller slopes, as long as any are found."""
        floor = float(self.lower)
        reach = self.start - floor if self.start > floor else 1e-3 * (min(below, 1.0) - floor)
        bounded = below < math.inf
        size, misses, shrink = (below - floor if bounded else 1e4 * reach) * 0.97, 0, 0.7 if bounded else 0.2
        for _ in range(RUNGS):
            found = list(self.balanced_at(floor + size))
            yield from found
            best = min((o.top - floor for o in found), default=math.inf)
            misses = 0 if best < size else misses + 1
            size = 0.97 * best if best < size else shrink * size
            if misses == MISSES or size < reach:
                return

    def balanced_at(self, k: float) -> Iterator[Oscillation]:
        """The same with the larger slope ``k``, followed from there."""
        floor = float(self.lower)
        families = [((k, floor), lambda p: (p, self.lower)), ((floor, k), lambda p: (self.lower, p))]
        for ends, slopes in families:
            balance = HarmonicBalance(self.numerator, self.denominator, ends)
            for wave in balance.solutions()[:8]:
                guess = balance.orbit(wave)
                if guess is not None and guess.adjacent(2):
                    found = self.follow(slopes, k, guess, floor)
                    if found is not None:
                        yield found

    def relays(self, gain: float, counts: tuple[tuple[int, bool], ...]) -> Iterator[RelayOrbit]:
        """Relay orbits of the loop with a gain taken out, at most four for every number of switches."""
        search = RelayOrbits(self.closed(gain), np.array([float(v) for v in self.system.b]), self.row)
        for count, half in counts:
            yield from search.with_switches(count, half=half)[:4]

    @property
    def row(self) -> Reals:
        """``c``."""
        return np.array([float(v) for v in self.system.c])

    def closed(self, gain: float) -> Reals:
        """``A - b c gain``."""
        return doubles(self.system.closed(Fraction(gain)))

    def improved(self, found: Oscillation) -> Oscillation:
        """The same orbit with the smaller slope raised by a share of the difference, if that lowers the larger."""
        fine = self.follow(found.slopes, found.parameter, found.orbit, float(self.lower), accuracy=FINE)
        best = found if fine is None or fine.top > found.top else fine
        inner, _ = found.slopes(Fraction(found.parameter))
        steep_inside = float(inner) == found.top
        for share in SHARES:
            slopes = self.shared(Fraction(share), steep_inside=steep_inside)
            try:
                orbit = settled(self.loop(slopes, best.top * 1.03), best.orbit)
            except InputError:
                break
            if orbit is None:
                break
            trial = self.follow(slopes, best.top * 1.03, orbit, float(self.lower), accuracy=FINE)
            if trial is None or trial.top >= best.top:
                break
            best = trial
        return best

    def shared(self, share: Fraction, *, steep_inside: bool) -> Slopes:
        """Slopes ``p`` and ``lower + share (p - lower)``."""

        def slopes(p: Fraction) -> tuple[Fraction, Fraction]:
            """Slope inside and outside of the kinks."""
            flat = self.lower + share * (p - self.lower)
            return (p, flat) if steep_inside else (flat, p)

        return slopes


def steepened(relay: RelayOrbit, gain: float, A: Reals, c: Reals) -> Orbit:
    """The orbit a relay's turns into with the slope ``gain`` between ``y = -1`` and ``y = 1`` in place of the jump."""
    stays = [2 / (gain * abs(float(c @ (A @ z)))) for z in relay.states]
    state = gain * relay.states[0]
    pieces: list[int] = []
    durations: list[float] = []
    for i, (stay, time) in enumerate(zip(stays, relay.times, strict=True)):
        pieces += [1, 2 if i % 2 == 0 else 0]
        durations += [stay, max(time - stay, time / 2)]
    return Orbit(tuple(pieces), state - A @ state * (stays[0] / 2), np.array(durations), relay.half)
