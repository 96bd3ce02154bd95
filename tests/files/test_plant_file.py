"""Loops as TOML files: exact numbers in, one sentence out for whatever is wrong, and back to a file unchanged."""

import math
import tomllib
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st
from refusals import refusal

from lure.analysis.inequality.plant import TransferPolynomials, closed_loop_poles
from lure.classes import NonlinearityClass, Sector
from lure.errors import InputError
from lure.files import find_system, loop_to_toml, parse_system, plant_template, read_system
from lure.files.builtin import builtin_loop, builtin_loops, loop_names
from lure.files.system import LoopSystem, loop_system
from lure.plants import as_plant
from lure.plants.delay import DelayPlant
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace
from lure.rod.file import template
from lure.rod.systems import RodSystem

F = Fraction
PLANT = "[plant]\nnum = [1]\nden = [1, 3, 2, 0]\n"
SATURATION = "[nonlinearity]\nkind = 'saturation'\ngain = 5\nlimit = 1\n"


def parsed(text, *settings):
    return parse_system(text, name="loop", source="loop.toml", settings=settings)


def refused(text, *settings):
    return refusal(parsed, text, *settings)


def same(left, right):
    return (left.name, left.title, left.block, left.nonlinearity_class, left.nonlinearity) == (
        right.name,
        right.title,
        right.block,
        right.nonlinearity_class,
        right.nonlinearity,
    )


# blocks


@pytest.mark.parametrize(
    ("plant", "block"),
    [
        ("num = [1]\nden = [1, 3, 2, 0]", RationalPlant([1], [1, 3, 2, 0])),
        ("num = '1'\nden = '1 3 2 0'", RationalPlant([1], [1, 3, 2, 0])),
        ("num = [0.1]\nden = [1, '1/3']", RationalPlant([F(1, 10)], [1, F(1, 3)])),
        ("num = [1]\nden = [1, 0.5]\ndt = 0.1", RationalPlant([1], [1, F(1, 2)], F(1, 10))),
        ("num = [1]\nden = [1, 0.5]\ndt = '1/3'", RationalPlant([1], [1, F(1, 2)], F(1, 3))),
        ("A = [[0, 1], [-2, -3]]\nB = [0, 1]\nC = [1, 0]", RationalPlant([1], [1, 3, 2])),
        ("A = [[0, 1], [-2, -3]]\nB = [[0], [1]]\nC = [[1, 0]]\nD = [[2]]", RationalPlant([2, 6, 5], [1, 3, 2])),
        ("A = [[-0.1]]\nB = ['1/3']\nC = [1]\nD = 0", RationalPlant([F(1, 3)], [1, F(1, 10)])),
        ("A = [[0.5]]\nB = [1]\nC = [1]\ndt = 1", RationalPlant([1], [1, F(-1, 2)], 1)),
        ("transfer = '1/(s*(s+1))'", RationalPlant([1], [1, 1, 0])),
        ("transfer = 'z/(z-0.5)'", RationalPlant([1, 0], [1, F(-1, 2)], 1)),
        ("transfer = 'z/(z-0.5)'\ndt = 0.1", RationalPlant([1, 0], [1, F(-1, 2)], F(1, 10))),
    ],
)
def test_a_plant_is_read_exactly_in_each_of_its_forms(plant, block):
    assert parsed(f"[plant]\n{plant}\n").block == block


def test_a_dead_time_makes_a_delay_block():
    block = parsed("[plant]\ntransfer = 'exp(-0.2*s)/(s*(s+1))'\n").block
    assert isinstance(block, DelayPlant)
    assert [delay for delay, _ in block.terms] == [F(1, 5)]


def test_a_plant_alone_leaves_law_and_class_open():
    system = parsed(PLANT)
    assert (system.name, system.title) == ("loop", "the loop of loop.toml")
    assert system.nonlinearity is None
    assert system.nonlinearity_class is None


# nonlinearities and classes


def test_a_law_is_made_from_its_table_with_exact_numbers():
    nonlinearity = parsed(PLANT + "[nonlinearity]\nkind = 'saturation'\ngain = 0.1\nlimit = '1/3'\n").nonlinearity
    assert nonlinearity.sector == Sector(0, F(1, 10))
    assert nonlinearity(100.0) == pytest.approx(1 / 3)
    table = "[nonlinearity]\nkind = 'piecewise linear'\npoints = [[0, 0], [0.02, 0]]\nleft_slope = 0\nright_slope = 1\n"
    assert parsed(PLANT + table).nonlinearity.exact(F(3, 100)) == F(1, 100)


def test_a_formula_declares_its_sector_slope_and_symmetry():
    text = "[nonlinearity]\nkind = 'expression'\nexpression = 'tanh(sigma/0.01)'\n"
    text += "sector = [0, 100]\nslope = [0, 100]\nodd = true\n"
    nonlinearity = parsed(PLANT + text).nonlinearity
    assert (nonlinearity.sector.upper, nonlinearity.slope_bounds.upper, nonlinearity.odd) == (100, 100, True)
    wide = parsed(PLANT + text.replace("sector = [0, 100]", "sector = [0, inf]")).nonlinearity
    assert wide.sector.upper == math.inf


@pytest.mark.parametrize(
    ("table", "nonlinearity_class"),
    [
        ("sector = [0, 5.9]", NonlinearityClass(sector=Sector(0, F(59, 10)))),
        ("sector = [0, inf]\ntime_varying = true", NonlinearityClass(sector=Sector(0, math.inf), time_varying=True)),
        ("sector = ['-1/3', '+inf']", NonlinearityClass(sector=Sector(F(-1, 3), math.inf))),
        ("sector = '[0, 2]'", NonlinearityClass(sector=Sector(0, 2))),
        ("slope = [0, 2]\nodd = true", NonlinearityClass.slope_restricted(0, 2, odd=True)),
        ("slope = [-1, 2]\nsector = [0, 1]", None),
    ],
)
def test_a_class_is_read_exactly(table, nonlinearity_class):
    found = parsed(f"{PLANT}[class]\n{table}\n").nonlinearity_class
    if nonlinearity_class is None:
        assert (found.sector, found.slope.lower, found.slope.upper) == (Sector(0, 1), -1, 2)
    else:
        assert found == nonlinearity_class


# A class that leaves the nonlinearity out would let a certificate for the class pass for one of the nonlinearity.
@pytest.mark.parametrize(
    ("table", "inside"),
    [
        ("sector = [0, 5]", True),
        ("sector = [0, 4.999]", False),
        ("sector = [0.001, 5]", False),
        ("slope = [0, 5]\nodd = true", True),
        ("slope = [0, 6]", True),
        ("sector = [0, 5]\nslope = [-1, 5]\nodd = true", True),
        ("slope = [0.5, 5]", False),
    ],
)
def test_a_law_must_belong_to_the_class_given_with_it(table, inside):
    text = f"{PLANT}{SATURATION}[class]\n{table}\n"
    if inside:
        assert parsed(text).nonlinearity_class is not None
    else:
        assert "give a class that contains the nonlinearity" in refused(text)


def test_a_law_whose_slope_falls_below_the_class_is_no_member():
    text = "[nonlinearity]\nkind = 'expression'\ntext = 'sigma*exp(-abs(sigma))'\nsector = [0, 1]\nslope = [-0.2, 1]\n"
    assert parsed(PLANT + text + "[class]\nsector = [0, 1]\nslope = [-0.2, 1]\n").nonlinearity_class is not None
    assert "give a class that contains the nonlinearity" in refused(PLANT + text + "[class]\nslope = [0, 1]\n")
    assert "give a class that contains the nonlinearity" in refused(
        PLANT + text.replace("slope = [-0.2, 1]\n", "") + "[class]\nslope = [-9, 9]\nsector = [0, 1]\n"
    )


def test_a_law_that_is_not_odd_is_no_member_of_an_odd_class():
    lopsided = SATURATION + "lower_limit = -2\n[class]\nsector = [0, 9]\n"
    assert parsed(PLANT + lopsided).nonlinearity_class == NonlinearityClass(sector=Sector(0, 9))
    assert "give a class that contains the nonlinearity" in refused(PLANT + lopsided + "odd = true\n")


# refusals


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[plnt]\nnum = [1]\nden = [1, 1]", "unknown key plnt; did you mean plant?"),
        ("[plant]\nnumm = [1]\nden = [1]", "unknown key plant.numm; did you mean plant.num?"),
        ("[plant]\nnumerator = [1]\nden = [1]", "did you mean plant.num?"),
        ("[plant]\ntransfr = '1/s'", "did you mean plant.transfer?"),
        ("[plant]\nH = '1/s'", "did you mean plant.transfer?"),
        (PLANT + "dead_time = 1", 'unknown key plant.dead_time; did you mean plant.transfer = "exp(-0.2*s)/(s+1)"?'),
        ("[plant]\nnum = [1]\nden = [1, 1]\ndelay = 1", 'did you mean plant.transfer = "exp(-0.2*s)/(s+1)"?'),
        (PLANT + "[clas]\nsector = [0, 1]", "unknown key clas; did you mean class?"),
        (PLANT + "[class]\nsectr = [0, 1]", "unknown key class.sectr; did you mean class.sector?"),
        (PLANT + "[class]\ntimevarying = true\nsector = [0, 1]", "did you mean class.time_varying?"),
        ("colour = 1\n" + PLANT, "unknown key colour; a system has the keys name and title and the tables [plant]"),
        ("[plant]\n", "got none of them"),
        ("[plant]\nnum = [1]", "num and den, or A, B and C, or transfer; got num"),
        ("[plant]\nnum = [1]\nden = [1, 1]\ntransfer = '1/s'", "got den, num, transfer"),
        ("[plant]\nA = [[1]]\nB = [1]", "got A, B"),
        ("[class]\nsector = [0, 1]", "the table [plant] is missing; give it with num, den"),
        (PLANT + "[rod]\nlength = 1", "both [rod] and [plant]"),
        ("plant = 3", "plant is 3; give a table that starts with the line [plant]"),
        ("name = 3\n" + PLANT, "name is 3; give a text in quotes"),
        ("[plant]\nnum = 1\nden = [1, 1]", "plant.num is 1; give a list such as"),
        ("[plant]\nnum = []\nden = [1, 1]", "plant.num is empty"),
        ("[plant]\nnum = [true]\nden = [1, 1]", "plant.num[0] is true; give a number"),
        ("[plant]\nnum = [nan]\nden = [1, 1]", "plant.num[0] is NaN; give a finite number"),
        ("[plant]\nnum = [1e999]\nden = [1, 1]", "plant.num[0] is 1E+999, outside the range"),
        ("[plant]\nnum = [1e99999999999999999999]\nden = [1, 1]", "plant.num[0]"),
        ("[plant]\nnum = ['1 2']\nden = [1, 1]", "plant.num[0] is '1 2'; give one number"),
        ("[plant]\nnum = [[1]]\nden = [1, 1]", "plant.num[0] is [1]; give a number"),
        ("[plant]\nnum = [1, 1, 1]\nden = [1, 1]", "plant: the transfer function is improper"),
        ("[plant]\nnum = [1]\nden = [0]", "plant: the denominator is zero"),
        ("[plant]\nnum = [1]\nden = [1, 1]\ndt = -1", "plant.dt is -1; give a positive time"),
        ("[plant]\nnum = [1]\nden = [1, 1]\ndt = 0", "plant.dt is 0; give a positive time, or leave dt out"),
        ("[plant]\nnum = [1]\nden = [1, 1]\ndt = true", "plant.dt is true; give a number"),
        ("[plant]\nA = 1\nB = [1]\nC = [1]", "plant.A is 1; give a list of rows"),
        ("[plant]\nA = [[0, 1], [2]]\nB = [0, 1]\nC = [1, 0]", "plant: A is not square"),
        (
            "[plant]\nA = [[0]]\nB = [[1, 2]]\nC = [1]",
            "plant: it has 2 inputs and 1 output; nonlinearities mu_i",
        ),
        ("[plant]\nA = [[[0]]]\nB = [1]\nC = [1]", "plant.A[0][0] is nested too deeply"),
        ("[plant]\nA = [[0]]\nB = [1]\nC = [1]\nD = [1, 2]", "plant: D has 2 entries"),
        ("[plant]\ntransfer = 1", "plant.transfer is 1; give a formula in quotes"),
        ("[plant]\ntransfer = '1/(s+1'", "plant: transfer: expected ')'"),
        ("[plant]\ntransfer = '1/s'\ndt = 1", "the formula is in s but dt asks for discrete time"),
        (PLANT + "[class]\nodd = true", "class: neither sector, slope, gain nor relu is given"),
        (PLANT + "[class]\nsector = [1, 0]", "class.sector is [1, 0]; the first must be smaller"),
        (PLANT + "[class]\nsector = [0, 0]", "the first must be smaller"),
        (PLANT + "[class]\nsector = [0, nan]", "class.sector[1] is NaN"),
        (PLANT + "[class]\nsector = [0]", "class.sector is [0]; give two numbers"),
        (PLANT + "[class]\nsector = 5", "class.sector is 5; give two numbers"),
        (PLANT + "[class]\nsector = [0, 'x']", "class.sector[1] is 'x'; give a number"),
        (PLANT + "[class]\nsector = [0, 1]\nodd = 1", "class.odd is 1; give true or false"),
        (PLANT + "[class]\nsector = [0, 1]\nslope = [0.5, 1]", "class: NonlinearityClass has the sector [0, 1]"),
        (PLANT + "[nonlinearity]\ngain = 1", "nonlinearity.kind is missing"),
        (PLANT + "[nonlinearity]\nkind = 3", "nonlinearity.kind is 3; give the kind of a nonlinearity in quotes"),
        (
            PLANT + "[nonlinearity]\nkind = 'saturaton'",
            "nonlinearity: unknown kind of nonlinearity 'saturaton'; did you mean",
        ),
        (PLANT + "[nonlinearity]\nkind = 'tanh'\nscal = 1", "nonlinearity: the nonlinearity 'tanh' has no key 'scal'"),
        (PLANT + "[nonlinearity]\nkind = 'tanh'\nscale = 'x'", "nonlinearity: "),
        (PLANT + "[nonlinearity]\nkind = 'tanh'\nscale = {a = 1}", "nonlinearity.scale is a table"),
        (PLANT + "[nonlinearity]\nkind = 'expression'\ntext = 'sigma + 1'\nsector = [0, 1]", "nonlinearity: "),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(text, said):
    assert said in refused(text)


@given(
    st.text(max_size=30),
    st.sampled_from(["plant.num", "plant.A", "plant.transfer", "class.sector", "plant.dt", "name"]),
)
def test_no_setting_breaks_the_reader(text, key):
    try:
        message = parsed(PLANT, f"{key}={text}").title
    except InputError as error:
        message = str(error)
    assert message.isprintable()


# settings


def test_settings_change_a_plant_before_it_is_checked():
    system = parsed(PLANT, "plant.den=1 3 2 1/3", "class.sector=[0, inf]", "class.odd=true", "title=mine")
    assert system.block == RationalPlant([1], [1, 3, 2, F(1, 3)])
    assert system.nonlinearity_class == NonlinearityClass(sector=Sector(0, math.inf), odd=True)
    assert system.title == "mine"
    changed = parsed(PLANT + SATURATION, "nonlinearity.gain=0.1")
    assert changed.nonlinearity.sector == Sector(0, F(1, 10))
    assert changed.title == "the loop of loop.toml; with nonlinearity.gain=0.1"
    assert "unknown key plant.dn; did you mean plant.den?" in refused(PLANT, "plant.dn=3")
    assert "unknown key rod.length" in refused(PLANT, "rod.length=3")


def test_a_built_in_loop_may_be_changed_and_says_so():
    system = find_system("dt-6", ["plant.dt=0.5"])
    assert system.block.dt == F(1, 2)
    assert system.name == "dt-6 (changed)"
    assert system.title.endswith("; with plant.dt=0.5")


# files, names and round trips


def test_a_file_is_a_rod_or_a_loop_by_its_tables(tmp_path):
    (tmp_path / "rod.toml").write_text(template(), encoding="utf-8")
    (tmp_path / "motor.toml").write_text(PLANT, encoding="utf-8")
    assert isinstance(find_system(str(tmp_path / "rod.toml")), RodSystem)
    motor = read_system(tmp_path / "motor.toml")
    assert isinstance(motor, LoopSystem)
    assert (motor.name, motor.source) == ("motor", "motor.toml")
    assert isinstance(find_system("paper-rod"), RodSystem)
    assert find_system("kalman-fitts").name == "kalman-fitts"
    with pytest.raises(InputError, match="'kalman-fits'; did you mean 'kalman-fitts'"):
        find_system("kalman-fits")
    with pytest.raises(InputError, match="there is no built-in loop 'third-ordr'; did you mean 'third-order'"):
        builtin_loop("third-ordr")


def test_the_template_parses_and_each_of_its_comments_does_too():
    system = parsed(plant_template())
    assert system.block == RationalPlant([1], [1, 3, 2, 0])
    assert system.nonlinearity_class.sector == Sector(0, F(59, 10))
    text = plant_template()
    alternatives = {
        "A": ["# A =", "# B =", "# C =", "# D ="],
        "transfer": ["# transfer ="],
        "expression": ['# kind = "exp', "# expression =", "# sector =", "# slope = [0, 5]\n", "# odd = true\n"],
    }
    for lines in alternatives.values():
        for start in lines:
            assert text.count("\n" + start) == 1, start
    formula = text.replace("\nnum", "\n# num").replace("\nden", "\n# den").replace("\n# transfer", "\ntransfer")
    assert parsed(formula).block == system.block
    matrices = text.replace("\nnum", "\n# num").replace("\nden", "\n# den")
    for name in "ABCD":
        matrices = matrices.replace(f"\n# {name} =", f"\n{name} =")
    assert parsed(matrices).block == RationalPlant([1], [1, 3, 2])
    nonlinearity = text.replace('kind = "saturation"', "").replace("\ngain = 5\nlimit = 1\n", "\n")
    for start in alternatives["expression"]:
        nonlinearity = nonlinearity.replace("\n" + start, "\n" + start.removeprefix("# "))
    assert parsed(nonlinearity).nonlinearity.odd


@pytest.mark.parametrize("name", loop_names())
def test_a_built_in_loop_survives_the_way_through_a_file(name):
    system = builtin_loop(name)
    assert same(system, parsed(loop_to_toml(system)))
    assert system.source


def test_a_dead_time_survives_the_way_through_a_file():
    block = as_plant("exp(-0.2*s)/(3*s*(s+1)) + 1/3/(s+1)")
    system = loop_system(
        ("delayed", "a delay", ""), block, nonlinearity_class=NonlinearityClass.slope_restricted(F(-1, 3), math.inf)
    )
    again = parsed(loop_to_toml(system))
    assert same(again, system)
    matrix = StateSpace([[-1]], [1], [1])
    with pytest.raises(InputError, match="too large for a system file"):
        loop_to_toml(loop_system(("m", "", ""), matrix))


@given(
    st.lists(st.fractions(max_denominator=10**6), min_size=1, max_size=4),
    st.lists(st.fractions(max_denominator=10**6), min_size=4, max_size=5).filter(lambda d: d[0] != 0),
    st.one_of(st.none(), st.fractions(F(1, 1000), 10)),
)
def test_any_block_survives_the_way_through_a_file(top, bottom, dt):
    system = loop_system(("any", "any title", "any source"), RationalPlant(top, bottom, dt))
    text = loop_to_toml(system)
    assert tomllib.loads(text)["title"] == "any title"
    assert same(parsed(text), system)


# the library, against what is known of its plants


# Where the linear loop with gain k stops being stable, from benchmarks with closed forms: 1/(s(s+1)(s+2)) at 6, ...
@pytest.mark.parametrize(
    ("name", "limit"),
    [
        ("third-order", F(6)),
        ("integrator-oscillator", F(1)),
        ("integrator-resonance", F(1, 10)),
        ("triple-lag", F(8)),
        ("three-lags", F(5, 2)),
        ("ct-4", F(7, 2)),
        ("ct-6", F(12, 7)),
        ("leonov-bragin-kuznetsov", F(1000, 101)),
        ("dt-1", F(361, 10)),
        ("dt-6", F(25, 23)),
    ],
)
def test_a_plant_of_the_library_has_its_published_hurwitz_limit(name, limit):
    plant = TransferPolynomials.of(builtin_loop(name).block)
    below, above = (closed_loop_poles(plant, limit * (1 + F(sign, 10**6))) for sign in (-1, 1))
    assert below.left == plant.degree
    assert above.left < plant.degree


def test_the_counterexamples_of_the_library_are_the_published_ones():
    fitts = builtin_loop("kalman-fitts")
    assert [float(c) for c in fitts.block.denominator[1:]] == pytest.approx([0.12, 2.0254, 0.121308, 0.98191881])
    assert fitts.nonlinearity.sector == Sector(0, 100)
    hidden = TransferPolynomials.of(builtin_loop("lurie-hidden-zero").block)
    assert hidden.hidden.degree() == 1
    assert TransferPolynomials.of(builtin_loop("lurie-negative-residue").block).residue == -1
    assert TransferPolynomials.of(builtin_loop("lurie-indirect-control").block).residue == 1


def test_the_library_is_listed_with_distinct_names_and_titles():
    systems = builtin_loops()
    assert tuple(systems) == loop_names()
    assert len({system.title for system in systems.values()}) == len(systems)
    assert all(system.name == name for name, system in systems.items())


def test_a_setting_of_one_coefficient_is_told_what_to_change():
    assert refused(PLANT, "plant.den.1=2") == (
        "--set: plant.den is no table, and plant.den.1 no key; change plant.den as a whole, "
        "or name a constant of it in [plant.parameters]"
    )
    assert "did you mean performance.Bw?" in refused(PLANT, "performance.Bx=1")
