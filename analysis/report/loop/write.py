"""The files of a report on a loop."""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path
from typing import Any

from markupsafe import Markup

from lure.analysis.questions.largest import UNFINISHED
from lure.analysis.report.certificates import certificate_files
from lure.analysis.report.diagram import block_diagram, class_graph, fits, nonlinearity_graph
from lure.analysis.report.html import glyphs, inline, lowered, prose, shown, template
from lure.analysis.report.loop.bars import Bar, bar
from lure.analysis.report.loop.document import loop_document, nonlinearity_text
from lure.analysis.report.loop.figures import loop_figures
from lure.analysis.report.loop.model import LoopReport
from lure.analysis.report.loop.words import (
    asked_about,
    class_words,
    counterexamples,
    criteria,
    explanation,
    headline,
    open_questions,
    own,
    reason,
)
from lure.analysis.report.parts import LADDER, Figure, to_json, write_files
from lure.analysis.report.pdf import embedded, pdf_of, printed_diagram

Data = dict[str, Any]

_LAW_ROWS = (("sector", "sector"), ("slope", "slope"), ("odd", "odd"), ("regularity", "regularity"))


def write_loop_report(report: LoopReport, directory: str | os.PathLike[str], *, pdf: bool = False) -> Path:
    """Write ``report.html``, ``report.json``, ``certificates/`` and ``figures/`` into a directory, made if missing.

    Parameters
    ----------
    report : LoopReport
        The report.
    directory : path
        Where to write; files of the same names are overwritten.
    pdf : bool
        Whether to write ``report.pdf`` too.

    Returns
    -------
    Path
        The page, ``report.html``.

    Raises
    ------
    InputError
        A PDF is asked for, and weasyprint is not installed.
    """
    data, drawn, diagram = loop_document(report), loop_figures(report), loop_diagram(report)
    texts = {"report.json": to_json(data), "report.html": loop_page(data, drawn, diagram)}
    texts |= certificate_files(report.certificates)
    printed = pdf_of(loop_page(data, drawn, diagram, paper=True)) if pdf else None
    return write_files(texts, drawn, directory, printed=printed)


def loop_diagram(report: LoopReport) -> Markup:
    """The block diagram of a loop, with its nonlinearity or the class asked about.

    Parameters
    ----------
    report : LoopReport
        The report.
    """
    about = report.analysis.problem
    if about.several:
        channels = len(about.classes.classes)
        words = f"φ₁, {'… ' * (channels > 2)}φ{lowered(str(channels))}" if channels > 1 else "φ₁"
        return block_diagram("H", words, class_graph(about.classes.classes[0]))
    graph = class_graph(about.given) if about.nonlinearity is None else nonlinearity_graph(about.nonlinearity)
    text = nonlinearity_text(about.nonlinearity) if about.nonlinearity is not None else str(about.given or "phi")
    return block_diagram(str(about.plant), prose(text), graph)


def _bars(data: Data) -> list[Bar]:
    """The bar of the class asked about; without one a bar for each class, one for those of the same numbers."""
    system, found = data["system"], dict[tuple[object, ...], Bar]()
    every = system["class"] is None and "classes" not in system
    for i, row in enumerate(data["answers"]):
        if every or asked_about(row, system):
            end = None if every else 1.0 if "classes" in system else float(system["class"][row["question"]][1])
            same = found.get((row["proved_text"], row["refuted_text"]))
            name = class_words(row) if same is None else f"{same.name}; {class_words(row)}"
            found[row["proved_text"], row["refuted_text"]] = bar(name, f"answers.{i}", row, end)
    return list(found.values())


def loop_page(data: Data, figures: tuple[Figure, ...], diagram: Markup, *, paper: bool = False) -> str:
    """The page for a document.

    Parameters
    ----------
    data : dict
        From :func:`lure.analysis.report.loop.document.loop_document`.
    figures : tuple of Figure
        Figures, in order.
    diagram : Markup
        From :func:`loop_diagram`.
    paper : bool
        Whether the page is for :func:`lure.analysis.report.pdf.pdf_of`: figures are images then.
    """
    bars = _bars(data)
    return template("loop.html.j2", __package__).render(
        d=data,
        several="channels" in data["system"],
        n=partial(shown, data),
        own=own(data),
        headline=headline(data),
        explanation=explanation(data),
        reason=reason(data),
        unfinished=UNFINISHED,
        diagram=printed_diagram(diagram) if paper else diagram,
        fits=fits(data["system"]["block"]["text"]),
        bars=bars,
        asked_end=f"{bars[0].row['question']}.1",
        open_questions=open_questions(data),
        endless=all(row["verdict"] == "PROVED" and row["largest"][0] == "inf" for row in data["answers"]),
        names=[class_words(row) for row in data["answers"]],
        asked=[asked_about(row, data["system"]) for row in data["answers"]],
        figures=figures,
        inline=embedded if paper else inline,
        glyphs="" if paper else glyphs(figures),
        criteria=criteria(data),
        counterexamples=counterexamples(data),
        nonlinearity_rows=_LAW_ROWS,
        ladder=LADDER,
    )
