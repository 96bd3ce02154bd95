"""The files of a report on a loop."""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path
from typing import Any

from analysis.report.certificates import certificate_files
from analysis.report.claims import LADDER
from analysis.report.document import to_json
from analysis.report.figures import Figure
from analysis.report.html import glyphs, inline, shown, template
from analysis.report.loop.document import loop_document
from analysis.report.loop.figures import loop_figures
from analysis.report.loop.model import LoopReport
from analysis.report.loop.words import (
    asked_about,
    class_words,
    counterexamples,
    criteria,
    explanation,
    headline,
    open_questions,
)
from analysis.report.write import write_files

_LAW_ROWS = (("sector", "sector"), ("slope", "slope"), ("odd", "odd"), ("regularity", "regularity"))


def write_loop_report(report: LoopReport, directory: str | os.PathLike[str]) -> Path:
    """Write ``report.html``, ``report.json``, ``certificates/`` and ``figures/`` into a directory, made if missing.

    Parameters
    ----------
    report : LoopReport
        The report.
    directory : path
        Where to write; files of the same names are overwritten.

    Returns
    -------
    Path
        The page, ``report.html``.
    """
    data, drawn = loop_document(report), loop_figures(report)
    texts = {"report.json": to_json(data), "report.html": loop_page(data, drawn)}
    texts |= certificate_files(report.analysis.certificates)
    return write_files(texts, drawn, directory)


def loop_page(data: dict[str, Any], figures: tuple[Figure, ...]) -> str:
    """The page for a document.

    Parameters
    ----------
    data : dict
        From :func:`analysis.report.loop.document.loop_document`.
    figures : tuple of Figure
        Figures, in order.
    """
    return template("loop/loop.html.j2").render(
        d=data,
        n=partial(shown, data),
        headline=headline(data),
        explanation=explanation(data),
        open_questions=open_questions(data),
        endless=all(row["verdict"] == "PROVED" and row["largest"][0] == "inf" for row in data["answers"]),
        names=[class_words(row) for row in data["answers"]],
        asked=[asked_about(row, data["system"]["class"]) for row in data["answers"]],
        figures=figures,
        inline=inline,
        glyphs=glyphs(figures),
        criteria=criteria(data),
        counterexamples=counterexamples(data),
        law_rows=_LAW_ROWS,
        ladder=LADDER,
    )
