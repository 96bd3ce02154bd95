"""What the drawings share: the figure inside a page, the words for a range of frequencies, a number of the caller's."""

from __future__ import annotations

import hashlib
import html
import math
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lure.delay import DelayBlock
from lure.errors import InputError
from lure.exact import exact_number
from lure.frequency_data import FrequencyData
from lure.rational import RationalBlock
from lure.state_space import StateSpaceBlock
from lure.upwind import UpwindScheme

if TYPE_CHECKING:
    from analysis.graphical.axis import Drawable
    from analysis.plots.export import Draw

_LONGEST = 160
ROD = "the verdict about the rod itself rests on its energy theorem, not on this drawing: lure report"


def with_figure(draw: Draw, table: str, *, alt: str) -> str:
    """A figure as inline SVG, on white, above a table.

    Parameters
    ----------
    draw : callable
        Draws on the axes it is given as ``ax``.
    table : str
        HTML.
    alt : str
        What the figure shows, for who cannot see it; also what its identifiers are salted with.
    """
    from analysis.plots.export import render

    name = "figure-" + hashlib.sha256((alt + table).encode()).hexdigest()[:12]
    svg = render(draw, name=name, size=(5.4, 3.8)).svg
    label = f'role="img" aria-label="{html.escape(alt)}" style="max-width:100%;height:auto"'
    svg = svg[svg.index("<svg") :].replace("<svg", f"<svg {label}", 1)
    return f'<figure style="margin:0;max-width:40em">{svg}</figure>{table}'


def block_text(block: Drawable) -> str:
    """The block in a few words: its formula if that is short.

    Parameters
    ----------
    block : Drawable
        The block.
    """
    if isinstance(block, RationalBlock | DelayBlock):
        text = str(block)
        return f"H = {text}" if len(text) <= _LONGEST else f"H of order {len(block.denominator) - 1}"
    if isinstance(block, FrequencyData):
        return "a measured response"
    if isinstance(block, StateSpaceBlock):
        return str(block)
    return f"the scheme with {block.cells} cells" if isinstance(block, UpwindScheme) else "the rod"


def span_text(omega: NDArray[np.float64]) -> str:
    """Where a curve was evaluated.

    Parameters
    ----------
    omega : ndarray
        (m,) frequencies [rad/s].
    """
    return f"at {omega.size} frequencies from {omega[0]:.4g} to {omega[-1]:.4g} rad/s"


def bound(value: object, name: str) -> float | Fraction:
    """A bound of a sector as it is given, exact unless it is ``inf``.

    Parameters
    ----------
    value : object
        A number.
    name : str
        What it is, for the error.

    Raises
    ------
    InputError
        It is no number.
    """
    if isinstance(value, float) and value == math.inf:
        return value
    return exact_number(value, name)


def upper_end(k: object, lower: Fraction) -> float | Fraction:
    """The upper end of a sector, which lies above the lower one.

    Parameters
    ----------
    k : object
        A number.
    lower : Fraction
        The lower end.

    Raises
    ------
    InputError
        It is no number, or does not lie above.
    """
    end = bound(k, "k")
    if end <= lower:
        raise InputError(f"k is {float(end):g}; give the upper end of a sector, above its lower end {float(lower):g}")
    return end
