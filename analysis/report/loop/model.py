"""The report on a loop as an object."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from lure.analysis.questions import LoopAnalysis
from lure.analysis.verdict import Verdict
from lure.record import html_table

if TYPE_CHECKING:
    import xarray

    from lure.analysis.counterexamples.trajectories import Trajectory
    from lure.analysis.plots.responses import Axes


@dataclass(frozen=True, kw_only=True, slots=True)
class LoopReport:
    """What was found about a loop; :func:`lure.analysis.report.write_loop_report` turns it into files.

    Attributes
    ----------
    analysis : LoopAnalysis
        Every criterion, every counterexample, and the verdict.
    observed : tuple of str
        What simulations of the given law showed, one sentence each; empty without a law.
    hints : tuple of str
        What the describing function suggests: hints, not verdicts.
    command : str
        The command that makes this report again.
    versions : Mapping[str, str]
        Versions of lure, Python and the packages the numbers come from.
    trajectories : tuple of Trajectory
        A few simulated solutions, ``sigma`` and ``mu`` over time: of the given law, or of members of the class proved.
    """

    analysis: LoopAnalysis
    observed: tuple[str, ...]
    hints: tuple[str, ...]
    command: str
    versions: Mapping[str, str]
    trajectories: tuple[Trajectory, ...] = ()

    @property
    def verdict(self) -> Verdict:
        """Verdict of the analysis, which decides the exit status of the command."""
        return self.analysis.verdict

    def __bool__(self) -> bool:
        raise TypeError("a report has three answers; compare report.verdict")

    def __str__(self) -> str:
        lines = [f"Observed: {text}" for text in self.observed] + [f"Hint: {text}" for text in self.hints]
        return "\n\n".join([str(self.analysis), *lines])

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

    def to_xarray(self) -> xarray.Dataset:
        """The table of classes; see :meth:`lure.analysis.questions.LoopAnalysis.to_xarray`.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        return self.analysis.to_xarray()

    def _repr_html_(self) -> str:
        rows = [
            *(("observed", text) for text in self.observed),
            *(("hint, not a verdict", text) for text in self.hints),
        ]
        shown = self.analysis._repr_html_()
        note = "One motion proves nothing about another, and a hint proves nothing at all."
        return shown + html_table("Simulations and hints", rows, verdict="OBSERVED", notes=[note]) if rows else shown
