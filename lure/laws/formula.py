"""Laws given as a formula in ``sigma``, with the properties their author declares."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.errors import InputError
from lure.expressions import Expression
from lure.expressions.tree import Apply, Node, Number
from lure.laws.affine import piecewise_linear_graph
from lure.laws.graph import Graph
from lure.laws.law import assign
from lure.sector import Sector, SlopeBounds

VARIABLE = "sigma"
_LIPSCHITZ = frozenset(("+", "-", "*", "neg", "abs", "min", "max", "sin", "cos", "exp", "tanh", "atan", "pi"))


@dataclass(frozen=True, slots=True)
class ExpressionLaw:
    r"""``phi(sigma)`` as text, read by the whitelist parser; the author vouches for its sector and slope.

    What is declared stays declared: :func:`lure.laws.properties` calls it checked only for a formula that is piecewise
    linear, which is recognised exactly; :func:`lure.laws.check_declared` looks for a point that contradicts it.

    Parameters
    ----------
    text : str
        The formula, e.g. ``"min(max(2*sigma, -1), 1)"``; see :class:`lure.expressions.Expression`.
    sector : Sector
        Declared sector.
    slope_bounds : SlopeBounds or None
        Declared slope bounds, None for none.
    odd : bool
        Whether the law is declared odd.
    locally_lipschitz : bool
        Whether it is declared locally Lipschitz; finite slope bounds make it so, and so does a formula made only of
        sums, products, whole powers, ``abs min max sin cos exp tanh atan`` and division by numbers.

    Raises
    ------
    InputError
        The text is refused by the parser, ``phi(0)`` is not 0 or cannot be shown to be 0, or a declared property is
        not of the type named.

    Examples
    --------
    >>> law = ExpressionLaw("sigma/(1 + abs(sigma))", sector=Sector(0, 1), slope_bounds=SlopeBounds(0, 1), odd=True)
    >>> print(law, law.sector, law([-1.0, 3.0]))
    sigma/(1 + abs(sigma)) [0, 1] [-0.5   0.75]
    """

    text: str
    sector: Sector
    slope_bounds: SlopeBounds | None
    odd: bool
    locally_lipschitz: bool
    expression: Expression = field(init=False, repr=False, compare=False)
    derivative: Expression = field(init=False, repr=False, compare=False)
    graph: Graph | None = field(init=False, repr=False, compare=False)

    def __init__(
        self,
        text: str,
        *,
        sector: Sector,
        slope_bounds: SlopeBounds | None = None,
        odd: bool = False,
        locally_lipschitz: bool = False,
    ) -> None:
        if not isinstance(text, str):
            raise InputError(f"ExpressionLaw.text is {text!r:.60}; give a formula in sigma as text")
        if not isinstance(sector, Sector):
            raise InputError(f"ExpressionLaw.sector is {sector!r:.60}; declare a Sector")
        if slope_bounds is not None and not isinstance(slope_bounds, SlopeBounds):
            raise InputError(f"ExpressionLaw.slope_bounds is {slope_bounds!r:.60}; declare SlopeBounds, or None")
        for name, value in (("odd", odd), ("locally_lipschitz", locally_lipschitz)):
            if not isinstance(value, bool):
                raise InputError(f"ExpressionLaw.{name} is {value!r:.60}; declare True or False")
        expression = Expression.parse(text, variables=(VARIABLE,), field="ExpressionLaw.text")
        _demand_zero(expression)
        finite = slope_bounds is not None and max(-slope_bounds.lower, slope_bounds.upper) < math.inf
        graph = piecewise_linear_graph(expression, VARIABLE)
        assign(
            self,
            text=expression.source,
            sector=sector,
            slope_bounds=slope_bounds,
            odd=odd,
            locally_lipschitz=locally_lipschitz or finite or graph is not None or _smooth_enough(expression.tree),
            expression=expression,
            derivative=expression.derivative(VARIABLE),
            graph=graph,
        )

    @property
    def regularity(self) -> str:
        """Continuity in words: exact for piecewise linear formulas, else what is declared."""
        if self.graph is not None:
            return "piecewise linear, globally Lipschitz"
        return "locally Lipschitz" if self.locally_lipschitz else "unknown"

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

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data: parameters, and what is known with its standing."""
        from lure.laws.showing import law_dict

        return law_dict(self)

    def _repr_html_(self) -> str:
        from lure.laws.showing import law_html

        return law_html(self)


def _demand_zero(expression: Expression) -> None:
    """Refuse a formula that does not vanish at 0, or that cannot be shown to."""
    try:
        value = expression.exact(sigma=Fraction(0))
    except InputError:
        import flint

        enclosure = expression.ball(sigma=flint.arb(0))
        if enclosure == 0:
            return
        if enclosure != 0:
            found = f"phi(0) = {float(enclosure.mid()):.6g}; a law must vanish at 0"
        else:
            found = "a phi(0) that cannot be shown to be 0; write the formula so that it visibly is"
        raise InputError(f"ExpressionLaw {expression.source[:60]!r} has {found}") from None
    if value != 0:
        raise InputError(
            f"ExpressionLaw {expression.source[:60]!r} has phi(0) = {float(value):.6g}; a law must vanish at 0: "
            "measure sigma and phi from the equilibrium"
        )


def _smooth_enough(node: Node) -> bool:
    """Whether a formula is visibly locally Lipschitz on the whole line."""
    if not isinstance(node, Apply):
        return True
    if node.operation in ("/", "**"):
        first, last = node.arguments
        if not isinstance(last, Number):
            return False
        fits = last.value != 0 if node.operation == "/" else last.value >= 1 and last.value.denominator == 1
        return fits and _smooth_enough(first)
    return node.operation in _LIPSCHITZ and all(_smooth_enough(part) for part in node.arguments)
