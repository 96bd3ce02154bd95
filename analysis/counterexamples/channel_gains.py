"""Constant gains ``mu_i = -g_i sigma_i`` that destabilise a plant of several channels, in floating point."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product

from lure.analysis.deadline import checkpoint
from lure.arrays import NDArray, np, optimize

_ALL_VERTICES, _DRAWN, _SCALES, _POLISHED, _EVALUATIONS, _SEED = 6, 40, 90, 2, 80, 20261122
_BEYOND = (1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2)  # of the crossing, so that rounding does not hide it
_STILL = 1e-8  # of the largest eigenvalue
_ZOOMS, _POINTS, _REFINED = 9, 16, 12  # of a crossing: 16^-9 of the interval


@dataclass(frozen=True)
class GainSearch:
    """Gains ``g_i = l_i + tau_i (alpha u_i - l_i)``, ``0 <= tau_i <= 1``, of the classes ``[l_i, alpha u_i]``.

    Parameters
    ----------
    A, B, C, D : ndarray
        (n, n), (n, m), (m, n) and (m, m) [floating point].
    lower, upper : ndarray
        (m,) bounds at ``alpha = 1``.
    blocks : sequence of sequences of int
        The channels, counted from 0, that have equal gains.
    discrete : bool
        Whether in discrete time.
    critical : bool
        Whether the loop with the gains ``lower`` has an eigenvalue 0 (1).
    """

    A: NDArray[np.float64]
    B: NDArray[np.float64]
    C: NDArray[np.float64]
    D: NDArray[np.float64]
    lower: NDArray[np.float64]
    upper: NDArray[np.float64]
    blocks: Sequence[Sequence[int]]
    discrete: bool
    critical: bool = False

    def growth(self, gains: NDArray[np.float64]) -> NDArray[np.float64]:
        """The largest real part of the eigenvalues, in discrete time the largest modulus less 1, for gains (.., m).

        Parameters
        ----------
        gains : ndarray
            (.., m).
        """
        m = gains.shape[-1]
        G = gains[..., None] * np.eye(m)
        whole = np.eye(m) + self.D @ G
        whole = np.where(np.abs(np.linalg.det(whole))[..., None, None] < 1e-300, whole + 1e-9 * np.eye(m), whole)
        values = np.linalg.eigvals(
            self.A - self.B @ G @ np.linalg.solve(whole, np.broadcast_to(self.C, (*G.shape[:-2], *self.C.shape)))
        )
        found = np.abs(values) - 1 if self.discrete else values.real
        if self.critical:  # eigenvalues 0 that stay there with some gains refute nothing
            still = np.abs(values - self.discrete) < _STILL * np.abs(values).max(axis=-1, keepdims=True)
            found = np.where(still, -np.inf, found)
        return np.asarray(found.max(axis=-1))

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
            away = np.abs(points[:, None] - poles).min(axis=1) > 1e-6 * size
            points = np.append(points[away], np.exp(1j) if self.discrete else 1j * size)
        with np.errstate(all="ignore"):
            shifted = points[:, None, None] * np.eye(len(self.A)) - self.A + 1e-9 * np.eye(len(self.A))
            size = np.linalg.norm(self.C @ np.linalg.solve(shifted, self.B.astype(complex)) + self.D, axis=(1, 2)).max()
        unit = 1 / max(float(size) * float(np.abs(self.upper).max()), 1e-12)
        return np.asarray(unit * np.geomspace(1e-2, 1e6, _SCALES))

    def first(self, shape: NDArray[np.float64], scales: NDArray[np.float64]) -> float:
        """The smallest factor among the scales, sharpened, at which this shape of gains destabilises; inf if none.

        Parameters
        ----------
        shape : ndarray
            (m,) ``tau``.
        scales : ndarray
            Ascending factors.
        """
        unstable = np.flatnonzero(self.growth(self._gains(shape, scales)) > 0)
        if not unstable.size:
            return np.inf
        k = int(unstable[0])
        if not k:
            return float(scales[0])
        low, high = float(scales[k - 1]), float(scales[k])
        for _ in range(_ZOOMS):
            points = np.linspace(low, high, _POINTS + 1)
            j = int(np.flatnonzero(self.growth(self._gains(shape, points[1:])) > 0)[:1].sum()) + 1
            low, high = float(points[j - 1]), float(points[j])
        return high

    def found(self, least: float, most: float) -> tuple[float, NDArray[np.float64]] | None:
        """The smallest factor that was found with its ``tau``; None if there is none up to ``most``.

        Parameters
        ----------
        least, most : float
            The factors of interest; at ``least`` a class may be a single gain.
        """
        scales = self.scales()
        scales = np.unique(np.concatenate([scales, [max(least, 0.0) * (1 + 1e-9), 2 * max(least, 0.0)]]))
        scales = scales[(scales > least) & (scales < most)]
        scales = np.append(scales, most) if most < np.inf else scales
        shapes, rough = self.shapes(), []
        for shape in shapes:
            checkpoint()
            unstable = np.flatnonzero(self.growth(self._gains(shape, scales)) > 0)
            rough.append(float(scales[unstable[0]]) if unstable.size else np.inf)
        nearest = np.argsort(rough, kind="stable")[:_REFINED]
        reached = sorted((self.first(shapes[i], scales), tuple(shapes[i])) for i in nearest)
        best = reached[0]
        firsts = [block[0] for block in self.blocks]
        for start in [] if len(firsts) == 1 else [one for one in reached[:_POLISHED] if np.isfinite(one[0])]:
            near = start[0] * np.linspace(0.02, 1.02, 40)
            near = near[near > least]

            def factor(shape: NDArray[np.float64], near: NDArray[np.float64] = near) -> float:
                """The factor of a shape inside the box."""
                checkpoint()
                return min(self.first(self._spread(np.clip(shape, 0, 1)), near), float(near[-1]) * 2)

            polished = optimize.minimize(
                factor,
                np.array(start[1])[firsts],
                method="Nelder-Mead",
                options={"maxfev": _EVALUATIONS},
            )
            best = min(best, (float(polished.fun), tuple(self._spread(np.clip(polished.x, 0, 1)))))
        return (best[0], np.array(best[1])) if np.isfinite(best[0]) and best[0] <= most else None

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
