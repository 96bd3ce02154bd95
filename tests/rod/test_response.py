"""Long runs of the rod against closed forms: the free rod, the matched rod bouncing on a rigid obstacle, rest."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from motions import NODES, WEIGHTS, unit_rod
from scipy.optimize import brentq

from lure.analysis.rod.response import Plan, response
from lure.analysis.verdict import Evidence
from lure.errors import AssumptionError, InputError
from lure.rod import Scenario
from lure.rod.motion import Boundary, exact_motion

FAR = 1e3
# mean 0.3 N presses the bar against a stiff stop; its period doubles between F = 0.65 N and 0.7 N
SHAKEN = unit_rod(damping=0.2, compliance=0.01, gap=0)


# Without contact W = 2 b e^{-sT}/(1 + a e^{-2sT}) g and z = W/s; here T = 1, so that with g = sin(w t) the amplitude is
# |2 b / (1 + a e^{-2iw})|/w and the phase that of e^{-iw}/((1 + a e^{-2iw}) iw) less pi/2 (a cosine is asked for).
@pytest.mark.parametrize("damping", [0.3, 1.0, 2.5])
@pytest.mark.parametrize("omega", [0.4, 1.3, 4.0])
def test_the_free_rod_answers_a_sine_as_its_transfer_function_says(damping, omega):
    rod = unit_rod(damping=damping, gap=FAR)
    seen = response(rod, f"sin({omega}*t)", plan=Plan(settle=120, run=12))
    a, b = rod.reflection, rod.input_gain
    transfer = 2 * b * np.exp(-1j * omega) / ((1 + a * np.exp(-2j * omega)) * 1j * omega)
    assert (seen.regime.kind, seen.regime.multiple, seen.transients.trend) == ("periodic", 1, "over")
    assert seen.harmonics[1] == pytest.approx(abs(transfer), rel=1e-9)
    i = seen.spectrum.periods
    turn = seen.spectrum.phase[i] - (np.angle(transfer) - np.pi / 2)
    assert math.remainder(turn, 2 * np.pi) == pytest.approx(0, abs=1e-6)
    others = np.delete(seen.spectrum.amplitude, [0, i])
    assert others.max() < 1e-9 * FAR
    assert (seen.duty, seen.impulses.count, seen.contacts) == (0.0, 0, ())
    assert seen.balance.contact == 0.0


# A mean force F0 drags the free rod along at F0/k: z moves by F0 P/k a period.
def test_a_rod_that_is_pulled_away_drifts_by_the_mean_force_over_the_damping():
    rod = unit_rod(damping=0.5, gap=1)
    seen = response(rod, "-0.25 + sin(2*t)", plan=Plan(settle=60, run=12))
    assert (seen.regime.kind, seen.regime.multiple) == ("drifting", 1)
    assert seen.regime.step == pytest.approx(-0.25 * math.pi / 0.5, rel=1e-9)
    # the dashpot takes up the whole force: k times F0/k
    assert seen.balance.dashpot == pytest.approx(-0.25 * math.pi, rel=1e-9)
    assert abs(seen.balance.left) < 1e-9


def bounce(mean, omega):
    """k = Z, T = Z = 1, rigid obstacle, g = mean + sin(omega t): release and contact, as phases of g(t - T).

    W = g(t - T)/Z, for nothing comes back: z' = W while the end is free, and it is held while W > 0.  So it leaves when
    W turns negative, at theta_1, and returns when int W from there is zero, at theta_2.
    """
    release = math.pi + math.asin(mean)

    def travel(theta):
        return mean * (theta - release) - (np.cos(theta) - math.cos(release))

    return release, brentq(travel, 2 * math.pi - math.asin(mean), release + 2 * math.pi, xtol=1e-14), travel


@pytest.mark.slow_for("0.8-0.2")
@pytest.mark.parametrize(("mean", "omega"), [(0.3, 0.7), (0.05, 2.0), (0.8, 0.2)])
def test_a_matched_rod_bounces_on_a_rigid_obstacle_as_the_closed_form_says(mean, omega):
    rod = unit_rod(damping=1.0, gap=0)
    plan = Plan(run=8, samples=128, boundary=Boundary(rigid=True))
    seen = response(rod, f"{mean} + sin({omega}*t)", plan=plan)
    release, contact, travel = bounce(mean, omega)
    assert seen.settling.periods == 10  # nothing to wait for
    assert (seen.regime.kind, seen.regime.multiple, seen.regime.seen) == ("periodic", 1, 8)
    assert seen.duty == pytest.approx(1 - (contact - release) / (2 * math.pi), rel=1e-11)
    assert seen.impulses.per_period == 1.0
    # all of the push of a period goes through the one contact of it
    assert seen.impulses.mean == pytest.approx(mean * 2 * math.pi / omega, rel=1e-11)
    assert seen.impulses.deviation < 1e-11
    touching = contact < 2.5 * math.pi  # the crest of the force falls into the contact
    crest = 1 + mean if touching else mean + math.sin(contact)
    assert seen.impulses.peak_stress == pytest.approx(crest, rel=1e-10)
    theta = np.mod(omega * (seen.t - 1) - release, 2 * math.pi) + release
    exact = np.where(theta < contact, travel(theta) / omega, 0.0)
    assert seen.z == pytest.approx(exact, abs=1e-10)
    start, end = seen.contacts[3]
    assert omega * (end - start) == pytest.approx(2 * math.pi - (contact - release), rel=1e-10)


def test_a_constant_push_ends_at_rest_where_the_obstacle_holds_it():
    rod = unit_rod(damping=0.8, compliance=0.5, gap=0.1)
    seen = response(rod, 0.4)
    assert (seen.regime.kind, seen.period_source, seen.transients.trend) == ("rest", "constant load", "over")
    assert seen.z == pytest.approx(0.4 * 0.5 + 0 * seen.z, rel=1e-6)  # A z/eps = F
    assert seen.duty == 1.0
    assert seen.impulses.count == 0  # none begins: the one contact goes on
    assert seen.balance.contact == pytest.approx(0.4 * seen.period, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("amplitude", "multiple"),
    [pytest.param(0.5, 1, marks=pytest.mark.thorough), (0.75, 2), pytest.param(0.97, 3, marks=pytest.mark.slow)],
)
def test_the_period_of_the_shaken_bar_doubles_and_trebles(amplitude, multiple):
    seen = response(SHAKEN, f"0.3 + {amplitude}*sin(t/2)", plan=Plan(settle=500, run=14, samples=16))
    assert (seen.regime.kind, seen.regime.multiple) == ("periodic", multiple)
    assert seen.period == pytest.approx(4 * math.pi, rel=1e-15)
    points = seen.poincare
    assert points[multiple:] == pytest.approx(points[:-multiple], abs=1e-4)
    spread = np.abs(points[1 : multiple + 1] - points[:multiple]).max()
    assert spread > 0.5 if multiple > 1 else spread < 1e-4
    # momentum: the obstacle gives back what the force brings, 0.3 N all the time
    assert seen.balance.force == pytest.approx(0.3 * 4 * math.pi, rel=1e-12)
    assert seen.balance.contact == pytest.approx(seen.balance.force, rel=1e-6)
    assert seen.impulses.count == seen.impulses.per_period * 14
    assert seen.impulses.peak_stress < 10
    assert seen.evidence is Evidence.OBSERVED


@pytest.mark.slow
def test_irregular_motion_is_not_called_chaotic_and_still_balances():
    plan = Plan(settle=30, run=24, samples=16)
    seen = response(SHAKEN, "0.3 + 0.88*sin(t/2)", plan=plan)
    assert (seen.regime.kind, seen.regime.multiple, seen.spectrum.window) == ("not seen to repeat", None, "hann")
    assert seen.regime.mismatch > 0.05
    assert "does not prove" in str(seen)
    # over the watch: force = contact + dashpot + change of momentum, |change| <= sqrt(2 M E) a run
    assert abs(seen.balance.left) * 24 < 10
    gained = 24 * seen.balance.left
    shorter = response(SHAKEN, "0.3 + 0.88*sin(t/2)", plan=replace(plan, run=12))
    assert abs(gained - 12 * shorter.balance.left) < 10
    assert seen.z[: shorter.z.size] == pytest.approx(shorter.z, abs=1e-9)


# force = contact + dashpot + gain, and the gain is the momentum that is in the rod at the end less that at the start
@pytest.mark.slow
def test_what_is_left_of_the_momentum_is_in_the_rod():
    seen = response(SHAKEN, "0.3 + 0.9*sin(t/2)", plan=Plan(settle=12, run=8, samples=8))
    assert seen.regime.multiple is None
    motion = exact_motion(SHAKEN, Scenario.parse(force="0.3 + 0.9*sin(t/2)"), float(seen.t[-1]) * (1 + 1e-12))

    def momentum(t):
        edges = motion.fields.breaks(t)
        half = np.diff(edges)[:, None] / 2
        return float((half * WEIGHTS * motion.velocity(t, edges[:-1, None] + half * (NODES + 1))).sum())

    gained = momentum(float(seen.t[-1])) - momentum(float(seen.t[0]))
    assert abs(gained) > 0.1
    assert 8 * seen.balance.left == pytest.approx(gained, abs=1e-9)
    assert response(SHAKEN, "0.3 + sin(t/2)", plan=Plan(settle=0, run=8)).balance is None


# E -> s^2 E, k -> s k, eps -> eps/s^2, g(t) -> s^2 g(s t) is the same motion, s times as fast
@pytest.mark.slow
def test_the_unit_of_time_does_not_matter():
    slow = response(SHAKEN, "0.3 + 0.75*sin(t/2)", plan=Plan(settle=60, run=8))
    rod = unit_rod(youngs_modulus=16, damping=0.8, compliance=0.01 / 16, gap=0)
    fast = response(rod, "4.8 + 12*sin(2*t)", plan=Plan(settle=15, run=8))
    assert fast.period == slow.period / 4
    assert fast.z == pytest.approx(slow.z, abs=1e-8)
    assert fast.v == pytest.approx(4 * slow.v, abs=1e-5)
    assert fast.duty == pytest.approx(slow.duty, rel=1e-9)
    assert fast.impulses.mean == pytest.approx(4 * slow.impulses.mean, rel=1e-9)
    assert fast.settling.wave_time == pytest.approx(slow.settling.wave_time / 4, rel=1e-12)
    assert fast.settling.contact_time == pytest.approx(slow.settling.contact_time / 4, rel=1e-12)


@pytest.mark.slow
def test_the_same_question_has_the_same_answer():
    first, second = (response(SHAKEN, "0.3 + 0.9*sin(t/2)", plan=Plan(settle=50, run=8)).to_dict() for _ in range(2))
    assert first == second


@pytest.mark.slow
def test_memory_does_not_depend_on_the_time_waited():
    soon, late = (response(SHAKEN, "0.3 + sin(t/2)", plan=Plan(settle=s, run=8)) for s in (20, 100))
    assert soon.t.size == late.t.size == 8 * 64 + 1
    assert soon.impulses.count < 20


# Pressed for good, the rod is linear: s + (d/eps)(1 - a e^{-2s})/(1 + a e^{-2s}) = 0; a real root for a = 1/3, eps = 4
@pytest.mark.slow
def test_two_motions_on_a_linear_obstacle_come_together_at_the_rate_of_the_slowest_root():
    rod = unit_rod(damping=2.0, compliance=4.0, gap=0)
    a = rod.reflection
    root = brentq(lambda s: s + 0.25 * (1 - a * math.exp(-2 * s)) / (1 + a * math.exp(-2 * s)), -0.3, -0.01)
    seen = response(rod, "1 + 0.1*sin(4*t)", plan=Plan(settle=60, run=32, separation=True))
    assert seen.duty == 1.0
    late = np.log(seen.separation.distance[20:31])
    assert (late[-1] - late[0]) / (10 * seen.period) == pytest.approx(root, rel=3e-3)
    assert seen.separation.rate == pytest.approx(root, rel=0.03)  # the faster modes of its first periods are in it
    assert "shrank" in str(seen.separation)


@pytest.mark.slow
def test_nearby_motions_part_where_none_was_seen_to_repeat_and_meet_where_one_was():
    plan = Plan(settle=40, run=16, samples=16, separation=True)
    assert response(SHAKEN, "0.3 + 0.5*sin(t/2)", plan=plan).separation.rate < -0.01
    assert response(SHAKEN, "0.3 + 0.88*sin(t/2)", plan=plan).separation.rate > 0.01


@pytest.mark.slow
def test_a_motion_on_its_way_to_its_regime_says_so():
    seen = response(SHAKEN, "0.3 + 0.7*sin(t/2)", plan=Plan(settle=200, run=16))
    assert (seen.regime.kind, seen.transients.trend) == ("not seen to repeat", "still approaching")
    # a matched rod is in its regime after the first period
    plan = Plan(settle=0, run=12, boundary=Boundary(rigid=True))
    soon = response(unit_rod(damping=1.0, gap=0.5), "0.3 + sin(t)", plan=plan)
    assert (soon.regime.multiple, soon.regime.seen, soon.transients.trend) == (1, 11, "died out")
    assert "died out" in str(soon)


# k/M = 1 1/s, and the slower root of M s^2 + k s + A/eps: (1 - sqrt(1/2))/2 of k/M for the paper's numbers
def test_the_time_to_wait_follows_from_the_slowest_time_constant_of_the_paper_rod():
    from lure.analysis.rod.response.recording import settling
    from lure.rod.systems import paper_rod

    found = settling(paper_rod(), Plan(), 1.0)
    assert found.wave_time == pytest.approx(1.0, rel=1e-6)
    assert found.contact_time == pytest.approx(2 / (1 - math.sqrt(0.5)), rel=1e-9)
    # 12 times 6.83 s are 81.9 s, more than 200 000 round trips of 1/3000 s
    assert found.time == 67.0
    assert "200000 round trips" in found.note
    stiff = unit_rod(damping=0.2, compliance=0.01)
    assert settling(stiff, Plan(), 1.0).time == 120.0  # 12 times 2 M/k
    assert settling(stiff, Plan(settle=3.2), 1.0).periods == 4
    assert settling(stiff, Plan(settle=3.0), 1.0).periods == 3


@given(damping=st.floats(0.01, 50), end=st.sampled_from([0.0, 0.3, 2.0]))
def test_the_rate_of_the_waves_is_that_of_the_echoes(damping, end):
    from lure.analysis.rod.response.recording import wave_rate

    rod = unit_rod(damping=damping)
    echo = abs(rod.reflection * (1 - end) / (1 + end))
    rate = wave_rate(rod, Boundary(end_damping=end))
    assert math.exp(-2 * rate) == pytest.approx(echo, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize(
    ("change", "plan", "sentence"),
    [
        ({"damping": 0}, Plan(), "never forgets its start; give the time to wait, settle"),
        ({"damping": -0.1}, Plan(), "motions grow; give the time to wait, settle,"),
    ],
)
def test_a_rod_that_forgets_nothing_needs_a_time(change, plan, sentence):
    with pytest.raises(AssumptionError, match=sentence):
        response(unit_rod(**change), "sin(t)", plan=plan)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"settle": -1}, "settle is -1"),
        ({"settle": math.inf}, "settle is inf"),
        ({"run": 7}, "run, the periods watched, is 7; give a whole number from 8"),
        ({"run": True}, "run, the periods watched, is True"),
        ({"samples": 4}, "samples is 4"),
        ({"run": 10_000, "samples": 10_000}, "give at most 20000000"),
        ({"tolerance": 0.0}, "tolerance is 0.0"),
    ],
)
def test_plans_that_cannot_be_followed_are_refused(options, sentence):
    with pytest.raises(InputError, match=sentence):
        Plan(**options)


def test_a_separation_needs_a_force_to_push_with():
    plan = Plan(settle=20, run=8, separation=True)
    with pytest.raises(InputError, match=r"force\.g is zero"):
        response(unit_rod(damping=0.5), Scenario.parse(velocity=1), plan=plan)


def test_a_body_force_and_initial_data_come_with_a_scenario():
    # always pressed: the momentum that f = 0.3 + 0.1 sin(t/2) N/m brings to 1 m passes through the obstacle
    scenario = Scenario.parse(body_force="0.3 + 0.1*sin(t/2)", velocity=0.1)
    rod = unit_rod(damping=0.8, compliance=0.05, gap=0)
    seen = response(rod, scenario, plan=Plan(settle=60, run=8, tolerance=1e-4))
    assert seen.balance is None
    assert (seen.regime.kind, seen.period_source, seen.duty) == ("periodic", "formula", 1.0)
    assert seen.spectrum.amplitude[0] == pytest.approx(0.3 * 0.05, rel=1e-3)
