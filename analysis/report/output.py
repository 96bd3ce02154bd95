"""The files of a report."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from lure.analysis.report.certificates import certificate_files
from lure.analysis.report.claims import claims
from lure.analysis.report.document import document, to_json
from lure.analysis.report.figures import Figure, figures
from lure.analysis.report.html import page
from lure.analysis.report.model import StabilityReport
from lure.analysis.report.pdf import pdf_of


def write_report(report: StabilityReport, directory: str | os.PathLike[str], *, pdf: bool = False) -> Path:
    """Write ``report.html``, ``report.json``, ``certificates/`` and ``figures/`` into a directory, made if missing.

    Everything is computed and drawn before the first file is written.  For a directory that changes in one step, and
    never loses what is not a report, write into that of :func:`lure.analysis.output.replaced`, as the command does.

    Parameters
    ----------
    report : StabilityReport
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
    data, drawn = document(report), figures(report)
    texts = {"report.json": to_json(data), "report.html": page(data, claims(report), drawn)}
    texts |= certificate_files(report.certificates)
    printed = pdf_of(page(data, claims(report), drawn, paper=True)) if pdf else None
    return write_files(texts, drawn, directory, printed=printed)


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
