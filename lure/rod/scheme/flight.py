r"""Free flight of the upwind scheme in one jump of any length, for very many cells.

With ``g^{2N} = 1/f`` the matrix ``diag(g)^{-j} S diag(g)^j`` is ``1/g`` times the cyclic shift, so that the FFT of
``g^{-j} y_j`` diagonalises ``S``, with the eigenvalues ``omega = |f|^{1/2N} e^{i theta}``.  In ``e^{tau(omega - 1)}``
the phase ``tau |omega| sin(theta)`` is of size ``1e5`` and more; but with ``n`` the integer next to ``tau``,

.. math:: e^{\tau(\omega - 1)} = e^{\tau (|\omega| \cos\theta - 1)}\; e^{i n \theta}\;
    e^{i [(\tau - n)\theta + \tau(|\omega| - 1) \sin\theta + \tau(\sin\theta - \theta)]},

where ``n theta`` is a whole number of parts of a turn, reduced exactly, and the bracket is small for every mode that is
not yet damped away.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.arrays import Reals as Array
from lure.errors import InputError
from lure.record import described, quantity
from lure.rod.discretisation import UpwindScheme
from lure.rod.scenario import Scenario, initial_state
from lure.rod.scheme.poisson import Mean, mean_of, poisson_weights
from lure.rod.scheme.register import RegisterState, ShiftRegister

Complex = NDArray[np.complex128]
Way = Literal["auto", "modes", "poisson"]

_FAINT, _LOUD = math.log(0.1), math.log(10.0)
_DEAD = 2000
_GONE = 750.0  # exp(-750) is zero
_SMALL = 0.5


@described(frozen=True, kw_only=True, eq=False)
class Modes:
    """Modes of a ring in order of frequency, with the amplitudes of its state at the start."""

    start: RegisterState = quantity("The state; ``f`` is not zero")

    @property
    def register(self) -> ShiftRegister:
        """The ring."""
        return self.start.register

    @property
    def size(self) -> int:
        """``2N``."""
        return 2 * self.register.cells

    @property
    def log_growth(self) -> float:
        """``ln|omega| = ln|f|/2N``."""
        return self.register.log_echo / self.size

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
        return np.asarray(np.fft.fft(self.scale * self.start.waves)[self.order] / self.size)

    @cached_property
    def at_end(self) -> Complex:
        """(2N,) what each mode contributes to ``y_N``."""
        last = self.register.cells - 1
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
        gap = self.start.gap + float((share * travelled).real.sum()) + float(self.spent[count])
        return gap, float((share * factors).real.sum())

    @property
    def _odd(self) -> int:
        return 0 if self.register.echo > 0.0 else 1

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


@described(frozen=True, kw_only=True, eq=False)
class FreeFlight:
    """The scheme without contact and without loads, ``y' = A y``: any time in one step.

    Its ring of ``2N`` waves is f-circulant, ``f = -a``.  Two ways to ``exp(t A)``:

    - *modes*: a scaled FFT diagonalises it (:mod:`lure.rod.scheme.flight`), cost ``O(N log N)`` for any time; for
      ``0.1 <= |a| <= 10``, since scaling costs a factor ``max(|a|, 1/|a|)`` in accuracy;
    - *Poisson*: ``exp(t A) = sum_n w_n S^n`` with Poisson weights of mean ``s t``, folded onto the ring and convolved;
      for every ``a``, also ``a = 0`` (``k = Z``) where the ring is one Jordan block and has no eigenvectors to speak
      of, and ``s t <= 1e13``.

    Make one with :func:`free_flight`.  Contact is not modelled: what is returned after the end has touched the obstacle
    is the motion of a rod without one; see :func:`lure.rod.scheme.first_contact`.

    Notes
    -----
    It is a motion of the scheme, whose waves lose more energy than the rod's.  The mean ``s t`` is taken without
    rounding, so that times are as exact as the double ``s = c N/L``.
    """

    start: RegisterState = quantity("The scheme and its state at the start")

    @property
    def register(self) -> ShiftRegister:
        """The ring."""
        return self.start.register

    @cached_property
    def modes(self) -> Modes | None:
        """The scaled FFT of the start; None where it would lose digits."""
        return Modes(start=self.start) if _FAINT <= self.register.log_echo <= _LOUD else None

    def state(self, t: float, *, way: Way = "auto") -> Array:
        """State (2N+1,) at one time, in the ordering of the scheme.

        Parameters
        ----------
        t : float
            Time, from 0 on [s].
        way : {"auto", "modes", "poisson"}
            How; ``"auto"`` takes the modes wherever they are accurate.

        Raises
        ------
        InputError
            The time is not a nonnegative number, the way does not apply, or the motion (``k < 0``) has grown beyond
            doubles.
        """
        return self.after(mean_of(self.register.rate, t), way=way).state

    def after(self, mean: Mean, *, way: Way = "auto") -> RegisterState:
        """What the register holds at the time ``mean`` in units of ``1/s``; errors as for :meth:`state`."""
        with np.errstate(over="ignore", invalid="ignore"):
            modes = self.modes if self._uses_modes(way) else None
            waves, gap = self._by_poisson(mean) if modes is None else (modes.waves(mean), modes.end(mean)[0])
        if not (np.isfinite(waves).all() and math.isfinite(gap)):
            raise InputError("the motion has grown beyond the range of doubles (damping < 0); give an earlier time")
        return RegisterState(register=self.register, waves=waves, gap=gap)

    def end(self, t: ArrayLike) -> tuple[Array, Array]:
        """Contact coordinate ``z`` [m] and last forward wave ``y_N = z'`` [m/s] at the times ``t`` [s], elementwise.

        Parameters
        ----------
        t : array_like
            Times from 0 on.

        Raises
        ------
        InputError
            As for :meth:`state`.

        Notes
        -----
        A value costs ``O(sqrt(N))`` at most where modes serve: early by the Poisson weights, which are few then, later
        by the modes, of which few are left then.
        """
        times = np.asarray(t, dtype=float)
        pairs = np.array([self.end_at(mean_of(self.register.rate, float(time))) for time in times.ravel()])
        pairs = pairs.reshape(*times.shape, 2)
        if not np.isfinite(pairs).all():
            raise InputError("the motion has grown beyond the range of doubles (damping < 0); give earlier times")
        return pairs[..., 0] / self.register.rate, pairs[..., 1]

    def discrepancy(self, t: float) -> float:
        """Estimate of the error at ``t``: largest difference of the waves between the two ways.

        Parameters
        ----------
        t : float
            Time [s].

        Returns
        -------
        float
            Relative to the largest wave at the start.  Observed, not proved: the two share the initial state, the
            rate ``s`` and the echo ``f``, and nothing else.

        Raises
        ------
        InputError
            Only one of the ways applies.
        """
        largest = float(np.abs(self.start.waves).max())
        one, two = self.state(t, way="modes"), self.state(t, way="poisson")
        keep = self.register.scheme.permutation < 2 * self.register.cells
        return float(np.abs(one - two)[keep].max()) / (largest or 1.0)

    def _uses_modes(self, way: Way) -> bool:
        if way not in ("auto", "modes", "poisson"):
            raise InputError(f"way is {way!r}; give auto, modes or poisson")
        if way == "modes" and self.modes is None:
            raise InputError(
                f"the scaled FFT loses too many digits for a = {-self.register.echo:.6g}, outside 0.1 <= |a| <= 10; "
                'give way="poisson"'
            )
        return way != "poisson" and self.modes is not None

    def _by_poisson(self, mean: Mean) -> tuple[Array, float]:
        start, size = self.start, 2 * self.register.cells
        n, weights = self._terms(mean)
        trips = n // size
        kernel = np.bincount(n - trips * size, weights=weights * self.register.power(trips), minlength=size)
        product = np.fft.rfft(kernel, 2 * size) * np.fft.rfft(start.waves, 2 * size)
        convolved = np.fft.irfft(product, 2 * size)
        return convolved[:size] + self.register.echo * convolved[size:], float(weights @ start.gaps(n))

    def end_at(self, mean: Mean) -> tuple[float, float]:
        """``s z`` and ``y_N`` [m/s] at the time ``mean`` in units of ``1/s``."""
        few = 18.0 * math.sqrt(mean.value) + 40.0 < 2 * self.register.cells
        if self.modes is not None and not (few and 18.0 * math.sqrt(mean.value) < self.modes.active(mean.value)):
            return self.modes.end(mean)
        n, weights = self._terms(mean)
        return float(weights @ self.start.gaps(n)), float(weights @ self.start.leaving(n))

    def _terms(self, mean: Mean) -> tuple[NDArray[np.int64], Array]:
        """Indices and weights of the window, which echoes that grow must not carry away by a standard deviation."""
        register = self.register
        if register.log_echo > 0.0 and mean.value * register.log_echo**2 > 2.0 * register.cells**2:
            raise InputError(
                f"a = {-register.echo:.6g} amplifies the tail of the Poisson weights; give an earlier time"
            )
        if register.log_echo < _FAINT:  # a wave has sunk below the range of doubles after so many echoes
            mean = Mean(whole=min(mean.whole, _DEAD * register.cells), rest=mean.rest)
        first, weights = poisson_weights(mean)
        return np.arange(first, first + weights.size), weights


def free_flight(scheme: UpwindScheme, start: Scenario | ArrayLike) -> FreeFlight:
    """Free flight of a scheme from the initial data of a scenario, or from a state.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme, in any ordering.
    start : Scenario or array_like
        Initial data, without loads; or a state (2N+1,) in the ordering of the scheme.

    Raises
    ------
    InputError
        The scenario has loads, or the state another shape or a number that is not finite.

    Examples
    --------
    >>> from lure.rod import builtin_system, upwind
    >>> system = builtin_system("paper-rod")
    >>> flight = free_flight(upwind(system.rod, 1000), system.scenario)
    >>> z, _ = flight.end([0.0, system.rod.travel_time, 100.0])
    >>> (z + system.rod.gap).round(7)
    array([-1.0e-04,  9.5e-05,  1.0e-04])
    """
    if isinstance(start, Scenario):
        for name, load in (("g", start.force), ("f", start.body_force)):
            if not load.is_zero:
                raise InputError(
                    f"force.{name} is {load}; free_flight takes no loads, give 0 (structured_motion takes a force)"
                )
        state = initial_state(scheme, start)
    else:
        state = np.array(start, dtype=float)
    if state.shape != (scheme.order,) or not np.isfinite(state).all():
        raise InputError(f"start has shape {state.shape} or is not finite; give a state ({scheme.order},)")
    plain = state[np.argsort(scheme.permutation)]
    register = ShiftRegister(scheme=scheme)
    return FreeFlight(start=RegisterState(register=register, waves=plain[:-1], gap=float(plain[-1]) * scheme.rate))
