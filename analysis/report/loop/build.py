"""From a loop to its report."""

from __future__ import annotations

import shlex
from collections.abc import Callable

from lure.analysis.questions import analyse
from lure.analysis.report.loop.asked import answers
from lure.analysis.report.loop.document import balance_hints
from lure.analysis.report.loop.model import LoopReport
from lure.analysis.report.loop.observed import observed
from lure.analysis.report.parts import versions
from lure.extensions import extension
from lure.files.system import LoopSystem

PACKAGES = ("numpy", "scipy", "control", "python-flint", "matplotlib", "jinja2")

Progress = Callable[[str, float], None]


def build_loop_report(
    system: LoopSystem,
    *,
    seconds: float | None = None,
    progress: Progress | None = None,
    command: str | None = None,
) -> LoopReport:
    """Everything the report says about a loop.

    Parameters
    ----------
    system : LoopSystem
        The loop.
    seconds : float or None
        Time allowed to the criteria and searches, and to each question asked beside them; simulations and
        drawings are not counted.
    progress : callable, optional
        Called as ``progress(stage, done)`` when a stage begins, with the share ``0 <= done <= 1`` of work behind it.
    command : str, optional
        The command that makes the report again; by default ``lure report`` and the name of the system.

    Raises
    ------
    AssumptionError
        Nothing certified can be said of such a block.
    ContradictionError
        A simulation contradicts what is proved.
    """
    say = progress or (lambda _stage, _done: None)
    told_of = answers(system, seconds)  # first, so that a question which has no answer is refused at once
    found = analyse(system, seconds=seconds, progress=lambda stage, done: say(stage, 0.8 * done))
    say("simulation", 0.8)
    seen = observed(found)
    told = extension("beyond", system.approximates)
    beyond, shown = ("", ()) if told is None else told(system.approximates)
    follow = extension("beyond, followed", system.approximates)
    beyond_observed, beyond_figures = ((), ()) if follow is None else follow(system.approximates)
    return LoopReport(
        analysis=found,
        observed=seen.sentences,
        trajectories=seen.trajectories,
        hints=balance_hints(found.problem),
        beyond=beyond,
        beyond_shown=shown,
        asked=told_of,
        beyond_observed=beyond_observed,
        beyond_figures=beyond_figures,
        command=command or f"lure report {shlex.quote(system.name)}",
        versions=versions(*PACKAGES),
    )
