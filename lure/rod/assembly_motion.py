"""The exact motion of rods with several contacts: what is known of it at any time and place."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from lure.errors import InputError, demand_whole
from lure.record import Record, described, plain, quantity
from lure.rod.assembly import RodAssembly
from lure.rod.datasets import Contact
from lure.rod.motion.network import Line, Network, Run, Step, begun
from lure.rod.motion.pieces import Array, values
from lure.rod.scenario import Scenario

if TYPE_CHECKING:
    from collections.abc import Callable
    from fractions import Fraction

    from lure.expressions import Expression
    from lure.rod.parameters import Rod

_BALANCED = 200  # instants at which the energy is added up
_MOST_TRANSITS = 100_000
_PASSAGES = 20


class AssemblySamples(Record):
    """A motion of rods with several contacts at evenly spaced instants."""

    about: str = quantity("The object in words")
    t: Array = quantity("time", "s", dims="t")
    sigma: Array = quantity("how far each contact has closed", "m", dims="t contact")
    stress: Array = quantity("contact stress ``p_i(sigma_i)``", "Pa", dims="t contact")
    contact_force: Array = quantity("contact force, the stress times its area", "N", dims="t contact")
    u_end: Array = quantity("displacement of the end ``x = L``, positive along x", "m", dims="t rod")
    u_0: Array = quantity("displacement of the end ``x = 0``, positive along x", "m", dims="t rod")
    obstacle: Array = quantity("displacement of the obstacle", "m", dims="t")
    energy: Array = quantity("energy of the waves and of the contacts", "J", dims="t")
    energy_residual: float = quantity("Error of the energy balance, relative")
    error: float = quantity("Estimate of the sum of all local errors, as displacement", "m")
    _kind = "motion of several rods"


@described(frozen=True, kw_only=True, eq=False, slots=True)
class AssemblyMotion:
    """A motion of rods with several contacts, without grid or time step; made by :func:`assembly_motion`.

    Evidence: COMPUTED, about this motion and no other.
    """

    assembly: RodAssembly = quantity("The rods and their contacts")
    scenarios: tuple[Scenario, ...] = quantity("Force and initial data of each rod")
    until: float = quantity("End of the motion", "s")
    contacts: tuple[tuple[Contact, ...], ...] = quantity(
        "The stretches of each contact, in order; the last is not closed if it still touches"
    )
    energy_residual: float = quantity(
        "Largest ``|E(t) + what was lost in dashpots and obstacle - work of the forces - E(0)|`` at 200 instants, "
        "relative to the largest energy, work or loss. ``E`` is an integral of the waves in the rods, the rest one "
        "of velocities over time"
    )
    error: float = quantity("Sum of the estimates of all local errors, as displacement", "m")
    run: Run = quantity("The waves as they were made")
    steps: tuple[Step, ...] = quantity("What happened between events")

    def sigma(self, t: ArrayLike) -> Array:
        """(.., m) how far each contact has closed [m] at instants (..) [s] from 0 to ``until``."""
        return self._read(t, "sigma")

    def stresses(self, t: ArrayLike) -> Array:
        """(.., m) contact stress ``p_i = max(sigma_i - gap_i, 0)/eps_i`` [Pa]."""
        return np.maximum(self._read(t, "stress"), 0.0)

    def forces(self, t: ArrayLike) -> Array:
        """(.., m) contact force, the stress times the area on which it acts [N]."""
        return np.asarray(self.stresses(t) * self.run.network.areas)

    def ends(self, t: ArrayLike) -> tuple[Array, Array]:
        """(.., n) displacement of the ends ``x = 0`` and ``x = L`` of each rod [m]."""
        return self._read(t, "near"), self._read(t, "far")

    def obstacle(self, t: ArrayLike) -> Array:
        """(..) displacement ``w`` of the obstacle [m]."""
        return np.asarray(self._read(t, "plate")[..., 0])

    def waves(self, number: int, t: ArrayLike, x: ArrayLike) -> tuple[Array, Array]:
        """``r1 = v - c w`` and ``r2 = v + c w`` [m/s] of a rod, counted from 0, at ``(t, x)``, elementwise.

        Raises
        ------
        InputError
            A point lies outside the rod or the times of the motion, or there is no such rod.
        """
        rod, T = self._rod(number)
        times, places = np.broadcast_arrays(self._times(t), np.asarray(x, dtype=float) / rod.length)
        if not np.all((places >= 0) & (places <= 1)):
            raise InputError(f"x leaves the rod; give places in [0, {rod.length:g}] m")
        forth = self.run.forward[number].at((times - T * places).ravel())
        back = self.run.backward[number].at((times - T * (1 - places)).ravel())
        return forth.reshape(times.shape), back.reshape(times.shape)

    def displacement(self, number: int, t: float, x: ArrayLike) -> Array:
        """``u(t, x)`` [m] of a rod, counted from 0, at one time and any places: from ``x = L`` by the strain."""
        rod, T = self._rod(number)
        time, places = float(self._times(t)), np.asarray(x, dtype=float) / rod.length
        forth, back, second = self.run.forward[number], self.run.backward[number], self.run.network.seconds
        ends = forth.totals(time - T)[0], back.totals(time)[0]
        inside = [
            (back_end - back.totals(time - T * (1 - y))[0]) - (forth.totals(time - T * y)[0] - forth_end)
            for y in places.ravel().tolist()
            for forth_end, back_end in (ends,)
        ]
        return np.asarray(self.ends(t)[1][number] - 0.5 * second * np.reshape(inside, places.shape))

    def energies(self, t: ArrayLike) -> Array:
        r"""(..) ``E(t) = sum_j A/2 int (rho v^2 + E w^2) dx + sum_i A_i P_i(sigma_i)`` [J]."""
        times, net = self._times(t), self.run.network
        stored = 0.5 * net.areas * net.compliance * self.stresses(t) ** 2
        waves = [_wave_energy(self.run, time) for time in times.ravel().tolist()]
        return np.asarray(np.reshape(waves, times.shape) + stored.sum(axis=-1))

    def sampled(self, samples: int = 2001) -> AssemblySamples:
        """The motion at evenly spaced instants, with units, as a record that knows ``to_xarray``.

        Parameters
        ----------
        samples : int
            Number of instants, 2 to 20001.

        Raises
        ------
        InputError
            ``samples`` is out of range.
        """
        demand_whole("samples", samples, 2, 20_001)
        t = np.linspace(0.0, self.until, samples)
        near, far = self.ends(t)
        return AssemblySamples(
            about=self.assembly.words,
            t=t,
            sigma=self.sigma(t),
            stress=self.stresses(t),
            contact_force=self.forces(t),
            u_end=far,
            u_0=near,
            obstacle=self.obstacle(t),
            energy=self.energies(t),
            energy_residual=self.energy_residual,
            error=self.error,
        )

    def to_dict(self) -> dict[str, object]:
        """What is said of the motion as plain JSON data; the curves are in :meth:`sampled`."""
        energy = self.energies([0.0, self.until]).tolist()
        return {
            "about": self.assembly.words,
            "evidence": "computed",
            "until": self.until,
            "contacts": plain(self.contacts),
            "energy": {"start": energy[0], "end": energy[1]},
            "energy_residual": self.energy_residual,
            "error": self.error,
        }

    def __str__(self) -> str:
        counts = ", ".join(str(len(one)) for one in self.contacts)
        return (
            f"{self.assembly.words}, followed for {self.until:.4g} s: {counts} stretches of contact; error about "
            f"{self.error:.1g} m, energy balance {self.energy_residual:.1g} (computed, of this motion alone)"
        )

    def _rod(self, number: int) -> tuple[Rod, float]:
        if not 0 <= number < len(self.assembly.rods):
            raise InputError(f"there is no rod {number}; they are counted from 0 to {len(self.assembly.rods) - 1}")
        return self.assembly.rods[number], float(self.run.network.travel[number])

    def _times(self, t: ArrayLike) -> Array:
        times = np.asarray(t, dtype=float)
        if not np.all((times >= 0) & (times <= self.until)):
            raise InputError(f"t leaves the motion; give times in [0, {self.until:g}] s")
        return times / self.run.network.seconds

    def _read(self, t: ArrayLike, name: str) -> Array:
        times = self._times(t)
        flat = times.ravel()
        low = np.array([step.low for step in self.steps])
        i = np.clip(np.searchsorted(low, flat, side="right") - 1, 0, len(low) - 1)
        high = np.array([step.high for step in self.steps])
        x = np.clip(((flat - low[i]) - (high[i] - flat)) / (high[i] - low[i]), -1.0, 1.0)
        series = np.array([getattr(step, name) for step in self.steps])[i]
        rows = series.shape[1]
        found = values(series.reshape(-1, series.shape[2]), np.repeat(x, rows)[:, None])
        return np.asarray(found.reshape(*times.shape, rows))


def assembly_motion(
    assembly: RodAssembly, scenarios: Sequence[Scenario] = (), until: float | None = None
) -> AssemblyMotion:
    r"""Motion of rods with several contacts on ``[0, until]``, to rounding and the error of its series.

    By d'Alembert the waves travel unchanged, ``r1(t, L) = r1(t - T, 0)`` and ``r2(t, 0) = r2(t - T, L)``; at the ends
    ``v(L) = W + F_L/Z``, ``v(0) = (1 - a) X/2 + b F_0`` with the waves ``W``, ``X`` that arrive, and ``sigma' = ... -
    M p(sigma)`` is an ordinary differential equation, linear while no contact opens or closes.  It is solved by
    collocation in Chebyshev series of degree 16, on steps that end where anything that arrives has a kink and where a
    contact opens or closes; these instants are found by bounds on the series over whole intervals, so that no contact
    is missed but by rounding.  There is no grid.  Travel times may have any ratio; where it is not a simple one kinks
    multiply with time.

    Parameters
    ----------
    assembly : RodAssembly
        The rods, each with any damping that a rod may have.
    scenarios : sequence of Scenario
        For each rod the force ``g(t)`` at ``x = 0`` [N], and initial displacement and velocity; no body force.  By
        default those of the assembly.
    until : float, optional
        End of the motion [s], at most 100 000 transits of the rod with the shortest; by default that of the assembly.

    Returns
    -------
    AssemblyMotion
        Evidence: COMPUTED.

    Raises
    ------
    InputError
        There is not one scenario a rod, one has a body force, ``until`` is out of range, or data are not finite.
    AssumptionError
        The kinks multiply beyond 200 000 steps, or contact and flight cannot be told apart.

    Examples
    --------
    Two equal rods thrown at each other: each behaves as if it met an obstacle half way.

    >>> from fractions import Fraction
    >>> from lure.rod import Rod
    >>> rod = Rod(youngs_modulus=1, density=1, length=1, area=1, damping=1, compliance=1)
    >>> pair = RodAssembly(
    ...     arrangement="across-gap", rods=(rod, rod), compliances=(Fraction(1, 10),), gaps=(Fraction(1),)
    ... )
    >>> thrown = Scenario.parse(velocity=1)
    >>> motion = assembly_motion(pair, (thrown, thrown), until=4)
    >>> float(motion.sigma(0.5)[0]), round(motion.contacts[0][0].start, 12)
    (1.0, 0.5)
    """
    rods, data = assembly.rods, tuple(scenarios) or assembly.scenarios
    if until is None:
        until = assembly.until or _PASSAGES * max(rod.travel_time for rod in rods)
    if len(data) != len(rods):
        raise InputError(f"there are {len(data)} scenarios for {len(rods)} rods; give one for each")
    for number, one in enumerate(data, 1):
        if not one.body_force.is_zero:
            raise InputError(f"rod {number} has a body force; the motion of several rods takes forces at x = 0 alone")
    shortest = min(rod.travel_time for rod in rods)
    if isinstance(until, bool) or not 0 < until <= _MOST_TRANSITS * shortest:
        raise InputError(f"until is {until!r}; give a time from 0 to {_MOST_TRANSITS * shortest:.6g} s")
    run = _begun(assembly, data, float(until))
    net, end = run.network, float(until) / run.network.seconds
    first = _energy(run, 0.0)
    steps = tuple(run.steps(end))
    balance, largest = 0.0, first
    for step in steps[:: max(1, len(steps) // _BALANCED)] + steps[-1:]:
        stored = 0.5 * net.areas * net.compliance * step.stress.sum(axis=1) ** 2
        energy = _wave_energy(run, step.high) + float(stored.sum())
        balance, largest = max(balance, abs(energy + step.lost - first)), max(largest, energy, abs(step.lost))
    waves = (*run.forward, *run.backward)
    return AssemblyMotion(
        assembly=assembly,
        scenarios=data,
        until=float(until),
        contacts=tuple(tuple(one) for one in run.contacts),
        energy_residual=balance / largest if largest else 0.0,
        error=run.error + math.fsum(line.error for line in waves) * net.seconds,
        run=run,
        steps=steps,
    )


def _begun(assembly: RodAssembly, data: tuple[Scenario, ...], until: float) -> Run:
    rods = assembly.rods
    second = max(rod.travel_time for rod in rods)
    net = _network(assembly, second)
    shortest = float(net.travel.min())
    lines: list[list[Line]] = [[], []]
    edges: set[float] = set()
    forces: list[Callable[[Array], Array] | None] = []
    ends = np.empty((2, len(rods)))
    for j, (rod, one, T) in enumerate(zip(rods, data, net.travel.tolist(), strict=True)):
        kinks = [float(x) / rod.length for f in (one.displacement, one.velocity) for x in _kinks(f, rod.length)]
        for backward, into in enumerate(lines):

            def wave(tau: Array, rod: Rod = rod, one: Scenario = one, T: float = T, backward: int = backward) -> Array:
                """What left the end, read off the rod at the start."""
                share = np.clip(1.0 + tau / T if backward else -tau / T, 0.0, 1.0)
                return one.waves(rod, rod.length * share)[backward]

            breaks = [T * (x - 1.0) if backward else -T * x for x in kinks]
            into.append(begun(wave, T, breaks, shortest))
        if one.force.is_zero:
            forces.append(None)
        else:
            forces.append(partial(_force_at, one.force, second))
            edges |= {float(t) / second for t in one.force.breakpoints("t", 0.0, until) or ()}
        x = np.array([0.0, rod.length])
        ends[:, j] = np.asarray(one.displacement(x=x), dtype=float) + 0 * x
    sigma = net.closing @ ends[1] + net.opening @ ends[0]
    return Run(
        network=net,
        forward=lines[0],
        backward=lines[1],
        forces=forces,
        edges=sorted(edges),
        sigma=sigma,
        far=ends[1],
        near=ends[0],
    )


def _force_at(force: Expression, second: float, t: Array) -> Array:
    return np.asarray(force(t=second * t), dtype=float) + 0.0 * t


def _kinks(formula: Expression, length: float) -> tuple[Fraction, ...]:
    return formula.breakpoints("x", 0.0, length) or ()


def _network(assembly: RodAssembly, second: float) -> Network:
    rods, m = assembly.rods, assembly.contacts
    loads = [assembly.loads(j) for j in range(len(rods))]
    closing = np.array([assembly.closing(j) for j in range(len(rods))], dtype=float).T
    near, far = (np.array([[float(v) for v in load[end]] for load in loads]) for end in (0, 1))
    both = assembly.arrangement == "both-ends"
    opening = np.zeros((m, len(rods)))
    if both:
        opening[0, 0] = -1.0
    plate = 0.0 if assembly.obstacle_damping is None else 1.0 / float(assembly.obstacle_damping)
    return Network(
        seconds=second,
        travel=np.array([rod.travel_time / second for rod in rods]),
        reflection=np.array([rod.reflection for rod in rods]),
        gain=np.array([rod.input_gain for rod in rods]),
        impedance=np.array([rod.impedance for rod in rods]),
        damping=np.array([rod.damping for rod in rods]),
        far=far,
        near=near,
        closing=closing,
        opening=opening,
        areas=np.abs(near + far).max(axis=0),
        compliance=np.array([float(v) for v in assembly.compliances]),
        gaps=np.array([float(v) for v in assembly.gaps]),
        plate=plate,
    )


def _wave_energy(run: Run, t: float) -> float:
    """Energy of the waves that are in the rods at an instant [unit of time]."""
    total, net = 0.0, run.network
    for line_pair, T, Z in zip(
        zip(run.forward, run.backward, strict=True), net.travel.tolist(), net.impedance.tolist(), strict=True
    ):
        total += 0.25 * Z * net.seconds * sum(line.totals(t)[1] - line.totals(t - T)[1] for line in line_pair)
    return max(total, 0.0)


def _energy(run: Run, t: float) -> float:
    """Energy at the start."""
    net = run.network
    return _wave_energy(run, t) + float(
        (0.5 * net.areas / net.compliance * np.maximum(run.sigma - net.gaps, 0) ** 2).sum()
    )
