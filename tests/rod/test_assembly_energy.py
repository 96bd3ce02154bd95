"""Rods with several contacts themselves: the energy theorem's certificate, and what neither checker accepts."""

import copy
import json
from fractions import Fraction as F
from importlib import resources

import jsonschema
import pytest

from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.report.loop.build import build_loop_report
from lure.analysis.rod.assembly import of_the_rods, rods_at_rest
from lure.errors import AssumptionError
from lure.rod import Rod
from lure.rod.assembly import RodAssembly
from lure.rod.assembly_file import assembly_loop

SCHEMA = json.loads(resources.files("lure.analysis.certificates").joinpath("schema.json").read_text("utf-8"))
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
    jsonschema.Draft202012Validator(SCHEMA).validate(found)


def changed(draft, *path_and_value):
    *path, last, value = path_and_value
    found = copy.deepcopy(draft)
    at = found
    for key in path:
        at = at[key]
    at[last] = value
    return found


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
    with pytest.raises((Rejected, Malformed)):
        check(changed(accepted(name), *path))
    assert not recheck(changed(accepted(name), *path)).accepted


def test_a_rod_without_damping_is_not_proved():
    undamped = rods("both-ends", 1, 2, damping=0)
    with pytest.raises(AssumptionError, match="number 1: its damping is 0"):
        rods_at_rest(undamped)
    text, shown = of_the_rods(undamped)
    assert shown is None
    assert "nothing is proved: [[rod]] number 1" in text


def test_the_report_on_the_scheme_says_what_is_proved_of_the_rods():
    one = Rod(youngs_modulus=4, density=1, length=1, area=1, damping=1, compliance=1)
    across = RodAssembly(arrangement="across-gap", rods=(one, one), compliances=(F(1),), gaps=(F(0),))
    found = build_loop_report(assembly_loop(across, 1))
    assert "All other answers are about the upwind scheme. Of the rods themselves, two rods that meet" in str(found)
    data = found.to_dict()
    assert RESTS in data["beyond"]
    assert data["certificates"][-1]["theorem"] == "rods-energy"
    schema = json.loads(resources.files("lure.analysis.report").joinpath("schema.json").read_text("utf-8"))
    jsonschema.Draft202012Validator(schema).validate(json.loads(json.dumps(data)))
