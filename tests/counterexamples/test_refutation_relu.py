"""Loops with ReLUs that are refuted by a solution that keeps its direction and grows."""

import json
from copy import deepcopy
from fractions import Fraction as F

import numpy as np
import pytest
from scipy.linalg import expm
from tampering import assert_both_reject, edited, refused_again

from lure import NonlinearityClass, SlopeBounds, as_plant, certify
from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.questions.channel_members import members_refuting
from lure.analysis.questions.channel_problem import channel_problem
from lure.analysis.verdict import Verdict

relu = NonlinearityClass.relu
CROSSED = [[0, -1], [-1, 0]]  # mu_i drives the other state upwards


def loop(A, B, classes, dt=None):
    n = len(A)
    return certify(as_plant((A, B, np.eye(n).tolist(), np.zeros((n, n)).tolist()), dt=dt), classes)


# x' = -x + 2 max(x, 0): e^t from x = 1.  x_1' = -x_1 + 3/2 max(x_2, 0) and the same turned round: e^(t/2) along (1, 1).
# x+ = -2 max(x, 0) - 3/4 min(x, 0): 1, -2, 3/2.  x_1+ = x_1/2 + max(x_2, 0), x_2+ = x_2/2 + phi(x_1): 3/2 along (1, 1)
@pytest.mark.parametrize(
    ("A", "B", "classes", "dt", "value", "steps"),
    [
        ([[-1]], [[-1]], relu(0, 2), None, 1, 1),
        ([[-1, 0], [0, -1]], CROSSED, [relu(0, F(3, 2))] * 2, None, F(1, 2), 1),
        ([[0]], [[1]], relu(F(3, 4), 2), 1, F(3, 2), 2),
        ([["1/2", 0], [0, "1/2"]], CROSSED, [relu(), SlopeBounds(0, 1)], 1, F(3, 2), 1),
    ],
)
def test_a_growing_solution_refutes(A, B, classes, dt, value, steps):
    found = loop(A, B, classes, dt)
    assert found.verdict is Verdict.REFUTED
    proof = found.shown.certificate["proof"]
    assert (proof["method"], len(proof["gains"])) == ("relu-ray", steps)
    assert abs(F(proof["value"]) - value) < F(1, 10**9)
    assert recheck(dict(found.shown.certificate)).accepted


# x+ = x/2 - 2 max(x, 0) is below 0 at once, where it decays, though the gain 2 destabilises; x' = -x + max(x, 0) rests
@pytest.mark.parametrize(("A", "B", "k", "dt"), [(["1/2"], ["1"], 2, 1), (["-1"], ["-1"], 1, None)])
def test_what_does_not_grow_is_not_refuted(A, B, k, dt):
    assert loop([A], [B], relu(0, k), dt).verdict is not Verdict.REFUTED


@pytest.fixture(scope="module")
def certificate():
    return dict(loop([[0]], [[1]], relu(F(3, 4), 2), 1).shown.certificate)


@pytest.mark.parametrize(
    ("key", "change"),
    [
        ("gains", lambda rows: [["2"], ["2"]]),  # the other sign of sigma
        ("gains", lambda rows: rows[::-1]),
        ("gains", lambda rows: [["1"] if row == ["2"] else row for row in rows]),  # no gain of the ReLU
        ("gains", lambda rows: rows[:1]),
        ("state", lambda state: [str(-F(state[0]))]),
        ("state", lambda state: ["0"]),
        ("value", lambda value: "1.6"),
        ("value", lambda value: "3/4"),
        ("radius", lambda radius: "0"),
        ("radius", lambda radius: "2"),
    ],
)
def test_both_checkers_reject_another_number(certificate, key, change):
    changed = deepcopy(certificate)
    changed["proof"][key] = change(changed["proof"][key])
    with pytest.raises((Rejected, Malformed)):
        check(json.dumps(changed))
    assert refused_again(changed)


def test_both_checkers_reject_another_class_and_a_slower_loop(certificate):
    for path, value in ((("laws", "channels", 0, "sector"), ["1/2", "2"]), (("system", "A"), [["1/4"]])):
        changed = deepcopy(certificate)
        place = changed
        for step in path[:-1]:
            place = place[step]
        place[path[-1]] = value
        with pytest.raises((Rejected, Malformed)):
            check(json.dumps(changed))
        assert refused_again(changed)


@pytest.mark.slow
def test_the_refuted_loops_do_grow():
    rng, refuted = np.random.default_rng(5), 0
    for k in range(12):
        dt = [None, 1][k % 2]
        A = np.round(8 * rng.normal(size=(3, 3))) / 16 - (dt is None) * 1.5 * np.eye(3)
        B, C = np.round(4 * rng.normal(size=(3, 2))) / 4, np.round(4 * rng.normal(size=(2, 3))) / 4
        if (np.abs(np.linalg.eigvals(A)).max() if dt else 1 + np.linalg.eigvals(A).real.max()) >= 1:
            continue
        found = certify(as_plant((A, B, C), dt=dt), [relu()] * 2)
        if found.verdict is not Verdict.REFUTED or found.shown.certificate["proof"]["method"] != "relu-ray":
            continue
        refuted += 1
        proof = found.shown.certificate["proof"]
        x, value = np.array([float(F(v)) for v in proof["state"]]), float(F(proof["value"]))
        start, pace = x.copy(), 1 if dt else 1e-3
        for _ in range(len(proof["gains"]) if dt else 1000):  # continuous time: one unit of it
            gains = np.where(C @ x > 0, 1.0, 0.0)
            closed = A - (B * gains) @ C
            x = (closed if dt else expm(closed * pace)) @ x
        assert x == pytest.approx((value if dt else np.exp(value)) * start, rel=1e-5, abs=1e-6)
    assert refuted > 1


# x1' = -x1 - max(x1, 0), x2' = -x2 + 2 max(x2, 0): the second grows as e^t beside a first that rests at 0
@pytest.mark.parametrize("dt", [None, 1])
def test_a_channel_that_rests_has_any_gain(dt):
    A = [["-1", "0"], ["0", "-1"]] if dt is None else [["1/2", "0"], ["0", "1/2"]]
    B, C = [["1", "0"], ["0", "-2"]], [["1", "0"], ["0", "1"]]
    plant = as_plant((A, B, C, [["0", "0"]] * 2), dt=dt)
    assert certify(plant, [NonlinearityClass.relu()] * 2).certificate["proof"]["method"] == "part"
    asked = channel_problem(plant, [NonlinearityClass.relu()] * 2)  # as one loop
    shown = dict(members_refuting(asked, most=1)[1].certificate)
    assert shown["proof"]["state"][0] == "0"
    assert recheck(shown).accepted
    # where the second state moves the first, sigma_1 has a sign; and 0 has to be 0
    for path, value in (
        (("system", "A", 0, 1), "1"),
        (("proof", "state", 0), "1/1000000"),
        (("proof", "state"), ["0", "0"]),
        (("system", "C", 0, 1), "1"),
        (("system", "A", 1, 1), "-3"),
    ):
        assert_both_reject(edited(shown, *path, value=value))
