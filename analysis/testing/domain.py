"""Where a law is tested: an interval, and the points of it that are tried first."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from lure.errors import InputError
from lure.exact import Exact, exact_number

_DECADES = (-12.0, 12.0)
_SHARE_OF_LINEAR = 0.25
_NEAR = (0.0, 1e-3, -1e-3, 1e-6, -1e-6, 1e-9, -1e-9)


@dataclass(frozen=True, kw_only=True, slots=True)
class Domain:
    """The interval ``[low, high]`` in doubles.

    Attributes
    ----------
    low, high : float
        Its ends; ``-1e12, 1e12`` stand for all of R where nothing was given.
    given : tuple of Fraction or None
        The ends as they were given, None for all of R.
    scale : float
        The evenly spaced points have at most this size.
    """

    low: float
    high: float
    given: tuple[Fraction, Fraction] | None
    scale: float

    def __str__(self) -> str:
        return f"[{self.low:g}, {self.high:g}]"

    def points(self, samples: int, breakpoints: Sequence[float]) -> NDArray[np.float64]:
        """Ascending points: many decades on both sides of 0, evenly spaced ones, and some near breakpoints."""
        reach = max(abs(self.low), abs(self.high))
        top = np.log10(reach)
        sizes = np.logspace(min(_DECADES[0], top - 12.0), top, max(samples * 3 // 8, 4))
        linear = np.linspace(
            max(self.low, -self.scale), min(self.high, self.scale), int(samples * _SHARE_OF_LINEAR) + 2
        )
        kinks = np.array([b for b in breakpoints if np.isfinite(b)], dtype=float)
        near = [kinks + shift * np.maximum(np.abs(kinks), 1e-3 * self.scale) for shift in _NEAR]
        x = np.unique(np.concatenate([-sizes, sizes, linear, *near, [0.0, self.low, self.high]]))
        return np.asarray(x[(x >= self.low) & (x <= self.high)])

    @property
    def rounding_scale(self) -> float:
        """Size of ``sigma`` below which ``phi`` is taken to carry the rounding of its largest value there."""
        return min(self.scale, 1.0)

    @property
    def unit(self) -> float:
        """The power of ten in which simple numbers of the interval are written."""
        return 1.0 if self.given is None else float(f"1e{math.floor(math.log10(self.scale))}")

    def holds(self, sigma: float) -> bool:
        """Whether a point belongs to the interval."""
        return self.low <= sigma <= self.high


def domain(on: tuple[Exact, Exact] | None) -> Domain:
    """The interval of a test.

    Parameters
    ----------
    on : (low, high) or None
        Ends, exact numbers; None for all of R, of which ``|sigma| <= 1e12`` is sampled.

    Raises
    ------
    InputError
        It is not a pair of numbers in ascending order.
    """
    if on is None:
        return Domain(low=-1e12, high=1e12, given=None, scale=1.0)
    if isinstance(on, str) or not isinstance(on, Sequence) or len(on) != 2:
        raise InputError(f"on is {on!r:.60}; give a pair (low, high), or None for all of R")
    low, high = exact_number(on[0], "on[0]"), exact_number(on[1], "on[1]")
    if not low < high:
        raise InputError(f"on is ({float(low):g}, {float(high):g}); give low < high")
    ends = float(low), float(high)
    return Domain(low=ends[0], high=ends[1], given=(low, high), scale=max(map(abs, ends)))
