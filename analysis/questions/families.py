"""Plants with parameters in a box: proofs by branch and bound over the box, refutations by one plant of it.

What the criteria find for the plant in the middle of a box is tried on all of the box by the checker's own test; where
it fails the box is cut.  Nothing here is believed: the certificate holds the cuts and the multipliers.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property, partial
from typing import Any

from lure.analysis.certificates import boxes
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.checker import SLOPED, Proved, Refuted, inequality, on_axis
from lure.analysis.certificates.drafts import complete_and_check, guarded
from lure.analysis.certificates.multipliers import multipliers
from lure.analysis.certificates.states import classes
from lure.analysis.certificates.systems import system_of
from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.box_polynomials import LateLook, Look, best_theta, likeliest
from lure.analysis.numerics.doubles import double_above, double_below
from lure.analysis.questions.worst_plants import MOST_LOOKS, cheaply_worst, least
from lure.analysis.theorems.table import TABLE, Theorem, Upper
from lure.analysis.verdict import Bracket, CriterionResult, Evidence, Verdict, Witness
from lure.classes import NonlinearityClass, Sector, SlopeBounds
from lure.errors import AssumptionError, Reason
from lure.plants.channel_family import ChannelFamily
from lure.plants.delay import DelayPlant
from lure.plants.family import Box, PlantFamily, Point
from lure.plants.rational import RationalPlant
from lure.record import described, quantity

MOST_BOXES, MOST_LATE = 400, 20
NEAR = (Fraction(1, 10), Fraction(1, 100), Fraction(1, 1000), Fraction(1, 10**5), Fraction(1, 5 * 10**6))
FAR = (Fraction(1, 4), Fraction(1, 2), Fraction(3, 4), Fraction(19, 20), Fraction(999, 1000))
LARGE = (10**9, 10**6, 10**3)
UNUSED = tuple(row.name for row in TABLE if not row.family)
"""Criteria that are not shown of plants with parameters."""


# One class for all plants of the box.


@dataclass(slots=True)
class Leaf:
    """A box that is cut no further, and what shows the inequality on it."""

    box: Box
    multiplier: Mapping[str, Any] | None = None


@dataclass(slots=True)
class Cut:
    """A box in two halves."""

    box: Box
    parameter: int
    at: Fraction
    below: Tree
    above: Tree


Tree = Leaf | Cut


def cut(box: Box, j: int, made: Callable[[Box], Tree]) -> Cut:
    """A box in two halves, with what is made of each; ``j``: across which parameter it is cut."""
    low, high = box[j]
    at = simplest(low, high)
    halves = ((*box[:j], ends, *box[j + 1 :]) for ends in ((low, at), (at, high)))
    below, above = (made(half) for half in halves)
    return Cut(box, j, at, below, above)


def too_many(family: PlantFamily | ChannelFamily, box: Box, most: int) -> AssumptionError:
    """That some boxes are still open, and where one of them lies; ``most``: how many boxes there may be."""
    where = family.within(box).ranges
    return AssumptionError(f"the box of parameters was cut into {most} boxes, and some are still open: {where}")


def wide_enough(family: PlantFamily, box: Box) -> None:
    """Refuse to cut a box beside one plant without end.

    Raises
    ------
    AssumptionError
        The box is less than the ``2^-50`` th part of an interval.
    """
    if any((high - low) * 2**50 < b - a for (low, high), (a, b) in zip(box, family.box, strict=True)):
        where = family.within(box).ranges
        raise AssumptionError(f"however small the boxes, one multiplier serves none of those beside {where}")


_PARTS, _SHOWN = 5, 4  # how often the box is cut to see where it is open; how many of these parts are named


def open_parts(family: PlantFamily | ChannelFamily, serves: Callable[[Box], bool], widest: Callable[[Box], int]) -> str:
    """Where in the box nothing is proved, in a sentence, as far as floating point tells.

    ``serves``: whether something is found for a box; ``widest``: across which parameter a box is cut.
    """

    def parts(box: Box, cuts: int) -> list[Box]:
        """The parts of a box that nothing serves, one box where all of its halves are such."""
        checkpoint()
        if serves(box):
            return []
        if cuts == _PARTS:
            return [box]
        j = widest(box)
        (low, high), at = box[j], simplest(*box[j])
        halves = [(*box[:j], ends, *box[j + 1 :]) for ends in ((low, at), (at, high))]
        found = [parts(half, cuts + 1) for half in halves]
        return [box] if found == [[half] for half in halves] else [one for each in found for one in each]

    found = parts(family.box, 0)
    if not found:
        return "each part of the box is covered in floating point, and the whole was not accepted"
    if found == [family.box]:
        return "no part of the box is covered"
    whole = math.prod(high - low for low, high in family.box)
    share = float(sum(math.prod(high - low for low, high in box) for box in found) / whole)
    named = "; ".join(family.within(box).ranges for box in found[:_SHOWN])
    more = f"; and {len(found) - _SHOWN} more" if len(found) > _SHOWN else ""
    return f"open is {share * 100:.3g} % of the box: {named}{more}; the rest is covered, in floating point"


class Short(AssumptionError):
    """A criterion does not reach the class at a plant of the box."""

    def __init__(self, point: Point, words: str) -> None:
        super().__init__(f"with {words} the criterion does not reach so far")
        self.point = point


@described()
class Search:
    """The search for a proof by one criterion, for classes of one kind."""

    family: PlantFamily = quantity("The plants")
    row: Theorem = quantity("The criterion")
    odd: bool = quantity("Whether it may use that the nonlinearities are odd", default=False)
    most: int = quantity("How many boxes the box may be cut into", default=MOST_BOXES)
    worst: Point | None = quantity(
        "A plant whose multiplier is tried on all boxes, of criteria whose multipliers cost much", default=None
    )
    exact: bool = field(default=False, init=False)

    @cached_property
    def plants(self) -> boxes.Plants:
        """The plants as the checker reads them."""
        return boxes.plants(system_of(self.family))

    def decided(self, point: Point, lower: Fraction, upper: Upper) -> Mapping[str, Any]:
        """The likeliest multiplier for a class at a plant.

        Raises
        ------
        Short
            The criterion does not prove the class there.
        AssumptionError
            With dead time it is not about such a class.
        """
        plant, end = self.family.at(point), math.inf if isinstance(upper, str) else upper
        if not isinstance(plant, RationalPlant):
            if lower or isinstance(upper, str):
                raise AssumptionError(
                    "with dead time the classes begin at 0 and have a finite upper end", code=Reason.DEAD_TIME
                )
            if (late := likeliest(plant, self.row.name, upper)) is None:
                raise Short(point, self.family.words(point))
            return late
        bounds = SlopeBounds(lower, end) if self.row.slope else Sector(lower, end)
        answer = self.row.decide(plant, bounds, odd=self.odd)
        given = next(iter(multipliers(plant, answer, upper)), None)
        if answer.verdict is not Verdict.PROVED or given is None or "mirrored" in given:
            raise Short(point, self.family.words(point))
        if any("delay" in one for one in given.get("kernels", ())):
            raise AssumptionError(
                f"with {self.family.words(point)} it takes kernels that are delays, for one plant only"
            )
        return given

    def serves(self, laws: Mapping[str, Any], ends: tuple[Fraction, Upper], box: Box) -> bool:
        """Whether a multiplier for the middle of a box seems to serve all of it.

        ``laws``: the class as it stands in a certificate.
        """
        try:
            own = self.decided(tuple((low + high) / 2 for low, high in box), *ends)
        except AssumptionError:
            return False
        return self._look(laws).passes(box, own)

    def _look(self, laws: Mapping[str, Any]) -> Look:
        """The test of boxes in floating point."""
        given = classes(dict(laws))
        ends = given.slope if self.row.name in SLOPED else given.sector
        return (LateLook if self.family.delay else Look)(self.family, self.row.name, ends)

    def tree(self, laws: Mapping[str, Any], lower: Fraction, upper: Upper, start: Tree | None = None) -> Tree:
        """Boxes that cover the box with a multiplier each, on which the inequality holds as far as floats can tell.

        ``laws``: the class as it stands in a certificate; ``lower``, ``upper``: its ends; ``start``: boxes to begin
        with.

        Raises
        ------
        Short
            At some plant the criterion does not reach the class.
        AssumptionError
            The boxes became too many.
        """
        if self.family.order_changes:
            leading = self.family.sides[1][0]
            raise AssumptionError(
                f"the order of the plants changes in the box, where {leading} = 0, and no theorem here is about all of "
                "them at once; give intervals in which it is not 0, or leave the smallest time constant out"
            )
        given = classes(dict(laws))
        ends = given.slope if self.row.name in SLOPED else given.sector
        look, count = self._look(laws), [0]

        def holds(box: Box, multiplier: Mapping[str, Any]) -> bool:
            """Whether the test is passed on a box: by floats, in doubt or where these erred by the checker's own."""
            checkpoint()
            if not look.passes(box, multiplier):
                return False
            if not self.exact:
                return True
            try:
                shows = partial(inequality, self.row.name, dict(multiplier), family=given)
                boxes.on_box(self.plants, list(box), ends, shows, on_axis)
            except Rejected:
                return False
            return True

        lead = None if self.worst is None else self.decided(self.worst, lower, upper)

        def made(box: Box, known: Mapping[str, Any] | None) -> Tree:
            """The boxes for one."""
            count[0] += 1
            if count[0] > self.most:
                raise too_many(self.family, box, self.most)
            wide_enough(self.family, box)
            given = [one for one in (known, lead if lead != known else None) if one is not None]
            for one in given:
                if holds(box, one):
                    return Leaf(box, one)
            middle = tuple((low + high) / 2 for low, high in box)
            if lead is not None and box != self.family.box:  # a smaller box is enough, and cheaper than a multiplier
                alone = tuple((v, v) for v in middle)
                serves = next((one for one in given if look.passes(alone, one)), None)
                if serves is not None:
                    return cut(box, look.widest(box), partial(made, known=serves))
            own = self.decided(middle, lower, upper)
            if own not in given and holds(box, own):
                return Leaf(box, own)
            return cut(box, look.widest(box), partial(made, known=own))

        def again(part: Tree) -> Tree:
            """The same for boxes that were made for another class."""
            if isinstance(part, Cut):
                return Cut(part.box, part.parameter, part.at, again(part.below), again(part.above))
            return made(part.box, part.multiplier)

        return again(start or Leaf(self.family.box))

    def proved(self, laws: Mapping[str, Any], lower: Fraction, upper: Upper, start: Tree | None = None) -> Proved:
        """What the checker accepts of the class.

        Parameters
        ----------
        laws, lower, upper, start
            As for :meth:`tree`.

        Raises
        ------
        AssumptionError
            No boxes were found.
        Rejected
            The checker accepts none.
        """
        tree = self.tree(laws, lower, upper, start)
        try:
            shown = complete_and_check(draft(self.family, self.row, laws, tree))
        except Rejected:
            self.exact = True
            shown = complete_and_check(draft(self.family, self.row, laws, self.tree(laws, lower, upper, tree)))
        assert isinstance(shown, Proved), "it is a proof that was drafted"
        return shown


def simplest(low: Fraction, high: Fraction) -> Fraction:
    """A short number about in the middle."""
    middle, width = (low + high) / 2, high - low
    digits = 1
    while abs((near := middle.limit_denominator(digits)) - middle) > width / 16:
        digits *= 2
    return near


def leaves(tree: Tree) -> int:
    """How many boxes are cut no further."""
    return 1 if isinstance(tree, Leaf) else leaves(tree.below) + leaves(tree.above)


def written(tree: Tree) -> dict[str, Any]:
    """The boxes as they stand in a certificate."""
    if isinstance(tree, Leaf):
        return {"multiplier": dict(tree.multiplier or {})}
    parts = {"below": written(tree.below), "above": written(tree.above)}
    return {"parameter": tree.parameter, "at": str(tree.at), **parts}


def draft(family: PlantFamily, row: Theorem, laws: Mapping[str, Any], tree: Tree) -> dict[str, Any]:
    """A certificate for all plants of a box, the checker's part left out.

    ``row``: the criterion; ``laws``: the class; ``tree``: the boxes with their multipliers.
    """
    return {
        "verdict": "PROVED",
        "system": system_of(family),
        "laws": dict(laws),
        "theorem": row.name,
        "proof": {"method": "boxes", "boxes": written(tree)},
    }


# The largest class of a criterion.

Laws = Callable[[Upper], tuple[NonlinearityClass, Mapping[str, Any]]]


def largest(family: PlantFamily, row: Theorem, lower: Fraction, laws: Laws, *, odd: bool) -> CriterionResult:
    """How far a criterion proves the classes ``[lower, k]`` for all plants of the box.

    Parameters
    ----------
    family : PlantFamily
        The plants.
    row : Theorem
        The criterion.
    lower : Fraction
        Lower end of the classes.
    laws : callable
        The class with an upper end, and the same as it stands in a certificate.
    odd : bool
        Whether the classes are of odd nonlinearities.

    Raises
    ------
    AssumptionError
        The criterion proves no class of all plants of the box.
    """
    if row.name in UNUSED:
        raise AssumptionError(f"the criterion {row.name} is not shown of plants with parameters; try best")

    reach = partial(_reach, row, lower, odd=odd)
    if family.order_changes:
        _ = Search(family, row, odd).tree(laws("finite")[1], lower, "finite")  # says so
    costly = row.stage > 0 and not family.delay
    if costly:  # what is worst for a cheap criterion, and if that is not all Short says where more is to be seen
        top, worst = min((reach(family.at(point)), point) for point in (cheaply_worst(family, lower), family.middle))
    else:
        worst, top = least(family, reach, looks=len(family.box) * 4 + 2 if row.stage else MOST_LOOKS)
    if top <= lower:
        raise AssumptionError(f"with {family.words(worst)} the criterion proves nothing")
    search = Search(family, row, odd, worst=worst if costly else None)
    kept, reason = list[tuple[Upper, Tree]](), ""

    def tries(upper: Upper) -> bool:
        """Whether a class is shown, which is then kept."""
        nonlocal top, reason
        try:
            kept.append((upper, search.tree(laws(upper)[1], lower, upper, kept[-1][1] if kept else None)))
        except Short as short:
            there, reason = reach(family.at(short.point)), str(short)
            if there < top:
                top, search.worst = there, short.point if costly else None
        except AssumptionError as refusal:
            reason = str(refusal)
        else:
            return True
        return False

    if top == math.inf:
        _ = tries("finite") or any(tries(Fraction(n)) for n in LARGE)
    else:
        for share in NEAR:
            if not any(tries(_below(lower, before, share)) for before in _tops(lambda: top)):
                break
            if family.delay and leaves(kept[-1][1]) > MOST_LATE:
                break  # each takes the checker half a second
        _ = kept or any(tries(_below(lower, top, share)) for share in FAR)
    if not kept:
        raise AssumptionError(reason or "nothing is proved for all parameters")
    upper, tree = kept[-1]
    nonlinearity_class, entry = laws(upper)
    shown = search.proved(entry, lower, upper, tree)
    end = math.inf if isinstance(upper, str) else float(upper)
    tried = top == math.inf and not isinstance(upper, str)
    return replace(
        _of_all(row.answer(family.central, lower=lower, odd=odd), family, shown),
        nonlinearity_class=nonlinearity_class,
        largest=Bracket(end, max(end, double_above(Fraction(top)) if top < math.inf else top)),
        reason=f"{end:g} is the largest k for which a certificate was tried" if tried else reason,
        search_limited=tried,
    )


def _of_all(answer: CriterionResult, family: PlantFamily, shown: Proved) -> CriterionResult:
    """An answer about the plant in the middle, of which stays what holds for all plants by what was accepted."""
    return replace(
        answer,
        verdict=Verdict.PROVED,
        evidence=Evidence.CERTIFIED,
        theta=None,
        multiplier=None,
        parameters={name: [str(low), str(high)] for name, (low, high) in zip(family.names, family.box, strict=True)},
        margin=None,
        worst_frequency=None,
        hypotheses=tuple(f"{name}: {fact}" for name, fact in shown.facts.items()),
        shown=shown,
    )


def _reach(row: Theorem, lower: Fraction, plant: RationalPlant | DelayPlant, *, odd: bool) -> float:
    """How far a criterion goes for one plant."""
    if isinstance(plant, DelayPlant):
        return best_theta(plant, turned=row.name == "popov")[1]
    answer = row.answer(plant, lower=lower, odd=odd)
    return answer.largest.low if answer.verdict is Verdict.PROVED else -math.inf


def _below(lower: Fraction, top: float, share: Fraction) -> Fraction:
    """A double that leaves a share of the way from ``lower`` to ``top``."""
    return Fraction(double_below(lower + (Fraction(top) - lower) * (1 - share)))


def _tops(top: Callable[[], float]) -> Iterator[float]:
    """How far the worst plant known lets it go, again while a worse one is found, twice at most."""
    before = math.inf
    for _ in range(3):
        if top() < before:
            before = top()
            yield before


# Refutations: a plant of the box with a destabilising member.


def refuted_at(family: PlantFamily, point: Point, witness: Witness) -> Witness:
    """The witness of one plant of the box, as one of the box.

    ``witness``: what destabilises the loop there, with what the checker accepted of it.
    """
    data = {**witness.data, "parameters": {name: str(v) for name, v in zip(family.names, point, strict=True)}}
    said = witness.description
    if "k" in family.names:  # which is then no name for the gain
        said = re.sub(r"\bk\b", "gain" if "g" in family.names else "g", said)
    description = f"with {family.words(point)}, {said}"
    moved = replace(witness, description=description, data=data, refutation=None)
    if witness.refutation is None:
        return moved
    inner = witness.refutation.certificate
    whole = {**member_draft(family, point, inner), "laws": inner["laws"]}
    found = guarded("the parameters", lambda: complete_and_check(whole), passing=(TimeoutError,))
    if not isinstance(found, Refuted):
        return replace(moved, evidence=Evidence.COMPUTED)
    return replace(moved, refutation=found)


def member_draft(family: PlantFamily | ChannelFamily, point: Point, inner: Mapping[str, Any]) -> dict[str, Any]:
    """The draft of a refutation by one plant of the box, from a certificate about that plant."""
    proof = {"method": "member", "at": [str(v) for v in point], "proof": inner["proof"]}
    return {**inner, "system": system_of(family), "proof": proof}
