"""What a formula shows of a nonlinearity: whether it is odd, and where it vanishes, exactly.

With a pole at 0 the equilibria of the loop are the points where it vanishes.
"""

from __future__ import annotations

import math
from fractions import Fraction

from lure.analysis.nonlinearity.bounds import cuts_of
from lure.analysis.nonlinearity.pieces import Known, Piece, known_nonlinearity
from lure.analysis.nonlinearity.rational import End, Ratio, ratio, roots_between
from lure.errors import InputError
from lure.expressions import Expression
from lure.expressions.regularity import nature
from lure.expressions.tree import Apply, Node, Number, Variable
from lure.nonlinearities import ExpressionNonlinearity, GraphNonlinearity, Quantiser
from lure.nonlinearities.formula import piecewise_linear_graph
from lure.nonlinearities.piecewise_linear import Graph
from lure.record import described, quantity
from lure.record.values import exact_text

# Oddness read off a formula: a proof for every ``sigma``, where the formula shows it.

_ODD_FUNCTIONS = frozenset(("neg", "sin", "tan", "tanh", "atan", "sign"))
_EVEN_OF_ODD = frozenset(("abs", "cos"))
_EVEN, _ODD = 1, -1


def known_odd(expression: Expression, variable: str) -> bool | None:
    """Whether a formula is odd; None where its form does not tell.

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


_LIKE_THEIR_ARGUMENT = frozenset(("neg", "tanh", "atan", "abs", "sqrt"))


@described(frozen=True, kw_only=True, slots=True)
class ZeroInterval:
    """An interval on which a nonlinearity is 0; a point has equal ends."""

    low: End = quantity("Lower end")
    high: End = quantity("Upper end")
    closed: bool = quantity("Whether the finite ends belong to it", default=True)

    def __str__(self) -> str:
        if self.low == self.high:
            return f"{{{exact_text(self.low)}}}"
        left = "[" if self.closed and self.low != -math.inf else "("
        right = "]" if self.closed and self.high != math.inf else ")"
        return f"{left}{exact_text(self.low)}, {exact_text(self.high)}{right}"


@described(frozen=True, kw_only=True, slots=True)
class ZeroSet:
    """All ``sigma`` with ``phi(sigma) = 0``, exactly."""

    parts: tuple[ZeroInterval, ...] = quantity("Ascending, with gaps between them")

    @property
    def only_zero(self) -> bool:
        """Whether the nonlinearity vanishes at 0 and nowhere else."""
        return len(self.parts) == 1 and self.parts[0].low == 0 == self.parts[0].high

    def __str__(self) -> str:
        return " and ".join(map(str, self.parts))


def zero_set(nonlinearity: object) -> ZeroSet | None:
    """The exact set of zeros of a nonlinearity; None where it is not known.

    ``nonlinearity``: a nonlinearity of the library, or a formula.

    Returns
    -------
    ZeroSet or None
        For piecewise linear graphs, the quantiser, and formulas that are piecewise rational with rational zeros, all
        zeros; for other formulas ``{0}`` where no other zero exists.

    Examples
    --------
    >>> from lure import DeadZone, Quantiser, Saturation
    >>> print(zero_set(Saturation()), zero_set(DeadZone(width=2)), zero_set(Quantiser(step=1)))
    {0} [-2, 2] (-0.5, 0.5)
    """
    if type(nonlinearity) is Quantiser:
        return ZeroSet(parts=(ZeroInterval(low=-nonlinearity.step / 2, high=nonlinearity.step / 2, closed=False),))
    own = getattr(type(nonlinearity).__call__, "__module__", "").startswith(
        "lure."
    )  # no class of the user's, of other values
    graph = nonlinearity.graph if isinstance(nonlinearity, GraphNonlinearity | ExpressionNonlinearity) and own else None
    if graph is not None:
        return _of_graph(graph)
    try:
        known = known_nonlinearity(nonlinearity, -math.inf, math.inf)
        return None if known is None else _of_known(known)
    except InputError:
        return None  # it has no value somewhere, or too many pieces


def _of_graph(graph: Graph) -> ZeroSet:
    """Zeros at the knots, between them, and on the two half-lines outside."""
    found: list[tuple[End, End]] = []
    ends: list[End] = [-math.inf, *graph.knots, math.inf]
    for i, slope in enumerate(graph.slopes):
        low, high = ends[i], ends[i + 1]
        anchor = min(i, len(graph.knots) - 1)
        x, y = graph.knots[anchor], graph.values[anchor]
        if slope == 0:
            if y == 0:
                found.append((low, high))
        elif low <= (root := x - y / slope) <= high:
            found.append((root, root))
    return _joined(found)


def _of_known(known: Known) -> ZeroSet | None:
    found: list[tuple[End, End]] = []
    for cut in cuts_of(known):
        value = known.value(cut)
        if isinstance(value, tuple):
            if value[0] <= 0 <= value[1]:
                return None
        elif value == 0:
            found.append((cut, cut))
    points = {low for low, _ in found}
    for piece in known.pieces:
        roots = _zeros_inside(piece)
        if roots is None:
            return None
        if any(low != high and not {low, high} <= {*points, -math.inf, math.inf} for low, high in roots):
            return None  # it jumps away from 0 at an end, and the interval is not closed
        found += roots
    return _joined(found)


def _joined(found: list[tuple[End, End]]) -> ZeroSet:
    """Closed intervals with those that meet made one."""
    parts: list[tuple[End, End]] = []
    for low, high in sorted(found):
        if parts and low <= parts[-1][1]:
            parts[-1] = parts[-1][0], max(high, parts[-1][1])
        else:
            parts.append((low, high))
    return ZeroSet(parts=tuple(ZeroInterval(low=low, high=high) for low, high in parts))


def _zeros_inside(piece: Piece) -> list[tuple[End, End]] | None:
    """The zeros in an open interval between cuts; None where they are not known."""
    if piece.ratio is None:
        return [] if _sign(piece.tree, piece) else None
    if piece.ratio.top.degree() < 0:
        return [(piece.low, piece.high)]
    roots = roots_between(piece.ratio.top, piece.low, piece.high)
    exact = [root for root in roots if isinstance(root, Fraction)]
    return [(root, root) for root in exact] if len(exact) == len(roots) else None


def _sign(node: Node, piece: Piece) -> int | None:
    """The strict sign of a tree on all of an open interval; None where it is not seen."""
    try:
        known = ratio(node)
    except InputError:
        known = None
    if known is not None:
        return _sign_of_ratio(known, piece)
    assert isinstance(node, Apply), "a number or a variable is a rational function"
    visible = nature(node)
    if visible is not None and visible.nonzero:
        return 1 if visible.positive else -1
    if node.operation in ("where", "min", "max"):
        signs = {_sign(part, piece) for part in node.arguments[-2:]}
        return signs.pop() if len(signs) == 1 else None
    if node.operation == "**":
        return _sign_of_power(node, piece)
    first = _sign(node.arguments[0], piece)
    if first is None:
        return None
    if node.operation in _LIKE_THEIR_ARGUMENT:
        return {"neg": -first, "abs": 1}.get(node.operation, first)
    if node.operation not in ("+", "-", "*", "/"):
        return None
    second = _sign(node.arguments[1], piece)
    if second is None:
        return None
    if node.operation in ("*", "/"):
        return first * second
    return first if first == (second if node.operation == "+" else -second) else None


def _sign_of_power(node: Apply, piece: Piece) -> int | None:
    base, exponent = _sign(node.arguments[0], piece), node.arguments[1]
    assert isinstance(exponent, Number), "the parser and the derivative make only constant exponents"
    if base is None or exponent.value == 0:
        return None if base is None else 1
    return base if exponent.value.denominator != 1 or exponent.value.numerator % 2 else 1


def _sign_of_ratio(known: Ratio, piece: Piece) -> int | None:
    if known.top.degree() < 0 or any(roots_between(p, piece.low, piece.high) for p in (known.top, known.bottom)):
        return None
    value = known.at(piece.middle)
    assert value is not None, "the denominator has no root inside"
    return 1 if value > 0 else -1
