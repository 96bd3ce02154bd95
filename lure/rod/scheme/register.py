"""The upwind scheme as a shift register: two waves on N cells each, the contact coordinate, what enters and leaves."""

from __future__ import annotations

import math
from functools import cached_property, lru_cache

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import ArrayLike, NDArray

from lure.arrays import Reals as Array
from lure.record import described, quantity
from lure.rod.discretisation import UpwindScheme
from lure.rod.transfer import RodPlant

_BLOCK = 64


@described(frozen=True, kw_only=True, eq=False)
class ShiftRegister:
    """The scheme in units of its own time ``1/s``: ``tau = s t``, contact coordinate ``s z`` [m/s].

    In these units ``y' = (S - 1) y + inputs``, and ``S`` shifts each wave by one cell and closes the ring with the echo
    ``f = -a``.  The contact stress enters as ``q = d p`` [m/s].
    """

    scheme: UpwindScheme = quantity(
        "The scheme; its own ordering does not matter here, states are in the ordering (39)"
    )

    @property
    def cells(self) -> int:
        """``N``."""
        return self.scheme.cells

    @cached_property
    def rate(self) -> float:
        """``s`` [1/s]."""
        return self.scheme.rate

    @property
    def echo(self) -> float:
        """``f = -a``: what comes back from the dashpot."""
        return -self.scheme.rod.reflection

    @cached_property
    def log_echo(self) -> float:
        """``ln|f|``, accurate near ``|f| = 1``; ``-inf`` for ``k = Z``."""
        return RodPlant(self.scheme.rod).log_reflection

    @property
    def opening(self) -> float:
        """``1 - f = 2k/(k + Z)``, without cancellation."""
        return 2.0 * self.scheme.rod.damping * self.scheme.rod.input_gain

    @property
    def growth(self) -> float:
        """Largest growth of a wave per shift, ``max(1, |a|^{1/2N})``."""
        return float(max(1.0, abs(self.echo) ** (0.5 / self.cells)))

    @cached_property
    def force_gain(self) -> float:
        """Wave sent out by a unit force, ``2 b`` (corrected form) or ``2 b/s`` (as printed) [m/(N s)]."""
        return self.scheme.force_gain

    @cached_property
    def body_gain(self) -> float:
        """Wave added in each cell per unit of time and body force, ``1/(rho A s)`` [m^2/(N s)]."""
        return 1.0 / (self.scheme.rod.density * self.scheme.rod.area * self.rate)

    @property
    def exponent(self) -> float:
        """``m`` of the contact law."""
        return self.scheme.rod.exponent

    @cached_property
    def spring(self) -> float:
        """``d c_n``: the stress ``q`` at ``z = 1 m`` [m/s]."""
        return self.scheme.rod.mobility * self.scheme.rod.nonlinearity.stiffness

    @property
    def kappa(self) -> float:
        """``d c_n / s``: rate of the contact spring against one cell of rod, in units of ``s`` (linear contact law)."""
        return self.spring / self.rate

    def push(self, gap: Array) -> Array:
        """``q = d p(z)`` at the scaled coordinate, extended as an odd function; only its half ``z > 0`` is accepted."""
        z = gap / self.rate
        return np.asarray(self.spring * np.sign(z) * np.abs(z) ** self.exponent)

    def push_slope(self, gap: Array) -> Array:
        """``dq/d(s z)``; infinite at zero for ``m < 1``."""
        with np.errstate(divide="ignore"):
            steepness = self.exponent * np.abs(gap / self.rate) ** (self.exponent - 1.0)
        return np.asarray(self.kappa * steepness)

    def penetration(self, push: Array) -> Array:
        """The scaled coordinate at which the stress is ``push``; inverse of :meth:`push`."""
        return np.asarray(self.rate * np.sign(push) * (np.abs(push) / self.spring) ** (1.0 / self.exponent))

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


@described(frozen=True, kw_only=True, eq=False)
class RegisterState:
    """What the register holds: waves ``y`` and the scaled coordinate ``s z``.

    Read backwards, ``Y_{i - 2N} = f Y_i`` continues the waves for ever, and without inputs ``S^n`` only moves the place
    at which that stream is read.
    """

    register: ShiftRegister = quantity("The register")
    waves: Array = quantity("(2N,) in the ordering (39) [m/s]")
    gap: float = quantity("``s z`` [m/s]")

    @property
    def state(self) -> Array:
        """(2N+1,) the state of the scheme, in its ordering."""
        state = np.append(self.waves, self.gap / self.register.rate)
        return np.asarray(state[self.register.scheme.permutation])

    @cached_property
    def stream(self) -> Array:
        """(2N,) what leaves the forward wave at the shifts ``0 .. 2N-1``; later ``f`` times what left 2N before."""
        N = self.register.cells
        return np.concatenate((self.waves[N - 1 :: -1], self.register.echo * self.waves[: N - 1 : -1]))

    @cached_property
    def sums(self) -> Array:
        """(2N+1,) ``R_r``, the first ``r`` terms of the stream added up."""
        return np.concatenate(([0.0], np.cumsum(self.stream)))

    def gaps(self, n: NDArray[np.int64]) -> Array:
        """``s z`` after ``n`` shifts: the start and the first ``n`` terms of the stream."""
        trips, left = np.divmod(n, self.waves.size)
        register = self.register
        return np.asarray(self.gap + register.series(trips) * self.sums[-1] + register.power(trips) * self.sums[left])

    def leaving(self, n: NDArray[np.int64]) -> Array:
        """``Y_{N-n}``: what the last cell of the forward wave holds after ``n`` shifts."""
        trips, left = np.divmod(n, self.waves.size)
        return np.asarray(self.register.power(trips) * self.stream[left])

    def largest_gap(self, trips: float = math.inf) -> float:
        """Bound of ``s z`` over the next ``trips`` round trips: the largest value after any number of shifts.

        ``s z`` is an average of these values with positive weights.  For ``|f| <= 1`` they are ``C + f^m (R_r - C)``
        with ``C = R_2N/(1 - f)``: extreme at ``m`` = 0, 1 or infinity; for ``f = 1`` they are ``m R_2N + R_r``.  For
        ``|f| > 1`` the bound is ``inf``.  Below zero it means that no contact can follow.
        """
        register = self.register
        if register.log_echo > 0.0:
            return math.inf
        trip, highest, lowest = float(self.sums[-1]), float(self.sums.max()), float(self.sums.min())
        if register.opening == 0.0:
            return self.gap + highest + (trip * trips if trip > 0.0 else 0.0)
        limit = trip / register.opening
        once = limit + register.echo * ((highest if register.echo > 0.0 else lowest) - limit)
        return self.gap + max(highest, limit, once)


@described(frozen=True, kw_only=True, slots=True, eq=False)
class Inputs:
    """What enters at each shift."""

    kappa: float = quantity("Stiffness of a linear contact law in contact, else 0", default=0.0)
    inflow: Array | None = quantity("(columns, k) what the force adds to the first cell", default=None)
    push: Array | None = quantity(
        "(columns, k) a prescribed contact stress ``q``, besides ``kappa`` times the coordinate", default=None
    )


@described(frozen=True, kw_only=True, slots=True, eq=False)
class Streams:
    """Powers of the shift applied to a state: what left each wave at each shift, and the contact coordinate."""

    forward: Array = quantity(
        "(N + columns - 1, ...) values of the forward wave in the order in which they leave its last cell"
    )
    backward: Array = quantity("(N + columns - 1, ...) of the backward wave")
    gap: Array = quantity("(columns, ...) contact coordinate after ``n`` shifts")

    @property
    def single(self) -> Streams:
        """Those of the first of several starts, one-dimensional."""
        return Streams(forward=self.forward[:, 0], backward=self.backward[:, 0], gap=self.gap[:, 0])

    @property
    def histories(self) -> Array:
        """The shifted states (columns, 2N+1) of a single start."""
        columns = self.gap.shape[0]
        N = self.forward.shape[0] - columns + 1
        waves = [sliding_window_view(stream, N)[:, ::-1] for stream in (self.forward, self.backward)]
        return np.concatenate((*waves, self.gap[:, None]), axis=1)


def shifted(register: ShiftRegister, state: Array, columns: int, inputs: Inputs) -> Streams:
    r"""Shift states ``columns - 1`` times.

    In contact a linear contact law adds ``-kappa z`` to ``z'`` and ``-2 kappa z`` to the first backward cell, and a
    force ``2 b g`` to the first forward cell: one step of the register becomes

    .. math:: z_{n+1} = (1 - \kappa) z_n + F_n, \qquad \text{entering the backward wave: } F_n - 2 \kappa z_n, \qquad
        \text{entering the forward wave: } f B_n + 2 b g_n,

    where what leaves the waves, ``F_n`` and ``B_n``, is known ``N`` steps ahead.

    ``state``: (2N+1, k) states, scaled; ``columns``: length of the result; ``inputs``: what enters meanwhile.
    """
    N, k, kappa, push = register.cells, state.shape[1], inputs.kappa, inputs.push
    forward, backward = np.empty((N + columns - 1, k)), np.empty((N + columns - 1, k))
    gap = np.empty((columns, k))
    forward[:N], backward[:N], gap[0] = state[N - 1 :: -1], state[-2 : N - 1 : -1], state[-1]
    for start in range(0, columns - 1, N):
        stop = min(start + N, columns - 1)
        leaving = forward[start:stop]
        drive = leaving if push is None else leaving - push[start:stop]
        gap[start + 1 : stop + 1] = _integrated(drive, gap[start], 1.0 - kappa)
        pressed = kappa * gap[start:stop] if push is None else kappa * gap[start:stop] + push[start:stop]
        backward[N + start : N + stop] = leaving - 2.0 * pressed
        forward[N + start : N + stop] = register.echo * backward[start:stop]
        if inputs.inflow is not None:
            forward[N + start : N + stop] += inputs.inflow[start:stop]
    return Streams(forward=forward, backward=backward, gap=gap)


def _integrated(drive: Array, initial: Array, kept: float) -> Array:
    """``z_{n+1} = kept z_n + drive_n``: in blocks, whose ends obey the same rule."""
    if kept == 1.0:
        sums = np.cumsum(drive, axis=0)
        sums += initial
        return sums
    whole, k = drive.shape[0] // _BLOCK, drive.shape[1]
    found = np.empty_like(drive)
    if whole:
        fading, kernel = _fading(kept, _BLOCK)
        inside = kernel @ drive[: whole * _BLOCK].reshape(whole, _BLOCK, k)
        ends = _integrated(inside[:, -1], initial, float(fading[-1]))
        inside += fading[:, None] * np.concatenate((initial[None], ends[:-1]))[:, None]
        found[: whole * _BLOCK] = inside.reshape(-1, k)
        initial = ends[-1]
    if drive.shape[0] > whole * _BLOCK:
        fading, kernel = _fading(kept, drive.shape[0] - whole * _BLOCK)
        found[whole * _BLOCK :] = kernel @ drive[whole * _BLOCK :] + fading[:, None] * initial
    return found


@lru_cache(maxsize=128)
def _fading(kept: float, size: int) -> tuple[Array, Array]:
    """Powers 1 .. size of ``kept``, and the lower triangle of the powers 0 .. size-1."""
    powers = np.concatenate((np.zeros(size - 1), np.cumprod(np.concatenate(([1.0], np.full(size, kept))))))
    triangle: Array = sliding_window_view(powers[:-1], size)[:, ::-1].astype(float)
    return powers[size:].astype(float), triangle


def body_history(register: ShiftRegister, body: Array, kappa: float) -> Array:
    """What a body force adds to the shifted states of a register that holds nothing.

    ``body``: (columns, 2N) what it adds to each cell at each shift; ``kappa``: stiffness of a linear contact law in
    contact, else 0.

    Returns
    -------
    ndarray
        (columns, 2N+1).
    """
    N, columns = register.cells, body.shape[0]
    states = np.zeros((columns, 2 * N + 1))
    for n in range(columns - 1):
        here, after = states[n], states[n + 1]
        after[1:-1] = here[:-2]
        after[0] = register.echo * here[-2]
        after[N] -= 2.0 * kappa * here[-1]
        after[-1] = (1.0 - kappa) * here[-1] + here[N - 1]
        after[:-1] += body[n]
    return states
