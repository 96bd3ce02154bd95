"""Plants whose coefficients depend on parameters that are constant but known only to lie in a box."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import product
from math import prod
from typing import TYPE_CHECKING, Literal

from lure.errors import InputError
from lure.exact import Exact, exact_number
from lure.plants.rational import RationalPlant, sampling_period, time_text
from lure.plants.text import Element, OneVariable, Quotient, exact_coefficient, parsed_quotient, step_of_formula
from lure.record import Record, exact_text, quantity

if TYPE_CHECKING:
    from flint import fmpq

_VANISHES = "a denominator in the parameters may vanish in the box; multiply it out, or narrow the box"
MOST_PARAMETERS, MOST_POWER, MOST_ORDER = 6, 12, 40
NAME = re.compile(r"[A-Za-z][A-Za-z_0-9]{0,40}")
RESERVED = ("s", "z", "exp", "inf", "nan")
Box = tuple[tuple[Fraction, Fraction], ...]
Point = tuple[Fraction, ...]
Term = tuple[tuple[int, ...], tuple[Fraction, ...], tuple[Fraction, ...]]
Entry = Fraction | str
Bounds = Mapping[str, Exact | tuple[Exact, Exact]]


class PlantFamily(Record):
    r"""All plants ``H(s) = sum_e p^e n_e(s) / sum_e p^e d_e(s)`` with the parameters ``p`` in a box.

    The parameters are real and constant; nothing is known of them but their bounds.  What is said of the family is said
    of every plant of it.

    Parameters
    ----------
    parameters : mapping of str to (number, number)
        The bounds of each parameter, the smaller first, in the order of the exponents.
    terms : sequence of (exponents, numerator, denominator)
        For each product ``p^e`` of powers the coefficients of ``n_e`` and ``d_e``, highest power first, of one length.
    dt : Fraction, True or None
        Sampling time [s]; None for continuous time.

    Raises
    ------
    InputError
        There is no parameter, one has no interval or does not matter, or the plants are no proper ones of order 1 on.

    Examples
    --------
    >>> family = PlantFamily.of_coefficients(["b"], [1, 1, "a"], {"a": (1, 2), "b": (0.5, 1)})
    >>> print(family.at((Fraction(2), Fraction(1))))
    1 / (s^2 + s + 2)
    """

    names: tuple[str, ...] = quantity("The parameters", label="parameters")
    box: Box = quantity("Their bounds", form=lambda box: ", ".join(f"[{float(a):g}, {float(b):g}]" for a, b in box))
    terms: tuple[Term, ...] = quantity("Exponents of the parameters with numerator and denominator", label="")
    dt: Fraction | None = quantity("Sampling time", "s", label="time", form=lambda dt: time_text(dt))
    any_period: bool = quantity("", hidden=True)
    _kind, _said = "plants with parameters", "text"
    _notes = ("From mu to sigma; in a loop mu = -phi(sigma). Parameters are constant.",)

    def __init__(
        self,
        parameters: Mapping[str, tuple[Exact, Exact]],
        terms: Sequence[Term],
        dt: int | float | Fraction | None = None,
    ) -> None:
        names, box = tuple(parameters), tuple(_interval(name, ends) for name, ends in parameters.items())
        if not 0 < len(names) <= MOST_PARAMETERS:
            raise InputError(f"there are {len(names)} parameters with an interval; give 1 to {MOST_PARAMETERS}")
        kept = tuple((e, n, d) for e, n, d in sorted(terms) if any(n) or any(d))
        for j, name in enumerate(names):
            highest = max((e[j] for e, *_ in kept), default=0)
            if not highest:
                raise InputError(f"parameters.{name} does not occur in the plant; leave it out, or use it")
            if highest > MOST_POWER:
                raise InputError(f"parameters.{name} occurs to the power {highest}; powers up to {MOST_POWER} are read")
        order = len(kept[0][2]) - 1
        if not 0 < order <= MOST_ORDER:
            raise InputError(f"the plants with parameters have order {order}; give ones of order 1 to {MOST_ORDER}")
        if not any(d[0] for *_, d in kept):
            raise InputError("the plants with parameters are improper; give a denominator of at least the other degree")
        object.__setattr__(self, "names", names)
        object.__setattr__(self, "box", box)
        object.__setattr__(self, "terms", kept)
        object.__setattr__(self, "dt", sampling_period(dt, "dt"))
        object.__setattr__(self, "any_period", dt is True)

    @classmethod
    def of_coefficients(
        cls, numerator: Sequence[object], denominator: Sequence[object], parameters: Bounds, dt: object = None
    ) -> PlantFamily | RationalPlant:
        """The plants of coefficients that are formulas in the parameters.

        Parameters
        ----------
        numerator, denominator : sequence of number or str
            Highest power first; each a number or a formula in the parameters.
        parameters : mapping of str to number or (number, number)
            Bounds of each; one number for a constant.
        dt : object
            Sampling time, as for :func:`lure.as_plant`.

        Returns
        -------
        PlantFamily or RationalPlant
            The latter if every parameter is a constant.

        Raises
        ------
        InputError
            A formula is none, or the class refuses the plants.
        """
        ring = _Ring(parameters)
        sides = (_entries(numerator, ring, "num"), _entries(denominator, ring, "den"))
        return _family(_cleared(sides, ring), ring, step_of_formula("", dt, "plant"))

    @classmethod
    def of_formula(cls, text: str, parameters: Bounds, dt: object = None) -> PlantFamily | RationalPlant:
        """The plants of a transfer function that is a formula in ``s`` or ``z`` and the parameters.

        Parameters
        ----------
        text : str
            The formula.
        parameters, dt
            As for :meth:`of_coefficients`.

        Raises
        ------
        InputError
            As there.
        """
        ring = _Ring(parameters)
        found, variable = _parsed(text, ring, "transfer")
        sides = (_in_s(found.top, ring), _in_s(found.bottom, ring))
        return _family(sides, ring, step_of_formula(variable, dt, "transfer"))

    @classmethod
    def of_matrices(  # noqa: PLR0913  (four matrices, the bounds and the time)
        cls,
        A: Sequence[Sequence[object]],
        B: Sequence[object],
        C: Sequence[object],
        D: object,
        parameters: Bounds,
        dt: object = None,
    ) -> PlantFamily | RationalPlant:
        """The plants of state equations whose entries are formulas in the parameters.

        ``d = det(s - A)`` with every mode, seen or not, and ``n = det(s - A + B C) - d + D d``.

        Parameters
        ----------
        A, B, C, D : sequence
            ``x' = A x + B mu``, ``sigma = C x + D mu``, of one input and one output.
        parameters, dt
            As for :meth:`of_coefficients`.

        Raises
        ------
        InputError
            As there; or the shapes do not fit.
        """
        ring, b, c = _Ring(parameters), _flat(B), _flat(C)
        n = len(A)
        if not n or any(len(row) != n for row in A) or len(b) != n or len(c) != n:
            raise InputError(
                f"plant: with parameters A is square, B and C have one entry for each state; got A of {n} rows, B of "
                f"{len(b)} and C of {len(c)} entries"
            )
        rows = [_entries(row, ring, f"A[{i}]") for i, row in enumerate(A)]
        given = [*(v for row in rows for v in row), *_entries([*b, *c, D], ring, "B, C, D")]
        (entries,), common = _over_common((given,), ring)
        A_, rest = [entries[i * n : (i + 1) * n] for i in range(n)], entries[n * n :]
        direct, unit = rest[-1], ring.number(Fraction(1))
        first = _characteristic(A_, ring)  # of common A
        closed = [
            [common * v - b_ * c_ for v, c_ in zip(row, rest[n:], strict=False)]
            for row, b_ in zip(A_, rest, strict=False)
        ]
        second = _characteristic(closed, ring)  # of common^2 (A - b c)
        powers = [unit]
        for _ in range(2 * n + 1):
            powers.append(powers[-1] * common)
        d = [v * powers[2 * n - i] for i, v in enumerate(first)]  # common^2n det(s - A)
        looped = [v * powers[2 * n - 2 * i] for i, v in enumerate(second)]
        top = [common * (q - p) + direct * p for p, q in zip(d, looped, strict=True)]
        return _family((top, [common * v for v in d]), ring, step_of_formula("", dt, "plant"))

    @property
    def order(self) -> int:
        """The number of states."""
        return len(self.terms[0][2]) - 1

    @property
    def degrees(self) -> tuple[int, ...]:
        """The highest power of each parameter."""
        return tuple(max(e[j] for e, *_ in self.terms) for j in range(len(self.names)))

    @property
    def middle(self) -> Point:
        """The middle of the box."""
        return tuple((low + high) / 2 for low, high in self.box)

    @property
    def corners(self) -> Iterator[Point]:
        """The corners of the box."""
        return product(*self.box)

    @property
    def variable(self) -> str:
        """``s`` in continuous time, ``z`` in discrete time."""
        return "s" if self.dt is None else "z"

    @property
    def central(self) -> RationalPlant:
        """The plant with the parameters in the middle of the box, for what can be drawn of one plant only."""
        return self.at(self.middle)

    def at(self, point: Sequence[Fraction]) -> RationalPlant:
        """The plant with these parameters.

        Parameters
        ----------
        point : sequence of Fraction
            A value for each, in order; outside the box too.

        Raises
        ------
        InputError
            The denominator vanishes there.
        """
        weights = [
            prod((v**e for v, e in zip(point, powers, strict=True)), start=Fraction(1)) for powers, *_ in self.terms
        ]
        top, bottom = (
            [
                sum((w * term[i][k] for w, term in zip(weights, self.terms, strict=True)), Fraction(0))
                for k in range(self.order + 1)
            ]
            for i in (1, 2)
        )
        return RationalPlant(top, bottom, True if self.any_period else self.dt)

    def within(self, box: Box) -> PlantFamily:
        """The plants of another box of the same parameters.

        Parameters
        ----------
        box : tuple of (Fraction, Fraction)
            The bounds.
        """
        return PlantFamily(dict(zip(self.names, box, strict=True)), self.terms, True if self.any_period else self.dt)

    def words(self, point: Sequence[Fraction]) -> str:
        """Values of the parameters in words.

        Parameters
        ----------
        point : sequence of Fraction
            The values.
        """
        return ", ".join(f"{name} = {exact_text(v, 8)}" for name, v in zip(self.names, point, strict=True))

    @property
    def ranges(self) -> str:
        """The box in words."""
        pairs = zip(self.names, self.box, strict=True)
        return ", ".join(f"{name} in [{exact_text(low, 8)}, {exact_text(high, 8)}]" for name, (low, high) in pairs)

    @property
    def sides(self) -> tuple[list[str], list[str]]:
        """Numerator and denominator, highest power first, each coefficient as a formula in the parameters."""
        found: tuple[list[str], list[str]] = ([], [])
        for i, side in enumerate(found, 1):
            for k in range(self.order + 1):
                side.append(_sum_text([(e, term[i - 1][k]) for e, *term in self.terms], self.names))
        return found

    def __str__(self) -> str:
        top, bottom = (_polynomial_text(side, self.variable) for side in self.sides)
        return f"({top}) / ({bottom}), {self.ranges}"


def _interval(name: str, ends: tuple[Exact, Exact]) -> tuple[Fraction, Fraction]:
    """The bounds of a parameter."""
    low, high = (exact_number(end, f"parameters.{name}") for end in ends)
    if not low < high:
        raise InputError(
            f"parameters.{name} is [{float(low):g}, {float(high):g}]; the first must be smaller than the second, or "
            "give one number for a constant"
        )
    return low, high


class _Ring(OneVariable):
    """Polynomials in ``s``, or ``z``, and the parameters; constants stand for their numbers."""

    def __init__(self, parameters: Bounds) -> None:
        from flint import Ordering, fmpq_mpoly_ctx

        for name in parameters:
            if not NAME.fullmatch(name) or name in RESERVED:
                raise InputError(f"parameters.{name!r:.40} is no name here; give letters, digits and _, and not s or z")
        pairs = {name: ends for name, ends in parameters.items() if isinstance(ends, tuple | list)}
        self.constants = {
            name: exact_coefficient(value, f"parameters.{name}")
            for name, value in parameters.items()
            if name not in pairs
        }
        self.parameters = {name: (ends[0], ends[1]) for name, ends in pairs.items()}
        self.names = ("s", "z", *parameters)
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


Pair = tuple[Element, Element]


def _parsed(text: str, ring: _Ring, field: str) -> tuple[Quotient, str]:
    """A formula as a quotient; nothing that it divides by, at any depth, vanishes for parameters in the box."""
    ring.divisors.clear()
    found, variable = parsed_quotient(text, ring, field)
    for divisor in ring.divisors:
        for factor, _ in divisor.factor()[1]:
            coefficients = _in_s(factor, ring)  # it vanishes where they all do, and with it what keeps it as a factor
            kept = len(coefficients) > 1 and not found.bottom % factor
            if not kept and not any(_apart(p, ring) for p in coefficients):
                raise InputError(_VANISHES)
    return found, variable


def _entries(values: Iterable[object], ring: _Ring, name: str) -> list[Pair]:
    """Each entry, a number or a formula in the parameters, as a quotient."""
    found = list[Pair]()
    for i, value in enumerate(values):
        where = f"{name}[{i}]"
        if not isinstance(value, str):
            found.append((ring.number(exact_number(value, where)), ring.number(Fraction(1))))
            continue
        quotient, variable = _parsed(value, ring, where)
        if variable:
            raise InputError(
                f"{where} is {value!r:.60}, which holds {variable}; give a formula in the parameters alone"
            )
        found.append((quotient.top, quotient.bottom))
    return found


def _flat(side: object) -> list[object]:
    """A vector, whether it was given as a row, a column or a list."""
    rows = list(side) if isinstance(side, Sequence) and not isinstance(side, str) else [side]
    return [v for row in rows for v in (row if isinstance(row, Sequence) and not isinstance(row, str) else [row])]


def _over_common(sides: Iterable[Sequence[Pair]], ring: _Ring) -> tuple[list[list[Element]], Element]:
    """All over one denominator, which has no zero in the box."""
    listed, common = [list(side) for side in sides], ring.number(Fraction(1))
    for side in listed:
        for _, bottom in side:
            common = common * (bottom // common.gcd(bottom))
    _require_apart(common, ring)
    return [[top * (common // bottom) for top, bottom in side] for side in listed], common


def _cleared(sides: tuple[list[Pair], list[Pair]], ring: _Ring) -> tuple[list[Element], list[Element]]:
    (top, bottom), _ = _over_common(sides, ring)
    return top, bottom


def _require_apart(p: Element, ring: _Ring) -> None:
    """Refuse a denominator that may vanish in the box."""
    if not _apart(p, ring):
        raise InputError(_VANISHES)


def _apart(p: Element, ring: _Ring) -> bool:
    """Whether interval arithmetic, factor by factor, shows that a polynomial has no zero in the box."""
    from flint import arb, fmpq

    if not p:
        return False
    boxes = [arb(0)]
    for name, ends in ring.parameters.items():
        low, high = (arb(fmpq(end.numerator, end.denominator)) for end in _interval(name, ends))
        boxes.append(low.union(high))
    for factor, _ in p.factor()[1]:
        total = arb(0)
        for powers, c in factor.to_dict().items():
            term = arb(c)
            for box, e in zip(boxes, powers, strict=True):
                term *= box ** int(e)
            total += term
        if total.contains(0):
            return False
    return True


def _in_s(p: Element, ring: _Ring) -> list[Element]:
    """The coefficients of a polynomial in ``s``, highest power first."""
    parts: dict[int, dict[tuple[int, ...], fmpq]] = {}
    for powers, c in p.to_dict().items():
        parts.setdefault(int(powers[0]), {})[(0, *powers[1:])] = c
    return [ring.context.from_dict(parts.get(k, {})) for k in range(max(parts, default=0), -1, -1)]


def _characteristic(A: list[list[Element]], ring: _Ring) -> list[Element]:
    """``det(s - A)``, highest power first, by Faddeev and LeVerrier."""
    n = len(A)
    zero, found = ring.number(Fraction(0)), [ring.number(Fraction(1))]
    M = [[zero] * n for _ in range(n)]
    for k in range(1, n + 1):
        M = [
            [sum((A[i][h] * M[h][j] for h in range(n)), zero) + (found[-1] if i == j else zero) for j in range(n)]
            for i in range(n)
        ]
        trace = sum((A[i][h] * M[h][i] for i in range(n) for h in range(n)), zero)
        found.append(trace * ring.number(Fraction(-1, k)))
    return found


def _family(
    sides: tuple[list[Element], list[Element]], ring: _Ring, dt: Fraction | Literal[True] | None
) -> PlantFamily | RationalPlant:
    """The plants of numerator and denominator, without what all coefficients have in common."""
    top, bottom = sides
    while len(bottom) > 1 and not bottom[0]:
        bottom = bottom[1:]
    while len(top) > 1 and not top[0]:
        top = top[1:]
    if len(top) > len(bottom):
        raise InputError("plant: it is improper; give a denominator of at least the degree of the numerator")
    zero = ring.number(Fraction(0))
    top = [zero] * (len(bottom) - len(top)) + list(top)
    shared = zero
    for p in (*top, *bottom):
        shared = shared.gcd(p)
    if shared and ring.degree(shared) > 0:
        _require_apart(shared, ring)
        top, bottom = [p // shared for p in top], [p // shared for p in bottom]
    table: dict[tuple[int, ...], tuple[list[Fraction], list[Fraction]]] = {}
    for i, side in enumerate((top, bottom)):
        for k, p in enumerate(side):
            for powers, c in p.to_dict().items():
                empty = ([Fraction(0)] * len(bottom), [Fraction(0)] * len(bottom))
                table.setdefault(tuple(int(e) for e in powers[1:]), empty)[i][k] = Fraction(int(c.p), int(c.q))
    if not ring.parameters:
        n, d = table[()]
        return RationalPlant(n, d, dt)
    return PlantFamily(ring.parameters, [(e, tuple(n), tuple(d)) for e, (n, d) in table.items()], dt)


def _sum_text(terms: Sequence[tuple[tuple[int, ...], Fraction]], names: Sequence[str]) -> str:
    """A polynomial in the parameters, exactly, as a formula that is read again."""
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


def _polynomial_text(side: Sequence[str], variable: str) -> str:
    """A polynomial in ``s`` whose coefficients are texts."""
    parts = list[str]()
    for power, text in zip(range(len(side) - 1, -1, -1), side, strict=True):
        if text == "0":
            continue
        letter = "" if power == 0 else variable if power == 1 else f"{variable}^{power}"
        whole = f"({text})" if letter and " " in text else text
        parts.append(letter if letter and text == "1" else f"{whole} {letter}".strip())
    return " + ".join(parts) or "0"
