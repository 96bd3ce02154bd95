"""From a loop to its report, the words of its page, and the files of that."""

from __future__ import annotations

import math
import os
import shlex
from collections.abc import Callable
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

from markupsafe import Markup

from lure.analysis.numerics.doubles import bound_above, bound_below
from lure.analysis.questions import analyse
from lure.analysis.questions.largest import UNFINISHED
from lure.analysis.questions.proofs import NOT_NEEDED, REFUSED
from lure.analysis.report.diagram import block_diagram, class_graph, fits, nonlinearity_graph
from lure.analysis.report.html import glyphs, inline, lowered, prose, shown, template
from lure.analysis.report.loop.asked import answers
from lure.analysis.report.loop.figures import loop_figures
from lure.analysis.report.loop.model import LoopReport, balance_hints, nonlinearity_text
from lure.analysis.report.loop.observed import observed
from lure.analysis.report.parts import LADDER, Figure, versions, write_files
from lure.analysis.report.pdf import embedded, printed_diagram
from lure.extensions import extension
from lure.files.system import LoopSystem
from lure.record import described, quantity

# The words of the page on a loop: headline, classes, criteria and counterexamples.


def own(data: Data) -> bool:
    """Whether the verdict is on the nonlinearity that was given: PROVED, its class checked, nothing assumed."""
    conclusion = data["conclusion"]
    return (
        data["system"]["law"] is not None
        and conclusion["verdict"] == "PROVED"
        and conclusion["membership"] == "checked"
        and not conclusion["assumed"]
    )


def headline(data: Data) -> str:
    """The verdict in a sentence, without how it was found; after the name of the nonlinearity what is proved of it."""
    conclusion = data["conclusion"]
    return str(conclusion["meaning"] if own(data) else conclusion["headline"])


def explanation(data: Data) -> str:
    """What the statement says after its headline; empty if that is all of it."""
    conclusion = data["conclusion"]
    rest: str = conclusion["statement"][len(conclusion["headline"]) - 1 :].lstrip(",:;. ")
    if rest.startswith("(certified)"):
        return rest.replace("(certified)", "Certified", 1)
    return "by " + rest[1:].replace(")", "", 1) if rest.startswith("(") else rest


def open_questions(data: Data) -> list[str]:
    """What is not decided, and what would decide it."""
    conclusion, rows = data["conclusion"], data["answers"]
    if conclusion["hints"]:
        return list(conclusion["hints"])
    if conclusion["verdict"] == "REFUTED":
        return ["a smaller class: the table says how far each kind is proved"]
    if data["system"]["class"] is not None or "classes" in data["system"]:
        proved = conclusion["verdict"] == "PROVED"
        return ["nothing: the question asked is decided" if proved else "nothing that these criteria know of"]
    gaps = [f"{class_words(row)}: nothing is known {_gap(row)}" for row in rows if row["gap"] == "open"]
    return gaps or ["nothing: every gap is closed"]


def _gap(row: Data) -> str:
    """Where between its two numbers a row of the table is silent."""
    start, end = row["proved_text"] or bound_below(_size(row["lower"])), row["refuted_text"]
    return f"between {start} and {end}" if end else f"above {start}"


def class_words(row: Data, *, inwards: bool = True) -> str:
    """The classes of one row of the table, such as ``odd, slope in [0, k]``.

    ``row``: one of the document's ``answers``.  ``inwards``: whether the lower end is rounded into the classes, as for
    what is proved; else out of them, as for a member.
    """
    if "classes" in row:
        return f"{row['classes']['text']}; upper bounds times k"
    lower, short = (bound_above if inwards else bound_below)(row["lower"]), f"{row['lower']:.6g}"
    lower = short if float(short) == row["lower"] else lower
    if row["question"] == "sector":
        return f"sector [{lower}, k]{', time-varying' if row['time_varying'] else ''}"
    return f"slope in [{lower}, k]{', odd' if row['odd'] else ''}"


def asked_about(row: Data, system: Data) -> bool:
    """Whether the row is of the kind of the class asked about, with several channels about these classes.

    ``row``: one of the document's ``answers``; ``system``: the document's ``system``.
    """
    if "classes" in system:
        return bool(row["classes"] == system["classes"])
    nonlinearity_class = system["class"]
    if nonlinearity_class is None:
        return False
    if nonlinearity_class["time_varying"] or nonlinearity_class["slope"] is None:
        return bool(row["question"] == "sector" and row["time_varying"] == nonlinearity_class["time_varying"])
    return bool(row["question"] == "slope" and row["odd"] == nonlinearity_class["odd"])


def reason(data: Data) -> str:
    """Why nothing was proved of the class asked about, where the statement does not say it; empty elsewhere."""
    conclusion, rows = data["conclusion"], data["answers"]
    if conclusion["verdict"] == "PROVED":
        return ""
    asked = [row for row in rows if asked_about(row, data["system"])] or rows
    why: str = asked[0]["reason"]
    if data["system"]["law"] is not None:  # what can be done for it stands among the hints
        why = why.partition("; give ")[0]
    return why if why and why not in conclusion["statement"] and asked[0]["verdict"] != "PROVED" else ""


def criteria(data: Data) -> list[Data]:
    """Each criterion once for each kind of class it was asked about with different results, and its key.

    Criteria that proved nothing for one and the same reason are one entry.  One that only some classes do not need is
    there with what it said of the others.
    """
    seen: dict[str, Data] = {}
    for i, row in enumerate(data["answers"]):
        for j, answer in enumerate(row["answers"]):
            odd = row["odd"] and "odd" in answer["needs"]
            name = f"{answer['criterion']}{', odd nonlinearities' if odd else ''}"
            proved = answer["verdict"] == "PROVED"
            same = repr(
                (
                    name if proved or answer["theorem"] not in (REFUSED, NOT_NEEDED) else "",
                    answer["largest"],
                    answer["reason"],
                )
            )
            entry = seen.setdefault(same, {"names": [], "key": f"answers.{i}.answers.{j}", **answer})
            entry["names"] += [] if name in entry["names"] else [name]
    needless = [entry for entry in seen.values() if entry["theorem"] == NOT_NEEDED]
    told = {name for entry in seen.values() if entry not in needless for name in entry["names"]}
    for entry in needless:
        entry["names"] = [name for name in entry["names"] if name not in told]
    shown = [entry for entry in seen.values() if entry["names"]]
    for entry in shown:  # one that proves no more than is proved may prove the class asked about all the same
        least = "nothing more proved" if " proves more than " in entry["reason"] else "nothing proved"
        entry["unproved"] = NOT_NEEDED if entry["theorem"] == NOT_NEEDED else least
    return sorted(shown, key=lambda answer: (answer["verdict"] != "PROVED", -_size(answer["largest"][0])))


def counterexamples(data: Data) -> list[Data]:
    """Each destabilising nonlinearity once, with the classes it belongs to and what there is to see of it."""
    seen: dict[str, Data] = {}
    for row in data["answers"]:
        both = [one for one in (row["trivial"], row["witness"]) if one is not None]
        for witness in both:
            quoted = row["refuted_text"] if witness is both[0] else bound_above(float(witness["k"]))
            entry = seen.setdefault(
                repr((witness["kind"], witness["description"])),
                {**witness, "quoted": quoted, "classes": [], "details": _details(witness["data"])},
            )
            entry["classes"].append(class_words(row, inwards=False))
    return sorted(seen.values(), key=lambda witness: _size(witness["k"]))


_SHOWN = (
    ("points", "φ through (σ, φ)"),
    ("sigma", "σ repeats"),
    ("u", "μ repeats"),
    ("gains", "gains in turn"),
    ("times", "each for so long [s]"),
)
_LISTED = 12
_LONG = 14


def _details(data: Data) -> list[tuple[str, str]]:
    """What a reader can look at, lists cut after a dozen entries."""
    return [(name, _listed(data[key])) for key, name in _SHOWN if isinstance(data.get(key), list)]


def _listed(values: list[object]) -> str:
    shown = [f"({', '.join(map(_short, entry))})" if isinstance(entry, list) else _short(entry) for entry in values]
    more = f", … ({len(values)} in all)" if len(values) > _LISTED else ""
    return ", ".join(shown[:_LISTED]) + more


def _short(value: object) -> str:
    """A number exactly if that is short, else to nine digits."""
    text = str(value)
    return f"{float(Fraction(text)):.9g}" if len(text) > _LONG else text


def _size(value: float | str) -> float:
    return float(value)


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
    data, drawn = report.to_dict(), loop_figures(report)
    page = partial(loop_page, data, drawn, loop_diagram(report))
    return write_files(data, page, drawn, report.certificates, directory, pdf=pdf)


def loop_diagram(report: LoopReport) -> Markup:
    """The block diagram of a loop, with its nonlinearity or the class asked about."""
    about = report.analysis.problem
    if about.several:
        channels = len(about.classes.classes)
        words = f"φ₁, {'… ' * (channels > 2)}φ{lowered(str(channels))}" if channels > 1 else "φ₁"
        return block_diagram("H", words, class_graph(about.classes.classes[0]))
    graph = class_graph(about.given) if about.nonlinearity is None else nonlinearity_graph(about.nonlinearity)
    text = nonlinearity_text(about.nonlinearity) if about.nonlinearity is not None else str(about.given or "phi")
    return block_diagram(str(about.plant), prose(text), graph)


# The bar of a class: how far it is proved, from where it is refuted, what is open, and what was asked.


@described(frozen=True, kw_only=True, slots=True)
class Bar:
    """One class as a bar, in percent of its width."""

    name: str = quantity("The class")
    key: str = quantity("Where its numbers stand in the document")
    row: Data = quantity("Its numbers")
    pieces: tuple[tuple[str, float], ...] = quantity("``proved``, ``open`` or ``refuted``, and the width of that piece")
    asked: float | None = quantity("Place of the upper end that was asked about")
    logarithmic: bool = quantity("Whether equal steps are equal ratios")


def bar(name: str, key: str, row: Data, asked: float | None) -> Bar:
    """The bar of one row of the table.

    ``name``: the class; ``key``: where the row stands in the document; ``row``: one of the document's ``answers``;
    ``asked``: the upper end asked about.
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
        From :meth:`lure.analysis.report.loop.model.LoopReport.to_dict`.
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
