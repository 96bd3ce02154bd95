"""Forms of several samples, checked again."""

from __future__ import annotations

from fractions import Fraction

from flint import arb_mat, fmpq, fmpq_mat

from lure.analysis.certificates.second.channels import Asked, acyclic, closed_by, cut, half_plane_stable, stacked
from lure.analysis.certificates.second.matrix import BITS, LARGEST_EXPONENT, positive_definite, triangle
from lure.analysis.certificates.second.numerics import (
    to_fmpq,
    working_precision,
)
from lure.analysis.certificates.second.order import require_positive_on_orders
from lure.analysis.certificates.second.reading import (
    Document,
    NotShown,
    count,
    flag,
    listed,
    numbers,
    record,
    require,
)

LARGEST, MOST_VERTICES, MOST_BOXES, LONGEST, SQUARINGS = 400, 10, 20_000, 10_000, 80


def require_windows(document: Document, asked: Asked) -> None:
    """Forms of ``T`` samples: ``V(xi+) - V(xi) + sum w' M w < 0``, and ``w' M w > 0`` on the order cones."""
    found, proof = record(document.multiplier, "windows", "odd"), record(document.proof, "method", "P", "exponent")
    require(proof["method"] == "matrix" and asked.discrete, "forms of several samples: by matrices, in discrete time")
    firsts = sorted(set(asked.repeated))
    windows = [[numbers(row) for row in listed(one)] for one in listed(found["windows"])]
    odd = [flag(one) for one in listed(found["odd"])]
    require(len(firsts) == len(windows) == len(odd), "there is not one form for each nonlinearity")
    n, m, T = asked.A.nrows(), asked.D.nrows(), len(windows[0]) // (2 * asked.repeated.count(0))
    require(T > 0 and acyclic(asked.D), "there are no samples, or D has a cycle of channels")
    slopes = [nonlinearities.slope for nonlinearities in asked.nonlinearities]
    ends = [one for one in slopes if one is not None and all(isinstance(end, Fraction) for end in one)]
    require(len(ends) == m, "a channel has no finite slope bounds")
    low, high = ([Fraction(one[side]) for one in ends] for side in (0, 1))
    closed = closed_by(asked, low)
    require(closed is not None and half_plane_stable(closed), "the loop with the least slopes is not stable")
    size, order = n + m * T, n + m * (T - 1)
    unit = fmpq_mat([[int(i == j) for j in range(size)] for i in range(size)])
    phi = [cut(unit, n + m * t, m) for t in range(T)]
    x, sigma, later = cut(unit, 0, n), list[fmpq_mat](), unit
    for t in range(T):
        sigma.append(asked.C * x - asked.D * phi[t])
        x = asked.A * x - asked.B * phi[t]
        later = stacked(x, cut(unit, n + m, order - n)) if t == 0 else later
    total = fmpq_mat(size, size)
    for first, rows, only_odd in zip(firsts, windows, odd, strict=True):
        block = [i for i in range(m) if asked.repeated[i] == first]
        given = asked.nonlinearities[first]
        require(len(rows) == 2 * T * len(block), "a form has another number of samples")
        require(not (given.time_varying or given.rough), "the nonlinearities are fixed in time and locally Lipschitz")
        require(given.odd or not only_odd, "a form is for odd nonlinearities")
        require_positive_on_orders(rows, odd=only_odd)
        M = fmpq_mat([[to_fmpq(rows[max(i, j)][min(i, j)]) for j in range(len(rows))] for i in range(len(rows))])
        u = [cut(phi[t], i, 1) - to_fmpq(low[i]) * cut(sigma[t], i, 1) for t in range(T) for i in block]
        v = [to_fmpq(high[i]) * cut(sigma[t], i, 1) - cut(phi[t], i, 1) for t in range(T) for i in block]
        w = fmpq_mat([[line[0, j] for j in range(size)] for line in (*u, *v)])
        total += w.transpose() * M * w
    exponent = count(proof["exponent"], least=-LARGEST_EXPONENT)
    require(exponent <= LARGEST_EXPONENT, "the exponent of P is too large")
    half, scale = triangle(proof["P"], order), to_fmpq(Fraction(2)) ** -exponent
    P = fmpq_mat([[fmpq(half[max(i, j)][min(i, j)]) * scale for j in range(order)] for i in range(order)])
    now = cut(unit, 0, order)
    falls = now.transpose() * P * now - later.transpose() * P * later - total
    for bits in BITS:
        with working_precision(bits):
            if positive_definite(arb_mat(falls)):
                return
    raise NotShown("the matrix of the inequality is not shown to be positive definite")
