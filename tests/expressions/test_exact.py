"""lure.exact: what number an input denotes, and square roots of exact numbers."""

import math
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lure.errors import InputError
from lure.exact import exact_number, square_root


@pytest.mark.parametrize("tenth", [Fraction("0.1"), Decimal("0.1"), Fraction(1, 10)])
def test_a_decimal_is_kept_as_the_decimal_it_is(tenth):
    assert exact_number(tenth, "x") == Fraction(1, 10)


def test_a_double_means_the_double_and_not_the_decimal_it_was_typed_as():
    # the double nearest to 0.1 is 0.1000000000000000055511151231257827...
    assert exact_number(0.1, "x") == Fraction(3602879701896397, 2**55) != Fraction(1, 10)


@given(value=st.floats(allow_nan=False, allow_infinity=False))
def test_no_finite_double_is_changed(value):
    assert float(exact_number(value, "x")) == value


@pytest.mark.parametrize("value", [np.float64(0.25), np.float32(0.25), np.array(0.25), np.int64(3), np.uint8(3)])
def test_numpy_scalars_are_numbers_too(value):
    assert exact_number(value, "x") == Fraction(value.item())


@pytest.mark.parametrize("value", [5e-324, 1.7976931348623157e308, 0, -0.0, Decimal("-0.0"), 10**300])
def test_the_whole_range_of_doubles_is_accepted(value):
    assert exact_number(value, "x") == Fraction(value)


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (True, "True"),
        (False, "False"),
        (np.True_, "True"),
        ("1", "'1'"),
        (None, "None"),
        (1j, "1j"),
        ([1.0], r"\[1.0\]"),
        (np.array([1.0]), r"array\(\[1\.\]\)"),
    ],
)
def test_what_is_not_a_number_is_refused_by_name(value, shown):
    with pytest.raises(InputError, match=rf"^rod\.length is {shown}; give a number$"):
        exact_number(value, "rod.length")


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (math.nan, "nan"),
        (math.inf, "inf"),
        (-math.inf, "-inf"),
        (np.float64("nan"), "nan"),
        (Decimal("NaN"), "NaN"),
        (Decimal("sNaN"), "sNaN"),
        (Decimal("-Infinity"), "-Infinity"),
    ],
)
def test_what_is_not_finite_is_refused(value, shown):
    with pytest.raises(InputError, match=rf"^rod\.length is {shown}; give a finite number$"):
        exact_number(value, "rod.length")


# a Fraction of the last two would need gigabytes: they must be refused before one is made
@pytest.mark.parametrize(
    "value",
    [10**400, -(10**400), Fraction(1, 10**400), Decimal("1e400"), Decimal("1e999999999"), Decimal("1e-999999999")],
)
def test_what_no_double_can_hold_is_refused(value):
    with pytest.raises(InputError, match=r"^rod\.length is outside the range of double precision"):
        exact_number(value, "rod.length")


def test_a_long_text_does_not_flood_the_message():
    with pytest.raises(InputError) as refusal:
        exact_number("9" * 100_000, "rod.length")
    assert len(str(refusal.value)) < 100


@given(root=st.floats(1e-200, 1e200))
def test_the_root_of_the_square_of_a_double_is_that_double(root):
    assert square_root(Fraction(root) ** 2) == root


@given(
    numerator=st.integers(1, 10**40),
    denominator=st.integers(1, 10**40),
    power=st.integers(-600, 600),
)
def test_the_square_root_is_the_nearest_double(numerator, denominator, power):
    value = Fraction(numerator, denominator) * Fraction(2) ** power
    root = square_root(value)
    # no other double is nearer: the root lies between the midpoints to both neighbours
    below, above = (Fraction(math.nextafter(root, end)) for end in (0.0, math.inf))
    assert ((below + Fraction(root)) / 2) ** 2 <= value <= ((above + Fraction(root)) / 2) ** 2


def test_the_square_root_knows_zero_and_overflow():
    assert square_root(Fraction(0)) == 0.0
    assert square_root(Fraction(10) ** 700) == math.inf
    assert square_root(Fraction(1, 10**700)) == 0.0
