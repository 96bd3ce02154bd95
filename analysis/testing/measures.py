"""How far a law is outside what is asserted of it, and how much of that may be rounding."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from analysis.testing.domain import Domain
from analysis.testing.subject import Array, Subject

_RELATIVE = 1e-12
_ABSOLUTE = 4e-15
_ARGUMENT = 2e-15


@dataclass(frozen=True, kw_only=True, slots=True)
class Limits:
    """What a quantity must lie between, and by how much it may miss: ``lower - tolerance`` to ``upper + tolerance``."""

    lower: float | Fraction
    upper: float | Fraction
    tolerance: float

    @property
    def size(self) -> float:
        """The larger of the finite bounds, in size; 0 if there is none."""
        return max((abs(float(b)) for b in (self.lower, self.upper) if abs(b) != math.inf), default=0.0)

    @property
    def sides(self) -> tuple[int, ...]:
        """1 if there is an upper bound, -1 if there is a lower one."""
        return tuple(side for side, bound in ((1, self.upper), (-1, self.lower)) if abs(bound) != math.inf)

    def outside(self, values: Array) -> Array:
        """Signed distance to the limits without the tolerance, positive outside; ``-inf`` where nothing bounds."""
        return np.maximum(values - float(self.upper), float(self.lower) - values)

    def allowance(self, values: Array, coarseness: float) -> Array:
        """The tolerance, and what rounding may do to a value whatever the law."""
        return self.tolerance + coarseness * _RELATIVE * np.maximum(np.abs(values), self.size)


@dataclass(frozen=True, kw_only=True, slots=True)
class Chord:
    """``phi(sigma)/sigma``, for ``sigma`` not 0."""

    subject: Subject
    limits: Limits
    noise: float

    def quantity(self, x: Array) -> Array:
        """The chord slopes."""
        return np.asarray(self.subject(x) / x)

    def allowance(self, x: Array, values: Array) -> Array:
        """Tolerance and rounding."""
        return np.asarray(self.limits.allowance(values, self.subject.coarseness) + self.noise / np.abs(x))


@dataclass(frozen=True, kw_only=True, slots=True)
class Mirror:
    """``phi(sigma) + phi(-sigma)``, which is 0 for an odd law."""

    subject: Subject
    limits: Limits
    noise: float

    def quantity(self, x: Array) -> Array:
        """The sums."""
        return self.subject(x) + self.subject(-x)

    def allowance(self, x: Array, values: Array) -> Array:
        """Tolerance and rounding."""
        sizes = np.maximum(np.abs(self.subject(x)), np.abs(values))
        return self.limits.allowance(sizes, self.subject.coarseness) + 2 * self.noise


@dataclass(frozen=True, kw_only=True, slots=True)
class Quotient:
    """``(phi(y) - phi(x))/(y - x)``, for pairs ``x < y``."""

    subject: Subject
    limits: Limits
    noise: float

    def quantity(self, x: Array, phi: Array) -> Array:
        """The difference quotients of consecutive points."""
        with np.errstate(over="ignore"):
            return np.diff(phi) / np.diff(x)

    def allowance(self, x: Array, phi: Array, values: Array) -> Array:
        """Tolerance and rounding: of the values, and of the argument inside the law."""
        steps = np.diff(x)
        coarse = self.subject.coarseness
        sizes = coarse * (np.abs(phi[1:]) + np.abs(phi[:-1]))
        argument = coarse * _ARGUMENT * (np.abs(x[1:]) + np.abs(x[:-1])) * np.maximum(np.abs(values), self.limits.size)
        with np.errstate(over="ignore"):
            return self.limits.allowance(values, coarse) + (2 * self.noise + 1e-15 * sizes + argument) / steps


def rounding(subject: Subject, x: Array, where: Domain) -> float:
    """The absolute rounding error granted to a law in doubles: 4e-15 of its largest value near 0."""
    inner = x[np.abs(x) <= where.rounding_scale]
    return subject.coarseness * _ABSOLUTE * float(np.abs(subject(inner)).max(initial=0.0))
