"""Switched gains: against closed forms, against the circle criterion, and against a simulation."""

import math
from fractions import Fraction as F

import numpy as np
import pytest
from depth import sampled
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.optimize import brentq

from lure.analysis.counterexamples.linear import Exponential, companion
from lure.analysis.counterexamples.switched import SwitchingSearch, growing, switched_witness
from lure.analysis.verdict import Evidence
from lure.arrays import in_doubles
from lure.plants.rational import RationalPlant


def circle_reach(block, lower=0.0):
    """Where the circle criterion stops, from a dense sample of the response: at least the true value."""
    poles = np.roots([float(c) for c in block.denominator])
    omega = np.concatenate(
        [np.geomspace(1e-4, 1e4, 40_000), *(p.imag + np.linspace(-5, 5, 4001) * p.real for p in poles)]
    )
    response = block.transfer(1j * omega)
    least = (response / (1 + lower * response)).real.min()
    return lower - 1 / least if least < 0 else math.inf


def multiplier(block, witness):
    """Spectral radius of one period, in doubles, from the witness's data alone."""
    system = companion(block)
    product = np.eye(block.order)
    for gain, time in zip(witness.data["gains"], witness.data["times"], strict=True):
        product = expm(in_doubles(system.closed(F(gain))) * float(F(time))) @ product
    return np.abs(np.linalg.eigvals(product)).max()


# x'' + 2 a x' + (1 + u) x = 0 with u in {0, k}: energy grows fastest with u = k while x x' < 0, u = 0 while x x' > 0.
# From x = 1 at rest to x = 0 with stiffness 1 + k takes (pi - atan(w/a))/w and ends at the speed sqrt(1 + k) e^(-a t);
# from x = 0 to rest with stiffness 1 takes atan(w0/a)/w0 and ends at v e^(-a t0).  The half turn grows by the product.
@pytest.mark.parametrize("a", [0.05, 0.5, 0.9])
def test_the_worst_switching_of_an_oscillator_is_the_known_one(a):
    def growth(k):
        w0, w = math.sqrt(1 - a * a), math.sqrt(1 + k - a * a)
        return math.log(1 + k) / 2 - a * (math.atan(w0 / a) / w0 + (math.pi - math.atan(w / a)) / w)

    worst = brentq(growth, 1e-6, 1e4)
    witness = switched_witness(RationalPlant([1], [1, 2 * F(a), 1]))
    assert witness.k == pytest.approx(worst, rel=1e-7)
    assert witness.k > worst
    assert (witness.kind, witness.evidence, witness.time_varying) == ("switched gain", Evidence.CERTIFIED, True)


# A gain that alternates at 2 w drives a weakly damped motion at w.  Of k(t) in {0, k} the first harmonic is (2/pi) k;
# the circle criterion stops where a harmonic of k would do it: hence pi/2 times 4.0004e-4, to first order in k.
@pytest.mark.slow
def test_weak_damping_leaves_the_ratio_of_a_square_wave_to_its_first_harmonic():
    block = RationalPlant([1, 0, 0], [1, F("0.0003"), 10, F("0.0021"), 9])
    assert switched_witness(block).k == pytest.approx(math.pi / 2 * 4.0004e-4, rel=1e-3)


@pytest.mark.slow
@settings(max_examples=sampled(6, of=15))
@given(
    rates=st.lists(st.floats(0.2, 3), min_size=1, max_size=2),
    damping=st.floats(0.02, 0.9),
    top=st.lists(st.integers(-4, 4), min_size=1, max_size=3).filter(any),
)
def test_no_witness_lies_below_the_circle_limit(rates, damping, top):
    pole = [1, 2 * damping * rates[0], rates[0] ** 2]
    block = RationalPlant(top, np.polymul(pole, [1, rates[1]]) if len(rates) > 1 else pole)
    if block.feedthrough < 0:
        return
    witness = switched_witness(block)
    limit = circle_reach(block)
    if witness is None:
        return
    assert witness.k > limit * (1 - 1e-9)
    assert multiplier(block, witness) > 1 - 1e-12


def test_passive_blocks_discrete_blocks_and_unstable_ones_have_no_witness():
    assert switched_witness(RationalPlant([1, 1], [1, 2, 0])) is None
    assert switched_witness(RationalPlant([1], [1, F(1, 2)], dt=1)) is None
    assert switched_witness(RationalPlant([1], [1, -1])) is None
    assert switched_witness(RationalPlant([2], [1])) is None


# Steep gains make products of exponentials overflow in the search.
@pytest.mark.parametrize(
    ("top", "bottom"),
    [
        ([-0.9526, 0.1033, -0.2813], [1, 0.79022, 2.64687]),
        ([-0.1603, 0.0136, -0.0254], [1, 2.37609, 0.37965]),
    ],
)
def test_overflow_in_the_search_is_survived(top, bottom):
    block = RationalPlant(top, bottom)
    witness = switched_witness(block)
    assert witness is None or multiplier(block, witness) > 1


@pytest.mark.parametrize(
    "matrix",
    [[[0, 1], [-2, -0.3]], [[0, 1], [0, 0]], [[0, 1, 0], [0, 0, 1], [0, -5, -1e-9]]],
    ids=["complex poles", "no basis of eigenvectors", "a pole at 0"],
)
def test_exponentials_are_those_of_scipy(matrix):
    matrix, times = np.array(matrix, dtype=float), np.array([1e-20, 0.3, 4.0])
    exponential = Exponential(matrix)
    assert exponential.over(times) == pytest.approx(np.array([expm(matrix * t) for t in times]), abs=1e-12)
    assert exponential.over(0.3) == pytest.approx(expm(matrix * 0.3), abs=1e-12)
    assert np.abs(exponential.over(1e-20) - np.eye(len(matrix))).max() < 1e-19  # and not merely 1e-16


# With a pole at 0 the spectral radius is 1 and its logarithm is rounding, which over 1e-20 s would be fast growth.
def test_rounding_over_short_periods_is_no_growth():
    search = SwitchingSearch(companion(RationalPlant([2500], [1, 50, 0])), F(0), 1.0, 0.0, math.inf)
    assert search.growth(np.full(2, 1e-20), 1.3) == 0
    assert search.growth(np.array([0.622, 0.0223]), 3.1) > 0


@pytest.mark.slow
def test_a_lower_gain_is_the_loop_shifted():
    block, shifted = RationalPlant([1], [1, 1, 1]), RationalPlant([1], [1, 1, 3])
    assert switched_witness(block, lower=F(2)).k == pytest.approx(2 + switched_witness(shifted).k, rel=1e-7)


def test_growth_is_not_claimed_where_there_is_none():
    system = companion(RationalPlant([1], [1, 1, 1]))
    times = [F(5441, 4500), F(3125, 4500)]
    assert growing(system, [F(0), F(5711, 1000)], times)
    assert not growing(system, [F(0), F(5710, 1000)], times)
    assert not growing(system, [F(0), F(0)], times)
    assert growing(system, [F(-1001, 1000)], [F(1)])  # a real eigenvalue just right of 0
    assert not growing(system, [F(-1)], [F(1)])  # an eigenvalue exactly 0 does not grow
