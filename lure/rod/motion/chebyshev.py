"""Chebyshev series on ``[-1, 1]``, many at once: fit, values, integral, restriction, bounds."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Basis:
    """Points and matrices of one degree ``N``; make one with :func:`basis`.

    Attributes
    ----------
    degree : int
        ``N``.
    inner : ndarray
        (N+1,) zeros of ``T_{N+1}``, ascending: data are read there, never on a jump at the end of a piece.
    ends : ndarray
        (N+1,) extrema of ``T_N``, ascending, both ends included.
    from_inner, from_ends : ndarray
        (N+1, N+1) from values at those points to coefficients.
    integral : ndarray
        (N+1, N+1) from coefficients to those of ``int_{-1}^x``, without its term of degree ``N+1``.
    derivative : ndarray
        (N+1, N+1) from coefficients to those of the derivative.
    collocation : ndarray
        (N, N) from values at ``ends[1:]`` to the integral from -1 of their interpolant there.
    at_ends, at_gauss : ndarray
        (N+1, N+1) from coefficients to values at ``ends`` and at the Gauss points.
    gauss, weights : ndarray
        (N+1,) Gauss points and weights.
    """

    degree: int
    inner: Array
    ends: Array
    from_inner: Array
    from_ends: Array
    integral: Array
    derivative: Array
    collocation: Array
    at_ends: Array
    at_gauss: Array
    gauss: Array
    weights: Array


@lru_cache(maxsize=8)
def basis(degree: int) -> Basis:
    """The points and matrices of the degree."""
    n = degree + 1
    inner = -np.cos(np.pi * (np.arange(n) + 0.5) / n)
    ends = -np.cos(np.pi * np.arange(n) / degree)
    ends[0], ends[-1] = -1.0, 1.0
    unit = np.eye(n)
    integral = np.column_stack([chebyshev.chebint(row, lbnd=-1)[:n] for row in unit])
    derivative = np.zeros((n, n))
    for k in range(1, n):
        derivative[:k, k] = chebyshev.chebder(unit[k])[:k]
    gauss, weights = np.polynomial.legendre.leggauss(n)
    right = _inverse(ends[1:], degree - 1)
    primitives = np.column_stack([chebyshev.chebint(column, lbnd=-1) for column in right.T])
    return Basis(
        degree=degree,
        inner=inner,
        ends=ends,
        from_inner=_inverse(inner, degree),
        from_ends=_inverse(ends, degree),
        integral=np.asarray(integral, dtype=float),
        derivative=derivative,
        collocation=np.asarray(chebyshev.chebvander(ends[1:], degree) @ primitives, dtype=float),
        at_ends=np.asarray(chebyshev.chebvander(ends, degree), dtype=float),
        at_gauss=np.asarray(chebyshev.chebvander(gauss, degree), dtype=float),
        gauss=gauss,
        weights=weights,
    )


def _inverse(points: Array, degree: int) -> Array:
    """From values at the points to coefficients."""
    return np.asarray(np.linalg.inv(chebyshev.chebvander(points, degree)), dtype=float)


def values(coefficients: Array, x: Array) -> Array:
    """Values (m, j) of m series (m, N+1) at their own points ``x`` (m, j), by Clenshaw's recurrence."""
    total, before = np.zeros_like(x), np.zeros_like(x)
    for k in range(coefficients.shape[1] - 1, 0, -1):
        total, before = 2.0 * x * total - before + coefficients[:, k, None], total
    return np.asarray(x * total - before + coefficients[:, 0, None])


def right_ends(coefficients: Array) -> Array:
    """Values (m,) at 1."""
    return np.asarray(coefficients.sum(axis=1))


def left_ends(coefficients: Array) -> Array:
    """Values (m,) at -1."""
    return np.asarray(coefficients[:, ::2].sum(axis=1) - coefficients[:, 1::2].sum(axis=1))


def restricted(coefficients: Array, low: Array, high: Array) -> Array:
    """The series (m, N+1) on ``[low, high]`` (m,), a part of ``[-1, 1]`` each, as series on ``[-1, 1]``."""
    space = basis(coefficients.shape[1] - 1)
    x = low[:, None] + 0.5 * (high - low)[:, None] * (space.inner + 1.0)
    return np.asarray(values(coefficients, x) @ space.from_inner.T)


def largest(coefficients: Array) -> float:
    """A bound on ``|f|`` for all series: the largest sum of ``|c_k|``."""
    return float(np.abs(coefficients).sum(axis=1).max(initial=0.0))


def tails(coefficients: Array) -> Array:
    """Size (m,) of the last two coefficients: what is left out is of that order or less if they fall off."""
    return np.asarray(np.abs(coefficients[:, -2:]).max(axis=1))


def upper_bounds(series: Array) -> Array:
    """Upper bounds (m,) on the largest value on each piece: the larger end where the derivative keeps its sign."""
    size = np.abs(series)
    top = series[:, 0] + size[:, 1:].sum(axis=1)
    ends = np.maximum(left_ends(series), right_ends(series))
    return np.where(directions(series) != 0, ends, top)


def directions(series: Array) -> Array:
    """1 or -1 (m,) where the function certainly rises or falls on the whole piece, else 0."""
    slope = series @ basis(series.shape[1] - 1).derivative.T
    rest = np.abs(slope[:, 1:]).sum(axis=1)
    return np.where(np.abs(slope[:, 0]) >= rest, np.sign(slope[:, 0]), 0.0)
