"""The files of a report on a rod."""

from __future__ import annotations

import os
from pathlib import Path

from lure.analysis.report.certificates import certificate_files
from lure.analysis.report.parts import to_json, write_files
from lure.analysis.report.pdf import pdf_of
from lure.analysis.rod.report.claims import claims
from lure.analysis.rod.report.document import document
from lure.analysis.rod.report.figures import figures
from lure.analysis.rod.report.model import StabilityReport
from lure.analysis.rod.report.page import page


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
