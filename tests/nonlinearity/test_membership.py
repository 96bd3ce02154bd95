"""Whether a given nonlinearity belongs to a class: checked, declared or violated, with its regularity and zeros."""

import math
from fractions import Fraction

import flint
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lure import as_plant
from lure.analysis import analyse, certify
from lure.analysis.certificates import codes
from lure.analysis.nonlinearity.membership import Status, examined, membership
from lure.analysis.verdict import Verdict
from lure.classes import NonlinearityClass, Sector, SlopeBounds
from lure.errors import AssumptionError, InputError
from lure.nonlinearities import (
    Cubic,
    DeadZone,
    ExpressionNonlinearity,
    LeakyReLU,
    PiecewiseLinear,
    Quantiser,
    ReLU,
    Saturation,
    Tanh,
    check_declared,
    nonlinearity_class,
    shifted_nonlinearity,
)
from lure.nonlinearities.base import NormalCompliance

LIBRARY = [
    Saturation(gain=2, limit=1),
    Saturation(gain=1, limit=1, lower_limit=-3),
    DeadZone(width=1, gain=2),
    Tanh(scale=Fraction(1, 5)),
    Cubic(linear=1, cubic=2),
    ReLU(gain=3),
    LeakyReLU(),
    Quantiser(step=Fraction(1, 3)),
    PiecewiseLinear([(-1, -3), (2, 6), (4, 7)], left_slope=0, right_slope=Fraction(1, 2)),
    NormalCompliance(stiffness=4),
    NormalCompliance(stiffness=4, exponent=1.5),
    shifted_nonlinearity(Tanh(), Fraction(1, 2)),
    shifted_nonlinearity(Quantiser(step=1), Fraction(1, 2)),
]
WIDE = Sector(-math.inf, math.inf)


def formula(text, sector=WIDE, **declared):
    return ExpressionNonlinearity(text, sector=sector, **declared)


def status_of(found, name):
    return next(known for known in found.properties if known.name == name).status


@pytest.mark.parametrize("nonlinearity", LIBRARY, ids=str)
def test_a_library_nonlinearity_is_a_checked_member_of_its_own_class(nonlinearity):
    assert membership(nonlinearity, nonlinearity_class(nonlinearity)).status is Status.CHECKED


@pytest.mark.parametrize("nonlinearity", LIBRARY, ids=str)
def test_a_library_nonlinearity_is_no_member_of_a_narrower_sector(nonlinearity):
    # every sector above is the tightest, so that half of its finite width is too little
    low, high = nonlinearity.sector.lower, nonlinearity.sector.upper
    narrow = Sector(low, low + (high - low) / 2) if math.isfinite(high) else Sector(low, low + 100)
    found = membership(nonlinearity, NonlinearityClass(sector=narrow))
    assert found.status is Status.VIOLATED
    (x,) = found.violated.points
    assert float(nonlinearity(float(x))) / float(x) == pytest.approx(float(found.violated.value), rel=1e-6)
    assert found.violated.value > narrow.upper


# the peak of the formula is sigma = 0.777 exactly, where phi(sigma)/sigma = 2 + 7
def test_a_narrow_peak_beyond_the_declared_sector_is_found_with_point_value_and_certified_bound():
    nonlinearity = formula("sigma*(2+7*exp(-((sigma-0.777)/0.0001)**2))", Sector(0, 3))
    known = membership(nonlinearity, NonlinearityClass(sector=Sector(0, 3))).violated
    assert known.name == "sector"
    assert float(known.points[0]) == pytest.approx(0.777, abs=1e-4)
    assert 3 < known.value <= 9 <= known.certified < 9.0001
    assert "0.77" in known.how
    assert "certified bound is at most 9" in known.how


@pytest.mark.slow
def test_a_formula_inside_its_declared_class_is_checked_and_one_beyond_the_effort_stays_declared():
    smooth = NonlinearityClass(sector=Sector(0, 5), slope=SlopeBounds(0, 5), odd=True)
    assert membership(formula("tanh(sigma/0.2)"), smooth).status is Status.CHECKED
    wild = formula("sigma*(1+log(2+sin(1/(sigma**2+0.00001))))")
    assert membership(wild, NonlinearityClass(sector=Sector(0, 3))).status is Status.DECLARED
    bounded = formula("sigma*(1+0.5*sin(1/(sigma**2+0.00001)))")  # as wild, and bounded by its form
    assert membership(bounded, NonlinearityClass(sector=Sector(0, 2))).status is Status.CHECKED


def test_a_function_of_the_users_is_declared():
    class Mine:
        sector = Sector(0, 1)

        def __call__(self, sigma):
            return np.tanh(sigma)

    found = membership(Mine(), NonlinearityClass(sector=Sector(0, 1)))
    assert found.status is Status.DECLARED
    assert {known.name for known in found.declared} == {"sector", "time-invariance"}
    assert (found.regularity, found.regularity_property.status, found.zeros) == (
        "locally Lipschitz",
        Status.DECLARED,
        None,
    )


@pytest.mark.parametrize(
    ("nonlinearity", "regularity", "status"),
    [
        (Saturation(), "locally Lipschitz", Status.CHECKED),
        (Quantiser(), "none", Status.CHECKED),
        (NormalCompliance(stiffness=1, exponent=0.5), "continuous", Status.CHECKED),
        (formula("sigma/(1+sigma**2)"), "locally Lipschitz", Status.CHECKED),
        (formula("sqrt(abs(sigma))"), "continuous", Status.CHECKED),
        (formula("sigma/(sigma**2+sigma+1)"), "locally Lipschitz", Status.CHECKED),  # by its certified slopes
        (formula("where(sigma > 1, 2*sigma, sigma)"), "none", Status.CHECKED),  # 1 below 1, 2 above
        (formula("where(sigma > 1, 2*sigma, sigma)", locally_lipschitz=True), "none", Status.VIOLATED),
        (formula("where(sigma > 0, sqrt(sigma), sigma)"), "continuous", Status.CHECKED),
        (formula("where(sigma > 1, sigma**2, sigma)"), "locally Lipschitz", Status.CHECKED),  # both 1 at 1
    ],
    ids=str,
)
def test_regularity_is_what_can_be_shown(nonlinearity, regularity, status):
    found = membership(nonlinearity, NonlinearityClass(sector=WIDE))
    assert (found.regularity, found.regularity_property.status) == (regularity, status)


@pytest.mark.parametrize(
    ("nonlinearity", "zeros"),
    [
        (Saturation(), "{0}"),
        (DeadZone(width=Fraction(1, 2)), "[-0.5, 0.5]"),
        (Quantiser(step=1), "(-0.5, 0.5)"),
        (ReLU(), "(-inf, 0]"),
        (NormalCompliance(stiffness=1, exponent=2), "(-inf, 0]"),
        (Tanh(), "{0}"),
        (Cubic(linear=-1, cubic=1), "{-1} and {0} and {1}"),  # sigma^3 - sigma
        (PiecewiseLinear([(0, 0), (1, 1), (2, 0)], left_slope=1, right_slope=-1), "{0} and {2}"),
        (formula("tanh(3*sigma) + sigma/(1+abs(sigma))"), "{0}"),
        (formula("sigma*exp(-sigma**2)"), "{0}"),
        (formula("sigma*(sigma-2)**2"), "{0} and {2}"),
        (formula("where(sigma > 1, sigma, 0)"), "(-inf, 1]"),
        (formula("where(sigma >= 1, sigma, 0)"), None),  # not closed
        (formula("sin(sigma)"), None),
    ],
    ids=str,
)
def test_zeros_are_exact(nonlinearity, zeros):
    found = membership(nonlinearity, NonlinearityClass(sector=WIDE)).zeros
    assert (found if found is None else str(found)) == zeros
    assert found is None or found.only_zero is (zeros == "{0}")


def test_oddness_is_checked_read_off_or_refuted_at_a_point():
    odd = NonlinearityClass(sector=WIDE, odd=True)
    assert status_of(membership(formula("sigma**3*exp(-abs(sigma))"), odd), "odd") is Status.CHECKED
    known = membership(formula("sigma + 0.001*sigma**2"), odd).violated
    assert (known.name, known.value) == ("odd", Fraction(2, 1000) * known.points[0] ** 2)
    assert membership(ReLU(), odd).violated.name == "odd"


def test_a_theorem_may_not_be_used_where_nothing_is_known_of_the_regularity():
    found = membership(formula("where(sigma > exp(1), 2*sigma, sigma)"), NonlinearityClass(sector=WIDE))
    assert found.regularity == "unknown"
    assert found.regular("continuous") is Status.VIOLATED
    assert found.regular("none") is Status.CHECKED
    assert membership(Saturation(), NonlinearityClass(sector=WIDE)).regular("locally Lipschitz") is Status.CHECKED


def test_a_formula_without_a_value_somewhere_is_refused():
    with pytest.raises(InputError, match="at sigma = 1"):
        membership(formula("sigma/(sigma-1)"), NonlinearityClass(sector=WIDE))


def test_an_examined_formula_without_a_declared_sector_carries_the_certified_class():
    # x/(1 + x^2): chords 1/(1 + x^2) in (0, 1], slopes (1 - x^2)/(1 + x^2)^2 least -1/8 at the root of 3
    found = examined(ExpressionNonlinearity("sigma/(1+sigma**2)"))
    assert found.nonlinearity_class.sector == Sector(0, 1)
    assert found.nonlinearity_class.odd
    assert -0.1250001 < found.nonlinearity_class.slope.lower <= Fraction(-1, 8)
    assert found.membership.status is Status.CHECKED
    assert examined(
        ExpressionNonlinearity("min(max(2*sigma, -1), 1)")
    ).nonlinearity_class == NonlinearityClass.slope_restricted(0, 2, odd=True)


@pytest.mark.slow_for("sigma*(1+log(2+sin(1/(sigma**2+0.00001))))-s")
@pytest.mark.parametrize(
    ("nonlinearity", "message"),
    [
        (
            formula("sigma*(2+7*exp(-((sigma-0.777)/0.0001)**2))", Sector(0, 3)),
            r"sector \[0, 3\], but phi\(sigma\)/sigma = .* > 3 .* at sigma = 0.77.* certified bound is at most 9",
        ),
        (formula("min(max(2*sigma, -1), 1)", Sector(0, 1)), r"sector \[0, 1\], but phi\(sigma\)/sigma = 2 > 1"),
        (formula("sigma + sigma**2/1e6", odd=True), r"property odd, but phi\(sigma\) \+ phi\(-sigma\) = 2e-06"),
        (
            formula("where(sigma > 1, 2*sigma, sigma)", locally_lipschitz=True),
            "locally Lipschitz, but phi has a jump at 1",
        ),
        (formula("sigma/(sigma-1)"), "at sigma = 1"),
        # too wild for the search: a sample finds 1 + ln 3 where 1/(sigma^2 + 1e-5) = pi/2, confirmed in balls
        (formula("sigma*(1+log(2+sin(1/(sigma**2+0.00001))))", Sector(0, 1.4)), "sector \\[0, 1.4"),
        (
            ExpressionNonlinearity("sigma*(1+log(2+sin(1/(sigma**2+0.00001))))"),
            "declares no sector, and none could be certified",
        ),
        (ExpressionNonlinearity("3*sigma"), "straight line; a linear gain belongs into the block"),
    ],
    ids=str,
)
def test_what_is_declared_and_false_is_an_error_of_the_input(nonlinearity, message):
    with pytest.raises(InputError, match=message):
        examined(nonlinearity)


# Random formulas sigma*f(sigma), with branches, kinks, divisions, and conditions that may have no value.
NUMBERS = st.sampled_from(["0", "1", "2", "0.5", "-1", "0.1", "3", "1/3"])
PARTS = st.recursive(
    st.one_of(st.just("sigma"), NUMBERS),
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from("+-*/"), inner).map(lambda p: f"({p[0]} {p[1]} {p[2]})"),
        st.tuples(st.sampled_from(["abs", "tanh", "sign", "atan", "sin", "exp", "sqrt", "log"]), inner).map(
            lambda p: f"{p[0]}({p[1]})"
        ),
        st.tuples(st.sampled_from(["min", "max"]), inner, inner).map(lambda p: f"{p[0]}({p[1]}, {p[2]})"),
        st.tuples(inner, st.sampled_from(["**2", "**3", "**-1", "**0.5", "**0"])).map("".join),
        st.tuples(inner, st.sampled_from(["<", ">=", "==", "!="]), inner, inner, inner).map(
            lambda p: f"where({p[0]} {p[1]} {p[2]}, {p[3]}, {p[4]})"
        ),
    ),
    max_leaves=5,
)


def without_values(nonlinearity):
    """Points at which the exact value fails with a division by zero: the cuts, and simple fractions."""
    points = {Fraction(n, d) for n in range(-6, 7) for d in (1, 2, 3, 10)} | set(nonlinearity.breakpoints)
    for point in points:
        try:
            nonlinearity.expression.exact(sigma=point)
        except InputError as error:
            if "divides by zero" in str(error):
                yield point


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(PARTS)
def test_what_is_checked_of_a_random_formula_no_sample_contradicts(part):
    try:
        found = examined(ExpressionNonlinearity(f"sigma*({part})"))
    except (InputError, AssumptionError):
        return  # no value somewhere, no value 0 at 0, or nothing certified
    known, nonlinearity = found.membership, found.nonlinearity
    assert known.status is Status.CHECKED
    assert not list(without_values(nonlinearity))
    check_declared(nonlinearity)  # a sample over 24 decades and around the cuts, confirmed in balls
    if known.regularity == "locally Lipschitz":
        for cut in nonlinearity.breakpoints:  # no jump: the values on both sides meet
            near = [
                nonlinearity.expression.ball(sigma=flint.arb(float(cut)) + side * flint.arb(2) ** -200)
                for side in (-1, 1)
            ]
            assert not abs(near[0] - near[1]) > 1e-12
    if known.zeros is not None and known.zeros.only_zero:
        for place in (-37, -1, -0.25, 0.125, 0.5, 1, 3):
            assert not nonlinearity.expression.ball(sigma=flint.arb(place)).is_zero()


def test_a_class_asked_about_must_contain_a_formula_that_declares_nothing():
    nonlinearity = ExpressionNonlinearity("3*tanh(sigma)")
    assert examined(nonlinearity, NonlinearityClass(sector=Sector(0, 4))).membership.status is Status.CHECKED
    with pytest.raises(
        InputError, match=r"asked about in a class with the sector \[0, 2\].* give a class that contains it"
    ):
        examined(nonlinearity, NonlinearityClass(sector=Sector(0, 2)))


class Fivefold(ExpressionNonlinearity):
    def __call__(self, sigma):
        return 5 * sigma


class Jumping:
    sector = Sector(0, 2)
    regularity = "piecewise constant, discontinuous"

    def __call__(self, sigma):
        return np.round(sigma)


class Silent:
    sector = Sector(0, 2)

    def __call__(self, sigma):
        return 1.5 * np.tanh(sigma)


def test_a_class_derived_from_a_formula_is_not_judged_by_the_formula():
    found = membership(Fivefold("tanh(sigma)", sector=Sector(0, 6)), NonlinearityClass(sector=Sector(0, 6)))
    assert found.status is Status.DECLARED
    assert found.zeros is None
    assert (
        membership(type("Own", (Saturation,), {"__call__": lambda _, x: 0 * x})(), found.nonlinearity_class).zeros
        is None
    )


def test_a_law_that_says_it_is_discontinuous_is_not_taken_to_be_locally_lipschitz():
    assert analyse("1/(s+1)", Jumping()).verdict is Verdict.INCONCLUSIVE
    assert certify("1/(s+1)", Jumping()).code is codes.NOT_LIPSCHITZ
    # without a direct term the circle criterion in discrete time holds for nonlinearities of any regularity
    assert analyse(as_plant("0.2/(z-0.5)", dt=1), Jumping()).verdict is Verdict.PROVED


def test_what_nobody_declared_is_not_called_declared():
    said = analyse("1/(s+1)", Silent()).conclusion.headline
    assert said.endswith(
        "if phi lies in the sector you declare and is locally Lipschitz, of which nothing is declared."
    )
