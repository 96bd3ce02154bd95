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

from flint import fmpq, fmpq_mat

from lure.analysis.inequality.channels import ChannelInequality
from lure.analysis.inequality.kernels import Found
from lure.analysis.inequality.shifted_loop import Proposal
from lure.analysis.inequality.zero_modes import null_rows
from lure.arrays import NDArray, np

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
