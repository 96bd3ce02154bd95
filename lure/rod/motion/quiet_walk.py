"""States of the motion block after block while nothing happens, and bounds that show how far that is."""

from __future__ import annotations

import math

import numpy as np

from lure.rod.motion.chebyshev import Array
from lure.rod.motion.quiet_powers import Powers
from lure.rod.motion.stretch import BLOCK, BLOCK_POWER

TOP = 1e-16  # of the wave: what its last coefficients may be
_CHUNK, _LARGE = 64, 100
_MARGIN = 1e-12
_CANCELLED = 4e-16


class Walk:
    """States block after block, up to the first round trip that is not certainly quiet."""

    def __init__(self, powers: Powers, number: int) -> None:
        self.powers, self.number = powers, number
        self.states: list[Array] = []
        self.rests: list[Array] = []
        self.tops: list[Array] = []
        self.starts: list[Array] = []
        self.loads: list[Array] = []
        self._tables()

    def _tables(self) -> None:
        """``zeta`` in each round trip of a block, less that in the first; bounds on what ``zeta`` does in any."""
        powers, q = self.powers, self.powers.quiet
        w, size = q.waves, powers.states.count + 1
        inside, forced = np.zeros((1, q.size)), np.zeros((1, size))
        series, constant = q.travel, q.steady
        swing, more = np.abs(series).sum(axis=1), np.zeros((q.pieces, size))
        more[:, -1] = np.abs(constant).sum(axis=1)
        for k in range(BLOCK_POWER):
            p = powers[k]
            step = powers.step(p.m)
            # row w of B + D, the identity taken off, then what is inside carried over
            row = np.zeros(q.size)
            row += p.rows[0] if q.segment.rate == 0.0 else p.rows[w]
            later = inside * p.beta + inside[:, p.place] @ p.rows + row
            load = inside @ p.load + forced @ step + p.load[w]
            inside, forced = np.vstack((inside, later)), np.vstack((forced, load))
            more = swing @ np.abs(p.load) + more @ np.maximum(np.abs(step), np.eye(size))
            swing = swing * np.maximum(1.0, np.abs(p.beta)) + swing[:, p.place] @ np.abs(p.rows)
        self._inside, self._forced, self._swing, self._more = inside, forced, swing, more

    def along(self, X: Array, rest: float, most: int) -> int:
        """Number of quiet round trips, at most ``most``."""
        q, done = self.powers.quiet, 0
        w, segment = q.waves, q.segment
        low, high = segment.low - segment.origin, segment.high - segment.origin
        self.ahead, self.ahead_rest = X, rest
        blocks = _CHUNK if q.size < _LARGE else 1
        while done < most:
            n = self.number + done
            blocks = min(blocks * 8, _CHUNK, -(-(most - done) // BLOCK))
            u = self.powers.at(self.powers.number_of(n, blocks))
            states, rests = self._chunk(u)
            self.loads.append(u)
            swing = (np.abs(states) @ self._swing.T + np.abs(u) @ self._more.T).max(axis=1)
            zeta = states @ self._inside.T + u @ self._forced.T + (states[:, w] + rests)[:, None]
            margin = _MARGIN * (np.abs(zeta).max(axis=1) + swing)
            tops = zeta + (swing + margin)[:, None]
            quiet = tops < high
            if low > -math.inf:
                quiet &= zeta - (swing + margin)[:, None] > low
            sizes = np.abs(states[:, :w]).reshape(blocks, q.pieces, -1)
            fine = sizes[:, :, -1].max(axis=1) <= TOP * sizes.sum(axis=2).max(axis=1) if q.degree else True
            if segment.rate > 0.0:
                quiet &= np.reshape(fine, (-1, 1))
            self.states.append(states)
            self.rests.append(rests)
            self.tops.append(tops.ravel())
            self.starts.append(zeta.ravel())
            loud = np.flatnonzero(~quiet.ravel())
            if loud.size:
                return min(most, done + int(loud[0]))
            done += BLOCK * blocks
        return most

    def _chunk(self, u: Array) -> tuple[Array, Array]:
        """States (blocks, S) given those of the load; ``ahead`` is the one after them."""
        powers, q, blocks = self.powers, self.powers.quiet, len(u)
        states, k, filled = np.empty((blocks + 1, q.size)), BLOCK_POWER, 1
        states[0] = self.ahead
        while filled < blocks + 1:
            count = min(filled, blocks + 1 - filled)
            states[filled : filled + count] = powers[k].applied(states[:count], u[:count])
            filled, k = filled + count, k + 1
        rests = np.zeros(blocks + 1)
        if q.segment.rate == 0.0:
            travelled = travel(powers, BLOCK_POWER, states[:-1], u)
            sums = self.ahead_rest + np.concatenate(([0.0], np.cumsum(travelled)))
            start = states[0, q.waves]
            value = start + sums
            back = value - start
            rests = (start - (value - back)) + (sums - back)
            states[:, q.waves] = value
        self.ahead, self.ahead_rest = states[-1], float(rests[-1])
        return states[:-1], rests[:-1]


def travel(powers: Powers, k: int, X: Array, u: Array) -> Array:
    """What ``zeta`` travels in flight over ``2**k`` round trips; ways there and back that differ by rounding cancel."""
    gone, q = powers[k], powers.quiet
    parts = X[:, : q.waves] * gone.rows[0, : q.waves]
    way = parts.sum(axis=1)
    way[np.abs(way) <= _CANCELLED * np.abs(parts).sum(axis=1)] = 0.0
    return np.asarray(way + u @ gone.load[q.waves])
