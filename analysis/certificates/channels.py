"""The plant and the classes of several nonlinearities, one in each channel: part of the checker.

Standard library only.  Every function raises ``Rejected`` unless what it is asked to show is shown.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import accumulate
from typing import Any, NamedTuple

from . import arithmetic as exact
from . import frequencies, states
from .arithmetic import S, eliminated, fields, form, integer, need, numbers, real, tick
from .balls import dot, positive_definite

MOST_STATES, MOST_CHANNELS = 200, 100
Rows = list[list[Fraction]]


class Plant(NamedTuple):
    """``x' = A x + B mu``, ``sigma = C x + D mu`` (or ``x+``), ``mu_i = -phi_i(sigma_i)``."""

    A: Rows
    B: Rows
    C: Rows
    D: Rows
    discrete: bool


class Channels(NamedTuple):
    """The class of each channel, and the channels of each nonlinearity."""

    families: list[states.Family]
    blocks: list[range]

    def bounds(self, i: int) -> tuple[Any, Any]:
        """Bounds of ``phi_i(sigma)/sigma``: those of the sector and, as ``phi_i(0) = 0``, those of the slope."""
        sector, slope = self.families[i].sector, self.families[i].slope
        return max(sector[0], slope[0]), min(sector[1], slope[1])


def plant(system: Any) -> Plant:
    """The plant of a certificate."""
    kind, domain, *sides = fields(system, "kind", "time", "A", "B", "C", "D")
    form(kind == "multivariable" and domain in ("continuous", "discrete"), "the system is of no kind for channels")
    form(all(isinstance(side, list) and side for side in sides), "A, B, C and D are lists of rows")
    n, m = len(sides[0]), len(sides[3])
    form(n <= MOST_STATES and m <= MOST_CHANNELS, "there are too many states or channels")
    form([len(side) for side in sides] == [n, n, m, m], "A, B, C and D do not fit, or inputs and outputs differ")
    A, B, C, D = ([numbers(row, width) for row in side] for side, width in zip(sides, (n, m, n, m)))
    return Plant(A, B, C, D, domain == "discrete")


def channels(data: Any, m: int) -> Channels:
    """The classes of a certificate, one for each channel."""
    given, repeated = fields(data, "channels", "repeated")
    form(isinstance(given, list) and len(given) == m, f"{m} classes are needed, in order")
    sizes = ([m] if repeated else [1] * m) if type(repeated) is bool else repeated
    form(isinstance(sizes, list), "repeated is true, false, or how many channels in turn have the same nonlinearity")
    ends = list(accumulate(integer(size, 1, m) for size in sizes))
    form(ends[-1:] == [m], f"the channels with the same nonlinearity do not add up to {m}")
    blocks = [range(end - size, end) for end, size in zip(ends, sizes)]
    families = [states.classes(one, paced=True) for one in given]
    same = all(given[i] == given[block[0]] for block in blocks for i in block)
    form(same, "a repeated nonlinearity has one class")
    return Channels(families, blocks)


def described(asked: Channels) -> str:
    """The classes in words."""
    words = "; ".join(f"channel {i}: {states.described(family)}" for i, family in enumerate(asked.families, 1))
    same = [f"{block[0] + 1} to {block[-1] + 1}" for block in asked.blocks if len(block) > 1]
    if len(asked.blocks) == 1 and same:
        return f"{words}; one nonlinearity in all channels"
    return "".join([words, *(f"; one nonlinearity in the channels {channels}" for channels in same)])


def ordered(D: Rows) -> bool:
    """Whether the channels can be taken one after the other, each ``sigma_i`` given by those before it."""
    left = set(range(len(D)))
    while free := {i for i in left if not any(D[i][j] for j in left)}:
        left -= free
    return not left


def each(asked: Channels) -> Any:
    """The class of each channel with its number."""
    return enumerate(asked.families)


def triangle(given: Any, order: int) -> Rows:
    """The symmetric matrix of a lower triangle."""
    form(isinstance(given, list) and len(given) == order, f"a lower triangle of order {order} is missing")
    half = [numbers(row, i + 1) for i, row in enumerate(given)]
    return [[half[max(i, j)][min(i, j)] for j in range(order)] for i in range(order)]


def definite(Pi: Rows, view: Rows, where: str, less: Any = None) -> None:
    """``view' Pi view``, less a matrix if there is one, is positive definite."""
    columns = [*zip(*view)]
    turned = [[dot(row, column) for row in Pi] for column in columns]
    inner = [[dot(row, column) for column in columns[: i + 1]] for i, row in enumerate(turned)]
    if less is not None:
        inner = [[v - w for v, w in zip(row, other)] for row, other in zip(inner, less)]
    q = states.unit(inner)
    need(positive_definite([[int(q * v) for v in row] for row in inner]), f"Pi is not positive definite {where}")


def closed_by(H: Plant, gains: list[Fraction]) -> Rows | None:
    """The matrix of the loop with constant gains; None if it has no solution."""
    # mu = -G sigma and sigma = C x + D mu: (1 + G D) mu = -G C x
    left = [[(i == j) + g * v for j, v in enumerate(row)] for i, (g, row) in enumerate(zip(gains, H.D))]
    solved = eliminated(left, [[-g * v for v in row] for g, row in zip(gains, H.C)])
    if solved is None:
        return None
    return [[a + dot(b, column) for a, column in zip(row, zip(*solved))] for row, b in zip(H.A, H.B)]


def within(A: Rows, discrete: bool) -> bool:
    """Whether all eigenvalues are strictly inside, by Routh's array."""
    up, down = (real(1) + S, real(1) + exact.MINUS * S) if discrete else (S, real(1))
    inner = exact.homogeneous(characteristic(A), up, down, len(A))
    return len(exact.primitive(exact.ascending(inner))) == len(A) + 1 and exact.hurwitz(inner)


def characteristic(A: Rows) -> list[Fraction]:
    """``det(s - A)``, descending."""
    p, q, _ = frequencies.resolvent(A, [], [])
    return [Fraction(c, q**i) for i, c in enumerate(p)]


def rank(rows: Rows) -> int:
    """The rank of a square matrix, by elimination."""
    left, found = [list(row) for row in rows], 0
    for j in range(len(rows)):
        tick()
        pivot = next((row for row in left if row[j]), None)
        if pivot is not None:
            left.remove(pivot)
            left = [[v - row[j] / pivot[j] * u for v, u in zip(row, pivot)] if row[j] else row for row in left]
            found += 1
    return found


def member(data: Any, asked: Channels) -> list[Fraction]:
    """One gain for each channel, all of the class."""
    gains = numbers(data, len(asked.families))
    inside = all(low <= g <= high for g, (low, high) in zip(gains, map(asked.bounds, range(len(gains)))))
    need(
        inside and all(len({gains[i] for i in block}) == 1 for block in asked.blocks), "the gains are outside the class"
    )
    return gains


def moved(H: Plant) -> Rows:
    """Rows of ``(A, -B)``: ``x'`` (or ``x+``) from ``(x, phi)``."""
    return [[*a, *(-v for v in b)] for a, b in zip(H.A, H.B)]


def seen(H: Plant) -> Rows:
    """Rows of ``(C, -D)``: ``sigma`` from ``(x, phi)``."""
    return [[*c, *(-v for v in d)] for c, d in zip(H.C, H.D)]
