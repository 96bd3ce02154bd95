"""Decay rates of loops with dead time: against Lambert's function, published rates, and several channels."""

import math
from fractions import Fraction

import pytest
from scipy import optimize, special

from lure import RationalPlant, Sector, SlopeBounds, as_plant
from lure.analysis.certificates.second import recheck
from lure.analysis.questions.channel_problem import channel_plant
from lure.analysis.questions.decay import decay_rate
from lure.analysis.verdict import Verdict
from lure.plants.delay_matrix import DelayMatrix


@pytest.mark.parametrize(
    ("top", "bottom", "slopes", "rate"),
    [("-1/100", "2.515", (0, 2), 2.495), ("-1.27", "0.691", ("-0.04", "0.1"), 0.564)],
)
def test_one_pole_decays_as_the_slowest_gain_says(top, bottom, slopes, rate):
    # x' = -(p + g n) x is the slowest loop, and phi g(t) x is no slower
    plant = RationalPlant([Fraction(top)], [1, Fraction(bottom)])
    found = decay_rate(plant, SlopeBounds(*map(Fraction, slopes)))
    assert found.rate.low == pytest.approx(rate, rel=1e-6)
    assert found.rate.high == pytest.approx(rate, rel=1e-6)


def test_a_rate_is_proved_up_to_a_pole_of_a_plant_with_dead_time():
    # with the gain 0 the root is the pole -0.984, and no root is farther to the right: |exp(-s/10)/(s + .984)| 1.64 < 1
    found = decay_rate("0.01*exp(-0.1*s)/(s+0.984)", Sector(0, Fraction("1.64")))
    assert found.rate.low == pytest.approx(0.984, rel=1e-6)
    assert found.rate.low <= 0.984 <= found.rate.high


@pytest.mark.slow
def test_an_integrator_with_dead_time_and_the_gain_0_does_not_decay():
    # x' = 0 is a loop of the class; nothing is claimed at the rate 0, where the theorem speaks of convergence alone
    found = decay_rate("0.28*exp(-s)/s", SlopeBounds(0, Fraction("1.66")))
    assert found.verdict is Verdict.REFUTED
    assert found.rate.high == 0
    assert found.proof is None or found.rate.low < 0
    assert all(recheck(one.certificate).accepted for one in (found.proof, found.refutation) if one is not None)


# roots s = W(-g) of s + g e^-s: the rightmost with the gain 1/5 is real, with the gain 1 it is W_0(-1)
@pytest.mark.slow
@pytest.mark.parametrize(
    ("low", "high", "proved", "slowest", "bounds"),
    [(0.2, 0.35, 0.259171, 0.259171, Sector), (0.5, 1, 0.31805, 0.318132, SlopeBounds)],
)
def test_an_integrator_with_dead_time_decays_as_lambert_says(low, high, proved, slowest, bounds):
    found = decay_rate("exp(-s)/s", bounds(Fraction(str(low)), Fraction(str(high))))
    exact = min(-special.lambertw(-g).real for g in (low, high))
    assert slowest == pytest.approx(exact, abs=1e-6)
    assert exact <= found.rate.high <= exact * (1 + 1e-8)
    assert proved == pytest.approx(found.rate.low, abs=2e-4)
    assert found.rate.low <= exact
    assert "<= c m exp(-" in str(found)
    assert all(recheck(one.certificate).accepted for one in (found.proof, found.refutation))


@pytest.mark.slow
def test_several_channels_with_dead_time_have_a_rate():
    # side by side: 1/(s + 2) with the gain 0, and exp(-s)/(s + 1) with -1/2, the root s = -r where 1 - r = e^r/2
    plant = as_plant([["1/(s+2)", "0"], ["0", "exp(-s)/(s+1)"]])
    found = decay_rate(plant, [Sector(0, 1), Sector(Fraction(-1, 2), Fraction(1, 2))])
    root = optimize.brentq(lambda r: 1 - r - math.exp(r) / 2, 0, 1)
    assert found.rate.low <= root <= found.rate.high
    assert found.rate.width < 1e-5


@pytest.mark.slow
def test_the_roots_drawn_are_those_with_dead_time():
    # s + g e^-s, g in [1/5, 7/20]: W_0(-1/5) = -.2592 is the rightmost of all, and none is 0, the pole of the plant
    axes = decay_rate("exp(-s)/s", Sector(Fraction(1, 5), Fraction(7, 20))).plot()
    drawn = axes.lines[0].get_xdata()
    assert max(drawn) == pytest.approx(special.lambertw(-0.2).real, abs=1e-6)


@pytest.mark.slow
def test_a_published_rate_of_a_retarded_equation_is_met():
    # x' = [-4 1; 0 -4] x + [.1 0; 4 .1] x(t - 1/2), published rate 1.1534: 4 - r = e^(r/2)/10 + 2 e^(r/4)
    rows = [tuple(tuple(Fraction(str(v)) for v in row) for row in side) for side in ([[0.1, 0], [4, 0.1]], [[0, 0]])]
    base = channel_plant(([[-4, 1], [0, -4]], [[0], [1]], [[1, 0]], [[0]]))
    found = decay_rate(DelayMatrix(base, ((Fraction(1, 2), rows[1]),), (rows[0],)), [Sector(0, Fraction(1, 10**6))])
    root = optimize.brentq(lambda r: 4 - r - math.exp(r / 2) / 10 - 2 * math.exp(r / 4), 1, 2)
    assert root == pytest.approx(1.1534, abs=1e-4)
    assert root * (1 - 1e-6) < found.rate.low <= root <= found.rate.high < root * (1 + 1e-8)


# the gain 0 is the slowest: (s + 1) + g exp(-s) has no other root near -1, and F > 0 seems to hold on one piece
def test_a_class_of_small_gains_beside_dead_time_has_the_rate_of_the_plant():
    found = decay_rate("exp(-s)/(s+1)", Sector(0, Fraction(1, 10**7)))
    assert 1 - 1e-8 < found.rate.low < 1 <= found.rate.high < 1 + 1e-8
    assert recheck(found.proof.certificate).accepted
