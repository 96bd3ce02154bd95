"""Whether a rod that moves freely can still reach the obstacle."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.simulation.ring import Ring

Array = NDArray[np.float64]


def highest_ever(ring: Ring, state: Array) -> float:
    r"""Bound on ``s z`` at all later times of free flight without loads.

    The motion is an average, with positive weights, of the shifted states: ``z`` stays below the largest ``z_n`` of the
    shift register, which loses nothing to the grid.  With ``C_n`` what ``n`` shifts of the first round trip add and
    ``S = C_{2N}``, ``m`` round trips and ``n`` shifts give

    .. math:: z_{2Nm+n} = \zeta + (-a)^m (C_n - (\zeta - z_0)), \qquad \zeta = z_0 + S/(1+a),

    so that the largest is found in one round trip (two for ``a > 0``) and at infinity.

    Parameters
    ----------
    ring : Ring
        The scheme, ``k > 0``.
    state : ndarray
        (2N+1,) scaled state in free flight.

    Returns
    -------
    float
        Supremum of the sequence [m/s]; below zero means that no contact can follow.
    """
    N = ring.cells
    leaving = np.concatenate((state[N - 1 :: -1], ring.echo * state[-2 : N - 1 : -1]))
    sums = np.concatenate(([0.0], np.cumsum(leaving)))
    settled = state[-1] + sums[-1] / ring.opening
    departures = sums - (settled - state[-1])
    return float(max(settled, settled + departures.max(), settled + (ring.echo * departures).max()))
