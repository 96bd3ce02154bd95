"""Tokens to a tree by recursive descent, with Python's precedence; nothing is handed to Python's own compiler."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from lure.errors import InputError
from lure.expressions.build import apply
from lure.expressions.reader import MAX_NODES, Reader
from lure.expressions.tokens import Token, tokens
from lure.expressions.tree import COMPARISONS, ZERO, Node, Number, Variable, decimal, is_condition
from lure.expressions.vocabulary import FUNCTIONS, KEYWORDS, unknown_name

MAX_POWER = 32
MAX_DIGITS = 100


def parse(text: str, *, variables: tuple[str, ...], field: str) -> Node:
    """Tree of a text.

    Raises
    ------
    InputError
        One sentence with the column: what was found and what is allowed.
    """
    reader = Reader(tokens(text, field=field), variables, field)
    if reader.ended:
        raise InputError(f"{field}: the expression is empty; write a number or a formula such as sin(pi/2).")
    start = reader.token
    result = _number(reader, _choice(reader), start)
    if reader.ended:
        return result
    hint = {",": " (the decimal separator is a point)", "(": " (write * for a product)"}.get(reader.token.text, "")
    reader.refuse(f"expected an operator but found {reader.token}{hint}")


def _number(reader: Reader, node: Node, at: Token) -> Node:
    if is_condition(node):
        reader.refuse("a comparison is not a number; write where(condition, a, b) for the part that starts", at)
    return node


def _condition(reader: Reader, node: Node, at: Token) -> Node:
    if not is_condition(node):
        reader.refuse("expected a comparison such as t < 1 for the part that starts", at)
    return node


def _choice(reader: Reader) -> Node:
    """``a if condition else b``, right to left."""
    start = reader.token
    result = _either(reader)
    if not (at := reader.accept("if")):
        return result
    _number(reader, result, start)
    start = reader.token
    condition = _condition(reader, _either(reader), start)
    reader.expect("else", "after 'if'")
    reader.enter(at)
    start = reader.token
    otherwise = _number(reader, _choice(reader), start)
    reader.leave()
    return reader.node("where", condition, result, otherwise, at=at)


def _either(reader: Reader) -> Node:
    return _joined(reader, "or", _both)


def _both(reader: Reader) -> Node:
    return _joined(reader, "and", _negation)


def _joined(reader: Reader, word: str, part: Callable[[Reader], Node]) -> Node:
    start = reader.token
    result = part(reader)
    while at := reader.accept(word):
        after = reader.token
        result = reader.node(word, _condition(reader, result, start), _condition(reader, part(reader), after), at=at)
    return result


def _negation(reader: Reader) -> Node:
    if not (at := reader.accept("not")):
        return _comparison(reader)
    reader.enter(at)
    start = reader.token
    inner = _condition(reader, _negation(reader), start)
    reader.leave()
    return reader.node("not", inner, at=at)


def _comparison(reader: Reader) -> Node:
    """One comparison, or a chain ``a < b < c`` that means ``a < b and b < c``."""
    start = reader.token
    left = _sum(reader)
    result: Node | None = None
    while at := reader.accept(*COMPARISONS):
        after = reader.token
        _number(reader, left, start)
        right = _number(reader, _sum(reader), after)
        link = reader.node(at.text, left, right, at=at)
        result = link if result is None else reader.node("and", result, link, at=at)
        left, start = right, after
    return left if result is None else result


def _sum(reader: Reader) -> Node:
    start = reader.token
    result = _product(reader)
    while at := reader.accept("+", "-"):
        after = reader.token
        result = reader.node(at.text, _number(reader, result, start), _number(reader, _product(reader), after), at=at)
    return result


def _product(reader: Reader) -> Node:
    start = reader.token
    result = _signed(reader)
    while at := reader.accept("*", "/"):
        after = reader.token
        right = _number(reader, _signed(reader), after)
        if at.text == "/" and right == ZERO:
            reader.refuse("division by zero", at)
        result = reader.node(at.text, _number(reader, result, start), right, at=at)
    return result


def _signed(reader: Reader) -> Node:
    if not (at := reader.accept("+", "-")):
        return _power(reader)
    reader.enter(at)
    start = reader.token
    inner = _number(reader, _signed(reader), start)
    reader.leave()
    if at.text == "-":
        return reader.node("neg", inner, at=at)
    reader.count(at)
    return inner


def _power(reader: Reader) -> Node:
    start = reader.token
    base = _atom(reader)
    if not (at := reader.accept("**")):
        return base
    reader.enter(at)
    exponent = _signed(reader)
    reader.leave()
    if not isinstance(exponent, Number) or abs(exponent.value) > MAX_POWER:
        reader.refuse(
            f"an exponent must be a rational number between -{MAX_POWER} and {MAX_POWER}, "
            "and a variable exponent is written exp(...),",
            at,
        )
    if _number(reader, base, start) == ZERO and exponent.value < 0:
        reader.refuse("division by zero", at)
    return reader.node("**", base, exponent, at=at)


def _atom(reader: Reader) -> Node:
    token = reader.token
    if token.kind == "number":
        reader.position += 1
        reader.count(token)
        return _literal(reader, token)
    if token.kind == "name" and token.text not in KEYWORDS:
        reader.position += 1
        reader.count(token)
        return _named(reader, token)
    if reader.accept("("):
        return reader.closed(token, _choice)
    reader.refuse(f"expected a number, a name or '(' but found {token}")


def _literal(reader: Reader, token: Token) -> Number:
    mantissa, _, exponent = token.text.lower().partition("e")
    if len(mantissa) > MAX_DIGITS or len(exponent) > 4:
        reader.refuse(f"the number has more than {MAX_DIGITS} digits or an exponent of more than three", token)
    value = Fraction(token.text)
    if decimal(value) is None:
        reader.refuse("the number is not zero and not between 1e-300 and 1e300 in size", token)
    return Number(value)


def _named(reader: Reader, token: Token) -> Node:
    name = token.text
    called = reader.token.text == "(" and reader.token.kind == "symbol"
    if name in FUNCTIONS:
        if not called:
            reader.refuse(f"{name} is a function; write {name}(...)", token)
        return _call(reader, token)
    if name not in reader.variables and name != "pi":
        unknown_name(reader, token)
    if called:
        reader.refuse(f"{name} is not a function (write * for a product)", token)
    return Variable(name) if name in reader.variables else apply("pi")


def _call(reader: Reader, function: Token) -> Node:
    opening = reader.token
    reader.position += 1
    reader.enter(opening)
    arguments: list[Node] = []
    if not reader.accept(")"):
        while True:
            start = reader.token
            check = _condition if function.text == "where" and not arguments else _number
            arguments.append(check(reader, _choice(reader), start))
            if not reader.accept(","):
                break
        reader.expect(")", f"to close {function.text}(")
    reader.leave()
    least, most = {"where": (3, 3), "min": (2, MAX_NODES), "max": (2, MAX_NODES)}.get(function.text, (1, 1))
    if not least <= len(arguments) <= most:
        wanted = {
            "where": "three arguments (condition, a, b)",
            "min": "two or more arguments",
            "max": "two or more arguments",
        }
        reader.refuse(
            f"{function.text} takes {wanted.get(function.text, 'one argument')}, not {len(arguments)},", function
        )
    if function.text not in ("min", "max"):
        return reader.node(function.text, *arguments, at=function)
    result = arguments[0]
    for argument in arguments[1:]:
        result = reader.node(function.text, result, argument, at=function)
    return result
