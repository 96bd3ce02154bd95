"""A force as a sum of exponentials, sines and powers of time between two of its breakpoints."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from lure.expressions.exponentials import Sum, exponentials
from lure.rod.motion.pieces import Array, basis, tails
from lure.rod.motion.sources import SPAN, Load, Sources, panel_table

_MOST_COLUMNS = 24
_MOST_POWER = 4
_LARGEST = 250.0  # exponents of the force, per round trip and transit
_RESOLVED, _NOISE = 1e-15, 1e-16
Complex = NDArray[np.complex128]


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class ExponentialForce:
    """What a force adds to the wave between two of its breakpoints, a sum of ``w t^K e^{rate t}``.

    Attributes
    ----------
    rate : ndarray
        (r,) exponents per transit, one of each conjugate pair.
    powers : tuple of int
        (r,) highest power of ``t`` with each.
    weights : tuple of ndarray
        (r,) weights for ``K = 0, ...``, time in transits since the force left ``x = 0``, in units of the wave [m/s],
        twice those of the sum for a pair.
    """

    rate: Complex
    powers: tuple[int, ...]
    weights: tuple[Complex, ...]

    def __call__(self, t: Array) -> Array:
        """Values at instants [transits] of the wave, which has taken a transit."""
        total, late = np.zeros(t.shape), t - 1.0
        for rate, weights in zip(self.rate.tolist(), self.weights, strict=True):
            shares = np.polynomial.polynomial.polyval(late, weights)
            total += (shares * np.exp(rate * late)).real
        return total

    @property
    def table(self) -> Array:
        """As the kernel has it: see :func:`lure.rod.motion.kernel_follow.follow`."""
        rows = [float(len(self.powers))]
        for rate, power, weights in zip(self.rate.tolist(), self.powers, self.weights, strict=True):
            rows += [rate.real, rate.imag, float(power)]
            rows += [part for weight in weights.tolist() for part in (weight.real, weight.imag)]
        return np.array(rows)

    @property
    def columns(self) -> int:
        """Number of real functions of the time in a round trip that it takes."""
        return sum((power + 1) * (2 if rate.imag else 1) for rate, power in zip(self.rate, self.powers, strict=True))

    @property
    def finite_until(self) -> int:
        """Round trip up to which no exponential is beyond the doubles."""
        fastest = float(self.rate.real.max(initial=0.0))
        return int(_LARGEST / fastest) if fastest > 0.0 else 1 << 62


class ExponentialForces:
    """The force of a motion from breakpoint to breakpoint."""

    def __init__(self, sources: Sources) -> None:
        scenario, self._sources = sources.scenario, sources
        self.known = scenario.body_force.is_zero
        self._edges: Sequence[Fraction] = ()
        if self.known and not scenario.force.is_zero:
            found = scenario.force.breakpoints("t", 0.0, math.inf)
            self.known = found is not None
            self._edges = found or ()
        self._made: dict[int, ExponentialForce | None] = {}

    def panels(self, first: int, count: int, degree: int) -> Load | None:
        """The panels of blocks in which the force keeps its formula, without looking at it; None elsewhere."""
        force, end = self._from(max(SPAN * first, 1.0))
        if force is None or end < SPAN * (first + count) or (not first and count > 1):
            return None
        low, space = (0.0 if first else 1.0), basis(degree)  # the force needs a transit to arrive
        block, none = np.arange(first, first + count, dtype=float), np.zeros(count)
        with np.errstate(over="ignore", invalid="ignore"):  # a force that grows beyond the doubles is no panel
            values = force(SPAN * block[:, None] + (low + 0.5 * (SPAN - low) * (space.inner + 1.0)))
            coef = np.einsum("ij,kj->ik", values, space.from_inner)  # rounds each row alike, however many there are
        size = np.abs(coef).sum(axis=1)
        if not np.all(tails(coef) <= _RESOLVED * size):
            return None
        done = [(block, none + low, none + SPAN, coef, size, none, _NOISE * size)]
        if not first:
            done.insert(0, (block, none, none + 1.0, 0.0 * coef, none, none, none))
        return panel_table(first, count, done)

    def over(self, number: int) -> tuple[ExponentialForce | None, float]:
        """The force from a round trip on, None if it is no such sum; the instant [transits] up to which it holds."""
        return self._from(2.0 * number) if number else (None, 0.0)

    def _from(self, start: float) -> tuple[ExponentialForce | None, float]:
        if not self.known:
            return None, 0.0
        ends = [float(edge) / self._sources.rod.travel_time + 1.0 for edge in self._edges]
        place = sum(end <= start for end in ends)
        if place not in self._made:
            self._made[place] = self._force(place)
        return self._made[place], ends[place] if place < len(ends) else math.inf

    def _force(self, place: int) -> ExponentialForce | None:
        sources = self._sources
        terms: Sum | None = {}
        if not sources.scenario.force.is_zero and sources.force_gain:
            low = self._edges[place - 1] if place else Fraction(0)
            high = self._edges[place] if place < len(self._edges) else low + 1
            terms = exponentials(sources.scenario.force.tree, "t", (low + high) / 2)
        if terms is None or max((power for _, power in terms), default=0) > _MOST_POWER:
            return None
        T, gain = sources.rod.travel_time, sources.force_gain
        rates = sorted({rate for rate, _ in terms if rate.imag >= 0.0}, key=lambda rate: (rate.imag, rate.real))
        powers = tuple(max(power for other, power in terms if other == rate) for rate in rates)
        weights = tuple(
            np.array(
                [gain * T**k * (2.0 if rate.imag else 1.0) * terms.get((rate, k), 0j) for k in range(power + 1)],
                dtype=complex,
            )
            for rate, power in zip(rates, powers, strict=True)
        )
        rate = np.array([T * rate for rate in rates], dtype=complex)
        found = ExponentialForce(rate=rate, powers=powers, weights=weights)
        return found if found.columns <= _MOST_COLUMNS else None
