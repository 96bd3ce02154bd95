"""Oddness read off a formula: a proof for every ``sigma``, where the formula shows it."""

from __future__ import annotations

from lure.expressions import Expression
from lure.expressions.tree import Apply, Node, Number, Variable
from lure.nonlinearities.formula import piecewise_linear_graph

_ODD_FUNCTIONS = frozenset(("neg", "sin", "tan", "tanh", "atan", "sign"))
_EVEN_OF_ODD = frozenset(("abs", "cos"))
_EVEN, _ODD = 1, -1


def known_odd(expression: Expression, variable: str) -> bool | None:
    """Whether a formula is odd; None where its form does not tell.

    Parameters
    ----------
    expression : Expression
        The formula.
    variable : str
        Its variable.

    Notes
    -----
    A piecewise linear formula is decided from its exact graph.  For others the parities of the parts are combined: sums
    of odd parts are odd, a product of an odd and an even part is odd, an odd function of an odd part is odd.

    Examples
    --------
    >>> known_odd(Expression.parse("sigma/(1 + abs(sigma))", variables=("sigma",)), "sigma")
    True
    """
    graph = piecewise_linear_graph(expression, variable)
    if graph is not None:
        return graph.odd
    return True if _parity(expression.tree) == _ODD else None


def _parity(node: Node) -> int | None:
    """1 for even, -1 for odd, None for neither or not known."""
    if isinstance(node, Number):
        return _EVEN
    if isinstance(node, Variable):
        return _ODD
    return _of_operation(node)


def _of_operation(node: Apply) -> int | None:
    parts = [_parity(part) for part in node.arguments]
    name = node.operation
    if None in parts:
        return None
    if all(part == _EVEN for part in parts):
        return _EVEN
    if name in _ODD_FUNCTIONS:
        return _ODD
    if name in _EVEN_OF_ODD:
        return _EVEN
    if name in ("+", "-"):
        return parts[0] if parts[0] == parts[1] else None
    if name in ("*", "/"):
        return (parts[0] or 0) * (parts[1] or 0)
    exponent = node.arguments[1] if name == "**" else None
    if isinstance(exponent, Number) and exponent.value.denominator == 1:
        return _ODD if exponent.value.numerator % 2 else _EVEN
    return _chosen(parts) if name == "where" else None


def _chosen(parts: list[int | None]) -> int | None:
    """``where(condition, a, b)`` with an even condition and both branches of one parity."""
    condition, first, second = parts
    return first if condition == _EVEN and first == second else None
