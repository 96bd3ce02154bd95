"""Formulas that are piecewise linear without looking it: from the tree to the exact graph."""

from __future__ import annotations

import operator
from bisect import bisect_left
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import TypeAlias

from lure.errors import InputError
from lure.expressions import Expression
from lure.expressions.tree import COMPARISONS, CONDITIONS, Apply, Node, Number
from lure.laws.graph import Graph

MAX_PIECES = 500
_SIGMA: dict[str, Callable[[Fraction, int], bool]] = dict(
    zip(COMPARISONS, (operator.lt, operator.le, operator.gt, operator.ge, operator.eq, operator.ne), strict=True)
)

Line: TypeAlias = tuple[Fraction, Fraction]
"""``(c0, c1)`` for ``c0 + c1 sigma``; a truth value is ``(1, 0)`` or ``(0, 0)``."""


class _NotPiecewiseLinear(Exception):
    """Some operation leaves the piecewise linear functions, or makes too many pieces."""


@dataclass(frozen=True, slots=True)
class _Pieces:
    """One line on each open interval between the cuts; nothing is said about the cuts themselves."""

    cuts: tuple[Fraction, ...]
    lines: tuple[Line, ...]

    def refined(self, cuts: Iterable[Fraction]) -> _Pieces:
        """The same function with more cuts."""
        merged = tuple(sorted({*self.cuts, *cuts}))
        if len(merged) >= MAX_PIECES:
            raise _NotPiecewiseLinear
        return _Pieces(merged, tuple(self.lines[bisect_left(self.cuts, x)] for x in _inside(merged)))


def piecewise_linear_graph(expression: Expression, variable: str) -> Graph | None:
    """The graph of an expression in one variable that is continuous, piecewise linear and 0 at 0; None for others.

    Parameters
    ----------
    expression : Expression
        The formula.
    variable : str
        Its variable.

    Notes
    -----
    Lines are carried through the tree exactly, cut wherever a comparison, ``min``, ``max`` or ``abs`` changes side.
    The value at each cut is then computed exactly and compared with the lines that meet there, so that neither a jump
    nor a stray point passes.
    """
    try:
        found = _pieces(expression.tree)
        values = [expression.exact(**{variable: cut}) for cut in (*found.cuts, Fraction(0))]
    except (_NotPiecewiseLinear, InputError):
        return None
    for cut, value, sides in zip(found.cuts, values[:-1], pairwise(found.lines), strict=True):
        if any(c0 + c1 * cut != value for c0, c1 in sides):
            return None
    if values.pop() != 0:
        return None
    try:
        return Graph.through(list(zip(found.cuts, values, strict=True)), found.lines[0][1], found.lines[-1][1])
    except InputError:
        return None  # a slope outside the range of doubles


def _inside(cuts: tuple[Fraction, ...]) -> list[Fraction]:
    """A point of each open interval between the cuts."""
    if not cuts:
        return [Fraction(0)]
    return [cuts[0] - 1, *((a + b) / 2 for a, b in pairwise(cuts)), cuts[-1] + 1]


def _pieces(node: Node) -> _Pieces:
    if isinstance(node, Number):
        return _Pieces((), ((node.value, Fraction(0)),))
    if not isinstance(node, Apply):
        return _Pieces((), ((Fraction(0), Fraction(1)),))
    parts = [_pieces(part) for part in node.arguments]
    name = node.operation
    if name in ("min", "max", "abs", "sign") or name in COMPARISONS:
        if len(parts) == 1:
            parts.append(_Pieces((), ((Fraction(0), Fraction(0)),)))
        parts = _cut_where_they_cross(parts[0], parts[1])
    rule = _chosen if name in ("min", "max", "abs", "sign", *CONDITIONS, "where") else _ARITHMETIC.get(name)
    if rule is None:
        raise _NotPiecewiseLinear
    cuts = {cut for part in parts for cut in part.cuts}
    parts = [part.refined(cuts) for part in parts]
    points = _inside(parts[0].cuts)
    rows = zip(points, *(part.lines for part in parts), strict=True)
    if rule is _chosen:
        return _Pieces(parts[0].cuts, tuple(_chosen(name, x, *lines) for x, *lines in rows))
    return _Pieces(parts[0].cuts, tuple(_ARITHMETIC[name](*lines) for _, *lines in rows))


def _cut_where_they_cross(first: _Pieces, second: _Pieces) -> list[_Pieces]:
    first, second = first.refined(second.cuts), second.refined(first.cuts)
    crossings = [
        (a0 - b0) / (b1 - a1) for (a0, a1), (b0, b1) in zip(first.lines, second.lines, strict=True) if a1 != b1
    ]
    return [first.refined(crossings), second.refined(crossings)]


def _chosen(name: str, x: Fraction, u: Line, v: Line = (Fraction(0), Fraction(0)), w: Line | None = None) -> Line:
    """The line on an interval on which no comparison changes side; ``x`` lies in it."""
    if name == "where":
        assert w is not None, "the parser gives where three arguments"
        return v if u[0] else w
    if name in ("and", "or", "not"):
        truth = not u[0] if name == "not" else (u[0] and v[0]) if name == "and" else (u[0] or v[0])
        return Fraction(bool(truth)), Fraction(0)
    difference = u[0] - v[0] + (u[1] - v[1]) * x
    if name in COMPARISONS:
        return Fraction(_SIGMA[name](difference, 0)), Fraction(0)
    if name == "sign":
        return Fraction((difference > 0) - (difference < 0)), Fraction(0)
    if name == "abs":
        return u if difference >= 0 else (-u[0], -u[1])
    return u if (difference >= 0) == (name == "max") else v


def _product(u: Line, v: Line) -> Line:
    if u[1] * v[1] != 0:
        raise _NotPiecewiseLinear
    return u[0] * v[0], u[0] * v[1] + u[1] * v[0]


def _quotient(u: Line, v: Line) -> Line:
    if v[1] != 0 or v[0] == 0:
        raise _NotPiecewiseLinear
    return u[0] / v[0], u[1] / v[0]


_ARITHMETIC: Mapping[str, Callable[..., Line]] = {
    "+": lambda u, v: (u[0] + v[0], u[1] + v[1]),
    "-": lambda u, v: (u[0] - v[0], u[1] - v[1]),
    "neg": lambda u: (-u[0], -u[1]),
    "*": _product,
    "/": _quotient,
}
