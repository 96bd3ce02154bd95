"""Which classes each theorem about channels serves, and each refutation: all others are refused by both checkers.

The classes have the bounds -1 and 1; the plants are such that a theorem that did not ask for the class would accept it.
"""

import json
from functools import cache

import pytest
from handwritten import draft, loop, nonlinearities, operator
from tampering import assert_both_reject, edited

from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second.opinion import recheck

ATTRACTS, CONVERGES = "0 attracts every motion", "every motion converges to the set of equilibria"
BOUNDED, GAIN = "every motion is bounded", "the L2 gain from w to z is at most gamma in every loop of the class"
KINDS = {
    "sector": nonlinearities(-1, 1),
    "slope": nonlinearities(-1, 1, slope=True),
    "odd": nonlinearities(-1, 1, slope=True, odd=True),
    "relu": nonlinearities(-1, 1, slope=True, relu=True),
    "gain": nonlinearities(-1, 1, slope=True, odd=True, linear=True),
    "jumping": nonlinearities(-1, 1, regularity="any"),
    "varying": nonlinearities(-1, 1, time_varying=True),
    "slow gain": nonlinearities(-1, 1, slope=True, odd=True, linear=True, time_varying=True, rate="1/100"),
    "full block": nonlinearities(-1, 1, operator="full block"),
    "play": nonlinearities(0, 1, slope=True, memory="play"),
    "stop": nonlinearities(0, 1, slope=True, memory="stop"),
    "any": operator("any", 1),
    "invariant": operator("linear time-invariant", 1),
    "scalar": nonlinearities(-1, 1, operator="scalar linear time-invariant"),
    "delay": nonlinearities(-1, 1, operator="delay"),
    "varying delay": operator("varying delay", 1),
    "slow delay": operator("varying delay", 1) | {"rate": "1/2"},
    "performance": operator("performance", 1),
}
SLOPES, FIXED = {"slope", "odd", "relu", "gain"}, {"sector", "slope", "odd", "relu", "gain"}
VARYING, MEMORY, OPERATORS = {"varying", "slow gain"}, {"play", "stop"}, {"any", "invariant", "scalar"}
SECTORS = FIXED | VARYING | {"full block"}
WITH_NORM = SECTORS | OPERATORS | {"performance"}
GAINS = {"sector", "slope", "odd", "gain", "jumping", *VARYING}  # of which a constant gain is a member
LAG = loop([[-3]], [[1]], [[1]], [[0]])
MAP = loop([["1/4"]], [["1/2"]], [[1]], [[0]], "discrete")
GROWS, DOUBLES = loop([["1/2"]], [[1]], [[1]], [[0]]), loop([["3/2"]], [[1]], [[1]], [[0]], "discrete")
TURNS = loop([["-1/2"]], [[1]], [[1]], [[0]], "discrete")
MATRIX = {"method": "matrix", "P": [["1"]], "exponent": 0}
DETERMINANT, PIECES = {"method": "determinant"}, {"method": "pieces", "ends": ["1"]}
SPLINE = {"method": "spline", "degree": 1, "pieces": [1], "P": [[["1"]], [["1"]]], "exponent": 0}
HULL = {"method": "hull", "tree": {"omega": [], "directions": [["1", "0"]]}}
CONSTANT = {"gamma": [["1"]], "theta": ["0"], "kernels": []}
EVEN = [
    {"channels": [1, 1], "coefficient": "1/4", "rate": "1", "order": 1, "side": side}
    for side in ("causal", "anticausal")
]
KERNEL = {"channels": [1, 1], "coefficient": "1/2", "rate": "1", "order": 1, "side": "causal"}
FORM = {"kind": "sector", "channels": [1], "rows": [["1"]]}
LINE = {"points": [["0", "0"]], "left": "1/2", "right": "1/2"}
LAMBDA, THETA, PI = {"lambda": ["1/2"]}, {"theta": ["1/10"]}, {"Pi": [["11/10"], ["0", "-1"]]}
PROOFS = {  # plant, multiplier, proof, and a class that is served
    "diagonal-circle": (LAG, LAMBDA, MATRIX, "sector"),
    "diagonal-circle everywhere": (LAG, LAMBDA, DETERMINANT, "sector"),
    "diagonal-circle in samples": (MAP, {"lambda": ["1/4"]}, MATRIX, "sector"),
    "diagonal-popov": (LAG, LAMBDA | THETA, MATRIX, "sector"),
    "diagonal-popov everywhere": (LAG, LAMBDA | THETA, DETERMINANT, "sector"),
    "coupled-circle": (LAG, {"forms": [FORM]}, MATRIX, "sector"),
    "coupled-circle of slopes": (LAG, {"forms": [FORM | {"kind": "monotone"}]}, MATRIX, "slope"),
    "coupled-circle of odd ones": (LAG, {"forms": [FORM | {"kind": "odd"}]}, MATRIX, "odd"),
    "coupled-popov": (LAG, {"forms": [FORM]} | THETA, MATRIX, "sector"),
    "full-block-circle": (LAG, PI, MATRIX, "sector"),
    "full-block-popov": (LAG, PI | THETA, MATRIX, "sector"),
    "matrix-zames-falb": (LAG, CONSTANT, DETERMINANT, "sector"),
    "matrix-zames-falb of slopes": (LAG, CONSTANT | {"kernels": [KERNEL]}, DETERMINANT, "slope"),
    "parameter-dependent": (LAG, {"lambda": [[]], "theta": []}, SPLINE, "gain"),
    "constant-gains": (LAG, {}, HULL, "gain"),
    "piecewise-circle": (LAG, {"lambda": ["1"], "pieces": [[None]] * 2}, PIECES, "sector"),
    "piecewise-circle by pieces": (LAG, {"lambda": ["0"], "pieces": [[["1", "0"]]] * 2}, PIECES, "gain"),
    "piecewise-popov": (LAG, LAMBDA | THETA | {"pieces": [[None]] * 2}, PIECES, "sector"),
    "matrix-scalings": (MAP, CONSTANT, DETERMINANT, "sector"),
    "matrix-zames-falb that is even": (LAG, CONSTANT | {"kernels": EVEN}, DETERMINANT, "slope"),
    "matrix-scalings with kernels": (MAP, CONSTANT | {"kernels": EVEN}, DETERMINANT, "gain"),
    "order-cones": (MAP, {"windows": [[["1/100"], ["1/4", "1/100"]]], "odd": [False]}, MATRIX, "slope"),
    "coupled-windows": (
        MAP,
        {"samples": 2, "forms": [FORM | {"rows": [["1/4", "0"], ["0", "1/8"]]}], "start": None},
        MATRIX | {"P": [["1"], ["0", "0"]]},
        "sector",
    ),
}
REFUTATIONS = {
    "linear-gains": (GROWS, {"gains": ["1/4"]}, "sector"),
    "linear-members": (GROWS, {"gains": ["1/4"], "operators": []}, "sector"),
    "switched-gains": (DOUBLES, {"gains": [["0"], ["1/4"]], "squarings": 0, "bits": 64}, "varying"),
    "ramped-gains": (
        GROWS,
        {"gains": [["0"], ["1/100"]], "squarings": 0, "bits": 64, "times": ["1", "1"]},
        "varying",
    ),
    "equilibrium": (GROWS, {"nonlinearities": [LINE], "inputs": ["1/2"], "state": ["1"]}, "sector"),
    "sampled-orbit": (TURNS, {"nonlinearities": [LINE], "inputs": [["1/2"]], "state": ["1"], "half": True}, "sector"),
}
SERVED = {
    "diagonal-circle": WITH_NORM | MEMORY,
    "diagonal-circle everywhere": WITH_NORM | MEMORY | {"delay"},
    "diagonal-circle in samples": WITH_NORM | MEMORY,
    "diagonal-popov": FIXED,
    "diagonal-popov everywhere": FIXED,
    "coupled-circle": FIXED | VARYING | MEMORY,
    "coupled-circle of slopes": SLOPES,
    "coupled-circle of odd ones": {"odd", "gain"},
    "coupled-popov": FIXED,
    "full-block-circle": FIXED | VARYING | MEMORY,
    "full-block-popov": FIXED,
    "matrix-zames-falb": WITH_NORM | MEMORY | {"delay"},
    "matrix-zames-falb of slopes": SLOPES,
    "parameter-dependent": {"gain", "slow gain"},
    "constant-gains": {"gain"},
    "piecewise-circle": (WITH_NORM | MEMORY) - {"gain", "invariant"},  # whose multipliers are those of the pieces
    "piecewise-circle by pieces": {"gain", "invariant", "delay", "slow delay"},
    "piecewise-popov": FIXED - {"gain"},
    "matrix-scalings": WITH_NORM | MEMORY,
    "matrix-zames-falb that is even": SLOPES | {"invariant", "scalar", "delay"},
    "matrix-scalings with kernels": {"gain", "invariant", "scalar"},
    "order-cones": SLOPES,
    "coupled-windows": FIXED | VARYING | MEMORY,
    "linear-gains": GAINS | OPERATORS | {"full block"},
    "linear-members": GAINS | {"full block"},
    "switched-gains": {"varying", "any"},
    "ramped-gains": {"varying", "slow gain", "any"},
    "equilibrium": GAINS,
    "sampled-orbit": GAINS,
}
# solutions times e^(t/10), or (10/9)^t: operators have another norm then, and what play and stop do does not scale
NOTHING = set()
PACED = {name: served & (SECTORS | {"jumping"}) for name, served in SERVED.items()}
PACED |= {name: NOTHING for name in SERVED if name.startswith(("parameter-", "matrix-scalings", "order-cones"))}
PACED |= {name: NOTHING for name in ("linear-members", "equilibrium", "sampled-orbit")}
PACED |= {"diagonal-popov everywhere": SLOPES, "piecewise-popov": SLOPES - {"gain"}}
PACED |= {"piecewise-circle by pieces": {"gain"}}
# sigma = x + mu/10: no Popov term, no memory and no delay of which the derivative is asked, D has a cycle; and forms
# that say nothing of differences need slopes within the bounds
DIRECT = {name: served - MEMORY - {"delay", "slow delay"} for name, served in SERVED.items()}
DIRECT |= {name: NOTHING for name in SERVED if "popov" in name}
DIRECT |= {name: NOTHING for name in ("parameter-dependent", "order-cones", "coupled-windows")}
DIRECT |= {name: NOTHING for name in ("ramped-gains", "equilibrium", "sampled-orbit")}
DIRECT |= {"coupled-circle": SLOPES | {"slow gain"}, "matrix-scalings": SLOPES | {"slow gain", "performance"}}
DIRECT |= {"matrix-scalings with kernels": {"gain"}}
DIRECT |= {"matrix-zames-falb": SLOPES | OPERATORS | {"slow gain", "full block", "performance"}}
VARIANTS = {
    "plain": (SERVED, {}, {}),
    "rate": (PACED, {("rate",): "1/10"}, {("rate",): "9/10"}),
    "direct": (DIRECT, {("system", "D"): [["1/10"]]}, {("system", "D"): [["1/10"]]}),
}


@cache
def certificate(name):
    theorem = name.partition(" ")[0]
    if name in PROOFS:
        plant, multiplier, proof, kind = PROOFS[name]
        found = draft(plant, [KINDS[kind]], theorem, multiplier, proof)
    else:
        plant, proof, kind = REFUTATIONS[name]
        found = draft(plant, [KINDS[kind]], "counterexample", {}, {"method": name, **proof})
    return dict(complete_and_check(found).certificate)


def served(name, edits):
    """The classes for which the first checker accepts it, and what it concludes; the second agrees."""
    found = {}
    for kind, one in KINDS.items():
        changed = edited(certificate(name), "laws", "channels", 0, value=one)
        for path, value in edits.items():
            changed = edited(changed, *path, value=value)
        try:
            shown = check(json.dumps(changed), draft=True)
        except (Rejected, Malformed):
            assert not recheck(changed).accepted, (name, kind)
            continue
        found[kind] = shown.certificate["conclusion"]
        assert recheck(dict(shown.certificate)).accepted, (name, kind)
    return found


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("name", SERVED)
def test_each_class_is_served_by_its_theorems_alone(name, variant):
    expected, flows, samples = VARIANTS[variant]
    discrete = certificate(name)["system"]["time"] == "discrete"
    found = served(name, samples if discrete else flows)
    assert {*found} == expected[name]
    if name in PROOFS and variant != "rate":
        special = dict.fromkeys(MEMORY, CONVERGES) | {"performance": GAIN}
        assert found == {kind: special.get(kind, ATTRACTS) for kind in found}


# x' = -x + mu, of which the gain -1, the lower bound, leaves x' = 0
@pytest.mark.parametrize(
    ("name", "functions"),
    [
        ("diagonal-circle everywhere", FIXED),
        ("matrix-zames-falb", FIXED),
        ("diagonal-popov everywhere", FIXED),
        ("matrix-zames-falb of slopes", SLOPES),
    ],
)
def test_with_an_eigenvalue_0_at_the_lower_bounds_0_attracts_nothing(name, functions):
    found = served(name, {("system", "A"): [["-1"]]})
    expected = dict.fromkeys(functions, CONVERGES)
    if name in ("diagonal-circle everywhere", "matrix-zames-falb"):
        expected |= dict.fromkeys(VARYING, BOUNDED) | dict.fromkeys(MEMORY, CONVERGES)
        expected |= {"performance": GAIN, "delay": ATTRACTS}  # which is shifted by 1
    assert found == expected


# x' = mu is at rest wherever mu = 0, and no theorem here serves play and stop then; of a delay of 1 < pi/2 0 attracts
@pytest.mark.parametrize("name", ["diagonal-circle everywhere", "matrix-zames-falb"])
def test_with_an_eigenvalue_0_play_and_stop_are_refused(name):
    assert served(name, {("system", "A"): [["0"]]}) == {"delay": ATTRACTS}


@pytest.mark.parametrize("name", [name for name in PROOFS if "popov" in name or "determinant" in str(PROOFS[name][2])])
def test_theorems_of_one_time_are_refused_for_the_other(name):
    other = {str(LAG): MAP, str(MAP): LAG}[str(PROOFS[name][0])]
    assert served(name, {("system",): other}) == {}


def test_no_operator_stands_beside_a_matrix_that_depends_on_a_gain():
    system, plain = loop([[-3, 0], [0, -3]], [[1, 0], [0, 1]], [[1, 0], [0, 1]], [[0, 0], [0, 0]]), KINDS["sector"]
    proof = SPLINE | {"P": [[["1"], ["0", "1"]]] * 2}
    multiplier = {"lambda": [["1/2"]], "theta": ["0"]}
    found = complete_and_check(
        draft(system, [KINDS["gain"], plain], "parameter-dependent", multiplier, proof)
    ).certificate
    for kind in (*OPERATORS, "performance", "delay", "full block", "jumping", "play"):
        changed = edited(found, "laws", "channels", 1, value=KINDS[kind])
        with pytest.raises((Rejected, Malformed)):
            check(json.dumps(changed), draft=True)
        assert not recheck(changed).accepted


@pytest.mark.parametrize(
    ("name", "path", "value"),
    [
        ("piecewise-circle", ("proof", "method"), "polynomial"),
        ("piecewise-circle", ("multiplier", "pieces", 0, 0), ["0", "0"]),  # a sector has a multiplier on no piece
        ("sampled-orbit", ("proof", "nonlinearities", 0, "points"), []),
    ],
)
def test_a_word_that_no_proof_has_and_numbers_that_say_nothing_are_refused(name, path, value):
    assert_both_reject(edited(certificate(name), *path, value=value))
