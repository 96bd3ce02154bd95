r"""Invariant ellipsoids of a loop with many channels: Newton's method on a barrier, in floating point.

The search of :mod:`lure.analysis.inequality.ellipsoids`, which is linear in ``W = P^{-1}``, in ``Y = h W`` and in the
inverse weights ``S``.  Each of its slopes is a sum of few products of two vectors, so that a step of Newton costs the
inverse of one matrix and some products, where a general programme of this order takes seconds.  Nothing is proved here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.ellipsoids import Ellipsoid, Local, Matrix, shifted
from lure.analysis.numerics.semidefinite import symmetric_basis
from lure.arrays import linalg, np, one_thread

MANY = 6  # channels, from which on this search is the faster one
_STEPS, _FACTOR = 120, 10.0
_FALL = 1e-3  # of the barrier in a step, below which it is centred


@dataclass(frozen=True, kw_only=True)
class _Programme:
    """The inequality by pairs of vectors, and what bounds the set; variables: ``W``, ``Y``, ``S``, one more.

    ``M = sum_k x_k sum_p share[k, p] (left_p right_p' + right_p left_p') + slack``, with the last variable the slack,
    or the largest ``p'P p`` of given points.
    """

    left: Matrix  # (p, N)
    right: Matrix
    share: Matrix  # (K, p)
    basis: Matrix  # (s, n, n) of W
    strips: Matrix  # (k, n): |row x| <= 1
    limits: Matrix  # (c,) of |h x|
    points: Matrix  # (q, n)

    @property
    def rest(self) -> int:
        """Where the inverse weights begin, behind ``W`` and ``Y``."""
        return len(self.basis) + len(self.limits) * int(self.basis.shape[-1])

    @property
    def order(self) -> int:
        """Of the barrier: a centred point is no farther from the best one than this over ``t``."""
        bounds = (len(self.limits) + len(self.points)) * (int(self.basis.shape[-1]) + 1)
        return int(self.left.shape[1]) + len(self.share) - self.rest + len(self.strips) + bounds

    def W(self, x: Matrix) -> Matrix:
        """The inverse of the matrix of the ellipsoid."""
        return np.asarray(np.tensordot(x[: len(self.basis)], self.basis, 1))

    def inequality(self, x: Matrix, slack: float) -> Matrix:
        """``M``."""
        half = (self.left * (x[:-1] @ self.share)[:, None]).T @ self.right
        return np.asarray(half + half.T + slack * np.eye(len(half)))

    def bounds(self, x: Matrix) -> list[tuple[Matrix, Matrix]]:
        """The limits ``h W h' <= limit^2``, and ``p'P p <= x_last``, as matrices with their slopes."""
        n, s, found = self.basis.shape[-1], len(self.basis), list[tuple[Matrix, Matrix]]()
        k = np.arange(n)
        for c in range(len(self.limits) + len(self.points)):
            slopes = np.zeros((len(x), n + 1, n + 1))
            slopes[:s, :n, :n] = self.basis
            constant = np.zeros((n + 1, n + 1))
            if c < len(self.limits):
                slopes[s + c * n + k, n, k] = slopes[s + c * n + k, k, n] = 1.0
                constant[n, n] = self.limits[c] ** 2
            else:
                slopes[-1, n, n] = 1.0
                constant[n, :n] = constant[:n, n] = self.points[c - len(self.limits)]
            found.append((constant + np.tensordot(x, slopes, 1), slopes))
        return found

    def value(self, x: Matrix, slack: float) -> float:
        """The barrier: ``-log det`` of all that is to be positive; ``inf`` where it is not."""
        strips = 1 - np.einsum("ki,ij,kj->k", self.strips, self.W(x), self.strips)
        weights = x[self.rest : -1]
        if min(strips.min(initial=1.0), weights.min()) <= 0:
            return float(np.inf)
        blocks = [self.inequality(x, slack), *(block for block, _ in self.bounds(x))]
        try:
            roots = [np.diag(np.linalg.cholesky(block)) for block in blocks]
        except np.linalg.LinAlgError:
            return float(np.inf)
        return float(-2 * sum(np.log(root).sum() for root in roots) - np.log(strips).sum() - np.log(weights).sum())

    def derivatives(self, x: Matrix, slack: float, *, moving: bool) -> tuple[Matrix, Matrix]:
        """Gradient and Hessian of the barrier; whether the last variable is the slack."""
        X, s = np.linalg.inv(self.inequality(x, slack)), len(self.basis)
        gradient, hessian = np.zeros(len(x)), np.zeros((len(x), len(x)))
        U, V = self.left @ X, self.right @ X
        uv = U @ self.right.T
        gradient[:-1] = -2 * self.share @ np.diag(uv)
        hessian[:-1, :-1] = 2 * self.share @ (uv * uv.T + (U @ self.left.T) * (V @ self.right.T)) @ self.share.T
        if moving:
            gradient[-1], hessian[-1, -1] = -np.trace(X), (X * X).sum()
            hessian[-1, :-1] = hessian[:-1, -1] = 2 * self.share @ (U * V).sum(axis=1)
        wide = np.einsum("ki,bij,kj->kb", self.strips, self.basis, self.strips)
        ratio = wide / (1 - wide @ x[:s])[:, None]
        gradient[:s] += ratio.sum(axis=0)
        hessian[:s, :s] += ratio.T @ ratio
        for block, slopes in self.bounds(x):
            moved = np.linalg.solve(block[None], slopes)
            gradient -= np.trace(moved, axis1=1, axis2=2)
            hessian += np.einsum("aij,bji->ab", moved, moved)
        places = np.arange(self.rest, len(x) - 1)
        gradient[places] -= 1 / x[places]
        with np.errstate(over="ignore"):
            hessian[places, places] += 1 / x[places] ** 2
        return gradient, hessian

    def volume(self, x: Matrix) -> tuple[float, Matrix, Matrix]:
        """``-log det W`` with its derivatives."""
        W, gradient, hessian = self.W(x), np.zeros(len(x)), np.zeros((len(x), len(x)))
        sign, value = np.linalg.slogdet(W)
        if sign <= 0:
            return float(np.inf), gradient, hessian
        s, moved = len(self.basis), np.linalg.solve(W[None], self.basis)
        gradient[:s] = -np.trace(moved, axis1=1, axis2=2)
        hessian[:s, :s] = np.einsum("aij,bji->ab", moved, moved)
        return -float(value), gradient, hessian

    def centred(self, x: Matrix, t: float, *, slack: float | None = None, enough: float = -np.inf) -> Matrix:
        """The least of ``t`` times what is to be small and the barrier, by Newton's method; ``slack`` None: it moves.

        What is to be small is the slack, the last variable, or ``-log det W`` where no points are given.
        """
        moving, sized = slack is None, slack is not None and not len(self.points)
        size = len(x) - sized

        def whole(x: Matrix) -> float:
            """The function."""
            value = self.volume(x)[0] if sized else float(x[-1])
            return t * value + self.value(x, float(x[-1]) if slack is None else slack)

        value = whole(x)
        for _ in range(_STEPS):
            try:
                gradient, hessian = self.derivatives(x, float(x[-1]) if slack is None else slack, moving=moving)
            except np.linalg.LinAlgError:
                break
            if sized:
                _, slope, bend = self.volume(x)
                gradient, hessian = gradient + t * slope, hessian + t * bend
            else:
                gradient[-1] += t
            with np.errstate(all="ignore"):
                scale = np.sqrt(np.diag(hessian)[:size])
                inner = hessian[:size, :size] / np.outer(scale, scale) + 1e-13 * np.eye(size)
            if not np.isfinite(inner).all():
                break
            step = np.zeros(len(x))
            try:
                step[:size] = -linalg.cho_solve(linalg.cho_factor(inner), gradient[:size] / scale) / scale
            except (np.linalg.LinAlgError, ValueError):
                break
            fall, length = -float(step[:size] @ gradient[:size]), 1.0
            if not fall > _FALL:
                break
            while not (now := whole(new := x + length * step)) <= value - 0.1 * length * fall:
                length /= 2
                if length < 1e-6:
                    return x
            x, value = new, now
            if x[-1] < enough:
                break
        return x


@one_thread
def many_ellipsoid(  # noqa: PLR0913  (what a search needs)
    plant: Sequence[Matrix],
    local: Sequence[Local],
    first: Matrix,
    *,
    discrete: bool,
    points: Matrix | None = None,
    margin: float = 1e-7,
    digits: float = 1e-5,
) -> Ellipsoid | None:
    """About the largest invariant ellipsoid, as :func:`lure.analysis.inequality.ellipsoids.ellipsoid` finds it.

    Parameters
    ----------
    plant : sequence of ndarray
        ``A``, ``B``, ``C`` and ``D``.
    local : sequence of Local
        What is used of each nonlinearity.
    first : ndarray
        (n, n) an ellipsoid in whose units it is solved.
    discrete : bool
        Whether time is discrete.
    points : ndarray or None
        (k, n) points, of which the largest multiple is to lie inside; None for the volume.
    margin : float
        By which the inequality is to hold, relative to its terms.
    digits : float
        How near the largest one it is to come, relative.

    Returns
    -------
    Ellipsoid or None
        None where none was found; else what has still to be proved.
    """
    back = np.linalg.cholesky(first).T
    scale = np.asarray(np.linalg.inv(back))  # x = scale z, in which the first set is the unit ball
    own = _sizes(plant, local, scale)  # phi = own psi
    A, B, C, D = plant
    upper = np.array([one.upper for one in local])
    sides = shifted((back @ A @ scale, back @ B * own, C @ scale / own[:, None], D * own / own[:, None]), upper)
    strips = [C[i] @ scale / one.reach for i, one in enumerate(local) if one.limit is None and C[i].any()]
    free = [i for i, one in enumerate(local) if one.limit is not None]
    turned = np.zeros((0, len(A))) if points is None else points @ back.T
    programme = _programme(
        sides,
        np.array([one.upper - one.lower for one in local]),
        free,
        discrete=discrete,
        strips=np.array(strips).reshape(-1, len(A)),
        limits=np.array([float(local[i].limit or 0.0) / own[i] for i in free]),
        points=turned / np.linalg.norm(turned, axis=1).max(initial=1e-300),
    )
    x = _feasible(programme, margin)
    if x is None:
        return None
    t = 1.0
    while t < programme.order / digits:
        checkpoint()
        x = programme.centred(x, t, slack=-margin)
        t *= _FACTOR
    n, s = len(A), len(programme.basis)
    P, h = np.linalg.inv(programme.W(x)), np.zeros((len(own), n))
    for c, i in enumerate(free):
        h[i] = own[i] * P @ x[s + c * n : s + (c + 1) * n]
    return Ellipsoid(back.T @ ((P + P.T) / 2) @ back, 1 / (x[programme.rest : -1] * own**2), h @ back)


def _sizes(plant: Sequence[Matrix], local: Sequence[Local], scale: Matrix) -> Matrix:
    """About how large each ``sigma`` is on the first set, at most the limit of a line with limits."""
    wide, through = np.linalg.norm(plant[2] @ scale, axis=1), np.abs(plant[3])
    most = np.array([np.inf if one.limit is None else one.limit for one in local])
    steep = np.array([max(abs(one.lower), abs(one.upper)) for one in local])
    found = np.minimum(wide, most)
    for _ in local:
        new = np.minimum(wide + through @ (steep * found), most)
        if np.array_equal(new, found):
            break
        found = new
    return np.where(found > 0, found, 1.0)


def _programme(  # noqa: PLR0913  (what bounds it)
    sides: Sequence[Matrix],
    width: Matrix,
    free: Sequence[int],
    *,
    discrete: bool,
    strips: Matrix,
    limits: Matrix,
    points: Matrix,
) -> _Programme:
    A, B, C, D = sides
    n, m = B.shape
    one = np.eye((2 * n if discrete else n) + m)
    E, T, H = one[:n], one[n : n + m], one[n + m :]
    moved = -(width[:, None] * C).T @ T + (A.T @ H if discrete else -A.T @ E)  # row a: from e_a
    a, b = np.tril_indices(n)
    half, s = np.where(a == b, 0.5, 1.0), len(a)
    parts = [(moved[a] + (E[a] if discrete else 0), E[b]), (moved[b], E[a])] + ([(H[a], H[b])] if discrete else [])
    inward = T - (width[:, None] * D).T @ T + (B.T @ H if discrete else -B.T @ E)
    rows = [i for i in free for _ in range(n)]
    rest = len(rows) + m
    share = np.zeros((s + rest, len(parts) * s + rest))
    for k in range(len(parts)):
        share[np.arange(s), k * s + np.arange(s)] = half
    share[np.arange(s, s + rest), np.arange(len(parts) * s, len(parts) * s + rest)] = 1.0
    return _Programme(
        left=np.vstack([*(u for u, _ in parts), T[rows], T]),
        right=np.vstack([*(v for _, v in parts), *[E] * len(free), inward]),
        share=share,
        basis=symmetric_basis(n),
        strips=strips,
        limits=limits,
        points=points,
    )


def _feasible(programme: _Programme, margin: float) -> Matrix | None:
    """A point at which the inequality holds with twice the margin; None where there is none, or it was not found."""
    n = programme.basis.shape[-1]
    wide = max(1.0, float((programme.strips**2).sum(axis=1).max(initial=0.0)))
    m = len(programme.share) - programme.rest
    ball = np.array([float(np.trace(one) > 0) for one in programme.basis]) / (1.5 * wide)
    x = np.concatenate([ball, np.zeros(n * len(programme.limits)), np.ones(m) / wide, [0.0]])
    search = programme if not len(programme.points) else _Programme(**{**vars(programme), "points": np.zeros((0, n))})
    x[-1] = 1.0 - float(np.linalg.eigvalsh(search.inequality(x, 0.0))[0])
    t = 0.1 * len(programme.left[0])
    for _ in range(9):
        checkpoint()
        x = search.centred(x, t, enough=-2 * margin)
        if x[-1] < -2 * margin:
            P = np.linalg.inv(programme.W(x))
            x[-1] = 2 * float(np.einsum("ki,ij,kj->k", programme.points, P, programme.points).max(initial=1.0))
            return x
        if x[-1] > 2 * search.order / t:
            return None  # the slack falls below 0 nowhere
        t *= _FACTOR
    return None
