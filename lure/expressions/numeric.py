"""The numpy back-end: a tree becomes nested closures over numpy's own functions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

import numpy as np

from lure.expressions.tree import Apply, Node, Number

# Scalars, arrays and, inside conditions, arrays of bool: numpy's broadcasting is what gives them one shape.
Values: TypeAlias = Any
Closure: TypeAlias = Callable[[Mapping[str, Values]], Values]

_FUNCTIONS: dict[str, Callable[..., Values]] = {
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
    "/": np.divide,
    "**": np.power,
    "neg": np.negative,
    "<": np.less,
    "<=": np.less_equal,
    ">": np.greater,
    ">=": np.greater_equal,
    "==": np.equal,
    "!=": np.not_equal,
    "and": np.logical_and,
    "or": np.logical_or,
    "not": np.logical_not,
    "where": np.where,
    "min": np.minimum,
    "max": np.maximum,
    "abs": np.abs,
    "sign": np.sign,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "tanh": np.tanh,
    "atan": np.arctan,
    "exp": np.exp,
    "log": np.log,
    "sqrt": np.sqrt,
}


def closure(node: Node) -> Closure:
    """A function of the variables' arrays; both branches of a condition are evaluated, the untaken one is discarded."""
    if isinstance(node, Number):
        constant = np.float64(float(node.value))
        return lambda values: constant
    if not isinstance(node, Apply):
        name = node.name
        return lambda values: values[name]
    if node.operation == "pi":
        return lambda values: np.float64(np.pi)
    return _applied(_FUNCTIONS[node.operation], [closure(part) for part in node.arguments])


def _applied(function: Callable[..., Values], parts: list[Closure]) -> Closure:
    if len(parts) == 1:
        (only,) = parts
        return lambda values: function(only(values))
    if len(parts) == 2:
        first, second = parts
        return lambda values: function(first(values), second(values))
    return lambda values: function(*(part(values) for part in parts))
