r"""The end of the rod against a power law, ``z' = W - d c_n max(z, 0)^m``: collocation with adaptive pieces.

On a piece ``z`` is the polynomial with the given start that satisfies the equation at the Chebyshev extrema except the
left one (stiffly accurate); Newton's method finds it.  A piece is kept if the last coefficients of ``z`` and of the
stress have fallen to rounding, and cut otherwise: near contact and release, where a power that is no whole number is
not smooth, pieces shrink geometrically.
"""

from __future__ import annotations

import numpy as np

from lure.errors import AssumptionError
from lure.rod.motion.chebyshev import Array, basis, values
from lure.rod.motion.end_law import Segment
from lure.rod.motion.pieces import Pieces
from lure.rod.motion.segment_motion import Arc, Level

_STRESS, _PLACE = 3e-14, 3e-15
_PULL = -1e-12
_NARROWEST = 1e-11
_ITERATIONS = 40
_MOST_PIECES = 2000
_THINNEST = 3e-11


def power_arc(segment: Segment, share: float, transit: float, wave: Pieces, start: Level) -> Arc:
    """The motion until the end of the wave, or on to the first piece after which the obstacle is left.

    Raises
    ------
    AssumptionError
        The law is too stiff for double precision, or needs more than 2000 pieces.
    """
    space = basis(wave.series.shape[1] - 1)
    size = share * float(np.abs(wave.series).sum(axis=1).max(initial=0.0))
    with np.errstate(over="ignore", under="ignore"):
        depth = float(np.float64(size / segment.rate) ** (1.0 / segment.power))
    if depth < _THINNEST * transit * size:
        raise AssumptionError(
            f"a wave of {size:.3g} m/s is stopped by the power law m = {segment.power:g} within {depth:.1g} m, too "
            "short for double precision; give a larger compliance, or a rigid obstacle"
        )
    zeta, edges = start.value + start.rest, [float(wave.edges[0])]
    rows: list[Array] = []
    pushes: list[Array] = []
    error, width = 0.0, np.inf
    for i, series in enumerate(wave.series):
        low, high = float(wave.edges[i]), float(wave.edges[i + 1])
        at = low
        while at < high:
            rest = high - at
            step = rest if width >= 0.75 * rest else width
            x = 2.0 * ((at - low) + 0.5 * step * (space.ends + 1.0)) / (high - low) - 1.0
            incoming = share * values(series[None, :], x[None, :])[0]
            table, push = _solved(segment, transit * 0.5 * step, incoming, zeta)
            narrow = step <= _NARROWEST
            if not np.isfinite(table).all():
                width = 0.25 * step
                if narrow:
                    table, push = np.full(len(x), zeta), incoming.copy()
                else:
                    continue
            place, stress = space.from_ends @ table, space.from_ends @ push
            miss = np.abs(stress[-2:]).max() / _STRESS, np.abs(place[-2:]).max() / (_PLACE * transit)
            if max(miss) > size and not narrow:
                width = (0.5 if max(miss) < 1e3 * size else 0.25) * step
                continue
            error += step * float(np.abs(stress[-2:]).max())
            at = high if step == rest else at + step
            if len(rows) == _MOST_PIECES:
                raise AssumptionError(
                    f"contact with the power law m = {segment.power:g} needs more than {_MOST_PIECES} pieces in a "
                    "round trip; give another compliance, stiffer or softer, or m = 1"
                )
            edges.append(at)
            rows.append(place)
            pushes.append(stress)
            zeta, width = float(table[-1]), (4.0 if max(miss) < 1e-2 * size else 2.0) * step
            if zeta < -4e-16 * transit * size if segment.power > 1.0 else push[-1] < _PULL * size:
                return _arc(wave, edges, (rows, pushes), zeta, error)
    return _arc(wave, edges, (rows, pushes), zeta, error)


def _arc(wave: Pieces, edges: list[float], series: tuple[list[Array], list[Array]], end: float, error: float) -> Arc:
    zeta, push = (np.array(rows) for rows in series)
    return Arc(wave=wave.on(np.array(edges)), zeta=zeta, push=push, end=Level(value=end), error=error)


def _solved(segment: Segment, half: float, incoming: Array, start: float) -> tuple[Array, Array]:
    """Values of ``zeta`` and of the push at the extrema; nan if Newton's method does not settle."""
    space = basis(len(incoming) - 1)
    K, m, rate = half * space.collocation, segment.power, segment.rate
    free = start + K @ incoming[1:]
    scale = float(np.abs(free).max())
    if scale == 0.0:
        return np.zeros(len(incoming)), np.zeros(len(incoming))
    with np.errstate(all="ignore"):
        at_rest = np.maximum(incoming[1:], 1e-9 * np.abs(incoming).max())
        for push in (rate * np.maximum(free, 1e-3 * scale) ** m, at_rest):
            place = (push / rate) ** (1.0 / m) if push is at_rest or m < 1.0 else free
            found = _in_push(segment, K, push, free) if m < 1.0 else _in_place(segment, K, place, free)
            if found is not None:
                return _in_stress(found, K, segment, start)
    return np.full(len(incoming), np.nan), np.zeros(len(incoming))


def _in_place(segment: Segment, K: Array, z: Array, free: Array) -> tuple[Array, Array, Array, Array] | None:
    """Newton's method in ``z``, for ``m > 1``: place, push, slope and miss."""
    m, rate, scale, last = segment.power, segment.rate, float(np.abs(free).max()), np.inf
    for _ in range(_ITERATIONS):
        inside = np.maximum(z, 0.0)
        push = rate * inside**m
        slope = rate * m * inside ** (m - 1.0)
        miss = z + K @ push - free
        size = float(np.abs(miss).max())
        if not size <= 1e6 * scale:
            return None
        if size <= 2e-16 * scale or (size <= 1e-13 * scale and size >= 0.5 * last):
            return z, push, slope, miss
        last = size
        z = z - np.linalg.solve(np.eye(len(z)) + K * slope, miss)
    return None


def _in_push(segment: Segment, K: Array, push: Array, free: Array) -> tuple[Array, Array, Array, Array] | None:
    """Newton's method in the push, for ``m < 1``, whose slope is infinite at contact; the law made odd below zero."""
    n, rate, scale, last = 1.0 / segment.power, segment.rate, float(np.abs(free).max()), np.inf
    for _ in range(_ITERATIONS):
        share = np.abs(push) / rate
        z = np.sign(push) * share**n
        softness = n * share ** (n - 1.0) / rate
        miss = z + K @ push - free
        size = float(np.abs(miss).max())
        if not size <= 1e6 * scale:
            return None
        if size <= 2e-16 * scale or (size <= 1e-13 * scale and size >= 0.5 * last):
            return z, push, np.where(softness > 1e-200, 1.0 / np.maximum(softness, 1e-200), 1e200), miss
        last = size
        push = push - np.linalg.solve(np.diag(softness) + K, miss)
    return None


def _in_stress(
    found: tuple[Array, Array, Array, Array], K: Array, segment: Segment, start: float
) -> tuple[Array, Array]:
    """The solution after one correction of the push: rounding of ``z`` times a large stiffness would spoil it."""
    z, push, slope, miss = found
    n = 1.0 / segment.power
    softness = np.where(slope > 0.0, 1.0 / np.where(slope > 0.0, slope, 1.0), 1e200)
    better = push - np.linalg.solve(np.diag(softness) + K, miss)
    if segment.power > 1.0:
        better = np.maximum(better, 0.0)
    stiff = slope * np.abs(K).max() > 1.0
    place = np.where(stiff, np.sign(better) * (np.abs(better) / segment.rate) ** n, z)
    return np.append(start, place), np.append(segment.rate * max(start, 0.0) ** segment.power, better)
