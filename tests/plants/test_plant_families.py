"""Plants with parameters: formulas in their coefficients become exact polynomials."""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lure import as_plant, max_sector
from lure.errors import InputError
from lure.files import find_system, loop_to_toml
from lure.files.reading import parse_system
from lure.plants import parameters
from lure.plants.channel_family import ChannelFamily
from lure.plants.delay import DelayPlant
from lure.plants.family import PlantFamily
from lure.plants.rational import RationalPlant
from lure.plants.text import parse_transfer

BOX = {"m": (1, 2), "c": (Fraction(1, 2), 1), "k": (1, 3)}
numbers = st.fractions(min_value=-3, max_value=5, max_denominator=50)


@given(m=st.fractions(1, 2, max_denominator=9), c=numbers, k=numbers)
def test_coefficients_formula_and_matrices_are_the_same_plants(m, c, k):
    # m x'' + c x' + k x = mu, in three ways
    ways = [
        PlantFamily.of_coefficients([1], ["m", "c", "k"], BOX),
        PlantFamily.of_formula("1/(m*s^2 + c*s + k)", BOX),
        PlantFamily.of_matrices([[0, 1], ["-k/m", "-c/m"]], [0, "1/m"], [1, 0], 0, BOX),
    ]
    wanted = as_plant(([1], [m, c, k]))
    assert [one.at((m, c, k)) for one in ways] == [wanted] * 3
    assert len({one.terms for one in ways}) == 1


@given(a=numbers, b=numbers)
def test_matrices_with_a_direct_term_are_those_of_the_numbers(a, b):
    A, B, C = [["-a", "1"], ["b^2", -2]], [["a"], [1]], [[1, "b"]]
    family = PlantFamily.of_matrices(A, B, C, "a*b", {"a": (0, 1), "b": (0, 1)})
    exact = ([[-a, 1], [b * b, -2]], [a, 1], [1, b], a * b)
    assert family.at((a, b)) == as_plant(exact)


def test_a_formula_may_divide_by_what_vanishes_nowhere_in_the_box():
    family = PlantFamily.of_formula("1/(s^2 + s/a + 1/(1 + 1/(a*s + 1)))", {"a": (Fraction(1, 2), 1)})
    # a = 1: 1/(1 + 1/(s + 1)) = (s + 1)/(s + 2), so that H = (s + 2)/((s^2 + s)(s + 2) + s + 1)
    assert family.at((Fraction(1),)) == RationalPlant([1, 2], [1, 3, 3, 1])
    assert PlantFamily.of_formula("1/(a*s + 1)", {"a": (0, 1)}).order == 1


def test_constants_are_no_parameters_and_constants_alone_make_one_plant():
    family = PlantFamily.of_coefficients(["g"], [1, "2*a", "g"], {"a": (1, 2), "g": Fraction("0.1")})
    assert (family.names, family.degrees) == (("a",), (1,))
    assert PlantFamily.of_coefficients(["g"], [1, "g"], {"g": 2}) == RationalPlant([2], [1, 2])


# exp(-T s) exp(-(a + 1) s/2)/exp(-s/4) = exp(-(1/4 + T + a/2) s)
def test_a_dead_time_is_a_number_a_parameter_or_a_sum_of_such():
    text = "exp(-T*s)*a*(s + 2)*exp(-(a + 1)*s/2)/(exp(-s/4)*(s^2 + s + a))"
    family = PlantFamily.of_formula(text, {"T": (0, 1), "a": (1, 2)})
    assert family.delay == (Fraction(1, 4), 1, Fraction(1, 2))
    assert family.waits(family.box) == (Fraction(3, 4), Fraction(9, 4))
    assert family.at((Fraction(1), Fraction(2))) == DelayPlant.parse("(2*s + 4)*exp(-9*s/4)/(s**2 + s + 2)")
    assert PlantFamily.of_formula("exp(-T*s)/(s+g)", {"T": 0.5, "g": 2}) == DelayPlant.parse("exp(-s/2)/(s+2)")
    plant = f'[plant]\ntransfer = "{text}"\n[plant.parameters]\nT = [0, 1]\na = [1, 2]\n'
    system = parse_system(plant, name="own", source="here")
    assert parse_system(loop_to_toml(system), name="own", source="here").block == system.block == family


def test_a_file_reads_back_as_it_was_written():
    plant = '[plant]\nnum = ["b"]\nden = [1, "2*zeta*w", "w^2/3"]\n'
    text = plant + "[plant.parameters]\nw = [1, 2]\nzeta = [0.1, 0.3]\nb = [1, 2]\n"
    system = parse_system(text, name="own", source="here")
    again = parse_system(loop_to_toml(system), name="own", source="here")
    assert system.block == again.block
    assert system.block.box == ((1, 2), (Fraction(1, 10), Fraction(3, 10)), (1, 2))


@pytest.mark.parametrize(
    ("plant", "parameters", "said"),
    [
        ('num = ["b"]\nden = [1, "a"]', "a = [2, 1]\nb = 1", r"parameters\.a is \[2, 1\]"),
        ('num = [1]\nden = [1, "a"]', "a = [1, 2]\nb = [1, 2]", "parameters.b does not occur"),
        ('num = [1]\nden = [1, "q"]', "a = [1, 2]", "unknown name 'q'"),
        ('num = [1]\nden = [1, "a*s"]', "a = [1, 2]", "holds s"),
        ('num = [1]\nden = [1, "1/a"]', "a = [-1, 2]", "may vanish in the box"),
        ('transfer = "1/(s^2+s/a+1)"', "a = [0, 1]", "may vanish in the box"),  # multiplied out a/(a s^2 + s + a)
        ('transfer = "1/(s+1/(1+1/(s+a^-2)))"', "a = [-1, 1]", "may vanish in the box"),
        ('num = [1]\nden = [1, "1/(1+1/a)"]', "a = [0, 1]", "may vanish in the box"),  # a/(a + 1)
        ('transfer = "1/(a*(s+1))"', "a = [0, 1]", "may vanish in the box"),
        ('transfer = "1/(1+(s^2+s+1)/(a*s+b))"', "a = [0, 1]\nb = [0, 1]", "may vanish in the box"),  # at a = b = 0
        ('num = [1]\nden = [1, "a"]', "s = [1, 2]\na = 1", "is no name here"),
        ('transfer = "s^2/(s+a)"', "a = [1, 2]", "improper"),
        ('transfer = "1/(s+exp(-s)+a)"', "a = [1, 2]", "a dead time is a factor of the whole numerator"),
        ('transfer = "exp(-s)/(s+a) + 1/(s+1)"', "a = [1, 2]", "a dead time is a factor of the whole numerator"),
        ('transfer = "exp(-a*s)/(s+1)"', "a = [-1, 2]", "it is -1 s for some"),
        ('transfer = "exp(-a*s)/(z+1)"', "a = [1, 2]", "both s and z occur|write z.-n in discrete time"),
        ('transfer = "exp(-s/a)/(s+1)"', "a = [1, 2]", "exp has the argument '-s/a'"),
        ('transfer = "exp(-a*s/(s+1)"', "a = [1, 2]", "close the bracket of exp"),
        ('num = ["exp(-a*s)"]\nden = [1, 1]', "a = [1, 2]", "in one channel alone, as a factor of transfer"),
        ('transfer = [["exp(-a*s)/(s+1)", "0"], ["0", "1/(s+a)"]]', "a = [1, 2]", "in one channel alone"),
        (
            'transfer = [["1/(s+a)", "s^2/(s+a)"]]',
            "a = [1, 2]",
            r"transfer\[0\]\[1\] is 's.2/\(s\+a\)', which is improper",
        ),
        ('transfer = [["1/(s+a)", "1/(z+a)"]]', "a = [1, 2]", "holds s and z"),
        ('transfer = [["a", "1"], ["2", "a"]]', "a = [1, 2]", "no poles"),
        ('num = [1]\nden = [1, "a"]', "a = [1, 2, 3]", "give two numbers"),
        ("A = [[0, 1]]\nB = [1]\nC = [1]", "a = [1, 2]", "A is square"),
    ],
)
def test_what_is_no_family_is_refused_in_one_sentence(plant, parameters, said, tmp_path):
    path = Path(tmp_path, "plant.toml")
    path.write_text(f"[plant]\n{plant}\n[plant.parameters]\n{parameters}\n", encoding="utf-8")
    with pytest.raises(InputError, match=said):
        find_system(str(path))


@pytest.mark.parametrize("least", ["1e-9", "1e-30"])
def test_a_denominator_that_is_nearly_0_at_an_end_does_not_vanish(least: str) -> None:
    """m in [least, 1] is above 0; a ball about the middle with a radius of a few digits holds 0."""
    ring = parameters.Ring({"m": (Fraction(least), Fraction(1))})
    parameters.require_apart(ring.variable("m"), ring)
    with pytest.raises(InputError, match="may vanish in the box"):
        parameters.require_apart(ring.variable("m") - ring.number(Fraction(1, 2)), ring)


# parameters that are all constants: the numbers in their places, hidden modes kept
@pytest.mark.parametrize("text", ["k/(s*(s+a))", "k*(s+a)/((s+a)*(s^2+k))", "1/s + k/(s*(s+a))", "-(a)^2/(k*s+1)"])
def test_a_formula_of_constants_is_that_with_the_numbers_in_it(text):
    found = PlantFamily.of_formula(text, {"k": Fraction(3, 7), "a": Fraction(-5, 2)})
    assert found == parse_transfer(text.replace("k", "(3/7)").replace("a", "(-5/2)"))
    with pytest.raises(InputError, match="plant: it is improper"):
        PlantFamily.of_formula("s^2/(s+a)", {"a": Fraction(1)})


# entries of one column with the same denominator share their states: 2 + 1 + 1 here
def test_a_matrix_of_formulas_has_the_transfer_functions_of_its_entries():
    rows = [["k/(s+1)^2", "1/(s+a)"], ["(s+2)/(s+1)^2", "(k*s+b)/(a*s+1)"]]
    family = ChannelFamily.of_transfers(rows, {"k": (1, 2), "a": (1, 3), "b": (2, Fraction(5, 2))})
    assert (family.order, family.names) == (4, ("k", "a", "b"))
    k, a, b = point = Fraction(3, 2), Fraction(2), Fraction(9, 4)
    A, B, C, D = family.at(point).doubles()
    s = 0.3 + 0.8j
    found = C @ np.linalg.solve(s * np.eye(4) - A, B) + D
    wanted = [[k / (s + 1) ** 2, 1 / (s + a)], [(s + 2) / (s + 1) ** 2, (k * s + b) / (a * s + 1)]]
    assert np.allclose(found, np.array(wanted, dtype=complex))


# s + a + k g with k = -1, a = 1 has a root at or beyond 0 from g = 1 on; a gain called k would be -1 here
@pytest.mark.parametrize(("other", "gain"), [("a", "g"), ("g", "gain")])
def test_a_gain_that_refutes_is_not_named_like_a_parameter(other, gain):
    found = max_sector(PlantFamily.of_formula(f"k/(s + {other})", {"k": (-1, 1), other: (1, 2)}))
    assert f"with k = -1, {other} = 1, phi = {gain} sigma, {gain} just above 1: the loop" in str(found)
