"""One small accepted certificate of every theorem and of every kind of proof, for the tests that attack the checker.

They are kept in certificates.json, so that a certificate once accepted stays one; run as a script, this file writes
them again, after a change of the format or of the words of a hypothesis.
"""

import copy
import json
from fractions import Fraction
from functools import cache
from pathlib import Path

from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.drafts import complete_and_check, completed
from lure.analysis.certificates.matrix import matrix_draft
from lure.analysis.certificates.refutations import flow_orbit_proof
from lure.analysis.counterexamples.linear import companion
from lure.analysis.counterexamples.piecewise import Flow, PiecewiseLoop, returns
from lure.analysis.theorems.homogeneous import homogeneous_criterion, homogeneous_proof
from lure.classes import Sector
from lure.nonlinearities.piecewise_linear import Graph
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace

POLYNOMIAL, STRUCTURE = {"method": "polynomial"}, {"method": "structure"}


def texts(numbers):
    return [str(Fraction(v)) for v in numbers.split()]


def transfer(numerator, denominator, time="continuous"):
    return {"kind": "transfer", "time": time, "numerator": texts(numerator), "denominator": texts(denominator)}


def delayed(terms, denominator):
    return {
        "kind": "delay",
        "terms": [[str(Fraction(tau)), texts(n)] for tau, n in terms],
        "denominator": texts(denominator),
    }


def nonlinearities(lower, upper, *, slope=None, odd=False, time_varying=False, linear=False):
    """`slope=True`: the slopes have the bounds of the sector."""
    ends = [str(lower), str(upper)]
    return {
        "sector": ends,
        "slope": list(ends) if slope is True else slope,
        "odd": odd,
        "time_varying": time_varying,
        "linear": linear,
    }


def draft(system, given, theorem, multiplier, proof=POLYNOMIAL, **more):
    return {
        "verdict": "PROVED",
        "system": system,
        "laws": given,
        "theorem": theorem,
        "multiplier": multiplier,
        "proof": proof,
        **more,
    }


def refutation(system, given, proof):
    return draft(system, given, "counterexample", {}, proof, verdict="REFUTED")


def matrix(block, upper, **more):
    """A proof by a matrix of the exact numbers that the block is made of."""
    return matrix_draft(block, Fraction(upper), **more)


THIRD = transfer("1", "1 3 2 0")  # popov: below 6, circle: below 4/3; linear gains: below 6
SERVO = transfer("1", "1 2 27 8 0")  # linear gains: below 92, by Routh's array; popov: below 15.4
OSCILLATOR = transfer("1", "1 1 1")  # circle: below 3; every linear gain >= 0 is stable
LAG = transfer("1", "1 3 3 1")  # linear gains: below 8
DISCRETE = transfer("1", "1 -1/2 0", "discrete")
DEAD = delayed([("1", "1")], "1 1")
ROD = {"kind": "rod", "E": "4", "rho": "9", "L": "3", "A": "1/2", "k": "5"}  # Z = A sqrt(rho E) = 3
SCHEME = {**ROD, "kind": "rod-scheme", "cells": 3}
BIPROPER = transfer("1 2", "1 1")  # H(inf) = 1
LAG_1, STEEP = transfer("1", "1 1"), transfer("1/2 1", "1 -1/2", "discrete")
COUPLED = {  # linear gains: below 2
    "kind": "state-space",
    "time": "continuous",
    "A": [["-1", "0"], ["1", "-2"]],
    "b": ["1", "0"],
    "c": ["0", "-1"],
    "d": "0",
}
QUARTERS = [["0", "1/2"], ["1/2", "1"], ["1", "3/2"], ["3/2", "2"]]
LOADED = transfer("-1/2 0 0", "1 -1/2 0", "discrete")
LEAD = transfer("1/2 0 0", "1 -1/2 0", "discrete")
LIMITER = {"kind": "piecewise-linear", "points": [["-1", "-1"], ["0", "0"], ["1", "1"]], "left": "0", "right": "1/2"}
TANH = {"kind": "tanh", "height": "1/2", "rate": "2"}
HALF_KERNEL = {"coefficient": "1/2", "rate": "1", "order": 1, "side": "causal"}
FAR_KERNEL = {"coefficient": "-1/4", "rate": "2", "order": 2, "side": "anticausal"}
QUARTIC = {  # in x1^2, x1 x2, x2^2
    "method": "powers",
    "power": 2,
    "P": [["24"], ["6", "11"], ["7", "4", "3"]],
    "lower": [["0"], ["0", "16"], ["-8", "0", "0"]],
    "upper": [["0"], ["0", "30"], ["-15", "0", "0"]],
}
SETTLING = {  # in the same, of 1/(s^2 + s): 2 (z^4 + 2 z^2 w^2 - z w^3 + w^4), z = x1 + x2, w = x2
    "method": "powers",
    "power": 2,
    "P": [["2"], ["4", "12"], ["2", "7", "6"]],
    "lower": [["0"], ["0", "0"], ["0", "0", "0"]],
    "upper": [["0"], ["0", "0"], ["0", "0", "0"]],
}
THREE_BOXES = {"method": "cover", "boxes": [["0", "2"], ["2", "4"], ["4", "7"]], "order": 14}


def powers_proof(plant, upper):
    """A form of degree 4 that the search finds for the sector [0, upper]."""
    asked = homogeneous_criterion(plant, Sector(0, upper))
    return homogeneous_proof(plant, asked, upper)


def on_both(sides):
    """y = x1 of a state (x1, x2, 1), on one of the sides at both ends."""
    return [Fraction(1), Fraction(0), Fraction(0)], sides, True, True


def flow_orbit(direct=Fraction(0), *, half):
    """D + s/(s^2 - s/5 + 1) with a dead zone: energy is fed in while |sigma| < 1, and a periodic motion is left."""
    top = [direct, 1 - direct / 5, direct] if direct else [1, 0]
    block, graph = RationalPlant(top, [1, Fraction(-1, 5), 1]), Graph.through([(-1, 0), (0, 0), (1, 0)], 1, 1)
    stays = Flow(PiecewiseLoop.of(companion(block), graph)).passages([2.0, 0.0], 400.0)
    first, last = returns(stays)
    turn = stays[first : (first + last) // 2 if half else last]
    record = {
        "points": [["-1", "0"], ["0", "0"], ["1", "0"]],
        "left_slope": "1",
        "right_slope": "1",
        "pieces": [stay.piece for stay in turn],
        "durations": [stay.duration for stay in turn],
        "state": [float(v) for v in turn[0].state],
        "half": half,
    }
    system, given = transfer(" ".join(map(str, top)), "1 -1/5 1"), nonlinearities(0, 1, slope=True)
    return refutation(system, given, flow_orbit_proof(system, given, record))


DRAFTS = {
    "popov": lambda: draft(THIRD, nonlinearities(0, "59/10"), "popov", {"theta": "3/2"}),
    "popov, shifted, piecewise linear": lambda: draft(
        THIRD, nonlinearities("1/4", "2"), "popov", {"theta": "1"}, law={**LIMITER, "left": "1/2"}
    ),
    "popov, every finite bound": lambda: draft(OSCILLATOR, nonlinearities(0, "finite"), "popov", {"theta": "1"}),
    "popov, tanh": lambda: draft(THIRD, nonlinearities(0, "5"), "popov", {"theta": "3/2"}, law=TANH),
    "popov, negative theta": lambda: draft(
        transfer("1 0 0", "1 2 2 1"), nonlinearities(0, "17/2"), "popov", {"theta": "-1/10"}
    ),
    "circle": lambda: draft(OSCILLATOR, nonlinearities(0, "29/10", time_varying=True), "circle", {}),
    "circle, critical": lambda: draft(THIRD, nonlinearities(0, "5/4", time_varying=True), "circle", {}),
    "circle, mirrored": lambda: draft(
        transfer("-1", "1 1"), nonlinearities("-inf", "1/2"), "circle", {"mirrored": True}
    ),
    "circle, no bound": lambda: draft(transfer("1 1", "1 3 3"), nonlinearities(0, "inf"), "circle", {}),
    "circle, discrete": lambda: draft(DISCRETE, nonlinearities("-1/4", "3/5", time_varying=True), "circle", {}),
    "circle, discrete critical": lambda: draft(transfer("1", "1 -1", "discrete"), nonlinearities(0, 1), "circle", {}),
    "circle, dead time": lambda: draft(DEAD, nonlinearities(0, "3/4"), "circle", {}, THREE_BOXES),
    "popov, dead time": lambda: draft(DEAD, nonlinearities(0, "1"), "popov", {"theta": "1/8"}, THREE_BOXES),
    "off-axis": lambda: draft(OSCILLATOR, nonlinearities(0, "4", slope=True), "off-axis-circle", {"alpha": "1/2"}),
    "park": lambda: draft(OSCILLATOR, nonlinearities(0, "4", slope=True), "park", {"theta": "1/2", "tau": "1/4"}),
    "off-axis, critical": lambda: draft(
        THIRD, nonlinearities(0, "11/2", slope=True), "off-axis-circle", {"alpha": "2"}
    ),
    "park, critical": lambda: draft(SERVO, nonlinearities(0, "80", slope=True), "park", {"theta": "913", "tau": "100"}),
    "zames-falb, critical": lambda: draft(
        SERVO,
        nonlinearities(0, "90", slope=True),
        "zames-falb",
        {"theta": "-1/350", "kernels": [{"coefficient": "1", "rate": "20", "order": 3, "side": "causal"}]},
    ),
    "zames-falb, discrete critical": lambda: draft(
        transfer("1", "1 -1 1/2 -1/2", "discrete"),
        nonlinearities(0, "17/20", slope=True),
        "zames-falb",
        {"taps": [[2, "1/2"], [-2, "2/5"]]},
    ),
    "zames-falb": lambda: draft(
        OSCILLATOR, nonlinearities(0, "4", slope=True), "zames-falb", {"theta": "1/2", "kernels": [HALF_KERNEL]}
    ),
    "zames-falb, odd": lambda: draft(
        OSCILLATOR,
        nonlinearities(0, "7/2", slope=True, odd=True),
        "zames-falb",
        {"theta": "1/2", "kernels": [HALF_KERNEL, FAR_KERNEL]},
    ),
    "zames-falb, dead time": lambda: draft(
        OSCILLATOR,
        nonlinearities(0, "7/2", slope=True),
        "zames-falb",
        {"theta": "1/2", "kernels": [{"coefficient": "1/8", "delay": "1/2"}]},
        THREE_BOXES,
    ),
    "zames-falb, discrete": lambda: draft(
        DISCRETE, nonlinearities(0, "4/5", slope=True), "zames-falb", {"taps": [[1, "1/2"], [-2, "1/8"]]}
    ),
    "tsypkin": lambda: draft(DISCRETE, nonlinearities(0, "4/5", slope=["0", "inf"]), "tsypkin", {"q": "1/4"}),
    "tsypkin-odd": lambda: draft(
        transfer("1", "1 1/2 0", "discrete"),
        nonlinearities(0, "4/5", slope=["0", "inf"], odd=True),
        "tsypkin-odd",
        {"q": "1/4"},
    ),
    "jury-lee": lambda: draft(DISCRETE, nonlinearities(0, "4/5", slope=["-inf", "4/5"]), "jury-lee", {"q": "1/4"}),
    "homogeneous-lyapunov": lambda: draft(
        OSCILLATOR, nonlinearities(0, "7/2", time_varying=True), "homogeneous-lyapunov", {}, QUARTIC
    ),
    "homogeneous-lyapunov, critical": lambda: draft(
        transfer("1", "1 1 0"), nonlinearities(0, "5/4", time_varying=True), "homogeneous-lyapunov", {}, SETTLING
    ),
    "homogeneous-lyapunov, discrete": lambda: draft(  # circle: below 5^(-1/2); linear gains: below 1/2
        transfer("1", "1 -1 1/2", "discrete"),
        nonlinearities(0, "12/25", time_varying=True),
        "homogeneous-lyapunov",
        {},
        powers_proof(RationalPlant([1], [1, -1, Fraction(1, 2)], 1), Fraction(12, 25)),
    ),
    "hurwitz": lambda: draft(LAG, nonlinearities(0, "79/10", linear=True), "hurwitz", {}),
    "circle, matrix": lambda: {
        **matrix(RationalPlant([1], [1, 1, 1]), "5/2"),
        "laws": nonlinearities(0, "5/2", time_varying=True),
    },
    "circle, state space": lambda: matrix(StateSpace([[-1.0, 2.0], [-2.0, -1.0]], [0.0, 1.0], [1.0, 0.5]), 1),
    "popov, matrix": lambda: matrix(RationalPlant([1], [1, 3, 2, 0]), 5, theta=Fraction(3, 2)),
    "popov, matrix, no bound": lambda: matrix_draft(RationalPlant([1, 2], [1, 1]), "inf", theta=Fraction(0)),
    "circle, discrete matrix": lambda: matrix(RationalPlant([1], [1, Fraction(-1, 2), 0], 1), "1/2"),
    "rod-popov": lambda: draft(SCHEME, nonlinearities(0, "inf"), "rod-popov", {"theta": "7"}, STRUCTURE),
    "rod-circle": lambda: draft(SCHEME, nonlinearities(0, "1/8", time_varying=True), "rod-circle", {}, STRUCTURE),
    "rod-energy": lambda: draft(SCHEME, nonlinearities(0, "inf"), "rod-energy", {}, STRUCTURE),
    "rod itself": lambda: draft(ROD, nonlinearities(0, "inf"), "rod-energy", {}, STRUCTURE),
    "linear gain": lambda: refutation(
        LAG, nonlinearities(0, 9, linear=True), {"method": "linear-gain", "gain": "17/2"}
    ),
    "linear gain, discrete": lambda: refutation(
        DISCRETE, nonlinearities(0, 2), {"method": "linear-gain", "gain": "5/4"}
    ),
    "linear gain, dead time": lambda: refutation(
        DEAD, nonlinearities(-2, 0), {"method": "linear-gain", "gain": "-3/2"}
    ),
    "crossing, rational": lambda: refutation(
        THIRD, nonlinearities(0, 9), {"method": "crossing", "gains": ["5", "7"], "frequencies": ["7/5", "3/2"]}
    ),
    "crossing": lambda: refutation(
        DEAD, nonlinearities(0, 3), {"method": "crossing", "gains": ["2", "5/2"], "frequencies": ["2", "41/20"]}
    ),
    # V = -2 x1 x2 falls for 4 g > 9: -(A'P + PA) = [[2, -3], [-3, 2 g]]
    "matrix gain": lambda: refutation(
        COUPLED,
        nonlinearities(0, 9),
        {"method": "matrix-gain", "gain": "5/2", "P": [["0"], ["-1", "0"]], "start": ["1", "1"]},
    ),
    # V = -x^2, x(t+1) = (1/2 - g) x(t)
    "matrix gain, discrete": lambda: refutation(
        transfer("1", "1 -1/2", "discrete"),
        nonlinearities(0, 2),
        {"method": "matrix-gain", "gain": "7/4", "P": [["-1"]], "start": ["1"]},
    ),
    "switched gain": lambda: refutation(
        transfer("1", "1 1/10 1"),
        nonlinearities(0, 3, time_varying=True),
        {"method": "switched-gain", "gains": ["3", "0"], "times": ["4/5", "3/2"], "squarings": 3, "bits": 96},
    ),
    "switched gain, discrete": lambda: refutation(
        DISCRETE,
        nonlinearities(0, "3/2", time_varying=True),
        {"method": "switched-gain", "gains": ["3/2", "0", "3/2"], "squarings": 4, "bits": 96},
    ),
    "orbit": lambda: refutation(
        transfer("1", "1 0", "discrete"),
        nonlinearities(0, 1, slope=True),
        {
            "method": "orbit",
            "points": [["0", "0"]],
            "left": "1",
            "right": "1",
            "u": ["-1", "1"],
            "sigma": ["1", "-1"],
        },
    ),
    # H = (1 - z)/(2 z): sigma_0 = -u_0/2 + u_1/2 with u_1 = -u_0
    "orbit, chords": lambda: refutation(
        transfer("-1/2 1/2", "1 0", "discrete"),
        nonlinearities(0, 1),
        {
            "method": "orbit",
            "points": [["-1", "-1"], ["-2/3", "0"], ["0", "0"], ["2/3", "0"], ["1", "1"]],
            "left": "0",
            "right": "0",
            "u": ["-1", "1"],
            "sigma": ["1", "-1"],
        },
    ),
    # sigma_t + sigma_(t-1)/2 = u_t + u_(t-1) + 5/2 u_(t-2)
    "orbit, three samples": lambda: refutation(
        transfer("1 1 5/2", "1 1/2 0", "discrete"),
        nonlinearities(0, 1, slope=True),
        {
            "method": "orbit",
            "points": [["-5", "-1"], ["-1", "-1"], ["0", "0"], ["3", "3"]],
            "left": "0",
            "right": "0",
            "u": ["-3", "1", "1"],
            "sigma": ["3", "-1", "-5"],
        },
    ),
    "equilibrium": lambda: refutation(
        DISCRETE,
        nonlinearities(-1, 0),
        {"method": "orbit", "points": [["0", "0"]], "left": "-1/2", "right": "-1/2", "u": ["1/2"], "sigma": ["1"]},
    ),
    "flow-orbit": lambda: flow_orbit(half=False),
    "flow-orbit, half": lambda: flow_orbit(half=True),
    "flow-orbit, direct": lambda: flow_orbit(Fraction(1, 4), half=True),
    "rod, refuted": lambda: refutation({**ROD, "k": "-1"}, nonlinearities(0, "inf"), STRUCTURE),
}


STORED = Path(__file__).with_name("certificates.json")


@cache
def stored():
    return json.loads(STORED.read_text("ascii"))


def certificate(name):
    """The certificate as it was written; not to be changed: take a deep copy."""
    return stored()[name]


def changed(name, changes):
    """The draft of a certificate with parts replaced; a path is keys joined by points."""
    made = copy.deepcopy(certificate(name))
    if made["proof"]["method"] == "polynomial":
        made["proof"] = {"method": "polynomial"}
    for path, value in changes.items():
        *above, last = path.split(".")
        place = made
        for key in above:
            place = place[int(key) if key.isdigit() else key]
        place[last] = value
    return made


def accepted(made):
    """What the checker makes of a draft with the polynomial, conclusion and hypotheses that it would want, or None."""
    try:
        return complete_and_check(made)
    except (Rejected, Malformed):
        return None


if __name__ == "__main__":
    STORED.write_text(json.dumps({name: completed(make()) for name, make in DRAFTS.items()}, indent=1) + "\n", "ascii")
