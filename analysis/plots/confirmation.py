"""The motion of the rod and that of its scheme, on the same axes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from analysis.plots.style import (
    BLUE,
    GREEN,
    GREY,
    LEGEND,
    PURPLE,
    VERMILLION,
    axes_or_new,
    finish_axes,
    padded,
    scaled_unit,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from analysis.confirmation import Confirmation, Side

Array = NDArray[np.float64]

_LEAST = 1e-9


def plot_both_ends(confirmation: Confirmation, *, ax: Axes | None = None) -> Axes:
    """Contact coordinate ``z`` of the rod and of its scheme, with ``zeta`` of each where it is claimed never to rise.

    Parameters
    ----------
    confirmation : Confirmation
        The two motions; either may be missing.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.
    """
    axes = axes_or_new(ax)
    drawn = []
    largest = max(float(np.abs(side.curves.z).max()) for side, *_ in _sides(confirmation))
    factor, unit = scaled_unit(largest, "m")
    for side, name, colour, deflated in _sides(confirmation):
        curves = side.curves
        dashes = "-" if name == "rod" else (0, (5, 1.5))
        axes.plot(curves.t, factor * curves.z, color=colour, ls=dashes, lw=1.1, label=f"z, {name}")
        drawn.append(factor * curves.z)
        if curves.zeta is not None:
            style = "--" if name == "rod" else ":"
            axes.plot(curves.t, factor * curves.zeta, color=deflated, ls=style, lw=1.5, label=f"ζ, {name}")
            drawn.append(factor * curves.zeta)
    low, high = min(float(values.min()) for values in drawn), max(float(values.max()) for values in drawn)
    if low < 0.0 < high:
        axes.axhline(0.0, color=GREY, lw=0.8)
    bottom, top = padded(low, high, 0.12)
    bottom -= 0.2 * (top - bottom)  # room for the legend
    axes.set_ylim(bottom, top)
    axes.set_yticks(_round_ticks(bottom, top), minor=False)
    axes.set_ylim(bottom, top)
    axes.set_xlim(0.0, _last(confirmation))
    axes.set_xlabel("t [s]")
    axes.set_ylabel(f"z and ζ [{unit}]", labelpad=1)
    axes.tick_params(axis="y", labelsize="small")
    finish_axes(axes)
    axes.legend(loc="lower center", ncols=2, **LEGEND)
    return axes


def plot_both_decays(confirmation: Confirmation, *, ax: Axes | None = None) -> Axes:
    """Energy of the rod and of its scheme, and the Popov-Lyapunov function of each, relative to their start.

    Parameters
    ----------
    confirmation : Confirmation
        The two motions without load; either may be missing.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on, logarithmic where the curves span more than a decade; what is below 1e-9 is cut off.
    """
    axes = axes_or_new(ax)
    shares = []
    for side, name, colour, second in _sides(confirmation):
        for values, label, hue, style in (
            (side.curves.energy, "energy", colour, "-" if name == "rod" else "--"),
            (side.curves.lyapunov, "V", second, "-." if name == "rod" else ":"),
        ):
            if values is not None and values[0] > 0.0:
                share = np.asarray(values / values[0])
                shares.append(share)
                axes.plot(side.curves.t, share, color=hue, ls=style, lw=1.3, label=f"{label}, {name}")
    if shares:
        low, high = min(float(share.min()) for share in shares), max(float(share.max()) for share in shares)
        if low < 0.1 * high:
            axes.set_yscale("log")
            axes.set_ylim(max(0.5 * low, _LEAST * high), 2.0 * high)
        else:
            axes.set_ylim(*padded(min(low, 0.0), high, 0.1))
        axes.legend(loc="best", ncols=2, **LEGEND)
    else:
        axes.text(0.5, 0.5, "no energy: the rod stays at rest", transform=axes.transAxes, ha="center", color=GREY)
    axes.set_xlim(0.0, _last(confirmation))
    axes.set_xlabel("t [s]")
    axes.set_ylabel("share of the first value")
    finish_axes(axes)
    return axes


def _sides(confirmation: Confirmation) -> list[tuple[Side, str, str, str]]:
    pairs = ((confirmation.rod, "rod", BLUE, GREEN), (confirmation.scheme, "scheme", VERMILLION, PURPLE))
    return [(side, name, colour, second) for side, name, colour, second in pairs if side is not None]


def _round_ticks(bottom: float, top: float) -> Array:
    """Ticks whose last digits are not those of a rounding error."""
    from matplotlib.ticker import MaxNLocator

    ticks = np.asarray(MaxNLocator(6, steps=[1, 2, 2.5, 5, 10]).tick_values(bottom, top), dtype=float)
    ticks = ticks[(ticks >= bottom) & (ticks <= top)]
    return np.array([float(f"{tick:.12g}") for tick in ticks]) if len(ticks) else ticks


def _last(confirmation: Confirmation) -> float:
    return max(float(side.curves.t[-1]) for side, *_ in _sides(confirmation))
