"""From a loop to its report, and the files of that."""

from __future__ import annotations

import math
import os
import shlex
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from markupsafe import Markup

from lure.analysis.questions import analyse
from lure.analysis.questions.largest import UNFINISHED
from lure.analysis.report.diagram import block_diagram, class_graph, fits, nonlinearity_graph
from lure.analysis.report.html import glyphs, inline, lowered, prose, shown, template
from lure.analysis.report.loop.asked import answers
from lure.analysis.report.loop.figures import loop_figures
from lure.analysis.report.loop.model import LoopReport, balance_hints, loop_document, nonlinearity_text
from lure.analysis.report.loop.observed import observed
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
from lure.analysis.report.parts import LADDER, Figure, versions, write_files
from lure.analysis.report.pdf import embedded, printed_diagram
from lure.extensions import extension
from lure.files.system import LoopSystem

# From a loop to its report.

PACKAGES = ("numpy", "scipy", "control", "python-flint", "matplotlib", "jinja2")

Progress = Callable[[str, float], None]


def build_loop_report(
    system: LoopSystem,
    *,
    seconds: float | None = None,
    progress: Progress | None = None,
    command: str | None = None,
) -> LoopReport:
    """Everything the report says about a loop.

    Parameters
    ----------
    system : LoopSystem
        The loop.
    seconds : float or None
        Time allowed to the criteria and searches, and to each question asked beside them; simulations and
        drawings are not counted.
    progress : callable, optional
        Called as ``progress(stage, done)`` when a stage begins, with the share ``0 <= done <= 1`` of work behind it.
    command : str, optional
        The command that makes the report again; by default ``lure report`` and the name of the system.

    Raises
    ------
    AssumptionError
        Nothing certified can be said of such a block.
    ContradictionError
        A simulation contradicts what is proved.
    """
    say = progress or (lambda _stage, _done: None)
    told_of = answers(system, seconds)  # first, so that a question which has no answer is refused at once
    found = analyse(system, seconds=seconds, progress=lambda stage, done: say(stage, 0.8 * done))
    say("simulation", 0.8)
    seen = observed(found)
    told = extension("beyond", system.approximates)
    beyond, shown = ("", ()) if told is None else told(system.approximates)
    follow = extension("beyond, followed", system.approximates)
    beyond_observed, beyond_figures = ((), ()) if follow is None else follow(system.approximates)
    return LoopReport(
        analysis=found,
        observed=seen.sentences,
        trajectories=seen.trajectories,
        hints=balance_hints(found.problem),
        beyond=beyond,
        beyond_shown=shown,
        asked=told_of,
        beyond_observed=beyond_observed,
        beyond_figures=beyond_figures,
        command=command or f"lure report {shlex.quote(system.name)}",
        versions=versions(*PACKAGES),
    )


# The files of a report on a loop.

Data = dict[str, Any]

_WIDE = 30.0  # beyond this ratio of its numbers a bar is logarithmic
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
    data, drawn = loop_document(report), loop_figures(report)
    page = partial(loop_page, data, drawn, loop_diagram(report))
    return write_files(data, page, drawn, report.certificates, directory, pdf=pdf)


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


# The bar of a class: how far it is proved, from where it is refuted, what is open, and what was asked.


@dataclass(frozen=True, kw_only=True, slots=True)
class Bar:
    """One class as a bar, in percent of its width.

    Attributes
    ----------
    name : str
        The class.
    key : str
        Where its numbers stand in the document.
    row : dict
        Its numbers.
    pieces : tuple of (str, float)
        ``proved``, ``open`` or ``refuted``, and the width of that piece.
    asked : float or None
        Place of the upper end that was asked about.
    logarithmic : bool
        Whether equal steps are equal ratios.
    """

    name: str
    key: str
    row: Data
    pieces: tuple[tuple[str, float], ...]
    asked: float | None
    logarithmic: bool


def bar(name: str, key: str, row: Data, asked: float | None) -> Bar:
    """The bar of one row of the table.

    Parameters
    ----------
    name : str
        The class.
    key : str
        Where the row stands in the document.
    row : dict
        One of the document's ``answers``.
    asked : float or None
        The upper end asked about.
    """
    start, proved, refuted = float(row["lower"]), _proved(row), math.inf
    if row["verdict"] == "REFUTED":
        refuted = start
    elif row["refuted_at"] is not None:
        refuted = proved if row["gap"].startswith("closed") else float(row["refuted_at"])
    inner = [value for value in (proved, refuted, asked) if value is not None and start < value < math.inf]
    end = 1.25 * max(inner) if start == 0 and inner else start + 1.25 * ((max(inner, default=start + 1.0)) - start)
    wide = start == 0 and bool(inner) and end > _WIDE * min(inner)
    first = 0.4 * min(inner) if wide else start

    def place(value: float) -> float:
        """Where a number stands, in percent."""
        inside = min(max(value, first), end)
        share = math.log(inside / first) / math.log(end / first) if wide else (inside - first) / (end - first)
        return 100.0 * share

    marks = [("proved", place(proved)), ("open", place(min(max(refuted, proved), end))), ("refuted", 100.0)]
    pieces, before = [], 0.0
    for kind, until in marks:
        if until > before:
            pieces.append((kind, until - before))
            before = until
    at = None if asked is None else place(asked)
    return Bar(name=name, key=key, row=row, pieces=tuple(pieces), asked=at, logarithmic=wide)


def _proved(row: Data) -> float:
    return float(row["largest"][0]) if row["verdict"] == "PROVED" else float(row["lower"])


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
        From :func:`lure.analysis.report.loop.model.loop_document`.
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
