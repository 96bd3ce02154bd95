"""Nonlinearities of a slope or sector with a self-oscillation though every linear gain is stable, continuous time."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from types import MappingProxyType
from typing import NamedTuple

from lure.analysis.certificates.channels import Plant
from lure.analysis.counterexamples.balance import Balance
from lure.analysis.counterexamples.channel_orbits import Found, Graphs, course, near_fold
from lure.analysis.counterexamples.graphs import pointed, shaped
from lure.analysis.counterexamples.harmonic import HarmonicBalance, Orbit, RelayOrbit, RelayOrbits, followed, settled
from lure.analysis.counterexamples.linear import Realisation, companion
from lure.analysis.counterexamples.piecewise import Itinerary, PiecewiseLoop, proved, refined, saturation
from lure.analysis.counterexamples.simulated import followed as followed_oscillation
from lure.analysis.counterexamples.switched import circle_reach
from lure.analysis.inequality.gains import KALMAN, hurwitz_limit
from lure.analysis.inequality.plant import TransferPolynomials
from lure.analysis.numerics.precision import ball, outward, working_precision
from lure.analysis.verdict import Evidence, Witness
from lure.arrays import Reals, in_doubles, np, one_thread
from lure.errors import InputError
from lure.nonlinearities.piecewise_linear import Graph
from lure.plants.rational import RationalPlant
from lure.record import described, quantity

# The search for self-oscillating loops with saturations and dead zones, in floating point: proposals, never proofs.

Slopes = Callable[[Fraction], tuple[Fraction, Fraction]]

STEEP = 1e4
RUNGS = 8
MISSES = 3
ROUGH = 2e-3
FINE = 2e-5
SHARES = (0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5)


@described(frozen=True, slots=True)
class Oscillation:
    """A nonlinearity with kinks at ``y = -1`` and ``y = 1`` and an orbit of its loop."""

    slopes: Slopes = quantity("Slope between the kinks and slope outside them, for the value of a parameter")
    parameter: float = quantity("The value at which the orbit is given")
    orbit: Orbit = quantity("The orbit")

    @property
    def top(self) -> float:
        """The larger slope."""
        return float(max(self.slopes(Fraction(self.parameter))))


@described(frozen=True, slots=True)
class OrbitSearch:
    """The search for one block without feedthrough."""

    system: Realisation = quantity("The block")
    lower: Fraction = quantity("Least slope")
    limit: float = quantity("Slopes at or above it are not wanted")
    start: float = quantity("Slopes at or below it are not worth a search")
    numerator: Reals = quantity("Of the block, descending powers")
    denominator: Reals = quantity("Of the block, descending powers")

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
        return in_doubles(self.system.closed(Fraction(gain)))

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


MAX_ORDER = 16


def oscillation_witness(
    block: RationalPlant, *, odd: bool, lower: Fraction = Fraction(0), k: Fraction | None = None
) -> Witness | None:
    r"""A piecewise-linear ``phi`` with slopes in ``[lower, k]`` whose loop has a periodic solution.

    The loop is ``sigma = H mu``, ``mu = -phi(sigma)``.  The solution's existence refutes global asymptotic stability
    for the class of all ``phi`` with slope in ``[lower, k]``; whether the solution attracts is not asked.

    Parameters
    ----------
    block : RationalPlant
        In continuous time.
    odd : bool
        Whether only odd nonlinearities are wanted.  The nonlinearities tried are odd either way: they belong to both
        classes.
    lower : Fraction
        Least slope.
    k : Fraction or None
        Largest slope allowed; None for the smallest that is found.

    Returns
    -------
    Witness or None
        CERTIFIED where Krawczyk's test proves the orbit, else COMPUTED.  ``k`` is the smallest found, not proved to be
        the smallest.  None: discrete time, order 0 or above 16, a loop that is unstable at ``lower`` or just above, or
        nothing found with ``k`` below the first unstable linear gain (a linear gain is the better witness there).

    Notes
    -----
    Relay loops, the limit of steep saturations, have orbits that follow from a few times by Newton's method.  They are
    followed from there while the slope of the saturation falls, down to the fold where they vanish.  Orbits of
    saturations and dead zones with smaller slopes come from harmonic balance with four odd harmonics and are followed
    likewise.  Feedthrough ``d`` is first absorbed: with ``y = sigma + d phi`` the block is ``H - d`` and slopes turn
    into ``s/(1 + d s)``.
    """
    witness = _smallest(block, lower)
    fits = witness is not None and (k is None or Fraction(witness.k) <= k) and (witness.odd or not odd)
    return witness if fits else None


def _gap(block: RationalPlant, lower: Fraction, least: int) -> tuple[float, float] | None:
    """Where the circle criterion and stable gains end, of orders from ``least`` on; None: nothing lies between."""
    if block.dt is not None or not least <= block.order <= MAX_ORDER:
        return None
    plant = TransferPolynomials.of(block)
    if plant.shifted(lower).poles.right > 0:
        return None
    start, stable = circle_reach(plant, lower)[0], hurwitz_limit(block, lower)
    return None if start == math.inf or stable.low <= lower else (start, stable.high)


@lru_cache(maxsize=64)
def _smallest(block: RationalPlant, lower: Fraction) -> Witness | None:
    """The witness with the smallest ``k`` found."""
    gap = _gap(block, lower, 1)
    if gap is None:
        return None
    (start, limit), system, d = gap, companion(block), block.feedthrough
    search = OrbitSearch(
        system=replace(system, d=Fraction(0)),
        lower=lower / (1 + d * lower),
        limit=absorbed(limit, float(d)),
        start=absorbed(start, float(d)),
        numerator=np.array([float(c) for c in reversed(system.c)]),
        denominator=np.array([float(c) for c in block.denominator]),
    )
    with np.errstate(all="ignore"):  # Newton's method may run off; what is not finite is dropped
        candidates = search.candidates()[:4]
    for found in candidates:
        witness = _witness(system, found)
        if witness is not None and witness.k < limit:
            return witness
    return None


_WAVES = (  # whether phi is odd, harmonics and kinks: half waves, and whole ones
    (True, tuple(range(1, 20, 2)), 2),
    (True, tuple(range(8)), 2),
    (False, tuple(range(8)), 1),
)
_RANDOM, _REACH = 40, 100.0
_POINTS = (6, 8)  # of the graph of a sector, to each side of 0
_ABOVE = (1e-4, 1e-3, 1e-2, 3e-2)  # relative, above where a periodic solution of a sector seems to end


@one_thread
def wave_witness(block: RationalPlant, *, odd: bool, lower: Fraction = Fraction(0)) -> Witness | None:
    r"""A staircase ``phi`` with slopes in ``[lower, k]``, odd or not, whose loop has a periodic solution: proved.

    By harmonic balance with the kinks and ``k`` unknown, see :mod:`lure.analysis.counterexamples.balance` and
    :mod:`lure.analysis.counterexamples.graphs`: more kinks than :func:`oscillation_witness` has, and solutions without
    half waves.

    ``block``: in continuous time; ``odd``: whether only odd nonlinearities are wanted; ``lower``: least slope.

    Returns
    -------
    Witness or None
        None if the search finds none below the smallest destabilising gain, which proves nothing.
    """
    found = [_from_waves(block, lower, i) for i, family in enumerate(_WAVES) if family[0] or not odd]
    return min((one for one in found if one is not None), key=lambda one: one.k, default=None)


class _Begun(NamedTuple):
    """A loop for a family of waves, and the largest factor of interest."""

    system: Realisation
    H: Plant
    balance: Balance
    top: float


def _begun(block: RationalPlant, lower: Fraction, family: tuple[bool, tuple[int, ...], int]) -> _Begun | None:
    """The loop for a family of waves; None where no solution is looked for."""
    gap = _gap(block, lower, KALMAN + 1)
    if gap is None:
        return None
    (start, limit), system, (odd, harmonics, kinks) = gap, companion(block), family
    A, b, c, d = [list(row) for row in system.A], [[v] for v in system.b], [list(system.c)], [[system.d]]
    inner, into, out, direct = (np.array(side, dtype=float) for side in (A, b, c, d))
    low, high = np.array([float(lower)]), np.ones(1)
    balance = Balance(inner, into, out, direct, low, high, [range(1)], [odd], harmonics, [kinks])
    return _Begun(system, Plant(A, b, c, d, discrete=False), balance, min(limit, _REACH * start))


@lru_cache(maxsize=64)
def _from_waves(block: RationalPlant, lower: Fraction, family: int) -> Witness | None:
    """The witness of the smallest ``k`` found in a family of ``_WAVES``."""
    begun, odd, best = _begun(block, lower, _WAVES[family]), _WAVES[family][0], list[Witness]()
    if begun is None:
        return None
    system, H, balance, top = begun
    for finer, wave in balance.found(_RANDOM, top, first=shaped(balance, top) if odd else ()):
        for one in near_fold(finer, wave, H, [lower], [Fraction(1)]):
            if one.alpha >= top:
                continue
            witness = _shown(system, one)
            if witness is not None:
                best.append(witness)
                break
    return min(best, key=lambda one: one.k, default=None)


@one_thread
def sector_witness(block: RationalPlant, *, lower: Fraction = Fraction(0)) -> Witness | None:
    """An odd ``phi`` in the sector ``[lower, k]``, of any slope, whose loop has a periodic solution: proved.

    See :func:`lure.analysis.counterexamples.graphs.pointed`.

    ``block``: in continuous time, with two resonances or more; for others nothing is looked for.  ``lower``: lower end
    of the sector.

    Returns
    -------
    Witness or None
        None if the search finds none below the smallest destabilising gain, which proves nothing.
    """
    begun = _begun(block, lower, _WAVES[0])
    if begun is None:
        return None
    found = [_pointed(begun, lower, count) for count in _POINTS]
    return min((one for one in found if one is not None), key=lambda one: one.k, default=None)


def _pointed(begun: _Begun, lower: Fraction, count: int) -> Witness | None:
    """The witness of the first graph through so many points to each side that is proved."""
    with np.errstate(all="ignore"):
        for wave, shares in pointed(begun.balance, begun.top, count):
            given = [(Fraction(f"{x:.9g}"), Fraction(f"{share:.6f}")) for x, share in shares]
            for step in _ABOVE:
                k = Fraction(f"{wave.alpha * (1 + step):.9g}")
                right = [(x, (lower + (k - lower) * share) * x) for x, share in given]
                points = [*((-x, -w) for x, w in reversed(right)), (Fraction(0), Fraction(0)), *right]
                last = right[-1][1] / right[-1][0]
                graphs = Graphs.through([(points, last, last)], [1])
                visited = course(wave, begun.balance, begun.H, graphs, half=True) if k < begun.top else None
                witness = None if visited is None else _shown(begun.system, Found(k, graphs, *visited), sloped=False)
                if witness is not None:
                    return witness
    return None


def _shown(system: Realisation, found: Found, *, sloped: bool = True) -> Witness | None:
    """The witness of a solution of one channel, if it is proved."""
    given, course = found.graphs.data[0], found.course
    points = [(Fraction(x), Fraction(w)) for x, w in given["points"]]
    graph = Graph.through(points, Fraction(given["left"]), Fraction(given["right"]))
    if any(1 + system.d * slope <= 0 for slope in graph.slopes):
        return None  # sigma does not follow from the state
    loop = PiecewiseLoop.of(system, graph)
    pieces, durations, state = (row[0] for row in found.pieces), tuple(course.durations), tuple(course.state)
    orbit = refined(loop, Itinerary(pieces=tuple(pieces), durations=durations, state=state, half=course.half))
    known = orbit is not None and proved(loop, orbit)
    return orbit_witness(loop, orbit, Evidence.CERTIFIED, sloped=sloped) if orbit is not None and known else None


def absorbed(slope: float, d: float) -> float:
    """``s/(1 + d s)``, infinity included."""
    if slope == math.inf:
        return 1 / d if d > 0 else math.inf
    return slope / (1 + d * slope) if 1 + d * slope > 0 else math.inf


def restored(nonlinearity: Graph, d: Fraction) -> Graph:
    """``phi(sigma)`` for the nonlinearity ``psi(y)`` with ``y = sigma + d phi``, ``phi = psi``."""
    points = [(y - d * nonlinearity.exact(y), nonlinearity.exact(y)) for y in nonlinearity.kinks]
    left, right = (s / (1 - d * s) for s in (nonlinearity.slopes[0], nonlinearity.slopes[-1]))
    return Graph.through(points, left, right)


def _witness(system: Realisation, found: Oscillation) -> Witness | None:
    """The witness a little above the fold, proved if possible."""
    weaker = None
    for excess in (1e-5, 1e-4, 4e-4, 2e-3, 1e-2):
        parameter = Fraction(float(f"{found.parameter * (1 + excess):.12g}"))
        nonlinearity = restored(saturation(*found.slopes(parameter)), system.d)
        try:
            loop = PiecewiseLoop.of(system, nonlinearity)
        except InputError:
            return weaker
        near = settled(loop, found.orbit)
        orbit = None if near is None else refined(loop, near.exact())
        if orbit is None:
            continue
        if proved(loop, orbit):
            return orbit_witness(loop, orbit, Evidence.CERTIFIED)
        weaker = weaker if weaker is not None else orbit_witness(loop, orbit, Evidence.COMPUTED)
    return weaker


def orbit_witness(loop: PiecewiseLoop, orbit: Itinerary, evidence: Evidence, *, sloped: bool = True) -> Witness:
    """The witness for an orbit of a piecewise-linear loop.

    ``evidence``: CERTIFIED if ``validated.proved`` holds.  ``sloped``: whether it is one for a class of slopes; else
    for a sector.
    """
    nonlinearity = loop.nonlinearity
    with working_precision(128):
        top = ball(max(nonlinearity.slopes) if sloped else Fraction(nonlinearity.sector.upper))
        k = outward(top, top).high
    points = ", ".join(f"({float(x):.6g}, {float(nonlinearity.exact(x)):.6g})" for x in nonlinearity.kinks)
    left, right = float(nonlinearity.slopes[0]), float(nonlinearity.slopes[-1])
    state = [float(v) for v in orbit.state]
    visited = followed_oscillation(loop, np.array(state), np.linspace(0.0, orbit.period, 401)).sigma
    return Witness(
        kind="periodic orbit",
        k=k,
        evidence=evidence,
        slope_restricted=sloped,
        odd=nonlinearity.odd,
        description=f"phi piecewise linear through {points}, slope {left:.6g} to the left, {right:.6g} to the right: "
        f"a periodic solution with period {orbit.period:.7g} s",
        data=MappingProxyType(
            {
                "points": [[str(x), str(nonlinearity.exact(x))] for x in nonlinearity.kinks],
                "left_slope": str(nonlinearity.slopes[0]),
                "right_slope": str(nonlinearity.slopes[-1]),
                "period": orbit.period,
                "pieces": list(orbit.pieces),
                "durations": [float(t) for t in orbit.durations],
                "state": state,
                "half": orbit.half,
                "visited": [float(np.nanmin(visited)), float(np.nanmax(visited))],
            }
        ),
    )
