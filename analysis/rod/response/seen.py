"""What a watched motion shows: its kind, its impacts, its momentum, its spectrum, and how fast two motions part."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from typing import Literal

import numpy as np
from scipy.integrate import quad

from lure.analysis.rod.response.recording import Recording
from lure.arrays import Reals as Array
from lure.errors import InputError
from lure.expressions import Expression
from lure.record import Record, derived, quantity
from lure.record import Record as Result
from lure.rod.scenario import Scenario

# Two motions that part: how fast a small difference grows, as it was seen.
#
# A second motion gets a small push ``delta g(t)`` for one period when the watch begins; up to then the two are the same
# to the last bit.  The slope of ``ln sup |z_2 - z_1|`` over the periods is observed evidence about these two motions.
# It estimates the largest Lyapunov exponent of the motion if that exists and the run is long enough, and proves neither
# that the motion is chaotic nor that it is not.

PUSH = 1e-9
_NOISE, _LARGE = 1e-13, 1e-2
_FEWEST = 4


class Separation(Record):
    """How the distance of two nearby motions changed."""

    distance: Array = quantity("(R,) largest ``|z_2 - z_1|`` in each period of the watch", "m")
    rate: float = quantity(
        "Slope of its logarithm over ``periods`` [1/s]; negative if the motions come together; nan if there were "
        "fewer than 4 periods above rounding and below a hundredth of the range of ``z``"
    )
    periods: tuple[int, int] = quantity("First period used, and the one after the last")

    def __str__(self) -> str:
        first, last = self.periods
        if np.isnan(self.rate):
            return "The distance of two nearby motions left the range in which a rate can be read within 4 periods."
        what = "grew" if self.rate > 0 else "shrank"
        return (
            f"The distance of two nearby motions {what} at {abs(self.rate):.4g} 1/s on average, as seen over periods "
            f"{first + 1} to {last}."
        )


def pushed(scenario: Scenario, start: float, period: float) -> Scenario:
    """The scenario with its force enlarged by 1e-9 of itself for one period.

    ``scenario``: it must have a force; ``start``, ``period``: when the push begins, and how long it lasts [s].

    Raises
    ------
    InputError
        There is no force, or its formula leaves no room for the push.
    """
    force = scenario.force
    if force.is_zero:
        raise InputError("force.g is zero; a separation is measured with a push of the force, give a force or leave it")
    text = f"({force})*(1 + where(t < {start!r}, 0, where(t < {start + period!r}, {PUSH!r}, 0)))"
    return replace(scenario, force=Expression.parse(text, variables=("t",), field="force.g"))


def separation(first: Array, second: Array, period: float) -> Separation:
    """The rate at which two motions part.

    ``first``, ``second``: (R, q) samples of ``z``: ``q`` phases of ``R`` periods [m]; ``period``: of the force [s].
    """
    distance = np.abs(second - first).max(axis=1)
    size, level = float(np.ptp(first)), float(np.abs(first).max())
    readable = (distance > max(_NOISE * level, 1e-300)) & (distance < _LARGE * size)
    start = 1  # the push itself lasts one period
    stop = start + int(np.argmin(np.append(readable[start:], False)))
    rate = np.nan
    if stop - start >= _FEWEST:
        rate = float(np.polyfit(np.arange(start, stop), np.log(distance[start:stop]), 1)[0]) / period
    return Separation(distance=distance, rate=rate, periods=(start, stop))


# What kind of motion was seen: at rest, repeating, drifting, or none of these within the run.

Kind = Literal["rest", "periodic", "drifting", "not seen to repeat"]
Trend = Literal["over", "died out", "still approaching", "still changing", "no trend seen"]
_TIMES = 4
_ROUNDING = 1e-12


class Regime(Record):
    """A motion as it was seen, over a finite time and from one start; it says nothing of other starts."""

    kind: Kind = quantity(
        "``drifting`` is periodic but for the same step in every period: a rod that is pulled away from its "
        "obstacle. ``not seen to repeat`` is no proof that the motion is not periodic: the period may be longer "
        "than a quarter of the run, or the motion not yet there",
        key="regime",
    )
    multiple: int | None = quantity(
        "``n``: it repeats after ``n`` periods of the force and was not seen to after fewer; None if it does not"
    )
    mismatch: float = quantity(
        "Largest distance of ``z`` from the last ``n`` periods, over all phases of the periods that were seen to "
        "repeat, relative to ``range``; for the best ``n`` and all periods if the motion was not seen to repeat [-]"
    )
    seen: int = quantity("Number of the last periods that agree", key="periods_seen")
    range: float = quantity("Largest minus least ``z`` during the watch, without the drift", "m", key="range_m")
    step: float = quantity("Drift of ``z`` in a period of the force", "m", key="drift_m_per_period", default=0.0)

    def __str__(self) -> str:
        if self.kind == "rest":
            moved = f"moves by {self.range:.3g} m in all" if self.range else "does not move"
            return f"At rest: z {moved} during the {self.seen} periods watched."
        if self.multiple is None:
            return (
                f"Not seen to repeat: no multiple of the period of the force brings z back to better than "
                f"{self.mismatch:.2g} of its range during the watch.  This does not prove that the motion is chaotic."
            )
        often = "every period" if self.multiple == 1 else f"every {self.multiple} periods"
        drift = f", but for a drift of {self.step:.4g} m a period" if self.kind == "drifting" else ""
        return (
            f"Repeats {often} of the force{drift}, to {self.mismatch:.2g} of its range, seen over {self.seen} periods."
        )


class Transients(Record):
    """Whether the motion was still changing: the four quarters of the watch compared."""

    trend: Trend = quantity(
        "``over``: the motion repeats from the first period watched on (or is at rest). ``died out``: it repeats "
        "since later in the watch. ``still approaching``: it comes closer to repeating from quarter to quarter, "
        "to less than half of the first and a tenth of its range. ``still changing``: the mean or the size of "
        "``z`` moves one way through the four quarters, by more than a fifth of its size",
        key="transients",
    )
    means: tuple[float, ...] = quantity("Mean of ``z`` in each quarter", "m", key="")
    sizes: tuple[float, ...] = quantity("Standard deviation of ``z`` in each quarter", "m", key="")
    mismatches: tuple[float, ...] = quantity(
        "How far ``z`` is from ``n`` periods before, relative to its range, largest in each quarter, for the "
        "``n`` that fits the last quarter best [-]",
        key="",
    )

    def __str__(self) -> str:
        return {
            "over": "Transients are over: the motion is the same from the start of the watch to its end.",
            "died out": "Transients died out during the watch, before the periods that were seen to repeat.",
            "still approaching": "Transients are not over: the motion still comes closer to repeating; settle longer.",
            "still changing": "The motion was still changing during the watch; settle longer.",
            "no trend seen": "No trend was seen between the four quarters of the watch.",
        }[self.trend]


def observed_regime(table: Array, *, tolerance: float, unloaded: bool) -> tuple[Regime, Transients]:
    """Classify a motion from its samples.

    ``table``: (R, q) values of ``z``, ``q`` phases of ``R`` periods [m]; ``tolerance``: how closely it must repeat,
    relative to its range; ``unloaded``: whether all loads are constant, a motion that does not move being at rest then.
    """
    size = float(np.ptp(table))
    rounding = _ROUNDING * float(np.abs(table).max())
    if size <= rounding or (unloaded and size <= tolerance * float(np.abs(table).max())):
        regime = Regime(kind="rest", multiple=None, mismatch=0.0, seen=len(table), range=size)
        return regime, _transients(table, regime, 1)
    found = _repeating(table, tolerance, rounding)
    if found is None:
        step = float(table[-1].mean() - table[0].mean()) / (len(table) - 1)
        level = table - step * (np.arange(len(table))[:, None] + np.arange(table.shape[1]) / table.shape[1])
        drifting = _repeating(level, tolerance, rounding) if abs(step) > tolerance * size else None
        if drifting is not None:
            found, table = replace(drifting, kind="drifting", step=step), level
    if found is not None:
        return found, _transients(table, found, found.multiple or 1)
    multiple = _best(table)
    worst = float(np.abs(table[multiple:] - table[:-multiple]).max()) / size
    regime = Regime(kind="not seen to repeat", multiple=None, mismatch=worst, seen=0, range=size)
    return regime, _transients(table, regime, multiple)


def _repeating(table: Array, tolerance: float, rounding: float) -> Regime | None:
    """The least ``n`` for which the last periods, half of the run and ``4 n`` at least, agree with the last ``n``."""
    periods, size = len(table), float(np.ptp(table))
    allowed = max(tolerance * size, rounding)
    for n in range(1, periods // _TIMES + 1):
        rows = np.arange(periods)
        last = table[periods - n + (rows - periods) % n]
        close = np.abs(table - last).max(axis=1) <= allowed
        seen = periods if close.all() else int(np.argmin(close[::-1]))
        if seen >= max(_TIMES * n, periods // 2):
            miss = float(np.abs(table - last)[periods - seen :].max()) / size
            return Regime(kind="periodic", multiple=n, mismatch=miss, seen=seen, range=size)
    return None


def _best(table: Array) -> int:
    """The ``n`` for which the last quarter comes closest to ``n`` periods before."""
    quarter = max(len(table) // 4, 1)
    misses = [
        float(np.abs(table[-quarter:] - table[-quarter - n : len(table) - n]).max())
        for n in range(1, max(len(table) // _TIMES, 1) + 1)
    ]
    return 1 + int(np.argmin(misses))


def _transients(table: Array, regime: Regime, multiple: int) -> Transients:
    quarters = np.array_split(np.arange(len(table)), 4)
    means = tuple(float(table[rows].mean()) for rows in quarters)
    sizes = tuple(float(table[rows].std()) for rows in quarters)
    away = np.abs(table[multiple:] - table[:-multiple]).max(axis=1) / (regime.range or 1.0)
    mismatches = tuple(float(part.max(initial=0.0)) for part in np.array_split(away, 4))
    return Transients(
        trend=_trend(regime, len(table), (means, sizes, mismatches)), means=means, sizes=sizes, mismatches=mismatches
    )


def _trend(regime: Regime, periods: int, quarters: tuple[tuple[float, ...], ...]) -> Trend:
    means, sizes, mismatches = quarters
    if regime.kind != "not seen to repeat":
        return "over" if regime.seen == periods else "died out"
    if mismatches[-1] < min(0.1, 0.5 * mismatches[0]) and all(b < a for a, b in pairwise(mismatches)):
        return "still approaching"
    moved = any(
        abs(values[-1] - values[0]) > 0.2 * max(sizes) and np.all(np.diff(values) * (values[-1] - values[0]) > 0.0)
        for values in (means, sizes)
    )
    return "still changing" if moved else "no trend seen"


class Impulses(Result):
    """Impacts that begin during the watch; statistics over those that also end in it."""

    count: int = quantity("Contacts that begin", key="impacts")
    unfinished: int = quantity("Of these, contacts that have not ended", key="")
    per_period: float = quantity("``count`` per period of the force", "1", key="impacts_per_period")
    mean: float = quantity("Mean of ``A int p dt`` of one contact [N s]; nan without any", key="impulse_mean_Ns")
    deviation: float = quantity("Its standard deviation [N s]; nan without any", key="impulse_deviation_Ns")
    least: float = quantity("The least of them [N s]; nan without any", key="impulse_least_Ns")
    largest: float = quantity("The largest of them [N s]; nan without any", key="impulse_largest_Ns")
    peak_stress: float = quantity("Largest contact stress of them all [Pa]; 0 without any", key="peak_stress_Pa")


class Balance(Result):
    """Momentum per period of the force [N s], averaged over the last periods watched, a whole number of repetitions.

    In a motion that repeats the dashpots take none on average, since ``k int u_t dt`` is ``k`` times the change of
    ``u``, and momentum comes back: **the mean contact impulse is that of the force.**  So a force of mean 0 has no
    periodic response with contact: the rod walks away from the obstacle until it no longer reaches it.
    """

    contact: float = quantity("``A int p dt``, by integration of the motion")
    force: float = quantity("``int g dt``, by quadrature of the formula")
    dashpot: float = quantity("``k int u_t(t, 0) dt + k_L int u_t(t, L) dt``")

    @property
    @derived()
    def left(self) -> float:
        """``force - dashpot - contact``: the gain of momentum per period."""
        return self.force - self.dashpot - self.contact


class Spectrum(Result):
    """Amplitudes of ``z`` during the watch."""

    frequency: Array = quantity("frequency, from 0 on", "Hz", dims="frequency")
    amplitude: Array = quantity(
        "amplitude of ``z``, as in ``amplitude cos(2 pi frequency t + phase)``; at 0 the mean", "m", dims="frequency"
    )
    phase: Array = quantity("phase of ``z``, ``t = 0`` at the start of the motion", "rad", dims="frequency")
    periods: int = quantity(
        "Periods of the force transformed: a whole number of periods of the motion if it repeats", key=""
    )
    window: str = quantity(
        "Hann's window is laid over motions that do not repeat; a line is then spread over three neighbours, and "
        "its amplitude is that of the middle one",
        key="",
    )

    def harmonic(self, order: int, period: float) -> float:
        """Amplitude at ``order`` times the frequency of the force [m]; nan above the spectrum.

        Parameters
        ----------
        order : int
            From 0 on.
        period : float
            Of the force [s].
        """
        i = round(order * self.periods)
        return float(self.amplitude[i]) if i < self.amplitude.size and period > 0 else math.nan


def impulses(record: Recording, periods: int) -> Impulses:
    """Statistics of the impacts.

    ``record``: the watched motion; ``periods``: periods of the force in it.
    """
    found = record.impacts
    closed = np.array([impact.impulse for impact in found if impact.closed])
    return Impulses(
        count=len(found),
        unfinished=len(found) - closed.size,
        per_period=len(found) / periods,
        mean=float(closed.mean()) if closed.size else math.nan,
        deviation=float(closed.std()) if closed.size else math.nan,
        least=float(closed.min()) if closed.size else math.nan,
        largest=float(closed.max()) if closed.size else math.nan,
        peak_stress=max((impact.peak_stress for impact in found), default=0.0),
    )


def balance(record: Recording, scenario: Scenario, period: float, multiple: int | None) -> Balance | None:
    r"""Momentum per period; None with a body force, a clamped end or a start within one transit, which are not kept.

    .. math:: \int v(t, 0)\,dt = \tfrac{1 - a}{2} \int V(t - T)\,dt + b \int g\,dt.

    ``period``: of the force [s]; ``multiple``: periods after which the motion repeats, if it was seen to.
    """
    rod, boundary = record.rod, record.boundary
    if boundary.clamped or not scenario.body_force.is_zero or record.t[0] < rod.travel_time:
        return None
    watched = record.returned.size
    first = watched % (multiple or 1)
    samples = (record.z.size - 1) // watched
    start = float(record.t[0])
    force = _impulse(scenario.force, start, start + period)
    travelled = 0.5 * (1.0 - rod.reflection) * float(record.returned[first:].mean()) + rod.input_gain * force
    at_end = float(record.z[-1] - record.z[first * samples]) / (watched - first)
    return Balance(
        contact=float(record.contact_impulses[first:].mean()),
        force=force,
        dashpot=rod.damping * travelled + boundary.end_damping * at_end,
    )


def _impulse(force: Expression, low: float, high: float) -> float:
    if force.is_zero:
        return 0.0
    kinks = [float(point) for point in force.breakpoints("t", low, high) or ()][:50]
    edges = np.linspace(low, high, 9)
    edges = np.unique(np.concatenate((edges, kinks)))
    parts = [
        quad(lambda t: float(force(t=t)), a, b, epsabs=0.0, epsrel=1e-13, limit=100, full_output=1)[0]
        for a, b in pairwise(edges)
    ]
    return math.fsum(parts)


def spectrum(record: Recording, regime: Regime, period: float, samples: int) -> Spectrum:
    """Fourier amplitudes of ``z``.

    ``regime``: whether it repeats, and after how many periods; ``period``: of the force [s]; ``samples``: in a period.

    Notes
    -----
    From samples: what lies above half the sampling frequency is folded back.  ``z`` of a rod with contact has kinks in
    its second derivative or its first (rigid obstacle), so that its amplitudes fall off like the third or the second
    power of the frequency.
    """
    watched = (record.z.size - 1) // samples
    multiple = regime.multiple or 1
    periods = watched - watched % multiple
    z = record.z[record.z.size - 1 - periods * samples : -1]
    start = float(record.t[record.z.size - 1 - periods * samples])
    window = "none" if regime.kind == "periodic" or regime.kind == "rest" else "hann"
    weights = np.ones(z.size) if window == "none" else 1.0 - np.cos(2.0 * np.pi * np.arange(z.size) / z.size)
    mean = float(z.mean())
    line = np.fft.rfft((z - mean) * weights) / z.size
    amplitude = 2.0 * np.abs(line)
    if z.size % 2 == 0:
        amplitude[-1] *= 0.5
    amplitude[0] = abs(mean)
    frequency = np.arange(line.size) / (periods * period)
    phase = np.angle(line * np.exp(-2j * np.pi * frequency * start))
    return Spectrum(frequency=frequency, amplitude=amplitude, phase=phase, periods=periods, window=window)


def share_in_contact(record: Recording) -> float:
    """Share of the watch in which the end touches the obstacle [-]; ``record``: the watched motion."""
    touching = math.fsum(end - start for start, end in record.contacts)
    return min(touching / float(record.t[-1] - record.t[0]), 1.0)
