"""A nonlinearity cut into pieces on each of which it is one formula, and those that are known exactly."""

from __future__ import annotations

import math
import operator
from bisect import bisect_left
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from itertools import pairwise
from typing import Any

from flint import fmpq_poly

from lure.analysis.nonlinearity.rational import BITS, End, Ratio, TooLarge, bounds_of, ratio, roots_between
from lure.analysis.numerics.polynomial import to_fmpq
from lure.analysis.numerics.precision import working_precision
from lure.errors import InputError
from lure.expressions import Expression
from lure.expressions import rigorous as exact
from lure.expressions.regularity import has_value
from lure.expressions.rigorous import ball, enclosure
from lure.expressions.tree import COMPARISONS, CONDITIONS, ZERO, Apply, Node, Number, Variable, apply, is_total, names
from lure.nonlinearities import Cubic, ExpressionNonlinearity, GraphNonlinearity, ShiftedNonlinearity, Tanh
from lure.nonlinearities.base import NormalCompliance
from lure.nonlinearities.piecewise_linear import Graph
from lure.nonlinearities.reading import control_saturation
from lure.record import described, quantity
from lure.record.values import exact_text

# A nonlinearity given as a tree, cut where its branches change: on each open interval one tree, with the branches
# chosen.

# Values at rational points as sums of different constants, so that ``tanh(-1) + tanh(1)`` is seen to be 0.

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


MAX_PIECES = 500
_COMPARE: Mapping[str, Callable[[Fraction, int], bool]] = dict(
    zip(COMPARISONS, (operator.lt, operator.le, operator.gt, operator.ge, operator.eq, operator.ne), strict=True)
)
_TRUE, _FALSE = apply("==", ZERO, ZERO), apply("!=", ZERO, ZERO)
_SINGULAR = ("sqrt", "log")
_SHORT = Fraction(1, 2**64)  # so near to 0 branches that change elsewhere are chosen


@described(frozen=True, slots=True)
class Piece:
    """The nonlinearity on an open interval."""

    low: End = quantity("Lower end of the interval")
    high: End = quantity("Upper end of the interval")
    tree: Node = quantity("The nonlinearity there: branches that change side at rational points only are chosen")
    ratio: Ratio | None = quantity("The same as a rational function, if it is one")

    @property
    def middle(self) -> Fraction:
        """A point inside."""
        return _middle(self.low, self.high)

    @property
    def tends_to_zero(self) -> bool:
        """Whether 0 is an end and visibly the limit there, which the value at 0 alone does not show: it may jump."""
        if Fraction(0) not in (self.low, self.high):
            return False
        near = branches(self.tree, max(self.low, -_SHORT), min(self.high, _SHORT))
        return not jumps_possible(near) and difference_vanishes(near, ZERO, Fraction(0))


def pieces(tree: Node, low: End, high: End) -> tuple[Piece, ...]:
    """The nonlinearity between two ends, cut at 0 and wherever a branch changes at a rational point.

    ``tree``: a formula in one variable; ``low``, ``high``: the domain, ``low < high``.

    Returns
    -------
    tuple of Piece
        Ascending and adjacent.  A branch that depends on a condition whose sides are not rational functions, or cross
        at irrational points, stays in the tree.

    Raises
    ------
    TooLarge
        There are more than 500 pieces, or the degree of a rational function passes 256.
    """
    waiting: list[tuple[End, End]] = [(Fraction(0), high), (low, Fraction(0))] if low < 0 < high else [(low, high)]
    found: list[Piece] = []
    while waiting:
        a, b = waiting.pop()
        chosen = _Chosen(a, b)
        resolved = chosen.tree(tree)
        if chosen.cuts:
            ends = [a, *sorted(chosen.cuts), b]
            waiting += reversed(list(pairwise(ends)))
            if len(found) + len(waiting) > MAX_PIECES:
                raise TooLarge(
                    f"the nonlinearity changes its branch more than {MAX_PIECES} times; bound it on a shorter interval"
                )
            continue
        found.append(Piece(a, b, resolved, chosen.ratio(resolved)))
    return tuple(found)


def branches(tree: Node, low: End, high: End) -> Node:
    """The tree with the branches of ``where`` and ``sign`` chosen: what is left is continuous if none is left.

    Two neighbouring intervals, or an interval and its end (``low == high``), with the same tree meet without a jump.
    """
    return _Chosen(low, high, kinks=False).tree(tree)


def at_point(tree: Node, x: Fraction) -> Node:
    """The tree at an exact point, with its branches chosen and every rational function in it a number."""
    return _Chosen(x, x, numbers=True).tree(tree)


@dataclass(slots=True)
class _Chosen:
    """The branches taken on an open interval, or at a point, and the points inside where one changes.

    Without ``kinks`` the branches of ``abs``, ``min`` and ``max`` are left alone, except in conditions.  With
    ``numbers``, at a point, rational functions become their values there.
    """

    low: End
    high: End
    kinks: bool = True
    numbers: bool = False
    cuts: set[Fraction] = field(default_factory=set)
    ratios: dict[Node, Ratio | None] = field(default_factory=dict)

    def ratio(self, node: Node) -> Ratio | None:
        """The rational function a tree without branches stands for."""
        if node not in self.ratios:
            try:
                self.ratios[node] = ratio(node)
            except InputError:
                if not self.numbers:
                    raise
                self.ratios[node] = None  # it may stand in a branch that is not taken
        return self.ratios[node]

    def tree(self, node: Node) -> Node:
        """The tree with its branches chosen, as far as they are known; points where one changes are collected."""
        if self.numbers and (known := self.ratio(node)) is not None:
            here = known.defined_at(Fraction(self.low))
            return node if here is None else Number(here)
        if not isinstance(node, Apply):
            return node
        name, kinks = node.operation, self.kinks
        self.kinks = kinks or name in CONDITIONS or name == "sign"
        parts = [self.tree(part) for part in node.arguments]
        self.kinks = kinks
        if name in COMPARISONS or (self.kinks and name in ("min", "max")):
            return self._compared(name, parts[0], parts[1])
        if name == "sign" or (self.kinks and name == "abs"):
            sign = self._sign(parts[0])
            if sign is None:
                return apply(name, *parts)
            return Number(Fraction(sign)) if name == "sign" else parts[0] if sign >= 0 else apply("neg", parts[0])
        if name in ("and", "or", "not"):
            return _combined(name, parts)
        if name == "where":
            return parts[1] if parts[0] == _TRUE else parts[2] if parts[0] == _FALSE else apply("where", *parts)
        if name in _SINGULAR or (name == "**" and _fractional(parts[1])):
            self._sign(parts[0])  # a zero of the argument is no place to expand at: cut there
            if parts[0] == ZERO and (name == "sqrt" or _positive(parts[-1])):
                return ZERO
            exponent = parts[1] if name == "**" else Number(Fraction(1, 2))
            if (root := self._root(parts[0], exponent)) is not None:
                return root
        return self._without_zeros(apply(name, *parts))

    def _root(self, base: Node, exponent: Node) -> Node | None:
        """``(u**n)**p`` as ``|u|**(n p)`` where the sign of ``u`` is known; None for other trees."""
        if not isinstance(base, Apply) or base.operation != "**" or not isinstance(exponent, Number):
            return None
        inner, power = base.arguments
        assert isinstance(power, Number), "the parser and the derivative make only constant exponents"
        sign = self._sign(inner)
        if not sign or power.value.denominator != 1 or (sign < 0 and power.value.numerator % 2):
            return None
        size = inner if sign > 0 else apply("neg", inner)
        return apply("**", size, Number(power.value * exponent.value))

    def _without_zeros(self, node: Node) -> Node:
        """0 for a difference of equal rational functions without poles, such as ``x - x``."""
        if isinstance(node, Apply) and node.operation == "-" and is_total(node):
            known = self.ratio(node)
            if known is not None and known.top.degree() < 0:
                return ZERO
        return node

    def _compared(self, name: str, u: Node, v: Node) -> Node:
        sign = self._sign(apply("-", u, v))
        if sign is None:
            return apply(name, u, v)
        if name in COMPARISONS:
            return _TRUE if _COMPARE[name](Fraction(sign), 0) else _FALSE
        return u if (sign >= 0) == (name == "max") else v

    def _sign(self, node: Node) -> int | None:
        """The sign on the whole interval; None if it changes there (rational changes are noted) or is not known."""
        known = self.ratio(node)
        if known is None:
            return None
        if self.low == self.high:
            here = known.defined_at(Fraction(self.low))
            return None if here is None else (here > 0) - (here < 0)
        # poles that cancel are points without a value too: a comparison there has nothing to compare
        roots = [*roots_between(known.top, self.low, self.high), *roots_between(known.poles, self.low, self.high)]
        self.cuts.update(root for root in roots if isinstance(root, Fraction))
        if roots:
            return None
        if known.top.degree() < 0:
            return 0
        value = known.at(_middle(self.low, self.high))
        assert value is not None, "the denominator has no root inside"
        return 1 if value > 0 else -1


def _combined(name: str, parts: list[Node]) -> Node:
    if name == "not":
        return _FALSE if parts[0] == _TRUE else _TRUE if parts[0] == _FALSE else apply("not", parts[0])
    deciding, other = (_TRUE, _FALSE) if name == "or" else (_FALSE, _TRUE)
    if deciding in parts:
        parts = parts[: parts.index(deciding) + 1]  # what stands before it must have a value all the same
    rest = [part for part in parts if part != other]
    return other if not rest else rest[0] if len(rest) == 1 else apply(name, *rest)


def _positive(exponent: Node) -> bool:
    return isinstance(exponent, Number) and exponent.value > 0


def _fractional(exponent: Node) -> bool:
    return isinstance(exponent, Number) and exponent.value.denominator != 1


def _middle(low: End, high: End) -> Fraction:
    if isinstance(low, Fraction):
        return (low + high) / 2 if isinstance(high, Fraction) else low + 1
    return high - 1 if isinstance(high, Fraction) else Fraction(0)


Value = Fraction | tuple[Fraction, Fraction]
SIGMA = Variable("sigma")
_NAMES = ("sigma", "x")
_ONE = fmpq_poly([1])


@described(frozen=True, kw_only=True, slots=True)
class Known:
    """A nonlinearity on a closed interval or all of R."""

    name: str = quantity("The nonlinearity in words")
    pieces: tuple[Piece, ...] = quantity("Ascending and adjacent")
    value: Callable[[Fraction], Value] = quantity("The value at an exact point, or an interval that contains it")
    continuous: bool = quantity(
        "Whether the nonlinearity is continuous for its form alone; else the cuts are looked at one by one"
    )
    whole: bool = quantity("Whether all its branches were chosen exactly, so that it is smooth between the cuts")
    branches: Callable[[End, End], Node] | None = quantity(
        "For a nonlinearity with jumps: the tree, with its branches chosen, on an interval or at a point", default=None
    )


def known_nonlinearity(nonlinearity: object, low: End, high: End) -> Known | None:
    """The nonlinearity cut into pieces; None for one known by its values alone.

    Raises
    ------
    InputError
        A text is refused by the parser, or uses both ``sigma`` and ``x``.
    """
    nonlinearity = control_saturation(nonlinearity) or nonlinearity
    if callable(nonlinearity) and not getattr(type(nonlinearity).__call__, "__module__", "").startswith("lure."):
        return None  # a class of the user's, whose values need not be those of the nonlinearity that it is derived from
    if isinstance(nonlinearity, GraphNonlinearity):
        return _of_graph(nonlinearity.graph, f"{nonlinearity}", low, high)
    if isinstance(nonlinearity, ExpressionNonlinearity) and nonlinearity.graph is not None:
        return _of_graph(nonlinearity.graph, nonlinearity.text, low, high)
    tree = tree_of(nonlinearity)
    return None if tree is None else of_tree(_in_sigma(tree), _name(nonlinearity), low, high)


def tree_of(nonlinearity: object) -> Node | None:
    """The tree of a nonlinearity in one variable; None for one that has none."""
    if isinstance(nonlinearity, str):
        return parsed(nonlinearity).tree
    if isinstance(nonlinearity, Expression):
        if len(names(nonlinearity.tree)) > 1:
            raise InputError(
                f"the nonlinearity {nonlinearity.source[:60]!r} has the variables {sorted(names(nonlinearity.tree))}; "
                f"a "
                "nonlinearity has one"
            )
        return nonlinearity.tree
    if isinstance(nonlinearity, ExpressionNonlinearity):
        return nonlinearity.expression.tree
    if isinstance(nonlinearity, Tanh):
        return _times(nonlinearity.gain, Apply("tanh", (Apply("/", (SIGMA, Number(nonlinearity.scale))),)))
    if isinstance(nonlinearity, Cubic):
        cube = Apply("**", (SIGMA, Number(Fraction(3))))
        return Apply("+", (_times(nonlinearity.linear, SIGMA), _times(nonlinearity.cubic, cube)))
    if isinstance(nonlinearity, NormalCompliance):
        power = Apply("**", (SIGMA, Number(nonlinearity.exact_exponent)))
        zero = Number(Fraction(0))
        return Apply("where", (Apply(">", (SIGMA, zero)), _times(nonlinearity.exact_stiffness, power), zero))
    if isinstance(nonlinearity, ShiftedNonlinearity):
        inner = tree_of(nonlinearity.nonlinearity)
        return None if inner is None else Apply("-", (inner, _times(nonlinearity.gain, SIGMA)))
    return None


def kinks(nonlinearity: object) -> list[float]:
    """Where a nonlinearity changes its branch, as far as that is known exactly."""
    known = known_nonlinearity(nonlinearity, -math.inf, math.inf)
    return [] if known is None else [float(p.high) for p in known.pieces if isinstance(p.high, Fraction)]


def parsed(text: str) -> Expression:
    """A nonlinearity as text in ``sigma``, or in ``x``.

    Raises
    ------
    InputError
        The parser refuses it, or it uses both names.
    """
    found = Expression.parse(text, variables=_NAMES, field="the nonlinearity")
    if len(names(found.tree)) > 1:
        raise InputError(f"the nonlinearity {text[:60]!r} uses both sigma and x; write it in one variable")
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
                f"the nonlinearity {name[:60]!r} has no value that could be enclosed at sigma = {float(x):.10g}"
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


def _name(nonlinearity: object) -> str:
    if isinstance(nonlinearity, NormalCompliance):
        factor = "" if nonlinearity.exact_stiffness == 1 else f"{exact_text(nonlinearity.exact_stiffness)} "
        power = "" if nonlinearity.exact_exponent == 1 else f"^{exact_text(nonlinearity.exact_exponent)}"
        return f"normal compliance {factor}max(sigma, 0){power}"
    return nonlinearity.source if isinstance(nonlinearity, Expression) else str(nonlinearity)


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
