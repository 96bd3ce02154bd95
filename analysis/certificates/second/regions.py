r"""Regions of attraction, checked again: forms in balls, strips by the inverse of ``P``, signs by isolated roots.

With ``z = (x, phi)``, ``x' = F z``, ``sigma = Y z`` and ``E z = x`` the form ``V = x'P x`` falls where the terms ``w (u
sigma - phi)(phi - v)`` are not negative if

.. math:: -(E'PF + F'PE) - \sum_i w_i (f_i' g_i + g_i' f_i) > 0, \quad f_i = u_i Y_i - e_i, \quad g_i = e_i - v_i,

in discrete time with ``E'PE - F'PF``.  A term counts on ``V <= 1`` if ``r P^{-1} r' < c^2`` for its strip ``|r x| <=
c``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from flint import arb_mat, fmpq, fmpq_mat, fmpq_poly

from lure.analysis.certificates.second.channels import diagonal, matrices, stacked, symmetric
from lure.analysis.certificates.second.matrix import BITS, positive_definite
from lure.analysis.certificates.second.numerics import (
    X,
    nonnegative_from_zero,
    positive_from_zero,
    to_fmpq,
    to_fraction,
    working_precision,
)
from lure.analysis.certificates.second.reading import (
    Document,
    NotShown,
    count,
    listed,
    mapping,
    number,
    numbers,
    record,
    require,
    text,
)

INSIDE = "every motion that starts in {x : x^T P x <= 1} tends to 0, P as in the proof"
LEVEL = (
    "every motion that starts in {x : x^T P x + 2 sum theta_i int_0^sigma_i phi_i <= 1, |sigma_i| <= reach_i} tends to "
    "0, P, theta and reach as in the proof"
)
BEYOND = "no motion that starts in {x : x^T Q x > 1} tends to 0, Q as in the proof"
WITHIN = "every motion that starts within the first turn of the spiral, closed along its ray, tends to 0"
AROUND = "no motion that starts on or outside the closed curve of the proof tends to 0"
LARGEST_DEGREE, LONGEST_CURVE, MOST_TURNS = 40, 20_000, 400
Cut = Fraction | None  # None: there is no end on this side


@dataclass(frozen=True, kw_only=True, slots=True)
class Graph:
    """A nonlinearity: polynomials between cuts, or, without any, a sector for ``|sigma| <= reach``."""

    cuts: tuple[Fraction, ...] = ()
    pieces: tuple[fmpq_poly, ...] = ()
    sector: tuple[Fraction, Fraction] = (Fraction(0), Fraction(0))
    reach: Fraction | None = None

    @property
    def clip(self) -> tuple[Fraction, Fraction, Fraction, Fraction] | None:
        """``e, u, least, most``: ``phi - e sigma`` is ``(u - e) sigma`` held between the last two; else None."""
        if len(self.pieces) != 3 or any(p.degree() > 1 for p in self.pieces) or self.pieces[1][0] != 0:
            return None
        left, middle, right = self.pieces
        least, most = sorted((to_fraction(left[0]), to_fraction(right[0])))
        if left[1] != right[1] or not least < 0 < most or not self.cuts[0] < 0 < self.cuts[1]:
            return None
        return to_fraction(left[1]), to_fraction(middle[1]), least, most


def _read(value: object) -> Graph:
    """The nonlinearity of one channel, continuous with ``phi(0) = 0``."""
    if mapping(value).get("kind") == "sector":
        found = record(value, "kind", "sector", "reach")
        low, high = numbers(found["sector"])
        require(low <= high and number(found["reach"]) > 0, "a sector or its reach is none")
        return Graph(sector=(low, high), reach=number(found["reach"]))
    found = record(value, "kind", "cuts", "pieces")
    require(found["kind"] == "piecewise-polynomial", "the kind of a nonlinearity is unknown")
    cuts = tuple(numbers(found["cuts"]))
    pieces = tuple(fmpq_poly([to_fmpq(v) for v in numbers(piece)]) for piece in listed(found["pieces"]))
    require(len(pieces) == len(cuts) + 1, "there is not one polynomial more than cuts")
    require(all(p.degree() < LARGEST_DEGREE for p in pieces), "the degree of a polynomial is too high")
    require(all(a < b for a, b in pairwise(cuts)), "the cuts do not ascend")
    for cut, (left, right) in zip(cuts, pairwise(pieces), strict=True):
        require(bool(left(to_fmpq(cut)) == right(to_fmpq(cut))), "the nonlinearity jumps")
    require(bool(pieces[sum(cut < 0 for cut in cuts)](fmpq(0)) == 0), "phi(0) is not 0")
    return Graph(cuts=cuts, pieces=pieces)


def _pieces(graph: Graph, scale: Fraction) -> list[tuple[Cut, Cut, fmpq_poly]]:
    """The pieces of ``phi(scale x)`` over ``x``, with their ends; scale > 0 or < 0."""
    argument, cuts = to_fmpq(scale) * X, [cut / scale for cut in graph.cuts]
    parts = [piece(argument) for piece in graph.pieces]
    if scale < 0:
        cuts, parts = cuts[::-1], parts[::-1]
    return list(zip([None, *cuts], [*cuts, None], parts, strict=True))


def _nonnegative(p: fmpq_poly, low: Cut, high: Cut) -> bool:
    """Whether ``p >= 0`` between two ends, one of which is finite."""
    if low is None:
        require(high is not None, "an interval has no end")
        assert high is not None, "it was required"
        return nonnegative_from_zero(p(to_fmpq(high) - X))
    if high is None:
        return nonnegative_from_zero(p(to_fmpq(low) + X))
    top, start, width = max(p.degree(), 0), to_fmpq(low), to_fmpq(high - low)
    # x = low + width t/(1 + t), times (1 + t)^degree
    moved, grown = p(start + width * X), fmpq_poly([])
    for i, c in enumerate(moved.coeffs()):
        grown += c * X**i * (1 + X) ** (top - i)
    return nonnegative_from_zero(grown)


def _positive_inside(p: fmpq_poly, low: Cut, high: Cut) -> bool:
    """Whether ``p > 0`` strictly between the ends: it is nonnegative, and has no double root there."""
    if not _nonnegative(p, low, high) or p.degree() < 0:
        return False
    for end in (low, high):  # roots at the ends are allowed
        while end is not None and p.degree() > 0 and p(to_fmpq(end)) == 0:
            p //= X - to_fmpq(end)
    shared = p.gcd(p.derivative())  # a root inside would be a double one, p being nonnegative
    if shared.degree() < 1:
        return True
    return _positive_inside(shared, low, high) or _positive_inside(-shared, low, high)


def _in_sector(graph: Graph, low: Fraction, high: Fraction, reach: Fraction) -> bool:
    """Whether the sector holds for ``|sigma| <= reach``."""
    if graph.reach is not None:
        return reach <= graph.reach and low <= graph.sector[0] and graph.sector[1] <= high
    for sign in (1, -1):  # over x = sign sigma in (0, reach)
        for start, end, piece in _pieces(graph, Fraction(sign)):
            left = Fraction(0) if start is None else max(start, Fraction(0))
            right = reach if end is None else min(end, reach)
            if left >= right:
                continue
            own = sign * piece
            if not (
                _nonnegative(own - to_fmpq(low) * X, left, right) and _nonnegative(to_fmpq(high) * X - own, left, right)
            ):
                return False
    return True


@dataclass(frozen=True, kw_only=True, slots=True)
class _Loop:
    """The plant as ``x' = F z``, ``sigma = Y z`` with ``z = (x, phi)``, and its nonlinearities."""

    F: fmpq_mat
    Y: fmpq_mat
    D: fmpq_mat
    discrete: bool
    graphs: tuple[Graph, ...]

    @property
    def sizes(self) -> tuple[int, int]:
        """How many states and channels there are."""
        return self.F.nrows(), self.Y.nrows()

    def form(self, P: fmpq_mat, rate: Fraction = Fraction(0)) -> fmpq_mat:
        """``V' - rate V``, or ``V+ - (1 + rate) V``."""
        n, m = self.sizes
        E = fmpq_mat([[int(i == j) for j in range(n + m)] for i in range(n)])
        if self.discrete:
            return self.F.transpose() * P * self.F - to_fmpq(1 + rate) * (E.transpose() * P * E)
        half = E.transpose() * P * self.F
        return half + half.transpose() - to_fmpq(rate) * (E.transpose() * P * E)


def shown(document: Document) -> str:
    """The sentence that a certificate about a region of attraction shows.

    Parameters
    ----------
    document : Document
        The parts of the certificate.

    Raises
    ------
    NotShown
        It shows nothing.
    """
    sides, discrete = matrices(document)
    m = sides["D"].nrows()
    graphs = tuple(map(_read, listed(record(document.nonlinearities, "graphs")["graphs"])))
    require(len(graphs) == m, "there is not one nonlinearity for each channel")
    require(document.nonlinearity is None, "no nonlinearity is given beside several")
    pattern = fmpq_mat([[int(sides["D"][i, j] != 0) for j in range(m)] for i in range(m)])
    require(bool(pattern**m == fmpq_mat(m, m)), "D has a cycle")
    F = _beside(sides["A"], -sides["B"])
    loop = _Loop(F=F, Y=_beside(sides["C"], -sides["D"]), D=sides["D"], discrete=discrete, graphs=graphs)
    inner = document.verdict == "PROVED"
    require(inner or document.verdict == "REFUTED", "the verdict is neither PROVED nor REFUTED")
    if document.proof.get("method") == "signs":
        require(document.theorem == ("scalar" if inner else "counterexample"), "the theorem is not about one state")
        require(not document.multiplier, "signs need no multiplier")
        return _by_signs(loop, document, inner=inner)
    if document.proof.get("method") == "spiral":
        require(inner and document.theorem == "planar", "a spiral shows what tends to 0")
        _require_spiral(loop, document)
        return WITHIN
    if document.proof.get("method") == "curve":
        require(not inner and document.theorem == "counterexample", "a curve shows what never comes in")
        require(not document.multiplier, "a curve needs no multiplier")
        curve = _curve(loop, record(document.proof, "method", "points")["points"])
        require(curve.factor >= 1, "the curve ends nearer to 0 than it starts")
        _require_crossed(loop, curve.arcs, -curve.sense)
        if curve.factor > 1:
            _require_crossed(loop, (curve.along_ray(Fraction(1), curve.factor),), curve.sense)
        return AROUND
    if inner:
        require(document.theorem in ("local-circle", "local-popov"), "the theorem is unknown for regions")
        _require_level_set(loop, document)
        return INSIDE if document.theorem == "local-circle" else LEVEL
    require(document.theorem == "counterexample" and not document.multiplier, "a refutation is a counterexample")
    _require_growth(loop, document)
    return BEYOND


def _beside(left: fmpq_mat, right: fmpq_mat) -> fmpq_mat:
    return fmpq_mat([[*a, *b] for a, b in zip(left.tolist(), right.tolist(), strict=True)])


def _require_definite(M: fmpq_mat, reason: str) -> None:
    for bits in BITS:
        with working_precision(bits):
            if positive_definite(arb_mat(M)):
                return
    raise NotShown(reason)


def _row(values: Sequence[Fraction]) -> fmpq_mat:
    return fmpq_mat([[to_fmpq(v) for v in values]])


def _integral_bounded(graph: Graph, least: Fraction, reach: Fraction, *, above: bool) -> bool:
    """Whether ``2 int_0^sigma phi - least sigma^2`` is ``>= 0``, or ``<= 0``, for ``|sigma| <= reach``."""
    for sign in (1, -1):  # over x = sign sigma in (0, reach), d/dx int phi = sign phi(sign x)
        start_value = fmpq(0)
        for start, end, piece in _pieces(graph, Fraction(sign)):
            left = Fraction(0) if start is None else max(start, Fraction(0))
            right = reach if end is None else min(end, reach)
            if left >= right:
                continue
            own = (sign * piece).integral()
            own += start_value - own(to_fmpq(left))
            start_value = own(to_fmpq(right))
            rest = 2 * own - to_fmpq(least) * X * X
            if not _nonnegative(rest if above else -rest, left, right):
                return False
    return True


def _require_level_set(loop: _Loop, document: Document) -> fmpq_mat:
    """Check that ``V`` falls on ``V <= 1``, and that the terms used for it count there; ``P``."""
    level, spiral = document.theorem == "local-popov", document.theorem == "planar"
    found = record(document.proof, "method", "P", *(("integrals",) if level else ("turns",) if spiral else ()))
    method = "level-set" if level else "spiral" if spiral else "ellipsoid"
    require(found["method"] == method, "the method does not fit the theorem")
    n, m = loop.sizes
    P = symmetric(found["P"], n)
    M, strips = -loop.form(P), list[tuple[fmpq_mat, Fraction]]()
    least = P + 0 * P  # below V on the set
    for entry in listed(found["integrals"]) if level else ():
        given = record(entry, "channel", "theta", "reach", "least")
        i, theta = count(given["channel"], least=1) - 1, number(given["theta"])
        reach, bound = number(given["reach"]), number(given["least"])
        require(i < m and reach > 0 and not loop.discrete, "an integral does not fit")
        require(all(loop.D[i, j] == 0 for j in range(m)), "sigma of a channel with an integral depends on phi")
        graph = loop.graphs[i]
        require(graph.reach is None, "an integral is one of a known nonlinearity")
        require(_integral_bounded(graph, bound, reach, above=theta >= 0), "an integral is not bounded")
        row = fmpq_mat([loop.Y.tolist()[i][:n]])
        least += to_fmpq(theta * bound) * (row.transpose() * row)
        strips.append((row, reach))
        half = fmpq_mat([[int(j == n + i) for j in range(n + m)]]).transpose() * (row * loop.F)
        M -= to_fmpq(theta) * (half + half.transpose())
    _require_definite(least, "V is not shown to be positive definite")
    inverse = least.inv()
    reaches: dict[int, Fraction] = {}
    most = {i: max(map(abs, one.clip[2:])) for i, one in enumerate(loop.graphs) if one.clip and one.clip[0] == 0}

    def require_strip(row: fmpq_mat, half: Fraction) -> None:
        """Check ``|row x| < half`` on the ellipsoid."""
        square = (row * inverse * row.transpose())[0, 0]
        require(half > 0 and bool(square < to_fmpq(half * half)), "the ellipsoid leaves a strip")

    for strip in strips:
        require_strip(*strip)
    for item in listed(record(document.multiplier, "terms")["terms"]):
        local = "sector" in mapping(item)
        term = record(item, "channel", "weight", *(("sector", "reach") if local else ("row",)))
        i, weight = count(term["channel"], least=1) - 1, number(term["weight"])
        require(i < m and weight >= 0, "a channel is none, or a weight is negative")
        own, phi = fmpq_mat([loop.Y.tolist()[i]]), fmpq_mat([[int(j == n + i) for j in range(n + m)]])
        if local:
            (low, high), reach = numbers(term["sector"]), number(term["reach"])
            require(reach > 0 and _in_sector(loop.graphs[i], low, high, reach), "the sector does not hold")
            reaches[i] = min(reach, reaches.get(i, reach))
            largest = max(abs(low), abs(high)) * reach
            most[i] = min(largest, most.get(i, largest))
            point = to_fmpq(low) * own
        else:
            clip = loop.graphs[i].clip
            if clip is None:
                raise NotShown("the nonlinearity has no limits")
            outer, high, lower, upper = clip
            row = _row(numbers(term["row"]))
            require(row.ncols() == n, "a row is not one of the states")
            require_strip(row, min(-lower, upper))
            point = to_fmpq(outer) * own + _beside(row, fmpq_mat(1, m))
        product = (to_fmpq(high) * own - phi).transpose() * (phi - point)
        M -= to_fmpq(weight) * (product + product.transpose())
    for i, graph in enumerate(loop.graphs):
        require(
            graph.reach is None or (i in reaches and reaches[i] <= graph.reach), "a sector holds on an interval alone"
        )
    for i, reach in reaches.items():
        rest = reach
        for j in range(m):
            if loop.D[i, j] != 0:
                require(j in most, "what feeds through is not bounded")
                rest -= abs(to_fraction(loop.D[i, j])) * most[j]
        require_strip(fmpq_mat([loop.Y.tolist()[i][:n]]), rest)
    _require_definite(M, "V is not shown to fall")
    return P


def _require_growth(loop: _Loop, document: Document) -> None:
    """Check ``V' >= rate (V - 1)`` for limited nonlinearities, the lines outside the limits taken into the plant."""
    found = record(document.proof, "method", "Q", "rate", "weights")
    require(found["method"] == "growth", "the method does not fit")
    n, m = loop.sizes
    Q, rate, weights = symmetric(found["Q"], n), number(found["rate"]), numbers(found["weights"])
    require(rate > 0 and len(weights) == m and min(weights) >= 0, "the rate or the weights are no good")
    clips = [clip for graph in loop.graphs if (clip := graph.clip) is not None]
    require(len(clips) == m, "a nonlinearity has no limits")
    squares = [max(low * low, high * high) for _, _, low, high in clips]
    require(
        sum((w * v for w, v in zip(weights, squares, strict=True)), Fraction(0)) <= rate, "the weights are too large"
    )
    # z = T (x, p) with phi = e sigma + p: sigma = C x - D phi, (1 + e D) phi = e C x + p
    outer = diagonal([clip[0] for clip in clips])
    C, one = fmpq_mat([row[:n] for row in loop.Y.tolist()]), diagonal([Fraction(1)] * m)
    back = (one + outer * loop.D).inv()
    T = stacked(fmpq_mat([[int(i == j) for j in range(n + m)] for i in range(n)]), _beside(back * outer * C, back))
    turned = _Loop(F=loop.F * T, Y=loop.Y, D=loop.D, discrete=loop.discrete, graphs=loop.graphs)
    corner = fmpq_mat(
        [[to_fmpq(weights[i - n]) if i == j >= n else fmpq(0) for j in range(n + m)] for i in range(n + m)]
    )
    _require_definite(turned.form(Q, rate) + corner, "V is not shown to grow")


def _ends(value: object) -> tuple[Cut, Cut]:
    low, high = listed(value)
    return None if low == "-inf" else number(low), None if high == "inf" else number(high)


def _by_signs(loop: _Loop, document: Document, *, inner: bool) -> str:
    """One state: the signs of ``f``, or of ``x - f`` and ``x + f``, on both sides of 0."""
    found = record(document.proof, "method", "interval")
    low, high = _ends(found["interval"])
    words = [text(end) for end in listed(found["interval"])]
    n, _ = loop.sizes
    require(n == 1 and not any(v != 0 for v in loop.D.entries()), "signs are about one state and D = 0")
    require(all(graph.reach is None for graph in loop.graphs), "the nonlinearities are not known")
    require((low is None or low < 0) and (high is None or high > 0), "the interval is none around 0")
    opposite = (low is None and high is None) or (low is not None and high is not None and low == -high)
    require(not loop.discrete or opposite, "the interval is not symmetric")
    parts = [
        (_pieces(graph, to_fraction(loop.Y[i, 0])), loop.F[0, 1 + i])
        for i, graph in enumerate(loop.graphs)
        if loop.Y[i, 0] != 0
    ]
    cuts = sorted({Fraction(0), *(start for pieces, _ in parts for start, _, _ in pieces if start is not None)})
    whole: list[tuple[Cut, Cut, fmpq_poly]] = []
    for start, end in pairwise([None, *cuts, None]):
        f = fmpq_poly([0, loop.F[0, 0]])
        for pieces, factor in parts:
            f += factor * next(p for a, b, p in pieces if _over(a, b, start, end))
        whole.append((start, end, f))
    right = [(start, end, f) for start, end, f in whole if start is not None and start >= 0]
    left = [
        (-end, None if start is None else -start, -f(-X)) for start, end, f in whole if end is not None and end <= 0
    ]
    if inner:
        for reach, side in ((high, right), (None if low is None else -low, left)):
            for start, end, f in side:  # x f(x) < 0 over x > 0
                top = end if reach is None else reach if end is None else min(end, reach)
                if top is not None and start >= top:
                    continue
                needed = (X - f, X + f) if loop.discrete else (-f,)
                require(all(_positive_inside(p, start, top) for p in needed), "0 does not attract all of the interval")
        return f"every motion that starts between {words[0]} and {words[1]} tends to 0"
    require(low is not None or high is not None, "nothing lies beyond")
    for reach, side in ((high, right), (None if low is None else -low, left)):
        if reach is None:
            continue
        for start, end, f in side:
            if loop.discrete and (end is None or end > reach):
                beyond = max(start, reach)
                grows = _nonnegative(f - X, beyond, end) or _nonnegative(-f - X, beyond, end)
                require(grows, "|f(x)| >= |x| is not shown")
            elif start < reach and (end is None or end >= reach):
                require(loop.discrete or bool(f(to_fmpq(reach)) >= 0), "a solution may come back")
    return f"no motion that starts at or beyond {words[0]} or {words[1]} tends to 0"


def _over(low: Cut, high: Cut, start: Cut, end: Cut) -> bool:
    """Whether an interval covers a smaller one."""
    return (low is None or (start is not None and low <= start)) and (high is None or (end is not None and end <= high))


# Curves in the plane.  A parabola is q(t) = a + b t + c t^2 for 0 <= t <= 1; a straight edge has c = 0.

Place = tuple[fmpq, fmpq]


@dataclass(frozen=True, kw_only=True, slots=True)
class _Arc:
    """Its corners: start, end, and between them the control point of a parabola."""

    corners: tuple[Place, ...]

    def coordinate(self, k: int) -> fmpq_poly:
        """``q_k(t)``."""
        values = [corner[k] for corner in self.corners]
        if len(values) == 2:
            return fmpq_poly([values[0], values[1] - values[0]])
        a, b, c = values
        return a * (1 - X) ** 2 + 2 * b * X * (1 - X) + c * X**2


@dataclass(frozen=True, kw_only=True, slots=True)
class _Curve:
    """Once around 0: ``sense`` is 1 for anticlockwise; it ends at ``factor`` times its start."""

    sense: int
    start: Place
    factor: Fraction
    arcs: tuple[_Arc, ...]

    def along_ray(self, low: Fraction, high: Fraction) -> _Arc:
        """The edge between two factors of the start."""
        low_end, high_end = ((to_fmpq(v) * self.start[0], to_fmpq(v) * self.start[1]) for v in (low, high))
        return _Arc(corners=(low_end, high_end))


def _turned(p: Place, q: Place) -> fmpq:
    """Positive where ``q`` is anticlockwise of ``p``, by less than half a turn."""
    return p[0] * q[1] - p[1] * q[0]


def _curve(loop: _Loop, value: object) -> _Curve:
    """The curve, which goes once around 0 by steps of less than half a turn in one sense."""
    require(loop.sizes[0] == 2 and not loop.discrete, "curves are about two states in continuous time")
    require(not any(v != 0 for v in loop.D.entries()), "curves are about D = 0")
    require(all(graph.reach is None for graph in loop.graphs), "the nonlinearities are not known")
    rows = [[to_fmpq(v) for v in numbers(row)] for row in listed(value)]
    require(4 <= len(rows) <= LONGEST_CURVE, "the curve has too few or too many points")
    require(len(rows[0]) == 2 and all(len(row) in (2, 4) for row in rows), "a point has not two coordinates")
    at: Place = (rows[0][0], rows[0][1])
    arcs, path = list[_Arc](), [at]
    for row in rows[1:]:
        corners = [path[-1], *((row[i], row[i + 1]) for i in range(0, len(row), 2))]
        path += corners[1:]
        arcs.append(_Arc(corners=tuple(corners)))
    sense = 1 if _turned(path[0], path[1]) > 0 else -1
    steps = [*pairwise(path), *((arc.corners[0], arc.corners[-1]) for arc in arcs)]
    require(all(sense * _turned(p, q) > 0 for p, q in steps), "the curve does not turn in one sense")
    passed = sum(bool(sense * _turned(p, at) > 0 and sense * _turned(at, q) >= 0) for p, q in pairwise(path))
    end = path[-1]
    factor = (at[0] * end[0] + at[1] * end[1]) / (at[0] ** 2 + at[1] ** 2)
    require(bool(_turned(at, end) == 0) and factor > 0 and passed == 1, "the curve does not go once around 0")
    return _Curve(sense=sense, start=at, factor=to_fraction(factor), arcs=tuple(arcs))


def _positive_on_unit(p: fmpq_poly) -> bool:
    """Whether ``p > 0`` on ``[0, 1]``: at 1, and at ``t = x/(1 + x)`` for no ``x >= 0`` a root."""
    grown, top = fmpq_poly([]), max(p.degree(), 0)
    for i, c in enumerate(p.coeffs()):
        grown += c * X**i * (1 + X) ** (top - i)
    return bool(p(fmpq(1)) > 0) and positive_from_zero(grown)


def _require_crossed(loop: _Loop, arcs: Sequence[_Arc], side: int) -> None:
    """Check that ``x'`` points strictly to the left of every arc, for ``side`` -1 to its right."""
    for arc in arcs:
        x = arc.coordinate(0), arc.coordinate(1)
        sigma = [loop.Y[i, 0] * x[0] + loop.Y[i, 1] * x[1] for i in range(len(loop.graphs))]
        reaches = [
            sorted(to_fraction(loop.Y[i, 0] * c[0] + loop.Y[i, 1] * c[1]) for c in arc.corners)
            for i in range(len(loop.graphs))
        ]
        times = {Fraction(0), Fraction(1)}
        for graph, own, reach in zip(loop.graphs, sigma, reaches, strict=True):
            for cut in graph.cuts:
                if reach[0] < cut < reach[-1]:
                    require(own.degree() == 1 and len(arc.corners) == 2, "a parabola leaves a piece")
                    times.add((cut - to_fraction(own[0])) / to_fraction(own[1]))
        for start, end in pairwise(sorted(times)):
            inner = to_fmpq(start) + to_fmpq(end - start) * X
            speed = [loop.F[k, 0] * x[0] + loop.F[k, 1] * x[1] for k in (0, 1)]
            for i, (graph, own, reach) in enumerate(zip(loop.graphs, sigma, reaches, strict=True)):
                straight = len(arc.corners) == 2
                here = to_fraction(own(to_fmpq((start + end) / 2))) if straight else (reach[0] + reach[-1]) / 2
                phi = graph.pieces[sum(cut < here for cut in graph.cuts)](own)
                speed = [speed[k] + loop.F[k, 2 + i] * phi for k in (0, 1)]
            left = x[0].derivative() * speed[1] - x[1].derivative() * speed[0]
            require(_positive_on_unit((side * left)(inner)), "an arc is not crossed")


def _require_spiral(loop: _Loop, document: Document) -> None:
    """Check that turn after turn is crossed inwards, the last one within the ellipsoid, around one equilibrium."""
    require(len(loop.graphs) == 1, "a spiral is about one nonlinearity")
    P = _require_level_set(loop, document)
    turns = [_curve(loop, value) for value in listed(document.proof["turns"])]
    require(1 <= len(turns) <= MOST_TURNS, "there are no turns, or too many")
    first, before = turns[0], None
    reaches: list[Fraction] = []
    for turn in turns:
        at = first.start[0] * turn.start[0] + first.start[1] * turn.start[1]
        factor = to_fraction(at / (first.start[0] ** 2 + first.start[1] ** 2))
        require(bool(_turned(first.start, turn.start) == 0) and factor > 0, "a turn starts on another ray")
        require(turn.sense == first.sense and turn.factor < 1, "a turn does not wind inwards as the first one does")
        require(before is None or factor >= before, "a turn starts within the end of the one before")
        before = factor * turn.factor
        reaches += [factor, before]
        _require_crossed(loop, turn.arcs, first.sense)
    _require_crossed(loop, (first.along_ray(min(reaches), max(reaches)),), first.sense)
    for arc in turns[-1].arcs:
        for corner in arc.corners:
            z = fmpq_mat([list(corner)])
            require(bool((z * P * z.transpose())[0, 0] <= 1), "the last turn leaves the ellipsoid")
    _require_one_equilibrium(loop, first)


def _require_one_equilibrium(loop: _Loop, curve: _Curve) -> None:
    """Check that ``A x = B phi`` has no solution within the curve but 0; all are ``x = (A - g B C)^-1 B psi``."""
    A, minus_b = (fmpq_mat([[row[i] for i in own] for row in loop.F.tolist()]) for own in ((0, 1), (2,)))
    C = fmpq_mat([loop.Y.tolist()[0][:2]])
    shift = next((g for g in (0, 1) if (A + g * (minus_b * C)).det() != 0), None)
    require(shift is not None, "equilibria are not isolated")
    line = -((A + (shift or 0) * (minus_b * C)).inv() * minus_b)
    slope = (C * line)[0, 0]  # sigma = slope psi(sigma), psi = phi - shift sigma
    if slope == 0:
        return
    graph = loop.graphs[0]
    for sign in (1, -1):  # x = tau way for tau > 0
        way: Place = (sign * line[0, 0], sign * line[1, 0])
        far = fmpq(0)
        for arc in curve.arcs:
            for p, q in [*pairwise(arc.corners), (arc.corners[0], arc.corners[-1])]:
                if curve.sense * _turned(p, way) >= 0 and curve.sense * _turned(way, q) >= 0:
                    far = max(far, _turned(p, q) / _turned(way, (q[0] - p[0], q[1] - p[1])))
        require(bool(far > 0), "a ray does not leave the curve")
        reach = to_fraction(far * sign * slope)
        for low, high, piece in _pieces(graph, Fraction(1 if reach > 0 else -1)):  # over |sigma|
            start = Fraction(0) if low is None else max(low, Fraction(0))
            end = abs(reach) if high is None else min(high, abs(reach))
            if start >= end:
                continue
            own = (1 if reach > 0 else -1) * X
            rest = own - slope * (piece - (shift or 0) * own)
            ends = [rest(to_fmpq(v)) for v in (start, end) if v]
            fine = _positive_inside(rest, start, end) or _positive_inside(-rest, start, end)
            require(fine and all(v != 0 for v in ends), "there is another equilibrium, or it is not excluded")
