r"""Constant gains in a box, in floating point: at each frequency a direction in which the vertices of a box lie.

``p(s, G) = det(1 + G D) det(s - A + B G (1 + D G)^{-1} C)`` is affine in each gain, so that ``p(i omega, G)`` stays in
the convex hull of its values at the vertices; where several channels have one gain, of their means over the vertices
with equally many at the upper end (Bernstein's coefficients).  Where that holds 0 the box is split, along the gain that
moves ``p`` most.  A tree of boxes with directions is proposed; a checker decides with exact polynomials.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import product
from typing import Any, ClassVar

from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.gains import simplest_between
from lure.analysis.inequality.shifted_loop import ChannelSearch, Proposal
from lure.arrays import NDArray, Reals, np
from lure.record import described, quantity

MOST_STATES, MOST_CHANNELS = 24, 6
_LEAVES, _ALL_LEAVES, _GRID, _DEEPEST = 150, 500, 320, 40
_ABOUT = (-2.0, -1.2, -0.7, -0.3, 0.0, 0.3, 0.7, 1.2, 2.0)
_PARTS = 8  # of a step where the values turn fast
_ROOM = 1e-7  # of the half turn that the vertices may fill
_KEPT = 0.03  # cosine of the angle to the values up to which a direction is kept for the next frequency


@described()
class GainBox(ChannelSearch):
    """The search for one plant and lower bounds; the others: see :class:`ChannelSearch`."""

    blocks: tuple[range, ...] = quantity("The channels with one gain each")
    discrete: bool = quantity("Whether in discrete time")

    precision: ClassVar[float] = 1e-5

    def __post_init__(self) -> None:
        self.ends = np.array(list(product((0, 1), repeat=len(self.D))))
        counts = np.stack([self.ends[:, list(block)].sum(axis=1) for block in self.blocks], axis=1)
        self.counts, which = np.unique(counts, axis=0, return_inverse=True)
        self.groups, self.leaves = [np.flatnonzero(which.ravel() == k) for k in range(len(self.counts))], 0
        poles = self._poles(np.zeros(len(self.blocks)))
        size = np.abs(poles)[np.abs(poles) > 1e-9]
        low, high = (float(size.min()), float(size.max())) if size.size else (1.0, 1.0)
        points = np.concatenate([[0.0], np.geomspace(low / 1e3, high * 1e4, _GRID), _near(poles)])
        self.coarse = np.unique(points[points >= 0])
        self.omega = self.coarse

    def _poles(self, gains: Reals) -> NDArray[np.complex128]:
        """The eigenvalues with one gain for each block, in discrete time in ``s``, ``z = (1 + s)/(1 - s)``."""
        G = np.diag(gains[[j for j, block in enumerate(self.blocks) for _ in block]])
        closed = self.A - self.B @ G @ np.linalg.solve(np.eye(len(G)) + self.D @ G, self.C)
        poles = np.linalg.eigvals(closed).astype(complex)
        return np.asarray((poles - 1) / np.where(np.abs(poles + 1) < 1e-9, 1e-9, poles + 1) if self.discrete else poles)

    def values(self, gains: Reals, omega: Reals) -> NDArray[np.complex128]:
        """Bernstein's coefficients of ``p(i omega, G)``, up to a positive factor for each ``omega``: (.., frequencies).

        ``gains``: (vertices, m).
        """
        n, m = self.B.shape
        s = 1j * omega
        left, right = ((1 + s), (1 - s)) if self.discrete else (s, np.ones_like(s))
        table = np.zeros((len(gains), len(omega), n + m, n + m), dtype=complex)
        scale = (1 + np.abs(omega))[:, None, None]
        table[:, :, :n, :n] = (left[:, None, None] * np.eye(n) - right[:, None, None] * self.A) / scale
        table[:, :, :n, n:] = -right[:, None, None] * self.B / scale
        table[:, :, n:, :n] = (gains[:, :, None] * self.C)[:, None]
        table[:, :, n:, n:] = (np.eye(m) + gains[:, :, None] * self.D)[:, None]
        found = np.linalg.det(table)
        return np.array([found[group].mean(axis=0) for group in self.groups])

    def _vertices(self, low: Reals, high: Reals) -> Reals:
        of = [j for j, block in enumerate(self.blocks) for _ in block]
        return np.asarray(np.where(self.ends == 1, high[of], low[of]))

    def serves(self, widths: Reals) -> bool:
        """Whether a tree of boxes was found; see :class:`ChannelSearch`."""
        ends = (
            [Fraction(float(side[block[0]])) for block in self.blocks] for side in (self.lower, self.lower + widths)
        )
        return self.tree(*ends) is not None

    def proposals(self, widths: Sequence[Fraction], lower: Sequence[Fraction]) -> Iterator[Proposal]:
        """The tree of boxes, if one was found; see :class:`ChannelSearch`."""
        low = [lower[block[0]] for block in self.blocks]
        high = [a + widths[block[0]] for a, block in zip(low, self.blocks, strict=True)]
        self.leaves = 0
        tree = self.tree(low, high)
        if tree is not None:
            yield Proposal({}, {"method": "hull", "tree": tree})

    def tree(self, low: list[Fraction], high: list[Fraction]) -> dict[str, Any] | None:
        """The tree of a certificate for the box; None where a gain of it seems to have a root on the axis.

        ``low``, ``high``: ends of the gain of each block.
        """
        n, m = self.B.shape
        self.most = min(self.leaves + _LEAVES, _ALL_LEAVES)
        return self._node(low, high, 0) if n <= MOST_STATES and m <= MOST_CHANNELS else None

    def _node(self, low: list[Fraction], high: list[Fraction], depth: int) -> dict[str, Any] | None:
        checkpoint()
        self.leaves += 1
        if self.leaves > self.most or depth > _DEEPEST:
            return None
        ends = np.array([float(v) for v in low]), np.array([float(v) for v in high])
        vertices, poles = self._vertices(*ends), [self._poles(end) for end in (*ends, (ends[0] + ends[1]) / 2)]
        fine = np.concatenate([self.coarse, *map(_near, poles)])  # where p turns within the distance of its root
        self.omega = np.unique(fine[fine >= 0])
        values = self.values(vertices, self.omega)
        found = self._directions(vertices, values)
        if isinstance(found, dict):
            return found
        if max(p.real.max() for p in poles) >= 0:
            return None
        which = self._widest(values[:, found])
        at = simplest_between(low[which] + (high[which] - low[which]) / 3, high[which] - (high[which] - low[which]) / 3)
        first = self._node(low, [*high[:which], at, *high[which + 1 :]], depth + 1)
        second = None if first is None else self._node([*low[:which], at, *low[which + 1 :]], high, depth + 1)
        return None if second is None else {"split": [which, str(at)], "parts": [first, second]}

    def _widest(self, values: NDArray[np.complex128]) -> int:
        """The block whose gain moves the values most."""
        most, least = self.counts.max(axis=0), self.counts.min(axis=0)
        sides = [
            (values[self.counts[:, j] == most[j]], values[self.counts[:, j] == least[j]]) for j in range(len(most))
        ]
        return int(np.argmax([abs(upper.mean() - lower.mean()) for upper, lower in sides]))

    def _directions(self, vertices: Reals, values: NDArray[np.complex128]) -> dict[str, Any] | int:
        """A leaf: where the directions change, and they; or the number of a frequency at which there is none."""
        middle, spread = _arcs(values)
        if spread.max() >= np.pi * (1 - _ROOM):
            return int(spread.argmax())
        angles = np.angle(values)
        shared = _arcs(np.vstack([values[:, :-1], values[:, 1:]]))  # of neighbours
        omega, directions = list[float](), [float(middle[0])]
        for k in range(1, len(middle)):
            if _holds(directions[-1], angles[:, k]):
                continue
            if shared[1][k - 1] < np.pi * (1 - _ROOM):
                omega.append(float(self.omega[k - 1]))
                directions.append(float(shared[0][k - 1]))
                continue
            points = np.linspace(self.omega[k - 1], self.omega[k], _PARTS + 1)  # they turn fast
            inner = self.values(vertices, points)
            turns, wide = _arcs(np.vstack([inner[:, :-1], inner[:, 1:]]))
            if wide.max() >= np.pi * (1 - _ROOM):
                return k
            if omega and omega[-1] >= points[0]:
                omega.pop()
                directions.pop()
            omega += [float(v) for v in points[:-1]]
            directions += [float(v) for v in turns]
            if not _holds(directions[-1], angles[:, k]):
                omega.append(float(points[-1]))
                directions.append(float(middle[k]))
        exact = [str(Fraction(v)) for v in omega]
        if any(a >= b for a, b in zip([0.0, *omega], omega, strict=False)):
            return len(self.omega) - 1
        pairs = [[str(round(np.cos(a) * 2**20)), str(round(np.sin(a) * 2**20))] for a in directions]
        return {"omega": exact, "directions": pairs}


def _near(poles: NDArray[np.complex128]) -> Reals:
    """Frequencies about those of the poles, as far apart as these are from the axis."""
    near = poles[poles.imag >= 0]
    return np.asarray(near.imag[:, None] + np.abs(near.real)[:, None] * np.array(_ABOUT)).ravel()


def _holds(direction: float, angles: Reals) -> bool:
    """Whether a direction serves for these angles, with some room for what lies between."""
    return bool(np.cos(angles - direction).min() > _KEPT)


def _arcs(values: NDArray[np.complex128]) -> tuple[Reals, Reals]:
    """Middle and length of the shortest arc that holds all angles, for each column."""
    angles = np.sort(np.angle(values), axis=0)
    gaps = np.vstack([np.diff(angles, axis=0), angles[:1] + 2 * np.pi - angles[-1:]])
    at = gaps.argmax(axis=0)
    columns = np.arange(values.shape[1])
    spread = 2 * np.pi - gaps[at, columns]
    start = angles[(at + 1) % len(angles), columns]
    return start + spread / 2, spread
