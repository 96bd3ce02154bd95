"""The files of a report on a loop."""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path
from typing import Any

from analysis.report.document import to_json
from analysis.report.figures import Figure
from analysis.report.html import glyphs, inline, shown, template
from analysis.report.loop.document import loop_document
from analysis.report.loop.figures import loop_figures
from analysis.report.loop.model import LoopReport

_CLASSES = {
    ("sector", False, True): "sector, time-varying",
    ("sector", False, False): "sector, time-invariant",
    ("slope", False, False): "slope",
    ("slope", True, False): "slope, odd",
}


def write_loop_report(report: LoopReport, directory: str | os.PathLike[str]) -> Path:
    """Write ``report.html``, ``report.json`` and ``figures/`` into a directory, made if it is missing.

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
    target = Path(directory)
    (target / "figures").mkdir(parents=True, exist_ok=True)
    for figure in drawn:
        (target / "figures" / f"{figure.spec.name}.svg").write_text(figure.picture.svg, encoding="utf-8")
        (target / "figures" / f"{figure.spec.name}.png").write_bytes(figure.picture.png)
    for name, text in texts.items():
        (target / name).write_text(text, encoding="utf-8")
    return target / "report.html"


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
        names=[_CLASSES[row["question"], row["odd"], row["time_varying"]] for row in data["answers"]],
        figures=figures,
        inline=inline,
        glyphs=glyphs(figures),
        criteria=_criteria(data),
    )


def _criteria(data: dict[str, Any]) -> list[dict[str, Any]]:
    """Each criterion once, with its key in the document, whichever rows of the table repeat it."""
    seen: dict[tuple[str, str], dict[str, Any]] = {}
    for i, row in enumerate(data["answers"]):
        for j, answer in enumerate(row["answers"]):
            odd = row["odd"] and answer["criterion"] == "zames-falb"
            name = f"{answer['criterion']}{', odd laws' if odd else ''}"
            seen.setdefault((name, str(row["lower"])), {"name": name, "key": f"answers.{i}.answers.{j}", **answer})
    return list(seen.values())
