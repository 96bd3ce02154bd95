"""Transfer functions written as formulas: ``1/(s*(s+1))``, ``z/(z - 0.5)``, with exact coefficients."""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Literal

from lure.errors import InputError
from lure.expressions.reader import Reader
from lure.expressions.tokens import Token
from lure.inputs.coefficients import exact_coefficient
from lure.inputs.sampling import sampling_time, stated
from lure.rational import MAX_ORDER, RationalBlock

if TYPE_CHECKING:
    from flint import fmpq_poly

MAX_LENGTH = 8192
_MAX_BITS = 1 << 17
_WORD = re.compile(
    r"(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"
    r"|(?P<name>[A-Za-z_][A-Za-z_0-9]*)|(?P<symbol>\*\*|[-+*/^()])"
)
_HINTS = {
    "i": "coefficients are real",
    "j": "coefficients are real",
    "pi": "pi is irrational, write a decimal or a fraction",
    "p": "write s",
    "exp": "a dead time is written exp(-T*s), with a number for T",
    "q": "write z",
}


def parse_transfer(text: str, *, dt: object = None, field: str = "transfer") -> RationalBlock:
    r"""The rational block of a formula in ``s``, or in ``z`` for discrete time, with exact coefficients.

    A factor written in the numerator and the denominator of one fraction is kept, as a hidden mode:
    ``(s-1)/((s-1)*(s+2))`` has order 2.  The common part of the denominators of a sum or of a quotient is taken once:
    ``1/s + 1/(s*(s+1))`` has order 2 and ``(1/s)/(1 + 1/s)`` is ``1/(s+1)``.

    Parameters
    ----------
    text : str
        Decimals (each exactly itself), ``s`` or ``z``, ``+ - * /``, whole powers by ``^`` or ``**``, brackets.  A
        product may leave out ``*``, as in ``2 s (s+1)``, except after ``/``, where it would be ambiguous.
    dt : None, 0, True or number
        Sampling time in python-control's convention; a text in ``z`` without it has period 1.
    field : str
        Where the text stands, for errors.

    Raises
    ------
    InputError
        One sentence with the column: the text is empty, too long, not such a formula, improper, of order above 1000,
        in both variables, or its variable contradicts ``dt``.

    Examples
    --------
    >>> print(parse_transfer("1/(s*(s+1)*(s+2))"))
    1 / (s^3 + 3 s^2 + 2 s)
    >>> parse_transfer("z/(z-0.5)").dt
    Fraction(1, 1)
    """
    reader = Reader(_tokens(text, field), ("s", "z"), field)
    if reader.ended:
        raise InputError(f"{field}: the text is empty; write a transfer function such as 1/(s*(s+1))")
    found = _sum(reader)
    if not reader.ended:
        reader.refuse(f"expected an operator but found {reader.token}")
    names = {token.text for token in reader.tokens if token.kind == "name"}
    if len(names) > 1:
        raise InputError(f"{field}: both s and z occur; write s for continuous or z for discrete time")
    said = stated(dt)
    if "s" in names and said:
        raise InputError(f"{field}: the formula is in s but dt asks for discrete time; write it in z or leave dt out")
    if "z" in names and said == 0:
        raise InputError(f"{field}: the formula is in z but dt = 0 asks for continuous time; write it in s")
    step = sampling_time(True if "z" in names and said is None else dt)
    return RationalBlock(_descending(found.top), _descending(found.bottom), step)


@dataclass(frozen=True, slots=True)
class _Quotient:
    """``top / bottom``; factors common to both are kept."""

    top: fmpq_poly
    bottom: fmpq_poly


def _sum(reader: Reader) -> _Quotient:
    result = _product(reader)
    while at := reader.accept("+", "-"):
        right = _product(reader)
        shared = result.bottom.gcd(right.bottom)
        left_over, right_over = result.bottom // shared, right.bottom // shared
        top = result.top * right_over + (right.top if at.text == "+" else -right.top) * left_over
        result = _checked(reader, at, top, result.bottom * right_over)
    return result


def _product(reader: Reader) -> _Quotient:
    result, divided = _signed(reader), False
    while True:
        if at := reader.accept("*"):
            result = _times(reader, at, result, _signed(reader))
        elif at := reader.accept("/"):
            result, divided = _over(reader, at, result, _signed(reader)), True
        elif reader.token.kind == "name" or (reader.token.kind, reader.token.text) == ("symbol", "("):
            at = reader.token
            if divided:
                reader.refuse(f"a product after / needs * and brackets to say what it divides before {at}")
            result = _times(reader, at, result, _power(reader))
        else:
            return result


def _signed(reader: Reader) -> _Quotient:
    if not (at := reader.accept("+", "-")):
        return _power(reader)
    reader.enter(at)
    inner = _signed(reader)
    reader.leave()
    return _Quotient(-inner.top, inner.bottom) if at.text == "-" else inner


def _power(reader: Reader) -> _Quotient:
    base = _atom(reader)
    if not (at := reader.accept("^", "**")):
        return base
    bracket = reader.accept("(")
    sign = reader.accept("-", "+")
    token = reader.token
    if token.kind != "number" or not token.text.isdigit() or len(token.text) > 4:
        reader.refuse(f"an exponent must be a whole number of at most four digits, found {token}")
    reader.position += 1
    if bracket:
        reader.expect(")", "to close the exponent")
    if reader.token.text in ("^", "**"):
        reader.refuse("a power of a power needs brackets")
    exponent, degree = int(token.text), max(base.top.degree(), base.bottom.degree(), 0)
    if degree * exponent > MAX_ORDER or _bits(base.top, base.bottom) * exponent > _MAX_BITS:
        reader.refuse(f"the power is too large (degrees stop at {MAX_ORDER})", at)
    top, bottom = base.top**exponent, base.bottom**exponent
    if sign is None or sign.text == "+":
        return _checked(reader, at, top, bottom)
    if not top:
        reader.refuse("division by zero", at)
    return _checked(reader, at, bottom, top)


def _atom(reader: Reader) -> _Quotient:
    from flint import fmpq, fmpq_poly

    token = reader.token
    if token.kind == "number":
        reader.position += 1
        value = exact_coefficient(token.text, f"{reader.field}: the number at column {token.column}")
        return _Quotient(fmpq_poly([fmpq(value.numerator, value.denominator)]), fmpq_poly([1]))
    if token.kind == "name":
        if token.text not in reader.variables:
            hint = _HINTS.get(token.text.lower(), "a transfer function is a formula in s, or in z for discrete time")
            reader.refuse(f"unknown name {token} ({hint})")
        reader.position += 1
        return _Quotient(fmpq_poly([0, 1]), fmpq_poly([1]))
    if reader.accept("("):
        return reader.closed(token, _sum)
    reader.refuse(f"expected a number, s, z or '(' but found {token}")


def _times(reader: Reader, at: Token, left: _Quotient, right: _Quotient) -> _Quotient:
    return _checked(reader, at, left.top * right.top, left.bottom * right.bottom)


def _over(reader: Reader, at: Token, left: _Quotient, right: _Quotient) -> _Quotient:
    if not right.top:
        reader.refuse("division by zero", at)
    shared = left.bottom.gcd(right.bottom)
    return _checked(reader, at, left.top * (right.bottom // shared), (left.bottom // shared) * right.top)


def _checked(reader: Reader, at: Token, top: fmpq_poly, bottom: fmpq_poly) -> _Quotient:
    if max(top.degree(), bottom.degree()) > MAX_ORDER or _bits(top, bottom) > _MAX_BITS:
        reader.refuse(f"the formula is too large (degrees stop at {MAX_ORDER})", at)
    return _Quotient(top, bottom)


def _bits(*polynomials: fmpq_poly) -> int:
    return max(max(int(p.numer().height_bits()), int(p.denom()).bit_length()) for p in polynomials)


def _descending(p: fmpq_poly) -> list[Fraction]:
    return [Fraction(int(c.p), int(c.q)) for c in reversed(p.coeffs())]


def _tokens(text: str, field: str) -> list[Token]:
    if len(text) > MAX_LENGTH:
        raise InputError(f"{field}: the text has {len(text)} characters; at most {MAX_LENGTH} are allowed")
    found: list[Token] = []
    position = 0
    while position < len(text):
        if text[position] in " \t\r\n":
            position += 1
            continue
        match = _WORD.match(text, position)
        if match is None:
            raise InputError(
                f"{field}: character {text[position]!a} at column {position + 1} is not allowed; "
                "write numbers, s or z, and + - * / ^ ( )"
            )
        kind: Literal["number", "name", "symbol"] = (
            "number" if match["number"] else "name" if match["name"] else "symbol"
        )
        found.append(Token(kind, match[0], position + 1))
        position = match.end()
    return [*found, Token("end", "", len(text) + 1)]
