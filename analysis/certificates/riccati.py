"""Solutions of the Kalman-Yakubovich-Popov inequality from Riccati equations, with as many digits as needed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from flint import acb_mat, arb, arb_mat

from lure.analysis.certificates.codes import code_for
from lure.analysis.certificates.multipliers import slack
from lure.analysis.numerics.polynomial import exact_midpoint
from lure.analysis.numerics.precision import ball, working_precision
from lure.arrays import NDArray, Reals, balanced, in_doubles, linalg, np
from lure.errors import AssumptionError
from lure.record import described, quantity

# Lyapunov's equation in doubles, from one Schur form: steps of an iteration whose residuals have more digits.


@dataclass(frozen=True, slots=True, eq=False)
class Lyapunov:
    """``-(A'X + XA) = F``, in discrete time ``X - A'XA = F``, for symmetric ``F``, from one Schur form of ``A``."""

    triangle: NDArray[np.complex128]
    basis: NDArray[np.complex128]
    discrete: bool

    @classmethod
    def of(cls, A: Reals, *, discrete: bool) -> Lyapunov:
        """The equation."""
        triangle, basis = linalg.schur(A, output="complex")
        return cls(triangle, basis, discrete)

    def solution(self, F: Reals) -> Reals:
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
            X[:, j] = linalg.solve_triangular(matrix, side, trans="C", check_finite=False)
        found = (self.basis @ X @ self.basis.conj().T).real
        return np.asarray((found + found.T) / 2)


def doubles(M: arb_mat) -> Reals:
    """The midpoints of a matrix of balls, rounded."""
    return in_doubles(M.tolist())


SMALLER = (1.0, 1.0 / 8, 1.0 / 64)
LONGER = (0, 16, 48)
MOST_IN_BALLS = 64
MOST_EIGENVECTORS = 24  # beyond, minutes
PRECISIONS = (128, 256, 512)
REFINED_BITS = 192
MOST_STEPS = 12
CLOSE = (8, 16, 24, 32, 40, 48, 56, 64, 80, 96, 112, 128)
SURE = 1e-9

Triangle = list[list[int]]


@described(frozen=True, kw_only=True, slots=True)
class Rounded:
    """A symmetric matrix of dyadic numbers."""

    rows: Triangle = quantity("Rows of the lower triangle, in units of ``2^-exponent``")
    exponent: int = quantity("``e >= 0``")
    sure: bool = quantity(
        "Whether floating point leaves no reasonable doubt that it is a solution, which is not a proof", default=False
    )


@described(frozen=True, kw_only=True)
class Inequality:
    r"""``[[-(A'P + PA), q - Pb], [., r]] > 0`` for ``P``, with ``q = c + theta A'c``, in exact numbers.

    With ``x = (i omega - A)^{-1} b`` it says ``r + 2 Re q x > 0`` at every frequency, and that is also sufficient for
    a solution if ``A`` is Hurwitz.
    """

    A: list[list[Fraction]] = quantity("(n, n)")
    b: list[Fraction] = quantity("(n,)")
    c: list[Fraction] = quantity("(n,)")
    theta: Fraction
    r: Fraction

    @property
    def order(self) -> int:
        """``n``."""
        return len(self.b)

    @cached_property
    def scaled(self) -> Scaled:
        """The same in doubles, its states in units of powers of two that even out ``A``, ``b`` and ``q``."""
        n, theta = self.order, float(self.theta)
        A, c = in_doubles(self.A), np.array([float(v) for v in self.c])
        bordered = np.zeros((n + 1, n + 1))
        bordered[:n, :n], bordered[:n, n], bordered[n, :n] = A, [float(v) for v in self.b], c + theta * (c @ A)
        even, units = balanced(bordered)
        units = units[:n] / units[n]
        doubt = SURE * float(np.max(units * (np.abs(c) + abs(theta) * (np.abs(c) @ np.abs(A)))))
        return Scaled(A=even[:n, :n], b=even[:n, n], q=even[n, :n], r=float(self.r), units=units, doubt=doubt)


@described(frozen=True, kw_only=True)
class Scaled:
    """The inequality in doubles, ``x = units * x_scaled``: ``P = P_scaled / (units units')``."""

    A: NDArray[np.float64] = quantity("The data, scaled, with ``b``, ``q`` and ``r``")
    b: NDArray[np.float64]
    q: NDArray[np.float64]
    r: float
    units: NDArray[np.float64] = quantity("Powers of two")
    doubt: float = quantity("Far more than the rounding errors of ``q``")

    def solution(self, eps: float, delta: float) -> NDArray[np.float64] | None:
        """``P`` of the Riccati equation with ``eps I`` added and ``delta`` taken from ``r``; None if there is none."""
        n, r = self.b.size, self.r - delta
        moved = self.A - np.outer(self.b, self.q) / r
        weight = np.outer(self.q, self.q) / r + eps * np.eye(n)
        hamiltonian = np.block([[moved, np.outer(self.b, self.b) / r], [-weight, -moved.T]])
        with np.errstate(all="ignore"), suppress(np.linalg.LinAlgError, ValueError):
            _, vectors, stable = linalg.schur(hamiltonian, sort="lhp", output="real", check_finite=True)
            if stable != n:
                return None
            found = np.linalg.solve(vectors[:n, :n].T, vectors[n:, :n].T)
            P = np.asarray((found + found.T) / 2)
            return P if np.isfinite(P).all() else None
        return None

    def refined(self, P: NDArray[np.float64], eps: float, delta: float) -> Rounded | None:
        """The solution with the digits it takes to solve the inequality, by Newton steps from ``P``; None without.

        With the residual ``R`` of the equation the matrix of the inequality is at least ``eps - |R|``, and ``delta`` in
        its corner; ``P > 0`` as ``A`` is stable.
        """
        n, r = self.b.size, self.r - delta
        if not np.max(np.linalg.eigvals(self.A).real) < 0:
            return None
        silent = suppress(ValueError, ArithmeticError, np.linalg.LinAlgError)
        with working_precision(REFINED_BITS), np.errstate(all="ignore"), silent:
            A, b, q, X = (arb_mat(part.tolist()) for part in (self.A, self.b[:, None], self.q[:, None], P))
            newton = Lyapunov.of(self.A + np.outer(self.b, self.b @ P - self.q) / r, discrete=False)
            extra = arb_mat((eps * np.eye(n)).tolist())
            for _ in range(MOST_STEPS):
                moved, edge = X * A, X * b - q
                residual = doubles(moved + moved.transpose() + edge * edge.transpose() * (1 / arb(r)) + extra)
                if float(np.linalg.norm(residual)) < eps / 8:
                    places = self._places(n, 8.0 / min(eps, delta))
                    lower = [[exact_midpoint(X[i, j]) for j in range(i + 1)] for i in range(n)]
                    units = [Fraction(v) for v in self.units.tolist()]
                    rows = [[v / (units[i] * units[j]) for j, v in enumerate(row)] for i, row in enumerate(lower)]
                    return Rounded(rows=_integers(rows, places), exponent=places, sure=True)
                step = newton.solution(residual)
                if not np.isfinite(step).all():
                    return None
                X = (X + arb_mat(step.tolist())).mid()
        return None

    def _places(self, n: int, inverse: float) -> int:
        """Binary places with which the matrix of the inequality moves by less than ``1/inverse``."""
        size = 2.0 * float(np.linalg.norm(self.A)) + 2.0 * float(np.linalg.norm(self.b)) + 1.0
        return max(0, math.ceil(math.log2(n * size * inverse) + 2.0 * math.log2(float(np.max(np.abs(self.units))))) + 1)

    def margin(self, P: NDArray[np.float64]) -> float:
        """The least eigenvalue of ``P`` and of the matrix of the inequality, in floating point."""
        moved, edge = P @ self.A, self.q - P @ self.b
        matrix = np.block([[-(moved + moved.T), edge[:, None]], [edge[None, :], np.array([[self.r]])]])
        return float(min(np.linalg.eigvalsh(matrix)[0], np.linalg.eigvalsh(P)[0]))

    def rounded(self, P: NDArray[np.float64], margin: float, more: int) -> Rounded:
        """The solution in the units asked for, rounded so that little of its margin is lost, with ``more`` bits."""
        exponent = self._places(self.b.size, 1 / margin) + more
        lower = [row[: i + 1] for i, row in enumerate((P / np.outer(self.units, self.units)).tolist())]
        size = 2.0 * float(np.linalg.norm(self.A)) + 2.0 * float(np.linalg.norm(self.b)) + 1.0
        sure = margin > self.doubt + SURE * (self.r + size * float(np.linalg.norm(P)))
        return Rounded(rows=_integers(lower, exponent), exponent=exponent, sure=sure)


def solutions(inequality: Inequality) -> Iterator[Rounded]:
    r"""Candidates for ``P``, rounded, the shortest first; none of them is proved to be a solution.

    Yields
    ------
    Rounded
        From doubles, with three lengths, and with Newton steps added that have more digits; then, up to order 24, from
        128, 256 and 512 bits.

    Raises
    ------
    AssumptionError
        The inequality fails at a frequency, as far as doubles can tell, or its numbers are too large for them.

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
    eps, delta = _room(inequality)
    scaled, near = inequality.scaled, list[Rounded]()
    for part in SMALLER:
        P = scaled.solution(part * eps, part * delta)
        if P is None:
            continue
        if not near and (margin := scaled.margin(P)) > 0:
            near = [scaled.rounded(P, margin, more) for more in LONGER]
            yield from (one for one in near if one.sure)
        better = scaled.refined(P, part * eps, part * delta)
        if better is not None:
            yield better
            break
    yield from near
    if inequality.order > MOST_EIGENVECTORS:
        return
    for bits in PRECISIONS:
        for part in SMALLER:
            lower = _in_balls(inequality, part * eps, part * delta, bits)
            if lower is not None:
                for exponent in (bits // 4, bits // 2, bits):
                    yield Rounded(rows=_integers(lower, exponent), exponent=exponent)


def close_solutions(inequality: Inequality) -> Iterator[Rounded]:
    """Candidates for ``P`` where the frequency inequality leaves less room than doubles can tell.

    Yields
    ------
    Rounded
        With less and less room, from more and more bits.
    """
    if not 0 < inequality.order <= MOST_EIGENVECTORS or not inequality.r > 0:
        return
    for power in CLOSE:
        bits = max(PRECISIONS[0], 8 * power)
        with suppress(ArithmeticError, ValueError, AssumptionError):
            lower = _in_balls(inequality, 2.0**-power, float(inequality.r) * 2.0**-power, bits)
            if lower is not None:
                yield Rounded(rows=_integers(lower, bits // 2), exponent=bits // 2)


def _room(inequality: Inequality) -> tuple[float, float]:
    """``eps`` and ``delta``."""
    try:
        with np.errstate(all="ignore"):
            scaled = inequality.scaled
            room = slack(scaled.A, scaled.b, scaled.q, scaled.r)
    except AssumptionError:
        raise
    except (OverflowError, ValueError, np.linalg.LinAlgError) as error:
        raise AssumptionError(
            f"the block is too much for doubles ({error}); rescale its units", code=code_for(error).reason
        ) from None
    if not all(0 < value < math.inf for value in room):
        raise AssumptionError(
            "the room the frequency inequality leaves is not a number; rescale the units of the block"
        )
    return room


def _integers(lower: Sequence[Sequence[Fraction | float]], exponent: int) -> Triangle:
    """The lower triangle in units of ``2^-exponent``, rounded."""
    return [[round(Fraction(v) * 2**exponent) for v in row] for row in lower]


def _in_balls(inequality: Inequality, eps: float, delta: float, bits: int) -> list[list[Fraction]] | None:
    """Lower triangle of the solution of the Riccati equation with so many bits, from eigenvectors; None without one."""
    n = inequality.order
    with working_precision(bits):
        r = ball(inequality.r) - arb(delta)
        A = arb_mat([[ball(v) for v in row] for row in inequality.A])
        b, c = (arb_mat([[ball(v)] for v in vector]) for vector in (inequality.b, inequality.c))
        q = c + A.transpose() * c * ball(inequality.theta)
        extra = arb_mat(n, n)
        for i, unit in enumerate(inequality.scaled.units.tolist()):
            extra[i, i] = arb(eps) / arb(unit) ** 2
        return stabilising(A, b, q, arb_mat([[r]]), extra)


def stabilising(A: arb_mat, B: arb_mat, S: arb_mat, R: arb_mat, extra: arb_mat) -> list[list[Fraction]] | None:
    """Lower triangle of the stabilising ``P`` of ``A'P + PA + (PB - S) R^-1 (PB - S)' + extra = 0``; None without one.

    ``A``, ``B``, ``S``, ``R``, ``extra``: shapes ``(n, n)``, ``(n, m)``, ``(n, m)``, ``(m, m)`` and ``(n, n)``; the
    working precision is that outside.
    """
    n, inverse = A.nrows(), R.inv()
    moved, gain = (A - B * inverse * S.transpose()).tolist(), (B * inverse * B.transpose()).tolist()
    weight = (S * inverse * S.transpose() + extra).tolist()
    upper = [[*moved[i], *gain[i]] for i in range(n)]
    lower = [[-v for v in (*weight[i], *(row[i] for row in moved))] for i in range(n)]
    values, vectors = acb_mat(upper + lower).mid().eig(right=True, algorithm="approx")
    stable = [j for j, value in enumerate(values) if value.real < 0]
    if len(stable) != n:
        return None
    table = vectors.tolist()
    top, low = (acb_mat([[row[j] for j in stable] for row in part]) for part in (table[:n], table[n:]))
    try:
        P = [[value.real for value in row] for row in top.transpose().solve(low.transpose()).tolist()]
    except ZeroDivisionError:
        return None
    if not all(value.is_finite() for row in P for value in row):
        return None
    return [[(exact_midpoint(P[i][j]) + exact_midpoint(P[j][i])) / 2 for j in range(i + 1)] for i in range(n)]
