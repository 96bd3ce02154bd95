"""A motion watched while it is computed: samples and exact integrals, in memory that the run before does not touch."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lure.rod.motion import Boundary, Impact, Motion, Numerics, Window, exact_motion
from lure.rod.motion.pieces import Pieces
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

Array = NDArray[np.float64]
Progress = Callable[[str, float], None]
_EVERY = 32


@dataclass(frozen=True, kw_only=True, eq=False)
class Recording:
    """What is kept of a watch.

    Attributes
    ----------
    rod : Rod
        The rod.
    boundary : Boundary
        What happens at its ends.
    t : ndarray
        (n+1,) times, equally spaced from the start of the watch to its end [s].
    z, v : ndarray
        (n+1,) contact coordinate [m] and end velocity ``z'`` [m/s].
    contact_impulses : ndarray
        (R,) ``A int p dt`` over each period of the watch [N s].
    returned : ndarray
        (R,) ``int V dt`` over each, one transit earlier: what reaches ``x = 0`` [m].
    touched : tuple of Impact
        Every contact that lies in the watch or reaches into it, in order.
    """

    rod: Rod
    boundary: Boundary
    t: Array
    z: Array
    v: Array
    contact_impulses: Array
    returned: Array
    touched: tuple[Impact, ...]

    @property
    def impacts(self) -> tuple[Impact, ...]:
        """The contacts that begin during the watch."""
        return tuple(impact for impact in self.touched if self.t[0] <= impact.start < self.t[-1])

    @property
    def contacts(self) -> tuple[tuple[float, float], ...]:
        """Start and end of contact, cut to the watch [s]."""
        low, high = float(self.t[0]), float(self.t[-1])
        ends = (each.end if each.closed else high for each in self.touched)
        spans = ((max(each.start, low), min(end, high)) for each, end in zip(self.touched, ends, strict=True))
        return tuple((start, end) for start, end in spans if start < end)


class Watch:
    """Takes the windows of a motion as they come, and keeps what happens from the first of its times to the last.

    Parameters
    ----------
    rod : Rod
        The rod.
    boundary : Boundary
        What happens at its ends.
    times : ndarray
        (n+1,) ascending [s].
    samples : int
        Samples in a period; ``n`` is a multiple of it.

    Attributes
    ----------
    boundary : Boundary
        As given.
    t : ndarray
        The times.
    """

    def __init__(self, rod: Rod, boundary: Boundary, times: Array, samples: int) -> None:
        self._rod, self.boundary, self.t = rod, boundary, times
        self._times = times / rod.travel_time
        self._next = 0
        self._z, self._v = np.empty(times.size), np.empty(times.size)
        self._periods = self._times[::samples]
        self._pushed, self._returned = np.zeros(self._periods.size - 1), np.zeros(self._periods.size - 1)
        self._touched: list[Impact] = []
        self._open: Impact | None = None

    @property
    def done(self) -> bool:
        """Whether all of its times have passed."""
        return self._next == self._times.size

    def see(self, window: Window) -> None:
        """Keep what the watch wants of a window."""
        origin, span = 2.0 * window.number, float(window.edges[-1])
        if origin + span < float(self._times[0]) - 1.0 or self.done:
            return
        start = float(self.t[0])
        self._touched += [impact for impact in window.impacts if impact.end > start]
        self._open = window.end.impact
        self._add(self._pushed, window.edges, window.push, origin)
        self._add(self._returned, window.edges, window.returned, origin + 1.0)
        self._sample(window, origin, span)

    def record(self) -> Recording:
        """What was kept, once it is done."""
        assert self.done, "a watch is read when all of its times have passed"
        rod, loss = self._rod, 1.0 + self.boundary.end_damping / self._rod.impedance
        begun = [*self._touched] if self._open is None else [*self._touched, self._open]
        return Recording(
            rod=rod,
            boundary=self.boundary,
            t=self.t,
            z=self._z,
            v=self._v,
            contact_impulses=rod.area * loss / rod.mobility * self._pushed,
            returned=self._returned,
            touched=tuple(impact for impact in begun if impact.start < self.t[-1]),
        )

    def _sample(self, window: Window, origin: float, span: float) -> None:
        is_last = origin + span >= self._times[-1] * (1.0 - 1e-15)
        stop = self._times.size if is_last else int(np.searchsorted(self._times, origin + span))
        chosen = slice(self._next, stop)
        if stop > self._next:
            local = np.clip(self._times[chosen] - origin, 0.0, span)
            self._z[chosen] = Pieces(window.edges, window.z)(local)
            self._v[chosen] = Pieces(window.edges, 0.5 * (window.wave + window.returned))(local)
            self._next = stop

    def _add(self, sums: Array, edges: Array, series: Array, origin: float) -> None:
        """Add the integral of a series that starts at an instant to the periods it reaches into."""
        low, high = origin + float(edges[0]), origin + float(edges[-1])
        first = max(int(np.searchsorted(self._periods, low, side="right")) - 1, 0)
        for i in range(first, min(int(np.searchsorted(self._periods, high)), sums.size)):
            sums[i] += self._integral(edges, series, self._periods[i] - origin, self._periods[i + 1] - origin)

    def _integral(self, edges: Array, series: Array, low: float, high: float) -> float:
        """Of a series over a part of its window, in seconds times its unit."""
        low, high = max(low, float(edges[0])), min(high, float(edges[-1]))
        if not low < high:
            return 0.0
        inner = edges[(edges > low) & (edges < high)]
        part = Pieces(edges, series)
        if inner.size < edges.size - 2 or low > edges[0] or high < edges[-1]:
            part = part.on(np.concatenate(([low], inner, [high])))
        return self._rod.travel_time * float(means(part.series) @ part.widths)


def follow(rod: Rod, scenario: Scenario, watches: Sequence[Watch], progress: Progress | None = None) -> Motion:
    """Follow a motion to the end of the last watch; every watch has seen what went by if it is interrupted.

    Parameters
    ----------
    rod, scenario
        The rod, its loads and initial data.
    watches : sequence of Watch
        In the order of their times, one at least.
    progress : callable, optional
        Called as ``progress(text, share)``.
    """
    until = float(watches[-1].t[-1])
    first, trip = float(watches[0].t[0]), 2.0 * rod.travel_time

    def see(window: Window) -> None:
        """Show the window to all."""
        if progress is not None and window.number % _EVERY == 0:
            now = trip * window.number
            progress("waiting for transients" if now < first else "watching", min(now / until, 1.0))
        for watch in watches:
            watch.see(window)

    return exact_motion(rod, scenario, until, boundary=watches[0].boundary, numerics=Numerics(keep=2, on_window=see))


def means(series: Array) -> Array:
    """Mean values (m,) of Chebyshev series (m, N+1) on their pieces.

    >>> means(np.array([[1.0, 5.0, 3.0]]))  # T_2 has mean -1/3
    array([0.])
    """
    k = np.arange(0, series.shape[1], 2, dtype=float)
    return np.asarray(series[:, ::2] @ (1.0 / (1.0 - k * k)))
