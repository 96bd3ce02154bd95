"""The nonlinearity of a shifted loop, ``phi(sigma) - gain sigma``."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

from lure.arrays import ArrayLike, NDArray, np
from lure.classes import NonlinearityClass, Sector, SlopeBounds
from lure.exact import Exact, exact_number
from lure.nonlinearities.base import LibraryNonlinearity, NamedNonlinearity, Nonlinearity
from lure.nonlinearities.named import Cubic
from lure.nonlinearities.piecewise_linear import GraphNonlinearity, PiecewiseLinear
from lure.record.values import exact_text


class ShiftedNonlinearity(NamedNonlinearity, kw_only=False):
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
    def regularity(self) -> str:
        """That of the nonlinearity."""
        return str(getattr(self.nonlinearity, "regularity", "unknown"))

    @property
    def locally_lipschitz(self) -> bool:
        """Whether the nonlinearity is known to be."""
        return bool(getattr(self.nonlinearity, "locally_lipschitz", False))

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

    Parameters
    ----------
    bound : int, float or Fraction
        A bound; a float means the double it is.
    gain : Fraction
        What is subtracted.
    """
    return bound if bound in (math.inf, -math.inf) else Fraction(bound) - gain


def _full(nonlinearity: Nonlinearity) -> LibraryNonlinearity:
    """A nonlinearity taken to have a slope and a primitive; asking one that has not raises its AttributeError."""
    return nonlinearity  # type: ignore[return-value]  # as said
