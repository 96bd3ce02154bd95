"""The obstacle in a plot of the end of the rod: a line, or a remark where it is too far away for the motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from analysis.plots.style import VERMILLION, note, number, padded

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_FAR = 6.0


def draw_obstacle(
    axes: Axes,
    gap: float,
    span: tuple[float, float],
    *,
    corner: str = "upper left",
    **line: Any,  # noqa: ANN401  (what matplotlib takes)
) -> bool:
    """Draw it at ``u = gap`` [m] and fit the axis to it and the motion; False if it is only named.

    Parameters
    ----------
    axes : Axes
        Of ``u`` [m].
    gap : float
        Where it is [m].
    span : (float, float)
        Least and largest displacement [m].
    corner : str
        For the remark.
    **line
        Of the line, as for ``axhline``.
    """
    low, high = span
    near = gap - high <= _FAR * (high - low)
    if near:
        axes.axhline(gap, color=VERMILLION, label=f"obstacle at {number(gap)} m", **line)
        axes.set_ylim(*padded(min(low, gap), max(high, gap), 0.1))
    else:
        axes.set_ylim(*padded(low, high, 0.15))
        note(axes, f"obstacle at {number(gap)} m, outside this view", corner=corner)
    return near
