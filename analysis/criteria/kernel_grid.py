"""Points in floating point: frequencies around resonances, maxima of a function of the delay."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def peaks(f: Callable[[Floats], Floats], points: Floats, *, least: float, count: int) -> list[tuple[float, float]]:
    """The highest local maxima of ``f`` and where they are: on the points, then refined between neighbours."""
    values = f(points)
    inner = np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] >= values[2:]) & (values[1:-1] > least)) + 1
    found = []
    for i in inner[np.argsort(-values[inner])][:count]:
        low, high = points[i - 1], points[i + 1]
        for _ in range(3):
            finer = np.linspace(low, high, 21)
            best = int(np.clip(np.argmax(f(finer)), 1, 19))
            low, high = finer[best - 1], finer[best + 1]
        found.append((float(values[i]), float(finer[best])))
    return found


def around(roots: NDArray[np.complex128], count: int) -> Floats:
    """Frequencies around lightly damped roots, closer and closer."""
    found: list[Floats] = [np.zeros(0)]
    for root in roots:
        frequency, damping = float(root.imag), abs(float(root.real))
        if frequency > 2 * damping > 0:
            away = damping * np.geomspace(1e-2, frequency / damping, count)
            found += [frequency + away, frequency - away, np.array([frequency])]
    return np.concatenate(found)


def increasing(*parts: Sequence[float] | Floats) -> Floats:
    """All finite frequencies of several arrays that are not negative, in ascending order, each once."""
    omega = np.unique(np.concatenate([np.asarray(part, dtype=float) for part in parts]))
    return np.asarray(omega[np.isfinite(omega) & (omega >= 0)])


def short(value: float) -> Fraction:
    """A number of eight decimal digits, exactly."""
    return Fraction(f"{float(value):.8g}")
