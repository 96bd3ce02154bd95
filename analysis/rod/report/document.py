"""The report as plain data, what goes into ``report.json`` and what the page prints; and in a dozen lines of text."""

from __future__ import annotations

import hashlib
import json
import math
import textwrap
from fractions import Fraction
from typing import TYPE_CHECKING

from lure.analysis.numerics.evidence import ends
from lure.analysis.report.parts import SCHEMA, Json, certificate_list
from lure.analysis.rod.confirmation import Confirmation, Side
from lure.analysis.rod.confirmation.result import Quantity
from lure.analysis.rod.simulation.trajectory import compared
from lure.analysis.verdict import CriterionResult
from lure.expressions.tree import decimal
from lure.plants.multivariable import counted
from lure.record import plain
from lure.record.base import aligned
from lure.rod.datasets import number_of_contacts
from lure.rod.parameters import PARAMETERS
from lure.rod.systems import RodSystem

if TYPE_CHECKING:
    from lure.analysis.rod.report.model import StabilityReport
    from lure.analysis.rod.simulation import Trajectory

# The confirmation of a report as plain data and in words.

_UNDER_LOAD = (
    "under load nothing is claimed of energy, Lyapunov function or zeta, since the load feeds energy in; what is "
    "checked is the balance of the energy"
)


def confirmation_data(found: Confirmation) -> Json:
    """The ``confirmation`` part of ``report.json``; ``found``: the two motions."""
    return {
        "kind": found.kind,
        "sentence": confirmation_sentence(found),
        "rod": _side(found.rod),
        "scheme": _side(found.scheme),
        "rod_skipped": found.rod_skipped,
        "scheme_skipped": found.scheme_skipped,
        "agrees": found.agrees,
        "compared": list(found.compared),
    }


_QUANTITY = {"start": "start", "end": "end", "residual": "against", "rounding": "allowance"}
_SIDE = {"contact_count": "contacts", "max_gap_coordinate": "highest", "energy_residual": "energy_residual"}


def _of(record: object, *names: str, **others: str) -> Json | None:
    """Plain data of some fields of an object, each under its name or another; None of none."""
    keys = {**dict(zip(names, names, strict=True)), **others}
    return None if record is None else {key: plain(getattr(record, name)) for key, name in keys.items()}


def _side(side: Side | None) -> Json | None:
    if side is None:
        return None
    return {
        **(_of(side, "model", "until", **_SIDE) or {}),
        "energy": _of(side.energy, **_QUANTITY),
        "lyapunov": _of(side.lyapunov, **_QUANTITY),
        "lyapunov_theta": plain(side.lyapunov_theta),
        "zeta": _of(side.zeta, **_QUANTITY),
        "momentum_residual": plain(side.momentum),
        "rest": _of(side.rest, "predicted", "shown", "at", "way", "difference", rounding="allowance", agrees="agrees"),
        "open_end": side.open_end,
    }


def confirmation_sentence(found: Confirmation) -> str:
    """What the two motions show, without a full stop."""
    if found.rod is None:
        return f"the rod was not followed: {found.rod_skipped}"
    rod, scheme = found.rod, found.scheme
    models = "exact motions of the rod and of its scheme" if scheme is not None else "exact motion of the rod"
    if not found.compared:
        return f"{models}: at rest throughout, which tests nothing"
    followed = f"{models}, the rod up to {rod.until:.4g} s ({number_of_contacts(rod.contacts)})"
    if found.kind == "load":
        sides = (rod,) if scheme is None else (rod, scheme)
        within = ", ".join(f"{side.model.split(',')[0]} within {_order(side.energy_residual)}" for side in sides)
        return f"{followed}; {_UNDER_LOAD} ({within})"
    assert rod.energy is not None
    if found.kind == "growth":
        return (
            f"{followed}; the energy of the rod does not fall from sample to sample, and grows from "
            f"{rod.energy.start:.3g} J{_growth(rod.energy)}"
        )
    if found.kind == "undamped":
        kept = f"the energy of the rod stays {rod.energy.start:.3g} J within {_order(rod.energy.against)}"
        return f"{followed}; {kept}{_scheme_loss(scheme)}"
    return f"{followed}; energy, Lyapunov function and zeta do not rise from sample to sample; {_rests(found)}"


def _growth(energy: Quantity) -> str:
    """By how much, or to what: two numbers that look alike show no growth."""
    share = energy.end / energy.start - 1.0 if energy.start > 0.0 else 1.0
    return f" by {100.0 * share:.3g} %" if share < 1.0 else f" to {energy.end:.3g} J"


def _order(value: float) -> str:
    """A relative error as a power of ten that is not exceeded, no finer than rounding."""
    for exponent in range(-14, 0):
        if value <= 10.0**exponent:
            return f"1e{exponent}"
    return f"{math.ceil(10.0 * value) / 10.0:.2g}"


def _scheme_loss(scheme: Side | None) -> str:
    if scheme is None or scheme.energy is None or scheme.energy.start <= 0.0:
        return ""
    left = scheme.energy.end / scheme.energy.start
    return f", its waves persist; the scheme keeps {left:.2g} of it, since its damping is numerical"


def _rests(found: Confirmation) -> str:
    sides = [side for side in (found.rod, found.scheme) if side is not None]
    settled = [(side.model.split(",")[0], side.rest) for side in sides if side.rest is not None]
    if not settled:
        of = "neither was" if len(sides) > 1 else "it was not"
        return f"{of} followed to a resting place: contact is going on or can still come"
    places = ", ".join(f"{name} at z = {rest.predicted:.9g} m" for name, rest in settled)
    if all(rest.agrees for _, rest in settled):
        return f"the resting place predicted from momentum ({places}) is the one shown, to 1e-9 of the largest |z|"
    worst = max(rest.difference for _, rest in settled)
    return f"the resting place predicted from momentum ({places}) is shown to {worst:.1g} of the largest |z| only"


# The report in a dozen lines of plain text, for the terminal.

_WIDTH = 80
_HEAD = ("criterion", "model", "verdict", "evidence", "theta", "margin", "largest k")


def summary(report: StabilityReport) -> str:
    """Verdict, conclusion, criteria, spectrum and motions, at most 80 columns wide."""
    reasons = dict.fromkeys(
        f"In the {result.model}, {result.reason}" for result in report.criteria if result.theta is None
    )
    blocks = [
        f"{report.verdict}  {report.system.name}",
        _filled(report.conclusion.statement),
        _filled(f"Criteria for the sector {report.criteria[0].sector} Pa/m; theta in s, margin in m/Pa, k in Pa/m")
        + "\n"
        + "\n".join(aligned([_HEAD, *(_row(result) for result in report.criteria)])),
        *(_filled(f"{reason}.") for reason in reasons),
        _filled(f"Spectrum: {report.spectrum}."),
        _filled(f"Simulation: {_simulated(report)}."),
        _filled(f"Confirmation: {confirmation_sentence(report.confirmation)}."),
    ]
    return "\n\n".join(blocks)


def _filled(text: str) -> str:
    return textwrap.fill(text, _WIDTH, break_on_hyphens=False)  # names such as rod-energy stay whole


def _row(result: CriterionResult) -> tuple[str, ...]:
    brackets = () if result.margin is None else (result.margin, result.largest)
    numbers = [result.theta, *(bracket.low for bracket in brackets if bracket is not None)]
    return (
        result.criterion,
        result.model,
        str(result.verdict),
        str(result.evidence_shown or "-"),
        *(f"{value:.4g}" for value in numbers if value is not None),
    )


def _simulated(report: StabilityReport) -> str:
    run = report.simulation.trajectory
    if run is None:
        return f"skipped, {report.simulation.skipped}"
    count = len(run.contacts)
    touches = f"{count} contact interval{'s' if count != 1 else ''}" if run.contact else "no contact"
    return (
        f"{counted(run.cells, 'cell')} up to {float(run.t[-1]):.4g} s, {touches}, largest z "
        f"{run.max_gap_coordinate:.6g} m, energy identity within {run.energy_residual:.1e}; compared with the theory: "
        + (", ".join(compared(run)) or "nothing, the rod stays at rest")
    )


MOST_CONTACTS = 1000


def document(report: StabilityReport) -> Json:
    """``report.json`` as a dictionary of plain values, described by ``schema.json`` of :mod:`lure.analysis.report`.

    Infinite numbers are the strings ``"inf"`` and ``"-inf"``, what is missing is None; there is no NaN.

    Parameters
    ----------
    report : StabilityReport
        The report.
    """
    system = _system(report)
    return {
        "schema": SCHEMA,
        "system": system,
        "spectrum": _spectrum(report),
        "criteria": [_criterion(result) for result in report.criteria],
        "conclusion": _conclusion(report),
        "certificates": certificate_list(report.certificates),
        "response_check": _of(report.response, "frequencies", "lowest", "highest", "difference", "skipped"),
        "simulation": _simulation(report),
        "confirmation": confirmation_data(report.confirmation),
        "reproduce": {"command": report.command, "inputs_sha256": inputs_sha256(system)},
        "versions": dict(report.versions),
    }


def exact_text(value: Fraction) -> str:
    """An exact rational as text: a decimal where one is exact, else ``p/q``.

    ``value``: the number.
    """
    return decimal(value) or str(value)


def inputs_sha256(system: Json) -> str:
    """Fingerprint of everything that was put in: parameters to the last digit, loads, initial data, discretisation.

    ``system``: the ``system`` part of the document.
    """
    inputs = {
        key: system[key]
        for key in ("kind", "parameters_exact", "intervals", "scenario", "cells", "form", "until", "simulation_cells")
        if key in system
    }
    return hashlib.sha256(json.dumps(inputs, sort_keys=True).encode()).hexdigest()


def _system(report: StabilityReport) -> Json:
    system: RodSystem = report.system
    rod = system.rod
    intervals = {name: [exact_text(end) for end in ends] for name, ends in system.intervals.items()}
    return {
        "name": system.name,
        "title": system.title,
        "kind": "rod",
        "source": system.source,
        "parameters": {name: getattr(rod, name) for name in PARAMETERS},
        "parameters_exact": {name: exact_text(rod.exact[name]) for name in PARAMETERS},
        **({"intervals": intervals} if intervals else {}),
        "derived": _of(rod, "wave_speed", "impedance", "travel_time", a="reflection", b="input_gain", d="mobility"),
        "cells": system.cells,
        "form": system.form,
        "until": system.until,
        "simulation_cells": system.simulation_cells,
        "scenario": _of(system.scenario, g="force", f="body_force", u0="displacement", u1="velocity"),
        "matching": {"matched": report.matching.matched, "sentence": str(report.matching)},
    }


def _spectrum(report: StabilityReport) -> Json:
    found = report.spectrum
    return {
        "zero_multiplicity": found.zero_multiplicity,
        "residue_at_zero": plain(found.residue_at_zero),
        "slowest_decay_rate": {"scheme": plain(found.decay_scheme), "rod": plain(found.decay_rod)},
        "first_elastic_mode": {"scheme": plain(found.elastic_scheme), "rod": plain(found.elastic_rod)},
        "jordan_size": found.jordan_size,
        "modes": [_of(mode, "number", "scheme", "rod", "numerical_share") for mode in found.modes],
    }


def _criterion(result: CriterionResult) -> Json:
    return {
        "name": result.criterion,
        "model": result.model,
        "sector": [plain(float(result.sector.lower)), plain(float(result.sector.upper))],
        "verdict": str(result.verdict),
        "evidence": str(result.evidence),
        "theta": plain(result.theta),
        # the end that is safe to quote: a multiplier that works, a margin that is there
        "smallest_theta": plain(result.smallest_theta.high) if result.smallest_theta else None,
        "smallest_theta_bracket": ends(result.smallest_theta),
        "margin": plain(result.margin.low) if result.margin else None,
        "margin_bracket": ends(result.margin),
        "worst_frequency": plain(result.worst_frequency),
        "largest_sector": None if result.margin is None else ends(result.largest),
        "reason": result.reason,
        "hypotheses": list(result.hypotheses),
        "witness": result.witness,
    }


def _conclusion(report: StabilityReport) -> Json:
    found = report.conclusion
    return {
        "verdict": str(found.verdict),
        "headline": found.headline,
        "statement": found.statement,
        "law_class": found.found.nonlinearity_class,
        "membership": found.found.membership,
        "reason": found.found.reason,
        "code": None if found.found.code is None else found.found.code.identifier,
        "stationary_set": found.stationary_set,
        "resting_place": found.resting_place,
        "assumptions": list(found.assumptions),
        "not_shown": list(found.not_shown),
        "proofs": plain(found.proofs),
    }


def _simulation(report: StabilityReport) -> Json:
    run: Trajectory | None = report.simulation.trajectory
    contacts = () if run is None else run.contacts
    return {
        "cells": report.simulation.cells,
        "t_end": None if run is None else plain(float(run.t[-1])),
        "max_gap_coordinate": None if run is None else plain(run.max_gap_coordinate),
        "contact": None if run is None else bool(run.contact),
        "contact_count": None if run is None else len(contacts),
        "contacts": [
            _of(contact, "start", "end", "peak_penetration", "impulse", "open") for contact in contacts[:MOST_CONTACTS]
        ],
        "rest_position": None if run is None else plain(run.rest_position),
        "rest_limit": None if run is None else plain(run.rest_limit),
        "rest_is_final": None if run is None else run.rest_is_final,
        "energy_residual": None if run is None else plain(run.energy_residual),
        "error_estimate": None if run is None else plain(run.error_estimate),
        "method": None if run is None else run.method,
        "ended_early": None if run is None else run.ended_early,
        # a contradiction stops the report before this point
        "agrees": True if run is not None and compared(run) else None,
        "compared": [] if run is None else list(compared(run)),
        "skipped": report.simulation.skipped,
    }
