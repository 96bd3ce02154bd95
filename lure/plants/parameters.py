"""Formulas in parameters of which only bounds are known: the polynomials that they are, and what a box of them has."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import product
from math import inf
from typing import TYPE_CHECKING

from lure.bounds import lower_text, upper_text
from lure.errors import InputError
from lure.exact import Exact, exact_number
from lure.plants.text import Element, OneVariable, Quotient, exact_coefficient, parsed_quotient
from lure.record import exact_text, value_text

if TYPE_CHECKING:
    from flint import fmpq

VANISHES = "a denominator in the parameters may vanish in the box; multiply it out, or narrow the box"
MOST_PARAMETERS, MOST_POWER = 6, 12
NAME = re.compile(r"[A-Za-z][A-Za-z_0-9]{0,40}")
RESERVED = ("s", "z", "exp", "inf", "nan")
_WORD, _EXPONENTIAL = re.compile(r"(?<![\w.])[A-Za-z]\w*"), re.compile(r"(?<!\w)exp\s*\(")
Box = tuple[tuple[Fraction, Fraction], ...]
Point = tuple[Fraction, ...]
Bounds = Mapping[str, Exact | tuple[Exact, ...]]


class InBox:
    """What plants with parameters in a box have in common: the names of the parameters and their bounds."""

    names: tuple[str, ...]
    box: Box

    @property
    def middle(self) -> Point:
        """The middle of the box."""
        return tuple((low + high) / 2 for low, high in self.box)

    @property
    def corners(self) -> Iterator[Point]:
        """The corners of the box."""
        return product(*self.box)

    def words(self, point: Sequence[Fraction]) -> str:
        """Values of the parameters in words."""
        return ", ".join(value_text(name, v) for name, v in zip(self.names, point, strict=True))

    @property
    def ranges(self) -> str:
        """The box in words, exactly where that is short, else rounded inwards: no larger one is claimed."""
        rates = getattr(self, "rates", ()) or (0,) * len(self.names)
        how = (
            ""
            if not r
            else " that changes " + ("at any speed" if r == inf else f"by at most {upper_text(r)} in a unit of time")
            for r in rates
        )
        named = zip(self.names, self.box, how, strict=True)
        return ", ".join(f"{one} in [{lower_text(low)}, {upper_text(high)}]{at}" for one, (low, high), at in named)


def checked_box(parameters: Mapping[str, tuple[Exact, Exact]], powers: Sequence[Sequence[int]]) -> Box:
    """The bounds of the parameters of plants.

    ``powers``: the exponents that occur in the plants, one for each parameter.

    Raises
    ------
    InputError
        There are none or too many, one has no interval, does not occur, or to too high a power.
    """
    box = tuple(interval(name, ends) for name, ends in parameters.items())
    if not 0 < len(box) <= MOST_PARAMETERS:
        raise InputError(f"there are {len(box)} parameters with an interval; give 1 to {MOST_PARAMETERS}")
    for j, name in enumerate(parameters):
        highest = max((e[j] for e in powers), default=0)
        if not highest:
            raise InputError(f"parameters.{name} does not occur in the plant; leave it out, or use it")
        if highest > MOST_POWER:
            raise InputError(f"parameters.{name} occurs to the power {highest}; powers up to {MOST_POWER} are read")
    return box


def interval(name: str, ends: tuple[Exact, Exact]) -> tuple[Fraction, Fraction]:
    """The bounds of a parameter."""
    low, high = (exact_coefficient(end, f"parameters.{name}") for end in ends)
    if not low < high:
        raise InputError(
            f"parameters.{name} is [{float(low):g}, {float(high):g}]; the first must be smaller than the second, or "
            "give one number for a constant"
        )
    return low, high


class Constants(OneVariable):
    """Polynomials in ``s``, or ``z``; parameters that are no intervals stand for their numbers."""

    def __init__(self, parameters: Bounds) -> None:
        for name in parameters:
            if not NAME.fullmatch(name) or name in RESERVED:
                raise InputError(f"parameters.{name!r:.40} is no name here; give letters, digits and _, and not s or z")
        self.names = ("s", "z", *parameters)
        self.constants = {
            name: exact_coefficient(value, f"parameters.{name}")
            for name, value in parameters.items()
            if not isinstance(value, tuple | list)
        }

    def put_in(self, text: str) -> str:
        """A formula with the numbers of the constants in place of their names."""
        return _WORD.sub(lambda word: f"({self.constants[word[0]]})" if word[0] in self.constants else word[0], text)

    def variable(self, name: str) -> Element:
        """``s``, ``z`` or a number."""
        return self.number(self.constants[name]) if name in self.constants else super().variable(name)


class Ring(Constants):
    """Polynomials in ``s``, or ``z``, and the parameters; constants stand for their numbers."""

    def __init__(self, parameters: Bounds) -> None:
        from flint import Ordering, fmpq_mpoly_ctx

        super().__init__(parameters)
        pairs = {name: ends for name, ends in parameters.items() if isinstance(ends, tuple | list)}
        self.parameters = {name: (ends[0], ends[1]) for name, ends in pairs.items()}
        self.rates = tuple(_rate(name, ends[2:]) for name, ends in pairs.items())
        self.context = fmpq_mpoly_ctx.get(["s", *(f"p_{i}" for i in range(len(pairs)))], Ordering.lex)
        self.generators = dict(zip(self.parameters, self.context.gens()[1:], strict=True))
        self.divisors = list[Element]()

    def number(self, value: Fraction) -> Element:
        """A constant."""
        from flint import fmpq

        return self.context.constant(fmpq(value.numerator, value.denominator))

    def variable(self, name: str) -> Element:
        """``s``, ``z`` or a parameter."""
        if name in self.constants:
            return self.number(self.constants[name])
        return self.generators[name] if name in self.generators else self.context.gens()[0]

    def product(self, powers: Sequence[int], value: Fraction) -> Element:
        """A number times powers of the parameters."""
        return (
            self.context.from_dict({(0, *powers): self.number(value).leading_coefficient()})
            if value
            else self.number(value)
        )

    def degree(self, p: Element) -> int:
        """The highest power of any."""
        return max((int(e) for powers in p.to_dict() for e in powers), default=-1)

    def bits(self, p: Element) -> int:
        """The size of the numbers, times their count."""
        numbers = p.to_dict().values()
        return sum(max(int(c.p).bit_length(), int(c.q).bit_length()) for c in numbers)

    def divided_by(self, p: Element) -> None:
        """Keep what is divided by: where it vanishes in the box there is no plant."""
        self.divisors.append(p)


def names_in(side: object) -> set[str]:
    """The names that occur in formulas, in a text or in nested lists of such; ``side``: what is neither has none."""
    if isinstance(side, str):
        return set(_WORD.findall(side))
    return {name for part in side for name in names_in(part)} if isinstance(side, list | tuple) else set()


Pair = tuple[Element, Element]
Rate = Fraction | float


def _rate(name: str, given: Sequence[Exact]) -> Rate:
    """How fast a parameter may change: 0 for a constant, infinity for any speed."""
    rate = Fraction(0) if not given else inf if given[0] == inf else exact_number(given[0], f"parameters.{name}.rate")
    if rate < 0 or len(given) > 1:
        raise InputError(f"parameters.{name} has the rate {float(rate):g}; give one number from 0 on, inf for any")
    return rate


def parsed(text: str, ring: Ring, field: str) -> tuple[Quotient, str]:
    """A formula as a quotient; nothing that it divides by, at any depth, vanishes for parameters in the box."""
    if _EXPONENTIAL.search(text) and "exp" not in ring.names:
        raise InputError(
            f"{field} is {text!r:.50}, with a dead time, which beside parameters is read in one channel alone, as a "
            "factor of transfer such as exp(-T*s)*k/(s + 1); write it so, or give each parameter one number"
        )
    ring.divisors.clear()
    found, variable = parsed_quotient(text, ring, field)
    for divisor in ring.divisors:
        for factor, _ in divisor.factor()[1]:
            coefficients = in_s(factor, ring)  # it vanishes where they all do, and with it what keeps it as a factor
            kept = len(coefficients) > 1 and not found.bottom % factor
            if not kept and not any(_apart(p, ring) for p in coefficients):
                raise InputError(VANISHES)
    return found, variable


def dead_times_apart(
    text: str, ring: Ring, parameters: Bounds, field: str
) -> tuple[Quotient, str, tuple[Fraction, ...]]:
    """The same of a formula with factors ``exp(-T*s)``, and ``T = c_0 + sum c_j p_j`` of all; ``T`` empty for none.

    Each stands as one more letter in the formula, between 1/2 and 1, of which the same power has to be in all terms.

    Raises
    ------
    InputError
        It is none, or has dead times in a part only.
    """
    if "exp" in ring.names or not _EXPONENTIAL.search(text):
        return (*parsed(text, ring, field), ())
    letters, waits, rest = list[str](), list[list[Fraction]](), text
    while at := _EXPONENTIAL.search(rest):
        letter, depth, end = f"late{'_' * (1 + max(map(len, ring.names)))}{len(letters)}", 1, at.end()
        while depth and end < len(rest):
            depth += {"(": 1, ")": -1}.get(rest[end], 0)
            end += 1
        if depth:
            raise InputError(f"{field} is {text!r:.50}; close the bracket of exp")
        waits.append(_dead_time(rest[at.end() : end - 1], ring, field))
        letters.append(letter)
        rest = f"{rest[: at.start()]} {letter} {rest[end:]}"
    wider = Ring({**parameters, **dict.fromkeys(letters, (Fraction(1, 2), Fraction(1)))})
    found, variable = parsed(rest, wider, field)
    if variable == "z":
        raise InputError(f"{field}: exp(-T*s) is a dead time in continuous time; write z^-n in discrete time")
    m, sides, powers = 1 + len(ring.parameters), list[Element](), list[tuple[int, ...]]()
    for side in (found.top, found.bottom):
        terms = {tuple(int(e) for e in key): c for key, c in side.to_dict().items()}
        if len({key[m:] for key in terms}) != 1:
            raise InputError(
                f"{field} is {text!r:.50}; beside parameters a dead time is a factor of the whole numerator, "
                "exp(-T*s)*(..)/(..): write it so, or give each parameter one number"
            )
        powers.append(next(iter(terms))[m:])
        sides.append(ring.context.from_dict({key[:m]: c for key, c in terms.items()}))
    counts = [up - down for up, down in zip(*powers, strict=True)]
    late = [sum((n * wait[j] for n, wait in zip(counts, waits, strict=True)), Fraction(0)) for j in range(m)]
    return Quotient(*sides), "s", tuple(late)


def _dead_time(argument: str, ring: Ring, field: str) -> list[Fraction]:
    """``T`` of an argument ``-T s``: its constant part and the share of each parameter."""
    found, variable = parsed(argument, ring, field)
    terms = {tuple(int(e) for e in key): c for key, c in found.top.to_dict().items()}
    if variable not in ("", "s") or ring.degree(found.bottom) > 0 or any(k[0] != 1 or sum(k) > 2 for k in terms):
        raise InputError(
            f"{field}: exp has the argument {argument!r:.40}; beside parameters give exp(-T*s) with a number or a "
            "parameter T, or a sum of such"
        )
    below, wait = found.bottom.leading_coefficient(), [Fraction(0)] * (1 + len(ring.parameters))
    for key, c in terms.items():
        wait[key.index(1, 1) if sum(key) > 1 else 0] = -Fraction(int((c / below).p), int((c / below).q))
    return wait


def entries(values: Iterable[object], ring: Ring, name: str) -> list[Pair]:
    """Each entry, a number or a formula in the parameters, as a quotient."""
    found = list[Pair]()
    for i, value in enumerate(values):
        where = f"{name}[{i}]"
        if not isinstance(value, str):
            found.append((ring.number(exact_number(value, where)), ring.number(Fraction(1))))
            continue
        quotient, variable = parsed(value, ring, where)
        if variable:
            raise InputError(
                f"{where} is {value!r:.60}, which holds {variable}; give a formula in the parameters alone"
            )
        found.append((quotient.top, quotient.bottom))
    return found


def flat(side: object) -> list[object]:
    """A vector, whether it was given as a row, a column or a list."""
    rows = list(side) if isinstance(side, Sequence) and not isinstance(side, str) else [side]
    return [v for row in rows for v in (row if isinstance(row, Sequence) and not isinstance(row, str) else [row])]


def over_common(sides: Iterable[Sequence[Pair]], ring: Ring) -> tuple[list[list[Element]], Element]:
    """All over one denominator, which has no zero in the box."""
    listed, common = [list(side) for side in sides], ring.number(Fraction(1))
    for side in listed:
        for _, bottom in side:
            common = common * (bottom // common.gcd(bottom))
    require_apart(common, ring)
    return [[top * (common // bottom) for top, bottom in side] for side in listed], common


def require_apart(p: Element, ring: Ring) -> None:
    """Refuse a denominator that may vanish in the box."""
    if not _apart(p, ring):
        raise InputError(VANISHES)


def _apart(p: Element, ring: Ring) -> bool:
    """Whether intervals with rational ends, factor by factor, show that a polynomial has no zero in the box."""
    if not p:
        return False
    # the variable itself, s or z, is not in a denominator
    boxes = [(Fraction(0), Fraction(0)), *(interval(name, ends) for name, ends in ring.parameters.items())]
    for factor, _ in p.factor()[1]:
        low = high = Fraction(0)
        for powers, c in factor.to_dict().items():
            ends = [Fraction(int(c.p), int(c.q))] * 2
            for (least, most), e in zip(boxes, powers, strict=True):
                raised = [least ** int(e), most ** int(e), *([Fraction(0)] if e and least < 0 < most else [])]
                products = [a * b for a in ends for b in (min(raised), max(raised))]
                ends = [min(products), max(products)]
            low, high = low + ends[0], high + ends[1]
        if low <= 0 <= high:
            return False
    return True


def in_s(p: Element, ring: Ring) -> list[Element]:
    """The coefficients of a polynomial in ``s``, highest power first."""
    parts: dict[int, dict[tuple[int, ...], fmpq]] = {}
    for powers, c in p.to_dict().items():
        parts.setdefault(int(powers[0]), {})[(0, *powers[1:])] = c
    return [ring.context.from_dict(parts.get(k, {})) for k in range(max(parts, default=0), -1, -1)]


def sum_text(terms: Sequence[tuple[tuple[int, ...], Fraction]], names: Sequence[str]) -> str:
    """A polynomial in the parameters, exactly, as a formula that is read again; ``terms``: its coefficients."""
    parts = list[str]()
    for powers, c in terms:
        if not c:
            continue
        letters = [name if e == 1 else f"{name}^{e}" for name, e in zip(names, powers, strict=True) if e]
        size = exact_text(abs(c), 12) if Fraction(exact_text(abs(c), 12)) == abs(c) else str(abs(c))
        body = "*".join([size, *letters] if size != "1" or not letters else letters)
        parts.append(
            f"{'-' if c < 0 else '+' if parts else ''}{body}" if not parts else f" {'-' if c < 0 else '+'} {body}"
        )
    return "".join(parts) or "0"
