"""lure.nonlinearities: nonlinearities given as formulas, and which of them are piecewise linear."""

import math
from fractions import Fraction

import numpy as np
import pytest

from lure import InputError, Sector
from lure.nonlinearities import DeadZone, ExpressionNonlinearity, LeakyReLU, ReLU, Saturation


@pytest.mark.parametrize(
    ("text", "nonlinearity"),
    [
        ("min(max(2*sigma, -1), 1)", Saturation(gain=2, limit=1)),
        ("sigma - max(min(sigma, 1), -1)", DeadZone(width=1, gain=1)),
        ("3*max(sigma, 0)", ReLU(gain=3)),
        ("where(sigma < 0, 0.1*sigma, sigma)", LeakyReLU(negative_slope=Fraction(1, 10))),
        ("(abs(sigma + 1) - abs(sigma - 1))/2", Saturation(gain=1, limit=1)),
        ("where(sigma > 1 or sigma < -1, sign(sigma), sigma)", Saturation(gain=1, limit=1)),
        ("where(not (sigma >= -1 and sigma <= 1), sigma - sign(sigma), 0*sigma)", DeadZone(width=1, gain=1)),
        ("0 if abs(sigma) <= 2 else sigma - 2*sign(sigma)", DeadZone(width=2, gain=1)),
    ],
)
def test_a_piecewise_linear_formula_is_recognised_exactly(text, nonlinearity):
    formula = ExpressionNonlinearity(text, sector=Sector(0, 5))
    assert formula.graph is not None
    assert formula.graph.sector == nonlinearity.sector
    assert formula.graph.slope_bounds == nonlinearity.slope_bounds
    assert formula.breakpoints == nonlinearity.breakpoints
    x = np.linspace(-4, 4, 81)
    assert formula(x) == pytest.approx(nonlinearity(x), abs=1e-12)
    assert formula.primitive(x) == pytest.approx(nonlinearity.primitive(x), abs=1e-12)


@pytest.mark.parametrize(
    "text",
    [
        "sigma**3",
        "tanh(sigma)",
        "sign(sigma)",  # jumps at 0
        "where(sigma < 1, sigma, 2)",  # jumps at 1
        "where(sigma == 1, 5, sigma)",  # a stray point, invisible on the open intervals
        "where(sigma*sigma < 1, sigma, 0)",
        "sigma*abs(sigma)",
        "sigma/(1 + abs(sigma))",
        "max(sigma, sqrt(2)*sigma)",
    ],
)
def test_no_other_formula_passes_for_piecewise_linear(text):
    assert ExpressionNonlinearity(text, sector=Sector(-9, 9)).graph is None


def test_many_nested_folds_are_given_up_rather_than_counted():
    # every fold |u| - 2^-n doubles the corners: 2^6 are still counted, 2^12 are not
    folded = "sigma"
    for n in range(12):
        if n == 6:
            graph = ExpressionNonlinearity(f"min(sigma, {folded}) - min(0, {folded})", sector=Sector(-9, 9)).graph
            assert len(graph.knots) > 60
        folded = f"(abs({folded}) - {2.0**-n})"
    assert (
        ExpressionNonlinearity(f"0*sigma*({folded})", sector=Sector(0, 1)).graph is not None
    )  # folded away by the parser
    assert ExpressionNonlinearity(f"{folded} - {folded}", sector=Sector(0, 1)).graph is None


@pytest.mark.parametrize(
    "text", ["sin(sigma)", "tanh(100*sigma)", "exp(sigma) - 1", "cos(sigma) - 1", "sqrt(abs(sigma))"]
)
def test_formulas_that_vanish_at_zero_are_accepted(text):
    nonlinearity = ExpressionNonlinearity(text, sector=Sector(-math.inf, math.inf))
    assert nonlinearity(0.0) == 0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("sigma + 1", r"has phi\(0\) = 1; a nonlinearity must vanish at 0"),
        ("cos(sigma)", r"has phi\(0\) = 1; a nonlinearity must vanish at 0"),
        ("sin(sigma + pi)", r"has a phi\(0\) that cannot be shown to be 0"),
        ("sigma/abs(sigma)", r"has a phi\(0\) that cannot be shown to be 0"),
        ("x", "unknown name 'x'"),
    ],
)
def test_other_formulas_are_refused(text, message):
    with pytest.raises(InputError, match=message):
        ExpressionNonlinearity(text, sector=Sector(0, 1))


def test_what_is_declared_has_its_type():
    with pytest.raises(InputError, match=r"^ExpressionNonlinearity\.sector is \(0, 1\); declare a Sector$"):
        ExpressionNonlinearity("sigma", sector=(0, 1))
    with pytest.raises(InputError, match=r"^ExpressionNonlinearity\.slope_bounds is 3; declare SlopeBounds, or None$"):
        ExpressionNonlinearity("sigma", sector=Sector(0, 1), slope_bounds=3)
    with pytest.raises(InputError, match=r"^ExpressionNonlinearity\.odd is 1; declare True or False$"):
        ExpressionNonlinearity("sigma", sector=Sector(0, 1), odd=1)


# int_0^x s/(1+s) = x - log(1+x)
def test_the_primitive_of_a_formula_is_integrated():
    nonlinearity = ExpressionNonlinearity("sigma/(1 + abs(sigma))", sector=Sector(0, 1))
    x = np.array([[0.0, 1.0], [-2.5, 40.0]])
    assert nonlinearity.primitive(x) == pytest.approx(np.abs(x) - np.log1p(np.abs(x)), rel=1e-9)
    assert nonlinearity.slope(x) == pytest.approx(1 / (1 + np.abs(x)) ** 2, rel=1e-12)


def test_a_formula_without_its_variable_is_the_zero_law():
    nonlinearity = ExpressionNonlinearity("0", sector=Sector(0, 1))
    assert nonlinearity(np.ones(3)).tolist() == [0, 0, 0]
    assert nonlinearity.slope([1.0]).tolist() == [0]
