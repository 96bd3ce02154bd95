"""What a comparison returns: the exact motion, a row for each other one, and the numbers as JSON."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.comparison.modes import ModeDecay
from lure.analysis.rod.comparison.reference import Reference
from lure.analysis.rod.comparison.settling_claim import SettlingRow
from lure.record import by_value
from lure.rod.parameters import PARAMETERS, Rod
from lure.rod.scenario import Scenario

if TYPE_CHECKING:
    import xarray

    from lure.analysis.plots.style import Axes

Array = NDArray[np.float64]

ENERGIES = (
    "Energies as each model has them: rod and Galerkin A int (rho v^2 + E w^2)/2 dx + A P(z), P' = p; scheme the sum "
    "A rho h/4 sum y_i^2 + A P(z), which without loads never rises for k >= 0, whatever p >= 0 is."
)
EVIDENCE = (
    "The exact row is about the rod (COMPUTED); every other row is one motion of a discrete model (OBSERVED). Errors "
    "are those of this motion and are proved for no other."
)


@dataclass(frozen=True, kw_only=True, slots=True)
class Order:
    """Observed order of the L2 error of ``u(t, L)`` against the next coarser model of the family.

    Attributes
    ----------
    coarser : int
        Its size.
    before : float or None
        Up to the first kink or contact; None without samples there, or if an error is down to that of the integrator.
    whole : float or None
        Over the whole run.
    """

    coarser: int
    before: float | None
    whole: float | None


@by_value
@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Row:
    """One approximation of the motion.

    Attributes
    ----------
    family : str
        ``"scheme"`` or ``"Galerkin P1"``, ``"Galerkin P2"``, ``"Galerkin cosine"``.
    size : int
        ``N`` cells, or dimension ``m``.
    width : float
        Cell or element length [m].
    integrator : str
        What took the steps.
    u : ndarray or None
        (samples,) ``u(t, L)`` [m]; None for a model that could not be run.
    largest_error, l2_error : float
        Largest ``|u - u_exact|`` at the samples, and its root mean square over the time [m]; nan if not run.
    before_error : float or None
        The same mean up to the first kink or contact [m].
    energy_error : float or None
        Largest difference of the energies, relative to the largest energy of the rod.
    energy_end : float or None
        Energy at the end [J].
    decay : tuple of float or None
        Decay rates of the elastic modes 1, 2, 3 in flight [1/s].
    contacts : tuple of (float, float)
        Contacts of this motion [s].
    cpu_seconds : float
        CPU time of the process, with the assembly of the model [s].
    steps, evaluations : int or None
        Time steps and evaluations of the right-hand side; None where there are none or they are not counted.
    order : Order or None
        Against the next coarser row; None for the coarsest.
    refused : str
        Why it was not run, or nothing.
    """

    family: str
    size: int
    width: float
    integrator: str
    u: Array | None = None
    largest_error: float = float("nan")
    l2_error: float = float("nan")
    before_error: float | None = None
    energy_error: float | None = None
    energy_end: float | None = None
    decay: ModeDecay = ()
    contacts: tuple[tuple[float, float], ...] = ()
    cpu_seconds: float = 0.0
    steps: int | None = None
    evaluations: int | None = None
    order: Order | None = None
    refused: str = ""

    @property
    def label(self) -> str:
        """The family with the size."""
        return f"scheme, N = {self.size}" if self.family == "scheme" else f"{self.family}, m = {self.size}"


@by_value
@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Comparison:
    """The exact motion of a rod and what approximations make of it; made by :func:`.compare`.

    Attributes
    ----------
    rod : Rod
        The rod.
    scenario : Scenario
        Loads and initial data.
    until : float
        End of the run [s].
    exact : Reference
        The motion of the rod, with its samples.
    decay : tuple of float or None
        Decay rates of the rod's modes 1, 2, 3 in flight [1/s].
    rows : tuple of Row
        Schemes by size, then Galerkin models.
    settling : tuple of SettlingRow
        How each lets the released end settle; empty unless this is the release of the paper, in free flight.
    settling_statement : str
        What this shows of the paper's settling time, or nothing.
    """

    rod: Rod
    scenario: Scenario
    until: float
    exact: Reference
    decay: ModeDecay
    rows: tuple[Row, ...]
    settling: tuple[SettlingRow, ...] = ()
    settling_statement: str = ""

    @property
    def t(self) -> Array:
        """(samples,) instants [s]."""
        return self.exact.t

    @property
    def contacts(self) -> tuple[tuple[float, float], ...]:
        """Contacts of the rod itself [s]."""
        return tuple((impact.start, impact.end) for impact in self.exact.motion.impacts)

    def relative(self, error: float) -> float | None:
        """An error as a share of the amplitude; None for a rod that stays at rest."""
        return error / self.exact.amplitude if self.exact.amplitude else None

    def __str__(self) -> str:
        """The tables and what may be read from them."""
        from lure.analysis.rod.comparison.text import text

        return text(self)

    def to_dict(self) -> dict[str, Any]:
        """Everything but the curves, in types that JSON has."""
        exact, motion = self.exact, self.exact.motion
        loads = ("force", "body_force", "displacement", "velocity")
        return {
            "rod": {name: getattr(self.rod, name) for name in PARAMETERS},
            "scenario": {name: getattr(self.scenario, name).source for name in loads},
            "until": self.until,
            "samples": int(exact.t.size),
            "amplitude": exact.amplitude,
            "first_event": None if exact.event is None else {"t": exact.event.t, "kind": exact.event.kind},
            "exact": {
                "evidence": "COMPUTED",
                "energy_start": float(exact.energy[0]),
                "energy_end": float(exact.energy[-1]),
                "energy_residual": motion.energy_residual,
                "error": motion.error,
                "decay": list(self.decay),
                "contacts": [list(contact) for contact in self.contacts],
                "cpu_seconds": exact.cpu_seconds,
            },
            "rows": [_plain_row(self, row) for row in self.rows],
            "settling": [dataclasses.asdict(row) for row in self.settling],
            "settling_statement": self.settling_statement,
            "energies": ENERGIES,
            "evidence": EVIDENCE,
        }

    def to_xarray(self) -> xarray.Dataset:
        """All curves ``u(t, L)`` and numbers as an ``xarray.Dataset``, along ``t`` [s] and ``model``, with units.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        from lure.analysis.rod.comparison.export import comparison_dataset

        return comparison_dataset(self)

    def plot(self, *, ax: Axes | None = None) -> tuple[Axes, Axes]:
        """The end of the rod by every method, the errors below; see :func:`lure.analysis.plots.plot_comparison`.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        from lure.analysis.plots.rod_comparison import plot_comparison

        return plot_comparison(self, ax=ax)

    def _repr_html_(self) -> str:
        from lure.analysis.rod.comparison.export import comparison_html

        return comparison_html(self)


def _plain_row(found: Comparison, row: Row) -> dict[str, Any]:
    ran = not row.refused
    return {
        "family": row.family,
        "size": row.size,
        "width": row.width,
        "integrator": row.integrator,
        "evidence": "OBSERVED",
        "largest_error": row.largest_error if ran else None,
        "largest_error_relative": found.relative(row.largest_error) if ran else None,
        "l2_error": row.l2_error if ran else None,
        "l2_error_relative": found.relative(row.l2_error) if ran else None,
        "l2_error_before_event": row.before_error,
        "energy_error": row.energy_error,
        "energy_end": row.energy_end,
        "decay": list(row.decay),
        "contacts": [list(contact) for contact in row.contacts],
        "cpu_seconds": row.cpu_seconds,
        "steps": row.steps,
        "evaluations": row.evaluations,
        "order": None if row.order is None else dataclasses.asdict(row.order),
        "refused": row.refused or None,
    }
