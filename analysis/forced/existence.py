r"""That a periodic solution exists near a balance of harmonics, where nothing is proved of differences: in balls.

With ``a(t) = psi'(sigma_hat(t))`` a solution ``sigma_hat + delta`` has ``nu = -psi(sigma)`` off by ``eta``, where

.. math:: (1 + M_a G)\, \eta = -e - q(\delta), \qquad \delta = G \eta, \qquad
    q = \psi(\hat\sigma + \delta) - \psi(\hat\sigma) - a\,\delta,

``G`` being what harmonics of ``nu`` make of ``sigma`` and ``M_a`` the product with ``a``.  If ``|delta| <= r`` at every
time implies as much of ``G (1 + M_a G)^{-1} (-e - q)``, there is a solution with ``|delta| <= r`` by Schauder's
theorem: the map is continuous and compact on continuous periodic functions.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from flint import acb, acb_mat, arb

from lure.analysis.deadline import checkpoint
from lure.analysis.forced.balance import Balanced
from lure.analysis.forced.band import BITS, NotEnclosed, Residual, Sampled, above, around, peak, residual
from lure.analysis.forced.loop import Curve, ForcedLoop
from lure.analysis.numerics.precision import ball, working_precision
from lure.analysis.verdict import Bracket
from lure.arrays import Complexes, np
from lure.record import described, quantity

_POINTS, _KINKED, _FINER, _NEAR = 4096, 16384, 16, 1e-6
_LOW, _RADII, _START, _STEP = (16, 32, 64, 96), 8, 1.2, 1.7


@described(frozen=True)
class Existing:
    """A periodic solution that exists."""

    found: Balanced = quantity("The balance it is near to")
    rows: list[list[acb]] = quantity("The harmonics of ``sigma`` and ``z`` there")
    radius: float = quantity("How far ``sigma`` is from the balanced one at any time, at most")
    z: Bracket = quantity("Its peak over a period")
    sigma: tuple[Bracket, ...] = quantity("Their peaks over a period")
    error: float = quantity("How far ``z`` is from the balanced one at any time, at most")
    residual: float = quantity("Mean square root of what the harmonics miss")

    def apart(self, other: Existing) -> bool:
        """Whether the two solutions are certainly not the same."""
        if self.found.wave.base != other.found.wave.base:
            return False
        limit = 2 * (ball(self.radius) + ball(other.radius))
        pairs = zip(self.rows[: len(self.sigma)], other.rows, strict=False)
        return any(abs(a - b) > limit for mine, theirs in pairs for a, b in zip(mine, theirs, strict=False))

    @property
    def subharmonic(self) -> bool:
        """Whether it certainly does not repeat with the input: then a period of the input later it is another one."""
        n, limit = self.found.wave.periods, 2 * ball(self.radius)
        rows = self.rows[: len(self.sigma)]
        return any(abs(c) > limit for row in rows for k, c in enumerate(row) if k % n)


def existing(loop: ForcedLoop, found: Balanced) -> Existing | None:
    """The solution near a balance; None where the argument does not show one.

    ``loop``: the loop, ``sigma`` and ``z`` without direct terms from ``nu``.
    """
    if any(v != 0 for row in loop.D.tolist() for v in row):
        return None
    smooth = loop.smoothing(found.wave.base)
    with working_precision(BITS):
        try:
            missed = residual(loop, found)
        except NotEnclosed:
            return None
        m = loop.channels
        ways = [_Way.of(loop, i, missed) for i in range(m)]
        inverse = next((one for low in _LOW if (one := _inverse(loop, missed, ways, low, smooth)) is not None), None)
        if inverse is None:
            return None
        checkpoint()
        alone, steep = missed.filtered(loop, smooth), _steepest(ways)
        plain = inverse * missed.mean
        begun = [
            min(top + s * inverse * steep * alone.mean, s * plain, key=float)
            for top, s in zip(alone.tops, smooth, strict=True)
        ]
        radius = above(_START * max(begun[:m], key=float))
        if not math.isfinite(radius):
            return None
        bent = [(way, way.bent(radius * _STEP**_RADII)) for way in ways]
        for _ in range(_RADII):
            q = inverse * sum((way.curved(radius, parts) ** 2 for way, parts in bent), arb(0)).sqrt()
            errors = [one + s * q for one, s in zip(begun, smooth, strict=True)]
            if all(one <= ball(radius) for one in errors[:m]):
                wide = sum((one * one for one in errors[m:]), arb(0)).sqrt()
                sigma = tuple(around(peak([missed.rows[i]]), errors[i]) for i in range(m))
                z = around(peak(missed.rows[m:]), wide)
                return Existing(found, missed.rows, radius, z, sigma, above(wide), above(missed.mean))
            radius *= _STEP
    return None


def _steepest(ways: Sequence[_Way]) -> arb:
    """What ``|psi'|`` does not exceed on the way."""
    return max((abs(slope).upper() for way in ways for slope in way.slopes), key=float)


@dataclass(frozen=True)
class _Way:
    """Of one channel ``sigma_hat`` on equal parts of a period, and an interval of ``psi'`` on each."""

    curve: Curve
    at: Sampled
    half: arb
    slopes: list[arb]
    exact: list[acb] | None

    @classmethod
    def of(cls, loop: ForcedLoop, channel: int, missed: Residual) -> _Way:
        """The way of a channel."""
        degree, order = loop.degrees[channel], len(missed.rows[channel]) - 1
        count = _POINTS if degree is not None else _KINKED
        at, half = Sampled.of(missed.rows[channel], count), arb.pi() / count
        g, curve = ball(loop.gains[channel]), loop.curves[channel]
        slopes = [curve(_box(s, ds, at.bend, half))[1] - g for s, ds in zip(at.values, at.slopes, strict=True)]
        exact = None
        if degree is not None and 2 * (degree - 1) * order < count:  # psi' is a sum of harmonics itself
            exact = [c / count for c in acb.dft([acb(curve(s)[1] - g) for s in at.values])]
        return cls(curve, at, half, slopes, exact)

    def coefficients(self, most: int) -> tuple[list[acb], arb]:
        """``a_k``, ``|k| <= most``, of ``a`` or of what is constant on each part, and how far each is off."""
        count = len(self.slopes)
        if self.exact is not None:
            return [self.exact[k % count] for k in range(-most, most + 1)], arb(0)
        found = acb.dft([acb(slope.mid()) for slope in self.slopes])
        width = [arb(1), *((self.half * k).sin() / (self.half * k) for k in range(1, most + 1))]
        flat = [found[k % count] * width[abs(k)] / count for k in range(-most, most + 1)]
        return flat, (sum((slope.rad() for slope in self.slopes), arb(0)) / count).upper()

    def bent(self, radius: float) -> list[int]:
        """The parts on which ``psi`` is not straight where ``|delta| <= radius``."""
        wide = arb(0, radius)
        return [j for j in range(len(self.slopes)) if self._most(self._box(j) + wide, ball(radius)) > 0]

    def curved(self, radius: float, parts: Sequence[int]) -> arb:
        """What ``q`` is at most in the mean square, for ``|delta| <= radius``, ``psi`` being bent on these parts."""
        wide, total, r = arb(0, radius), arb(0), ball(radius)
        fine, drift = self.half / _FINER, arb(0, above(self.at.bend * self.half**2 / 2))
        for j in parts:
            s, ds = self.at.values[j], self.at.slopes[j]
            most = self._most(self._box(j) + wide, r)
            if most < _NEAR:
                total += most**2
                continue
            quick = arb(0, above((abs(ds) + self.at.bend * self.half) * fine))  # a kink may be near: look closer
            for k in range(_FINER):
                total += self._most(s + ds * fine * (2 * k + 1 - _FINER) + drift + quick + wide, r) ** 2 / _FINER
        return r * (total / len(self.slopes)).sqrt().upper()

    def _box(self, j: int) -> arb:
        return _box(self.at.values[j], self.at.slopes[j], self.at.bend, self.half)

    def _most(self, box: arb, r: arb) -> arb:
        """What ``|q|`` is at most, over ``|delta|``, on a part where ``sigma`` is in a box that is wider by that."""
        _, slope, bend = self.curve(box)
        return (abs(bend) * r / 2 if bend.is_finite() else 2 * slope.rad()).upper()


def _box(s: arb, ds: arb, bend: arb, half: arb) -> arb:
    """Where a signal is within ``half`` of a point at which it and its derivative are known."""
    return s + arb(0, above((abs(ds) + bend * half) * half))


def _inverse(loop: ForcedLoop, missed: Residual, ways: Sequence[_Way], low: int, smooth: Sequence[arb]) -> arb | None:
    r"""A bound of ``(1 + M_a G)^{-1}`` in the mean square; None if ``low`` harmonics do not show one.

    With ``P`` the harmonics up to ``low`` and ``F = P (1 + M_a G) P``: ``(1 + M_a G P)^{-1} = 1 - M_a G F^{-1} P``, of
    norm ``rho <= 1 + |a| |G F^{-1}|``; and ``|M_a G (1 - P)| <= |a| g``, ``g`` the largest ``|G|`` above, which stands
    twice in the sum of squares.
    """
    m, top, G = loop.channels, _steepest(ways), missed.responses
    if low >= len(G) or not top.is_finite():
        return None
    beyond = (sum((missed.tail(i, smooth[i], low) ** 2 for i in range(m)), arb(0)) / 2).sqrt()
    if not 2 * top * beyond < 1:
        return None
    known = [way.coefficients(2 * low) for way in ways]
    coefficients, spread = [one for one, _ in known], max((off for _, off in known), key=float)
    order = [(i, k) for i in range(m) for k in range(-low, low + 1)]

    def response(i: int, j: int, k: int) -> acb:
        """``G_ij`` at the k-th harmonic."""
        return G[k][i, j] if k >= 0 else G[-k][i, j].conjugate()

    # F = 1 + P M_a G P, up to what the middles of a miss: at most `spread` in each coefficient
    F = acb_mat(
        [
            [coefficients[i][k - q + 2 * low] * response(i, j, q) + (1 if (i, k) == (j, q) else 0) for j, q in order]
            for i, k in order
        ]
    )
    plain: Complexes = np.array([[complex(F[r, c]) for c in range(len(order))] for r in range(len(order))])
    if not np.isfinite(plain).all() or abs(np.linalg.det(plain)) == 0:
        return None
    R = acb_mat([[acb(v.real, v.imag) for v in row] for row in np.linalg.inv(plain).tolist()])
    off = F * R
    miss = sum(
        (abs(off[r, c] - (1 if r == c else 0)) ** 2 for r in range(len(order)) for c in range(len(order))), arb(0)
    ).sqrt()
    whole = acb_mat([[response(i, j, q) if k == q else acb(0) for j, q in order] for i, k in order]) * R
    size = sum((abs(v) ** 2 for row in whole.tolist() for v in row), arb(0)).sqrt()
    # the middles of a: |P (M_a - M_mid) G R| <= |entries| <= spread sqrt(rows) |G R|
    miss = miss + spread * arb(m * (2 * low + 1) * (2 * low + 1)).sqrt() * size
    if not miss < 1:
        return None
    rho = 1 + top * size / (1 - miss)
    left = 1 - rho * top * beyond
    return (rho / left).upper() if left > 0 else None
