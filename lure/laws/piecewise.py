"""Piecewise linear laws: saturation, relay with slope, dead zone and rectifiers."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.errors import InputError
from lure.laws.graph import Graph
from lure.laws.law import Parameter, assign, exact_parameter, factor_text, number_text, positive
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

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data: parameters, and what is known with its standing."""
        from lure.laws.showing import law_dict

        return law_dict(self)

    def _repr_html_(self) -> str:
        from lure.laws.showing import law_html

        return law_html(self)


@dataclass(frozen=True, slots=True)
class Saturation(GraphLaw):
    r"""Saturation, ``phi(sigma) = min(max(gain sigma, lower_limit), limit)``; sector and slope ``[0, gain]``.

    Parameters
    ----------
    gain : int, float, Fraction, Decimal or str
        Slope between the limits, positive [unit of phi / unit of sigma].
    limit : int, float, Fraction, Decimal or str
        Largest value of ``phi``, positive [unit of phi].
    lower_limit : int, float, Fraction, Decimal, str or None
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
        low, high = (number_text(x) for x in (self.lower_limit, self.limit))
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


@dataclass(frozen=True, slots=True)
class DeadZone(GraphLaw):
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
    graph: Graph = field(init=False, repr=False, compare=False)

    def __init__(self, *, width: Parameter = 1, gain: Parameter = 1) -> None:
        w, g = positive(width, "DeadZone.width"), positive(gain, "DeadZone.gain")
        assign(self, width=w, gain=g, graph=Graph.through([(-w, Fraction(0)), (w, Fraction(0))], g, g))

    def __str__(self) -> str:
        return f"dead zone of |sigma| <= {number_text(self.width)}, then slope {number_text(self.gain)}"


@dataclass(frozen=True, slots=True)
class ReLU(GraphLaw):
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
    graph: Graph = field(init=False, repr=False, compare=False)

    def __init__(self, *, gain: Parameter = 1) -> None:
        g = positive(gain, "ReLU.gain")
        assign(self, gain=g, graph=Graph.through([], Fraction(0), g))

    def __str__(self) -> str:
        return f"ReLU {factor_text(self.gain)}max(sigma, 0)"


@dataclass(frozen=True, slots=True)
class LeakyReLU(GraphLaw):
    """Two slopes that meet at 0; sector and slope bounds are the two, in order, and the law is not odd.

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
    graph: Graph = field(init=False, repr=False, compare=False)

    def __init__(self, *, negative_slope: Parameter = Fraction(1, 100), positive_slope: Parameter = 1) -> None:
        left = exact_parameter(negative_slope, "LeakyReLU.negative_slope")
        right = exact_parameter(positive_slope, "LeakyReLU.positive_slope")
        assign(self, negative_slope=left, positive_slope=right, graph=bent(Graph.through([], left, right), "LeakyReLU"))

    def __str__(self) -> str:
        left, right = number_text(self.negative_slope), number_text(self.positive_slope)
        return f"leaky ReLU with slope {left} for sigma < 0 and {right} for sigma > 0"


def bent(graph: Graph, name: str) -> Graph:
    """The graph, unless it is a straight line.

    Raises
    ------
    InputError
        It is one.
    """
    if graph.is_line:
        gain = number_text(graph.slopes[0])
        raise InputError(f"{name} is the straight line phi = {gain} sigma; a linear gain belongs into the block")
    return graph
