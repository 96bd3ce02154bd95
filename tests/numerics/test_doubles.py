"""lure.analysis.numerics.doubles: matrices as text whose forms lie on the side that is said."""

import json
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lure.analysis.numerics.doubles import form_text

entries = st.fractions(-10, 10, max_denominator=10**9)
scales = st.integers(-40, 40).map(lambda k: Fraction(10) ** k)


def printed(rows, towards):
    return [[Fraction(v) for v in row] for row in json.loads(form_text(rows, towards), parse_float=str, parse_int=str)]


# x' (P' - P) x >= 0 for all x, P' as printed: 2 x 2, so iff both diagonal entries and the determinant are nonnegative.
# That it is not far: an entry loses 5e-7 of itself at most, and |b| <= 10 sqrt(a c) of those drawn
@pytest.mark.parametrize(("towards", "sign"), [("above", 1), ("below", -1)])
@given(a=st.fractions(1, 10, max_denominator=10**9), b=entries, c=st.fractions(1, 10, max_denominator=10**9), s=scales)
def test_the_form_of_what_is_printed_lies_on_its_side_whatever_the_units_of_the_states(towards, sign, a, b, c, s):
    rows = [[a, b * s], [b * s, c * s * s]]
    (p, q), (_, r) = [
        [sign * (x - y) for x, y in zip(*two, strict=True)] for two in zip(printed(rows, towards), rows, strict=True)
    ]
    assert p >= 0
    assert r >= 0
    assert p * r >= q * q
    assert p <= Fraction(2, 10**5) * a
    assert r <= Fraction(2, 10**5) * c * s * s
