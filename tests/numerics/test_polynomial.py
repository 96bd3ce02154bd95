"""Exact root counts against polynomials built from known roots."""

from fractions import Fraction

import pytest
from flint import fmpq_poly
from hypothesis import given
from hypothesis import strategies as st

from lure.analysis.numerics import polynomial
from lure.analysis.numerics.polynomial import (
    RootCounts,
    from_descending,
    is_hurwitz,
    positive_from_zero,
    positive_root_count,
    real_roots,
    root_counts,
    to_descending,
    to_fmpq,
)

_SIZES = st.fractions(min_value=Fraction(1, 1000), max_value=1000, max_denominator=1000)
# factor kind, two sizes; the factor's roots are known by construction
_FACTORS = st.lists(
    st.tuples(
        st.sampled_from(["left", "right", "zero", "axis", "pair-left", "pair-right", "mirrored"]), _SIZES, _SIZES
    ),
    min_size=1,
    max_size=6,
)


def _factor(kind, a, b):
    """The polynomial and its roots left of, on, right of the axis."""
    a, b = to_fmpq(a), to_fmpq(b)
    return {
        "left": (fmpq_poly([a, 1]), (1, 0, 0)),
        "right": (fmpq_poly([-a, 1]), (0, 0, 1)),
        "zero": (fmpq_poly([0, 1]), (0, 1, 0)),
        "axis": (fmpq_poly([a, 0, 1]), (0, 2, 0)),
        "pair-left": (fmpq_poly([a * a + b, 2 * a, 1]), (2, 0, 0)),  # (s + a)^2 + b
        "pair-right": (fmpq_poly([a * a + b, -2 * a, 1]), (0, 0, 2)),
        "mirrored": (fmpq_poly([-a * a, 0, 1]), (1, 0, 1)),  # (s - a)(s + a)
    }[kind]


@given(_FACTORS)
def test_roots_are_counted_with_multiplicity_on_each_side(factors):
    p, expected = fmpq_poly([-3]), (0, 0, 0)
    for kind, a, b in factors:
        q, counts = _factor(kind, a, b)
        p, expected = p * q, tuple(x + y for x, y in zip(expected, counts, strict=True))
    assert root_counts(p) == RootCounts(*expected)
    assert is_hurwitz(p) == (expected[1] == expected[2] == 0)


@given(st.lists(st.fractions(min_value=-5, max_value=5, max_denominator=50), max_size=6), st.integers(0, 2))
def test_real_roots_are_counted_once_each(roots, pairs):
    p = fmpq_poly([1])
    for root in roots:
        p *= fmpq_poly([to_fmpq(-root), 1])
    p *= fmpq_poly([1, 1, 1]) ** pairs  # no real root
    assert len(real_roots(p)) == len(set(roots))
    assert positive_root_count(p) == len({root for root in roots if root > 0})
    assert positive_from_zero(p * p) == all(root < 0 for root in roots)


@pytest.mark.parametrize("gap", [Fraction(1, 2**40), Fraction(1, 10**60), Fraction(1, 10**300)])
def test_a_root_at_any_distance_from_the_axis_is_put_on_its_side(gap):
    for side in (1, -1):
        p = fmpq_poly([to_fmpq(4 + gap * gap), to_fmpq(-2 * side * gap), 1])  # roots side * gap +- 2i
        assert root_counts(p) == (RootCounts(0, 0, 2) if side > 0 else RootCounts(2, 0, 0))


def test_coefficients_survive_the_way_there_and_back():
    assert to_descending(from_descending([Fraction(1, 3), Fraction(0), Fraction(-2)])) == [Fraction(1, 3), 0, -2]


def test_the_zero_polynomial_has_no_count():
    with pytest.raises(ValueError, match="zero polynomial"):
        root_counts(fmpq_poly([]))


def test_positive_roots_are_counted_by_either_means(monkeypatch):
    # (x^2 - 2)^2 (x^2 - x - 1) x has the positive roots sqrt(2) and the golden ratio; its reversed polynomial the same
    p = fmpq_poly([-2, 0, 1]) ** 2 * fmpq_poly([-1, -1, 1]) * fmpq_poly([0, 1])
    for q in (p, fmpq_poly(p.coeffs()[::-1]), -3 * p):
        assert positive_root_count(q) == 2
        with monkeypatch.context() as patch:
            patch.setattr(polynomial, "STURM", 0)
            assert positive_root_count(q) == 2
