"""Intervals without events: many round trips by their states, evaluated where it is asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import field, replace

import numpy as np

from lure.record import described, quantity
from lure.rod.datasets import Contact
from lure.rod.motion.blocks import MANY, Block, Counts, SeriesBlock
from lure.rod.motion.compilation import reader
from lure.rod.motion.kernel_walk import sampled
from lure.rod.motion.pieces import Array, left_ends, right_ends, supremum, upper_bounds, values
from lure.rod.motion.record import Record, Series, Window
from lure.rod.motion.trip_matrix import Setting

CHUNK = 1024


@described(frozen=True, kw_only=True, eq=False, slots=True)
class EventFreeInterval:
    """Round trips ``number .. number + count - 1``, as :class:`lure.rod.motion.record.Record` has them."""

    number: int = quantity("The first round trip")
    count: int = quantity("How many there are")
    index: int = quantity("Place of the segment in the nonlinearity")
    impact: Contact | None = quantity("As it was before")
    mobility: float = quantity("``d`` with the share of a dashpot: from stresses to waves")
    error: float = quantity("Local error of a round trip", "m")
    setting: Setting = quantity("Pieces, segment and rod")
    blocks: Sequence[Block | SeriesBlock] = quantity("The states")
    before: int = quantity("Round trips in the blocks before the first", default=0)
    _made: dict[object, object] = field(default_factory=dict)

    def __len__(self) -> int:
        """Number of round trips."""
        return self.count

    @property
    def share(self) -> float:
        """``1/(1 + k_L/Z)``."""
        return self.setting.share

    @property
    def stop(self) -> float:
        """Where the last round trip ends, from its start [transits]."""
        return float(self.setting.edges[-1])

    @property
    def impacts(self) -> Array:
        """(0, 4): none ended."""
        return np.empty((0, 4))

    def edges(self, i: int) -> Array:
        """Edges of the pieces of the i-th round trip."""
        return self.setting.edges.copy()

    def at(self, t: Array, name: Series) -> Array:
        """Values (n,) at instants (n,) [transits]; on an edge those from the right."""
        if (t[1:] < t[:-1]).any():
            order = t.argsort(kind="stable")
            found = np.empty(len(t))
            found[order] = self.at(t[order], name)
            return found
        sample = reader(sampled) if len(t) > MANY and name != "returned" else None
        if sample is not None and isinstance(self.blocks[0], SeriesBlock):
            return self._levelled(self._sampled(t, name, sample), name)
        edges = self.setting.edges
        trip = np.minimum(np.maximum(np.floor(0.5 * t) - float(self.number), 0.0), self.count - 1.0)
        place = t - 2.0 * (trip + float(self.number))
        piece = edges[1:-1].searchsorted(place, side="right")
        low, high = edges[piece], edges[piece + 1]
        x = np.minimum(np.maximum(((place - low) - (high - place)) / (high - low), -1.0), 1.0)
        if name != "returned":
            return self._at(trip, piece, x, name)
        return (2.0 * self.share - 1.0) * self._at(trip, piece, x, "wave") - 2.0 * self._at(trip, piece, x, "push")

    def _at(self, trip: Array, piece: Counts, x: Array, name: Series) -> Array:
        found = np.empty(len(x))
        for block, some, n in self._blocks(trip):
            order = piece[some].argsort(kind="stable")
            pieces = piece[some][order]
            starts = [0, *((pieces[1:] != pieces[:-1]).nonzero()[0] + 1).tolist()]
            table, weights = block.read(n[order], name, pieces[starts])
            coefficients = np.empty((len(n), table.shape[2]))
            for i, (low, high) in enumerate(zip(starts, [*starts[1:], len(n)], strict=True)):
                np.matmul(weights[:, low:high].T, table[:, i], out=coefficients[low:high])
            found[some][order] = values(coefficients, x[some][order, None])[:, 0]
        return self._levelled(found, name)

    def _levelled(self, found: Array, name: Series) -> Array:
        """What is asked for, from ``W`` or ``zeta``."""
        if name == "wave":
            return found
        return found + self.setting.origin if name == "z" else self.setting.push + self.setting.rate * found

    def _sampled(self, t: Array, name: Series, sample: Callable[..., None]) -> Array:
        """``W`` or ``zeta`` at ascending instants, by compiled code."""
        found, firsts = np.empty(len(t)), [self.number + block.start - self.before for block in self.blocks]
        cuts = [0, *t.searchsorted([2.0 * first for first in firsts[1:]]).tolist(), len(t)]
        for block, first, low, high in zip(self.blocks, firsts, cuts[:-1], cuts[1:], strict=True):
            if low < high and isinstance(block, SeriesBlock):
                most = min(block.count, self.number + self.count - first)
                numbers = np.array([first, block.count, most], dtype=float)
                sample(t[low:high], self.setting.edges, block.curve(name), numbers, found[low:high])
        return found

    def _blocks(self, trip: Array) -> Iterator[tuple[Block | SeriesBlock, slice, Array]]:
        """The blocks of ascending round trips, counted from the first: where they are, and counted from the block's."""
        cuts = trip.searchsorted([block.start - self.before for block in self.blocks[1:]]).tolist()
        for block, low, high in zip(self.blocks, [0, *cuts], [*cuts, len(trip)], strict=True):
            if low < high:
                yield block, slice(low, high), trip[low:high] + float(self.before - block.start)

    def _on_pieces(self, first: int, stop: int, name: Series) -> Array:
        """(n, P, k) ``W`` or ``zeta`` on the pieces of consecutive round trips, counted from the first."""
        parts = [block.on_pieces(n, name) for block, _, n in self._blocks(np.arange(first, float(stop)))]
        return np.concatenate(parts)

    def record(self, first: int, stop: int) -> Record:
        """Some of the round trips, counted from the first, piece by piece."""
        setting, edges = self.setting, self.setting.edges
        count, P, touching = stop - first, len(edges) - 1, setting.loading > 0.0
        wave, zeta = self._on_pieces(first, stop, "wave"), self._on_pieces(first, stop, "z")
        ends = [block.ends(n) for block, _, n in self._blocks(np.arange(first + 1.0, stop + 1.0))]
        push = self._pushes(zeta)
        z = zeta.copy()
        z[:, :, 0] += setting.origin
        coef = np.concatenate((wave, z, push), axis=2)
        degree = np.tile([wave.shape[2] - 1, z.shape[2] - 1, push.shape[2] - 1], (count * P, 1))
        endings = np.zeros((count, 7))
        endings[:, 0], endings[:, 1:3] = self.error, np.concatenate([levels for levels, _ in ends])
        if touching:
            T = setting.transit
            endings[:, 3] = T * 2.0 * self.number if self.impact is None else self.impact.start
            endings[:, 4] = T * 2.0 * (self.number + np.arange(first, stop) + 1.0)
            endings[:, 5], endings[:, 6] = np.concatenate([impulses for _, impulses in ends]), self._peaks()[first:stop]
        marks = np.zeros((count, 4), dtype=np.int64)
        marks[:, 0], marks[:, 1] = self.index, touching
        return Record(
            number=self.number + first,
            share=self.share,
            width=setting.degree + 1,
            first=P * np.arange(count + 1),
            low=np.tile(edges[:-1], count),
            high=np.tile(edges[1:], count),
            start=coef.shape[2] * np.arange(count * P),
            degree=degree,
            coef=coef.ravel(),
            endings=endings,
            marks=marks,
            impacts=self.impacts,
        )

    def pushes(self, first: int, stop: int) -> Array:
        """``d p`` (n, P, K) on the pieces of consecutive round trips, counted from the first."""
        return self._pushes(self._on_pieces(first, stop, "z"))

    def _pushes(self, zeta: Array) -> Array:
        setting = self.setting
        push = (
            setting.rate * zeta if setting.rate else np.zeros((*zeta.shape[:2], 2))
        )  # two terms, as bounds by slopes need
        push[:, :, 0] += setting.push
        return push

    def _peaks(self) -> Array:
        """Largest stress [Pa] of the impact up to the end of each round trip."""
        if "peaks" not in self._made:
            self._made["peaks"] = running_peaks(self)
        peaks = self._made["peaks"]
        assert isinstance(peaks, np.ndarray)
        return peaks

    def window(self, i: int) -> Window:
        """The i-th round trip on its own."""
        chunk = i // CHUNK
        key = ("record", chunk)
        if key not in self._made:
            for other in [other for other in self._made if isinstance(other, tuple)]:
                del self._made[other]
            self._made[key] = self.record(chunk * CHUNK, min((chunk + 1) * CHUNK, self.count))
        record = self._made[key]
        assert isinstance(record, Record)
        return record.window(i - chunk * CHUNK)

    def last(self, count: int) -> Record | EventFreeInterval:
        """The last round trips."""
        gone = self.count - count
        if gone <= 0:
            return self
        if count <= CHUNK:
            return self.record(gone, self.count)
        return replace(
            self,
            number=self.number + gone,
            count=count,
            before=self.before + gone,
            impact=self.record(gone - 1, gone).window(0).end.impact,
            blocks=[block for block in self.blocks if block.start + block.count > self.before + gone],
            _made={},
        )


def running_peaks(interval: EventFreeInterval) -> Array:
    """Largest stress (count,) [Pa] of the impact up to the end of each round trip."""
    impact = interval.impact
    best = -np.inf if impact is None else impact.peak_stress * interval.mobility
    found = []
    for low in range(0, len(interval), CHUNK):
        push = interval.pushes(low, min(low + CHUNK, len(interval)))
        flat = push.reshape(-1, push.shape[2])
        least = np.maximum(left_ends(flat), right_ends(flat)).reshape(push.shape[:2]).max(axis=1)
        most = upper_bounds(flat).reshape(push.shape[:2]).max(axis=1)
        before = np.maximum.accumulate(np.append(best, least))[:-1]
        for i in np.flatnonzero(most > np.maximum(before, least)):
            least[i] = max(least[i], supremum(push[i])[0])
        found.append(np.maximum.accumulate(np.append(best, least))[1:])
        best = float(found[-1][-1])
    return np.concatenate(found) / interval.mobility
