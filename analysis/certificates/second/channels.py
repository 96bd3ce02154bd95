r"""Several nonlinearities, checked again: the loop shifted by the lower bounds, and a Schur complement in balls.

With ``phi = L sigma + psi``, ``psi_i`` in ``[0, w_i]``, and ``sigma = C x + D mu`` the loop is ``x' = A~ x - B~ psi``
with ``sigma = C~ x - D~ psi``, ``E = (1 + D L)^{-1}``, ``C~ = E C``, ``D~ = E D``, ``A~ = A - B L C~``, ``B~ = B (1 - L
D~)``.  The form ``V = x'P x + 2 sum theta_i int_0^{sigma_i} phi_i`` is ``x'Q x + 2 sum theta_i int psi_i``, where ``Q =
P + C' L Theta C``.  With ``Pi`` for the form of the multiplier in ``(sigma, psi)`` and ``N = C~' (Pi_12 - Pi_11 D~) +
A~' C' Theta``, what has to be positive definite is

.. math::

    \begin{pmatrix} -(\tilde A'Q + Q\tilde A) - \tilde C'\Pi_{11}\tilde C & Q\tilde B - N \\ \cdot &
    \Pi_{21}\tilde D + \tilde D'\Pi_{12} - \Pi_{22} - \tilde D'\Pi_{11}\tilde D + \Theta C\tilde B + \tilde B'C'\Theta
    \end{pmatrix},

in discrete time, ``Theta = 0``, with ``Q - A~'Q A~``, ``A~'Q B~`` and ``- B~'Q B~`` for the terms of ``Q``.  ``V > 0``
if ``Q + C' Theta^- W C > 0``, ``Theta^-`` the negative part.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise, product

from flint import arb, arb_mat, fmpq, fmpq_mat, fmpq_poly, fmpz

from lure.analysis.certificates.second import classes as claims
from lure.analysis.certificates.second.classes import Nonlinearities, read_nonlinearities
from lure.analysis.certificates.second.frequencies import (
    Matrices,
    read_multiplier,
    require_frequencies,
    require_vertices,
)
from lure.analysis.certificates.second.matrix import BITS, LARGEST_EXPONENT, positive_definite, triangle
from lure.analysis.certificates.second.numerics import (
    X,
    ball,
    even_odd,
    half_plane_counts,
    positive_from_zero,
    to_fmpq,
    to_fraction,
    working_precision,
)
from lure.analysis.certificates.second.order import require_positive_on_orders
from lure.analysis.certificates.second.reading import (
    Document,
    NotShown,
    count,
    flag,
    listed,
    mapping,
    number,
    numbers,
    record,
    require,
    tick,
)
from lure.analysis.certificates.second.systems import mapped

LARGEST, MOST_VERTICES, MOST_BOXES, LONGEST, SQUARINGS = 400, 10, 20_000, 10_000, 80


@dataclass(frozen=True, kw_only=True)
class Asked:
    """The plant and the classes of a certificate; bounds are those of ``phi_i(sigma)/sigma``.

    ``repeated`` says of each channel which is the first with the same nonlinearity.
    """

    A: fmpq_mat
    B: fmpq_mat
    C: fmpq_mat
    D: fmpq_mat
    discrete: bool
    nonlinearities: tuple[Nonlinearities, ...]
    repeated: tuple[int, ...]

    @property
    def bounds(self) -> list[tuple[Fraction, Fraction]]:
        """Finite bounds of every channel.

        Raises
        ------
        NotShown
            A channel has none.
        """
        ends = [nonlinearities.ends for nonlinearities in self.nonlinearities]
        if any(low is None or high is None or low >= high for low, high in ends):
            raise NotShown("a channel has no finite bounds")
        return [(low, high) for low, high in ends if low is not None and high is not None]


def shown(document: Document) -> str:
    """The sentence that a certificate about several nonlinearities shows.

    Parameters
    ----------
    document : Document
        The parts of the certificate.

    Raises
    ------
    NotShown
        It shows nothing.
    """
    asked = _read(document)
    require(document.nonlinearity is None, "no nonlinearity is given beside several classes")
    if document.verdict == "PROVED":
        _proved(document, asked)
        return claims.ATTRACTS
    require(document.verdict == "REFUTED", "the verdict is neither PROVED nor REFUTED")
    require(document.theorem == "counterexample" and not document.multiplier, "a refutation is a counterexample")
    return _refuted(document, asked)


def _read(document: Document) -> Asked:
    found = record(document.system, "kind", "time", "A", "B", "C", "D")
    require(found["kind"] == "multivariable", "the kind of system is unknown for several nonlinearities")
    require(found["time"] in ("continuous", "discrete"), "the time is unknown")
    rows = {name: [numbers(row) for row in listed(found[name])] for name in "ABCD"}
    n, m = len(rows["A"]), len(rows["D"])
    require(0 < n <= LARGEST and 0 < m <= LARGEST, "there are no states or channels, or too many")
    for name, height, width in (("A", n, n), ("B", n, m), ("C", m, n), ("D", m, m)):
        fits = len(rows[name]) == height and all(len(row) == width for row in rows[name])
        require(fits, f"{name} does not fit the other matrices")
    stated = record(document.nonlinearities, "channels", "repeated")
    given = [mapping(one) for one in listed(stated["channels"])]
    repeated = _repeated(stated["repeated"], len(given))
    require(len(given) == m, "there is not one class for each channel")
    same = all(dict(given[first]) == dict(one) for first, one in zip(repeated, given, strict=True))
    require(same, "one nonlinearity has one class")
    sides = {name: fmpq_mat([[to_fmpq(v) for v in row] for row in side]) for name, side in rows.items()}
    return Asked(
        **sides,
        discrete=found["time"] == "discrete",
        nonlinearities=tuple(map(read_nonlinearities, given)),
        repeated=repeated,
    )


def _repeated(stated: object, m: int) -> tuple[int, ...]:
    """For each channel the first one with the same nonlinearity: its own, or stated for all or block after block."""
    if isinstance(stated, bool):
        return (0,) * m if stated else tuple(range(m))
    firsts: list[int] = []
    for entry in listed(stated):
        size = count(entry, least=1)
        require(len(firsts) + size <= m, "more channels have the same nonlinearity than there are")
        firsts += [len(firsts)] * size
    require(len(firsts) == m, "the channels with the same nonlinearity do not add up")
    return tuple(firsts)


def _require_windows(document: Document, asked: Asked) -> None:
    """Forms of ``T`` samples: ``V(xi+) - V(xi) + sum w' M w < 0``, and ``w' M w > 0`` on the order cones."""
    found, proof = record(document.multiplier, "windows", "odd"), record(document.proof, "method", "P", "exponent")
    require(proof["method"] == "matrix" and asked.discrete, "forms of several samples: by matrices, in discrete time")
    firsts = sorted(set(asked.repeated))
    windows = [[numbers(row) for row in listed(one)] for one in listed(found["windows"])]
    odd = [flag(one) for one in listed(found["odd"])]
    require(len(firsts) == len(windows) == len(odd), "there is not one form for each nonlinearity")
    n, m, T = asked.A.nrows(), asked.D.nrows(), len(windows[0]) // (2 * asked.repeated.count(0))
    require(T > 0 and _acyclic(asked.D), "there are no samples, or D has a cycle of channels")
    slopes = [nonlinearities.slope for nonlinearities in asked.nonlinearities]
    ends = [one for one in slopes if one is not None and all(isinstance(end, Fraction) for end in one)]
    require(len(ends) == m, "a channel has no finite slope bounds")
    low, high = ([Fraction(one[side]) for one in ends] for side in (0, 1))
    closed = _closed(asked, low)
    require(closed is not None and half_plane_stable(closed), "the loop with the least slopes is not stable")
    size, order = n + m * T, n + m * (T - 1)
    unit = fmpq_mat([[int(i == j) for j in range(size)] for i in range(size)])
    phi = [_cut(unit, n + m * t, m) for t in range(T)]
    x, sigma, later = _cut(unit, 0, n), list[fmpq_mat](), unit
    for t in range(T):
        sigma.append(asked.C * x - asked.D * phi[t])
        x = asked.A * x - asked.B * phi[t]
        later = _stacked(x, _cut(unit, n + m, order - n)) if t == 0 else later
    total = fmpq_mat(size, size)
    for first, rows, only_odd in zip(firsts, windows, odd, strict=True):
        block = [i for i in range(m) if asked.repeated[i] == first]
        given = asked.nonlinearities[first]
        require(len(rows) == 2 * T * len(block), "a form has another number of samples")
        require(not (given.time_varying or given.rough), "the nonlinearities are fixed in time and locally Lipschitz")
        require(given.odd or not only_odd, "a form is for odd nonlinearities")
        require_positive_on_orders(rows, odd=only_odd)
        M = fmpq_mat([[to_fmpq(rows[max(i, j)][min(i, j)]) for j in range(len(rows))] for i in range(len(rows))])
        u = [_cut(phi[t], i, 1) - to_fmpq(low[i]) * _cut(sigma[t], i, 1) for t in range(T) for i in block]
        v = [to_fmpq(high[i]) * _cut(sigma[t], i, 1) - _cut(phi[t], i, 1) for t in range(T) for i in block]
        w = fmpq_mat([[line[0, j] for j in range(size)] for line in (*u, *v)])
        total += w.transpose() * M * w
    exponent = count(proof["exponent"], least=-LARGEST_EXPONENT)
    require(exponent <= LARGEST_EXPONENT, "the exponent of P is too large")
    half, scale = triangle(proof["P"], order), to_fmpq(Fraction(2)) ** -exponent
    P = fmpq_mat([[fmpq(half[max(i, j)][min(i, j)]) * scale for j in range(order)] for i in range(order)])
    now = _cut(unit, 0, order)
    falls = now.transpose() * P * now - later.transpose() * P * later - total
    for bits in BITS:
        with working_precision(bits):
            if positive_definite(arb_mat(falls)):
                return
    raise NotShown("the matrix of the inequality is not shown to be positive definite")


def _cut(M: fmpq_mat, top: int, rows: int) -> fmpq_mat:
    return fmpq_mat([[M[top + i, j] for j in range(M.ncols())] for i in range(rows)])


def _acyclic(D: fmpq_mat) -> bool:
    """Whether no product of entries of ``D`` leads from a channel back to it: the pattern is nilpotent."""
    m = D.nrows()
    pattern = fmpq_mat([[int(D[i, j] != 0) for j in range(m)] for i in range(m)])
    return bool(pattern**m == fmpq_mat(m, m))


def half_plane_stable(closed: fmpq_mat) -> bool:
    """Whether every eigenvalue of a loop in discrete time is strictly inside the unit circle."""
    p = closed.charpoly()
    inner = mapped(p, p.degree())
    counts = half_plane_counts(inner)
    return inner.degree() == closed.nrows() and (counts.right, counts.axis) == (0, 0)


def _proved(document: Document, asked: Asked) -> None:
    if document.theorem == "order-cones":
        _require_windows(document, asked)
        return
    if mapping(document.proof).get("method") == "determinant":
        _over_frequencies(document, asked)
        return
    if document.theorem == "constant-gains":
        _require_gains(document, asked)
        return
    m, (kind, _, theorem) = asked.D.nrows(), document.theorem.rpartition("-")
    popov, full = theorem == "popov", kind == "full-block"
    require(theorem in ("circle", "popov") and (full or kind == "diagonal"), "the theorem is not one for channels")
    names = {"Pi" if full else "lambda"} | ({"theta"} if popov else set())
    given = record(document.multiplier, *names, *(("N",) if full and "N" in document.multiplier else ()))
    theta = numbers(given["theta"]) if popov else [Fraction(0)] * m
    require(len(theta) == m, "the multipliers are not one for each channel")
    require(
        not any(nonlinearities.rough for nonlinearities in asked.nonlinearities),
        "the theorem is for locally Lipschitz nonlinearities",
    )
    require(not (popov and asked.discrete), "Popov's criterion is for continuous time")
    for i, nonlinearities in enumerate(asked.nonlinearities):
        state_only = all(asked.D[i, j] == 0 for j in range(m))
        require(
            theta[i] == 0 or (state_only and not nonlinearities.time_varying), "Popov's term does not fit its channel"
        )
    proof = record(document.proof, "method", "P", "exponent")
    require(proof["method"] == "matrix", "the method does not fit the theorem")
    exponent = count(proof["exponent"], least=-LARGEST_EXPONENT)
    require(exponent <= LARGEST_EXPONENT, "the exponent of P is too large")
    shifted = _shifted(asked, asked.bounds)
    Pi, needed = _full_block(given, asked) if full else (_diagonal_multiplier(numbers(given["lambda"]), asked), [])
    rows = triangle(proof["P"], asked.A.nrows())
    for bits in BITS:
        with working_precision(bits):
            forms = (*_forms(asked, shifted, (rows, exponent), Pi, theta), *map(arb_mat, needed))
            if all(map(positive_definite, forms)):
                return
    raise NotShown("V, the multiplier or the matrix of the inequality is not shown to be positive definite")


def _require_gains(document: Document, asked: Asked) -> None:
    """Check boxes of constant gains: at each frequency Bernstein's coefficients lie in one open half-plane."""
    record(document.multiplier)
    proof, bounds = record(document.proof, "method", "tree"), asked.bounds
    require(proof["method"] == "hull", "the method does not fit the theorem")
    require(all(one.linear for one in asked.nonlinearities), "a class is not one of constant gains")
    require(len(bounds) <= MOST_VERTICES, "there are too many channels for boxes of gains")
    firsts = sorted(set(asked.repeated))
    of = [firsts.index(first) for first in asked.repeated]  # which gain of the box a channel has
    least = [bounds[first][0] for first in firsts]
    det, p = _characteristic(asked, [least[j] for j in of])
    n, counts = asked.A.nrows(), half_plane_counts(p)
    require(p.degree() == n and counts.axis == counts.right == 0, "the loop at the lower bounds is unstable")
    signs, known = (det > 0, p[n] > 0), dict[tuple[Fraction, ...], tuple[fmpq, fmpq_poly]]()
    pending, boxes = [(proof["tree"], least, [bounds[first][1] for first in firsts])], 0
    while pending:
        tick()
        node, low, high = pending.pop()
        found, boxes = mapping(node), boxes + 1
        require(boxes <= MOST_BOXES, "there are too many boxes")
        if "split" in found:
            which, value = listed(record(found, "split", "parts")["split"])
            j, at, parts = count(which), number(value), listed(found["parts"])
            require(len(parts) == 2 and j < len(low) and low[j] < at < high[j], "a box is not split into two")
            left, right = list(high), list(low)
            left[j] = right[j] = at
            pending += [(parts[0], low, left), (parts[1], right, high)]
            continue
        record(found, "omega", "directions")
        omega = [number(v) for v in listed(found["omega"])]
        directions = [numbers(pair) for pair in listed(found["directions"])]
        ends: list[Fraction | None] = [Fraction(0), *omega, None]
        require(all(a < b for a, b in pairwise([Fraction(0), *omega])), "the frequencies are not in order")
        require([len(pair) for pair in directions] == [2] * (len(ends) - 1), "each part has one direction")
        hull = dict[tuple[int, ...], tuple[fmpq, fmpq_poly]]()  # sums over the corners that differ by turns of one gain
        for upper in product((False, True), repeat=len(of)):
            corner = tuple(high[j] if up else low[j] for j, up in zip(of, upper, strict=True))
            if corner not in known:
                known[corner] = _characteristic(asked, corner)
            key = tuple(sum(up for i, up in zip(of, upper, strict=True) if i == j) for j in range(len(low)))
            before = hull.get(key, (fmpq(0), fmpq_poly([0])))
            hull[key] = before[0] + known[corner][0], before[1] + known[corner][1]
        for det, p in hull.values():
            require(p.degree() == n and (det > 0, p[n] > 0) == signs, "a leading coefficient changes its sign")
            for (a, b), (real, imaginary) in zip(pairwise(ends), directions, strict=True):
                even, odd = (half(X * X) for half in even_odd(p))
                line = to_fmpq(real) * even + to_fmpq(imaginary) * X * odd  # Re u* (e + i w o)
                require(_positive_between(line, a, b), "the vertices are not shown to lie in a half-plane")


def _characteristic(asked: Asked, gains: Sequence[Fraction]) -> tuple[fmpq, fmpq_poly]:
    """``det(1 + D G)``, and it times ``det(s - A + B G (1 + D G)^-1 C)``; in discrete time ``z = (1 + s)/(1 - s)``."""
    closed = _closed(asked, gains)
    if closed is None:
        raise NotShown("with some of the gains the loop has no solution")
    det = (_diagonal([Fraction(1)] * len(gains)) + asked.D * _diagonal(gains)).det()
    p = closed.charpoly()
    return det, det * (mapped(p, p.degree()) if asked.discrete else p)


def _positive_between(p: fmpq_poly, low: Fraction | None, high: Fraction | None) -> bool:
    """Whether ``p > 0`` on ``[low, high]``; None: on ``[low, inf)``.  By ``x = (low + high y)/(1 + y)``, ``y >= 0``."""
    a = to_fmpq(low or Fraction(0))
    if high is None:
        return positive_from_zero(p(X + a))
    b, whole, power = to_fmpq(high), fmpq_poly([0]), fmpq_poly([1])
    for c in reversed(p.coeffs()):
        whole, power = whole * (X * b + a) + c * power, power * (X + 1)
    return bool(p(b) > 0) and positive_from_zero(whole)


def _diagonal_multiplier(weights: Sequence[Fraction], asked: Asked) -> fmpq_mat:
    """``2 sum lambda_i psi_i (w_i sigma_i - psi_i)``."""
    require(len(weights) == asked.D.nrows(), "the multipliers are not one for each channel")
    require(all(v >= 0 for v in weights), "a weight is negative")
    side = _diagonal([v * (high - low) for v, (low, high) in zip(weights, asked.bounds, strict=True)])
    return _joined(side * 0, side, _diagonal([-2 * v for v in weights]))


def _full_block(given: Mapping[str, object], asked: Asked) -> tuple[fmpq_mat, list[fmpq_mat]]:
    """``Pi`` for ``(sigma, psi)``, and what has to be positive definite for its form to be nonnegative in the class."""
    m, one = asked.D.nrows(), _diagonal([Fraction(1)] * asked.D.nrows())
    require(m <= MOST_VERTICES, "there are too many channels for full-block multipliers")
    shift, width = _diagonal([low for low, _ in asked.bounds]), [high - low for low, high in asked.bounds]
    move = _joined(one, 0 * one, one, lower_left=shift)  # phi = psi + l sigma
    Pi = move.transpose() * _symmetric(given["Pi"], 2 * m) * move
    if "N" not in given:
        require(all(Pi[i, i] <= 0 for i in range(m, 2 * m)), "the form is not concave in each gain")
        views = [_stacked(one, _diagonal(list(ends))) for ends in product(*((Fraction(0), w) for w in width))]
        return Pi, [view.transpose() * Pi * view for view in views]
    shares = _diagonal([1 / w for w in width])
    view = _joined(shares, shares, 0 * one, lower_left=one)  # (sigma, psi) of (psi, w sigma - psi)
    inner, parts = view.transpose() * Pi * view, listed(given["N"])
    patterns = [[Fraction(s) for s in (1, *rest)] for rest in product((1, -1), repeat=m - 1)]
    require(len(parts) == len(patterns), "N has not one part for each pattern of signs")
    needed = []
    for signs, part in zip(patterns, parts, strict=True):
        N, turn = _symmetric(part, 2 * m), _diagonal([*signs, *signs])
        require(all(v >= 0 for v in N.entries()), "an entry of N is negative")
        needed.append(turn * inner * turn - N)
    return Pi, needed


def _symmetric(value: object, order: int) -> fmpq_mat:
    rows = [numbers(row) for row in listed(value)]
    require([len(row) for row in rows] == [*range(1, order + 1)], "a lower triangle is missing")
    return fmpq_mat([[to_fmpq(rows[max(i, j)][min(i, j)]) for j in range(order)] for i in range(order)])


def _stacked(above: fmpq_mat, below: fmpq_mat) -> fmpq_mat:
    return fmpq_mat([*above.tolist(), *below.tolist()])


def _joined(first: fmpq_mat, side: fmpq_mat, last: fmpq_mat, *, lower_left: fmpq_mat | None = None) -> fmpq_mat:
    """Four blocks; the lower left is that above it, turned, unless it is given."""
    under = side.transpose() if lower_left is None else lower_left
    left, right = _stacked(first, under).tolist(), _stacked(side, last).tolist()
    return fmpq_mat([[*a, *b] for a, b in zip(left, right, strict=True)])


def _over_frequencies(document: Document, asked: Asked) -> None:
    """The inequality over all frequencies, of the circle criterion, Popov's, or with kernels."""
    m = asked.D.nrows()
    record(document.proof, "method")
    require(not asked.discrete, "over frequencies it is decided in continuous time only")
    odd = [one.odd for one in asked.nonlinearities]
    given = read_multiplier(document.theorem, document.multiplier, odd, asked.repeated)
    bounds = list[tuple[Fraction, Fraction]]()
    for i, one in enumerate(asked.nonlinearities):
        coupled = i in given.moved
        low, high = one.slope if coupled and one.slope is not None else one.ends
        if not (isinstance(low, Fraction) and isinstance(high, Fraction) and low < high):
            raise NotShown("a channel has no finite bounds")
        bounds.append((low, high))
        require(not coupled or one.slope is not None, "a channel with kernels has no slope bounds")
        require(not one.rough, "the theorem is for locally Lipschitz nonlinearities")
        constant = given.theta[i] == 0 and not coupled
        require(constant or not one.time_varying, "a nonlinearity depends on time, its multiplier must not")
        state_only = all(asked.D[i, j] == 0 for j in range(m))
        require(given.theta[i] == 0 or state_only, "Popov's term does not fit its channel")
    shifted, widths = _shifted(asked, bounds), [high - low for low, high in bounds]
    require_frequencies(shifted, asked.C, widths, given)
    if document.theorem == "matrix-zames-falb" and _cyclic(asked.D):
        for one, (low, high) in zip(asked.nonlinearities, bounds, strict=True):
            require(one.slopes_within(low, high), "D has a cycle, and a slope is outside the bounds")
        require_vertices(shifted[3], widths)


def _cyclic(D: fmpq_mat) -> bool:
    """Whether channels determine each other in a cycle: the pattern of ``D`` is not nilpotent."""
    m = D.nrows()
    pattern = fmpq_mat([[int(D[i, j] != 0) for j in range(m)] for i in range(m)])
    power = pattern
    for _ in range(m - 1):
        power = power * pattern
    return any(power[i, j] != 0 for i in range(m) for j in range(m))


def _shifted(asked: Asked, bounds: Sequence[tuple[Fraction, Fraction]]) -> Matrices:
    """``A~, B~, C~, D~``."""
    m = asked.D.nrows()
    lower, one = _diagonal([low for low, _ in bounds]), _diagonal([Fraction(1)] * m)
    whole = one + asked.D * lower
    require(bool(whole.det() != 0), "the loop is not well posed at the lower bounds")
    inverse = whole.inv()
    C, D = inverse * asked.C, inverse * asked.D
    return asked.A - asked.B * lower * C, asked.B * (one - lower * D), C, D


def _forms(
    asked: Asked,
    shifted: tuple[fmpq_mat, fmpq_mat, fmpq_mat, fmpq_mat],
    scaled: tuple[list[list[fmpz]], int],
    multiplier: fmpq_mat,
    theta: Sequence[Fraction],
) -> tuple[arb_mat, arb_mat]:
    """At the working precision what has to be positive definite: for ``V``, and for its fall."""
    (rows, exponent), n, m = scaled, asked.A.nrows(), asked.D.nrows()
    A, B, C, D = map(arb_mat, shifted)
    own, unit = arb_mat(asked.C), arb(2) ** -exponent
    P = arb_mat([[arb(rows[max(i, j)][min(i, j)]) * unit for j in range(n)] for i in range(n)])
    low, width = [low for low, _ in asked.bounds], [high - low for low, high in asked.bounds]
    turn, Pi = _balls(theta), arb_mat(multiplier)
    square, cross, last = (_part(Pi, *at, m) for at in ((0, 0), (0, m), (m, m)))
    Q = P + own.transpose() * _balls([t * v for t, v in zip(theta, low, strict=True)]) * own
    least = Q + own.transpose() * _balls([min(t, Fraction(0)) * v for t, v in zip(theta, width, strict=True)]) * own
    moved = A.transpose() * Q
    side, seen = C.transpose() * (cross - square * D), C.transpose() * square * C
    both = cross.transpose() * D
    corner = both + both.transpose() - last - D.transpose() * square * D
    if asked.discrete:
        main, edge, corner = Q - moved * A - seen, moved * B - side, corner - B.transpose() * Q * B
    else:
        rate = turn * own * B
        main, edge = -(moved + moved.transpose() + seen), Q * B - side - A.transpose() * own.transpose() * turn
        corner = corner + rate + rate.transpose()
    top = [[*(main[i, j] for j in range(n)), *(edge[i, j] for j in range(m))] for i in range(n)]
    bottom = [[*(edge[j, i] for j in range(n)), *(corner[i, j] for j in range(m))] for i in range(m)]
    return least, arb_mat([*top, *bottom])


def _part(M: arb_mat, top: int, left: int, m: int) -> arb_mat:
    return arb_mat([[M[top + i, left + j] for j in range(m)] for i in range(m)])


def _diagonal(values: Sequence[Fraction]) -> fmpq_mat:
    return fmpq_mat([[to_fmpq(v) if i == j else to_fmpq(0) for j in range(len(values))] for i, v in enumerate(values)])


def _balls(values: Sequence[Fraction]) -> arb_mat:
    return arb_mat([[ball(v) if i == j else arb(0) for j in range(len(values))] for i, v in enumerate(values)])


def _refuted(document: Document, asked: Asked) -> str:
    """What gains do that are constant, or that jump and repeat."""
    if document.proof.get("method") == "switched-gains":
        _require_growth(document, asked)
        return claims.NO_REST
    proof = record(document.proof, "method", "gains")
    require(proof["method"] == "linear-gains", "the method is unknown for several nonlinearities")
    closed = _closed(asked, _member(proof["gains"], asked))
    return claims.NO_SOLUTION if closed is None else _unstable(closed, discrete=asked.discrete)


def _member(value: object, asked: Asked) -> list[Fraction]:
    gains = numbers(value)
    require(len(gains) == len(asked.nonlinearities), "there is not one gain for each channel")
    require(
        all(nonlinearities.has_gain(g) for nonlinearities, g in zip(asked.nonlinearities, gains, strict=True)),
        "a gain is not in its class",
    )
    require(
        all(gains[first] == g for first, g in zip(asked.repeated, gains, strict=True)), "one nonlinearity, one gain"
    )
    return gains


def _closed(asked: Asked, gains: Sequence[Fraction]) -> fmpq_mat | None:
    G = _diagonal(gains)
    whole = _diagonal([Fraction(1)] * len(gains)) + asked.D * G
    return None if whole.det() == 0 else asked.A - asked.B * G * whole.inv() * asked.C


def _require_growth(document: Document, asked: Asked) -> None:
    """Check ``|tr M^N| > n`` for the matrix ``M`` of one period: it has an eigenvalue outside the unit disc."""
    found = record(document.proof, "method", "gains", "squarings", "bits", *([] if asked.discrete else ["times"]))
    count(found["squarings"])
    count(found["bits"], least=2)
    rows = [_member(one, asked) for one in listed(found["gains"])]
    times = [Fraction(1)] * len(rows) if asked.discrete else numbers(found["times"])
    require(0 < len(rows) == len(times) <= LONGEST and all(t > 0 for t in times), "gains and times do not fit")
    for gains, nonlinearities in zip(zip(*rows, strict=True), asked.nonlinearities, strict=True):
        varying = nonlinearities.time_varying and not nonlinearities.linear
        require(varying or len(set(gains)) == 1, "the class has no gains that vary in time")
    n, closed = asked.A.nrows(), {tuple(row): _closed(asked, row) for row in rows}
    for bits in BITS:
        with working_precision(bits):
            whole, steps = _balls([Fraction(1)] * n), dict[tuple[tuple[Fraction, ...], Fraction], arb_mat]()
            for row, time in zip(rows, times, strict=True):
                matrix = closed[tuple(row)]
                if matrix is None:
                    raise NotShown("with some of the gains the loop has no solution")
                if (tuple(row), time) not in steps:
                    G = arb_mat(matrix)
                    steps[tuple(row), time] = G if asked.discrete else (G * ball(time)).exp()
                whole = steps[tuple(row), time] * whole
            for _ in range(SQUARINGS):
                tick()
                if abs(whole.trace()) > n:
                    return
                whole = whole * whole
    raise NotShown("no eigenvalue outside the unit disc is shown")


def _unstable(closed: fmpq_mat, *, discrete: bool) -> str:
    """The characteristic polynomial, its roots counted by their side."""
    tick()
    p = closed.charpoly()
    require(p.degree() == closed.nrows(), "the characteristic polynomial has another degree")
    inner = mapped(p, p.degree()) if discrete else p
    counts = half_plane_counts(inner)
    at_infinity = p.degree() - inner.degree()  # z = -1
    at_zero = next(i for i in range(inner.degree() + 1) if to_fraction(inner[i]) != 0)
    require(counts.right + counts.axis + at_infinity > 0, "the loop with these gains is asymptotically stable")
    rests = counts.right == 0 and at_infinity == 0 and counts.axis == at_zero
    if rests and at_zero:  # with too few eigenvectors some solution grows like t
        rests = closed.nrows() - (closed - discrete * _diagonal([Fraction(1)] * closed.nrows())).rank() == at_zero
    return claims.OTHER_EQUILIBRIA if rests else claims.NO_REST
