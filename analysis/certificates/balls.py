"""Bounds on what is not rational: matrices of integers off by a known error, exponentials, signs over frequencies.

Standard library only; part of the checker.  No statement about a loop is made here.
"""

from __future__ import annotations

import math
import operator
from fractions import Fraction
from itertools import pairwise
from typing import Any, NamedTuple

from .arithmetic import ZERO, Form, added, multiplied, need, onwards, positive, real, tick, value

WORD, TERMS = 384, 32  # bits of the coefficients, and how many, of functions on a piece
MOST_DOUBLINGS, MOST_HALVINGS, MOST_TURNS = 60, 40, 128


class Ball(NamedTuple):
    """A matrix of integers in units of 2^-bits, off by at most ``error`` units in the infinity norm."""

    rows: list[list[int]]
    error: int
    bits: int


def norm(X: Ball) -> int:
    """Bound on the infinity norm, in units."""
    return max(sum(map(abs, row)) for row in X.rows) + X.error


def ball(matrix: Any, bits: int) -> Ball:
    """The ball around an exact matrix."""
    rows = list[list[int]]()
    for row in matrix:
        tick()
        rows.append([round(v * 2**bits) for v in row])
    return Ball(rows, len(matrix[0]), bits)


def product(X: Ball, Y: Ball) -> Ball:
    """Errors |X| e_Y + e_X |Y|, and one unit for each column rounded."""
    need(norm(X).bit_length() + norm(Y).bit_length() < 32 * X.bits, "the matrices grow too large")
    rows, columns = list[list[int]](), [*zip(*Y.rows)]
    for row in X.rows:
        some = [j for j, v in enumerate(row) if v] or [0]  # the matrices of dead times have few entries in a row
        few = 2 * len(some) < len(row)
        used, cols = ([row[j] for j in some], zip(*(Y.rows[j] for j in some))) if few else (row, columns)
        rows.append([dot(used, col) >> X.bits for col in cols])
    return Ball(rows, (norm(X) * Y.error + X.error * norm(Y) >> X.bits) + 1 + len(Y.rows[0]), X.bits)


def plus(X: Ball, Y: Ball, sign: int = 1) -> Ball:
    """``X + sign Y``."""
    rows = [[x + sign * y for x, y in zip(row, other)] for row, other in zip(X.rows, Y.rows)]
    return Ball(rows, X.error + Y.error, X.bits)


def identity(n: int, columns: int | None = None) -> list[list[Fraction]]:
    """The unit matrix, wide if so many columns are given."""
    return [[Fraction(i == j) for j in range(columns or n)] for i in range(n)]


def size(matrix: Any) -> Fraction:
    """The infinity norm."""
    return max(sum(map(abs, row), ZERO) for row in matrix)


def exponential(G: Any, t: Fraction, bits: int) -> Ball:
    """Exp(G t) = exp(X)^(2^s), |X| < 2^-8, by its series."""
    s = int(size(G) * abs(t)).bit_length() + 8
    need(s <= 64, "the exponent of a matrix exponential is too large")
    X = ball([[v * t / 2**s for v in row] for row in G], bits)
    total = term = ball(identity(len(G)), bits)
    j, rest = 0, 2 ** (bits + 1)  # the terms from the j-th on add up to less than 2 |X|^j / j! < rest + 1 units
    while rest:
        j, term = j + 1, product(X, term)
        term = Ball([[v // j for v in row] for row in term.rows], term.error // j + 1 + len(G), bits)
        total, rest = plus(total, term), rest // (256 * j)
    total = Ball(total.rows, total.error + 1, bits)
    for _ in range(s):
        total = product(total, total)
    return total


def ramp(first: Any, last: Any, t: Fraction, bits: int) -> Ball:
    """The solution at ``t`` of ``Y' = G(s) Y``, ``Y(0) = 1``, where ``G`` goes linearly from the first to the last.

    On each of ``s`` pieces ``Y = sum Y_k``, ``Y_(k+1) = (X Y_k + Z Y_(k-1))/(k + 1)``, ``X = h G``, ``Z = h^2 G'``.
    Their norms are at most the coefficients of ``exp(|X| z + |Z| z^2/2)``, ``w = |X| + |Z|/2 <= 1/2``: from the k-th on
    they add up to at most ``2 w^j/j!``, ``j = k/2`` rounded up.
    """
    n, s = len(first), int(4 * t * max(size(first), size(last))) + 1
    need(s <= 2**14, "a stay is too long")
    whole = ball(identity(n), bits)
    for i in range(s):
        G = [[(u + (v - u) * Fraction(i, s)) * t / s for u, v in zip(*rows)] for rows in zip(first, last)]
        turn = [[(v - u) * t / s**2 for u, v in zip(*rows)] for rows in zip(first, last)]
        X, Z, w = ball(G, bits), ball(turn, bits), size(G) + size(turn) / 2
        older, term = ball([[ZERO] * n for _ in range(n)], bits), ball(identity(n), bits)
        total, k, rest = term, 1, int(w * 2 ** (bits + 1)) + 1
        while rest > 1:
            both = plus(product(X, term), product(Z, older))
            older, term = term, Ball([[v // k for v in row] for row in both.rows], both.error // k + 1 + n, bits)
            total, k = plus(total, term), k + 1
            rest = int(rest * w / ((k + 1) // 2)) + 1 if k % 2 else rest
        whole = product(total._replace(error=total.error + 1), whole)
    return whole


def sign_of_determinant(X: Ball) -> int:
    """Its sign, the same for all matrices of the ball, by elimination, each row with its own error; 0 if undecided."""
    M, errors, sign, n, bits = [[*row] for row in X.rows], [X.error] * len(X.rows), 1, len(X.rows), X.bits
    for k in range(n):
        best = max(range(k, n), key=lambda i: abs(M[i][k]))
        if best != k:
            M[k], M[best], errors[k], errors[best], sign = M[best], M[k], errors[best], errors[k], -sign
        pivot, own = abs(M[k][k]) - errors[k], errors[k]
        if pivot <= 0:
            return 0
        sign, most = sign if M[k][k] > 0 else -sign, max(map(abs, M[k][k:])) + own
        for i in range(k + 1, n):
            tick()
            f = (M[i][k] << bits) // M[k][k]
            off = ((errors[i] << bits) + (abs(f) + 1) * own) // pivot + 2  # of f: (a + e)/(p + d) - a/p and rounding
            M[i][k + 1 :] = [v - (f * u >> bits) for u, v in zip(M[k][k + 1 :], M[i][k + 1 :])]
            errors[i] += (abs(f) * own + off * most >> bits) + 2
    return sign


def dot(u: Any, v: Any) -> Any:
    """U . v, as far as both go."""
    tick()
    return sum(map(operator.mul, u, v))


def positive_definite(M: list[list[int]], bits: int = 30) -> bool:
    """M: rows of the lower triangle; False if undecided."""
    n, L, half = len(M), list[list[int]](), [bits - (row[-1].bit_length() + 1) // 2 for row in M]
    N = [[v << h + k if h + k >= 0 else v >> -h - k for v, k in zip(row, half)] for row, h in zip(M, half)]
    for i, row in enumerate(N):  # N <= S M S < N + 1, S powers of two; L: Cholesky's factor of N - n 2^bits, rounded
        new = list[int]()
        for j in range(i):
            new.append((row[j] - dot(new, L[j])) // L[j][j])
        rest = row[i] - (n << bits) - dot(new, new)
        if rest <= 0:
            return M[i][i] > 0 and bits < 480 and positive_definite(M, 2 * bits)
        L.append([*new, math.isqrt(rest)])
    R = [[v - dot(L[i], L[j]) for j, v in enumerate(row)] for i, row in enumerate(N)]
    aside = [sum(abs(v) + 1 for v in (*R[i][:i], *(R[j][i] for j in range(i + 1, n)))) for i in range(n)]
    return all(row[-1] > most for row, most in zip(R, aside))  # S M S - L L' is strictly diagonally dominant


def box(F: Form, a: Fraction, b: Fraction, order: int, critical: int = 0) -> bool:
    """Whether ``Re F > 0`` on ``[a, b]``; over ``omega^(2 critical)`` if it has such a factor and ``a = 0``.

    ``exp(-i tau (a + t))`` is a number, off by ``e``, times a Taylor polynomial, off by ``r = (|tau| t)^order/order!``:
    its cosine and sine are each off by at most ``2 e + 4 r``.
    """
    body, shift = Form(), real(a, 1)
    for tau in {tau for tau, _ in F}:
        parts = [Form(), Form()]  # p(a + t), q(a + t)
        for which in (0, 1):
            for c in reversed(F.part(which, tau)):
                parts[which] = parts[which] * shift + real(c)
        p, q = parts
        if tau == 0:
            body = body + p
            continue
        E = exponential([[ZERO, -tau * a], [tau * a, ZERO]], Fraction(1), 160)  # [[cos, -sin], [sin, cos]]
        c, s, error = (Fraction(x, 2**160) for x in (E.rows[0][0], E.rows[1][0], E.error if a else 0))
        taylor = [tau**j / math.factorial(j) for j in range(order)]
        C, Z = (real(*(x * sign[j % 4] for j, x in enumerate(taylor))) for sign in ((1, 0, -1, 0), (0, 1, 0, -1)))
        sizes = [[abs(x) for x in part.part()] for part in parts]
        wide = real(*sizes[0]) + real(*sizes[1])
        off = real(-2 * error, *[0] * (order - 1), -4 * abs(tau) ** order / math.factorial(order))
        body = body + (real(c) * p + real(s) * q) * C + (real(c) * q + real(-s) * p) * Z + wide * off
    left, skip = body.part(), 2 * critical if a == 0 else 0
    return positive(left[skip:] if not any(left[:skip]) else left, ZERO, b - a)


class Model(NamedTuple):
    """A function of ``x`` in ``[-1, 1]``: a complex polynomial in units of 2^-WORD, off by at most ``off`` units."""

    u: list[int]
    v: list[int]
    off: int

    def __add__(self, other: Model) -> Model:  # type: ignore[override]  # no tuple of theirs
        return Model(added(self.u, other.u), added(self.v, other.v), self.off + other.off)

    def __mul__(self, other: Model) -> Model:  # type: ignore[override]  # as above
        (a, b, e), (c, d, f), left, right = self, other, self.most(), other.most()
        u = added(multiplied(a, c), [-x for x in multiplied(b, d)])
        v = added(multiplied(a, d), multiplied(b, c))
        off = left * f + e * (right + f) + sum(map(abs, u[TERMS:])) + sum(map(abs, v[TERMS:]))
        u, v = ([x >> WORD for x in side[:TERMS]] for side in (u, v))
        return Model(u, v, (off >> WORD) + 1 + 2 * TERMS).short()

    def most(self) -> int:
        """Bound on its modulus, less ``off``."""
        return sum(map(abs, self.u)) + sum(map(abs, self.v))

    def short(self) -> Model:
        """The same without the last coefficients, where these are small."""
        (u, v, off), small = self, 2**64
        for side in (u, v):
            while side and abs(side[-1]) < small:
                off += abs(side.pop())
        return Model(u, v, off)

    def conjugate(self) -> Model:
        """The complex conjugate."""
        return Model(self.u, [-x for x in self.v], self.off)


class Lift:
    """What becomes of a :class:`Form` on ``[a, b]``, with ``omega = (a + b)/2 + x (b - a)/2``."""

    def __init__(self, a: Fraction, b: Fraction, pace: Fraction | None = None) -> None:
        self.middle, self.radius, self.turns = (a + b) / 2, (b - a) / 2, dict[Fraction, Model]()
        self.pace = pace or ZERO

    def __call__(self, F: Form, halvings: int = 0) -> Model:
        """Of ``F/2^halvings``."""
        found, (unit, rows) = Model([], [], 0), F.whole()
        q = math.lcm(self.middle.denominator, self.radius.denominator)
        shift, word = [int(self.middle * q), int(self.radius * q)], max(WORD - halvings, 0)
        for tau in {tau for (tau, _), _ in rows}:
            terms = {n: z for (t, n), z in rows if t == tau}
            top, sides = max(terms), [[0], [0]]
            for k in range(top, -1, -1):  # times q^top unit
                scale = q ** (top - k) << word
                for i, c in enumerate(terms.get(k, (0, 0))):
                    sides[i] = added(multiplied(sides[i], shift), [c * scale])
            below = unit * q**top << max(halvings - WORD, 0)
            u, v = ([x // below for x in side] for side in sides)
            off = sum(map(abs, [*u[TERMS:], *v[TERMS:]])) + 2 * len(u)
            one = Model(u[:TERMS], v[:TERMS], off).short()
            found = found + (one * self.turn(tau) if tau else one)
        return found

    def turn(self, tau: Fraction) -> Model:
        """``exp(-i tau omega)``: at the middle, times Taylor's polynomial, off by ``|tau radius|^TERMS/TERMS!``.

        With a pace ``a`` it is ``exp(a tau)`` times that, in forms that are analytic in ``Re s > 0``.
        """
        if tau not in self.turns:
            need(not self.pace or tau > 0, "with a rate a dead time is above 0")
            t, y, up = tau * self.middle, abs(tau * self.radius), tau * self.pace
            E = exponential([[up, -t], [t, up]], Fraction(1), WORD)  # e^up [[cos, -sin], [sin, cos]]
            still = Model([E.rows[0][0]], [-E.rows[1][0]], 2 * E.error)
            u, v, term, turned = [0] * TERMS, [0] * TERMS, Fraction(2**WORD), [(0, 1), (1, -1), (0, -1), (1, 1)]
            for k in range(TERMS):
                side, sign = turned[k % 4]
                (u, v)[side][k] = sign * int(term) * (1 if tau > 0 or k % 2 == 0 else -1)
                term = term * y / (k + 1)
            self.turns[tau] = still * Model(u, v, TERMS + 1 + int(term)).short()
        return self.turns[tau]


def above(p: Model) -> bool:
    """Whether ``Re p > 0`` on ``[-1, 1]``."""
    u = [*(p.u or [0])]
    u[0] -= p.off
    flipped = onwards([-c if i % 2 else c for i, c in enumerate(u)])  # p(-x - 1): from -2 to 0
    return positive([-c if i % 2 else c for i, c in enumerate(flipped)], ZERO, Fraction(2))


def tail(F: Form, start: Fraction, degree: int) -> bool:
    """Whether ``Re F > 0`` from ``start`` on, and at infinity over ``omega^degree``: the undelayed part prevails.

    For any weights ``l > 0``, ``(sum |z_tau|)^2 <= sum l sum |z_tau|^2/l``; taken are the leading coefficients, or what
    is largest of these and of the parts at the start.
    """
    A, parts = F.part(), {t: Form({(ZERO, n): z for (tau, n), z in F.items() if tau == t}) for t, _ in F if t}
    lead = {t: max(*map(abs, z.get((ZERO, degree), (ZERO, ZERO)))) for t, z in parts.items()}
    if len(A) != degree + 1 or not positive(A, start):
        return False
    near = {t: max(abs(value(z.part(which), start)) for which in (0, 1)) / start**degree for t, z in parts.items()}
    for sizes in (lead, {t: max(lead[t], near[t]) for t in lead}):
        least, square = sum(sizes.values(), ZERO) / 10**6, Form()
        weight = {t: max(size, least) or Fraction(1) for t, size in sizes.items()}
        for t, z in parts.items():
            square = square + z * z.conjugate() * real(-sum(weight.values(), ZERO) / weight[t])
        left = (real(*A) * real(*A) + square).part()
        if len(left) == 2 * degree + 1 and positive(left, start):
            return True
    return False


def turning(F: Form, start: Fraction, degree: int) -> bool:
    """Whether ``Re F > 0`` from ``start`` on, and at infinity over ``omega^degree``, where delayed terms do not decay.

    All ``tau`` are multiples of one ``h``.  With ``theta = h omega``, whatever it is, and ``u = 1/omega`` it is ``sum
    u^k G_k``, ``k`` from 0 to ``N``, functions of ``theta`` of the period ``2 pi``: ``G_0 + u G_1`` and less than
    ``rest``, affine in ``u``, at both ends; or a mean of its Bernstein coefficients on ``[0, 1/start]``.
    """
    unit = math.lcm(*(tau.denominator for tau, _ in F))
    h = Fraction(math.gcd(*(int(tau * unit) for tau, _ in F)), unit)
    most = max((abs(tau / h) for tau, _ in F), default=ZERO) if h else ZERO
    if not (start > 0 and 0 < most <= MOST_TURNS) or any(n > degree for _, n in F):
        return False
    N = degree - min(n for _, n in F)
    parts = [
        Form({(tau / h, 0): z for (tau, n), z in F.items() if degree - n == k}) * real(start**-k) for k in range(N + 1)
    ]
    rest = sum((sum(map(abs, z)) for part in parts[2:] for z in part.values()), ZERO)
    ends = [parts[0] + real(-rest), sum(parts[1:2], parts[0]) + real(-rest)]
    cuts = [Fraction(k * 6283186, 10**6 * 2 * int(most)) for k in range(2 * int(most) + 1)]
    lifts = [Lift(a, b) for a, b in pairwise(cuts)]
    if all(above(lift(end)) for lift in lifts for end in ends):
        return True
    for i in (0, N, *range(1, N)):
        shares = [real(Fraction(math.comb(i, k), math.comb(N, k))) * part for k, part in enumerate(parts[: i + 1])]
        mean = sum(shares, Form())
        if not all(above(lift(mean)) for lift in lifts):
            return False
    return True


def outward(F: Form, start: Fraction, degree: int, pace: Any) -> Model:
    """``F/omega^degree`` of ``1/omega`` from 0 to ``1/start``, what comes late being a number of unknown phase."""
    need(all(n <= degree for _, n in F), "the loop is not proper")
    now = Form({(ZERO, degree - n): z for (tau, n), z in F.items() if not tau})
    late = [(Form({(ZERO, 0): z}), tau, n) for (tau, n), z in F.items() if tau]
    found, wide = Lift(ZERO, 1 / start)(now), ZERO
    for one, tau, n in late:
        up = exponential([[pace * tau]], Fraction(1), WORD)
        size = sum(map(abs, one[ZERO, 0]), ZERO) * Fraction(start) ** (n - degree)
        wide += size * (up.rows[0][0] + up.error)
    return found._replace(off=found.off + int(wide) + 1)


def right_zeros(turned: Form, n: int, poles: int = 0, pace: Fraction | None = None) -> tuple[int, str]:
    """How many zeros with ``Re s > 0`` ``chi`` has, of which 0 is one ``poles`` times; ``turned`` is ``chi(i omega)``.

    ``chi`` is entire, and ``s^n (c + sum c_T e^(-s T) + o(1))`` in ``Re s >= 0``, ``c > sum |c_T|`` being shown far
    out: by the argument principle its angle rises by ``n`` quarter turns less two for each zero from 0 to infinity, if
    none lies on the axis.  On each of some pieces ``Re i^-k chi > 0``; from one to the next ``k`` changes by at most 1,
    so that no turn is missed.  With a ``pace`` ``a`` what is late by ``T`` is ``e^(a T)`` times as large.
    """
    need(not (poles and pace), "a pole at 0 has no rate")
    (u, v), far = ((1, 0), (0, -1), (-1, 0), (0, 1))[n % 4], Fraction(1)
    last = turned * Form({(ZERO, 0): (Fraction(u), Fraction(v))})
    while not (above(outward(last, far, n, pace)) if pace else tail(last, far, n)):
        need(far < 2**MOST_DOUBLINGS, "what is counted is not shown to behave like s^n far out")
        far *= 2
    inner, n = turned * Form({(ZERO, 0): (ZERO, Fraction(-1))}) ** poles, n - poles
    stack, k, start, pieces = [(ZERO, far)], 0, 0, 1
    while stack:
        a, b = stack.pop()
        p, q, off = over_s(inner, b, poles) if poles and not a else Lift(a, b, pace)(inner)
        minus = [-x for x in p], [-x for x in q]
        sides = [(p, q), (q, minus[0]), minus, (minus[1], p)]  # chi, -i chi, -chi, i chi
        turns = (k, k + 1, k - 1) if a else (0, 2)
        found = next((j for j in turns if above(Model(*sides[j % 4], off))), None)
        if found is None:
            need(b - a > far / 2**MOST_HALVINGS, "what is counted has a root on the axis, or near it")
            stack += [((a + b) / 2, b), (a, (a + b) / 2)]
            continue
        k, pieces, start = found, pieces + 1, start if a else found
    end = n - 4 * ((n - k + 1) // 4)  # the far direction is n, up to whole turns
    need(abs(end - k) <= 1, "the pieces do not go together")
    return (n - end + start) // 2, f"rises by {end - start} of {n} quarter turns, on {pieces} pieces"


def over_s(turned: Form, b: Fraction, r: int) -> Model:
    """``chi/s^r`` on ``i [0, b]``, ``turned`` being ``chi/i^r``, where 0 is a zero of that order.

    Where ``s^n`` has a lower power, ``q = r - n > 0``, ``e^(-s T)`` is its Taylor polynomial of degree ``q``, off by at
    most ``omega^(q + 1) T^(q + 1)/(q + 1)!``.
    """
    kept, taylor, off = Form(), Form(), ZERO
    for (tau, n), z in turned.items():
        if n >= r:
            kept[tau, n - r] = z
            continue
        one = Form({(ZERO, n): z})
        for k in range(r - n + 1):
            taylor, one = taylor + one, one * Form({(ZERO, 1): (ZERO, Fraction(-tau, k + 1))})
        off += sum(map(abs, z)) * tau ** (r - n + 1) * b / math.factorial(r - n + 1)
    need(all(n == r for _, n in taylor), "0 is a zero of a lower order")
    near = Lift(ZERO, b)(kept + Form({(ZERO, 0): taylor.get((ZERO, r), (ZERO, ZERO))}))
    return near._replace(off=near.off + int(off * 2**WORD) + 1)
