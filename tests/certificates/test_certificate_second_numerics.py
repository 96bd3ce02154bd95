"""The second checker's own numerics: roots by their side, polynomials on the circle, nonlinearities in pieces."""

import cmath
from fractions import Fraction as F

import pytest
from flint import fmpq, fmpq_poly
from hypothesis import given
from hypothesis import strategies as st

from lure.analysis.certificates.second.classes import graph
from lure.analysis.certificates.second.numerics import (
    Counts,
    Laurent,
    X,
    even_odd,
    half_plane_counts,
    nonnegative_from_zero,
    nonnegative_on_circle,
    positive_from_zero,
    positive_on_circle,
    positive_roots,
    to_fmpq,
)
from lure.analysis.certificates.second.systems import Plant

ONE = fmpq_poly([1])


# s + a has one root at -a; s^2 + 2 b s + c with b^2 < c two at real part -b; s^2 + c, c > 0, two on the axis.
FACTORS = {
    "left": [X + 3, X**2 + X + 5, X * 2 + 1],
    "right": [X - 2, X**2 - X + 7, X * 3 - 1],
    "axis": [X, X**2 + 2, X**2 * 5 + 1],
}


@given(st.lists(st.tuples(st.sampled_from([*FACTORS]), st.integers(0, 2), st.integers(1, 3)), max_size=5))
def test_roots_are_counted_by_their_side_with_multiplicity(chosen):
    wanted, p = dict.fromkeys(FACTORS, 0), ONE
    for side, i, power in chosen:
        factor = FACTORS[side][i]
        wanted[side] += power * factor.degree()
        p *= factor**power
    assert half_plane_counts(-p) == Counts(**wanted)


@given(st.lists(st.integers(-4, 4), min_size=1, max_size=6), st.floats(-3, 3))
def test_the_value_on_the_axis(coefficients, omega):
    p = fmpq_poly(coefficients)
    e, o = even_odd(p)
    x, s = omega * omega, 1j * omega
    value = sum(c * s**k for k, c in enumerate(coefficients))
    assert value == pytest.approx(at(e, x) + s * at(o, x), abs=1e-9 * (1 + abs(omega)) ** 6)


def at(p, x):
    return sum(int(c.p) / int(c.q) * x**k for k, c in enumerate(p.coeffs()))


def test_positive_roots_come_with_their_multiplicities():
    found = positive_roots(X**3 * (X - 2) ** 2 * (X - 1) * (X + 5) * (X**2 + 1))
    assert sorted((round(float(root.mid()), 9), m) for root, m in found) == [(1.0, 1), (2.0, 2)]


# (x - 1)^2 touches 0, x (x - 1)^2 from 0 on; x^2 - 3 x + 2 is negative between 1 and 2.
def test_signs_from_zero_on():
    assert positive_from_zero(X**2 - X + 1)
    assert not positive_from_zero((X - 1) ** 2)
    assert nonnegative_from_zero(X * (X - 1) ** 2)
    assert not nonnegative_from_zero(X**2 - 3 * X + 2)
    assert not nonnegative_from_zero(-X)


# c^2 - 1/4 changes its sign at 1/2; (c - 1/2)^2 touches 0 there; 1 - c^2 is 0 at both ends, 2 - c nowhere.
@pytest.mark.parametrize(
    ("p", "positive", "nonnegative"),
    [
        (2 - X, True, True),
        (X**2 - fmpq(1, 4), False, False),
        ((X - fmpq(1, 2)) ** 2, False, True),
        (1 - X**2, False, True),
        (X - 1, False, False),
        (fmpq_poly([]), False, True),
        ((X - 1) ** 2 * (X + 2), False, True),
        (X**3 - X + 1, True, True),  # least value 1 - 2/(3 sqrt(3)) > 0
    ],
)
def test_signs_on_the_circle(p, positive, nonnegative):
    assert (positive_on_circle(p), nonnegative_on_circle(p)) == (positive, nonnegative)


@given(st.lists(st.integers(-4, 4), min_size=1, max_size=6), st.integers(0, 4), st.floats(0, 3.14))
def test_the_real_part_on_the_circle(coefficients, shift, w):
    z = cmath.exp(1j * w)
    one = Laurent(fmpq_poly(coefficients), shift)
    value = sum(c * z ** (k - shift) for k, c in enumerate(coefficients))
    assert at(one.real_part(), z.real) == pytest.approx(value.real, abs=1e-8)
    assert at(one.conjugate().real_part(), z.real) == pytest.approx(value.real, abs=1e-8)
    both = one * one.conjugate() + one.scaled(F(1, 2))
    assert at(both.real_part(), z.real) == pytest.approx(abs(value) ** 2 + value.real / 2, abs=1e-7)


# z - 1/2 has its root inside, z + 1 on, z - 3 outside the unit circle; z = -1 is mapped to infinity.
def test_a_plant_in_discrete_time():
    d = (2 * X - 1) * (X + 1) ** 2 * (X - 3)
    assert Plant.of(ONE, d, discrete=True).counts == Counts(left=1, axis=2, right=1)
    assert Plant.of(ONE, (2 * X - 1) * (X - 1), discrete=True).case == "critical"
    assert Plant.of(ONE, (2 * X - 1) * (X + 1), discrete=True).case is None
    # 1/(z - 1 + 1/2 + g): stable for |1/2 - g| < 1
    plant = Plant.of(ONE, X - fmpq(1, 2), discrete=True)
    assert [plant.shifted(F(g, 2)).case for g in (-1, 0, 2, 3)] == ["critical", "stable", "stable", None]


def test_a_law_gets_the_origin_and_its_kinks():
    nonlinearity = graph([["-1", "-1"], ["2", "2"]], "0", "3")  # a line through 0 between two kinks
    assert nonlinearity.knots == (-1, 0, 2)
    assert nonlinearity.slopes == (0, 1, 1, 3)
    assert [kink[0] for kink in nonlinearity.kinks] == [-1, 2]
    assert (nonlinearity.at(F(-5)), nonlinearity.at(F(1, 2)), nonlinearity.at(F(3))) == (-1, F(1, 2), 5)
    assert sorted(set(nonlinearity.chords)) == [0, 1, 3]
    assert not nonlinearity.odd
    assert graph([["-1", "-1"], ["1", "1"]], "0", "0").odd
    assert to_fmpq(F(2, 3)) == fmpq(2, 3)
