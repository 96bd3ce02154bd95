"""The waves inside the rod, from those at its end ``x = L``: a shift along the characteristics."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from lure.errors import InputError
from lure.rod.motion.chebyshev import Array
from lure.rod.motion.pieces import distinct
from lure.rod.motion.record import Series, Trips, Windows
from lure.rod.motion.sources import Sources
from lure.rod.motion.wave_energy import squares_over_a_transit

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Fields:
    """What is known of the waves at ``x = L``, and what follows for the rest of the rod.

    Attributes
    ----------
    sources : Sources
        Loads and initial data.
    share : float
        ``1/(1 + k_L/Z)``.
    record : Trips
        Consecutive round trips.
    """

    sources: Sources
    share: float
    record: Trips

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
