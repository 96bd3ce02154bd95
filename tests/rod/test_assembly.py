"""Several contacts: the scheme against its closed form, what is conserved, files, and refusals."""

from fractions import Fraction as F

import numpy as np
import pytest
from depth import rarely

from lure import certify, max_sector
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.inequality.zero_modes import zero_modes
from lure.analysis.verdict import Verdict
from lure.classes import Sector
from lure.errors import InputError
from lure.files.reading import parse_system
from lure.rod import Rod
from lure.rod.assembly import RodAssembly


def rod(damping, length=1, area=1):
    return Rod(youngs_modulus=4, density=1, length=length, area=area, damping=damping, compliance=1)  # c = Z = 2


def assembly(arrangement, *rods, contacts, **more):
    return RodAssembly(
        arrangement=arrangement, rods=rods, compliances=(F(1),) * contacts, gaps=(F(0),) * contacts, **more
    )


THREE = rod(1), rod(3, "1/2"), rod(2, 2, 2)
CASES = {
    "both ends": assembly("both-ends", rod(1), contacts=2),
    "across a gap": assembly("across-gap", rod(1), rod(3, "1/2", 2), contacts=1),
    "one obstacle": assembly("one-obstacle", *THREE, contacts=3),
    "an obstacle that moves": assembly("one-obstacle", *THREE, contacts=3, obstacle_damping=F(1, 2)),
}


def matrices(plant):
    if hasattr(plant, "channel"):
        return [np.array([[float(v) for v in row] for row in side]) for side in (plant.A, plant.B, plant.C)]
    r = plant.matrices
    A = np.array([[float(v) for v in row] for row in r.A])
    return [A, np.array([[float(v)] for v in r.b]), np.array([[float(v) for v in r.c]])]


@pytest.mark.parametrize("name", CASES)
def test_the_scheme_has_the_transfer_function_of_its_closed_form_which_tends_to_that_of_the_rods(name):
    found = CASES[name]
    A, B, C = matrices(found.scheme(3))
    points = np.array([0.3 + 2j, 5j, 2.0])
    resolvent = np.linalg.solve(points[:, None, None] * np.eye(len(A)) - A, B.astype(complex))
    assert np.allclose(C @ resolvent, found.transfer(points, 3), rtol=1e-11)
    errors = [np.abs(found.transfer(points, n) - found.transfer(points)).max() for n in (1000, 2000)]
    assert errors[1] == pytest.approx(errors[0] / 2, rel=0.02)  # of first order in 1/N


def test_one_contact_alone_is_that_of_the_papers_rod():
    # H = (d/s)(1 - a Q^2)/(1 + a Q^2), d = 1/2, a = (1 - 2)/(1 + 2): model of one rod
    s, a, Q = 0.7 + 1j, -1 / 3, np.exp(-(0.7 + 1j) / 2)
    alone = assembly("one-obstacle", rod(1), contacts=1).transfer(s)
    assert alone[0, 0] == pytest.approx(0.5 / s * (1 - a * Q**2) / (1 + a * Q**2))


# constant pressures move a rod with the dashpot k at F/k: R = A/k [[1, -1], [-1, 1]] = [[1, -1], [-1, 1]]; two rods
# close at A/k_1 + A/k_2 = 1 + 1/3; three with A_j/k_j = 1, 1/3, 1, and A_j/k_o = 2, 2, 4 more in each row
@pytest.mark.parametrize(
    ("name", "residue"),
    [
        ("both ends", [[1, -1], [-1, 1]]),
        ("across a gap", [[F(4, 3)]]),
        ("one obstacle", [[1, 0, 0], [0, F(1, 3), 0], [0, 0, 1]]),
        ("an obstacle that moves", [[3, 2, 4], [2, F(7, 3), 4], [2, 2, 5]]),
    ],
)
def test_the_residue_is_that_of_the_dashpots_for_every_number_of_cells(name, residue):
    for cells in (1, 4):
        plant = CASES[name].scheme(cells)
        sides = (plant.A, plant.B, plant.C) if hasattr(plant, "channel") else None
        if sides is None:
            r = plant.matrices
            sides = (r.A, [[v] for v in r.b], [list(r.c)])
        modes = zero_modes(*sides, discrete=False)
        assert [[F(int(v.p), int(v.q)) for v in row] for row in (modes.outputs * modes.inputs).tolist()] == residue
    low = 1e-6 * CASES[name].transfer(1e-6)  # of the rods themselves
    assert np.allclose(low, np.array(residue, dtype=float), atol=1e-4)


@pytest.mark.slow_for("both ends")
@pytest.mark.parametrize("name", rarely([name for name in CASES if CASES[name].contacts > 1], "an obstacle that moves"))
def test_the_scheme_is_proved_for_steep_pressures(name):
    found = max_sector(CASES[name].scheme(1), [Sector(0, 1)] * CASES[name].contacts)
    assert found.largest.low > 1e4
    assert found.proof.certificate["conclusion"] == "every motion converges to the set of equilibria"
    assert recheck(dict(found.proof.certificate)).accepted


def dot(row, column):
    return sum((a * v for a, v in zip(row, column, strict=True)), F(0))


def energy(found, cells, y):
    """Of the waves: ``sum_j Z/(4 s) sum_i y_i^2``."""
    total = F(0)
    for j, one in enumerate(found.rods):
        area, length = one.exact["area"], one.exact["length"]
        total += area * length / (4 * cells) * sum(v * v for v in y[2 * cells * j :][: 2 * cells])  # Z/s = A rho L/N
    return total


# the energy of waves falls by k v(0)^2 at each dashpot, by Z/4 of each jump squared and by k_o w'^2, and takes up what
# the pressures give: y'y Z/(2 s) = sum A mu sigma' - ..., exactly, at random states and pressures
@pytest.mark.parametrize("name", [name for name in CASES if CASES[name].contacts > 1])
def test_energy_is_lost_in_dashpots_and_jumps_alone(name):
    found, cells, rng = CASES[name], 2, np.random.default_rng(20261122)
    plant, m = found.scheme(cells), found.contacts
    areas = [one.exact["area"] for one in found.rods] * (m // len(found.rods))
    for _ in range(5):
        y, mu = ([F(int(v), 7) for v in rng.integers(-20, 20, size)] for size in (plant.order, m))
        rate = [dot(row, y) + dot(side, mu) for row, side in zip(plant.A, plant.B, strict=True)]
        sigma_rate = [dot(row, rate) for row in plant.C]
        h = F(1, 10**6)
        moved = [v + h * w for v, w in zip(y, rate, strict=True)]
        back = [v - h * w for v, w in zip(y, rate, strict=True)]
        growth = (energy(found, cells, moved) - energy(found, cells, back)) / (2 * h)  # of a square, exactly
        lost = F(0)
        for j, one in enumerate(found.rods):
            k, Z = one.exact["damping"], 2 * one.exact["area"]
            s = 2 * cells / one.exact["length"]
            waves, jumps = y[2 * cells * j :][: 2 * cells], [v / s for v in rate[2 * cells * j :][: 2 * cells]]
            entering = waves[0] + jumps[0]
            lost += k * ((entering + waves[-1]) / 2) ** 2 + Z / 4 * sum(v * v for v in jumps)
        if found.obstacle_damping is not None:
            lost += dot(areas, mu) ** 2 / found.obstacle_damping
        given = sum(a * u * v for a, u, v in zip(areas, mu, sigma_rate, strict=True))
        assert growth == given - lost


TEXT = """
[contact]
arrangement = "one-obstacle"
compliance = [1, 2]
gap = 0.02
obstacle_damping = 3

[[rod]]
youngs_modulus = 4
density = 1
length = 1
area = 1
damping = "Z/2"

[[rod]]
youngs_modulus = 9
density = 1
length = 1
area = 2
damping = 1

[discretisation]
cells = 2
"""


def test_a_file_is_the_loop_of_the_scheme_and_says_so():
    system = parse_system(TEXT, name="pair", source="pair.toml")
    assert (system.block.order, system.block.inputs) == (10, 2)
    assert all("upwind scheme with 2 cells a rod" in said for said in (system.name, system.title))
    found = certify(system)
    assert found.verdict is Verdict.PROVED
    assert found.conclusion.meaning == "Every solution converges to the set of equilibria"
    changed = parse_system(TEXT, name="pair", source="pair.toml", settings=["rod.2.damping=2", "contact.gap=0"])
    assert changed.block.A != system.block.A


# c^2 = 10: the scheme has the double next to it, 5e-17 away, and says so
def test_an_irrational_wave_speed_is_rounded_and_that_is_said():
    system = parse_system(TEXT.replace("youngs_modulus = 9", "youngs_modulus = 10"), name="pair", source="pair.toml")
    assert system.title.endswith("with the wave speed of rod 2 rounded to a double")
    assert system.approximates.rounded == (2,)
    assert -system.block.A[5][5] == 2 * F(10**0.5)
    assert parse_system(TEXT, name="pair", source="pair.toml").approximates.rounded == ()
    A, B, C = matrices(system.block)
    points = np.array([0.3 + 2j, 5j])
    resolvent = np.linalg.solve(points[:, None, None] * np.eye(len(A)) - A, B.astype(complex))
    assert np.allclose(C @ resolvent, system.approximates.transfer(points, 2), rtol=1e-11)


def single(text):
    return text.replace("[[rod]]", "[rod]", 1).split("[[rod]]")[0].replace("[1, 2]", "1")


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (TEXT.replace("[1, 2]", "[1, 2, 3]"), r"compliance has 3 values; give one, or one for each of 2 contacts"),
        (TEXT.replace("[1, 2]", "[1, 0]"), "contact.compliance is 0; give a positive number"),
        (TEXT.replace("0.02", "-0.02"), "contact.gap is -0.02; give 0 or more"),
        (TEXT.replace("obstacle_damping = 3", "obstacle_damping = -3"), "obstacle_damping is -3"),
        (TEXT.replace("one-obstacle", "across-gap"), "contact.compliance has 2 values"),
        (
            single(TEXT).replace("one-obstacle", "both-ends"),
            "obstacle_damping is 3; give a positive number for one-obst",
        ),
        (single(TEXT).replace("one-obstacle", "across-gap"), "there are 1 rods, and across-gap has 2"),
        (TEXT.replace("one-obstacle", "nowhere"), "contact.arrangement is 'nowhere'; give one of 'both-ends'"),
        (TEXT.replace("cells = 2", "cells = 21"), "discretisation.cells is 21; give 1 to 20"),
        (TEXT.replace("damping = 1\n", "damping = 1\ncompliance = 1\n"), "number 2: unknown key rod.compliance"),
        (TEXT + "[plant]\nnum = [1]\nden = [1, 1]\n", r"both \[contact\] and \[plant\]"),
    ],
)
def test_bad_input_is_one_sentence(text, why):
    with pytest.raises(InputError, match=why) as refused:
        parse_system(text, name="pair", source="pair.toml")
    assert "\n" not in str(refused.value)
