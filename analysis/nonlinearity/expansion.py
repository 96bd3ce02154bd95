"""A tree expanded near an end of its interval: 0, another finite point, or infinity."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

from flint import arb, arb_series

from lure.analysis.nonlinearity.jets import NOTHING, Span, inside_sech_square, sech_square_series, tanh_series
from lure.analysis.nonlinearity.rational import Candidate, Cover, End, bounds_of
from lure.analysis.nonlinearity.result import Bound
from lure.expressions.rigorous import ball
from lure.expressions.tree import Apply, Node, Number
from lure.record import described, quantity

# What an expansion lies between on its stretch, and where it tends.


def enclosure_at_end(m: Expansion, stretch: Stretch, end: End, side: int) -> tuple[Cover, Candidate | None]:
    """What an expansion lies between on its stretch, and its limit as ``t -> 0`` where it has one."""
    low, high, limit = _enclosure(stretch.settled(m), stretch)
    found = None if limit is None else Candidate(value=limit, place=end, inside=False, side=side)
    return Cover(low=low, high=high), found


def _enclosure(m: Expansion, stretch: Stretch) -> tuple[Bound, Bound, Bound | tuple[Fraction, Fraction] | None]:
    lead = m.lead
    if m.growth is not None or lead < 0:
        sign = stretch.sign(m)
        if not sign:
            return -math.inf, math.inf, None
        least = max(bounds_of(_smallest(m, stretch))[0], Fraction(0))
        limit = sign * math.inf if m.growth is not None or lead in m.terms else None
        return (least, math.inf, limit) if sign > 0 else (-math.inf, -least, limit)
    constant = m.terms.get(Fraction(0), arb(0))
    rest = m.without_constant
    c_low, c_high = bounds_of(constant)
    known = (
        c_low if c_low == c_high or not isinstance(c_low, Fraction) or isinstance(c_high, float) else (c_low, c_high)
    )
    if rest.is_zero:
        return c_low, c_high, known
    span = stretch.hull(rest, rest.lead) * stretch.upto(rest.lead)
    low, high = bounds_of(span.low)[0], bounds_of(span.high)[1]
    return _sum(c_low, low), _sum(c_high, high), known if rest.lead > 0 else None


def _sum(first: Bound, second: Bound) -> Bound:
    """The sum of two lower or two upper bounds; with an infinite one a number beyond all doubles is not converted."""
    for bound in (first, second):
        if isinstance(bound, float):
            return bound
    return first + second


def _smallest(m: Expansion, stretch: Stretch) -> arb:
    """A lower bound of ``|m|`` for an expansion that grows without bound."""
    size = stretch.hull(m, m.lead).size.low
    if m.growth is None:
        return size * stretch.power(m.lead).low
    rate, power = stretch.hull(m.growth, m.growth.lead).low, m.growth.lead
    far = stretch.power(power).low
    if rate * ball(-power) * far >= ball(m.lead):  # then exp(rate t^power) t^lead falls as t grows
        return size * stretch.power(m.lead).low * (rate * far).exp()
    return arb(0)


# Functions near an end of an interval: finitely many powers of a small ``t`` and a rest enclosed for all of them.

ORDER = 8
MOST_TERMS = 24
_ZERO = Fraction(0)


class Unsettled(Exception):
    """Nothing could be shown on this stretch; a shorter one may do."""


@described(frozen=True, slots=True)
class Expansion:
    """``exp(growth) (sum_e c_e t^e + t^order rest)`` for every ``t`` in ``(0, tau]``."""

    terms: Mapping[Fraction, arb] = quantity(
        "Coefficients ``c_e`` of the powers below ``order``, none of them exactly 0"
    )
    order: Fraction = quantity("The power of the rest")
    rest: Span = quantity("Encloses the rest over the whole stretch")
    growth: Expansion | None = quantity("Tends to an infinity; None for no such factor", default=None)

    @property
    def lead(self) -> Fraction:
        """The lowest power."""
        return min(self.terms, default=self.order)

    @property
    def is_zero(self) -> bool:
        """Whether the function is 0."""
        return not self.terms and self.rest.is_zero

    @property
    def plain(self) -> Expansion:
        """The function without its growth."""
        return replace(self, growth=None)

    @property
    def without_constant(self) -> Expansion:
        """The function less the coefficient of ``t^0``."""
        return replace(self, terms={e: c for e, c in self.terms.items() if e != 0})


@dataclass(frozen=True, slots=True)
class Stretch:
    """The arithmetic of expansions for ``0 < t <= tau``; ``tau < 1`` is a power of two."""

    tau: arb

    def power(self, exponent: Fraction) -> Span:
        """``tau^exponent``."""
        return Span.of(self.tau ** ball(exponent))

    def upto(self, exponent: Fraction) -> Span:
        """What ``t^exponent`` lies in, ``exponent >= 0``."""
        return Span(arb(1), arb(1)) if exponent == 0 else Span(arb(0), self.power(exponent).high)

    def hull(self, m: Expansion, shift: Fraction) -> Span:
        """What ``t^(-shift) m`` lies in, without its growth; ``shift`` is at most the lowest power."""
        total, power = m.rest, m.order
        for exponent in sorted(m.terms, reverse=True):  # nested, so that the sign of the first term settles the others
            total = Span.of(m.terms[exponent]) + (total if total.is_zero else total * self.upto(power - exponent))
            power = exponent
        return total * self.upto(power - shift)

    def sign(self, m: Expansion) -> int | None:
        """The sign for every ``t``, None if it is not known."""
        return 0 if m.is_zero else self.hull(m, m.lead).sign

    def tidy(self, terms: Mapping[Fraction, arb], order: Fraction, rest: Span) -> Expansion:
        """An expansion cut to the powers worth keeping; the others go to the rest."""
        if not rest.is_finite or not all(c.is_finite() for c in terms.values()):
            raise Unsettled
        kept = {e: c for e, c in sorted(terms.items()) if not bool(c == 0)}  # c != 0 is False for a ball that may be 0
        if kept:
            powers = list(kept)
            last = powers[0] + ORDER
            if len(powers) > MOST_TERMS:
                last = min(last, powers[MOST_TERMS])
            if rest.is_zero:
                order = last
            elif last < order:
                rest, order = rest * self.upto(order - last), last
        for exponent in [e for e in kept if e >= order]:
            rest += Span.of(kept.pop(exponent)) * self.upto(exponent - order)
        return Expansion(kept, order, rest)

    def constant(self, value: arb) -> Expansion:
        """A constant."""
        return self.tidy({_ZERO: value}, Fraction(ORDER), NOTHING)

    def within(self, rest: Span, order: Fraction = _ZERO) -> Expansion:
        """``t^order`` times something of which only an enclosure is known."""
        return self.tidy({}, order, rest)

    def add(self, f: Expansion, g: Expansion) -> Expansion:
        """The sum."""
        if f.is_zero or g.is_zero:
            return g if f.is_zero else f
        if f.growth is None and g.growth is None:
            return self._plain_sum(f, g)
        ratio = self._ratio(g.growth, f.growth)
        if not ratio.is_zero and ratio.lead < 0 and self.sign(ratio) == 1:
            f, g, ratio = g, f, self.negated(ratio)
        small = self.settled(self.grown(g.plain, ratio))
        if small.growth is not None:
            raise Unsettled
        return replace(self._plain_sum(f.plain, small), growth=f.growth)

    def _ratio(self, top: Expansion | None, bottom: Expansion | None) -> Expansion:
        """``top - bottom``, None standing for 0."""
        if bottom is None:
            assert top is not None, "one of them grows"
            return top
        return self.negated(bottom) if top is None else self._plain_sum(top, self.negated(bottom))

    def negated(self, f: Expansion) -> Expansion:
        """``-f``."""
        return replace(f, terms={e: -c for e, c in f.terms.items()}, rest=-f.rest)

    def multiply(self, f: Expansion, g: Expansion) -> Expansion:
        """The product."""
        if f.is_zero or g.is_zero:
            return self.constant(arb(0))
        order = min(f.lead + g.order, g.lead + f.order)
        terms: dict[Fraction, arb] = {}
        rest = NOTHING
        for ef, cf in f.terms.items():
            for eg, cg in g.terms.items():
                if ef + eg < order:
                    terms[ef + eg] = terms.get(ef + eg, arb(0)) + cf * cg
                else:
                    rest += Span.of(cf * cg) * self.upto(ef + eg - order)
        if not g.rest.is_zero:
            rest += self.hull(f, f.lead) * g.rest * self.upto(f.lead + g.order - order)
        if not f.rest.is_zero and g.terms:
            known = Expansion(g.terms, g.order, NOTHING)
            rest += self.hull(known, known.lead) * f.rest * self.upto(known.lead + f.order - order)
        product = self.tidy(terms, order, rest)
        if f.growth is not None and g.growth is not None:
            return self.grown(product, self._plain_sum(f.growth, g.growth))
        return replace(product, growth=f.growth or g.growth)

    def grown(self, f: Expansion, growth: Expansion) -> Expansion:
        """``exp(growth) f`` for any ``growth`` that is bounded or tends to an infinity."""
        if growth.is_zero:
            return f
        if growth.lead >= 0:
            return self.multiply(f, self.composed(growth, arb_series.exp))
        large = {e: c for e, c in growth.terms.items() if e < 0}
        if growth.order < 0:
            raise Unsettled
        bounded = replace(growth, terms={e: c for e, c in growth.terms.items() if e >= 0})
        if not bounded.is_zero:
            f = self.multiply(f, self.composed(bounded, arb_series.exp))
        return replace(f, growth=Expansion(large, Fraction(ORDER), NOTHING))

    def settled(self, f: Expansion) -> Expansion:
        """The same with no factor that tends to 0 faster than every power: it goes to the rest."""
        if f.growth is None:
            return f
        sign = self.sign(f.growth)
        if sign is None:
            raise Unsettled
        if sign > 0:
            return f
        rate, fall = -self.hull(f.growth, f.growth.lead).high, -f.growth.lead
        power = ORDER - min(f.lead, _ZERO)
        # y^(power/fall) exp(-rate y), y = t^(-fall) >= tau^(-fall), is largest at peak, or at the end if that is later
        peak, end = (ball(power / fall) / rate).upper(), self.power(-fall)
        top = peak.max(end.high)
        most = (top ** ball(power / fall) * (-rate * peak.max(end.low)).exp()).upper() if end.low >= peak else None
        if most is None:
            most = (peak ** ball(power / fall) * (-rate * (ball(power / fall) / rate).lower()).exp()).upper()
        return self.multiply(f.plain, self.within(Span(arb(0), most), power))

    def exponential(self, f: Expansion) -> Expansion:
        """``exp(f)``."""
        f = self.settled(f)
        if f.growth is not None:  # f <= -c exp(growth) <= -c growth^2/2
            c = -self.hull(f, f.lead).high
            if not c > 0 or f.lead > 0:
                raise Unsettled
            faster = self.multiply(self.multiply(f.growth, f.growth), self.constant(-c / 2))
            return self.multiply(self.within(Span(arb(0), arb(1))), self.grown(self.constant(arb(1)), faster))
        if f.order < 0:
            raise Unsettled
        return self.grown(self.constant(arb(1)), f)

    def composed(self, f: Expansion, function: Callable[[arb_series], arb_series]) -> Expansion:
        """``function(f)`` for a bounded ``f`` and a function analytic around its values."""
        f = self.settled(f)
        if f.growth is not None or f.lead < 0:
            raise Unsettled
        if f.order == 0:
            return self.within(Span.of(_series(function, self.hull(f, _ZERO).ball, 1)[0]))
        centre = f.terms.get(_ZERO, arb(0))
        rest = f.without_constant
        if rest.is_zero:
            return self.constant(_series(function, centre, 1)[0])
        length = max(1, min(ORDER, math.ceil(ORDER / rest.lead)))
        known = _series(function, centre, length)
        around = (Span.of(centre) + self.hull(rest, _ZERO)).ball
        result = self.within(Span.of(_series(function, around, length + 1)[length]))
        for k in reversed(range(length)):
            result = self.add(self.multiply(result, rest), self.constant(known[k]))
        return result

    def raised(self, f: Expansion, exponent: Fraction) -> Expansion:
        """``f**exponent``; for a broken exponent ``f`` must be positive."""
        if exponent == 0:
            return self.constant(arb(1))
        if f.is_zero:
            if exponent < 0:
                raise Unsettled
            return f
        held, lead = self.hull(f, f.lead), f.lead
        if held.sign is None or (exponent.denominator != 1 and held.sign < 0):
            return self._repeated(f, exponent)
        p = ball(exponent)
        sign = -1 if held.sign < 0 and exponent.numerator % 2 else 1
        if lead not in f.terms:
            size = held.size.power(p)
            plain = self.within(size if sign > 0 else -size, lead * exponent)
        else:
            first = f.terms[lead]
            ratio = self.multiply(f.plain, self.tidy({-lead: 1 / first}, ORDER - lead, NOTHING))
            ratio = replace(ratio, terms={**ratio.terms, _ZERO: arb(1)})  # the same first / first, known exactly
            unit = self.composed(ratio, lambda s: (s.log() * arb_series([p], s.prec)).exp())
            size_ = self.tidy({lead * exponent: sign * abs(first) ** p}, lead * exponent + ORDER, NOTHING)
            plain = self.multiply(unit, size_)
        if f.growth is None:
            return plain
        return self.grown(plain, self.multiply(f.growth, self.constant(p)))

    def _repeated(self, f: Expansion, exponent: Fraction) -> Expansion:
        if exponent.denominator != 1 or exponent < 0:
            raise Unsettled
        result = f
        for _ in range(exponent.numerator - 1):
            result = self.multiply(result, f)
        return result

    def _plain_sum(self, f: Expansion, g: Expansion) -> Expansion:
        order = min((part.order for part in (f, g) if not part.rest.is_zero), default=max(f.order, g.order))
        rest = NOTHING
        for part in (f, g):
            if not part.rest.is_zero:
                rest += part.rest * self.upto(part.order - order)
        terms = dict(f.terms)
        for exponent, coefficient in g.terms.items():
            terms[exponent] = terms.get(exponent, arb(0)) + coefficient
        return self.tidy(terms, order, rest)


def _series(function: Callable[[arb_series], arb_series], centre: arb, length: int) -> list[arb]:
    try:
        found = function(arb_series([centre, arb(1)], length))
    except (ValueError, ZeroDivisionError):
        raise Unsettled from None
    return [found[k] for k in range(length)]


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
