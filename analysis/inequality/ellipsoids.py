r"""Invariant ellipsoids of a loop whose nonlinearities are bounded only near 0: a convex search, in floating point.

In the coordinates ``psi = u sigma - phi`` the loop is ``x' = A x + B psi``, ``sigma = C x + D psi``, and each channel
offers one term ``psi (w sigma - psi - h x) >= 0`` on the ellipsoid ``x'P x <= 1``: of a sector ``[l, u]`` that holds
for ``|sigma| <= c`` with ``w = u - l`` and ``h = 0``, if ``|sigma| <= c`` there; of a line with limits, ``phi = e sigma
+ p``, with ``w = u - e`` and any ``h`` with ``|h x| <= limit`` there.  With ``W = P^{-1}``, ``Y = h W`` and ``S`` the
inverse of the weights

.. math::

    \begin{pmatrix} AW + WA' & BS + (wCW - Y)' \\ \cdot & -2S + wDS + SD'w \end{pmatrix} < 0, \qquad
    \begin{pmatrix} W & Y_i' \\ Y_i & \text{limit}_i^2 \end{pmatrix} \ge 0

is linear in ``W``, ``Y`` and ``S`` (Hu and Lin 2001, Gomes da Silva and Tarbouriech 2005); in discrete time with the
Schur complement of ``(AW, BS)``.  Nothing is proved here: what is found is rounded, and a certificate decides.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

from lure.analysis.numerics.semidefinite import Block, proposed, symmetric_basis
from lure.arrays import NDArray, np

Matrix: TypeAlias = "NDArray[np.float64]"


class Local(NamedTuple):
    """What is used of one nonlinearity: its bounds, and the limit of ``p`` or the reach of the sector."""

    lower: float  # l, or the slope e outside the limits
    upper: float
    limit: float | None  # of |h x|; None: a sector
    reach: float  # of |C x|, less what feeds through; for a sector alone


class Ellipsoid(NamedTuple):
    """``x'P x <= 1``, with the weight of each channel and the row ``h`` of those with limits, else 0."""

    P: Matrix
    weights: Matrix
    rows: Matrix

    @property
    def size(self) -> float:
        """The logarithm of its volume, up to a constant."""
        return -0.5 * float(np.linalg.slogdet(self.P)[1])


def shifted(plant: Sequence[Matrix], upper: Matrix) -> tuple[Matrix, Matrix, Matrix, Matrix]:
    """``A``, ``B``, ``C`` and ``D`` of the loop in ``psi = upper sigma - phi``.

    Parameters
    ----------
    plant : sequence of ndarray
        ``A`` (n, n), ``B`` (n, m), ``C`` (m, n) and ``D`` (m, m), with ``mu = -phi(sigma)``.
    upper : ndarray
        (m,) gains.
    """
    A, B, C, D = plant
    back = np.linalg.inv(np.eye(len(D)) + D * upper)
    gain = B * upper
    return A - gain @ back @ C, B - gain @ back @ D, back @ C, back @ D


def ellipsoid(
    plant: Sequence[Matrix],
    local: Sequence[Local],
    *,
    discrete: bool,
    points: Matrix | None = None,
    margin: float = 1e-7,
) -> Ellipsoid | None:
    """About the largest invariant ellipsoid: of the largest volume, or that holds the largest multiple of given points.

    Parameters
    ----------
    plant : sequence of ndarray
        ``A``, ``B``, ``C`` and ``D``.
    local : sequence of Local
        What is used of each nonlinearity.
    discrete : bool
        Whether time is discrete.
    points : ndarray or None
        (k, n) points, None for the volume.
    margin : float
        By which the inequality is to hold, relative to its terms.

    Returns
    -------
    Ellipsoid or None
        None where the solver finds none; else what has still to be proved.
    """
    first = _solved(plant, local, points, max(margin, 1e-5), discrete=discrete)
    if first is None:
        return None
    scale = np.linalg.cholesky(np.linalg.inv(first.P))  # x = scale z, in which the first ellipsoid is the unit ball
    A, B, C, D = plant
    back = np.linalg.inv(scale)
    turned = (back @ A @ scale, back @ B, C @ scale, D)
    second = _solved(turned, local, None if points is None else points @ back.T, margin, discrete=discrete)
    if second is None:
        return first
    return Ellipsoid(back.T @ second.P @ back, second.weights, second.rows @ back)


def _solved(
    plant: Sequence[Matrix], local: Sequence[Local], points: Matrix | None, margin: float, *, discrete: bool
) -> Ellipsoid | None:
    n, m = plant[1].shape
    upper, low = (np.array([one[i] for one in local], dtype=float) for i in (1, 0))
    A, B, C, D = shifted(plant, upper)
    w = (upper - low)[:, None]
    free = [i for i, one in enumerate(local) if one.limit is not None]
    basis = symmetric_basis(n)
    s, k = len(basis), len(basis) + len(free) * n
    count = k + m + (len(basis) + n if points is None else 1)

    def spread(parts: Sequence[tuple[int, Matrix]], order: int) -> Block:
        """A block without a constant from the slopes at the variables from each place on."""
        slopes = np.zeros((count, order, order))
        for place, matrices in parts:
            slopes[place : place + len(matrices)] += matrices
        return Block(np.zeros((order, order)), slopes)

    Y = np.zeros((len(free) * n, m, n))
    for a, i in enumerate(free):
        Y[np.arange(a * n, (a + 1) * n), i, np.arange(n)] = 1.0
    S = np.zeros((m, m, m))
    S[np.arange(m), np.arange(m), np.arange(m)] = 1.0
    last = 2 * (1 - margin) * S - w * (D @ S) - np.swapaxes(w * (D @ S), 1, 2)
    order = (2 * n if discrete else n) + m
    one, two, three = slice(0, n), slice(n, n + m), slice(n + m, order)
    ofW, ofY, ofS = np.zeros((s, order, order)), np.zeros((len(Y), order, order)), np.zeros((m, order, order))
    ofW[:, two, one] = -w * (C @ basis)
    ofY[:, two, one] = Y
    ofS[:, two, two] = last
    if discrete:
        ofW[:, one, one], ofW[:, three, one], ofW[:, three, three] = (1 - margin) * basis, A @ basis, basis
        ofS[:, three, two] = B @ S
    else:
        moved = A @ basis
        size = max(float(np.linalg.norm(A, 2)), 1e-9)
        ofW[:, one, one] = -(moved + np.swapaxes(moved, 1, 2)) - margin * size * basis
        ofS[:, two, one] = -np.swapaxes(B @ S, 1, 2)
    lower = [(0, ofW), (s, ofY), (k, ofS)]
    below, beside = np.tril_indices(order, -1)
    for _, part in lower:
        part[:, beside, below] = part[:, below, beside]
    blocks = [spread(lower, order)]
    for i, own in enumerate(local):
        strip = np.zeros((count, n + 1, n + 1))
        strip[:s, :n, :n] = basis
        if own.limit is not None:
            strip[s : s + len(Y), n, :n] = Y[:, i]
        else:
            strip[:s, n, :n] = plant[2][i] @ basis
        strip[:, :n, n] = strip[:, n, :n]
        constant = np.zeros((n + 1, n + 1))
        constant[n, n] = (own.reach if own.limit is None else own.limit) ** 2
        blocks.append(Block(constant, strip))
    cost, logarithms = np.zeros(count), list[tuple[int, int]]()
    if points is None:  # log det W >= sum log z_ii for a lower triangle Z with [[W, Z], [Z', diag Z]] >= 0
        rows, columns = np.tril_indices(n)
        slopes, at = np.zeros((count, 2 * n, 2 * n)), k + m
        slopes[:s, :n, :n] = basis
        for z, (row, column) in enumerate(zip(rows.tolist(), columns.tolist(), strict=True)):
            slopes[at + z, row, n + column] = slopes[at + z, n + column, row] = 1.0
            if row == column:
                slopes[at + z, n + row, n + row] = 1.0
                logarithms.append((at + s + row, at + z))
        blocks.append(Block(np.zeros((2 * n, 2 * n)), slopes))
        cost[at + s :] = 1.0
    else:
        cost[-1] = -1.0
        for point in points:
            slopes, constant = np.zeros((count, n + 1, n + 1)), np.zeros((n + 1, n + 1))
            slopes[:s, :n, :n] = basis
            slopes[-1, n, n] = 1.0
            constant[n, :n] = constant[:n, n] = point
            blocks.append(Block(constant, slopes))
    found = proposed(cost, blocks, np.zeros((0, count)), np.zeros(0), logarithms=logarithms)
    if found is None:
        return None
    W = np.tensordot(found[:s], basis, 1)
    if np.linalg.eigvalsh(W)[0] <= 0 or min(found[k : k + m]) <= 0:
        return None
    P = np.linalg.inv(W)
    h = np.tensordot(found[s:k], Y, 1) @ P if free else np.zeros((m, n))
    return Ellipsoid((P + P.T) / 2, 1 / found[k : k + m], h)
