"""Values as they stand in TOML: decimals kept exact, and every value in a form fit for an error message."""

from __future__ import annotations

import re
from decimal import Decimal, InvalidOperation

_NUMBER = re.compile(r"[+-]?(?=\.?\d)(?P<whole>\d[\d_]*)?(?P<fraction>\.[\d_]*)?(?P<exponent>[eE][+-]?\d+)?", re.ASCII)
_WIDTH = 60
_PATH_WIDTH = 200
_PRINTED_BITS = 200


def exact_decimal(text: str) -> Decimal | str:
    """The decimal exactly as written, at a cost that does not grow with its exponent.

    A decimal whose exponent has some twenty digits stays text, which every numeric field refuses.

    >>> exact_decimal("0.1"), exact_decimal("1e999999999")
    (Decimal('0.1'), Decimal('1E+999999999'))
    """
    try:
        return Decimal(text.replace("_", ""))
    except InvalidOperation:
        return text


def number_or_text(text: str) -> int | Decimal | str:
    """What a value typed on the command line means: a number if it reads as one, else itself.

    >>> number_or_text("8e-4"), number_or_text("10"), number_or_text("2*sin(4*t)")
    (Decimal('0.0008'), 10, '2*sin(4*t)')
    """
    match = _NUMBER.fullmatch(text.strip())
    if not match:
        return text
    number = exact_decimal(match[0])
    whole = match["fraction"] is None and match["exponent"] is None
    return int(number) if whole and isinstance(number, Decimal) and len(text) <= _WIDTH else number


def shown(value: object) -> str:
    r"""A value in a message: one short line in which nothing is left unescaped.

    >>> shown(True), shown({}), shown(chr(27) + "[2J")
    ('true', 'a table', "'\\x1b[2J'")
    """
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list):
        return "an array"
    if isinstance(value, int) and value.bit_length() > _PRINTED_BITS:
        return "a whole number of more than 60 digits"
    text = repr(value) if isinstance(value, str) else str(value)
    if len(text) <= _WIDTH:
        return text
    return f"{text[: _WIDTH - 4]}...{text[0] if isinstance(value, str) else ''}"


def shown_path(path: str) -> str:
    """A path or the name of a file in a message: without quotes, escaped, and long enough to be recognised."""
    text = repr(path)[1:-1]
    return text if len(text) <= _PATH_WIDTH else f"...{text[3 - _PATH_WIDTH :]}"
