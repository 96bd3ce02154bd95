"""A leg by the integrators of scipy, with the end of the phase found on their interpolants."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.comparison.equations import BAND
from lure.analysis.rod.comparison.legs import Counted, Leg, Walked, at_zero, stacked, stopping
from lure.errors import InputError

Array = NDArray[np.float64]
ScipyMethod = Literal["RK45", "DOP853", "Radau", "BDF", "LSODA"]

_DEGREE = 12  # the largest of scipy's interpolants: LSODA's, of its order
_POINTS = 0.5 * (1.0 - np.cos((np.arange(_DEGREE + 1) + 0.5) * math.pi / (_DEGREE + 1)))
_FIT = np.linalg.inv(np.polynomial.chebyshev.chebvander(2.0 * _POINTS - 1.0, _DEGREE))
_NEAR = 2.0


def scipy_leg(leg: Leg, method: ScipyMethod) -> Walked:
    """Integrate a leg.

    On each step the interpolant of ``z`` is a polynomial; where a root of it ends the phase, the step ends, so that no
    contact of the interpolant is missed, however short.  In flight steps are not looked at on which the largest wave
    could not carry ``z`` half the way to the obstacle.

    Parameters
    ----------
    leg : Leg
        The piece.
    method : str
        Name of a class of ``scipy.integrate``.

    Raises
    ------
    InputError
        The integrator gives up, or the state is no longer finite.
    """
    rate = Counted(leg=leg)
    solver = _solver(leg, method, rate)
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


def _solver(leg: Leg, method: ScipyMethod, rate: Counted) -> Any:  # noqa: ANN401  (scipy has no types)
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
    series = _FIT @ leg.depth(np.asarray(dense(start + _POINTS * (end - start)))[-1])
    size = np.abs(series)
    if series[0] > size[1:].sum():
        return None
    significant = np.flatnonzero(size > 1e-15 * size.max(initial=0.0))
    series = series[: int(significant[-1]) + 1] if significant.size else series[:1]
    roots = np.polynomial.chebyshev.chebroots(series) if series.size > 1 else np.empty(0)
    inside = np.sort(roots.real[(np.abs(roots.imag) < 1e-7) & (np.abs(roots.real) < 1.0)])
    for low, high in pairwise([-1.0, *inside, 1.0]):
        if float(np.polynomial.chebyshev.chebval(np.linspace(low, high, 5)[1:], series).min()) < -leg.noise:
            return float(start + 0.5 * (low + 1.0) * (end - start))
    return None
