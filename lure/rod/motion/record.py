"""Consecutive round trips as flat arrays, their evaluation at many instants, and windows made of them on demand."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Literal, Protocol, overload

import numpy as np
from numpy.typing import NDArray

from lure.record import described, quantity
from lure.rod.datasets import Contact
from lure.rod.motion.compilation import reader
from lure.rod.motion.kernel_walk import recorded
from lure.rod.motion.pieces import Array, values

Series = Literal["wave", "returned", "push", "z"]
_COLUMNS = {"wave": 0, "z": 1, "push": 2}
_MANY, _FEW = 100_000, 8  # instants that are read at once, and for which arrays cost more than loops


@described(frozen=True, kw_only=True, eq=False, slots=True)
class Window:
    """One round trip."""

    number: int = quantity("It spans ``2T number`` to ``2T number + span T``")
    edges: Array = quantity("(m+1,) from 0 to ``span``, at most 2 [transits]")
    wave: Array = quantity("(m, N+1) Chebyshev series of ``W = r1(t, L)`` on the pieces [m/s]")
    returned: Array = quantity("(m, N+1) of ``V = r2(t, L)`` [m/s]")
    push: Array = quantity("(m, N+1) of ``d p``, with ``d`` reduced by a dashpot at ``x = L`` [m/s]")
    z: Array = quantity("(m, N+1) of the contact coordinate", "m")
    impacts: tuple[Contact, ...] = quantity("Those that ended here")
    crossings: int = quantity("Passages from one segment of the nonlinearity to another")
    error: float = quantity("Estimate of the local errors made here, as a change of ``V`` times its duration", "m")
    end: State = quantity("The end of the rod after this window")


@described(frozen=True, kw_only=True, slots=True)
class State:
    """Where the end of the rod is."""

    segment: int = quantity("Segment of the nonlinearity")
    zeta: Level = quantity("``z`` from the origin of the segment", "m")
    impact: Contact | None = quantity("The contact that goes on", default=None)


@dataclass(frozen=True, kw_only=True, slots=True)
class Level:
    """A number with its rounding remainder: positions in free flight are sums of very many small travels."""

    value: float
    rest: float = 0.0


@described(frozen=True, kw_only=True, eq=False, slots=True)
class Record:
    """Round trips ``number .. number + W - 1`` on ``P`` pieces."""

    number: int = quantity("The first round trip")
    share: float = quantity("``1/(1 + k_L/Z)``")
    width: int = quantity("``N + 1``, the most coefficients of a series")
    first: NDArray[np.int64] = quantity("(W+1,) first piece of each round trip, and the number of pieces")
    low: Array = quantity("(P,) starts of the pieces, from the start of their round trip [transits]")
    high: Array = quantity("(P,) ends of the pieces, from there [transits]")
    start: NDArray[np.int64] = quantity("(P,) where the coefficients of a piece begin")
    degree: NDArray[np.int64] = quantity(
        "(P, 3) degrees of ``W``, ``z`` and ``d p`` on it, whose coefficients follow each other"
    )
    coef: Array = quantity("(C,) all coefficients")
    endings: Array = quantity(
        "(W, 7) error; ``zeta`` and its remainder at the end; start, end, impulse and peak stress of an open impact"
    )
    marks: NDArray[np.int64] = quantity(
        "(W, 4) segment at the end; whether an impact is open there; crossings; impacts that ended so far"
    )
    impacts: Array = quantity("(I, 4) start, end, impulse and peak stress of the impacts that ended here")

    def __len__(self) -> int:
        """Number of round trips."""
        return len(self.marks)

    @property
    def stop(self) -> float:
        """Where the last round trip ends, from its start [transits]."""
        return float(self.high[-1])

    def edges(self, i: int) -> Array:
        """Edges of the pieces of the i-th round trip."""
        low, high = self.first[i], self.first[i + 1]
        return np.append(self.low[low:high], self.high[high - 1])

    def at(self, t: Array, name: Series) -> Array:
        """Values (n,) at instants (n,) [transits]; on an edge those from the right."""
        if name == "returned":
            return (2.0 * self.share - 1.0) * self.at(t, "wave") - 2.0 * self.at(t, "push")
        read = reader(recorded)
        if read is not None or len(t) <= _FEW:
            out, what = np.empty(len(t)), np.array([self.number, _COLUMNS[name]])
            (read or recorded)(t, (self.low, self.high, self.coef), (self.first, self.start, self.degree), what, out)
            return out
        parts = [self._at(t[i : i + _MANY], _COLUMNS[name]) for i in range(0, len(t), _MANY)]
        return np.concatenate(parts) if parts else np.empty(0)

    def found(self, t: Array) -> tuple[NDArray[np.int64], Array]:
        """The piece (n,) of each instant [transits], and the instant from the start of its round trip."""
        trip = np.minimum(np.maximum(np.floor(0.5 * t).astype(np.int64) - self.number, 0), len(self) - 1)
        local = t - 2.0 * (trip + self.number)
        piece, last = self.first[trip], self.first[trip + 1] - 1
        while (piece < last).any():
            middle = (piece + last + 1) // 2
            right = self.low[middle] <= local
            piece, last = np.where(right, middle, piece), np.where(right, last, middle - 1)
        return piece, local

    def _at(self, t: Array, column: int) -> Array:
        piece, local = self.found(t)
        low, high = self.low[piece], self.high[piece]
        x = np.minimum(np.maximum(((local - low) - (high - local)) / (high - low), -1.0), 1.0)
        return values(self.rows(piece, column), x[:, None])[:, 0]

    def series(self, i: int, column: int) -> Array:
        """(m, N+1) coefficients on the pieces of the i-th round trip: of ``W`` (0), ``z`` (1) or ``d p`` (2)."""
        return self.rows(np.arange(self.first[i], self.first[i + 1]), column)

    def rows(self, pieces: NDArray[np.int64], column: int) -> Array:
        """(m, N+1) coefficients on pieces: of ``W`` (0), ``z`` (1) or ``d p`` (2)."""
        degree = self.degree[pieces]
        at = self.start[pieces] + (degree[:, :column] + 1).sum(axis=1)
        k = np.arange(self.width)
        inside = k <= degree[:, column, None]
        return np.where(inside, self.coef[at[:, None] + np.where(inside, k, 0)], 0.0)

    def window(self, i: int) -> Window:
        """The i-th round trip on its own."""
        wave, z, push = (self.series(i, column) for column in range(3))
        error, zeta, rest, start, end, impulse, peak = self.endings[i].tolist()
        segment, opened, crossings, ended = self.marks[i].tolist()
        before = int(self.marks[i - 1, 3]) if i > 0 else 0
        impact = Contact(start=start, end=end, impulse=impulse, peak_stress=peak, closed=False) if opened else None
        return Window(
            number=self.number + i,
            edges=self.edges(i),
            wave=wave,
            returned=(2.0 * self.share - 1.0) * wave - 2.0 * push,
            push=push,
            z=z,
            impacts=impacts_of(self.impacts[before:ended]),
            crossings=crossings,
            error=error,
            end=State(segment=segment, zeta=Level(value=zeta, rest=rest), impact=impact),
        )

    def last(self, count: int) -> Record:
        """The last round trips, in arrays of their own."""
        w = max(len(self) - count, 0)
        p, i = int(self.first[w]), int(self.marks[w - 1, 3]) if w else 0
        c = int(self.start[p])
        marks = self.marks[w:].copy()
        marks[:, 3] -= i
        return Record(
            number=self.number + w,
            share=self.share,
            width=self.width,
            first=self.first[w:] - p,
            low=self.low[p:].copy(),
            high=self.high[p:].copy(),
            start=self.start[p:] - c,
            degree=self.degree[p:].copy(),
            coef=self.coef[c:].copy(),
            endings=self.endings[w:].copy(),
            marks=marks,
            impacts=self.impacts[i:].copy(),
        )


class Trips(Protocol):
    """Consecutive round trips, however they are held: see :class:`Record`."""

    @property
    def number(self) -> int:
        """The first round trip."""

    @property
    def stop(self) -> float:
        """Where the last round trip ends, from its start [transits]."""

    @property
    def impacts(self) -> Array:
        """(I, 4) start, end, impulse and peak stress of the impacts that ended here."""

    def __len__(self) -> int:
        """Number of round trips."""

    def edges(self, i: int) -> Array:
        """Edges of the pieces of the i-th round trip."""

    def at(self, t: Array, name: Series) -> Array:
        """Values (n,) at instants (n,) [transits]; on an edge those from the right."""

    def window(self, i: int) -> Window:
        """The i-th round trip on its own."""

    def last(self, count: int) -> Trips:
        """The last round trips."""


class Windows(Sequence[Window]):
    """The round trips of a record as windows, made when they are asked for."""

    def __init__(self, record: Trips) -> None:
        self._record = record

    def __len__(self) -> int:
        return len(self._record)

    @overload
    def __getitem__(self, i: int) -> Window: ...
    @overload
    def __getitem__(self, i: slice) -> tuple[Window, ...]: ...
    def __getitem__(self, i: int | slice) -> Window | tuple[Window, ...]:
        """One window, or some."""
        if isinstance(i, slice):
            return tuple(self._record.window(j) for j in range(*i.indices(len(self))))
        if not -len(self) <= i < len(self):
            raise IndexError(i)
        return self._record.window(i % len(self))

    def __iter__(self) -> Iterator[Window]:
        """One after the other."""
        return (self._record.window(i) for i in range(len(self)))


def impacts_of(rows: Array) -> tuple[Contact, ...]:
    """Impacts that ended, from rows (n, 4)."""
    return tuple(
        Contact(start=start, end=end, impulse=impulse, peak_stress=peak, closed=True)
        for start, end, impulse, peak in rows.tolist()
    )


def joined_records(records: Sequence[Record]) -> Record:
    """Records that follow each other as one."""
    if len(records) == 1:
        return records[0]
    first, start, marks, pieces, numbers, impacts = [], [], [], 0, 0, 0
    for record in records:
        first.append(record.first[:-1] + pieces)
        start.append(record.start + numbers)
        marks.append(record.marks + np.array([0, 0, 0, impacts]))
        pieces, numbers, impacts = pieces + len(record.low), numbers + len(record.coef), impacts + len(record.impacts)
    return Record(
        number=records[0].number,
        share=records[0].share,
        width=records[0].width,
        first=np.concatenate((*first, [pieces])),
        low=np.concatenate([record.low for record in records]),
        high=np.concatenate([record.high for record in records]),
        start=np.concatenate(start),
        degree=np.concatenate([record.degree for record in records]),
        coef=np.concatenate([record.coef for record in records]),
        endings=np.concatenate([record.endings for record in records]),
        marks=np.concatenate(marks),
        impacts=np.concatenate([record.impacts for record in records]),
    )


def record_of(windows: Collection[Window], share: float) -> Record:
    """Consecutive windows as a record."""
    first_window = next(iter(windows))
    width = first_window.wave.shape[1]
    counts = np.array([len(window.wave) for window in windows])
    first = np.concatenate(([0], np.cumsum(counts)))
    table = np.concatenate([np.stack((w.wave, w.z, w.push), axis=1) for w in windows])
    open_ = [(0.0,) * 4 if (i := w.end.impact) is None else (i.start, i.end, i.impulse, i.peak_stress) for w in windows]
    ended = np.cumsum([len(w.impacts) for w in windows])
    rows = [(i.start, i.end, i.impulse, i.peak_stress) for w in windows for i in w.impacts]
    return Record(
        number=first_window.number,
        share=share,
        width=width,
        first=first,
        low=np.concatenate([w.edges[:-1] for w in windows]),
        high=np.concatenate([w.edges[1:] for w in windows]),
        start=3 * width * np.arange(first[-1]),
        degree=np.full((first[-1], 3), width - 1),
        coef=table.ravel(),
        endings=np.array(
            [(w.error, w.end.zeta.value, w.end.zeta.rest, *o) for w, o in zip(windows, open_, strict=True)]
        ),
        marks=np.array(
            [(w.end.segment, w.end.impact is not None, w.crossings, n) for w, n in zip(windows, ended, strict=True)],
            dtype=np.int64,
        ),
        impacts=np.array(rows).reshape(-1, 4),
    )


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
        if (t[1:] < t[:-1]).any():
            order = t.argsort(kind="stable")
            found = np.empty(len(t))
            found[order] = self.at(t[order], name)
            return found
        cuts = t.searchsorted(2.0 * self._firsts[1:]).tolist()
        ends = zip(self._parts, [0, *cuts], [*cuts, len(t)], strict=True)
        return np.concatenate([part.at(t[low:high], name) for part, low, high in ends if low < high] or [np.empty(0)])

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
