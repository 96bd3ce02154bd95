"""State equations of several channels whose entries depend on parameters, constant but known only to lie in a box."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import prod
from typing import Literal, NamedTuple, cast

from lure.errors import InputError
from lure.exact import Exact
from lure.plants.multivariable import MOST_CHANNELS, MultivariablePlant, Rows, counted
from lure.plants.parameters import (
    Bounds,
    Box,
    InBox,
    Rate,
    Ring,
    checked_box,
    entries,
    in_s,
    over_common,
    parsed,
    sum_text,
)
from lure.plants.rational import sampling_period, time_text
from lure.plants.text import Element, step_of_formula
from lure.record import Record, quantity

MOST_STATES = 40
Sides = tuple[Rows, Rows, Rows, Rows]
Elements = list[list[Element]]


class Term(NamedTuple):
    """What stands before one product of powers: in the common denominator, and in ``A``, ``B``, ``C`` and ``D``."""

    powers: tuple[int, ...]
    common: Fraction
    A: Rows
    B: Rows
    C: Rows
    D: Rows

    @property
    def sides(self) -> Sides:
        """The four matrices."""
        return self.A, self.B, self.C, self.D


class _Chain(NamedTuple):
    """States in companion form, moved by one input: the denominator, and by what outputs see them."""

    column: int
    bottom: list[Element]
    outputs: list[tuple[int, list[tuple[Element, Element]]]]


class ChannelFamily(InBox, Record):
    r"""All plants ``x' = A x + B mu``, ``sigma = C x + D mu`` with ``A = sum_e p^e A_e / sum_e p^e c_e``, and so on.

    The parameters ``p`` are real; nothing is known of them but their bounds, and how fast they may change.  The common
    denominator has no zero in the box.  What is said of the family is said of every plant of it.

    Parameters
    ----------
    parameters : mapping of str to (number, number)
        The bounds of each parameter, the smaller first, in the order of the exponents.
    terms : sequence of Term
        For each product ``p^e`` of powers its exponents, ``c_e`` and the matrices, of one shape each.
    dt : Fraction, True or None
        Sampling time [s]; None for continuous time.
    rates : sequence of Fraction or float
        How fast each parameter may change, in a unit of time: 0 for a constant, infinity for any speed; empty if all
        are constant.

    Raises
    ------
    InputError
        There is no parameter, one has no interval or does not matter, or there are no states or too many.

    Examples
    --------
    >>> family = ChannelFamily.of_matrices([["-a"]], [["1", "b"]], [[1], [1]], None, {"a": (1, 2), "b": (0.5, 1)})
    >>> print(family.at((Fraction(2), Fraction(1))))
    1 state, 2 inputs and 2 outputs in continuous time
    """

    names: tuple[str, ...] = quantity("The parameters", label="parameters")
    box: Box = quantity("Their bounds", form=lambda box: ", ".join(f"[{float(a):g}, {float(b):g}]" for a, b in box))
    terms: tuple[Term, ...] = quantity("What stands before each product of powers of the parameters", label="")
    dt: Fraction | None = quantity("Sampling time", "s", label="time", form=lambda dt: time_text(dt))
    any_period: bool = quantity("", hidden=True)
    rates: tuple[Rate, ...] = quantity("", hidden=True)
    _kind, _said = "plants of several channels with parameters", "text"
    _notes = ("In a loop mu_i = -phi_i(sigma_i). Parameters are constant where nothing else is said.",)

    def __init__(
        self,
        parameters: Mapping[str, tuple[Exact, Exact]],
        terms: Sequence[Term],
        dt: int | float | Fraction | None = None,
        rates: Sequence[Rate] = (),
    ) -> None:
        found = tuple(sorted(terms))
        kept = tuple(one for one in found if one.common or any(v for side in one.sides for row in side for v in row))
        box = checked_box(parameters, [one.powers for one in kept])
        n, m, p = len(kept[0].A), len(kept[0].D[0]), len(kept[0].D)
        if not 0 < n <= MOST_STATES or not 0 < max(m, p) <= MOST_CHANNELS:
            raise InputError(
                f"the plants with parameters have {n} states, {m} inputs and {p} outputs; give 1 to {MOST_STATES} "
                f"states and up to {MOST_CHANNELS} channels"
            )
        for name, value in (("names", tuple(parameters)), ("box", box), ("terms", kept)):
            object.__setattr__(self, name, value)
        object.__setattr__(self, "dt", sampling_period(dt, "dt"))
        object.__setattr__(self, "any_period", dt is True)
        object.__setattr__(self, "rates", tuple(rates) * any(rates))

    @classmethod
    def of_matrices(  # noqa: PLR0913  (four matrices, the bounds and the time)
        cls, A: object, B: object, C: object, D: object, parameters: Bounds, dt: object = None
    ) -> ChannelFamily | MultivariablePlant:
        """The plants of matrices whose entries are numbers, or formulas in the parameters.

        Parameters
        ----------
        A, B, C, D : sequence of sequences
            (n, n), (n, m), (p, n) and (p, m), row by row; ``D`` None or 0 for zeros.
        parameters : mapping of str to number, (number, number) or (number, number, rate)
            Bounds of each; one number for a constant; the rate at which it may change at most, ``inf`` for any.
        dt : object
            Sampling time, as for :func:`lure.as_plant`.

        Returns
        -------
        ChannelFamily or MultivariablePlant
            The latter if every parameter is a constant.

        Raises
        ------
        InputError
            The shapes do not fit, a formula is none, or what is divided by may vanish in the box.
        """
        ring, (left, inward, outward) = Ring(parameters), (_rows(side) for side in (A, B, C))
        n, m, p = len(left), len(inward[0]) if inward else 0, len(outward)
        through = [[0] * m for _ in range(p)] if D is None or D == 0 else _rows(D)
        shapes = [(left, n, n), (inward, n, m), (outward, p, n), (through, p, m)]
        if not n or not all(len(side) == h and all(len(row) == w for row in side) for side, h, w in shapes):
            raise InputError("plant: A, B, C and D do not fit; give A (n, n), B (n, m), C (p, n) and D (p, m), n >= 1")
        named = zip((left, inward, outward, through), "ABCD", strict=True)
        read = [entries(row, ring, f"{name}[{i}]") for side, name in named for i, row in enumerate(side)]
        found, common = over_common(read, ring)
        sides = found[:n], found[n : 2 * n], found[2 * n : 2 * n + p], found[2 * n + p :]
        return cls.of_elements(common, sides, ring, step_of_formula("", dt, "plant"))

    @classmethod
    def of_transfers(
        cls, rows: Sequence[Sequence[object]], parameters: Bounds, dt: object = None
    ) -> ChannelFamily | MultivariablePlant:
        """The plants of a matrix of transfer functions, formulas in ``s`` or ``z`` and the parameters.

        Entries of one column with the same denominator share their states; no others do.

        Parameters
        ----------
        rows : sequence of sequences
            (p, m) formulas, or numbers.
        parameters, dt
            As for :meth:`of_matrices`.

        Raises
        ------
        InputError
            As there; or an entry is improper, or holds a dead time.
        """
        ring, variables, m = Ring(parameters), set[str](), len(rows[0])
        zero, one = (ring.number(Fraction(v)) for v in (0, 1))
        through: list[list[tuple[Element, Element]]] = [[(zero, one)] * m for _ in rows]
        chains = list[_Chain]()
        for j in range(m):
            shared = list[_Chain]()
            for i, row in enumerate(rows):
                where, text = f"transfer[{i}][{j}]", row[j] if isinstance(row[j], str) else str(row[j])
                found, variable = parsed(str(text), ring, where)
                variables |= {variable} - {""}
                top, bottom = in_s(found.top, ring), in_s(found.bottom, ring)
                if len(top) > len(bottom):
                    raise InputError(f"{where} is {text!r:.60}, which is improper; give a denominator of its degree")
                top, first = [zero] * (len(bottom) - len(top)) + top, bottom[0]
                through[i][j] = top[0], first
                seen = [(first * b - top[0] * a, first * first) for a, b in zip(bottom, top, strict=True)][1:]
                if any(v for v, _ in seen):
                    if not any(one.bottom == bottom for one in shared):
                        shared.append(_Chain(j, bottom, []))
                    next(one for one in shared if one.bottom == bottom).outputs.append((i, seen))
            chains += shared
        n, p = sum(len(one.bottom) - 1 for one in chains), len(rows)
        A, B, C = ([[(zero, one)] * width for _ in range(height)] for height, width in ((n, n), (n, m), (p, n)))
        at = 0
        for j, bottom, outputs in chains:  # in companion form
            last = at + len(bottom) - 2
            for k in range(at, last):
                A[k][k + 1] = one, one
            for k, a in enumerate(reversed(bottom[1:])):
                A[last][at + k] = -a, bottom[0]
            B[last][j] = one, one
            for i, seen in outputs:
                C[i][at : last + 1] = seen[::-1]
            at = last + 1
        if not n:
            raise InputError("plant: the transfer functions have no poles; give a plant with at least one state")
        if len(variables) > 1:
            raise InputError("plant: transfer holds s and z; give one of them")
        whole, common = over_common([line for side in (A, B, C, through) for line in side], ring)
        sides = whole[:n], whole[n : 2 * n], whole[2 * n : 2 * n + p], whole[2 * n + p :]
        return cls.of_elements(common, sides, ring, step_of_formula("".join(variables), dt, "transfer"))

    @classmethod
    def of_elements(
        cls, common: Element, sides: Sequence[Elements], ring: Ring, dt: Fraction | Literal[True] | None
    ) -> ChannelFamily | MultivariablePlant:
        """The plants of polynomials in the parameters over a common one, which has no zero in the box.

        Parameters
        ----------
        common : polynomial
            The denominator.
        sides : sequence of lists of rows
            ``A``, ``B``, ``C`` and ``D`` times that.
        ring : Ring
            Of the polynomials.
        dt : Fraction, True or None
            Sampling time [s].
        """
        found: dict[tuple[int, ...], list[list[list[Fraction]]]] = {}

        def at(powers: tuple[int, ...]) -> list[list[list[Fraction]]]:
            """The matrices of the monomial with these powers, 0 at first."""
            empty = [[[Fraction(0)]], *([[Fraction(0)] * len(row) for row in side] for side in sides)]
            return found.setdefault(powers, empty)

        for k, side in enumerate(([[common]], *sides)):
            for i, row in enumerate(side):
                for j, entry in enumerate(row):
                    for powers, c in entry.to_dict().items():
                        at(tuple(int(e) for e in powers[1:]))[k][i][j] = Fraction(int(c.p), int(c.q))
        terms = [
            Term(powers, first[0][0], *(tuple(map(tuple, side)) for side in rest))
            for powers, (first, *rest) in found.items()
        ]
        if not ring.parameters:
            ((_, whole, *matrices),) = terms
            A, B, C, D = (tuple(tuple(v / whole for v in row) for row in side) for side in matrices)
            return MultivariablePlant(A, B, C, D, cast("Fraction | None", dt))
        return cls(ring.parameters, terms, dt, ring.rates)

    def still(self, i: int) -> bool:
        """Whether an output is the same function of the state whatever the parameters that change are."""
        moved = [one for one in self.terms if any(e and r for e, r in zip(one.powers, self.rates, strict=False))]
        return not any(one.common or any(one.C[i]) for one in moved)

    @property
    def order(self) -> int:
        """The number of states."""
        return len(self.terms[0].A)

    @property
    def inputs(self) -> int:
        """The number of inputs."""
        return len(self.terms[0].D[0])

    @property
    def outputs(self) -> int:
        """The number of outputs."""
        return len(self.terms[0].D)

    @property
    def size(self) -> str:
        """Inputs and outputs in words."""
        return f"{counted(self.inputs, 'input')} and {counted(self.outputs, 'output')}"

    @property
    def central(self) -> MultivariablePlant:
        """The plant with the parameters in the middle of the box, for what can be drawn of one plant only."""
        return self.at(self.middle)

    @property
    def pattern(self) -> Rows:
        """``D`` with an entry that is not 0 wherever that of some plant is not: (p, m)."""
        rows = range(self.outputs)
        return tuple(
            tuple(sum((abs(one.D[i][j]) for one in self.terms), Fraction(0)) for j in range(self.inputs)) for i in rows
        )

    @property
    def sides(self) -> dict[str, list[list[str]]]:
        """``A``, ``B``, ``C`` and ``D``, each entry as a formula in the parameters."""
        below = sum_text([(one.powers, one.common) for one in self.terms], self.names)

        def entry(k: int, i: int, j: int) -> str:
            """One entry as a formula in the parameters."""
            above = sum_text([(one.powers, one.sides[k][i][j]) for one in self.terms], self.names)
            return above if below == "1" or above == "0" else f"({above})/({below})"

        return {
            name: [[entry(k, i, j) for j in range(len(row))] for i, row in enumerate(self.terms[0].sides[k])]
            for k, name in enumerate("ABCD")
        }

    def at(self, point: Sequence[Fraction]) -> MultivariablePlant:
        """The plant with these parameters.

        Parameters
        ----------
        point : sequence of Fraction
            A value for each, in order; outside the box too.

        Raises
        ------
        InputError
            The common denominator vanishes there.
        """
        weights = [
            prod((v**e for v, e in zip(point, one.powers, strict=True)), start=Fraction(1)) for one in self.terms
        ]
        common = sum((w * one.common for w, one in zip(weights, self.terms, strict=True)), Fraction(0))
        if not common:
            raise InputError(f"the plant divides by 0 where {self.words(point)}; give other values")
        A, B, C, D = (
            tuple(
                tuple(sum((w * v for w, v in zip(weights, cell, strict=True)), Fraction(0)) / common for cell in line)
                for line in (zip(*(one.sides[k][i] for one in self.terms), strict=True) for i in range(height))
            )
            for k, height in enumerate((self.order, self.order, self.outputs, self.outputs))
        )
        return MultivariablePlant(A, B, C, D, cast("Fraction | None", True if self.any_period else self.dt))

    def within(self, box: Box) -> ChannelFamily:
        """The plants of another box of the same parameters.

        Parameters
        ----------
        box : tuple of (Fraction, Fraction)
            The bounds.
        """
        bounds = dict(zip(self.names, box, strict=True))
        return ChannelFamily(bounds, self.terms, True if self.any_period else self.dt, self.rates)

    def beside(self, B: Rows, C: Rows, D: Rows) -> ChannelFamily:
        """The plants with more inputs and outputs, the same for all.

        Parameters
        ----------
        B, C, D : tuple of tuples
            (n, k), (k, n) and (p + k, m + k): how the new inputs move the state, how the new outputs see it, and ``D``
            with both, 0 where that of the plants stands.
        """
        terms = list[Term]()
        for one in self.terms:
            c = one.common
            wide = tuple((*row, *(c * v for v in more)) for row, more in zip(one.B, B, strict=True))
            tall = (*one.C, *(tuple(c * v for v in row) for row in C))
            own = [list(row) for row in one.D]
            through = tuple(
                tuple(c * v + (own[i][j] if i < self.outputs and j < self.inputs else 0) for j, v in enumerate(row))
                for i, row in enumerate(D)
            )
            terms.append(one._replace(B=wide, C=tall, D=through))
        bounds = dict(zip(self.names, self.box, strict=True))
        return ChannelFamily(bounds, terms, True if self.any_period else self.dt, self.rates)

    def __str__(self) -> str:
        return f"{self.central}, {self.ranges}"


def _rows(side: object) -> list[Sequence[object]]:
    """A matrix given as rows; what is no list of rows is none."""
    if not isinstance(side, list | tuple) or not side:
        raise InputError('plant: with parameters A, B, C and D are lists of rows, as in [[0, 1], ["-a", -1]]')
    return [row if isinstance(row, list | tuple) else [row] for row in side]
