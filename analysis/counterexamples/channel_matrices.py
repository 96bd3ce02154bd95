"""Matrices of gains that destabilise a loop in which a function of several channels lies in a full-block sector.

``mu_b = -(c + r Q) sigma_b`` with ``c = (l + u)/2``, ``r = (u - l)/2`` and any ``|Q| <= 1`` is a member.  The leading
eigenvalue of the loop changes by ``<K, dG>``, ``K_ij = -(y^* B)_i (C x)_j/(y^* x)``, and grows fastest towards ``Q =
U V'`` if ``Re K_b = U S V'``; gains of other channels go to one end or the other.  Nothing here is believed: a checker
decides.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction

from lure.analysis.deadline import checkpoint
from lure.arrays import Reals, np
from lure.record import described, quantity

_STARTS, _TURNS, _HALVINGS, _LARGEST, _SURE = 8, 30, 40, 1e6, 1e-9
_MARGIN, _BITS = Fraction(1, 2**40), 2**52
_STEPS = (1e-10, 1e-9, 1e-7, 1e-5, 1e-3)


@described()
class MatrixGains:
    """The search for one plant."""

    A: Reals = quantity("(n, n) [floating point]")
    B: Reals = quantity("(n, m) [floating point]")
    C: Reals = quantity("(m, n) [floating point]")
    D: Reals = quantity("(m, m) [floating point]")
    lower: Sequence[Fraction] = quantity("Lower bounds at the factor 1")
    upper: Sequence[Fraction] = quantity("Upper bounds at the factor 1")
    blocks: Sequence[Sequence[int]] = quantity("The channels of each nonlinearity")
    wide: Sequence[Sequence[int]] = quantity("Those of the blocks that are functions of all their channels")
    discrete: bool = quantity("Whether in discrete time")

    def found(self, most: float) -> Iterator[tuple[Fraction, list[list[Fraction]]]]:
        """Factors and matrices of all channels that let a solution grow, the least factor that was found first.

        ``most``: the largest factor of interest; finite: of this factor.
        """
        random = np.random.default_rng(0)
        starts = [np.eye(len(self.D)), -np.eye(len(self.D))]
        starts += [random.normal(size=self.D.shape) for _ in range(_STARTS)]
        if most < math.inf:
            best = max((self._grown(most, start) for start in starts), key=lambda one: one[0])
            if best[0] > _SURE:
                yield Fraction(most), self._exact(Fraction(most), best[1])
            return
        high, shape = self._first(starts)
        if shape is None:
            return
        low = 0.0
        for _ in range(_HALVINGS):
            checkpoint()
            middle = (low + high) / 2
            growth, turned = max((self._grown(middle, one) for one in (shape, *starts[:2])), key=lambda one: one[0])
            low, high, shape = (low, middle, turned) if growth > _SURE else (middle, high, shape)
        for step in _STEPS:
            alpha = Fraction(high * (1 + step))
            yield alpha, self._exact(alpha, self._grown(float(alpha), shape)[1])

    def _first(self, starts: list[Reals]) -> tuple[float, Reals | None]:
        """A factor at which something grows, with the shape of the gains."""
        factor = 1 / _LARGEST
        while factor <= _LARGEST:
            checkpoint()
            growth, shape = max((self._grown(factor, one) for one in starts), key=lambda one: one[0])
            if growth > _SURE:
                return factor, shape
            factor *= 4
        return factor, None

    def _grown(self, factor: float, shape: Reals) -> tuple[float, Reals]:
        """The growth that is reached from a shape ``Q`` (of single gains its diagonal), and the shape there."""
        shape, best = self._towards(shape), (-math.inf, shape)
        for _ in range(_TURNS):
            growth, slope = self._leading(factor, shape)
            if growth <= best[0] + _SURE * abs(best[0]):
                break
            best = growth, shape
            shape = self._towards(slope)
        return best

    def _towards(self, slope: Reals) -> Reals:
        """The shape at which a linear function of ``G`` is largest."""
        found = np.zeros_like(slope)
        for block in self.blocks:
            if block in self.wide:
                u, _, v = np.linalg.svd(slope[np.ix_(block, block)])
                found[np.ix_(block, block)] = u @ v
            else:
                found[block, block] = np.sign(sum(slope[i, i] for i in block)) or 1.0
        return found

    def _ends(self, factor: float) -> tuple[Reals, Reals]:
        low, high = (np.array([float(v) for v in side]) for side in (self.lower, self.upper))
        return (factor * high + low) / 2, (factor * high - low) / 2

    def _leading(self, factor: float, shape: Reals) -> tuple[float, Reals]:
        """The growth with a shape, and its slopes in ``G``."""
        middle, radius = self._ends(factor)
        G, one = np.diag(middle) + radius[:, None] * shape, np.eye(len(shape))
        whole = one + self.D @ G
        if radius.min() <= 0 or abs(np.linalg.det(whole)) < _SURE:
            return -math.inf, shape
        seen, into = np.linalg.solve(whole, self.C), self.B @ np.linalg.inv(one + G @ self.D)
        values, right = np.linalg.eig(self.A - self.B @ G @ seen)
        size = np.abs(values) - 1 if self.discrete else values.real
        k = int(np.argmax(size))
        left = np.linalg.pinv(right)[k]
        slope = -np.outer(left @ into, seen @ right[:, k])
        turn = np.conj(values[k]) / max(abs(values[k]), _SURE) if self.discrete else 1.0
        return float(size[k]), np.real(turn * slope)

    def _exact(self, alpha: Fraction, shape: Reals) -> list[list[Fraction]]:
        """The matrix of all channels in fractions, a little inside of the class."""
        wide = {i for block in self.wide for i in block}
        found = list[list[Fraction]]()
        for i, row in enumerate(shape.tolist()):
            low, high = self.lower[i], alpha * self.upper[i]
            inside = 1 - _MARGIN if i in wide else 1
            rounded = [Fraction(round(v * _BITS), _BITS) * inside * (high - low) / 2 for v in row]
            found.append([v + (i == j) * (high + low) / 2 for j, v in enumerate(rounded)])
        return found
