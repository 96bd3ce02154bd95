"""lure.rod.transfer: the transfer function of the rod itself, its poles, and the accuracy of both."""

import math
from fractions import Fraction

import numpy as np
import pytest
from flint import acb
from hypothesis import assume, given
from hypothesis import strategies as st
from reference import (
    Exact,
    at_high_precision,
    decades,
    point,
    ratios,
    real,
    real_part_error,
    relative_error,
    rods,
    with_damping,
)

from lure import InputError
from lure.rod import RodPlant
from lure.rod.systems import paper_rod, rod_from_exact

EPS = 2.0**-52
angles = st.floats(-math.pi, math.pi)


def error_and_sensitivity(rod, s):
    exact = Exact(rod)
    return relative_error(RodPlant(rod).transfer(s), exact.transfer(s, None)), exact.sensitivity(s, None)


# What is reached: a few roundings times the sensitivity of H to a rounding of a and of the phase 2 omega T, which no
# formula that starts from doubles can avoid.  It is about 2 omega T, times 1/(1 - |a|) at a resonance.
@given(rod=rods(), turns=decades(-12, 2))
def test_the_closed_form_on_the_imaginary_axis_is_right_to_what_its_inputs_allow(rod, turns):
    error, sensitivity = at_high_precision(error_and_sensitivity, rod, 1j * turns / rod.travel_time)
    assert error <= 8 * EPS * sensitivity


@given(rod=rods(), size=decades(-12, 2), angle=angles)
def test_the_closed_form_anywhere_in_the_plane_is_right_to_what_its_inputs_allow(rod, size, angle):
    s = complex(size * math.cos(angle), size * math.sin(angle)) / rod.travel_time
    # a rod matched in doubles counts as matched, although |Q| > 1 makes a remainder of 1e-16 grow
    assume(rod.reflection != 0 or s.real >= 0)
    error, sensitivity = at_high_precision(error_and_sensitivity, rod, s)
    assert error <= 8 * EPS * sensitivity


@given(rod=rods(), turns=decades(-300, -2))
def test_near_zero_the_closed_form_keeps_all_its_digits(rod, turns):
    s = 1j * turns / rod.travel_time
    assume(abs(s) > 1e-290)
    error, _ = at_high_precision(error_and_sensitivity, rod, s)
    assert error <= 16 * EPS


# Popov's expression lives on Re H, which tends to a limit where Im H grows as A/(k omega)
@given(rod=rods(), turns=decades(-100, -2))
def test_near_zero_the_real_part_keeps_its_digits_beside_an_imaginary_part_of_any_size(rod, turns):
    assume(rod.reflection != 0)
    s = 1j * turns / rod.travel_time
    error = at_high_precision(lambda: real_part_error(RodPlant(rod).transfer(s), Exact(rod).transfer(s, None)))
    assert error <= 16 * EPS


@pytest.mark.parametrize("ratio", [1e-6, 1e-3, 0.5, 0.999, 1.001, 2.0, 1e3])
def test_from_a_millionth_of_the_impedance_to_a_thousand_times_it_eleven_digits_are_right_off_resonance(ratio):
    # omega T at odd multiples of pi/4, where neither 1 + a Q nor 1 - a Q is small
    rod = with_damping(paper_rod(), Fraction(ratio) * Fraction(6, 5))
    for turns in math.pi / 4 * np.array([1, 3, 21, 2001]):
        error, _ = at_high_precision(error_and_sensitivity, rod, 1j * turns / rod.travel_time)
        assert error <= 1e-11


def test_the_value_at_half_a_turn_by_hand():
    # omega T = pi/2: Q = -1 and H = (d/s)(1 + a)/(1 - a) = (d/s) k/Z
    rod = paper_rod("0.3")
    s = 0.5j * math.pi / rod.travel_time
    assert RodPlant(rod).transfer(s) == pytest.approx(rod.mobility / s * 0.25, rel=1e-12)


@given(rod=rods(), size=decades(-6, 2), angle=angles)
def test_conjugate_points_give_conjugate_values(rod, size, angle):
    s, block = complex(size * math.cos(angle), size * math.sin(angle)) / rod.travel_time, RodPlant(rod)
    assert block.transfer(np.conj(s)) == np.conj(block.transfer(s))


# In other units of length and time (see test_rod) sigma grows by `length` and mu by 1/(length time^2).
powers = st.integers(-20, 20).map(lambda power: Fraction(2) ** power)


@given(rod=rods(), turns=decades(-6, 2), time=powers, length=powers)
def test_the_response_follows_the_units(rod, turns, time, length):
    exact = rod.exact
    scaled = rod_from_exact(
        {
            **exact,
            "youngs_modulus": exact["youngs_modulus"] / (length * time**2),
            "density": exact["density"] / length**3,
            "length": exact["length"] * length,
            "area": exact["area"] * length**2,
            "damping": exact["damping"] / time,
        }
    )
    s = (0.1 + 1j) * turns / rod.travel_time
    expected = float(length**2 * time**2) * RodPlant(rod).transfer(s)
    assert RodPlant(scaled).transfer(s / float(time)) == pytest.approx(expected, rel=1e-11)


@given(rod=rods(), turns=decades(-6, 2), factor=decades(-3, 3))
def test_a_longer_rod_is_a_slower_one(rod, turns, factor):
    # H = (d/s) F(s L/c): H(s; x L) = x H(x s; L)
    longer = rod_from_exact({**rod.exact, "length": rod.exact["length"] * Fraction(factor)})
    s = (1 + 1j) * turns / rod.travel_time
    assert RodPlant(longer).transfer(s / factor) == pytest.approx(factor * RodPlant(rod).transfer(s), rel=1e-10)


@pytest.mark.slow
@given(rod=rods())
def test_the_residue_at_zero_is_the_area_over_the_damping(rod):
    # Q = 1 - 2 s T changes s H by about s T (k/Z + Z/k)
    ratio = rod.damping / rod.impedance
    s = 1e-10 / (ratio + 1 / ratio) / rod.travel_time
    assert s * RodPlant(rod).transfer(s) == pytest.approx(rod.residue_at_zero, rel=1e-9)
    assert rod.residue_at_zero == pytest.approx(rod.area / rod.damping, rel=1e-15)


@given(rod=rods(), size=decades(-3, 2), angle=st.floats(-math.pi / 2, math.pi / 2))
def test_the_rod_takes_up_energy_at_every_complex_frequency(rod, size, angle):
    # stress times velocity of a passive end: Re[s H(s)] >= 0 for Re s >= 0
    s = complex(size * math.cos(angle), size * math.sin(angle)) / rod.travel_time
    mobility = s * RodPlant(rod).transfer(s)
    assert mobility.real >= -1e-12 * abs(mobility)


@given(rod=rods(ratio=1.0), size=decades(-6, 4), angle=angles)
def test_the_matched_rod_is_an_integrator(rod, size, angle):
    s = complex(size * math.cos(angle), size * math.sin(angle)) / rod.travel_time
    assert RodPlant(rod).transfer(s) == pytest.approx(rod.mobility / s, rel=4 * EPS)


@pytest.mark.parametrize("damping", ["2e-4", "1.1999", "5", "-0.3"])
def test_far_to_the_left_the_waves_outgrow_the_integrator_and_nothing_overflows(damping):
    # |Q| -> inf: H -> -d/s
    rod = paper_rod(damping)
    s = np.array([-1e6, -1e9 + 3e8j, -1e300]) / rod.travel_time
    assert np.allclose(RodPlant(rod).transfer(s), -rod.mobility / s, rtol=1e-12, atol=0)


@pytest.mark.parametrize("excess", [1e-3, 1e-7, 1e-12, -1e-7])
def test_where_a_small_reflection_meets_a_large_wave_no_digits_are_lost(excess):
    # 1/Q + a with both of size |a|: on |Q| = 1/|2a|, at a right angle to the poles
    rod = with_damping(paper_rod(), Fraction(6, 5) * (1 + Fraction(excess)))
    s = (math.log(abs(2 * rod.reflection)) + 0.5j * math.pi) / (2 * rod.travel_time)
    error, _ = at_high_precision(error_and_sensitivity, rod, s)
    assert error <= 100 * EPS


def test_at_the_pole_at_zero_the_value_is_not_finite():
    assert not np.isfinite(RodPlant(paper_rod()).transfer(0.0))


@pytest.mark.parametrize("damping", ["2e-4", "0", "0.6", "1.3", "500", "-0.3", "-7"])
def test_the_poles_are_where_the_denominator_vanishes(damping):
    rod = paper_rod(damping)
    poles = RodPlant(rod).poles(4)
    # 1 + a e^{-2sT} = 0
    assert np.allclose(rod.reflection * np.exp(-2 * rod.travel_time * poles), -1, rtol=1e-11)
    assert np.allclose(poles, np.conj(poles[::-1]), rtol=1e-15)
    assert np.all(np.diff(poles.imag) > 0)
    assert len(poles) == (9 if rod.reflection < 0 else 8)


# -ln|a|/(2T) = -ln(1.1998/1.2002)/(2/6000) = 3.3333333796e-4 * 3000 = 1.00000001389 1/s; frequencies pi m/T
def test_the_poles_of_the_paper_decay_at_one_per_second():
    poles = RodPlant(paper_rod()).poles(2)
    rate = 3000 * math.log(1.2002 / 1.1998)
    assert rate == pytest.approx(1.0, abs=2e-8)
    assert poles.real == pytest.approx([-rate] * 5, rel=1e-12)
    assert poles.imag == pytest.approx(6000 * math.pi * np.arange(-2, 3), rel=1e-15)


@given(rod=rods(ratio=1.0), ratio=ratios(), sign=st.sampled_from([1, -1]))
def test_the_logarithm_of_the_reflection_keeps_its_digits(rod, ratio, sign):
    assume(abs(ratio - 1) > 1e-14)
    rod = with_damping(rod, Fraction(sign * ratio * rod.impedance))

    def error():
        logarithm = acb(abs(Exact(rod).a)).log().real
        # ln|a| near |a| = 1 is about 2q, q = k/Z or Z/k, and is asked for relative to itself
        return float(abs(real(RodPlant(rod).log_reflection) - logarithm) / abs(logarithm))

    assert at_high_precision(error) < 16 * EPS


def test_the_matched_rod_has_no_wave_poles():
    assert RodPlant(paper_rod("1.2")).poles(5).size == 0
    assert RodPlant(paper_rod("1.2")).log_reflection == -math.inf


def test_without_damping_the_poles_lie_on_the_imaginary_axis_and_with_negative_damping_beyond_it():
    assert np.all(RodPlant(paper_rod("0")).poles(3).real == 0)
    for damping in ("-0.3", "-1.1", "-7"):
        assert np.all(RodPlant(paper_rod(damping)).poles(3).real > 0)


@pytest.mark.parametrize("modes", [0, -1])
def test_fewer_than_one_mode_is_refused(modes):
    with pytest.raises(InputError, match=rf"^RodPlant\.poles was asked for {modes} modes; ask for at least 1$"):
        RodPlant(paper_rod()).poles(modes)


def test_the_reference_satisfies_the_boundary_conditions():
    # guards the comparison itself: u = p cosh(s x/c) + q sinh(s x/c) with A E u'(0) = k s u(0), E u'(L) = 1, H = u(L)
    def error():
        rod = paper_rod("0.3")
        exact, s = Exact(rod), point(100 + 2e4j)
        E, A = real(rod.exact["youngs_modulus"]), real(rod.exact["area"])
        wave = s / exact.c
        ratio = exact.k * s / (A * E * wave)  # q/p
        C, S = (s * exact.T).cosh(), (s * exact.T).sinh()
        u = (C + ratio * S) / (E * wave * (S + ratio * C))
        return float(abs(u - exact.transfer(100 + 2e4j, None)) / abs(u))

    assert at_high_precision(error) < 1e-80
