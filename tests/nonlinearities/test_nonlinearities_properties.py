"""lure.nonlinearities: what is known of a nonlinearity, what is only declared, and nonlinearities from tables."""

import math
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lure import AssumptionError, InputError, Sector, SlopeBounds
from lure.classes import NonlinearityClass
from lure.nonlinearities import (
    LAW_KINDS,
    Cubic,
    DeadZone,
    ExpressionNonlinearity,
    LeakyReLU,
    PiecewiseLinear,
    Provenance,
    Quantiser,
    ReLU,
    Saturation,
    Tanh,
    check_declared,
    nonlinearity_class,
    nonlinearity_from_table,
    properties,
    shifted_nonlinearity,
)
from lure.rod import NormalCompliance

LIBRARY = [
    Saturation(gain=2, limit=3, lower_limit=-1),
    DeadZone(width=2, gain=3),
    ReLU(gain=2),
    LeakyReLU(negative_slope=-1, positive_slope=3),
    PiecewiseLinear([(-1, -3), (0, 0), (2, 1)], left_slope=1, right_slope=0),
    Cubic(linear=-2, cubic=3),
    Cubic(linear=2, cubic=-3),
    Tanh(scale=Fraction(1, 100), gain=4),
    Quantiser(step=Fraction(1, 3)),
    NormalCompliance(3),
]


UNIT = Sector(0, 1)


@dataclass(frozen=True)
class Arctangent:
    """A user's nonlinearity, with what its user says of it."""

    sector: Sector = UNIT
    slope_bounds: SlopeBounds | None = None
    odd: bool = False
    offset: float = 0.0

    def __call__(self, sigma):
        return np.arctan(np.asarray(sigma, dtype=float)) + self.offset


class Minimal:
    """The least the protocol asks for."""

    sector = Sector(0, 2)

    def __call__(self, sigma):
        return np.asarray(sigma, dtype=float)


# Provenance.


@pytest.mark.parametrize("nonlinearity", LIBRARY, ids=str)
def test_everything_about_a_law_of_the_library_is_checked(nonlinearity):
    known = properties(nonlinearity)
    for name in ("sector", "slope_bounds", "odd", "regularity"):
        found = getattr(known, name)
        assert found.provenance is Provenance.CHECKED
        assert found.value == getattr(nonlinearity, name)
        assert found.how


def test_what_a_user_says_is_declared_and_what_is_not_said_is_not_known():
    said = properties(Arctangent(slope_bounds=SlopeBounds(0, 1), odd=True))
    assert {p.provenance for p in (said.sector, said.slope_bounds, said.odd, said.regularity)} == {Provenance.DECLARED}
    assert said.sector.how == "the word of the nonlinearity's author"
    unsaid = properties(Minimal())
    assert (unsaid.slope_bounds.value, unsaid.odd.value, unsaid.regularity.value) == (None, False, "unknown")
    assert unsaid.odd.how == unsaid.slope_bounds.how == "nothing is declared"


def test_a_class_that_inherits_from_a_law_is_on_its_own_word():
    class Louder(Saturation):
        def __call__(self, sigma):
            return 2 * super().__call__(sigma)

    assert properties(Louder()).sector.provenance is Provenance.DECLARED


def test_passing_the_sample_does_not_make_a_declaration_checked():
    nonlinearity = ExpressionNonlinearity(
        "tanh(3*sigma)", sector=Sector(0, 3), slope_bounds=SlopeBounds(0, 3), odd=True
    )
    check_declared(nonlinearity)
    assert properties(nonlinearity).sector.provenance is Provenance.DECLARED
    assert properties(nonlinearity).regularity.value == "locally Lipschitz"


def test_a_piecewise_linear_formula_is_checked_exactly():
    nonlinearity = ExpressionNonlinearity(
        "min(max(2*sigma, -1), 1)", sector=Sector(0, 2), slope_bounds=SlopeBounds(0, 2), odd=True
    )
    known = properties(nonlinearity)
    assert {p.provenance for p in (known.sector, known.slope_bounds, known.odd)} == {Provenance.CHECKED}
    assert known.sector.how.startswith("the formula is piecewise linear: exact")
    assert str(known.odd).startswith("True (checked: the formula")


# sharp: the slope 2 of the formula against bounds 1e-30 below it, which no sample in floats could tell
@pytest.mark.parametrize(
    ("declared", "message"),
    [
        (
            {"sector": Sector(0, 2 - Fraction(1, 10**30))},
            r"have the sector \[0, 1.9999999999999999\], but phi\(sigma\)/sigma is 2 as sigma -> 0-",
        ),
        ({"sector": Sector(Fraction(1, 10**9), 2)}, "sector .*, but .* is 0 as sigma -> -inf"),
        (
            {"sector": Sector(0, 2), "slope_bounds": SlopeBounds(Fraction(1, 8), 2)},
            r"slope bounds \[0.125, 2\], but the slope is 0 on one of its pieces",
        ),
        (
            {"sector": Sector(0, 2), "odd": True},
            r"is declared odd, but phi\(-2.5\) = -5 and phi\(2.5\) = 3; declare odd = False",
        ),
    ],
)
def test_a_false_word_about_a_piecewise_linear_formula_is_never_used(declared, message):
    nonlinearity = ExpressionNonlinearity("min(max(2*sigma, -5), 3)", **declared)
    for use in (properties, nonlinearity_class):
        with pytest.raises(AssumptionError, match=message):
            use(nonlinearity)


def test_a_shifted_law_keeps_the_standing_of_what_is_shifted():
    user = properties(shifted_nonlinearity(Arctangent(slope_bounds=SlopeBounds(0, 1), odd=True), Fraction(1, 2)))
    assert user.sector.value == Sector(Fraction(-1, 2), Fraction(1, 2))
    assert user.sector.provenance is Provenance.DECLARED
    assert user.sector.how.endswith("; shifted by 0.5")
    assert user.odd.value is True
    library = properties(shifted_nonlinearity(Tanh(), 1))
    assert library.slope_bounds.value == SlopeBounds(-1, 0)
    assert library.slope_bounds.provenance is Provenance.CHECKED


# The class of a nonlinearity.


@pytest.mark.parametrize("nonlinearity", LIBRARY, ids=str)
def test_the_class_of_a_law_is_its_tightest(nonlinearity):
    assert nonlinearity_class(nonlinearity) == NonlinearityClass(
        sector=nonlinearity.sector, slope=nonlinearity.slope_bounds, odd=nonlinearity.odd
    )


def test_a_declared_sector_is_narrowed_to_the_declared_slopes():
    found = nonlinearity_class(Arctangent(sector=Sector(-1, 3), slope_bounds=SlopeBounds(0, 1)))
    assert found == NonlinearityClass(sector=Sector(0, 1), slope=SlopeBounds(0, 1))


def test_declarations_that_exclude_each_other_are_refused():
    with pytest.raises(InputError, match=r"^Sector needs lower < upper; got \[2, 1\]$"):
        nonlinearity_class(Arctangent(sector=Sector(2, 3), slope_bounds=SlopeBounds(0, 1)))


# Sampling.


@pytest.mark.parametrize("nonlinearity", LIBRARY, ids=str)
def test_no_law_of_the_library_is_accused(nonlinearity):
    for options in ({}, {"samples": 10, "scale": 1e-6}):
        assert check_declared(nonlinearity, **options) is None  # it raises where a declaration is broken
    check_declared(nonlinearity, scale=1000)


@pytest.mark.parametrize(
    ("nonlinearity", "message"),
    [
        # arctan(s)/s = 0.95 at s = 0.394; the sample sees the supremum 1, near 0
        (
            Arctangent(sector=Sector(0, 0.95)),
            r"the nonlinearity Arctangent is declared to have the sector \[0, 0.95\], but phi\(sigma\)",
        ),
        (
            Arctangent(sector=Sector(1e-6, 1)),
            r"sector \[1e-06, 1\], but phi\(sigma\)/sigma at sigma = -?1000000000000 is 1.57079632679e-12",
        ),
        (Arctangent(slope_bounds=SlopeBounds(0.01, 1)), "slope bounds .* but the difference quotient to the right of"),
        (Arctangent(offset=0.1), r"has phi\(0\) = 0.1; a nonlinearity must vanish at 0"),
        (Arctangent(offset=math.nan), r"has phi\(0\) = nan"),
        (ExpressionNonlinearity("exp(sigma) - 1", sector=Sector(0, math.inf), odd=True), "is declared odd, but phi"),
        (
            ExpressionNonlinearity("sqrt(sigma)", sector=Sector(0, math.inf)),
            r"'sqrt\(sigma\)' has no value at sigma = -",
        ),
        # the jump at 1000 is off every grid, but a breakpoint
        (
            ExpressionNonlinearity(
                "where(sigma < 1000, sigma, where(sigma < 1000.01, sigma**2, sigma))", sector=Sector(0, 2)
            ),
            r"sector \[0, 2\], but phi\(sigma\)/sigma at sigma = 1000.00899999 is 1000",
        ),
    ],
)
def test_a_false_declaration_is_falsified_by_a_point(nonlinearity, message):
    with pytest.raises(AssumptionError, match=message):
        check_declared(nonlinearity)


# sin(s)/s >= -0.2172336282..., at s = 4.4934: a bound 1e-4 higher is false; 30 samples a decade come within 3e-4 of it
def test_a_sector_between_zero_and_infinity_is_looked_at_too():
    bound = -0.21723362821122166
    check_declared(ExpressionNonlinearity("sin(sigma)", sector=Sector(bound - 1e-9, 1), odd=True), samples=20000)
    with pytest.raises(AssumptionError, match=r"sector .*, but phi\(sigma\)/sigma at sigma = -?4\.4[89]"):
        check_declared(ExpressionNonlinearity("sin(sigma)", sector=Sector(bound + 1e-4, 1)), samples=20000)


@pytest.mark.parametrize("text", ["where(sigma > 0, 1 - exp(-sigma), 0)", "(1000 + tanh(sigma)) - 1000"])
def test_rounding_is_not_taken_for_a_violation_of_a_formula(text):
    nonlinearity = ExpressionNonlinearity(text, sector=Sector(0, 1))
    x = np.logspace(-12, -9, 100)
    assert (nonlinearity(x) / x).max() > 1.00001  # in doubles; the nonlinearity itself is below 1
    check_declared(nonlinearity)


def test_rounding_is_not_taken_for_a_violation_of_a_users_law():
    class Charging:
        sector = Sector(0, 1)
        slope_bounds = SlopeBounds(0, 1)

        def __call__(self, sigma):
            return 1 - np.exp(-np.maximum(np.asarray(sigma, dtype=float), 0))

    x = np.logspace(-12, -9, 100)
    assert (Charging()(x) / x).max() > 1.00001  # in doubles; the nonlinearity itself is below 1
    check_declared(Charging())


# the double next to 1/3 lies below it, and some quotients (x/3)/x are rounded to above that
def test_bounds_that_are_no_doubles_are_compared_exactly():
    check_declared(
        ExpressionNonlinearity("sigma/3", sector=Sector(0, Fraction(1, 3)), slope_bounds=SlopeBounds(0, Fraction(1, 3)))
    )
    with pytest.raises(AssumptionError, match="sector"):
        check_declared(ExpressionNonlinearity("sigma/3", sector=Sector(0, Fraction(1, 3) - Fraction(1, 10**17))))


def test_a_violation_smaller_than_rounding_is_found_in_a_formula():
    # tanh(s)/s comes to 1 - s^2/3 with s = 1e-12: above 1 - 1e-15, below 1
    check_declared(ExpressionNonlinearity("tanh(sigma)", sector=Sector(0, 1), slope_bounds=SlopeBounds(0, 1), odd=True))
    below = 1 - Fraction(1, 10**15)
    with pytest.raises(AssumptionError, match=r"sector \[0, 0.99.*\], but phi\(sigma\)/sigma"):
        check_declared(ExpressionNonlinearity("tanh(sigma)", sector=Sector(0, below)))


@given(level=st.floats(1e-3, 1e3), scale=st.floats(1e-3, 1e3))
def test_the_verdict_on_a_sector_does_not_depend_on_the_units(level, scale):
    class Scaled:
        def __init__(self, factor):
            self.sector = Sector(0, factor * level / scale)

        def __call__(self, sigma):
            return level * np.arctan(np.asarray(sigma, dtype=float) / scale)

    check_declared(Scaled(1.0), scale=scale)
    with pytest.raises(AssumptionError, match="sector"):
        check_declared(Scaled(0.999), scale=scale)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"samples": 9}, "samples is 9; give a whole number of at least 10"),
        ({"samples": 1e3}, "samples is 1000.0"),
        ({"scale": 0}, "scale is 0; give a positive number"),
        ({"scale": math.nan}, "scale is nan"),
    ],
)
def test_settings_of_the_sample_are_checked(options, message):
    with pytest.raises(InputError, match=f"^check_declared: {message}"):
        check_declared(Minimal(), **options)


# Tables.


@pytest.mark.parametrize(
    ("kind", "values", "nonlinearity"),
    [
        ("saturation", {"gain": 2, "limit": Decimal("0.1")}, Saturation(gain=2, limit=Fraction(1, 10))),
        ("Saturation", {"slope": 2, "limit": 3, "lower_limit": 0}, Saturation(gain=2, limit=3, lower_limit=0)),
        ("relay-with-slope", {"gain": 50, "level": 2}, Saturation(gain=50, limit=2)),
        ("dead_zone", {"width": 1, "gain": 3}, DeadZone(width=1, gain=3)),
        ("deadzone", {"width": 1, "slope": 3}, DeadZone(width=1, gain=3)),
        ("cubic", {"cubic": 2}, Cubic(linear=0, cubic=2)),
        ("tanh", {"scale": Fraction(1, 100)}, Tanh(scale=Fraction(1, 100))),
        ("ReLU", {}, ReLU()),
        ("leaky ReLU", {"negative_slope": Decimal("0.01")}, LeakyReLU()),
        ("quantizer", {"step": 1}, Quantiser()),
        (
            "piecewise linear",
            {"points": [[-1, -1], [0, 0], [1, Decimal("0.5")]], "left_slope": 0, "right_slope": 0},
            PiecewiseLinear([(-1, -1), (0, 0), (1, Fraction(1, 2))], left_slope=0, right_slope=0),
        ),
        (
            "expression",
            {"text": "sigma**3", "sector": [0, Decimal("inf")], "slope_bounds": [0, "inf"], "odd": True},
            ExpressionNonlinearity(
                "sigma**3", sector=Sector(0, math.inf), slope_bounds=SlopeBounds(0, math.inf), odd=True
            ),
        ),
    ],
    ids=str,
)
def test_a_table_makes_the_law(kind, values, nonlinearity):
    assert nonlinearity_from_table(kind, values) == nonlinearity


def test_every_kind_is_made_from_what_it_says_it_needs():
    nonlinearity = nonlinearity_from_table("normal compliance", {"stiffness": Decimal("0.1"), "exponent": 2})
    assert nonlinearity.exact_stiffness == Fraction(1, 10)
    assert len(LAW_KINDS) == 12
    for kind in LAW_KINDS:
        if kind not in ("tanh", "relu"):
            with pytest.raises(InputError, match=rf"^the nonlinearity '{kind}' needs |^the ideal relay jumps"):
                nonlinearity_from_table(kind, {})


@pytest.mark.parametrize(
    ("kind", "values", "message"),
    [
        (
            "satuation",
            {},
            "^unknown kind of nonlinearity 'satuation'; did you mean 'saturation'[?] the kinds are saturation, relay",
        ),
        (
            "spring",
            {},
            "^unknown kind of nonlinearity 'spring'; the kinds are .*, piecewise linear, table, normal compliance",
        ),
        (
            "table",
            {"file": "law.csv", "skale": 1},
            "^the nonlinearity 'table' has no key 'skale'; it takes points, left_slope",
        ),
        ("table", {"points": [[0, 0]], "file": "law.csv"}, "^the nonlinearity 'table' has both points and a file"),
        (
            "table",
            {"points": [[0, 0]]},
            "^the nonlinearity 'table' needs left_slope and right_slope, or a file; it takes points,",
        ),
        (3, {}, "^the kind of a nonlinearity is 3; give one of saturation"),
        ("relay", {"level": 1}, "^the ideal relay jumps at sigma = 0"),
        ("ideal relay", {"level": 1}, "^the ideal relay jumps at sigma = 0"),
        ("relay with slope", {"level": 1, "gain": Decimal("inf")}, "^the ideal relay jumps at sigma = 0"),
        (
            "saturation",
            {"gain": 1, "limt": 1},
            "^the nonlinearity 'saturation' has no key 'limt'; did you mean limit[?] it takes gain,",
        ),
        ("saturation", {"gain": 1}, "^the nonlinearity 'saturation' needs limit; it takes gain, limit, lower_limit$"),
        ("saturation", {"gain": "one", "limit": 1}, r"^Saturation\.gain is 'one'; give a number"),
        ("saturation", {"gain": 1, "slope": 1, "limit": 1}, "^the nonlinearity 'saturation' has both slope and gain"),
        ("expression", {"text": "sigma", "sector": 1}, r"^the nonlinearity's sector is 1; give a pair of numbers"),
        ("expression", {"text": "sigma", "sector": [0, "x"]}, r"^sector\[1\] is 'x'; give a number"),
        (
            "expression",
            {"text": 3, "sector": [0, 1]},
            r"^ExpressionNonlinearity\.text is 3; give a formula in sigma as text",
        ),
        ("expression", {"text": "sigma", "sector": [2, 1]}, "^Sector needs lower < upper"),
        (
            "piecewise linear",
            {"points": "0", "left_slope": 0, "right_slope": 0},
            r"^PiecewiseLinear\.points is '0'; give a list",
        ),
    ],
)
def test_a_wrong_table_is_refused_in_a_sentence(kind, values, message):
    with pytest.raises(InputError, match=message):
        nonlinearity_from_table(kind, values)
