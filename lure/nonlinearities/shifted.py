"""The law of a shifted loop, ``phi(sigma) - gain sigma``."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

from lure.arrays import ArrayLike, NDArray, np
from lure.classes import NonlinearityClass, Sector, SlopeBounds
from lure.exact import Exact, exact_number
from lure.nonlinearities.base import Law, NamedNonlinearity, Nonlinearity, number_text
from lure.nonlinearities.named import Cubic
from lure.nonlinearities.piecewise_linear import GraphNonlinearity, PiecewiseLinear


class ShiftedNonlinearity(NamedNonlinearity, kw_only=False):
    """``phi(sigma) - gain sigma`` of another law; made by :func:`shifted_law`.

    Attributes
    ----------
    law : Nonlinearity
        The law ``phi``.  Where it has no ``slope`` or ``primitive``, the shifted law raises the same AttributeError.
    gain : Fraction
        What is subtracted.
    """

    law: Nonlinearity
    gain: Fraction

    @property
    def sector(self) -> Sector:
        """The sector of the law, both bounds less ``gain``."""
        bounds = self.law.sector
        return Sector(shifted_bound(bounds.lower, self.gain), shifted_bound(bounds.upper, self.gain))

    @property
    def slope_bounds(self) -> SlopeBounds | None:
        """The slope bounds of the law, both less ``gain``."""
        bounds: SlopeBounds | None = getattr(self.law, "slope_bounds", None)
        if bounds is None:
            return None
        return SlopeBounds(shifted_bound(bounds.lower, self.gain), shifted_bound(bounds.upper, self.gain))

    @property
    def odd(self) -> bool:
        """Whether the law is odd."""
        return bool(getattr(self.law, "odd", False))

    @property
    def regularity(self) -> str:
        """That of the law."""
        return str(getattr(self.law, "regularity", "unknown"))

    @property
    def locally_lipschitz(self) -> bool:
        """Whether the law is known to be."""
        return bool(getattr(self.law, "locally_lipschitz", False))

    @property
    def breakpoints(self) -> tuple[Fraction, ...]:
        """Those of the law."""
        return tuple(getattr(self.law, "breakpoints", ()))

    def __call__(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """Values, elementwise."""
        return np.asarray(self.law(sigma) - float(self.gain) * np.asarray(sigma, dtype=float))

    def slope(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """Derivative, elementwise."""
        return np.asarray(_full(self.law).slope(sigma) - float(self.gain))

    def primitive(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """``int_0^sigma``, elementwise."""
        square = np.asarray(sigma, dtype=float) ** 2
        return np.asarray(_full(self.law).primitive(sigma) - 0.5 * float(self.gain) * square)

    def __str__(self) -> str:
        sign = "+" if self.gain < 0 else "-"
        return f"({self.law}) {sign} {number_text(abs(self.gain))} sigma"


def shifted_law(law: Nonlinearity, gain: Exact) -> Nonlinearity:
    """The law ``phi(sigma) - gain sigma``, with its properties moved along exactly.

    It belongs with the block ``H/(1 + gain H)``, see :func:`lure.loop.pole_shift`.

    Parameters
    ----------
    law : Nonlinearity
        The law ``phi``.
    gain : int, float, Fraction or Decimal
        What is subtracted, finite; a shift by ``-gain`` undoes it.

    Returns
    -------
    Nonlinearity
        A law of the library where there is one (``PiecewiseLinear``, ``Cubic``), else a
        :class:`ShiftedNonlinearity`; the law itself for ``gain = 0``.

    Raises
    ------
    InputError
        ``gain`` is not a finite number.

    Examples
    --------
    >>> from lure.nonlinearities import Saturation
    >>> print(shifted_law(Saturation(gain=1, limit=1), 1).sector)
    [-1, 0]
    """
    g = exact_number(gain, "shifted_law: gain")
    if g == 0:
        return law
    if isinstance(law, GraphNonlinearity):
        moved = law.graph.shifted(g)
        points = list(zip(moved.knots, moved.values, strict=True))
        return PiecewiseLinear(points, left_slope=moved.slopes[0], right_slope=moved.slopes[-1])
    if type(law) is Cubic:
        return Cubic(linear=law.linear - g, cubic=law.cubic)
    if type(law) is ShiftedNonlinearity:
        return law.law if law.gain + g == 0 else ShiftedNonlinearity(law.law, law.gain + g)
    return ShiftedNonlinearity(law, g)


def shifted_class(law_class: NonlinearityClass, gain: Fraction) -> NonlinearityClass:
    """The class of all ``phi(sigma) - gain sigma``; parity and time dependence stay.

    Parameters
    ----------
    law_class : NonlinearityClass
        The class of ``phi``.
    gain : Fraction
        What is subtracted.
    """
    sector, slope = law_class.sector, law_class.slope
    return replace(
        law_class,
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


def _full(law: Nonlinearity) -> Law:
    """A law taken to have a slope and a primitive; asking one that has not raises its AttributeError."""
    return law  # type: ignore[return-value]  # as said
