r"""Disturbances that come far through a loop with lines of two slopes, found in floating point.

``phi_i = a sigma`` below 0 and ``b sigma`` above.  Along the pieces that a signal goes through the loop is linear,
``z = T w``; ``T' z`` over its length is the next signal (power iteration; Tierno, Murray, Doyle, Gregory 1997).  In
continuous time ``w`` is constant on short steps, and so is ``mu`` in the search.  A checker decides what the rounded
signal does.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

from lure.analysis.deadline import checkpoint
from lure.arrays import Reals, linalg, np

LENGTHS, _STARTS, _TURNS, _SEED, _BITS = (40, 100), 60, 60, 20261122, 16
_PATIENCE, _GAINED = 5, 1e-4  # turns, and by how much more is to come through after these


class Loop:
    """The matrices of a loop whose functions see no later one at once, taken apart.

    Parameters
    ----------
    plant : sequence of ndarray
        ``A``, ``B``, ``C`` and ``D``; among the functions ``D`` is 0 on and above the diagonal.
    own : sequence of int
        The channels from ``z`` to ``w``; the others are functions, in order.
    """

    def __init__(self, plant: Sequence[Reals], own: Sequence[int]) -> None:
        A, B, C, D = plant
        functions = [i for i in range(len(D)) if i not in own]
        self.A, self.Bf, self.Bw, self.Cf, self.Cz = A, B[:, functions], B[:, [*own]], C[functions], C[[*own]]
        self.Dff, self.Dfw = D[np.ix_(functions, functions)], D[np.ix_(functions, own)]
        self.Dzf, self.Dzw = D[np.ix_(own, functions)], D[np.ix_(own, own)]
        self.layered = bool(self.Dff.any())

    def held(self, step: float) -> Loop:
        """The loop in discrete time whose inputs are constant on steps."""
        n, found = len(self.A), object.__new__(Loop)
        found.__dict__.update(self.__dict__)
        inputs = np.hstack([self.Bf, self.Bw])
        width = inputs.shape[1]
        whole = linalg.expm(np.block([[self.A, inputs], [np.zeros((width, n + width))]]) * step)
        found.A, found.Bf, found.Bw = (
            whole[:n, :n],
            whole[:n, n : n + self.Bf.shape[1]],
            whole[:n, n + self.Bf.shape[1] :],
        )
        return found

    def outward(self, sigma: Reals, slopes: Reals) -> tuple[Reals, Reals]:
        """The gains on the side where ``sigma`` is, and ``mu``; ``sigma`` is given without what functions add to it."""
        if not self.layered:
            gains = np.where(sigma > 0, slopes[:, 1], slopes[:, 0])
            return gains, -gains * sigma
        gains, mu = np.empty_like(sigma), np.zeros_like(sigma)
        for i in range(sigma.shape[1]):
            own = sigma[:, i] + mu[:, :i] @ self.Dff[i, :i]
            gains[:, i] = np.where(own > 0, slopes[i, 1], slopes[i, 0])
            mu[:, i] = -gains[:, i] * own
        return gains, mu

    def inward(self, toward: Reals, gains: Reals) -> Reals:
        """The adjoint of :meth:`outward`: from what ``mu`` does to what ``sigma`` does."""
        into = -gains * toward
        if self.layered:
            for i in reversed(range(gains.shape[1])):
                into[:, i] = -gains[:, i] * (toward[:, i] + into[:, i + 1 :] @ self.Dff[i + 1 :, i])
        return into


def signals(loop: Loop, slopes: Reals, length: int, starts: int = _STARTS) -> tuple[float, Reals]:
    """The gain found, and a signal (length, inputs) that has it, its largest entry about 1.

    Parameters
    ----------
    loop : Loop
        In discrete time.
    slopes : ndarray
        (functions, 2) below and above 0.
    length : int
        Samples.
    starts : int
        How many signals it begins from.
    """
    w = np.random.default_rng(_SEED).normal(size=(starts, length, loop.Bw.shape[1]))
    best, found, before = 0.0, w[0], list[float]()
    for _ in range(_TURNS):
        checkpoint()
        before.append(best)
        if len(before) > 2 * _PATIENCE and best < before[-_PATIENCE] * (1 + _GAINED):
            break
        x, gains, outputs = np.zeros((starts, len(loop.A))), list[Reals](), list[Reals]()
        for t in range(length):
            now, mu = loop.outward(x @ loop.Cf.T + w[:, t] @ loop.Dfw.T, slopes)
            gains.append(now)
            outputs.append(x @ loop.Cz.T + mu @ loop.Dzf.T + w[:, t] @ loop.Dzw.T)
            x = x @ loop.A.T + mu @ loop.Bf.T + w[:, t] @ loop.Bw.T
        reached = np.sqrt(sum((z**2).sum(1) for z in outputs) / np.maximum((w**2).sum((1, 2)), 1e-300))
        if reached.max() > best:
            best, found = float(reached.max()), w[reached.argmax()].copy()
        p, w = np.zeros((starts, len(loop.A))), np.zeros_like(w)
        for t in reversed(range(length)):
            into = loop.inward(p @ loop.Bf + outputs[t] @ loop.Dzf, gains[t])
            w[:, t] = p @ loop.Bw + outputs[t] @ loop.Dzw + into @ loop.Dfw
            p = p @ loop.A + outputs[t] @ loop.Cz + into @ loop.Cf
        w /= np.maximum(np.abs(w).max((1, 2), keepdims=True), 1e-300)
    return best, found / (np.abs(found).max() or 1.0)


def rounded(signal: Reals) -> list[list[Fraction]]:
    """With few binary digits.

    Parameters
    ----------
    signal : ndarray
        (length, inputs).
    """
    return [[Fraction(round(float(v) * 2**_BITS), 2**_BITS) for v in row] for row in signal]


def best_signals(loop: Loop, slopes: Reals) -> Iterator[tuple[float, list[list[Fraction]]]]:
    """Signals of several lengths, the farthest first; parameters as for :func:`signals`.

    Parameters
    ----------
    loop, slopes
        As there.
    """
    found = sorted((signals(loop, slopes, length) for length in LENGTHS), key=lambda one: -one[0])
    yield from ((gain, rounded(signal)) for gain, signal in found)
