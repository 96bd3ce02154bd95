"""Periodic orbits followed in doubles while the law changes."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise

from lure.analysis.counterexamples.linear import Exponential, doubles
from lure.analysis.counterexamples.piecewise import PiecewiseLoop
from lure.analysis.counterexamples.validated import Itinerary
from lure.analysis.deadline import checkpoint
from lure.arrays import Reals, np
from lure.errors import InputError

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
        kinds = {p: Exponential(doubles(loop.generators[p])) for p in set(orbit.pieces)}
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
