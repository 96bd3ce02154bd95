"""The files of a report on a rod."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from lure.analysis.output import replaced
from lure.analysis.report.certificates import certificate_files
from lure.analysis.report.parts import to_json, write_files
from lure.analysis.report.pdf import pdf_of
from lure.analysis.rod.report.build import build_report
from lure.analysis.rod.report.claims import claims
from lure.analysis.rod.report.document import document
from lure.analysis.rod.report.figures import figures
from lure.analysis.rod.report.model import StabilityReport
from lure.analysis.rod.report.page import page
from lure.rod.systems import RodSystem


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


def reported(
    system: RodSystem, target: Path | None, progress: Callable[[str, float], None] | None = None
) -> StabilityReport:
    """The report on a rod, written into a directory unless that is None; see :func:`lure.analysis.report_on`.

    Parameters
    ----------
    system : RodSystem
        The rod, its scenario and discretisation.
    target : Path or None
        The directory, already checked.
    progress : callable, optional
        As for :func:`lure.analysis.rod.report.build_report`.
    """
    report = build_report(system, progress=progress)
    if target is not None:
        with replaced(target) as directory:
            write_report(report, directory)
    return report
