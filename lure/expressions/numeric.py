"""The numpy back-end: a tree becomes nested closures over numpy's own functions."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from lure.arrays import np
from lure.expressions.tree import Apply, Node, Number

# Scalars, arrays and, inside conditions, arrays of bool: numpy's broadcasting is what gives them one shape.
Values: TypeAlias = Any
Closure: TypeAlias = Callable[[Mapping[str, Values]], Values]

_FUNCTIONS = {  # what numpy calls them
    "+": "add",
    "-": "subtract",
    "*": "multiply",
    "/": "divide",
    "**": "power",
    "neg": "negative",
    "<": "less",
    "<=": "less_equal",
    ">": "greater",
    ">=": "greater_equal",
    "==": "equal",
    "!=": "not_equal",
    "and": "logical_and",
    "or": "logical_or",
    "not": "logical_not",
    "where": "where",
    "min": "minimum",
    "max": "maximum",
    "abs": "abs",
    "sign": "sign",
    "sin": "sin",
    "cos": "cos",
    "tan": "tan",
    "tanh": "tanh",
    "atan": "arctan",
    "exp": "exp",
    "log": "log",
    "sqrt": "sqrt",
}


def closure(node: Node) -> Closure:
    """A function of the variables' arrays; both branches of a condition are evaluated, the untaken one is discarded."""
    if isinstance(node, Number):
        constant = float(node.value)
        return lambda values: constant
    if not isinstance(node, Apply):
        name = node.name
        return lambda values: values[name]
    if node.operation == "pi":
        return lambda values: math.pi
    return _applied(_FUNCTIONS[node.operation], [closure(part) for part in node.arguments])


def _applied(function: str, parts: list[Closure]) -> Closure:
    if len(parts) == 1:
        (only,) = parts
        return lambda values: getattr(np, function)(only(values))
    if len(parts) == 2:
        first, second = parts
        return lambda values: getattr(np, function)(first(values), second(values))
    return lambda values: getattr(np, function)(*(part(values) for part in parts))
