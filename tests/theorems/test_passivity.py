"""Passivity indices and positive realness against closed forms, from both sides, and their symmetries."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from lure.analysis.theorems.passivity import passivity_indices
from lure.analysis.verdict import Verdict
from lure.plants.rational import RationalPlant

F = Fraction
P, R = Verdict.PROVED, Verdict.REFUTED


def plus(block, constant):
    """H + constant."""
    padded = (F(0),) * (block.order + 1 - len(block.numerator)) + block.numerator
    return RationalPlant(
        [n + constant * d for n, d in zip(padded, block.denominator, strict=True)], block.denominator, block.dt
    )


def feedback(block, gain):
    """H/(1 + gain H), whose inverse is 1/H + gain."""
    padded = (F(0),) * (block.order + 1 - len(block.numerator)) + block.numerator
    return RationalPlant(
        block.numerator, [d + gain * n for n, d in zip(padded, block.denominator, strict=True)], block.dt
    )


@pytest.mark.parametrize(
    ("block", "nu", "rho", "positive", "strictly"),
    [
        (RationalPlant([1], [1, 1]), 0, 1, P, P),
        (RationalPlant([1, 2], [1, 3]), 2 / 3, 1, P, P),
        (RationalPlant([1], [1, 0]), 0, 0, P, R),
        (RationalPlant([-1], [1, 0]), -math.inf, -math.inf, R, R),
        (RationalPlant([1], [1, 0, 0]), -math.inf, -math.inf, R, R),
        (RationalPlant([1, 0], [1, 0, 1]), 0, 0, P, R),  # lossless
        (RationalPlant([1, 3], [1, 0, 4]), -math.inf, -3, R, R),  # 1/H + 3 = s + 13/(s + 3)
        (RationalPlant([1, 1], [1, 0, 0]), -math.inf, -1, R, R),  # 1/H + 1 = s + 1/(s + 1)
        (RationalPlant([1], [1, -1]), -math.inf, -1, R, R),
        (RationalPlant([-1, 1], [1, 1]), -1, -math.inf, R, R),  # 1/H has a pole right of the axis
        (RationalPlant([1], [1, 1, 1]), -1 / 3, -math.inf, R, R),
        (RationalPlant([1, 3], [1, 3, 2]), 0, 0, P, R),  # w^2 Re H -> 0: positive real, not strictly
        (RationalPlant([0], [1, 1]), 0, None, P, R),
        (RationalPlant([-2], [1]), -2, -0.5, R, R),
        (RationalPlant([1, -1], [1, 0, -1]), 0, 1, P, P),  # 1/(s + 1) with a hidden mode at 1
        (RationalPlant([1, 1], [1, -1], dt=1), 0, 0, P, R),
        (RationalPlant([1, F(1, 2)], [1, 1], dt=1), 0.75, 0, P, R),
        (RationalPlant([1], [1, F(1, 2)], dt=1), -2, -math.inf, R, R),
        (RationalPlant([2, 1], [2, 0], dt=1), 0.5, 2 / 3, P, P),  # 1 + 1/(2z)
    ],
)
def test_indices_by_hand(block, nu, rho, positive, strictly):
    found = passivity_indices(block)
    assert found.input_feedforward.middle == pytest.approx(nu, abs=1e-15)
    assert (found.output_feedback is None) is (rho is None)
    assert rho is None or found.output_feedback.middle == pytest.approx(rho, abs=1e-15)
    assert (found.positive_real, found.strictly_positive_real) == (positive, strictly)
    assert found.reason


# floating-point tests with a tolerance call 1/(s + 1) - 1e-8 passive; it is not
@pytest.mark.parametrize("lack", [F(1, 10**8), F(1, 10**100)])
def test_a_tiny_lack_of_passivity_is_a_lack(lack):
    found = passivity_indices(plus(RationalPlant([1], [1, 1]), -lack))
    assert found.positive_real is R
    assert found.input_feedforward.low <= -lack <= found.input_feedforward.high < 0


_BLOCKS = st.tuples(
    st.lists(st.integers(-6, 6), min_size=1, max_size=4),
    st.lists(st.sampled_from([F(1, 4), F(1), F(5, 2)]), min_size=3, max_size=3),
    st.sampled_from([F(1), F(1, 10), F(1, 10**6)]),
)


def drawn(parts):
    numerator, (a, b, c), damping = parts
    assume(any(numerator))
    denominator = [
        F(1),
        2 * damping * b + a,
        b * b + 2 * damping * a * b,
        a * b * b,
    ]  # (s + a)(s^2 + 2 damping b s + b^2)
    return RationalPlant(numerator, [c * d for d in denominator])


@given(_BLOCKS)
def test_the_input_index_is_sharp_from_both_sides(parts):
    block = drawn(parts)
    nu = passivity_indices(block).input_feedforward
    assert math.isfinite(nu.low)
    assert passivity_indices(plus(block, -F(nu.low))).positive_real is P
    assert passivity_indices(plus(block, -F(nu.high) - F(1, 10**12))).positive_real is R
    omega = np.concatenate([[0], np.geomspace(1e-3, 1e3, 20_001), 2.5 + np.linspace(-1e-4, 1e-4, 2001)])
    least = block.transfer(1j * omega).real.min()
    assert nu.low <= least + 1e-9 * abs(nu.low)


@given(_BLOCKS, st.fractions(-3, 3, max_denominator=7))
def test_a_constant_adds_to_an_index_and_a_scale_multiplies_it(parts, constant):
    block = drawn(parts)
    before = passivity_indices(block)
    after = passivity_indices(plus(block, constant))
    assert after.input_feedforward.middle == pytest.approx(
        before.input_feedforward.middle + float(constant), abs=1e-9, rel=1e-12
    )
    assume(1 + constant * block.feedthrough != 0)
    looped = passivity_indices(feedback(block, constant))
    assert looped.output_feedback.middle == pytest.approx(
        before.output_feedback.middle + float(constant), abs=1e-9, rel=1e-12
    )
    scaled = passivity_indices(RationalPlant([3 * c for c in block.numerator], block.denominator))
    assert scaled.input_feedforward.middle == pytest.approx(3 * before.input_feedforward.middle, rel=1e-12)
    assert scaled.output_feedback.middle == pytest.approx(before.output_feedback.middle / 3, rel=1e-12)


@given(_BLOCKS)
def test_strictly_implies_positive_real_implies_indices(parts):
    found = passivity_indices(drawn(parts))
    assert found.strictly_positive_real is R or found.positive_real is P
    assert (found.input_feedforward.high >= 0) or found.positive_real is R
    if found.positive_real is P:
        assert found.output_feedback.high >= 0
    with pytest.raises(TypeError):
        bool(found)
