"""What the reports on loops and on rods have in common: figures, claims, files."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Protocol

from lure.analysis.plots import Draw, Picture
from lure.analysis.verdict import Verdict

SCHEMA = "lure-report/1"
Json = dict[str, Any]
Section = Literal["asked", "frequency", "criteria", "spectrum", "confirmation", "simulation"]
LADDER = (
    ("certified", "exact or ball arithmetic over the whole claim, or a proof from exact hypotheses"),
    ("computed", "floating point, compared with a second computation"),
    ("observed", "one motion, of the rod or of its scheme; it can contradict a claim, never prove one"),
)


class Report(Protocol):
    """A report on whatever it is; ``str`` is what the command prints."""

    @property
    def verdict(self) -> Verdict:
        """The verdict, which decides the exit status of the command."""

    def to_dict(self) -> dict[str, Any]:
        """``report.json`` as plain data."""


class ContradictionError(RuntimeError):
    """A motion contradicts a verdict: one of the two is wrong, and no report is written."""


@dataclass(frozen=True, kw_only=True, slots=True)
class FigureSpec:
    """One figure before it is drawn.

    Attributes
    ----------
    name : str
        File name without its ending.
    section : {"asked", "frequency", "criteria", "spectrum", "confirmation", "simulation"}
        Where it stands in the report.
    title : str
        A few words above it.
    caption : str
        What to look at.
    draw : callable
        Draws on the axes it is given.
    """

    name: str
    section: Section
    title: str
    caption: str
    draw: Draw


@dataclass(frozen=True, kw_only=True, slots=True)
class Figure:
    """One figure, drawn."""

    spec: FigureSpec
    picture: Picture


def to_json(data: Json) -> str:
    """``data`` as text; a NaN or an infinity in it is an error, not a token.

    Parameters
    ----------
    data : dict
        From :func:`document`.
    """
    return json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def write_files(
    texts: Mapping[str, str],
    drawn: tuple[Figure, ...],
    directory: str | os.PathLike[str],
    *,
    printed: bytes | None = None,
) -> Path:
    """Write texts by name, and figures into ``figures/``; the page is ``report.html``.

    Parameters
    ----------
    texts : Mapping of str to str
        Contents by path in that directory.
    drawn : tuple of Figure
        The figures.
    directory : path
        Where to write.
    printed : bytes, optional
        ``report.pdf``.
    """
    target = Path(directory)
    (target / "figures").mkdir(parents=True, exist_ok=True)
    for figure in drawn:
        (target / "figures" / f"{figure.spec.name}.svg").write_text(figure.picture.svg, encoding="utf-8")
        (target / "figures" / f"{figure.spec.name}.png").write_bytes(figure.picture.png)
    for name, text in texts.items():
        (target / name).parent.mkdir(exist_ok=True)
        (target / name).write_text(text, encoding="utf-8")
    if printed is not None:
        (target / "report.pdf").write_bytes(printed)
    return target / "report.html"
