"""Gains from below by disturbances that both checkers follow: in continuous time through ReLUs, step by step."""

import json
import math
from dataclasses import replace
from fractions import Fraction as F
from functools import cache
from itertools import pairwise
from types import SimpleNamespace

import depth
import numpy as np
import pytest
from certificate_format import FORMAT
from flint import arb_mat, fmpq, fmpq_mat
from scipy.linalg import expm
from tampering import assert_both_reject, edited

from lure import NonlinearityClass, Sector, as_plant
from lure.analysis.certificates.channels import Plant
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.second import signals as second_signals
from lure.analysis.certificates.second.numerics import working_precision
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.certificates.signals import Flow
from lure.analysis.counterexamples import gain_signals
from lure.analysis.counterexamples.gain_signals import Loop, signals
from lure.analysis.questions import channel_members
from lure.analysis.questions.channel_members import members_refuting
from lure.analysis.questions.gain import gain_problem

RELU = NonlinearityClass.relu()
OSCILLATOR = ([[0, 1], [-1, F(-1, 2)]], [[0], [1]], [[1, 0]], 0)
PUSHED = {"Bw": [[0], [1]], "Cz": [[1, 0]]}


def shown_below(plant, classes, performance, **options):
    """What a disturbance shows of a gain: the bound, and the certificate as it is read from a file."""
    asked, *_ = gain_problem(plant, classes, performance)
    asked = replace(asked, **options)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(gain_signals, "_STEPS", (64, 64))  # 8 s; by default 50 s
        patch.setattr(channel_members, "_LONG", 240)
        alpha, shown = members_refuting(asked, most=math.inf)
    unit = F(asked.classes.classes[-1].sector.upper)
    return float(1 / (unit * alpha)), json.loads(json.dumps(dict(shown.certificate)))


@cache
def oscillator():
    """x'' + x'/2 + x + max(x, 0) = w."""
    return shown_below(OSCILLATOR, [RELU], PUSHED)


# The linear oscillator with stiffness 1, which the ReLU only adds to, has the gain 1/(c sqrt(1 - c^2/4)) = 2.0656, c =
# 1/2; over the 8 s that are looked at less comes through.
@pytest.mark.slow
def test_a_disturbance_in_continuous_time_is_accepted_twice():
    low, certificate = oscillator()
    assert 1.3 < low < 2.0656
    assert {tuple(at) for at in certificate["proof"]["sides"]} == {(0,), (1,)}
    assert type(check(json.dumps(certificate))).__name__ == "Refuted"
    assert recheck(json.dumps(certificate)).accepted
    FORMAT.validate(certificate)


# An independent simulation of the signal, each step cut into four of Runge and Kutta's method, has the energy claimed.
@pytest.mark.slow
def test_the_disturbance_gets_through_what_is_claimed():
    low, certificate = oscillator()
    proof, x, through, entered = certificate["proof"], np.zeros(2), 0.0, 0.0

    def rate(x, w):
        return np.array([x[1], -x[0] - max(x[0], 0) - x[1] / 2 + w])

    for row, time in zip(proof["inputs"], proof["times"], strict=True):
        w, h = float(F(row[0])), float(F(time)) / 4
        entered += 4 * h * w * w
        for _ in range(4):
            k = [rate(x, w)]
            for c in (h / 2, h / 2, h):
                k.append(rate(x + c * k[-1], w))
            after = x + h / 6 * (k[0] + 2 * k[1] + 2 * k[2] + k[3])
            through += h / 6 * (x[0] ** 2 + after[0] ** 2 + (x[0] + after[0] + h / 4 * (x[1] - after[1])) ** 2)
            x = after
    assert math.sqrt(through / entered) == pytest.approx(low, rel=1e-4)


@pytest.mark.slow
def test_what_is_altered_is_refused_by_both():
    low, good = oscillator()
    steps, middle, sides = len(good["proof"]["inputs"]), len(good["proof"]["inputs"]) // 2, good["proof"]["sides"]
    change = next(k for k, (at, after) in enumerate(pairwise(sides)) if at != after)
    other = edited(good, "laws", "channels", 0, value=lambda one: {k: v for k, v in one.items() if k != "relu"})
    gamma = edited(
        good, "laws", "channels", 1, "sector", value=lambda ends: [str(F(v) * (1 - F(1, 10**6))) for v in ends]
    )
    for bad in (
        edited(good, "proof", "sides", middle, value=lambda at: [1 - at[0]]),
        edited(good, "proof", "sides", middle, value=[]),
        edited(good, "proof", "sides", middle, value=[2]),
        edited(good, "proof", "slopes", 0, value=["0", "1/2"]),
        edited(good, "proof", "slopes", 0, value=["1", "0"]),
        edited(good, "proof", "slopes", 0, value=[["0", "1"], ["0", "0"]] * (steps // 2) + [["0", "1"]] * (steps % 2)),
        edited(good, "proof", "inputs", value=lambda rows: [["0"] for _ in rows]),
        edited(good, "proof", "inputs", value=lambda rows: rows[:-1]),
        edited(good, "proof", "times", change, value=lambda t: str(F(t) + F(1, 10**6))),  # not at 0 then
        edited(good, "proof", "times", middle, value="0"),
        edited(good, "proof", "bits", value=64),
        edited(good, "proof", "scale", value="0"),
        edited(good, "system", "A", 1, 1, value="-3/5"),  # more damping
        edited(other, "laws", "channels", 0, "odd", value=True),
        gamma,  # a gain larger by 1e-6 than what comes through
    ):
        assert_both_reject(bad)
    assert low > 0


# x' = -x - max(x, 0) + w behind a lag: the ReLU sees the disturbance late, and another sees that one at once.
@pytest.mark.slow
def test_functions_in_layers_are_followed_too():
    plant = ([[-1, 0], [0, -1]], [[0, 1], [0, 0]], [[0, 1], [0, 0]], [[0, 0], [-2, 0]])
    performance = {"Bw": [[0], [1]], "Cz": [[1, 0]], "Dzmu": [[0, 0]]}
    # sigma_1 = x2, sigma_2 = 2 max(x2, 0), x1' = -x1 - sigma_2: the gain of 2/(s + 1)^2 for w > 0 is 2
    low, certificate = shown_below(plant, [RELU, RELU], performance)
    assert 1.6 < low < 2
    assert recheck(json.dumps(certificate)).accepted
    whole = as_plant(tuple(np.array(side, dtype=float).tolist() for side in discretised(plant, F(1, 2))), dt=1)
    low, certificate = shown_below(whole, [RELU, RELU], performance | {"Bw": [[0], [1]]})
    assert check(json.dumps(certificate))
    assert recheck(json.dumps(certificate)).accepted
    assert low > 0


def discretised(plant, h):
    A, B, C, D = (np.array(side, dtype=float) for side in plant)
    E = expm(A * float(h))
    return E, np.linalg.solve(A, E - np.eye(len(A))) @ B, C, D


# Power iteration is its own test: of a linear loop, slopes equal, it finds the gain over a long time.
def test_power_iteration_finds_the_gain_of_a_linear_loop():
    A, B, C = np.array([[0.5]]), np.array([[0.0, 1.0]]), np.array([[0.0], [1.0]])
    loop = Loop((A, B, C, np.zeros((2, 2))), [1])  # x+ = x/2 + w, z = x: 1/(1 - 1/2)
    assert signals(loop, np.array([[0.0, 0.0]]), 60)[0] == pytest.approx(2, rel=5e-3)


# Sides as they are in the middle of a step, no step ending where they change, some of them wrong: whatever is said of
# sides, neither checker may find more energy than there is.  Steps are short, so that errors do not hide a mistake.
@pytest.mark.parametrize("seed", range(depth.sampled(6, of=200)))
def test_no_side_makes_a_checker_find_more_than_comes_through(monkeypatch, seed):
    monkeypatch.setattr(second_signals, "LOST", 1e9)  # where it would give up
    rng = np.random.default_rng(seed)
    n, steps, h = 2, 12, F(1, 2 ** int(rng.integers(7, 10)))
    A, B, C = (np.round(rng.normal(size=size), 1) for size in ((n, n), (n, 3), (3, n)))
    D = np.round(np.tril(rng.normal(size=(3, 3)), -1), 1)
    lines = {i: [tuple(sorted(F(int(v), 4) for v in rng.integers(-2, 6, 2)))] * steps for i in range(2)}
    w = np.round(rng.normal(size=steps), 2)
    sides, through, x = [], 0.0, np.zeros(n)

    def outputs(x, v):
        mu, sigma = np.array([0.0, 0.0, v]), np.zeros(3)
        for i in (0, 1, 2):
            sigma[i] = C[i] @ x + D[i] @ mu
            if i < 2:
                mu[i] = -float(lines[i][0][int(sigma[i] > 0)]) * sigma[i]
        return mu, sigma

    fine = 64
    for v in w:
        for k in range(fine):
            mu, sigma = outputs(x, v)
            if k == fine // 2:
                sides.append([int(s > 0) ^ int(rng.random() < 0.05 * (seed % 2)) for s in sigma[:2]])
            half = x + float(h) / fine / 2 * (A @ x + B @ mu)
            mu, sigma = outputs(half, v)
            through += float(h) / fine * sigma[2] ** 2
            x = x + float(h) / fine * (A @ half + B @ mu)
    rows = [[[F(str(v)) for v in row] for row in side] for side in (A, B, C, D)]
    inputs, gamma = [[F(str(v))] for v in w], F(1)
    asked = SimpleNamespace(performance=range(2, 3))
    found, _ = Flow(Plant(*rows, discrete=False), asked, lines, F(4), 256).through(sides, inputs, [h] * steps)
    assert found <= through * (1 + 1e-3) + 1e-12
    exact = [fmpq_mat([[fmpq(v.numerator, v.denominator) for v in row] for row in side]) for side in rows]
    own = SimpleNamespace(**dict(zip("ABCD", exact, strict=True)), performance=[2], bounds=[None, None, (0, gamma)])
    with working_precision(256):
        again = float(second_signals._Steps(own, lines).balance(inputs, [h] * steps, sides).upper())
    assert again + float(h) * (w**2).sum() <= through * (1 + 1e-3) + 1e-12


# x' = -x - phi_2(phi_1(x)) + w, z = x: where phi_1 is said to be 0 although x > 0, x' = -x + w is followed, from which
# more would come through; what is off at phi_1 is passed on to phi_2
def test_what_is_off_in_one_function_is_passed_on_to_the_next(monkeypatch):
    monkeypatch.setattr(second_signals, "LOST", 1e9)  # where it would give up
    A, B, C, D = [[-1]], [[0, 1, 1]], [[1], [0], [1]], [[0, 0, 0], [-1, 0, 0], [0, 0, 0]]
    rows = [[[F(v) for v in row] for row in side] for side in (A, B, C, D)]
    lines, times, inputs = {i: [(F(0), F(1))] * 8 for i in range(2)}, [F(1, 64)] * 8, [[F(1)]] * 8
    flow = Flow(Plant(*rows, discrete=False), SimpleNamespace(performance=range(2, 3)), lines, F(4), 256)
    right, _ = flow.through([[1, 1]] * 8, inputs, times)
    assert right > 0
    assert flow.through([[0, 1]] * 8, inputs, times)[0] < right
    exact = [fmpq_mat([[fmpq(v.numerator, v.denominator) for v in row] for row in side]) for side in rows]
    own = SimpleNamespace(**dict(zip("ABCD", exact, strict=True)), performance=[2], bounds=[None, None, (0, F(1))])
    with working_precision(256):
        steps = second_signals._Steps(own, lines)
        ends = [float(steps.balance(inputs, times, [side] * 8).upper()) for side in ([0, 1], [1, 1])]
    assert ends[0] < ends[1]


# (q - 1/2)(q - 1) is below 0 in the second half of [0, 1] alone, by 1/16
def test_what_is_below_zero_in_the_second_half_of_a_step_is_seen():
    with working_precision(128):
        row, step = arb_mat([[0.5, -1.5, 2]]), arb_mat([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
        X = arb_mat([[1], [0], [0]])
        assert 0.0625 <= float(second_signals._wrong(row, step, X, step.exp() * X)) < 0.07


# In samples phi of a sector may have any value where sigma comes once: more comes through than with a constant gain
# (2.7675, of phi = -sigma/4), and no more than the circle criterion says, 2.8261.
TURNING = as_plant(([[F(1, 2), F(1, 2)], [F(-1, 2), F(1, 2)]], [[F(1, 2)], [0]], [[1, 1]], [[0]]), dt=1)
TURNED = {"Bw": [[1], [0]], "Cz": [[1, 0]]}


@pytest.mark.slow
def test_gains_that_jump_get_more_through_a_sector_in_samples():
    sector = NonlinearityClass(sector=Sector(F(-1, 4), F(1, 4)))
    low, good = shown_below(TURNING, [sector], TURNED, worst=True)
    assert 2.769 < low < 2.8262
    check(json.dumps(good))
    assert recheck(json.dumps(good)).accepted
    FORMAT.validate(good)
    for change in ({"slope": ["-1/4", "1/4"]}, {"linear": True}, {"sector": ["-1/8", "1/4"]}):
        assert_both_reject(edited(good, "laws", "channels", 0, value=lambda one, change=change: one | change))
    assert_both_reject(edited(good, "proof", "slopes", 0, value=lambda rows: rows[:-1]))
    # sigma = w one sample before: 1 again and again, where phi has one value, or 1 and -1 of an odd one
    once = {"kind": "multivariable", "time": "discrete", "A": [["0"]], "B": [["0", "1"]], "C": [["1"], ["1"]]}
    other = edited(good, "system", value=once | {"D": [["0", "0"], ["1", "0"]]})
    other["proof"] |= {"inputs": [["1"]] * 3, "slopes": [[["1/4", "1/4"]] * 3]}
    other["laws"]["channels"][1]["sector"] = ["-100", "100"]
    check(json.dumps(other), draft=True)
    jumping = [["1/4", "1/4"]] * 2 + [["-1/4", "-1/4"]]
    assert_both_reject(edited(other, "proof", "slopes", 0, value=jumping))
    turned = edited(edited(other, "proof", "slopes", 0, value=jumping), "proof", "inputs", value=[["1"], ["-1"], ["1"]])
    check(json.dumps(turned), draft=True)
    assert_both_reject(edited(turned, "laws", "channels", 0, "odd", value=True))


@pytest.mark.slow
def test_gains_that_jump_in_continuous_time_are_of_classes_that_depend_on_time():
    varying = NonlinearityClass(sector=Sector(0, 3), time_varying=True)
    low, good = shown_below(([[0, 1], [-1, -1]], [[0], [1]], [[1, 0]], 0), [varying], PUSHED, worst=True)
    assert good["proof"]["method"] == "signal"
    # the gain of 1/(s^2 + s + 1) is 2/sqrt(3) = 1.1547; a stiffness that jumps from 1 to 4 gets more through
    assert low > 1.2
    assert recheck(json.dumps(good)).accepted
    assert_both_reject(edited(good, "laws", "channels", 0, "time_varying", value=False))
    assert_both_reject(edited(good, "laws", "channels", 0, "sector", value=["0", "2"]))


# of a ReLU no linear gain is a member, so that a signal has to show it; beside it phi_2 = g sigma with an end g is one
@pytest.mark.slow
@pytest.mark.parametrize("kind", ["slope", "gain"])
def test_beside_a_relu_other_classes_take_an_end_of_theirs(kind):
    A = [[F(84, 100), F(-17, 100)], [F(17, 100), F(8, 10)]]
    plant = as_plant((A, [[F(1, 10), F(1, 10)], [F(-1, 10), F(1, 5)]], [[1, 0], [0, 1]], [[0, 0], [0, 0]]), dt=1)
    other = (
        NonlinearityClass.constant_gain(0, 1) if kind == "gain" else NonlinearityClass.slope_restricted(0, 1, odd=True)
    )
    low, certificate = shown_below(plant, [RELU, other], {"Bw": [[1], [0]], "Cz": [[0, 1]]})
    # phi_1 = max(sigma, 0), phi_2 = 0: a signal that keeps x_1 < 0 sees A alone, whose response at z = 1 is linear
    still = abs(0.17 / ((1 - 0.84) * (1 - 0.8) + 0.17 * 0.17))
    assert low > 0.9 * still
    assert check(certificate)
    assert recheck(certificate).accepted
    assert certificate["proof"]["slopes"][0] == ["0", "1"]
    assert len(set(certificate["proof"]["slopes"][1])) == 1
    for wrong in (["0", "1"], ["0", "5/4"]):
        assert_both_reject(edited(certificate, "proof", "slopes", 1, value=lambda _, wrong=wrong: wrong))
