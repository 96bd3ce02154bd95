"""Text to tokens: decimal numbers, names, operators and parentheses; every other character is refused."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from lure.errors import InputError

MAX_LENGTH = 1024
_SPACE = re.compile(r"[ \t\r\n]+")
_NUMBER = re.compile(r"([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
_NAME = re.compile(r"[A-Za-z_][A-Za-z_0-9]*")
_SYMBOL = re.compile(r"\*\*|<=|>=|==|!=|[-+*/()<>,]")
_HINTS = {
    "^": "a power is written **",
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
    "\N{MIDDLE DOT}": "write *",
    "\N{GREEK SMALL LETTER PI}": "write pi",
    "\N{SUPERSCRIPT TWO}": "a power is written **2",
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
            tail = Token("name", name.group(), position + 1)
            raise InputError(
                f"{field}: the number {token} runs into {tail} at column {tail.column}; "
                "write * for a product, and only plain decimal numbers such as 12, 0.5 or 1e-3."
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
