"""The report as plain data: what goes into ``report.json`` and what the page prints."""

from __future__ import annotations

import hashlib
import json
from fractions import Fraction
from typing import TYPE_CHECKING

from lure.analysis.inequality.checks import CriterionResult
from lure.analysis.numerics.doubles import json_number
from lure.analysis.report.certificates import certificate_list
from lure.analysis.report.parts import SCHEMA, Json
from lure.analysis.rod.report.confirmed import confirmation_data
from lure.analysis.rod.report.model import StabilityReport
from lure.analysis.rod.simulation.trajectory import compared
from lure.analysis.verdict import Bracket
from lure.expressions.tree import decimal
from lure.rod.parameters import PARAMETERS
from lure.rod.systems import RodSystem

if TYPE_CHECKING:
    from lure.analysis.rod.simulation import Trajectory

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
        "response_check": {
            "frequencies": report.response.frequencies,
            "lowest": json_number(report.response.lowest),
            "highest": json_number(report.response.highest),
            "difference": json_number(report.response.difference),
            "skipped": report.response.skipped,
        },
        "simulation": _simulation(report),
        "confirmation": confirmation_data(report.confirmation),
        "reproduce": {"command": report.command, "inputs_sha256": inputs_sha256(system)},
        "versions": dict(report.versions),
    }


def exact_text(value: Fraction) -> str:
    """An exact rational as text: a decimal where one is exact, else ``p/q``.

    Parameters
    ----------
    value : Fraction
        The number.
    """
    return decimal(value) or str(value)


def inputs_sha256(system: Json) -> str:
    """Fingerprint of everything that was put in: parameters to the last digit, loads, initial data, discretisation.

    Parameters
    ----------
    system : dict
        The ``system`` part of the document.
    """
    inputs = {
        key: system[key]
        for key in ("kind", "parameters_exact", "scenario", "cells", "form", "until", "simulation_cells")
    }
    return hashlib.sha256(json.dumps(inputs, sort_keys=True).encode()).hexdigest()


def _system(report: StabilityReport) -> Json:
    system: RodSystem = report.system
    rod = system.rod
    return {
        "name": system.name,
        "title": system.title,
        "kind": "rod",
        "source": system.source,
        "parameters": {name: getattr(rod, name) for name in PARAMETERS},
        "parameters_exact": {name: exact_text(rod.exact[name]) for name in PARAMETERS},
        "derived": {
            "wave_speed": rod.wave_speed,
            "impedance": rod.impedance,
            "travel_time": rod.travel_time,
            "a": rod.reflection,
            "b": rod.input_gain,
            "d": rod.mobility,
        },
        "cells": system.cells,
        "form": system.form,
        "until": system.until,
        "simulation_cells": system.simulation_cells,
        "scenario": {
            "g": str(system.scenario.force),
            "f": str(system.scenario.body_force),
            "u0": str(system.scenario.displacement),
            "u1": str(system.scenario.velocity),
        },
        "matching": {"matched": report.matching.matched, "sentence": str(report.matching)},
    }


def _spectrum(report: StabilityReport) -> Json:
    found = report.spectrum
    return {
        "zero_multiplicity": found.zero_multiplicity,
        "residue_at_zero": json_number(found.residue_at_zero),
        "slowest_decay_rate": {"scheme": json_number(found.decay_scheme), "rod": json_number(found.decay_rod)},
        "first_elastic_mode": {"scheme": _pair(found.elastic_scheme), "rod": _pair(found.elastic_rod)},
        "jordan_size": found.jordan_size,
        "modes": [
            {
                "number": mode.number,
                "scheme": _pair(mode.scheme),
                "rod": _pair(mode.rod),
                "numerical_share": json_number(mode.numerical_share),
            }
            for mode in found.modes
        ],
    }


def _criterion(result: CriterionResult) -> Json:
    return {
        "name": result.name,
        "model": result.model,
        "sector": [json_number(float(result.sector.lower)), json_number(float(result.sector.upper))],
        "verdict": str(result.verdict),
        "evidence": str(result.evidence),
        "theta": json_number(result.theta),
        # the end that is safe to quote: a multiplier that works, a margin that is there
        "smallest_theta": json_number(result.smallest_theta.high) if result.smallest_theta else None,
        "smallest_theta_bracket": _bracket(result.smallest_theta),
        "margin": json_number(result.margin.low) if result.margin else None,
        "margin_bracket": _bracket(result.margin),
        "worst_frequency": json_number(result.worst_frequency),
        "largest_sector": _bracket(result.largest_sector),
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
        "law_class": found.found.law_class,
        "membership": found.found.membership,
        "reason": found.found.reason,
        "code": None if found.found.code is None else found.found.code.identifier,
        "stationary_set": found.stationary_set,
        "resting_place": found.resting_place,
        "assumptions": list(found.assumptions),
        "not_shown": list(found.not_shown),
        "proofs": [
            {
                "title": proof.title,
                "model": proof.model,
                "meaning": proof.meaning,
                "sector": proof.sector,
                "evidence": str(proof.evidence),
                "argument": proof.argument,
            }
            for proof in found.proofs
        ],
    }


def _simulation(report: StabilityReport) -> Json:
    run: Trajectory | None = report.simulation.trajectory
    contacts = () if run is None else run.contacts
    return {
        "cells": report.simulation.cells,
        "t_end": None if run is None else json_number(float(run.t[-1])),
        "max_gap_coordinate": None if run is None else json_number(run.max_gap_coordinate),
        "contact": None if run is None else bool(run.contact),
        "contact_count": None if run is None else len(contacts),
        "contacts": [
            {
                "start": json_number(contact.start),
                "end": json_number(contact.end),
                "peak_penetration": json_number(contact.peak_penetration),
                "impulse": json_number(contact.impulse),
                "open": contact.open,
            }
            for contact in contacts[:MOST_CONTACTS]
        ],
        "rest_position": None if run is None else json_number(run.rest_position),
        "rest_limit": None if run is None else json_number(run.rest_limit),
        "rest_is_final": None if run is None else run.rest_is_final,
        "energy_residual": None if run is None else json_number(run.energy_residual),
        "error_estimate": None if run is None else json_number(run.error_estimate),
        "method": None if run is None else run.method,
        "ended_early": None if run is None else run.ended_early,
        # a contradiction stops the report before this point
        "agrees": True if run is not None and compared(run) else None,
        "compared": [] if run is None else list(compared(run)),
        "skipped": report.simulation.skipped,
    }


def _pair(value: complex | None) -> list[float | str | None] | None:
    return None if value is None else [json_number(value.real), json_number(value.imag)]


def _bracket(bracket: Bracket | None) -> list[float | str | None] | None:
    return None if bracket is None else [json_number(bracket.low), json_number(bracket.high)]
