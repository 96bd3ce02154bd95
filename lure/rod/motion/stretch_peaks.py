"""The largest stress of a stretch of round trips, by bounds that leave few of them to look into."""

from __future__ import annotations

import numpy as np

from lure.rod.motion.chebyshev import Array, left_ends, right_ends, upper_bounds
from lure.rod.motion.impacts import largest_value
from lure.rod.motion.stretch import CHUNK, Stretch


def running_peaks(stretch: Stretch) -> Array:
    """Largest stress (count,) [Pa] of the impact up to the end of each round trip."""
    segment, impact = stretch.powers.quiet.segment, stretch.impact
    best = -np.inf if impact is None else impact.peak_stress * stretch.mobility
    found = []
    for low in range(0, len(stretch), CHUNK):
        zeta = stretch.series(stretch.every(low, min(low + CHUNK, len(stretch))))[1]
        push = segment.rate * zeta
        push[:, :, 0] += segment.push
        flat = push.reshape(-1, push.shape[2])
        least = np.maximum(left_ends(flat), right_ends(flat)).reshape(push.shape[:2]).max(axis=1)
        most = upper_bounds(flat).reshape(push.shape[:2]).max(axis=1)
        before = np.maximum.accumulate(np.append(best, least))[:-1]
        for i in np.flatnonzero(most > np.maximum(before, least)):
            least[i] = max(least[i], largest_value(push[i]))
        found.append(np.maximum.accumulate(np.append(best, least))[1:])
        best = float(found[-1][-1])
    return np.concatenate(found) / stretch.mobility


def peak(stretch: Stretch, tops: Array, best: float) -> float:
    """The largest ``zeta`` of the stretch, given upper bounds (count,) round trip by round trip, and a value it has."""
    some = np.flatnonzero(tops > best)
    for low in range(0, len(some), CHUNK):
        X, rest = stretch.states_in(some[low : low + CHUNK])
        X[:, stretch.powers.quiet.waves] += rest
        zeta = stretch.series(X)[1]
        flat = zeta.reshape(-1, zeta.shape[2])
        flat = flat[flat[:, 0] + np.abs(flat[:, 1:]).sum(axis=1) > best]
        if len(flat):
            best = max(best, float(right_ends(flat).max()))
            flat = flat[upper_bounds(flat) > best]
        if len(flat):
            best = max(best, largest_value(flat))
    return best
