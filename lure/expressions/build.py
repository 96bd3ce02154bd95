"""Operations on nodes: constants are folded exactly, and only what holds on the whole domain is simplified."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from lure.expressions.tree import CONDITIONS, ONE, ZERO, Apply, Node, Number, decimal, is_total

_EXACT: dict[str, Callable[[Fraction, Fraction], Fraction]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "min": min,
    "max": max,
}


def apply(operation: str, *arguments: Node) -> Node:
    """The node of an operation, simplified when the answer does not depend on the values of the variables.

    Constants are combined as exact fractions unless the result would be undefined (``1/0``) or need more digits than
    a literal may have; then the operation stays as it is.  ``0*u`` becomes 0 only for an operand defined everywhere.
    """
    if operation in CONDITIONS or operation == "pi":
        return Apply(operation, arguments)
    if operation == "where":
        return _where(*arguments)
    if operation == "**":
        return _power(*arguments)
    if len(arguments) == 1:
        return _unary(operation, arguments[0])
    return _binary(operation, *arguments)


def _unary(operation: str, u: Node) -> Node:
    if isinstance(u, Number):
        if operation == "neg":
            return Number(-u.value)
        if operation == "abs":
            return Number(abs(u.value))
        if operation == "sign":
            return Number(Fraction((u.value > 0) - (u.value < 0)))
    if operation == "neg" and isinstance(u, Apply) and u.operation == "neg":
        return u.arguments[0]
    return Apply(operation, (u,))


def _binary(operation: str, u: Node, v: Node) -> Node:
    if isinstance(u, Number) and isinstance(v, Number):
        return _folded(operation, u, v)
    if operation == "*":
        return _product(u, v)
    if v == ZERO and operation in ("+", "-"):
        return u
    if u == ZERO and operation in ("+", "-"):
        return v if operation == "+" else apply("neg", v)
    if v == ONE and operation == "/":
        return u
    return Apply(operation, (u, v))


def _folded(operation: str, u: Number, v: Number) -> Node:
    if operation == "/" and v == ZERO:
        return Apply(operation, (u, v))
    value = _EXACT[operation](u.value, v.value)
    return Number(value) if decimal(value) is not None else Apply(operation, (u, v))


def _product(u: Node, v: Node) -> Node:
    for factor, other in ((u, v), (v, u)):
        if factor == ZERO and is_total(other):
            return ZERO
        if factor == ONE:
            return other
        if factor == Number(Fraction(-1)):
            return apply("neg", other)
    return Apply("*", (u, v))


def _power(base: Node, exponent: Node) -> Node:
    if isinstance(exponent, Number):
        if exponent == ONE:
            return base
        if exponent == ZERO and is_total(base):
            return ONE
        whole = exponent.value.denominator == 1 and abs(exponent.value) <= 64
        if isinstance(base, Number) and whole and not (base == ZERO and exponent.value < 0):
            value = base.value**exponent.value.numerator
            if decimal(value) is not None:
                return Number(value)
    return Apply("**", (base, exponent))


def _where(condition: Node, u: Node, v: Node) -> Node:
    same = isinstance(u, Number) and u == v
    return u if same and is_total(condition) else Apply("where", (condition, u, v))
