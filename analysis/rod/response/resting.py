r"""Where the rod comes to rest without a load, against how it starts.

Its equilibria are a half-line: at rest anywhere short of the obstacle.  Which of them is taken is decided by

.. math:: \zeta(t) = z(t) - \frac{a}{1 + a} \int_{t - 2T}^{t} V, \qquad V = r_2(\cdot, L), \qquad
    \zeta' = -\frac{A}{k}\,p(z) \le 0,

which free flight keeps: after the last contact the rod comes to rest at ``z = zeta``.  In free flight ``z - zeta`` is
multiplied by ``-a`` in every round trip, so that two round trips in succession without contact and ``zeta <= 0`` mean
that there is none later.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lure.analysis.drawing import drawn
from lure.analysis.rod.response.recording import MOST_TRIPS, Progress, contact_time, wave_rate
from lure.analysis.rod.response.sweeping import checked_values
from lure.analysis.verdict import Evidence
from lure.arrays import Reals as Array
from lure.errors import AssumptionError, InputError, Reason
from lure.expressions import Expression
from lure.record import Page, Record, derived, quantity
from lure.rod.motion import Boundary, Window, motion_windows
from lure.rod.motion.pieces import basis
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

# Resting places of the rod without a load over a grid of initial data.

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
        ends = float(np.nanmin(self.low)), float(np.nanmax(self.high))
        low, high = (0.0 if abs(end) < 1e-12 * max(map(abs, ends)) else end for end in ends)  # 0 but for rounding
        most = int(self.impacts.max())
        after = f"after up to {most} impact{'s' * (most > 1)}" if most else "without an impact"
        return (
            f"{part}{known} of {count} resting places are known, {int(self.settled.sum())} of them with no contact to "
            f"come, {untouched} without any.{open_}\nThey lie at z = {low:.6g} m to {high:.6g} m, {after}.\n"
            f"Evidence: {self.evidence}; of the rod itself, from these initial data only."
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

    plot = drawn("Resting places over the initial data; see :func:`lure.analysis.rod.plots.plot_basin`.")


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
    return replace(
        scenario,
        displacement=_plus(scenario.displacement, offset, "initial.u0"),
        velocity=_plus(scenario.velocity, velocity, "initial.u1"),
    )


def _plus(formula: Expression, number: float, field: str) -> Expression:
    return Expression.parse(f"({formula}) + ({number!r})", variables=("x",), field=field)


_TIME_CONSTANTS = 60.0
_FEWEST_TRIPS = 100
_QUIET = 2
_KNOWN = 1e-9


class Rest(Record):
    """Where one motion ends."""

    low: float = quantity("Lower bound of the resting place ``z``", "m")
    high: float = quantity("Upper bound; equal to the lower, to rounding, if no contact follows", "m")
    impacts: int = quantity("Contacts that ended before the motion was left")
    settled: bool = quantity(
        "Whether no contact follows: in two round trips in succession there was none, and ``zeta <= 0``"
    )
    known: bool = quantity(
        "Whether the bounds agree to 1e-9 of the largest ``|z|`` met, whether or not contact follows: a rod may "
        "creep out of the obstacle for ever"
    )
    time: float = quantity("When the motion was left", "s")

    def __str__(self) -> str:
        if self.settled:
            return f"Comes to rest at z = {self.high:.9g} m after {self.impacts} impacts; it does not touch again."
        if self.known:
            return f"Comes to rest at z = {self.high:.9g} m after {self.impacts} impacts; contact may go on till then."
        return (
            f"INCONCLUSIVE: after {self.time:.4g} s and {self.impacts} impacts contact may follow; it comes to rest "
            f"between z = {self.low:.6g} m and {self.high:.6g} m."
        )


def resting_place(rod: Rod, scenario: Scenario, *, rigid: bool = False, until: float | None = None) -> Rest:
    r"""Where the rod comes to rest without a load.

    Parameters
    ----------
    rod : Rod
        The rod, ``k > 0``.
    scenario : Scenario
        Initial data; no loads.
    rigid : bool
        Whether the obstacle is rigid.
    until : float, optional
        Longest time that is followed [s]; by default 60 time constants of the rod, between 100 and 200 000 round
        trips.

    Returns
    -------
    Rest
        ``zeta`` if no contact follows.  Otherwise bounds: ``zeta`` never increases, the resting place is at most 0, and
        after the last release, where ``z = 0``,

        .. math:: \zeta = -\frac{a}{1+a} \int V \ge -\frac{1}{1 + a} \sqrt{8\,T E / Z}, \qquad E' \le 0.

    Raises
    ------
    AssumptionError
        There is a load, or ``k <= 0``: without loss the rod does not come to rest; or the first round trip cannot be
        followed.  Where a later one cannot, the bounds are those before it.
    """
    if not scenario.free:
        raise AssumptionError("a rod under a load does not come to rest; give g = 0 and f = 0, or ask for its response")
    if not rod.damping > 0:
        raise AssumptionError(
            f"the rod comes to rest for k > 0 only; the damping is {rod.damping:g} N s/m", code=Reason.UNDAMPED
        )
    boundary = Boundary(rigid=rigid)
    T = rod.travel_time
    if until is None:
        slow = max(1.0 / wave_rate(rod, boundary), contact_time(rod, boundary) or 0.0)
        until = 2.0 * T * min(max(_TIME_CONSTANTS * slow / (2.0 * T), _FEWEST_TRIPS), MOST_TRIPS)
    until = 2.0 * T * max(math.floor(until / (2.0 * T)), 1)
    one_plus_a = 2.0 * rod.damping * rod.input_gain
    impacts, quiet, scale = 0, 0, abs(scenario.contact_coordinate(rod))
    found = Rest(low=-math.inf, high=0.0, impacts=0, settled=False, known=False, time=0.0)
    try:
        for window in motion_windows(rod, scenario, until, boundary=boundary):
            impacts += len(window.impacts)
            end = float(window.z[-1].sum())
            scale = max(scale, abs(end))
            travelled, squares = _integrals(window)
            zeta = end - rod.reflection / one_plus_a * T * travelled
            quiet = quiet + 1 if not window.push.any() and window.end.impact is None else 0
            settled = quiet >= _QUIET and zeta <= 0.0
            pressed = 0.0 if rigid else rod.area * float(rod.nonlinearity.primitive(np.array(end)))
            energy = 0.25 * rod.impedance * T * squares + pressed
            reach = math.sqrt(8.0 * T * energy / rod.impedance) / one_plus_a
            high = min(zeta, 0.0)
            low = high if settled else min(high, -reach)
            known = high - low <= _KNOWN * scale
            time = 2.0 * T * (window.number + 1)
            found = Rest(low=low, high=high, impacts=impacts, settled=settled, known=known, time=time)
            if settled or (known and window.end.impact is not None):
                break
    except AssumptionError as error:
        if found.time == 0.0:
            raise error from None
    return found


def _integrals(window: Window) -> tuple[float, float]:
    """``int V dt`` and ``int V^2 dt`` over a window, in transits."""
    space = basis(window.returned.shape[1] - 1)
    share, wave = 0.5 * np.diff(window.edges)[:, None] * space.weights, window.returned @ space.at_gauss.T
    return float((share * wave).sum()), float((share * wave**2).sum())
