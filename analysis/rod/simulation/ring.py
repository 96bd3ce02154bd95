"""The upwind scheme as a shift register: two waves on N cells each, the contact coordinate, what enters them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from lure.rod.upwind import UpwindScheme

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, slots=True)
class Ring:
    r"""The scheme in units of its own time ``1/s``: ``tau = s t``, contact coordinate ``s z`` [m/s].

    In these units ``y' = (S - 1) y + inputs``, and ``S`` shifts each wave by one cell.  The contact stress enters as
    ``q = d p`` [m/s].

    Attributes
    ----------
    cells : int
        ``N``.
    rate : float
        ``s`` [1/s].
    echo : float
        ``-a``: what comes back from the dashpot.
    opening : float
        ``1 + a = 2k/(k+Z)``, without cancellation.
    force_gain : float
        Wave sent out by a unit force, ``2 b`` (corrected form) or ``2 b/s`` (as printed) [m/(N s)].
    body_gain : float
        Wave added in each cell per unit of time and body force, ``1/(rho A s)`` [m^2/(N s)].
    mobility : float
        ``d`` [m/(Pa s)].
    stiffness, exponent : float
        ``c_n`` [Pa/m^m] and ``m`` of the contact law.
    """

    cells: int
    rate: float
    echo: float
    opening: float
    force_gain: float
    body_gain: float
    mobility: float
    stiffness: float
    exponent: float

    @property
    def kappa(self) -> float:
        """``d c_n / s``: rate of the contact spring against one cell of rod, in units of ``s`` (linear law)."""
        return self.mobility * self.stiffness / self.rate

    @property
    def growth(self) -> float:
        """Largest growth of a wave per shift, ``max(1, |a|^{1/2N})``."""
        return float(max(1.0, abs(self.echo) ** (0.5 / self.cells)))

    def push(self, gap: Array) -> Array:
        """``q = d p(z)`` at the scaled coordinate, extended as an odd function; only its half ``z > 0`` is accepted."""
        z = gap / self.rate
        return np.asarray(self.mobility * self.stiffness * np.sign(z) * np.abs(z) ** self.exponent)

    def push_slope(self, gap: Array) -> Array:
        """``dq/d(s z)``; infinite at zero for ``m < 1``."""
        with np.errstate(divide="ignore"):
            steepness = self.exponent * np.abs(gap / self.rate) ** (self.exponent - 1.0)
        return np.asarray(self.mobility * self.stiffness / self.rate * steepness)

    def penetration(self, push: Array) -> Array:
        """The scaled coordinate at which the stress is ``push``; inverse of :meth:`push`."""
        root = (np.abs(push) / (self.mobility * self.stiffness)) ** (1.0 / self.exponent)
        return np.asarray(self.rate * np.sign(push) * root)


def ring_of(scheme: UpwindScheme) -> Ring:
    """The shift register of a scheme."""
    rod, s = scheme.rod, scheme.rate
    return Ring(
        cells=scheme.cells,
        rate=s,
        echo=-rod.reflection,
        opening=2.0 * rod.damping * rod.input_gain,
        force_gain=float(scheme.b2.max()) / s,
        body_gain=1.0 / (rod.density * rod.area * s),
        mobility=rod.mobility,
        stiffness=rod.law.stiffness,
        exponent=rod.law.exponent,
    )


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Inputs:
    """What enters at each shift.

    Attributes
    ----------
    kappa : float
        Stiffness of a linear law in contact, else 0.
    inflow : ndarray or None
        (columns, k) what the force adds to the first cell.
    push : ndarray or None
        (columns, k) a prescribed contact stress ``q``, besides ``kappa`` times the coordinate.
    """

    kappa: float = 0.0
    inflow: Array | None = None
    push: Array | None = None


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Streams:
    """Powers of the shift applied to a state: what left each wave at each shift, and the contact coordinate.

    Attributes
    ----------
    forward, backward : ndarray
        (N + columns - 1, ...) values in the order in which they leave the last cell of the wave.
    gap : ndarray
        (columns, ...) contact coordinate after ``n`` shifts.
    """

    forward: Array
    backward: Array
    gap: Array


def shifted(ring: Ring, state: Array, columns: int, inputs: Inputs) -> Streams:
    """Shift a state ``columns - 1`` times.

    Parameters
    ----------
    ring : Ring
        The shift register.
    state : ndarray
        (2N+1, k) states, scaled.
    columns : int
        Length of the result.
    inputs : Inputs
        What enters meanwhile.
    """
    N, k, kappa, push = ring.cells, state.shape[1], inputs.kappa, inputs.push
    forward, backward = np.empty((N + columns - 1, k)), np.empty((N + columns - 1, k))
    gap = np.empty((columns, k))
    forward[:N], backward[:N], gap[0] = state[N - 1 :: -1], state[-2 : N - 1 : -1], state[-1]
    for start in range(0, columns - 1, N):  # what leaves during N shifts is known before they begin
        stop = min(start + N, columns - 1)
        leaving = forward[start:stop]
        drive = leaving if push is None else leaving - push[start:stop]
        gap[start + 1 : stop + 1] = _integrated(drive, gap[start], kappa)
        pressed = 2.0 * kappa * gap[start:stop] if push is None else 2.0 * (kappa * gap[start:stop] + push[start:stop])
        backward[N + start : N + stop] = leaving - pressed
        forward[N + start : N + stop] = ring.echo * backward[start:stop]
        if inputs.inflow is not None:
            forward[N + start : N + stop] += inputs.inflow[start:stop]
    return Streams(forward=forward, backward=backward, gap=gap)


def _integrated(drive: Array, initial: Array, kappa: float) -> Array:
    """``z_{n+1} = (1 - kappa) z_n + drive_n``."""
    if kappa == 0.0:
        sums = np.cumsum(drive, axis=0)
        sums += initial
        return sums
    fading, kernel = _fading(kappa, drive.shape[0])
    return np.asarray(kernel @ drive + fading[:, None] * initial)


@lru_cache(maxsize=16)
def _fading(kappa: float, size: int) -> tuple[Array, Array]:
    """Powers 1 .. size of ``1 - kappa``, and the lower triangle of the powers 0 .. size-1."""
    powers = np.concatenate((np.zeros(size - 1), np.cumprod(np.concatenate(([1.0], np.full(size, 1.0 - kappa))))))
    triangle: Array = sliding_window_view(powers[:-1], size)[:, ::-1].astype(float)
    return powers[size:].astype(float), triangle


def histories(ring: Ring, streams: Streams) -> Array:
    """The shifted states (columns, 2N+1) of a single start."""
    N = ring.cells
    states = np.empty((streams.gap.shape[0], 2 * N + 1))
    states[:, :N] = sliding_window_view(streams.forward, N)[:, ::-1]
    states[:, N:-1] = sliding_window_view(streams.backward, N)[:, ::-1]
    states[:, -1] = streams.gap
    return states


def body_history(ring: Ring, body: Array, kappa: float) -> Array:
    """What a body force adds to the shifted states of a ring at rest.

    Parameters
    ----------
    ring : Ring
        The shift register.
    body : ndarray
        (columns, 2N) what it adds to each cell at each shift.
    kappa : float
        Stiffness of a linear law in contact, else 0.

    Returns
    -------
    ndarray
        (columns, 2N+1).
    """
    N, columns = ring.cells, body.shape[0]
    states = np.zeros((columns, 2 * N + 1))
    for n in range(columns - 1):
        here, after = states[n], states[n + 1]
        after[1:-1] = here[:-2]
        after[0] = ring.echo * here[-2]
        after[N] -= 2.0 * kappa * here[-1]
        after[-1] = (1.0 - kappa) * here[-1] + here[N - 1]
        after[:-1] += body[n]
    return states
