"""A motion watched while it is computed: samples and exact integrals, in memory that the run before does not touch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.response.plan import Plan
from lure.motion import Impact, Motion, Numerics, Window, exact_motion
from lure.motion.pieces import Pieces
from lure.rod import Rod
from lure.scenario import Scenario

Array = NDArray[np.float64]
Progress = Callable[[str, float], None]
_EVERY = 256


@dataclass(frozen=True, kw_only=True, eq=False)
class Record:
    """What is kept of a motion.

    Attributes
    ----------
    t : ndarray
        (n+1,) times, equally spaced from the start of the watch to its end [s].
    z, v : ndarray
        (n+1,) contact coordinate [m] and end velocity ``z'`` [m/s].
    contact_impulse : float
        ``A int p dt`` over the watch [N s].
    returned : float
        ``int V dt`` over the watch, one transit earlier: what reaches ``x = 0`` [m].
    motion : Motion
        The last round trips, the impacts, the errors.
    """

    t: Array
    z: Array
    v: Array
    contact_impulse: float
    returned: float
    motion: Motion

    @property
    def impacts(self) -> tuple[Impact, ...]:
        """The contacts that begin during the watch."""
        return tuple(impact for impact in self.motion.impacts if impact.start >= self.t[0])

    @property
    def contacts(self) -> tuple[tuple[float, float], ...]:
        """Start and end of contact, cut to the watch [s]."""
        low, high = float(self.t[0]), float(self.t[-1])
        spans = ((max(each.start, low), min(self._end(each), high)) for each in self.motion.impacts)
        return tuple((start, end) for start, end in spans if start < end)

    def _end(self, impact: Impact) -> float:
        return impact.end if impact.closed else float(self.t[-1])


def record(rod: Rod, scenario: Scenario, times: Array, *, plan: Plan, progress: Progress | None = None) -> Record:
    """Follow a motion up to the last of the times, and keep what happens from the first on.

    Parameters
    ----------
    rod, scenario
        The rod, its loads and initial data.
    times : ndarray
        (n+1,) ascending [s].
    plan : Plan
        For its boundary conditions.
    progress : callable, optional
        Called as ``progress(text, share)``.
    """
    watch = _Watch(rod, times, progress)
    boundary = plan.boundary
    motion = exact_motion(
        rod, scenario, float(times[-1]), boundary=boundary, numerics=Numerics(keep=2, on_window=watch.see)
    )
    loss = 1.0 + boundary.end_damping / rod.impedance
    return Record(
        t=times,
        z=watch.z,
        v=watch.v,
        contact_impulse=rod.area * loss / rod.mobility * watch.pushed,
        returned=watch.returned,
        motion=motion,
    )


class _Watch:
    """Takes the windows of a motion as they come."""

    def __init__(self, rod: Rod, times: Array, progress: Progress | None) -> None:
        self._transit, self._progress = rod.travel_time, progress
        self._times = times / rod.travel_time
        self._next = 0
        self.z, self.v = np.empty(times.size), np.empty(times.size)
        self.pushed, self.returned = 0.0, 0.0

    def see(self, window: Window) -> None:
        """Keep what the watch wants of a window."""
        origin, span = 2.0 * window.number, float(window.edges[-1])
        first, last = float(self._times[0]), float(self._times[-1])
        if self._progress is not None and window.number % _EVERY == 0:
            self._progress("settling" if origin < first else "watching", min(origin / last, 1.0))
        if origin + span < first - 1.0:
            return
        self._sample(window, origin, span)
        self.pushed += self._integral(window.edges, window.push, first - origin, last - origin)
        self.returned += self._integral(window.edges, window.returned, first - 1.0 - origin, last - 1.0 - origin)

    def _sample(self, window: Window, origin: float, span: float) -> None:
        is_last = origin + span >= self._times[-1] * (1.0 - 1e-15)
        stop = self._times.size if is_last else int(np.searchsorted(self._times, origin + span))
        chosen = slice(self._next, stop)
        if stop > self._next:
            local = np.clip(self._times[chosen] - origin, 0.0, span)
            self.z[chosen] = Pieces(window.edges, window.z)(local)
            self.v[chosen] = Pieces(window.edges, 0.5 * (window.wave + window.returned))(local)
            self._next = stop

    def _integral(self, edges: Array, series: Array, low: float, high: float) -> float:
        """Of a series over a part of its window, in seconds times its unit."""
        low, high = max(low, float(edges[0])), min(high, float(edges[-1]))
        if not low < high:
            return 0.0
        inner = edges[(edges > low) & (edges < high)]
        part = Pieces(edges, series)
        if inner.size < edges.size - 2 or low > edges[0] or high < edges[-1]:
            part = part.on(np.concatenate(([low], inner, [high])))
        return self._transit * float(means(part.series) @ part.widths)


def means(series: Array) -> Array:
    """Mean values (m,) of Chebyshev series (m, N+1) on their pieces.

    >>> means(np.array([[1.0, 5.0, 3.0]]))  # T_2 has mean -1/3
    array([0.])
    """
    k = np.arange(0, series.shape[1], 2, dtype=float)
    return np.asarray(series[:, ::2] @ (1.0 / (1.0 - k * k)))
