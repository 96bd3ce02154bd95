"""The assertions about a nonlinearity: right on both sides of its bounds, and a failure that can be read."""

import math
import re
from fractions import Fraction as F

import numpy as np
import pytest
from depth import sampled
from hypothesis import given, settings
from hypothesis import strategies as st

from lure import Cubic, Expression, Quantiser, Saturation, Sector, SlopeBounds, Tanh
from lure.analysis.nonlinearity.shape import known_odd
from lure.analysis.testing import (
    NonlinearityViolation,
    assert_in_sector,
    assert_monotone,
    assert_odd,
    assert_slope_restricted,
)
from lure.analysis.testing.strategies import monotone_graphs, sector_graphs
from lure.analysis.verdict import Evidence
from lure.errors import InputError
from lure.rod import NormalCompliance


def violation_of(assertion, *arguments, **settings):
    with pytest.raises(NonlinearityViolation) as caught:
        assertion(*arguments, **settings)
    return caught.value.violation


def hidden(nonlinearity):
    """The nonlinearity as a function of arrays, of which nothing but its values is known."""
    return lambda sigma: nonlinearity(sigma)


def one_at_a_time(nonlinearity):
    """The nonlinearity as a function of one float."""
    return lambda sigma: float(nonlinearity(float(sigma))) if isinstance(sigma, float) else 1 / 0


# -- both sides of a bound that is known by construction


@pytest.mark.slow
@settings(max_examples=sampled(8, of=1000))
@given(sector_graphs(F(-1), F(3)))
def test_a_black_box_passes_its_own_sector_and_fails_any_smaller(nonlinearity):
    # the extremes of phi(sigma)/sigma are at knots, between the points of any grid
    tight = nonlinearity.graph.sector
    assert assert_in_sector(hidden(nonlinearity), tight).evidence is Evidence.OBSERVED
    step = F(1, 10**6) * (tight.upper - tight.lower)
    # a bound that is only approached at infinity is within 1e-6 of its value long before 1e12
    above = violation_of(assert_in_sector, hidden(nonlinearity), Sector(tight.lower, tight.upper - step))
    below = violation_of(assert_in_sector, hidden(nonlinearity), Sector(tight.lower + step, tight.upper))
    assert nonlinearity.exact(F(above.sigma[0])) / F(above.sigma[0]) > tight.upper - step
    assert nonlinearity.exact(F(below.sigma[0])) / F(below.sigma[0]) < tight.lower + step


@pytest.mark.slow
@settings(max_examples=sampled(8, of=1000))
@given(monotone_graphs(F(5, 2)))
def test_a_black_box_passes_its_own_slope_bounds_and_fails_any_smaller(nonlinearity):
    tight = nonlinearity.graph.slope_bounds
    assert_slope_restricted(hidden(nonlinearity), tight)
    step = F(1, 10**6)
    pair = violation_of(
        assert_slope_restricted, hidden(nonlinearity), SlopeBounds(tight.lower, tight.upper - step)
    ).sigma
    x, y = map(F, pair)
    assert (nonlinearity.exact(y) - nonlinearity.exact(x)) / (y - x) > tight.upper - step
    assert violation_of(assert_slope_restricted, hidden(nonlinearity), SlopeBounds(tight.lower + step, tight.upper))


@pytest.mark.slow
@settings(max_examples=sampled(8, of=1000))
@given(sector_graphs(0, 2))
def test_known_laws_are_decided_for_every_sigma(nonlinearity):
    tight = nonlinearity.graph.sector
    assert assert_in_sector(nonlinearity, tight).evidence is Evidence.CERTIFIED
    # a billionth of a billionth is no matter of doubles
    with pytest.raises(
        NonlinearityViolation,
        match=r"leaves the sector .*passes the bound by .*e-[12]\d.*\(certified\), though doubles",
    ):
        assert_in_sector(nonlinearity, Sector(tight.lower, tight.upper - F(1, 10**18)))
    assert assert_in_sector(nonlinearity, Sector(tight.lower, tight.upper - F(1, 10**18)), tolerance=1e-17)


@pytest.mark.parametrize(
    "nonlinearity", [np.tanh, math.tanh, one_at_a_time(np.tanh)], ids=["arrays", "floats", "strict floats"]
)
def test_tanh_lies_in_0_1_and_in_nothing_smaller(nonlinearity):
    assert assert_in_sector(nonlinearity, Sector(0, 1)).points > 4000
    assert assert_slope_restricted(nonlinearity, SlopeBounds(0, 1))
    # tanh(s)/s = 1 - s^2/3: above 1 - 1e-9 for |s| < 5e-5; with 4e-15/|s| granted to rounding, there are such points
    found = violation_of(assert_in_sector, nonlinearity, Sector(0, 1 - 1e-9))
    assert 1 - 1e-9 < found.found <= 1
    assert violation_of(assert_slope_restricted, nonlinearity, SlopeBounds(0, 0.999999))
    assert violation_of(assert_slope_restricted, nonlinearity, SlopeBounds(1e-6, 1))


def test_the_two_sides_of_a_jump_are_found_to_the_last_digit():
    # rounding to the nearest integer: phi/sigma = 1/sigma just above 1/2, at most 2 and as near to 2 as doubles allow
    nearest = lambda sigma: np.sign(sigma) * np.floor(np.abs(sigma) + 0.5)
    assert_in_sector(nearest, Sector(0, 2))
    found = violation_of(assert_in_sector, nearest, Sector(0, 2 - 1e-9))
    assert abs(found.sigma[0]) == pytest.approx(0.5, abs=1e-9)
    assert_in_sector(Quantiser(step=1), Sector(0, 2))
    assert violation_of(assert_in_sector, Quantiser(step=1), Sector(0, 2 - 1e-9))


def test_a_bump_between_the_points_is_climbed():
    # width 1e-4 around 0.3333: the nearest of 50 points is 20 widths away on a linear grid of 1/12, but the bump's
    # algebraic tails lean towards it; the top is 1/2 + 1/2
    nonlinearity = lambda s: s * (0.5 + 0.5 / (1 + ((np.abs(s) - 0.3333) / 1e-4) ** 2))
    found = violation_of(assert_in_sector, nonlinearity, Sector(0, 0.999), on=(-1, 1))
    assert abs(found.sigma[0]) == pytest.approx(0.3333, abs=1e-5)
    assert_in_sector(nonlinearity, Sector(0, 1), on=(-1, 1))
    # also where the other bound is much nearer to most of the nonlinearity
    assert violation_of(assert_in_sector, nonlinearity, Sector(0.49, 0.999), on=(-1, 1))


def test_a_steep_stretch_between_the_points_is_found():
    # slope 1 + 2/(1 + ((s - 0.3333)/1e-4)^2): 3 at one point; over a step of 2e-3 around it the mean is about 1.3
    nonlinearity = lambda s: s + 2e-4 * (np.arctan((s - 0.3333) / 1e-4) + np.arctan(0.3333 / 1e-4))
    assert_slope_restricted(nonlinearity, SlopeBounds(0, 3), on=(-1, 1))
    low, high = violation_of(assert_slope_restricted, nonlinearity, SlopeBounds(0, 2.99), on=(-1, 1)).sigma
    assert 0.3332 < low < high < 0.3334


def test_a_spike_is_found_where_the_user_says_to_look():
    spike = lambda s: np.where(np.abs(s - 0.0213) < 1e-9, 2 * s, s)
    assert_in_sector(spike, Sector(0, 1))  # observed: it slips through
    assert violation_of(assert_in_sector, spike, Sector(0, 1), breakpoints=[0.0213]).found == 2


def test_breakpoints_of_a_contact_law_at_the_scale_of_its_user():
    # gap 0.02, compliance 1e-3: the slope is 1000 from the gap on, the chord below 1000 for every sigma
    contact = lambda x: max(x - 0.02, 0) / 1e-3
    assert_in_sector(contact, Sector(0, 1000))
    assert_slope_restricted(contact, SlopeBounds(0, 1000))
    assert violation_of(assert_slope_restricted, contact, SlopeBounds(0, 999.999))
    assert_in_sector(contact, Sector(0, 500), on=(-1, 0.04))  # (0.04 - 0.02)/1e-3/0.04 = 500
    assert violation_of(assert_in_sector, contact, Sector(0, 499.9), on=(-1, 0.04)).sigma == (0.04,)


def test_the_interval_is_kept():
    cubic = lambda s: s**3
    assert_in_sector(cubic, Sector(0, 9), on=(-3, 3))
    assert all(abs(x) <= 3 for x in violation_of(assert_in_sector, cubic, Sector(0, 8.9), on=(-3, 3)).sigma)
    assert all(
        0.5 <= x <= 2 for x in violation_of(assert_slope_restricted, cubic, SlopeBounds(1, 9), on=(0.5, 2)).sigma
    )
    assert_in_sector("max(x, 0)**1.5", Sector(0, 1), on=(-1, 1))
    assert violation_of(assert_in_sector, "max(x, 0)**1.5", Sector(0, 1), on=(-1, F(11, 10))).sigma == (1.1,)


def test_a_tolerance_is_a_tolerance():
    nonlinearity = lambda s: 1.01 * s
    assert_in_sector(nonlinearity, Sector(0, 1), tolerance=0.0101)
    assert violation_of(assert_in_sector, nonlinearity, Sector(0, 1), tolerance=0.0099)
    assert_in_sector("1.01*sigma", Sector(0, 1), tolerance=0.0101)
    assert violation_of(assert_in_sector, "1.01*sigma", Sector(0, 1), tolerance=0.0099)


def test_rounding_is_not_held_against_a_function():
    assert_in_sector(lambda s: (1 + s) - 1, Sector(0, 1), on=(-1, 1))  # relative error 1e-16/|s| near 0
    assert_in_sector(lambda s: 0.1 * s, Sector(0, F(1, 10)))  # the double 0.1 is above 1/10
    assert_slope_restricted(np.expm1, SlopeBounds(0, math.e), on=(-1, 1))


@pytest.mark.slow
def test_single_precision_is_judged_as_such():
    # the tanh of a neural network: phi/sigma exceeds 1 by up to 1e-7 near 0, and neighbouring slopes by far more
    single = lambda s: np.tanh(np.asarray(s, dtype=np.float32))
    sigma = np.logspace(-8, -4, 5000)
    assert (single(sigma).astype(float) / sigma).max() > 1 + 1e-9
    for nonlinearity in (single, lambda s: np.float32(single(float(s)))):
        assert_in_sector(nonlinearity, Sector(0, 1))
        assert_slope_restricted(nonlinearity, SlopeBounds(0, 1), on=(-20, 20))
        assert_odd(nonlinearity)
        assert violation_of(assert_in_sector, nonlinearity, Sector(0, 0.99))
        assert violation_of(assert_slope_restricted, nonlinearity, SlopeBounds(0, 0.99), on=(-20, 20))


# -- oddness and monotony


@pytest.mark.slow
def test_oddness():
    assert assert_odd("sigma**3/(1 + cos(sigma)**2)").evidence is Evidence.CERTIFIED
    assert assert_odd(Saturation()).evidence is Evidence.CERTIFIED
    assert assert_odd(np.arctan).evidence is Evidence.OBSERVED
    assert violation_of(assert_odd, NormalCompliance(2))
    assert violation_of(assert_odd, "sigma + exp(sigma) - 1").found == pytest.approx(2 * math.cosh(1) - 2)
    assert violation_of(assert_odd, lambda s: s + 1e-6 * s**2, on=(-1, 2)).sigma[0] <= 1
    assert_odd(lambda s: s + 1e-6 * s**2, on=(-1, 2), tolerance=2.1e-6)


@pytest.mark.parametrize(
    ("text", "odd"),
    [
        ("sigma*abs(sigma)", True),
        ("sin(sigma)/cos(sigma)", True),
        ("sigma**3 - sigma", True),
        ("sigma**2", None),
        ("sigma*sin(sigma)", None),
        ("where(abs(sigma) < 1, sigma**3, sigma)", True),
        ("where(sigma < 1, sigma**3, sigma**5)", None),
        ("min(max(sigma, -1), 1)", True),
        ("min(max(sigma, -1), 2)", False),
        ("atan(sigma) + exp(sigma**2)*tanh(sigma)", True),
        ("sqrt(sigma**2)*sigma", True),
        ("max(sigma, 0)**2", None),
    ],
)
def test_parity_of_formulas(text, odd):
    expression = Expression.parse(text, variables=("sigma",))
    assert known_odd(expression, "sigma") is odd
    points = np.linspace(0.1, 3, 30)
    sums = expression(sigma=points) + expression(sigma=-points)
    assert bool(np.allclose(sums, 0)) is bool(odd)


def test_monotony():
    assert_monotone(np.exp, on=(-700, 700))
    assert_monotone(NormalCompliance(3, 2))
    assert assert_monotone("sigma**3").evidence is Evidence.CERTIFIED
    low, high = violation_of(assert_monotone, np.sin).sigma
    assert math.sin(high) < math.sin(low)
    assert violation_of(assert_monotone, Cubic(linear=-1, cubic=1))


# -- nonlinearities that have no value, and arguments that make no sense


@pytest.mark.parametrize(
    ("nonlinearity", "says"),
    [
        (lambda s, gain: gain * s, r"phi\(1\) raises TypeError"),
        (math.log, r"phi\(-1\) raises ValueError"),
        (lambda s: s / 0, r"phi\(1\) raises ZeroDivisionError"),
        (lambda s: 1j * s, r"phi\(1\) is 1j"),
        (lambda s: None, r"phi\(1\) is None"),
        (lambda s: "2", r"phi\(1\) is '2'"),
        (lambda s: np.where(s > 2.5, np.nan, s), r"phi\(3\) is nan"),
        (math.sinh, r"phi\(1000\) raises OverflowError"),
        (np.sinh, r"phi\(1000\) is inf"),
        (lambda s: [s, s], r"phi\(1\) is \["),
    ],
)
@pytest.mark.parametrize("assertion", ["sector", "slope", "odd", "monotone"])
def test_a_law_without_a_value_is_said_in_one_sentence(nonlinearity, says, assertion):
    run = {
        "sector": lambda: assert_in_sector(nonlinearity, Sector(0, math.inf)),
        "slope": lambda: assert_slope_restricted(nonlinearity, SlopeBounds(0, math.inf)),
        "odd": lambda: assert_odd(nonlinearity),
        "monotone": lambda: assert_monotone(nonlinearity),
    }[assertion]
    with pytest.raises(NonlinearityViolation, match=says) as caught:
        run()
    text = str(caught.value)
    assert "\n" not in text
    of_the_point = not any(word in says for word in ("TypeError", "None", "'2'", "\\["))  # what an interval may help
    assert ("on=(low, high)" in text) is of_the_point
    assert caught.value.violation is None


def test_a_formula_may_overflow_in_doubles():
    assert assert_in_sector("exp(sigma) - 1", Sector(0, math.inf)).evidence is Evidence.CERTIFIED


def test_a_law_that_does_not_vanish_at_0_is_in_no_sector():
    for nonlinearity in (lambda s: s + 0.25, "sigma + 0.25"):
        found = violation_of(assert_in_sector, nonlinearity, Sector(0, 2))
        assert (found.sigma, found.phi) == ((0.0,), (0.25,))
    assert_in_sector(lambda s: s + 0.25, Sector(0, 2), on=(1, 2))


def test_a_law_with_memory_is_refused():
    last = [0.0]

    def play(sigma):
        last[0] = 0.5 * last[0] + float(sigma)
        return last[0]

    with pytest.raises(InputError, match="without memory or chance"):
        assert_in_sector(play, Sector(0, 2))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"on": (1, 0)}, "give low < high"),
        ({"on": 3}, "give a pair"),
        ({"on": (0, math.inf)}, "on\\[1\\] is inf"),
        ({"samples": 10}, "at least 50"),
        ({"tolerance": -1}, "at least 0"),
        ({"tolerance": math.nan}, "at least 0"),
        ({"plot": "law.txt"}, ".png or .svg"),
    ],
)
def test_arguments_that_make_no_sense(change, says):
    with pytest.raises(InputError, match=says):
        assert_in_sector(np.tanh, Sector(0, 1), **change)


def test_more_that_makes_no_sense():
    with pytest.raises(InputError, match="phi is 3"):
        assert_in_sector(3, Sector(0, 1))
    with pytest.raises(InputError, match="sector is"):
        assert_in_sector(np.tanh, SlopeBounds(0, 1))
    with pytest.raises(InputError, match="slope is"):
        assert_slope_restricted(np.tanh, (0, 1))
    with pytest.raises(InputError, match="0 inside"):
        assert_odd(np.tanh, on=(1, 2))
    with pytest.raises(InputError, match="phi"):
        assert_in_sector("__import__(1)", Sector(0, 1))


# -- what is said


def test_a_pass_says_what_was_checked():
    text = str(assert_in_sector(np.tanh, Sector(0, 1), on=(-20, 20)))
    assert re.fullmatch(
        r"tanh lies in the sector \[0, 1\]: no violation among \d+ values on \[-20, 20\] \(observed\)", text
    )
    assert str(assert_in_sector(Saturation(gain=2), Sector(0, 2))).endswith("(certified)")
    assert assert_in_sector(Tanh(), Sector(0, 1)).to_dict()["evidence"] == "certified"


@pytest.mark.parametrize(
    ("nonlinearity", "sector", "simple"),
    [
        (np.tanh, Sector(0, 0.9), 0.5),  # 0.92; 0.76 at 1
        (lambda s: max(s - 0.02, 0) / 1e-3, Sector(0, 600), 1.0),  # 980
        (lambda s: s + np.sin(40 * s), Sector(-10, 35), 0.01),  # 1 + 40 (1 - 0.16/6) = 39.9
        (lambda s: s**3, Sector(0, 4), 3.0),  # 9; 4 at 2
    ],
)
def test_the_violating_point_is_a_simple_number(nonlinearity, sector, simple):
    assert violation_of(assert_in_sector, nonlinearity, sector).sigma == (simple,)


def test_simple_numbers_are_those_of_the_interval():
    contact = lambda x: max(x - 2e-7, 0) / 1e-3
    assert violation_of(assert_in_sector, contact, Sector(0, 100), on=(-1e-6, 1e-6)).sigma == (1e-6,)
    assert violation_of(assert_slope_restricted, contact, SlopeBounds(0, 100), on=(-1e-6, 1e-6)).sigma == (0.0, 1e-6)


@given(
    st.sampled_from([np.tanh, np.arctan, lambda s: s**3, lambda s: 1e7 * s, lambda s: s + 0.1 * s**2]),
    st.sampled_from([1e-9, 1e-3, 1.0, 1e6]),
)
def test_every_message_fits_a_terminal(nonlinearity, scale):
    scaled = lambda s: scale * nonlinearity(s / scale)
    for assertion, arguments in (
        (assert_in_sector, (Sector(0.1, 0.5),)),
        (assert_slope_restricted, (SlopeBounds(0.1, 0.5),)),
        (assert_odd, ()),
    ):
        try:
            assertion(scaled, *arguments, on=(-3 * scale, 3 * scale))
        except NonlinearityViolation as error:
            text = str(error)
            assert text.isascii()
            assert max(map(len, text.split("\n"))) <= 76
            assert text.count("X") >= 2  # in the plot and in its legend
            plot = [line.partition("|")[2] for line in text.split("\n") if re.match(r"[ \d.e+-]{9,} \|", line)]
            assert len(plot) == 17
            assert sum(line.count("*") for line in plot) > 10
        else:
            assert assertion is assert_odd


def test_the_message_holds_the_numbers():
    found = violation_of(assert_in_sector, lambda s: s**3, Sector(0, 4), on=(-3, 3))
    assert (found.sigma, found.phi, found.found, found.bound, found.excess) == ((3.0,), (27.0,), 9.0, 4, 5.0)
    assert found.slope == pytest.approx(27, rel=1e-6)
    with pytest.raises(NonlinearityViolation) as caught:
        assert_in_sector(lambda s: s**3, Sector(0, 4), on=(-3, 3))
    rows = dict(re.findall(r"^  (\S.*?)  +(\S.*)$", str(caught.value), re.M)[:6])
    assert rows["sigma"] == "3"
    assert rows["phi(sigma)"] == "27"
    assert rows["allowed"] == "[0, 4]"
    assert rows["excess"] == "5"
    assert rows["slope there"] == "27"


# min(sigma, 1) has the slopes 1 and 0 beside its corner at 1, whose mean is the slope of nothing; sin at its maximum,
# 0.636 of sigma there, has one, 0; and 0 is written without a sign
def test_no_slope_is_told_where_there_is_none():
    assert math.isnan(violation_of(assert_in_sector, lambda s: min(s, 1.0), Sector(0, 0.9), on=(0.5, 1.5)).slope)
    top = violation_of(assert_in_sector, np.sin, Sector(0, 0.5), on=(np.pi / 2, np.pi / 2 + 1))
    assert top.slope == pytest.approx(np.cos(top.sigma[0]), abs=1e-4)
    assert "from sigma = -0.001 to 0\n" in violation_of(assert_slope_restricted, np.sign, SlopeBounds(0, 100)).message()


def test_the_x_stands_where_the_point_is():
    # window [-4.5, 4.5] cut to [-3, 3]: sigma = 3 is the last column, phi = 27 near the top, above every other value
    with pytest.raises(NonlinearityViolation) as caught:
        assert_in_sector(lambda s: s**3, Sector(0, 4), on=(-3, 3))
    rows = [line for line in str(caught.value).split("\n") if " |" in line[:12]]
    columns = [line.index("X") for line in rows if "X" in line]
    assert columns == [11 + 59]
    assert "X" in rows[0] + rows[1]


@pytest.mark.slow
@pytest.mark.parametrize("ending", ["png", "svg"])
def test_a_plot_is_saved_if_and_only_if_the_law_fails(tmp_path, ending):
    target = tmp_path / "deep" / f"law.{ending}"
    assert_in_sector(np.tanh, Sector(0, 1), plot=target)
    assert not target.exists()
    with pytest.raises(NonlinearityViolation):
        assert_in_sector(np.tanh, Sector(0, 0.5), plot=target)
    start = target.read_bytes()[:100]
    assert start.startswith(b"\x89PNG") if ending == "png" else b"<svg" in target.read_bytes()
    target.write_bytes(b"old")
    with pytest.raises(NonlinearityViolation):
        assert_slope_restricted(np.tanh, SlopeBounds(0, 0.5), plot=str(target))
    with pytest.raises(NonlinearityViolation):
        assert_odd(lambda s: s + s**2, plot=str(target), on=(-1, 1))
    assert target.read_bytes() != b"old"


def test_a_violation_is_an_assertion_error():
    assert issubclass(NonlinearityViolation, AssertionError)
    with pytest.raises(AssertionError):
        assert_monotone(np.cos)


def test_what_passed_says_to_within_what():
    # 1.01 sigma is not in [0, 1]: what is certified is that it is so up to 0.0101
    assert str(assert_in_sector("1.01*sigma", Sector(0, 1), tolerance=0.0101)).count("[0, 1], to within 0.0101: ") == 1
    assert "within" not in assert_in_sector("sigma", Sector(0, 1)).claim


@pytest.mark.parametrize("text", ["1/sigma", "sigma*sqrt(sigma**2 - 1)/sqrt(sigma**2 - 1)"])
def test_an_odd_form_without_values_is_not_certified(text):
    with pytest.raises(
        NonlinearityViolation, match="a nonlinearity is a function of one number with a finite real value everywhere"
    ):
        assert_odd(text)
    assert assert_odd("sigma/(sigma**2 - 4)", on=(-1, 1)).evidence is Evidence.CERTIFIED


def test_a_law_that_hides_nan_from_its_bounds_does_not_pass():
    # nan for sigma < 0, which an interval for sign(...) of [-1, 1] would hide
    with pytest.raises(
        NonlinearityViolation, match="a nonlinearity is a function of one number with a finite real value everywhere"
    ):
        assert_in_sector("sigma*sign(sqrt(sigma))**2", Sector(-3, 3))


def test_a_violation_seen_in_floating_point_is_not_called_refuted():
    found = violation_of(assert_in_sector, lambda s: 2 * s, Sector(0, 1))
    assert "REFUTED" not in found._repr_html_()


@pytest.mark.parametrize("text", ["x*sign(1/(x - 1))", "x*where(1/(x - 1) > 0, 1, 3)"])
def test_a_formula_that_divides_by_zero_at_one_point_has_no_value_there(text):
    # in doubles 1/0 is inf, and its sign 1; the values beside it lie in the sector
    with pytest.raises(NonlinearityViolation, match="has no value at sigma = 1, where it divides by zero"):
        assert_in_sector(text, Sector(-1, 3))
    assert assert_in_sector(text, Sector(-1, 3), on=(2, 3)).evidence is Evidence.CERTIFIED
