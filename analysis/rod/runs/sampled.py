"""A motion as samples: of which object, on which evidence, and every quantity with its unit and sign."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from lure.analysis.verdict import Evidence
from lure.errors import InputError
from lure.rod.motion import Impact
from lure.rod.motion.sampling import check_places as check_places
from lure.rod.motion.sampling import check_samples as check_samples
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

if TYPE_CHECKING:
    import control
    import xarray

    from lure.analysis.plots.style import Axes

Array = NDArray[np.float64]
Subject = Literal["rod", "scheme", "Galerkin space"]

_APART = 0.5  # transits L/c
LOADED_CELLS = 1000  # of the scheme, above which it is followed by its structure and only its end is kept


@dataclass(frozen=True, kw_only=True, eq=False)
class Along:
    """What was kept along the rod, at the samples in time.

    Attributes
    ----------
    x : ndarray
        (n,) places [m].
    v, w, u : ndarray
        (samples, n) velocity [m/s], strain ``u_x`` [-], displacement [m].
    """

    x: Array
    v: Array
    w: Array
    u: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class SampledRun:
    """One motion at increasing instants, with its contacts; it shows this motion and proves nothing of others.

    Attributes
    ----------
    subject : {"rod", "scheme", "Galerkin space"}
        Which object moved.  A motion of the scheme or of a Galerkin space is not one of the rod.
    about : str
        The object in words.
    evidence : Evidence
        ``COMPUTED`` with an error estimate, else ``OBSERVED``.
    method : str
        How the motion was computed.
    rod : Rod
        The parameters.
    scenario : Scenario
        Loads and initial data.
    t, z, u_end, stress : ndarray
        (samples,) instants [s], ``z = u(t,L) - gap`` [m], ``u(t,L)`` [m], contact stress ``p >= 0`` [Pa].
    v_end, v_0, dashpot_force, energy : ndarray or None
        (samples,) ``u_t(t,L)`` [m/s], ``u_t(t,0)`` [m/s], ``k u_t(t,0)`` [N], energy of the object [J]; None where the
        method does not give them.
    impacts : tuple of Impact
        Every contact.  ``impulse`` and ``peak_stress`` are nan where the method does not give them.
    energy_residual : float or None
        Error of the energy balance, relative.
    error : float or None
        Estimate of the error of ``z`` [m]; of the time integration alone where the object is not the rod.
    error_is : str
        What ``error`` estimates.
    details : Mapping
        Settings of the method, numbers or text.
    note : str
        What was put in place of the data, or nothing.
    along : Along or None
        Fields, if asked for.
    """

    subject: Subject
    about: str
    evidence: Evidence
    method: str
    rod: Rod
    scenario: Scenario
    t: Array
    z: Array
    u_end: Array
    stress: Array
    v_end: Array | None = None
    v_0: Array | None = None
    dashpot_force: Array | None = None
    energy: Array | None = None
    impacts: tuple[Impact, ...] = ()
    energy_residual: float | None = None
    error: float | None = None
    error_is: str = ""
    details: Mapping[str, str | int | float] = field(default_factory=lambda: MappingProxyType({}))
    note: str = ""
    along: Along | None = None

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
        from lure.record import plain

        found: Any = plain(summary_dict(self, self.about))
        return {"subject": self.subject, "evidence": str(self.evidence), **found}

    def to_xarray(self) -> xarray.Dataset:
        """The motion as :func:`lure.analysis.rod.runs.run_dataset` has it.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        from lure.analysis.rod.runs.dataset import run_dataset

        return run_dataset(self)

    def to_control(self) -> control.TimeResponseData:
        """The motion as python-control has it: output ``sigma = z`` [m], inputs ``mu = -p(z)`` [Pa] and ``g`` [N]."""
        from lure.rod.datasets import loop_response

        return loop_response(self.about, self.t, self.z, self.stress, self.scenario.force(t=self.t))

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """The end of the rod and its contacts; see :func:`lure.analysis.plots.plot_run_end`.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        from lure.analysis.plots.rod_run import plot_run_end

        return plot_run_end(self, ax=ax)

    def _repr_html_(self) -> str:
        from lure.analysis.rod.runs.summary import summary_html

        return summary_html(self)


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
