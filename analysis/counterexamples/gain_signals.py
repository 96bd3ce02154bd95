r"""Disturbances that come far through a loop with lines of two slopes, in discrete time and in floating point.

``phi_i = a sigma`` below 0 and ``b sigma`` above.  Along the pieces that a signal goes through the loop is linear,
``z = T w``; ``T' z`` over its length is the next signal (power iteration).  A checker decides what the rounded
signal does.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

from lure.analysis.deadline import checkpoint
from lure.arrays import Reals, np

LENGTHS, _STARTS, _TURNS, _SEED, _BITS = (40, 100), 60, 60, 20261122, 16


def signals(
    plant: Sequence[Reals], slopes: Reals, own: Sequence[int], length: int
) -> tuple[float, list[list[Fraction]]]:
    """The gain found, and a signal that has it, its largest entry about 1.

    Parameters
    ----------
    plant : sequence of ndarray
        ``A``, ``B``, ``C`` and ``D``; no function acts on another without delay.
    slopes : ndarray
        (functions, 2) below and above 0.
    own : sequence of int
        The channels from ``z`` to ``w``; the others are functions, in order.
    length : int
        Samples.
    """
    A, B, C, D = plant
    functions = [i for i in range(len(D)) if i not in own]
    Bf, Bw, Cf, Cz = B[:, functions], B[:, [*own]], C[functions], C[[*own]]
    Dfw, Dzf, Dzw = D[np.ix_(functions, own)], D[np.ix_(own, functions)], D[np.ix_(own, own)]
    w = np.random.default_rng(_SEED).normal(size=(_STARTS, length, len(own)))
    best, found = 0.0, w[0]
    for _ in range(_TURNS):
        checkpoint()
        x, gains, outputs = np.zeros((_STARTS, len(A))), list[Reals](), list[Reals]()
        for t in range(length):
            sigma = x @ Cf.T + w[:, t] @ Dfw.T
            gains.append(np.where(sigma > 0, slopes[:, 1], slopes[:, 0]))
            mu = -gains[-1] * sigma
            outputs.append(x @ Cz.T + mu @ Dzf.T + w[:, t] @ Dzw.T)
            x = x @ A.T + mu @ Bf.T + w[:, t] @ Bw.T
        reached = np.sqrt(sum((z**2).sum(1) for z in outputs) / np.maximum((w**2).sum((1, 2)), 1e-300))
        if reached.max() > best:
            best, found = float(reached.max()), w[reached.argmax()].copy()
        p, w = np.zeros((_STARTS, len(A))), np.zeros_like(w)
        for t in reversed(range(length)):
            into = -gains[t] * (p @ Bf + outputs[t] @ Dzf)
            w[:, t] = p @ Bw + outputs[t] @ Dzw + into @ Dfw
            p = p @ A + outputs[t] @ Cz + into @ Cf
        w /= np.maximum(np.abs(w).max((1, 2), keepdims=True), 1e-300)
    found = found / (np.abs(found).max() or 1.0)
    return best, [[Fraction(round(float(v) * 2**_BITS), 2**_BITS) for v in row] for row in found]


def best_signals(
    plant: Sequence[Reals], slopes: Reals, own: Sequence[int]
) -> Iterator[tuple[float, list[list[Fraction]]]]:
    """Signals of several lengths, the farthest first; parameters as for :func:`signals`.

    Parameters
    ----------
    plant, slopes, own
        As there.
    """
    yield from sorted((signals(plant, slopes, own, length) for length in LENGTHS), key=lambda one: -one[0])
