"""A loop's analysis as plain data, the ``loop`` part of ``report.json``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from analysis.doubles import json_number
from lure.rational import RationalBlock
from lure.state_space import StateSpaceBlock

if TYPE_CHECKING:
    from analysis.answers.subject import Subject
    from analysis.answers.table import LoopAnalysis
    from lure.law_class import LawClass


def analysis_dict(found: LoopAnalysis) -> dict[str, Any]:
    """The analysis as a dictionary of plain values; infinite numbers are the text ``inf``.

    Parameters
    ----------
    found : LoopAnalysis
        The analysis.
    """
    return {
        **_subject(found.subject),
        "case": found.case,
        "verdict": str(found.verdict),
        "evidence": str(found.evidence),
        "statement": found.statement,
        "headline": found.conclusion.headline,
        "meaning": found.conclusion.meaning,
        "law_class": found.conclusion.law_class,
        "membership": found.conclusion.membership,
        "attracts": found.conclusion.attracts,
        "reason": found.reason,
        "code": None if found.code is None else found.code.identifier,
        "gains": None if found.gains is None else [str(interval) for interval in found.gains],
        "answers": [row.to_dict() for row in found.rows],
        "hints": list(found.hints),
        "not_shown": list(found.not_shown),
        "stopped": found.stopped,
    }


def _subject(about: Subject) -> dict[str, Any]:
    block = about.block
    data: dict[str, Any] = {"text": str(block), "denominator": None}
    if isinstance(block, StateSpaceBlock):
        step = None if block.dt is None else str(block.dt)
        data |= {"numerator": None, "terms": None, "dt": step, "matrices": block.to_dict()}
        return {**_named(about), "block": data}
    data["denominator"] = [str(c) for c in block.denominator]
    if isinstance(block, RationalBlock):
        data |= {
            "numerator": [str(c) for c in block.numerator],
            "terms": None,
            "dt": None if block.dt is None else str(block.dt),
        }
    else:
        terms = [[str(delay), [str(c) for c in top]] for delay, top in block.terms]
        data |= {"numerator": None, "terms": terms, "dt": None}
    return {**_named(about), "block": data}


def _named(about: Subject) -> dict[str, Any]:
    return {
        "name": about.name,
        "title": about.title,
        "source": about.source,
        "law": None if about.law is None else str(about.law),
        "class": None if about.law_class is None else class_dict(about.law_class),
    }


def class_dict(law_class: LawClass) -> dict[str, Any]:
    """A class of laws as plain data.

    Parameters
    ----------
    law_class : LawClass
        The class.
    """
    slope = law_class.slope
    return {
        "sector": [json_number(float(law_class.sector.lower)), json_number(float(law_class.sector.upper))],
        "slope": None if slope is None else [json_number(float(slope.lower)), json_number(float(slope.upper))],
        "odd": law_class.odd,
        "time_varying": law_class.time_varying,
        "text": str(law_class),
    }
