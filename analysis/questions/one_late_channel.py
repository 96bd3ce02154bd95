"""One nonlinearity around a plant with dead time, asked as the only one of a list: where its class does not begin at 0.

Such a question about slopes is one about the loop shifted by the lower one, if that is stable.
A question for the largest ``k`` of the classes ``[lower, k]`` is one for the largest factor of ``[lower, top]`` there.
So it is where the plant is unstable with the gain 0, or with small gains above it: gains of the class refute it.
"""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

from lure.analysis.inequality.delay import Delayed
from lure.analysis.numerics.doubles import bound_below, double_above, double_below
from lure.analysis.numerics.polynomial import from_descending, root_counts
from lure.analysis.questions.channels import Factors
from lure.analysis.questions.conclusion import conclusion_of
from lure.analysis.questions.largest import StabilityBound
from lure.analysis.questions.problem import Problem
from lure.analysis.theorems.table import BEST
from lure.analysis.verdict import Bracket, CriterionResult, Verdict
from lure.classes import Diagonal, NonlinearityClass, Sector, SlopeBounds
from lure.errors import AssumptionError, Reason
from lure.plants.delay import DelayPlant
from lure.plants.delay_matrix import one_channel_of


def as_one_channel(asked: Problem) -> Problem:
    """The question as one about a list with one class, if it does not begin at 0 or the plant is not stable from there.

    Else the question as it is.
    """
    plant, whole = asked.plant, asked.kind == "class"
    if not isinstance(plant, DelayPlant) or asked.endless_below:
        return asked
    one = asked.nonlinearity_class
    sloped = asked.question == "slope" or (whole and one.slope is not None and one.slope.lower == one.gains[0])
    lower = Fraction(one.gains[0]) if sloped and not (one.time_varying or one.linear) else Fraction(0)
    from_zero = one.sector.lower == lower
    if from_zero and plant.strictly_proper and _refused_from(plant, lower) is None:
        return asked
    if whole and (one.gains[1] == math.inf or not asked.provable or asked.refusals or asked.method != BEST):
        return asked
    classes = Diagonal((one if whole else _with_top(one, top_of(asked)),))
    known = () if asked.nonlinearity is None else (asked.nonlinearity,)
    listed = one_channel_of(plant)
    return replace(asked, plant=listed, classes=classes, nonlinearity=None, membership=None, known=known)


def _refused_from(plant: object, lower: Fraction = Fraction(0)) -> AssumptionError | None:
    """Why the plant is not stable with small gains above a lower one, or, with ``PRECISION``, not known to be."""
    assert isinstance(plant, DelayPlant), "asked of such plants"
    if not plant.strictly_proper:
        return None
    try:
        Delayed.of(plant, lower)
    except AssumptionError as refused:
        roots = root_counts(from_descending(plant.denominator))
        unstable = lower or refused.code is Reason.RESIDUE or plant.feedback or roots.right or roots.axis
        return refused if unstable else None
    return None


def top_of(asked: Problem) -> Fraction:
    """The upper bound at the factor 1: above the lower one, and of its size.

    ``asked``: the question for the largest ``k``.
    """
    return max(Fraction(1), 2 * asked.lower)


def _with_top(one: NonlinearityClass, top: Fraction) -> NonlinearityClass:
    slope = None if one.slope is None else SlopeBounds(one.slope.lower, top)
    return replace(one, sector=Sector(one.sector.lower, top), slope=slope)


def bound_of_factors(asked: Problem, found: Factors) -> StabilityBound:
    """The answer for the classes ``[lower, k]``, from what was found about factors.

    ``asked``: the question for the largest ``k``; ``found``: what was found about it as a question about a list with
    one class.
    """
    row, top, lower = found.bound, top_of(asked), asked.lower
    low, high, witness, concluded, reason = double_below(lower), math.inf, row.witness, row.conclusion, row.reason
    if row.verdict is Verdict.PROVED:
        low = double_below(top * max(factor for factor, _ in found.proofs))
    if found.against is not None and witness is not None:
        factor, shown = found.against
        proof = shown.certificate["proof"]
        between = proof["method"] == "late-crossing"  # of gains below 0, by a certificate of the class up to the top
        end = top * (factor or 1) if factor or between else max(Fraction(proof["gains"][0]), lower)
        high = double_above(end)
        witness = replace(witness, k=high)
        if row.verdict is Verdict.REFUTED:
            reason = "the class should begin where the plant is stable"
        elif row.verdict is Verdict.INCONCLUSIVE and lower == 0:
            refused = _refused_from(asked.plant)
            if refused is not None and refused.code is not Reason.PRECISION:  # by small gains
                concluded, reason = conclusion_of(found.asked.scaled(factor), shown), str(refused)
    return replace(
        row,
        question=asked.question,
        lower=lower,
        verdict=concluded.verdict,
        conclusion=concluded,
        reason=reason,
        largest=Bracket(low, max(low, high)),
        hurwitz=Bracket(low, max(low, high)),
        refuted_at=None if witness is None else high,
        witness=witness,
        answers=tuple(_of_top(one, top, low) for one in row.answers),
        classes=None,
    )


def _of_top(one: CriterionResult, top: Fraction, low: float) -> CriterionResult:
    """What a criterion shows, with ``k`` in place of the factor."""
    if one.proof is None:
        return replace(one, largest=Bracket(min(low, one.largest.low), math.inf), classes=None)
    end = double_below(top * Fraction(one.largest.low))
    return replace(one, largest=Bracket(end, math.inf), classes=None, reason=f"proved up to {bound_below(end)}")
