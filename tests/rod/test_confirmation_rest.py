"""Where the rod comes to rest, and whether contact can still come."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from motions import other_rod, unit_rod

from lure.analysis.rod.confirmation.follow import MOST_TRIPS, closed_form_error, flight_after, follow, ringing
from lure.analysis.rod.confirmation.rod_side import initial_zeta, rest_of_rod, rest_of_scheme
from lure.analysis.rod.simulation import simulate
from lure.rod import Scenario, builtin_system, upwind
from lure.rod.motion import exact_motion, motion_windows
from lure.rod.motion.pieces import supremum
from lure.rod.systems import rod_from_exact

DATA = Scenario.parse(displacement="0.05*x - 0.03*x**2", velocity="0.3*sin(3*x) + 0.2")


def first_trip(rod, scenario):
    return next(iter(motion_windows(rod, scenario, 4.5 * rod.travel_time)))


# u0 = -e x released: no momentum, the dashpot at u0(0) = 0 does not move, so z ends at 0 - gap.  Pushed with u1 = 1 the
# dashpot takes up the momentum rho A L = 1: it moves by 1/k.
@pytest.mark.parametrize(("damping", "start", "expected"), [(0.3, 0, -9.0), (0.3, 1, -9 + 1 / 0.3), (3, 1, -9 + 1 / 3)])
def test_zeta_at_the_start_by_hand(damping, start, expected):
    rod = unit_rod(damping=damping, gap=9)
    scenario = Scenario.parse(displacement="-0.1*x", velocity=start)
    assert initial_zeta(rod, scenario) == pytest.approx(expected, rel=1e-15)
    assert flight_after(rod, first_trip(rod, scenario)).zeta == pytest.approx(expected, rel=1e-13)


@pytest.mark.slow
@given(
    ratio=st.floats(-1, 2),
    slope=st.floats(-0.1, 0.1),
    bend=st.floats(-0.1, 0.1),
    push=st.floats(-0.02, 0.02),
    swing=st.floats(-0.1, 0.1),
)
def test_a_released_rod_rests_where_it_was_predicted(ratio, slope, bend, push, swing):
    rod = unit_rod(damping=10**ratio, gap=10)
    scenario = Scenario.parse(
        displacement=f"{slope:.5f}*x + {bend:.5f}*abs(x - 0.3)", velocity=f"{push:.5f} + {swing:.5f}*sin(7*x)"
    )
    followed = follow(rod, scenario, 1.0)
    rest = rest_of_rod(rod, scenario, followed, 10.0)
    assert rest.difference <= 1e-9
    # u0(0) - gap + (1/k) int u1 dx by hand
    momentum = round(push, 5) + round(swing, 5) * (1 - np.cos(7)) / 7
    assert rest.shown == pytest.approx(0.3 * round(bend, 5) - 10 + momentum / 10**ratio, abs=1e-9)


@pytest.mark.parametrize("damping", [0.05, 0.3, 1.0, 3.0])
@pytest.mark.parametrize("compliance", [0.2, 1e-4])
def test_a_rod_that_touched_rests_where_its_impulse_says_and_a_long_run_agrees(damping, compliance):
    rod = other_rod(damping=damping, compliance=compliance, gap=0.05)
    followed = follow(rod, DATA, 3.0)
    rest = rest_of_rod(rod, DATA, followed, 1.0)
    assert rest.difference <= 1e-12
    if followed.flight is not None:
        assert len(followed.windows) > followed.flight_from + 1
        longer = exact_motion(rod, DATA, 1.5 * rest.at)
        assert float(longer.z(longer.until)) == pytest.approx(rest.predicted, abs=1e-9)
        assert rest.predicted < -0.01
    else:
        # k = Z: one wave in, none back; the end leans on the obstacle with a stress that decays exponentially
        assert followed.leans
        assert damping == 1.0
        assert rest.predicted == pytest.approx(0, abs=1e-12)


def test_a_rod_that_rings_for_long_is_continued_by_the_closed_form():
    system = builtin_system("paper-rod")
    followed = follow(system.rod, system.scenario, system.until)
    rest = rest_of_rod(system.rod, system.scenario, followed, 0.02)
    assert len(followed.windows) < MOST_TRIPS
    assert closed_form_error(system.rod, followed) < 1e-15
    # e^{-t} to 1e-14: the rod loses energy at 1.0 1/s
    assert rest.at == pytest.approx(np.log(1e14), rel=1e-3)
    assert rest.predicted == pytest.approx(-0.0199, rel=1e-14)
    assert rest.difference < 1e-12
    assert "closed form" in rest.way
    assert ringing(system.rod, 60_000) == pytest.approx(np.exp(-20), rel=1e-4)


@pytest.mark.parametrize(("damping", "trips"), [(0.05, 40), (3.0, 3), (3.0, 4)])
def test_the_closed_form_of_free_flight_is_the_motion(damping, trips):
    rod = other_rod(damping=damping, gap=5)
    followed = follow(rod, DATA, 2.0)
    late = 2.0 * (followed.flight_from + trips)
    departure = followed.flight.start - followed.flight.zeta
    closed = followed.flight.zeta + ringing(rod, trips) * departure
    assert float(exact_motion(rod, DATA, late).z(late)) == pytest.approx(closed, abs=1e-12)
    assert abs(departure) > 0.01
    assert closed_form_error(rod, followed) < 1e-12


# The bound on all later z is sharp: with the gap moved by it, less or more 1e-9, the rod just touches or just misses.
@pytest.mark.parametrize("damping", [0.02, 0.3, 0.9, 1.2, 3.0, 30.0])
def test_the_bound_on_later_z_is_sharp_from_both_sides(damping):
    far = other_rod(damping=damping, gap=50)
    scenario = Scenario.parse(displacement="0.2*sin(2*x)", velocity="0.1*cos(5*x) - 0.1")
    window = first_trip(far, scenario)
    flight = flight_after(far, window)
    assert 0 <= flight.highest_high - flight.highest_low < 1e-12 * 50
    assert flight.final
    # what the first round trip itself reaches is not "later": only its bound on what follows is moved to the obstacle
    highest = max(flight.highest_high, supremum(window.z)[0])
    later_decides = flight.highest_low >= supremum(window.z)[1]
    for miss, touches in ((1e-9, 0), (-1e-9, 1)):
        near = other_rod(damping=damping, gap=50 + highest + miss)
        motion = exact_motion(near, scenario, 400.0)
        reached = flight.highest_low > flight.zeta + 1e-9  # the supremum is taken, not only approached
        assert len(motion.impacts) >= (touches if reached or not later_decides else 0)
        assert touches or not motion.impacts


# u0' = -u1: only a forward wave, W(tau) = r1(1 - tau) = 2 sin(2 pi tau) on the first transit.  z rises by 2/pi and
# comes back in the first round trip; dips by a 2/pi in the second; rises by a^2 2/pi, a = 1/2, in the third, and
# this is the largest of what comes after the first: -5 - 1/(2 pi) + 1/(2 pi).
def test_the_supremum_counts_where_echoes_change_sign():
    rod = unit_rod(damping=3, gap=5)
    scenario = Scenario.parse(displacement="-cos(2*pi*x)/(2*pi)", velocity="-sin(2*pi*x)")
    flight = flight_after(rod, first_trip(rod, scenario))
    assert flight.highest_low == pytest.approx(-5, abs=1e-13)
    assert flight.highest_high == pytest.approx(-5, abs=1e-12)
    assert float(exact_motion(rod, scenario, 5.0).z(4.5)) == pytest.approx(-5, abs=1e-13)


@given(st.lists(st.floats(-1, 1), min_size=17, max_size=34))
def test_a_supremum_is_bracketed(numbers):
    size = len(numbers) // 2
    series = np.array([numbers[:size], numbers[size : 2 * size]])
    low, high = supremum(series)
    x = np.linspace(-1, 1, 2001)
    sampled = max(float(np.polynomial.chebyshev.chebval(x, row).max()) for row in series)
    total = float(np.abs(series).sum(axis=1).max())
    assert sampled <= high + 1e-14 * total
    assert low - 1e-4 * total * size**2 <= sampled
    assert high - low <= 1e-12 * (1 + total)


def test_the_scheme_rests_where_it_was_predicted_and_elsewhere_than_the_rod():
    rod = other_rod(damping=0.3, gap=0.05)
    scheme = upwind(rod, 20)
    run = simulate(scheme, DATA, until=100.0)
    rest = rest_of_scheme(scheme, DATA, run)
    assert run.contacts
    assert "second solver" in rest.way
    assert rest.difference < 1e-11
    followed = follow(rod, DATA, 3.0)
    assert abs(rest.shown - rest_of_rod(rod, DATA, followed, 1.0).shown) > 1e-2


def test_contact_that_goes_on_is_no_resting_place():
    # pressed by its own momentum against a very soft obstacle for longer than is followed
    system = builtin_system("paper-rod")
    rod = rod_from_exact({**system.rod.exact, "gap": 0})
    followed = follow(rod, Scenario.parse(velocity=1), 1e-3)
    assert followed.flight is None
    assert not followed.leans
    assert rest_of_rod(rod, Scenario.parse(velocity=1), followed, 1.0) is None
    assert len(followed.windows) <= MOST_TRIPS


@pytest.mark.parametrize("damping", [0.0, -0.2])
def test_without_damping_the_rod_is_followed_as_far_as_asked(damping):
    followed = follow(other_rod(damping=damping, gap=1e3), DATA, 30.0)
    assert followed.flight is None
    assert len(followed.windows) == 15
    assert followed.shortened is None
    assert "to keep the report quick" in follow(other_rod(damping=damping, gap=1e3), DATA, 1e9).shortened
