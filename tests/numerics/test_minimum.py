"""Branch and bound in ball arithmetic: brackets contain known minima, failures only widen them."""

import math

import pytest
from depth import sampled
from flint import arb, ctx
from hypothesis import given, settings
from hypothesis import strategies as st

from lure.analysis.numerics.minimum import _taylor_bound, minimum
from lure.analysis.numerics.precision import ball, outward, working_precision


def close(best):
    return abs(best) * arb("1e-9") + arb("1e-12")


# (x - c)^2 + m has its minimum m at c
@given(c=st.floats(-3, 3), m=st.floats(-5, 5))
def test_the_bracket_contains_the_minimum_of_a_parabola(c, m):
    found = minimum(lambda x: (x - ball(c)) * (x - ball(c)) + ball(m), arb(-4), arb(4), width=close)
    assert found.low <= ball(m)
    assert found.high >= ball(m)
    assert float(found.high - found.low) <= 1e-9 * abs(m) + 1e-11
    assert float(found.where) == pytest.approx(c, abs=1e-4)


# a dip of depth 1 and width 1e-9 on a flat floor, which no grid of a million points would see: 1 - 1/(1 + (x -
# c)^2/w^2)
@given(c=st.floats(-0.9, 0.9))
def test_a_dip_a_billionth_wide_is_found(c):
    width = arb("1e-9")

    def dip(x):
        u = (x - ball(c)) / width
        return 1 - 1 / (1 + u * u)

    found = minimum(dip, arb(-1), arb(1), width=close)
    assert found.high < arb("1e-6")
    assert found.low <= 0


def polynomial(coefficients):
    def f(x):
        total = 0 * x
        for c in reversed(coefficients):
            total = total * x + c
        return total

    return f


# degree 8 is beyond the order of the expansion: the remainder on the box has to carry the rest
@given(
    coefficients=st.lists(st.integers(-9, 9), min_size=1, max_size=9),
    left=st.floats(-2, 2),
    length=st.floats(0.01, 3),
    at=st.floats(0, 1),
)
def test_the_taylor_bound_lies_below_the_function_on_its_box(coefficients, left, length, at):
    f = polynomial(coefficients)
    box = ball(left).union(ball(left + length))
    point = ball(left) + (ball(left + length) - ball(left)) * ball(at)
    assert not _taylor_bound(f, box, box.mid()) > f(point)


@pytest.mark.parametrize("power", range(1, 7))
@pytest.mark.parametrize("sign", [-1, 1])
def test_the_taylor_bound_of_a_power_is_sound_at_both_ends(power, sign):
    f = polynomial([0] * power + [sign])
    box = arb(-1).union(arb(1))
    bound = _taylor_bound(f, box, box.mid())
    assert not bound > f(arb(-1))
    assert not bound > f(arb(1))
    assert bound >= -1.001  # and not weaker than it need be


# x is least at the left end, -x at the right end
@pytest.mark.parametrize(("sign", "value"), [(1, -2.0), (-1, -3.0)])
def test_a_minimum_at_an_end_is_found(sign, value):
    found = minimum(lambda x: sign * x, arb(-2), arb(3), width=close)
    assert found.low <= ball(value) <= found.high


@pytest.mark.slow
def test_a_function_that_is_nowhere_finite_gives_no_lower_bound():
    found = minimum(lambda x: x / (x - x), arb(0), arb(1), width=close)
    assert not found.low.is_finite()
    assert not found.closed


def test_a_known_floor_is_used_where_the_boxes_fail():
    found = minimum(lambda x: 1 + 0 * (x / (x - x)), arb(0), arb(1), width=close, floor=arb(1))
    assert float(found.low) == 1.0


@given(value=st.floats(allow_nan=False, allow_infinity=False))
def test_rounding_to_doubles_goes_outwards(value):
    exact = ball(value)
    bracket = outward(exact, exact)
    assert bracket.low <= value <= bracket.high
    third = outward(exact / 3, exact / 3)
    assert arb(third.low) <= exact / 3 or math.isinf(third.low)
    assert arb(third.high) >= exact / 3 or math.isinf(third.high)


def test_infinite_bounds_survive_rounding():
    assert outward(arb("inf"), arb("inf")).low == math.inf
    assert outward(arb("-inf"), arb(1)).low == -math.inf
    assert outward(arb("nan"), arb("nan")).high == math.inf


def test_precision_is_put_back_after_an_error():
    def fail():
        with working_precision(333):
            raise RuntimeError(str(ctx.prec))

    before = ctx.prec
    with pytest.raises(RuntimeError, match="333"):
        fail()
    assert ctx.prec == before


# two digits of precision: the answers get wide, never wrong
@given(c=st.floats(-3, 3), m=st.floats(-5, 5))
@settings(max_examples=sampled(4, of=100))
@pytest.mark.slow
def test_few_bits_widen_the_bracket_and_keep_it_valid(c, m):
    with working_precision(10):
        found = minimum(lambda x: (x - ball(c)) * (x - ball(c)) + ball(m), arb(-4), arb(4), width=lambda b: abs(b) / 4)
        low, high = found.low, found.high
    assert not low > ball(m)
    assert not high < ball(m)


# flint.ctx.cap is a global that cuts every series short: a coefficient cut off is unknown, not zero
@pytest.mark.parametrize("cap", [1, 2, 4, 6])
def test_a_series_cut_short_gives_no_taylor_bound(cap):
    before, ctx.cap = ctx.cap, cap
    try:
        assert not _taylor_bound(lambda x: x * x.cos(), arb(3, 1), arb(3)).is_finite()
    finally:
        ctx.cap = before


@pytest.mark.parametrize("cap", [1, 2, 10])
def test_the_length_of_a_series_is_set_with_the_precision_and_put_back(cap):
    before, ctx.cap = ctx.cap, cap
    try:
        with working_precision(64):
            assert _taylor_bound(lambda x: x * x.cos(), arb(3, 1), arb(3)).is_finite()
        assert ctx.cap == cap
    finally:
        ctx.cap = before
