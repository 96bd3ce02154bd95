"""Constant gains and constant delays with a large gain from ``w`` to ``z``, in floating point; nothing is believed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

from lure.analysis.deadline import checkpoint
from lure.arrays import NDArray, np, optimize

_GRID, _STEPS, _CORNERS, _REFINED, _SPREAD = 300, 9, 64, 3, 30.0


def _solved(left: NDArray[Any], right: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """``left^-1 right`` for each matrix; 0 where floating point has no finite inverse."""
    singular = ~(np.abs(np.linalg.det(left)) > 0)
    found = np.linalg.solve(np.where(singular[:, None, None], np.eye(left.shape[-1]), left), right)
    finite = np.isfinite(found).all(axis=(1, 2)) & ~singular
    return np.asarray(np.where(finite[:, None, None], found, 0))


class Delayed(NamedTuple):
    """The gain, of which gains and delays (one a block), at which frequency [rad/s] and for which input."""

    gain: float
    gains: NDArray[np.float64]
    delays: NDArray[np.float64]
    omega: float
    direction: NDArray[np.complex128]


@dataclass
class DelayedMembers:
    """The search for one plant ``(A, B, C, D)`` in continuous time.

    Attributes
    ----------
    sides : tuple of ndarray
        ``A``, ``B``, ``C`` and ``D``.
    own : sequence of int
        The channels from ``z`` to ``w``.
    functions, late : sequence of sequence of int
        The channels of each gain, and of each delay.
    bounds : ndarray
        (len(functions), 2), between which the gains lie.
    longest : ndarray
        Bounds of the delays [s].
    """

    sides: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]
    own: Sequence[int]
    functions: Sequence[Sequence[int]]
    late: Sequence[Sequence[int]]
    bounds: NDArray[np.float64]
    longest: NDArray[np.float64]

    def _response(self, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        A, B, C, D = self.sides
        states = _solved(1j * omega[:, None, None] * np.eye(len(A)) - A, B.astype(complex))
        return np.asarray(C @ states + D)

    def _through(
        self,
        gains: NDArray[np.float64],
        delays: NDArray[np.float64],
        omega: NDArray[np.float64],
        H: NDArray[np.complex128],
    ) -> NDArray[np.complex128]:
        """``T`` at the frequencies; 0 where the loop is singular in floating point, which shows no gain."""
        G = np.zeros((len(omega), H.shape[-1]), dtype=complex)
        for block, gain in zip(self.functions, gains, strict=True):
            G[:, [*block]] = gain
        for block, delay in zip(self.late, delays, strict=True):
            G[:, [*block]] = np.exp(-1j * omega * delay)[:, None]
        closed = np.eye(H.shape[-1]) + H * G[:, None, :]
        own = [*self.own]
        return _solved(closed, H[:, :, own])[:, own]

    def best(self) -> Delayed | None:
        """The largest gain found, between the ends of a grid of frequencies: from corners of the gains on."""
        size = np.abs(np.linalg.eigvals(self.sides[0]))
        slow, fast = min([*size[size > 0], *(1 / self.longest)]), max([*size, *(1 / self.longest)])
        omega = np.geomspace(slow / _SPREAD, fast * _SPREAD, _GRID)
        H = self._response(omega)
        found: list[tuple[float, NDArray[np.float64]]] = []
        corners = [np.array(v) for v in product(*self.bounds)][:_CORNERS]
        shares = np.linspace(0, 1, _STEPS)
        some = [np.full(len(self.late), s) for s in shares] + [np.eye(len(self.late))[k] for k in range(len(self.late))]
        for gains, share in product(corners, some):
            checkpoint()
            sizes = np.linalg.norm(self._through(gains, share * self.longest, omega, H), 2, axis=(1, 2))
            at = int(sizes.argmax())
            found.append((float(sizes[at]), np.concatenate([gains, share * self.longest, [math.log(omega[at])]])))
        found.sort(key=lambda one: -one[0])
        low = np.concatenate([self.bounds[:, 0], 0 * self.longest, np.log(omega[:1])])
        high = np.concatenate([self.bounds[:, 1], self.longest, np.log(omega[-1:])])
        best: Delayed | None = None

        def member(point: NDArray[np.float64]) -> Delayed:
            checkpoint()
            point, count = np.clip(point, low, high), len(self.functions)
            where = np.exp(point[-1:])
            T = self._through(point[:count], point[count:-1], where, self._response(where))[0]
            _, sizes, right = np.linalg.svd(T)
            return Delayed(float(sizes[0]), point[:count], point[count:-1], float(where[0]), right[0].conj())

        for _, start in found[:_REFINED]:
            done = optimize.minimize(lambda point: -member(point).gain, start, method="Nelder-Mead")
            one = member(done.x)
            best = one if best is None or one.gain > best.gain else best
        return best
