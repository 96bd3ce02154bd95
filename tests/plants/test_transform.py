"""lure.loop: gains moved between nonlinearity and block, exactly, and moved back."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from lure.classes import NonlinearityClass, Sector, SlopeBounds
from lure.errors import InputError
from lure.loop import pole_shift, sector_shift, shifted_block
from lure.nonlinearities import DeadZone, PiecewiseLinear, Saturation, Tanh, nonlinearity_class, shifted_nonlinearity
from lure.plants.rational import RationalPlant

small = st.fractions(-5, 5, max_denominator=20)


@st.composite
def blocks(draw):
    order = draw(st.integers(0, 5))
    bottom = [draw(small.filter(bool)), *(draw(small) for _ in range(order))]
    return RationalPlant(
        draw(st.lists(small, min_size=1, max_size=order + 1)), bottom, draw(st.sampled_from([None, 1]))
    )


@given(block=blocks(), gain=small)
def test_a_shift_is_undone_by_the_opposite_one_hidden_modes_and_all(block, gain):
    assume(1 + gain * block.feedthrough != 0)
    assert shifted_block(shifted_block(block, gain), -gain) == block


# the feedback by gain around H, computed in floating point from H alone
@given(block=blocks(), gain=small, point=st.complex_numbers(min_magnitude=0.5, max_magnitude=3))
def test_the_block_is_the_feedback_of_the_gain_around_it(block, gain, point):
    assume(1 + gain * block.feedthrough != 0)
    h = complex(block.transfer(point))
    assume(math.isfinite(abs(h)) and abs(h) < 1e3 and abs(1 + float(gain) * h) > 1e-3)
    assert complex(shifted_block(block, gain).transfer(point)) == pytest.approx(
        h / (1 + float(gain) * h), rel=1e-6, abs=1e-9
    )


@given(block=blocks(), first=small, second=small)
def test_two_shifts_are_one(block, first, second):
    start = NonlinearityClass(sector=Sector(-1, 4), slope=SlopeBounds(-2, math.inf), odd=True)
    assume(all(1 + g * block.feedthrough != 0 for g in (first, first + second)))
    twice, once = pole_shift(block, start, first).then(second), pole_shift(block, start, first + second)
    assert (twice.block, twice.nonlinearity_class, twice.gain) == (once.block, once.nonlinearity_class, once.gain)
    assert twice.undo(1) == 1 + first + second


def test_a_hidden_mode_stays_where_it_is():
    # (s+3)/((s+3)(s-1)): the feedback 2 moves the pole 1 to -1 and leaves the hidden -3: (s+3)(s+1) = s^2 + 4s + 3
    block = RationalPlant([1, 3], [1, 2, -3])
    assert shifted_block(block, Fraction(2)) == RationalPlant([1, 3], [1, 4, 3])


def test_a_sector_shift_starts_the_sector_at_zero_and_keeps_everything_else():
    start = NonlinearityClass(
        sector=Sector(Fraction(1, 3), 2), slope=SlopeBounds(-1, math.inf), odd=True, time_varying=True
    )
    shifted = sector_shift(RationalPlant([1], [1, 1]), start)
    assert shifted.nonlinearity_class == NonlinearityClass(
        sector=Sector(0, Fraction(5, 3)), slope=SlopeBounds(Fraction(-4, 3), math.inf), odd=True, time_varying=True
    )
    assert shifted.block == RationalPlant([1], [1, Fraction(4, 3)])
    assert shifted.undo(Fraction(5, 3)) == 2
    assert shifted.undo(math.inf) == math.inf


def test_the_steps_say_what_was_replaced_by_what():
    shifted = pole_shift(
        RationalPlant([1], [1, 0]), NonlinearityClass.slope_restricted(0, 4, odd=True), Fraction(-1, 2)
    )
    assert shifted.steps == (
        "odd phi with slope in [0, 4] is replaced by psi(sigma) = phi(sigma) + 0.5 sigma: "
        "odd psi with slope in [0.5, 4.5]",
        "H = 1 / s is replaced by H/(1 - 0.5 H) = 1 / (s - 0.5)",
        "a gain k of psi is the gain k - 0.5 of phi",
    )


def test_a_sector_that_starts_at_zero_is_left_alone():
    block, start = RationalPlant([1], [1, 1]), NonlinearityClass(sector=Sector(0, 2))
    same = sector_shift(block, start)
    assert (same.block, same.nonlinearity_class, same.gain) == (block, start, 0)
    assert len(same.steps) == 1


# 1/3 is no double: the nearest lies below it, so the upper end must step up and the lower end must not
@given(low=st.floats(-1e6, 1e6), width=st.floats(0, 1e6), gain=st.fractions(-1000, 1000))
def test_a_bracket_is_undone_outwards_and_no_further_than_one_double(low, width, gain):
    shifted = pole_shift(RationalPlant([1], [1, 1]), NonlinearityClass(sector=Sector(0, 1)), gain)
    below, above = shifted.undo_bracket(low, low + width)
    exact = Fraction(low) + gain, Fraction(low + width) + gain
    assert below <= exact[0] < math.nextafter(below, math.inf)
    assert math.nextafter(above, -math.inf) < exact[1] <= above


def test_an_infinite_reach_stays_infinite():
    shifted = pole_shift(RationalPlant([1], [1, 1]), NonlinearityClass(sector=Sector(0, 1)), 3)
    assert shifted.undo_bracket(2.0, math.inf) == (5.0, math.inf)
    assert shifted.undo_bracket(math.inf, math.inf) == (math.inf, math.inf)


def test_what_cannot_be_shifted_is_refused():
    half = RationalPlant([1, 0], [2, 1])
    with pytest.raises(
        InputError, match=r"^the loop is not well posed: 1 \+ gain D = 0 with gain = -2 and D = H\(inf\) = 0.5"
    ):
        pole_shift(half, NonlinearityClass(sector=Sector(0, 1)), -2)
    with pytest.raises(InputError, match=r"^sector_shift needs a finite lower bound, and the sector is \[-inf, 2\]"):
        sector_shift(half, NonlinearityClass(sector=Sector(-math.inf, 2)))
    for gain, message in ((math.nan, "is nan"), (math.inf, "is inf"), ("1", "is '1'")):
        with pytest.raises(InputError, match=rf"^pole_shift: gain {message}"):
            pole_shift(half, NonlinearityClass(sector=Sector(0, 1)), gain)


@pytest.mark.parametrize(
    "nonlinearity", [Saturation(gain=2, limit=1), Tanh(scale=Fraction(1, 100)), DeadZone(width=1, gain=3)]
)
@given(gain=small, sigma=st.floats(-50, 50))
def test_the_law_and_its_class_shift_together(nonlinearity, gain, sigma):
    psi = shifted_nonlinearity(nonlinearity, gain)
    block = RationalPlant([1], [1, 1])
    assert nonlinearity_class(psi) == pole_shift(block, nonlinearity_class(nonlinearity), gain).nonlinearity_class
    assert float(psi(sigma)) == pytest.approx(float(nonlinearity(sigma)) - float(gain) * sigma, rel=1e-12, abs=1e-12)
    assert float(psi.slope(sigma)) == pytest.approx(
        float(nonlinearity.slope(sigma)) - float(gain), rel=1e-12, abs=1e-12
    )
    primitive = float(nonlinearity.primitive(sigma)) - 0.5 * float(gain) * sigma**2
    assert float(psi.primitive(sigma)) == pytest.approx(primitive, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(
    "nonlinearity", [Saturation(gain=2, limit=1), Tanh(), PiecewiseLinear([(1, 3)], left_slope=3, right_slope=0)]
)
def test_a_law_shifted_there_and_back_has_its_values_again(nonlinearity):
    back = shifted_nonlinearity(shifted_nonlinearity(nonlinearity, Fraction(7, 3)), Fraction(-7, 3))
    assert nonlinearity_class(back) == nonlinearity_class(nonlinearity)
    sigma = np.linspace(-3, 3, 61)
    assert back(sigma) == pytest.approx(nonlinearity(sigma), abs=1e-14)


# one time step of sigma' = -sigma + mu, mu = -phi(sigma), from either description
@given(sigma=st.floats(-10, 10), gain=small)
def test_both_loops_have_the_same_right_hand_side(sigma, gain):
    nonlinearity, block = Saturation(gain=3, limit=2), RationalPlant([1], [1, 1])
    shifted = pole_shift(block, nonlinearity_class(nonlinearity), gain)
    pole = -float(shifted.block.denominator[1])
    psi = float(shifted_nonlinearity(nonlinearity, gain)(sigma))
    assert pole * sigma - psi == pytest.approx(-sigma - float(nonlinearity(sigma)), abs=1e-12)
