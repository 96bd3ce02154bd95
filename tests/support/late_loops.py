"""Drafts of certificates by hand about plants with known dead times: the parts of a file, and the value of a form."""

import cmath


def sector(low, high, **more):
    bounds = {"sector": [low, high], "slope": None, "odd": False, "time_varying": True, "linear": False}
    return bounds | more


def draft(system, classes, theorem, proof, multiplier=None):
    laws = {"channels": classes, "repeated": False}
    found = {"verdict": "PROVED", "system": system, "laws": laws, "theorem": theorem, "proof": proof}
    return found | ({"verdict": "REFUTED"} if multiplier is None else {"multiplier": multiplier})


def late(A, B, C, D, *parts):
    sides = {"A": A, "B": B, "C": C, "D": D, "late": [list(part) for part in parts]}
    return {"kind": "multivariable delay", "time": "continuous", **sides}


ONE, NO = [["1"]], [["0"]]
LAG = late([["-1"]], ONE, NO, NO, ("1", ONE))  # exp(-s)/(s + 1)
INTEGRATOR = late([["0"]], ONE, NO, NO, ("1", ONE))  # exp(-s)/s


def value(form, omega):
    """Of a sum of ``(u + i v) omega^n exp(-i omega tau)``."""
    return sum((u + 1j * v) * omega**n * cmath.exp(-1j * omega * float(tau)) for (tau, n), (u, v) in form.items())
