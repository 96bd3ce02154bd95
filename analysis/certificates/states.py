"""State-space arguments of the checker: graphs through points, matrix inequalities, growing and periodic solutions.

Standard library only.  Every function raises ``Rejected`` unless what it is asked to show is shown.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterator
from fractions import Fraction
from itertools import combinations, compress, pairwise, permutations
from itertools import product as signings
from typing import Any, NamedTuple

from .arithmetic import INF, ZERO, IllPosed, eliminated, extended, fields, form, integer, need, number, numbers, tick
from .balls import Ball, ball, dot, exponential, identity, norm, plus, positive_definite, product, ramp, size

FLOW_ORBIT = "method points left right pieces durations state half inverse radius bits"
SOLVABLE = "assumed: sigma + H(inf) phi(sigma) is increasing with a locally Lipschitz inverse"
REGULAR = "locally Lipschitz"
TERMS, DEEPEST = 12, 48  # of Taylor's formula; halvings of a stay


class Family(NamedTuple):
    """A class of nonlinearities."""

    sector: tuple[Any, Any]
    slope: tuple[Any, Any]  # (-inf, inf): nothing is assumed
    endless: tuple[bool, bool]  # whether the upper bounds are no bounds at all, or stand for every finite one
    odd: bool
    varying: bool
    linear: bool
    rough: bool = False  # of any regularity, else locally Lipschitz
    relu: bool = False  # the upper bound times sigma above 0, the lower one times sigma below
    rate: Any = None  # of linear ones that depend on time: how fast the gain changes
    memory: Any = None  # ("play" or "stop", k): increments of phi are between 0 and k times those of sigma
    operator: str = ""  # which mu_b = -Delta sigma_b, of norm up to the upper bound; else a function of sigma


OPERATORS = {
    "any": "causal operators",
    "linear time-invariant": "stable linear time-invariant operators",
    "scalar linear time-invariant": "delta times the identity, delta a stable linear time-invariant operator,",
    "performance": "from z to w",
    "delay": "sigma(t - tau) with a constant tau",
    "varying delay": "sigma(t - tau(t)) with any tau(t)",
    "full block": "functions of all sigma of the block together",
}


def classes(data: Any, several: bool = False) -> Family:
    """The class of nonlinearities of a certificate; of ``several`` also gains with a rate, and operators."""
    own = isinstance(data, dict) and several and "rate" in data
    operator = data["operator"] if several and isinstance(data, dict) and "operator" in data else None
    keys = [
        *["sector", "slope", "odd", "time_varying", "linear"],
        *["regularity"] * (isinstance(data, dict) and "regularity" in data),
        *["relu"] * (isinstance(data, dict) and "relu" in data),
        *["rate"] * own,
        *["operator"] * (operator is not None),
        *["memory"] * (several and isinstance(data, dict) and "memory" in data),
    ]
    sector, slope, odd, varying, linear, *_ = fields(data, *keys)
    form(data.get("regularity", "any") == "any", "regularity is left out or any")
    form(data.get("relu", True) is True, "relu is left out or true")
    rate = number(data["rate"]) if own else None
    slow = linear is varying is True if operator is None else operator == "varying delay" and (rate or 0) < 1
    form(rate is None or (rate > 0 and slow), "a rate > 0 is one of gains that depend on time, or below 1 of delays")
    if operator is not None:
        plain = (slope, odd, linear, len(keys) - own) == (None, False, False, 6)
        form(isinstance(operator, str) and operator in OPERATORS, "operator is of no kind there is")
        moving = operator in ("any", "performance", "varying delay") or (operator == "full block" and varying)
        form(plain and not (own and operator == "full block"), "an operator has a bound of its norm alone")
        form(varying is moving, "an operator has a bound of its norm alone")
    form(all(type(x) is bool for x in (odd, varying, linear)), "odd, time_varying and linear are true or false")
    form(rate is not None or not (linear and varying), "gains that depend on time have a rate, constant ones do not")
    form(
        all(isinstance(x, list) and len(x) == 2 for x in (sector, slope or [0, 0])),
        "sector and slope are pairs of bounds",
    )
    bounds = [(extended(x[0]), extended(x[1])) for x in (sector, slope if slope is not None else ["-inf", "inf"])]
    form(all(x[0] < x[1] for x in bounds), "the bounds are not in order")
    form(
        max(bounds[0][0], bounds[1][0]) <= min(bounds[0][1], bounds[1][1]),
        "no nonlinearity has both the sector and the slopes",
    )
    rough, relu = "regularity" in data, "relu" in data
    known = bounds[0] == bounds[1] and INF not in map(abs, bounds[0]) and not (odd or varying or linear or rough)
    form(known or not relu, "a ReLU has equal finite bounds of sector and slope, and no other property")
    centred = operator in (None, "full block") or -bounds[0][0] == bounds[0][1]
    form(centred and (operator is None or INF not in map(abs, bounds[0])), "the bounds of an operator are -r and r")
    if "memory" in keys:  # of phi(sigma)/sigma there is no bound
        form(data["memory"] in ("play", "stop") and len(keys) == 6, "memory is play or stop, with no other property")
        plain = bounds[0] == bounds[1] and bounds[0][0] == 0 and bounds[0][1] < INF and not (odd or varying or linear)
        form(plain, "play and stop have a slope from 0 to a finite bound, and no other property")
        free = (-INF, INF)
        return Family(free, free, (True, True), False, False, False, memory=(data["memory"], bounds[0][1]))
    endless = (sector[1] == "inf", slope is None or slope[1] == "inf")
    return Family(bounds[0], bounds[1], endless, odd, varying, linear, rough, relu, rate, operator=operator or "")


def regular(family: Family, without: bool) -> None:
    """Whether the proof holds for phi that jump: then the next state is defined, and V falls, whatever phi is."""
    need(
        not family.rough or without,
        "locally Lipschitz nonlinearities are needed: this is no circle criterion in discrete time "
        "with H(inf) = 0 and no root at z = 1",
    )


def described(family: Family) -> str:
    """The class of nonlinearities in words."""
    if family.memory:
        return f"all {family.memory[0]} operators of a slope up to {family.memory[1]}, of any width and initial state"
    if family.operator:
        bound = family.sector[1]
        if family.operator == "performance":
            return f"{OPERATORS[family.operator]}, gamma = {1 / bound} (about {float(1 / bound):.9g})"
        if "delay" in family.operator:
            slow = "" if family.rate is None else f" of a slope up to {family.rate}"
            return f"all phi = {OPERATORS[family.operator]}{slow} in [0, {bound}], from any bounded initial function on"
        if family.operator == "full block":
            time = "which may depend on time" if family.varying else "the same at all times"
            within = ", ".join(map(str, family.sector))
            return f"all {OPERATORS[family.operator]}, {REGULAR}, {time}, in the full-block sector [{within}]"
        return f"all {OPERATORS[family.operator]} of L2 gain up to {bound}, at rest at first"
    kind = "constant gains" if family.linear else "time-varying laws" if family.varying else "time-invariant laws"
    if family.relu:
        return f"phi = {family.slope[1]} max(sigma, 0) + {family.slope[0]} min(sigma, 0)"
    kind = kind if family.rate is None else f"gains that change at rates up to {family.rate}"
    odd, any_of = "odd " * (family.odd and family.rate is None), "continuous or not" if family.rough else REGULAR
    words = [f"all {odd}{kind} with phi(0) = 0, {any_of}"]
    for name, (l, k), endless in zip(("phi(sigma)/sigma", "slope"), family[:2], family.endless):
        near = "" if abs(k) == INF or k.denominator < 10**6 else f" (about {float(k):.9g})"
        top = "without upper bound" if endless else "up to any finite bound" if k == INF else f"up to {k}{near}"
        words += [f"{name} from {l} {top}"] * (l != -INF or k != INF or not endless)
    return ", ".join(words)


class Graph(NamedTuple):
    """Piecewise linear, with one slope more than knots, 0 among them."""

    knots: list[tuple[Fraction, Fraction]]
    slopes: list[Fraction]

    @property
    def lines(self) -> list[tuple[Fraction, Fraction, Fraction]]:
        """Of each piece a point and the slope; the points of all but the first are where it begins."""
        sides = zip(self.knots, self.slopes, self.slopes[1:])
        return [(*self.knots[0], self.slopes[0]), *((x, w, k) for (x, w), h, k in sides if h != k)]

    def at(self, x: Fraction) -> Fraction:
        """``phi(x)``."""
        i = bisect_left(self.knots, x, key=lambda knot: knot[0])
        s, w = self.knots[max(i - 1, 0)]
        return w + self.slopes[i] * (x - s)

    def member(self, family: Family) -> bool:
        """Whether it lies in the class: chords between knots are monotone, next to 0 and far out slopes."""
        odd = self.slopes[0] == self.slopes[-1] and all(self.at(-x) == -w for x, w in self.knots)
        i = [x for x, _ in self.knots].index(ZERO)
        chords = [self.slopes[j] for j in (0, i, i + 1, -1)] + [w / x for x, w in self.knots if x]
        inside = all(
            a <= min(x) and max(x) <= b for x, (a, b) in ((chords, family.sector), (self.slopes, family.slope))
        )
        return inside and (odd or not family.odd) and (not family.linear or min(self.slopes) == max(self.slopes))


def piecewise(points: Any, left: Any, right: Any) -> Graph:
    """The nonlinearity through points, (0, 0) among them, and its outer slopes."""
    form(isinstance(points, list) and all(isinstance(p, list) and len(p) == 2 for p in points), "points are pairs")
    knots = [(number(x), number(w)) for x, w in points]
    ascend = all(p[0] < q[0] for p, q in pairwise(knots))
    need(ascend and (ZERO, ZERO) in knots, "the points need ascending sigma, (0, 0) among them")
    return Graph(knots, [number(left), *((q[1] - p[1]) / (q[0] - p[0]) for p, q in pairwise(knots)), number(right)])


def known(phi: Any, family: Family) -> tuple[str, list[Fraction]]:
    """One nonlinearity, in the class: how that was found, and slopes of which all of its slopes are means."""
    if phi.get("kind") == "tanh":
        height, rate = (number(x) for x in fields(phi, "kind", "height", "rate")[1:])
        top = height * rate  # slopes and chords fill (0, top]
        inside = all(a <= 0 and top <= b for a, b in (family.sector, family.slope)) and not family.linear
        need(height > 0 and rate > 0 and inside, "the nonlinearity is not in the class")
        return f"{height} tanh({rate} sigma) has slopes and chords in (0, {top}] and is odd", [ZERO, top]
    kind, *given = fields(phi, "kind", "points", "left", "right")
    form(kind == "piecewise-linear", "a nonlinearity is piecewise-linear or tanh")
    found = piecewise(*given)
    need(found.member(family), "the nonlinearity is not in the class")
    return "piecewise linear through the given points: its slopes and chords lie within the bounds", found.slopes


def solvable(direct: Fraction, family: Family, slopes: list[Fraction]) -> dict[str, str]:
    """Whether ``y = sigma + H(inf) phi(sigma)`` determines ``sigma``, ``slopes`` being those of a given nonlinearity.

    ``1 + s H(inf)`` must have the sign it has at the lower bound of the sector for every slope ``s``; where that is
    assumed of the class, the sign is plus, as the assumption says.
    """
    if not direct:
        return {}
    need(keeps(direct, family, slopes), "1 + slope H(inf) changes its sign over the slopes of the nonlinearity")
    shown = keeps(direct, family, family.slope)
    need(shown or 1 + family.sector[0] * direct > 0, "sigma + H(inf) phi(sigma) does not increase for phi = l sigma")
    return {"solvable": "1 + slope H(inf) keeps its sign over the class" if shown else SOLVABLE}


def keeps(direct: Fraction, family: Family, slopes: Any) -> bool:
    """Whether ``1 + s H(inf)`` keeps the sign it has at the lower bound of the sector for slopes between bounds."""
    ends = (family.sector[0], *slopes)
    signs = [1 + s * direct for s in ends] if INF not in map(abs, ends) else [-1, 1]
    return bool(min(signs) > 0 or max(signs) < 0)


def assumed(name: str, direct: Fraction, family: Family) -> str:
    """What the theorem ``name`` assumes of phi beyond its class, so that the loop has solutions; empty if nothing."""
    if not direct or family.linear or keeps(direct, family, family.slope):
        return ""
    if name == "popov":
        return f"sigma + D phi(sigma), D = {direct}, is increasing with a locally Lipschitz inverse"
    return f"sigma + D phi(sigma) = y, D = {direct}, has exactly one solution sigma for every y"


def unit(rows: Any) -> int:
    """The common denominator, unless it may be too long to work with."""
    parts = {v.denominator for row in rows for v in row}
    need(sum(map(int.bit_length, parts)) < 200_000, "the denominators are too long")
    return math.lcm(*parts)


def deflated(A: Any, b: Any, c: Any, zero: object) -> tuple[Any, Any, Any, Fraction]:
    """``A, b, c`` in ``x_i - (x0_i/x0_p) x_p``, and ``rho`` of ``zeta' = rho mu`` for ``zeta = (c x0)(l x)/(l x0)``."""
    right, left, pivot = fields(zero, "right", "left", "pivot")
    x, y, p, _ = numbers(right), numbers(left), integer(pivot, 0, len(A) - 1), unit((*A, b, c))
    need(len(x) == len(y) == len(A) and unit((x, y)) > 0 and x[p] != 0 != dot(y, x), "no null vectors, or l x0 = 0")
    need(not any(dot(v, x) for v in A) and not any(dot(y, v) for v in zip(*A)), "A x0 = 0 or l A = 0 fails")
    gain, rest = dot(c, x) / dot(y, x), [i for i in range(len(A)) if i != p]
    need(gain * dot(y, b) > 0, "the residue at s = 0 is not positive")
    small = [[A[i][j] - x[i] / x[p] * A[p][j] if A[p][j] else A[i][j] for j in rest] for i in rest]
    return small, [b[i] - x[i] / x[p] * b[p] for i in rest], [c[i] - gain * y[i] for i in rest], gain * dot(y, b)


def symmetric(rows: Any, vectors: list[Any], order: int) -> tuple[list[list[int]], int, list[list[int]]]:
    """The matrix of a lower triangle of integers, and a whole number ``a`` with the integers ``a v``."""
    a = unit(vectors)
    sizes = isinstance(rows, list) and [isinstance(row, list) and len(row) for row in rows]
    form(sizes == list(range(1, order + 1)), f"P is no lower triangle of order {order}")
    half = [[number(v) for v in row] for row in rows]
    large = max((v.numerator.bit_length() for row in (*half, *vectors) for v in row), default=0) + a.bit_length()
    whole = all(v.denominator == 1 for row in half for v in row)
    need(whole and order * order * large < 10**9, "P: integers, not so long")
    P = [[half[max(i, j)][min(i, j)].numerator for j in range(order)] for i in range(order)]
    return P, a, [[v.numerator * (a // v.denominator) for v in vector] for vector in vectors]


def falling(P: Any, At: Any, a: int, discrete: bool) -> tuple[list[list[int]], list[list[int]]]:
    """``P A`` and the lower triangle of ``-(A'P + PA)``, in discrete time of ``P - A'PA``; ``At`` holds ``a A'``."""
    PA = [[dot(compress(row, v), filter(None, v)) for v in At] for row in P]
    if not discrete:
        return PA, [[-PA[i][j] - PA[j][i] for j in range(i + 1)] for i in range(len(P))]
    APA = [[dot(compress(w, v), filter(None, v)) for v in At[: i + 1]] for i, w in enumerate(zip(*PA))]
    return PA, [[a * a * v - w for v, w in zip(*lines)] for lines in zip(P, APA)]


def matrix_facts(A: Any, b: Any, c: Any, d: Any, width: Any, theta: Any, discrete: bool, proof: object) -> Any:
    """What ``P`` shows: ``A`` stable and ``1/width + Re[(1 + i omega theta) H] > 0``; ``width > 0``, None: no bound.

    ``V = x'Px + zeta^2/rho + 2 theta int phi`` falls, as ``2 phi (sigma - phi/width) >= 0``; discrete: ``V = x'Px``.
    """
    _, rows, exponent, zero = fields(proof, "method", "P", "exponent", "zero")
    need(not discrete or (zero is None and theta == 0), "in discrete time theta is 0 and zero is null")
    A, b, c, rho = (A, b, c, Fraction(0)) if zero is None else deflated(A, b, c, zero)
    n, e = len(A), integer(exponent, 0, 10**5)
    P, a, (*At, b, c) = symmetric(rows, [*zip(*A), b, c], n)  # P times 2^e; A, b, c times a
    need(positive_definite([row[: i + 1] for i, row in enumerate(P)]), "P > 0 fails, or is undecided")
    (PA, M), Pb = falling(P, At, a, discrete), [dot(row, b) for row in P]
    end = (0 if width is None else 2 / width) + 2 * theta * (Fraction(dot(b, c), a * a) + rho) + 2 * d
    if discrete:
        edge, end = [(a * v << e) - dot(b, w) for v, w in zip(c, zip(*PA))], end * (a * a << e) - dot(b, Pb)
    else:
        edge, end = [(v << e) - w + theta * Fraction(dot(c, u) << e, a) for u, v, w in zip(At, c, Pb)], end * (a << e)
    s = math.lcm(*(v.denominator for v in (*edge, end)))  # multiplies the last row and column
    need(positive_definite([*M, [int(s * v) for v in (*edge, s * end)]]), "the inequality of P fails, or is undecided")
    stable = f"P > 0, {'P - A^T P A > 0' if discrete else 'A^T P + P A < 0'} (order {n})"
    facts = {"stable": stable, "inequality": f"the matrix of order {n + 1} is positive definite: F > 0"}
    return facts if zero is None else facts | {"residue": f"rho = {rho} > 0, and the zero eigenvalue is simple"}


def matrix_gain(closed: Any, family: Family, proof: Any) -> dict[str, str]:
    """A gain ``g`` with a solution that grows: ``V = x'Px`` falls along every solution, and is negative at the start.

    ``V <= V(0) < 0`` keeps the solution away from 0, so that ``V``, a quadratic form, falls without end.
    ``closed`` gives the matrices of the loop with the linear gain.
    """
    _, gain, rows, start = fields(proof, "method", "gain", "P", "start")
    g, v = number(gain), numbers(start)
    need(all(low <= g <= high for low, high in (family.sector, family.slope)), "the gain is outside the class")
    A, *_, discrete = closed(g)
    P, a, At = symmetric(rows, [*zip(*A)], len(A))
    form(len(v) == len(A), f"the start is no list of {len(A)} numbers")
    need(dot(v, [dot(row, v) for row in P]) < 0, "V is not negative at the start")
    need(positive_definite(falling(P, At, a, discrete)[1]), "that V falls fails, or is undecided")
    falls = "V(x(t+1)) < V(x(t))" if discrete else "V' < 0"
    return {"growth": f"V = x^T P x, {falls} for x != 0 (order {len(A)}, g = {g}), and V < 0 at the start: it grows"}


def chords(phi: Graph) -> list[Fraction]:
    """Phi(sigma)/sigma is monotone between knots, and a slope next to 0 and far out."""
    i = [x for x, _ in phi.knots].index(ZERO)
    return [phi.slopes[j] for j in (0, i, i + 1, -1)] + [w / x for x, w in phi.knots if x]


def gained(A: Any, b: Any, f: Any) -> list[list[Fraction]]:
    """A - b f, for mu = -f x."""
    return [[x - v * y for x, y in zip(row, f)] for row, v in zip(A, b)]


def grows(steps: Any, squarings: int, bits: int) -> dict[str, str]:
    """Matrices ``G`` in turn, each for a time ``t`` (None: one step): the period's ``M`` has ``|trace M^N| > n``.

    Or going linearly to a third one in that time.
    """
    n, known = len(steps[0][0]), dict[Any, Ball]()
    M = ball(identity(n), bits)
    for G, t, *last in steps:
        key = id(G), t, *map(id, last)
        if key not in known:
            known[key] = ball(G, bits) if t is None else ramp(G, last[0], t, bits) if last else exponential(G, t, bits)
        M = product(known[key], M)
    for _ in range(squarings):
        M = product(M, M)
    trace = abs(sum(row[i] for i, row in enumerate(M.rows))) - n * M.error
    need(trace > n << bits, "the trace does not show growth")
    return {"growth": f"|trace M^(2^{squarings})| > {n} for the period of {len(steps)} gains, so some motion grows"}


def orbit(system: Any, family: Family, proof: Any, critical: bool, rate: Fraction | None = None) -> dict[str, str]:
    """An orbit in discrete time, exactly: ``sum d_j sigma[t-j] = sum n_j u[t-j]`` and ``u = -phi(sigma)``.

    With a rate one that is ``s`` times as large after its samples, see :func:`scaled`.
    """
    if rate is not None:
        return scaled(system, family, proof, rate)
    points, left, right, u, sigma = fields(proof, "method", "points", "left", "right", "u", "sigma")[1:]
    phi, u = piecewise(points, left, right), numbers(u)
    n, d, sigma = numbers(system["numerator"]), numbers(system["denominator"]), numbers(sigma, len(u))
    n, p = [ZERO] * (len(d) - len(n)) + n, len(u)
    need(phi.member(family), "the nonlinearity is not in the class")
    direct = [1 + g * n[0] / d[0] for g in (chords(phi) if family.slope == (-INF, INF) else phi.slopes)]
    need(min(direct) > 0 or max(direct) < 0, "1 + g H(inf) does not keep its sign over the nonlinearity", IllPosed)
    for t in range(p):
        tick()
        need(phi.at(sigma[t]) == -u[t], f"sample {t} is not on the nonlinearity")
        rest = sum(d[j] * sigma[(t - j) % p] - n[j] * u[(t - j) % p] for j in range(len(d)))
        need(rest == 0, f"sample {t} does not satisfy the difference equation")
    moves = len(set(sigma)) > 1
    need(any(u) and (moves or not critical), "u vanishes, or it is an equilibrium in the critical case")
    return {"orbit": f"a motion that repeats after {p} samples" if moves else "an equilibrium other than 0"}


def scaled(system: Any, family: Family, proof: Any, rate: Fraction) -> dict[str, str]:
    """``sigma[t+p] = s sigma[t]`` and ``u`` likewise, ``phi(s sigma) = s phi(sigma)``: linear between all these points.

    On each side of 0 they are those of one interval ``[m, m/|s|)`` times powers of ``|s|`` (``s < 0``, or an odd
    ``phi``: of both sides, mirrored); where a side has none ``phi`` is linear there, of the class.
    """
    _, given, u, sigma = fields(proof, "method", "scale", "u", "sigma")
    s, u, n, d = number(given), numbers(u), numbers(system["numerator"]), numbers(system["denominator"])
    n, p, sigma = [ZERO] * (len(d) - len(n)) + n, len(u), numbers(sigma, len(u))
    lasts = 0 < p <= 1000 and 0 < abs(s) != 1 and rate > 0 and rate**p <= abs(s)
    need(lasts, "it becomes smaller at that rate, or does not at all")
    need(any(sigma) and not (family.linear or n[0]), "it rests, or phi is linear, or H(inf) is not 0")
    for t in range(p):
        tick()
        late = [(j, (t - j) % p, s ** ((t - j) // p)) for j in range(len(d))]
        rest = sum((d[j] * sigma[i] - n[j] * u[i]) * power for j, i, power in late)
        need(rest == 0, f"sample {t} does not satisfy the difference equation")
    sides, step = dict[bool, list[tuple[Fraction, Fraction]]](), min(abs(s), 1 / abs(s))
    for x, v in zip(sigma, u):
        need(x != 0 or v == 0, "phi(0) is not 0")
        points, x, w = sides.setdefault(x > 0 or s < 0 or family.odd, []), abs(x), -v if x > 0 else v
        while x and not (m := points[0][0] if points else x) <= x < m / step:
            tick()
            x, w = (x / step, w / step) if x < m else (x * step, w * step)
        points += [(x, w)] if x else []
    for points in map(sorted, sides.values()):
        for (x, w), (y, v) in pairwise([*points, *((x / step, w / step) for x, w in points[:1])]):
            need(family.sector[0] <= w / x <= family.sector[1], "phi is not in the sector")
            chord = x != y and family.slope[0] <= (v - w) / (y - x) <= family.slope[1]
            need(chord or (x, w) == (y, v), "phi is not in the class")
    return {"orbit": f"a motion that is {s} times as large after {p} samples"}


def flow_orbit(realised: Any, family: Family, proof: Any) -> dict[str, str]:
    """An orbit over the pieces of phi, near the given one."""
    points, left, right, pieces, *rest = fields(proof, *FLOW_ORBIT.split())[1:]
    (A, b, c, d), phi, n = realised, piecewise(points, left, right), len(realised[1])
    X0, times, half, Y, r = orbit_numbers(rest, pieces, n)
    need(
        phi.member(family._replace(odd=family.odd or half)),
        "the nonlinearity is not in the class, or half needs an odd one",
    )
    need(all(1 + d * k > 0 for k in phi.slopes), "1 + slope H(inf) > 0 is needed on every piece")
    kinks, sign, e = phi.lines[1:], -1 if half else 1, X0[-1]
    levels = [-INF, *(x + d * w for x, w, _ in kinks), INF]  # of y = c x = sigma + d phi, which tells the pieces
    path = [integer(p, 0, len(kinks)) for p in pieces] + [len(kinks) - pieces[0] if half else pieces[0]]
    need(all(abs(p - q) == 1 for p, q in pairwise(path)), "the pieces do not follow one another")
    entries = [sign * levels[max(path[-2:])], *(levels[max(p, q)] for p, q in pairwise(pieces))]
    forces = [[k * v / (1 + d * k) for v in c] + [(w - k * x) / (1 + d * k) / e] for x, w, k in phi.lines]  # phi = f X
    closed = [[*gained([[*row, ZERO] for row in A], b, f), [ZERO] * (n + 1)] for f in forces]
    stays = [
        Stay(closed[p], [*c, -level / e], [([*c, ZERO], levels[p : p + 2], True, True)])
        for p, level in zip(pieces, entries)
    ]
    return periodic(stays, (X0, times), Y, r, sign)


class Stay(NamedTuple):
    """``X' = G X``, ``entry X = 0`` at the start; of each row between which sides ``row X`` lies.

    And whether it is on one of them at the start, and at the end.
    """

    G: Any
    entry: Any
    watched: list[tuple[Any, Any, bool, bool]]


def orbit_numbers(data: Any, pieces: Any, n: int) -> tuple[Any, Any, bool, Ball, Fraction]:
    """First state with ``e``, durations, whether they make half a period, the inverse and the radius.

    ``e`` is any number > 0; it is of about the size of the state.
    """
    durations, state, half, inverse, radius, bits = data
    form(isinstance(pieces, list) and type(half) is bool and isinstance(inverse, list), "pieces or half is missing")
    x0, times, r = numbers(state, n), numbers(durations, len(pieces)), number(radius)
    form(len(inverse) == n + len(times) <= 400, "the inverse is square, of order up to 400")
    Y = ball([numbers(row, n + len(times)) for row in inverse], integer(bits, 64, 4096))
    return [*x0, Fraction(2 ** int(max(map(abs, x0))).bit_length())], times, half, Y, r


def periodic(stays: list[Stay], start: Any, Y: Ball, r: Fraction, sign: int) -> dict[str, str]:
    """An orbit ``X' = G_i X``, ``X = (x, e)``, over stays, near given first state and durations, by a contraction.

    They, ``z``, solve ``F(z) = (x_m - sign x_0, entry_i X_(i-1)) = 0``.  Let ``|Y F| <= Y0`` at the
    given ``z`` and ``|1 - Y F'| <= Z1 < 1`` within ``r`` of it (maximum norm), ``Y0 + Z1 r < r``: then ``z - Y F(z)``
    maps that ball into itself and contracts, ``Y`` is regular and the fixed point a zero.  Balls of radius 0 and ``r``
    go through the pieces; ``|exp(G (t + q)) - exp(G t)| <= 2 |G q| |exp(G t)|`` if ``|G q| <= 1``.
    """
    (X0, times), bits, bounds = start, Y.bits, list[list[int]]()
    n, starts = len(X0) - 1, list[Ball]()
    need(
        all(0 < 4 * r < t and r * size(one.G) <= 1 for one, t in zip(stays, times)),
        "the radius must be positive and small",
    )
    unit = [*identity(n, n + len(times)), [ZERO] * (n + len(times))]
    for q in (ZERO, r):
        first = ball([[v, *row] for v, row in zip(X0, unit)], bits)
        Z = first = first._replace(error=first.error + int(q * 2**bits) + 1)  # [X_i, X_i']
        starts, rows = [], list[Ball]()
        for j, ((G, entry, _), t) in enumerate(zip(stays, times), n + 1):
            starts, rows = [*starts, Z], [*rows, product(ball([entry], bits), Z)]
            E = exponential(G, t, bits)
            Z = product(E._replace(error=E.error + int(2 * size(G) * q * norm(E)) + 1), Z)
            push = product(ball(G, bits), Z)
            for row, (v, *_) in zip(Z.rows, push.rows):
                row[j] += v
            Z = Z._replace(error=Z.error + push.error)
        closing = plus(Z, first, -sign)
        F = Ball(closing.rows[:n] + [X.rows[0] for X in rows], max(X.error for X in [closing, *rows]), bits)
        P = product(Y, F)  # [Y F, Y F']
        for i, row in enumerate(P.rows):
            row[i + 1] -= 2**bits
        bounds.append([max(sum(map(abs, row[s])) for row in P.rows) + P.error for s in (slice(1), slice(1, None))])
    need(bounds[0][0] + bounds[1][1] * r < r * 2**bits, "no contraction near the given orbit")
    for one, t, X in zip(stays, times, starts):
        X = X._replace(rows=[row[:1] for row in X.rows])
        for seen in one.watched:
            need(inside(one.G, X, (t, r), seen), "y is not shown to stay on a piece")
    return {
        "orbit": f"a periodic motion; {len(times)} switches of the piece make {'half a' if sign < 0 else 'a'} period"
    }


def inside(G: Any, X: Ball, stay: Any, seen: Any) -> bool:
    """Whether ``y = row exp(G s) X`` is between the sides for ``0 < s < t'``, ``|t' - t| <= r``.

    It is known whether it is on one of them at the start and at the end.
    On a step ``y(h q) = sum a_j q^j``, ``0 <= q <= 1``, ``a_j = row (G h)^j/j! X``.  The terms from ``m`` on add up to
    at most ``2 |row (G h)^m/m!| |X|``, as ``|exp(G s)| <= 2``, and those of ``y'`` to ``m`` times that.  Steps are
    halved.
    """
    (t, r), (seen_by, sides, starts, ends), steps, pending = stay, seen, dict[int, Any](), [(0, 0, X)]
    low, high = (side if abs(side) == INF else side * 2**X.bits for side in sides)
    while pending:
        k, i, X = pending.pop()  # the i-th of 2^k steps
        if k not in steps:
            h, rows = Fraction(math.ceil((t / 2**k + r) * 2**96), 2**96), [seen_by]
            fine = bool(2 * size(G) * h <= 1 and r < t / 2**k)
            for j in range(1, TERMS + 1 if fine else 1):
                rows.append([h / j * dot(rows[-1], column) for column in zip(*G)])
            steps[k] = fine, ball(rows[:TERMS], X.bits), int(2 * TERMS * size(rows[-1:]) * 2**64) + 1
            steps[k] += (exponential(G, t / 2 ** (k + 1), X.bits),)
        fine, R, rest, half = steps[k]
        if fine:
            P = product(R, X)
            (y, v, *more), e = [row[0] for row in P.rows], P.error
            turn = sum(j * (abs(a) + e) for j, a in enumerate(more, 2)) + (rest * norm(X) >> 64) + 1
            rises, falls = v - e > turn, v + e < -turn  # |y'(q) - v| <= turn, 2 |y(q) - y - v q| <= turn
            first, last = starts and i == 0, ends and i == 2**k - 1
            above = y - e + min(0, v - e) - turn > low or (first and rises) or (last and falls)
            below = y + e + max(0, v + e) + turn < high or (first and falls) or (last and rises)
            if above and below:
                continue
        if k == DEEPEST:
            return False
        pending += [(k + 1, 2 * i, X), (k + 1, 2 * i + 1, product(half, X))]
    return True


def order_cones(samples: int, odd: bool) -> Iterator[list[list[int]]]:
    """The steps that span ``(phi(sigma_i))_i`` for each ordering of ``sigma_i`` and 0; odd: of ``s_i sigma_i >= 0``.

    Orderings in reverse, or with all signs turned, give the same forms and are left out.
    """
    if odd:
        for order in permutations(range(samples)):
            for signs in signings((1, -1), repeat=samples - 1):
                s = (1, *signs)
                yield [[s[i] * (i in order[cut:]) for i in range(samples)] for cut in range(samples)]
        return
    for order in permutations(range(samples + 1)):  # the last stands for 0
        zero, cuts = order.index(samples), range(1, samples + 1)
        if order[0] < order[-1]:
            above = [(order[cut:], 1) if cut > zero else (order[:cut], -1) for cut in cuts]
            yield [[sign * (i in side) for i in range(samples)] for side, sign in above]


def window(data: Any, unbounded: bool) -> tuple[list[list[Fraction]], bool]:
    """The form of up to 4 samples, a lower triangle of numbers, positive on their order cones; if for odd ones only."""
    _, rows, odd = fields(data, "taps", "window", "odd")
    form(isinstance(rows, list) and len(rows) in (0, 2, 4, 6, 8) and type(odd) is bool, "a window has 1 to 4 samples")
    need(not unbounded, "forms of several samples need a bound on the slope")
    half = [numbers(row, i) for i, row in enumerate(rows, 1)]
    M = [[half[max(i, j)][min(i, j)] for j in range(len(half))] for i in range(len(half))]
    need(not M or order_positive(M, odd), "w'M w > 0 fails on an order cone, or is undecided")
    return M, odd


def order_positive(M: Any, odd: bool) -> bool:
    """Whether ``w'M w > 0`` for ``w = (u, v) != 0`` with ``u`` and ``v`` in one order cone.

    Then it is so for samples ``u = phi``, ``v = k sigma - phi`` of every ``phi`` with ``phi(0) = 0`` and slopes in
    ``[0, k]``: from one ``sigma`` to the next both ascend.
    """
    p, a = len(M) // 2, unit(M)
    M = [[v.numerator * (a // v.denominator) for v in row] for row in M]
    for steps in order_cones(p, odd):
        tick()
        rays = [[(h, s) for h, s in enumerate(step, base) if s] for base in (0, p) for step in steps]
        C = [[sum(a * b * M[i][j] for i, a in x for j, b in y) for y in rays] for x in rays]
        if not copositive(C):
            return False
    return True


def copositive(C: Any) -> bool:
    """Whether ``x'C x > 0`` for all ``x >= 0`` but 0; False also where a submatrix that counts is singular.

    Else the least value ``m <= 0`` on ``sum x = 1`` is attained with ``x > 0`` on some face, where ``B x = m (1, ..,
    1)`` for the principal submatrix ``B``: each of its rows holds a negative entry, and ``B^-1 (1, .., 1) = x/m < 0``
    if it is regular.
    """
    if min(C[i][i] for i in range(len(C))) <= 0:
        return False
    for count in range(2, len(C) + 1):
        for face in combinations(range(len(C)), count):
            B = [[C[i][j] for j in face] for i in face]
            if all(min(row) < 0 for row in B):
                solved = eliminated(B, [[Fraction(1)]] * count)
                if solved is None or max(row[0] for row in solved) < 0:
                    return False
    return True
