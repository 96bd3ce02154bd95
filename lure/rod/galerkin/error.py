"""Distance of Galerkin motions from a known one in H1 x L2, and the order at which it shrinks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lure.errors import InputError
from lure.expressions import Expression
from lure.rod.free_motion import FreeMotion
from lure.rod.galerkin.model import GalerkinModel
from lure.rod.galerkin.spaces import quadrature
from lure.rod.scenario import Scenario

if TYPE_CHECKING:
    import xarray

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class KnownState:
    """A state of the rod at one instant, to compare with.

    Attributes
    ----------
    slope, velocity : callable
        ``u_x`` [-] and ``u_t`` [m/s] at an array of places [m].
    end : float
        ``u(t, L)`` [m].
    kinks : tuple of float
        Places inside the rod where these jump or bend [m]; the quadrature is cut there.
    """

    slope: Callable[[Array], Array]
    velocity: Callable[[Array], Array]
    end: float
    kinks: tuple[float, ...] = ()


@dataclass(frozen=True, kw_only=True, slots=True)
class StateError:
    """Distance of a Galerkin state from a known one.

    Attributes
    ----------
    h1 : float
        ``(int (u_x - u_mx)^2 dx + (u - u_m)(L)^2/L)^(1/2)``, a norm equivalent to that of H1 [m^(1/2)].
    l2 : float
        ``(int (u_t - b.w)^2 dx)^(1/2)`` [m^(3/2)/s].
    """

    h1: float
    l2: float


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Convergence:
    """Errors of a family of Galerkin spaces at one instant.

    Observed orders are what these runs show, in the family they were taken from; they prove no rate.

    Attributes
    ----------
    widths : tuple of float
        ``h`` [m], decreasing.
    errors : tuple of StateError
        One for each.
    """

    widths: tuple[float, ...]
    errors: tuple[StateError, ...]

    @property
    def h1_orders(self) -> Array:
        """Observed orders in H1 between neighbours, ``ln(e_1/e_2)/ln(h_1/h_2)``."""
        return self._orders([error.h1 for error in self.errors])

    @property
    def l2_orders(self) -> Array:
        """Observed orders of the velocity in L2 between neighbours."""
        return self._orders([error.l2 for error in self.errors])

    def to_dict(self) -> dict[str, object]:
        """Widths, errors and observed orders as plain JSON data."""
        from lure.rod.galerkin.export import convergence_dict

        return convergence_dict(self)

    def to_xarray(self) -> xarray.Dataset:
        """The same as an ``xarray.Dataset`` along the width ``h`` [m]; orders against the next coarser space.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        from lure.rod.galerkin.export import convergence_dataset

        return convergence_dataset(self)

    def _repr_html_(self) -> str:
        from lure.rod.galerkin.export import convergence_html

        return convergence_html(self)

    def _orders(self, errors: list[float]) -> Array:
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.diff(np.log(errors)) / np.diff(np.log(self.widths)))


def state_error(model: GalerkinModel, a: Array, b: Array, known: KnownState) -> StateError:
    """Distance of the state ``(a, b)`` from a known one.

    Parameters
    ----------
    model : GalerkinModel
        The space.
    a, b : ndarray
        (m,) coefficients of displacement and velocity.
    known : KnownState
        What to compare with.
    """
    space = model.space
    rule = quadrature(space, (*model.rod.breakpoints, *known.kinks))
    strain = known.slope(rule.x) - space.slopes(rule.x) @ a
    velocity = known.velocity(rule.x) - space.values(rule.x) @ b
    end = known.end - float(space.right @ a)
    h1 = float(rule.w @ strain**2) + end**2 / space.length
    return StateError(h1=float(np.sqrt(h1)), l2=float(np.sqrt(rule.w @ velocity**2)))


def formula_state(motion: Expression, t: float, length: float) -> KnownState:
    """State of the motion ``u(t, x)`` given as a formula.

    Parameters
    ----------
    motion : Expression of t, x
        ``u`` [m], smooth in ``x`` at this instant.
    t : float
        The instant [s].
    length : float
        ``L`` [m].
    """
    slope, velocity = motion.derivative("x"), motion.derivative("t")
    return KnownState(
        slope=lambda x: slope(t=t, x=x), velocity=lambda x: velocity(t=t, x=x), end=float(motion(t=t, x=length))
    )


def free_state(motion: FreeMotion, t: float) -> KnownState:
    """State of the exact free motion of the uniform rod: ``u_x = (r2 - r1)/(2c)``, ``u_t = (r1 + r2)/2``.

    Parameters
    ----------
    motion : FreeMotion
        See :func:`lure.rod.free_motion.free_motion`.
    t : float
        The instant [s], at most ``until`` less one transit.
    """

    def slope(x: Array) -> Array:
        """``u_x = (r2 - r1)/(2 c)``."""
        forward, backward = motion.waves(t, x)
        return np.asarray((backward - forward) / (2.0 * motion.rod.wave_speed))

    L, c = motion.rod.length, motion.rod.wave_speed
    fold = (c * t) % L  # the waves of the ends at t = 0 have come to fold and to L - fold
    kinks = tuple(sorted({fold, L - fold})) if 0.0 < fold < L else ()
    return KnownState(
        slope=slope, velocity=lambda x: motion.velocity(t, x), end=float(motion.end_displacement(t)), kinks=kinks
    )


def convergence(
    models: Sequence[GalerkinModel], scenario: Scenario, known: KnownState, *, until: float, tolerance: float = 1e-11
) -> Convergence:
    """Errors at ``until`` of the same rod in finer and finer spaces.

    Parameters
    ----------
    models : sequence of GalerkinModel
        At least two, of one rod and kind of space, in order of dimension.
    scenario : Scenario
        Loads and initial data.
    known : KnownState
        The state of the rod at ``until``.
    until : float
        The instant [s].
    tolerance : float
        Of the time integration.

    Raises
    ------
    InputError
        There are fewer than two models, or their widths do not decrease.
    """
    widths = tuple(model.space.width for model in models)
    if len(widths) < 2 or any(fine >= coarse for coarse, fine in pairwise(widths)):
        raise InputError(f"models have the widths {widths} m; give at least two spaces, each finer than the one before")
    errors = []
    for model in models:
        run = model.simulate(scenario, until, samples=2, tolerance=tolerance)
        errors.append(state_error(model, run.coefficients[-1], run.velocities[-1], known))
    return Convergence(widths=widths, errors=tuple(errors))
