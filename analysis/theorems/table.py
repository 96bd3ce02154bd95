"""The table of theorems: what each criterion needs, where it is decided, and which multipliers a certificate tries.

A criterion is added by its row here, its lines in the two checkers and the functions that the row names.  Modules are
named as text and imported when a criterion is asked.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from functools import cache
from importlib import import_module
from operator import attrgetter
from typing import Any, Literal

from lure.analysis.inequality.protocol import ScalarPlant
from lure.analysis.verdict import CriterionResult
from lure.classes import NonlinearityClass, Sector, SlopeBounds
from lure.errors import AssumptionError, InputError, did_you_mean
from lure.plants.delay import DelayPlant
from lure.plants.family import PlantFamily
from lure.plants.rational import RationalPlant
from lure.record import described, quantity

Question = Literal["sector", "slope"]
Time = Literal["continuous", "discrete"]
Upper = Fraction | Literal["finite", "inf"]
Multiplier = dict[str, Any]
BEST, LAST = "best", 4  # the stage after all searches
_NEARBY = (Fraction(1), Fraction(9, 8), Fraction(2), Fraction(7, 8), Fraction(1, 2))
_SHRINKING = tuple(1 - Fraction(1, 10**digits) for digits in (24, 18, 15, 12, 9, 6, 4, 3, 2, 1))


@described(frozen=True, kw_only=True, slots=True)
class Theorem:
    """One row of the table."""

    name: str = quantity("Its name, in questions and in certificates")
    title: str = quantity("The criterion in a sentence")
    largest: str = quantity("``module:function`` of the search for the largest ``k``")
    decision: str = quantity("``module:function`` of the decision about one class")
    multipliers: Callable[[CriterionResult, Upper], Iterator[Multiplier]] = quantity(
        "The ``multiplier`` of a certificate worth trying, the likeliest first, from an answer and an upper end"
    )
    times: tuple[Time, ...] = quantity("Where it applies")
    slope: bool = quantity("Whether it needs slope bounds; else a sector is enough", default=False)
    free: Literal["", "above", "below"] = quantity(
        "The side on which it needs no slope bound, the sector being bounded on both, where ``H(inf)`` permits it",
        default="",
    )
    odd: bool = quantity("Whether the functions take ``odd``", default=False)
    only_odd: bool = quantity("Whether its conclusion covers odd nonlinearities only", default=False)
    within: str = quantity(
        "``module:function`` of a quick exact test whether the largest ``k`` may be a given one or more; empty for "
        "none",
        default="",
    )
    time_varying: bool = quantity("Whether its conclusion covers time-varying nonlinearities", default=False)
    linear: bool = quantity("Whether it is about constant gains alone", default=False)
    endless: bool = quantity("Whether it covers nonlinearities without an upper bound", default=False)
    composed: bool = quantity(
        "Whether it assumes, where ``H(inf)`` is not 0, that ``sigma + H(inf) phi(sigma)`` increases", default=False
    )
    matrix: bool = quantity("Whether a matrix inequality can prove it", default=False)
    thorough: bool = quantity('Whether ``decision`` takes ``effort="full"``, which takes minutes', default=False)
    longer: bool = quantity('Whether ``largest`` takes ``effort="full"``, for who asks for it by name', default=False)
    stage: int = quantity(
        "0: cheap and of interest by itself; 1: cheap; 2: dear; 4: after the search for counterexamples, which is 3.  "
        "Those of a later stage are asked while a gap is left",
        default=0,
    )
    aliases: tuple[str, ...] = quantity("Other names to ask for it", default=())
    channels: tuple[str, ...] = quantity(
        "Its names in certificates about several nonlinearities, the cheapest kind of multiplier first; empty if it "
        "is about one",
        default=(),
    )
    family: bool = quantity("Whether it is decided for all plants of a box of parameters", default=True)
    late: str = quantity(
        "The function for plants with dead time, of a criterion about slopes; empty where there is none", default=""
    )
    proof: str = quantity(
        "``module:function`` of the ``proof`` of a certificate from the plant, an answer and an upper end, None "
        "where it finds none; empty where the checker finds the polynomial itself",
        default="",
    )
    broad: bool = quantity(
        "Whether it is for rational plants alone, and ``best`` asks it about sectors and what depends on time alone: "
        "of slopes others show more",
        default=False,
    )

    def answer(self, block: ScalarPlant, *, lower: Fraction, odd: bool, named: bool = False) -> CriterionResult:
        """The largest ``k`` of the classes ``[lower, k]`` that the criterion proves, computes or observes.

        ``named``: it was asked for by its name, among no others.
        """
        if not isinstance(block, RationalPlant):
            if self.late:
                return _called(self.late, block, lower=lower, odd=odd)
            return _called("theorems.other_plants:largest", block, self.name, lower=lower)
        if not self.odd:
            return _called(self.largest, block, lower=lower, **({"effort": "full"} if named and self.longer else {}))
        found = _called(self.largest, block, lower=lower, odd=odd)
        if not odd or block.dt is None:
            return found
        monotone = _called(
            self.largest, block, lower=lower, odd=False
        )  # odd nonlinearities are monotone nonlinearities
        return monotone if monotone.largest.low > found.largest.low else found

    def may_reach(self, block: object, upper: float, *, lower: Fraction) -> bool:
        """Whether it may prove a class up to ``upper`` from ``lower`` on, as far as a quick test can tell."""
        if not self.within or not isinstance(block, RationalPlant) or not lower < upper:
            return True
        found: bool = _function(self.within)(block, upper, lower=lower)
        return found

    def decide(
        self, block: RationalPlant, bounds: Sector | SlopeBounds, *, odd: bool = False, thorough: bool = False
    ) -> CriterionResult:
        """Whether the criterion proves the class with these bounds of the sector or, where it needs them, the slope."""
        asked = SlopeBounds(bounds.lower, bounds.upper) if self.slope else Sector(bounds.lower, bounds.upper)
        options: dict[str, Any] = {"odd": odd} if self.odd else {}
        return _called(self.decision, block, asked, **options, **({"effort": "full"} if thorough else {}))

    def proof_of(self, block: object, answer: CriterionResult, upper: Upper) -> dict[str, Any] | None:
        """The ``proof`` of a certificate for the class with this upper end; None if there is none."""
        if not self.proof:
            return {"method": "polynomial"}
        found: dict[str, Any] | None = _function(self.proof)(block, answer, upper)
        return found

    def bounds(self, nonlinearity_class: NonlinearityClass) -> list[Sector] | list[SlopeBounds]:
        """What it is asked about: the sector, the slope bounds, or where one side is free both bounds as slopes."""
        slope = nonlinearity_class.slope
        if not self.slope or slope is None:
            return [nonlinearity_class.sector]
        tight = SlopeBounds(nonlinearity_class.sector.lower, nonlinearity_class.sector.upper)
        return [tight, slope] if self.free and tight != slope else [slope]


_module = cache(import_module)  # what stands in the module is asked each time: tests put faults there


def _function(place: str) -> Callable[..., Any]:
    module, _, function = place.partition(":")
    found: Callable[..., Any] = attrgetter(function)(_module(f"lure.analysis.{module}"))
    return found


def _called(place: str, *given: object, **options: object) -> CriterionResult:
    answer: CriterionResult = _function(place)(*given, **options)
    return answer


# The multipliers of a certificate, from the parameters of an answer.


def _none(_answer: CriterionResult, _upper: Upper) -> Iterator[Multiplier]:
    yield {}


def _mirrored(answer: CriterionResult, _upper: Upper) -> Iterator[Multiplier]:
    lower = answer.nonlinearity_class.sector.lower
    yield from ({"mirrored": True},) if lower == -math.inf else ({}, {"mirrored": True})


def _number(name: str) -> Callable[[CriterionResult, Upper], Iterator[Multiplier]]:
    """A finite number of the parameters and, should it fail, multiples of it."""

    def multipliers(answer: CriterionResult, _upper: Upper) -> Iterator[Multiplier]:
        """The number, then others near to it."""
        value = str(answer.parameters.get(name, "0"))
        if "inf" not in value:
            yield from ({name: text} for text in dict.fromkeys(str(Fraction(value) * factor) for factor in _NEARBY))

    return multipliers


def _pair(answer: CriterionResult, _upper: Upper) -> Iterator[Multiplier]:
    theta, tau = (str(answer.parameters.get(name, "0")) for name in ("theta", "tau"))
    if "inf" not in theta + tau:
        yield {"theta": theta, "tau": tau}


def _taps(answer: CriterionResult, _upper: Upper) -> Iterator[Multiplier]:
    if "taps" in answer.parameters:
        yield {"taps": [[int(i), str(h)] for i, h in _mapping(answer.parameters["taps"]).items()]}


def _windows(answer: CriterionResult, upper: Upper) -> Iterator[Multiplier]:
    """The taps and the form of the answer, for the class with this upper end."""
    if "window" in answer.parameters and isinstance(upper, Fraction):
        from lure.analysis.theorems.order_cone import certificate_multiplier

        lower, odd = Fraction(answer.nonlinearity_class.sector.lower), answer.nonlinearity_class.odd
        yield certificate_multiplier(answer.parameters, upper - lower, odd=odd)


def _kernels(answer: CriterionResult, upper: Upper) -> Iterator[Multiplier]:
    """Kernels as they are; then with less mass, which can serve every finite ``k`` where a mass of 1 does not."""
    given = answer.parameters.get("kernels")
    if not isinstance(given, list | tuple):
        return
    theta, entries = str(answer.parameters["theta"]), [_mapping(entry) for entry in given]
    yield {"theta": theta, "kernels": entries}
    mass = sum((abs(Fraction(entry["coefficient"])) for entry in entries), Fraction(0))
    for factor in _SHRINKING if entries and (upper == "finite" or mass == 1) else ():
        less = [{**entry, "coefficient": str(factor * Fraction(entry["coefficient"]))} for entry in entries]
        yield {"theta": theta, "kernels": less}


def _mapping(value: object) -> dict[Any, Any]:
    return dict(value) if isinstance(value, Mapping) else {}


_FLOW: tuple[Time, ...] = ("continuous",)
_MAP: tuple[Time, ...] = ("discrete",)
TABLE = (  # in each stage the cheapest first
    Theorem(
        name="hurwitz",
        title="Hurwitz: constant gains",
        times=(*_FLOW, *_MAP),
        linear=True,
        channels=("constant-gains",),
        largest="inequality.gains:hurwitz_largest",
        decision="inequality.gains:hurwitz_criterion",
        multipliers=_none,
        family=False,
    ),
    Theorem(
        name="circle",
        title="the circle criterion",
        times=(*_FLOW, *_MAP),
        time_varying=True,
        endless=True,
        matrix=True,
        channels=(
            *("diagonal-circle", "coupled-circle", "full-block-circle"),
            *("parameter-dependent", "matrix-scalings", "piecewise-circle", "storage-circle"),
        ),
        largest="theorems.circle:circle_largest",
        decision="theorems.circle:circle_criterion",
        within="theorems.circle:circle_may_reach",
        multipliers=_mirrored,
    ),
    Theorem(
        name="popov",
        title="Popov's criterion",
        times=_FLOW,
        endless=True,
        composed=True,
        matrix=True,
        channels=("diagonal-popov", "coupled-popov", "full-block-popov", "piecewise-popov"),
        largest="theorems.popov:popov_largest",
        decision="theorems.popov:popov_criterion",
        multipliers=_number("theta"),
    ),
    Theorem(
        name="park",
        title="Yakubovich's and Park's criterion",
        aliases=("yakubovich",),
        times=_FLOW,
        slope=True,
        late="theorems.dead_time:first_order_largest",
        stage=1,
        largest="theorems.park:park_largest",
        decision="theorems.park:park_criterion",
        multipliers=_pair,
    ),
    Theorem(
        name="off-axis-circle",
        title="the off-axis circle criterion",
        aliases=("off-axis",),
        times=_FLOW,
        slope=True,
        stage=1,
        largest="theorems.off_axis:off_axis_largest",
        decision="theorems.off_axis:off_axis_criterion",
        multipliers=_number("alpha"),
    ),
    Theorem(
        name="tsypkin",
        title="Tsypkin's criterion",
        times=_MAP,
        slope=True,
        free="above",
        stage=1,
        largest="theorems.differences:TSYPKIN.largest",
        decision="theorems.differences:TSYPKIN.decide",
        multipliers=_number("q"),
    ),
    Theorem(
        name="tsypkin-odd",
        title="Tsypkin's criterion for odd nonlinearities",
        times=_MAP,
        slope=True,
        free="above",
        only_odd=True,
        stage=1,
        largest="theorems.differences:TSYPKIN_ODD.largest",
        decision="theorems.differences:TSYPKIN_ODD.decide",
        multipliers=_number("q"),
    ),
    Theorem(
        name="jury-lee",
        title="the Jury-Lee criterion",
        times=_MAP,
        slope=True,
        free="below",
        stage=1,
        largest="theorems.differences:JURY_LEE.largest",
        decision="theorems.differences:JURY_LEE.decide",
        multipliers=_number("q"),
    ),
    Theorem(
        name="zames-falb",
        title="Zames-Falb multipliers with a Popov term",
        aliases=("zf",),
        times=_FLOW,
        slope=True,
        odd=True,
        channels=("matrix-zames-falb", "late-zames-falb"),
        thorough=True,
        late="theorems.dead_time:kernels_largest",
        stage=2,
        largest="theorems.zames_falb:zames_falb_largest",
        decision="theorems.zames_falb:zames_falb_criterion",
        multipliers=_kernels,
    ),
    Theorem(
        name="zames-falb",
        title="Zames-Falb multipliers with finitely many taps",
        aliases=("zf",),
        times=_MAP,
        slope=True,
        odd=True,
        channels=("coupled-windows",),
        stage=2,
        largest="theorems.zames_falb_discrete:zames_falb_discrete_largest",
        decision="theorems.zames_falb_discrete:zames_falb_discrete_criterion",
        multipliers=_taps,
    ),
    Theorem(
        name="order-cone",
        title="forms of several samples, copositive on order cones",
        times=_MAP,
        slope=True,
        odd=True,
        stage=LAST,
        channels=("order-cones",),
        largest="theorems.order_cone:order_cone_largest",
        decision="theorems.order_cone:order_cone_criterion",
        multipliers=_windows,
        family=False,
    ),
    Theorem(
        name="homogeneous-lyapunov",
        title="homogeneous Lyapunov functions of degree 4 and more",
        aliases=("homogeneous",),
        times=(*_FLOW, *_MAP),
        time_varying=True,
        broad=True,
        stage=LAST,
        longer=True,
        largest="theorems.homogeneous:homogeneous_largest",
        decision="theorems.homogeneous:homogeneous_criterion",
        multipliers=_none,
        proof="theorems.homogeneous:homogeneous_proof",
        family=False,
    ),
)
CRITERIA = tuple(dict.fromkeys(row.name for row in TABLE))
"""The names of the criteria, to ask for one of them."""


def time_of(block: object) -> Time:
    """The time domain of a block; ``block``: in discrete time it has a sampling time ``dt``."""
    return "continuous" if getattr(block, "dt", None) is None else "discrete"


def row_of(name: str, block: object) -> Theorem:
    """The row of a criterion by its name, in the time domain of a block.

    ``name``: ``criterion`` of an answer; ``block``: the block of the answer.
    """
    return next(row for row in TABLE if row.name == name and time_of(block) in row.times)


def theorems_for(
    block: object, question: Question, criterion: str, *, odd: bool = False, time_varying: bool = False
) -> list[Theorem]:
    """The criteria to run for a question.

    Parameters
    ----------
    block : RationalPlant, DelayPlant or StateSpace
        The block.
    question : {"sector", "slope"}
        What is known of the nonlinearity; a slope-restricted nonlinearity lies in the sector of the same bounds, so
        that the criteria for sectors serve it too.
    criterion : str
        A name, or ``best`` for all that apply (without those for constant gains, which prove nothing about nonlinear
        nonlinearities).
    odd : bool
        Whether the nonlinearity is known to be odd.
    time_varying : bool
        Whether the nonlinearity may vary with time.

    Raises
    ------
    InputError
        There is no such criterion.
    AssumptionError
        It does not apply to this question.
    """
    time = time_of(block)
    wanted = criterion.replace("_", "-").lower()
    wanted = next((row.name for row in TABLE if wanted in row.aliases), wanted)
    if wanted != BEST and wanted not in CRITERIA:
        hint = did_you_mean(wanted, CRITERIA, cutoff=0.6)
        raise InputError(f"there is no criterion {criterion!r}; {hint}choose from {BEST}, {', '.join(CRITERIA)}")
    exact = isinstance(block, RationalPlant) or (isinstance(block, PlantFamily) and not block.delay)  # else for sectors
    late = isinstance(block, DelayPlant)
    found = [
        row for row in TABLE if time in row.times and (exact or not (row.slope or row.broad) or (late and row.late))
    ]
    if wanted == BEST:
        return [
            row
            for row in found
            if not row.linear
            and (row.stage < LAST or not isinstance(block, PlantFamily))
            and (question == "slope" or not row.slope)
            and (odd or not row.only_odd)
            and (row.time_varying if time_varying else question == "sector" or not row.broad)
        ]
    named = [row for row in TABLE if row.name == wanted and time in row.times]
    found = [row for row in found if row.name == wanted]
    if named and not found:
        others = " or ".join(row.name for row in TABLE if row.matrix)
        raise AssumptionError(
            f"the criterion {wanted} is evaluated for rational blocks of moderate order only; for this one ask {others}"
        )
    if not found:
        other = "discrete" if time == "continuous" else "continuous"
        raise AssumptionError(f"the criterion {wanted} is for {other} time, this block is in {time} time; try {BEST}")
    if question == "sector" and found[0].slope:
        raise AssumptionError(
            f"the criterion {wanted} needs slope bounds, and a sector gives none; ask for the largest slope "
            "(max_slope, lure max-slope)"
        )
    if found[0].only_odd and not odd:
        raise AssumptionError(
            f"the criterion {wanted} is for odd nonlinearities; ask about those (odd=True, lure max-slope --odd)"
        )
    if time_varying and not found[0].time_varying:
        varying = " or ".join(row.name for row in TABLE if row.time_varying)
        raise AssumptionError(
            f"the criterion {wanted} is for time-invariant nonlinearities; for time-varying ones ask {varying}"
        )
    return found
