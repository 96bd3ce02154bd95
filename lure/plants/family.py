"""Plants whose coefficients depend on parameters that are constant but known only to lie in a box."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import gcd, lcm, prod
from typing import Literal

from lure.errors import InputError
from lure.exact import Exact
from lure.plants.channel_family import ChannelFamily
from lure.plants.delay import DelayPlant
from lure.plants.matrices import rational_block
from lure.plants.multivariable import MultivariablePlant
from lure.plants.parameters import (
    Bounds,
    Constants,
    InBox,
    Pair,
    Ring,
    checked_box,
    dead_times_apart,
    entries,
    flat,
    in_s,
    over_common,
    require_apart,
    sum_text,
)
from lure.plants.parameters import Box as Box
from lure.plants.parameters import Point as Point
from lure.plants.rational import RationalPlant, sampling_period, time_text
from lure.plants.text import Element, descending, parsed_quotient, step_of_formula
from lure.record import Record, quantity

MOST_ORDER = 40
_LARGE = 10**60  # of coefficients, from which on they are freed of what they have in common
_IMPROPER = "plant: it is improper; give a denominator of at least the degree of the numerator"
Term = tuple[tuple[int, ...], tuple[Fraction, ...], tuple[Fraction, ...]]


class PlantFamily(InBox, Record):
    r"""All plants ``H(s) = exp(-T s) sum_e p^e n_e(s) / sum_e p^e d_e(s)`` with the parameters ``p`` in a box.

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
    states : ChannelFamily or None
        The matrices that the plants were given by, for whoever needs their states.
    delay : sequence of Fraction
        ``T = c_0 + sum c_j p_j`` [s], a dead time of all the plant: ``c_0``, then a number for each parameter; empty
        for none.

    Raises
    ------
    InputError
        There is no parameter, one has no interval or does not matter, the plants are no proper ones of order 1 on, or
        the dead time may be negative.

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
    states: ChannelFamily | None = quantity("", hidden=True)
    delay: tuple[Fraction, ...] = quantity("", hidden=True)
    _kind, _said = "plants with parameters", "text"
    _notes = ("From mu to sigma; in a loop mu = -phi(sigma). Parameters are constant.",)

    def __init__(
        self,
        parameters: Mapping[str, tuple[Exact, Exact]],
        terms: Sequence[Term],
        dt: int | float | Fraction | None = None,
        states: ChannelFamily | None = None,
        delay: Sequence[Fraction] = (),
    ) -> None:
        kept, late = tuple((e, n, d) for e, n, d in sorted(terms) if any(n) or any(d)), tuple(delay) * any(delay)
        once = [tuple(int(c != 0) for c in late[1:])] * bool(late)
        names, box = tuple(parameters), checked_box(parameters, [e for e, *_ in kept] + once)
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
        object.__setattr__(self, "states", states)
        object.__setattr__(self, "delay", late)
        least, _ = self.waits(box)
        if late and (least < 0 or dt is not None):
            raise InputError(
                "the dead time of the plants is in continuous time, and not negative for any of the parameters; it is "
                + (f"{float(least):g} s for some" if least < 0 else "beside a sampling time: write z^-n there")
            )

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
        ring = Ring(parameters)
        sides = (entries(numerator, ring, "num"), entries(denominator, ring, "den"))
        return _family(_cleared(sides, ring), ring, step_of_formula("", dt, "plant"))

    @classmethod
    def of_formula(cls, text: str, parameters: Bounds, dt: object = None) -> PlantFamily | RationalPlant | DelayPlant:
        """The plants of a transfer function that is a formula in ``s`` or ``z`` and the parameters.

        A factor ``exp(-T*s)`` of all of it is a dead time, ``T`` a number or a parameter, or a sum of such.

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
        if not any(isinstance(ends, tuple | list) for ends in parameters.values()):
            if "exp" in text and "exp" not in parameters:
                _ = step_of_formula("s", dt, "transfer")
                late_one = DelayPlant.parse(Constants(parameters).put_in(text).replace("^", "**"))
                return late_one.delayless or late_one
            whole, variable = parsed_quotient(text, Constants(parameters), "transfer")
            if whole.top.degree() > whole.bottom.degree():
                raise InputError(_IMPROPER)
            step = step_of_formula(variable, dt, "transfer")
            return RationalPlant(descending(whole.top), descending(whole.bottom), step)
        ring = Ring(parameters)
        found, variable, late = dead_times_apart(text, ring, parameters, "transfer")
        sides = (in_s(found.top, ring), in_s(found.bottom, ring))
        return _family(sides, ring, step_of_formula(variable, dt, "transfer"), late)

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
        ring, b, c = Ring(parameters), flat(B), flat(C)
        n = len(A)
        square = all(isinstance(row, list | tuple) and len(row) == n for row in A)
        if not n or not square or len(b) != n or len(c) != n:
            raise InputError(
                f"plant: with parameters A is square, B and C have one entry for each state; got A of {n} rows, B of "
                f"{len(b)} and C of {len(c)} entries"
            )
        rows = [entries(row, ring, f"A[{i}]") for i, row in enumerate(A)]
        given = [*(v for row in rows for v in row), *entries([*b, *c, D], ring, "B, C, D")]
        (found,), common = over_common((given,), ring)
        A_, rest = [found[i * n : (i + 1) * n] for i in range(n)], found[n * n :]
        step = step_of_formula("", dt, "plant")
        sides = A_, [[v] for v in rest[:n]], [rest[n:-1]], [[rest[-1]]]
        states = ChannelFamily.of_elements(common, sides, ring, step) if not any(ring.rates) else None
        if isinstance(states, MultivariablePlant):
            return rational_block(states.A, states.B, states.C, states.D[0][0], dt=step)
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
        made = _family((top, [common * v for v in d]), ring, step)
        assert isinstance(made, PlantFamily), "there are parameters"
        return PlantFamily(ring.parameters, made.terms, step, states)

    @property
    def channels(self) -> ChannelFamily:
        """State equations: the matrices that the plants were given by, else the companion form of the coefficients.

        Raises
        ------
        InputError
            There is a dead time: then the states are infinitely many.
        """
        if self.delay:
            raise InputError(
                "the plants have a dead time beside their parameters, of which the largest class and one class are "
                "asked (lure max-sector, max-slope, certify, analyse) and nothing else; leave it out, or the parameters"
            )
        if self.states is not None:
            return self.states
        zero, n = Fraction(0), self.order
        ring = Ring(dict(zip(self.names, self.box, strict=True)))
        top, bottom = (
            [sum((ring.product(e, term[i][k]) for e, *term in self.terms), ring.number(zero)) for k in range(n + 1)]
            for i in range(2)
        )
        first = bottom[0]
        shift = [[first if j == i + 1 else ring.number(zero) for j in range(n)] for i in range(n - 1)]
        row = [first * t - top[0] * b for t, b in zip(top[1:], bottom[1:], strict=True)]  # times first^2
        A = [[first * v for v in line] for line in [*shift, [-v for v in bottom[:0:-1]]]]
        B = [[ring.number(zero)] for _ in range(n - 1)] + [[first * first]]
        C, D = [row[::-1]], [[top[0] * first]]
        step: Fraction | Literal[True] | None = True if self.any_period else self.dt
        made = ChannelFamily.of_elements(first * first, (A, B, C, D), ring, step)
        assert isinstance(made, ChannelFamily), "there are parameters"
        return made

    @property
    def order(self) -> int:
        """The number of states."""
        return len(self.terms[0][2]) - 1

    @property
    def degrees(self) -> tuple[int, ...]:
        """The highest power of each parameter."""
        return tuple(max(e[j] for e, *_ in self.terms) for j in range(len(self.names)))

    @property
    def order_changes(self) -> bool:
        """Whether the coefficient of the highest power vanishes, or has two signs, at corners or in the middle."""
        values = {
            (value > 0) - (value < 0)
            for point in (self.middle, *self.corners)
            for value in [
                sum(
                    (d[0] * prod(v**e for v, e in zip(point, powers, strict=True)) for powers, _, d in self.terms),
                    Fraction(0),
                )
            ]
        }
        return values not in ({1}, {-1})

    def waits(self, box: Box) -> tuple[Fraction, Fraction]:
        """The least and the largest dead time [s].

        Parameters
        ----------
        box : tuple of (Fraction, Fraction)
            The bounds of the parameters.
        """
        if not self.delay:
            return Fraction(0), Fraction(0)
        shares = [sorted((c * low, c * high)) for c, (low, high) in zip(self.delay[1:], box, strict=True)]
        return self.delay[0] + sum(low for low, _ in shares), self.delay[0] + sum(high for _, high in shares)

    @property
    def variable(self) -> str:
        """``s`` in continuous time, ``z`` in discrete time."""
        return "s" if self.dt is None else "z"

    @property
    def central(self) -> RationalPlant | DelayPlant:
        """The plant with the parameters in the middle of the box, for what can be drawn of one plant only."""
        return self.at(self.middle)

    def at(self, point: Sequence[Fraction]) -> RationalPlant | DelayPlant:
        """The plant with these parameters.

        Parameters
        ----------
        point : sequence of Fraction
            A value for each, in order; outside the box too.

        Raises
        ------
        InputError
            The denominator vanishes there, or the dead time is negative.
        """
        plant = self.undelayed(point)
        if not self.delay:
            return plant
        wait = self.delay[0] + sum(c * v for c, v in zip(self.delay[1:], point, strict=True))
        return DelayPlant({wait: plant.numerator}, plant.denominator)

    def undelayed(self, point: Sequence[Fraction]) -> RationalPlant:
        """The plant with these parameters, without its dead time.

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
        states = None if self.states is None else self.states.within(box)
        bounds = dict(zip(self.names, box, strict=True))
        return PlantFamily(bounds, self.terms, True if self.any_period else self.dt, states, self.delay)

    @property
    def sides(self) -> tuple[list[str], list[str]]:
        """Numerator and denominator, highest power first, each coefficient as a formula in the parameters."""
        found: tuple[list[str], list[str]] = ([], [])
        for i, side in enumerate(found, 1):
            for k in range(self.order + 1):
                side.append(sum_text([(e, term[i - 1][k]) for e, *term in self.terms], self.names))
        return found

    def __str__(self) -> str:
        top, bottom = (_polynomial_text(side, self.variable) for side in self.sides)
        return f"{f'exp(-({self.wait_text}) s) ' if self.delay else ''}({top}) / ({bottom}), {self.ranges}"

    @property
    def formula(self) -> str:
        """The transfer function as a formula that is read again."""
        powers = range(self.order, -1, -1)
        top, bottom = (
            " + ".join(f"({c})*{self.variable}^{k}" for c, k in zip(side, powers, strict=True) if c != "0")
            for side in self.sides
        )
        return f"{f'exp(-({self.wait_text})*s)*' if self.delay else ''}({top or 0})/({bottom})"

    @property
    def wait_text(self) -> str:
        """The dead time as a formula in the parameters."""
        zero = (0,) * len(self.names)
        powers = [zero, *((*zero[:j], 1, *zero[j + 1 :]) for j in range(len(zero)))]
        return sum_text(list(zip(powers, self.delay, strict=True)), self.names)


def _cleared(sides: tuple[list[Pair], list[Pair]], ring: Ring) -> tuple[list[Element], list[Element]]:
    (top, bottom), _ = over_common(sides, ring)
    return top, bottom


def _characteristic(A: list[list[Element]], ring: Ring) -> list[Element]:
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
    sides: tuple[list[Element], list[Element]],
    ring: Ring,
    dt: Fraction | Literal[True] | None,
    late: Sequence[Fraction] = (),
) -> PlantFamily | RationalPlant:
    """The plants of numerator and denominator, without what all coefficients have in common."""
    if any(ring.rates):
        raise InputError(
            "a parameter that changes with time needs the states that it acts on; give the plant by A, B and C, as a "
            "ChannelFamily"
        )
    top, bottom = sides
    while len(bottom) > 1 and not bottom[0]:
        bottom = bottom[1:]
    while len(top) > 1 and not top[0]:
        top = top[1:]
    if len(top) > len(bottom):
        raise InputError(_IMPROPER)
    zero = ring.number(Fraction(0))
    top = [zero] * (len(bottom) - len(top)) + list(top)
    shared = zero
    for p in (*top, *bottom):
        shared = shared.gcd(p)
    if shared and ring.degree(shared) > 0:
        require_apart(shared, ring)
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
    numbers = [c for n, d in table.values() for c in (*n, *d) if c]
    if max(map(abs, numbers), default=0) > _LARGE:  # the common denominator of many entries, to a high power
        unit = Fraction(gcd(*(c.numerator for c in numbers)), lcm(*(c.denominator for c in numbers)))
        table = {e: ([c / unit for c in n], [c / unit for c in d]) for e, (n, d) in table.items()}
    return PlantFamily(ring.parameters, [(e, tuple(n), tuple(d)) for e, (n, d) in table.items()], dt, delay=late)


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
