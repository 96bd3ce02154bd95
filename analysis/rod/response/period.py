r"""Periods of loads that can be proved from their formulas.

.. math:: \sin(c_0 + c_1 t): \; 2\pi/|c_1|, \qquad f(u(t), v(t), \ldots): \; \text{least common multiple}.

A slope ``c_1`` is kept as a rational number times powers of ``pi`` and of other constants, such as ``sqrt(2)``; two
periods have a common multiple that is proved if those powers agree.  A period found so need not be the least one.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np

from lure.errors import InputError, demand_seconds
from lure.expressions import Expression
from lure.expressions.tree import Apply, Node, Number, names
from lure.rod.scenario import Scenario

_TURN = {"sin": 2, "cos": 2, "tan": 1}
_PI = Apply("pi", ())
_POINTS = 61
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
_AGREE = 1e-9
_MANY = 100


@dataclass(frozen=True, slots=True)
class _Monomial:
    """``factor`` times integer powers of constants that are not rational."""

    factor: Fraction
    powers: frozenset[tuple[Node, int]] = field(default_factory=frozenset)

    def times(self, other: _Monomial, sign: int = 1) -> _Monomial:
        """The product, or with ``sign = -1`` the quotient by ``other``, which is not zero."""
        powers: Counter[Node] = Counter(dict(self.powers))
        for node, power in other.powers:
            powers[node] += sign * power
        kept = frozenset((node, power) for node, power in powers.items() if power)
        return _Monomial(self.factor * other.factor**sign, kept)

    def value(self) -> float:
        """In double precision."""
        try:
            product = float(self.factor)
            for node, power in self.powers:
                product *= float(Expression(source="", variables=(), tree=node)()) ** power
        except (OverflowError, ZeroDivisionError):
            return math.inf
        return product


class _NotPeriodicError(Exception):
    """Why a formula is not seen to be periodic."""


def proved_period(formula: Expression) -> float | None:
    """A period in ``t`` that follows from the formula [s]; None if ``t`` does not occur.  It need not be the least.

    Parameters
    ----------
    formula : Expression
        A load; other variables than ``t`` count as constants.

    Raises
    ------
    InputError
        No period follows: one sentence with the reason.

    Examples
    --------
    >>> load = Expression.parse("1 + sin(2*pi*t/3)*abs(cos(pi*t/2))", variables=("t",))
    >>> proved_period(load)
    12.0
    """
    try:
        return _seconds(_period(formula.tree))
    except _NotPeriodicError as reason:
        raise InputError(
            f"no period of {str(formula)[:80]!r} follows from the formula, since {reason}; give the period if you "
            "know one"
        ) from None


def load_period(scenario: Scenario, given: float | None, otherwise: float) -> tuple[float, str]:
    """Period of the loads of a scenario [s], and where it comes from.

    Parameters
    ----------
    scenario : Scenario
        Its ``g`` and ``f``.
    given : float or None
        The user's word; at 61 times the formulas are compared with themselves 1 and 100 periods later, which is no
        proof.
    otherwise : float
        What to take if no load depends on ``t`` [s].

    Returns
    -------
    period : float
        The period [s].
    source : str
        ``"formula"``, ``"given"`` or ``"constant load"``.

    Raises
    ------
    InputError
        No period follows from the formulas and none is given, or the one given is not a period.
    """
    loads = {"force.g": scenario.force, "force.f": scenario.body_force}
    if given is not None:
        _check_given(loads, given)
        return float(given), "given"
    try:
        found = _seconds(_common(*(_period(load.tree) for load in loads.values())))
    except _NotPeriodicError:
        for load in loads.values():
            proved_period(load)  # says which of the two, and why
        raise InputError("force.g and force.f have no common period that can be proved; give the period") from None
    return (otherwise, "constant load") if found is None else (found, "formula")


def _check_given(loads: dict[str, Expression], period: float) -> None:
    demand_seconds("period", period)
    t = period * np.mod(_GOLDEN * np.arange(1, _POINTS + 1), 1.0)
    for name, load in loads.items():
        places = {"x": 0.0} if "x" in load.variables else {}
        now = load(t=t, **places)
        for count in (1, _MANY):
            later = load(t=t + count * period, **places)
            wrong = ~(np.abs(later - now) <= _AGREE * count * np.abs(now).max(initial=0.0))
            if wrong.any():
                i = int(np.argmax(wrong))
                raise InputError(
                    f"period is {period:g} s, but {name} is {now[i]:.6g} at t = {t[i]:.6g} s and {later[i]:.6g} after "
                    f"{count} of them; give a period of the load"
                )


def _seconds(period: _Monomial | None) -> float | None:
    value = None if period is None else abs(period.value())
    if value is not None and not 0.0 < value < math.inf:
        raise _NotPeriodicError(f"its period comes out as {value:g} s")
    return value


def _period(node: Node) -> _Monomial | None:
    if "t" not in names(node):
        return None
    if not isinstance(node, Apply):
        raise _NotPeriodicError("t appears outside sin, cos and tan")
    if node.operation in _TURN:
        slope = _slope(node.arguments[0])
        if slope is not None:
            turn = _Monomial(Fraction(_TURN[node.operation]), frozenset({(_PI, 1)}))
            return turn.times(slope, -1) if slope.factor else None
    return _common(*(_period(part) for part in node.arguments))


def _common(*periods: _Monomial | None) -> _Monomial | None:
    """Least common multiple; a constant has every period."""
    found: _Monomial | None = None
    for period in periods:
        if found is None or period is None:
            found = found or period
            continue
        if found.powers != period.powers:
            raise _NotPeriodicError(
                f"{abs(found.value()):.6g} s and {abs(period.value()):.6g} s have no common multiple that can be proved"
            )
        a, b = abs(found.factor), abs(period.factor)
        multiple = Fraction(math.lcm(a.numerator, b.numerator), math.gcd(a.denominator, b.denominator))
        found = _Monomial(multiple, found.powers)
    return found


def _slope(node: Node) -> _Monomial | None:
    """``c1`` if the node is ``c0 + c1 t`` with ``c1`` a constant; None if that is not seen."""
    if "t" not in names(node):
        return _Monomial(Fraction(0))
    if not isinstance(node, Apply):
        return _Monomial(Fraction(1))
    if node.operation == "neg":
        inner = _slope(node.arguments[0])
        return None if inner is None else _Monomial(-inner.factor, inner.powers)
    if node.operation not in ("+", "-", "*", "/"):
        return None
    left, right = node.arguments
    if node.operation in ("*", "/"):
        part, constant = (right, left) if node.operation == "*" and "t" not in names(left) else (left, right)
        inner = None if names(constant) else _slope(part)
        if inner is None:
            return None
        scale = _constant(constant)
        return inner.times(scale, 1 if node.operation == "*" else -1) if scale.factor else None
    first, second = _slope(left), _slope(right)
    if first is None or second is None:
        return None
    if not first.factor or not second.factor or first.powers == second.powers:
        sign = 1 if node.operation == "+" else -1
        total = first.factor + sign * second.factor
        return _Monomial(total, first.powers if first.factor else second.powers)
    return None


def _constant(node: Node) -> _Monomial:
    """A node without variables, its rational factors and powers taken out."""
    if isinstance(node, Number):
        return _Monomial(node.value)
    assert isinstance(node, Apply), "a constant has no variables"
    if node.operation == "neg":
        inner = _constant(node.arguments[0])
        return _Monomial(-inner.factor, inner.powers)
    if node.operation in ("*", "/"):
        first, second = (_constant(part) for part in node.arguments)
        if node.operation == "*" or second.factor:
            return first.times(second, 1 if node.operation == "*" else -1)
    return _Monomial(Fraction(1), frozenset({(node, 1)}))
