"""lure.rod.scenario: loads, initial data, whether they match at the ends, and the initial state of the scheme."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lure import InputError
from lure.rod import Scenario, initial_state, matching, upwind
from lure.rod.systems import builtin_system, paper_rod, rod_from_exact

RELEASE = Scenario.parse(displacement="0.0001 - 0.0002*x")


def number(value):
    return f"({value.numerator}/{value.denominator})" if value >= 0 else f"(0 - {-value.numerator}/{value.denominator})"


def test_a_scenario_without_arguments_is_rest_without_load():
    scenario = Scenario()
    assert scenario.free
    assert not np.any(initial_state(upwind(paper_rod(), 3), scenario)[:-1])
    assert scenario.contact_coordinate(paper_rod()) == -0.02


@pytest.mark.parametrize(
    ("loads", "free"),
    [
        ({}, True),
        ({"displacement": "x", "velocity": 3}, True),
        ({"force": "2*sin(4*t)"}, False),
        ({"body_force": "x*t"}, False),
        ({"force": "0*sin(t)", "body_force": 0.0}, True),
    ],
)
def test_a_scenario_is_free_when_no_load_acts(loads, free):
    assert Scenario.parse(**loads).free is free


@pytest.mark.parametrize(
    ("name", "key"),
    [("force", "force.g"), ("body_force", "force.f"), ("displacement", "initial.u0"), ("velocity", "initial.u1")],
)
def test_an_error_in_a_formula_names_the_key_of_the_file(name, key):
    with pytest.raises(InputError, match=rf"^{key}\b"):
        Scenario.parse(**{name: "y + 1"})


def test_the_waves_of_a_displacement_and_a_velocity_by_hand():
    # u0 = x^2, u1 = 3x, c = 6000: r1 = 3x - 12000x, r2 = 3x + 12000x
    scenario = Scenario.parse(displacement="x**2", velocity="3*x")
    forward, backward = scenario.waves(paper_rod(), np.array([0.0, 0.5, 1.0]))
    assert forward.tolist() == [0, -5998.5, -11997]
    assert backward.tolist() == [0, 6001.5, 12003]


def test_the_initial_state_is_the_corrected_37_in_each_ordering():
    # N = 2, x = 0, 1/2, 1: xi1^1, xi1^2 = r1(1/2), r1(1); xi2^1, xi2^0 = r2(1/2), r2(0); z = 1 - gap
    scenario = Scenario.parse(displacement="x**2", velocity="3*x + 1")
    r1, r2, z = [-5997.5, -11996.0], [6002.5, 1.0], 0.98
    assert initial_state(upwind(paper_rod(), 2), scenario).tolist() == [*r1, *r2, z]
    assert initial_state(upwind(paper_rod(), 2, ordering="eq42"), scenario).tolist() == [*r1, *r2, z]
    assert initial_state(upwind(paper_rod(), 2, ordering="eq48"), scenario).tolist() == [*r1, z, *r2]


def test_the_initial_state_does_not_depend_on_the_form():
    corrected, printed = (upwind(paper_rod(), 4, form=form) for form in ("corrected", "as-printed"))
    assert np.array_equal(initial_state(corrected, RELEASE), initial_state(printed, RELEASE))


# u0' = -2e-4 throughout: r1 = 6000 * 2e-4 = 1.2 and r2 = -1.2; z = -1e-4 - 0.02 (figure 6 starts at -1e-4)
def test_the_release_of_the_paper_starts_two_waves_of_1_2_metres_per_second():
    state = initial_state(upwind(paper_rod(), 10), RELEASE)
    assert state[:10] == pytest.approx([1.2] * 10, rel=1e-15)
    assert state[10:20] == pytest.approx([-1.2] * 10, rel=1e-15)
    assert state[20] == pytest.approx(-0.0201, rel=1e-15)


def test_the_contact_coordinate_is_the_end_against_the_obstacle():
    longer = rod_from_exact({**paper_rod().exact, "length": Fraction(2), "gap": Fraction(-1, 4)})
    assert Scenario.parse(displacement="x/8").contact_coordinate(longer) == 0.5


def matched_data(*, contact, force):
    """A displacement and a velocity that satisfy both conditions (8) of the paper's rod exactly, as rationals."""
    rod = paper_rod()
    E, A, k, gap = (rod.exact[name] for name in ("youngs_modulus", "area", "damping", "gap"))
    velocity = Fraction(36)
    alpha = (k * velocity - force) / (A * E)  # A E u0'(0) = k u1(0) - g(0)
    # u0 = start + alpha x + beta x^2 on 0..1: E (alpha + 2 beta) = -p(z), z = start + alpha + beta - gap, eps = 1
    if contact:
        start = gap + Fraction(1, 100)
        beta = -(start - gap + alpha + E * alpha) / (2 * E + 1)
    else:
        start, beta = Fraction(0), -alpha / 2
    return start, alpha, beta, velocity


@pytest.mark.parametrize("contact", [True, False])
@pytest.mark.parametrize("force", [Fraction(0), Fraction(5, 2)])
def test_data_that_satisfy_both_boundary_conditions_are_matched(contact, force):
    start, alpha, beta, velocity = matched_data(contact=contact, force=force)
    displacement = f"{number(start)} + {number(alpha)}*x + {number(beta)}*x**2"
    scenario = Scenario.parse(displacement=displacement, velocity=velocity, force=f"{number(force)}*cos(t)")
    assert (scenario.contact_coordinate(paper_rod()) > 0) is contact
    found = matching(paper_rod(), scenario)
    assert found.matched
    assert str(found) == "Initial and boundary data are matched at both ends."


@pytest.mark.parametrize(
    ("changes", "dashpot", "contact"),
    [
        ({"force": "5/2 + 1/1000"}, 1e-3, 0.0),  # g(0) is a term of the balance at the dashpot
        ({"velocity": "37"}, -2e-4, 0.0),  # - k u1(0)
        ({"displacement": "1/10**5"}, 0.0, 1e-5),  # the stress 1/eps = 1 Pa/m times the shift
    ],
)
def test_data_off_by_a_little_are_not_matched_and_say_by_how_much(changes, dashpot, contact):
    start, alpha, beta, velocity = matched_data(contact=True, force=Fraction(5, 2))
    parts = {
        "displacement": f"{number(start)} + {number(alpha)}*x + {number(beta)}*x**2",
        "velocity": f"{number(velocity)}",
        "force": "5/2",
    }
    if "displacement" in changes:
        changes = {"displacement": parts["displacement"] + " + " + changes["displacement"]}
    found = matching(paper_rod(), Scenario.parse(**{**parts, **changes}))
    assert not found.matched
    assert found.dashpot == pytest.approx(dashpot, rel=1e-6, abs=1e-9)
    assert found.contact == pytest.approx(contact, rel=1e-6, abs=1e-9)


# a compressed rod has stress at both ends that nothing holds from t = 0 on:
# A E u0'(0) = 7200 * (-2e-4) = -1.44 N, E u0'(L) = 288e6 * (-2e-4) = -57600 Pa
def test_the_release_of_the_paper_is_not_matched():
    found = matching(paper_rod(), RELEASE)
    assert not found.matched
    assert (found.dashpot, found.contact) == pytest.approx((-1.44, -57600))
    assert str(found).startswith(
        "Initial and boundary data are not matched (off by -1.44 N at x = 0 and -5.76e+04 Pa at x = L): "
    )
    assert "scheme smears it" in str(found)


@pytest.mark.parametrize("name", ["paper-rod", "paper-rod-figure-8", "paper-rod-figure-9", "paper-rod-figure-10"])
def test_all_systems_of_the_paper_start_from_unmatched_data(name):
    system = builtin_system(name)
    assert not matching(system.rod, system.scenario).matched


@given(shift=st.integers(-1000, 19).map(lambda n: n / 1000), speed=st.integers(-100, 100).map(lambda n: n / 10))
def test_rigid_motion_short_of_the_obstacle_is_matched_only_at_rest(shift, speed):
    # u0 constant: no stress; the dashpot resists the speed with k u1
    found = matching(paper_rod(), Scenario.parse(displacement=shift, velocity=speed))
    assert found.contact == 0
    assert found.dashpot == pytest.approx(-2e-4 * speed, rel=1e-12)
    assert found.matched is (speed == 0)


def test_a_rod_pressed_into_the_obstacle_without_stress_is_not_matched():
    # p(0.05 - 0.02) = 0.03 Pa
    found = matching(paper_rod(), Scenario.parse(displacement="0.05"))
    assert found.contact == pytest.approx(0.03)
    assert not found.matched


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"displacement": "sqrt(x)"}, r"the slope of initial\.u0 is inf at x = 0 m"),
        ({"displacement": "log(x - 2)"}, r"initial\.u0 is nan at x = 1 m"),
        ({"velocity": "log(x)"}, r"initial\.u1 is -inf at x = 0 m"),
        ({"velocity": "1/(x - 1)"}, r"initial\.u1 is inf at x = 1 m"),
    ],
)
def test_initial_data_that_are_not_finite_are_refused_by_name_and_place(parts, message):
    with pytest.raises(InputError, match=rf"^{message}; give a formula that is finite there$"):
        initial_state(upwind(paper_rod(), 4), Scenario.parse(**parts))


def test_a_force_that_is_not_finite_at_the_start_is_refused():
    with pytest.raises(InputError, match=r"^force\.g is -inf at t = 0 s; give a formula that is finite there$"):
        matching(paper_rod(), Scenario.parse(force="log(t)"))


def test_numbers_and_text_mean_the_same():
    one, other = (
        Scenario.parse(displacement=0.1, velocity=Fraction(1, 4)),
        Scenario.parse(displacement="0.1", velocity="1/4"),
    )
    x = np.array([0.0, 0.3])
    for wave, twin in zip(one.waves(paper_rod(), x), other.waves(paper_rod(), x), strict=True):
        assert np.array_equal(wave, twin)
    assert one.contact_coordinate(paper_rod()) == other.contact_coordinate(paper_rod())
    assert math.isclose(one.contact_coordinate(paper_rod()), 0.08)
