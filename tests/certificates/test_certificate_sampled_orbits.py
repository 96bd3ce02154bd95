"""Periodic solutions of several channels in discrete time: found, made exact, and checked by both checkers."""

import json
from fractions import Fraction
from functools import cache
from importlib import resources

import jsonschema
import pytest
from tampering import assert_both_reject, edited

from lure import Diagonal, NonlinearityClass, Sector, SlopeBounds, as_plant, certify, max_sector
from lure.analysis.certificates.channels import Plant
from lure.analysis.certificates.checker import MOVES, check
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.counterexamples.channel_samples import SampledOrbits
from lure.analysis.questions.channel_members import orbits_refuting
from lure.analysis.questions.channel_problem import channel_problem
from lure.analysis.wording import counterexample

SCHEMA = json.loads(resources.files("lure.analysis.certificates").joinpath("schema.json").read_text("utf-8"))
SIX = "(2*z+0.92)/(z^2-0.5*z)"  # with slopes in [0, k] an orbit of three samples exists from k = 175/192 on, exactly
SLOPE = NonlinearityClass.slope_restricted(0, 1)
PLANTS = {
    "apart": [[SIX, "0"], ["0", "0.1/(z-0.5)"]],
    "mixed": [[f"0.5*{SIX}", f"0.5*{SIX}"], [f"0.5*{SIX}", f"0.5*{SIX}"]],  # one loop, the mean of both phi
    "coupled": [["-0.5/(z-0.5)", "0.2/z"], ["-0.1/(z+0.3)", SIX]],
}


@cache
def found(name, *classes, most=1.08):
    plant = as_plant(PLANTS[name], dt=1)
    asked = channel_problem(plant, classes or (SLOPE, SLOPE))
    return orbits_refuting(asked, Fraction(1, 10), most)


@pytest.mark.parametrize("name", ["apart", "mixed", "coupled"])
def test_both_checkers_accept_the_orbit_found(name):
    alpha, shown = found(name)
    certificate = dict(shown.certificate)
    # what is proved of the coupled loop by windows of four samples is 0.89768
    assert 0 <= float(alpha) - (0.89768 if name == "coupled" else 175 / 192) < (2e-5 if name == "coupled" else 1e-9)
    assert certificate["proof"]["method"] == "sampled-orbit"
    assert certificate["conclusion"] == MOVES
    jsonschema.Draft202012Validator(SCHEMA).validate(certificate)
    check(certificate)
    assert recheck(certificate).accepted
    assert "period 3 samples" in counterexample(shown)


def test_half_a_period_is_enough_where_all_are_odd():
    odd = NonlinearityClass(sector=Sector(0, 1), odd=True)
    alpha, shown = found("apart", odd, odd)
    assert float(alpha) == pytest.approx(0.6510416667, rel=1e-9)
    assert shown.certificate["proof"]["half"] is True
    assert recheck(dict(shown.certificate)).accepted
    lopsided = edited(shown.certificate, "proof", "nonlinearities", 0, "right", value="1/2")
    assert_both_reject(lopsided)


def test_an_upper_bound_0_is_that_for_all_factors():
    # z^2 - z + 0.9 and z^2 - z/2 + 0.8 less a gain of [-1, 0]; there was a division by 0, and a warning is an error
    A = [[0, 1, 0, 0], [Fraction(-9, 10), 1, 0, 0], [0, 0, 0, 1], [0, 0, Fraction(-4, 5), Fraction(1, 2)]]
    sides = A, [[0, 0], [1, 0], [0, 0], [0, 1]], [[1, 0, 0, 0], [0, 0, 1, 0]], [[0, 0], [0, 0]]
    plant = Plant(*([[Fraction(v) for v in row] for row in side] for side in sides), discrete=True)
    ends = [Fraction(-1)] * 2, [Fraction(0)] * 2
    search = SampledOrbits(plant, *ends, [(0,), (1,)], ["monotone", "odd"], [False, True])
    factor, proof = next(search.found(Fraction(0), 10.0))
    assert factor == 0
    assert proof["method"] == "sampled-orbit"


def test_a_sector_has_orbits_that_slopes_do_not_have():
    plant = as_plant(PLANTS["apart"], dt=1)
    bound = max_sector(plant, [Sector(0, 1)] * 2)
    assert bound.largest.low == pytest.approx(0.6510416, abs=1e-6)
    assert bound.refuted_at == pytest.approx(0.6510416, abs=1e-6)
    assert bound.witness.kind == "periodic orbit"


def test_one_class_is_refuted_as_it_stands():
    shown = certify(as_plant(PLANTS["apart"], dt=1), [SlopeBounds(0, 0.92)] * 2)
    assert shown.verdict.name == "REFUTED"
    assert shown.shown.certificate["proof"]["proof"]["method"] == "orbit"  # of one of the loops side by side


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("laws", "channels", 0, "slope"), ["0", "9/10"]),
        (("laws", "channels", 0, "odd"), True),
        (("laws", "channels", 0, "linear"), True),
        (("laws", "repeated"), [2]),
        (("proof", "half"), True),
        (("proof", "half"), 0),
        (("proof", "inputs"), lambda rows: rows[:2]),
        (("proof", "inputs"), lambda rows: rows[1:] + rows[:1]),
        (("proof", "inputs", 0, 1), lambda v: str(Fraction(v) + 1)),
        (("proof", "state", 0), lambda v: str(Fraction(v) * 2)),
        (("proof", "nonlinearities", 0, "left"), "-1"),
        (("proof", "nonlinearities", 0, "points", 0, 1), lambda v: str(Fraction(v) * Fraction(99, 100))),
        (("proof", "nonlinearities"), lambda rows: rows[:1]),
        (("system", "time"), "continuous"),
        (("system", "A", 0, 0), lambda v: str(Fraction(v) + Fraction(1, 100))),
        (("system", "D", 0, 0), "1"),
        (("conclusion",), lambda _: "0 attracts every motion"),
    ],
)
def test_neither_accepts_what_was_changed(path, value):
    certificate = dict(found("apart")[1].certificate)
    assert_both_reject(edited(certificate, *path, value=value), stored=path == ("conclusion",))


def test_a_state_at_rest_is_no_orbit():
    # x+ = x/2 + 1/2 phi with phi = x: every point is at rest, and one sample is a period
    certificate = dict(found("apart")[1].certificate)
    still = {"kind": "multivariable", "time": "discrete", "A": [["1/2"]], "B": [["-1/2"]], "C": [["1"]], "D": [["0"]]}
    laws = {
        "channels": [certificate["laws"]["channels"][0] | {"sector": ["0", "1"], "slope": ["0", "1"]}],
        "repeated": [1],
    }
    line = {"points": [["0", "0"]], "left": "1", "right": "1"}
    turned = still | {"B": [["3/2"]]}  # x+ = -x
    proof = {"method": "sampled-orbit", "nonlinearities": [line], "inputs": [["1"]], "state": ["1"], "half": False}
    assert_both_reject(certificate | {"system": still, "laws": laws, "proof": proof})
    moves = certificate | {"system": turned, "laws": laws, "proof": proof | {"half": True}}
    assert check(json.dumps(moves), draft=True)


def test_one_nonlinearity_in_both_channels_has_one_graph():
    asked = channel_problem(as_plant(PLANTS["coupled"], dt=1), Diagonal((SLOPE, SLOPE), repeated=True))
    alpha, shown = orbits_refuting(asked, Fraction(1, 10), 1.08)
    assert len(shown.certificate["proof"]["nonlinearities"]) == 1
    assert found("coupled")[0] < alpha < Fraction(9, 10)
    assert recheck(dict(shown.certificate)).accepted
