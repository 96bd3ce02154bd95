"""The reproduction as files: figures, a page and JSON."""

from __future__ import annotations

import base64
import json
from importlib import resources
from pathlib import Path

from lure.analysis.plots.style import Picture, render
from lure.analysis.rod.paper.figures import PaperFigure, paper_figures
from lure.analysis.rod.paper.model import TITLES, PaperTable
from lure.analysis.rod.paper.runs import FORCED, PaperRuns


def write_paper(table: PaperTable, runs: PaperRuns, directory: Path) -> None:
    """Write ``paper.html``, ``paper.json`` and ``figures/`` into a directory, made if missing.

    Parameters
    ----------
    table : PaperTable
        The claims.
    runs : PaperRuns
        The motions behind the figures.
    directory : Path
        Where to write.  Files of these names are replaced; for all or nothing write inside
        :func:`lure.analysis.output.replaced`.
    """
    drawn = [(figure, render(figure.draw, name=figure.name)) for figure in paper_figures(runs)]
    folder = directory / "figures"
    folder.mkdir(parents=True, exist_ok=True)
    for figure, picture in drawn:
        (folder / f"{figure.name}.svg").write_text(picture.svg, encoding="utf-8")
        (folder / f"{figure.name}.png").write_bytes(picture.png)
    text = json.dumps(table.to_dict(), indent=2, allow_nan=False)
    (directory / "paper.json").write_text(text + "\n", encoding="utf-8")
    (directory / "paper.html").write_text(paper_page(table, drawn), encoding="utf-8")


def paper_page(table: PaperTable, drawn: list[tuple[PaperFigure, Picture]]) -> str:
    """The reproduction as one page of HTML: offline, without scripts, in the style of the report.

    Parameters
    ----------
    table : PaperTable
        The claims.
    drawn : list of (PaperFigure, Picture)
        The figures, in order.
    """
    from jinja2 import Environment, StrictUndefined

    style = resources.files("lure.analysis.report").joinpath("style.css").read_text("utf-8")
    template = resources.files("lure.analysis.rod.paper").joinpath("paper.html.j2").read_text("utf-8")
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    peaks = [
        (title, [table.peak(figure, variant) for figure in FORCED])
        for variant, title in TITLES.items()
        if any(peak.variant == variant for peak in table.peaks)
    ]
    return environment.from_string(template).render(
        style=style,
        claims=table.claims,
        survivors=sum(claim.survives for claim in table.claims),
        numbers=FORCED,
        peaks=peaks,
        settling=table.settling,
        figures=[(figure, _embedded(picture)) for figure, picture in drawn],
    )


def _embedded(picture: Picture) -> str:
    return "data:image/svg+xml;base64," + base64.b64encode(picture.svg.encode()).decode()
