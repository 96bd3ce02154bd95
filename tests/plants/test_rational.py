"""Rational blocks: values, text and refusals, whatever the size of the coefficients."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lure import InputError, RationalPlant
from lure.plants.rational import polynomial_text


@given(st.integers(-300, 300), st.lists(st.integers(1, 9), min_size=1, max_size=8))
def test_values_do_not_depend_on_the_unit_of_time(decades, roots):
    # prod a/(s/T + a) at s = i T is prod a/(i + a), whatever T
    T = Fraction(10) ** decades
    den, expected = [Fraction(1)], 1.0 + 0j
    for a in roots:
        den = [x + y for x, y in zip([*den, Fraction(0)], [Fraction(0), *(c * a * T for c in den)], strict=True)]
        expected *= a / (1j + a)
    block = RationalPlant([den[-1]], den)
    assert block.transfer(1j * float(T)) == pytest.approx(expected, rel=1e-11)


def test_a_pole_far_smaller_than_the_others_does_no_harm():
    # 0.1/(z (z - 1e-300)) is 0.1/z^2 at |z| = 1
    block = RationalPlant([Fraction(1, 10)], [1, -Fraction(1, 10**300), 0], dt=1)
    assert block.transfer([1, 1j]) == pytest.approx([0.1, -0.1], rel=1e-15)


def test_a_pole_is_not_finite_and_infinity_is_the_feedthrough():
    block = RationalPlant([3, 1], [1, 2])
    assert not np.isfinite(block.transfer(-2))
    assert block.feedthrough == 3
    assert block.transfer([0, 1j]) == pytest.approx([0.5, (3j + 1) / (1j + 2)])


def test_it_prints_as_people_write():
    block = RationalPlant([Fraction(-1, 2), 0, 1], [1, 0, -3, Fraction(1, 3), Fraction(10) ** 400], dt=Fraction(1, 10))
    assert str(block) == "(-0.5 z^2 + 1) / (z^4 - 3 z^2 + 0.333333 z + 1e+400)"
    assert polynomial_text([Fraction(0)], "s") == "0"
    assert polynomial_text([Fraction(123456789), Fraction(0)], "s") == "1.23457e+08 s"


def test_python_control_gets_doubles_or_a_sentence():
    system = RationalPlant([1], [1, 3, 2, 0]).to_control()
    assert np.array_equal(system.den[0][0], [1, 3, 2, 0])
    assert system.dt == 0
    with pytest.raises(InputError, match="rescale the unit of time"):
        RationalPlant([1], [1, Fraction(10) ** 400]).to_control()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (([1], []), "is zero"),
        (([1], [0, 0]), "is zero"),
        (([1, 0], [1]), "improper"),
        (([float("nan")], [1, 1]), "finite"),
        ((["1"], [1, 1]), "give a number"),
        ((1, [1, 1]), "give a list"),
        (([1], [1, 1], 0), "positive time"),
        (([1], [1, 1], -1), "positive time"),
        (([1], [1] * 1002), "order 1001"),
    ],
)
def test_what_is_no_block_is_refused_in_a_sentence(arguments, words):
    with pytest.raises(InputError, match=words):
        RationalPlant(*arguments)
