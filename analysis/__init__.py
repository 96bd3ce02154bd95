"""What can be said about a Lur'e loop, by what means, and with which margin."""

from __future__ import annotations

from typing import TYPE_CHECKING

from analysis.handing_out import handing_out

if TYPE_CHECKING:
    from analysis.answers import Largest as Largest
    from analysis.answers import LoopAnalysis as LoopAnalysis
    from analysis.answers import analyse as analyse
    from analysis.answers import max_sector as max_sector
    from analysis.answers import max_slope as max_slope
    from analysis.bounds import LawBounds as LawBounds
    from analysis.bounds import law_bounds as law_bounds
    from analysis.certificates.certify import certify as certify
    from analysis.certificates.checker import Proved as Proved
    from analysis.certificates.checker import Refuted as Refuted
    from analysis.certificates.checker import check as check
    from analysis.comparison import compare as compare
    from analysis.criteria.describing import describing_hint as describing_hint
    from analysis.criteria.describing_function import describing_function as describing_function
    from analysis.criteria.passivity import passivity_indices as passivity_indices
    from analysis.evidence import Bracket as Bracket
    from analysis.evidence import Evidence as Evidence
    from analysis.evidence import Verdict as Verdict
    from analysis.graphical import NyquistResponse as NyquistResponse
    from analysis.graphical import PopovResponse as PopovResponse
    from analysis.graphical import nyquist_response as nyquist_response
    from analysis.graphical import popov_response as popov_response
    from analysis.measured import Measurements as Measurements
    from analysis.measured import example_measurements as example_measurements
    from analysis.measured import fit_compliance as fit_compliance
    from analysis.measured import margin_of as margin_of
    from analysis.measured import read_measurements as read_measurements
    from analysis.measured import report_of as report_of
    from analysis.measured import sector_of as sector_of
    from analysis.report import report_on as report_on
    from analysis.response import basin as basin
    from analysis.response import bifurcation as bifurcation
    from analysis.response import resting_place as resting_place
    from analysis.simulation import simulate as simulate

_HOMES = {
    "Largest": "answers",
    "LoopAnalysis": "answers",
    "analyse": "answers",
    "max_sector": "answers",
    "max_slope": "answers",
    "LawBounds": "bounds",
    "law_bounds": "bounds",
    "certify": "certificates.certify",
    "Proved": "certificates.checker",
    "Refuted": "certificates.checker",
    "check": "certificates.checker",
    "compare": "comparison",
    "describing_function": "criteria.describing_function",
    "describing_hint": "criteria.describing",
    "passivity_indices": "criteria.passivity",
    "Bracket": "evidence",
    "Evidence": "evidence",
    "Verdict": "evidence",
    "NyquistResponse": "graphical",
    "PopovResponse": "graphical",
    "nyquist_response": "graphical",
    "popov_response": "graphical",
    "Measurements": "measured",
    "example_measurements": "measured",
    "fit_compliance": "measured",
    "margin_of": "measured",
    "read_measurements": "measured",
    "report_of": "measured",
    "sector_of": "measured",
    "report_on": "report",
    "basin": "response",
    "bifurcation": "response",
    "resting_place": "response",
    "simulate": "simulation",
}

__all__ = [*_HOMES]
__getattr__, __dir__ = handing_out(__name__, _HOMES)  # `lure --help` does not wait for them
