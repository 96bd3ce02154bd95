"""Constant gains ``mu_i = -g_i sigma_i`` that destabilise a plant of several channels, in floating point.

Where a function of several channels lies in a full-block sector, a matrix takes the place of their gains.
``mu_b = -(c + r Q) sigma_b`` with ``c = (l + u)/2``, ``r = (u - l)/2`` and any ``|Q| <= 1`` is a member.  The leading
eigenvalue of the loop changes by ``<K, dG>``, ``K_ij = -(y^* B)_i (C x)_j/(y^* x)``, and grows fastest towards ``Q =
U V'`` if ``Re K_b = U S V'``; gains of other channels go to one end or the other.  Nothing here is believed: a checker
decides.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from itertools import islice, product
from typing import Any, NamedTuple

from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.zero_modes import Rows, exact
from lure.arrays import NDArray, Reals, np, optimize
from lure.record import described, quantity

_ALL_VERTICES, _DRAWN, _SCALES, _POLISHED, _SEED = 6, 40, 90, 2, 20261122
_STEPS, _TRIED, _NEAR, _ROUGHLY, _ENOUGH = 25, 8, 32, 5, 1e-9  # of the search that starts there
_BEYOND = (1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2)  # of the crossing, so that rounding does not hide it
_WORK = 4e8  # evaluations times the cube of the order, for shapes and scales
_STILL = 1e-8  # of the largest eigenvalue
_MOST_CORNERS, _FARTHEST, _SHORT = 10, 1e12, 10**6  # nonlinearities, factors, denominators: where D has no solution
_ZOOMS, _POINTS, _REFINED = 9, 16, 12  # of a crossing: 16^-9 of the interval
_GRID, _MOST_PATTERNS, _RANDOM, _TIMES_FINER, _NEWTONS = 900, 64, 16, 2, 60
_A_TURN, _MOST_GRID = 10, 9000  # frequencies for each turn of the longest dead time
_WIDTHS = (1e-9, 1e-8, 1e-7, 1e-6, 1e-5)
_LARGEST, _EXACT, _CLOSE, _REAL = 1e6, 1e-15, 1e-6, 1e-4
_STARTS, _TURNS, _HALVINGS, _LARGEST_GAIN, _SURE = 8, 30, 40, 1e6, 1e-9
_MARGIN, _BITS = Fraction(1, 2**40), 2**52
_MATRIX_STEPS = (1e-10, 1e-9, 1e-7, 1e-5, 1e-3)


@described(frozen=True)
class GainsAround:
    """A plant in floating point with linear gains around it."""

    A: NDArray[np.float64] = quantity("(n, n)")
    B: NDArray[np.float64] = quantity("(n, m)")
    C: NDArray[np.float64] = quantity("(m, n)")
    D: NDArray[np.float64] = quantity("(m, m)")

    def closed_by(self, gains: NDArray[np.float64]) -> NDArray[np.float64]:
        """The matrices of the loop with ``mu = -g sigma``: (.., n, n); with huge entries where there is no solution.

        ``gains``: (.., m), one of each channel.
        """
        m = gains.shape[-1]
        G = gains[..., None] * np.eye(m)
        whole = np.eye(m) + self.D @ G
        whole = np.where(np.abs(np.linalg.det(whole))[..., None, None] < 1e-300, whole + 1e-9 * np.eye(m), whole)
        seen = np.linalg.solve(whole, np.broadcast_to(self.C, (*G.shape[:-2], *self.C.shape)))
        return np.asarray(self.A - self.B @ G @ seen)


@described(frozen=True)
class GainSearch(GainsAround):
    """Gains ``g_i = l_i + tau_i (alpha u_i - l_i)``, ``0 <= tau_i <= 1``, of the classes ``[l_i, alpha u_i]``."""

    lower: NDArray[np.float64] = quantity("(m,) lower bounds at ``alpha = 1``")
    upper: NDArray[np.float64] = quantity("(m,) upper bounds at ``alpha = 1``")
    blocks: Sequence[Sequence[int]] = quantity("The channels, counted from 0, that have equal gains")
    discrete: bool = quantity("Whether in discrete time")
    critical: bool = quantity("Whether the loop with the gains ``lower`` has an eigenvalue 0 (1)", default=False)

    def growth(self, gains: NDArray[np.float64]) -> NDArray[np.float64]:
        """The largest real part of the eigenvalues, in discrete time the largest modulus less 1, for gains (.., m).

        ``gains``: (.., m).
        """
        values = np.linalg.eigvals(self.closed_by(gains))
        return np.asarray(self._grows(np.asarray(values, dtype=complex)).max(axis=-1))

    def _grows(self, values: NDArray[np.complex128]) -> Reals:
        found = np.abs(values) - 1 if self.discrete else values.real
        if self.critical:  # eigenvalues 0 that stay there with some gains refute nothing
            still = np.abs(values - self.discrete) < _STILL * np.abs(values).max(axis=-1, keepdims=True)
            found = np.where(still, -np.inf, found)
        return np.asarray(found)

    def _gains(self, shape: NDArray[np.float64], alpha: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(self.lower + shape * (alpha[..., None] * self.upper - self.lower))

    def shapes(self) -> NDArray[np.float64]:
        """``tau``: the vertices of the box and points inside; equal entries for a repeated nonlinearity."""
        m = len(self.blocks)
        if m == 1:
            return np.ones((1, len(self.upper)))
        rng = np.random.default_rng(_SEED)
        corners = list(product((0.0, 1.0), repeat=m)) if m <= _ALL_VERTICES else []
        drawn = rng.random((_DRAWN, m))
        edges = np.where(rng.random((_DRAWN, m)) < 0.5, np.round(drawn), drawn)
        extra = [np.ones(m), *(1.0 - np.eye(m)), *np.eye(m), *drawn, *edges]
        return self._spread(np.unique(np.array([*corners, *extra], dtype=float), axis=0))

    def _spread(self, shape: NDArray[np.float64]) -> NDArray[np.float64]:
        """Entries for each block (.., number of blocks) as entries for each channel."""
        return np.asarray(np.repeat(shape, [len(block) for block in self.blocks], axis=-1))

    def scales(self) -> NDArray[np.float64]:
        """Factors from where small gains cannot destabilise to far beyond."""
        poles = np.linalg.eigvals(self.A)
        points = (
            np.exp(1j * np.linspace(0, np.pi, 40)) if self.discrete else 1j * np.unique(np.abs([*poles, *poles.imag]))
        )
        if self.critical:  # H is infinite there, which says nothing about gains
            size = np.abs(poles).max() or 1.0
            away = np.abs(points[:, None] - poles).min(axis=1) > 1e-3 * size
            points = np.append(points[away], np.exp(1j) if self.discrete else 1j * size)
        with np.errstate(all="ignore"):
            shifted = points[:, None, None] * np.eye(len(self.A)) - self.A + 1e-9 * np.eye(len(self.A))
            size = np.linalg.norm(self.C @ np.linalg.solve(shifted, self.B.astype(complex)) + self.D, axis=(1, 2)).max()
        unit = 1 / max(float(size) * float(np.abs(self.upper).max()), 1e-12)
        return np.asarray(unit * np.geomspace(1e-2, 1e6, _SCALES))

    def first(self, shapes: NDArray[np.float64], scales: NDArray[np.float64], zooms: int = _ZOOMS) -> Reals:
        """For each shape the smallest factor among the scales, sharpened, at which it destabilises; inf if none.

        Parameters
        ----------
        shapes : ndarray
            (k, m) ``tau``.
        scales : ndarray
            Ascending factors.
        zooms : int
            How often the interval of the crossing is divided.
        """
        checkpoint()
        beyond = self.growth(self._gains(shapes[:, None], scales)) > 0
        at, never = beyond.argmax(axis=1), ~beyond.any(axis=1)
        low, high = scales[np.maximum(at - 1, 0)], scales[at]
        steps, row = np.linspace(0, 1, _POINTS + 1), np.arange(len(shapes))
        for _ in range(zooms):
            points = low[:, None] + (high - low)[:, None] * steps
            j = 1 + (self.growth(self._gains(shapes[:, None], points[:, 1:])) > 0).argmax(axis=1)
            low, high = points[row, j - 1], points[row, j]
        return np.where(never, np.inf, high)

    def unsolvable(self, most: float) -> tuple[float, Reals] | None:
        """The smallest factor found at which ``det(1 + D G) = 0``, with its ``tau``, a vertex; None up to ``most``.

        The determinant is affine in each gain of its own, so that it vanishes at a vertex first.

        ``most``: the largest factor of interest.
        """
        if not self.D.any() or len(self.blocks) > _MOST_CORNERS:
            return None
        shapes, one = self._spread(np.array(list(product((0.0, 1.0), repeat=len(self.blocks))))), np.eye(len(self.D))
        still, moved = (side[:, None, :] * self.D for side in ((1 - shapes) * self.lower, shapes * self.upper))
        kept = np.abs(np.linalg.det(one + still)) > _STILL
        values = np.linalg.eigvals(-np.linalg.solve(one + still[kept], moved[kept])).astype(complex)
        real = (np.abs(values.imag) <= _STILL * np.abs(values)) & (values.real * _FARTHEST > 1)
        first = 1 / np.where(real, values.real, 0.0).max(axis=1, initial=1 / _FARTHEST)
        k = int(np.argmin(first)) if len(first) else 0
        found = len(first) and first[k] < _FARTHEST and first[k] <= most * (1 + _STILL)
        return (float(first[k]), shapes[kept][k]) if found else None

    def singular(
        self, D: Rows, ends: tuple[Sequence[Fraction], Sequence[Fraction]], found: tuple[float, Reals], *, most: float
    ) -> Iterator[list[Fraction]]:
        """Gains near a vertex with ``det(1 + D G) = 0`` exactly, within the class of the factor ``most``.

        Parameters
        ----------
        D : sequence of sequence of Fraction
            ``D``, exactly.
        ends : tuple of sequence of Fraction
            The bounds at ``alpha = 1``, exactly.
        found : tuple
            The factor and the shape of :meth:`unsolvable`.
        most : float
            The largest factor allowed.
        """
        alpha, shape = found
        short = Fraction(alpha).limit_denominator(_SHORT)
        tried = [short] * (abs(float(short) - alpha) < _BEYOND[0] * alpha)
        tried += [Fraction(alpha * (1 + beyond)) for beyond in _BEYOND]
        alone = [block[0] for block in self.blocks if len(block) == 1 and shape[block[0]] > 0]
        for factor, i in product((one for one in tried if one <= most), alone):
            gains = [high * factor if tau else low for low, high, tau in zip(*ends, shape, strict=True)]
            values = []
            for gains[i] in (Fraction(0), Fraction(1)):
                rows = [[(r == c) + v * gains[c] for c, v in enumerate(row)] for r, row in enumerate(D)]
                values.append(exact(rows).det())
            if values[0] != values[1]:
                root = values[0] / (values[0] - values[1])
                gains[i] = Fraction(int(root.p), int(root.q))
                yield gains

    def _rough(self, shapes: Reals, scales: Reals) -> Reals:
        """The smallest factor at which each shape destabilises, between two scales as if growth were a line."""
        found = []
        for shape in shapes:
            checkpoint()
            values = self.growth(self._gains(shape, scales))
            k = int((values > 0).argmax())
            share = values[k] / (values[k] - values[k - 1]) if k else 0.0
            found.append(scales[k] - share * (scales[k] - scales[k - 1]) if values[k] > 0 else np.inf)
        return np.array(found)

    def found(self, least: float, most: float) -> tuple[float, NDArray[np.float64]] | None:
        """The smallest factor that was found with its ``tau``; None if there is none up to ``most``.

        ``least``, ``most``: the factors of interest; at ``least`` a class may be a single gain.
        """
        scales = self.scales()
        scales = np.unique(np.concatenate([scales, [max(least, 0.0) * (1 + 1e-9), 2 * max(least, 0.0)]]))
        scales = scales[(scales > least) & (scales < most)]
        scales = np.append(scales, most) if most < np.inf else scales
        shapes, count = self.shapes(), _WORK / len(self.A) ** 3
        if len(shapes) * len(scales) > count:  # fewer of both
            share = (count / len(shapes) / len(scales)) ** 0.5
            keep = np.linspace(len(shapes) - 1, 0, max(3, int(share * len(shapes)))).astype(int)
            shapes = np.concatenate([np.ones((1, len(self.upper))), shapes[keep]])
            scales = scales[np.linspace(0, len(scales) - 1, max(10, int(share * len(scales)))).astype(int)]
        nearest = np.argsort(self._rough(shapes, scales), kind="stable")[:_REFINED]
        sharp = self.first(shapes[nearest], scales)
        order = np.argsort(sharp, kind="stable")
        reached = [(float(sharp[i]), shapes[nearest[i]]) for i in order if np.isfinite(sharp[i])]
        if len(self.blocks) > 1:
            reached += [self._polished(*one, least) for one in reached[:_POLISHED]]
        best = min(reached, key=lambda one: one[0], default=None)
        return best if best is not None and best[0] <= most else None

    def _polished(self, factor: float, shape: Reals, least: float) -> tuple[float, Reals]:
        """From there, steps to the shape that grows most at the factor, and back to the factor where it begins to."""
        rng = np.random.default_rng(_SEED)
        for step in range(_STEPS):
            slope = self._slope(self._gains(shape, np.array(factor)))
            slope = slope * (factor * self.upper - self.lower)
            slope = slope / (np.abs(slope).max() or 1.0)
            moves = [shape + slope * 2.0**-k for k in range(9)]
            each = self._spread(np.eye(len(self.blocks)))
            moves += [np.where(one > 0, end, shape) for one in each for end in (0.0, 1.0)]
            moves += [shape + self._spread(rng.normal(size=len(self.blocks))) * 0.3 / (1 + step) for _ in range(_TRIED)]
            tried = np.clip(moves, 0, 1)
            grown = self.growth(self._gains(tried, np.full(len(tried), factor)))
            near = factor * np.append(np.linspace(0.02, 0.98, _NEAR), 1.0)
            best = tried[np.argsort(-grown)[:1]]
            reached = float(self.first(best, near[near > least], _ROUGHLY)[0]) if grown.max() > 0 else np.inf
            if not reached < factor * (1 - _ENOUGH):
                break
            factor, shape = reached, best[0]
        return float(self.first(shape[None], np.array([max(least, 0.9 * factor), factor]))[0]), shape

    def _slope(self, gains: Reals) -> Reals:
        """What the growth rises with each gain, the gains of a block together: from eigenvectors on both sides."""
        G, one = np.diag(gains), np.eye(len(gains))
        right = np.linalg.solve(one + self.D @ G, self.C)
        values, turned = np.linalg.eig(self.A - self.B @ G @ right)
        k = int(self._grows(np.asarray(values, dtype=complex)).argmax())
        try:
            left = np.linalg.inv(turned)[k]
        except np.linalg.LinAlgError:
            return np.zeros(len(gains))
        rises = -(left @ self.B @ np.linalg.inv(one + G @ self.D)) * (right @ turned[:, k])
        rises = rises * np.conj(values[k]) / (np.abs(values[k]) or 1.0) if self.discrete else rises
        found = rises.real.copy()
        for block in self.blocks:
            found[[*block]] = found[[*block]].sum()
        return np.asarray(found)

    def proposals(self, alpha: float, shape: NDArray[np.float64], *, most: float) -> Iterator[list[Fraction]]:
        """Gains a little beyond the crossing, within the class of the factor ``most``.

        Parameters
        ----------
        alpha : float
            The factor that was found.
        shape : ndarray
            (m,) ``tau``.
        most : float
            The largest factor allowed.
        """
        for step in (*_BEYOND, None):
            factor = most if step is None else alpha * (1 + step)
            if factor <= most < np.inf or step is not None:
                yield [Fraction(float(g)) for g in self._gains(shape, np.array(min(factor, most)))]


# Constant gains that destabilise a plant with several channels and known dead times, in floating point.
#
# With gains ``alpha G`` the loop has a root ``i omega`` where ``1/alpha`` is an eigenvalue of ``-H G``: real ones are
# looked for along the frequency, and directions ``G`` with a large one; beside poles at 0 those of ``-lim s H G``, near
# which there are roots ``s > 0`` for every ``alpha``.  Nothing here is believed: a rectangle of gains and frequencies
# is proposed, and checked.


class Crossing(NamedTuple):
    """The factor, gains in units of the upper bounds, how much of these, and the frequency [rad/s]; 0: ``s >= 0``."""

    factor: float
    shares: NDArray[np.float64]
    size: float
    omega: float


@described()
class LateGains:
    """The search for one plant."""

    transfer: Callable[[NDArray[np.complex128]], NDArray[np.complex128]] = quantity("``H`` at points of the plane")
    upper: NDArray[np.float64] = quantity("Upper bounds, all multiplied by the factor")
    blocks: Sequence[Sequence[int]] = quantity("The channels that have one gain")
    signed: Sequence[bool] = quantity("For each block whether its gains may be negative too, as those of operators")
    poles: NDArray[np.complex128] = quantity("Of the plant", "1/s")
    delays: tuple[float, float] = quantity("The shortest dead time and the longest", "s")
    base: NDArray[np.float64] = quantity(
        "Gains of the class with which the loop is stable, but for poles at 0; others are added to these.  Channels "
        "in no block have the gain 1"
    )

    def __post_init__(self) -> None:
        (shortest, longest), fastest = self.delays, np.abs(self.poles).max()
        end, turns = 10 * max(fastest, 2 * math.pi / shortest), _A_TURN * longest / (2 * math.pi)
        count, begin = math.ceil(min(max(_GRID, turns * end), _MOST_GRID)), 1e-5 * max(fastest, 2 * math.pi / longest)
        self.omega = np.union1d(np.geomspace(begin, end, _GRID // 3), np.linspace(end / count, end, count))
        self.critical = not self.base.any() and np.abs(self.poles).min() == 0
        near = self.omega[0] * _CLOSE
        self.H = self._response(1j * np.append(near, self.omega))
        self.residue = near * self.transfer(np.array([near + 0j]))[0].real

    def _response(self, points: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """``H`` with the gains of the base."""
        H = self.transfer(points)
        if not self.base.any():
            return H
        back = np.eye(len(self.base)) + self.base[:, None] * H
        try:
            return np.asarray(H @ np.linalg.inv(back))
        except np.linalg.LinAlgError:  # near a pole at 0 of the loop itself
            return np.asarray(H @ np.linalg.pinv(back))

    def _gains(self, shares: NDArray[np.float64]) -> NDArray[np.float64]:
        found = np.zeros(len(self.upper))
        for share, block in zip(shares, self.blocks, strict=True):
            found[[*block]] = share * self.upper[[*block]]
        return found

    def crossing(self, shares: NDArray[np.float64]) -> Crossing | None:
        """The smallest factor at which gains in this direction have a root on the axis; None if none.

        ``shares``: one for each block.
        """
        G = self._gains(shares)
        values = np.linalg.eigvals(-self.H * G)
        still = values[0][np.abs(values[0].imag) < _CLOSE * (np.abs(values[0]) + 1e-300)].real
        if self.critical:
            still = still[:0]
            rates = np.linalg.eigvals(-self.residue * G).real
            growing = rates > _REAL * np.abs(self.residue).max() * np.abs(G).max()
            if growing.sum() % 2:  # poles at 0 move to the right with any such gains
                return self._made(1 / _LARGEST, shares, 0.0)
        best = self._made(1 / still.max(), shares, 0.0) if len(still) and still.max() > 1 / _LARGEST else None
        phase = np.where(values[1:].real > 0, values[1:].imag, np.nan)
        # a path is continued by the nearest value: with few channels all pairs are looked at
        for k in range(values.shape[1]):
            near = np.abs(values[2:, :] - values[1:-1, k, None]).argmin(axis=1)
            after = np.take_along_axis(phase[1:], near[:, None], axis=1)[:, 0]
            for at in np.flatnonzero(phase[:-1, k] * after <= 0):
                size = max(values[at + 1, k].real, values[at + 2, near[at]].real)
                if size <= 1 / _LARGEST or (best is not None and 1 / size > best.size * 1.01):
                    continue
                found = self._refined(G, float(self.omega[at]), float(self.omega[at + 1]), complex(values[at + 1, k]))
                if found is not None and (best is None or found[0] < best.size):
                    best = self._made(found[0], shares, found[1])
        return best

    def _made(self, size: float, shares: NDArray[np.float64], omega: float) -> Crossing:
        gains, one = self.base + size * self._gains(shares), self.upper != 0
        return Crossing(float(np.abs(gains[one] / self.upper[one]).max()), shares, size, omega)

    def _refined(self, G: NDArray[np.float64], low: float, high: float, start: complex) -> tuple[float, float] | None:
        """The factor and the frequency of one crossing, by secants between ends of two signs (the Illinois method)."""

        def value(omega: float, near: complex) -> complex:
            """The eigenvalue of ``-H(i omega) G`` next to one that was found before: 1 at a crossing."""
            found = np.linalg.eigvals(-self._response(np.array([1j * omega]))[0] * G)
            return complex(found[np.abs(found - near).argmin()])

        omega, near, new = low, start, start
        below, above, last = start.imag, value(high, start).imag, 0
        for _ in range(_NEWTONS):
            if below == above or abs(new.imag) <= _EXACT * abs(new) or high - low <= _EXACT * high:
                break
            omega = min(max((low * above - high * below) / (above - below), low), high)
            new = value(omega, near)
            if new.imag * start.imag > 0:
                low, near, below, above, last = omega, new, new.imag, above / (2 if last < 0 else 1), -1
            else:
                high, above, below, last = omega, new.imag, below / (2 if last > 0 else 1), 1
        return (1 / new.real, omega) if new.real > 1 / _LARGEST else None

    def best(self) -> Crossing | None:
        """The smallest factor found: at vertices, some random directions, and from the best of these on."""
        count, random = len(self.blocks), np.random.default_rng(7)
        lowest = np.where(self.signed, -1.0, 0.0)
        ends = product(*((1.0, 0.0, -1.0) if signed else (1.0, 0.0) for signed in self.signed))
        tried = [np.array(v) for v in islice((v for v in ends if any(v)), _MOST_PATTERNS)]
        tried += list(lowest + (1 - lowest) * random.random((_RANDOM if count > 1 else 0, count)))
        found = list[Crossing]()
        for shares in tried:
            checkpoint()
            one = self.crossing(shares / np.abs(shares).max())
            found += [one] if one is not None else []
        found.sort(key=lambda one: one.factor)
        for start in found[:_TIMES_FINER] if count > 1 else ():

            def factor(shares: NDArray[np.float64]) -> float:
                """The factor of a crossing of gains in these proportions, which is kept; a large number without one."""
                checkpoint()
                inside = np.clip(shares, lowest, 1.0)
                size = np.abs(inside).max()
                one = self.crossing(inside / size) if size > 0 else None
                if one is not None:
                    found.append(one)
                return _LARGEST if one is None else one.factor

            optimize.minimize(factor, start.shares, method="Nelder-Mead", options={"maxfev": 40 * count, "xatol": 1e-9})
        return min(found, key=lambda one: one.factor, default=None)

    def proofs(self, one: Crossing, channels: int) -> Iterator[tuple[float, dict[str, Any]]]:
        """Factors, and proofs that gains of the classes of these have a root on the axis.

        ``channels``: of so many, the first, the gains are stated.
        """
        G = one.size * self._gains(one.shares)
        for width in _WIDTHS:
            sides = ((self.base + G * (1 + step)).tolist()[:channels] for step in (-width, width))
            ends = [[Fraction(v) for v in side] for side in sides]
            factor = one.factor * (1 + 2 * width)
            if one.omega == 0:
                yield factor, {"method": "late-gains", "gains": [*map(str, ends[1])]}
                continue
            eye, step = np.eye(len(G)), 1e-6 * one.omega
            left, here, right = self.transfer(1j * np.array([one.omega - step, one.omega, one.omega + step]))
            left, right = (np.linalg.det(eye + h * (self.base + G)) for h in (left, right))
            more, fewer = (np.linalg.det(eye + here * (self.base + G * (1 + v))) for v in (1e-6, -1e-6))
            here, by_factor = np.linalg.det(eye + here * (self.base + G)), more - fewer
            slope, turn = (right - left) / (2 * step), by_factor / 2e-6  # per relative change of the factor
            turn = turn / abs(turn) if abs(turn) > 0 else 1.0
            around = np.prod(1j * one.omega - self.poles) ** len(G)  # the checker multiplies by det(s - A) each column
            pull = abs((slope * np.conj(turn)).imag)
            if pull == 0 or not np.isfinite(pull) or not np.isfinite(here):
                return
            reach = 0.25 * width * abs(by_factor / 2e-6) / abs(slope)
            turn = turn * around / abs(around)
            band = [Fraction(one.omega - reach), Fraction(one.omega + reach)]
            yield (
                factor,
                {
                    "method": "late-crossing",
                    "gains": [[*map(str, row)] for row in ends],
                    "frequencies": [*map(str, band)],
                    "turn": [str(Fraction(f"{v:.6g}")) for v in (turn.real, -turn.imag)],
                },
            )


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
        for step in _MATRIX_STEPS:
            alpha = Fraction(high * (1 + step))
            yield alpha, self._exact(alpha, self._grown(float(alpha), shape)[1])

    def _first(self, starts: list[Reals]) -> tuple[float, Reals | None]:
        """A factor at which something grows, with the shape of the gains."""
        factor = 1 / _LARGEST_GAIN
        while factor <= _LARGEST_GAIN:
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
