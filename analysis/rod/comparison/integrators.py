"""The motion of the scheme by general integrators and by the event-exact one, behind one function."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field
from typing import Literal, cast, get_args

import numpy as np

from lure.analysis.rod.comparison.legs import CvodeMethod, Leg, SchemeEquations, ScipyMethod, cvode_leg, scipy_leg
from lure.analysis.rod.simulation import simulate
from lure.analysis.rod.simulation.simulate import in_steps
from lure.arrays import Reals as Array
from lure.errors import InputError, demand_seconds, demand_whole
from lure.plants.multivariable import counted
from lure.record import described, quantity
from lure.rod.datasets import Contact, in_phases, number_of_contacts
from lure.rod.discretisation import UpwindScheme
from lure.rod.scenario import Scenario
from lure.rod.scheme import structured_motion

SchemeMethod = Literal["exact", "RK45", "DOP853", "Radau", "BDF", "LSODA", "CVODE", "CVODE-Adams"]
"""How the motion of the scheme is computed."""
SCHEME_METHODS: tuple[SchemeMethod, ...] = get_args(SchemeMethod)
"""Every one of them, by name."""

_LONGEST = 0.25
_MOST_SAMPLES = 10**7
_MOST_WORK = 1e8


@described(frozen=True, kw_only=True, slots=True, eq=False)
class SchemeRun:
    """A motion of the scheme as an integrator gives it; OBSERVED evidence, about the scheme and not about the rod."""

    scheme: UpwindScheme = quantity("The scheme")
    method: str = quantity("The integrator")
    t: Array = quantity("(samples,) instants", "s")
    z: Array = quantity("(samples,) contact coordinate ``u(t, L) - gap``", "m")
    velocity: Array | None = quantity(
        "(samples,) ``z' = v(t, L)`` [m/s]; None if the method does not tell", default=None
    )
    energy: Array | None = quantity(
        "(samples,) :func:`lure.analysis.rod.energy.discrete_energy` [J]; None if the method does not tell",
        default=None,
    )
    contacts: tuple[tuple[float, float], ...] = quantity(
        "Beginning and end of every contact [s]; 0 and the end of the run if it began or was cut there"
    )
    state: Array | None = quantity(
        "(2N+1,) at the end, in the ordering of the scheme; None if the method does not tell", default=None
    )
    steps: int | None = quantity("Time steps; None where there are none or they are not told", default=None)
    evaluations: int | None = quantity(
        "Evaluations of the right-hand side; None where there are none or they are not told", default=None
    )
    cpu_seconds: float = quantity("CPU time of the process", "s")

    @property
    def u_end(self) -> Array:
        """(samples,) ``u(t, L)`` [m]."""
        return self.z + self.scheme.rod.gap

    def __str__(self) -> str:
        """One sentence."""
        contact = number_of_contacts(len(self.contacts))
        work = "" if self.evaluations is None else f", {self.evaluations} evaluations"
        return (
            f"scheme of {counted(self.scheme.cells, 'cell')} by {self.method} up to {self.t[-1]:.6g} s: "
            f"{contact}{work}, {self.cpu_seconds:.2g} s of CPU"
        )


def exact_scheme(scheme: UpwindScheme, scenario: Scenario, until: float, samples: int) -> SchemeRun:
    """The scheme, event to event: :func:`simulate`, or :func:`structured_motion` where that would take too long.

    ``scheme``, ``scenario``, ``until``, ``samples``: see :func:`lure.analysis.rod.comparison.integrate`.

    Raises
    ------
    InputError
        What either of the two refuses.
    """
    if not in_steps(scheme, until):
        return by_structure(scheme, scenario, until, samples)
    before = time.process_time()
    run = simulate(scheme, scenario, until=until, samples=samples)
    if run.ended_early is not None:
        raise InputError(f"until is {until:g} s, and the motion is followed to {run.t[-1]:g} s: {run.ended_early}")
    return SchemeRun(
        scheme=scheme,
        method="exact",
        t=run.t,
        z=run.z,
        energy=run.energy,
        contacts=tuple((contact.start, contact.end) for contact in run.contacts),
        cpu_seconds=time.process_time() - before,
    )


def by_structure(scheme: UpwindScheme, scenario: Scenario, until: float, samples: int) -> SchemeRun:
    """The scheme by :func:`structured_motion`; arguments and refusals are those of that."""
    before = time.process_time()
    run = structured_motion(scheme, scenario, until, samples=samples)
    return SchemeRun(
        scheme=scheme,
        method="exact",
        t=run.t,
        z=run.z,
        velocity=run.wave - scheme.rod.mobility * run.stress,
        contacts=run.contacts,
        state=run.state,
        cpu_seconds=time.process_time() - before,
    )


def integrate(  # noqa: PLR0913  (what, from where, until when, and five settings with defaults)
    scheme: UpwindScheme,
    scenario: Scenario,
    until: float,
    *,
    method: SchemeMethod = "LSODA",
    rtol: float = 1e-8,
    atol: float | None = None,
    samples: int = 2001,
    longest_step: float | None = None,
) -> SchemeRun:
    r"""Motion of the scheme ``y' = A y + b1 mu + b2 g + f``-terms, ``mu = -p(z)``, by the integrator of one's choice.

    Flight and contact are integrated as two smooth problems, each from where the last one ended; an instant at which a
    load changes its formula ends a piece, too.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme, in any ordering.
    scenario : Scenario
        Loads and initial data.
    until : float
        End of the run [s].
    method : str
        ``"exact"``: :func:`lure.analysis.rod.simulation.simulate`, without a time step, for at most 1000 cells; for
        more, and for long runs, :func:`.structured_motion`, which takes a force, no body force, and tells no energy.
        ``"RK45"``, ``"DOP853"`` (explicit), ``"Radau"``, ``"BDF"`` (implicit), ``"LSODA"`` (either): scipy.
        ``"CVODE"`` (BDF), ``"CVODE-Adams"``: SUNDIALS through scikit-sundae, the extra ``lure[cvode]``.
    rtol : float
        Relative tolerance of a step, from 1e-12 to 1e-2; ``"exact"`` has no use for it.
    atol : float, optional
        Absolute tolerance of the waves [m/s], and, times ``T``, of ``z``.  By default ``rtol`` times the largest
        velocity that the data and the loads suggest.
    samples : int
        Number of instants kept, evenly spaced from 0 to ``until``.
    longest_step : float, optional
        Longest step [s].  By default a quarter of a transit: a load that is quiet for long is still looked at, and at
        rest the integrator could go faster.

    Returns
    -------
    SchemeRun
        A motion of the scheme: OBSERVED evidence, and about the scheme only, which damps what the rod keeps.

    Raises
    ------
    InputError
        An argument is out of range, scikit-sundae is missing, a load is not finite, or the integrator gives up.

    Notes
    -----
    The tolerances hold for a step.  With scipy's own (1e-3, 1e-6) and without a stop at contact, Radau has been seen
    28 % off after an impact with stiffness ``k = 1e6``; hence the defaults here, and the comparison with ``"exact"``.

    Examples
    --------
    >>> from lure.rod import builtin_system, upwind
    >>> system = builtin_system("paper-rod")
    >>> run = integrate(upwind(system.rod, 10), system.scenario, 1e-3, method="DOP853", samples=3)
    >>> exact = integrate(upwind(system.rod, 10), system.scenario, 1e-3, method="exact", samples=3)
    >>> bool(abs(run.u_end - exact.u_end).max() < 1e-11)
    True
    """
    _check(scheme, until, (method, samples))
    _check_steps(rtol, atol, longest_step)
    if method == "exact":
        return exact_scheme(scheme, scenario, until, samples)
    equations = SchemeEquations(scheme=scheme, scenario=scenario)
    if not np.isfinite(equations.start).all():
        raise InputError("initial.u0 and initial.u1 have no finite value at some grid point; give finite data")
    before = time.process_time()
    speed = rtol * equations.speed(until) if atol is None else atol
    size = np.full(scheme.order, speed)
    size[-1] *= scheme.rod.travel_time
    walk = _Walk(
        equations=equations,
        method=method,
        rtol=rtol,
        atol=size,
        longest=_LONGEST * scheme.rod.travel_time if longest_step is None else longest_step,
        times=np.linspace(0.0, float(until), samples),
    )
    with np.errstate(over="ignore", invalid="ignore"):  # what comes of it is looked at after each step
        contacts = walk.go([0.0, *scenario.breaks(until), float(until)])
    return SchemeRun(
        scheme=scheme,
        method=method,
        t=walk.times,
        z=walk.rows[:, 0],
        velocity=walk.rows[:, 1],
        energy=walk.rows[:, 2],
        contacts=tuple((contact.start, contact.end) for contact in contacts),
        state=np.asarray(equations.unfolded(walk.y)[scheme.permutation]),
        steps=walk.steps,
        evaluations=walk.evaluations,
        cpu_seconds=time.process_time() - before,
    )


@dataclass(kw_only=True, slots=True, eq=False)
class _Walk:
    """A run as it proceeds: samples filled in, the state, steps and evaluations counted."""

    equations: SchemeEquations
    method: SchemeMethod
    rtol: float
    atol: Array
    longest: float
    times: Array
    rows: Array = field(init=False)
    filled: int = 0
    steps: int | None = 0
    evaluations: int = 0
    y: Array = field(init=False)

    def __post_init__(self) -> None:
        self.rows, self.y = np.empty((self.times.size, 3)), self.equations.start

    def go(self, edges: list[float]) -> tuple[Contact, ...]:
        """Integrate from edge to edge, and on each piece from contact to release to contact; the contacts."""
        z, arriving = self.y[-1], self.y[-3]
        found = in_phases(edges, self._phase, touching=z > 0.0 or (z == 0.0 and arriving > 0.0))
        self._fill(edges[-1])
        return found

    def _phase(self, t: float, span: tuple[float, float], touching: bool, watch: bool) -> tuple[float, bool]:  # noqa: FBT001  (see in_phases)
        self._fill(t)
        leg = Leg(
            equations=self.equations,
            touching=touching,
            start=t,
            end=span[1],
            span=span,
            y=self.y,
            times=self.times[self.filled : int(np.searchsorted(self.times, span[1], side="right"))],
            longest=self.longest,
            rtol=self.rtol,
            atol=self.atol,
            watch=watch,
        )
        if self.method in get_args(CvodeMethod):
            found = cvode_leg(leg, cast("CvodeMethod", self.method))
        else:
            found = scipy_leg(leg, cast("ScipyMethod", self.method))
        self.rows[self.filled : self.filled + len(found.rows)] = found.rows
        self.filled += len(found.rows)
        self.evaluations += found.evaluations
        self.steps = None if found.steps is None or self.steps is None else self.steps + found.steps
        self.y = found.y
        return found.t, found.left

    def _fill(self, t: float) -> None:
        """Samples up to ``t`` that are still open: those at ``t`` itself."""
        last = int(np.searchsorted(self.times, t, side="right"))
        self.rows[self.filled : last] = self.equations.observed(self.y[None, :])
        self.filled = max(self.filled, last)


def _check(scheme: UpwindScheme, until: float, settings: tuple[object, object]) -> None:
    method, samples = settings
    demand_seconds("until", until)
    if method not in SCHEME_METHODS:
        raise InputError(f"method is {method!r:.40}; give one of {', '.join(SCHEME_METHODS)}")
    demand_whole("samples", samples, 2, _MOST_SAMPLES)
    work = scheme.rate * until
    if method != "exact" and work > _MOST_WORK:
        raise InputError(
            f"until is {until:g} s, in which a wave passes {work:.2g} cells, one or two a step; give at most "
            f'{_MOST_WORK / scheme.rate:.3g} s, fewer cells or method="exact"'
        )


def _check_steps(rtol: object, atol: object, longest: object) -> None:
    if isinstance(rtol, bool) or not isinstance(rtol, int | float) or not 1e-12 <= rtol <= 1e-2:
        raise InputError(f"rtol is {rtol!r}; give a number from 1e-12 to 1e-2")
    for name, value, unit in (("atol", atol, "m/s"), ("longest_step", longest, "s")):
        wrong = isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < math.inf
        if value is not None and wrong:
            raise InputError(f"{name} is {value!r}; give a positive number in {unit}, or None")
