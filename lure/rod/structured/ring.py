"""The waves of the upwind scheme as an f-circulant ring: what leaves it, sums of it, and its echoes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.errors import InputError
from lure.rod.transfer import RodBlock
from lure.rod.upwind import UpwindScheme

# Poisson weights of any mean, to rounding, on the window outside which they are below it.
#
# ``w_n = e^{-tau} tau^n / n!`` for ``tau`` from 0 to ``1e13``.  Written out, the exponent is a small difference of
# numbers of size ``tau log tau``; Stirling's formula takes that difference analytically,
#
# .. math:: \ln w_n = -\tau\,\varphi\!\left(\tfrac{n - \tau}{\tau}\right) - \tfrac12 \ln 2\pi n - \delta_n, \qquad
#     \varphi(e) = (1 + e)\ln(1 + e) - e,
#
# with ``delta_n = 1/(12 n) - ..`` the remainder of Stirling's formula.

Array: TypeAlias = NDArray[np.float64]

LARGEST_MEAN = 1e13
_SERIES = 0.1
_TINY = 1e-290
_TERMS = 20
_STIRLING = 16


@dataclass(frozen=True, kw_only=True, slots=True)
class Mean:
    """A mean ``tau = whole + rest`` with more digits than a double has.

    Attributes
    ----------
    whole : int
        The nearest integer, nonnegative.
    rest : float
        What is left, between -1/2 and 1/2.
    """

    whole: int
    rest: float

    @property
    def value(self) -> float:
        """``tau`` as a double."""
        return float(self.whole) + self.rest


def mean_of(rate: float, time: float) -> Mean:
    """``rate * time`` without rounding.

    Parameters
    ----------
    rate : float
        Cell crossings per second [1/s].
    time : float
        Time, finite and not negative [s].

    Raises
    ------
    InputError
        The time is negative or not finite, or the product is outside the range of doubles.

    Examples
    --------
    >>> mean_of(6e8, 0.1).whole
    60000000
    """
    if not 0.0 <= time < math.inf:
        raise InputError(f"time is {time!r}; give a number of seconds from 0 on")
    product = Fraction(rate) * Fraction(time)
    if product > Fraction(10) ** 300:
        raise InputError(f"time is {time:g} s, more than 1e300 cell crossings; give a shorter one")
    whole = round(product)
    return Mean(whole=whole, rest=float(product - whole))


def parted(tau: float) -> Mean:
    """A double as a :class:`Mean`."""
    whole = round(tau)
    return Mean(whole=whole, rest=tau - whole)


def window(mean: float) -> tuple[int, int]:
    """First and last ``n`` of the window: 9 standard deviations and 20 each way."""
    reach = 9.0 * math.sqrt(mean) + 20.0
    return max(0, math.floor(mean - reach)), math.ceil(mean + reach)


def poisson_weights(mean: Mean) -> tuple[int, Array]:
    """The first index of the window and the weights on it, which sum to one.

    Parameters
    ----------
    mean : Mean
        At most ``1e13``: beyond it the window has more than 50 million terms.

    Raises
    ------
    InputError
        The mean is larger.

    Examples
    --------
    >>> first, weights = poisson_weights(Mean(whole=2, rest=0.0))
    >>> first, weights[:3].round(4)
    (0, array([0.1353, 0.2707, 0.2707]))
    """
    tau = mean.value
    if tau > LARGEST_MEAN:
        raise InputError(f"a Poisson mean of {tau:.3g} has too wide a window; give at most {LARGEST_MEAN:g}")
    first, last = window(tau)
    if tau < _TINY:
        return 0, np.ones(1)
    start = max(first, 1)
    n = np.arange(start, last + 1, dtype=float)
    away = (np.arange(start - mean.whole, last + 1 - mean.whole, dtype=float) - mean.rest) / tau
    weights = np.exp(-tau * _phi(away) - 0.5 * np.log(2.0 * math.pi * n) - _stirling(n))
    if first == 0:
        weights = np.concatenate(([math.exp(-tau)], weights))
    return first, weights / weights.sum()


def _phi(e: Array) -> Array:
    """``(1 + e) log(1 + e) - e``, by its series near 0."""
    near = np.abs(e) < _SERIES
    x = np.where(near, e, 0.0)
    total = np.zeros_like(x)
    for k in range(_TERMS, 1, -1):
        total = (1.0 if k % 2 == 0 else -1.0) / (k * (k - 1)) + x * total
    far = np.where(near, 1.0, e)
    return np.where(near, x * x * total, (1.0 + far) * np.log1p(far) - far)


def _stirling(n: Array) -> Array:
    """``delta_n = ln n! - (n + 1/2) ln n + n - ln(2 pi)/2``."""
    inverse = 1.0 / (n * n)
    remainder = (1.0 / 12.0 - inverse * (1.0 / 360.0 - inverse * (1.0 / 1260.0 - inverse / 1680.0))) / n
    for i in np.flatnonzero(n < _STIRLING):
        k = float(n[i])
        remainder[i] = math.lgamma(k + 1.0) - (k + 0.5) * math.log(k) + k - 0.5 * math.log(2.0 * math.pi)
    return np.asarray(remainder)


# The scaled FFT: eigenvectors of the f-circulant ring, and time jumps that lose no digits to their length.
#
# With ``g^{2N} = 1/f`` the matrix ``diag(g)^{-j} S diag(g)^j`` is ``1/g`` times the cyclic shift, so that the FFT of
# ``g^{-j} y_j`` diagonalises ``S``, with the eigenvalues ``omega = |f|^{1/2N} e^{i theta}``.  In ``e^{tau(omega - 1)}``
# the phase ``tau |omega| sin(theta)`` is of size ``1e5`` and more; but with ``n`` the integer next to ``tau``,
#
# .. math:: e^{\tau(\omega - 1)} = e^{\tau (|\omega| \cos\theta - 1)}\; e^{i n \theta}\;
#     e^{i [(\tau - n)\theta + \tau(|\omega| - 1) \sin\theta + \tau(\sin\theta - \theta)]},
#
# where ``n theta`` is a whole number of parts of a turn, reduced exactly, and the bracket is small for every mode
# that is
# not yet damped away.

Complex: TypeAlias = NDArray[np.complex128]

_GONE = 750.0  # exp(-750) is zero
_SMALL = 0.5


@dataclass(frozen=True, kw_only=True, eq=False)
class Modes:
    """Modes of a ring in order of frequency, with the amplitudes of its state at the start.

    Attributes
    ----------
    ring : Ring
        The ring; ``f`` is not zero.
    """

    ring: Ring

    @property
    def size(self) -> int:
        """``2N``."""
        return 2 * self.ring.scheme.cells

    @property
    def log_growth(self) -> float:
        """``ln|omega| = ln|f|/2N``."""
        return self.ring.log_echo / self.size

    @cached_property
    def order(self) -> NDArray[np.int64]:
        """Indices of the FFT, lowest frequency first."""
        turns = np.abs(2 * np.fft.fftfreq(self.size, 1.0 / self.size) - self._odd)
        return np.argsort(turns, kind="stable")

    @cached_property
    def quarters(self) -> NDArray[np.int64]:
        """``theta`` of each mode in units of ``pi/2N``: even for ``f > 0``, odd for ``f < 0``."""
        turns = np.rint(np.fft.fftfreq(self.size, 1.0 / self.size)).astype(np.int64)
        return np.asarray((self._odd - 2 * turns)[self.order])

    @cached_property
    def theta(self) -> Array:
        """Angles of the eigenvalues [rad]."""
        return np.asarray(math.pi * self.quarters / self.size)

    @cached_property
    def rate(self) -> Complex:
        """``omega - 1``, without cancellation."""
        growth, theta = self.log_growth, self.theta
        real = math.expm1(growth) * np.cos(theta) - 2.0 * np.sin(0.5 * theta) ** 2
        return np.asarray(real + 1j * math.exp(growth) * np.sin(theta))

    @cached_property
    def scale(self) -> Complex:
        """(2N,) ``g^{-j}``."""
        j = np.arange(self.size)
        return np.asarray(np.exp(self.log_growth * j) * self._turned(self._odd * j))

    @cached_property
    def amplitudes(self) -> Complex:
        """(2N,) FFT of the scaled waves, in the order of the modes, divided by ``2N``."""
        return np.asarray(np.fft.fft(self.scale * self.ring.waves)[self.order] / self.size)

    @cached_property
    def at_end(self) -> Complex:
        """(2N,) what each mode contributes to ``y_N``."""
        last = self.ring.scheme.cells - 1
        return np.asarray(self.amplitudes * self._turned(2 * self.order * last) / self.scale[last])

    @cached_property
    def spent(self) -> Array:
        """(2N+1,) what the modes from the given one on contribute to ``s z`` when they are damped away."""
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(self.rate == 0.0, 0.0, -self.at_end / self.rate).real
        return np.concatenate((np.cumsum(share[::-1])[::-1], [0.0]))

    def active(self, tau: float) -> int:
        """Number of modes that are left after ``tau``."""
        damping = math.expm1(self.log_growth) + _GONE / tau if tau > 0.0 else math.inf
        half = 0.5 * damping * math.exp(-self.log_growth)  # sin^2(theta/2) up to which a mode is left
        if half >= 1.0:
            return self.size
        if half <= 0.0:
            return 0
        return int(np.searchsorted(np.abs(self.theta), 2.0 * math.asin(math.sqrt(half)), side="right"))

    def factors(self, mean: Mean, count: int) -> Complex:
        """``e^{tau (omega - 1)}`` of the first ``count`` modes."""
        tau, theta, growth = mean.value, self.theta[:count], math.expm1(self.log_growth)
        fading = tau * growth - 2.0 * tau * (1.0 + growth) * np.sin(0.5 * theta) ** 2
        phase = mean.rest * theta + tau * growth * np.sin(theta) + tau * _sine_defect(theta)
        turns = self._turned((mean.whole % (2 * self.size)) * self.quarters[:count])
        return np.asarray(np.exp(fading) * turns * (np.cos(phase) + 1j * np.sin(phase)))

    def waves(self, mean: Mean) -> Array:
        """(2N,) the waves after ``tau``."""
        count = self.active(mean.value)
        spectrum = np.zeros(self.size, dtype=complex)
        spectrum[self.order[:count]] = self.amplitudes[:count] * self.factors(mean, count)
        return np.asarray((np.fft.ifft(spectrum, norm="forward") / self.scale).real)

    def end(self, mean: Mean) -> tuple[float, float]:
        """``s z`` and ``y_N`` after ``tau``."""
        tau, count = mean.value, self.active(mean.value)
        factors, rate, share = self.factors(mean, count), self.rate[:count], self.at_end[:count]
        early = np.abs(rate) * tau < _SMALL
        with np.errstate(divide="ignore", invalid="ignore"):
            grown = np.where(early, np.expm1(np.where(early, rate, 0.0) * tau), factors - 1.0)
            travelled = np.where(rate == 0.0, tau, grown / rate)
        gap = self.ring.gap + float((share * travelled).real.sum()) + float(self.spent[count])
        return gap, float((share * factors).real.sum())

    @property
    def _odd(self) -> int:
        return 0 if self.ring.echo > 0.0 else 1

    def _turned(self, quarters: NDArray[np.int64]) -> Complex:
        """``e^{i pi quarters/2N}``, the angle reduced exactly."""
        angle = math.pi * (quarters % (2 * self.size)) / self.size
        return np.asarray(np.cos(angle) + 1j * np.sin(angle))


def _sine_defect(theta: Array) -> Array:
    """``sin(theta) - theta``, by its series below 1."""
    x = np.where(np.abs(theta) < 1.0, theta, 0.0)
    square, total = x * x, np.ones_like(x)
    for k in range(9, 1, -1):
        total = 1.0 - square / (2 * k * (2 * k + 1)) * total
    return np.where(np.abs(theta) < 1.0, -x * square / 6.0 * total, np.sin(theta) - theta)


@dataclass(frozen=True, kw_only=True, eq=False)
class Ring:
    r"""Waves ``y`` in the order (39) and the scaled coordinate ``s z``, in units of ``1/s``: ``y' = (S - 1) y``.

    ``S`` shifts by one cell and closes the ring with ``f = -a``; read backwards, ``Y_{i - 2N} = f Y_i`` continues the
    waves for ever, and ``S^n`` only moves the place at which that stream is read.

    Attributes
    ----------
    scheme : UpwindScheme
        The scheme.
    waves : ndarray
        (2N,) at the start [m/s].
    gap : float
        ``s z`` at the start [m/s].
    """

    scheme: UpwindScheme
    waves: Array
    gap: float

    @property
    def echo(self) -> float:
        """``f = -a``."""
        return -self.scheme.rod.reflection

    @cached_property
    def log_echo(self) -> float:
        """``ln|f|``, accurate near ``|f| = 1``; ``-inf`` for ``k = Z``."""
        return RodBlock(self.scheme.rod).log_reflection

    @property
    def opening(self) -> float:
        """``1 - f = 2k/(k + Z)``, without cancellation."""
        return 2.0 * self.scheme.rod.damping * self.scheme.rod.input_gain

    @cached_property
    def stream(self) -> Array:
        """(2N,) what leaves the forward wave at the shifts ``0 .. 2N-1``; later ``f`` times what left 2N before."""
        N = self.scheme.cells
        return np.concatenate((self.waves[N - 1 :: -1], self.echo * self.waves[: N - 1 : -1]))

    @cached_property
    def sums(self) -> Array:
        """(2N+1,) ``R_r``, the first ``r`` terms of the stream added up."""
        return np.concatenate(([0.0], np.cumsum(self.stream)))

    def power(self, m: ArrayLike) -> Array:
        """``f^m`` for whole ``m >= 0``."""
        trips = np.asarray(m, dtype=float)
        with np.errstate(invalid="ignore", over="ignore"):
            size = np.where(trips == 0.0, 1.0, np.exp(trips * self.log_echo))
        return np.asarray(size if self.echo >= 0.0 else size * (1.0 - 2.0 * (trips % 2.0)))

    def series(self, m: ArrayLike) -> Array:
        """``1 + f + .. + f^{m-1}`` for whole ``m >= 0``."""
        trips = np.asarray(m, dtype=float)
        if self.opening == 0.0:
            return trips
        with np.errstate(invalid="ignore", over="ignore"):
            if self.echo > 0.0:
                return np.asarray(-np.expm1(trips * self.log_echo) / self.opening)
            return np.asarray((1.0 - self.power(trips)) / self.opening)

    def gaps(self, n: NDArray[np.int64]) -> Array:
        """``s z`` after ``n`` shifts: the start and the first ``n`` terms of the stream."""
        size = 2 * self.scheme.cells
        trips = n // size
        left = n - trips * size
        return np.asarray(self.gap + self.series(trips) * self.sums[-1] + self.power(trips) * self.sums[left])

    def leaving(self, n: NDArray[np.int64]) -> Array:
        """``Y_{N-n}``: what the last cell of the forward wave holds after ``n`` shifts."""
        size = 2 * self.scheme.cells
        trips = n // size
        return np.asarray(self.power(trips) * self.stream[n - trips * size])

    def largest_gap(self, trips: float = math.inf) -> float:
        """Bound of ``s z`` over the next ``trips`` round trips: the largest value after any number of shifts.

        ``s z`` is an average of these values with positive weights.  For ``|f| <= 1`` they are ``C + f^m (R_r - C)``
        with ``C = R_2N/(1 - f)``: extreme at ``m`` = 0, 1 or infinity; for ``f = 1`` they are ``m R_2N + R_r``.  For
        ``|f| > 1`` the bound is ``inf``.
        """
        if self.log_echo > 0.0:
            return math.inf
        trip, highest, lowest = float(self.sums[-1]), float(self.sums.max()), float(self.sums.min())
        if self.opening == 0.0:
            return self.gap + highest + (trip * trips if trip > 0.0 else 0.0)
        limit = trip / self.opening
        once = limit + self.echo * ((highest if self.echo > 0.0 else lowest) - limit)
        return self.gap + max(highest, limit, once)
