"""Nonlinearities beside unknown gains, constant or slow: a Lyapunov matrix that depends on them; part of the checker.

Standard library only.  Every function raises ``Rejected`` unless what it is asked to show is shown.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import pairwise, product
from math import comb, lcm, prod
from typing import Any, NamedTuple

from . import states
from .arithmetic import INF, ZERO, eliminated, fields, form, integer, need, numbers, tick
from .balls import dot, identity, positive_definite
from .channels import Channels, Plant, Rows, each

MOST_GAINS, MOST_DEGREE, MOST_BOXES, MOST_COEFFICIENTS = 3, 8, 4096, 10**5


class Spline(NamedTuple):
    """``P(g)``: continuous, of degree ``d`` in each gain on each of the equal pieces of its interval."""

    d: int
    pieces: list[int]
    bounds: list[tuple[Fraction, Fraction]]
    rates: list[Fraction]
    at: dict[tuple[int, ...], Rows]

    def value(self, box: tuple[int, ...], bases: list[list[Fraction]]) -> Rows:
        """The sum of its coefficients on a box, each times the product of its weights, one of each variable."""
        order, terms = range(len(next(iter(self.at.values())))), []
        for index in product(range(self.d + 1), repeat=len(box)):
            weight = prod(base[i] for base, i in zip(bases, index))
            if weight:
                terms.append((weight, self.at[tuple(self.d * k + i for k, i in zip(box, index))]))
        tick()
        return [[sum((w * X[i][j] for w, X in terms), ZERO) for j in order] for i in order]

    def gain(self, j: int, piece: int, s: Fraction) -> Fraction:
        """The gain at ``s``, 0 to 1, of a piece."""
        low, high = self.bounds[j]
        return low + (high - low) * (piece + s) / self.pieces[j]


def proved(H: Plant, data: Any, asked: Channels, proof: Any) -> dict[str, str]:
    """``V = x'P(g) x + 2 sum theta_i int_0^sigma_i phi_i`` falls for ``mu_i = -g_i sigma_i``, ``g`` in a box.

    ``|g_i'| <= r_i``, 0 for constant gains; the other channels as in :func:`several.proved`, with ``lambda >= 0`` for
    each of the boxes on which ``P`` is polynomial.  There, for almost all times, ``V'`` is at most the form of a matrix
    that is polynomial in ``g`` and affine in ``g'``: negative definite, if its Bernstein coefficients are, for ``g_i'``
    in ``{-r_i, r_i}``.  Discrete: ``V(x+, g+) - V(x, g)``, with ``g_i+`` on its own in each piece within ``r_i``.
    """
    gains = [block for block in asked.blocks if asked.families[block[0]].linear]
    inside = [i for block in gains for i in block]
    others = [i for i in range(len(H.D)) if i not in inside]
    need(0 < len(gains) <= MOST_GAINS, f"1 to {MOST_GAINS} unknown gains are needed")
    need(not any(H.D[i][j] for i in inside for j in inside), "D has an entry between two unknown gains")
    weights, turned = fields(data, "lambda", "theta")
    method, degree, given, rows, exponent = fields(proof, "method", "degree", "pieces", "P", "exponent")
    form(method == "spline", "a matrix that depends on gains is a spline")
    form(isinstance(given, list) and len(given) == len(gains), "each gain has a number of pieces")
    d, pieces = integer(degree, 1, MOST_DEGREE), [integer(count, 1, MOST_BOXES) for count in given]
    need(prod(pieces) <= MOST_BOXES, "there are too many boxes")
    need(prod(d * count + 1 for count in pieces) <= MOST_COEFFICIENTS, "P has too many coefficients")
    boxes = [*product(*map(range, pieces))]
    form(isinstance(weights, list) and len(weights) == len(boxes), "each box has its lambda")
    lines = [one_each(line, others) for line in weights]
    need(all(v >= 0 for line in lines for v in line), "a weight lambda is negative")
    bounds = [asked.bounds(i) for i in range(len(H.D))]
    for i, family in each(asked):
        need(INF not in map(abs, bounds[i]), f"channel {i + 1} has no finite bounds")
        need(not family.rough, "locally Lipschitz nonlinearities are needed")
        paced = not family.linear or family.varying is (family.rate is not None)
        need(paced, f"the gain of channel {i + 1} depends on time, and no rate is given")
    theta = one_each(turned, others)
    for t, i in zip(theta, others):
        fixed = not asked.families[i].varying and not H.discrete
        need(not t or fixed, f"theta_{i + 1} needs continuous time and a nonlinearity that does not depend on it")
        need(not t or not any(H.D[i]), f"theta_{i + 1} needs sigma_{i + 1} to be a function of the state alone")
    indices, e = [*product(*(range(d * count + 1) for count in pieces))], integer(exponent, 0, 10**5)
    form(isinstance(rows, list) and len(rows) == len(indices), "P has one matrix for each coefficient")
    rates = [asked.families[block[0]].rate or ZERO for block in gains]
    ends, at = [bounds[block[0]] for block in gains], {k: scaled(X, H, e) for k, X in zip(indices, rows)}
    P = Spline(d, pieces, ends, rates, at)
    least = [(H.C[i], min(t * end for end in bounds[i])) for t, i in zip(theta, others)]
    for Q in P.at.values():
        definite([[v + sum(w * c[i] * c[j] for c, w in least) for j, v in enumerate(row)] for i, row in enumerate(Q)])
    for box, line in zip(boxes, lines):
        channels = [(i, *bounds[i], *pair) for i, *pair in zip(others, line, theta)]
        for falls in (stepped if H.discrete else flowing)(H, gains, P, box, channels):
            definite(falls)
    still = "" if any(rates) else " that does not change"
    return {
        "stable": f"V is positive definite, as the {len(P.at)} coefficients of P, of degree {d} in the gains, are",
        "inequality": f"V falls for every gain{still}: the coefficients on {len(boxes)} boxes are positive definite",
    }


def one_each(data: Any, others: list[int]) -> list[Fraction]:
    """One number for each of the other channels, of which there may be none."""
    form(others != [] or data == [], "there are numbers for no channels")
    return numbers(data, len(others)) if others else []


def scaled(half: Any, H: Plant, e: int) -> Rows:
    """The symmetric matrix of a lower triangle of integers, in units of ``2^-e``."""
    n = len(H.A)
    return [[Fraction(v, 2**e) for v in row] for row in states.symmetric(half, [[ZERO] * n], n)[0]]


def definite(M: Rows) -> None:
    """A symmetric matrix is positive definite."""
    q = states.unit(M)
    whole = [[int(q * v) for v in row[: i + 1]] for i, row in enumerate(M)]
    need(positive_definite(whole), "V > 0, or that V falls, fails or is undecided")


def flowing(H: Plant, gains: Any, P: Spline, box: tuple[int, ...], channels: Any) -> Iterator[Rows]:
    """Bernstein coefficients, on a box, of ``-V'`` less the forms, in continuous time."""
    n, D = len(H.A), max(P.d + 1, 2)
    values = dict[Any, dict[tuple[int, ...], Rows]]()
    for node in product(range(D + 1), repeat=len(box)):
        at = [Fraction(k, D) for k in node]
        R, falls = forms(H, gains, [P.gain(j, k, s) for j, (k, s) in enumerate(zip(box, at))], channels)
        bases = [bernstein(P.d, s) for s in at]
        PR = [[dot(row, column) for column in zip(*R)] for row in P.value(box, bases)]
        for i, row in enumerate(PR):
            for j, v in enumerate(row):
                falls[i][j] -= v
                falls[j][i] -= v
        turns = list[Rows]()
        for j, (s, (low, high)) in enumerate(zip(at, P.bounds)):  # r dP/dg_j
            factor = P.rates[j] * P.pieces[j] / (high - low)
            turns.append(P.value(box, [*bases[:j], [factor * v for v in slopes(P.d, s)], *bases[j + 1 :]]))
        for signs in product(*((1, -1) if rate else (0,) for rate in P.rates)):
            whole = [list(row) for row in falls]
            for sign, turn in zip(signs, turns):
                for i in range(n * abs(sign)):
                    whole[i][:n] = [v - sign * w for v, w in zip(whole[i], turn[i])]
            values.setdefault(signs, {})[node] = whole
    for found in values.values():
        yield from coefficients(found, [D] * len(box))


def stepped(H: Plant, gains: Any, P: Spline, box: tuple[int, ...], channels: Any) -> Iterator[Rows]:
    """The same of ``-(V(x+, g+) - V(x, g))``: in ``g`` and, for gains that change, in ``g+`` on each piece in reach."""
    n, own = len(H.A), [j for j, rate in enumerate(P.rates) if rate]
    degrees = [max(P.d, 2) if rate else P.d + 2 for rate in P.rates] + [P.d] * len(own)
    reach = list[list[int]]()
    for j, (k, rate) in enumerate(zip(box, P.rates)):
        least, most = P.gain(j, k, ZERO) - rate, P.gain(j, k, Fraction(1)) + rate
        near = (h for h in range(P.pieces[j]) if P.gain(j, h, Fraction(1)) >= least and P.gain(j, h, ZERO) <= most)
        reach.append([*near] if rate else [k])
    for after in product(*reach):
        values = dict[tuple[int, ...], Rows]()
        for node in product(*(range(D + 1) for D in degrees)):
            at = [Fraction(k, D) for k, D in zip(node, degrees)]
            now, later = at[: len(box)], at[: len(box)]
            for j, s in zip(own, at[len(box) :]):
                later[j] = s
            R, falls = forms(H, gains, [P.gain(j, k, s) for j, (k, s) in enumerate(zip(box, now))], channels)
            Q = P.value(after, [bernstein(P.d, s) for s in later])
            QR = [*zip(*([dot(row, column) for column in zip(*R)] for row in Q))]
            for i, column in enumerate(zip(*R)):
                falls[i] = [v - dot(column, other) for v, other in zip(falls[i], QR)]
            for i, row in enumerate(P.value(box, [bernstein(P.d, s) for s in now])):
                falls[i][:n] = [v + w for v, w in zip(falls[i], row)]
            values[node] = falls
        yield from coefficients(values, degrees)


def forms(H: Plant, gains: Any, values: list[Fraction], channels: Any) -> tuple[Rows, Rows]:
    """Rows of ``x'`` (or ``x+``) from ``(x, phi)``, ``phi`` of the other channels, and less what these say.

    That is ``-2 lambda (phi - l sigma)(u sigma - phi) - 2 theta phi sigma'`` for each.
    """
    n, others = len(H.A), [i for i, *_ in channels]
    N, g = n + len(others), {i: v for block, v in zip(gains, values) for i in block}
    seen = {i: [*H.C[i], *(-H.D[i][h] for h in others)] for i in range(len(H.D))}  # sigma, with mu = 0 where g is
    R = [[*row, *(-b[h] for h in others)] for row, b in zip(H.A, H.B)]
    R = [[v - sum(b[i] * w * seen[i][j] for i, w in g.items()) for j, v in enumerate(row)] for row, b in zip(R, H.B)]
    falls = [[ZERO] * N for _ in range(N)]
    for k, (h, low, high, weight, theta) in enumerate(channels):
        sigma = [v - sum(H.D[h][i] * w * seen[i][j] for i, w in g.items()) for j, v in enumerate(seen[h])]
        phi = [Fraction(j == n + k) for j in range(N)]
        rate = [theta * dot(H.C[h], column) for column in zip(*R)] if theta else [ZERO] * N
        a, b = [p - low * s for p, s in zip(phi, sigma)], [weight * (high * s - p) for p, s in zip(phi, sigma)]
        for i in range(N):
            for j in range(N):
                falls[i][j] -= a[i] * b[j] + a[j] * b[i] + phi[i] * rate[j] + phi[j] * rate[i]
    return R, falls


def bernstein(d: int, s: Fraction) -> list[Fraction]:
    """Bernstein's polynomials of degree ``d`` at ``s``."""
    return [comb(d, i) * s**i * (1 - s) ** (d - i) for i in range(d + 1)]


def slopes(d: int, s: Fraction) -> list[Fraction]:
    """Their derivatives."""
    return [d * (a - b) for a, b in pairwise([ZERO, *bernstein(d - 1, s), ZERO])]


def coefficients(values: dict[tuple[int, ...], Rows], degrees: list[int]) -> Iterator[Rows]:
    """Bernstein coefficients of a polynomial from its values where each variable is ``k/D``."""
    scale = lcm(*(v.denominator for X in values.values() for row in X for v in row))
    whole = {node: [[v.numerator * (scale // v.denominator) for v in row] for row in X] for node, X in values.items()}
    for axis, D in enumerate(degrees):
        if not D:  # it does not matter
            continue
        back = eliminated([bernstein(D, Fraction(k, D)) for k in range(D + 1)], identity(D + 1))
        assert back is not None, "no polynomial but 0 vanishes at so many points"
        unit = lcm(*(v.denominator for row in back for v in row))
        shares = [[int(unit * v) for v in row] for row in back]
        scale, turned = scale * unit, dict[tuple[int, ...], list[list[int]]]()
        for node, X in whole.items():
            tick()
            line = [whole[(*node[:axis], k, *node[axis + 1 :])] for k in range(D + 1)]
            share = [(c, Y) for c, Y in zip(shares[node[axis]], line) if c]
            turned[node] = [[sum(c * Y[i][j] for c, Y in share) for j in range(len(row))] for i, row in enumerate(X)]
        whole = turned
    yield from ([[Fraction(v, scale) for v in row] for row in X] for X in whole.values())
