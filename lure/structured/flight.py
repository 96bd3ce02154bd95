"""Free flight of the upwind scheme in one jump of any length, for very many cells."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.errors import InputError
from lure.scenario import Scenario, initial_state
from lure.structured.modes import Modes
from lure.structured.poisson import Mean, mean_of, poisson_weights
from lure.structured.ring import Ring
from lure.upwind import UpwindScheme

Array: TypeAlias = NDArray[np.float64]
Way = Literal["auto", "modes", "poisson"]

_FAINT, _LOUD = math.log(0.1), math.log(10.0)
_DEAD = 2000


@dataclass(frozen=True, kw_only=True, eq=False)
class FreeFlight:
    r"""The scheme without contact and without loads, ``y' = A y``: any time in one step.

    Its ring of ``2N`` waves is f-circulant, ``f = -a``.  Two ways to ``exp(t A)``:

    - *modes*: a scaled FFT diagonalises it (:mod:`lure.structured.modes`), cost ``O(N log N)`` for any time; for
      ``0.1 <= |a| <= 10``, since scaling costs a factor ``max(|a|, 1/|a|)`` in accuracy;
    - *Poisson*: ``exp(t A) = sum_n w_n S^n`` with Poisson weights of mean ``s t``, folded onto the ring and convolved;
      for every ``a``, also ``a = 0`` (``k = Z``) where the ring is one Jordan block and has no eigenvectors to speak
      of, and ``s t <= 1e13``.

    Make one with :func:`free_flight`.  Contact is not modelled: what is returned after the end has touched the obstacle
    is the motion of a rod without one; see :func:`lure.structured.first_contact`.

    Attributes
    ----------
    ring : Ring
        The scheme and its state at the start.

    Notes
    -----
    It is a motion of the scheme, whose waves lose more energy than the rod's.  The mean ``s t`` is taken without
    rounding, so that times are as exact as the double ``s = c N/L``.
    """

    ring: Ring

    @cached_property
    def modes(self) -> Modes | None:
        """The scaled FFT of the start; None where it would lose digits."""
        return Modes(ring=self.ring) if _FAINT <= self.ring.log_echo <= _LOUD else None

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
        return self.jumped(mean_of(self.ring.scheme.rate, t), way=way)

    def jumped(self, mean: Mean, *, way: Way = "auto") -> Array:
        """:meth:`state` at the time ``mean`` in units of ``1/s``."""
        scheme = self.ring.scheme
        with np.errstate(over="ignore", invalid="ignore"):
            waves, gap = self._by_modes(mean) if self._uses_modes(way) else self._by_poisson(mean)
        state = np.append(waves, gap / scheme.rate)
        if not np.isfinite(state).all():
            raise InputError("the motion has grown beyond the range of doubles (damping < 0); give an earlier time")
        return np.asarray(state[scheme.permutation])

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
        pairs = np.array([self.end_at(mean_of(self.ring.scheme.rate, float(time))) for time in times.ravel()])
        pairs = pairs.reshape(*times.shape, 2)
        if not np.isfinite(pairs).all():
            raise InputError("the motion has grown beyond the range of doubles (damping < 0); give earlier times")
        return pairs[..., 0] / self.ring.scheme.rate, pairs[..., 1]

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
        largest = float(np.abs(self.ring.waves).max())
        one, two = self.state(t, way="modes"), self.state(t, way="poisson")
        keep = self.ring.scheme.permutation < 2 * self.ring.scheme.cells
        return float(np.abs(one - two)[keep].max()) / (largest or 1.0)

    def _uses_modes(self, way: Way) -> bool:
        if way not in ("auto", "modes", "poisson"):
            raise InputError(f"way is {way!r}; give auto, modes or poisson")
        if way == "modes" and self.modes is None:
            raise InputError(
                f"the scaled FFT loses too many digits for a = {-self.ring.echo:.6g}, outside 0.1 <= |a| <= 10; "
                'give way="poisson"'
            )
        return way != "poisson" and self.modes is not None

    def _by_modes(self, mean: Mean) -> tuple[Array, float]:
        assert self.modes is not None
        return self.modes.waves(mean), self.modes.end(mean)[0]

    def _by_poisson(self, mean: Mean) -> tuple[Array, float]:
        ring, size = self.ring, 2 * self.ring.scheme.cells
        n, weights = self._terms(mean)
        trips = n // size
        kernel = np.bincount(n - trips * size, weights=weights * ring.power(trips), minlength=size)
        product = np.fft.rfft(kernel, 2 * size) * np.fft.rfft(ring.waves, 2 * size)
        convolved = np.fft.irfft(product, 2 * size)
        return convolved[:size] + ring.echo * convolved[size:], float(weights @ ring.gaps(n))

    def end_at(self, mean: Mean) -> tuple[float, float]:
        """``s z`` and ``y_N`` [m/s] at the time ``mean`` in units of ``1/s``."""
        few = 18.0 * math.sqrt(mean.value) + 40.0 < 2 * self.ring.scheme.cells
        if self.modes is not None and not (few and 18.0 * math.sqrt(mean.value) < self.modes.active(mean.value)):
            return self.modes.end(mean)
        n, weights = self._terms(mean)
        return float(weights @ self.ring.gaps(n)), float(weights @ self.ring.leaving(n))

    def _terms(self, mean: Mean) -> tuple[NDArray[np.int64], Array]:
        """Indices and weights of the window, which echoes that grow must not carry away by a standard deviation."""
        ring = self.ring
        if ring.log_echo > 0.0 and mean.value * ring.log_echo**2 > 2.0 * ring.scheme.cells**2:
            raise InputError(f"a = {-ring.echo:.6g} amplifies the tail of the Poisson weights; give an earlier time")
        if ring.log_echo < _FAINT:  # a wave has sunk below the range of doubles after so many echoes
            mean = Mean(whole=min(mean.whole, _DEAD * ring.scheme.cells), rest=mean.rest)
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
    >>> from lure import builtin_system, upwind
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
    return FreeFlight(ring=Ring(scheme=scheme, waves=plain[:-1], gap=float(plain[-1]) * scheme.rate))


def later(flight: FreeFlight, shifts: int) -> FreeFlight:
    """The flight seen from ``shifts`` cell crossings later.

    Parameters
    ----------
    flight : FreeFlight
        The flight.
    shifts : int
        Whole number of units of ``1/s``.
    """
    state = flight.jumped(Mean(whole=shifts, rest=0.0))
    return free_flight(flight.ring.scheme, state)
