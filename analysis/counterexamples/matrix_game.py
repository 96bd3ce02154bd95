"""Matrix games, many of one size at a time: the linear programs behind the search for periodic orbits."""

from __future__ import annotations

import itertools
import math
from typing import Literal, TypeAlias

from lure.analysis.deadline import checkpoint
from lure.arrays import NDArray, Reals, np
from lure.record import described, quantity

# In which order the values of a periodic orbit can lie: the finite choice behind every monotone nonlinearity through
# it.

Family = Literal["monotone", "odd", "sector"]

EXHAUSTIVE = 3_000_000  # entries of the matrices of all patterns of one period, if all are to be tried


def basis(values: Reals, family: Family) -> Reals:
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


def all_patterns(p: int, family: Family) -> Reals:
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


def sinusoids(p: int, turns: float, family: Family) -> Reals:
    """The patterns of ``cos(2 pi turns t / p + phase)``, for ``monotone`` with every offset.

    Between multiples of ``pi/(2 p)`` of the phase the order of the values, and of the magnitudes, stays the same.
    """
    phase = (2 * np.arange(4) + 1) * math.pi / (4 * p)
    waves = np.cos(2 * math.pi * turns * np.arange(p)[None, :] / p + phase[:, None])
    if family != "monotone":
        return waves
    ranks = np.argsort(np.argsort(waves, axis=1), axis=1) + 0.5
    return np.vstack([ranks - below for below in range(p + 1)])


def neighbours(values: Reals, family: Family) -> Reals:
    """Patterns one exchange of neighbours, one step of zero or one sign away from one pattern (p,)."""
    p = len(values)
    found: list[Reals] = []
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


Places: TypeAlias = "NDArray[np.intp]"

_TINY = 1e-11
_CHUNK = 1 << 22  # entries of a stack of games worked on at a time


@described(frozen=True, slots=True)
class Solved:
    """Values and optimal mixtures of a stack of games."""

    value: Reals = quantity("(m,), NaN where the simplex method did not end")
    mixture: Reals = quantity("(m, n), nonnegative, each row of sum 1")


def solve_games(games: Reals) -> Solved:
    r"""``max_d min_i (B d)_i`` over mixtures ``d >= 0``, ``sum d = 1``, for every ``B`` of the stack.

    The value is nonnegative exactly if ``B d >= 0`` has a solution ``d >= 0`` other than 0.  Floating point: a
    proposal, never a proof.

    ``games``: (m, n, n).

    Notes
    -----
    Each game is scaled and shifted to entries in ``[1, 3]``, where ``max sum z``, ``B^T z <= 1``, ``z >= 0`` starts
    from the feasible ``z = 0``; the condensed tableaux of all games are pivoted together, largest coefficient first.
    """
    count, n, _ = games.shape
    step = max(1, _CHUNK // (n + 1) ** 2)
    value, mixture = np.full(count, np.nan), np.zeros((count, n))
    for start in range(0, count, step):
        part = slice(start, start + step)
        value[part], mixture[part] = _solve(games[part])
    return Solved(value, mixture)


def _solve(games: Reals) -> tuple[Reals, Reals]:
    count, n, _ = games.shape
    scale = np.maximum(np.abs(games).max(axis=(1, 2)), 1e-300)
    tableau = np.ones((count, n + 1, n + 1))
    tableau[:, :n, :n] = games.transpose(0, 2, 1) / scale[:, None, None] + 2
    tableau[:, n, :n] = -1
    tableau[:, n, n] = 0
    in_row = np.tile(np.arange(n, 2 * n), (count, 1))  # labels below n: z; from n on: slack of a constraint
    in_column = np.tile(np.arange(n), (count, 1))
    value, mixture = np.full(count, np.nan), np.zeros((count, n))
    alive = np.arange(count)
    for _ in range(10 * n + 20):
        checkpoint()
        column = tableau[:, n, :n].argmin(axis=1)
        ended = tableau[np.arange(len(alive)), n, column] > -_TINY
        if ended.any():
            done = alive[ended]
            total = tableau[ended, n, n]
            value[done] = (1 / total - 2) * scale[done]
            mixture[done] = _duals(tableau[ended, n, :n], in_column[ended], n) / total[:, None]
            tableau, in_row, in_column, column, alive = (
                held[~ended] for held in (tableau, in_row, in_column, column, alive)
            )
        row, bounded = _tightest(tableau, column)
        if not bounded.all():  # by rounding: the programs themselves are
            tableau, in_row, in_column, column, alive, row = (
                held[bounded] for held in (tableau, in_row, in_column, column, alive, row)
            )
        if not len(alive):
            break
        _pivot(tableau, row, column)
        every = np.arange(len(alive))
        in_row[every, row], in_column[every, column] = in_column[every, column], in_row[every, row]
    return value, mixture


def _duals(costs: Reals, labels: Places, n: int) -> Reals:
    found = np.zeros((len(costs), 2 * n))
    np.put_along_axis(found, labels, np.maximum(costs, 0), axis=1)
    return found[:, n:]


def _tightest(tableau: Reals, column: Places) -> tuple[Places, NDArray[np.bool_]]:
    """The row that leaves where ``column`` enters, and whether there is one."""
    n = tableau.shape[1] - 1
    entering = tableau[np.arange(len(tableau)), :n, column]
    some = entering > _TINY
    ratio = np.where(some, tableau[:, :n, n] / np.where(some, entering, 1.0), np.inf)
    return ratio.argmin(axis=1), np.asarray(some.any(axis=1))


def _pivot(tableau: Reals, row: Places, column: Places) -> None:
    """One exchange in every tableau, in place: ``column`` enters, ``row`` leaves."""
    every = np.arange(len(tableau))
    entering, pivot = tableau[every, :, column], tableau[every, row, column]
    leaving = tableau[every, row] / pivot[:, None]
    tableau -= entering[:, :, None] * leaving[:, None, :]
    tableau[every, row] = leaving
    tableau[every, :, column] = -entering / pivot[:, None]
    tableau[every, row, column] = 1 / pivot
