"""One motion, exactly and by the ways people know, side by side, with observed orders."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lure.analysis.rod.comparison.integrators import SCHEME_METHODS, SchemeMethod, integrate
from lure.analysis.rod.comparison.modes import (
    GalerkinModes,
    SettlingRow,
    from_closed_form,
    from_modes,
    galerkin_modes,
    is_the_papers,
    verdict,
    wave_decay,
)
from lure.analysis.rod.comparison.reference import Reference, reference
from lure.analysis.rod.comparison.result import Comparison, Order, Row
from lure.analysis.rod.paper.settling import rod_settling, scheme_settling
from lure.arrays import Reals as Array
from lure.errors import AssumptionError, InputError, demand_whole
from lure.rod import galerkin as weak
from lure.rod.discretisation import upwind
from lure.rod.galerkin.spaces import Space, SpaceName
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

_FLOOR, _ROUNDING = 100.0, 1e-13
Progress = Callable[[str, float], None]

CELLS = (10, 50, 200)
GALERKIN: tuple[tuple[SpaceName, int], ...] = (("P1", 51), ("P2", 51), ("cosine", 50))
_ROUND_TRIPS = 7.5
_TOLERANCE = 1e-8
_MOST_SAMPLES = 200_000
_FEWEST = 8


def mean_square(error: Array, t: Array) -> float:
    """Root of the mean square over the time, by the trapezoidal rule.

    ``error``, ``t``: (n,) values and their instants [s].
    """
    return math.sqrt(float(np.trapezoid(error**2, t)) / float(t[-1] - t[0]))


def with_orders(rows: list[Row], exact: Reference, tolerances: tuple[float, float]) -> tuple[Row, ...]:
    """The rows with the orders against the next coarser of the family that was run.

    ``rows``: by size within each family; ``tolerances``: relative ones of the time steps of the schemes and of the
    Galerkin models: errors within a hundred times that of the amplitude say nothing about an order.
    """
    done: list[Row] = []
    last: dict[str, Row] = {}
    rounding = _ROUNDING * (float(np.abs(exact.u).max()) + abs(exact.motion.rod.gap))
    for row in rows:
        coarse = last.get(row.family)
        if not row.refused:
            last[row.family] = row
        if row.refused or coarse is None:
            done.append(row)
            continue
        tolerance = tolerances[0 if row.family == "scheme" else 1]
        floor = _FLOOR * tolerance * exact.amplitude + rounding
        ratio = math.log(coarse.width / row.width)
        order = Order(
            coarser=coarse.size,
            before=_order(coarse.before_error, row.before_error, ratio, floor),
            whole=_order(coarse.l2_error, row.l2_error, ratio, floor),
        )
        done.append(replace(row, order=order))
    return tuple(done)


def _order(coarse: float | None, fine: float | None, ratio: float, floor: float) -> float | None:
    if coarse is None or fine is None or not min(coarse, fine) > floor:
        return None
    return math.log(coarse / fine) / ratio


def compare(  # noqa: PLR0913  (what, from where, until when, and five settings with defaults)
    rod: Rod,
    scenario: Scenario | None = None,
    until: float | None = None,
    *,
    cells: Sequence[int] = CELLS,
    galerkin: Sequence[tuple[SpaceName, int]] = GALERKIN,
    method: SchemeMethod = "exact",
    samples: int = 2001,
    progress: Progress | None = None,
) -> Comparison:
    r"""The exact motion of a rod, the method of lines for several ``N``, and Galerkin models, in one table.

    Each is held against the exact motion: error of ``u(t, L)``, energy, decay of the elastic modes in flight, cost.
    The observed order between neighbours in size is that of

    .. math:: e = \Big( \frac{1}{t} \int_0^t (u - u_{\text{exact}})^2 ds \Big)^{1/2} \Big|_{x = L},
        \qquad \frac{\ln (e_1/e_2)}{\ln (h_1/h_2)},

    once up to the first kink of ``u(t, L)`` or contact, once over the run.  What smears before a kink counts as before
    it: orders there stay below those for smooth data.

    Parameters
    ----------
    rod : Rod
        The rod.
    scenario : Scenario, optional
        Loads and initial data; by default the rod is released from a uniform strain of 2e-4, as the paper's is.
    until : float, optional
        End of the run [s]; by default seven and a half round trips, 2.5e-3 s for the paper's rod.
    cells : sequence of int
        Numbers of cells of the scheme, any order; may be empty.
    galerkin : sequence of (str, int)
        Spaces (``"P1"``, ``"P2"``, ``"cosine"``) with their dimensions; may be empty.
    method : str
        What integrates the scheme; see :func:`lure.analysis.rod.comparison.integrate`.
    samples : int
        Number of instants compared, from 16 to 200 000.
    progress : callable, optional
        Called as ``progress(stage, done)`` with the share done.

    Returns
    -------
    Comparison
        A model that cannot be run (a contact too stiff for it, say) has a row that says why.

    Raises
    ------
    InputError
        An argument is out of range or given twice, or the exact motion is refused.
    AssumptionError
        The exact motion has too many contacts.

    Examples
    --------
    >>> from lure.rod import builtin_system
    >>> system = builtin_system("paper-rod")
    >>> found = compare(system.rod, system.scenario, 2.5e-3, cells=(10, 50), galerkin=())
    >>> [round(row.largest_error / found.exact.amplitude, 2) for row in found.rows]
    [1.0, 0.81]
    """
    chosen = scenario if scenario is not None else _release(rod)
    end = 2.0 * _ROUND_TRIPS * rod.travel_time if until is None else until
    sizes, spaces = _checked(rod, cells, galerkin, method, samples)
    say = progress or (lambda _stage, _done: None)
    total = 1.0 + len(sizes) + len(spaces)
    say("exact motion", 0.0)
    exact = reference(rod, chosen, end, samples)
    models = _Models(rod=rod, scenario=chosen, exact=exact, method=method)
    rows: list[Row] = []
    modes: dict[str, GalerkinModes] = {}
    for N in sizes:
        say(f"scheme, N = {N}", (1.0 + len(rows)) / total)
        rows.append(models.scheme(N))
    for space in spaces:
        say(f"Galerkin {space.name}, m = {space.order}", (1.0 + len(rows)) / total)
        row, found = models.galerkin(space)
        rows.append(row)
        if found is not None:
            modes[row.label] = found
    settling, statement = _settling(models, rows, modes)
    return Comparison(
        rod=rod,
        scenario=chosen,
        until=float(end),
        exact=exact,
        decay=wave_decay(rod, None),
        rows=with_orders(rows, exact, (1e-13 if method == "exact" else _TOLERANCE, _TOLERANCE)),
        settling=settling,
        settling_statement=statement,
    )


def _release(rod: Rod) -> Scenario:
    """Uniform strain -2e-4, as ``u0 = e/2 - e x/L`` with ``e = 2e-4 L``."""
    length = rod.exact["length"]
    return Scenario.parse(displacement=f"{length}/10000 - x/5000")


def _checked(
    rod: Rod, cells: Sequence[int], galerkin: Sequence[tuple[SpaceName, int]], method: str, samples: object
) -> tuple[list[int], list[Space]]:
    if method not in SCHEME_METHODS:
        raise InputError(f"method is {method!r:.40}; give one of {', '.join(SCHEME_METHODS)}")
    demand_whole("samples", samples, 16, _MOST_SAMPLES)
    sizes = sorted(upwind(rod, N).cells for N in cells)
    spaces = [Space(name=name, order=order, length=rod.length) for name, order in galerkin]
    for what, given in (("cells", sizes), ("galerkin", [(space.name, space.order) for space in spaces])):
        if len(set(given)) < len(given):
            raise InputError(f"{what} is {given}; give every model once")
    return sizes, sorted(spaces, key=lambda space: (space.name, space.order))


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class _Models:
    """The one question that all models answer."""

    rod: Rod
    scenario: Scenario
    exact: Reference
    method: SchemeMethod

    def scheme(self, cells: int) -> Row:
        """A row for the scheme."""
        scheme, t = upwind(self.rod, cells), self.exact.t
        row = Row(
            family="scheme",
            size=cells,
            width=self.rod.length / cells,
            integrator=self.method,
            decay=wave_decay(self.rod, cells),
        )
        try:
            run = integrate(scheme, self.scenario, float(t[-1]), method=self.method, samples=t.size)
        except (InputError, AssumptionError) as refusal:
            return replace(row, refused=str(refusal))
        row = replace(
            row, contacts=run.contacts, cpu_seconds=run.cpu_seconds, steps=run.steps, evaluations=run.evaluations
        )
        return self._held_against(row, run.u_end, run.energy)

    def galerkin(self, space: Space) -> tuple[Row, GalerkinModes | None]:
        """A row for a Galerkin model, and its modes if they were computed."""
        before, t = time.process_time(), self.exact.t
        row = Row(family=f"Galerkin {space.name}", size=space.order, width=space.width, integrator="DOP853")
        try:
            model = weak.galerkin(self.rod, space=space.name, order=space.order)
            run = model.simulate(self.scenario, float(t[-1]), samples=t.size, tolerance=_TOLERANCE)
        except (InputError, AssumptionError) as refusal:
            return replace(row, refused=str(refusal)), None
        spent = time.process_time() - before
        modes = galerkin_modes(model, self.scenario)
        row = replace(
            row,
            decay=() if modes is None else modes.decay,
            contacts=tuple((touch.start, touch.end) for touch in run.contacts),
            cpu_seconds=spent,
            steps=run.steps,
        )
        return self._held_against(row, run.u_end, run.energy), modes

    def _held_against(self, row: Row, u: Array, energy: Array | None) -> Row:
        exact = self.exact
        error, event = u - exact.u, exact.event
        early = exact.t.size if event is None else int(np.searchsorted(exact.t, event.t, side="right"))
        largest = float(exact.energy.max())
        difference = None if energy is None else float(np.abs(energy[exact.places] - exact.energy).max())
        return replace(
            row,
            u=u,
            largest_error=float(np.abs(error).max()),
            l2_error=mean_square(error, exact.t),
            before_error=mean_square(error[:early], exact.t[:early]) if early >= _FEWEST else None,
            energy_error=difference / largest if difference is not None and largest else None,
            energy_end=None if energy is None else float(energy[-1]),
        )


def _settling(models: _Models, rows: list[Row], modes: dict[str, GalerkinModes]) -> tuple[tuple[SettlingRow, ...], str]:
    """The paper's settling time against every model that stays free."""
    rod, scenario, exact = models.rod, models.scenario, models.exact
    if not is_the_papers(rod, scenario) or exact.motion.impacts:
        return (), ""
    try:
        itself = from_closed_form("exact", rod_settling(rod, scenario))
    except AssumptionError:  # the end reaches the obstacle after the run
        return (), ""
    found, schemes = [itself], {}
    for row in rows:
        if row.contacts or row.refused:
            continue
        if row.family == "scheme":
            found.append(from_closed_form(row.label, scheme_settling(rod, scenario, row.size)))
            schemes[row.size] = found[-1].left
        elif row.label in modes:
            found.append(from_modes(row.label, modes[row.label], rod))
    return tuple(found), verdict(itself.left, schemes)
