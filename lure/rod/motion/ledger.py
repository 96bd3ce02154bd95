"""The energy balance of the end ``x = L`` along a motion."""

from __future__ import annotations

import math

import numpy as np

from lure.rod.motion.chebyshev import basis, largest
from lure.rod.motion.windows import Problem, Window

LEAST_ENERGY = 1e-290  # [J]: below, doubles lose digits


class Ledger:
    r"""Keeps ``Z/4 int (W^2 - V^2) dt - k_L int z'^2 dt - A [P(z)]`` since the start, which is zero in exact numbers.

    The waves bring what they carry from ``x = 0`` and along the rod without change, so that an error of the motion can
    only be here: in the solution of ``z' = W - d p(z)`` and in the instants of contact and release.
    """

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        self._sum, self._rest, self._worst, self._scale = 0.0, 0.0, 0.0, 0.0
        self._start: float | None = None
        self.largest_wave = 0.0

    def add(self, window: Window) -> None:
        """Enter the next window."""
        work, lost, passed = _power_at_end(self._problem, window)
        if self._start is None:
            z = self._problem.sources.scenario.contact_coordinate(self._problem.sources.rod)
            self._start = self._stored(z)
        term = work - lost
        total = self._sum + term
        self._rest += (self._sum - total) + term if abs(self._sum) >= abs(term) else (term - total) + self._sum
        self._sum = total
        segment = self._problem.law.segments[window.end.segment]
        stored = self._stored(segment.origin + (window.end.zeta.value + window.end.zeta.rest))
        self._worst = max(self._worst, abs(self._sum + self._rest - (stored - self._start)))
        self._scale = max(self._scale, passed, abs(stored), abs(self._start))
        self.largest_wave = max(self.largest_wave, largest(window.wave))

    @property
    def residual(self) -> float:
        """Largest imbalance so far, relative to the largest energy of a round trip."""
        return self._worst / max(self._scale, LEAST_ENERGY)

    def _stored(self, z: float) -> float:
        """``A P(z)`` [J]."""
        problem, area = self._problem, self._problem.sources.rod.area
        total = 0.0
        for segment in problem.law.segments:
            if math.isinf(segment.rate):
                continue
            # from 0 to z, the part inside this segment, in both directions
            low, high = max(segment.low, min(0.0, z)), min(segment.high, max(0.0, z))
            if low >= high:
                continue
            a, b = low - segment.origin, high - segment.origin
            n = segment.power + 1.0
            curved = segment.rate * (max(b, 0.0) ** n - max(a, 0.0) ** n) / n
            straight = segment.rate * 0.5 * (b - a) * (b + a)
            part = segment.push * (b - a) + (straight if segment.power == 1.0 else curved)
            total += part if z > 0.0 else -part
        return area * total / (problem.sources.rod.mobility * problem.share)


def _power_at_end(problem: Problem, window: Window) -> tuple[float, float, float]:
    """Work of the waves on the end, what a dashpot there takes up, and the energy that passes, over a window [J].

    ``Z/4 int (W^2 - V^2) dt``, ``k_L int z'^2 dt`` and ``Z/4 int W^2 dt``, by Gauss quadrature exact for the series.
    """
    rod, share = problem.sources.rod, problem.share
    space = basis(window.wave.shape[1] - 1)
    incoming, pushed = window.wave @ space.at_gauss.T, window.push @ space.at_gauss.T
    speed = share * incoming - pushed
    half = 0.5 * rod.travel_time * np.diff(window.edges)[:, None] * space.weights
    work = rod.impedance * float((half * speed * (incoming - speed)).sum())
    lost = rod.impedance * (1.0 / share - 1.0) * float((half * speed**2).sum())
    return work, lost, 0.25 * rod.impedance * float((half * incoming**2).sum())
