"""Distance of Galerkin motions from a known one in H1 x L2, and the order at which it shrinks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from lure.arrays import Reals as Array
from lure.errors import InputError
from lure.expressions import Expression
from lure.record import Column, Page, Record, derived, described, quantity
from lure.rod.galerkin.model import GalerkinModel
from lure.rod.galerkin.spaces import quadrature
from lure.rod.motion import Motion
from lure.rod.scenario import Scenario


@described(frozen=True, kw_only=True, slots=True, eq=False)
class KnownState:
    """A state of the rod at one instant, to compare with."""

    slope: Callable[[Array], Array] = quantity("``u_x`` [-] at an array of places [m]")
    velocity: Callable[[Array], Array] = quantity("``u_t`` [m/s] at an array of places [m]")
    end: float = quantity("``u(t, L)``", "m")
    kinks: tuple[float, ...] = quantity(
        "Places inside the rod where these jump or bend [m]; the quadrature is cut there", default=()
    )


class StateError(Record):
    """Distance of a Galerkin state from a known one."""

    h1: float = quantity(
        "error of the displacement, ``(int (u_x - u_mx)^2 dx + (u - u_m)(L)^2/L)^(1/2)``, a norm equivalent to that of "
        "H1",
        "m0.5",
        dims="",
        name="h1_error",
    )
    l2: float = quantity(
        "error of the velocity in L2, ``(int (u_t - b.w)^2 dx)^(1/2)``", "m1.5 s-1", dims="", name="l2_error"
    )


class Convergence(Record):
    """Errors of a family of Galerkin spaces at one instant.

    Observed orders are what these runs show, in the family they were taken from; they prove no rate.
    """

    widths: tuple[float, ...] = quantity(
        "element length ``h``, decreasing", "m", dims="width", name="width", key="widths"
    )
    errors: tuple[StateError, ...] = quantity("One for each", dims="width", each=StateError, key="")

    @property
    @derived()
    def evidence(self) -> str:
        """Observed."""
        return "observed"

    @property
    @derived()
    def comment(self) -> str:
        """What they do not show."""
        return "Observed orders are what these runs show, in the family they were taken from; they prove no rate."

    @property
    @derived()
    def h1_errors(self) -> list[float]:
        """Errors in H1 [m^(1/2)]."""
        return [error.h1 for error in self.errors]

    @property
    @derived()
    def l2_errors(self) -> list[float]:
        """Errors of the velocity in L2 [m^(3/2)/s]."""
        return [error.l2 for error in self.errors]

    @property
    @derived()
    def h1_orders(self) -> Array:
        """Observed orders in H1 between neighbours, ``ln(e_1/e_2)/ln(h_1/h_2)``."""
        return self._orders(self.h1_errors)

    @property
    @derived()
    def l2_orders(self) -> Array:
        """Observed orders of the velocity in L2 between neighbours."""
        return self._orders(self.l2_errors)

    def _columns(self) -> dict[str, Column]:
        """Along the width; orders against the next coarser space."""
        text = "observed order in {} against the next coarser space"
        return super()._columns() | {
            "h1_order": Column(("width",), np.append(np.nan, self.h1_orders), "1", text.format("H1")),
            "l2_order": Column(("width",), np.append(np.nan, self.l2_orders), "1", text.format("L2")),
        }

    def _page(self) -> Page:
        orders = (
            ["", *(f"{order:.3f}" for order in self.h1_orders)],
            ["", *(f"{order:.3f}" for order in self.l2_orders)],
        )
        numbers = zip(self.widths, self.h1_errors, orders[0], self.l2_errors, orders[1], strict=True)
        rows = [(f"{width:.4g}", f"{h1:.3g}", before, f"{l2:.3g}", after) for width, h1, before, l2, after in numbers]
        head = ("h [m]", "H1 error [m^0.5]", "order", "L2 error of the velocity [m^1.5/s]", "order")
        return Page("errors of Galerkin spaces", rows, head, "OBSERVED", (self.comment,))

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


def exact_state(motion: Motion, t: float) -> KnownState:
    """State of the uniform rod itself: its strain and velocity, between the places at which its waves have kinks.

    Parameters
    ----------
    motion : Motion
        See :func:`lure.rod.exact_motion`.
    t : float
        The instant [s].

    Raises
    ------
    InputError
        The motion was not kept, or not followed, at that instant.
    """
    kinks = motion.fields.breaks(t / motion.rod.travel_time)[1:-1]
    return KnownState(
        slope=lambda x: motion.strain(t, x),
        velocity=lambda x: motion.velocity(t, x),
        end=float(motion.end_displacement(t)),
        kinks=tuple(kinks.tolist()),
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
