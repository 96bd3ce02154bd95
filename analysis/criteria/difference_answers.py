"""The answers of Tsypkin's and the Jury-Lee criterion, given what sets the two apart."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from types import MappingProxyType

from analysis.answer import Answer
from analysis.criteria.checks import finite_bounds
from analysis.criteria.difference_multiplier import DifferenceMultiplier, DifferenceReach, difference_reach
from analysis.criteria.discrete_block import DiscreteBlock, below
from analysis.criteria.hurwitz import hurwitz_limit
from analysis.doubles import text_above, text_below
from analysis.evidence import Bracket, Evidence, Verdict
from analysis.trigonometric import Laurent, least_on_circle
from lure.law_class import LawClass
from lure.rational import RationalBlock
from lure.sector import Sector, SlopeBounds

Bound = Fraction | float


@dataclass(frozen=True, kw_only=True, slots=True)
class Form:
    """One of the two criteria.

    Attributes
    ----------
    name, theorem, formula : str
        For the answer; ``formula`` is the left-hand side with ``q`` and ``k``.
    difference : Laurent
        What ``q`` multiplies.
    loss : Fraction
        The factor of ``-q K |(z - 1) H|^2``.
    slopes : callable
        The slope bounds the theorem needs, given lower and upper end of the sector and ``D`` of the shifted block.
    """

    name: str
    theorem: str
    formula: str
    difference: Laurent
    loss: Fraction
    slopes: Callable[[Bound, Bound, Fraction], SlopeBounds]


def largest_answer(block: RationalBlock, form: Form, *, lower: Fraction) -> Answer:
    """How far the criterion reaches from ``lower``.

    Parameters
    ----------
    block : RationalBlock
        In discrete time.
    form : Form
        The criterion.
    lower : Fraction
        Lower end of the class.
    """
    multiplier, reach = _reach(block, form, lower)
    if not reach.low > lower:
        return replace(
            _blank(multiplier, form, (lower, math.inf)),
            largest=Bracket(below(lower), reach.high),
            reason="No weight q was found that proves any slope above the lower one.",
        )
    margin, worst = _margin(multiplier, reach.q, reach.low)
    return replace(
        _blank(multiplier, form, (lower, reach.low)),
        largest=Bracket(reach.low, reach.high),
        verdict=Verdict.PROVED,
        parameters=MappingProxyType({"q": str(reach.q), "k": _text(reach.low)}),
        margin=margin,
        worst_frequency=worst,
        reason=f"With q = {float(reach.q):.8g} the inequality holds up to k = {text_below(reach.low)}, decided "
        f"exactly; no q reaches {text_above(reach.high)}.",
    )


def class_answer(block: RationalBlock, form: Form, bounds: SlopeBounds) -> Answer:
    """Whether the criterion proves one class.

    Parameters
    ----------
    block : RationalBlock
        In discrete time.
    form : Form
        The criterion.
    bounds : SlopeBounds
        Finite bounds.

    Raises
    ------
    AssumptionError
        A bound is infinite.
    """
    lower, upper = finite_bounds(bounds, form.name)
    multiplier, reach = _reach(block, form, lower)
    margin, worst = _margin(multiplier, reach.q, upper)
    proved = multiplier.certifies(upper - lower, reach.q)
    return replace(
        _blank(multiplier, form, (bounds.lower, bounds.upper)),
        largest=Bracket(reach.low if reach.low > lower else below(lower), reach.high),
        verdict=Verdict.PROVED if proved else Verdict.INCONCLUSIVE,
        parameters=MappingProxyType({"q": str(reach.q), "k": str(upper)}),
        margin=margin,
        worst_frequency=worst,
        reason="The inequality holds at every frequency, decided exactly."
        if proved
        else f"The criterion reaches {text_below(reach.low)} and not {text_above(reach.high)}; nothing follows about "
        "larger slopes.",
    )


def _reach(block: RationalBlock, form: Form, lower: Fraction) -> tuple[DifferenceMultiplier, DifferenceReach]:
    discrete = DiscreteBlock.of(block, lower, form.name)
    multiplier = DifferenceMultiplier(discrete=discrete, difference=form.difference, loss=form.loss)
    ceiling = hurwitz_limit(block, lower).high
    reach = difference_reach(multiplier)
    return multiplier, replace(reach, high=min(reach.high, ceiling))


def _margin(multiplier: DifferenceMultiplier, q: Fraction, k: Bound) -> tuple[Bracket, float]:
    if k == math.inf:
        discrete = multiplier.discrete
        top = (discrete.cross + (multiplier.difference * discrete.cross).scaled(q)).real_part()
    else:
        top = multiplier.inequality(Fraction(k) - multiplier.discrete.lower, q)
    margin, c = least_on_circle(top, multiplier.discrete.square)
    return margin, math.acos(min(max(c, -1.0), 1.0))


def _blank(multiplier: DifferenceMultiplier, form: Form, ends: tuple[Bound, Bound]) -> Answer:
    lower, upper = ends
    slopes = form.slopes(lower, upper, multiplier.discrete.feedthrough)
    law = LawClass(sector=Sector(lower, upper), slope=slopes)
    return Answer(
        criterion=form.name,
        theorem=form.theorem,
        largest=Bracket(below(Fraction(lower)), math.inf),
        law_class=law,
        verdict=Verdict.INCONCLUSIVE,
        evidence=Evidence.CERTIFIED,
        needs=("slope", "time-invariant"),
        multiplier=form.formula,
        hypotheses=(
            "every pole of H after the shift by the lower slope, hidden modes included, lies inside the unit circle: "
            "exact root count",
            "1 + kappa D > 0 for every gain kappa of the sector: exact",
            "the inequality at every frequency: exact root count of a polynomial in cos w",
            f"{law}, time-invariant" + (", continuous" if multiplier.discrete.feedthrough else "") + ": assumed",
        ),
    )


def _text(k: float) -> str:
    return "inf" if math.isinf(k) else str(Fraction(k))
