"""Regions of attraction: sets from which every solution tends to 0, or none does; part of the checker.

Standard library only.  Every function raises ``Rejected`` unless what it is asked to show is shown.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise
from typing import Any, NamedTuple

from . import arithmetic as exact
from . import states
from .arithmetic import INF, ZERO, extended, fields, form, integer, need, number, numbers, real
from .balls import dot, positive_definite
from .channels import Plant, Rows, closed_loop, moved, plant, seen, semidefinite, triangle

ATTRACTS = "0 attracts every motion"
INSIDE = "every motion that starts in {x : x^T P x <= 1} tends to 0, P as in the proof"
LEVEL = (
    "every motion that starts in {x : x^T P x + 2 sum theta_i int_0^sigma_i phi_i <= 1, |sigma_i| <= reach_i} tends to "
    "0, P, theta and reach as in the proof"
)
DISTURBED = (
    "from rest every motion with a disturbance w of energy at most {}, x' = A x + B mu + Bw w (or x+), stays in {{x : "
    "x^T P x <= 1}} and tends to 0, P and Bw as in the proof"
)
PUSHED = DISTURBED.replace("(or x+)", "(or x+), sigma = C x + D mu + Dsigmaw w").replace("Bw as", "Bw, Dsigmaw as")
BETWEEN = "every motion that starts between {} and {} tends to 0"
BEYOND = "no motion that starts in {{x : x^T Q x > 1}} tends to 0, Q as in the proof"
OUTSIDE = "no motion that starts at or beyond {} or {} tends to 0"
WITHIN = "every motion that starts within the first turn of the spiral, closed along its ray, tends to 0"
AROUND = "no motion that starts on or outside the closed curve of the proof tends to 0"
ORBIT = ", and within it there is a periodic motion"
Point = tuple[Fraction, Fraction]
Arc = tuple[Point, Point | None, Point]  # a straight edge, or (1-t)^2 p + 2t(1-t) c + t^2 q


class Graph(NamedTuple):
    """A nonlinearity with ``phi(0) = 0``: polynomials between cuts, or with a sector for ``|sigma| <= reach``."""

    cuts: list[Any]
    pieces: list[list[Fraction]]  # ascending coefficients, one more than cuts
    sector: tuple[Any, Any] = (-INF, INF)
    reach: Any = INF

    def between(self, low: Any, high: Any) -> list[tuple[Any, Any, list[Fraction]]]:
        """Its pieces within an interval, with their ends."""
        ends = [-INF, *self.cuts, INF]
        parts = [(max(a, low), min(b, high), p) for (a, b), p in zip(pairwise(ends), self.pieces)]
        return [(a, b, p) for a, b, p in parts if a < b]

    def within(self, l: Any, u: Any, reach: Fraction) -> bool:
        """Whether ``l <= phi(sigma)/sigma <= u`` for ``0 < |sigma| <= reach``."""
        if self.reach != INF:
            return bool(reach <= self.reach and l <= self.sector[0] and self.sector[1] <= u)
        sides = [(a, b, p, sign) for sign in (-1, 1) for a, b, p in self.between(*sorted((ZERO, sign * reach)))]
        return all(
            never_negative(more(p, [ZERO, -l], sign), a, b) and never_negative(more([ZERO, u], p, sign, -1), a, b)
            for a, b, p, sign in sides
        )

    def bounded(self, least: Fraction, reach: Fraction, sign: int) -> bool:
        """Whether ``sign (2 int_0^sigma phi - least sigma^2) >= 0`` for ``|sigma| <= reach``."""
        for side in (-1, 1):
            total = ZERO  # the integral up to the end of the piece that is nearer to 0
            for a, b, p in self.between(*sorted((ZERO, side * reach)))[::side]:
                q = [ZERO, *(c / (k + 1) for k, c in enumerate(p))]
                near, far = (a, b)[::side]
                q[0] = total - exact.value(q, near)
                total = exact.value(q, far)
                if not never_negative(more([2 * c for c in q], [ZERO, ZERO, -least], sign), a, b):
                    return False
        return True

    def limited(self) -> bool:
        """Whether it is a line ``e sigma`` and another one between limits on both sides."""
        if len(self.pieces) != 3 or max(map(len, self.pieces)) > 2 or not self.cuts[0] < 0 < self.cuts[1]:
            return False
        (c, e), _, (d, f) = ([*p, ZERO][:2] for p in self.pieces)
        return e == f and c * d < 0

    def clip(self) -> tuple[Fraction, Fraction, Fraction, Fraction]:
        """``e, u, a, b`` with ``phi = e sigma + p``, ``p = (u - e) sigma`` limited to ``[-a, b]``."""
        need(self.limited(), "the nonlinearity is no line with limits on both sides")
        (c, e), (_, u), (d, _) = ([*p, ZERO][:2] for p in self.pieces)
        return e, u, -min(c, d), max(c, d)


def graph(data: Any) -> Graph:
    """The nonlinearity of one channel; ``signed``: any of a class, known nowhere by itself, and so of reach 0."""
    if isinstance(data, dict) and data.get("kind") == "signed":
        top = number(fields(data, "kind", "top")[1])
        form(top > 0, "a slope is not positive")
        return Graph([], [], (ZERO, top), ZERO)
    if isinstance(data, dict) and data.get("kind") == "sector":
        _, pair, reach = fields(data, "kind", "sector", "reach")
        form(isinstance(pair, list) and len(pair) == 2, "a sector is a pair of bounds")
        l, u, c = number(pair[0]), number(pair[1]), number(reach)
        form(l <= u and c > 0, "a sector has bounds in order, and a reach > 0")
        return Graph([], [], (l, u), c)
    kind, cuts, pieces = fields(data, "kind", "cuts", "pieces")
    form(kind == "piecewise-polynomial" and isinstance(cuts, list) and isinstance(pieces, list), "no nonlinearity")
    found = Graph([number(x) for x in cuts], [numbers(p) for p in pieces])
    ordered = all(a < b for a, b in pairwise(found.cuts)) and len(found.pieces) == len(found.cuts) + 1
    form(ordered and max(map(len, found.pieces)) <= 40, "cuts ascend, with one polynomial more than cuts")
    joins = zip(found.cuts, pairwise(found.pieces))
    need(all(exact.value(p, x) == exact.value(q, x) for x, (p, q) in joins), "the nonlinearity jumps")
    at_zero = [p for p, a, b in zip(found.pieces, [-INF, *found.cuts], [*found.cuts, INF]) if a <= 0 <= b]
    need(exact.value(at_zero[0], ZERO) == 0, "phi(0) is not 0")
    return found


def more(p: list[Fraction], q: list[Fraction], sign: int = 1, other: int = 1) -> list[Fraction]:
    """``sign (p + other q)``."""
    return (real(sign) * (real(*p) + real(other) * real(*q))).part()


def never_negative(p: list[Fraction], low: Any, high: Any, strictly: bool = False) -> bool:
    """Whether ``p >= 0`` on an interval, ``> 0`` inside unless ``p = 0`` (strictly: which is then refused)."""
    for end, side in ((low, 1), (high, -1)):
        while p and abs(end) != INF and exact.value(p, end) == 0:  # p = side (x - end) q
            quotient, carry = list[Fraction](), ZERO
            for c in reversed(p):
                carry = carry * end + c
                quotient.insert(0, carry)
            p = [side * c for c in quotient[1:]]
    if not p:
        return not strictly
    if low == -INF:
        return never_negative([c * (-1) ** i for i, c in enumerate(p)], -high, INF, strictly)
    return exact.positive(p, low, None if high == INF else high)


def described(graphs: list[Graph]) -> str:
    """The nonlinearities in words."""
    words = list[str]()
    for i, one in enumerate(graphs, 1):
        if one.reach == ZERO:
            said = f"all locally Lipschitz phi, 0 < phi(sigma)/sigma <= {one.sector[1]}, int phi -> inf on both sides"
        elif one.reach != INF:
            (l, u), c = one.sector, one.reach
            said = f"all locally Lipschitz phi(t, sigma) in the sector [{l}, {u}] for |sigma| <= {c}"
        else:
            parts = "; ".join(" ".join(map(str, p)) for p in one.pieces)
            said = f"phi polynomials in sigma, ascending: {parts}; cuts {' '.join(map(str, one.cuts)) or '-'}"
        words.append(f"channel {i}: {said}")
    return "; ".join(words)


def examined(verdict: str, name: str, data: Any, system: Any, given: Any, phi: Any, proof: Any) -> Any:
    """Whether a set lies inside the region, the sentence, and how every hypothesis was found to hold."""
    H = plant(system)
    (listed,) = fields(given, "graphs")
    form(isinstance(listed, list) and len(listed) == len(H.D), "one nonlinearity for each channel is needed")
    graphs = [graph(one) for one in listed]
    need(phi is None, "no nonlinearity is given beside several")
    acyclic(H.D)
    facts, inner = {"class": described(graphs)}, verdict == "PROVED"
    if proof["method"] == "signs":
        need(name == ("scalar" if inner else "counterexample") and data == {}, "signs are about one state")
        sentence, found = by_signs(H, graphs, inner, proof)
    elif proof["method"] in ("spiral", "curve"):
        need((name, data == {}) == (("planar", False) if inner else ("counterexample", True)), "a curve is planar")
        around = AROUND + ORBIT * ("orbit" in proof)
        sentence, found = (WITHIN, spiral(H, graphs, data, proof)) if inner else (around, curve(H, graphs, proof))
    elif name == "global-popov":
        need(inner, "what attracts everything is a proof")
        sentence, found = ATTRACTS, everywhere(H, graphs, data, proof)
    elif inner:
        need(name in ("local-circle", "local-popov"), f"there is no theorem {name!r:.40} for regions")
        level = name == "local-popov"
        energy, moves = proof.get("energy"), PUSHED if "Dsigmaw" in proof else DISTURBED
        sentence = LEVEL if level else INSIDE if energy is None else moves.format(energy)
        found = ellipsoid(H, graphs, data, proof, level)
    else:
        need((name, data) == ("counterexample", {}), "starts that never come to 0 are a counterexample")
        sentence, found = BEYOND.format(), beyond(H, graphs, proof)
    return inner, sentence, facts | found


def acyclic(D: Rows) -> None:
    """The channels can be taken one after the other."""
    left = set(range(len(D)))
    while free := {i for i in left if not any(D[i][j] for j in left)}:
        left -= free
    need(not left, "D has a cycle: sigma is not given channel after channel")


def definite(rows: Rows, reason: str) -> None:
    """A symmetric matrix, of which the lower triangle is looked at, is positive definite."""
    lower = [row[: i + 1] for i, row in enumerate(rows)]
    q = states.unit(lower)
    need(positive_definite([[int(q * v) for v in row] for row in lower]), reason)


def quadratic(*terms: tuple[Any, Any, Any]) -> Rows:
    """The matrix of ``sum w (f z)(g z)`` for terms ``w, f, g``."""
    found = [[ZERO] * len(terms[0][1]) for _ in terms[0][1]]
    for w, f, g in terms:
        places = [k for k, pair in enumerate(zip(f, g)) if any(pair)]
        for i in places:
            for j in places:
                found[i][j] += w * (f[i] * g[j] + g[i] * f[j]) / 2
    return found


def added(*parts: tuple[int, Rows]) -> Rows:
    """A sum of matrices with their signs."""
    size = len(parts[0][1])
    return [[sum((s * M[i][j] for s, M in parts), ZERO) for j in range(size)] for i in range(size)]


def growth(P: Rows, H: Plant, factor: Fraction = ZERO) -> Rows:
    """``V' - factor V`` of ``V = x'P x``, in discrete time ``V+ - (1 + factor) V``, as a form in ``(x, phi)``."""
    n, F = len(P), moved(H)
    size = len(F[0])
    PF = [[dot(row, column) for column in zip(*F)] for row in P]
    V = [[P[i][j] if i < n and j < n else ZERO for j in range(size)] for i in range(size)]
    if H.discrete:
        moves = [[dot(f, column) for column in zip(*PF)] for f in zip(*F)]
        return added((1, moves), (-1, [[(1 + factor) * v for v in row] for row in V]))
    half = [PF[i] if i < n else [ZERO] * size for i in range(size)]
    return added((1, half), (1, [list(row) for row in zip(*half)]), (-1, [[factor * v for v in row] for row in V]))


def integrated(H: Plant, graphs: list[Graph], given: Any, P: Rows) -> tuple[Rows, list[Any], list[Any]]:
    """The form below ``x'P x`` with integrals, what these add to ``V'``, and the strips where they are bounded."""
    n, m = len(H.A), len(H.D)
    below, products, strips = [list(row) for row in P], list[Any](), list[Any]()
    for one in given:
        where, *values = fields(one, "channel", "theta", "reach", "least")
        i, (theta, reach, least) = integer(where, 1, m) - 1, map(number, values)
        fits = not H.discrete and not any(H.D[i]) and graphs[i].reach == INF and reach > 0
        need(fits, f"an integral does not fit channel {i + 1}")
        bounded = graphs[i].bounded(least, reach, 1 if theta >= 0 else -1)
        need(bounded, f"the integral of channel {i + 1} is not bounded")
        below = [[v + theta * least * a * b for v, b in zip(row, H.C[i])] for row, a in zip(below, H.C[i])]
        strips.append((H.C[i], reach))
        phi = [Fraction(j == n + i) for j in range(n + m)]
        products.append((2 * theta, phi, [dot(H.C[i], column) for column in zip(*moved(H))]))
    return below, products, strips


def disturbed(H: Plant, energy: Any, *given: Any) -> tuple[Plant, Rows]:
    """``x' = .. + Bw w`` with ``w`` behind the inputs of the plant, and ``Dsigmaw``, by default 0."""
    into, *sides = ([numbers(row) for row in side] if isinstance(side, list) else [] for side in given)
    p = len(into[0]) if into else 0
    pushed = sides[0] if sides else [[ZERO] * p for _ in H.D]
    form((len(into), len(pushed)) == (len(H.A), len(H.D)), "Bw has a row for each state, Dsigmaw for each channel")
    fits = p > 0 and all(len(row) == p for row in (*into, *pushed)) and number(energy) > 0
    form(fits, "a row, or the energy, is none")
    return H._replace(B=[[*b, *(-v for v in row)] for b, row in zip(H.B, into)]), pushed


def ellipsoid(H: Plant, graphs: list[Graph], data: Any, proof: Any, level: bool) -> dict[str, str]:
    """``V = x'P x`` falls on ``V <= 1``, where every term ``weight (u sigma - phi)(phi - v) >= 0``.

    Or, in continuous time, ``V = x'P x + 2 sum theta_i int_0^sigma_i phi_i`` where also ``|sigma_i| <= reach_i``: there
    ``V`` is at least the form with ``2 int phi_i`` replaced by ``least_i sigma_i^2``, which takes the place of ``P`` in
    what follows; the strips of ``|sigma_i| <= reach_i`` are left by no solution, as they touch ``V <= 1`` nowhere.
    Either ``v = l sigma`` and ``|sigma| <= reach`` there; or ``phi = e sigma + p``, ``p`` limited to ``[-a, b]``, and
    ``v = e sigma + h x`` with ``|h x| <= min(a, b)`` there: ``p`` is the point of the interval nearest to
    ``(u - e) sigma``, and ``h x`` another of its points.  As ``|r x| <= c`` on the ellipsoid if ``r P^-1 r' <= c^2``.
    """
    own = ["energy", "Bw", *["Dsigmaw"] * ("Dsigmaw" in proof)] if "energy" in proof else []
    _, rows, *given = fields(proof, "method", "P", *(["integrals"] if level else own))
    form(proof["method"] == ("level-set" if level else "ellipsoid"), "a region is proved by the level set of a form")
    (terms,) = fields(data, "terms")
    form(isinstance(terms, list) and len(terms) <= 400, "terms are a list")
    n, m, P = len(H.A), len(H.D), triangle(rows, len(H.A))
    below, products, asked = integrated(H, graphs, given[0] if level else (), P)
    H, pushed = disturbed(H, *given) if given and not level else (H, list[Any]([[]] * m))
    p, Y = len(pushed[0]), [[*y, *w] for y, w in zip(seen(H), pushed)]
    Z = [[Fraction(j == k) for j in range(n + m + p)] for k in range(n, n + m + p)]
    definite(below, "P > 0 fails, or is undecided")
    most, reaches = list[Any]([INF] * m), list[Any]([INF] * m)  # bounds of |phi| and |sigma| on the ellipsoid
    for i, one in enumerate(graphs):
        if one.limited() and one.clip()[0] == 0:
            most[i] = max(one.clip()[2:])
    for term in terms:
        form(isinstance(term, dict), "a term is an object")
        local = "sector" in term
        where, weight, *own = fields(term, "channel", "weight", *(("sector", "reach") if local else ("row",)))
        i, w = integer(where, 1, m) - 1, number(weight)
        need(w >= 0, "a weight is negative")
        if local:
            form(isinstance(own[0], list) and len(own[0]) == 2, "a sector is a pair of bounds")
            l, u, c = number(own[0][0]), number(own[0][1]), number(own[1])
            held = c > 0 and not any(pushed[i]) and graphs[i].within(l, u, c)
            need(held, f"the nonlinearity of channel {i + 1} leaves its sector, or w its interval")
            reaches[i], most[i] = min(reaches[i], c), min(most[i], max(abs(l), abs(u)) * c)
            v = [l * y for y in Y[i]]
        else:
            e, u, a, b = graphs[i].clip()
            h = numbers(own[0], n)
            asked.append((h, min(a, b)))
            v = [e * y + x for y, x in zip(Y[i], [*h, *[ZERO] * (m + p)])]
        f, g = [u * y - z for y, z in zip(Y[i], Z[i])], [z - x for z, x in zip(Z[i], v)]
        products.append((2 * w, f, g))
    for i, one in enumerate(graphs):
        need(one.reach == INF or reaches[i] <= one.reach, f"channel {i + 1} is known on an interval alone")
        if reaches[i] != INF:
            need(all(most[j] != INF for j in range(m) if H.D[i][j]), f"sigma of channel {i + 1} is not bounded")
            rest = reaches[i] - sum((abs(d) * most[j] for j, d in enumerate(H.D[i]) if d), ZERO)
            need(rest > 0, f"sigma of channel {i + 1} is not bounded by its reach")
            asked.append((H.C[i], rest))
    for r, c in asked:
        definite(
            [*([*row, x] for row, x in zip(below, r)), [*r, c * c]], "the ellipsoid leaves a strip, or is undecided"
        )
    products += [(-1 / number(given[0]), unit, unit) for unit in Z[m:]]
    parts = [(-1, growth(P, H)), *([(-1, quadratic(*products))] if products else [])]
    definite(added(*parts), "that V falls fails, or is undecided")
    words = "V = x^T P x with integrals" if level else "V = x^T P x"
    return {
        "decrease": f"{words} falls where the {len(terms)} terms are not negative (order {n + m})",
        "terms": f"they are not negative on the set: it lies in {len(asked)} strips",
    }


def everywhere(H: Plant, graphs: list[Graph], data: Any, proof: Any) -> dict[str, str]:
    """``V = x'P x + 2 sum theta_i int_0^sigma_i phi_i >= 0`` falls along every solution but 0.

    ``V' = -sum 2 lambda_i phi_i (sigma_i - inverse_i phi_i) - sum least_i phi_i^2 - M(x, phi)``, ``M >= 0``, ``sigma
    phi >= inverse phi^2``.  ``phi`` has the sign of ``sigma`` and ends in polynomials: ``int phi``, and with it ``V``
    if ``P + sum C_i'C_i > 0`` over ``theta_i > 0``, goes to infinity.  Where ``V`` stays the same ``M (x, phi) = 0``,
    and ``phi_i = 0`` if ``least_i`` or ``lambda_i > 0 = inverse_i``; ``phi = 0`` and ``x = 0`` follow (LaSalle).
    """
    _, rows, squares = fields(proof, "method", "P", "least")
    n, m, least = len(H.A), len(H.D), numbers(squares, len(H.D))
    form(proof["method"] == "everywhere" and not H.discrete, "a function that falls everywhere is of continuous time")
    weights, theta, inverse = (numbers(one, m) for one in fields(data, "lambda", "theta", "inverse"))
    P, Y, flow = triangle(rows, n), seen(H), [*zip(*moved(H))]
    need(min(*weights, *theta, *inverse, *least) >= 0, "a weight is negative")
    products, units, above = list[Any](), list[Any](), [list(row) for row in P]
    for i, one in enumerate(graphs):
        top = one.sector[1] if one.reach == ZERO else ZERO
        fits = one.reach in (INF, ZERO) and inverse[i] * top <= 1 and not (theta[i] and any(H.D[i]))
        need(fits, f"channel {i + 1} is not known, steeper, or has no integral")
        crosses = [x for x, p in zip(one.cuts, one.pieces) if x and exact.value(p, x) == 0]
        for side, ends in ((-1, (-INF, ZERO)), (1, (ZERO, INF))):
            for a, b, p in one.between(*ends):
                own = never_negative(more(p, [], side), a, b, True)
                need(own and not crosses, f"phi of channel {i + 1} has another sign than sigma, or another zero")
                scaled = [inverse[i] * v for v in p]
                below = never_negative(more([ZERO, Fraction(1)], scaled, side, -1), a, b)
                need(below, f"sigma phi >= {inverse[i]} phi^2 fails in channel {i + 1}")
        unit = [Fraction(j == n + i) for j in range(n + m)]
        units.append(unit)
        turned = [theta[i] * dot(H.C[i], column) for column in flow]
        products.append((2, unit, [t + weights[i] * (y - inverse[i] * z) for t, y, z in zip(turned, Y[i], unit)]))
        products.append((least[i], unit, unit))
        if theta[i]:
            above = [[v + a * b for v, b in zip(row, H.C[i])] for row, a in zip(above, H.C[i])]
    falls = added((-1, growth(P, H)), (-1, quadratic(*products)))
    need(all(semidefinite([row[: i + 1] for i, row in enumerate(M)]) for M in (P, falls)), "V >= 0 or its fall fails")
    definite(above, "V does not grow with x")
    known = [unit for unit, e, w, c in zip(units, least, weights, inverse) if e or (w and not c)]
    held = exact.lasting([*falls, *known], moved(H))
    need(len(exact.lasting([*held, *units], moved(H))) == len(held), "V may stay the same while phi is not 0")
    need(len(exact.lasting([*held, *Y], moved(H))) == n + m, "a state is hidden from sigma")
    return {
        "decrease": "V = x^T P x + 2 sum theta_i int phi_i >= 0 goes to infinity with x, and falls unless phi = 0",
        "rest": "where phi = 0, sigma = 0 at all times: then x = 0, as sigma sees all states",
    }


def beyond(H: Plant, graphs: list[Graph], proof: Any) -> dict[str, str]:
    """``V = x'Q x`` has ``V' >= rate (V - 1)``, as ``|p_i| <= a_i`` and ``sum s_i a_i^2 <= rate``, weights ``s_i``."""
    method, rows, rate, weights = fields(proof, "method", "Q", "rate", "weights")
    form(method == "growth", "starts beyond a set are proved by growth or by signs")
    n, m, r, s = len(H.A), len(H.D), number(rate), numbers(weights, len(H.D))
    clips = [one.clip() for one in graphs]
    G = closed_loop(H, [[e * (i == j) for j in range(m)] for i, (e, *_) in enumerate(clips)])
    need(G is not None and r > 0 and min(s) >= 0, "a rate > 0 and weights >= 0 are needed")
    assert G is not None
    acyclic(G.D)
    need(sum((w * max(a, b) ** 2 for w, (_, _, a, b) in zip(s, clips)), ZERO) <= r, "the weights exceed the rate")
    Q = triangle(rows, n)
    M: Rows = growth(Q, G, r)
    for i, w in enumerate(s, n):
        M[i][i] += w
    definite(M, "that V grows fails, or is undecided")
    return {"growth": f"V = x^T Q x, V - 1 grows at a rate of at least {r} where V > 1 (order {n + m})"}


def by_signs(H: Plant, graphs: list[Graph], inner: bool, proof: Any) -> tuple[str, dict[str, str]]:
    """One state: ``x' = f(x)`` with ``x f(x) < 0``, in discrete time ``|f(x)| < |x|``, for ``low < x < high``, not 0.

    And against it: ``f(high) >= 0`` and ``f(low) <= 0``; in discrete time ``|f(x)| >= |x|`` from there on.
    """
    _, ends = fields(proof, "method", "interval")
    form(isinstance(ends, list) and len(ends) == 2, "an interval is a pair")
    low, high = map(extended, ends)
    need(low < 0 < high and "finite" not in ends, "the interval is none around 0")
    need(len(H.A) == 1 and not any(map(any, H.D)), "signs are about one state and D = 0")
    need(all(one.reach == INF for one in graphs), "signs need nonlinearities that are known")
    need(not H.discrete or low == -high, "in discrete time the interval is symmetric")
    cuts = sorted({ZERO, *(x / c[0] for one, c in zip(graphs, H.C) if c[0] for x in one.cuts)})
    f = list[tuple[Any, Any, list[Fraction]]]()
    for a, b in pairwise([-INF, *cuts, INF]):
        middle = b - 1 if a == -INF else a + 1 if b == INF else (a + b) / 2
        total = real(0, H.A[0][0])
        for one, b_i, c in zip(graphs, H.B[0], (row[0] for row in H.C)):
            p = one.pieces[sum(x < c * middle for x in one.cuts)]
            total = total + real(-b_i) * real(*(v * c**k for k, v in enumerate(p)))
        f.append((a, b, total.part()))
    step = [ZERO, Fraction(1)]

    def holds(a: Any, b: Any, strictly: bool) -> bool:
        """``strictly``: whether every solution comes nearer to 0 between two ends; else, whether none does."""
        for left, right, p in f:
            x, y = max(a, left), min(b, right)
            if x < y:
                sign = (1 if x >= 0 else -1) * (1 if strictly else -1)
                if H.discrete:
                    turned = (never_negative(more(step, p, sign, turn), x, y, strictly) for turn in (1, -1))
                    fine = (all if strictly else any)(turned)
                else:
                    fine = never_negative(more(p, [], -sign), x, y, True)
                if not fine:
                    return False
        return True

    if inner:
        need(holds(low, high, True), "x = 0 does not attract all of the interval")
        how = "|f(x)| < |x|" if H.discrete else "x f(x) < 0"
        return BETWEEN.format(*ends), {"signs": f"{how} for {ends[0]} < x < {ends[1]}, x != 0, by Sturm's chains"}
    need((low, high) != (-INF, INF), "nothing lies beyond")
    if H.discrete:
        need(holds(-INF, low, False) and holds(high, INF, False), "|f(x)| >= |x| is not shown from the ends on")
        return OUTSIDE.format(*ends), {"signs": "|f(x)| >= |x| from there on"}
    at = [sum((exact.value(p, x) for a, b, p in f if a < x <= b), ZERO) for x in (low, high) if abs(x) != INF]
    signs = [v * (1 if x > 0 else -1) for v, x in zip(at, (x for x in (low, high) if abs(x) != INF))]
    need(min(signs) >= 0, "the solution may come back across an end")
    return OUTSIDE.format(*ends), {"signs": "f >= 0 at the upper end and f <= 0 at the lower one: none crosses them"}


def cross(p: Point, q: Point) -> Fraction:
    """``p_1 q_2 - p_2 q_1``."""
    return p[0] * q[1] - p[1] * q[0]


def once_around(H: Plant, graphs: list[Graph], given: Any) -> tuple[int, Fraction, list[Arc]]:
    """Arcs that go once around 0, seen from there in one sense: the sense, the end as a factor of the start, the arcs.

    Given are the start, then for each arc its end, before which its control point may stand.
    """
    need(len(H.A) == 2 and not H.discrete and not any(map(any, H.D)), "curves are about two states and D = 0")
    need(all(one.reach == INF for one in graphs), "curves need nonlinearities that are known")
    form(isinstance(given, list) and 4 <= len(given) <= 20_000, "a curve is a list of points")
    rows = [numbers(row) for row in given]
    form(len(rows[0]) == 2 and all(len(row) in (2, 4) for row in rows), "a point has two coordinates")
    arcs = list[Arc]()
    chain: list[Point] = [(rows[0][0], rows[0][1])]
    for row in rows[1:]:
        points = [(row[i], row[i + 1]) for i in range(0, len(row), 2)]
        arcs.append((chain[-1], points[0] if len(points) == 2 else None, points[-1]))
        chain += points
    start, end = chain[0], chain[-1]
    sense = 1 if cross(start, chain[1]) > 0 else -1
    turned = all(sense * cross(p, q) > 0 for p, q in [*pairwise(chain), *((p, q) for p, _, q in arcs)])
    sides = [sense * cross(start, p) for p in chain[1:-1]]
    halves = [1 if side > 0 else 3 if side < 0 else 2 for side in sides]
    along = start[0] * end[0] + start[1] * end[1]
    once = cross(start, end) == 0 and along > 0 and sorted(halves) == halves and halves[-1] == 3
    need(turned and once, "the curve does not go once around 0, in one sense")
    return sense, along / (start[0] ** 2 + start[1] ** 2), arcs


def crossed(H: Plant, graphs: list[Graph], arcs: list[Arc], way: int) -> None:
    """Solutions cross the arcs from right to left, seen along them, for ``way = -1`` the other way; nowhere along them.

    ``way (x' f_2 - y' f_1) > 0`` at each point of an arc: a polynomial in its parameter where no nonlinearity changes
    its piece.  A curved arc stays in one piece of each, by its three points.
    """
    for p, c, q in arcs:
        X, D = list[Any](), list[Any]()
        for k in (0, 1):
            bend = [] if c is None else [p[k] - 2 * c[k] + q[k]]
            D.append([(q if c is None else c)[k] - p[k], *bend])
            X.append([p[k], (1 if c is None else 2) * D[k][0], *bend])
        line, seen_at, times = mixed(H.A, X), list[list[Fraction]](), {ZERO, Fraction(1)}
        for row, one in zip(H.C, graphs):
            values = [row[0] * point[0] + row[1] * point[1] for point in (p, c, q) if point is not None]
            inside = [x for x in one.cuts if min(values) < x < max(values)]
            need(c is None or not inside, "a curved arc crosses a cut of a nonlinearity")
            times |= {(x - values[0]) / (values[1] - values[0]) for x in inside}
            seen_at.append(values)
        for a, b in pairwise(sorted(times)):
            f = line
            for i, (sigma, one, values) in enumerate(zip(mixed(H.C, X), graphs, seen_at)):
                middle = (min(values) + max(values)) / 2 if c else values[0] + (values[1] - values[0]) * (a + b) / 2
                phi = list[Any]()
                for v in reversed(one.pieces[sum(x < middle for x in one.cuts)]):
                    phi = exact.added(exact.multiplied(phi, sigma), [v])
                f = [exact.added(f[k], [-H.B[k][i] * v for v in phi]) for k in (0, 1)]
            speed = exact.added(exact.multiplied(D[0], f[1]), [-v for v in exact.multiplied(D[1], f[0])])
            while speed and not speed[-1]:
                speed.pop()
            need(
                exact.positive([way * v for v in speed], a, b),
                "solutions are not shown to cross an arc in one direction",
            )


def mixed(rows: Rows, X: list[list[Any]]) -> list[list[Any]]:
    """Of two polynomials the sums with the entries of each row."""
    return [exact.added([row[0] * v for v in X[0]], [row[1] * v for v in X[1]]) for row in rows]


def curve(H: Plant, graphs: list[Graph], proof: Any) -> dict[str, str]:
    """A closed curve around 0 that solutions cross outwards: what starts outside never comes in.

    Its end lies farther out on the ray from 0 than its start; the edge between is crossed in the sense of the curve.
    Back in time nothing leaves it.  If 0 is the only equilibrium within and attracts what is near, it is no limit back
    in time, and by Poincare and Bendixson every other solution has a periodic one as its limit.
    """
    _, given, *orbit = fields(proof, "method", "points", *["orbit"] * ("orbit" in proof))
    sense, factor, arcs = once_around(H, graphs, given)
    need(factor >= 1, "the end of the curve lies within its start")
    crossed(H, graphs, arcs, -sense)
    if factor > 1:
        crossed(H, graphs, [(arcs[0][0], None, arcs[-1][2])], sense)
    facts = {"curve": f"{len(arcs)} arcs once around 0 are crossed outwards: their tangents and x' are independent"}
    if orbit:
        need(orbit == [True] and len(graphs) == 1, "a periodic motion is shown of one nonlinearity")
        still(H, graphs[0], sense, arcs)
        one, B, C = graphs[0], [row[0] for row in H.B], H.C[0]
        slope = [*one.pieces[sum(x < 0 for x in one.cuts)], ZERO, ZERO][1]
        (a, b), (c, d) = ([H.A[k][j] - slope * B[k] * C[j] for j in (0, 1)] for k in (0, 1))
        need(ZERO not in one.cuts and a + d < 0 < a * d - b * c, "0 is not shown to attract what is near")
        facts["equilibria"] = f"0 is the only one within; there phi' = {slope}, with which the loop is stable"
    return facts


def spiral(H: Plant, graphs: list[Graph], data: Any, proof: Any) -> dict[str, str]:
    """Turns around 0, each closed along one ray, that solutions cross inwards, the last one ending in the ellipsoid.

    Each turn bounds a set that no solution leaves, and the next one starts on the ray no nearer to 0 than it ends.  A
    periodic solution in such a set goes around 0, the only equilibrium there, and crosses the ray below the end of the
    turn: in the next set, at last in the ellipsoid.  So there is none, and by Poincare and Bendixson all tends to 0.
    """
    _, rows, given = fields(proof, "method", "P", "turns")
    need(len(graphs) == 1, "a spiral is about one nonlinearity")
    facts = ellipsoid(H, graphs, data, {"method": "ellipsoid", "P": rows}, False)
    P = triangle(rows, 2)
    form(isinstance(given, list) and 1 <= len(given) <= 400, "a spiral has up to 400 turns")
    turns = [once_around(H, graphs, one) for one in given]
    sense, _, outer = turns[0]
    ray = outer[0][0]
    starts, ends = list[Fraction](), list[Fraction]()
    for one, factor, arcs in turns:
        at = arcs[0][0]
        along = (ray[0] * at[0] + ray[1] * at[1]) / (ray[0] ** 2 + ray[1] ** 2)
        need(one == sense and cross(ray, at) == 0 and along > 0, "a turn starts on another ray, or in another sense")
        need(factor < 1, "a turn does not end nearer to 0 than it starts")
        starts, ends = [*starts, along], [*ends, along * factor]
        crossed(H, graphs, arcs, sense)
    need(all(a >= b for a, b in zip(starts[1:], ends)), "a turn starts within the end of the one before")
    low, high = ((v * ray[0], v * ray[1]) for v in (min(ends), max(starts)))
    crossed(H, graphs, [(low, None, high)], sense)
    x, y = (ends[-1] * v for v in ray)
    need(P[0][0] * x * x + 2 * P[1][0] * x * y + P[1][1] * y * y <= 1, "the last turn ends outside of the ellipsoid")
    still(H, graphs[0], sense, outer)
    return facts | {
        "spiral": f"{len(turns)} turns, {sum(len(arcs) for *_, arcs in turns)} arcs, are crossed inwards, their ray in "
        "one sense",
        "equilibria": "0 is the only one within the first turn",
    }


def still(H: Plant, one: Graph, sense: int, arcs: list[Arc]) -> None:
    """0 is the only equilibrium within the arcs.

    With ``A - g B C`` invertible all are ``x = d psi``, ``psi = phi - g sigma``, on one line: ``sigma = h psi``.
    """
    (A, B, C), g = (H.A, [row[0] for row in H.B], H.C[0]), ZERO
    for g in (ZERO, Fraction(1)):
        (a, b), (c, d) = ([A[k][j] - g * B[k] * C[j] for j in (0, 1)] for k in (0, 1))
        if a * d != b * c:
            break
    need(a * d != b * c, "equilibria are not isolated")
    line = (d * B[0] - b * B[1]) / (a * d - b * c), (a * B[1] - c * B[0]) / (a * d - b * c)
    h = C[0] * line[0] + C[1] * line[1]
    edges = [edge for p, c, q in arcs for edge in ([(p, q)] if c is None else [(p, q), (p, c), (c, q)])]
    for side in (1, -1) if h else ():
        way = side * line[0], side * line[1]
        met = [(p, q) for p, q in edges if sense * cross(p, way) >= 0 and sense * cross(way, q) >= 0]
        need(bool(met), "the curve does not meet a ray")
        far = side * h * max(cross(p, q) / cross(way, (q[0] - p[0], q[1] - p[1])) for p, q in met)
        for low, high, p in one.between(*sorted((ZERO, far))):
            rest = (real(0, 1 + g * h) + real(-h) * real(*p)).part()  # sigma - h psi
            ends = [exact.value(rest, x) for x in (low, high) if x]
            need(
                all(ends) and any(never_negative([s * v for v in rest], low, high, True) for s in (1, -1)),
                "there is an equilibrium within the first turn, or it is not excluded",
            )
