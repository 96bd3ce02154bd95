"""Loads along one step: polynomials in time, fitted at Chebyshev points and checked between them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.simulation.poisson import chebyshev_fit, chebyshev_points, chebyshev_values
from lure.errors import InputError
from lure.expressions import Expression
from lure.rod.scenario import Scenario
from lure.rod.upwind import UpwindScheme

Array = NDArray[np.float64]

TERMS = 12
_END = 1e-6
_POINTS, _FIT = chebyshev_points(TERMS), chebyshev_fit(TERMS)


@dataclass(frozen=True, kw_only=True, slots=True)
class Loads:
    """The loads of a scenario on a grid.

    Attributes
    ----------
    force, body_force : Expression or None
        ``g(t)`` [N] and ``f(t, x)`` [N/m]; None where there is none.
    x : ndarray
        (2N,) place of each wave's grid value, in the order (39) [m].
    breakpoints : tuple of float
        Instants at which a load may change its formula [s]: steps end there.
    known : bool
        Whether these are all; where they are not, steps shrink until the polynomial fits.
    tolerance : float
        Accuracy of the fit relative to the largest load met so far.
    """

    force: Expression | None
    body_force: Expression | None
    x: Array
    breakpoints: tuple[float, ...]
    known: bool
    tolerance: float

    @property
    def free(self) -> bool:
        """Whether no load acts."""
        return self.force is None and self.body_force is None

    def force_at(self, t: Array) -> Array:
        """``g`` at the instants ``t`` [N]."""
        return np.zeros(t.shape) if self.force is None else _finite(self.force(t=t), "force.g", t)

    def body_at(self, t: Array) -> Array:
        """``f`` (k, 2N) at the instants ``t`` and the grid points [N/m]."""
        if self.body_force is None:
            return np.zeros((t.size, self.x.size))
        return _finite(self.body_force(t=t[:, None], x=self.x[None, :]), "force.f", t)


@dataclass(frozen=True, kw_only=True, slots=True)
class LoadFit:
    """Chebyshev coefficients of the loads on a step.

    Attributes
    ----------
    force : ndarray or None
        (TERMS,) [N].
    body_force : ndarray or None
        (TERMS, 2N) [N/m].
    largest : float
        Largest force and body force met, relative units of the run.
    resolved : bool
        Whether the fit holds between its points.
    """

    force: Array | None
    body_force: Array | None
    largest: tuple[float, float]
    resolved: bool


NO_LOAD = LoadFit(force=None, body_force=None, largest=(0.0, 0.0), resolved=True)


def loads_of(scheme: UpwindScheme, scenario: Scenario, until: float, tolerance: float) -> Loads:
    """The loads of ``scenario`` on the grid of ``scheme`` up to ``until`` [s]."""
    rod, N = scheme.rod, scheme.cells
    forward = rod.length * np.arange(1, N + 1) / N
    backward = rod.length * np.arange(N - 1, -1, -1) / N
    present = [None if load.is_zero else load for load in (scenario.force, scenario.body_force)]
    breaks: set[Fraction] = set()
    known = True
    for load in present:
        found = () if load is None or load.is_constant else load.breakpoints("t", 0.0, until)
        known = known and found is not None
        breaks.update(found or ())
    return Loads(
        force=present[0],
        body_force=present[1],
        x=np.concatenate((forward, backward)),
        breakpoints=tuple(sorted(map(float, breaks))),
        known=known,
        tolerance=tolerance,
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class LoadGrid:
    """Where on a step the loads are read: the Chebyshev points, then points evenly spaced that check the fit.

    Attributes
    ----------
    points : ndarray
        (TERMS + checks + 2,) shares of the step, in (0, 1).
    basis : ndarray
        (checks + 2, TERMS) Chebyshev polynomials at the checks.
    """

    points: Array
    basis: Array


def load_grid(checks: int) -> LoadGrid:
    """The grid with ``checks`` points of checking inside and one next to each end."""
    between = np.concatenate(([_END], (np.arange(checks) + 0.5) / checks, [1.0 - _END]))
    return LoadGrid(points=np.concatenate((_POINTS, between)), basis=chebyshev_values(between, TERMS))


def fit_loads(loads: Loads, grid: LoadGrid, start: float, length: float, largest: tuple[float, float]) -> LoadFit:
    """Fit the loads on ``[start, start + length]`` [s]; ``largest`` are the sizes met in earlier steps."""
    if loads.free:
        return NO_LOAD
    t = start + length * grid.points
    force, force_size, force_fits = _fitted(
        loads.force_at if loads.force else None, t, grid, largest[0], loads.tolerance
    )
    body, body_size, body_fits = _fitted(
        loads.body_at if loads.body_force else None, t, grid, largest[1], loads.tolerance
    )
    return LoadFit(force=force, body_force=body, largest=(force_size, body_size), resolved=force_fits and body_fits)


def _fitted(
    load: Callable[[Array], Array] | None, t: Array, grid: LoadGrid, largest: float, tolerance: float
) -> tuple[Array | None, float, bool]:
    """Coefficients, largest size met, and whether the fit holds up to the tolerance and the rounding of ``t``."""
    if load is None:
        return None, largest, True
    values = load(t)
    size = max(largest, float(np.abs(values).max()))
    coefficients = _FIT @ values[:TERMS]
    miss = float(np.abs(grid.basis @ coefficients - values[TERMS:]).max())
    if miss <= tolerance * size:
        return coefficients, size, True
    rounding = float(np.abs(load(t * (1.0 + 2.0**-50)) - values).max())
    return coefficients, size, miss <= tolerance * size + 4.0 * rounding


def averaged(fit: LoadFit) -> LoadFit:
    """The fit reduced to its mean: for a step too short to matter, across a jump."""
    force, body = (
        None if part is None else part * (np.arange(TERMS) == 0).reshape(-1, *[1] * (part.ndim - 1))
        for part in (fit.force, fit.body_force)
    )
    return LoadFit(force=force, body_force=body, largest=fit.largest, resolved=True)


def _finite(values: Array, field: str, t: Array) -> Array:
    if not np.isfinite(values).all():
        bad = t[np.flatnonzero(~np.isfinite(values.reshape(t.size, -1)).all(axis=1))[0]]
        raise InputError(f"{field} has no finite value at t = {float(bad):.6g} s; give a formula that is defined there")
    return values
