"""Where the branches of an expression change, when every condition is linear in one variable."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from lure.expressions.tree import COMPARISONS, ZERO, Apply, Node, Number, Variable


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
