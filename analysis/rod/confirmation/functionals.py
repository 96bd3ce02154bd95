"""What the rod itself conserves and loses: its energy, its deflated coordinate, its Popov-Lyapunov functional."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from lure.errors import AssumptionError, Reason
from lure.record import described, quantity
from lure.rod.motion import Boundary, Window
from lure.rod.motion.fields import Integrand, over_a_transit, square
from lure.rod.motion.pieces import Array
from lure.rod.motion.record import Record, record_of
from lure.rod.motion.sources import sources
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

# The end ``x = L`` of the rod along whole round trips, and what the waves in the rod hold at any instant.


@described(frozen=True, kw_only=True, eq=False)
class Track:
    """Consecutive round trips of a rod, from the start on.

    Without loads, and with ``W = r1(t, L)`` and ``V = r2(t, L)``, what runs in the rod at ``t`` is known from the ends:
    the forward wave is the ``W`` that arrives in the next ``T``, the backward wave is the ``V`` of the last ``T``.
    """

    rod: Rod = quantity("The rod")
    scenario: Scenario = quantity("Its initial data and loads")
    windows: tuple[Window, ...] = quantity("From number 0 on; under load the last may be cut off")

    @property
    def reached(self) -> float:
        """End of the last round trip [s]."""
        last = self.windows[-1]
        return self.rod.travel_time * (2.0 * last.number + float(last.edges[-1]))

    @cached_property
    def record(self) -> Record:
        """The windows as arrays."""
        return record_of(self.windows, 1.0)

    def over(self, t: ArrayLike, of: Integrand) -> tuple[Array, Array]:
        """``int_0^1 of(V(t - s), t - s) ds`` and ``int_0^1 of(W(t + s), t + s) ds`` at instants [s], in transits."""
        rod, degree = self.rod, self.windows[0].wave.shape[1] - 1
        loads = sources(rod, self.scenario, Boundary(), self.reached, degree)
        return over_a_transit(loads, self.record, np.asarray(t, dtype=float) / rod.travel_time, of)


# What the rod itself conserves and loses: its energy, its deflated coordinate, its Popov-Lyapunov functional.


@described(frozen=True, kw_only=True, slots=True)
class Weights:
    """Weights on the squares of the waves, linear in the time since they left ``x = L``."""

    leaving: float = quantity("On the backward wave where it leaves ``x = L``")
    leaving_slope: float = quantity("What that loses in one transit")
    arriving: float = quantity("On the forward wave where it arrives at ``x = L``")
    arriving_slope: float = quantity("What that lost in one transit")


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
    behind, ahead = track.over(t, square)
    waves = 0.25 * rod.impedance * rod.travel_time * (behind + ahead)
    return np.asarray(waves + rod.area * rod.nonlinearity.primitive(track_z(track, t)))


def track_z(track: Track, t: ArrayLike) -> Array:
    """Contact coordinate [m] at the instants; ``t``: (n,) instants from 0 to the end of the track [s]."""
    return track.record.at(np.asarray(t, dtype=float) / track.rod.travel_time, "z")


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
    rod = track.rod
    if rod.damping == 0:
        raise AssumptionError(
            "the deflated coordinate needs k != 0; the damping is 0 N s/m, free flight does not end",
            code=Reason.UNDAMPED,
        )
    behind, ahead = track.over(t, lambda wave, _at: wave)
    return np.asarray(track_z(track, t) + zeta_gain(rod) * (ahead - rod.reflection * behind))


def zeta_gain(rod: Rod) -> float:
    """``T/(1 + a)`` [s], with ``1 + a = 2 k b`` free of cancellation; ``rod``: the rod, ``k != 0``."""
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

    ``rod``: the rod, ``k > 0``.

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
    transits = np.asarray(t, dtype=float) / track.rod.travel_time
    behind, ahead = track.over(t, square)
    first_behind, first_ahead = track.over(t, lambda wave, at: at * wave**2)
    total = weights.leaving * behind + weights.leaving_slope * (first_behind - transits * behind)
    total += weights.arriving * ahead + weights.arriving_slope * (first_ahead - transits * ahead)
    return np.asarray(track.rod.travel_time * total)


def _need_damping(rod: Rod) -> None:
    if rod.damping <= 0:
        raise AssumptionError(
            f"the Popov-Lyapunov functional needs k > 0; the damping is {rod.damping:g} N s/m", code=Reason.UNDAMPED
        )
