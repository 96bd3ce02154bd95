"""lure.classes: bounds on nonlinearities, and which are refused."""

import math
from decimal import Decimal
from fractions import Fraction

import pytest

from lure import InputError, NonlinearityClass, Sector, SlopeBounds

BOUNDS = pytest.mark.parametrize("bounds", [Sector, SlopeBounds])


@BOUNDS
@pytest.mark.parametrize(
    ("lower", "upper"), [(0, 1), (-1.5, 2), (0, math.inf), (-math.inf, 0), (-math.inf, math.inf), (0, Fraction(1, 3))]
)
def test_bounds_are_kept_as_given(bounds, lower, upper):
    made = bounds(lower, upper)
    assert (made.lower, made.upper) == (lower, upper)
    assert type(made.upper) is type(upper)


@BOUNDS
@pytest.mark.parametrize(("lower", "upper"), [(1, 1), (2, 1), (math.inf, math.inf), (math.inf, 0), (0, -math.inf)])
def test_an_empty_interval_is_refused(bounds, lower, upper):
    with pytest.raises(InputError, match=rf"^{bounds.__name__} needs lower < upper; got \[{lower}, {upper}\]$"):
        bounds(lower, upper)


@BOUNDS
@pytest.mark.parametrize("bound", [True, "1", None, Decimal(1), 1j])
def test_what_is_not_a_number_is_refused(bounds, bound):
    with pytest.raises(InputError, match=rf"^{bounds.__name__}\.upper is .*; give a number \(int, float or"):
        bounds(0, bound)
    with pytest.raises(InputError, match=rf"^{bounds.__name__}\.lower is "):
        bounds(bound, 5)


@BOUNDS
def test_nan_is_refused(bounds):
    with pytest.raises(InputError, match=r"\.lower is nan, which bounds nothing; give a number"):
        bounds(math.nan, 1)
    with pytest.raises(InputError, match=r"\.upper is nan"):
        bounds(0, math.nan)


@BOUNDS
@pytest.mark.parametrize("bound", [10**400, Fraction(1, 10**400)])
def test_a_bound_that_no_double_can_hold_is_refused(bounds, bound):
    with pytest.raises(InputError, match=r"\.upper is outside the range of double precision"):
        bounds(0, bound)


def test_bounds_print_as_an_interval():
    assert str(Sector(0, Fraction(1, 4))) == "[0, 0.25]"
    assert str(SlopeBounds(-1, math.inf)) == "[-1, inf]"


def test_sectors_are_equal_by_value_and_cannot_be_changed():
    assert Sector(0, 1) == Sector(0.0, Fraction(1)) != Sector(0, 2)
    with pytest.raises(AttributeError):
        Sector(0, 1).upper = 2


def test_a_class_with_slope_bounds_alone_has_the_sector_of_these():
    assert NonlinearityClass(slope=SlopeBounds(0, 2), odd=True) == NonlinearityClass.slope_restricted(0, 2, odd=True)
    with pytest.raises(InputError, match="neither sector nor slope bounds"):
        NonlinearityClass(odd=True)
