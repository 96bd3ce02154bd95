"""lure.rod.systems and lure.loop: the named systems, their numbers, and what a wrong name is answered."""

import dataclasses
from fractions import Fraction

import numpy as np
import pytest

from lure import InputError, Loop
from lure.rod import builtin_system, builtin_systems, initial_state, upwind
from lure.rod.systems import paper_rod, rod_from_exact

NAMES = ["paper-rod", "paper-rod-figure-8", "paper-rod-figure-9", "paper-rod-figure-10", "steel-rod"]


def test_the_names_are_those_of_the_figures_in_their_order_and_the_steel_rod():
    assert list(builtin_systems()) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_each_system_builds_its_scheme_its_start_and_its_loop(name):
    system = builtin_system(name)
    scheme = upwind(system.rod, system.cells, form=system.form)
    assert system.name == name
    assert scheme.A.shape == (21, 21)
    assert initial_state(scheme, system.scenario).shape == (21,)
    loop = Loop(scheme, system.rod.nonlinearity)
    assert np.isfinite(loop.block.transfer(1j))
    assert loop.nonlinearity.sector.upper == 1 / system.rod.exact["compliance"]


@pytest.mark.parametrize(
    ("name", "damping", "amplitude", "form", "until"),
    [
        ("paper-rod", "2e-4", 0, "corrected", 2.5e-3),
        ("paper-rod-figure-8", "2e-4", 2, "as-printed", 5.0),
        ("paper-rod-figure-9", "8e-4", 5, "as-printed", 5.0),
        ("paper-rod-figure-10", "8e-4", 2, "as-printed", 5.0),
    ],
)
def test_the_figures_differ_in_damping_force_and_form(name, damping, amplitude, form, until):
    system = builtin_system(name)
    assert system.rod.exact["damping"] == Fraction(damping)
    assert (system.form, system.until, system.cells, system.simulation_cells) == (form, until, 10, None)
    t = np.array([0.0, 0.1, 1.0])
    assert np.allclose(system.scenario.force(t=t), amplitude * np.sin(4 * t), rtol=1e-15)
    assert system.scenario.body_force.is_zero
    assert system.scenario.free is (amplitude == 0)


# section 5: E = 288e6, rho = 8, L = 1, A = 0.25e-4, l = 1.02 (gap 0.02), e = 2e-4, u0 = e/2 - e x, u1 = 0; eps = 1
def test_the_rod_of_the_paper_is_exact():
    rod = builtin_system("paper-rod").rod
    assert rod.exact == {
        "youngs_modulus": 288_000_000,
        "density": 8,
        "length": 1,
        "area": Fraction(25, 1_000_000),
        "damping": Fraction(2, 10_000),
        "compliance": 1,
        "exponent": 1,
        "gap": Fraction(2, 100),
    }
    scenario = builtin_system("paper-rod").scenario
    assert scenario.displacement(x=np.array([0.0, 0.5, 1.0])).tolist() == [1e-4, 0.0, -1e-4]
    assert scenario.velocity.is_zero


def test_the_rod_of_the_paper_takes_another_damping():
    assert paper_rod("8e-4") == rod_from_exact({**paper_rod().exact, "damping": Fraction(8, 10_000)})


def test_every_system_says_where_its_numbers_come_from():
    for system in builtin_systems().values():
        assert ("section 5" in system.source) is system.name.startswith("paper")
        assert system.source
        assert system.title


@pytest.mark.parametrize(
    ("name", "near"),
    [
        ("paper-rot", "paper-rod"),
        ("paper-rod-figure-80", "paper-rod-figure-8"),
        ("Paper-Rod-figure-9", "paper-rod-figure-9"),
    ],
)
def test_a_misspelt_name_is_answered_with_the_nearest(name, near):
    with pytest.raises(
        InputError, match=rf"^there is no built-in system '{name}'; did you mean '{near}'\? choose from "
    ):
        builtin_system(name)


def test_a_name_near_to_none_is_answered_with_all():
    with pytest.raises(InputError, match=rf"^there is no built-in system 'beam'; choose from {', '.join(NAMES)}$"):
        builtin_system("beam")


def test_the_table_of_systems_cannot_be_changed():
    with pytest.raises(TypeError):
        builtin_systems()["mine"] = None


def test_the_unit_of_the_compliance_is_that_of_the_exponent():
    linear = builtin_system("paper-rod")
    quadratic = dataclasses.replace(linear, rod=rod_from_exact({**linear.rod.exact, "exponent": Fraction(2)}))
    assert "m/Pa" in linear._repr_html_()
    assert "m^m/Pa" not in linear._repr_html_()
    assert "m^m/Pa" in quadratic._repr_html_()
