"""The report as an object: everything that was found about one system."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from lure.analysis.inequality.checks import CriterionResult
from lure.analysis.rod.conclusion import Conclusion
from lure.analysis.rod.confirmation import Confirmation
from lure.analysis.rod.criteria import ResponseCheck
from lure.analysis.rod.report.document import document, summary
from lure.analysis.rod.spectrum import RodSpectrum
from lure.analysis.verdict import Verdict
from lure.record import html_table, xarray_or_refusal
from lure.rod.discretisation import UpwindScheme
from lure.rod.scenario import Matching
from lure.rod.systems import RodSystem

if TYPE_CHECKING:
    import xarray

    from lure.analysis.certificates.checker import Proved, Refuted
    from lure.analysis.rod.simulation import Trajectory


@dataclass(frozen=True, kw_only=True, slots=True)
class Simulation:
    """The motion of the scheme, or why there is none.

    Attributes
    ----------
    cells : int or None
        Cells simulated; None if skipped.
    trajectory : Trajectory or None
        The simulated motion; None if skipped.
    skipped : str or None
        Why nothing was simulated, and what to do about it.
    """

    cells: int | None
    trajectory: Trajectory | None
    skipped: str | None


@dataclass(frozen=True, kw_only=True, slots=True)
class StabilityReport:
    """What was found about a system; :func:`lure.analysis.rod.report.write_report` turns it into files.

    Attributes
    ----------
    system : RodSystem
        What was asked about.
    scheme : UpwindScheme
        The block that was analysed.
    spectrum : RodSpectrum
        Spectrum, scheme against rod.
    criteria : tuple of CriterionResult
        Frequency criteria, for the scheme and for the rod.
    conclusion : Conclusion
        What follows for the motion, in words.
    certificates : tuple of Proved or Refuted
        What the checker accepted, of the conclusion first.
    matching : Matching
        Whether initial and boundary data fit together.
    response : ResponseCheck
        The two computations of the frequency response compared.
    simulation : Simulation
        The motion of the scheme.
    confirmation : Confirmation
        The motion of the rod beside it, and what both were held against.
    command : str
        The command that makes this report again.
    versions : Mapping[str, str]
        Versions of lure, Python and the packages the numbers come from.
    """

    system: RodSystem
    scheme: UpwindScheme
    spectrum: RodSpectrum
    criteria: tuple[CriterionResult, ...]
    conclusion: Conclusion
    certificates: tuple[Proved | Refuted, ...]
    matching: Matching
    response: ResponseCheck
    simulation: Simulation
    confirmation: Confirmation
    command: str
    versions: Mapping[str, str]

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

    def to_xarray(self) -> xarray.Dataset:
        """The lowest modes of scheme and rod, and the criteria over the dimension ``criterion``.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        xr = xarray_or_refusal("StabilityReport.to_xarray")
        found = self.criteria
        lows = [math.nan if one.margin is None else one.margin.low for one in found]
        variables = {
            "verdict": ("criterion", [str(one.verdict) for one in found]),
            "evidence": ("criterion", [str(one.evidence) for one in found]),
            "theta": ("criterion", [math.nan if one.theta is None else one.theta for one in found], {"units": "s"}),
            "margin": ("criterion", lows, {"units": "m/Pa"}),
        }
        names = [f"{one.name}, {one.model}" for one in found]
        table: xarray.Dataset = xr.Dataset(variables, coords={"criterion": names})
        made = table.merge(self.spectrum.to_xarray())
        return made.assign_attrs(title=self.system.name, verdict=str(self.verdict), comment=self.conclusion.statement)

    def _repr_html_(self) -> str:
        head = ("criterion", "about", "verdict", "evidence", "theta [s]", "margin [m/Pa]")
        rows = [
            (
                one.name,
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
        return html_table(self.system.name, rows, head=head, verdict=str(self.verdict), notes=notes)
