"""A block along its stability boundary: where to evaluate it so that the curve looks as it is."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.analysis.questions.problem import plant_given
from lure.errors import InputError
from lure.extensions import extension
from lure.plants.block import LinearBlock, Plant, StructuredPlant
from lure.plants.delay import DelayPlant
from lure.plants.family import PlantFamily
from lure.plants.frequency_data import FrequencyData
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace

# Frequencies for drawing a response: dense where the curve turns, never the ground of a verdict.

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


# A block along its stability boundary: where to evaluate it so that the curve looks as it is.

POINTS = 1500
_DENSE = 150  # states beyond which a point costs so much that fewer are drawn
Formula = RationalPlant | DelayPlant | StateSpace
Drawable = Formula | FrequencyData | StructuredPlant


@dataclass(frozen=True, eq=False, slots=True)
class OnAxis:
    """A block along its stability boundary: ``H(i omega)``, or ``H(e^(i omega))`` with ``omega`` in rad per sample."""

    block: Formula

    def transfer(self, s: ArrayLike) -> NDArray[np.complex128]:
        """``H`` at ``s = i omega``, or at ``z = exp(s)``."""
        points = np.asarray(s, dtype=complex)
        return self.block.transfer(np.exp(points) if self.discrete else points)

    @property
    def discrete(self) -> bool:
        """Whether time is discrete."""
        return self.block.dt is not None

    def frequencies(self) -> NDArray[np.float64]:
        """Frequencies at which the curve looks as it is: a logarithmic grid, refined around every resonance."""
        if isinstance(self.block, StateSpace):
            roots = np.linalg.eigvals(self.block.A)
            points, across = (POINTS, 101) if self.block.order <= _DENSE else (POINTS // 3, 21)
        else:
            roots = np.roots([float(c) for c in self.block.denominator])
            points, across = POINTS, 101
        if self.discrete:
            roots = np.log(roots[np.abs(roots) > 1e-6])
            low, high = 1e-3, math.pi
        else:
            largest = float(np.max(np.abs(roots), initial=0.0))
            sizes = [size for size in np.abs(roots).tolist() if size > 1e-9 * min(1.0, largest)] or [1.0]
            low, high = 1e-2 * min(sizes), 1e2 * max(sizes)
        width = np.tan(np.linspace(-1.5, 1.5, across))
        near = [abs(root.imag) + abs(root.real) * width for root in roots.tolist() if root.imag]
        if isinstance(self.block, DelayPlant):  # a phase that turns evenly in omega
            longest = max(float(delay) for delay, _ in self.block.terms)
            near.append(np.linspace(low, min(high, 20 * math.pi / longest) if longest else high, POINTS))
        omega = np.unique(np.concatenate([np.geomspace(low, high, points), *near]))
        return np.asarray(omega[(omega >= low) & (omega <= high)])


def drawable(system: object) -> Drawable:
    """The block that a drawing is about: what :func:`lure.as_plant` makes of it, or the block of a loop.

    Infinite values of a measurement are left out.

    ``system``: whatever :func:`lure.as_plant` takes, a ``StructuredPlant`` such as a rod, or a loop with a ``block``;
    of plants with parameters in a box the one in its middle is drawn.

    Raises
    ------
    InputError
        It is no linear block.
    """
    from lure.files.system import LoopSystem
    from lure.loop import Loop

    if isinstance(system, Loop | LoopSystem):
        system = system.block
    block = plant_given(system)
    if isinstance(block, PlantFamily):
        return block.central
    return _finite_part(block) if isinstance(block, FrequencyData) else block


def _finite_part(data: FrequencyData) -> FrequencyData:
    """The measurement without the frequencies at which it is infinite: a pole was met there."""
    good = np.isfinite(data.response)
    if good.all():
        return data
    if not good.any():
        raise InputError(f"{data}: none of them is finite; give a response that can be drawn")
    error = None if data.error is None else data.error[good]
    return FrequencyData(data.omega[good], data.response[good], data.dt, error)


def axis_values(block: Drawable, omega: ArrayLike | None) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
    """Frequencies [rad/s] and the values of ``H`` there: ``H(i omega)``, in discrete time ``H(e^(i omega dt))``.

    Parameters
    ----------
    block : Drawable
        The block.
    omega : array_like or None
        (m,) frequencies, increasing and positive, below ``pi/dt`` in discrete time; None for a grid that is refined
        around every resonance.  A measured response has its own, and takes no other.

    Returns
    -------
    omega, values : ndarray
        (m,) each; nan where a pole is met.

    Raises
    ------
    InputError
        The frequencies are no such list.
    """
    if isinstance(block, FrequencyData):
        if omega is not None:
            raise InputError(f"omega was given for {block}: measured data have their own frequencies; leave omega out")
        return block.omega, block.response
    step = 1.0 if block.dt is None else float(block.dt)
    if omega is not None:
        at = _frequencies(omega, math.inf if continuous(block) else math.pi / step)
    elif isinstance(block, StructuredPlant):
        at = drawing_frequencies(block)
    else:
        at = OnAxis(block).frequencies() / step
    values = block.transfer(1j * at) if continuous(block) else block.transfer(np.exp(1j * at * step))
    return at, np.where(np.isfinite(values), values, complex(np.nan, np.nan))


def continuous(block: Drawable) -> bool:
    """Whether time is continuous."""
    return block.dt is None


def _frequencies(omega: ArrayLike, highest: float) -> NDArray[np.float64]:
    try:
        at = np.array(omega, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(f"omega is no list of numbers ({error}); give frequencies in rad/s") from None
    good = at.ndim == 1 and at.size >= 2 and bool(np.isfinite(at).all()) and at[0] > 0 and bool((np.diff(at) > 0).all())
    if not good or at[-1] > highest * (1 + 1e-12):
        limit = "" if math.isinf(highest) else f", up to pi/dt = {highest:g}"
        raise InputError(f"omega must be at least two positive, increasing frequencies in rad/s{limit}")
    return at
