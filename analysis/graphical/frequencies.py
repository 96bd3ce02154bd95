"""Frequencies for drawing a response: dense where the curve turns, never the ground of a verdict."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from lure.errors import InputError
from lure.extensions import extension
from lure.plants.block import LinearBlock, Plant

_PER_DECADE = 60
_ACROSS = np.tan(np.linspace(-1.5, 1.5, 51))


def drawing_frequencies(block: Plant) -> NDArray[np.float64]:
    """Increasing frequencies at which a response curve of ``block`` looks as it is.

    A logarithmic grid, refined around every resonance in proportion to its width: a peak of the paper's rod is about
    ``1e-4`` of the distance to the next, and an even grid does not see it.  The rod has infinitely many; 24 are drawn.

    Parameters
    ----------
    block : UpwindScheme, RodPlant or LinearBlock
        The block; a ``LinearPlant`` costs one dense eigenvalue computation.

    Returns
    -------
    ndarray
        (n,) [rad/s], positive, ``n`` a few thousand.

    Raises
    ------
    InputError
        The block is of another type: its resonances are not known; give the frequencies.

    Notes
    -----
    For the eye only.  A criterion is decided over all frequencies, without a grid.
    """
    poles, low, high = _extent(block)
    low = 1e-2 * low
    grid = np.geomspace(low, high, max(2, round(_PER_DECADE * math.log10(high / low))))
    peaks = [pole for pole in poles if pole.imag and pole.real]
    distance = min((abs(pole.imag) for pole in peaks), default=0.0)
    omega = np.unique(np.concatenate([grid, *(_around(pole, distance) for pole in peaks)]))
    return np.asarray(omega[(omega >= low) & (omega <= high)])


def _around(pole: complex, distance: float) -> NDArray[np.float64]:
    """Points about a resonance: even in angle across the peak, then logarithmic up to ``distance`` from it."""
    width = abs(pole.real)
    flank = np.geomspace(min(14 * width, 0.5 * distance), distance, 16)
    return np.asarray(abs(pole.imag) + np.concatenate((-flank, width * _ACROSS, flank)))


def _extent(block: Plant) -> tuple[list[complex], float, float]:
    """Resonances to refine, and the slowest and fastest rates [1/s] the grid must span."""
    special = extension("resonances", block)
    if special is not None:
        found: tuple[list[complex], float, float] = special(block)
        return found
    if isinstance(block, LinearBlock):
        poles = [complex(pole) for pole in np.linalg.eigvals(block.dense())]
        sizes = [abs(pole) for pole in poles]
        sizes = [size for size in sizes if size > 1e-9 * max(sizes)] or [1.0]
        return poles, min(sizes), 100.0 * max(sizes)
    raise InputError(f"the resonances of a {type(block).__name__} are not known; give the frequencies to draw")
