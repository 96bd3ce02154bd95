"""A finding of a simulation computed again: more accurately, in exact arithmetic, or by Newton's method."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

from lure.analysis.counterexamples.simulated import graph_of
from lure.analysis.counterexamples.trajectories import BatchLoop, Finding, OutOfBudget
from lure.arrays import Reals, np
from lure.plants.rational import RationalPlant
from lure.record import described, quantity

# What one run of a loop shows: convergence, rest elsewhere, growth, undiminished oscillation, or nothing yet.

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


@described(kw_only=True, slots=True, eq=False)
class Run:
    """One solution as far as it is followed, in the scaled time and coordinates of its loop."""

    start: Reals = quantity("(n,) first state")
    text: str = quantity("The first state in words")
    t: list[Reals] = quantity(
        "Instants, stretch by stretch, the last of one being the first of the next", default_factory=list
    )
    sigma: list[Reals] = quantity("Input of the nonlinearity at these", default_factory=list)
    states: list[Reals] = quantity("State there", default_factory=list)
    finding: Finding = quantity("So far", default=Finding.OPEN)
    ended: bool = quantity("Whether it need not be followed further", default=False)
    closed: bool = quantity("Whether its oscillation was found to be periodic", default=False)
    attempts: int = quantity("How often that was tried", default=0)

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

    ``run``: with one more stretch than at the last call.  ``off_balance``: how far a value of ``sigma`` is from an
    equilibrium; 0 at one.
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


_RTOL = 1e-11
DELTA = 1e-6
ISOLATED = 1e-7
CLOSED, EXACT = 1e-8, 1e-13
"""By how much of its size a solution may miss its first state after a period: of an integrated one, of a sampled one.
With a nonlinearity of straight pieces a sampled solution that is almost periodic, at a slope below the least that
admits it by 1e-9 of itself, misses by 1e-9; one that is periodic, by nothing but rounding."""
CLEAR = 20.0
"""How far the least singular value of the map whose zero is a periodic solution stands out from the error of its
derivative; what does not is taken for a slow decay."""
DECAYS = 8.0
"""Time constants of the slowest linear gain after which an oscillation that has not shrunk is none of a slow decay."""
CLOSING = 10000
"""Evaluations granted to each search for a period."""
_BITS = 256
_LONGEST_EXACT = 400
_PERIODS = 64


def confirmed(block: RationalPlant, loop: BatchLoop, run: Run, slow: float) -> bool:
    """Whether a finding survives: beyond the error of the integrator, and not a slow decay.

    Parameters
    ----------
    block : RationalPlant
        The block.
    loop : BatchLoop
        Its loop, with evaluations left.
    run : Run
        A run with a finding.
    slow : float
        Slowest decay of a linear gain that the nonlinearity attains, modes at 0 left out, in the scaled time.
    """
    try:
        if run.finding is Finding.OSCILLATES:
            return run.closed or (lasts(run, slow) and _again(block, loop, run))
        if run.finding is Finding.RESTS:
            return _equilibrium(loop, float(run.sigma[-1][-1]))
        if run.finding is Finding.GROWS:
            grown = run.largest / max(float(np.abs(run.sigma[0][:2]).max()), 1e-290)
            lasting = slow < 0 or slow * run.until >= DECAYS
            return (grown > 1e9 or lasting) and _again(block, loop, run)
        return run.finding is Finding.UNSOLVABLE
    except OutOfBudget:
        return False


def lasts(run: Run, slow: float) -> bool:
    """Whether an oscillation outlasted what any linear gain of the nonlinearity would have made of it.

    ``run``: a run that seems to oscillate.  ``slow``: slowest decay of a linear gain that the nonlinearity attains in
    the scaled time; negative if one grows.
    """
    return abs(slow) * float(run.t[-1][-1] - run.t[-1][0]) / 2 >= DECAYS


def _again(block: RationalPlant, loop: BatchLoop, run: Run) -> bool:
    """The same finding from the same start with a tolerance a thousand times smaller, or in exact arithmetic."""
    twin = Run(start=run.start, text=run.text)
    for part in run.t:
        now = twin.states[-1][-1] if twin.states else twin.start
        if loop.discrete:
            states = _exactly(block, loop, now, len(part))
            times = np.arange(len(part), dtype=float)
        else:
            times, path = loop.advance(now[None, :], float(part[-1] - part[0]), len(part), _RTOL)
            states = path[0]
        twin.t.append(twin.until + times)
        twin.states.append(states)
        twin.sigma.append(loop.sigma_of(states)[0])
        judge(twin, loop.rests_at)
        if twin.ended or (twin.finding is Finding.GROWS is run.finding):
            break
    return twin.finding is run.finding


def _exactly(block: RationalPlant, loop: BatchLoop, start: Reals, count: int) -> Reals:
    """The recursion with 256 bits, where the nonlinearity is known exactly and the run is short; else in doubles."""
    graph = graph_of(loop.nonlinearity)
    if graph is None or loop.d != 0 or count > _LONGEST_EXACT:
        path = loop.advance(start[None, :], 0.0, count, _RTOL)[1]
        return np.asarray(path[0])
    system, x = block.realisation, [Fraction(float(v)) for v in start * loop.weights]
    found = np.empty((count, loop.order))
    for i in range(count):
        found[i] = np.array([float(v) for v in x]) / loop.weights
        phi = graph.exact(sum((c * v for c, v in zip(system.c, x, strict=True)), Fraction(0)))
        x = [
            _rounded(sum((a * v for a, v in zip(row, x, strict=True)), Fraction(0)) - b * phi)
            for row, b in zip(system.A, system.b, strict=True)
        ]
    return np.asarray(found)


def _rounded(value: Fraction) -> Fraction:
    shift = _BITS - value.numerator.bit_length() + value.denominator.bit_length()
    return Fraction(round(value * Fraction(2) ** shift)) / Fraction(2) ** shift


def _equilibrium(loop: BatchLoop, sigma: float) -> bool:
    """Whether an equilibrium lies beside ``sigma``, not 0: by a change of sign, or by an exact zero of a graph."""
    if loop.rests_at(sigma * 0.999) * loop.rests_at(sigma * 1.001) < 0:
        return True
    graph = graph_of(loop.nonlinearity)
    return loop.integrates and graph is not None and graph.exact(Fraction(sigma)) == 0


def closes(loop: BatchLoop, run: Run) -> bool:
    """Whether Newton's method finds a periodic solution where the run ends, isolated and as large as its oscillation.

    Of a slow decay the map over one period is close to the identity: Newton's method then leaps to 0, and nothing is
    found.

    ``loop``: the loop, with evaluations left; ``run``: a run that seems to oscillate.
    """
    guesses = _sampled_periods(run) if loop.discrete else _periods(run)
    swing = float(np.ptp(run.sigma[-1]))
    return any(periodic(loop, run.states[-1][-1], period, swing) for period in guesses)


def periodic(loop: BatchLoop, state: Reals, period: float, swing: float | None = None) -> bool:
    """Whether Newton's method finds an isolated periodic solution near a state.

    Parameters
    ----------
    loop : BatchLoop
        The loop.
    state : ndarray
        (n,) a state near the solution, in the coordinates of the loop.
    period : float
        Its period, about, in the scaled time.
    swing : float or None
        Largest less least ``sigma`` along it, within a factor of two; None for those of the solution from ``state``.
    """
    used, granted = loop.used, loop.budget
    loop.budget = used + CLOSING
    try:
        return _shoot(loop, state, period, swing)
    except OutOfBudget:
        return False
    finally:
        loop.used, loop.budget = used, granted


def _periods(run: Run) -> list[float]:
    """Periods suggested by the upward passages of the middle level, of one to four passages."""
    t, sigma = run.t[-1], run.sigma[-1]
    middle = 0.5 * (float(sigma.max()) + float(sigma.min()))
    level = sigma - middle
    up = np.flatnonzero((level[:-1] < 0) & (level[1:] >= 0))
    if len(up) < 6:
        return []
    times = t[up] - level[up] * (t[up + 1] - t[up]) / (level[up + 1] - level[up])
    laps = np.diff(times)
    gap = float(laps.mean())
    return [gap] if float(np.ptp(laps)) <= 0.05 * gap else [gap * count for count in (1, 2, 3, 4)]


def _sampled_periods(run: Run) -> list[float]:
    """Periods, in steps, after which the end of the run comes back best."""
    states = run.states[-1]
    size = float(np.abs(states[-_PERIODS:]).max())
    most = min(_PERIODS, len(states) // 2)
    miss = [float(np.abs(states[-1] - states[-1 - q]).max()) for q in range(1, most + 1)]
    return [float(q + 1) for q in np.argsort(miss)[:3] if miss[q] <= 0.05 * size]


def _shoot(loop: BatchLoop, state: Reals, period: float, swing: float | None) -> bool:
    size, n = float(np.abs(state).max()), loop.order
    x, span = state, period
    for _ in range(8):
        lap = _lap(loop, x, span, DELTA * size)
        if lap is None:
            return False
        swing = lap.swing if swing is None else swing
        if not 0.5 * swing <= lap.swing <= 2 * swing:
            return False
        least = float(np.linalg.svd(lap.jacobian, compute_uv=False)[-1])
        if least < ISOLATED:
            return False
        step = np.linalg.solve(lap.jacobian, -lap.gap)
        missed = float(np.abs(lap.gap).max()) / size
        if missed <= (EXACT if loop.discrete else CLOSED) and float(np.abs(step).max()) <= 1e-4 * size:
            again = _lap(loop, x, span, 3 * DELTA * size)
            noise = np.inf if again is None else float(np.linalg.norm(lap.jacobian - again.jacobian, 2))
            return least > CLEAR * noise
        x = x + step[:n]
        if not loop.discrete:
            span += lap.scale * float(step[n])
            if not 0.5 * period < span < 1.5 * period:
                return False
    return False


@dataclass(frozen=True, slots=True, eq=False)
class _Lap:
    """By how much a solution misses its first state after a time, and the derivative of that, bordered by its phase."""

    gap: Reals
    jacobian: Reals
    swing: float
    scale: float


def _lap(loop: BatchLoop, x: Reals, span: float, delta: float) -> _Lap | None:
    n, size = loop.order, float(np.abs(x).max())
    around = np.concatenate([x[None, :], x + delta * np.eye(n)])
    path = loop.advance(around, span, int(span) + 1 if loop.discrete else 65, _RTOL)[1]
    ends = path[:, -1]
    if not np.isfinite(ends).all():
        return None
    gap, jacobian = ends[0] - x, (ends[1:] - ends[0]).T / delta - np.eye(n)
    swing = float(np.ptp(loop.sigma_of(path[0])[0]))
    if loop.discrete:
        return _Lap(gap, jacobian, swing, 1.0)
    speed, first = (s @ loop.A.T - loop.sigma_of(s[None, :])[1] * loop.b for s in (ends[0], x))
    scale = size / max(float(np.abs(first).max()), 1e-290)
    phase = (first * scale / size)[None, :]
    bordered = np.block([[jacobian, scale * speed[:, None]], [phase, np.zeros((1, 1))]])
    return _Lap(np.append(gap, 0.0), bordered, swing, scale)
