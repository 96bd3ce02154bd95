"""What the tests of sampled runs share: a motion whose every quantity is known in closed form."""

import numpy as np
from motions import unit_rod

from lure.rod import Scenario
from lure.rod.motion import Boundary, exact_motion


def thrown():
    """A rod with c = Z = T = d = 1 and k = 3 (a = 1/2), thrown at speed 1 against a rigid obstacle at 1/2, until 2 T.

    Contact from 1/2 on with p = W/d = 1, until at 1 = T the wave that x = 0 sends back arrives, W = -a, and the end
    leaves.  V = W until 1/2, W - 2 = -1 until 1; it reaches x = 0 one transit later, where v = (1 - a)/2 V.
    """
    return exact_motion(unit_rod(damping=3, gap=0.5), Scenario.parse(velocity=1), 2.0, boundary=Boundary(rigid=True))


def thrown_end(t):
    return np.minimum(t, 0.5) - 0.5 * np.maximum(t - 1.0, 0.0)


def thrown_velocity(t):
    return np.where(t < 0.5, 1.0, np.where(t < 1.0, 0.0, -0.5))


def thrown_stress(t):
    return np.where((t > 0.5) & (t < 1.0), 1.0, 0.0)


def thrown_dashpot(t):
    """The velocity at x = 0: the initial wave r2 = 1 until T, then V of one transit ago, which is 1, then -1."""
    return np.where(t < 1.5, 0.25, -0.25)


def thrown_energy(t):
    """E' = -k v(t,0)^2 = -3/16, from rho A L v^2/2 = 1/2."""
    return 0.5 - 3.0 * t / 16.0
