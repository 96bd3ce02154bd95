r"""Several nonlinearities in discrete time: forms of ``T`` samples of each, or of all channels of a repeated one.

With ``phi_i = l_i sigma_i + psi_i`` the samples ``psi_i`` and ``w_i sigma_i - psi_i`` of one nonlinearity lie in an
order cone (``lure.analysis.inequality.order_cones``).  For a block ``b`` of channels with one nonlinearity let
``W_b`` hold the rows ``z^t e_i`` and ``-z^t (w_i H_i + e_i)``, ``t < T``; forms ``M_b`` that are positive on the order
cones serve if ``sum_b W_b^* M_b W_b < 0`` on the circle.  Operators of norm up to ``w_b`` add ``a_b (w_b^2 H_b^* H_b -
1_b)``, ``a_b >= 0``.  Nothing here is believed: a checker decides.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import field
from fractions import Fraction
from typing import Any, ClassVar

from lure.analysis.certificates.states import order_positive
from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.order_cones import OrderCones
from lure.analysis.inequality.shifted_loop import Proposal, ShiftedLoop
from lure.analysis.numerics.doubles import matrix_proof, triangle_texts
from lure.arrays import NDArray, Reals, in_doubles, linalg, np, optimize
from lure.record import described, quantity

_LEAST, _ROUNDS, _BITS, _DIGITS = 1e-7, 80, 56, 10**9
_SLACKS, _RAISED = (0.5, 0.1, 1e-2, 1e-3), (0.0, 1e-8, 1e-7, 1e-6)


@described()
class ChannelWindows(ShiftedLoop):
    """The inequality of one plant and lower bounds; parameters as for the diagonal multipliers."""

    blocks: Sequence[Sequence[int]] = quantity("The channels of each nonlinearity", default=())
    odd: Sequence[bool] = quantity("Of each nonlinearity, whether it is odd", default=())
    samples: int = quantity("Number ``T``; the samples of a block are at most 4", default=2)
    precision: ClassVar[float] = 1e-5
    cuts: list[tuple[float, NDArray[np.complex128]]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.given = self.A, self.B, self.C, self.D
        super().__post_init__()
        self.cones = [
            OrderCones(self.samples * len(block), odd) for block, odd in zip(self.blocks, self.odd, strict=True)
        ]

    def serves(self, widths: NDArray[np.float64]) -> bool:
        """Whether forms were found for these widths."""
        return self.forms(widths) is not None

    def forms(self, widths: NDArray[np.float64]) -> list[Reals] | None:
        """A form for each block that serves with a margin, None if there are none; last the weights of the operators.

        ``widths``: (m,) of the shifted slopes.
        """
        known: Reals | None = None
        best = -math.inf
        if not self.cuts:
            for omega in (0.0, math.pi / 2, math.pi):
                self.cuts += [(omega, v.astype(complex)) for v in np.eye(len(widths))]
        for _ in range(_ROUNDS):
            checkpoint()
            x, margin = self._programme(widths)
            if margin < _LEAST:
                return None
            x = x if known is None else (x + known) / 2
            forms = self._unpacked(x)
            least = self._cone_cuts(forms, margin)
            worst = min(least, self._frequency_cuts(forms, widths, margin))
            if worst > max(_LEAST, margin / 10):
                return forms
            known, best = (x, worst) if worst > best else (known, best)
        return None

    def _sides(self, widths: NDArray[np.float64], omega: NDArray[np.float64]) -> list[NDArray[np.complex128]]:
        """``W_b`` at the frequencies: (frequencies, 2 T |b|, m)."""
        H, m = self.response(omega)[1], len(widths)
        z, one = np.exp(1j * omega)[:, None, None], np.eye(m)
        v = -(widths[:, None] * H + one)
        found = []
        for block in self.blocks:
            u = [np.broadcast_to(one[[*block]], H[:, [*block]].shape) * z**t for t in range(self.samples)]
            found.append(np.concatenate([*u, *(v[:, [*block]] * z**t for t in range(self.samples))], axis=1))
        return found

    def _entries(self, size: int) -> tuple[NDArray[np.intp], NDArray[np.intp], Reals]:
        left, right = np.tril_indices(size)
        return left, right, np.where(left == right, 1.0, 2.0)

    def _acted(self, widths: Reals, H: NDArray[np.complex128], v: NDArray[np.complex128]) -> Reals:
        """``w_b^2 |H_b v|^2 - |v_b|^2`` for each operator, in columns: (frequencies, operators)."""
        seen = np.einsum("fij,fj->fi", H, v)
        values = widths**2 * np.abs(seen) ** 2 - np.abs(v) ** 2
        return np.stack([values[:, [*block]].sum(axis=1) for block in self.operators] or [values[:, :0]], axis=-1)

    def _unpacked(self, x: Reals) -> list[Reals]:
        found, start = list[Reals](), 0
        for cone in self.cones:
            M = np.zeros((2 * cone.samples,) * 2)
            left, right, _ = self._entries(len(M))
            M[left, right] = M[right, left] = x[start : start + len(left)]
            found, start = [*found, M], start + len(left)
        weights = np.zeros(len(self.D))
        for block, weight in zip(self.operators, x[start:], strict=True):
            weights[[*block]] = max(weight, 0.0)
        return [*found, weights]

    def _programme(self, widths: NDArray[np.float64]) -> tuple[Reals, float]:
        """The forms of the largest margin that the cuts leave, and that margin."""
        omega, turned = np.array([cut[0] for cut in self.cuts]), np.array([cut[1] for cut in self.cuts])
        columns, sizes = list[Reals](), np.zeros(len(omega))
        for side in self._sides(widths, omega):
            w = np.einsum("fij,fj->fi", side, turned)
            left, right, twice = self._entries(w.shape[1])
            columns.append((w[:, left].conj() * w[:, right]).real * twice)
            sizes += (np.abs(w) ** 2).sum(axis=1)
        if self.operators:
            columns.append(self._acted(widths, self.response(omega)[1], turned).reshape(len(omega), -1))
            sizes += np.abs(columns[-1]).sum(axis=1)
        top = np.hstack(columns) / sizes[:, None]
        starts = np.cumsum([0, *(column.shape[1] for column in columns)])
        lines = [top]
        for i, cone in enumerate(self.cones):
            points = np.array(cone.cuts).reshape(-1, 2 * cone.samples)
            left, right, twice = self._entries(2 * cone.samples)
            line = np.zeros((len(points), top.shape[1]))
            line[:, starts[i] : starts[i + 1]] = -points[:, left] * points[:, right] * twice
            lines.append(line)
        A = np.vstack(lines)
        count = A.shape[1]
        solved = optimize.linprog(
            np.append(np.zeros(count), -1.0),
            A_ub=np.column_stack([A, np.ones(len(A))]),
            b_ub=np.zeros(len(A)),
            bounds=[(-1, 1)] * (count - len(self.operators)) + [(0, 1)] * len(self.operators) + [(None, 1)],
            method="highs",
        )
        return (np.zeros(count), 0.0) if solved.x is None else (np.asarray(solved.x[:-1]), float(solved.x[-1]))

    def _cone_cuts(self, forms: list[Reals], margin: float) -> float:
        found = math.inf
        for cone, M in zip(self.cones, forms[:-1], strict=True):
            least, points = cone.least(M)
            cone.cuts += [w for w in points if w @ M @ w < margin / 2]
            found = min(found, least)
        return found

    def _frequency_cuts(self, forms: list[Reals], widths: NDArray[np.float64], margin: float) -> float:
        """The least margin over the grid; cuts at the local ones."""
        m = len(widths)
        total = np.zeros((len(self.omega), m, m), complex)
        adjoint, weights = self.H.conj().swapaxes(1, 2), forms[-1]
        total = total + adjoint @ ((weights * widths**2)[:, None] * self.H) - np.diag(weights)
        scale = adjoint @ ((self.acting * widths**2)[:, None] * self.H) + np.diag(self.acting)
        for side, M in zip(self._sides(widths, self.omega), forms[:-1], strict=True):
            adjoint = side.conj().swapaxes(1, 2)
            total, scale = total + adjoint @ M @ side, scale + adjoint @ side
        factor = np.linalg.inv(np.linalg.cholesky(scale))
        values, vectors = np.linalg.eigh(factor @ total @ factor.conj().swapaxes(1, 2))
        worst = values[:, -1]
        padded = np.concatenate([[-np.inf], worst, [-np.inf]])
        peaks = np.flatnonzero((worst >= padded[:-2]) & (worst >= padded[2:]) & (worst > -margin / 2))
        for i in peaks:
            self.cuts.append((float(self.omega[i]), factor[i].conj().T @ vectors[i][:, -1]))
        return -float(worst.max())

    def proposals(self, widths: Sequence[Fraction], lower: Sequence[Fraction]) -> Iterator[Proposal]:
        """Forms in decimals with ``P`` of Riccati equations, for the loop as it was given."""
        forms = self.forms(np.array([float(w) for w in widths]))
        if forms is None:
            return
        exact = list[list[list[Fraction]]]()
        weights = [Fraction(round(v * _DIGITS), _DIGITS) for v in forms.pop().tolist()]
        for M, odd in zip(forms, self.odd, strict=True):
            for raised in _RAISED:
                near = (M + raised * np.eye(len(M))) * _DIGITS
                rows = [[Fraction(round(v), _DIGITS) for v in row] for row in near.tolist()]
                if order_positive(rows, odd):
                    exact.append(rows)
                    break
        if len(exact) < len(forms):
            return
        windows = [triangle_texts(M) for M in exact]
        multiplier: dict[str, Any] = {"windows": windows, "odd": [bool(odd) for odd in self.odd]}
        multiplier |= {"lambda": [*map(str, weights)]} if self.operators else {}
        stated = [in_doubles(M) for M in exact]
        stated.append(np.array([float(v) for v in weights]))
        for P in self._solutions(stated, [float(w) for w in widths], [float(v) for v in lower]):
            yield Proposal(multiplier, matrix_proof(P, float(np.abs(P).max()) or 1.0, _BITS))

    def _solutions(self, forms: list[Reals], widths: list[float], lower: list[float]) -> Iterator[Reals]:
        """``P`` with ``V(xi+) - V(xi) + sum w' M w < 0``, ``xi`` the oldest state and all inputs but the last."""
        A, B, C, D = self.given
        (n, m), T = B.shape, self.samples
        x, states, seen = np.eye(n, n + m * T), [np.eye(n, n + m * T)], list[Reals]()
        for t in range(T):
            phi = np.eye(m, n + m * T, n + m * t)
            seen.append(C @ x - D @ phi)
            x = A @ x - B @ phi
            states.append(x)
        inputs = np.eye(n + m * T)[n:]
        moved, S = np.vstack([states[1], inputs[m:]]), np.zeros((n + m * T,) * 2)
        for i, weight in enumerate(forms[-1]):
            last, out = inputs[(T - 1) * m + i], seen[T - 1][i]
            S += weight * (widths[i] ** 2 * np.outer(out, out) - np.outer(last, last))
        for block, M in zip(self.blocks, forms[:-1], strict=True):
            points = [(inputs[t * m + i], seen[t][i], i) for t in range(T) for i in block]
            u = [p - lower[i] * s for p, s, i in points]
            w = np.array([*u, *((lower[i] + widths[i]) * s - p for p, s, i in points)])
            S += w.T @ M @ w
        order = n + m * (T - 1)
        F, G = moved[:, :order], moved[:, order:]
        size = float(np.abs(S).max())
        for share in _SLACKS:
            checkpoint()
            slack = share * 1e-5 * size
            try:
                with np.errstate(all="ignore"):
                    P = -linalg.solve_discrete_are(
                        F, G, -S[:order, :order] - slack * np.eye(order), -S[order:, order:], s=-S[:order, order:]
                    )
            except (np.linalg.LinAlgError, ValueError):
                continue
            if np.isfinite(P).all():
                yield (P + P.T) / 2
