"""A motion as samples: of which object, on which evidence, and every quantity with its unit and sign."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from lure.analysis.verdict import Evidence
from lure.errors import InputError
from lure.record import Column, Page, Record, plain, quantity
from lure.rod import datasets
from lure.rod.datasets import SERIES, STRESS
from lure.rod.motion import Impact
from lure.rod.motion.sampling import check_places as check_places
from lure.rod.motion.sampling import check_samples as check_samples
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

if TYPE_CHECKING:
    import control

    from lure.analysis.plots.style import Axes

Array = NDArray[np.float64]
Subject = Literal["rod", "scheme", "Galerkin space"]

_APART = 0.5  # transits L/c
LOADED_CELLS = 1000  # of the scheme, above which it is followed by its structure and only its end is kept


class Along(Record):
    """What was kept along the rod, at the samples in time."""

    x: Array = quantity(datasets.PLACE, "m", dims="x")
    v: Array = quantity("velocity, positive along x", "m s-1", dims="t x")
    w: Array = quantity("strain ``u_x``, positive in tension", "1", dims="t x")
    u: Array = quantity("displacement, positive along x", "m", dims="t x")


class SampledRun(Record):
    """One motion at increasing instants, with its contacts; it shows this motion and proves nothing of others."""

    subject: Subject = quantity(
        "Which object moved. A motion of the scheme or of a Galerkin space is not one of the rod"
    )
    about: str = quantity("The object in words")
    evidence: Evidence = quantity("``COMPUTED`` with an error estimate, else ``OBSERVED``")
    method: str = quantity("How the motion was computed")
    rod: Rod = quantity("The parameters")
    scenario: Scenario = quantity("Loads and initial data")
    t: Array = quantity(datasets.TIME, "s", dims="t")
    z: Array = quantity(*SERIES["z"], dims="t")
    u_end: Array = quantity(*SERIES["u_end"], dims="t")
    stress: Array = quantity(*SERIES["stress"], dims="t", name=STRESS)
    v_end: Array | None = quantity(*SERIES["v_end"], dims="t", default=None)
    v_0: Array | None = quantity(*SERIES["v_0"], dims="t", default=None)
    dashpot_force: Array | None = quantity(*SERIES["dashpot_force"], dims="t", default=None)
    energy: Array | None = quantity(*SERIES["energy"], dims="t", default=None)
    impacts: tuple[Impact, ...] = quantity(
        "Every contact. ``impulse`` and ``peak_stress`` are nan where the method does not give them", default=()
    )
    energy_residual: float | None = quantity("Error of the energy balance, relative", default=None)
    error: float | None = quantity(
        "Estimate of the error of ``z`` [m]; of the time integration alone where the object is not the rod",
        default=None,
    )
    error_is: str = quantity("What ``error`` estimates", default="")
    details: Mapping[str, str | int | float] = quantity(
        "Settings of the method, numbers or text", default_factory=lambda: MappingProxyType({})
    )
    note: str = quantity("What was put in place of the data, or nothing", default="")
    along: Along | None = quantity("Fields, if asked for", inline=True, default=None)

    @property
    def until(self) -> float:
        """The last sample [s]."""
        return float(self.t[-1])

    @property
    def largest_stress(self) -> tuple[float, str]:
        """Largest contact stress [Pa], and whether over all instants or at the samples only."""
        peaks = [impact.peak_stress for impact in self.impacts]
        if any(math.isnan(peak) for peak in peaks):
            return float(self.stress.max()), "at the samples"
        return max(peaks, default=0.0), "over all instants"

    @property
    def impulse(self) -> float:
        """Sum of the impulses of all contacts, ``A int p dt`` [N s]; nan where one is not known."""
        return math.fsum(impact.impulse for impact in self.impacts)

    def to_dict(self) -> dict[str, Any]:
        """What is said of the motion as plain JSON data; the curves are in :meth:`to_xarray`."""
        from lure.analysis.rod.runs.summary import summary_dict

        found: Any = plain(summary_dict(self, self.about))
        return {"subject": self.subject, "evidence": str(self.evidence), **found}

    def _columns(self) -> dict[str, Column]:
        """Samples along ``t``, contacts along ``impact`` (nan: the method does not tell), fields along ``x``."""
        return super()._columns() | datasets.impact_columns(self.impacts)

    def _attributes(self) -> dict[str, object]:
        """What moved, how that is known, and every number that went in."""
        words = {"subject": self.subject, "about": self.about, "evidence": str(self.evidence), "method": self.method}
        found: dict[str, object] = {
            **datasets.motion_attributes("Motion of a rod against an obstacle", **words),
            **datasets.rod_attributes(self.rod),
            **datasets.scenario_attributes(self.scenario),
        }
        if self.energy_residual is not None:
            found["energy_residual"] = self.energy_residual
        if self.error is not None:
            found |= {"error_estimate": self.error, "error_estimate_units": "m", "error_estimate_of": self.error_is}
        if self.note:
            found["note"] = self.note
        return found | {f"method_{name}": value for name, value in self.details.items()}

    def to_control(self) -> control.TimeResponseData:
        """The motion as python-control has it: output ``sigma = z`` [m], inputs ``mu = -p(z)`` [Pa] and ``g`` [N]."""
        return datasets.loop_response(self.about, self.t, self.z, self.stress, self.scenario.force(t=self.t))

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """The end of the rod and its contacts; see :func:`lure.analysis.rod.plots.plot_run_end`.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        from lure.analysis.rod.plots.run import plot_run_end

        return plot_run_end(self, ax=ax)

    def _page(self) -> Page:
        from lure.analysis.rod.runs.summary import summary_page

        return summary_page(self)


def instants(since: float, until: float, samples: int) -> Array:
    """Evenly spaced samples [s].

    Raises
    ------
    InputError
        ``samples`` is not a whole number from 2 to 1000000.
    """
    check_samples(samples)
    return np.linspace(since, until, samples)


def check_until(until: float) -> None:
    """Refuse an end of the motion that is none.

    Raises
    ------
    InputError
        It is not a positive number of seconds.
    """
    if isinstance(until, bool) or not isinstance(until, int | float) or not 0.0 < until < math.inf:
        raise InputError(f"until is {until!r}; give a positive number of seconds")


def sparse(until: float, samples: int, rod: Rod) -> str:
    """A warning where waves pass the end unseen between two samples: more than half a transit apart; else nothing.

    Parameters
    ----------
    until : float
        End of the motion [s].
    samples : int
        Number of instants, evenly spaced.
    rod : Rod
        The rod.
    """
    apart = until / (samples - 1) / rod.travel_time
    if apart <= _APART:
        return ""
    return f"the samples are {apart:.3g} transits L/c apart, and what the waves do between them is not in the samples"
