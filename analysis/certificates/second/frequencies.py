r"""Several nonlinearities over all frequencies, checked again: no eigenvalue of a Hamiltonian matrix on the axis.

After the shift by the lower bounds, ``Psi = M (1 + W H) + s Theta H`` gets a realisation ``(A, B, C, D)``, anticausal
kernels with eigenvalues in the right half-plane: ``F = Psi + Psi^*`` has ``(diag(A, -A'), (B; C'), (C, -B'), R)`` with
``R = D + D'``.  If ``R > 0`` and

.. math:: \begin{pmatrix} A & 0 \\ 0 & -A^\top \end{pmatrix}
    - \begin{pmatrix} B \\ C^\top \end{pmatrix} R^{-1} \begin{pmatrix} C & -B^\top \end{pmatrix}

has no eigenvalue ``i omega``, ``F`` is nowhere singular and positive definite at infinity, hence everywhere.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import product
from math import comb

from flint import fmpq, fmpq_mat, fmpq_poly

from lure.analysis.certificates.second.numerics import half_plane_counts, positive_from_zero, to_fmpq
from lure.analysis.certificates.second.pace import kernel_masses
from lure.analysis.certificates.second.reading import (
    NotShown,
    count,
    listed,
    mapping,
    number,
    numbers,
    record,
    require,
    tick,
)

MOST_CHANNELS = 8
Matrices = tuple[fmpq_mat, fmpq_mat, fmpq_mat, fmpq_mat]


@dataclass(frozen=True, slots=True)
class Chain:
    """Kernels of one rate and side that act on one column: for every order the coefficient of each row."""

    column: int
    rate: Fraction
    causal: bool
    rows: dict[int, list[tuple[int, Fraction]]]


@dataclass(frozen=True, slots=True)
class Multiplier:
    """``M = gamma - kernels``, and ``theta``; ``moved`` are the channels of which ``M`` takes more than one value."""

    gamma: list[list[Fraction]]
    theta: list[Fraction]
    chains: list[Chain]
    moved: frozenset[int]
    owed: Mapping[int, tuple[Fraction, Fraction]] = field(default_factory=dict)  # by row and column, less gamma_ii


def read_multiplier(  # noqa: PLR0913  (a multiplier, and what is known of each channel)
    theorem: str,
    value: object,
    odd: Sequence[bool],
    same: Sequence[int],
    gains: Sequence[bool],
    operators: Sequence[tuple[Sequence[int], bool]] = (),
    rate: Fraction | None = None,
) -> Multiplier:
    """The multiplier of a certificate, doubly dominant: else it is no multiplier for these classes.

    With a rate that is said by ``owed``, once the widths are known.

    Parameters
    ----------
    theorem : str
        ``diagonal-circle``, ``diagonal-popov``, ``matrix-zames-falb`` or ``matrix-scalings``.
    value : object
        As it stands in the certificate.
    odd : sequence of bool
        Whether their nonlinearities are odd.
    same : sequence of int
        For each channel the first that has the same nonlinearity.
    gains : sequence of bool
        Whether it is a constant gain, for which ``He M > 0`` on its channels is enough.
    operators : sequence of tuple
        The channels of each operator, on which ``M`` is Hermitian and positive; and whether it is one scalar operator
        in each of them: else ``M`` is a multiple of the identity.
    rate : Fraction or None
        The rate of a certificate with one.

    Raises
    ------
    NotShown
        It is not for these classes.
    """
    m = len(odd)
    if theorem not in ("matrix-zames-falb", "matrix-scalings"):
        require(theorem in ("diagonal-circle", "diagonal-popov"), "the theorem is not one over frequencies")
        return _one_each(value, gains, turned=theorem == "diagonal-popov")
    given = record(mapping(value), "gamma", "theta", "kernels")
    gamma, theta = [numbers(row) for row in listed(given["gamma"])], numbers(given["theta"])
    require(len(gamma) == len(theta) == m and all(len(row) == m for row in gamma), "gamma or theta does not fit")
    partner = {(i, j) for i in range(m) for j in range(m) if same[i] == same[j]}
    joint = {i: alike for block, alike in operators for i in block}
    chains, moved = dict[tuple[int, Fraction, bool], Chain](), set[int]()
    into, out = [Fraction(0)] * m, [Fraction(0)] * m  # absolute masses in a row and in a column
    inside = [list[tuple[int, int, Fraction, Fraction, int, bool]]() for _ in range(m)]  # kernels of an operator
    for i, j in ((i, j) for i in range(m) for j in range(m) if i != j and gamma[i][j] != 0):
        require((i, j) in partner and joint.get(i, True), "gamma couples different nonlinearities")
        require(odd[i] or i in joint or gamma[i][j] < 0, "gamma has a positive entry beside the diagonal")
        into[i], out[j] = into[i] + abs(gamma[i][j]), out[j] + abs(gamma[i][j])
        moved |= {i, j}
    for one in listed(given["kernels"]):
        tick()
        kernel = record(mapping(one), "channels", "coefficient", "rate", "order", "side")
        where = [count(x, least=1) - 1 for x in listed(kernel["channels"])]
        require(len(where) == 2 and max(where) < m, "a kernel has no such channels")
        c, decay, order = number(kernel["coefficient"]), number(kernel["rate"]), count(kernel["order"], least=1)
        require(kernel["side"] in ("causal", "anticausal") and decay > 0 and order <= 20, "a kernel is unknown")
        i, j = where
        require((i, j) in partner, "a kernel couples different nonlinearities")
        causal = kernel["side"] == "causal"
        if i in joint:
            require(i == j or joint[i], "a kernel couples the channels of an operator")
            inside[same[i]].append((i, j, c, decay, order, causal))
        else:
            require(odd[i] or c >= 0, "a kernel is negative")
            taken = kernel_masses(c, decay, order, causal=causal, rate=rate or Fraction(0))
            into[i], out[j] = into[i] + taken[0], out[j] + taken[1]
        moved |= {i, j}
        chain = chains.setdefault((j, decay, causal), Chain(j, decay, causal, {}))
        chain.rows.setdefault(order, []).append((i, c))
    made, owed = (
        Multiplier(gamma, theta, list(chains.values()), frozenset(moved)),
        dict[int, tuple[Fraction, Fraction]](),
    )
    for block, alike in operators:
        listed_here = inside[block[0]]
        adjoint = sorted((j, i, c, decay, order, not causal) for i, j, c, decay, order, causal in listed_here)
        plain = all(gamma[i][j] == gamma[j][i] for i in block for j in block)
        require(plain and sorted(listed_here) == adjoint, "the multiplier of an operator is not Hermitian")
        each = {(gamma[i][i], tuple(sorted(one[2:] for one in listed_here if one[0] == i))) for i in block}
        require(alike or len(each) == 1, "an operator has several multipliers")
        require(_is_positive(made, block), "the multiplier of an operator is not positive")
    for i in set(range(m)) - set(joint):
        if gains[i] and _is_positive(made, [j for j in range(m) if same[j] == same[i]]):
            continue
        owed[i] = into[i] - gamma[i][i], out[i] - gamma[i][i]
        require(rate is not None or max(owed[i]) <= 0, "the kernels of a row or a column outweigh gamma")
    return replace(made, owed=owed)


def _one_each(value: object, gains: Sequence[bool], *, turned: bool) -> Multiplier:
    """One multiplier for each channel, and one of Popov's where that is the theorem."""
    m, names = len(gains), ("lambda", "theta") if turned else ("lambda",)
    found = {name: numbers(side) for name, side in record(mapping(value), *names).items()}
    weights, theta = found["lambda"], found.get("theta", [Fraction(0)] * m)
    require(len(weights) == m == len(theta) and min(weights) >= 0, "the multipliers are not one for each channel, >= 0")
    gamma = [[v * (i == j) for j in range(m)] for i, v in enumerate(weights)]
    return Multiplier(gamma, theta, [], frozenset(), {i: (-v, -v) for i, v in enumerate(weights) if not gains[i]})


def require_weights(given: Multiplier, widths: Sequence[Fraction], rate: Fraction) -> None:
    """Check the sums of rows and columns at a rate ``a``.

    ``theta int a_i sigma' = (theta/w) int a_i b_i'``, up to ends, is ``a theta/w`` times the integral of ``a_i b_i -
    Phi_i``, less that of ``Phi_i``: Popov's term gives to a row what it takes from a column.

    ``widths``: of the bounds.
    """
    for i, (row, column) in given.owed.items():
        given_by = given.theta[i] * rate / widths[i]
        require(row <= given_by and column <= -given_by, "the weighted kernels of a row or a column outweigh gamma")


def _is_positive(given: Multiplier, channels: Sequence[int]) -> bool:
    """Whether ``He M > 0`` on the axis, infinity included, in the rows and columns of some channels, or ``M = 0``.

    In one channel ``Re (1 + i t)^-n = sum_k C(n, 2k) (-x)^k/(1 + x)^n``, ``x = t^2``, gives a polynomial; in several
    ``M`` is realised, without a plant.
    """
    place = {i: k for k, i in enumerate(channels)}
    chains = list[Chain]()
    for one in given.chains:
        rows = {n: [(place[i], c) for i, c in each if i in place] for n, each in one.rows.items()}
        rows = {n: each for n, each in rows.items() if each}
        if one.column in place and rows:
            chains.append(Chain(place[one.column], one.rate, one.causal, rows))
    gamma = [[given.gamma[i][j] for j in channels] for i in channels]
    if not chains and not any(map(any, gamma)):
        return True
    if len(channels) == 1:
        kernels = [(c, one.rate, n) for one in chains for n, each in one.rows.items() for _, c in each]
        return _has_real_part(gamma[0][0], kernels)
    m = len(channels)
    nothing = fmpq_mat(1, 1, [-1]), fmpq_mat(1, m), fmpq_mat(m, 1), fmpq_mat(m, m)
    part = Multiplier(gamma, [Fraction(0)] * m, chains, frozenset())
    try:
        _require_definite(_realised(nothing, nothing[2], [Fraction(1)] * m, part, nothing[3]))
    except NotShown:
        return False
    return True


def still(given: Multiplier) -> fmpq_mat:
    """``M(0)``."""
    found = [[to_fmpq(v) for v in row] for row in given.gamma]
    for chain in given.chains:
        for i, c in (one for rows in chain.rows.values() for one in rows):
            found[i][chain.column] -= to_fmpq(c)
    return fmpq_mat(found)


def _has_real_part(gamma: Fraction, kernels: Sequence[tuple[Fraction, Fraction, int]]) -> bool:
    """Whether ``Re M_ii > 0`` on the axis, infinity included."""
    total, below = fmpq_poly([to_fmpq(gamma)]), fmpq_poly([1])
    for c, rate, order in kernels:
        square = to_fmpq(1 / rate**2)
        top = [comb(order, 2 * k) * (-square) ** k for k in range(order // 2 + 1)]
        bottom = fmpq_poly([1, square]) ** order
        total = total * bottom - to_fmpq(c) * fmpq_poly(top) * below
        below *= bottom
    return gamma > 0 and positive_from_zero(total)


def require_frequencies(
    shifted: Matrices, own: fmpq_mat, widths: Sequence[Fraction], given: Multiplier, jump: fmpq_mat
) -> None:
    """Check that the loop is stable at the lower bounds, and ``F > 0`` on the whole axis, infinity included.

    Parameters
    ----------
    shifted : tuple of fmpq_mat
        ``A~, B~, C~, D~``.
    own : fmpq_mat
        ``C``, whose rows give the outputs with Popov's terms.
    widths : sequence of Fraction
        ``u_i - l_i``.
    given : Multiplier
        The multiplier.
    jump : fmpq_mat
        ``lim s H`` at 0, if the integrators were taken apart, which the loop of ``shifted`` then lacks; else 0.

    Raises
    ------
    NotShown
        One of them is not so.
    """
    n, m = shifted[0].nrows(), len(widths)
    require(m <= MOST_CHANNELS, "there are too many channels for determinants")
    require(half_plane_counts(shifted[0].charpoly()).left == n, "the loop at the lower bounds is not stable")
    _require_definite(_realised(shifted, own, widths, given, jump))


def _require_definite(realised: Matrices) -> None:
    """Check ``Psi + Psi^* > 0`` on the axis, infinity included."""
    A, B, C, D = realised
    m, R = D.nrows(), D + D.transpose()
    p = R.charpoly()  # all of its roots, which are real, are positive if its signs alternate
    require(all(c * (-1) ** (m - i) > 0 for i, c in enumerate(p.coeffs())), "F > 0 fails far out")
    back, first, second = R.inv(), _beside(C, B.transpose(), -1), _stacked(B, C.transpose())
    whole = _corners(A, A.transpose()) - second * back * first
    tick()
    q = fmpq_poly(whole.charpoly().coeffs()[0::2])  # even: q(s^2)
    sign = fmpq(1) if q[0] > 0 else fmpq(-1)
    axis = q(fmpq_poly([0, -1])) * sign  # at s^2 = -x
    require(positive_from_zero(axis), "F is singular at some frequency")


def require_vertices(D: fmpq_mat, widths: Sequence[Fraction]) -> None:
    """Check ``det(1 + D G) > 0`` for all gains in ``[0, w]``: it is affine in each.

    ``D``: after the shift; ``widths``: ``w``.

    Raises
    ------
    NotShown
        At a vertex it is not.
    """
    m = len(widths)
    for ends in product(*((Fraction(0), w) for w in widths)):
        whole = fmpq_mat([[to_fmpq(ends[j]) * D[i, j] + (i == j) for j in range(m)] for i in range(m)])
        require(bool(whole.det() > 0), "det(1 + D G) vanishes for gains within the bounds")


def _realised(
    shifted: Matrices, own: fmpq_mat, widths: Sequence[Fraction], given: Multiplier, apart: fmpq_mat
) -> Matrices:
    """``Psi``: the loop, then a chain of first-order lags for each column, rate and side."""
    A, B, C, D = shifted
    n, m = A.nrows(), len(widths)
    depth = [max(chain.rows) for chain in given.chains]  # lags in a row
    size = n + sum(depth)
    state = [[fmpq(0)] * size for _ in range(size)]
    inward = [[fmpq(0)] * m for _ in range(size)]
    outward = [[fmpq(0)] * size for _ in range(m)]
    W = [to_fmpq(w) for w in widths]
    seen = [[W[j] * C[j, k] for k in range(n)] for j in range(m)]  # (1 + W H) p: rows of states, then of p
    direct = [[W[j] * D[j, k] + (j == k) for k in range(m)] for j in range(m)]
    for i in range(n):
        state[i][:n] = [A[i, k] for k in range(n)]
        inward[i] = [B[i, k] for k in range(m)]
    at = n
    for chain, length in zip(given.chains, depth, strict=True):
        rate = to_fmpq(chain.rate if chain.causal else -chain.rate)  # z' = -a z + a y, or z' = a z - a y
        for k in range(length):
            state[at + k][at + k] = -rate
            if k:
                state[at + k][at + k - 1] = rate
            else:
                state[at][:n] = [rate * v for v in seen[chain.column]]
                inward[at] = [rate * v for v in direct[chain.column]]
        for order, rows in chain.rows.items():
            for i, c in rows:
                outward[i][at + order - 1] -= to_fmpq(c)
        at += length
    slow = _integrated(given, [[W[j] * apart[j, k] for k in range(m)] for j in range(m)])
    turned, jump = own * A, own * B + apart
    G = [[to_fmpq(v) for v in row] for row in given.gamma]
    through = [[fmpq(0)] * m for _ in range(m)]
    for i, theta in enumerate(map(to_fmpq, given.theta)):
        for k in range(n):
            outward[i][k] += sum((G[i][j] * seen[j][k] for j in range(m)), theta * turned[i, k])
        for k in range(m):
            through[i][k] = sum((G[i][j] * direct[j][k] for j in range(m)), theta * jump[i, k])
    main = fmpq_mat(state), fmpq_mat(inward), fmpq_mat(outward), fmpq_mat(through)
    return main if slow is None else _sum(main, slow)


def _integrated(given: Multiplier, residue: list[list[fmpq]]) -> tuple[fmpq_mat, fmpq_mat, fmpq_mat] | None:
    """``(M(s) - M(0)) W R/s`` as states: ``(h^n - 1)/s = -(h + ... + h^n)/a`` for ``h = a/(a + s)``.

    None where there is no residue or no kernel.
    """
    m, size = len(residue), sum(max(chain.rows) for chain in given.chains)
    if not size or not any(v != 0 for row in residue for v in row):
        return None
    state, inward = [[fmpq(0)] * size for _ in range(size)], [[fmpq(0)] * m for _ in range(size)]
    outward, at = [[fmpq(0)] * size for _ in range(m)], 0
    for chain in given.chains:
        rate = to_fmpq(chain.rate if chain.causal else -chain.rate)
        length = max(chain.rows)
        for k in range(length):
            state[at + k][at + k] = -rate
            if k:
                state[at + k][at + k - 1] = rate
        inward[at] = [rate * v for v in residue[chain.column]]
        for order, rows in chain.rows.items():
            for i, c in rows:
                for k in range(order):
                    outward[i][at + k] += to_fmpq(c) / rate
        at += length
    return fmpq_mat(state), fmpq_mat(inward), fmpq_mat(outward)


def _sum(one: Matrices, other: tuple[fmpq_mat, fmpq_mat, fmpq_mat]) -> Matrices:
    (A, B, C, D), (F, G, H) = one, other
    n, k = A.nrows(), F.nrows()
    whole = [[*row, *[fmpq(0)] * k] for row in _rows(A)] + [[*[fmpq(0)] * n, *row] for row in _rows(F)]
    return fmpq_mat(whole), _stacked(B, G), _beside(C, H, 1), D


def _rows(X: fmpq_mat) -> list[list[fmpq]]:
    return [[X[i, j] for j in range(X.ncols())] for i in range(X.nrows())]


def _beside(X: fmpq_mat, Y: fmpq_mat, sign: int) -> fmpq_mat:
    return fmpq_mat([[*a, *(sign * v for v in b)] for a, b in zip(_rows(X), _rows(Y), strict=True)])


def _stacked(X: fmpq_mat, Y: fmpq_mat) -> fmpq_mat:
    return fmpq_mat([*_rows(X), *_rows(Y)])


def _corners(X: fmpq_mat, Y: fmpq_mat) -> fmpq_mat:
    """``diag(X, -Y)``."""
    n, k = X.nrows(), Y.nrows()
    top = [[*row, *[fmpq(0)] * k] for row in _rows(X)]
    return fmpq_mat([*top, *([*[fmpq(0)] * n, *(-v for v in row)] for row in _rows(Y))])
