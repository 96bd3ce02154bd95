"""In which order the values of a periodic orbit can lie: the finite choice behind every monotone law through it."""

from __future__ import annotations

import itertools
import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Family = Literal["monotone", "odd", "sector"]

EXHAUSTIVE = 3_000_000  # entries of the matrices of all patterns of one period, if all are to be tried


def basis(values: Floats, family: Family) -> Floats:
    r"""Matrices ``V`` with ``w = V d``, ``d >= 0``, for all ``w`` ordered as the rows of ``values``.

    ``monotone``: the order of the values and zero; ``d`` are the steps between neighbours.  ``odd``: the signs and the
    order of the magnitudes; ``d`` are the steps of the magnitudes from zero up.  ``sector``: the signs; ``d = |w|``.

    Parameters
    ----------
    values : ndarray
        (m, p), no zeros, no ties: one representative of each order.
    family : {"monotone", "odd", "sector"}
        What of the values is kept.

    Returns
    -------
    ndarray
        (m, p, p), entries -1, 0, 1, each matrix invertible.
    """
    p = values.shape[1]
    sign = np.sign(values)
    if family == "sector":
        return np.asarray(sign[:, :, None] * np.eye(p), dtype=float)
    step = np.arange(p)[None, None, :]
    if family == "odd":
        rank = np.argsort(np.argsort(np.abs(values), axis=1), axis=1)[:, :, None]
        return np.where(step <= rank, sign[:, :, None], 0.0)
    rank = np.argsort(np.argsort(values, axis=1), axis=1)[:, :, None]
    below = (values < 0).sum(axis=1)[:, None, None]
    above_zero = (below <= step) & (step <= rank)
    below_zero = (rank <= step) & (step < below)
    return np.asarray(above_zero, dtype=np.float64) - np.asarray(below_zero, dtype=np.float64)


def pattern_count(p: int, family: Family) -> int:
    """How many patterns :func:`all_patterns` lists."""
    if family == "sector":
        return int(2 ** (p - 1))
    return math.factorial(p - 1) * (p + 1 if family == "monotone" else 2 ** (p - 1))


def all_patterns(p: int, family: Family) -> Floats:
    """One representative of every pattern of ``p`` values, up to shifts in time and (not ``monotone``) a common sign.

    The first value is the largest, or the largest in magnitude.
    """
    if family == "sector":
        signs = np.array(list(itertools.product((1.0, -1.0), repeat=p - 1)))
        return np.hstack([np.ones((len(signs), 1)), signs])
    orders = np.array(list(itertools.permutations(range(1, p))), dtype=float)
    ranks = np.hstack([np.full((len(orders), 1), float(p)), orders])
    if family == "monotone":
        return np.vstack([ranks - below - 0.5 for below in range(p + 1)])
    signs = all_patterns(p, "sector")
    return (ranks[:, None, :] * signs[None, :, :]).reshape(-1, p)


def sinusoids(p: int, turns: float, family: Family) -> Floats:
    """The patterns of ``cos(2 pi turns t / p + phase)``, for ``monotone`` with every offset.

    Between multiples of ``pi/(2 p)`` of the phase the order of the values, and of the magnitudes, stays the same.
    """
    phase = (2 * np.arange(4) + 1) * math.pi / (4 * p)
    waves = np.cos(2 * math.pi * turns * np.arange(p)[None, :] / p + phase[:, None])
    if family != "monotone":
        return waves
    ranks = np.argsort(np.argsort(waves, axis=1), axis=1) + 0.5
    return np.vstack([ranks - below for below in range(p + 1)])


def neighbours(values: Floats, family: Family) -> Floats:
    """Patterns one exchange of neighbours, one step of zero or one sign away from one pattern (p,)."""
    p = len(values)
    found: list[Floats] = []
    if family != "monotone":
        found += list(values * (1 - 2 * np.eye(p)))
    if family != "sector":
        order = np.argsort(values if family == "monotone" else np.abs(values))
        for i, j in itertools.pairwise(order):
            other = values.copy()
            other[i], other[j] = values[j], values[i]
            if family == "odd":
                other[i], other[j] = math.copysign(values[j], values[i]), math.copysign(values[i], values[j])
            found.append(other)
    if family == "monotone":
        centred = np.argsort(np.argsort(values)) + 0.5 - (values < 0).sum()
        found += [centred + 1, centred - 1]
    return np.array(found)
