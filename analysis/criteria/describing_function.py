"""The gain of a law for the first harmonic of a sinusoid."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import pairwise
from typing import cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.errors import AssumptionError, InputError
from lure.laws import Cubic, GraphLaw, Quantiser, ShiftedLaw
from lure.laws.accepting import control_saturation, is_control_nonlinearity
from lure.nonlinearity import Nonlinearity

_MAX_LEVELS = 2000
_ROUNDING = 1e-12


def describing_function(law: object, amplitude: ArrayLike) -> NDArray[np.float64] | NDArray[np.complex128]:
    r"""Gain of a nonlinearity for the first harmonic of a sinusoid: a hint, from which nothing may be concluded.

    .. math:: N(A) = \frac{2}{\pi A} \int_0^{\pi} \varphi(A \sin t)\, \sin t \, dt,

    real for an odd nonlinearity without memory, of which it lies in the sector; complex for one with memory.

    Parameters
    ----------
    law : Nonlinearity, callable, or control.DescribingFunctionNonlinearity
        An odd nonlinearity.  Closed form for piecewise linear ones, the cubic and the quantiser; for others, functions
        of arrays among them, Gauss quadrature on intervals that halve towards ``t = 0``, so that a steep slope at 0 is
        resolved.  Of one that does not say whether it is odd a sample is taken.  For the nonlinearities with memory of
        python-control (relay with hysteresis, backlash) what their own ``describing_function`` returns.
    amplitude : array_like
        ``A > 0`` [unit of sigma].

    Returns
    -------
    NDArray[np.float64], of complex numbers for a nonlinearity with memory
        ``N``, of the shape of ``amplitude`` [unit of phi / unit of sigma].

    Raises
    ------
    AssumptionError
        The law is not odd, or not known to be: a constant term would take part in the balance.
    InputError
        An amplitude is not a positive finite number, or the law cannot be called.

    References
    ----------
    A. Gelb and W. E. Vander Velde, Multiple-Input Describing Functions and Nonlinear System Design, McGraw-Hill 1968.
    """
    sizes = np.asarray(amplitude, dtype=float)
    if not (np.isfinite(sizes) & (sizes > 0)).all():
        raise InputError("describing_function: an amplitude is not a positive finite number")
    law = control_saturation(law) or law
    if is_control_nonlinearity(law):
        values = [complex(law.describing_function(float(size))) for size in sizes.ravel()]  # type: ignore[attr-defined]
        return np.array(values, dtype=complex).reshape(sizes.shape)
    if not callable(law):
        raise InputError(f"describing_function: the law is {law!r:.60}; give a nonlinearity, or a function of sigma")
    return real_describing_function(cast("Nonlinearity", law), sizes)


def real_describing_function(law: Nonlinearity, sizes: NDArray[np.float64]) -> NDArray[np.float64]:
    """The describing function of an odd nonlinearity without memory.

    Parameters
    ----------
    law : Nonlinearity
        The nonlinearity.
    sizes : NDArray[np.float64]
        Positive amplitudes.

    Raises
    ------
    AssumptionError
        As for :func:`describing_function`.
    """
    if not (getattr(law, "odd", False) if hasattr(law, "odd") else _seems_odd(law, sizes)):
        raise AssumptionError(
            f"the describing function needs an odd law, and {law} is not known to be odd: a constant term would take "
            "part in the balance"
        )
    if isinstance(law, GraphLaw):
        return _of_graph(law, sizes)
    if type(law) is ShiftedLaw:
        return np.asarray(real_describing_function(law.law, sizes) - float(law.gain))
    if type(law) is Cubic:
        return np.asarray(float(law.linear) + 0.75 * float(law.cubic) * sizes**2)
    if type(law) is Quantiser:
        return _of_quantiser(law, sizes)
    return np.array([_by_quadrature(law, float(size)) for size in sizes.ravel()], dtype=float).reshape(sizes.shape)


def _seems_odd(law: Nonlinearity, sizes: NDArray[np.float64]) -> bool:
    """Whether a sample up to the largest amplitude shows no more than rounding between both sides."""
    x = float(sizes.max(initial=1.0)) * np.linspace(0.0, 1.0, 257)[1:]
    right, left = np.asarray(law(x), dtype=float), np.asarray(law(-x), dtype=float)
    return bool((np.abs(right + left) <= _ROUNDING * (np.abs(right) + np.abs(left))).all())


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
