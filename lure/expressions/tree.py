"""The tree of an expression: exact operations, its text, its derivative, and where its branches change."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TypeAlias

# Operations on nodes: constants are folded exactly, and only what holds on the whole domain is simplified.

# The tree of an expression: exact numbers, variables and operations.

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


# A tree as text the parser reads back to the same tree.

_INFIX = (*COMPARISONS, "+", "-", "*", "/", "**", "and", "or")


def render(node: Node) -> str:
    """Text with every operation inside another one in parentheses; ``where`` and the functions by name.

    >>> from lure.expressions.parser import parse
    >>> render(parse("-t**2 + sin(t)/3 if 0 < t else 0", variables=("t",), field="f"))
    'where(0 < t, (-(t**2)) + (sin(t)/3), 0)'
    """
    if isinstance(node, Number):
        text = decimal(node.value)
        assert text is not None, "constants that have no text are never folded"
        return text
    if not isinstance(node, Apply):
        return node.name
    if node.operation == "pi":
        return "pi"
    if node.operation == "neg":
        return f"-{_inner(node.arguments[0])}"
    if node.operation == "not":
        return f"not {_inner(node.arguments[0])}"
    if node.operation in _INFIX:
        left, right = (_inner(part) for part in node.arguments)
        space = "" if node.operation in ("*", "/", "**") else " "
        return f"{left}{space}{node.operation}{space}{right}"
    return f"{node.operation}({', '.join(render(part) for part in node.arguments)})"


def _inner(node: Node) -> str:
    text = render(node)
    simple = isinstance(node, Number) and text.replace(".", "").isdigit()
    named = not isinstance(node, Number | Apply) or (isinstance(node, Apply) and text == "pi")
    called = isinstance(node, Apply) and node.operation not in (*_INFIX, "neg", "not")
    return text if simple or named or called else f"({text})"


_EXACT: dict[str, Callable[[Fraction, Fraction], Fraction]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "min": min,
    "max": max,
}


def apply(operation: str, *arguments: Node) -> Node:
    """The node of an operation, simplified when the answer does not depend on the values of the variables.

    Constants are combined as exact fractions unless the result would be undefined (``1/0``) or need more digits than
    a literal may have; then the operation stays as it is.  ``0*u`` becomes 0 only for an operand defined everywhere.
    """
    if operation in CONDITIONS or operation == "pi":
        return Apply(operation, arguments)
    if operation == "where":
        return _where(*arguments)
    if operation == "**":
        return _power(*arguments)
    if len(arguments) == 1:
        return _unary(operation, arguments[0])
    return _binary(operation, *arguments)


def _unary(operation: str, u: Node) -> Node:
    if isinstance(u, Number):
        if operation == "neg":
            return Number(-u.value)
        if operation == "abs":
            return Number(abs(u.value))
        if operation == "sign":
            return Number(Fraction((u.value > 0) - (u.value < 0)))
    if operation == "neg" and isinstance(u, Apply) and u.operation == "neg":
        return u.arguments[0]
    return Apply(operation, (u,))


def _binary(operation: str, u: Node, v: Node) -> Node:
    if isinstance(u, Number) and isinstance(v, Number):
        return _folded(operation, u, v)
    if operation == "*":
        return _product(u, v)
    if v == ZERO and operation in ("+", "-"):
        return u
    if u == ZERO and operation in ("+", "-"):
        return v if operation == "+" else apply("neg", v)
    if v == ONE and operation == "/":
        return u
    return Apply(operation, (u, v))


def _folded(operation: str, u: Number, v: Number) -> Node:
    if operation == "/" and v == ZERO:
        return Apply(operation, (u, v))
    value = _EXACT[operation](u.value, v.value)
    return Number(value) if decimal(value) is not None else Apply(operation, (u, v))


def _product(u: Node, v: Node) -> Node:
    for factor, other in ((u, v), (v, u)):
        if factor == ZERO and is_total(other):
            return ZERO
        if factor == ONE:
            return other
        if factor == Number(Fraction(-1)):
            return apply("neg", other)
    return Apply("*", (u, v))


def _power(base: Node, exponent: Node) -> Node:
    if isinstance(exponent, Number):
        if exponent == ONE:
            return base
        if exponent == ZERO and is_total(base):
            return ONE
        whole = exponent.value.denominator == 1 and abs(exponent.value) <= 64
        if isinstance(base, Number) and whole and not (base == ZERO and exponent.value < 0):
            value = base.value**exponent.value.numerator
            if decimal(value) is not None:
                return Number(value)
    return Apply("**", (base, exponent))


def _where(condition: Node, u: Node, v: Node) -> Node:
    same = isinstance(u, Number) and u == v
    return u if same and is_total(condition) else Apply("where", (condition, u, v))


# The derivative of a tree, branch by branch, valid almost everywhere.

_HALF = Number(Fraction(1, 2))


def derivative(node: Node, variable: str) -> Node:
    """Tree of the partial derivative.

    ``|u|' = sign(u) u'``, ``min(u, v)' = u' where u < v else v'``, ``where(c, u, v)' = where(c, u', v')`` and
    ``sign(u)' = 0``: kinks and jumps are passed over.
    """
    if isinstance(node, Variable):
        return ONE if node.name == variable else ZERO
    if not isinstance(node, Apply) or variable not in names(node):
        return ZERO
    if node.operation == "where":
        condition, first, second = node.arguments
        return apply("where", condition, derivative(first, variable), derivative(second, variable))
    u, du = node.arguments[0], derivative(node.arguments[0], variable)
    if node.operation == "neg":
        return apply("neg", du)
    if node.operation == "**":
        return _times(_power_rule(u, node.arguments[1]), du)
    if len(node.arguments) == 1:
        return _times(_outer(node), du)
    v, dv = node.arguments[1], derivative(node.arguments[1], variable)
    match node.operation:
        case "+" | "-":
            return apply(node.operation, du, dv)
        case "*":
            return apply("+", _times(du, v), _times(u, dv))
        case "/":
            rest = _times(apply("/", u, apply("**", v, Number(Fraction(2)))), dv)
            return apply("-", ZERO if du == ZERO else apply("/", du, v), rest)
        case "min":
            return apply("where", apply("<", u, v), du, dv)
        case _:
            assert node.operation == "max", f"{node.operation} has no derivative rule"
            return apply("where", apply(">", u, v), du, dv)


def _times(factor: Node, inner: Node) -> Node:
    """A product, 0 if either factor is: outside the domain of the other the expression itself is undefined."""
    return ZERO if ZERO in (factor, inner) else apply("*", factor, inner)


def _power_rule(base: Node, exponent: Node) -> Node:
    assert isinstance(exponent, Number), "the parser and this module make only constant exponents"
    lower = exponent.value - 1
    # Below -32 the power would not be readable again; u**p / u is the same.
    rest = apply("**", base, Number(lower)) if lower >= -32 else apply("/", apply("**", base, exponent), base)
    return _times(exponent, rest)


def _outer(node: Apply) -> Node:
    """The derivative of a function of one argument at that argument."""
    (u,) = node.arguments
    square = Number(Fraction(2))
    match node.operation:
        case "abs":
            return apply("sign", u)
        case "sin":
            return apply("cos", u)
        case "cos":
            return apply("neg", apply("sin", u))
        case "exp":
            return node
        case "log":
            return apply("/", ONE, u)
        case "sqrt":
            return apply("/", _HALF, node)
        case "tan":
            return apply("+", ONE, apply("**", node, square))
        case "tanh":
            return apply("-", ONE, apply("**", node, square))
        case "atan":
            return apply("/", ONE, apply("+", ONE, apply("**", u, square)))
        case _:
            assert node.operation == "sign", f"{node.operation} has no derivative rule"
            return ZERO


def switches(node: Node, variable: str) -> frozenset[Fraction] | None:
    """Where a comparison, ``abs``, ``sign``, ``min`` or ``max`` changes side in the variable; None if unknown."""
    points: set[Fraction] = set()
    for left, right in _compared(node):
        line, other = _affine(left, variable), _affine(right, variable)
        if line is None or other is None:
            return None
        height, slope = line[0] - other[0], line[1] - other[1]
        if slope != 0:
            points.add(-height / slope)
    return frozenset(points)


def _compared(node: Node) -> Iterator[tuple[Node, Node]]:
    if not isinstance(node, Apply):
        return
    if node.operation in (*COMPARISONS, "min", "max"):
        yield node.arguments[0], node.arguments[1]
    elif node.operation in ("abs", "sign"):
        yield node.arguments[0], ZERO
    for part in node.arguments:
        yield from _compared(part)


def _affine(node: Node, variable: str) -> tuple[Fraction, Fraction] | None:
    """``(c0, c1)`` if the node is ``c0 + c1*variable`` with rational coefficients."""
    if isinstance(node, Number):
        return node.value, Fraction(0)
    if isinstance(node, Variable):
        return (Fraction(0), Fraction(1)) if node.name == variable else None
    if node.operation not in ("+", "-", "*", "/", "neg"):
        return None
    parts = [_affine(part, variable) for part in node.arguments]
    known = [part for part in parts if part is not None]
    if len(known) < len(parts):
        return None
    if node.operation == "neg":
        return -known[0][0], -known[0][1]
    (a0, a1), (b0, b1) = known
    match node.operation:
        case "+":
            return a0 + b0, a1 + b1
        case "-":
            return a0 - b0, a1 - b1
        case "/":
            return (a0 / b0, a1 / b0) if b1 == 0 and b0 != 0 else None
        case _:
            return (a0 * b0, a0 * b1 + a1 * b0) if a1 * b1 == 0 else None
