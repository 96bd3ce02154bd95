"""The certificates beside a report: what the checker accepted, as files that anyone can check again."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from lure.analysis.certificates.checker import Checked, Proved, Refuted
from lure.analysis.certificates.sealing import guarded, settled
from lure.analysis.inequality.checks import CriterionResult
from lure.analysis.questions.certify import text_of
from lure.analysis.rod.certificates import inequality_draft, negative_damping_draft
from lure.analysis.verdict import Verdict
from lure.rod.transfer import RodBlock
from lure.rod.upwind import UpwindScheme

FOLDER = "certificates"


def certificate_files(shown: Sequence[Checked]) -> dict[str, str]:
    """Contents by path relative to the report, in the order given: ``certificates/1-proved-popov.json`` and so on.

    Parameters
    ----------
    shown : sequence of Checked
        What the checker accepted.
    """
    return {f"{FOLDER}/{_name(i, one)}": text_of(one.certificate) for i, one in enumerate(shown, 1)}


def certificate_list(shown: Sequence[Checked]) -> list[dict[str, Any]]:
    """The part ``certificates`` of ``report.json``: file, verdict, theorem, claim and fingerprint of each.

    Parameters
    ----------
    shown : sequence of Checked
        What the checker accepted.
    """
    files = certificate_files(shown)
    return [
        {
            "file": path,
            "verdict": one.certificate["verdict"],
            "theorem": one.theorem,
            "claim": one.claim,
            "sha256": hashlib.sha256(text.encode()).hexdigest(),
        }
        for (path, text), one in zip(files.items(), shown, strict=True)
    ]


def _name(number: int, shown: Checked) -> str:
    return f"{number}-{shown.certificate['verdict'].lower()}-{re.sub('[^a-z-]', '', shown.theorem)}.json"


def checked_criteria(scheme: UpwindScheme, results: Sequence[CriterionResult]) -> tuple[CriterionResult, ...]:
    """Results for the rod and its scheme with what the checker accepted of them; INCONCLUSIVE where it was nothing.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme.
    results : sequence of CriterionResult
        What the criteria said.
    """
    return tuple(_checked(scheme, result) for result in results)


def _checked(scheme: UpwindScheme, result: CriterionResult) -> CriterionResult:
    if result.verdict is Verdict.INCONCLUSIVE:
        return result
    block = scheme if result.model == "scheme" else RodBlock(scheme.rod)
    proved = result.verdict is Verdict.PROVED
    draft = inequality_draft(block, result) if proved else negative_damping_draft(block, result.sector)
    found = guarded(result.name, lambda: settled(draft))
    if isinstance(found, Proved | Refuted):
        return replace(result, shown=found)
    return replace(result, verdict=Verdict.INCONCLUSIVE, reason=f"not certified: {found}")
