r"""The frequency inequality of several channels, in floating point: multipliers by cutting planes, ``P`` by Riccati.

After the shift by the lower bounds ``psi_i`` lies in ``[0, w_i]``; the diagonal multipliers ``lambda, theta`` serve if

.. math:: F(\omega) = \Lambda W^{-1} + \mathrm{He}\, (\Lambda + i \omega \Theta) H(i \omega) > 0

(``He M = (M + M^*)/2``) at every frequency, infinity included; in discrete time at ``z = e^{i omega}``, ``Theta = 0``.
It is linear in them: the multipliers solve a linear programme over ``v^* F(omega) v >= t |v|^2``, to which the worst
frequencies are added.  Nothing here is believed: a checker decides with rational ``P``, ``lambda`` and ``theta``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import NamedTuple

from lure.analysis.deadline import checkpoint
from lure.arrays import NDArray, linalg, np, optimize
from lure.errors import AssumptionError

_ROUNDS, _GRID, _DECADES, _ZOOMS = 60, 100, 4, 6
_SLACKS = (0.5, 0.2, 1e-1, 1e-2, 1e-3, 1e-4)
_SURE = 1e-10  # of the largest: below it a margin is rounding
_BITS = 56  # of the smallest entry on the diagonal of P
_LARGEST_THETA = 1e5


class Multipliers(NamedTuple):
    """``lambda`` for ``psi (sigma - psi/w)`` and ``theta``, with the least ``v^* F v / |v|^2`` that they reach."""

    weights: NDArray[np.float64]
    theta: NDArray[np.float64]
    margin: float


class Proposal(NamedTuple):
    """What a certificate holds: ``P`` in units of ``2^-exponent``, the lower triangle, and the multipliers."""

    rows: list[list[int]]
    exponent: int
    weights: list[Fraction]
    theta: list[Fraction]


def _between(core: Multipliers, far: Multipliers) -> Multipliers:
    """Half way from multipliers that nearly serve to those of the linear programme: fewer rounds than its corners."""
    weights, theta = ((a + b) / 2 for a, b in zip(core[:2], far[:2], strict=True))
    return Multipliers(weights, theta, far.margin)


@dataclass
class ChannelInequality:
    """The inequality of one plant and lower bounds, for any widths ``w``; cuts are kept from one to the next.

    Parameters
    ----------
    A, B, C, D : ndarray
        (n, n), (n, m), (m, n) and (m, m) [floating point].
    lower : ndarray
        (m,) lower bounds.
    free : sequence of bool
        Which ``theta`` may differ from 0.
    discrete : bool
        Whether in discrete time.

    Raises
    ------
    AssumptionError
        The loop with the gains ``lower`` is not well posed, or not asymptotically stable.
    """

    A: NDArray[np.float64]
    B: NDArray[np.float64]
    C: NDArray[np.float64]
    D: NDArray[np.float64]
    lower: NDArray[np.float64]
    free: Sequence[bool]
    discrete: bool
    cuts: list[tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]] = field(default_factory=list)

    def __post_init__(self) -> None:
        m, gain = len(self.D), np.diag(self.lower)
        self.own = self.C
        whole = np.eye(m) + self.D @ gain
        if abs(np.linalg.det(whole)) < 1e-12:
            raise AssumptionError("the loop is not well posed with the gains at the lower bounds")
        inverse = np.linalg.inv(whole)
        self.C, self.D = inverse @ self.C, inverse @ self.D
        self.A, self.B = self.A - self.B @ gain @ self.C, self.B @ (np.eye(m) - gain @ self.D)
        balanced, (self.units, _) = linalg.matrix_balance(self.A, permute=False, separate=True)
        self.A, self.B = np.asarray(balanced), self.B / self.units[:, None]
        self.C, self.own = self.C * self.units, self.own * self.units
        poles = np.linalg.eigvals(self.A).astype(complex)
        inside = np.abs(poles).max() < 1 if self.discrete else poles.real.max() < 0
        if not inside:
            raise AssumptionError("the loop with the gains at the lower bounds is not asymptotically stable")
        self.omega = self._frequencies(poles)
        self.states, self.H = self._response(self.omega)
        self.unit = float(np.abs(poles).min() or 1.0) ** -1 if not self.discrete else 1.0

    def _frequencies(self, poles: NDArray[np.complex128]) -> NDArray[np.float64]:
        if self.discrete:
            near = np.abs(np.angle(poles))
            return np.unique(np.concatenate([np.linspace(0, np.pi, 2 * _GRID), near]))
        size = np.abs(poles)
        low, high = size.min() / 10**_DECADES, size.max() * 10**_DECADES
        around = [np.abs(p.imag) + abs(p.real) * np.linspace(-3, 3, 13) for p in poles]
        points = np.concatenate([[0.0], np.geomspace(low, high, 3 * _GRID), *around])
        return np.append(np.unique(points[points >= 0]), np.inf)

    def _response(self, omega: NDArray[np.float64]) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """``(i omega - A)^-1 B`` and ``H``; at infinity 0 and ``D``."""
        points = np.exp(1j * omega) if self.discrete else 1j * np.where(np.isinf(omega), 0, omega)
        states = np.linalg.solve(points[:, None, None] * np.eye(len(self.A)) - self.A, self.B.astype(complex))
        states[np.isinf(omega)] = 0
        return np.asarray(states, dtype=complex), np.asarray(self.C @ states + self.D, dtype=complex)

    def _turned(
        self, omega: NDArray[np.float64], states: NDArray[np.complex128], H: NDArray[np.complex128]
    ) -> NDArray[np.complex128]:
        """``i omega H`` in the rows where it is used; at infinity ``C B``."""
        rate = self.own @ (self.A @ states + self.B)  # sigma' of a function of the state: C (A x + B mu)
        return np.asarray(np.where(np.asarray(self.free)[None, :, None], rate, 0))

    def values(
        self, found: Multipliers, widths: NDArray[np.float64], omega: NDArray[np.float64] | None = None
    ) -> NDArray[np.complex128]:
        """``F`` at the frequencies of the grid, or at given ones."""
        if omega is None:
            omega, states, H = self.omega, self.states, self.H
        else:
            states, H = self._response(omega)
        inner = found.weights[:, None] * H + found.theta[:, None] * self._turned(omega, states, H)
        inner = inner + np.diag(found.weights / widths)
        return np.asarray((inner + inner.conj().swapaxes(1, 2)) / 2)

    def _cut(self, omega: float, v: NDArray[np.complex128]) -> None:
        states, H = self._response(np.array([omega]))
        turned = self._turned(np.array([omega]), states, H)
        row = [np.abs(v) ** 2, (v.conj() * (H[0] @ v)).real, (v.conj() * (turned[0] @ v)).real * self.unit]
        self.cuts.append((row[0], row[1], row[2]))

    def multipliers(self, widths: NDArray[np.float64]) -> Multipliers | None:
        """Multipliers that serve on the grid and between its points, None if there are none.

        Parameters
        ----------
        widths : ndarray
            (m,) of the shifted sectors.
        """
        if not self.cuts:
            for j in range(len(widths)):
                for omega in (0.0, self.omega[len(self.omega) // 2], self.omega[-1]):
                    self._cut(float(omega), np.eye(len(widths))[j].astype(complex))
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
        squares, plain, turned = (np.array([cut[k] for cut in self.cuts]) for k in range(3))
        # variables: a_i = lambda_i/w_i, theta_i/unit, t
        rows = np.hstack([-(squares + plain * widths), -turned, squares.sum(axis=1)[:, None]])
        most = [_LARGEST_THETA if free else 0.0 for free in self.free]
        bounds = [(0, None)] * m + [(-top, top) for top in most] + [(None, None)]
        total = np.concatenate([np.ones(m), np.zeros(m + 1)])[None]
        cost = np.concatenate([np.zeros(2 * m), [-1.0]])
        scale = np.abs(rows).max(axis=1, keepdims=True)
        solved = optimize.linprog(
            cost, A_ub=rows / scale, b_ub=np.zeros(len(rows)), A_eq=total, b_eq=[1.0], bounds=bounds, method="highs"
        )
        if solved.status != 0:
            return None
        return Multipliers(solved.x[:m] * widths, solved.x[m : 2 * m] * self.unit, float(solved.x[-1]))

    def _worst(self, found: Multipliers, widths: NDArray[np.float64]) -> float:
        """The least eigenvalue over the frequencies; cuts at its local minima."""
        least, vectors = np.linalg.eigh(self.values(found, widths))
        least = least[:, 0]
        padded = np.concatenate([[np.inf], least, [np.inf]])
        local = np.flatnonzero((least <= padded[:-2]) & (least <= padded[2:]))
        worst = float(least.min())
        for i in local[np.argsort(least[local])][:8]:
            omega, value, v = self.omega[i], least[i], vectors[i][:, 0]
            low, high = self.omega[max(i - 1, 0)], self.omega[min(i + 1, len(self.omega) - 1)]
            for _ in range(_ZOOMS if np.isfinite(high) and low < high else 0):
                points = np.linspace(low, high, 9)
                values, turned = np.linalg.eigh(self.values(found, widths, points))
                k = int(values[:, 0].argmin())
                if values[k, 0] < value:
                    omega, value, v = points[k], values[k, 0], turned[k][:, 0]
                low, high = points[max(k - 1, 0)], points[min(k + 1, 8)]
            worst = min(worst, value)
            self._cut(float(omega), v)
        return worst

    def proposals(self, found: Multipliers, widths: Sequence[Fraction], lower: Sequence[Fraction]) -> list[Proposal]:
        """``P`` of Riccati equations with more and less slack, in integers, for the loop as it was given.

        Parameters
        ----------
        found : Multipliers
            Multipliers that serve.
        widths, lower : sequence of Fraction
            The shifted sectors, and the shift.
        """
        w = np.array([float(v) for v in widths])
        weights, theta = ([Fraction(f"{v:.12g}") for v in side] for side in (found.weights, found.theta))
        near = [np.array([float(v) for v in side]) for side in (weights, theta)]
        rounded = Multipliers(near[0], near[1], found.margin)
        F = np.linalg.eigvalsh(self.values(rounded, w))[:, 0]
        size = np.linalg.norm(self.states, 2, axis=(1, 2)) ** 2
        with np.errstate(divide="ignore"):
            room = float(np.min(np.where(size > 0, 2 * F / size, np.inf)))
        turn = np.diag(rounded.theta) @ self.own
        N = self.C.T @ np.diag(rounded.weights) + (0 if self.discrete else self.A.T @ turn.T)
        R = np.diag(2 * rounded.weights / w) + rounded.weights[:, None] * self.D
        R = R + self.D.T * rounded.weights[None]
        R = R if self.discrete else R + turn @ self.B + (turn @ self.B).T
        made = []
        for share in _SLACKS if room > 0 else ():
            checkpoint()
            P = self._riccati(share * room, N, R)
            if P is not None:
                low = np.diag([float(v) for v in lower]) * rounded.theta[:, None]
                made.append(self._rounded(P - self.own.T @ low @ self.own, weights, theta, widths))
        return made

    def _riccati(self, slack: float, N: NDArray[np.float64], R: NDArray[np.float64]) -> NDArray[np.float64] | None:
        solve = linalg.solve_discrete_are if self.discrete else linalg.solve_continuous_are
        try:
            with np.errstate(all="ignore"):
                P = solve(self.A, self.B, slack * np.eye(len(self.A)), -(R + R.T) / 2, s=-N)
        except (np.linalg.LinAlgError, ValueError):
            return None
        return (P + P.T) / 2 if np.isfinite(P).all() else None

    def _rounded(
        self, P: NDArray[np.float64], weights: list[Fraction], theta: list[Fraction], widths: Sequence[Fraction]
    ) -> Proposal:
        P = P / self.units[:, None] / self.units[None, :]
        exponent = max(0, _BITS - int(np.floor(np.log2(max(np.abs(np.diag(P)).min(), 1e-300)))))
        rows = [[round(Fraction(float(P[i, j])) * 2**exponent) for j in range(i + 1)] for i in range(len(P))]
        scaled = [v / w for v, w in zip(weights, widths, strict=True)]  # for psi (w sigma - psi)
        return Proposal(rows, exponent, scaled, theta)
