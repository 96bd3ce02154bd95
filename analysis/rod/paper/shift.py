"""The rod itself with contact: waves shifted by whole cells (Courant number one), the contact solved in each cell."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lure.errors import AssumptionError
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

CELLS_PER_TRANSIT = 4


@dataclass(frozen=True, kw_only=True, eq=False)
class RodRun:
    """A motion of the rod itself.

    Attributes
    ----------
    t, z : ndarray
        (n,) times [s] and contact coordinate ``u(t, L) - gap`` [m] there.
    contacts : tuple of (float, float)
        Intervals with ``z > 0`` [s]; one still open at the end is closed there.
    largest_z : float
        Largest ``z`` [m].
    error : float
        Largest change of ``z`` at common times when the step is halved [m].
    """

    t: NDArray[np.float64]
    z: NDArray[np.float64]
    contacts: tuple[tuple[float, float], ...]
    largest_z: float
    error: float


def rod_run(rod: Rod, scenario: Scenario, until: float, *, cells: int = CELLS_PER_TRANSIT) -> RodRun:
    r"""Motion of the rod with contact, from its delay equation.

    .. math:: W(t) = -a\,V(t - 2T) + 2 b\,g(t - T), \quad z' = W - d\,p(z), \quad V = W - 2 d\,p(z) = 2 z' - W.

    Waves are constant on cells of length ``T/cells`` and move by whole cells, which is exact: no numerical damping.  In
    each cell ``z`` is solved exactly for that ``W`` (linear law), and ``V`` takes the mean of ``2 z' - W``.  The only
    errors are those of replacing ``g``, ``u1 -+ c u0'`` and ``V`` by their cell values: second order, none for the
    paper's initial data.

    Parameters
    ----------
    rod : Rod
        The rod, with exponent ``m = 1``.
    scenario : Scenario
        Loads (``f = 0``) and initial data.
    until : float
        End of the span [s].
    cells : int
        Cells per transit; the run is repeated with twice as many, which is returned, and the change is ``error``.

    Raises
    ------
    AssumptionError
        ``m`` is not 1, or there is a body force.

    Notes
    -----
    Evidence: COMPUTED, with ``error`` as the estimate.
    """
    if rod.exponent != 1 or not scenario.body_force.is_zero:
        raise AssumptionError(
            f"rod_run needs the linear law and no body force; got m = {rod.exponent:g}, f = {scenario.body_force}"
        )
    coarse, _ = _shifted(rod, scenario, until, cells)
    z, contacts = _shifted(rod, scenario, until, 2 * cells)
    t: NDArray[np.float64] = np.arange(len(z), dtype=np.float64) * (rod.travel_time / (2 * cells))
    common = min(len(coarse), (len(z) + 1) // 2)
    error = float(np.abs(coarse[:common] - z[: 2 * common : 2]).max())
    return RodRun(t=t, z=z, contacts=contacts, largest_z=float(z.max()), error=error)


def _shifted(
    rod: Rod, scenario: Scenario, until: float, cells: int
) -> tuple[NDArray[np.float64], tuple[tuple[float, float], ...]]:
    step = rod.travel_time / cells
    count = math.ceil(until / step)
    middle: NDArray[np.float64] = (np.arange(cells, dtype=np.float64) + 0.5) * (rod.length / cells)
    forward, backward = scenario.waves(rod, middle)
    sent = 2 * rod.input_gain * scenario.force(t=(np.arange(count) + 0.5) * step)
    # what arrives at x = L: the initial waves during (0, 2T), then echoes
    incoming: list[float] = [*forward[::-1].tolist(), *(-rod.reflection * backward).tolist()]
    push = [0.0] * cells + sent.tolist()
    rate = rod.mobility / rod.compliance
    decay, gain = math.exp(-rate * step), -math.expm1(-rate * step) / rate
    echo, z = -rod.reflection, scenario.contact_coordinate(rod)
    entered = 0.0 if z > 0 else None
    path, contacts = [z], []
    for i in range(count):
        w = incoming[i] + push[i]
        after = decay * z + gain * w if z > 0 else z + step * w
        if (after > 0) != (z > 0):  # the obstacle is reached or left inside the cell
            part = -z / w if z <= 0 else math.log1p(-rate * z / w) / rate
            after = -math.expm1(-rate * (step - part)) / rate * w if z <= 0 else (step - part) * w
            if z <= 0:
                entered = i * step + part
            elif entered is not None:
                contacts.append((entered, i * step + part))
                entered = None
        incoming.append(echo * (2 * (after - z) / step - w))
        z = after
        path.append(z)
    if entered is not None:
        contacts.append((entered, count * step))
    return np.array(path), tuple(contacts)
