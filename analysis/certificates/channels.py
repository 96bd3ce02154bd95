"""The plant and the classes of several nonlinearities, one in each channel: part of the checker.

Standard library only.  Every function raises ``Rejected`` unless what it is asked to show is shown.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import accumulate, pairwise, product
from typing import Any, NamedTuple

from . import arithmetic as exact
from . import frequencies, pieces, states
from .arithmetic import ZERO, S, eliminated, fields, form, integer, need, number, numbers, real, tick
from .balls import box, dot, positive_definite

EXISTS = "every initial state has a solution with the operators at rest"
RESTED = "play and stop have phi = 0 at first"
MOST_STATES, MOST_CHANNELS, MOST_DELAYS, MOST_VERTICES = 200, 100, 20, 10
DELAYS = ("delay", "varying delay")
SCALAR = "scalar linear time-invariant"  # one delta in each channel of its block
FULL_BLOCK = "full block"  # (phi - l sigma)'(u sigma - phi) >= 0 for the channels of a block together
Rows = list[list[Fraction]]


class Plant(NamedTuple):
    """``x' = A x + B mu``, ``sigma = C x + D mu`` (or ``x+``), ``mu_i = -phi_i(sigma_i)``.

    To ``sigma(t)`` each ``(T, C_T)`` of ``late`` adds ``C_T x(t - T)``, and ``A_T x(t - T)`` of ``inner`` to ``x'``;
    ``(D_T, E_T)`` of ``rates`` add ``D_T x'(t - T)`` and ``E_T x'(t - T)``, an equation of neutral type.
    """

    A: Rows
    B: Rows
    C: Rows
    D: Rows
    discrete: bool
    late: tuple[tuple[Fraction, Rows], ...] = ()
    inner: tuple[Rows, ...] = ()
    rates: tuple[tuple[Rows, Rows], ...] = ()
    pace: Fraction | None = None  # a rate a: each C_T and A_T is multiplied by e^(a T)

    def direct(self, i: int) -> bool:
        """Whether ``sigma_i`` is no function of states alone."""
        return any(map(any, (self.D[i], *(D[i] for D, _ in self.rates))))


class Channels(NamedTuple):
    """The class of each channel, and the channels of each nonlinearity."""

    families: list[states.Family]
    blocks: list[range]
    delayed: tuple[int, ...] = ()  # channels of which a delay was taken out: D has no cycle, and solutions exist
    tied: tuple[range, ...] = ()  # the channels of one function in a full-block sector, whose products are summed

    @property
    def operators(self) -> list[range]:
        """The channels of each operator, that of the performance channel last."""
        return [block for block in self.blocks if self.families[block[0]].operator]

    @property
    def performance(self) -> range | None:
        """The channels from ``z`` to ``w``; None where no gain is asked for."""
        return self.blocks[-1] if self.families[-1].operator == "performance" else None

    @property
    def functions(self) -> list[int]:
        """The channels without an operator."""
        return [i for i, family in enumerate(self.families) if not family.operator]

    def bounds(self, i: int) -> tuple[Any, Any]:
        """Bounds of ``phi_i(sigma)/sigma``: those of the sector and, as ``phi_i(0) = 0``, those of the slope.

        A delay has none, nor is it of small norm: there the bound is that of ``tau``.  Nor has a full block: see
        :func:`centred`.
        """
        need(not self.families[i].memory, f"channel {i + 1} has memory, which this theorem does not cover")
        need(self.families[i].operator not in DELAYS, f"channel {i + 1} has a delay, which this theorem does not cover")
        need(self.families[i].operator != FULL_BLOCK, f"channel {i + 1} is of a full block, not covered here")
        sector, slope = self.families[i].sector, self.families[i].slope
        return max(sector[0], slope[0]), min(sector[1], slope[1])


def plant(system: Any, late: bool = False, rate: Fraction | None = None) -> Plant:
    """The plant of a certificate; with dead times only where these are asked for, at a rate what arrives is larger."""
    late = late and isinstance(system, dict) and "late" in system
    kind, domain, *sides = fields(system, "kind", "time", "A", "B", "C", "D", *["late"] * late)
    listed, times = sides.pop() if late else [], ("continuous",) if late else ("continuous", "discrete")
    form(kind == "multivariable" + " delay" * late and domain in times, "the system is of no kind for channels")
    form(all(isinstance(side, list) and side for side in sides), "A, B, C and D are lists of rows")
    n, m = len(sides[0]), len(sides[3])
    form(n <= MOST_STATES and m <= MOST_CHANNELS, "there are too many states or channels")
    form([len(side) for side in sides] == [n, n, m, m], "A, B, C and D do not fit, or inputs and outputs differ")
    A, B, C, D = ([numbers(row, width) for row in side] for side, width in zip(sides, (n, m, n, m)))
    listing = isinstance(listed, list) and len(listed) <= MOST_DELAYS and (not late or len(listed) > 0)
    form(listing, "late is a list of pairs, of triples, or of five each")
    parts, inner, rates = list[tuple[Fraction, Rows]](), list[Rows](), list[tuple[Rows, Rows]]()
    for one in listed:
        form(isinstance(one, list) and len(one) == len(listed[0]) and len(one) in (2, 3, 5), "a dead time has its C")
        for side, rows in zip(one[1:], (m, n, m, n)):
            form(isinstance(side, list) and len(side) == rows, "C or A of a dead time has other rows")
        C_T, *back = ([numbers(row, n) for row in side] for side in one[1:])
        parts.append((number(one[0]), C_T))
        inner += back[:1]
        rates += [(back[1], back[2])] if len(back) > 1 else []
    form(all(a < b for a, b in pairwise([ZERO, *(tau for tau, _ in parts)])), "the dead times do not ascend from 0")
    return Plant(A, B, C, D, domain == "discrete", tuple(parts), tuple(inner), tuple(rates), rate if late else None)


def channels(data: Any, m: int) -> Channels:
    """The classes of a certificate, one for each channel."""
    given, repeated = fields(data, "channels", "repeated")
    form(isinstance(given, list) and len(given) == m, f"{m} classes are needed, in order")
    sizes = ([m] if repeated else [1] * m) if type(repeated) is bool else repeated
    form(isinstance(sizes, list), "repeated is true, false, or how many channels in turn have the same nonlinearity")
    ends = list(accumulate(integer(size, 1, m) for size in sizes))
    form(ends[-1:] == [m], f"the channels with the same nonlinearity do not add up to {m}")
    blocks = [range(end - size, end) for end, size in zip(ends, sizes)]
    families = [states.classes(one, several=True) for one in given]
    asked = [families[block[0]].operator for block in blocks]
    form("performance" not in asked[:-1], "the performance channel is one, and the last")
    same = all(given[i] == given[block[0]] for block in blocks for i in block)
    form(same, "a repeated nonlinearity has one class")
    return Channels(families, blocks)


def lasting(given: Any, name: str) -> None:
    """With a rate classes of functions, of several channels too, are the same: they have a sector at each time."""
    kinds = [one["operator"] for one in given if "operator" in one]
    functions = all(kind == FULL_BLOCK for kind in kinds) and not (kinds and name == "coupled-windows")
    need(functions, "an operator has another norm with a rate")
    need(not any("memory" in one for one in given), "with play and stop 0 attracts nothing at a rate")


def described(asked: Channels) -> str:
    """The classes in words."""
    words = "; ".join(f"channel {i}: {states.described(family)}" for i, family in enumerate(asked.families, 1))
    joint = [(block, f"{block[0] + 1} to {block[-1] + 1}") for block in asked.blocks if len(block) > 1]
    alike = {block[0] for block in asked.operators if asked.families[block[0]].operator == SCALAR}
    for b, where in joint:
        if b in asked.operators:
            kind = "function of" if asked.families[b[0]].operator == FULL_BLOCK else "operator on"
            words += f"; one {'operator in each of' if b[0] in alike else kind} the channels {where}"
    same = [where for block, where in joint if block not in asked.operators]
    if len(asked.blocks) == 1 and same:
        return f"{words}; one nonlinearity in all channels"
    return "".join([words, *(f"; one nonlinearity in the channels {channels}" for channels in same)])


def ordered(D: Rows, asked: Channels) -> bool:
    """Whether the channels can be taken one after the other, each ``sigma_i`` given by those before it.

    The channels of an operator are taken together, but of one that acts in each of them; ``w`` is given, and ``z``
    determines nothing.
    """
    together = [block for block in asked.operators if block != asked.performance]
    apart = [[i] for block in together if asked.families[block[0]].operator == SCALAR for i in block]
    together = [block for block in together if asked.families[block[0]].operator != SCALAR]
    left = {tuple(block) for block in [*together, *apart, *([i] for i in asked.functions)]}
    if asked.delayed:
        return True
    while free := {one for one in left if not any(D[i][j] for i in one for other in left for j in other)}:
        left -= free
    return not left


def existing(asked: Channels) -> str:
    """What is assumed of operators."""
    past = [None if asked.performance is None else asked.performance[0], *asked.delayed]
    return EXISTS if any(block[0] not in past for block in asked.operators) else ""


def uniform(weights: Any, asked: Channels) -> None:
    """An operator on all of its channels together has one weight for them, the performance channel one > 0."""
    together = [block for block in asked.operators if asked.families[block[0]].operator != SCALAR]
    together += asked.tied
    one = all(weights[i] == weights[block[0]] for block in together for i in block)
    need(one, "the channels of an operator have different weights")
    need(asked.performance is None or weights[-1] > 0, "the weight of the performance channel is not positive")


def each(asked: Channels) -> Any:
    """The class of each channel with its number."""
    return enumerate(asked.families)


def unit_of(Pi: Rows, theta: Any, bounds: Any) -> int:
    """What makes integers of a multiplier, and of what ``V`` is at least."""
    return states.unit([*Pi, theta, [min(t * l, t * u) for t, (l, u) in zip(theta, bounds)]])


def triangle(given: Any, order: int) -> Rows:
    """The symmetric matrix of a lower triangle."""
    form(isinstance(given, list) and len(given) == order, f"a lower triangle of order {order} is missing")
    half = [numbers(row, i + 1) for i, row in enumerate(given)]
    return [[half[max(i, j)][min(i, j)] for j in range(order)] for i in range(order)]


def definite(Pi: Rows, view: Rows, where: str, less: Any = None, resting: bool = False) -> None:
    """``view' Pi view``, less a matrix if there is one, is positive definite, or ``resting`` semidefinite."""
    columns = [*zip(*view)]
    turned = [[dot(row, column) for row in Pi] for column in columns]
    inner = [[dot(row, column) for column in columns[: i + 1]] for i, row in enumerate(turned)]
    if less is not None:
        inner = [[v - w for v, w in zip(row, other)] for row, other in zip(inner, less)]
    q, failure = states.unit(inner), f"Pi is not positive {'semi' * resting}definite {where}"
    if not resting:
        return need(positive_definite([[int(q * v) for v in row] for row in inner]), failure)
    need(semidefinite(inner), failure)


def diagonal(weights: list[Fraction], bounds: Any) -> Rows:
    """``Pi`` of ``2 sum lambda_i (phi_i - l_i sigma_i)(u_i sigma_i - phi_i)``, ``lambda_i >= 0``."""
    need(min(weights) >= 0, "a weight lambda is negative")
    m = len(weights)
    Pi = [[ZERO] * 2 * m for _ in range(2 * m)]
    for i, (v, (l, u)) in enumerate(zip(weights, bounds)):
        Pi[i][i], Pi[i][m + i], Pi[m + i][i], Pi[m + i][m + i] = -2 * v * l * u, v * (l + u), v * (l + u), -2 * v
    return Pi


def full_block(given: Any, parts: Any, bounds: Any, resting: bool = False) -> Rows:
    """``Pi`` whose form is nonnegative for ``phi = Delta sigma``, ``Delta`` diagonal and within the bounds.

    At every vertex ``(1; Delta)' Pi (1; Delta) > 0``, and ``Pi`` has no entry > 0 on the diagonal of ``phi``: the form
    is concave in each ``Delta_ii``.  Or, with ``N``: ``phi_i - l_i sigma_i`` and ``u_i sigma_i - phi_i`` have one sign
    ``s_i``; times it both are ``y >= 0``, and the form in ``y`` less that of ``N``, entries ``>= 0``, is positive
    definite for all signs, up to a common one.  With equilibria, ``resting``, all these are only semidefinite.
    """
    m = len(bounds)
    need(m <= MOST_VERTICES, f"full-block multipliers are for up to {MOST_VERTICES} channels")
    Pi = triangle(given, 2 * m)
    if not parts:
        need(max(Pi[m + i][m + i] for i in range(m)) <= 0, "Pi is not concave in each gain")
        for ends in product(*bounds):
            view = [[Fraction(i == j) for j in range(m)] for i in range(m)]
            definite(
                Pi,
                [*view, *([d * v for v in row] for d, row in zip(ends, view))],
                "at a vertex of the gains",
                resting=resting,
            )
        return Pi
    form(
        isinstance(parts[0], list) and len(parts[0]) == 2 ** (m - 1), f"N has one part for each of {2 ** (m - 1)} signs"
    )
    for rest, part in zip(product((1, -1), repeat=m - 1), parts[0]):
        N, view = triangle(part, 2 * m), [[ZERO] * 2 * m for _ in range(2 * m)]
        need(min(map(min, N)) >= 0, "an entry of N is negative")
        for i, (sign, (l, u)) in enumerate(zip((1, *rest), bounds)):
            view[i][i] = view[i][m + i] = sign / (u - l)
            view[m + i][i], view[m + i][m + i] = sign * u / (u - l), sign * l / (u - l)
        definite(Pi, view, "for one of the signs", N, resting)
    return Pi


def semidefinite(half: Any) -> bool:
    """Whether the matrix of a lower triangle is positive semidefinite, by elimination in fractions."""
    left = [[Fraction(half[max(i, j)][min(i, j)]) for j in range(len(half))] for i in range(len(half))]
    while left:
        tick()
        (pivot, *side), *rows = left
        if pivot < 0 or (pivot == 0 and any(side)):
            return False
        left = [[v - first * u / pivot if pivot else v for v, u in zip(row, side)] for first, *row in rows]
    return True


def closed_by(H: Plant, gains: list[Fraction]) -> Rows | None:
    """The matrix of the loop with constant gains; None if it has no solution."""
    found = closed_loop(H, [[g * (i == j) for j in range(len(gains))] for i, g in enumerate(gains)])
    return None if found is None else found.A


def closed_loop(H: Plant, G: Rows) -> Plant | None:
    """``x' = A x + B w``, ``sigma = C x + D w`` with ``mu = w - G sigma``; None if it has no solution."""
    m = len(G)
    # sigma = C x + D mu: (1 + G D) mu = w - G C x
    left = [[(i == j) + dot(g, column) for j, column in enumerate(zip(*H.D))] for i, g in enumerate(G)]
    right = [
        [*(-dot(g, column) for column in zip(*H.C)), *(Fraction(i == j) for j in range(m))] for i, g in enumerate(G)
    ]
    solved = eliminated(left, right)
    if solved is None:
        return None
    columns, n = [*zip(*solved)], len(H.A)
    sides = [[[dot(b, column) for column in columns] for b in side] for side in (H.B, H.D)]
    A, C = (
        [[v + w for v, w in zip(row, more)] for row, more in zip(own, side)] for own, side in zip((H.A, H.C), sides)
    )
    B, D = ([row[n:] for row in side] for side in sides)
    return Plant(A, B, C, D, H.discrete)


def within(A: Rows, discrete: bool, zeros: int = 0) -> bool:
    """Whether all eigenvalues but so many, which are 0 (in discrete time 1), are strictly inside, by Routh's array."""
    found = characteristic(A)
    for _ in range(zeros):
        *found, rest = accumulate(found, lambda high, c: high + c if discrete else c)
        if rest:
            return False
    return inside(found, discrete)


def inside(p: list[Fraction], discrete: bool) -> bool:
    """Whether all roots of a polynomial, descending, are strictly inside, by Routh's array."""
    up, down = (real(1) + S, real(1) + exact.MINUS * S) if discrete else (S, real(1))
    inner = exact.homogeneous(p, up, down, len(p) - 1)
    return len(exact.primitive(exact.ascending(inner))) == len(p) and exact.hurwitz(inner)


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


def member(data: Any, asked: Channels, growing: bool = False, near: bool = False) -> list[Fraction]:
    """One gain for each channel, all of the class; of solutions that grow those of play and stop far from 0.

    ``near``: gains that play and stop come near to, uniformly up to any time from rest: a play of slope ``g`` and a
    small width (``g = 0``: of a large one), a stop of slope ``g`` and a large width (``g = 0``: of a small one).
    """
    gains = numbers(data, len(asked.families))
    ends = list[tuple[Any, Any]]()
    for g, (i, family) in zip(gains, each(asked)):
        if growing and family.memory:  # up to a bounded difference k sigma, and 0
            kind, k = family.memory
            need(g > 0 or kind == "stop", f"channel {i + 1} has a play, of which the gain 0 is none")
            ends.append((0, k if kind == "play" else 0))
        elif near and family.memory:
            ends.append((0, family.memory[1]))
        elif family.operator == FULL_BLOCK:
            ends.append(family.sector)
        else:
            ends.append((1, 1) if family.operator in DELAYS else asked.bounds(i))
    inside = all(low <= g <= high for g, (low, high) in zip(gains, ends))
    need(not any(gains[i] for i in asked.performance or ()), "the performance channel is no part of the loop")
    alike = [block for block in asked.blocks if asked.families[block[0]].operator != FULL_BLOCK]
    need(inside and all(len({gains[i] for i in block}) == 1 for block in alike), "the gains are outside the class")
    return gains


def matrices(gains: list[Fraction], given: Any, asked: Channels) -> Rows:
    """Gains, and matrices of them for full blocks, ``(G - l)'(u - G)`` and its transpose adding up to ``>= 0``."""
    found = [[g * (i == j) for j in range(len(gains))] for i, g in enumerate(gains)]
    blocks = [block for block in asked.operators if asked.families[block[0]].operator == FULL_BLOCK]
    form(isinstance(given, list) and len(given) == len(blocks) > 0, "there is a matrix for each full block, in order")
    for block, rows in zip(blocks, given):
        form(isinstance(rows, list) and len(rows) == len(block), "a matrix of gains does not fit its block")
        G, (low, high) = [numbers(row, len(block)) for row in rows], asked.families[block[0]].sector
        above = [[v - low * (i == j) for j, v in enumerate(row)] for i, row in enumerate(G)]
        below = [[high * (i == j) - v for j, v in enumerate(row)] for i, row in enumerate(G)]
        sides = [[dot(a, b) for b in zip(*below)] for a in zip(*above)]
        half = [[sides[i][j] + sides[j][i] for j in range(i + 1)] for i in range(len(G))]
        need(semidefinite(half), "a matrix of gains is not of its class")
        for i, row in zip(block, G):
            for j, v in zip(block, row):
                found[i][j] = v
    return found


def moved(H: Plant) -> Rows:
    """Rows of ``(A, -B)``: ``x'`` (or ``x+``) from ``(x, phi)``."""
    return [[*a, *(-v for v in b)] for a, b in zip(H.A, H.B)]


def seen(H: Plant) -> Rows:
    """Rows of ``(C, -D)``: ``sigma`` from ``(x, phi)``."""
    return [[*c, *(-v for v in d)] for c, d in zip(H.C, H.D)]


# -- what the axis shows: dead times of the plant, and delays of the class
def crossing(H: Plant, asked: Channels, proof: Any) -> tuple[int, dict[str, str]]:
    """Constant gains of a plant with dead times: a root on the imaginary axis, or a real one ``s >= 0``.

    ``p(t, omega) = det(d + N G) = sum (1 - t)^(c - k) t^k D_k`` with ``G = (1 - t) G_0 + t G_1``, ``c`` channels
    differing; ``D_k`` adds up the determinants with ``k`` columns of ``G_1``.  Turned by a number, ``Re p`` has
    different signs for ``t = 0`` and ``1``, and ``Im p``, as all ``D_k`` have, at both ends of ``omega``: inside is a
    root (Poincare, Miranda), of ``det(1 + H G)`` where ``d`` has none, and ``sigma = e^(i omega t) v``.

    Else :func:`still`.
    """
    need(not any(family.relu or family.memory for family in asked.families), "no gain is such a member")
    need(asked.performance is None, "beside dead times gains from w to z are not covered")
    need(len(H.D) <= frequencies.MOST_CHANNELS, "there are too many channels for determinants")
    if proof["method"] == "late-gains":
        return still(H, asked, proof)
    if proof["method"] == "late-turns":
        gains = member(fields(proof, "method", "gains")[1], asked)
        if not (any(gains) or H.inner):  # the dead times are outputs alone
            p = characteristic(H.A)
            while not p[-1] and H.pace is None:
                p.pop()
            need(not inside(p, False), "with the gains 0 all roots but s = 0 are strictly inside")
            which = f"root{' s != 0' * (H.pace is None)} that is not strictly inside"
            return 1, {"root": f"det(s - A) has a {which}, by Routh's array; all gains are 0"}
        number, _, found = pieces.right_roots(H, gains)
        need(number > 0, "with these gains no root Re s > 0 is shown")
        return 1, {"root": f"{number} roots Re s > 0: {found}"}
    H, inner = pieces.opened(H)
    m, (d, N) = len(H.D), pieces.quotients(H, [ZERO] * len(H.D))
    one = [[d if i == j else exact.Form() for j in range(m)] for i in range(m)]
    _, given, where, turn = fields(proof, "method", "gains", "frequencies", "turn")
    form(isinstance(given, list) and len(given) == 2, "there are gains at two ends")
    ends, (a, b), (x, y) = [member(row, asked) + inner for row in given], numbers(where, 2), numbers(turn, 2)
    need(0 < a < b, "the frequencies are not in order")
    apart = [j for j in range(m) if ends[0][j] != ends[1][j]]
    sides = [[[u + real(g) * f for u, f, g in zip(*rows, row)] for rows in zip(one, N)] for row in ends]
    parts = [exact.Form() for _ in range(len(apart) + 1)]
    for chosen in product((0, 1), repeat=len(apart)):
        pick = dict(zip(apart, chosen))
        F = [[sides[pick.get(j, 0)][i][j] for j in range(m)] for i in range(m)]
        parts[sum(chosen)] += pieces.leading(F)[-1]
    re, im = (exact.Form({(ZERO, 0): z}) for z in ((x, y), (y, -x)))  # Im z = Re(-i z)
    faces = [[([re * p], a, b) for p in (parts[0], parts[-1])], [([im * p for p in parts], w, w) for w in (a, b)]]

    def apart_in_sign(face: list[tuple[list[exact.Form], Fraction, Fraction]]) -> bool:
        """Whether all are above 0 on the one side and below 0 on the other."""
        signs = [[real(s) for s in pair] for pair in ((1, -1), (-1, 1))]
        return any(all(box(s * p, v, w, 24) for s, (ps, v, w) in zip(pair, face) for p in ps) for pair in signs)

    need(box(d * d.conjugate(), a, b, 24), "d vanishes between the frequencies")
    need(bool(apart) and all(map(apart_in_sign, faces)), "no root i omega is shown for gains between the two")
    return 1, {"root": f"det(1 + H G) = 0 for one omega between {a} and {b} and gains between the two"}


def still(H: Plant, asked: Channels, proof: Any) -> tuple[int, dict[str, str]]:
    """Constant gains with ``chi(0) <= 0 < det(1 + D G)``: a real root ``s >= 0`` of ``chi = det(s - A) det(1 + H G)``.

    It has no pole, and is ``s^n det(1 + D G) (1 + o(1))`` for large ``s``.
    """
    gains = member(fields(proof, "method", "gains")[1], asked)
    C = [[sum(v, ZERO) for v in zip(*rows)] for rows in zip(H.C, *(rows for _, rows in H.late))]
    A = [[sum(v, ZERO) for v in zip(*rows)] for rows in zip(H.A, *H.inner)]
    G = [[g * (i == j) for j in range(len(gains))] for i, g in enumerate(gains)]
    found, far = (
        closed_loop(H._replace(A=A, C=C), G),
        [[(i == j) + v * g for j, (v, g) in enumerate(zip(row, gains))] for i, row in enumerate(H.D)],
    )
    need(
        found is not None and frequencies.determinant([[[v] for v in row] for row in far])[0] > 0,
        "det(1 + D G) > 0 fails",
    )
    near = characteristic((found or H).A)[-1]  # chi(0)/det(1 + D G)
    need(near < 0 or (near == 0 and not H.inner and within(H.A, False)), "no root s >= 0 is shown with these gains")
    return 1 if near else 2, {"root": f"det(s - A) det(1 + H(s) G) is {near} at 0, of its sign at infinity"}


# -- delays: mu = -sigma(t - tau), 0 <= tau <= h, as the operator w = sigma(t - tau) - sigma beside the gain 1


def centred(H: Plant, asked: Channels) -> tuple[Plant, Channels]:
    """The loop with ``(l + u) sigma/2`` in place of each full block, and a function of norm up to ``(u - l)/2`` beside.

    ``(phi - l sigma)'(u sigma - phi) = r^2 |sigma|^2 - |phi - c sigma|^2``.  It is a causal operator, at rest at first,
    and locally Lipschitz: solutions exist where ``D`` has no cycle, the channels of a block being taken together.

    Beside dead times it is a time-varying function in each channel, if all of a block have one weight and no more.
    """
    own = [i for i, family in each(asked) if family.operator == FULL_BLOCK]
    if not own:
        return H, asked
    families, m = list(asked.families), len(asked.families)
    if H.late:
        need(ordered(H.D, asked), "beside dead times and full blocks D has a cycle of channels")
        tied = tuple(block for block in asked.operators if block[0] in own)
        for i in own:
            families[i] = families[i]._replace(operator="", varying=True)
        return H, asked._replace(families=families, delayed=tuple(own), tied=tied)
    middle = [sum(family.sector) / 2 if i in own else ZERO for i, family in each(asked)]
    found = closed_loop(H, [[middle[i] * (i == j) for j in range(m)] for i in range(m)])
    need(found is not None, "the loop with the gains in the middle of full blocks has no solution", exact.IllPosed)
    for i in own:
        r = (families[i].sector[1] - families[i].sector[0]) / 2
        families[i] = families[i]._replace(operator="any", sector=(-r, r), varying=True)
    solved = tuple(own) if ordered(H.D, asked) else ()
    return found or H, asked._replace(families=families, delayed=solved)


def undelayed(H: Plant, asked: Channels, kept: bool = False) -> tuple[Plant, Channels]:
    """The loop with the gain 1 in place of each delay, and norm-bounded operators beside these.

    Constant delays, and those of a bounded slope, may be kept for the theorem about them.

    In samples ``w`` is less the sum of the last ``tau``
    differences of ``sigma``, an operator of norm up to ``h`` on these, whether ``tau`` is constant or not.

    A constant one: ``w = Delta m(h s) sigma`` with ``|Delta| <= 1``, linear and time-invariant, as
    ``|e^(-i omega tau) - 1| <= |m(i omega h)|`` (:func:`frequencies.majorised`), ``m(s)/s`` and its inverse times
    ``s/(1 + s)`` being stable.  Else ``w = -int_(t - tau)^t sigma'``: ``|w|^2 <= h int_(t - h)^t |sigma'|^2``, so that
    ``w`` is a causal operator of norm up to ``h`` on ``sigma'``.  What is before ``t = 0`` is an input ``e`` of finite
    energy.
    """
    own = [i for i, family in each(asked) if family.operator in DELAYS]
    if own:
        need(ordered(H.D, asked), "beside delays D has a cycle of channels")
    H, asked = centred(H, asked)
    if not own:
        return H, asked
    asked = asked._replace(delayed=(*asked.delayed, *own))
    if H.late:
        need(kept, "beside dead times delays are covered on pieces of the axis")
        return H, asked
    apart = [i for i in own if not asked.families[i].varying or asked.families[i].rate is not None]
    own = [i for i in own if not (kept and i in apart)]
    constant = [i for i in own if not asked.families[i].varying and not H.discrete]
    rise, fall = frequencies.RISE, frequencies.FALL
    if constant:
        frequencies.majorised()
    families = list(asked.families)
    found = closed_loop(H, [[Fraction(i == j and i in own) for j in range(len(H.D))] for i in range(len(H.D))])
    need(found is not None, "the loop without delay has no solution", exact.IllPosed)
    A, B, C, D = (found or H)[:4]
    for i in own:
        h, fixed = families[i].sector[1], i in constant
        one, kind = (Fraction(1), SCALAR) if fixed else (h, "any")
        families[i] = families[i]._replace(operator=kind, sector=(-one, one), varying=not fixed, rate=None)
        if H.discrete:  # sigma - z, z+ = sigma
            A = [[*row, ZERO] for row in A] + [[*C[i], ZERO]]
            B, C = [*B, D[i]], [[*row, ZERO - (j == i)] for j, row in enumerate(C)]
            continue
        if not fixed:
            need(not any(H.D[i]), f"sigma_{i + 1}, whose delay varies, is no function of the state alone")
            C[i], D[i] = ([dot(C[i], column) for column in zip(*side)] for side in (A, B))
            continue
        n, last = len(A), fall[3] * h  # h z' = shift z, its last row with sigma: z_1 = FALL_3 sigma/FALL(h s)
        A = [[*row, *[ZERO] * 3] for row in A] + [[ZERO] * n + [(k == j + 1) / h for k in range(3)] for j in range(2)]
        A.append([*(v / h for v in C[i]), *(-Fraction(v) / last for v in fall[:3])])
        B += [[ZERO] * len(D), [ZERO] * len(D), [v / h for v in D[i]]]
        top = Fraction(rise[3], fall[3])
        C[i] = [top * v for v in C[i]] + [(rise[k] - top * fall[k]) / fall[3] for k in range(3)]
        C = [[*row, *[ZERO] * (n + 3 - len(row))] for row in C]
        D[i] = [top * v for v in D[i]]
    return Plant(A, B, C, D, H.discrete), asked._replace(families=families)
