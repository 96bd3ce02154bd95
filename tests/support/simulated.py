"""What the tests of simulation share: a rod of small numbers, loads, and another solver to compare with."""

import numpy as np
from scipy.integrate import solve_ivp

from lure.rod import Rod, Scenario, builtin_system, initial_state

PAPER = builtin_system("paper-rod")
# c = 2, Z = 1, d = 1/2, T = 1.5, s = 2 N/3; contact as stiff as a cell of rod where compliance is h/E
UNITS = {"youngs_modulus": 4, "density": 1, "length": 3, "area": 0.5, "compliance": 0.1, "gap": 0.2}
FLYING = Scenario.parse(displacement="0.1*cos(x)", velocity="0.3 + 0.2*sin(2*x)")
DRIVEN = {
    "force": {"force": "0.4*sin(3*t)"},
    "a force that jumps": {"force": "where(t < 1.3, 0.5, -0.2)"},
    "a force with kinks": {"force": "0.4*abs(sin(3*t)) + min(t, 1)/4"},
    "body force": {"body_force": "0.2*sin(3*t)*x"},
    "both": {"force": "0.1", "body_force": "where(t < 2, 0.3, 0)*cos(x) + 0.1*t"},
}


def rod(**changes):
    return Rod(**{**UNITS, "damping": 0.4, **changes})


def reference(scheme, scenario, times, stiff=False):
    """The motion from the matrices of the block by scipy, to about 1e-11."""
    its, block, N = scheme.rod, scheme.block, scheme.cells
    A = block.A.toarray()
    x = its.length * np.concatenate((np.arange(1, N + 1), np.arange(N - 1, -1, -1))) / N

    def right_hand_side(t, y):
        load = scenario.body_force(t=t, x=x) / (its.density * its.area)
        return A @ y - block.b1 * its.nonlinearity(y[-1]) + block.b2 * scenario.force(t=t) + np.append(load, 0.0)

    start = initial_state(scheme, scenario)
    method, span = ("Radau", (0, times[-1])) if stiff else ("DOP853", (0, times[-1]))
    step = np.inf if stiff else 0.1 / scheme.rate
    tolerance = 1e-11 if stiff else 1e-12
    return solve_ivp(right_hand_side, span, start, method, times, rtol=tolerance, atol=1e-13, max_step=step).y[-1]
