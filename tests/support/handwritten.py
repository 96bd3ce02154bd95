"""Certificates written by hand for the tests of the second checker: the parts of a file, and its answer."""

import json
from fractions import Fraction as F
from functools import reduce
from math import gcd, lcm

from lure.analysis.certificates.second import recheck

ATTRACTS = "0 attracts every motion"
EQUILIBRIA = "every motion converges to the set of equilibria"
BOUNDED = "every motion is bounded"
DELAYED = "0 attracts every motion with inputs to the block and initial functions of finite energy"
AT_REST = "every motion of finite energy comes to rest, its end at a zero of the law"
GAINS = "every constant gain of the class makes the loop asymptotically stable"
NO_REST = "a loop of the class has a motion that does not converge to an equilibrium"
OTHERS = "a loop of the class has equilibria other than 0"


def transfer(numerator, denominator, time="continuous"):
    return {
        "kind": "transfer",
        "time": time,
        "numerator": [str(F(c)) for c in numerator],
        "denominator": [str(F(c)) for c in denominator],
    }


def nonlinearities(lower, upper, **more):
    """`slope=True` takes the bounds of the sector; other entries are added, or take the place of those."""
    ends = [str(lower), str(upper)]
    slope = ends if more.get("slope") is True else more.get("slope") or None
    return {"sector": ends, "odd": False, "time_varying": False, "linear": False} | more | {"slope": slope}


def whole(coefficients):
    """The same up to a positive factor, in coprime integers."""
    exact = [F(c) for c in coefficients]
    scale = lcm(*(c.denominator for c in exact))
    integers = [int(c * scale) for c in exact]
    shared = reduce(gcd, integers) or 1
    return [str(c // shared) for c in integers]


def polynomial(coefficients, variable="omega^2"):
    written = whole(coefficients)
    return {"method": "polynomial", "variable": variable, "coefficients": written, "limits": [written[0], written[-1]]}


def proved(system, class_, theorem, multiplier, proof, conclusion=ATTRACTS, **more):
    return {
        "format": "lure-certificate/1",
        "verdict": "PROVED",
        "convention": "sigma = H mu, mu = -phi(sigma)",
        "numbers": "rationals",
        "system": system,
        "laws": class_,
        "law": None,
        "theorem": theorem,
        "multiplier": multiplier,
        "conclusion": conclusion,
        "hypotheses": {"poles": "counted"},
        "proof": proof,
        **more,
    }


def refuted(system, class_, proof, conclusion=NO_REST):
    return proved(system, class_, "counterexample", {}, proof, conclusion, verdict="REFUTED")


def accepted(certificate):
    """The answer for the mapping, which is that for the text."""
    answer = recheck(certificate).accepted
    assert recheck(json.dumps(certificate)).accepted is answer
    return answer


def circle_of_oscillator(k, ratio=F(1, 2), **more):
    # k ((1 - x) + D/k) with D = (1 - x)^2 + 4 ratio^2 x
    system = transfer([1], [1, 2 * ratio, 1])
    coefficients = [1 + k, 4 * ratio**2 - 2 - k, 1]
    return proved(system, nonlinearities(0, k, **more), "circle", {}, polynomial(coefficients))


THIRD = transfer([1], [1, 3, 3, 1])


def state_space(A, b, c, d=0, time="continuous"):
    rows = [[str(v) for v in row] for row in A]
    sides = {"b": [str(v) for v in b], "c": [str(v) for v in c]}
    return {"kind": "state-space", "time": time, "A": rows, **sides, "d": str(d)}


def rod(k="1/5000", cells=10):
    """The rod of the paper: Z = 1.2 N s/m, Z^2 = 36/25."""
    found = {"kind": "rod", "E": "288000000", "rho": "8", "L": "1", "A": "1/40000", "k": k}
    return {**found, "kind": "rod-scheme", "cells": cells} if cells else found


def operator(kind, bound):
    return nonlinearities(-F(bound), bound, operator=kind, time_varying=kind != "linear time-invariant")


def loop(A, B, C, D, time="continuous"):
    sides = {name: [[str(v) for v in row] for row in side] for name, side in zip("ABCD", (A, B, C, D), strict=True)}
    return {"kind": "multivariable", "time": time, **sides}


def draft(system, channels, theorem, multiplier, proof, repeated=False):
    laws = {"channels": channels, "repeated": repeated}
    verdict = "REFUTED" if theorem == "counterexample" else "PROVED"
    found = {"verdict": verdict, "system": system, "laws": laws, "theorem": theorem, "proof": proof}
    return found | ({} if verdict == "REFUTED" else {"multiplier": multiplier})
