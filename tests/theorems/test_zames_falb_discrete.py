"""Zames-Falb multipliers in discrete time: published numbers, phase limits, and what must be refused."""

import math
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from depth import sampled
from flint import fmpq_poly
from hypothesis import given, settings
from hypothesis import strategies as st
from plants import DISCRETE, discrete

from lure.analysis.inequality.gains import hurwitz_limit
from lure.analysis.inequality.unit_circle import DiscretePlant
from lure.analysis.theorems.differences import tsypkin_largest
from lure.analysis.theorems.fir import Multiplier, certifies
from lure.analysis.theorems.phase_limit import lowest_phase_limit, phase_limit
from lure.analysis.theorems.zames_falb_discrete import zames_falb_discrete_criterion, zames_falb_discrete_largest
from lure.analysis.verdict import Evidence, Verdict
from lure.classes import SlopeBounds
from lure.errors import AssumptionError, InputError
from lure.plants.rational import RationalPlant


@cache
def reach(example, odd):
    return zames_falb_discrete_largest(DISCRETE[example], odd=odd)


def sampled_left_hand_side(plant, answer):
    """``Re[M (H + 1/k)]`` on a dense grid, from nothing but the plant and the parameters of the answer."""
    omega = np.linspace(0, math.pi, 50_001)
    z = np.exp(1j * omega)
    lower = float(answer.nonlinearity_class.slope.lower)
    H = plant.transfer(z)
    H = H / (1 + lower * H)
    M = 1 - sum(float(Fraction(h)) * z ** (-int(i)) for i, h in answer.parameters["taps"].items())
    return (M * (H + 1 / (float(Fraction(answer.parameters["k"])) - lower))).real


# lower ends: the best values published; upper ends: the slopes at which no multiplier of any length is left
@pytest.mark.parametrize(
    ("example", "odd", "published", "limit"),
    [
        (1, True, 13.5115, 13.51168),
        (1, False, 13.0283, 13.028374),
        (2, True, 1.1056, 1.105649),
        (2, False, 0.80274, 0.802746),
        (3, True, 0.3121, 0.312145),
        (3, False, 0.3121, 0.312145),
        (5, True, 2.4475 - 1e-9, 2.4475 + 1e-9),
        (5, False, 2.4475 - 1e-9, 2.4475 + 1e-9),
        (6, True, 25 / 23 - 1e-8, 25 / 23 + 1e-12),
        (6, False, 175 / 192 - 1e-8, 175 / 192 + 1e-12),
    ],
)
@pytest.mark.slow
def test_the_published_values_are_reached_and_bounded(example, odd, published, limit):
    plant = DISCRETE[example]
    answer = reach(example, odd)
    assert answer.verdict is Verdict.PROVED
    assert answer.evidence is Evidence.CERTIFIED
    assert published <= answer.largest.low < answer.largest.high <= limit
    assert answer.largest.low < hurwitz_limit(plant).low
    assert sampled_left_hand_side(plant, answer).min() > -1e-12
    assert ("odd" in answer.needs) is odd is answer.nonlinearity_class.odd
    assert 0 < answer.margin.low <= answer.margin.high


@pytest.mark.slow
def test_the_orbit_of_example_6_is_never_certified_against():
    # a monotone nonlinearity of slope 175/192 has an orbit of period 3; odd nonlinearities are stable far beyond
    monotone = reach(6, False)
    assert Fraction(monotone.largest.low) < Fraction(175, 192)
    refused = zames_falb_discrete_criterion(DISCRETE[6], SlopeBounds(0, Fraction(175, 192)), odd=False)
    assert refused.verdict is Verdict.INCONCLUSIVE
    assert zames_falb_discrete_criterion(DISCRETE[6], SlopeBounds(0, 1), odd=True).verdict is Verdict.PROVED


@pytest.mark.slow
def test_the_criterion_is_sharp_in_k():
    for k, verdict in ((0.9114, Verdict.PROVED), (0.9115, Verdict.INCONCLUSIVE)):
        answer = zames_falb_discrete_criterion(DISCRETE[6], SlopeBounds(0, k), odd=False)
        assert answer.verdict is verdict
        assert (answer.margin.low > 0) is (verdict is Verdict.PROVED)


def certified_taps(example, *, odd):
    answer = reach(example, odd)
    taps = {int(i): Fraction(h) for i, h in answer.parameters["taps"].items()}
    return DiscretePlant.of(DISCRETE[example], Fraction(0), "test"), taps, Fraction(answer.parameters["k"])


@pytest.mark.slow_for("1-True", "2-False")
@pytest.mark.parametrize(("example", "odd"), [(1, True), (2, False), (6, False)])
def test_a_tampered_multiplier_certifies_nothing(example, odd):
    discrete, taps, k = certified_taps(example, odd=odd)
    assert certifies(discrete, Multiplier(taps=taps), k, odd=odd)
    assert not certifies(discrete, Multiplier(taps=taps), k * (1 + Fraction(1, 1000)), odd=odd)
    for i in taps:
        flipped = Multiplier(taps={**taps, i: -taps[i]})
        assert not certifies(discrete, flipped, k, odd=odd)
        mirrored = {(-j if j == i else j): h for j, h in taps.items()}
        assert not certifies(discrete, Multiplier(taps=mirrored), k, odd=odd) or abs(taps[i]) < Fraction(1, 10**3)


def test_taps_of_the_wrong_sign_or_size_are_illegal():
    tenth = Fraction(1, 10)
    assert Multiplier(taps={1: tenth, -2: tenth}).legal(odd=False)
    assert not Multiplier(taps={1: -tenth}).legal(odd=False)
    assert Multiplier(taps={1: -tenth}).legal(odd=True)
    assert not Multiplier(taps={1: 5 * tenth, 2: -5 * tenth}).legal(odd=True)
    with pytest.raises(ValueError, match="shift 0"):
        Multiplier(taps={0: tenth})


def test_a_multiplier_for_odd_laws_proves_nothing_about_others():
    discrete, taps, k = certified_taps(6, odd=True)
    assert any(h < 0 for h in taps.values())
    assert not certifies(discrete, Multiplier(taps=taps), k, odd=False)


def test_the_multiplier_as_a_laurent_polynomial():
    laurent = Multiplier(taps={1: Fraction(1, 4), -2: Fraction(1, 3)}).laurent
    assert (laurent.p, laurent.shift) == (fmpq_poly([0, -3, 12, 0, -4]) / 12, 2)  # 1 - z^-1/4 - z^2/3


# sigma_t -> (-1)^t sigma_t maps odd nonlinearities to themselves and H(z) to H(-z)
@pytest.mark.slow
@pytest.mark.parametrize("example", [pytest.param(1, marks=pytest.mark.thorough), 2])
def test_odd_laws_do_not_distinguish_z_from_minus_z(example):
    plant = DISCRETE[example]
    n, d = list(plant.numerator), list(plant.denominator)
    turned = RationalPlant(
        [c * (-1) ** (len(n) - 1 - i) for i, c in enumerate(n)],
        [c * (-1) ** (len(d) - 1 - i) for i, c in enumerate(d)],
        dt=1,
    )
    here = zames_falb_discrete_largest(plant, odd=True, taps=3).largest.low
    there = zames_falb_discrete_largest(turned, odd=True, taps=3).largest.low
    assert here == pytest.approx(there, rel=1e-6)


@pytest.mark.slow
def test_a_lower_slope_is_the_shifted_block():
    lower = Fraction(3, 10)
    plant = DISCRETE[6]
    n = (Fraction(0), *plant.numerator)
    shifted = RationalPlant(plant.numerator, [d + lower * c for d, c in zip(plant.denominator, n, strict=True)], dt=1)
    here = zames_falb_discrete_largest(plant, odd=False, lower=lower)
    there = zames_falb_discrete_largest(shifted, odd=False)
    assert here.largest.low == pytest.approx(float(lower) + there.largest.low, rel=1e-9)
    assert here.nonlinearity_class.slope.lower == lower
    assert sampled_left_hand_side(plant, here).min() > -1e-12


@pytest.mark.slow
def test_more_taps_never_reach_less():
    found = [
        zames_falb_discrete_largest(DISCRETE[1], odd=True, taps=taps).largest.low for taps in (1, 3, sampled(4, of=6))
    ]
    assert found == sorted(found)
    assert found[0] < 13 < found[1]


@pytest.mark.parametrize("delay", [1, 2, 7])
def test_a_pure_delay_reaches_the_small_gain_bound(delay):
    # z^delay + kappa has its roots on the circle at kappa = 1, and |H| = 1 everywhere
    answer = zames_falb_discrete_largest(discrete([1], [1] + [0] * delay), odd=True)
    assert 1 - 1e-9 < answer.largest.low < 1


# 1/(z - 1 + e) is stable for kappa < 2 - e; H = g/(z + 1/2) for kappa < 1/(2 g)
@pytest.mark.parametrize(
    ("numerator", "denominator", "limit"),
    [
        ([1], [1, Fraction(1, 10**18) - 1], 2.0),
        ([10**200], [1, "0.5"], 5e-201),
        (["1e-300"], [1, "0.5"], 5e299),
    ],
)
def test_extreme_blocks_are_certified_all_the_same(numerator, denominator, limit):
    answer = zames_falb_discrete_largest(discrete(numerator, denominator), odd=False)
    assert limit * (1 - 1e-8) < answer.largest.low < limit


@pytest.mark.slow
def test_what_doubles_cannot_search_is_left_open():
    # poles at +-i within 1e-18 of the circle; and a reach of 1e400, beyond doubles
    for plant in (discrete([1], [1, 0, 1 - Fraction(1, 10**18)]), discrete([Fraction(1, 10**400)], [1, "0.5"])):
        answer = zames_falb_discrete_largest(plant, odd=True)
        assert answer.verdict is Verdict.INCONCLUSIVE
        assert answer.largest.low == 0


@pytest.mark.parametrize(("numerator", "denominator"), [([0], [1, "-.5"]), ([2, 0], [2, -1]), ([1, 1], [1, 0])])
def test_a_positive_real_block_admits_every_slope(numerator, denominator):
    answer = zames_falb_discrete_largest(discrete(numerator, denominator), odd=False)
    assert answer.largest.low == math.inf
    assert answer.verdict is Verdict.PROVED


def test_a_negative_feedthrough_stops_at_the_singular_algebraic_loop():
    # sigma - 3 phi(sigma) = r has no unique solution from slope 1/3 on
    answer = zames_falb_discrete_largest(discrete([-3], [1]), odd=True)
    assert 1 / 3 - 1e-9 < answer.largest.low < 1 / 3
    system = DiscretePlant.of(discrete([-3], [1]), Fraction(0), "test")
    assert system.well_posed(Fraction(33, 100))
    assert not system.well_posed(Fraction(1, 3))


def test_unstable_and_continuous_blocks_are_refused():
    with pytest.raises(AssumptionError, match="give a lower gain in"):
        zames_falb_discrete_largest(discrete([1], [1, -2]), odd=True)
    with pytest.raises(AssumptionError, match="cancels in H"):
        zames_falb_discrete_largest(discrete([1, -2], [1, "-2.5", 1]), odd=True)
    with pytest.raises(InputError, match="dt is None"):
        zames_falb_discrete_largest(RationalPlant([1], [1, 1]), odd=True)
    with pytest.raises(InputError, match="positive integer"):
        zames_falb_discrete_largest(DISCRETE[6], odd=True, taps=0)
    with pytest.raises(AssumptionError, match="finite slope bounds"):
        zames_falb_discrete_criterion(DISCRETE[6], SlopeBounds(0, math.inf), odd=True)
    shifted = zames_falb_discrete_largest(discrete([1], [1, -2]), odd=True, lower=Fraction(3, 2))
    assert 1.5 < shifted.largest.low < 3  # z - 2 + kappa is stable for 1 < kappa < 3


# Zhang, Carrasco, Heath: example 6 loses its multipliers at 175/192 = 0.9114583 for period 3, example 1 (odd) at
# 13.5754 for period 6; example 2 at 1.10565 (odd, period 4) and 0.80275 (period 5)
@pytest.mark.parametrize(
    ("example", "odd", "period", "k"),
    [(6, False, 3, 175 / 192), (1, True, 6, 13.5754), (2, True, 4, 1.10565), (2, False, 5, 0.80275)],
)
def test_the_phase_limits_of_the_literature(example, odd, period, k):
    system = DiscretePlant.of(DISCRETE[example], Fraction(0), "test")
    limit = phase_limit(system, period, odd=odd)
    assert limit.k == pytest.approx(k, abs=5.1e-6 * max(1, k))
    assert limit.k >= lowest_phase_limit(system, range(2, 8), odd=odd).k


def test_the_weights_of_a_phase_limit_rule_out_every_short_multiplier():
    plant = DISCRETE[6]
    limit = phase_limit(DiscretePlant.of(plant, Fraction(0), "test"), 3, odd=False)
    z = np.exp(2j * math.pi * np.arange(2) / 3)
    G = plant.transfer(z) + 1 / limit.k
    for shift in range(-9, 10):
        M = 1 - z ** (-shift) if shift else np.ones(2)
        assert np.dot(limit.weights, (M * G).real) <= 1e-12


@st.composite
def stable_blocks(draw):
    poles = []
    for _ in range(draw(st.integers(1, 4))):
        radius, angle = draw(st.floats(0, 0.98)), draw(st.floats(0, math.pi))
        poles += [radius * np.exp(1j * angle), radius * np.exp(-1j * angle)]
    size = draw(st.integers(1, len(poles)))
    numerator = draw(st.lists(st.integers(-20, 20), min_size=size, max_size=size))
    return RationalPlant([Fraction(c, 10) for c in numerator], np.real(np.poly(poles)).tolist(), dt=1)


@pytest.mark.slow
@settings(max_examples=sampled(3, of=15))
@given(stable_blocks())
def test_criteria_are_ordered_and_stay_below_the_linear_limit(plant):
    limit = hurwitz_limit(plant)
    tsypkin = tsypkin_largest(plant)
    monotone = zames_falb_discrete_largest(plant, odd=False, taps=5)
    odd = zames_falb_discrete_largest(plant, odd=True, taps=5)
    for answer in (monotone, odd):
        assert answer.verdict is Verdict.PROVED
        assert answer.largest.low <= answer.largest.high <= limit.high
        assert answer.largest.low < limit.low or math.isinf(limit.low)
        if math.isfinite(answer.largest.low):
            values = sampled_left_hand_side(plant, answer)
            assert values.min() > -1e-9 * np.abs(values).max()
    assert odd.largest.low >= monotone.largest.low * (1 - 1e-6)
    if math.isfinite(tsypkin.largest.low):  # else the classes differ only in what is beyond every finite slope
        assert monotone.largest.low >= tsypkin.largest.low * (1 - 1e-6)
