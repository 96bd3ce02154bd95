"""Solutions of the Kalman-Yakubovich-Popov inequality from Riccati equations, with as many digits as needed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np
from flint import acb_mat, arb, arb_mat
from numpy.typing import NDArray
from scipy.linalg import matrix_balance, schur, solve, solve_triangular
from scipy.optimize import minimize_scalar

from analysis.precision import ball, working_precision
from lure.errors import AssumptionError

FAR = 24
NEAR = 12
MOST_POINTS = 1000
LOWEST = 6
SMALLER = (1.0, 1.0 / 8, 1.0 / 64)
MOST_IN_BALLS = 64
PRECISIONS = (128, 256, 512)

Triangle = list[list[int]]


@dataclass(frozen=True, kw_only=True, slots=True)
class Rounded:
    """A symmetric matrix of dyadic numbers.

    Attributes
    ----------
    rows : list of list of int
        Rows of the lower triangle, in units of ``2^-exponent``.
    exponent : int
        ``e >= 0``.
    """

    rows: Triangle
    exponent: int


@dataclass(frozen=True, kw_only=True)
class Inequality:
    r"""``[[-(A'P + PA), q - Pb], [., r]] > 0`` for ``P``, in exact numbers.

    With ``x = (i omega - A)^{-1} b`` it says ``r + 2 Re q x > 0`` at every frequency, and that is also sufficient for
    a solution if ``A`` is Hurwitz and ``(A, b)`` controllable.

    Attributes
    ----------
    A, b, q, r : list of list of Fraction, list of Fraction, Fraction
        Shapes ``(n, n)``, ``(n,)``, ``(n,)`` and one number.
    """

    A: list[list[Fraction]]
    b: list[Fraction]
    q: list[Fraction]
    r: Fraction

    @property
    def order(self) -> int:
        """``n``."""
        return len(self.b)

    @cached_property
    def scaled(self) -> Scaled:
        """The same in doubles, its states in units of powers of two that even out ``A``, ``b`` and ``q``."""
        n = self.order
        bordered = np.zeros((n + 1, n + 1))
        bordered[:n, :n] = [[float(v) for v in row] for row in self.A]
        bordered[:n, n], bordered[n, :n] = [float(v) for v in self.b], [float(v) for v in self.q]
        even, (units, _) = matrix_balance(bordered, permute=False, separate=True)
        units = units[:n] / units[n]
        return Scaled(A=even[:n, :n], b=even[:n, n], q=even[n, :n], r=float(self.r), units=units)


@dataclass(frozen=True, kw_only=True)
class Scaled:
    """The inequality in doubles, ``x = units * x_scaled``: ``P = P_scaled / (units units')``."""

    A: NDArray[np.float64]
    b: NDArray[np.float64]
    q: NDArray[np.float64]
    r: float
    units: NDArray[np.float64]

    @cached_property
    def slack(self) -> tuple[float, float]:
        r"""``(eps, delta)``, about largest, with ``r - delta + 2 Re q x >= eps |x|^2`` at the frequencies looked at.

        Raises
        ------
        AssumptionError
            ``r + 2 Re q x`` is not positive at one of them.
        """
        triangle, basis = schur(self.A, output="complex")
        inward, outward, unit = basis.conj().T @ self.b, self.q @ basis, np.eye(self.b.size)

        def at(omega: float) -> tuple[float, float]:
            """``r + 2 Re q x`` and ``|x|^2`` at one frequency."""
            x = solve_triangular(1j * omega * unit - triangle, inward, check_finite=False)
            return self.r + 2.0 * float((outward @ x).real), float(np.vdot(x, x).real)

        points = _frequencies(np.diag(triangle))
        values = np.array([at(omega)[0] for omega in points])
        lowest = [float(points[int(np.argmin(values))]), *_dips(lambda omega: at(omega)[0], points, values)]
        seen = [at(omega) for omega in (*points.tolist(), *lowest)]
        least, where = min([(value, omega) for (value, _), omega in zip(seen[-len(lowest) :], lowest, strict=True)])
        if not min(least, self.r) > 0:
            raise AssumptionError(f"the frequency inequality fails near {where:.6g} rad/s; no matrix P can prove it")
        delta = min(least, self.r) / 2
        room = [(value - delta) / size for value, size in seen if size > 0]
        return (min(room) / 2 if room else 1.0), delta

    def solution(self, eps: float, delta: float) -> NDArray[np.float64] | None:
        """``P`` of the Riccati equation with ``eps I`` added and ``delta`` taken from ``r``; None if there is none."""
        n, r = self.b.size, self.r - delta
        moved = self.A - np.outer(self.b, self.q) / r
        weight = np.outer(self.q, self.q) / r + eps * np.eye(n)
        hamiltonian = np.block([[moved, np.outer(self.b, self.b) / r], [-weight, -moved.T]])
        try:
            _, vectors, stable = schur(hamiltonian, sort="lhp", output="real", check_finite=True)
            found = solve(vectors[:n, :n].T, vectors[n:, :n].T) if stable == n else None
        except (np.linalg.LinAlgError, ValueError):
            return None
        if found is None or not np.isfinite(found).all():
            return None
        return np.asarray((found + found.T) / 2)

    def margin(self, P: NDArray[np.float64]) -> float:
        """The least eigenvalue of the matrix of the inequality, in floating point."""
        moved = P @ self.A
        edge = self.q - P @ self.b
        matrix = np.block([[-(moved + moved.T), edge[:, None]], [edge[None, :], np.array([[self.r]])]])
        return float(min(np.linalg.eigvalsh(matrix)[0], np.linalg.eigvalsh(P)[0]))


def solutions(inequality: Inequality) -> Iterator[Rounded]:
    r"""Candidates for ``P``, rounded, the shortest first; none of them is proved to be a solution.

    Parameters
    ----------
    inequality : Inequality
        The inequality.

    Yields
    ------
    Rounded
        From doubles, with three lengths; then, up to order 64, from 128, 256 and 512 bits.

    Raises
    ------
    AssumptionError
        The inequality fails at a frequency.

    Notes
    -----
    ``A'P + PA + (Pb - q)(Pb - q)'/(r - delta) + eps I = 0`` has its stabilising solution strictly inside the solutions
    of the inequality, by ``eps`` and ``delta``; both are about half of the most that the frequency inequality leaves
    room for.  It is read off the stable invariant subspace of a Hamiltonian matrix [1]_, order ``n^3``, with no
    semidefinite program.

    References
    ----------
    .. [1] A. J. Laub, IEEE Transactions on Automatic Control 24 (1979) 913-921.
    """
    if inequality.order == 0:
        yield Rounded(rows=[], exponent=0)
        return
    scaled = inequality.scaled
    eps, delta = scaled.slack
    for part in SMALLER:
        P = scaled.solution(part * eps, part * delta)
        margin = -1.0 if P is None else scaled.margin(P)
        if P is not None and margin > 0:
            exact = (P / np.outer(scaled.units, scaled.units)).tolist()
            first = _exponent(scaled, margin)
            for more in (0, 16, 48):
                yield _rounded([[Fraction(v) for v in row[: i + 1]] for i, row in enumerate(exact)], first + more)
            break
    if inequality.order > MOST_IN_BALLS:
        return
    for bits in PRECISIONS:
        for part in SMALLER:
            lower = _in_balls(inequality, part * eps, part * delta, bits)
            if lower is not None:
                for exponent in (bits // 4, bits // 2, bits):
                    yield _rounded(lower, exponent)


def _dips(function: Callable[[float], float], points: NDArray[np.float64], values: NDArray[np.float64]) -> list[float]:
    """Where the lowest local minima are, between the neighbours of the points that show them."""
    inner = 1 + np.flatnonzero((values[1:-1] <= values[:-2]) & (values[1:-1] <= values[2:]))
    found = []
    for i in sorted(inner.tolist(), key=lambda i: float(values[i]))[:LOWEST]:
        within = (float(points[i - 1]), float(points[i + 1]))
        found.append(minimize_scalar(function, bounds=within, method="bounded", options={"xatol": 1e-9 * within[1]}).x)
    return [float(x) for x in found]


def _frequencies(poles: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Zero, the frequencies of the poles and points about them, as close as their damping, and some far away."""
    size, width, at = np.abs(poles), np.abs(poles.real), np.abs(poles.imag)
    size = np.unique(size[size > 0])
    reach = np.geomspace(1 / 16, 64, min(max(MOST_POINTS // size.size, 2), NEAR))
    spread = np.concatenate([-reach, [0.0], reach])
    close = (at[:, None] + width[:, None] * spread[None, :]).ravel()
    far = np.geomspace(1.5, 1e6, FAR)
    between = np.sqrt(size[1:] * size[:-1])
    return np.unique(np.concatenate([[0.0], size[0] / far, size, between, size[-1] * far, close[close > 0]]))


def _exponent(scaled: Scaled, margin: float) -> int:
    """How many binary places ``P`` needs so that rounding cannot use up the margin."""
    n = scaled.b.size
    reach = 2.0 * float(np.linalg.norm(scaled.A)) + 2.0 * float(np.linalg.norm(scaled.b)) + 1.0
    places = math.log2(n * reach / margin) + 2.0 * math.log2(float(np.max(scaled.units)))
    return max(0, math.ceil(places) + 1)


def _rounded(lower: Sequence[Sequence[Fraction]], exponent: int) -> Rounded:
    """The lower triangle in integers."""
    return Rounded(rows=[[round(v * 2**exponent) for v in row] for row in lower], exponent=exponent)


def _in_balls(inequality: Inequality, eps: float, delta: float, bits: int) -> list[list[Fraction]] | None:
    """Lower triangle of the solution of the Riccati equation with so many bits, from eigenvectors; None without one."""
    n, units = inequality.order, inequality.scaled.units
    with working_precision(bits):
        r = ball(inequality.r) - arb(delta)
        A = arb_mat([[ball(v) for v in row] for row in inequality.A])
        b, q = (arb_mat([[ball(v)] for v in vector]) for vector in (inequality.b, inequality.q))
        extra = arb_mat(n, n)
        for i, unit in enumerate(units.tolist()):
            extra[i, i] = arb(eps) / arb(unit) ** 2
        moved, gain = A - b * q.transpose() * (1 / r), b * b.transpose() * (1 / r)
        weight = q * q.transpose() * (1 / r) + extra
        hamiltonian = acb_mat(
            [[*moved.tolist()[i], *gain.tolist()[i]] for i in range(n)]
            + [[-v for v in [*weight.tolist()[i], *moved.transpose().tolist()[i]]] for i in range(n)]
        )
        values, vectors = hamiltonian.mid().eig(right=True, algorithm="approx")
        stable = [j for j, value in enumerate(values) if value.real < 0]
        if len(stable) != n:
            return None
        table = vectors.tolist()
        top, low = (acb_mat([[row[j] for j in stable] for row in part]) for part in (table[:n], table[n:]))
        try:
            found = top.transpose().solve(low.transpose()).transpose().tolist()
        except ZeroDivisionError:
            return None
        if not all(value.real.is_finite() for row in found for value in row):
            return None
        return [
            [(_fraction(found[i][j].real) + _fraction(found[j][i].real)) / 2 for j in range(i + 1)] for i in range(n)
        ]


def _fraction(value: arb) -> Fraction:
    """The midpoint."""
    man, exp = value.mid().man_exp()
    return Fraction(int(man)) * Fraction(2) ** int(exp)
