r"""The waves inside the rod, from those at its end ``x = L``: a shift along the characteristics; and their energy."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lure.errors import InputError
from lure.record import described, quantity
from lure.rod.motion.pieces import Array, Pieces, basis, distinct, fitted, values
from lure.rod.motion.record import Record, Series, Trips, Windows, record_of
from lure.rod.motion.sources import Sources

Integrand = Callable[[Array, Array], Array]
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)


@described(frozen=True, kw_only=True, eq=False, slots=True)
class Fields:
    """What is known of the waves at ``x = L``, and what follows for the rest of the rod."""

    sources: Sources = quantity("Loads and initial data")
    share: float = quantity("``1/(1 + k_L/Z)``")
    record: Trips = quantity("Consecutive round trips")

    @property
    def windows(self) -> Windows:
        """The round trips one by one, each made when it is asked for."""
        return Windows(self.record)

    def at_end(self, t: Array, name: Series) -> Array:
        """Values of one of the series of the windows at instants [transits], elementwise."""
        return self.record.at(t.ravel(), name).reshape(t.shape)

    def waves(self, t: Array, x: Array) -> tuple[Array, Array]:
        """``r1`` and ``r2`` [m/s] at instants [s] and places [m].

        Raises
        ------
        InputError
            A point lies outside the rod or the times that are kept.
        """
        times, places = np.broadcast_arrays(t / self.sources.rod.travel_time, x)
        if not np.all((places >= 0) & (places <= self.sources.rod.length)):
            raise InputError(f"x leaves the rod; give positions in [0, {self.sources.rod.length:g}] m")
        self._check_times(times)
        return self._forward(times, places), self._backward(times, places)

    def _check_times(self, times: Array) -> None:
        low, high = self.span
        if not np.all((times >= low) & (times <= high)):
            T = self.sources.rod.travel_time
            raise InputError(f"t leaves the waves that are kept; give times in [{low * T:g}, {high * T:g}] s")

    @property
    def span(self) -> tuple[float, float]:
        """First and last instant [transits] at which all of the rod is known."""
        record = self.record
        first, last = 2.0 * record.number, 2.0 * (record.number + len(record) - 1)
        return first + (2.0 if first else 0.0), last + record.stop * (1.0 + 1e-15)

    def _backward(self, t: Array, x: Array) -> Array:
        rod = self.sources.rod
        left = t - (1.0 - x / rod.length)
        early = left < 0.0
        start = np.clip(x + rod.length * t, 0.0, rod.length)
        initial = self.sources.scenario.waves(rod, np.where(early, start, 0.0))[1]
        value = np.where(early, initial, self.at_end(np.where(early, 0.0, left), "returned"))
        return np.asarray(value + self._loaded(t, x, -1))

    def _forward(self, t: Array, x: Array) -> Array:
        rod = self.sources.rod
        left = t - x / rod.length
        early = left < 0.0
        start = np.clip(x - rod.length * t, 0.0, rod.length)
        initial = self.sources.scenario.waves(rod, np.where(early, start, 0.0))[0]
        late = np.where(early, 0.0, left)
        sent = self.sources.echo * self._backward(late, np.zeros(late.shape))
        if not self.sources.scenario.force.is_zero:
            sent = sent + self.sources.force_gain * self.sources.force_at(late)
        return np.asarray(np.where(early, initial, sent) + self._loaded(t, x, 1))

    def _loaded(self, t: Array, x: Array, direction: int) -> Array | float:
        if self.sources.scenario.body_force.is_zero:
            return 0.0
        return self.sources.body(t.ravel(), x.ravel(), direction).reshape(t.shape)

    def breaks(self, t: float) -> Array:
        """Places between which the waves are smooth at an instant [transits], with both ends of the rod [m]."""
        L = self.sources.rod.length
        instants = [0.0]
        first = self.record.number
        for number in range(max(first, math.floor(0.5 * t) - 3), min(first + len(self.record), math.ceil(0.5 * t) + 2)):
            if t - 4.1 < 2.0 * number < t + 0.1:
                instants += (2.0 * number + self.record.edges(number - first)).tolist()
        places = [L * (1.0 - (t - s)) for s in instants]
        places += [L * (t - (s - 1.0)) for s in instants]  # kinks of the force that its formula does not show
        places += [L * (t - s - 1.0) for s in instants] + [L * (t - s) for s in (0.0, *self.sources.breaks)]
        known = [0.0, *self.sources.body_breaks[1]]
        if t < 3.0:  # with an echo that hides none of the kinks of the initial data
            known += _kinks(self.sources)
        for start in (0.0, *self.sources.body_breaks[0]):
            path = L * (t - start)
            places += [place for p in (*known, L) for place in (p + path, p - path, path - p, p)]
        return distinct([place / L for place in places], 0.0, 1.0) * L

    def _quadrature(self, edges: Array) -> tuple[Array, Array]:
        half = 0.5 * np.diff(edges)
        return (edges[:-1, None] + half[:, None] * (_NODES + 1.0)), half[:, None] * _WEIGHTS

    def wave_energies(self, t: Array) -> Array:
        """``A int (rho v^2 + E w^2)/2 dx`` (n,) [J] at instants (n,) [s].

        Raises
        ------
        InputError
            An instant lies outside the times that are kept.
        """
        rod = self.sources.rod
        self._check_times(t / rod.travel_time)
        if self.sources.scenario.body_force.is_zero:
            squares = rod.length * squares_over_a_transit(self.sources, self.share, self.record, t / rod.travel_time)
        else:
            squares = np.array([self._squares(float(instant)) for instant in t])
        return np.asarray(0.25 * rod.area * rod.density * squares)

    def _squares(self, t: float) -> float:
        x, weights = self._quadrature(self.breaks(t / self.sources.rod.travel_time))
        forward, backward = self.waves(np.full(x.shape, t), x)
        return float((weights * (forward**2 + backward**2)).sum())

    def integral_to_end(self, t: float, x: Array) -> Array:
        """``int_x^L w dx`` [m] at an instant [s]."""
        rod = self.sources.rod
        wanted = np.unique(x)
        edges = distinct([*(self.breaks(t / rod.travel_time) / rod.length).tolist(), *(wanted / rod.length)], 0.0, 1.0)
        nodes, weights = self._quadrature(edges * rod.length)
        forward, backward = self.waves(np.full(nodes.shape, float(t)), nodes)
        parts = (weights * (backward - forward)).sum(axis=1) / (2.0 * rod.wave_speed)
        sums = np.concatenate((np.cumsum(parts[::-1])[::-1], [0.0]))
        nearest = np.abs(edges[:, None] - x.ravel() / rod.length).argmin(axis=0)
        return np.asarray(sums[nearest].reshape(x.shape))


@lru_cache(maxsize=4)
def _kinks(sources: Sources) -> list[float]:
    """Places [m] between which the initial data are smooth."""
    edges = replace(sources, echo=-1.0).initial_wave()[0].edges
    return [float(place) for place in sources.rod.length * np.abs(1.0 - edges)]


def squares_over_a_transit(sources: Sources, share: float, trips: Trips, t: Array) -> Array:
    r"""``int_0^1 (V(t - s)^2 + W(t + s)^2) ds`` (n,) at instants (n,) [transits] that the round trips cover.

    Without loads along the rod this is its energy,

    .. math:: \int_0^L (\rho v^2 + E w^2)\,dx = \frac{\rho c}{2} \int_0^T \big(V(t - s)^2 + W(t + s)^2\big)\,ds,

    for the backward wave at ``x`` left the end ``(L - x)/c`` ago and the forward wave will be there in as long.  Both
    are polynomials on pieces, whose squares Gauss quadrature integrates exactly, whatever kinks there are.

    ``share``: ``1/(1 + k_L/Z)``.
    """
    if isinstance(trips, Record):
        behind, ahead = over_a_transit(sources, trips, t)
        return behind + ahead
    total = np.empty(len(t))
    trip = np.clip(np.floor(0.5 * t).astype(np.int64) - trips.number, 0, len(trips) - 1)
    for i in np.unique(trip):
        near = [trips.window(j) for j in range(max(i - 1, 0), min(i + 2, len(trips)))]
        behind, ahead = over_a_transit(sources, record_of(near, share), t[trip == i])
        total[trip == i] = behind + ahead
    return total


def square(wave: Array, _at: Array) -> Array:
    """The integrand of an energy."""
    return np.asarray(wave**2)


def over_a_transit(sources: Sources, record: Record, t: Array, of: Integrand = square) -> tuple[Array, Array]:
    """``int_0^1 of(V(t - s), t - s) ds`` and ``int_0^1 of(W(t + s), t + s) ds``, (n,) each: over all of the rod.

    ``record``: round trips that cover the instants ``t`` (n,) [transits]; ``of``: from values of a wave [m/s] and their
    instants [transits] to what is integrated; polynomials of at most twice the degree of the wave are integrated
    exactly.
    """
    stop = 2.0 * (record.number + len(record) - 1) + record.stop
    behind = of_record(record, np.maximum(t - 1.0, 0.0), t, of, returned=True)
    ahead = of_record(record, t, np.minimum(t + 1.0, stop), of, returned=False)
    early = t < 1.0
    if early.any():  # as if the end x = 0 gave back minus what comes: then W(tau) = -V(tau - 2) for 1 < tau < 2
        before = replace(sources, echo=-1.0).initial_wave()[0]
        before = Pieces(before.edges, -before.series)
        behind[early] += of_pieces(before, t[early] + 1.0, np.full(int(early.sum()), 2.0), of, -2.0)
    late = t + 1.0 > stop
    number = int(stop // 2.0)
    for n in (number, number + 1) if late.any() else ():
        span = min(2.0, stop + 1.0 - 2.0 * n)
        low, high = np.clip(stop - 2.0 * n, 0.0, span), np.clip(t[late] + 1.0 - 2.0 * n, 0.0, span)
        if span > 0.0:
            ahead[late] += of_pieces(_incoming(sources, record, n, span), np.minimum(low, high), high, of, 2.0 * n)
    return behind, ahead


def _incoming(sources: Sources, record: Record, n: int, span: float) -> Pieces:
    """``W`` in a round trip, up to one transit after the end of the motion."""
    if n == 0:
        wave = sources.initial_wave()[0]
    else:
        i = n - 1 - record.number
        returned = (2.0 * record.share - 1.0) * record.series(i, 0) - 2.0 * record.series(i, 2)
        wave = Pieces(record.edges(i), sources.echo * returned)
    if sources.scenario.free:
        return wave
    edges = [*wave.edges.tolist(), *(point - 2.0 * n for point in sources.load_breaks())]
    load, _ = fitted(lambda tau: sources.added(2.0 * n + tau), distinct(edges, 0.0, span), sources.degree, 0.0)
    return Pieces(load.edges, wave.on(load.edges).series + load.series)


def itself(wave: Array, _at: Array) -> Array:
    """The integrand of a mean."""
    return wave


def of_pieces(pieces: Pieces, low: Array, high: Array, of: Integrand = itself, origin: float = 0.0) -> Array:
    """Integrals (n,) from ``low`` to ``high`` (n,) [transits from the origin].

    ``low``, ``high``: inside the pieces; ``of``: as for :func:`over_a_transit`; ``origin``: where the edges of the
    pieces count from [transits].
    """
    edges = pieces.edges
    first = np.clip(np.searchsorted(edges, low, side="right") - 1, 0, len(edges) - 2)
    last = np.clip(np.searchsorted(edges, high, side="left") - 1, first, len(edges) - 2)

    def at(i: NDArray[np.int64], x: Array, tau: Array) -> Array:
        """What is integrated."""
        return of(values(pieces.series[i], x), tau + origin)

    return _sums((edges[:-1], edges[1:]), pieces.series.shape[1] - 1, at, (first, low), (last, high))


def of_record(record: Record, low: Array, high: Array, of: Integrand = square, *, returned: bool) -> Array:
    """The same for ``V`` or ``W``, instants in transits from the start of the motion."""
    origins = 2.0 * np.repeat(record.number + np.arange(len(record)), np.diff(record.first))

    def at(i: NDArray[np.int64], x: Array, tau: Array) -> Array:
        """What is integrated."""
        wave = record.rows(i, 0)
        wave = (2.0 * record.share - 1.0) * wave - 2.0 * record.rows(i, 2) if returned else wave
        return of(values(wave, x), tau + origins[i, None])

    return _sums((record.low, record.high), record.width - 1, at, record.found(low), record.found(high))


def _sums(
    ends: tuple[Array, Array],
    degree: int,
    at: Callable[[NDArray[np.int64], Array, Array], Array],
    begin: tuple[NDArray[np.int64], Array],
    end: tuple[NDArray[np.int64], Array],
) -> Array:
    """Integrals from a place on one piece to a place on a later one, the pieces between taken once."""
    (start, stop), (first, low), (last, high) = ends, begin, end
    space = basis(degree)

    def part(i: NDArray[np.int64], a: Array, b: Array) -> Array:
        """Over a part of each piece."""
        half = np.maximum(0.5 * (b - a), 0.0)
        tau = a[:, None] + half[:, None] * (space.gauss + 1.0)
        x = ((tau - start[i, None]) - (stop[i, None] - tau)) / (stop[i, None] - start[i, None])
        return np.asarray(half * (at(i, x, tau) @ space.weights))

    one = first == last
    total = part(first, low, np.where(one, high, stop[first]))
    total += np.where(one, 0.0, part(last, start[last], high))
    counts = np.maximum(last - first - 1, 0)
    owner = np.repeat(np.arange(len(first)), counts)
    between = np.arange(len(owner)) - (np.cumsum(counts) - counts)[owner] + first[owner] + 1
    pieces, which = np.unique(between, return_inverse=True)
    whole = part(pieces, start[pieces], stop[pieces])
    return np.asarray(total + np.bincount(owner, whole[which], minlength=len(first)))
