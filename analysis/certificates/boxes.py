"""Plants whose coefficients are polynomials in parameters, unknown in a box: part of the checker.

Standard library only.  ``H = n/d``, ``n = sum p^e n_e(s)``, ``d = sum p^e d_e(s)``, or ``exp(-T s) n/d`` with ``T``
affine in ``p``; of several channels ``A = sum p^e A_e/sum p^e c_e`` and so on.  Every function raises ``Rejected``
unless what it is asked to show is shown.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import partial
from itertools import product
from math import prod
from operator import mul
from typing import Any, NamedTuple

from . import channels, states
from .arithmetic import INF, MINUS, ZERO, Form, S, fields, form, homogeneous, integer, need, number, numbers, real, tick
from .balls import box as covered
from .balls import dot, tail
from .blocks import Block, over_s
from .channels import MOST_CHANNELS, MOST_STATES, Plant, Rows, closed_by, moved, seen
from .gains import MOST_STEPS
from .parametric import coefficients

MOST_PARAMETERS, MOST_DEGREE, MOST_NODES, MOST_BOXES, DEEPEST = 6, 12, 2000, 20_000, 400
TERMS, LATE, CHANNELS = 10, "delay-family", ("channel-family", "varying-family")
NAME = re.compile(r"[A-Za-z][A-Za-z_0-9]{0,40}")
Box = list[tuple[Fraction, Fraction]]
Shows = Callable[[Any, Block], tuple[Form, int, bool, dict[str, str]]]
Decides = Callable[[Form, int, bool, bool], object]
Values = dict[tuple[int, ...], list[list[Fraction]]]


class Plants(NamedTuple):
    """The plants of a box: names and bounds of the parameters, and powers, numerator, denominator of each term."""

    time: str
    names: list[str]
    box: Box
    terms: list[tuple[list[int], list[Fraction], list[Fraction]]]
    forms: list[tuple[Form, Form]]
    delay: list[Fraction]  # T = c_0 + sum c_j p_j; empty for none

    def waits(self, box: Box) -> tuple[Fraction, Fraction]:
        """The least and the largest dead time."""
        shares = [sorted((c * low, c * high)) for c, (low, high) in zip(self.delay[1:], box)]
        least, most = (sum((ends[i] for ends in shares), sum(self.delay[:1], ZERO)) for i in (0, 1))
        return least, most

    @property
    def degrees(self) -> list[int]:
        """The highest power of each parameter."""
        return [max(powers[j] for powers, *_ in self.terms) for j in range(len(self.names))]

    def at(self, point: list[Fraction]) -> dict[str, Any]:
        """One of them, as the system of a certificate."""
        weights, size = weighed(self.terms, point), range(len(self.terms[0][1]))
        sides = [[str(sum(w * term[i][k] for w, term in zip(weights, self.terms))) for k in size] for i in (1, 2)]
        if self.delay:
            need(Fraction(sides[0][0]) == 0, "beside dead time H(inf) = 0 is needed")
            wait = self.waits([(v, v) for v in point])[0]
            return {"kind": "delay", "terms": [[str(wait), sides[0][1:]]], "denominator": sides[1]}
        return {"kind": "transfer", "time": self.time, "numerator": sides[0], "denominator": sides[1]}

    def block(self, point: list[Fraction], wait: Fraction) -> Block:
        """The same as a block, ``H(inf)`` being 0, with this dead time in place of its own."""
        weights, n, d = weighed(self.terms, point), Form(), Form()
        need(sum(w * term[2][0] for w, term in zip(weights, self.terms)) != 0, "the order is less for some parameters")
        for w, (top, bottom) in zip(weights, self.forms):
            n, d = n + real(w) * top, d + real(w) * bottom
        if self.delay:
            n = n * Form({(wait, 0): (Fraction(1), ZERO)})
        return Block(n, d, len(self.terms[0][2]) - 1, ZERO, self.time == "discrete", bool(self.delay))


class Matrices(NamedTuple):
    """Plants of several channels: the powers of each term, its share of the common denominator, ``A, B, C, D``.

    ``rates``: of each parameter how fast it may change, 0 for a constant; empty if all are constant.
    """

    time: str
    names: list[str]
    box: Box
    terms: list[tuple[list[int], Fraction, list[Rows]]]
    rates: list[Any]

    def still(self, theta: list[Fraction]) -> None:
        """What Popov's terms integrate is a function of the state alone, which does not change with the parameters."""
        moved = [one for one in self.terms if any(e and r for e, r in zip(one[0], self.rates))]
        for i, t in enumerate(theta):
            need(not t or not any(c or any(sides[2][i]) for _, c, sides in moved), f"theta_{i + 1}: sigma changes")

    @property
    def pattern(self) -> Rows:
        """``D``, with an entry that is not 0 wherever one of a plant may not be."""
        return [
            [sum(map(abs, cell), ZERO) for cell in zip(*rows)] for rows in zip(*(sides[3] for *_, sides in self.terms))
        ]

    def common(self, point: list[Fraction]) -> Fraction:
        """The denominator."""
        return sum((w * c for w, (_, c, _) in zip(weighed(self.terms, point), self.terms)), ZERO)

    def at(self, point: list[Fraction]) -> dict[str, Any]:
        """One of them, as the system of a certificate."""
        H = self.plant(point)
        sides = {name: [[str(v) for v in row] for row in side] for name, side in zip("ABCD", (H.A, H.B, H.C, H.D))}
        return {"kind": "multivariable", "time": self.time, **sides}

    def plant(self, point: list[Fraction]) -> Plant:
        """The same as a plant."""
        weights, c, found = weighed(self.terms, point), self.common(point), list[Rows]()
        need(c != 0, "the common denominator vanishes for some parameters")
        for k in range(4):
            lines: Any = zip(*(sides[k] for *_, sides in self.terms))
            found.append([[sum(map(mul, weights, cell), ZERO) / c for cell in zip(*line)] for line in lines])
        return Plant(found[0], found[1], found[2], found[3], self.time == "discrete")

    def degrees(self, turned: bool, more: bool) -> list[int]:
        """Of the inequality of a matrix times the square of the denominator, in each parameter.

        With Popov's terms (``turned``), and with a matrix that depends on the parameters (``more``).
        """
        found = list[int]()
        for j in range(len(self.names)):
            c = max((powers[j] for powers, v, _ in self.terms if v), default=0)
            moves, sees = (
                max((powers[j] for powers, _, sides in self.terms if any(map(any, sides[k] + sides[k + 1]))), default=0)
                for k in (0, 2)
            )
            once = 2 * moves if self.time == "discrete" else c + moves
            found.append(max(once + more, 2 * sees, 2 * c + more, moves + sees if turned else 0))
        return found


class Integers(NamedTuple):
    """The terms of plants of several channels in one unit: for each entry, row by row, what it is in each term.

    The first is the common denominator, then there are the rows of ``(A, -B)`` and of ``(C, -D)``.
    """

    unit: int
    terms: list[tuple[list[int], Fraction, list[Rows]]]
    entries: list[list[int]]

    @classmethod
    def of(cls, H: Matrices) -> Integers:
        """Those of these plants."""
        parts = [Plant(sides[0], sides[1], sides[2], sides[3], discrete=False) for *_, sides in H.terms]
        rows = [[c, *(v for row in moved(one) + seen(one) for v in row)] for (_, c, _), one in zip(H.terms, parts)]
        unit = states.unit(rows)
        return cls(unit, H.terms, [[int(unit * v) for v in entry] for entry in zip(*rows)])

    def at(self, point: list[Fraction]) -> list[Any]:
        """A number ``u``, and ``u`` times the denominator and the rows of the plant with these parameters."""
        weights = weighed(self.terms, point)
        unit = states.unit([weights])
        shares = [int(unit * w) for w in weights]
        c, *values = (dot(shares, entry) for entry in self.entries)
        size = len(self.terms[0][2][0]) + len(self.terms[0][2][3])
        return [unit * self.unit, c, *(values[k : k + size] for k in range(0, len(values), size))]


class Rods(NamedTuple):
    """Rods, or their schemes with ``cells`` cells, whose ``E, rho, L, A, k`` lie within bounds."""

    names: list[str]
    box: Box
    cells: int

    def at(self, point: list[Fraction]) -> dict[str, Any]:
        """One of them, as the system of a certificate."""
        more = {"cells": self.cells} if self.cells else {}
        return {"kind": "rod-scheme" if self.cells else "rod", **dict(zip(self.names, map(str, point))), **more}


def rods(system: Any) -> Rods:
    """The rods of a system with bounds of its parameters; both may be one number."""
    cells = system.get("kind") == "rod-scheme-family"
    _, given, *more = fields(system, "kind", "parameters", *["cells"] * cells)
    form(isinstance(given, list) and all(isinstance(x, list) and len(x) == 3 for x in given), "bounds are missing")
    names, box = [x[0] for x in given], [(number(x[1]), number(x[2])) for x in given]
    form(names == ["E", "rho", "L", "A", "k"], "a rod has E, rho, L, A and k, in this order")
    form(all(low <= high for low, high in box) and all(low > 0 for low, _ in box[:4]), "E, rho, L and A are positive")
    return Rods(names, box, integer(more[0], 1, 1_000_000) if cells else 0)


def hardest(system: Any) -> tuple[list[Any], dict[str, str]]:
    """The rods at which the conditions of the theorems on rods are hardest, and the bounds in words.

    ``L |k^2 - Z^2|/(k A E) = L |k/(A E) - rho A/k|``, and where it is positive ``(L/E) (max(q, 1/q) - 1)``, ``q =
    k^2/(A^2 rho E)``, is ``L (k^2/(A^2 rho E^2) - 1/E)``, which falls in ``E`` for ``q >= 1``, or ``L (rho A^2/k^2 -
    1/E)``: both are largest for the most ``L, k`` and least ``E, rho, A``, or for the least ``k`` and the others most.
    """
    if system.get("kind") not in ("rod-family", "rod-scheme-family"):
        return [system], {}
    H = rods(system)
    (E, F), (rho, sigma), (_, L), (A, B), (k, l) = H.box
    return [H.at([E, rho, L, A, l]), H.at([F, sigma, L, B, k])], {"parameters": words(H.names, H.box)}


def weighed(terms: Any, point: list[Fraction]) -> list[Fraction]:
    """The products of powers."""
    return [prod((v**e for v, e in zip(point, powers)), start=Fraction(1)) for powers, *_ in terms]


def words(names: list[str], box: Box, rates: Any = ()) -> str:
    """The parameters in words."""
    ranges = [
        f"{name} in [{low}, {high}]" if low < high else f"{name} = {low}" for name, (low, high) in zip(names, box)
    ]
    if not any(rates):
        return f"for all constant {', '.join(ranges)}"
    how = ["constant" if not r else "at any speed" if r == INF else f"by at most {r} in a unit of time" for r in rates]
    return f"for all parameters, {', '.join(f'{one} ({speed})' for one, speed in zip(ranges, how))}"


def plants(system: Any) -> Plants:
    """The plants of a system with parameters, of one channel."""
    late = system.get("kind") == LATE
    form(late or system.get("kind") == "family", "the system is of no kind with parameters")
    time, names, box, terms = stated(system, *["delay"] * late)
    found = list[tuple[list[int], list[Fraction], list[Fraction]]]()
    for term in terms:
        powers, top, bottom = fields(term, "powers", "numerator", "denominator")
        n, d = numbers(top), numbers(bottom)
        form(len(n) == len(d) <= 401, "numerator and denominator have a coefficient for each power, up to 400")
        found.append((exponents(powers, names), n, d))
    form(len({len(d) for *_, d in found}) == 1, "all terms have as many coefficients")
    form(len({tuple(powers) for powers, *_ in found}) == len(found), "powers are there twice")
    up, down = (real(1) + S, real(1) + MINUS * S) if time == "discrete" else (S, real(1))
    forms = [(homogeneous(n, up, down, len(n) - 1), homogeneous(d, up, down, len(d) - 1)) for _, n, d in found]
    H = Plants(time, names, box, found, forms, numbers(system["delay"], len(names) + 1) if late else [])
    least, most = H.waits(box)
    form(not late or (time == "continuous" and least >= 0 < most), "a dead time is in continuous time, and >= 0")
    return H


def stated(system: Any, *more: str) -> tuple[str, list[str], Box, Any]:
    """The time, the names and bounds of the parameters, and the terms of a system with parameters."""
    _, time, given, terms = fields(system, "kind", "time", "parameters", "terms", *more)[:4]
    form(time in ("continuous", "discrete") and isinstance(given, list), "time is one of two, parameters are a list")
    form(0 < len(given) <= MOST_PARAMETERS and all(isinstance(x, list) and len(x) == 3 for x in given), "no parameters")
    names, box = [x[0] for x in given], [(number(x[1]), number(x[2])) for x in given]
    form(all(isinstance(name, str) and NAME.fullmatch(name) for name in names), "a parameter has no name")
    form(len(set(names)) == len(names) and all(low < high for low, high in box), "two have a name, or an interval none")
    form(isinstance(terms, list) and 0 < len(terms) <= 2000, "terms are a list")
    return time, names, box, terms


def exponents(powers: Any, names: list[str]) -> list[int]:
    """The power of each parameter in a term."""
    form(isinstance(powers, list) and len(powers) == len(names), "each parameter has its power")
    return [integer(e, 0, MOST_DEGREE) for e in powers]


def matrices(system: Any) -> Matrices:
    """The plants of several channels of a system with parameters."""
    form(system.get("kind") in CHANNELS, "the system is of no kind with parameters")
    varying, found = system["kind"] == CHANNELS[1], list[tuple[list[int], Fraction, list[Rows]]]()
    time, names, box, terms = stated(system, *["rates"] * varying)
    rates = [INF if r == "inf" else number(r) for r in system["rates"]] if varying else []
    fit = len(rates) == len(names) and max(rates) > 0 and all(r >= 0 for r in rates) if varying else True
    form(fit, "each parameter has its rate, 0 or more, and not all are 0")
    shapes = set[tuple[tuple[int, ...], ...]]()
    for term in terms:
        powers, share, *sides = fields(term, "powers", "common", "A", "B", "C", "D")
        form(all(isinstance(side, list) and side for side in sides), "A, B, C and D are lists of rows")
        rows = [[numbers(row) for row in side] for side in sides]
        shapes.add(tuple(tuple(map(len, side)) for side in rows))
        found.append((exponents(powers, names), number(share), rows))
    form(len({tuple(powers) for powers, *_ in found}) == len(found), "powers are there twice")
    n, m = len(found[0][2][0]), len(found[0][2][3])
    form(shapes == {((n,) * n, (m,) * n, (n,) * m, (m,) * m)}, "A, B, C and D do not fit, or differ in shape")
    form(n <= MOST_STATES and m <= MOST_CHANNELS, "there are too many states or channels")
    return Matrices(time, names, box, found, rates)


def moving(H: Matrices, box: Box, parts: Any, falls: Values, common: Values, unit: int) -> Iterator[Values]:
    """``falls``, of ``-V'``, for parameters that change: less ``c^2 unit sum t_j' P_j``, ``|t_j'|`` at its bounds.

    ``V'`` is affine in the ``t_j'``.  ``P`` does not depend on what may jump: without a bound, or in samples.
    """
    turns = list[tuple[Fraction, Any]]()
    for (low, high), rate, P in zip(box, H.rates, parts[1:]):
        jumps = rate == INF or H.time == "discrete"
        need(not (rate and jumps) or not any(map(any, P)), "P depends on a parameter that may jump")
        if rate and not jumps:
            turns.append((rate / (high - low), P))
    for signs in product((1, -1), repeat=len(turns)):
        found = Values()
        for node, M in falls.items():
            tick()
            found[node] = [list(row) for row in M]
            for sign, (share, P) in zip(signs, turns):
                for i, row in enumerate(P):
                    for j in range(i + 1):
                        found[node][i][j] -= common[node][0][0] ** 2 * unit * sign * share * row[j]
        yield found


def leaves(tree: Any, box: Box, rates: Any = ()) -> Iterator[tuple[Box, Any]]:
    """The boxes into which a box is cut, which cover it by their making, each with its multiplier.

    What changes stays in its box: its interval is not cut.
    """
    pending, count = [(tree, box, 0)], 0
    while pending:
        part, own, depth = pending.pop()
        form(isinstance(part, dict) and depth <= DEEPEST, "a box is cut too often, or is none")
        if "multiplier" in part:
            count += 1
            need(count <= MOST_BOXES, "there are too many boxes")
            yield own, fields(part, "multiplier")[0]
            continue
        which, at, below, above = fields(part, "parameter", "at", "below", "above")
        j, cut = integer(which, 0, len(box) - 1), number(at)
        need(own[j][0] < cut < own[j][1], "a cut lies outside its box")
        need(not any(rates[j : j + 1]), "the interval of a parameter that changes is cut")
        for half, ends in ((above, (cut, own[j][1])), (below, (own[j][0], cut))):
            pending.append((half, [*own[:j], ends, *own[j + 1 :]], depth + 1))


def proved(
    system: Any, proof: Any, name: str, gains: Any, shows: Shows, decides: Decides
) -> tuple[bool, bool, bool, dict[str, str]]:
    """Whether critical, late, and in discrete time, and the hypotheses: of every plant of a box; ``H(inf)`` is 0."""
    H, (method, tree) = plants(system), fields(proof, "method", "boxes")
    degrees = [2 * d for d in H.degrees]
    counts = all(d or any(H.delay[j : j + 1]) for j, d in enumerate(degrees, 1))
    form(method == "boxes" and counts, "the method is boxes, and each parameter counts")
    need(prod(d + 1 for d in degrees) <= MOST_NODES, "the degrees in the parameters are too high")
    need(not any(n[0] for _, n, _ in H.terms), "with parameters H(inf) = 0 is needed")
    need(-INF not in gains and not (H.delay and INF in gains), "a bound is infinite")
    need(not (H.delay and gains[0]), "beside parameters and dead time the classes begin at 0")
    cases = list[tuple[bool, str]]()
    for box, data in leaves(tree, H.box):
        need(not (isinstance(data, dict) and "mirrored" in data), "with parameters the lower bound is a stable gain")
        cases.append(on_box(H, box, gains, partial(shows, data), decides))
    need(len({critical for critical, _ in cases}) == 1, "the loop has a pole at 0 for some of the parameters only")
    facts = {
        "parameters": words(H.names, H.box),
        "stable": f"in the middle of the first box {cases[0][1]}; elsewhere no root crosses the axis: Re(c* d) > 0",
        "well-posed": "H(inf) = 0 for all of the parameters",
        "inequality": f"F > 0: its Bernstein coefficients, of degrees {degrees}, are, at every frequency, on each of "
        f"the boxes that cover these parameters, {len(cases)} of them" + ", whatever the dead time" * bool(H.delay),
    }
    return cases[0][0], bool(H.delay), H.time == "discrete", facts


def on_box(
    H: Plants, box: Box, gains: tuple[Any, Any], shows: Callable[[Block], Any], decides: Decides
) -> tuple[bool, str]:
    """Whether critical, and what is found of the roots in the middle of a box, on which one multiplier shows ``F > 0``.

    The multiplier does not depend on ``p``, so that ``F`` is a form in ``n`` and ``d``: of degree ``2 deg`` in each
    parameter, its value a mean of its Bernstein coefficients on the box, which its values at ``2 deg + 1`` points give.
    So it is with ``Re(c* d)``, ``c`` the ``d`` of the middle: where it is positive ``d`` has no root on the axis, its
    degree is that of ``c``, and by continuity as many of its roots are inside.  With dead time ``F`` is affine in
    ``exp(-i omega T)``, and has two such polynomials, of the terms with this factor and of those without.
    """
    degrees, (l, k), ends = [2 * d for d in H.degrees], gains, H.waits(box)
    wait = (ends[0] + ends[1]) / 2
    middle = H.block([(low + high) / 2 for low, high in box], wait)
    _, _, critical, facts = shows(middle)
    c = lowest(middle, l)
    F, apart, residue, late, full = Values(), Values(), Values(), Values(), 0
    for node in product(*(range(d + 1) for d in degrees)):
        tick()
        B = H.block([low + (high - low) * Fraction(i, d or 1) for (low, high), i, d in zip(box, node, degrees)], wait)
        found, full, same, _ = shows(B)
        need(same == critical, "the loop has a pole at 0 for some of the parameters only")
        known = (0, wait) if H.delay else (0,)
        need(all(tau in known for tau, _ in found), "kernels that are delays are not used with parameters")
        if H.delay:
            sides = found.part(), found.part(0, wait), found.part(1, wait)
            late[node] = [[*side, *[ZERO] * (full + 1 - len(side))] for side in sides]
        F[node], apart[node] = [found.part()], [(c.conjugate() * lowest(B, l)).part()]
        residue[node] = [[sum((u for (_, n), (u, _) in B.n.items() if n == 0), ZERO)]]
    for p in bernstein(F, degrees) if not H.delay else ():
        decides(real(*p), full, critical, k != INF)
    for bare, u, v in coefficients(late, degrees) if H.delay else ():
        waiting(real(*bare), Form({(wait, n): z for n, z in enumerate(zip(u, v))}), ends, full, critical)
    for p in bernstein(apart, degrees):
        decides(real(*p), 2 * (len(H.terms[0][2]) - 1), critical, True)
    turn = over_s(c)[ZERO, 0][0] if critical else ZERO
    positive = (turn * v > 0 for (v,) in bernstein(residue, degrees))
    need(not critical or all(positive), "the residue at 0 is not positive for all parameters")
    return critical, facts["stable"]


def waiting(bare: Form, late: Form, ends: tuple[Fraction, Fraction], full: int, critical: bool) -> None:
    """``F = bare + late`` is positive, and away from 0 over ``omega^full``, with every dead time between the ends.

    ``late`` has the mean ``m`` of the two.  For ``x = omega r <= 1``, ``r`` half of their distance, what is left of the
    turn, ``exp(-i x t)``, ``|t| <= 1``, lies in the triangle of ``exp(i x)``, ``exp(-i x)`` and any number from ``1/cos
    x`` on, such as ``1/(1 - b^2 r^2/2)`` for ``omega <= b``; and ``Re F`` is affine in it.
    """
    (low, high), m, r = ends, (ends[0] + ends[1]) / 2, (ends[1] - ends[0]) / 2
    beyond = 1 / m
    while not tail(bare + late, beyond, full):
        beyond = beyond * 9 / 8
        need(beyond * m < 2**14 and beyond * r <= 1, "the part without dead time does not prevail early enough")
    corners = [bare + Form({(T, n): z for (_, n), z in late.items()}) for T in {low, high}]
    parts = [(ZERO, beyond)]
    while parts:
        a, b = parts.pop()
        wide = real(1 / (1 - b * b * r * r / 2))
        if not all(covered(G, a, b, TERMS, critical) for G in (*corners, *[bare + wide * late] * bool(r))):
            need((b - a) * 2**20 > beyond, f"F > 0 is not shown between omega = {a} and {b}")
            parts += [((a + b) / 2, b), (a, (a + b) / 2)]


def lowest(B: Block, l: Fraction) -> Form:
    """The denominator of the loop with the gain ``l``."""
    return B.d + real(l) * B.n


def bernstein(values: Values, degrees: list[int]) -> Iterator[list[Fraction]]:
    """Bernstein coefficients of the rows that are polynomials in the parameters, from those at the nodes."""
    most = max(len(rows[0]) for rows in values.values())
    filled = {node: [[*rows[0], *[ZERO] * (most - len(rows[0]))]] for node, rows in values.items()}
    return (rows[0] for rows in coefficients(filled, degrees))


def member(system: Any, proof: Any) -> tuple[Any, Any, dict[str, str]]:
    """The plant of a box at which a refutation is, its proof, and where that is."""
    kind = str(system.get("kind"))
    H: Plants | Matrices | Rods = (
        plants(system) if kind in ("family", LATE) else matrices(system) if kind in CHANNELS else rods(system)
    )
    need(proof["method"] == "member", "one plant of the box is needed")
    _, at, inner = fields(proof, "method", "at", "proof")
    point = numbers(at, len(H.names))
    need(all(low <= v <= high for v, (low, high) in zip(point, H.box)), "the parameters are outside their bounds")
    form(isinstance(inner, dict) and "method" in inner and inner["method"] != "member", "a proof is missing")
    return H.at(point), inner, {"parameters": ", ".join(f"{name} = {v}" for name, v in zip(H.names, point))}


def moving_members(system: Any, asked: Any, proof: Any) -> dict[str, str]:
    """Parameters that change, over and over, beside gains that stay or jump: some solution grows.

    One that may change at any speed jumps from list to list; one of a bounded rate goes linearly, and stands in ``A``
    alone, to the first power, so that the matrix of the loop goes linearly too.
    """
    H = matrices(system)
    discrete, keys = H.time == "discrete", ("method", "at", "gains", "squarings", "bits")
    _, path, data, squarings, bits, *lengths = fields(proof, *keys, *([] if discrete else ["times"]))
    lists = isinstance(path, list) and isinstance(data, list) and 0 < len(path) == len(data) <= MOST_STEPS
    form(lists, f"at and gains are 1 to {MOST_STEPS} lists, as many of both")
    plain = not asked.operators and not any(one.memory or one.relu for one in asked.families)
    need(plain and len(H.terms[0][2][0]) <= 64, "functions of sigma and orders up to 64 are needed")
    points, rows = [numbers(one, len(H.names)) for one in path], [channels.member(one, asked) for one in data]
    times = [None] * len(rows) if discrete else numbers(lengths[0], len(rows))
    need(all(t is None or t > 0 for t in times), "a time is not positive")
    inside = all(low <= v <= high for point in points for v, (low, high) in zip(point, H.box))
    need(inside, "the parameters are outside their bounds")
    for i, family in enumerate(asked.families):
        free = family.varying and not family.linear
        need(
            free or len({row[i] for row in rows}) == 1, f"the gain of channel {i + 1} does not vary so fast, or at all"
        )
    following, slow = [*points[1:], points[0]], list[int]()
    for j, (name, rate) in enumerate(zip(H.names, H.rates or [ZERO] * len(H.names))):
        moves = [(abs(after[j] - point[j]), t) for point, after, t in zip(points, following, times)]
        if any(move for move, _ in moves) and rate != INF:
            need(
                all(t is not None and move <= rate * t for move, t in moves),
                f"{name} does not change so fast, or at all",
            )
            slow.append(j)
    for powers, common, sides in H.terms:
        turned = sum(powers[j] for j in slow)
        alone = not common and not any(any(map(any, side)) for side in sides[1:])
        need(not turned or (turned == 1 and alone), "what goes linearly stands elsewhere than in A, or to a power")
    steps = list[Any]()
    for point, after, row, t in zip(points, following, rows, times):
        last = [after[j] if j in slow else v for j, v in enumerate(point)]
        ends = [closed_by(H.plant(one), row) for one in ([point] if last == point else [point, last])]
        need(None not in ends, "1 + H(inf) G is singular for some of the parameters and gains")
        steps.append((ends[0], t, *ends[1:]))
    found = states.grows(steps, integer(squarings, 0, 64), integer(bits, 64, 4096))
    return found | {"parameters": words(H.names, H.box, H.rates)}
