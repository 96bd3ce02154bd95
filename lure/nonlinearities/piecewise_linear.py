"""Nonlinearities through a table of points."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from pathlib import Path

from lure.arrays import ArrayLike, NDArray, is_array, np
from lure.classes import Sector, SlopeBounds
from lure.errors import InputError, Reason
from lure.exact import exact_number
from lure.nonlinearities.base import (
    NamedNonlinearity,
    Parameter,
    assign,
    exact_parameter,
    factor_text,
    positive,
)
from lure.nonlinearities.points_file import Points, points_from_csv
from lure.record import described, quantity
from lure.record.values import exact_text

# Piecewise linear graphs through the origin: everything about them is exact and read off the points.


@described(frozen=True)
class Graph:
    """A continuous piecewise linear function with ``phi(0) = 0``."""

    knots: tuple[Fraction, ...] = quantity("Points of the graph in ascending order, the origin among them")
    values: tuple[Fraction, ...] = quantity("Their values")
    slopes: tuple[Fraction, ...] = quantity(
        "Slope left of the first knot, between the knots, right of the last: one more than there are knots"
    )
    rows: tuple[tuple[float, ...], ...] = quantity(
        "Rows for floats: the knots; then for each of the slopes the point of its segment nearest to 0, the value "
        "and the primitive there, and the slope itself",
        init=False,
        hidden=True,
    )

    @classmethod
    def through(cls, points: Sequence[tuple[Fraction, Fraction]], left: Fraction, right: Fraction) -> Graph:
        """The graph through ascending points with these slopes outside them; the origin is added if it lies on it."""
        x, y = [point[0] for point in points], [point[1] for point in points]
        if 0 not in x:
            place = bisect_left(x, Fraction(0))
            x.insert(place, Fraction(0))
            y.insert(place, Fraction(0))
        inner = [(y1 - y0) / (x1 - x0) for (x0, y0), (x1, y1) in pairwise(zip(x, y, strict=True))]
        return cls(tuple(x), tuple(y), (left, *inner, right))

    def __post_init__(self) -> None:
        for i, slope in enumerate(self.slopes):
            exact_number(slope, f"slope {i + 1} of the graph")
        last = len(self.knots) - 1
        anchors = [min(i, last) if i == 0 or self.knots[i - 1] < 0 else i - 1 for i in range(len(self.slopes))]
        integrals = self._integrals()
        columns = [(self.knots[a], self.values[a], integrals[a], s) for a, s in zip(anchors, self.slopes, strict=True)]
        rows = (self.knots, *zip(*columns, strict=True))
        try:
            object.__setattr__(self, "rows", tuple(tuple(map(float, row)) for row in rows))
        except OverflowError:
            raise InputError(
                "a point of the graph, or the area below it, is beyond the largest double, 1.8e308; rescale the units"
            ) from None

    @cached_property
    def table(self) -> tuple[NDArray[np.float64], ...]:
        """``rows`` as arrays."""
        return tuple(np.array(row) for row in self.rows)

    def _integrals(self) -> list[Fraction]:
        """``int_0^knot phi`` at each knot."""
        sums = [Fraction(0)]
        for (x0, x1), (y0, y1) in zip(pairwise(self.knots), pairwise(self.values), strict=True):
            sums.append(sums[-1] + (x1 - x0) * (y0 + y1) / 2)
        origin = sums[self.knots.index(Fraction(0))]
        return [total - origin for total in sums]

    @property
    def kinks(self) -> tuple[Fraction, ...]:
        """Where the slope changes."""
        return tuple(x for x, (s0, s1) in zip(self.knots, pairwise(self.slopes), strict=True) if s0 != s1)

    @property
    def chords(self) -> list[tuple[Fraction, str]]:
        """Every value at which ``phi(sigma)/sigma`` can be extreme, with where: it is monotone between these places."""
        at_zero = self.knots.index(Fraction(0))
        ends = [(self.slopes[0], "as sigma -> -inf"), (self.slopes[-1], "as sigma -> inf")]
        ends += [(self.slopes[at_zero], "as sigma -> 0-"), (self.slopes[at_zero + 1], "as sigma -> 0+")]
        return ends + [
            (y / x, f"at sigma = {exact_text(x)}") for x, y in zip(self.knots, self.values, strict=True) if x != 0
        ]

    @property
    def sector(self) -> Sector:
        """The tightest sector."""
        chords = [chord for chord, _ in self.chords]
        return Sector(min(chords), max(chords))

    @property
    def slope_bounds(self) -> SlopeBounds:
        """The tightest slope bounds."""
        return SlopeBounds(min(self.slopes), max(self.slopes))

    @property
    def is_line(self) -> bool:
        """Whether the graph is a straight line."""
        return len(set(self.slopes)) == 1

    @property
    def odd(self) -> bool:
        """Whether the graph is its own mirror image in the origin."""
        return self.slopes[0] == self.slopes[-1] and all(self.exact(-x) == -self.exact(x) for x in self.knots)

    def exact(self, sigma: Fraction) -> Fraction:
        """The value at an exact point, exactly."""
        i = bisect_left(self.knots, sigma)
        anchor = min(i, len(self.knots) - 1)
        return self.values[anchor] + self.slopes[i] * (sigma - self.knots[anchor])

    def __call__(self, sigma: ArrayLike) -> NDArray[np.float64]:
        """Values, elementwise."""
        x, (x0, y0, _, s) = self._segments(sigma)
        with np.errstate(over="ignore", invalid="ignore"):
            return np.where(np.isnan(x) | (s != 0), y0 + s * (x - x0), y0)

    def slope(self, sigma: ArrayLike) -> NDArray[np.float64]:
        """Slopes, elementwise; at a kink the one from the left."""
        x, (_, _, _, s) = self._segments(sigma)
        return np.where(np.isnan(x), x, s)

    def primitive(self, sigma: ArrayLike) -> NDArray[np.float64]:
        """``int_0^sigma phi``, elementwise."""
        x, (x0, y0, p0, s) = self._segments(sigma)
        with np.errstate(over="ignore", invalid="ignore"):
            step = x - x0
            flat = np.where(np.isnan(x) | (y0 != 0), y0 * step, 0.0)
            return np.where(s != 0, p0 + step * (y0 + 0.5 * s * step), p0 + flat)

    def shifted(self, gain: Fraction) -> Graph:
        """The graph of ``phi(sigma) - gain sigma``."""
        values = tuple(y - gain * x for x, y in zip(self.knots, self.values, strict=True))
        return Graph(self.knots, values, tuple(s - gain for s in self.slopes))

    def _segments(self, sigma: ArrayLike) -> tuple[NDArray[np.float64], tuple[NDArray[np.float64], ...]]:
        x = np.asarray(sigma, dtype=float)
        i = np.searchsorted(self.table[0], x, side="left")
        return x, tuple(row[i] for row in self.table[1:])


# Piecewise linear nonlinearities: saturation, relay with slope, dead zone and rectifiers.


class GraphNonlinearity(NamedNonlinearity):
    """What piecewise linear nonlinearities share; each sets ``graph`` when it is made and overrides nothing.

    Attributes
    ----------
    graph : Graph
        The points and slopes, exactly.
    """

    graph: Graph = quantity("", hidden=True, init=False)
    locally_lipschitz, regularity = True, "piecewise linear, globally Lipschitz"

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
        """Whether the nonlinearity is odd, from its points."""
        return self.graph.odd

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


class Saturation(GraphNonlinearity):
    r"""Saturation, ``phi(sigma) = min(max(gain sigma, lower_limit), limit)``; sector and slope ``[0, gain]``.

    Parameters
    ----------
    gain : int, float, Fraction, Decimal or str
        Slope between the limits, positive [unit of phi / unit of sigma].
    limit : int, float, Fraction, Decimal or str
        Largest value of ``phi``, positive [unit of phi].
    lower_limit : int, float, Fraction, Decimal, str or None
        Least value, at most 0; None for ``-limit``.  Any other value makes a nonlinearity that is not odd.

    Raises
    ------
    InputError
        A parameter is not a finite number of the sign named.

    Examples
    --------
    >>> nonlinearity = Saturation(gain=2, limit=1)
    >>> print(nonlinearity, nonlinearity.sector, nonlinearity([-3.0, 0.25]), nonlinearity.primitive(1.0))
    saturation min(max(2 sigma, -1), 1) [0, 2] [-1.   0.5] 0.75
    """

    gain: Fraction
    limit: Fraction
    lower_limit: Fraction

    def __init__(self, *, gain: Parameter = 1, limit: Parameter = 1, lower_limit: Parameter | None = None) -> None:
        g, top = positive(gain, "Saturation.gain"), positive(limit, "Saturation.limit")
        bottom = -top if lower_limit is None else exact_parameter(lower_limit, "Saturation.lower_limit")
        if bottom > 0:
            raise InputError(
                f"Saturation.lower_limit is {float(bottom):g}; give a number of at most 0, since phi(0) = 0"
            )
        points = [(bottom / g, bottom), (top / g, top)]
        assign(self, gain=g, limit=top, lower_limit=bottom, graph=Graph.through(points, Fraction(0), Fraction(0)))

    def __str__(self) -> str:
        low, high = (exact_text(x) for x in (self.lower_limit, self.limit))
        return f"saturation min(max({factor_text(self.gain)}sigma, {low}), {high})"


def relay_with_slope(*, gain: Parameter, level: Parameter) -> Saturation:
    """A relay whose switch has the finite slope ``gain``, between the values ``-level`` and ``level``.

    The ideal relay, ``gain = inf``, is refused: it jumps at 0, so that the loop is a differential inclusion, for which
    none of the theorems here is stated.

    Parameters
    ----------
    gain : int, float, Fraction, Decimal or str
        Slope at 0, positive and finite.
    level : int, float, Fraction, Decimal or str
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


class DeadZone(GraphNonlinearity):
    r"""Dead zone: 0 for ``|sigma| <= width``, then ``gain (|sigma| - width)`` with the sign of ``sigma``.

    Sector and slope ``[0, gain]``; the upper bound of the sector is approached as ``|sigma| -> inf``, never attained.
    Every ``|sigma| <= width`` gives ``phi = 0``, so a loop with a pole at 0 has a segment of equilibria.

    Parameters
    ----------
    width : int, float, Fraction, Decimal or str
        Half the width of the zone, positive [unit of sigma].
    gain : int, float, Fraction, Decimal or str
        Slope outside, positive [unit of phi / unit of sigma].

    Raises
    ------
    InputError
        A parameter is not a positive finite number.

    Examples
    --------
    >>> DeadZone(width=1, gain=2)([-3.0, 0.5, 2.0])
    array([-4.,  0.,  2.])
    """

    width: Fraction
    gain: Fraction

    def __init__(self, *, width: Parameter = 1, gain: Parameter = 1) -> None:
        w, g = positive(width, "DeadZone.width"), positive(gain, "DeadZone.gain")
        assign(self, width=w, gain=g, graph=Graph.through([(-w, Fraction(0)), (w, Fraction(0))], g, g))

    def __str__(self) -> str:
        return f"dead zone of |sigma| <= {exact_text(self.width)}, then slope {exact_text(self.gain)}"


class ReLU(GraphNonlinearity):
    """Rectifier, ``phi(sigma) = gain max(sigma, 0)``; sector and slope ``[0, gain]``, not odd.

    Parameters
    ----------
    gain : int, float, Fraction, Decimal or str
        Slope for positive ``sigma``, positive.

    Raises
    ------
    InputError
        ``gain`` is not a positive finite number.
    """

    gain: Fraction

    def __init__(self, *, gain: Parameter = 1) -> None:
        g = positive(gain, "ReLU.gain")
        assign(self, gain=g, graph=Graph.through([], Fraction(0), g))

    def __str__(self) -> str:
        return f"ReLU {factor_text(self.gain)}max(sigma, 0)"


class LeakyReLU(GraphNonlinearity):
    """Two slopes that meet at 0; sector and slope bounds are the two, in order, and the nonlinearity is not odd.

    Parameters
    ----------
    negative_slope, positive_slope : int, float, Fraction, Decimal or str
        Slopes left and right of 0, different from each other.

    Raises
    ------
    InputError
        A slope is not a finite number, or the two are equal.
    """

    negative_slope: Fraction
    positive_slope: Fraction

    def __init__(self, *, negative_slope: Parameter = Fraction(1, 100), positive_slope: Parameter = 1) -> None:
        left = exact_parameter(negative_slope, "LeakyReLU.negative_slope")
        right = exact_parameter(positive_slope, "LeakyReLU.positive_slope")
        assign(self, negative_slope=left, positive_slope=right, graph=bent(Graph.through([], left, right), "LeakyReLU"))

    def __str__(self) -> str:
        left, right = exact_text(self.negative_slope), exact_text(self.positive_slope)
        return f"leaky ReLU with slope {left} for sigma < 0 and {right} for sigma > 0"


def bent(graph: Graph, name: str) -> Graph:
    """The graph, unless it is a straight line.

    Raises
    ------
    InputError
        It is one.
    """
    if graph.is_line:
        gain = exact_text(graph.slopes[0])
        raise InputError(f"{name} is the straight line phi = {gain} sigma; a linear gain belongs into the block")
    return graph


class PiecewiseLinear(GraphNonlinearity):
    r"""The continuous nonlinearity through a table of points, straight between and outside them.

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
    >>> nonlinearity = PiecewiseLinear([(-1, -3), (2, 6), (4, 7)], left_slope=0, right_slope=Fraction(1, 2))
    >>> print(nonlinearity.sector, nonlinearity.slope_bounds, nonlinearity.odd)
    [0, 3] [0, 3] False
    """

    points: tuple[tuple[Fraction, Fraction], ...]
    left_slope: Fraction
    right_slope: Fraction

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
        """The nonlinearity through the points of a CSV file; see ``lure.nonlinearities.points_file``.

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
        listed = ", ".join(f"({exact_text(x)}, {exact_text(y)})" for x, y in self.points[:4])
        more = ", ..." if len(self.points) > 4 else ""
        left, right = exact_text(self.left_slope), exact_text(self.right_slope)
        return (
            f"piecewise linear nonlinearity through {listed}{more}, slope {left} to the left and {right} to the right"
        )


def outer_slopes(points: Points) -> tuple[Fraction, Fraction]:
    """The slopes between the first two and the last two of at least two points; ``points``: in ascending order."""
    (x0, y0), (x1, y1) = points[:2]
    (x2, y2), (x3, y3) = points[-2:]
    return (y1 - y0) / (x1 - x0), (y3 - y2) / (x3 - x2)


def _ascending(points: Sequence[Sequence[Parameter]]) -> list[tuple[Fraction, Fraction]]:
    name = "PiecewiseLinear.points"
    if isinstance(points, str) or not (isinstance(points, Sequence) or is_array(points)) or len(points) == 0:
        raise InputError(f"{name} is {points!r:.60}; give a list of at least one pair [sigma, phi]")
    table: list[tuple[Fraction, Fraction]] = []
    for i, point in enumerate(points):
        if isinstance(point, str) or not (isinstance(point, Sequence) or is_array(point)) or len(point) != 2:
            raise InputError(f"{name}[{i}] is {point!r:.60}; give a pair [sigma, phi]")
        x, y = exact_parameter(point[0], f"{name}[{i}][0]"), exact_parameter(point[1], f"{name}[{i}][1]")
        table.append((x, y))
    for i, ((x0, _), (x1, _)) in enumerate(pairwise(table)):
        if not x0 < x1:
            raise InputError(
                f"{name} has sigma = {exact_text(x0)} at {i} and {exact_text(x1)} at {i + 1}; "
                "give the points with sigma strictly ascending (a jump is not a nonlinearity of this kind)"
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
            f"PiecewiseLinear has phi(0) = {exact_text(value)}; a nonlinearity must vanish at 0: "
            "measure sigma and phi from the equilibrium",
            code=Reason.OUTSIDE_CLASS,
        )
