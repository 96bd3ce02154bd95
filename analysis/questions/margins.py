"""How much farther the parameters of a plant may vary before an answer is lost: boxes that grow, from both sides."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from fractions import Fraction
from functools import partial
from itertools import islice
from typing import cast

from lure.analysis.certificates.checker import Proved, Refuted
from lure.analysis.certificates.drafts import Failure, guarded
from lure.analysis.deadline import checkpoint, time_limit
from lure.analysis.drawing import drawn
from lure.analysis.numerics.doubles import double_above, double_below
from lure.analysis.numerics.evidence import Bracket, ends
from lure.analysis.questions import channel_families, families
from lure.analysis.questions.channel_kinds import has_channels
from lure.analysis.questions.channel_members import members_refuting
from lure.analysis.questions.channel_problem import channel_problem
from lure.analysis.questions.conclusion import Certification
from lure.analysis.questions.counterexample_search import hurwitz, linear_refutation, worst
from lure.analysis.questions.largest import UNFINISHED, Stopped
from lure.analysis.questions.problem import Problem, class_given, loop_given, posed
from lure.analysis.questions.two_sided import TwoSided
from lure.analysis.theorems.table import BEST, Theorem, Upper, theorems_for
from lure.analysis.verdict import Evidence, Verdict
from lure.analysis.wording import class_words, interval, proviso
from lure.errors import InputError
from lure.plants.channel_family import ChannelFamily
from lure.plants.family import Box, PlantFamily
from lure.record import Page, Record, derived, quantity

_NO_PARAMETERS = "tolerances are those of a plant with parameters; give their intervals in [plant.parameters]"
_ROUNDS, _CORNERS = 4, 8
MOST, LEAST, CLOSE, LATE, PARTS = Fraction(32), Fraction(1, 64), Fraction(1, 100), 1, 48
"""How wide boxes get, in widths of the one given; how closely; the last stage of the criteria; into how many parts."""


class Margin(Record):
    """How wide the intervals of some parameters may be, about their middles, the others staying what they are."""

    parameters: tuple[str, ...] = quantity("The parameters that vary farther")
    width: Bracket = quantity(
        "Width of their intervals, times that given: up to ``low`` certified, 0 for nothing, from ``high`` on refuted",
        plainly=ends,
    )
    proved: Box | None = quantity("All intervals for which it is certified; None for none", default=None)
    refuted: Box | None = quantity(
        "All intervals with a plant that refutes it; None where none was found", default=None
    )
    proof: Proved | None = quantity("What the checker accepted of the former", key="", label="", default=None)
    refutation: Refuted | None = quantity("What the checker accepted of the latter", key="", label="", default=None)
    _title = "How much farther parameters may vary"

    def words(self, family: PlantFamily | ChannelFamily) -> str:
        """The margin in a sentence, in the units of the parameters.

        Parameters
        ----------
        family : PlantFamily or ChannelFamily
            The plants.
        """
        own = [family.names.index(name) for name in self.parameters]
        who = self.parameters[0] if len(own) == 1 else "all together"
        said = list[str]()
        may, never = ("may be in", "not in") if len(own) == 1 else ("proved for", "not for all of")
        for box, verb in ((self.proved, may), (self.refuted, never)):
            if box is not None:
                ranges = ", ".join(_range(family, j, box, inwards=box is self.proved, named=len(own) > 1) for j in own)
                wider = _percent(family, own[0], box, inwards=box is self.proved)
                said.append(f"{verb} {ranges} ({wider})")
        if self.refuted is None and self.proved is not None:
            said.append("and nothing farther was refuted")
        return f"{who}: {', '.join(said) or 'nothing is shown'}"


def _range(family: PlantFamily | ChannelFamily, j: int, box: Box, *, inwards: bool, named: bool) -> str:
    """An interval, rounded into itself where it is proved."""
    words = interval([str(end) for end in box[j]], inwards=inwards)
    return f"{family.names[j]} in {words}" if named else words


def _percent(family: PlantFamily | ChannelFamily, j: int, box: Box, *, inwards: bool) -> str:
    """How much wider than given, to three digits, rounded to what is narrower where it is proved, else to the wider."""
    (low, high), (left, right) = family.box[j], box[j]
    more = ((right - left) / (high - low) - 1) * 100
    rounded = Context(prec=3, rounding=ROUND_FLOOR if inwards else ROUND_CEILING)
    size = float(rounded.divide(Decimal(more.numerator), Decimal(more.denominator)))
    return f"{abs(size):g} % {'wider' if more >= 0 else 'narrower'}" if more else "as given"


class Tolerances(TwoSided):
    r"""How much farther each parameter, and all, may vary about the middle of its interval, for one class."""

    family: PlantFamily | ChannelFamily = quantity("The plants", key="plants")
    verdict: Verdict = quantity("On the class for the box as it is given")
    nonlinearity_class: str = quantity("The class in words", key="class")
    margins: tuple[Margin, ...] = quantity("Of each parameter, and, where there are several, of all together the last")
    reason: str = quantity("Why nothing is proved of the box given; empty if it is", default="")
    stopped: Stopped | None = quantity("What ended the search before it was complete", default=None)
    shown: Proved | Refuted | None = quantity(
        "What the checker accepted of the box given", key="", label="", default=None
    )
    _schema, _kind, _said = "lure-tolerances/1", "tolerances", "sentence"
    _no_truth = "tolerances have no truth value; compare result.verdict"

    @property
    def proof(self) -> Proved | None:
        """What the checker accepted of the widest intervals of all parameters."""
        return self.margins[-1].proof if self.margins else None

    @property
    def refutation(self) -> Refuted | None:
        """What the checker accepted against the narrowest."""
        return self.margins[-1].refutation if self.margins else None

    @property
    def _sides(self) -> tuple[Proved | None, Refuted | None]:
        return self.proof, self.refutation

    @property
    @derived()
    def assumed(self) -> str:
        """What the proofs assume of the nonlinearities beyond their class; empty if nothing."""
        own = cast("Proved | None", self.shown) if self.verdict is Verdict.PROVED else None
        proofs = (own, *(one.proof for one in self.margins))
        found = (proviso(proof) for proof in proofs if proof is not None)
        return " and ".join(dict.fromkeys(filter(None, found)))

    @property
    @derived()
    def evidence(self) -> Evidence | None:
        """What the margins rest on; None where there is none."""
        shown = any(one.proof is not None or one.refutation is not None for one in self.margins)
        return Evidence.CERTIFIED if shown else None

    def __str__(self) -> str:
        head = {Verdict.PROVED: "Proved", Verdict.REFUTED: "Refuted"}.get(self.verdict, "Undecided")
        assumed = self.assumed and f", {self.assumed},"
        plants = f"{'some' if self.verdict is Verdict.REFUTED else 'every'} {self.family.ranges}"
        said = f"{head} for {self.nonlinearity_class}{assumed} and {plants}"
        said += f": {self.reason}" if self.reason else ""
        each = "; ".join(one.words(self.family) for one in self.margins)
        more = f" {UNFINISHED[self.stopped]}" if self.stopped else ""
        each += "" if self.evidence is None else f" ({self.evidence})"
        far = f" How far parameters may go about the middle of their intervals: {each}." if self.margins else ""
        return f"{said}.{far}{more}"

    plot = drawn("Of two parameters the boxes, else the widths; see :func:`lure.analysis.plots.plot_tolerances`.")

    def _page(self) -> Page:
        rows = [(", ".join(one.parameters), one.words(self.family).partition(": ")[2]) for one in self.margins]
        return Page(f"Tolerances: {self.nonlinearity_class}", rows, verdict=str(self.verdict))


def tolerances(
    loop: object,
    nonlinearity: object = None,
    *,
    seconds: float | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> Tolerances:
    r"""How much farther the parameters may vary than their intervals say, before a class is no longer stable.

    The intervals ``[m - h, m + h]`` become ``[m - s h, m + s h]``: of one parameter after the other, the others
    staying what they are, and of all of them.  Up to some ``s`` the class is proved for every plant of the box; from
    some ``s`` on a plant of it and a constant gain refute it.

    Parameters
    ----------
    loop : LoopSystem, PlantFamily or ChannelFamily
        The plants, with the class.
    nonlinearity : object
        The class of nonlinearities, as for :func:`lure.analysis.certify`; by default that of the loop.
    seconds : float or None
        Time allowed; when it is over the best margins so far are returned.
    progress : callable, optional
        Called as ``progress(step, done)`` when a step begins.

    Raises
    ------
    InputError
        The plant has no parameters, or no class is given.

    Notes
    -----
    Zames-Falb multipliers are not asked: what is proved may be less than ``certify`` proves of the box.  Of several
    channels the circle criterion and Popov's are, and the plants that refute are looked for at corners of the boxes.

    Examples
    --------
    ``b/(s + a)`` against gains down to -1/2 is stable for ``b < 2 a``: with b = 1 for a > 1/2.

    >>> from lure import Sector
    >>> family = PlantFamily.of_coefficients([1], [1, "a"], {"a": (1, 2)})
    >>> found = tolerances(family, Sector(Fraction(-1, 2), 1))
    >>> print([round(found.margins[0].width.low, 1), round(found.margins[0].width.high, 1)])
    [2.0, 2.0]
    """
    if has_channels(loop, nonlinearity):
        several = channel_problem(loop, nonlinearity)
        if not isinstance(several.plant, ChannelFamily):
            raise InputError(_NO_PARAMETERS)
        if several.kind != "class":
            raise InputError("no class of nonlinearities is given; give one for each channel, in order")
        return _ChannelGrowth(several).answered(seconds, progress)
    given = class_given(nonlinearity)
    asked = posed(loop if given else loop_given(loop, nonlinearity), given, criterion=BEST, finite=False)
    if not isinstance(asked.plant, PlantFamily):
        raise InputError(_NO_PARAMETERS)
    if asked.nonlinearity_class.gains[0] == -math.inf:
        raise InputError(f"the class {asked.nonlinearity_class} has no lower bound; give one")
    return _Growth(asked).answered(seconds, progress)


@dataclass
class _Growth:
    """The boxes that grow."""

    asked: Problem
    found: tuple[Box, Theorem, families.Tree] | None = None  # what was found last in floating point

    @property
    def family(self) -> PlantFamily:
        """The plants."""
        assert isinstance(self.asked.plant, PlantFamily), "looked at before"
        return self.asked.plant

    @property
    def plants(self) -> PlantFamily | ChannelFamily:
        """The same, of several channels too."""
        return self.family

    def box(self, own: Sequence[int], s: Fraction) -> Box:
        """The box with the intervals of some parameters ``s`` times as wide."""
        found = list[tuple[Fraction, Fraction]]()
        for j, (low, high) in enumerate(self.plants.box):
            half = (high - low) / 2 * (s if j in own else 1)
            found.append(((low + high) / 2 - half, (low + high) / 2 + half))
        return tuple(found)

    def most(self, own: Sequence[int]) -> Fraction:
        """The largest width of interest, at which no dead time is negative."""
        least, _ = self.family.waits(self.box(own, Fraction(0)))
        shorter = least - self.family.waits(self.box(own, Fraction(1)))[0]
        return min(MOST, least / shorter) if self.family.delay and shorter else MOST

    def at(self, box: Box) -> Problem:
        """The question about another box."""
        return replace(self.asked, plant=self.plants.within(box))

    @property
    def rows(self) -> list[Theorem]:
        """The criteria."""
        asked = self.asked
        found = theorems_for(asked.plant, asked.question, BEST, odd=asked.odd, time_varying=asked.time_varying)
        return [row for row in found if row.stage <= LATE]

    def proved(self, box: Box) -> Proved | None:
        """What is accepted of the class for all plants of a box."""
        laws, plants = dict(self.asked.class_entry), self.family.within(box)
        for row, lower, upper in self._bounds():
            start = self.found[2] if self.found is not None and self.found[:2] == (box, row) else None
            if start is None and self.found is not None and self.found[0] == box:
                continue  # of another criterion
            search = families.Search(plants, row, self.asked.odd, PARTS)
            found = guarded(row.name, partial(search.proved, laws, lower, upper, start))
            if isinstance(found, Proved):
                return found
        return None

    def likely(self, box: Box) -> bool:
        """Whether floating point finds boxes for a criterion."""
        checkpoint()
        laws, plants = dict(self.asked.class_entry), self.family.within(box)
        for row, lower, upper in self._bounds():
            found = guarded(
                row.name, partial(families.Search(plants, row, self.asked.odd, PARTS).tree, laws, lower, upper)
            )
            if not isinstance(found, Failure):
                self.found = box, row, found
                return True
        return False

    def _bounds(self) -> Iterator[tuple[Theorem, Fraction, Upper]]:
        own = self.asked.nonlinearity_class
        for row in self.rows:
            bounds = own.slope if row.slope and own.slope is not None else own.sector
            yield row, Fraction(bounds.lower), Fraction(bounds.upper) if bounds.upper != math.inf else "finite"

    def unstable(self, box: Box) -> bool:
        """Whether a constant gain of the class is seen to be unstable with a plant of a box."""
        checkpoint()
        return bool(hurwitz(self.at(box)).high <= self.asked.nonlinearity_class.gains[1])

    def _worst_place(self, own: Sequence[int], s: Fraction) -> list[Fraction]:
        """Where in the box of a width the linear gains end first, from -1 to 1 in each parameter."""
        box = self.box(own, s)
        point, _ = worst(self.family.within(box), self.asked.lower)
        return [(2 * v - low - high) / (high - low) for v, (low, high) in zip(point, box, strict=True)]

    def _moves(self, own: Sequence[int], place: Sequence[Fraction], s: Fraction) -> bool:
        """Whether a gain of the class is seen to be unstable with the plant at a place of the box of a width."""
        checkpoint()
        ends = zip(self.box(own, s), place, strict=True)
        plant = self.family.at([(low + high + (high - low) * t) / 2 for (low, high), t in ends])
        return bool(hurwitz(replace(self.asked, plant=plant)).high <= self.asked.nonlinearity_class.gains[1])

    def refuted(self, box: Box) -> Refuted | None:
        """What is accepted against the class, of a plant of a box."""
        found = guarded("linear gains", partial(linear_refutation, self.at(box), "rationals"))
        return found if isinstance(found, Refuted) else None

    def margin(self, own: Sequence[int]) -> Margin:
        """How far the intervals of some parameters may grow."""
        found = guarded("wider intervals", partial(self._refuted, own), passing=(TimeoutError,))
        against = None if isinstance(found, Failure) else found  # of plants that no limit of gains is known of
        end = self.most(own) if against is None else against[0]
        proof = self._proved(own, end)
        low, high = (None if one is None else one[0] for one in (proof, against))
        return Margin(
            parameters=tuple(self.plants.names[j] for j in own),
            width=Bracket(double_below(low or Fraction(0)), math.inf if high is None else double_above(high)),
            proved=None if low is None else self.box(own, low),
            refuted=None if high is None else self.box(own, high),
            proof=None if proof is None else proof[1],
            refutation=None if against is None else against[1],
        )

    def _refuted(self, own: Sequence[int]) -> tuple[Fraction, Refuted] | None:
        """The least width at which a plant refutes, and the refutation."""
        most = self.most(own)
        high = min(Fraction(1), most)
        while not self.unstable(self.box(own, high)):
            if high >= most:
                return None
            high = min(2 * high, most)
        first = high / 2 if high > 1 else Fraction(0)
        for _ in range(_ROUNDS):
            place = self._worst_place(own, high)
            low = first
            while high - low > CLOSE / 4 * high and high > LEAST:  # of the plant at the same place of its box
                middle = (low + high) / 2
                low, high = (low, middle) if self._moves(own, place, middle) else (middle, high)
            if high <= LEAST or not self.unstable(self.box(own, high * (1 - CLOSE / 2))):
                break
            high *= 1 - CLOSE / 2
        for width in (high, *(wide for wide in (high * (1 + CLOSE), 2 * high) if wide <= most)):
            shown = self.refuted(self.box(own, width))
            if shown is not None:
                return width, shown
        return None

    def _proved(self, own: Sequence[int], end: Fraction) -> tuple[Fraction, Proved] | None:
        """The largest width at which the class is proved, up to a share, and the proof."""
        high, sure = end, end * (1 - CLOSE / 2)
        if self.likely(self.box(own, sure)):
            low = sure
        elif not self.likely(self.box(own, LEAST)):
            return None
        else:
            low = LEAST
            while high - low > CLOSE / 2 * high:
                middle = (low + high) / 2
                low, high = (middle, high) if self.likely(self.box(own, middle)) else (low, middle)
        for width in (low, low * (1 - CLOSE), low / 2):
            shown = self.proved(self.box(own, width))
            if shown is not None:
                return width, shown
        return None

    def answered(self, seconds: float | None, progress: Callable[[str, float], None] | None) -> Tolerances:
        """The margins, one after the other."""
        tell, names, stopped = progress or (lambda _step, _done: None), self.plants.names, None
        margins, shown, verdict, reason = list[Margin](), None, Verdict.INCONCLUSIVE, "the time allowed is over"
        each = [(j,) for j in range(len(names))] + ([tuple(range(len(names)))] if len(names) > 1 else [])
        try:
            with time_limit(seconds):
                tell("the box given", 0.0)
                found = self._certification().conclusion
                verdict, reason, shown = found.verdict, found.reason, found.shown
                for i, own in enumerate(each):
                    tell(", ".join(names[j] for j in own), i / len(each))
                    margins.append(self.margin(own))
        except TimeoutError:
            stopped = "time"
        return Tolerances(
            family=self.plants,
            verdict=verdict,
            nonlinearity_class=class_words(
                self.asked.class_entry, inwards=verdict is not Verdict.REFUTED, spelled=self.asked.spelled
            ),
            margins=tuple(margins),
            reason=reason,
            stopped=stopped,  # type: ignore[arg-type]  # one of the two
            shown=shown,
        )

    def _certification(self) -> Certification:
        """What is known of the box as it is given."""
        from lure.analysis.questions.answers import answer

        found = answer(self.asked)
        assert isinstance(found, Certification), "one class is asked about"
        return found


@dataclass
class _ChannelGrowth(_Growth):
    """The same of several channels."""

    @property
    def plants(self) -> ChannelFamily:
        """The plants."""
        return channel_families.family_of(self.asked)

    def most(self, own: Sequence[int]) -> Fraction:
        """The largest width of interest."""
        return MOST

    def proved(self, box: Box) -> Proved | None:
        """What is accepted of the classes for all plants of a box."""
        for name in channel_families.criteria(self.asked):
            found = guarded(name, channel_families.BoxSearch(self.at(box), name).whole, passing=(TimeoutError,))
            if isinstance(found, Proved):
                return found
        return None

    def likely(self, box: Box) -> bool:
        """Whether floating point finds boxes for a criterion."""
        checkpoint()
        for name in channel_families.criteria(self.asked):
            search = channel_families.BoxSearch(self.at(box), name)
            if not isinstance(guarded(name, partial(search.tree, Fraction(1))), Failure):
                return True
        return False

    def unstable(self, box: Box) -> bool:
        """Whether constant gains of the classes are seen to be unstable with a plant in the middle or at a corner."""
        checkpoint()
        inside = self.plants.within(box)
        points = (inside.middle, *islice(inside.corners, _CORNERS))
        return any(channel_families.slack(self.asked, self.plants.at(point)) <= 1 for point in points)

    def refuted(self, box: Box) -> Refuted | None:
        """What is accepted against the classes, of a plant of a box."""
        found = channel_families.refuting(self.at(box), partial(members_refuting, most=1.0))
        return None if found is None else found[1]

    def _worst_place(self, own: Sequence[int], s: Fraction) -> list[Fraction]:
        """The corner, or the middle, of the box of a width where gains end first."""
        inside = self.plants.within(self.box(own, s))
        places = [(inside.middle, [Fraction(0)] * len(inside.box))]
        for point in islice(inside.corners, _CORNERS):
            ends = zip(point, inside.box, strict=True)
            places.append((point, [Fraction(1 if v == high else -1) for v, (_, high) in ends]))
        return min(places, key=lambda one: channel_families.slack(self.asked, self.plants.at(one[0])))[1]

    def _moves(self, own: Sequence[int], place: Sequence[Fraction], s: Fraction) -> bool:
        """Whether gains of the classes are seen to be unstable with the plant at a place of the box of a width."""
        checkpoint()
        ends = zip(self.box(own, s), place, strict=True)
        plant = self.plants.at([(low + high + (high - low) * t) / 2 for (low, high), t in ends])
        return channel_families.slack(self.asked, plant) <= 1
