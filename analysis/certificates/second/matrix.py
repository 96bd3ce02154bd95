r"""Lyapunov matrices: a quadratic form that falls along every solution, tested in ball arithmetic.

With ``x' = A x + b mu``, ``sigma = c x + D mu`` after the shift and ``rho`` the residue at 0 (0 in the principal case)
``V = x'P x + xi^2/rho + 2 theta int phi`` satisfies ``V' <= -[x; mu]' M [x; mu] - 2 phi (sigma - phi/w)``,

.. math::

    M = \begin{pmatrix} -(A'P + PA) & -Pb + c' + \theta A'c' \\ \cdot & 2/w + 2\theta (cb + \rho) + 2D \end{pmatrix},

and in discrete time, ``theta = 0``, ``V = x'P x + xi^2/rho``, with ``P - A'PA``, ``-A'Pb + c'`` and
``2/w + 2D - rho - b'Pb``.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from flint import arb, arb_mat, fmpz

from lure.analysis.certificates.second.classes import Claim, Nonlinearities
from lure.analysis.certificates.second.numerics import ball, balls, working_precision
from lure.analysis.certificates.second.reading import (
    NotShown,
    count,
    listed,
    number,
    numbers,
    record,
    require,
    tick,
    whole,
)
from lure.analysis.certificates.second.systems import Case, Rational, Row

BITS = (256, 1024, 4096)
DIRECT = 6
LARGEST_EXPONENT = 1_000_000


@dataclass(frozen=True, kw_only=True, slots=True)
class State:
    """State equations without the pole at 0: ``x' = A x + b mu``, ``xi' = rho mu``, ``sigma = c x + xi + D mu``."""

    A: tuple[Row, ...]
    b: Row
    c: Row
    direct: Fraction
    rho: Fraction


def require_matrix(system: Rational, claim: Claim, theta: Fraction, proof: object) -> Case:
    """Check ``P > 0`` and ``M > 0``; the case is critical if a zero eigenvalue was split off.

    Parameters
    ----------
    system : Rational
        The block before the shift.
    claim : Claim
        Its ``lower`` and ``inverse_gain = 1/w``.
    theta : Fraction
        Popov multiplier, 0 for the circle criterion.
    proof : object
        ``P`` in integers, the lower triangle row by row, the exponent, and the zero eigenvalue.

    Raises
    ------
    NotShown
        A matrix is not shown to be positive definite, or the zero eigenvalue is not simple with a positive residue.
    """
    found = record(proof, "method", "P", "exponent", "zero")
    require(not (system.discrete and theta != 0), "Popov's criterion is for continuous time")
    states = _shifted(system, claim.lower)
    case: Case = "stable"
    if found["zero"] is not None:
        states = [_deflated(state, found["zero"], discrete=system.discrete) for state in states]
        require(all(state.rho > 0 for state in states), "the residue at the pole 0 is not positive")
        case = "critical"
    n = len(states[0].b)
    rows = triangle(found["P"], n)
    exponent = count(found["exponent"], least=-LARGEST_EXPONENT)
    require(exponent <= LARGEST_EXPONENT, "the exponent of P is too large")
    for bits in BITS:
        with working_precision(bits):
            unit = arb(2) ** -exponent
            P = arb_mat([[arb(rows[max(i, j)][min(i, j)]) * unit for j in range(n)] for i in range(n)])
            definite = positive_definite(P)
            if definite and any(
                positive_definite(_form(state, P, claim.inverse_gain, theta, discrete=system.discrete))
                for state in states
            ):
                return case
    raise NotShown("P or the matrix of the inequality is not shown to be positive definite")


def require_growth(system: Rational, nonlinearities: Nonlinearities, proof: object) -> None:
    """Check that a gain of the class makes a solution grow: ``V = x'P x`` falls everywhere and is negative somewhere.

    Parameters
    ----------
    system : Rational
        The block.
    nonlinearities : Nonlinearities
        The class, of which the gain is a member.
    proof : object
        The gain, ``P`` in integers, the lower triangle row by row, and a state with ``V < 0``.

    Raises
    ------
    NotShown
        One of these is not shown.
    """
    found = record(proof, "method", "gain", "P", "start")
    gain, start, r = number(found["gain"]), numbers(found["start"]), system.states
    require(nonlinearities.has_gain(gain), "the gain is not in the class")
    require(1 + gain * r.d != 0, "with this gain the loop has no solution")
    rows = triangle(found["P"], r.order)
    require(len(start) == r.order, "the start is no state of this order")
    value = sum(
        ((1 + (j < i)) * int(v) * start[i] * start[j] for i, row in enumerate(rows) for j, v in enumerate(row)),
        Fraction(0),
    )
    require(value < 0, "the form is not negative at the start")
    closed = r.closed(gain)
    for bits in BITS:
        with working_precision(bits):
            A = balls(closed)
            P = arb_mat([[arb(rows[max(i, j)][min(i, j)]) for j in range(r.order)] for i in range(r.order)])
            moved = A.transpose() * P
            if positive_definite(P - moved * A if system.discrete else -(moved + moved.transpose())):
                return
    raise NotShown("the form is not shown to fall along every solution")


def triangle(rows: object, order: int) -> list[list[fmpz]]:
    """The lower triangle of integers, row by row.

    ``rows``: as they stand in the file; ``order``: how many there must be.
    """
    found = [[whole(entry) for entry in listed(row)] for row in listed(rows)]
    require([len(row) for row in found] == list(range(1, order + 1)), "P is not a lower triangle of this order")
    return found


def positive_definite(M: arb_mat) -> bool:
    """Whether a symmetric matrix is shown to be positive definite: first block and Schur complement, each halved."""
    n = M.nrows()
    if n <= DIRECT:
        return _eliminated([[M[i, j] for j in range(n)] for i in range(n)])
    half = n // 2
    first, side = _part(M, 0, half, 0, half), _part(M, 0, half, half, n)
    if not positive_definite(first):
        return False
    try:
        solved = first.solve(side)
    except ZeroDivisionError:
        return False
    return positive_definite(_part(M, half, n, half, n) - side.transpose() * solved)


def _eliminated(rows: list[list[arb]]) -> bool:
    n = len(rows)
    for i in range(n):
        tick()
        if not rows[i][i] > 0:
            return False
        for j in range(i + 1, n):
            factor = rows[j][i] / rows[i][i]
            rows[j] = [v - factor * u for v, u in zip(rows[j], rows[i], strict=True)]
    return True


def _part(M: arb_mat, top: int, bottom: int, left: int, right: int) -> arb_mat:
    return arb_mat([[M[i, j] for j in range(left, right)] for i in range(top, bottom)])


def _form(state: State, P: arb_mat, inverse_gain: Fraction, theta: Fraction, *, discrete: bool) -> arb_mat:
    """``M`` at the working precision."""
    n = len(state.b)
    direct = 2 * ball(inverse_gain) + 2 * ball(state.direct)
    if n == 0:
        return arb_mat([[direct + 2 * ball(theta * state.rho) - (ball(state.rho) if discrete else 0)]])
    A, b, c = balls(state.A), balls([[v] for v in state.b]), balls([[v] for v in state.c])
    transposed = A.transpose()
    if discrete:
        main, side = P - transposed * P * A, c - transposed * P * b
        corner = direct - ball(state.rho) - (b.transpose() * P * b)[0, 0]
    else:
        main, side = -(transposed * P + P * A), c - P * b + transposed * c * ball(theta)
        corner = direct + 2 * ball(theta) * ((c.transpose() * b)[0, 0] + ball(state.rho))
    rows = [[*(main[i, j] for j in range(n)), side[i, 0]] for i in range(n)]
    return arb_mat([*rows, [*(side[i, 0] for i in range(n)), corner]])


def _shifted(system: Rational, lower: Fraction) -> list[State]:
    """The loop after the shift; with a direct term the factor ``1/(1 + l D)`` may belong to ``b`` or to ``c``."""
    r = system.states
    beta = 1 / (1 + lower * r.d)
    A = r.closed(lower) if lower else r.A
    return [
        State(
            A=A,
            b=tuple(left * v for v in r.b),
            c=tuple(beta * beta / left * v for v in r.c),
            direct=r.d * beta,
            rho=Fraction(0),
        )
        for left in dict.fromkeys((Fraction(1), beta, beta * beta))
    ]


def _deflated(state: State, zero: object, *, discrete: bool) -> State:
    """The block without its eigenvalue 0 (1 in discrete time), in the coordinates ``x_j - (x0_j/x0_p) x_p``."""
    found = record(zero, "right", "left", "pivot")
    x0, left, n = numbers(found["right"]), numbers(found["left"]), len(state.b)
    p = count(found["pivot"])
    require(len(x0) == n and len(left) == n and p < n and x0[p] != 0, "the eigenvectors of 0 do not fit")
    eigenvalue = Fraction(int(discrete))
    for j in range(n):
        tick()
        require(_dot(state.A[j], x0) == eigenvalue * x0[j], "the right eigenvector is none")
        require(_dot([row[j] for row in state.A], left) == eigenvalue * left[j], "the left eigenvector is none")
    overlap = _dot(left, x0)
    require(overlap != 0, "the eigenvalue 0 is not simple")
    gain = _dot(state.c, x0) / overlap
    kept = [j for j in range(n) if j != p]
    share = {j: x0[j] / x0[p] for j in kept}
    return State(
        A=tuple(tuple(state.A[j][k] - share[j] * state.A[p][k] for k in kept) for j in kept),
        b=tuple(state.b[j] - share[j] * state.b[p] for j in kept),
        c=tuple(state.c[k] - gain * left[k] for k in kept),
        direct=state.direct,
        rho=gain * _dot(left, state.b),
    )


def _dot(left: list[Fraction] | Row, right: list[Fraction] | Row) -> Fraction:
    return sum((u * v for u, v in zip(left, right, strict=True) if u and v), Fraction(0))
