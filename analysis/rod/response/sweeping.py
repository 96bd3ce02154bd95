"""A parameter varied: what is asked for, and what was seen."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from lure.analysis.rod.response.model import plain
from lure.analysis.rod.response.plan import Plan
from lure.analysis.rod.response.recording import Array, Progress
from lure.analysis.verdict import Evidence
from lure.errors import InputError
from lure.record import by_value
from lure.rod.scenario import Scenario

if TYPE_CHECKING:
    import xarray

    from lure.analysis.plots.style import Axes

Order = Literal["separate", "up", "down"]
ORDERS: tuple[Order, ...] = ("separate", "up", "down")


@dataclass(frozen=True, kw_only=True, slots=True)
class Sweep:
    """How a parameter is varied.

    Attributes
    ----------
    plan : Plan
        How long to wait and to watch at each value; ``separation`` is not used.
    order : {"separate", "up", "down"}
        ``separate``: each value starts from the same initial data.  ``up``, ``down``: one motion, in which the force
        goes through the values in ascending or descending order, so that each value starts from where the one before
        has ended; up and down may differ (hysteresis).  The rod cannot change in the middle of its motion: only symbols
        of the force can be swept.
    start : Scenario
        Initial data and body force.
    workers : int
        Processes that share the values of a separate sweep; the result does not depend on it.  A script that asks for
        more than one needs the usual ``if __name__ == "__main__":``.
    progress : callable or None
        Called as ``progress(text, share)``.
    """

    plan: Plan = field(default_factory=Plan)
    order: Order = "separate"
    start: Scenario = field(default_factory=Scenario)
    workers: int = 1
    progress: Progress | None = None

    def __post_init__(self) -> None:
        if self.order not in ORDERS:
            raise InputError(f"order is {self.order!r}; give one of {', '.join(ORDERS)}")
        if isinstance(self.workers, bool) or not isinstance(self.workers, int) or not 1 <= self.workers <= 64:
            raise InputError(f"workers is {self.workers!r}; give a whole number from 1 to 64")

    def _repr_html_(self) -> str:
        from lure.analysis.rod.response.export import sweep_html

        return sweep_html(self)


@by_value
@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Point:
    """What was seen at one value.

    Attributes
    ----------
    value : float
        Of the parameter.
    poincare : ndarray
        (R+1, 2) points ``(z, z')`` at whole periods of the force [m, m/s]; (0, 2) if the motion could not be followed.
    regime, multiple, trend : str, int or None, str
        As in :class:`Regime` and :class:`Transients`.
    duty, impacts, peak_stress : float
        Share of time in contact [-], impacts per period [-], largest stress [Pa].
    problem : str
        Why the motion could not be followed, or nothing.
    """

    value: float
    poincare: Array
    regime: str = "not followed"
    multiple: int | None = None
    trend: str = ""
    duty: float = np.nan
    impacts: float = np.nan
    peak_stress: float = np.nan
    problem: str = ""


@by_value
@dataclass(frozen=True, kw_only=True, eq=False)
class Bifurcation:
    """Stroboscopic points against a parameter; make one with :func:`bifurcation`.

    Attributes
    ----------
    parameter : str
        Its name.
    force : str
        Formula of ``g``, with the symbol.
    values : tuple of float
        Values asked for, in the order in which they were taken.
    points : tuple of Point
        What was seen at those that were done, in that order.
    order : {"separate", "up", "down"}
        How each value started.
    complete : bool
        Whether all values were done; if not, it was interrupted.
    """

    parameter: str
    force: str
    values: tuple[float, ...]
    points: tuple[Point, ...]
    order: Order
    complete: bool

    @property
    def evidence(self) -> Evidence:
        """OBSERVED: one motion at each value, for a finite time."""
        return Evidence.OBSERVED

    def scatter(self) -> tuple[Array, Array]:
        """All points: values of the parameter (n,) and ``z`` at whole periods (n,) [m]."""
        if not self.points:
            return np.empty(0), np.empty(0)
        values = [np.full(len(point.poincare), point.value) for point in self.points]
        return np.concatenate(values), np.concatenate([point.poincare[:, 0] for point in self.points])

    def __str__(self) -> str:
        counted: dict[str, int] = {}
        for point in self.points:
            name = f"repeats after {point.multiple}" if point.regime == "periodic" else point.regime
            counted[name] = counted.get(name, 0) + 1
        seen = ", ".join(f"{name}: {count}" for name, count in counted.items()) or "nothing"
        starts = {
            "separate": "Each value starts from the same initial data.",
            "up": "One motion, the values in ascending order, each from the end of the one before.",
            "down": "One motion, the values in descending order, each from the end of the one before.",
        }[self.order]
        done = "All" if self.complete else "Interrupted: only"
        waiting = sum(point.trend in ("still approaching", "still changing") for point in self.points)
        late = f"  At {waiting} of them transients were not over." if waiting else ""
        return (
            f"g = {self.force}, {self.parameter} varied.  {done} {len(self.points)} of {len(self.values)} values done."
            f"  {starts}\nSeen: {seen}.{late}\nEvidence: {self.evidence}; of the rod itself, at these values and from "
            "these starts only."
        )

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "parameter": self.parameter,
            "force": self.force,
            "order": self.order,
            "complete": self.complete,
            "values": list(self.values),
            "points": [
                {
                    "value": point.value,
                    "regime": point.regime,
                    "multiple": point.multiple,
                    "transients": point.trend,
                    "contact_duty": plain(point.duty),
                    "impacts_per_period": plain(point.impacts),
                    "peak_stress_Pa": plain(point.peak_stress),
                    "problem": point.problem,
                    "poincare": point.poincare.tolist(),
                }
                for point in self.points
            ],
            "evidence": str(self.evidence),
        }

    def to_xarray(self) -> xarray.Dataset:
        """What was seen at each value as an ``xarray.Dataset``, along ``value`` and ``period``, with units.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        from lure.analysis.rod.response.export import bifurcation_dataset

        return bifurcation_dataset(self)

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Stroboscopic points against the parameter; see :func:`lure.analysis.plots.plot_bifurcation`.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        from lure.analysis.plots.rod_response import plot_bifurcation

        return plot_bifurcation(self, ax=ax)

    def _repr_html_(self) -> str:
        from lure.analysis.rod.response.export import bifurcation_html

        return bifurcation_html(self)
