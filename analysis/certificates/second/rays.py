"""Solutions that grow along a ray, of loops with ReLUs, checked again: eigenvectors by the interval Newton method.

As long as no ``sigma`` of a ReLU changes its sign the loop is linear.  ``x`` and ``lambda`` with ``M x = lambda x`` are
enclosed in balls, in which every sign is what the gains say; or ``sigma`` is 0 on an invariant subspace with ``x``.
"""

from __future__ import annotations

from fractions import Fraction

from flint import arb, arb_mat, fmpq_mat

from lure.analysis.certificates.second import classes as claims
from lure.analysis.certificates.second.channels import Asked, diagonal
from lure.analysis.certificates.second.numerics import ball, to_fmpq, working_precision
from lure.analysis.certificates.second.reading import Document, NotShown, listed, number, numbers, record, require

LONGEST, BITS = 1000, 400


def refuted_by_ray(document: Document, asked: Asked) -> str:
    """What the solution does.

    Raises
    ------
    NotShown
        The gains are not of the class, or no such solution is shown to exist.
    """
    proof = record(document.proof, "method", "gains", "state", "value", "radius")
    rows, x = [numbers(row) for row in listed(proof["gains"])], numbers(proof["state"])
    require(0 < len(rows) <= (LONGEST if asked.discrete else 1), "there are too many steps, or none")
    require(all(len(row) == len(asked.nonlinearities) for row in rows), "there is not one gain for each channel")
    for row in rows:
        for i, (gain, one) in enumerate(zip(row, asked.nonlinearities, strict=True)):
            if one.relu:
                require(gain in (one.lower, one.upper), "a gain is not one of its ReLU")
            else:
                require(one.has_gain(gain) and not one.operator, "a gain is not in its class")
                require(gain == rows[0][i] == rows[0][asked.repeated[i]], "a gain is not constant, or not repeated")
    n, value, radius = asked.A.nrows(), number(proof["value"]), number(proof["radius"])
    require(len(x) == n and any(x), "the state does not fit")
    whole = diagonal([Fraction(1)] * n)
    signs = list[tuple[bool, fmpq_mat]]()
    for row in rows:
        G = diagonal(row)
        loop = diagonal([Fraction(1)] * len(row)) + asked.D * G
        require(loop.det() != 0, "with some of the gains the loop has no solution")
        sigma = loop.inv() * asked.C
        seen = sigma * whole
        for i, one in enumerate(asked.nonlinearities):
            if one.relu:
                signs.append((row[i] == one.upper, fmpq_mat([[seen[i, j] for j in range(n)]])))
        whole = (asked.A - asked.B * G * sigma) * whole
    moving = [i for i in range(n) if x[i] != 0]
    if all(whole[i, j] == 0 for j in moving for i in set(range(n)) - set(moving)):  # an invariant subspace
        whole = fmpq_mat([[whole[i, j] for j in moving] for i in moving])
        signs = [(above, fmpq_mat([[line[0, j] for j in moving]])) for above, line in signs]
        x = [x[j] for j in moving]
    held = max(range(len(x)), key=lambda i: abs(x[i]))
    with working_precision(BITS):
        state, rate = _eigenvector(whole, x, value, radius, held)
        require(bool(rate > (1 if asked.discrete else 0)), "the solution does not grow")
        for above, line in signs:
            if line == 0 * line:  # sigma is 0 all the time
                continue
            sigma_there = (arb_mat(line) * state)[0, 0]
            require(bool(sigma_there > 0) if above else bool(sigma_there < 0), "a ReLU has another gain there")
    return claims.NO_REST


def _eigenvector(
    matrix: fmpq_mat, x: list[Fraction], value: Fraction, radius: Fraction, held: int
) -> tuple[arb_mat, arb]:
    """Balls around ``x`` and ``lambda`` that hold an eigenvector, its entry ``held`` as it is, and its eigenvalue."""
    n, off = len(x), arb(0, to_fmpq(radius))
    center, around = [ball(v) for v in x], [ball(v) + (off if i != held else 0) for i, v in enumerate(x)]
    rate, M = ball(value), arb_mat(matrix)
    wide, jacobian = rate + off, arb_mat(n, n)
    for i in range(n):
        for j in range(n):  # the column of the entry held is that of lambda
            jacobian[i, j] = -around[i] if j == held else M[i, j] - (wide if i == j else 0)
    point = arb_mat([[v] for v in center])
    residue = M * point - point * rate
    try:
        step = jacobian.solve(residue)
    except ZeroDivisionError:
        raise NotShown("the eigenvector is not shown to exist") from None
    for i in range(n):
        require(bool(abs(step[i, 0]) < ball(radius)), "the eigenvector is not shown to exist")
    return arb_mat([[v] for v in around]), wide
