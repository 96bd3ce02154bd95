r"""Poisson averages: the exact solution of ``y' = (S - 1) y + b g`` from powers of ``S``, and loads in them.

If ``x_{n+1} = S x_n + b gamma_n`` then ``y(tau) = sum_n e^{-tau} tau^n/n! x_n`` solves ``y' = (S - 1) y + b g`` with
``g(tau) = sum_n e^{-tau} tau^n/n! gamma_n``: differentiate the weights.  For the upwind scheme in units of ``1/s``,
``S`` is the shift register of the rod at Courant number one, so that ``x_n`` costs nothing, and since the weights are
positive and sum to one nothing is lost to cancellation and ``y(tau)`` lies in the hull of the ``x_n``.

Weights of large means are computed on the window outside which they are below rounding, for ``tau`` up to ``1e13``.
Written out, their exponent is a small difference of numbers of size ``tau log tau``; Stirling's formula takes that
difference analytically,

.. math:: \ln w_n = -\tau\,\phi\!\left(\tfrac{n - \tau}{\tau}\right) - \tfrac12 \ln 2\pi n - \delta_n, \qquad
    \phi(e) = (1 + e)\ln(1 + e) - e,

with ``delta_n = 1/(12 n) - ..`` the remainder of Stirling's formula.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from lure.arrays import Reals as Array
from lure.errors import InputError
from lure.record import described, quantity

LARGEST_MEAN = 1e13
_SERIES = 0.1
_TINY = 1e-290
_TERMS = 20
_STIRLING = 16


@described(frozen=True, kw_only=True, slots=True)
class Mean:
    """A mean ``tau = whole + rest`` with more digits than a double has."""

    whole: int = quantity("The nearest integer, nonnegative")
    rest: float = quantity("What is left, between -1/2 and 1/2")

    @property
    def value(self) -> float:
        """``tau`` as a double."""
        return float(self.whole) + self.rest


def mean_of(rate: float, time: float) -> Mean:
    """``rate * time`` without rounding.

    ``rate``: cell crossings per second [1/s]; ``time``: time, finite and not negative [s].

    Raises
    ------
    InputError
        The time is negative or not finite, or the product is outside the range of doubles.

    Examples
    --------
    >>> mean_of(6e8, 0.1).whole
    60000000
    """
    if not 0.0 <= time < math.inf:
        raise InputError(f"time is {time!r}; give a number of seconds from 0 on")
    product = Fraction(rate) * Fraction(time)
    if product > Fraction(10) ** 300:
        raise InputError(f"time is {time:g} s, more than 1e300 cell crossings; give a shorter one")
    return parted(product)


def parted(tau: float | Fraction) -> Mean:
    """A number as a :class:`Mean`."""
    whole = round(tau)
    return Mean(whole=whole, rest=float(tau - whole))


def window(mean: float) -> tuple[int, int]:
    """First and last ``n`` of the window: 9 standard deviations and 20 each way."""
    reach = 9.0 * math.sqrt(mean) + 20.0
    return max(0, math.floor(mean - reach)), math.ceil(mean + reach)


def poisson_weights(mean: Mean) -> tuple[int, Array]:
    """The first index of the window and the weights on it, which sum to one.

    ``mean``: at most ``1e13``: beyond it the window has more than 50 million terms.

    Raises
    ------
    InputError
        The mean is larger.

    Examples
    --------
    >>> first, weights = poisson_weights(Mean(whole=2, rest=0.0))
    >>> first, weights[:3].round(4)
    (0, array([0.1353, 0.2707, 0.2707]))
    """
    tau = mean.value
    if tau > LARGEST_MEAN:
        raise InputError(f"a Poisson mean of {tau:.3g} has too wide a window; give at most {LARGEST_MEAN:g}")
    first, last = window(tau)
    if tau < _TINY:
        return 0, np.ones(1)
    start = max(first, 1)
    n = np.arange(start, last + 1, dtype=float)
    away = (np.arange(start - mean.whole, last + 1 - mean.whole, dtype=float) - mean.rest) / tau
    weights = np.exp(-tau * _phi(away) - 0.5 * np.log(2.0 * math.pi * n) - _stirling(n))
    if first == 0:
        weights = np.concatenate(([math.exp(-tau)], weights))
    return first, weights / weights.sum()


def _phi(e: Array) -> Array:
    """``(1 + e) log(1 + e) - e``, by its series near 0."""
    near = np.abs(e) < _SERIES
    x = np.where(near, e, 0.0)
    total = np.zeros_like(x)
    for k in range(_TERMS, 1, -1):
        total = (1.0 if k % 2 == 0 else -1.0) / (k * (k - 1)) + x * total
    far = np.where(near, 1.0, e)
    return np.where(near, x * x * total, (1.0 + far) * np.log1p(far) - far)


def _stirling(n: Array) -> Array:
    """``delta_n = ln n! - (n + 1/2) ln n + n - ln(2 pi)/2``."""
    inverse = 1.0 / (n * n)
    remainder = (1.0 / 12.0 - inverse * (1.0 / 360.0 - inverse * (1.0 / 1260.0 - inverse / 1680.0))) / n
    for i in np.flatnonzero(n < _STIRLING):
        k = float(n[i])
        remainder[i] = math.lgamma(k + 1.0) - (k + 0.5) * math.log(k) + k - 0.5 * math.log(2.0 * math.pi)
    return np.asarray(remainder)


def poisson_columns(horizon: float) -> int:
    """Number of terms after which the Poisson weights of means up to ``horizon`` are below rounding."""
    return window(horizon)[1] + 4


def poisson_rows(tau: ArrayLike, columns: int) -> Array:
    """Weights ``e^{-tau} tau^n / n!``, normalised to sum to one.

    ``tau``: (k,) means, at most about 500; ``columns``: number of terms, from :func:`poisson_columns`.

    Returns
    -------
    ndarray
        (k, columns), each with a relative error of a few units of rounding.
    """
    means = np.asarray(tau, dtype=float).reshape(-1, 1)
    rows = np.empty((means.size, columns))
    rows[:, 0] = 1.0
    np.divide(means, np.arange(1.0, columns), out=rows[:, 1:])
    np.cumprod(rows, axis=1, out=rows)
    rows /= rows.sum(axis=1, keepdims=True)
    return rows


def chebyshev_points(count: int) -> Array:
    """Chebyshev points of the first kind on ``[0, 1]``, ascending; no endpoints."""
    return np.asarray(0.5 - 0.5 * np.cos(np.pi * (np.arange(count) + 0.5) / count))


def chebyshev_values(points: ArrayLike, count: int) -> Array:
    """Values ``T_0 .. T_{count-1}`` of the Chebyshev polynomials of ``[0, 1]`` at ``points``, (k, count)."""
    x = 2.0 * np.asarray(points, dtype=float) - 1.0
    return np.ascontiguousarray(np.polynomial.chebyshev.chebvander(x, count - 1))  # products round by the layout


def chebyshev_fit(count: int) -> Array:
    """Matrix (count, count) from values at :func:`chebyshev_points` to Chebyshev coefficients, by orthogonality."""
    fit = chebyshev_values(chebyshev_points(count), count).T * (2.0 / count)
    fit[0] *= 0.5
    return np.asarray(fit)


def chebyshev_sequences(count: int, length: float, columns: int) -> Array:
    r"""Sequences whose Poisson averages are the Chebyshev polynomials of ``[0, length]``.

    ``sum_n e^{-tau} tau^n/n! gamma_n = T_j(2 tau/length - 1)``: multiplying by ``tau`` turns ``gamma_n`` into
    ``n gamma_{n-1}``, so the three-term recurrence carries over.

    ``count``: number of polynomials; ``length``: in the unit of the mean; ``columns``: number of terms of each
    sequence.

    Returns
    -------
    ndarray
        (columns, count).  Terms far beyond ``length`` are extrapolations and large; their weights make up for it.
    """
    n = np.arange(columns, dtype=float)
    gamma = np.zeros((columns, count))
    gamma[:, 0] = 1.0
    for j in range(1, count):
        raised = -gamma[:, j - 1]
        raised[1:] += 2.0 / length * n[1:] * gamma[:-1, j - 1]
        gamma[:, j] = raised if j == 1 else 2.0 * raised - gamma[:, j - 2]
    return gamma
