"""What the reports on loops and on rods have in common: figures, claims, files."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, Literal, Protocol

from lure import __version__
from lure.analysis.certificates.checker import Checked
from lure.analysis.plots import Draw, Picture
from lure.analysis.questions.certify import text_of
from lure.analysis.report.pdf import pdf_of
from lure.analysis.verdict import Verdict
from lure.record import described, quantity

SCHEMA = "lure-report/1"
Json = dict[str, Any]
FOLDER = "certificates"
Section = Literal["asked", "frequency", "criteria", "spectrum", "confirmation", "simulation"]
LADDER = (
    ("certified", "exact or ball arithmetic over the whole claim, or a proof from exact hypotheses"),
    ("computed", "floating point, compared with a second computation"),
    ("observed", "a simulation, a sample or a drawing; it can contradict a claim, never prove one"),
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


@described(frozen=True, kw_only=True, slots=True)
class FigureSpec:
    """One figure before it is drawn."""

    name: str = quantity("File name without its ending")
    section: Section = quantity("Where it stands in the report")
    title: str = quantity("A few words above it")
    caption: str = quantity("What to look at")
    draw: Draw = quantity("Draws on the axes it is given")


@dataclass(frozen=True, kw_only=True, slots=True)
class Figure:
    """One figure, drawn."""

    spec: FigureSpec
    picture: Picture


def to_json(data: Json) -> str:
    """``data`` as text; a NaN or an infinity in it is an error, not a token.

    ``data``: from :func:`document`.
    """
    return json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def versions(*packages: str) -> dict[str, str]:
    """Those of lure, of Python and of the packages that the numbers of a report come from."""
    own = {"lure": __version__, "python": platform.python_version()}
    return own | {name: version(name) for name in packages}


# The certificates beside a report: what the checker accepted, as files that anyone can check again.


def certificate_files(shown: Sequence[Checked]) -> dict[str, str]:
    """Contents by path relative to the report, in the order given: ``certificates/1-proved-popov.json`` and so on."""
    return {f"{FOLDER}/{_name(i, one)}": text_of(one.certificate) for i, one in enumerate(shown, 1)}


def certificate_list(shown: Sequence[Checked]) -> list[dict[str, Any]]:
    """The part ``certificates`` of ``report.json``: file, verdict, theorem, claim and fingerprint of each."""
    files = certificate_files(shown)
    return [
        {
            "file": path,
            "verdict": one.certificate["verdict"],
            "theorem": one.theorem,
            "claim": one.claim,
            "sha256": hashlib.sha256(text.encode()).hexdigest(),
        }
        for (path, text), one in zip(files.items(), shown, strict=True)
    ]


def _name(number: int, shown: Checked) -> str:
    return f"{number}-{shown.certificate['verdict'].lower()}-{re.sub('[^a-z-]', '', shown.theorem)}.json"


def write_files(  # noqa: PLR0913  (all that a report consists of)
    data: Json,
    page: Callable[..., str],
    drawn: tuple[Figure, ...],
    shown: Sequence[Checked],
    directory: str | os.PathLike[str],
    *,
    pdf: bool,
) -> Path:
    """Write ``report.html``, ``report.json``, ``certificates/`` and ``figures/`` into a directory, made if missing.

    Everything is made before the first file is written.

    Parameters
    ----------
    data : dict
        The document.
    page : callable
        Its page; with ``paper=True`` that for :func:`lure.analysis.report.pdf.pdf_of`.
    drawn : tuple of Figure
        The figures.
    shown : sequence of Checked
        What the checker accepted.
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
    texts = {"report.json": to_json(data), "report.html": page()} | certificate_files(shown)
    printed = pdf_of(page(paper=True)) if pdf else None
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
