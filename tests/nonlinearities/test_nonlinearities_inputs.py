"""Nonlinearities as users give them: CSV tables, keys and their spellings, text for numbers, kinds with memory."""

from fractions import Fraction

import control
import numpy as np
import pytest
from refusals import refusal

from lure import Loop, NonlinearityClass, Sector, as_nonlinearity
from lure.analysis import describing_function, nonlinearity_bounds
from lure.analysis.nonlinearity import violation
from lure.analysis.theorems.popov import popov_criterion
from lure.analysis.verdict import Evidence
from lure.classes import SlopeBounds
from lure.errors import AssumptionError, InputError
from lure.files import loop_to_toml, parse_system, read_system
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
    nonlinearity_from_table,
)
from lure.nonlinearities.base import NormalCompliance
from lure.plants.rational import RationalPlant

F = Fraction
PLANT = "[plant]\nnum = [1]\nden = [1, 3, 2, 0]\n"


def nonlinearity_entry(text):
    return parse_system(PLANT + "[nonlinearity]\n" + text, name="loop", source="loop.toml").nonlinearity


# tables from files


@pytest.mark.parametrize(
    "content",
    [
        "-1,-2\n0,0\n1,2\n3,2.5\n",
        "sigma,phi\n-1, -2\n0, 0\n1, 2\n3, 2.5\n",
        "# a measured valve\nsigma [mm];phi [N]\n-1;-2\n0;0\n\n1;2\n3;2,5\n",
        "\ufeff3\t2.5\r\n1\t2\r\n0\t0\r\n-1\t-2\r\n",
        "-1 -2\n0 0\n1 2\n3 2,5\n",
        # the names say which column is which, as read the other way the sector was that of the inverse
        "phi,sigma\n-2,-1\n0,0\n2,1\n2.5,3\n",
        "\N{GREEK SMALL LETTER PHI} [N];\N{GREEK SMALL LETTER SIGMA} [mm]\n2,5;3\n2;1\n0;0\n-2;-1\n",
        "phi [N] sigma [mm]\n-2 -1\n0 0\n2 1\n2.5 3\n",
        "phi(sigma),sigma\n-2,-1\n0,0\n2,1\n2.5,3\n",
        "force,sigma\n-2,-1\n0,0\n2,1\n2.5,3\n",
        "Phi,x\n-2,-1\n0,0\n2,1\n2.5,3\n",
        "# phi [N], sigma [mm]\n-2,-1\n0,0\n2,1\n2.5,3\n",
        "# phi over sigma, measured\n# sigma phi\n-1 -2\n0 0\n1 2\n3 2.5\n",
        "sigma,phi(sigma)\n-1,-2\n0,0\n1,2\n3,2.5\n",
        "x,y\n-1,-2\n0,0\n1,2\n3,2.5\n",
    ],
)
def test_a_table_is_read_from_a_csv_file_beside_the_system(tmp_path, content, monkeypatch):
    (tmp_path / "valve.csv").write_text(content, encoding="utf-8")
    (tmp_path / "servo.toml").write_text(PLANT + "[nonlinearity]\nkind = 'table'\nfile = 'valve.csv'\n")
    monkeypatch.chdir("/")
    system = read_system(tmp_path / "servo.toml")
    # straight on with the slopes of the outermost segments: 2 on the left, (2.5 - 2)/(3 - 1) on the right
    wanted = PiecewiseLinear([(-1, -2), (0, 0), (1, 2), (3, F(5, 2))], left_slope=2, right_slope=F(1, 4))
    assert system.nonlinearity == wanted
    assert PiecewiseLinear.from_csv(tmp_path / "valve.csv") == wanted
    assert nonlinearity_from_table("table", {"file": str(tmp_path / "valve.csv"), "right_slope": 0}).right_slope == 0
    again = parse_system(loop_to_toml(system), name="loop", source="elsewhere")  # the points stand in it
    assert again.nonlinearity == wanted


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "does not exist"),
        ("0,0\n", "has 1 point; a nonlinearity needs at least two"),
        ("0,0\n1,1\n1,2\n", "line 3: sigma is 1 beside 1; give the points in ascending order"),
        ("0,0\n1,1\n0.5,2\n2,2\n", "line 3: sigma is 0.5 beside 1"),
        ("0,1\n1,2\n", r"phi\(0\) = 1; a nonlinearity must vanish at 0"),
        ("0,0\n1,1,1\n", "line 2: '1,1,1' has 3 columns; give two, sigma and phi"),
        ("0,0\n1,nan\n", "line 2: 'nan' is no number"),
        ("0,0\n1,1e999\n", "line 2: .1e999. is beyond the largest double"),
        (b"0,0\n\xff,1\n", "not UTF-8 text"),
        ("1," * 600_000, "larger than 1024 KiB"),
    ],
)
def test_a_table_that_cannot_be_a_law_is_refused(tmp_path, content, message):
    if content is not None:
        (tmp_path / "law.csv").write_bytes(content if isinstance(content, bytes) else content.encode())
    (tmp_path / "servo.toml").write_text(PLANT + "[nonlinearity]\nkind = 'table'\nfile = 'law.csv'\n")
    with pytest.raises(InputError, match=message):
        read_system(tmp_path / "servo.toml")


# keys


@pytest.mark.parametrize("words", [("expression", "slope"), ("text", "slope_bounds"), ("formula", "slope")])
def test_an_expression_takes_both_spellings_of_its_keys(words):
    text, slope = words
    nonlinearity = nonlinearity_entry(
        f"kind = 'expression'\n{text} = 'tanh(sigma)'\nsector = [0, 1]\n{slope} = [0, 1]\nodd = true\n"
    )
    assert (nonlinearity.text, nonlinearity.slope_bounds, nonlinearity.odd) == ("tanh(sigma)", SlopeBounds(0, 1), True)


@pytest.mark.parametrize(
    ("nonlinearity", "message"),
    [
        ("kind = 'expression'\nexpression = 'sigma'\nslop = [0, 1]", "did you mean slope"),
        (
            "kind = 'expression'\nexpression = 'sigma'\ngain = 2",
            "it takes expression, sector, slope, odd, locally_lips",
        ),
        ("kind = 'expression'\nexpression = 'sigma'\ntext = 'sigma'", "both text and expression, which mean the same"),
        ("kind = 'expression'\nsector = [0, 1]", "needs expression"),
        ("kind = 'piecewise linear'\npoints = [[0, 0]]", "needs left_slope and right_slope, or a file"),
    ],
)
def test_keys_have_one_set_of_names(nonlinearity, message):
    assert message in refusal(nonlinearity_entry, nonlinearity)


@pytest.mark.parametrize(
    "nonlinearity", ["kind = 'saturation'\ngain = 1\nlimit = 1\nwidth = 1", "kind = 'spring'\nrate = 1"]
)
def test_what_is_not_close_is_not_proposed(nonlinearity):
    assert "did you mean" not in refusal(nonlinearity_entry, nonlinearity)


@pytest.mark.parametrize(
    "kind", ["backlash", "Hysteresis", "relay-hysteresis", "relay with hysteresis", "play", "stop", "preisach"]
)
def test_kinds_with_memory_are_told_from_typing_errors(kind):
    said = refusal(nonlinearity_entry, f"kind = '{kind}'\nwidth = 1")
    assert "has a memory" in said
    assert "memoryless nonlinearities" in said
    assert "did you mean" not in said


# numbers as text


@pytest.mark.parametrize(
    ("text", "number"),
    [
        (
            Saturation(gain="2", limit=".1", lower_limit="-1/3"),
            Saturation(gain=2, limit=F(1, 10), lower_limit=F(-1, 3)),
        ),
        (DeadZone(width="1e-3", gain="2/3"), DeadZone(width=F(1, 1000), gain=F(2, 3))),
        (Tanh(scale="0.2", gain="3"), Tanh(scale=F(1, 5), gain=3)),
        (Cubic(linear="-.5", cubic="2"), Cubic(linear=F(-1, 2), cubic=2)),
        (ReLU(gain="7/2"), ReLU(gain=F(7, 2))),
        (LeakyReLU(negative_slope="0.1", positive_slope="1"), LeakyReLU(negative_slope=F(1, 10), positive_slope=1)),
        (Quantiser(step="1/8"), Quantiser(step=F(1, 8))),
        (
            PiecewiseLinear([("0", "0"), ("1", ".5")], left_slope="0", right_slope="1/4"),
            PiecewiseLinear([(0, 0), (1, F(1, 2))], left_slope=0, right_slope=F(1, 4)),
        ),
    ],
    ids=str,
)
def test_laws_take_text_where_blocks_take_it(text, number):
    assert text == number


def test_text_that_is_no_number_names_its_field():
    assert NormalCompliance(stiffness="1/3").exact_stiffness == F(1, 3)
    with pytest.raises(InputError, match=r"Saturation\.limit is 'high'; give a number such as"):
        Saturation(limit="high")


# straight lines


def test_a_loop_takes_the_formula_that_analyse_takes():
    loop = Loop("1/(s+1)", "9*tanh(sigma)")
    assert loop.nonlinearity == as_nonlinearity("9*tanh(sigma)") == ExpressionNonlinearity("9*tanh(sigma)")
    assert "unknown name" in refusal(Loop, "1/(s+1)", "9*tanhh(sigma)")


def test_the_sector_of_a_straight_line_is_exact_and_no_theorem_takes_it():
    found = nonlinearity_bounds("sigma/3")
    assert (found.sector, found.slope) == (Sector.line(F(1, 3)), SlopeBounds.line(F(1, 3)))
    assert str(nonlinearity_bounds("3*x").sector) == "[3, 3]"
    with pytest.raises(InputError, match="a linear gain belongs into the block"):
        NonlinearityClass(sector=found.sector)
    with pytest.raises(InputError, match="a linear gain belongs into the block"):
        popov_criterion(RationalPlant([1], [1, 3, 2]), found.sector)


# objects of python-control


def test_a_saturation_of_python_control_is_bounded_as_certified_as_ours():
    theirs, ours = control.saturation_nonlinearity(2), Saturation(limit=2)
    assert nonlinearity_bounds(theirs) == nonlinearity_bounds(ours)
    assert nonlinearity_bounds(theirs).evidence is Evidence.CERTIFIED
    assert violation(theirs, Sector(0, F(1, 2))).evidence is Evidence.CERTIFIED


@pytest.mark.parametrize(
    "memory", [control.relay_hysteresis_nonlinearity(1, 0.5), control.friction_backlash_nonlinearity(1.0)]
)
def test_a_nonlinearity_with_memory_has_a_describing_function_and_is_no_law(memory):
    with pytest.raises(InputError, match="memoryless"):
        as_nonlinearity(memory)
    found = describing_function(memory, [1.0, 2.0])
    assert found.dtype == complex
    assert found == pytest.approx([memory.describing_function(1.0), memory.describing_function(2.0)])


# relay with hysteresis c = 1/2 and level 1 at A = 1: 4/(pi A) (sqrt(1 - c^2/A^2) - i c/A)
def test_the_describing_function_of_a_relay_with_hysteresis_is_the_textbooks():
    found = describing_function(control.relay_hysteresis_nonlinearity(1, 0.5), 1.0)
    assert complex(found) == pytest.approx(4 / np.pi * (np.sqrt(0.75) - 0.5j))


def test_functions_have_describing_functions_too():
    class Declared:
        sector = Sector(0, 1)

        def __call__(self, sigma):
            return np.tanh(sigma)

    wanted = describing_function(Tanh(), [0.5, 2.0])
    assert describing_function(np.tanh, [0.5, 2.0]) == pytest.approx(wanted, rel=1e-12)
    assert describing_function(Declared(), [0.5, 2.0]) == pytest.approx(wanted, rel=1e-12)
    with pytest.raises(AssumptionError, match="odd"):
        describing_function(np.abs, 1.0)
    with pytest.raises(InputError, match="give a nonlinearity, or a function"):
        describing_function(1.0, 1.0)
