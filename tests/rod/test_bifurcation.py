"""Sweeps of a parameter and resting places: what is kept, how each value starts, and closed forms for both."""

import importlib
import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from motions import other_rod, unit_rod

from lure.analysis.rod.response import Plan, Sweep, basin, bifurcation, response, resting_place
from lure.analysis.verdict import Evidence
from lure.errors import AssumptionError, InputError
from lure.rod import Scenario
from lure.rod.motion import Boundary, exact_motion

SHAKEN = unit_rod(damping=0.2, compliance=0.01, gap=0)
MATCHED = unit_rod(damping=1.0, gap=0)
RIGID = Plan(settle=20, run=8, samples=16, boundary=Boundary(rigid=True))
QUICK = Plan(settle=60, run=8, samples=8)


def released(mean, omega, phase):
    """``z`` of the matched rod on a rigid obstacle at a phase of ``g(t - 1)``: int of W since the release."""
    release = math.pi + math.asin(mean)
    theta = (phase - release) % (2 * math.pi) + release
    fallen = mean * (theta - release) - (math.cos(theta) - math.cos(release))
    return min(fallen, 0.0) / omega


def test_stroboscopic_points_of_the_matched_rod_follow_its_closed_form():
    omegas = np.linspace(0.5, 2.5, 5)
    seen = bifurcation(MATCHED, "0.3 + sin(w*t)", "w", omegas, sweep=Sweep(plan=RIGID))
    assert (seen.complete, seen.order, seen.evidence) == (True, "separate", Evidence.OBSERVED)
    for omega, point in zip(omegas, seen.points, strict=True):
        assert point.value == omega
        assert (point.regime, point.multiple, point.trend, point.impacts) == ("periodic", 1, "over", 1.0)
        assert point.poincare[:, 0] == pytest.approx(released(0.3, omega, -omega), abs=1e-9)
    values, z = seen.scatter()
    assert values.shape == z.shape == (5 * 9,)


@pytest.mark.parametrize("order", ["up", "down"])
def test_a_sweep_carries_the_motion_on_and_a_matched_rod_forgets_it(order):
    omegas = [0.5, 1.0, 2.0]
    seen = bifurcation(MATCHED, "0.3 + sin(w*t)", "w", omegas, sweep=Sweep(plan=RIGID, order=order))
    assert [point.value for point in seen.points] == sorted(omegas, reverse=order == "down")
    for point in seen.points:
        assert point.poincare[:, 0] == pytest.approx(released(0.3, point.value, -point.value), abs=1e-9)


# two steps at the same value are one motion twice as long, and the second begins where the first has ended
@pytest.mark.slow
def test_each_step_begins_where_the_one_before_has_ended():
    force = "0.3 + 0.75*sin(t/2)"
    swept = bifurcation(SHAKEN, force.replace("0.75", "F"), "F", [0.75, 0.75], sweep=Sweep(plan=QUICK, order="up"))
    alone = response(SHAKEN, force, plan=QUICK)
    first, second = (point.poincare for point in swept.points)
    assert first == pytest.approx(alone.poincare, abs=1e-8)
    period = alone.period
    later = response(SHAKEN, force, plan=Plan(settle=2 * 5 * period + 8 * period, run=8, samples=8))
    assert second == pytest.approx(later.poincare, abs=1e-6)
    assert np.abs(second - first).max() > 1e-3


def test_a_field_of_the_rod_is_varied_and_the_rest_stays_exact():
    seen = bifurcation(SHAKEN, "0.3 + 0.05*sin(t/2)", "compliance", [0.1, 0.2], sweep=Sweep(plan=QUICK))
    # never out of contact: the mean of z is 0.3 eps
    means = [point.poincare[:, 0].mean() for point in seen.points]
    assert means[1] - means[0] == pytest.approx(0.03, rel=0.1)
    assert [point.duty for point in seen.points] == [1.0, 1.0]


def interrupted_at(share):
    def progress(_text, done):
        if done >= share:
            raise KeyboardInterrupt

    return progress


def test_an_interrupted_sweep_keeps_what_is_done():
    omegas = np.linspace(1.5, 2.5, 5)
    whole = bifurcation(MATCHED, "0.3 + sin(w*t)", "w", omegas, sweep=Sweep(plan=RIGID))
    part = bifurcation(MATCHED, "0.3 + sin(w*t)", "w", omegas, sweep=Sweep(plan=RIGID, progress=interrupted_at(0.55)))
    assert (part.complete, len(part.points), len(part.values)) == (False, 3, 5)
    assert part.to_dict()["points"] == whole.to_dict()["points"][:3]
    assert "Interrupted: only 3 of 5" in str(part)
    none = bifurcation(MATCHED, "0.3 + sin(w*t)", "w", omegas, sweep=Sweep(plan=RIGID, progress=interrupted_at(0)))
    assert (none.complete, none.points) == (False, ())
    assert none.scatter()[0].size == 0


def test_an_interrupted_motion_through_all_values_keeps_the_steps_that_were_done():
    plan = Plan(settle=60, run=16, samples=8, boundary=Boundary(rigid=True))
    values = [0.9, 1.0, 1.1]
    sweep = Sweep(plan=plan, order="up", progress=interrupted_at(0.75))
    part = bifurcation(MATCHED, "0.3 + F*sin(2*t)", "F", values, sweep=sweep)
    assert (part.complete, [point.value for point in part.points]) == (False, [0.9, 1.0])
    assert part.points[1].impacts == 1.0


@pytest.mark.slow
def test_the_result_is_json_and_the_same_every_time():
    first, second = (
        json.dumps(bifurcation(SHAKEN, "0.3 + F*sin(t/2)", "F", [0.5, 0.9], sweep=Sweep(plan=QUICK)).to_dict())
        for _ in range(2)
    )
    assert first == second
    assert json.loads(first)["points"][0]["poincare"]


@pytest.mark.slow
def test_processes_that_share_the_values_find_the_same():
    alone, shared = (
        bifurcation(SHAKEN, "0.3 + F*sin(t/2)", "F", [0.5, 0.9], sweep=Sweep(plan=QUICK, workers=workers))
        for workers in (1, 2)
    )
    assert shared.to_dict() == alone.to_dict()


def test_a_value_that_cannot_be_followed_is_kept_with_the_reason(monkeypatch):
    module = importlib.import_module("lure.analysis.rod.response.sweeping")  # the package has a function of that name

    def refusing(rod, scenario, watches, progress=None):
        if rod.gap > 0.5:
            raise AssumptionError("chattering")
        return follow(rod, scenario, watches, progress)

    follow = module.follow
    monkeypatch.setattr(module, "follow", refusing)
    seen = bifurcation(MATCHED, "0.3 + sin(t)", "gap", [0.0, 1.0], sweep=Sweep(plan=RIGID))
    assert seen.complete
    assert [point.problem for point in seen.points] == ["", "chattering"]
    assert seen.to_dict()["points"][1]["contact_duty"] is None


@pytest.mark.parametrize(
    ("force", "name", "values", "sweep", "sentence"),
    [
        ("sin(t)", "F", [1], Sweep(), "there is no parameter 'F'"),
        ("F*sin(t)", "t", [1], Sweep(), "there is no parameter 't'"),
        ("gap*sin(t)", "gap", [1], Sweep(), "gap is a field of the rod and a symbol of the force"),
        ("F*sin(t)", "F", [], Sweep(), "there are no values"),
        ("F*sin(t)", "F", [1, math.nan], Sweep(), "a value asked for is nan"),
        ("sin(t)", "area", [1, -1], Sweep(), "rod.area is -1"),
        ("F*sin(t) + G", "F", [1], Sweep(), "G"),
        ("exp(F*t)", "F", [1], Sweep(), "no period"),
        ("0", "damping", [0.5, 1], Sweep(), "the force is 0, which does not change with time"),
        ("F", "F", [0.5, 1], Sweep(), "the force is F, which does not change with time"),
        ("1 + sin(t)", "gap", [0, 1], Sweep(order="up"), "the parameter must be a symbol of the force"),
        ("F*sin(t)", "F", [1], Sweep(order="up", start=Scenario.parse(body_force="sin(t)")), "no body force"),
    ],
)
def test_sweeps_that_cannot_be_made_are_refused_before_anything_is_followed(force, name, values, sweep, sentence):
    rod = unit_rod(damping=0.5)
    with pytest.raises(InputError, match=sentence):
        bifurcation(rod, force, name, values, sweep=sweep)


@pytest.mark.parametrize(
    ("options", "sentence"), [({"order": "sideways"}, "order is 'sideways'"), ({"workers": 0}, "workers is 0")]
)
def test_sweep_options_are_checked(options, sentence):
    with pytest.raises(InputError, match=sentence):
        Sweep(**options)


# From a uniform velocity v0, momentum gives k (u(inf) - u(0)) = M v0 - J with the impulse J of all contacts.
@pytest.mark.parametrize("damping", [0.3, 0.6, 1.6])
@pytest.mark.parametrize("velocity", [0.1, 0.8, 3.0])
def test_momentum_decides_where_the_rod_comes_to_rest(damping, velocity):
    rod = other_rod(damping=damping, gap=0.4)
    seen = resting_place(rod, Scenario.parse(velocity=velocity))
    motion = exact_motion(rod, Scenario.parse(velocity=velocity), seen.time + 20)
    impulse = sum(impact.impulse for impact in motion.impacts)
    mass = rod.area * rod.density * rod.length
    assert seen.settled
    assert seen.impacts == len(motion.impacts)
    assert seen.low == seen.high == pytest.approx(-0.4 + (mass * velocity - impulse) / damping, abs=1e-12)
    assert seen.high <= 0


@pytest.mark.parametrize("rigid", [False, True])
def test_the_last_touch_is_sharp_from_both_sides(rigid):
    rod = unit_rod(damping=0.5, gap=1, compliance=0.01)
    # free, it moves by M v0/k = 2 v0
    short = resting_place(rod, Scenario.parse(velocity=0.5 - 1e-9), rigid=rigid)
    assert (short.settled, short.impacts) == (True, 0)
    assert short.high == pytest.approx(-2e-9, rel=1e-5)
    touching = resting_place(rod, Scenario.parse(velocity=0.5 + 1e-4), rigid=rigid)
    assert touching.settled
    assert touching.impacts > 0
    assert -1e-3 < touching.high <= 0


# k > Z: an echo changes its sign, so that one round trip without contact is not enough, though zeta <= 0
@pytest.mark.parametrize(
    ("rod", "displacement", "velocity", "impacts", "rest"),
    [
        (
            unit_rod(damping=4, compliance=0.2, gap=0.21),
            "0.11*cos(2*pi*x)",
            "0.27*sin(2*pi*x) + 0.27",
            2,
            -0.0783203555,
        ),
        (unit_rod(damping=8, compliance=0.2, gap=0.06), "0.44*cos(pi*x)", "-0.12*sin(pi*x) - 0.12", 11, -0.00995993562),
        (
            unit_rod(damping=4, compliance=0.02, gap=0.03),
            "0.15*cos(2*pi*x)",
            "0.29*sin(2*pi*x) + 0.29",
            9,
            -0.0172708827,
        ),
    ],
)
def test_contact_that_comes_back_after_a_quiet_round_trip_is_waited_for(rod, displacement, velocity, impacts, rest):
    start = Scenario.parse(displacement=displacement, velocity=velocity)
    seen = resting_place(rod, start)
    motion = exact_motion(rod, start, 60)
    assert seen.settled
    assert seen.impacts == len(motion.impacts) == impacts
    # far past its last contact the end lies where it was said to come to rest
    assert seen.high == pytest.approx(rest, rel=1e-8)
    assert float(motion.z(60.0)) == pytest.approx(seen.high, abs=0.2 * abs(rod.reflection) ** 20)


# thrown at a stiff stop with v, it comes back with nearly -v: zeta = -M v/k, and the bound is T v (k + Z)/k
def test_the_bound_is_nearly_reached_by_a_rod_that_bounces_back():
    rod = unit_rod(damping=0.002, compliance=1e-3, gap=2.5)
    start = Scenario.parse(velocity=0.5)
    brief, final = resting_place(rod, start, until=4), resting_place(rod, start)
    assert (brief.settled, final.settled, final.impacts) == (False, True, 1)
    assert brief.low <= final.low <= 0.97 * brief.low


def within_units(number):
    """Not so small that a rod refuses it: 0, or at least 1e-9."""
    return number == 0 or abs(number) >= 1e-9


@settings(max_examples=12)
@given(
    damping=st.sampled_from([0.6, 0.9, 1.0, 3.0]),
    velocity=st.floats(-1, 2).filter(within_units),
    until=st.floats(2, 20),
    gap=st.floats(-0.2, 0.5).filter(within_units),
)
def test_bounds_of_a_short_look_hold_what_a_long_one_finds(damping, velocity, until, gap):
    rod = unit_rod(damping=damping, compliance=0.05, gap=gap)
    start = Scenario.parse(velocity=velocity)
    brief, final = resting_place(rod, start, until=until), resting_place(rod, start)
    slack = 1e-12
    assert brief.low - slack <= final.low <= final.high <= brief.high + slack
    assert final.high <= slack
    if brief.settled or (brief.known and final.time == brief.time):
        assert (brief.impacts, brief.time) == (final.impacts, final.time)


def test_what_creeps_off_the_obstacle_for_ever_is_inconclusive():
    # k >> Z: pressed in, it creeps out and never leaves: z > 0 falls to 0 like exp(-A t/(eps k))
    rod = unit_rod(damping=5.0, compliance=4.0, gap=-0.1)
    seen = resting_place(rod, Scenario(), until=100)
    assert (seen.settled, seen.known, seen.impacts) == (False, False, 0)
    assert -0.05 < seen.low < seen.high <= 0
    assert "INCONCLUSIVE" in str(seen)
    grid = basin(rod, [0.0], [0.0])
    assert (grid.settled.tolist(), grid.known.tolist()) == ([[False]], [[True]])
    assert grid.high[0, 0] == 0.0
    assert 0 > grid.low[0, 0] > -1e-9
    assert "1 of 1 resting places are known, 0 of them with no contact to come" in str(grid)


def test_a_grid_is_its_motions_one_by_one():
    rod = unit_rod(damping=0.4, compliance=0.02, gap=0.3)
    start = Scenario.parse(displacement="0.01*x", velocity="x")
    grid = basin(rod, [-0.2, 0.1], [0.0, 0.5, -1.0], start=start)
    assert grid.high.shape == (3, 2)
    for i, j in np.ndindex(3, 2):
        u0, u1 = f"0.01*x + {[-0.2, 0.1][j]}", f"x + {[0.0, 0.5, -1.0][i]}"
        alone = resting_place(rod, Scenario.parse(displacement=u0, velocity=u1))
        assert (grid.high[i, j], grid.impacts[i, j]) == (pytest.approx(alone.high, abs=1e-13), alone.impacts)
    assert grid.evidence is Evidence.COMPUTED
    assert json.loads(json.dumps(grid.to_dict()))["complete"]


def test_an_interrupted_grid_keeps_what_is_done():
    part = basin(unit_rod(damping=0.5), [0.0, 0.1], [0.0, 0.5], progress=interrupted_at(0.5))
    assert not part.complete
    assert part.impacts.tolist()[1] == [-1, -1]
    assert np.isnan(part.high[1]).all()
    assert np.isfinite(part.high[0]).all()
    assert "Interrupted: 2 of 4" in str(part)
    assert part.to_dict()["rest_high_m"][1] == [None, None]


@pytest.mark.parametrize(
    ("change", "scenario", "sentence"),
    [
        ({"damping": 0}, Scenario(), "comes to rest for k > 0 only"),
        ({"damping": -0.5}, Scenario(), "comes to rest for k > 0 only"),
        ({"damping": 1}, Scenario.parse(force=1), "under a load does not come to rest"),
    ],
)
def test_rods_that_do_not_come_to_rest_are_refused(change, scenario, sentence):
    with pytest.raises(AssumptionError, match=sentence):
        basin(unit_rod(**change), [0.0], [0.0], start=scenario)
    with pytest.raises(InputError, match="no offsets or no velocities"):
        basin(unit_rod(**change), [], [0.0], start=scenario)
