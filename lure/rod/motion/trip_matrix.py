"""A round trip in which nothing happens as one matrix, for the kernel where it is not compiled."""

from __future__ import annotations

from array import array
from dataclasses import dataclass

import numpy as np

from lure.rod.motion.pieces import Array


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Layout:
    """Where the tables of an interval are; the names are those of :mod:`lure.rod.motion.kernel_tables`."""

    pieces: int
    degree: int
    depth: int
    width: int
    numbers: dict[str, float]
    tables: dict[str, Array]


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class TripMatrix:
    """What a round trip makes of its wave ``w``, (k, p) flattened, and of ``zeta`` where it begins.

    Attributes
    ----------
    matrix, held, level : ndarray
        (T+2, T) per ``w``, (T+2,) per ``zeta``, (T+2,) constant: the wave that comes back without its load, the travel
        of ``zeta``, and the impulse.
    begins, begins_held, begins_level : ndarray
        (P+1, T), (P+1,), (P+1,) the same of ``zeta`` where the pieces begin, less that at the start, and at the end.
    columns : ndarray
        (C, T) of the load.
    own, hold, constant : ndarray
        (P, K, n+1), (P, K), (P, K): the series of ``zeta`` on a piece per ``w`` on it, per its start, and constant.
    flat : bool
        Whether ``zeta`` is a quadrature, so that ways there and back cancel.
    """

    matrix: Array
    held: Array
    level: Array
    begins: Array
    begins_held: Array
    begins_level: Array
    columns: Array
    own: Array
    hold: Array
    constant: Array
    flat: bool

    def ways(self, wave: Array) -> float:
        """All ways there and back in free flight, regardless of sign; else 0."""
        return float(np.abs(self.matrix[-2] * wave).sum()) if self.flat else 0.0

    def starts(self, heads: Array, waves: Array) -> Array:
        """``zeta`` (m, P+1) where the pieces begin, and at the end, in round trips with their heads and waves."""
        z = heads[:, :1]
        return np.asarray(z + (heads[:, 1:2] + waves @ self.begins.T + z * self.begins_held + self.begins_level))

    def loads(self, force: Array, number: Array) -> Array:
        """(m, T) what the load adds in round trips."""
        rows, at, flat = [], 1, np.asarray(force)
        for _ in range(int(flat[0])):
            re, im, power = 2.0 * flat[at], 2.0 * flat[at + 1], int(flat[at + 2])
            grown = np.exp(re * number)
            parts = [grown * np.cos(im * number)] + ([grown * np.sin(im * number)] if im else [])
            for _k in range(power + 1):
                rows += parts
                parts = [part * number for part in parts]
            at += 3 + 2 * (power + 1)
        return np.asarray(np.array(rows).T @ self.columns) if rows else np.zeros((len(number), self.matrix.shape[1]))


class Doubles(array):  # type: ignore[type-arg]  # before Python 3.12 it takes no argument
    """Doubles of an interval, with the matrix of its round trip once that has been asked for."""

    made: TripMatrix | None = None


def trip_matrix(layout: Layout) -> TripMatrix:
    """The matrix of the tables of an interval."""
    P, n, K, N = layout.pieces, layout.degree, layout.depth, layout.width
    T, numbers, tables = (n + 1) * P, layout.numbers, layout.tables
    end, mean = (tables[name].reshape(-1, P)[: n + 1] for name in ("end", "mean"))
    begins, held, level = np.zeros((P + 1, n + 1, P)), np.zeros(P + 1), np.zeros(P + 1)
    for p in range(P):
        more = tables["hold_end"][p]
        begins[p + 1] = (1.0 + more) * begins[p]
        begins[p + 1, :, p] += end[:, p]
        held[p + 1] = held[p] + more * (1.0 + held[p])
        level[p + 1] = (1.0 + more) * level[p] + tables["level_end"][p]
    own = tables["own"].reshape(P, N, N)[:, :K, : n + 1]
    hold, constant = (tables[name].reshape(P, N)[:, :K] for name in ("hold", "level"))
    flat = begins.reshape(P + 1, T)
    matrix, per_zeta, fixed = np.zeros((T + 2, T)), np.zeros(T + 2), np.zeros(T + 2)
    matrix[:T] = numbers["back_w"] * np.eye(T)
    fixed[:P] = numbers["back_p"]
    if numbers["back_z"]:
        for p in range(P):
            for k in range(min(n + 1, K)):
                row, share = k * P + p, numbers["back_z"] * hold[p, k]
                matrix[row] += share * flat[p]
                matrix[row].reshape(n + 1, P)[:, p] += numbers["back_z"] * own[p, k]
                per_zeta[row] = share * (1.0 + held[p])
                fixed[row] += share * level[p] + numbers["back_z"] * constant[p, k]
    matrix[T], per_zeta[T], fixed[T] = flat[P], held[P], level[P]
    shares = 2.0 * numbers["loading"] * numbers["stiffness"] * tables["halves"]
    held_mean, level_mean = tables["hold_mean"], tables["level_mean"]
    matrix[T + 1] = ((shares * held_mean) @ flat[:P]) + (shares * mean).ravel()
    per_zeta[T + 1] = (shares * held_mean) @ (1.0 + held[:P])
    fixed[T + 1] = (shares * held_mean) @ level[:P] + shares @ level_mean
    fixed[T + 1] += 2.0 * numbers["loading"] * numbers["pushed"] * numbers["time"]
    return TripMatrix(
        matrix=matrix,
        held=per_zeta,
        level=fixed,
        begins=flat,
        begins_held=held,
        begins_level=level,
        columns=tables["loads"].reshape(-1, N * P)[:, :T],
        own=own,
        hold=hold,
        constant=constant,
        flat=numbers["back_z"] == 0.0,
    )
