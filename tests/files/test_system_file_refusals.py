"""One sentence, with the fix, for whatever is wrong in a system file: a key, a value, a table."""

import re

import pytest
from system_files import ROD, refused, with_line

from lure.files.kinds import nearest_key
from lure.rod.file import ROD_FILE
from lure.rod.parameters import PARAMETERS

# unknown and missing keys


@pytest.mark.parametrize(
    ("key", "meant"),
    [
        ("rod.dampng", "rod.damping"),
        ("rod.Damping", "rod.damping"),
        ("rod.E", "rod.youngs_modulus"),
        ("rod.eps", "rod.compliance"),
        ("discretization", "discretisation"),
        ("discretization.cells", "discretisation.cells"),
        ("damping", "rod.damping"),
        ("rod.cells", "discretisation.cells"),
        ("rod.until", "simulation.until"),
        ("N", "discretisation.cells"),
        ("cell", "discretisation.cells"),
        ("rods", "rod"),
        ("rod.colour", None),
    ],
)
def test_a_misspelt_key_is_recognised(key, meant):
    assert nearest_key(key, ROD_FILE) == meant


def test_an_unknown_key_names_its_table_what_was_meant_and_what_is_allowed():
    assert refused(ROD.replace("damping", "dampng")) == (
        "unknown key rod.dampng; did you mean rod.damping? [rod] takes youngs_modulus, density, length, area, damping, "
        "compliance, exponent, gap"
    )
    assert refused(ROD + "[force2]\ng = 1").startswith("unknown key force2; did you mean force? a system has the key")


@pytest.mark.parametrize("key", ["youngs_modulus", "density", "length", "area", "damping", "compliance"])
def test_a_missing_key_is_named_with_its_unit(key):
    assert re.fullmatch(rf"rod\.{key} is missing; give .*\[.+\].*", refused(re.sub(rf"(?m)^{key}.*\n", "", ROD)))


def test_an_empty_file_is_told_what_it_needs():
    assert refused("# nothing\r\n").endswith(
        " is empty; `lure init --loop` writes a loop to start from, `lure init` a rod"
    )
    assert refused("rod = {}").startswith(
        "rod.youngs_modulus is missing; give E, Young's modulus [Pa] (and 5 more to mend)"
    )


def test_keys_of_a_plant_without_its_table_are_told_the_table():
    told = "unknown key num; did you mean plant.num? a system has the keys name and title and the tables [plant], "
    assert refused("num = [1]\nden = [1, 1]").startswith(told)
    assert refused("length = 1\narea = 1").startswith("unknown key length; did you mean rod.length? a system")


def test_further_problems_are_counted():
    text = with_line("cells = 0", "discretisation") + "[force]\ng = nan\n"
    assert refused(text).endswith("give a whole number from 1 to 10000000 (and 1 more to mend)")


# values


@pytest.mark.parametrize("key", ["youngs_modulus", "density", "length", "area", "compliance", "exponent"])
@pytest.mark.parametrize("value", ["0", "-1", "-0.0", "-1e-300"])
def test_what_must_be_positive_is_refused_at_zero_and_below(key, value):
    assert re.fullmatch(rf"rod\.{key} is -?[\de.-]+; give a positive number", refused(with_line(f"{key} = {value}")))


@pytest.mark.parametrize("key", PARAMETERS)
@pytest.mark.parametrize(
    ("value", "sentence"),
    [
        ("nan", "rod.{} is NaN; give a finite number"),
        ("-inf", "rod.{} is -Infinity; give a finite number"),
        ('"8"', "rod.{} is '8'; give a number"),
        ("true", "rod.{} is true; give a number"),
        ("[1]", "rod.{} is an array of 1; give a number, or an interval [low, high]"),
        ("{ a = 1 }", "rod.{} is a table; give a number"),
        ("1979-05-27", "rod.{} is 1979-05-27; give a number"),
        ("1e401", "rod.{} is 1E+401, outside the range of double precision; rescale the units"),
        ("1e999999999", "rod.{} is 1E+999999999, outside the range of double precision; rescale the units"),
        ("1e-999999999", "rod.{} is 1E-999999999, outside the range of double precision; rescale the units"),
        ("1e99999999999999999999", "rod.{} is '1e99999999999999999999'; give a number"),
        ("1." + 2000 * "3", "rod.{} has more than 1000 digits; give fewer"),
    ],
)
def test_what_is_not_a_finite_number_is_refused_by_name(key, value, sentence):
    if key in ("gap", "exponent"):  # these have no intervals
        sentence = sentence.replace("an array of 1; give a number, or an interval [low, high]", "[1]; give a number")
    assert refused(with_line(f"{key} = {value}")) == sentence.format(key)


@pytest.mark.parametrize("value", [4000 * "9", "0x" + 20000 * "f", "1" + 400 * "0"])
def test_a_whole_number_of_any_length_is_refused_without_being_printed(value):
    assert "outside the range of double precision" in refused(with_line(f"length = {value}"))
    assert "more than 18 digits" in refused(with_line(f"cells = {value}", "discretisation"))


@pytest.mark.parametrize("table", ["discretisation", "simulation"])
@pytest.mark.parametrize(
    ("value", "sentence"),
    [
        ("0", "is 0; give a whole number from 1 to 10000000"),
        ("-5", "is -5; give a whole number from 1 to 10000000"),
        ("10.0", "is 10.0; give a whole number"),
        ("true", "is true; give a whole number"),
        ('"10"', "is '10'; give a whole number"),
        (
            "1000000000",
            "is 1000000000 (it would need about 100 GB for its matrices); give a whole number from 1 to 10000000",
        ),
    ],
)
def test_a_number_of_cells_is_a_whole_number_that_fits_in_memory(table, value, sentence):
    assert refused(with_line(f"cells = {value}", table)) == f"{table}.cells {sentence}"


@pytest.mark.parametrize(
    ("line", "table", "sentence"),
    [
        ("damping = -1.2", "rod", "rod.damping is -1.2, minus the impedance of the rod: "),  # Z = 0.25e-4 sqrt(8*288e6)
        ("form = 'printed'", "discretisation", 'discretisation.form is \'printed\'; give "corrected" or "as-printed"'),
        ("form = 1", "discretisation", "discretisation.form is 1; give "),
        ("until = 0", "simulation", "simulation.until is 0; give a positive number"),
        ("until = 'long'", "simulation", "simulation.until is 'long'; give a number"),
        ("g = true", "force", "force.g is true; give a number or a formula in quotes"),
        ("g = nan", "force", "force.g: the number must be finite but is NaN"),
        ("g = '2*sin(4*x)'", "force", "force.g: unknown name 'x' "),
        ("f = '2*'", "force", "force.f: expected a number, a name or '(' but found "),
        ("u1 = 't'", "initial", "initial.u1: unknown name 't' "),
        ("u0 = '1/x'", "initial", "initial.u0 is not a finite number at x = 0; change the formula"),
        ("u0 = 'sqrt(x)'", "initial", "the derivative of initial.u0 is not a finite number at x = 0; "),
        ("u1 = 'log(x - 0.5)'", "initial", "initial.u1 is not a finite number at x = 0; "),
        ("g = 'sqrt(t - 1e-3)'", "force", "force.g is not a finite number at t = 0; "),
        ("f = '1/(x - 1)'", "force", "force.f is not a finite number at t = 0; "),
    ],
)
def test_a_wrong_value_is_named_with_the_fix(line, table, sentence):
    assert refused(with_line(line, table)).startswith(sentence)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("rod = 5", "rod is 5; give a table that starts with the line [rod]"),
        ("[[rod]]\nlength = 1", "rod is an array; give a table that starts with the line [rod]"),
        (f"force = 'x'\n{ROD}", "force is 'x'; give a table that starts with the line [force]"),
        (f"name = 3\n{ROD}", "name is 3; give a text in quotes"),
        (f"name = ' '\n{ROD}", "name is ' '; give one line of 1 to 100 printable characters"),
        (f"name = '{101 * 'n'}'\n{ROD}", "name is 'nnn"),
    ],
)
def test_a_wrong_table_or_name_is_refused(text, sentence):
    assert refused(text).startswith(sentence)


def test_a_setting_cannot_be_put_into_what_is_no_table():
    assert refused("rod = 5", "rod.length=1").startswith("rod is 5; give a table")
