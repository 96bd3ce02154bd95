"""Hypothesis strategies for members of a class and for linear blocks, all exact: to fuzz closed loops and criteria.

Drawn nonlinearities are those of :mod:`lure.nonlinearities`, with rational parameters, so that membership in the class
holds by construction and can be checked exactly.  A failing test shrinks to a straight line, else to a nonlinearity of
few pieces and small numbers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from functools import reduce

from lure.arrays import np
from lure.classes import Sector, SlopeBounds
from lure.errors import InputError
from lure.exact import Exact, exact_number
from lure.nonlinearities import (
    Cubic,
    DeadZone,
    ExpressionNonlinearity,
    LibraryNonlinearity,
    PiecewiseLinear,
    Saturation,
    Tanh,
    shifted_nonlinearity,
)
from lure.plants.rational import RationalPlant
from lure.record import described, quantity

# The exact numbers that strategies draw: small ones first, so that what fails shrinks to them.

try:
    from hypothesis import strategies as st
except ImportError:
    raise InputError("lure.analysis.testing.strategies needs Hypothesis: pip install hypothesis") from None

_FAR = 100
_FINEST = 12


def ratios(lower: float | Fraction, upper: float | Fraction) -> st.SearchStrategy[Fraction]:
    """Numbers of ``[lower, upper]``: often one of the finite bounds; at most 100 beyond the finite end of a half-line.

    ``lower``, ``upper``: the interval; infinite ends are allowed.
    """
    if lower == -math.inf and upper == math.inf:
        return st.one_of(st.integers(-3, 3).map(Fraction), st.fractions(-_FAR, _FAR, max_denominator=_FINEST))
    if upper == math.inf:
        return _shares(_FAR).map(lambda share: Fraction(lower) + share)
    if lower == -math.inf:
        return _shares(_FAR).map(lambda share: Fraction(upper) - share)
    low, width = Fraction(lower), Fraction(upper) - Fraction(lower)
    return _shares(1).map(lambda share: low + share * width)


def steps(scale: Fraction) -> st.SearchStrategy[Fraction]:
    """Distances between knots, a tenth to ten times the scale; ``scale``: their size, positive."""
    share = st.one_of(st.just(Fraction(1)), st.fractions(Fraction(1, 10), 10, max_denominator=_FINEST))
    return share.map(lambda number: number * scale)


def sizes(scale: Fraction) -> st.SearchStrategy[Fraction]:
    """Positive numbers from a hundredth to a hundred times the scale; ``scale``: their size, positive."""
    powers = st.sampled_from((Fraction(1), Fraction(1, 10), Fraction(10), Fraction(1, 100), Fraction(100)))
    return powers.map(lambda number: number * scale)


def _shares(most: int) -> st.SearchStrategy[Fraction]:
    """Numbers from 0 to ``most``, often the ends; 1 is the simplest."""
    return st.one_of(st.sampled_from((Fraction(1), Fraction(0))), st.fractions(0, most, max_denominator=_FINEST))


# A nonlinearity with memory that stays in a sector: one graph while the input rises, another while it falls.


@described(frozen=True, kw_only=True, slots=True)
class HystereticNonlinearity:
    """``phi = rising(sigma)`` after ``sigma`` has grown, ``falling(sigma)`` after it has fallen.

    Not a nonlinearity of :mod:`lure.nonlinearities`, which have no memory; what covers it is a theorem for the sector
    alone, without time-invariance, such as the circle criterion.
    """

    rising: PiecewiseLinear = quantity("The graph on the way up")
    falling: PiecewiseLinear = quantity("The graph on the way down")

    @property
    def sector(self) -> Sector:
        """The smallest sector that contains both graphs."""
        first, second = self.rising.graph.sector, self.falling.graph.sector
        return Sector(min(first.lower, second.lower), max(first.upper, second.upper))

    def respond(self, sigma: Sequence[Fraction]) -> Fraction:
        """The value after a history of inputs, exactly; an input that repeats the last takes the graph for falling.

        Parameters
        ----------
        sigma : sequence of Fraction
            The inputs up to now, the last one being the present; before the first the input was 0.
        """
        now, before = sigma[-1], sigma[-2] if len(sigma) > 1 else Fraction(0)
        return (self.rising if now > before else self.falling).exact(now)


def hysteretic(graphs: st.SearchStrategy[PiecewiseLinear]) -> st.SearchStrategy[HystereticNonlinearity]:
    """Hysteretic nonlinearities from two graphs of a class."""
    return st.builds(HystereticNonlinearity, rising=graphs, falling=graphs)


_MOST_KNOTS = 4
# formulas with chords in [0, 1]: 1 at 0, 1 at infinity, both bounds again and again; and whether they are odd
_SHAPES = (
    ("sigma/(1 + (sigma/({s}))**2)", True),
    ("sigma*(sigma/({s}))**2/(1 + (sigma/({s}))**2)", True),
    ("sigma*(1 + sin(sigma/({s})))/2", False),
)
_MONOTONE_SHAPES = {
    True: ("sigma/(1 + abs(sigma/({s})))", "({s})*atan(sigma/({s}))"),
    False: ("sigma/(1 + abs(sigma/({s})))", "({s})*(1 - exp(-max(sigma/({s}), 0)))"),
}


def sector_members(
    lower: Exact, upper: Exact, *, scale: Exact = 1, memory: bool = False
) -> st.SearchStrategy[LibraryNonlinearity] | st.SearchStrategy[HystereticNonlinearity]:
    """Nonlinearities with ``lower sigma^2 <= sigma phi(sigma) <= upper sigma^2``, time-invariant and locally Lipschitz.

    Drawn are straight lines, piecewise linear nonlinearities (with slopes outside the sector as well), and smooth ones,
    among them nonlinearities that touch both bounds again and again as ``|sigma|`` grows.  Many touch the bounds
    exactly.

    Parameters
    ----------
    lower, upper : int, float, Fraction or Decimal
        The sector; ``-math.inf`` and ``math.inf`` are allowed.
    scale : int, float, Fraction or Decimal
        Size of ``sigma`` on which the nonlinearities bend, positive.
    memory : bool
        True draws :class:`HystereticNonlinearity` instead, with one piecewise linear member for rising and one for
        falling ``sigma``: no theorem for time-invariant nonlinearities without memory covers them, the circle criterion
        does.

    Returns
    -------
    SearchStrategy
        Of nonlinearities of :mod:`lure.nonlinearities`.

    Raises
    ------
    InputError
        The bounds are not in order, or ``scale`` is not positive.
    """
    sector, s = _sector(lower, upper), _scale(scale)
    if memory:
        return hysteretic(sector_graphs(lower, upper, scale=scale))
    return st.one_of(_lines(sector), sector_graphs(lower, upper, scale=scale), _smooth(sector, s))


def sector_graphs(lower: Exact, upper: Exact, *, scale: Exact = 1) -> st.SearchStrategy[PiecewiseLinear]:
    """The piecewise linear members of a sector, without the straight lines; exact, as ``.graph.sector`` shows.

    Parameters
    ----------
    lower, upper : int, float, Fraction or Decimal
        The sector, infinite bounds allowed.
    scale : int, float, Fraction or Decimal
        Size of ``sigma`` on which the nonlinearities bend, positive.

    Raises
    ------
    InputError
        The bounds are not in order, or ``scale`` is not positive.

    Notes
    -----
    Between the knots, the origin and infinity ``phi(sigma)/sigma`` is monotone, so that it is enough to draw it there.
    """
    sector, s = _sector(lower, upper), _scale(scale)

    @st.composite
    def graphs(draw: st.DrawFn) -> PiecewiseLinear:
        """Chords at the knots of both sides, and the slopes outside."""
        chord = ratios(sector.lower, sector.upper)
        points, ends = [(Fraction(0), Fraction(0))], []
        for side in (1, -1):
            ends.append(draw(chord))
            for x in _places(draw, s):
                points.append((side * x, side * x * draw(chord)))
        return _bent(sorted(points), (ends[1], ends[0]), sector)

    return graphs()


def monotone_members(k: Exact, *, odd: bool = False, scale: Exact = 1) -> st.SearchStrategy[LibraryNonlinearity]:
    """Nonlinearities with every difference quotient in ``[0, k]``, and ``phi(0) = 0``.

    Parameters
    ----------
    k : int, float, Fraction or Decimal
        Largest slope, positive; ``math.inf`` is allowed.
    odd : bool
        Whether only odd nonlinearities are drawn.
    scale : int, float, Fraction or Decimal
        Size of ``sigma`` on which the nonlinearities bend, positive.

    Returns
    -------
    SearchStrategy
        Of nonlinearities of :mod:`lure.nonlinearities`.

    Raises
    ------
    InputError
        ``k`` or ``scale`` is not positive.
    """
    sector, s = _sector(0, k), _scale(scale)

    @st.composite
    def named(draw: st.DrawFn) -> LibraryNonlinearity:
        """Saturation, dead zone, tanh and formulas."""
        top = draw(ratios(sector.lower, sector.upper).filter(bool))
        width = draw(sizes(s))
        kind = draw(st.sampled_from(("saturation", "dead zone", "tanh", "formula")))
        if kind == "saturation":
            return Saturation(gain=top, limit=top * width, lower_limit=None if odd else -top * width / 3)
        if kind == "dead zone":
            return DeadZone(width=width, gain=top)
        if kind == "tanh":
            return Tanh(scale=width, gain=top * width)
        text = _times(top, draw(st.sampled_from(_MONOTONE_SHAPES[odd])).format(s=width))
        slope = SlopeBounds(0, sector.upper)
        return ExpressionNonlinearity(text, sector=sector, slope_bounds=slope, odd=odd, locally_lipschitz=True)

    return st.one_of(_lines(sector, slope=True), monotone_graphs(k, odd=odd, scale=scale), named())


def monotone_graphs(k: Exact, *, odd: bool = False, scale: Exact = 1) -> st.SearchStrategy[PiecewiseLinear]:
    """The piecewise linear nonlinearities with slopes in ``[0, k]``, without the straight lines.

    Parameters
    ----------
    k : int, float, Fraction or Decimal
        Largest slope, positive; ``math.inf`` is allowed.
    odd : bool
        Whether only odd nonlinearities are drawn.
    scale : int, float, Fraction or Decimal
        Size of ``sigma`` on which the nonlinearities bend, positive.

    Raises
    ------
    InputError
        ``k`` or ``scale`` is not positive.
    """
    sector, s = _sector(0, k), _scale(scale)

    @st.composite
    def graphs(draw: st.DrawFn) -> PiecewiseLinear:
        """Slopes between the knots, summed up from the origin."""
        slope = ratios(sector.lower, sector.upper)
        right, right_end = _climb(draw, slope, s)
        if odd:
            return _mirrored(right, right_end, sector, s)
        left, left_end = _climb(draw, slope, s)
        points = [(-x, -y) for x, y in reversed(left)] + [(Fraction(0), Fraction(0)), *right]
        return _bent(points, (left_end, right_end), sector)

    return graphs()


def _climb(
    draw: st.DrawFn, slope: st.SearchStrategy[Fraction], scale: Fraction
) -> tuple[list[tuple[Fraction, Fraction]], Fraction]:
    """Points on one side of the origin, and the slope beyond them."""
    points: list[tuple[Fraction, Fraction]] = []
    x, y = Fraction(0), Fraction(0)
    for place in _places(draw, scale):
        y += (place - x) * draw(slope)
        x = place
        points.append((x, y))
    return points, draw(slope)


def _places(draw: st.DrawFn, scale: Fraction) -> list[Fraction]:
    """Ascending positive places of knots."""
    place, places = Fraction(0), []
    for step in draw(st.lists(steps(scale), max_size=_MOST_KNOTS)):
        place += step
        places.append(place)
    return places


def _bent(points: list[tuple[Fraction, Fraction]], ends: tuple[Fraction, Fraction], sector: Sector) -> PiecewiseLinear:
    """The nonlinearity through the points, with these slopes outside; a straight line is bent at its right end."""
    left, right = ends
    if {left, right, *(y / x for x, y in points if x != 0)} == {left}:
        right = _other(left, sector)
    return PiecewiseLinear(points, left_slope=left, right_slope=right)


def _mirrored(
    points: list[tuple[Fraction, Fraction]], end: Fraction, sector: Sector, scale: Fraction
) -> PiecewiseLinear:
    """The odd nonlinearity through the points; a straight line is bent at both ends."""
    if {end, *(y / x for x, y in points)} == {end}:
        points = points or [(scale, end * scale)]
        end = _other(end, sector)
    both = [(-x, -y) for x, y in reversed(points)] + [(Fraction(0), Fraction(0)), *points]
    return PiecewiseLinear(both, left_slope=end, right_slope=end)


def _other(slope: Fraction, sector: Sector) -> Fraction:
    """Another number of the sector: its lower bound, unless that is the one."""
    low, high = (None if math.isinf(bound) else Fraction(bound) for bound in (sector.lower, sector.upper))
    if low is None:
        return slope - 1
    if slope != low:
        return low
    return slope + 1 if high is None else high


def _lines(sector: Sector, *, slope: bool = False) -> st.SearchStrategy[LibraryNonlinearity]:
    """Straight lines, the simplest members."""
    bounds = SlopeBounds(sector.lower, sector.upper) if slope else None

    @st.composite
    def lines(draw: st.DrawFn) -> LibraryNonlinearity:
        """``gain sigma``."""
        text = _times(draw(ratios(sector.lower, sector.upper)), "sigma")
        return ExpressionNonlinearity(text, sector=sector, slope_bounds=bounds, odd=True, locally_lipschitz=True)

    return lines()


def _smooth(sector: Sector, scale: Fraction) -> st.SearchStrategy[LibraryNonlinearity]:
    """Smooth members: from one bound towards the other, or between them again and again."""
    low, high = sector.lower, sector.upper
    if math.inf in (abs(low), abs(high)):
        return _cubics(sector, scale)

    @st.composite
    def between(draw: st.DrawFn) -> LibraryNonlinearity:
        """``lower sigma`` plus a share of ``upper - lower`` times a shape with chords in [0, 1]."""
        base, width = Fraction(low), Fraction(high) - Fraction(low)
        share = width * draw(ratios(0, 1).filter(bool))
        place = draw(sizes(scale))
        shape, odd = draw(st.sampled_from((("tanh", True), *_SHAPES)))
        if shape == "tanh":
            nonlinearity: LibraryNonlinearity = shifted_nonlinearity(Tanh(scale=place, gain=share * place), -base)  # type: ignore[assignment]  # of a nonlinearity, one
            return nonlinearity
        line = f"{_times(base, 'sigma')} + " if base else ""
        text = line + _times(share, shape.format(s=place))
        return ExpressionNonlinearity(text, sector=sector, odd=odd, locally_lipschitz=True)

    return between()


def _cubics(sector: Sector, scale: Fraction) -> st.SearchStrategy[LibraryNonlinearity]:
    """Cubics of a sector with an infinite bound."""
    low, high = sector.lower, sector.upper

    @st.composite
    def cubics(draw: st.DrawFn) -> LibraryNonlinearity:
        """From the finite bound towards the infinite one."""
        upwards = high == math.inf
        linear = draw(ratios(low, high))
        return Cubic(linear=linear, cubic=(1 if upwards else -1) * draw(sizes(Fraction(1))) / scale**2)

    return cubics()


def _times(factor: Fraction, text: str) -> str:
    """A product as text, ``-3/2*sigma``."""
    return text if factor == 1 else f"{factor}*{text}"


def _sector(lower: Exact, upper: Exact) -> Sector:
    return Sector(_bound(lower), _bound(upper))


def _bound(value: Exact) -> float | Fraction:
    if isinstance(value, float) and math.isinf(value):
        return value
    return exact_number(value, "a bound of the class")


def _scale(scale: Exact) -> Fraction:
    exact = exact_number(scale, "scale")
    if exact <= 0:
        raise InputError(f"scale is {float(exact):g}; give a positive number")
    return exact


# Linear blocks with known poles, for loops with nonlinearities of a class.

_ORDERS = (1, 4)
_BLOCKS_FINEST = 10


@described(frozen=True, kw_only=True, slots=True)
class KnownPlant:
    """A block and the poles it was made from."""

    block: RationalPlant = quantity("The block, its coefficients exact")
    poles: tuple[tuple[Fraction, Fraction], ...] = quantity(
        "Real and imaginary part of each pole; of a conjugate pair the one above the axis"
    )


def lurie_blocks(
    *, order: int | tuple[int, int] = _ORDERS, critical: bool = False, discrete: bool = False
) -> st.SearchStrategy[RationalPlant]:
    """Strictly proper blocks with all poles stable, or with one simple pole at 0 (1) and the others stable.

    Parameters
    ----------
    order : int or pair of int
        Order, or the smallest and the largest.
    critical : bool
        Whether there is a pole at ``s = 0`` (``z = 1``); its residue is positive, as absolute stability needs.
    discrete : bool
        Whether time is discrete, with the sampling time 1.

    Returns
    -------
    SearchStrategy of RationalPlant
        Shrinks to ``1/(s + 1)``.

    Raises
    ------
    InputError
        ``order`` is not positive, or not ascending.
    """
    return known_blocks(order=order, critical=critical, discrete=discrete).map(lambda known: known.block)


def known_blocks(
    *, order: int | tuple[int, int] = _ORDERS, critical: bool = False, discrete: bool = False
) -> st.SearchStrategy[KnownPlant]:
    """The blocks of :func:`lurie_blocks`, with their poles.

    Parameters
    ----------
    order : int or pair of int
        Order, or the smallest and the largest.
    critical : bool
        Whether there is a pole at ``s = 0`` (``z = 1``).
    discrete : bool
        Whether time is discrete.

    Raises
    ------
    InputError
        ``order`` is not positive, or not ascending.
    """
    least, most = (order, order) if isinstance(order, int) else order
    if not 1 <= least <= most:
        raise InputError(f"order is {order!r:.60}; give a positive whole number, or two in ascending order")

    @st.composite
    def blocks(draw: st.DrawFn) -> KnownPlant:
        """Poles first, then a numerator of lower degree."""
        size = draw(st.integers(least, most))
        poles = [(Fraction(1 if discrete else 0), Fraction(0))] if critical else []
        left = size - len(poles)
        while left:
            pair = left >= 2 and draw(st.booleans())
            poles.append(_pole(draw, discrete=discrete, pair=pair))
            left -= 2 if pair else 1
        denominator = reduce(np.convolve, [np.array(_factor(pole), dtype=object) for pole in poles]).tolist()
        numerator = _numerator(draw, size, (1 if discrete else 0) if critical else None)
        return KnownPlant(block=RationalPlant(numerator, denominator, 1 if discrete else None), poles=tuple(poles))

    return blocks()


def _pole(draw: st.DrawFn, *, discrete: bool, pair: bool) -> tuple[Fraction, Fraction]:
    """A stable pole: left of the imaginary axis, or inside the unit circle."""
    if not discrete:
        decay = draw(st.one_of(st.just(Fraction(1)), st.fractions(Fraction(1, 10), 10, max_denominator=_BLOCKS_FINEST)))
        return -decay, draw(st.fractions(Fraction(1, 10), 10, max_denominator=_BLOCKS_FINEST)) if pair else Fraction(0)
    inside = st.fractions(Fraction(-9, 10), Fraction(9, 10), max_denominator=_BLOCKS_FINEST)
    real = draw(inside)
    if not pair:
        return real, Fraction(0)
    imaginary = draw(st.fractions(Fraction(1, 10), Fraction(9, 10), max_denominator=_BLOCKS_FINEST))
    return (real, imaginary) if real**2 + imaginary**2 < Fraction(9, 10) else (real / 2, imaginary / 2)


def _factor(pole: tuple[Fraction, Fraction]) -> list[Fraction]:
    real, imaginary = pole
    return [Fraction(1), -2 * real, real**2 + imaginary**2] if imaginary else [Fraction(1), -real]


def _numerator(draw: st.DrawFn, order: int, critical: int | None) -> list[Fraction]:
    """Coefficients of a polynomial of degree below the order; its value at the critical pole is positive."""
    number = st.one_of(st.sampled_from((Fraction(0), Fraction(1))), st.fractions(-5, 5, max_denominator=4))
    coefficients = [*draw(st.lists(number, max_size=order - 1)), draw(number)]
    if not any(coefficients):
        coefficients[-1] = Fraction(1)
    if critical is None:
        return coefficients
    value = sum(coefficients, Fraction(0)) if critical else coefficients[-1]
    if value == 0:
        coefficients[-1] += 1
    return [-c for c in coefficients] if value < 0 else coefficients
