"""Transfer functions written as formulas: ``1/(s*(s+1))``, ``z/(z - 0.5)``, with exact coefficients."""

from __future__ import annotations

import re
import reprlib
from collections.abc import Iterable, Sized
from dataclasses import dataclass
from dataclasses import field as dataclasses_field
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias

from lure.errors import InputError
from lure.exact import exact_number
from lure.expressions.parser import Reader, Token
from lure.plants.rational import MAX_ORDER, RationalPlant

if TYPE_CHECKING:
    from flint import fmpq_poly

# Sampling times: what a source and its user say of time, brought to one answer.

ANY_PERIOD: Final = "any"
Stated = Fraction | str | None  # 0 continuous, positive discrete, ANY_PERIOD discrete, None: nothing is said


def stated(dt: object, name: str = "dt") -> Stated:
    """What ``dt`` says in python-control's convention.

    Parameters
    ----------
    dt : object
        None: nothing; 0: continuous time; True: discrete time of unspecified period; a positive number: that period.
    name : str
        Where it stands, for errors.

    Raises
    ------
    InputError
        It is False, negative, not finite or not a number.
    """
    if hasattr(dt, "item") and getattr(dt, "ndim", None) == 0:
        dt = dt.item()
    if dt is None or dt is True:
        return None if dt is None else ANY_PERIOD
    if dt is False:
        raise InputError(f"{name} is False; give 0 or None for continuous time, True or a period for discrete time")
    value = exact_number(dt, name)
    if value < 0:
        raise InputError(f"{name} is {float(value):g}; give a positive period, or 0 for continuous time")
    return value


def sampling_time(given: object, own: object = None, *, name: str = "dt") -> Fraction | Literal[True] | None:
    """The sampling time that a caller's ``dt`` and the source's own one agree on.

    Parameters
    ----------
    given : object
        The caller's word, in python-control's convention: None, 0, True or a positive number.
    own : object
        The source's own ``dt``, in the same convention.
    name : str
        What the source is, for errors.

    Returns
    -------
    Fraction, True or None
        None for continuous time, also if neither says anything; True for discrete time of unspecified period.

    Raises
    ------
    InputError
        One of them is not a sampling time, or they contradict each other.

    Examples
    --------
    >>> sampling_time(None, 0), sampling_time(True), sampling_time(0.5, True)
    (None, True, Fraction(1, 2))
    """
    caller, source = stated(given), stated(own, f"{name}.dt")
    if caller is None or caller == source:
        return _period(source)
    if source is None or (source == ANY_PERIOD and caller):
        return _period(caller)
    if caller == ANY_PERIOD and source:
        return _period(source)
    if isinstance(caller, Fraction) and isinstance(source, Fraction) and caller and float(caller) == float(source):
        return caller  # the decimal that the source holds as a double
    raise InputError(f"dt is {_words(caller)} but {name} is in {_words(source)}; leave dt out or convert the system")


def _period(value: Stated) -> Fraction | Literal[True] | None:
    if value == ANY_PERIOD:
        return True
    return value if isinstance(value, Fraction) and value else None


def _words(value: Stated) -> str:
    if value == ANY_PERIOD:
        return "discrete time"
    return f"discrete time of period {float(value):g}" if isinstance(value, Fraction) and value else "continuous time"


# Lists of exact coefficients, from numbers and from text.

MAX_TEXT = 1 << 16
_MAX_DIGITS = 1000
_MAX_EXPONENT = 400
_DECIMAL = r"(?:[0-9]+\.?[0-9]*|\.[0-9]+)"
_NUMBER = re.compile(rf"([+-]?{_DECIMAL})(?:[eE]([+-]?[0-9]+))?(?:/({_DECIMAL}))?")
_BRACKETS = {"[": "]", "(": ")"}


def coefficients(values: object, name: str = "coefficients") -> tuple[Fraction, ...]:
    """Exact coefficients from a text such as ``"1 3 2 0"`` or from a list of numbers and texts.

    Parameters
    ----------
    values : object
        Text: numbers separated by blanks or commas, with or without brackets around them; each a whole number, a
        decimal, both perhaps with an exponent, or a quotient ``p/q``.  A list: ints, floats (each the double it is),
        Fractions, Decimals, or such texts of one number.
    name : str
        What they are, for errors.

    Raises
    ------
    InputError
        There is none, there are more than 1001, or one is not a finite real number within the range of doubles.

    Examples
    --------
    >>> coefficients("1, 0.1 -2/3 1e-2")
    (Fraction(1, 1), Fraction(1, 10), Fraction(-2, 3), Fraction(1, 100))
    """
    if isinstance(values, str):
        entries: list[object] = list(_coefficients_words(values, name))
    elif isinstance(values, Iterable) and getattr(values, "shape", None) != ():  # an array () cannot be listed
        entries = list(values)
    else:
        raise InputError(f"{name} is {reprlib.repr(values)}; give a list of numbers")
    if not entries:
        raise InputError(f"{name} is empty; give at least one number")
    if len(entries) > MAX_ORDER + 1:
        raise InputError(f"{name} has {len(entries)} entries; exact polynomials stop at degree {MAX_ORDER}")
    return tuple(exact_coefficient(entry, f"{name}[{i}]") for i, entry in enumerate(entries))


def exact_coefficient(value: object, name: str) -> Fraction:
    """The exact number that a coefficient is: a text of one number, or as in :func:`lure.exact.exact_number`.

    Raises
    ------
    InputError
        It is complex, not a number, not finite or outside the range of doubles.
    """
    if isinstance(value, str):
        return _number(value.strip(), name)
    if hasattr(value, "item") and getattr(value, "ndim", None) == 0:
        value = value.item()
    if isinstance(value, complex):
        if value.imag != 0:
            raise InputError(f"{name} is {value}, a complex coefficient; a real loop needs real numbers")
        value = value.real
    if isinstance(value, Sized):
        raise InputError(f"{name} is a list; give one number: a block has one input and one output")
    return exact_number(value, name)


def _coefficients_words(text: str, name: str) -> list[str]:
    if len(text) > MAX_TEXT:
        raise InputError(f"{name} has {len(text)} characters; at most {MAX_TEXT} are allowed")
    inner = text.strip()
    if inner[:1] in _BRACKETS:
        if inner[-1:] != _BRACKETS[inner[0]]:
            raise InputError(f"{name} is {reprlib.repr(text)}; close the bracket {inner[0]!r} at the end")
        inner = inner[1:-1].strip()
    if not inner:
        return []
    if re.search(r"\d,\d", inner) and re.search(r"[^,\s]\s+[^,\s]", inner):
        raise InputError(
            f"{name} is {reprlib.repr(text)}, with commas and with spaces between numbers; write a decimal comma as a "
            f"point, 0.5, or separate all numbers alike"
        )
    parts = [part.strip() for part in inner.split(",")]
    if not all(parts):
        raise InputError(f"{name} is {reprlib.repr(text)} with nothing before or after a comma; give a number there")
    return [word for part in parts for word in part.split()]


def _number(text: str, name: str) -> Fraction:
    match = _NUMBER.fullmatch(text)
    if match is None:
        raise InputError(f"{name} is {reprlib.repr(text)}; give a number such as 2, -0.5, 1e-3 or 2/3")
    mantissa, exponent, below = match.groups()
    if len(text) > 2 * _MAX_DIGITS or (exponent and len(exponent.lstrip("+-0")) > len(str(_MAX_EXPONENT))):
        raise InputError(f"{name} has more than {_MAX_DIGITS} digits or an exponent beyond {_MAX_EXPONENT}; rescale it")
    if below is not None and not Fraction(below):
        raise InputError(f"{name} is {reprlib.repr(text)}, a division by zero; give another denominator")
    value = Fraction(mantissa) * Fraction(10) ** int(exponent or 0) / Fraction(below or 1)
    return exact_number(value, name)


# Polynomials multiplied out exactly from roots in floating point.

_SAME = 1e-12


def polynomial_of_roots(roots: Iterable[complex], name: str = "roots") -> list[Fraction]:
    """Coefficients of ``prod (s - r)``, highest power first, every double taken exactly.

    Parameters
    ----------
    roots : iterable of complex
        Complex ones in conjugate pairs; a pair that agrees only to a few rounding errors counts as the root of the
        pair with positive imaginary part and its exact conjugate.
    name : str
        What they are, for errors.

    Raises
    ------
    InputError
        A root is not finite, or a complex one has no conjugate.
    """
    left, ring = [complex(root) for root in roots], OneVariable()
    product, s = ring.one, ring.variable("s")
    for i, root in enumerate(left):
        for part in (root.real, root.imag):
            exact_number(part, f"{name}[{i}]")
    upper = [root for root in left if root.imag > 0]
    lower = [root for root in left if root.imag < 0]
    for root in upper:
        match = min(lower, key=lambda other: abs(other - root.conjugate()), default=None)
        if match is None or abs(match - root.conjugate()) > _SAME * abs(root):
            raise InputError(f"{name} holds {root:.6g} without its conjugate: the coefficients are complex; add it")
        lower.remove(match)
        x, y = Fraction(root.real), Fraction(root.imag)
        product *= s * s - ring.number(2 * x) * s + ring.number(x * x + y * y)
    if lower:
        raise InputError(f"{name} holds {lower[0]:.6g} without its conjugate: the coefficients are complex; add it")
    for root in left:
        if root.imag == 0:
            product *= s - ring.number(Fraction(root.real))
    return descending(product)


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
_NO_VARIABLE = (
    "a transfer function is a formula in s, or in z for discrete time; of a parameter the file of a plant gives the "
    "interval, in [plant.parameters]"
)


def parse_transfer(text: str, *, dt: object = None, field: str = "transfer") -> RationalPlant:
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
    found, variable = parsed_quotient(text, OneVariable(), field)
    step = step_of_formula(variable, dt, field)
    return RationalPlant(descending(found.top), descending(found.bottom), step)


def step_of_formula(variable: str, dt: object, field: str) -> Fraction | Literal[True] | None:
    """The sampling time of a formula in ``s`` or ``z``; a text in ``z`` without one has period 1.

    Parameters
    ----------
    variable : {"s", "z", ""}
        The variable that occurs.
    dt : None, 0, True or number
        Sampling time in python-control's convention.
    field : str
        Where the text stands, for errors.

    Raises
    ------
    InputError
        The variable contradicts ``dt``.
    """
    said = stated(dt)
    if variable == "s" and said:
        raise InputError(f"{field}: the formula is in s but dt asks for discrete time; write it in z or leave dt out")
    if variable == "z" and said == 0:
        raise InputError(f"{field}: the formula is in z but dt = 0 asks for continuous time; write it in s")
    return sampling_time(True if variable == "z" and said is None else dt)


Element: TypeAlias = Any  # a polynomial of python-flint, in one variable or in several


class OneVariable:
    """The polynomials of a formula: in ``s`` or in ``z``, which stand for each other."""

    names: tuple[str, ...] = ("s", "z")

    @cached_property
    def one(self) -> Element:
        """The constant 1."""
        return self.number(Fraction(1))

    def number(self, value: Fraction) -> Element:
        """A constant."""
        from flint import fmpq, fmpq_poly

        return fmpq_poly([fmpq(value.numerator, value.denominator)])

    def variable(self, name: str) -> Element:
        """``s`` or ``z``."""
        from flint import fmpq_poly

        return fmpq_poly([0, 1])

    def degree(self, p: Element) -> int:
        """The degree, -1 for 0."""
        return int(p.degree())

    def bits(self, p: Element) -> int:
        """The size of the numbers."""
        return max(int(p.numer().height_bits()), int(p.denom()).bit_length())

    def divided_by(self, p: Element) -> None:
        """Told of every polynomial that a formula divides by; in one variable none vanishes."""


def parsed_quotient(text: str, ring: OneVariable, field: str) -> tuple[Quotient, str]:
    """A formula as a quotient of polynomials, and which of ``s`` and ``z`` occurs.

    Parameters
    ----------
    text : str
        As for :func:`parse_transfer`.
    ring : OneVariable
        The polynomials, and the names they may hold.
    field : str
        Where the text stands, for errors.

    Raises
    ------
    InputError
        It is no such formula, or holds both ``s`` and ``z``.
    """
    reader = _Formula(_tokens(text, field), ring.names, field, ring=ring)
    if reader.ended:
        raise InputError(f"{field}: the text is empty; write a transfer function such as 1/(s*(s+1))")
    found = _sum(reader)
    if not reader.ended:
        reader.refuse(f"expected an operator but found {reader.token}")
    names = {token.text for token in reader.tokens if token.kind == "name"} & {"s", "z"}
    if len(names) > 1:
        raise InputError(f"{field}: both s and z occur; write s for continuous or z for discrete time")
    return found, "".join(names)


@dataclass(slots=True)
class _Formula(Reader):
    """The words of a formula, and the polynomials it is made of."""

    ring: OneVariable = dataclasses_field(default_factory=OneVariable)


@dataclass(frozen=True, slots=True)
class Quotient:
    """``top / bottom``; factors common to both are kept."""

    top: Element
    bottom: Element


def _sum(reader: _Formula) -> Quotient:
    result = _product(reader)
    while at := reader.accept("+", "-"):
        right = _product(reader)
        shared = result.bottom.gcd(right.bottom)
        left_over, right_over = result.bottom // shared, right.bottom // shared
        top = result.top * right_over + (right.top if at.text == "+" else -right.top) * left_over
        result = _checked(reader, at, top, result.bottom * right_over)
    return result


def _product(reader: _Formula) -> Quotient:
    result, divided = _signed(reader), False
    while True:
        if at := reader.accept("*"):
            result = _transfer_text_times(reader, at, result, _signed(reader))
        elif at := reader.accept("/"):
            result, divided = _over(reader, at, result, _signed(reader)), True
        elif reader.token.kind == "name" or (reader.token.kind, reader.token.text) == ("symbol", "("):
            at = reader.token
            if divided:
                reader.refuse(f"a product after / needs * and brackets to say what it divides before {at}")
            result = _transfer_text_times(reader, at, result, _power(reader))
        else:
            return result


def _signed(reader: _Formula) -> Quotient:
    if not (at := reader.accept("+", "-")):
        return _power(reader)
    reader.enter(at)
    inner = _signed(reader)
    reader.leave()
    return Quotient(-inner.top, inner.bottom) if at.text == "-" else inner


def _power(reader: _Formula) -> Quotient:
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
    exponent, degree = int(token.text), max(*map(reader.ring.degree, (base.top, base.bottom)), 0)
    bits = max(map(reader.ring.bits, (base.top, base.bottom)))
    if degree * exponent > MAX_ORDER or bits * exponent > _MAX_BITS:
        reader.refuse(f"the power is too large (degrees stop at {MAX_ORDER})", at)
    top, bottom = base.top**exponent, base.bottom**exponent
    if sign is None or sign.text == "+":
        return _checked(reader, at, top, bottom)
    if not top:
        reader.refuse("division by zero", at)
    reader.ring.divided_by(base.top)
    return _checked(reader, at, bottom, top)


def _atom(reader: _Formula) -> Quotient:
    token, one = reader.token, reader.ring.one
    if token.kind == "number":
        reader.position += 1
        value = exact_coefficient(token.text, f"{reader.field}: the number at column {token.column}")
        return Quotient(reader.ring.number(value), one)
    if token.kind == "name":
        if token.text not in reader.variables:
            hint = _HINTS.get(token.text.lower(), _NO_VARIABLE)
            reader.refuse(f"unknown name {token} ({hint})")
        reader.position += 1
        return Quotient(reader.ring.variable(token.text), one)
    if reader.accept("("):
        return reader.closed(token, lambda _: _sum(reader))
    reader.refuse(f"expected a number, s, z or '(' but found {token}")


def _transfer_text_times(reader: _Formula, at: Token, left: Quotient, right: Quotient) -> Quotient:
    return _checked(reader, at, left.top * right.top, left.bottom * right.bottom)


def _over(reader: _Formula, at: Token, left: Quotient, right: Quotient) -> Quotient:
    if not right.top:
        reader.refuse("division by zero", at)
    reader.ring.divided_by(right.top)
    shared = left.bottom.gcd(right.bottom)
    return _checked(reader, at, left.top * (right.bottom // shared), (left.bottom // shared) * right.top)


def _checked(reader: _Formula, at: Token, top: Element, bottom: Element) -> Quotient:
    ring = reader.ring
    if max(map(ring.degree, (top, bottom))) > MAX_ORDER or max(map(ring.bits, (top, bottom))) > _MAX_BITS:
        reader.refuse(f"the formula is too large (degrees stop at {MAX_ORDER})", at)
    return Quotient(top, bottom)


def descending(p: fmpq_poly) -> list[Fraction]:
    """The coefficients, highest power first."""
    return [Fraction(int(c.p), int(c.q)) for c in reversed(p.coeffs())]


@lru_cache(maxsize=64)  # a formula is read for many values of its parameters
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
