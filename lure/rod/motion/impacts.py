"""Impacts: when the end touches the obstacle, with which impulse and which largest stress."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lure.rod.motion.chebyshev import Array, basis, restricted, upper_bounds


@dataclass(frozen=True, kw_only=True, slots=True)
class Impact:
    """One contact.

    Attributes
    ----------
    start, end : float
        From contact to release [s].
    impulse : float
        ``A int p dt`` [N s].
    peak_stress : float
        Largest ``p`` [Pa].
    closed : bool
        Whether the end has left the obstacle; if not, ``end`` is where the motion ends or the start of the window after
        which it goes on.
    """

    start: float
    end: float
    impulse: float
    peak_stress: float
    closed: bool

    def to_dict(self) -> dict[str, object]:
        """The contact as plain JSON data; None where the method does not tell."""
        from lure.rod.datasets import impact_dicts

        return impact_dicts((self,))[0]

    def _repr_html_(self) -> str:
        from lure.rod.motion.sampling import impact_html

        return impact_html(self)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Touch:
    """Contact on consecutive pieces, in units of the window.

    Attributes
    ----------
    start, end : float
        From when to when [s].
    widths : ndarray
        (m,) lengths of the pieces [s].
    push : ndarray
        (m, N+1) series of ``d p`` [m/s].
    """

    start: float
    end: float
    widths: Array
    push: Array


def with_touch(impact: Impact | None, touch: Touch, area: float, mobility: float) -> Impact:
    """The open impact, or a new one, continued by a touch."""
    degree = touch.push.shape[1] - 1
    k = np.arange(0, degree + 1, 2)
    mean = touch.push[:, ::2] @ (1.0 / (1.0 - k.astype(float) ** 2))
    impulse = area / mobility * float(mean @ touch.widths)
    peak = largest_value(touch.push) / mobility
    if impact is None:
        return Impact(start=touch.start, end=touch.end, impulse=impulse, peak_stress=peak, closed=False)
    return replace(impact, end=touch.end, impulse=impact.impulse + impulse, peak_stress=max(impact.peak_stress, peak))


def largest_value(series: Array) -> float:
    """The largest value on any piece, to rounding: pieces that may hold it are halved while a bound exceeds the best.

    >>> largest_value(np.array([[0.0, 0.5, -0.5]]))  # -x^2 + x/2 + 1/2 is largest at x = 1/4
    0.5625
    """
    space = basis(series.shape[1] - 1)
    best = -np.inf
    for _ in range(40):
        sampled = series @ space.at_ends.T
        best = max(best, float(sampled.max(initial=-np.inf)))
        size = float(np.abs(series).sum(axis=1).max(initial=0.0))
        open_ = series[upper_bounds(series) > best + 1e-15 * size]
        if not len(open_):
            break
        low, high = np.full(len(open_), -1.0), np.zeros(len(open_))
        series = np.concatenate((restricted(open_, low, high), restricted(open_, high, -low)))
    return best
