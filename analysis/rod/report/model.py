"""The report as an object: everything that was found about one system."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from lure.analysis.rod.conclusion import Conclusion
from lure.analysis.rod.confirmation import Confirmation
from lure.analysis.rod.popov import ResponseCheck
from lure.analysis.rod.report.document import document, summary
from lure.analysis.rod.spectrum import RodSpectrum
from lure.analysis.verdict import CriterionResult, Verdict
from lure.record import Column, Page, Record, quantity
from lure.rod.discretisation import UpwindScheme
from lure.rod.scenario import Matching
from lure.rod.systems import RodSystem

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Proved, Refuted
    from lure.analysis.rod.simulation import Trajectory


class Simulation(Record):
    """The motion of the scheme, or why there is none."""

    cells: int | None = quantity("Cells simulated; None if skipped")
    trajectory: Trajectory | None = quantity("The simulated motion; None if skipped")
    skipped: str | None = quantity("Why nothing was simulated, and what to do about it")


class StabilityReport(Record):
    """What was found about a system; :func:`lure.analysis.rod.report.write_report` turns it into files."""

    system: RodSystem = quantity("What was asked about")
    scheme: UpwindScheme = quantity("The block that was analysed")
    spectrum: RodSpectrum = quantity("Spectrum, scheme against rod")
    criteria: tuple[CriterionResult, ...] = quantity("Frequency criteria, for the scheme and for the rod")
    conclusion: Conclusion = quantity("What follows for the motion, in words")
    certificates: tuple[Proved | Refuted, ...] = quantity("What the checker accepted, of the conclusion first")
    matching: Matching = quantity("Whether initial and boundary data fit together")
    response: ResponseCheck = quantity("The two computations of the frequency response compared")
    simulation: Simulation = quantity("The motion of the scheme")
    confirmation: Confirmation = quantity("The motion of the rod beside it, and what both were held against")
    command: str = quantity("The command that makes this report again")
    versions: Mapping[str, str] = quantity("Versions of lure, Python and the packages the numbers come from")

    @property
    def verdict(self) -> Verdict:
        """Verdict of the conclusion, which decides the exit status of the command."""
        return self.conclusion.verdict

    def __bool__(self) -> bool:
        raise TypeError("a report has three answers; compare report.verdict")

    def __str__(self) -> str:
        return summary(self)

    def to_dict(self) -> dict[str, Any]:
        """``report.json`` as plain data, with its published schema."""
        return document(self)

    def _columns(self) -> dict[str, Column]:
        """The lowest modes of scheme and rod, and the criteria over the dimension ``criterion``."""
        along, found = ("criterion",), self.criteria
        lows = [math.nan if one.margin is None else one.margin.low for one in found]
        thetas = [math.nan if one.theta is None else one.theta for one in found]
        return {
            "criterion": Column(along, [f"{one.criterion}, {one.model}" for one in found], "1", "criterion and model"),
            "verdict": Column(along, [str(one.verdict) for one in found], "1", "verdict on the inequality"),
            "evidence": Column(along, [str(one.evidence) for one in found], "1", "what it rests on"),
            "theta": Column(along, thetas, "s", "Popov multiplier"),
            "margin": Column(along, lows, "m/Pa", "least value of the inequality over all frequencies, from below"),
            **self.spectrum._columns(),
        }

    def _attributes(self) -> dict[str, object]:
        more = {"title": self.system.name, "verdict": str(self.verdict), "comment": self.conclusion.statement}
        return self.spectrum._attributes() | more

    def _page(self) -> Page:
        head = ("criterion", "about", "verdict", "evidence", "theta [s]", "margin [m/Pa]")
        rows = [
            (
                one.criterion,
                one.model,
                one.verdict,
                one.evidence_shown or "-",
                "-" if one.theta is None else f"{one.theta:.6g}",
                "-" if one.margin is None else one.margin,
            )
            for one in self.criteria
        ]
        notes = [
            self.conclusion.statement,
            "The verdicts in the table are on the frequency inequalities; that on the rod rests on its energy theorem.",
            f"Spectrum: {self.spectrum}.",
            *(f"Assumed: {text}." for text in self.conclusion.assumptions),
            *(f"Not shown: {text}." for text in self.conclusion.not_shown),
        ]
        return Page(self.system.name, rows, head, str(self.verdict), notes)
