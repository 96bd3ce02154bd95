"""Solutions that grow along a ray, of loops with ReLUs in some channels, in floating point.

As long as no ``sigma_i`` changes its sign a ReLU is a gain.  An eigenvector of that linear loop that has these signs,
its eigenvalue real and above 0 (in discrete time of some steps, above 1), is the beginning of a solution of the loop
with the ReLUs, which grows without bound.  Nothing here is believed: a checker decides.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import NamedTuple

from lure.analysis.deadline import checkpoint
from lure.arrays import NDArray, Reals, np
from lure.record import described, quantity

_ALL_PATTERNS, _DRAWN, _STARTS, _STEPS, _LONGEST, _SEED, _MEMBERS = 8, 256, 40, 300, 24, 20261122, 24
_CLEAR, _GROWS, _ZERO = 1e-8, 1e-7, 1e-12  # of the largest entry: a sign; beyond the edge: growth; and no entry


class Ray(NamedTuple):
    """Gains at each step, (N, m), the state at the first, and by what it is multiplied; in continuous time its rate."""

    gains: Reals
    state: Reals
    value: float


@described(frozen=True)
class ReluRays:
    """Rays of one loop."""

    A: NDArray[np.float64] = quantity("(n, n) [floating point]")
    B: NDArray[np.float64] = quantity("(n, m) [floating point]")
    C: NDArray[np.float64] = quantity("(m, n) [floating point]")
    D: NDArray[np.float64] = quantity("(m, m) [floating point]")
    lower: NDArray[np.float64] = quantity("(m,) lower bounds of the gains; those of a ReLU are its gains below 0")
    upper: NDArray[np.float64] = quantity("(m,) upper bounds of the gains; those of a ReLU are its gains above 0")
    rectified: Sequence[bool] = quantity("Which channels have a ReLU")
    blocks: Sequence[Sequence[int]] = quantity("The channels of each nonlinearity")
    discrete: bool = quantity("Whether in discrete time")

    def found(self) -> Iterator[Ray]:
        """Rays, those that keep their pattern before those of several steps."""
        rng, own = np.random.default_rng(_SEED), [i for i, one in enumerate(self.rectified) if one]
        for others in self._members(rng):
            checkpoint()
            patterns = np.array(list(product((0.0, 1.0), repeat=len(own)))) if len(own) <= _ALL_PATTERNS else None
            if patterns is None:
                patterns = np.round(rng.random((_DRAWN, len(own))))
            for pattern in patterns:
                gains = others.copy()
                gains[own] = np.where(pattern > 0, self.upper[own], self.lower[own])
                yield from self._rays(gains[None], own)
            if self.discrete:
                yield from self._cycles(others, own, rng)

    def _members(self, rng: np.random.Generator) -> Iterator[Reals]:
        """Constant gains of the other channels: their ends, then others."""
        free = [block for block in self.blocks if not self.rectified[block[0]]]
        ends = product((0.0, 1.0), repeat=len(free)) if len(free) <= 4 else ()
        shares = [*ends, *(rng.random((_MEMBERS, len(free))) if free else [])]
        for share in shares:
            gains = self.lower.copy()
            for part, block in zip(share, free, strict=True):
                gains[[*block]] += part * (self.upper - self.lower)[[*block]]
            yield gains

    def _closed(self, gains: Reals) -> tuple[Reals, Reals]:
        """The matrix of the loop, and ``sigma`` of ``x``."""
        sigma = np.linalg.solve(np.eye(len(gains)) + self.D * gains, self.C)
        return np.asarray(self.A - (self.B * gains) @ sigma), np.asarray(sigma, dtype=float)

    def _rays(self, rows: Reals, own: list[int]) -> Iterator[Ray]:
        """Eigenvectors of the steps that have the signs of their gains."""
        whole, seen = np.eye(len(self.A)), list[tuple[Reals, Reals]]()
        for gains in rows:
            try:
                closed, sigma = self._closed(gains)
            except np.linalg.LinAlgError:
                return
            seen.append((np.where(gains[own] == self.upper[own], 1.0, -1.0), sigma[own] @ whole))
            whole = closed @ whole
        values, vectors = np.linalg.eig(whole)
        size = 1.0 if self.discrete else float(np.abs(whole).max())
        for k in np.argsort(-values.real):
            if abs(values[k].imag) > 0 or values[k].real <= self.discrete + _GROWS * size:
                continue
            for x in (vectors[:, k].real, -vectors[:, k].real):
                x = np.where(np.abs(x) > _ZERO * np.abs(x).max(), x / np.abs(x).max(), 0.0)
                still = x == 0
                idle = [~lines[:, ~still].any(axis=1) & ~whole[still][:, ~still].any() for _, lines in seen]
                if all(
                    ((sign * (lines @ x) > _CLEAR * np.abs(lines).max()) | rests).all()
                    for (sign, lines), rests in zip(seen, idle, strict=True)
                ):
                    yield Ray(rows, x, float(values[k].real))

    def _cycles(self, others: Reals, own: list[int], rng: np.random.Generator) -> Iterator[Ray]:
        """What simulated solutions end in: patterns that repeat."""
        if self.D.any():
            return
        x, history = rng.normal(size=(_STARTS, len(self.A))), list[Reals]()
        with np.errstate(all="ignore"):
            for _ in range(_STEPS):
                sigma = x @ self.C.T
                gains = np.repeat(others[None], _STARTS, axis=0)
                gains[:, own] = np.where(sigma[:, own] > 0, self.upper[own], self.lower[own])
                history.append(gains)
                x = x @ self.A.T - (gains * sigma) @ self.B.T
                x = x / np.maximum(np.abs(x).max(axis=1, keepdims=True), 1e-300)
        table, known = np.array(history), set[bytes]()
        for start in range(_STARTS):
            late = table[_STEPS // 2 :, start]
            period = next((N for N in range(2, _LONGEST + 1) if (late[N:] == late[:-N]).all()), None)
            if period is not None and late[:period].tobytes() not in known:
                known.add(late[:period].tobytes())
                yield from self._rays(late[:period], own)
