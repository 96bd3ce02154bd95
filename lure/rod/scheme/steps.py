r"""Steps of exact motion, free or against a spring: one step, the tables that make it cheap, and how long it may be.

Contact with a nonlinear or very stiff nonlinearity is collocated: the stress ``q = d p(z)`` of a step is a polynomial
through the Radau points; given ``q`` the waves and ``z`` are exact, so that the unknowns are the values of ``z`` at
those points, ``z_i + sum_j K_ij q(z_j) = z^0_i``, where ``z^0`` is the motion without stress and ``K`` the response of
``z`` to each polynomial.  For ``z`` alone this is Radau IIA collocation, stiffly accurate and L-stable; the waves add
no error.
"""

from __future__ import annotations

from dataclasses import field

import numpy as np

from lure.arrays import Reals as Array
from lure.record import described, quantity
from lure.rod.scheme.crossing import Mesh, mesh_of
from lure.rod.scheme.loads import TERMS, LoadFit, LoadGrid, load_grid
from lure.rod.scheme.poisson import chebyshev_sequences, chebyshev_values, poisson_columns, poisson_rows
from lure.rod.scheme.register import Inputs, ShiftRegister, Streams, body_history, shifted

_SPACING, _NEAR = 0.5, 16.0
_SMALL_RING = 40
_PANELS = (0.0, 1.0, 4.0, 16.0)
_PANEL = 16.0
_PANEL_POINTS = 14
_STIFF = 1e4  # the stress between collocation points is less accurate than the coordinate, by less than this factor
STAGES = 8
_ITERATIONS = 60
_AMPLIFICATION = 100.0


@described(frozen=True, kw_only=True, slots=True)
class Tables:
    """What steps of one length share."""

    length: float = quantity("Length of the step in units of ``1/s``")
    columns: int = quantity("Terms of the Poisson averages")
    mesh: Mesh = quantity("The step in pieces, both ends included")
    sequences: Array = quantity("(columns, TERMS) sequences of the Chebyshev polynomials of the step")
    grid: LoadGrid = quantity("Where loads are read")
    gauss: Array = quantity("Quadrature points of the step")
    gauss_weights: Array = quantity("Their weights")
    gauss_rows: Array = quantity("The Poisson weights there")
    shift: Array | None = quantity("For small rings, the linear map from state and load coefficients to the streams")


@described(frozen=True, kw_only=True, eq=False)
class Step:
    """A motion over one step, known at every instant of it."""

    tables: Tables = quantity("Tables of its length")
    streams: Streams = quantity("The shifted states, one-dimensional streams")
    extra: Array | None = quantity("(columns, 2N+1) what a body force adds to the shifted states")
    gap: Array = quantity("(columns,) contact coordinate after each shift, scaled")
    push: Array | None = quantity("(columns,) collocated contact stress ``q`` at each shift", default=None)


def step_tables(register: ShiftRegister, length: float, kappa: float, *, reused: bool) -> Tables:
    """Tables for steps of ``length``; ``reused`` ones are worth the map ``shift``."""
    columns = poisson_columns(length * register.growth)
    near, far = min(length, _NEAR), max(0.0, length - _NEAR)
    edges = np.concatenate(
        (
            np.linspace(0.0, near, max(2, int(np.ceil(near / _SPACING))) + 1),
            np.linspace(near, length, int(np.ceil(far / (2.0 * _SPACING))) + 1)[1:],
        )
    )
    sequences = chebyshev_sequences(TERMS, length, columns)
    gauss, weights = quadrature(length)
    shift = None
    if reused and register.cells <= _SMALL_RING:
        size = 2 * register.cells + 1
        states, inflow = np.zeros((size, size + TERMS)), np.zeros((columns, size + TERMS))
        states[:, :size] = np.eye(size)
        inflow[:, size:] = register.force_gain * sequences
        streams = shifted(register, states, columns, Inputs(kappa=kappa, inflow=inflow))
        shift = np.concatenate((streams.forward, streams.backward, streams.gap))
    return Tables(
        length=length,
        columns=columns,
        mesh=mesh_of(edges, columns),
        sequences=sequences,
        grid=load_grid(max(3, int(np.ceil(length)))),
        gauss=gauss,
        gauss_weights=weights,
        gauss_rows=poisson_rows(gauss, columns),
        shift=shift,
    )


def exact_step(register: ShiftRegister, tables: Tables, state: Array, fit: LoadFit, kappa: float) -> Step:
    """The motion from ``state`` (2N+1,) over one step, with no error but rounding and the fit of the loads."""
    columns = tables.columns
    if tables.shift is not None:
        loads = np.zeros(TERMS) if fit.force is None else fit.force
        streams = _cut(tables.shift @ np.concatenate((state, loads)), register.cells + columns - 1)
    else:
        inflow = None if fit.force is None else (register.force_gain * (tables.sequences @ fit.force))[:, None]
        streams = shifted(register, state[:, None], columns, Inputs(kappa=kappa, inflow=inflow)).single
    extra = None
    if fit.body_force is not None:
        extra = body_history(register, register.body_gain * (tables.sequences @ fit.body_force), kappa)
    gap = streams.gap if extra is None else streams.gap + extra[:, -1]
    return Step(tables=tables, streams=streams, extra=extra, gap=gap)


def states_at(register: ShiftRegister, step: Step, rows: Array) -> Array:
    """States (k, 2N+1) at the instants whose Poisson weights are ``rows`` (k, columns)."""
    if rows.shape[0] == 1:
        states = _state_at(step, rows[0])
    else:
        history = step.streams.histories
        states = np.asarray(rows @ (history if step.extra is None else history + step.extra))
    if step.push is not None:
        states[:, -1] = coordinate(register, states[:, -1], rows @ step.push)
    return states


def coordinate(register: ShiftRegister, gap: Array, push: Array) -> Array:
    """The scaled coordinate in contact: where the law is stiff from the stress, since rounding spoils the other way."""
    by_nonlinearity = register.penetration(np.maximum(push, 0.0))
    return np.where((push > 0.0) & (register.push_slope(by_nonlinearity) > _STIFF), by_nonlinearity, gap)


def _state_at(step: Step, row: Array) -> Array:
    waves = [np.correlate(stream, row, "valid")[::-1] for stream in (step.streams.forward, step.streams.backward)]
    state = np.concatenate((*waves, [row @ step.streams.gap]))
    return (state if step.extra is None else state + row @ step.extra)[None, :]


def quadrature(length: float) -> tuple[Array, Array]:
    """Gauss points and weights on ``[0, length]``, in panels that widen as fast waves die out."""
    far = np.arange(_PANELS[-1] + _PANEL, length, _PANEL)
    edges = np.concatenate(([edge for edge in _PANELS if edge < length], far, [length]))
    nodes, weights = np.polynomial.legendre.leggauss(_PANEL_POINTS)
    half, middle = 0.5 * np.diff(edges)[:, None], 0.5 * (edges[1:] + edges[:-1])[:, None]
    return (middle + half * nodes).ravel(), (half * weights).ravel()


def _cut(stacked: Array, size: int) -> Streams:
    return Streams(forward=stacked[:size], backward=stacked[size : 2 * size], gap=stacked[2 * size :])


@described(frozen=True, kw_only=True, slots=True)
class Collocation:
    """What contact steps of one length share."""

    rows: Array = quantity("(STAGES, columns) Poisson weights at the Radau points")
    sequences: Array = quantity(
        "(columns, STAGES) sequences of the polynomials that are 1 at one Radau point and 0 at the others"
    )
    coefficients: Array = quantity("(STAGES, STAGES) from values at the Radau points to Chebyshev coefficients")
    response: Array = quantity("(STAGES, STAGES) ``K``: loss of ``z`` at the points per polynomial")


@described(frozen=True, kw_only=True, slots=True)
class ContactStep:
    """A contact step and how well its polynomial fits."""

    step: Step = quantity("The motion")
    error: float = quantity(
        "Estimate of the error of the scaled coordinate at the end: last coefficients of ``q`` times the length [m/s]"
    )
    gap: float = quantity(
        "Scaled coordinate at the end [m/s], from the nonlinearity where that is the more accurate way"
    )
    left: bool = quantity("Whether the end of the rod has left the obstacle at one of the points")
    converged: bool = quantity("Whether the equations were solved to rounding")


def collocation(register: ShiftRegister, tables: Tables) -> Collocation:
    """Collocation matrices for steps with the given tables."""
    points = radau_points(STAGES)
    coefficients: Array = np.linalg.inv(chebyshev_values(points, STAGES)).astype(float)
    sequences = chebyshev_sequences(STAGES, tables.length, tables.columns) @ coefficients
    rows = poisson_rows(tables.length * points, tables.columns)
    at_rest = np.zeros((2 * register.cells + 1, STAGES))
    pressed = shifted(register, at_rest, tables.columns, Inputs(push=sequences))
    return Collocation(rows=rows, sequences=sequences, coefficients=coefficients, response=-(rows @ pressed.gap))


def contact_step(register: ShiftRegister, free: Step, scheme: Collocation) -> ContactStep:
    """The motion in contact, from the motion ``free`` that the same start would have without stress."""
    unpressed = scheme.rows @ free.gap
    push, converged = _solved(register, unpressed, scheme.response)
    sequence = (scheme.sequences @ push)[:, None]
    at_rest = np.zeros((2 * register.cells + 1, 1))
    added = shifted(register, at_rest, free.tables.columns, Inputs(push=sequence)).single
    streams = Streams(
        forward=free.streams.forward + added.forward,
        backward=free.streams.backward + added.backward,
        gap=free.streams.gap + added.gap,
    )
    step = Step(tables=free.tables, streams=streams, extra=free.extra, gap=free.gap + added.gap, push=sequence[:, 0])
    by_nonlinearity = register.penetration(push)
    stiff = register.push_slope(by_nonlinearity) > 1.0
    gaps = np.where(stiff, by_nonlinearity, unpressed - scheme.response @ push)
    length = free.tables.length
    error = length * float(np.abs(scheme.coefficients[-2:] @ push).sum())
    noise = 4e-15 * float((scheme.rows @ np.abs(free.gap) + np.abs(scheme.response) @ np.abs(push)).max())
    off = np.where(stiff, push * length < -max(error, 64.0 * noise), gaps < -noise)
    return ContactStep(step=step, error=error, gap=float(gaps[-1]), left=bool(off.any()), converged=converged)


def radau_points(stages: int) -> Array:
    """Right Radau points on ``[0, 1]``: zeros of ``P_{s-1} - P_s`` on ``[-1, 1]``, the last one at 1."""
    difference = np.zeros(stages + 1)
    difference[-2:] = 1.0, -1.0
    roots = np.sort(np.polynomial.legendre.legroots(difference).real)
    for _ in range(3):
        slope = np.polynomial.legendre.legval(roots, np.polynomial.legendre.legder(difference))
        roots = roots - np.polynomial.legendre.legval(roots, difference) / slope
    roots[-1] = 1.0
    return np.asarray(0.5 + 0.5 * roots)


def _solved(register: ShiftRegister, unpressed: Array, response: Array) -> tuple[Array, bool]:
    """Stresses ``q_i`` with ``z_i + K q = z^0_i``, by Newton's method.

    For ``m > 1`` the iteration runs in ``z``, where the nonlinearity is smooth, and ends with one correction in ``q``,
    since rounding in ``z`` times a large stiffness would spoil ``q``; for ``m <= 1`` it runs in ``q`` throughout.
    """
    scale = float(np.abs(unpressed).max())
    if scale == 0.0:
        return np.zeros(unpressed.size), True
    steep = register.exponent > 1.0
    z, q = unpressed.copy(), register.push(unpressed)
    best = np.inf
    for _ in range(_ITERATIONS):
        miss = z + response @ q - unpressed
        size = float(np.abs(miss).max())
        if not np.isfinite(size):
            break
        if size <= 1e-15 * scale or (size <= 1e-11 * scale and size >= 0.5 * best):
            return (_in_stress(register, z, q, miss, response) if steep else q), True
        best = min(best, size)
        if steep:
            z = z - np.linalg.solve(np.eye(z.size) + response * register.push_slope(z), miss)
            q = register.push(z)
        else:
            q = _in_stress(register, z, q, miss, response)
            z = register.penetration(q)
    return q, False


def _in_stress(register: ShiftRegister, z: Array, q: Array, miss: Array, response: Array) -> Array:
    """One Newton correction of ``q``."""
    with np.errstate(divide="ignore"):
        softness = np.minimum(1.0 / register.push_slope(z), 1e200)
    return np.asarray(q - np.linalg.solve(np.diag(softness) + response, miss))


@described(frozen=True, kw_only=True, eq=False)
class Plan:
    """Step lengths of a run and the tables it has made."""

    register: ShiftRegister = quantity("The scheme")
    longest: float = quantity("Longest step in free flight, in units of ``1/s``")
    longest_contact: float = quantity("Longest exact step in contact; zero where contact is collocated")
    tolerance: float = quantity("Accuracy of a collocated step, relative to the speeds in the rod")
    _tables: dict[tuple[float, float], Tables] = field(default_factory=dict)
    _collocations: dict[float, Collocation] = field(default_factory=dict)

    def tables(self, length: float, kappa: float, *, reused: bool) -> Tables:
        """Tables for a length, kept if they will be ``reused``."""
        if not reused:
            return step_tables(self.register, length, kappa, reused=False)
        if (length, kappa) not in self._tables:
            self._tables[length, kappa] = step_tables(self.register, length, kappa, reused=True)
        return self._tables[length, kappa]

    def collocation(self, tables: Tables) -> Collocation:
        """Collocation matrices for a length, kept if the tables are."""
        if self._tables.get((tables.length, 0.0)) is not tables:
            return collocation(self.register, tables)
        if tables.length not in self._collocations:
            self._collocations[tables.length] = collocation(self.register, tables)
        return self._collocations[tables.length]


def plan_steps(register: ShiftRegister, *, longest: float, tolerance: float) -> Plan:
    """Choose the step lengths.

    The powers of the shift must not outgrow what their Poisson average cancels: in free flight they do so only if the
    dashpot drives the rod, in contact if the spring is stiffer than about two cells of rod.

    ``longest``: longest step wanted; ``tolerance``: accuracy of a collocated step, relative to the speeds in the rod.
    """
    while longest * (register.growth - 1.0) > 4.0:
        longest /= 4.0
    contact = longest if register.exponent == 1.0 else 0.0
    probe = np.ones((2 * register.cells + 1, 2))
    probe[:-1, 0], probe[1::2, 1] = 0.0, -1.0
    while contact > 0.0:
        columns = poisson_columns(contact * register.growth)
        with np.errstate(over="ignore", invalid="ignore"):
            powers = shifted(register, probe, columns, Inputs(kappa=register.kappa)).gap
            sizes = poisson_rows(contact, columns) @ np.abs(powers)
        if sizes.max() <= _AMPLIFICATION * max(1.0, contact):
            break
        contact = contact / 4.0 if contact >= 0.05 * longest else 0.0
    return Plan(register=register, longest=longest, longest_contact=contact, tolerance=tolerance)
