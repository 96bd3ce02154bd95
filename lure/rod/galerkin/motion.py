"""Time integration of the coefficients by scipy, stopped at every contact and release."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from lure.errors import AssumptionError, InputError
from lure.rod.galerkin.model import INTEGRALS, Equations, GalerkinModel
from lure.rod.scenario import Scenario

if TYPE_CHECKING:
    import control
    import xarray

# What a Galerkin run returns: coefficients, the end of the rod, energy, and the bound of Lemma 3.2.

Array = NDArray[np.float64]
Method = Literal["DOP853", "Radau"]
METHODS: tuple[Method, ...] = ("DOP853", "Radau")


@dataclass(frozen=True, kw_only=True, slots=True)
class Touch:
    """One stretch of contact, ``z > 0``.

    Attributes
    ----------
    start, end : float
        [s]; 0 and the end of the run if it began or was cut there.
    """

    start: float
    end: float


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class GalerkinRun:
    """A motion of ``u_m``, with what the existence proof says of it.

    It is a motion of the semi-discrete problem: OBSERVED evidence about the rod, at best.  That its energy obeys the
    bound of Lemma 3.2 shows that the run is sound, not that it is near the motion of the rod.

    Attributes
    ----------
    model : GalerkinModel
        The rod and the space.
    scenario : Scenario
        Loads and initial data.
    t : ndarray
        (samples,) instants [s].
    states : ndarray
        (samples, 2m+5) rows of ``lure.rod.galerkin.model.Equations``.
    contacts : tuple of Touch
        Every stretch of contact, in order.
    steps : int
        Time steps taken.
    method : {"DOP853", "Radau"}
        Integrator.
    """

    model: GalerkinModel
    scenario: Scenario
    t: Array
    states: Array
    contacts: tuple[Touch, ...]
    steps: int
    method: Method

    @property
    def coefficients(self) -> Array:
        """(samples, m) ``a``, coefficients of the displacement [m]."""
        return self.states[:, : self.model.space.order]

    @property
    def velocities(self) -> Array:
        """(samples, m) ``b = a'``, coefficients of the velocity [m/s]."""
        return self.states[:, self.model.space.order : 2 * self.model.space.order]

    @property
    def u_end(self) -> Array:
        """(samples,) ``u_m(t, L)`` [m]."""
        return np.asarray(self.coefficients @ self.model.space.right)

    @property
    def z(self) -> Array:
        """(samples,) ``u_m(t, L) - gap`` [m]."""
        return self.u_end - self.model.rod.gap

    @property
    def contact_stress(self) -> Array:
        """(samples,) ``p(z)`` [Pa]."""
        return self.model.rod.law(self.z)

    @property
    def energy(self) -> Array:
        """(samples,) ``E_m`` [J]."""
        return self.model.energy(self.coefficients, self.velocities)

    @property
    def dissipated(self) -> Array:
        """(samples,) ``int_0^t k u_t(s,0)^2 ds``, lost in the dashpot [J]."""
        return self.states[:, -5]

    @property
    def supplied(self) -> Array:
        """(samples,) ``int_0^t (g u_t(s,0) + int f u_t dx) ds``, work of the loads [J]."""
        return self.states[:, -4]

    @property
    def impulse(self) -> Array:
        """(samples,) ``int_0^t A(L) p ds``, given to the obstacle [N s]."""
        return self.states[:, -1]

    @property
    def energy_residual(self) -> float:
        """Largest ``|E_m(t) - E_m(0) + dissipated - supplied|`` over the samples, relative to the largest of these [-].

        The identity is exact for ``u_m``, so this is the error of the time integration alone; 0 if all vanish.
        """
        energy = self.energy
        parts = (energy, self.dissipated, self.supplied)
        size = max(float(np.abs(part).max()) for part in parts)
        return float(np.abs(energy - energy[0] + self.dissipated - self.supplied).max()) / size if size else 0.0

    @property
    def gronwall_bound(self) -> Array | None:
        """(samples,) :meth:`bound` at the lemma's own rate, 1/s [J]; None where :meth:`bound` has none."""
        try:
            return self.bound()
        except AssumptionError:
            return None

    def bound(self, rate: float = 1.0) -> Array:
        r"""The bound of Lemma 3.2 on ``E_m`` along the run, with all constants [J]; ``inf`` above the largest double.

        .. math::

            E_m(t) \le \Big( E_m(0) + \frac{1}{2k} \int_0^t g^2\,ds
                + \frac{1}{2\lambda} \int_0^t\!\!\int_0^L \frac{f^2}{\rho A}\,dx\,ds \Big) e^{\lambda t},
            \qquad \lambda > 0 .

        From ``E_m' = -k v_0^2 + g v_0 + int f u_t``, with ``g v_0 <= g^2/(2k) + k v_0^2/2`` and
        ``int f u_t <= int f^2/(2 lambda rho A) + lambda int rho A u_t^2/2``, and Gronwall's inequality.  The paper
        takes ``E = k = rho = A = 1`` and ``lambda = 1``, which has the unit 1/s.  Hence ``int rho A u_t^2 dx`` and
        ``int A E u_x^2 dx`` are at most **twice** the bound (the paper's last two lines leave out the 2, and the dot).

        Parameters
        ----------
        rate : float
            ``lambda`` [1/s].  Without body force the smaller the better; with it about ``1/t`` serves best at ``t``.

        Raises
        ------
        InputError
            ``rate`` is not a positive finite number.
        AssumptionError
            ``k < 0``, or ``k = 0`` under a force ``g``: energy then enters at a rate no energy bounds.
        """
        if not 0.0 < rate < math.inf:
            raise InputError(f"rate is {rate!r}; give a positive number in 1/s")
        k, force, body = self.model.rod.damping, self.states[:, -3], self.states[:, -2]
        if k < 0 or (k == 0 and force[-1] > 0):
            raise AssumptionError(
                f"the bound of Lemma 3.2 needs k > 0, or k = 0 and no force g; the damping is {k:g} N s/m"
            )
        given = (force / (2.0 * k) if k > 0 else 0.0) + body / (2.0 * rate)
        base = np.asarray(self.energy[0] + given)
        with np.errstate(over="ignore", divide="ignore"):
            return np.asarray(np.exp(np.log(base) + rate * self.t))

    def to_dict(self) -> dict[str, object]:
        """What is said of the motion as plain JSON data; the curves are in :meth:`to_xarray`."""
        from lure.rod.galerkin.export import run_dict

        return run_dict(self)

    def to_xarray(self) -> xarray.Dataset:
        """The motion as an ``xarray.Dataset``: the ends, the energy account and all coefficients, with units.

        Returns
        -------
        xarray.Dataset
            Dimensions ``t`` [s], ``basis`` (with the coordinate ``node`` [m] for elements) and ``contact``; the
            attributes say that it is OBSERVED and a motion in this space, not of the rod.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        from lure.rod.galerkin.export import run_dataset

        return run_dataset(self)

    def to_control(self) -> control.TimeResponseData:
        """The motion as python-control has it: output ``sigma = z`` [m], inputs ``mu = -p(z)`` [Pa] and ``g`` [N]."""
        from lure.rod.galerkin.export import run_response

        return run_response(self)

    def _repr_html_(self) -> str:
        from lure.rod.galerkin.export import run_html

        return run_html(self)

    def __str__(self) -> str:
        """One sentence."""
        space, touched = self.model.space, len(self.contacts)
        contact = "no contact" if not touched else "1 contact" if touched == 1 else f"{touched} contacts"
        return (
            f"Galerkin {space.name} of dimension {space.order} up to {self.t[-1]:.6g} s: {contact}, largest z = "
            f"{self.z.max():.9g} m at the samples, energy identity to {self.energy_residual:.1g}"
        )


_MOST_STEPS = 100_000
_LARGEST_IMPLICIT = 300
_LOOKS = 513
_DEGREE = 7  # of scipy's interpolants: 7 for DOP853, 3 for Radau
_POINTS = 0.5 * (1.0 - np.cos((np.arange(_DEGREE + 1) + 0.5) * math.pi / (_DEGREE + 1)))
_FIT = np.linalg.inv(np.polynomial.chebyshev.chebvander(2.0 * _POINTS - 1.0, _DEGREE))


def simulate(  # noqa: PLR0913  (what, from where, until when, and three settings with defaults)
    model: GalerkinModel,
    scenario: Scenario,
    until: float,
    *,
    samples: int = 501,
    tolerance: float = 1e-10,
    method: Method = "DOP853",
) -> GalerkinRun:
    r"""Motion of ``u_m`` under the loads of a scenario, from its projected initial data.

    Contact and flight are integrated as two smooth problems.  On each step scipy's interpolant of ``z`` is a
    polynomial; where a root of it ends the phase, the step ends, so that no contact of the interpolant is missed,
    however short.  Instants at which a load changes its formula end a step, too.

    Arguments are those of :meth:`GalerkinModel.simulate`, which calls it.

    Raises
    ------
    InputError
        An argument is out of range, data or loads are not finite, or the run would take more than 100 000 steps.

    Notes
    -----
    Between initial data and ``V_m`` and between ``V_m`` and the rod there is an error of discretisation that no
    tolerance removes; :mod:`lure.rod.galerkin.error` measures it where the motion is known.
    """
    _check(model, until, samples, tolerance, method)
    equations = Equations(model=model, scenario=scenario)
    a, b = model.project(scenario.displacement, scenario.velocity)
    speed = _speed(equations, a, b, until)
    steps = equations.fastest() * until / 2.0
    if method == "DOP853" and not steps <= _MOST_STEPS:
        raise InputError(
            f"galerkin.until is {until:g} s, about {steps:.2g} steps of the explicit method, more than {_MOST_STEPS}; "
            'give a shorter time, a smaller order or, for a dashpot far above the impedance, method="Radau"'
        )
    m, inertia = model.space.order, float(model.mass.sum())
    atol = np.empty(2 * m + INTEGRALS)
    atol[:m], atol[m : 2 * m] = speed * _transit(model) / m, speed
    peak = model.rod.inertia(np.array([0.0]))[0] * model.rod.length / _transit(model) * speed  # Z v [N]
    atol[2 * m :] = (inertia * speed**2, inertia * speed**2, peak**2 * until, peak * speed, inertia * speed)
    run = _Integration(
        equations=equations,
        method=method,
        atol=tolerance * atol,
        times=np.linspace(0.0, until, samples),
        rows=np.empty((samples, 2 * m + INTEGRALS)),
    )
    with np.errstate(over="ignore", invalid="ignore"):  # what comes of it is looked at after each step
        run.go(np.concatenate((a, b, np.zeros(INTEGRALS))), [0.0, *_breaks(scenario, until), until])
    return GalerkinRun(
        model=model,
        scenario=scenario,
        t=run.times,
        states=run.rows,
        contacts=tuple(run.contacts),
        steps=run.steps,
        method=method,
    )


@dataclass(kw_only=True, slots=True, eq=False)
class _Integration:
    """A run as it proceeds: samples filled in, contacts met, steps taken, largest ``|u(t, L)|`` seen [m]."""

    equations: Equations
    method: Method
    atol: Array
    times: Array
    rows: Array
    filled: int = 0
    steps: int = 0
    reach: float = 0.0
    contacts: list[Touch] = field(default_factory=list)

    def go(self, y: Array, edges: list[float]) -> None:
        """Integrate from edge to edge, and on each piece from contact to release to contact."""
        m, model = self.equations.model.space.order, self.equations.model
        z, rise = self._z(y), float(model.space.right @ y[m : 2 * m])
        touching = z > 0 or (z == 0 and rise > 0)
        if touching:
            self._touch(0.0)
        self.rows[0], self.filled = y, 1
        for span in pairwise(edges):
            t, idle = span[0], 0
            while t < span[1]:
                before = t
                t, y, ended = self._phase(t, y, span, touching=touching, watch=idle < 3)
                idle = idle + 1 if t == before else 0
                if ended:
                    touching = not touching
                    (self._touch if touching else self._release)(t)
        if touching:
            self._release(edges[-1])

    def _phase(
        self, t: float, y: Array, span: tuple[float, float], *, touching: bool, watch: bool
    ) -> tuple[float, Array, bool]:
        """Integrate until the phase or the span ends: the instant, the state, and whether the phase ended.

        Without ``watch`` the first step is taken as it is: rounding has just ended several phases at one instant.

        Raises
        ------
        InputError
            The integrator gives up, or the state is no longer finite.
        """
        from scipy.integrate import DOP853, Radau

        rate = partial(self.equations.rate, touching=touching, span=span)
        if self.method == "Radau":
            slopes = partial(self.equations.jacobian, touching=touching, span=span)
            solver = Radau(rate, t, y, span[1], rtol=2.3e-13, atol=self.atol, jac=slopes)
        else:
            solver = DOP853(rate, t, y, span[1], rtol=2.3e-13, atol=self.atol)
        while solver.status == "running":
            message = solver.step()
            self.steps += 1
            if solver.status == "failed" or not np.isfinite(solver.y).all() or self.steps > _MOST_STEPS:
                raise InputError(
                    f"galerkin.until cannot be reached: after {self.steps} steps, at t = {solver.t:g} s, the "
                    f"integrator stops ({message or 'too many steps'}); give a shorter time, a larger tolerance or, "
                    'for stiff contact, method="Radau"'
                )
            dense = solver.dense_output()
            share = self._end_of_phase(dense, solver.t_old, solver.t, touching=touching) if watch else None
            if share is not None:
                stop = float(solver.t_old + share * (solver.t - solver.t_old))
                self._record(dense, stop)
                return stop, np.asarray(dense(stop)), True
            self._record(dense, solver.t)
            watch = True
        return span[1], np.asarray(solver.y), False

    def _end_of_phase(
        self, dense: Callable[[Array], Array], start: float, end: float, *, touching: bool
    ) -> float | None:
        """Share of the step at which ``z`` takes the wrong sign for the phase, by more than rounding; None if never."""
        states = dense(start + _POINTS * (end - start))
        m, model = self.equations.model.space.order, self.equations.model
        position = model.space.right @ states[:m]
        z = (position - model.rod.gap) * (1.0 if touching else -1.0)
        self.reach = max(self.reach, float(np.abs(position).max()))
        series = _FIT @ z
        if series[0] > np.abs(series[1:]).sum():
            return None
        noise = 64 * np.finfo(float).eps * (self.reach + abs(model.rod.gap))
        roots = np.polynomial.chebyshev.chebroots(series) if np.any(series[1:]) else np.empty(0)
        inside = np.sort(roots.real[(np.abs(roots.imag) < 1e-7) & (np.abs(roots.real) < 1.0)])
        for low, high in pairwise([-1.0, *inside, 1.0]):
            if float(np.polynomial.chebyshev.chebval(np.linspace(low, high, 5)[1:], series).min()) < -noise:
                return float(0.5 * (low + 1.0))
        return None

    def _record(self, dense: Callable[[Array], Array], stop: float) -> None:
        """Samples up to ``stop``."""
        last = int(np.searchsorted(self.times, stop, side="right"))
        if last > self.filled:
            self.rows[self.filled : last] = dense(self.times[self.filled : last]).T
            self.filled = last

    def _z(self, y: Array) -> float:
        space = self.equations.model.space
        return float(space.right @ y[: space.order]) - self.equations.model.rod.gap

    def _touch(self, t: float) -> None:
        """Begin a contact; one that ended at this very instant goes on."""
        again = bool(self.contacts) and self.contacts[-1].end == t
        start = self.contacts.pop().start if again else t
        self.contacts.append(Touch(start=start, end=math.inf))

    def _release(self, t: float) -> None:
        """End the contact; one that began at this very instant was none."""
        start = self.contacts.pop().start
        if t > start:
            self.contacts.append(Touch(start=start, end=t))


def _breaks(scenario: Scenario, until: float) -> list[float]:
    """Instants inside the run at which a load may change its formula, as far as they are known."""
    loads: tuple[Any, ...] = (scenario.force, scenario.body_force)
    found = (load.breakpoints("t", 0, until) or () for load in loads if not load.is_constant)
    return sorted({float(point) for points in found for point in points if 0.0 < float(point) < until})


def _transit(model: GalerkinModel) -> float:
    """``int sqrt(rho/E) dx``, one transit [s]."""
    x, rod = model.quadrature.x, model.rod
    slowness = np.sqrt(rod.coefficient("density", x) / rod.coefficient("youngs_modulus", x))
    return float(model.quadrature.w @ slowness)


def _speed(equations: Equations, a: Array, b: Array, until: float) -> float:
    """A velocity of the size the data and loads suggest, 1 if they suggest none [m/s]."""
    model, x = equations.model, equations.model.quadrature.x
    impedance = float(np.sqrt(model.rod.inertia(x) * model.rod.stretch(x)).min())
    times = np.linspace(0.0, until, _LOOKS)
    started = math.sqrt(2.0 * float(model.energy(a, b)) / float(model.mass.sum()))
    loads = [equations.loads(float(t), (0.0, until)) for t in times]
    pushed = max(abs(force) for force, _, _ in loads) / impedance
    carried = math.sqrt(max(squared for _, _, squared in loads) / float(model.mass.sum())) * _transit(model)
    return max(started, pushed, carried) or 1.0


def _check(model: GalerkinModel, until: object, samples: object, tolerance: float, method: object) -> None:
    """Refuse what cannot be run."""
    if isinstance(until, bool) or not isinstance(until, int | float) or not 0.0 < until < math.inf:
        raise InputError(f"galerkin.until is {until!r}; give a positive number of seconds")
    if isinstance(samples, bool) or not isinstance(samples, int | np.integer) or not 2 <= samples <= 10**6:
        raise InputError(f"galerkin.samples is {samples!r}; give a whole number from 2 to 1000000")
    most = 10**8 // (2 * model.space.order + INTEGRALS)
    if samples > most:
        raise InputError(f"galerkin.samples is {samples}; with order {model.space.order} give at most {most}")
    if not 1e-13 <= tolerance <= 1e-3:
        raise InputError(f"galerkin.tolerance is {tolerance!r}; give a number from 1e-13 to 1e-3")
    if method not in METHODS:
        raise InputError(f"galerkin.method is {method!r}; give one of {', '.join(METHODS)}")
    if method == "Radau" and model.space.order > _LARGEST_IMPLICIT:
        raise InputError(
            f"galerkin.order is {model.space.order}; Radau factorises dense matrices, give at most {_LARGEST_IMPLICIT}"
        )
