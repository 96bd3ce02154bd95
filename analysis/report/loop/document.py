"""The report on a loop as plain data: what goes into ``report.json`` and what the page prints."""

from __future__ import annotations

import hashlib
import json
from typing import Any

from analysis.answers.document import analysis_dict
from analysis.report.loop.model import LoopReport
from analysis.report.model import SCHEMA


def loop_document(report: LoopReport) -> dict[str, Any]:
    """``report.json`` as a dictionary of plain values, described by ``schema.json`` of :mod:`analysis.report`.

    Parameters
    ----------
    report : LoopReport
        The report.
    """
    found = analysis_dict(report.analysis)
    keys = ("name", "title", "source", "block", "case", "law", "class")
    system = {"kind": "loop", **{key: found[key] for key in keys}}
    return {
        "schema": SCHEMA,
        "system": system,
        "conclusion": {key: found[key] for key in ("verdict", "evidence", "statement", "hints", "not_shown")},
        "gains": found["gains"],
        "answers": found["answers"],
        "observed": list(report.observed),
        "hints": list(report.hints),
        "reproduce": {"command": report.command, "inputs_sha256": inputs_sha256(system)},
        "versions": dict(report.versions),
    }


def inputs_sha256(system: dict[str, Any]) -> str:
    """Fingerprint of everything that was put in: the block to the last digit, the law, the class.

    Parameters
    ----------
    system : dict
        The ``system`` part of the document.
    """
    inputs = {key: system[key] for key in ("kind", "block", "law", "class")}
    return hashlib.sha256(json.dumps(inputs, sort_keys=True).encode()).hexdigest()
