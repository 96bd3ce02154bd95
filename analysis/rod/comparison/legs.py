"""One smooth piece of a motion of the scheme, and what the integrators of scipy and CVODE make of it.

Its ordinary differential equations under loads are folded so that they are banded.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.energy import discrete_energy
from lure.arrays import Reals as Array
from lure.errors import InputError
from lure.record import described, quantity
from lure.rod.datasets import step_points, turning_negative
from lure.rod.discretisation import UpwindScheme, upwind
from lure.rod.scenario import Scenario, initial_state

if TYPE_CHECKING:
    from scipy.sparse import csc_array

BAND = 2
_LOOKS = 1025
ScipyMethod = Literal["RK45", "DOP853", "Radau", "BDF", "LSODA"]
_DEGREE = 12  # the largest of scipy's interpolants: LSODA's, of its order
_POINTS = step_points(_DEGREE)
_NEAR = 2.0
CvodeMethod = Literal["CVODE", "CVODE-Adams"]
_ROOT = 2
_MOST_STEPS = 10_000_000
_CLOSE = 1e-13
_FINER, _DEEPEST = 16, 3
_CELL, _GRAZE = 0.5, 0.02
_SHARES = np.linspace(0.0, 1.0, 33)[1:-1]


@described(frozen=True, kw_only=True, eq=False)
class SchemeEquations:
    """``y' = A y + b1 mu + b2 g + f``-terms of the scheme, ``mu = -p(z)``, with both waves of a place side by side.

    The folded state is ``[y_1, y_{2N}, y_2, y_{2N-1}, .., y_N, y_{N+1}, z]`` in the numbering of (39): the ring of the
    scheme is laid flat, and no equation reaches farther than two places, so that every matrix of an implicit method is
    banded.  A body force adds ``f/(rho A)`` to each wave where it stands.
    """

    scheme: UpwindScheme = quantity("The scheme; its own ordering does not matter here")
    scenario: Scenario = quantity("Loads and initial data")

    @cached_property
    def plain(self) -> UpwindScheme:
        """The scheme in the ordering (39)."""
        return upwind(self.scheme.rod, self.scheme.cells, form=self.scheme.form)

    @cached_property
    def fold(self) -> NDArray[np.intp]:
        """(2N+1,) ``folded = y_39[fold]``."""
        N = self.scheme.cells
        places = np.empty(2 * N + 1, dtype=np.intp)
        places[0 : 2 * N : 2] = np.arange(N)
        places[1 : 2 * N : 2] = np.arange(2 * N - 1, N - 1, -1)
        places[-1] = 2 * N
        return places

    @cached_property
    def start(self) -> Array:
        """(2N+1,) initial state, folded."""
        return np.asarray(initial_state(self.plain, self.scenario)[self.fold])

    def unfolded(self, states: Array) -> Array:
        """States (..., 2N+1) in the ordering (39)."""
        plain = np.empty_like(states)
        plain[..., self.fold] = states
        return plain

    def observed(self, states: Array) -> Array:
        """(k, 3) contact coordinate ``z`` [m], velocity ``v(t, L)`` [m/s] and energy [J] of folded states (k, 2N+1)."""
        z = states[:, -1]
        velocity = states[:, -3] - self.scheme.rod.mobility * self.scheme.rod.nonlinearity(z)
        return np.column_stack((z, velocity, discrete_energy(self.plain, self.unfolded(states))))

    @cached_property
    def _force_gain(self) -> float:
        """What ``g`` adds to ``y_1'`` [m/(N s^2)]."""
        return float(self.plain.b2[0])

    @cached_property
    def _grid(self) -> Array:
        return self.scheme.rod.length * np.arange(self.scheme.cells + 1) / self.scheme.cells

    def rate(self, t: float, y: Array, *, touching: bool, span: tuple[float, float]) -> Array:
        """``y'`` on one smooth piece: ``p = 0`` in flight and ``c_n |z|^m sign z`` in contact; folded (2N+1,).

        Raises
        ------
        InputError
            A load is not finite.
        """
        rod, N, s = self.scheme.rod, self.scheme.cells, self.scheme.rate
        force, body = self._loads(t, span)
        push = rod.mobility * rod.nonlinearity.continued(float(y[-1]))[0] if touching else 0.0
        change = np.empty(2 * N + 1)
        forward, backward = y[0 : 2 * N : 2], y[1 : 2 * N : 2]
        change[2 : 2 * N : 2] = s * (forward[:-1] - forward[1:])
        change[1 : 2 * N - 2 : 2] = s * (backward[1:] - backward[:-1])
        change[0] = -s * (forward[0] + rod.reflection * backward[0]) + self._force_gain * force
        change[2 * N - 1] = s * (forward[-1] - 2.0 * push - backward[-1])
        change[2 * N] = forward[-1] - push
        if body is not None:
            change[0 : 2 * N : 2] += body[1:]
            change[1 : 2 * N : 2] += body[:-1]
        return change

    def jacobian(self, y: Array, *, touching: bool) -> csc_array:
        """``dy'/dy`` (2N+1, 2N+1), sparse with two diagonals on either side [1/s]."""
        from scipy.sparse import csc_array

        rod = self.scheme.rod
        slope = rod.nonlinearity.continued(float(y[-1]))[1] if touching else 0.0
        free, pressed = self._slopes
        return csc_array(free - slope * pressed)

    @cached_property
    def _slopes(self) -> tuple[csc_array, csc_array]:
        """``A`` and ``b1 c^T``, folded."""
        from scipy.sparse import csc_array

        block, fold = self.plain.block, self.fold
        pressed = csc_array(block.b1[fold][:, None]) @ csc_array(block.c[fold][None, :])
        return csc_array(block.A[fold][:, fold]), pressed

    def speed(self, until: float) -> float:
        """A velocity of the size the data and the loads suggest, 1 if they suggest none [m/s]."""
        rod, times = self.scheme.rod, np.linspace(0.0, until, _LOOKS)
        span = (0.0, until)
        started = float(np.abs(self.start[:-1]).max())
        if self.scenario.free:
            return started or 1.0
        loads = [self._loads(float(t), span) for t in times]
        pushed = self._force_gain / self.scheme.rate * max(abs(force) for force, _ in loads)
        carried = rod.travel_time * max(0.0 if body is None else float(np.abs(body).max()) for _, body in loads)
        return max(started, pushed, carried) or 1.0

    def _loads(self, t: float, span: tuple[float, float]) -> tuple[float, Array | None]:
        """``g`` [N] and ``f/(rho A)`` (N+1,) [m/s^2], as :meth:`.Scenario.loads` reads them."""
        if self.scenario.free:
            return 0.0, None
        force, body = self.scenario.loads(t, self._grid, span)
        return force, None if body is None else body / (self.scheme.rod.density * self.scheme.rod.area)


@described(frozen=True, kw_only=True, eq=False)
class Leg:
    """Flight or contact from an instant on, until it ends or a load changes its formula."""

    equations: SchemeEquations = quantity("What to integrate")
    touching: bool = quantity("Whether the law of contact or that of flight holds")
    start: float = quantity("From when", "s")
    end: float = quantity("To when at most", "s")
    span: tuple[float, float] = quantity("Instants between which the formulas of the loads do not change", "s")
    y: Array = quantity("(2N+1,) folded state at the start")
    times: Array = quantity("Instants at which the motion is wanted, from the start to the end of the leg", "s")
    longest: float = quantity("Longest step, and longest stretch over which the sign of ``z`` is not looked at", "s")
    rtol: float = quantity("Relative tolerance")
    atol: Array = quantity("(2N+1,) absolute tolerance, folded [m/s] and, for ``z``, [m]")
    watch: bool = quantity(
        "Whether the first step may end the leg; not, if rounding has just ended several at this instant", default=True
    )

    def rate(self, t: float, y: Array) -> Array:
        """``y'``."""
        return self.equations.rate(t, y, touching=self.touching, span=self.span)

    @property
    def noise(self) -> float:
        """Sizes of ``z`` below this say nothing [m]."""
        return 1e-3 * float(self.atol[-1]) + 64.0 * float(np.finfo(float).eps) * abs(float(self.y[-1]))

    def depth(self, z: Array) -> Array:
        """``z`` with the sign that the leg should keep: positive while the leg may go on."""
        return z if self.touching else -z


@described(frozen=True, kw_only=True, eq=False)
class Walked:
    """How far a leg went."""

    t: float = quantity("Where it ended", "s")
    y: Array = quantity("(2N+1,) state there")
    rows: Array = quantity("(k, 3) what was observed at the wanted instants up to there")
    left: bool = quantity("Whether the phase ended, and not merely the leg")
    steps: int | None = quantity("Steps taken; None if the integrator does not tell")
    evaluations: int = quantity("Evaluations of the right-hand side, those for difference quotients included")


@dataclass(kw_only=True, slots=True, eq=False)
class Counted:
    """A right-hand side that counts its evaluations."""

    leg: Leg
    count: int = 0

    def __call__(self, t: float, y: Array) -> Array:
        """``y'``, and one evaluation more."""
        self.count += 1
        return self.leg.rate(t, y)

    def into(self, t: float, y: Array, out: Array) -> None:
        """The same, written into an array."""
        out[:] = self(t, y)


def stopping(leg: Leg, method: str, t: float, why: str) -> str:
    """The sentence about a run that an integrator cannot finish."""
    advice = 'method="exact" or "Radau"' if leg.equations.scheme.cells <= 1000 else 'method="Radau"'
    return f"until cannot be reached by {method}: at t = {t:g} s it stops ({why}); give another tolerance or {advice}"


def at_zero(y: Array) -> Array:
    """The state with ``z = 0`` exactly, as it is where contact begins or ends."""
    settled = np.array(y)
    settled[-1] = 0.0
    return settled


def stacked(parts: list[Array]) -> Array:
    """Observations one below the other."""
    return np.concatenate(parts) if parts else np.empty((0, 3))


def scipy_leg(leg: Leg, method: ScipyMethod) -> Walked:
    """Integrate a leg.

    On each step the interpolant of ``z`` is a polynomial; where a root of it ends the phase, the step ends, so that no
    contact of the interpolant is missed, however short.  In flight steps are not looked at on which the largest wave
    could not carry ``z`` half the way to the obstacle.

    ``leg``: the piece; ``method``: name of a class of ``scipy.integrate``.

    Raises
    ------
    InputError
        The integrator gives up, or the state is no longer finite.
    """
    rate = Counted(leg=leg)
    solver = _scipy(leg, method, rate)
    rows, filled, steps, watch = [], 0, 0, leg.watch
    while solver.status == "running":
        before = np.array(solver.y)
        message = solver.step()
        steps += 1
        if solver.status == "failed" or not np.isfinite(solver.y).all():
            raise InputError(stopping(leg, method, float(solver.t), message or "the state is not finite"))
        dense: Callable[[Array], Array] | None = None
        stop = None
        if watch and (leg.touching or _near(solver, before)):
            dense = solver.dense_output()
            stop = _end_of_phase(dense, float(solver.t_old), float(solver.t), leg)
        reached = float(solver.t) if stop is None else stop
        last = int(np.searchsorted(leg.times, reached, side="right"))
        if last > filled:
            dense = dense or solver.dense_output()
            rows.append(leg.equations.observed(np.asarray(dense(leg.times[filled:last])).T))
            filled = last
        if stop is not None and dense is not None:
            y = at_zero(np.asarray(dense(np.array([stop])))[:, 0])
            return Walked(t=stop, y=y, rows=stacked(rows), left=True, steps=steps, evaluations=rate.count)
        watch = True
    y = np.array(solver.y)
    return Walked(t=leg.end, y=y, rows=stacked(rows), left=False, steps=steps, evaluations=rate.count)


def _scipy(leg: Leg, method: ScipyMethod, rate: Counted) -> Any:  # noqa: ANN401  (scipy has no types)
    """The integrator, with the Jacobian in the form it takes; it is banded for LSODA and sparse for the others."""
    from scipy import integrate

    def slopes(_t: float, y: Array) -> Any:  # noqa: ANN401  (scipy has no types)
        """The Jacobian of the leg."""
        return leg.equations.jacobian(y, touching=leg.touching)

    options: dict[str, Any] = {"rtol": leg.rtol, "atol": leg.atol, "max_step": leg.longest}
    if method == "LSODA":
        options |= {"lband": BAND, "uband": BAND}
    elif method in ("Radau", "BDF"):
        options["jac"] = slopes
    return getattr(integrate, method)(rate, leg.start, leg.y, leg.end, **options)


def _near(solver: Any, before: Array) -> bool:  # noqa: ANN401  (scipy has no types)
    """Whether ``z`` might reach the obstacle within the step: waves grow by the loads alone."""
    fastest = max(float(np.abs(before[:-1]).max()), float(np.abs(solver.y[:-1]).max()))
    highest = max(float(before[-1]), float(solver.y[-1]))
    return highest + _NEAR * fastest * float(solver.t - solver.t_old) >= 0.0


def _end_of_phase(dense: Callable[[Array], Array], start: float, end: float, leg: Leg) -> float | None:
    """Instant on the step from which ``z`` has the wrong sign by more than noise; None if it never has."""
    z = np.asarray(dense(start + _POINTS * (end - start)))[-1]
    share = turning_negative(leg.depth(z), leg.noise)
    return None if share is None else start + share * (end - start)


def cvode_leg(leg: Leg, method: CvodeMethod, *, depth: int = 0) -> Walked:
    """Integrate a leg; ``"CVODE"`` by its BDF of order up to 5, ``"CVODE-Adams"`` of order up to 12.

    Newton's method with the banded Jacobian by difference quotients, which for these equations are exact to rounding
    where the nonlinearity is linear.  CVODE compares signs at the ends of its steps; here they are also compared at
    every sample and at least every ``leg.longest``, near the obstacle twice for every cell a wave passes.  Where the
    cubic through ``z`` and ``z'`` at two such instants changes sign between them, or all but does, the stretch is run
    again with sixteen times as many; what neither shows is missed.

    ``depth``: how often the stretch was refined.

    Raises
    ------
    InputError
        scikit-sundae is not installed, or CVODE gives up.
    """
    rate = Counted(leg=leg)
    if leg.end - leg.start <= _CLOSE * leg.end:
        rest = leg.equations.observed(np.tile(leg.y, (leg.times.size, 1)))
        return Walked(t=leg.end, y=leg.y, rows=rest, left=False, steps=None, evaluations=0)
    solver = _cvode(leg, method, rate)
    solver.init_step(leg.start, leg.y)
    close = leg.times <= leg.start * (1.0 + _CLOSE)  # CVODE does not start for so short a way
    rows, wanted = [leg.equations.observed(np.tile(leg.y, (int(close.sum()), 1)))], leg.times[~close]
    t, y, extra, watch = leg.start, leg.y, 0, leg.watch
    while t < leg.end:
        look = min(leg.end, t + _stride(leg, y), *wanted[:1].tolist())
        found = solver.step(look, method="normal", tstop=leg.end)
        if not found.success or not np.isfinite(found.y).all():
            raise InputError(stopping(leg, method, float(found.t), str(found.message)))
        new_t, new, root = float(found.t), np.array(found.y), found.status == _ROOT
        if not root and watch and float(leg.depth(new[-1:])[0]) < -leg.noise:
            new_t, new, root = t, y, True  # CVODE sees no change of sign where z starts from zero
        elif depth < _DEEPEST and not root and _doubtful(leg, (t, y), (new_t, new)):
            part = replace(leg, start=t, y=y, end=new_t, times=np.empty(0), longest=(new_t - t) / _FINER)
            again = cvode_leg(part, method, depth=depth + 1)
            extra += again.evaluations
            if again.left:
                new_t, new, root = again.t, again.y, True
        if not root and wanted.size and wanted[0] <= new_t:
            rows.append(leg.equations.observed(new[None, :]))
            wanted = wanted[1:]
        t, y, watch = new_t, new, True
        if root:
            break
    else:
        root = False
    y = at_zero(y) if root else y
    return Walked(t=t, y=y, rows=stacked(rows), left=root, steps=None, evaluations=rate.count + extra)


def _stride(leg: Leg, y: Array) -> float:
    """How long ``z`` need not be looked at: half a cell where it could reach the obstacle within two longest steps."""
    near = abs(float(y[-1])) <= _NEAR * leg.longest * float(np.abs(y[:-1]).max(initial=0.0))
    return min(leg.longest, _CELL / leg.equations.scheme.rate) if near else leg.longest


def _cvode(leg: Leg, method: CvodeMethod, rate: Counted) -> Any:  # noqa: ANN401  (scikit-sundae has no types)
    try:
        from sksundae.cvode import CVODE
    except ImportError:
        raise InputError(f'method {method!r} needs scikit-sundae: pip install "lure[cvode]"') from None

    class Event:
        """``z``, which ends the leg where it falls through zero in contact and rises through it in flight."""

        terminal = (True,)
        direction = (-1 if leg.touching else 1,)

        def __call__(self, _t: float, y: Array, out: Array) -> None:
            out[0] = y[-1]

    return CVODE(
        rate.into,
        method="Adams" if method == "CVODE-Adams" else "BDF",
        rtol=leg.rtol,
        atol=leg.atol,
        max_step=leg.longest,
        max_num_steps=_MOST_STEPS,
        linsolver="band",
        lband=BAND,
        uband=BAND,
        eventsfn=Event(),
        num_events=1,
    )


def _doubtful(leg: Leg, before: tuple[float, Array], after: tuple[float, Array]) -> bool:
    """Whether the cubic through ``z`` and ``z'`` at both instants takes the wrong sign between them, or nearly."""
    (t0, y0), (t1, y1) = before, after
    span, nonlinearity, mobility = t1 - t0, leg.equations.scheme.rod.nonlinearity, leg.equations.scheme.rod.mobility
    ends = np.array([y0[-1], y1[-1]])
    slopes = np.array([y0[-3], y1[-3]]) - (mobility * nonlinearity(ends) if leg.touching else 0.0)
    s = _SHARES
    cubic = leg.depth(
        (1.0 + 2.0 * s) * (1.0 - s) ** 2 * ends[0]
        + s * (1.0 - s) ** 2 * span * slopes[0]
        + s**2 * (3.0 - 2.0 * s) * ends[1]
        - s**2 * (1.0 - s) * span * slopes[1]
    )
    least = float(cubic.min())
    return least < -leg.noise or least < min(float(leg.depth(ends).min()), _GRAZE * span * float(np.abs(slopes).max()))
