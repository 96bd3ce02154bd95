"""Known dead times in several channels: both sides of the largest factor, and what is refused."""

from fractions import Fraction

import numpy as np
import pytest
from tampering import assert_both_reject, edited, refused_again

from lure import (
    AssumptionError,
    Diagonal,
    InputError,
    NonlinearityClass,
    Sector,
    SlopeBounds,
    as_plant,
    certify,
    lft,
    max_sector,
)
from lure.analysis import analyse, l2_gain, region, steady_response
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.questions.channel_pieces import PiecewiseProofs
from lure.analysis.questions.channel_problem import channel_problem
from lure.analysis.questions.channel_refutations import constant_gains, late_gains_refuting, refutation
from lure.analysis.questions.energy import energy_bounds
from lure.files import find_system
from lure.files.loop import loop_to_toml
from lure.plants.delay_matrix import DelayMatrix

LAGS = as_plant([["1/(s+1)", "0"], ["0", "exp(-s)/(s+2)"]])
UNIT = [Sector(0, 1)] * 2


@pytest.mark.slow
def test_without_coupling_it_is_the_channel_with_the_dead_time():
    # tan(w) = -w/2 at w = 2.288930, and k = sqrt(4 + w^2) = 3.0396051224123709: Popov's criterion reaches it
    found, whole = max_sector(LAGS, UNIT), max_sector(LAGS, UNIT, criterion="popov")
    assert 3.039605 < found.largest.low < 3.0396051224123709 < found.refuted_at < 3.0396052
    assert 3.0395 < whole.largest.low < 3.0396051224123709 < whole.refuted_at < 3.03961
    assert (found.criterion, whole.criterion, whole.witness.kind) == ("parts", "piecewise-popov", "linear gains")


@pytest.mark.slow
def test_time_varying_sectors_are_proved_by_the_circle_criterion_alone():
    # min Re exp(-i w)/(i w + 2) = -.335791 at w = 2.5206, on a grid of 1e-4
    found = max_sector(LAGS, [NonlinearityClass(sector=Sector(0, 1), time_varying=True)] * 2, criterion="circle")
    assert found.criterion == "piecewise-circle"
    assert found.largest.low == pytest.approx(2.97804, rel=1e-4)


@pytest.mark.slow
def test_rectifiers_beside_dead_time_are_functions_of_a_sector_to_both_checkers():
    plant = as_plant([["exp(-s/5)/(s+2)", "1/(s+1)"], ["-1/(s+3)", "1/(s+2)"]])
    shown = certify(plant, [NonlinearityClass.relu(), Sector(0, 1)]).shown
    assert recheck(dict(shown.certificate)).accepted
    refuted = certify(plant, [Sector(0, 50), Sector(0, 50)]).shown.certificate
    relu = refuted["laws"]["channels"][0] | {"relu": True, "slope": refuted["laws"]["channels"][0]["sector"]}
    assert_both_reject(edited(refuted, "laws", "channels", 0, value=relu))  # no gain is one


@pytest.mark.slow
def test_an_integrator_with_dead_time_converges_up_to_its_crossing():
    # i w + k exp(-i w) = 0 at w = k = pi/2
    found = max_sector(as_plant([["exp(-s)/s", "0"], ["0", "1/(s+1)"]]), UNIT)
    assert 1.5707 < found.largest.low < np.pi / 2 < found.refuted_at < 1.5708
    assert str(found).startswith("Every solution converges to the set of equilibria")


@pytest.mark.slow
def test_sectors_around_0_and_constant_gains():
    # |exp(-s)/(s+1)| <= 1 with 1 at 0: operators and sectors up to 1; gains in [-a/2, a] up to the crossing 2.2618
    one = as_plant([["exp(-s)/(s+1)", "0"], ["0", "exp(-2*s)/(s+1)"]])
    around = max_sector(one, [NonlinearityClass.norm_bounded(1)] * 2)
    assert around.largest.low == pytest.approx(1, rel=1e-3)
    single = as_plant([["exp(-s)/(s+1)", "0"], ["0", "1/(s+1)"]])
    gains = [NonlinearityClass.constant_gain(-0.1, 1), NonlinearityClass(sector=Sector(0, 1))]
    found = max_sector(single, gains)
    assert 2.2618 * 0.999 < found.largest.low < 2.26183


def test_a_gain_of_the_wrong_sign_moves_an_integrator_whatever_its_size():
    # s = r exp(-s) has a root s > 0 for every r > 0
    late, norm = [["exp(-s)/s", "0"], ["0", "1/(s+1)"]], NonlinearityClass.norm_bounded(0.5)
    found = max_sector(as_plant(late), [norm, Sector(0, 1)])
    assert (found.largest.low, found.verdict.name) == (0, "INCONCLUSIVE")
    assert found.refuted_at < 1e-5
    for rows, classes in (
        (late, [Sector(-1, 1), Sector(0, 1)]),
        ([["-1/s", "0"], ["0", "exp(-s)/(s+1)"]], UNIT),
        ([["1/(s-1)", "0"], ["0", "exp(-s)/(s+2)"]], UNIT),
        ([["1/s", "0"], ["0", "1/(s+1)"]], [norm, Sector(0, 1)]),
        ([["1/(z-1)"]], [norm]),
    ):
        shown = certify(as_plant(rows), classes)
        assert shown.verdict.name == "REFUTED"
        assert recheck(shown.certificate).accepted


def test_one_channel_with_dead_time_is_a_matrix_like_others():
    # |exp(-s)/(s+1)| <= 1 with 1 at 0
    found = max_sector("exp(-s)/(s+1)", [NonlinearityClass.norm_bounded(0.5)])
    assert 1.999 < found.largest.low < 2 < found.refuted_at < 2.0001
    assert "the gain about -1, within 2.000000004 times, destabilises" in str(found)
    assert certify("exp(-s)/s", [NonlinearityClass.norm_bounded(0.5)]).verdict.name == "REFUTED"
    with pytest.raises(InputError, match="the plant has dead time; with dead time the largest"):
        region("exp(-s)/(s+1)", [Sector(0, 1)])


@pytest.mark.slow
def test_lower_bounds_above_0_shift_the_loop():
    # i w + k exp(-i w) = 0 at k = pi/2; k exp(-s/5)/(s - 1): w = tan(w/5) = 7.16, k = sqrt(1 + w^2) = 7.22966
    for formula, low, end in (("exp(-s)/s", 0.5, np.pi / 2), ("exp(-s/5)/(s-1)", 2, 7.22966 / 3)):
        found = max_sector(formula, [Sector(low, 1 if low < 1 else 3)])
        assert end * 0.9999 < found.largest.low < found.refuted_at < end * 1.0001
        assert recheck(found.proof.certificate).accepted
    for formula, low, high in (("-exp(-s)/s", 0.5, 1), ("3*exp(-s)/(s+1/2)", 1, 2), ("-exp(-s)/s", -1.6, -0.5)):
        # s = g exp(-s) at .5; two roots beyond the axis at 1; i w = 1.6 exp(-i w) is beyond pi/2 again
        shown = certify(formula, [Sector(low, high)])
        assert shown.verdict.name == "REFUTED"
        assert recheck(shown.certificate).accepted


# exp(-s)/(s - 1) is unstable with every gain, and so is exp(-s)/(s + 1) with 3 > 2.262; 0.3 and 3.76 are no doubles
@pytest.mark.parametrize(
    ("plant", "bounds"),
    [
        ([["exp(-s)/(s-1)"]], [("3.76", "3.8")]),
        pytest.param(
            [["1/(s+1)", "0"], ["exp(-s)/(s+3)", "exp(-s)/(s+1)"]],
            [("0.3", "1.3"), ("0", "3")],
            marks=pytest.mark.slow,
        ),
    ],
)
def test_bounds_that_are_no_doubles_are_refuted_by_gains_within_them(plant, bounds):
    asked = channel_problem(as_plant(plant), [Sector(*map(Fraction, ends)) for ends in bounds], late=True)
    _, shown = late_gains_refuting(asked, most=1.0)
    assert recheck(shown.certificate).accepted


@pytest.mark.slow
def test_a_delay_known_by_its_bound_adds_to_one_that_is_known():
    # x' = -x(t - 1 - tau) up to pi/2 - 1, the factor of .5; with the rate .1 what is shown ends before
    found = max_sector("exp(-s)/s", [NonlinearityClass.delayed(0.5)])
    end = np.pi - 2
    assert end * 0.999 < found.largest.low < end < found.refuted_at < end * 1.00001
    assert (found.criterion, found.witness.kind) == ("piecewise-circle", "delay")
    for shown in (found.proof, found.refutation):
        assert recheck(shown.certificate).accepted
    slow = certify("exp(-s)/s", [NonlinearityClass.delayed(0.4, rate=0.1)])
    assert slow.verdict.name == "PROVED"
    assert recheck(slow.certificate).accepted
    # at any rate: small gain, h |sigma'| against |w|, up to the least |i w + exp(-i w)|/w, .3195591 at w = 1.3824;
    # beyond 1/2 the delay is above 3/2, where x' = -x(t - tau(t)) need not tend to 0 (Myshkis)
    fast = max_sector("exp(-s)/s", [NonlinearityClass.delayed(0.5, varying=True)])
    assert 0.3195 < fast.largest.low / 2 < 0.3195592
    assert recheck(fast.proof.certificate).accepted
    x, y = fast.proof.certificate["multiplier"]["pieces"][0][0]
    assert x == "0"
    pieces = [[["1/1000000", y]] for _ in fast.proof.certificate["multiplier"]["pieces"]]
    forged = {**fast.proof.certificate, "multiplier": {**fast.proof.certificate["multiplier"], "pieces": pieces}}
    with pytest.raises(Rejected, match="bounded rate"):
        check(forged)
    assert "too fast" in recheck(forged).reason
    assert certify("3*exp(-s)/(s+1/2)", [NonlinearityClass.delayed(0.5)]).verdict.name == "REFUTED"  # with tau = 0


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.thorough) for k in range(1, 6))])
def test_no_gain_of_what_is_proved_is_unstable(seed):
    random = np.random.default_rng(seed)
    rows = [
        [
            f"{random.choice([-3, -2, -1, 1, 2, 3])}*exp(-{random.integers(0, 3)}*s)/(s+{random.integers(1, 4)})"
            for _ in range(2)
        ]
        for _ in range(2)
    ]
    plant = as_plant(rows)
    found = max_sector(plant, UNIT)
    assert found.refuted_at is None or found.largest.low < found.refuted_at
    # H is stable: det(1 + H G) goes round 0 as often as the loop has unstable roots
    omega = np.concatenate([[0.0], np.geomspace(1e-3, 1e3, 40_001)])
    H = plant.transfer(1j * omega)
    for gains in random.random((20, 2)) * min(found.largest.low, 1e3):
        curve = np.linalg.det(np.eye(2) + H * gains)
        turned = np.unwrap(np.angle(curve))
        assert abs(turned[-1] - turned[0]) < 1, (rows, gains)


@pytest.mark.slow
def test_a_system_from_a_file_is_analysed_and_written_back(tmp_path):
    path = tmp_path / "loop.toml"
    path.write_text(
        "[plant]\ntransfer = [['1/(s+1)', '0.5*exp(-2*s)/(s+1)'], ['0', 'exp(-s)/(s+2)']]\n"
        "[[class]]\nsector = [0, 1]\n[[class]]\nslope = [0, 1]\nodd = true\n"
    )
    system = find_system(str(path), [])
    again = tmp_path / "again.toml"
    again.write_text(loop_to_toml(system))
    assert np.allclose(find_system(str(again), []).block.transfer(1j), system.block.transfer(1j))
    shown = certify(system)
    assert (shown.verdict.name, shown.conclusion.shown.theorem) == ("PROVED", "piecewise-popov")
    assert "initial functions of finite energy" in shown.conclusion.meaning


def test_a_factor_with_which_a_class_is_empty_refutes_nothing():
    # a quarter of [1/2, 1] is [1/2, 1/4]; the gains are members of no such class
    asked = channel_problem(LAGS, [Sector(0, 1), Sector(Fraction(1, 2), 1)], late=True)
    assert refutation(asked, Fraction(1, 4), constant_gains([Fraction(0), Fraction(1, 4)])) is None


@pytest.mark.thorough
def test_analyse_answers_every_class():
    same = Diagonal((NonlinearityClass(sector=Sector(0, 2), time_varying=True),) * 2, repeated=True)
    found = analyse(as_plant([["exp(-s)/(s+1)", "0"], ["0", "exp(-s)/(s+1)"]]), same)
    assert found.verdict.name == "PROVED"
    assert found.to_dict()["block"]["matrices"]["late"][0][0] == "1"


def test_channels_of_a_larger_plant():
    plant = as_plant([["1/(s+1)", "exp(-s)/(s+2)", "1"], ["0", "exp(-s)/(s+3)", "0"]])
    chosen = lft(plant, {"valve": ("0", "1"), "spring": ("1", "0")})
    assert isinstance(chosen, DelayMatrix)
    assert chosen.names == ("valve", "spring")
    assert np.allclose(chosen.transfer(1j), plant.transfer(1j)[:, [1, 0]])
    assert str(lft(plant, [(0, 0)])).startswith("(s^2")  # no dead time is left
    with pytest.raises(InputError, match=r"give to_control\(pade=4\)"):
        plant.to_control()
    assert np.allclose(plant.to_control(pade=6)(0.5j), plant.transfer(0.5j), atol=1e-6)


@pytest.mark.slow_for("plant2-classes2")
@pytest.mark.parametrize(
    ("plant", "classes"),
    [
        pytest.param(
            as_plant([["1/s", "0"], ["0", "exp(-s)/(s+2)"]]),
            [NonlinearityClass(sector=Sector(0, 1), time_varying=True)] * 2,
            marks=pytest.mark.slow,
        ),
        (LAGS, [NonlinearityClass.delayed(1, varying=True), Sector(0, 1)]),
        (LAGS, [NonlinearityClass.hysteretic("play", 1), Sector(0, 1)]),
    ],
)
def test_what_no_theorem_covers_is_not_proved(plant, classes):
    assert certify(plant, classes).verdict.name == "INCONCLUSIVE"


def test_an_undamped_mode_refutes_classes_from_0_on_by_the_gain_0():
    found = certify(as_plant([["1/s", "0"], ["0", "-exp(-s)/(s**2+4)"]]), UNIT)
    assert found.verdict.name == "REFUTED"
    assert found.certificate["proof"]["proof"] == {"method": "late-turns", "gains": ["0"]}


@pytest.mark.slow
def test_a_long_dead_time_beside_a_fast_pole_needs_few_pieces():
    # of a few radians of the dead time each, up to thirty times the pole, they would be a thousand and more
    found = certify("exp(-8*s)/(s+1) + 1/(s+50)", NonlinearityClass.constant_gain(-0.5, 0.9))
    assert found.verdict.name == "PROVED"
    assert len(found.certificate["proof"]["ends"]) < 100


@pytest.mark.parametrize(
    ("rows", "classes", "code", "sentence"),
    [
        ([["exp(-s)/s"]], [Sector(2, 3)], "DEAD_TIME", "shifted by the gains 2, with which it is not stable"),
        ([["exp(-s)/(s-1)"]], [Sector(1, 3)], "CRITICAL", "a pole at 0 is not simple"),
        ([["0.1+exp(-s)/(s+1)", "0"], ["0", "1/(s+2)"]], UNIT, "NOT_APPLICABLE", "D has a cycle of channels"),
        (
            [["1/s", "0"], ["0", "exp(-s)/(s+2)"]],
            [NonlinearityClass(sector=Sector(0, 1), time_varying=True)] * 2,
            "CRITICAL",
            "an eigenvalue 0",
        ),
    ],
)
def test_a_hypothesis_that_fails_is_named_before_a_search(rows, classes, code, sentence):
    asked = channel_problem(as_plant(rows), classes, late=True)
    with pytest.raises(AssumptionError, match=sentence) as refused:
        PiecewiseProofs(asked, None)
    assert refused.value.code.name == code


@pytest.mark.slow
def test_constant_gains_beside_an_integrator_with_dead_time_are_proved_as_functions():
    # pi/2 is where i w + k exp(-i w) = 0, and Popov's criterion reaches it for all functions in [0, k]
    late = as_plant([["exp(-s)/s", "0"], ["0", "1/(s+1)"]])
    assert certify(late, [NonlinearityClass.constant_gain(0, 1)] * 2).verdict.name == "PROVED"
    assert certify(late, [NonlinearityClass.constant_gain(0, 1.6)] * 2).verdict.name == "REFUTED"
    # slopes within the bounds make up for a cycle in D
    direct = as_plant([["0.1+exp(-s)/(s+1)", "0"], ["0", "1/(s+2)"]])
    assert certify(direct, [NonlinearityClass.slope_restricted(0, 0.5)] * 2).verdict.name == "PROVED"


# the first channel ends where i w + 1 + exp(-i w)/2 + k exp(-i w) = 0: k + 1/2 = 2.26182, as exp(-s)/(s + 1)
@pytest.mark.slow
def test_entries_with_dead_time_in_the_denominator_keep_what_they_have_apart():
    plant = as_plant([["exp(-s)/(s + 1 + exp(-s)/2)", "1/(s + 3)"], ["0", "1/(s + 4 + exp(-s/2))"]])
    below, above = (certify(plant, [Sector(0, k)] * 2) for k in (1.75, 1.762))
    assert (below.verdict.name, above.verdict.name) == ("PROVED", "REFUTED")
    for shown in (below, above):
        assert recheck(shown.certificate).accepted
    system = below.certificate["system"]
    (wait, seen, back), *others = system["late"][::-1]
    more = [wait, seen, [[str(8 * Fraction(v)) for v in row] for row in back]]
    changed = {**below.certificate, "system": {**system, "late": [*others[::-1], more]}}
    assert refused_again(changed)
    with pytest.raises(Rejected):
        complete_and_check(changed)


def test_a_denominator_with_dead_time_in_two_columns_of_a_row_is_refused():
    with pytest.raises(InputError, match="how many states"):
        as_plant([["1/(s + exp(-s))", "2/(s + exp(-s))"], ["0", "1/(s + 1)"]])
    with pytest.raises(InputError, match="neutral"):
        as_plant([["1/(s + 1 + s*exp(-s)/2)", "0"], ["0", "1/(s + 1)"]])


def test_other_questions_say_that_dead_time_is_not_covered():
    on = {"Bw": [[1], [0]], "Cz": [[1, 0]]}
    for ask in (lambda: region(LAGS, UNIT), lambda: energy_bounds(LAGS, UNIT, on)):
        with pytest.raises(InputError, match="dead time"):
            ask()
    with pytest.raises(InputError, match="dead time"):
        steady_response(LAGS, UNIT, {"Bw": [[1], [0]], "amplitude": 1})


# s + 1 + 3 exp(-s) has a root in Re s > 0, and the plant has it too where it comes back late; s = 0 is a pole with 0
@pytest.mark.parametrize(
    ("plant", "high"), [("exp(-s)/(s+1)", 3), ("1/(s+1+3*exp(-s))", 1), ("exp(-s)/s", 1), ("exp(-s)/(s-1)", 3)]
)
def test_no_gain_is_finite_where_a_member_with_dead_time_grows(plant, high):
    found = l2_gain(plant, [Sector(0, high)])
    assert (found.gain.low, found.verdict.name) == (np.inf, "REFUTED")
    assert recheck(found.refutation.certificate).accepted


def test_a_pole_of_the_plant_alone_on_the_axis_ends_no_search():
    # H = s exp(-s)/(s^2 + 1) has no value at w = 1; with the gain 1/10 the loop does: H/(1 + H/10) -> 10
    asked = channel_problem(as_plant([["s*exp(-s)/(s^2+1)"]]), [Sector(Fraction(1, 10), 1)], late=True)
    H, _ = PiecewiseProofs(asked, None).search._response(np.array([1.0]))
    assert H[0, 0, 0] == pytest.approx(10, rel=1e-3)


def test_no_gain_is_shown_of_neutral_equations_nor_where_sigma_and_z_see_w_at_once():
    with pytest.raises(InputError, match="neutral equations"):
        l2_gain("exp(-s)/(s+1+s*exp(-s)/2)", SlopeBounds(0, 1))
    assert "that of w and z included" in l2_gain("1+exp(-s)/(s+1)", SlopeBounds(0, 1), criterion="circle").reason


@pytest.mark.slow
def test_a_member_that_grows_unseen_refutes_no_gain():
    # sigma = exp(-s)/(s + 1) mu destabilises, and neither w nor z has to do with it: z = w/(s + 3)
    found = l2_gain(as_plant([["exp(-s)/(s+1)", "0"], ["0", "1/(s+3)"]]), [Sector(0, 3)])
    assert found.verdict.name == "INCONCLUSIVE"
    assert found.gain.low < 0.334


@pytest.mark.slow
def test_the_gain_of_a_plant_with_dead_time_is_met_from_both_sides():
    # z = H (w - phi) with |H| <= H(0) = 1 and |phi| <= |z|/2: |z| <= |w| + |z|/2, with equality at 0 for phi = -z/2
    lag = "exp(-s)/(s+1)"
    found = l2_gain(as_plant([[lag, lag]] * 2), [Sector(-0.5, 0.5)])
    assert 1.9999 < found.gain.low < 2 < found.gain.high < 2.0001
    assert recheck(found.proof.certificate).accepted
    assert recheck(found.refutation.certificate).accepted
    assert "with phi = -0.5" in str(found)
    assert found.performance.late == ((1, ((1,),)),)  # z sees the state of one second ago alone
    assert found.performance.Cz == ((0,),)


@pytest.mark.slow
def test_what_z_sees_late_and_at_once_in_a_file(tmp_path):
    # from w at the sensor to mu: -g/(1 + g H), |1 + g H| >= 1/2 as |g H| <= 1/2; |H| is least far out, where it is g
    (tmp_path / "loop.toml").write_text(
        """[plant]
transfer = "exp(-s)/(2*s + 2)"
[class]
sector = [0, 1]
[performance]
Dsigmaw = [[1]]
Dzmu = [[1]]
"""
    )
    found = l2_gain(find_system(str(tmp_path / "loop.toml")))
    assert found.criterion == "piecewise-circle"
    assert 1.2 < found.gain.low <= found.gain.high < 2
    with pytest.raises(InputError, match="Bw and Cz are about states"):
        l2_gain(as_plant("exp(-s)/(s+1)"), [Sector(0, 1)], {"Bw": [[1]], "Cz": [[1]]})
    assert str(found.performance) == "1 disturbance w (Dsigmaw), 1 output z (Dzmu)"
