"""Periodic solutions of several channels in discrete time, and equilibria: found, made exact, checked by both."""

import json
from fractions import Fraction
from functools import cache

import pytest
from certificate_format import FORMAT
from depth import rarely
from tampering import assert_both_reject, edited

from lure import Diagonal, NonlinearityClass, Sector, SlopeBounds, as_plant, certify, max_sector, max_slope
from lure.analysis.certificates.channels import Plant
from lure.analysis.certificates.checker import MOVES, OTHERS, check
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.counterexamples.channel_samples import SampledOrbits
from lure.analysis.questions.channel_problem import channel_problem
from lure.analysis.questions.channel_refutations import orbits_refuting
from lure.analysis.wording import counterexample

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


@pytest.mark.slow
@pytest.mark.parametrize("name", rarely(["apart", "mixed", "coupled"], "mixed"))
def test_both_checkers_accept_the_orbit_found(name):
    alpha, shown = found(name)
    certificate = dict(shown.certificate)
    # what is proved of the coupled loop by windows of four samples is 0.89768
    assert 0 <= float(alpha) - (0.89768 if name == "coupled" else 175 / 192) < (2e-5 if name == "coupled" else 1e-9)
    assert certificate["proof"]["method"] == "sampled-orbit"
    assert certificate["conclusion"] == MOVES
    FORMAT.validate(certificate)
    check(certificate)
    assert recheck(certificate).accepted
    assert "period 3 samples" in counterexample(shown)


@pytest.mark.slow
def test_half_a_period_is_enough_where_all_are_odd():
    odd = NonlinearityClass(sector=Sector(0, 1), odd=True)
    alpha, shown = found("apart", odd, odd)
    assert float(alpha) == pytest.approx(0.6510416667, rel=1e-9)
    assert shown.certificate["proof"]["half"] is True
    assert recheck(dict(shown.certificate)).accepted
    lopsided = edited(shown.certificate, "proof", "nonlinearities", 0, "right", value="1/2")
    assert_both_reject(lopsided)


@pytest.mark.slow
def test_an_upper_bound_0_is_that_for_all_factors():
    # z^2 - z + 0.9 and z^2 - z/2 + 0.8 less a gain of [-1, 0]; there was a division by 0, and a warning is an error
    A = [[0, 1, 0, 0], [Fraction(-9, 10), 1, 0, 0], [0, 0, 0, 1], [0, 0, Fraction(-4, 5), Fraction(1, 2)]]
    sides = A, [[0, 0], [1, 0], [0, 0], [0, 1]], [[1, 0, 0, 0], [0, 0, 1, 0]], [[0, 0], [0, 0]]
    plant = Plant(*([[Fraction(v) for v in row] for row in side] for side in sides), discrete=True)
    ends = [Fraction(-1)] * 2, [Fraction(0)] * 2
    search = SampledOrbits(plant, *ends, [(0,), (1,)], ["monotone", "odd"], [False, True])
    factor, proof = next(search.found(Fraction(0), 10.0))
    assert factor == 0
    assert proof["method"] == "equilibrium"  # z = 1: 0.9 - 0.9


def test_a_sector_has_orbits_that_slopes_do_not_have():
    plant = as_plant(PLANTS["apart"], dt=1)
    bound = max_sector(plant, [Sector(0, 1)] * 2)
    assert bound.largest.low == pytest.approx(0.6510416, abs=1e-6)
    assert bound.refuted_at == pytest.approx(0.6510416, abs=1e-6)
    assert bound.witness.kind == "periodic orbit"


@pytest.mark.slow
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


# sigma = -M mu/(s + 1), or at z = 1 the same: sigma_1 = 2 phi_1 + phi_2, sigma_2 = -9/2 phi_1 - 3 phi_2 at rest.  One
# phi = g max(sigma, 0): sigma_1 = 2 phi_1, at rest for g = 1/2.  Odd: phi = (1, -1), sigma = (1, -3/2), a saturation.
# Equal gains: 1 + g - 3/2 g^2 = 0, g = (1 + 7^(1/2))/3 = 1.2153.
@cache
def resting(text, odd=False, turned=False):
    rows = [[f"({v})*{text}" for v in row] for row in (("-2", "-1"), ("9/2", "3"))]
    rows = [row[::-1] for row in rows[::-1]] if turned else rows
    plant, one = as_plant(rows, dt=1 if "z" in text else None), NonlinearityClass.slope_restricted(0, 1, odd=odd)
    known = Fraction(99999, 100000 if odd else 200000)  # what is proved: nothing else is looked for
    return orbits_refuting(channel_problem(plant, Diagonal((one, one), repeated=True)), known, 1.2)


@pytest.mark.parametrize(
    ("text", "odd", "turned"),
    [("1/(s+1)", False, False), ("1/(s+1)", True, False), ("1/(s+1)", False, True), ("0.5/(z-0.5)", False, False)],
)
def test_an_equilibrium_refutes_one_nonlinearity_in_two_channels_where_no_gain_does(text, odd, turned):
    alpha, shown = resting(text, odd, turned)
    assert float(alpha) == pytest.approx(1 if odd else 0.5, rel=1e-8)
    certificate = dict(shown.certificate)
    assert certificate["conclusion"] == OTHERS
    FORMAT.validate(certificate)
    check(certificate)
    assert recheck(certificate).accepted


@pytest.mark.slow_for("0.6")
@pytest.mark.parametrize("limit", [0.5, 0.6])
def test_an_equilibrium_is_an_answer_of_its_own(limit):
    plant = as_plant([["-2/(s+1)", "-1/(s+1)"], ["9/2/(s+1)", "3/(s+1)"]])
    one = NonlinearityClass.slope_restricted(0, limit)
    if limit == 0.6:
        shown = certify(plant, Diagonal((one, one), repeated=True))
        assert shown.verdict.name == "REFUTED"
        assert "has equilibria other than 0" in str(shown)
        return
    bound = max_slope(plant, Diagonal((one, one), repeated=True))
    assert bound.largest.low == pytest.approx(1, rel=1e-8)
    assert bound.refuted_at == pytest.approx(1, rel=1e-8)
    assert bound.witness.kind == "equilibrium"
    assert bound.witness.description.endswith("gives the loop other equilibria than 0")


@pytest.mark.parametrize(("beside", "refuted"), [("1/(s+2)", 0.5), ("1/(s*(s+2))", None)])
def test_an_equilibrium_of_a_part_is_one_of_the_whole_and_refutes_it_but_for_a_pole_at_0(beside, refuted):
    rows = [["-2/(s+1)", "-1/(s+1)", "0"], ["9/2/(s+1)", "3/(s+1)", "0"], ["0", "0", beside]]
    bound = max_slope(as_plant(rows), Diagonal((SLOPE,) * 3, repeated=(2, 1)))
    assert bound.criterion == "parts"
    assert bound.largest.low == pytest.approx(0.5, rel=1e-8)
    assert bound.refuted_at == (None if refuted is None else pytest.approx(refuted, rel=1e-8))
    assert refuted is None or recheck(dict(bound.refutation.certificate)).accepted


@pytest.mark.parametrize("text", ["1/(s+1)", "0.5/(z-0.5)"])
@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("proof", "state", 0), lambda v: str(Fraction(v) * 2)),
        (("proof", "state"), lambda v: ["0"] * len(v)),
        (("proof", "inputs", 0), lambda v: str(Fraction(v) + 1)),
        (("proof", "inputs"), lambda v: v[:1]),
        (("proof", "nonlinearities", 0, "points"), lambda v: [["0", "0"]]),
        (("laws", "channels"), lambda v: [one | {"odd": True} for one in v]),
        (("laws", "channels"), lambda v: [one | {"slope": ["0", "2/5"], "sector": ["0", "2/5"]} for one in v]),
        (("laws", "channels"), lambda v: [one | {"linear": True} for one in v]),
        (("system", "A", 0, 0), lambda v: str(Fraction(v) + Fraction(1, 100))),
        (("conclusion",), lambda _: MOVES),
    ],
)
def test_neither_accepts_an_equilibrium_that_was_changed(text, path, value):
    certificate = dict(resting(text)[1].certificate)
    assert_both_reject(edited(certificate, *path, value=value), stored=path == ("conclusion",))


@pytest.mark.parametrize("discrete", [False, True])
def test_an_equilibrium_refutes_nothing_where_the_gains_at_the_lower_bounds_leave_an_eigenvalue_0(discrete):
    # x_1' = -x_1 + phi(x_1) + u, x_2' = -phi(x_2): (1, 0) stays with phi = 1 at 1, and all are to come to equilibria
    certificate = dict(resting("1/(s+1)")[1].certificate)
    one = certificate["laws"]["channels"][0] | {"sector": ["0", "1"], "slope": ["0", "1"]}
    system = {"kind": "multivariable", "time": "discrete" if discrete else "continuous", "C": [["1", "0"], ["0", "1"]]}
    A, B = ([["0", "0"], ["0", "1"]] if discrete else [["-1", "0"], ["0", "0"]]), [["-1", "0"], ["0", "1"]]
    proof = {"method": "equilibrium", "nonlinearities": [{"points": [["0", "0"]], "left": "1", "right": "1"}] * 2}
    proof |= {"inputs": ["1", "0"], "state": ["1", "0"]}
    told = {"laws": {"channels": [one, one], "repeated": [1, 1]}, "proof": proof, "conclusion": OTHERS}
    critical = certificate | told | {"system": system | {"A": A, "B": B, "D": [["0", "0"], ["0", "0"]]}}
    assert_both_reject(critical)
    moved = critical | {"system": critical["system"] | {"A": [A[0], ["0", "1/2" if discrete else "-1"]]}}
    assert check(json.dumps(moved), draft=True)
    assert recheck(moved).accepted
