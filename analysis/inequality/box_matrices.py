r"""Plants of several channels with parameters in a box, in floating point: one ``P`` and one multiplier for a box.

Sought are ``P``, ``lambda_i`` and ``theta_i`` such that the Bernstein coefficients, on a box, of the matrix of ``-V'``
less the forms of the classes, ``V = x'P x + 2 sum theta_i int phi_i``, are positive definite, times the square of the
common denominator.  All are linear in the unknowns, the square of the gain from ``w`` to ``z`` too: one semidefinite
programme.  Nothing here is believed: a checker decides with rational numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from math import comb, inf, prod
from typing import Any, NamedTuple

from lure.analysis.deadline import checkpoint
from lure.analysis.numerics.semidefinite import Block, Limits, proposed, symmetric_basis
from lure.arrays import Reals, balanced, np
from lure.plants.channel_family import ChannelFamily
from lure.plants.parameters import Box

_LARGEST, _SURE, _MOST, _BITS = 4e7, 1e-8, 1e5, 48
_SLACK = 1e-8  # of the least square of a gain, in units of the plant


class Found(NamedTuple):
    """``P_0, P_1, ...``, ``lambda``, ``theta`` and the gain from ``w`` to ``z``, in the units of the plant."""

    P: Reals
    weights: Reals
    theta: Reals
    gain: float

    def entry(self, *, popov: bool) -> dict[str, Any]:
        """As they stand in a certificate.

        Parameters
        ----------
        popov : bool
            Whether the theorem has ``theta``.
        """
        smallest = float(np.abs(np.diag(self.P[0])).min())
        exponent = max(0, _BITS - int(np.floor(np.log2(max(smallest, 1e-300)))))
        rows = [
            [[str(round(Fraction(float(Q[i, j])) * 2**exponent)) for j in range(i + 1)] for i in range(len(Q))]
            for Q in self.P
        ]
        found = {"lambda": [str(Fraction(f"{max(v, 0.0):.12g}")) for v in self.weights], "P": rows}
        turned = {"theta": [str(Fraction(f"{v:.12g}")) for v in self.theta]} if popov else {}
        return {**found, **turned, "exponent": exponent}


class _Units(NamedTuple):
    """Of each state, of each ``sigma`` and ``mu``, and of time [1/s]."""

    state: Reals
    seen: Reals
    force: Reals
    time: float


@dataclass
class BoxMatrices:
    """The programme for some plants and classes.

    Parameters
    ----------
    family : ChannelFamily
        The plants; from ``w`` to ``z`` are the last channels.
    blocks : sequence of range
        The channels that have one weight: each alone, but those of an operator.
    performance : range or None
        The channels from ``w`` to ``z``.
    free : sequence of bool
        Which ``theta`` may differ from 0.
    rate : float
        In continuous time the plants are those of the solutions times ``e^(rate t)``; then ``theta >= 0``.
    sloped : sequence of bool
        With a rate: in which channels the slopes are in the bounds of the sector.
    """

    family: ChannelFamily
    blocks: Sequence[range]
    performance: range | None
    free: Sequence[bool]
    rate: float = 0.0
    sloped: Sequence[bool] = ()

    def __post_init__(self) -> None:
        self.terms = [
            (one.powers, float(one.common), [np.array([[float(v) for v in row] for row in side]) for side in one.sides])
            for one in self.family.terms
        ]
        self.discrete = self.family.dt is not None
        rates = enumerate(self.family.rates)
        self.jumping = [j for j, rate in rates if rate and (rate == inf or self.discrete)]  # P does not depend on these

    def at(self, point: Sequence[float]) -> tuple[float, list[Reals]]:
        """The common denominator, and ``A``, ``B``, ``C``, ``D`` times it.

        Parameters
        ----------
        point : sequence of float
            The parameters.
        """
        shares = [prod(v**e for v, e in zip(point, powers, strict=True)) for powers, *_ in self.terms]
        common = sum(w * c for w, (_, c, _) in zip(shares, self.terms, strict=True))
        return common, [sum(w * one[2][k] for w, one in zip(shares, self.terms, strict=True)) for k in range(4)]  # type: ignore[misc]

    def degrees(self) -> list[int]:
        """Of the matrix in each parameter; see the checker, which counts them likewise."""
        found, turned = list[int](), any(self.free)
        for j in range(len(self.family.names)):
            c = max((powers[j] for powers, share, _ in self.terms if share), default=0)
            moves, sees = (
                max((powers[j] for powers, _, own in self.terms if own[k].any() or own[k + 1].any()), default=0)
                for k in (0, 2)
            )
            once = 2 * moves if self.discrete else c + moves
            found.append(max(once + 1, 2 * sees, 2 * c + 1, moves + sees if turned else 0))
        return found

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
        state, degrees = symmetric_basis(n), self.degrees()
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
        blocks = [Block(one[-1], np.concatenate([one[:-1], -np.eye(order)[None]])) for one in falls]
        for one in above:
            whole = np.zeros((total, n, n))
            whole[:q], whole[q + 2 * k : q + 3 * k], whole[-1] = one[:q], one[q:], -np.eye(n)
            blocks.append(Block(np.zeros((n, n)), whole))
            below = np.zeros((total, n, n))
            below[:q] = -one[:q]
            blocks.append(Block(_MOST * np.eye(n), below))
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
        found = proposed(cost, blocks, *limits.arrays())
        if found is None or (cost[-1] and not found[-1] > _SURE):
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

        Parameters
        ----------
        box : tuple of (Fraction, Fraction)
            Where the parameters are.
        """
        middle = [float(low + high) / 2 for low, high in box]
        units = self._units(box, np.tile([0.0, 1.0], (len(self.family.pattern), 1)))
        changes = list[float]()
        for j, pair in enumerate(box):
            ends = [self.at([*middle[:j], float(end), *middle[j + 1 :]]) for end in pair]
            (A, B, C, D), (A1, B1, C1, D1) = ([side / c for side in sides] for c, sides in ends)
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
        common, sides = self.at([float(low + high) / 2 for low, high in box])
        A, B, C, D = (side / common for side in sides)
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
        """Bernstein coefficients: (nodes, slopes of the unknowns and what is constant, N, N), and those of ``V``."""
        (units, ends), (functions, state, degrees) = sizes, over
        shape = [d + 1 for d in degrees]
        falls: dict[tuple[int, ...], Reals] = {}
        above: dict[tuple[int, ...], Reals] = {}
        for node in product(*map(range, shape)):
            point = [
                float(low) + float(high - low) * i / max(d, 1)
                for (low, high), i, d in zip(box, node, degrees, strict=True)
            ]
            t = np.array([1.0, *(i / d for i, d in zip(node, degrees, strict=True) if d)])
            falls[node], above[node] = self._node(point, units, ends, functions, state)
            for values in (falls, above):
                own, rest = np.split(values[node], [len(state)])
                spread = (t[:, None, None, None] * own).reshape(-1, *own.shape[1:])
                values[node] = np.concatenate([spread, rest])
        found = list[Reals]()
        for values in (falls, above):
            whole = np.array([values[node] for node in product(*map(range, shape))])
            whole = whole.reshape(*shape, *whole.shape[1:])
            for axis, d in enumerate(degrees):
                if not d:
                    continue
                basis = [
                    [comb(d, i) * (r / d) ** i * (1 - r / d) ** (d - i) for i in range(d + 1)] for r in range(d + 1)
                ]
                whole = np.moveaxis(np.tensordot(np.linalg.inv(np.array(basis)), whole, (1, axis)), 0, axis)
            found.append(whole.reshape(-1, *whole.shape[-3:]))
        return found[0], found[1]

    def _growing(self, psi: Reals, sigma: Reals, j: int, width: float, units: _Units) -> Reals:
        """Half of what a rate adds to ``V'`` for ``theta_j = 1``: ``a psi (sigma - psi/w)``, or of a sector."""
        if not self.rate or not self.free[j]:
            return np.zeros((len(psi), len(psi)))
        a, rest = abs(self.rate) / units.time, sigma - psi / width
        first = psi if self.sloped[j] or self.rate < 0 else width * sigma
        return np.asarray(a * np.outer(first, rest if self.sloped[j] or self.rate > 0 else sigma))

    def _node(
        self, point: Sequence[float], units: _Units, ends: Reals, functions: Sequence[range], state: Reals
    ) -> tuple[Reals, Reals]:
        """The same at a plant, times the square of the common denominator over that in the middle."""
        c, (A, B, C, D) = self.at(point)
        c0, _ = self.at([float(low + high) / 2 for low, high in self.family.box])
        c, A, B, C, D = c / c0, A / c0, B / c0, C / c0, D / c0
        n, m = len(A), len(D)
        A, B = A / units.state[:, None] * units.state / units.time, B / units.state[:, None] * units.force / units.time
        C, D = C * units.state / units.seen[:, None], D * units.force / units.seen[:, None]
        left, right = np.hstack([np.eye(n), np.zeros((n, m))]), np.hstack([np.zeros((m, n)), np.eye(m)])
        R, S = np.hstack([A, -B]), np.hstack([C, -D])
        keep = left.T @ state @ left
        if self.discrete:
            first = c**2 * keep - R.T @ state @ R
        else:
            moves = c * (left.T @ state @ R)
            first = -(moves + moves.swapaxes(1, 2))
        weights, turns, least = list[Reals](), list[Reals](), list[Reals]()
        for block in functions:
            X, Y = np.zeros((n + m, n + m)), np.zeros((n + m, n + m))
            for j in block:
                low, high = ends[j]
                X -= np.outer(c * right[j] - low * S[j], high * S[j] - c * right[j])
                Y -= np.outer(right[j], C[j] @ R) + self._growing(c * right[j] - low * S[j], S[j], j, high - low, units)
            weights.append(X + X.T)
            turns.append((Y + Y.T) * float(self.free[block[0]]))
            least.append(C[block[0]][:, None] * C[block[0]])
        bounds = np.zeros((len(functions), n + m, n + m))
        square, constant = np.zeros((n + m, n + m)), np.zeros((n + m, n + m))
        for j in self.performance or ():
            square += c**2 * np.outer(right[j], right[j])
            constant -= np.outer(S[j], S[j])
        slopes = [first, np.array(weights).reshape(-1, n + m, n + m), np.array(turns).reshape(-1, n + m, n + m), bounds]
        whole = np.concatenate([*slopes, square[None], constant[None]])
        return whole, np.concatenate([c**2 * state, np.array(least).reshape(-1, n, n)])
