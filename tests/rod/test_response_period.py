"""Periods of loads that follow from the formula, and those that do not."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lure.analysis.rod.response import load_period, proved_period
from lure.errors import InputError
from lure.expressions import Expression
from lure.rod import Scenario

PI = math.pi


def period(text):
    return proved_period(Expression.parse(text, variables=("t",), field="force.g"))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("sin(4*t)", PI / 2),
        ("sin(-4*t + 1)", PI / 2),
        ("2 + 3*cos(t/2)", 4 * PI),
        ("tan(t)**2", PI),
        ("sin(2*t) + sin(3*t)", 2 * PI),
        ("sin(t/6) * cos(t/4)", 24 * PI),  # 12 pi and 8 pi
        ("sin(2*pi*t/3) + cos(2*pi*50*t)", 3.0),
        ("abs(sin(pi*t)) + max(cos(pi*t), 0)", 2.0),  # the least is 1 and 2: any common one will do
        ("where(sin(t) > 0, 1, 0)", 2 * PI),
        ("exp(sin(t)) + 1/(2 + cos(2*t))", 2 * PI),
        ("sin(cos(t) + 2)", 2 * PI),
        ("sin(sqrt(2)*t) + cos(3*sqrt(2)*t)", PI * math.sqrt(2)),
        ("sin((t + 2*t)*0.1) + sin(t - 0.4*t)", 20 * PI / 3),  # slopes 3/10 and 6/10
        ("sin(t*pi/(2*pi))", 4 * PI),
        ("1 + exp(2)", None),
        ("0*t + 3", None),
    ],
)
def test_a_period_follows_from_the_formula(text, expected):
    assert period(text) == (None if expected is None else pytest.approx(expected, rel=1e-14))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("t", "t appears outside sin, cos and tan"),
        ("sin(t**2)", "t appears outside"),
        ("exp(-t)*sin(t)", "t appears outside"),
        ("where(t < 1, sin(t), 0)", "t appears outside"),
        ("sin(t) + sin(pi*t)", "no common multiple"),
        ("sin(t) + sin(sqrt(2)*t)", "no common multiple"),
        ("sin(t) + sin((1 + 10**-20)*exp(0)*t)", "no common multiple"),
    ],
)
def test_what_does_not_follow_is_refused_with_the_reason(text, reason):
    with pytest.raises(InputError, match=reason) as refusal:
        period(text)
    assert "give the period if you know one" in str(refusal.value)
    assert "\n" not in str(refusal.value)


RATIONALS = st.builds(Fraction, st.integers(1, 12), st.integers(1, 12))


@given(rates=st.lists(RATIONALS, min_size=1, max_size=4))
def test_the_period_of_a_sum_of_sines_is_the_least_common_one(rates):
    text = " + ".join(f"sin({rate.numerator}*t/{rate.denominator})" for rate in rates)
    turns = [period(text) / (2 * PI) * float(rate) for rate in rates]  # whole turns of each, with no common divisor
    whole = [round(turn) for turn in turns]
    assert turns == pytest.approx(whole, rel=1e-12)
    assert math.gcd(*whole) == 1


@given(rates=st.lists(RATIONALS, min_size=1, max_size=3), t=st.floats(0, 10))
def test_a_load_is_the_same_one_period_later(rates, t):
    text = " * ".join(f"(2 + cos({rate.numerator}*pi*t/{rate.denominator}))" for rate in rates)
    load = Expression.parse(text, variables=("t",))
    found = proved_period(load)
    assert load(t=t + found) == pytest.approx(load(t=t), rel=1e-9)


def test_force_and_body_force_share_a_period():
    loads = Scenario.parse(force="sin(2*t)", body_force="x*cos(3*t - 2*x)")
    assert load_period(loads, None, 1.0) == (pytest.approx(2 * PI), "formula")
    assert load_period(Scenario.parse(force=2), None, 7.0) == (7.0, "constant load")


@pytest.mark.parametrize(
    ("force", "body", "sentence"),
    [
        ("sin(t)", "cos(pi*t)", "no common period"),
        ("sin(t)", "sin(x*t)", "t appears outside"),
        ("t", "0", "'t' follows"),
    ],
)
def test_loads_without_a_common_period_are_refused(force, body, sentence):
    with pytest.raises(InputError, match=sentence):
        load_period(Scenario.parse(force=force, body_force=body), None, 1.0)


def test_a_period_that_is_given_is_compared_with_the_load():
    decaying = Scenario.parse(force="where(t < 1, 5, sin(2*pi*t))")
    square = Scenario.parse(force="sign(sin(2*pi*t))")
    assert load_period(square, 0.5 + 0.5, 9.0) == (1.0, "given")
    assert load_period(square, 3, 9.0) == (3.0, "given")
    for loads, wrong in ((square, 0.5), (square, 1.001), (decaying, 1.0)):
        with pytest.raises(InputError, match="give a period of the load"):
            load_period(loads, wrong, 9.0)
    for nonsense in (0, -1.0, math.nan, math.inf, True, "1"):
        with pytest.raises(InputError, match="give a positive number of seconds"):
            load_period(square, nonsense, 9.0)


def test_a_period_outside_the_doubles_is_refused():
    text = "sin(t*" + "*".join(["1e-200"] * 2) + ")"
    with pytest.raises(InputError, match="period comes out as"):
        period(text)
    assert np.isfinite(period("sin(1e-200*t)"))
