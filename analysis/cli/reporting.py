"""What ``lure report`` writes, and where: a directory, with a PDF in it if asked, or a PDF alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lure.analysis.report.loop import LoopReport
    from lure.analysis.rod.report import StabilityReport
    from lure.files.system import LoopSystem
    from lure.rod.systems import RodSystem


@dataclass(frozen=True, kw_only=True, slots=True)
class Target:
    """Where a report goes.

    Attributes
    ----------
    path : Path
        A directory, or a file for a PDF alone.
    alone : bool
        Whether only a PDF is written.
    pdf : bool
        Whether a directory gets a PDF too.
    """

    path: Path
    alone: bool
    pdf: bool

    @property
    def page(self) -> Path:
        """What the user opens."""
        return self.path if self.alone else self.path / "report.html"


def target_of(output: Path, *, pdf: bool) -> Target:
    """The target of a report, checked before anything is computed.

    Parameters
    ----------
    output : Path
        As given with ``-o``; a name that ends in ``.pdf``, and is no directory, is a file.
    pdf : bool
        Whether ``--pdf`` was given.

    Raises
    ------
    InputError
        Nothing can be written there, or no PDF can be made.
    """
    from lure.analysis.output import checked_target

    alone = output.suffix.lower() == ".pdf" and not output.is_dir()
    if alone or pdf:
        from lure.analysis.report.pdf import checked_pdf_target, pdf_maker

        pdf_maker()  # refused before anything is computed
        if alone:
            checked_pdf_target(output)
    if not alone:
        checked_target(output)
    return Target(path=output, alone=alone, pdf=pdf)


def delivered(
    system: RodSystem | LoopSystem,
    target: Target,
    *,
    command: str,
    seconds: float | None = None,
    tell: Callable[[str, float], None] | None,
) -> tuple[StabilityReport | LoopReport, str]:
    """Build a report and write it; the report, and its JSON as text.

    Parameters
    ----------
    system : RodSystem or LoopSystem
        What is reported on.
    target : Target
        From :func:`target_of`.
    command : str
        The command that makes the report again.
    seconds : float or None
        Time allowed to the searches for a loop; None for no limit, and for a rod.
    tell : callable, optional
        Told the stage and the share of work done.
    """
    from lure.analysis.output import replaced

    build, write = _reporting(system)
    limit = {} if seconds is None else {"seconds": seconds}
    found = build(system, progress=tell, command=command, **limit)
    if tell:
        tell("writing the report", 0.95)
    if not target.alone:
        with replaced(target.path) as directory:
            write(found, directory, **({"pdf": True} if target.pdf else {}))
            return found, (directory / "report.json").read_text(encoding="utf-8")
    from lure.analysis.report.pdf import write_pdf

    with TemporaryDirectory(prefix="lure-") as scratch:
        write(found, Path(scratch), pdf=True)
        write_pdf((Path(scratch) / "report.pdf").read_bytes(), target.path)
        return found, (Path(scratch) / "report.json").read_text(encoding="utf-8")


def _reporting(
    system: RodSystem | LoopSystem,
) -> tuple[Callable[..., StabilityReport | LoopReport], Callable[..., Path]]:
    """What builds and what writes the report on such a system."""
    from lure.rod.systems import RodSystem

    if isinstance(system, RodSystem):
        from lure.analysis.rod.report import build_report, write_report

        return build_report, write_report
    from lure.analysis.report.loop import build_loop_report, write_loop_report

    return build_loop_report, write_loop_report
