r"""One step of contact with a nonlinear or very stiff law: collocation for the stress, exact waves around it.

On a step the stress ``q = d p(z)`` is a polynomial through the Radau points; given ``q`` the waves and ``z`` are exact,
so that the unknowns are the values of ``z`` at those points: ``z_i + sum_j K_ij q(z_j) = z^0_i``, where ``z^0`` is the
motion without stress and ``K`` the response of ``z`` to each polynomial.  For ``z`` alone this is Radau IIA
collocation, stiffly accurate and L-stable; the waves add no error.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.simulation.poisson import chebyshev_sequences, chebyshev_values, poisson_rows
from lure.analysis.rod.simulation.ring import Inputs, Ring, Streams, shifted
from lure.analysis.rod.simulation.steps import Step, Tables

Array = NDArray[np.float64]

STAGES = 8
_ITERATIONS = 60


@dataclass(frozen=True, kw_only=True, slots=True)
class Collocation:
    """What contact steps of one length share.

    Attributes
    ----------
    rows : ndarray
        (STAGES, columns) Poisson weights at the Radau points.
    sequences : ndarray
        (columns, STAGES) sequences of the polynomials that are 1 at one Radau point and 0 at the others.
    coefficients : ndarray
        (STAGES, STAGES) from values at the Radau points to Chebyshev coefficients.
    response : ndarray
        (STAGES, STAGES) ``K``: loss of ``z`` at the points per polynomial.
    """

    rows: Array
    sequences: Array
    coefficients: Array
    response: Array


@dataclass(frozen=True, kw_only=True, slots=True)
class ContactStep:
    """A contact step and how well its polynomial fits.

    Attributes
    ----------
    step : Step
        The motion.
    error : float
        Estimate of the error of the scaled coordinate at the end: last coefficients of ``q`` times the length [m/s].
    gap : float
        Scaled coordinate at the end [m/s], from the law where that is the more accurate way.
    left : bool
        Whether the end of the rod has left the obstacle at one of the points.
    converged : bool
        Whether the equations were solved to rounding.
    """

    step: Step
    error: float
    gap: float
    left: bool
    converged: bool


def collocation(ring: Ring, tables: Tables) -> Collocation:
    """Collocation matrices for steps with the given tables."""
    points = radau_points(STAGES)
    coefficients: Array = np.linalg.inv(chebyshev_values(points, STAGES)).astype(float)
    sequences = chebyshev_sequences(STAGES, tables.length, tables.columns) @ coefficients
    rows = poisson_rows(tables.length * points, tables.columns)
    at_rest = np.zeros((2 * ring.cells + 1, STAGES))
    pressed = shifted(ring, at_rest, tables.columns, Inputs(push=sequences))
    return Collocation(rows=rows, sequences=sequences, coefficients=coefficients, response=-(rows @ pressed.gap))


def contact_step(ring: Ring, free: Step, scheme: Collocation) -> ContactStep:
    """The motion in contact, from the motion ``free`` that the same start would have without stress."""
    unpressed = scheme.rows @ free.gap
    push, converged = _solved(ring, unpressed, scheme.response)
    sequence = (scheme.sequences @ push)[:, None]
    at_rest = np.zeros((2 * ring.cells + 1, 1))
    added = shifted(ring, at_rest, free.tables.columns, Inputs(push=sequence))
    streams = Streams(
        forward=free.streams.forward + added.forward[:, 0],
        backward=free.streams.backward + added.backward[:, 0],
        gap=free.streams.gap + added.gap[:, 0],
    )
    step = Step(
        tables=free.tables, streams=streams, extra=free.extra, gap=free.gap + added.gap[:, 0], push=sequence[:, 0]
    )
    by_law = ring.penetration(push)
    stiff = ring.push_slope(by_law) > 1.0
    gaps = np.where(stiff, by_law, unpressed - scheme.response @ push)
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


def _solved(ring: Ring, unpressed: Array, response: Array) -> tuple[Array, bool]:
    """Stresses ``q_i`` with ``z_i + K q = z^0_i``, by Newton's method.

    For ``m > 1`` the iteration runs in ``z``, where the law is smooth, and ends with one correction in ``q``, since
    rounding in ``z`` times a large stiffness would spoil ``q``; for ``m <= 1`` it runs in ``q`` throughout.
    """
    scale = float(np.abs(unpressed).max())
    if scale == 0.0:
        return np.zeros(unpressed.size), True
    steep = ring.exponent > 1.0
    z, q = unpressed.copy(), ring.push(unpressed)
    best = np.inf
    for _ in range(_ITERATIONS):
        miss = z + response @ q - unpressed
        size = float(np.abs(miss).max())
        if not np.isfinite(size):
            break
        if size <= 1e-15 * scale or (size <= 1e-11 * scale and size >= 0.5 * best):
            return (_in_stress(ring, z, q, miss, response) if steep else q), True
        best = min(best, size)
        if steep:
            z = z - np.linalg.solve(np.eye(z.size) + response * ring.push_slope(z), miss)
            q = ring.push(z)
        else:
            q = _in_stress(ring, z, q, miss, response)
            z = ring.penetration(q)
    return q, False


def _in_stress(ring: Ring, z: Array, q: Array, miss: Array, response: Array) -> Array:
    """One Newton correction of ``q``."""
    with np.errstate(divide="ignore"):
        softness = np.minimum(1.0 / ring.push_slope(z), 1e200)
    return np.asarray(q - np.linalg.solve(np.diag(softness) + response, miss))
