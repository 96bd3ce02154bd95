r"""Nonlinearities beside unknown gains, checked again: a Lyapunov matrix that is a spline in the gains.

On each box of gains ``g_j = l_j + h_j (k_j + s_j)``, ``0 <= s_j <= 1``, and ``g_j' = r_j (2 q_j - 1)``, ``0 <= q_j <=
1``, or in discrete time ``g_j+`` in the same way on each piece that it can reach.  With ``mu_j = -g_j sigma_j`` the
matrix of

.. math:: -\dot V - 2 \sum_i \lambda_i (\phi_i - l_i \sigma_i)(u_i \sigma_i - \phi_i),
    \qquad V = x^\top P(g) x + 2 \sum_i \theta_i \int_0^{\sigma_i} \phi_i,

(discrete: with ``V(x+, g+) - V(x, g)``) has polynomials in ``s`` and ``q`` as entries: ``sum a_i t^i`` has Bernstein's
coefficients ``b_k = sum_(i <= k) a_i prod C(k_j, i_j)/C(D_j, i_j)``, and stays in their convex hull.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from math import comb, prod

from flint import Ordering, arb_mat, fmpq, fmpq_mat, fmpq_mpoly, fmpq_mpoly_ctx

from lure.analysis.certificates.second.channels import Asked
from lure.analysis.certificates.second.matrix import BITS, LARGEST_EXPONENT, positive_definite, triangle
from lure.analysis.certificates.second.numerics import to_fmpq, working_precision
from lure.analysis.certificates.second.reading import (
    Document,
    NotShown,
    count,
    listed,
    numbers,
    record,
    require,
    tick,
)

LARGEST, DEEPEST, MOST_GAINS = 100_000, 12, 3
Index = tuple[int, ...]
Table = list[list[fmpq_mpoly]]


@dataclass(frozen=True, kw_only=True, slots=True)
class Spline:
    """``P`` and the gains: degree, pieces and ends of each, its rate, its channels, and the coefficients of ``P``."""

    degree: int
    pieces: list[int]
    ends: list[tuple[Fraction, Fraction]]
    rates: list[Fraction]
    channels: list[list[int]]
    coefficients: dict[Index, fmpq_mat]

    def piece(self, j: int, k: int) -> tuple[Fraction, Fraction]:
        """The ends of a piece of a gain."""
        low, high = self.ends[j]
        width = (high - low) / self.pieces[j]
        return low + k * width, low + (k + 1) * width


def require_parametric(document: Document, asked: Asked) -> None:
    """Check that ``V`` is positive definite and falls for all gains that change no faster than said.

    ``asked``: the plant and the classes.

    Raises
    ------
    NotShown
        It does not.
    """
    given, proof = (
        record(document.multiplier, "lambda", "theta"),
        record(document.proof, "method", "degree", "pieces", "P", "exponent"),
    )
    require(proof["method"] == "spline", "the method does not fit the theorem")
    n, m, families = asked.A.nrows(), asked.D.nrows(), asked.nonlinearities
    firsts = sorted(i for i in set(asked.repeated) if families[i].linear)
    others = [i for i in range(m) if not families[i].linear]
    require(0 < len(firsts) <= MOST_GAINS, "there are no unknown gains, or too many")
    for i, j in product([i for i in range(m) if i not in others], repeat=2):
        require(asked.D[i, j] == 0, "D has an entry between unknown gains")
    require(not any(one.rough for one in families), "the theorem is for locally Lipschitz nonlinearities")
    paced = all(one.time_varying is (one.rate is not None) for one in families if one.linear)
    require(paced, "a gain depends on time without a rate")
    theta = numbers(given["theta"])
    require(len(theta) == len(others), "theta is not one for each other channel")
    for t, i in zip(theta, others, strict=True):
        free = not families[i].time_varying and all(asked.D[i, j] == 0 for j in range(m))
        require(t == 0 or (free and not asked.discrete), "Popov's term does not fit its channel")
    pieces, degree = [count(one, least=1) for one in listed(proof["pieces"])], count(proof["degree"], least=1)
    exponent = count(proof["exponent"], least=-LARGEST_EXPONENT)
    require(degree <= DEEPEST and exponent <= LARGEST_EXPONENT, "a degree or an exponent is too large")
    require(len(pieces) == len(firsts), "there is not one number of pieces for each gain")
    require(prod(degree * one + 1 for one in pieces) <= LARGEST, "P has too many coefficients")
    indices = [*product(*(range(degree * one + 1) for one in pieces))]
    halves = [triangle(half, n) for half in listed(proof["P"])]
    require(len(halves) == len(indices), "P has not one matrix for each coefficient")
    unit, bounds = to_fmpq(Fraction(2)) ** -exponent, asked.bounds
    P = {
        index: fmpq_mat([[fmpq(half[max(i, j)][min(i, j)]) * unit for j in range(n)] for i in range(n)])
        for index, half in zip(indices, halves, strict=True)
    }
    spline = Spline(
        degree=degree,
        pieces=pieces,
        ends=[bounds[i] for i in firsts],
        rates=[families[i].rate or Fraction(0) for i in firsts],
        channels=[[i for i in range(m) if asked.repeated[i] == first] for first in firsts],
        coefficients=P,
    )
    least = fmpq_mat(n, n)
    for t, i in zip(theta, others, strict=True):
        row = fmpq_mat([[asked.C[i, j] for j in range(n)]])
        least += row.transpose() * row * to_fmpq(min(t * bounds[i][0], t * bounds[i][1]))
    needed, boxes = [Q + least for Q in P.values()], [*product(*map(range, pieces))]
    lines = [numbers(line) for line in listed(given["lambda"])]
    require(len(lines) == len(boxes), "there is not one line of lambda for each box")
    for matrix in needed:
        _require_definite(matrix)
    for box, line in zip(boxes, lines, strict=True):
        require(len(line) == len(others) and all(v >= 0 for v in line), "lambda is not one number >= 0 a channel")
        channels = [*zip(others, line, theta, strict=True)]
        for after in _reached(spline, box, discrete=asked.discrete):
            for matrix in _falls(asked, spline, box, after, channels):
                _require_definite(matrix)


def _require_definite(matrix: fmpq_mat) -> None:
    tick()
    for bits in BITS:
        with working_precision(bits):
            if positive_definite(arb_mat(matrix)):
                return
    raise NotShown("V, or the matrix of the inequality, is not shown to be positive definite")


def _reached(spline: Spline, box: Index, *, discrete: bool) -> list[Index]:
    """The boxes in which the gains may be after a step; in continuous time this one."""
    found = list[list[int]]()
    for j, (k, rate) in enumerate(zip(box, spline.rates, strict=True)):
        low, high = spline.piece(j, k)
        near = [h for h in range(spline.pieces[j]) if _gap((low, high), spline.piece(j, h)) <= rate]
        found.append(near if discrete and rate > 0 else [k])
    return [*product(*found)]


def _gap(one: tuple[Fraction, Fraction], other: tuple[Fraction, Fraction]) -> Fraction:
    """The distance of two intervals."""
    return max(one[0] - other[1], other[0] - one[1], Fraction(0))


def _falls(
    asked: Asked, spline: Spline, box: Index, after: Index, channels: Sequence[tuple[int, Fraction, Fraction]]
) -> list[fmpq_mat]:
    """Bernstein's coefficients of the matrix on a box; variables: a place for each gain, then what it does next."""
    n, p, d = asked.A.nrows(), len(box), spline.degree
    moving = [j for j in range(p) if spline.rates[j] > 0]
    context = fmpq_mpoly_ctx.get([*(f"s{j}" for j in range(p)), *(f"q{j}" for j in moving)], Ordering.lex)
    variables, zero = context.gens(), context.constant(0)
    place, following = list(variables[:p]), dict(zip(moving, variables[p:], strict=True))
    gain = dict[int, fmpq_mpoly]()
    for j, s in enumerate(place):
        low, high = spline.piece(j, box[j])
        gain |= dict.fromkeys(spline.channels[j], s * to_fmpq(high - low) + to_fmpq(low))
    others = [i for i, *_ in channels]
    N = n + len(others)

    def row(left: fmpq_mat, right: fmpq_mat, i: int) -> list[fmpq_mpoly]:
        """A row of ``left x + right mu`` as one of ``(x, phi)``: ``mu = -phi``, or ``-g sigma``."""
        found = [zero + left[i, j] for j in range(n)] + [zero - right[i, h] for h in others]
        for h, g in gain.items():
            if right[i, h] != 0:
                share = g * right[i, h]
                for j in range(n):
                    found[j] -= share * asked.C[h, j]
                for k, other in enumerate(others):
                    found[n + k] += share * asked.D[h, other]
        return found

    R = [row(asked.A, asked.B, i) for i in range(n)]
    Q, own = _matrix(spline, box, place, zero), range(n)
    later = (
        Q if not asked.discrete else _matrix(spline, after, [following.get(j, s) for j, s in enumerate(place)], zero)
    )
    turned = [[sum((a * R[k][j] for k, a in enumerate(line)), zero) for j in range(N)] for line in later]
    if asked.discrete:
        M = [[-sum((R[k][i] * turned[k][j] for k in own), zero) for j in range(N)] for i in range(N)]
        for i, j in product(own, own):
            M[i][j] += Q[i][j]
        degrees = [max(d, 2) if j in following else d + 2 for j in range(p)] + [d] * len(moving)
    else:
        M = [[zero] * N for _ in range(N)]
        for i, j in product(own, range(N)):
            M[i][j] -= turned[i][j]
            M[j][i] -= turned[i][j]
        for j, q in following.items():
            low, high = spline.piece(j, box[j])
            speed = (2 * q - 1) * to_fmpq(spline.rates[j] / (high - low))
            for a, b in product(own, own):
                M[a][b] -= Q[a][b].derivative(j) * speed
        degrees = [max(d + 1, 2)] * p + [1] * len(moving)
    for k, (i, weight, theta) in enumerate(channels):
        least, greatest = map(to_fmpq, asked.bounds[i])
        sigma, phi = row(asked.C, asked.D, i), [zero + (j == n + k) for j in range(N)]
        first = [f - least * s for f, s in zip(phi, sigma, strict=True)]
        second = [to_fmpq(weight) * (greatest * s - f) for f, s in zip(phi, sigma, strict=True)]
        rate = [sum((R[h][j] * asked.C[i, h] for h in own), zero) * to_fmpq(theta) for j in range(N)]
        for a, b in product(range(N), range(N)):
            M[a][b] -= first[a] * second[b] + first[b] * second[a] + phi[a] * rate[b] + phi[b] * rate[a]
    return _bernstein(M, degrees)


def _matrix(spline: Spline, box: Index, place: Sequence[fmpq_mpoly], zero: fmpq_mpoly) -> Table:
    """``P`` on a box as polynomials in the places."""
    d, n = spline.degree, next(iter(spline.coefficients.values())).nrows()
    found = [[zero] * n for _ in range(n)]
    for index in product(range(d + 1), repeat=len(box)):
        X = spline.coefficients[tuple(d * k + i for k, i in zip(box, index, strict=True))]
        weight = zero + 1
        for i, s in zip(index, place, strict=True):
            weight *= comb(d, i) * s**i * (1 - s) ** (d - i)
        for a, b in product(range(n), range(n)):
            found[a][b] += weight * X[a, b]
    return found


def _bernstein(M: Table, degrees: Sequence[int]) -> list[fmpq_mat]:
    """Bernstein's coefficients of a matrix of polynomials of these degrees at most."""
    tick()
    size = len(M)
    terms = dict[Index, fmpq_mat]()
    for a, b in product(range(size), range(size)):
        for power, c in M[a][b].to_dict().items():
            require(all(i <= D for i, D in zip(power, degrees, strict=True)), "a polynomial has a higher degree")
            terms.setdefault(tuple(power), fmpq_mat(size, size))[a, b] = c
    found = list[fmpq_mat]()
    for k in product(*(range(D + 1) for D in degrees)):
        whole = fmpq_mat(size, size)
        for power, X in terms.items():
            share = prod(Fraction(comb(a, i), comb(D, i)) for a, i, D in zip(k, power, degrees, strict=True))
            if share:
                whole += X * to_fmpq(Fraction(share))
        found.append(whole)
    return found
