r"""Normal compliance ``p = max(u - gap, 0)^m / eps`` fitted to measurements, with intervals of the likelihood."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.analysis.drawing import drawn
from lure.analysis.measured.mean_nonlinearity import Noise, mean_nonlinearity, noise_of
from lure.analysis.measured.measured_sector import Outlier, left_out
from lure.analysis.measured.reading import Direction, Measurements
from lure.analysis.measured.sector import hysteresis_from_data
from lure.analysis.verdict import Evidence
from lure.arrays import one_thread
from lure.errors import AssumptionError, InputError
from lure.nonlinearities.base import NormalCompliance
from lure.record import Column, Page, Record, derived, quantity

if TYPE_CHECKING:
    pass

# A fitted law of normal compliance with what is known of its parameters.

NAMES = ("eps", "gap", "m")
_MISFIT = 0.01


class Parameter(Record):
    """A fitted parameter."""

    value: float = quantity("Its best value")
    error: float = quantity("Standard uncertainty, linearised", key="standard_uncertainty")
    single: tuple[float, float] = quantity(
        "Interval for this parameter alone, from its profile likelihood; ends may be infinite"
    )
    joint: tuple[float, float] = quantity(
        "Side of the box around the likelihood region of all three parameters: all three lie within theirs at "
        "once with at least the confidence"
    )


class ComplianceFit(Record):
    """``p = max(u - gap, 0)^m / eps`` fitted to measurements; see :func:`fit_compliance` for the assumptions."""

    measurements: Measurements = quantity("The rows fitted", key="rows", plainly=len)
    confidence: float = quantity("Of the intervals")
    parameters: Mapping[str, Parameter] = quantity("``eps`` [m^m / unit of the load], ``gap`` [m], ``m`` [-]", key="")
    correlation: NDArray[np.float64] = quantity("(3, 3) of ``log eps``, ``gap``, ``m``, linearised", key="")
    noise: Noise = quantity("Standard deviation of a reading")
    scores: NDArray[np.float64] = quantity("(n,) residuals in standard deviations", key="")
    outliers: tuple[Outlier, ...] = quantity("Rows left out; ``index`` is that in the whole file")
    misfit: float = quantity(
        "p-value of this nonlinearity against a free one: small means that the data contradict the nonlinearity"
    )
    explained: float = quantity("Weighted share of the variance of the load that the nonlinearity explains")
    in_contact: int = quantity("Rows beyond the fitted gap")
    branch: Direction | None = quantity("The branch fitted, None for all rows")
    note: str = quantity("A remark on hysteresis, or nothing", key="")

    @property
    @derived()
    def evidence(self) -> Evidence:
        """OBSERVED: a fit proves nothing of the nonlinearity."""
        return Evidence.OBSERVED

    @property
    def nonlinearity(self) -> NormalCompliance:
        """The fitted law of the penetration ``u - gap``, as a rod takes it if the load is a stress.

        Raises
        ------
        AssumptionError
            ``1/eps`` is not a finite double.
        """
        eps = self.parameters["eps"].value
        if not 1e-300 < eps < 1e300:
            raise AssumptionError(f"eps is {eps:g}, and 1/eps no double; give the measurements in other units")
        return NormalCompliance(stiffness=1 / eps, exponent=self.parameters["m"].value)

    def __call__(self, displacement: ArrayLike) -> NDArray[np.float64]:
        """The fitted load [unit of the load] at a displacement [m], elementwise."""
        return self.nonlinearity(np.asarray(displacement, dtype=float) - self.parameters["gap"].value)

    @property
    def stated(self) -> bool:
        """Whether the intervals have the confidence: the data show no loop and do not contradict the nonlinearity."""
        return not self.note and self.misfit >= _MISFIT

    @property
    @derived()
    def conclusion(self) -> str:
        """The fit in a sentence, with what it rests on."""
        eps, gap, m = (self.parameters[name] for name in NAMES)
        sure = (
            f"all three within at once with at least {100 * self.confidence:g} % confidence, if the nonlinearity and "
        )
        sure += "independent normal errors are assumed (observed, not proved)."
        if not self.stated:
            sure = "no confidence is stated, since the data contradict the nonlinearity (observed, not proved)."
        return (
            f"Fitted p = max(u - gap, 0)^m / eps: eps = {eps.value:.4g} in {_span(eps.joint)} m^m/"
            f"{self.measurements.unit}, gap = {gap.value:.5g} in {_span(gap.joint)} m, m = {m.value:.4g} in "
            f"{_span(m.joint)}; {sure}"
        )

    plot = drawn(
        "The data, the fitted nonlinearity and the residuals; see :func:`lure.analysis.plots.plot_compliance`."
    )

    def to_dict(self) -> dict[str, Any]:
        """The fit as plain data; infinite numbers are the text ``inf``."""
        units = {"eps": f"m^m/{self.measurements.unit}", "gap": "m", "m": "1"}
        return super().to_dict() | {
            "parameters": {name: found.to_dict() | {"unit": units[name]} for name, found in self.parameters.items()},
            "correlation": {"of": ["log eps", "gap", "m"], "matrix": self.correlation.tolist()},
        }

    def _columns(self) -> dict[str, Column]:
        """Rows with the fitted load, and the three parameters, which have units of their own, with their intervals."""
        data, of = self.measurements, ("parameter", "parameter_")
        found = data._columns() | {
            "fitted_load": Column(("row",), self(data.displacement), data.unit, "load of the fitted nonlinearity"),
            "fit_score": Column(("row",), self.scores, "1", "residual of the fit in standard deviations"),
            "correlation": Column(of, self.correlation, "1", "correlation of log eps, gap and m, linearised"),
            "end": Column(("end",), np.array(["low", "high"], dtype=object), "1", "end of an interval"),
        }
        units = {"eps": f"m{self.parameters['m'].value:.6g} {data.unit}-1", "gap": "m", "m": "1"}
        for name, parameter in self.parameters.items():
            unit, joint = units[name], f"interval of {name} with all three inside at once"
            error = f"standard uncertainty of {name}, linearised"
            found[f"fit_{name}"] = Column((), parameter.value, unit, f"fitted {name} of max(u - gap, 0)^m / eps")
            found[f"fit_{name}_error"] = Column((), parameter.error, unit, error)
            found[f"fit_{name}_joint"] = Column(("end",), parameter.joint, unit, joint)
        names = np.array(["log eps", "gap", "m"], dtype=object)
        return found | {dim: Column((dim,), names, "1", "parameter of the nonlinearity") for dim in of}

    def _attributes(self) -> dict[str, object]:
        return self.measurements._attributes() | {
            "title": "Normal compliance fitted to measurements",
            "evidence": str(self.evidence),
            "comment": self.conclusion,
            "confidence": self.confidence,
            "warnings": "; ".join(self.warnings),
        }

    def _page(self) -> Page:
        units = {"eps": f"m^m/{self.measurements.unit}", "gap": "m", "m": "1"}
        rows = [
            (f"{name} [{units[name]}]", f"{p.value:.6g}", f"{p.error:.2g}", _span(p.single, 5), _span(p.joint, 5))
            for name, p in self.parameters.items()
        ]
        head = ("parameter", "value", "uncertainty", "interval, alone", "interval, all three at once")
        notes = [self.conclusion, *self.warnings, *left_out(self.outliers)]
        return Page("p = max(u - gap, 0)^m / eps, fitted", rows, head, "OBSERVED", notes)

    @property
    @derived()
    def warnings(self) -> tuple[str, ...]:
        """What speaks against the fit."""
        found = [self.note] if self.note else []
        if self.misfit < _MISFIT:
            found.append(
                f"The data contradict the nonlinearity (p = {self.misfit:.1g} against a free one): the intervals say "
                f"nothing."
            )
        return tuple(found)

    def __str__(self) -> str:
        lines = [self.conclusion]
        for name in NAMES:
            p = self.parameters[name]
            lines.append(f"  {name} = {p.value:.5g} +- {p.error:.2g}, alone in {_span(p.single)}")
        pairs = ", ".join(
            f"{('log eps', 'gap', 'm')[i]} and {('log eps', 'gap', 'm')[j]} {self.correlation[i, j]:+.3f}"
            for i, j in ((0, 1), (0, 2), (1, 2))
        )
        lines.append(f"  correlations: {pairs}")
        lines.append(
            f"  {self.in_contact} of {len(self.measurements)} rows in contact, {100 * self.explained:.2f} % of the "
            f"variance explained, noise {self.noise.constant:.3g} {self.measurements.unit} + "
            f"{100 * self.noise.proportional:.2g} % of the load, p = {self.misfit:.2g} against a free nonlinearity"
        )
        if self.outliers:
            lines.append(
                f"  outliers, left out: {', '.join(f'line {o.line} ({o.score:+.1f})' for o in self.outliers[:8])}"
            )
        return "\n".join([*lines, *(f"  warning: {text}" for text in self.warnings)])


def _span(ends: tuple[float, float], digits: int = 4) -> str:
    return f"[{ends[0]:.{digits}g}, {ends[1]:.{digits}g}]"


# The sum of squares of the compliance law: its minimum, its profiles, and the intervals they give.

Array = NDArray[np.float64]
_DEEPEST, _HIGHEST = -50.0, 25.0  # gap below the data, in ranges of displacement; exponent
_LOWEST = 0.05
_STEPS = 60
_STRIDE, _GROWTH = 0.4, 1.15


class Problem:
    """Least squares for ``y = exp(b) ((x - g)/(1 - g))^m`` beyond ``g``; ``0 <= x <= 1``, ``|y| <= 1``.

    ``b``, the logarithm of the load at the largest displacement, is nearly uncorrelated with the gap ``g`` and the
    exponent ``m``.  What is wanted is ``e = log eps`` instead, ``e = m log(U (1 - g)) - log F - b`` in the units ``U``
    and ``F`` of ``x`` and ``y``.  ``weights`` (of residuals) and ``kept`` (no outliers) may be set.
    """

    def __init__(self, displacement: Array, load: Array) -> None:
        self.origin = float(displacement.min())
        self.units = float(np.ptp(displacement)), float(np.abs(load).max())
        if not (self.units[0] > 0 and self.units[1] > 0 and math.isfinite(1 / (self.units[0] * self.units[1]))):
            raise AssumptionError(
                "the displacement or the load does not vary; a nonlinearity needs measurements that do"
            )
        self.x, self.y = (displacement - self.origin) / self.units[0], load / self.units[1]
        self.weights = np.ones_like(self.x)
        self.kept = np.ones(self.x.size, dtype=bool)

    @property
    def degrees(self) -> int:
        """Rows kept less the three parameters."""
        return int(self.kept.sum()) - 3

    def nonlinearity(self, point: Array) -> Array:
        """The nonlinearity at the rows for ``(b, g, m)``."""
        b, g, m = _inside(point)
        s = np.maximum(self.x - g, 0.0) / (1 - g)
        return np.asarray(math.exp(b) * s**m)

    def slopes(self, point: Array) -> Array:
        """(n, 3) derivatives of the nonlinearity by ``(b, g, m)``."""
        b, g, m = _inside(point)
        s = (self.x - g) / (1 - g)
        touching = s > 0
        safe = np.where(touching, np.maximum(s, 1e-12), 1.0)
        y = np.where(touching, math.exp(b) * safe**m, 0.0)
        return np.column_stack([y, y * m * (self.x - 1) / ((1 - g) ** 2 * safe), y * np.log(safe)])

    def least(self, point: Array) -> float:
        """Sum of weighted squares of the rows kept."""
        return float(np.sum(((self.y - self.nonlinearity(point)) * self.weights)[self.kept] ** 2))

    def minimum(self, start: Array, *, robust: bool = False) -> Array:
        """The best ``(b, g, m)`` near a start; ``robust`` grows linearly with large residuals."""
        from scipy.optimize import least_squares

        w, kept = self.weights, self.kept
        scale = 1.0
        if robust:
            scale = max(1.4826 * float(np.median(np.abs((self.y - self.nonlinearity(start)) * w))), 1e-12)
        found = least_squares(
            lambda point: ((self.nonlinearity(point) - self.y) * w)[kept],
            start,
            jac=lambda point: (self.slopes(point) * w[:, None])[kept],
            loss="soft_l1" if robust else "linear",
            f_scale=scale,
            method="trf" if robust else "lm",
            max_nfev=400,
        )
        return np.array(_inside(np.asarray(found.x, dtype=float)))

    def wanted(self, point: Array) -> Array:
        """``(e, g, m)`` for ``(b, g, m)``."""
        b, g, m = _inside(point)
        return np.array([m * math.log(self.units[0] * (1 - g)) - math.log(self.units[1]) - b, g, m])

    def _point(self, wanted: Array) -> Array:
        """``(b, g, m)`` for ``(e, g, m)``: the same formula with the two exchanged."""
        e, g, m = wanted
        g, m = min(g, 1 - 1e-9), max(m, _LOWEST)
        return np.array([m * math.log(self.units[0] * (1 - g)) - math.log(self.units[1]) - e, g, m])

    def _change(self, point: Array) -> Array:
        """(3, 3) derivative of ``(b, g, m)`` by ``(e, g, m)``."""
        _, g, m = _inside(point)
        return np.array([[-1.0, -m / (1 - g), math.log(self.units[0] * (1 - g))], [0, 1, 0], [0, 0, 1]])

    def covariance(self, point: Array) -> Array:
        """(3, 3) of ``(e, g, m)`` for errors of weight one, linearised at the minimum."""
        slopes = (self.slopes(point) * self.weights[:, None])[self.kept]
        inverse = np.linalg.pinv(slopes.T @ slopes, rcond=1e-15, hermitian=True)
        back = np.linalg.inv(self._change(point))
        return np.asarray(back @ inverse @ back.T)

    def profile(self, i: int, value: float, start: Array) -> tuple[float, Array]:
        """The least sum of squares with the ``i``-th of ``(e, g, m)`` held, and where, from a start ``(e, g, m)``."""
        from scipy.optimize import least_squares

        others = [j for j in range(3) if j != i]

        def whole(rest: Array) -> Array:
            """All three parameters, the i-th held."""
            full = np.empty(3)
            full[i], full[others] = value, rest
            return self._point(full)

        # held eps ties the load to the exponent: the step is taken along that valley by the exact derivative
        found = least_squares(
            lambda rest: ((self.nonlinearity(whole(rest)) - self.y) * self.weights)[self.kept],
            start[others],
            jac=lambda rest: (self.slopes(whole(rest)) @ self._change(whole(rest))[:, others] * self.weights[:, None])[
                self.kept
            ],
            method="lm",
            max_nfev=100,
        )
        full = np.empty(3)
        full[i], full[others] = value, found.x
        return 2 * float(found.cost), full

    def outlying(self, scores: Array) -> NDArray[np.bool_]:
        """Which rows are far from the curve and from their neighbours, by a limit that one clean set in 100 passes."""
        from lure.analysis.measured.mean_nonlinearity import outlying

        return outlying(self.x, scores, parameters=3)


def _inside(point: Array) -> tuple[float, float, float]:
    """``(b, g, m)`` where the nonlinearity is defined and its parameters mean something."""
    b, g, m = (float(value) for value in point)
    return min(max(b, -200.0), 200.0), min(max(g, _DEEPEST), 1 - 1e-9), min(max(m, _LOWEST), _HIGHEST)


def at_an_end(point: Array) -> bool:
    """Whether a minimum has run to an end of the gaps or exponents that are searched."""
    _, g, m = _inside(point)
    return g <= 0.98 * _DEEPEST or m >= 0.98 * _HIGHEST or m <= 1.02 * _LOWEST


def joint_limit(confidence: float, degrees: int) -> float:
    """Rise of the sum of squares, in variances, that bounds a region of all three parameters."""
    from scipy.stats import f as fisher

    return 3 * float(fisher.ppf(confidence, 3, degrees))


def single_limit(confidence: float, degrees: int) -> float:
    """Rise of the sum of squares, in variances, that bounds one parameter."""
    from scipy.stats import f as fisher

    return float(fisher.ppf(confidence, 1, degrees))


def profile_interval(problem: Problem, best: Array, i: int, limit: float, error: float) -> tuple[float, float]:
    """Where the profile of the ``i``-th of ``(e, g, m)`` stays within a limit of its minimum; ends may be infinite."""
    centre = problem.wanted(best)
    least = problem.least(best)
    step = _STRIDE * max(error, 1e-9 * max(1.0, abs(float(centre[i]))))
    step *= math.sqrt(limit * problem.degrees / max(least, 1e-300)) if least > 0 else 1.0
    low, high = (_end(problem, centre, i, (least + limit, sign * step)) for sign in (-1, 1))
    return low, high


def _end(problem: Problem, centre: Array, i: int, walk: tuple[float, float]) -> float:
    """Where the profile crosses the level for good, walking outwards; two steps in a row above it end the walk."""
    from scipy.optimize import brentq

    level, step = walk
    inner, outer, above = (float(centre[i]), centre), None, 0
    value, start = float(centre[i]), centre
    for _ in range(_STEPS):
        value += step
        if (i == 1 and (value < _DEEPEST or value >= 1)) or (i == 2 and not _LOWEST < value < _HIGHEST):
            break
        least, start = problem.profile(i, value, start)
        if least > level:
            above += 1
            outer = value if outer is None else outer
        else:
            above, inner, outer = 0, (value, start), None
        if above == 2:
            break
        step *= _GROWTH
    if outer is None:
        return (math.copysign(math.inf, step), 1.0 if step > 0 else -math.inf, math.inf if step > 0 else 0.0)[i]
    ends = sorted((inner[0], outer))
    return float(
        brentq(lambda t: problem.profile(i, t, inner[1])[0] - level, *ends, xtol=1e-5 * abs(ends[1] - ends[0]))
    )


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
    displacements without error, and the nonlinearity itself; ``misfit`` tests the nonlinearity against a free one.

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
    >>> from lure.analysis.measured import example_measurements
    >>> found = fit_compliance(example_measurements())
    >>> print(f"m = {found.parameters['m'].value:.2f}")
    m = 1.50
    """
    if branch not in (None, "loading", "unloading"):
        raise InputError(f"branch is {branch!r:.40}; give 'loading' or 'unloading'")
    if not (isinstance(confidence, float) and 0.5 <= confidence <= 0.9999):
        raise InputError(f"confidence is {confidence!r:.40}; give a number between 0.5 and 0.9999")
    units = measurements.displacement_unit, measurements.unit
    if units[0] != "m" or units[1] not in ("N", "Pa"):
        raise AssumptionError(
            f"a contact law relates m to N or Pa, and the data {units[0]} to {units[1]}; leave the fit out"
        )
    note = ""
    if branch is None and hysteresis_from_data(measurements) is not None:
        branch = "loading"
        note = (
            "Loading and unloading differ by more than noise: fitted is loading alone, and unloading does not obey it."
        )
    rows = measurements.rows(branch) if branch else np.arange(len(measurements))
    if rows.size < 12:
        raise InputError(f"there are {rows.size} rows{f' of {branch}' if branch else ''}; give at least 12")
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
        mean = problem.nonlinearity(best)
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
    return problem, best, (problem.y - problem.nonlinearity(best)) * problem.weights / max(scale, 1e-300), noise


def _start(problem: Problem) -> Array:
    """The best of a grid of gaps and exponents, by the sum of absolute residuals."""
    low, high = float(problem.x.min()), float(problem.x.max())
    found: tuple[float, Array] | None = None
    for gap in np.linspace(low - 0.2 * (high - low), high, _GAPS, endpoint=False):
        for m in _EXPONENTS:
            shape = problem.nonlinearity(np.array([0.0, gap, m]))
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
    free = mean_nonlinearity(used.displacement[inside] - gap, used.load[inside], free=True)
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
    """Share of the weighted variance of the load that the nonlinearity explains."""
    weights = np.where(problem.kept, problem.weights, 0.0) ** 2
    mean = float(np.sum(weights * problem.y) / np.sum(weights))
    return 1 - problem.least(best) / float(np.sum(weights * (problem.y - mean) ** 2))
