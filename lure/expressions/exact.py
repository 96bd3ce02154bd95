"""The rational back-end: exact values at exact points, for expressions without sin, exp, sqrt, pi and the like."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from fractions import Fraction

from lure.errors import InputError
from lure.expressions.tree import COMPARISONS, Apply, Node, Number, Variable

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
