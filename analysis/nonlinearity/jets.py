"""Values and two derivatives of a tree on a whole interval, in ball arithmetic."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from flint import arb, arb_series

from lure.expressions.regularity import has_value
from lure.expressions.rigorous import ball, enclosure, truth
from lure.expressions.tree import ONE, Apply, Node, Number, Variable, apply

# Intervals with two ends in ball arithmetic: a radius has 30 bits, too few for a wide interval that must end at 0.


@dataclass(frozen=True, slots=True)
class Span:
    """All numbers from ``low`` to ``high``, exact balls."""

    low: arb
    high: arb

    @classmethod
    def of(cls, value: arb) -> Span:
        """The interval of a ball."""
        return cls(value.lower(), value.upper())

    @property
    def is_zero(self) -> bool:
        """Whether it holds 0 alone."""
        return bool(self.low == 0) and bool(self.high == 0)

    @property
    def is_finite(self) -> bool:
        """Whether both ends are."""
        return self.low.is_finite() and self.high.is_finite()

    @property
    def sign(self) -> int | None:
        """1 or -1 if 0 does not belong to it, else None."""
        return 1 if self.low > 0 else -1 if self.high < 0 else None

    @property
    def ball(self) -> arb:
        """A ball that contains it."""
        return self.low.union(self.high)

    @property
    def size(self) -> Span:
        """The absolute values."""
        if self.low >= 0:
            return self
        if self.high <= 0:
            return -self
        return Span(arb(0), (-self.low).max(self.high))

    def __neg__(self) -> Span:
        return Span(-self.high, -self.low)

    def __add__(self, other: Span) -> Span:
        return Span((self.low + other.low).lower(), (self.high + other.high).upper())

    def __mul__(self, other: Span) -> Span:
        products = [a * b for a in (self.low, self.high) for b in (other.low, other.high)]
        low, high = products[0].lower(), products[0].upper()
        for product in products[1:]:
            low, high = low.min(product.lower()), high.max(product.upper())
        return Span(low, high)

    def inverse(self) -> Span:
        """``1/x`` for an interval without 0."""
        return Span((1 / self.high).lower(), (1 / self.low).upper())

    def power(self, exponent: arb) -> Span:
        """``x**exponent`` for a positive interval."""
        ends = self.low**exponent, self.high**exponent
        return Span(ends[0].lower().min(ends[1].lower()), ends[0].upper().max(ends[1].upper()))

    def joined(self, other: Span) -> Span:
        """The hull of both."""
        return Span(self.low.min(other.low), self.high.max(other.high))


NOTHING = Span(arb(0), arb(0))


# Power series of functions that the ball library has not, without overflow and cancellation.


def tanh_series(s: arb_series) -> arb_series:
    """``tanh`` of a series, from one exponential that cannot overflow where the sign is known."""
    if s[0] < 0:
        return -tanh_series(-s)
    two = arb_series([arb(2)], s.prec)
    one = arb_series([arb(1)], s.prec)
    return two / (one + (-two * s).exp()) - one


def sech_square_series(s: arb_series) -> arb_series:
    """``1 - tanh^2`` of a series."""
    if s[0] < 0:
        return sech_square_series(-s)
    small = (arb_series([arb(-2)], s.prec) * s).exp()
    one = arb_series([arb(1)], s.prec)
    return arb_series([arb(4)], s.prec) * small / ((one + small) * (one + small))


def inside_sech_square(node: Apply) -> Node | None:
    """``u`` where the node is ``1 - tanh(u)**2``, as derivatives write it."""
    if node.operation != "-" or node.arguments[0] != ONE:
        return None
    square = node.arguments[1]
    if not isinstance(square, Apply) or square.operation != "**" or square.arguments[1] != Number(Fraction(2)):
        return None
    inner = square.arguments[0]
    return inner.arguments[0] if isinstance(inner, Apply) and inner.operation == "tanh" else None


LENGTH = 3
_MOST_OPEN = 6
_NAN = arb("nan")
_METHODS = ("exp", "log", "sin", "cos", "tan", "atan", "sqrt")


def jet(node: Node, box: arb) -> tuple[arb, arb, arb]:
    """Enclosures of ``f``, ``f'`` and ``f''/2`` over a ball; nan where nothing is known.

    At a kink inside the ball ``f'`` holds the slopes of both sides and ``f''`` is nan; at a possible jump only ``f`` is
    enclosed.
    """
    found = _Walk(box, 3).value(node)
    if found[1].is_finite() and not found[0].is_nan():
        return found[0], found[1], found[2]
    found = _Walk(box, 2).value(node)  # one unknown coefficient may spoil the others
    if found[0].is_finite():
        return found[0], found[1], _NAN
    point = {"sigma": box}
    return enclosure(node, point) if has_value(node, point) else _NAN, _NAN, _NAN


def values_by_branch(node: Node, box: arb) -> list[arb] | None:
    """Enclosures of the values over a ball, one for each way of choosing the branches that are open there.

    Together they hold every value, and lose less than one enclosure of all of them.  None for more than six branches.
    """
    waiting: list[dict[Node, int]] = [{}]
    found: list[arb] = []
    while waiting:
        chosen = waiting.pop()
        walk = _Walk(box, 1, chosen)
        value = walk.value(node)[0]
        if walk.open is None:
            found.append(value)
        elif len(chosen) >= _MOST_OPEN:
            return None
        else:
            waiting += [{**chosen, walk.open: side} for side in (1, 0, -1)]
    return found


def over_sigma(node: Node, side: int) -> Node:
    """A tree for ``f(sigma)/sigma`` on one side of 0, in which ``sigma`` is cancelled where that can be seen."""
    if _divisible(node):
        return _quotient(node)
    if isinstance(node, Apply):
        name, parts = node.operation, node.arguments
        if name in ("+", "-", "neg"):
            return apply(name, *(over_sigma(part, side) for part in parts))
        if name in ("min", "max"):
            turned = name if side > 0 else {"min": "max", "max": "min"}[name]
            return apply(turned, *(over_sigma(part, side) for part in parts))
        if name == "where":
            return apply("where", parts[0], *(over_sigma(part, side) for part in parts[1:]))
        if name == "*" and isinstance(parts[0], Number):
            return apply("*", parts[0], over_sigma(parts[1], side))
        if name in ("*", "/") and isinstance(parts[1], Number):
            return apply(name, over_sigma(parts[0], side), parts[1])
    return Apply("/", (node, Variable("sigma")))


def _divisible(node: Node) -> bool:
    if isinstance(node, Number):
        return node.value == 0
    if not isinstance(node, Apply):
        return True
    if node.operation in ("+", "-", "neg"):
        return all(_divisible(part) for part in node.arguments)
    if node.operation == "*":
        return any(_divisible(part) for part in node.arguments)
    if node.operation == "**":
        exponent = node.arguments[1]
        assert isinstance(exponent, Number), "the parser and the derivative make only constant exponents"
        return exponent.value.denominator == 1 and exponent.value >= 1 and _divisible(node.arguments[0])
    return node.operation == "/" and _divisible(node.arguments[0])


def _quotient(node: Node) -> Node:
    if isinstance(node, Number):
        return node
    if not isinstance(node, Apply):
        return Number(Fraction(1))
    parts = node.arguments
    if node.operation in ("+", "-", "neg"):
        return apply(node.operation, *(_quotient(part) for part in parts))
    if node.operation == "*":
        if _divisible(parts[0]):
            return apply("*", _quotient(parts[0]), parts[1])
        return apply("*", parts[0], _quotient(parts[1]))
    if node.operation == "**":
        exponent = parts[1]
        assert isinstance(exponent, Number), "the parser and the derivative make only constant exponents"
        return apply("*", _quotient(parts[0]), apply("**", parts[0], Number(exponent.value - 1)))
    return apply("/", _quotient(parts[0]), parts[1])


class _Walk:
    """One evaluation; shared parts are evaluated once.

    ``chosen`` gives the sign taken by expressions whose sign is open; the first one met that is not in it is ``open``.
    """

    def __init__(self, box: arb, length: int, chosen: Mapping[Node, int] | None = None) -> None:
        self.chosen = chosen
        self.open: Node | None = None
        self.box, self.length, self.known = box, length, dict[int, arb_series]()
        self.variable = _series(length, box, arb(1))

    def value(self, node: Node) -> arb_series:
        """The series of a tree."""
        if isinstance(node, Number):
            return _constant(ball(node.value))
        if not isinstance(node, Apply):
            return self.variable
        if id(node) not in self.known:
            try:
                self.known[id(node)] = self._applied(node)
            except (ValueError, ZeroDivisionError):  # how series refuse to divide by one that may start at 0
                self.known[id(node)] = self._unknown()
        return self.known[id(node)]

    def _applied(self, node: Apply) -> arb_series:
        name, parts = node.operation, node.arguments
        if name == "where":
            return self._where(node)
        inner = inside_sech_square(node)
        if inner is not None:
            return sech_square_series(self.value(inner))
        u = self.value(parts[0]) if parts else _constant(arb.pi())
        if name == "pi":
            return u
        if name == "**":
            exponent = parts[1]
            assert isinstance(exponent, Number), "the parser and the derivative make only constant exponents"
            return self._unknown() if u[0].is_nan() else _power(u, exponent.value)
        if name in ("abs", "sign"):
            return self._side(name, parts[0], u)
        if name in ("neg", "tanh") or name in _METHODS:
            return _unary(name, u)
        v = self.value(parts[1])
        match name:
            case "+":
                return u + v
            case "-":
                return u - v
            case "*":
                return self._unknown() if _nowhere(u, v) else u * v
            case "/":
                return self._unknown() if _nowhere(u, v) else u / v
            case _:
                return self._extreme(name, Apply("<", parts), u, v)

    def _extreme(self, name: str, key: Apply, u: arb_series, v: arb_series) -> arb_series:
        if _nowhere(u, v):
            return self._unknown()
        d = u[0] - v[0]
        if d >= 0 or d <= 0 or self.chosen is not None:
            larger = d >= 0 if d >= 0 or d <= 0 else self._choice(key) < 0
            return u if larger == (name == "max") else v
        value = u[0].max(v[0]) if name == "max" else u[0].min(v[0])
        return _series(self.length, value, u[1].union(v[1]), _NAN)

    def _unknown(self) -> arb_series:
        """Of what may have no value."""
        return _series(self.length, _NAN, _NAN, _NAN)

    def _side(self, name: str, inner: Node, u: arb_series) -> arb_series:
        if u[0].is_nan():
            return self._unknown()
        sign = 1 if u[0] >= 0 else -1 if u[0] <= 0 else 0
        if sign == 0 and self.chosen is not None:
            sign = self._choice(inner)
            if name == "sign":
                return _constant(arb(sign))
        if name == "abs":
            if sign:
                return u if sign > 0 else -u
            return _series(self.length, abs(u[0]).nonnegative_part(), u[1].union(-u[1]), _NAN)
        if u[0] > 0 or u[0] < 0:
            return _constant(arb(sign))
        return _series(self.length, arb(0, 1), _NAN, _NAN)

    def _where(self, node: Apply) -> arb_series:
        condition, first, second = node.arguments
        if not has_value(condition, {"sigma": self.box}):
            return self._unknown()
        decided = truth(condition, {"sigma": self.box})
        if decided is None and self.chosen is not None:
            decided = self._choice(condition) > 0
        if decided is not None:
            return self.value(first if decided else second)
        u, v = self.value(first), self.value(second)
        return _series(self.length, u[0].union(v[0]), _NAN, _NAN)

    def _choice(self, key: Node) -> int:
        """The side taken of something open: for a comparison 1 is true, for an expression it is its sign."""
        assert self.chosen is not None, "only asked for where choices are made"
        if key not in self.chosen:
            self.open = self.open or key
            return 1
        return self.chosen[key]


def value_at(node: Node, point: Fraction) -> arb:
    """An enclosure of the value at an exact point."""
    return jet(node, ball(point))[0]


def _nowhere(u: arb_series, v: arb_series) -> bool:
    """Whether one may have no value: flint would make 0 of its product with 0, and 1 of its power 0."""
    return bool(u[0].is_nan() or v[0].is_nan())


def _series(length: int, *coefficients: arb) -> arb_series:
    return arb_series(list(coefficients[:length]), length)


def _constant(value: arb) -> arb_series:
    return arb_series([value], LENGTH)


def _unary(name: str, u: arb_series) -> arb_series:
    if name == "neg":
        return -u
    if name == "tanh":
        return tanh_series(u)
    found: arb_series = getattr(u, name)()
    return found


def _power(u: arb_series, exponent: Fraction) -> arb_series:
    if exponent < 0:
        return _constant(arb(1)) / _power(u, -exponent)
    if exponent.denominator != 1:
        return (u.log() * _constant(ball(exponent))).exp()
    result = _constant(arb(1))
    for bit in bin(exponent.numerator)[2:]:
        result = result * result
        if bit == "1":
            result = result * u
    return result
