r"""The frequency inequality of several channels, in floating point: diagonal multipliers, ``P`` by Riccati.

After the shift by the lower bounds ``psi_i`` lies in ``[0, w_i]``; the diagonal multipliers ``lambda, theta`` serve if

.. math:: F(\omega) = \Lambda W^{-1} + \mathrm{He}\, (\Lambda + i \omega \Theta) H(i \omega) > 0

(``He M = (M + M^*)/2``) at every frequency, infinity included; in discrete time at ``z = e^{i omega}``, ``Theta = 0``.
For an operator of norm up to ``w`` the term is ``lambda (1/w - w H_b^* H_b)``.
It is linear in them; semidefinite programmes over the worst frequencies propose them.  Eigenvalues 0 of the loop are
taken apart (:mod:`lure.analysis.inequality.zero_modes`).  Nothing here is believed: a checker decides with rational
``P``, ``lambda`` and ``theta``.

Such a programme has ``m^4`` numbers.  For many channels linear ones over frequencies and directions take its place:
``F(omega) = Lambda W^{-1} + He Lambda H(i omega) > 0`` is put as ``v^* F(omega) v >= t |v|^2`` for the directions
``v`` in which it was worst.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import ClassVar

from lure.analysis.certificates.frequencies import MOST_CHANNELS
from lure.analysis.deadline import checkpoint
from lure.analysis.inequality import dissipation
from lure.analysis.inequality.kernel_cone import KernelCone
from lure.analysis.inequality.kernels import Found
from lure.analysis.inequality.shifted_loop import LARGEST, MEETING, Proposal, ShiftedLoop, Widths
from lure.analysis.inequality.zero_modes import ZeroModes, doubles, whole
from lure.analysis.numerics.doubles import decimals
from lure.arrays import NDArray, linalg, np, optimize
from lure.record import described, quantity

MOST_STATES = 30  # determinants of larger loops take long
_ROUNDS, _SURE, _POINTS, _DEEPEST, _KEPT = 40, 1e-9, 160, 12, 600  # of many channels


@described()
class ChannelInequality(ShiftedLoop):
    """The inequality with diagonal multipliers; parameters as for :class:`ShiftedLoop`."""

    modes: ZeroModes | None = quantity("The eigenvalues 0 of the loop with the lower bounds", default=None)

    @cached_property
    def cone(self) -> KernelCone:
        """The multipliers: those of the cone of kernels that has none."""
        ratios = () if self.modes is None else tuple((first, float(ratio)) for first, ratio in self.modes.ratios)
        return KernelCone(self, [], [False] * len(self.D), ratios)

    def _apart(self) -> NDArray[np.float64]:
        """``He Lambda R/(z - 1)`` is ``-Lambda R/2``; ``He Lambda R/(i omega)`` is 0, and ``i omega H`` keeps ``R``."""
        if self.modes is None:
            return super()._apart()
        through, R = doubles(self.modes.right * self.modes.left), self.modes.residue()
        far = 1.0 if self.discrete else float(np.abs(np.linalg.eigvals(self.A)).max()) or 1.0
        self.A, self.B = self.A - far * through, self.B - through @ self.B
        if self.discrete:
            self.D = self.D - R / 2
        return 0 * R if self.discrete else R

    def serves(self, widths: NDArray[np.float64]) -> bool:
        """Whether there are multipliers; see :class:`ChannelSearch`."""
        return self.cone.serving(widths) is not None

    def largest(self, widths: Widths, start: float, most: float) -> float:
        """The largest factor for which multipliers were found; see :class:`ChannelSearch`."""
        top = min(most, LARGEST) * (1 - MEETING)
        search = dissipation.largest if dissipation.applies(self.cone) else KernelCone.largest
        begin = start if start and widths(start).min() > 0 else max(1.0, 2 * start)
        found = search(self.cone, widths, top if most < LARGEST else begin, top)
        return 0.0 if found is None else found.factor

    def proposals(self, widths: Sequence[Fraction], lower: Sequence[Fraction]) -> Iterator[Proposal]:
        """Multipliers that serve, rounded: over all frequencies, then with ``P`` of Riccati equations."""
        at = np.array([float(w) for w in widths])
        exact = not self.discrete and len(widths) <= MOST_CHANNELS and len(self.A) <= MOST_STATES
        known = self.cone.known(at) if exact else None
        if known is not None:
            yield self._by_determinant(known, widths)
        found = self.cone.serving(at)
        if found is None:
            return
        if exact:
            yield self._by_determinant(found, widths)
        weights, theta = self._exact(found, 12)
        scaled = [v / w for v, w in zip(weights, widths, strict=True)]  # for psi (w sigma - psi)
        ends, wide = (np.array([float(v) for v in side]) for side in (scaled, widths))
        multiplier, Pi = {"lambda": [*map(str, scaled)]} | self.popovs(theta), self.form(ends, wide)
        if self.modes is None:
            for proof in self.solutions(Pi, theta, lower):
                yield Proposal(multiplier, proof)
            return
        for Q in self.matrices(Pi, theta):
            factor, proof = whole(self.modes, self.integers(Q), weights, theta, lower)
            stated = {"lambda": [str(factor * v) for v in scaled]}
            yield Proposal(stated | self.popovs([factor * v for v in theta]), proof)

    def _by_determinant(self, found: Found, widths: Sequence[Fraction]) -> Proposal:
        weights, theta = self._exact(found, 15)
        stated = {"lambda": [str(v / w) for v, w in zip(weights, widths, strict=True)]}
        return Proposal(stated | self.popovs(theta), {"method": "determinant"})

    def _exact(self, found: Found, digits: int) -> tuple[list[Fraction], list[Fraction]]:
        """``lambda`` and ``theta`` with so many digits; in the ratios that a residue demands."""
        weights, theta = ([Fraction(f"{v:.{digits}g}") for v in side] for side in (found.gamma, found.theta))
        return weights if self.modes is None else self.modes.weights(weights), theta


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

        ``widths``: (m,) of the shifted sectors.
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
        weights = decimals(found)
        scaled = [v / w for v, w in zip(weights, widths, strict=True)]  # for psi (w sigma - psi)
        plain, ends = (np.diag([float(v) for v in side]) for side in (weights, scaled))
        theta = [Fraction(0)] * len(weights)
        multiplier = {"lambda": [*map(str, scaled)]} | self.popovs(theta)
        for proof in self.solutions(np.block([[0 * plain, plain], [plain, -2 * ends]]), theta, lower):
            yield Proposal(multiplier, proof)
