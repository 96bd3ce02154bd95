"""Which criteria there are, for which time and for which class of laws; each is imported when it is asked for."""

from __future__ import annotations

import difflib
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from importlib import import_module
from typing import Literal, cast

from analysis.answer import Answer
from lure.errors import AssumptionError, InputError
from lure.rational import RationalBlock

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
        call = cast("Callable[..., Answer]", getattr(import_module(f"analysis.criteria.{module}"), function))
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
    Entry("hurwitz", _BOTH, slope=False, time_varying=False, place="hurwitz:hurwitz_largest"),
    Entry("circle", _BOTH, slope=False, time_varying=True, place="circle:circle_largest"),
    Entry("popov", _FLOW, slope=False, time_varying=False, place="popov:popov_largest"),
    Entry("park", _FLOW, **_SLOPE, place="park:park_largest", stage=1),
    Entry("off-axis-circle", _FLOW, **_SLOPE, place="off_axis:off_axis_largest", stage=1),
    Entry("tsypkin", _MAP, **_SLOPE, place="tsypkin:tsypkin_largest", stage=1),
    Entry("jury-lee", _MAP, **_SLOPE, place="jury_lee:jury_lee_largest", stage=1),
    Entry("zames-falb", _FLOW, **_SLOPE, place="zames_falb:zames_falb_largest", stage=2, odd=True),
    Entry("zames-falb", _MAP, **_SLOPE, place="zames_falb_discrete:zames_falb_discrete_largest", stage=2, odd=True),
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
