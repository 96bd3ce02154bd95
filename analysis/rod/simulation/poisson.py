r"""Poisson averages: the exact solution of ``y' = (S - 1) y + b g`` from powers of ``S``.

If ``x_{n+1} = S x_n + b gamma_n`` then ``y(tau) = sum_n e^{-tau} tau^n/n! x_n`` solves ``y' = (S - 1) y + b g`` with
``g(tau) = sum_n e^{-tau} tau^n/n! gamma_n``: differentiate the weights.  For the upwind scheme in units of ``1/s``,
``S`` is the shift register of the rod at Courant number one, so that ``x_n`` costs nothing, and since the weights are
positive and sum to one nothing is lost to cancellation and ``y(tau)`` lies in the hull of the ``x_n``.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def poisson_columns(horizon: float) -> int:
    """Number of terms after which the Poisson weights of means up to ``horizon`` are below rounding."""
    return math.ceil(horizon + 9.0 * math.sqrt(horizon) + 18.0)


def poisson_rows(tau: ArrayLike, columns: int) -> Array:
    """Weights ``e^{-tau} tau^n / n!``, normalised to sum to one.

    Parameters
    ----------
    tau : array_like
        (k,) means, at most about 500.
    columns : int
        Number of terms, from :func:`poisson_columns`.

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
    values = np.empty((x.size, count))
    values[:, 0] = 1.0
    if count > 1:
        values[:, 1] = x
    for j in range(2, count):
        values[:, j] = 2.0 * x * values[:, j - 1] - values[:, j - 2]
    return values


def chebyshev_fit(count: int) -> Array:
    """Matrix (count, count) from values at :func:`chebyshev_points` to Chebyshev coefficients, by orthogonality."""
    fit = chebyshev_values(chebyshev_points(count), count).T * (2.0 / count)
    fit[0] *= 0.5
    return np.asarray(fit)


def chebyshev_sequences(count: int, length: float, columns: int) -> Array:
    r"""Sequences whose Poisson averages are the Chebyshev polynomials of ``[0, length]``.

    ``sum_n e^{-tau} tau^n/n! gamma_n = T_j(2 tau/length - 1)``: multiplying by ``tau`` turns ``gamma_n`` into
    ``n gamma_{n-1}``, so the three-term recurrence carries over.

    Parameters
    ----------
    count : int
        Number of polynomials.
    length : float
        End of the interval, in the unit of the mean.
    columns : int
        Number of terms of each sequence.

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
