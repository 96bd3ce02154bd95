"""Rods with several contacts themselves: the energy theorem's certificate, what neither checker accepts, one motion."""

import json
from dataclasses import replace
from fractions import Fraction as F
from importlib import resources

import jsonschema
import numpy as np
import pytest
import xarray
from certificate_format import FORMAT
from matplotlib.figure import Figure
from tampering import assert_both_reject, changed, refused_again

from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.checker import Proved
from lure.analysis.certificates.drafts import checked
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.report.loop.write import build_loop_report
from lure.analysis.report.parts import ContradictionError
from lure.analysis.rod.assembly import circle_reach, followed, of_the_rods, rods_at_rest, varying_pressures
from lure.errors import AssumptionError, InputError
from lure.rod import Rod, Scenario
from lure.rod.assembly import RodAssembly
from lure.rod.assembly_file import assembly_loop
from lure.rod.assembly_motion import AssemblyMotion

QUIET = "every motion of finite energy comes to rest, and the pressure of every contact is square integrable"
RESTS = "every motion of finite energy comes to rest, and the pressure of every contact tends to 0"


def rods(arrangement, count, contacts, damping=800, **more):
    one = Rod(youngs_modulus=210e9, density=7850, length=1, area="1e-4", damping=damping, compliance=1)
    ones, none = (F(1),) * contacts, (F(0),) * contacts
    return RodAssembly(arrangement=arrangement, rods=(one,) * count, compliances=ones, gaps=none, **more)


CASES = {
    "both-ends": rods("both-ends", 1, 2),
    "across-gap": rods("across-gap", 2, 1),
    "one-obstacle": rods("one-obstacle", 3, 3),
    "moving": rods("one-obstacle", 3, 3, obstacle_damping=F(5)),
}


def accepted(name):
    return json.loads(json.dumps(dict(rods_at_rest(CASES[name]).certificate)))


@pytest.mark.parametrize("name", CASES)
def test_rods_come_to_rest_by_both_checkers(name):
    found = accepted(name)
    assert found["conclusion"] == RESTS
    assert recheck(found).accepted
    FORMAT.validate(found)


PULLS = {"sector": ["-1", "inf"], "slope": None, "odd": False, "time_varying": False, "linear": False}


@pytest.mark.parametrize(
    ("name", "path"),
    [
        ("both-ends", ("system", "rods", 0, "k", "0")),  # waves go on for ever
        ("both-ends", ("system", "rods", 0, "k", "-800")),
        ("one-obstacle", ("system", "rods", 1, "k", "0")),
        ("across-gap", ("system", "rods", 1, "A", "-1")),
        ("across-gap", ("system", "arrangement", "one-obstacle")),  # which has two contacts
        ("across-gap", ("system", "arrangement", "both-ends")),
        ("across-gap", ("system", "obstacle", "1")),
        ("moving", ("system", "obstacle", "-5")),
        ("moving", ("system", "rods", [])),
        ("both-ends", ("laws", "channels", 0, PULLS)),
        ("both-ends", ("laws", "channels", 1, "time_varying", True)),
        ("both-ends", ("laws", "channels", 1, "regularity", "any")),
        ("both-ends", ("conclusion", "0 attracts every motion")),
        ("both-ends", ("conclusion", "every motion of finite energy comes to rest, its end at a zero of the law")),
        ("both-ends", ("theorem", "rod-energy")),
        ("both-ends", ("theorem", "diagonal-circle")),
        ("both-ends", ("verdict", "REFUTED")),
        ("both-ends", ("multiplier", {"theta": "1"})),
        ("both-ends", ("proof", "method", "matrix")),
    ],
)
def test_what_was_tampered_with_is_accepted_by_neither(name, path):
    assert_both_reject(changed(accepted(name), *path), stored=path[0] == "conclusion")


def varying(name):
    return json.loads(json.dumps(dict(varying_pressures(CASES[name]).certificate)))


@pytest.mark.parametrize("name", CASES)
def test_rods_come_to_rest_under_pressures_that_change_with_time(name):
    found = varying(name)
    assert found["conclusion"] == QUIET
    assert all(one["time_varying"] for one in found["laws"]["channels"])
    assert recheck(found).accepted
    FORMAT.validate(found)
    keys = ("verdict", "numbers", "system", "laws", "theorem", "multiplier", "proof")
    draft = {key: found[key] for key in keys}  # without findings, which a changed bound would contradict at once
    assert isinstance(checked(draft), Proved)
    beyond = [str(F(101, 99) * F(one["sector"][1])) for one in found["laws"]["channels"]]  # 99 per cent is the default
    for i, upper in enumerate(beyond):
        for value in (upper, "inf"):
            path = ("laws", "channels", i, "sector", 1, value)
            with pytest.raises(Rejected, match=r"is not below 1|with an upper bound"):
                checked(changed(draft, *path))
            assert refused_again(changed(found, *path))


@pytest.mark.parametrize(
    "path",
    [
        ("system", "rods", 0, "k", "-800"),
        ("system", "rods", 0, "k", "80000"),  # far from Z: less is covered
        ("system", "rods", 0, "L", "2"),  # a longer rod lags more
        ("laws", "channels", 0, "sector", 0, "-1"),
        ("laws", "channels", 0, "regularity", "any"),
        ("conclusion", RESTS),
        ("theorem", "rods-energy"),
        ("theorem", "rod-circle"),
        ("multiplier", {"theta": "1"}),
    ],
)
def test_a_varying_pressure_that_was_tampered_with_is_accepted_by_neither(path):
    assert_both_reject(changed(varying("moving"), *path), stored=path[0] == "conclusion")


# falsifier: random rods and frequencies, resonances among them, against the least eigenvalue of the Hermitian part of
# diag(A) H diag(A)^-1/2-scaled; it comes near the bound of one contact, (L/E)|k^2 - Z^2|/min^2
def test_the_hermitian_part_stays_above_what_the_circle_criterion_uses():
    rng, nearest = np.random.default_rng(15), {}
    for _ in range(40):
        for arrangement, count, contacts in (("both-ends", 1, 2), ("across-gap", 2, 1), ("one-obstacle", 3, 3)):
            parts = tuple(
                Rod(
                    **dict(zip(("youngs_modulus", "density", "length", "area", "damping"), values, strict=True)),
                    compliance=1,
                )
                for values in 10.0 ** rng.uniform(-0.5, 0.5, (count, 5))
            )
            plate = {"obstacle_damping": F(1, 2)} if contacts == 3 else {}
            found = RodAssembly(
                arrangement=arrangement, rods=parts, compliances=(F(1),) * contacts, gaps=(F(0),) * contacts, **plate
            )
            reach = np.array([float(end) for end in circle_reach(found)])
            turn = np.pi / min(one.travel_time for one in parts)
            H = found.transfer(1j * np.concatenate((np.linspace(1e-3, 3, 400), [0.001, 0.5, 0.999])) * turn)
            weights = np.sqrt([one.area for one in parts] * (contacts // count or 1))[:contacts]
            scaled = H * weights[:, None] / weights[None, :]
            least = np.linalg.eigvalsh((scaled + np.conj(np.swapaxes(scaled, 1, 2))) / 2 + np.diag(1 / reach))[:, 0]
            assert least.min() > -1e-12 * np.abs(H).max()
            nearest[arrangement] = min(nearest.get(arrangement, 1), least.min() * reach.min())
    assert nearest["across-gap"] < 0.5


def test_bounds_that_are_not_covered_are_refused():
    with pytest.raises(AssumptionError, match=r"bound 1 is 1e.18 Pa/m, and the circle criterion covers"):
        varying_pressures(CASES["across-gap"], [F(10**18)])
    with pytest.raises(InputError, match="bounds has 1 values for 2 contacts"):
        varying_pressures(CASES["both-ends"], [F(1)])
    matched = replace(
        CASES["across-gap"], rods=(Rod(youngs_modulus=4, density=1, length=1, area=1, damping=2, compliance=1),) * 2
    )
    assert circle_reach(matched) == (None,)  # k = Z: no wave comes back
    assert varying_pressures(matched).certificate["conclusion"] == QUIET


def test_a_rod_without_damping_is_not_proved():
    undamped = rods("both-ends", 1, 2, damping=0)
    with pytest.raises(AssumptionError, match="number 1: its damping is 0"):
        rods_at_rest(undamped)
    text, shown = of_the_rods(undamped)
    assert shown == ()
    assert "nothing is proved: [[rod]] number 1" in text


@pytest.mark.slow
def test_the_report_on_the_scheme_says_what_is_proved_of_the_rods_and_follows_them():
    one = Rod(youngs_modulus=4, density=1, length=1, area=1, damping=1, compliance=1)
    thrown = (Scenario.parse(velocity=1), Scenario.parse(velocity=1))
    across = RodAssembly(
        arrangement="across-gap", rods=(one, one), compliances=(F(1),), gaps=(F(1),), scenarios=thrown, until=2.0
    )
    found = build_loop_report(assembly_loop(across, 1))
    assert "All other answers are about the upwind scheme. Of the rods themselves, two rods that meet" in str(found)
    assert "Computed: one motion of the rods themselves was followed for 2 s without a grid" in str(found)
    data = found.to_dict()
    assert RESTS in data["beyond"]
    assert [one["theorem"] for one in data["certificates"][-2:]] == ["rods-energy", "rods-circle"]
    # k = 1, Z = 2, E/L = 4: l = 3/4 of each rod, 3/2 across the gap, and 99 per cent of 2/3
    assert "stays within [0, K_i], K = 0.66 Pa/m" in data["beyond"]
    # both ends move with 1 m/s and close the gap of 1 m half a second later; masses of 1 kg m/s: 2 J/2 at the start
    assert "contact 1 was closed once, first from 0.5 s on" in data["beyond_observed"][1]
    assert "the energy was 1 J at the start" in data["beyond_observed"][2]
    schema = json.loads(resources.files("lure.analysis.report").joinpath("schema.json").read_text("utf-8"))
    jsonschema.Draft202012Validator(schema).validate(json.loads(json.dumps(data)))
    for spec in found.beyond_figures:
        spec.draw(ax=Figure().add_subplot())
    assert [spec.name for spec in found.beyond_figures] == ["rods-contacts", "rods-ends", "rods-energy"]


@pytest.mark.slow
def test_a_motion_that_gains_energy_is_no_report(monkeypatch):
    moving = replace(CASES["across-gap"], scenarios=(Scenario.parse(velocity=1),) * 2, until=1e-3)
    assert "contact 1 was closed once" in followed(moving)[0][1]
    monkeypatch.setattr(AssemblyMotion, "energies", lambda self, t: 1 + np.asarray(t))
    with pytest.raises(ContradictionError, match="the energy of two rods that meet across a gap grows"):
        followed(moving)


FILE = """
[contact]
arrangement = "both-ends"
compliance = 0.1
gap = [0.5, 0.25]
[[rod]]
youngs_modulus = 1
density = 1
length = 1
area = 1
damping = "Z"
u1 = 1
[simulation]
until = 2
"""


@pytest.mark.slow
def test_the_command_follows_several_contacts(lure, here):
    (here / "rods.toml").write_text(FILE, "utf-8")
    status, out, _ = lure("simulate", "rods.toml", "--json", "--plot", "run.svg", "-o", "run.nc")
    data = json.loads(out)
    assert status == 0
    assert data["contacts"][0] == []
    assert data["contacts"][1][0]["start"] == pytest.approx(0.25, abs=1e-14)  # thrown with 1 m/s over a gap of 0.25 m
    with xarray.open_dataset("run.nc") as kept:
        assert kept["sigma"].shape == (2001, 2)
        assert float(kept["sigma"][250, 1]) == pytest.approx(0.25, abs=1e-14)
    assert (here / "run.svg").exists()
    assert "Contact 1 was never closed." in lure("simulate", "rods.toml", "--until", "1")[1]


@pytest.mark.parametrize(
    ("options", "text", "why"),
    [
        (["-o", "rods.csv"], FILE, "output is 'rods.csv', and netCDF is written; give a name that ends in .nc"),
        (["--rigid"], FILE, "leave out the others, which are for one rod"),
        (["--samples", "1"], FILE, "samples is 1; give a whole number from 2"),
        (["--until", "-1"], FILE, "until is -1.0; give a time from 0"),
        ([], FILE.replace("u1 = 1\n", ""), "nothing moves: give a [[rod]] u0, u1 or g"),
        ([], FILE.replace("u1 = 1\n", 'u1 = "y"\n'), "rod.u1: unknown name 'y'"),
    ],
)
def test_what_cannot_be_followed_is_refused_in_a_sentence(lure, here, options, text, why):
    (here / "rods.toml").write_text(text, "utf-8")
    status, _, err = lure("simulate", "rods.toml", *options)
    assert (status, err.count("\n")) == (2, 1)
    assert why in err
