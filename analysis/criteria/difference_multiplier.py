"""What Tsypkin's and the Jury-Lee criterion share: one weight ``q >= 0`` on a difference of successive samples."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from flint import fmpq_poly
from numpy.typing import NDArray

from analysis.criteria.discrete_block import DiscreteBlock, largest_certified, nearest_double
from analysis.criteria.fir_search import SampledResponse
from analysis.polynomial import to_fmpq
from analysis.trigonometric import Laurent, at_cosine, nonnegative_on_circle, positive_on_circle

Array = NDArray[np.float64]

WEIGHTS = np.concatenate([[0.0], np.logspace(-6, 8, 57)])
GOLDEN_STEPS = 50
NEARBY = (0.0, *(sign * 10.0**-power for power in range(3, 9) for sign in (-1, 1)))
GOLDEN = (math.sqrt(5) - 1) / 2
DIGITS = (2, 3, 4, 6, 8, 10, 12, 17)
STEPS_UP = (1e-14, 1e-13, 1e-12, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5)


@dataclass(frozen=True, kw_only=True, slots=True)
class DifferenceMultiplier:
    r"""The inequality ``1/K + Re[(1 + q Z) H] - q K s |(z - 1) H|^2 > 0`` on ``|z| = 1``.

    Attributes
    ----------
    discrete : DiscreteBlock
        The stable block ``H``.
    difference : Laurent
        ``Z``: ``1 - z^-1`` or ``z - 1``.
    loss : Fraction
        ``s >= 0``.
    """

    discrete: DiscreteBlock
    difference: Laurent
    loss: Fraction

    def constant(self, width: Fraction) -> fmpq_poly:
        """``|d|^2 (1/width + Re H)`` as a polynomial in ``c = cos w``."""
        return to_fmpq(1 / width) * self.discrete.square + self.discrete.cross.real_part()

    def slope(self, width: Fraction) -> fmpq_poly:
        """The coefficient of ``q``, times ``|d|^2``."""
        gain = (self.difference * self.discrete.cross).real_part()
        return gain - to_fmpq(self.loss * width) * self.squared_difference

    @property
    def squared_difference(self) -> fmpq_poly:
        """``|z - 1|^2 |n|^2``."""
        n = self.discrete.n
        return fmpq_poly([2, -2]) * (n * n.conjugate()).real_part()

    def inequality(self, width: Fraction, q: Fraction) -> fmpq_poly:
        """The left-hand side times ``|d|^2``."""
        return self.constant(width) + to_fmpq(q) * self.slope(width)

    def certifies(self, width: Fraction, q: Fraction) -> bool:
        """Whether it holds at every frequency and ``1 + kappa D > 0`` on ``[0, width]``, decided exactly."""
        if not (width > 0 and q >= 0 and self.discrete.well_posed(width)):
            return False
        return positive_on_circle(self.inequality(width, q))

    def certifies_every(self, q: Fraction) -> bool:
        """The same for every finite width: possible only without a loss that grows with it."""
        if not (q >= 0 and self.discrete.feedthrough >= 0):
            return False
        if q > 0 and self.loss > 0 and self.discrete.n.p.degree() >= 0:
            return False
        real_part = self.discrete.cross + (self.difference * self.discrete.cross).scaled(q)
        return nonnegative_on_circle(real_part.real_part())

    def excluded(self, width: Fraction, cosines: Iterable[Fraction]) -> bool:
        """Whether no ``q >= 0`` satisfies the inequality even at these ``c = cos w`` alone, decided exactly.

        At one ``c`` it reads ``alpha + beta q > 0``: a bound on ``q`` from below or from above.
        """
        constant, slope = self.constant(width), self.slope(width)
        above, below = Fraction(0), None
        for c in cosines:
            alpha, beta = at_cosine(constant, c), at_cosine(slope, c)
            if not -1 <= c <= 1 or (beta == 0 and alpha > 0):
                continue
            if beta == 0:
                return True
            if beta > 0:
                above = max(above, -alpha / beta)
            else:
                below = -alpha / beta if below is None else min(below, -alpha / beta)
        # q above ``above``, or equal to it where it is 0, and strictly below ``below``
        return below is not None and below <= above


@dataclass(frozen=True, kw_only=True, slots=True)
class DifferenceReach:
    """How far it reaches: ``low`` is certified with ``q`` (NaN if none), at ``high`` no ``q`` is left."""

    q: Fraction
    low: float
    high: float


def difference_reach(multiplier: DifferenceMultiplier) -> DifferenceReach:
    """The largest class and the best weight: searched in floating point, then both ends decided exactly.

    Parameters
    ----------
    multiplier : DifferenceMultiplier
        The inequality.

    Notes
    -----
    The set of feasible ``q`` is an interval that shrinks as ``K`` grows, so that the reach is quasiconcave in ``q``.
    """
    sampled = _Sampled.of(multiplier)
    weight, inverse, tight = _best_weight(sampled)
    for text in ("0", *(f"{weight:.{digits}g}" for digits in DIGITS)):
        q = Fraction(text)
        rounded, _ = sampled.inverse_reach(float(q))
        if rounded <= inverse * (1 + 1e-12):
            break
    discrete = multiplier.discrete
    if not inverse > 1e-12 * sampled.size and multiplier.certifies_every(q):
        return DifferenceReach(q=q, low=math.inf, high=math.inf)
    low = largest_certified(discrete, rounded, lambda width: multiplier.certifies(width, q))
    cosines = [Fraction(c) for c in np.unique(np.cos(tight)).tolist()]
    high = math.inf
    for step in STEPS_UP if 0 < inverse < math.inf else ():
        k = nearest_double(discrete.lower + (1 + Fraction(step)) / (Fraction(inverse) * discrete.gain))
        if discrete.lower < k < math.inf and multiplier.excluded(Fraction(k) - discrete.lower, cosines):
            high = k
            break
    return DifferenceReach(q=q, low=low, high=high)


@dataclass(frozen=True, slots=True)
class _Sampled:
    """The inequality in floating point: ``1/K`` must exceed ``(sqrt(R^2 + 4 q Q) - R)/2``, ``R = Re[(1 + q Z) H]``."""

    response: SampledResponse
    multiplier: DifferenceMultiplier
    size: float

    @classmethod
    def of(cls, multiplier: DifferenceMultiplier) -> _Sampled:
        """The left-hand side of a multiplier on the points of a response."""
        response = SampledResponse.of(*multiplier.discrete.coefficients())
        return cls(response, multiplier, float(np.max(np.abs(response.at(response.omega)))))

    def at(self, omega: Array, q: float) -> Array:
        """Its values at ``omega`` for one ``q``, in floating point."""
        z, H = np.exp(1j * omega), self.response.at(omega)
        difference = self.multiplier.difference
        Z = np.polyval([float(c.p) / float(c.q) for c in reversed(difference.p.coeffs())], z) / z**difference.shift
        with np.errstate(invalid="ignore", over="ignore"):
            R = ((1 + q * Z) * H).real
            Q = float(self.multiplier.loss) * np.abs((z - 1) * H) ** 2
            return np.asarray((np.sqrt(R * R + 4 * q * Q) - R) / 2)

    def inverse_reach(self, q: float) -> tuple[float, Array]:
        """The largest value over all frequencies, and the frequencies of the local maxima."""
        return self.response.maximum(lambda omega: self.at(omega, q))


def _best_weight(sampled: _Sampled) -> tuple[float, float, Array]:
    values = [sampled.inverse_reach(float(q))[0] for q in WEIGHTS]
    best = int(np.argmin(values))
    left, right = float(WEIGHTS[max(best - 1, 0)]), float(WEIGHTS[min(best + 1, len(WEIGHTS) - 1)])
    a, b = right - GOLDEN * (right - left), left + GOLDEN * (right - left)
    at_a, at_b = sampled.inverse_reach(a)[0], sampled.inverse_reach(b)[0]
    for _ in range(GOLDEN_STEPS):
        if at_a <= at_b:
            right, b, at_b = b, a, at_a
            a = right - GOLDEN * (right - left)
            at_a = sampled.inverse_reach(a)[0]
        else:
            left, a, at_a = a, b, at_b
            b = left + GOLDEN * (right - left)
            at_b = sampled.inverse_reach(b)[0]
    weight, inverse = min((a, at_a), (b, at_b), (float(WEIGHTS[best]), values[best]), key=lambda pair: pair[1])
    near = [sampled.inverse_reach(weight * (1 + step))[1] for step in NEARBY]
    return weight, inverse, np.concatenate(near)
