"""What ``lure verify`` does with one file: read it, have it checked, say what came of it.

Nothing here imports numpy, a solver or the package ``lure``: the checker needs Python's standard library only.
"""

from __future__ import annotations

import json
import shlex
import stat
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from analysis.certificates.arithmetic import Malformed, Rejected
from analysis.certificates.checker import Proved, Refuted, check
from analysis.cli.wrapping import wrapped

ACCEPTED, REJECTED, NO_CERTIFICATE = "ACCEPTED", "REJECTED", "NO CERTIFICATE"
LONGEST = 600.0  # [s] for the second checker, as for the first
MOST_BYTES = 1 << 26  # more than any certificate has: the checker refuses what is cut off here by its size
STATUS = {ACCEPTED: 0, NO_CERTIFICATE: 2, REJECTED: 11}
_SECOND = "the second checker, on python-flint, agrees"


@dataclass(frozen=True, kw_only=True, slots=True)
class Verified:
    """What came of one file.

    Attributes
    ----------
    file : str
        Its name as given; ``-`` is standard input.
    result : str
        ``ACCEPTED``, ``REJECTED`` or ``NO CERTIFICATE``.
    reason : str
        The claim that was accepted, or why it was not.
    shown : Proved, Refuted or None
        What the checker made of an accepted certificate.
    second : bool or None
        Whether the second checker agreed; None if it was not asked.
    """

    file: str
    result: str
    reason: str
    shown: Proved | Refuted | None = None
    second: bool | None = None

    @property
    def status(self) -> int:
        """Exit status for this file alone."""
        return STATUS[self.result]

    def to_dict(self) -> dict[str, Any]:
        """The same as plain data."""
        data: dict[str, Any] = {"file": self.file, "result": self.result}
        if self.shown is None:
            return {**data, "reason": self.reason, "second": self.second}
        found = self.shown
        return {
            **data,
            "verdict": "PROVED" if isinstance(found, Proved) else "REFUTED",
            "claim": found.claim,
            "theorem": found.theorem,
            "facts": dict(found.facts),
            "assumed": [found.assumed] if found.assumed else [],
            "second": self.second,
        }

    def lines(self) -> list[str]:
        """The same in lines of 80 columns, exact numbers unbroken."""
        said = wrapped(f"{self.result}: {self.reason}", indent=2)
        if self.shown is not None:
            said += accepted_lines(self.shown, [self.shown.assumed] if self.shown.assumed else [])
        if self.second:
            said.append(f"  {_SECOND}")
        return said


def accepted_lines(shown: Proved | Refuted, assumed: Sequence[str]) -> list[str]:
    """The theorem, the hypotheses found to hold and what is assumed beside them, in lines of 80 columns.

    Parameters
    ----------
    shown : Proved or Refuted
        What the checker accepted.
    assumed : sequence of str
        What nothing shows, in clauses.
    """
    said = [("theorem", shown.theorem), *shown.facts.items(), *(("assumed", clause) for clause in assumed)]
    return [line for name, text in said for line in wrapped(f"  {name}: {text}", indent=4)]


def verified(file: str, *, second: bool, seconds: float | None) -> Verified:
    """Read and check one file; every outcome is a value and no exception.

    Parameters
    ----------
    file : str
        A path, or ``-`` for standard input.
    second : bool
        Whether the second checker is asked too; a disagreement is a rejection.
    seconds : float or None
        Time allowed to each checker, ten minutes by default; a file that takes longer is rejected.
    """
    data = _read(file)
    if isinstance(data, str):
        return Verified(file=file, result=NO_CERTIFICATE, reason=data)
    try:
        shown = check(data) if seconds is None else check(data, seconds=seconds)
    except Malformed as refusal:
        if (told := _report(file, data)) is not None:
            return Verified(file=file, result=NO_CERTIFICATE, reason=told)
        return Verified(file=file, result=NO_CERTIFICATE, reason=f"{_label(file)} is no certificate: {refusal}")
    except Rejected as refusal:
        return Verified(file=file, result=REJECTED, reason=str(refusal))
    except (MemoryError, RecursionError):
        return Verified(file=file, result=REJECTED, reason="checking it needs more memory than there is")
    except Exception as error:  # a fault of the checker accepts nothing
        fault = f"{type(error).__name__}: {error}"
        return Verified(file=file, result=REJECTED, reason=f"the checker stopped with {fault:.200}; please report it")
    if not second:
        return Verified(file=file, result=ACCEPTED, reason=shown.claim, shown=shown)
    against = _against(shown, LONGEST if seconds is None else seconds)
    if against:
        return Verified(file=file, result=REJECTED, reason=against, second=False)
    return Verified(file=file, result=ACCEPTED, reason=shown.claim, shown=shown, second=True)


def _against(shown: Proved | Refuted, seconds: float) -> str:
    """What the second checker says against a certificate that the first accepted; empty if it agrees."""
    from analysis.certificates.second import recheck_apart
    from analysis.certificates.second.reading import OUT_OF_TIME

    opinion = recheck_apart(shown.certificate, seconds=seconds)
    if opinion.accepted:
        return ""
    if opinion.reason == OUT_OF_TIME:
        return f"the second checker has not decided: {OUT_OF_TIME}"
    return f"the second checker disagrees: {opinion.reason or 'it gives no reason'}"


def _report(file: str, data: bytes) -> str | None:
    """What a ``report.json`` is, and where the certificates beside it are; None for any other file."""
    try:
        found = json.loads(data)
        if not str(found["schema"]).startswith("lure-report/"):
            return None
        names = [str(entry["file"]) for entry in found["certificates"]]
    except (ValueError, TypeError, LookupError, RecursionError):
        return None
    if not names:
        return f"{_label(file)} is a report and no certificate, and nothing in it was certified"
    folder = Path("." if file == "-" else file).parent
    where = " ".join(shlex.quote(str(folder / name)) for name in names)
    return f"{_label(file)} is a report and no certificate; its certificates are beside it: lure verify {where}"


def _read(file: str) -> bytes | str:
    """The content, cut off far beyond the size of any certificate, or a sentence on why there is none."""
    label = _label(file)
    if file == "-":
        return sys.stdin.buffer.read(MOST_BYTES)
    try:
        kind = Path(file).stat().st_mode
        if stat.S_ISDIR(kind):
            return f"{label} is a directory; give a certificate file, such as cert.json"
        if not stat.S_ISREG(kind):
            return f"{label} is not an ordinary file; give a certificate file, or - for standard input"
        with Path(file).open("rb") as content:
            return content.read(MOST_BYTES)
    except FileNotFoundError:
        return f"{label} does not exist; write a certificate with: lure certify plant.toml -o cert.json"
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        return f"{label} cannot be read ({reason}); give a readable file"


def _label(file: str) -> str:
    return "standard input" if file == "-" else repr(file)
