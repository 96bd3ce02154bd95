"""Each criterion asked about exactly one class of laws, cheapest first."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from importlib import import_module

from analysis.answer import Answer
from analysis.answers.catalogue import Entry, Question, entries
from analysis.answers.rods import rod_largest
from analysis.certificates.multipliers import Upper
from analysis.evidence import Verdict
from lure.delay import DelayBlock
from lure.errors import AssumptionError
from lure.exact import exact_number
from lure.law_class import LawClass
from lure.rational import RationalBlock
from lure.sector import Sector, SlopeBounds
from lure.upwind import UpwindScheme

Ask = Callable[[], Answer]
_SECTOR = {
    "circle": "circle:circle_criterion",
    "popov": "popov:popov_criterion",
    "hurwitz": "hurwitz:hurwitz_criterion",
}
_SLOPE = {
    "off-axis-circle": "off_axis:off_axis_criterion",
    "park": "park:park_criterion",
    "tsypkin": "tsypkin:tsypkin_criterion",
    "jury-lee": "jury_lee:jury_lee_criterion",
}
LONG = "zames-falb, full effort"  # takes minutes
_ONE_SIDED = ("tsypkin", "jury-lee")


def questions(
    block: RationalBlock | DelayBlock | UpwindScheme, law_class: LawClass, criterion: str, *, finite: bool
) -> Iterator[tuple[str, Upper, Ask]]:
    """The criteria that serve a class, each with the upper end to certify and a function that asks it.

    Parameters
    ----------
    block : RationalBlock, DelayBlock or UpwindScheme
        The block.
    law_class : LawClass
        The class.
    criterion : str
        A name, or ``best`` for all that apply.
    finite : bool
        Whether an infinite upper end means every law with some finite bound.

    Yields
    ------
    tuple of str, Fraction or str, callable
        The name, the upper end, and what gives the answer, PROVED where the whole class is.

    Raises
    ------
    InputError
        There is no such criterion.
    AssumptionError
        It does not apply to such a class or block.
    """
    question: Question = "sector" if law_class.slope is None else "slope"
    found = entries(block, question, criterion, time_varying=law_class.time_varying)
    for entry in found:
        for bounds in _bounds(entry, law_class):
            upper: Upper = Fraction(bounds.upper) if bounds.upper != math.inf else "finite" if finite else "inf"
            yield entry.name, upper, _ask(block, entry, bounds, law_class, finite=finite)
    if isinstance(block, RationalBlock) and block.dt is None and "zames-falb" in [entry.name for entry in found]:
        slope = law_class.slope
        if slope is not None and slope.upper != math.inf:
            yield (
                LONG,
                Fraction(slope.upper),
                lambda: _zames_falb(block, slope, law_class, full=True),
            )


def _bounds(entry: Entry, law_class: LawClass) -> list[Sector] | list[SlopeBounds]:
    """What the criterion is asked about: the sector, the slope, or for those with a slope bound on one side both."""
    slope = law_class.slope
    if not entry.slope or slope is None:
        return [law_class.sector]
    tight = SlopeBounds(law_class.sector.lower, law_class.sector.upper)
    return [tight, slope] if entry.name in _ONE_SIDED and tight != slope else [slope]


def _ask(
    block: RationalBlock | DelayBlock | UpwindScheme,
    entry: Entry,
    bounds: Sector | SlopeBounds,
    law_class: LawClass,
    *,
    finite: bool,
) -> Ask:
    if isinstance(block, DelayBlock):
        from analysis.dead_time.criteria import LARGEST

        return lambda: _reaching(LARGEST[entry.name](block), bounds)
    if isinstance(block, UpwindScheme):
        return lambda: _reaching(rod_largest(block, entry.name), bounds)
    if finite and bounds.upper == math.inf:
        lower = exact_number(bounds.lower, "lower") if bounds.lower != -math.inf else None
        if lower is None:
            return _endless
        return lambda: _reaching(entry.largest(block, lower=lower, odd=law_class.odd), bounds)
    if entry.name == "zames-falb":
        return lambda: _zames_falb(block, bounds, law_class, full=False)
    module, function = {**_SECTOR, **_SLOPE}[entry.name].split(":")
    call: Callable[[RationalBlock, Sector | SlopeBounds], Answer]
    call = getattr(import_module(f"analysis.criteria.{module}"), function)
    return lambda: call(block, bounds)


def _endless() -> Answer:
    raise AssumptionError("the class has no finite lower end, and no theorem here begins at -inf; give a lower bound")


def _reaching(answer: Answer, bounds: Sector | SlopeBounds) -> Answer:
    """The answer about the largest class, if the class asked about is inside it."""
    if bounds.lower < answer.law_class.sector.lower:
        raise AssumptionError(
            f"for such a block the classes begin at {float(answer.law_class.sector.lower):g}; for a DelayBlock or a "
            "rod close a loop with the lower gain in the model first"
        )
    if answer.verdict is Verdict.PROVED and bounds.upper > answer.largest.low:
        reason = f"what is proved ends at {answer.largest.low:.10g}"
        return replace(answer, verdict=Verdict.INCONCLUSIVE, reason=reason)
    return answer


def _zames_falb(block: RationalBlock, bounds: Sector | SlopeBounds, law_class: LawClass, *, full: bool) -> Answer:
    slope = SlopeBounds(bounds.lower, bounds.upper)
    if block.dt is not None:
        from analysis.criteria.zames_falb_discrete import zames_falb_discrete_criterion

        return zames_falb_discrete_criterion(block, slope, odd=law_class.odd)
    from analysis.criteria.zames_falb import zames_falb_criterion

    return zames_falb_criterion(block, slope, odd=law_class.odd, effort="full" if full else "quick")
