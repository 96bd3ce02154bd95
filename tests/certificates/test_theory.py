"""What is registered of a structured plant: found by its type, and asked by what the plant itself says."""

import pytest

from lure.analysis import max_sector
from lure.analysis.certificates.theory import theory_of
from lure.analysis.rod.theory import RodTheory
from lure.plants.block import StructuredPlant
from lure.rod import RodPlant, builtin_system, upwind

ROD = builtin_system("paper-rod").rod
SCHEME = upwind(ROD, 4)


class Unknown(StructuredPlant):
    """A plant of which no room says anything."""

    name, order = "a plate", None

    def transfer(self, s):
        return 1 / s

    def certificate_system(self):
        return {"kind": "plate"}


@pytest.mark.parametrize("plant", [RodPlant(ROD), SCHEME])
def test_the_theory_of_a_plant_is_found_by_its_type(plant):
    theory = theory_of(plant)
    assert isinstance(theory, RodTheory)
    assert theory.plant is plant


def test_of_a_plant_without_a_theory_nothing_is_said():
    with pytest.raises(TypeError, match="theory of a Unknown"):
        max_sector(Unknown())


def test_a_plant_says_what_it_is_and_what_it_stands_for():
    rod = RodPlant(ROD)
    assert (rod.name, rod.order) == ("the rod", None)
    assert (SCHEME.name, SCHEME.order) == ("the scheme with 4 cells", 9)
    # rho = 8, E = 288e6, L = 1, A = 1/40000, k = 1/5000 of the paper
    parameters = {"E": "288000000", "rho": "8", "L": "1", "A": "1/40000", "k": "1/5000"}
    assert rod.certificate_system() == {"kind": "rod", **parameters}
    assert SCHEME.certificate_system() == {"kind": "rod-scheme", **parameters, "cells": 4}
