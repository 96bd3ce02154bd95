"""The exact motion of a rod: what may be asked for, and how the windows become an answer."""

from __future__ import annotations

import sys
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from lure.errors import InputError
from lure.rod.motion.choice import compilation_pays
from lure.rod.motion.end_law import Boundary, end_law
from lure.rod.motion.fields import Fields
from lure.rod.motion.impacts import Impact
from lure.rod.motion.ledger import Ledger
from lure.rod.motion.motion import Motion
from lure.rod.motion.record import Trips, Windows, impacts_of, record_of
from lure.rod.motion.sources import sources
from lure.rod.motion.timeline import timeline
from lure.rod.motion.windows import Problem, Window, windows
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

_MOST_TRIPS = 10_000_000
_TELL_EVERY = 64


@dataclass(frozen=True, kw_only=True, slots=True)
class Numerics:
    """How a motion is computed; the answer does not depend on it beyond its error.

    Attributes
    ----------
    degree : int
        Degree of the Chebyshev series on a piece, from 8 to 40.
    keep : int or None
        Number of the last round trips that are kept for evaluation, at least 2; None for all.  With a number, memory
        does not grow with ``until``, except by the impacts.
    on_window : callable or None
        Called with every window when it is done, and before it is dropped; by compiled code for many at a time.
    on_progress : callable or None
        Called now and then with the time reached [s]; unlike ``on_window`` it costs nothing.
    compiled : bool or None
        Whether numba compiles the motion (``pip install "lure[fast]"``): half a microsecond a round trip in flight,
        and about as much for each piece between kinks in the wave, in place of half a millisecond a round trip, for
        some 20 s at the first call ever, which are kept on disk.  None compiles if that takes less time than it saves:
        what this process or, for motions of more than 2000 round trips, an earlier one has compiled is used, and
        motions of more than 40 000 are compiled for.  Both ways give the same numbers to rounding.  Power laws other
        than ``m = 1`` are never compiled; ``Motion.compiled`` says which way was taken.
    stretches : bool
        Whether compiled code passes over many round trips at once where nothing can happen in them: without a body
        force, under a force that is a sum of exponentials, sines and powers between its breakpoints, at a cost that
        hardly depends on their number.
    """

    degree: int = 16
    keep: int | None = None
    on_window: Callable[[Window], None] | None = None
    on_progress: Callable[[float], None] | None = None
    compiled: bool | None = None
    stretches: bool = True

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
    if not compilation_pays(problem, None):
        return windows(problem)
    from lure.rod.motion.engine import Engine

    return (window for record in Engine(problem).records() for window in Windows(record))


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
    piecewise linear laws) or trivial (rigid obstacle, ``z = 0`` while the stress ``W/d`` is positive); a power law is
    solved by collocation with adaptive pieces.  Contact and release are found by bounds on the series over whole
    intervals; an excursion below rounding (grazing) counts as none.

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
        Clamped end, dashpot at ``x = L``, rigid obstacle, another law.
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

    >>> from lure import builtin_system
    >>> system = builtin_system("paper-rod")
    >>> motion = exact_motion(system.rod, system.scenario, until=2.5e-3)
    >>> T = system.rod.travel_time
    >>> motion.end_displacement([0.0, T, 2 * T]).round(8), motion.impacts
    (array([-1.000e-04,  1.000e-04, -9.993e-05]), ())
    """
    boundary, numerics = boundary or Boundary(), numerics or Numerics()
    problem = _problem(rod, scenario, until, boundary, numerics.degree)
    pays = compilation_pays(problem, numerics.compiled)
    run = _by_engine(problem, numerics) if pays else _by_windows(problem, numerics)
    return Motion(
        rod=rod,
        scenario=scenario,
        boundary=boundary,
        until=float(until),
        since=2.0 * rod.travel_time * run.record.number,
        impacts=run.impacts,
        crossings=run.crossings,
        energy_residual=run.energy_residual,
        error=run.error + problem.law.error * run.largest_wave,
        note=problem.law.note,
        compiled=pays,
        fields=Fields(sources=problem.sources, share=problem.share, record=run.record),
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class _Run:
    """What either way of computing brings."""

    record: Trips
    impacts: tuple[Impact, ...]
    crossings: int
    energy_residual: float
    error: float
    largest_wave: float


def _by_windows(problem: Problem, numerics: Numerics) -> _Run:
    kept: deque[Window] = deque(maxlen=numerics.keep)
    impacts: list[Impact] = []
    ledger, last = Ledger(problem), None
    error = 0.0
    crossings = 0
    for window in windows(problem):
        last = window
        ledger.add(window)
        kept.append(window)
        impacts += window.impacts
        crossings += window.crossings
        error += window.error
        if numerics.on_window is not None:
            numerics.on_window(window)
        if numerics.on_progress is not None and window.number % _TELL_EVERY == 0:
            numerics.on_progress(_reached(problem, window.number + 1))
    assert last is not None, "a positive time has at least one window"
    if last.end.impact is not None:
        impacts.append(last.end.impact)
    return _Run(
        record=record_of(kept, problem.share),
        impacts=tuple(impacts),
        crossings=crossings,
        energy_residual=ledger.residual,
        error=error,
        largest_wave=ledger.largest_wave,
    )


def _by_engine(problem: Problem, numerics: Numerics) -> _Run:
    from lure.rod.motion.engine import Engine

    engine, kept, total = Engine(problem, stretches=numerics.stretches), deque[Trips](), 0
    impacts: list[Impact] = []
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
    whole = timeline(tuple(kept))
    open_impact = engine.open_impact
    return _Run(
        record=whole if numerics.keep is None else whole.last(numerics.keep),
        impacts=(*impacts, open_impact) if open_impact is not None else tuple(impacts),
        crossings=engine.crossings,
        energy_residual=engine.energy_residual,
        error=engine.error,
        largest_wave=engine.largest_wave,
    )


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
        law=end_law(rod, boundary),
        share=1.0 / (1.0 + boundary.end_damping / rod.impedance),
        transits=transits,
    )
