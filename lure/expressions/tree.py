"""The tree of an expression: exact numbers, variables and operations."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from typing import TypeAlias

COMPARISONS = ("<", "<=", ">", ">=", "==", "!=")
CONDITIONS = (*COMPARISONS, "and", "or", "not")
_TOTAL_FUNCTIONS = ("abs", "min", "max", "sin", "cos", "exp", "tanh", "atan", "sign", "where", "pi")
_TOTAL = frozenset(("+", "-", "*", "neg", *_TOTAL_FUNCTIONS, *CONDITIONS))
_MAX_DIGITS = 100
_MAX_EXPONENT = 300


@dataclass(frozen=True, slots=True)
class Number:
    """An exact rational constant."""

    value: Fraction


@dataclass(frozen=True, slots=True)
class Variable:
    """A value supplied at evaluation."""

    name: str


@dataclass(frozen=True, slots=True)
class Apply:
    """An operation on other nodes: an operator (``"+"``, ``"neg"``, ``"<"``, ...), a function by name, or ``"pi"``.

    ``size`` (nodes, counted with repetition) and ``depth`` bound the work of every walk over the tree; ``names`` are
    the variables met.  ``total`` says that there is a value for all real values of the variables, so that ``0 * node``
    is 0.
    """

    operation: str
    arguments: tuple[Node, ...]
    size: int = field(init=False, compare=False, repr=False)
    depth: int = field(init=False, compare=False, repr=False)
    names: frozenset[str] = field(init=False, compare=False, repr=False)
    total: bool = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        """Derive the bookkeeping from the arguments, whose own is already known."""
        parts = self.arguments
        object.__setattr__(self, "size", 1 + sum(size(part) for part in parts))
        object.__setattr__(self, "depth", 1 + max((depth(part) for part in parts), default=0))
        object.__setattr__(self, "names", frozenset().union(*(names(part) for part in parts)))
        defined = self.operation in _TOTAL
        if self.operation in ("/", "**"):
            last = parts[1]
            defined = isinstance(last, Number) and (
                last.value != 0 if self.operation == "/" else last.value >= 0 and last.value.denominator == 1
            )
        object.__setattr__(self, "total", defined and all(is_total(part) for part in parts))


Node: TypeAlias = Number | Variable | Apply

ZERO, ONE = Number(Fraction(0)), Number(Fraction(1))


def size(node: Node) -> int:
    """Number of nodes, shared ones counted each time they are met."""
    return node.size if isinstance(node, Apply) else 1


def depth(node: Node) -> int:
    """Length of the longest path to a leaf."""
    return node.depth if isinstance(node, Apply) else 1


def names(node: Node) -> frozenset[str]:
    """Variables the value depends on."""
    if isinstance(node, Apply):
        return node.names
    return frozenset({node.name}) if isinstance(node, Variable) else frozenset()


def is_total(node: Node) -> bool:
    """Whether the node visibly has a value for all real values of the variables."""
    return node.total if isinstance(node, Apply) else True


def is_condition(node: Node) -> bool:
    """Whether the node is true or false rather than a number."""
    return isinstance(node, Apply) and node.operation in CONDITIONS


def decimal(value: Fraction) -> str | None:
    """Exact text of a number, ``p/q`` if no decimal is exact; None if it is too long, or too large or small for floats.

    >>> decimal(Fraction(1, 8)), decimal(Fraction(1, 10**30)), decimal(Fraction(-2, 3)), decimal(Fraction(10**400))
    ('0.125', '1e-30', '-2/3', None)
    """
    top, bottom = abs(value.numerator), value.denominator
    if max(top.bit_length(), bottom.bit_length()) > 4 * (_MAX_EXPONENT + _MAX_DIGITS):
        return None
    if top and not Fraction(1, 10**_MAX_EXPONENT) <= abs(value) <= 10**_MAX_EXPONENT:
        return None
    sign = "-" if value < 0 else ""
    twos, rest = 0, bottom
    while rest % 2 == 0:
        twos, rest = twos + 1, rest // 2
    fives = 0
    while rest % 5 == 0:
        fives, rest = fives + 1, rest // 5
    if rest == 1:
        shift = max(twos, fives)
        text = _scientific(str(top * 10**shift // bottom), -shift)
        return None if text is None else sign + text
    if len(str(top)) > _MAX_DIGITS or len(str(bottom)) > _MAX_DIGITS:
        return None
    return f"{sign}{top}/{bottom}"


def _scientific(digits: str, exponent: int) -> str | None:
    """``digits * 10**exponent``, short numbers without an exponent."""
    significant = digits.rstrip("0") or "0"
    exponent += len(digits) - len(significant)
    if len(significant) > _MAX_DIGITS:
        return None
    if significant == "0":
        return "0"
    if exponent >= 0 and len(significant) + exponent <= 20:
        return significant + "0" * exponent
    if -20 <= exponent < 0:
        padded = significant.rjust(1 - exponent, "0")
        return f"{padded[:exponent]}.{padded[exponent:]}"
    return f"{significant}e{exponent}"
