"""One smooth piece of a motion of the scheme, and what an integrator makes of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.comparison.equations import SchemeEquations

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Leg:
    """Flight or contact from an instant on, until it ends or a load changes its formula.

    Attributes
    ----------
    equations : SchemeEquations
        What to integrate.
    touching : bool
        Whether the law of contact or that of flight holds.
    start, end : float
        From when and to when at most [s].
    span : (float, float)
        Instants between which the formulas of the loads do not change [s].
    y : ndarray
        (2N+1,) folded state at the start.
    times : ndarray
        Instants at which the motion is wanted, from the start to the end of the leg [s].
    longest : float
        Longest step, and longest stretch over which the sign of ``z`` is not looked at [s].
    rtol : float
        Relative tolerance.
    atol : ndarray
        (2N+1,) absolute tolerance, folded [m/s] and, for ``z``, [m].
    watch : bool
        Whether the first step may end the leg; not, if rounding has just ended several at this instant.
    """

    equations: SchemeEquations
    touching: bool
    start: float
    end: float
    span: tuple[float, float]
    y: Array
    times: Array
    longest: float
    rtol: float
    atol: Array
    watch: bool = True

    def rate(self, t: float, y: Array) -> Array:
        """``y'``."""
        return self.equations.rate(t, y, touching=self.touching, span=self.span)

    @property
    def noise(self) -> float:
        """Sizes of ``z`` below this say nothing [m]."""
        return 1e-3 * float(self.atol[-1]) + 64.0 * float(np.finfo(float).eps) * abs(float(self.y[-1]))

    def depth(self, z: Array) -> Array:
        """``z`` with the sign that the leg should keep: positive while the leg may go on."""
        return z if self.touching else -z


@dataclass(frozen=True, kw_only=True, eq=False)
class Walked:
    """How far a leg went.

    Attributes
    ----------
    t : float
        Where it ended [s].
    y : ndarray
        (2N+1,) state there.
    rows : ndarray
        (k, 3) what was observed at the wanted instants up to there.
    left : bool
        Whether the phase ended, and not merely the leg.
    steps : int or None
        Steps taken; None if the integrator does not tell.
    evaluations : int
        Evaluations of the right-hand side, those for difference quotients included.
    """

    t: float
    y: Array
    rows: Array
    left: bool
    steps: int | None
    evaluations: int


@dataclass(kw_only=True, slots=True, eq=False)
class Counted:
    """A right-hand side that counts its evaluations."""

    leg: Leg
    count: int = 0

    def __call__(self, t: float, y: Array) -> Array:
        """``y'``, and one evaluation more."""
        self.count += 1
        return self.leg.rate(t, y)

    def into(self, t: float, y: Array, out: Array) -> None:
        """The same, written into an array."""
        out[:] = self(t, y)


def stopping(leg: Leg, method: str, t: float, why: str) -> str:
    """The sentence about a run that an integrator cannot finish."""
    advice = 'method="exact" or "Radau"' if leg.equations.scheme.cells <= 1000 else 'method="Radau"'
    return f"until cannot be reached by {method}: at t = {t:g} s it stops ({why}); give another tolerance or {advice}"


def at_zero(y: Array) -> Array:
    """The state with ``z = 0`` exactly, as it is where contact begins or ends."""
    settled = np.array(y)
    settled[-1] = 0.0
    return settled


def stacked(parts: list[Array]) -> Array:
    """Observations one below the other."""
    return np.concatenate(parts) if parts else np.empty((0, 3))
