"""Forms of several samples beside a pole at z = 1: loops with known answers, and what both checkers reject."""

import json
import math
import random
from fractions import Fraction as F

import numpy as np
import pytest
from tampering import assert_both_reject, edited

from lure import NonlinearityClass, Sector, SlopeBounds, as_plant
from lure.analysis import certify, max_sector, max_slope
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.channels import within
from lure.analysis.certificates.checker import Proved, check
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.questions.channel_proofs import Criterion, proved_whole, searches
from lure.analysis.questions.problem import Problem
from lure.analysis.theorems.table import TABLE
from lure.classes import Diagonal
from lure.plants.multivariable import MultivariablePlant

CONVERGES = "every motion converges to the set of equilibria"
SLOPE, ODD, RELU = (
    NonlinearityClass.slope_restricted(0, 1),
    NonlinearityClass.slope_restricted(0, 1, odd=True),
    NonlinearityClass.relu(),
)
# Example 6 with an integrator: monotone nonlinearities .8845829 by Zames and Falb's multipliers, and an exact periodic
# solution from .8845837 on (one channel); odd ones as far as constant gains, 1.0713693
LEARNING = "(2*z + 0.92)/(z^2 - z/2) + 1/(10*(z - 1))"
# a double pole at 9/10 with an integrator: the limit is that of gains, 18.97503; the circle criterion ends at .77795
SLOW = "z/(10*(z^2 - 9*z/5 + 81/100)) + 1/(20*(z - 1))"


def beside(*transfers):
    m = len(transfers)
    return as_plant([[transfers[i] if i == j else "0" for j in range(m)] for i in range(m)], dt=1)


def scaled(plant, ratio):
    """The second input and output in other units: slopes [0, k] stay what they are."""
    A, B, C, D = (np.array(side, dtype=object) for side in (plant.A, plant.B, plant.C, plant.D))
    by = np.array([F(1), ratio], dtype=object)
    return MultivariablePlant(*(side.tolist() for side in (A, B / by, C * by[:, None], D)), dt=1)


WINDOWS = Criterion("coupled-windows", next(row for row in TABLE if "coupled-windows" in row.channels))


def by_windows(plant, classes):
    if not isinstance(plant, MultivariablePlant):
        plant = MultivariablePlant.of_one_channel(plant)
    return proved_whole(Problem(plant=plant, classes=classes, kind="class"), WINDOWS)


def twice_accepted(shown):
    certificate = dict(shown.certificate)
    assert certificate["conclusion"] == CONVERGES
    assert isinstance(check(certificate), Proved)
    assert recheck(certificate).accepted
    return certificate


@pytest.fixture(scope="module")
def slow():
    return max_slope(beside(SLOW, SLOW), [SLOPE, SLOPE], criterion="coupled-windows")


@pytest.fixture(scope="module")
def relu():
    return max_sector(beside(LEARNING, "3/(10*(z - 1/2))"), [RELU, SLOPE])


@pytest.mark.slow_for("ratio1")
@pytest.mark.parametrize("ratio", [F(1), F(7, 3)])
def test_loops_beside_each_other_reach_as_far_as_alone(slow, ratio):
    named = {"criterion": "coupled-windows"}
    found = slow if ratio == 1 else max_slope(scaled(beside(SLOW, LEARNING), ratio), [ODD, ODD], **named)
    limit = 18.97503285 if ratio == 1 else 1.07136931
    assert limit * (1 - 1e-5) < found.largest.low < limit
    assert found.refuted_at == pytest.approx(limit, rel=1e-6)
    assert found.criterion == "coupled-windows"
    assert found.critical
    twice_accepted(found.proof)


def test_monotone_nonlinearities_reach_less_than_odd_ones():
    plant = beside("3/(10*(z - 1/2))", LEARNING)
    within, beyond = (Diagonal((NonlinearityClass.slope_restricted(0, k),) * 2) for k in (F("0.8845"), F("0.8846")))
    twice_accepted(by_windows(plant, within))
    assert by_windows(plant, beyond) is None  # from .8845837 on a periodic solution refutes


# With D H D^-1 for H the residue is no longer symmetric: the weights are prescribed, 4 for the second channel to 1
@pytest.mark.parametrize(("over", "under"), [("0.1", "0.1"), ("0.2", "0.05")])
@pytest.mark.parametrize(("k", "proved"), [(F("0.844"), True), (F("0.845"), False)])
def test_integrators_between_channels_prescribe_the_ratios(over, under, k, proved):
    learning, coupled = "(2*z + 0.92)/(z^2 - z/2)", [["0.2", over], [under, "0.1"]]
    rows = [
        [f"{gain}/(z - 1)" + f" + {learning}" * (i == j) for j, gain in enumerate(row)] for i, row in enumerate(coupled)
    ]
    asked = Diagonal((NonlinearityClass.slope_restricted(0, k),) * 2)
    assert (by_windows(as_plant(rows, dt=1), asked) is not None) is proved


@pytest.mark.parametrize("same", [False, True])
def test_one_nonlinearity_in_both_channels_has_more_multipliers(same):
    plant = as_plant([[LEARNING, "0.05/(z - 1/2)"], ["-0.05/(z - 1/2)", LEARNING]], dt=1)
    asked = Diagonal((NonlinearityClass.slope_restricted(0, F("0.856")),) * 2, repeated=same)  # .8534 and .8577
    assert (by_windows(plant, asked) is not None) is same


@pytest.mark.slow
def test_rectifiers_beside_an_integrator_have_a_form_at_the_start(relu):
    # the second channel alone: 3/10 k < 1 + 1/2, for gains of all; a ReLU is none
    assert relu.largest.low == pytest.approx(5, rel=1e-5)
    assert relu.largest.low < 5
    assert twice_accepted(relu.proof)["multiplier"]["start"] is not None


def test_a_rectifier_beside_integrators_alone_is_proved_beyond_its_sector():
    # x+ = x - 3 max(x, 0): from x > 0 to -2 x, where it rests; a function of the sector [0, 3] is proved up to 2
    found = certify(as_plant("1/(z - 1)", dt=1), [NonlinearityClass.relu(0, 3)])
    assert twice_accepted(found.shown)["theorem"] == "coupled-windows"


def test_lower_bounds_are_taken_out_first():
    # LEARNING as states, and A + B C/10 for A: with the gain 1/10 it is LEARNING again
    A, B, C = (F("0.5"), 0, 0), (1, 0, 1), (2, F("0.92"), F("0.1"))
    rows = [
        [v + F(b * c) / 10 for v, c in zip(row, C, strict=True)]
        for row, b in zip((A, (1, 0, 0), (0, 0, 1)), B, strict=True)
    ]
    plant = MultivariablePlant(rows, [[b] for b in B], [C], [[0]], dt=1)
    below, beyond = (NonlinearityClass.slope_restricted(F(1, 10), k) for k in (F("0.984"), F("0.985")))  # .88458 above
    assert twice_accepted(by_windows(plant, Diagonal((below,))))["proof"]["zero"][0][-1] != "0"
    assert by_windows(plant, Diagonal((beyond,))) is None


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("proof", "zero", 0, 0), "2"),
        (("proof", "zero"), []),
        (("proof", "zero"), lambda rows: rows[:1]),
        (("proof", "zero"), lambda rows: [*rows, rows[0]]),
        (("proof", "zero", 0, -1), "1"),
        (("proof", "P", 0, 0), lambda v: str(int(v) + 1)),
        (("multiplier", "forms", 0, "rows", 0, 0), lambda v: str(F(v) + F(1, 10**9))),
        (("multiplier", "forms", 0, "kind"), "sector"),
        (("laws", "channels", 0, "time_varying"), True),
        (("laws", "channels", 0, "slope"), None),
        (("system", "C", 0, 0), lambda v: str(F(v) + F(1, 10**9))),
        (("proof",), lambda proof: {key: value for key, value in proof.items() if key != "zero"}),
    ],
)
def test_a_proof_that_was_tampered_with_is_rejected_by_both(slow, path, value):
    assert_both_reject(edited(slow.proof.certificate, *path, value=value))


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("multiplier", "start"), None),
        (("multiplier", "start", 0, "rows", 0, 0), lambda v: str(F(v) + 10**60)),
        (("proof", "zero", 0, 0), "2"),
        (("laws", "channels", 0, "relu"), False),
    ],
)
def test_a_proof_for_a_rectifier_that_was_tampered_with_is_rejected_by_both(relu, path, value):
    assert_both_reject(edited(relu.proof.certificate, *path, value=value))


# x+ = x - phi(-x) grows for every gain, and yet M = 1 - z serves: Re (1 - z)(1 + H) = 1 + Re(1 - z) > 0.  As forms,
# 2 phi_1 (v_1 - v_2) = -4 phi_1^2 + 2 phi_1 phi_2, which less 2 phi_2^2 - 2 phi_1^2 is negative; M(1) = 0, and V = 0 at
# the equilibria.  With a little of the circle criterion, c u_1 v_1, beside it V = -c x^2 - 2 phi_1^2.
@pytest.mark.parametrize("circle", [0, 1])
def test_a_multiplier_that_does_not_see_the_sign_of_the_residue_is_rejected(circle):
    stable = MultivariablePlant([[F(1, 2)]], [[1]], [[1]], [[0]], dt=1)
    rows = [[str(10 + circle), "-10"], ["0", "0"]]
    certificate = {
        **dict(certify(stable, [SLOPE]).shown.certificate),
        "system": {
            **{"kind": "multivariable", "time": "discrete"},
            **{"A": [["1"]], "B": [["1"]], "C": [["-1"]], "D": [["0"]]},
        },
        "theorem": "coupled-windows",
        "conclusion": CONVERGES,
        "multiplier": {
            **{"samples": 2, "start": None},
            "forms": [{"kind": "monotone", "channels": [1], "rows": rows}],
        },
        "proof": {
            **{"method": "matrix", "exponent": 0, "zero": [["1", "0"]]},
            "P": [[str(-circle)], ["0", "-20"]],
        },
    }
    with pytest.raises(Rejected, match="V > 0 fails at an equilibrium"):
        check(certificate)
    assert_both_reject(certificate)


# Forms summed over time are proposed with P of either sign, for loops that are unstable and functions that fall, too
@pytest.mark.parametrize(
    ("other", "second", "failure"),
    [
        ("1/(z - 2)", NonlinearityClass.slope_restricted(0, F(1, 10)), "the loop with the least slopes is not stable"),
        ("1/(z - 1/2)", NonlinearityClass(sector=Sector(0, F(1, 10))), "channel 2 has no lower bound of its slope"),
    ],
)
def test_what_else_the_summed_forms_need(other, second, failure):
    asked = Problem(
        plant=beside(SLOW, other),
        classes=Diagonal((NonlinearityClass.slope_restricted(0, F(1, 10)), second)),
        kind="class",
    )
    search = next(searches(asked, WINDOWS))
    one = next(search.proposals([F(1, 10)] * 2, [F(0)] * 2))
    certificate = {
        **dict(by_windows(beside(SLOW), Diagonal((NonlinearityClass.slope_restricted(0, 1),))).certificate),
        **{"system": dict(asked.system), "laws": dict(asked.class_entry)},
        **{"multiplier": one.multiplier, "proof": one.proof},
    }
    with pytest.raises(Rejected, match=failure):
        check(json.loads(json.dumps(certificate)), draft=True)
    assert_both_reject(certificate)


# Tsypkin's criterion ends at 2.98764 for SLOW alone, more taps go farther; of forms of v V > 0 at rest says nothing
def test_functions_that_ascend_have_taps_and_others_have_none():
    plant = beside(SLOW, SLOW)
    for slope, shown in (((0, math.inf), True), ((-math.inf, F("3.6")), False)):
        one = NonlinearityClass(sector=Sector(0, F("3.6")), slope=SlopeBounds(*slope))
        found = by_windows(plant, Diagonal((one,) * 2))
        assert (found is not None) is shown
        if found is not None:
            certificate = twice_accepted(found)
            kinds = [one["kind"] for one in certificate["multiplier"]["forms"]]
            assert kinds == ["sector", "rising", "sector", "rising"]
            low = edited(certificate, "laws", "channels", 0, "slope", value=["-1/10", "inf"])
            assert_both_reject(low)


def test_eigenvalues_are_divided_out():
    assert within([[F(1), F(0)], [F(0), F(1, 2)]], True, 1)
    assert not within([[F(1), F(0)], [F(0), F(1, 2)]], True, 2)
    assert not within([[F(1), F(1)], [F(0), F(1)]], True, 1)
    assert within([[F(0), F(0)], [F(0), F(-1)]], False, 1)


def member(seed, slope, odd):
    """A nonlinearity through 0 with slopes between 0 and a number, in pieces, some of them flat."""
    random.seed(seed)
    steps = [(10 ** random.uniform(-2, 1), random.choice([0, slope, random.uniform(0, slope)])) for _ in range(8)]
    x = np.concatenate([[0.0], np.cumsum([a for a, _ in steps])])
    up, down = (np.concatenate([[0.0], np.cumsum([a * b for a, b in one])]) for one in (steps, steps[::-1]))
    down = up if odd else down
    left = x if odd else np.concatenate([[0.0], np.cumsum([a for a, _ in steps[::-1]])])
    return lambda s: np.where(s >= 0, np.interp(s, x, up), -np.interp(-s, left, down))


@pytest.mark.parametrize("seed", range(6))
def test_solutions_with_random_members_come_to_rest(slow, seed):
    plant, k, rng = beside(SLOW, SLOW), slow.largest.low, np.random.default_rng(seed)
    A, B, C = (np.array(side, dtype=float) for side in (plant.A, plant.B, plant.C))
    laws, x = [member(10 * seed + i, 0.98 * k, odd=bool(seed % 2)) for i in range(2)], rng.normal(size=len(A))
    for _ in range(4000):
        before, x = x, A @ x - B @ [law(s) for law, s in zip(laws, C @ x, strict=True)]
    assert np.abs(x - before).max() < 1e-3
