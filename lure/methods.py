r"""First-order optimisation methods as plants: ``mu = -grad f(sigma)`` around a pole at ``z = 1``.

A step of length ``a``, momentum ``b`` and extrapolation ``g``,

.. math:: y_t = x_t + g\,(x_t - x_{t-1}), \qquad x_{t+1} = x_t + b\,(x_t - x_{t-1}) - a \nabla f(y_t),

is the loop of ``sigma = y``, ``mu = -grad f(sigma)`` and

.. math:: H(z) = a\,\frac{(1 + g)\,z - g}{(z - 1)(z - b)},

in deviations from the minimiser.  Where the literature has ``u = +grad f(y)`` it has ``-H``.  For ``f`` of one variable
with second derivative within ``[m, L]`` the nonlinearity has slopes in ``[m, L]``, ``SlopeBounds(m, L)``.
"""

from __future__ import annotations

import math
from fractions import Fraction

from lure.errors import InputError
from lure.exact import Exact, exact_number
from lure.plants.rational import RationalPlant


def first_order_method(step: Exact, momentum: Exact = 0, extrapolation: Exact = 0) -> RationalPlant:
    """The plant of a method, one sample an iteration.

    Parameters
    ----------
    step, momentum, extrapolation : int, float, Fraction or Decimal
        ``a > 0``, ``b`` and ``g``, exact: a float means the double it is.

    Returns
    -------
    RationalPlant
        ``H`` in discrete time, of order 1 without momentum and extrapolation, else 2.

    Raises
    ------
    InputError
        A parameter is no number, or the step is not positive.

    Examples
    --------
    >>> print(first_order_method(Fraction(1, 10)))
    0.1 / (z - 1)
    """
    a, b, g = (
        exact_number(value, f"first_order_method: {name}")
        for value, name in ((step, "step"), (momentum, "momentum"), (extrapolation, "extrapolation"))
    )
    if a <= 0:
        raise InputError(f"first_order_method has the step {a}; give a positive one")
    if b == g == 0:
        return RationalPlant([a], [1, -1], dt=1)
    return RationalPlant([a * (1 + g), -a * g], [1, -(1 + b), b], dt=1)


def gradient(m: Exact, L: Exact) -> RationalPlant:
    """The gradient method with the step ``1/L``; its rate is ``1 - m/L``.

    Parameters
    ----------
    m, L : int, float, Fraction or Decimal
        The bounds of the slope of the gradient, ``0 < m < L``.

    Examples
    --------
    >>> print(gradient(1, 10))
    0.1 / (z - 1)
    """
    _, L = _bounds("gradient", m, L)
    return first_order_method(1 / L)


def nesterov(m: Exact, L: Exact) -> RationalPlant:
    r"""Nesterov's method for strongly convex functions: ``a = 1/L``, ``b = g`` with ``kappa = L/m``.

    .. math:: b = g = \frac{\sqrt\kappa - 1}{\sqrt\kappa + 1}.

    Parameters
    ----------
    m, L : int, float, Fraction or Decimal
        As for :func:`gradient`.
    """
    m, L = _bounds("nesterov", m, L)
    root = _root(L / m)
    b = (root - 1) / (root + 1)
    return first_order_method(1 / L, b, b)


def heavy_ball(m: Exact, L: Exact) -> RationalPlant:
    r"""Polyak's heavy ball, tuned for quadratic functions; for others it need not converge.

    .. math:: a = \frac{4}{(\sqrt L + \sqrt m)^2}, \qquad b = \Big(\frac{\sqrt\kappa - 1}{\sqrt\kappa + 1}\Big)^2.

    Parameters
    ----------
    m, L : int, float, Fraction or Decimal
        As for :func:`gradient`.
    """
    m, L = _bounds("heavy_ball", m, L)
    root = _root(L / m)
    return first_order_method(4 / (m * (root + 1) ** 2), ((root - 1) / (root + 1)) ** 2)


def triple_momentum(m: Exact, L: Exact) -> RationalPlant:
    r"""The triple momentum method (Van Scoy, Freeman, Lynch 2018), the fastest known: the rate is ``r``.

    .. math:: r = 1 - \frac{1}{\sqrt\kappa}, \quad a = \frac{1 + r}{L}, \quad b = \frac{r^2}{2 - r}, \quad
        g = \frac{r^2}{(1 + r)(2 - r)}.

    Parameters
    ----------
    m, L : int, float, Fraction or Decimal
        As for :func:`gradient`.
    """
    m, L = _bounds("triple_momentum", m, L)
    r = 1 - 1 / _root(L / m)
    return first_order_method((1 + r) / L, r * r / (2 - r), r * r / ((1 + r) * (2 - r)))


def _bounds(name: str, m: Exact, L: Exact) -> tuple[Fraction, Fraction]:
    low, high = exact_number(m, f"{name}: m"), exact_number(L, f"{name}: L")
    if not 0 < low < high:
        raise InputError(f"{name} has the slopes [{low}, {high}]; give 0 < m < L")
    return low, high


def _root(kappa: Fraction) -> Fraction:
    """The square root, exact where it is rational, else that of doubles."""
    top, bottom = math.isqrt(kappa.numerator), math.isqrt(kappa.denominator)
    exact = Fraction(top, bottom)
    return exact if exact * exact == kappa else Fraction(math.sqrt(kappa))
