"""Gains that destabilise: switched and linear ones in discrete time, their order; beside dead times the crossing."""

import math
from fractions import Fraction as F

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plants import CIRCLE, DISCRETE
from scipy import optimize

from lure.analysis.counterexamples.channel_gains import LateGains
from lure.analysis.counterexamples.linear import linear_witness, refutes_lower
from lure.analysis.counterexamples.orbit import verify_periodic_discrete
from lure.analysis.counterexamples.periodic_discrete import periodic_witness_discrete, sector_witness_discrete
from lure.analysis.counterexamples.search import refute
from lure.analysis.counterexamples.switched import _runs, switched_witness_discrete, verify_switched_discrete
from lure.analysis.inequality.gains import is_stable_gain
from lure.analysis.theorems.zames_falb_discrete import zames_falb_discrete_largest
from lure.analysis.verdict import Evidence
from lure.errors import InputError
from lure.plants.rational import RationalPlant


@pytest.mark.parametrize("plant", [1, 2, 3, 5, 6])
@pytest.mark.slow
def test_switched_gain_grows_and_is_not_below_the_circle_criterion(plant):
    witness = switched_witness_discrete(DISCRETE[plant])
    assert witness.evidence is Evidence.CERTIFIED
    assert witness.time_varying
    assert CIRCLE[plant] < witness.k < linear_witness(DISCRETE[plant]).k
    assert verify_switched_discrete(DISCRETE[plant], witness.data)
    assert monodromy_radius(DISCRETE[plant], witness.data["gains"]) > 1
    k = F(witness.data["k"])
    less = [str(F(g) if F(g) == 0 else k * (1 - F(1, 10**6))) for g in witness.data["gains"]]
    assert monodromy_radius(DISCRETE[plant], less) < 1
    assert not verify_switched_discrete(DISCRETE[plant], dict(witness.data) | {"gains": less})


def monodromy_radius(plant, gains):
    """Spectral radius over one period, from the difference equation itself: (sigma, mu) of the last n steps."""
    n = plant.order
    top = [F(0)] * (n + 1 - len(plant.numerator)) + list(plant.numerator)
    product = np.eye(2 * n)
    for gain in (float(F(g)) for g in gains):
        step = np.diag(np.ones(2 * n - 1), -1)
        step[n] = 0
        row = np.array([-float(a) for a in plant.denominator[1:]] + [float(b) for b in top[1:]])
        row /= 1 + gain * float(top[0])
        step[0], step[n] = row, -gain * row
        product = step @ product
    return abs(np.linalg.eigvals(product)).max()


@pytest.mark.parametrize(
    "wrong", [{"gains": []}, {"gains": ["0", "x"]}, {"k": "0"}, {"lower": "1/2"}, {"gains": ["0", "0"]}]
)
def test_a_wrong_record_of_a_switched_gain_is_rejected(wrong):
    witness = switched_witness_discrete(DISCRETE[6])
    assert verify_switched_discrete(DISCRETE[6], dict(witness.data) | wrong) is False


# d + k n = z - 1 + k has its root on the circle at k = 2; z^2 - z/2 + k (2 z + .92) has a complex pair on it at
# k = 25/23 (constant term 1); 1/(s^3 + 3 s^2 + 2 s) stops at 6
@pytest.mark.parametrize(
    ("plant", "k"),
    [
        (RationalPlant([1], [1, -1], 1), F(2)),
        (DISCRETE[6], F(25, 23)),
        (RationalPlant([1], [1, 3, 2, 0]), F(6)),
        (RationalPlant([1], [1, -2], 1), F(0)),  # unstable at gain 0
        (RationalPlant([-2], [1], 1), F(1, 2)),  # 1 + k H(inf) = 0
    ],
)
def test_linear_gain_at_a_rational_limit_is_the_limit(plant, k):
    witness = linear_witness(plant)
    assert F(witness.data["gain"]) == k
    assert witness.k == float(k) or F(witness.k) > k
    assert not is_stable_gain(plant, k)
    assert linear_witness(plant, bound=float(k) - 1e-9) is None


def test_linear_gain_at_an_irrational_limit_is_just_above_it():
    witness = linear_witness(DISCRETE[3])
    gain = F(witness.data["gain"])
    assert not is_stable_gain(DISCRETE[3], gain)
    assert is_stable_gain(DISCRETE[3], gain * (1 - F(1, 10**10)))
    assert witness.k == pytest.approx(0.312370, abs=5e-7)


@given(st.lists(st.integers(-9, 9), min_size=1, max_size=4), st.fractions(-2, 2, max_denominator=30), st.booleans())
def test_linear_gain_is_the_first_that_is_not_stable(top, lower, discrete):
    """Against a float count of roots at gains up to the witness and just above it."""
    bottom, dt = ([10, -3, 2, 5, -1], 1) if discrete else ([1, 3, 5, 4, 2], None)
    plant = RationalPlant(top, bottom, dt)
    witness = linear_witness(plant, lower=lower)
    up_to = lower + 20 if witness is None else F(witness.k)
    for i in range(1, 20):
        assert refutes_lower(witness) or is_stable_gain(plant, lower + (up_to - lower) * F(i, 20))
    if witness is not None:
        gain = F(witness.data.get("gain", witness.k))
        assert not is_stable_gain(plant, gain)
        poly = np.polyadd(
            [float(c) for c in plant.denominator], float(gain) * np.array([float(c) for c in plant.numerator])
        )
        roots = np.roots(poly)
        assert (abs(roots).max() if discrete else 1 + roots.real.max()) > 1 - 1e-4


def test_linear_gain_is_counted_from_the_lower_bound():
    plant = RationalPlant([4], [F(1, 3), F(2, 3), -1])  # 4/((s - 1)(s/3 + 1)): stable for k > 1/4
    assert F(linear_witness(plant).data["gain"]) == 0
    assert linear_witness(plant, lower=F(1)) is None
    assert linear_witness(plant, lower=F(1, 4)) is None  # the class is (1/4, k]


@pytest.mark.slow
def test_refutations_come_in_order_and_only_of_the_class():
    slope = refute(DISCRETE[6], slope=True, odd=False, time_varying=False)
    assert [witness.kind for witness in slope] == ["periodic orbit", "linear gain"]
    assert [witness.kind for witness in refute(DISCRETE[6], slope=True, odd=True, time_varying=False)] == [
        "linear gain"
    ]
    varying = refute(DISCRETE[6], slope=False, odd=False, time_varying=True)
    assert [witness.kind for witness in varying] == ["switched gain", "linear gain"]
    sector = refute(DISCRETE[6], slope=False, odd=False, time_varying=False)
    assert sector[0].k <= slope[0].k
    assert [w.k for w in refute(RationalPlant([1], [1, -2], 1), slope=True, odd=False, time_varying=False)] == [0.0]


def test_questions_out_of_range_are_refused():
    with pytest.raises(InputError, match="give dt"):
        periodic_witness_discrete(RationalPlant([1], [1, 1]), odd=False)
    with pytest.raises(InputError, match="give dt"):
        switched_witness_discrete(RationalPlant([1], [1, 1]))
    with pytest.raises(InputError, match="periods contains 0"):
        periodic_witness_discrete(DISCRETE[6], odd=False, periods=[0, 2])


# poles well inside to nearly on the circle; every proof must lie strictly below every refutation
@pytest.mark.slow
@given(
    st.lists(st.tuples(st.floats(0.2, 0.98), st.floats(0.05, 3.1)), min_size=1, max_size=2),
    st.lists(st.integers(-20, 20), min_size=1, max_size=3),
    st.booleans(),
)
@settings(max_examples=15)
def test_no_proof_reaches_a_refutation(poles, top, odd):
    bottom = np.poly([r * np.exp(1j * sign * angle) for r, angle in poles for sign in (1, -1)]).real
    plant = RationalPlant([F(c, 10) for c in top], [F(round(1000 * c), 1000) for c in bottom], 1)
    witness = periodic_witness_discrete(plant, odd=odd, periods=range(2, 7))
    if witness is None:
        return
    assert verify_periodic_discrete(plant, witness.data)
    assert zames_falb_discrete_largest(plant, odd=odd).largest.low < F(witness.data["k"])
    sector = sector_witness_discrete(plant, odd=odd, periods=range(2, 7))
    assert sector.k <= witness.k


def test_an_unstable_loop_at_a_lower_bound_that_is_no_double_is_refuted_there():
    plant = RationalPlant([-2], [1, F(-3, 2)], 1)
    found = refute(plant, slope=True, odd=False, time_varying=False, lower=F(1, 3))
    assert [F(witness.data["gain"]) for witness in found] == [F(1, 3)]
    assert refutes_lower(found[0])
    assert periodic_witness_discrete(plant, odd=False, lower=F(1, 3)) is None


def test_a_long_pattern_of_gains_is_told_by_its_runs():
    assert _runs(["0", "0", "k"]) == "0 0 k"
    assert _runs(["1/2"] * 5 + ["k"] + ["1/2"] + ["k"] * 3) == "5 times 1/2, k, 1/2, 3 times k"


@pytest.mark.slow
def test_the_search_ends_where_the_reach_rises_ever_more_slowly():
    """A sampled motor, poles at 1 and 0.905: near the largest 1/k each step of the ascent gains less than the last.

    The circle criterion proves 0.9504; the linear limit is 20.2.
    """
    plant = RationalPlant([F(48, 10_000), F(47, 10_000)], [1, F("-1.905"), F("0.905")], dt=F(1, 10))
    witness = switched_witness_discrete(plant)
    assert 0.9504 < witness.k < 2.8
    assert "times k" in witness.description
    assert verify_switched_discrete(plant, witness.data)


def test_a_crossing_of_the_shortest_dead_time_is_found_beside_a_long_one():
    # w/1000 + arctan(w) = pi at w = 1571.432.., and k = sqrt(1 + w^2); what comes 7 s late takes one part in 10^6 of it
    def transfer(s):
        return ((np.exp(-s / 1000) + 1e-6 * np.exp(-7 * s)) / (s + 1))[:, None, None]

    end = optimize.brentq(lambda w: w / 1000 + math.atan(w) - math.pi, 1000, 2000)
    search = LateGains(transfer, np.ones(1), [[0]], [False], np.array([-1.0 + 0j]), (1e-3, 7.0), np.zeros(1))
    assert search.best().factor == pytest.approx(math.hypot(1, end), rel=1e-5)
