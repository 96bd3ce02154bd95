"""A tree expanded near an end of its interval: 0, another finite point, or infinity."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from flint import arb, arb_series

from analysis.bounds.expansion import ORDER, Expansion, Stretch, Unsettled
from analysis.bounds.extremes import End
from analysis.bounds.series import inside_sech_square, sech_square_series, tanh_series
from analysis.bounds.span import NOTHING, Span
from lure.expressions.balls import ball
from lure.expressions.tree import Apply, Node, Number

_LOG_POWER = Fraction(1, 8)
_UNIT = Span(arb(-1), arb(1))
_ANALYTIC: dict[str, Callable[[arb_series], arb_series]] = {
    "sin": arb_series.sin,
    "cos": arb_series.cos,
    "tan": arb_series.tan,
    "atan": arb_series.atan,
}


def expanded(node: Node, end: End, side: int, stretch: Stretch) -> Expansion:
    """The tree at ``sigma = end + side t``, or ``sigma = 1/t`` or ``-1/t`` for an infinite end.

    Parameters
    ----------
    node : Node
        A formula in one variable.
    end : Fraction, or an infinity
        The end of the interval.
    side : int
        1 if the interval lies right of a finite end, -1 if left.
    stretch : Stretch
        The ``t`` for which the expansion holds.

    Raises
    ------
    Unsettled
        Some operation is not known to be defined, or cannot be expanded, for these ``t``.
    """
    if isinstance(end, Fraction):
        terms = {Fraction(0): ball(end), Fraction(1): arb(side)}
    else:
        terms = {Fraction(-1): arb(1 if end > 0 else -1)}
    variable = stretch.tidy(terms, min(terms) + ORDER, NOTHING)
    return _Walk(stretch, variable).value(node)


class _Walk:
    """One evaluation of a tree."""

    def __init__(self, stretch: Stretch, variable: Expansion) -> None:
        self.s, self.variable = stretch, variable
        self.known: dict[int, Expansion] = {}

    def value(self, node: Node) -> Expansion:
        """The expansion of a tree; shared parts are expanded once."""
        if isinstance(node, Number):
            return self.s.constant(ball(node.value))
        if not isinstance(node, Apply):
            return self.variable
        if id(node) not in self.known:
            self.known[id(node)] = self._applied(node)
        return self.known[id(node)]

    def _applied(self, node: Apply) -> Expansion:
        s, name = self.s, node.operation
        if name == "pi":
            return s.constant(arb.pi())
        if name == "where":
            decided = self._truth(node.arguments[0])
            if decided is None:
                return self._either(*(self.value(part) for part in node.arguments[1:]))
            return self.value(node.arguments[1 if decided else 2])
        if name == "**":
            exponent = node.arguments[1]
            assert isinstance(exponent, Number), "the parser and the derivative make only constant exponents"
            return s.raised(self.value(node.arguments[0]), exponent.value)
        inner = inside_sech_square(node)
        if inner is not None:
            return self._sech_square(self.value(inner))
        parts = [self.value(part) for part in node.arguments]
        match name:
            case "+":
                return s.add(*parts)
            case "-":
                return s.add(parts[0], s.negated(parts[1]))
            case "*":
                return s.multiply(*parts)
            case "/":
                return s.multiply(parts[0], s.raised(parts[1], Fraction(-1)))
            case "neg":
                return s.negated(parts[0])
            case "min" | "max":
                sign = s.sign(s.add(parts[0], s.negated(parts[1])))
                if sign is None:
                    return self._either(*parts)
                return parts[0] if (sign >= 0) == (name == "max") else parts[1]
            case "abs" | "sign":
                return self._side(name, parts[0])
            case _:
                return self._function(name, parts[0])

    def _side(self, name: str, u: Expansion) -> Expansion:
        sign = self.s.sign(u)
        if sign is None:
            if name == "sign":
                return self.s.within(_UNIT)
            return self._either(u, self.s.negated(u))
        if name == "sign":
            return self.s.constant(arb(sign))
        return u if sign >= 0 else self.s.negated(u)

    def _function(self, name: str, u: Expansion) -> Expansion:
        s = self.s
        if name == "exp":
            return s.exponential(u)
        if name == "sqrt":
            return s.raised(u, Fraction(1, 2))
        if name == "log":
            return self._log(u)
        if name == "tanh":
            return self._tanh(u)
        u = s.settled(u)
        if u.growth is not None or u.lead < 0:
            if name in ("sin", "cos"):
                return s.within(_UNIT)
            sign = s.sign(u) if name == "atan" else None
            if sign is None:
                raise Unsettled
            inverse = s.composed(s.raised(u, Fraction(-1)), arb_series.atan)
            return s.add(s.constant(sign * arb.pi() / 2), s.negated(inverse))
        return s.composed(u, _ANALYTIC[name])

    def _tanh(self, u: Expansion) -> Expansion:
        s, small = self.s, self._small(u)
        if small is None:
            return s.composed(u, tanh_series)
        sign = s.sign(u)
        assert sign is not None, "a large argument has a sign"
        away = s.multiply(small, s.raised(s.add(s.constant(arb(1)), small), Fraction(-1)))
        return s.add(s.constant(arb(sign)), s.multiply(away, s.constant(arb(-2 * sign))))

    def _sech_square(self, u: Expansion) -> Expansion:
        """``1 - tanh(u)^2 = 4 e/(1 + e)^2`` with ``e = exp(-2 |u|)``, without its cancellation."""
        s, small = self.s, self._small(u)
        if small is None:
            return s.composed(u, sech_square_series)
        return s.multiply(
            s.multiply(small, s.constant(arb(4))), s.raised(s.add(s.constant(arb(1)), small), Fraction(-2))
        )

    def _small(self, u: Expansion) -> Expansion | None:
        """``exp(-2 |u|)`` for an unbounded argument, enclosed; None for a bounded one."""
        s, u = self.s, self.s.settled(u)
        if u.growth is None and u.lead >= 0:
            return None
        sign = s.sign(u)
        if not sign:
            raise Unsettled
        return s.exponential(s.multiply(u, s.constant(arb(-2 * sign))))

    def _log(self, u: Expansion) -> Expansion:
        s, lead = self.s, u.lead
        held = s.hull(u, lead)
        if held.sign != 1:
            raise Unsettled
        if lead == 0 and u.growth is None:
            return s.composed(u, arb_series.log)
        plain = s.within(Span(held.low.log().lower(), held.high.log().upper()))
        if lead != 0:  # 0 <= -log t <= 8/e t^(-1/8)
            size = Span(arb(0), (1 / (ball(_LOG_POWER) * arb(1).exp())).upper())
            plain = s.add(plain, s.within(Span.of(-ball(lead)) * size, -_LOG_POWER))
        return plain if u.growth is None else s.add(u.growth, plain)

    def _either(self, u: Expansion, v: Expansion) -> Expansion:
        """What both lie in."""
        u, v = self.s.settled(u), self.s.settled(v)
        if u.growth is not None or v.growth is not None:
            raise Unsettled
        lead = min(u.lead, v.lead)
        return self.s.within(self.s.hull(u, lead).joined(self.s.hull(v, lead)), lead)

    def _truth(self, condition: Node) -> bool | None:
        assert isinstance(condition, Apply), "the parser lets only comparisons and their combinations be conditions"
        name = condition.operation
        if name in ("and", "or", "not"):
            parts = [self._truth(part) for part in condition.arguments]
            if name == "not":
                return None if parts[0] is None else not parts[0]
            deciding = name == "or"
            return deciding if deciding in parts else None if None in parts else not deciding
        left, right = (self.value(part) for part in condition.arguments)
        sign = self.s.sign(self.s.add(left, self.s.negated(right)))
        if sign is None:
            return None
        return {
            "<": sign < 0,
            "<=": sign <= 0,
            ">": sign > 0,
            ">=": sign >= 0,
            "==": sign == 0,
            "!=": sign != 0,
        }[name]
