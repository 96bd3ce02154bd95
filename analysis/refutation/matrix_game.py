"""Matrix games, many of one size at a time: the linear programs behind the search for periodic orbits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.deadline import checkpoint

Floats = NDArray[np.float64]

_TINY = 1e-11
_CHUNK = 1 << 22  # entries of a stack of games worked on at a time


@dataclass(frozen=True, slots=True)
class Solved:
    """Values and optimal mixtures of a stack of games.

    Attributes
    ----------
    value : ndarray
        (m,), NaN where the simplex method did not end.
    mixture : ndarray
        (m, n), nonnegative, each row of sum 1.
    """

    value: Floats
    mixture: Floats


def solve_games(games: Floats) -> Solved:
    r"""``max_d min_i (B d)_i`` over mixtures ``d >= 0``, ``sum d = 1``, for every ``B`` of the stack.

    The value is nonnegative exactly if ``B d >= 0`` has a solution ``d >= 0`` other than 0.  Floating point: a
    proposal, never a proof.

    Parameters
    ----------
    games : ndarray
        (m, n, n).

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


def _solve(games: Floats) -> tuple[Floats, Floats]:
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
        if not len(alive):
            break
        _pivot(tableau, in_row, in_column, column)
    return value, mixture


def _duals(costs: Floats, labels: NDArray[np.intp], n: int) -> Floats:
    found = np.zeros((len(costs), 2 * n))
    np.put_along_axis(found, labels, np.maximum(costs, 0), axis=1)
    return found[:, n:]


def _pivot(tableau: Floats, in_row: NDArray[np.intp], in_column: NDArray[np.intp], column: NDArray[np.intp]) -> None:
    """One exchange in every tableau, in place: ``column`` enters, the tightest row leaves."""
    n, every = tableau.shape[1] - 1, np.arange(len(tableau))
    entering = tableau[every, :, column]
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(entering[:, :n] > _TINY, tableau[:, :n, n] / entering[:, :n], np.inf)
    row = ratio.argmin(axis=1)
    pivot = entering[every, row]
    leaving = tableau[every, row] / pivot[:, None]
    tableau -= entering[:, :, None] * leaving[:, None, :]
    tableau[every, row] = leaving
    tableau[every, :, column] = -entering / pivot[:, None]
    tableau[every, row, column] = 1 / pivot
    in_row[every, row], in_column[every, column] = in_column[every, column], in_row[every, row]
