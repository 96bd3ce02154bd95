r"""The best multiplier ``1 + theta s - tau s^2``: bisection in ``tau`` on exact cutting planes in ``theta``.

For fixed ``tau`` the inequality is ``(U + theta W/(1 + tau x))/D > -1/k``, as in Popov's.  Its support, points ``x_i``
with weights ``l_i`` such that ``sum l_i W/D = 0``, says more: no ``theta`` and ``tau`` exceed the level ``m`` unless
``S_0 + tau S_1 > 0``, ``S_j = sum l_i x_i^j (U/D - m)``.  So it tells on which side of ``tau`` to go on, and two
supports with opposite answers bound the criterion's reach from above.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

from flint import fmpq

from analysis.multiplier_search import Cut, Found, search
from analysis.polynomial_family import PolynomialFamily, short_between

EXPANSIONS = 24
HALVINGS = 60
KEPT = 32
LOOSE = fmpq(1, 10**11)
CLOSED = fmpq(1, 10**11)


@dataclass(frozen=True, slots=True)
class Support:
    """Points of ``[0, inf)`` with weights: ``sum l w = 0`` exactly."""

    cuts: tuple[Cut, ...]
    weights: tuple[fmpq, ...]

    def moment(self, power: int, level: fmpq) -> fmpq:
        """``S_j`` at a level."""
        total = fmpq(0)
        for cut, weight in zip(self.cuts, self.weights, strict=True):
            x = fmpq(0) if cut.x is None else cut.x
            total += weight * x**power * (cut.u - level)
        return total


@dataclass(frozen=True, slots=True)
class Best:
    """``theta``, ``tau`` and the level they exceed, with a level that no pair exceeds; None where none was shown.

    A level of 0 stands for every negative one.  ``growing`` says what must grow with ``k`` then: ``theta``, whose
    sign is given, or ``tau``, with ``theta`` the ratio ``theta/tau``.
    """

    theta: fmpq | None
    tau: fmpq
    level: fmpq
    unreachable: fmpq | None = None
    growing: Literal["", "theta", "tau"] = ""


def best_pair(family: PolynomialFamily, scale: fmpq, rounded: Callable[[fmpq], fmpq]) -> Best:
    """The largest level that some ``theta`` and ``tau >= 0`` exceed.

    Parameters
    ----------
    family : PolynomialFamily
        ``D, U, W`` of a stable block.
    scale : fmpq
        A typical ``1/x``: where ``tau`` begins.
    rounded : callable
        As in :func:`analysis.multiplier_search.search`.
    """
    return _Search(family, rounded, list(family.first_cuts())).run(scale)


@dataclass(slots=True)
class _Search:
    family: PolynomialFamily
    rounded: Callable[[fmpq], fmpq]
    raw: list[Cut]
    best: Best = Best(None, fmpq(0), fmpq(-1))
    low: tuple[fmpq, Support] | None = None
    high: tuple[fmpq, Support] | None = None

    def run(self, scale: fmpq) -> Best:
        """The best multiplier found."""
        if self._visit(fmpq(0)):
            return self.best
        tau = scale
        for _ in range(EXPANSIONS):
            if self._visit(tau):
                return self.best
            if self.high is not None and self.low is not None and self.low[0] > 0:
                break
            tau = tau * 16 if self.high is None else tau / 16
        for _ in range(HALVINGS if self.high is not None else 0):
            if self._closed() or self._visit(self._between()):
                break
        return self.best

    def _visit(self, tau: fmpq) -> bool:
        """Look at one ``tau``; whether nothing better is left."""
        stretched = self.family.stretched(tau)
        cuts = [_stretch(cut, tau) for cut in self.raw]
        direct = Cut(self.family.at_infinity.u, fmpq(0))
        found = search(stretched, [*cuts, direct], self.rounded)
        if found.theta is not None and (self.best.theta is None or found.level > self.best.level):
            self.best = Best(found.theta, tau, found.level, self.best.unreachable)
        self.raw = self._kept(found)
        if any(cut.x is None for cut in found.summit.support):
            return self._at_infinity(found, stretched, tau)
        support = self._support(found)
        level = found.summit.value * (1 - LOOSE)
        if support.moment(0, level) <= 0 and support.moment(1, level) <= 0:
            self._bound(level)
            return True
        if support.moment(1, found.summit.value) > 0:
            self.low = (tau, support)
        else:
            self.high = (tau, support)
        return False

    def _kept(self, found: Found) -> list[Cut]:
        theta = found.theta if found.theta is not None else fmpq(0)
        inner = sorted((cut for cut in found.cuts if cut.x is not None), key=lambda cut: cut.at(theta))
        points = [cut.x for cut in inner[:KEPT]]
        return [self.family.at_infinity, *(self.family.cut(x) for x in points if x is not None)]

    def _at_infinity(self, found: Found, stretched: PolynomialFamily, tau: fmpq) -> bool:
        """Whether the bound is one that no multiplier moves: a level of 0, or ``1/k + D > 0``."""
        if not all(cut.w == 0 for cut in found.summit.support):
            return False
        theta = stretched.everywhere(list(found.cuts)) if found.summit.value == 0 else None
        if theta is not None:
            self.best = Best(theta, tau, fmpq(0))
        elif found.summit.value < 0:
            self._bound(found.summit.value)
        return True

    def _support(self, found: Found) -> Support:
        """The support in terms of the unstretched functions."""
        cuts = tuple(self.family.exact(cut.x) for cut in found.summit.support if cut.x is not None)
        if len(cuts) == 1:
            return Support(cuts, (fmpq(1),))
        return Support(cuts, (-cuts[1].w, cuts[0].w))

    def _bound(self, level: fmpq) -> None:
        self.best = Best(self.best.theta, self.best.tau, self.best.level, level)

    def _between(self) -> fmpq:
        assert self.low is not None
        assert self.high is not None
        ratio = float(self.high[0] / self.low[0]) ** 0.5
        root = self.low[0] * fmpq(int(ratio * 2**60), 2**60)
        gap = (self.high[0] - self.low[0]) / 16
        return short_between(root - min(gap, root / 16), root + gap)

    def _closed(self) -> bool:
        """Whether the two supports together bound every pair at a level next to the best one."""
        assert self.low is not None
        assert self.high is not None
        level = self.best.level * (1 - CLOSED)
        if level < 0 and jointly_infeasible((self.low[1], self.high[1]), level):
            self._bound(level)
            return True
        return False


def jointly_infeasible(supports: Sequence[Support], level: fmpq) -> bool:
    """Whether some mixture of two supports has ``S_0 <= 0`` and ``S_1 <= 0``: then nothing exceeds the level."""
    one, two = supports
    a0, a1, b0, b1 = one.moment(0, level), one.moment(1, level), two.moment(0, level), two.moment(1, level)
    mixtures = [(fmpq(1), fmpq(0)), (fmpq(0), fmpq(1))]
    if a1 * b1 < 0:
        mixtures.append((abs(b1), abs(a1)))
    if a0 * b0 < 0:
        mixtures.append((abs(b0), abs(a0)))
    return any(p * a0 + q * b0 <= 0 and p * a1 + q * b1 <= 0 for p, q in mixtures)


def _stretch(cut: Cut, tau: fmpq) -> Cut:
    if cut.x is None:
        return cut if tau == 0 else Cut(cut.u, fmpq(0))
    return Cut(cut.u, cut.w / (1 + tau * cut.x), cut.x)
