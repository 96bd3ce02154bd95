"""Loops with several channels in the second checker: delays, members, rays and disturbances by their formulas."""

import cmath
import math
from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest
from flint import arb, arb_mat, fmpq, fmpq_mat
from second_plants import PLAIN, asked, assert_accepted_if, at, of, rows_of, unit

from lure.analysis.certificates.second import channel_gains, members, rays, signals
from lure.analysis.certificates.second.classes import EXCEEDED, NO_REST, OTHER_EQUILIBRIA, SCALAR
from lure.analysis.certificates.second.delays import refuted_by_delay, refuted_by_delayed_members, without_delays
from lure.analysis.certificates.second.numerics import to_fmpq, working_precision
from lure.analysis.certificates.second.reading import NotShown

TIMID = replace(PLAIN, slope=None, lower=F(-1), time_varying=True)
LATE = replace(TIMID, operator="delay", upper=F(3), time_varying=False)
VARYING = replace(TIMID, operator="varying delay", upper=F(2))
SEEN = replace(TIMID, operator="performance")
GAIN = replace(PLAIN, slope=None, linear=True)


# Delays


def test_delays_in_samples_see_how_sigma_changes_and_lasting_ones_may_stay():
    sides = (
        [[fmpq(1, 2), 1, 0], [0, fmpq(-1, 3), 1], [0, 0, fmpq(1, 5)]],
        [[1, 0, 2], [0, 1, 1], [1, 1, 0]],
        unit(3).tolist(),
    )
    direct = [[0, 0, fmpq(1, 3)], [0, 0, fmpq(1, 4)], [0, 0, 0]]
    plant = asked(*sides, direct, LATE, VARYING, PLAIN, discrete=True)
    found, z = without_delays(plant), fmpq(3)
    P = at((plant.A, plant.B, plant.C, plant.D), z)
    E, seen = fmpq_mat([[1, 0, 0], [0, 1, 0], [0, 0, 0]]), fmpq_mat([[fmpq(2, 3), 0, 0], [0, fmpq(2, 3), 0], [0, 0, 1]])
    assert at((found.A, found.B, found.C, found.D), z) == seen * (unit(3) + P * E).inv() * P
    assert [one.ends for one in found.nonlinearities] == [(-3, 3), (-2, 2), (0, 1)]
    assert all(one.operator == "any" and one.time_varying for one in found.nonlinearities[:2])
    slow = replace(VARYING, rate=F(1, 2))
    kept = asked(*sides, [[0] * 3] * 3, LATE, slow, VARYING)
    found, P = without_delays(kept, constant=False), at((kept.A, kept.B, kept.C, kept.D), z)
    E, seen = fmpq_mat([[0] * 3, [0] * 3, [0, 0, 1]]), fmpq_mat([[1, 0, 0], [0, 1, 0], [0, 0, z]])
    assert at((found.A, found.B, found.C, found.D), z) == seen * (unit(3) + P * E).inv() * P
    assert found.nonlinearities[:2] == kept.nonlinearities[:2]
    assert all(one.operator != "varying delay" for one in without_delays(kept).nonlinearities)


@pytest.mark.parametrize(
    ("D", "one", "holds"),
    [
        ([[0, 0], [0, 0]], VARYING, True),
        ([[0, 0], [1, 0]], VARYING, True),
        ([[0, 1], [0, 0]], VARYING, False),  # sigma jumps
        ([[0, 1], [0, 0]], LATE, True),
        ([[1, 0], [0, 0]], LATE, False),  # a cycle
        ([[0, 1], [1, 0]], LATE, False),
        ([[0, 0], [0, 0]], replace(LATE, upper="inf"), False),
    ],
)
def test_beside_which_direct_terms_delays_are_taken_out(D, one, holds):
    plant = asked([[-1]], [[1, 1]], [[1], [1]], D, one, PLAIN)
    with assert_accepted_if(holds):
        without_delays(plant)


# 9/(s + 1)^3 with the delay 1/20: 1 in size at 1.82, where it turns by less than pi; as in the formulas' table
@pytest.mark.parametrize(
    ("change", "holds"),
    [
        ({}, True),
        ({"channel": 2}, False),  # a function
        ({"channel": 3}, False),
        ({"gains": ["0", "0"]}, False),
        ({"gains": ["1", "2"]}, False),
        ({"frequencies": ["164/100", "163/100"]}, False),
        ({"delays": ["1/10", "0"]}, False),
        ({"delays": ["0", "4"]}, False),  # longer than the class has
        ({"delays": ["0"]}, False),
    ],
)
def test_a_crossing_by_delay_is_of_its_channel(change, holds):
    # beside the function with the gain 1 in the second channel: 14/(s + 1)^3 over 1 + 1/(s + 1)^0 of D_22 = 1
    A, B = [[-1, 0, 0], [1, -1, 0], [0, 1, -1]], [[7, 0], [0, 0], [0, 0]]
    plant = asked(A, B, [[0, 0, 1], [0, 0, 0]], [[0, 0], [0, 1]], LATE, PLAIN)
    given = {"method": "delayed-gains", "gains": ["1", "1"], "channel": 1, "delays": ["0", "1/10"]}
    proof = given | {"frequencies": ["163/100", "164/100"]} | change
    with assert_accepted_if(holds):
        assert refuted_by_delay(of(**proof), plant) == NO_REST
    for other in (replace(plant, repeated=(0, 0)), replace(plant, D=fmpq_mat([[0, 0], [0, -1]]))):
        with pytest.raises(NotShown):
            refuted_by_delay(of(**proof), other)


# b/(z - 1/2) + D behind a delay of 1 sample: z^2 + (D - 1/2) z + b - D/2, stable for b - D/2 < 1 and small D
@pytest.mark.parametrize(
    ("b", "D", "samples", "most", "said"),
    [
        (F(11, 10), 0, 1, 3, NO_REST),
        (F(9, 10), 0, 1, 3, None),
        (F(9, 10), F(-1, 4), 1, 3, NO_REST),
        (F(3, 4), F(-1, 4), 1, 3, None),
        (F(9, 10), 0, 2, 3, NO_REST),  # z^3 - z^2/2 + 9/10
        (F(11, 10), 0, 2, 1, None),
        (F(-1, 2), 0, 1, 3, OTHER_EQUILIBRIA),
        (F(-2), 0, 60, 70, None),
    ],
)
def test_a_delay_of_samples_moves_the_eigenvalues(b, D, samples, most, said):
    late = replace(LATE, upper=F(most))
    sides = [[fmpq(1, 2)]], [[to_fmpq(b), 1]], [[1], [0]], [[to_fmpq(F(D)), 0], [0, 0]]
    plant = asked(*sides, late, PLAIN, discrete=True)
    proof = {"method": "delayed-gains", "gains": ["1", "0"], "channel": 1, "samples": samples}
    with assert_accepted_if(said is not None):
        assert refuted_by_delay(of(**proof), plant) == said
    for change in ({"channel": 2}, {"channel": 3}, {"gains": ["0", "0"]}, {"samples": 0}):
        with pytest.raises(NotShown):
            refuted_by_delay(of(**(proof | change)), plant)
    with pytest.raises(NotShown, match="no such channel"):
        refuted_by_delay(of(**(proof | {"gains": ["1", "1"]})), replace(plant, repeated=(0, 0)))


def test_what_gains_and_delays_let_through_is_that_of_complex_numbers():
    A, B, C = [[-1, 2], [0, -3]], [[1, 0, 1, 0], [2, 1, 0, 1]], [[1, 0], [0, 1], [1, 1], [1, -2]]
    D = [[0, 0, 0, 1], [0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]]
    s, w = 0.7j, np.array([0.6 - 0.8j, 0.5 + 2j])
    H = np.array(C) @ np.linalg.solve(s * np.eye(2) - np.array(A), np.array(B)) + np.array(D)
    G = np.diag([0.5, cmath.exp(-1.25 * s), 0, 0])
    z = np.linalg.solve(np.eye(4) + H @ G, H[:, 2:] @ w)[2:]
    size = float(np.linalg.norm(z) / np.linalg.norm(w))
    given = {"method": "delayed-members", "gains": ["1/2", "1", "0", "0"], "delays": ["5/4"], "omega": "7/10"}
    proof = given | {"input": [["3/5", "-4/5"], ["1/2", "2"]]}

    def plant(share):
        r = F(1 / (size * share)).limit_denominator(10**6)
        return asked(A, B, C, D, PLAIN, LATE, *[replace(SEEN, lower=-r, upper=r)] * 2, repeated=(0, 1, 2, 2))

    for share, holds in ((0.999, True), (1.001, False)):
        with assert_accepted_if(holds):
            assert refuted_by_delayed_members(of(**proof), plant(share)) == EXCEEDED
    easy = plant(0.1)
    refuted_by_delayed_members(of(**proof), easy)
    one, late, *seen = easy.nonlinearities
    for change, other in (
        ({"omega": "-7/10"}, {}),
        ({"delays": ["-1/10"]}, {}),
        ({"delays": ["31/10"]}, {}),
        ({"delays": []}, {}),
        ({"gains": ["2", "1", "0", "0"]}, {}),
        ({"input": [["1", "0"]]}, {}),
        ({}, {"discrete": True}),
        ({}, {"D": fmpq_mat([[1, 0, 0, 0], *[[0] * 4] * 3])}),
        ({}, {"nonlinearities": (replace(one, relu=True), late, *seen)}),
        (
            {"delays": ["1", "2"], "gains": ["1", "1", "0", "0"]},
            {"nonlinearities": (late, late, *seen), "repeated": (0, 0, 2, 2)},
        ),
    ):
        with pytest.raises(NotShown):
            refuted_by_delayed_members(of(**(proof | change)), replace(easy, **other))


# Members


@pytest.mark.parametrize(("omega", "discrete"), [(F(3, 2), False), (F(1, 2), True), (None, False), (None, True)])
def test_what_comes_through_members_is_that_of_complex_numbers(omega, discrete):
    A, B, C, D = [[F(-1), F(2, 3)], [F(1, 2), F(3)]], [[1, 2], [0, 1]], [[1, -1], [2, 1]], [[F(1, 3), 0], [1, -2]]
    w, loop = (
        [[F(1), F(2)], [F(-1, 2), F(1, 3)]],
        [fmpq_mat([[to_fmpq(F(v)) for v in row] for row in M]) for M in (A, B, C, D)],
    )
    found = members._response(tuple(loop), w, omega, discrete=discrete)
    signal = np.array([complex(*map(float, pair)) for pair in w])
    plain = np.array(D, dtype=float)
    if omega is None and not discrete:
        wanted = plain @ signal
    else:
        t = 0 if omega is None else float(omega)
        s = (-1 if omega is None else (1 + 1j * t) ** 2 / (1 + t * t)) if discrete else 1j * t
        inner = np.linalg.solve(s * np.eye(2) - np.array(A, dtype=float), np.array(B, dtype=float) @ signal)
        wanted = np.array(C, dtype=float) @ inner + plain @ signal
    assert [float(v.p) / float(v.q) for v in found] == pytest.approx([*wanted.real, *wanted.imag])


# sigma' = -sigma - c W sigma, W = 1 or (s - 1)/(s + 1): unstable for c = -2, with W (s + 1)^2 + c (s - 1) for c = 2
@pytest.mark.parametrize(
    ("delta", "gains", "D", "holds"),
    [
        (["-2", None], ["0"], 0, True),
        (["-201/100", None], ["0"], 0, False),
        (["-1/2", None], ["0"], 0, False),
        (["2", "1"], ["0"], 0, True),
        (["201/100", "1"], ["0"], 0, False),
        (["1/2", "1"], ["0"], 0, False),
        (["2", "1"], ["1"], 0, False),
        (["1", "1"], ["0"], 2, False),  # 1 + 2 (s - 1)/(s + 1) has a zero on the right whatever the plant is
    ],
)
def test_a_scalar_member_has_the_norm_of_its_class(delta, gains, D, holds):
    one = replace(TIMID, operator=SCALAR, lower=F(-2), upper=F(2), time_varying=False)
    plant = asked([[-1]], [[int(D == 0)]], [[1]], [[D]], one)
    proof = {"method": "members", "gains": gains, "operators": [{"delta": delta}]}
    with assert_accepted_if(holds):
        members.refuted_by_members(of(**proof), plant)
    with pytest.raises(NotShown):
        members.refuted_by_members(of(**(proof | {"operators": []})), plant)


def test_a_gain_is_asked_of_a_stable_loop_with_a_performance_channel():
    one, seen = (
        replace(TIMID, operator="linear time-invariant", lower=F(-3), upper=F(3)),
        replace(SEEN, lower=F(-9), upper=F(9)),
    )
    plant = asked([[-1]], [[1, 1]], [[1], [1]], [[0, 0]] * 2, one, seen)
    for c, holds in (("-1/2", True), ("-2", False)):  # the pole at 1 would let through as much
        operator = {"left": [[c, None]], "right": [["1", None]]}
        proof = {"method": "members", "gains": ["0", "0"], "operators": [operator], "omega": "0", "input": [["1", "0"]]}
        with assert_accepted_if(holds):
            members.refuted_by_members(of(**proof), plant)
    given = {"method": "members", "gains": ["0"], "operators": [], "omega": "0", "input": []}
    with pytest.raises(NotShown, match="no performance channel"):
        members.refuted_by_members(of(**given), asked([[-1]], [[1]], [[1]], [[0]], PLAIN))


# Rays: of [[0, 1], [-2, -3]] the eigenvector (1, -1) of -1, and x_1 held; radius 1/1000


@pytest.mark.parametrize(
    ("by_state", "by_value"), [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, 1), (1, -1), (-1, -1)]
)
def test_an_eigenvector_lies_within_its_radius(by_state, by_value):
    matrix, radius = fmpq_mat([[0, 1], [-2, -3]]), F(1, 1000)
    for share, holds in ((F(9, 10), True), (F(11, 10), False)):
        x, value = [F(1), -1 + by_state * share * radius], -1 + by_value * share * radius
        with working_precision(200), assert_accepted_if(holds):
            state, rate = rays._eigenvector(matrix, x, value, radius, 0)
            assert rate.contains(arb(-1))
            assert state[0, 0] == 1
            assert state[1, 0].contains(arb(-1))


# x_1' = x_1 - phi(x_2), x_2' = x_2/2 + ...: x_2 = 0 is invariant, where any ReLU of it has any gain
@pytest.mark.parametrize(
    ("A", "C", "state", "value", "holds"),
    [
        ([[1, 0], [0, -2]], [[0, 1]], ["1", "0"], "1", True),
        ([[1, 0], [1, -2]], [[0, 1]], ["1", "0"], "1", False),  # not invariant
        ([[1, 0, 0], [1, -2, 0], [0, 0, -2]], [[0, 1, 0]], ["1", "0", "0"], "1", False),
        ([[1, 0, 0], [0, -2, 1], [0, 0, -2]], [[0, 1, 1]], ["1", "0", "0"], "1", True),
        ([[1, 0], [1, -2]], [[0, 1]], ["3", "1"], "1", True),
        ([[1, 0], [1, -2]], [[0, 1]], ["-3", "-1"], "1", False),  # with the other gain
        ([[1, 0], [0, -2]], [[1, 1]], ["1", "0"], "1", True),
        ([[1, 0], [0, -2]], [[-1, 1]], ["1", "0"], "1", False),
        ([[-1, 0], [0, -2]], [[0, 1]], ["1", "0"], "-1", False),
        ([[1, 0], [0, -2]], [[0, 1]], ["0", "0"], "1", False),
        ([[1, 0], [0, -2]], [[0, 1]], ["1"], "1", False),
    ],
)
def test_a_ray_of_two_states(A, C, state, value, holds):
    relu = replace(PLAIN, relu=True)
    plant = asked(A, [[0]] * len(A), C, [[0]], relu)
    proof = {"method": "relu-ray", "gains": [["1"]], "state": state, "value": value, "radius": "1/1000"}
    with assert_accepted_if(holds):
        assert rays.refuted_by_ray(of(**proof), plant) == NO_REST
    with pytest.raises(NotShown):
        rays.refuted_by_ray(of(**(proof | {"radius": "0"})), plant)


# in samples: x+ = 2 x without the function, 3/4 x with the gain 1 in every other step
@pytest.mark.parametrize(
    ("gains", "one", "holds"),
    [
        ([["0", "1/2"]], {}, True),
        ([["0", "1/2"], ["0", "1/2"]], {}, True),
        ([["0", "1/2"], ["0", "0"]], {}, False),  # a function of no one slope
        ([["0", "1/2"]], {"upper": F(1, 4), "slope": (F(0), F(1, 4))}, False),
        ([["0", "1/2"]], {"operator": "any"}, False),
        ([["0"]], {}, False),
        ([["1", "1/2"]], {}, False),  # the gain of x > 0
    ],
)
def test_beside_rays_of_rectifiers_functions_have_one_gain(gains, one, holds):
    plant = asked(
        [[2]], [[1, 1]], [[-1], [1]], [[0, 0]] * 2, replace(PLAIN, relu=True), replace(PLAIN, **one), discrete=True
    )
    value = str(F(3, 2) ** len(gains)) if len(gains[0]) > 1 and gains[0][0] == "0" else "1/2"
    proof = {"method": "relu-ray", "gains": gains, "state": ["1"], "value": value, "radius": "1/1000"}
    with assert_accepted_if(holds):
        rays.refuted_by_ray(of(**proof), plant)
    with pytest.raises(NotShown):
        rays.refuted_by_ray(of(**(proof | {"gains": []})), plant)


def test_in_samples_a_ray_by_which_the_solution_falls_is_refused():
    for a, holds in ((F(2), True), (F(1), False), (F(1, 2), False)):
        plant = asked([[to_fmpq(a)]], [[1]], [[-1]], [[0]], replace(PLAIN, relu=True), discrete=True)
        proof = {"method": "relu-ray", "gains": [["0"]], "state": ["1"], "value": str(a), "radius": "1/1000"}
        with assert_accepted_if(holds):
            rays.refuted_by_ray(of(**proof), plant)


# Disturbances


@pytest.mark.parametrize(
    ("one", "value", "holds"),
    [
        ({}, ["0", "1"], True),
        ({}, ["0", "11/10"], False),
        ({}, ["-1/10", "1"], False),
        ({}, ["0", "1", "1"], False),
        ({"odd": True}, ["1/2", "1/2"], True),
        ({"odd": True}, ["0", "1"], False),
        ({"linear": True}, ["0", "1"], False),
        ({"relu": True}, ["0", "1"], True),
        ({"relu": True}, ["0", "1/2"], False),
        ({}, [["0", "1"], ["1", "0"]], True),
        ({}, [["0", "1"]], False),
        ({}, [["0", "1"], ["1", "2"]], False),
        ({"linear": True}, [["1", "1"], ["1", "1"]], True),
        ({"linear": True}, [["1", "1"], ["0", "0"]], False),
        ({"rate": F(1)}, [["1", "1"], ["0", "0"]], False),
    ],
)
def test_which_lines_a_class_has(one, value, holds):
    plant = asked([[-1]], [[1, 1]], [[1], [1]], [[0, 0]] * 2, replace(PLAIN, **one), SEEN)
    with assert_accepted_if(holds):
        found = signals._lines(value, 0, plant, 2)
        assert found == [(F(a), F(b)) for a, b in (value if isinstance(value[0], list) else [value] * 2)]


SAMPLES = {
    "A": [[fmpq(1, 2), 1], [0, fmpq(-1, 3)]],
    "B": [[1, 0, 2], [2, 1, 1]],
    "C": [[1, 0], [1, -1], [0, 1]],
    "D": [[0, 0, 1], [fmpq(1, 2), 0, 0], [1, 2, fmpq(1, 4)]],
}


def test_what_comes_through_in_samples_is_followed_exactly():
    one = replace(PLAIN, slope=None)
    seen = replace(SEEN, lower=F(-1, 2), upper=F(1, 2))
    plant = asked(*SAMPLES.values(), one, one, seen, discrete=True)
    A, B, C, D = map(rows_of, (plant.A, plant.B, plant.C, plant.D))
    lines, inputs = {0: [(F(0), F(1))] * 3, 1: [(F(1, 2), F(1, 4))] * 3}, [F(1), F(-2), F(1, 2)]
    x, total = np.zeros(2), 0.0
    for w in map(float, inputs):
        mu = np.array([0, 0, w])
        for i in (0, 1):
            sigma = C[i] @ x + D[i] @ mu
            mu[i] = -float(lines[i][0][int(sigma > 0)]) * sigma
        z = C[2] @ x + D[2] @ mu
        total, x = total + z * z - 4 * w * w, A @ x + B @ mu
    found = signals._in_samples(plant, lines, [[w] for w in inputs])
    assert float(found.p) / float(found.q) == pytest.approx(total)
    proof = {"method": "signal", "slopes": [["0", "1"], ["1/2", "1/4"]], "inputs": [["1"], ["-2"], ["1/2"]]}
    assert (found > 0) is False
    for bound, holds in ((F(1, 2), False), (F(9), True)):
        easy = replace(plant, nonlinearities=(one, one, replace(SEEN, lower=-bound, upper=bound)))
        with assert_accepted_if(holds):
            assert signals.refuted_by_signal(of(**proof), easy) == EXCEEDED
    for change, other in (
        ({"inputs": []}, {}),
        ({"inputs": [["1", "1"]]}, {}),
        ({"slopes": [["0", "1"]]}, {}),
        ({}, {"repeated": (0, 0, 2)}),
        ({}, {"D": fmpq_mat([[0, 1, 1], *SAMPLES["D"][1:]])}),
        ({}, {"D": fmpq_mat([[1, 0, 1], *SAMPLES["D"][1:]])}),
        ({}, {"nonlinearities": (one, replace(one, operator="any"), easy.nonlinearities[2])}),
        ({}, {"nonlinearities": (one, replace(one, memory=("play", F(1))), easy.nonlinearities[2])}),
    ):
        with pytest.raises(NotShown):
            signals.refuted_by_signal(of(**(proof | change)), replace(easy, **other))


# sigma = w: a function that does not depend on time has one value at 1, an odd one minus that at -1
@pytest.mark.parametrize(
    ("one", "inputs", "holds"),
    [
        ({"slope": None}, (1, 1), False),
        ({"slope": None}, (1, 2), True),
        ({"slope": None}, (1, -1), True),
        ({"slope": None, "odd": True}, (1, -1), False),
        ({"slope": None, "time_varying": True}, (1, 1), True),
        ({}, (1, 2), False),
        ({"time_varying": True}, (1, 2), True),
    ],
)
def test_a_function_of_sigma_alone_has_one_value(one, inputs, holds):
    odd = one.get("odd", False)
    plant = asked([[0]], [[0, 0]], [[0], [0]], [[0, 1], [0, 1]], replace(PLAIN, **one), SEEN, discrete=True)
    lines = {0: [(F(0), F(int(not odd))), (F(int(not odd)), F(0))]} if not odd else {0: [(F(0), F(0)), (F(1), F(1))]}
    lines = {0: [(F(1), F(1)), (F(0), F(0))]} if not odd and inputs == (1, -1) else lines
    with assert_accepted_if(holds):
        signals._in_samples(plant, lines, [[F(w)] for w in inputs])


def steps(plant, lines, count):
    return signals._Steps(plant, {i: [line] * count for i, line in lines.items()})


def test_the_energy_of_a_flow_is_that_of_its_integral():
    # x' = -(1 + a) x + w, z = 2 x: from rest 2 w (1 - e^-kt)/k, then 2 x_1 e^-kt
    one, seen = replace(PLAIN, slope=None), replace(SEEN, lower=F(-1, 2), upper=F(1, 2))
    plant = asked([[-1]], [[1, 1]], [[1], [2]], [[0, 0]] * 2, one, seen)
    k, T, S, w = 1.5, 0.75, 0.5, 3.0
    first = 4 * w * w / k**2 * (T - 2 * (1 - math.exp(-k * T)) / k + (1 - math.exp(-2 * k * T)) / (2 * k))
    x = w * (1 - math.exp(-k * T)) / k
    wanted = first + 4 * x * x * (1 - math.exp(-2 * k * S)) / (2 * k) - 4 * T * w * w
    with working_precision(192):
        loop = steps(plant, {0: (F(1, 2), F(1, 2))}, 2)
        found = loop.balance([[F(3)], [F(0)]], [F(3, 4), F(1, 2)], [[0], [1]])
    assert float(found.mid()) == pytest.approx(wanted)
    assert found.rad() < arb(2) ** -40


@pytest.mark.parametrize(
    ("change", "one", "holds"),
    [
        ({}, {}, True),
        ({"slopes": [[["1/2", "1/2"], ["1", "1"]]]}, {}, False),  # the function would depend on time
        ({"slopes": [[["1/2", "1/2"], ["1", "1"]]]}, {"time_varying": True}, True),
        ({"slopes": [["0", "1"]], "sides": [[1], [1]]}, {}, True),
        ({"slopes": [["0", "1"]], "sides": [[0], [0]]}, {}, False),  # sigma is above 0
        ({"inputs": [["-3"], ["0"]], "slopes": [["0", "1"]], "sides": [[0], [0]]}, {}, True),
        ({"sides": [[2], [1]]}, {}, False),
        ({"sides": [[0]]}, {}, False),
        ({"sides": [[0, 0], [1, 1]]}, {}, False),
        ({"times": ["3/4"]}, {}, False),
        ({"times": ["3/4", "0"]}, {}, False),
        ({"times": ["3/4", "-1/2"]}, {}, False),
        ({"bits": 64}, {}, False),
        ({"scale": "0"}, {}, False),
    ],
)
def test_a_flow_of_lines_lets_more_through_than_is_said(change, one, holds):
    # as above: |z|^2 is above |w|^2 (4/9)^2, and is not with a ninth of z
    classes = replace(PLAIN, slope=None, **one), replace(SEEN, lower=F(-9, 4), upper=F(9, 4))
    plant = asked([[-1]], [[1, 1]], [[1], [2]], [[0, 0]] * 2, *classes)
    given = {"method": "signal", "slopes": [["1/2", "1/2"]], "inputs": [["3"], ["0"]], "times": ["3/4", "1/2"]}
    proof = given | {"sides": [[0], [1]], "scale": "1", "bits": 192} | change
    with assert_accepted_if(holds):
        assert signals.refuted_by_signal(of(**proof), plant) == EXCEEDED
    with pytest.raises(NotShown):
        signals.refuted_by_signal(of(**proof), replace(plant, C=fmpq_mat([[1], [fmpq(1, 9)]])))


def test_how_far_a_flow_may_be_off_is_bounded_by_its_parts():
    sides = [[-1, 2], [0, -3]], [[1, 0, 1], [2, 1, 0]], [[3, 4], [0, 1], [1, 1]], [[0, 0, 0], [2, 0, 0], [0, 0, 0]]
    one, seen = replace(PLAIN, slope=None, upper=F(5)), replace(SEEN, lower=F(-1), upper=F(1))
    plant = asked(*sides, one, one, seen)
    with working_precision(96):
        loop = steps(plant, {0: (F(1), F(2)), 1: (F(3), F(-4))}, 1)
        assert [loop.steep[i] == v for i, v in ((0, 2), (1, 4))] == [True, True]
        for found, wanted in (
            (loop.reach[0], 2 * 5),  # 2 |(3, 4)|
            (loop.reach[1], 4 * (1 + 2 * 10)),
            (loop.columns[0], 5**0.5),
            (loop.columns[1], 1),
            (loop.growth, 14**0.5 + 5**0.5 * 10 + 84),
        ):
            assert float(found.mid()) == pytest.approx(wanted)
        G, rows = loop.rows([F(2), F(3)])  # mu_1 = -2 sigma_1, mu_2 = -3 (x_2 - 4 sigma_1)
        first, second = np.array([3, 4]), np.array([0, 1]) - 4 * np.array([3, 4])
        wanted = np.array([[-1, 2], [0, -3]]) + np.outer([1, 2], -2 * first) + np.outer([0, 1], -3 * second)
        assert [[float(G[i, j].mid()) for j in range(3)] for i in range(3)] == pytest.approx(
            np.vstack([np.hstack([wanted, [[1], [0]]]), np.zeros((1, 3))])
        )
        assert [[float(rows[i, j].mid()) for j in range(3)] for i in range(3)] == pytest.approx(
            np.array([[3, 4, 0], [*second, 0], [1, 1, 0]])
        )


# x' = x_0 - phi(x) - x + w: x ascends to less than e = 1e-7, where phi is steep, and the side said is the other
@pytest.mark.parametrize("wait", [0, 1])
@pytest.mark.parametrize(("said", "true"), [(0, 5), (-3, 3)])
def test_on_the_wrong_side_no_more_comes_through_than_is_true(wait, said, true):
    one, seen = replace(PLAIN, slope=None, upper=F(5)), replace(SEEN, lower=F(-1), upper=F(1))
    plant = asked([[-1]], [[1, 1]], [[1], [1]], [[0, 0]] * 2, one, seen)
    w, T = 1e-7, 0.1
    with working_precision(192):
        loop = steps(plant, {0: (F(said), F(true))}, 1 + wait)
        given = [[F(1, 10**7)]] + [[F(0)]] * wait, [F(1, 10)] * (1 + wait), [[0]] + [[1]] * wait
        found = loop.balance(*given)
    k = 1.0 + true
    x = w * (1 - math.exp(-k * T)) / k
    through = w * w / k**2 * (T - 2 * (1 - math.exp(-k * T)) / k + (1 - math.exp(-2 * k * T)) / (2 * k))
    through += wait * x * x * (1 - math.exp(-2 * k * T)) / (2 * k)
    assert float(found.upper()) <= through - w * w * T


# sum c_j q^j on [0, 1]: its least value, or 0 where that is above
@pytest.mark.parametrize(
    ("c", "least"),
    [
        ((1, -2), -1),
        ((1, 3), 0),
        ((-1, 3), -1),
        ((0, 1, -2), -1),
        ((0, 1, -1), 0),
        ((-1, 2, -2), -1),
        ((-1, 0, 1, -3), -3),
        ((0, 0, 1, -1), 0),
        ((0, 0, 1, -2), -1),
        ((0, 0, 0, 1, -1), 0),
        ((0, 0, 0, 1, -2), -1),
        ((-1, -1, 2, -3), -3),
    ],
)
def test_below_what_a_polynomial_does_not_fall(c, least):
    n = len(c)
    with working_precision(96):
        step = arb_mat([[int(j == i + 1) for j in range(n)] for i in range(n)])
        X = arb_mat([[math.factorial(k) * v] for k, v in enumerate(c)])
        row = arb_mat([[int(k == 0) for k in range(n)]])
        found = signals._lowest(row, step, X)
        assert least - 1e-9 <= float(found) <= least
        wrong = signals._wrong(row, step, X, step.exp() * X)
        dense = -min(sum(v * (k / 400) ** j for j, v in enumerate(c)) for k in range(401))
        assert max(dense, 0) <= float(wrong) <= 4 * max(dense, 0) + 1e-9


def test_what_a_series_leaves_out_counts():
    with working_precision(96):
        for size in (10, 20, 40):  # -exp(20 q): four fifths of it are in the terms that are added
            row, step, X = arb_mat([[1]]), arb_mat([[size]]), arb_mat([[-1]])
            assert signals._lowest(row, step, X) <= -arb(size).exp()
        dip = arb_mat([[0, 1, 0], [0, 0, 1], [0, 0, 0]])  # 3/16 - q + q^2, -1/16 in the middle
        X = arb_mat([[fmpq(3, 16)], [-1], [2]])
        row = arb_mat([[1, 0, 0]])
        found = signals._wrong(row, dip, X, dip.exp() * X)
        assert 1 / 16 <= float(found) <= 1 / 15


# Points at rest and samples that come back: x' = -x + u, or x+ = -u, with u = phi(x), sigma = x

LINE = {"points": [["0", "0"]], "left": "1", "right": "1"}


@pytest.mark.parametrize(
    ("change", "plant", "holds"),
    [
        ({}, {}, True),
        ({"state": ["0"], "inputs": ["0"]}, {}, False),
        ({"state": ["2"]}, {}, False),
        ({"state": ["1", "0"]}, {}, False),
        ({"inputs": ["1", "0"]}, {}, False),
        ({"state": ["1/2"], "inputs": ["1/2"], "nonlinearities": [LINE | {"left": "1/2"}]}, {}, True),
        ({"nonlinearities": [LINE | {"right": "1/2"}]}, {}, False),  # phi(1) is another
        ({"nonlinearities": [LINE | {"left": "2"}]}, {}, False),  # not in the class
        ({"nonlinearities": [LINE] * 2}, {}, False),
        ({}, {"A": fmpq_mat([[fmpq(-1, 2)]])}, False),
        ({}, {"C": fmpq_mat([[2]])}, False),
        ({}, {"D": fmpq_mat([[1]])}, False),  # sigma = x - u
        ({}, {"C": fmpq_mat([[2]]), "D": fmpq_mat([[1]])}, True),
        ({}, {"nonlinearities": (replace(PLAIN, operator="any"),)}, False),
        ({}, {"nonlinearities": (replace(PLAIN, lower=F(1), upper=F(2), slope=None),)}, False),  # 0 at the lower bound
    ],
)
@pytest.mark.parametrize("discrete", [False, True])
def test_what_is_at_rest_solves_the_equations(change, plant, holds, discrete):
    whole = replace(asked([[-1]], [[-1]], [[1]], [[0]], PLAIN), **plant)
    whole = replace(whole, A=whole.A + 1 * unit(1), discrete=True) if discrete else whole
    proof = {"method": "equilibrium", "nonlinearities": [LINE], "inputs": ["1"], "state": ["1"]} | change
    with assert_accepted_if(holds):
        assert channel_gains.refuted(of(**proof), whole) == OTHER_EQUILIBRIA


@pytest.mark.parametrize(
    ("change", "plant", "holds"),
    [
        ({}, {}, True),
        ({"inputs": [["1"]], "half": True}, {}, True),
        ({"inputs": [["1"]]}, {}, False),
        ({"half": True}, {}, False),
        ({"half": 0}, {}, False),
        ({"inputs": [["1"], ["1"]]}, {}, False),
        ({"inputs": []}, {}, False),
        ({"inputs": [["1", "0"], ["-1", "0"]]}, {}, False),
        ({"state": ["-1"], "inputs": [["-1"], ["1"]]}, {}, True),
        ({"state": ["1", "0"]}, {}, False),
        ({"inputs": [["1"]], "half": True, "nonlinearities": [LINE | {"left": "1/2"}]}, {}, False),  # not odd
        ({"nonlinearities": [LINE | {"left": "1/2"}]}, {}, False),
        ({"state": ["0"], "inputs": [["0"], ["0"]]}, {}, False),
        ({}, {"D": fmpq_mat([[1]])}, False),
        ({}, {"C": fmpq_mat([[2]]), "D": fmpq_mat([[1]])}, True),
        ({}, {"discrete": False}, False),
        ({}, {"nonlinearities": (replace(PLAIN, operator="any"),)}, False),
        ({}, {"nonlinearities": (replace(PLAIN, memory=("play", F(1))),)}, False),
    ],
)
def test_samples_that_come_back_lie_on_the_graph(change, plant, holds):
    whole = replace(asked([[0]], [[1]], [[1]], [[0]], PLAIN, discrete=True), **plant)
    given = {"method": "sampled-orbit", "nonlinearities": [LINE], "inputs": [["1"], ["-1"]], "state": ["1"]}
    with assert_accepted_if(holds):
        assert channel_gains.refuted(of(**(given | {"half": False} | change)), whole) == NO_REST
