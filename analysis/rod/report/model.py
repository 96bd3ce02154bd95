"""The report as an object: everything that was found about one system, every claim as one row."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from lure.analysis.rod.conclusion import Conclusion
from lure.analysis.rod.confirmation import Confirmation
from lure.analysis.rod.popov import ResponseCheck
from lure.analysis.rod.report.document import document, summary
from lure.analysis.rod.simulation.trajectory import compared
from lure.analysis.rod.spectrum import RodSpectrum
from lure.analysis.verdict import CriterionResult, Evidence, Verdict
from lure.record import Column, Page, Record, described, quantity
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


@described(frozen=True, kw_only=True, slots=True)
class Claim:
    """One row of the table of claims."""

    text: str = quantity("What is claimed")
    model: str = quantity('``"rod"``, ``"scheme"`` or both: what it is claimed of')
    answer: str = quantity(
        'A verdict, ``"checked"`` for an exact fact without a certificate, or ``"agrees"``, ``"differs"`` or '
        '``"not tested"`` for a comparison, which decides nothing by itself'
    )
    evidence: Evidence | None = quantity(
        "What the answer rests on; None where nothing was decided and no number stands in the row"
    )
    criterion: int | None = quantity(
        "Index of the criterion whose numbers belong in the row; None if it has none", default=None
    )


def claims(report: StabilityReport) -> tuple[Claim, ...]:
    """The claims of a report: by evidence, strongest first, and decided ones before undecided ones.

    What rests on no evidence comes last.

    Parameters
    ----------
    report : StabilityReport
        The report.
    """
    rows = [
        *_proofs(report),
        *_criteria(report),
        _zero(report),
        *_computed(report),
        *_moved(report),
        *_observed(report),
    ]
    return tuple(sorted(rows, key=lambda row: (_rank(row.evidence), row.answer == "INCONCLUSIVE")))


def _rank(evidence: Evidence | None) -> int:
    return [Evidence.CERTIFIED, Evidence.COMPUTED, Evidence.OBSERVED, None].index(evidence)


def _proofs(report: StabilityReport) -> list[Claim]:
    found = report.conclusion
    if not found.proofs:
        text = "free motions come to rest"
        return [Claim(text=text, model="rod", answer=str(found.verdict), evidence=None)]
    return [
        Claim(
            text=f"without load, {proof.meaning[0].lower()}{proof.meaning[1:]}, for nonlinearities in the sector "
            f"{proof.sector} ({proof.title})",
            model=proof.model,
            answer=str(found.verdict),
            evidence=proof.evidence,
        )
        for proof in found.proofs
    ]


def _criteria(report: StabilityReport) -> list[Claim]:
    rows = [
        Claim(
            text=f"{_title(result)} the sector {result.sector} Pa/m",
            model=result.model,
            answer=str(result.verdict),
            evidence=result.evidence_shown,
            criterion=None if result.verdict is Verdict.REFUTED else index,
        )
        for index, result in enumerate(report.criteria)
    ]
    return list(dict.fromkeys(rows))


def _title(result: CriterionResult) -> str:
    if result.verdict is Verdict.REFUTED:  # by a member of the class, whatever the criterion
        return "absolute stability for nonlinearities in"
    return "Popov inequality for" if result.criterion == "popov" else "circle criterion for"


def _zero(report: StabilityReport) -> Claim:
    certified = any("dissipation" in shown.facts for shown in report.certificates)
    return Claim(
        text=f"the zero eigenvalue is {'simple' if report.spectrum.zero_multiplicity == 1 else 'double'}",
        model="rod and scheme",
        answer=str(Verdict.PROVED) if certified else "checked",
        evidence=Evidence.CERTIFIED,
    )


def _computed(report: StabilityReport) -> list[Claim]:
    if report.response.difference is None:
        return []
    agrees = report.response.difference < 1e-6
    return [
        Claim(
            text="frequency response by python-control and by the closed form, at "
            f"{report.response.frequencies} frequencies",
            model="scheme",
            answer="agrees" if agrees else "differs",
            evidence=Evidence.COMPUTED,
        )
    ]


def _moved(report: StabilityReport) -> list[Claim]:
    side, held = report.confirmation.rod, report.confirmation.compared
    if side is None:
        return []
    return [
        Claim(
            text=f"exact motion up to t = {side.until:.4g} s, compared: "
            + (", ".join(held) or "nothing, the rod stays at rest"),
            model="rod",
            answer="agrees" if held else "not tested",
            evidence=Evidence.OBSERVED,
        )
    ]


def _observed(report: StabilityReport) -> list[Claim]:
    run = report.simulation
    if run.trajectory is None:
        return []
    return [
        Claim(
            text=f"simulated motion up to t = {float(run.trajectory.t[-1]):.4g} s, compared: "
            + (", ".join(compared(run.trajectory)) or "nothing, the rod stays at rest"),
            model=f"scheme, N = {run.cells}",
            answer="agrees" if compared(run.trajectory) else "not tested",
            evidence=Evidence.OBSERVED,
        )
    ]


def merged(rows: tuple[Claim, ...]) -> tuple[Claim, ...]:
    """Claims of the same words and answer about different models as one, its models joined.

    ``rows``: from :func:`claims`.
    """
    joined: dict[tuple[str, str, Evidence | None], list[str]] = {}
    for row in rows:
        joined.setdefault((row.text, row.answer, row.evidence), []).append(row.model)
    return tuple(
        Claim(text=text, model=" and ".join(models), answer=answer, evidence=evidence)
        for (text, answer, evidence), models in joined.items()
    )
