"""How much one reading scatters: a constant part and a part in proportion to the load."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_TO_DEVIATION = 1.4826022185056018  # of a median absolute value, for normal errors
_SCALE = 1.2533141373155001  # of a mean absolute value, likewise: sqrt(pi/2)
_FLOOR = 0.05
_ROUNDS = 4


@dataclass(frozen=True, kw_only=True, slots=True)
class Noise:
    """Standard deviation ``constant + proportional |f|`` of a reading about the mean law ``f``.

    Attributes
    ----------
    constant : float
        [unit of the load].
    proportional : float
        [-].
    """

    constant: float
    proportional: float

    def __call__(self, mean: Array) -> Array:
        """Standard deviation [unit of the load] where the law has the value ``mean``, elementwise."""
        return np.asarray(self.constant + self.proportional * np.abs(mean))


def noise_of(residuals: Array, mean: Array, *, parameters: int) -> Noise:
    """The noise behind residuals, little moved by outliers.

    The two parts are fitted to the absolute residuals, of which those beyond three deviations are cut down to three.
    The constant part is at least 5 % of the whole, so that no reading counts as exact.

    Parameters
    ----------
    residuals, mean : ndarray
        (n,) residuals and the law they are about [unit of the load].
    parameters : int
        How many were fitted: residuals are smaller than errors by the square root of ``1 - parameters/n``.
    """
    lost = np.sqrt(residuals.size / max(residuals.size - parameters, 1))
    size = np.abs(residuals) * lost
    typical = max(
        _TO_DEVIATION * float(np.median(size)), 1e-14 * float(np.abs(mean).max()), 1e-14 * float(size.max()), 1e-150
    )
    level = np.abs(mean)
    deviation = np.full_like(size, typical)
    constant, proportional = typical, 0.0
    for _ in range(_ROUNDS):
        cut = np.minimum(_SCALE * size, 3 * deviation) / deviation
        constant, proportional = _positive(1 / deviation, level / deviation, cut)
        floor = _FLOOR * (constant + proportional * float(np.mean(level)))
        constant = max(constant, floor, 1e-3 * typical)
        deviation = constant + proportional * level
    return Noise(constant=float(constant), proportional=float(proportional))


def _positive(first: Array, second: Array, sizes: Array) -> tuple[float, float]:
    """The nonnegative combination of two nonnegative columns that is closest to nonnegative sizes, by least squares.

    Where the free minimum has a negative part, the least is at the edge of the quadrant, on the other column alone.
    """
    scale = max(float(np.sqrt(first @ first)), 1e-300), max(float(np.sqrt(second @ second)), 1e-300)
    a, b = float(first @ sizes) / scale[0], float(second @ sizes) / scale[1]
    both = float(first @ second) / (scale[0] * scale[1])
    one, other = a - both * b, b - both * a
    if one <= 0 or other <= 0 or both >= 1:
        return (a / scale[0], 0.0) if a >= b else (0.0, b / scale[1])
    return one / (1 - both**2) / scale[0], other / (1 - both**2) / scale[1]
