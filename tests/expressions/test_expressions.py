"""Derivatives, balls at branches, growing exact values and breakpoints of formulas."""

import pickle
import tracemalloc
from fractions import Fraction
from itertools import pairwise

import flint
import numpy as np
import pytest
from counting import counted
from formulas import TX, contains, of_t
from hypothesis import given
from hypothesis import strategies as st

from lure.errors import InputError
from lure.expressions import Expression

# The derivative of the other functions.

SMOOTH = [
    *(
        "sin(t)",
        "cos(2*t)",
        "tan(t)",
        "exp(-t**2)",
        "log(1 + t)",
        "sqrt(t)",
        "tanh(3*t)",
        "atan(t)",
        "t**1.5",
        "t**-0.5",
    ),
    *("t**(1/3)*sin(pi*t)", "exp(sin(t))/(1 + t)", "sin(cos(tanh(t)))", "t**-32/1e9", "sqrt(1 + t**2)**3", "2**0.5*t"),
    *(
        "where(t < 0.4, sin(t), t**2)",
        "max(t, t**2)*exp(t)",
        "abs(t - 1)*log(t)",
        "t*sign(t - 2)",
        "min(sin(t), cos(t))",
    ),
]
TIMES = np.array([0.31, 0.5, 0.63, 0.77, 0.9])  # none of them at a kink above (0.4, pi/4, 1, 2)


@pytest.mark.parametrize("text", SMOOTH)
def test_derivative_agrees_with_central_differences(text):
    # Fourth-order stencil: truncation about h^4 f^(5)/30, rounding about eps*f/h; with h = 1e-3 both are below 1e-8
    # relative but for t**-32 at 0.31, where f^(5) h^4/(30 f') = 33*34*35*36 h^4/(30 t^4) = 5e-6.
    nonlinearity, h = of_t(text), 1e-3
    quotient = (
        8 * (nonlinearity(t=TIMES + h) - nonlinearity(t=TIMES - h))
        - (nonlinearity(t=TIMES + 2 * h) - nonlinearity(t=TIMES - 2 * h))
    ) / (12 * h)
    np.testing.assert_allclose(nonlinearity.derivative("t")(t=TIMES), quotient, rtol=1e-5, atol=1e-9)


@pytest.mark.parametrize("text", SMOOTH)
def test_a_coarse_ball_contains_the_fine_one_for_every_function(text):
    for expression in (of_t(text), of_t(text).derivative("t")):
        before = flint.ctx.prec
        try:
            flint.ctx.prec = 300
            point = flint.arb(flint.fmpq(31, 100))
            fine = expression.ball(t=point)
            flint.ctx.prec = 30
            coarse, wide = expression.ball(t=point), expression.ball(t=flint.arb(0.31, 0.01))
            assert fine.rad() < 1e-60
            assert coarse.contains(fine)
            assert wide.contains(fine)
            assert float(fine.mid()) == pytest.approx(float(expression(t=0.31)), rel=1e-12)
        finally:
            flint.ctx.prec = before


def test_the_derivative_of_the_lowest_power_can_be_read_back():
    slope = of_t("t**-32").derivative("t")
    assert of_t(str(slope)).exact(t=2) == slope.exact(t=2) == Fraction(-32, 2**33)


def test_kinks_and_jumps_are_passed_over():
    assert str(of_t("abs(t)").derivative("t")) == "sign(t)"
    assert of_t("sign(t)").derivative("t").is_zero
    assert of_t("where(t < 1, 2, 3)").derivative("t").is_zero
    assert of_t("log(2)*3").derivative("t").is_zero
    assert str(of_t("max(t, 1)").derivative("t")) == "where(t > 1, 1, 0)"
    assert Expression.parse("log(x)*t", variables=TX).derivative("t") == Expression.parse("log(x)", variables=TX)
    assert str(of_t("log(t)*2").derivative("t")) == "(1/t)*2"
    slope = of_t("abs(t)").derivative("t").ball(t=flint.arb(0, 0.5))
    assert slope.contains(1)
    assert slope.contains(-1)


def differentiated(nonlinearity, *, times):
    for _ in range(times):
        nonlinearity = nonlinearity.derivative("t")
    return nonlinearity


@pytest.mark.slow
def test_derivatives_that_explode_are_refused_and_deep_ones_still_evaluate():
    nested = of_t("/".join(["(t + 2)"] * 15))
    deep = nested.derivative("t").derivative("t")
    # f = s**-13 with s = t + 2, so f'' = 182 s**-15.
    assert deep.exact(t=0) == Fraction(182, 2**15)
    assert deep(t=0.0) == pytest.approx(182 / 2**15)
    assert contains(deep.ball(t=flint.arb(0)), Fraction(182, 2**15))
    assert pickle.loads(pickle.dumps(deep)) == deep
    with counted() as work, pytest.raises(InputError, match="too large"):
        differentiated(deep, times=20)
    assert work.calls < 10**6


# Balls and branches.


def hull(ball):
    return float(ball.lower()), float(ball.upper())


@pytest.mark.parametrize(
    ("text", "low", "high"),
    [
        ("where(t < 0, -3, 5)", -3, 5),
        ("where(t >= 0, -3, 5)", -3, 5),
        ("where(t == 0, -3, 5)", -3, 5),
        ("where(t != 0, -3, 5)", -3, 5),
        ("where(t < 2 and not t > 0, -3, 5)", -3, 5),
        ("where(t > 2 or t > 0, -3, 5)", -3, 5),
        ("where(t > 2 and t > 0, -3, 5)", 5, 5),
        ("where(t < 2 or t > 0, -3, 5)", -3, -3),
        ("where(t != 2, -3, 5)", -3, -3),
        ("where(-2 <= t <= 2, -3, 5)", -3, -3),
        ("where(1/t > 0, -3, 5)", -3, 5),
        ("sign(t)", -1, 1),
        ("sign(t - 2)", -1, -1),
        ("abs(t)", 0, 1),
        ("max(t, 0.5)", 0.5, 1),
        ("min(t, 0.5)", -1, 0.5),
        ("t**2", 0, 1),
        ("t**3", -1, 1),
        ("abs(t)**1.5", 0, 1),
        ("sqrt(abs(t))", 0, 1),
        ("sqrt(t**2)", 0, 1),
        ("sqrt(exp(30*t))", 0, 3269017.4),
        ("(t + 3)**-2", 1 / 16, 1 / 4),
    ],
)
def test_undecided_conditions_take_the_hull_of_both_branches(text, low, high):
    ball = of_t(text).ball(t=flint.arb(0, 1))
    got = hull(ball)
    assert got[0] <= low
    assert got[1] >= high
    # min and max of Arb keep the ball symmetric, which costs up to the distance to the other end.
    slack = 2 if text.startswith(("min", "max")) else 1e-6 * max(1, high)
    assert got == pytest.approx((low, high), abs=slack)


@pytest.mark.parametrize("text", ["1/t", "log(t)", "sqrt(t)", "t**0.5", "t**-2", "tan(2*t)", "where(t > 0, log(t), 0)"])
def test_a_ball_that_reaches_where_nothing_is_defined_is_nan(text):
    assert of_t(text).ball(t=flint.arb(0, 1)).is_nan()


def test_numbers_in_balls_are_decimal_not_binary():
    assert of_t("0.1 + t").ball(t=flint.arb(0)).contains(flint.arb(flint.fmpq(1, 10)))
    assert not flint.arb(0.1).contains(flint.arb(flint.fmpq(1, 10)))


# Exact values that grow.


def test_exact_values_stop_growing_before_memory_does():
    tower = of_t("(((t**32)**32)**32)**32")
    tracemalloc.start()
    with pytest.raises(InputError, match="more than 65536 bits"):
        tower.exact(t=Fraction(7, 3))
    with pytest.raises(InputError, match="divides by zero"):
        of_t("1/t").exact(t=0)
    with pytest.raises(InputError, match="divides by zero"):
        of_t("(1/t)**0").exact(t=0)
    with pytest.raises(InputError, match="more than 65536 bits"):
        of_t("t*t").exact(t=2**40000)
    with pytest.raises(InputError, match="power 1/2 has no exact"):
        of_t("t**0.5").exact(t=4)
    assert of_t("((9**32)**32)**32 - t").is_constant is False
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 2**20  # (7/3)^(32^4) has 3 million bits in the numerator alone


# Breakpoints.


@pytest.mark.parametrize(
    ("text", "points"),
    [
        ("sin(t)", ()),
        ("where(t < 1/3, t, 0)", (Fraction(1, 3),)),
        ("t if 2 <= 4*t < 10 else 0", (Fraction(1, 2), Fraction(5, 2))),
        ("abs(t - 1) + max(2*t, 3) - sign(-t + 2)/7", (1, Fraction(3, 2), 2)),
        ("where(t < 7, 1, where(t < -1, 2, 3))", ()),
        ("where(1 < 2, t, 0)", ()),
        ("where((t - 1)/2 + 0*t > 0.25, 1, 2)", (Fraction(3, 2),)),
        ("where(t**2 < 2, 1, 2)", None),
        ("where(t < pi, 1, 2)", None),
        ("where(t < x, 1, 2)", None),
        ("max(abs(t), 1)", None),
        ("where(1/t < 2, 1, 2)", None),
        ("where(t*t < 2, 1, 2)", None),
        ("where(0 < t < 3, 1, 2)", ()),
    ],
)
def test_breakpoints_are_the_switches_of_linear_conditions(text, points):
    assert Expression.parse(text, variables=TX).breakpoints("t", 0, 3) == points


@given(
    lines=st.lists(st.tuples(st.integers(-3, 3), st.integers(-6, 6)), min_size=1, max_size=4),
    where=st.floats(0.01, 0.99),
)
def test_between_breakpoints_a_sum_of_kinks_is_linear(lines, where):
    nonlinearity = of_t(" + ".join(f"abs({a}*t + {b})*{k + 1}" for k, (a, b) in enumerate(lines)))
    ends = (Fraction(-10), *nonlinearity.breakpoints("t", -10, 10), Fraction(10))
    for low, high in pairwise(ends):
        inner = low + (high - low) * Fraction(where)
        chord = nonlinearity.exact(t=low) + (nonlinearity.exact(t=high) - nonlinearity.exact(t=low)) * Fraction(where)
        assert nonlinearity.exact(t=inner) == chord
