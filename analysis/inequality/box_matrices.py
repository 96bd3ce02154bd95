r"""Plants of several channels with parameters in a box, in floating point: one ``P`` and one multiplier for a box.

Sought are ``P``, ``lambda_i`` and ``theta_i`` such that the Bernstein coefficients, on a box, of the matrix of ``-V'``
less the forms of the classes, ``V = x'P x + 2 sum theta_i int phi_i``, are positive definite, times the square of the
common denominator.  All are linear in the unknowns, the square of the gain from ``w`` to ``z`` too: one semidefinite
programme.  Nothing here is believed: a checker decides with rational numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from math import comb, inf, prod
from typing import Any, NamedTuple

from lure.analysis.deadline import checkpoint
from lure.analysis.numerics.doubles import decimals, places, triangle, triangle_texts
from lure.analysis.numerics.semidefinite import Limits, in_stages, symmetric_basis
from lure.arrays import Reals, balanced, in_doubles, np
from lure.plants.channel_family import ChannelFamily
from lure.plants.parameters import Box
from lure.record import described, quantity

_LARGEST, _SURE, _MOST, _BITS = 4e7, 1e-8, 1e5, 48
_SLACK = 1e-8  # of the least square of a gain, in units of the plant


class Found(NamedTuple):
    """``P_0, P_1, ...``, ``lambda``, ``theta`` and the gain from ``w`` to ``z``, in the units of the plant."""

    P: Reals
    weights: Reals
    theta: Reals
    gain: float

    def entry(self, *, popov: bool) -> dict[str, Any]:
        """As they stand in a certificate; ``popov``: whether the theorem has ``theta``."""
        smallest = float(np.abs(np.diag(self.P[0])).min())
        exponent = places(smallest, _BITS)
        rows = [triangle_texts(triangle(Q, exponent)) for Q in self.P]
        found = {"lambda": [*map(str, decimals(max(v, 0.0) for v in self.weights))], "P": rows}
        turned = {"theta": [*map(str, decimals(self.theta))]} if popov else {}
        return {**found, **turned, "exponent": exponent}


class _Units(NamedTuple):
    """Of each state, of each ``sigma`` and ``mu``, and of time [1/s]."""

    state: Reals
    seen: Reals
    force: Reals
    time: float


@described()
class BoxMatrices:
    """The programme for some plants and classes."""

    family: ChannelFamily = quantity("The plants; from ``w`` to ``z`` are the last channels")
    blocks: Sequence[range] = quantity("The channels that have one weight: each alone, but those of an operator")
    performance: range | None = quantity("The channels from ``w`` to ``z``")
    free: Sequence[bool] = quantity("Which ``theta`` may differ from 0")
    rate: float = quantity(
        "In continuous time the plants are those of the solutions times ``e^(rate t)``; then ``theta >= 0``",
        default=0.0,
    )
    sloped: Sequence[bool] = quantity(
        "With a rate: in which channels the slopes are in the bounds of the sector", default=()
    )

    def __post_init__(self) -> None:
        self.terms = [
            (one.powers, float(one.common), [in_doubles(side) for side in one.sides]) for one in self.family.terms
        ]
        self.discrete, self.needed = self.family.dt is not None, dict[tuple[int, ...], list[set[int]]]()
        rates = enumerate(self.family.rates)
        self.jumping = [j for j, rate in rates if rate and (rate == inf or self.discrete)]  # P does not depend on these

    def at(self, points: Reals) -> tuple[Reals, list[Reals]]:
        """The common denominator, (N,), and ``A``, ``B``, ``C``, ``D`` times it, (N, .., ..).

        ``points``: (N, parameters).
        """
        powers, common = np.array([one[0] for one in self.terms]), np.array([one[1] for one in self.terms])
        shares = np.prod(points[:, None, :] ** powers, axis=2)
        return shares @ common, [np.tensordot(shares, [one[2][k] for one in self.terms], 1) for k in range(4)]

    def degrees(self) -> tuple[list[int], list[int]]:
        """In each parameter: of the matrix, as the checker counts, and of what is below ``V``."""
        found, below, turned = list[int](), list[int](), any(self.free)
        for j in range(len(self.family.names)):
            c = max((powers[j] for powers, share, _ in self.terms if share), default=0)
            moves, sees = (
                max((powers[j] for powers, _, own in self.terms if own[k].any() or own[k + 1].any()), default=0)
                for k in (0, 2)
            )
            once = 2 * moves if self.discrete else c + moves
            found.append(max(once + 1, 2 * sees, 2 * c + 1, moves + sees if turned else 0))
            below.append(found[-1] if self.family.rates else max(2 * c + 1, 2 * sees if turned else 0))
        return found, below

    def solved(self, box: Box, ends: Reals, gain: float | None = None) -> Found | None:
        """What serves on a box with the largest margin; None if nothing was found, or the programme is too large.

        Parameters
        ----------
        box : tuple of (Fraction, Fraction)
            Where the parameters are.
        ends : ndarray
            (m, 2) bounds of the classes; of ``w`` and ``z`` they do not matter.
        gain : float, optional
            The gain from ``w`` to ``z``; without one the least is looked for.
        """
        checkpoint()
        n, own = self.family.order, self.performance or range(0)
        functions = [block for block in self.blocks if block != self.performance]
        state, degrees = symmetric_basis(n), self.degrees()[0]
        whole_box = any(low < high for low, high in box)
        degrees = degrees if whole_box else [0] * len(box)
        q, k, order = len(state) * (1 + len(box) * whole_box), len(functions), n + len(ends)
        total = q + 3 * k + 2  # P, lambda, theta, its bounds, the square of the gain, the margin
        if total * prod(d + 1 for d in degrees) * order**2 > _LARGEST:
            return None
        units = self._units(box, ends)
        scaled = ends / np.maximum(np.abs(ends).max(axis=1), 1e-300)[:, None]
        falls, above = self._coefficients(box, (units, scaled), (functions, state, degrees))
        falls = self._drifting(box, (falls, above), len(state), units.time)
        moves = np.concatenate([falls[:, :-1], np.tile(-np.eye(order), (len(falls), 1, 1, 1))], axis=1)
        whole = np.zeros((len(above), total, n, n))
        whole[:, :q], whole[:, q + 2 * k : q + 3 * k], whole[:, -1] = above[:, :q], above[:, q:], -np.eye(n)
        below = np.zeros((1, total, n, n))  # in the middle, so that it is at most twice as much at a vertex
        below[0, :q] = -np.concatenate([state, *[state / 2] * (q // len(state) - 1)])
        parts = [(falls[:, -1], moves), (np.zeros((len(above), n, n)), whole), (_MOST * np.eye(n)[None], below)]
        limits = Limits(total)
        for i in (i for j in self.jumping * whole_box for i in range(len(state) * (1 + j), len(state) * (2 + j))):
            for sign in (1.0, -1.0):
                limits.at_most({i: sign}, 0.0)
        for i, block in enumerate(functions):
            weight, turn, least = q + i, q + k + i, q + 2 * k + i
            limits.at_most({weight: -1.0}, 0.0)
            limits.at_most({weight: 1.0}, _MOST)
            for sign in (1.0, -1.0):
                limits.at_most({turn: sign}, _MOST if self.free[block[0]] and (sign > 0 or not self.rate) else 0.0)
            for end in scaled[block[0]]:
                limits.at_most({least: 1.0, turn: -float(end)}, 0.0)
        cost, square = np.zeros(total), 1.0
        if own:
            square = float(units.seen[own[0]] / units.force[own[0]]) ** 2  # of the gain, for 1 in these units
        if own and gain is None:
            cost[-2] = -1.0
            limits.at_most({total - 1: 1.0}, _SLACK)
            limits.at_most({total - 1: -1.0}, -_SLACK)
        else:
            cost[-1] = 1.0
            limits.at_most({total - 1: 1.0}, 1.0)
            level = 0.0 if gain is None else gain**2 / square
            limits.at_most({total - 2: 1.0}, level)
            limits.at_most({total - 2: -1.0}, -level)
        chosen = self.needed.setdefault(tuple(len(one) for one, _ in parts), [set() for _ in parts])
        sure = _SURE if cost[-1] else -inf
        found = in_stages(cost, parts, limits, chosen, sure)
        if found is None or not found[-1] > sure:
            return None
        return self._restored(found, units, (functions, state), square)

    def _drifting(self, box: Box, sides: tuple[Reals, Reals], k: int, time: float) -> Reals:
        """``falls`` for the extremes of ``P'`` of parameters that change with bounded rates, in continuous time."""
        falls, above = sides
        pairs = enumerate(zip(self.family.rates, box, strict=False))
        shares = {
            j: float(r / (high - low)) / time for j, (r, (low, high)) in pairs if 0 < r < inf and not self.discrete
        }
        found, n = list[Reals](), above.shape[-1]
        for signs in product((1.0, -1.0), repeat=len(shares)):
            one = falls.copy()
            for sign, (j, share) in zip(signs, shares.items(), strict=True):
                one[:, (1 + j) * k : (2 + j) * k, :n, :n] -= sign * share * above[:, :k]
            found.append(one)
        return np.concatenate(found)

    def widest(self, box: Box) -> int:
        """The parameter that changes the plants most over a box, constant ones first.

        ``box``: where the parameters are.
        """
        middle = [float(low + high) / 2 for low, high in box]
        units = self._units(box, np.tile([0.0, 1.0], (len(self.family.pattern), 1)))
        changes = list[float]()
        for j, pair in enumerate(box):
            common, sides = self.at(np.array([[*middle[:j], float(end), *middle[j + 1 :]] for end in pair]))
            (A, A1), (B, B1), (C, C1), (D, D1) = (side / common[:, None, None] for side in sides)
            state, seen = units.state, units.seen
            parts = [(A1 - A) / state[:, None] * state / units.time, (B1 - B) / state[:, None] * seen / units.time]
            parts += [(C1 - C) * state / seen[:, None], D1 - D]
            fixed = not any(self.family.rates[len(changes) : len(changes) + 1])
            changes.append(float(sum(np.linalg.norm(part) for part in parts)) if fixed else -1.0)
        return max(range(len(box)), key=changes.__getitem__)

    def _restored(self, found: Reals, units: _Units, over: tuple[list[range], Reals], square: float) -> Found:
        """What was found, in the units of the plant."""
        functions, state = over
        k = len(functions)
        parts = found[: -3 * k - 2].reshape(-1, len(state)).copy()
        if len(parts) > 1:
            parts[[1 + j for j in self.jumping]] = 0.0
        q, P = parts.size, np.einsum("kq,qij->kij", parts, state) / units.state[:, None] / units.state[None, :]
        weights, theta, gain = np.zeros(len(units.seen)), np.zeros(len(units.seen)), 0.0
        for i, block in enumerate(functions):
            for j in block:
                weights[j] = max(found[q + i], 0.0) * units.time / units.force[j] ** 2
                theta[j] = self.free[j] * found[q + k + i] / (units.force[j] * units.seen[j])
        for j in self.performance or ():
            weights[j] = units.time * max(found[-2], 0.0) / units.force[j] ** 2 / 2
            gain = float(np.sqrt(max(found[-2], 0.0) * square))
        return Found(P, weights, theta, gain)

    def _units(self, box: Box, ends: Reals) -> _Units:
        """Those in which the plant in the middle has matrices of about the size 1."""
        common, sides = self.at(np.array([[float(low + high) / 2 for low, high in box]]))
        A, B, C, D = (side[0] / common for side in sides)
        functions = [i for block in self.blocks if block != self.performance for i in block]
        lower = np.zeros(len(D))
        lower[functions] = ends[functions, 0]
        gain = np.diag(lower)
        closed = A - B @ gain @ np.linalg.solve(np.eye(len(D)) + D @ gain, C)
        _, state = balanced(closed)
        time = 1.0 if self.discrete else float(np.abs(np.linalg.eigvals(closed)).max()) or 1.0
        size = np.linalg.norm(C * state, axis=1)
        seen = np.where(size > 0, size, 1.0)
        force = np.abs(ends).max(axis=1) * seen
        for j in self.performance or ():
            into = float(np.linalg.norm(B[:, list(self.performance or ())] / state[:, None])) / time
            through = float(np.linalg.norm(D[functions][:, list(self.performance or ())]))
            seen[j] = float(np.linalg.norm(size[list(self.performance or ())])) or float(np.linalg.norm(D)) or 1.0
            force[j] = 1.0 / (into or through or 1.0)
        return _Units(np.asarray(state), seen, np.where(force > 0, force, 1.0), time)

    def _coefficients(
        self, box: Box, sizes: tuple[_Units, Reals], over: tuple[list[range], Reals, list[int]]
    ) -> tuple[Reals, Reals]:
        """Bernstein coefficients: (nodes, slopes of the unknowns and what is constant, N, N), and those of ``V``.

        Those of ``V`` are of its own degrees: raised to the others, as the checkers take them, they are means of these.
        """
        (units, ends), (functions, state, degrees) = sizes, over
        low, width = (np.array([float(v) for v in side]) for side in zip(*((a, b - a) for a, b in box), strict=True))
        found = list[Reals]()
        for part, own in enumerate((degrees, [min(d, e) for d, e in zip(degrees, self.degrees()[1], strict=True)])):
            shape = [d + 1 for d in own]
            t = np.stack(np.meshgrid(*(np.arange(d + 1) / max(d, 1) for d in own), indexing="ij"), -1)
            t = t.reshape(-1, len(own))
            values = self._nodes(low + width * t, units, ends, functions, state)[part]
            if any(own):
                shares = np.hstack([np.ones((len(t), 1)), t])
                spread = np.einsum("nj,nqab->njqab", shares, values[:, : len(state)])
                spread = spread.reshape(len(t), -1, *values.shape[2:])
                values = np.concatenate([spread, values[:, len(state) :]], axis=1)
            whole = values.reshape(*shape, *values.shape[1:])
            for axis, d in enumerate(own):
                if d:
                    r = np.arange(d + 1)[:, None] / d
                    basis = np.hstack([comb(d, i) * r**i * (1 - r) ** (d - i) for i in range(d + 1)])
                    whole = np.moveaxis(np.tensordot(np.linalg.inv(basis), whole, (1, axis)), 0, axis)
            found.append(whole.reshape(-1, *whole.shape[-3:]))
        return found[0], found[1]

    def _growing(self, psi: Reals, sigma: Reals, j: int, width: float, units: _Units) -> Reals:
        """Half of what a rate adds to ``V'`` for ``theta_j = 1``: ``a psi (sigma - psi/w)``, or of a sector."""
        if not self.rate or not self.free[j]:
            return np.zeros((*psi.shape, psi.shape[-1]))
        a, rest = abs(self.rate) / units.time, sigma - psi / width
        first = psi if self.sloped[j] or self.rate < 0 else width * sigma
        return a * _outer(first, rest if self.sloped[j] or self.rate > 0 else sigma)

    def _nodes(
        self, points: Reals, units: _Units, ends: Reals, functions: Sequence[range], state: Reals
    ) -> tuple[Reals, Reals]:
        """The same at plants, one a row, times the square of the common denominator over that in the middle."""
        c0, _ = self.at(np.array([[float(low + high) / 2 for low, high in self.family.box]]))
        (c, sides), (n, m) = self.at(points), self.terms[0][2][1].shape
        c, (A, B, C, D) = (c / c0)[:, None, None], (side / c0 for side in sides)
        A, B = A / units.state[:, None] * units.state / units.time, B / units.state[:, None] * units.force / units.time
        C, D = C * units.state / units.seen[:, None], D * units.force / units.seen[:, None]
        left, right = np.hstack([np.eye(n), np.zeros((n, m))]), np.hstack([np.zeros((m, n)), np.eye(m)])
        R, S = np.concatenate([A, -B], axis=2), np.concatenate([C, -D], axis=2)
        slopes = np.zeros((len(points), len(state) + 3 * len(functions) + 2, n + m, n + m))
        keep, q, k = left.T @ state @ left, len(state), len(functions)
        if self.discrete:
            moved = R.swapaxes(1, 2)[:, None] @ state @ R[:, None]
            slopes[:, :q] = (c**2)[:, None] * keep - moved
        else:
            moves = c[:, None] * (left.T @ state @ R[:, None])
            slopes[:, :q] = -(moves + moves.swapaxes(2, 3))
        above = np.concatenate([c[:, None] ** 2 * state, np.zeros((len(points), k, n, n))], axis=1)
        for i, block in enumerate(functions):
            X, Y = np.zeros((2, len(points), n + m, n + m))
            for j in block:
                low, high = ends[j]
                psi, width = c[:, 0] * right[j] - low * S[:, j], high - low
                X = X - _outer(psi, high * S[:, j] - c[:, 0] * right[j])
                Y = Y - _outer(np.broadcast_to(right[j], psi.shape), (C[:, j : j + 1] @ R)[:, 0])
                Y = Y - self._growing(psi, S[:, j], j, width, units)
            slopes[:, q + i] = X + X.swapaxes(1, 2)
            slopes[:, q + k + i] = (Y + Y.swapaxes(1, 2)) * float(self.free[block[0]])
            above[:, q + i] = _outer(C[:, block[0]], C[:, block[0]])
        for j in self.performance or ():
            slopes[:, -2] += c**2 * np.outer(right[j], right[j])
            slopes[:, -1] -= _outer(S[:, j], S[:, j])
        return slopes, above


def _outer(x: Reals, y: Reals) -> Reals:
    """Products of each pair of rows."""
    return np.asarray(x[..., :, None] * y[..., None, :])
