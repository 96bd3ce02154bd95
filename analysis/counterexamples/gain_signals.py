r"""Disturbances that come far through a loop with lines of two slopes, found in floating point.

``phi_i = a sigma`` below 0 and ``b sigma`` above.  Along the pieces that a signal goes through the loop is linear,
``z = T w``; ``T' z`` over its length is the next signal (power iteration; Tierno, Murray, Doyle, Gregory 1997).  In
continuous time ``w`` is constant on short steps, and so is ``mu`` in the search.  A checker decides what the rounded
signal does.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import product
from typing import Any

from lure.analysis.deadline import checkpoint
from lure.arrays import NDArray, Reals, linalg, np
from lure.record import described, quantity

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


# Disturbances with gains that go with them: what comes far through a loop whose gains may jump at any time.
#
# Along gains ``g_i(t)`` at an end of their classes the loop is linear, ``z = T w``; ``T' z`` is the next signal, and
# each gain goes to the end at which more comes through, by the sign of ``-sigma_i (T' z)_i``.  Nothing rests on what is
# found here: a checker follows signal and gains again.

MOST_CHANNELS = 5
_MOVING_STARTS, _MOVING_TURNS, _MOVING_SEED, _MOVING_PATIENCE, _MOVING_GAINED = 8, 40, 20261123, 5, 1e-3


@described(frozen=True)
class Moving:
    """A signal and the gains beside it."""

    gain: float = quantity("What comes through over what enters")
    inputs: list[list[Fraction]] = quantity("``w`` on each step")
    ends: list[list[int]] = quantity("Of each function in each step which end of its class: 0 or 1")


class Modes:
    """The loop with each choice of ends, in steps.

    Parameters
    ----------
    loop : Loop
        The loop.
    ends : ndarray
        (functions, 2).
    step : float or None
        Length of a step on which ``w`` and the gains are constant; None in discrete time.
    """

    def __init__(self, loop: Loop, ends: Reals, step: float | None) -> None:
        sides, m = list[list[Any]](), len(ends)
        p, n = loop.Bw.shape[1], len(loop.A)
        for chosen in product((0, 1), repeat=m):
            K = np.diag(ends[range(m), chosen])
            inner = np.linalg.solve(np.eye(m) + loop.Dff @ K, np.hstack([loop.Cf, loop.Dfw]))
            A, B = loop.A - loop.Bf @ K @ inner[:, :n], loop.Bw - loop.Bf @ K @ inner[:, n:]
            z = np.hstack([loop.Cz, loop.Dzw]) - loop.Dzf @ K @ inner
            W = z.T @ z
            if step is not None:
                G = np.vstack([np.hstack([A, B]), np.zeros((p, n + p))])
                wide = linalg.expm(np.block([[-G.T, W], [np.zeros_like(G), G]]) * step)
                E, W = wide[n + p :, n + p :], wide[n + p :, n + p :].T @ wide[: n + p, n + p :]
                A, B = E[:n, :n], E[:n, n:]
            sides.append([A, B, z, inner, W])
        self.A, self.B, self.z, self.sigma, self.W = (np.stack(side) for side in zip(*sides, strict=True))
        self.places = 2 ** np.arange(m)[::-1]
        self.Bf, self.Dzf = (loop.Bf if step is None else step * loop.Bf), loop.Dzf

    def through(self, w: Reals, modes: NDArray[np.int64]) -> float:
        """The energy that one signal has in ``z``."""
        x, energy = np.zeros(self.A.shape[1]), 0.0
        for v, k in zip(w, modes, strict=True):
            X = np.concatenate([x, v])
            energy, x = energy + float(X @ self.W[k] @ X), self.A[k] @ x + self.B[k] @ v
        return energy


def moving(loop: Loop, ends: Sequence[tuple[Fraction, Fraction]], length: int, step: Fraction | None) -> Moving | None:
    """The signal with most through it, its largest entry about 1; None where nothing comes through.

    Parameters
    ----------
    loop : Loop
        The loop.
    ends : sequence of pairs of Fraction
        Least and greatest gain of each function.
    length : int
        How many steps.
    step : Fraction or None
        How long each is; None in discrete time.
    """
    own = Modes(loop, np.array([[float(v) for v in pair] for pair in ends]), None if step is None else float(step))
    rng, n = np.random.default_rng(_MOVING_SEED), len(loop.A)
    w = rng.normal(size=(_MOVING_STARTS, length, loop.Bw.shape[1]))
    modes = rng.integers(0, len(own.A), size=(_MOVING_STARTS, length))
    best, found, before = 0.0, (w[0], modes[0]), list[float]()
    for _ in range(_MOVING_TURNS):
        checkpoint()
        before.append(best)
        if len(before) > 2 * _MOVING_PATIENCE and best < before[-_MOVING_PATIENCE] * (1 + _MOVING_GAINED):
            break
        x, outputs, seen = np.zeros((_MOVING_STARTS, n)), list[Reals](), list[Reals]()
        for t in range(length):
            X, k = np.hstack([x, w[:, t]]), modes[:, t]
            outputs.append(np.einsum("sij,sj->si", own.z[k], X))
            seen.append(np.einsum("sij,sj->si", own.sigma[k], X))
            x = np.einsum("sij,sj->si", own.A[k], x) + np.einsum("sij,sj->si", own.B[k], w[:, t])
        reached = sum((z**2).sum(1) for z in outputs) / np.maximum((w**2).sum((1, 2)), 1e-300)
        top = int(np.argmax(np.where(np.isfinite(reached), reached, 0.0)))
        if reached[top] ** 0.5 > best:
            best, found = float(reached[top]) ** 0.5, (w[top].copy(), modes[top].copy())
        p, w, modes = np.zeros((_MOVING_STARTS, n)), np.zeros_like(w), modes.copy()
        for t in reversed(range(length)):
            toward = p @ own.Bf + outputs[t] @ own.Dzf
            modes[:, t] = (-toward * seen[t] > 0) @ own.places
            k = modes[:, t]
            whole = np.einsum("sj,sji->si", outputs[t], own.z[k])
            w[:, t] = np.einsum("sj,sji->si", p, own.B[k]) + whole[:, n:]
            p = np.einsum("sj,sji->si", p, own.A[k]) + whole[:, :n]
        w /= np.maximum(np.abs(w).max((1, 2), keepdims=True), 1e-300)
    signal, chosen = found
    inputs = rounded(signal / (np.abs(signal).max() or 1.0))
    exact = np.array([[float(v) for v in row] for row in inputs])
    entered = float((exact**2).sum()) * (1.0 if step is None else float(step))
    if not entered > 0:
        return None
    bits = [[int(k) // int(place) % 2 for place in own.places] for k in chosen]
    return Moving((own.through(exact, chosen) / entered) ** 0.5, inputs, bits)
