"""A Galerkin motion as a Dataset, plain data, a python-control response, an HTML table."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lure.record import html_table, plain
from lure.rod import datasets
from lure.rod.datasets import Column

if TYPE_CHECKING:
    import control
    import xarray

    from lure.rod.galerkin.error import Convergence
    from lure.rod.galerkin.motion import GalerkinRun
    from lure.rod.galerkin.spaces import NonuniformRod

_ROUNDING = 1e-9
SUBJECT, EVIDENCE = "Galerkin space", "observed"
NO_RATE = "Observed orders are what these runs show, in the family they were taken from; they prove no rate."


def about(run: GalerkinRun) -> str:
    """Which object moves, in words."""
    return f"the Galerkin space {run.model.space.name} of dimension {run.model.space.order}, not the rod"


def _method(run: GalerkinRun) -> str:
    kind = "cosine modes" if run.model.space.name == "cosine" else f"{run.model.space.name} elements"
    return f"weak form in {kind}, integrated by scipy's {run.method} between contacts and releases, located as events"


def _rod(rod: NonuniformRod) -> dict[str, object]:
    return {
        "length": rod.length,
        "area": str(rod.area),
        "youngs_modulus": str(rod.youngs_modulus),
        "density": str(rod.density),
        "damping": rod.damping,
        "compliance": 1.0 / rod.law.stiffness,
        "exponent": rod.law.exponent,
        "gap": rod.gap,
    }


def run_dataset(run: GalerkinRun) -> xarray.Dataset:
    """The Dataset of :meth:`lure.rod.galerkin.GalerkinRun.to_xarray`.

    Raises
    ------
    InputError
        xarray is not installed.
    """
    space = run.model.space
    v_0 = np.asarray(run.velocities @ space.left)
    variables = datasets.series(
        {
            "u_end": run.u_end,
            "z": run.z,
            "v_end": run.velocities @ space.right,
            "stress": run.contact_stress,
            "dashpot_force": run.model.rod.damping * v_0,
            "v_0": v_0,
            "energy": run.energy,
        }
    )
    of = ("t", "basis")
    variables |= {
        "coefficients": Column(of, run.coefficients, "m", "coefficients a of the displacement u_m = sum a_j w_j"),
        "velocities": Column(of, run.velocities, "m s-1", "coefficients b = a' of the velocity"),
        "dissipated": Column(("t",), run.dissipated, "J", "energy lost in the dashpot since the start"),
        "supplied": Column(("t",), run.supplied, "J", "work of the loads since the start"),
        "impulse": Column(("t",), run.impulse, "N s", "impulse A(L) int p dt given to the obstacle since the start"),
        "contact_start": Column(("contact",), [c.start for c in run.contacts], "s", "instant of contact"),
        "contact_end": Column(("contact",), [c.end for c in run.contacts], "s", "instant of release, or the end"),
    }
    if (bound := run.gronwall_bound) is not None:
        variables["energy_bound"] = Column(("t",), bound, "J", "bound of Lemma 3.2 on the energy, at the rate 1/s")
    coordinates = {
        "t": Column(("t",), run.t, "s", datasets.TIME),
        "basis": datasets.numbered("basis", space.order, f"number of the function w_j of the space {space.name}"),
        "contact": datasets.numbered("contact", len(run.contacts)),
    }
    if space.name != "cosine":
        nodes = np.linspace(0.0, space.length, space.order)
        coordinates["node"] = Column(("basis",), nodes, "m", "place of the node at which w_j is 1")
    title = "Motion in a Galerkin space"
    words = {"subject": SUBJECT, "about": about(run), "evidence": EVIDENCE, "method": _method(run)}
    attributes: dict[str, object] = {
        **datasets.motion_attributes(title, **words),
        **{f"rod_{name}": value for name, value in _rod(run.model.rod).items()},
        **{f"rod_{name}_units": unit for name, unit in datasets.UNITS.items()},
        **datasets.scenario_attributes(run.scenario),
        "energy_residual": run.energy_residual,
        "method_space": space.name,
        "method_order": space.order,
        "method_steps": run.steps,
    }
    if run.model.rod.law.exponent != 1.0:
        attributes["rod_compliance_units"] = f"m{run.model.rod.law.exponent:g} Pa-1"
    return datasets.dataset(variables, coordinates, attributes)


def within_bound(run: GalerkinRun) -> bool | None:
    """Whether the energy at the samples obeys the bound of Lemma 3.2, to rounding; None without a bound.

    At the start the two are equal.
    """
    bound, energy = run.gronwall_bound, run.energy
    if bound is None:
        return None
    return bool((energy <= bound + _ROUNDING * float(energy.max())).all())


def run_dict(run: GalerkinRun) -> dict[str, object]:
    """What is said of the motion, without the curves, as plain JSON data."""
    return {
        "subject": SUBJECT,
        "evidence": EVIDENCE,
        "space": run.model.space.name,
        "order": run.model.space.order,
        "rod": plain(_rod(run.model.rod)),
        "scenario": datasets.scenario_dict(run.scenario),
        "until": float(run.t[-1]),
        "samples": run.t.size,
        "contacts": [[touch.start, touch.end] for touch in run.contacts],
        "largest_z_at_samples": float(run.z.max()),
        "energy_start": float(run.energy[0]),
        "energy_end": float(run.energy[-1]),
        "energy_residual": run.energy_residual,
        "energy_within_bound": within_bound(run),
        "steps": run.steps,
        "method": _method(run),
        "comment": datasets.what_it_shows(SUBJECT, about(run), EVIDENCE),
    }


def run_response(run: GalerkinRun) -> control.TimeResponseData:
    """The python-control response of :meth:`lure.rod.galerkin.GalerkinRun.to_control`."""
    name = f"the Galerkin space {run.model.space.name} of dimension {run.model.space.order}"
    return datasets.loop_response(name, run.t, run.z, run.contact_stress, run.scenario.force(t=run.t))


def run_html(run: GalerkinRun) -> str:
    """A table for notebooks."""
    held = within_bound(run)
    said = "not claimed here" if held is None else "holds" if held else "VIOLATED"
    rows = [
        ("what moved", about(run)),
        ("time", f"0 s to {run.t[-1]:g} s, {run.t.size} samples"),
        ("force g(t) [N]", run.scenario.force),
        ("contacts", len(run.contacts) or "none"),
        ("largest z", f"{run.z.max():.9g} m, at the samples"),
        ("energy", f"{run.energy[0]:.6g} J at the start, {run.energy[-1]:.6g} J at the end"),
        ("energy identity", f"relative residual {run.energy_residual:.1g}"),
        ("bound of Lemma 3.2 at the samples", said),
    ]
    notes = (datasets.what_it_shows(SUBJECT, about(run), EVIDENCE),)
    return html_table(f"motion of u_m, {run.steps} steps of {run.method}", rows, verdict="OBSERVED", notes=notes)


def convergence_dataset(found: Convergence) -> xarray.Dataset:
    """The Dataset of :meth:`lure.rod.galerkin.Convergence.to_xarray`.

    Raises
    ------
    InputError
        xarray is not installed.
    """
    of, h1, l2 = ("width",), [error.h1 for error in found.errors], [error.l2 for error in found.errors]
    text = "observed order in {} against the next coarser space"
    variables = {
        "h1_error": Column(of, h1, "m0.5", "error of the displacement in a norm equivalent to that of H1"),
        "l2_error": Column(of, l2, "m1.5 s-1", "error of the velocity in L2"),
        "h1_order": Column(of, np.append(np.nan, found.h1_orders), "1", text.format("H1")),
        "l2_order": Column(of, np.append(np.nan, found.l2_orders), "1", text.format("L2")),
    }
    coordinates = {"width": Column(of, found.widths, "m", "element length h")}
    return datasets.dataset(variables, coordinates, {"evidence": EVIDENCE, "comment": NO_RATE})


def convergence_dict(found: Convergence) -> dict[str, object]:
    """Widths, errors and observed orders as plain JSON data."""
    return {
        "evidence": EVIDENCE,
        "widths": list(found.widths),
        "h1_errors": [error.h1 for error in found.errors],
        "l2_errors": [error.l2 for error in found.errors],
        "h1_orders": plain(found.h1_orders),
        "l2_orders": plain(found.l2_orders),
        "comment": NO_RATE,
    }


def convergence_html(found: Convergence) -> str:
    """A table for notebooks: a row for each space."""
    orders = [("", ""), *zip(found.h1_orders, found.l2_orders, strict=True)]
    rows = [
        (f"{width:.4g}", f"{error.h1:.3g}", _order(h1), f"{error.l2:.3g}", _order(l2))
        for width, error, (h1, l2) in zip(found.widths, found.errors, orders, strict=True)
    ]
    head = ("h [m]", "H1 error [m^0.5]", "order", "L2 error of the velocity [m^1.5/s]", "order")
    return html_table("errors of Galerkin spaces", rows, head=head, verdict="OBSERVED", notes=(NO_RATE,))


def _order(value: object) -> str:
    return f"{value:.3f}" if isinstance(value, float) else str(value)
