r"""Level sets of Lur'e and Postnikov's functions that are invariant: a search by turns, in floating point.

``V = x'P x + 2 sum theta_i int_0^{sigma_i} phi_i`` falls where the terms of the ellipsoids' search are not negative.
With ``|sigma_i| <= c_i`` on the set, and ``kappa_i sigma^2 <= 2 int phi_i`` there (``>=`` where ``theta_i < 0``), ``V``
is at least the form of ``P + sum theta_i kappa_i C_i'C_i``, whose ellipsoid has to lie in the strips.  For given rows
``h`` all this is linear in ``P``, ``theta`` and the weights; for given ``P`` and ``theta`` in the weights and their
products with the rows.  The two are solved by turns, beginning with an ellipsoid.  Such functions for regions of
attraction: Walker, McClamroch 1967; Weissenberger 1968.  Nothing is proved here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from lure.analysis.inequality.ellipsoids import Ellipsoid, Local, Matrix, in_units
from lure.analysis.numerics.semidefinite import Block, proposed, symmetric_basis
from lure.arrays import np

ROUNDS = 8
_LOOSE = 1e-2  # the margin of the first turns
_INSIDE = 1 + 3e-6  # what a strip's limit squared exceeds the set by; more than rounding the certificate takes
_GRID = np.geomspace(1e-5, 1.0, 60)
_SLACK = 1.002  # by which the intervals of the integrals exceed what the set needs
Integral = Callable[[Matrix], Matrix]


class LevelSet(NamedTuple):
    """``x'P x + 2 sum theta_i int phi_i <= 1``, ``|sigma_i| <= reach_i``, with weights and rows as an ellipsoid's."""

    P: Matrix
    theta: Matrix
    reaches: Matrix
    weights: Matrix
    rows: Matrix

    def radii(self, C: Matrix, integrals: Sequence[Integral], directions: Matrix) -> Matrix:
        """How far the set goes in each direction, by halving."""
        low, high = np.zeros(len(directions)), np.ones(len(directions))
        for _ in range(60):
            inside = self.values(C, integrals, high[:, None] * directions) <= 1
            if not inside.any():
                break
            high = np.where(inside, 2 * high, high)
        for _ in range(50):
            middle = (low + high) / 2
            inside = self.values(C, integrals, middle[:, None] * directions) <= 1
            low, high = np.where(inside, middle, low), np.where(inside, high, middle)
        return low

    def values(self, C: Matrix, integrals: Sequence[Integral], points: Matrix) -> Matrix:
        """``V`` at points; ``inf`` where an interval is left on which it may fall."""
        found = np.einsum("ki,ij,kj->k", points, self.P, points)
        for theta, row, integral, reach in zip(self.theta, C, integrals, self.reaches, strict=True):
            if theta:
                sigma = points @ row
                added = 2 * theta * integral(sigma)
                found = np.where((np.abs(sigma) <= reach) | (added >= 0), found + added, np.inf)
        return np.asarray(found)


class _Search(NamedTuple):
    """The plant, what is used of its nonlinearities, and directions in which the set is to grow."""

    plant: Sequence[Matrix]
    local: Sequence[Local]
    integrals: Sequence[Integral | None]
    directions: Matrix
    margin: float

    @property
    def own(self) -> list[int]:
        """The channels with integrals."""
        return [i for i, one in enumerate(self.integrals) if one is not None]

    def parts(self) -> tuple[Matrix, Matrix, Matrix, Matrix]:
        """``F``, ``C F``, and for each channel the two factors of its term but for ``h x``, over ``(x, phi)``."""
        A, B, C, D = self.plant
        n, m = B.shape
        F, Y, phi = np.hstack([A, -B]), np.hstack([C, -D]), np.hstack([np.zeros((m, n)), np.eye(m)])
        upper, lower = (np.array([one[k] for one in self.local])[:, None] for k in (1, 0))
        return F, C @ F, upper * Y - phi, phi - lower * Y


def level_set(  # noqa: PLR0913  (what a search needs)
    plant: Sequence[Matrix],
    local: Sequence[Local],
    integrals: Sequence[Integral | None],
    first: Ellipsoid,
    *,
    points: Matrix | None = None,
    margin: float = 1e-6,
) -> LevelSet | None:
    """A larger set than an ellipsoid, in continuous time.

    Parameters
    ----------
    plant : sequence of ndarray
        ``A``, ``B``, ``C`` and ``D``.
    local : sequence of Local
        What is used of each nonlinearity.
    integrals : sequence of callable or None
        ``int_0^sigma phi_i``, elementwise; None for channels that get none.
    first : Ellipsoid
        Where the search begins.
    points : ndarray or None
        (k, n) points whose multiples the set is to hold; None for its volume.
    margin : float
        By which the inequality is to hold, relative to its terms.

    Returns
    -------
    LevelSet or None
        None where nothing better is found; else what has still to be proved.
    """
    n = len(plant[0])
    back = np.asarray(np.linalg.cholesky(first.P).T, dtype=float)
    scale = np.asarray(np.linalg.inv(back), dtype=float)  # x = scale z, in which the first set is the unit ball
    a = first.weights**-0.5
    turned, own, b = in_units(plant, local, scale, a)
    directions: Matrix = _directions(n) if points is None else np.asarray(np.linalg.solve(scale, points.T).T)
    inner = [None if one is None else _in_units(one, *units) for one, *units in zip(integrals, a, b, strict=True)]
    search = _Search(turned, own, inner, directions, margin)
    safe = [one or (lambda sigma: 0 * sigma) for one in inner]
    zero = np.zeros(len(local))
    wide = np.array([one.reach if one.limit is None else 0.0 for one in own])  # where a sector holds: as far as that
    reaches = np.maximum(_SLACK * np.linalg.norm(turned[2], axis=1), wide)
    best = LevelSet(np.eye(n), zero, reaches, np.ones(len(local)), first.rows @ scale / a[:, None])
    size = _size(best.radii(turned[2], safe, directions), n, alone=points is not None)
    start = size
    for slack in sorted({_LOOSE, margin}, reverse=True):  # a turn goes about as far as there is slack
        search = search._replace(margin=slack)
        for _ in range(ROUNDS):
            found = _grown(search, best, safe, alone=points is not None)
            found = None if found is None else _turned(search, found)
            if found is None:
                break
            now = _size(found.radii(turned[2], safe, directions), n, alone=points is not None)
            if not now > size * (1 + 1e-4):
                break
            best, size = found, now
    if not size > start * (1 + 1e-3):
        return None
    best = _between_strips(search, best)
    return LevelSet(
        back.T @ best.P @ back,
        best.theta / (a * b),
        best.reaches * b,
        best.weights / a**2,
        a[:, None] * best.rows @ back,
    )


def _in_units(integral: Integral, a: float, b: float) -> Integral:
    """``int_0^sigma phi`` with ``sigma`` and ``phi`` in other units."""
    return lambda sigma: integral(b * sigma) / (a * b)


def _directions(n: int) -> Matrix:
    if n == 2:
        angles = np.linspace(0, np.pi, 48, endpoint=False)
        half = np.column_stack([np.cos(angles), np.sin(angles)])
    else:
        half = np.random.default_rng(0).normal(size=(40 * n, n))
        half = np.vstack([half / np.linalg.norm(half, axis=1)[:, None], np.eye(n)])
    return np.vstack([half, -half])


def _size(radii: Matrix, n: int, *, alone: bool) -> float:
    return float(radii.min() if alone else np.mean(radii**n) ** (1 / n))


def _kappas(search: _Search, reaches: Matrix) -> tuple[Matrix, Matrix]:
    """The least and the largest ``2 int phi / sigma^2`` on each interval."""
    low, high = np.zeros(len(reaches)), np.zeros(len(reaches))
    for i in search.own:
        sigma = reaches[i] * np.concatenate([_GRID, -_GRID])
        integral = search.integrals[i]
        assert integral is not None, "it has one"
        ratio = 2 * integral(sigma) / sigma**2
        low[i], high[i] = ratio.min(), ratio.max()
    return low - 1e-9 * np.abs(low), high + 1e-9 * np.abs(high)


def _form_below(search: _Search, now: LevelSet) -> Matrix:
    """The matrix of a form that ``V`` is not below on the intervals."""
    (least, most), C = _kappas(search, now.reaches), search.plant[2]
    factors = now.theta * np.where(now.theta >= 0, least, most)
    return np.asarray(now.P + C.T @ (factors[:, None] * C))


def _between_strips(search: _Search, now: LevelSet) -> LevelSet:
    """The set made so small that its ellipsoid lies in the strips, which a solver's tolerance leaves open."""
    low = _form_below(search, now)
    most = max(
        float(row @ np.linalg.solve(low, row)) / limit**2 for row, limit in _strips(search, now.rows, now.reaches)
    )
    factor = max(1.0, most * _INSIDE)
    return now._replace(P=factor * now.P, theta=factor * now.theta, weights=factor * now.weights)


def _strips(search: _Search, rows: Matrix, reaches: Matrix) -> list[tuple[Matrix, float]]:
    found = [(search.plant[2][i], float(reaches[i])) for i in search.own]
    for i, one in enumerate(search.local):
        found.append((search.plant[2][i], one.reach) if one.limit is None else (rows[i], one.limit))
    return found


def _grown(search: _Search, now: LevelSet, integrals: Sequence[Integral], *, alone: bool) -> LevelSet | None:
    """``P``, ``theta`` and weights for given rows: the least mean (or largest) value of ``V`` where it was 1."""
    n, m = search.plant[1].shape
    F, CF, left, right = search.parts()
    C, basis, own = search.plant[2], symmetric_basis(n), search.own
    s, q = len(basis), len(own)
    count = s + 2 * q + m + 1  # P, theta above 0, theta below 0, weights, the largest value
    right = right - np.hstack([now.rows, np.zeros((m, m))])
    slopes = np.zeros((count, n + m, n + m))
    half = np.zeros((s, n + m, n + m))
    half[:, :n] = basis @ F
    slopes[:s] = -half
    kappa = _kappas(search, now.reaches)
    low = np.zeros((count, n, n))
    low[:s] = basis
    for j, i in enumerate(own):
        for at, sign, bound in ((s + j, 1.0, kappa[0][i]), (s + q + j, -1.0, kappa[1][i])):
            slopes[at, n + i] = -sign * CF[i]
            low[at] = sign * bound * np.outer(C[i], C[i])
    for i in range(m):
        slopes[s + 2 * q + i] = -np.outer(left[i], right[i])
    slopes = slopes + np.swapaxes(slopes, 1, 2)
    held = np.diag(np.concatenate([np.ones(n) * np.linalg.norm(search.plant[0], 2), np.abs(now.weights)]))
    blocks = [Block(-search.margin * held, slopes)]
    for row, limit in _strips(search, now.rows, now.reaches):
        inner, constant = np.zeros((count, n + 1, n + 1)), np.zeros((n + 1, n + 1))
        inner[:, :n, :n] = low
        constant[n, :n] = constant[:n, n] = row
        constant[n, n] = limit**2 * (1 - 1e-7)
        blocks.append(Block(constant, inner))
    places = now.radii(C, integrals, search.directions)[:, None] * search.directions
    values = np.zeros((len(places), count))
    values[:, :s] = np.einsum("ki,bij,kj->kb", places, basis, places)
    for j, i in enumerate(own):
        values[:, s + j] = 2 * integrals[i](places @ C[i])
        values[:, s + q + j] = -values[:, s + j]
    cost = np.zeros(count)
    signs = np.zeros((2 * q + m, count))
    signs[np.arange(2 * q + m), np.arange(s, s + 2 * q + m)] = -1.0
    if alone:
        values[:, -1] = -1.0
        cost[-1] = -1.0
        rows = np.vstack([signs, values])
    else:
        cost = -values.mean(axis=0)
        rows = signs
    found = proposed(cost, blocks, rows, np.zeros(len(rows)))
    if found is None:
        return None
    theta = np.zeros(m)
    theta[own] = found[s : s + q] - found[s + q : s + 2 * q]
    P = np.tensordot(found[:s], basis, 1)
    return now._replace(P=P, theta=theta, weights=np.maximum(found[s + 2 * q : -1], 0.0))


def _turned(search: _Search, now: LevelSet) -> LevelSet | None:
    """Rows and weights for given ``P`` and ``theta``, for the largest level that can be had; it becomes 1."""
    n, m = search.plant[1].shape
    F, CF, left, right = search.parts()
    limited = [one.limit is not None for one in search.local]
    free = [i for i, one in enumerate(limited) if one]
    C = search.plant[2]
    low = _form_below(search, now)
    if np.linalg.eigvalsh(low)[0] <= 0:
        return None
    count = m + n * len(free)
    base = np.zeros((n + m, n + m))
    base[:n] = -now.P @ F
    for i, theta in enumerate(now.theta):
        base[n + i] -= theta * CF[i]
    slopes = np.zeros((count, n + m, n + m))
    for i in range(m):
        slopes[i] = -np.outer(left[i], right[i])
    for a, i in enumerate(free):
        for k in range(n):
            slopes[m + a * n + k] = np.outer(left[i], np.eye(n + m)[k])
    held = np.diag(np.concatenate([np.ones(n) * np.linalg.norm(search.plant[0], 2), np.abs(now.weights)]))
    inequality = Block(base + base.T - search.margin * held, slopes + np.swapaxes(slopes, 1, 2))
    own = [float(row @ np.linalg.solve(low, row)) / limit**2 for row, limit in _strips(search, now.rows, now.reaches)]
    signs = np.zeros((m, count))
    signs[np.arange(m), np.arange(m)] = -1.0

    def at_level(level: float) -> LevelSet | None:
        """Weights and rows with which the set of a larger level is invariant."""
        blocks = [inequality]
        for a, i in enumerate(free):
            strip = np.zeros((count, n + 1, n + 1))
            strip[i, :n, :n] = low
            strip[i, n, n] = (search.local[i].limit or 0.0) ** 2 / level * (1 - 1e-7)
            for k in range(n):
                strip[m + a * n + k, n, k] = strip[m + a * n + k, k, n] = 1.0
            blocks.append(Block(np.zeros((n + 1, n + 1)), strip))
        found = proposed(np.zeros(count), blocks, signs, np.zeros(m))
        if found is None or min(found[:m]) <= 0:
            return None
        for block in blocks:
            matrix = block.constant + np.tensordot(found, block.slopes, 1)
            if np.linalg.eigvalsh(matrix)[0] < -1e-9 * np.abs(matrix).max():
                return None
        rows = np.zeros((m, n))
        for a, i in enumerate(free):
            rows[i] = found[m + a * n : m + (a + 1) * n] / found[i]
        grown = np.sqrt(level * np.einsum("ij,ji->i", C, np.linalg.solve(low, C.T)))
        reaches = np.where(limited, np.maximum(_SLACK * grown, 1e-12), now.reaches)
        return LevelSet(now.P / level, now.theta / level, reaches, found[:m] / level, rows)

    if not free:
        level = 1 / max(own) if own else 1.0
        return now._replace(P=now.P / level, theta=now.theta / level, weights=now.weights / level)
    best, low_level, high_level = at_level(1.0), 1.0, 2.0
    if best is None:
        return None
    for _ in range(10):
        middle = (low_level + high_level) / 2
        found = at_level(middle)
        if found is None:
            high_level = middle
        else:
            best, low_level = found, middle
    return best
