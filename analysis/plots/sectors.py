"""A nonlinearity with the wedge of its sector, and its slope between its bounds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lure.analysis.nonlinearity.pieces import kinks, parsed
from lure.analysis.numerics.doubles import text_above, text_below
from lure.analysis.plots.style import BLUE, GREY, VERMILLION, axes_or_new, finish_axes, ink, note, padded
from lure.analysis.plots.style import number as number_sectors
from lure.analysis.verdict import Evidence
from lure.exact import nearest_double
from lure.record.values import exact_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lure.analysis.nonlinearity import Extreme, NonlinearityBounds
    from lure.analysis.nonlinearity.result import Quantity
    from lure.analysis.testing.result import Violation

# A nonlinearity that leaves its sector or its slope bounds, with the point where it does.

_POINTS = 1201


def plot_violation(violation: Violation, *, ax: Axes | None = None) -> Axes:
    """Draw a nonlinearity, the lines that bound it and the point or pair at which it breaks what was asserted of it.

    Parameters
    ----------
    violation : Violation
        From a :class:`lure.analysis.testing.NonlinearityViolation`.
    ax : matplotlib Axes, optional
        Where to draw; a new figure if not given.

    Returns
    -------
    Axes
        The axes, for further labels.
    """
    axes = axes_or_new(ax)
    low, high = violation.window
    x = np.linspace(low, high, _POINTS)
    phi = violation.values_where_defined(x)
    lines = [y0 + slope * (x - x0) for x0, y0, slope in violation.lines()]
    axes.axhline(0.0, color=GREY, lw=0.6)
    axes.axvline(0.0, color=GREY, lw=0.6)
    allowed = f"[{exact_text(violation.lower, 12)}, {exact_text(violation.upper, 12)}]".replace("inf", "∞")
    what = f"sector {allowed}" if violation.kind == "sector" else f"slopes {allowed}, from the first point"
    if len(lines) == 2:
        axes.fill_between(x, np.minimum(*lines), np.maximum(*lines), color=GREY, alpha=0.2, lw=0, label=what)
    for i, line in enumerate(lines):
        axes.plot(x, line, color=GREY, lw=1.0, ls="--", label=what if len(lines) == 1 and i == 0 else None)
    if violation.kind == "odd":
        axes.plot(x, -violation.values_where_defined(-x), color=GREY, ls="--", lw=1.2, label="−φ(−σ)")
    axes.plot(x, phi, color=BLUE, lw=1.5, label="φ(σ)")
    places = " and ".join(exact_text(sigma, 12) for sigma in violation.sigma)
    axes.plot(violation.sigma, violation.phi, "X", color=VERMILLION, ms=8, ls="none", label=f"fails at σ = {places}")
    axes.set_xlim(low, high)
    axes.set_ylim(*violation.heights(phi))
    return finish_axes(axes, "σ [unit of σ]", "φ [unit of φ]", legend="best")


Array = NDArray[np.float64]
_SECTORS_POINTS = 2001
_REACH = 2.0
_JUMP = 0.05


def plot_nonlinearity_sector(nonlinearity: object, found: NonlinearityBounds, *, ax: Axes | None = None) -> Axes:
    """``phi(sigma)`` with the lines of its sector, the wedge between them shaded and the attained points marked.

    Parameters
    ----------
    nonlinearity : nonlinearity of lure.nonlinearities, Expression, str or callable
        The nonlinearity that was bounded.
    found : NonlinearityBounds
        Its bounds; those of a sample are drawn dashed.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.  Without an interval the nonlinearity is drawn around the places where its bounds are
        attained.
    """
    axes = axes_or_new(ax)
    x = _abscissae(nonlinearity, found, "sector")
    values = _values(nonlinearity, x)
    pair = (found.sector_lower, found.sector_upper)
    bounds = [_bound(part, found) for part in pair]
    low, high = _window(values, [slope * x for slope in bounds if math.isfinite(slope)])
    edges = [np.clip(slope * x, low, high) if math.isfinite(slope) else _half(x, slope, low, high) for slope in bounds]
    axes.fill_between(x, edges[0], edges[1], color=BLUE, alpha=0.13, lw=0, label="sector")
    style = "-" if str(found.evidence) == "certified" else (0, (4, 2))
    for slope, text in _named(bounds).items():
        axes.plot(x, slope * x, color=BLUE, lw=1.0, ls=style, label=f"slope {text}", zorder=1.5)
    axes.plot(x, _broken(values, high - low), color=ink(axes), lw=1.6, label="φ(σ)")
    for part in pair:
        point = _point(part)
        if point is not None and point != 0.0 and x[0] <= point <= x[-1] and part.attained:
            axes.plot(point, nearest_double(part.inner) * point, "o", color=VERMILLION, ms=5, zorder=4)
    _finish(axes, found, "sector", (x, low, high))
    axes.set_ylabel("φ(σ)")
    return axes


def plot_nonlinearity_slope(nonlinearity: object, found: NonlinearityBounds, *, ax: Axes | None = None) -> Axes:
    """Difference quotients of ``phi`` between neighbouring points of the picture, and the bounds on all of them.

    Parameters
    ----------
    nonlinearity : nonlinearity of lure.nonlinearities, Expression, str or callable
        The nonlinearity that was bounded.
    found : NonlinearityBounds
        Its bounds; those of a sample are drawn dashed.
    ax : Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    Axes
        The axes drawn on.  A jump of the nonlinearity is a spike that leaves the picture.
    """
    axes = axes_or_new(ax)
    x = _abscissae(nonlinearity, found, "slope")
    slopes = np.diff(_values(nonlinearity, x)) / np.diff(x)
    middle = 0.5 * (x[1:] + x[:-1])
    pair = (found.slope_lower, found.slope_upper)
    bounds = [_bound(part, found) for part in pair if part is not None]
    finite = [slope for slope in bounds if math.isfinite(slope)]
    usual = slopes[np.abs(slopes) <= 5 * np.median(np.abs(slopes)) + 1.0] if len(finite) < len(bounds) else slopes
    low, high = _window(usual, [np.array(finite or [0.0])])
    if len(finite) == 2:
        axes.axhspan(finite[0], finite[1], color=BLUE, alpha=0.13, lw=0)
    style = "-" if str(found.evidence) == "certified" else (0, (4, 2))
    for slope, text in _named(bounds).items():
        axes.axhline(slope, color=BLUE, lw=1.0, ls=style, label=f"bound {text}", zorder=1.5)
    axes.plot(middle, _broken(slopes, high - low), color=ink(axes), lw=1.6, label="slope of φ")
    for part in pair:
        point = _point(part)
        if part is not None and point is not None and x[0] <= point <= x[-1] and part.attained:
            axes.plot(point, nearest_double(part.inner), "o", color=VERMILLION, ms=5, zorder=4)
    _finish(axes, found, "slope", (x, low, high))
    axes.set_ylabel("slope of φ")
    return axes


def _bound(part: Extreme, found: NonlinearityBounds) -> float:
    """What is drawn: what no value passes where that is certified, else the value reached."""
    return nearest_double(part.outer if found.evidence is Evidence.CERTIFIED else part.inner)


def _named(bounds: Sequence[float]) -> dict[float, str]:
    """The finite ones of a lower and an upper bound, each with its text, rounded outwards."""
    said = zip(bounds, (text_below, text_above), strict=False)
    return {bound: text(bound, 4).replace("-", "−") for bound, text in said if math.isfinite(bound)}


def _finish(axes: Axes, found: NonlinearityBounds, quantity: Quantity, frame: tuple[Array, float, float]) -> None:
    x, low, high = frame
    axes.axhline(0.0, color=ink(axes), lw=0.5, zorder=1)
    axes.axvline(0.0, color=ink(axes), lw=0.5, zorder=1)
    axes.set_xlim(float(x[0]), float(x[-1]))
    axes.set_ylim(low, high)
    axes.set_xlabel("σ")
    finish_axes(axes, legend="upper left")
    approached = [
        f"{side} {'' if '->' in str(part.at) else number_sectors(nearest_double(part.inner)) + ', '}{part.where}"
        for side, part in zip(("lower", "upper"), found.extremes(quantity), strict=True)
        if part is not None and not part.attained
    ]
    if approached:
        words = "; ".join(approached).replace("sigma", "σ").replace("->", "→").replace("-inf", "−∞").replace("inf", "∞")
        note(axes, f"not attained: {words}", corner="lower right")
    title = found.nonlinearity if len(found.nonlinearity) <= 50 else found.nonlinearity[:47] + "..."
    axes.set_title(f"{title} ({found.evidence})", fontsize="medium", loc="left")


def _abscissae(nonlinearity: object, found: NonlinearityBounds, quantity: Quantity) -> Array:
    """The interval, or what holds the places where the bounds are attained and the nonlinearity changes its branch."""
    if found.on is not None:
        return np.linspace(float(found.on[0]), float(found.on[1]), _SECTORS_POINTS)
    places = [abs(point) for part in found.extremes(quantity) if (point := _point(part)) is not None]
    places += [abs(x) for x in kinks(nonlinearity)]
    reach = _REACH * max((size for size in places if 1e-6 < size < 1e6), default=_REACH)
    return np.linspace(-reach, reach, _SECTORS_POINTS)


def _point(part: Extreme | None) -> float | None:
    """Where an extreme is taken, if that is a point."""
    if part is None or isinstance(part.at, str):
        return None
    at = (part.at, part.at) if isinstance(part.at, Fraction) else part.at
    return 0.5 * (nearest_double(at[0]) + nearest_double(at[1]))


def _values(nonlinearity: object, x: Array) -> Array:
    if isinstance(nonlinearity, str):
        nonlinearity = parsed(nonlinearity)
    with np.errstate(all="ignore"):
        variables = getattr(nonlinearity, "variables", None)
        if variables is not None and hasattr(nonlinearity, "exact"):
            from lure.expressions import Expression
            from lure.expressions.tree import names

            assert isinstance(nonlinearity, Expression), "only expressions have variables"
            return np.asarray(nonlinearity(**dict.fromkeys(names(nonlinearity.tree), x)), dtype=float) + 0.0 * x
        assert callable(nonlinearity), "it was bounded"
        try:
            found = np.asarray(nonlinearity(x), dtype=float)
        except (TypeError, ValueError):
            found = np.array([float(nonlinearity(float(point))) for point in x])
    return found


def _window(values: Array, lines: list[Array]) -> tuple[float, float]:
    """What the picture holds of the ordinate: the nonlinearity, and the lines as far as thrice its height."""
    finite = values[np.isfinite(values)]
    low, high = float(finite.min(initial=0.0)), float(finite.max(initial=0.0))
    room = 1.0 * (high - low) or 1.0
    for line in lines:
        low = min(low, max(float(line.min()), low - room))
        high = max(high, min(float(line.max()), high + room))
    return padded(low, high)


def _half(x: Array, slope: float, low: float, high: float) -> Array:
    """The edge of a wedge without a bound on one side."""
    return np.where((x > 0) == (slope > 0), high, low)


def _broken(values: Array, height: float) -> Array:
    """Values with a gap at every jump."""
    steps = np.abs(np.diff(values))
    usual = float(np.median(steps))
    jumps = np.flatnonzero(steps > max(_JUMP * height, 50 * usual))
    shown = values.copy()
    shown[jumps] = np.nan
    return shown
