"""Search for multipliers of Zames and Falb by linear programming: floating point, proposes and proves nothing."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Literal

from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.plant import TransferPolynomials
from lure.analysis.numerics.polynomial import to_descending
from lure.analysis.theorems.kernels import Delay, Gamma, Kernel, Multiplier
from lure.analysis.theorems.park import park_largest
from lure.analysis.theorems.popov import popov_largest
from lure.analysis.verdict import CriterionResult, Verdict
from lure.arrays import NDArray, Reals, np
from lure.plants.rational import RationalPlant
from lure.record import described, quantity

# Points in floating point: frequencies around resonances, maxima of a function of the delay.


def peaks(f: Callable[[Reals], Reals], points: Reals, *, least: float, count: int) -> list[tuple[float, float]]:
    """The highest local maxima of ``f`` and where they are: on the points, then refined between neighbours."""
    values = f(points)
    middle, left, right = values[1:-1], values[:-2], values[2:]
    rise = (2 * middle - left - right) / 4  # a parabola through the three is at most half of it higher than the middle
    high = (middle > left) & (middle >= right) & (middle + rise > least)
    inner = np.flatnonzero(high) + 1
    found = []
    for i in inner[np.argsort(-values[inner] - rise[inner - 1])][:count]:
        low, top = points[i - 1], points[i + 1]
        for _ in range(3):
            finer = np.linspace(low, top, 21)
            best = int(np.clip(np.argmax(f(finer)), 1, 19))
            low, top = finer[best - 1], finer[best + 1]
        found.append((float(f(finer[best : best + 1])[0]), float(finer[best])))
    return found


def around(roots: NDArray[np.complex128], count: int) -> Reals:
    """Frequencies around lightly damped roots, closer and closer."""
    found: list[Reals] = [np.zeros(0)]
    for root in roots:
        frequency, damping = float(root.imag), abs(float(root.real))
        if frequency > 2 * damping > 0:
            away = damping * np.geomspace(1e-2, frequency / damping, count)
            found += [frequency + away, frequency - away[:-1], np.array([frequency])]
    return np.concatenate(found)


def increasing(*parts: Sequence[float] | Reals) -> Reals:
    """All finite frequencies of several arrays that are not negative, in ascending order, each once."""
    omega = np.unique(np.concatenate([np.asarray(part, dtype=float) for part in parts]))
    return np.asarray(omega[np.isfinite(omega) & (omega >= 0)])


def short(value: float) -> Fraction:
    """A number of eight decimal digits, exactly."""
    return Fraction(f"{float(value):.8g}")


# A plant in units in which its poles and its peak are near 1, for the search in doubles.


@dataclass(frozen=True, slots=True)
class Scaled:
    """``H(unit s) / gain`` in doubles, of size about 1, and the way back; both factors are powers of two."""

    numerator: Reals
    denominator: Reals
    unit: Fraction
    gain: Fraction

    @classmethod
    def of(cls, plant: TransferPolynomials) -> Scaled:
        """The plant with the geometric mean of its poles and the peak of ``|H|`` near 1."""
        n, d = to_descending(plant.n), to_descending(plant.d)
        order, drifts = len(d) - 1, d[-1] == 0
        unit = _power_of_two(_log2(abs(d[-1 - drifts] / d[0])) / max(order - drifts, 1))
        top = [c * unit**i for c, i in zip(n, range(len(n) - 1, -1, -1), strict=True)]
        bottom = [c * unit**i for c, i in zip(d, range(order, -1, -1), strict=True)]
        lead = _power_of_two(max(_log2(abs(c)) for c in bottom if c))
        size = _power_of_two(max(_log2(abs(c)) for c in top if c))
        numerator = np.array([float(c / size) for c in top])
        denominator = np.array([float(c / lead) for c in bottom])
        probe = Search(numerator, denominator, odd=False, family="none")
        peak = _power_of_two(math.log2(float(np.max(probe.size(probe.rows, probe.response(probe.rows))))))
        return cls(numerator / float(peak), denominator, unit, peak * size / lead)

    def search(self, family: Family, *, odd: bool = False, full: bool = False) -> Search:
        """A search for this plant."""
        return Search(self.numerator, self.denominator, odd=odd, family=family, full=full)


def _power_of_two(exponent: float) -> Fraction:
    return Fraction(2) ** round(exponent)


def _log2(value: Fraction) -> float:
    return math.log2(value.numerator) - math.log2(value.denominator)


# Popov's and Park's multipliers in the form of Zames and Falb: the search starts from them and never falls behind.

BITS = 300
DENOMINATORS = (10**3, 10**6, 10**12, 2**BITS)


def seeds(block: RationalPlant, lower: Fraction) -> Iterator[tuple[Fraction | None, Multiplier]]:
    """Slopes (None: every finite one) and multipliers that should prove them; each is to be checked.

    ``block``: in continuous time, stable with the gain ``lower`` but for a simple pole at 0.
    """
    for answer in (popov_largest(block, lower=lower), park_largest(block, lower=lower)):
        if answer.verdict is Verdict.PROVED:
            k = None if math.isinf(answer.largest.low) else Fraction(answer.largest.low)
            for multiplier in _forms(answer):
                yield k, multiplier


def _forms(answer: CriterionResult) -> Iterator[Multiplier]:
    theta, tau, ratio = (answer.parameters.get(name) for name in ("theta", "tau", "theta/tau"))
    if tau == "inf" and ratio is not None:
        yield from (first_order(None, Fraction(str(ratio)), size) for size in DENOMINATORS)
    elif theta is not None and theta not in ("inf", "-inf"):
        weight, squared = Fraction(str(theta)), Fraction(str(tau or 0))
        if squared == 0:
            yield Multiplier(weight, ())
        else:
            yield from (first_order(1 / squared, weight / squared, size) for size in DENOMINATORS)


def first_order(product: Fraction | None, difference: Fraction, size: int) -> Multiplier:
    r"""Park's multiplier ``1 + theta s - tau s^2 = tau (a - s)(b + s)`` as ``1 - c h^`` with an exponential ``h``.

    On the axis it is a positive multiple of ``(b + s)/(a + s) = 1 - ((a - b)/a) a/(a + s)``, used if ``b <= a``, and of
    ``(a - s)/(b - s) = 1 - ((b - a)/b) b/(b - s)``, used if ``a < b``.

    Parameters
    ----------
    product : Fraction or None
        ``a b = 1/tau`` [1/s^2]; None for ``tau = inf``, where it is 0.
    difference : Fraction
        ``a - b = theta/tau`` [1/s].
    size : int
        Denominators of the rounded ``a`` and ``b``, relative to their size.
    """
    if difference == 0:
        return Multiplier(Fraction(0), ())
    larger = (abs(difference) + _root(difference**2 + 4 * (product or 0))) / 2
    smaller = larger - abs(difference)
    rate = _rounded(larger, size)
    share = 1 - _rounded(smaller / larger, size) if product else Fraction(1)
    return Multiplier(Fraction(0), ((share, Gamma(rate, 1, "causal" if difference > 0 else "anticausal")),))


def _root(value: Fraction) -> Fraction:
    shift = 2 * BITS + value.denominator.bit_length()
    return Fraction(math.isqrt(value.numerator * 4**shift // value.denominator), 2**shift)


def _rounded(value: Fraction, size: int) -> Fraction:
    scale = Fraction(2) ** (value.numerator.bit_length() - value.denominator.bit_length())
    return (value / scale).limit_denominator(size) * scale


Family = Literal["none", "gamma", "delays", "both"]
Column = tuple[int, Kernel]
TOLERANCE = 1e-7
COEFFICIENT_BITS = 40
HORIZON = 40.0
NEW_COLUMNS = 10
PRICE = 1e-8
NEAR_ZERO = 1e-5  # of the slowest pole, in place of 0 where there is a pole at 0


@dataclass(frozen=True, kw_only=True, slots=True)
class Proposal:
    """A multiplier, and the least value found of its inequality relative to ``|H + 1/k|``."""

    multiplier: Multiplier
    least: float
    where: float


@described(slots=True)
class Search:
    r"""Rows (frequencies) and columns (kernels) of the linear programme, kept from one ``k`` to the next.

    For given ``k`` it maximises ``t`` subject to
    ``Re[(1 - sum c_j h_j^)(H + 1/k)] + theta Re(i w H) >= t |H + 1/k|`` on the rows, with ``sum |c_j| <= 1``.
    Delays are the extreme points of the whole class; those that help are found by pricing on a fine grid.  Beyond
    ``far`` [rad/s] their phases count as the worst ones.
    """

    numerator: Reals = quantity("Coefficients of the numerator of ``H`` in descending powers")
    denominator: Reals = quantity("Those of its denominator")
    odd: bool = quantity("Whether coefficients may be negative")
    family: Family = quantity("Kernels to use; ``none`` leaves Popov's multiplier")
    full: bool = quantity("Whether to add rows and columns for longer", default=False)
    poles: NDArray[np.complex128] = field(init=False)
    unit: float = field(init=False)
    low: float = field(init=False)
    far: float = field(init=False)
    drift: float = field(init=False)
    rows: Reals = field(init=False)
    columns: list[Column] = field(init=False)
    lags: Reals = field(init=False)

    def __post_init__(self) -> None:
        poles = np.roots(self.denominator).astype(complex)
        self.poles = poles[poles != 0]
        sizes = np.abs(self.poles) if self.poles.size else np.ones(1)
        zeros = np.abs(np.roots(self.numerator))
        self.unit = float(np.exp(np.mean(np.log(sizes))))
        self.low, high = float(sizes.min()), float(max([*sizes, *zeros[zeros < 1e3 * sizes.max()]]))
        self.far = 10 * high
        self.drift = self.low if self.denominator[-1] == 0 else 0.0
        self.rows = increasing(
            [self.drift * NEAR_ZERO],
            np.geomspace(self.low / 100, high * 100, 80),
            np.linspace(0, 3 * high, 60)[1:],
            around(self.poles, 10),
        )
        self.lags = np.concatenate([np.geomspace(1e-2, 1, 200), np.linspace(1, HORIZON, 3000)[1:]]) / self.unit
        self.columns = self._first_columns()

    def size(self, omega: Reals, values: NDArray[np.complex128]) -> Reals:
        """What the left-hand side is compared with: ``|H + 1/k|``, without its growth at a pole at 0."""
        return np.asarray(np.abs(values) * (omega / (omega + self.drift) if self.drift else 1.0))

    def response(self, omega: Reals) -> NDArray[np.complex128]:
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

    def _fine(self, k: float) -> Reals:
        return increasing(
            [self.drift * NEAR_ZERO],
            np.geomspace(self.low / 1e3, self.far * 1e3, 3000),
            np.linspace(0, self.far / 2, 4000)[1:],
            around(self.poles, 100),
            around(self._closed_loop(k), 100),
        )

    def _solve(
        self, k: float, rows: Reals
    ) -> tuple[float, Multiplier, tuple[Reals, NDArray[np.complex128], float]] | None:
        from scipy.optimize import linprog

        checkpoint()
        H = self.response(rows)
        F = H + 1 / k
        scale = self.size(rows, F)
        near = rows <= self.far
        left = np.empty((rows.size, len(self.columns)))
        for j, (sign, kernel) in enumerate(self.columns):
            left[:, j] = sign * (kernel.at(rows) * F).real
            if isinstance(kernel, Delay):
                left[~near, j] = scale[~near]
        popov = (1j * rows * H).real * self._theta_unit
        A = np.column_stack([left / scale[:, None], -popov / scale, np.ones(rows.size)])
        ends, mass = np.atleast_2d(self._at_infinity(k)), np.append(np.ones(len(self.columns)), [0.0, 0.0])
        result = linprog(
            np.append(np.zeros(len(self.columns) + 1), -1.0),
            A_ub=np.vstack([A, ends, mass]),
            b_ub=np.append(F.real / scale, np.ones(len(ends) + 1)),
            bounds=[(0, None)] * len(self.columns) + [(None, None), (None, 1)],
            method="highs",
        )
        if result.status != 0:
            return None
        duals = -np.asarray(result.ineqlin.marginals)
        weights = np.where(near, duals[: rows.size] / scale, 0)
        held = weights > 0
        far = float(duals[: rows.size][~near].sum() + duals[rows.size :].sum())
        return float(result.x[-1]), self._rounded(result.x), (rows[held], weights[held] * F[held], far)

    @property
    def _theta_unit(self) -> float:
        return 1 / self.unit

    def _at_infinity(self, k: float) -> Reals:
        """The inequality in the limit, relative to ``1/k + D``: delays at their worst phase, gamma kernels gone."""
        degree = len(self.denominator) - 1
        top = np.concatenate([np.zeros(degree + 1 - len(self.numerator)), self.numerator])
        D = top[0] / self.denominator[0]
        slope = (top[1] - D * self.denominator[1]) / self.denominator[0] if degree else 0.0
        masses = [1.0 if isinstance(kernel, Delay) else 0.0 for _, kernel in self.columns]
        return np.array([*masses, -slope * self._theta_unit / (1 / k + D), 1.0])

    def _rounded(self, x: Reals) -> Multiplier:
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

    def _priced(self, omega: Reals, prices: NDArray[np.complex128], far: float) -> list[Column]:
        """Delays whose price says that they help."""
        if self.family in ("none", "gamma"):
            return []
        known = set(self.columns)
        found: list[tuple[float, Column]] = []
        for direction in (1, -1):
            for sign in (1, -1) if self.odd else (1,):

                def gain(lags: Reals, direction: int = direction, sign: int = sign) -> Reals:
                    """What a delay would earn at the prices of the frequencies."""
                    waves = np.exp(-1j * direction * np.outer(lags, omega))
                    return np.asarray(-sign * (waves @ prices).real - far)

                for value, lag in peaks(gain, self.lags, least=PRICE, count=NEW_COLUMNS):
                    column = (sign, Delay(direction * short(lag)))
                    if value > PRICE and column not in known:
                        found.append((value, column))
        found.sort(key=lambda pair: -pair[0])
        return [column for _, column in found[:NEW_COLUMNS]]

    def _split(self, multiplier: Multiplier, omega: Reals, H: NDArray[np.complex128]) -> tuple[Reals, Reals]:
        """``Re(M H) + theta Re(i w H)`` and ``Re M``."""
        M = multiplier.at(omega)
        return (M * H).real + float(multiplier.theta) * (1j * omega * H).real, M.real

    def _dips(self, multiplier: Multiplier, k: float, fine: Reals, t: float) -> tuple[Proposal, Reals]:
        H = self.response(fine)
        fixed, gain = self._split(multiplier, fine, H)
        values = (fixed + gain / k) / self.size(fine, H + 1 / k)
        i = int(np.argmin(values))
        low = np.flatnonzero(
            (values[1:-1] < values[:-2]) & (values[1:-1] <= values[2:]) & (values[1:-1] < t - 1e-3 * abs(t) - TOLERANCE)
        )
        worst = low[np.argsort(values[low + 1])][:40] + 1
        return Proposal(multiplier=multiplier, least=float(values[i]), where=float(fine[i])), fine[worst]
