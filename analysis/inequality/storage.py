r"""The circle criterion beside play and stop with their storage functions, in floating point.

For the loop of ``y = A x - B phi`` with ``psi = phi'`` in the sectors ``[0, w_i]`` of ``sigma'`` they serve if

.. math:: F(\omega) = \Lambda W^{-1} + \mathrm{He}\,[\Lambda H + \Theta (H - H(0))/(i\omega)] > 0

at every frequency, ``Theta H(0)`` being symmetric, ``theta_i >= 0`` for play and ``<= 0`` for stop.  That is Popov's
inequality with ``eta = C A^{-1} y`` in place of ``sigma'``.  Nothing here is believed: a checker decides.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import ClassVar

from flint import fmpq, fmpq_mat

from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.channels import ChannelInequality
from lure.analysis.inequality.kernels import Found
from lure.analysis.inequality.shifted_loop import ChannelSearch, Proposal
from lure.analysis.inequality.zero_modes import null_rows
from lure.analysis.numerics.semidefinite import Block, proposed, symmetric_basis
from lure.arrays import NDArray, np

_LEAST = 1e-7  # of the largest entry that may be 1: what is positive
_NOTHING = 1e-7  # relative: storage that is not worth its rounding


@dataclass
class StorageInequality(ChannelInequality):
    """The inequality with storage functions; the lower bounds are 0; others: :class:`ChannelInequality`.

    Parameters
    ----------
    signs : sequence of int
        Of each ``theta``: 1 for play, -1 for stop, 0 for either; where ``free`` says so.
    still : fmpq_mat or None
        (m, m) ``H(0)``.
    """

    signs: Sequence[int] = ()
    still: fmpq_mat | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        cone = self.cone  # which theta there are
        cone.turning = self._turning()
        cone.theta_signs = [sign if free else 0 for sign, free in zip(self.signs, self.free, strict=True)]

    @property
    def rates(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """``C A^{-1}``, and nothing of the inputs."""
        return np.asarray(np.linalg.solve(self.A.T, self.own.T).T, dtype=float), np.zeros_like(self.D)

    def _turning(self) -> list[tuple[int, list[Fraction]]]:
        """``theta`` with ``Theta H(0)`` symmetric: channels that are free, and what others are of these."""
        m = len(self.D)
        assert self.still is not None, "H(0)"
        rows = [[fmpq(0)] * m for _ in range(m * m)]
        for i in range(m):
            rows[i * m + i][i] = fmpq(int(not self.free[i]))
            for j in range(i):
                rows[i * m + j][i] = self.still[i, j]
                rows[i * m + j][j] = -self.still[j, i]
        basis = null_rows(fmpq_mat(rows))
        found = list[tuple[int, list[Fraction]]]()
        for k in range(basis.nrows()):
            row = [Fraction(int(v.p), int(v.q)) for v in (basis[k, j] for j in range(m))]
            alone = [not any(basis[i, j] for i in range(basis.nrows()) if i != k) for j in range(m)]
            first = next(j for j, v in enumerate(row) if v == 1 and alone[j])
            found.append((first, row))
        return found

    def _exact(self, found: Found, digits: int) -> tuple[list[Fraction], list[Fraction]]:
        """``lambda`` and ``theta`` with so many digits; ``Theta H(0)`` symmetric exactly."""
        weights = [Fraction(f"{v:.{digits}g}") for v in found.gamma]
        theta, least = [Fraction(0)] * len(weights), _NOTHING * self.unit * float(max(found.gamma))
        for first, row in self.cone.turning or ():
            t = Fraction(f"{found.theta[first]:.{digits}g}")
            if abs(t) > least:
                theta = [v + t * c for v, c in zip(theta, row, strict=True)]
        return weights, theta

    def proposals(self, widths: Sequence[Fraction], lower: Sequence[Fraction]) -> Iterator[Proposal]:
        """Multipliers that serve, rounded, with ``P`` of Riccati equations."""
        at = np.array([float(w) for w in widths])
        for found in (self.cone.known(at), self.cone.serving(at)):
            if found is None:
                continue
            weights, theta = self._exact(found, 12)
            scaled = [v / w for v, w in zip(weights, widths, strict=True)]  # for psi (w sigma' - psi)
            Pi = self.form(np.array([float(v) for v in scaled]), at)
            stated = {"lambda": [*map(str, scaled)]} | self.popovs(theta)
            for proof in self.solutions(Pi, theta, lower):
                yield Proposal(stated, proof)


@dataclass
class MovedByStops(ChannelSearch):
    """The same with an eigenvalue 0 that stops move: ``phi_i = f_i y``, by semidefinite programmes in ``P``.

    Parameters
    ----------
    moved : ndarray
        (m, n) the rows ``f_i``, 0 where there is none.
    operators : sequence of sequence of int
        The channels from ``z`` to ``w``.
    """

    moved: NDArray[np.float64]
    operators: Sequence[Sequence[int]] = ()
    precision: ClassVar[float] = 1e-5

    def serves(self, widths: NDArray[np.float64]) -> bool:
        """Whether a programme has a solution; see :class:`ChannelSearch`."""
        return self._solved(widths) is not None

    def proposals(self, widths: Sequence[Fraction], lower: Sequence[Fraction]) -> Iterator[Proposal]:
        """The solution of the programme, rounded."""
        assert not any(lower), "of play and stop, and of gains"
        found = self._solved(np.array([float(w) for w in widths]))
        if found is not None:
            P, weights, theta = found
            exponent = max(0, 50 - int(np.floor(np.log2(max(np.abs(P).max(), 1e-300)))))
            rows = [[str(round(Fraction(float(v)) * 2**exponent)) for v in row[: i + 1]] for i, row in enumerate(P)]
            stated = {"lambda": [f"{v:.12g}" for v in weights], "theta": [f"{v:.12g}" for v in theta]}
            exact = {name: [str(Fraction(v)) for v in side] for name, side in stated.items()}
            yield Proposal(exact, {"method": "matrix", "P": rows, "exponent": exponent})

    def _solved(
        self, widths: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]] | None:
        """``P``, ``lambda`` and ``theta`` with ``-V' >= t > 0``; None if there are none."""
        checkpoint()
        (n, m), out = self.B.shape, [i for block in self.operators for i in block]
        basis, flow, seen = symmetric_basis(n), np.hstack([self.A, -self.B]), np.hstack([self.C, -self.D])
        stops = [i for i in range(m) if self.moved[i].any()]
        states, inputs, K = np.eye(n, n + m), np.eye(m, n + m, n), len(basis)
        slopes = np.zeros((K + m + len(stops) + 1, n + m, n + m))
        slopes[:K] = -2 * (states.T @ basis @ flow)
        for i in range(m):
            w, u, s = widths[i], inputs[i], seen[i]
            form = w * w * np.outer(s, s) - np.outer(u, u) if i in out else np.outer(u, w * s - u)
            slopes[K + i] = -2 * form / w
        for k, i in enumerate(stops, K + m):  # -theta_i
            slopes[k] = -2 * np.outer(self.moved[i] @ states, seen[i])
        slopes[-1] = -np.eye(n + m)
        slopes = (slopes + slopes.swapaxes(1, 2)) / 2
        V = np.zeros((len(slopes), n, n))
        V[:K] = basis
        for k, i in enumerate(stops, K + m):
            V[k] = np.outer(self.moved[i], self.moved[i]) / widths[i]
        V[-1] = -np.eye(n)
        rows = np.vstack([-np.eye(len(slopes))[K:], np.eye(len(slopes))[K:]])
        limits = np.concatenate([np.zeros(m + len(stops)), [1.0], np.full(m + len(stops), 1.0), [1.0]])
        zero = [np.zeros((size, size)) for size in (n + m, n)]
        x = proposed(np.eye(len(slopes))[-1], [Block(zero[0], slopes), Block(zero[1], V)], rows, limits)
        if x is None or not x[-1] > _LEAST:
            return None
        theta = np.zeros(m)
        theta[stops] = -x[K + m : -1]
        weights = np.array([max(x[K + i], 0.0) / widths[i] for i in range(m)])
        weights[out] = weights[out].mean() if out else 0.0
        return np.tensordot(x[:K], basis, 1), weights, theta
