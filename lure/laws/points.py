"""Laws through a table of points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import numpy as np

from lure.errors import InputError
from lure.laws.graph import Graph
from lure.laws.law import Parameter, assign, exact_parameter, number_text
from lure.laws.piecewise import GraphLaw, bent
from lure.laws.points_file import Points, points_from_csv


@dataclass(frozen=True, slots=True)
class PiecewiseLinear(GraphLaw):
    r"""The continuous law through a table of points, straight between and outside them.

    Sector and slope bounds are the tightest and exact: between the points, 0 and infinity the chord slope
    ``phi(sigma)/sigma = s + c/sigma`` is monotone, so that its extremes are read off there.

    Parameters
    ----------
    points : sequence of (sigma, phi)
        At least one, ``sigma`` strictly ascending; the origin need not be listed but must lie on the graph.
    left_slope, right_slope : int, float, Fraction, Decimal or str
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

    def __init__(self, points: Sequence[Sequence[Parameter]], *, left_slope: Parameter, right_slope: Parameter) -> None:
        left = exact_parameter(left_slope, "PiecewiseLinear.left_slope")
        right = exact_parameter(right_slope, "PiecewiseLinear.right_slope")
        table = _ascending(points)
        _demand_origin(table, left, right)
        graph = bent(Graph.through(table, left, right), "PiecewiseLinear")
        assign(self, points=tuple(table), left_slope=left, right_slope=right, graph=graph)

    @classmethod
    def from_csv(
        cls, path: str | Path, *, left_slope: Parameter | None = None, right_slope: Parameter | None = None
    ) -> PiecewiseLinear:
        """The law through the points of a CSV file; see ``lure.laws.points_file``.

        Parameters
        ----------
        path : str or Path
            Two columns, ``sigma`` and ``phi``.
        left_slope, right_slope : int, float, Fraction, Decimal, str or None
            Slopes outside the points; None goes on straight with that of the outermost two.

        Raises
        ------
        InputError
            The file cannot be read, its points are not in order, or their graph misses the origin.
        """
        points = points_from_csv(path)
        left, right = outer_slopes(points)
        return cls(
            points,
            left_slope=left if left_slope is None else left_slope,
            right_slope=right if right_slope is None else right_slope,
        )

    def __str__(self) -> str:
        listed = ", ".join(f"({number_text(x)}, {number_text(y)})" for x, y in self.points[:4])
        more = ", ..." if len(self.points) > 4 else ""
        left, right = number_text(self.left_slope), number_text(self.right_slope)
        return f"piecewise linear law through {listed}{more}, slope {left} to the left and {right} to the right"


def outer_slopes(points: Points) -> tuple[Fraction, Fraction]:
    """The slopes between the first two and the last two of at least two points.

    Parameters
    ----------
    points : list of (Fraction, Fraction)
        In ascending order.
    """
    (x0, y0), (x1, y1) = points[:2]
    (x2, y2), (x3, y3) = points[-2:]
    return (y1 - y0) / (x1 - x0), (y3 - y2) / (x3 - x2)


def _ascending(points: Sequence[Sequence[Parameter]]) -> list[tuple[Fraction, Fraction]]:
    name = "PiecewiseLinear.points"
    if isinstance(points, str) or not isinstance(points, Sequence | np.ndarray) or len(points) == 0:
        raise InputError(f"{name} is {points!r:.60}; give a list of at least one pair [sigma, phi]")
    table: list[tuple[Fraction, Fraction]] = []
    for i, point in enumerate(points):
        if isinstance(point, str) or not isinstance(point, Sequence | np.ndarray) or len(point) != 2:
            raise InputError(f"{name}[{i}] is {point!r:.60}; give a pair [sigma, phi]")
        x, y = exact_parameter(point[0], f"{name}[{i}][0]"), exact_parameter(point[1], f"{name}[{i}][1]")
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
