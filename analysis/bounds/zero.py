"""Values at rational points as sums of different constants, so that ``tanh(-1) + tanh(1)`` is seen to be 0."""

from __future__ import annotations

from collections.abc import Hashable
from fractions import Fraction

from lure.errors import InputError
from lure.expressions import exact
from lure.expressions.balls import ball, enclosure
from lure.expressions.tree import Apply, Node, Number

Combination = dict[Hashable, Fraction]
"""Rational multiples of constants such as ``("tanh", 1)``; the rational part is that of ``None``."""
_ODD = ("sin", "tan", "tanh", "atan")
_AT_ZERO = {**dict.fromkeys((*_ODD, "sqrt"), Fraction(0)), "cos": Fraction(1), "exp": Fraction(1)}


def difference_vanishes(first: Node, second: Node, x: Fraction) -> bool:
    """Whether two trees visibly have the same value at a point; False means that it was not seen.

    Where a tree has no value that ball arithmetic encloses, as ``0*log(0)``, nothing is seen.
    """
    if not all(enclosure(tree, {"sigma": ball(x)}).is_finite() for tree in (first, second)):
        return False
    found = _sum(_combination(first, x), _combination(second, x), Fraction(-1))
    return not any(found.values())


def _combination(node: Node, x: Fraction) -> Combination:
    if isinstance(node, Number):
        return {None: node.value}
    if not isinstance(node, Apply):
        return {None: x}
    name = node.operation
    try:
        return {None: exact.value(node, {"sigma": x})}
    except InputError:
        pass
    parts = [_combination(part, x) for part in node.arguments] if name != "where" else []
    if name in ("+", "-"):
        return _sum(parts[0], parts[1], Fraction(1 if name == "+" else -1))
    if name == "neg":
        return _sum({}, parts[0], Fraction(-1))
    if name == "*":
        for factor, other in ((parts[0], parts[1]), (parts[1], parts[0])):
            if (value := _rational(factor)) is not None:
                return _sum({}, other, value)
    if name == "/" and (value := _rational(parts[1])):
        return _sum({}, parts[0], 1 / value)
    return _constant(name, parts, node)


def _constant(name: str, parts: list[Combination], node: Apply) -> Combination:
    """A value that is no sum: one constant of its own."""
    value = _rational(parts[0]) if len(parts) == 1 else None
    if value is not None:
        if value == 0 and name in _AT_ZERO:
            return {None: _AT_ZERO[name]}
        if name in _ODD and value < 0:
            return {(name, -value): Fraction(-1)}
        return {(name, abs(value) if name == "cos" else value): Fraction(1)}
    if name in ("where", "min", "max", "abs", "sign"):
        return {node: Fraction(1)}
    return {(name, *(frozenset(part.items()) for part in parts)): Fraction(1)}


def _rational(combination: Combination) -> Fraction | None:
    rest = {key: value for key, value in combination.items() if value}
    return rest.get(None, Fraction(0)) if set(rest) <= {None} else None


def _sum(first: Combination, second: Combination, factor: Fraction) -> Combination:
    total = dict(first)
    for key, value in second.items():
        total[key] = total.get(key, Fraction(0)) + factor * value
    return {key: value for key, value in total.items() if value}
