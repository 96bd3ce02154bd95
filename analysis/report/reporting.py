"""The report from Python: what ``lure report`` does, for objects."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import cast

from lure.analysis.output import checked_target, replaced
from lure.analysis.questions.problem import loop_given
from lure.analysis.report.loop import build_loop_report
from lure.analysis.report.parts import Report
from lure.analysis.report.pdf import checked_pdf_target, pdf_maker, write_pdf
from lure.errors import InputError
from lure.extensions import extension
from lure.files.system import LoopSystem
from lure.loop import Loop
from lure.plants.conversion import one_channel

_COMMAND = "lure.analysis.report_on(plant, nonlinearity, output=...)"


def report_on(  # noqa: PLR0913  (a loop and what is done with the report on it)
    plant: object,
    nonlinearity: object = None,
    *,
    output: str | os.PathLike[str] | None = None,
    pdf: bool = False,
    seconds: float | None = None,
    command: str | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> Report:
    """Everything that can be said of a loop or a rod; the command ``lure report`` is this function.

    Parameters
    ----------
    plant : object
        A ``Loop``, a ``LoopSystem`` or ``RodSystem``, or anything :func:`lure.as_plant` takes.
    nonlinearity : object
        What closes the loop around a plant: a nonlinearity, a formula as text, ``control.saturation_nonlinearity``, a
        ``NonlinearityClass``, a ``Sector`` or ``SlopeBounds``.  Without one the classes ``[0, k]`` are looked at.
    output : path, optional
        A directory for ``report.html``, ``report.json``, figures and certificates; a report there is replaced.  A name
        that ends in ``.pdf``, and is no directory, is a file for a PDF alone.  Without it nothing is written.
    pdf : bool
        Whether a directory gets ``report.pdf`` too.
    seconds : float or None
        Time allowed to the searches for a loop; None for no limit, and for a rod.
    command : str, optional
        What makes the report again, as it stands in it.
    progress : callable, optional
        Called as ``progress(stage, done)`` when a stage begins, ``0 <= done <= 1``.

    Returns
    -------
    LoopReport, or of a rod lure.analysis.rod.report.StabilityReport
        ``verdict`` and everything on the page; ``str`` is what the command prints.

    Raises
    ------
    InputError
        A plant or nonlinearity is none, what is declared of it is false, the directory holds something else, no PDF
        can be made, or a report on a rod is given a time.
    AssumptionError
        Nothing certified can be said of such a block.
    ContradictionError
        A simulation contradicts what is proved: a bug.

    Examples
    --------
    >>> from lure import Saturation
    >>> print(report_on("1/(s+1)", Saturation(gain=2)).verdict)
    PROVED
    """
    loop = loop_given(plant, nonlinearity)
    target = None if output is None else Path(output)
    if target is not None:
        _check_target(target, pdf=pdf)
    special: Callable[..., Report] | None = extension("report", loop)
    if special is None:
        named = isinstance(loop, LoopSystem) and loop.nonlinearity is None and nonlinearity is None
        said = command or (None if named else _COMMAND)
        found: Report = build_loop_report(_system(loop), seconds=seconds, progress=progress, command=said)
    elif seconds is not None:
        raise InputError("seconds limits the searches for a loop, and a report on a rod has none; leave it out")
    else:
        found = special(loop, progress=progress, command=command)
    if target is not None:
        if progress:
            progress("writing the report", 0.95)
        _write(found, target, pdf=pdf)
    return found


def page_of(output: Path) -> Path:
    """What the user opens of a report: the page in its directory, or the PDF where that is all.

    ``output``: as for :func:`report_on`.
    """
    return output if _alone(output) else output / "report.html"


def _alone(output: Path) -> bool:
    return output.suffix.lower() == ".pdf" and not output.is_dir()


def _check_target(output: Path, *, pdf: bool) -> None:
    """Refuse what cannot be written before anything is computed."""
    if pdf or _alone(output):
        pdf_maker()
    if _alone(output):
        checked_pdf_target(output)
    else:
        checked_target(output)


def _write(found: Report, output: Path, *, pdf: bool) -> None:
    """The files of a report; each page by the kind of report it is."""
    write = cast("Callable[..., Path]", extension("report files", found))
    if not _alone(output):
        with replaced(output) as directory:
            write(found, directory, **({"pdf": True} if pdf else {}))
        return
    with TemporaryDirectory(prefix="lure-") as scratch:
        write(found, Path(scratch), pdf=True)
        write_pdf((Path(scratch) / "report.pdf").read_bytes(), output)


def _system(loop: object) -> LoopSystem:
    if isinstance(loop, LoopSystem):
        return loop
    if isinstance(loop, Loop):
        return LoopSystem(name="loop", title="", block=one_channel(loop.block), nonlinearity=loop.nonlinearity)  # type: ignore[arg-type]  # refused later, in words
    return LoopSystem(name="loop", title="", block=one_channel(loop))  # type: ignore[arg-type]  # likewise
