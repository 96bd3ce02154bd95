"""Solutions of ``(s I - A) x = b`` at many points ``s``: one orthogonal reduction, then order ``n^2`` a point."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_ROWS = 32  # of a block of the substitution: the rest is matrix products
_LARGE = 1e100
_NEGLIGIBLE = 1e-100  # below this share of the matrix a subdiagonal entry is zero


@dataclass(frozen=True, eq=False, slots=True)
class ControllerForm:
    r"""``A = S Q H Q^T S^{-1}`` and ``b = beta S Q e_1`` with ``S`` diagonal, ``Q`` orthogonal, ``H`` upper Hessenberg.

    Attributes
    ----------
    H : ndarray
        (r, r), ``r <= n``: states past a vanishing subdiagonal entry cannot be reached from ``b`` and are left out.
    basis : ndarray
        (n, r), the leading columns of ``S Q``.
    beta : float
        Length of ``b`` in the balanced coordinates.
    """

    H: NDArray[np.float64]
    basis: NDArray[np.float64]
    beta: float

    @classmethod
    def of(cls, A: NDArray[np.float64], b: NDArray[np.float64]) -> ControllerForm:
        """The form of ``A`` (n, n) and ``b`` (n,), balanced first.

        The Hessenberg form of the bordered matrix ``[0, 0; b, A]`` is that of ``A`` with ``b`` along ``e_1``.
        """
        from scipy.linalg import hessenberg, matrix_balance

        n = b.size
        balanced, (scale, _) = matrix_balance(A, permute=False, separate=True)
        bordered = np.zeros((n + 1, n + 1))
        bordered[1:, 0], bordered[1:, 1:] = b / scale, balanced
        H, Q = hessenberg(bordered, calc_q=True, overwrite_a=True)
        beta, H = float(H[1, 0]), np.ascontiguousarray(H[1:, 1:])
        small = np.flatnonzero(np.abs(np.diag(H, -1)) <= _NEGLIGIBLE * np.abs(H).max())
        reached = int(small[0]) + 1 if small.size else n
        basis = scale[:, None] * Q[1:, 1 : reached + 1]
        return cls(np.ascontiguousarray(H[:reached, :reached]), np.ascontiguousarray(basis), beta)

    def solutions(self, points: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """``(s I - A)^{-1} b`` at each of the points, (n, m); not finite where ``s`` is an eigenvalue to rounding.

        Hyman's substitution: with the last entry set to one, the rows from the last to the second give the entries
        above it, and the first row their common factor.  It solves a system whose entries differ from those of
        ``s I - H`` by rounding errors.
        """
        H, r = self.H, self.H.shape[0]
        X = np.empty((r, points.size), dtype=complex)
        X[-1] = 1.0
        with np.errstate(all="ignore"):
            for high in range(r, 1, -_ROWS):
                low = max(high - _ROWS, 1)
                _block(H, X, points, (low, high))
            factor = points * X[0] - _product(H[:1], X)[0]
            X *= self.beta / factor
            return _product(self.basis, X)


def _block(
    H: NDArray[np.float64], X: NDArray[np.complex128], points: NDArray[np.complex128], rows: tuple[int, int]
) -> None:
    """Entries ``low - 1`` to ``high - 2`` of the solution, from the rows ``low`` to ``high - 1`` of the matrix."""
    low, high = rows
    known = _product(H[low:high, high:], X[high:])
    flat = known.view(np.float64)
    for i in range(high - 1, low - 1, -1):
        flat[: i - low + 1] += H[low : i + 1, i : i + 1] * X[i].view(np.float64)
        X[i - 1] = (points * X[i] - known[i - low]) / H[i, i - 1]
        if not np.abs(X[i - 1].view(np.float64)).max() <= _LARGE:
            shrink = np.exp2(-np.floor(np.log2(np.maximum(np.abs(X[i - 1]), 1.0))))
            X[i - 1 :] *= shrink
            known *= shrink


def _product(real: NDArray[np.float64], values: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """A real matrix times a complex one, as one real product of twice as many columns."""
    flat = np.ascontiguousarray(values).view(np.float64)
    return np.asarray((np.ascontiguousarray(real) @ flat).view(np.complex128))
