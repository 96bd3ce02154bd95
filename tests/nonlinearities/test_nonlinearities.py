"""lure.nonlinearities: values, slopes and primitives of each, and the tightest sector, slope bounds and parity."""

import math
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from lure import InputError, Sector, SlopeBounds
from lure.nonlinearities import (
    Cubic,
    DeadZone,
    LeakyReLU,
    PiecewiseLinear,
    Quantiser,
    ReLU,
    Saturation,
    Tanh,
    relay_with_slope,
)
from lure.rod import NormalCompliance

sizes = st.fractions(Fraction(1, 50), 50, max_denominator=50)
numbers = st.fractions(-20, 20, max_denominator=12)


@st.composite
def tables(draw):
    """Points on both sides of the origin, which is one of them, and two slopes; not all on one line."""
    xs = sorted(draw(st.sets(numbers.filter(bool), min_size=1, max_size=6)) | {Fraction(0)})
    points = [(x, draw(numbers) if x else Fraction(0)) for x in xs]
    left, right = draw(numbers), draw(numbers)
    slopes = {(b[1] - a[1]) / (b[0] - a[0]) for a, b in pairwise(points)} | {left, right}
    assume(len(slopes) > 1)
    return PiecewiseLinear(points, left_slope=left, right_slope=right)


piecewise = st.one_of(
    st.builds(Saturation, gain=sizes, limit=sizes, lower_limit=st.none() | sizes.map(lambda x: -x)),
    st.builds(relay_with_slope, gain=sizes, level=sizes),
    st.builds(DeadZone, width=sizes, gain=sizes),
    st.builds(ReLU, gain=sizes),
    st.builds(LeakyReLU, negative_slope=sizes, positive_slope=sizes.map(lambda x: -x)),
    tables(),
)
smooth = st.one_of(
    st.builds(Cubic, linear=numbers, cubic=numbers.filter(bool)), st.builds(Tanh, scale=sizes, gain=sizes)
)
quantisers = st.builds(Quantiser, step=sizes)
nonlinearities = st.one_of(
    piecewise, smooth, quantisers, st.builds(NormalCompliance, stiffness=sizes, exponent=st.just(1))
)


def sample(nonlinearity):
    """Dense on every scale, on both sides, and at the kinks."""
    x = np.logspace(-9, 9, 1801)
    kinks = np.array([float(point) for point in getattr(nonlinearity, "breakpoints", ())])
    return np.unique(np.concatenate([-x, x, kinks[kinks != 0]]))


# Sectors and slope bounds: nothing leaves them, and nothing tighter would do.


@given(nonlinearity=nonlinearities)
def test_every_chord_lies_in_the_sector_and_the_sector_is_the_hull_of_the_chords(nonlinearity):
    x = sample(nonlinearity)
    chords = nonlinearity(x) / x
    low, high = float(nonlinearity.sector.lower), float(nonlinearity.sector.upper)
    room = 1e-9 * max(abs(b) for b in (low, high) if math.isfinite(b)) + 1e-12
    assert low - room <= chords.min()
    assert chords.max() <= high + room
    # at 1e-9 and 1e9 the chord is within 50*50/1e9 of its limit; the quantiser is sampled 100 times a decade
    near = 0.05 if isinstance(nonlinearity, Quantiser) else 1e-5
    assert chords.min() <= low + near if math.isfinite(low) else chords.min() < -1e6
    assert chords.max() >= high - near if math.isfinite(high) else chords.max() > 1e6


@given(
    nonlinearity=st.one_of(piecewise, smooth),
    pairs=st.lists(st.tuples(st.floats(-99, 99), st.floats(-99, 99)), min_size=20),
)
def test_every_difference_quotient_lies_in_the_slope_bounds(nonlinearity, pairs):
    low, high = float(nonlinearity.slope_bounds.lower), float(nonlinearity.slope_bounds.upper)
    for x, y in pairs:
        if abs(x - y) > 1e-3:
            quotient = float(nonlinearity(x) - nonlinearity(y)) / (x - y)
            room = 1e-9 * (1 + abs(quotient))
            assert low - room <= quotient <= high + room


@given(nonlinearity=st.one_of(piecewise, smooth))
def test_the_slope_bounds_are_the_hull_of_the_slopes(nonlinearity):
    slopes = nonlinearity.slope(sample(nonlinearity))
    for extreme, bound in (
        (slopes.min(), float(nonlinearity.slope_bounds.lower)),
        (slopes.max(), float(nonlinearity.slope_bounds.upper)),
    ):
        assert extreme == pytest.approx(bound, abs=1e-9) if math.isfinite(bound) else abs(extreme) > 1e6


@given(nonlinearity=piecewise)
def test_the_bounds_of_a_piecewise_linear_law_are_attained_exactly(nonlinearity):
    chords = [nonlinearity.exact(x) / x for x in nonlinearity.breakpoints if x]
    ends = [
        nonlinearity.exact(x) / x
        for x in (Fraction(1, 10**9), Fraction(-1, 10**9), Fraction(10**12), Fraction(-(10**12)))
    ]
    assert all(nonlinearity.sector.lower <= chord <= nonlinearity.sector.upper for chord in chords + ends)
    for bound in (nonlinearity.sector.lower, nonlinearity.sector.upper):
        assert bound in chords or min(abs(bound - end) for end in ends) < Fraction(1, 10**6)


# the tail of slope 5 through (1, 0) has the chords 5 - 5/sigma, which come to 5 only at infinity
def test_the_slopes_outside_the_table_count():
    nonlinearity = PiecewiseLinear([(-1, 0), (1, 0)], left_slope=0, right_slope=5)
    assert nonlinearity.sector == Sector(0, 5)
    assert PiecewiseLinear([(-1, 0), (1, 0), (10, 1)], left_slope=0, right_slope=0).sector == Sector(0, Fraction(1, 10))


# y+ = y/2 + 2 u + (23/25) u_prev with u = -phi(y) repeats u = (192/415, 192/415, -1); the slope between the last two
# corners, and so the smallest slope bound of any nonlinearity with this orbit, is 1/(192/175) = 175/192
def test_the_law_of_a_known_orbit_is_exact_enough_to_keep_it():
    flat, far, near, last = Fraction(-192, 415), Fraction(-74498, 72625), Fraction(-36864, 72625), Fraction(192, 175)
    nonlinearity = PiecewiseLinear([(far, flat), (near, flat), (0, 0), (last, 1)], left_slope=0, right_slope=0)
    assert nonlinearity.slope_bounds == SlopeBounds(0, Fraction(175, 192))
    y, before = last, -nonlinearity.exact(near)
    seen = []
    for _ in range(6):
        seen.append(-nonlinearity.exact(y))
        y, before = y / 2 + 2 * seen[-1] + Fraction(23, 25) * before, seen[-1]
    assert seen == [-1, -flat, -flat] * 2
    assert y == last


@pytest.mark.parametrize(
    ("nonlinearity", "sector", "slope"),
    [
        (Saturation(gain=2, limit=1), (0, 2), (0, 2)),
        (Saturation(gain=2, limit=1, lower_limit=0), (0, 2), (0, 2)),
        (relay_with_slope(gain=Fraction(1, 3), level=7), (0, Fraction(1, 3)), (0, Fraction(1, 3))),
        (DeadZone(width=1, gain=3), (0, 3), (0, 3)),
        (ReLU(), (0, 1), (0, 1)),
        (LeakyReLU(negative_slope=Fraction(1, 10)), (Fraction(1, 10), 1), (Fraction(1, 10), 1)),
        (LeakyReLU(negative_slope=2, positive_slope=-1), (-1, 2), (-1, 2)),
        (Cubic(linear=-1), (-1, math.inf), (-1, math.inf)),
        (Cubic(linear=4, cubic=-1), (-math.inf, 4), (-math.inf, 4)),
        (Tanh(scale=Fraction(1, 100)), (0, 100), (0, 100)),
    ],
    ids=str,
)
def test_the_bounds_are_exact(nonlinearity, sector, slope):
    assert nonlinearity.sector == Sector(*sector)
    assert nonlinearity.slope_bounds == SlopeBounds(*slope)
    assert isinstance(nonlinearity.sector.upper, Fraction | int) or math.isinf(nonlinearity.sector.upper)


def test_the_quantiser_has_a_sector_and_no_slope():
    nonlinearity = Quantiser(step=Fraction(1, 2))
    assert nonlinearity.sector == Sector(0, 2)
    assert nonlinearity.slope_bounds is None
    assert "discontinuous" in nonlinearity.regularity
    assert nonlinearity.locally_lipschitz is False
    assert nonlinearity.exact(Fraction(1, 4)) / Fraction(1, 4) == 2  # the upper bound is attained at half a step
    assert nonlinearity.exact(Fraction(-1, 4)) == Fraction(-1, 2)
    assert nonlinearity.exact(Fraction(1, 4) - Fraction(1, 10**30)) == 0  # and the lower one below it


# Values, slopes and primitives against one another.


def integral(nonlinearity, end):
    """Gauss quadrature between 0, the kinks or jumps, and dyadic cuts that resolve what happens near 0."""
    cuts = [float(x) for x in getattr(nonlinearity, "breakpoints", ())]
    if isinstance(nonlinearity, Quantiser):
        cuts += [(n + 0.5) * float(nonlinearity.step) * s for n in range(1501) for s in (1, -1)]
    cuts = [x for x in cuts if min(0.0, end) < x < max(0.0, end)] + [0.0] + [end / 2**j for j in range(12)]
    cuts = np.unique(cuts)[:: 1 if end > 0 else -1]
    nodes, weights = np.polynomial.legendre.leggauss(20)
    half = np.diff(cuts)[:, None] / 2
    return float((half * weights * nonlinearity(cuts[:-1, None] + half * (nodes + 1))).sum())


@given(nonlinearity=nonlinearities, end=st.floats(-30, 30))
def test_the_primitive_is_the_integral_of_the_law(nonlinearity, end):
    assert float(nonlinearity.primitive(end)) == pytest.approx(integral(nonlinearity, end), rel=1e-9, abs=1e-12)


@given(nonlinearity=st.one_of(piecewise, smooth), x=st.floats(-30, 30))
def test_the_slope_is_the_derivative_of_the_law(nonlinearity, x):
    h = 1e-5
    assume(all(abs(float(kink) - x) > 2 * h for kink in getattr(nonlinearity, "breakpoints", ())))
    assume(not isinstance(nonlinearity, Tanh) or nonlinearity.scale > Fraction(1, 4))
    difference = float(nonlinearity(x + h) - nonlinearity(x - h)) / (2 * h)
    # error h^2 |phi'''|/6 <= 1e-10 * 2 gain/scale^3 plus the rounding 1e-16 |phi| / h
    assert difference == pytest.approx(float(nonlinearity.slope(x)), rel=1e-5, abs=1e-5)


@given(nonlinearity=nonlinearities)
def test_a_law_is_called_odd_exactly_if_it_is_its_own_mirror_image(nonlinearity):
    x = sample(nonlinearity)
    mirrored = -nonlinearity(-x)
    assert nonlinearity.odd == bool(np.allclose(mirrored, nonlinearity(x), rtol=1e-12, atol=1e-12))


@given(nonlinearity=tables(), x=numbers)
def test_exact_values_agree_with_floats_and_with_numpys_interpolation(nonlinearity, x):
    assert float(nonlinearity(float(x))) == pytest.approx(float(nonlinearity.exact(x)), rel=1e-12, abs=1e-12)
    xs, ys = ([float(value) for value in side] for side in zip(*nonlinearity.points, strict=True))
    if xs[0] <= x <= xs[-1]:
        assert float(nonlinearity.exact(x)) == pytest.approx(float(np.interp(float(x), xs, ys)), rel=1e-9, abs=1e-9)


def test_values_by_hand():
    assert Saturation(gain=2, limit=3, lower_limit=-1)([-9.0, -0.25, 1.0, 9.0]).tolist() == [-1.0, -0.5, 2.0, 3.0]
    assert DeadZone(width=2, gain=3)([-3.0, -2.0, 1.0, 4.0]).tolist() == [-3.0, 0.0, 0.0, 6.0]
    assert ReLU(gain=2)([-1.0, 3.0]).tolist() == [0.0, 6.0]
    assert LeakyReLU(negative_slope=Fraction(1, 4))([-8.0, 3.0]).tolist() == [-2.0, 3.0]
    assert Cubic(linear=1, cubic=2)([-1.0, 2.0]).tolist() == [-3.0, 18.0]
    assert Tanh(scale=2, gain=3)(2.0) == pytest.approx(3 * math.tanh(1))
    # halves go away from zero, and the double just below a half does not reach it
    assert Quantiser()([0.5, -0.5, 1.5, 2.5, 0.49999999999999994, 0.0]).tolist() == [1, -1, 2, 3, 0, 0]
    # (1 + 3)/2 over [0, 2], then 3 to 4: 0.75 + 6; left of 0: the triangle (1/2)(1/2)
    nonlinearity = Saturation(gain=2, limit=3, lower_limit=-1)
    assert nonlinearity.primitive([1.5, 3.5, -0.5, -1.5]).tolist() == [2.25, 8.25, 0.25, 1.25]
    assert nonlinearity.slope([-1.0, 0.0, 1.5, 2.0]).tolist() == [0.0, 2.0, 2.0, 0.0]
    # 3 full steps in [0, 3.2]: 0.5*0 + 1 + 2 + 0.7*3 = 5.1
    assert Quantiser().primitive([3.2, -3.2]) == pytest.approx([5.1, 5.1])


def test_tiny_arguments_keep_their_relative_accuracy():
    tiny = 1e-200
    assert Tanh(scale=2)(tiny) == pytest.approx(tiny / 2, rel=1e-15)
    assert Tanh(scale=2).primitive(1e-6) == pytest.approx(1e-12 / 4, rel=1e-12)
    assert Saturation(gain=3)(tiny) == pytest.approx(3 * tiny, rel=1e-15)


@given(nonlinearity=st.one_of(piecewise, smooth, quantisers))
def test_nan_infinity_and_shapes_pass_through_without_a_warning(nonlinearity):
    for values in (nonlinearity, nonlinearity.slope, nonlinearity.primitive):
        assert math.isnan(values(math.nan))
        assert values(np.ones((2, 3))).shape == (2, 3)
        assert values(1.0).shape == ()
        values(np.array([math.inf, -math.inf, 1e300, 0.0]))
    assert nonlinearity(0.0) == 0
    assert nonlinearity.primitive(0.0) == 0


def test_limits_at_infinity():
    assert Saturation(limit=2)([math.inf, -math.inf]).tolist() == [2.0, -2.0]
    assert Saturation(limit=2).primitive(math.inf) == math.inf
    assert Tanh(gain=2)([math.inf, -math.inf]).tolist() == [2.0, -2.0]
    assert Tanh().slope(1e6) == 0
    assert DeadZone().primitive([0.5, math.inf]).tolist() == [0.0, math.inf]
    assert PiecewiseLinear([(0, 0), (1, 1), (2, 0)], left_slope=0, right_slope=0).primitive(math.inf) == 1


def test_laws_are_equal_by_their_parameters_and_cannot_be_changed():
    assert Saturation(gain=0.5) == Saturation(gain=Fraction(1, 2))
    assert len({Tanh(), Tanh(scale=1), Tanh(scale=2)}) == 2
    with pytest.raises(AttributeError):
        Tanh().scale = Fraction(2)
    assert Tanh(scale=Fraction("0.1")).scale == Fraction(1, 10)


# What is refused.


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Saturation(gain=0), r"Saturation\.gain is 0; give a positive number"),
        (lambda: Saturation(limit=-1), r"Saturation\.limit is -1; give a positive number"),
        (lambda: Saturation(lower_limit=1), r"Saturation\.lower_limit is 1; give a number of at most 0"),
        (lambda: Saturation(limit=math.nan), r"Saturation\.limit is nan; give a finite number"),
        (lambda: DeadZone(width=0), r"DeadZone\.width is 0; give a positive number"),
        (lambda: relay_with_slope(gain=math.inf, level=1), "the ideal relay jumps at sigma = 0"),
        (lambda: relay_with_slope(gain=1, level=0), "relay with slope: level is 0; give a positive number"),
        (lambda: ReLU(gain=True), r"ReLU\.gain is True; give a number"),
        (lambda: LeakyReLU(negative_slope=1), "LeakyReLU is the straight line phi = 1 sigma"),
        (lambda: Cubic(cubic=0), r"Cubic\.cubic is 0"),
        (lambda: Tanh(scale=0), r"Tanh\.scale is 0; give a positive number"),
        (lambda: Tanh(scale=1e-300, gain=1e300), "Tanh: the slope gain/scale is outside the range"),
        (lambda: Quantiser(step=0), r"Quantiser\.step is 0; give a positive number"),
        (lambda: Quantiser(kind="mid-riser"), r"Quantiser\.kind is 'mid-riser'; only 'mid-tread' is offered"),
        (lambda: PiecewiseLinear([], left_slope=0, right_slope=0), r"PiecewiseLinear\.points is \[\]; give a list"),
        (lambda: PiecewiseLinear([1], left_slope=0, right_slope=0), r"points\[0\] is 1; give a pair"),
        (lambda: PiecewiseLinear([(1, 2, 3)], left_slope=0, right_slope=0), r"points\[0\] is \(1, 2, 3\); give a pair"),
        (lambda: PiecewiseLinear([(0, 0), (1, math.nan)], left_slope=0, right_slope=0), r"points\[1\]\[1\] is nan"),
        (lambda: PiecewiseLinear([(0, 0), (0, 1)], left_slope=0, right_slope=0), "sigma strictly ascending"),
        (lambda: PiecewiseLinear([(1, 1), (0, 0)], left_slope=0, right_slope=0), "sigma strictly ascending"),
        (
            lambda: PiecewiseLinear([(0, 1), (1, 2)], left_slope=0, right_slope=0),
            r"has phi\(0\) = 1; a nonlinearity must vanish",
        ),
        (lambda: PiecewiseLinear([(-1, 0), (1, 1)], left_slope=0, right_slope=0), r"has phi\(0\) = 0.5"),
        (lambda: PiecewiseLinear([(1, 1)], left_slope=0, right_slope=0), r"has phi\(0\) = 1"),
        (lambda: PiecewiseLinear([(-1, -1)], left_slope=0, right_slope=2), r"has phi\(0\) = 1"),
        (
            lambda: PiecewiseLinear([(-1, -2), (1, 2)], left_slope=2, right_slope=2),
            "is the straight line phi = 2 sigma",
        ),
    ],
)
def test_what_is_no_law_is_refused_in_a_sentence(make, message):
    with pytest.raises(InputError, match=f"^.*{message}"):
        make()


def test_a_straight_line_off_the_last_point_may_pass_through_the_origin():
    assert PiecewiseLinear([(-1, -2), (-3, 0)][::-1], left_slope=0, right_slope=2).exact(Fraction(5)) == 10
