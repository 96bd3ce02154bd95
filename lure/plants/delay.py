"""Transfer functions with dead time: rational functions of ``s`` times ``exp(-s T)``, added up."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, ClassVar

from lure.arrays import ArrayLike, NDArray, np
from lure.errors import InputError
from lure.expressions.parser import parse
from lure.expressions.tree import Node, Number, Variable
from lure.plants.rational import RationalPlant, polynomial_text
from lure.record import Record, quantity

if TYPE_CHECKING:
    import control

MAX_DEGREE = 100
Polynomial = tuple[Fraction, ...]  # ascending powers, no trailing zero


def require_pade_order(pade: int | None, what: str, instead: str = "") -> None:
    """Refuse an approximation of dead times that is not asked for, or of no order from 1 to 20."""
    if pade is None:
        raise InputError(
            f"python-control has no dead time, and {what}; give to_control(pade=4) for an approximation, about which "
            f"no answer of lure is{instead}"
        )
    if isinstance(pade, bool) or not isinstance(pade, int) or not 1 <= pade <= 20:
        raise InputError(f"pade is {pade!r:.40}; give the order of the approximation, a whole number from 1 to 20")


class DelayPlant(Record):
    r"""A block ``H(s) = sum_j n_j(s) exp(-s T_j) / d(s)`` in continuous time, all coefficients and delays exact.

    Every ``n_j/d`` is proper.  Delays in the denominator (a delayed feedback inside the block) are not covered.

    Parameters
    ----------
    terms : mapping
        ``{T_j: n_j}``, delays [s] ``T_j >= 0`` to coefficients in descending powers.
    denominator : sequence of Fraction
        ``d``, descending powers.

    Raises
    ------
    InputError
        A delay is negative, a term improper, or everything is zero.

    Examples
    --------
    >>> block = DelayPlant.parse("exp(-s/2)/(s + 1)")
    >>> print(block)
    exp(-0.5 s) / (s + 1)
    """

    terms: tuple[tuple[Fraction, tuple[Fraction, ...]], ...] = quantity(
        "", label="dead times", form=lambda terms: ", ".join(f"{float(delay):g} s" for delay, _ in terms)
    )
    denominator: tuple[Fraction, ...] = quantity("", label="order of d", form=lambda d: len(d) - 1)
    dt: ClassVar[None] = None
    _kind, _said = "delay block", "text"
    _notes = ("From mu to sigma; in a loop mu = -phi(sigma).",)

    def __init__(self, terms: Mapping[Fraction, tuple[Fraction, ...]], denominator: tuple[Fraction, ...]) -> None:
        if any(delay < 0 for delay in terms):
            raise InputError(f"DelayPlant has the delay {float(min(terms)):g} s, which foresees; give delays >= 0")
        blocks = {delay: RationalPlant(top, denominator) for delay, top in sorted(terms.items())}
        kept = tuple((delay, block.numerator) for delay, block in blocks.items() if any(block.numerator))
        if not kept:
            raise InputError("DelayPlant is zero; give a transfer function that is not")
        object.__setattr__(self, "terms", kept)
        object.__setattr__(self, "denominator", next(iter(blocks.values())).denominator)

    @classmethod
    def parse(cls, text: str, *, field: str = "transfer") -> DelayPlant:
        """Read a formula in ``s`` such as ``exp(-0.3*s)/(s*(s+1)) + 2/(s+3)``.

        Parameters
        ----------
        text : str
            ``+ - * / **`` (whole exponents), parentheses, exact decimals and ``exp`` of ``-T*s``.
        field : str
            Where the text stands, for errors.

        Raises
        ------
        InputError
            It is not such a formula, or not proper.
        """
        top, bottom = _value(parse(text, variables=("s",), field=field), field)
        return cls({delay: tuple(reversed(p)) for delay, p in top.items()}, tuple(reversed(bottom)))

    @property
    def delayless(self) -> RationalPlant | None:
        """The same block without the type, if no delay is left in it."""
        if len(self.terms) == 1 and self.terms[0][0] == 0:
            return RationalPlant(self.terms[0][1], self.denominator)
        return None

    def transfer(self, s: ArrayLike) -> NDArray[np.complex128]:
        """``H(s)``, elementwise, in floating point; not finite at a pole."""
        points = np.asarray(s, dtype=complex)
        parts = [
            RationalPlant(top, self.denominator).transfer(points) * np.exp(-float(delay) * points)
            for delay, top in self.terms
        ]
        return np.asarray(sum(parts))

    def to_control(self, *, pade: int | None = None) -> control.TransferFunction:
        """The block with each dead time replaced by its Pade approximation: python-control has no dead time.

        Parameters
        ----------
        pade : int
            Order of the approximation, 1 to 20.  The system returned is another one: no answer about this block is one
            about it, nor the other way round.

        Raises
        ------
        InputError
            No order is given: an approximation is not made unasked.
        """
        require_pade_order(pade, f"the block is {self}", ", or draw with popov_response(block).to_control()")
        import control

        total = control.TransferFunction([0.0], [1.0])
        for delay, top in self.terms:
            term = control.TransferFunction([float(c) for c in top], [1.0])
            total = total + (term * control.TransferFunction(*control.pade(float(delay), pade)) if delay else term)
        return total * control.TransferFunction([1.0], [float(c) for c in self.denominator])

    @property
    def _title(self) -> str:
        return f"H(s) = {self}"

    def _rows(self) -> Iterator[tuple[object, ...]]:
        yield "time", "continuous"
        yield from super()._rows()

    def __str__(self) -> str:
        parts = []
        for delay, top in self.terms:
            text = polynomial_text(top, "s")
            text = f"({text})" if " " in text and len(top) > 1 else text
            wait = f"exp(-{float(delay):g} s)"
            parts.append(text if delay == 0 else wait if text == "1" else f"{text} {wait}")
        joined = " + ".join(parts)
        joined = f"({joined})" if len(parts) > 1 else joined
        return f"{joined} / ({polynomial_text(self.denominator, 's')})"


Quasi = tuple[dict[Fraction, Polynomial], Polynomial]


def _value(node: Node, field: str) -> Quasi:
    one: Polynomial = (Fraction(1),)
    if isinstance(node, Number):
        return ({Fraction(0): (node.value,)} if node.value else {}), one
    if isinstance(node, Variable):
        return {Fraction(0): (Fraction(0), Fraction(1))}, one
    parts = node.arguments
    if node.operation == "exp":
        return {_delay(_value(parts[0], field), field): one}, one
    if node.operation == "**":
        return _power(_value(parts[0], field), parts[1], field)
    values = [_value(part, field) for part in parts]
    if node.operation == "neg":
        return _scaled(values[0][0], (Fraction(-1),)), values[0][1]
    if node.operation in ("+", "-"):
        (a, p), (b, q) = values
        sign = Fraction(1 if node.operation == "+" else -1)
        shared = _gcd(p, q)  # a pole of both summands is one pole of the formula
        left, right = _divided(q, shared), _divided(p, shared)
        return _sum(_scaled(a, left), _scaled(b, _times(right, (sign,)))), _times(p, left)
    if node.operation == "*":
        return _product(values[0][0], values[1][0]), _times(values[0][1], values[1][1])
    if node.operation == "/":
        return _quotient(values[0], values[1], field)
    raise InputError(f"{field}: {node.operation} is not part of a transfer function; use + - * / ** and exp(-T*s)")


def _delay(argument: Quasi, field: str) -> Fraction:
    top, bottom = argument
    if not top:
        return Fraction(0)
    p = top.get(Fraction(0), ())
    if len(top) == 1 and len(p) == 2 and p[0] == 0 and len(bottom) == 1:
        return -p[1] / bottom[0]
    raise InputError(
        f"{field}: exp must have the form exp(-T*s) with a number T; no other function of s is a dead time"
    )


def _quotient(left: Quasi, right: Quasi, field: str) -> Quasi:
    (a, p), (b, q) = left, right
    if not b:
        raise InputError(f"{field}: the transfer function divides by zero; give a denominator that is not")
    if len(b) > 1:
        raise InputError(
            f"{field}: a dead time in a sum in the denominator (delayed feedback) is not covered; give one in the "
            "numerator"
        )
    delay, bottom = next(iter(b.items()))
    return {time - delay: _times(c, q) for time, c in a.items()}, _times(p, bottom)


def _power(base: Quasi, exponent: Node, field: str) -> Quasi:
    if not isinstance(exponent, Number) or exponent.value.denominator != 1:
        raise InputError(f"{field}: powers of a transfer function have whole exponents; write 1/(s + 1)**2")
    whole = exponent.value.numerator
    one: Quasi = ({Fraction(0): (Fraction(1),)}, (Fraction(1),))
    result = one
    for _ in range(abs(whole)):
        result = _product(result[0], base[0]), _times(result[1], base[1])
    return _quotient(one, result, field) if whole < 0 else result


def _sum(a: dict[Fraction, Polynomial], b: dict[Fraction, Polynomial]) -> dict[Fraction, Polynomial]:
    total = {delay: _add(a.get(delay, ()), b.get(delay, ())) for delay in {*a, *b}}
    return {delay: p for delay, p in total.items() if p}


def _scaled(a: dict[Fraction, Polynomial], factor: Polynomial) -> dict[Fraction, Polynomial]:
    return {delay: _times(p, factor) for delay, p in a.items()}


def _product(a: dict[Fraction, Polynomial], b: dict[Fraction, Polynomial]) -> dict[Fraction, Polynomial]:
    total: dict[Fraction, Polynomial] = {}
    for s, p in a.items():
        for t, q in b.items():
            total = _sum(total, {s + t: _times(p, q)})
    return total


def _add(p: Polynomial, q: Polynomial) -> Polynomial:
    size = max(len(p), len(q))
    padded = [list(side) + [Fraction(0)] * (size - len(side)) for side in (p, q)]
    total = [a + b for a, b in zip(*padded, strict=True)]
    while total and total[-1] == 0:
        total.pop()
    return tuple(total)


def _gcd(p: Polynomial, q: Polynomial) -> Polynomial:
    """Euclid's greatest common divisor, monic."""
    while q:
        p, q = q, _rest(p, q)[1]
    return tuple(c / p[-1] for c in p)


def _divided(p: Polynomial, q: Polynomial) -> Polynomial:
    return _rest(p, q)[0]


def _rest(p: Polynomial, q: Polynomial) -> tuple[Polynomial, Polynomial]:
    """Quotient and remainder."""
    rest, quotient = list(p), [Fraction(0)] * max(len(p) - len(q) + 1, 0)
    for shift in range(len(quotient) - 1, -1, -1):
        factor = rest[shift + len(q) - 1] / q[-1]
        quotient[shift] = factor
        for i, c in enumerate(q):
            rest[shift + i] -= factor * c
    return _add(tuple(quotient), ()), _add(tuple(rest), ())


def _times(p: Polynomial, q: Polynomial) -> Polynomial:
    if not p or not q:
        return ()
    if len(p) + len(q) > MAX_DEGREE + 2:
        raise InputError(f"the transfer function has a degree above {MAX_DEGREE}; give a simpler one")
    total = [Fraction(0)] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            total[i + j] += a * b
    return tuple(total)
