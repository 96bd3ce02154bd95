"""lure.nonlinearities.base: the normal compliance law, its sector, its slope and its primitive."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from lure import InputError, Sector
from lure.classes import SlopeBounds
from lure.rod import NormalCompliance

stiffnesses, exponents = st.floats(1e-6, 1e6), st.floats(0.25, 5)
penetrations = st.floats(-1e3, 1e3)


def test_the_law_is_zero_up_to_contact_and_a_power_beyond():
    # 4 r^2 at r = 3 is 36, its slope 8 r = 24, its primitive 4 r^3 / 3 = 36
    nonlinearity = NormalCompliance(4, 2)
    r = [-7.0, 0.0, 3.0]
    assert nonlinearity(r).tolist() == [0.0, 0.0, 36.0]
    assert nonlinearity.slope(r).tolist() == [0.0, 0.0, 24.0]
    assert nonlinearity.primitive(r).tolist() == [0.0, 0.0, 36.0]


def test_the_law_of_the_paper_is_the_exponent_one():
    # (9): p(r) = r/eps for r >= 0
    nonlinearity = NormalCompliance(1 / 0.125)
    assert nonlinearity(0.5) == 4.0
    assert nonlinearity.exponent == 1.0


@given(stiffness=stiffnesses, exponent=exponents, r=penetrations)
def test_the_law_lies_in_its_sector(stiffness, exponent, r):
    nonlinearity = NormalCompliance(stiffness, exponent)
    product = r * float(nonlinearity(r))
    assert nonlinearity.sector.lower == 0
    assert (
        0
        <= product
        <= (math.inf if nonlinearity.sector.upper == math.inf else float(nonlinearity.sector.upper) * r * r)
    )


# the chord slope c_n r^(m-1) has the supremum c_n for m = 1 and none otherwise: r = X^(1/(m-1)) reaches c_n X
@given(stiffness=stiffnesses, exponent=exponents.filter(lambda m: abs(m - 1) > 0.1), multiple=st.floats(2, 1e3))
def test_no_finite_sector_holds_another_exponent_than_one(stiffness, exponent, multiple):
    nonlinearity = NormalCompliance(stiffness, exponent)
    r = multiple ** (1 / (exponent - 1))
    assert float(nonlinearity(r)) / r == pytest.approx(stiffness * multiple)
    assert nonlinearity.sector == Sector(0, math.inf)
    assert nonlinearity.slope_bounds == SlopeBounds(0, math.inf)


@given(stiffness=stiffnesses)
def test_the_linear_law_attains_its_sector(stiffness):
    nonlinearity = NormalCompliance(stiffness)
    assert float(nonlinearity(1.0)) == nonlinearity.sector.upper == nonlinearity.slope_bounds.upper == stiffness


@given(stiffness=stiffnesses, exponent=exponents, r=penetrations, step=st.floats(0, 1e3))
def test_the_law_never_falls(stiffness, exponent, r, step):
    nonlinearity = NormalCompliance(stiffness, exponent)
    assert float(nonlinearity(r + step)) >= float(nonlinearity(r)) >= 0


@given(stiffness=stiffnesses, exponent=exponents, r=st.floats(-5, 5))
def test_the_primitive_is_the_integral_of_the_law(stiffness, exponent, r):
    nonlinearity = NormalCompliance(stiffness, exponent)
    integral, error = quad(lambda x: float(nonlinearity(x)), 0, r)
    assert float(nonlinearity.primitive(r)) == pytest.approx(integral, rel=1e-7, abs=10 * error)


@given(stiffness=stiffnesses, exponent=exponents, r=st.floats(1e-2, 1e2))
def test_the_slope_is_the_derivative_of_the_law(stiffness, exponent, r):
    nonlinearity, h = NormalCompliance(stiffness, exponent), 1e-4 * r
    # central difference: relative error (h/r)^2 |m-1||m-2|/6 <= 2e-8
    assert float(nonlinearity(r + h) - nonlinearity(r - h)) / (2 * h) == pytest.approx(
        float(nonlinearity.slope(r)), rel=1e-6
    )


@pytest.mark.parametrize(("exponent", "lipschitz"), [(1, True), (1.5, True), (Fraction(999, 1000), False)])
def test_the_law_is_locally_lipschitz_from_the_exponent_one_on(exponent, lipschitz):
    assert NormalCompliance(1, exponent).locally_lipschitz is lipschitz


def test_the_sector_keeps_the_exact_stiffness():
    third = Fraction(1, 3)
    nonlinearity = NormalCompliance(third)
    assert nonlinearity.sector == Sector(0, third)
    assert nonlinearity.stiffness == 1 / 3
    # an exponent that only rounds to one is not one
    assert NormalCompliance(1, 1 + Fraction(1, 10**30)).sector.upper == math.inf


def test_nan_comes_back_as_nan_and_overflow_as_infinity_without_a_warning():
    nonlinearity = NormalCompliance(1e300, 3)
    for values in (nonlinearity, nonlinearity.slope, nonlinearity.primitive):
        assert math.isnan(values(math.nan))
        assert values(1e200) == math.inf


def test_values_take_the_shape_of_the_argument():
    nonlinearity = NormalCompliance(2)
    for values in (nonlinearity, nonlinearity.slope, nonlinearity.primitive):
        assert values(np.ones((2, 3))).shape == (2, 3)
        assert values(1.0).shape == ()


@pytest.mark.parametrize("name", ["stiffness", "exponent"])
@pytest.mark.parametrize(
    ("value", "message"),
    [
        (0, "is 0; give a positive number"),
        (-1.5, "is -1.5; give a positive number"),
        (math.nan, "is nan; give a finite number"),
        (math.inf, "is inf; give a finite number"),
        (True, "is True; give a number"),
        ("one", "is 'one'; give a number such as 2, -0.5, 1e-3 or 2/3"),
    ],
)
def test_a_parameter_that_is_not_positive_and_finite_is_refused(name, value, message):
    with pytest.raises(InputError, match=rf"^NormalCompliance\.{name} {message}$"):
        NormalCompliance(**{"stiffness": 1, "exponent": 1, name: value})


def test_the_rigid_limit_is_named_where_it_is_looked_for():
    assert "Signorini" in NormalCompliance.__doc__


def test_stiffer_laws_tend_to_the_signorini_condition():
    # under a fixed stress 1 the penetration is (1/c_n)^(1/m) -> 0, and short of contact there is no stress at all
    for exponent in (1, 2):
        depths = [(1 / NormalCompliance(c, exponent).stiffness) ** (1 / exponent) for c in (1, 1e4, 1e8)]
        assert depths == sorted(depths, reverse=True)
        assert depths[-1] <= 1e-4
        assert NormalCompliance(1e8, exponent)(depths[-1]) == pytest.approx(1)
