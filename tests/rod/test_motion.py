"""lure.rod.motion without contact: waves against closed forms, boundary conditions, loads, streaming, refusals."""

import math

import numpy as np
import pytest
from motions import EITHER_WAY, imbalance, other_rod, unit_rod

from lure import InputError
from lure.rod import RodPlant, Scenario, builtin_system
from lure.rod.motion import Boundary, Numerics, exact_motion, motion_windows

RNG = np.random.default_rng(5)


# Figure 6 without its numerical damping.  w(0, x) = -e and v = 0 give W = c e on (0, T) and -a(-c e) = -|a| c e on
# (T, 2T): u(t, L) falls and rises by e |a|^n in each transit of round trip n, from -e/2 on.
@pytest.mark.slow_for("compiled")
@pytest.mark.parametrize("compiled", EITHER_WAY)
def test_the_released_rod_is_a_triangle_wave_over_a_thousand_round_trips(compiled):
    system = builtin_system("paper-rod")
    rod, e = system.rod, 2e-4
    T, decay = rod.travel_time, RodPlant(system.rod).log_reflection
    motion = exact_motion(rod, system.scenario, 2000 * T, numerics=Numerics(compiled=compiled))
    transit = np.arange(2002)
    trip = transit // 2
    sums = np.expm1(trip * decay) / np.expm1(decay)
    corner = -e / 2 + e * (1 + rod.reflection) * sums + (transit % 2) * e * np.exp(trip * decay)
    t = RNG.uniform(0, 2000 * T, 20_000)
    n = np.floor(t / T).astype(int)
    expected = corner[n] + (corner[n + 1] - corner[n]) * (t / T - n)
    assert np.abs(motion.end_displacement(t) - expected).max() < 1e-12 * e / 2
    assert motion.error < 1e-12 * e
    assert motion.compiled is compiled
    assert motion.impacts == ()


def echoed(rod, scenario, t):
    """What arrives at x = L: the initial wave after n round trips, (-a)^n of it, and every echo of the force since."""
    T, a = rod.travel_time, rod.reflection
    trips = np.floor(t / (2 * T))
    phase = t - 2 * T * trips
    x = np.clip(np.where(phase < T, T - phase, phase - T) / T, 0, 1) * rod.length
    forward, backward = scenario.waves(rod, x)
    sent = [t - T - 2 * T * j for j in range(int(trips.max()) + 1)]
    echoes = [np.where(s >= 0, (-a) ** j * scenario.force(t=np.maximum(s, 0)), 0) for j, s in enumerate(sent)]
    return (-a) ** trips * np.where(phase < T, forward, -a * backward) + 2 * rod.input_gain * sum(echoes)


def test_free_flight_under_a_force_agrees_with_the_sum_over_echoes():
    rod = other_rod(gap=40)
    scenario = Scenario.parse(force="0.4*sin(1.3*t) + exp(-t)", displacement="0.1*x*(2-x)", velocity="0.2*cos(x)")
    motion, t, x = exact_motion(rod, scenario, 41.0), RNG.uniform(0, 40, 2000), RNG.uniform(0, 2, 2000)
    assert motion.end_velocity(t) == pytest.approx(echoed(rod, scenario, t), abs=2e-13)
    inside = t < 40 - rod.travel_time
    forward, _ = motion.waves(t[inside], x[inside])
    on = t[inside] + (rod.length - x[inside]) / rod.wave_speed
    assert forward == pytest.approx(echoed(rod, scenario, on), abs=2e-13)


def test_with_the_matched_dashpot_everything_leaves_in_one_round_trip():
    rod = unit_rod(damping=1)
    motion = exact_motion(rod, Scenario.parse(displacement="0.3*sin(3*x)", velocity="x**2 - 0.2"), 9.0)
    t = np.linspace(2.0, 9.0, 50)
    assert np.all(motion.end_velocity(t) == 0)
    x = np.linspace(0, 1, 7)
    for field in (motion.velocity, motion.strain):
        assert np.all(field(t[:, None], x[None, :]) == 0)
    assert np.ptp(motion.z(t)) == 0
    # v = 1 throughout: the forward half arrives until T, the backward half is swallowed by the dashpot
    pushed = exact_motion(unit_rod(damping=1, gap=9), Scenario.parse(velocity="1"), 9.0)
    assert pushed.end_velocity([0.999, 1.001]) == pytest.approx([1, 0], abs=1e-14)
    assert pushed.velocity(0.999, [0.0, 0.9985, 1.0]) == pytest.approx([0.5, 0.5, 1], abs=1e-14)


# cos(pi x) cos(pi t) satisfies u_x = 0 at both ends (k = 0); sin(pi x/2) cos(pi t/2) u(t, 0) = 0 and u_x(t, 1) = 0.
@pytest.mark.parametrize(("clamped", "wave"), [(False, 1.0), (True, 0.5)])
def test_standing_waves_between_a_free_end_and_one_free_or_clamped(clamped, wave):
    text = f"0.01*sin({wave}*pi*x)" if clamped else f"0.01*cos({wave}*pi*x)"
    motion = exact_motion(unit_rod(), Scenario.parse(displacement=text), 60.0, boundary=Boundary(clamped=clamped))
    x = np.linspace(0, 1, 11)
    shape = np.sin(wave * np.pi * x) if clamped else np.cos(wave * np.pi * x)
    for t in (0.0, 0.3, 1.0, 17.77, 59.9):
        assert motion.displacement(t, x) == pytest.approx(0.01 * shape * math.cos(wave * math.pi * t), abs=3e-15)
        speed = -0.01 * wave * math.pi * shape * math.sin(wave * math.pi * t)
        assert motion.velocity(t, x) == pytest.approx(speed, abs=3e-14)


def test_a_clamped_end_does_not_move_and_feels_no_force():
    scenario = Scenario.parse(velocity="x", force="7*sin(t)")
    motion = exact_motion(unit_rod(gap=4), scenario, 20.0, boundary=Boundary(clamped=True))
    assert np.abs(motion.dashpot_velocity(np.linspace(0, 20, 500))).max() < 1e-14
    quiet = exact_motion(unit_rod(gap=4), Scenario.parse(velocity="x"), 20.0, boundary=Boundary(clamped=True))
    t = np.linspace(0, 20, 500)
    assert np.array_equal(motion.z(t), quiet.z(t))
    with pytest.raises(InputError, match="no dashpot force"):
        motion.dashpot_force(1.0)


def test_a_matched_dashpot_at_the_far_end_takes_everything():
    boundary = Boundary(end_damping=1.0)
    motion = exact_motion(unit_rod(gap=4), Scenario.parse(velocity="1 + x"), 8.0, boundary=boundary)
    assert np.all(motion.velocity(np.full(5, 2.5), np.linspace(0, 1, 5)) == 0)
    assert imbalance(motion) < 1e-13
    half = exact_motion(unit_rod(gap=4), Scenario.parse(velocity="1 + x"), 8.0, boundary=Boundary(end_damping=0.5))
    # r2 = (1 - 1/2)/(1 + 1/2) r1 at x = L
    forward, backward = half.waves(np.array([0.4, 3.3]), np.ones(2))
    assert backward == pytest.approx(forward / 3, rel=1e-14)


# u = sin(t) x^2 (3 - 2x) has u = u_x = 0 at x = 0 and u_x = 0 at x = 1; it solves u_tt = u_xx + f with the f below.
def test_a_body_force_that_was_made_for_a_known_motion():
    body = "-sin(t)*(x**2*(3 - 2*x) + 6 - 12*x)"
    scenario = Scenario.parse(body_force=body, velocity="x**2*(3 - 2*x)")
    motion = exact_motion(unit_rod(gap=4, damping=0.4), scenario, 15.0)
    x = np.linspace(0, 1, 9)
    for t in (0.2, 1.0, 7.3, 15.0):
        assert motion.displacement(t, x) == pytest.approx(math.sin(t) * x**2 * (3 - 2 * x), abs=3e-13)
        assert motion.velocity(t, x) == pytest.approx(math.cos(t) * x**2 * (3 - 2 * x), abs=3e-13)


@pytest.mark.slow
def test_a_body_force_switched_on_a_part_of_the_rod_keeps_the_balance():
    scenario = Scenario.parse(body_force="where(t < 2, 1, 0)*where(x < 0.7, sin(x), 0.1)", displacement="0.05*x**2")
    assert imbalance(exact_motion(other_rod(gap=1), scenario, 4.0)) < 1e-12


def test_kinks_of_the_force_are_met_exactly_wherever_they_are():
    # a step at t = 0.3: u(t, L) of the free unit rod with k = 1 (a = 0) is the integral of 2 b g(t - 1) = g(t - 1)
    motion = exact_motion(unit_rod(damping=1, gap=4), Scenario.parse(force="where(t < 0.3, 0, 1)"), 5.0)
    t = np.linspace(0, 5, 201)
    assert motion.end_displacement(t) == pytest.approx(np.maximum(t - 1.3, 0), abs=1e-14)
    # max(sin t, 0) does not show where its kinks are
    hidden = exact_motion(unit_rod(damping=1, gap=4), Scenario.parse(force="max(sin(t), 0)"), 9.0)
    t = np.linspace(1, 1 + math.pi, 50)
    assert hidden.end_displacement(t) == pytest.approx(1 - np.cos(t - 1), abs=1e-13)
    assert hidden.end_displacement(9.0) == pytest.approx(3 - math.cos(8), abs=2e-13)


@pytest.mark.parametrize("compiled", EITHER_WAY)
def test_no_window_but_the_last_is_needed(compiled):
    rod = other_rod()
    scenario = Scenario.parse(force="0.4*sin(1.3*t)", velocity="0.3")
    whole = exact_motion(rod, scenario, 81.0, numerics=Numerics(compiled=compiled))
    seen = []
    numerics = Numerics(keep=3, on_window=lambda window: seen.append(window.number), compiled=compiled)
    kept = exact_motion(rod, scenario, 81.0, numerics=numerics)
    assert seen == list(range(41)) == [window.number for window in motion_windows(rod, scenario, 81.0)]
    assert len(kept.fields.windows) == 3
    assert kept.impacts == whole.impacts != ()
    t = np.linspace(kept.since, 81.0, 40)
    assert kept.z(t) == pytest.approx(whole.z(t), rel=1e-14)  # a record of a state rounds in another place
    with pytest.raises(InputError, match=r"give times in \[76, 81\] s"):
        kept.z(70.0)


def test_the_degree_of_the_series_does_not_show():
    scenario = Scenario.parse(force="0.4*sin(1.3*t)", displacement="0.1*x*(2-x)", velocity="0.2*cos(x)")
    motions = [exact_motion(other_rod(), scenario, 30.0, numerics=Numerics(degree=n)) for n in (10, 16, 27)]
    t = np.linspace(0, 30, 1001)
    assert motions[0].impacts
    for motion in motions[:2]:
        assert motion.z(t) == pytest.approx(motions[2].z(t), abs=3e-13)
        for ours, theirs in zip(motion.impacts, motions[2].impacts, strict=True):
            assert ours.start == pytest.approx(theirs.start, abs=1e-11)
            assert ours.impulse == pytest.approx(theirs.impulse, rel=1e-11)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"until": 0.0}, "give a positive number of seconds"),
        ({"until": math.nan}, "give a positive number of seconds"),
        ({"until": 1e9}, r"5e\+08 round trips; give at most 2e\+07 s"),
        ({"scenario": Scenario.parse(force="1/(t - 3)**2 + log(t - 3)")}, "force.g has no finite value"),
        ({"scenario": Scenario.parse(velocity="log(x)*x - log(x - 1)")}, "initial.u1 is"),
        ({"scenario": Scenario.parse(velocity="1e200*x")}, r"wave in round trip 0 is 1e\+200 m/s"),
        ({"scenario": Scenario.parse(force="sin(100000*t)")}, "more than 5000 pieces in one round trip"),
        ({"scenario": Scenario.parse(body_force="where(x < t, 1, 0)")}, "conditions that are linear in t alone"),
        ({"boundary": Boundary(rigid=True), "rod": unit_rod(gap=-0.5)}, "0.5 m inside the obstacle, which is rigid"),
        ({"rod": unit_rod(gap=-0.5, compliance=1e-300)}, "0.5 m inside the obstacle, which is rigid"),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_sentence(arguments, message):
    values = {"rod": unit_rod(), "scenario": Scenario.parse(), "until": 10.0, **arguments}
    with pytest.raises(InputError, match=message):
        exact_motion(values["rod"], values["scenario"], values["until"], boundary=values.get("boundary"))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Boundary(end_damping=-1.0), "end_damping is -1.0"),
        (lambda: Boundary(nonlinearity=3), "nonlinearity is a int"),
        (lambda: Numerics(degree=3), "degree is 3"),
        (lambda: Numerics(keep=1), "keep is 1"),
        (lambda: Numerics(compiled=1), "compiled is 1"),
    ],
)
def test_options_are_checked(make, message):
    with pytest.raises(InputError, match=message):
        make()
