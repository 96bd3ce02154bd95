"""The closed loop as a nonlinear system of python-control."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from lure.arrays import Reals, np
from lure.errors import InputError
from lure.nonlinearities.base import Nonlinearity
from lure.plants.block import LinearBlock
from lure.plants.conversion import one_channel
from lure.plants.delay import DelayPlant
from lure.plants.rational import RationalPlant
from lure.plants.realisation import Names
from lure.plants.state_space import StateSpace

if TYPE_CHECKING:
    from collections.abc import Callable

    import control


@dataclass(frozen=True, eq=False, slots=True)
class _Realised:
    """``x' = A x + B mu``, ``sigma = C x + D mu``; ``dt = 0`` in continuous time, True where no period is stated."""

    A: Reals
    B: Reals
    C: Reals
    D: float
    dt: float | bool
    names: Names | None = None


def closed_loop(block: object, nonlinearity: Nonlinearity, *, pade: int | None = None) -> control.NonlinearIOSystem:
    """The loop with a load ``r``: ``mu = r - phi(sigma)``; see :meth:`lure.Loop.to_control`.

    Parameters
    ----------
    block : object
        The linear part; one that holds a ``LinearPlant`` as its ``block`` stands for that.
    nonlinearity : Nonlinearity
        What closes the loop.
    pade : int, optional
        Order of the approximation of a dead time.

    Raises
    ------
    InputError
        The block has no states, or its direct term ``D`` leaves ``sigma + D phi(sigma)`` without an inverse.
    """
    import control

    linear = _realised(block, pade)
    if linear.D:
        _demand_solvable(nonlinearity, linear.D)

    def force(x: Reals, r: Reals) -> tuple[float, float]:
        """``sigma`` and ``mu = r - phi(sigma)``, where ``sigma = C x + D mu``."""
        free = float(linear.C @ x) + linear.D * float(r[0])
        sigma = _solved(nonlinearity, linear.D, free) if linear.D else free
        return sigma, float(r[0]) - float(nonlinearity(sigma))

    def rate(_t: float, x: Reals, r: Reals, _params: dict[str, Any]) -> Reals:
        """``A x + B mu``: the derivative, or the next state."""
        return np.asarray(linear.A @ x + linear.B * force(x, r)[1])

    def output(_t: float, x: Reals, r: Reals, _params: dict[str, Any]) -> Reals:
        """``sigma``."""
        return np.array([force(x, r)[0]])

    make: Callable[..., control.NonlinearIOSystem] = control.nlsys
    states = len(linear.B) if linear.names is None else list(linear.names.states)
    return make(rate, output, inputs=["r"], outputs=["sigma"], states=states, dt=linear.dt, name="lure")


def _realised(block: object, pade: int | None) -> _Realised:
    block = getattr(block, "block", block)
    if isinstance(block, LinearBlock):
        return _Realised(block.dense(), block.b1, block.c, 0.0, 0.0)
    if isinstance(block, DelayPlant):
        block = one_channel(block.to_control(pade=pade))
    if isinstance(block, StateSpace):
        return _Realised(block.A, block.B, block.C, block.D, block.period, block.names)
    if not isinstance(block, RationalPlant) or block.order == 0:
        raise InputError(
            f"a {type(block).__name__} without states cannot be simulated; give coefficients of order 1 or more, "
            "matrices or a formula in s or z"
        )
    equations = block.realisation
    return _Realised(*equations.doubles(), block.period, equations.names)


def _demand_solvable(nonlinearity: Nonlinearity, direct: float) -> None:
    """Refuse a direct term with which the loop need not define ``sigma``."""
    bounds = getattr(nonlinearity, "slope_bounds", None)
    ends = () if bounds is None else (bounds.lower, bounds.upper)
    if not ends or not all(math.isfinite(end) and 1 + direct * end > 0 for end in ends):
        known = "unknown" if bounds is None else str(bounds)
        raise InputError(
            f"the block has the direct term D = {direct:g}: the loop is only sure to define sigma where 1 + D k > 0 "
            f"for every slope k of phi, and these are {known}; give a nonlinearity whose slopes allow it"
        )


def _solved(nonlinearity: Nonlinearity, direct: float, free: float) -> float:
    """The one ``sigma`` with ``sigma + D phi(sigma) = free``: the sector says between which two numbers it lies."""
    from scipy.optimize import brentq

    slopes = nonlinearity.slope_bounds  # type: ignore[attr-defined]  # _demand_solvable has seen them
    ends = sorted(free / (1.0 + direct * float(end)) for end in (slopes.lower, slopes.upper))
    low, high = ends[0] - 1e-12 * abs(ends[0]), ends[1] + 1e-12 * abs(ends[1])
    if low == high:
        return low
    return float(
        brentq(lambda sigma: sigma + direct * float(nonlinearity(sigma)) - free, low, high, xtol=1e-300, rtol=1e-14)
    )
