"""The kinds of block a question can be about: rational, with dead time, too large for exact polynomials, measured."""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from importlib import import_module
from typing import Literal, cast

from lure.analysis.inequality.plant import Plant
from lure.analysis.numerics.doubles import double_below
from lure.analysis.numerics.precision import ball, outward
from lure.analysis.questions.certifying import refuted_witness
from lure.analysis.questions.state_space import growing_gain, state_space_answer
from lure.analysis.rod.questions import rod_hurwitz, rod_largest
from lure.analysis.verdict import Answer, Bracket, Evidence, Verdict, Witness
from lure.classes import LawClass, Sector, SlopeBounds
from lure.errors import AssumptionError, InputError
from lure.plants.delay import DelayBlock
from lure.plants.frequency_data import FrequencyData
from lure.plants.rational import RationalBlock
from lure.plants.state_space import StateSpaceBlock
from lure.rod.transfer import RodBlock
from lure.rod.upwind import UpwindScheme

# Which criteria there are, for which time and for which class of laws; each is imported when it is asked for.

Question = Literal["sector", "slope"]
Time = Literal["continuous", "discrete"]
BEST = "best"


@dataclass(frozen=True, slots=True)
class Entry:
    """A criterion as the questions see it.

    Attributes
    ----------
    name : str
        Its name.
    times : tuple of {"continuous", "discrete"}
        Where it applies.
    slope : bool
        Whether it needs slope bounds; else a sector is enough.
    time_varying : bool
        Whether its conclusion covers time-varying laws.
    place : str
        ``module:function`` of the search for the largest ``k``.
    stage : int
        0: cheap and of interest by itself; 1: cheap; 2: dear.  Those of a later stage are asked while a gap is left.
    odd : bool
        Whether the function takes ``odd``.
    """

    name: str
    times: tuple[Time, ...]
    slope: bool
    time_varying: bool
    place: str
    stage: int = 0
    odd: bool = False

    def largest(self, block: RationalBlock, *, lower: Fraction, odd: bool) -> Answer:
        """The largest ``k`` of the classes ``[lower, k]`` that the criterion proves."""
        module, function = self.place.split(":")
        call = cast("Callable[..., Answer]", getattr(import_module(f"lure.analysis.{module}"), function))
        if not self.odd:
            return call(block, lower=lower)
        found = call(block, lower=lower, odd=odd)
        if not odd or block.dt is None:
            return found
        monotone = call(block, lower=lower, odd=False)  # odd laws are monotone laws
        return monotone if monotone.largest.low > found.largest.low else found


_BOTH: tuple[Time, ...] = ("continuous", "discrete")
_FLOW, _MAP = _BOTH[:1], _BOTH[1:]
_SLOPE = {"slope": True, "time_varying": False}
CATALOGUE = (  # in each stage the cheapest first
    Entry("hurwitz", _BOTH, slope=False, time_varying=False, place="inequality.gains:hurwitz_largest"),
    Entry("circle", _BOTH, slope=False, time_varying=True, place="theorems.circle:circle_largest"),
    Entry("popov", _FLOW, slope=False, time_varying=False, place="theorems.popov:popov_largest"),
    Entry("park", _FLOW, **_SLOPE, place="theorems.park:park_largest", stage=1),
    Entry("off-axis-circle", _FLOW, **_SLOPE, place="theorems.off_axis:off_axis_largest", stage=1),
    Entry("tsypkin", _MAP, **_SLOPE, place="theorems.differences:tsypkin_largest", stage=1),
    Entry("jury-lee", _MAP, **_SLOPE, place="theorems.differences:jury_lee_largest", stage=1),
    Entry("zames-falb", _FLOW, **_SLOPE, place="theorems.zames_falb:zames_falb_largest", stage=2, odd=True),
    Entry(
        "zames-falb",
        _MAP,
        **_SLOPE,
        place="theorems.zames_falb_discrete:zames_falb_discrete_largest",
        stage=2,
        odd=True,
    ),
)
CRITERIA = tuple(dict.fromkeys(entry.name for entry in CATALOGUE))
"""The names of the criteria, to ask for one of them."""


def entries(block: object, question: Question, criterion: str, *, time_varying: bool = False) -> list[Entry]:
    """The criteria to run for a question.

    Parameters
    ----------
    block : RationalBlock, DelayBlock or StateSpaceBlock
        The block.
    question : {"sector", "slope"}
        What is known of the law; a slope-restricted law lies in the sector of the same bounds, so that the criteria for
        sectors serve it too.
    criterion : str
        A name, or ``best`` for all that apply (without ``hurwitz``, which proves nothing about nonlinear laws).
    time_varying : bool
        Whether the law may vary with time.

    Raises
    ------
    InputError
        There is no such criterion.
    AssumptionError
        It does not apply to this question.
    """
    time: Time = "continuous" if getattr(block, "dt", None) is None else "discrete"
    wanted = criterion.replace("_", "-").lower()
    wanted = {"off-axis": "off-axis-circle", "yakubovich": "park", "zf": "zames-falb"}.get(wanted, wanted)
    if wanted != BEST and wanted not in CRITERIA:
        near = difflib.get_close_matches(wanted, CRITERIA, n=1)
        hint = f"did you mean {near[0]!r}? " if near else ""
        raise InputError(f"there is no criterion {criterion!r}; {hint}choose from {BEST}, {', '.join(CRITERIA)}")
    exact = isinstance(block, RationalBlock)  # for other blocks there are only the criteria for sectors
    found = [entry for entry in CATALOGUE if time in entry.times and (exact or not entry.slope)]
    if wanted == BEST:
        return [
            entry
            for entry in found
            if entry.name != "hurwitz"
            and (question == "slope" or not entry.slope)
            and (entry.time_varying or not time_varying)
        ]
    named = [entry for entry in CATALOGUE if entry.name == wanted and time in entry.times]
    found = [entry for entry in found if entry.name == wanted]
    if named and not found:
        raise AssumptionError(
            f"the criterion {wanted} is evaluated for rational blocks of moderate order only; for this one ask circle "
            "or popov"
        )
    if not found:
        other = "discrete" if time == "continuous" else "continuous"
        raise AssumptionError(f"the criterion {wanted} is for {other} time, this block is in {time} time; try {BEST}")
    if question == "sector" and found[0].slope:
        raise AssumptionError(
            f"the criterion {wanted} needs slope bounds, and a sector gives none; ask for the largest slope "
            "(max_slope, lure max-slope)"
        )
    if time_varying and not found[0].time_varying:
        raise AssumptionError(f"the criterion {wanted} is for time-invariant laws; for time-varying ones ask circle")
    return found


REFUSED = "does not apply"
NOT_NEEDED = "not needed"
EXPECTED = (AssumptionError, InputError, OverflowError)  # said by the question itself
Search = Literal["linear", "full"]
Block = RationalBlock | DelayBlock | StateSpaceBlock | FrequencyData | UpwindScheme | RodBlock


@dataclass(frozen=True, kw_only=True, slots=True)
class Asked:
    """A question: the largest ``k`` of the classes ``[lower, k]`` for a block."""

    block: Block
    question: Question
    criterion: str
    lower: Fraction
    odd: bool
    time_varying: bool
    search: Search


def hurwitz(asked: Asked) -> Bracket:
    """Supremum of the ``k`` such that every linear gain in ``[lower, k]`` is stable (in the critical case: but 0)."""
    block = asked.block
    if isinstance(block, RationalBlock):
        from lure.analysis.inequality.gains import hurwitz_limit

        if Plant.of(block).shifted(asked.lower).case == "unstable":  # lower itself, a member of every class
            return outward(ball(asked.lower), ball(asked.lower))
        return hurwitz_limit(block, asked.lower)
    if isinstance(block, StateSpaceBlock):
        witness = growing_gain(block, asked.lower)
        return Bracket(double_below(asked.lower), math.inf if witness is None else witness.k)
    _from_zero(asked)
    if isinstance(block, DelayBlock):
        from lure.analysis.theorems.dead_time import hurwitz_limit as with_dead_time

        return with_dead_time(block)
    if isinstance(block, UpwindScheme | RodBlock):
        return rod_hurwitz(block)
    return Bracket(0.0, math.inf)


def critical(asked: Asked) -> bool:
    """Whether the loop with the gain ``lower`` has a pole at 0 (``z = 1``): laws of the class add equilibria."""
    block = asked.block
    if isinstance(block, RationalBlock):
        return Plant.of(block).shifted(asked.lower).case == "critical"
    if isinstance(block, DelayBlock):
        return block.denominator[-1] == 0
    return isinstance(block, UpwindScheme | RodBlock)


def answer_of(entry: Entry, asked: Asked) -> Answer | str:
    """What one criterion says, before the checker has seen it; that it refuses or fails, and why, as text.

    Raises
    ------
    TimeoutError
        The time allowed is over.
    """
    from lure.analysis.certificates.sealing import Failure, guarded

    try:
        found = guarded(entry.name, lambda: _largest(entry, asked), passing=(*EXPECTED, TimeoutError))
    except (AssumptionError, InputError) as refusal:
        return str(refusal)
    return f"the search failed: {found}" if isinstance(found, Failure) else found


def _largest(entry: Entry, asked: Asked) -> Answer:
    block = asked.block
    if isinstance(block, RationalBlock):
        return entry.largest(block, lower=asked.lower, odd=asked.odd)
    if isinstance(block, DelayBlock):
        from lure.analysis.theorems.dead_time import LARGEST

        return LARGEST[entry.name](block)
    if isinstance(block, UpwindScheme | RodBlock):
        return rod_largest(block, entry.name)
    if isinstance(block, StateSpaceBlock):
        return state_space_answer(block, entry.name, asked.lower)
    from lure.analysis.inequality.samples import largest_sampled

    return largest_sampled(block, entry.name)


def rank(answer: Answer) -> tuple[bool, bool, float, float]:
    """Proofs first, refusals last, farther reach before shorter."""
    silent = answer.theorem in (REFUSED, NOT_NEEDED)
    return answer.verdict is not Verdict.PROVED, silent, -answer.largest.low, -answer.largest.high


def linear_witnesses(asked: Asked, limit: Bracket) -> list[Witness]:
    """The smallest destabilising linear gain of the class, if there is one."""
    block, found = asked.block, None
    if isinstance(block, RationalBlock):
        from lure.analysis.counterexamples.linear import linear_witness

        found = linear_witness(block, lower=asked.lower)
    elif isinstance(block, StateSpaceBlock):
        found = growing_gain(block, asked.lower)
    elif isinstance(block, DelayBlock) and limit.high < math.inf:
        found = _dead_time_gain(block, limit)
    return [] if found is None else [refuted_witness(asked, found)]


def nonlinear_witnesses(asked: Asked) -> list[Witness]:
    """Other destabilising members of the class, with more than a simulation behind them.

    Raises
    ------
    TimeoutError
        The time allowed is over.
    """
    from lure.analysis.certificates.sealing import Failure, guarded
    from lure.analysis.counterexamples.search import refute

    block = asked.block
    if not isinstance(block, RationalBlock):
        return []
    kind = {"slope": asked.question == "slope", "odd": asked.odd, "time_varying": asked.time_varying}
    passing = (*EXPECTED, TimeoutError)
    found = guarded("refute", lambda: refute(block, lower=asked.lower, **kind), passing=passing)
    if isinstance(found, Failure):
        return []
    strong = (each for each in found if each.kind != "linear gain" and each.evidence > Evidence.OBSERVED)
    return [refuted_witness(asked, witness) for witness in strong]


def _dead_time_gain(block: DelayBlock, limit: Bracket) -> Witness:
    return Witness(
        kind="linear gain",
        k=limit.high,
        evidence=Evidence.CERTIFIED,
        slope_restricted=True,
        odd=True,
        description=f"a linear gain of about {limit.middle:.9g} puts a root on the imaginary axis, so that the loop "
        "does not come to rest",
        data={"gain": [limit.low, limit.high], "block": str(block)},
    )


def _from_zero(asked: Asked) -> None:
    if asked.lower != 0:
        raise AssumptionError(
            f"for a {type(asked.block).__name__} the classes begin at 0; got lower = {float(asked.lower):g}: close a "
            "loop with that gain in the model first"
        )


def silent(name: str, asked: Asked, reason: str, *, theorem: str = REFUSED) -> Answer:
    """The answer of a criterion that says nothing: it refuses, it failed, or it was not asked."""
    lower = float(asked.lower)
    computed, sampled = isinstance(asked.block, StateSpaceBlock), isinstance(asked.block, FrequencyData)
    slope = SlopeBounds(lower, math.inf) if asked.question == "slope" else None
    return Answer(
        criterion=name,
        theorem=theorem,
        largest=Bracket(lower, math.inf),
        law_class=LawClass(sector=Sector(lower, math.inf), slope=slope, odd=asked.odd),
        verdict=Verdict.INCONCLUSIVE,
        evidence=Evidence.OBSERVED if sampled else Evidence.COMPUTED if computed else Evidence.CERTIFIED,
        reason=reason,
    )
