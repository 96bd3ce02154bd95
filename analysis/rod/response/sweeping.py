"""A parameter varied: what is asked for, and what was seen."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal

import numpy as np

from lure.analysis.rod.response.plan import Plan
from lure.analysis.rod.response.recording import Array, Progress
from lure.analysis.verdict import Evidence
from lure.errors import InputError
from lure.record import Column, Page, Record, derived, numbered, quantity
from lure.rod import datasets
from lure.rod.scenario import Scenario

if TYPE_CHECKING:
    from lure.analysis.plots.style import Axes

_LISTED = 40
Order = Literal["separate", "up", "down"]
ORDERS: tuple[Order, ...] = ("separate", "up", "down")


class Sweep(Record):
    """How a parameter is varied."""

    plan: Plan = quantity(
        "How long to wait and to watch at each value; ``separation`` is not used", default_factory=Plan
    )
    order: Order = quantity(
        "``separate``: each value starts from the same initial data. ``up``, ``down``: one motion, in which the "
        "force goes through the values in ascending or descending order, so that each value starts from where the "
        "one before has ended; up and down may differ (hysteresis). The rod cannot change in the middle of its "
        "motion: only symbols of the force can be swept",
        default="separate",
    )
    start: Scenario = quantity("Initial data and body force", default_factory=Scenario)
    workers: int = quantity(
        "Processes that share the values of a separate sweep; the result does not depend on it. A script that "
        'asks for more than one needs the usual ``if __name__ == "__main__":``',
        default=1,
    )
    progress: Progress | None = quantity("Called as ``progress(text, share)``", default=None)

    def __post_init__(self) -> None:
        if self.order not in ORDERS:
            raise InputError(f"order is {self.order!r}; give one of {', '.join(ORDERS)}")
        if isinstance(self.workers, bool) or not isinstance(self.workers, int) or not 1 <= self.workers <= 64:
            raise InputError(f"workers is {self.workers!r}; give a whole number from 1 to 64")

    def _page(self) -> Page:
        rows = [("order", self.order), ("plan", self.plan), ("processes", self.workers)]
        return Page("how a parameter is varied", rows, notes=("A request: nothing was computed yet.",))


class Point(Record):
    """What was seen at one value."""

    value: float = quantity("value of the parameter")
    poincare: Array = quantity(
        "(R+1, 2) points ``(z, z')`` at whole periods of the force [m, m/s]; (0, 2) if the motion could not be followed"
    )
    regime: str = quantity("kind of motion seen, as in :class:`Regime`", "1", dims="", default="not followed")
    multiple: int | None = quantity(
        "periods of the force in a repetition; nan if none was seen", "1", dims="", default=None
    )
    trend: str = quantity(
        "whether it was still changing, as in :class:`Transients`",
        "1",
        dims="",
        key="transients",
        name="transients",
        default="",
    )
    duty: float = quantity("share of time in contact", "1", dims="", key="contact_duty", default=math.nan)
    impacts: float = quantity(
        "impacts that begin, per period of the force", "1", dims="", key="impacts_per_period", default=math.nan
    )
    peak_stress: float = quantity(
        "largest stress of these impacts", "Pa", dims="", key="peak_stress_Pa", default=math.nan
    )
    problem: str = quantity("why the motion could not be followed, or nothing", "1", dims="", default="")


class Bifurcation(Record):
    """Stroboscopic points against a parameter; make one with :func:`bifurcation`."""

    parameter: str = quantity("Its name")
    force: str = quantity("Formula of ``g``, with the symbol")
    values: tuple[float, ...] = quantity("Values asked for, in the order in which they were taken")
    points: tuple[Point, ...] = quantity(
        "What was seen at those that were done, in that order", dims="value", each=Point
    )
    order: Order = quantity("How each value started")
    complete: bool = quantity("Whether all values were done; if not, it was interrupted")

    @property
    @derived()
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

    def _columns(self) -> dict[str, Column]:
        points = self.points
        strobe = np.full((len(points), max((len(point.poincare) for point in points), default=0), 2), np.nan)
        for i, point in enumerate(points):
            strobe[i, : len(point.poincare)] = point.poincare
        both, text = ("value", "period"), "at whole periods of the force; nan beyond the last"
        unit = datasets.UNITS.get(self.parameter, "unit of the symbol in the force")
        return super()._columns() | {
            "value": Column(("value",), [point.value for point in points], unit, f"parameter {self.parameter}"),
            "period": numbered("period", strobe.shape[1], "number of the stroboscopic point"),
            "poincare_z": Column(both, strobe[:, :, 0], "m", f"z {text}"),
            "poincare_v": Column(both, strobe[:, :, 1], "m s-1", f"z' {text}"),
        }

    def _attributes(self) -> dict[str, object]:
        return {
            "subject": "rod",
            "evidence": str(self.evidence),
            "comment": "At each value one motion of the rod itself from one start; nothing is said between the values.",
            "parameter": self.parameter,
            "force_g": self.force,
            "order": self.order,
            "complete": int(self.complete),
        }

    def _page(self) -> Page:
        points = self.points
        step = max(1, -(-len(points) // _LISTED))
        rows = [
            (
                f"{point.value:.6g}",
                point.problem or point.regime,
                "-" if point.multiple is None else point.multiple,
                f"{100 * point.duty:.3g} %",
                f"{point.impacts:.3g}",
                f"{point.peak_stress:.4g}" if point.impacts > 0 else "-",
            )
            for point in points[::step]
        ]
        head = (self.parameter, "seen", "repeats after", "in contact", "impacts a period", "peak stress of these [Pa]")
        notes = [] if step == 1 else [f"Shown is one value in {step}."]
        title = f"response of the rod itself against {self.parameter}, g = {self.force}"
        return Page(title, rows, head, "OBSERVED", (*notes, *str(self).split("\n")))

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Stroboscopic points against the parameter; see :func:`lure.analysis.rod.plots.plot_bifurcation`.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        from lure.analysis.rod.plots.response import plot_bifurcation

        return plot_bifurcation(self, ax=ax)
