"""Periodic solutions around several channels: shown by both checkers, followed by another integrator, tampered."""

import copy
import json
from fractions import Fraction as F

import numpy as np
import pytest
from certificate_format import FORMAT
from scipy.integrate import solve_ivp
from tampering import assert_both_reject

from lure import Diagonal, NonlinearityClass, as_plant
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.questions.channel_problem import channel_problem
from lure.analysis.questions.channel_refutations import orbits_refuting
from lure.analysis.questions.channels import channel_bound

# Fitts's plant s^2/(((s + b)^2 + .81)((s + b)^2 + 1.21)), b = .03, whose linear loop is stable for every k >= 0 and
# which oscillates with steep saturations, and a lag that it meets weakly in both directions
DENOMINATOR = ["0.98191881", "0.121308", "2.0254", "0.12"]
A = [["0", "1", "0", "0", "0"], ["0", "0", "1", "0", "0"], ["0", "0", "0", "1", "0"]]
A += [[*(f"-{v}" for v in DENOMINATOR), "0"], ["0", "0", "0", "0", "-1"]]
B = [["0", "0"], ["0", "0"], ["0", "0"], ["1", "1/20"], ["0", "1"]]
C = [["0", "0", "1", "0", "1/20"], ["0", "0", "0", "0", "1/2"]]
LOOSE, DIRECT = [["0", "0"], ["0", "0"]], [["0", "1/10"], ["0", "1/4"]]


def asked(D, *, odd, repeated):
    classes = Diagonal([NonlinearityClass.slope_restricted(0, 1, odd=odd)] * 2, repeated=repeated)
    return channel_problem(as_plant((A, B, C, D)), classes, kind="slope")


@pytest.fixture(
    scope="module", params=["odd, apart", pytest.param("any, one for both, direct", marks=pytest.mark.slow)]
)
def found(request):
    apart = request.param == "odd, apart"
    problem = asked(LOOSE if apart else DIRECT, odd=apart, repeated=not apart)
    factor, shown = orbits_refuting(problem, F(1, 10), 20.0)
    return problem, factor, json.loads(json.dumps(dict(shown.certificate))), shown


@pytest.mark.slow
def test_both_checkers_accept_it_and_the_schema_knows_it(found):
    problem, factor, certificate, shown = found
    assert (certificate["verdict"], certificate["proof"]["method"]) == ("REFUTED", "flow-orbit")
    check(json.dumps(certificate))
    assert recheck(certificate).accepted
    FORMAT.validate(certificate)
    # odd, one channel alone: proved up to .6738, refuted from 1.4994 on; the lag adds little to either side
    assert 0.5 < factor < 1.7
    assert factor > 1.4 or not problem.odd
    told = str(channel_bound(problem, None, (factor, shown)))
    assert "makes the loop oscillate" in told
    assert "period" in told


def nonlinearity(one):
    points = [tuple(map(float, map(F, p))) for p in one["points"]]
    x, w = map(np.array, zip(*points, strict=True))
    left, right = float(F(one["left"])), float(F(one["right"]))

    def phi(s):
        inner = np.interp(s, x, w)
        return inner + left * min(s - x[0], 0) + right * max(s - x[-1], 0)

    return phi


@pytest.mark.slow
def test_another_integrator_comes_back_to_the_first_state(found):
    _, _, certificate, _ = found
    proof, system = certificate["proof"], certificate["system"]
    (a, b, c, d) = (np.array([[float(F(v)) for v in row] for row in system[name]]) for name in "ABCD")
    phis = [nonlinearity(one) for one in proof["nonlinearities"]]
    phis = phis * (2 // len(phis))

    def flow(_, x):
        sigma = c @ x
        for _ in range(40):  # sigma = C x - D phi(sigma): |D| slope < 1
            sigma = c @ x - d @ np.array([phi(s) for phi, s in zip(phis, sigma, strict=True)])
        return a @ x - b @ np.array([phi(s) for phi, s in zip(phis, sigma, strict=True)])

    x0, stay = [float(F(v)) for v in proof["state"]], float(sum(map(F, proof["durations"])))
    end = solve_ivp(flow, (0, stay), x0, rtol=1e-8, atol=1e-10).y[:, -1]
    assert end == pytest.approx((-1 if proof["half"] else 1) * np.array(x0), abs=1e-5)


def longer(proof):
    proof["durations"][0] = str(F(proof["durations"][0]) * F(1001, 1000))


def other_state(proof):
    proof["state"][1] = str(F(proof["state"][1]) + F(1, 1000))


@pytest.mark.parametrize("edit", [longer, other_state])
def test_a_contraction_is_around_a_solution_and_not_beside_it(found, edit):
    certificate = copy.deepcopy(found[2])
    edit(certificate["proof"])
    with pytest.raises(Rejected, match="no contraction"):
        check(json.dumps(certificate))
    assert recheck(certificate).accepted  # by Newton's method from there, to the same solution


def other_piece(proof):
    proof["pieces"][1] = list(proof["pieces"][0])


def two_at_once(proof):
    proof["pieces"][1] = [p + (p == q) * (1 if p == 0 else -1) for p, q in zip(*proof["pieces"][:2], strict=True)]


def steeper(proof):
    proof["nonlinearities"][0]["right"] = "100"


def one_too_few(proof):
    proof["nonlinearities"].pop()


def halved(proof):
    proof["half"] = not proof["half"]


def below_zero(proof):
    proof["pieces"][0] = [-1, 0]


def as_text(proof):
    proof["pieces"][0] = "01"


def no_channel(proof):
    proof["pieces"] = [row[:1] for row in proof["pieces"]]


EDITS = [other_piece, two_at_once, steeper, one_too_few]
EDITS += [halved, below_zero, as_text, no_channel]


@pytest.mark.parametrize("edit", EDITS)
def test_neither_checker_accepts_another_orbit(found, edit):
    certificate = copy.deepcopy(found[2])
    edit(certificate["proof"])
    assert_both_reject(certificate)


def smaller(certificate):
    for one in certificate["laws"]["channels"]:
        one["slope"][1] = one["sector"][1] = str(F(one["slope"][1]) * F(99, 100))


def gains(certificate):
    for one in certificate["laws"]["channels"]:
        one["linear"] = one["odd"] = True


def turned(certificate):
    certificate["system"]["B"][3][0] = "-1"


def in_samples(certificate):
    certificate["system"]["time"] = "discrete"


def proves(certificate):
    certificate["verdict"] = "PROVED"


def plays(certificate):
    for one in certificate["laws"]["channels"]:
        one |= {"memory": "play", "odd": False}


@pytest.mark.parametrize("edit", [smaller, gains, turned, in_samples, proves, plays])
def test_neither_checker_accepts_it_of_another_loop(found, edit):
    certificate = copy.deepcopy(found[2])
    edit(certificate)
    assert_both_reject(certificate)


def test_nonlinearities_that_are_not_odd_are_in_no_class_of_odd_ones(found):
    certificate = copy.deepcopy(found[2])
    for one in certificate["laws"]["channels"]:
        one["odd"] = True
    proof = certificate["proof"]
    if proof["half"]:
        for one in proof["nonlinearities"][:1]:
            one["points"][0] = [str(F(v) * F(11, 10)) for v in one["points"][0]]
        proof["half"] = False
    elif all(one["left"] == one["right"] and len(one["points"]) == 3 for one in proof["nonlinearities"]):
        assert proof["nonlinearities"][0]["points"][0] != proof["nonlinearities"][0]["points"][2]
    assert_both_reject(certificate)
