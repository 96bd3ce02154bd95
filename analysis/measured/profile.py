"""The sum of squares of the compliance law: its minimum, its profiles, and the intervals they give."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from lure.errors import AssumptionError

Array = NDArray[np.float64]
_DEEPEST, _HIGHEST = -50.0, 25.0  # gap below the data, in ranges of displacement; exponent
_LOWEST = 0.05
_STEPS = 60
_STRIDE, _GROWTH = 0.4, 1.15
_NEIGHBOURS = 3


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
            raise AssumptionError("the displacement or the load does not vary; a law needs measurements that do")
        self.x, self.y = (displacement - self.origin) / self.units[0], load / self.units[1]
        self.weights = np.ones_like(self.x)
        self.kept = np.ones(self.x.size, dtype=bool)

    @property
    def degrees(self) -> int:
        """Rows kept less the three parameters."""
        return int(self.kept.sum()) - 3

    def law(self, point: Array) -> Array:
        """The law at the rows for ``(b, g, m)``."""
        b, g, m = _inside(point)
        s = np.maximum(self.x - g, 0.0) / (1 - g)
        return np.asarray(math.exp(b) * s**m)

    def slopes(self, point: Array) -> Array:
        """(n, 3) derivatives of the law by ``(b, g, m)``."""
        b, g, m = _inside(point)
        s = (self.x - g) / (1 - g)
        touching = s > 0
        safe = np.where(touching, np.maximum(s, 1e-12), 1.0)
        y = np.where(touching, math.exp(b) * safe**m, 0.0)
        return np.column_stack([y, y * m * (self.x - 1) / ((1 - g) ** 2 * safe), y * np.log(safe)])

    def least(self, point: Array) -> float:
        """Sum of weighted squares of the rows kept."""
        return float(np.sum(((self.y - self.law(point)) * self.weights)[self.kept] ** 2))

    def minimum(self, start: Array, *, robust: bool = False) -> Array:
        """The best ``(b, g, m)`` near a start; ``robust`` grows linearly with large residuals."""
        from scipy.optimize import least_squares

        w, kept = self.weights, self.kept
        scale = 1.0
        if robust:
            scale = max(1.4826 * float(np.median(np.abs((self.y - self.law(start)) * w))), 1e-12)
        found = least_squares(
            lambda point: ((self.law(point) - self.y) * w)[kept],
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
            lambda rest: ((self.law(whole(rest)) - self.y) * self.weights)[self.kept],
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
        """Which rows are far from the law and from their neighbours, by a limit that one clean set in 100 passes."""
        from analysis.measured.outlying import outlying

        return outlying(self.x, scores, parameters=3)


def _inside(point: Array) -> tuple[float, float, float]:
    """``(b, g, m)`` where the law is defined and its parameters mean something."""
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
    return tuple(_end(problem, centre, i, (least + limit, sign * step)) for sign in (-1, 1))  # type: ignore[return-value]  # two


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
