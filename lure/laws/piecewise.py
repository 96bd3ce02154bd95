"""Piecewise linear laws: saturation, relay with slope, dead zone, rectifiers, and any table of points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.errors import InputError
from lure.exact import Exact, exact_number
from lure.laws.graph import Graph
from lure.laws.law import assign, number_text, positive
from lure.sector import Sector, SlopeBounds


class GraphLaw:
    """What laws with a piecewise linear graph share; each sets ``graph`` when it is made and overrides nothing."""

    __slots__ = ()
    graph: Graph

    @property
    def sector(self) -> Sector:
        """The tightest sector, exact."""
        return self.graph.sector

    @property
    def slope_bounds(self) -> SlopeBounds:
        """The tightest slope bounds, exact."""
        return self.graph.slope_bounds

    @property
    def odd(self) -> bool:
        """Whether the law is odd, from its points."""
        return self.graph.odd

    @property
    def regularity(self) -> str:
        """Continuity in words."""
        return "piecewise linear, globally Lipschitz"

    @property
    def locally_lipschitz(self) -> bool:
        """True."""
        return True

    @property
    def breakpoints(self) -> tuple[Fraction, ...]:
        """Where the slope changes, in ascending order."""
        return self.graph.kinks

    def exact(self, sigma: Fraction) -> Fraction:
        """Value at an exact point, exactly."""
        return self.graph.exact(sigma)

    def __call__(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """Values ``phi(sigma)``, elementwise."""
        return self.graph(sigma)

    def slope(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """Derivative, elementwise; at a kink the one from the left."""
        return self.graph.slope(sigma)

    def primitive(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """``int_0^sigma phi``, elementwise."""
        return self.graph.primitive(sigma)


@dataclass(frozen=True, slots=True)
class Saturation(GraphLaw):
    r"""Saturation, ``phi(sigma) = min(max(gain sigma, lower_limit), limit)``; sector and slope ``[0, gain]``.

    Parameters
    ----------
    gain : int, float, Fraction or Decimal
        Slope between the limits, positive [unit of phi / unit of sigma].
    limit : int, float, Fraction or Decimal
        Largest value of ``phi``, positive [unit of phi].
    lower_limit : int, float, Fraction, Decimal or None
        Least value, at most 0; None for ``-limit``.  Any other value makes a law that is not odd.

    Raises
    ------
    InputError
        A parameter is not a finite number of the sign named.

    Examples
    --------
    >>> law = Saturation(gain=2, limit=1)
    >>> print(law, law.sector, law([-3.0, 0.25]), law.primitive(1.0))
    saturation min(max(2 sigma, -1), 1) [0, 2] [-1.   0.5] 0.75
    """

    gain: Fraction
    limit: Fraction
    lower_limit: Fraction
    graph: Graph = field(init=False, repr=False, compare=False)

    def __init__(self, *, gain: Exact = 1, limit: Exact = 1, lower_limit: Exact | None = None) -> None:
        g, top = positive(gain, "Saturation.gain"), positive(limit, "Saturation.limit")
        bottom = -top if lower_limit is None else exact_number(lower_limit, "Saturation.lower_limit")
        if bottom > 0:
            raise InputError(
                f"Saturation.lower_limit is {float(bottom):g}; give a number of at most 0, since phi(0) = 0"
            )
        points = [(bottom / g, bottom), (top / g, top)]
        assign(self, gain=g, limit=top, lower_limit=bottom, graph=Graph.through(points, Fraction(0), Fraction(0)))

    def __str__(self) -> str:
        g, low, high = (number_text(x) for x in (self.gain, self.lower_limit, self.limit))
        return f"saturation min(max({g} sigma, {low}), {high})"


def relay_with_slope(*, gain: Exact, level: Exact) -> Saturation:
    """A relay whose switch has the finite slope ``gain``, between the values ``-level`` and ``level``.

    The ideal relay, ``gain = inf``, is refused: it jumps at 0, so that the loop is a differential inclusion, for which
    none of the theorems here is stated.

    Parameters
    ----------
    gain : int, float, Fraction or Decimal
        Slope at 0, positive and finite.
    level : int, float, Fraction or Decimal
        Value of ``phi`` beyond ``level / gain``, positive.

    Raises
    ------
    InputError
        ``gain`` is infinite, or a parameter is not a positive number.
    """
    if isinstance(gain, float) and gain == math.inf:
        raise InputError(IDEAL_RELAY)
    return Saturation(gain=positive(gain, "relay with slope: gain"), limit=positive(level, "relay with slope: level"))


IDEAL_RELAY = (
    "the ideal relay jumps at sigma = 0 and its loop is a differential inclusion, for which the theorems here are not "
    "stated; give a relay with slope, with a finite gain and a level"
)


@dataclass(frozen=True, slots=True)
class DeadZone(GraphLaw):
    r"""Dead zone: 0 for ``|sigma| <= width``, then ``gain (|sigma| - width)`` with the sign of ``sigma``.

    Sector and slope ``[0, gain]``; the upper bound of the sector is approached as ``|sigma| -> inf``, never attained.
    Every ``|sigma| <= width`` gives ``phi = 0``, so a loop with a pole at 0 has a segment of equilibria.

    Parameters
    ----------
    width : int, float, Fraction or Decimal
        Half the width of the zone, positive [unit of sigma].
    gain : int, float, Fraction or Decimal
        Slope outside, positive [unit of phi / unit of sigma].

    Raises
    ------
    InputError
        A parameter is not a positive finite number.
    """

    width: Fraction
    gain: Fraction
    graph: Graph = field(init=False, repr=False, compare=False)

    def __init__(self, *, width: Exact = 1, gain: Exact = 1) -> None:
        w, g = positive(width, "DeadZone.width"), positive(gain, "DeadZone.gain")
        assign(self, width=w, gain=g, graph=Graph.through([(-w, Fraction(0)), (w, Fraction(0))], g, g))

    def __str__(self) -> str:
        return f"dead zone of |sigma| <= {number_text(self.width)}, then slope {number_text(self.gain)}"


@dataclass(frozen=True, slots=True)
class ReLU(GraphLaw):
    """Rectifier, ``phi(sigma) = gain max(sigma, 0)``; sector and slope ``[0, gain]``, not odd.

    Parameters
    ----------
    gain : int, float, Fraction or Decimal
        Slope for positive ``sigma``, positive.

    Raises
    ------
    InputError
        ``gain`` is not a positive finite number.
    """

    gain: Fraction
    graph: Graph = field(init=False, repr=False, compare=False)

    def __init__(self, *, gain: Exact = 1) -> None:
        g = positive(gain, "ReLU.gain")
        assign(self, gain=g, graph=Graph.through([], Fraction(0), g))

    def __str__(self) -> str:
        return f"ReLU {number_text(self.gain)} max(sigma, 0)"


@dataclass(frozen=True, slots=True)
class LeakyReLU(GraphLaw):
    """Two slopes that meet at 0; sector and slope bounds are the two, in order, and the law is not odd.

    Parameters
    ----------
    negative_slope, positive_slope : int, float, Fraction or Decimal
        Slopes left and right of 0, different from each other.

    Raises
    ------
    InputError
        A slope is not a finite number, or the two are equal.
    """

    negative_slope: Fraction
    positive_slope: Fraction
    graph: Graph = field(init=False, repr=False, compare=False)

    def __init__(self, *, negative_slope: Exact = Fraction(1, 100), positive_slope: Exact = 1) -> None:
        left = exact_number(negative_slope, "LeakyReLU.negative_slope")
        right = exact_number(positive_slope, "LeakyReLU.positive_slope")
        assign(
            self, negative_slope=left, positive_slope=right, graph=_bent(Graph.through([], left, right), "LeakyReLU")
        )

    def __str__(self) -> str:
        left, right = number_text(self.negative_slope), number_text(self.positive_slope)
        return f"leaky ReLU with slope {left} for sigma < 0 and {right} for sigma > 0"


@dataclass(frozen=True, slots=True)
class PiecewiseLinear(GraphLaw):
    r"""The continuous law through a table of points, straight between and outside them.

    Sector and slope bounds are the tightest and exact: between the points, 0 and infinity the chord slope
    ``phi(sigma)/sigma = s + c/sigma`` is monotone, so that its extremes are read off there.

    Parameters
    ----------
    points : sequence of (sigma, phi)
        At least one, ``sigma`` strictly ascending; the origin need not be listed but must lie on the graph.
    left_slope, right_slope : int, float, Fraction or Decimal
        Slopes left of the first and right of the last point: 0 keeps the last value.

    Raises
    ------
    InputError
        A number is not finite, the points are not in ascending order, ``phi(0)`` is not 0, or the graph is a straight
        line (which belongs into the block as a gain).

    Examples
    --------
    >>> law = PiecewiseLinear([(-1, -3), (2, 6), (4, 7)], left_slope=0, right_slope=Fraction(1, 2))
    >>> print(law.sector, law.slope_bounds, law.odd)
    [0, 3] [0, 3] False
    """

    points: tuple[tuple[Fraction, Fraction], ...]
    left_slope: Fraction
    right_slope: Fraction
    graph: Graph = field(init=False, repr=False, compare=False)

    def __init__(self, points: Sequence[Sequence[Exact]], *, left_slope: Exact, right_slope: Exact) -> None:
        left = exact_number(left_slope, "PiecewiseLinear.left_slope")
        right = exact_number(right_slope, "PiecewiseLinear.right_slope")
        table = _ascending(points)
        _demand_origin(table, left, right)
        graph = _bent(Graph.through(table, left, right), "PiecewiseLinear")
        assign(self, points=tuple(table), left_slope=left, right_slope=right, graph=graph)

    def __str__(self) -> str:
        listed = ", ".join(f"({number_text(x)}, {number_text(y)})" for x, y in self.points[:4])
        more = ", ..." if len(self.points) > 4 else ""
        left, right = number_text(self.left_slope), number_text(self.right_slope)
        return f"piecewise linear law through {listed}{more}, slope {left} to the left and {right} to the right"


def _bent(graph: Graph, name: str) -> Graph:
    if graph.is_line:
        gain = number_text(graph.slopes[0])
        raise InputError(f"{name} is the straight line phi = {gain} sigma; a linear gain belongs into the block")
    return graph


def _ascending(points: Sequence[Sequence[Exact]]) -> list[tuple[Fraction, Fraction]]:
    name = "PiecewiseLinear.points"
    if isinstance(points, str) or not isinstance(points, Sequence | np.ndarray) or len(points) == 0:
        raise InputError(f"{name} is {points!r:.60}; give a list of at least one pair [sigma, phi]")
    table: list[tuple[Fraction, Fraction]] = []
    for i, point in enumerate(points):
        if isinstance(point, str) or not isinstance(point, Sequence | np.ndarray) or len(point) != 2:
            raise InputError(f"{name}[{i}] is {point!r:.60}; give a pair [sigma, phi]")
        x, y = exact_number(point[0], f"{name}[{i}][0]"), exact_number(point[1], f"{name}[{i}][1]")
        table.append((x, y))
    for i, ((x0, _), (x1, _)) in enumerate(pairwise(table)):
        if not x0 < x1:
            raise InputError(
                f"{name} has sigma = {number_text(x0)} at {i} and {number_text(x1)} at {i + 1}; "
                "give the points with sigma strictly ascending (a jump is not a law of this kind)"
            )
    return table


def _demand_origin(table: list[tuple[Fraction, Fraction]], left: Fraction, right: Fraction) -> None:
    """Refuse a table whose graph misses the origin."""
    (first_x, first_y), (last_x, last_y) = table[0], table[-1]
    if first_x > 0:
        value = first_y - left * first_x
    elif last_x < 0:
        value = last_y - right * last_x
    else:
        value = next(
            (y0 + (y1 - y0) / (x1 - x0) * -x0 for (x0, y0), (x1, y1) in pairwise(table) if x0 <= 0 <= x1), first_y
        )
    if value != 0:
        raise InputError(
            f"PiecewiseLinear has phi(0) = {number_text(value)}; a law must vanish at 0: "
            "measure sigma and phi from the equilibrium"
        )
