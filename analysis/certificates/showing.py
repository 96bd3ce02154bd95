"""What the checker accepted, and what a search came to, as a table for a notebook and as plain data.

Apart from the checker on purpose: it stays short enough to be read, and knows nothing of pages.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from lure.record import html_table, plain

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Checked
    from lure.analysis.certificates.sealing import Failure
    from lure.analysis.questions.certify import Certification

_CLAIM = "Not shown is anything beyond the claim: a rate of decay, a bound on a motion, external inputs."
_AGAIN = "Check it again with lure.analysis.check(certificate), or with checker.py and nothing but Python."
_NOTHING = "That nothing was shown says nothing about the loop: it may be stable or not."


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


def shown_html(shown: Checked) -> str:
    """A ``Proved`` or ``Refuted`` as a table: the claim, the theorem and the hypotheses that were found to hold.

    Parameters
    ----------
    shown : Proved or Refuted
        What the checker accepted.
    """
    return _accepted(shown, (shown.assumed,) if shown.assumed else ())


def _accepted(shown: Checked, assumed: tuple[str, ...]) -> str:
    """What was accepted, and what is assumed beside it."""
    rows = [("theorem", shown.theorem), ("evidence", "certified"), *shown.facts.items()]
    rows += [("assumed", clause) for clause in assumed]
    return html_table(shown.claim, rows, verdict=str(shown.certificate["verdict"]), notes=[_CLAIM, _AGAIN])


def failure_dict(failure: Failure) -> dict[str, Any]:
    """A search that showed nothing, as plain JSON data.

    Parameters
    ----------
    failure : Failure
        The failure.
    """
    return {
        "search": failure.search,
        "code": failure.code.identifier,
        "title": failure.code.title,
        "detail": failure.detail,
    }


def certification_dict(found: Certification) -> dict[str, Any]:
    """What came of a question, as plain JSON data.

    Parameters
    ----------
    found : Certification
        The outcome.
    """
    return {
        "verdict": str(found.verdict),
        "code": None if found.code is None else found.code.identifier,
        "detail": found.detail,
        "shown": None if found.shown is None else shown_dict(found.shown),
        "assumed": list(found.assumed),
        "failures": [failure_dict(failure) for failure in found.failures],
        "sentence": str(found),
    }


def certification_html(found: Certification) -> str:
    """What came of a question: what the checker accepted, or every search and how it ended.

    Parameters
    ----------
    found : Certification
        The outcome.
    """
    tried = [(one.search, f"{one.code.title} ({one.code.identifier})", one.detail) for one in found.failures]
    failed = html_table("Searches that showed nothing", tried, head=("search", "how it ended", "why")) if tried else ""
    if found.shown is not None:
        return _accepted(found.shown, found.assumed) + failed
    rows = [("why", found.detail)]
    if found.code is not None:
        rows.insert(0, ("code", f"{found.code.identifier}, {found.code.title}"))
    return html_table("No certificate was found", rows, verdict=str(found.verdict), notes=[_NOTHING]) + failed
