"""Two axes one above the other in the place of one, whatever lays the figure out."""

from __future__ import annotations

from typing import TYPE_CHECKING

from analysis.plots.style import axes_or_new

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_GAP = 0.03  # share of the height of the place


def panels(ax: Axes | None, share: float) -> tuple[Axes, Axes]:
    """``ax``, made less high, and new axes below it that share its x-axis.

    In the place of a subplot the two stand in a grid of their own, which constrained and tight layouts know how to
    treat; axes put down by hand are cut in two where they are.

    Parameters
    ----------
    ax : Axes or None
        Whose place the two take; None for a new figure.
    share : float
        Height of the axes below, relative to those above.
    """
    above = axes_or_new(ax)
    spec, figure = above.get_subplotspec(), above.figure
    if spec is None:
        box = above.get_position(original=True)
        low = share / (1 + share) * (1 - _GAP) * box.height
        high = box.height - low - _GAP * box.height
        above.set_position((box.x0, box.y1 - high, box.width, high))
        return above, figure.add_axes((box.x0, box.y0, box.width, low), sharex=above)
    grid = spec.subgridspec(2, 1, height_ratios=(1, share), hspace=2 * _GAP)
    above.set_subplotspec(grid[0])
    return above, figure.add_subplot(grid[1], sharex=above)
