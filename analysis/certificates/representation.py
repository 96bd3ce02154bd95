"""What the checker accepted, and what a search came to, as a table for a notebook and as plain data.

Apart from the checker on purpose: it stays short enough to be read, and knows nothing of pages.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from lure.record import Page, plain

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Checked
    from lure.analysis.certificates.drafts import Failure

_CLAIM = "Not shown is anything beyond the claim: a rate of decay, a bound on a solution, external inputs."
_AGAIN = "Check it again with lure.analysis.check(certificate), or with checker.py and nothing but Python."


def shown_dict(shown: Checked) -> dict[str, Any]:
    """A ``Proved`` or ``Refuted`` as plain JSON data, its certificate with it.

    Parameters
    ----------
    shown : Proved or Refuted
        What the checker accepted.
    """
    return {
        "verdict": str(shown.certificate["verdict"]),
        "evidence": "certified",
        "theorem": shown.theorem,
        "claim": shown.claim,
        "facts": plain(shown.facts),
        "assumed": [shown.assumed] if shown.assumed else [],
        "certificate": plain(shown.certificate),
    }


def shown_page(shown: Checked, assumed: tuple[str, ...] | None = None) -> Page:
    """A ``Proved`` or ``Refuted`` as a table: the claim, the theorem and the hypotheses that were found to hold.

    Parameters
    ----------
    shown : Proved or Refuted
        What the checker accepted.
    assumed : tuple of str, optional
        What is assumed beside it, in clauses; by default what it says itself.
    """
    own = (shown.assumed,) if shown.assumed else ()
    rows = [("theorem", shown.theorem), ("evidence", "certified"), *shown.facts.items()]
    rows += [("assumed", clause) for clause in (own if assumed is None else assumed)]
    return Page(shown.claim, rows, verdict=str(shown.certificate["verdict"]), notes=[_CLAIM, _AGAIN])


def failure_dict(failure: Failure) -> dict[str, Any]:
    """A search that showed nothing, as plain JSON data."""
    return {
        "search": failure.search,
        "code": failure.code.identifier,
        "title": failure.code.title,
        "detail": failure.detail,
    }
