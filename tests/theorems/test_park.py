"""Park's criterion: published plants, its multiplier as one of Zames and Falb, refusals, symmetries."""

import math
from fractions import Fraction

import numpy as np
import pytest
from flint import fmpq
from hypothesis import given
from plants import CONTINUOUS, block, stable_plants

from lure.analysis.inequality.multiplier_search import Cut
from lure.analysis.theorems.park import Support, jointly_infeasible, park_criterion, park_largest
from lure.analysis.theorems.popov import popov_largest
from lure.analysis.verdict import Evidence, Verdict
from lure.classes import SlopeBounds
from lure.errors import InputError


# Park's LMI gives 3.772, .788, .708, .0018333, .0018325 and 28.90; the whole class of multipliers reaches further in
# examples 1 (the Nyquist limit) and 7 (every finite k), and the same or the last digit more in the others.
@pytest.mark.parametrize(
    ("example", "expected"),
    [
        (1, 4.589454172946),
        (3, 0.788331477362),
        (4, 0.708331477362),
        (5, 0.001833520277983),
        (6, 0.001832540277982),
        (7, math.inf),
    ],
)
def test_published_plants_are_bracketed(example, expected):
    answer = park_largest(CONTINUOUS[example])
    assert answer.verdict is Verdict.PROVED
    assert answer.evidence is Evidence.CERTIFIED
    assert answer.largest.low == pytest.approx(expected, rel=1e-10)
    assert answer.largest.high == pytest.approx(expected, rel=1e-10)
    assert answer.needs == ("slope", "time-invariant")


# Z = (b+s)/(a+s) or (a-s)/(b-s) with 1 + theta s - tau s^2 = tau (a-s)(b+s): the proof goes through Z, so Z is what an
# adversary samples: int |z| < 1, z >= 0, and Re Z (H + 1/k) > 0
@pytest.mark.parametrize(("example", "k"), [(1, 4.589), (3, 0.788), (4, 0.708), (7, 28.9), (7, 1e4)])
def test_the_multiplier_behind_a_proof_is_one_of_zames_and_falb(example, k):
    plant = CONTINUOUS[example]
    answer = park_criterion(plant, SlopeBounds(0, k))
    assert answer.verdict is Verdict.PROVED
    theta, tau = (float(Fraction(answer.parameters[name])) for name in ("theta", "tau"))
    root = math.hypot(theta, 2 * math.sqrt(tau))  # a b = 1/tau, a - b = theta/tau; no cancellation in the larger one
    large = (abs(theta) + root) / (2 * tau)
    a, b = (large, 1 / (tau * large)) if theta >= 0 else (1 / (tau * large), large)
    assert abs(a - b) / max(a, b) < 1
    w = np.geomspace(1e-6, 1e6, 40001)
    s = 1j * w
    z = (b + s) / (a + s) if b <= a else (a - s) / (b - s)
    assert np.min((z * (plant.transfer(s) + 1 / k)).real) > 0
    assert np.allclose(np.angle(z), np.angle(1 + theta * s - tau * s**2), atol=1e-9)


# Fitts: tanh(sigma/.01) has slope up to 100 and a limit cycle although every linear gain is stable
def test_the_counterexample_of_fitts_is_not_certified():
    b = Fraction("0.03")
    one, two = b * b + Fraction("0.81"), b * b + Fraction("1.21")
    fitts = block([1, 0, 0], [1, 4 * b, one + two + 4 * b * b, 2 * b * (one + two), one * two])
    answer = park_largest(fitts)
    assert answer.largest.high < 1
    assert park_criterion(fitts, SlopeBounds(0, 100)).verdict is Verdict.INCONCLUSIVE


@pytest.mark.parametrize(
    ("numerator", "denominator", "limit"),
    [([1], [1, 3, 3, 1], 8), ([24], [1, 6, 11, 6], 2.5), ([1, -1, 10], [1, 1, 25], 1)],
)
def test_the_hurwitz_limit_is_approached_and_never_reached(numerator, denominator, limit):
    plant = block(numerator, denominator)
    answer = park_largest(plant)
    assert answer.largest.low < limit <= answer.largest.high
    assert answer.largest.low == pytest.approx(limit, rel=1e-9)
    assert park_criterion(plant, SlopeBounds(0, answer.largest.low)).verdict is Verdict.PROVED
    assert park_criterion(plant, SlopeBounds(0, Fraction(limit))).verdict is Verdict.INCONCLUSIVE


@pytest.mark.parametrize(
    ("numerator", "denominator"), [([1], [1, 1]), ([1, 3], [1, 3, 3, 1]), ([1, 0, 0], [1, 2, 2, 1])]
)
@pytest.mark.parametrize("k", [1, 1e6, 1e12])
def test_where_every_finite_k_is_in_reach_each_is_proved(numerator, denominator, k):
    plant = block(numerator, denominator)
    assert park_largest(plant).largest.low == math.inf
    assert park_criterion(plant, SlopeBounds(0, k)).verdict is Verdict.PROVED


def test_a_given_multiplier_is_judged_as_it_is():
    plant = CONTINUOUS[3]
    assert (
        park_criterion(plant, SlopeBounds(0, Fraction("0.3")), theta=Fraction(0), tau=Fraction(0)).verdict
        is Verdict.PROVED
    )
    failing = park_criterion(plant, SlopeBounds(0, Fraction("0.7")), theta=Fraction(0), tau=Fraction(0))
    assert failing.verdict is Verdict.INCONCLUSIVE
    assert failing.margin.high < 0
    assert "nothing follows" in failing.reason


@pytest.mark.parametrize(
    "pair", [{"theta": Fraction(1)}, {"tau": Fraction(1)}, {"theta": Fraction(1), "tau": Fraction(-1)}]
)
def test_half_a_multiplier_and_a_negative_tau_are_refused(pair):
    with pytest.raises(InputError, match="tau >= 0 together"):
        park_criterion(CONTINUOUS[3], SlopeBounds(0, 1), **pair)


def test_the_critical_case_is_admitted_after_a_shift():
    answer = park_largest(block([1], [1, 3, 2, 0]), lower=Fraction(1))
    assert answer.largest.low == pytest.approx(6, rel=1e-9)
    assert answer.nonlinearity_class.slope.lower == 1


# weights (1, 1) on x = 1, u = -1 and x = 2, u = 1: S_0 = -2 m, S_1 = 1 - 3 m; only m >= 1/3 excludes every tau
@pytest.mark.parametrize(
    ("level", "excluded"), [(fmpq(-1), False), (fmpq(1, 4), False), (fmpq(1, 3), True), (fmpq(1), True)]
)
def test_a_support_excludes_a_level_only_if_both_moments_say_so(level, excluded):
    cuts = (Cut(fmpq(-1), fmpq(1), fmpq(1)), Cut(fmpq(1), fmpq(-1), fmpq(2)))
    support = Support(cuts, (fmpq(1), fmpq(1)))
    assert jointly_infeasible((support, support), level) == excluded


small = stable_plants(critical=False).filter(lambda plant: plant.order <= 5)


@pytest.mark.slow
@given(small)
def test_park_reaches_at_least_as_far_as_popov(plant):
    popov, park = popov_largest(plant), park_largest(plant)
    assert park.largest.high >= popov.largest.low
    assert park.largest.low >= popov.largest.low * (1 - 1e-9)


# H = -1/(s+1)^2: U + r W/x = 1 + x for r = -1, yet H(0) = -1 and the gain 1 is not stable
def test_a_negative_static_gain_bounds_every_multiplier():
    answer = park_largest(block([-1], [1, 2, 1]))
    assert answer.largest.low < 1 <= answer.largest.high < 1 + 1e-9
