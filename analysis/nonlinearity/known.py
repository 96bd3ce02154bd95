"""Laws that are known exactly: cut into pieces, with their values at the cuts."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from itertools import pairwise
from typing import Any

from flint import fmpq_poly

from lure.analysis.nonlinearity.extremes import BITS, End, bounds_of
from lure.analysis.nonlinearity.pieces import Piece, at_point, branches, difference_vanishes, pieces
from lure.analysis.nonlinearity.rational import Ratio
from lure.analysis.numerics.polynomial import to_fmpq
from lure.analysis.numerics.precision import working_precision
from lure.errors import InputError
from lure.expressions import Expression
from lure.expressions.regularity import has_value
from lure.expressions.rigorous import ball, enclosure
from lure.expressions.tree import Apply, Node, Number, Variable, names
from lure.nonlinearities import Cubic, ExpressionNonlinearity, GraphNonlinearity, ShiftedNonlinearity, Tanh
from lure.nonlinearities.base import number_text
from lure.nonlinearities.piecewise_linear import Graph
from lure.nonlinearities.protocol import NormalCompliance
from lure.nonlinearities.reading import control_saturation

Value = Fraction | tuple[Fraction, Fraction]
SIGMA = Variable("sigma")
_NAMES = ("sigma", "x")
_ONE = fmpq_poly([1])


@dataclass(frozen=True, kw_only=True, slots=True)
class Known:
    """A law on a closed interval or all of R.

    Attributes
    ----------
    name : str
        The law in words.
    pieces : tuple of Piece
        Ascending and adjacent.
    value : callable
        The value at an exact point, or an interval that contains it.
    continuous : bool
        Whether the law is continuous for its form alone; else the cuts are looked at one by one.
    whole : bool
        Whether all its branches were chosen exactly, so that it is smooth between the cuts.
    branches : callable or None
        For a law with jumps: the tree, with its branches chosen, on an interval or at a point.
    """

    name: str
    pieces: tuple[Piece, ...]
    value: Callable[[Fraction], Value]
    continuous: bool
    whole: bool
    branches: Callable[[End, End], Node] | None = None


def known_nonlinearity(law: object, low: End, high: End) -> Known | None:
    """The law cut into pieces; None for one known by its values alone.

    Raises
    ------
    InputError
        A text is refused by the parser, or uses both ``sigma`` and ``x``.
    """
    law = control_saturation(law) or law
    if callable(law) and not getattr(type(law).__call__, "__module__", "").startswith("lure."):
        return None  # a class of the user's, whose values need not be those of the law that it is derived from
    if isinstance(law, GraphNonlinearity):
        return _of_graph(law.graph, f"{law}", low, high)
    if isinstance(law, ExpressionNonlinearity) and law.graph is not None:
        return _of_graph(law.graph, law.text, low, high)
    tree = tree_of(law)
    return None if tree is None else of_tree(_in_sigma(tree), _name(law), low, high)


def tree_of(law: object) -> Node | None:
    """The tree of a law in one variable; None for one that has none."""
    if isinstance(law, str):
        return parsed(law).tree
    if isinstance(law, Expression):
        if len(names(law.tree)) > 1:
            raise InputError(f"the law {law.source[:60]!r} has the variables {sorted(names(law.tree))}; a law has one")
        return law.tree
    if isinstance(law, ExpressionNonlinearity):
        return law.expression.tree
    if isinstance(law, Tanh):
        return _times(law.gain, Apply("tanh", (Apply("/", (SIGMA, Number(law.scale))),)))
    if isinstance(law, Cubic):
        cube = Apply("**", (SIGMA, Number(Fraction(3))))
        return Apply("+", (_times(law.linear, SIGMA), _times(law.cubic, cube)))
    if isinstance(law, NormalCompliance):
        power = Apply("**", (SIGMA, Number(law.exact_exponent)))
        zero = Number(Fraction(0))
        return Apply("where", (Apply(">", (SIGMA, zero)), _times(law.exact_stiffness, power), zero))
    if isinstance(law, ShiftedNonlinearity):
        inner = tree_of(law.law)
        return None if inner is None else Apply("-", (inner, _times(law.gain, SIGMA)))
    return None


def kinks(law: object) -> list[float]:
    """Where a law changes its branch, as far as that is known exactly."""
    known = known_nonlinearity(law, -math.inf, math.inf)
    return [] if known is None else [float(p.high) for p in known.pieces if isinstance(p.high, Fraction)]


def parsed(text: str) -> Expression:
    """A law as text in ``sigma``, or in ``x``.

    Raises
    ------
    InputError
        The parser refuses it, or it uses both names.
    """
    found = Expression.parse(text, variables=_NAMES, field="the law")
    if len(names(found.tree)) > 1:
        raise InputError(f"the law {text[:60]!r} uses both sigma and x; write it in one variable")
    return found


class Undefined(InputError):
    """The formula divides by zero at the rational point ``place``: there it has no value."""

    def __init__(self, words: str, place: Fraction) -> None:
        self.place = place
        super().__init__(words)


def of_tree(tree: Node, name: str, low: End, high: End) -> Known:
    """A tree cut into pieces."""
    cut = pieces(tree, low, high)
    return Known(
        name=name,
        pieces=cut,
        value=lambda x: _value(tree, x, name),
        continuous=not jumps_possible(tree),
        whole=not any(jumps_possible(piece.tree) for piece in cut),
        branches=partial(branches, tree),
    )


def _of_graph(graph: Graph, name: str, low: End, high: End) -> Known:
    cuts = sorted({Fraction(0), *graph.knots})
    ends: list[End] = [low, *(x for x in cuts if low < x < high), high]
    found = []
    for a, b in pairwise(ends):
        middle = Piece(a, b, SIGMA, None).middle
        slope = graph.slopes[bisect_left(graph.knots, middle)]
        line = fmpq_poly([to_fmpq(graph.exact(middle) - slope * middle), to_fmpq(slope)])
        found.append(Piece(a, b, SIGMA, Ratio(line, _ONE, _ONE)))
    return Known(name=name, pieces=tuple(found), value=graph.exact, continuous=True, whole=True)


def _value(tree: Node, x: Fraction, name: str) -> Value:
    from lure.expressions import rigorous as exact

    try:
        return exact.value(tree, {"sigma": x})
    except InputError as error:
        here = at_point(tree, x)
        with working_precision(BITS):
            point = {"sigma": ball(x)}
            low, high = bounds_of(enclosure(here, point)) if has_value(here, point) else (-math.inf, math.inf)
        if not isinstance(low, Fraction) or not isinstance(high, Fraction):
            divides = "divides by zero" in str(error)
            words = (
                f"the law {name[:60]!r} has no value that could be enclosed at sigma = {float(x):.10g}"
                f"{'; it divides by zero there' * divides}; write a formula with finite values, or bound it on an "
                "interval without that point"
            )
            raise (Undefined(words, x) if divides else InputError(words)) from None
        if low <= 0 <= high and difference_vanishes(tree, Number(Fraction(0)), x):
            return Fraction(0)
        return low if low == high else (low, high)


def jumps_possible(node: Node) -> bool:
    """Whether a tree holds an operation that is not continuous where it is defined."""
    if not isinstance(node, Apply) or not node.names:
        return False
    return node.operation in ("where", "sign") or any(jumps_possible(part) for part in node.arguments)


def _times(factor: Fraction, node: Node) -> Node:
    return Apply("*", (Number(factor), node))


def _in_sigma(node: Node) -> Node:
    """The tree with its one variable called sigma."""
    if isinstance(node, Variable):
        return SIGMA
    if not isinstance(node, Apply) or not node.names:
        return node
    return Apply(node.operation, tuple(_in_sigma(part) for part in node.arguments))


def _name(law: object) -> str:
    if isinstance(law, NormalCompliance):
        factor = "" if law.exact_stiffness == 1 else f"{number_text(law.exact_stiffness)} "
        power = "" if law.exact_exponent == 1 else f"^{number_text(law.exact_exponent)}"
        return f"normal compliance {factor}max(sigma, 0){power}"
    return law.source if isinstance(law, Expression) else str(law)


def domain(on: object) -> tuple[Fraction, Fraction] | None:
    """The interval as exact numbers.

    Raises
    ------
    InputError
        It is not a pair of finite numbers in ascending order.
    """
    from lure.exact import exact_number

    if on is None:
        return None
    if isinstance(on, str) or not hasattr(on, "__len__") or len(on) != 2:
        raise InputError(f"on is {on!r:.60}; give a pair of numbers, (low, high), or None for all of R")
    pair: Any = on  # exact_number says what is wrong with an entry
    low, high = (exact_number(x, f"on[{i}]") for i, x in enumerate(pair))
    if not low < high:
        raise InputError(f"on is [{float(low):g}, {float(high):g}]; give low < high")
    return low, high
