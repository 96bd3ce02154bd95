"""Sector and slope bounds against functions whose bounds are known by construction, and against symmetries."""

import math
from fractions import Fraction
from types import SimpleNamespace

import pytest
from bound_nonlinearities import INF, nonlinearities
from hypothesis import given, settings
from hypothesis import strategies as st

from lure.analysis.nonlinearity import bounds, nonlinearity_bounds, search, violation
from lure.analysis.verdict import Evidence, Verdict
from lure.classes import Sector, SlopeBounds
from lure.errors import InputError
from lure.nonlinearities import (
    Cubic,
    DeadZone,
    LeakyReLU,
    PiecewiseLinear,
    Quantiser,
    ReLU,
    Saturation,
    Tanh,
    shifted_nonlinearity,
)
from lure.nonlinearities.base import NormalCompliance


def check(extreme, truth, side, made, *, scale):
    """The truth lies between the inner and the outer bound, and these are close."""
    assert side * extreme.inner <= side * truth <= side * extreme.outer, (made, extreme, truth)
    if made.exact:
        assert extreme.inner == extreme.outer == truth, (made, extreme, truth)
    else:
        assert extreme.gap <= 1e-9 * float(scale), (made, extreme)


def check_law(made):
    found = nonlinearity_bounds(made.text, on=made.on)
    assert found.evidence is Evidence.CERTIFIED
    assert not found.notes or not made.exact
    for truth, pair in (
        (made.sector, (found.sector_lower, found.sector_upper)),
        (made.slope, (found.slope_lower, found.slope_upper)),
    ):
        if truth is not None:
            scale = max(map(abs, truth))
            check(pair[0], truth[0], -1, made, scale=scale)
            check(pair[1], truth[1], 1, made, scale=scale)


@pytest.mark.slow
def test_laws_with_known_bounds():
    for made in nonlinearities(1, piecewise_linear=60, polynomial=40, rational=20, saturating=12):
        check_law(made)


@pytest.mark.thorough
def test_ten_thousand_laws_with_known_bounds():
    for made in nonlinearities(20, piecewise_linear=4200, polynomial=3500, rational=2000, saturating=300):
        check_law(made)


def test_sums_of_a_line_and_a_sine():
    for made in nonlinearities(3, sine=10):
        found = nonlinearity_bounds(made.text, on=made.on)
        for truth, extreme in zip(
            (*made.sector, *made.slope),
            (found.sector_lower, found.sector_upper, found.slope_lower, found.slope_upper),
            strict=True,
        ):
            assert float(extreme.inner) == pytest.approx(float(truth), rel=1e-14, abs=1e-14), made
            assert extreme.gap <= 1e-9 * float(max(map(abs, made.slope)))


# (text, on, sector, slope), each by hand:
KNOWN = [
    ("x", None, (1, 1), (1, 1)),
    ("0*x", None, (0, 0), (0, 0)),
    ("x**3", None, (0, INF), (0, INF)),
    ("x - x**3", None, (-INF, 1), (-INF, 1)),
    ("x**2", None, (-INF, INF), (-INF, INF)),
    ("sqrt(x**2)", None, (-1, 1), (-1, 1)),
    ("(x**4)**0.25 + x", None, (0, 2), (0, 2)),
    ("x*abs(x)", (-2, 1), (0, 2), (0, 4)),
    ("abs(x)", None, (-1, 1), (-1, 1)),
    ("x/(1 + x**2)", None, (0, 1), (Fraction(-1, 8), 1)),  # slope (1 - x^2)/(1 + x^2)^2, least at x^2 = 3
    ("min(max(2*x, -1), 1)", None, (0, 2), (0, 2)),
    ("min(max(2*x, -1), 1)", (1, 4), (Fraction(1, 4), 1), (0, 0)),
    ("max(x, 0)**1.5", (-1, 1), (0, 1), (0, Fraction(3, 2))),
    ("max(x, 0)**1.5", None, (0, INF), (0, INF)),
    ("max(x, 0)**0.5", None, (0, INF), (0, INF)),
    ("tanh(x)", None, (0, 1), (0, 1)),
    ("exp(x) - 1", None, (0, INF), (0, INF)),
    ("1 - exp(-x)", (0, 1), (1 - Fraction(math.exp(-1)), 1), (Fraction(math.exp(-1)), 1)),
    ("sqrt(1 + x**2) - 1", None, (-1, 1), (-1, 1)),
    ("atan(x)", None, (0, 1), (0, 1)),
    (
        "x*exp(-x**2)",
        None,
        (0, 1),
        (-2 * Fraction(math.exp(-1.5)), 1),
    ),  # slope (1 - 2 x^2) e^(-x^2), least at x^2 = 3/2
    ("x**2*exp(-x)", (0, 9), (0, Fraction(math.exp(-1))), None),  # chord x e^(-x)
    ("log(1 + abs(x))*sign(x)", None, (0, 1), (0, 1)),
    ("x*tanh(x)", None, (-1, 1), None),
    ("where(x > 1, 2*x, x)", None, (1, 2), (1, INF)),
    ("where(x > 1, x, 2*x)", None, (1, 2), (-INF, 2)),
    ("where(x == 1, 5, x)", None, (1, 5), (-INF, INF)),
    ("where(x > 0, 1, 0)", None, (0, INF), (0, INF)),
    ("x*where(abs(x) > 0.5, 2, 1)", None, (1, 2), (1, INF)),  # up at -1/2, from -1 to -1/2, and at 1/2
    ("where(abs(x) > 1, tanh(x), tanh(x))", None, (0, 1), (0, 1)),  # continuous, for all its branches
    ("tanh(x - 1) + tanh(1)", None, (0, None), (0, 1)),  # vanishes at 0, seen without numbers
    ("where(x > 1, exp(x) - exp(1) + tanh(1), tanh(x))", (-1, 2), None, (None, Fraction(math.exp(2)))),  # continuous
    ("where(x > 0, x*(1/tanh(x)), 0)", (-1, 1), (0, INF), (0, INF)),  # a jump from 0 to 1 at 0
    ("sign(min(3, x**2))", None, (-INF, INF), None),  # 1 but at 0, where it jumps; 3 is met at an irrational point
    ("max(x**2 - 2, 0)", (-2, 2), (-1, 1), (-4, 4)),  # the kink, at the root of 2, is irrational
    ("sin(exp(x) - 1)", (-1, 0), None, (Fraction(math.exp(-1) * math.cos(math.exp(-1) - 1)), 1)),
]


@pytest.mark.parametrize(("text", "on", "sector", "slope"), KNOWN, ids=lambda value: str(value)[:30])
def test_bounds_found_by_hand(text, on, sector, slope):
    found = nonlinearity_bounds(text, on=on)
    for truth, pair in (
        (sector, (found.sector_lower, found.sector_upper)),
        (slope, (found.slope_lower, found.slope_upper)),
    ):
        for extreme, value in zip(pair, truth or (), strict=False):
            if value is None:
                continue
            assert float(extreme.inner) == pytest.approx(float(value), rel=1e-14, abs=1e-12)
            assert extreme.gap <= 1e-9 * max(1, abs(float(value)) if math.isfinite(value) else 1)
            if isinstance(value, int) and text not in ("x*tanh(x)",):
                assert extreme.inner == value


@pytest.mark.parametrize(
    ("text", "name", "place", "attained"),
    [
        ("x/(1 + x**2)", "sector_upper", "sigma -> 0", False),
        ("x/(1 + x**2)", "sector_lower", "|sigma| -> inf", False),
        ("x/(1 + x**2)", "slope_upper", 0, True),
        ("x*(2 - (x - 3)**2)", "sector_upper", 3, True),
        ("exp(x) - 1", "sector_lower", "sigma -> -inf", False),
        ("exp(x) - 1", "sector_upper", "sigma -> inf", False),
        ("where(x > 1, 2*x, x)", "slope_upper", "a jump at 1", False),
        ("where(x > 1, 2, x)", "sector_upper", "sigma -> 1+", False),
        ("where(x >= 1, 2, x)", "sector_upper", 1, True),
    ],
)
def test_where_a_bound_is_attained(text, name, place, attained):
    extreme = getattr(nonlinearity_bounds(text), name)
    assert (extreme.at, extreme.attained) == (place, attained)


def test_an_irrational_place_is_enclosed():
    # phi/x = sin(x)/x is least where tan(x) = x = 4.493409457909064175307880927...
    low, high = sorted(map(abs, nonlinearity_bounds("sin(x)").sector_lower.at))
    truth, digits = Fraction("4.493409457909064175307880927"), Fraction(1, 10**26)
    assert low - digits <= truth <= high + digits
    assert high - low < Fraction(1, 10**20)


LIBRARY = [
    Saturation(gain=2, limit=Fraction(1, 3)),
    Saturation(gain=2, limit=1, lower_limit=0),
    DeadZone(width=Fraction(1, 7), gain=3),
    ReLU(gain=5),
    LeakyReLU(negative_slope=Fraction(-1, 10)),
    PiecewiseLinear([(-1, -3), (2, 6), (4, 7)], left_slope=0, right_slope=Fraction(1, 2)),
    Quantiser(step=Fraction(1, 3)),
    Cubic(linear=1, cubic=-2),
    Tanh(scale=2, gain=3),
    NormalCompliance(stiffness=4, exponent=1),
    NormalCompliance(stiffness=4, exponent=Fraction(3, 2)),
    NormalCompliance(stiffness=4, exponent=Fraction(1, 2)),
    shifted_nonlinearity(Tanh(scale=2), Fraction(1, 4)),
]


@pytest.mark.parametrize("nonlinearity", LIBRARY, ids=lambda nonlinearity: type(nonlinearity).__name__)
def test_laws_of_the_library_agree_with_what_they_say_of_themselves(nonlinearity):
    found = nonlinearity_bounds(nonlinearity)
    assert (found.sector_lower.inner, found.sector_upper.inner) == (
        nonlinearity.sector.lower,
        nonlinearity.sector.upper,
    )
    assert found.sector_lower.exact
    assert found.sector_upper.exact
    if nonlinearity.slope_bounds is None:
        assert found.slope_upper.inner == INF  # the quantiser jumps
    else:
        assert found.slope == nonlinearity.slope_bounds


bounds_of_a_law = st.sampled_from(
    ["x/(1 + x**2)", "tanh(x) + x/4", "max(x, x**3)", "where(x > 1, 2*x, x)", "x**2", "sin(x)"]
)
factor = st.fractions(min_value=Fraction(1, 8), max_value=8, max_denominator=8)


def ends(found):
    return [found.sector_lower, found.sector_upper, found.slope_lower, found.slope_upper]


def close(extreme, low, high):
    """Two enclosures of one number have something in common."""
    inner, outer = sorted((extreme.inner, extreme.outer))
    return inner <= max(low, high) and min(low, high) <= outer


@settings(max_examples=25, deadline=None)
@given(text=bounds_of_a_law, p=factor, q=factor)
@pytest.mark.slow
def test_units_of_force_and_displacement_scale_the_bounds(text, p, q):
    once = nonlinearity_bounds(text)
    other = nonlinearity_bounds(f"({p})*({text.replace('x', f'(({q})*x)').replace(f'ma(({q})*x)', 'max')})")
    for a, b in zip(ends(once), ends(other), strict=True):
        assert close(b, a.inner * p * q, a.outer * p * q)


@settings(max_examples=10, deadline=None)
@given(text=bounds_of_a_law, g=factor)
def test_a_gain_taken_off_moves_the_bounds(text, g):
    for a, b in zip(ends(nonlinearity_bounds(text)), ends(nonlinearity_bounds(f"{text} - ({g})*x")), strict=True):
        assert close(b, a.inner - g, a.outer - g)


@settings(max_examples=10, deadline=None)
@given(text=bounds_of_a_law)
def test_reflections(text):
    once = nonlinearity_bounds(text)
    mirrored = text.replace("x", "(-x)").replace("ma(-x)", "max")
    for a, b in zip(ends(once), ends(nonlinearity_bounds(f"-({mirrored})")), strict=True):
        assert close(b, a.inner, a.outer)  # -phi(-sigma) has the same bounds,
    low, high, slope_low, slope_high = ends(nonlinearity_bounds(f"-({text})"))
    for a, b in zip(ends(once), (high, low, slope_high, slope_low), strict=True):
        assert close(b, -a.inner, -a.outer)  # and -phi has them reversed


def test_the_sector_contains_and_a_narrower_one_is_refuted():
    found = nonlinearity_bounds("tanh(x) + x/3")
    assert found.sector.lower <= Fraction(1, 3) < Fraction(4, 3) <= found.sector.upper
    assert float(found.sector.upper) == pytest.approx(4 / 3, rel=1e-15)
    assert (
        found.within(Sector(Fraction(1, 3) - Fraction(1, 10**30), Fraction(4, 3) + Fraction(1, 10**30)))
        is Verdict.PROVED
    )
    assert found.within(Sector(0, Fraction(4, 3) - Fraction(1, 10**30))) is Verdict.REFUTED
    assert found.within(SlopeBounds(Fraction(1, 3) + Fraction(1, 10**30), 2)) is Verdict.REFUTED
    assert found.within(Sector(0, Fraction(4, 3))) is Verdict.INCONCLUSIVE  # 4/3 is no ball: within 1e-47 of it


def test_an_exact_bound_decides_its_own_limit():
    assert nonlinearity_bounds("x/(1 + x**2)").within(Sector(0, 1)) is Verdict.PROVED
    assert nonlinearity_bounds("min(max(x/3, -1), 1)").within(Sector(0, Fraction(1, 3))) is Verdict.PROVED


@pytest.mark.parametrize(
    ("text", "on", "least", "most"),
    [
        # chords 2 + (t^4/4 - t^2) at t = (sigma - 1)/e, e = 1e-55: least at t = +-sqrt 2, where they are 1
        ("x*(2 + 1e220*((x - 1)**4/4 - 1e-110*(x - 1)**2))", None, 1, INF),
        # 50/sigma for 0 < |sigma - 1| < sqrt 2 e, e = 1e-20
        ("where((x - 1)**2*((x - 1)**2 - 2e-40) < 0, 50, x)", None, 1, 50),
        ("where(abs(x - 3) < 1e-40, 50, x)", None, 1, Fraction(50, 3)),
        ("where(abs(x - 3) < 1e-40, 50, x)", (3 - Fraction(1, 10**40), 4), 1, Fraction(50, 3)),
        # chords 1 + 1/(1 + 1e4 (t^2 - 2)^2), t = (sigma - 1)/1e-20: 2 at t = +-sqrt 2, next to nothing more at t = 0
        ("x*(1 + 1/(1 + 1e84*((x - 1)**2 - 2e-40)**2))", None, 1, 2),
    ],
)
def test_roots_closer_to_a_short_rational_than_the_working_precision_are_told_from_it(text, on, least, most):
    found = nonlinearity_bounds(text, on=on)
    assert found.sector_lower.outer <= least
    assert found.sector_lower.inner == pytest.approx(least)
    assert found.sector_upper.outer >= most


@pytest.mark.slow
def test_a_tail_that_does_not_settle_is_not_certified():
    found = nonlinearity_bounds("sin(x**2)/2 + x")  # the slope 1 + x cos(x^2) has no bounds, which is not shown
    assert (found.slope_lower.outer, found.slope_upper.outer) == (-INF, INF)
    assert math.isfinite(found.slope_upper.inner) or found.slope_upper.inner > 10**10
    assert any("could not be shown" in note for note in found.notes)
    assert found.within(SlopeBounds(-(10**9), INF)) is Verdict.REFUTED
    assert nonlinearity_bounds("x*log(2 + abs(x))").within(Sector(0, 10**300)) is not Verdict.PROVED


@pytest.mark.slow
def test_values_beyond_the_doubles_are_no_obstacle():
    found = nonlinearity_bounds("x*((abs(sin(x)) * x**3))")
    assert found.sector.upper > 1e300  # x^3 |sin x| grows without bound
    assert "sector" in str(found)
    assert found.to_dict()["evidence"] == "certified"
    assert violation("x*((abs(sin(x)) * x**3))", Sector(-INF, 10**200)) is not None
    assert nonlinearity_bounds("exp(800*x) - 1", on=(0, 1)).sector.upper == INF  # e^800 - 1, rounded up to a double


def test_continuity_that_cannot_be_decided_is_said():
    found = nonlinearity_bounds("where(tanh(x) > 0.5, 2*x, x)")
    assert found.slope_upper is None
    assert found.sector == Sector(1, 2)
    assert "continuity" in found.notes[0]


def test_a_slope_without_bounds_leaves_the_sector():
    found = nonlinearity_bounds("abs(sin(x + x**3))**0.5 * x", on=(-1, 1.5))  # a vertical tangent where x + x^3 = pi
    assert found.slope_upper is None
    assert "could not be enclosed near sigma = 1.2391" in found.notes[0]
    assert found.sector.upper == pytest.approx(1)


def test_documents_and_sentences():
    found = nonlinearity_bounds("x/(1 + x**2)", on=(Fraction(-1, 3), 4))
    document = found.to_dict()
    assert document["on"][0] == {"exact": "-1/3", "double": -1 / 3}
    assert document["sector_upper"]["inner"] == {"exact": "1", "double": 1.0}
    assert document["slope_lower"]["attained"] is True
    assert "[1/17, 1]" in str(found)
    assert "certified" in str(found)


@pytest.mark.slow
def test_when_the_time_is_over_the_bounds_hold_and_are_said_to_be_the_best_so_far(monkeypatch):
    text = "sigma*(1 + log(2 + sin(1/(sigma**2 + 0.01))))"
    whole = nonlinearity_bounds(text)
    looks = iter(range(10**9))
    monkeypatch.setattr(search, "time", SimpleNamespace(monotonic=lambda: next(looks)))  # a second for every look
    monkeypatch.setattr(bounds, "time", SimpleNamespace(monotonic=lambda: 0))
    for seconds in (1, 60):
        found = nonlinearity_bounds(text, seconds=seconds)
        assert "the time allowed ended the search (LURE-I007)" in found.notes[-1]
        assert found.sector_lower.outer <= whole.sector_lower.outer
        assert found.sector_upper.outer >= whole.sector_upper.outer
        assert found.sector_upper.gap > whole.sector_upper.gap
    assert nonlinearity_bounds(text, seconds=10**9) == whole
    for wrong in (0, -1, math.inf, math.nan, True, "1"):
        with pytest.raises(InputError, match=r"^seconds is .*; give a positive number of seconds"):
            nonlinearity_bounds("sin(sigma)", seconds=wrong)


def test_where_no_slope_was_looked_at_in_time_none_is_shown(monkeypatch):
    # max(sin, sin) is sin: its chords on [-1, 1] are from sin(1) to 1
    looks = iter(range(10**9))
    monkeypatch.setattr(search, "time", SimpleNamespace(monotonic=lambda: next(looks)))  # a second for every look
    monkeypatch.setattr(bounds, "time", SimpleNamespace(monotonic=lambda: 0))
    found = nonlinearity_bounds("max(sin(x), sin(x))", on=(-1, 1), seconds=1)
    assert (found.slope_lower, found.slope_upper) == (None, None)
    assert "no slope bounds: the time allowed was over before a slope was looked at" in found.notes
    assert found.sector_lower.outer <= math.sin(1)
    assert found.sector_upper.outer >= 1
