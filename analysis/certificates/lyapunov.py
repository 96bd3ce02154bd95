"""Lyapunov's equation in doubles, from one Schur form: steps of an iteration whose residuals have more digits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from flint import arb_mat
from numpy.typing import NDArray
from scipy.linalg import schur, solve_triangular

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Lyapunov:
    """``-(A'X + XA) = F``, in discrete time ``X - A'XA = F``, for symmetric ``F``, from one Schur form of ``A``."""

    triangle: NDArray[np.complex128]
    basis: NDArray[np.complex128]
    discrete: bool

    @classmethod
    def of(cls, A: Array, *, discrete: bool) -> Lyapunov:
        """The equation."""
        triangle, basis = schur(A, output="complex")
        return cls(triangle, basis, discrete)

    def solution(self, F: Array) -> Array:
        """``X``, column by column in the basis of the Schur form; not finite where there is none."""
        T, n = self.triangle, len(F)
        right, X = self.basis.conj().T @ F @ self.basis, np.zeros((n, n), dtype=complex)
        unit = np.eye(n)
        for j in range(n):
            before = X[:, :j] @ T[:j, j]
            if self.discrete:
                side, matrix = right[:, j] + T.conj().T @ before, unit - T[j, j].conj() * T
            else:
                side, matrix = -right[:, j] - before, T + T[j, j].conj() * unit
            if not np.all(np.diag(matrix)):
                return np.full((n, n), np.nan)
            X[:, j] = solve_triangular(matrix, side, trans="C", check_finite=False)
        found = (self.basis @ X @ self.basis.conj().T).real
        return np.asarray((found + found.T) / 2)


def doubles(M: arb_mat) -> Array:
    """The midpoints of a matrix of balls, rounded.

    Parameters
    ----------
    M : arb_mat
        The matrix.
    """
    return np.array([[float(v) for v in row] for row in M.tolist()])
