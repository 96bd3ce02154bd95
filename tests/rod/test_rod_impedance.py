"""The dashpot against the impedance of the rod: exact multiples of it, its negative, and dampings far from both."""

import json
from fractions import Fraction

import pytest
from depth import rarely

from lure import InputError
from lure.analysis.rod.confirmation import confirmation
from lure.files import parse_system
from lure.rod import Rod, builtin_system, upwind
from lure.rod.file import system_to_toml

# Z = A sqrt(rho E) = 2.5e-5 sqrt(8 * 288e6) = 1.2 N s/m
PAPER = {"youngs_modulus": "288e6", "density": 8, "length": 1, "area": "0.25e-4", "compliance": 1}


@pytest.mark.parametrize(
    ("text", "damping"),
    [
        ("2 Z", "12/5"),
        ("Z", "6/5"),
        ("-Z/3", "-2/5"),
        ("0.5*Z", "3/5"),
        ("1e-3Z", "3/2500"),
        ("2/3 Z", "4/5"),
        ("0 Z", "0"),
    ],
)
def test_a_multiple_of_the_impedance_is_exact(text, damping):
    assert Rod(**PAPER, damping=text).exact["damping"] == Fraction(damping)


def test_an_irrational_impedance_is_the_nearest_double():
    rod = Rod(**PAPER | {"density": 7}, damping="2 Z")  # sqrt(7 * 288e6) is irrational
    assert rod.damping == 2 * rod.impedance
    assert Rod(**PAPER | {"density": 7}, damping="Z").reflection == 0
    with pytest.raises(InputError, match="minus the impedance of the rod"):
        Rod(**PAPER | {"density": 7}, damping="-Z")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("Z Z", "rod.damping is 'Z Z'; give a number or a multiple of the impedance, such as '2 Z'"),
        ("x Z", "a multiple of the impedance"),
        ("Z/0", "a division by zero; give another multiple of Z"),
        ("-Z", "minus the impedance of the rod"),
    ],
)
def test_a_damping_that_is_none_is_refused_in_one_sentence(text, message):
    with pytest.raises(InputError, match=message):
        Rod(**PAPER, damping=text)


def test_files_and_settings_take_multiples_of_the_impedance():
    text = system_to_toml(builtin_system("paper-rod"))
    assert "damping = 0.0002" in text
    system = parse_system(text.replace("damping = 0.0002", 'damping = "2 Z"'), name="rod", source="a file")
    assert system.rod.exact["damping"] == Fraction(12, 5)
    assert parse_system(system_to_toml(system), name="rod", source="a file").rod == system.rod
    with pytest.raises(InputError, match=r"rod\.damping is 'twice Z'; give a number or a multiple"):
        parse_system(text.replace("damping = 0.0002", 'damping = "twice Z"'), name="rod", source="a file")
    with pytest.raises(InputError, match=r"rod\.area is '2 Z'; give a number"):
        parse_system(text.replace("area = 0.000025", 'area = "2 Z"'), name="rod", source="a file")


# -1.19999999999999999 is -Z (1 - 8e-18): its double is that of -Z, so that k + Z is 0 in doubles and a = 2.4e17
@pytest.mark.slow
@pytest.mark.usefixtures("sketched")
@pytest.mark.parametrize(
    ("damping", "status", "verdict"),
    rarely(
        [("-1.19999999999999999", 11, "REFUTED"), ("-1.1999999999999997", 11, "REFUTED"), ("1e50", 0, "PROVED")],
        ("-1.1999999999999997", 11, "REFUTED"),
    ),
)
def test_reports_near_minus_the_impedance_and_far_from_it(lure, tmp_path, damping, status, verdict):
    found, _, err = lure("report", "paper-rod", "--set", f"rod.damping={damping}", "-o", "out", "-q")
    assert (found, err) == (status, "")
    data = json.loads((tmp_path / "out" / "report.json").read_text("utf-8"))
    assert data["conclusion"]["verdict"] == verdict


@pytest.mark.parametrize("damping", ["1e-300", "-1e-200"])
def test_a_damping_beyond_what_can_be_drawn_is_refused(lure, damping):
    status, _, err = lure("report", "paper-rod", "--set", f"rod.damping={damping}", "-q")
    assert status == 2
    assert "give a damping of at least 1e-150 times the impedance, or 0" in err


def test_a_gap_of_zero_stays_zero():
    assert Rod(**PAPER, damping="2 Z", gap=0).gap == 0


def test_a_motion_that_doubles_cannot_follow_is_not_held_against_a_proof():
    system = builtin_system("paper-rod")
    for damping, word in (("-1.1999999999", "2.4e"), ("1e20", "8.3e+19 times the impedance")):
        rod = system.rod.replace(damping=damping)
        found = confirmation(upwind(rod, 5), system.scenario, system.until, "not simulated")
        assert found.contradictions == ()
        assert "the exact motion was not computed" in found.rod_skipped
        assert word in found.rod_skipped
