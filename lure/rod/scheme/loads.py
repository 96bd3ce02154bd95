"""Loads on the scheme: any load as a polynomial on each step, and a force that needs no steps.

A load is fitted at Chebyshev points of a step and checked between them.  A force at ``x = 0`` that is a sum of
exponentials times powers needs neither: the Poisson average of ``n (n-1) .. (n-k+1) (1 + lambda)^{n-k}`` is
``tau^k e^{lambda tau}``, with ``lambda`` in units of ``s``.  So it is a sequence ``g_n``, and the register that takes
in ``2 b g_n`` at its ``n``-th step has the forced motion of the scheme as its average: no fit and no step, as without a
force.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise

import numpy as np

from lure.arrays import Reals as Array
from lure.errors import InputError
from lure.expressions import Expression
from lure.expressions.exponentials import Sum, exponentials
from lure.record import described, quantity
from lure.rod.discretisation import UpwindScheme
from lure.rod.scenario import Scenario
from lure.rod.scheme.poisson import chebyshev_fit, chebyshev_points, chebyshev_values

TERMS = 12
_END = 1e-6
_POINTS, _FIT = chebyshev_points(TERMS), chebyshev_fit(TERMS)
_RUN = 1024
_ELSEWHERE = "lure.analysis.rod.simulation.simulate takes any load, up to 1000 cells"


@described(frozen=True, kw_only=True, slots=True)
class Loads:
    """The loads of a scenario on a grid."""

    force: Expression | None = quantity("``g(t)`` [N]; None where there is none")
    body_force: Expression | None = quantity("``f(t, x)`` [N/m]; None where there is none")
    x: Array = quantity("(2N,) place of each wave's grid value, in the order (39)", "m")
    breakpoints: tuple[float, ...] = quantity("Instants at which a load may change its formula [s]: steps end there")
    known: bool = quantity("Whether these are all; where they are not, steps shrink until the polynomial fits")
    tolerance: float = quantity("Accuracy of the fit relative to the largest load met so far")

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


@described(frozen=True, kw_only=True, slots=True)
class LoadFit:
    """Chebyshev coefficients of the loads on a step."""

    force: Array | None = quantity("(TERMS,)", "N")
    body_force: Array | None = quantity("(TERMS, 2N) [N/m]")
    largest: tuple[float, float] = quantity("Largest force and body force met, relative units of the run")
    resolved: bool = quantity("Whether the fit holds between its points")


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


@described(frozen=True, kw_only=True, slots=True)
class LoadGrid:
    """Where on a step the loads are read: the Chebyshev points, then points evenly spaced that check the fit."""

    points: Array = quantity("(TERMS + checks + 2,) shares of the step, in (0, 1)")
    basis: Array = quantity("(checks + 2, TERMS) Chebyshev polynomials at the checks")


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


@described(frozen=True, kw_only=True, eq=False)
class Force:
    """A force in pieces, each a sum of exponentials times powers."""

    rate: float = quantity("``s`` of the scheme [1/s]")
    gain: float = quantity("What a unit of force adds to the first wave in a step of the register [m/(N s)]")
    edges: tuple[Fraction, ...] = quantity("Where the pieces meet", "s")
    pieces: tuple[Sum, ...] = quantity("One more than edges")

    def end(self, clock: Fraction) -> Fraction | None:
        """Where the piece that begins at or contains ``clock`` ends, both in units of ``1/s``; None for the last."""
        place = bisect_right(self.edges, clock / Fraction(self.rate))
        return Fraction(self.rate) * self.edges[place] if place < len(self.edges) else None

    def reach(self, clock: Fraction) -> int:
        """Steps of the register over which the sequence of the piece at ``clock`` keeps the size of the force."""
        rates = [abs(rate) / self.rate for rate, _ in self._piece(clock)]
        fastest = max(rates, default=0.0)
        return max(1, int(min(1e9, fastest**-2 if fastest > 0.0 else math.inf)))

    def entering(self, clock: Fraction, count: int) -> Array:
        """(count,) what enters the first wave at the steps from ``clock`` on [m/s].

        Raises
        ------
        InputError
            The force grows beyond the range of doubles.
        """
        start = float(clock / Fraction(self.rate))
        waves: dict[int, list[tuple[complex, complex]]] = {}
        with np.errstate(over="ignore", invalid="ignore"):
            for (rate, power), weight in self._piece(clock).items():
                step = rate / self.rate
                size = self.gain * weight * (2.0 if rate.imag > 0.0 else 1.0) * complex(np.exp(rate * start))
                for k in range(power + 1) if rate.imag >= 0.0 else ():  # conjugates come in pairs
                    share = math.comb(power, k) * start ** (power - k) / self.rate**k
                    waves.setdefault(k, []).append((step, size * share * (1.0 + step) ** -k))
            total, falling, n = np.zeros(count), np.ones(1), np.arange(count, dtype=float)
            for k in range(max(waves, default=-1) + 1):
                total += falling * _powers(waves[k], count) if k in waves else 0.0
                falling = falling * (n - k)
        if not np.isfinite(total).all():
            raise InputError(f"force.g grows beyond the range of doubles after {start:.6g} s; give an earlier end")
        return total

    def _piece(self, clock: Fraction) -> Sum:
        return self.pieces[bisect_right(self.edges, clock / Fraction(self.rate))]


def _powers(waves: list[tuple[complex, complex]], count: int) -> Array:
    """The sum of ``Re[weight (1 + step)^n]`` over pairs of step and weight: blocks times a block."""
    sizes = np.array([0.5 * math.log1p(step.real * (2.0 + step.real) + step.imag**2) for step, _ in waves])
    growth = sizes + 1j * np.array([math.atan2(step.imag, 1.0 + step.real) for step, _ in waves])
    blocks = np.exp(np.multiply.outer(np.arange(0, count, _RUN), growth)) * np.array([weight for _, weight in waves])
    inside = np.exp(np.multiply.outer(growth, np.arange(_RUN)))
    product = np.hstack((blocks.real, -blocks.imag)) @ np.vstack((inside.real, inside.imag))
    return np.asarray(product.ravel()[:count])


def force_of(scheme: UpwindScheme, load: Expression, until: float) -> Force | None:
    """The force of a scenario on a scheme up to ``until`` [s]; None if it is zero.

    ``scheme``: its form scales the force; ``load``: ``g(t)`` [N].

    Raises
    ------
    InputError
        The formula is not piece by piece a sum of powers times exponentials, or changes faster than cells are crossed.
    """
    if load.is_zero:
        return None
    edges = load.breakpoints("t", 0, until)
    if edges is None:
        raise InputError(
            f"force.g is {str(load)[:60]}; structured_motion needs to know where its pieces meet, and so "
            f"conditions that compare straight lines in t; {_ELSEWHERE}"
        )
    bounds = (Fraction(0), *edges, Fraction(until))
    pieces = []
    for left, right in pairwise(bounds):
        piece = exponentials(load.tree, "t", (left + right) / 2)
        if piece is None:
            raise InputError(
                f"force.g is {str(load)[:60]}; structured_motion takes sums and products of numbers, t (up to t**8), "
                f"and exp, sin and cos of straight lines in t, piece by piece; {_ELSEWHERE}"
            )
        pieces.append(piece)
    fastest = max((abs(rate) for piece in pieces for rate, _ in piece), default=0.0)
    if fastest >= scheme.rate:
        least = math.floor(scheme.cells * fastest / scheme.rate) + 1
        raise InputError(
            f"force.g changes at {fastest:.3g} 1/s, faster than the {scheme.cells} cells are crossed; give at least "
            f"{least} cells"
        )
    return Force(rate=scheme.rate, gain=scheme.force_gain, edges=edges, pieces=tuple(pieces))
