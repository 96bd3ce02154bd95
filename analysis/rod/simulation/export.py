"""A simulated motion of the scheme as a Dataset, plain data, a python-control response, an HTML table."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lure.record import html_table, plain
from lure.rod import datasets
from lure.rod.datasets import Column
from lure.rod.structured.motion import scheme_words

if TYPE_CHECKING:
    import control
    import xarray

    from lure.analysis.rod.simulation.trajectory import Trajectory

SUBJECT, EVIDENCE = "scheme", "observed"
_CONTACTS = {
    "start": ("s", "instant of contact"),
    "end": ("s", "instant of release, or the end of the run"),
    "peak_penetration": ("m", "largest z over all instants of the contact"),
    "impulse": ("N s", "impulse A int p dt given to the obstacle"),
    "open": ("1", "whether the run began or ended in this contact, so that it is seen in part only"),
}
_FRAMES = {
    "r1": ("frames_r1", "forward wave r1 = v - c w"),
    "r2": ("frames_r2", "backward wave r2 = v + c w"),
    "v": ("frames_v", "velocity, positive along x"),
}
_NUMBERS = (
    "max_gap_coordinate",
    "energy_residual",
    "energy_increase",
    "zeta_increase",
    "lyapunov_increase",
    "lyapunov_theta",
    "bound",
    "rest_position",
    "rest_limit",
    "event_resolution",
    "error_estimate",
)


def trajectory_dataset(run: Trajectory) -> xarray.Dataset:
    """The Dataset of :meth:`lure.analysis.rod.simulation.Trajectory.to_xarray`.

    Raises
    ------
    InputError
        xarray is not installed.
    """
    variables = datasets.series({"u_end": run.u_end, "z": run.z, "stress": run.p, "energy": run.energy})
    variables["force"] = Column(("t",), run.force, "N", "force g on the end x = 0, positive along x")
    if run.zeta is not None:
        variables["zeta"] = Column(("t",), run.zeta, "m", "deflated coordinate, constant in free flight without load")
    if run.lyapunov is not None:
        text = f"Popov-Lyapunov function with the multiplier {run.lyapunov_theta:g} s"
        variables["lyapunov"] = Column(("t",), run.lyapunov, "Pa s", text)
    for name, (unit, text) in _CONTACTS.items():
        values = np.array([getattr(contact, name) for contact in run.contacts], bool if name == "open" else float)
        variables[f"contact_{name}"] = Column(("contact",), values, unit, text)
    coordinates = {
        "t": Column(("t",), run.t, "s", datasets.TIME),
        "contact": datasets.numbered("contact", len(run.contacts)),
    }
    if run.frames_t.size:
        coordinates["frame"] = Column(("frame",), run.frames_t, "s", "time of a frame")
        coordinates["x"] = Column(("x",), run.frames_x, "m", datasets.PLACE)
        for name, (field, text) in _FRAMES.items():
            variables[name] = Column(("frame", "x"), getattr(run, field), "m s-1", text)
    return datasets.dataset(variables, coordinates, _attributes(run))


def _attributes(run: Trajectory) -> dict[str, object]:
    about = scheme_words(run.scheme)
    words = {"subject": SUBJECT, "about": about, "evidence": EVIDENCE, "method": run.method}
    numbers = {name: getattr(run, name) for name in _NUMBERS}
    found: dict[str, object] = {
        **datasets.motion_attributes("Simulated motion of the upwind scheme", **words),
        **datasets.rod_attributes(run.scheme.rod),
        **{name: value for name, value in numbers.items() if value is not None},
        "method_cells": run.cells,
        "method_form": run.form,
        "loaded": int(run.loaded),
    }
    return found | ({"ended_early": run.ended_early} if run.ended_early else {})


def trajectory_dict(run: Trajectory) -> dict[str, object]:
    """What is said of the motion, without the curves, as plain JSON data."""
    return {
        "subject": SUBJECT,
        "evidence": EVIDENCE,
        "cells": run.cells,
        "form": run.form,
        "rod": datasets.rod_dict(run.scheme.rod),
        "loaded": run.loaded,
        "until": float(run.t[-1]),
        "samples": run.t.size,
        "contacts": [{name: plain(getattr(contact, name)) for name in _CONTACTS} for contact in run.contacts],
        **{name: plain(getattr(run, name)) for name in _NUMBERS},
        "rest_is_final": run.rest_is_final,
        "ended_early": run.ended_early,
        "method": run.method,
        "comment": datasets.what_it_shows(SUBJECT, scheme_words(run.scheme), EVIDENCE),
    }


def trajectory_response(run: Trajectory) -> control.TimeResponseData:
    """The python-control response of :meth:`lure.analysis.rod.simulation.Trajectory.to_control`."""
    return datasets.loop_response(f"the scheme, N = {run.cells}", run.t, run.z, run.p, run.force)


def trajectory_html(run: Trajectory) -> str:
    """A table for notebooks."""
    from lure.analysis.rod.simulation.trajectory import contradictions

    against = contradictions(run)
    rows: list[tuple[str, object]] = [
        ("what moved", scheme_words(run.scheme)),
        ("time", f"0 s to {run.t[-1]:g} s, {run.t.size} samples" + (", under load" if run.loaded else "")),
        ("contacts", len(run.contacts) or "none"),
        ("largest z", f"{run.max_gap_coordinate:.9g} m, over all instants"),
        ("error of z", f"{run.error_estimate:.1g} m, the difference from a second run with shorter steps"),
        ("energy identity", f"relative residual {run.energy_residual:.1g}"),
    ]
    if run.rest_limit is not None:
        rows.append(("comes to rest", f"at z = {run.rest_position:.9g} m" if run.rest_is_final else _at_most(run)))
    if run.ended_early:
        rows.append(("ended early", run.ended_early))
    rows.append(("against what was shown", "; ".join(against) or "nothing contradicts, which proves nothing"))
    notes = (datasets.what_it_shows(SUBJECT, scheme_words(run.scheme), EVIDENCE),)
    return html_table(f"simulated motion of the scheme, N = {run.cells}", rows, verdict="OBSERVED", notes=notes)


def _at_most(run: Trajectory) -> str:
    return f"at some z <= {run.rest_limit:.6g} m"
