"""Certificates in the making: the parts of a certificate that the checker arrives at by itself, filled in."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from analysis.certificates.blocks import block
from analysis.certificates.checker import (
    CONVENTION,
    FORMAT,
    Proved,
    Refuted,
    check,
    inequality,
    polynomial_proof,
    unbounded,
)
from analysis.certificates.states import classes
from analysis.deadline import time_left

LONGEST = 600.0  # [s] for one check


def settled(draft: Mapping[str, Any]) -> Proved | Refuted:
    """What the checker makes of a draft: its ``certificate`` is complete, with polynomial, conclusion and hypotheses.

    Parameters
    ----------
    draft : Mapping
        ``verdict``, ``system``, ``laws``, ``theorem`` and ``proof``, in the format of
        ``notebooks/notes/0008-certificates.md``; ``multiplier``, ``law`` and ``numbers`` where they are not empty.

    Raises
    ------
    ValueError
        ``Rejected`` or ``Malformed``: the draft proves nothing.
    """
    certificate: dict[str, Any] = {
        "format": FORMAT,
        "convention": CONVENTION,
        "numbers": "rationals",
        "law": None,
        "multiplier": {},
        **draft,
        "conclusion": "",
        "hypotheses": {},
    }
    if certificate["proof"].get("method") == "polynomial" and certificate["theorem"] != "hurwitz":
        laws, name, data = classes(certificate["laws"]), certificate["theorem"], certificate["multiplier"]
        F, _, critical, _ = inequality(name, data, block(certificate["system"]), laws)
        certificate["proof"] = polynomial_proof(F, critical=critical, bounded=not unbounded(name, data, laws))
    return check(certificate, draft=True, seconds=max(min(time_left(), LONGEST), 0.0))


def completed(draft: Mapping[str, Any]) -> dict[str, Any]:
    """The certificate of a draft; see :func:`settled`.

    Parameters
    ----------
    draft : Mapping
        The draft.

    Raises
    ------
    ValueError
        ``Rejected`` or ``Malformed``: the draft proves nothing.
    """
    return dict(settled(draft).certificate)
