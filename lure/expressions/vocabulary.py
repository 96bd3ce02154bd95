"""The words an expression may use, and what to say about others."""

from __future__ import annotations

from difflib import get_close_matches
from typing import NoReturn

from lure.expressions.reader import Reader
from lure.expressions.tokens import Token

FUNCTIONS = ("abs", "atan", "cos", "exp", "log", "max", "min", "sign", "sin", "sqrt", "tan", "tanh", "where")
KEYWORDS = ("and", "else", "if", "not", "or")
_HINTS = {
    "e": "e is no constant here, it could be meant as a variable; write exp(1) or exp(...)",
    "inf": "numbers must be finite",
    "infinity": "numbers must be finite",
    "nan": "numbers must be finite",
    "ln": "the natural logarithm is log",
    "pow": "a power is written **",
    "arctan": "the inverse tangent is atan",
    "heaviside": "a step is written where(t > 0, 1, 0)",
    "step": "a step is written where(t > 0, 1, 0)",
    "lambda": "write only the formula itself",
}


def unknown_name(reader: Reader, token: Token) -> NoReturn:
    """Refuse a name, with the nearest known one or all that are allowed."""
    known = [*reader.variables, "pi", *FUNCTIONS]
    close = get_close_matches(token.text.lower()[:20], known, n=1)
    if hint := _HINTS.get(token.text.lower()):
        reader.refuse(f"unknown name {token} ({hint})", token)
    if close:
        reader.refuse(f"unknown name {token} (did you mean {close[0]!r}?)", token)
    reader.refuse(f"unknown name {token} (allowed are {', '.join(known)})", token)
