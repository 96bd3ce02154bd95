r"""Regions of attraction, checked again: forms in balls, strips by the inverse of ``P``, signs by isolated roots.

With ``z = (x, phi)``, ``x' = F z``, ``sigma = Y z`` and ``E z = x`` the form ``V = x'P x`` falls where the terms ``w (u
sigma - phi)(phi - v)`` are not negative if

.. math:: -(E'PF + F'PE) - \sum_i w_i (f_i' g_i + g_i' f_i) > 0, \quad f_i = u_i Y_i - e_i, \quad g_i = e_i - v_i,

in discrete time with ``E'PE - F'PF``.  A term counts on ``V <= 1`` if ``r P^{-1} r' < c^2`` for its strip ``|r x| <=
c``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import pairwise

from flint import arb_mat, fmpq, fmpq_mat, fmpq_poly

from lure.analysis.certificates.second.channels import diagonal, matrices, stacked, symmetric
from lure.analysis.certificates.second.classes import ATTRACTS
from lure.analysis.certificates.second.curves import curve_of, require_crossed, require_one_equilibrium, turned
from lure.analysis.certificates.second.graphs import (
    Cut,
    Graph,
    Loop,
    nonnegative_between,
    pieces_of,
    positive_inside,
    read_graph,
)
from lure.analysis.certificates.second.matrix import BITS, positive_definite
from lure.analysis.certificates.second.numerics import (
    X,
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
from lure.analysis.certificates.second.zero import null_space

INSIDE = "every motion that starts in {x : x^T P x <= 1} tends to 0, P as in the proof"
LEVEL = (
    "every motion that starts in {x : x^T P x + 2 sum theta_i int_0^sigma_i phi_i <= 1, |sigma_i| <= reach_i} tends to "
    "0, P, theta and reach as in the proof"
)
DISTURBED = (
    "from rest every motion with a disturbance w of energy at most {}, x' = A x + B mu + Bw w (or x+), stays in {{x : "
    "x^T P x <= 1}} and tends to 0, P and Bw as in the proof"
)
SEEN = (
    "from rest every motion with a disturbance w of energy at most {}, x' = A x + B mu + Bw w (or x+), sigma = C x + D "
    "mu + Dsigmaw w, stays in {{x : x^T P x <= 1}} and tends to 0, P and Bw, Dsigmaw as in the proof"
)
BEYOND = "no motion that starts in {x : x^T Q x > 1} tends to 0, Q as in the proof"
WITHIN = "every motion that starts within the first turn of the spiral, closed along its ray, tends to 0"
AROUND = "no motion that starts on or outside the closed curve of the proof tends to 0"
ORBIT = ", and within it there is a periodic motion"
MOST_TURNS = 400


def _in_sector(graph: Graph, low: Fraction, high: Fraction, reach: Fraction) -> bool:
    """Whether the sector holds for ``|sigma| <= reach``."""
    if graph.reach is not None:
        return reach <= graph.reach and low <= graph.sector[0] and graph.sector[1] <= high
    for sign in (1, -1):  # over x = sign sigma in (0, reach)
        for start, end, piece in pieces_of(graph, Fraction(sign)):
            left = Fraction(0) if start is None else max(start, Fraction(0))
            right = reach if end is None else min(end, reach)
            if left >= right:
                continue
            own = sign * piece
            bounds = own - to_fmpq(low) * X, to_fmpq(high) * X - own
            if not all(nonnegative_between(p, left, right) for p in bounds):
                return False
    return True


def shown(document: Document) -> str:
    """The sentence that a certificate about a region of attraction shows.

    Raises
    ------
    NotShown
        It shows nothing.
    """
    sides, discrete = matrices(document)
    m = sides["D"].nrows()
    graphs = tuple(map(read_graph, listed(record(document.nonlinearities, "graphs")["graphs"])))
    require(len(graphs) == m, "there is not one nonlinearity for each channel")
    require(document.nonlinearity is None, "no nonlinearity is given beside several")
    pattern = fmpq_mat([[int(sides["D"][i, j] != 0) for j in range(m)] for i in range(m)])
    require(bool(pattern**m == fmpq_mat(m, m)), "D has a cycle")
    F = _beside(sides["A"], -sides["B"])
    loop = Loop(F=F, Y=_beside(sides["C"], -sides["D"]), D=sides["D"], discrete=discrete, graphs=graphs)
    inner = document.verdict == "PROVED"
    require(inner or document.verdict == "REFUTED", "the verdict is neither PROVED nor REFUTED")
    if document.theorem == "global-popov":
        require(inner, "what attracts everything is a proof")
        _require_everywhere(loop, document)
        return ATTRACTS
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
        orbit = "orbit" in document.proof
        found = record(document.proof, "method", "points", *(["orbit"] if orbit else []))
        curve = curve_of(loop, found["points"])
        require(curve.factor >= 1, "the curve ends nearer to 0 than it starts")
        require_crossed(loop, curve.arcs, -curve.sense)
        if curve.factor > 1:
            require_crossed(loop, (curve.along_ray(Fraction(1), curve.factor),), curve.sense)
        if orbit:
            require(found["orbit"] is True and len(loop.graphs) == 1, "a periodic solution is one of one nonlinearity")
            require_one_equilibrium(loop, curve)
            _require_stable_near_0(loop)
        return AROUND + ORBIT * orbit
    if inner:
        require(document.theorem in ("local-circle", "local-popov"), "the theorem is unknown for regions")
        _require_level_set(loop, document)
        if "energy" in document.proof:
            said = SEEN if "Dsigmaw" in document.proof else DISTURBED
            return said.format(text(document.proof["energy"]))
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
        for start, end, piece in pieces_of(graph, Fraction(sign)):
            left = Fraction(0) if start is None else max(start, Fraction(0))
            right = reach if end is None else min(end, reach)
            if left >= right:
                continue
            own = (sign * piece).integral()
            own += start_value - own(to_fmpq(left))
            start_value = own(to_fmpq(right))
            rest = 2 * own - to_fmpq(least) * X * X
            if not nonnegative_between(rest if above else -rest, left, right):
                return False
    return True


def _with_integrals(
    loop: Loop, P: fmpq_mat, given: Sequence[object]
) -> tuple[fmpq_mat, fmpq_mat, list[tuple[fmpq_mat, Fraction]]]:
    """A form below ``V`` with its integrals, what they take from ``-V'``, and the strips where they are bounded."""
    (n, m), strips = loop.sizes, list[tuple[fmpq_mat, Fraction]]()
    least, taken = P + 0 * P, fmpq_mat(n + m, n + m)
    for entry in given:
        one = record(entry, "channel", "theta", "reach", "least")
        i, theta = count(one["channel"], least=1) - 1, number(one["theta"])
        reach, bound = number(one["reach"]), number(one["least"])
        require(i < m and reach > 0 and not loop.discrete, "an integral does not fit")
        require(all(loop.D[i, j] == 0 for j in range(m)), "sigma of a channel with an integral depends on phi")
        graph = loop.graphs[i]
        require(graph.reach is None, "an integral is one of a known nonlinearity")
        require(_integral_bounded(graph, bound, reach, above=theta >= 0), "an integral is not bounded")
        row = fmpq_mat([loop.Y.tolist()[i][:n]])
        least += to_fmpq(theta * bound) * (row.transpose() * row)
        strips.append((row, reach))
        half = fmpq_mat([[int(j == n + i) for j in range(n + m)]]).transpose() * (row * loop.F)
        taken += to_fmpq(theta) * (half + half.transpose())
    return least, taken, strips


def _require_level_set(loop: Loop, document: Document) -> fmpq_mat:
    """Check that ``V`` falls on ``V <= 1``, and that the terms used for it count there; ``P``."""
    level, spiral = document.theorem == "local-popov", document.theorem == "planar"
    disturbed = not level and not spiral and "energy" in document.proof
    into = ("Bw", "energy", *(["Dsigmaw"] if "Dsigmaw" in document.proof else []))
    keys = ("integrals",) if level else ("turns",) if spiral else into if disturbed else ()
    found = record(document.proof, "method", "P", *keys)
    method = "level-set" if level else "spiral" if spiral else "ellipsoid"
    require(found["method"] == method, "the method does not fit the theorem")
    n, m = loop.sizes
    P = symmetric(found["P"], n)
    least, taken, strips = _with_integrals(loop, P, listed(found["integrals"]) if level else ())
    M = -loop.form(P) - taken
    moves = _Moves.read(loop, found) if disturbed else None
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
            require(moves is None or not moves.sees(i), "w moves sigma beyond the interval of a sector")
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
            if moves is not None:
                moves.add(i, weight, (to_fmpq(high) * own - phi, to_fmpq(high)), (phi - point, -to_fmpq(outer)))
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
    if moves is not None:
        M = moves.beside(loop, P, M)
    _require_definite(M, "V is not shown to fall")
    return P


def _require_everywhere(loop: Loop, document: Document) -> None:
    """Check ``V = x'P x + 2 sum theta_i int phi_i``: ``V >= 0``, radially unbounded, and it falls unless ``x = 0``."""
    (n, m), found = loop.sizes, record(document.proof, "method", "P", "least")
    require(found["method"] == "everywhere" and not loop.discrete, "the method does not fit the theorem, or the time")
    given = record(document.multiplier, "lambda", "theta", "inverse")
    weights, theta, inverse = (numbers(given[name]) for name in ("lambda", "theta", "inverse"))
    P, least = symmetric(found["P"], n), numbers(found["least"])
    sizes = all(len(side) == m and min(side) >= 0 for side in (weights, theta, inverse, least))
    require(sizes, "there are not m multipliers >= 0 each")
    grows, M, C = P + 0 * P, -loop.form(P), fmpq_mat([row[:n] for row in loop.Y.tolist()])
    for i, graph in enumerate(loop.graphs):
        signed = graph.reach == 0
        require(graph.reach is None or signed, "a nonlinearity is not known everywhere")
        require(not signed or inverse[i] * graph.sector[1] <= 1, "phi may be steeper than the multiplier says")
        for sign in () if signed else (1, -1):  # sign phi(sign x) > 0 for x > 0, at the cuts, too
            require(all(_at(graph, cut) != 0 for cut in graph.cuts if cut != 0), "phi has another zero")
            for start, end, piece in pieces_of(graph, Fraction(sign)):
                left, size = max(start or Fraction(0), Fraction(0)), sign * piece
                if end is None or left < end:
                    require(positive_inside(size, left, end), "phi has not the sign of sigma")
                    bounded = nonnegative_between(X - to_fmpq(inverse[i]) * size, left, end)
                    require(bounded, "phi is steeper than the multiplier says")
        own, phi = fmpq_mat([loop.Y.tolist()[i]]), fmpq_mat([[int(j == n + i) for j in range(n + m)]])
        row = fmpq_mat([C.tolist()[i]])
        if theta[i] > 0:
            require(all(loop.D[i, j] == 0 for j in range(m)), "sigma of a channel with an integral depends on phi")
            grows += row.transpose() * row
        beside = to_fmpq(theta[i]) * (row * loop.F) + to_fmpq(weights[i]) * (own - to_fmpq(inverse[i]) * phi)
        product = phi.transpose() * beside
        M -= product + product.transpose() + to_fmpq(least[i]) * (phi.transpose() * phi)
    for form in (P, M):  # all roots are real, and none is below 0 if these signs are
        signs = form.charpoly().coeffs()
        require(all(c * (-1) ** (form.nrows() - k) >= 0 for k, c in enumerate(signs)), "V, or its fall, is negative")
    _require_definite(grows, "V is not shown to go to infinity")
    every = zip(least, weights, inverse, strict=True)  # what falls with phi^2, or with sigma phi
    known = [i for i, (square, weight, slack) in enumerate(every) if square > 0 or (weight > 0 and slack == 0)]
    _require_no_phi(
        loop, stacked(M, fmpq_mat([[int(j == n + i) for j in range(n + m)] for i in known])) if known else M
    )
    A, rows = fmpq_mat([row[:n] for row in loop.F.tolist()]), C
    for _ in range(n - 1):
        rows = stacked(C, rows * A)
    require(rows.rank() == n, "sigma does not see all states")


def _require_no_phi(loop: Loop, equations: fmpq_mat) -> None:
    """Check that ``phi = 0`` along every solution on which linear equations of ``(x, phi)`` hold at all times.

    Of the ``z = (x, phi)`` that solve them those are kept for which ``x' = F z`` is the state of one that was kept.
    """
    n, Z = loop.sizes[0], null_space(equations)
    while Z.ncols():
        states = fmpq_mat(Z.tolist()[:n])
        away = null_space(states.transpose()).transpose()  # rows that vanish on the states
        left = Z * null_space(away * loop.F * Z) if away.nrows() else Z
        if left.ncols() == Z.ncols():
            break
        Z = left
    require(not any(v != 0 for row in Z.tolist()[n:] for v in row), "V is not said to fall where phi is not 0")


def _at(graph: Graph, cut: Fraction) -> fmpq:
    """``phi`` at one of its cuts."""
    return graph.pieces[graph.cuts.index(cut)](to_fmpq(cut))


def _require_stable_near_0(loop: Loop) -> None:
    """Check that the linear loop with the slope at 0, which is no corner, has its poles in the left half plane."""
    graph = loop.graphs[0]
    require(Fraction(0) not in graph.cuts, "the nonlinearity has a corner at 0")
    slope = graph.pieces[sum(cut < 0 for cut in graph.cuts)].derivative()(fmpq(0))
    A = fmpq_mat([[row[j] + row[2] * slope * loop.Y[0, j] for j in (0, 1)] for row in loop.F.tolist()])
    require(bool(A[0, 0] + A[1, 1] < 0) and bool(A.det() > 0), "0 is not shown to attract what is near")


class _Moves:
    """What ``w`` does: ``x' = F z + G w``, ``sigma = Y z + S w``, and the part of the terms that depends on it."""

    def __init__(self, G: fmpq_mat, S: fmpq_mat, energy: Fraction, size: int) -> None:
        self.G, self.S = G, S
        self.mixed = fmpq_mat(size, G.ncols())  # -sum weight (a'd + b'c) of terms (a z + c w)(b z + d w)
        self.alone = diagonal([1 / energy] * G.ncols())  # 1/energy - sum weight (c'd + d'c)

    @classmethod
    def read(cls, loop: Loop, found: Mapping[str, object]) -> _Moves:
        """From the proof."""
        (n, m), energy = loop.sizes, number(found["energy"])
        rows = [numbers(row) for row in listed(found["Bw"])]
        p = len(rows[0]) if rows else 0
        seen = [numbers(row) for row in listed(found["Dsigmaw"])] if "Dsigmaw" in found else [[Fraction(0)] * p] * m
        require(
            len(rows) == n and len(seen) == m and p > 0, "Bw has not a row for each state, or Dsigmaw for a channel"
        )
        require(all(len(row) == p for row in (*rows, *seen)), "rows of what w moves have different lengths")
        require(energy > 0, "the energy is not positive")
        G, S = (fmpq_mat([[to_fmpq(v) for v in row] for row in side]) for side in (rows, seen))
        return cls(G, S, energy, n + m)

    def sees(self, channel: int) -> bool:
        """Whether ``w`` moves ``sigma`` of a channel."""
        return any(v != 0 for v in self.S.tolist()[channel])

    def add(self, channel: int, weight: Fraction, one: tuple[fmpq_mat, fmpq], other: tuple[fmpq_mat, fmpq]) -> None:
        """Take a term ``2 weight (a z + first s w)(b z + second s w)`` of a channel, ``s`` its row, off."""
        row, w = fmpq_mat([self.S.tolist()[channel]]), to_fmpq(weight)
        (a, first), (b, second) = one, other
        self.mixed -= w * (second * (a.transpose() * row) + first * (b.transpose() * row))
        self.alone -= 2 * w * first * second * (row.transpose() * row)

    def beside(self, loop: Loop, P: fmpq_mat, M: fmpq_mat) -> fmpq_mat:
        """``|w|^2/energy - V' - terms`` as a form in ``(x, phi, w)``."""
        if loop.discrete:
            mixed = self.mixed - loop.F.transpose() * P * self.G
            alone = self.alone - self.G.transpose() * P * self.G
        else:
            mixed, alone = self.mixed - stacked(P * self.G, fmpq_mat(loop.sizes[1], self.G.ncols())), self.alone
        return stacked(_beside(M, mixed), _beside(mixed.transpose(), alone))


def _require_growth(loop: Loop, document: Document) -> None:
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
    turned = Loop(F=loop.F * T, Y=loop.Y, D=loop.D, discrete=loop.discrete, graphs=loop.graphs)
    corner = fmpq_mat(
        [[to_fmpq(weights[i - n]) if i == j >= n else fmpq(0) for j in range(n + m)] for i in range(n + m)]
    )
    _require_definite(turned.form(Q, rate) + corner, "V is not shown to grow")


def _ends(value: object) -> tuple[Cut, Cut]:
    low, high = listed(value)
    return None if low == "-inf" else number(low), None if high == "inf" else number(high)


def _by_signs(loop: Loop, document: Document, *, inner: bool) -> str:
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
        (pieces_of(graph, to_fraction(loop.Y[i, 0])), loop.F[0, 1 + i])
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
                require(all(positive_inside(p, start, top) for p in needed), "0 does not attract all of the interval")
        return f"every motion that starts between {words[0]} and {words[1]} tends to 0"
    require(low is not None or high is not None, "nothing lies beyond")
    for reach, side in ((high, right), (None if low is None else -low, left)):
        if reach is None:
            continue
        for start, end, f in side:
            if loop.discrete and (end is None or end > reach):
                beyond = max(start, reach)
                grows = nonnegative_between(f - X, beyond, end) or nonnegative_between(-f - X, beyond, end)
                require(grows, "|f(x)| >= |x| is not shown")
            elif start < reach and (end is None or end >= reach):
                require(loop.discrete or bool(f(to_fmpq(reach)) >= 0), "a solution may come back")
    return f"no motion that starts at or beyond {words[0]} or {words[1]} tends to 0"


def _over(low: Cut, high: Cut, start: Cut, end: Cut) -> bool:
    """Whether an interval covers a smaller one."""
    return (low is None or (start is not None and low <= start)) and (high is None or (end is not None and end <= high))


def _require_spiral(loop: Loop, document: Document) -> None:
    """Check that turn after turn is crossed inwards, to an end within the ellipsoid, around one equilibrium."""
    require(len(loop.graphs) == 1, "a spiral is about one nonlinearity")
    P = _require_level_set(loop, document)
    turns = [curve_of(loop, value) for value in listed(document.proof["turns"])]
    require(1 <= len(turns) <= MOST_TURNS, "there are no turns, or too many")
    first, before = turns[0], None
    reaches: list[Fraction] = []
    for turn in turns:
        at = first.start[0] * turn.start[0] + first.start[1] * turn.start[1]
        factor = to_fraction(at / (first.start[0] ** 2 + first.start[1] ** 2))
        require(bool(turned(first.start, turn.start) == 0) and factor > 0, "a turn starts on another ray")
        require(turn.sense == first.sense and turn.factor < 1, "a turn does not wind inwards as the first one does")
        require(before is None or factor >= before, "a turn starts within the end of the one before")
        before = factor * turn.factor
        reaches += [factor, before]
        require_crossed(loop, turn.arcs, first.sense)
    require_crossed(loop, (first.along_ray(min(reaches), max(reaches)),), first.sense)
    z = fmpq_mat([[to_fmpq(reaches[-1]) * v for v in first.start]])
    require(bool((z * P * z.transpose())[0, 0] <= 1), "the last turn ends outside of the ellipsoid")
    require_one_equilibrium(loop, first)
