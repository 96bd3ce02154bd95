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

_FUNCTIONS: dict[str, Callable[..., Values]] = {  # numpy's own, looked up when they are called
    "+": lambda *x: np.add(*x),
    "-": lambda *x: np.subtract(*x),
    "*": lambda *x: np.multiply(*x),
    "/": lambda *x: np.divide(*x),
    "**": lambda *x: np.power(*x),
    "neg": lambda *x: np.negative(*x),
    "<": lambda *x: np.less(*x),
    "<=": lambda *x: np.less_equal(*x),
    ">": lambda *x: np.greater(*x),
    ">=": lambda *x: np.greater_equal(*x),
    "==": lambda *x: np.equal(*x),
    "!=": lambda *x: np.not_equal(*x),
    "and": lambda *x: np.logical_and(*x),
    "or": lambda *x: np.logical_or(*x),
    "not": lambda *x: np.logical_not(*x),
    "where": lambda *x: np.where(*x),
    "min": lambda *x: np.minimum(*x),
    "max": lambda *x: np.maximum(*x),
    "abs": lambda *x: np.abs(*x),
    "sign": lambda *x: np.sign(*x),
    "sin": lambda *x: np.sin(*x),
    "cos": lambda *x: np.cos(*x),
    "tan": lambda *x: np.tan(*x),
    "tanh": lambda *x: np.tanh(*x),
    "atan": lambda *x: np.arctan(*x),
    "exp": lambda *x: np.exp(*x),
    "log": lambda *x: np.log(*x),
    "sqrt": lambda *x: np.sqrt(*x),
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


def _applied(function: Callable[..., Values], parts: list[Closure]) -> Closure:
    if len(parts) == 1:
        (only,) = parts
        return lambda values: function(only(values))
    if len(parts) == 2:
        first, second = parts
        return lambda values: function(first(values), second(values))
    return lambda values: function(*(part(values) for part in parts))
