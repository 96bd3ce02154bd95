r"""The energy of the waves in the rod at many instants, without loads along it: integrals of squares over a transit.

.. math:: \int_0^L (\rho v^2 + E w^2)\,dx = \frac{\rho c}{2} \int_0^T \big(V(t - s)^2 + W(t + s)^2\big)\,ds,

for the backward wave at ``x`` left the end ``(L - x)/c`` ago and the forward wave will be there in as long.  Both are
polynomials on pieces, whose squares Gauss quadrature integrates exactly, whatever kinks there are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lure.rod.motion.chebyshev import Array, basis, values
from lure.rod.motion.pieces import Pieces, joined
from lure.rod.motion.record import Record, Trips, record_of
from lure.rod.motion.sources import Sources


def squares_over_a_transit(sources: Sources, share: float, trips: Trips, t: Array) -> Array:
    """``int_0^1 (V(t - s)^2 + W(t + s)^2) ds`` (n,) at instants (n,) [transits] that the round trips cover."""
    if isinstance(trips, Record):
        return _squares(sources, trips, t)
    total = np.empty(len(t))
    trip = np.clip(np.floor(0.5 * t).astype(np.int64) - trips.number, 0, len(trips) - 1)
    for i in np.unique(trip):
        near = [trips.window(j) for j in range(max(i - 1, 0), min(i + 2, len(trips)))]
        total[trip == i] = _squares(sources, record_of(near, share), t[trip == i])
    return total


def _squares(sources: Sources, record: Record, t: Array) -> Array:
    """The same from one record."""
    stop = 2.0 * (record.number + len(record) - 1) + record.stop
    total = _of_record(record, np.maximum(t - 1.0, 0.0), t, returned=True)
    total += _of_record(record, t, np.minimum(t + 1.0, stop), returned=False)
    early = t < 1.0
    if early.any():  # as if the end x = 0 gave back minus what comes: then W(tau) = -V(tau - 2) for 1 < tau < 2
        before = replace(sources, echo=-1.0).initial_wave()[0]
        total[early] += _of_pieces(before, t[early] + 1.0, np.full(int(early.sum()), 2.0))
    late = t + 1.0 > stop
    number = int(stop // 2.0)
    for n in (number, number + 1) if late.any() else ():
        span = min(2.0, stop + 1.0 - 2.0 * n)
        low, high = np.clip(stop - 2.0 * n, 0.0, span), np.clip(t[late] + 1.0 - 2.0 * n, 0.0, span)
        if span > 0.0:
            total[late] += _of_pieces(_incoming(sources, record, n, span), np.minimum(low, high), high)
    return total


def _incoming(sources: Sources, record: Record, n: int, span: float) -> Pieces:
    """``W`` in a round trip, up to one transit after the end of the motion."""
    if n == 0:
        wave = sources.initial_wave()[0]
    else:
        i = n - 1 - record.number
        returned = (2.0 * record.share - 1.0) * record.series(i, 0) - 2.0 * record.series(i, 2)
        wave = Pieces(record.edges(i), sources.echo * returned)
    edges = wave.edges[wave.edges < span]
    wave = wave.on(np.append(edges, min(span, float(wave.edges[-1]))))
    added = sources.loads(n, span, 0.0)
    if added is None:
        return wave
    wave, load = joined(wave, added[0])
    return Pieces(wave.edges, wave.series + load.series)


def _of_pieces(pieces: Pieces, low: Array, high: Array) -> Array:
    """Integrals (n,) of the square from ``low`` to ``high`` (n,)."""
    edges = pieces.edges
    first = np.clip(np.searchsorted(edges, low, side="right") - 1, 0, len(edges) - 2)
    last = np.clip(np.searchsorted(edges, high, side="left") - 1, first, len(edges) - 2)
    return _sums((edges[:-1], edges[1:]), lambda i: pieces.series[i], (first, low), (last, high))


def _of_record(record: Record, low: Array, high: Array, *, returned: bool) -> Array:
    """The same for ``V`` or ``W``, instants in transits from the start of the motion."""

    def rows(i: NDArray[np.int64]) -> Array:
        """Coefficients (m, N+1)."""
        wave = record.rows(i, 0)
        return (2.0 * record.share - 1.0) * wave - 2.0 * record.rows(i, 2) if returned else wave

    return _sums((record.low, record.high), rows, record.found(low), record.found(high))


def _sums(
    ends: tuple[Array, Array],
    rows: Callable[[NDArray[np.int64]], Array],
    begin: tuple[NDArray[np.int64], Array],
    end: tuple[NDArray[np.int64], Array],
) -> Array:
    """Integrals of squares from a place on one piece to a place on a later one, the pieces between taken once."""
    (start, stop), (first, low), (last, high) = ends, begin, end

    def part(i: NDArray[np.int64], a: Array, b: Array) -> Array:
        """Over a part of each piece."""
        coefficients = rows(i)
        space = basis(coefficients.shape[1] - 1)
        half = np.maximum(0.5 * (b - a), 0.0)
        at = a[:, None] + half[:, None] * (space.gauss + 1.0)
        x = ((at - start[i, None]) - (stop[i, None] - at)) / (stop[i, None] - start[i, None])
        return np.asarray(half * (values(coefficients, x) ** 2 @ space.weights))

    one = first == last
    total = part(first, low, np.where(one, high, stop[first]))
    total += np.where(one, 0.0, part(last, start[last], high))
    counts = np.maximum(last - first - 1, 0)
    owner = np.repeat(np.arange(len(first)), counts)
    between = np.arange(len(owner)) - (np.cumsum(counts) - counts)[owner] + first[owner] + 1
    pieces, which = np.unique(between, return_inverse=True)
    whole = part(pieces, start[pieces], stop[pieces])
    return np.asarray(total + np.bincount(owner, whole[which], minlength=len(first)))
