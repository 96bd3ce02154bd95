"""Quadratic forms in what a loop does at one time, with integer coefficients: what a proof assistant is given to test.

All that a loop does at one time is a vector ``z``: of a transfer function a solution ``xi`` of ``den xi = mu`` and its
derivatives (or shifts), ``sigma = num xi``; of a plant in state space ``(x, w)`` with ``w = phi(sigma)``.  State, its
derivative, ``phi`` and ``sigma`` are linear forms in ``z``, and no number of the plant is divided or shifted.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from fractions import Fraction

from lure.analysis.certificates.arithmetic import INF
from lure.record import described, quantity

Vector = list[Fraction]
Matrix = list[Vector]
Term = tuple[int, list[int], list[int]]
MOST_SCALES = 400


@described(frozen=True, kw_only=True)
class Loop:
    """A loop, and the function ``V = x'P x + 2 sum theta_i int phi_i`` that is to fall along its solutions."""

    discrete: bool = quantity("Whether time is discrete")
    now: Matrix = quantity("The state ``x``, as rows over ``z``")
    then: Matrix = quantity("Its derivative, or the next state, as rows over ``z``")
    phi: Matrix = quantity("The values of the nonlinearities, as rows over ``z``")
    sigma: Matrix = quantity("Their arguments, as rows over ``z``")
    bounds: list[tuple[Fraction, Fraction | float]] = quantity("Of each sector; the upper one may be infinite")
    weights: Vector = quantity(
        "Of ``(phi - l sigma)(u sigma - phi)``, of ``(phi - l sigma) sigma`` without an upper bound"
    )
    theta: Vector = quantity("Of the integrals")
    P: Matrix = quantity("Symmetric")
    rows: Matrix = quantity("Over ``x``: the combinations that tend to 0")
    each: bool = quantity(
        "Whether it is shown for each finite upper bound, of one channel, in continuous time", default=False
    )
    rest: tuple[Vector, Vector, int] | None = quantity(
        "Where the loop with the lower gain has an eigenvalue 0 and ``sigma`` is a function of the state: its "
        "eigenvector over ``x``, the left one, and the place that ``rows`` leave out",
        default=None,
    )
    terms: list[tuple[Fraction, Vector, Vector]] = quantity(
        "In place of weights: weights, and pairs of rows over ``z`` whose products are nonnegative",
        default_factory=list,
    )
    block: Matrix = quantity(
        "In place of weights: ``Pi``, symmetric, of ``(sigma_1, phi_1, sigma_2, ..)``", default_factory=list
    )
    odds: bool | None = quantity(
        "Of channels with one nonlinearity, where ``Pi`` is of ``(phi_1 - l sigma_1, .., u sigma_1 - phi_1, ..)`` and "
        "nonnegative for all slopes within the bounds: whether for odd ones alone",
        default=None,
    )
    cones: list[Matrix] = quantity(
        "Where ``Pi`` is not concave in each gain: entries ``>= 0`` for each choice of the signs of ``sigma_2`` and "
        "so on, that of ``sigma_1`` being 1, of the coordinates ``a, b >= 0`` of ``(sigma_i, phi_i) = +-(a (q, p) + "
        "b (s, r))``, ``p/q`` and ``r/s`` the bounds",
        default_factory=list,
    )


@described(frozen=True, kw_only=True)
class Forms:
    """The same with integers, as ``falls_in_time`` and ``falls_by_steps`` of the Coq files take it."""

    size: int = quantity("Numbers in ``z``")
    P: list[list[int]]
    now: list[list[int]] = quantity("Times a whole number, as are ``then`` and ``rows``")
    then: list[list[int]]
    rows: list[list[int]]
    unit: int = quantity("That of ``now`` and ``then``")
    factor: Fraction = quantity("That of ``V``")
    products: list[Term] = quantity("Weights, and the factors of what is nonnegative for the class")
    factors: list[tuple[int, int]] = quantity("By which these two are multiplied")
    low: list[Term] = quantity("A bound below the integrals")
    turn: list[Term] = quantity("Their derivative")
    integrals: list[tuple[int, Fraction, list[int], Fraction]] = quantity(
        "Channel, coefficient ``c`` of its integral, the row of ``q sigma`` over ``now``, and ``q``"
    )
    times: int = quantity("``N``: ``N`` times the fall of ``V`` is above the squares of ``rows``")
    block: list[list[int]] = quantity("``Pi``")
    pairs: list[list[int]] = quantity("The rows that ``Pi`` is about, of which the products are then made")
    own: int = quantity("What these are multiplied by, where it is one number", default=1)
    cones: list[list[list[int]]] = quantity("Upper triangles by rows of twice the forms with entries ``>= 0``")
    beside: int = quantity("For each upper bound: with so many squares of ``phi - l sigma`` beside it", default=0)

    @property
    def small(self) -> list[list[int]]:
        """What tends to 0, in discrete time, as rows over ``z``: of one channel also ``phi - l sigma``, beside a 1."""
        if len(self.rows) == len(self.now):
            return self.now
        psi = [u for _, u, _ in self.products if len(self.products) == 1]
        return [*([int(v) for v in mix(row, self.now)] for row in self.rows), *psi]


def whole(row: Iterable[Fraction], unit: int = 0) -> tuple[list[int], int]:
    """A row times the least common denominator, or a given one, and that."""
    row = list(row)
    q = unit or math.lcm(*(v.denominator for v in row))
    return [v.numerator * (q // v.denominator) for v in row], q


def mix(row: Sequence[Fraction | int], forms: Sequence[Sequence[Fraction | int]]) -> list[Fraction]:
    """``sum_j row_j forms_j``."""
    return [
        sum((Fraction(a) * v for a, v in zip(row, column, strict=True) if a and v), Fraction(0))
        for column in zip(*forms, strict=True)
    ]


def less(row: Vector, factor: Fraction, other: Vector) -> Vector:
    """``row - factor other``."""
    return [a - factor * b for a, b in zip(row, other, strict=True)]


def times(factor: int, terms: Iterable[Term]) -> list[Term]:
    """A form times a whole number."""
    return [(factor * c, u, v) for c, u, v in terms]


def matrix_of(terms: Iterable[Term], size: int) -> list[list[int]]:
    """Upper triangle by rows of twice ``sum c (u z)(v z)``."""
    M = [[0] * (size - i) for i in range(size)]
    for c, u, v in terms:
        for i in range(size):
            if u[i] or v[i]:
                for j in range(i, size):
                    M[i][j - i] += c * (u[i] * v[j] + u[j] * v[i])
    return M


def nonnegative(terms: Iterable[Term], size: int) -> bool:
    """Whether Lagrange's reduction shows that the form is nowhere negative."""
    return semidefinite(matrix_of(terms, size))


def semidefinite(rows: list[list[int]]) -> bool:
    """``psd`` of the Coq files: the same of an upper triangle by rows."""
    before = 1
    while rows:
        (a, *v), *rest = rows
        if a > 0:
            rows = [
                [(a * x - v[i] * y) // before for x, y in zip(row, v[i:], strict=True)] for i, row in enumerate(rest)
            ]
            before = a
        elif a == 0 and not any(v):
            rows = rest
        else:
            return False
    return True


def definite(terms: Iterable[Term], size: int) -> bool:
    """``positive`` of the Coq files: the same in numbers of bounded length, where the form is above 0."""
    return _definite(matrix_of(terms, size))


def apart(terms: Iterable[Term], size: int) -> bool:
    """The same of a form in which the first variable does not stand."""
    (a, *v), *rows = matrix_of(terms, size)
    return a == 0 and not any(v) and _definite(rows)


def _definite(rows: list[list[int]]) -> bool:
    """``definite`` of the Coq files, of an upper triangle by rows."""
    while rows:
        (a, *v), *rest = rows
        if a <= 0:
            return False
        rows = [
            [(2 * (a * x - v[i] * y) >> a.bit_length()) for x, y in zip(row, v[i:], strict=True)]
            for i, row in enumerate(rest)
        ]
        for row in rows:
            row[0] -= len(rest)
    return True


def shortest(terms: Iterable[Term], size: int) -> int:
    """How many binary digits ``definite_by`` of the Coq files may cut off from a form; -1 if it is not seen even so."""
    rows = matrix_of(terms, size)
    low, high = -1, max(row[0] for row in rows).bit_length()
    while high - low > 1:
        k = (low + high) // 2
        held = _definite([[(a >> k) - len(rows), *(v >> k for v in rest)] for a, *rest in rows])
        low, high = (k, high) if held else (low, k)
    return low


def bilinear(P: list[list[int]], left: list[list[int]], right: list[list[int]], sign: int = 1) -> list[Term]:
    """``sum P_ij (left_i z)(right_j z)``."""
    return [(sign, u, [int(v) for v in mix(row, right)]) for row, u in zip(P, left, strict=True)]


def rounded(P: Matrix, bits: int) -> Matrix:
    """``P`` to so many bits, relative to ``sqrt(P_ii P_jj)``; still symmetric."""
    size = [(v[i].numerator.bit_length() - v[i].denominator.bit_length()) // 2 for i, v in enumerate(P)]
    found = [[Fraction(0)] * len(P) for _ in P]
    for i, row in enumerate(P):
        for j, v in enumerate(row[: i + 1]):
            step = Fraction(2) ** (size[i] + size[j] - bits)
            found[i][j] = found[j][i] = round(v / step) * step
    return found


def whole_loop(loop: Loop) -> Forms | None:
    """The forms of a loop with integers; None if an integral has no bound."""
    size, channels = len(loop.now[0]), range(len(loop.phi))
    unit = math.lcm(*(v.denominator for row in (*loop.now, *loop.then) for v in row))
    now, then = ([whole(row, unit)[0] for row in side] for side in (loop.now, loop.then))
    given, factors, halves, pairs, units = [], [], [], [], []
    for i in channels:
        (low, high), phi, sigma = loop.bounds[i], loop.phi[i], loop.sigma[i]
        if 2 * i < len(loop.block) and loop.odds is None:
            own = math.lcm(*(v.denominator for v in (*phi, *sigma)))
            pairs += [whole(sigma, own)[0], whole(phi, own)[0]]
            units += [own, own]
        elif loop.weights:
            (left, a) = whole(less(phi, low, sigma))
            right, b = whole(sigma if high == INF else [-v for v in less(phi, Fraction(high), sigma)])
            given.append((loop.weights[i] / (a * b), left, right))
            factors.append((a, b))
        if loop.theta[i]:
            least = low if loop.theta[i] > 0 else high
            if least == INF:
                return None
            argument, q = whole(sigma)
            row, r = whole(coordinates(sigma, loop.now))
            value, s = whole(phi)
            slope = [int(v) for v in mix(row, then)]
            theta = loop.theta[i]
            bound = (theta * Fraction(least) / q**2, argument, argument)
            halves.append((bound, (2 * theta / (s * unit * r), value, slope), (i, 2 * theta, row, Fraction(unit * r))))
    if loop.odds is not None:
        seen = [less(phi, low, sigma) for (low, _), phi, sigma in zip(loop.bounds, loop.phi, loop.sigma, strict=True)]
        seen += [
            less([Fraction(high) * v for v in sigma], Fraction(1), phi)
            for (_, high), phi, sigma in zip(loop.bounds, loop.phi, loop.sigma, strict=True)
        ]
        units = [math.lcm(*(v.denominator for row in seen for v in row))] * len(seen)
        pairs = [whole(row, units[0])[0] for row in seen]
    for weight, first, second in loop.terms:
        (left, a), (right, b) = whole(first), whole(second)
        given.append((weight / (a * b), left, right))
        factors.append((a, b))
    parts = [w for w, *_ in (*given, *(one[0] for one in halves), *(one[1] for one in halves))]
    parts += [c for *_, (_, c, _, _) in halves]
    inner, *cones = (
        [[v / (a * b) for v, b in zip(row, units, strict=True)] for row, a in zip(M, units, strict=True)]
        for M in (loop.block, *loop.cones)
    )
    entries = [v / unit**2 for row in loop.P for v in row] + [v for M in (inner, *cones) for row in M for v in row]
    common = math.lcm(*(v.denominator for v in (*parts, *entries)))
    shared = math.gcd(*(int(v * common) for v in (*parts, *entries)))
    K = Fraction(common, shared or 1)  # V is written times this
    P = [[int(v * K / unit**2) for v in row] for row in loop.P]
    block = [[int(v * K) for v in row] for row in inner]
    products, below, turn = (
        [(int(w * K), u, v) for w, u, v in side]
        for side in (given, [one[0] for one in halves], [one[1] for one in halves])
    )
    return Forms(
        size=size, P=P, now=now, then=then, rows=[whole(row)[0] for row in loop.rows], unit=unit, factor=K,
        factors=factors,
        products=[*bilinear(block, pairs, pairs), *products], low=below, turn=turn, times=0, block=block, pairs=pairs,
        own=(units or [1])[0],
        cones=[[[int(2 * v * K) for v in row[i:]] for i, row in enumerate(M)] for M in cones],
        integrals=[(i, c * K, row, r) for *_, (i, c, row, r) in halves],
    )  # fmt: skip


def forms(loop: Loop) -> Forms | None:
    """The forms of a loop, None if ``V`` does not pass the test."""
    found = whole_loop(loop)
    if found is None:
        return None
    size, P, now, then = found.size, found.P, found.now, found.then
    S = [(-c, u, v) for c, u, v in found.products]
    if loop.discrete:
        if found.low or not nonnegative(bilinear(P, now, now), size):
            return None
        falls = [*bilinear(P, now, now), *bilinear(P, then, then, -1), *S]
        small = [(-1, f, f) for f in found.small]
    else:
        if not nonnegative([*bilinear(P, now, now), *found.low], size):
            return None
        falls = [*bilinear(P, now, then, -1), *bilinear(P, then, now, -1), *((-c, u, v) for c, u, v in found.turn), *S]
        sides = [[int(v) for v in mix(row, side)] for side in (now, then) for row in found.rows]
        small = [(-1, f, f) for f in sides]
    if not nonnegative(falls, size):
        return None
    psi = found.products[0][1]
    for power, beside in scales(loop):
        if nonnegative([*((c << power, u, v) for c, u, v in falls), (beside, psi, psi), *small], size):
            return replace(found, times=1 << power, beside=beside)
    return None


def scales(loop: Loop) -> list[tuple[int, int]]:
    """Powers of two, and squares beside, to try."""
    if not loop.each:
        return [(power, 0) for power in range(0, MOST_SCALES, 4)]
    return [(power, 1 << more) for power in range(0, MOST_SCALES // 4, 8) for more in range(0, MOST_SCALES // 2, 16)]


def coordinates(form: Vector, now: Matrix) -> Vector:
    """``form`` over the rows ``now``, which are different unit vectors.

    Raises
    ------
    ValueError
        It is not a function of the state.
    """
    places = [row.index(Fraction(1)) for row in now]
    found = [form[p] for p in places]
    if any(v for j, v in enumerate(form) if j not in places):
        raise ValueError("sigma is no function of the state")
    return found
