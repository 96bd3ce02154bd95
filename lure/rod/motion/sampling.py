"""Motions as samples, and that of the rod itself as such: plain data, a python-control response, an HTML table."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from lure.errors import InputError
from lure.record import Column, Page, Record, plain, quantity
from lure.rod import datasets
from lure.rod.datasets import SERIES, STRESS, Contact
from lure.rod.motion.pieces import Array
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

if TYPE_CHECKING:
    import control

    from lure.rod.motion.end_law import Boundary
    from lure.rod.motion.motion import Motion

Subject = Literal["rod", "scheme", "Galerkin space"]

MOST_SAMPLES = 1_000_000
MOST_VALUES = 50_000_000
MOST_ENERGIES = 20_001
ABOUT = "the rod itself"
METHOD = (
    "exact motion of the rod along its characteristics: no grid and no time step; contact and release located as events"
)
ERROR = (
    "sum of the estimates of all local errors, as displacement; neither rounding along the way nor how impacts enlarge "
    "them is in it"
)
_SHOWN = 8


def check_samples(samples: int) -> None:
    """Refuse a number of samples that is none.

    Raises
    ------
    InputError
        It is not a whole number from 2 to 1000000.
    """
    if isinstance(samples, bool) or not isinstance(samples, int) or not 2 <= samples <= MOST_SAMPLES:
        raise InputError(f"samples is {samples!r}; give a whole number from 2 to {MOST_SAMPLES}")


def check_places(places: int, samples: int) -> None:
    """Refuse a number of places along the rod that is none, or a table that does not fit in memory.

    Raises
    ------
    InputError
        It is not a whole number from 2 on, or places times samples exceed 50 million.
    """
    most = MOST_VALUES // samples
    if isinstance(places, bool) or not isinstance(places, int) or not 2 <= places <= most:
        raise InputError(f"fields is {places!r}; with {samples} samples give a whole number of places from 2 to {most}")


def whole_rod_since(motion: Motion) -> float:
    """From when on all of the rod is known [s]: a round trip after the start of what was kept."""
    return motion.since + (2.0 * motion.rod.travel_time if motion.since > 0.0 else 0.0)


def boundary_attributes(boundary: Boundary) -> dict[str, str | float]:
    """Boundary conditions, for ``attrs``."""
    nonlinearity = "the rod's own" if boundary.nonlinearity is None else str(boundary.nonlinearity)
    return {
        "boundary_at_0": "clamped" if boundary.clamped else "dashpot",
        "boundary_end_damping": boundary.end_damping,
        "boundary_obstacle": "rigid" if boundary.rigid else nonlinearity,
    }


class Along(Record):
    """What was kept along the rod, at the samples in time."""

    x: Array = quantity(datasets.PLACE, "m", dims="x")
    v: Array = quantity("velocity, positive along x", "m s-1", dims="t x")
    w: Array = quantity("strain ``u_x``, positive in tension", "1", dims="t x")
    u: Array = quantity("displacement, positive along x", "m", dims="t x")


class Samples(Record):
    """One motion of a rod, of a scheme or of a Galerkin space at increasing instants, with its contacts."""

    subject: Subject = quantity(
        "Which object moved. A motion of the scheme or of a Galerkin space is not one of the rod"
    )
    about: str = quantity("The object in words")
    evidence: object = quantity("``COMPUTED`` with an error estimate, else ``OBSERVED``")
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
    impacts: tuple[Contact, ...] = quantity(
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


def at_instants(motion: Motion, t: Array) -> dict[str, Any]:
    """What :class:`Samples` hold of an exact motion at increasing instants [s], but for evidence, energy and fields.

    Raises
    ------
    InputError
        They leave what was kept of the motion.
    """
    return {
        "subject": "rod",
        "about": ABOUT,
        "method": METHOD,
        "rod": motion.rod,
        "scenario": motion.scenario,
        "t": t,
        "z": motion.z(t),
        "u_end": motion.end_displacement(t),
        "stress": motion.contact_stress(t),
        "v_end": motion.end_velocity(t),
        "v_0": motion.dashpot_velocity(t),
        "dashpot_force": None if motion.boundary.clamped else motion.dashpot_force(t),
        "impacts": motion.impacts,
        "energy_residual": motion.energy_residual,
        "error": motion.error,
        "error_is": ERROR,
        "details": {
            **boundary_attributes(motion.boundary),
            "law_crossings": motion.crossings,
            "compiled": int(motion.compiled),
        },
        "note": motion.note,
    }


def evenly(
    motion: Motion, samples: int, *, places: int = 0, energy: bool = True, span: tuple[float, float] | None = None
) -> dict[str, Any]:
    """The same at evenly spaced instants of all that was kept or of a span [s], with energy and fields if asked for.

    Raises
    ------
    InputError
        ``samples``, ``places`` or ``span`` is out of range.
    """
    check_samples(samples)
    if places != 0:
        check_places(places, samples)
    t = np.linspace(*(span or (whole_rod_since(motion), motion.until)), samples)
    return at_instants(motion, t) | {
        "energy": motion.energies(t) if energy and samples <= MOST_ENERGIES else None,
        "along": along_motion(motion, t, places) if places else None,
    }


def along_motion(motion: Motion, t: Array, places: int, *, displaced: bool = True) -> Along:
    """Velocity, strain and displacement of an exact motion on a grid of instants and places.

    ``t``: (samples,) instants [s]; ``places``: how many, evenly spaced from 0 to ``L``; ``displaced``: whether to
    compute the displacement, which costs more than the other two; else it is nan.

    Raises
    ------
    InputError
        ``places`` is out of range.
    """
    check_places(places, len(t))
    x = np.linspace(0.0, motion.rod.length, places)
    forward, backward = motion.waves(t[:, None], x[None, :])
    shown = np.full(forward.shape, np.nan)
    if displaced:
        shown = np.array([motion.displacement(float(instant), x) for instant in t])
    return Along(
        x=x,
        v=0.5 * (forward + backward),
        w=(backward - forward) / (2.0 * motion.rod.wave_speed),
        u=shown,
    )


def motion_dict(motion: Motion) -> dict[str, object]:
    """What is said of the motion, without the curves, as plain JSON data."""
    return {
        "subject": "rod",
        "evidence": "computed",
        "rod": datasets.rod_dict(motion.rod),
        "scenario": datasets.scenario_dict(motion.scenario),
        "boundary": plain(boundary_attributes(motion.boundary)),
        "since": motion.since,
        "until": motion.until,
        "impacts": plain(motion.impacts),
        "crossings": motion.crossings,
        "energy_residual": plain(motion.energy_residual),
        "error": plain(motion.error),
        "note": motion.note,
        "method": METHOD,
        "comment": datasets.what_it_shows("rod", ABOUT, "computed"),
    }


def motion_response(motion: Motion, samples: int) -> control.TimeResponseData:
    """The python-control response of :meth:`lure.rod.motion.Motion.to_control`.

    Raises
    ------
    InputError
        ``samples`` is out of range.
    """
    check_samples(samples)
    t = np.linspace(motion.since, motion.until, samples)
    return datasets.loop_response("the rod", t, motion.z(t), motion.contact_stress(t), motion.scenario.force(t=t))


def motion_page(motion: Motion) -> Page:
    """A table for notebooks: what moved, from when to when, what touched, and how well it is known."""
    rows: list[tuple[object, ...]] = [
        ("what moved", ABOUT),
        ("time", f"{motion.since:g} s to {motion.until:g} s"),
        ("force g(t) [N]", motion.scenario.force),
        ("contacts", _contacts(motion.impacts)),
        ("z at the end", f"{float(motion.z(motion.until)):.9g} m"),
        ("energy balance", f"relative residual {motion.energy_residual:.1g}"),
        ("error of z", f"{motion.error:.1g} m ({ERROR})"),
    ]
    if motion.note:
        rows.append(("note", motion.note))
    notes = (datasets.what_it_shows("rod", ABOUT, "computed"),)
    return Page("motion of the rod", rows, verdict="COMPUTED", notes=notes)


def _contacts(impacts: tuple[Contact, ...]) -> str:
    if not impacts:
        return "none"
    shown = ", ".join(f"{hit.start:.6g} s" for hit in impacts[:_SHOWN])
    more = ", ..." if len(impacts) > _SHOWN else ""
    peak = max(hit.peak_stress for hit in impacts)
    return f"{len(impacts)}, beginning at {shown}{more}; largest stress {peak:.6g} Pa"
