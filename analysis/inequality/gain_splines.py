r"""Nonlinearities beside unknown gains, constant or slow, in floating point: a Lyapunov matrix that depends on them.

``mu_i = -g_i sigma_i`` with ``g`` in a box and ``|g_i'| <= r_i``.  Sought are a continuous spline ``P(g)``, a number
``lambda_i >= 0`` for each other channel on each box of the spline, and ``theta_i``, such that Bernstein's coefficients
of the matrix of ``-V'`` less the forms of the other channels, ``V = x'P(g) x + 2 sum theta_i int phi_i``, are positive
definite on each box for ``g_i' = +-r_i``; in discrete time those of ``V(x, g) - V(x+, g+)`` for each box that ``g+``
can reach (Gahinet, Apkarian and Chilali 1996 with ``P`` affine and one box).  All of them are linear in the unknowns:
one semidefinite programme.  Nothing here is believed: a checker decides with rational ``P``, ``lambda`` and ``theta``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import field
from fractions import Fraction
from itertools import product
from math import comb, prod
from typing import ClassVar, NamedTuple

from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.shifted_loop import ChannelSearch, Proposal
from lure.analysis.numerics.doubles import decimals, places, triangle, triangle_texts
from lure.analysis.numerics.semidefinite import Limits, in_stages, symmetric_basis
from lure.arrays import NDArray, Reals, balanced, np
from lure.record import described, quantity

SPLINES = {1: ((1, 1), (2, 4), (3, 16)), 2: ((1, 1), (2, 1), (2, 2)), 3: ((1, 1), (2, 1))}
"""For each number of gains the degrees of the splines that are tried, and how many pieces each interval has."""
_LARGEST_PROGRAMME = 1e6  # entries of its matrices
_SURE, _MOST, _BITS = 1e-6, 1e4, 44


class _Found(NamedTuple):
    """``P`` for each coefficient, ``lambda`` for each box, ``theta``: in the units of the plant."""

    P: Reals
    weights: Reals
    theta: Reals


@described()
class GainSplines(ChannelSearch):
    """The search for one plant, lower bounds and kind of spline; the others: see :class:`ChannelSearch`."""

    gains: Sequence[range] = quantity("The channels of each unknown gain; ``D`` has no entry between two of them")
    rates: Sequence[float] = quantity("Of each gain, 0 for constant ones")
    free: Sequence[bool] = quantity("Which ``theta`` may differ from 0")
    discrete: bool = quantity("Whether in discrete time")
    degree: int = quantity("Degree of the spline in each gain")
    pieces: int = quantity("Pieces of the spline in each gain")
    known: dict[tuple[float, ...], tuple[float, _Found | None]] = field(default_factory=dict, repr=False)
    needed: dict[tuple[int, ...], list[set[int]]] = field(default_factory=dict, repr=False)

    precision: ClassVar[float] = 1e-4

    def __post_init__(self) -> None:
        inside = [i for block in self.gains for i in block]
        self.others = [i for i in range(len(self.D)) if i not in inside]
        p = len(self.gains)
        self.boxes = [*product(range(self.pieces), repeat=p)]
        self.indices = {k: i for i, k in enumerate(product(range(self.degree * self.pieces + 1), repeat=p))}

    def serves(self, widths: NDArray[np.float64]) -> bool:
        """Whether the programme finds a spline; see :class:`ChannelSearch`."""
        return self.margin(widths) > 0

    def margin(self, widths: NDArray[np.float64]) -> float:
        """What a spline leaves to spare beyond rounding, not positive if there is none; see :class:`ChannelSearch`."""
        key = tuple(float(w) for w in widths)
        if key not in self.known:
            checkpoint()
            self.known[key] = self._programme(widths)
        return self.known[key][0]

    def proposals(self, widths: Sequence[Fraction], lower: Sequence[Fraction]) -> Iterator[Proposal]:
        """The spline, rounded; see :class:`ChannelSearch`."""
        at = np.array([float(w) for w in widths])
        if not self.serves(at):
            return
        found = self.known[tuple(float(w) for w in at)][1]
        assert found is not None, "as it serves"
        smallest = float(np.abs(found.P[:, range(len(self.A)), range(len(self.A))]).min())
        exponent = places(smallest, _BITS)
        whole = [triangle_texts(triangle(Q, exponent)) for Q in found.P]
        proof = {"method": "spline", "degree": self.degree, "pieces": [self.pieces] * len(self.gains), "P": whole}
        weights = [[*map(str, decimals(max(v, 0.0) for v in line))] for line in found.weights]
        theta = [*map(str, decimals(found.theta))]
        yield Proposal({"lambda": weights, "theta": theta}, {**proof, "exponent": exponent})

    def _programme(self, widths: NDArray[np.float64]) -> tuple[float, _Found | None]:
        """The margin, and a spline where it is positive; ``-inf`` if the programme is too large, or has no answer."""
        n, k, d, p = len(self.A), len(self.others), self.degree, len(self.gains)
        state = symmetric_basis(n)
        q, order = len(state), n + k
        starts = np.cumsum([0, len(self.indices) * q, len(self.boxes) * k, k, k])  # P, lambda, theta, its bounds, t
        total = int(starts[-1]) + 1
        plant, units = self._scaled(widths)
        if self.discrete:
            pairs = sum(len(self._reached(plant, place)) for place in self.boxes)
            count = pairs * ((d + 2) * (d + 1)) ** p
        else:
            count = len(self.boxes) * (d + 2) ** p * 2**p
        if total * (count + 2 * len(self.indices)) * order**2 > _LARGEST_PROGRAMME:
            return -math.inf, None
        falls = list[Reals]()
        for box in range(len(self.boxes)):
            for local, slopes in self._falls(plant, box, starts):
                moved = np.zeros((len(slopes), total, order, order))
                for whole, one in zip(moved, slopes, strict=True):
                    np.add.at(whole, local, one)
                moved[:, -1] -= np.eye(order)
                falls.append(moved)
        own, size = plant.C[self.others], len(self.indices)
        whole = np.zeros((size, total, n, n))
        for index in range(size):
            whole[index, index * q : (index + 1) * q] = state
        below = -whole
        whole[:, starts[3] : starts[4]] = np.einsum("ki,kj->kij", own, own)
        whole[:, -1] = -np.eye(n)
        parts = [(np.zeros((size, n, n)), whole), (np.tile(np.eye(n), (size, 1, 1)), below)]
        parts.append((np.zeros((sum(map(len, falls)), order, order)), np.concatenate(falls)))
        limits = Limits(total)
        limits.at_most({total - 1: 1.0}, 1.0)
        for i in range(starts[1], starts[2]):
            limits.at_most({i: -1.0}, 0.0)
            limits.at_most({i: 1.0}, _MOST)
        for i, channel in enumerate(self.others):
            turn, least = int(starts[2]) + i, int(starts[3]) + i
            for sign in (1.0, -1.0):
                limits.at_most({turn: sign}, _MOST if self.free[channel] else 0.0)
            for end in plant.ends[channel]:
                limits.at_most({least: 1.0, turn: -float(end)}, 0.0)
        cost = np.zeros(total)
        cost[-1] = 1.0
        chosen = self.needed.setdefault(
            tuple(len(one) for one, _ in parts), [set(range(size)), set(range(size)), set()]
        )
        found = in_stages(cost, parts, limits, chosen, _SURE)
        if found is None or not found[-1] > _SURE:
            return (-math.inf if found is None else float(found[-1]) - _SURE), None
        P = np.einsum("kq,qij->kij", found[: starts[1]].reshape(-1, q), state)
        P = P / units.state[:, None] / units.state[None, :]
        weights = found[starts[1] : starts[2]].reshape(len(self.boxes), k) * units.time / units.force[self.others] ** 2
        free = np.array([self.free[i] for i in self.others], dtype=float)
        return float(found[-1]) - _SURE, _Found(
            P, weights, free * found[starts[2] : starts[3]] / units.force[self.others]
        )

    def _scaled(self, widths: NDArray[np.float64]) -> tuple[_Plant, _Units]:
        """The loop in units in which its matrices are of the size 1."""
        lower, upper = self.lower, self.lower + widths
        force = np.maximum(np.abs(lower), np.abs(upper))
        middle = np.zeros(len(lower))
        middle[[i for block in self.gains for i in block]] = 1
        middle = np.diag(middle * (lower + upper) / 2)
        closed = self.A - self.B @ middle @ self.C
        _, state = balanced(closed)
        time = 1.0 if self.discrete else float(np.abs(np.linalg.eigvals(closed)).max()) or 1.0
        A, B = self.A / state[:, None] * state, self.B * force / state[:, None]
        ends = np.stack([lower / force, upper / force], axis=1)
        rates = [rate / time / force[block[0]] for rate, block in zip(self.rates, self.gains, strict=True)]
        return _Plant(A / time, B / time, self.C * state, self.D * force, ends, rates), _Units(state, force, time)

    def _falls(self, plant: _Plant, box: int, starts: Reals) -> Iterator[tuple[NDArray[np.int_], Reals]]:
        """Bernstein's coefficients on a box: the unknowns in them, and the slopes of each, (.., unknowns, N, N)."""
        n, k, d, p = len(self.A), len(self.others), self.degree, len(self.gains)
        place = self.boxes[box]
        q = n * (n + 1) // 2
        moving = [j for j in range(p) if plant.rates[j] > 0]
        rest = [*range(starts[1] + box * k, starts[1] + (box + 1) * k), *range(starts[2], starts[3])]
        for after in self._reached(plant, place):
            if self.discrete:
                degrees = [max(d, 2) if j in moving else d + 2 for j in range(p)] + [d] * len(moving)
            else:
                degrees = [max(d + 1, 2)] * p
            coefficients = [self._local(one, q) for one in dict.fromkeys((place, after))]
            local = np.concatenate([*coefficients, np.array(rest, dtype=int)])
            signs = [()] if self.discrete else [*product((1.0, -1.0), repeat=len(moving))]
            values = np.zeros((len(signs), *(D + 1 for D in degrees), len(local), n + k, n + k))
            for node in product(*(range(D + 1) for D in degrees)):
                at = [i / D for i, D in zip(node, degrees, strict=True)]
                now, later = at[:p], at[:p]
                for j, s in zip(moving, at[p:] if self.discrete else [], strict=False):
                    later[j] = s
                for which, sign in enumerate(signs):
                    speeds = dict(zip(moving, sign, strict=False))
                    values[(which, *node)] = self._at(plant, (place, after), (now, later), speeds)
            for axis, D in enumerate(degrees, 1):
                back = np.linalg.inv(np.array([_bernstein(D, i / D) for i in range(D + 1)]))
                values = np.moveaxis(np.tensordot(back, values, (1, axis)), 0, axis)
            yield local, values.reshape(-1, *values.shape[-3:])

    def _reached(self, plant: _Plant, place: tuple[int, ...]) -> list[tuple[int, ...]]:
        """The boxes in which the gains may be after a step; in continuous time this one."""
        if not self.discrete:
            return [place]
        near = list[list[int]]()
        for j, k in enumerate(place):
            low, high = plant.ends[self.gains[j][0]]
            steps = plant.rates[j] / ((high - low) / self.pieces)
            near.append([h for h in range(self.pieces) if abs(h - k) - 1 <= steps * (1 + 1e-9) and (steps or h == k)])
        return [*product(*near)]

    def _local(self, place: tuple[int, ...], q: int) -> NDArray[np.int_]:
        """The unknowns of ``P`` on a box."""
        found = [
            self.indices[tuple(self.degree * k + i for k, i in zip(place, index, strict=True))] * q
            for index in product(range(self.degree + 1), repeat=len(place))
        ]
        return (np.array(found)[:, None] + np.arange(q)).ravel()

    def _at(
        self,
        plant: _Plant,
        boxes: tuple[tuple[int, ...], tuple[int, ...]],
        at: tuple[Sequence[float], Sequence[float]],
        speeds: dict[int, float],
    ) -> Reals:
        """The slopes of the matrix at one place: for the coefficients of ``P``, then ``lambda``, then ``theta``."""
        n, d, p = len(self.A), self.degree, len(self.gains)
        g, widths = np.zeros(len(self.D)), np.zeros(p)
        for j, block in enumerate(self.gains):
            low, high = plant.ends[block[0]]
            widths[j] = (high - low) / self.pieces
            g[list(block)] = low + widths[j] * (boxes[0][j] + at[0][j])
        R, sigma = self._closed(plant, g)
        state = symmetric_basis(n)
        first = np.hstack([np.eye(n), np.zeros((n, len(self.others)))])
        bases = [_bernstein(d, s) for s in at[0]]
        keep = first.T @ state @ first
        found = np.zeros((0, *keep.shape[1:]))
        if self.discrete:
            ahead = -(R.T @ state @ R)
            then = _weights([_bernstein(d, s) for s in at[1]])
            parts = [_weights(bases)[:, None, None, None] * keep, then[:, None, None, None] * ahead]
            found = np.concatenate(parts if boxes[0] != boxes[1] else [parts[0] + parts[1]]).reshape(
                -1, *keep.shape[1:]
            )
        else:
            moves = first.T @ state @ R
            moves = -(moves + moves.swapaxes(1, 2))
            shares = [(_weights(bases), moves)]
            for j, sign in speeds.items():
                turned = [*bases[:j], _slopes(d, at[0][j]), *bases[j + 1 :]]
                shares.append((_weights(turned) * (-sign * plant.rates[j] / widths[j]), keep))
            whole = sum((w[:, None, None, None] * X for w, X in shares), np.zeros(1))
            found = whole.reshape(-1, *keep.shape[1:])
        phi = np.hstack([np.zeros((len(self.others), n)), np.eye(len(self.others))])
        both = list[Reals]()
        for i, channel in enumerate(self.others):
            low, high = plant.ends[channel]
            both.append(np.outer(phi[i] - low * sigma[i], high * sigma[i] - phi[i]))
        both += [np.outer(phi[i], plant.C[channel] @ R) for i, channel in enumerate(self.others)]
        forms = np.array([-(X + X.T) for X in both]).reshape(-1, *keep.shape[1:])
        return np.concatenate([found, forms])

    def _closed(self, plant: _Plant, g: Reals) -> tuple[Reals, Reals]:
        """Rows of ``x'`` and of ``sigma`` of the other channels from ``(x, phi)``, with these gains."""
        seen = np.hstack([plant.C, -plant.D[:, self.others]])
        back = -(g[:, None] * seen)  # mu of the gains
        R = np.hstack([plant.A, -plant.B[:, self.others]]) + plant.B @ back
        return R, (seen + plant.D @ back)[self.others]


class _Plant(NamedTuple):
    """The plant, the ends of each channel, and the rates of the gains, in units of its own."""

    A: Reals
    B: Reals
    C: Reals
    D: Reals
    ends: Reals
    rates: list[float]


class _Units(NamedTuple):
    """Of each state, of each channel's input, and of time [1/s]."""

    state: Reals
    force: Reals
    time: float


def _bernstein(d: int, s: float) -> Reals:
    """Bernstein's polynomials of degree ``d`` at ``s``."""
    return np.array([comb(d, i) * s**i * (1 - s) ** (d - i) for i in range(d + 1)])


def _slopes(d: int, s: float) -> Reals:
    """Their derivatives."""
    lower = np.concatenate([[0.0], _bernstein(d - 1, s), [0.0]])
    return np.asarray(-d * np.diff(lower))


def _weights(bases: Sequence[Reals]) -> Reals:
    """All products of one number of each list, the last index first to change."""
    return np.array([prod(line) for line in product(*bases)])
