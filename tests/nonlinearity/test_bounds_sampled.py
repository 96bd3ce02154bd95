"""Nonlinearities known by their values alone: what a sample shows, and what a Lipschitz constant adds."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lure.analysis.nonlinearity import nonlinearity_bounds
from lure.analysis.verdict import Evidence, Verdict
from lure.classes import Sector, SlopeBounds
from lure.errors import AssumptionError

INF = math.inf


def test_a_sample_sees_and_bounds_nothing():
    found = nonlinearity_bounds(np.tanh)
    assert found.evidence is Evidence.OBSERVED
    assert [found.sector_lower.outer, found.sector_upper.outer] == [-INF, INF]
    assert float(found.sector_upper.inner) == pytest.approx(1)
    assert found.within(Sector(-1, 2)) is Verdict.INCONCLUSIVE  # however wide
    assert found.within(Sector(-1, 0.9)) is Verdict.REFUTED
    assert "observed" in str(found)
    assert "nothing is shown" in found.notes[0]


def test_refinement_finds_a_narrow_extreme():
    # chord 1 + exp(-(x - 1)^2 10^8): 2 at 1, and 1 beyond 1 +- 3e-4; the first sample of [0, 2] has steps of 1e-3
    found = nonlinearity_bounds(lambda x: x * (1 + np.exp(-(((x - 1) * 1e3) ** 2))), on=(0, 2))
    assert float(found.sector_upper.inner) == pytest.approx(2, abs=1e-6)
    assert float(found.sector_upper.at) == pytest.approx(1, abs=1e-5)


def test_a_function_of_one_number_will_do():
    found = nonlinearity_bounds(lambda x: math.atan(x), on=(-3, 2))
    assert float(found.sector_lower.inner) == pytest.approx(math.atan(3) / 3)


def test_a_vouched_constant_bounds_everything_and_says_so():
    found = nonlinearity_bounds(np.sin, lipschitz=1)
    assert found.evidence is Evidence.CERTIFIED
    assert "which is assumed" in found.assumptions[0]
    assert (found.sector_lower.outer, found.sector_upper.outer) == (-1, 1)
    assert (found.slope_lower.outer, found.slope_upper.outer) == (-1, 1)
    assert found.within(Sector(-1, 1)) is Verdict.PROVED
    assert found.within(Sector(-0.5, 1)) is Verdict.INCONCLUSIVE
    assert "given that" in str(found)


@pytest.mark.slow
@settings(max_examples=30, deadline=None)
@given(
    slopes=st.lists(st.fractions(-2, 2, max_denominator=8), min_size=1, max_size=6),
    low=st.fractions(Fraction(1, 2), 2, max_denominator=8),
)
def test_cones_hold_every_chord_between_the_samples(slopes, low):
    # a nonlinearity with kinks at 1, 2, ... and these slopes between them; its Lipschitz constant is 2 at most
    knots = list(range(len(slopes) + 1))
    heights = np.concatenate([[0.0], np.cumsum([float(s) for s in slopes])])

    def nonlinearity(x):
        inner = np.interp(np.abs(x), knots, heights)
        return np.sign(x) * inner

    on = (low, low + 3)
    found = nonlinearity_bounds(nonlinearity, on=on, lipschitz=2, samples=60)
    x = np.unique([*np.linspace(float(on[0]), float(on[1]), 4001), *(k for k in knots if on[0] <= k <= on[1])])
    chords = nonlinearity(x) / x
    assert float(found.sector_lower.outer) <= chords.min() + 1e-12
    assert float(found.sector_upper.outer) >= chords.max() - 1e-12
    assert float(found.sector_upper.inner) <= chords.max() + 1e-9
    assert found.sector_upper.gap < 0.2
    assert float(found.slope_upper.outer) == 2


def test_the_cones_close_where_the_sample_is_fine():
    # tanh(x)/x falls from tanh(1/2)/(1/2) to tanh(2)/2
    found = nonlinearity_bounds(np.tanh, on=(0.5, 2), lipschitz=1)
    for extreme, truth in ((found.sector_lower, math.tanh(2) / 2), (found.sector_upper, 2 * math.tanh(0.5))):
        assert float(extreme.inner) == pytest.approx(truth, rel=1e-15)
        assert 0 <= extreme.gap < 1e-5
    assert found.sector_lower.outer < math.tanh(2) / 2 < 2 * math.tanh(0.5) < found.sector_upper.outer


def test_slopes_that_were_not_found_are_not_given():
    found = nonlinearity_bounds("where(tanh(x) > 0.5, 2*x, x)")
    with pytest.raises(AssumptionError, match="no slope bounds"):
        _ = found.slope
    assert nonlinearity_bounds(np.tanh).slope.upper <= 1 + 1e-6
    assert found.within(SlopeBounds(0, 100)) is Verdict.INCONCLUSIVE
