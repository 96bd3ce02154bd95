"""A motion of the scheme with contact as a Dataset, plain data, a python-control response, an HTML table."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lure import datasets
from lure.datasets import Array, Column
from lure.showing import html_table
from lure.upwind import UpwindScheme

if TYPE_CHECKING:
    import control
    import xarray

    from lure.structured.motion import StructuredMotion

SUBJECT, EVIDENCE = "scheme", "observed"
METHOD = (
    "exact in time by the f-circulant structure of the scheme, from event to event; contact and release located as "
    "events"
)


def scheme_words(scheme: UpwindScheme) -> str:
    """Which object moves, in words."""
    printed = " as printed" if scheme.form == "as-printed" else ""
    return f"the upwind scheme{printed} of {scheme.cells} cells, whose waves lose more energy than the rod's"


def _stress(run: StructuredMotion) -> Array:
    return run.scheme.rod.law(run.z)


def run_dataset(run: StructuredMotion) -> xarray.Dataset:
    """The Dataset of :meth:`lure.structured.StructuredMotion.to_xarray`.

    Raises
    ------
    InputError
        xarray is not installed.
    """
    rod, stress = run.scheme.rod, _stress(run)
    ends = {"u_end": run.z + rod.gap, "z": run.z, "v_end": run.wave - rod.mobility * stress, "stress": stress}
    variables = datasets.series(ends)
    starts, stops = ([contact[i] for contact in run.contacts] for i in (0, 1))
    variables |= {
        "wave": Column(("t",), run.wave, "m s-1", "last forward wave y_N"),
        "contact_start": Column(("contact",), starts, "s", "instant of contact"),
        "contact_end": Column(("contact",), stops, "s", "instant of release, or the end"),
    }
    coordinates = {
        "t": Column(("t",), run.t, "s", datasets.TIME),
        "contact": datasets.numbered("contact", len(run.contacts)),
    }
    title = "Motion of the upwind scheme against an obstacle"
    about = scheme_words(run.scheme)
    attributes: dict[str, object] = {
        **datasets.motion_attributes(title, subject=SUBJECT, about=about, evidence=EVIDENCE, method=METHOD),
        **datasets.rod_attributes(rod),
        **(datasets.scenario_attributes(run.scenario) if run.scenario else {}),
        "method_cells": run.scheme.cells,
        "method_form": run.scheme.form,
    }
    return datasets.dataset(variables, coordinates, attributes)


def run_dict(run: StructuredMotion) -> dict[str, object]:
    """What is said of the motion, without the curves, as plain JSON data."""
    return {
        "subject": SUBJECT,
        "evidence": EVIDENCE,
        "cells": run.scheme.cells,
        "form": run.scheme.form,
        "rod": datasets.rod_dict(run.scheme.rod),
        "scenario": datasets.scenario_dict(run.scenario) if run.scenario else None,
        "until": float(run.t[-1]),
        "samples": run.t.size,
        "contacts": [list(contact) for contact in run.contacts],
        "largest_z_at_samples": float(run.z.max()),
        "z_end": float(run.z[-1]),
        "method": METHOD,
        "comment": datasets.what_it_shows(SUBJECT, scheme_words(run.scheme), EVIDENCE),
    }


def run_response(run: StructuredMotion) -> control.TimeResponseData:
    """The python-control response of :meth:`lure.structured.StructuredMotion.to_control`."""
    force = run.scenario.force(t=run.t) if run.scenario else 0.0
    return datasets.loop_response(f"the scheme, N = {run.scheme.cells}", run.t, run.z, _stress(run), force)


def run_html(run: StructuredMotion) -> str:
    """A table for notebooks."""
    about = scheme_words(run.scheme)
    rows = [
        ("what moved", about),
        ("time", f"0 s to {run.t[-1]:g} s, {run.t.size} samples"),
        ("force g(t) [N]", run.scenario.force if run.scenario else 0),
        ("contacts", len(run.contacts) or "none"),
        ("largest z", f"{run.z.max():.9g} m, at the samples"),
        ("z at the end", f"{run.z[-1]:.9g} m"),
    ]
    notes = (datasets.what_it_shows(SUBJECT, about, EVIDENCE),)
    return html_table(f"motion of the scheme, N = {run.scheme.cells}", rows, verdict="OBSERVED", notes=notes)
