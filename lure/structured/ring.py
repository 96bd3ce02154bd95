"""The waves of the upwind scheme as an f-circulant ring: what leaves it, sums of it, and its echoes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.upwind import UpwindScheme
from lure.waves import RodBlock

Array: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Ring:
    r"""Waves ``y`` in the order (39) and the scaled coordinate ``s z``, in units of ``1/s``: ``y' = (S - 1) y``.

    ``S`` shifts by one cell and closes the ring with ``f = -a``; read backwards, ``Y_{i - 2N} = f Y_i`` continues the
    waves for ever, and ``S^n`` only moves the place at which that stream is read.

    Attributes
    ----------
    scheme : UpwindScheme
        The scheme.
    waves : ndarray
        (2N,) at the start [m/s].
    gap : float
        ``s z`` at the start [m/s].
    """

    scheme: UpwindScheme
    waves: Array
    gap: float

    @property
    def echo(self) -> float:
        """``f = -a``."""
        return -self.scheme.rod.reflection

    @cached_property
    def log_echo(self) -> float:
        """``ln|f|``, accurate near ``|f| = 1``; ``-inf`` for ``k = Z``."""
        return RodBlock(self.scheme.rod).log_reflection

    @property
    def opening(self) -> float:
        """``1 - f = 2k/(k + Z)``, without cancellation."""
        return 2.0 * self.scheme.rod.damping * self.scheme.rod.input_gain

    @cached_property
    def stream(self) -> Array:
        """(2N,) what leaves the forward wave at the shifts ``0 .. 2N-1``; later ``f`` times what left 2N before."""
        N = self.scheme.cells
        return np.concatenate((self.waves[N - 1 :: -1], self.echo * self.waves[: N - 1 : -1]))

    @cached_property
    def sums(self) -> Array:
        """(2N+1,) ``R_r``, the first ``r`` terms of the stream added up."""
        return np.concatenate(([0.0], np.cumsum(self.stream)))

    def power(self, m: ArrayLike) -> Array:
        """``f^m`` for whole ``m >= 0``."""
        trips = np.asarray(m, dtype=float)
        with np.errstate(invalid="ignore", over="ignore"):
            size = np.where(trips == 0.0, 1.0, np.exp(trips * self.log_echo))
        return np.asarray(size if self.echo >= 0.0 else size * (1.0 - 2.0 * (trips % 2.0)))

    def series(self, m: ArrayLike) -> Array:
        """``1 + f + .. + f^{m-1}`` for whole ``m >= 0``."""
        trips = np.asarray(m, dtype=float)
        if self.opening == 0.0:
            return trips
        with np.errstate(invalid="ignore", over="ignore"):
            if self.echo > 0.0:
                return np.asarray(-np.expm1(trips * self.log_echo) / self.opening)
            return np.asarray((1.0 - self.power(trips)) / self.opening)

    def gaps(self, n: NDArray[np.int64]) -> Array:
        """``s z`` after ``n`` shifts: the start and the first ``n`` terms of the stream."""
        size = 2 * self.scheme.cells
        trips = n // size
        left = n - trips * size
        return np.asarray(self.gap + self.series(trips) * self.sums[-1] + self.power(trips) * self.sums[left])

    def leaving(self, n: NDArray[np.int64]) -> Array:
        """``Y_{N-n}``: what the last cell of the forward wave holds after ``n`` shifts."""
        size = 2 * self.scheme.cells
        trips = n // size
        return np.asarray(self.power(trips) * self.stream[n - trips * size])

    def largest_gap(self, trips: float = math.inf) -> float:
        """Bound of ``s z`` over the next ``trips`` round trips: the largest value after any number of shifts.

        ``s z`` is an average of these values with positive weights.  For ``|f| <= 1`` they are ``C + f^m (R_r - C)``
        with ``C = R_2N/(1 - f)``: extreme at ``m`` = 0, 1 or infinity; for ``f = 1`` they are ``m R_2N + R_r``.  For
        ``|f| > 1`` the bound is ``inf``.
        """
        if self.log_echo > 0.0:
            return math.inf
        trip, highest, lowest = float(self.sums[-1]), float(self.sums.max()), float(self.sums.min())
        if self.opening == 0.0:
            return self.gap + highest + (trip * trips if trip > 0.0 else 0.0)
        limit = trip / self.opening
        once = limit + self.echo * ((highest if self.echo > 0.0 else lowest) - limit)
        return self.gap + max(highest, limit, once)
