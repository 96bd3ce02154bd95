r"""One round trip in which nothing happens, as a matrix.

On a straight segment, on pieces that stay the same, the state of a round trip gives that of the next, linearly.  The
state is the wave, ``zeta`` where the round trip begins, the impulse so far, the functions of the force, and 1:

.. math:: y_{n+1} = y_n + D y_n.

In contact the coordinates of the wave are its coefficients on the pieces.  In flight it comes back as it was, times a
number, so that the wave at hand and the functions of the force are a basis of all that follow: a handful of
coordinates, however many pieces there are.

On a piece ``zeta`` solves ``zeta' + s zeta = h`` on ``[-1, 1]``.  The integrated equation of its coefficients,
``2 k z_k + s (z_{k-1} - z_{k+1}) = h_{k-1} - h_{k+1}``, is that of :mod:`lure.rod.motion.kernel_piece`.
"""

from __future__ import annotations

from dataclasses import field
from functools import lru_cache

import numpy as np

from lure.record import described, quantity
from lure.rod.motion.exponential_force import ExponentialForce
from lure.rod.motion.kernel_free import SEEN, SMALL, TOP, WAY_BACK
from lure.rod.motion.pieces import Array, products


@described(frozen=True, kw_only=True, eq=False, slots=True)
class Setting:
    """What does not change in an interval without events."""

    edges: Array = quantity("(P+1,) ends of the pieces [transits]")
    halves: Array = quantity("(P,) half their widths", "s")
    origin: float = quantity("Coordinate from which ``zeta`` is counted on the segment", "m")
    push: float = quantity("``d p`` there [m/s]")
    rate: float = quantity("``d p'`` on the segment [1/s]")
    transit: float = quantity("``T``", "s")
    share: float = quantity("``1/(1 + k_L/Z)``")
    echo: float = quantity("``-a``")
    loading: float = quantity("Impulse per integral of ``d p`` [N s/m]; 0 without contact")
    degree: int = quantity("The highest of a series")


@described(frozen=True, kw_only=True, eq=False, slots=True)
class TripMatrix:
    """What a round trip makes of a state (N,): of coordinates of the wave, ``zeta``, impulse, functions of force, 1."""

    setting: Setting = quantity("Pieces, segment and rod")
    step: Array = quantity("(N, N) the matrix ``D``")
    wave: Array = quantity("(P, n+1, N) the coefficients of ``W`` on the pieces")
    unit: Array = quantity("(P, K, n+1) the coefficients of the solution that starts at 0, for ``h = T_j``, in seconds")
    begins: Array = quantity("(P+1, N) ``zeta`` where the pieces begin, and at the end")
    zeta: int = quantity("Place of ``zeta`` in the state; the impulse is next, then the force")
    _made: list[Array] = field(default_factory=list)

    @property
    def series(self) -> Array:
        """(P, K, N) the coefficients of ``zeta`` on the pieces."""
        if not self._made:
            at, free = self.setting, self.unit[:, :, 0]
            found = at.share * (self.unit @ self.wave)
            if at.rate:
                found -= (at.rate * free)[:, :, None] * self.begins[:-1, None, :]
            found[:, :, -1] -= at.push * free
            found[:, 0] += self.begins[:-1]
            self._made.append(found)
        return self._made[0]

    def returned(self, state: Array) -> Array:
        """(P, n+1) the wave that comes back after the round trip with a state, before the force adds to it."""
        alone = state.copy()
        alone[self.zeta + 2 : -1] = 0.0
        alone[: self.zeta] += self.step[: self.zeta] @ alone
        return np.asarray(self.wave @ alone)


def trip_matrix(setting: Setting, back: Array, force: ExponentialForce, number: int) -> tuple[TripMatrix, Array] | None:
    """The matrix of the round trips from one on, and its state; None where these pieces will not do.

    ``back``: (P, degree+1) the wave that comes back to the round trip ``number``; ``force``: what adds to it.
    """
    size, flight = np.abs(back), setting.rate == 0.0
    largest = float(np.add.reduce(size, axis=1).max())
    columns = force.columns(number, setting.edges, setting.degree, SMALL * largest)
    if columns is None:
        return None
    P, C = len(back), len(columns)
    n, tiny = setting.degree, (SEEN if flight else TOP) * largest
    sizes = np.maximum.reduce(size).tolist()
    while n >= columns.shape[2] and not sizes[n] > tiny:
        n -= 1
    last = min(n + 1, setting.degree)
    if not flight:
        stiff, n, last = setting.rate * setting.halves, n + 1, n + 2
        half, k, term = 0.5 * float(stiff.max()), 0, 1.0
        while k < last or (term > SMALL and k < setting.degree):
            k += 1
            term *= half / k
        last = min(k, setting.degree)
        if n > setting.degree or term > SMALL:
            return None
    unit = setting.halves[:, None, None] * (_quadrature(n, last) if flight else _solutions(stiff, n, last))
    loads = np.zeros((P, n + 1, C))
    loads[:, : columns.shape[2]] = columns.transpose(1, 2, 0)
    constant = -2.0 * setting.echo * setting.push
    r = 1 + C + (constant != 0.0) if flight else P * (n + 1)
    N = r + C + 3
    wave, state, step = np.zeros((P, n + 1, N)), np.zeros(N), np.zeros((N, N))
    state[r + 2 : -1], state[-1] = force.start, 1.0
    if flight:
        wave[:, :, 0], wave[:, :, 1 : 1 + C], wave[:, 0, 1 + C : r] = back[:, : n + 1], loads, 1.0
        state[0], state[1 : 1 + C] = 1.0, force.start
    else:
        wave.ravel()[: r * N : N + 1] = 1.0
        state[:r] = (back[:, : n + 1] + loads @ force.start).ravel()
    begins, step[r] = _begins(setting, wave, unit, r)
    made = TripMatrix(setting=setting, step=step, wave=wave, unit=unit, begins=begins, zeta=r)
    step.ravel()[: r * N : N + 1] = setting.echo * (2.0 * setting.share - 1.0) - 1.0
    step[r + 1, -1] = 2.0 * setting.loading * setting.push * setting.transit
    step[r + 2 : -1, r + 2 : -1] = force.turn
    turned = force.turn.copy()
    turned.ravel()[:: C + 1] += 1.0
    if flight:
        step[1 : 1 + C, r + 2 : -1], step[1 + C : r, -1] = turned, constant
    else:
        echoes = (-2.0 * setting.echo * setting.rate) * made.series[:, : n + 1]
        echoes[:, 0, -1] += constant
        echoes[:, :, r + 2 : -1] += loads @ turned
        step[:r] += echoes.reshape(r, N)
        shares = setting.loading * setting.rate * setting.halves
        step[r + 1] += np.multiply.outer(shares, products(last + 1)[0]).ravel() @ made.series.reshape(-1, N)
    return made, state


def _begins(setting: Setting, wave: Array, unit: Array, zeta: int) -> tuple[Array, Array]:
    """``zeta`` (P+1, N) where the pieces begin, and the way (N,) of a round trip."""
    P, ends = len(wave), unit.sum(axis=1)
    if setting.rate == 0.0:
        ends[:, 1::2] = 0.0  # nothing, not rounding
    ways = setting.share * (ends[:, None, :] @ wave)[:, 0]
    ways[:, -1] -= setting.push * ends[:, 0]
    begins = np.zeros((P + 1, wave.shape[2]))
    begins[0, zeta] = 1.0
    if setting.rate == 0.0:
        begins[1:] = np.cumsum(ways, axis=0)
        way = begins[-1].copy()
        begins[1:, zeta] = 1.0
        there_and_back = setting.share * (np.abs(ends).ravel() @ np.abs(wave).reshape(-1, len(way)))
        way[np.abs(way) <= WAY_BACK * there_and_back] = 0.0
        return begins, way
    lost = setting.rate * ends[:, 0]
    chain = np.eye(P + 1)
    chain[np.arange(1, P + 1), np.arange(P)] = lost - 1.0
    begins[1:] = ways
    begins[:] = np.linalg.solve(chain, begins)
    return begins, (ways - lost[:, None] * begins[:-1]).sum(axis=0)


@lru_cache(maxsize=64)
def _differences(n: int, last: int) -> Array:
    """(K, n+1) the coefficients ``h_{k-1} - h_{k+1}`` of ``T_j``, 0 for ``k = 0``."""
    found = np.zeros((last + 1, n + 1))
    for j in range(n + 1):
        if j < last:
            found[j + 1, j] = 2.0 if j == 0 else 1.0
        if j > 1:
            found[j - 1, j] = -1.0
    return found


@lru_cache(maxsize=64)
def _quadrature(n: int, last: int) -> Array:
    """(K, n+1) the coefficients of the integrals of ``T_j`` from -1."""
    found = _differences(n, last).copy()
    found[1:] /= 2.0 * np.arange(1, last + 1)[:, None]
    found[0] = -(_signs(last)[1:] @ found[1:])
    return found


def _solutions(stiff: Array, n: int, last: int) -> Array:
    """(P, K, n+1) the same with ``s`` (P,) > 0; the last row takes its value at 1 for ``s -> inf`` from ``h``."""
    right, still, moving = _equations(n, last)
    return np.asarray(np.linalg.solve(still + np.multiply.outer(stiff, moving), right))


@lru_cache(maxsize=64)
def _equations(n: int, last: int) -> tuple[Array, Array, Array]:
    """Right side (K, n+1) and matrix (K, K) of the equations of the coefficients: for 0, and what ``s`` adds."""
    right, k = _differences(n, last).copy(), np.arange(1, last + 1)
    still, moving = np.zeros((last + 1, last + 1)), np.zeros((last + 1, last + 1))
    if last <= n:
        right[last, last] += (last + 1.0) / last
    still[0], still[k, k] = _signs(last), 2.0 * k
    moving[k, k - 1], moving[k[:-1], k[1:]] = 1.0, -1.0
    moving[1, 0] = 2.0
    moving[last, last] += (last + 1.0) / last
    return right, still, moving


@lru_cache(maxsize=64)
def _signs(last: int) -> Array:
    """Values of the polynomials at -1."""
    return np.asarray((-1.0) ** np.arange(last + 1))
