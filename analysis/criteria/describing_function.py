"""The gain of a law for the first harmonic of a sinusoid."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.errors import AssumptionError, InputError
from lure.laws import Cubic, GraphLaw, Quantiser, ShiftedLaw
from lure.nonlinearity import Nonlinearity

_MAX_LEVELS = 2000


def describing_function(law: Nonlinearity, amplitude: ArrayLike) -> NDArray[np.float64]:
    r"""Gain of the law for the first harmonic of a sinusoid.

    .. math:: N(A) = \frac{2}{\pi A} \int_0^{\pi} \varphi(A \sin t)\, \sin t \, dt,

    real because the law is odd and has no memory; it lies in the law's sector.

    Parameters
    ----------
    law : Nonlinearity
        An odd law.  Closed form for piecewise linear laws, the cubic and the quantiser; for others Gauss quadrature on
        intervals that halve towards ``t = 0``, so that a steep slope at 0 is resolved.
    amplitude : array_like
        ``A > 0`` [unit of sigma].

    Returns
    -------
    NDArray[np.float64]
        ``N``, of the shape of ``amplitude`` [unit of phi / unit of sigma].

    Raises
    ------
    AssumptionError
        The law is not known to be odd: a constant term would take part in the balance.
    InputError
        An amplitude is not a positive finite number.

    References
    ----------
    A. Gelb and W. E. Vander Velde, Multiple-Input Describing Functions and Nonlinear System Design, McGraw-Hill 1968.
    """
    if not getattr(law, "odd", False):
        raise AssumptionError(
            f"the describing function needs an odd law, and {law} is not known to be odd: a constant term would take "
            "part in the balance"
        )
    sizes = np.asarray(amplitude, dtype=float)
    if not (np.isfinite(sizes) & (sizes > 0)).all():
        raise InputError("describing_function: an amplitude is not a positive finite number")
    if isinstance(law, GraphLaw):
        return _of_graph(law, sizes)
    if type(law) is ShiftedLaw:
        return np.asarray(describing_function(law.law, sizes) - float(law.gain))
    if type(law) is Cubic:
        return np.asarray(float(law.linear) + 0.75 * float(law.cubic) * sizes**2)
    if type(law) is Quantiser:
        return _of_quantiser(law, sizes)
    return np.array([_by_quadrature(law, float(size)) for size in sizes.ravel()], dtype=float).reshape(sizes.shape)


def _of_graph(law: GraphLaw, sizes: NDArray[np.float64]) -> NDArray[np.float64]:
    """An odd polygon is a line and saturations.

    With the slopes ``s_i`` between the corners ``x_i > 0``,
    ``N = s_last + sum (s_(i-1) - s_i) f(x_i/A)``, ``f(r) = (2/pi)(asin r + r sqrt(1 - r^2))`` up to ``r = 1``, then 1.
    """
    right = law.graph.knots.index(Fraction(0))
    corners, slopes = law.graph.knots[right + 1 :], law.graph.slopes[right + 1 :]
    total = np.full(sizes.shape, float(slopes[-1]))
    for corner, (before, after) in zip(corners, pairwise(slopes), strict=True):
        r = np.minimum(float(corner) / sizes, 1.0)
        total = total + float(before - after) * (2 / math.pi) * (np.arcsin(r) + r * np.sqrt((1 - r) * (1 + r)))
    return np.asarray(total)


def _of_quantiser(law: Quantiser, sizes: NDArray[np.float64]) -> NDArray[np.float64]:
    """``(4 step / (pi A)) sum sqrt(1 - (c/A)^2)`` over the jumps ``c < A``; 1 from so many on that it is 1 to 1e-6."""
    step = float(law.step)
    result = np.ones(sizes.shape)
    for place in np.ndindex(sizes.shape):
        size = float(sizes[place]) / step
        if size <= _MAX_LEVELS:
            ratio = (np.arange(math.floor(size + 0.5)) + 0.5) / size
            result[place] = 4 / (math.pi * size) * np.sqrt((1 - ratio) * (1 + ratio)).sum()
    return result


_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)


def _by_quadrature(law: Nonlinearity, size: float) -> float:
    """Gauss quadrature between 0, the dyadic fractions of a quarter period, and the corners of the law."""
    corners = [math.asin(float(x) / size) for x in getattr(law, "breakpoints", ()) if 0 < x < size]
    cuts = np.unique([0.0, *(math.pi / 2 * 2.0**-j for j in range(60)), *corners])
    half = np.diff(cuts)[:, None] / 2
    t = cuts[:-1, None] + half * (_NODES + 1)
    sine = np.sin(t)
    return float(4 / (math.pi * size) * (half * _WEIGHTS * law(size * sine) * sine).sum())
