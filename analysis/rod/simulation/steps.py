"""One step of exact motion, free or against a linear spring, and the tables that make it cheap."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.simulation.certify import Mesh, mesh_of
from lure.analysis.rod.simulation.loads import TERMS, LoadFit, LoadGrid, load_grid
from lure.analysis.rod.simulation.poisson import chebyshev_sequences, poisson_columns, poisson_rows
from lure.analysis.rod.simulation.ring import Inputs, Ring, Streams, body_history, histories, shifted

Array = NDArray[np.float64]

_SPACING, _NEAR = 0.5, 16.0
_SMALL_RING = 40
_PANELS = (0.0, 1.0, 4.0, 16.0)
_PANEL = 16.0
_PANEL_POINTS = 14
_STIFF = 1e4  # the stress between collocation points is less accurate than the coordinate, by less than this factor


@dataclass(frozen=True, kw_only=True, slots=True)
class Tables:
    """What steps of one length share.

    Attributes
    ----------
    length : float
        Length of the step in units of ``1/s``.
    columns : int
        Terms of the Poisson averages.
    mesh : Mesh
        The step in pieces, both ends included.
    sequences : ndarray
        (columns, TERMS) sequences of the Chebyshev polynomials of the step.
    grid : LoadGrid
        Where loads are read.
    gauss, gauss_weights, gauss_rows : ndarray
        Quadrature points of the step, their weights, and the Poisson weights there.
    shift : ndarray or None
        For small rings, the linear map from state and load coefficients to the streams.
    """

    length: float
    columns: int
    mesh: Mesh
    sequences: Array
    grid: LoadGrid
    gauss: Array
    gauss_weights: Array
    gauss_rows: Array
    shift: Array | None


@dataclass(frozen=True, kw_only=True, eq=False)
class Step:
    """A motion over one step, known at every instant of it.

    Attributes
    ----------
    tables : Tables
        Tables of its length.
    streams : Streams
        The shifted states, one-dimensional streams.
    extra : ndarray or None
        (columns, 2N+1) what a body force adds to the shifted states.
    gap : ndarray
        (columns,) contact coordinate after each shift, scaled.
    push : ndarray or None
        (columns,) collocated contact stress ``q`` at each shift.
    """

    tables: Tables
    streams: Streams
    extra: Array | None
    gap: Array
    push: Array | None = None


def step_tables(ring: Ring, length: float, kappa: float, *, reused: bool) -> Tables:
    """Tables for steps of ``length``; ``reused`` ones are worth the map ``shift``."""
    columns = poisson_columns(length * ring.growth)
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
    if reused and ring.cells <= _SMALL_RING:
        size = 2 * ring.cells + 1
        states, inflow = np.zeros((size, size + TERMS)), np.zeros((columns, size + TERMS))
        states[:, :size] = np.eye(size)
        inflow[:, size:] = ring.force_gain * sequences
        streams = shifted(ring, states, columns, Inputs(kappa=kappa, inflow=inflow))
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


def exact_step(ring: Ring, tables: Tables, state: Array, fit: LoadFit, kappa: float) -> Step:
    """The motion from ``state`` (2N+1,) over one step, with no error but rounding and the fit of the loads."""
    columns = tables.columns
    if tables.shift is not None:
        loads = np.zeros(TERMS) if fit.force is None else fit.force
        streams = _cut(tables.shift @ np.concatenate((state, loads)), ring.cells + columns - 1)
    else:
        inflow = None if fit.force is None else (ring.force_gain * (tables.sequences @ fit.force))[:, None]
        columnwise = shifted(ring, state[:, None], columns, Inputs(kappa=kappa, inflow=inflow))
        streams = Streams(
            forward=columnwise.forward[:, 0], backward=columnwise.backward[:, 0], gap=columnwise.gap[:, 0]
        )
    extra = None
    if fit.body_force is not None:
        extra = body_history(ring, ring.body_gain * (tables.sequences @ fit.body_force), kappa)
    gap = streams.gap if extra is None else streams.gap + extra[:, -1]
    return Step(tables=tables, streams=streams, extra=extra, gap=gap)


def states_at(ring: Ring, step: Step, rows: Array) -> Array:
    """States (k, 2N+1) at the instants whose Poisson weights are ``rows`` (k, columns)."""
    if rows.shape[0] == 1:
        states = _state_at(step, rows[0])
    else:
        history = histories(ring, step.streams)
        states = np.asarray(rows @ (history if step.extra is None else history + step.extra))
    if step.push is not None:
        states[:, -1] = coordinate(ring, states[:, -1], rows @ step.push)
    return states


def coordinate(ring: Ring, gap: Array, push: Array) -> Array:
    """The scaled coordinate in contact: where the law is stiff from the stress, since rounding spoils the other way."""
    by_law = ring.penetration(np.maximum(push, 0.0))
    return np.where((push > 0.0) & (ring.push_slope(by_law) > _STIFF), by_law, gap)


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
