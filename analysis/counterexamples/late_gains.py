"""Constant gains that destabilise a plant with several channels and known dead times, in floating point.

With gains ``alpha G`` the loop has a root ``i omega`` where ``1/alpha`` is an eigenvalue of ``-H G``: real eigenvalues
are looked for along the frequency, and directions ``G`` with a large one; beside poles at 0 those of ``-lim s H G``,
near which there are roots ``s > 0`` for every ``alpha``.  Nothing here is believed: a rectangle of
gains and frequencies is proposed, and checked.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import islice, product
from typing import Any, NamedTuple

from lure.analysis.deadline import checkpoint
from lure.arrays import NDArray, np, optimize

_GRID, _MOST_PATTERNS, _RANDOM, _REFINED, _STEPS = 900, 64, 16, 2, 60
_WIDTHS = (1e-9, 1e-8, 1e-7, 1e-6, 1e-5)
_LARGEST, _EXACT, _CLOSE, _REAL = 1e6, 1e-15, 1e-6, 1e-4


class Crossing(NamedTuple):
    """The factor, gains in units of the upper bounds, how much of these, and the frequency [rad/s]; 0: ``s >= 0``."""

    factor: float
    shares: NDArray[np.float64]
    size: float
    omega: float


@dataclass
class LateGains:
    """The search for one plant.

    Attributes
    ----------
    transfer : callable
        ``H`` at points of the plane.
    upper : ndarray
        Upper bounds, all multiplied by the factor.
    blocks : sequence of sequence of int
        The channels that have one gain.
    signed : sequence of bool
        For each block whether its gains may be negative too, as those of operators.
    poles : ndarray
        Of the plant [1/s].
    delay : float
        The longest dead time [s].
    base : ndarray
        Gains of the class with which the loop is stable, but for poles at 0; others are added to these.  Channels in no
        block have the gain 1.
    """

    transfer: Callable[[NDArray[np.complex128]], NDArray[np.complex128]]
    upper: NDArray[np.float64]
    blocks: Sequence[Sequence[int]]
    signed: Sequence[bool]
    poles: NDArray[np.complex128]
    delay: float
    base: NDArray[np.float64]

    def __post_init__(self) -> None:
        end = 10 * max(np.abs(self.poles).max(), 2 * math.pi / self.delay)
        self.omega = np.union1d(np.geomspace(end * 1e-6, end, _GRID // 3), np.linspace(end / _GRID, end, _GRID))
        self.critical = not self.base.any() and np.abs(self.poles).min() == 0
        near = self.omega[0] * _CLOSE
        self.H = self._response(1j * np.append(near, self.omega))
        self.residue = near * self.transfer(np.array([near + 0j]))[0].real

    def _response(self, points: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """``H`` with the gains of the base."""
        H = self.transfer(points)
        return np.asarray(H @ np.linalg.inv(np.eye(len(self.base)) + self.base[:, None] * H) if self.base.any() else H)

    def _gains(self, shares: NDArray[np.float64]) -> NDArray[np.float64]:
        found = np.zeros(len(self.upper))
        for share, block in zip(shares, self.blocks, strict=True):
            found[[*block]] = share * self.upper[[*block]]
        return found

    def crossing(self, shares: NDArray[np.float64]) -> Crossing | None:
        """The smallest factor at which gains in this direction have a root on the axis; None if none.

        Parameters
        ----------
        shares : ndarray
            One for each block.
        """
        G = self._gains(shares)
        values = np.linalg.eigvals(-self.H * G)
        still = values[0][np.abs(values[0].imag) < _CLOSE * (np.abs(values[0]) + 1e-300)].real
        if self.critical:
            still = still[:0]
            rates = np.linalg.eigvals(-self.residue * G).real
            growing = rates > _REAL * np.abs(self.residue).max() * np.abs(G).max()
            if growing.sum() % 2:  # poles at 0 move to the right with any such gains
                return self._made(1 / _LARGEST, shares, 0.0)
        best = self._made(1 / still.max(), shares, 0.0) if len(still) and still.max() > 1 / _LARGEST else None
        phase = np.where(values[1:].real > 0, values[1:].imag, np.nan)
        # a path is continued by the nearest value: with few channels all pairs are looked at
        for k in range(values.shape[1]):
            near = np.abs(values[2:, :] - values[1:-1, k, None]).argmin(axis=1)
            after = np.take_along_axis(phase[1:], near[:, None], axis=1)[:, 0]
            for at in np.flatnonzero(phase[:-1, k] * after <= 0):
                size = max(values[at + 1, k].real, values[at + 2, near[at]].real)
                if size <= 1 / _LARGEST or (best is not None and 1 / size > best.size * 1.01):
                    continue
                found = self._refined(G, float(self.omega[at]), float(self.omega[at + 1]), complex(values[at + 1, k]))
                if found is not None and (best is None or found[0] < best.size):
                    best = self._made(found[0], shares, found[1])
        return best

    def _made(self, size: float, shares: NDArray[np.float64], omega: float) -> Crossing:
        gains, one = self.base + size * self._gains(shares), self.upper != 0
        return Crossing(float(np.abs(gains[one] / self.upper[one]).max()), shares, size, omega)

    def _refined(self, G: NDArray[np.float64], low: float, high: float, start: complex) -> tuple[float, float] | None:
        """The factor and the frequency of one crossing, by secants between ends of two signs (the Illinois method)."""

        def value(omega: float, near: complex) -> complex:
            found = np.linalg.eigvals(-self._response(np.array([1j * omega]))[0] * G)
            return complex(found[np.abs(found - near).argmin()])

        omega, near, new = low, start, start
        below, above, last = start.imag, value(high, start).imag, 0
        for _ in range(_STEPS):
            if below == above or abs(new.imag) <= _EXACT * abs(new) or high - low <= _EXACT * high:
                break
            omega = min(max((low * above - high * below) / (above - below), low), high)
            new = value(omega, near)
            if new.imag * start.imag > 0:
                low, near, below, above, last = omega, new, new.imag, above / (2 if last < 0 else 1), -1
            else:
                high, above, below, last = omega, new.imag, below / (2 if last > 0 else 1), 1
        return (1 / new.real, omega) if new.real > 1 / _LARGEST else None

    def best(self) -> Crossing | None:
        """The smallest factor found: at vertices, some random directions, and from the best of these on."""
        count, random = len(self.blocks), np.random.default_rng(7)
        lowest = np.where(self.signed, -1.0, 0.0)
        ends = product(*((1.0, 0.0, -1.0) if signed else (1.0, 0.0) for signed in self.signed))
        tried = [np.array(v) for v in islice((v for v in ends if any(v)), _MOST_PATTERNS)]
        tried += list(lowest + (1 - lowest) * random.random((_RANDOM if count > 1 else 0, count)))
        found = list[Crossing]()
        for shares in tried:
            checkpoint()
            one = self.crossing(shares / np.abs(shares).max())
            found += [one] if one is not None else []
        found.sort(key=lambda one: one.factor)
        for start in found[:_REFINED] if count > 1 else ():

            def factor(shares: NDArray[np.float64]) -> float:
                checkpoint()
                inside = np.clip(shares, lowest, 1.0)
                size = np.abs(inside).max()
                one = self.crossing(inside / size) if size > 0 else None
                if one is not None:
                    found.append(one)
                return _LARGEST if one is None else one.factor

            optimize.minimize(factor, start.shares, method="Nelder-Mead", options={"maxfev": 40 * count, "xatol": 1e-9})
        return min(found, key=lambda one: one.factor, default=None)

    def proofs(self, one: Crossing, channels: int) -> Iterator[tuple[float, dict[str, Any]]]:
        """Factors, and proofs that gains of the classes of these have a root on the axis.

        Parameters
        ----------
        one : Crossing
            A crossing.
        channels : int
            Of so many, the first, the gains are stated.
        """
        G = one.size * self._gains(one.shares)
        for width in _WIDTHS:
            sides = ((self.base + G * (1 + step)).tolist()[:channels] for step in (-width, width))
            ends = [[Fraction(v) for v in side] for side in sides]
            factor = one.factor * (1 + 2 * width)
            if one.omega == 0:
                yield factor, {"method": "late-gains", "gains": [*map(str, ends[1])]}
                continue
            eye, step = np.eye(len(G)), 1e-6 * one.omega
            left, here, right = self.transfer(1j * np.array([one.omega - step, one.omega, one.omega + step]))
            left, right = (np.linalg.det(eye + h * (self.base + G)) for h in (left, right))
            more, fewer = (np.linalg.det(eye + here * (self.base + G * (1 + v))) for v in (1e-6, -1e-6))
            here, by_factor = np.linalg.det(eye + here * (self.base + G)), more - fewer
            slope, turn = (right - left) / (2 * step), by_factor / 2e-6  # per relative change of the factor
            turn = turn / abs(turn) if abs(turn) > 0 else 1.0
            around = np.prod(1j * one.omega - self.poles) ** len(G)  # the checker multiplies by det(s - A) each column
            pull = abs((slope * np.conj(turn)).imag)
            if pull == 0 or not np.isfinite(pull) or not np.isfinite(here):
                return
            reach = 0.25 * width * abs(by_factor / 2e-6) / abs(slope)
            turn = turn * around / abs(around)
            band = [Fraction(one.omega - reach), Fraction(one.omega + reach)]
            yield (
                factor,
                {
                    "method": "late-crossing",
                    "gains": [[*map(str, row)] for row in ends],
                    "frequencies": [*map(str, band)],
                    "turn": [str(Fraction(f"{v:.6g}")) for v in (turn.real, -turn.imag)],
                },
            )
