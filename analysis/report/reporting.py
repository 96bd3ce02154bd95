"""The report from Python: what ``lure report`` does, for objects."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from lure.analysis.output import checked_target, replaced
from lure.analysis.questions.problem import loop_given
from lure.analysis.report.loop import build_loop_report, write_loop_report
from lure.analysis.report.parts import Report
from lure.extensions import extension
from lure.files.system import LoopSystem
from lure.loop import Loop
from lure.plants import as_plant

_COMMAND = "lure.analysis.report_on(plant, nonlinearity, output=...)"


def report_on(
    plant: object,
    nonlinearity: object = None,
    *,
    output: str | os.PathLike[str] | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> Report:
    """Everything that can be said of a loop or a rod, as ``lure report`` says it.

    Parameters
    ----------
    plant : object
        A ``Loop``, a ``LoopSystem`` or ``RodSystem``, or anything :func:`lure.as_plant` takes.
    nonlinearity : object
        What closes the loop around a plant: a law, a formula as text, ``control.saturation_nonlinearity``, a
        ``NonlinearityClass``, a ``Sector`` or ``SlopeBounds``.  Without one the classes ``[0, k]`` are looked at.
    output : path, optional
        A directory for ``report.html``, ``report.json``, figures and certificates; a report there is replaced.
        Without it nothing is written.
    progress : callable, optional
        Called as ``progress(stage, done)`` when a stage begins, ``0 <= done <= 1``.

    Returns
    -------
    LoopReport, or of a rod lure.analysis.rod.report.StabilityReport
        ``verdict`` and everything on the page; ``str`` is what the command prints.

    Raises
    ------
    InputError
        A plant or nonlinearity is none, what is declared of it is false, or the directory holds something else.
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
        checked_target(target)
    special = extension("report", loop)
    if special is not None:
        made: Report = special(loop, target, progress)
        return made
    named = isinstance(loop, LoopSystem) and loop.nonlinearity is None and nonlinearity is None
    found = build_loop_report(_system(loop), progress=progress, command=None if named else _COMMAND)
    if target is not None:
        with replaced(target) as directory:
            write_loop_report(found, directory)
    return found


def _system(loop: object) -> LoopSystem:
    if isinstance(loop, LoopSystem):
        return loop
    if isinstance(loop, Loop):
        return LoopSystem(name="loop", title="", block=as_plant(loop.block), nonlinearity=loop.nonlinearity)  # type: ignore[arg-type]
    return LoopSystem(name="loop", title="", block=as_plant(loop))  # type: ignore[arg-type]
