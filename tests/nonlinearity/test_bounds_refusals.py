"""Formulas and arguments that are refused, each with one sentence that says where and what to do."""

import math
from fractions import Fraction

import pytest

from lure.analysis.nonlinearity import nonlinearity_bounds, violation
from lure.classes import Sector
from lure.errors import AssumptionError, InputError
from lure.expressions import Expression

HOSTILE = [
    ("1/x", r"at sigma = 0; it divides by zero there"),
    ("x/(x - 1)", r"pole, or divides zero by zero, at sigma = 1;"),
    ("x*(x - 1)/(x - 1)", r"at sigma = 1;"),
    ("x/(x**2 - 2)", r"at sigma = -1.414213562;"),
    ("tan(x)", r"a pole, or no value that could be enclosed, near sigma = (-1.5707|1.5707)"),
    ("x/sin(x) - 1", r"no value that could be enclosed at sigma = 0"),
    ("x/(sin(x) + 1/2)", r"near sigma = "),
    ("x**2 + x/tanh(x - 3)", r"near sigma = 3;"),  # its chord has no bounds anyway, towards both infinities
    ("sqrt(x)", r"no value that could be enclosed at sigma = -"),
    ("log(1 + x)", r"no value that could be enclosed at sigma = -"),
    ("x**0.5", r"no value that could be enclosed at sigma = -"),
    ("sqrt(1 - x**2) - 1", r"no value that could be enclosed at sigma = -"),
    ("x*sin(1/x)", r"no value that could be enclosed at sigma = 0"),
    ("x**-1", r"at sigma = 0; it divides by zero there"),
    ("cos(x)", r"phi\(0\) = 1; a sector needs a nonlinearity that vanishes at 0"),
    ("x + 1", r"phi\(0\) = 1; a sector needs a nonlinearity that vanishes at 0"),
    ("exp(x)*cos(1)**2 + sin(1)**2 - 1", r"cannot be shown to be 0"),
    ("x**33", r"between -32 and 32"),
    ("(x**32)**32", r"degree 1024; at most 256"),
    ("x**1e9", r"between -32 and 32"),
    ("x + y", r"unknown name 'y'"),
    ("x + sigma", r"uses both sigma and x"),
    ("x > 1", r"a comparison is not a number"),
    ("__import__('os')", r"not allowed|unknown name"),
    ("nan*x", r"numbers must be finite"),
    ("", r"the expression is empty"),
    ("max(abs(sin(x)), " * 40 + "x" + ")" * 40, r"nested"),
]


@pytest.mark.parametrize(("text", "message"), HOSTILE, ids=[text[:25] for text, _ in HOSTILE])
def test_hostile_formulas_are_refused_with_a_sentence(text, message):
    with pytest.raises(InputError, match=message) as caught:
        nonlinearity_bounds(text)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400


# Each has no value at 1 (or at the place named), though the rest of the formula would hide it: behind a sign, in a
# condition, under the power 0, behind a factor 0, before a part that decides.
HIDDEN = [
    "x*where(1/(x-1) > 0, 1, 3)",
    "x*sign(1/(x-1))",
    "x*where((x-1)/(x-1) > 0, 1, 3)",
    "x*where((1/(x-1))**2 > 0, 1, 3)",
    "x*where(where(1/(x-1) > 0, 1, 3) > 2, 1, 3)",
    "x*where((x**2-2)/(x**2-2) > 0, 1, 3)",  # at the root of 2
    "x*where((x-1/3)/(x-1/3) > 0, 1, 3)",
    "x*where(sign(1/(x-1)) > 0, 1, 3)",
    "x*where(1/abs(x-1) > 0, 1, 3)",
    "x*where(1/(x-1) > 0 or 1 > 0, 1, 3)",
    "x*where(1/(x-1) > 0 and 1 < 0, 1, 3)",
    "x*where(not 1/(x-1) > 0, 1, 3)",
    "x*where(1/(x-1) > 0, 1, 1)",
    "x*where((x-1)**-32 > 0, 1, 3)",
    "x*where(0*log(abs(x-1)) == 0, 1, 3)",
    "x*where(1/(exp(x)-2) > 0, 1, 3)",  # at log 2
    "x*where(sqrt(-abs(x-1)) >= 0, 1, 3)",
    "x*where(1/x > 0, 1, 3)",  # at 0
    "sign(1/x)*x**2",
    "x*log(abs(x-1))**0",
    "x*max(2, sign(1/(x-1)))",
    "x*max(1, (x-1)/(x-1))",
    "x*(1 + 0*sign(1/(x-1)))",
    "exp(x)*x*where(1/(x-1) > 0, 1, 3)",
]


@pytest.mark.parametrize("text", HIDDEN)
def test_a_formula_without_a_value_somewhere_is_never_certified(text):
    with pytest.raises(InputError, match=r"value|pole|divides"):
        nonlinearity_bounds(text)


@pytest.mark.parametrize(
    ("text", "sector"),
    [
        ("x*where(x != 1 and 1/(x-1) > 0, 1, 3)", Sector(1, 3)),  # and stops where x = 1
        ("x*where(1 < 0 and 1/(x-1) > 0, 1, 3)", Sector(3, 3.5)),
        ("exp(0)*x*where(x == 1, 2, max(1, min(2, 1/abs(x-1))))", Sector(1, 2)),  # not taken at 1
    ],
)
def test_a_part_that_is_not_reached_needs_no_value(text, sector):
    found = nonlinearity_bounds(text).sector
    assert sector.lower <= found.lower <= found.upper <= sector.upper
    assert found.upper > sector.upper - 0.6


@pytest.mark.parametrize(
    ("text", "on", "sector"),
    [("x/(x - 1)", (-1, 0.5), (-1, -0.5)), ("x/(2 - x)", (0, 1), (0.5, 1)), ("sqrt(4 + x) - 2", (0, 5), (0.2, 0.25))],
)
def test_an_interval_without_the_pole_is_bounded(text, on, sector):
    # x/(x - 1): chord 1/(x - 1) from -2 at 1/2 to -1/2 at -1; 1/(2 - x); 1/(2 + sqrt(4 + x))
    found = nonlinearity_bounds(text, on=on)
    if text == "x/(x - 1)":
        sector = (-2, -0.5)
    assert (float(found.sector_lower.inner), float(found.sector_upper.inner)) == pytest.approx(sector, abs=1e-14)


def test_an_interval_away_from_zero_needs_no_law_that_vanishes_there():
    found = nonlinearity_bounds("cos(x)", on=(1, 3))
    assert float(found.sector_upper.inner) == pytest.approx(0.5403023058681398)  # cos(1)/1
    with pytest.raises(InputError, match="vanishes at 0"):
        nonlinearity_bounds("cos(x)", on=(0, 3))


@pytest.mark.parametrize("on", [(1, 1), (2, 1), (0, float("inf")), (0, float("nan")), "ab", 3, (1, 2, 3), ("a", "b")])
def test_intervals_that_are_none(on):
    with pytest.raises(InputError, match="on"):
        nonlinearity_bounds("x", on=on)


def test_arguments_that_are_no_laws():
    with pytest.raises(
        InputError, match=r"give a formula in sigma, a nonlinearity of lure.nonlinearities, or a " r"function"
    ):
        nonlinearity_bounds(3)
    with pytest.raises(InputError, match="has the variables"):
        nonlinearity_bounds(Expression.parse("t + x", variables=("t", "x")))
    with pytest.raises(InputError, match="lipschitz is for a nonlinearity given as a function"):
        nonlinearity_bounds("x", lipschitz=1)
    with pytest.raises(InputError, match="samples is 3"):
        nonlinearity_bounds(abs, samples=3)


@pytest.mark.parametrize(
    ("nonlinearity", "message"),
    [
        (lambda x: 1 / x, r"cannot be evaluated|no finite value"),
        (lambda x: x + 1, r"phi\(0\) = 1"),
        (lambda x: x * float("nan"), "no finite value at sigma"),
        (lambda x: "a", "cannot be evaluated"),
        (lambda: 0, "cannot be evaluated"),
    ],
)
def test_functions_that_are_no_laws(nonlinearity, message):
    with pytest.raises(InputError, match=message):
        nonlinearity_bounds(nonlinearity)


def test_a_constant_that_the_sample_contradicts():
    with pytest.raises(AssumptionError, match=r"its slope between sigma = .* give a constant that holds"):
        nonlinearity_bounds(lambda x: 2 * x, lipschitz=1)
    with pytest.raises(InputError, match="lipschitz is -1; give a positive number"):
        nonlinearity_bounds(abs, lipschitz=-1)


def test_a_violation_is_not_looked_for_where_there_is_none():
    assert violation("tanh(x)", Sector(0, 1)) is None


@pytest.mark.parametrize(
    "text",
    [
        "x*sign(sqrt(x))**2",
        "x + 0*sqrt(x)",
        "x + 0/log(x)",
        "where(x < sqrt(x), x, x/2)",
        "where(log(x) < 0, x, x)",
        "max(x, min(x, x*sign(sqrt(-x))))",
    ],
)
def test_what_hides_a_root_of_a_negative_number_has_no_value_either(text):
    # for numpy 0*nan and sign(nan) are nan, and a comparison with nan is neither true nor false
    with pytest.raises(InputError, match="no value that could be enclosed at sigma"):
        nonlinearity_bounds(text)


def test_numbers_beyond_all_doubles_are_bounds_like_others():
    straight = nonlinearity_bounds(
        "x*(1e300)**3"
    )  # one chord slope, 1e900: the doubles around it are the largest and inf
    assert (straight.sector.lower, straight.sector.upper) == (Fraction(1.7976931348623157e308), math.inf)
    with pytest.raises(InputError, match="could be enclosed"):  # exp(1e6) towards infinity
        nonlinearity_bounds("x*exp(1e6*tanh(x))")
