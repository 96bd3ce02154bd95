"""Values as they stand in TOML: decimals kept exact, checked, and in a form fit for an error message."""

from __future__ import annotations

import re
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from typing import TYPE_CHECKING

from lure.errors import InputError
from lure.exact import exact_number

if TYPE_CHECKING:
    from pydantic import ConfigDict, ValidationInfo

_NUMBER = re.compile(r"[+-]?(?=\.?\d)(?P<whole>\d[\d_]*)?(?P<fraction>\.[\d_]*)?(?P<exponent>[eE][+-]?\d+)?", re.ASCII)
_WIDTH = 60
_PATH_WIDTH = 200
_PRINTED_BITS = 200
MAX_NAME = 100
_MAX_DIGITS = 1000
_MAX_EXPONENT = 400
STRICT: ConfigDict = {"strict": True, "extra": "forbid", "frozen": True, "arbitrary_types_allowed": True}


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
    >>> shown([0, "a"]), shown([[1, 2]])
    ("[0, 'a']", 'an array')
    """
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list):
        inner = f"[{', '.join(map(shown, value[:_WIDTH]))}]"
        return "an array" if len(inner) > _WIDTH or any(isinstance(one, list | dict) for one in value) else inner
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


def field_key(info: ValidationInfo) -> str:
    """Dotted key, ``rod.length``; the title of a table's model is the name of the table, in small letters."""
    title = info.config.get("title") if info.config else None
    return f"{title}.{info.field_name}" if title and title.islower() else str(info.field_name)


def number_of(value: object, name: str) -> Fraction:
    """The exact number; size and digits are looked at before anything is computed with it."""
    if isinstance(value, bool) or not isinstance(value, int | Decimal | Fraction):
        raise InputError(f"{name} is {shown(value)}; give a number")
    if isinstance(value, Decimal) and value.is_finite() and value:
        if abs(value.adjusted()) > _MAX_EXPONENT:
            raise InputError(f"{name} is {shown(value)}, outside the range of double precision; rescale the units")
        if len(value.as_tuple().digits) > _MAX_DIGITS:
            raise InputError(f"{name} has more than {_MAX_DIGITS} digits; give fewer")
    return Fraction(0) if isinstance(value, Decimal) and not value else exact_number(value, name)


def array_of_tables(value: object) -> object:
    """An array of tables; of a single table the array with this one."""
    return [value] if isinstance(value, dict) else value


def one_line(value: object, info: ValidationInfo) -> str:
    """A text that fits in a heading."""
    if not isinstance(value, str):
        raise InputError(f"{field_key(info)} is {shown(value)}; give a text in quotes")
    if not value.strip() or len(value) > MAX_NAME or not value.isprintable():
        raise InputError(f"{field_key(info)} is {shown(value)}; give one line of 1 to {MAX_NAME} printable characters")
    return value
