"""The exact motion of a rod: what may be asked for, and what is known of it at any time and place."""

from __future__ import annotations

import sys
from collections import deque
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from lure.errors import InputError
from lure.record import Page, Record, described, quantity
from lure.rod.datasets import Contact
from lure.rod.motion.end_law import Boundary, end_law
from lure.rod.motion.engine import Engine
from lure.rod.motion.event_search import open_impact
from lure.rod.motion.fields import Fields
from lure.rod.motion.pieces import Array
from lure.rod.motion.record import Series, Trips, Window, Windows, impacts_of, timeline
from lure.rod.motion.sources import Problem, sources
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

if TYPE_CHECKING:
    import control
    import xarray

_MOST_TRIPS = 10_000_000


class Motion(Record):
    r"""A motion of the rod itself, without grid or time step; make one with :func:`exact_motion`."""

    rod: Rod = quantity("The rod")
    scenario: Scenario = quantity("Loads and initial data")
    boundary: Boundary = quantity("Boundary conditions beyond the paper's")
    until: float = quantity("End of the motion", "s")
    since: float = quantity("Start of what was kept", "s")
    impacts: tuple[Contact, ...] = quantity("In order; the last is not closed if the end still touches the obstacle")
    crossings: int = quantity("Passages between segments of the nonlinearity")
    energy_residual: float = quantity(
        "Largest ``|work of the waves on the end - loss there - change of A P(z)|`` since the start, relative to the "
        "largest energy that passed the end in one round trip or was stored in the obstacle.  In the rod and at ``x = "
        "0`` the balance ``E' = -k v(t,0)^2 + g v(t,0) + int f v dx`` holds identically for waves that are shifted.  "
        "Where round trips are passed over at once the difference is bounded by the residual of the equation of ``z``"
    )
    error: float = quantity(
        "Sum of the estimates of all local errors, as displacement.  How the motion enlarges them (impacts may) is "
        "not in it: compare two values of ``Numerics.degree``",
        "m",
    )
    note: str = quantity("What the computation put in place of the data, or nothing")
    compiled: bool = quantity("Whether compiled code computed it; see :class:`lure.rod.motion.Numerics`")
    fields: Fields = quantity("The waves as they were kept; :meth:`waves` and the methods beside it read them")

    def z(self, t: ArrayLike) -> Array:
        """Contact coordinate ``u(t, L) - gap`` [m] at ``since <= t <= until`` [s], elementwise."""
        return self._end(t, "z")

    def end_displacement(self, t: ArrayLike) -> Array:
        """``u(t, L)`` [m], elementwise."""
        return self.z(t) + self.rod.gap

    def end_velocity(self, t: ArrayLike) -> Array:
        """``v(t, L)`` [m/s], elementwise; at a jump the value after it."""
        return 0.5 * (self._end(t, "wave") + self._end(t, "returned"))

    def contact_stress(self, t: ArrayLike) -> Array:
        """``p(z)``, for a rigid obstacle its reaction [Pa], elementwise."""
        return self._end(t, "push") * ((1.0 + self.boundary.end_damping / self.rod.impedance) / self.rod.mobility)

    def dashpot_velocity(self, t: ArrayLike) -> Array:
        """``v(t, 0)`` [m/s], elementwise; times as for :meth:`waves`."""
        times = np.asarray(t, dtype=float)
        return self.velocity(times, np.zeros(times.shape))

    def dashpot_force(self, t: ArrayLike) -> Array:
        """``k v(t, 0)``, what the dashpot holds back [N], elementwise.

        Raises
        ------
        InputError
            The end is clamped: there is no dashpot.
        """
        if self.boundary.clamped:
            raise InputError("the end x = 0 is clamped and has no dashpot force; read the stress from strain(t, 0)")
        return np.asarray(self.rod.damping * self.dashpot_velocity(t))

    def waves(self, t: ArrayLike, x: ArrayLike) -> tuple[Array, Array]:
        """``r1 = v - c w`` and ``r2 = v + c w`` [m/s] at ``(t, x)``, elementwise; from ``since + 2T`` or 0 on.

        Raises
        ------
        InputError
            A point lies outside the rod or the times that are kept.
        """
        return self.fields.waves(np.asarray(t, dtype=float), np.asarray(x, dtype=float))

    def velocity(self, t: ArrayLike, x: ArrayLike) -> Array:
        """``v(t, x)`` [m/s]; arguments and errors as for :meth:`waves`."""
        forward, backward = self.waves(t, x)
        return 0.5 * (forward + backward)

    def strain(self, t: ArrayLike, x: ArrayLike) -> Array:
        """``w = u_x(t, x)`` [-]; arguments and errors as for :meth:`waves`."""
        forward, backward = self.waves(t, x)
        return (backward - forward) / (2.0 * self.rod.wave_speed)

    def displacement(self, t: float, x: ArrayLike) -> Array:
        """``u(t, x)`` [m] at one time and any places, by integrating the strain from ``x = L``."""
        integral = self.fields.integral_to_end(t, np.asarray(x, dtype=float))
        return np.asarray(self.end_displacement(t) - integral)

    def energies(self, t: ArrayLike) -> Array:
        """``E(t) = A int (rho v^2 + E w^2)/2 dx + A P(z)`` [J], elementwise; times and errors as for :meth:`waves`."""
        times = np.asarray(t, dtype=float)
        waves = self.fields.wave_energies(times.ravel()).reshape(times.shape)
        if self._rigid:
            return waves
        nonlinearity = self.boundary.nonlinearity or self.rod.nonlinearity
        return np.asarray(waves + self.rod.area * nonlinearity.primitive(self.z(times)))

    def energy(self, t: float) -> float:
        """The same at one instant."""
        return float(self.energies(t))

    def to_dict(self) -> dict[str, object]:
        """What is said of the motion as plain JSON data; the curves are in :meth:`to_xarray`."""
        from lure.rod.motion.sampling import motion_dict

        return motion_dict(self)

    def to_xarray(self, samples: int = 2001, *, places: int = 0) -> xarray.Dataset:
        """The motion at evenly spaced instants, as an ``xarray.Dataset`` with units, signs and every parameter.

        Parameters
        ----------
        samples : int
            Number of instants.  At a jump a sample is the value after it.
        places : int
            Number of places along the rod at which velocity, strain and displacement are kept; 0 for none.

        Returns
        -------
        xarray.Dataset
            Dimensions ``t`` [s], ``impact`` (the contacts, of the whole motion) and, if fields were asked for, ``x``
            [m].  The attributes say that it is a motion of the rod itself, COMPUTED, and what its error is.  Above
            20001 samples the energy is left out, since it costs more than all else.

        Raises
        ------
        InputError
            ``samples`` or ``places`` is out of range, or xarray is not installed.
        """
        from lure.rod.motion.sampling import Samples, evenly

        return Samples(evidence="computed", **evenly(self, samples, places=places)).to_xarray()

    def to_control(self, samples: int = 2001) -> control.TimeResponseData:
        """The motion as python-control has it: output ``sigma = z`` [m], inputs ``mu = -p(z)`` [Pa] and ``g`` [N].

        With a body force or initial data the outputs do not follow from these inputs alone.

        Parameters
        ----------
        samples : int
            Number of instants, evenly spaced.

        Raises
        ------
        InputError
            ``samples`` is out of range.
        """
        from lure.rod.motion.sampling import motion_response

        return motion_response(self, samples)

    def _page(self) -> Page:
        from lure.rod.motion.sampling import motion_page

        return motion_page(self)

    @property
    def _rigid(self) -> bool:
        return self.boundary.rigid or bool(self.note)

    def _end(self, t: ArrayLike, name: Series) -> Array:
        times = np.asarray(t, dtype=float)
        if not np.all((times >= self.since) & (times <= self.until)):
            raise InputError(f"t leaves the motion; give times in [{self.since:g}, {self.until:g}] s")
        return self.fields.at_end(times / self.rod.travel_time, name)


@described(frozen=True, kw_only=True, slots=True)
class Numerics:
    """How a motion is computed; the answer does not depend on it beyond its error."""

    degree: int = quantity("Degree of the Chebyshev series on a piece, from 8 to 40", default=16)
    keep: int | None = quantity(
        "Number of the last round trips that are kept for evaluation, at least 2; None for all. With a number, "
        "memory does not grow with ``until``, except by the impacts",
        default=None,
    )
    on_window: Callable[[Window], None] | None = quantity(
        "Called with every window, for many at a time and before it is dropped", default=None
    )
    on_progress: Callable[[float], None] | None = quantity(
        "Called now and then with the time reached [s]; unlike ``on_window`` it costs nothing", default=None
    )
    compiled: bool | None = quantity(
        'Whether numba compiles the kernel (``pip install "lure[fast]"``). It takes half a microsecond for each '
        "piece between kinks in the wave in a round trip with events, in place of some 0.1 ms, and a fifth of a "
        "millisecond for thousands of round trips in which nothing happens, in place of one. Compilation takes 25 "
        "s at the first call ever, twice as long with power laws, and is kept on disk. None compiles once a second "
        "was spent without, if what is left is likely to take longer than compilation, or than loading what an "
        "earlier process has compiled. Either way gives the same numbers to rounding; ``Motion.compiled`` says "
        "which way was taken in the end",
        default=None,
    )
    stretches: bool = quantity(
        "Whether round trips in which nothing can happen are taken together, up to thousands at once: without a "
        "body force, under a force that is a sum of exponentials, sines and powers between its breakpoints",
        default=True,
    )

    def __post_init__(self) -> None:
        if isinstance(self.degree, bool) or not isinstance(self.degree, int) or not 8 <= self.degree <= 40:
            raise InputError(f"Numerics.degree is {self.degree!r}; give a whole number from 8 to 40")
        if self.keep is not None and (isinstance(self.keep, bool) or not isinstance(self.keep, int) or self.keep < 2):
            raise InputError(f"Numerics.keep is {self.keep!r}; give None or a whole number from 2 on")
        if not (self.compiled is None or isinstance(self.compiled, bool)):
            raise InputError(f"Numerics.compiled is {self.compiled!r}; give None, True or False")
        if not isinstance(self.stretches, bool):
            raise InputError(f"Numerics.stretches is {self.stretches!r}; give True or False")


def motion_windows(
    rod: Rod, scenario: Scenario, until: float, *, boundary: Boundary | None = None, degree: int = 16
) -> Iterator[Window]:
    """The windows of a motion one by one, in memory that does not grow; see :func:`exact_motion`.

    Parameters
    ----------
    rod, scenario, until, boundary
        The rod, its loads and initial data, the end of the motion [s], and what happens at its ends.
    degree : int
        Degree of the Chebyshev series on a piece.
    """
    problem = _problem(rod, scenario, until, boundary or Boundary(), degree)
    engine = Engine(problem, wish=None)
    return (window for record in engine.records() for window in Windows(record))


def exact_motion(
    rod: Rod,
    scenario: Scenario,
    until: float,
    *,
    boundary: Boundary | None = None,
    numerics: Numerics | None = None,
) -> Motion:
    r"""Motion of the rod with contact on ``[0, until]``, to rounding and the error of its series.

    .. math:: W(t) &= -a\,V(t - 2T) + 2 b\,g(t - T) + \ldots, \\
        z' &= W - d\,p(z), \qquad V = W - 2 d\,p(z).

    Between events the equation of ``z`` is a quadrature (free flight), linear (normal compliance with ``m = 1`` and
    piecewise linear nonlinearities) or trivial (rigid obstacle, ``z = 0`` while the stress ``W/d`` is positive); a
    power law is solved by collocation with adaptive pieces.  Contact and release are found by bounds on the series over
    whole intervals; an excursion below rounding (grazing) counts as none.

    Parameters
    ----------
    rod : Rod
        The rod; any damping but ``-Z``.
    scenario : Scenario
        Loads and initial data.  Kinks and jumps of ``g``, ``u0``, ``u1`` that their formulas do not show are found by
        halving; the body force may have conditions in ``t`` alone and in ``x`` alone.
    until : float
        End of the motion [s], at most 10 000 000 round trips.
    boundary : Boundary, optional
        Clamped end, dashpot at ``x = L``, rigid obstacle, another nonlinearity.
    numerics : Numerics, optional
        Degree of the series, and what is kept.

    Returns
    -------
    Motion
        Evidence: COMPUTED, floating point with an estimate of the local errors and an energy balance.

    Raises
    ------
    InputError
        ``until`` is not a positive number or too far, data are not finite, or the end begins inside a rigid obstacle.
    AssumptionError
        Contact and flight alternate more than 4000 times in a round trip, or cannot be told apart.

    Examples
    --------
    The paper's rod, released: free flight between -e/2 and e/2.

    >>> from lure.rod import builtin_system
    >>> system = builtin_system("paper-rod")
    >>> motion = exact_motion(system.rod, system.scenario, until=2.5e-3)
    >>> T = system.rod.travel_time
    >>> motion.end_displacement([0.0, T, 2 * T]).round(8), motion.impacts
    (array([-1.000e-04,  1.000e-04, -9.993e-05]), ())
    """
    boundary, numerics = boundary or Boundary(), numerics or Numerics()
    problem = _problem(rod, scenario, until, boundary, numerics.degree)
    engine = Engine(problem, wish=numerics.compiled, stretches=numerics.stretches)
    record, impacts = _kept(engine, problem, numerics)
    return Motion(
        rod=rod,
        scenario=scenario,
        boundary=boundary,
        until=float(until),
        since=2.0 * rod.travel_time * record.number,
        impacts=impacts,
        crossings=engine.crossings,
        energy_residual=engine.energy_residual,
        error=engine.error + problem.nonlinearity.error * engine.largest_wave,
        note=problem.nonlinearity.note,
        compiled=engine.compiled,
        fields=Fields(sources=problem.sources, share=problem.share, record=record),
    )


def _kept(engine: Engine, problem: Problem, numerics: Numerics) -> tuple[Trips, tuple[Contact, ...]]:
    """The round trips that are kept, and all impacts."""
    kept, total = deque[Trips](), 0
    impacts: list[Contact] = []
    for record in engine.records():
        impacts += impacts_of(record.impacts)
        if numerics.on_window is not None:
            for window in Windows(record):
                numerics.on_window(window)
        if numerics.on_progress is not None:
            numerics.on_progress(_reached(problem, record.number + len(record)))
        kept.append(record)
        total += len(record)
        while numerics.keep is not None and total - len(kept[0]) >= numerics.keep:
            total -= len(kept.popleft())
    last = open_impact(engine.f, engine.q, problem.sources.rod.mobility * problem.share)
    impacts += [] if last is None else [last]
    whole = timeline(tuple(kept))
    return whole if numerics.keep is None else whole.last(numerics.keep), tuple(impacts)


def _reached(problem: Problem, trips: int) -> float:
    """Time [s] after so many round trips."""
    return problem.sources.rod.travel_time * min(2.0 * trips, problem.transits)


def _problem(rod: Rod, scenario: Scenario, until: float, boundary: Boundary, degree: int) -> Problem:
    if isinstance(until, bool) or not isinstance(until, int | float) or not 0.0 < until <= sys.float_info.max:
        shown = repr(until) if not isinstance(until, int) or abs(until) < 10**12 else "a very long whole number"
        raise InputError(f"until is {shown}; give a positive number of seconds, up to 1.8e308")
    transits = float(until) / rod.travel_time
    if abs(transits - round(transits)) <= 4e-16 * transits:  # no round trip of rounding errors alone
        transits = float(round(transits))
    if transits > 2.0 * _MOST_TRIPS:
        raise InputError(
            f"until = {until:g} s is {transits / 2.0:.3g} round trips; give at most "
            f"{2.0 * _MOST_TRIPS * rod.travel_time:.3g} s"
        )
    if transits < 1e-9:
        raise InputError(f"until = {until:g} s is {transits:.3g} of one transit; give at least 1e-9 of it")
    return Problem(
        sources=sources(rod, scenario, boundary, float(until), degree),
        nonlinearity=end_law(rod, boundary),
        share=1.0 / (1.0 + boundary.end_damping / rod.impedance),
        transits=transits,
    )
