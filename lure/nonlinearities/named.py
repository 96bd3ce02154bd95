"""Nonlinearities in closed form: the cubic, the hyperbolic tangent and the uniform quantiser."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Literal

from lure.arrays import ArrayLike, NDArray, np
from lure.classes import Sector, SlopeBounds
from lure.errors import InputError
from lure.exact import exact_number
from lure.nonlinearities.base import (
    NamedNonlinearity,
    Parameter,
    assign,
    exact_parameter,
    factor_text,
    positive,
)
from lure.record.values import exact_text

# The uniform quantiser: a nonlinearity with jumps, known by its sector alone.

QuantiserKind = Literal["mid-tread"]


class Quantiser(NamedNonlinearity):
    r"""Rounding to the nearest multiple of ``step``, halves away from 0; the sector is ``[0, 2]``, whatever the step.

    ``phi`` jumps, so that it has no slope bounds, and in continuous time a loop with it is a differential inclusion:
    theorems for locally Lipschitz nonlinearities do not apply.  In discrete time sector criteria do.

    Parameters
    ----------
    step : int, float, Fraction, Decimal or str
        Positive [unit of sigma].
    kind : {"mid-tread"}
        A quantiser with 0 among its levels.  The mid-riser, which jumps at 0, lies in no sector with a finite bound.

    Raises
    ------
    InputError
        ``step`` is not a positive finite number, or the kind is another.

    Examples
    --------
    >>> nonlinearity = Quantiser(step=1)
    >>> print(nonlinearity([0.49, 0.5, -2.5]), nonlinearity.sector, nonlinearity.slope_bounds)
    [ 0.  1. -3.] [0, 2] None
    """

    step: Fraction
    kind: QuantiserKind
    slope_bounds = None  # a jump has no finite slope
    odd, locally_lipschitz, regularity = True, False, "piecewise constant, discontinuous"

    def __init__(self, *, step: Parameter = 1, kind: QuantiserKind = "mid-tread") -> None:
        if kind != "mid-tread":
            raise InputError(
                f"Quantiser.kind is {kind!r:.60}; only 'mid-tread' is offered: a mid-riser jumps at sigma = 0 and lies "
                "in no sector with a finite bound"
            )
        assign(self, step=positive(step, "Quantiser.step"), kind=kind)

    @property
    def sector(self) -> Sector:
        """``[0, 2]``: 0 up to half a step, 2 at half a step."""
        return Sector(0, 2)

    def exact(self, sigma: Fraction) -> Fraction:
        """Value at an exact point, exactly."""
        level = int(abs(sigma) / self.step + Fraction(1, 2)) * self.step
        return level if sigma >= 0 else -level

    def __call__(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """Values ``phi(sigma)``, elementwise."""
        return np.asarray(float(self.step) * self._level(sigma))

    def slope(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """Zero: the derivative wherever there is one; it says nothing about the jumps."""
        x = np.asarray(sigma, dtype=float)
        return np.where(np.isnan(x), x, 0.0)

    def primitive(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """``int_0^sigma phi``, elementwise: a continuous polygon."""
        step = float(self.step)
        with np.errstate(over="ignore", invalid="ignore"):
            n = np.abs(self._level(sigma))
            return np.asarray(step * n * (np.abs(np.asarray(sigma, dtype=float)) - 0.5 * step * n))

    def _level(self, sigma: ArrayLike) -> NDArray[np.float64]:
        with np.errstate(over="ignore", invalid="ignore"):
            steps = np.asarray(sigma, dtype=float) / float(self.step)
            size = np.abs(steps)
            whole = np.floor(size)
            level = np.copysign(whole + (size - whole >= 0.5), steps)
            return np.asarray(level + 0.0)  # no negative zeros

    def __str__(self) -> str:
        return f"mid-tread quantiser of step {exact_text(self.step)}"


class Cubic(NamedNonlinearity):
    r"""``phi(sigma) = linear sigma + cubic sigma^3``.

    Sector and slope bounds are ``[linear, inf]`` for ``cubic > 0``, ``[-inf, linear]`` for ``cubic < 0``; the finite
    bound of the sector is approached as ``sigma -> 0``.

    Parameters
    ----------
    linear, cubic : int, float, Fraction, Decimal or str
        Coefficients; ``cubic`` is not 0.

    Raises
    ------
    InputError
        A coefficient is not a finite number, or ``cubic`` is 0.

    Examples
    --------
    >>> nonlinearity = Cubic(cubic=1, linear=2)
    >>> print(nonlinearity.sector, nonlinearity.slope(1.0))
    [2, inf] 5.0
    """

    linear: Fraction
    cubic: Fraction
    odd, locally_lipschitz, regularity = True, True, "polynomial, locally Lipschitz"

    def __init__(self, *, linear: Parameter = 0, cubic: Parameter = 1) -> None:
        a, b = exact_parameter(linear, "Cubic.linear"), exact_parameter(cubic, "Cubic.cubic")
        if b == 0:
            raise InputError("Cubic.cubic is 0; give another number, a linear gain belongs into the block")
        assign(self, linear=a, cubic=b)

    @property
    def sector(self) -> Sector:
        """``[linear, inf]`` or ``[-inf, linear]``."""
        return Sector(self.linear, math.inf) if self.cubic > 0 else Sector(-math.inf, self.linear)

    @property
    def slope_bounds(self) -> SlopeBounds:
        """``[linear, inf]`` or ``[-inf, linear]``."""
        return SlopeBounds(self.sector.lower, self.sector.upper)

    def exact(self, sigma: Fraction) -> Fraction:
        """Value at an exact point, exactly."""
        return sigma * (self.linear + self.cubic * sigma * sigma)

    def __call__(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """Values ``phi(sigma)``, elementwise."""
        return np.asarray(self._even(sigma, 1.0, 1.0) * np.asarray(sigma, dtype=float))

    def slope(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """Derivative ``linear + 3 cubic sigma^2``, elementwise."""
        return self._even(sigma, 1.0, 3.0)

    def primitive(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """``linear sigma^2/2 + cubic sigma^4/4``, elementwise."""
        with np.errstate(over="ignore", under="ignore", invalid="ignore"):
            return np.asarray(self._even(sigma, 0.5, 0.25) * np.asarray(sigma, dtype=float) ** 2)

    def _even(self, sigma: ArrayLike, first: float, second: float) -> NDArray[np.float64]:
        with np.errstate(over="ignore", under="ignore"):
            square = np.asarray(sigma, dtype=float) ** 2
            return np.asarray(first * float(self.linear) + second * float(self.cubic) * square)

    def __str__(self) -> str:
        if self.linear == 0:
            return f"cubic {factor_text(self.cubic)}sigma^3"
        sign = "-" if self.cubic < 0 else "+"
        return f"cubic {factor_text(self.linear)}sigma {sign} {factor_text(abs(self.cubic))}sigma^3"


class Tanh(NamedNonlinearity):
    r"""``phi(sigma) = gain tanh(sigma / scale)``, with values in ``(-gain, gain)`` and the slope ``gain/scale`` at 0.

    Sector and slope bounds are ``[0, gain/scale]``: the slope ``(gain/scale) / cosh^2(sigma/scale)`` falls from its
    largest value at 0 to 0 at infinity, which it does not attain.

    Parameters
    ----------
    scale : int, float, Fraction, Decimal or str
        Positive [unit of sigma].
    gain : int, float, Fraction, Decimal or str
        Positive [unit of phi].

    Raises
    ------
    InputError
        A parameter is not a positive finite number.

    Examples
    --------
    >>> nonlinearity = Tanh(gain=2)
    >>> print(nonlinearity.sector, f"{nonlinearity(0.5):.4f}")
    [0, 2] 0.9242
    """

    scale: Fraction
    gain: Fraction
    odd, locally_lipschitz, regularity = True, True, "analytic, globally Lipschitz"

    def __init__(self, *, scale: Parameter = 1, gain: Parameter = 1) -> None:
        d, g = positive(scale, "Tanh.scale"), positive(gain, "Tanh.gain")
        exact_number(g / d, "Tanh: the slope gain/scale")
        assign(self, scale=d, gain=g)

    @property
    def sector(self) -> Sector:
        """``[0, gain/scale]``."""
        return Sector(0, self.gain / self.scale)

    @property
    def slope_bounds(self) -> SlopeBounds:
        """``[0, gain/scale]``."""
        return SlopeBounds(0, self.gain / self.scale)

    def __call__(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """Values ``phi(sigma)``, elementwise."""
        return np.asarray(float(self.gain) * np.tanh(self._scaled(sigma)))

    def slope(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """Derivative, elementwise."""
        with np.errstate(over="ignore", under="ignore"):
            return np.asarray(float(self.gain / self.scale) / np.cosh(self._scaled(sigma)) ** 2)

    def primitive(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """``gain scale log cosh(sigma/scale)``, elementwise."""
        u = np.abs(self._scaled(sigma))
        with np.errstate(over="ignore", under="ignore"):
            near = np.log1p(2 * np.sinh(np.minimum(u, 1.0) / 2) ** 2)
            far = u + np.log1p(np.exp(-2 * u)) - math.log(2)
            return np.asarray(float(self.gain) * float(self.scale) * np.where(u < 1, near, far))

    def _scaled(self, sigma: ArrayLike) -> NDArray[np.float64]:
        with np.errstate(over="ignore", under="ignore"):
            return np.asarray(np.asarray(sigma, dtype=float) / float(self.scale))

    def __str__(self) -> str:
        inner = "sigma" if self.scale == 1 else f"sigma / {exact_text(self.scale)}"
        return f"{factor_text(self.gain)}tanh({inner})"
