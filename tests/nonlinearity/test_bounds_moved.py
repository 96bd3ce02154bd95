"""Nonlinearities around a point that is known to within a radius: what is said is true wherever it lies in there."""

from fractions import Fraction

import numpy as np
import pytest

from lure import ExpressionNonlinearity, Sector, SlopeBounds
from lure.analysis.nonlinearity import nonlinearity_bounds
from lure.analysis.verdict import Evidence
from lure.errors import InputError
from lure.nonlinearities import Cubic, MovedNonlinearity, Saturation, Tanh, nonlinearity_class


# At the middle and at both ends of the radius no chord or slope passes the bounds, and those at the middle come close:
# by the radius times |phi''|, or of a graph times the jump of the slope over the distance from the kink.
@pytest.mark.parametrize(
    ("phi", "at"),
    [
        (Tanh(scale=2, gain=3), Fraction(1, 3)),
        (Tanh(), Fraction(-3, 2)),
        (Tanh(), Fraction(0)),
        (ExpressionNonlinearity("sigma - sin(sigma)", sector=Sector(0, 2)), Fraction(-7, 10)),
        (Cubic(cubic=1), Fraction(1, 2)),
        (Saturation(limit=1), Fraction(1, 3)),
        (Saturation(limit="0.1"), Fraction(-1, 3)),
    ],
)
@pytest.mark.parametrize("on", [(Fraction(-1, 20), Fraction(1, 10)), (-2, 3), (-1, Fraction(1, 4))])
def test_bounds_around_a_point_hold_for_every_point_within_the_radius(phi, at, on):
    within = Fraction(1, 1000)
    found = nonlinearity_bounds(MovedNonlinearity(phi, at, within), on=on)
    assert found.evidence is Evidence.CERTIFIED
    x = np.concatenate([np.linspace(float(on[0]), 0, 500)[:-1], np.linspace(0, float(on[1]), 500)[1:]])
    for s in (at - within, at, at + within):
        chords = (phi(float(s) + x) - phi(float(s))) / x
        slopes = phi.slope(float(s) + x)
        assert float(found.sector_lower.outer) - 1e-9 <= chords.min()
        assert chords.max() <= float(found.sector_upper.outer) + 1e-9
        assert found.sector_lower.inner + 1e-2 >= chords.min() - 1e-9
        assert float(found.slope_lower.outer) - 1e-9 <= slopes.min()
        assert slopes.max() <= float(found.slope_upper.outer) + 1e-9
        if s == at:
            assert chords.min() - float(found.sector_lower.outer) <= 3e-2
            assert float(found.sector_upper.outer) - chords.max() <= 3e-2


# The kink at 1 is 0.49 away from s = 0.51, and 0.5 from the middle: slopes from there on are 0.
def test_a_kink_just_beyond_the_domain_counts():
    moved = MovedNonlinearity(Saturation(limit=1), Fraction(1, 2), Fraction(1, 100))
    for end, slope in ((Fraction(489, 1000), 1), (Fraction(495, 1000), 0)):
        found = nonlinearity_bounds(moved, on=(Fraction(-2, 5), end))
        assert (found.slope_lower.outer, found.slope_upper.outer) == (slope, 1)
        assert found.slope_lower.attained is (slope == 1)


# The tangent from (1, tanh 1) touches at t < 0 with tanh(1) - tanh(t) = (1 - tanh(t)^2)(1 - t): t = -0.4589, and its
# slope there is 0.8162.  For s = 0 it is that at 0, and far out it tends to 0.
@pytest.mark.parametrize(("at", "steepest"), [(1, 0.8162187), (-1, 0.8162187), (0, 1.0), (20, 0.0893278)])
def test_no_chord_of_tanh_is_steeper_than_a_tangent(at, steepest):
    moved = MovedNonlinearity(Tanh(scale=Fraction(1, 2), gain=3), Fraction(at, 2), Fraction(1, 10**20))
    assert float(moved.sector.upper) / 6 == pytest.approx(steepest, abs=1e-7)
    assert nonlinearity_class(moved).slope == SlopeBounds(0, 6)
    assert not moved.odd


def test_what_cannot_be_moved_is_refused():
    with pytest.raises(InputError, match="has a kink at 1"):
        MovedNonlinearity(Saturation(limit=1), Fraction(1), Fraction(1, 100))
    with pytest.raises(InputError, match="within is 0; give a positive number"):
        MovedNonlinearity(Tanh(), Fraction(1), Fraction(0))
    for text, words in (("abs(sigma)", "is no smooth formula"), ("exp(sigma**2) - 1", "second derivative")):
        moved = MovedNonlinearity(ExpressionNonlinearity(text), Fraction(1), Fraction(1, 100))
        with pytest.raises(InputError, match=words):
            nonlinearity_bounds(moved)
