r"""The frequency inequality of several channels, in floating point: multipliers by cutting planes, ``P`` by Riccati.

After the shift by the lower bounds ``psi_i`` lies in ``[0, w_i]``; the diagonal multipliers ``lambda, theta`` serve if

.. math:: F(\omega) = \Lambda W^{-1} + \mathrm{He}\, (\Lambda + i \omega \Theta) H(i \omega) > 0

(``He M = (M + M^*)/2``) at every frequency, infinity included; in discrete time at ``z = e^{i omega}``, ``Theta = 0``.
It is linear in them: the multipliers solve a linear programme over ``v^* F(omega) v >= t |v|^2``, to which the worst
frequencies are added.  Eigenvalues 0 of the loop are taken apart (:mod:`lure.analysis.inequality.zero_modes`).
Nothing here is believed: a checker decides with rational ``P``, ``lambda`` and ``theta``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

from lure.analysis.certificates.frequencies import MOST_CHANNELS
from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.shifted_loop import Proposal, ShiftedLoop
from lure.analysis.inequality.zero_modes import ZeroModes, doubles, whole
from lure.arrays import NDArray, np, optimize

_ROUNDS, _ZOOMS, _MINIMA, _MOST_CUTS = 60, 6, 8, 120
_SURE = 1e-10  # of the largest: below it a margin is rounding
_LARGEST_THETA = 1e5
_LEAST = 1e-6  # of the sum: a weight, where none may be 0

MOST_STATES = 30  # determinants of larger loops take long


class Multipliers(NamedTuple):
    """``lambda`` for ``psi (sigma - psi/w)`` and ``theta``, with the least ``v^* F v / |v|^2`` that they reach."""

    weights: NDArray[np.float64]
    theta: NDArray[np.float64]
    margin: float


def _between(core: Multipliers, far: Multipliers) -> Multipliers:
    """Half way from multipliers that nearly serve to those of the linear programme: fewer rounds than its corners."""
    weights, theta = ((a + b) / 2 for a, b in zip(core[:2], far[:2], strict=True))
    return Multipliers(weights, theta, far.margin)


@dataclass
class ChannelInequality(ShiftedLoop):
    """The inequality with diagonal multipliers; the cuts are kept from one question to the next."""

    modes: ZeroModes | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        self.cuts = np.empty((0, 3, len(self.D)))

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

    def values(
        self, found: Multipliers, widths: NDArray[np.float64], omega: NDArray[np.float64] | None = None
    ) -> NDArray[np.complex128]:
        """``F`` at the frequencies of the grid, or at given ones."""
        if omega is None:
            omega, states, H = self.omega, self.states, self.H
        else:
            states, H = self.response(omega)
        inner = found.weights[:, None] * H + found.theta[:, None] * self.turned(omega, states, H)
        inner = inner + np.diag(found.weights / widths)
        return np.asarray((inner + inner.conj().swapaxes(1, 2)) / 2)

    def _cut(self, omega: NDArray[np.float64], v: NDArray[np.complex128]) -> None:
        """Cuts at frequencies, each with its direction: (k,) and (k, m)."""
        states, H = self.response(omega)
        of_rate = (self.turned(omega, states, H) @ v[:, :, None])[:, :, 0]
        plain, turned = ((v.conj() * side).real for side in ((H @ v[:, :, None])[:, :, 0], of_rate))
        self.cuts = np.concatenate([self.cuts, np.stack([np.abs(v) ** 2, plain, turned * self.unit], axis=1)])

    def multipliers(self, widths: NDArray[np.float64]) -> Multipliers | None:
        """Multipliers that serve on the grid and between its points, None if there are none.

        Parameters
        ----------
        widths : ndarray
            (m,) of the shifted sectors.
        """
        if not len(self.cuts):
            for omega in (0.0, self.omega[len(self.omega) // 2], self.omega[-1]):
                self._cut(np.full(len(widths), omega), np.eye(len(widths), dtype=complex))
        core: Multipliers | None = None
        for _ in range(_ROUNDS):
            checkpoint()
            far = self._programme(widths)
            if far is None or far.margin <= _SURE:
                return None
            asked = far if core is None else _between(core, far)
            least = self._worst(asked, widths)
            if least > max(_SURE, far.margin / 10):
                return asked._replace(margin=least)
            if core is None or least > core.margin:
                core = asked._replace(margin=least)
        return core if core is not None and core.margin > _SURE else None

    def _programme(self, widths: NDArray[np.float64]) -> Multipliers | None:
        """The linear programme over the cuts: ``sum lambda_i/w_i = 1``, largest margin."""
        m = len(widths)
        squares, plain, turned = self.cuts.swapaxes(0, 1)
        # variables: a_i = lambda_i/w_i, theta_i/unit, t
        rows = np.hstack([-(squares + plain * widths), -turned, squares.sum(axis=1)[:, None]])
        most = [_LARGEST_THETA if free else 0.0 for free in self.free]
        bounds = [(0 if self.modes is None else _LEAST, None)] * m + [(-top, top) for top in most] + [(None, None)]
        total = [np.concatenate([np.ones(m), np.zeros(m + 1)])]
        for i, (first, ratio) in enumerate(() if self.modes is None else self.modes.ratios):
            if i != first:  # a_i w_i = ratio a_first w_first
                total.append(np.zeros(2 * m + 1))
                total[-1][[i, first]] = widths[i], -float(ratio) * widths[first]
        cost = np.concatenate([np.zeros(2 * m), [-1.0]])
        scale = np.abs(rows).max(axis=1, keepdims=True)
        solved = optimize.linprog(
            cost,
            A_ub=rows / scale,
            b_ub=np.zeros(len(rows)),
            A_eq=np.array(total),
            b_eq=[1.0] + [0.0] * (len(total) - 1),
            bounds=bounds,
            method="highs",
        )
        if solved.status != 0:
            return None
        if len(self.cuts) > _MOST_CUTS:  # those far from being met decide nothing
            self.cuts = self.cuts[np.argsort(solved.slack)[: _MOST_CUTS // 2]]
        return Multipliers(solved.x[:m] * widths, solved.x[m : 2 * m] * self.unit, float(solved.x[-1]))

    def _worst(self, found: Multipliers, widths: NDArray[np.float64]) -> float:
        """The least eigenvalue over the frequencies; cuts at its local minima."""
        least, vectors = np.linalg.eigh(self.values(found, widths))
        least = least[:, 0]
        padded = np.concatenate([[np.inf], least, [np.inf]])
        local = np.flatnonzero((least <= padded[:-2]) & (least <= padded[2:]))
        chosen = local[np.argsort(least[local])][:_MINIMA]
        omega, value, v = self.omega[chosen], least[chosen], vectors[chosen, :, 0]
        low, high = self.omega[np.maximum(chosen - 1, 0)], self.omega[np.minimum(chosen + 1, len(least) - 1)]
        wide = np.flatnonzero(np.isfinite(high) & (low < high))
        low, high = low[wide], high[wide]
        for _ in range(_ZOOMS if len(wide) else 0):
            points, each = np.linspace(low, high, 9), np.arange(len(wide))
            values, turned = np.linalg.eigh(self.values(found, widths, points.ravel()))
            values, turned = values[:, 0].reshape(points.shape), turned[:, :, 0].reshape(*points.shape, -1)
            k = values.argmin(axis=0)
            better = values[k, each] < value[wide]
            at = wide[better]
            omega[at], value[at], v[at] = (part[k, each][better] for part in (points, values, turned))
            low, high = points[np.maximum(k - 1, 0), each], points[np.minimum(k + 1, 8), each]
        self._cut(omega, v)
        return float(value.min())

    def serves(self, widths: NDArray[np.float64]) -> bool:
        """Whether there are multipliers; see :meth:`multipliers`."""
        return self.multipliers(widths) is not None

    def proposals(self, widths: Sequence[Fraction], lower: Sequence[Fraction]) -> Iterator[Proposal]:
        """Multipliers that serve, rounded: over all frequencies, then with ``P`` of Riccati equations."""
        found = self.multipliers(np.array([float(w) for w in widths]))
        if found is None:
            return
        if not self.discrete and len(widths) <= MOST_CHANNELS and len(self.A) <= MOST_STATES:
            weights, theta = self._exact(found, 15)
            stated = {"lambda": [str(v / w) for v, w in zip(weights, widths, strict=True)]}
            yield Proposal(stated | self.popovs(theta), {"method": "determinant"})
        weights, theta = self._exact(found, 12)
        scaled = [v / w for v, w in zip(weights, widths, strict=True)]  # for psi (w sigma - psi)
        plain, ends = (np.diag([float(v) for v in side]) for side in (weights, scaled))
        multiplier, Pi = (
            {"lambda": [*map(str, scaled)]} | self.popovs(theta),
            np.block([[0 * plain, plain], [plain, -2 * ends]]),
        )
        if self.modes is None:
            for proof in self.solutions(Pi, theta, lower):
                yield Proposal(multiplier, proof)
            return
        for Q in self.matrices(Pi, theta):
            factor, proof = whole(self.modes, self.integers(Q), weights, theta, lower)
            stated = {"lambda": [str(factor * v) for v in scaled]}
            yield Proposal(stated | self.popovs([factor * v for v in theta]), proof)

    def _exact(self, found: Multipliers, digits: int) -> tuple[list[Fraction], list[Fraction]]:
        """``lambda`` and ``theta`` with so many digits; in the ratios that a residue demands."""
        weights, theta = ([Fraction(f"{v:.{digits}g}") for v in side] for side in (found.weights, found.theta))
        return weights if self.modes is None else self.modes.weights(weights), theta
