"""Continuous functions that are affine between knots, fitted by reweighted least squares without outliers."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from analysis.measured.noise import Noise, noise_of
from analysis.measured.outlying import outlying
from lure.values import by_value

Array = NDArray[np.float64]
_TUKEY, _HUBER = 4.685, 1.345
_HUBER_ROUNDS, _ROUNDS = 3, 12


@by_value
@dataclass(frozen=True, kw_only=True, eq=False)  # without slots, for the cached property
class Hats:
    """Points and knots: the value of the function at a point is a mean of its values at two knots.

    Attributes
    ----------
    x, y : ndarray
        (n,) points, of order one.
    knots : ndarray
        (K + 1,) ascending, 0 among them.
    free : bool
        Whether the value at the knot 0 is fitted, instead of being 0.
    """

    x: Array
    y: Array
    knots: Array
    free: bool

    @cached_property
    def places(self) -> tuple[NDArray[np.intp], Array]:
        """The piece of each point, and how far along it the point lies."""
        return places(self.x, self.knots)

    @property
    def parameters(self) -> int:
        """How many values are fitted."""
        return int(self.knots.size - (not self.free))

    def solved(self, weights: Array) -> tuple[Array, Array]:
        """Values at the knots by weighted least squares, and the inverse of the normal matrix."""
        (index, share), size = self.places, self.knots.size
        a, b = 1 - share, share
        diagonal = np.bincount(index, weights * a**2, size) + np.bincount(index + 1, weights * b**2, size)
        beside = np.bincount(index, weights * a * b, size)[:-1]
        normal = np.diag(diagonal) + np.diag(beside, 1) + np.diag(beside, -1)
        right = np.bincount(index, weights * a * self.y, size) + np.bincount(index + 1, weights * b * self.y, size)
        fitted = np.arange(size) if self.free else np.flatnonzero(self.knots)
        inverse = np.zeros((size, size))
        inverse[np.ix_(fitted, fitted)] = np.linalg.pinv(normal[np.ix_(fitted, fitted)], rcond=1e-13, hermitian=True)
        return inverse @ right, inverse

    def leverages(self, inverse: Array, weights: Array) -> Array:
        """How much of its own value each point determines."""
        index, share = self.places
        a, b = 1 - share, share
        quadratic = a**2 * inverse[index, index] + 2 * a * b * inverse[index, index + 1]
        return np.asarray(np.clip(weights * (quadratic + b**2 * inverse[index + 1, index + 1]), 0, 0.9))

    def at(self, values: Array) -> Array:
        """The function at the points."""
        index, share = self.places
        return np.asarray(values[index] + share * np.diff(values)[index])


@by_value
@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class HatFit:
    """A fit: values at the knots, their covariance, the noise, which points were kept, and residuals in deviations."""

    hats: Hats
    values: Array
    covariance: Array
    noise: Noise
    kept: NDArray[np.bool_]
    scores: Array

    @property
    def weights(self) -> Array:
        """One over the variance of each point, 0 for outliers."""
        return np.asarray(self.kept / self.noise(self.hats.at(self.values)) ** 2)


def hat_fit(hats: Hats) -> HatFit:
    """Least squares with weights from the residuals: large ones are turned down, and outliers at last left out.

    Parameters
    ----------
    hats : Hats
        Points and knots.
    """
    weights, robust = np.ones_like(hats.x), np.ones_like(hats.x)
    values, noise, scores = np.zeros_like(hats.knots), Noise(constant=1.0, proportional=0.0), robust
    for turn in range(_ROUNDS):
        previous = values
        values, inverse = hats.solved(weights * robust)
        mean = hats.at(values)
        noise = noise_of(hats.y - mean, mean, parameters=hats.parameters)
        weights = 1 / noise(mean) ** 2
        scores = (hats.y - mean) * np.sqrt(weights / (1 - hats.leverages(inverse, weights * robust)))
        size = np.abs(scores)
        if turn < _HUBER_ROUNDS:
            robust = np.minimum(1.0, _HUBER / np.maximum(size, 1e-300))
        else:
            robust = np.maximum(1 - (size / _TUKEY) ** 2, 0.0) ** 2
        if turn > _HUBER_ROUNDS and np.abs(values - previous).max() < 1e-6:
            break
    return _final(hats, values, noise, scores)


def _final(hats: Hats, values: Array, noise: Noise, scores: Array) -> HatFit:
    """Plain weighted least squares through the points that are no outliers."""
    covariance, kept = np.zeros((values.size, values.size)), np.ones(hats.x.size, dtype=np.bool_)
    for _ in range(3):
        kept = ~outlying(hats.x, scores, parameters=hats.parameters)
        weights = 1 / noise(hats.at(values)) ** 2
        values, inverse = hats.solved(weights * kept)
        residuals = (hats.y - hats.at(values)) * np.sqrt(weights)
        degrees = max(1, int(kept.sum()) - hats.parameters)
        scale = max(float(np.sqrt(np.sum(kept * residuals**2) / degrees)), 1e-150)
        noise = Noise(constant=noise.constant * scale, proportional=noise.proportional * scale)
        covariance = inverse * scale**2
        leverages = hats.leverages(inverse, weights * kept)
        scores = residuals / (scale * np.sqrt(np.where(kept, 1 - leverages, 1 + leverages)))
    return HatFit(hats=hats, values=values, covariance=covariance, noise=noise, kept=kept, scores=scores)


def misfit(coarse: Hats, fine: HatFit) -> float:
    """p-value: how likely noise alone makes the finer function fit as much better than the coarser as it does.

    Parameters
    ----------
    coarse : Hats
        Fewer knots.
    fine : HatFit
        The fit with more, whose noise and outliers are taken for both.
    """
    from scipy.stats import f as fisher

    extra = fine.hats.parameters - coarse.parameters
    weights = fine.weights
    degrees = int(fine.kept.sum()) - fine.hats.parameters
    if extra <= 0 or degrees <= 0:
        return 1.0
    before, after = (
        float(np.sum(weights * (hats.y - hats.at(hats.solved(weights)[0])) ** 2)) for hats in (coarse, fine.hats)
    )
    rounding = 1e-24 * float(np.sum(weights * coarse.y**2))
    if after <= rounding:
        return 1.0 if before <= rounding else 0.0
    return float(fisher.sf(max(before - after, 0.0) / extra / (after / degrees), extra, degrees))


def places(x: Array, knots: Array) -> tuple[NDArray[np.intp], Array]:
    """The piece of each point, and how far along it the point lies; the outer pieces reach on.

    Parameters
    ----------
    x, knots : ndarray
        Points, and ascending knots.
    """
    index = np.clip(np.searchsorted(knots, x, side="right") - 1, 0, knots.size - 2)
    return index, np.asarray((x - knots[index]) / (knots[index + 1] - knots[index]))
