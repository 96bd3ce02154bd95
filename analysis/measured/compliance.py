r"""Normal compliance ``p = max(u - gap, 0)^m / eps`` fitted to measurements, with intervals of the likelihood."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.measured.compliance_fit import NAMES, ComplianceFit, Parameter
from analysis.measured.hysteresis import hysteresis_of
from analysis.measured.mean_law import mean_law, one_thread
from analysis.measured.measured_sector import Outlier
from analysis.measured.measurements import Direction, Measurements
from analysis.measured.noise import Noise, noise_of
from analysis.measured.profile import Problem, at_an_end, joint_limit, profile_interval, single_limit
from lure.errors import AssumptionError, InputError

Array = NDArray[np.float64]
_EXPONENTS = (0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0)
_GAPS = 25
_ROUNDS = 4
_LEAST = 8


@one_thread
def fit_compliance(
    measurements: Measurements, *, branch: Direction | None = None, confidence: float = 0.95
) -> ComplianceFit:
    r"""Fit ``p = max(u - gap, 0)^m / eps`` by weighted least squares, outliers left out.

    Assumed are independent normal errors of the load with mean 0 and standard deviation ``s0 + s1 p``, both unknown,
    displacements without error, and the law itself; ``misfit`` tests the law against a free one.

    Parameters
    ----------
    measurements : Measurements
        At least 12 rows, at least 8 of them in contact.
    branch : {"loading", "unloading"}, optional
        Rows to fit; by default all of them, or those on loading where the two differ by more than noise.
    confidence : float
        Between 0.5 and 0.9999.

    Returns
    -------
    ComplianceFit
        ``eps`` [m^m/Pa or m^m/N], ``gap`` [m] and ``m`` with standard uncertainties and two kinds of
        intervals: for each parameter alone, and for all three at once.

    Raises
    ------
    InputError
        There are too few rows, or an argument is not as described.
    AssumptionError
        The data are no displacement and force, the load does not grow with the displacement, or the best gap or
        exponent is out of all proportion.

    Notes
    -----
    The unit of ``eps`` depends on ``m``, and the two are all but proportional; fitted is therefore the logarithm of the
    load at the largest displacement.  Intervals are those of the profile likelihood: all values at which the sum of
    squares, least over the other two parameters, exceeds its minimum by less than an F quantile.  They need no
    linearisation, are lopsided where the likelihood is, and are infinite where the data set no bound.

    Examples
    --------
    >>> from analysis.measured import example_measurements
    >>> found = fit_compliance(example_measurements())
    >>> print(f"m = {found.parameters['m'].value:.2f}")
    m = 1.50
    """
    if branch not in (None, "loading", "unloading"):
        raise InputError(f"fit_compliance: branch is {branch!r:.40}; give 'loading' or 'unloading'")
    if not (isinstance(confidence, float) and 0.5 <= confidence <= 0.9999):
        raise InputError(f"fit_compliance: confidence is {confidence!r:.40}; give a number between 0.5 and 0.9999")
    units = measurements.displacement_unit, measurements.unit
    if units[0] != "m" or units[1] not in ("N", "Pa"):
        raise AssumptionError(
            f"a contact law relates m to N or Pa, and the data {units[0]} to {units[1]}; leave the fit out"
        )
    note = ""
    if branch is None and hysteresis_of(measurements) is not None:
        branch = "loading"
        note = (
            "Loading and unloading differ by more than noise: fitted is loading alone, and unloading does not obey it."
        )
    rows = measurements.rows(branch) if branch else np.arange(len(measurements))
    if rows.size < 12:
        raise InputError(f"fit_compliance: there are {rows.size} rows on {branch}; give at least 12")
    used = measurements.taken(rows)
    problem, best, scores, noise = _fitted(used)
    scale = problem.least(best) / problem.degrees
    joint, single = (limit(confidence, problem.degrees) * scale for limit in (joint_limit, single_limit))
    covariance = problem.covariance(best) * scale
    errors = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    centre, parameters = problem.wanted(best), {}
    for i, name in enumerate(NAMES):
        both = [profile_interval(problem, best, i, limit, float(errors[i])) for limit in (single, joint)]
        parameters[name] = Parameter(
            value=_in_units(problem, i, float(centre[i])),
            error=float(errors[i]) * (_in_units(problem, 0, float(centre[0])), problem.units[0], 1.0)[i],
            single=(_in_units(problem, i, both[0][0]), _in_units(problem, i, both[0][1])),
            joint=(_in_units(problem, i, both[1][0]), _in_units(problem, i, both[1][1])),
        )
    kept = problem.kept
    return ComplianceFit(
        measurements=used,
        confidence=confidence,
        parameters=parameters,
        correlation=covariance / np.maximum(np.outer(errors, errors), 1e-300),
        noise=Noise(constant=noise.constant * problem.units[1], proportional=noise.proportional),
        scores=scores,
        outliers=tuple(
            Outlier(index=int(rows[i]), line=int(used.lines[i]), score=float(scores[i])) for i in np.flatnonzero(~kept)
        ),
        misfit=_misfit(used, problem, best),
        explained=_explained(problem, best),
        in_contact=int(np.count_nonzero(kept & (problem.x > best[1]))),
        branch=branch,
        note=note,
    )


def _in_units(problem: Problem, i: int, value: float) -> float:
    """``eps``, ``gap`` or ``m`` from the ``i``-th of ``(e, g, m)``."""
    if i == 0:
        return math.exp(value) if value < 700 else math.inf
    return problem.origin + problem.units[0] * value if i == 1 else value


def _fitted(used: Measurements) -> tuple[Problem, Array, Array, Noise]:
    """Weights and outliers from the residuals, and the fit from the weights, in turn."""
    problem = Problem(used.displacement, used.load)
    if not np.isfinite(problem.units[1]) or float(np.max(problem.y)) <= 0:
        raise AssumptionError("no load is positive; a contact pushes, so give compression a positive sign")
    best = _start(problem)
    noise = Noise(constant=1.0, proportional=0.0)
    scores = np.zeros_like(problem.y)
    for turn in range(_ROUNDS):
        best = problem.minimum(best, robust=turn == 0)
        mean = problem.law(best)
        residuals = problem.y - mean
        noise = noise_of(residuals, mean, parameters=3)
        problem.weights = 1 / noise(mean)
        scores = residuals * problem.weights
        problem.kept = ~problem.outlying(scores)
        noise = noise_of(residuals[problem.kept], mean[problem.kept], parameters=3)
        problem.weights = 1 / noise(mean)
    best = problem.minimum(best)
    if at_an_end(best):
        raise AssumptionError(
            f"the data determine no gap and exponent: the best fit runs to m = {best[2]:.3g} with a gap at "
            f"{_in_units(problem, 1, best[1]):.3g} m, so that the load grows exponentially, or jumps, rather than as a "
            "power of the depth; leave the fit out, or cut the rows to those in contact"
        )
    touching = int(np.count_nonzero(problem.kept & (problem.x > best[1])))
    if touching < _LEAST:
        raise InputError(
            f"only {touching} rows are in contact, beyond the fitted gap {_in_units(problem, 1, best[1]):.3g} m; "
            f"give at least {_LEAST}"
        )
    scale = math.sqrt(problem.least(best) / problem.degrees)
    return problem, best, (problem.y - problem.law(best)) * problem.weights / max(scale, 1e-300), noise


def _start(problem: Problem) -> Array:
    """The best of a grid of gaps and exponents, by the sum of absolute residuals."""
    low, high = float(problem.x.min()), float(problem.x.max())
    found: tuple[float, Array] | None = None
    for gap in np.linspace(low - 0.2 * (high - low), high, _GAPS, endpoint=False):
        for m in _EXPONENTS:
            shape = problem.law(np.array([0.0, gap, m]))
            top = float(shape @ problem.y) / float(shape @ shape)
            if top > 0:
                cost = float(np.abs(problem.y - top * shape).sum())
                if found is None or cost < found[0]:
                    found = cost, np.array([math.log(top), gap, m])
    if found is None:
        raise AssumptionError("the load does not grow with the displacement; choose the sign of both so that it does")
    return found[1]


def _misfit(used: Measurements, problem: Problem, best: Array) -> float:
    """p-value of the compliance law against one that is affine between as many knots as the data ask for."""
    from scipy.stats import f as fisher

    gap = _in_units(problem, 1, float(best[1]))
    inside = problem.kept
    free = mean_law(used.displacement[inside] - gap, used.load[inside], free=True)
    residuals = (used.load[inside] - free(used.displacement[inside] - gap)) / problem.units[1]
    weights = problem.weights[inside]
    degrees = int(inside.sum()) - free.knots.size
    extra = free.knots.size - 3
    if extra < 1 or degrees < 1:
        return 1.0
    rest = float(np.sum((weights * residuals) ** 2))
    gain = (problem.least(best) - rest) / extra
    return float(fisher.sf(max(gain, 0.0) / max(rest / degrees, 1e-300), extra, degrees))


def _explained(problem: Problem, best: Array) -> float:
    """Share of the weighted variance of the load that the law explains."""
    weights = np.where(problem.kept, problem.weights, 0.0) ** 2
    mean = float(np.sum(weights * problem.y) / np.sum(weights))
    return 1 - problem.least(best) / float(np.sum(weights * (problem.y - mean) ** 2))
