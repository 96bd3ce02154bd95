"""The last step of every search: what it proposes goes through the checker, as the text it will have in a file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from analysis.certificates.arithmetic import Rejected
from analysis.certificates.checker import Proved, Refuted, check
from analysis.certificates.drafts import completed

if TYPE_CHECKING:
    from analysis.certificates.posing import Question

Draft = Mapping[str, Any]


def sealed(question: Question, draft: Draft) -> Proved | Refuted:
    """What the checker makes of a draft, stated for exactly the class asked about; else for a larger one.

    Parameters
    ----------
    question : Question
        The question.
    draft : Mapping
        A certificate without what the checker fills in, of a proof or a refutation.

    Raises
    ------
    Rejected
        The checker accepts neither.
    """
    law = None if question.law is None or draft["verdict"] == "REFUTED" else dict(question.law)
    asked = {**draft, "laws": dict(question.laws), "law": law}
    try:
        return checked(asked)
    except Rejected:
        if draft["verdict"] == "REFUTED" or not contains(draft["laws"], question.laws):
            raise
        return checked({**draft, "law": law})


def checked(draft: Draft) -> Proved | Refuted:
    """What the checker makes of the certificate of a draft, written to text and read again.

    Parameters
    ----------
    draft : Mapping
        A certificate without what the checker fills in.
    """
    return check(json.dumps(completed(draft)))


def contains(larger: Mapping[str, Any], smaller: Mapping[str, Any]) -> bool:
    """Whether every law of one class is in another, both as they stand in a certificate.

    Parameters
    ----------
    larger, smaller : Mapping
        ``laws`` of a certificate.
    """
    line = smaller["linear"]  # phi = g sigma is odd, does not jump, and has the slope that its sector bounds
    slope = smaller["sector"] if line and smaller["slope"] is None else smaller["slope"]
    return (
        _inside(smaller["sector"], larger["sector"])
        and (larger["slope"] is None or (slope is not None and _inside(slope, larger["slope"])))
        and (smaller["odd"] or line or not larger["odd"])
        and (larger["time_varying"] or not smaller["time_varying"])
        and (line or not larger["linear"])
        and (line or larger.get("regularity") == "any" or smaller.get("regularity") is None)
    )


def _inside(inner: list[str], outer: list[str]) -> bool:
    below = outer[0] == "-inf" or (inner[0] != "-inf" and Fraction(outer[0]) <= Fraction(inner[0]))
    if outer[1] in ("inf", "finite") or inner[1] in ("inf", "finite"):
        return below and (outer[1] == "inf" or (outer[1] == "finite" and inner[1] != "inf"))
    return below and Fraction(inner[1]) <= Fraction(outer[1])
