"""Measurements, their sector and the fitted law as Datasets and HTML tables."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from lure.analysis.numerics.doubles import text_above, text_below
from lure.record import html_table
from lure.rod.datasets import Column, dataset

if TYPE_CHECKING:
    import xarray

    from lure.analysis.measured.compliance_fit import ComplianceFit
    from lure.analysis.measured.margin import MeasuredMargin
    from lure.analysis.measured.measured_sector import MeasuredSector, Outlier
    from lure.analysis.measured.measurements import Measurements
    from lure.analysis.measured.report import MeasuredReport

_SIDES = ("lower", "upper", "slope_lower", "slope_upper")
_SHOWN = 8


def _rows(data: Measurements) -> tuple[dict[str, Column], dict[str, Column]]:
    """Variables and coordinates of the rows."""
    of = ("row",)
    branch = np.full(len(data), "", dtype=object)
    for part in data.branches:
        branch[part.start : part.stop] = part.direction
    variables = {
        "displacement": Column(
            of, data.displacement, data.displacement_unit, "displacement u, positive towards the obstacle"
        ),
        "load": Column(of, data.load, data.unit, "load, positive in compression"),
        "line": Column(of, data.lines, "1", "line of the file, from 1"),
        "branch": Column(of, branch, "1", "loading or unloading; empty where the rows form no branches"),
    }
    return variables, {"row": Column(of, np.arange(len(data)), "1", "row, from 0")}


def _source(data: Measurements) -> dict[str, object]:
    return {"source": data.source, "columns": ", ".join(data.columns), "notes": "; ".join(data.notes)}


def measurements_dataset(data: Measurements) -> xarray.Dataset:
    """The Dataset of :meth:`lure.analysis.measured.Measurements.to_xarray`.

    Raises
    ------
    InputError
        xarray is not installed.
    """
    return dataset(*_rows(data), {"title": "Measured law", "evidence": "observed", **_source(data)})


def measurements_html(data: Measurements) -> str:
    """A table for notebooks."""
    u, p, branches = data.displacement, data.load, data.branches
    rows = [
        ("rows", len(data)),
        ("columns", ", ".join(data.columns)),
        ("displacement", f"{u.min():.4g} to {u.max():.4g} {data.displacement_unit}"),
        ("load", f"{p.min():.4g} {data.unit} to {p.max():.4g} {data.unit}"),
        ("branches", ", ".join(b.direction for b in branches[:_SHOWN]) or "one sweep, or in no order"),
    ]
    return html_table(f"measurements from {data.source}", rows, verdict="OBSERVED", notes=data.notes)


def _mean(found: MeasuredSector) -> dict[str, Column]:
    """The mean law at the rows, its standard error and the residuals; nan on rows of the other branch."""
    data = found.measurements
    rows = [np.arange(len(data))] if found.memoryless else [data.rows("loading"), data.rows("unloading")]
    values = {name: np.full(len(data), np.nan) for name in ("mean", "error", "score")}
    for law, part in zip(found.laws, rows, strict=True):
        sigma = data.displacement[part] - found.origin
        values["mean"][part], values["error"][part], values["score"][part] = law(sigma), law.error(sigma), law.scores
    outlier = np.zeros(len(data), dtype=bool)
    outlier[[o.index for o in found.outliers]] = True
    of = ("row",)
    return {
        "sigma": Column(of, data.displacement - found.origin, data.displacement_unit, "displacement less the origin"),
        "mean": Column(of, values["mean"], data.unit, "fitted mean law, of the branch where there are two"),
        "error": Column(of, values["error"], data.unit, "standard error of the mean law, for one place alone"),
        "score": Column(of, values["score"], "1", "residual in standard deviations"),
        "outlier": Column(of, outlier, "1", "whether the row was left out"),
    }


def sector_dataset(found: MeasuredSector) -> xarray.Dataset:
    """The Dataset of :meth:`lure.analysis.measured.MeasuredSector.to_xarray`.

    Raises
    ------
    InputError
        xarray is not installed.
    """
    variables, coordinates = _rows(found.measurements)
    variables |= _mean(found)
    of, unit = ("bound",), found.measurements.stiffness_unit
    sides = [getattr(found, name) for name in _SIDES]
    variables |= {
        "limit": Column(of, [side.bound for side in sides], unit, "bound on chords or slopes of the mean law"),
        "fitted": Column(of, [side.fitted for side in sides], unit, "extreme of the fitted law"),
        "limit_at": Column(
            of, [side.at for side in sides], found.measurements.displacement_unit, "sigma that sets the bound"
        ),
    }
    names = np.array(_SIDES, dtype=object)
    coordinates["bound"] = Column(of, names, "1", "of f(sigma)/sigma, or of the slope")
    return dataset(variables, coordinates, _sector_attributes(found))


def _sector_attributes(found: MeasuredSector) -> dict[str, object]:
    return {
        "title": "Sector of a measured law",
        "evidence": str(found.evidence),
        "comment": found.conclusion,
        "confidence": found.confidence if found.stated else "none is stated",
        "origin": found.origin,
        "origin_units": found.measurements.displacement_unit,
        "assumptions": "; ".join(found.assumptions),
        "warnings": "; ".join(found.warnings),
        "memoryless": int(found.memoryless),
        **_source(found.measurements),
    }


def sector_html(found: MeasuredSector) -> str:
    """A table for notebooks: the four bounds, and on what they rest."""
    from lure.analysis.measured.measured_sector import MEMORY, TO_TRY

    unit = found.measurements.stiffness_unit
    rows = [
        (
            name.replace("_", ", "),
            _rounded(name, side.bound),
            f"{side.fitted:.6g}",
            f"{side.at:.4g} {found.measurements.displacement_unit}",
        )
        for name, side in ((name, getattr(found, name)) for name in _SIDES)
    ]
    head = ("bound", f"{found.how_sure} [{unit}]", f"of the fitted law [{unit}]", "set at sigma")
    notes = [found.conclusion, *([MEMORY, TO_TRY] if found.hysteresis else []), *found.warnings]
    notes += [f"Outliers, left out: {_listed(found.outliers)}."] if found.outliers else []
    notes += [f"Assumed: {text}." for text in found.assumptions]
    return html_table(f"sector of {found.measurements.source}", rows, head=head, verdict="OBSERVED", notes=notes)


def _rounded(name: str, bound: float) -> str:
    return text_below(bound, 6) if name.endswith("lower") else text_above(bound, 6)


def _listed(outliers: tuple[Outlier, ...]) -> str:
    shown = ", ".join(f"line {o.line} ({o.score:+.1f} deviations)" for o in outliers[:_SHOWN])
    return shown + (f", ... ({len(outliers)} in all)" if len(outliers) > _SHOWN else "")


def _fit_columns(found: ComplianceFit) -> tuple[dict[str, Column], dict[str, Column]]:
    """The rows with the fitted load, and the three parameters, which have units of their own."""
    data = found.measurements
    variables, coordinates = _rows(data)
    variables["fitted_load"] = Column(("row",), found(data.displacement), data.unit, "load of the fitted law")
    variables["fit_score"] = Column(("row",), found.scores, "1", "residual of the fit in standard deviations")
    exponent = found.parameters["m"].value
    units = {"eps": f"m{exponent:.6g} {data.unit}-1", "gap": "m", "m": "1"}
    for name, parameter in found.parameters.items():
        unit = units[name]
        variables[f"fit_{name}"] = Column((), parameter.value, unit, f"fitted {name} of max(u - gap, 0)^m / eps")
        error = f"standard uncertainty of {name}, linearised"
        variables[f"fit_{name}_error"] = Column((), parameter.error, unit, error)
        text = f"interval of {name} with all three inside at once"
        variables[f"fit_{name}_joint"] = Column(("end",), parameter.joint, unit, text)
    names = np.array(["log eps", "gap", "m"], dtype=object)
    of = ("parameter", "parameter_")
    variables["correlation"] = Column(of, found.correlation, "1", "correlation of log eps, gap and m, linearised")
    coordinates |= {
        "end": Column(("end",), np.array(["low", "high"], dtype=object), "1", "end of an interval"),
        **{dim: Column((dim,), names, "1", "parameter of the law") for dim in of},
    }
    return variables, coordinates


def fit_dataset(found: ComplianceFit) -> xarray.Dataset:
    """The Dataset of :meth:`lure.analysis.measured.ComplianceFit.to_xarray`.

    Raises
    ------
    InputError
        xarray is not installed.
    """
    attributes = {
        "title": "Normal compliance fitted to measurements",
        "evidence": str(found.evidence),
        "comment": found.conclusion,
        "confidence": found.confidence,
        "warnings": "; ".join(found.warnings),
        **_source(found.measurements),
    }
    return dataset(*_fit_columns(found), attributes)


def fit_html(found: ComplianceFit) -> str:
    """A table for notebooks: the three parameters with their intervals."""
    units = {"eps": f"m^m/{found.measurements.unit}", "gap": "m", "m": "1"}
    rows = [
        (f"{name} [{units[name]}]", f"{p.value:.6g}", f"{p.error:.2g}", _span(p.single), _span(p.joint))
        for name, p in found.parameters.items()
    ]
    head = ("parameter", "value", "uncertainty", "interval, alone", "interval, all three at once")
    notes = [found.conclusion, *found.warnings]
    notes += [f"Outliers, left out: {_listed(found.outliers)}."] if found.outliers else []
    title = "p = max(u - gap, 0)^m / eps, fitted"
    return html_table(title, rows, head=head, verdict="OBSERVED", notes=notes)


def _span(ends: tuple[float, float]) -> str:
    return f"[{ends[0]:.5g}, {ends[1]:.5g}]"


def margin_html(found: MeasuredMargin) -> str:
    """A table for notebooks: the measured sector beside the proved one."""
    margin = "any amount" if math.isinf(found.margin) else f"{100 * found.margin:.3g} %"
    rows = [
        ("measured, times gain", _outwards(float(found.sector.lower), float(found.sector.upper)), found.evidence),
        ("proved stable", _inwards(found), found.proved.evidence),
        ("room above the measured one", margin if found.inside else "-", ""),
    ]
    head = ("sector", "", "evidence")
    verdict = "INSIDE" if found.inside else "NOTHING FOLLOWS"
    return html_table(
        "measured sector beside the proved one", rows, head=head, verdict=verdict, notes=(found.conclusion,)
    )


def _outwards(low: float, high: float) -> str:
    return f"[{text_below(low, 6)}, {text_above(high, 6)}]"


def _inwards(found: MeasuredMargin) -> str:
    return f"[{text_above(float(found.proved.lower), 6)}, {text_below(found.proved.largest.low, 6)}]"


def report_dataset(found: MeasuredReport) -> xarray.Dataset:
    """The Dataset of a :class:`.MeasuredReport`: the sector's, with the fit where there is one.

    Raises
    ------
    InputError
        xarray is not installed.
    """
    whole = sector_dataset(found.sector)
    if found.fit is None:
        return whole
    fitted = fit_dataset(found.fit)
    if found.fit.branch is not None:  # rows of one branch only
        fitted = fitted.rename({"row": "fit_row", "displacement": "fit_displacement", "load": "fit_load"})
        fitted = fitted.drop_vars(["line", "branch"])
    merged: xarray.Dataset = whole.merge(fitted, combine_attrs="override", compat="equals")
    return merged.assign_attrs(fit_comment=found.fit.conclusion)


def report_html(found: MeasuredReport) -> str:
    """Tables for notebooks: the data, the sector, the fit."""
    parts = [measurements_html(found.measurements), sector_html(found.sector)]
    return "\n".join([*parts, fit_html(found.fit)] if found.fit else parts)
