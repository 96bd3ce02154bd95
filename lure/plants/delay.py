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
from lure.plants.text import Element, OneVariable, descending
from lure.record import Record, quantity

if TYPE_CHECKING:
    import control

MAX_DEGREE = 100
Polynomial = tuple[Fraction, ...]  # descending powers


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
    r"""A block ``H(s) = sum_j n_j(s) exp(-s T_j) / (d(s) + sum_k q_k(s) exp(-s T_k))`` in continuous time, exact.

    Every ``n_j/d`` and ``q_k/d`` is proper.  With a delayed feedback inside it is an equation of retarded type if every
    ``q_k/d`` is strictly proper, of neutral type if not.

    Parameters
    ----------
    terms : mapping
        ``{T_j: n_j}``, delays [s] ``T_j >= 0`` to coefficients in descending powers.
    denominator : sequence of Fraction
        ``d``, descending powers.
    feedback : mapping
        ``{T_k: q_k}``, as ``terms``; ``T_k > 0``.

    Raises
    ------
    InputError
        A delay is negative, a term improper, everything is zero, or a ``q_k`` has a higher degree than ``d``: the
        equation is of advanced type.

    Examples
    --------
    >>> block = DelayPlant.parse("exp(-s/2)/(s + 1)")
    >>> print(block)
    exp(-0.5 s) / (s + 1)
    >>> print(DelayPlant.parse("1/(s + 2*exp(-s/5))"))
    1 / (s + 2 exp(-0.2 s))
    """

    terms: tuple[tuple[Fraction, tuple[Fraction, ...]], ...] = quantity(
        "", label="dead times", form=lambda terms: ", ".join(f"{float(delay):g} s" for delay, _ in terms)
    )
    denominator: tuple[Fraction, ...] = quantity("", label="order of d", form=lambda d: len(d) - 1)
    feedback: tuple[tuple[Fraction, tuple[Fraction, ...]], ...] = quantity(
        "",
        label="dead times below",
        form=lambda terms: ", ".join(f"{float(delay):g} s" for delay, _ in terms) or "none",
    )
    dt: ClassVar[None] = None
    _kind, _said = "delay block", "text"
    _notes = ("From mu to sigma; in a loop mu = -phi(sigma).",)

    def __init__(
        self,
        terms: Mapping[Fraction, tuple[Fraction, ...]],
        denominator: tuple[Fraction, ...],
        feedback: Mapping[Fraction, tuple[Fraction, ...]] | None = None,
    ) -> None:
        if any(delay < 0 for delay in terms):
            raise InputError(f"the dead time {float(min(terms)):g} s is not causal; give exp(-T*s) with T >= 0")
        blocks = {delay: RationalPlant(top, denominator) for delay, top in sorted(terms.items())}
        kept = tuple((delay, block.numerator) for delay, block in blocks.items() if any(block.numerator))
        if not kept:
            raise InputError("DelayPlant is zero; give a transfer function that is not")
        below = next(iter(blocks.values())).denominator
        object.__setattr__(self, "terms", kept)
        object.__setattr__(self, "denominator", below)
        lead = next(c for c in denominator if c)
        object.__setattr__(self, "feedback", tuple(_inner(feedback or {}, lead, len(below) - 1)))

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
        above, below = ({delay: tuple(descending(p)) for delay, p in side.items()} for side in (top, bottom))
        return cls(above, below.pop(Fraction(0)), below)

    @property
    def delayless(self) -> RationalPlant | None:
        """The same block without the type, if no delay is left in it."""
        if len(self.terms) == 1 and self.terms[0][0] == 0 and not self.feedback:
            return RationalPlant(self.terms[0][1], self.denominator)
        return None

    @property
    def strictly_proper(self) -> bool:
        """Whether all of ``n_j/d`` and ``q_k/d`` are strictly proper: with dead time an equation of retarded type."""
        return all(len(top) < len(self.denominator) for _, top in (*self.terms, *self.feedback))

    def closed(self, gain: Fraction) -> DelayPlant:
        """The plant of the nonlinearity less a gain, ``phi - g sigma``: ``H/(1 + g H)``.

        Parameters
        ----------
        gain : Fraction
            ``g``, of either sign.

        Raises
        ------
        InputError
            ``d + g n_0`` has a lower degree than ``d``: the plant is not strictly proper.
        """
        below = dict(self.feedback) | {Fraction(0): self.denominator}
        for delay, top in self.terms if gain else ():
            own, size = below.get(delay, ()), max(len(below.get(delay, ())), len(top))
            rows = ((Fraction(0),) * (size - len(p)) + p for p in (own, tuple(gain * c for c in top)))
            below[delay] = tuple(a + b for a, b in zip(*rows, strict=True))
        return DelayPlant(dict(self.terms), below.pop(Fraction(0)), below)

    def transfer(self, s: ArrayLike) -> NDArray[np.complex128]:
        """``H(s)``, elementwise, in floating point; not finite at a pole."""
        points = np.asarray(s, dtype=complex)

        def total(terms: tuple[tuple[Fraction, Polynomial], ...]) -> NDArray[np.complex128]:
            """These terms added up."""
            each = (np.polyval([*map(float, top)], points) * np.exp(-float(delay) * points) for delay, top in terms)
            return np.asarray(sum(each, np.zeros(points.shape, dtype=complex)))

        if self.feedback:
            return total(self.terms) / total(((Fraction(0), self.denominator), *self.feedback))
        over = (
            RationalPlant(top, self.denominator).transfer(points) * np.exp(-float(delay) * points)
            for delay, top in self.terms
        )
        return np.asarray(sum(over, np.zeros(points.shape, dtype=complex)))

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

        below = control.TransferFunction([1.0], [float(c) for c in self.denominator])
        above, inner = control.TransferFunction([0.0], [1.0]), control.TransferFunction([0.0], [1.0])
        for delay, top in self.terms:
            term = control.TransferFunction([float(c) for c in top], [1.0])
            above = above + (term * control.TransferFunction(*control.pade(float(delay), pade)) if delay else term)
        for delay, top in self.feedback:
            term = control.TransferFunction([float(c) for c in top], [1.0])
            inner = inner + term * control.TransferFunction(*control.pade(float(delay), pade))
        return above * control.feedback(below, inner) if self.feedback else above * below

    @property
    def _title(self) -> str:
        return f"H(s) = {self}"

    def _rows(self) -> Iterator[tuple[object, ...]]:
        yield "time", "continuous"
        yield from super()._rows()

    def __str__(self) -> str:
        parts = [_term_text(*term) for term in self.terms]
        joined = f"({' + '.join(parts)})" if len(parts) > 1 else parts[0]
        below = [polynomial_text(self.denominator, "s"), *(_term_text(*term) for term in self.feedback)]
        return f"{joined} / ({' + '.join(below)})"


def _term_text(delay: Fraction, top: Polynomial) -> str:
    text = polynomial_text(top, "s")
    text = f"({text})" if " " in text and len(top) > 1 else text
    wait = f"exp(-{float(delay):g} s)"
    return text if delay == 0 else wait if text == "1" else f"{text} {wait}"


def _inner(
    feedback: Mapping[Fraction, Polynomial], lead: Fraction, degree: int
) -> Iterator[tuple[Fraction, Polynomial]]:
    """The terms of a delayed feedback, where ``d`` has this degree and is divided by its first coefficient."""
    for delay, p in sorted(feedback.items()):
        q = tuple(c / lead for c in p[next((k for k, c in enumerate(p) if c), len(p)) :])
        if delay <= 0:
            raise InputError(f"the denominator has the dead time {float(delay):g} s; give dead times > 0 there")
        if len(q) > degree + 1:
            raise InputError(
                f"the denominator has dead time with s^{len(q) - 1} and s^{degree} without: an equation of advanced "
                "type, which is not causal; give as high a power without dead time"
            )
        if q:
            yield delay, q


Sum = dict[Fraction, Element]  # of polynomials times exp(-T s), by T
Quasi = tuple[Sum, Sum]
_RING = OneVariable()


def _one() -> Sum:
    return {Fraction(0): _RING.one}


def _value(node: Node, field: str) -> Quasi:
    if isinstance(node, Number):
        return ({Fraction(0): _RING.number(node.value)} if node.value else {}), _one()
    if isinstance(node, Variable):
        return {Fraction(0): _RING.variable("s")}, _one()
    parts = node.arguments
    if node.operation == "exp":
        return {_delay(_value(parts[0], field), field): _RING.one}, _one()
    if node.operation == "**":
        return _power(_value(parts[0], field), parts[1], field)
    values = [_value(part, field) for part in parts]
    if node.operation == "neg":
        return {delay: -p for delay, p in values[0][0].items()}, values[0][1]
    if node.operation in ("+", "-"):
        (a, p), (b, q) = values
        left, right = _apart(p, q)  # a pole of both summands is one pole of the formula
        added = {delay: c if node.operation == "+" else -c for delay, c in _product(b, left).items()}
        return _sum(_product(a, right), added), _product(p, right)
    if node.operation == "*":
        return _product(values[0][0], values[1][0]), _product(values[0][1], values[1][1])
    if node.operation == "/":
        return _quotient(values[0], values[1], field)
    raise InputError(f"{field}: {node.operation} is not part of a transfer function; use + - * / ** and exp(-T*s)")


def _delay(argument: Quasi, field: str) -> Fraction:
    top, bottom = argument
    if not top:
        return Fraction(0)
    p, q = (descending(side.get(Fraction(0), 0 * _RING.one)) for side in (top, bottom))
    if len(top) == len(bottom) == 1 and len(p) == 2 and p[1] == 0 and len(q) == 1:
        return -p[0] / q[0]
    raise InputError(
        f"{field}: exp must have the form exp(-T*s) with a number T; no other function of s is a dead time"
    )


def _quotient(left: Quasi, right: Quasi, field: str) -> Quasi:
    (a, p), (b, q) = left, right
    if not b:
        raise InputError(f"{field}: the transfer function divides by zero; give a denominator that is not")
    ours, theirs = _apart(p, q)
    above, below = _product(a, theirs), _product(ours, b)
    first = min(below)
    return {time - first: c for time, c in above.items()}, {time - first: c for time, c in below.items()}


def _apart(p: Sum, q: Sum) -> tuple[Sum, Sum]:
    """Two denominators without what they share: a polynomial, or all of both."""
    if p == q:
        return _one(), _one()
    shared = 0 * _RING.one
    for c in (*p.values(), *q.values()):
        shared = shared.gcd(c)
    ours, theirs = ({time: c // shared for time, c in side.items()} for side in (p, q))
    return ours, theirs


def _power(base: Quasi, exponent: Node, field: str) -> Quasi:
    if not isinstance(exponent, Number) or exponent.value.denominator != 1:
        raise InputError(f"{field}: powers of a transfer function have whole exponents; write 1/(s + 1)**2")
    whole = exponent.value.numerator
    result: Quasi = (_one(), _one())
    for _ in range(abs(whole)):
        result = _product(result[0], base[0]), _product(result[1], base[1])
    return _quotient((_one(), _one()), result, field) if whole < 0 else result


def _sum(a: Sum, b: Sum) -> Sum:
    total = {delay: a.get(delay, 0) + b.get(delay, 0) for delay in {*a, *b}}
    return {delay: p for delay, p in total.items() if p}


def _product(a: Sum, b: Sum) -> Sum:
    total: Sum = {}
    for s, p in a.items():
        for t, q in b.items():
            total = _sum(total, {s + t: _times(p, q)})
    return total


def _times(p: Element, q: Element) -> Element:
    if p.degree() + q.degree() > MAX_DEGREE:
        raise InputError(f"the transfer function has a degree above {MAX_DEGREE}; give a simpler one")
    return p * q
