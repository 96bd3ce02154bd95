"""Laws through a table of points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise

import numpy as np

from lure.errors import InputError
from lure.exact import Exact, exact_number
from lure.laws.graph import Graph
from lure.laws.law import assign, number_text
from lure.laws.piecewise import GraphLaw, bent


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
        graph = bent(Graph.through(table, left, right), "PiecewiseLinear")
        assign(self, points=tuple(table), left_slope=left, right_slope=right, graph=graph)

    def __str__(self) -> str:
        listed = ", ".join(f"({number_text(x)}, {number_text(y)})" for x, y in self.points[:4])
        more = ", ..." if len(self.points) > 4 else ""
        left, right = number_text(self.left_slope), number_text(self.right_slope)
        return f"piecewise linear law through {listed}{more}, slope {left} to the left and {right} to the right"


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
