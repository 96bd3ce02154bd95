"""The report on a loop as an object."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from lure.analysis.certificates.checker import Checked, Proved
from lure.analysis.questions import LoopAnalysis
from lure.analysis.verdict import Verdict
from lure.record import Column, Page, Record, quantity

if TYPE_CHECKING:
    from lure.analysis.counterexamples.trajectories import Trajectory
    from lure.analysis.plots.responses import Axes
    from lure.analysis.report.parts import FigureSpec


class LoopReport(Record):
    """What was found about a loop; :func:`lure.analysis.report.write_loop_report` turns it into files."""

    analysis: LoopAnalysis = quantity("Every criterion, every counterexample, and the verdict", label="")
    observed: tuple[str, ...] = quantity(
        "What simulations of the given nonlinearity showed, one sentence each; empty without a nonlinearity",
        form="rows",
    )
    hints: tuple[str, ...] = quantity(
        "What the describing function suggests: hints, not verdicts", label="hint, not a verdict", form="rows"
    )
    command: str = quantity("The command that makes this report again", label="")
    versions: Mapping[str, str] = quantity("Versions of lure, Python and the packages the numbers come from", label="")
    beyond: str = quantity(
        "What is proved of that which the block approximates, such as a rod by its scheme; empty if of nothing",
        label="",
        default="",
    )
    beyond_shown: tuple[Proved, ...] = quantity("What the checker accepted of it", label="", default=())
    asked: Mapping[str, Any] = quantity(
        "The answers to what ``[report]`` asks beside stability, by name: gain, rate, region",
        label="",
        default_factory=dict,
    )
    beyond_observed: tuple[str, ...] = quantity(
        "What one motion of that which the block approximates showed, one sentence each", label="", default=()
    )
    beyond_figures: tuple[FigureSpec, ...] = quantity("Figures of that motion", label="", default=())
    trajectories: tuple[Trajectory, ...] = quantity(
        "A few simulated solutions, ``sigma`` and ``mu`` over time: of the given nonlinearity, or of members of the "
        "class "
        "proved",
        label="",
        default=(),
    )
    _no_truth = "a report has three answers; compare report.verdict"

    @property
    def verdict(self) -> Verdict:
        """Verdict of the analysis, which decides the exit status of the command."""
        return self.analysis.verdict

    def __str__(self) -> str:
        lines = [f"Observed: {text}" for text in self.observed] + [f"Hint: {text}" for text in self.hints]
        followed = [f"Computed: {text}" for text in self.beyond_observed]
        beyond = [*[self.beyond] * bool(self.beyond), *followed]
        from lure.analysis.report.loop.asked import not_answered

        analysis = not_answered(str(self.analysis), self.asked)
        return "\n\n".join([analysis, *beyond, *map(str, self.asked.values()), *lines])

    @property
    def certificates(self) -> tuple[Checked, ...]:
        """What the checker accepted, of the loop, of that which it approximates and of what is asked beside."""
        from lure.analysis.report.loop.asked import accepted

        return (*self.analysis.certificates, *self.beyond_shown, *accepted(self.asked))

    def plot(self, ax: Axes | None = None) -> Axes:
        """One bar a class; see :meth:`lure.analysis.questions.LoopAnalysis.plot`.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        return self.analysis.plot(ax)

    def to_dict(self) -> dict[str, Any]:
        """``report.json`` as plain data, with its published schema."""
        from lure.analysis.report.loop.document import loop_document

        return loop_document(self)

    def _columns(self) -> dict[str, Column]:
        """The table of classes; see :meth:`lure.analysis.questions.LoopAnalysis.to_xarray`."""
        return self.analysis._columns()

    def _attributes(self) -> dict[str, object]:
        return self.analysis._attributes()

    def _page(self) -> Page:
        rows = tuple(self._rows())
        note = "One solution proves nothing about another, and a hint proves nothing at all."
        below = [Page("Simulations and hints", rows, verdict="OBSERVED", notes=[note])] if rows else []
        return self.analysis._page()._replace(below=below)
