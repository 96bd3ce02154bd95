"""What the tests of lure.rod.motion share: simple rods, and the energy balance recomputed from the fields."""

import math
from importlib.util import find_spec

import numpy as np
import pytest

from lure.rod import Rod

WITH_NUMBA = pytest.mark.skipif(find_spec("numba") is None, reason="numba is not installed")
EITHER_WAY = [pytest.param(False, id="plain"), pytest.param(True, id="compiled", marks=WITH_NUMBA)]

NODES, WEIGHTS = np.polynomial.legendre.leggauss(10)


def unit_rod(**changes):
    """E = rho = A = L = 1, so that c = Z = T = d = 1."""
    values = {"youngs_modulus": 1, "density": 1, "length": 1, "area": 1, "damping": 0, "compliance": 1, "gap": 1}
    return Rod(**{**values, **changes})


def other_rod(**changes):
    """c = 2, Z = 1, T = 1, d = 1/2: no two constants of the formulas agree but Z and T."""
    values = {
        "youngs_modulus": 4.0,
        "density": 1.0,
        "length": 2.0,
        "area": 0.5,
        "damping": 0.3,
        "compliance": 0.2,
        "gap": 0.1,
    }
    return Rod(**{**values, **changes})


def imbalance(motion):
    """``E(until) - E(0) - int (g v(t,0) - k v(t,0)^2 - k_L v(t,L)^2 + int f v dx) dt``, relative, by Gauss panels."""
    rod, T, scenario = motion.rod, motion.rod.travel_time, motion.scenario
    # 10 points on a panel of width h miss the mean of sin(s t)^2 by J_20(s h), below 1e-16 for s h <= 2.5
    edges = [*np.arange(0, motion.until, T / 4), motion.until]
    for window in motion.fields.windows:
        edges += [T * (2 * window.number + edge + lag) for edge in window.edges for lag in (-1, 0, 1)]
    edges += [float(b) for b in scenario.force.breakpoints("t", 0, motion.until) or ()]
    instants, places = motion.fields.sources.body_breaks
    edges += [T * (b + lag) for b in instants for lag in range(3)]
    lags = np.arange(math.ceil(motion.until / T) + 1)
    edges += [T * (lag + sign * x / rod.length) for x in places for lag in lags for sign in (-2, -1, 1, 2)]
    for data in (scenario.displacement, scenario.velocity):
        edges += [float(b) / rod.wave_speed for b in data.breakpoints("x", 0, rod.length) or ()]
    edges = np.array(sorted({edge for edge in edges if 0 <= edge <= motion.until}))
    half = np.diff(edges)[:, None] / 2
    t, weights = edges[:-1, None] + half * (NODES + 1), half * WEIGHTS
    velocity = motion.dashpot_velocity(t)
    k = 0 if motion.boundary.clamped else rod.damping
    power = scenario.force(t=t) * velocity - k * velocity**2 - motion.boundary.end_damping * motion.end_velocity(t) ** 2
    if not scenario.body_force.is_zero:
        power += np.vectorize(lambda s: body_power(motion, s))(t)
    work = (weights * power).sum()
    start, end = motion.energy(0.0), motion.energy(motion.until)
    return abs(end - start - work) / max(start, end, abs(work))


def body_power(motion, t):
    """``int f v dx`` at one instant."""
    x, weights = motion.fields._quadrature(motion.fields.breaks(t / motion.rod.travel_time))
    times = np.full(x.shape, t)
    return (weights * motion.scenario.body_force(t=times, x=x) * motion.velocity(times, x)).sum()
