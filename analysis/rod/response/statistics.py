"""Numbers of a watched motion: its impacts, its momentum, its spectrum."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from scipy.integrate import quad

from lure.analysis.rod.response.recording import Array, Recording
from lure.analysis.rod.response.regime import Regime
from lure.expressions import Expression
from lure.record import Record as Result
from lure.record import derived, quantity
from lure.rod.scenario import Scenario


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

    Parameters
    ----------
    record : Recording
        The watched motion.
    periods : int
        Periods of the force in it.
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

    Parameters
    ----------
    record : Recording
        The watched motion.
    scenario : Scenario
        For its force.
    period : float
        Of the force [s].
    multiple : int or None
        Periods after which the motion repeats, if it was seen to.
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

    Parameters
    ----------
    record : Recording
        The watched motion.
    regime : Regime
        Whether it repeats, and after how many periods.
    period : float
        Of the force [s].
    samples : int
        Samples in a period.

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
    """Share of the watch in which the end touches the obstacle [-].

    Parameters
    ----------
    record : Recording
        The watched motion.
    """
    touching = math.fsum(end - start for start, end in record.contacts)
    return min(touching / float(record.t[-1] - record.t[0]), 1.0)
