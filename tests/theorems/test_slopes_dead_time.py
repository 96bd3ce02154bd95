"""Park's and Zames-Falb multipliers with dead time: computed, then proved by covers that both checkers accept."""

from fractions import Fraction as F

import numpy as np
import pytest
from certificate_family import delayed, draft, nonlinearities

from lure.analysis import max_slope
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.covers import cover_proof
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second import recheck
from lure.analysis.theorems.dead_time import first_order_largest
from lure.analysis.theorems.kernels import multiplier_of
from lure.analysis.verdict import Evidence, Verdict
from lure.errors import AssumptionError
from lure.plants.delay import DelayPlant

SERVO = "exp(-s/5)/(s*(s^2+0.4*s+4))"
OSCILLATOR = delayed([("1", "1")], "1 1/5 4")
PAIR = {"theta": "-4/25", "tau": "0"}
KERNELS = (
    [{"coefficient": "1/2", "delay": "-1/4"}],
    [{"coefficient": "9/10", "rate": "4", "order": 5, "side": "causal"}],
)


# linear gains: Im H = 0 at 4 w - w^3 = .4 w^2 cot(w/5), w = 1.7854.., and k = -1/Re H there = 1.5917841
def test_park_reaches_the_linear_gains_of_a_servo_with_dead_time():
    found = max_slope(SERVO)
    assert (found.criterion, found.verdict, found.evidence) == ("park", Verdict.PROVED, Evidence.CERTIFIED)
    assert found.hurwitz.low * (1 - 1e-6) < found.largest.low < found.hurwitz.low < found.refuted_at
    assert str(found).startswith(
        "Every solution converges to the set of equilibria for every phi with slope in [0, 1.59"
    )
    popov = next(answer for answer in found.answers if answer.criterion == "popov")
    assert popov.largest.high < 1.581
    assert recheck(found.proof.certificate).accepted


def test_what_is_computed_is_no_proof_before_the_checkers_have_seen_it():
    answer = first_order_largest(DelayPlant.parse(SERVO))
    assert (answer.verdict, answer.evidence) == (Verdict.INCONCLUSIVE, Evidence.COMPUTED)
    assert answer.proof is None


def late(k, name="park", given=PAIR, system=OSCILLATOR, odd=False):
    """The draft of a certificate, with a cover if one is found."""
    made = draft(system, nonlinearities(0, k, slope=True, odd=odd), name, given)
    return {**made, "proof": cover_proof(made)}


# exp(-s)/(s^2 + s/5 + 4): circle and Popov with theta >= 0 end at .41238, linear gains at .42348; theta < 0 serves
@pytest.mark.parametrize(("k", "good"), [("42/100", True), ("4236/10000", False)])
def test_a_multiplier_and_its_limit_are_seen_alike(k, good):
    shown = complete_and_check(late("42/100")).certificate
    given = {**shown, "laws": nonlinearities(0, k, slope=True)}
    assert recheck(given).accepted is good
    if not good:
        with pytest.raises(Rejected, match="not shown on the box"):
            complete_and_check(given)


# the left-hand side, evaluated another way: at many frequencies in doubles
@pytest.mark.parametrize(("theta", "kernels"), [("0", KERNELS[0]), ("-1/2", KERNELS[1])])
def test_kernels_hold_where_they_are_sampled(theta, kernels):
    shown = complete_and_check(late("42/100", "zames-falb", {"theta": theta, "kernels": kernels})).certificate
    assert recheck(shown).accepted
    assert shown["conclusion"].endswith("with inputs to the block and initial functions of finite energy")
    used, omega = multiplier_of(shown["multiplier"]), np.geomspace(1e-4, 1e4, 40_001)
    H = DelayPlant.parse("exp(-s)/(s^2 + s/5 + 4)").transfer(1j * omega)
    assert (used.at(omega) * (H + 1 / 0.42) + 1j * omega * float(used.theta) * H).real.min() > 0


@pytest.mark.thorough
def test_kernels_with_delays_reach_the_linear_gains():
    found = max_slope("s^2*exp(-s/10)/(s^4+0.2*s^3+6*s^2+0.1*s+1)")
    assert found.criterion == "zames-falb"
    assert found.hurwitz.low * (1 - 1e-6) < found.largest.low < found.hurwitz.low
    assert recheck(found.proof.certificate).accepted


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"theorem": "off-axis-circle", "multiplier": {"alpha": "1/2"}}, "does not cover dead time"),
        ({"multiplier": {"theta": "-4/25", "tau": "-6"}}, "tau < 0"),
        ({"laws": nonlinearities("-1/10", "1/5", slope=True)}, "begin at 0"),
        ({"laws": nonlinearities(0, "42/100", slope=True, time_varying=True)}, "do not depend on time"),
        ({"laws": nonlinearities(0, "42/100")}, "infinite"),
        ({"system": delayed([("1", "1")], "1 -1/5 4")}, "not strictly inside"),
        ({"system": delayed([("1", "1 0 0")], "1 1/5 4")}, "strictly proper"),
        (
            {"theorem": "zames-falb", "multiplier": {"theta": "0", "kernels": [{"coefficient": "-1/2", "delay": "1"}]}},
            "odd",
        ),
    ],
)
def test_a_hypothesis_that_fails_is_seen_by_both(changes, reason):
    shown = complete_and_check(late("42/100")).certificate
    with pytest.raises((Rejected, ValueError), match=reason):
        complete_and_check({**shown, **changes})
    assert not recheck({**shown, **changes}).accepted


def test_the_classes_begin_at_zero_with_dead_time():
    with pytest.raises(AssumptionError, match="begin at 0"):
        first_order_largest(DelayPlant.parse(SERVO), lower=F(1))
