"""Where the branches of an expression change, when every condition is linear in one variable."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from lure.expressions.tree import COMPARISONS, ONE, ZERO, Apply, Node, Number, Variable, apply, names

# The derivative of a tree, branch by branch, valid almost everywhere.

_HALF = Number(Fraction(1, 2))


def derivative(node: Node, variable: str) -> Node:
    """Tree of the partial derivative.

    ``|u|' = sign(u) u'``, ``min(u, v)' = u' where u < v else v'``, ``where(c, u, v)' = where(c, u', v')`` and
    ``sign(u)' = 0``: kinks and jumps are passed over.
    """
    if isinstance(node, Variable):
        return ONE if node.name == variable else ZERO
    if not isinstance(node, Apply) or variable not in names(node):
        return ZERO
    if node.operation == "where":
        condition, first, second = node.arguments
        return apply("where", condition, derivative(first, variable), derivative(second, variable))
    u, du = node.arguments[0], derivative(node.arguments[0], variable)
    if node.operation == "neg":
        return apply("neg", du)
    if node.operation == "**":
        return _times(_power_rule(u, node.arguments[1]), du)
    if len(node.arguments) == 1:
        return _times(_outer(node), du)
    v, dv = node.arguments[1], derivative(node.arguments[1], variable)
    match node.operation:
        case "+" | "-":
            return apply(node.operation, du, dv)
        case "*":
            return apply("+", _times(du, v), _times(u, dv))
        case "/":
            rest = _times(apply("/", u, apply("**", v, Number(Fraction(2)))), dv)
            return apply("-", ZERO if du == ZERO else apply("/", du, v), rest)
        case "min":
            return apply("where", apply("<", u, v), du, dv)
        case _:
            assert node.operation == "max", f"{node.operation} has no derivative rule"
            return apply("where", apply(">", u, v), du, dv)


def _times(factor: Node, inner: Node) -> Node:
    """A product, 0 if either factor is: outside the domain of the other the expression itself is undefined."""
    return ZERO if ZERO in (factor, inner) else apply("*", factor, inner)


def _power_rule(base: Node, exponent: Node) -> Node:
    assert isinstance(exponent, Number), "the parser and this module make only constant exponents"
    lower = exponent.value - 1
    # Below -32 the power would not be readable again; u**p / u is the same.
    rest = apply("**", base, Number(lower)) if lower >= -32 else apply("/", apply("**", base, exponent), base)
    return _times(exponent, rest)


def _outer(node: Apply) -> Node:
    """The derivative of a function of one argument at that argument."""
    (u,) = node.arguments
    square = Number(Fraction(2))
    match node.operation:
        case "abs":
            return apply("sign", u)
        case "sin":
            return apply("cos", u)
        case "cos":
            return apply("neg", apply("sin", u))
        case "exp":
            return node
        case "log":
            return apply("/", ONE, u)
        case "sqrt":
            return apply("/", _HALF, node)
        case "tan":
            return apply("+", ONE, apply("**", node, square))
        case "tanh":
            return apply("-", ONE, apply("**", node, square))
        case "atan":
            return apply("/", ONE, apply("+", ONE, apply("**", u, square)))
        case _:
            assert node.operation == "sign", f"{node.operation} has no derivative rule"
            return ZERO


def switches(node: Node, variable: str) -> frozenset[Fraction] | None:
    """Where a comparison, ``abs``, ``sign``, ``min`` or ``max`` changes side in the variable; None if unknown."""
    points: set[Fraction] = set()
    for left, right in _compared(node):
        line, other = _affine(left, variable), _affine(right, variable)
        if line is None or other is None:
            return None
        height, slope = line[0] - other[0], line[1] - other[1]
        if slope != 0:
            points.add(-height / slope)
    return frozenset(points)


def _compared(node: Node) -> Iterator[tuple[Node, Node]]:
    if not isinstance(node, Apply):
        return
    if node.operation in (*COMPARISONS, "min", "max"):
        yield node.arguments[0], node.arguments[1]
    elif node.operation in ("abs", "sign"):
        yield node.arguments[0], ZERO
    for part in node.arguments:
        yield from _compared(part)


def _affine(node: Node, variable: str) -> tuple[Fraction, Fraction] | None:
    """``(c0, c1)`` if the node is ``c0 + c1*variable`` with rational coefficients."""
    if isinstance(node, Number):
        return node.value, Fraction(0)
    if isinstance(node, Variable):
        return (Fraction(0), Fraction(1)) if node.name == variable else None
    if node.operation not in ("+", "-", "*", "/", "neg"):
        return None
    parts = [_affine(part, variable) for part in node.arguments]
    known = [part for part in parts if part is not None]
    if len(known) < len(parts):
        return None
    if node.operation == "neg":
        return -known[0][0], -known[0][1]
    (a0, a1), (b0, b1) = known
    match node.operation:
        case "+":
            return a0 + b0, a1 + b1
        case "-":
            return a0 - b0, a1 - b1
        case "/":
            return (a0 / b0, a1 / b0) if b1 == 0 and b0 != 0 else None
        case _:
            return (a0 * b0, a0 * b1 + a1 * b0) if a1 * b1 == 0 else None
