"""Resting places of the rod without a load over a grid of initial data."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.response.recording import Array, Progress
from lure.analysis.rod.response.resting import resting_place
from lure.analysis.rod.response.varying import checked_values
from lure.analysis.verdict import Evidence
from lure.errors import InputError
from lure.expressions import Expression
from lure.record import Page, Record, derived, quantity
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

if TYPE_CHECKING:
    from lure.analysis.plots.style import Axes

_GRID = "velocity offset"


class Basin(Record):
    """Resting places against the initial data; make one with :func:`basin`."""

    offsets: tuple[float, ...] = quantity(
        "uniform displacements added to the initial data", "m", dims="offset", name="offset", key="offsets_m"
    )
    velocities: tuple[float, ...] = quantity(
        "uniform velocities added to the initial data",
        "m s-1",
        dims="velocity",
        name="velocity",
        key="velocities_m_per_s",
    )
    low: Array = quantity(
        "lower bound of the resting place ``z``; nan where nothing was computed",
        "m",
        dims=_GRID,
        name="rest_low",
        key="rest_low_m",
    )
    high: Array = quantity(
        "upper bound of the resting place ``z``; nan where nothing was computed",
        "m",
        dims=_GRID,
        name="rest_high",
        key="rest_high_m",
    )
    impacts: NDArray[np.int64] = quantity(
        "number of impacts; -1 where nothing was computed", "1", dims=_GRID, key="impacts"
    )
    settled: NDArray[np.bool_] = quantity("whether it is shown that no contact follows", "1", dims=_GRID, key="settled")
    known: NDArray[np.bool_] = quantity(
        "whether the bounds agree to 1e-9 of the largest ``|z|`` of the motion", "1", dims=_GRID, key="known"
    )
    complete: bool = quantity("Whether all of the grid was done")

    @property
    @derived()
    def evidence(self) -> Evidence:
        """COMPUTED: each motion is followed until what is left of it is known in closed form."""
        return Evidence.COMPUTED

    def __str__(self) -> str:
        done = self.impacts >= 0
        count, known = int(done.sum()), int(self.known.sum())
        part = "" if self.complete else f"Interrupted: {count} of {done.size} motions done.  "
        if not count:
            return f"{part}Nothing is known."
        untouched = int((self.settled & (self.impacts == 0)).sum())
        open_ = f"  {count - known} are INCONCLUSIVE: bounds are given." if known < count else ""
        return (
            f"{part}{known} of {count} resting places are known, {int(self.settled.sum())} of them with no contact to "
            f"come, {untouched} without any.{open_}\nThey lie at z = {np.nanmin(self.low):.6g} m to "
            f"{np.nanmax(self.high):.6g} m, after up to {int(self.impacts.max())} impacts.\nEvidence: {self.evidence}; "
            "of the rod itself, from these initial data only."
        )

    def _attributes(self) -> dict[str, object]:
        comment = "Resting places of the rod itself from these initial data; nothing is said between them."
        return {"subject": "rod", **super()._attributes(), "comment": comment, "complete": int(self.complete)}

    def _page(self) -> Page:
        done = self.impacts >= 0
        rows: list[tuple[str, object]] = [
            ("what moved", "the rod itself"),
            ("initial data", f"{len(self.offsets)} displacements, {len(self.velocities)} velocities"),
            ("motions followed", f"{int(done.sum())} of {done.size}"),
            ("resting places known", int(self.known.sum())),
            ("no contact to come", int(self.settled.sum())),
        ]
        if done.any():
            rows.append(("resting places", f"z = {np.nanmin(self.low):.6g} m to {np.nanmax(self.high):.6g} m"))
            rows.append(("impacts", f"up to {int(self.impacts.max())}"))
        notes = ("Of the rod itself, from these initial data only.",)
        return Page("resting places of the rod", rows, verdict="COMPUTED", notes=notes)

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Resting places over the initial data; see :func:`lure.analysis.rod.plots.plot_basin`.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        from lure.analysis.rod.plots.response import plot_basin

        return plot_basin(self, ax=ax)


def basin(
    rod: Rod,
    offsets: Sequence[float],
    velocities: Sequence[float],
    *,
    start: Scenario | None = None,
    progress: Progress | None = None,
) -> Basin:
    """Resting places of the rod without loads, over a grid of initial data.

    Parameters
    ----------
    rod : Rod
        The rod, ``k > 0``.
    offsets, velocities : sequence of float
        Uniform displacements [m] and velocities [m/s], added to the initial data.
    start : Scenario, optional
        Initial data, without loads; by default the rod at rest and unstressed at ``u = 0``.
    progress : callable, optional
        Called as ``progress(text, share)``.

    Returns
    -------
    Basin
        Evidence: COMPUTED.  ``KeyboardInterrupt`` ends it with what is done.

    Raises
    ------
    AssumptionError
        There is a load, or ``k <= 0``.
    InputError
        A value is not a finite number, or there is none.

    Examples
    --------
    A rod thrown at an obstacle 1 m away; momentum decides how far it comes back.

    >>> from lure.rod import Rod
    >>> rod = Rod(youngs_modulus=1, density=1, length=1, area=1, damping=0.5, compliance=0.01, gap=1)
    >>> found = basin(rod, [0.0], [0.25, 1.0])
    >>> found.impacts.tolist(), found.high.round(6).tolist()
    ([[0], [1]], [[-0.5], [-0.332558]])
    """
    scenario = start or Scenario()
    columns, rows = checked_values(offsets), checked_values(velocities)
    if not columns or not rows:
        raise InputError("basin has no offsets or no velocities; give one of each at least")
    shape = (len(rows), len(columns))
    low, high = np.full(shape, np.nan), np.full(shape, np.nan)
    impacts, settled, known = np.full(shape, -1), np.zeros(shape, dtype=bool), np.zeros(shape, dtype=bool)
    complete = True
    try:
        for i, j in np.ndindex(shape):
            if progress is not None:
                share = (i * len(columns) + j) / (len(rows) * len(columns))
                progress(f"from {columns[j]:.4g} m, {rows[i]:.4g} m/s", share)
            found = resting_place(rod, _shifted(scenario, columns[j], rows[i]))
            low[i, j], high[i, j] = found.low, found.high
            impacts[i, j], settled[i, j], known[i, j] = found.impacts, found.settled, found.known
    except KeyboardInterrupt:
        complete = False
    return Basin(
        offsets=columns,
        velocities=rows,
        low=low,
        high=high,
        impacts=impacts,
        settled=settled,
        known=known,
        complete=complete,
    )


def _shifted(scenario: Scenario, offset: float, velocity: float) -> Scenario:
    return Scenario(
        force=scenario.force,
        body_force=scenario.body_force,
        displacement=_plus(scenario.displacement, offset, "initial.u0"),
        velocity=_plus(scenario.velocity, velocity, "initial.u1"),
    )


def _plus(formula: Expression, number: float, field: str) -> Expression:
    return Expression.parse(f"({formula}) + ({number!r})", variables=("x",), field=field)
