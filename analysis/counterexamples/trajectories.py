"""Many solutions of one loop at once, in scaled coordinates: the integrators behind confirmation by simulation."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from enum import Enum
from fractions import Fraction

from lure.analysis.counterexamples.linear import Realisation
from lure.analysis.counterexamples.piecewise import BLOCK, Flow, PiecewiseLoop
from lure.analysis.counterexamples.simulated import Characteristic, bracketed_root, graph_of
from lure.arrays import ArrayLike, Reals, balanced, in_doubles, integrate, np
from lure.errors import InputError, Reason
from lure.nonlinearities import Tanh
from lure.nonlinearities.piecewise_linear import Graph
from lure.plants.rational import RationalPlant
from lure.record import described, quantity

Values = Callable[[ArrayLike], Reals]

_BLOCKS = 100
"""Blocks of steps in which a piecewise-linear graph is followed exactly from kink to kink; beyond, an integrator."""
_PASSAGE = 5
"""Evaluations of the nonlinearity that cost as much as a passage from kink to kink."""
_ABSOLUTE = 1e-4
"""Absolute tolerance of the integrator, relative to its relative one and the size of a coordinate."""


_ESCAPED = 1e14
"""Growth in one stretch after which a solution is followed no further."""


class Finding(Enum):
    """What one simulated solution does."""

    CONVERGES = "converges to 0"
    RESTS = "comes to rest at an equilibrium other than 0"
    OSCILLATES = "oscillates without decay"
    GROWS = "grows"
    UNSOLVABLE = "has no solution from some time on"
    OPEN = "is not decided by the run"

    def __str__(self) -> str:
        return self.value


@described(frozen=True, kw_only=True, slots=True, eq=False)
class Trajectory:
    """One simulated solution of ``sigma = H mu``, ``mu = -phi(sigma)``, for figures and tables: OBSERVED evidence."""

    t: Reals = quantity("(samples,) instants [s], ascending from 0; multiples of the sampling time in discrete time")
    sigma: Reals = quantity(
        "(samples,) input of ``phi`` at these instants, a few hundred at most; with several channels (samples, m)"
    )
    mu: Reals = quantity("Input of the block, likewise")
    nonlinearity: str = quantity("The nonlinearity, in words")
    start: str = quantity("The first state, in words")
    finding: Finding = quantity("What the whole run showed, which may be longer than what is kept here")
    until: float = quantity("Length of the whole run", "s")
    discrete: bool = quantity("Whether time is discrete")
    unit: str = quantity("Of the times, 'samples' where no sampling time is stated", default="s")


class OutOfBudget(Exception):
    """The evaluations granted to a simulation are used up."""


class BatchLoop:
    r"""``x' = A x + b mu``, ``sigma = c x + d mu``, ``mu = -phi(sigma)`` for many first states at once, in doubles.

    Time is measured in a unit near the period of the loop over ``2 pi``, and the companion form is balanced, so that
    plants whose poles are of any size become matrices of moderate entries.

    Parameters
    ----------
    block : RationalPlant
        The block.
    nonlinearity : Graph, nonlinearity of the library or callable
        ``phi``, elementwise.
    gain : Fraction
        A gain of the class, whose loop gives the unit of time.
    budget : int
        Evaluations of the nonlinearity, each for all solutions at once, that the simulations may use altogether.

    Raises
    ------
    InputError
        A coefficient leaves the range of doubles.
    """

    def __init__(self, block: RationalPlant, nonlinearity: Characteristic, *, gain: Fraction, budget: int) -> None:
        self.nonlinearity, self.budget, self.used = nonlinearity, budget, 0
        self.values = kernel(nonlinearity)
        self.discrete, n = block.dt is not None, block.order
        unit = Fraction(1) if block.dt is not None else 1 / natural_frequency(block, gain)
        self.seconds, self.unit = float(unit if block.dt is None else block.dt), "samples" if block.any_period else "s"
        exact = (
            block.realisation
        )  # its own matrices if it has any: a finely sampled companion form is spoilt by doubles
        powers_of_unit = [n - i if block.matrices is None else 1 for i in range(n)]
        scale = [unit**power for power in powers_of_unit]  # x_i = scale_i x~_i, time = unit times the scaled one
        try:
            rough = _similar(exact, scale, unit)
            _, powers = balanced(in_doubles(rough.A).reshape(n, n))
            self.system = _similar(exact, [v * Fraction(float(w)) for v, w in zip(scale, powers, strict=True)], unit)
            self.A = in_doubles(self.system.A).reshape(n, n)
            self.b, self.c = (np.array([float(v) for v in side]) for side in (self.system.b, self.system.c))
            self.weights = np.array([float(v) for v in scale]) * powers
        except OverflowError:
            raise InputError(
                "a coefficient of the scaled loop leaves the range of doubles", code=Reason.RANGE
            ) from None
        self.d, self.order, self.gain = float(exact.d), n, max(abs(float(gain)), 1e-300)
        below = sum(block.denominator) if self.discrete else block.denominator[-1]
        above = sum(block.numerator) if self.discrete else block.numerator[-1]
        self._static = float(above / below) if below else None
        self._last: Reals = np.zeros(0)
        self._slope: Reals = np.zeros(0)
        self._flow = None if self.discrete else _flow_of(self.system, graph_of(nonlinearity))

    def closed(self, gain: float) -> Reals:
        """The matrix of the loop with ``mu = -gain sigma``; needs ``1 + gain d != 0``."""
        return self.A - gain / (1 + gain * self.d) * np.outer(self.b, self.c)

    def sigma_of(self, states: Reals) -> tuple[Reals, Reals]:
        """``sigma`` and ``phi(sigma)`` of states, one a row; NaN where ``sigma + d phi(sigma) = c x`` has no root."""
        self.used += 1
        if self.used > self.budget:
            raise OutOfBudget
        with np.errstate(all="ignore"):  # a lost run has states that are not finite
            y = states @ self.c
            if self.d == 0:
                return y, np.asarray(self.values(y), dtype=float)
            sigma = self._roots(y)
            return sigma, np.asarray(self.values(sigma), dtype=float)

    def _roots(self, y: Reals) -> Reals:
        """Roots of ``sigma + d phi(sigma) = y``: by iteration from the last ones, by bisection where that fails."""
        known = self._last.shape == y.shape
        sigma = np.where(np.isfinite(self._last), self._last, y) if known else y.copy()
        slope = self._slope if known else np.ones_like(y)
        before, held = np.full_like(y, np.nan), np.full_like(y, np.nan)
        for _ in range(12):
            residual, size = self._residual(sigma, y)
            good = np.abs(residual) <= 1e-13 * size
            if good.all():
                break
            chord = (residual - held) / (sigma - before)
            slope = np.where(np.isfinite(chord) & (np.abs(chord) > 1e-9), chord, slope)
            before, held, sigma = sigma, residual, np.where(good, sigma, sigma - residual / slope)
        for i in np.flatnonzero(~good & np.isfinite(y)):
            sigma[i] = bracketed_root(self.values, self.d, float(y[i]))
        self._last, self._slope = sigma, slope
        return sigma

    def _residual(self, sigma: Reals, y: Reals) -> tuple[Reals, Reals]:
        """The residual, and the size of its terms."""
        self.used += 1
        own = self.d * np.asarray(self.values(sigma), dtype=float)
        return sigma + own - y, np.abs(sigma) + np.abs(own) + np.abs(y) + 1e-300

    def rests_at(self, sigma: float) -> float:
        """How far ``sigma`` is from an equilibrium: 0 at one, of the order of 1 elsewhere; signed."""
        phi = float(np.asarray(self.values(sigma), dtype=float))
        if self._static is None:
            return phi / (self.gain * abs(sigma))
        return (sigma + self._static * phi) / (abs(sigma) + abs(self._static * phi))

    @property
    def integrates(self) -> bool:
        """Whether the block has a pole at 0 (``z = 1``): then ``phi = 0`` at every equilibrium."""
        return self._static is None

    def advance(self, states: Reals, span: float, samples: int, rtol: float) -> tuple[Reals, Reals]:
        """Scaled instants ``(samples,)`` from 0 and states ``(runs, samples, n)``; NaN from where a run is lost."""
        if self.discrete:
            return self._recursion(states, samples)
        if self._flow is not None and span * self._flow.quickest <= _BLOCKS * BLOCK:
            return self._exact(self._flow, states, span, samples)
        return self._integral(states, span, samples, rtol)

    def _exact(self, flow: Flow, states: Reals, span: float, samples: int) -> tuple[Reals, Reals]:
        """From kink to kink of a piecewise-linear nonlinearity."""
        times = np.linspace(0.0, span, samples)
        found = np.full((len(states), samples, self.order), np.nan)
        for i, start in enumerate(states):
            self.used += int(1 + span * flow.quickest / BLOCK)
            passages = flow.passages(start, span, most=max(1, (self.budget - self.used) // _PASSAGE))
            self.used += _PASSAGE * len(passages)
            if self.used > self.budget:
                raise OutOfBudget
            found[i] = flow.sampled(passages, times)
        return times, found

    def _recursion(self, states: Reals, samples: int) -> tuple[Reals, Reals]:
        found = np.empty((len(states), samples, self.order))
        x = states
        with np.errstate(all="ignore"):
            for i in range(samples):
                found[:, i] = x
                if i + 1 < samples:
                    x = x @ self.A.T - self.sigma_of(x)[1][:, None] * self.b
        return np.arange(samples, dtype=float), found

    def _integral(self, states: Reals, span: float, samples: int, rtol: float) -> tuple[Reals, Reals]:
        runs, n = states.shape
        times = np.linspace(0.0, span, samples)
        size = np.abs(states).max(axis=1, keepdims=True)
        far, fastest = _ESCAPED * size, _ESCAPED**1.5 * size

        def velocity(flat: Reals, _: float) -> Reals:
            """Right-hand side, the solutions one after the other; 0 where ``sigma`` does not exist.

            Its size is bounded: a solution that escapes in finite time would stop all others.
            """
            x = flat.reshape(runs, n)
            phi = self.sigma_of(x)[1]
            with np.errstate(all="ignore"):
                rates = x @ self.A.T - phi[:, None] * self.b
                rates /= 1 + np.abs(rates).max(axis=1, keepdims=True) / fastest
            if not math.isfinite(float(rates.sum())):
                rates[~np.isfinite(rates).all(axis=1)] = 0.0
            return np.asarray(rates.ravel())

        with warnings.catch_warnings():
            warnings.simplefilter("ignore", integrate.ODEintWarning)
            band = {"ml": n - 1, "mu": n - 1} if runs > 1 else {}
            weights = np.maximum(rtol * _ABSOLUTE * np.repeat(size, n, axis=1), 1e-280).ravel()
            found, info = integrate.odeint(
                velocity, states.ravel(), times, rtol=rtol, atol=weights, full_output=True, mxstep=100_000, **band
            )
        path = np.swapaxes(found.reshape(samples, runs, n), 0, 1).copy()
        if not str(info["message"]).startswith("Integration successful"):
            if runs > 1:  # one solution may have stopped all others
                singles = [self._integral(states[i : i + 1], span, samples, rtol)[1] for i in range(runs)]
                return times, np.concatenate(singles)
            reached = 1 + int(np.count_nonzero(np.asarray(info["tcur"]) >= times[1:]))
            path[:, reached:] = np.nan
        beyond = np.abs(path).max(axis=2) > far
        path[np.maximum.accumulate(beyond, axis=1) & np.roll(beyond, 1, axis=1)] = np.nan  # the first such sample tells
        return times, path


def kernel(nonlinearity: Characteristic) -> Values:
    """The nonlinearity as a function of arrays that costs little a call.

    ``nonlinearity``: ``phi``.
    """
    graph = graph_of(nonlinearity)
    if graph is not None:
        ends = np.array([-math.inf, *(float(x) for x in graph.knots), math.inf])
        low, high, slopes = ends[:-1], ends[1:], np.array([float(slope) for slope in graph.slopes])
        base = np.clip(0.0, low, high)

        def piecewise(sigma: ArrayLike) -> Reals:
            """Slope times the part of ``[0, sigma]`` on each piece, summed: accurate near 0 as elsewhere."""
            at = np.asarray(sigma, dtype=float)[..., None]
            return np.asarray((np.clip(at, low, high) - base) @ slopes)

        return piecewise
    if type(nonlinearity) is Tanh:
        gain, scale = float(nonlinearity.gain), float(nonlinearity.scale)
        return lambda sigma: np.asarray(gain * np.tanh(np.asarray(sigma) / scale))
    return nonlinearity


def _similar(system: Realisation, scale: list[Fraction], unit: Fraction) -> Realisation:
    """The same system in the states ``x_i / scale_i`` and in time measured in ``unit``, exactly."""
    rows = tuple(tuple(unit * a * scale[j] / scale[i] for j, a in enumerate(row)) for i, row in enumerate(system.A))
    b = tuple(unit * v / scale[i] for i, v in enumerate(system.b))
    return Realisation(rows, b, tuple(v * scale[i] for i, v in enumerate(system.c)), system.d)


def _flow_of(system: Realisation, graph: Graph | None) -> Flow | None:
    if graph is None or graph.is_line or any(1 + system.d * slope <= 0 for slope in graph.slopes):
        return None
    return Flow(PiecewiseLoop.of(system, graph))


def natural_frequency(block: RationalPlant, gain: Fraction) -> Fraction:
    """A power of two near the geometric mean of the sizes of the loop's poles other than 0 [rad/s].

    ``gain``: the gain ``k`` of the loop with ``mu = -k sigma``.
    """
    n, d = block.numerator, block.denominator
    padded = (*[Fraction(0)] * (len(d) - len(n)), *n)
    total = [a + gain * v for a, v in zip(d, padded, strict=True)]
    lead = next((i for i, v in enumerate(total) if v), None)
    last = next((i for i in range(len(total) - 1, -1, -1) if total[i]), None)
    if lead is None or last is None or last == lead:
        return Fraction(1)
    ratio = abs(total[last] / total[lead])
    exponent = (math.log2(ratio.numerator) - math.log2(ratio.denominator)) / (last - lead)
    return Fraction(2) ** round(exponent)
