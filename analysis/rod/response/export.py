"""Long runs, sweeps and resting places as Datasets and HTML tables."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lure.record import html_table
from lure.rod import datasets
from lure.rod.datasets import Array, Column

if TYPE_CHECKING:
    import xarray

    from lure.analysis.rod.response.basin import Basin
    from lure.analysis.rod.response.model import Response
    from lure.analysis.rod.response.sweeping import Bifurcation, Sweep

_LISTED = 40
_WATCHED = "motion of the rod itself from one start, watched for a finite time; it proves nothing of others"


def response_dataset(found: Response) -> xarray.Dataset:
    """The Dataset of :meth:`lure.analysis.rod.response.Response.to_xarray`.

    Raises
    ------
    InputError
        xarray is not installed.
    """
    starts, ends = ([contact[i] for contact in found.contacts] for i in (0, 1))
    spectrum = found.spectrum
    variables = {
        "z": Column(("t",), found.z, "m", "contact coordinate u(t, L) - gap"),
        "v": Column(("t",), found.v, "m s-1", "velocity z' of the end x = L"),
        "poincare_z": Column(("period",), found.poincare[:, 0], "m", "z at whole periods of the load"),
        "poincare_v": Column(("period",), found.poincare[:, 1], "m s-1", "z' at whole periods of the load"),
        "amplitude": Column(("frequency",), spectrum.amplitude, "m", "amplitude of z; at 0 the mean"),
        "phase": Column(("frequency",), spectrum.phase, "rad", "phase of z, t = 0 at the start of the motion"),
        "contact_start": Column(("contact",), starts, "s", "instant of contact, cut to the watch"),
        "contact_end": Column(("contact",), ends, "s", "instant of release, cut to the watch"),
        "impulse": Column(("hit",), found.impact_impulses, "N s", "impulse of a contact inside the watch"),
    }
    coordinates = {
        "t": Column(("t",), found.t, "s", datasets.TIME),
        "period": datasets.numbered("period", len(found.poincare), "number of the stroboscopic point"),
        "frequency": Column(("frequency",), spectrum.frequency, "Hz", "frequency"),
        "contact": datasets.numbered("contact", len(found.contacts)),
        "hit": datasets.numbered("hit", found.impact_impulses.size, "number of the finished contact, in order"),
    }
    attributes = {
        "subject": "rod",
        "evidence": str(found.evidence),
        "comment": f"A {_WATCHED}.",
        "regime": found.regime.kind,
        "period": found.period,
        "period_units": "s",
        "period_source": found.period_source,
        "energy_residual": found.energy_residual,
        "error_estimate": found.error,
        "error_estimate_units": "m",
        **datasets.rod_attributes(found.rod),
        **datasets.scenario_attributes(found.scenario),
    }
    return datasets.dataset(variables, coordinates, attributes)


def response_html(found: Response) -> str:
    """A table for notebooks."""
    hits = found.impulses
    rows: list[tuple[str, object]] = [
        ("what moved", "the rod itself"),
        ("force g(t) [N]", found.scenario.force),
        ("period", f"{found.period:.6g} s ({found.period_source})"),
        ("waited", found.settling),
        ("seen", found.regime),
        ("transients", found.transients),
        ("in contact", f"{100 * found.duty:.4g} % of the time, {hits.per_period:.4g} impacts a period"),
    ]
    if hits.count:
        rows.append(("peak stress of these impacts", f"{hits.peak_stress:.4g} Pa"))
    if found.balance is not None:
        rows.append(("momentum left per period", f"{found.balance.left:.3g} N s"))
    if found.separation is not None:
        rows.append(("nearby motions", found.separation))
    rows.append(("energy balance", f"relative residual {found.energy_residual:.1g}"))
    return html_table("response of the rod to a periodic load", rows, verdict="OBSERVED", notes=(f"One {_WATCHED}.",))


def bifurcation_dataset(found: Bifurcation) -> xarray.Dataset:
    """The Dataset of :meth:`lure.analysis.rod.response.Bifurcation.to_xarray`.

    Raises
    ------
    InputError
        xarray is not installed.
    """
    points, of = found.points, ("value",)
    longest = max((len(point.poincare) for point in points), default=0)
    strobe = np.full((len(points), longest, 2), np.nan)
    for i, point in enumerate(points):
        strobe[i, : len(point.poincare)] = point.poincare
    multiples = [np.nan if point.multiple is None else point.multiple for point in points]
    both = ("value", "period")
    variables = {
        "poincare_z": Column(both, strobe[:, :, 0], "m", "z at whole periods of the force; nan beyond the last"),
        "poincare_v": Column(both, strobe[:, :, 1], "m s-1", "z' at whole periods of the force; nan beyond the last"),
        "multiple": Column(of, multiples, "1", "periods of the force in a repetition; nan if none was seen"),
        "duty": Column(of, [point.duty for point in points], "1", "share of time in contact"),
        "impacts": Column(of, [point.impacts for point in points], "1", "impacts that begin, per period of the force"),
        "peak_stress": Column(of, [point.peak_stress for point in points], "Pa", "largest stress of these impacts"),
        "regime": Column(of, _texts([point.regime for point in points]), "1", "kind of motion seen"),
        "transients": Column(of, _texts([point.trend for point in points]), "1", "whether it was still changing"),
        "problem": Column(of, _texts([point.problem for point in points]), "1", "why it could not be followed"),
    }
    unit = datasets.UNITS.get(found.parameter, "unit of the symbol in the force")
    coordinates = {
        "value": Column(of, [point.value for point in points], unit, f"parameter {found.parameter}"),
        "period": datasets.numbered("period", longest, "number of the stroboscopic point"),
    }
    attributes = {
        "subject": "rod",
        "evidence": str(found.evidence),
        "comment": "At each value one motion of the rod itself from one start; nothing is said between the values.",
        "parameter": found.parameter,
        "force_g": found.force,
        "order": found.order,
        "complete": int(found.complete),
    }
    return datasets.dataset(variables, coordinates, attributes)


def _texts(values: list[str]) -> np.ndarray[tuple[int], np.dtype[np.object_]]:
    return np.array(values, dtype=object)


def bifurcation_html(found: Bifurcation) -> str:
    """A table for notebooks: a row for each value, up to forty of them."""
    points = found.points
    step = max(1, -(-len(points) // _LISTED))
    rows = [
        (
            f"{point.value:.6g}",
            point.problem or point.regime,
            "-" if point.multiple is None else point.multiple,
            f"{100 * point.duty:.3g} %",
            f"{point.impacts:.3g}",
            f"{point.peak_stress:.4g}" if point.impacts > 0 else "-",
        )
        for point in points[::step]
    ]
    head = (found.parameter, "seen", "repeats after", "in contact", "impacts a period", "peak stress of these [Pa]")
    notes = [] if step == 1 else [f"Shown is one value in {step}."]
    title = f"response of the rod itself against {found.parameter}, g = {found.force}"
    return html_table(title, rows, head=head, verdict="OBSERVED", notes=(*notes, *str(found).split("\n")))


def sweep_html(sweep: Sweep) -> str:
    """A table for notebooks: what is asked for."""
    rows = [("order", sweep.order), ("plan", sweep.plan), ("processes", sweep.workers)]
    return html_table("how a parameter is varied", rows, notes=("A request: nothing was computed yet.",))


def basin_dataset(found: Basin) -> xarray.Dataset:
    """The Dataset of :meth:`lure.analysis.rod.response.Basin.to_xarray`.

    Raises
    ------
    InputError
        xarray is not installed.
    """
    of = ("velocity", "offset")
    variables = {
        "rest_low": Column(of, found.low, "m", "lower bound of the resting place z; nan where nothing was computed"),
        "rest_high": Column(of, found.high, "m", "upper bound of the resting place z; nan where nothing was computed"),
        "impacts": Column(of, found.impacts, "1", "number of impacts; -1 where nothing was computed"),
        "settled": Column(of, found.settled, "1", "whether it is shown that no contact follows"),
        "known": Column(of, found.known, "1", "whether the bounds agree to 1e-9 of the largest |z|"),
    }
    coordinates = {
        "velocity": Column(("velocity",), _array(found.velocities), "m s-1", "velocity added to the initial data"),
        "offset": Column(("offset",), _array(found.offsets), "m", "displacement added to the initial data"),
    }
    attributes = {
        "subject": "rod",
        "evidence": str(found.evidence),
        "comment": "Resting places of the rod itself from these initial data; nothing is said between them.",
        "complete": int(found.complete),
    }
    return datasets.dataset(variables, coordinates, attributes)


def _array(values: tuple[float, ...]) -> Array:
    return np.array(values, dtype=float)


def basin_html(found: Basin) -> str:
    """A table for notebooks."""
    done = found.impacts >= 0
    rows: list[tuple[str, object]] = [
        ("what moved", "the rod itself"),
        ("initial data", f"{len(found.offsets)} displacements, {len(found.velocities)} velocities"),
        ("motions followed", f"{int(done.sum())} of {done.size}"),
        ("resting places known", int(found.known.sum())),
        ("no contact to come", int(found.settled.sum())),
    ]
    if done.any():
        rows.append(("resting places", f"z = {np.nanmin(found.low):.6g} m to {np.nanmax(found.high):.6g} m"))
        rows.append(("impacts", f"up to {int(found.impacts.max())}"))
    notes = ("Of the rod itself, from these initial data only.",)
    return html_table("resting places of the rod", rows, verdict="COMPUTED", notes=notes)
