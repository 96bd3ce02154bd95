r"""Full-block multipliers of several channels, in floating point: ``Pi`` by one semidefinite programme.

After the shift ``psi = Delta sigma`` at each time, ``Delta`` diagonal, ``0 <= Delta_ii <= w_i``.  A symmetric matrix
``Pi = [[Q, S], [S', R]]`` is a multiplier if its form in ``(sigma, psi)`` is nonnegative for all of these.  Two ways
show it:

Vertices: ``[1; Delta]' Pi [1; Delta] >= 0`` for ``Delta_ii`` in ``{0, w_i}``, and ``R_ii <= 0``, so that the form is
concave in each ``Delta_ii``.

Orthants: ``psi_i`` and ``w_i sigma_i - psi_i`` have one sign ``s_i``.  With ``J`` for the form in these, ``S J S - N >=
0`` and ``N >= 0`` entry by entry, for each of the ``2^(m - 1)`` pairs of signs ``s``, ``-s``, ``S = diag(s, s)``.

The diagonal multipliers are those with ``Q = 0``, ``S`` and ``R`` diagonal.  Operators have a weight beside ``Pi``,
which is about the other channels.  Nothing here is believed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import field
from fractions import Fraction
from itertools import product
from typing import Any, NamedTuple

from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.shifted_loop import LARGEST, Proposal, ShiftedLoop, Widths
from lure.analysis.numerics.doubles import decimals, triangle_texts
from lure.analysis.numerics.semidefinite import Block, proposed, roughly, symmetric_basis
from lure.arrays import NDArray, in_doubles, np
from lure.record import described, quantity

MOST_STATES, MOST_CHANNELS, MOST_ORTHANTS = 20, 6, 4  # beyond them a programme takes seconds, and a search a minute
_SURE, _LARGEST, _LARGEST_THETA = 1e-7, 100.0, 1e4
_ROOMS = (1e-9, 1e-7, 1e-5)  # of the largest entry: what is added to the form so that rounding leaves it positive
_BITS = 44
_STEPS, _HALVINGS, _ROUNDED, _NEAR, _SAME, _FAR = 10, 20, 1e-7, 1e-5, 1e-8, 0.05
Rows = list[list[Fraction]]


class FullBlock(NamedTuple):
    """``Pi`` for ``(sigma, psi/w)``, ``theta``, ``N`` for each pattern of signs (none: vertices), and what is left.

    ``weights``: of ``w^2 sigma^2 - psi^2`` for the channels of operators, 0 for those of ``Pi``.
    """

    Pi: NDArray[np.float64]
    theta: NDArray[np.float64]
    parts: list[NDArray[np.float64]]
    margin: float
    weights: NDArray[np.float64]


def signs(m: int) -> list[tuple[int, ...]]:
    """The patterns of signs of ``m`` channels, the first positive, in the order of a certificate.

    ``m``: number of channels.
    """
    return [(1, *rest) for rest in product((1, -1), repeat=m - 1)]


@described()
class FullBlockInequality(ShiftedLoop):
    """The inequality of one plant and lower bounds with full-block multipliers; parameters as for the diagonal ones."""

    orthants: bool = quantity(
        "Whether ``Pi`` is shown to be a multiplier by its orthants; else by its vertices", default=False
    )
    latest: tuple[NDArray[np.float64], FullBlock | None] = field(
        default_factory=lambda: (np.zeros(0), None), init=False
    )

    def multipliers(
        self, widths: NDArray[np.float64], before: FullBlock | None = None, rates: NDArray[np.float64] | None = None
    ) -> FullBlock | None:
        """Multipliers and a margin that is more than rounding, None if there are none or the programme is too large.

        Parameters
        ----------
        widths : ndarray
            (m,) of the shifted sectors.
        before : FullBlock or None
            Multipliers found before: then the margin is that of the vertices, about the relative gain of factor that is
            left, of either sign.
        rates : ndarray or None
            (m,) how much the widths gain, relatively, where the factor gains 1.
        """
        (n, m), own = self.B.shape, self.own_channels
        k = len(own)
        if n > MOST_STATES or not 0 < k <= (MOST_ORTHANTS if self.orthants else MOST_CHANNELS):
            return None
        checkpoint()
        free = [i for i in range(m) if self.free[i]]
        state, form = symmetric_basis(n), symmetric_basis(2 * k)
        patterns = signs(k) if self.orthants else []
        sizes = [len(state), len(form), len(free), 1, *(len(form) for _ in patterns), len(self.operators)]
        starts = np.concatenate([[0], np.cumsum(sizes)])
        total = int(starts[-1])

        def block(order: int, parts: dict[int, NDArray[np.float64]]) -> Block:
            """A matrix that is linear in the unknowns, from its slopes."""
            slopes = np.zeros((total, order, order))
            for which, part in parts.items():
                slopes[starts[which] : starts[which + 1]] = part
            return Block(np.zeros((order, order)), slopes)

        margin, last = np.diag([0.0] * n + [1.0] * m), len(sizes) - 1
        scale = [float(widths[[*b]].max()) ** 2 for b in self.operators]
        slopes, norms = self._falling(widths, state, form, scale)
        parts = dict(enumerate(slopes)) | ({3: -margin[None]} if before is None else {})
        blocks = [block(n + m, parts | ({last: norms} if self.operators else {}))]
        blocks += [block(len(sides[1][0]), sides) for sides in self._legal(form, before, rates)]
        diagonal = starts[1] + np.array([i * (i + 1) // 2 + i for i in range(2 * k)])
        bounds: list[tuple[int, float, float]] = []  # of entry k: factor, and what it times the entry is at most
        bounds += [(j, sign, most) for j in range(starts[last], total) for sign, most in ((-1.0, 0.0), (1.0, _LARGEST))]
        bounds += [(j, -1.0, 0.0) for j in range(starts[4], starts[last])]
        bounds += [(j, 1.0, 0.0) for j in diagonal[k:] if not self.orthants]
        bounds += [(j, sign, _LARGEST) for j in diagonal for sign in (1.0, -1.0)]
        bounds += [(j, sign, _LARGEST_THETA) for j in range(starts[2], starts[3]) for sign in (1.0, -1.0)]
        bounds += [(starts[3], 1.0, _LARGEST)]
        rows = np.zeros((len(bounds), total))
        rows[np.arange(len(bounds)), [j for j, *_ in bounds]] = [factor for _, factor, _ in bounds]
        limits = np.array([most for *_, most in bounds])
        if before is not None:  # the size of the form, which the margins are compared with
            middle = np.vstack([np.eye(k), np.eye(k) / 2])
            size = np.zeros(total)
            size[starts[1] : starts[2]] = np.trace(middle.T @ form @ middle, axis1=1, axis2=2)
            kept = float(np.trace(middle.T @ before.Pi @ middle))
            rows, limits = np.vstack([rows, size, -size]), np.append(limits, [kept, -kept])
        cost = np.zeros(total)
        cost[starts[3]] = 1.0
        solve = roughly if before is not None and before.margin > _FAR else proposed
        found = solve(cost, blocks, rows, limits)
        if found is None or (before is None and found[starts[3]] <= _SURE):
            return None
        theta = np.zeros(m)
        theta[free] = found[starts[2] : starts[3]] * self.unit
        signed = [np.tensordot(found[starts[at] : starts[at + 1]], form, 1) for at in range(4, 4 + len(patterns))]
        weights = np.zeros(m)
        for at, b in enumerate(self.operators):
            weights[[*b]] = max(found[starts[last] + at], 0.0) / scale[at] / 2
        return FullBlock(
            np.tensordot(found[starts[1] : starts[2]], form, 1), theta, signed, float(found[starts[3]]), weights
        )

    def _legal(
        self, form: NDArray[np.float64], before: FullBlock | None, rates: NDArray[np.float64] | None
    ) -> Iterator[dict[int, NDArray[np.float64]]]:
        """What makes ``Pi`` a multiplier, slopes by their unknowns: for every orthant, or for every vertex."""
        own = self.own_channels
        k = len(own)
        if self.orthants:
            view = _view(k)
            inner = view.T @ form @ view
            for at, pattern in enumerate(signs(k), 4):
                both = np.array([*pattern, *pattern])
                yield {1: inner * both[:, None] * both, at: -form}
            return
        for view in _vertices(np.ones(k)):
            sides = {1: view.T @ form @ view}
            if before is not None and rates is not None:
                turn = view.T @ before.Pi @ np.vstack([np.zeros((k, k)), view[k:] * rates[own]])
                sides[3] = (turn + turn.T)[None]
            yield sides

    def _falling(
        self, widths: NDArray[np.float64], state: NDArray[np.float64], form: NDArray[np.float64], scale: list[float]
    ) -> tuple[list[NDArray[np.float64]], NDArray[np.float64]]:
        """Slopes of the matrix of ``-V'`` in the unknowns ``P``, ``Pi`` and ``theta``; in the weights of operators."""
        (n, m), own = self.B.shape, self.own_channels
        free = [i for i in range(m) if self.free[i]]
        B, D = self.B * widths, self.D * widths
        moves, stays = np.hstack([self.A, -B]), np.hstack([np.eye(n), np.zeros((n, m))])
        Y = np.vstack([np.hstack([self.C, -D]), np.hstack([np.zeros((m, n)), np.eye(m)])])
        if self.discrete:
            falls = stays.T @ state @ stays - moves.T @ state @ moves
        else:
            falls = -(stays.T @ state @ moves + moves.T @ state @ stays)
        turns = [-np.outer(Y[m + i], widths[i] * self.own[i] @ moves) * self.unit for i in free]
        turning = np.array([t + t.T for t in turns]).reshape(len(free), n + m, n + m)
        seen = Y[[*own, *(m + i for i in own)]]
        acting = [widths[[*b]][:, None] * Y[[*b]] for b in self.operators]
        acted = [Y[[m + i for i in b]] * widths[[*b]][:, None] for b in self.operators]
        norms = np.array([(v.T @ v - u.T @ u) / c for u, v, c in zip(acting, acted, scale, strict=True)])
        return [falls, -(seen.T @ form @ seen), turning], norms

    @property
    def own_channels(self) -> list[int]:
        """The channels of ``Pi``."""
        return [i for i, acting in enumerate(self.acting) if not acting]

    def largest(self, widths: Widths, start: float, most: float) -> float:
        """The largest factor for which the programme finds multipliers, where its margins would end; see the base."""
        margins = list[tuple[float, float]]()

        def serves(factor: float) -> bool:
            """Whether multipliers are found for the widths at a factor, whose margin is noted."""
            at = widths(factor)
            found = self.multipliers(at) if at.min() > 0 else None
            if found is not None:
                margins.append((factor, found.margin))
                self.latest = at, found
            return found is not None

        low, high = self._between(serves, start, most) if most < math.inf else (start, math.inf)
        if (math.isinf(high) or high - low > self.precision * high) and not (self.orthants or self.operators):
            risen = min(self._risen(widths, low or 1.0), most, LARGEST)
            near = [risen * (1 - back) for back in (2 * self.precision, 100 * self.precision)]
            served = next((one for one in near if one > low and serves(one)), None)
            if served == near[0]:
                return served
            low, high = (low, high) if served is None else (served, risen)
        if math.isinf(high):
            low, high = self._between(serves, start, most)
        side = 1 - self.precision / 3
        while high - low > self.precision * high:
            checkpoint()
            middle = (low + high) / 2 if low > high / 8 else math.sqrt(low * high) if low else high / 8
            if middle * LARGEST < min(most, 1.0) / LARGEST:
                return 0.0
            (a, s), (b, t) = sorted(margins)[-2:] if len(margins) > 1 else ((0.0, 0.0), (0.0, 0.0))
            ends = b + t * (b - a) / (s - t) if s > t else 0.0
            ends, side = ends * side, 2 - side  # below it, then above
            middle = ends if low < ends < high and ends - b < 0.9 * (high - b) else middle
            low, high = (middle, high) if serves(middle) else (low, middle)
        return low

    def _risen(self, widths: Widths, factor: float) -> float:
        """The largest factor, by Newton's method for the generalised eigenvalue; 0 where that fails.

        ``P`` is about the states and the form, whatever the factor: multipliers serve as far as their vertices do, and
        the next ones leave most at these vertices.
        """
        k = len(self.own_channels)
        one, none = np.eye(k), np.zeros((k, k))
        found = FullBlock(
            np.block([[none, one], [one, -2 * one]]), np.zeros(len(self.D)), [], 1.0, np.zeros(len(self.D))
        )
        for _ in range(_STEPS):
            at = widths(factor)
            if at.min() <= 0:
                return 0.0
            tried = self.multipliers(at, found, (widths(2 * factor) - at) / at)
            if tried is None:
                return 0.0
            factor *= max(1 + min(tried.margin, 1.0), self._further(tried.Pi, at, widths, factor))
            if abs(tried.margin) < _NEAR or factor > LARGEST:
                return factor
            units = np.append(np.ones(k), (widths(factor) / at)[self.own_channels])
            found = tried._replace(Pi=tried.Pi * units[:, None] * units)
        return 0.0

    def _further(self, Pi: NDArray[np.float64], at: NDArray[np.float64], widths: Widths, factor: float) -> float:
        """The ratio of the largest factor at whose vertices the form is nonnegative to a factor."""
        least, low, high, own = -_ROUNDED * float(np.abs(Pi).max()), 0.0, 4.0, self.own_channels
        for _ in range(_HALVINGS):
            ratio = (low + high) / 2
            views = _vertices((widths(ratio * factor) / at)[own])
            serves = np.linalg.eigvalsh(views.swapaxes(1, 2) @ Pi @ views).min() > least
            low, high = (ratio, high) if serves else (low, ratio)
        return low

    def serves(self, widths: NDArray[np.float64]) -> bool:
        """Whether the programme finds multipliers; see :meth:`multipliers`."""
        return self.multipliers(widths) is not None

    def proposals(self, widths: Sequence[Fraction], lower: Sequence[Fraction]) -> Iterator[Proposal]:
        """``Pi`` rounded with more and less room, with ``P`` of Riccati equations; see :class:`ShiftedLoop`."""
        at, (before, found) = np.array([float(w) for w in widths]), self.latest
        if found is None or not (at <= before).all() or not np.allclose(at, before, rtol=_SAME, atol=0):
            found = self.multipliers(at)
        if found is None:
            return
        own, total = self.own_channels, len(widths)
        m = len(own)
        theta = decimals(found.theta)
        weights = decimals(found.weights)
        size = float(np.abs(found.Pi).max())
        parts = [np.maximum(part, 0) for part in found.parts]
        lacking = self._lacking(found.Pi, parts)
        corner = np.arange(m, 2 * m)
        for room in _ROOMS:
            raised = found.Pi.copy()
            if parts:
                raised += 3 * (lacking + room * size) * np.eye(2 * m)  # J'J > 1/3
            else:
                raised[np.diag_indices(m)] += lacking + room * size
                raised[corner, corner] = np.minimum(raised[corner, corner], 0)
            grid = Fraction(2) ** (int(np.floor(np.log2(size))) - _BITS)
            units = [Fraction(1)] * m + [1 / widths[i] for i in own]  # of psi/w
            Pi = _congruent(_exact(raised, grid), units)
            ends = [*units[m:], *units[m:]]  # of (psi, w sigma - psi)/w
            multiplier: dict[str, Any] = {"Pi": triangle_texts(_moved(Pi, [lower[i] for i in own]))}
            multiplier |= {"lambda": [*map(str, weights)]} if self.operators else {}
            if parts:
                multiplier["N"] = [triangle_texts(_congruent(_exact(part, grid), ends)) for part in parts]
            near = self.form(*(np.array([float(v) for v in side]) for side in (weights, widths)))
            places = [*own, *(total + i for i in own)]
            near[np.ix_(places, places)] += in_doubles(Pi)
            for proof in self.solutions(near, theta, lower):
                yield Proposal(multiplier | self.popovs(theta), proof)

    def _lacking(self, Pi: NDArray[np.float64], parts: list[NDArray[np.float64]]) -> float:
        """By how much the forms that are to be nonnegative fall below 0."""
        m = len(Pi) // 2
        if parts:
            inner, patterns = _view(m).T @ Pi @ _view(m), np.array([[*s, *s] for s in signs(m)])
            forms = np.array([inner * s[:, None] * s - part for s, part in zip(patterns, parts, strict=True)])
        else:
            views = _vertices(np.ones(m))
            forms = views.swapaxes(1, 2) @ Pi @ views
        return max(0.0, -float(np.linalg.eigvalsh(forms).min()))


def _vertices(ends: NDArray[np.float64]) -> NDArray[np.float64]:
    """``(1, Delta)`` for each diagonal ``Delta`` with entries 0 or ``ends``: (2^k, 2k, k)."""
    k = len(ends)
    return np.array([np.vstack([np.eye(k), np.diag(ends * pattern)]) for pattern in product((0.0, 1.0), repeat=k)])


def _view(m: int) -> NDArray[np.float64]:
    """``(sigma, psi)`` from ``(psi, sigma - psi)``."""
    one = np.eye(m)
    return np.block([[one, one], [one, 0 * one]])


def _exact(matrix: NDArray[np.float64], grid: Fraction) -> Rows:
    return [[round(Fraction(float(v)) / grid) * grid for v in row] for row in (matrix + matrix.T) / 2]


def _congruent(matrix: Rows, factors: Sequence[Fraction]) -> Rows:
    return [[v * f * g for v, g in zip(row, factors, strict=True)] for row, f in zip(matrix, factors, strict=True)]


def _moved(Pi: Rows, lower: Sequence[Fraction]) -> Rows:
    """The form in ``(sigma, phi)``, ``psi = phi - l sigma``."""
    m, found = len(lower), [list(row) for row in Pi]
    for _ in range(2):  # columns, then rows
        for i, shift in enumerate(lower):
            for row in found:
                row[i] -= shift * row[m + i]
        found = [list(column) for column in zip(*found, strict=True)]
    return found
