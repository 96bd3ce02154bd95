"""Solutions of a loop with several known nonlinearities, play and stop among them, simulated side by side: observed."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from typing import NamedTuple

from lure.analysis.counterexamples.confirming import scales
from lure.analysis.counterexamples.trajectories import Finding, Trajectory, kernel
from lure.arrays import Reals, in_doubles, integrate, linalg, np
from lure.errors import InputError
from lure.nonlinearities.base import Nonlinearity
from lure.nonlinearities.piecewise_linear import Graph
from lure.plants.multivariable import MultivariablePlant

SAMPLES, STRETCHES = 400, 5
"""Instants of the first stretch, and the number of stretches, each twice as long as that before it."""
_STARTS = ((3.0, "near the scales of the nonlinearities"), (0.3, "below them"), (100.0, "far beyond them"))
_RTOL, _REST, _STILL, _EVEN, _GROWTH = 1e-8, 1e-4, 1e-3, 1e-3, 1e6
_NEWTON, _MOST_STEPS = 40, 400
_GAINS = (0.1, 1.0, 3.0, 30.0)  # times the scales: where chords of the nonlinearities are looked at
_PROBES = 120


class Hysteron(NamedTuple):
    """A play, ``k p``, or a stop, ``k xi``, ``p = sigma - xi``: ``|xi| <= 1``, and ``p`` moves only where it has to.

    Attributes
    ----------
    stop : bool
        Whether a stop; else a play.
    slope : float
        ``k``.
    """

    stop: bool
    slope: float

    def alone(self, sigma: Reals) -> Reals:
        """The output from ``p = 0``, ``sigma`` being monotone; ``sigma``: input."""
        return self.of(sigma, np.clip(sigma, -1.0, 1.0))

    def of(self, sigma: Reals, xi: Reals) -> Reals:
        """The output; ``sigma``, ``xi``: input, and its distance from ``p``."""
        inner = np.clip(xi, -1.0, 1.0)
        return np.asarray(self.slope * (inner if self.stop else sigma - inner))


def channel_solutions(
    plant: MultivariablePlant, nonlinearities: Sequence[Nonlinearity | Graph | Hysteron], words: str
) -> tuple[Trajectory, ...]:
    """Solutions of ``sigma = H mu``, ``mu_i = -phi_i(sigma_i)`` from a few first states, left by impulses of ``mu``.

    The first states are seen in ``sigma`` near the scales of the nonlinearities, below and far beyond them.  Each
    solution is followed until it has come to rest or grown a million times, or five stretches are over, each twice as
    long as that before; what is then open is called so.  In doubles, by LSODA or by recursion.

    ``plant``: ``H`` with ``m`` inputs and outputs; ``nonlinearities``: one for each channel; ``words``: what they are
    called.

    Returns
    -------
    tuple of Trajectory
        ``sigma`` and ``mu`` are (samples, m), of the first stretch.

    Raises
    ------
    InputError
        There is a direct term beside play and stop.
    """
    loop = _Loop(plant, nonlinearities)
    states, first = loop.starts()
    stretches: list[tuple[Reals, Reals]] = []
    findings, mu = [Finding.OPEN] * len(states), list[Reals]()
    length, until, now = first, 0.0, states
    for _ in range(STRETCHES):
        t, path = loop.recursion(now, int(length)) if loop.discrete else loop.integral(now, length)
        flat = path.reshape(-1, path.shape[2])
        sigma = loop.sigma(flat).reshape(*path.shape[:2], -1)
        with np.errstate(all="ignore"):
            mu.append(-loop.phi(sigma.reshape(-1, plant.inputs), flat).reshape(sigma.shape))
        stretches.append((until + t, sigma))
        whole = np.concatenate([part for _, part in stretches], axis=1)
        findings = [loop.finding(whole[i], len(t)) for i in range(len(states))]
        until, length, now = until + float(t[-1]), 2 * length, path[:, -1]
        if all(one is not Finding.OPEN and one is not Finding.OSCILLATES for one in findings):
            break
        now = np.where(np.isfinite(now), now, 0.0)
    t, sigma = stretches[0]
    return tuple(
        Trajectory(
            t=t * loop.seconds,
            sigma=sigma[i],
            mu=mu[0][i],
            nonlinearity=words,
            start=f"|sigma| {_STARTS[i][1]}",
            finding=findings[i],
            until=until * loop.seconds,
            discrete=loop.discrete,
            unit="samples" if plant.dt == 1 else "s",  # 1 too where no sampling time is stated
        )
        for i in range(len(states))
    )


class _Loop:
    """The loop in doubles, for many solutions at once, one a row."""

    def __init__(self, plant: MultivariablePlant, nonlinearities: Sequence[Nonlinearity | Graph | Hysteron]) -> None:
        sides = (plant.A, plant.B, plant.C, plant.D)
        self.A, self.B, self.C, self.D = (in_doubles(side) for side in sides)
        self.discrete = plant.dt is not None
        self.seconds = 1.0 if plant.dt is None else float(plant.dt)
        self.values = list[Callable[[Reals], Reals]]()
        for one in nonlinearities:
            self.values.append(one.alone if isinstance(one, Hysteron) else kernel(one))
        self.knees = np.array([1.0 if isinstance(one, Hysteron) else scales(one)[-1] for one in nonlinearities])
        self.implicit = bool(self.D.any())
        self.hysterons = {i: one for i, one in enumerate(nonlinearities) if isinstance(one, Hysteron)}
        if self.hysterons and self.implicit:
            raise InputError("play and stop are simulated beside D = 0 alone")

    def phi(self, sigma: Reals, states: Reals | None = None) -> Reals:
        """``phi_i(sigma_i)``, (rows, m); of play and stop from ``p = 0`` if no states ``(x, xi)`` are given."""
        columns = [np.asarray(one(sigma[:, i]), dtype=float) for i, one in enumerate(self.values)]
        if states is not None:
            for at, (i, one) in enumerate(self.hysterons.items(), len(self.A)):
                columns[i] = one.of(sigma[:, i], states[:, at])
        return np.stack(columns, axis=1)

    def sigma(self, states: Reals) -> Reals:
        """``sigma + D phi(sigma) = C x``, (rows, m), by Newton's method with chords; NaN where it does not end."""
        with np.errstate(all="ignore"):
            y = np.asarray(states[:, : len(self.A)] @ self.C.T)
            if not self.implicit:
                return y
            found, step = y.copy(), 1e-6 * self.knees
            for _ in range(_NEWTON):
                phi = self.phi(found)
                residual = found + phi @ self.D.T - y
                size = np.abs(found) + np.abs(phi) @ np.abs(self.D).T + np.abs(y) + 1e-300
                if (np.abs(residual) <= 1e-12 * size).all():
                    return np.asarray(found)
                slopes = (self.phi(found + step) - self.phi(found - step)) / (2 * step)
                slopes = np.where(np.isfinite(slopes), slopes, 0.0)
                matrices = np.eye(len(self.D)) + self.D * slopes[:, None, :]
                moved = [np.linalg.lstsq(M, r, rcond=None)[0] for M, r in zip(matrices, residual, strict=True)]
                found = np.where(np.isfinite(residual), found - np.array(moved), np.nan)
            return np.where((np.abs(residual) <= 1e-6 * size).all(axis=1, keepdims=True), found, np.nan)

    def starts(self) -> tuple[Reals, float]:
        """First states (runs, n), and the length of the first stretch."""
        matrix, first = self._typical()
        shape = np.random.default_rng(15).standard_normal((len(_STARTS), self.B.shape[1]))
        states = shape @ self.B.T
        step = 1 if self.discrete else first / _PROBES
        flow, x = matrix if self.discrete else linalg.expm(matrix * step), states
        seen = []
        for _ in range(_PROBES):
            seen.append(x @ self.C.T)
            x = x @ flow.T
        sigma = np.stack(seen, axis=1)
        peaks = (np.abs(sigma) / self.knees).max(axis=(1, 2))
        lengths = np.array([size for size, _ in _STARTS]) / np.where(peaks > 0, peaks, 1.0)
        for i, length in enumerate(lengths):  # of two opposite states the one that one-sided nonlinearities oppose more
            forth, back = (float(np.abs(self.phi(sign * length * sigma[i])).sum()) for sign in (1, -1))
            lengths[i] = length if forth >= back else -length
        states = states * lengths[:, None]
        return np.hstack([states, np.clip(states @ self.C[list(self.hysterons)].T, -1.0, 1.0)]), first

    def _typical(self) -> tuple[Reals, float]:
        """The matrix of the linear loop with chords of the nonlinearities that decays most, and twelve of its times."""
        best, first, rate = self.A, 1.0, -math.inf
        for share in _GAINS:
            at = (share * self.knees)[None, :]
            gains = np.diag(((self.phi(at) / at - self.phi(-at) / at) / 2)[0])
            try:
                closed = self.A - self.B @ gains @ np.linalg.solve(np.eye(len(self.D)) + self.D @ gains, self.C)
            except np.linalg.LinAlgError:
                continue
            roots = np.linalg.eigvals(closed).astype(complex)
            roots = np.log(np.where(np.abs(roots) < 1e-12, 1e-12, roots)) if self.discrete else roots
            largest = float(np.abs(roots).max(initial=0.0)) or 1.0
            moving = roots[np.abs(roots) > 1e-9 * largest]
            slowest = float(-moving.real.max()) if moving.size else 0.0
            if slowest > rate:
                quickest = float(np.abs(moving.imag).max(initial=0.0)) or largest
                usual = 12 / slowest if slowest > 0 else math.inf
                best, rate, first = closed, slowest, min(usual, 40 * math.pi / quickest)
        return best, float(max(64, min(4 * SAMPLES, math.ceil(first)))) if self.discrete else first

    def recursion(self, states: Reals, steps: int) -> tuple[Reals, Reals]:
        """Instants (steps,) and states (runs, steps, n) in discrete time."""
        path, n, own = np.empty((len(states), steps, states.shape[1])), len(self.A), list(self.hysterons)
        with np.errstate(all="ignore"):
            for k in range(steps):
                path[:, k] = states
                sigma = self.sigma(states)
                after = states[:, :n] @ self.A.T - self.phi(sigma, states) @ self.B.T
                xi = states[:, n:] + (self.sigma(after) - sigma)[:, own] if own else states[:, n:]
                states = np.hstack([after, np.clip(xi, -1.0, 1.0)])
        return np.arange(steps, dtype=float), path

    def integral(self, states: Reals, length: float) -> tuple[Reals, Reals]:
        """Instants and states (runs, samples, n) in continuous time; NaN from where the integrator gives up."""
        t = np.linspace(0.0, length, SAMPLES)
        path, n, own = np.full((len(states), SAMPLES, states.shape[1]), np.nan), len(self.A), list(self.hysterons)

        def velocity(x: Reals, _: float) -> Reals:
            """Right-hand side; 0 where ``sigma`` does not exist."""
            row = x[None, :]
            rate = row[:, :n] @ self.A.T - self.phi(self.sigma(row), row) @ self.B.T
            turn = (rate @ self.C.T)[:, own]
            rate = np.hstack([rate, np.where((np.abs(row[:, n:]) >= 1) & (row[:, n:] * turn > 0), 0.0, turn)])
            return np.asarray(np.where(np.isfinite(rate), rate, 0.0)[0])

        for i, start in enumerate(states):
            weights = np.full(len(start), _RTOL * 1e-4 * float(np.abs(start).max()) + 1e-280)
            with warnings.catch_warnings(), np.errstate(all="ignore"):
                warnings.simplefilter("ignore", integrate.ODEintWarning)
                found, info = integrate.odeint(
                    velocity, start, t, rtol=_RTOL, atol=weights, mxstep=_MOST_STEPS, full_output=True
                )
            whole = str(info["message"]).startswith("Integration successful")
            reached = SAMPLES if whole else 1 + int(np.count_nonzero(np.asarray(info["tcur"]) >= t[1:]))
            path[i, :reached] = found[:reached]
        return t, path

    def finding(self, sigma: Reals, last: int) -> Finding:
        """What a solution (samples, m) shows, whose last stretch has so many samples."""
        sizes = np.abs(sigma / self.knees).max(axis=1)
        seen = np.isfinite(sizes)
        if not seen.all():
            return Finding.GROWS if sizes[seen].max(initial=0.0) > _GROWTH * sizes[0] > 0 else Finding.OPEN
        peak, end = float(sizes.max()), sigma[-(last // 4) :] / self.knees
        if float(sizes[-1]) > _GROWTH * float(sizes[: last // 4].max()):
            return Finding.GROWS
        if float(np.abs(end).max()) <= _REST * peak:
            return Finding.CONVERGES
        spans = [float(np.ptp(part, axis=0).max()) for part in (sigma[-last : -last // 2] / self.knees, end)]
        if spans[1] <= _REST * peak:  # or decays slowly
            return Finding.RESTS if spans[1] <= _STILL * float(np.abs(end).max()) else Finding.OPEN
        return Finding.OSCILLATES if abs(spans[1] - spans[0]) <= _EVEN * spans[0] else Finding.OPEN
