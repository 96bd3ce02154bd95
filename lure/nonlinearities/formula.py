"""Nonlinearities given as a formula in ``sigma``, with the properties their author declares."""

from __future__ import annotations

import math
import operator
from bisect import bisect_left
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import TypeAlias

from lure.arrays import ArrayLike, NDArray, np
from lure.classes import Sector, SlopeBounds
from lure.errors import InputError, Reason
from lure.expressions import Expression
from lure.expressions.regularity import Nature, has_value, nature
from lure.expressions.tree import COMPARISONS, CONDITIONS, Apply, Node, Number
from lure.nonlinearities.base import NamedNonlinearity, assign
from lure.nonlinearities.piecewise_linear import Graph
from lure.record import quantity

# Formulas that are piecewise linear without looking it: from the tree to the exact graph.

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


VARIABLE = "sigma"


class ExpressionNonlinearity(NamedNonlinearity):
    r"""``phi(sigma)`` as text, read by the whitelist parser; the author may vouch for its sector and slope.

    What is declared stays declared: :func:`lure.nonlinearities.properties` calls it checked only for a formula that
    is piecewise
    linear, which is recognised exactly; :func:`lure.nonlinearities.check_declared` looks for a point that contradicts
    it.

    Parameters
    ----------
    text : str
        The formula, e.g. ``"min(max(2*sigma, -1), 1)"``; see :class:`lure.expressions.Expression`.
    sector : Sector or None
        Declared sector; None declares nothing: of a piecewise linear formula the sector, slope bounds and oddness are
        then those of its graph, of any other the sector is ``[-inf, inf]`` here, and :func:`lure.analysis.analyse`
        takes
        the one it certifies.
    slope_bounds : SlopeBounds or None
        Declared slope bounds, None for none.
    odd : bool
        Whether the nonlinearity is declared odd.
    locally_lipschitz : bool
        Whether it is declared locally Lipschitz.  Finite slope bounds make it so, and so does a formula that visibly
        is: see ``lure.expressions.regularity.nature``.

    Raises
    ------
    InputError
        The text is refused by the parser, ``phi(0)`` is not 0 or cannot be shown to be 0, or a declared property is
        not of the type named.

    Examples
    --------
    >>> bounds = {"sector": Sector(0, 1), "slope_bounds": SlopeBounds(0, 1), "odd": True}
    >>> nonlinearity = ExpressionNonlinearity("sigma/(1 + abs(sigma))", **bounds)
    >>> print(nonlinearity, nonlinearity.sector, nonlinearity([-1.0, 3.0]))
    sigma/(1 + abs(sigma)) [0, 1] [-0.5   0.75]
    """

    text: str
    sector: Sector
    slope_bounds: SlopeBounds | None
    odd: bool
    locally_lipschitz: bool
    sector_declared: bool = quantity("", hidden=True, init=False)
    expression: Expression = quantity("", hidden=True, init=False)
    derivative: Expression = quantity("", hidden=True, init=False)
    graph: Graph | None = quantity("", hidden=True, init=False)
    nature: Nature | None = quantity("", hidden=True, init=False)

    def __init__(
        self,
        text: str,
        *,
        sector: Sector | None = None,
        slope_bounds: SlopeBounds | None = None,
        odd: bool = False,
        locally_lipschitz: bool = False,
    ) -> None:
        if not isinstance(text, str):
            raise InputError(f"ExpressionNonlinearity.text is {text!r:.60}; give a formula in sigma as text")
        if sector is not None and not isinstance(sector, Sector):
            raise InputError(f"ExpressionNonlinearity.sector is {sector!r:.60}; declare a Sector")
        if slope_bounds is not None and not isinstance(slope_bounds, SlopeBounds):
            raise InputError(
                f"ExpressionNonlinearity.slope_bounds is {slope_bounds!r:.60}; declare SlopeBounds, or None"
            )
        for name, value in (("odd", odd), ("locally_lipschitz", locally_lipschitz)):
            if not isinstance(value, bool):
                raise InputError(f"ExpressionNonlinearity.{name} is {value!r:.60}; declare True or False")
        expression = Expression.parse(text, variables=(VARIABLE,), field="ExpressionNonlinearity.text")
        _demand_zero(expression)
        graph = piecewise_linear_graph(expression, VARIABLE)
        if sector is None and graph is not None and not graph.is_line:
            slope_bounds = graph.slope_bounds if slope_bounds is None else slope_bounds
            odd = odd or graph.odd
        finite = slope_bounds is not None and max(-slope_bounds.lower, slope_bounds.upper) < math.inf
        found = nature(expression.tree)
        assign(
            self,
            text=expression.source,
            sector=_undeclared(graph, slope_bounds) if sector is None else sector,
            sector_declared=sector is not None,
            slope_bounds=slope_bounds,
            odd=odd,
            locally_lipschitz=locally_lipschitz or finite or graph is not None or _visibly_lipschitz(found),
            expression=expression,
            derivative=expression.derivative(VARIABLE),
            graph=graph,
            nature=found,
        )

    @property
    def regularity(self) -> str:
        """Continuity in words: what the form of the formula shows, else what is declared."""
        if self.graph is not None:
            return "piecewise linear, globally Lipschitz"
        if self.locally_lipschitz:
            return "locally Lipschitz"
        return "continuous" if self.nature is not None and self.nature.continuous else "unknown"

    @property
    def visibly_lipschitz(self) -> bool:
        """Whether the formula is locally Lipschitz by its form, whatever is declared."""
        return self.graph is not None or _visibly_lipschitz(self.nature)

    @property
    def breakpoints(self) -> tuple[Fraction, ...]:
        """Where the formula may change its branch, as far as that is known exactly."""
        if self.graph is not None:
            return self.graph.kinks
        return self.expression.breakpoints(VARIABLE, -(10**300), 10**300) or ()

    def __call__(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """Values ``phi(sigma)``, elementwise; nan where the formula is undefined."""
        return self._values(self.expression, sigma)

    def slope(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """Derivative almost everywhere, elementwise; jumps are passed over."""
        return self._values(self.derivative, sigma)

    def primitive(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """``int_0^sigma phi``, elementwise: exact up to rounding if piecewise linear, else by adaptive quadrature."""
        if self.graph is not None:
            return self.graph.primitive(sigma)
        from scipy.integrate import quad

        x = np.asarray(sigma, dtype=float)
        kinks = [float(point) for point in self.breakpoints]

        def integral(end: float) -> float:
            """Integral from 0 to ``end``, between the kinks."""
            if not np.isfinite(end):
                return float("nan")
            inside = sorted({0.0, end, *(kink for kink in kinks if min(0.0, end) < kink < max(0.0, end))})
            parts = [quad(self, a, b, limit=200)[0] for a, b in pairwise(inside)]
            return float(np.copysign(1.0, end) * sum(parts))

        return np.array([integral(float(end)) for end in x.ravel()], dtype=float).reshape(x.shape)

    def _values(self, expression: Expression, sigma: ArrayLike) -> NDArray[np.float64]:
        x = np.asarray(sigma, dtype=float)
        return expression(sigma=x) if not expression.is_constant else np.broadcast_to(expression(), x.shape).copy()

    def __str__(self) -> str:
        return self.text


def _undeclared(graph: Graph | None, slope_bounds: SlopeBounds | None) -> Sector:
    """The sector of a formula of which none is declared: its graph's, or that of the slope bounds."""
    if graph is not None and not graph.is_line:
        return graph.sector
    if slope_bounds is not None:
        return Sector(slope_bounds.lower, slope_bounds.upper)
    return Sector(-math.inf, math.inf)


def _demand_zero(expression: Expression) -> None:
    """Refuse a formula that does not vanish at 0, or that cannot be shown to."""
    try:
        value = expression.exact(sigma=Fraction(0))
    except InputError:
        import flint

        defined = has_value(expression.tree, {VARIABLE: flint.arb(0)})
        enclosure = expression.ball(sigma=flint.arb(0))
        if defined and enclosure == 0:
            return
        if defined and enclosure != 0:
            found = f"phi(0) = {float(enclosure.mid()):.6g}; a nonlinearity must vanish at 0"
        else:
            found = "a phi(0) that cannot be shown to be 0; write the formula so that it visibly is"
        raise InputError(f"ExpressionNonlinearity {expression.source[:60]!r} has {found}") from None
    if value != 0:
        raise InputError(
            f"ExpressionNonlinearity {expression.source[:60]!r} has phi(0) = {float(value):.6g}; a nonlinearity "
            "must vanish at 0: measure sigma and phi from the equilibrium",
            code=Reason.OUTSIDE_CLASS,
        )


def _visibly_lipschitz(found: Nature | None) -> bool:
    return found is not None and found.lipschitz
