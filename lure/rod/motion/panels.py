"""The loads as Chebyshev series on panels, over many round trips at once.

A panel reaches over up to 16 round trips if the load is made of sines, cosines, sums and products, which 29 points show
as they are; of other formulas (a pulse ``exp(-t**2)`` may hide between points) a panel reaches over one round trip at
most, as in :meth:`lure.rod.motion.sources.Sources.loads`.  What a block of 16 round trips needs does not depend on
how many
blocks are asked for at once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lure.errors import InputError
from lure.expressions.tree import Apply, Node, Number, names
from lure.rod.motion.chebyshev import Array, basis, tails
from lure.rod.motion.kernel_data import BLOCK, Counts
from lure.rod.motion.pieces import NARROWEST, SAME, distinct, fitted
from lure.rod.motion.sources import Sources

_SPAN = 2.0 * BLOCK
_CHECKS = np.array([-0.97, -0.83, -0.64, -0.43, -0.29, -0.17, 0.11, 0.26, 0.38, 0.59, 0.71, 0.9])
_MOST = 5000
_NOISE = 1e-16

Load = tuple[Array, Counts]
NO_LOAD: Load = np.empty(0), np.empty(0, dtype=np.int64)


@dataclass(kw_only=True, slots=True)
class Panels:
    """Makes the panels of one motion, block after block.

    Attributes
    ----------
    sources : Sources
        The loads.
    transits : float
        Length of the motion [transits]: loads are not asked for beyond.
    scale : float
        A lower bound of the size of the wave when the next block begins [m/s].
    width : float
        With which panels begin [transits]: what half of the panels of block 0 were cut down to.
    """

    sources: Sources
    transits: float
    scale: float
    width: float = 2.0

    def over(self, first: int, count: int) -> Load:
        """The panels of blocks ``first .. first + count - 1``; blocks are asked for in order.

        Returns
        -------
        panels : ndarray
            For each panel its ends from the start of its block [transits], its largest value and its error [m/s], the
            ``N + 1`` coefficients, and bounds on the k-th coefficient of a part, per k-th power of its share of the
            width.
        heads : ndarray
            The first block, the first panel of each block, the number of panels, and the degree of each.

        Raises
        ------
        InputError
            More than 5000 panels are needed in a round trip, or the load is not finite.
        """
        if not _gentle(self.sources):
            return _load(first, count, [self._halved(number) for number in range(first, first + count)])
        block, low, high = self._begun(first, count)
        space = basis(self.sources.degree)
        nodes = np.concatenate((space.inner, _CHECKS))
        seen = np.polynomial.chebyshev.chebvander(_CHECKS, space.degree).T
        scales: Array | None = None
        done: list[tuple[Array, ...]] = []
        while low.size:
            half = 0.5 * (high - low)[:, None]
            t = _SPAN * block[:, None] + (low[:, None] + half * (nodes + 1.0))
            flat, noise = (v.reshape(t.shape) for v in self.sources.added(t.ravel()))
            if scales is None:
                scales = self._scales(block - first, np.abs(flat).max(axis=1), count)
            series = flat[:, : space.degree + 1] @ space.from_inner.T
            miss = np.abs(series @ seen - flat[:, space.degree + 1 :]).max(axis=1)
            miss = np.maximum(miss, tails(series))
            allowed = 3e-15 * scales[block - first] + 8.0 * noise.max(axis=1)
            good = (miss <= allowed) | (high - low < NARROWEST)
            size = np.abs(flat[good]).max(axis=1)
            tiny = np.maximum(_NOISE * size, 0.5 * noise[good].max(axis=1))
            done.append((block[good], low[good], high[good], series[good], size, miss[good], tiny))
            block, low, high = (v[~good] for v in (block, low, high))
            self._check(block, low)
            middle = 0.5 * (low + high)
            block, low, high = np.repeat(block, 2), _woven(low, middle), _woven(middle, high)
        if first == 0:
            self.width = float(np.median(np.concatenate([np.minimum(part[2] - part[1], 2.0) for part in done])))
        return _load(first, count, done)

    def _halved(self, number: int) -> tuple[Array, ...]:
        """The panels of one block as :func:`lure.rod.motion.pieces.fitted` finds kinks, jumps and pulses."""
        origin = _SPAN * number
        end = min(_SPAN, self.transits - origin)
        points = [point - origin for point in self.sources.load_breaks()] + [2.0 * k for k in range(1, BLOCK)]
        pieces, error = fitted(
            lambda tau: self.sources.added(origin + tau), distinct(points, 0.0, end), self.sources.degree, self.scale
        )
        size = np.abs(pieces.series).sum(axis=1)
        self.scale = max(abs(self.sources.echo) ** BLOCK * self.scale, float(size.max()))
        ones = np.ones(len(size))
        return (
            number * ones,
            pieces.edges[:-1],
            pieces.edges[1:],
            pieces.series,
            size,
            error / end * ones,
            _NOISE * size,
        )

    def _begun(self, first: int, count: int) -> tuple[Counts, Array, Array]:
        """Blocks and ends of the panels to begin with."""
        breaks = np.unique([b for b in self.sources.load_breaks() if _SPAN * first < b < _SPAN * (first + count)])
        owner = np.floor(breaks / _SPAN).astype(np.int64)
        # where a block is not whole, panels begin and end with round trips, so that their halves meet the echoes' edges
        fine = np.full(count, self.width < 2.0)
        fine[owner - first] = True
        fine |= _SPAN * (np.arange(first, first + count) + 1) > self.transits
        step = 2.0 ** math.ceil(math.log2(self.width))
        grid = step * np.arange(round(_SPAN / step))
        block = np.repeat(np.arange(first, first + count), np.where(fine, len(grid), 1))
        low = np.concatenate([grid if many else grid[:1] for many in fine])
        inside = _SPAN * block + low < self.transits - SAME
        block, low = block[inside], low[inside]
        high = np.minimum(low + np.where(fine[block - first], step, _SPAN), self.transits - _SPAN * block)
        if not breaks.size:
            return block, low, high
        place = breaks - _SPAN * owner
        near = np.searchsorted(_SPAN * block + low, breaks, side="right") - 1
        keep = (place > low[near] + SAME) & (place < high[near] - SAME)
        owner, place, near = owner[keep], place[keep], near[keep]
        block, low = np.concatenate((block, owner)), np.concatenate((low, place))
        order = np.lexsort((low, block))
        ends = np.concatenate((high, high[near]))[order]
        block, low = block[order], low[order]
        same = block[1:] == block[:-1]
        high = ends.copy()
        high[:-1][same] = np.minimum(high[:-1][same], low[1:][same])
        wide = high - low > SAME
        return block[wide], low[wide], high[wide]

    def _scales(self, block: Counts, size: Array, count: int) -> Array:
        """Size to which errors in each block are relative."""
        largest = np.zeros(count)
        np.maximum.at(largest, block, size)
        decay = abs(self.sources.echo) ** BLOCK
        found = np.empty(count)
        for i, new in enumerate(largest.tolist()):
            found[i] = self.scale = max(decay * self.scale, new)
        return found

    def _check(self, block: Counts, low: Array) -> None:
        """Refuse loads that need more than 5000 panels in a round trip."""
        if len(low) > _MOST // 2 and np.unique((_SPAN * block + low) // 2.0, return_counts=True)[1].max() > _MOST // 2:
            raise InputError(
                f"the loads and initial data need more than {_MOST} pieces in one round trip; give smoother or slower "
                "ones"
            )


def _woven(first: Array, second: Array) -> Array:
    return np.column_stack((first, second)).ravel()


def _load(first: int, count: int, done: list[tuple[Array, ...]]) -> Load:
    block, low, high, series, size, miss, tiny = (np.concatenate(parts) for parts in zip(*done, strict=True))
    order = np.lexsort((low, block))
    block, low, high, series, size, miss, tiny = (v[order] for v in (block, low, high, series, size, miss, tiny))
    seen = np.abs(series) > tiny[:, None]
    last = series.shape[1] - 1
    degree = np.where(seen.any(axis=1), last - seen[:, ::-1].argmax(axis=1), 0)
    series = np.where(np.arange(last + 1) <= degree[:, None], series, 0.0)
    table = np.column_stack((low, high, size, miss, series, np.abs(series) @ _growth(last).T))
    starts = np.searchsorted(block, np.arange(first, first + count + 1))
    return table.ravel(), np.concatenate(([first], starts, degree)).astype(np.int64)


def _growth(degree: int) -> Array:
    """``T_j^(k)(1)/(2^{k-1} k!)`` (N+1, N+1): times ``r^k`` it bounds the k-th coefficient of ``T_j(a + r x)``."""
    j = np.arange(degree + 1, dtype=float)
    rows = [np.ones(degree + 1)]
    for k in range(1, degree + 1):
        factor = (j**2 - (k - 1.0) ** 2) / (2.0 * k - 1.0) / ((2.0 if k > 1 else 1.0) * k)
        rows.append(rows[-1] * factor)
    return np.array(rows)


def _gentle(sources: Sources) -> bool:
    """Whether the loads are sums and products of sines, cosines and few powers."""
    scenario = sources.scenario
    return scenario.body_force.is_zero and _mild(scenario.force.tree)


def _mild(node: Node) -> bool:
    if not isinstance(node, Apply):
        return True
    if node.operation in ("+", "-", "*", "neg", "sin", "cos", "pi"):
        return all(_mild(part) for part in node.arguments)
    if node.operation == "/":
        return _mild(node.arguments[0]) and not names(node.arguments[1])
    if node.operation == "**":
        base, exponent = node.arguments
        return _mild(base) and isinstance(exponent, Number) and exponent.value in (0, 1, 2, 3, 4)
    return not names(node)


def block_count(transits: float) -> int:
    """Number of blocks of a motion."""
    return math.ceil(transits / _SPAN)
