"""The rigorous back-end: Arb balls, where a condition that cannot be decided takes the hull of both branches.

Traps of python-flint kept out here: ``arb(0, 1)**2`` is nan (any ball with midpoint 0), ``x > 1`` and ``x <= 1`` are
both False when unknown, and ``arb(0.1)`` is the binary double.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from fractions import Fraction
from operator import methodcaller
from typing import TYPE_CHECKING

from lure.errors import InputError
from lure.expressions.tree import COMPARISONS, Apply, Node, Number, Variable

if TYPE_CHECKING:
    from flint import arb

# The rational back-end: exact values at exact points, for expressions without sin, exp, sqrt, pi and the like.

MAX_BITS = 1 << 16
_COMPARE: dict[str, Callable[[Fraction, Fraction], bool]] = dict(
    zip(COMPARISONS, (operator.lt, operator.le, operator.gt, operator.ge, operator.eq, operator.ne), strict=True)
)
_RATIONAL: dict[str, Callable[..., Fraction]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "neg": operator.neg,
    "abs": abs,
    "min": min,
    "max": max,
    "sign": lambda value: Fraction((value > 0) - (value < 0)),
}


def value(node: Node, point: Mapping[str, Fraction]) -> Fraction:
    """Exact value; only the branch a condition selects is evaluated.

    Raises
    ------
    InputError
        A function without rational values is met, the expression is undefined there, or a number passes 65536 bits.
    """
    if isinstance(node, Number):
        return node.value
    if isinstance(node, Variable):
        return point[node.name]
    if node.operation == "where":
        condition, first, second = node.arguments
        return value(first if holds(condition, point) else second, point)
    if node.operation == "**":
        return _power(value(node.arguments[0], point), node.arguments[1])
    if node.operation == "/":
        top, bottom = (value(part, point) for part in node.arguments)
        if bottom == 0:
            raise InputError("the expression divides by zero at this point.")
        return _bounded(top / bottom)
    if node.operation not in _RATIONAL:
        raise InputError(f"{node.operation} has no exact rational value; evaluate the expression as a ball instead.")
    return _bounded(_RATIONAL[node.operation](*(value(part, point) for part in node.arguments)))


def holds(condition: Node, point: Mapping[str, Fraction]) -> bool:
    """Truth of a condition; ``and`` and ``or`` stop at the first part that decides."""
    assert isinstance(condition, Apply), "the parser lets only comparisons and their combinations be conditions"
    if condition.operation == "and":
        return all(holds(part, point) for part in condition.arguments)
    if condition.operation == "or":
        return any(holds(part, point) for part in condition.arguments)
    if condition.operation == "not":
        return not holds(condition.arguments[0], point)
    left, right = (value(part, point) for part in condition.arguments)
    return _COMPARE[condition.operation](left, right)


def _power(base: Fraction, exponent: Node) -> Fraction:
    assert isinstance(exponent, Number), "the parser and the derivative make only constant exponents"
    if exponent.value.denominator != 1:
        raise InputError(
            f"the power {exponent.value} has no exact rational value; evaluate the expression as a ball instead."
        )
    whole = exponent.value.numerator
    if base == 0 and whole < 0:
        raise InputError("the expression divides by zero at this point.")
    if _bits(base) * abs(whole) > MAX_BITS:
        raise InputError(f"an exact value needs more than {MAX_BITS} bits; evaluate the expression as a ball instead.")
    return Fraction(base**whole)


def _bounded(result: Fraction) -> Fraction:
    if _bits(result) > MAX_BITS:
        raise InputError(f"an exact value needs more than {MAX_BITS} bits; evaluate the expression as a ball instead.")
    return result


def _bits(number: Fraction) -> int:
    return max(number.numerator.bit_length(), number.denominator.bit_length())


def enclosure(node: Node, point: Mapping[str, arb]) -> arb:
    """A ball that contains the value at every point of the given balls where there is one; nan if nothing is known."""
    import flint

    if isinstance(node, Variable):
        return point[node.name]
    if isinstance(node, Number):
        return ball(node.value)
    if node.operation == "where":
        return _branches(node, point)
    if node.operation == "**":
        exponent = node.arguments[1]
        assert isinstance(exponent, Number), "the parser and the derivative make only constant exponents"
        return _balls_power(enclosure(node.arguments[0], point), exponent.value)
    if node.operation == "pi":
        return flint.arb.pi()
    return _FUNCTIONS[node.operation](*(enclosure(part, point) for part in node.arguments))


def truth(condition: Node, point: Mapping[str, arb]) -> bool | None:
    """Truth at every point of the balls, or None where it is not certain (nan decides nothing)."""
    assert isinstance(condition, Apply), "the parser lets only comparisons and their combinations be conditions"
    if condition.operation in ("and", "or", "not"):
        parts = [truth(part, point) for part in condition.arguments]
        if condition.operation == "not":
            return None if parts[0] is None else not parts[0]
        deciding = condition.operation == "or"
        if deciding in parts:
            return deciding
        return None if None in parts else not deciding
    left, right = (enclosure(part, point) for part in condition.arguments)
    return _compared(condition.operation, left, right)


def ball(value: Fraction) -> arb:
    """The rational number, rounded outwards at the working precision."""
    import flint

    return flint.arb(flint.fmpq(value.numerator, value.denominator))


def _compared(operation: str, left: arb, right: arb) -> bool | None:
    certain = {
        "<": (left < right, left >= right),
        "<=": (left <= right, left > right),
        ">": (left > right, left <= right),
        ">=": (left >= right, left < right),
        "==": (left == right, left != right),
        "!=": (left != right, left == right),
    }
    yes, no = certain[operation]
    return True if yes else False if no else None


def _branches(node: Apply, point: Mapping[str, arb]) -> arb:
    condition, first, second = node.arguments
    decided = truth(condition, point)
    if decided is not None:
        return enclosure(first if decided else second, point)
    return enclosure(first, point).union(enclosure(second, point))


def _balls_power(base: arb, exponent: Fraction) -> arb:
    """``base**exponent`` on the hull of the ball, by monotonicity."""
    import flint

    if exponent < 0:
        return 1 / _balls_power(base, -exponent)
    if exponent.denominator == 1:
        return _whole_power(base, exponent.numerator)
    if base > 0:
        return base ** ball(exponent)
    if base >= 0:  # starts at zero, where Arb's power gives nan: 0 <= x**p <= upper**p
        return _from_zero(base, lambda top: top ** ball(exponent))
    return flint.arb("nan")


def _whole_power(base: arb, exponent: int) -> arb:
    if exponent % 2 == 1:
        return _product(base.lower(), exponent).union(_product(base.upper(), exponent))
    return _nonnegative(_product(base.abs_lower(), exponent).union(_product(base.abs_upper(), exponent)))


def _product(base: arb, exponent: int) -> arb:
    import flint

    result = flint.arb(1)
    for bit in bin(exponent)[2:]:
        result = result * result
        if bit == "1":
            result = result * base
    return result


def _root(x: arb) -> arb:
    return _from_zero(x, lambda top: top.sqrt()) if x >= 0 and not x > 0 else x.sqrt()


def _from_zero(x: arb, increasing: Callable[[arb], arb]) -> arb:
    """The range of an increasing function that vanishes at zero, on a ball whose lower end is zero."""
    top = x.upper()
    return x if top == 0 else _nonnegative(increasing(top).union(top * 0))


def _nonnegative(x: arb) -> arb:
    """The ball of a value known not to be negative: radii are rounded up, and a hull of 0 and 1 reaches below zero."""
    return x.nonnegative_part()


_FUNCTIONS: dict[str, Callable[..., arb]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "neg": operator.neg,
    "abs": lambda x: _nonnegative(abs(x)),
    "min": lambda x, y: x.min(y),
    "max": lambda x, y: x.max(y),
    "sign": methodcaller("sgn"),
    "exp": lambda x: _nonnegative(x.exp()),
    "sqrt": _root,
    **{name: methodcaller(name) for name in ("sin", "cos", "tan", "tanh", "atan", "log")},
}
