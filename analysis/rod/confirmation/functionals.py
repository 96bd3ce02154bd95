"""What the rod itself conserves and loses: its energy, its deflated coordinate, its Popov-Lyapunov functional."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.errors import AssumptionError, Reason
from lure.rod.motion import Window
from lure.rod.motion.pieces import Array, basis, distinct, fitted, values
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

# The end ``x = L`` of the rod along whole round trips, and what the waves in the rod hold at any instant.


@dataclass(frozen=True, kw_only=True, eq=False)
class Track:
    r"""Consecutive round trips of a rod, from the start on.

    Without loads, and with ``W = r1(t, L)`` and ``V = r2(t, L)``, what runs in the rod at ``t = 2T n + T tau`` is known
    from the window ``n`` and the one before: the forward wave is what arrives in the next ``T``, ``W`` up to the end of
    the window and ``-a V`` of it after that; the backward wave is the ``V`` of the last ``T``.

    Attributes
    ----------
    rod : Rod
        The rod.
    scenario : Scenario
        Its initial data and loads.
    windows : tuple of Window
        From number 0 on; under load the last may be cut off.
    """

    rod: Rod
    scenario: Scenario
    windows: tuple[Window, ...]

    @property
    def reached(self) -> float:
        """End of the last round trip [s]."""
        last = self.windows[-1]
        return self.rod.travel_time * (2.0 * last.number + float(last.edges[-1]))

    @cached_property
    def pieces(self) -> Places:
        """All pieces; the row before the first window holds what the backward wave was before the start."""
        degree = self.windows[0].wave.shape[1] - 1
        L = self.rod.length

        def backward(s: Array) -> tuple[Array, Array]:
            """``r2`` at ``x = L s`` at the start, which would have left ``x = L`` a time ``1 - s`` before."""
            return self.scenario.waves(self.rod, L * s)[1], np.zeros(len(s))

        edges: list[float] = []
        for data in (self.scenario.displacement, self.scenario.velocity):
            edges += [float(place) / L for place in data.breakpoints("x", 0.0, L) or ()]
        start, _ = fitted(backward, distinct(edges, 0.0, 1.0), degree, 0.0)
        still = np.zeros((1, degree + 1))
        tables = [(np.append(0.0, 1.0 + start.edges), np.zeros((len(start.series) + 1, degree + 1)))]
        tables += [(window.edges, window.wave) for window in self.windows]
        returned = [still, start.series, *(window.returned for window in self.windows)]
        z = [still, np.zeros_like(start.series), *(window.z for window in self.windows)]
        return Places(
            number=np.repeat(np.arange(-1, len(self.windows)), [len(series) for _, series in tables]),
            low=np.concatenate([edges[:-1] for edges, _ in tables]),
            high=np.concatenate([edges[1:] for edges, _ in tables]),
            wave=np.concatenate([series for _, series in tables]),
            returned=np.concatenate(returned),
            z=np.concatenate(z),
        )

    def place(self, t: ArrayLike) -> tuple[NDArray[np.int64], Array]:
        """Round trip and place in it [transits] of instants [s] from 0 to :attr:`reached`."""
        transits = np.asarray(t, dtype=float) / self.rod.travel_time
        number = np.clip(np.floor(0.5 * transits).astype(np.int64), 0, len(self.windows) - 1)
        return number, np.clip(transits - 2.0 * number, 0.0, 2.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Places:
    """Pieces of all windows in one table, with the integrals along each window.

    Attributes
    ----------
    number : ndarray
        (P,) window of each piece, -1 for the time before the start.
    low, high : ndarray
        (P,) ends in the window [transits].
    wave, returned, z : ndarray
        (P, N+1) Chebyshev series of ``W``, ``V`` [m/s] and ``z`` [m].
    """

    number: NDArray[np.int64]
    low: Array
    high: Array
    wave: Array
    returned: Array
    z: Array

    def at(self, series: Array, number: NDArray[np.int64], tau: Array) -> Array:
        """Values of a table of series at places (n,)."""
        i = self._found(number, tau)
        low, high = self.low[i], self.high[i]
        x = np.clip(((tau - low) - (high - tau)) / (high - low), -1.0, 1.0)
        return values(series[i], x[:, None])[:, 0]

    @cached_property
    def travel(self) -> tuple[Array, Array]:
        """Series of ``int W`` and ``int V`` from the start of the window [m/s transits]."""
        return self._integral(self.wave), self._integral(self.returned)

    @cached_property
    def squares(self) -> tuple[Array, Array, Array, Array]:
        """Series of the integrals of ``W^2``, ``V^2``, ``tau W^2`` and ``tau V^2`` from the start of the window."""
        degree = 2 * (self.wave.shape[1] - 1) + 1
        space = basis(degree)
        x = np.broadcast_to(space.inner, (len(self.low), degree + 1))
        tau = self.low[:, None] + 0.5 * (self.high - self.low)[:, None] * (x + 1.0)
        wave, returned = values(self.wave, x) ** 2, values(self.returned, x) ** 2
        found = (self._integral(table @ space.from_inner.T) for table in (wave, returned, tau * wave, tau * returned))
        one, two, three, four = found
        return one, two, three, four

    @cached_property
    def _first(self) -> NDArray[np.int64]:
        """First piece of each window, of that before the start first."""
        return np.searchsorted(self.number, np.arange(-1, int(self.number[-1]) + 2))

    def _found(self, number: NDArray[np.int64], tau: Array) -> NDArray[np.int64]:
        """Piece at each place: found in one list, then put right where rounding misplaced it."""
        first, last = self._first[number + 1], self._first[number + 2] - 1
        i = np.searchsorted(4.0 * self.number + self.low, 4.0 * number + tau, side="right") - 1
        i = np.clip(i, first, last)
        i = np.where((tau < self.low[i]) & (i > first), i - 1, i)
        return np.where((tau >= self.high[i]) & (i < last), i + 1, i)

    def _integral(self, series: Array) -> Array:
        """Series of the integral from the start of the window; one degree more."""
        grown = np.concatenate((series, np.zeros((len(series), 1))), axis=1)
        half = 0.5 * (self.high - self.low)
        primitive = half[:, None] * (grown @ basis(grown.shape[1] - 1).integral.T)
        gained = primitive.sum(axis=1)
        for first, stop in zip(self._first[:-1], self._first[1:], strict=True):
            primitive[first + 1 : stop, 0] += np.cumsum(gained[first : stop - 1])
        return np.asarray(primitive)


# What the rod itself conserves and loses: its energy, its deflated coordinate, its Popov-Lyapunov functional.


@dataclass(frozen=True, kw_only=True, slots=True)
class Weights:
    """Weights on the squares of the waves, linear in the time since they left ``x = L``.

    Attributes
    ----------
    leaving : float
        On the backward wave where it leaves ``x = L``.
    leaving_slope : float
        What that loses in one transit.
    arriving : float
        On the forward wave where it arrives at ``x = L``.
    arriving_slope : float
        What that lost in one transit.
    """

    leaving: float
    leaving_slope: float
    arriving: float
    arriving_slope: float


def rod_energy(track: Track, t: ArrayLike) -> Array:
    r"""Energy of the rod, waves and contact.

    .. math:: E(t) &= \tfrac12 A \int_0^L (\rho v^2 + E w^2)\,dx + A P(z) \\
        &= \tfrac{Z}{4c} \int_0^L (r_1^2 + r_2^2)\,dx + A P(z), \qquad E' = -k\,v(t, 0)^2

    without loads: it never increases for ``k >= 0``, whatever the nonlinearity, and never decreases for ``k <= 0``.

    Parameters
    ----------
    track : Track
        The motion, without loads.
    t : array_like
        Instants from 0 to the end of the track [s].

    Returns
    -------
    ndarray
        (n,) [J].
    """
    rod = track.rod
    share = 0.25 * rod.impedance
    waves = _weighted(track, t, Weights(leaving=share, leaving_slope=0.0, arriving=share, arriving_slope=0.0))
    return np.asarray(waves + rod.area * rod.nonlinearity.primitive(track_z(track, t)))


def track_z(track: Track, t: ArrayLike) -> Array:
    """Contact coordinate [m] at the instants.

    Parameters
    ----------
    track : Track
        The motion.
    t : array_like
        (n,) instants from 0 to the end of the track [s].
    """
    return track.pieces.at(track.pieces.z, *track.place(t))


def rod_zeta(track: Track, t: ArrayLike) -> Array:
    r"""Deflated coordinate of the rod: where the end goes if it never touches again.

    In free flight the waves bring to ``x = L``, in the round trip that follows ``t``, the travel ``S``: the forward
    wave arrives first, then the backward one, ``-a`` times itself.  Each later round trip brings ``-a`` times as much
    as the one before, so that ``z`` tends to ``z + S/(1 + a)``:

    .. math::

        \zeta = z + \frac{1}{c (1 + a)} \int_0^L (r_1 - a\,r_2)\,dx
              = u(t, 0) - \mathrm{gap} + \frac{\rho A}{k} \int_0^L v\,dx .

    (``r1 - a r2 = (1 - a) v - c (1 + a) u_x``, ``(1 - a)/(1 + a) = Z/k``, ``Z = rho A c``.)  The second form says what
    it is: position of the dashpot plus momentum over ``k``.  By the transport equations and ``r1(t,0) = -a r2(t,0) +
    2 b g``, ``r2(t,L) = r1(t,L) - 2 d p``, ``z' = r1(t,L) - d p``,

    .. math:: \zeta' = -\frac{A}{k}\,p(z) + \frac{g}{k} + \frac1k \int_0^L f\,dx .

    So without loads it is constant in free flight, falls by the impulse over ``k`` in a contact, and for ``k > 0`` and
    ``p >= 0`` never increases.  It is the limit for ``N -> inf`` of
    :func:`lure.analysis.rod.energy.deflated_coordinate`, whose
    sums over cells of length ``L/N`` are Riemann sums of the integral above.

    Parameters
    ----------
    track : Track
        The motion, without loads.
    t : array_like
        (n,) instants from 0 to the end of the track [s].

    Returns
    -------
    ndarray
        (n,) [m].

    Raises
    ------
    AssumptionError
        ``k = 0``: free flight has no resting place.
    """
    rod, pieces = track.rod, track.pieces
    if rod.damping == 0:
        raise AssumptionError(
            "the deflated coordinate needs k != 0; the damping is 0 N s/m, free flight does not end",
            code=Reason.UNDAMPED,
        )
    number, tau = track.place(t)
    arriving, leaving = pieces.travel
    end = np.full(tau.shape, 2.0)
    ahead = pieces.at(arriving, number, end) - pieces.at(arriving, number, tau)
    behind = pieces.at(leaving, number, tau)
    return np.asarray(track_z(track, t) + zeta_gain(rod) * (ahead - rod.reflection * behind))


def zeta_gain(rod: Rod) -> float:
    """``T/(1 + a)`` [s], with ``1 + a = 2 k b`` free of cancellation.

    Parameters
    ----------
    rod : Rod
        The rod, ``k != 0``.
    """
    return rod.travel_time / (2.0 * rod.damping * rod.input_gain)


def lyapunov_theta(rod: Rod) -> float:
    """Multiplier of :func:`rod_lyapunov`: ``T (Z/k)^2`` for ``k <= Z`` and ``T k/Z`` for ``k >= Z`` [s].

    Parameters
    ----------
    rod : Rod
        The rod, ``k > 0``.

    Raises
    ------
    AssumptionError
        ``k <= 0``.
    """
    _need_damping(rod)
    ratio = rod.damping / rod.impedance
    return rod.travel_time * (ratio if ratio >= 1.0 else 1.0 / ratio**2)


def rod_lyapunov(track: Track, t: ArrayLike) -> Array:
    r"""Popov-Lyapunov functional of the rod without loads.

    .. math:: V = \int_0^{2T} Q(s)\,y(s)^2\,ds + 2 \theta P(z) + \zeta^2/\rho_0, \qquad \rho_0 = A/k,

    where ``y(s)`` is the wave that left ``x = L`` the time ``s`` ago: ``r2`` at ``x = L - c s`` for ``s < T``, ``r1``
    at ``x = c (s - T)`` after that.  With ``eta = T (1 + |a|)/(d (1 + a))``

    .. math::

        Q(T^+) &= \frac{2\eta}{1 - a^2}, & \qquad Q(T^-) &= a^2 Q(T^+), \\
        Q' &= -\frac{|a|\,\eta}{(1 + |a|)\,T} \;(s < T), & \qquad Q' &= -\frac{\eta}{(1 + |a|)\,T} \;(s > T), \\
        \theta &= d\,\eta + 2 d\,Q(0),

    the derivative along every motion is, completing squares,

    .. math:: V' = -2 z\,p(z) - \eta\,z'^2 - \int_0^{2T} |Q'| \Big(y + \frac{\beta\,p}{(1 + a)\,|Q'|}\Big)^2 ds
        \le -2 z\,p(z),

    ``beta = -a`` for ``s < T`` and 1 after that.  (The terms at the ends of the loop are ``-(Q(2T) - Q(0)) W^2 +
    2 d eta p W - 2 d^2 eta p^2`` with ``Q(2T) - Q(0) = eta``; the squares under the integral cost ``d^2 eta p^2``;
    together ``-eta (W - d p)^2``.)  So it falls for *every* nonlinearity with ``z p(z) >= 0``, as that of the scheme
    does, but with a multiplier that no number of cells enters.

    Parameters
    ----------
    track : Track
        The motion, without loads.
    t : array_like
        (n,) instants from 0 to the end of the track [s].

    Returns
    -------
    ndarray
        (n,) [Pa s m].

    Raises
    ------
    AssumptionError
        ``k <= 0``.
    """
    rod = track.rod
    waves = _weighted(track, t, lyapunov_weights(rod))
    stored = 2.0 * lyapunov_theta(rod) * rod.nonlinearity.primitive(track_z(track, t))
    return np.asarray(waves + stored + rod_zeta(track, t) ** 2 / rod.residue_at_zero)


def lyapunov_weights(rod: Rod) -> Weights:
    """``Q`` of :func:`rod_lyapunov` [Pa s^2/m].

    Parameters
    ----------
    rod : Rod
        The rod, ``k > 0``.

    Raises
    ------
    AssumptionError
        ``k <= 0``.
    """
    _need_damping(rod)
    size = abs(rod.reflection)
    eta = zeta_gain(rod) * (1.0 + size) / rod.mobility
    # 1 - a^2 = 4 k Z b^2, without cancellation
    top = 2.0 * eta / (4.0 * (rod.damping * rod.input_gain) * (rod.impedance * rod.input_gain))
    slope = eta / (1.0 + size)
    return Weights(
        leaving=size**2 * top + size * slope, leaving_slope=size * slope, arriving=top - slope, arriving_slope=slope
    )


def _weighted(track: Track, t: ArrayLike, weights: Weights) -> Array:
    """``int_0^{2T} Q y^2 ds`` at the instants."""
    rod, pieces = track.rod, track.pieces
    number, tau = track.place(t)
    wave, returned, wave_moment, returned_moment = pieces.squares
    zero, two = np.zeros(tau.shape), np.full(tau.shape, 2.0)
    middle, late = np.minimum(tau + 1.0, 2.0), np.maximum(tau - 1.0, 0.0)

    def part(
        tables: tuple[Array, Array], window: NDArray[np.int64], span: tuple[Array, Array], line: tuple[Array, float]
    ) -> Array:
        """``int (constant + slope tau) f^2`` over the span."""
        plain, moment = (pieces.at(table, window, span[1]) - pieces.at(table, window, span[0]) for table in tables)
        return line[0] * plain + line[1] * moment

    ahead, behind = (wave, wave_moment), (returned, returned_moment)
    Q0, s0, Q2, s2 = weights.leaving, weights.leaving_slope, weights.arriving, weights.arriving_slope
    total = part(ahead, number, (tau, middle), (Q2 - s2 * tau, s2))
    total += rod.reflection**2 * part(behind, number, (zero, late), (Q2 + s2 * (2.0 - tau), s2))
    total += part(behind, number, (late, tau), (Q0 - s0 * tau, s0))
    total += part(behind, number - 1, (middle, two), (Q0 - s0 * (tau + 2.0), s0))
    return np.asarray(rod.travel_time * total)


def _need_damping(rod: Rod) -> None:
    if rod.damping <= 0:
        raise AssumptionError(
            f"the Popov-Lyapunov functional needs k > 0; the damping is {rod.damping:g} N s/m", code=Reason.UNDAMPED
        )
