"""One gain, or one scalar operator, in several channels: Hermitian multipliers by hand, falsified and tampered with."""

from fractions import Fraction as F
from json import dumps, loads

import numpy as np
import pytest
from certificate_format import FORMAT
from tampering import assert_both_reject, edited

from lure.analysis.certificates import frequencies
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.drafts import complete_and_check, contains
from lure.analysis.certificates.second.frequencies import read_multiplier
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.certificates.second.reading import NotShown

SCALAR = "scalar linear time-invariant"


def one(bound, **more):
    bounds = [str(-F(bound)), str(bound)]
    return {"sector": bounds, "slope": None, "odd": False, "time_varying": False, "linear": False} | more


def operator(bound, kind=SCALAR):
    return one(bound, operator=kind)


def gain(bound):
    return one(bound, slope=[str(-F(bound)), str(bound)], odd=True, linear=True)


def kernel(i, j, c, side, order=1):
    return {"channels": [i, j], "coefficient": str(c), "rate": "1", "order": order, "side": side}


def draft(system, laws, gamma, kernels, repeated=True):
    rows = {name: [[str(v) for v in row] for row in side] for name, side in zip("ABCD", system, strict=True)}
    return {
        "verdict": "PROVED",
        "system": {"kind": "multivariable", "time": "continuous", **rows},
        "laws": {"channels": laws, "repeated": repeated},
        "theorem": "matrix-zames-falb",
        "multiplier": {"gamma": gamma, "theta": ["0", "0"], "kernels": kernels},
        "proof": {"method": "determinant"},
    }


# H = [[1, 10], [0, 1]]/(s + 1): the eigenvalue of H is 1/(s + 1), of modulus <= 1 = 1/r, while |H| is 10.1 at 0.
# D = diag(1, d): r^2 H*DH < D at 0 for r = 9/10 if [[.81, 8.1], [8.1, 81 + .81 d]] < diag(1, d): from d = 2244 on
SHEAR = ([[-1, 0], [0, -1]], [[1, 10], [0, 1]], [[1, 0], [0, 1]], [[0, 0], [0, 0]])
APART = draft(SHEAR, [operator("9/10")] * 2, [["1", "0"], ["0", "3000"]], [])
EVEN = [kernel(1, 2, 1, "causal"), kernel(2, 1, 1, "anticausal")]  # D_12 = -1/(1 + i omega): |D_12|^2 < 3000
COUPLED = APART | {"multiplier": APART["multiplier"] | {"kernels": EVEN}}
# H = [[0, -1], [1, 0]]/(s + 1) = J/(s + 1) and one gain g in [-2, 2]: (s + 1)^2 + g^2 is stable for every g, though
# |H(0)| = 1.  M = 1 + 10 J has the Hermitian part 1, and the skew part shows what |H| does not.
TURN = ([[-1, 0], [0, -1]], [[0, -1], [1, 0]], [[1, 0], [0, 1]], [[0, 0], [0, 0]])
SKEW = draft(TURN, [gain(2)] * 2, [["1", "10"], ["-10", "1"]], [])
PROOFS = {"apart": APART, "coupled": COUPLED, "skew": SKEW}
# an eigenvalue of J/(s + 1) at s = i is i/(1 + i), so that delta = i - 1 = sqrt 2 e^(3 pi i/4) there; (s - a)/(s + a)
# has this angle for a = 1/tan(pi/8) = 2.414
PASSES = {k: v for k, v in draft(TURN, [operator("3/2")] * 2, [], []).items() if k != "multiplier"} | {
    "verdict": "REFUTED",
    "theorem": "counterexample",
    "proof": {"method": "linear-members", "gains": ["0", "0"], "operators": [{"delta": ["3/2", "12/5"]}]},
}


@pytest.mark.parametrize("made", [*PROOFS.values(), PASSES])
def test_what_is_derived_by_hand_is_accepted_by_both_checkers(made):
    shown = complete_and_check(made)
    assert recheck(dict(shown.certificate)).accepted
    FORMAT.validate(loads(dumps(dict(shown.certificate))))


TAMPERED = [
    (APART, "laws", "channels", [operator("9/10", "linear time-invariant")] * 2),  # |H| = 10
    (COUPLED, "laws", "repeated", False),
    (APART, "laws", "channels", [operator("101/100")] * 2),
    (APART, "multiplier", "gamma", [["1", "1"], ["0", "3000"]]),
    (APART, "multiplier", "gamma", [["-1", "0"], ["0", "3000"]]),
    (APART, "multiplier", "gamma", [["1", "60"], ["60", "3000"]]),  # 60^2 > 3000
    (COUPLED, "multiplier", "kernels", EVEN[:1]),
    (COUPLED, "multiplier", "kernels", [EVEN[0], EVEN[1] | {"side": "causal"}]),
    (COUPLED, "multiplier", "kernels", [one | {"coefficient": "60"} for one in EVEN]),
    (COUPLED, "laws", "channels", [operator("9/10", "linear time-invariant")] * 2),
    (SKEW, "laws", "channels", [gain(2) | {"linear": False}] * 2),
    (SKEW, "laws", "repeated", False),
    (SKEW, "multiplier", "gamma", [["1", "10"], ["-12", "1"]]),  # [[1, -1], [-1, 1]] is singular
    (SKEW, "multiplier", "gamma", [["1", "0"], ["0", "1"]]),
    (SKEW, "multiplier", "kernels", [kernel(1, 2, 2, "causal", 2)]),
    (PASSES, "proof", "operators", 0, "delta", ["8/5", "12/5"]),  # of a larger norm
    (PASSES, "proof", "operators", 0, "delta", ["3/2", None]),  # s + 1 + 3 J/2 is stable
    (PASSES, "proof", "operators", 0, "delta", ["3/2"]),
    (PASSES, "proof", "operators", 0, {"left": [["3/2", None]] * 2, "right": [["1", None]] * 2}),
    (PASSES, "laws", "channels", [operator("7/5")] * 2),
]


@pytest.mark.parametrize("change", TAMPERED, ids=range(len(TAMPERED)))
def test_what_is_changed_is_accepted_by_neither(change):
    made, *path, value = change
    assert_both_reject(edited(complete_and_check(made).certificate, *path, value=value))


def test_a_scalar_operator_is_among_the_others_on_its_channels_and_not_conversely():
    kinds = [SCALAR, "linear time-invariant", "any"]
    alike, joint, each = (
        {"channels": [operator(1, kind) | {"time_varying": kind == "any"}] * 2, "repeated": True} for kind in kinds
    )
    assert contains(joint, alike)
    assert contains(each, alike)
    assert not contains(alike, joint)
    assert not contains(alike, alike | {"repeated": False})


# -- a falsifier: Re a* M b for random members, a = phi + r sigma, b = r sigma - phi, phi = Delta sigma at a frequency
def random_multiplier(rng):
    """Numbers for two channels: often Hermitian, often positive, and often neither."""
    gamma = rng.integers(-3, 4, (2, 2)) + np.diag(rng.integers(0, 9, 2))
    symmetric, kernels = rng.random() < 0.7, list[frequencies.Kernel]()
    gamma[1, 0] = gamma[0, 1] if symmetric else -gamma[0, 1]
    for _ in range(rng.integers(0, 3)):
        i, j, side = (int(v) for v in (*rng.integers(0, 2, 2), rng.choice([1, -1])))
        c, rate, order = F(int(rng.integers(-4, 5)), 2), F(int(rng.integers(1, 5)), 2), int(rng.integers(1, 3))
        kernels.append(frequencies.Kernel(i, j, c, rate, order, side))
        if rng.random() < 0.8:
            kernels.append(frequencies.Kernel(j, i, c, rate, order, -side))
    return frequencies.Multiplier([[F(int(v)) for v in row] for row in gamma], [F(0)] * 2, kernels)


def at(given, omega):
    M = np.array([[float(v) for v in row] for row in given.gamma], dtype=complex)
    for i, j, c, rate, order, side in given.kernels:
        M[i, j] -= float(c) * (1 + side * 1j * omega / float(rate)) ** -order
    return M


def worst(given, members, omega):
    """The least Re a* M b over members, and all unit sigma, r = 1."""
    found = np.inf
    for delta in members:
        form = np.conj(delta + 1) * (1 - delta) * at(given, omega)
        found = min(found, float(np.linalg.eigvalsh(form + form.conj().T)[0]))
    return found


def second(given, kind):
    sides = {1: "causal", -1: "anticausal"}
    value = {
        "gamma": [[str(v) for v in row] for row in given.gamma],
        "theta": ["0", "0"],
        "kernels": [
            {"channels": [i + 1, j + 1], "coefficient": str(c), "rate": str(a), "order": n, "side": sides[side]}
            for i, j, c, a, n, side in given.kernels
        ],
    }
    gains, operators = ([True] * 2, []) if kind == "gain" else ([False] * 2, [([0, 1], True)])
    try:
        read_multiplier("matrix-zames-falb", value, [kind == "gain"] * 2, [0, 0], gains, operators)
    except NotShown:
        return False
    return True


@pytest.mark.parametrize("kind", ["gain", "scalar"])
def test_both_checkers_take_the_same_multipliers_and_no_member_refutes_them(kind):
    rng, taken = np.random.default_rng(7), 0
    omegas = np.array([0.0, *np.geomspace(1e-2, 1e2, 12), 1e6])
    for _ in range(80):
        given = random_multiplier(rng)
        gains, operators = ([True] * 2, []) if kind == "gain" else ([False] * 2, [(range(2), True)])
        try:
            frequencies.dominant(given, [kind == "gain"] * 2, [range(2)], gains, operators)
            accepted = True
        except Rejected:
            accepted = False
        assert second(given, kind) is accepted
        circle = rng.random(8) * np.exp(2j * np.pi * rng.random(8))
        members = rng.uniform(-1, 1, 4) if kind == "gain" else circle
        least = min(worst(given, members, omega) for omega in omegas)
        taken += accepted
        assert not accepted or least > -1e-9
    assert taken > 8
