"""The rightmost roots of a plant with dead times and constant gains around it, in floating point.

Of ``det(s - A_0 - sum A_k e^(-s T_k))``: eigenvalues of the generator, collocated at Chebyshev's points (Breda, Maset,
Vermiglio 2005), from which Newton's method goes to roots.  Nothing here is believed.
"""

from __future__ import annotations

import math
from functools import cached_property, lru_cache

from lure.analysis.deadline import checkpoint
from lure.arrays import NDArray, Reals, np
from lure.plants.delay_matrix import DelayMatrix

_LEAST_NODES, _MOST_NODES, _NEWTON, _ROOTS, _CLOSE = 12, 60, 12, 6, 1e-13
_SLOW = 1e-7  # of Newton's steps near a root that is not simple


class LateRoots:
    """The roots of a plant that is no neutral equation, for gains that are to come.

    Parameters
    ----------
    plant : DelayMatrix
        The plant.
    """

    def __init__(self, plant: DelayMatrix) -> None:
        self.sides, self.delays = plant.base.doubles(), tuple(float(delay) for delay, _ in plant.late)
        self.seen = [np.array(rows, dtype=float) for _, rows in plant.late]
        none = np.zeros((plant.order,) * 2)
        self.back = [np.array(rows, dtype=float) for rows in plant.inner] or [none] * len(self.seen)

    @cached_property
    def _nodes(self) -> int:
        size = float(np.abs(np.linalg.eigvals(self.sides[0])).max()) * self.delays[-1]
        return min(max(_LEAST_NODES, math.ceil(4 * size)), _MOST_NODES)

    def closed(self, gains: Reals) -> tuple[NDArray[np.float64], list[NDArray[np.float64]]]:
        """``A_0`` and the ``A_k`` with ``mu = -g sigma``.

        Parameters
        ----------
        gains : ndarray
            (m,), one of each channel.
        """
        A, B, C, D = self.sides
        closed = np.linalg.solve(np.eye(len(D)) + np.diag(gains) @ D, np.diag(gains))
        return A - B @ closed @ C, [own - B @ closed @ side for own, side in zip(self.back, self.seen, strict=True)]

    def spectrum(self, gains: Reals) -> NDArray[np.complex128]:
        """Eigenvalues of the collocated generator, the rightmost first.

        Parameters
        ----------
        gains : ndarray
            (m,), one of each channel.
        """
        checkpoint()
        now, later = self.closed(gains)
        weights, turn = _collocation(self._nodes, self.delays)
        n = len(now)
        whole = np.kron(turn, np.eye(n))
        whole[:n] = np.kron(weights[0], now) + sum(np.kron(w, M) for w, M in zip(weights[1:], later, strict=True))
        roots = np.linalg.eigvals(whole).astype(complex)
        return np.asarray(roots[np.argsort(-roots.real)])

    def rightmost(self, gains: Reals) -> complex:
        """The rightmost root to which Newton's method goes; of a pair that with ``Im s >= 0``.

        Parameters
        ----------
        gains : ndarray
            (m,), one of each channel.
        """
        now, later = self.closed(gains)
        one, found, starts = np.eye(len(now)), list[complex](), self.spectrum(gains)
        for start in starts[: _ROOTS * len(now)]:
            s = complex(start)
            for _ in range(_NEWTON):
                waits = [np.exp(-s * delay) * M for delay, M in zip(self.delays, later, strict=True)]
                slope = one + sum(delay * M for delay, M in zip(self.delays, waits, strict=True))
                try:
                    step = 1 / np.trace(np.linalg.solve(s * one - now - sum(waits), slope))
                except np.linalg.LinAlgError:  # a root
                    step = 0.0
                s -= step
                if abs(step) <= _CLOSE * abs(s):
                    break
            if abs(step) <= _SLOW * abs(s):
                found.append(complex(s.real, abs(s.imag)))
        return max(found, key=lambda s: s.real, default=complex(starts[0]))


@lru_cache(maxsize=8)
def _collocation(count: int, delays: tuple[float, ...]) -> tuple[list[NDArray[np.float64]], NDArray[np.float64]]:
    """Rows that interpolate at 0 and at each ``-T_k`` from Chebyshev's points on ``[-T, 0]``, and the derivative."""
    angles = np.pi * np.arange(count + 1) / count
    points = (np.cos(angles) - 1) * delays[-1] / 2
    signs = (-1.0) ** np.arange(count + 1)
    signs[[0, -1]] /= 2
    gaps = points[:, None] - points + np.eye(count + 1)
    turn = signs / signs[:, None] / gaps
    np.fill_diagonal(turn, 0)
    np.fill_diagonal(turn, -turn.sum(axis=1))
    rows = [np.eye(count + 1)[:1]]
    for delay in delays:
        away = -delay - points
        at = np.abs(away) < 1e-14 * delays[-1]
        row = at.astype(float) if at.any() else signs / away
        rows.append((row / row.sum())[None])
    return rows, turn
