"""Plants of several channels with parameters in a box: proofs by branch and bound over the box, one plant that refutes.

On each box one programme proposes a Lyapunov matrix and diagonal multipliers for all of its plants; where there are
none the box is cut.  Of a gain the box with the largest is cut, until that of some plant is met.  Nothing is believed.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cached_property, partial
from itertools import count, islice
from typing import Any, NamedTuple

from lure.analysis.certificates.checker import Proved, Refuted
from lure.analysis.certificates.drafts import complete_and_check, guarded
from lure.analysis.certificates.systems import system_of
from lure.analysis.counterexamples.channel_gains import GainSearch
from lure.analysis.inequality.box_matrices import BoxMatrices, Found
from lure.analysis.inequality.shifted_loop import LARGEST
from lure.analysis.numerics.doubles import double_below
from lure.analysis.questions import families
from lure.analysis.questions.problem import Problem
from lure.analysis.questions.worst_plants import least
from lure.analysis.theorems.table import BEST
from lure.arrays import Reals, np
from lure.classes import DELAYS
from lure.errors import AssumptionError, InputError, Reason
from lure.plants.channel_family import ChannelFamily
from lure.plants.multivariable import MultivariablePlant
from lure.plants.parameters import Box, Point
from lure.record import described, quantity

CIRCLE, POPOV = "diagonal-circle", "diagonal-popov"
_MOST, _MEET, _CORNERS = 250, 2e-3, 64
_WORTH = 0.02  # of what is to be taken off the largest gain: cuts that take less are not asked for
_SHAPES, _SEED = 16, 20261123  # of constant gains at which plants are compared
_STEPS = (1e-4, 1e-3, 1e-2, 0.1)
_FACTORS = (1e-4, 1e-3, 1e-2, 0.1, 0.5)
_LARGE = (1.0, 1e-2, 1e-3, 1e-4, 3e-5, 1e-5, 3e-6)  # of the largest factor
_AXIS = 1e-12  # relative: as far from it an eigenvalue may be one of 0, rounded
_NEAR = 1e-4  # relative: to which the worst plant's factor is found


def family_of(asked: Problem) -> ChannelFamily:
    """The plants of a question about several channels with parameters."""
    assert isinstance(asked.plant, ChannelFamily), "made for those"
    return asked.plant


def criteria(asked: Problem) -> list[str]:
    """The theorems to ask.

    Raises
    ------
    InputError
        None of them is asked for, or a class is not covered with parameters.
    """
    for i, one in enumerate(asked.classes.classes, 1):
        if one.memory or one.operator in DELAYS or one.rectifier:
            raise InputError(
                f"channel {i} is {one}, which is not asked for plants with parameters; give each parameter one number, "
                "or a sector in its place"
            )
    names = [CIRCLE] if family_of(asked).dt is not None or not any(free(asked)) else [POPOV, CIRCLE]
    wanted = asked.criterion.replace("_", "-").lower()
    found = [name for name in names if wanted in (BEST, name, name.removeprefix("diagonal-"))]
    if not found:
        raise InputError(
            f"the criterion {asked.criterion!r:.40} is not for several channels with parameters; choose from {BEST}, "
            f"{', '.join(names)}"
        )
    return found


def free(asked: Problem) -> list[bool]:
    """In which channels Popov's terms are possible: no direct term for any plant, and nothing depends on time."""
    family = family_of(asked)
    pairs = enumerate(zip(family.pattern, asked.classes.classes, strict=True))
    return [not any(row) and not one.time_varying and not one.operator and family.still(i) for i, (row, one) in pairs]


# Proofs.


@described()
class BoxSearch:
    """The search for a proof by one theorem."""

    asked: Problem = quantity("The question")
    theorem: str = quantity("``diagonal-circle`` or ``diagonal-popov``")
    rate: Fraction | None = quantity(
        "The plants are those of the solutions times ``r^-t``, or ``e^(a t)``", default=None
    )

    @cached_property
    def matrices(self) -> BoxMatrices:
        """The programme."""
        classes, popov = self.asked.classes, self.theorem == POPOV
        together = classes.operators
        blocks = [*together, *(range(i, i + 1) for i in range(len(classes.classes)) if not _in(i, together))]
        own = [one and popov for one in free(self.asked)]
        a = 0.0 if self.rate is None or family_of(self.asked).dt is not None else float(self.rate)
        within = [(one.slope.lower, one.slope.upper) == one.gains if one.slope else False for one in classes.classes]
        return BoxMatrices(family_of(self.asked), blocks, classes.performance, own, a, within)

    def _ends(self, alpha: Fraction) -> Reals:
        classes = self.asked.classes.scaled(alpha)
        return np.array([[float(low), float(high)] for low, high in zip(classes.lower, classes.upper, strict=True)])

    def _at(self, point: Point, ends: Reals, gain: float | None) -> Found | None:
        return self.matrices.solved(place_of(family_of(self.asked), point), ends, gain)

    def tree(self, alpha: Fraction, gain: float | None = None, start: families.Tree | None = None) -> families.Tree:
        """Boxes that cover the box, each with what serves on it.

        ``alpha``: the factor of the classes; ``gain``: the gain from ``w`` to ``z``; ``start``: boxes to begin with.

        Raises
        ------
        AssumptionError
            At some plant the theorem does not serve, or the boxes became too many.
        """
        ends, number = self._ends(alpha), [0]

        def made(box: Box) -> families.Tree:
            """The tree of a box: a leaf where multipliers serve all of it, else its halves."""
            number[0] += 1
            if number[0] > _MOST:
                raise families.too_many(family_of(self.asked), box, _MOST)
            found = self.matrices.solved(box, ends, gain)
            if found is not None:
                return families.Leaf(box, found.entry(popov=self.theorem == POPOV))
            middle = tuple((low + high) / 2 for low, high in box)
            if self._at(middle, ends, gain) is None:
                raise families.Short(middle, family_of(self.asked).words(middle))
            across = self.matrices.widest(box)
            if any(family_of(self.asked).rates[across : across + 1]):
                raise AssumptionError(
                    "no quadratic function was found for parameters that change over all their interval"
                )
            return families.cut(box, across, made)

        def again(part: families.Tree) -> families.Tree:
            """The same cuts, each leaf asked anew."""
            if isinstance(part, families.Cut):
                return replace(part, below=again(part.below), above=again(part.above))
            return made(part.box)

        return again(start or families.Leaf(family_of(self.asked).box))

    def serves(self, box: Box) -> bool:
        """Whether the programme finds something for the classes as they are on a box, or at one plant.

        ``box``: where the parameters are.
        """
        return self.matrices.solved(box, self._ends(Fraction(1))) is not None

    def accepted(self, alpha: Fraction, tree: families.Tree, system: Mapping[str, Any] | None = None) -> Proved | None:
        """What the checker accepts for the classes of a factor.

        Parameters
        ----------
        alpha : Fraction
            The factor.
        tree : Leaf or Cut
            The boxes.
        system : Mapping, optional
            With a rate: the plants as they are.
        """
        draft = {
            "verdict": "PROVED",
            "system": system or system_of(family_of(self.asked)),
            "laws": self.asked.scaled(alpha).class_entry,
            "theorem": self.theorem,
            "multiplier": {},
            "proof": {"method": "boxes", "boxes": families.written(tree)},
        } | ({} if self.rate is None else {"rate": str(self.rate)})
        found = guarded(self.theorem, lambda: complete_and_check(draft), passing=(TimeoutError,))
        return found if isinstance(found, Proved) else None

    def whole(self) -> Proved:
        """What is proved of the classes as they are given.

        Raises
        ------
        AssumptionError
            Nothing.
        """
        gain = None if self.asked.classes.performance is None else 1 / float(self.asked.classes.upper[-1])
        shown = self.accepted(Fraction(1), self.tree(Fraction(1), gain))
        if shown is None:
            raise AssumptionError("the checker does not accept what was found", code=Reason.NO_MULTIPLIER)
        return shown

    def parts(self) -> None:
        """Say where in the box nothing is proved of the classes as they are given.

        Raises
        ------
        AssumptionError
            With the parts of the box.
        """
        family, classes = family_of(self.asked), self.asked.classes
        ends, gain = self._ends(Fraction(1)), None if classes.performance is None else 1 / float(classes.upper[-1])
        found = families.open_parts(
            family, lambda box: self.matrices.solved(box, ends, gain) is not None, self.matrices.widest
        )
        raise AssumptionError(found, code=Reason.NO_MULTIPLIER)

    def farthest(self, known: Fraction, most: float) -> tuple[Fraction, Proved] | None:
        """The largest factor that is proved, above what is known and below ``most``.

        ``known``: a factor that is proved, or 0; ``most``: the smallest factor that is refuted, or infinity.

        Raises
        ------
        AssumptionError
            At some plant the theorem does not serve, or the boxes became too many.
        """
        if self.asked.classes.performance is not None:
            return self._least_gain(known)
        family, least = family_of(self.asked), self.asked.classes.least

        def serves(point: Point, alpha: float) -> bool:
            """Whether multipliers for one plant are found at a factor."""
            exact = Fraction(double_below(Fraction(alpha)))
            return exact > least and self._at(point, self._ends(exact), None) is not None

        def reach(point: Point, top: float) -> float:
            """How far the theorem serves a plant, below ``top``."""
            if serves(point, top * (1 - 1e-7)):
                return top
            low, high = 0.0, top
            while high - low > _NEAR / 10 * high and high > 1 / LARGEST:
                middle = (low + high) / 2 if low else high / 4
                low, high = (middle, high) if serves(point, middle) else (low, middle)
            return low

        top = min(most, LARGEST)
        for point in (family.middle, *islice(family.corners, _CORNERS)):
            top = reach(point, top)
        refusal: AssumptionError | None = None
        for share in (*(1 - step for step in _FACTORS), *_LARGE[1:]) if top < LARGEST else _LARGE:
            alpha = Fraction(double_below(Fraction(top) * Fraction(share)))
            if alpha <= max(known, least):
                break
            try:
                shown = self.accepted(alpha, self.tree(alpha))
            except AssumptionError as error:
                refusal = error
                continue
            if shown is not None:
                return alpha, shown
        if refusal is not None and not known:
            raise refusal
        return None

    def _least_gain(self, known: Fraction) -> tuple[Fraction, Proved] | None:
        """The same of a gain: the box with the largest is cut until that of a plant is met."""
        unit = Fraction(self.asked.classes.upper[-1])
        boxes = _GainTree(self)
        largest, tree = boxes.grown()
        if math.isinf(largest.gain):
            raise families.too_many(boxes.family, largest.place[0].box, _MOST)
        gain = max(largest.gain, boxes.floor)
        for step in _STEPS:
            alpha = Fraction(double_below(1 / (unit * Fraction(gain * (1 + step)))))
            if alpha <= known:
                return None
            try:
                shown = self.accepted(alpha, self.tree(alpha, 1 / float(unit * alpha), tree))
            except AssumptionError:
                continue
            if shown is not None:
                return alpha, shown
        raise AssumptionError("a gain was found that the checker does not accept", code=Reason.NO_MULTIPLIER)


class _Half(NamedTuple):
    """A box that is not cut yet: its place in the tree, and by how much cuts across each parameter lower its gain."""

    place: list[families.Tree]
    gain: float
    worth: list[float]


class _GainTree:
    """Boxes, of which that with the largest gain is cut until the gain of some plant is met.

    Parameters
    ----------
    search : BoxSearch
        The question.
    """

    def __init__(self, search: BoxSearch) -> None:
        self.search, self.family = search, family_of(search.asked)
        self.ends, self.order = search._ends(Fraction(1)), count()
        self.floor, self.worst = 0.0, self.family.middle
        self.heap = list[tuple[float, int, _Half]]()

    def _look(self, point: Point) -> None:
        """The gain of a plant."""
        found = self.search._at(point, self.ends, None)
        if found is None:
            raise families.Short(point, self.family.words(point))
        if found.gain > self.floor:
            self.floor, self.worst = found.gain, point

    def _gain(self, box: Box) -> float:
        found = self.search.matrices.solved(box, self.ends, None)
        return math.inf if found is None else found.gain

    def _push(self, box: Box, worth: list[float], gain: float | None = None) -> _Half:
        one = _Half([families.Leaf(box)], self._gain(box) if gain is None else gain, worth)
        if math.isinf(one.gain):
            self._look(tuple((low + high) / 2 for low, high in box))
        heapq.heappush(self.heap, (-one.gain, next(self.order), one))
        return one

    def _across(self, one: _Half) -> int:
        """The parameter to cut: by what a cut there took off, or where that is too little the widest."""
        j = max(range(len(one.worth)), key=one.worth.__getitem__)
        enough = one.worth[j] > _WORTH * (one.gain - self.floor) and math.isfinite(one.gain)
        return j if enough else self.search.matrices.widest(one.place[0].box)

    def _towards(self, box: Box) -> list[float]:
        """What each cut takes off the gain of the half where the worst plant known is."""
        whole, found = self._gain(box), list[float]()
        for j, (low, high) in enumerate(box if math.isfinite(whole) else ()):
            at = families.simplest(low, high)
            half = (low, at) if self.worst[j] <= at else (at, high)
            found.append(max(whole - self._gain((*box[:j], half, *box[j + 1 :])), 0.0))
        return found or [0.0] * len(box)

    def grown(self) -> tuple[_Half, families.Tree]:
        """The box with the largest gain, and all.

        Raises
        ------
        AssumptionError
            At some plant the theorem does not serve.
        """
        for point in (self.family.middle, *islice(self.family.corners, _CORNERS)):
            self._look(point)
        root = self._push(self.family.box, [0.0] * len(self.family.box))
        if root.gain > self.floor * (1 + _MEET):
            self.heap.clear()
            root = self._push(self.family.box, self._towards(self.family.box), root.gain)
        cuts = list[tuple[_Half, int, Fraction, _Half, _Half]]()
        while -self.heap[0][0] > self.floor * (1 + _MEET) and len(self.heap) < _MOST:
            one = heapq.heappop(self.heap)[-1]
            box = one.place[0].box
            self._look(tuple((low + high) / 2 for low, high in box))
            j = self._across(one)
            at, halves = families.simplest(*box[j]), list[_Half]()
            for pair in ((box[j][0], at), (at, box[j][1])):
                half = self._push((*box[:j], pair, *box[j + 1 :]), list(one.worth))
                off = one.gain - half.gain
                half.worth[j] = max(off, 0.0) / 4 if math.isfinite(off) else 0.0  # as the square of the width
                halves.append(half)
            cuts.append((one, j, at, halves[0], halves[1]))
        for one, j, at, below, above in reversed(cuts):
            one.place[0] = families.Cut(one.place[0].box, j, at, below.place[0], above.place[0])
        return self.heap[0][-1], root.place[0]


def _in(i: int, blocks: Sequence[range]) -> bool:
    return any(i in block for block in blocks)


# Refutations.

Against = Callable[[Problem], tuple[Fraction, Refuted] | None]


def place_of(family: ChannelFamily, point: Point) -> Box:
    """The box of one plant, of parameters that change all of their intervals.

    ``point``: the constant parameters, and any others.
    """
    rates = family.rates or (0,) * len(point)
    return tuple(own if rate else (v, v) for v, own, rate in zip(point, family.box, rates, strict=True))


def refuting(asked: Problem, against: Against) -> tuple[Fraction, Refuted] | None:
    """The smallest factor that one plant of the box refutes.

    ``against``: the search for one plant: a factor, and what the checker accepted.
    """
    best: tuple[Fraction, Refuted] | None = None
    for point in _severe(asked):
        one = replace(asked, plant=family_of(asked).at(point))
        found = guarded("one plant of the box", partial(against, one), passing=(TimeoutError,))
        if not isinstance(found, tuple) or (best is not None and found[0] >= best[0]):
            continue
        draft = families.member_draft(family_of(asked), point, found[1].certificate)
        shown = guarded("the parameters", partial(complete_and_check, draft), passing=(TimeoutError,))
        best = (found[0], shown) if isinstance(shown, Refuted) else best
    return best


def _severe(asked: Problem) -> Iterator[Point]:
    """Plants that seem to be the worst."""
    family, seen = family_of(asked), set[Point]()
    worst, _ = least(family, lambda plant: slack(asked, plant), looks=30)
    for point in (worst, family.middle, *islice(family.corners, 2)):
        if point not in seen:
            seen.add(point)
            yield point


def slack(asked: Problem, plant: MultivariablePlant) -> float:
    """About the smallest factor at which constant gains destabilise; of a gain less that of linear members.

    ``plant``: one plant of the box.
    """
    own = [*(asked.classes.performance or ())]
    rest = [i for i in range(len(plant.D)) if i not in own]
    A, B, C, D = plant.doubles()
    lower, upper = (np.array([float(v) for v in side]) for side in (asked.classes.lower, asked.classes.upper))
    places = [[rest.index(i) for i in block] for block in asked.classes.blocks if block[0] in rest]
    if not rest:
        return -_norm(A, B, C, D, discrete=plant.dt is not None)
    inner = A, B[:, rest], C[rest], D[np.ix_(rest, rest)]
    search = GainSearch(*inner, lower[rest], upper[rest], places, plant.dt is not None)
    if not own:
        return float(search.first(_spread(search.shapes()), search.scales(), zooms=2).min())
    worst = 0.0
    for shape in _spread(np.vstack([np.zeros((1, len(rest))), search.shapes()])):
        gains = np.zeros(len(D))
        gains[rest] = lower[rest] + shape * (upper[rest] - lower[rest])
        whole = np.linalg.inv(np.eye(len(D)) + D @ np.diag(gains))
        closed = whole @ C
        inward = B - B @ np.diag(gains) @ whole @ D
        sides = A - B @ np.diag(gains) @ closed, inward[:, own], closed[own], (whole @ D)[np.ix_(own, own)]
        worst = max(worst, _norm(*sides, discrete=plant.dt is not None))
    return -worst


def _spread(shapes: Reals) -> Reals:
    """Some of these: vertices first, of many of them some on all sides."""
    order = np.random.default_rng(_SEED).permutation(len(shapes))
    inside = np.asarray(((shapes > 0) & (shapes < 1)).any(axis=1))
    return np.asarray(shapes[order[np.argsort(inside[order], kind="stable")]][:_SHAPES])


def _norm(A: Reals, B: Reals, C: Reals, D: Reals, *, discrete: bool) -> float:
    """About the largest gain over the frequencies; infinite for a loop that is unstable, or nearly so."""
    poles = np.linalg.eigvals(A).astype(complex)
    slowest = np.abs(poles).max() - 1 if discrete else poles.real.max()
    if slowest > -_AXIS * max(float(np.abs(poles).max()), 1e-300):
        return math.inf
    size = np.abs(poles)[np.abs(poles) > 0] if poles.any() else np.ones(1)
    points = np.concatenate([np.geomspace(size.min() / 30, size.max() * 30, 120), np.abs(poles.imag), [0.0]])
    s = np.exp(1j * np.linspace(0, np.pi, 240)) if discrete else 1j * points
    response = C @ np.linalg.solve(s[:, None, None] * np.eye(len(A)) - A, B.astype(complex)) + D
    return float(np.linalg.norm(response, 2, axis=(1, 2)).max())
