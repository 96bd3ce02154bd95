"""Slope criteria with a pole at 0 and the lower slope 0: sharp at the linear gains, and nothing beyond equilibria."""

import math
from fractions import Fraction as F

import pytest
from certificate_family import certificate, changed
from tampering import refused_again

from lure.analysis import max_slope
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second import recheck
from lure.analysis.theorems.differences import jury_lee_largest
from lure.analysis.theorems.kernels import Delay, Multiplier, check
from lure.analysis.theorems.off_axis import off_axis_criterion, off_axis_largest
from lure.analysis.theorems.park import park_largest
from lure.analysis.theorems.popov import popov_largest
from lure.analysis.theorems.zames_falb import KernelInequality, zames_falb_largest
from lure.analysis.theorems.zames_falb_discrete import zames_falb_discrete_largest
from lure.analysis.verdict import Verdict
from lure.classes import SlopeBounds
from lure.errors import AssumptionError
from lure.nonlinearities import Tanh
from lure.plants.rational import RationalPlant

THIRD = RationalPlant([1], [1, 3, 2, 0])  # s^3 + 3 s^2 + 2 s + k: 3 * 2 > k
SERVO = RationalPlant([1], [1, 2, 27, 8, 0])  # s^4 + 2 s^3 + 27 s^2 + 8 s + k: (2 * 27 - 8) 8 > 4 k, k < 92
SAMPLED = RationalPlant([1], [1, -1, F(1, 2), F(-1, 2)], dt=1)  # z = exp(i w), w = 2 pi/3 .. : k^2 < 3/4


@pytest.mark.parametrize("largest", [park_largest, off_axis_largest, lambda H: zames_falb_largest(H, odd=False)])
def test_every_slope_criterion_reaches_the_linear_gains_of_order_three(largest):
    found = largest(THIRD)
    assert found.verdict is Verdict.PROVED
    assert 6 - 1e-6 < found.largest.low < 6 <= found.largest.high
    assert "converges to a point of the stationary set" in found.reason
    assert "residue 0.5 > 0" in found.hypotheses[0]


# a sample at z = 1, no pole in floating point, once made every programme infeasible; an orbit of
# period 5 destabilises from 9.665 on, Jury and Lee's criterion ends at 20/3
@pytest.mark.slow
def test_taps_in_discrete_time_reach_beyond_jury_and_lee():
    block = RationalPlant([F(1, 10), F(1, 20)], [1, F(-3, 2), F(1, 2)], dt=1)
    found, before = zames_falb_discrete_largest(block, odd=False, taps=10), jury_lee_largest(block)
    assert before.largest.low == pytest.approx(20 / 3)
    assert 9.4 < found.largest.low < 9.665
    assert sum(map(F, found.parameters["taps"].values())) < 1


# Popov: 1/k > Im H/(omega) stays behind; with slopes the gap to Routh's 92 closes
@pytest.mark.slow
def test_slopes_close_what_the_sector_leaves_open():
    assert popov_largest(SERVO).largest.high < 15.4
    assert 91.9 < park_largest(SERVO).largest.low < 92
    found = max_slope(SERVO)
    assert (found.criterion, found.verdict) == ("zames-falb", Verdict.PROVED)
    assert 92 * (1 - 1e-6) < found.largest.low < 92 == found.refuted_at
    assert str(found).startswith("Every solution converges to the set of equilibria for every phi with slope in [0,")
    assert not found.conclusion.attracts
    assert recheck(found.proof.certificate).accepted


# the root -1 + .. of z^3 - z^2 + z/2 - 1/2 + k: Jury's array gives 1 - (k - 1/2)^2 > |1/2 - (k - 1/2)|, k < sqrt(3)/2
def test_in_discrete_time_taps_reach_the_linear_gains():
    found = zames_falb_discrete_largest(SAMPLED, odd=False)
    assert math.sqrt(3) / 2 * (1 - 1e-6) < found.largest.low < math.sqrt(3) / 2
    assert found.margin.low >= 0


# 1/(z^2 - z): Re H = c + 1/2 - 1/(2 c + 2)..; 1 - z + z^2 has |z| = 1 at k = 1.  Tsypkin ends at 2 sqrt(2) - 2
@pytest.mark.slow_for("circle-0.6666666666666666")
@pytest.mark.parametrize(
    ("criterion", "end"), [("circle", 2 / 3), ("tsypkin", 2 * math.sqrt(2) - 2), ("jury-lee", 1.0)]
)
def test_one_difference_with_a_pole_at_one(criterion, end):
    found = max_slope(RationalPlant([1], [1, -1, 0], dt=1), criterion=criterion)
    assert found.largest.low == pytest.approx(end, rel=1e-9)
    assert recheck(found.proof.certificate).accepted
    assert found.proof.certificate["conclusion"] == "every motion converges to the set of equilibria"


# alpha rho/omega at 0: the pole decides the sign of alpha
@pytest.mark.parametrize(("alpha", "proved"), [(F(2), True), (F(-1, 1000), False), (F(-2), False)])
def test_the_line_turns_with_the_pole(alpha, proved):
    found = off_axis_criterion(THIRD, SlopeBounds(0, F(11, 2) if proved else F(1, 10)), alpha=alpha)
    assert (found.verdict is Verdict.PROVED) == proved
    assert proved or found.margin.low == -math.inf


# Re[(1 - exp(-i w t)/2)(1/(i w) + 1/k)] = (1 - cos(w t)/2)/k + sin(w t)/(2 w), at 0 (1/k + t)/2: k < 1 for t = -1
@pytest.mark.parametrize(("k", "holds"), [(F(99, 100), True), (F(101, 100), False)])
def test_the_limit_at_zero_of_a_kernel_with_a_delay_is_sharp(k, holds):
    inequality = KernelInequality.of(RationalPlant([1], [1, 0]), F(0), odd=True)
    late, early = (Multiplier(F(0), ((F(1, 2), Delay(F(tau))),)) for tau in (1, -1))
    found = [check(inequality.task.plant, k, one).holds for one in (late, early)]
    ends, kernel = ["0", str(k)], {"coefficient": "1/2", "delay": "-1"}
    proof = {"method": "cover", "boxes": [["0", "1/16"], ["1/16", "1"], ["1", "4"], ["4", "8"]], "order": 14}
    changes = {"system.denominator": ["1", "0"], "laws.sector": ends, "laws.slope": ends, "proof": proof}
    draft = changed("zames-falb, critical", {**changes, "multiplier": {"theta": "0", "kernels": [kernel]}})
    assert found == [True, holds]
    if holds:
        assert recheck(complete_and_check(draft).certificate).accepted
    else:
        with pytest.raises(Rejected, match="box"):
            complete_and_check(draft)


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("park, critical", {"laws.slope": ["0", "92"], "laws.sector": ["0", "92"]}),
        ("park, critical", {"system.denominator": ["1", "2", "27", "0", "0"]}),  # two poles at 0
        ("park, critical", {"system.numerator": ["-1"]}),  # the residue is negative
        ("off-axis, critical", {"multiplier.alpha": "-2"}),
        ("zames-falb, critical", {"multiplier.kernels.0.coefficient": "1000001/1000000"}),
        ("zames-falb, discrete critical", {"multiplier.taps": [[2, "3/5"], [-2, "41/100"]]}),
        ("zames-falb, discrete critical", {"laws.slope": ["0", "7/8"], "laws.sector": ["0", "7/8"]}),
    ],
)
def test_a_hypothesis_that_fails_is_seen_by_both_checkers(name, changes):
    draft = changed(name, changes)
    with pytest.raises(Rejected):
        complete_and_check(draft)
    assert refused_again({**certificate(name), **{key: draft[key] for key in ("system", "laws", "multiplier")}})


KEPT = ["off-axis, critical", "park, critical", "zames-falb, critical", "zames-falb, discrete critical"]


@pytest.mark.parametrize("name", KEPT)
def test_both_checkers_accept(name):
    assert complete_and_check(changed(name, {})).certificate == certificate(name)
    assert recheck(certificate(name)).accepted


@pytest.mark.parametrize("name", KEPT)
def test_more_than_convergence_to_equilibria_is_claimed_by_no_checker(name):
    given = certificate(name)
    assert given["conclusion"] == "every motion converges to the set of equilibria"
    for stronger in ("0 attracts every motion", "every motion is bounded"):
        assert not recheck({**given, "conclusion": stronger}).accepted
    assert refused_again({**given, "rate": "1/100", "conclusion": given["conclusion"]})


@pytest.mark.slow
def test_a_nonlinearity_that_vanishes_at_0_alone_makes_its_loop_converge_there():
    from lure.analysis import analyse

    said = analyse(SERVO, Tanh(gain=20)).statement
    assert "converges to 0" in said


def test_forms_of_several_samples_still_need_a_stable_block():
    from lure.analysis.theorems.order_cone import order_cone_largest

    with pytest.raises(AssumptionError, match="z = 1"):
        order_cone_largest(SAMPLED, odd=False)
