"""Bounds of a law, and points beyond them, as Datasets and HTML tables."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from analysis.bounds.result import as_double, short, stated
from analysis.evidence import Evidence
from lure.datasets import Column, dataset
from lure.showing import html_table

if TYPE_CHECKING:
    import xarray

    from analysis.bounds.result import Extreme, LawBounds
    from analysis.bounds.violating import Violation

_SIDES = ("sector_lower", "sector_upper", "slope_lower", "slope_upper")
_NOTHING = "A sample bounds nothing between its points."


def _domain(found: LawBounds) -> str:
    return "all real sigma" if found.on is None else f"sigma in [{short(found.on[0])}, {short(found.on[1])}]"


def _known(found: Extreme) -> str:
    return "exact" if found.exact else f"to within {found.gap:.1e}" if np.isfinite(found.gap) else "no bound is shown"


def bounds_dataset(found: LawBounds) -> xarray.Dataset:
    """The Dataset of :meth:`analysis.bounds.LawBounds.to_xarray`.

    Raises
    ------
    InputError
        xarray is not installed.
    """
    sides = [getattr(found, name) for name in _SIDES]
    unit, of = "unit of phi / unit of sigma", ("bound",)
    inner = [np.nan if side is None else as_double(side.inner) for side in sides]
    outer = [np.nan if side is None else as_double(side.outer) for side in sides]
    attained = [side is not None and side.attained for side in sides]
    at = np.array(["" if side is None else side.where for side in sides], dtype=object)
    variables = {
        "inner": Column(of, inner, unit, "what is reached or approached, nearest double; nan where nothing was shown"),
        "outer": Column(of, outer, unit, "what no value passes, nearest double; infinite for a sample"),
        "attained": Column(of, attained, "1", "whether it is known that the law takes the bound at a point"),
        "at": Column(of, at, "1", "where inner is reached or approached, in words"),
    }
    names = np.array(_SIDES, dtype=object)
    coordinates = {"bound": Column(of, names, "1", "of phi(sigma)/sigma, or of difference quotients")}
    attributes = {
        "law": found.law,
        "domain": _domain(found),
        "evidence": str(found.evidence),
        "assumptions": "; ".join(found.assumptions),
        "notes": "; ".join(found.notes),
        "comment": "Nearest doubles of the bounds; to_dict has the exact numbers, and sector and slope round outwards.",
    }
    return dataset(variables, coordinates, attributes)


def bounds_html(found: LawBounds) -> str:
    """A table for notebooks."""
    rows = []
    for name in _SIDES:
        side = getattr(found, name)
        label = name.replace("_", ", ")
        cells = ("not shown", "", "") if side is None else _cells(side)
        if side is not None and found.evidence is Evidence.CERTIFIED:
            cells = (stated(side, -1 if "lower" in name else 1, certified=True), *cells[1:])
        rows.append((label, *cells))
    given = [f"Assumed: {text}." for text in found.assumptions]
    sampled = [_NOTHING] if str(found.evidence) == "observed" else []
    head = ("bound", "value", "where", "known")
    title = f"{found.law}, {_domain(found)}"
    verdict = str(found.evidence).upper()
    return html_table(title, rows, head=head, verdict=verdict, notes=(*given, *found.notes, *sampled))


def _cells(side: Extreme) -> tuple[str, str, str]:
    return short(side.inner, digits=10), side.where, _known(side)


def extreme_html(found: Extreme) -> str:
    """A table for notebooks."""
    value, where, known = _cells(found)
    rows = [("value", value), ("where", where), ("known", known), ("attained", "yes" if found.attained else "no")]
    return html_table("least or largest value", rows)


def violation_html(found: Violation) -> str:
    """A table for notebooks."""
    ratio = "phi(sigma)/sigma" if found.quantity == "sector" else "(phi(x) - phi(y))/(x - y)"
    rows = [
        (ratio, short(found.value, digits=10)),
        ("bound", short(found.bound, digits=10)),
        ("at", ", ".join(short(point, digits=17) for point in found.points)),
        ("evidence", found.evidence),
    ]
    verdict = "REFUTED" if found.evidence is Evidence.CERTIFIED else "OBSERVED"
    return html_table(f"a {found.quantity} bound is passed", rows, verdict=verdict)
