"""A comparison as a Dataset and an HTML table."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from lure.record import html_table
from lure.rod import datasets
from lure.rod.datasets import Column

if TYPE_CHECKING:
    import xarray

    from lure.analysis.rod.comparison.result import Comparison, Row

_NUMBERS: dict[str, tuple[Callable[[Row], float | None], str, str]] = {
    "width": (lambda row: row.width, "m", "cell or element length"),
    "largest_error": (lambda row: row.largest_error, "m", "largest |u(t, L) - exact| at the samples"),
    "l2_error": (lambda row: row.l2_error, "m", "root mean square of u(t, L) - exact over the time"),
    "before_error": (lambda row: row.before_error, "m", "the same up to the first kink or contact"),
    "energy_error": (lambda row: row.energy_error, "1", "largest difference of the energies over the rod's largest"),
    "energy_end": (lambda row: row.energy_end, "J", "energy at the end"),
    "cpu": (lambda row: row.cpu_seconds, "s", "CPU time of the process, with the assembly of the model"),
    "order": (
        lambda row: None if row.order is None else row.order.whole,
        "1",
        "observed order of l2_error against the coarser row",
    ),
}


def comparison_dataset(found: Comparison) -> xarray.Dataset:
    """The Dataset of :meth:`lure.analysis.rod.comparison.Comparison.to_xarray`.

    Raises
    ------
    InputError
        xarray is not installed.
    """
    from lure.analysis.rod.comparison.result import ENERGIES, EVIDENCE

    rows, of = found.rows, ("model",)
    unknown = np.full(found.t.size, np.nan)
    curves = np.array([unknown if row.u is None else row.u for row in rows]).reshape(len(rows), found.t.size)
    variables = {
        "u_exact": Column(("t",), found.exact.u, "m", "exact displacement u(t, L) of the rod itself, positive along x"),
        "u_end": Column(("model", "t"), curves, "m", "displacement u(t, L) of the model; nan if it was not run"),
        "cells": Column(of, [row.size for row in rows], "1", "N cells of a scheme, or dimension of a Galerkin space"),
        "steps": Column(of, [_number(row.steps) for row in rows], "1", "time steps; nan where there are none"),
        "contacts": Column(of, [len(row.contacts) for row in rows], "1", "number of contacts of this motion"),
    }
    for name, (value, unit, text) in _NUMBERS.items():
        variables[name] = Column(of, [_number(value(row)) for row in rows], unit, text)
    coordinates = {
        "t": Column(("t",), found.t, "s", datasets.TIME),
        "model": Column(of, np.array([row.label for row in rows], dtype=object), "1", "approximation"),
    }
    attributes = {
        "title": "The exact motion of a rod and its approximations",
        "subject": "rod; every row of model is a discrete model of it",
        "evidence": "observed; u_exact computed",
        "comment": f"{EVIDENCE} {ENERGIES}",
        "amplitude": found.exact.amplitude,
        "amplitude_units": "m",
        "exact_error": found.exact.motion.error,
        "exact_error_units": "m",
        **datasets.rod_attributes(found.rod),
        **datasets.scenario_attributes(found.scenario),
    }
    return datasets.dataset(variables, coordinates, attributes)


def _number(value: float | None) -> float:
    return np.nan if value is None else float(value)


def comparison_html(found: Comparison) -> str:
    """A table for notebooks: the exact motion, and a row for each approximation."""
    from lure.analysis.rod.comparison.result import ENERGIES, EVIDENCE

    first = found.exact.energy[0]
    kept = f"{found.exact.energy[-1] / first:.4g}" if first else "-"
    rows: list[tuple[object, ...]] = [("the rod itself, exact", "-", "-", "-", kept, len(found.contacts))]
    for row in found.rows:
        rows.append((row.label, *((row.refused, "-", "-", "-", "-") if row.refused else _cells(row, first))))
    head = ("motion of", "largest error of u(t, L) [m]", "L2 error [m]", "order", "energy kept", "contacts")
    notes = [text for text in (found.settling_statement, EVIDENCE, ENERGIES) if text]
    title = f"the end of the rod up to {found.until:g} s, amplitude {found.exact.amplitude:.4g} m"
    return html_table(title, rows, head=head, verdict="OBSERVED", notes=notes)


def _cells(row: Row, first: float) -> tuple[object, ...]:
    order = "-" if row.order is None or row.order.whole is None else f"{row.order.whole:.2f}"
    kept = "-" if row.energy_end is None or not first else f"{row.energy_end / first:.4g}"
    return f"{row.largest_error:.3g}", f"{row.l2_error:.3g}", order, kept, len(row.contacts)
