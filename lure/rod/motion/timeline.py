"""Records and stretches that follow each other, as one."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from itertools import groupby

import numpy as np

from lure.rod.motion.chebyshev import Array
from lure.rod.motion.record import Record, Series, Trips, joined_records
from lure.rod.motion.windows import Window


class Timeline:
    """Round trips in several parts; see :class:`lure.rod.motion.record.Record`."""

    def __init__(self, parts: Sequence[Trips]) -> None:
        self._parts = list(parts)
        self._starts = [part.number for part in parts]
        self._firsts = np.array(self._starts, dtype=float)

    @property
    def number(self) -> int:
        """The first round trip."""
        return self._starts[0]

    @property
    def stop(self) -> float:
        """Where the last round trip ends, from its start [transits]."""
        return self._parts[-1].stop

    @property
    def impacts(self) -> Array:
        """(I, 4) start, end, impulse and peak stress of the impacts that ended here."""
        return np.concatenate([part.impacts for part in self._parts])

    def __len__(self) -> int:
        """Number of round trips."""
        return self._starts[-1] + len(self._parts[-1]) - self._starts[0]

    def at(self, t: Array, name: Series) -> Array:
        """Values (n,) at instants (n,) [transits]; on an edge those from the right."""
        found = np.empty(len(t))
        trip = np.floor(0.5 * t)
        part = np.clip(np.searchsorted(self._firsts, trip, side="right") - 1, 0, None)
        order = np.argsort(part, kind="stable")
        ends = np.flatnonzero(np.diff(part[order])) + 1
        for some in np.split(order, ends) if len(t) else ():
            found[some] = self._parts[part[some[0]]].at(t[some], name)
        return found

    def edges(self, i: int) -> Array:
        """Edges of the pieces of the i-th round trip."""
        part = self._part(i)
        return part.edges(i + self.number - part.number)

    def window(self, i: int) -> Window:
        """The i-th round trip on its own."""
        part = self._part(i)
        return part.window(i + self.number - part.number)

    def last(self, count: int) -> Trips:
        """The last round trips."""
        start, parts = max(self._starts[-1] + len(self._parts[-1]) - count, self.number), []
        for part in self._parts:
            stop = part.number + len(part)
            if stop > start:
                parts.append(part.last(stop - start) if part.number < start else part)
        return timeline(parts)

    def _part(self, i: int) -> Trips:
        return self._parts[bisect_right(self._starts, i + self.number) - 1]


def timeline(parts: Sequence[Trips]) -> Trips:
    """The parts as one; records next to each other are joined."""
    found: list[Trips] = []
    for plain, some in groupby(parts, key=lambda part: isinstance(part, Record)):
        group = list(some)
        found += [joined_records([part for part in group if isinstance(part, Record)])] if plain else group
    return found[0] if len(found) == 1 else Timeline(found)
