"""lure.rod.parameters: derived constants, exactness, the reflection near k = Z and k = -Z, and refusals."""

import copy
import dataclasses
import math
import pickle
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from reference import Exact, at_high_precision, decades, ratios, real, relative_error, rods, with_damping

from lure import InputError
from lure.rod import Rod
from lure.rod.parameters import PARAMETERS
from lure.rod.systems import paper_rod, rod_from_exact

PAPER = {
    "youngs_modulus": 288e6,
    "density": 8,
    "length": 1,
    "area": 0.25e-4,
    "damping": 2e-4,
    "compliance": 1,
    "exponent": 1,
    "gap": 0.02,
}
EPS = 2.0**-52


def paper(**changes):
    return Rod(**{**PAPER, **changes})


# c = sqrt(288e6/8) = sqrt(36e6) = 6000, Z = A sqrt(8 * 288e6) = 0.25e-4 * 48000 = 1.2, T = 1/6000, d = 1/48000,
# a = (0.0002 - 1.2)/(0.0002 + 1.2) = -1.1998/1.2002 = -0.99966672.., b = 1/1.2002, rho_0 = A/k = 0.25e-4/2e-4 = 1/8
def test_the_constants_of_the_paper_come_out_exactly():
    rod = paper_rod()
    assert rod.wave_speed == 6000.0
    assert rod.impedance == 1.2
    assert rod.travel_time == 1 / 6000
    assert rod.mobility == 1 / 48000
    assert rod.reflection == pytest.approx(-1.1998 / 1.2002, rel=4 * EPS)
    assert rod.reflection == pytest.approx(-0.99966672, abs=5e-9)
    assert rod.input_gain == pytest.approx(1 / 1.2002, rel=4 * EPS)
    assert rod.residue_at_zero == 0.125


def test_parameters_given_as_doubles_give_the_same_constants_to_rounding():
    names = ("wave_speed", "impedance", "travel_time", "mobility", "reflection", "input_gain", "residue_at_zero")
    for name in names:
        assert getattr(paper(), name) == pytest.approx(getattr(paper_rod(), name), rel=4 * EPS)


@given(rod=rods())
def test_the_constants_are_right_to_a_few_roundings(rod):
    def errors():
        exact = Exact(rod)
        pairs = (
            (rod.wave_speed, exact.c),
            (rod.impedance, exact.Z),
            (rod.travel_time, exact.T),
            (rod.mobility, exact.d),
            (rod.input_gain, exact.b),
            (1 + rod.reflection, 1 + exact.a) if abs(rod.reflection) < 0.5 else (rod.reflection, exact.a),
            (rod.residue_at_zero, exact.d * (1 - exact.a) / (1 + exact.a)),
        )
        return [relative_error(value, ball) for value, ball in pairs]

    assert max(at_high_precision(errors)) < 6 * EPS


@pytest.mark.parametrize("damping", [Fraction(6, 5), Decimal("1.2"), Fraction("1.2")])
def test_a_dashpot_equal_to_the_impedance_reflects_nothing(damping):
    assert rod_from_exact({**paper_rod().exact, "damping": Fraction(damping)}).reflection == 0.0


@given(rod=rods(ratio=0.5))
def test_a_dashpot_equal_to_the_impedance_in_doubles_reflects_nothing(rod):
    parameters = {name: getattr(rod, name) for name in PARAMETERS}
    assert Rod(**{**parameters, "damping": rod.impedance}).reflection == 0.0


@given(
    rod=rods(ratio=0.5),
    distance=st.one_of(decades(-14.9, -1), decades(-14.9, -1).map(lambda value: -value)),
    sign=st.sampled_from([1, -1]),
)
def test_the_reflection_keeps_its_digits_near_the_impedance_of_either_sign(rod, distance, sign):
    # a = (k - Z)/(k + Z) from doubles would keep log10(distance * 2^53) digits only
    rod = with_damping(rod, sign * rod.impedance * (1 + distance))
    for value, name in ((rod.reflection, "a"), (rod.input_gain, "b")):
        assert at_high_precision(lambda value, name: relative_error(value, getattr(Exact(rod), name)), value, name) < (
            8 * EPS
        )


def test_only_the_impedance_itself_or_the_double_nearest_to_it_is_matched():
    Z, unit = Fraction(6, 5), Fraction(1, 2**52)
    assert with_damping(paper_rod(), Z).reflection == 0.0
    assert with_damping(paper_rod(), Fraction(1.2)).reflection == 0.0  # the double, 1.2 - 4e-17
    for sign in (1, -1):
        beside = with_damping(paper_rod(), Z * (1 + sign * unit / 100)).reflection  # a decimal can come closer
        assert beside == pytest.approx(sign * float(unit) / 200, rel=1e-12)
    next_double = with_damping(paper_rod(), Fraction(math.nextafter(1.2, 2))).reflection
    assert 0 < next_double < 1e-15


@given(rod=rods(ratio=1.0), ratio=ratios())
def test_the_reflection_changes_sign_with_the_ratio_of_damping_and_impedance_inverted(rod, ratio):
    # (1/q - 1)/(1/q + 1) = -(q - 1)/(q + 1)
    one, other = (with_damping(rod, q * rod.impedance).reflection for q in (ratio, 1 / ratio))
    assert one == pytest.approx(-other, rel=1e-13, abs=4 * EPS)


@given(rod=rods())
def test_positive_damping_reflects_less_than_it_receives(rod):
    assert -1 < rod.reflection < 1
    assert with_damping(rod, 0).reflection == -1.0
    assume(rod.damping != rod.impedance)
    assert abs(with_damping(rod, -Fraction(rod.damping)).reflection) > 1


@pytest.mark.parametrize("damping", [1e200, 1e-200, -1e200, -1e-200, 1e300])
def test_no_damping_in_range_overflows(damping):
    rod = paper(damping=damping, area=1.0)
    for value in (rod.reflection, rod.input_gain, rod.residue_at_zero):
        assert math.isfinite(value)
    assert abs(rod.reflection) == 1.0  # to the last digit
    assert rod.input_gain == pytest.approx(1 / (damping + rod.impedance))


# a wave through the boundary condition itself: for r2 = 1 and g = 0 it fixes r1 in A E u_x = k u_t,
# with u_t = (r1 + r2)/2 and u_x = (r2 - r1)/(2c); and for r2 = 0, g = 1 it fixes r1 = 2 b
@given(rod=rods())
def test_the_reflection_and_the_input_gain_satisfy_the_condition_at_the_dashpot(rod):
    stiffness = rod.area * rod.youngs_modulus / (2 * rod.wave_speed)
    for incoming, force in ((1.0, 0.0), (0.0, rod.impedance)):
        outgoing = -rod.reflection * incoming + 2 * rod.input_gain * force
        pull, damper = stiffness * (incoming - outgoing), rod.damping * (incoming + outgoing) / 2
        scale = stiffness * 2 + rod.damping + force
        assert pull - damper + force == pytest.approx(0, abs=1e-13 * scale)


def test_decimals_are_kept_beside_the_nearest_doubles():
    rod = paper(damping=Fraction("0.1"), length=0.1)
    assert rod.exact["damping"] == Fraction(1, 10)
    assert rod.exact["length"] == Fraction(0.1) != Fraction(1, 10)
    assert rod.damping == rod.length == 0.1
    assert set(rod.exact) == set(PARAMETERS)


def test_the_contact_law_keeps_the_exact_compliance():
    nonlinearity = paper(compliance=Fraction(3), exponent=Fraction(3, 2)).nonlinearity
    assert (nonlinearity.exact_stiffness, nonlinearity.exact_exponent) == (Fraction(1, 3), Fraction(3, 2))


def test_rods_are_equal_when_their_exact_parameters_are():
    assert paper_rod() == paper_rod()
    assert hash(paper_rod()) == hash(paper_rod())
    assert paper(damping=0.1) != paper(damping=Fraction("0.1"))  # the same doubles, another rod


def test_rods_can_be_pickled_and_copied_without_loss():
    rod = paper_rod()
    for twin in (pickle.loads(pickle.dumps(rod)), copy.copy(rod), copy.deepcopy(rod)):
        assert twin == rod
        assert dict(twin.exact) == dict(rod.exact)


def test_a_rod_cannot_be_changed():
    rod = paper()
    with pytest.raises(AttributeError):
        rod.damping = 1.0
    with pytest.raises(TypeError):
        rod.exact["damping"] = Fraction(1)


powers = st.integers(-20, 20).map(lambda power: Fraction(2) ** power)


@given(rod=rods(), time=powers, length=powers)
def test_the_constants_follow_the_units(rod, time, length):
    # E [kg/(m s^2)], rho [kg/m^3], L [m], A [m^2], k [kg/s] in units 1/length and 1/time times as long
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
    assert scaled.reflection == rod.reflection
    assert scaled.wave_speed == pytest.approx(rod.wave_speed * float(length / time), rel=4 * EPS)
    assert scaled.impedance == pytest.approx(rod.impedance / float(time), rel=4 * EPS)
    assert scaled.travel_time == pytest.approx(rod.travel_time * float(time), rel=4 * EPS)
    assert scaled.residue_at_zero == pytest.approx(rod.residue_at_zero * float(length**2 * time), rel=4 * EPS)


@pytest.mark.parametrize("name", PARAMETERS)
@pytest.mark.parametrize(
    ("value", "message"),
    [
        (math.nan, "is nan; give a finite number"),
        (math.inf, "is inf; give a finite number"),
        (-math.inf, "is -inf; give a finite number"),
        (True, "is True; give a number"),
        ("one", "is 'one'; give a number such as 2, -0.5, 1e-3 or 2/3"),
        ("1e999999999", "has more than 1000 digits or an exponent beyond 400"),
        ("1/0", "is '1/0', a division by zero"),
        (None, "is None; give a number"),
        (10**400, "is outside the range of double precision"),
        (Fraction(1, 10**400), "is outside the range of double precision"),
    ],
)
def test_a_parameter_that_is_not_a_finite_number_is_refused_by_name(name, value, message):
    with pytest.raises(InputError, match=rf"^rod\.{name} {message}"):
        paper(**{name: value})


def test_a_parameter_may_be_the_text_of_a_number_which_is_exact():
    rod = paper(length="1/3", area=" 0.25e-4 ", damping="-0.1", gap="2")
    assert [rod.exact[name] for name in ("length", "area", "damping", "gap")] == [
        Fraction(1, 3),
        Fraction(1, 40000),
        Fraction(-1, 10),
        2,
    ]
    assert rod.length == 1 / 3
    with pytest.raises(InputError, match=r"^rod\.length is -1; give a positive number$"):
        paper(length="-1")


@pytest.mark.parametrize("change", [lambda rod, **new: rod.replace(**new), lambda rod, **new: rod.__replace__(**new)])
def test_a_rod_with_one_parameter_changed_keeps_the_others_exactly(change):
    rod = paper(length="1/3", compliance=Fraction(1, 7))
    other = change(rod, damping="0.3")
    assert other.exact == {**rod.exact, "damping": Fraction(3, 10)}
    assert other == paper(length=Fraction(1, 3), compliance=Fraction(1, 7), damping=Fraction(3, 10))
    # a rod of doubles is another one
    assert dataclasses.replace(rod, damping=0.3).exact["length"] == Fraction(1 / 3) != Fraction(1, 3)
    assert change(rod) == rod


def test_a_parameter_that_there_is_not_cannot_be_changed():
    with pytest.raises(InputError, match=r"^a rod has no parameter 'k'; it has youngs_modulus, density, .*, gap$"):
        paper().replace(k=1)
    with pytest.raises(InputError, match=r"^rod\.damping is 'much'"):
        paper().replace(damping="much")


@pytest.mark.parametrize("name", ["youngs_modulus", "density", "length", "area", "compliance", "exponent"])
@pytest.mark.parametrize("value", [0, -0.0, -1, -1e-300])
def test_a_parameter_that_must_be_positive_is_refused_otherwise(name, value):
    with pytest.raises(InputError, match=rf"^rod\.{name} is -?[\de-]+; give a positive number$"):
        paper(**{name: value})


@pytest.mark.parametrize(("name", "value"), [("damping", 0), ("damping", -1.0), ("gap", 0), ("gap", -0.5)])
def test_no_damping_negative_damping_and_a_preloaded_gap_are_physics(name, value):
    assert getattr(paper(**{name: value}), name) == value


def test_minus_the_impedance_is_refused():
    with pytest.raises(InputError, match=r"^rod\.damping is -1\.2, minus the impedance of the rod: "):
        with_damping(paper_rod(), Fraction("-1.2"))


def test_beside_minus_the_impedance_the_wave_is_amplified_beyond_measure_but_defined():
    # the double -1.2 is not -Z: the impedance of the doubles is 0.25e-4 * 48000 and irrational digits away
    assert abs(paper(damping=-1.2).reflection) > 1e15


@pytest.mark.parametrize(
    ("changes", "constant"),
    [
        ({"youngs_modulus": 1e300, "density": 1e300, "area": 1e100}, "impedance"),
        ({"youngs_modulus": 1e-300, "density": 1e-300, "area": 1e-100}, "impedance"),
        ({"youngs_modulus": 1e300, "density": 1e-320, "length": 1e-100}, "wave speed"),
        ({"length": 1e300, "youngs_modulus": 1e-100, "density": 1e10}, "travel time"),
        ({"compliance": 1e-310}, "contact stiffness"),
        ({"damping": 1e-308, "area": 1e5}, "residue"),
    ],
)
def test_constants_that_no_double_can_hold_are_refused(changes, constant):
    with pytest.raises(InputError, match=rf"^rod: the {constant} .* comes out as (inf|0) .*; rescale the units$"):
        paper(**changes)


@pytest.mark.parametrize("name", ["youngs_modulus", "density", "length", "area", "damping", "compliance"])
def test_a_missing_parameter_is_an_error(name):
    with pytest.raises(TypeError, match=name):
        Rod(**{key: value for key, value in PAPER.items() if key != name})


def test_numpy_scalars_are_parameters_like_any_other():
    assert paper(length=np.float64(2.0), density=np.int64(8)) == paper(length=2.0)


def test_the_reference_is_the_rod_in_exact_arithmetic():
    # guards the comparison itself: Z^2 = A^2 rho E
    rod = paper(area=0.3)

    def residual():
        Z = Exact(rod).Z
        return abs(Z * Z - real(rod.exact["area"]) ** 2 * real(rod.exact["density"] * rod.exact["youngs_modulus"]))

    assert float(at_high_precision(residual)) < 1e-70
