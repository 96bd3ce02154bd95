"""A motion of the rod itself as samples: a Dataset, plain data, a python-control response, an HTML table."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lure.errors import InputError
from lure.record import Page, plain
from lure.rod import datasets
from lure.rod.datasets import Column

if TYPE_CHECKING:
    import control
    import xarray

    from lure.rod.datasets import Contact
    from lure.rod.motion.end_law import Boundary
    from lure.rod.motion.motion import Motion

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


def motion_dataset(motion: Motion, samples: int, places: int) -> xarray.Dataset:
    """The Dataset of :meth:`lure.rod.motion.Motion.to_xarray`.

    Raises
    ------
    InputError
        ``samples`` or ``places`` is out of range, or xarray is not installed.
    """
    check_samples(samples)
    if places != 0:
        check_places(places, samples)
    t = np.linspace(whole_rod_since(motion), motion.until, samples)
    variables = datasets.series(
        {
            "u_end": motion.end_displacement(t),
            "z": motion.z(t),
            "v_end": motion.end_velocity(t),
            "stress": motion.contact_stress(t),
            "dashpot_force": None if motion.boundary.clamped else motion.dashpot_force(t),
            "v_0": motion.dashpot_velocity(t),
            "energy": motion.energies(t) if samples <= MOST_ENERGIES else None,
        }
    )
    coordinates = {
        "t": Column(("t",), t, "s", datasets.TIME),
        "impact": datasets.numbered("impact", len(motion.impacts)),
    }
    variables |= datasets.impact_columns(motion.impacts)
    if places:
        x = np.linspace(0.0, motion.rod.length, places)
        grid = t[:, None], x[None, :]
        shown = np.array([motion.displacement(float(instant), x) for instant in t])
        variables |= datasets.fields({"v": motion.velocity(*grid), "w": motion.strain(*grid), "u": shown})
        coordinates["x"] = Column(("x",), x, "m", datasets.PLACE)
    return datasets.dataset(variables, coordinates, _attributes(motion))


def _attributes(motion: Motion) -> dict[str, object]:
    title = "Motion of a rod against an obstacle"
    found: dict[str, object] = {
        **datasets.motion_attributes(title, subject="rod", about=ABOUT, evidence="computed", method=METHOD),
        **datasets.rod_attributes(motion.rod),
        **datasets.scenario_attributes(motion.scenario),
        "energy_residual": motion.energy_residual,
        "error_estimate": motion.error,
        "error_estimate_units": "m",
        "error_estimate_of": ERROR,
    }
    if motion.note:
        found["note"] = motion.note
    details = {**boundary_attributes(motion.boundary), "law_crossings": motion.crossings}
    return found | {f"method_{name}": value for name, value in {**details, "compiled": int(motion.compiled)}.items()}


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
