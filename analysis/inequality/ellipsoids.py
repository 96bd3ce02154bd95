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
from fractions import Fraction
from typing import NamedTuple, TypeAlias

from lure.analysis.numerics.semidefinite import Block, proposed, symmetric_basis
from lure.arrays import NDArray, np

Matrix: TypeAlias = "NDArray[np.float64]"
_LEAST_WIDTH, _ROUNDING = 1e-9, 1e-14  # of a sector, in the choice of units; of eigenvalues
_SEEN, _LONGER = 1e-10, 100.0  # below which a state is seen by rounding alone; times a first set, for states not seen


class Local(NamedTuple):
    """What is used of one nonlinearity: its bounds, and the limit of ``p`` or the reach of the sector."""

    lower: float  # l, or the slope e outside the limits
    upper: float
    limit: float | None  # of |h x|; None: a sector
    reach: float  # of |C x|, less what feeds through; for a sector alone


class Disturbance(NamedTuple):
    """Asked in place of a size: the largest energy of ``w``, ``x' = .. + B w``, that leaves ``x`` in the set.

    With ``D`` also ``sigma = .. + D w``; ``exact`` has both as they were given.
    """

    B: Matrix
    D: Matrix
    exact: tuple[tuple[tuple[Fraction, ...], ...], ...] = ()


class Ellipsoid(NamedTuple):
    """``x'P x <= 1``, with the weight of each channel and the row ``h`` of those with limits, else 0."""

    P: Matrix
    weights: Matrix
    rows: Matrix
    energy: float = 0.0  # of a disturbance

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


def ellipsoid(  # noqa: PLR0913  (what a search needs)
    plant: Sequence[Matrix],
    local: Sequence[Local],
    *,
    discrete: bool,
    points: Matrix | Disturbance | None = None,
    margin: float = 1e-7,
    turns: int = 3,
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
    points : ndarray, Disturbance or None
        (k, n) points, None for the volume; of a disturbance the largest energy with ``V' <= |w|^2/energy`` is asked.
    margin : float
        By which the inequality is to hold, relative to its terms.
    turns : int
        How often it is solved, each time in better units.

    Returns
    -------
    Ellipsoid or None
        None where the solver finds none; else what has still to be proved.
    """
    guess, found = linear_ellipsoid(plant, local, discrete=discrete), None
    unseen = None
    if guess is not None and not isinstance(points, Disturbance):
        unseen = _unseen(plant, guess, points)
    for turn in range(turns):  # x = scale z, in which the last ellipsoid is the unit ball; phi by the weights, and
        # sigma so that all sectors are about 1 wide
        if guess is None:
            break
        try:
            scale = np.linalg.cholesky(np.linalg.inv(guess.P))
        except np.linalg.LinAlgError:
            break
        back, a = np.linalg.inv(scale), guess.weights**-0.5
        turned, own, b = in_units(plant, local, scale, a)
        moved: Matrix | Disturbance | None = None
        if isinstance(points, Disturbance):
            moved = Disturbance(back @ points.B, points.D / b[:, None])
        elif points is not None:
            turned_points = points @ back.T
            moved = turned_points / float(np.linalg.norm(turned_points, axis=1).max())
        capped = None if unseen is None else unseen @ scale
        guess = _solved(
            turned, own, moved, max(margin, 1e-5) if turn == 0 else margin, discrete=discrete, capped=capped
        )
        if guess is not None:
            P, rows = back.T @ guess.P @ back, a[:, None] * guess.rows @ back
            guess = Ellipsoid(P, guess.weights / a**2, rows, guess.energy)
            found = guess
    return found


def _unseen(plant: Sequence[Matrix], guess: Ellipsoid, points: Matrix | None) -> Matrix | None:
    """Functionals of the states that no ``sigma`` sees, of at most 1 where a set may go; None if all are seen.

    A set that is invariant stays so when it is made longer along such states, so that there is no largest one; it may
    go as far as the ``points``.
    """
    A, _, C, _ = plant
    try:
        root = np.linalg.cholesky(np.linalg.inv(guess.P))  # in units in which a first ellipsoid is the unit ball
    except np.linalg.LinAlgError:
        return None
    back = np.linalg.solve(root, A @ root)
    rows = [C @ root / max(float(np.linalg.norm(C @ root)), 1e-300)]
    for _ in range(len(A) - 1):
        rows.append(rows[-1] @ back / max(float(np.linalg.norm(back, 2)), 1e-300))
    values, basis = np.linalg.svd(np.vstack(rows))[1:]
    rank = int(np.sum(values > _SEEN * values[0]))
    if rank == len(A):
        return None
    found = np.asarray(basis[rank:] @ np.linalg.inv(root)) / _LONGER
    return found if points is None else found / max(1.0, float(np.linalg.norm(points @ found.T, axis=1).max()))


def in_units(
    plant: Sequence[Matrix], local: Sequence[Local], scale: Matrix, a: Matrix
) -> tuple[list[Matrix], list[Local], Matrix]:
    """The loop in ``x = scale z``, ``phi_i`` in units of ``a_i`` and ``sigma_i`` so that sectors are 1 wide.

    Parameters
    ----------
    plant : sequence of ndarray
        ``A``, ``B``, ``C`` and ``D``.
    local : sequence of Local
        What is used of each nonlinearity.
    scale : ndarray
        (n, n).
    a : ndarray
        (m,), positive.

    Returns
    -------
    tuple
        The plant, what is used of each nonlinearity, and the units of ``sigma``, (m,).
    """
    A, B, C, D = plant
    widths = np.array([max(abs(one.upper - one.lower), _LEAST_WIDTH) for one in local])  # e > u in a dead zone
    b, back = a / widths, np.linalg.inv(scale)
    turned = [back @ A @ scale, back @ B * a, C @ scale / b[:, None], D * a / b[:, None]]
    own = [
        Local(one.lower / wide, one.upper / wide, None if one.limit is None else one.limit / v, one.reach * wide / v)
        for one, v, wide in zip(local, a, widths, strict=True)
    ]
    return turned, own, b


def linear_ellipsoid(plant: Sequence[Matrix], local: Sequence[Local], *, discrete: bool) -> Ellipsoid | None:
    """An ellipsoid of the loop with ``phi = u sigma`` that lies in the strips: where the search begins.

    ``plant``: ``A``, ``B``, ``C`` and ``D``.

    Returns
    -------
    Ellipsoid or None
        None where that loop is not stable.
    """
    from scipy import linalg

    upper, low = (np.array([one[i] for one in local], dtype=float) for i in (1, 0))
    A = shifted(plant, upper)[0]
    modes = np.linalg.eigvals(A)
    size = np.abs(modes).max()  # a pair on the axis, or circle, which rounding has moved inside, is not stable
    if not ((size < 1 - _ROUNDING) if discrete else (modes.real.max() < -_ROUNDING * size)):
        return None
    one = np.eye(len(A))
    P = linalg.solve_discrete_lyapunov(A.T, one) if discrete else linalg.solve_continuous_lyapunov(A.T, -one)
    P = (P + P.T) / 2
    wide = np.einsum("ij,ji->i", plant[2], np.linalg.solve(P, plant[2].T))
    reaches = np.array(
        [own.reach if own.limit is None else own.limit / max(abs(own.upper - own.lower), _LEAST_WIDTH) for own in local]
    )
    reaches = np.where(np.isfinite(reaches), np.abs(reaches), 1.0)
    P = P * float(np.max(wide / reaches**2, initial=1e-300))
    width = np.maximum(np.abs(upper - low), _LEAST_WIDTH) * reaches
    return Ellipsoid(P, 1 / width**2, np.zeros((len(local), len(A))))


def unsaturated_ellipsoid(plant: Sequence[Matrix], local: Sequence[Local], *, discrete: bool) -> Ellipsoid | None:
    """An invariant ellipsoid on which nothing saturates, ``h = w C``: where sets grow for ever, or no solver ends.

    There ``psi (w sigma - psi - h x) = -psi^2``, and a weight of ``|PB|^2`` suffices beside ``A'P + PA = -1``, in
    discrete time one of ``|B'PB| + |A'PB|^2`` beside ``A'PA - P = -1``; each is taken twice.

    ``plant``: ``A``, ``B``, ``C`` and ``D``.

    Returns
    -------
    Ellipsoid or None
        None of sectors, of plants with ``D``, and where the loop is not stable without its limits.
    """
    begun = linear_ellipsoid(plant, local, discrete=discrete)
    if begun is None or plant[3].any() or any(one.limit is None for one in local):
        return None
    upper, wide = np.array([[one.upper, one.upper - one.lower] for one in local]).T
    A, B, C, _ = shifted(plant, upper)
    P = begun.P
    fall = P - A.T @ P @ A if discrete else -(A.T @ P + P @ A)
    cross = A.T @ P @ B if discrete else P @ B
    falls = float(np.linalg.eigvalsh(fall)[0])
    if not falls > 0:
        return None  # lost in rounding
    least = float(np.linalg.norm(cross, 2)) ** 2 / falls
    weight = 2 * (least + (float(np.linalg.norm(B.T @ P @ B, 2)) if discrete else 0.0))
    return Ellipsoid(P, np.full(len(local), max(weight, 1e-300)), wide[:, None] * C)


def _solved(  # noqa: PLR0913  (what a search needs)
    plant: Sequence[Matrix],
    local: Sequence[Local],
    points: Matrix | Disturbance | None,
    margin: float,
    *,
    discrete: bool,
    capped: Matrix | None = None,
) -> Ellipsoid | None:
    n, m = plant[1].shape
    w_of, seen = (points.B, points.D) if isinstance(points, Disturbance) else (np.zeros((n, 0)), np.zeros((m, 0)))
    upper, low = (np.array([one[i] for one in local], dtype=float) for i in (1, 0))
    A, B, C, D = shifted(plant, upper)
    seen = np.linalg.inv(np.eye(m) + plant[3] * upper) @ seen
    w_of = w_of - plant[1] * upper @ seen
    modes = np.linalg.eigvals(A)
    decay = 1 - float(np.abs(modes).max()) ** 2 if discrete else -2 * float(modes.real.max())
    if not decay > 0:
        return None  # phi = u sigma is allowed
    w = (upper - low)[:, None]
    free = [i for i, one in enumerate(local) if one.limit is not None]
    basis = symmetric_basis(n)
    s, k = len(basis), len(basis) + len(free) * n
    count = k + m + (len(basis) + n if points is None else 1)

    Y = np.einsum("ai,cd->acid", np.eye(m)[free], np.eye(n)).reshape(-1, m, n)
    S = np.einsum("ij,jk->ijk", np.eye(m), np.eye(m))
    last = 2 * (1 - margin) * S - w * (D @ S) - np.swapaxes(w * (D @ S), 1, 2)
    last_x, p = (2 * n if discrete else n) + m, w_of.shape[1]
    order = last_x + p
    one, two, three, four = slice(0, n), slice(n, n + m), slice(n + m, last_x), slice(last_x, order)
    ofW, ofY, ofS = np.zeros((s, order, order)), np.zeros((len(Y), order, order)), np.zeros((m, order, order))
    ofW[:, two, one] = -w * (C @ basis)
    ofY[:, two, one] = Y
    ofS[:, two, two] = last
    if discrete:
        ofW[:, one, one], ofW[:, three, one], ofW[:, three, three] = (1 - margin * decay) * basis, A @ basis, basis
        ofS[:, three, two] = B @ S
    else:
        moved = A @ basis
        ofW[:, one, one] = -(moved + np.swapaxes(moved, 1, 2)) - margin * decay * basis
        ofS[:, two, one] = -np.swapaxes(B @ S, 1, 2)
    main = Block(np.zeros((order, order)), np.zeros((count, order, order)))
    below, beside = np.tril_indices(order, -1)
    for place, part in ((0, ofW), (s, ofY), (k, ofS)):
        part[:, beside, below] = part[:, below, beside]
        main.slopes[place : place + len(part)] = part
    if p:  # V' - |w|^2/energy: the last variable is 1/energy
        main.slopes[-1, four, four] = (1 - margin) * np.eye(p)
        at = three if discrete else one
        main.constant[four, at] = w_of.T if discrete else -w_of.T
        main.constant[at, four] = main.constant[four, at].T
        main.constant[two, four] = -w * seen
        main.constant[four, two] = main.constant[two, four].T
    start = np.zeros(count)  # W = 1 and S = 1, what the units are made for
    start[:s], start[k : k + m] = np.einsum("kii->k", basis) == 1, 1.0
    if p:
        start[-1] = max(float(np.sum(w_of**2)) / decay, 1e-12)
    blocks = [even(main, start)]
    blocks += [_limited(own, count, basis, (s, Y[:, i]), plant[2][i]) for i, own in enumerate(local)]
    blocks += [] if capped is None else [_ended(count, basis, capped)]
    cost, logarithms = np.zeros(count), list[tuple[int, int]]()
    if points is None:
        block, logarithms = _log_det(count, basis, k + m)
        blocks.append(block)
        cost[k + m + s :] = 1.0
    else:
        cost[-1] = -1.0
        blocks += [] if isinstance(points, Disturbance) else [_holding(point, count, basis) for point in points]
    found = proposed(cost, blocks, np.zeros((0, count)), np.zeros(0), logarithms=logarithms)
    return None if found is None or not _held(blocks, found) else _read(found, basis, Y, disturbed=p > 0)


def _ended(count: int, basis: Matrix, rows: Matrix) -> Block:
    """That functionals of the states are at most 1 on the set."""
    block = Block(np.eye(len(rows)), np.zeros((count, len(rows), len(rows))))
    block.slopes[: len(basis)] = -(rows @ basis @ rows.T)
    return block


def _read(found: Matrix, basis: Matrix, Y: Matrix, *, disturbed: bool) -> Ellipsoid | None:
    """The ellipsoid of values of ``W``, ``Y`` and ``S``, if ``W`` and ``S`` are positive definite."""
    s, k, m = len(basis), len(basis) + len(Y), Y.shape[1]
    W = np.tensordot(found[:s], basis, 1)
    least = np.linalg.eigvalsh(W)
    if least[0] <= 1e-14 * least[-1] or min(found[k : k + m]) <= 0:
        return None
    P = np.linalg.inv(W)
    h = np.tensordot(found[s:k], Y, 1) @ P
    energy = 1 / max(float(found[-1]), 1e-300) if disturbed else 0.0
    return Ellipsoid((P + P.T) / 2, 1 / found[k : k + m], h, energy)


def even(block: Block, start: Matrix) -> Block:
    """The same inequality in rows and columns scaled so that its diagonal has entries of size 1 at a start.

    A width of 10^6 is else beside a rate of 1, and where the solver stops depends on how the processor rounds.

    ``start``: (K,) values of the unknowns.
    """
    value = block.constant + np.tensordot(start, block.slopes, 1)
    scale = np.maximum(np.abs(np.diag(value)), 1e-12 * np.abs(value).max()) ** -0.5
    by = np.outer(scale, scale)
    return Block(block.constant * by, block.slopes * by)


def _held(blocks: Sequence[Block], found: Matrix) -> bool:
    """Whether all blocks are positive semidefinite, nearly: not so on a ray of a programme without a solution."""
    held = [block.constant + np.tensordot(found, block.slopes, 1) for block in blocks]
    return all(np.linalg.eigvalsh(one)[0] >= -1e-6 * np.abs(one).max() for one in held)


def _holding(point: Matrix, count: int, basis: Matrix) -> Block:
    """``z' W^-1 z <= t`` for a point ``z``, with ``t`` the last variable."""
    n = len(point)
    slopes, constant = np.zeros((count, n + 1, n + 1)), np.zeros((n + 1, n + 1))
    slopes[: len(basis), :n, :n] = basis
    slopes[-1, n, n] = 1.0
    constant[n, :n] = constant[:n, n] = point
    return Block(constant, slopes)


def _limited(own: Local, count: int, basis: Matrix, free: tuple[int, Matrix], row: Matrix) -> Block:
    """``|h x| <= limit``, or ``|c x| <= reach``, on the ellipsoid; ``h W`` are variables from a place on."""
    n, (place, Y) = basis.shape[-1], free
    strip = np.zeros((count, n + 1, n + 1))
    strip[: len(basis), :n, :n] = basis
    if own.limit is not None:
        strip[place : place + len(Y), n, :n] = Y
    else:
        strip[: len(basis), n, :n] = row @ basis
    strip[:, :n, n] = strip[:, n, :n]
    constant = np.zeros((n + 1, n + 1))
    constant[n, n] = (own.reach if own.limit is None else own.limit) ** 2
    return Block(constant, strip)


def _log_det(count: int, basis: Matrix, place: int) -> tuple[Block, list[tuple[int, int]]]:
    """``log det W >= sum log z_ii`` for a lower triangle ``Z`` from a place on with ``[[W, Z], [Z', diag Z]] >= 0``.

    ``W`` is made of the basis by the first variables; the logarithms follow the triangle.
    """
    n = basis.shape[-1]
    rows, columns = np.tril_indices(n)
    slopes, logarithms = np.zeros((count, 2 * n, 2 * n)), list[tuple[int, int]]()
    slopes[: len(basis), :n, :n] = basis
    for z, (row, column) in enumerate(zip(rows.tolist(), columns.tolist(), strict=True)):
        slopes[place + z, row, n + column] = slopes[place + z, n + column, row] = 1.0
        if row == column:
            slopes[place + z, n + row, n + row] = 1.0
            logarithms.append((place + len(rows) + row, place + z))
    return Block(np.zeros((2 * n, 2 * n)), slopes), logarithms


class Growth(NamedTuple):
    """``V - 1`` grows at a rate where ``V = x'Q x > 1``, with a weight for each channel."""

    Q: Matrix
    rate: float
    weights: Matrix


def growing(plant: Sequence[Matrix], limits: Matrix, *, discrete: bool, margin: float = 1e-7) -> Growth | None:
    r"""About the smallest set outside of which solutions grow, for inputs ``p`` of the plant with ``|p_i| <= limit_i``.

    ``V' - rate V + sum s_i p_i^2 > 0`` with ``sum s_i limit_i^2 <= rate`` (in discrete time ``V+ - (1 + rate) V``) is
    linear in ``Q`` and ``s`` for each rate.  ``Q`` has as many positive eigenvalues as the plant has unstable ones; its
    volume on their space is made largest.  With one of them, ``w'A = lambda w'``, and ``|w'B p| <= beta``, the set
    tends to ``|w'x| > beta/lambda``.

    Parameters
    ----------
    plant : sequence of ndarray
        ``A`` (n, n) and ``B`` (n, m), the lines outside the limits taken into them.
    limits : ndarray
        (m,), positive.
    discrete : bool
        Whether time is discrete.
    margin : float
        By which the inequality is to hold, relative to its terms.

    Returns
    -------
    Growth or None
        None without unstable modes, or where the solver finds none; else what has still to be proved.
    """
    A, B = plant[0], plant[1] * limits
    values, vectors = np.linalg.eig(A)
    fast = np.abs(values) ** 2 - 1 if discrete else 2 * values.real
    if not (fast > 1e-9).any():
        return None
    own = vectors[:, fast > 1e-9]
    basis = np.linalg.svd(np.hstack([own.real, own.imag]))[0][:, : own.shape[1]]
    size = max(float(np.linalg.norm(B)), 1e-12) / max(float(np.linalg.norm(A, 2)), 1e-12)
    top = float(fast[fast > 1e-9].min())
    best: Growth | None = None
    value = -np.inf
    for share in (0.5, 0.35, 0.2, 0.1, 0.65, 0.02):
        found = _grown((A, B / size), basis, share * top, discrete=discrete, margin=margin)
        if found is not None:
            score = float(np.linalg.slogdet(basis.T @ found.Q @ basis)[1])
            if score > value:
                best, value = found, score
    if best is None:
        return None
    return Growth(best.Q / size**2, best.rate, best.weights / limits**2)


def _grown(
    plant: tuple[Matrix, Matrix], unstable: Matrix, rate: float, *, discrete: bool, margin: float
) -> Growth | None:
    (A, B), (n, k) = plant, unstable.shape
    m = B.shape[1]
    basis = symmetric_basis(n)
    s, corner = len(basis), len(symmetric_basis(k))
    count = s + m + corner + k
    F, E = np.hstack([A, -B]), np.hstack([np.eye(n), np.zeros((n, m))])
    slopes = np.zeros((count, n + m, n + m))
    held = E.T @ basis @ E
    if discrete:
        slopes[:s] = F.T @ basis @ F - (1 + rate) * held
    else:
        half = E.T @ basis @ F
        slopes[:s] = half + np.swapaxes(half, 1, 2) - rate * held
    slopes[np.arange(s, s + m), np.arange(n, n + m), np.arange(n, n + m)] = 1.0
    blocks = [Block(-margin * np.eye(n + m), slopes)]  # in units of the rate
    block, logarithms = _log_det(count, unstable.T @ basis @ unstable, s + m)
    blocks.append(block)
    cost = np.zeros(count)
    cost[s + m + corner :] = 1.0
    sums, zero = np.zeros((m + 1, count)), np.zeros(m + 1)
    sums[0, s : s + m] = 1.0
    sums[np.arange(1, m + 1), np.arange(s, s + m)] = -1.0
    zero[0] = 1 - margin
    found = proposed(cost, blocks, sums, zero, logarithms=logarithms)
    if found is None:
        return None
    Q, weights = np.tensordot(found[:s], basis, 1), np.maximum(found[s : s + m], 0.0)
    if not weights.sum() or np.linalg.eigvalsh(unstable.T @ Q @ unstable)[0] <= 0:
        return None
    return Growth(rate * Q, rate, rate * weights * min(1.0, 1 / weights.sum()))
