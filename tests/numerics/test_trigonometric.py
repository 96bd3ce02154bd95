"""Trigonometric polynomials with exact signs: sharp where they touch zero, and in agreement with samples."""

import math
from fractions import Fraction

import numpy as np
import pytest
from flint import fmpq, fmpq_poly
from hypothesis import given
from hypothesis import strategies as st

from lure.analysis.numerics.trigonometric import (
    Laurent,
    least_on_circle,
    nonnegative_on_circle,
    positive_on_circle,
)

coefficients = st.lists(st.integers(-9, 9), min_size=1, max_size=9)


def values_on_circle(f, omega):
    z = np.exp(1j * omega)
    return np.polyval([float(Fraction(int(c.p), int(c.q))) for c in reversed(f.p.coeffs())], z) * z ** (-f.shift)


def values_at_cosine(p, c):
    return np.polyval([float(Fraction(int(a.p), int(a.q))) for a in reversed(p.coeffs())], c)


@given(left=coefficients, right=coefficients, shift=st.integers(0, 4))
def test_sums_products_and_conjugates_agree_with_complex_numbers(left, right, shift):
    omega = np.linspace(0, math.pi, 7)
    f, g = Laurent(fmpq_poly(left), shift), Laurent(fmpq_poly(right), 1)
    F, G = values_on_circle(f, omega), values_on_circle(g, omega)
    assert values_on_circle(f * g, omega) == pytest.approx(F * G, abs=1e-9)
    assert values_on_circle(f + g, omega) == pytest.approx(F + G, abs=1e-9)
    assert values_on_circle(f.conjugate(), omega) == pytest.approx(F.conj(), abs=1e-9)
    assert values_on_circle(f.scaled(Fraction(2, 3)), omega) == pytest.approx(2 / 3 * F, abs=1e-9)
    assert values_at_cosine(f.real_part(), np.cos(omega)) == pytest.approx(F.real, abs=1e-9)


# 1 + a cos w is least at w = pi or 0 and equals 1 - |a| there
@pytest.mark.parametrize(
    ("a", "positive", "nonnegative"),
    [
        (Fraction(1) - Fraction(1, 10**30), True, True),
        (Fraction(1), False, True),
        (Fraction(-1), False, True),
        (Fraction(1) + Fraction(1, 10**30), False, False),
        (Fraction(-1) - Fraction(1, 10**30), False, False),
    ],
)
def test_signs_are_sharp_at_the_ends(a, positive, nonnegative):
    p = fmpq_poly([1, fmpq(a.numerator, a.denominator)])
    assert positive_on_circle(p) is positive
    assert nonnegative_on_circle(p) is nonnegative


# (cos w - 1/3)^2 + e touches zero inside for e = 0
@pytest.mark.parametrize(("e", "positive", "nonnegative"), [(1, True, True), (0, False, True), (-1, False, False)])
def test_signs_are_sharp_at_a_double_zero(e, positive, nonnegative):
    p = fmpq_poly([fmpq(-1, 3), 1]) ** 2 + fmpq_poly([fmpq(e, 10**40)])
    assert positive_on_circle(p) is positive
    assert nonnegative_on_circle(p) is nonnegative


def test_the_zero_polynomial_is_nonnegative_only():
    assert not positive_on_circle(fmpq_poly([]))
    assert nonnegative_on_circle(fmpq_poly([]))
    assert not nonnegative_on_circle(fmpq_poly([-1]))


@given(coefficients)
def test_positive_agrees_with_a_dense_sample(listed):
    p = fmpq_poly(listed)
    values = values_at_cosine(p, np.linspace(-1, 1, 2001))
    if positive_on_circle(p):
        assert values.min() > -1e-12
    else:
        assert values.min() < 0.5  # integer coefficients of degree at most 8: a minimum of at most 0 is near a sample


@given(top=coefficients, bottom=coefficients)
def test_the_least_value_of_a_ratio_is_bracketed(top, bottom):
    square = fmpq_poly(bottom) ** 2 + fmpq_poly([1])
    found, where = least_on_circle(fmpq_poly(top), square)
    c = np.linspace(-1, 1, 4001)
    ratio = values_at_cosine(fmpq_poly(top), c) / values_at_cosine(square, c)
    assert found.low <= ratio.min() + 1e-9
    assert found.width <= 1e-12 * (1 + abs(found.low))
    exact = fmpq(*where.as_integer_ratio())
    at_minimum = fmpq_poly(top)(exact) / square(exact)
    assert float(at_minimum) == pytest.approx(found.low, rel=1e-6, abs=1e-9)


def test_the_least_value_of_a_parabola_lies_between_samples():
    found, where = least_on_circle(fmpq_poly([1, fmpq(-2, 3), 1]), fmpq_poly([1]))  # (c - 1/3)^2 + 8/9
    assert found.low <= 8 / 9 <= found.high
    assert where == pytest.approx(1 / 3)
