r"""Diagonal multipliers for many channels, in floating point: linear programmes over frequencies and directions.

As :mod:`lure.analysis.inequality.channels`, of which a semidefinite programme over frequencies has ``m^4`` numbers:
``F(omega) = Lambda W^{-1} + He Lambda H(i omega) > 0`` is put as ``v^* F(omega) v >= t |v|^2`` for the directions
``v`` in which it was worst.  Nothing here is believed: a checker decides.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import ClassVar

from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.shifted_loop import Proposal, ShiftedLoop
from lure.arrays import NDArray, linalg, np, optimize

_ROUNDS, _SURE, _POINTS, _DEEPEST, _KEPT = 40, 1e-9, 160, 12, 600


@dataclass
class ManyChannels(ShiftedLoop):
    """The inequality of one plant and lower bounds; parameters as for :class:`ShiftedLoop`."""

    precision: ClassVar[float] = 1e-3
    cuts: list[tuple[NDArray[np.float64], NDArray[np.float64]]] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__post_init__()
        every = -(-len(self.omega) // _POINTS)
        kept = np.unique(np.append(np.arange(0, len(self.omega), every), len(self.omega) - 1))
        self.omega, self.states, self.H = self.omega[kept], self.states[kept], self.H[kept]

    def serves(self, widths: NDArray[np.float64]) -> bool:
        """Whether multipliers were found; see :meth:`weights`."""
        return self.weights(widths) is not None

    def weights(self, widths: NDArray[np.float64]) -> NDArray[np.float64] | None:
        """``lambda`` that serves at the frequencies, None if there is none or it was not found.

        Parameters
        ----------
        widths : ndarray
            (m,) of the shifted sectors.
        """
        m, core = len(widths), np.ones(len(widths)) / len(widths)
        for _ in range(_ROUNDS):
            checkpoint()
            if self._worst(core, widths) > _SURE:
                return core * widths
            self.cuts = self.cuts[-_KEPT:]
            squares, plain = (np.array([cut[k] for cut in self.cuts]) for k in range(2))
            rows = np.hstack([-(squares + plain * widths), squares.sum(axis=1)[:, None]])
            rows /= np.abs(rows).max(axis=1, keepdims=True)
            solved = optimize.linprog(
                np.append(np.zeros(m), -1.0),
                A_ub=rows,
                b_ub=np.zeros(len(rows)),
                A_eq=np.append(np.ones(m), 0.0)[None],
                b_eq=[1.0],
                bounds=[(0, None)] * m + [(None, None)],
                method="highs",
            )
            if solved.status != 0 or solved.x[-1] <= _SURE:
                return None
            core = (core + solved.x[:m]) / 2  # fewer rounds than the corners of the programme
        return None

    def _worst(self, shares: NDArray[np.float64], widths: NDArray[np.float64]) -> float:
        """The least eigenvalue for ``lambda_i = shares_i w_i``; cuts where it is least."""
        inner = (shares * widths)[:, None] * self.H
        F = (inner + inner.conj().swapaxes(1, 2)) / 2 + np.diag(shares)
        found = [linalg.eigh(one, subset_by_index=(0, 0)) for one in F]
        least = np.array([values[0] for values, _ in found])
        for i in np.argsort(least)[:_DEEPEST]:
            v = found[i][1][:, 0]
            self.cuts.append((np.abs(v) ** 2, (v.conj() * (self.H[i] @ v)).real))
        return float(least.min())

    def proposals(self, widths: Sequence[Fraction], lower: Sequence[Fraction]) -> Iterator[Proposal]:
        """Multipliers that serve, rounded, with ``P`` of Riccati equations."""
        found = self.weights(np.array([float(w) for w in widths]))
        if found is None:
            return
        weights = [Fraction(f"{v:.12g}") for v in found]
        scaled = [v / w for v, w in zip(weights, widths, strict=True)]  # for psi (w sigma - psi)
        plain, ends = (np.diag([float(v) for v in side]) for side in (weights, scaled))
        theta = [Fraction(0)] * len(weights)
        multiplier = {"lambda": [*map(str, scaled)]} | self.popovs(theta)
        for proof in self.solutions(np.block([[0 * plain, plain], [plain, -2 * ends]]), theta, lower):
            yield Proposal(multiplier, proof)
