"""What the values of a tree lie between, read off its form in exact numbers: ``1 + sin(5 sigma)`` in ``[0, 2]``."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

from lure.analysis.nonlinearity.extremes import Candidate, Cover, End
from lure.analysis.nonlinearity.result import Bound
from lure.expressions.tree import Node, Number, Variable

Hull = tuple[Bound, Bound]
_ANY: Hull = (-math.inf, math.inf)
_ZERO, _ONE = Fraction(0), Fraction(1)
_LONGEST = 4096  # [bits] of a number; longer ones bound nothing


def hull(node: Node, low: End, high: End) -> Hull:
    """Bounds of every value that a tree has for ``sigma`` between two ends; infinite where its form says nothing.

    Parameters
    ----------
    node : Node
        The tree.
    low, high : Fraction, or an infinity
        The ends.
    """
    if isinstance(node, Variable):
        return low, high
    if isinstance(node, Number):
        return _short((node.value, node.value))
    if node.operation in ("pi", "where"):
        return (Fraction(3), Fraction(4)) if node.operation == "pi" else _joined(node.arguments[1:], low, high)
    if node.operation == "**":
        exponent = node.arguments[1]
        assert isinstance(exponent, Number), "the parser and the derivative make only constant exponents"
        return _short(_power(hull(node.arguments[0], low, high), exponent.value))
    return _short(_applied(node.operation, [hull(part, low, high) for part in node.arguments]))


def tightened(found: list[Candidate], covers: list[Cover], within: Hull) -> tuple[list[Candidate], list[Cover]]:
    """Values and covers that were enclosed, without what rounding added beyond bounds that hold for every value.

    Parameters
    ----------
    found, covers : list
        What is known of the values.  An end that is infinite stays so: it says that not every place was looked at.
    within : pair of Fraction or infinity
        The bounds, of :func:`hull`.
    """
    low, high = within

    def inside(value: Fraction) -> Fraction:
        """The value, moved to the nearer bound from beyond it."""
        above = max(value, low) if isinstance(low, Fraction) else value
        return min(above, high) if isinstance(high, Fraction) else above

    def end(value: Bound) -> Bound:
        """The end of a cover, likewise."""
        return inside(value) if isinstance(value, Fraction) else value

    values = [
        replace(c, value=(inside(c.value[0]), inside(c.value[1]))) if isinstance(c.value, tuple) else c for c in found
    ]
    return values, [Cover(low=end(c.low), high=end(c.high)) for c in covers]


def _joined(nodes: tuple[Node, ...], low: End, high: End) -> Hull:
    lows, highs = zip(*(hull(node, low, high) for node in nodes), strict=True)
    return min(lows), max(highs)


def _short(found: Hull) -> Hull:
    """The same without numbers that are too long to go on with."""
    low, high = (isinstance(x, Fraction) and x.numerator.bit_length() + x.denominator.bit_length() for x in found)
    return -math.inf if low > _LONGEST else found[0], math.inf if high > _LONGEST else found[1]


def _applied(operation: str, parts: list[Hull]) -> Hull:
    (a, b), *rest = parts
    c, d = rest[0] if rest else (_ZERO, _ZERO)
    match operation:
        case "+":
            return _plus(a, c), _plus(b, d)
        case "-":
            return _plus(a, -d), _plus(b, -c)
        case "neg":
            return -b, -a
        case "*":
            return _product((a, b), (c, d))
        case "/":
            return _product((a, b), _inverse((c, d)))
        case "abs":
            return max(a, -b, _ZERO), max(-a, b)
        case "min":
            return min(a, c), min(b, d)
        case "max":
            return max(a, c), max(b, d)
        case "sin" | "cos":
            return -_ONE, _ONE
        case "sign" | "tanh" | "atan":  # odd and increasing, below 1 or below pi/2
            most = Fraction(2) if operation == "atan" else _ONE
            return -most if a < 0 else _ZERO, most if b > 0 else _ZERO
        case "exp":
            return _ONE if a >= 0 else _ZERO, _ONE if b <= 0 else math.inf
        case "sqrt":
            return _ZERO, max(b, _ONE)
        case _:
            return _ANY


def _power(base: Hull, exponent: Fraction) -> Hull:
    if exponent < 0:
        return _inverse(_power(base, -exponent))
    low, high = base
    if exponent.denominator != 1:
        return _ZERO, math.inf
    n = exponent.numerator
    if n % 2 == 0:
        low, high = _applied("abs", [base])
    return _raised(low, n, -math.inf), _raised(high, n, math.inf)


def _raised(value: Bound, n: int, outwards: float) -> Bound:
    """``value^n`` for odd ``n`` or ``value >= 0``; one too long is rounded outwards, to 0 or an infinity."""
    if isinstance(value, Fraction) and n * max(value.numerator.bit_length(), value.denominator.bit_length()) < _LONGEST:
        return value**n
    return outwards if (value > 0) == (outwards > 0) else _ZERO


def _plus(x: Bound, y: Bound) -> Bound:
    """The sum; of two lower bounds, or of two upper ones, so that no infinities of both signs meet."""
    return x if isinstance(x, float) else y if isinstance(y, float) else x + y


def _product(one: Hull, other: Hull) -> Hull:
    ends = [_times(x, y) for x in one for y in other]
    return min(ends), max(ends)


def _times(x: Bound, y: Bound) -> Bound:
    """The product, 0 of 0 and an infinity: the values themselves are finite."""
    if x == 0 or y == 0:
        return _ZERO
    if isinstance(x, Fraction) and isinstance(y, Fraction):
        return x * y
    return math.inf if (x > 0) == (y > 0) else -math.inf


def _inverse(of: Hull) -> Hull:
    """``1/x``, where ``x`` keeps its sign."""
    low, high = of
    if low < 0 < high:
        return _ANY
    ends = [_ZERO if isinstance(x, float) else 1 / x for x in of if x != 0]
    return (-math.inf if high == 0 else min(ends), math.inf if low == 0 else max(ends)) if ends else _ANY
