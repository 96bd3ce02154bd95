"""Steady responses in discrete time to a sampled sine: exact where the loop is linear, attacked by simulation."""

import math
from fractions import Fraction

import numpy as np
import pytest
from flint import arb, fmpq_mat

from lure import Saturation, Tanh
from lure.analysis import steady_response
from lure.analysis.forced.band import Residual
from lure.analysis.forced.loop import ForcedLoop
from lure.analysis.forced.samples import Falling, carried, falling, positive_definite
from lure.analysis.verdict import Verdict
from lure.files.reading import parse_system
from lure.plants.multivariable import MultivariablePlant


# x+ = x/2 - sat(x) + w: while |x| <= 1 it is x+ = -x/2 + w, of amplitude a/|e^(i theta) + 1/2| <= 2 a, here 2/3
@pytest.mark.slow_for("dt0")
@pytest.mark.parametrize("dt", [Fraction(1), Fraction(1, 10)])
def test_a_loop_that_stays_on_a_line_has_the_amplitude_of_the_linear_loop(dt):
    plant = MultivariablePlant(((Fraction(1, 2),),), ((Fraction(1),),), ((Fraction(1),),), ((Fraction(0),),), dt)
    found = steady_response(plant, Saturation(), {"amplitude": Fraction(1, 3), "omega": 1 / dt})
    truth = 1 / 3 / abs(complex(math.cos(1) + 0.5, math.sin(1)))
    (row,) = found.response
    assert found.verdict is Verdict.PROVED
    assert row.omega == float(1 / dt)
    assert truth * (1 - 1e-9) < row.low <= truth <= row.high < truth * (1 + 1e-9)


LOOP = """
[plant]
A = [[0.5, 0.25, 0], [-0.25, 0.6, 0.1], [0, 0.2, -0.3]]
B = [[1, 0], [0.5, 0.2], [0, 1]]
C = [[0.5, 0.2, 0], [0, 0.1, 0.4]]
D = [[0, 0], [0.125, 0]]
dt = 0.5

[[nonlinearity]]
kind = "saturation"
gain = 1
limit = 1

[[nonlinearity]]
kind = "tanh"

[performance]
Bw = [[1], [0], [1]]
Cz = [[1, 1, 0]]
Dzmu = [[0, 0.25]]

[forcing]
amplitude = 4
omega = [3]
constant = 0.25
"""


@pytest.mark.slow
def test_no_sample_of_a_simulation_leaves_the_band_and_one_comes_near_to_it():
    system = parse_system(LOOP, name="loop", source="a test")
    found = steady_response(system)
    A, B, C, D = (np.array(side, float) for side in (system.block.A, system.block.B, system.block.C, system.block.D))
    assert found.verdict is Verdict.PROVED
    for row in found.response:
        phases = np.linspace(0, 2 * np.pi, 2000, endpoint=False)  # all at once, which the solution comes to one by one
        x, largest = np.zeros((3, 2000)), 0.0
        for t in range(200):
            w = 0.25 + 4 * np.sin(row.omega * 0.5 * t + phases)
            sigma = C @ x
            mu = np.array([-np.clip(sigma[0], -1, 1), sigma[1]])
            mu[1] = -np.tanh(sigma[1] + D[1, 0] * mu[0])
            z = x[0] + x[1] + mu[1] / 4
            largest = np.abs(z).max() if t == 199 else 0.0
            x = A @ x + B @ mu + np.outer([1, 0, 1], w)
        assert row.low <= largest * (1 + 1e-5)
        assert largest <= row.high
        assert row.amplitude.width < 1e-2 * largest


def test_a_function_that_falls_is_shown_in_exact_numbers():
    plant = MultivariablePlant(((Fraction(1, 2),),), ((Fraction(1),),), ((Fraction(1),),), ((Fraction(0),),), 1)
    loop = ForcedLoop.around(plant, None, [Tanh()], [(Fraction(0), Fraction(1))])  # x+ = -nu' + .., |nu'| <= |x|/2
    found = falling(loop, 0.5)
    assert found is not None
    assert positive_definite(found.P)
    # V = p x^2: p (kappa x + e)^2 <= rho^2 p x^2 + beta e^2 for all x, e needs beta >= p rho^2/(rho^2 - kappa^2)
    p, (beta,), kappa2 = Fraction(str(found.P[0, 0])), found.pushes, Fraction(1, 4)
    assert beta >= p * found.rho2 / (found.rho2 - kappa2)
    assert falling(loop, 0.1).rho2 > kappa2  # no smaller factor is true
    assert not positive_definite(fmpq_mat([[1, 2], [2, 1]]))


# e = 1 at all phases adds beta (1 + rho^2 + ..) = 3/(1 - 1/4) = 4; e = 1 on one of 1024 parts, which no orbit of this
# angle meets again before long, beta alone, up to its neighbours
@pytest.mark.parametrize(("parts", "low", "high"), [(np.ones(1024), 4, 4.0001), (np.eye(1, 1024)[0], 3, 3.01)])
def test_what_is_carried_over_from_samples_before(parts, low, high):
    missed = Residual([], [], [], arb(0), arb(1), [parts])
    found = carried(missed, Falling(fmpq_mat([[1]]), Fraction(1, 4), (Fraction(3),)), Fraction(7, 10))
    assert low <= float(found) <= high
