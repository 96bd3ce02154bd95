"""What is printed of certified bounds holds: rounded outwards, and infinite where nothing was shown."""

import re
from fractions import Fraction

import pytest
from depth import sampled

from lure import Sector
from lure.analysis.nonlinearity import nonlinearity_bounds, search
from lure.analysis.testing import assert_in_sector


def printed(text):
    """The two ends of the sector line, as exact decimals."""
    return [Fraction(end) for end in re.search(r"sector \[(\S+), (\S+)\]", text).groups()]


@pytest.mark.slow
def test_a_bound_that_is_not_known_is_not_printed_as_one(monkeypatch):
    # x/(sin(x) - 1) has poles: values as large as one likes between the points looked at
    monkeypatch.setattr(search, "MOST_BOXES", sampled(400, of=search.MOST_BOXES))  # every one is looked at
    found = nonlinearity_bounds("x/(sin(x)-1)")
    assert "sector [-inf, inf]" in str(found)
    assert "seen at sigma" in str(found)
    assert "-inf" in found._repr_html_()


@pytest.mark.parametrize("text", ["sin(x)", "tanh(x)+x/3", "x*exp(-x**2)", "atan(3*x)/7"])
def test_what_is_printed_contains_the_law(text):
    found = nonlinearity_bounds(text)
    low, high = printed(str(found))
    assert low <= found.sector_lower.outer
    assert high >= found.sector_upper.outer
    assert high - low <= (found.sector_upper.inner - found.sector_lower.inner) * Fraction("1.000000002")


# the least value of sin(x)/x is cos(t) at the t = 4.4934... where tan t = t: -0.21723362821122...
def test_the_last_digit_of_a_lower_bound_is_rounded_down():
    assert "sector [-0.2172336283, 1]" in str(nonlinearity_bounds("sin(x)"))
    checked = assert_in_sector("sin(x)", Sector(-0.25, 1))
    assert "is at least -0.2172336283" in str(checked)
