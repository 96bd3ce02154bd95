"""Search for multipliers of Zames and Falb by linear programming: floating point, proposes and proves nothing."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from analysis.criteria.kernel_grid import Floats, around, increasing, peaks, short
from analysis.criteria.kernels import Delay, Gamma, Kernel, Multiplier
from analysis.deadline import checkpoint

Family = Literal["none", "gamma", "delays", "both"]
Column = tuple[int, Kernel]
TOLERANCE = 1e-7
COEFFICIENT_BITS = 40
HORIZON = 40.0
NEW_COLUMNS = 10
PRICE = 1e-8


@dataclass(frozen=True, kw_only=True, slots=True)
class Proposal:
    """A multiplier, and the least value found of its inequality relative to ``|H + 1/k|``."""

    multiplier: Multiplier
    least: float
    where: float


@dataclass(slots=True)
class Search:
    r"""Rows (frequencies) and columns (kernels) of the linear programme, kept from one ``k`` to the next.

    For given ``k`` it maximises ``t`` subject to
    ``Re[(1 - sum c_j h_j^)(H + 1/k)] + theta Re(i w H) >= t |H + 1/k|`` on the rows, with ``sum |c_j| <= 1``.
    Delays are the extreme points of the whole class; those that help are found by pricing on a fine grid.  Beyond
    ``far`` [rad/s] their phases count as the worst ones.

    Parameters
    ----------
    numerator, denominator : ndarray
        Coefficients of ``H`` in descending powers.
    odd : bool
        Whether coefficients may be negative.
    family : {"none", "gamma", "delays", "both"}
        Kernels to use; ``none`` leaves Popov's multiplier.
    full : bool
        Whether to add rows and columns for longer.
    """

    numerator: Floats
    denominator: Floats
    odd: bool
    family: Family
    full: bool = False
    poles: NDArray[np.complex128] = field(init=False)
    unit: float = field(init=False)
    low: float = field(init=False)
    far: float = field(init=False)
    rows: Floats = field(init=False)
    columns: list[Column] = field(init=False)
    lags: Floats = field(init=False)

    def __post_init__(self) -> None:
        self.poles = np.roots(self.denominator).astype(complex)
        sizes = np.abs(self.poles)
        zeros = np.abs(np.roots(self.numerator))
        self.unit = float(np.exp(np.mean(np.log(sizes))))
        self.low, high = float(sizes.min()), float(max([*sizes, *zeros[zeros < 1e3 * sizes.max()]]))
        self.far = 10 * high
        self.rows = increasing(
            [0.0],
            np.geomspace(self.low / 100, high * 100, 80),
            np.linspace(0, 3 * high, 60),
            around(self.poles, 10),
        )
        self.lags = np.concatenate([np.geomspace(1e-2, 1, 200), np.linspace(1, HORIZON, 3000)[1:]]) / self.unit
        self.columns = self._first_columns()

    def response(self, omega: Floats) -> NDArray[np.complex128]:
        """``H(i w)``."""
        s = 1j * omega
        return np.asarray(np.polyval(self.numerator, s) / np.polyval(self.denominator, s))

    def propose(self, k: float) -> Proposal | None:
        """The best multiplier found for slopes in ``[0, k]``; None if there is none on the rows."""
        fine = self._fine(k)
        best: Proposal | None = None
        rows = increasing(self.rows, around(self._closed_loop(k), 6))
        for _ in range(30 if self.full else 8):
            solved = self._solve(k, rows)
            if solved is None:
                return best
            t, multiplier, prices = solved
            new = self._priced(*prices)
            if t <= TOLERANCE and not new:
                return best
            least, dips = self._dips(multiplier, k, fine, t)
            if best is None or least.least > best.least:
                best = least
            if best.least > 0.5 * t > TOLERANCE and not (new and best.least < TOLERANCE * 100):
                return best
            if not new and dips.size == 0:
                return best
            rows = increasing(rows, dips)
            self.rows = increasing(self.rows, dips)
            self.columns += new
        return best

    def largest(self, multiplier: Multiplier, k: float) -> float:
        """Largest slope at least ``k`` for which this multiplier works on the fine grid."""
        omega = self._fine(k)
        H = self.response(omega)
        fixed, gain = self._split(multiplier, omega, H)
        with np.errstate(divide="ignore", invalid="ignore"):
            needed = np.where(gain > 0, -fixed / gain, math.inf)
        worst = float(np.nanmax(needed))
        return k if not worst > 0 else max(k, 1 / worst) if worst < 1 / k else k

    def least(self, multiplier: Multiplier, k: float) -> float:
        """Frequency of the fine grid at which the left-hand side itself is least."""
        omega = self._fine(k)
        fixed, gain = self._split(multiplier, omega, self.response(omega))
        return float(omega[np.argmin(fixed + gain / k)])

    def add_row(self, omega: float) -> None:
        """Add a frequency at which a proof failed, with neighbours."""
        self.rows = increasing(self.rows, omega * (1 + np.array([-1e-4, 0.0, 1e-4])))

    def _first_columns(self) -> list[Column]:
        signs = (1, -1) if self.odd else (1,)
        kernels: list[Kernel] = []
        if self.family in ("delays", "both"):
            for lag in np.geomspace(0.05, HORIZON, 8) / self.unit:
                kernels += [Delay(short(lag)), Delay(-short(lag))]
        if self.family in ("gamma", "both"):
            for rate in np.geomspace(1e-2, 1e2, 13) * self.unit:
                for order in (1, 2, 3, 5):
                    kernels += [Gamma(short(rate), order, "causal"), Gamma(short(rate), order, "anticausal")]
        return [(sign, kernel) for kernel in kernels for sign in signs]

    def _closed_loop(self, k: float) -> NDArray[np.complex128]:
        return np.asarray(np.roots(np.polyadd(self.denominator, k * self.numerator)))

    def _fine(self, k: float) -> Floats:
        return increasing(
            np.geomspace(self.low / 1e3, self.far * 1e3, 3000),
            np.linspace(0, self.far / 2, 4000),
            around(self.poles, 100),
            around(self._closed_loop(k), 100),
        )

    def _solve(
        self, k: float, rows: Floats
    ) -> tuple[float, Multiplier, tuple[Floats, NDArray[np.complex128], float]] | None:
        from scipy.optimize import linprog

        checkpoint()
        H = self.response(rows)
        F = H + 1 / k
        scale = np.abs(F)
        near = rows <= self.far
        left = np.empty((rows.size, len(self.columns)))
        for j, (sign, kernel) in enumerate(self.columns):
            left[:, j] = sign * (kernel.at(rows) * F).real
            if isinstance(kernel, Delay):
                left[~near, j] = scale[~near]
        popov = (1j * rows * H).real * self._theta_unit
        A = np.column_stack([left / scale[:, None], -popov / scale, np.ones(rows.size)])
        mass = np.append(np.ones(len(self.columns)), [0.0, 0.0])
        result = linprog(
            np.append(np.zeros(len(self.columns) + 1), -1.0),
            A_ub=np.vstack([A, self._at_infinity(k), mass]),
            b_ub=np.append(F.real / scale, [1.0, 1.0]),
            bounds=[(0, None)] * len(self.columns) + [(None, None), (None, 1)],
            method="highs",
        )
        if result.status != 0:
            return None
        duals = -np.asarray(result.ineqlin.marginals)
        weights = np.where(near, duals[: rows.size] / scale, 0)
        held = weights > 0
        far = float(duals[: rows.size][~near].sum() + duals[-2] + duals[-1])
        return float(result.x[-1]), self._rounded(result.x), (rows[held], weights[held] * F[held], far)

    @property
    def _theta_unit(self) -> float:
        return 1 / self.unit

    def _at_infinity(self, k: float) -> Floats:
        """The inequality in the limit, relative to ``1/k + D``: delays at their worst phase, gamma kernels gone."""
        degree = len(self.denominator) - 1
        top = np.concatenate([np.zeros(degree + 1 - len(self.numerator)), self.numerator])
        D = top[0] / self.denominator[0]
        slope = (top[1] - D * self.denominator[1]) / self.denominator[0] if degree else 0.0
        masses = [1.0 if isinstance(kernel, Delay) else 0.0 for _, kernel in self.columns]
        return np.array([*masses, -slope * self._theta_unit / (1 / k + D), 1.0])

    def _rounded(self, x: Floats) -> Multiplier:
        whole = 2**COEFFICIENT_BITS
        terms = []
        for value, (sign, kernel) in zip(x, self.columns, strict=False):
            c = Fraction(int(value * whole), whole)
            if value > 1e-10 and c > 0:
                terms.append((sign * c, kernel))
        mass = sum((abs(c) for c, _ in terms), Fraction(0))
        if mass > 1:
            terms = [(Fraction(int(c / mass * whole), whole), kernel) for c, kernel in terms]
        theta = float(x[len(self.columns)]) * self._theta_unit
        return Multiplier(Fraction(theta).limit_denominator(10**12) if theta else Fraction(0), tuple(terms))

    def _priced(self, omega: Floats, prices: NDArray[np.complex128], far: float) -> list[Column]:
        """Delays whose price says that they help."""
        if self.family in ("none", "gamma"):
            return []
        known = set(self.columns)
        found: list[tuple[float, Column]] = []
        for direction in (1, -1):
            for sign in (1, -1) if self.odd else (1,):

                def gain(lags: Floats, direction: int = direction, sign: int = sign) -> Floats:
                    """What a delay would earn at the prices of the frequencies."""
                    waves = np.exp(-1j * direction * np.outer(lags, omega))
                    return np.asarray(-sign * (waves @ prices).real - far)

                for value, lag in peaks(gain, self.lags, least=PRICE, count=NEW_COLUMNS):
                    column = (sign, Delay(direction * short(lag)))
                    if value > PRICE and column not in known:
                        found.append((value, column))
        found.sort(key=lambda pair: -pair[0])
        return [column for _, column in found[:NEW_COLUMNS]]

    def _split(self, multiplier: Multiplier, omega: Floats, H: NDArray[np.complex128]) -> tuple[Floats, Floats]:
        """``Re(M H) + theta Re(i w H)`` and ``Re M``."""
        M = multiplier.at(omega)
        return (M * H).real + float(multiplier.theta) * (1j * omega * H).real, M.real

    def _dips(self, multiplier: Multiplier, k: float, fine: Floats, t: float) -> tuple[Proposal, Floats]:
        H = self.response(fine)
        fixed, gain = self._split(multiplier, fine, H)
        values = (fixed + gain / k) / np.abs(H + 1 / k)
        i = int(np.argmin(values))
        low = np.flatnonzero(
            (values[1:-1] < values[:-2]) & (values[1:-1] <= values[2:]) & (values[1:-1] < t - 1e-3 * abs(t) - TOLERANCE)
        )
        worst = low[np.argsort(values[low + 1])][:40] + 1
        return Proposal(multiplier=multiplier, least=float(values[i]), where=float(fine[i])), fine[worst]
