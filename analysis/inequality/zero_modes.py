r"""Eigenvalues 0 of the loop of several channels at the lower bounds (1 in discrete time), taken apart exactly.

With ``A N = 0``, ``K A = 0``, ``K N = 1`` the state is ``x = N x_0 + x_1``, ``x_0' = K B mu``, and ``H = R/s + H_1``
with the residue ``R = C N K B``.  For weights ``Lambda`` with ``Lambda R = R' Lambda`` positive semidefinite, of rank
``r``, the number of these eigenvalues, ``P_0 (K B) = (C N)' Lambda`` has one solution, ``P_0 > 0``; ``V`` contains
``x_0' P_0 x_0``, and what is left is an inequality about ``x_1``: ``docs/theory/integrators.md``.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

from flint import fmpq, fmpq_mat, fmpq_poly

from lure.arrays import NDArray, np
from lure.errors import AssumptionError, Reason
from lure.record import described, quantity

Rows = Sequence[Sequence[Fraction]]
Exact: TypeAlias = "NDArray[np.object_]"  # of fractions


class Loop(NamedTuple):
    """``A``, ``B``, ``C`` and ``D``, in fractions."""

    A: Exact
    B: Exact
    C: Exact
    D: Exact


class Free(NamedTuple):
    """What equations leave free: the unknowns are ``basis`` times free ones; which of them are 0."""

    basis: fmpq_mat
    absent: set[int]


@described(frozen=True)
class ZeroModes:
    """The null space of the loop, and which weights its residue permits."""

    right: fmpq_mat = quantity("(n, r) ``N`` in echelon form")
    left: fmpq_mat = quantity("(r, n) ``K``")
    inputs: fmpq_mat = quantity("(r, m) ``K B``")
    seen: fmpq_mat = quantity("(m, n) ``C``")
    ratios: tuple[tuple[int, Fraction], ...] = quantity(
        "For each channel: its weight is the ratio times that of the channel, counted from 0"
    )

    @property
    def outputs(self) -> fmpq_mat:
        """(m, r) ``C N``."""
        return self.seen * self.right

    @cached_property
    def turn(self) -> fmpq_mat:
        """(n, n) ``(x_0, x_1)`` of ``x``, ``x = N x_0 + X x_1`` with ``K X = 0``."""
        beside = self.right.tolist()
        if self.right.nrows() > self.right.ncols():
            beside = [a + b for a, b in zip(beside, null_rows(self.left).transpose().tolist(), strict=True)]
        return fmpq_mat(beside).inv()

    def apart(self, loop: Sequence[Rows]) -> Loop:
        """The loop in the states ``(x_0, x_1)``.

        ``loop``: ``A``, ``B``, ``C`` and ``D``, shifted by the lower bounds.
        """
        A, B, C, D = map(exact, loop)
        back = self.turn.inv()
        return Loop(*map(fractions, (self.turn * A * back, self.turn * B, C * back, D)))

    def residue(self) -> NDArray[np.float64]:
        """``R`` (m, m) [unit of sigma / unit of mu / s; in discrete time without s]."""
        return doubles(self.outputs * self.inputs)

    def weights(self, near: Sequence[Fraction]) -> list[Fraction]:
        """The weights with these ratios next to given ones.

        ``near``: one for each channel, of which those count that are their own ratio.
        """
        return [ratio * near[first] for first, ratio in self.ratios]

    def energy(self, weights: Sequence[Fraction]) -> fmpq_mat:
        """``P_0`` with ``P_0 (K B) = (C N)' Lambda``; ``weights``: ``Lambda``."""
        side = self.outputs.transpose() * diagonal(weights) * self.inputs.transpose()
        return side * (self.inputs * self.inputs.transpose()).inv()


def zero_modes(A: Rows, B: Rows, C: Rows, *, discrete: bool) -> ZeroModes | None:
    """The eigenvalues 0 (1) of a loop, None if there are none.

    ``A``, ``B``, ``C``: (n, n), (n, m) and (m, n) of the loop shifted by the lower bounds.

    Raises
    ------
    AssumptionError
        The theorem does not cover them: LURE-I012, with the hypothesis that fails.

    Examples
    --------
    >>> one, half = Fraction(1), Fraction(1, 2)
    >>> found = zero_modes([[0 * one] * 2] * 2, [[one, 2 * one], [half, 3 * one]], [[one, 0], [0, one]], discrete=False)
    >>> found.ratios == ((0, 1), (0, 4))
    True
    """
    n, m = len(A), len(C)
    turned = exact(A) - diagonal([Fraction(int(discrete))] * n)
    r = n - turned.rank()
    if not r:
        return None
    right, left = null_rows(turned).transpose(), null_rows(turned.transpose())
    overlap = left * right
    why = "its multiplicity is higher" if overlap.det() == 0 else ""
    if not why:
        left = overlap.inv() * left
        inputs, outputs = left * exact(B), exact(C) * right
        R = outputs * inputs
        ratios = _ratios([[R[i, j] for j in range(m)] for i in range(m)])
        words = "[" + ", ".join("[" + ", ".join(map(str, row)) + "]" for row in R.tolist()) + "]"
        found = ZeroModes(right, left, inputs, exact(C), tuple(ratios))
        p = (diagonal(found.weights([Fraction(1)] * len(ratios))) * R).charpoly() if ratios else fmpq_poly()
        if R.rank() < r:
            why = f"its residue R = {words:.120} has the rank {R.rank()}: the channels do not move or see all"
        elif not ratios:
            why = f"no weights > 0 make Lambda R symmetric, R = {words:.120} being its residue"
        elif not all(p[m - k] * (-1) ** k > 0 for k in range(r + 1)):
            why = f"Lambda R has a negative eigenvalue, R = {words:.120} being its residue"
        else:
            return found
    raise AssumptionError(
        f"with the gains at the lower bounds the eigenvalue {int(discrete)} of the loop has {r} "
        f"eigenvector{'s' * (r > 1)} (the critical case), and {why}; give lower bounds above these",
        code=Reason.CRITICAL,
    )


def whole(
    modes: ZeroModes,
    near: tuple[Sequence[Sequence[int]], int],
    weights: Sequence[Fraction],
    theta: Sequence[Fraction],
    lower: Sequence[Fraction],
) -> tuple[int, dict[str, Any]]:
    """A proof with ``V = x_0' P_0 x_0 + x_1' Q x_1 + ...`` exactly, times the integer that is given first.

    Parameters
    ----------
    modes : ZeroModes
        The integrators.
    near : tuple
        A lower triangle of integers and an exponent: ``Q``, of which the part for ``x_1`` counts.
    weights, theta, lower : sequence of Fraction
        ``Lambda`` with the ratios of ``modes``, Popov's terms, and the lower bounds.

    Returns
    -------
    tuple of int and dict
        By what ``lambda`` and ``theta`` are to be multiplied, and the proof.
    """
    (rows, exponent), n = near, modes.right.nrows()
    Q = fmpq_mat([[fmpq(rows[max(i, j)][min(i, j)], 2**exponent) for j in range(n)] for i in range(n)])
    rest = diagonal([Fraction(1)] * n) - modes.right * modes.left
    turned = diagonal([t * v for t, v in zip(theta, lower, strict=True)])
    P = rest.transpose() * Q * rest + modes.left.transpose() * modes.energy(weights) * modes.left
    entries, factor = (P - modes.seen.transpose() * turned * modes.seen).numer_denom()
    phi = diagonal(lower) * modes.outputs
    zero = [[*map(str, v)] for v in zip(*modes.right.tolist(), *phi.tolist(), strict=True)]
    P_rows = [[str(entries[i, j]) for j in range(i + 1)] for i in range(n)]
    return int(factor), {"method": "matrix", "P": P_rows, "exponent": 0, "zero": zero}


def _ratios(R: list[list[fmpq]]) -> list[tuple[int, Fraction]]:
    """``lambda_i R_ij = lambda_j R_ji``: along each chain of channels the ratios are given; [] if none are > 0."""
    m, found = len(R), dict[int, tuple[int, fmpq]]()
    for start in range(m):
        pending = [] if start in found else [start]
        found.setdefault(start, (start, fmpq(1)))
        while pending:
            i = pending.pop()
            for j in range(m):
                if R[i][j] * R[j][i] < 0 or (R[i][j] == 0) != (R[j][i] == 0):
                    return []
                if j not in found and R[i][j] != 0:
                    found[j] = found[i][0], found[i][1] * R[i][j] / R[j][i]
                    pending.append(j)
    if any(found[i][1] * R[i][j] != found[j][1] * R[j][i] for i in range(m) for j in range(m)):
        return []
    return [(found[i][0], Fraction(int(found[i][1].p), int(found[i][1].q))) for i in range(m)]


def null_rows(M: fmpq_mat) -> fmpq_mat:
    """A basis of the null space, one row each, in echelon form; ``M``: any; without a null space no rows."""
    reduced, rank = M.rref()
    n = M.ncols()
    if rank == n:
        return fmpq_mat(0, n)
    pivots = [next(j for j in range(n) if reduced[i, j] != 0) for i in range(rank)]
    basis = []
    for k in (j for j in range(n) if j not in pivots):
        row = [fmpq(int(j == k)) for j in range(n)]
        for i, pivot in enumerate(pivots):
            row[pivot] = -reduced[i, k]
        basis.append(row)
    return fmpq_mat(basis).rref()[0]


def exact(rows: Rows) -> fmpq_mat:
    """A matrix of fractions."""
    return fmpq_mat([[fmpq(int(v.numerator), int(v.denominator)) for v in row] for row in rows])


def diagonal(values: Sequence[Fraction]) -> fmpq_mat:
    """A diagonal matrix."""
    n = len(values)
    return exact([[v if i == j else Fraction(0) for j in range(n)] for i, v in enumerate(values)])


def doubles(M: fmpq_mat) -> NDArray[np.float64]:
    """The entries, rounded."""
    return np.array([[float(Fraction(int(v.p), int(v.q))) for v in row] for row in M.tolist()])


def freed(rows: Exact, positive: Sequence[bool]) -> Free:
    """The solutions of equations in unknowns of which some are not negative: those of a row of one sign are 0.

    ``rows``: (equations, unknowns), of fractions.

    Examples
    --------
    >>> rows = np.array([[1, -2, 0, 0], [0, 0, 1, 3]], dtype=object)
    >>> found = freed(rows, [False, True, True, True])
    >>> found.basis.tolist() == [[2], [1], [0], [0]], found.absent
    (True, {2, 3})
    """
    absent, count = set[int](), len(positive)
    while True:
        kept = [j for j in range(count) if j not in absent]
        reduced, rank = fmpq_mat([[fmpq(row[j]) for j in kept] for row in rows.tolist()]).rref()
        lines = [[(kept[j], reduced[i, j]) for j in range(len(kept)) if reduced[i, j] != 0] for i in range(rank)]
        gone = set[int]()
        for line in lines:
            if all(positive[j] for j, _ in line) and all(v > 0 for _, v in line):
                gone |= {j for j, _ in line}
        if not gone:
            break
        absent |= gone
    pivots = [line[0][0] for line in lines]
    free = [j for j in kept if j not in pivots]
    basis = fmpq_mat(count, len(free))
    for k, j in enumerate(free):
        basis[j, k] = fmpq(1)
        for pivot, line in zip(pivots, lines, strict=True):
            basis[pivot, k] = -dict(line).get(j, fmpq(0))
    return Free(basis, absent)


def fractions(M: fmpq_mat) -> Exact:
    """A matrix as an array of fractions."""
    return np.array(M.tolist(), dtype=object).reshape(M.nrows(), M.ncols())


def floats(M: Exact) -> NDArray[np.float64]:
    """An array of fractions or integers, rounded."""
    flat = [float(Fraction(int(fmpq(v).p), int(fmpq(v).q))) for v in M.ravel()]
    return np.array(flat).reshape(M.shape)
