"""Every claim of a report as one row, strongest first."""

from __future__ import annotations

from lure.analysis.rod.report.model import StabilityReport
from lure.analysis.rod.simulation.trajectory import compared
from lure.analysis.verdict import CriterionResult, Evidence, Verdict
from lure.record import described, quantity


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
