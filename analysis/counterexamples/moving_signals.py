r"""Disturbances with gains that go with them: what comes far through a loop whose gains may jump at any time.

Along gains ``g_i(t)`` at an end of their classes the loop is linear, ``z = T w``; ``T' z`` is the next signal, and each
gain goes to the end at which more comes through, by the sign of ``-sigma_i (T' z)_i``.  Nothing rests on what is found
here: a checker follows signal and gains again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from typing import Any

from lure.analysis.counterexamples.gain_signals import Loop, rounded
from lure.analysis.deadline import checkpoint
from lure.arrays import NDArray, Reals, linalg, np

MOST_CHANNELS = 5
_STARTS, _TURNS, _SEED, _PATIENCE, _GAINED = 8, 40, 20261123, 5, 1e-3


@dataclass(frozen=True)
class Moving:
    """A signal and the gains beside it.

    Attributes
    ----------
    gain : float
        What comes through over what enters.
    inputs : list of list of Fraction
        ``w`` on each step.
    ends : list of list of int
        Of each function in each step which end of its class: 0 or 1.
    """

    gain: float
    inputs: list[list[Fraction]]
    ends: list[list[int]]


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
    rng, n = np.random.default_rng(_SEED), len(loop.A)
    w = rng.normal(size=(_STARTS, length, loop.Bw.shape[1]))
    modes = rng.integers(0, len(own.A), size=(_STARTS, length))
    best, found, before = 0.0, (w[0], modes[0]), list[float]()
    for _ in range(_TURNS):
        checkpoint()
        before.append(best)
        if len(before) > 2 * _PATIENCE and best < before[-_PATIENCE] * (1 + _GAINED):
            break
        x, outputs, seen = np.zeros((_STARTS, n)), list[Reals](), list[Reals]()
        for t in range(length):
            X, k = np.hstack([x, w[:, t]]), modes[:, t]
            outputs.append(np.einsum("sij,sj->si", own.z[k], X))
            seen.append(np.einsum("sij,sj->si", own.sigma[k], X))
            x = np.einsum("sij,sj->si", own.A[k], x) + np.einsum("sij,sj->si", own.B[k], w[:, t])
        reached = sum((z**2).sum(1) for z in outputs) / np.maximum((w**2).sum((1, 2)), 1e-300)
        top = int(np.argmax(np.where(np.isfinite(reached), reached, 0.0)))
        if reached[top] ** 0.5 > best:
            best, found = float(reached[top]) ** 0.5, (w[top].copy(), modes[top].copy())
        p, w, modes = np.zeros((_STARTS, n)), np.zeros_like(w), modes.copy()
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
