"""The end ``x = L`` of the rod along whole round trips, and what the waves in the rod hold at any instant."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.rod.motion import Window
from lure.rod.motion.pieces import Array, basis, distinct, fitted, values
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario


@dataclass(frozen=True, kw_only=True, eq=False)
class Track:
    r"""Consecutive round trips of a rod, from the start on.

    Without loads, and with ``W = r1(t, L)`` and ``V = r2(t, L)``, what runs in the rod at ``t = 2T n + T tau`` is known
    from the window ``n`` and the one before: the forward wave is what arrives in the next ``T``, ``W`` up to the end of
    the window and ``-a V`` of it after that; the backward wave is the ``V`` of the last ``T``.

    Attributes
    ----------
    rod : Rod
        The rod.
    scenario : Scenario
        Its initial data and loads.
    windows : tuple of Window
        From number 0 on; under load the last may be cut off.
    """

    rod: Rod
    scenario: Scenario
    windows: tuple[Window, ...]

    @property
    def reached(self) -> float:
        """End of the last round trip [s]."""
        last = self.windows[-1]
        return self.rod.travel_time * (2.0 * last.number + float(last.edges[-1]))

    @cached_property
    def pieces(self) -> Places:
        """All pieces; the row before the first window holds what the backward wave was before the start."""
        degree = self.windows[0].wave.shape[1] - 1
        L = self.rod.length

        def backward(s: Array) -> tuple[Array, Array]:
            """``r2`` at ``x = L s`` at the start, which would have left ``x = L`` a time ``1 - s`` before."""
            return self.scenario.waves(self.rod, L * s)[1], np.zeros(len(s))

        edges: list[float] = []
        for data in (self.scenario.displacement, self.scenario.velocity):
            edges += [float(place) / L for place in data.breakpoints("x", 0.0, L) or ()]
        start, _ = fitted(backward, distinct(edges, 0.0, 1.0), degree, 0.0)
        still = np.zeros((1, degree + 1))
        tables = [(np.append(0.0, 1.0 + start.edges), np.zeros((len(start.series) + 1, degree + 1)))]
        tables += [(window.edges, window.wave) for window in self.windows]
        returned = [still, start.series, *(window.returned for window in self.windows)]
        z = [still, np.zeros_like(start.series), *(window.z for window in self.windows)]
        return Places(
            number=np.repeat(np.arange(-1, len(self.windows)), [len(series) for _, series in tables]),
            low=np.concatenate([edges[:-1] for edges, _ in tables]),
            high=np.concatenate([edges[1:] for edges, _ in tables]),
            wave=np.concatenate([series for _, series in tables]),
            returned=np.concatenate(returned),
            z=np.concatenate(z),
        )

    def place(self, t: ArrayLike) -> tuple[NDArray[np.int64], Array]:
        """Round trip and place in it [transits] of instants [s] from 0 to :attr:`reached`."""
        transits = np.asarray(t, dtype=float) / self.rod.travel_time
        number = np.clip(np.floor(0.5 * transits).astype(np.int64), 0, len(self.windows) - 1)
        return number, np.clip(transits - 2.0 * number, 0.0, 2.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Places:
    """Pieces of all windows in one table, with the integrals along each window.

    Attributes
    ----------
    number : ndarray
        (P,) window of each piece, -1 for the time before the start.
    low, high : ndarray
        (P,) ends in the window [transits].
    wave, returned, z : ndarray
        (P, N+1) Chebyshev series of ``W``, ``V`` [m/s] and ``z`` [m].
    """

    number: NDArray[np.int64]
    low: Array
    high: Array
    wave: Array
    returned: Array
    z: Array

    def at(self, series: Array, number: NDArray[np.int64], tau: Array) -> Array:
        """Values of a table of series at places (n,)."""
        i = self._found(number, tau)
        low, high = self.low[i], self.high[i]
        x = np.clip(((tau - low) - (high - tau)) / (high - low), -1.0, 1.0)
        return values(series[i], x[:, None])[:, 0]

    @cached_property
    def travel(self) -> tuple[Array, Array]:
        """Series of ``int W`` and ``int V`` from the start of the window [m/s transits]."""
        return self._integral(self.wave), self._integral(self.returned)

    @cached_property
    def squares(self) -> tuple[Array, Array, Array, Array]:
        """Series of the integrals of ``W^2``, ``V^2``, ``tau W^2`` and ``tau V^2`` from the start of the window."""
        degree = 2 * (self.wave.shape[1] - 1) + 1
        space = basis(degree)
        x = np.broadcast_to(space.inner, (len(self.low), degree + 1))
        tau = self.low[:, None] + 0.5 * (self.high - self.low)[:, None] * (x + 1.0)
        wave, returned = values(self.wave, x) ** 2, values(self.returned, x) ** 2
        found = (self._integral(table @ space.from_inner.T) for table in (wave, returned, tau * wave, tau * returned))
        one, two, three, four = found
        return one, two, three, four

    @cached_property
    def _first(self) -> NDArray[np.int64]:
        """First piece of each window, of that before the start first."""
        return np.searchsorted(self.number, np.arange(-1, int(self.number[-1]) + 2))

    def _found(self, number: NDArray[np.int64], tau: Array) -> NDArray[np.int64]:
        """Piece at each place: found in one list, then put right where rounding misplaced it."""
        first, last = self._first[number + 1], self._first[number + 2] - 1
        i = np.searchsorted(4.0 * self.number + self.low, 4.0 * number + tau, side="right") - 1
        i = np.clip(i, first, last)
        i = np.where((tau < self.low[i]) & (i > first), i - 1, i)
        return np.where((tau >= self.high[i]) & (i < last), i + 1, i)

    def _integral(self, series: Array) -> Array:
        """Series of the integral from the start of the window; one degree more."""
        grown = np.concatenate((series, np.zeros((len(series), 1))), axis=1)
        half = 0.5 * (self.high - self.low)
        primitive = half[:, None] * (grown @ basis(grown.shape[1] - 1).integral.T)
        gained = primitive.sum(axis=1)
        for first, stop in zip(self._first[:-1], self._first[1:], strict=True):
            primitive[first + 1 : stop, 0] += np.cumsum(gained[first : stop - 1])
        return np.asarray(primitive)
