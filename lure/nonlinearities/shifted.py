"""The nonlinearity of a shifted loop, ``phi(sigma) - gain sigma``, and of one counted from elsewhere."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise

from lure.arrays import ArrayLike, NDArray, np
from lure.classes import NonlinearityClass, Sector, SlopeBounds
from lure.errors import InputError
from lure.exact import Exact, exact_number
from lure.expressions.rigorous import ball
from lure.nonlinearities.base import LibraryNonlinearity, NamedNonlinearity, Nonlinearity
from lure.nonlinearities.named import Cubic, Tanh
from lure.nonlinearities.piecewise_linear import Graph, GraphNonlinearity, PiecewiseLinear
from lure.record import quantity
from lure.record.values import exact_text

_BITS = 128


class _AsSmooth:
    """As regular as the nonlinearity that it is made of."""

    nonlinearity: Nonlinearity

    @property
    def regularity(self) -> str:
        """That of the nonlinearity."""
        return str(getattr(self.nonlinearity, "regularity", "unknown"))

    @property
    def locally_lipschitz(self) -> bool:
        """Whether the nonlinearity is known to be."""
        return bool(getattr(self.nonlinearity, "locally_lipschitz", False))


class ShiftedNonlinearity(_AsSmooth, NamedNonlinearity, kw_only=False):
    """``phi(sigma) - gain sigma`` of another nonlinearity; made by :func:`shifted_nonlinearity`.

    Attributes
    ----------
    nonlinearity : Nonlinearity
        The nonlinearity ``phi``.  Where it has no ``slope`` or ``primitive``, the shifted nonlinearity raises the same
        AttributeError.
    gain : Fraction
        What is subtracted.
    """

    nonlinearity: Nonlinearity
    gain: Fraction

    @property
    def sector(self) -> Sector:
        """The sector of the nonlinearity, both bounds less ``gain``."""
        bounds = self.nonlinearity.sector
        return Sector(shifted_bound(bounds.lower, self.gain), shifted_bound(bounds.upper, self.gain))

    @property
    def slope_bounds(self) -> SlopeBounds | None:
        """The slope bounds of the nonlinearity, both less ``gain``."""
        bounds: SlopeBounds | None = getattr(self.nonlinearity, "slope_bounds", None)
        if bounds is None:
            return None
        return SlopeBounds(shifted_bound(bounds.lower, self.gain), shifted_bound(bounds.upper, self.gain))

    @property
    def odd(self) -> bool:
        """Whether the nonlinearity is odd."""
        return bool(getattr(self.nonlinearity, "odd", False))

    @property
    def breakpoints(self) -> tuple[Fraction, ...]:
        """Those of the nonlinearity."""
        return tuple(getattr(self.nonlinearity, "breakpoints", ()))

    def __call__(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """Values, elementwise."""
        return np.asarray(self.nonlinearity(sigma) - float(self.gain) * np.asarray(sigma, dtype=float))

    def slope(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """Derivative, elementwise."""
        return np.asarray(_full(self.nonlinearity).slope(sigma) - float(self.gain))

    def primitive(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """``int_0^sigma``, elementwise."""
        square = np.asarray(sigma, dtype=float) ** 2
        return np.asarray(_full(self.nonlinearity).primitive(sigma) - 0.5 * float(self.gain) * square)

    def __str__(self) -> str:
        sign = "+" if self.gain < 0 else "-"
        return f"({self.nonlinearity}) {sign} {exact_text(abs(self.gain))} sigma"


def shifted_nonlinearity(nonlinearity: Nonlinearity, gain: Exact) -> Nonlinearity:
    """The nonlinearity ``phi(sigma) - gain sigma``, with its properties moved along exactly.

    It belongs with the block ``H/(1 + gain H)``, see :func:`lure.loop.pole_shift`.

    Parameters
    ----------
    nonlinearity : Nonlinearity
        The nonlinearity ``phi``.
    gain : int, float, Fraction or Decimal
        What is subtracted, finite; a shift by ``-gain`` undoes it.

    Returns
    -------
    Nonlinearity
        A nonlinearity of the library where there is one (``PiecewiseLinear``, ``Cubic``), else a
        :class:`ShiftedNonlinearity`; the nonlinearity itself for ``gain = 0``.

    Raises
    ------
    InputError
        ``gain`` is not a finite number.

    Examples
    --------
    >>> from lure.nonlinearities import Saturation
    >>> print(shifted_nonlinearity(Saturation(gain=1, limit=1), 1).sector)
    [-1, 0]
    """
    g = exact_number(gain, "shifted_nonlinearity: gain")
    if g == 0:
        return nonlinearity
    if isinstance(nonlinearity, GraphNonlinearity):
        moved = nonlinearity.graph.shifted(g)
        points = list(zip(moved.knots, moved.values, strict=True))
        return PiecewiseLinear(points, left_slope=moved.slopes[0], right_slope=moved.slopes[-1])
    if type(nonlinearity) is Cubic:
        return Cubic(linear=nonlinearity.linear - g, cubic=nonlinearity.cubic)
    if type(nonlinearity) is ShiftedNonlinearity:
        return (
            nonlinearity.nonlinearity
            if nonlinearity.gain + g == 0
            else ShiftedNonlinearity(nonlinearity.nonlinearity, nonlinearity.gain + g)
        )
    return ShiftedNonlinearity(nonlinearity, g)


def shifted_class(nonlinearity_class: NonlinearityClass, gain: Fraction) -> NonlinearityClass:
    """The class of all ``phi(sigma) - gain sigma``; parity and time dependence stay.

    Parameters
    ----------
    nonlinearity_class : NonlinearityClass
        The class of ``phi``.
    gain : Fraction
        What is subtracted.
    """
    sector, slope = nonlinearity_class.sector, nonlinearity_class.slope
    return replace(
        nonlinearity_class,
        sector=Sector(shifted_bound(sector.lower, gain), shifted_bound(sector.upper, gain)),
        slope=slope and SlopeBounds(shifted_bound(slope.lower, gain), shifted_bound(slope.upper, gain)),
    )


def shifted_bound(bound: float | Fraction, gain: Fraction) -> float | Fraction:
    """``bound - gain``, exactly; an infinite bound stays.

    ``bound``: a bound; a float means the double it is.  ``gain``: what is subtracted.
    """
    return bound if bound in (math.inf, -math.inf) else Fraction(bound) - gain


class MovedNonlinearity(_AsSmooth, NamedNonlinearity, kw_only=False):
    r"""``phi(at + sigma) - phi(at)`` of another nonlinearity, with ``at`` known to within ``within``.

    All that is said of it is true for every number that is no farther from ``at``: it is about the one that is meant,
    such as what a neuron sees at an equilibrium that is no rational number.  Values are those at the middle.

    Parameters
    ----------
    nonlinearity : Nonlinearity
        The nonlinearity ``phi``.
    at : Fraction
        Where ``sigma`` is counted from, its middle.
    within : Fraction
        How far from there it is at most; positive.

    Raises
    ------
    InputError
        ``within`` is not positive, or a kink of ``phi`` is no farther from ``at`` than twice that.

    Examples
    --------
    >>> moved = MovedNonlinearity(Tanh(), Fraction(1), Fraction(1, 10**20))
    >>> print(moved, moved.sector.upper < Fraction(82, 100))
    tanh(sigma) around 1 True
    """

    nonlinearity: Nonlinearity
    at: Fraction
    within: Fraction
    centre: PiecewiseLinear | None = quantity("that of a piecewise linear one around the middle", init=False)
    odd = False  # it is not known to be

    def __post_init__(self) -> None:
        if not self.within > 0:
            raise InputError(f"within is {float(self.within):g}; give a positive number")
        own = self.nonlinearity
        graph = own.graph if isinstance(own, GraphNonlinearity) else None
        object.__setattr__(self, "centre", None if graph is None else moved_graph(graph, self.at))
        if not self.room > 2 * self.within:
            raise InputError(
                f"{own!s:.60} has a kink at {exact_text(self.at)}, to within {float(self.within):.1e}; it is moved to "
                "places only where it is a line on both sides"
            )

    @property
    def room(self) -> Fraction | float:
        """How far the next kink is from the middle; ``inf`` without any."""
        return min((abs(x) for x in self.kinks), default=math.inf)

    @property
    def kinks(self) -> tuple[Fraction, ...]:
        """The kinks around the middle, of a piecewise linear one."""
        return () if self.centre is None else self.centre.graph.kinks

    @property
    def spread(self) -> Fraction:
        """Of a piecewise linear one: by how much a chord slope may differ from that around the middle."""
        if self.centre is None or self.room == math.inf:
            return Fraction(0)
        slopes = self.centre.graph.slopes
        return (max(slopes) - min(slopes)) * self.within / (Fraction(self.room) - self.within)

    @property
    def sector(self) -> Sector:
        """The slope bounds, which bound all chords; of ``tanh`` and piecewise linear ones a closer one."""
        if self.centre is not None:
            chords, slopes = self.centre.sector, self.centre.graph.slopes
            low, high = shifted_bound(chords.lower, self.spread), shifted_bound(chords.upper, -self.spread)
            return Sector(max(low, min(slopes)), min(high, max(slopes)))
        if type(self.nonlinearity) is Tanh:
            d = self.nonlinearity.scale
            return Sector(0, self.nonlinearity.gain / d * steepest_chord(abs(self.at) / d, self.within / d))
        bounds = self.slope_bounds
        return Sector(-math.inf, math.inf) if bounds is None else Sector(bounds.lower, bounds.upper)

    @property
    def slope_bounds(self) -> SlopeBounds | None:
        """Those of the nonlinearity."""
        return getattr(self.nonlinearity, "slope_bounds", None)

    def __call__(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """Values around the middle, elementwise."""
        at, x = float(self.at), np.asarray(sigma, dtype=float)
        if self.centre is not None:
            return self.centre(x)
        if type(self.nonlinearity) is Tanh:  # tanh(a + x) - tanh(a) = tanh(x) (1 - tanh(a) tanh(a + x))
            one = Tanh(scale=self.nonlinearity.scale)
            return np.asarray(self.nonlinearity(x) * (1 - one(at) * one(at + x)))
        return np.asarray(self.nonlinearity(at + x) - self.nonlinearity(at))

    def slope(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """Derivative, elementwise."""
        return np.asarray(_full(self.nonlinearity).slope(float(self.at) + np.asarray(sigma, dtype=float)))

    def primitive(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """``int_0^sigma``, elementwise."""
        at, x, phi = float(self.at), np.asarray(sigma, dtype=float), _full(self.nonlinearity)
        return np.asarray(phi.primitive(at + x) - phi.primitive(at) - phi(at) * x)

    def __str__(self) -> str:
        return f"{self.nonlinearity} around {float(self.at):.6g}"


def moved_graph(graph: Graph, at: Fraction) -> PiecewiseLinear:
    """``phi(at + sigma) - phi(at)`` of a piecewise linear nonlinearity, exactly.

    ``graph``: that of ``phi``; ``at``: where ``sigma`` is counted from.
    """
    value = graph.exact(at)
    kinks = [k for k, (x, (s, t)) in enumerate(zip(graph.knots, pairwise(graph.slopes), strict=True)) if s != t]
    points = [(graph.knots[k] - at, graph.values[k] - value) for k in kinks]
    return PiecewiseLinear(
        sorted({*points, (Fraction(0), Fraction(0))}), left_slope=graph.slopes[0], right_slope=graph.slopes[-1]
    )


@lru_cache(maxsize=1024)
def steepest_chord(at: Fraction, within: Fraction) -> Fraction:
    """A bound of all ``(tanh(s + x) - tanh(s))/x`` for ``|s - at| <= within``, at most 1.

    ``at``: not negative; ``within``: positive.

    Notes
    -----
    With ``s > 0`` chords to the right of 0 are less steep than that to 0, as ``tanh`` is concave there; to the left it
    is convex and above its tangent at any ``t < 0``, of slope ``m``: a chord from ``s`` is no steeper than ``m + max(d,
    0)/s`` with ``d = tanh(s) - tanh(t) - m (s - t)``, which is 0 for the ``t`` that is looked for.  Elsewhere ``s``
    adds at most ``max |tanh''| = 4/27^(1/2) < 1`` times ``within``.
    """
    from flint import arb, ctx

    s = float(at)
    if not 1e-6 < s < 1e6:
        return Fraction(1)
    low, high = -s, 0.0
    for _ in range(60):
        t = (low + high) / 2
        low, high = (t, high) if math.tanh(s) - math.tanh(t) > (1 - math.tanh(t) ** 2) * (s - t) else (low, t)
    with ctx.workprec(_BITS):
        x, touched = ball(at), arb(low)
        m = 1 - touched.tanh() * touched.tanh()
        rest = x.tanh() - touched.tanh() - m * (x - touched)
        bound = m + (rest.max(arb(0)) / x) + ball(within)
        above = (bound * arb(2) ** 50).upper().ceil().unique_fmpz()
    return Fraction(1) if above is None else min(Fraction(1), Fraction(int(above), 2**50))


def _full(nonlinearity: Nonlinearity) -> LibraryNonlinearity:
    """A nonlinearity taken to have a slope and a primitive; asking one that has not raises its AttributeError."""
    return nonlinearity  # type: ignore[return-value]  # as said
