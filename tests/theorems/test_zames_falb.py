"""Zames-Falb multipliers in continuous time: published plants, what must be refused, sharp limits."""

import math
from dataclasses import replace
from fractions import Fraction as F
from functools import cache

import numpy as np
import pytest
from depth import sampled
from hypothesis import given, settings
from hypothesis import strategies as st
from multipliers import left_hand_side, samples, stable_blocks
from plants import CONTINUOUS as PLANTS
from plants import block

from lure.analysis.inequality.gains import hurwitz_limit
from lure.analysis.inequality.plant import TransferPolynomials
from lure.analysis.theorems.kernels import Delay, Gamma, Multiplier, check, check_every, multiplier_of
from lure.analysis.theorems.park import park_largest
from lure.analysis.theorems.popov import popov_largest
from lure.analysis.theorems.zames_falb import recheck, zames_falb_criterion, zames_falb_largest
from lure.analysis.verdict import Evidence, Verdict
from lure.classes import SlopeBounds
from lure.errors import AssumptionError, InputError
from lure.plants.rational import RationalPlant

# Fitts: s^2/(((s + b)^2 + 0.81)((s + b)^2 + 1.21)), b = 0.03; phi = tanh(sigma/0.01) oscillates with period 11.917
FITTS = block("1 0 0", "1 0.12 2.0254 0.121308 0.98191881")


@cache
def reach(number, odd):
    return zames_falb_largest(PLANTS[number], odd=odd)


def assert_sound(system, answer, odd):
    """What every proved answer must satisfy, checked without the code that proved it."""
    assert answer.verdict is Verdict.PROVED
    assert answer.evidence is Evidence.CERTIFIED
    assert recheck(system, answer.parameters)
    multiplier = multiplier_of(answer.parameters)
    assert sum(abs(c) for c, _ in multiplier.terms) <= 1
    assert odd or all(c > 0 for c, _ in multiplier.terms)
    if math.isfinite(answer.largest.low):
        assert F(answer.parameters["k"]) == F(answer.largest.low)
        assert answer.largest.low < hurwitz_limit(system).high
        omega = samples(system)
        values = left_hand_side(system, answer.largest.low, multiplier, omega)
        scale = np.abs(system.transfer(1j * omega)) + 1 / answer.largest.low
        assert (values > -1e-11 * scale).all()


# least certified slopes: above the table's "at least" everywhere; 1 is the Nyquist value 4.5894542 less its last digits
QUICK = [(1, False, 4.5894541), (1, True, 4.5894541), (7, False, 1e9), (7, True, 1e9)]
HARD = [
    pytest.param(number, odd, least, marks=pytest.mark.thorough)
    for number, odd, least in ((3, False, 2.25), (3, True, 2.25), (4, True, 1.34))
]
# the others have their certificates checked in test_certificate_proposals.py


@pytest.mark.parametrize(("number", "odd", "least"), QUICK)
def test_published_plants(number, odd, least):
    answer = reach(number, odd)
    assert answer.largest.low >= least
    assert_sound(PLANTS[number], answer, odd)
    assert answer.needs == (("slope", "odd", "time-invariant") if odd else ("slope", "time-invariant"))


@pytest.mark.slow
@pytest.mark.parametrize(("number", "odd", "least"), HARD)
def test_published_plants_that_take_longer(number, odd, least):
    answer = reach(number, odd)
    assert answer.largest.low >= least
    assert_sound(PLANTS[number], answer, odd)


@pytest.mark.parametrize(
    ("number", "odd"),
    [(1, True), pytest.param(3, False, marks=pytest.mark.thorough), pytest.param(3, True, marks=pytest.mark.thorough)],
)
def test_more_effort_and_odd_laws_never_reach_less(number, odd):
    full = zames_falb_largest(PLANTS[number], odd=odd, effort="full").largest.low
    assert full >= reach(number, odd).largest.low >= (reach(number, False).largest.low if odd else 0)


# the nonlinearity tanh(sigma/0.01) is odd, has slope in [0, 100] and leaves a limit cycle
@pytest.mark.parametrize("odd", [False, True])
def test_the_kalman_counterexample_of_fitts_is_not_certified(odd):
    at_hundred = zames_falb_criterion(FITTS, SlopeBounds(0, 100), odd=odd)
    assert at_hundred.verdict is Verdict.INCONCLUSIVE


@pytest.mark.slow
@pytest.mark.thorough
@pytest.mark.parametrize("odd", [False, True])
def test_the_largest_slope_stays_below_the_kalman_counterexample_of_fitts(odd):
    answer = zames_falb_largest(FITTS, odd=odd)
    assert 0.3 < answer.largest.low < 100
    assert answer.largest.high == math.inf
    assert_sound(FITTS, answer, odd)
    assert not recheck(FITTS, {**answer.parameters, "k": "100"})


@pytest.mark.slow
def test_iqcbeta_plant_reaches_every_stable_linear_gain():
    # G = 400 (s^2 - 0.5 s + 1)/((s + 10)(s + 20)(s + 30)); its slope is asked up to 1 only
    plant = block("400 -200 400", "1 60 1100 6000")
    answer = zames_falb_largest(plant, odd=True)
    assert answer.largest.low == pytest.approx(hurwitz_limit(plant).low, rel=1e-7)
    proved = zames_falb_criterion(plant, SlopeBounds(0, 1), odd=True)
    assert proved.verdict is Verdict.PROVED
    assert 0 <= proved.margin.low <= proved.margin.high
    assert proved.margin.low > 0.4 * proved.margin.high


def test_margin_brackets_the_least_value():
    # 1/(s + 1), slope up to 2: with M = 1 the least value is 1/2, in the limit, and no frequency is below
    answer = zames_falb_criterion(block("1", "1 1"), SlopeBounds(0, 2), odd=False)
    multiplier = multiplier_of(answer.parameters)
    values = left_hand_side(block("1", "1 1"), 2, multiplier, samples(block("1", "1 1")))
    assert answer.margin.low <= values.min() <= answer.margin.high * (1 + 1e-6)


def test_every_finite_slope():
    # 7 with M = 1 - 1/(1 - s) = -s/(1 - s): Re[M H] is a positive multiple of w^4; with coefficient 1, M vanishes at 0
    answer = reach(7, False)
    assert answer.largest.low == math.inf
    assert answer.parameters["k"] == "inf"
    assert "every finite k" in answer.reason
    assert answer.margin is None
    with pytest.raises(AssumptionError, match="finite slope bounds"):  # of each: no multiplier serves steeper ones
        zames_falb_criterion(PLANTS[7], SlopeBounds(0, math.inf), odd=False)
    for k in ("100", "1000000"):
        one = zames_falb_criterion(PLANTS[7], SlopeBounds(0, F(k)), odd=False)
        assert one.verdict is Verdict.PROVED
        assert F(one.parameters["k"]) == F(k)
        assert recheck(PLANTS[7], one.parameters)


def test_every_finite_slope_needs_a_nonnegative_gain_at_zero_where_the_multiplier_vanishes():
    # (2 s - 1)/(s + 1) with 1 - 1/(1 - s): Re[M H] (1 + w^2)^2 = 2 w^4 + 2 w^2 >= 0, but the gain 1 has the pole s = 0
    multiplier = Multiplier(F(0), ((F(1), Gamma(F(1), 1, "anticausal")),))
    assert not check_every(TransferPolynomials.of(block("2 -1", "1 1")), multiplier)
    assert check_every(TransferPolynomials.of(PLANTS[7]), multiplier)
    assert not check_every(TransferPolynomials.of(PLANTS[7]), Multiplier(F(0), ((F(1), Gamma(F(1), 1, "causal")),)))
    assert not check_every(TransferPolynomials.of(PLANTS[7]), Multiplier(F(0), ((F(1), Delay(F(1))),)))


def test_negative_coefficients_are_for_odd_laws_only():
    parameters = {"lower": "0", "k": "1/2", "odd": True, "theta": "0"}
    parameters["kernels"] = [{"coefficient": "-1/10", "delay": "1"}]
    plant = block("1", "1 1")
    assert recheck(plant, parameters)
    assert not recheck(plant, {**parameters, "odd": False})
    assert not recheck(plant, {**parameters, "odd": "yes"})  # only the truth value is an assumption made


def test_mass_above_one_is_refused():
    # Re[1 + c 5/(5 + s)] >= 1 for c > 0, and 1/k = 100 outweighs H: the inequality holds, the multiplier is illegal
    plant = block("1", "1 1")
    term = {"coefficient": "-1", "rate": "5", "order": 1, "side": "causal"}
    parameters = {"lower": "0", "k": "1/100", "odd": True, "theta": "0", "kernels": [term]}
    assert recheck(plant, parameters)
    heavy = {**parameters, "kernels": [{**term, "coefficient": "-1001/1000"}]}
    assert check(TransferPolynomials.of(plant), F("1/100"), multiplier_of(heavy)).holds
    assert not recheck(plant, heavy)


@pytest.mark.parametrize(
    "change",
    [
        {"k": "5"},
        {"k": "-1"},
        {"k": "inf"},
        {"theta": "40"},
        {"kernels": []},
        {"kernels": [{"coefficient": "9/10", "rate": "-2", "order": 1, "side": "anticausal"}]},
        {"kernels": [{"coefficient": "9/10", "delay": "0"}]},
    ],
)
def test_a_changed_certificate_is_refused(change):
    answer = reach(1, False)
    assert recheck(PLANTS[1], answer.parameters)
    assert not recheck(PLANTS[1], {**answer.parameters, **change})


@pytest.mark.parametrize(
    "parameters",
    [
        {},
        {"theta": "0", "kernels": [], "k": "1", "odd": True},
        {"theta": "0", "kernels": 3, "lower": "0", "k": "1", "odd": True},
        {"theta": "x", "kernels": [], "lower": "0", "k": "1", "odd": True},
        {"theta": "0", "kernels": [{"coefficient": "1", "rate": "1", "order": 1, "side": "left"}], "lower": "0"},
    ],
)
def test_incomplete_parameters(parameters):
    with pytest.raises(InputError, match="give"):
        recheck(PLANTS[1], parameters)


def test_refusals():
    with pytest.raises(AssumptionError, match="continuous time"):
        zames_falb_largest(RationalPlant([1], [1, 0], dt=1), odd=True)
    with pytest.raises(AssumptionError, match="residue"):
        zames_falb_largest(block("-1", "1 3 2 0"), odd=False)
    with pytest.raises(AssumptionError, match="right half-plane"):
        zames_falb_largest(block("1", "1 -1"), odd=False)
    with pytest.raises(AssumptionError, match="finite slope bounds"):
        zames_falb_criterion(PLANTS[1], SlopeBounds(-math.inf, 1), odd=False)
    beyond = zames_falb_criterion(PLANTS[4], SlopeBounds(0, 4), odd=True)
    assert beyond.verdict is Verdict.INCONCLUSIVE
    assert "linear gain" in beyond.reason


def test_blocks_without_dynamics():
    assert zames_falb_largest(block("1/2", "1"), odd=False).largest.low == math.inf
    assert zames_falb_largest(block("0", "1 1"), odd=False).largest.low == math.inf
    assert zames_falb_largest(block("-1/2", "1"), odd=False).largest.low == pytest.approx(2, rel=1e-6)
    assert zames_falb_largest(block("-1/2", "1"), odd=False).largest.low < 2


def test_sign_convention():
    # mu = -phi(sigma): 1/(s + 1) is stable with every slope, -1/(s + 1) below slope 1
    assert zames_falb_largest(block("1", "1 1"), odd=False).largest.low == math.inf
    answer = zames_falb_largest(block("-1", "1 1"), odd=False)
    assert 1 - 1e-6 < answer.largest.low < 1


@settings(max_examples=sampled(4, of=10), deadline=None)
@given(stable_blocks(most=3), st.booleans())
def test_order_of_the_criteria(system, odd):
    answer = zames_falb_largest(system, odd=odd)
    assert_sound(system, answer, odd)
    assert answer.largest.low >= popov_largest(system).largest.low
    assert answer.largest.low >= park_largest(system).largest.low * (1 - 1e-12)
    assert answer.largest.high <= hurwitz_limit(system).high


def test_a_direct_term_moves_into_the_law():
    # H + D with [0, k] is H with [0, k/(1 + k D)]; 1/k' = 1/k + D
    n, d = PLANTS[1].numerator, PLANTS[1].denominator
    direct = F("1/10")
    padded = [F(0)] * (len(d) - len(n)) + list(n)
    with_direct = RationalPlant([a + direct * b for a, b in zip(padded, d, strict=True)], d)
    base, moved = (zames_falb_largest(system, odd=False).largest.low for system in (PLANTS[1], with_direct))
    assert 1 / base == pytest.approx(1 / moved + float(direct), rel=1e-7)


def test_lower_slope():
    # 1/(s^2 - s/2 + 1) needs a positive lower slope of its derivative: H = s/(...), lower = 1 leaves s/(s^2 + s/2 + 1)
    answer = zames_falb_largest(block("1 0", "1 -1/2 1"), odd=False, lower=F(1))
    assert answer.largest.low == math.inf
    assert answer.parameters["lower"] == "1"
    shifted = RationalPlant(
        PLANTS[1].numerator, [a + b / 2 for a, b in zip(PLANTS[1].denominator, (0, *PLANTS[1].numerator), strict=True)]
    )
    direct = zames_falb_largest(PLANTS[1], odd=False, lower=F("1/2"))
    assert direct.largest.low - 0.5 == pytest.approx(zames_falb_largest(shifted, odd=False).largest.low, rel=1e-7)
    assert recheck(PLANTS[1], direct.parameters)


def test_answer_of_a_given_class_is_not_a_truth_value():
    answer = zames_falb_criterion(PLANTS[1], SlopeBounds(0, 4), odd=False)
    assert answer.verdict is Verdict.PROVED
    assert answer.largest.low == 4.0
    with pytest.raises(TypeError):
        bool(answer)
    assert replace(answer, reason="") != answer
