"""Whether a rod that moves freely can still reach the obstacle: bounds on whole intervals, not on samples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lure.analysis.rod.confirmation.functionals import zeta_gain
from lure.rod.motion import Window
from lure.rod.motion.pieces import Array, basis, restricted, right_ends, upper_bounds
from lure.rod.parameters import Rod

_HALVINGS = 44
_ROUNDING = 32.0 * np.finfo(float).eps


@dataclass(frozen=True, kw_only=True, slots=True)
class Flight:
    """Free flight for ever, from the end of a round trip on.

    Attributes
    ----------
    start : float
        Contact coordinate at its beginning [m].
    zeta : float
        Where it goes [m].
    highest_low, highest_high : float
        Bracket on the supremum of ``z`` over all later times [m].
    """

    start: float
    zeta: float
    highest_low: float
    highest_high: float

    @property
    def final(self) -> bool:
        """Whether no contact can follow."""
        return self.highest_high < 0.0


def flight_after(rod: Rod, window: Window) -> Flight:
    r"""Free flight after a round trip at the end of which the obstacle is not touched.

    The next round trip brings ``W(tau) = -a V`` of the last one, and with ``C(tau) = int_0^tau W``,
    ``D = C - (zeta - z_0)``, ``zeta = z_0 + C(2T)/(1 + a)``, the flight is known for ever:

    .. math:: z(2T m + \tau) = \zeta + (-a)^m D(\tau), \qquad m = 0, 1, 2, \ldots

    As ``|a| < 1`` its supremum is the largest of ``zeta`` (in the limit), ``zeta + sup D`` (in the first round trip)
    and ``zeta - a inf D`` (for ``a > 0``, in the second).  ``sup D`` is bracketed: from below by values, from above by
    bounds on Chebyshev series over whole pieces, which are halved until both ends agree to rounding.  It is the
    continuous counterpart of the bound on the shift register of the scheme.

    Parameters
    ----------
    rod : Rod
        The rod, ``k > 0``.
    window : Window
        The whole round trip before.

    Notes
    -----
    COMPUTED: floating point; the upper end of the bracket contains an allowance for rounding.
    """
    a = rod.reflection
    space = basis(window.returned.shape[1] - 1)
    widths = np.diff(window.edges)
    travel = (-0.5 * a * rod.travel_time * widths)[:, None] * (window.returned @ space.integral.T)
    passed = np.concatenate(([0.0], np.cumsum(right_ends(travel))))
    travel[:, 0] += passed[:-1]
    start = float(right_ends(window.z)[-1])
    away = float(passed[-1]) * zeta_gain(rod) / rod.travel_time
    departures = travel.copy()
    departures[:, 0] -= away
    low, high = supremum(departures)
    if a > 0.0:
        low_again, high_again = (a * end for end in supremum(-departures))
        low, high = max(low, low_again), max(high, high_again)
    size = float(np.abs(departures).sum(axis=1).max()) + abs(away) + abs(start)
    zeta = start + away
    return Flight(
        start=start,
        zeta=zeta,
        highest_low=zeta + max(0.0, low),
        highest_high=zeta + max(0.0, high) + _ROUNDING * size,
    )


def supremum(series: Array) -> tuple[float, float]:
    """Bracket on the largest value of a piecewise polynomial.

    Parameters
    ----------
    series : ndarray
        (m, N+1) Chebyshev coefficients.

    Returns
    -------
    low, high : float
        A value that is taken, and a bound that no value exceeds, up to rounding.

    Examples
    --------
    >>> low, high = supremum(np.array([[0.0, 0.5, -0.5]]))  # -x^2 + x/2 + 1/2 is largest at x = 1/4
    >>> low, bool(high - low < 1e-12)
    (0.5625, True)
    """
    space = basis(series.shape[1] - 1)
    size = float(np.abs(series).sum(axis=1).max())
    low, high = -np.inf, -np.inf
    for _ in range(_HALVINGS):
        low = max(low, float((series @ space.at_ends.T).max()))
        tops = upper_bounds(series)
        open_ = tops > low + 1e-15 * size
        high = max(high, float(tops[~open_].max(initial=-np.inf)))
        if not open_.any():
            return low, max(low, high)
        left, right = np.full(int(open_.sum()), -1.0), np.zeros(int(open_.sum()))
        series = np.concatenate((restricted(series[open_], left, right), restricted(series[open_], right, -left)))
    return low, max(low, high, float(upper_bounds(series).max()))
