"""A motion in a few lines to read, and as plain data."""

from __future__ import annotations

import math
from typing import Any

from lure.analysis.rod.runs.sampled import SampledRun
from lure.record import Page, finite
from lure.rod.datasets import impact_dicts, what_it_shows

_REST = 1e-28  # of the largest energy: velocities below 1e-14 of the largest


def summary_lines(run: SampledRun, name: str) -> list[str]:
    """What moved, what touched, how energy and errors stand, and what this shows.

    Parameters
    ----------
    run : SampledRun
        The motion.
    name : str
        Name of the system.
    """
    said = [f"{name} up to {run.until:g} s: {run.about}.", *_ends(run), _contact(run), _end(run)]
    if run.energy is not None:
        said.append(f"Energy: {run.energy[0]:.6g} J at the start, {run.energy[-1]:.6g} J at the end.")
    if run.energy_residual is not None:
        said.append(f"Energy balance: relative residual {run.energy_residual:.1g}.")
    if run.error is not None:
        said.append(f"Error of z: {run.error:.1g} m ({run.error_is}).")
    else:
        said.append("Error of z: not estimated.")
    said.append(f"Method: {run.method.removesuffix('.')}.")
    if run.note:
        said.append(f"Note: {run.note}.")
    other = "" if run.subject == "rod" else ", and it is not a motion of the rod"
    said.append(f"One motion, {run.evidence}: it proves nothing of others{other}.")
    return said


def _ends(run: SampledRun) -> list[str]:
    """How the ends differ from those of the system."""
    found = []
    at_0, end_damping = run.details.get("boundary_at_0"), run.details.get("boundary_end_damping")
    if at_0 not in (None, "the dashpot of the system", "dashpot"):
        found.append(f"x = 0 is {at_0}")
    if run.details.get("boundary_obstacle") == "rigid":
        found.append("the obstacle is rigid")
    if end_damping:
        found.append(f"x = L has a dashpot of {end_damping:g} N s/m")
    return [f"Ends: {', '.join(found)}."] if found else []


def _contact(run: SampledRun) -> str:
    if not run.impacts:
        return f"Contact: none; largest z {float(run.z.max()):.6g} m at the samples."
    number, first = len(run.impacts), run.impacts[0].start
    stress, where = run.largest_stress
    impulse = "" if math.isnan(run.impulse) else f", impulse {run.impulse:.6g} N s in all"
    times = "once" if number == 1 else f"{number} times"
    return f"Contact: {times}, first at {first:.6g} s; largest stress {stress:.6g} Pa {where}{impulse}."


def _end(run: SampledRun) -> str:
    touching = bool(run.impacts) and not run.impacts[-1].closed
    state = "in contact" if touching else "in flight" if moving(run) else "at rest to rounding"
    return f"At the end: {state}, u(t, L) = {run.u_end[-1]:.9g} m, z = {run.z[-1]:.9g} m."


def moving(run: SampledRun) -> bool:
    """Whether energy above rounding is left at the end; true where the method gives no energy.

    Parameters
    ----------
    run : SampledRun
        The motion.
    """
    return run.energy is None or float(run.energy[-1]) > _REST * float(run.energy.max())


def summary_dict(run: SampledRun, name: str) -> dict[str, Any]:
    """The same as plain data, with every impact; numbers that are not known are None.

    Parameters
    ----------
    run : SampledRun
        The motion.
    name : str
        Name of the system.
    """
    stress, where = run.largest_stress
    return {
        "system": name,
        "until": run.until,
        "samples": len(run.t),
        "end": {
            "u_end": float(run.u_end[-1]),
            "z": float(run.z[-1]),
            "energy": None if run.energy is None else float(run.energy[-1]),
        },
        "largest_stress": stress,
        "largest_stress_is": where,
        "impulse": finite(run.impulse),
        "impacts": impact_dicts(run.impacts),
        "energy_residual": run.energy_residual,
        "error": run.error,
        "attributes": run._attributes() | {"title": f"Motion of {name}"},
    }


def summary_page(run: SampledRun) -> Page:
    """A table for notebooks: the same lines.

    Parameters
    ----------
    run : SampledRun
        The motion.
    """
    said = [("what moved", run.about), ("time", f"{run.t[0]:g} s to {run.until:g} s, {run.t.size} samples")]
    said += [("force g(t) [N]", str(run.scenario.force))]
    lines = [line.partition(": ") for line in summary_lines(run, run.subject)[1:-1]]
    said += [(name, text) for name, _, text in lines]
    notes = (what_it_shows(run.subject, run.about, str(run.evidence)),)
    return Page(f"motion of the {run.subject}", said, verdict=str(run.evidence).upper(), notes=notes)
