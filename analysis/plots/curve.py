"""What Nyquist and Popov plots share: the curve, its unit, and the arrow that shows a margin."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from analysis.plots.frequencies import drawing_frequencies
from analysis.plots.style import GREEN, VERMILLION
from lure.block import Block
from lure.errors import InputError
from lure.upwind import UpwindScheme
from lure.waves import RodBlock

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FAR = 30.0
"""A boundary further away than so many widths of the curve is named in the plot, not drawn."""

_ROUNDING = 1e-13
"""An imaginary part that is a smaller share of its value is drawn as 0."""


def curve(block: Block, omega: ArrayLike | None) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
    """Frequencies [rad/s] and ``H(i omega)`` there, nan at a pole so that the drawn curve breaks."""
    frequencies = drawing_frequencies(block) if omega is None else np.asarray(omega, dtype=float)
    if frequencies.ndim != 1 or frequencies.size < 2 or not frequencies[0] > 0:
        raise InputError("omega must be a list of at least two positive frequencies [rad/s]")
    values = block.transfer(1j * frequencies)
    values = np.where(np.abs(values.imag) < _ROUNDING * np.abs(values), values.real, values)
    return frequencies, np.where(np.isfinite(values), values, complex(np.nan, np.nan))


def unit(block: Block, *, per_second: bool = False) -> str:
    """Unit of ``H``, or of ``omega H``."""
    if isinstance(block, RodBlock | UpwindScheme):
        return "m/(Pa s)" if per_second else "m/Pa"
    return "unit of σ / (unit of μ · s)" if per_second else "unit of σ / unit of μ"


def upper_end(block: Block) -> str:
    """The letter of the sector's upper end: ``k``, but for the rod, whose ``k`` is the dashpot."""
    return "κ" if isinstance(block, RodBlock | UpwindScheme) else "k"


def boundary_name(axes: Axes, boundary: float, letter: str, *, above: bool) -> None:
    """The name of the point on the real axis, on the forbidden side of it unless that is too narrow."""
    low, high = axes.get_xlim()
    tight = boundary - low < 0.15 * (high - low)  # no room on the left
    text, offset = f"−1/{letter}" if boundary else "0", (5 if tight else -5, 4 if above else -5)
    axes.annotate(text, (boundary, 0.0), xytext=offset, textcoords="offset points", color=VERMILLION,
                  ha="left" if tight else "right", va="bottom" if above else "top")  # fmt: skip


def margin_arrow(axes: Axes, ends: tuple[float, float], height: float) -> None:
    """A double arrow from the boundary to the curve, unless they are too close to see it."""
    low, high = axes.get_xlim()
    if abs(ends[1] - ends[0]) < 0.03 * (high - low):
        return
    axes.annotate(
        "",
        (ends[0], height),
        xytext=(ends[1], height),
        arrowprops={"arrowstyle": "<->", "color": GREEN, "lw": 1.0, "shrinkA": 0, "shrinkB": 0},
    )
    middle = (0.5 * (ends[0] + ends[1]), height)
    label = "margin" if ends[1] > ends[0] else "short by"
    axes.annotate(label, middle, xytext=(0, 3), textcoords="offset points", ha="center", color=GREEN)
