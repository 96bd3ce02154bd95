"""One round trip in which nothing happens: what ``z`` does in it, linear in the wave and in ``z`` at its start."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lure.rod.motion.chebyshev import Array
from lure.rod.motion.end_law import Segment

_SMALL = 1e-19
_MORE = 10


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Coefficients:
    """The physical numbers of a map: see :class:`lure.rod.motion.windows.Problem`; ``d`` is reduced by the share."""

    transit: float
    share: float
    echo: float
    area: float
    mobility: float
    impedance: float


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Quiet:
    """Functions of the state of one round trip.

    Attributes
    ----------
    edges : ndarray
        (P+1,) of the pieces.
    degree : int
        Of ``W`` on a piece.
    segment : Segment
        Of the law.
    own, start, level : ndarray
        ``z`` on a piece less ``z`` where the piece begins: (P, K, degree+1) per coefficient of ``W`` on it, (P, K) per
        ``zeta`` there, (P, K) constant.
    begins, begin : ndarray
        ``zeta`` where the pieces begin, and at the end, less that at the start of the round trip: (P+1, S) per ``X``,
        (P+1,) constant.
    travel, steady : ndarray
        Series of ``zeta`` less ``zeta`` at the start of the round trip: (P, K, S) per ``X``, (P, K) constant.
    """

    edges: Array
    degree: int
    segment: Segment
    own: Array
    start: Array
    level: Array
    begins: Array
    begin: Array
    travel: Array
    steady: Array

    @property
    def pieces(self) -> int:
        """P."""
        return len(self.edges) - 1

    @property
    def waves(self) -> int:
        """Place of ``zeta`` in ``X``, after those of ``W``."""
        return self.pieces * (self.degree + 1)

    @property
    def size(self) -> int:
        """S."""
        return int(self.begins.shape[1])


def _travel(found: tuple[Array, Array, Array], begins: Array, begin: Array) -> tuple[Array, Array]:
    """``travel`` and ``steady``."""
    own, start, level = found
    P, n = len(own), own.shape[2]
    series = start[:, :, None] * begins[:-1, None, :]
    series[:, :, P * n] += start
    for p in range(P):
        series[p, :, p * n : (p + 1) * n] += own[p]
    series[:, 0] += begins[:-1]
    constant = level + start * begin[:-1, None]
    constant[:, 0] += begin[:-1]
    return series, constant


def quiet(segment: Segment, edges: Array, degree: int, numbers: Coefficients) -> Quiet | None:
    """The functions on a segment that is straight; None if ``zeta`` needs a much higher degree than ``W``."""
    half = 0.5 * numbers.transit * np.diff(edges)
    stiff, n = segment.rate * half, degree + 1
    more, term = 1, float(stiff.max())
    while term > _SMALL and more < _MORE:
        more += 1
        term *= float(stiff.max()) / (2.0 * more)
    if term > _SMALL:
        return None
    K = n + (1 if segment.rate == 0.0 else 1 + more)
    integral = _integral(K)
    driven = half[:, None, None] * integral[:, :n]
    pushed = -segment.push * half[:, None] * integral[:, 0]
    held = -stiff[:, None] * integral[:, 0]
    if segment.rate > 0.0:
        system = np.eye(K) + stiff[:, None, None] * integral
        right = np.concatenate((numbers.share * driven, held[:, :, None], pushed[:, :, None]), axis=2)
        found = np.asarray(np.linalg.solve(system, right), dtype=float)
        own, start, level = found[:, :, :n], found[:, :, n], found[:, :, n + 1]
    else:
        own, start, level = numbers.share * driven, held, pushed
    P = len(half)
    size = P * n + (2 if segment.touching else 1)
    begins, begin = np.zeros((P + 1, size)), np.zeros(P + 1)
    held_ends, own_ends, level_ends = start.sum(axis=1), own.sum(axis=1), level.sum(axis=1)
    if segment.rate == 0.0:
        own_ends = 2.0 * numbers.share * half[:, None] * mean_values(n)  # nothing, not rounding, for odd degrees
        for p in range(P):
            begins[p + 1 :, p * n : (p + 1) * n] = own_ends[p]
        begin[1:] = np.cumsum(level_ends)
    else:
        for p in range(P):
            begins[p + 1] = (1.0 + held_ends[p]) * begins[p]
            begins[p + 1, P * n] += held_ends[p]
            begins[p + 1, p * n : (p + 1) * n] += own_ends[p]
            begin[p + 1] = (1.0 + held_ends[p]) * begin[p] + level_ends[p]
    travel, steady = _travel((own, start, level), begins, begin)
    return Quiet(
        edges=edges,
        degree=degree,
        segment=segment,
        own=own,
        start=start,
        level=level,
        begins=begins,
        begin=begin,
        travel=travel,
        steady=steady,
    )


def _integral(size: int) -> Array:
    """(size, size) from coefficients to those of the integral from -1, without its last term."""
    matrix = np.zeros((size, size))
    for j in range(size):
        if j + 1 < size:
            matrix[j + 1, j] = (2.0 if j == 0 else 1.0) / (2.0 * (j + 1))
        if j > 1:
            matrix[j - 1, j] = -1.0 / (2.0 * (j - 1))
        # the value at -1 of the primitive, with its last term, is taken off
        low = (-1.0) ** (j + 1) * (2.0 if j == 0 else 1.0) / (2.0 * (j + 1))
        if j > 1:
            low -= (-1.0) ** (j - 1) / (2.0 * (j - 1))
        matrix[0, j] -= low
    return matrix


def mean_values(size: int) -> Array:
    """Means of ``T_k`` over ``[-1, 1]``."""
    k = np.arange(size)
    return np.where(k % 2 == 0, 1.0 / (1.0 - np.where(k % 2 == 0, k, 0.0) ** 2), 0.0)
