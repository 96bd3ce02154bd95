"""The exact motion of the rod while its end is free, by characteristics and without a grid.

Contact is not covered: see :func:`free_motion`, which refuses a motion that reaches the obstacle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.errors import AssumptionError, InputError
from lure.expressions import Expression
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario
from lure.rod.transfer import RodPlant

_PER_TRANSIT = 16
_MOST = 20_000_000
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)


@dataclass(frozen=True, kw_only=True, eq=False)
class FreeMotion:
    r"""Free flight of a rod: waves, velocity and the displacement of the contacting end.

    With ``p = 0`` both waves at ``x = L`` are one function ``W(t) = r1(t, L) = r2(t, L)``, and

    .. math::

        W(t) &= -a\,W(t - 2T) + 2 b\,g(t - T) \quad (t > 2T), \\
        u(t, L) &= u_0(L) + \int_0^t W,

    with ``W = r1(0, L - ct)`` on ``(0, T)`` and ``W = -a r2(0, c(t - T)) + 2 b g(t - T)`` on ``(T, 2T)``.  A jump of
    ``W`` (data that are not matched) stays a jump; on it one of its two sides is returned.

    Make one with :func:`free_motion`, which checks that the flight is free.

    Attributes
    ----------
    rod : Rod
        The rod.
    scenario : Scenario
        Initial data and force; no body force.
    until : float
        Times up to here are valid [s].
    largest_z : float
        Upper bound, in floating point, of the contact coordinate ``z = u(t,L) - gap`` on ``[0, until]``; negative [m].
    """

    rod: Rod
    scenario: Scenario
    until: float
    largest_z: float

    def end_wave(self, t: ArrayLike) -> NDArray[np.float64]:
        """``W(t) = v(t, L)`` [m/s] at ``0 <= t <= until`` [s], elementwise.

        Raises
        ------
        InputError
            A time lies outside ``[0, until]``.
        """
        return _end_wave(self.rod, self.scenario, self._checked(t))

    def end_displacement(self, t: ArrayLike) -> NDArray[np.float64]:
        """``u(t, L)`` [m] at ``0 <= t <= until`` [s], elementwise.

        Raises
        ------
        InputError
            A time lies outside ``[0, until]``.
        """
        times = self._checked(t)
        return self.rod.gap + self.scenario.contact_coordinate(self.rod) + _travel(self.rod, self.scenario, times)

    def waves(self, t: ArrayLike, x: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Riemann invariants ``r1 = v - c u_x`` and ``r2 = v + c u_x`` at ``(t, x)`` [m/s], elementwise.

        Parameters
        ----------
        t : array_like
            Times in ``[0, until - T]`` [s]: the forward wave is read where it arrives, up to ``T`` later.
        x : array_like
            Positions in ``[0, L]`` [m]; broadcasts against ``t``.

        Raises
        ------
        InputError
            A point lies outside.
        """
        times, places = np.broadcast_arrays(np.asarray(t, dtype=float), np.asarray(x, dtype=float))
        if not np.all((places >= 0) & (places <= self.rod.length)):
            raise InputError(f"x leaves the rod; give positions in [0, {self.rod.length:g}] m")
        rest = (self.rod.length - places) / self.rod.wave_speed
        forward = self.end_wave(times + rest)
        early = times < rest
        start = np.where(early, places + self.rod.wave_speed * times, self.rod.length)
        initial = self.scenario.waves(self.rod, np.minimum(start, self.rod.length))[1]
        backward = np.where(early, initial, self.end_wave(np.where(early, 0.0, times - rest)))
        return forward, backward

    def velocity(self, t: ArrayLike, x: ArrayLike) -> NDArray[np.float64]:
        """``v(t, x) = (r1 + r2)/2`` [m/s]; arguments and errors as for :meth:`waves`."""
        forward, backward = self.waves(t, x)
        return 0.5 * (forward + backward)

    def _checked(self, t: ArrayLike) -> NDArray[np.float64]:
        times = np.asarray(t, dtype=float)
        if not np.all((times >= 0) & (times <= self.until)):
            raise InputError(f"t leaves the free flight; give times in [0, {self.until:g}] s (waves: one transit less)")
        return times


def free_motion(rod: Rod, scenario: Scenario, until: float) -> FreeMotion:
    r"""Exact motion of the rod on ``[0, until]``, if its end stays free.

    No grid in space and no time step: the error is that of double precision and of one quadrature for ``int g`` and
    ``int u1`` (Gauss, 8 nodes a transit: exact to rounding for smooth data, of second order where ``g`` has a kink
    inside a transit).  Contact is not covered; that ``z < 0`` holds is checked at 16 times a transit, with the largest
    ``|W|`` met there as the bound in between, which is COMPUTED evidence.

    Parameters
    ----------
    rod : Rod
        The rod.
    scenario : Scenario
        Initial data and force ``g``; ``f = 0``.
    until : float
        End of the span [s], at most 20 000 000 evaluations away.

    Raises
    ------
    InputError
        There is a body force, data are not finite, or ``until`` is not a positive number or too far away.
    AssumptionError
        The end reaches the obstacle, or comes so near that the check cannot tell.

    Notes
    -----
    Without a force the cost of a value does not depend on its time; with one it is proportional to ``t/2T``.

    Examples
    --------
    The paper's rod, released: the end swings between -e/2 and e/2, one transit each way, and ends at ``u0(0)``.

    >>> from lure.rod import builtin_system
    >>> system = builtin_system("paper-rod")
    >>> motion = free_motion(system.rod, system.scenario, until=20.0)
    >>> T = system.rod.travel_time
    >>> motion.end_displacement([0.0, T, 2 * T, 20.0]).round(8)
    array([-1.000e-04,  1.000e-04, -9.993e-05,  1.000e-04])
    """
    if not scenario.body_force.is_zero:
        raise InputError(f"force.f is {scenario.body_force}; free_motion takes no body force, give 0")
    if not 0 < until < np.inf:
        raise InputError(f"until is {until!r}; give a positive number of seconds")
    samples = int(min(until / rod.travel_time, _MOST)) * _PER_TRANSIT + _PER_TRANSIT + 1
    if samples > _MOST:
        raise InputError(f"until = {until:g} s is {until / rod.travel_time:.3g} transits; give at most {_MOST // 16:g}")
    times: NDArray[np.float64] = np.arange(samples, dtype=np.float64) * (rod.travel_time / _PER_TRANSIT)
    travel, wave = _lattice(rod, scenario, times)
    if not (np.isfinite(travel).all() and np.isfinite(wave).all()):
        raise InputError("initial.u0 or its derivative is not finite somewhere on the rod; give finite data")
    span = times <= until + rod.travel_time / _PER_TRANSIT
    between = 0.5 * float(np.abs(wave).max()) * rod.travel_time / _PER_TRANSIT
    z = scenario.contact_coordinate(rod) + travel[span]
    largest = float(z.max()) + between
    if not largest < 0:
        first = float(times[span][np.argmax(z + between >= 0)])
        raise AssumptionError(
            f"the end reaches the obstacle at about t = {first:.6g} s; free_motion covers free flight only"
        )
    return FreeMotion(rod=rod, scenario=scenario, until=float(until), largest_z=largest)


def _end_wave(rod: Rod, scenario: Scenario, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """``W`` at any time: the initial wave after ``n`` round trips, and what the force sent out since."""
    T = rod.travel_time
    trips, phase = _round_trips(rod, times)
    outward = phase < T
    x = np.where(outward, rod.length - rod.wave_speed * phase, rod.wave_speed * (phase - T))
    forward, backward = scenario.waves(rod, np.clip(x, 0.0, rod.length))
    value = _power(rod, trips) * np.where(outward, forward, -rod.reflection * backward)
    if not scenario.force.is_zero:
        for j in range(int(trips.max(initial=0.0)) + 1):
            sent = times - T - 2 * T * j
            echo = _power(rod, np.array(float(j))) * 2 * rod.input_gain
            value += np.where(sent >= 0, echo * scenario.force(t=np.maximum(sent, 0.0)), 0.0)
    return value


def _travel(rod: Rod, scenario: Scenario, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """``int_0^t W``: the initial waves in closed form (a geometric series), the force from the same sum as ``W``."""
    T = rod.travel_time
    value = _initial_travel(rod, scenario, times)
    if not scenario.force.is_zero:
        pushed = _Primitive(scenario.force, "t", T, float(times.max(initial=0.0)))
        for j in range(int(times.max(initial=0.0) / (2 * T)) + 1):
            echo = _power(rod, np.array(float(j))) * 2 * rod.input_gain
            value += echo * pushed(np.maximum(times - T - 2 * T * j, 0.0))
    return value


def _lattice(
    rod: Rod, scenario: Scenario, times: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """``int_0^t W`` and ``W`` on a lattice of 16 times a transit, at a cost linear in its length."""
    T, back = rod.travel_time, 2 * _PER_TRANSIT
    unloaded = Scenario(displacement=scenario.displacement, velocity=scenario.velocity)
    travel, wave = _initial_travel(rod, scenario, times), _end_wave(rod, unloaded, times)
    if scenario.force.is_zero:
        return travel, wave
    pushed = _Primitive(scenario.force, "t", T, float(times[-1]))
    sent = times[: max(len(times) - _PER_TRANSIT, 0)]
    for total, values in ((travel, pushed(sent)), (wave, scenario.force(t=sent))):
        forced = np.zeros(len(times) + back)
        forced[_PER_TRANSIT : len(times)] = 2 * rod.input_gain * values
        for row in range(back, len(times), back):
            forced[row : row + back] -= rod.reflection * forced[row - back : row]
        total += forced[: len(times)]
    return travel, wave


def _initial_travel(rod: Rod, scenario: Scenario, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """``int_0^t W`` of the initial data alone: differences of ``u0``, integrals of ``u1``."""
    L, c, T = rod.length, rod.wave_speed, rod.travel_time
    u0 = scenario.displacement
    kicked = _Primitive(scenario.velocity, "x", L / 4, L)

    def within(phase: NDArray[np.float64]) -> NDArray[np.float64]:
        """The wave inside one transit."""
        left = np.clip(L - c * phase, 0.0, L)
        right = np.clip(c * (phase - T), 0.0, L)
        forward = u0(x=left) - u0(x=L) + (kicked(np.array(L)) - kicked(left)) / c
        backward = u0(x=right) - u0(x=0.0) + kicked(right) / c
        return np.asarray(forward - rod.reflection * backward)

    trips, phase = _round_trips(rod, times)
    return np.asarray(_series(rod, trips) * within(np.array(2 * T)) + _power(rod, trips) * within(phase))


def _round_trips(rod: Rod, times: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Whole round trips before each time, and the time since the last."""
    period = 2 * rod.travel_time
    trips = np.floor(times / period)
    return trips, np.maximum(times - period * trips, 0.0)


def _power(rod: Rod, n: NDArray[np.float64]) -> NDArray[np.float64]:
    """``(-a)^n``; for ``0 < -a`` through ``ln|a|``, which keeps its digits where ``-a`` is near one."""
    if rod.reflection < 0:
        return np.exp(n * RodPlant(rod).log_reflection)
    return np.asarray((-rod.reflection) ** n)


def _series(rod: Rod, n: NDArray[np.float64]) -> NDArray[np.float64]:
    """``1 + (-a) + .. + (-a)^(n-1)``, with ``1 + a = 2k/(k + Z)``."""
    if rod.damping == 0:
        return n
    missing = -np.expm1(n * RodPlant(rod).log_reflection) if rod.reflection < 0 else 1 - _power(rod, n)
    return np.asarray(missing / (2 * rod.damping * rod.input_gain))


class _Primitive:
    """``int_0^y`` of an expression for ``0 <= y <= end``, by Gauss quadrature on panels."""

    def __init__(self, expression: Expression, variable: str, width: float, end: float) -> None:
        self._expression, self._variable, self._width = expression, variable, width
        self._edges: NDArray[np.float64] = width * np.arange(int(end / width) + 2, dtype=np.float64)
        self._sums = np.zeros(len(self._edges))
        self._sums[1:] = np.cumsum(self._panel(self._edges[:-1], self._edges[1:]))

    def _panel(self, low: NDArray[np.float64], high: NDArray[np.float64]) -> NDArray[np.float64]:
        half = 0.5 * (high - low)[..., None]
        values = self._expression(**{self._variable: 0.5 * (high + low)[..., None] + half * _NODES})
        if not np.isfinite(values).all():
            raise InputError(f"{str(self._expression)!r} is not finite somewhere on the span; give finite data")
        return np.asarray((half * values) @ _WEIGHTS)

    def __call__(self, y: NDArray[np.float64]) -> NDArray[np.float64]:
        panel = np.minimum((y / self._width).astype(int), len(self._edges) - 2)
        return np.asarray(self._sums[panel] + self._panel(self._edges[panel], y))
