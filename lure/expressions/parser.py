"""Tokens to a tree by recursive descent, with Python's precedence; nothing is handed to Python's own compiler."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from difflib import get_close_matches
from fractions import Fraction
from functools import lru_cache
from typing import Literal, NoReturn, TypeVar

from lure.errors import InputError
from lure.expressions.tree import COMPARISONS, ZERO, Node, Number, Variable, apply, decimal, depth, is_condition

# Text to tokens: decimal numbers, names, operators and parentheses; every other character is refused.

MAX_LENGTH = 1024
_SPACE = re.compile(r"[ \t\r\n]+")
_NUMBER = re.compile(r"([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
_NAME = re.compile(r"[A-Za-z_][A-Za-z_0-9]*")
_SYMBOL = re.compile(r"\*\*|<=|>=|==|!=|[-+*/^()<>,]")
_HINTS = {
    "=": "equality is written ==, and arguments have no names",
    ".": "numbers such as 0.5 may have a point, values have no attributes",
    '"': "text is not a value",
    "'": "text is not a value",
    "[": "there are no lists or indices, group with ( )",
    "{": "there are no sets, group with ( )",
    ";": "one expression only",
    "&": "write and",
    "|": "write or",
    "!": "write not or !=",
    "#": "there are no comments inside an expression",
    "\N{MINUS SIGN}": "write the ASCII minus -",
    "\N{EN DASH}": "write the ASCII minus -",
    "\N{MULTIPLICATION SIGN}": "write *",
    "\N{GREEK SMALL LETTER SIGMA}": "write sigma",
    "\N{MIDDLE DOT}": "write *",
    "\N{GREEK SMALL LETTER PI}": "write pi",
    "\N{SUPERSCRIPT TWO}": "a power is written **2",
    "\N{SUPERSCRIPT THREE}": "a power is written **3",
}

Kind = Literal["number", "name", "symbol", "end"]


@dataclass(frozen=True, slots=True)
class Token:
    """A word of the text and the column, from 1, where it starts."""

    kind: Kind
    text: str
    column: int

    def __str__(self) -> str:
        """The token as error messages quote it, cut to 20 characters."""
        if self.kind == "end":
            return "the end of the text"
        return repr(self.text if len(self.text) <= 20 else self.text[:17] + "...")


def tokens(text: str, *, field: str) -> list[Token]:
    """Split a text of at most 1024 characters into tokens, the last of kind ``"end"``.

    Raises
    ------
    InputError
        The text is too long, or holds a character no expression needs (quotes, brackets, ``:``, ``=``, a lone point,
        anything not ASCII), or a number runs into a name.
    """
    if len(text) > MAX_LENGTH:
        raise InputError(f"{field}: the expression has {len(text)} characters; at most {MAX_LENGTH} are allowed.")
    found: list[Token] = []
    position = 0
    while position < len(text):
        if space := _SPACE.match(text, position):
            position = space.end()
            continue
        token = _token(text, position)
        if token is None:
            raise InputError(f"{field}: {_refused(text[position])} at column {position + 1}.")
        position += len(token.text)
        if token.kind == "number" and (name := _NAME.match(text, position)):
            tail, product = Token("name", name.group(), position + 1), f"{token.text}*{name.group()}"
            raise InputError(
                f"{field}: the number {token} runs into {tail} at column {tail.column}; write {product:.20} "
                "for a product, and only plain decimal numbers such as 12, 0.5 or 1e-3."
            )
        found.append(token)
    return [*found, Token("end", "", len(text) + 1)]


def _token(text: str, position: int) -> Token | None:
    patterns: tuple[tuple[Kind, re.Pattern[str]], ...] = (("number", _NUMBER), ("name", _NAME), ("symbol", _SYMBOL))
    for kind, pattern in patterns:
        if match := pattern.match(text, position):
            return Token(kind, match.group(), position + 1)
    return None


def _refused(character: str) -> str:
    shown = repr(character) if character.isascii() else f"{character!a} (not ASCII)"
    hint = _HINTS.get(character, "expressions hold ASCII numbers, names, + - * / ** ( ) , and comparisons")
    return f"character {shown} is not allowed ({hint})"


# The parser's place in the text, its budget of nodes and nesting, and the one way it refuses.

MAX_NODES = 200
MAX_DEPTH = 30
_Part = TypeVar("_Part")


@dataclass(slots=True)
class Reader:
    """Position in the tokens, and how much of the budget of nodes and nesting is used."""

    tokens: list[Token]
    variables: tuple[str, ...]
    field: str
    position: int = 0
    nodes: int = 0
    level: int = 0

    @property
    def ended(self) -> bool:
        """Whether all words are used."""
        return self.token.kind == "end"

    @property
    def token(self) -> Token:
        """The next word."""
        return self.tokens[self.position]

    def refuse(self, message: str, token: Token | None = None) -> NoReturn:
        """Raise InputError naming the field and the column."""
        raise InputError(f"{self.field}: {message} at column {(token or self.token).column}.")

    def accept(self, *texts: str) -> Token | None:
        """Step over the next word if it is one of these."""
        token = self.token
        if token.kind in ("symbol", "name") and token.text in texts:
            self.position += 1
            return token
        return None

    def expect(self, text: str, after: str) -> None:
        """Step over a word that must come now."""
        if not self.accept(text):
            comma = " (the decimal separator is a point)" if self.token.text == "," else ""
            self.refuse(f"expected {text!r} {after} but found {self.token}{comma}")

    def node(self, operation: str, *arguments: Node, at: Token) -> Node:
        """An operation, charged to the budget."""
        self.count(at)
        result = apply(operation, *arguments)
        if depth(result) > MAX_DEPTH:
            self.refuse(
                f"more than {MAX_DEPTH} operations are nested or chained; group a long sum with parentheses", at
            )
        return result

    def count(self, at: Token) -> None:
        """Charge one node to the budget."""
        self.nodes += 1
        if self.nodes > MAX_NODES:
            self.refuse(f"the expression has more than {MAX_NODES} numbers, names and operations", at)

    def enter(self, at: Token) -> None:
        """One level deeper: a parenthesis, sign or branch opens."""
        self.level += 1
        if self.level > MAX_DEPTH:
            self.refuse(f"more than {MAX_DEPTH} parentheses or signs are nested", at)

    def leave(self) -> None:
        """The level is closed again."""
        self.level -= 1

    def closed(self, opening: Token, part: Callable[[Reader], _Part]) -> _Part:
        """The part inside a parenthesis that is open, and its end."""
        self.enter(opening)
        found = part(self)
        self.leave()
        self.expect(")", f"to close '(' of column {opening.column}")
        return found


# The words an expression may use, and what to say about others.

FUNCTIONS = ("abs", "atan", "cos", "exp", "log", "max", "min", "sign", "sin", "sqrt", "tan", "tanh", "where")
KEYWORDS = ("and", "else", "if", "not", "or")
_VOCABULARY_HINTS = {
    "e": "e is no constant here, it could be meant as a variable; write exp(1) or exp(...)",
    "inf": "numbers must be finite",
    "infinity": "numbers must be finite",
    "nan": "numbers must be finite",
    "ln": "the natural logarithm is log",
    "pow": "a power is written **",
    "arctan": "the inverse tangent is atan",
    **dict.fromkeys(("asin", "arcsin", "acos", "arccos", "asinh", "acosh", "atanh"), "of inverses there is atan"),
    "sinh": "sinh(u) is written (exp(u) - exp(-u))/2",
    "cosh": "cosh(u) is written (exp(u) + exp(-u))/2",
    "erf": "there is no error function here; a table of its values may stand in its place",
    "sat": "a saturation of u is written min(max(u, -1), 1)",
    "relu": "a ReLU of u is written max(u, 0)",
    "heaviside": "a step is written where(t > 0, 1, 0)",
    "step": "a step is written where(t > 0, 1, 0)",
    "lambda": "write only the formula itself",
}


def unknown_name(reader: Reader, token: Token) -> NoReturn:
    """Refuse a name, with the nearest known one or all that are allowed."""
    known = [*reader.variables, "pi", *FUNCTIONS]
    close = get_close_matches(token.text.lower()[:20], known, n=1)
    hint = _VOCABULARY_HINTS.get(token.text.lower())
    if len(token.text) == len(reader.variables) == 1:
        hint = hint or f"the variable is {reader.variables[0]}"
    if hint:
        reader.refuse(f"unknown name {token} ({hint})", token)
    if close:
        reader.refuse(f"unknown name {token} (did you mean {close[0]!r}?)", token)
    reader.refuse(f"unknown name {token} (allowed are {', '.join(known)})", token)


MAX_POWER = 32
MAX_DIGITS = 100


@lru_cache(maxsize=256)
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
    if not (at := reader.accept("**", "^")):
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
