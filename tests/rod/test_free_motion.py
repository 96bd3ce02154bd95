"""The exact motion of a rod that does not touch: boundary conditions, momentum, drift and rest."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lure.rod import Rod, Scenario, exact_motion

# c = 2, Z = 1, T = 1.5
UNITS = {"youngs_modulus": 4, "density": 1, "length": 3, "area": 0.5, "compliance": 1, "gap": 50}
SMOOTH = Scenario.parse(force="-exp(-t)*sin(3*t)", displacement="cos(x)/4", velocity="x*x/9 - sin(2*x)")


def rod(damping):
    return Rod(**UNITS, damping=damping)


@pytest.mark.parametrize("damping", [0.01, 0.3, 1.0, 1.7, 100.0])
def test_the_waves_meet_both_boundary_conditions(damping):
    its = rod(damping)
    motion, t = exact_motion(its, SMOOTH, 45), np.random.default_rng(3).uniform(0, 40, 200)
    left, right = motion.waves(t, 0 * t), motion.waves(t, its.length + 0 * t)
    assert left[0] == pytest.approx(-its.reflection * left[1] + 2 * its.input_gain * SMOOTH.force(t=t), abs=1e-10)
    assert right[1] == pytest.approx(right[0], abs=1e-10)
    assert motion.velocity(t, its.length + 0 * t) == pytest.approx(motion.end_velocity(t), abs=1e-10)


WRITTEN = st.floats(-1, 1).filter(lambda value: value == 0 or abs(value) > 1e-300)  # formulas refuse smaller numbers


@given(damping=st.floats(0.2, 5), tilt=WRITTEN, kick=WRITTEN)
def test_momentum_decides_where_the_released_rod_rests(damping, tilt, kick):
    # integrate rho A u_tt = (A E u_x)_x over the rod and all time: -rho A int u1 = -k (u(inf, 0) - u0(0)),
    # and at rest the rod is undeformed
    release = Scenario.parse(displacement=f"{tilt!r}*x + 0.5", velocity=f"{kick!r}*x")
    its = rod(damping)
    rest = exact_motion(its, release, until=200).end_displacement(200)
    assert rest == pytest.approx(0.5 + its.density * its.area * kick * 4.5 / damping, abs=1e-9)


def test_a_constant_pull_ends_in_the_terminal_velocity_of_the_dashpot():
    motion = exact_motion(rod(0.5), Scenario.parse(force=-2), until=60)
    assert motion.end_velocity([58.0, 59.5]) == pytest.approx([-4, -4], abs=1e-7)


def test_without_a_dashpot_the_motion_repeats_and_drifts_with_its_momentum():
    # a = -1: W has period 2T = 3; mean velocity = mean of u1 = 2 is kept
    motion = exact_motion(rod(0), Scenario.parse(displacement="x/5", velocity=-2), until=60)
    t = np.linspace(0, 3, 13)
    assert np.allclose(motion.end_displacement(t + 57), motion.end_displacement(t) - 2 * 57, atol=1e-12)
