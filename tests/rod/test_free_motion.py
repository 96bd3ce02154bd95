"""Free motion of the rod in closed form: boundary conditions, rest, and the refusal of whatever touches."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lure import AssumptionError, InputError
from lure.rod import Rod, Scenario, builtin_system
from lure.rod.free_motion import free_motion

PAPER = builtin_system("paper-rod")
# c = 2, Z = 1, T = 1.5
UNITS = {
    "youngs_modulus": 4,
    "density": 1,
    "length": 3,
    "area": 0.5,
    "compliance": 1,
    "gap": 50,
}  # c = 2, Z = 1, T = 1.5
SMOOTH = Scenario.parse(force="-exp(-t)*sin(3*t)", displacement="cos(x)/4", velocity="x*x/9 - sin(2*x)")


def rod(damping):
    return Rod(**UNITS, damping=damping)


def test_the_papers_rod_swings_by_e_and_loses_the_factor_a_each_round_trip():
    # u0 = e/2 - e x: W = c e on (0, T), then a c e on (T, 2T), so u(T) = e/2, u(2T) = u(T) + a e, and every round trip
    # repeats the last one times -a
    motion = free_motion(PAPER.rod, PAPER.scenario, until=5e-3)
    e, a, T = 2e-4, PAPER.rod.reflection, PAPER.rod.travel_time
    top, bottom, expected = e / 2, -e / 2, []
    for trip in range(10):
        expected += [bottom, top]
        bottom = top + a * e * (-a) ** trip
        top = bottom + e * (-a) ** (trip + 1)
    assert motion.end_displacement(T * np.arange(20)) == pytest.approx(expected, abs=1e-17)
    assert motion.end_wave(T * (np.arange(4) + 0.5)) == pytest.approx([1.2, 1.2 * a, -1.2 * a, -1.2 * a * a], rel=1e-13)


@given(damping=st.floats(0.01, 100), t=st.floats(0, 40))
def test_the_waves_meet_both_boundary_conditions(damping, t):
    its = rod(damping)
    motion = free_motion(its, SMOOTH, until=45)
    left, right = motion.waves(t, 0.0), motion.waves(t, its.length)
    force = SMOOTH.force(t=t)
    assert left[0] == pytest.approx(-its.reflection * left[1] + 2 * its.input_gain * force, abs=1e-10)
    assert right[1] == pytest.approx(right[0], abs=1e-10)
    assert motion.velocity(t, its.length) == pytest.approx(motion.end_wave(t), abs=1e-10)


@given(damping=st.floats(0.01, 100), t=st.floats(0, 30), x=st.floats(0, 3), lag=st.floats(0, 1))
def test_the_waves_move_along_their_characteristics_unchanged(damping, t, x, lag):
    its = rod(damping)
    motion = free_motion(its, SMOOTH, until=45)
    onward, back = lag * (its.length - x), lag * x
    assert motion.waves(t + onward / 2, x + onward)[0] == pytest.approx(motion.waves(t, x)[0], abs=1e-9)
    assert motion.waves(t + back / 2, x - back)[1] == pytest.approx(motion.waves(t, x)[1], abs=1e-9)


def test_the_motion_begins_as_the_scenario_says():
    x = np.linspace(0.1, 2.9, 29)  # at the ends the data do not fit, and the waves jump
    forward, backward = free_motion(rod(0.3), SMOOTH, until=10).waves(0.0, x)
    assert np.allclose([forward, backward], SMOOTH.waves(rod(0.3), x), atol=1e-13)


@given(damping=st.sampled_from([0.0, 0.03, 0.999999, 1.0, 1.2, 40.0]), t=st.floats(0, 30))
def test_the_displacement_is_the_integral_of_the_end_velocity(damping, t):
    # independent of the closed sums: Gauss quadrature of W over the pieces between its jumps at multiples of T
    motion = free_motion(rod(damping), SMOOTH, until=31)
    nodes, weights = np.polynomial.legendre.leggauss(20)
    edges = np.append(np.arange(0, t, 1.5), t)
    middle, half = (edges[1:] + edges[:-1]) / 2, (edges[1:] - edges[:-1]) / 2
    integral = float((half[:, None] * motion.end_wave(middle[:, None] + half[:, None] * nodes) @ weights).sum())
    start, now = motion.end_displacement([0.0, t])
    assert now - start == pytest.approx(integral, abs=1e-10)


WRITTEN = st.floats(-1, 1).filter(lambda value: value == 0 or abs(value) > 1e-300)  # formulas refuse smaller numbers


@given(damping=st.floats(0.2, 5), tilt=WRITTEN, kick=WRITTEN)
def test_momentum_decides_where_the_released_rod_rests(damping, tilt, kick):
    # integrate rho A u_tt = (A E u_x)_x over the rod and all time: -rho A int u1 = -k (u(inf, 0) - u0(0)),
    # and at rest the rod is undeformed
    release = Scenario.parse(displacement=f"{tilt!r}*x + 0.5", velocity=f"{kick!r}*x")
    its = rod(damping)
    rest = free_motion(its, release, until=200).end_displacement(200)
    assert rest == pytest.approx(0.5 + its.density * its.area * kick * 4.5 / damping, abs=1e-9)


def test_a_constant_pull_ends_in_the_terminal_velocity_of_the_dashpot():
    motion = free_motion(rod(0.5), Scenario.parse(force=-2), until=60)
    assert motion.end_wave([58.0, 59.5]) == pytest.approx([-4, -4], abs=1e-7)


def test_the_matched_rod_is_at_rest_after_one_round_trip():
    motion = free_motion(rod(1), Scenario.parse(displacement="x*(3 - x)", velocity="cos(x)"), until=12)
    assert np.ptp(motion.end_displacement(np.linspace(3, 12, 40))) == 0
    assert np.all(motion.end_wave(np.linspace(3.01, 12, 40)) == 0)


def test_without_a_dashpot_the_motion_repeats_and_drifts_with_its_momentum():
    # a = -1: W has period 2T = 3; mean velocity = mean of u1 = 2 is kept
    motion = free_motion(rod(0), Scenario.parse(displacement="x/5", velocity=-2), until=60)
    t = np.linspace(0, 3, 13)
    assert np.allclose(motion.end_displacement(t + 57), motion.end_displacement(t) - 2 * 57, atol=1e-12)


@pytest.mark.parametrize(
    ("scenario", "message"),
    [
        # near rigid: 1.5 kg under 1 N against 0.1 N s/m is at 10 t - 150 (1 - e^{-t/15}), 50 m at t = 14.2 s
        (Scenario.parse(force=1), r"the end reaches the obstacle at about t = 14\.\d+ s"),
        (Scenario.parse(displacement=51), r"the end reaches the obstacle at about t = 0 s"),
    ],
)
def test_a_motion_that_touches_is_refused(scenario, message):
    with pytest.raises(AssumptionError, match=message):
        free_motion(rod(0.1), scenario, until=100)


def test_a_motion_is_free_until_just_before_it_touches():
    # thrown at 2 m/s without a dashpot: the undeformed rod travels at 2 m/s and covers the gap of 50 m at t = 25 s; the
    # check allows |W|/2 = 1 m/s times T/16 = 0.094 s
    thrown = Scenario.parse(velocity=2)
    assert free_motion(rod(0), thrown, until=24.7).largest_z < 0
    with pytest.raises(AssumptionError, match="reaches the obstacle"):
        free_motion(rod(0), thrown, until=25)


@pytest.mark.parametrize(
    ("scenario", "until", "message"),
    [
        (Scenario.parse(body_force="x"), 1, "force.f is x; free_motion takes no body force"),
        (Scenario.parse(force="sqrt(1 - t)"), 9, r"'sqrt\(1 - t\)' is not finite somewhere on the span"),
        (Scenario.parse(displacement="-sqrt(x - 1)"), 9, "initial.u0 is nan at x ="),
        (Scenario(), 0, "until is 0; give a positive number"),
        (Scenario(), float("nan"), "until is nan; give a positive number"),
        (Scenario(), 1e9, "transits; give at most"),
    ],
)
def test_what_cannot_be_computed_is_refused(scenario, until, message):
    with pytest.raises(InputError, match=message):
        free_motion(rod(0.1), scenario, until)


def test_times_and_places_outside_are_refused():
    motion = free_motion(rod(0.1), Scenario(), until=5)
    with pytest.raises(InputError, match=r"give times in \[0, 5\] s"):
        motion.end_displacement(5.1)
    with pytest.raises(InputError, match=r"give times in \[0, 5\] s"):
        motion.waves(4.0, 0.0)
    with pytest.raises(InputError, match=r"give positions in \[0, 3\] m"):
        motion.velocity(1.0, 3.5)
