"""The gate of every answer: what a criterion or a search claims is put before the checker, and only then said."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING

from lure.analysis.inequality.gains import is_stable_gain
from lure.analysis.numerics.doubles import double_above, double_below, short
from lure.analysis.verdict import Answer, Bracket, Evidence, Verdict, Witness
from lure.plants.delay import DelayPlant
from lure.plants.frequency_data import FrequencyData
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Proved, Refuted
    from lure.analysis.certificates.proposals import Certified
    from lure.analysis.questions.problem import Problem


def proved_answer(asked: Problem, answer: Answer) -> Answer:
    """The answer with what the checker accepted of it; INCONCLUSIVE where it accepted nothing.

    Parameters
    ----------
    asked : Problem
        The question.
    answer : Answer
        What a criterion says.

    Returns
    -------
    Answer
        With ``proof``, and ``largest.low`` lowered to the class that was accepted.
    """
    from lure.analysis.certificates.proposals import certified
    from lure.analysis.certificates.sealing import Failure, guarded

    block = asked.plant
    if isinstance(block, StateSpace):
        from lure.analysis.certificates.by_matrices import certified_by_matrix

        by_matrix = guarded(answer.criterion, lambda: certified_by_matrix(block, answer), passing=(TimeoutError,))
        if isinstance(by_matrix, Failure):
            return replace(answer, verdict=Verdict.INCONCLUSIVE, reason=f"not certified: {by_matrix}")
        return by_matrix
    if answer.verdict is not Verdict.PROVED or isinstance(block, FrequencyData):
        return answer
    wide = answer
    if asked.time_varying and not answer.law_class.time_varying:
        wide = replace(answer, law_class=replace(answer.law_class, time_varying=True))
    found = guarded(answer.criterion, lambda: certified(block, wide), passing=(TimeoutError,))
    if isinstance(found, Failure):
        return replace(answer, verdict=Verdict.INCONCLUSIVE, reason=f"not certified: {found}")
    search_limited = answer.largest.low == math.inf and isinstance(found.upper, Fraction)
    reach = _reach(answer, found)
    tried = f"{reach.low:g}".replace("e+", "e")
    reason = f"{tried} is the largest k for which a certificate was tried" if search_limited else answer.reason
    return replace(answer, largest=reach, proof=found.proved, search_limited=search_limited, reason=reason)


def unbounded_proof(block: RationalPlant, answer: Answer, *, time_varying: bool) -> Proved | None:
    """What the checker accepted of an answer about a sector without an upper bound; None for nothing.

    Parameters
    ----------
    block : RationalPlant
        The block.
    answer : Answer
        What a criterion says.
    time_varying : bool
        Whether the laws may vary.
    """
    from lure.analysis.certificates.proposals import certified
    from lure.analysis.certificates.sealing import Failure, guarded

    if answer.verdict is not Verdict.PROVED:
        return None
    if time_varying and not answer.law_class.time_varying:
        answer = replace(answer, law_class=replace(answer.law_class, time_varying=True))
    found = guarded(answer.criterion, lambda: certified(block, answer, "inf"))
    return None if isinstance(found, Failure) or found.upper != "inf" else found.proved


def restated(shown: Proved | Refuted, asked: Problem) -> Proved | Refuted:
    """What was accepted, stated for exactly the class asked about and the nonlinearity given, where that is accepted.

    Parameters
    ----------
    shown : Proved or Refuted
        What was accepted, of another class as a rule.
    asked : Problem
        What is asked.
    """
    from lure.analysis.certificates.sealing import guarded, settled
    from lure.analysis.certificates.systems import law_of

    proved = shown.certificate["verdict"] == "PROVED"
    drafts = [{**shown.certificate, "laws": dict(asked.laws)}]
    written = law_of(asked.nonlinearity) if proved else None
    if written is not None:
        drafts = [{**draft, "law": written} for draft in (drafts[0], shown.certificate)] + drafts
    for draft in drafts:
        found = guarded("the class asked about", partial(settled, draft))
        if type(found) is type(shown):
            return found
    return shown


def _reach(answer: Answer, found: Certified) -> Bracket:
    """The largest class, as far as it was accepted."""
    largest = answer.largest
    if isinstance(found.upper, Fraction) and found.upper < largest.low:
        return Bracket(double_below(found.upper), largest.high)
    return largest


def refuted_witness(asked: Problem, witness: Witness) -> Witness:
    """The witness with what the checker accepted of it; COMPUTED where it accepted nothing.

    Parameters
    ----------
    asked : Problem
        The question.
    witness : Witness
        A destabilising member.
    """
    from lure.analysis.certificates.checker import Refuted
    from lure.analysis.certificates.sealing import guarded

    block = asked.plant
    if witness.evidence is not Evidence.CERTIFIED or not isinstance(block, RationalPlant | DelayPlant):
        return witness
    for candidate in (witness, *_just_above(block, witness)):
        found = guarded(candidate.kind, partial(_refuted, block, candidate), passing=(TimeoutError,))
        if isinstance(found, Refuted):
            return _as_accepted(candidate, found)
    return replace(witness, evidence=Evidence.COMPUTED)


def _as_accepted(witness: Witness, found: Refuted) -> Witness:
    """The witness with the gain of its certificate: a larger one where the gain at a critical end refutes nothing."""
    gain = found.certificate["proof"].get("gain")
    if gain is None or gain == witness.data.get("gain"):
        return replace(witness, refutation=found)
    return replace(
        witness,
        k=double_above(Fraction(gain)),
        description=f"phi = {short(Fraction(gain))} sigma: the loop is not asymptotically stable",
        data={**witness.data, "gain": gain},
        refutation=found,
    )


def _refuted(block: RationalPlant | DelayPlant, witness: Witness) -> Proved | Refuted:
    from lure.analysis.certificates.refutations import refutation_draft
    from lure.analysis.certificates.sealing import settled

    return settled(refutation_draft(block, witness))


def _just_above(block: RationalPlant | DelayPlant, witness: Witness) -> Iterator[Witness]:
    """Gains just above a linear one that only makes other equilibria: at the end of a class they refute nothing."""
    if witness.kind != "linear gain" or not isinstance(witness.data.get("gain"), str):
        return
    gain = Fraction(str(witness.data["gain"]))
    for exponent in (40, 30, 20):
        above = gain + max(abs(gain), Fraction(1, 2**exponent)) / 2**exponent
        if isinstance(block, RationalPlant) and not is_stable_gain(block, above):
            yield replace(
                witness,
                k=double_above(above),
                description=f"phi = k sigma, k just above {short(gain)}: the loop is not asymptotically stable",
                data={**witness.data, "gain": str(above)},
            )
