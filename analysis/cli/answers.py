"""The answers of ``lure max-sector`` and ``lure max-slope`` in a few lines to quote."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from analysis.answers import Largest
    from analysis.criteria.hurwitz import GainInterval
    from analysis.evidence import Bracket
    from analysis.witness import Witness

WIDTH = 80


def lines(found: Largest, *, stable: Sequence[GainInterval] | None) -> list[str]:
    """What is proved, what is refuted, the linear limit, the multiplier and, where nothing is proved, why.

    Parameters
    ----------
    found : Largest
        The answer.
    stable : sequence of GainInterval or None
        The intervals of stable linear gains, None if they were not computed.
    """
    from analysis.evidence import Verdict

    proved, refuted = found.verdict is Verdict.PROVED, found.verdict is Verdict.REFUTED
    said = [_claim(found)]
    if found.witness is not None and found.refuted_at is not None:
        if refuted:
            said = [f"{said[0][:-1]}: {refutation(found.trivial or found.witness)}."]
            if found.trivial is not None:
                said.append(f"From k = {found.witness_text} on also {refutation(found.witness)}.")
        else:
            said.append(f"Refuted from {found.refuted_text} on: {refutation(found.witness)}.")
        if proved and not found.closed:
            said.append("Nothing was shown in between.")
    if stable is not None and not stable:
        said.append("No linear gain makes the loop stable.")
    elif not refuted:
        said.append(linear(found.hurwitz, found.lower))
    if proved and found.multiplier and found.multiplier != "1":
        theta = "" if found.theta is None or "theta" not in found.multiplier else f", theta = {found.theta:.7g}"
        said.append(f"Multiplier: {found.multiplier}{theta}.")
    if found.unfinished:
        said.append(found.unfinished)
    if not proved and found.reason:
        said.append(f"Reason: {found.reason}.")
    if refuted and stable:
        where = " and ".join(map(str, stable))
        said.append(f"Linear gains in {where} are stable; begin the class there, as with --lower={stable[0].sample}.")
    joined = [text.replace("phi = ", "phi\xa0=\xa0").replace("k = ", "k\xa0=\xa0") for text in said]
    joined = [re.sub(r"(\[[^,\]\s]+), ", "\\1,\xa0", text) for text in joined]
    wrapped = [line for text in joined for line in textwrap.wrap(text, WIDTH, break_on_hyphens=False)]
    return [line.replace("\xa0", " ") for line in wrapped]


def _claim(found: Largest) -> str:
    from analysis.doubles import bound_above, bound_below
    from analysis.evidence import Verdict

    low, classes = found.largest.low, f"{found.about} [{bound_above(found.lower)}, k]"
    if found.verdict is Verdict.PROVED:
        tried = ", the largest k tried" if found.capped else ""
        return f"{found.conclusion.headline[:-1]}{tried}, by {found.criterion} ({found.evidence})."
    if found.verdict is Verdict.REFUTED:
        return f"Not stable for every {classes}, whatever k."
    if low > found.lower:
        reached = f"{found.criterion} reaches {bound_below(low)}, {found.evidence} only"
        return f"Nothing is proved for {classes}; {reached}."
    return f"Nothing is proved for {classes}."


def refutation(witness: Witness) -> str:
    """What a destabilising law is and does, linear ones in short.

    Parameters
    ----------
    witness : Witness
        The law.
    """
    law, colon, rest = witness.description.partition(": ")
    gain = witness.data.get("gain")
    if witness.kind == "linear gain" and isinstance(gain, str) and colon:
        factor = {"1": "", "-1": "-"}.get(gain, f"{gain} ")
        law = "without feedback (phi = 0)" if Fraction(gain) == 0 else f"with phi = {factor}sigma"
        return f"{law} {rest} ({witness.evidence})"
    return f"{witness.description} ({witness.evidence})"


def linear(limit: Bracket, lower: Fraction) -> str:
    """For which linear gains above ``lower`` the loop is stable.

    Parameters
    ----------
    limit : Bracket
        Of the largest.
    lower : Fraction
        Where the classes begin.
    """
    if limit.high <= lower:
        return "Linear gains at the lower end of the class are not stable."
    if limit.low == math.inf:
        return "Every larger linear gain is stable." if lower else "Every positive linear gain is stable."
    if limit.high == math.inf:
        return f"Linear gains are stable up to {limit.low:.7g} at least."
    return f"Linear gains are stable up to {limit.middle:.7g}."
