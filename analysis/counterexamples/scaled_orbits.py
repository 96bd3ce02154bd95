"""Solutions of discrete-time loops that repeat on another scale: how slowly a nonlinearity of a class may let decay.

``w[t + q] = s w[t]`` and ``sigma`` likewise, with a ``phi`` for which ``phi(s sigma) = s phi(sigma)``: for one order of
the points of a period, and of their multiples by powers of ``s``, the bounds of the slopes are linear in ``w``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

from flint import fmpq, fmpq_mat

from lure.analysis.deadline import checkpoint
from lure.analysis.numerics.polynomial import to_fmpq, to_fraction
from lure.arrays import NDArray, Reals, np, optimize
from lure.plants.multivariable import MultivariablePlant
from lure.plants.rational import RationalPlant
from lure.record import described, quantity

PERIODS = (4, 5, 6, 7, 8, 9, 10, 12, 14, 16, 20, 24, 28)
_PHASES, _ORDERS, _HALVINGS = 8, 5, 9
_SURE, _BETTER = 1e-9, 1e-4  # of the inequalities; relative to what is known
_BITS, _SHORT = 40, 10**6  # of the inputs, and denominators of scales and rates


@dataclass(frozen=True, slots=True)
class Slow:
    """A solution in floating point: ``q`` samples after which it is ``scale`` times as large, its inputs ``w``."""

    rate: float
    scale: float
    w: Reals


@dataclass(frozen=True, slots=True)
class ExactOrbit:
    """A solution in rational numbers, ``u = -w`` and ``sigma`` of its samples, that falls no faster than ``rate^t``."""

    rate: Fraction
    scale: Fraction
    u: Sequence[Fraction]
    sigma: Sequence[Fraction]


@described()
class ScaledOrbits:
    """The search for one plant, strictly proper and in discrete time, and one class of slopes."""

    plant: RationalPlant = quantity("The plant")
    low: Fraction = quantity("Lower bound of the slope")
    high: Fraction = quantity("Upper bound of the slope")
    odd: bool = quantity("Whether ``phi`` has to be odd")

    def __post_init__(self) -> None:
        self.sides = [np.asarray(side) for side in MultivariablePlant.of_one_channel(self.plant).doubles()]

    def better(self, known: float, most: float) -> Iterator[ExactOrbit]:
        """Solutions that fall more slowly than at a rate, each more slowly than the last.

        ``known``, ``most``: the rate that is known, and one that no solution exceeds.
        """
        for q in PERIODS:
            for turn in (-1, 1):
                for start in self._starts(q, turn):
                    checkpoint()
                    found = self._at(start, turn * (known * (1 + _BETTER)) ** q)
                    if found is None:
                        continue
                    found = self._pushed(found, most)
                    shown = self._exactly(found)
                    if shown is not None and float(shown.rate) > known:
                        known = float(shown.rate)
                        yield shown

    def _starts(self, q: int, turn: int) -> Iterator[Reals]:
        """Sinusoids, to be damped."""
        for turns in np.arange(q // 2 + 1) + (0.5 if turn < 0 else 0.0):
            for phase in 2 * np.pi * np.arange(_PHASES) / _PHASES + 0.1:
                yield np.cos(2 * np.pi * turns * np.arange(q) / q + phase)

    def _at(self, start: Reals, scale: float) -> Slow | None:
        """A solution of this scale, for the order of the start or of what comes nearest to one."""
        q, S = len(start), self._response(len(start), scale)
        if S is None:
            return None
        rate = abs(scale) ** (1 / q)
        sigma = S @ (start * rate ** np.arange(q))
        for _ in range(_ORDERS):
            rows = self._rows(S, sigma, scale)
            if rows is None:
                return None
            total = rows.sum(axis=0)
            found = optimize.linprog(
                np.append(np.zeros(q), -1.0),
                A_ub=np.column_stack([-rows, np.ones(len(rows))]),
                b_ub=np.zeros(len(rows)),
                A_eq=np.append(total, 0.0)[None],
                b_eq=[1.0],
                bounds=[(None, None)] * q + [(None, 1.0)],
                method="highs",
            )
            if found.status != 0:
                return None
            w = found.x[:q]
            if found.x[-1] > _SURE:
                return Slow(rate, scale, w)
            if np.allclose(S @ w, sigma):
                return None
            sigma = S @ w
        return None

    def _pushed(self, found: Slow, most: float) -> Slow:
        """The same order at larger rates, by halving."""
        q, low, high, turn = len(found.w), found.rate, most, math.copysign(1.0, found.scale)
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            other = self._at(found.w / found.rate ** np.arange(q), turn * middle**q)
            if other is None:
                high = middle
            else:
                low, found = middle, other
        return found

    def _response(self, q: int, scale: float) -> NDArray[np.float64] | None:
        """``sigma = S w`` where ``x[q] = scale x[0]``, ``x+ = A x - B w``; None where the scale is one of the plant."""
        A, B, C, _ = self.sides
        powers = [np.eye(len(A))]
        for _ in range(q):
            powers.append(A @ powers[-1])
        try:
            first = np.linalg.solve(
                scale * powers[0] - powers[q], np.column_stack([-powers[q - 1 - j] @ B for j in range(q)])
            )
        except np.linalg.LinAlgError:
            return None
        S = np.array([(C @ powers[t] @ first)[0] for t in range(q)])
        for t in range(q):
            for j in range(t):
                S[t, j] -= (C @ powers[t - 1 - j] @ B)[0, 0]
        return S if bool(np.isfinite(S).all()) else None

    def _rows(self, S: NDArray[np.float64], sigma: Reals, scale: float) -> NDArray[np.float64] | None:
        """What is to be ``>= 0``: ``dw - l dsigma`` and ``k dsigma - dw`` between neighbours, on both sides of 0."""
        if not (np.isfinite(sigma).all() and sigma.all()):
            return None
        step, q = min(abs(scale), 1 / abs(scale)), len(sigma)
        sides: dict[bool, list[tuple[float, int, float]]] = {}
        for i, value in enumerate(sigma.tolist()):
            power = step ** math.floor(math.log(abs(value)) / -math.log(step))
            side = sides.setdefault(value > 0 or self.odd or scale < 0, [])
            side.append((abs(value) * power, i, power if value > 0 else -power))
        found = list[Reals]()
        for side in map(sorted, sides.values()):
            again = side[0]
            for (_, i, a), (_, j, b) in zip(side, [*side[1:], (again[0], again[1], again[2] / step)], strict=True):
                dw, size = np.zeros(q), max(abs(a), abs(b))
                dw[j] += b / size
                dw[i] -= a / size
                ds = (b * S[j] - a * S[i]) / size
                found += [dw - float(self.low) * ds, float(self.high) * ds - dw]
        return np.array(found)

    def _exactly(self, found: Slow) -> ExactOrbit | None:
        """The same in rational numbers; None where the scale is one of the plant."""
        q, plant = len(found.w), MultivariablePlant.of_one_channel(self.plant)
        scale = Fraction(found.scale).limit_denominator(_SHORT)
        A, B, C = (fmpq_mat([[to_fmpq(v) for v in row] for row in side]) for side in (plant.A, plant.B, plant.C))
        top = float(np.abs(found.w).max())
        w = [fmpq(round(value / top * 2**_BITS), 2**_BITS) for value in found.w.tolist()]
        n = A.nrows()
        one = fmpq_mat([[int(i == j) for j in range(n)] for i in range(n)])
        reached, power = fmpq_mat(n, 1), one
        for value in w:
            reached, power = A * reached - B * value, A * power
        whole = one * to_fmpq(scale) - power
        if whole.det() == 0:
            return None
        x, sigma = whole.solve(reached), list[Fraction]()
        for value in w:
            sigma.append(to_fraction((C * x)[0, 0]))
            x = A * x - B * value
        rate = Fraction(abs(float(scale)) ** (1 / q) * (1 - 1e-9)).limit_denominator(_SHORT)
        while rate**q > abs(scale):
            rate -= Fraction(1, 10**9)
        return ExactOrbit(rate, scale, [-to_fraction(value) for value in w], sigma)
