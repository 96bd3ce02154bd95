"""The certificates beside a report: what the checker accepted, as files that anyone can check again."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence
from typing import Any

from lure.analysis.certificates.checker import Checked
from lure.analysis.questions.certify import text_of

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
