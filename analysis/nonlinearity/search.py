"""The largest value of a smooth piece on an interval, by branch and bound in ball arithmetic."""

from __future__ import annotations

import heapq
import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import count

from flint import arb

from lure.analysis.nonlinearity.expansion import Expansion, Stretch, Unsettled, enclosure_at_end, expanded
from lure.analysis.nonlinearity.jets import jet, value_at, values_by_branch
from lure.analysis.nonlinearity.rational import Candidate, Cover, End, bounds_of, interval_of
from lure.analysis.nonlinearity.result import Bound
from lure.analysis.numerics.polynomial import to_fmpq
from lure.errors import InputError
from lure.expressions.rigorous import ball
from lure.expressions.tree import Node, Variable, size
from lure.record import described, quantity

# What is bounded on an interval, and the parts the interval is divided into.


class NotEnclosed(InputError):
    """Near a point the values could not be enclosed, however short the interval; ``place`` is the point."""

    def __init__(self, place: Fraction) -> None:
        self.place = place
        super().__init__(
            f"the nonlinearity has a pole, or no value that could be enclosed, near sigma = {float(place):.10g}; "
            "write a formula with finite values, or bound it on an interval without that point"
        )


@described(frozen=True, kw_only=True, slots=True)
class Target:
    """A function of ``sigma`` on an open interval, in two shapes."""

    tree: Node = quantity("For boxes: ``phi(sigma)/sigma`` with what cancels cancelled, or the derivative")
    base: Node = quantity("For the ends: ``phi``, or the derivative")
    over_sigma: bool = quantity("Whether ``base`` is still to be divided by ``sigma``")
    low: End = quantity("Lower end of the interval")
    high: End = quantity("Upper end of the interval")
    vanishes: bool = quantity(
        "Whether ``base`` is known to tend to 0 at 0, whatever rounding leaves of it", default=False
    )


@described(frozen=True, kw_only=True, slots=True)
class Region:
    """A part of the interval with what is known of the values there."""

    box: tuple[Fraction, Fraction] | None = quantity("A closed interval without a singular end")
    end: tuple[End, int, int] | None = quantity(
        "Instead: an end, the side on which the interval lies, and ``n`` for the stretch ``0 < t <= 2^-n``"
    )
    cover: Cover = quantity("What the values lie between")
    found: tuple[Candidate, ...] = quantity("Values there", default=())
    closed: bool = quantity("Whether ``cover`` is as narrow as it will get", default=False)

    @property
    def unknown(self) -> bool:
        """Whether nothing is known of a box, not even that the nonlinearity has values there."""
        return self.box is not None and self.cover.low == -math.inf and self.cover.high == math.inf


def border(end: End, side: int, stage: int) -> Fraction:
    """``sigma`` at ``t = 2^-stage``."""
    if isinstance(end, Fraction):
        return end + side * Fraction(1, 2**stage)
    return Fraction(2**stage if end > 0 else -(2**stage))


def middle(a: Fraction, b: Fraction) -> Fraction:
    """The middle, in the logarithm for ends of one sign far apart."""
    if (a > 0 and b > 4 * a) or (b < 0 and a < 4 * b):
        sign = 1 if a > 0 else -1
        low, high = sorted((abs(a), abs(b)))
        exponent = (_log2(low) + _log2(high)) // 2
        guess = Fraction(2**exponent) if exponent >= 0 else Fraction(1, 2**-exponent)
        if low < guess < high:
            return sign * guess
    return (a + b) / 2


def _log2(x: Fraction) -> int:
    return x.numerator.bit_length() - x.denominator.bit_length()


# The values of a target on a closed interval, as far as one look at it tells.


def by_branch(target: Target, a: Fraction, b: Fraction) -> list[Region]:
    """A box too narrow to be halved, once more with its branches apart; nothing if that says no more."""
    values = values_by_branch(target.tree, ball(a).union(ball(b)))
    ends = [bounds_of(value) for value in values or []]
    if not ends or any(isinstance(end, float) for pair in ends for end in pair):
        return []
    cover = Cover(low=min(low for low, _ in ends), high=max(high for _, high in ends))
    return [Region(box=(a, b), end=None, cover=cover, closed=True)]


def evaluated(target: Target, a: Fraction, b: Fraction) -> Region:
    """What one look at the values, slope and curvature on the box shows."""
    tree = target.tree
    box = ball(a).union(ball(b))
    value, slope, bend = jet(tree, box)
    centre = middle(a, b)
    if slope >= 0 or slope <= 0:
        return _closed(a, b, [_point(target, a), _point(target, b)])
    at_centre = _point(target, centre)
    if bend.is_finite() and (bend > 0 or bend < 0):
        turning = _turning(target, a, b, bend)
        if turning is not None:
            return _closed(a, b, [_point(target, a), _point(target, b), *turning])
    spread = value
    if slope.is_finite() and at_centre is not None:
        step = box - ball(centre)
        first = _ball_of(at_centre) + slope * step
        spread = spread.intersection(first) if spread.is_finite() and spread.overlaps(first) else first
    low, high = bounds_of(spread)
    return Region(
        box=(a, b), end=None, cover=Cover(low=low, high=high), found=() if at_centre is None else (at_centre,)
    )


def _point(target: Target, x: Fraction) -> Candidate | None:
    """The value at a point; None where nothing is known of it."""
    low, high = bounds_of(value_at(target.tree, x))
    inside = target.low < x < target.high
    if not isinstance(low, Fraction) or not isinstance(high, Fraction):
        return None
    return Candidate(value=low if low == high else (low, high), place=x, inside=inside)


def _turning(target: Target, a: Fraction, b: Fraction, bend: arb) -> list[Candidate] | None:
    """The value where the slope changes sign, for a second derivative of one sign; empty if it does not."""
    tree = target.tree
    at_a, at_b = jet(tree, ball(a))[1], jet(tree, ball(b))[1]
    first, last = (at_a, at_b) if bend > 0 else (at_b, at_a)  # the slope rises from the first to the last
    if first >= 0 or last <= 0:
        return []
    if not (first < 0 and last > 0):
        return None
    inside = ball(a).union(ball(b))
    for _ in range(60):
        centre = inside.mid()
        newton = centre - jet(tree, centre)[1] / (2 * bend)
        if not newton.overlaps(inside):
            return None
        narrower = newton.intersection(inside)
        if not narrower.rad() < 0.75 * inside.rad():
            break
        inside = narrower
        new = jet(tree, inside)[2]
        bend = new if new.is_finite() and (new > 0 or new < 0) else bend
    slope = jet(tree, inside)[1]
    centre = inside.mid()
    held = jet(tree, centre)[0] + slope * (inside - centre)
    low, high = bounds_of(held)
    if not isinstance(low, Fraction) or not isinstance(high, Fraction):
        return None
    return [Candidate(value=(low, high), place=interval_of(inside), inside=True)]


def _closed(a: Fraction, b: Fraction, found: Sequence[Candidate | None]) -> Region:
    """A box on which the function is monotone between the points given."""
    known = tuple(c for c in found if c is not None)
    if len(known) < len(found):
        return Region(box=(a, b), end=None, cover=Cover(low=-math.inf, high=math.inf), found=known)
    cover = Cover(low=min(c.low for c in known), high=max(c.high for c in known))
    return Region(box=(a, b), end=None, cover=cover, found=known, closed=True)


def _ball_of(c: Candidate) -> arb:
    low, high = c.low, c.high
    return arb(to_fmpq(low)).union(arb(to_fmpq(high)))


MOST_BOXES = 4000
_NARROW = Fraction(1, 2**60)
_CLOSE = Fraction(1, 2**50)
_DEEPEST = 256
_FAR = Fraction(2**64)
_EXPANDING = 20  # what an expansion costs beside an evaluation on a box, about


@dataclass(slots=True)
class Effort:
    """How much work may still be done, in operations of a formula evaluated on a box; shared by several searches.

    ``until`` is the end of the time allowed, on the clock of ``time.monotonic``.
    """

    left: float = math.inf
    until: float = math.inf

    @property
    def late(self) -> bool:
        """Whether the time allowed is over."""
        return self.until < math.inf and time.monotonic() >= self.until

    @property
    def spent(self) -> bool:
        """Whether nothing may be done any more."""
        return self.left <= 0 or self.late


def extremes(
    target: Target, others: Sequence[Candidate] = (), effort: Effort | None = None
) -> tuple[list[Candidate], list[Cover]]:
    """Candidates and covers for the infimum and the supremum of a target.

    Parameters
    ----------
    target : Target
        The function and its interval.
    others : sequence of Candidate
        What was found elsewhere: nothing that lies between is looked at closely.
    effort : Effort, optional
        What may be spent; when nothing is left the covers are as wide as they then are.

    Returns
    -------
    tuple of list of Candidate and list of Cover
        Every value lies between the least and the largest of both lists; the candidates are taken or approached.

    Raises
    ------
    NotEnclosed
        Somewhere inside the formula has no value, or a pole.
    """
    search = _Search(target) if effort is None else _Search(target, effort)
    regions = list(search.start())
    candidates: list[Candidate] = []
    covers: list[Cover] = []
    for sign in (1, -1):
        found, rest = search.run(regions, sign, others)
        candidates += found
        covers += rest
    return candidates, covers


@dataclass(slots=True)
class _Search:
    target: Target
    effort: Effort = field(default_factory=Effort)
    ends: list[Bound] = field(default_factory=list)
    cache: dict[object, Region] = field(default_factory=dict)
    tick: Iterator[int] = field(default_factory=count)

    def start(self) -> Iterator[Region]:
        """The two ends, expanded where they are singular, and the box between them."""
        low, high = self.target.low, self.target.high
        ends: list[End] = []
        for end, side in ((low, 1), (high, -1)):
            if isinstance(end, Fraction) and self._regular(end):
                ends.append(end)
                self.ends.append(bounds_of(value_at(self.target.tree, end))[0])
                continue
            stage = 1 if isinstance(end, float) else self._first_stage()
            stage, region = self._first(end, side, stage)
            yield region
            ends.append(border(end, side, stage))
        a, b = ends
        assert isinstance(a, Fraction), "infinite ends are expanded"
        assert isinstance(b, Fraction), "infinite ends are expanded"
        if a < b:
            yield self._box(a, b)

    def run(self, regions: list[Region], sign: int, others: Sequence[Candidate]) -> tuple[list[Candidate], list[Cover]]:
        """Refine until the supremum of ``sign f`` is known, or the budget is spent."""
        heap = [(_rank(region, sign), -next(self.tick), region) for region in regions]
        heapq.heapify(heap)
        found = [c for region in regions for c in region.found]
        best = max((_least(c, sign) for c in (*found, *others)), default=-math.inf)
        limits = [c.low for region in regions if region.end is not None for c in region.found] + self.ends
        scale = max((abs(value) for value in limits if isinstance(value, Fraction)), default=Fraction(0))
        for _ in range(MOST_BOXES):
            top, _, region = heap[0]
            if region.closed or self.effort.spent or (_near(best, -top, scale) and not region.unknown):
                break
            heapq.heappop(heap)
            parts = self._refined(region)
            if not parts:  # nothing smaller can be asked
                heapq.heappush(
                    heap,
                    (top, -next(self.tick), Region(box=region.box, end=region.end, cover=region.cover, closed=True)),
                )
                break
            for part in parts:
                heapq.heappush(heap, (_rank(part, sign), -next(self.tick), part))
                found += part.found
                best = max([best, *(_least(c, sign) for c in part.found)])
        if not heap:
            return found, []
        cover = heap[0][2].cover
        return found, [Cover(low=math.inf, high=cover.high) if sign > 0 else Cover(low=cover.low, high=-math.inf)]

    def _refined(self, region: Region) -> list[Region]:
        if region.end is not None:
            end, side, stage = region.end
            if stage >= _DEEPEST:
                return []
            a, b = sorted((border(end, side, stage), border(end, side, stage + 2)))
            return [self._end(end, side, stage + 2), self._box(a, b)]
        assert region.box is not None, "a region is an end or a box"
        a, b = region.box
        largest = max(abs(a), abs(b))
        if b - a <= _NARROW * largest:
            unknown = not isinstance(region.cover.low, Fraction) or not isinstance(region.cover.high, Fraction)
            if unknown and 1 / _FAR < largest < _FAR:
                raise NotEnclosed((a + b) / 2)
            return by_branch(self.target, a, b)
        centre = middle(a, b)
        return [self._box(a, centre), self._box(centre, b)]

    def _regular(self, end: Fraction) -> bool:
        if end == 0:
            return False  # the limit of a chord, and a sign that shows a limit to be extreme, come from the expansion
        return all(part.is_finite() for part in jet(self.target.tree, ball(end)))

    def _first_stage(self) -> int:
        """How short the first stretch at a finite end is: less than half of the interval."""
        low, high = self.target.low, self.target.high
        if not isinstance(low, Fraction) or not isinstance(high, Fraction):
            return 1
        stage = 1
        while Fraction(1, 2**stage) * 2 > high - low:
            stage += 1
        return stage

    def _first(self, end: End, side: int, stage: int) -> tuple[int, Region]:
        """The longest stretch on which the expansion says something."""
        low, high = self.target.low, self.target.high
        if isinstance(end, float):
            other = high if end < 0 else low
            while isinstance(other, Fraction) and 2**stage <= 2 * abs(other):
                stage += 1
        last = stage
        for last in range(stage, _DEEPEST, 2):
            region = self._end(end, side, last)
            if self.effort.spent:
                break
            if isinstance(region.cover.low, Fraction) or isinstance(region.cover.high, Fraction):
                return last, region
        return last, region

    def _end(self, end: End, side: int, stage: int) -> Region:
        key = ("end", end, side, stage)
        if key not in self.cache:
            self.effort.left -= _EXPANDING * size(self.target.base)
            stretch = Stretch(ball(Fraction(1, 2**stage)))
            try:
                m = self._expansion(end, side, stretch)
                cover, limit = enclosure_at_end(m, stretch, end, side)
            except Unsettled:
                cover, limit = Cover(low=-math.inf, high=math.inf), None
            self.cache[key] = Region(
                box=None, end=(end, side, stage), cover=cover, found=() if limit is None else (limit,)
            )
        return self.cache[key]

    def _expansion(self, end: End, side: int, stretch: Stretch) -> Expansion:
        m = expanded(self.target.base, end, side, stretch)
        if end == 0 and self.target.vanishes:
            m = m.without_constant
        if self.target.over_sigma:
            variable = expanded_sigma(end, side, stretch)
            m = stretch.multiply(m, stretch.raised(variable, Fraction(-1)))
        return m

    def _box(self, a: Fraction, b: Fraction) -> Region:
        key = (a, b)
        if key not in self.cache:
            self.effort.left -= size(self.target.tree)
            self.cache[key] = evaluated(self.target, a, b)
        return self.cache[key]


def end_limit(target: Target, end: Fraction, side: int) -> Bound | tuple[Fraction, Fraction] | None:
    """The limit of a target at a finite end of its interval, None if it is not known."""
    low, high = bounds_of(value_at(target.tree, end))
    if isinstance(low, Fraction) and isinstance(high, Fraction):
        return low if low == high else (low, high)
    search = _Search(target)
    _, region = search._first(end, side, search._first_stage())
    return region.found[0].value if region.found else None


def expanded_sigma(end: End, side: int, stretch: Stretch) -> Expansion:
    """``sigma`` itself near an end."""
    return expanded(Variable("sigma"), end, side, stretch)


def _rank(region: Region, sign: int) -> Bound:
    """Minus the largest value of ``sign f``: the heap's least comes first."""
    return -region.cover.high if sign > 0 else region.cover.low


def _least(c: Candidate, sign: int) -> Bound:
    return c.low if sign > 0 else -c.high


def _near(best: Bound, top: Bound, scale: Fraction) -> bool:
    if best >= top:
        return True
    if isinstance(best, float) or isinstance(top, float):
        return False
    return top - best <= _CLOSE * max(abs(best), scale)
