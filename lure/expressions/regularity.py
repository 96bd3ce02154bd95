"""Whether a formula visibly has a value everywhere, is continuous, is locally Lipschitz: read off its operations."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import TYPE_CHECKING, TypeAlias

from lure.expressions.rigorous import enclosure, truth
from lure.expressions.tree import COMPARISONS, Apply, Node, Number, Variable
from lure.record import described, quantity

if TYPE_CHECKING:
    from flint import arb

# Where a formula certainly has a value: every operation looked at, also inside conditions and behind a factor 0.


def has_value(node: Node, point: Mapping[str, arb]) -> bool:
    """Whether a formula certainly has a value at every point of the given balls; False means that it was not seen.

    A condition needs a value on both of its sides; ``and`` and ``or`` stop at the first part that decides, and of the
    branches of ``where`` only the one taken counts.

    ``point``: a ball for each variable.
    """
    if not isinstance(node, Apply) or node.total:
        return True
    name, parts = node.operation, node.arguments
    if name == "where":
        if not has_value(parts[0], point):
            return False
        decided = truth(parts[0], point)
        taken = parts[1:] if decided is None else (parts[1 if decided else 2],)
        return all(has_value(part, point) for part in taken)
    if name in ("and", "or"):
        for part in parts:
            if not has_value(part, point):
                return False
            if truth(part, point) is (name == "or"):
                return True
        return True
    if not all(has_value(part, point) for part in parts):
        return False
    if name == "/":
        return _nonzero(enclosure(parts[1], point))
    if name == "**":
        return _power(enclosure(parts[0], point), parts[1])
    return name not in _NEEDS or _NEEDS[name](enclosure(parts[0], point))


def _nonzero(value: arb) -> bool:
    return bool(value > 0 or value < 0)


def _power(base: arb, exponent: Node) -> bool:
    assert isinstance(exponent, Number), "the parser and the derivative make only constant exponents"
    if exponent.value.denominator == 1:
        return exponent.value >= 0 or _nonzero(base)
    return bool(base > 0 or (base >= 0 and exponent.value > 0))


_NEEDS: dict[str, Callable[[arb], bool]] = {
    "log": lambda u: bool(u > 0),
    "sqrt": lambda u: bool(u >= 0),
    "tan": lambda u: _nonzero(u.cos()),
}


End: TypeAlias = Fraction | float
_MAX_BITS = 4096
_ZERO, _ONE = Fraction(0), Fraction(1)


@described(frozen=True, kw_only=True, slots=True)
class Nature:
    """What is visible of a formula, from what its variables lie between."""

    low: End = quantity("The values lie in ``[low, high]``, wherever there are any")
    high: End
    low_open: bool = quantity("Whether the end is known not to be taken", default=False)
    high_open: bool = False
    continuous: bool = quantity("Whether the formula is visibly continuous", default=True)
    lipschitz: bool = quantity(
        "Whether it is visibly locally Lipschitz: on every bounded set the difference quotients are bounded",
        default=True,
    )
    total: bool = quantity(
        "Whether the formula visibly has a value everywhere; without that nothing is said but the bounds", default=True
    )

    @property
    def positive(self) -> bool:
        """Whether every value is positive."""
        return self.low > 0 or (self.low == 0 and self.low_open)

    @property
    def nonzero(self) -> bool:
        """Whether no value is 0."""
        return self.positive or self.negated.positive

    @property
    def negated(self) -> Nature:
        """That of the formula times -1."""
        return replace(self, low=-self.high, high=-self.low, low_open=self.high_open, high_open=self.low_open)


def nature(node: Node) -> Nature | None:
    """What is visible of a formula; None if it may have no value somewhere.

    Notes
    -----
    Sums, products, ``abs``, ``min``, ``max``, ``sin``, ``cos``, ``exp``, ``tanh``, ``atan`` and whole powers of locally
    Lipschitz functions are locally Lipschitz; so are quotients whose denominator is bounded away from 0 or visibly of
    one strict sign, ``sqrt``, ``log`` and broken powers of what is positive, and powers above 1 of what is not
    negative.  ``sqrt`` and powers between 0 and 1 of what may be 0 are continuous only.  ``sign`` and ``where`` may
    jump; nothing is said of them here.

    Examples
    --------
    >>> from lure.expressions.parser import parse
    >>> found = nature(parse("x/(1 + x**2)", variables=("x",), field="f"))
    >>> found.lipschitz
    True
    >>> nature(parse("x/(1 - x**2)", variables=("x",), field="f")) is None
    True
    """
    found = _nature(node, Nature(low=-math.inf, high=math.inf))
    return found if found.total else None


_SMOOTH = ("+", "-", "*", "/", "**", "neg", "sin", "cos", "tan", "exp", "log", "sqrt", "tanh", "atan", "pi")


def smooth(node: Node) -> bool:
    """Whether a formula is made of functions alone that are smooth wherever they and their derivatives have values."""
    return not isinstance(node, Apply) or (node.operation in _SMOOTH and all(map(smooth, node.arguments)))


def hull(node: Node, low: End, high: End) -> tuple[End, End]:
    """Bounds of every value that a formula has for a variable between two ends; infinite where its form says nothing.

    ``node``: the tree of the formula, in one variable; ``low``, ``high``: the ends, infinite ones too.

    Examples
    --------
    >>> from lure.expressions.parser import parse
    >>> list(map(str, hull(parse("1 + sin(5*x)", variables=("x",), field="f"), Fraction(0), Fraction(1))))
    ['0', '2']
    """
    found = _nature(node, Nature(low=low, high=high))
    return found.low, found.high


def _nature(node: Node, variable: Nature) -> Nature:
    if isinstance(node, Number):
        return Nature(low=node.value, high=node.value)
    if isinstance(node, Variable):
        return variable
    if node.operation == "pi":
        return Nature(low=Fraction(3), high=Fraction(4))
    if node.operation == "where":
        return _where(node, variable)
    if node.operation == "**":
        exponent = node.arguments[1]
        assert isinstance(exponent, Number), "the parser and the derivative make only constant exponents"
        return _regularity_power(_nature(node.arguments[0], variable), exponent.value)
    parts = [_nature(part, variable) for part in node.arguments]
    if node.operation == "*" and node.arguments[0] == node.arguments[1]:
        return _regularity_power(parts[0], Fraction(2))
    found = _RULES[node.operation](*parts)
    return replace(
        found,
        continuous=found.continuous and all(part.continuous for part in parts),
        lipschitz=found.lipschitz and all(part.lipschitz for part in parts),
        total=found.total and all(part.total for part in parts),
    )


def _where(node: Apply, variable: Nature) -> Nature:
    condition, *branches = node.arguments
    u, v = (_nature(part, variable) for part in branches)
    steady = u.continuous and v.continuous and branches[0] == branches[1]
    total = u.total and v.total and _decided(condition, variable)
    return replace(_hull(u, v), continuous=steady, lipschitz=steady and u.lipschitz, total=total)


def _decided(condition: Node, variable: Nature) -> bool:
    """Whether a condition is visibly true or false everywhere."""
    assert isinstance(condition, Apply), "the parser lets only comparisons and their combinations be conditions"
    if condition.operation in COMPARISONS:
        return all(_nature(part, variable).total for part in condition.arguments)
    return all(_decided(part, variable) for part in condition.arguments)


def _hull(u: Nature, v: Nature) -> Nature:
    low, high = min(u.low, v.low), max(u.high, v.high)
    return Nature(
        low=low,
        high=high,
        low_open=all(part.low_open or part.low > low for part in (u, v)),
        high_open=all(part.high_open or part.high < high for part in (u, v)),
    )


def _sum(u: Nature, v: Nature) -> Nature:
    return Nature(
        low=_bounded(_plus(u.low, v.low), -math.inf),
        high=_bounded(_plus(u.high, v.high), math.inf),
        low_open=u.low_open or v.low_open,
        high_open=u.high_open or v.high_open,
    )


def _product(u: Nature, v: Nature) -> Nature:
    ends = [
        (_times(a, b), (a_open and not (b == 0 and not b_open)) or (b_open and not (a == 0 and not a_open)))
        for (a, a_open), (b, b_open) in product(
            ((u.low, u.low_open), (u.high, u.high_open)), ((v.low, v.low_open), (v.high, v.high_open))
        )
    ]
    low, high = min(value for value, _ in ends), max(value for value, _ in ends)
    return Nature(
        low=_bounded(low, -math.inf),
        high=_bounded(high, math.inf),
        low_open=all(is_open for value, is_open in ends if value == low),
        high_open=all(is_open for value, is_open in ends if value == high),
    )


def _times(a: End, b: End) -> End:
    """The product, where 0 times an infinity is 0; a Fraction is not made a float, which could overflow."""
    if a == 0 or b == 0:
        return _ZERO
    if isinstance(a, float) or isinstance(b, float):
        return math.inf if (a > 0) == (b > 0) else -math.inf
    return a * b


def _plus(a: End, b: End) -> End:
    return a if isinstance(a, float) else b if isinstance(b, float) else a + b


def _quotient(u: Nature, v: Nature) -> Nature:
    inverse = _inverse(v)
    return replace(_product(u, inverse), total=inverse.total)


def _inverse(v: Nature) -> Nature:
    if v.high <= 0 and v.low < 0:
        return _inverse(v.negated).negated
    if v.low < 0 or v.high == 0:
        return replace(_ANY, total=False)
    return replace(
        v,
        low=_ZERO if isinstance(v.high, float) else 1 / v.high,
        low_open=v.high_open or isinstance(v.high, float),
        high=math.inf if v.low == 0 else 1 / Fraction(v.low),
        high_open=v.low_open,
        total=v.total and v.positive,
    )


def _regularity_power(base: Nature, exponent: Fraction) -> Nature:
    """``base**exponent``, for any rational exponent."""
    if exponent < 0:
        return _inverse(_regularity_power(base, -exponent))
    if exponent == 0:
        return replace(base, low=_ONE, high=_ONE, low_open=False, high_open=False)
    if exponent.denominator == 1:
        inner = _absolute(base) if exponent.numerator % 2 == 0 else base
        return replace(
            base,
            low=_raised(inner.low, exponent.numerator, -math.inf),
            high=_raised(inner.high, exponent.numerator, math.inf),
            low_open=inner.low_open and (inner.low == 0 or exponent == 1),
            high_open=False,
        )
    smooth = exponent >= 1 or base.positive
    floor, ceiling = (_ONE if base.low >= 1 else _ZERO), (base.high if exponent < 1 else math.inf)
    return replace(
        base,
        low=floor,
        high=_ONE if base.high <= 1 else ceiling,
        low_open=floor == 0 and base.positive,
        high_open=False,
        lipschitz=base.lipschitz and smooth,
        total=base.total and base.low >= 0,
    )


def _raised(end: End, exponent: int, outwards: float) -> End:
    if isinstance(end, float):
        return end if end > 0 or exponent % 2 else -end
    size = max(end.numerator.bit_length(), end.denominator.bit_length()) * exponent
    if size <= _MAX_BITS:
        return Fraction(end**exponent)
    return outwards if outwards > 0 or end < 0 else _ZERO


def _bounded(end: End, outwards: float) -> End:
    """The end, or the infinity outside it where its digits would grow without limit."""
    if isinstance(end, float) or max(end.numerator.bit_length(), end.denominator.bit_length()) <= _MAX_BITS:
        return end
    return outwards


def _absolute(u: Nature) -> Nature:
    if u.low >= 0:
        return u
    if u.high <= 0:
        return u.negated
    return replace(u, low=_ZERO, low_open=u.nonzero, high=max(-u.low, u.high), high_open=False)


def _smaller(u: Nature, v: Nature) -> Nature:
    return _larger(u.negated, v.negated).negated


def _larger(u: Nature, v: Nature) -> Nature:
    """``max(u, v)``."""
    low = max(u.low, v.low)
    return replace(_hull(u, v), low=low, low_open=any(part.low == low and part.low_open for part in (u, v)))


def _monotone(bound: Fraction) -> Callable[[Nature], Nature]:
    """An increasing odd function with values between ``-bound`` and ``bound``, neither taken."""

    def applied(u: Nature) -> Nature:
        """Only its sign is carried over."""
        low = (-bound, True) if u.low < 0 else (_ZERO, u.positive)
        high = (bound, True) if u.high > 0 else (_ZERO, u.negated.positive)
        return Nature(low=low[0], low_open=low[1], high=high[0], high_open=high[1])

    return applied


def _exponential(u: Nature) -> Nature:
    return Nature(low=_ONE if u.low >= 0 else _ZERO, low_open=u.low < 0, high=_ONE if u.high <= 0 else math.inf)


def _logarithm(u: Nature) -> Nature:
    low, high = (_ZERO if u.low >= 1 else -math.inf), (_ZERO if u.high <= 1 else math.inf)
    return Nature(low=low, high=high, total=u.positive)


def _tangent(u: Nature) -> Nature:
    """``tan`` between -3/2 and 3/2, where it has no pole."""
    if u.low < Fraction(-3, 2) or u.high > Fraction(3, 2):
        return replace(_ANY, total=False)
    return _monotone(Fraction(15))(u)  # tan(3/2) = 14.1


def _sign(u: Nature) -> Nature:
    low = _ONE if u.positive else _ZERO if u.low >= 0 else -_ONE
    high = -_ONE if u.negated.positive else _ZERO if u.high <= 0 else _ONE
    return Nature(low=low, high=high, continuous=low == high, lipschitz=low == high)


_ANY = Nature(low=-math.inf, high=math.inf)
_UNIT = Nature(low=-_ONE, high=_ONE)
_RULES: dict[str, Callable[..., Nature]] = {
    "+": _sum,
    "-": lambda u, v: _sum(u, v.negated),
    "*": _product,
    "/": _quotient,
    "neg": lambda u: u.negated,
    "abs": _absolute,
    "min": _smaller,
    "max": _larger,
    "sin": lambda u: _UNIT,
    "cos": lambda u: _UNIT,
    "tanh": _monotone(_ONE),
    "atan": _monotone(Fraction(2)),
    "exp": _exponential,
    "log": _logarithm,
    "tan": _tangent,
    "sqrt": lambda u: _regularity_power(u, Fraction(1, 2)),
    "sign": _sign,
}
