"""Whether a formula visibly has a value everywhere, is continuous, is locally Lipschitz: read off its operations."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product
from typing import TYPE_CHECKING, TypeAlias

from lure.expressions.rigorous import enclosure, truth
from lure.expressions.tree import COMPARISONS, Apply, Node, Number, Variable

if TYPE_CHECKING:
    from flint import arb

# Where a formula certainly has a value: every operation looked at, also inside conditions and behind a factor 0.


def has_value(node: Node, point: Mapping[str, arb]) -> bool:
    """Whether a formula certainly has a value at every point of the given balls; False means that it was not seen.

    A condition needs a value on both of its sides; ``and`` and ``or`` stop at the first part that decides, and of the
    branches of ``where`` only the one taken counts.

    Parameters
    ----------
    node : Node
        The tree of the formula.
    point : Mapping of str to arb
        A ball for each variable.
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


@dataclass(frozen=True, kw_only=True, slots=True)
class Nature:
    """What is visible of a formula that has a value for all real values of its variables.

    Attributes
    ----------
    low, high : Fraction, or an infinity
        The values lie in ``[low, high]``.
    low_open, high_open : bool
        Whether the end is known not to be taken.
    continuous : bool
        Whether the formula is visibly continuous.
    lipschitz : bool
        Whether it is visibly locally Lipschitz: on every bounded set the difference quotients are bounded.
    """

    low: End
    high: End
    low_open: bool = False
    high_open: bool = False
    continuous: bool = True
    lipschitz: bool = True

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


_LINE = Nature(low=-math.inf, high=math.inf)


def nature(node: Node) -> Nature | None:
    """What is visible of a formula; None if it may have no value somewhere.

    Parameters
    ----------
    node : Node
        The tree of the formula.

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
    if isinstance(node, Number):
        return Nature(low=node.value, high=node.value)
    if isinstance(node, Variable):
        return _LINE
    if node.operation == "pi":
        return Nature(low=Fraction(3), high=Fraction(4))
    if node.operation == "where":
        return _where(node)
    if node.operation == "**":
        exponent = node.arguments[1]
        assert isinstance(exponent, Number), "the parser and the derivative make only constant exponents"
        base = nature(node.arguments[0])
        return None if base is None else _regularity_power(base, exponent.value)
    parts = [nature(part) for part in node.arguments]
    known = [part for part in parts if part is not None]
    if len(known) < len(parts):
        return None
    if node.operation == "*" and node.arguments[0] == node.arguments[1]:
        return _regularity_power(known[0], Fraction(2))
    found = _RULES[node.operation](*known)
    if found is None:
        return None
    continuous = found.continuous and all(part.continuous for part in known)
    return replace(found, continuous=continuous, lipschitz=found.lipschitz and all(part.lipschitz for part in known))


def _where(node: Apply) -> Nature | None:
    condition, *branches = node.arguments
    found = [nature(part) for part in branches]
    if found[0] is None or found[1] is None or not _decided(condition):
        return None
    u, v = found[0], found[1]
    steady = u.continuous and v.continuous and branches[0] == branches[1]
    return replace(_hull(u, v), continuous=steady, lipschitz=steady and u.lipschitz)


def _decided(condition: Node) -> bool:
    """Whether a condition is visibly true or false everywhere."""
    assert isinstance(condition, Apply), "the parser lets only comparisons and their combinations be conditions"
    if condition.operation in COMPARISONS:
        return all(nature(part) is not None for part in condition.arguments)
    return all(_decided(part) for part in condition.arguments)


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


def _quotient(u: Nature, v: Nature) -> Nature | None:
    inverse = _inverse(v)
    return None if inverse is None else _product(u, inverse)


def _inverse(v: Nature) -> Nature | None:
    if v.positive:
        return replace(
            v,
            low=_ZERO if isinstance(v.high, float) else 1 / v.high,
            low_open=v.high_open or isinstance(v.high, float),
            high=math.inf if v.low == 0 else 1 / Fraction(v.low),
            high_open=v.low_open,
        )
    if not v.negated.positive:
        return None
    found = _inverse(v.negated)
    return None if found is None else found.negated


def _regularity_power(base: Nature, exponent: Fraction) -> Nature | None:
    """``base**exponent``, for any rational exponent."""
    if exponent < 0:
        below = _regularity_power(base, -exponent)
        return None if below is None else _inverse(below)
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
    if base.low < 0:
        return None
    smooth = exponent >= 1 or base.positive
    floor, ceiling = (_ONE if base.low >= 1 else _ZERO), (_ONE if base.high <= 1 else math.inf)
    return replace(
        base,
        low=floor,
        high=ceiling,
        low_open=floor == 0 and base.positive,
        high_open=False,
        lipschitz=base.lipschitz and smooth,
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


def _logarithm(u: Nature) -> Nature | None:
    if not u.positive:
        return None
    return Nature(low=_ZERO if u.low >= 1 else -math.inf, high=_ZERO if u.high <= 1 else math.inf)


def _tangent(u: Nature) -> Nature | None:
    """``tan`` between -3/2 and 3/2, where it has no pole."""
    if u.low < Fraction(-3, 2) or u.high > Fraction(3, 2):
        return None
    return _monotone(Fraction(15))(u)  # tan(3/2) = 14.1


def _sign(u: Nature) -> Nature:
    value = _ONE if u.positive else -_ONE if u.negated.positive else None
    if value is not None:
        return Nature(low=value, high=value)
    return Nature(low=-_ONE, high=_ONE, continuous=False, lipschitz=False)


_UNIT = Nature(low=-_ONE, high=_ONE)
_RULES: dict[str, Callable[..., Nature | None]] = {
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
