"""Loops that recover from everywhere: functions that fall along every solution, and the only equilibrium."""

import json
import math
from fractions import Fraction

import pytest
from certificate_format import FORMAT
from tampering import assert_both_reject, edited

from lure import ReLU, Saturation, Tanh, as_plant
from lure.analysis import check, region
from lure.analysis.certificates.checker import Proved
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.questions.region_sets import rests_at_0, shape_of
from lure.nonlinearities import Cubic, DeadZone
from lure.plants.multivariable import MultivariablePlant


def rows(matrix):
    return tuple(tuple(Fraction(str(v)) for v in row) for row in matrix)


def test_a_loop_that_is_stable_from_everywhere_says_so():
    found = region(([1], [1, 3, 3, 1]), Saturation())
    assert (found.sets[0].kind, found.area) == ("everything", (math.inf, math.inf))
    assert found.sets[0].contains([100, 100, 100])


# A line is no nonlinearity of its own to the criteria, and an ellipsoid as large as numbers allow is not all states:
# s^2 + 4 s + 2, s^2 + s + 1/2 and, beside tanh, s + 1.  With 0 sigma s^2 - s + 1 stays, and with sigma/3 s^2 + 4 s/3.
@pytest.mark.parametrize(
    ("plant", "law", "everywhere"),
    [
        (([[0, 1], [1, 0]], [0, 1], [3, 4], 0), "sigma", True),
        (([[0, 1], [-1, -1]], [0, 1], [1, 0], 0), "-sigma/2", True),
        (([[-1, 0], [0, 1]], [[1, 0], [0, 1]], [[1, 0], [0, 1]], 0), ["tanh(sigma)", "2*sigma"], True),
        (([1], [1, -1, 1]), "0*sigma", False),
        (([[0, 1], [1, 0]], [0, 1], [3, 4], 0), "sigma/3", False),
    ],
)
def test_a_line_that_stabilises_does_so_from_everywhere(plant, law, everywhere):
    found = region(as_plant(plant), law)
    assert (found.area[0] == math.inf) is everywhere
    if everywhere:
        assert recheck(found.proof.certificate).accepted
        assert isinstance(check(found.proof.certificate), Proved)
    else:
        assert found.sets == ()


# V = int phi + y^2/2 for x' = y, y' = -phi(x + y): V' = -phi^2.  With H = (s + 1)(s + 2)/(s^2 (s + 4)) it is s H that
# has a positive real part, (omega^4 + 10 omega^2)/|s (s + 4)|^2; with (s + 1)/(s^2 (s + 5)) it is 4/|s + 5|^2, which
# has the limit 0: V falls by the square of a state that a solution keeps at 0 only if phi = 0.  With 1/2 for 5 large
# gains leave roots on the right.  For a force along the speed of an oscillator x^2 + y^2 falls by 2 y phi.  A dead zone
# leaves what is in it at rest, a triple integrator is unstable for small gains, and a hidden state rests: nothing is
# said of these.
@pytest.mark.slow_for("plant9-sigma/(1 + sigma**2)-False")
@pytest.mark.parametrize(
    ("plant", "law", "everywhere"),
    [
        (([1, 1], [1, 0, 0]), Saturation(), True),
        (([1, 1], [1, 0, 0]), Saturation(gain=2, limit=1, lower_limit=-3), True),
        (([1, 1], [1, 0, 0]), Cubic(cubic=1), True),
        (([1, 3, 2], [1, 4, 0, 0]), Saturation(), True),
        (([1, 1], [1, 5, 0, 0]), Saturation(), True),
        (([1, 2, 1], [1, 7, 11, 0, 0]), Tanh(), True),
        (([1, 1], [1, 0.5, 0, 0]), Saturation(), False),
        (([1, 0], [1, 0, 4]), Saturation(), True),
        (([1, 1], [1, 0, 0]), Tanh(), True),
        (([1, 1], [1, 0, 0]), "sigma/(1 + sigma**2)", False),  # which falls beyond 1
        (([1, 1], [1, 0, 0]), DeadZone(), False),
        (([1, 3, 3], [1, 0, 0, 0]), Saturation(), False),
        (([[0, 1, 0], [0, 0, 0], [0, 0, 0]], [0, 1, 0], [1, 1, 0], 0), Saturation(), False),
    ],
)
def test_a_saturated_double_integrator_recovers_from_everywhere(plant, law, everywhere):
    found = region(as_plant(plant), law)
    assert (found.area[0] == math.inf) is everywhere
    if everywhere:
        proof = found.sets[0].proof
        assert (found.sets[0].kind, proof.theorem) == ("everything", "global-popov")
        assert isinstance(check(json.dumps(dict(proof.certificate)), draft=True), Proved)
        assert recheck(proof.certificate).accepted
        FORMAT.validate(json.loads(json.dumps(dict(proof.certificate))))


# x' = y, y' = -phi(x + y), theta = 1: P = diag(0, 1), -V' = 2 phi^2
GLOBAL = {
    "verdict": "PROVED",
    "system": {"kind": "multivariable", "time": "continuous", "A": [["0", "1"], ["0", "0"]], "B": [["0"], ["1"]]}
    | {"C": [["1", "1"]], "D": [["0"]]},
    "laws": {"graphs": [{"kind": "piecewise-polynomial", "cuts": ["-1", "1"], "pieces": [["-1"], ["0", "1"], ["1"]]}]},
    "theorem": "global-popov",
    "multiplier": {"lambda": ["0"], "theta": ["1"], "inverse": ["1"]},
    "proof": {"method": "everywhere", "P": [["0"], ["0", "1"]], "least": ["2"]},
}


@pytest.mark.parametrize(
    "change",
    [
        ("proof", "least", ["3"]),
        ("proof", "P", [["0"], ["0", "2"]]),
        ("proof", "P", [["-1"], ["0", "1"]]),
        ("multiplier", "theta", ["0"]),
        ("multiplier", "theta", ["-1"]),
        ("multiplier", "lambda", ["1/10"]),
        ("multiplier", "inverse", ["2"]),  # sigma phi < 2 phi^2
        ("system", "C", [["1", "-1"]]),
        ("system", "C", [["0", "1"]]),  # x is hidden
        ("system", "A", [["0", "1"], ["0", "1/10"]]),
        ("system", "D", [["1/10"]]),
        ("system", "time", "discrete"),
        # 0 up to 1/2, then a line; one that comes back to 0 at 2; of the other sign to the left; known up to 5 alone
        ("laws", "graphs", 0, "pieces", [["-1"], ["0"], ["1"]]),
        (
            "laws",
            "graphs",
            0,
            {"kind": "piecewise-polynomial", "cuts": ["0", "1/2"], "pieces": [["0", "1"], [], ["-1/2", "1"]]},
        ),
        (
            "laws",
            "graphs",
            0,
            {"kind": "piecewise-polynomial", "cuts": ["1", "2"], "pieces": [["0", "1"], ["2", "-1"], ["-2", "1"]]},
        ),
        ("laws", "graphs", 0, {"kind": "piecewise-polynomial", "cuts": ["0"], "pieces": [["0", "-1"], ["0", "1"]]}),
        (
            "laws",
            "graphs",
            0,
            {"kind": "piecewise-polynomial", "cuts": ["0", "1"], "pieces": [["0"], ["0", "1"], ["1"]]},
        ),
        ("laws", "graphs", 0, {"kind": "sector", "sector": ["0", "1"], "reach": "5"}),
        ("laws", "graphs", 0, {"kind": "sector", "sector": ["0", "1"], "reach": "0"}),
        ("laws", "graphs", 0, {"kind": "signed", "top": "2"}),  # of which phi/sigma may be 2
        ("laws", "graphs", 0, {"kind": "signed", "top": "-1"}),
        ("verdict", "REFUTED"),
    ],
)
def test_what_attracts_everything_is_accepted_as_it_is_and_changed_by_neither(change):
    any_of_them = complete_and_check(GLOBAL | {"laws": {"graphs": [{"kind": "signed", "top": "1"}]}}).certificate
    assert recheck(dict(any_of_them)).accepted
    assert_both_reject(edited(any_of_them, "theorem", value="local-circle"))
    good = complete_and_check(GLOBAL).certificate
    assert (good["conclusion"], recheck(dict(good)).accepted) == ("0 attracts every motion", True)
    *path, value = change
    assert_both_reject(edited(good, *path, value=value))


# (1 - s)/(s^2 + s + 1) oscillates with the gain 1: with x_1' = x_2 and V = 5/2 x_1^2 + x_1 x_2 + x_2^2 + int phi it is
# -V' = 2 phi (sigma - phi) + (phi - sigma)^2; for phi of at most sigma/2 there are 2 phi^2 to spare
def test_a_function_that_rests_while_phi_is_steepest_attracts_nothing():
    half = {"kind": "piecewise-polynomial", "cuts": ["-1", "1"], "pieces": [["-1/2"], ["0", "1/2"], ["1/2"]]}
    good = complete_and_check(
        GLOBAL
        | {
            "system": GLOBAL["system"] | {"A": [["0", "1"], ["-1", "-1"]], "C": [["1", "-1"]]},
            "laws": {"graphs": [half]},
            "multiplier": {"lambda": ["1"], "theta": ["1/2"], "inverse": ["2"]},
            "proof": {"method": "everywhere", "P": [["5/2"], ["1/2", "1"]], "least": ["2"]},
        }
    ).certificate
    assert recheck(dict(good)).accepted
    resting = edited(edited(good, "proof", "least", value=["0"]), "multiplier", "inverse", value=["1"])
    for graph in (half, *GLOBAL["laws"]["graphs"]):
        assert_both_reject(edited(resting, "laws", "graphs", 0, value=graph))


# x' = y, y' = -phi(x) keeps y^2/2 + int phi, alone and beside the loop above
def test_a_function_that_stays_the_same_along_solutions_attracts_nothing():
    good = complete_and_check(GLOBAL).certificate
    assert_both_reject(edited(edited(good, "system", "C", value=[["1", "0"]]), "proof", "least", value=["0"]))
    flow = [["0", "1", "0", "0"], ["0"] * 4, ["0", "0", "0", "1"], ["0"] * 4]
    system = good["system"] | {"A": flow, "B": [["0", "0"], ["1", "0"], ["0", "0"], ["0", "1"]]}
    two = GLOBAL | {
        "system": system | {"C": [["1", "1", "0", "0"], ["0", "0", "1", "1"]], "D": [["0", "0"]] * 2},
        "laws": {"graphs": GLOBAL["laws"]["graphs"] * 2},
        "multiplier": {"lambda": ["0"] * 2, "theta": ["1"] * 2, "inverse": ["1"] * 2},
        "proof": GLOBAL["proof"] | {"P": [["0"], ["0", "1"], ["0"] * 3, ["0", "0", "0", "1"]], "least": ["0"] * 2},
    }
    good = complete_and_check(two).certificate
    assert recheck(dict(good)).accepted
    assert_both_reject(edited(good, "system", "C", 1, value=["0", "0", "1", "0"]))


# x'' + x' = -phi(x): Popov's criterion with one pole at 0; NB = 1, and phi vanishes at 0 alone.
def test_in_the_critical_case_0_attracts_everything_where_it_is_the_only_equilibrium():
    plant = ([1], [1, 1, 0])
    for law in (Saturation(), Tanh(), Cubic(linear=1, cubic=1)):
        found = region(plant, law)
        assert found.sets[0].kind == "everything"
        assert "0 is the only one" in str(found) or found.proof.certificate["conclusion"] == "0 attracts every motion"
    assert region(([1], [1, 0]), Saturation()).lines() == [
        "PROVED: every solution tends to 0, wherever it starts."
    ]  # one state, by the signs


@pytest.mark.parametrize(
    ("plant", "law", "alone"),
    [
        (([[0, 1], [0, -1]], [0, 1], [1, 0], 0), Saturation(), True),
        (([[0, 1], [0, -1]], [0, 1], [1, 0], 0), DeadZone(width=1, gain=1), False),  # rests wherever |x1| <= 1
        (([[0, 1], [0, -1]], [0, 1], [1, 0], 0), Cubic(linear=1, cubic=-1), False),  # phi(1) = 0
        (([[0, 1], [0, -1]], [0, 1], [1, 0], 0), ReLU(), False),  # rests wherever x1 <= 0
        (([[0, 1], [0, -1]], [0, 1], [0, 1], 0), Saturation(), False),  # x1 is not seen
        (([[0, 1], [-1, -1]], [0, 1], [1, 0], 0), Saturation(), False),  # no pole at 0: not shown this way
    ],
)
def test_the_only_equilibrium_is_shown_exactly(plant, law, alone):
    A, B, C, _ = plant
    many = MultivariablePlant(rows(A), rows([[v] for v in B]), rows([C]), rows([[0]]))
    assert rests_at_0(many, [shape_of(law)]) is alone
