"""Classes of nonlinearities: what a claim speaks about, what it contains, and whether a theorem covers all of it."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from typing import Literal, cast

from lure.analysis.certificates.second.axis import Need
from lure.analysis.certificates.second.reading import NotShown, flag, listed, number, record, require

# The sentences a certificate may conclude with, and what has to be positive for which upper bound.

ATTRACTS = "0 attracts every motion"
EQUILIBRIA = "every motion converges to the set of equilibria"
BOUNDED = "every motion is bounded"
DELAYED = "0 attracts every motion with inputs to the block and initial functions of finite energy"
AT_REST = "every motion of finite energy comes to rest, its end at a zero of the law"
SQUARE_INTEGRABLE = (
    "every motion of finite energy comes to rest, and the pressure of every contact is square integrable"
)
PRESSURELESS = "every motion of finite energy comes to rest, and the pressure of every contact tends to 0"
GAINS = "every constant gain of the class makes the loop asymptotically stable"
NO_REST = "a loop of the class has a motion that does not converge to an equilibrium"
OTHER_EQUILIBRIA = "a loop of the class has equilibria other than 0"
GAIN = "the L2 gain from w to z is at most gamma in every loop of the class"
UNLIMITED = "no L2 gain from w to z is finite for all loops of the class"
EXCEEDED = "the L2 gain from w to z is above gamma in a loop of the class"
NO_SOLUTION = "a loop of the class is not well posed: 1 + g H(inf) = 0"


@dataclass(frozen=True, kw_only=True, slots=True)
class Claim:
    """A class of nonlinearities after the mirror, with a finite lower bound.

    Attributes
    ----------
    nonlinearities : Nonlinearities
        The class.
    lower : Fraction
        Its lower bound, by which the loop is shifted.
    """

    nonlinearities: Nonlinearities
    lower: Fraction

    @classmethod
    def of(cls, nonlinearities: Nonlinearities) -> Claim:
        """The claim of a class.

        Raises
        ------
        NotShown
            The lower bound is infinite.
        """
        if not isinstance(nonlinearities.lower, Fraction):
            raise NotShown("the lower bound is infinite")
        return cls(nonlinearities=nonlinearities, lower=nonlinearities.lower)

    @property
    def width(self) -> Fraction | None:
        """``w = k - l``; None for ``finite`` and ``inf``."""
        return self.nonlinearities.upper - self.lower if isinstance(self.nonlinearities.upper, Fraction) else None

    @property
    def inverse_gain(self) -> Fraction:
        """``1/w``, or 0."""
        return Fraction(0) if self.width is None else 1 / self.width

    @property
    def unbounded(self) -> bool:
        """Whether nonlinearities without any upper bound are meant."""
        return self.nonlinearities.upper == "inf"

    @property
    def need(self) -> Need:
        """What the left-hand side without the excess must satisfy, for a bounded class."""
        return "nonnegative" if self.nonlinearities.upper == "finite" else "positive"


Upper = Fraction | Literal["finite", "inf"]
Lower = Fraction | Literal["-inf"]


@dataclass(frozen=True, slots=True)
class Graph:
    """A continuous piecewise-linear nonlinearity.

    Attributes
    ----------
    knots, values : tuple of Fraction
        Points of the graph in ascending order, the origin among them.
    slopes : tuple of Fraction
        Left of the first knot, between the knots, right of the last.
    """

    knots: tuple[Fraction, ...]
    values: tuple[Fraction, ...]
    slopes: tuple[Fraction, ...]

    def at(self, sigma: Fraction) -> Fraction:
        """``phi(sigma)``."""
        i = bisect_left(self.knots, sigma)
        anchor = min(i, len(self.knots) - 1)
        return self.values[anchor] + self.slopes[i] * (sigma - self.knots[anchor])

    @property
    def kinks(self) -> list[tuple[Fraction, Fraction, Fraction]]:
        """Where the slope changes: ``sigma``, ``phi`` and the slope to the right."""
        sides = pairwise(self.slopes)
        return [(x, y, k) for x, y, (h, k) in zip(self.knots, self.values, sides, strict=True) if h != k]

    @property
    def chords(self) -> list[Fraction]:
        """All values at which ``phi(sigma)/sigma``, monotone between the knots, can be extreme."""
        at_zero = self.knots.index(Fraction(0))
        limits = [self.slopes[i] for i in (0, -1, at_zero, at_zero + 1)]
        return limits + [y / x for x, y in zip(self.knots, self.values, strict=True) if x != 0]

    @property
    def odd(self) -> bool:
        """Whether ``phi(-sigma) = -phi(sigma)``."""
        return self.slopes[0] == self.slopes[-1] and all(self.at(-x) == -self.at(x) for x in self.knots)


@dataclass(frozen=True, kw_only=True, slots=True)
class Nonlinearities:
    """Nonlinearities with ``phi(0) = 0`` and the bounds of ``phi(sigma)/sigma`` and of the difference quotients.

    ``finite`` as an upper bound: the union of the classes with a finite bound; ``inf``: no bound at all.
    """

    lower: Lower
    upper: Upper
    slope: tuple[Lower, Upper] | None
    odd: bool
    time_varying: bool
    linear: bool
    rough: bool = False  # continuous or not; else locally Lipschitz
    relu: bool = False  # piecewise linear, with its least slope left of 0 and its greatest right of it
    rate: Fraction | None = None  # of gains that depend on time: |g(t) - g(s)| <= rate |t - s|
    memory: tuple[str, Fraction] | None = None  # play or stop, and the largest quotient of increments
    operator: str = ""  # which operators of norm up to ``upper``, acting on a block of channels; else functions

    def mirrored(self) -> Nonlinearities:
        """The class of ``-phi``, which the loop of ``-H`` has; ``[-k, -l]`` in place of ``[l, k]``."""
        slope = None if self.slope is None else _mirrored(*self.slope)
        lower, upper = _mirrored(self.lower, self.upper)
        return replace(self, lower=lower, upper=upper, slope=slope)

    @property
    def ends(self) -> tuple[Fraction | None, Fraction | None]:
        """Least and greatest gain of the class, None where there is none, of delays and of functions of a block."""
        if self.operator in (*DELAYS, FULL_BLOCK):
            return None, None
        slope = self.slope or (self.lower, self.upper)
        lows = [end for end in (self.lower, slope[0]) if isinstance(end, Fraction)]
        highs = [end for end in (self.upper, slope[1]) if isinstance(end, Fraction)]
        return max(lows, default=None), min(highs, default=None)

    def slopes_within(self, lower: Lower, upper: Upper) -> bool:
        """Whether every nonlinearity of the class has its slope within these bounds."""
        return self.slope is not None and at_least(self.slope[0], lower) and at_most(self.slope[1], upper)

    def has_gain(self, gain: Fraction) -> bool:
        """Whether ``phi = gain sigma``, an odd nonlinearity that does not depend on time, is in the class."""
        if self.relu or self.memory is not None:
            return False
        if self.operator in DELAYS:  # sigma(t - 0)
            return gain == 1
        inside = at_least(gain, self.lower) and at_most(gain, self.upper)
        return inside and (self.slope is None or (at_least(gain, self.slope[0]) and at_most(gain, self.slope[1])))

    def has(self, nonlinearity: Graph) -> bool:
        """Whether a piecewise-linear nonlinearity is in the class, which is not that of a ReLU."""
        if self.relu or self.memory is not None:
            return False
        inside = at_least(min(nonlinearity.chords), self.lower) and at_most(max(nonlinearity.chords), self.upper)
        if self.slope is not None:
            inside = (
                inside
                and at_least(min(nonlinearity.slopes), self.slope[0])
                and at_most(max(nonlinearity.slopes), self.slope[1])
            )
        return inside and (nonlinearity.odd or not self.odd) and (not nonlinearity.kinks or not self.linear)


def at_most(bound: Upper, limit: Upper) -> bool:
    """``bound <= limit`` for upper bounds: every number < ``finite`` < ``inf``."""
    if limit == "inf":
        return True
    if limit == "finite":
        return bound != "inf"
    return isinstance(bound, Fraction) and bound <= limit


def at_least(bound: Lower, limit: Lower) -> bool:
    """``bound >= limit`` for lower bounds."""
    return limit == "-inf" or (isinstance(bound, Fraction) and bound >= limit)


DELAYS = ("delay", "varying delay")
SCALAR, FULL_BLOCK = "scalar linear time-invariant", "full block"


def read_memory(value: Mapping[str, object]) -> Nonlinearities:
    """Play or stop operators: of ``phi(sigma)/sigma`` nothing is known."""
    found = record(value, "sector", "slope", "odd", "time_varying", "linear", "memory")
    kind, slope, sector = found["memory"], _bounds(found["slope"]), _bounds(found["sector"])
    require(kind in ("play", "stop"), "the kind of memory is unknown")
    require(slope == sector and slope[0] == 0 and isinstance(slope[1], Fraction), "play and stop have no such slopes")
    require(not any(flag(found[name]) for name in ("odd", "time_varying", "linear")), "memory has no other property")
    k = slope[1]
    return Nonlinearities(
        lower="-inf",
        upper="inf",
        slope=None,
        odd=False,
        time_varying=False,
        linear=False,
        memory=(str(kind), k) if isinstance(k, Fraction) else None,
    )


def read_operator(value: Mapping[str, object]) -> Nonlinearities:
    """The operators of a certificate: of nothing but their norm is there a bound."""
    slow = ["rate"] if "rate" in value else []
    found = record(value, "sector", "slope", "odd", "time_varying", "linear", "operator", *slow)
    kinds = {
        **{"any": True, "linear time-invariant": False, SCALAR: False, "performance": True},
        **{"delay": False, "varying delay": True},
    }
    operator = found["operator"]
    block = operator == FULL_BLOCK
    kinds |= {FULL_BLOCK: flag(found["time_varying"])}
    require(isinstance(operator, str) and operator in kinds, "the kind of operator is unknown")
    lower, upper = _bounds(found["sector"])
    finite = isinstance(upper, Fraction) and isinstance(lower, Fraction)
    require(finite and (block or lower == -upper), "the norm of an operator has no bound")  # type: ignore[operator]  # finite is asked first
    bare = found["slope"] is None and not flag(found["odd"]) and not flag(found["linear"])
    require(bare and flag(found["time_varying"]) is kinds[str(operator)], "an operator has no other properties")
    rate = number(found["rate"]) if slow else None
    require(rate is None or (0 < rate < 1 and operator == DELAYS[1]), "a rate is one of delays, between 0 and 1")
    return Nonlinearities(
        lower=lower,
        upper=upper,
        slope=None,
        odd=False,
        time_varying=kinds[str(operator)],
        linear=False,
        rate=rate,
        operator=str(operator),
    )


def read_nonlinearities(value: Mapping[str, object], *, rates: bool = False) -> Nonlinearities:
    """The class of a certificate; with ``rates`` gains may change at a bounded rate."""
    known = ("regularity", "relu", *(["rate"] if rates else []))
    rough, more = "regularity" in value, [key for key in known if key in value]
    found = record(value, "sector", "slope", "odd", "time_varying", "linear", *more)
    require(found.get("regularity", "any") == "any", "the regularity is unknown")
    lower, upper = _bounds(found["sector"])
    nonlinearities = Nonlinearities(
        lower=lower,
        upper=upper,
        slope=None if found["slope"] is None else _bounds(found["slope"]),
        odd=flag(found["odd"]),
        time_varying=flag(found["time_varying"]),
        linear=flag(found["linear"]),
        rough=rough,
        relu="relu" in value,
        rate=number(found["rate"]) if "rate" in found else None,
    )
    if nonlinearities.relu:
        require(
            found["relu"] is True and nonlinearities.slope == (lower, upper), "a ReLU has slopes that fill its sector"
        )
        require(isinstance(lower, Fraction) and isinstance(upper, Fraction), "the bounds of a ReLU are finite")
        others = (nonlinearities.odd, nonlinearities.time_varying, nonlinearities.linear, rough)
        require(not any(others), "a ReLU has no other property")
    moving = nonlinearities.linear and nonlinearities.time_varying
    paced = nonlinearities.rate is not None and nonlinearities.rate > 0
    still = nonlinearities.rate is None and not moving
    require(
        still or (paced and moving), "a rate is positive, and one of linear gains that depend on time, which have one"
    )
    least, greatest = nonlinearities.ends
    require(
        least is None or greatest is None or least <= greatest, "no nonlinearity has both the sector and the slopes"
    )
    return nonlinearities


def require_member(value: Mapping[str, object], nonlinearities: Nonlinearities) -> None:
    """Check that one nonlinearity, as written in a certificate, is in the class."""
    if value.get("kind") == "tanh":
        found = record(value, "kind", "height", "rate")
        height, rate = number(found["height"]), number(found["rate"])
        require(height > 0 and rate > 0, "tanh needs a positive height and rate")
        # phi/sigma and the slope take every value in (0, height rate), and the slope its maximum at 0
        steepest, flattest = height * rate, Fraction(0)
        inside = (
            at_least(flattest, nonlinearities.lower)
            and at_most(steepest, nonlinearities.upper)
            and not nonlinearities.linear
        )
        if nonlinearities.slope is not None:
            inside = (
                inside and at_least(flattest, nonlinearities.slope[0]) and at_most(steepest, nonlinearities.slope[1])
            )
        require(inside, "the nonlinearity is not in the class")
        return
    found = record(value, "kind", "points", "left", "right")
    require(found["kind"] == "piecewise-linear", "the kind of nonlinearity is unknown")
    require(
        nonlinearities.has(graph(found["points"], found["left"], found["right"])),
        "the nonlinearity is not in the class",
    )


def graph(points: object, left: object, right: object) -> Graph:
    """The piecewise-linear nonlinearity through these points; it must pass through the origin."""
    pairs = [tuple(number(value) for value in listed(point)) for point in listed(points)]
    require(bool(pairs) and all(len(pair) == 2 for pair in pairs), "there are no points, or one is no pair")
    through = [(pair[0], pair[1]) for pair in pairs]
    require(all(p[0] < q[0] for p, q in pairwise(through)), "the points of the nonlinearity do not ascend")
    given = _through(through, number(left), number(right))
    require(given.at(Fraction(0)) == 0, "the nonlinearity does not vanish at 0")
    if Fraction(0) in given.knots:
        return given
    return _through(sorted([*through, (Fraction(0), Fraction(0))]), given.slopes[0], given.slopes[-1])


def _through(points: list[tuple[Fraction, Fraction]], left: Fraction, right: Fraction) -> Graph:
    inner = [(y1 - y0) / (x1 - x0) for (x0, y0), (x1, y1) in pairwise(points)]
    return Graph(tuple(x for x, _ in points), tuple(y for _, y in points), (left, *inner, right))


def _bounds(value: object) -> tuple[Lower, Upper]:
    ends = listed(value)
    require(len(ends) == 2, "bounds are not a pair")
    lower: Lower = "-inf" if ends[0] == "-inf" else number(ends[0])
    upper: Upper = cast("Upper", ends[1]) if ends[1] in ("finite", "inf") else number(ends[1])
    if isinstance(lower, Fraction) and isinstance(upper, Fraction):
        require(lower < upper, "the lower bound is not below the upper one")
    return lower, upper


def _mirrored(lower: Lower, upper: Upper) -> tuple[Lower, Upper]:
    if upper == "finite":
        raise NotShown("a class without a common upper bound has no mirror image here")
    return ("-inf" if upper == "inf" else -upper), ("inf" if lower == "-inf" else -lower)
