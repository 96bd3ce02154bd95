"""The verdict on the class asked about, from the table of classes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, cast

from analysis.answers.advice import serves, why
from analysis.answers.certifying import restated, unbounded_proof
from analysis.answers.conclusion import Conclusion, conclusion_of, inquiry_about, undecided
from analysis.answers.largest import Largest
from analysis.answers.subject import Subject
from analysis.criteria.circle import circle_criterion
from analysis.criteria.popov import popov_criterion
from analysis.evidence import Verdict
from lure.errors import AssumptionError
from lure.law_class import LawClass
from lure.rational import RationalBlock
from lure.sector import Sector

if TYPE_CHECKING:
    from analysis.certificates.checker import Proved, Refuted


def asked_row(rows: list[Largest], law_class: LawClass | None) -> Largest | None:
    """The row whose class is that of the question, of the four in their order of the table."""
    if law_class is None:
        return None
    if law_class.time_varying:
        return rows[0]
    if law_class.slope is None:
        return rows[1]
    return rows[3] if law_class.odd else rows[2]


def decided(about: Subject, rows: list[Largest]) -> Conclusion:
    """What follows for the class asked about, without one for the row that reaches farthest.

    Everything that the checker accepted of any row is tried; :func:`analysis.answers.conclusion.conclusion_of` judges
    whether it fits.
    """
    law_class, asked = about.law_class, asked_row(rows, about.law_class)
    if law_class is None or asked is None:
        best = max(rows, key=lambda row: (row.verdict is Verdict.PROVED, row.largest.low, not row.time_varying))
        return best.conclusion
    inquiry = inquiry_about(about.block, law_class, nonlinearity=about.law)
    ordered = [asked, *(row for row in rows if row is not asked)]
    missed: list[Conclusion] = []
    for proof in _proofs(about, ordered, law_class):
        found = conclusion_of(inquiry, restated(proof, inquiry), reach=proof)
        if found.verdict is Verdict.PROVED:
            return found
        missed.append(found)
    for row in ordered:
        for refuted, beside in pairwise((*row.refutations, None)):
            found = conclusion_of(inquiry, restated(cast("Refuted", refuted), inquiry), beside=beside)
            if found.verdict is Verdict.REFUTED:
                return found
    code, reason = why(asked, rows, law_class, missed)
    return undecided(inquiry, reason, code=code)


def _proofs(about: Subject, rows: list[Largest], law_class: LawClass) -> Iterator[Proved]:
    """What was accepted of the rows, those that may serve; of laws without an upper bound beside every finite one."""
    for row in rows:
        end = law_class.slope.upper if row.question == "slope" and law_class.slope else law_class.sector.upper
        if row.proof is None or not serves(row, law_class) or row.largest.low < end:
            continue
        endless = _unbounded(about, row, law_class) if end == math.inf else None
        yield from (proof for proof in (endless, row.proof) if proof is not None)


def _unbounded(about: Subject, row: Largest, law_class: LawClass) -> Proved | None:
    """What is accepted of the class without an upper bound: every finite ``k`` is less than that.

    ``sigma^3`` lies in ``[0, inf]`` and in no ``[0, k]``.
    """
    block = about.block
    if not isinstance(block, RationalBlock):
        return None
    sector = Sector(row.lower, math.inf)
    criterion = circle_criterion if law_class.time_varying else popov_criterion
    try:
        return unbounded_proof(block, criterion(block, sector), time_varying=law_class.time_varying)
    except AssumptionError:
        return None
