"""Forms of several samples of several nonlinearities: what is proved, and what both checkers reject."""

import copy
import json
from fractions import Fraction as F

import pytest
from tampering import assert_both_reject, edited

from lure import SlopeBounds, as_plant
from lure.analysis import certify, max_slope
from lure.analysis.certificates.checker import Proved, check
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.questions.certify import ProofOptions
from lure.plants.multivariable import MultivariablePlant

SIXTH = ([[F(1, 2), 0], [1, 0]], [[1], [0]], [[2, F("0.92")]], [[0]])  # example 6: (2 z + 0.92)/(z^2 - z/2)


def twice(M):
    width = len(M[0])
    return [[*row, *[0] * width] for row in M] + [[*[0] * width, *row] for row in M]


@pytest.fixture(scope="module")
def found():
    """Two copies of example 6 beside each other, with a nonlinearity each."""
    plant = MultivariablePlant(*map(twice, SIXTH), dt=1)
    return max_slope(plant, [SlopeBounds(0, 1), SlopeBounds(0, 1)], criterion="order-cones")


# Block-diagonal: what one loop reaches, 0.876480 with two samples (0.651041 by the circle criterion).
def test_two_loops_side_by_side_are_proved_as_far_as_one(found):
    assert found.criterion == "order-cones"
    assert found.largest.low == pytest.approx(0.87648, abs=3e-5)
    assert found.refuted_at > 0.9
    text = json.dumps(found.proof.certificate)
    assert isinstance(check(text), Proved)
    assert recheck(text).accepted


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("multiplier", "windows", 0, 2, 0), "-1"),
        (("multiplier", "windows", 1, 3, 3), lambda v: f"-{v}"),
        (("multiplier", "windows"), lambda v: v[:1]),
        (("multiplier", "windows"), lambda v: [v[0], v[1][:2]]),
        (("multiplier", "odd"), [True, False]),
        (("proof", "P", 0, 0), lambda v: str(-int(v))),
        (("proof", "P"), lambda v: v[:-1]),
        (("proof", "exponent"), lambda v: v + 1),
        (("laws", "channels", 0, "slope"), None),
        (("laws", "channels", 1, "time_varying"), True),
        (("laws", "channels", 0, "slope"), ["0", "9/10"]),
        (("system", "time"), "continuous"),
        (("system", "A", 0, 0), "3/2"),
        (("system", "D"), [["0", "1"], ["1", "0"]]),
    ],
)
def test_what_was_tampered_with_is_rejected_by_both(found, path, value):
    assert_both_reject(edited(found.proof.certificate, *path, value=value))


def test_a_direct_term_from_one_channel_to_the_next_counts():
    # proved up to .8743 with two samples: of another D the inequality fails, of a cycle of channels all
    plant = as_plant([["(2*z + 0.92)/(z^2 - z/2)", "1/(5*z)"], ["1/2", "1/(2*z - 1)"]], dt=1)
    ways = ProofOptions(criterion="coupled-windows")
    shown = certify(plant, [SlopeBounds(0, F("0.874"))] * 2, ways=ways).shown
    assert recheck(shown.certificate).accepted
    for D in ([["0", "0"], ["-1/2", "0"]], [["0", "0"], ["3/5", "0"]], [["0", "1/5"], ["1/2", "0"]]):
        assert_both_reject(edited(shown.certificate, "system", "D", value=D))


# P has either sign, so that a mode which nothing sees or drives can satisfy the inequality and grow: x+ = 2 x with
# V = -x^2. That the loop is stable at its least slopes is shown apart.
def test_an_unstable_mode_that_the_inequality_does_not_see_is_rejected(found):
    certificate = copy.deepcopy(dict(found.proof.certificate))
    system, proof = certificate["system"], certificate["proof"]
    n, unit = len(system["A"]), str(-(2 ** proof["exponent"]))
    grown = copy.deepcopy(certificate)
    grown["system"]["A"] = [[*row, "0"] for row in system["A"]] + [["0"] * n + ["2"]]
    grown["system"]["B"] = [*system["B"], ["0", "0"]]
    grown["system"]["C"] = [[*row, "0"] for row in system["C"]]
    P = [[*row[:n], *(["0"] if i >= n else []), *row[n:]] for i, row in enumerate(proof["P"])]
    grown["proof"]["P"] = [*P[:n], ["0"] * n + [unit], *P[n:]]
    assert_both_reject(grown)
    grown["system"]["A"][-1][-1] = "1/2"  # with V = x^2 the same mode, stable, is no obstacle
    grown["proof"]["P"][n][n] = unit.removeprefix("-")
    assert isinstance(check(json.dumps(grown), draft=True), Proved)
    assert recheck(json.dumps({**grown, **check(json.dumps(grown), draft=True).certificate})).accepted
