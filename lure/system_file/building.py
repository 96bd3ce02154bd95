"""From checked tables to a :class:`lure.systems.RodSystem`, with the checks that concern several tables at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.errors import InputError
from lure.rod import Rod
from lure.scenario import Scenario
from lure.system_file.schema import SystemTables
from lure.systems import RodSystem, rod_from_exact

ROUND_TRIPS = 10
_SAMPLES = 1000


def built_system(tables: SystemTables, *, title: str, source: str) -> RodSystem:
    """The system of a file; without ``simulation.until`` it is simulated for ten round trips of a wave, ``20 L/c``.

    Raises
    ------
    InputError
        The rod refuses its parameters, or a load or an initial value is not finite at one of the sampled points.
    """
    rod = rod_from_exact({key: getattr(tables.rod, key) for key in type(tables.rod).model_fields})
    scenario = Scenario(
        force=tables.force.g,
        body_force=tables.force.f,
        displacement=tables.initial.u0,
        velocity=tables.initial.u1,
    )
    simulation = tables.simulation
    until = 2.0 * ROUND_TRIPS * rod.travel_time if simulation.until is None else float(simulation.until)
    _check_finite(rod, scenario, cells=tables.discretisation.cells, until=until)
    return RodSystem(
        name=tables.name or "rod",
        title=title,
        rod=rod,
        scenario=scenario,
        cells=tables.discretisation.cells,
        form=tables.discretisation.form,
        until=until,
        simulation_cells=simulation.cells,
        source=source,
    )


def _check_finite(rod: Rod, scenario: Scenario, *, cells: int, until: float) -> None:
    """Refuse formulas such as ``1/x`` that a sample shows to be undefined somewhere; a sample proves nothing."""
    count = min(cells, _SAMPLES)
    x = rod.length * np.arange(count + 1) / count
    t = until * np.arange(_SAMPLES + 1) / _SAMPLES
    _refuse_infinite("initial.u0", scenario.displacement(x=x), "x", x)
    _refuse_infinite("the derivative of initial.u0", scenario.slope(x=x), "x", x)
    _refuse_infinite("initial.u1", scenario.velocity(x=x), "x", x)
    _refuse_infinite("force.g", scenario.force(t=t), "t", t)
    few_x, few_t = x[:: max(1, count // 30)], t[::30]
    _refuse_infinite("force.f", scenario.body_force(t=few_t[:, None], x=few_x), "t", few_t)


def _refuse_infinite(name: str, values: ArrayLike, variable: str, points: NDArray[np.float64]) -> None:
    array = np.atleast_1d(np.asarray(values))
    finite = np.isfinite(array.reshape(len(array), -1)).all(axis=1)
    if not finite.all():
        where = points[int(np.argmin(finite))] if len(array) > 1 else points[0]
        raise InputError(f"{name} is not a finite number at {variable} = {where:.6g}; change the formula")
