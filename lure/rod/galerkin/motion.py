"""Time integration of the coefficients by scipy, stopped at every contact and release."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np

from lure.arrays import Reals as Array
from lure.errors import AssumptionError, InputError, Reason, demand_seconds, demand_whole
from lure.record import Column, Page, derived, numbered, plain, quantity
from lure.rod import datasets
from lure.rod.datasets import Contact, SampledMotion, in_phases, number_of_contacts, step_points, turning_negative
from lure.rod.galerkin.model import INTEGRALS, Equations, GalerkinModel
from lure.rod.scenario import Scenario

if TYPE_CHECKING:
    import control

    from lure.rod.galerkin.spaces import NonuniformRod

# What a Galerkin run returns: coefficients, the end of the rod, energy, and the bound of Lemma 3.2.

Method = Literal["DOP853", "Radau"]
_ROUNDING = 1e-9
METHODS: tuple[Method, ...] = ("DOP853", "Radau")


def _rod(rod: NonuniformRod) -> dict[str, object]:
    return {
        "length": rod.length,
        "area": str(rod.area),
        "youngs_modulus": str(rod.youngs_modulus),
        "density": str(rod.density),
        "damping": rod.damping,
        "compliance": 1.0 / rod.nonlinearity.stiffness,
        "exponent": rod.nonlinearity.exponent,
        "gap": rod.gap,
    }


class GalerkinRun(SampledMotion):
    """A motion of ``u_m``, with what the existence proof says of it.

    It is a motion of the semi-discrete problem: OBSERVED evidence about the rod, at best.  That its energy obeys the
    bound of Lemma 3.2 shows that the run is sound, not that it is near the motion of the rod.
    """

    _subject: ClassVar[str] = "Galerkin space"
    _heading: ClassVar[str] = "Motion in a Galerkin space"

    model: GalerkinModel = quantity("The rod and the space", key="rod", plainly=lambda model: plain(_rod(model.rod)))
    scenario: Scenario = quantity("Loads and initial data", plainly=datasets.scenario_dict)
    states: Array = quantity("(samples, 2m+5) rows of ``lure.rod.galerkin.model.Equations``", key="")
    contacts: tuple[Contact, ...] = quantity(
        "Every stretch of contact, in order",
        dims="contact",
        name="contact_",
        each=Contact,
        plainly=lambda contacts: [[contact.start, contact.end] for contact in contacts],
    )
    steps: int = quantity("Time steps taken")
    method: Method = quantity("Integrator", key="")

    @property
    def about(self) -> str:
        """Which object moves, in words."""
        return f"the Galerkin space {self.model.space.name} of dimension {self.model.space.order}, not the rod"

    @property
    def how(self) -> str:
        """How the motion was computed."""
        name = self.model.space.name
        kind = "cosine modes" if name == "cosine" else f"{name} elements"
        return (
            f"weak form in {kind}, integrated by scipy's {self.method} between contacts and releases, located as events"
        )

    @property
    @derived("m", dims="t basis")
    def coefficients(self) -> Array:
        """(samples, m) coefficients ``a`` of the displacement ``u_m = sum a_j w_j`` [m]."""
        return self.states[:, : self.model.space.order]

    @property
    @derived("m s-1", dims="t basis")
    def velocities(self) -> Array:
        """(samples, m) coefficients ``b = a'`` of the velocity [m/s]."""
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
        return self.model.rod.nonlinearity(self.z)

    @property
    def energy(self) -> Array:
        """(samples,) ``E_m`` [J]."""
        return self.model.energy(self.coefficients, self.velocities)

    @property
    @derived("J", dims="t")
    def dissipated(self) -> Array:
        """(samples,) energy lost in the dashpot since the start, ``int_0^t k u_t(s,0)^2 ds`` [J]."""
        return self.states[:, -5]

    @property
    @derived("J", dims="t")
    def supplied(self) -> Array:
        """(samples,) work of the loads since the start, ``int_0^t (g u_t(s,0) + int f u_t dx) ds`` [J]."""
        return self.states[:, -4]

    @property
    @derived("N s", dims="t")
    def impulse(self) -> Array:
        """(samples,) impulse given to the obstacle since the start, ``int_0^t A(L) p ds`` [N s]."""
        return self.states[:, -1]

    @property
    @derived()
    def energy_residual(self) -> float:
        """Largest ``|E_m(t) - E_m(0) + dissipated - supplied|`` over the samples, relative to the largest of these [-].

        The identity is exact for ``u_m``, so this is the error of the time integration alone; 0 if all vanish.
        """
        energy = self.energy
        parts = (energy, self.dissipated, self.supplied)
        size = max(float(np.abs(part).max()) for part in parts)
        return float(np.abs(energy - energy[0] + self.dissipated - self.supplied).max()) / size if size else 0.0

    @property
    @derived("J", dims="t", name="energy_bound")
    def gronwall_bound(self) -> Array | None:
        """(samples,) bound of Lemma 3.2 on the energy, :meth:`bound` at the rate 1/s [J]; None where it has none."""
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
                f"the bound of Lemma 3.2 needs k > 0, or k = 0 and no force g; the damping is {k:g} N s/m",
                code=Reason.UNDAMPED,
            )
        given = (force / (2.0 * k) if k > 0 else 0.0) + body / (2.0 * rate)
        base = np.asarray(self.energy[0] + given)
        with np.errstate(over="ignore", divide="ignore"):
            return np.asarray(np.exp(np.log(base) + rate * self.t))

    @property
    @derived(key="energy_within_bound")
    def within_bound(self) -> bool | None:
        """Whether the energy at the samples obeys the bound of Lemma 3.2, to rounding; None without a bound.

        At the start the two are equal.
        """
        bound, energy = self.gronwall_bound, self.energy
        return None if bound is None else bool((energy <= bound + _ROUNDING * float(energy.max())).all())

    def to_dict(self) -> dict[str, Any]:
        """What is said of the motion as plain JSON data; the curves are in :meth:`to_xarray`."""
        return super().to_dict() | {
            "space": self.model.space.name,
            "order": self.model.space.order,
            "largest_z_at_samples": float(self.z.max()),
            "energy_start": float(self.energy[0]),
            "energy_end": float(self.energy[-1]),
            "method": self.how,
        }

    def _columns(self) -> dict[str, Column]:
        """The ends, the energy account and all coefficients, along ``t``, ``basis`` and ``contact``."""
        space, v_0 = self.model.space, self.velocities @ self.model.space.left
        found = super()._columns() | datasets.series(
            {
                "u_end": self.u_end,
                "z": self.z,
                "v_end": self.velocities @ space.right,
                "stress": self.contact_stress,
                "dashpot_force": self.model.rod.damping * v_0,
                "v_0": v_0,
                "energy": self.energy,
            }
        )
        found["basis"] = numbered("basis", space.order, f"number of the function w_j of the space {space.name}")
        if space.name != "cosine":
            nodes = np.linspace(0.0, space.length, space.order)
            found["node"] = Column(("basis",), nodes, "m", "place of the node at which w_j is 1", aside=True)
        return found

    def _attributes(self) -> dict[str, object]:
        space, exponent = self.model.space, self.model.rod.nonlinearity.exponent
        return {
            **super()._attributes(),
            **{f"rod_{name}": value for name, value in _rod(self.model.rod).items()},
            **{f"rod_{name}_units": unit for name, unit in datasets.UNITS.items()},
            **({} if exponent == 1.0 else {"rod_compliance_units": f"m{exponent:g} Pa-1"}),
            **datasets.scenario_attributes(self.scenario),
            "energy_residual": self.energy_residual,
            "method_space": space.name,
            "method_order": space.order,
            "method_steps": self.steps,
        }

    def to_control(self) -> control.TimeResponseData:
        """The motion as python-control has it: output ``sigma = z`` [m], inputs ``mu = -p(z)`` [Pa] and ``g`` [N]."""
        name = self.about.removesuffix(", not the rod")
        return datasets.loop_response(name, self.t, self.z, self.contact_stress, self.scenario.force(t=self.t))

    def _page(self) -> Page:
        said = {None: "not claimed here", True: "holds", False: "VIOLATED"}[self.within_bound]
        rows = [
            ("what moved", self.about),
            ("time", f"0 s to {self.t[-1]:g} s, {self.t.size} samples"),
            ("force g(t) [N]", self.scenario.force),
            ("contacts", len(self.contacts) or "none"),
            ("largest z", f"{self.z.max():.9g} m, at the samples"),
            ("energy", f"{self.energy[0]:.6g} J at the start, {self.energy[-1]:.6g} J at the end"),
            ("energy identity", f"relative residual {self.energy_residual:.1g}"),
            ("bound of Lemma 3.2 at the samples", said),
        ]
        return Page(
            f"motion of u_m, {self.steps} steps of {self.method}", rows, verdict="OBSERVED", notes=(self.comment,)
        )

    def __str__(self) -> str:
        """One sentence."""
        space, contact = self.model.space, number_of_contacts(len(self.contacts))
        return (
            f"Galerkin {space.name} of dimension {space.order} up to {self.t[-1]:.6g} s: {contact}, largest z = "
            f"{self.z.max():.9g} m at the samples, energy identity to {self.energy_residual:.1g}"
        )


_MOST_STEPS = 100_000
_LARGEST_IMPLICIT = 300
_LOOKS = 513
_DEGREE = 7  # of scipy's interpolants: 7 for DOP853, 3 for Radau
_POINTS = step_points(_DEGREE)


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
        contacts = run.go(np.concatenate((a, b, np.zeros(INTEGRALS))), [0.0, *scenario.breaks(until), until])
    return GalerkinRun(
        model=model,
        scenario=scenario,
        t=run.times,
        states=run.rows,
        contacts=contacts,
        steps=run.steps,
        method=method,
    )


@dataclass(kw_only=True, slots=True, eq=False)
class _Integration:
    """A run as it proceeds: samples filled in, steps taken, the state, largest ``|u(t, L)|`` seen [m]."""

    equations: Equations
    method: Method
    atol: Array
    times: Array
    rows: Array
    filled: int = 0
    steps: int = 0
    reach: float = 0.0
    y: Array = field(init=False)

    def go(self, y: Array, edges: list[float]) -> tuple[Contact, ...]:
        """Integrate from edge to edge, and on each piece from contact to release to contact; the contacts."""
        m, model = self.equations.model.space.order, self.equations.model
        z, rise = float(model.space.right @ y[:m]) - model.rod.gap, float(model.space.right @ y[m : 2 * m])
        self.y, self.rows[0], self.filled = y, y, 1
        return in_phases(edges, self._phase, touching=z > 0 or (z == 0 and rise > 0))

    def _phase(self, t: float, span: tuple[float, float], touching: bool, watch: bool) -> tuple[float, bool]:  # noqa: FBT001  (see in_phases)
        """Integrate until the phase or the span ends: the instant, and whether the phase ended.

        Raises
        ------
        InputError
            The integrator gives up, or the state is no longer finite.
        """
        from scipy.integrate import DOP853, Radau

        rate = partial(self.equations.rate, touching=touching, span=span)
        if self.method == "Radau":
            slopes = partial(self.equations.jacobian, touching=touching, span=span)
            solver = Radau(rate, t, self.y, span[1], rtol=2.3e-13, atol=self.atol, jac=slopes)
        else:
            solver = DOP853(rate, t, self.y, span[1], rtol=2.3e-13, atol=self.atol)
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
                self.y = np.asarray(dense(stop))
                return stop, True
            self._record(dense, solver.t)
            watch = True
        self.y = np.asarray(solver.y)
        return span[1], False

    def _end_of_phase(
        self, dense: Callable[[Array], Array], start: float, end: float, *, touching: bool
    ) -> float | None:
        """Share of the step at which ``z`` takes the wrong sign for the phase, by more than rounding; None if never."""
        states = dense(start + _POINTS * (end - start))
        m, model = self.equations.model.space.order, self.equations.model
        position = model.space.right @ states[:m]
        self.reach = max(self.reach, float(np.abs(position).max()))
        noise = 64 * np.finfo(float).eps * (self.reach + abs(model.rod.gap))
        return turning_negative((position - model.rod.gap) * (1.0 if touching else -1.0), noise)

    def _record(self, dense: Callable[[Array], Array], stop: float) -> None:
        """Samples up to ``stop``."""
        last = int(np.searchsorted(self.times, stop, side="right"))
        if last > self.filled:
            self.rows[self.filled : last] = dense(self.times[self.filled : last]).T
            self.filled = last


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


def _check(model: GalerkinModel, until: object, samples: int, tolerance: float, method: object) -> None:
    """Refuse what cannot be run."""
    demand_seconds("galerkin.until", until)
    demand_whole("galerkin.samples", samples, 2, 10**6)
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
