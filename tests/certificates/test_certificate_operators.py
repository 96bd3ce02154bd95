"""Norm-bounded operators and the L2 gain: certificates by hand, and what neither checker accepts."""

import json
import random
from fractions import Fraction as F

import pytest
from certificate_format import FORMAT
from handwritten import draft, loop, nonlinearities, operator
from tampering import assert_both_reject, edited

from lure import Diagonal, NonlinearityClass, as_plant, max_sector
from lure.analysis.certificates import frequencies
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.drafts import complete_and_check, contains
from lure.analysis.certificates.second.opinion import recheck

ATTRACTS, GAIN = "0 attracts every motion", "the L2 gain from w to z is at most gamma in every loop of the class"
MOVES = "a loop of the class has a motion that does not converge to an equilibrium"
UNLIMITED = "no L2 gain from w to z is finite for all loops of the class"
EXCEEDED = "the L2 gain from w to z is above gamma in a loop of the class"


# x' = -x + mu, sigma = x: |H| = 1/|1 + i omega| <= 1.  V = x^2, lambda = 1/2, r = 9/10: -V' - (r^2 x^2 - mu^2) is
# (2 - .81) x^2 - 2 x mu + mu^2, of determinant .19; in discrete time x+ = x/2 + mu, |H| <= 2, r = 2/5, lambda = 1: of
# -dV - 2 (r^2 x^2 - mu^2) is left (3/4 - .32) x^2 - x mu + mu^2, of determinant .18
LAG = loop([[-1]], [[1]], [[1]], [[0]])
MAP = loop([["1/2"]], [[1]], [[1]], [[0]], "discrete")
P1 = {"method": "matrix", "P": [["1"]], "exponent": 0}
ANY = draft(LAG, [operator("any", "9/10")], "diagonal-circle", {"lambda": ["1/2"]}, P1)
INVARIANT = ANY | {"laws": {"channels": [operator("linear time-invariant", "9/10")], "repeated": False}}
EVEN = [
    {"channels": [1, 1], "coefficient": "1/4", "rate": "2", "order": 2, "side": side}
    for side in ("causal", "anticausal")
]
SCALED = INVARIANT | {
    "theorem": "matrix-zames-falb",
    "multiplier": {"gamma": [["1"]], "theta": ["0"], "kernels": EVEN},
    "proof": {"method": "determinant"},
}
OF_MAP = ANY | {
    "system": MAP,
    "laws": {"channels": [operator("any", "2/5")], "repeated": False},
    "multiplier": {"lambda": ["1"]},
}
# beside an operator of two channels a sector: three lags, each by itself; for the third, with lambda = 1/2, the form is
# 2 x^2 + 2 x phi - phi (x - phi) = 2 x^2 + x phi + phi^2
THREE = loop(*([[-v * (i == j) for j in range(3)] for i in range(3)] for v in (1, -1, -1, 0)))
I3 = {"method": "matrix", "P": [["1"], ["0", "1"], ["0", "0", "1"]], "exponent": 0}
MIXED = draft(
    THREE,
    [operator("any", "9/10")] * 2 + [nonlinearities(0, 1)],
    "diagonal-circle",
    {"lambda": ["1/2", "1/2", "1/2"]},
    I3,
    [2, 1],
)
# the same with Pi for the third alone: its form phi (x - phi), and a little at both vertices
FULL = MIXED | {
    "theorem": "full-block-circle",
    "multiplier": {"Pi": [["1/10"], ["1/2", "-1"]], "lambda": ["1/2", "1/2", "0"]},
}
# x' = -x - phi + w, sigma = z = x, phi in [0, 1]: the gain is 1, with phi = 0; V = x^2, lambda_1 = 1/10, that of w to z
# 1/2, gamma = 10/9, lambda_1 = 1: 1.19 x^2 + 2 phi^2 - 2 x w + w^2, of determinant 2 (.19)
LOOP = loop([[-1]], [[1, 1]], [[1], [1]], [[0, 0], [0, 0]])
PERFORMANCE = draft(
    LOOP, [nonlinearities(0, 1), operator("performance", "9/10")], "diagonal-circle", {"lambda": ["1", "1/2"]}, P1
)
OVER_ALL = PERFORMANCE | {"proof": {"method": "determinant"}}
# q' = v, v' = -v - phi(q) + w, z = v: w moves q, which z does not see.  V = v^2 + 2 int phi, lambda of w to z 1/2,
# gamma = 1: 2 v^2 - 2 v w - (v^2 - w^2) = (v - w)^2
SERVO = loop([[0, 1], [0, -1]], [[0, 0], [1, 1]], [[1, 0], [0, 1]], [[0, 0], [0, 0]])
RESTING = draft(
    SERVO,
    [nonlinearities(0, 5), operator("performance", 1)],
    "diagonal-popov",
    {"lambda": ["0", "1/2"], "theta": ["1", "0"]},
    {"method": "matrix", "P": [["0"], ["0", "1"]], "exponent": 0, "semidefinite": True},
)
# x' = -x - phi + w, z = x: with lambda = 1, 1/2, gamma = 1, is left (x - w)^2 + 2 phi^2
CLOSED = PERFORMANCE | {"proof": P1 | {"semidefinite": True}}
CLOSED = edited(CLOSED, "laws", "channels", 1, value=operator("performance", 1))
PROOFS = {
    "gain without a margin": (CLOSED, GAIN),
    "resting gain": (RESTING, GAIN),
    "any": (ANY, ATTRACTS),
    "invariant": (INVARIANT, ATTRACTS),
    "scaled": (SCALED, ATTRACTS),
    "discrete": (OF_MAP, ATTRACTS),
    "mixed": (MIXED, ATTRACTS),
    "full": (FULL, ATTRACTS),
    "gain": (PERFORMANCE, GAIN),
    "gain over all frequencies": (OVER_ALL, GAIN),
}
# the gain with phi = 0 is 1 at omega = 0, above 1/r = 10/11
ABOVE = draft(
    LOOP,
    [nonlinearities(0, 1), operator("performance", "11/10")],
    "counterexample",
    {},
    {"method": "linear-members", "gains": ["0", "0"], "operators": [], "omega": "0", "input": [["1", "0"]]},
)
# H = 1/(s + 1)^2 is 1/(2i) at s = i, where c (s - 1)/(s + 1) is c i: 1 + c i/(2 i) = 0 for c = -2
TWICE = loop([[-2, -1], [1, 0]], [[1], [0]], [[0, 1]], [[0]])
PASSES = draft(
    TWICE,
    [operator("linear time-invariant", 2)],
    "counterexample",
    {},
    {"method": "linear-members", "gains": ["0"], "operators": [{"left": [["-2", "1"]], "right": [["1", None]]}]},
)
# x+ = x/2 + mu with |H(-1)| = 2/3: z = -1 is the frequency without a tangent
BELOW = ABOVE | {
    "system": MAP,
    "laws": {"channels": [operator("performance", "8/5")], "repeated": False},
    "proof": {"method": "linear-members", "gains": ["0"], "operators": [], "omega": None, "input": [["1", "2"]]},
}
# of the servo with phi = 0 z sees 1/(s + 1), and not q, which rests: |T|^2 = 10^6/(10^6 + 1) at omega = 1/1000
HIDDEN = ABOVE | {"system": SERVO, "proof": ABOVE["proof"] | {"omega": "1/1000"}}
# x' = w, z = x with phi = 0; x+ = -x + w, of which z = -1 is the pole; and the second of two states from w_2 to z_1
DRIFTS = draft(
    loop([[0]], [[1, 1]], [[1], [1]], [[0, 0], [0, 0]]),
    [nonlinearities(0, 1), operator("performance", 1)],
    "counterexample",
    {},
    {"method": "linear-gains", "gains": ["0", "0"], "unlimited": [1, 1]},
)
TURNS = DRIFTS | {"system": loop([[-1]], [[1, 1]], [[1], [1]], [[0, 0], [0, 0]], "discrete")}
CROSSES = DRIFTS | {
    "system": loop([[-1, 0], [0, 0]], [[1, 1, 0], [0, 0, 1]], [[1, 0], [1, 1], [1, 0]], [[0] * 3] * 3),
    "laws": {"channels": [nonlinearities(0, 1), *[operator("performance", 1)] * 2], "repeated": [1, 2]},
    "proof": {"method": "linear-gains", "gains": ["0", "0", "0"], "unlimited": [1, 2]},
}
# of 1/s, 1/(s + 1), 1/(s + 2) w moves the first two, and z sees the first and the third
SHARED = DRIFTS | {
    "system": loop(
        [[0, 0, 0], [0, -1, 0], [0, 0, -2]], [[0, 1], [0, 1], [0, 0]], [[1, 1, 1], [1, 0, 1]], [[0, 0], [0, 0]]
    )
}


@pytest.mark.parametrize("name", PROOFS)
def test_a_proof_by_hand_is_accepted_by_both_checkers_and_keeps_the_schema(name):
    one, conclusion = PROOFS[name]
    shown = complete_and_check(one)
    assert shown.certificate["conclusion"] == conclusion
    assert recheck(dict(shown.certificate)).accepted
    FORMAT.validate(json.loads(json.dumps(dict(shown.certificate))))


@pytest.mark.parametrize(
    ("one", "conclusion"),
    [
        (ABOVE, EXCEEDED),
        (PASSES, MOVES),
        (BELOW, EXCEEDED),
        (HIDDEN, EXCEEDED),
        *((one, UNLIMITED) for one in (DRIFTS, TURNS, CROSSES, SHARED)),
    ],
)
def test_linear_members_refute_for_both_checkers(one, conclusion):
    shown = complete_and_check(one)
    assert shown.certificate["conclusion"] == conclusion
    assert recheck(dict(shown.certificate)).accepted
    FORMAT.validate(json.loads(json.dumps(dict(shown.certificate))))


def test_the_words_name_the_pole_and_the_frequency():
    assert "a pole from w_2 to z_1 not strictly inside" in complete_and_check(CROSSES).facts["pole"]
    assert complete_and_check(HIDDEN).facts["gain"].endswith("at omega = 1/1000")
    assert complete_and_check(BELOW).facts["gain"].endswith("at omega = inf, the tangent of half the angle")


SIDES = ("laws", "channels", 0, "sector")
TAMPERED = [
    (ANY, *SIDES, ["-1", "1"]),  # |H| = 1
    (ANY, *SIDES, ["-1/2", "9/10"]),  # no norm
    (ANY, "laws", "channels", 0, "time_varying", False),
    (ANY, "laws", "channels", 0, "operator", "anything"),
    (ANY, "laws", "channels", 0, "odd", True),
    (ANY, "laws", "channels", 0, "slope", ["-9/10", "9/10"]),
    (ANY, "multiplier", "lambda", ["-1/2"]),
    (SCALED, "laws", "channels", 0, operator("any", "9/10")),  # which may depend on time
    (SCALED, "multiplier", "kernels", EVEN[:1]),  # not real
    (SCALED, "multiplier", "kernels", [one | {"coefficient": "2/3"} for one in EVEN]),  # negative at omega = 0
    (SCALED, "multiplier", "theta", ["1/10"]),
    (MIXED, "multiplier", "lambda", ["1/2", "3/5", "1/2"]),  # two weights for one operator
    (FULL, "multiplier", "lambda", ["1/2", "1/2", "1/10"]),
    (FULL, "multiplier", "Pi", [["-1/10"], ["1/2", "-1"]]),
    (PERFORMANCE, "laws", "channels", 1, operator("performance", "11/10")),
    (PERFORMANCE, "multiplier", "lambda", ["1", "0"]),
    (PERFORMANCE, "laws", "channels", [operator("performance", "9/10")] * 2),
    (PERFORMANCE, "laws", "channels", [operator("performance", "9/10"), nonlinearities(0, 1)]),
    (PERFORMANCE, "conclusion", ATTRACTS),
    (OVER_ALL, "system", "C", [["1"], ["2"]]),
    (ABOVE, "laws", "channels", 1, operator("performance", "9/10")),
    (ABOVE, "proof", "gains", ["0", "1/2"]),  # the loop is not closed from z to w
    (ABOVE, "proof", "gains", ["-1/2", "0"]),
    (ABOVE, "proof", "gains", ["1", "0"]),
    (ABOVE, "proof", "omega", "1"),
    (PASSES, "proof", "operators", 0, "left", [["-21/10", "1"]]),  # of a larger norm
    (PASSES, "proof", "operators", 0, "left", [["-2", "-1"]]),  # not stable
    (PASSES, "proof", "operators", 0, "left", [["1/2", "1"]]),
    (PASSES, "proof", "operators", 0, "left", [["-2", "2"]]),
    (PASSES, "proof", "operators", []),
    (PASSES, "conclusion", EXCEEDED),
    (RESTING, "laws", "channels", 1, operator("performance", "11/10")),
    (RESTING, "laws", "channels", 0, nonlinearities(0, 5, time_varying=True)),
    (RESTING, "laws", "channels", 0, nonlinearities(-1, 5)),  # V < 0 where phi = -sigma
    (RESTING, "multiplier", "theta", ["99/100", "0"]),
    (RESTING, "proof", "P", [["-1"], ["0", "1"]]),
    (RESTING, "proof", "semidefinite", False),
    (RESTING, "proof", {"method": "matrix", "P": [["0"], ["0", "1"]], "exponent": 0}),
    (RESTING, "system", "D", [["0", "0"], ["1", "0"]]),
    (RESTING, "laws", "channels", 0, nonlinearities(0, 5, slope=["0", "5"], memory="play")),
    (RESTING, "conclusion", ATTRACTS),
    (RESTING, "laws", "channels", 1, operator("any", 1)),  # q does not come to rest
    (CLOSED, "laws", "channels", 1, operator("any", 1)),
    (CLOSED, "laws", "channels", 0, operator("any", 1)),
    (CLOSED, "laws", "channels", 1, operator("performance", "1001/1000")),
    (CLOSED, "system", "A", [["-999/1000"]]),
    (CLOSED, "system", "D", [["1/10", "0"], ["0", "0"]]),  # a cycle
    (CLOSED, "theorem", "coupled-circle"),
    (HIDDEN, "proof", "omega", "0"),  # which is that of a pole
    (HIDDEN, "proof", "omega", "1"),
    (HIDDEN, "laws", "channels", 1, operator("performance", 1)),
    (DRIFTS, "proof", "gains", ["1/2", "0"]),  # 1/(s + 1/2)
    (DRIFTS, "proof", "gains", ["-1/2", "0"]),
    (DRIFTS, "proof", "unlimited", [1, 2]),
    (DRIFTS, "system", "C", [["1"], ["0"]]),  # which z does not see
    (DRIFTS, "system", "B", [["1", "0"]]),  # which w does not move
    (DRIFTS, "conclusion", EXCEEDED),
    (CROSSES, "proof", "unlimited", [1, 1]),  # 1/(s + 1)
    (SHARED, "system", "C", 1, ["0", "1", "1"]),
    (SHARED, "system", "B", [["0", "0"], ["0", "1"], ["0", "1"]]),
    (SHARED, "system", "A", 0, 0, "-1/2"),
    (SHARED, "system", "C", 1, ["0", "0", "0"]),
    (SHARED, "system", "B", [["0", "0"], ["0", "0"], ["0", "0"]]),
]


@pytest.mark.parametrize("change", TAMPERED, ids=range(len(TAMPERED)))
def test_what_is_changed_is_accepted_by_neither(change):
    one, *path, value = change
    found = edited(complete_and_check(one).certificate, *path, value=value)
    assert_both_reject(found, stored=path == ["conclusion"])


def test_w_has_a_weight_also_where_it_moves_nothing():
    # x' = -x - phi, z = 5 w: without a weight the form of (x, phi) says nothing of z
    found = edited(
        complete_and_check(CLOSED).certificate, "system", value=loop([[-1]], [[1, 0]], [[1], [0]], [[0, 0], [0, 5]])
    )
    assert_both_reject(edited(found, "multiplier", "lambda", value=["1", "0"]))


def test_one_operator_on_two_channels_is_another_class_than_one_on_each():
    # [[0, 1], [1, 0]] is a matrix of norm 1 and not diagonal; diag(1, 1) is both
    joint = {"channels": [operator("any", 1)] * 2, "repeated": True}
    apart = {"channels": [operator("any", 1)] * 2, "repeated": False}
    invariant = {"channels": [operator("linear time-invariant", "1/2")] * 2, "repeated": True}
    assert not contains(joint, apart)
    assert not contains(apart, joint)
    assert contains(joint, invariant)
    assert not contains(invariant, joint)
    mixed = complete_and_check(MIXED).certificate
    assert "one operator on the channels 1 to 2" in mixed["hypotheses"]["class"]


def test_an_operator_that_d_leads_back_to_is_no_chain_of_channels():
    # D = [[0, 1], [0, 0]]: sigma_1 needs mu_2, which an operator on both makes of sigma_1 as well
    system = loop([[-1, 0], [0, -1]], [[1, 0], [0, 1]], [["1/10", 0], [0, "1/10"]], [[0, "1/10"], [0, 0]])
    proof = {"method": "matrix", "P": [["1"], ["0", "1"]], "exponent": 0}
    one = [operator("any", "1/2")] * 2
    for repeated, posed in ((False, "channel after channel"), (True, "det(1 + D G) != 0")):
        made = draft(system, one, "diagonal-circle", {"lambda": ["1", "1"]}, proof, repeated)
        shown = complete_and_check(made)
        assert posed in shown.facts["well-posed"]
        assert ("exactly one solution" in shown.assumed) is repeated
        assert recheck(dict(shown.certificate)).accepted


def test_members_of_each_class_keep_the_constraints_of_its_multipliers():
    # Re a* M b at a frequency, a = mu + r sigma (mu = -Delta sigma there, phi = Delta sigma), b = r sigma - phi
    rng = random.Random(20261122)

    def vector(size):
        found = [complex(rng.gauss(0, 1), rng.gauss(0, 1)) for _ in range(size)]
        length = sum(abs(v) ** 2 for v in found) ** 0.5
        return [v / length for v in found]

    r, worst = 1.5, 0.0
    for _ in range(300):
        sigma, omega, gamma = vector(2), abs(rng.gauss(0, 3)), F(rng.randint(1, 9), 4)
        u, v = vector(2), vector(2)
        phi = [r * x * sum(a * b for a, b in zip(v, sigma, strict=True)) for x in u]  # of a matrix of norm r
        c, rate, order = F(rng.randint(-8, 8), 8), F(rng.randint(1, 8), 2), rng.randint(1, 3)
        kernels = [frequencies.Kernel(i, i, c, rate, order, side) for i in (0, 1) for side in (1, -1)]
        given = frequencies.Multiplier([[gamma, F(0)], [F(0), gamma]], [F(0)] * 2, kernels)
        try:
            frequencies.dominant(given, [False] * 2, [range(2)], [False] * 2, [(range(2), False)])
        except Rejected:
            continue
        lag = (float(rate) / (float(rate) + 1j * omega)) ** order
        d = float(gamma) - float(c) * 2 * lag.real
        form = sum(((p + r * s).conjugate() * d * (r * s - p)).real for p, s in zip(phi, sigma, strict=True))
        worst = min(worst, form)
    assert worst > -1e-9
    # diag(1, 2): r^2 |sigma_1|^2 - 2 |phi_2|^2 < 0 for sigma = e_1, which the operator turns to phi = r e_2
    coupled = frequencies.Multiplier([[F(1), F(1, 2)], [F(1, 2), F(1)]], [F(0)] * 2, [])
    for wrong in (coupled, frequencies.Multiplier([[F(2), F(0)], [F(0), F(1)]], [F(0)] * 2, [])):
        with pytest.raises(Rejected):
            frequencies.dominant(wrong, [False] * 2, [range(2)], [False] * 2, [(range(2), False)])


@pytest.mark.slow
def test_one_scalar_operator_in_each_channel_is_given_channel_after_channel_and_one_on_both_is_not():
    # sigma_1 = .. + mu_2/10: delta in each channel has no cycle of D, an operator on both leads from mu_1 to sigma_2
    one = NonlinearityClass.norm_bounded(1, dynamics="scalar linear time-invariant")
    plant = as_plant([["1/(s+1)", "0.1"], ["0.2/(s+3)", "1/(s+2)"]])
    found = max_sector(plant, Diagonal((one, one), repeated=True), criterion="matrix-zames-falb")
    data = dict(found.proof.certificate)
    assert data["theorem"] == "matrix-zames-falb"
    assert recheck(data).accepted
    both = [{**each, "operator": "linear time-invariant"} for each in data["laws"]["channels"]]
    assert_both_reject(edited(data, "laws", "channels", value=both))
    assert_both_reject(edited(data, "system", "D", 1, 0, value="1/100"))


def test_the_channels_of_an_operator_have_one_multiplier_on_each_piece():
    # x_i' = -x_i + mu_i: |H| <= 1 < 10/9, and F > 0 with other weights too
    two = loop(*([[v * (i == j) for j in range(2)] for i in range(2)] for v in (-1, 1, 1, 0)))
    both, proof = [operator("linear time-invariant", "9/10")] * 2, {"method": "pieces", "ends": ["1"]}
    multiplier = {"lambda": ["0", "0"], "pieces": [[["1", "0"]] * 2] * 2}
    found = complete_and_check(draft(two, both, "piecewise-circle", multiplier, proof, [2])).certificate
    assert recheck(found).accepted
    assert_both_reject(edited(found, "multiplier", "pieces", 1, value=[["1", "0"], ["2", "0"]]))
