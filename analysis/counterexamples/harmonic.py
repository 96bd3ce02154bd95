"""Orbits by harmonic balance with several harmonics, many starts at once: where the search for exact orbits begins."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise

from lure.analysis.counterexamples.linear import Exponential
from lure.analysis.counterexamples.piecewise import Itinerary, PiecewiseLoop
from lure.analysis.deadline import checkpoint
from lure.arrays import Complexes, NDArray, Reals, in_doubles, np
from lure.errors import InputError
from lure.record import described, quantity

# Periodic orbits followed in doubles while the nonlinearity changes.

_CORRECTOR_STEPS = 15


@dataclass(frozen=True, slots=True)
class Orbit:
    """A periodic orbit in doubles: pieces, first state, durations [s]; see ``validated.Itinerary``."""

    pieces: tuple[int, ...]
    state: Reals
    durations: Reals
    half: bool

    def adjacent(self, last: int) -> bool:
        """Whether the pieces, ``0`` to ``last``, follow one another, over the turn of a half too."""
        closing = last - self.pieces[0] if self.half else self.pieces[0]
        return all(abs(p - q) == 1 for p, q in pairwise((*self.pieces, closing)))

    def exact(self) -> Itinerary:
        """The same numbers as Fractions."""
        durations, state = (tuple(Fraction(float(v)) for v in side) for side in (self.durations, self.state))
        return Itinerary(pieces=self.pieces, durations=durations, state=state, half=self.half)


@dataclass(frozen=True, slots=True)
class Followed:
    """An orbit at a value of the parameter."""

    parameter: float
    orbit: Orbit


def followed(
    family: Callable[[float], PiecewiseLoop], start: float, orbit: Orbit, *, until: float, accuracy: float
) -> Followed | None:
    """The orbit at the smallest parameter it can be followed to from ``start``; None if it is not even there.

    Parameters
    ----------
    family : callable
        The loop for a value of the parameter.
    start : float
        Where to begin, positive.
    orbit : Orbit
        Approximate orbit there.
    until : float
        Where to stop.
    accuracy : float
        Relative width to which the end is located.
    """
    first = settled(family(start), orbit)
    if first is None:
        return None
    best, step = Followed(start, first), 0.3
    previous: Followed | None = None
    while step > accuracy and best.parameter > until:
        target = max(until, best.parameter * (1 - step))
        try:
            loop = family(target)
        except InputError:
            return best
        ahead = best.orbit if previous is None else _extrapolated(previous, best, target)
        found = settled(loop, ahead)
        if found is None and previous is not None:
            found = settled(loop, best.orbit)
        if found is None:
            step /= 2.5
        else:
            previous, best, step = best, Followed(target, found), min(0.5, step * 1.5)
    return best


def settled(loop: PiecewiseLoop, guess: Orbit) -> Orbit | None:
    """The orbit Newton's method leads to, if it stays on its pieces at the samples taken; else None."""
    shooting = Shooting(loop, guess)
    n = len(guess.state)
    unknowns = np.concatenate([guess.state, guess.durations])
    with np.errstate(all="ignore"):
        for _ in range(_CORRECTOR_STEPS):
            checkpoint()
            misses, jacobian = shooting.equations(unknowns)
            if not (np.isfinite(jacobian).all() and np.isfinite(misses).all()):
                return None
            scale = np.abs(jacobian).max(axis=1) + 1e-300
            step = np.linalg.lstsq(jacobian / scale[:, None], misses / scale, rcond=None)[0]
            change = float(np.abs(step[n:] / unknowns[n:]).max())
            unknowns = unknowns - step * min(1.0, 0.4 / max(change, 1e-300))
            if not (np.isfinite(unknowns).all() and (unknowns[n:] > 0).all()):
                return None
            if change < 1e-9:
                found = replace(guess, state=unknowns[:n], durations=unknowns[n:])
                return found if shooting.on_its_pieces(unknowns) else None
    return None


class Shooting:
    """The equations of an orbit in doubles; ``validated`` has the same in balls."""

    def __init__(self, loop: PiecewiseLoop, orbit: Orbit) -> None:
        self.n = loop.system.order
        self.sign = -1 if orbit.half else 1
        self.row = np.array([*(float(v) for v in loop.system.c), 0.0])
        kinds = {p: Exponential(in_doubles(loop.generators[p])) for p in set(orbit.pieces)}
        self.flows = [kinds[p] for p in orbit.pieces]
        closing = loop.mirrored(orbit.pieces[0]) if orbit.half else orbit.pieces[0]
        following = (*orbit.pieces[1:], closing)
        exits = [float(loop.levels[min(p, q)]) for p, q in zip(orbit.pieces, following, strict=True)]
        self.entries = [self.sign * exits[-1], *exits[:-1]]
        ends = [loop.interval(p) for p in orbit.pieces]
        self.bounds = [
            (-math.inf if low is None else float(low), math.inf if high is None else float(high)) for low, high in ends
        ]

    def equations(self, unknowns: Reals) -> tuple[Reals, Reals]:
        """What closure and levels miss, and the derivative by first state and durations."""
        n, times = self.n, unknowns[self.n :]
        m = len(times)
        state = np.append(unknowns[:n], 1.0)
        change = np.zeros((n + 1, n + m))
        change[:n, :n] = np.eye(n)
        misses, jacobian = np.empty(n + m), np.empty((n + m, n + m))
        for i, (flow, t) in enumerate(zip(self.flows, times, strict=True)):
            misses[n + i], jacobian[n + i] = self.row @ state - self.entries[i], self.row @ change
            step = flow.over(t)
            state, change = step @ state, step @ change
            change[:, n + i] = flow.matrix @ state
        misses[:n] = state[:n] - self.sign * unknowns[:n]
        jacobian[:n] = change[:n]
        jacobian[:n, :n] -= self.sign * np.eye(n)
        return misses, jacobian

    def on_its_pieces(self, unknowns: Reals) -> bool:
        """Whether ``y`` is inside the piece at samples of every stay."""
        state = np.append(unknowns[: self.n], 1.0)
        for flow, t, (low, high) in zip(self.flows, unknowns[self.n :], self.bounds, strict=True):
            rate = float(np.abs(flow.matrix).sum(axis=1).max())
            count = int(min(400, max(12, 6 * rate * t)))
            step = flow.over(t / count)
            for i in range(count):
                state = step @ state
                y = float(self.row @ state)
                if i < count - 1 and not low < y < high:
                    return False
        return True


def _extrapolated(previous: Followed, last: Followed, target: float) -> Orbit:
    """Along the straight line through two orbits, over the logarithm of the parameter."""
    ahead = math.log(target / last.parameter) / math.log(last.parameter / previous.parameter) if target > 0 else 0.0
    state = last.orbit.state + ahead * (last.orbit.state - previous.orbit.state)
    durations = last.orbit.durations * (last.orbit.durations / previous.orbit.durations) ** ahead
    return replace(last.orbit, state=state, durations=durations)


# Periodic orbits of relay loops, the limit of steep saturations: where the search for orbits of nonlinearities starts.


NEWTON_STEPS = 30
STARTS = 800


@described(frozen=True, slots=True)
class RelayOrbit:
    """An orbit of ``x' = A x - b sign(c x)``."""

    times: Reals = quantity("(m,), times [s] between the switches; ``c x > 0`` at first")
    states: Reals = quantity("(m, n), the states at the switches, from the one at which it begins")
    half: bool = quantity("Whether the times make half a period, after which the state is the negative of the first")


class RelayOrbits:
    """Relay orbits with a given number of switches, by Newton's method from many random times at once.

    In the modes of ``A`` all is explicit: between switches ``z' = lambda z + u beta``, ``u = -+1``, and the first state
    of a periodic solution follows from the times.  Floating point, for ``A`` with a full set of eigenvectors:
    proposals, never proofs.
    """

    def __init__(self, A: Reals, b: Reals, c: Reals) -> None:
        self.rates, self.modes = (part.astype(complex) for part in np.linalg.eig(A))
        self.beta = np.linalg.lstsq(self.modes, b.astype(complex), rcond=None)[0]
        self.gamma = c @ self.modes
        sizes = np.abs(self.rates)
        self.scale = sizes[sizes > 1e-9 * sizes.max()] if sizes.max() > 0 else np.ones(1)

    def with_switches(self, count: int, *, half: bool, seed: int = 0) -> list[RelayOrbit]:
        """Orbits with ``count`` switches in the half or whole period, no two with the same times."""
        fast, slow = float(self.scale.max()), float(self.scale.min())
        draw = np.random.default_rng(seed).uniform(np.log(0.1 / fast), np.log(6 / slow), (STARTS, count))
        times, sign = np.exp(draw), -1.0 if half else 1.0
        with np.errstate(all="ignore"):
            for _ in range(NEWTON_STEPS):
                checkpoint()
                times, change = self._newton(times, sign)
                if len(times) == 0:
                    return []
            times = times[change < 1e-8]
            if len(times) == 0:
                return []
            _, _, states = self._shoot(times, sign)
            valid = self._signs(times, states)
        found: dict[tuple[float, ...], RelayOrbit] = {}
        for i in np.flatnonzero(valid):
            key = tuple(sorted(float(f"{t:.4g}") for t in times[i]))
            real = np.array([(self.modes @ state[i]).real for state in states[:-1]])
            found.setdefault(key, RelayOrbit(times[i], real, half))
        return sorted(found.values(), key=lambda orbit: float(orbit.times.sum()))

    def _newton(self, times: Reals, sign: float) -> tuple[Reals, Reals]:
        """The times after a damped step, without those that left the range, and how much they changed relatively."""
        misses, jacobian, _ = self._shoot(times, sign)
        good = np.isfinite(jacobian).all(axis=(1, 2)) & np.isfinite(misses).all(axis=1)
        times, misses, jacobian = times[good], misses[good], jacobian[good]
        scale = np.abs(jacobian).max(axis=(1, 2), keepdims=True) + 1e-300
        jacobian, misses = jacobian / scale, misses / scale[..., 0]
        regular = np.abs(np.linalg.det(jacobian)) > 1e-12
        times, misses, jacobian = times[regular], misses[regular], jacobian[regular]
        step = np.linalg.solve(jacobian, misses[..., None])[..., 0]
        change = np.abs(step / times).max(axis=1)
        times = times - step * np.minimum(1, 0.4 / np.maximum(change, 1e-300))[:, None]
        kept = np.isfinite(times).all(axis=1)
        kept &= (times > 1e-6 / self.scale.max()).all(axis=1) & (times < 100 / self.scale.min()).all(axis=1)
        return times[kept], change[kept]

    def _shoot(self, times: Reals, sign: float) -> tuple[Reals, Reals, list[Complexes]]:
        """Values of ``c x`` at the switches, their derivative by the times, and the states in modes."""
        batch, m = times.shape
        decay, gain = self._propagators(times)
        force = [self.beta * (-1 if i % 2 == 0 else 1) for i in range(m)]
        whole: Complexes = np.ones((batch, len(self.rates)), complex)
        forced: Complexes = np.zeros((batch, len(self.rates)), complex)
        for i in range(m):
            forced, whole = decay[:, i] * forced + gain[:, i] * force[i], whole * decay[:, i]
        states: list[Complexes] = [forced / (sign - whole)]
        for i in range(m):
            states.append(decay[:, i] * states[-1] + gain[:, i] * force[i])
        jacobian: Reals = np.empty((batch, m, m))
        for j in range(m):
            push = self.rates * states[j + 1] + force[j]
            moved = push
            for i in range(j + 1, m):
                moved = decay[:, i] * moved
            change = moved / (sign - whole)
            jacobian[:, 0, j] = (change @ self.gamma).real
            for i in range(m - 1):
                change = decay[:, i] * change + (push if i == j else 0)
                jacobian[:, i + 1, j] = (change @ self.gamma).real
        return np.stack([(z @ self.gamma).real for z in states[:-1]], axis=1), jacobian, states

    def _propagators(self, times: Reals) -> tuple[Complexes, Complexes]:
        """``e^(lambda t)`` and ``(e^(lambda t) - 1)/lambda`` for every time and mode."""
        exponent = self.rates * times[..., None]
        still = np.abs(self.rates) < 1e-9 * self.scale.min()
        gain = np.where(still, times[..., None] + 0j, np.expm1(exponent) / np.where(still, 1, self.rates))
        return np.exp(exponent), gain

    def _signs(self, times: Reals, states: list[Complexes]) -> NDArray[np.bool_]:
        """Whether ``c x`` has the relay's sign at samples between the switches."""
        valid = np.ones(len(times), bool)
        for i in range(times.shape[1]):
            side = 1 if i % 2 == 0 else -1
            for share in np.linspace(0.02, 0.98, 25):
                decay, gain = self._propagators(times[:, i] * share)
                valid &= ((decay * states[i] - side * gain * self.beta) @ self.gamma).real * side > 0
        return valid


HARMONICS = (1, 3, 5, 7)
SAMPLES = 128
HARMONIC_STARTS = 600
STEPS = 40
FINE_SAMPLES = 4096


@described(frozen=True, slots=True)
class Balance:
    """A wave ``y = Re sum c_h e^(i h w t)``, ``h = 1, 3, 5, 7``, that nearly satisfies the loop."""

    omega: float = quantity("Fundamental frequency", "rad/s")
    amplitudes: Complexes = quantity("(4,) complex ``c_h``")


class HarmonicBalance:
    """Harmonic balance for ``y = H mu``, ``mu = -psi(y)``, ``psi`` odd with kinks at ``y = -1`` and 1.

    Floating point, and cut off after the seventh harmonic: proposals for Newton's method on the flow, never proofs.

    Parameters
    ----------
    numerator, denominator : ndarray
        Of the strictly proper ``H``, descending powers.
    slopes : tuple of float
        Slope of ``psi`` between the kinks and outside them.
    """

    def __init__(self, numerator: Reals, denominator: Reals, slopes: tuple[float, float]) -> None:
        self.numerator, self.denominator = numerator, denominator
        self.inner, self.outer = slopes
        # half a period, as odd harmonics change sign in the other half
        self.waves = np.exp(1j * np.outer(np.arange(SAMPLES // 2) * (2 * math.pi / SAMPLES), HARMONICS))
        self.basis = np.concatenate([self.waves.real, -self.waves.imag], axis=1).T.copy()
        self.products = (self.basis[:, None] * self.basis).reshape(-1, SAMPLES // 2).T.copy()

    def solutions(self, *, seed: int = 0) -> list[Balance]:
        """Balanced waves that pass the kinks, by Newton's method from random waves, no two alike."""
        rates = np.abs(np.roots(self.denominator))
        rates = rates[rates > 1e-6 * rates.max()] if rates.max() > 0 else np.ones(1)
        low, high = math.log(rates.min() / 5), math.log(rates.max() * 2)
        draw = np.random.default_rng(seed)
        size = 2 * len(HARMONICS)
        first = draw.uniform([low, 0.0], [high, math.log(30)], (HARMONIC_STARTS, 2))
        unknowns = np.concatenate([first, draw.normal(size=(HARMONIC_STARTS, size - 2)) / 2], axis=1)
        with np.errstate(all="ignore"):
            for _ in range(STEPS):
                checkpoint()
                unknowns, change = self._newton(unknowns)
                inside = (unknowns[:, 0] > low - 1) & (unknowns[:, 0] < high + 1) & (np.abs(unknowns[:, 1]) < 8)
                inside &= (np.abs(unknowns[:, 2:]) < 10).all(axis=1)
                unknowns, change = unknowns[inside], change[inside]
                if len(unknowns) == 0:
                    return []
        unknowns = unknowns[change < 1e-6]
        found: dict[tuple[str, str], Balance] = {}
        for row in unknowns:
            omega, amplitudes = self._wave(row[None, :])
            if np.abs((self.waves @ amplitudes[0]).real).max() > 1.0001:
                key = f"{omega[0]:.4g}", f"{abs(amplitudes[0, 0]):.3g}"
                found.setdefault(key, Balance(float(omega[0]), amplitudes[0]))
        return list(found.values())

    def orbit(self, wave: Balance) -> Orbit | None:
        """The wave as half an orbit in the companion form; None if it does not split into two halves at the kinks."""
        points, omega = wave.amplitudes, wave.omega
        phase = np.arange(FINE_SAMPLES) * (2 * math.pi / FINE_SAMPLES)
        y = (np.exp(1j * np.outer(phase, HARMONICS)) @ points).real
        piece = np.where(y < -1, 0, np.where(y > 1, 2, 1))
        switches = np.flatnonzero(np.diff(piece) != 0)
        if len(switches) == 0:
            return None
        first = int(switches[0])
        half = [int(i) for i in switches if i < first + FINE_SAMPLES // 2]
        step = 2 * math.pi / omega / FINE_SAMPLES
        durations = np.diff([*half, first + FINE_SAMPLES // 2]) * step
        s = 1j * omega * np.array(HARMONICS)
        inner = points / np.polyval(self.numerator, s) * np.exp(1j * np.array(HARMONICS) * phase[first])
        state = np.array([(inner * s**j).sum().real for j in range(len(self.denominator) - 1)])
        if len(half) < 2 or not np.isfinite(state).all():
            return None
        return Orbit(tuple(int(piece[(i + 1) % FINE_SAMPLES]) for i in half), state, durations, half=True)

    def _wave(self, unknowns: Reals) -> tuple[Reals, Complexes]:
        """Frequencies and amplitudes: the first is real and positive, the others are relative to it."""
        rest = len(HARMONICS) - 1
        ratio = unknowns[:, 2 : 2 + rest] + 1j * unknowns[:, 2 + rest :]
        first = np.exp(unknowns[:, 1:2])
        return np.exp(unknowns[:, 0]), first * np.concatenate([np.ones_like(first), ratio], axis=1)

    def _harmonics(self, c: Complexes) -> tuple[Complexes, Complexes]:
        """Those of ``psi(y)``, and their derivatives by real and imaginary parts of those of ``y``."""
        a, m = np.concatenate([c.real, c.imag], axis=1), len(HARMONICS)
        y, bent = a @ self.basis, 4 * (self.inner - self.outer) / SAMPLES
        f = self.outer * a + bent * (np.clip(y, -1, 1) @ self.basis.T)
        slopes = bent * ((np.abs(y) < 1).astype(float) @ self.products).reshape(-1, 2 * m, 2 * m)
        slopes += self.outer * np.eye(2 * m)
        return f[:, :m] + 1j * f[:, m:], slopes[:, :m] + 1j * slopes[:, m:]

    def _blocks(self, omega: Reals) -> tuple[Complexes, Complexes]:
        """``n`` and ``d`` at the harmonics, divided by ``|d| + |n|`` times the larger slope."""
        s = 1j * omega[:, None] * HARMONICS
        n, d = np.polyval(self.numerator, s), np.polyval(self.denominator, s)
        size = np.abs(d) + max(self.inner, self.outer) * np.abs(n)
        return n / size, d / size

    def _newton(self, unknowns: Reals) -> tuple[Reals, Reals]:
        """The unknowns after a damped step for ``d c + n f = 0``, those that have one, and the largest change."""
        omega, c = self._wave(unknowns)
        n, d = self._blocks(omega)
        f, slopes = self._harmonics(c)
        first, rest, one = c[:, :1].real, len(HARMONICS) - 1, np.eye(len(HARMONICS))[:, 1:]
        turning = slopes @ np.concatenate([c.real, c.imag], axis=1)[..., None]
        c, f, turning = c / first, f / first, turning[..., 0] / first
        later_n, later_d = self._blocks(omega * math.exp(1e-7))
        misses = d * c + n * f
        columns = [((later_d * c + later_n * f - misses) / 1e-7)[..., None], (n * (turning - f))[..., None]]
        for share, side in ((1, slopes[:, :, 1 : 1 + rest]), (1j, slopes[:, :, 2 + rest :])):
            columns.append(n[..., None] * side + share * d[..., None] * one)
        derivative = np.concatenate(columns, axis=2)
        residual = np.concatenate([misses.real, misses.imag], axis=1)
        jacobian = np.concatenate([derivative.real, derivative.imag], axis=1)
        jacobian[~np.isfinite(jacobian).all(axis=(1, 2))] = 0.0
        good = np.flatnonzero(np.abs(np.linalg.det(jacobian)) > 1e-200)
        step = np.linalg.solve(jacobian[good], residual[good][..., None])[..., 0]
        change = np.abs(step).max(axis=1)
        return unknowns[good] - step * np.minimum(1, 0.3 / np.maximum(change, 1e-300))[:, None], change
