r"""The end of the rod on one segment of its law: ``z' = W - d p(z)`` for a given incoming wave.

With ``zeta = z - origin`` and time in transits ``T`` the equation of a straight segment is ``zeta' = T (W - push - rate
zeta)``.  It is linear, so that all pieces are solved at once, for the load and for the initial value, and then chained.
On a piece the solution is the polynomial with the given start that satisfies the equation at the Chebyshev extrema
except the left one: exact for polynomials of lower degree, stable for any stiffness (at ``rate -> inf`` it takes the
value ``W - push`` at the right end).  Where the boundary layer ``exp(-rate t)`` is not resolved the piece is cut at
multiples of ``3/rate``, and halved where that is not enough: the echoes of a layer after ``n`` round trips are Laguerre
functions, with ``n`` zeros.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lure.rod.motion.chebyshev import Array, basis, left_ends, right_ends, tails
from lure.rod.motion.end_law import Segment
from lure.rod.motion.pieces import NARROWEST, Pieces, union

RESOLVED = 3e-15
_LAYER = 3.0
_CUTS = 14
_ROUNDS = 12
_MOST_PIECES = 20_000
_EXPONENTIAL = 16
_GRAZE = 8e-15
_ULPS = 2e-15


@dataclass(frozen=True, kw_only=True, slots=True)
class Level:
    """A number with its rounding remainder: positions in free flight are sums of very many small travels."""

    value: float
    rest: float = 0.0

    def plus(self, travel: float) -> Level:
        """The sum, with what rounding lost kept in ``rest``."""
        small = travel + self.rest
        total = self.value + small
        back = total - self.value
        return Level(value=total, rest=(self.value - (total - back)) + (small - back))


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Arc:
    """The motion on consecutive pieces that one segment of the law governs.

    Attributes
    ----------
    wave : Pieces
        Incoming wave, on the pieces of the solution (time in transits) [m/s].
    zeta : ndarray
        (m, N+1) series of ``z - origin`` [m].
    push : ndarray
        (m, N+1) series of ``d p`` [m/s].
    end : Level
        ``z - origin`` at the end [m].
    error : float
        Estimate of what the series leave out of ``push``, times its duration [m/s transits].
    """

    wave: Pieces
    zeta: Array
    push: Array
    end: Level
    error: float


def flat_arc(segment: Segment, share: float, transit: float, wave: Pieces, start: Level) -> Arc:
    """Free flight, or constant stress: a quadrature."""
    space = basis(wave.series.shape[1] - 1)
    load = share * wave.series
    load[:, 0] -= segment.push
    zeta = (0.5 * transit * wave.widths)[:, None] * (load @ space.integral.T)
    zeta[:, 0] -= left_ends(zeta)  # what the term of degree N + 1, left out, has there
    travelled = np.concatenate(([0.0], np.cumsum(right_ends(zeta))))
    zeta[:, 0] += travelled[:-1] + start.rest
    zeta[:, 0] += start.value
    push = np.zeros_like(zeta)
    push[:, 0] = segment.push
    end = start.plus(float(travelled[-1]))
    return Arc(wave=wave, zeta=zeta, push=push, end=end, error=0.0)


def rigid_arc(share: float, wave: Pieces) -> Arc:
    """Held by a rigid obstacle: ``z`` does not move and takes up the whole wave."""
    still = np.zeros_like(wave.series)
    return Arc(wave=wave, zeta=still, push=share * wave.series, end=Level(value=0.0), error=0.0)


def straight_arc(segment: Segment, share: float, transit: float, wave: Pieces, start: Level) -> Arc:
    """A segment with a slope."""
    size = float(np.abs(wave.series).sum(axis=1).max(initial=0.0))
    first = start.value + start.rest
    allowed = RESOLVED * max((size + abs(segment.push)) * min(transit, 1.0 / segment.rate), abs(first))
    for attempt in range(_ROUNDS + 1):
        zeta, end = _linear(segment, share, transit, wave, first)
        given = 2.0 * share * min(transit, 1.0 / segment.rate) * tails(wave.series)  # what W itself leaves out
        rough = np.where(tails(zeta) > np.minimum(given, 3.0 * allowed), tails(zeta), 0.0)
        steps = segment.rate * transit * wave.widths
        coarse = np.flatnonzero((rough > allowed) & (wave.widths > NARROWEST))
        if not coarse.size or attempt == _ROUNDS or len(rough) > _MOST_PIECES:
            break
        wide = coarse[steps[coarse] > 1.01 * _LAYER]
        offsets = (_LAYER / (segment.rate * transit)) * np.arange(1, _CUTS)
        cuts = (wave.edges[wide][:, None] + offsets)[offsets < wave.widths[wide][:, None] * (1.0 - 1e-3)]
        halves = wave.edges[coarse] + 0.5 * wave.widths[coarse]
        wave = wave.on(
            union(
                wave.edges,
                np.sort(np.append(cuts, halves[steps[coarse] <= 1.01 * _LAYER])),
            )
        )
    push = segment.rate * zeta
    push[:, 0] += segment.push
    error = float((segment.rate * rough * wave.widths)[rough > allowed].sum())
    return Arc(wave=wave, zeta=zeta, push=push, end=Level(value=end), error=error)


def _linear(segment: Segment, share: float, transit: float, wave: Pieces, first: float) -> tuple[Array, float]:
    """Series of ``zeta``, and its value at the end."""
    space = basis(wave.series.shape[1] - 1)
    half = 0.5 * transit * wave.widths
    load = share * wave.series
    load[:, 0] -= segment.push
    driven = half[:, None] * (load @ space.at_ends[1:].T @ space.collocation.T)
    stiff = segment.rate * half
    ones = np.ones_like(driven)
    if float(stiff.max(initial=0.0)) < 0.05:
        forced, grown = driven, ones
        for _ in range(1 + _terms(2.0 * float(stiff.max(initial=0.0)))):
            forced = driven - stiff[:, None] * (forced @ space.collocation.T)
            grown = ones - stiff[:, None] * (grown @ space.collocation.T)
    else:
        system = np.eye(space.degree) + stiff[:, None, None] * space.collocation
        both: Array = np.asarray(np.linalg.solve(system, np.stack((driven, ones), axis=2)), dtype=float)
        forced, grown = both[:, :, 0], both[:, :, 1]
    starts, level = [], first
    for gain, added in zip(grown[:, -1].tolist(), forced[:, -1].tolist(), strict=True):
        starts.append(level)
        level = gain * level + added
    begun = np.array(starts)
    table = np.column_stack((begun, grown * begun[:, None] + forced))
    return table @ space.from_ends.T, level


def _terms(x: float) -> int:
    """Terms of ``exp(x)`` down to rounding."""
    n, term = 1, x
    while term > 1e-17 and n < _EXPONENTIAL:
        n += 1
        term *= x / n
    return n


def departure(segment: Segment, arc: Arc) -> tuple[list[tuple[int, Array]], float]:
    """Functions that become positive when the motion leaves the segment, with the step that takes, and their rounding.

    Returns
    -------
    functions : list of (int, ndarray)
        1 (upwards) or -1 (downwards) and the series (m, N+1).
    tolerance : float
        Rounding of the functions: an excursion that stays below it is none.
    """
    if math.isinf(segment.rate) or segment.power < 1.0:
        return [(-1, -arc.push)], _GRAZE * float(np.abs(arc.push).sum(axis=1).max(initial=0.0))
    found = []
    for step, bound in ((1, segment.high), (-1, segment.low)):
        if math.isfinite(bound):
            series = step * arc.zeta
            distance = bound - segment.origin
            series[:, 0] -= step * distance + _ULPS * abs(distance)
            found.append((step, series))
    return found, _GRAZE * float(np.abs(arc.zeta[:, 1:]).sum(axis=1).max(initial=0.0))
