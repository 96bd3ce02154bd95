"""A certificate as a file for Coq: a theorem about the plant's own coefficients, and its proof by computation.

Beside the theorem the file holds all that it needs but Coq's standard library, from the files ``*.v`` of this folder,
which are the same for every loop.  Of each kind of certificate a function writes it, from ``data``, the certificate,
and ``claim``, the sentence of the checker.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from lure.analysis.certificates.arithmetic import number
from lure.analysis.certificates.checker import Checked, Proved
from lure.analysis.export.beside import beside_text
from lure.analysis.export.beyond import beyond_text
from lure.analysis.export.decaying import decaying_text
from lure.analysis.export.driven import driven_text
from lure.analysis.export.everywhere import everywhere_text
from lure.analysis.export.falling import falling_text
from lure.analysis.export.gained import in_states
from lure.analysis.export.gaining import gaining_text, has_gain
from lure.analysis.export.hulls import SteppedTheorem
from lure.analysis.export.jumping import jumping_text
from lure.analysis.export.kernels import Kernels
from lure.analysis.export.members import members_text
from lure.analysis.export.modes import METHODS, mode_text
from lure.analysis.export.orbits import orbit_text
from lure.analysis.export.pacing import pacing_text
from lure.analysis.export.powers import PoweredTheorem, powers_text
from lure.analysis.export.regional import regional_text
from lure.analysis.export.relying import THEOREMS, relying_text
from lure.analysis.export.returning import returning_text
from lure.analysis.export.switching import switched_text
from lure.analysis.export.through import through_text
from lure.analysis.export.words import refused
from lure.errors import InputError


def coq_text(shown: Checked) -> str:
    """A certificate as a Coq file: a theorem about its plant and class, which ``coqc`` 8.16 or later checks.

    Parameters
    ----------
    shown : Proved or Refuted
        What the checker accepted: ``check(certificate)``.

    Returns
    -------
    str
        The file.  It ends with ``Print Assumptions``, which shows what the proof rests on.

    Raises
    ------
    refused
        An ``InputError``: it cannot be exported; what it claims is of a kind that no file is written for.
    """
    data = shown.certificate
    if "delay" in data["system"]["kind"]:
        raise refused("its plant has dead time, beside which there is no export")
    if not isinstance(shown, Proved):
        method = data["proof"]["method"]
        if "rate" in data:
            return pacing_text(data, shown.claim)
        if method == "linear-members" or "unlimited" in data["proof"]:
            return driven_text(data, shown.claim)
        constant = members_text if data["system"]["kind"] == "state-space" else _constant
        written = {"linear-gains": members_text, "growth": beyond_text, "flow-orbit": returning_text} | dict.fromkeys(
            METHODS, constant
        )
        if method in ("switched-gain", "switched-gains"):
            discrete = data["system"].get("time") == "discrete"
            return (switched_text if discrete else jumping_text)(data, shown.claim)
        return written.get(method, orbit_text)(data, shown.claim)
    if isinstance(data["laws"], dict) and "graphs" in data["laws"]:
        everywhere = data["proof"]["method"] == "everywhere"
        return (everywhere_text if everywhere else regional_text)(data, shown.claim)
    if has_gain(data):
        if "rate" in data or data["proof"]["method"] == "parts":
            raise refused("it is a gain with a rate, or of parts; a gain alone has an export")
        return gaining_text(data, shown.claim)
    if "rate" in data:
        return decaying_text(data, shown.claim)
    if data["theorem"] == "matrix-zames-falb":
        return Kernels(data).text(shown.claim)
    if data["proof"]["method"] == "parts":
        return beside_text(data, shown.claim)
    if data["proof"]["method"] == "powers":
        kind = SteppedTheorem if data["system"]["time"] == "discrete" else PoweredTheorem
        return powers_text(data, shown.claim, kind)
    covered = data["proof"]["method"] == "cover" and data["system"]["kind"] == "transfer"
    if data["theorem"] in THEOREMS and (covered or data["proof"]["method"] == "polynomial"):
        return relying_text(data, shown.claim)
    return (through_text if _has_feedthrough(data) else falling_text)(data, shown.claim)


def _constant(data: Mapping[str, Any], claim: str) -> str:
    """A constant gain of two polynomials: by a root whose place can be told, else by a form that grows."""
    try:
        return mode_text(data, claim)
    except InputError as reason:
        with suppress(InputError):
            return members_text(in_states(data), claim)
        raise reason from None


def _has_feedthrough(data: Mapping[str, Any]) -> bool:
    """Whether Popov's term meets a feedthrough of two polynomials."""
    system = data["system"]
    if data["theorem"] != "popov" or system["kind"] != "transfer" or not number(data["multiplier"]["theta"]):
        return False
    return len(system["numerator"]) == len(system["denominator"]) and number(system["numerator"][0]) != 0
