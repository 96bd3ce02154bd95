"""Park's and Zames-Falb multipliers with dead time: computed, then proved by covers that both checkers accept."""

from fractions import Fraction as F

import numpy as np
import pytest
from certificate_family import delayed, draft, nonlinearities
from tampering import assert_both_reject, refused_again

from lure import NonlinearityClass, SlopeBounds
from lure.analysis import certify, max_slope
from lure.analysis.certificates.arithmetic import Rejected, real
from lure.analysis.certificates.balls import right_zeros
from lure.analysis.certificates.blocks import block, shifted
from lure.analysis.certificates.covers import cover_proof
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second import recheck
from lure.analysis.certificates.second.numerics import right_zeros as second_zeros
from lure.analysis.certificates.second.numerics import working_precision
from lure.analysis.certificates.second.systems import read_system
from lure.analysis.certificates.second.systems import shifted as theirs
from lure.analysis.questions.counterexample_search import linear_witnesses
from lure.analysis.questions.problem import Problem
from lure.analysis.theorems.dead_time import first_order_largest
from lure.analysis.theorems.kernels import multiplier_of
from lure.analysis.verdict import Bracket, Evidence, Verdict
from lure.plants.delay import DelayPlant

SERVO = "exp(-s/5)/(s*(s^2+0.4*s+4))"
OSCILLATOR = delayed([("1", "1")], "1 1/5 4")
PAIR = {"theta": "-4/25", "tau": "0"}
KERNELS = (
    [{"coefficient": "1/2", "delay": "-1/4"}],
    [{"coefficient": "9/10", "rate": "4", "order": 5, "side": "causal"}],
)


# linear gains: Im H = 0 at 4 w - w^3 = .4 w^2 cot(w/5), w = 1.7854.., and k = -1/Re H there = 1.5917841
@pytest.mark.slow
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


# exp(-s)/(s^2 + s/5 + 4): the circle criterion ends at .41238, linear gains at .42348; theta < 0 serves
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
        ({"laws": nonlinearities("-5", "1/5", slope=True)}, "root with Re s > 0"),
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
    assert refused_again({**shown, **changes})


BELOW = "exp(-s)/(s^2 + 2/5*s + 4 + exp(-s/2)/2)"
# chi = s (s + 1 + exp(-s)), times exp(s/2) at i w: k = w^2 cos(w/2) where w tan(w/2) = 2, w = 1.720667178
AT_REST = "exp(-s/2)/(s^2 + s + s*exp(-s))"


@pytest.fixture(scope="module")
def below():
    """What is proved of two plants with dead time in the denominator by Park's multiplier."""
    return {text: max_slope(text, criterion="park") for text in (BELOW, AT_REST)}


# the linear gain of the first: Im H = 0 = Re H + 1/k at w = 2.168; the circle criterion ends at .41210
@pytest.mark.slow_for("exp(-s)/(s^2 + 2/5*s + 4 + exp")
@pytest.mark.parametrize(("text", "end"), [(BELOW, 0.42695309441), (AT_REST, 1.93092010569)])
def test_park_reaches_the_linear_gains_with_dead_time_in_the_denominator(below, text, end):
    found = below[text]
    assert found.verdict is Verdict.PROVED
    assert end * (1 - 1e-6) < found.largest.low < end < found.refuted_at * (1 + 1e-9) < end * (1 + 1e-8)
    assert found.critical is (text == AT_REST)
    for shown in (found.proof, found.refutation):
        assert recheck(shown.certificate).accepted


@pytest.mark.parametrize("text", [BELOW, AT_REST])
def test_a_changed_number_below_is_seen_by_both(below, text):
    shown = below[text].proof.certificate
    system, boxes = shown["system"], shown["proof"]["boxes"][1:]
    ((wait, q),) = system["feedback"]
    changes = [
        {"system": {**system, "feedback": [[wait, [*q[:-1], str(F(q[-1]) + 9)]]]}},
        {"system": {**system, "feedback": [[str(8 * F(wait)), q]]}},
        {"system": {**system, "feedback": [["0", q]]}},
        {"system": {**system, "feedback": []}},
        {"system": {**system, "feedback": [[wait, ["1", "0", *q]]]}},
        {"system": {**system, "terms": [[wait, ["9"]]]}},
        {"laws": nonlinearities(0, "2", slope=True)},
        {"multiplier": {"theta": "9", "tau": "0"}},
        {"proof": {**shown["proof"], "boxes": boxes}},
    ]
    for change in changes:
        with pytest.raises((Rejected, ValueError)):
            complete_and_check({**shown, **change})
        assert refused_again({**shown, **change})


# -exp(-s)/(s + 1): k = 1 at 0, where Re H is least only with theta < 0; exp(-s)/s: theta > 0 up to pi/2
@pytest.mark.parametrize(
    ("numerator", "denominator", "theta", "good"), [("-1", "1 1", "-3/4", True), ("1", "1 0", "-1/100", False)]
)
def test_theta_below_0_is_for_plants_without_a_pole_at_0(numerator, denominator, theta, good):
    made = draft(delayed([("1", numerator)], denominator), nonlinearities(0, "1/2"), "popov", {"theta": "0"})
    made = {**made, "multiplier": {"theta": theta if good else "1"}}
    shown = complete_and_check({**made, "proof": cover_proof(made)}).certificate
    assert recheck(shown).accepted
    turned = {**shown, "multiplier": {"theta": theta}}
    assert recheck(turned).accepted is good
    if not good:
        with pytest.raises(Rejected, match="theta >= 0 is needed"):
            complete_and_check(turned)


# s + K exp(-s) has 2 zeros to the right for K between pi/2 and 5 pi/2, none below; s - 1 + K exp(-s/10) has 1 for K < 1
# and none just beyond; s + 1 - exp(-s) is 0 at 0, where its slope is 2, and s - 2 + 2 exp(-s) at 0 and at 1.594
@pytest.mark.parametrize(
    ("d", "wait", "q", "pole", "zeros"),
    [
        ("1 0", "1", "3/2", False, 0),
        ("1 0", "1", "2", False, 2),
        ("-1 1", "1/10", "-1/2", False, 1),
        ("-1 1", "1/10", "-2", False, 0),
        ("1 0 0", "1", "3/2 0", True, 0),
        ("1 0 0", "1", "2 0", True, 2),
        ("1 1", "1", "-1", True, 0),
        ("1 -2", "1", "2", True, 1),
        ("1 3 0 0", "1/3", "2 0 0", False, None),
    ],
)
def test_zeros_of_a_denominator_with_dead_time_are_counted_by_both(d, wait, q, pole, zeros):
    system = {"kind": "delay", "terms": [["0", ["1"]]], "denominator": d.split(), "feedback": [[wait, q.split()]]}
    B, ours = block(system), read_system(system)
    turned = B.d if F(d.split()[0]) > 0 else B.d * real(-1)
    if zeros is None:  # a double root at 0
        for count in (lambda: shifted(B, F(0)), lambda: theirs(ours, F(0))):
            with pytest.raises(ValueError, match=r"root|pole"):
                count()
        return
    assert right_zeros(turned, B.order, pole)[0] == zeros
    with working_precision(192):
        assert second_zeros(B.order - pole, ours.turn, ours.closer) == zeros


@pytest.mark.parametrize("top", ["1", "-1"])
def test_the_residue_is_that_of_the_whole_denominator(top):
    # (s + 1 - exp(-s))' = 2 at 0
    system = {"kind": "delay", "terms": [["1", [top]]], "denominator": ["1", "1"], "feedback": [["1", ["-1"]]]}
    if top == "1":
        assert "residue 1/2 > 0" in shifted(block(system), F(0))[2]
        assert theirs(read_system(system), F(0)).case == "critical"
        return
    for count in (lambda: shifted(block(system), F(0)), lambda: theirs(read_system(system), F(0))):
        with pytest.raises(ValueError, match="residue"):
            count()


def above(low, high, name, given, system):
    """The draft of a certificate of slopes above a lower one, with a cover if one is found."""
    made = draft(system, nonlinearities(low, high, slope=True), name, given)
    return {**made, "proof": cover_proof(made)}


# exp(-s)/(s^2 + s/5 + 4 + l exp(-s)), whose linear gains end at .42348 - l; and exp(-s/2)/(s - 1 + exp(-s/2)) of the
# residue 2: (s + exp(-s/2))' = 1/2 at 0.  Its linear gains end at w/sin(w/2) = 2.5365, w = tan(w/2) = 2.33112
UNSTABLE = delayed([("1/2", "1")], "1 -1")


@pytest.mark.parametrize(
    ("low", "high", "name", "given", "system", "ends"),
    [
        ("1/10", "42/100", "park", PAIR, OSCILLATOR, "energy"),
        ("-1/10", "42/100", "zames-falb", {"theta": "-4/25", "kernels": []}, OSCILLATOR, "energy"),
        ("1", "5/2", "popov", {"theta": "1/2"}, UNSTABLE, "equilibria"),
        ("11/10", "5/2", "popov", {"theta": "1/2"}, UNSTABLE, "energy"),
    ],
)
def test_slopes_may_begin_where_the_loop_is_stable(low, high, name, given, system, ends):
    shown = complete_and_check(above(low, high, name, given, system)).certificate
    assert shown["conclusion"].endswith(ends)
    assert recheck(shown).accepted
    for sides in (("-5", high), (low, "13/5")):  # the lower gain destabilises; the upper one does
        assert_both_reject({**shown, "laws": nonlinearities(*sides, slope=True)})
    if ends == "equilibria":  # with a pole at 0 after the shift
        assert_both_reject({**shown, "multiplier": {"theta": "-1/100"}})
        assert_both_reject({**shown, "laws": nonlinearities("99/100", high, slope=True)})


# |exp(-s)/(s + 1)| <= 1, so that slopes within [-1/2, 1] are proved by the small gain theorem after a shift by 1/4;
# exp(-s/10)/(s - 1) is stable for gains from 1 to about 15
@pytest.mark.parametrize(
    ("text", "asked"),
    [
        ("exp(-s)/(s + 1)", SlopeBounds(-0.5, 1)),
        ("exp(-s)/(s + 1)", NonlinearityClass.constant_gain(-0.5, 2)),
        ("exp(-s/10)/(s - 1)", SlopeBounds(1.5, 4)),
    ],
)
def test_one_class_is_asked_of_the_criteria_from_its_own_lower_bound_on(text, asked):
    found = certify(text, asked)
    assert found.verdict is Verdict.PROVED
    assert recheck(found.certificate).accepted


def test_the_time_allowed_holds_while_roots_at_the_lower_end_are_counted():
    assert max_slope("exp(-1000000*s)/(s+1)", lower=F(3, 10), seconds=0.05).stopped == "time"


def test_a_linear_gain_is_named_by_where_a_root_was_found():
    # between 0 and it nothing is known; tan(w) = -w, k = sqrt(1 + w^2)
    (one,) = linear_witnesses(
        Problem.largest(DelayPlant.parse("exp(-s)/(s+1)"), "sector", lower=F(0)), Bracket(0, 2.2618263341)
    )
    assert one.description.startswith("a linear gain of about 2.26182634 puts")
