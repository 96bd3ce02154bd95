"""Where a formula certainly has a value: every operation looked at, also inside conditions and behind a factor 0."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from lure.expressions.balls import enclosure, truth
from lure.expressions.tree import Apply, Node, Number

if TYPE_CHECKING:
    from flint import arb


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
