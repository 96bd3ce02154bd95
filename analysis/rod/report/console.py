"""The report in a dozen lines of plain text, for the terminal."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

from lure.analysis.inequality.checks import CriterionResult
from lure.analysis.rod.report.confirmed import confirmation_sentence
from lure.analysis.rod.simulation.trajectory import compared

if TYPE_CHECKING:
    from lure.analysis.rod.report.model import StabilityReport

_WIDTH = 80
_HEAD = ("criterion", "model", "verdict", "evidence", "theta", "margin", "reach")


def summary(report: StabilityReport) -> str:
    """Verdict, conclusion, criteria, spectrum and motions, at most 80 columns wide.

    Parameters
    ----------
    report : StabilityReport
        The report.
    """
    reasons = dict.fromkeys(
        f"In the {result.model}, {result.reason}" for result in report.criteria if result.theta is None
    )
    blocks = [
        f"{report.verdict}  {report.system.name}",
        _filled(report.conclusion.statement),
        _filled(f"Criteria for the sector {report.criteria[0].sector} Pa/m; theta in s, margin in m/Pa, reach in Pa/m")
        + "\n"
        + _table([_HEAD, *(_row(result) for result in report.criteria)]),
        *(_filled(f"{reason}.") for reason in reasons),
        _filled(f"Spectrum: {report.spectrum}."),
        _filled(f"Simulation: {_simulated(report)}."),
        _filled(f"Confirmation: {confirmation_sentence(report.confirmation)}."),
    ]
    return "\n\n".join(blocks)


def _filled(text: str) -> str:
    return textwrap.fill(text, _WIDTH, break_on_hyphens=False)  # names such as rod-energy stay whole


def _row(result: CriterionResult) -> tuple[str, ...]:
    brackets = (result.margin, result.largest_sector)
    numbers = [result.theta, *(bracket.low for bracket in brackets if bracket is not None)]
    return (
        result.name,
        result.model,
        str(result.verdict),
        str(result.evidence_shown or "-"),
        *(f"{value:.4g}" for value in numbers if value is not None),
    )


def _table(rows: list[tuple[str, ...]]) -> str:
    widths = [max(len(row[i]) for row in rows if i < len(row)) for i in range(len(_HEAD))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=False)) for row in rows]
    return "\n".join(line.rstrip() for line in lines)


def _simulated(report: StabilityReport) -> str:
    run = report.simulation.trajectory
    if run is None:
        return f"skipped, {report.simulation.skipped}"
    count = len(run.contacts)
    touches = f"{count} contact interval{'s' if count != 1 else ''}" if run.contact else "no contact"
    return (
        f"{report.simulation.cells} cells up to {float(run.t[-1]):.4g} s, {touches}, largest z "
        f"{run.max_gap_coordinate:.6g} m, energy identity within {run.energy_residual:.1e}; compared with the theory: "
        + (", ".join(compared(run)) or "nothing, the rod stays at rest")
    )
