r"""The circle criterion beside play and stop with their storage functions, in floating point.

For the loop of ``y = A x - B phi`` with ``psi = phi'`` in the sectors ``[0, w_i]`` of ``sigma'`` they serve if

.. math:: F(\omega) = \Lambda W^{-1} + \mathrm{He}\,[\Lambda H + \Theta (H - H(0))/(i\omega)] > 0

at every frequency, ``Theta H(0)`` being symmetric, ``theta_i >= 0`` for play and ``<= 0`` for stop.  That is Popov's
inequality with ``eta = C A^{-1} y`` in place of ``sigma'``.  Nothing here is believed: a checker decides.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import cached_property
from itertools import product
from typing import ClassVar

from flint import fmpq, fmpq_mat

from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.channels import ChannelInequality
from lure.analysis.inequality.kernels import Found
from lure.analysis.inequality.shifted_loop import ChannelSearch, Proposal
from lure.analysis.inequality.zero_modes import doubles, null_rows
from lure.analysis.numerics.doubles import decimals, matrix_proof
from lure.analysis.numerics.semidefinite import Block, proposed, symmetric_basis
from lure.arrays import NDArray, Reals, linalg, np
from lure.record import described, quantity

_LEAST = 1e-7  # of the largest entry that may be 1: what is positive
_CHAINS = 3  # of channels, each with both signs
_NOTHING = 1e-7  # relative: storage that is not worth its rounding


@described()
class StorageInequality(ChannelInequality):
    """The inequality with storage functions, lower bounds 0 where there are any; others: :class:`ChannelInequality`."""

    signs: Sequence[int] = quantity(
        "Of each ``theta``: 1 for play, -1 for stop, 0 for either; where ``free`` says so", default=()
    )
    still: fmpq_mat | None = quantity("(m, m) ``H(0)``", default=None)
    resting: NDArray[np.float64] | None = quantity(
        "(m, n) ``C A^{-1}``, and 0 in the channels of functions ``phi`` themselves, where ``theta`` is Popov's",
        default=None,
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        cone = self.cone  # which theta there are
        cone.turning = turning(self.free, self.still or fmpq_mat(0, 0))
        cone.theta_signs = [sign if free else 0 for sign, free in zip(self.signs, self.free, strict=True)]

    @property
    def rates(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """``C A^{-1}``, and nothing of the inputs; Popov's terms multiply ``sigma'``."""
        assert self.resting is not None, "given with the signs"
        (through, direct), stored = super().rates, self.resting.any(axis=1, keepdims=True)
        return np.where(stored, self.resting * self.units, through), np.where(stored, 0.0, direct)

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


def turning(free: Sequence[bool], still: fmpq_mat) -> list[tuple[int, list[Fraction]]]:
    """``theta`` with ``Theta H(0)`` symmetric: channels that are free, and what others are of these.

    ``free``: which ``theta`` may differ from 0; ``still``: (m, m) ``H(0)``, in discrete time ``H(1)``.
    """
    m = len(free)
    rows = [[fmpq(0)] * m for _ in range(m * m)]
    for i in range(m):
        rows[i * m + i][i] = fmpq(int(not free[i]))
        for j in range(i):
            rows[i * m + j][i] = still[i, j]
            rows[i * m + j][j] = -still[j, i]
    basis = null_rows(fmpq_mat(rows))
    found = list[tuple[int, list[Fraction]]]()
    for k in range(basis.nrows()):
        row = [Fraction(int(v.p), int(v.q)) for v in (basis[k, j] for j in range(m))]
        alone = [not any(basis[i, j] for i in range(basis.nrows()) if i != k) for j in range(m)]
        first = next(j for j, v in enumerate(row) if v == 1 and alone[j])
        found.append((first, row))
    return found


@described()
class MovedByStops(ChannelSearch):
    """The same with an eigenvalue 0 that stops move: ``phi_i = f_i y``, by semidefinite programmes in ``P``."""

    moved: NDArray[np.float64] = quantity("(m, n) the rows ``f_i``, 0 where there is none")
    operators: Sequence[Sequence[int]] = quantity("The channels from ``z`` to ``w``", default=())
    precision: ClassVar[float] = 1e-5

    def serves(self, widths: NDArray[np.float64]) -> bool:
        """Whether a programme has a solution; see :class:`ChannelSearch`."""
        return self._solved(widths) is not None

    def proposals(self, widths: Sequence[Fraction], lower: Sequence[Fraction]) -> Iterator[Proposal]:
        """The solution of the programme, rounded."""
        found = self._solved(np.array([float(w) for w in widths]))
        if found is not None:
            P, weights, theta = found
            stated = {"lambda": [*map(str, decimals(weights))], "theta": [*map(str, decimals(theta))]}
            yield Proposal(stated, matrix_proof(P, float(np.abs(P).max()), 50))

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
            w, u, s = widths[i], inputs[i] - self.lower[i] * seen[i], seen[i]
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


@described()
class SampledStorage(ChannelSearch):
    """Storage functions in discrete time, of the loop of the differences, by semidefinite programmes in ``P``."""

    free: Sequence[bool] = quantity("Which ``theta`` may differ from 0")
    signs: Sequence[int] = quantity("Of each ``theta``: 1 for play, -1 for stop, 0 for either")
    still: fmpq_mat = quantity("(m, m) ``H(1)``")
    resting: NDArray[np.float64] = quantity(
        "(m, n) ``C (A - 1)^{-1}``, and 0 in the channels of functions ``phi`` themselves"
    )
    precision: ClassVar[float] = 1e-5

    def serves(self, widths: NDArray[np.float64]) -> bool:
        """Whether a programme has a solution; see :class:`ChannelSearch`."""
        return any(self._solved(widths, given) is not None for given in self._choices)

    @cached_property
    def _choices(self) -> list[list[list[Fraction]]]:
        """Which ``theta`` are tried together, up to positive factors: of all chains of channels, and of each alone."""
        chains = list[list[list[Fraction]]]()
        for _, row in turning(self.free, self.still):
            fits = [s for s in (1, -1) if all(s * v * sign >= 0 for v, sign in zip(row, self.signs, strict=True))]
            chains += [[[s * v for v in row] for s in fits]] if fits else []
        whole = [list(one) for one in product(*chains)] if len(chains) <= _CHAINS else [[one[0] for one in chains]]
        return whole + [[row] for one in chains for row in one if len(chains) > 1]

    def proposals(self, widths: Sequence[Fraction], lower: Sequence[Fraction]) -> Iterator[Proposal]:
        """Solutions of the programmes, rounded."""
        at = np.array([float(w) for w in widths])
        for given in self._choices:
            found = self._solved(at, given)
            if found is None:
                continue
            P, weights, factors = found
            exact = decimals(factors)
            theta = [
                sum((f * v for f, v in zip(exact, column, strict=True)), Fraction(0))
                for column in zip(*given, strict=True)
            ]
            stated = {"lambda": [*map(str, decimals(weights))], "theta": [*map(str, theta)]}
            yield Proposal(stated, matrix_proof(P, float(np.abs(P).max()), 50))

    @cached_property
    def _even(self) -> tuple[Reals, Reals, Reals, Reals]:
        """``A``, ``B`` and ``C`` in states that unit inputs make equally large, and these of the given ones."""
        reached = linalg.solve_discrete_lyapunov(self.A, self.B @ self.B.T)
        values, vectors = np.linalg.eigh((reached + reached.T) / 2)
        sizes = np.sqrt(np.maximum(values, _LEAST**2 * values.max()))
        turn, back = vectors.T / sizes[:, None], vectors * sizes
        return turn @ self.A @ back, turn @ self.B, self.C @ back, turn

    def _solved(
        self, widths: NDArray[np.float64], given: Sequence[Sequence[Fraction]]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]] | None:
        """``P``, ``lambda`` and factors of the ``theta`` that leave a margin; None if there are none."""
        checkpoint()
        (n, m), count, (A, B, C, turn) = self.B.shape, len(given), self._even
        basis, flow, seen = symmetric_basis(n), np.hstack([A, -B]), np.hstack([C, -self.D])
        states, inputs, K = np.eye(n, n + m), np.eye(m, n + m, n), len(basis)
        slopes, V = np.zeros((K + m + count + 1, n + m, n + m)), np.zeros((K + m + count + 1, n + m, n + m))
        slopes[:K] = states.T @ basis @ states - flow.T @ basis @ flow
        for i in range(m):
            above = inputs[i] - self.lower[i] * seen[i]
            slopes[K + i] = -2 * np.outer(above, widths[i] * seen[i] - above) / widths[i]
        E, still = self.resting @ np.linalg.inv(turn), doubles(self.still)
        for k, row in enumerate(given, K + m):
            theta = np.array([float(v) for v in row])
            falling, lost = np.diag(np.minimum(theta, 0)), np.diag(np.abs(theta) / widths)
            S = np.diag(theta) @ still
            eta = np.where(theta[:, None] > 0, E @ flow, E @ states)
            half = theta[:, None] * eta - np.where(theta[:, None] > 0, S, 0) @ inputs
            slopes[k] = -2 * inputs.T @ (half + (S - lost) @ inputs / 2)
            V[k] = 2 * inputs.T @ falling @ (E @ states - still @ inputs) + inputs.T @ (S + lost) @ inputs
        V[:K] = states.T @ basis @ states
        slopes[-1], V[-1] = -np.eye(n + m), -np.eye(n + m)
        used = [*range(n), *(n + i for i in range(m) if any(row[i] for row in given))]
        both = [(side + side.swapaxes(1, 2)) / 2 for side in (slopes, V[np.ix_(range(len(V)), used, used)])]
        rows = np.vstack([-np.eye(len(slopes))[K:], np.eye(len(slopes))[K:]])
        limits = np.concatenate([np.zeros(m + count), np.full(m + count + 2, 1.0)])
        x = proposed(np.eye(len(slopes))[-1], [Block(np.zeros(one.shape[1:]), one) for one in both], rows, limits)
        if x is None or not x[-1] > _LEAST:
            return None
        return (
            turn.T @ np.tensordot(x[:K], basis, 1) @ turn,
            np.maximum(x[K : K + m], 0) / widths,
            np.maximum(x[K + m : -1], 0),
        )
