"""What one run of a loop shows: convergence, rest elsewhere, growth, undiminished oscillation, or nothing yet."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from analysis.refutation.trajectories import Finding, Reals

SETTLED = 1e-4
"""Share of its largest ``|sigma|`` below which a solution is said to converge to 0."""
RESTING = 1e-7
"""Variation of a solution at rest, relative to its largest ``|sigma|``."""
BALANCED = 1e-5
"""Imbalance of an equilibrium, relative to its terms."""
STEADY = 0.02
"""How much the amplitudes of the quarters of a stretch differ in an oscillation called undiminished."""
EXPLODED = 1e12
"""Growth over its first size after which a run ends."""
CROSSINGS = 8
_NOTHING = 1e-290


@dataclass(kw_only=True, slots=True, eq=False)
class Run:
    """One solution as far as it is followed, in the scaled time and coordinates of its loop.

    Attributes
    ----------
    start : ndarray
        (n,) first state.
    text : str
        The first state in words.
    t, sigma, states : list of ndarray
        Stretch by stretch, the last instant of one being the first of the next.
    finding : Finding
        So far.
    ended : bool
        Whether it need not be followed further.
    closed : bool
        Whether its oscillation was found to be periodic.
    attempts : int
        How often that was tried.
    """

    start: Reals
    text: str
    t: list[Reals] = field(default_factory=list)
    sigma: list[Reals] = field(default_factory=list)
    states: list[Reals] = field(default_factory=list)
    finding: Finding = Finding.OPEN
    ended: bool = False
    closed: bool = False
    attempts: int = 0

    @property
    def largest(self) -> float:
        """Largest finite ``|sigma|`` so far."""
        return max((_amplitude(part) for part in self.sigma), default=0.0)

    @property
    def until(self) -> float:
        """Last instant."""
        return float(self.t[-1][-1]) if self.t else 0.0


def _amplitude(values: Reals) -> float:
    seen = np.abs(values[np.isfinite(values)])
    return float(seen.max()) if seen.size else 0.0


def judge(run: Run, off_balance: Callable[[float], float]) -> None:
    """Set the finding of a run from what is followed of it, and whether it need not be followed further.

    Sizes are judged against the largest of the run itself: what the integrator or rounding leaves of a solution that
    has come to rest is neither growth nor oscillation.  Values that are not finite are never a decay.

    Parameters
    ----------
    run : Run
        With one more stretch than at the last call.
    off_balance : callable
        How far a value of ``sigma`` is from an equilibrium; 0 at one.
    """
    sigma, states = run.sigma[-1], run.states[-1]
    largest = run.largest
    first = max(_amplitude(run.sigma[0][: max(2, len(run.sigma[0]) // 8)]), _NOTHING)
    whole = bool(np.isfinite(states).all())
    lost = np.flatnonzero(~np.isfinite(sigma))
    if lost.size and np.isfinite(states[lost[0]]).all():
        run.ended, run.finding = True, Finding.UNSOLVABLE
        return
    size = float(np.abs(run.start).max())
    grown = max(largest / first, _amplitude(states) / max(size, _NOTHING))
    if not whole or grown > EXPLODED:
        run.ended = True
        run.finding = Finding.GROWS if grown > 1e6 else Finding.OPEN
        return
    last = sigma[len(sigma) // 2 :]
    if _amplitude(last) <= max(SETTLED * largest, _NOTHING):
        if _still(states):
            run.ended, run.finding = True, Finding.CONVERGES
        else:
            run.finding = Finding.OPEN
        return
    at_rest = float(np.ptp(last)) <= RESTING * largest and _still(states)
    if at_rest and abs(off_balance(float(last[-1]))) <= BALANCED:
        run.ended, run.finding = True, Finding.RESTS
        return
    run.finding = _trend(run)


def _still(states: Reals) -> bool:
    """Whether no state grows: the second half of the stretch is nowhere larger than the first, up to rounding."""
    half = len(states) // 2
    before, after = np.abs(states[:half]).max(axis=0), np.abs(states[half:]).max(axis=0)
    return bool((after <= 1.01 * before + 1e-6 * float(np.abs(states).max()) + _NOTHING).all())


def _trend(run: Run) -> Finding:
    """Undiminished oscillation or growth, as the last stretches suggest; else nothing."""
    sigma = run.sigma[-1]
    quarters = np.array_split(sigma, 4)
    middle = 0.5 * (float(sigma.max()) + float(sigma.min()))
    crossings = int(np.count_nonzero(np.diff(np.signbit(sigma - middle))))
    spans = [float(np.ptp(part)) for part in quarters]
    if max(spans) <= RESTING * run.largest:  # at a bend where solutions come to rest rounding leaves as much
        return Finding.OPEN
    if crossings >= CROSSINGS and min(spans) >= (1 - STEADY) * max(spans):
        return Finding.OSCILLATES
    sizes = [_amplitude(part[len(part) // 2 :]) for part in run.sigma]
    if len(sizes) >= 3 and sizes[-1] > 1.3 * sizes[-2] > 1.69 * sizes[-3] and spans[-1] > max(spans[:2]):
        return Finding.GROWS
    chaotic = len(sizes) >= 3 and crossings >= 4 * CROSSINGS and min(spans) >= 0.5 * max(spans)
    if chaotic and sizes[-1] >= 0.8 * sizes[-2] >= 0.64 * sizes[-3]:
        return Finding.OSCILLATES
    return Finding.OPEN


def steadiness(run: Run) -> float:
    """Least over largest oscillation in the eighths of the last stretch; 1 for one that does not change."""
    spans = [float(np.ptp(part)) for part in np.array_split(run.sigma[-1], 8)]
    return min(spans) / max(spans) if max(spans) > 0 else math.nan
