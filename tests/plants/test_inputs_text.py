"""Coefficients and formulas given as text become the block they say, exactly, or are refused in one sentence."""

import math
from decimal import Decimal
from fractions import Fraction as F

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plants import value
from refusals import refusal

from lure.errors import InputError
from lure.expressions import Expression
from lure.plants import as_plant, coefficients, parse_transfer
from lure.plants.delay import DelayPlant
from lure.plants.rational import RationalPlant


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("1 3 2 0", [1, 3, 2, 0]),
        ("[1, 3,2 ,0]", [1, 3, 2, 0]),
        ("(1,-.5)", [1, F(-1, 2)]),
        ("1/3 -2/7", [F(1, 3), F(-2, 7)]),
        ("0.1 1e-3 +2.", [F(1, 10), F(1, 1000), 2]),
        ("0.5/0.3", [F(5, 3)]),
        ("  7\t8\n9 ", [7, 8, 9]),
    ],
)
def test_coefficients_are_read_exactly(text, values):
    assert coefficients(text) == tuple(values)


def test_a_list_may_mix_numbers_and_texts_and_a_float_is_the_double_it_is():
    assert coefficients([1, 0.1, F(1, 3), Decimal("0.1"), "2/3", np.int64(4), 2 + 0j]) == (
        1,
        F(3602879701896397, 2**55),
        F(1, 3),
        F(1, 10),
        F(2, 3),
        4,
        2,
    )


@pytest.mark.parametrize(
    ("given_", "said"),
    [
        ("", "is empty"),
        ("[]", "is empty"),
        ([], "is empty"),
        ("1,,2", "nothing before or after a comma"),
        ("0,002 0,12 1 0", "decimal comma"),
        ("[1 2", "close the bracket '\\['"),
        ("1 x", r"\[1\] is 'x'; give a number such as 2"),
        ("1;2", "give a number such as 2"),
        ("1/0", "division by zero"),
        ("nan", "give a number such as 2"),
        ("1e400", "outside the range of double precision"),
        ("1e99999999999", "exponent beyond 400"),
        ("-- 1", "give a number such as 2"),
        ([1, math.nan], r"\[1\] is nan; give a finite number"),
        ([math.inf], r"\[0\] is inf; give a finite number"),
        ([1, 1j], "complex coefficient"),
        ([[1, 2]], "one input and one output"),
        ([True], "give a number"),
        ([None], "give a number"),
        (3, "give a list of numbers"),
        (np.array(3.0), "give a list of numbers"),
        ("1 " * 1002, "stop at degree 1000"),
        ("1" * 70000, "at most 65536"),
    ],
)
def test_what_is_no_list_of_coefficients_is_refused(given_, said):
    with pytest.raises(InputError, match=said):
        coefficients(given_)


@given(st.lists(st.fractions(), min_size=1, max_size=8))
def test_fractions_survive_the_way_through_text(values):
    kept = [v for v in values if v == 0 or 1e-300 < abs(v) < 1e300]
    if kept:
        assert coefficients(" ".join(str(v) for v in kept)) == tuple(kept)


@pytest.mark.parametrize(
    ("text", "top", "bottom"),
    [
        ("1/(s*(s+1)*(s+2))", [1], [1, 3, 2, 0]),
        ("(s+2)/(s^2+s)", [1, 2], [1, 1, 0]),
        ("2 s (s+1)/(3s^3 + 0.5)", [2, 2, 0], [3, 0, 0, F(1, 2)]),
        ("-s^2/(s+1)**2", [-1, 0, 0], [1, 2, 1]),
        ("3", [3], [1]),
        ("(s^2 + 1)/(s^2 + 0.1 s + 1)", [1, 0, 1], [1, F(1, 10), 1]),
        ("2 - 1/(s+1)", [2, 1], [1, 1]),
        ("s^-1", [1], [1, 0]),
        ("1e-3/(s+1/3)", [F(1, 1000)], [1, F(1, 3)]),
        ("1/(s+1)^(2)", [1], [1, 2, 1]),
        ("1/-s", [-1], [1, 0]),
    ],
)
def test_a_formula_is_the_block_it_says(text, top, bottom):
    assert parse_transfer(text) == RationalPlant(top, bottom)


# Factors written in one fraction are modes of the system described; the denominators of a sum are common ground.
@pytest.mark.parametrize(
    ("text", "top", "bottom"),
    [
        ("(s-1)/((s-1)*(s+2))", [1, -1], [1, 1, -2]),
        ("(s-1)/(s+2) * 1/(s-1)", [1, -1], [1, 1, -2]),
        ("s/(s*(s+1))", [1, 0], [1, 1, 0]),
        ("1/(s-1) - 1/(s-1)", [0], [1, -1]),
        ("0*1/(s-1)", [0], [1, -1]),
        ("1/s + 1/s", [2], [1, 0]),
        ("1/s + 1/(s*(s+1))", [1, 2], [1, 1, 0]),
        ("(1/s)/(1 + 1/s)", [1], [1, 1]),
    ],
)
def test_a_mode_written_out_is_kept_and_none_is_invented(text, top, bottom):
    assert parse_transfer(text) == RationalPlant(top, bottom)


def test_negative_powers_of_z_are_delays_and_bring_no_mode_of_their_own():
    assert parse_transfer("0.1/(1 - 1.8 z^-1 + 0.81 z^-2)") == RationalPlant(
        [F(1, 10), 0, 0], [1, F("-1.8"), F("0.81")], 1
    )


def test_z_means_discrete_time_and_a_period_may_be_given():
    assert parse_transfer("z/(z-0.5)").dt == 1
    assert parse_transfer("z/(z-0.5)", dt=F(1, 10)).dt == F(1, 10)
    assert parse_transfer("z/(z-0.5)", dt=True).dt == 1
    assert parse_transfer("2", dt=True).dt == 1


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "the text is empty"),
        ("  ", "the text is empty"),
        ("s^2", "improper"),
        ("1/0", "division by zero at column 2"),
        ("1/(s-s)", "division by zero at column 2"),
        ("(s-s)^-1", "division by zero"),
        ("1/(s+1)(s+2)", "needs \\* and brackets .* at column 8"),
        ("1/2 s", "needs \\* and brackets"),
        ("s+z", "both s and z"),
        ("1/(s+pi)", "pi is irrational"),
        ("1/(s+2j)", "coefficients are real"),
        ("1/(x+1)", "unknown name 'x' \\(.* in s, .* parameter .* in \\[plant.parameters\\]"),
        ("1/(p+1)", "write s"),
        ("sin(s)", "unknown name 'sin'"),
        ("(s+1", "to close '\\(' of column 1"),
        ("s+1)", "expected an operator but found '\\)'"),
        ("1 3", "expected an operator but found '3'"),
        ("1/s^1.5", "whole number"),
        ("1/s^s", "whole number"),
        ("1/s^2^3", "power of a power"),
        ("1/(s+1)^1001", "too large"),
        ("1/((s+1)^999*(s+1)^2)", "too large"),
        ("1/(s+12345678)^9999", "too large"),
        ("1/s; 2", "character ';' at column 4"),
        ("1/s \N{MULTIPLICATION SIGN} 2", "is not allowed"),
        ("__import__('os')", "unknown name|not allowed"),
        ("(" * 40 + "s" + ")" * 40, "nested"),
        ("s+" * 5000 + "1", "at most 8192"),
        ("1e999/s", "exponent|outside the range"),
    ],
)
def test_what_is_no_transfer_function_is_refused_with_its_column(text, said):
    with pytest.raises(InputError, match=said) as caught:
        parse_transfer(text)
    assert str(caught.value).isprintable()


@pytest.mark.parametrize(("text", "dt"), [("1/s", 1), ("1/s", True), ("1/z", 0)])
def test_a_variable_that_contradicts_the_sampling_time_is_refused(text, dt):
    assert "the formula is in" in refusal(parse_transfer, text, dt=dt)


FORMULAS = st.recursive(
    st.sampled_from(["s", "1", "2", "0.5", "3", "(s+1)"]),
    lambda inner: st.one_of(
        st.builds("({}+{})".format, inner, inner),
        st.builds("({}-{})".format, inner, inner),
        st.builds("{}*{}".format, inner, inner),
        st.builds("{}/({})".format, inner, inner),
        st.builds("({})^{}".format, inner, st.sampled_from(["2", "3", "-1", "-2"])),
        st.builds("(-{})".format, inner),
    ),
    max_leaves=8,
)


# The other parser of the package, for nonlinearities, evaluates the same text as a number; it knows nothing of
# polynomials.
@given(FORMULAS, st.fractions(-3, 3, max_denominator=7))
def test_a_block_has_the_value_of_its_formula(text, point):
    try:
        block, number = parse_transfer(text), Expression.parse(text.replace("^", "**"), variables=("s",)).exact(s=point)
    except InputError:
        return
    bottom = sum(c * point**n for n, c in enumerate(reversed(block.denominator)))
    if bottom != 0:
        assert value(block, point) == number


@pytest.mark.slow
@given(
    st.lists(st.fractions(-9, 9, max_denominator=9), min_size=1, max_size=4),
    st.lists(st.fractions(-9, 9, max_denominator=9), min_size=4, max_size=6).filter(lambda d: d[0] != 0),
)
def test_a_block_survives_the_way_through_a_formula(top, bottom):
    def text(side):
        return "+".join(f"({c})*s^{n}" for n, c in enumerate(reversed(side)))

    assert as_plant(f"({text(top)})/({text(bottom)})") == RationalPlant(top, bottom)


def test_a_dead_time_makes_a_delay_block_and_one_that_cancels_does_not():
    block = as_plant("exp(-0.2*s)/(s*(s+1))")
    assert isinstance(block, DelayPlant)
    assert block.terms[0][0] == F(1, 5)
    assert as_plant("exp(0*s)/(s+1)^2") == RationalPlant([1], [1, 2, 1])
    assert "dead time in continuous time" in refusal(as_plant, "exp(-s)/(s+1)", dt=1)


# Three rows of three numbers are no (A, B, C), whose A is square, and five no scipy system: its period is a number.
@pytest.mark.parametrize(
    ("rows", "sides"),
    [([["0", "-1", "0"], ["1", "0", "0"], ["0", "0", "1"]], (3, 3)), ([[1, 2]], (2, 1)), ([[1]] * 5, (1, 5))],
)
def test_rows_of_numbers_that_can_only_be_gains_are_gains(rows, sides):
    found = as_plant(rows)
    assert (found.order, (found.inputs, found.outputs)) == (0, sides)
    assert tuple(tuple(map(F, row)) for row in rows) == found.D


@pytest.mark.parametrize("rows", [[["0", "-1"], ["1", "0"]], [[1], [2]]])
def test_two_lists_of_two_numbers_are_a_pair_or_gains_and_have_to_say_which(rows):
    with pytest.raises(
        InputError, match=r"may be numerator and denominator, or rows of gains; give a pair \(num, den\)"
    ):
        as_plant(rows)
    assert as_plant(tuple(rows)).order == len(rows[0]) - 1  # as the message says
    found = as_plant(([], [], [], rows))
    assert (found.order, found.D[1]) == (0, tuple(map(F, rows[1])))


def test_lists_that_are_no_rows_of_gains_are_what_they_were():
    assert as_plant([[-1], [1], [1]]) == as_plant(([-1], [1], [1]))  # A, B, C of one state
    assert as_plant([[1], [1, 1]]) == as_plant("1/(s+1)")
    assert as_plant([[1, 0, 2], [1, 3, 1]]) == as_plant(([1, 0, 2], [1, 3, 1]))
