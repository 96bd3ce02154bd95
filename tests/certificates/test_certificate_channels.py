"""Certificates about several nonlinearities: what both checkers accept by hand, and what neither does."""

import json
import random
from fractions import Fraction as F

import pytest
from certificate_format import FORMAT
from handwritten import nonlinearities
from tampering import changed, refused_again

from lure.analysis.certificates import channels
from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.checker import Proved, Refuted, check
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.certificates.several import ONE_SOLUTION

# H = diag(1/(s + 1), 1/(s + 2)) with phi_1 in [-1/2, 1] and phi_2 in [0, 5]: with V = x_1^2 + 4 x_2^2 and lambda = 1
# the form -V' - 2 sum lambda (phi - l x)(u x - phi) is, channel by channel,
# channel 1: 2 x^2 + 2 x phi - 2 (phi + x/2)(x - phi) = x^2 + phi^2 + x phi, of determinant 3/4
# channel 2: 16 x^2 + 8 x phi - 2 phi (5 x - phi) = 16 x^2 - 2 x phi + 2 phi^2, of determinant 31
SYSTEM = {
    "kind": "multivariable",
    "time": "continuous",
    "A": [["-1", "0"], ["0", "-2"]],
    "B": [["1", "0"], ["0", "1"]],
    "C": [["1", "0"], ["0", "1"]],
    "D": [["0", "0"], ["0", "0"]],
}
PROOF = {
    "verdict": "PROVED",
    "system": SYSTEM,
    "laws": {"channels": [nonlinearities("-1/2", 1), nonlinearities(0, 5)], "repeated": False},
    "theorem": "diagonal-circle",
    "multiplier": {"lambda": ["1", "1"]},
    "proof": {"method": "matrix", "P": [["1"], ["0", "4"]], "exponent": 0},
}
POPOV = {**PROOF, "theorem": "diagonal-popov", "multiplier": {"lambda": ["1", "1"], "theta": ["1/10", "-1/100"]}}
# the same form with Q + 1/4: at each vertex of the gains it is 1/4, and what is left of the inequality is, channel by
# channel, 3/4 x^2 + x phi + phi^2, of determinant 1/2, and 63/4 x^2 - 2 x phi + 2 phi^2, of determinant 61/2
FULL = {
    **PROOF,
    "theorem": "full-block-circle",
    "multiplier": {"Pi": [["5/4"], ["0", "1/4"], ["1/2", "0", "-2"], ["0", "5", "0", "-2"]]},
}
# with 1/4 phi^2 as well: 3/4 x^2 + x phi + 3/4 phi^2, of determinant 5/16, and 63/4 x^2 - 2 x phi + 7/4 phi^2; Pi is
# 2 y z + (sigma^2 + phi^2)/4 with y = phi - l sigma and z = u sigma - phi, and N the form 2 y z
PART = [["0"], ["0", "0"], ["1", "0", "0"], ["0", "1", "0", "0"]]
ORTHANTS = {
    **FULL,
    "multiplier": {"Pi": [["5/4"], ["0", "1/4"], ["1/2", "0", "-7/4"], ["0", "5", "0", "-7/4"]], "N": [PART, PART]},
}
FULL_POPOV = {**FULL, "theorem": "full-block-popov", "multiplier": FULL["multiplier"] | {"theta": ["1/10", "-1/100"]}}
# constant gains: p = (s + 1 + g)(s + 2 + h) = (a + s)(b + s), a in [1/2, 2], b in [2, 7]; at s = i omega the parts ab -
# omega^2 and (a + b) omega add up to more than 0 for omega <= 2, and for omega >= 2 the second exceeds the first
LEAF = {"omega": ["2"], "directions": [["1", "1"], ["-1", "1"]]}
GAINS = {
    **PROOF,
    "laws": {
        "channels": [nonlinearities(*ends, slope=True, odd=True, linear=True) for ends in (("-1/2", 1), (0, 5))],
        "repeated": False,
    },
    "theorem": "constant-gains",
    "multiplier": {},
    "proof": {"method": "hull", "tree": {"split": [1, "3"], "parts": [LEAF, LEAF]}},
}
# x+ = -G (..) with the matrix [[0, 2 g], [2 h, 0]] of the loop: (g, h) = (1, 0), then (0, 1) multiply x_2 by 4
JUMPING = {
    "verdict": "REFUTED",
    "system": {
        "kind": "multivariable",
        "time": "discrete",
        "A": [["0", "0"], ["0", "0"]],
        "B": [["-2", "0"], ["0", "-2"]],
        "C": [["0", "1"], ["1", "0"]],
        "D": [["0", "0"], ["0", "0"]],
    },
    "laws": {"channels": [nonlinearities(0, 1, time_varying=True)] * 2, "repeated": False},
    "theorem": "counterexample",
    "proof": {"method": "switched-gains", "gains": [["1", "0"], ["0", "1"]], "squarings": 3, "bits": 64},
}
# gains -3 and -2: A - B G C = diag(-1 + 3, -2 + 2) has the eigenvalue 2
COUNTER = {
    "verdict": "REFUTED",
    "system": SYSTEM,
    "laws": {"channels": [nonlinearities(-5, 1), nonlinearities(-5, 5)], "repeated": False},
    "theorem": "counterexample",
    "proof": {"method": "linear-gains", "gains": ["-3", "-2"]},
}


@pytest.mark.parametrize(
    "draft",
    [
        *(PROOF, POPOV, FULL, FULL_POPOV, ORTHANTS, GAINS),
        *(changed(one, "laws", "channels", 0, "time_varying", True) for one in (PROOF, FULL, ORTHANTS)),
    ],
)
def test_a_proof_by_hand_is_accepted_by_both_checkers_and_keeps_the_schema(draft):
    shown = complete_and_check(draft)
    assert isinstance(shown, Proved)
    assert shown.claim.startswith("0 attracts every motion: channel 1: all")
    assert recheck(dict(shown.certificate)).accepted
    FORMAT.validate(json.loads(json.dumps(dict(shown.certificate))))


@pytest.mark.parametrize(
    ("gains", "conclusion"),
    [
        (["-3", "-2"], "a loop of the class has a motion that does not converge to an equilibrium"),
        (["-1", "0"], "a loop of the class has equilibria other than 0"),  # diag(0, -2)
        (["-1", "-2"], "a loop of the class has equilibria other than 0"),  # the zero matrix: every point is one
    ],
)
def test_constant_gains_refute_for_both_checkers(gains, conclusion):
    shown = complete_and_check(changed(COUNTER, "proof", "gains", gains))
    assert isinstance(shown, Refuted)
    assert shown.certificate["conclusion"] == conclusion
    assert recheck(dict(shown.certificate)).accepted
    FORMAT.validate(json.loads(json.dumps(dict(shown.certificate))))


def test_a_zero_eigenvalue_with_too_few_eigenvectors_moves():
    # A = [[0, 1], [0, 0]] with the gains 0: x_1 = t; and [[1, 1], [0, 1]] in discrete time
    for time, entry in (("continuous", "0"), ("discrete", "1")):
        system = SYSTEM | {"time": time, "A": [[entry, "1"], ["0", entry]]}
        shown = complete_and_check(
            {**COUNTER, "system": system, "proof": {"method": "linear-gains", "gains": ["0", "0"]}}
        )
        assert shown.certificate["conclusion"].endswith("converge to an equilibrium")
        assert recheck(dict(shown.certificate)).accepted


def test_gains_that_leave_no_solution_refute():
    # D = [[0, 1], [1, 0]] and G = 1: det (1 + D G) = det [[1, 1], [1, 1]] = 0
    draft = changed(changed(COUNTER, "system", "D", [["0", "1"], ["1", "0"]]), "proof", "gains", ["1", "1"])
    shown = complete_and_check(draft)
    assert shown.certificate["conclusion"] == "a loop of the class is not well posed: 1 + g H(inf) = 0"
    assert recheck(dict(shown.certificate)).accepted


def test_in_discrete_time_the_unit_circle_counts():
    discrete = changed(COUNTER, "system", "time", "discrete")  # A - B G C = diag(-1 - g, -2 - h)
    for gains, ends in ((["0", "-2"], "converge to an equilibrium"), (["-2", "-2"], "other than 0")):  # z = -1, z = 1
        shown = complete_and_check(changed(discrete, "proof", "gains", gains))
        assert shown.certificate["conclusion"].endswith(ends)
        assert recheck(dict(shown.certificate)).accepted
    with pytest.raises(Rejected, match="is stable"):
        complete_and_check(changed(discrete, "proof", "gains", ["-1", "-2"]))  # diag(0, 0)
    # x+ = x/2 - phi, phi in [0, 1]: P = 1, lambda: x^2 - (x/2 - phi)^2 - 2 phi (x - phi) = 3/4 x^2 - x phi + phi^2
    proof = {**PROOF, "system": {**SYSTEM, "time": "discrete", "A": [["1/2", "0"], ["0", "1/2"]]}}
    proof |= {"laws": {"channels": [nonlinearities(0, 1)] * 2, "repeated": True}}
    shown = complete_and_check(changed(proof, "proof", "P", [["1"], ["0", "1"]]))
    assert recheck(dict(shown.certificate)).accepted


def test_gains_that_jump_refute_for_both_checkers():
    shown = complete_and_check(JUMPING)
    assert isinstance(shown, Refuted)
    assert (
        shown.certificate["conclusion"] == "a loop of the class has a motion that does not converge to an equilibrium"
    )
    assert recheck(dict(shown.certificate)).accepted
    FORMAT.validate(json.loads(json.dumps(dict(shown.certificate))))


# what is wrong: a gain outside, one that jumps where the class does not depend on time or is one constant gain,
# different gains of one nonlinearity, no growth (a product of 1/4), times in discrete time
@pytest.mark.parametrize(
    "path",
    [
        ("proof", "gains", [["1", "0"], ["0", "2"]]),
        ("laws", "channels", 1, "time_varying", False),
        ("laws", "channels", 0, "linear", True),
        ("laws", "repeated", True),
        ("system", "B", [["-1/2", "0"], ["0", "-1/2"]]),
        ("proof", "times", ["1", "1"]),
        ("proof", "gains", [["1", "0"], ["0"]]),
        ("proof", "squarings", -1),
    ],
)
def test_gains_that_do_not_jump_within_the_class_or_do_not_grow_are_accepted_by_neither(path):
    accepted = json.loads(json.dumps(dict(complete_and_check(JUMPING).certificate)))
    with pytest.raises((Rejected, Malformed)):
        check(changed(accepted, *path))
    assert refused_again(changed(accepted, *path))


# at both ends the form (sigma - phi/2)^2 - ... is 1/4 sigma^2, and between them -2 sigma^2: not concave in the gain
CONVEX = [["1/4"], ["0", "1/4"], ["-9/2", "0", "9"], ["0", "5", "0", "-2"]]


@pytest.mark.parametrize(
    ("draft", "path"),
    [
        (FULL, ("multiplier", "Pi", 0, ["1"])),  # 0 at the vertices of the first channel: not strictly above
        (FULL, ("multiplier", "Pi", 1, ["1", "1/4"])),  # a coupling that is negative at a vertex
        (FULL, ("multiplier", "Pi", 0, ["9"])),  # a multiplier, but the inequality of P fails
        (FULL, ("multiplier", "Pi", CONVEX[:3])),
        (FULL, ("laws", "channels", 1, "sector", ["0", "6"])),
        (FULL, ("proof", "P", [["1"], ["3", "4"]])),
        (FULL, ("multiplier", "N", [])),
        (FULL, ("theorem", "diagonal-circle")),
        (ORTHANTS, ("multiplier", "N", [PART])),  # a pattern of signs is missing
        (
            ORTHANTS,
            ("multiplier", "N", [PART, [["0"], ["0", "0"], ["1", "0", "0"], ["-1/100", "1", "0", "0"]]]),
        ),  # an entry below 0
        (ORTHANTS, ("multiplier", "N", [PART, [["0"], ["0", "0"], ["2", "0", "0"], ["0", "1", "0", "0"]]])),
        (ORTHANTS, ("laws", "channels", 1, "sector", ["0", "6"])),
        (FULL_POPOV, ("laws", "channels", 0, "time_varying", True)),
        (FULL_POPOV, ("system", "time", "discrete")),
        (GAINS, ("laws", "channels", 0, "linear", False)),  # nothing is shown of gains that depend on sigma
        (GAINS, ("laws", "channels", 0, nonlinearities(-1, 1, linear=True))),  # a root at 0
        (GAINS, ("laws", "channels", 0, nonlinearities("-1/2", 50, linear=True))),
        (GAINS, ("laws", "channels", 1, nonlinearities(0, 3, linear=True))),  # split at an end
        (GAINS, ("proof", "tree", "parts", [LEAF])),
        (GAINS, ("proof", "tree", "split", [2, "3"])),
        (GAINS, ("proof", "tree", "parts", 0, "omega", ["3"])),  # 1 + 15/2 - 9 < 0 for a = 1/2, b = 2
        (GAINS, ("proof", "tree", "parts", 1, "omega", ["2", "2"])),
        (GAINS, ("proof", "tree", "parts", 1, "directions", [["1", "1"]])),
        (GAINS, ("proof", "tree", "parts", 0, "directions", 1, ["1", "1"])),
        (GAINS, ("system", "D", [["-2", "0"], ["0", "0"]])),  # 1 + g D changes its sign
        (GAINS, ("system", "A", [["-1", "9"], ["9", "-2"]])),
    ],
)
def test_a_proof_of_another_kind_that_was_tampered_with_is_accepted_by_neither(draft, path):
    accepted = json.loads(json.dumps(dict(complete_and_check(draft).certificate)))
    with pytest.raises((Rejected, Malformed)):
        check(changed(accepted, *path))
    assert refused_again(changed(accepted, *path))


def test_a_root_that_leaves_through_infinity_is_seen():
    # p = (1 - 2 g)(s + 1) + 2 g = (1 - 2 g) s + 1 has the real part 1 on the axis, and for g = 1 the root 1
    system = {**SYSTEM, "A": [["-1"]], "B": [["1"]], "C": [["2"]], "D": [["-2"]]}
    given = {"channels": [nonlinearities(0, "2/5", linear=True)], "repeated": False}
    tree = {"omega": [], "directions": [["1", "0"]]}
    draft = {**GAINS, "system": system, "laws": given, "proof": {"method": "hull", "tree": tree}}
    accepted = complete_and_check(draft).certificate  # 1 - 2 g > 0
    wide = {"channels": [nonlinearities(0, 1, linear=True)], "repeated": False}
    with pytest.raises(Rejected, match="changes its sign"):
        complete_and_check(draft | {"laws": wide})
    assert recheck(dict(accepted)).accepted
    assert refused_again(dict(accepted) | {"laws": wide})


def test_a_form_that_is_positive_at_the_vertices_alone_is_no_multiplier():
    # phi in [0, 1]: 1/4 - 9 d + 9 d^2 is 1/4 at d = 0 and 1, and -2 at 1/2; with it every loop would be stable
    convex = changed(changed(FULL, "multiplier", "Pi", CONVEX), "laws", "channels", 0, "sector", ["0", "1"])
    with pytest.raises(Rejected, match="not concave"):
        complete_and_check(convex)
    complete = dict(complete_and_check(changed(FULL, "laws", "channels", 0, "sector", ["0", "1"])).certificate)
    assert refused_again(complete | {"multiplier": convex["multiplier"]})


def test_the_same_nonlinearity_in_some_of_the_channels():
    # x' = (g - 1) x_1, (h - 2) x_2, (k - 2) x_3 with mu = -phi: at g = -3 unstable, whatever h = k is
    system = {**COUNTER["system"], "A": [["-1", "0", "0"], ["0", "-2", "0"], ["0", "0", "-2"]]}
    system |= {name: [["1", "0", "0"], ["0", "1", "0"], ["0", "0", "1"]] for name in "BC"}
    system |= {"D": [["0", "0", "0"]] * 3}
    draft = {**COUNTER, "system": system}
    three = [nonlinearities(-5, 1), nonlinearities(-5, 5), nonlinearities(-5, 5)]
    draft |= {"laws": {"channels": three, "repeated": [1, 2]}, "proof": {**COUNTER["proof"], "gains": ["-3", "0", "0"]}}
    shown = complete_and_check(draft)
    assert shown.certificate["hypotheses"]["class"].endswith("one nonlinearity in the channels 2 to 3")
    accepted = json.loads(json.dumps(dict(shown.certificate)))
    assert recheck(accepted).accepted
    FORMAT.validate(accepted)
    for path in (
        ("proof", "gains", ["-3", "0", "1"]),  # not one gain in the channels 2 and 3
        ("laws", "repeated", [2, 1]),  # of different classes
        ("laws", "repeated", [1, 1]),
        ("laws", "repeated", [1, 3]),
        ("laws", "repeated", [3, 0]),
        ("laws", "repeated", []),
        ("laws", "repeated", [1, True, 1]),
        ("laws", "repeated", "all"),
    ):
        with pytest.raises((Rejected, Malformed)):
            check(changed(accepted, *path))
        assert refused_again(changed(accepted, *path))


def random_rows(rng, order, low, high):
    return [[str(F(rng.randint(low, high), 4)) for _ in range(i + 1)] for i in range(order)]


# whatever the checker takes for a multiplier has a form that is nonnegative for the gains of the class; the diagonal is
# raised step by step, so that it is taken when it has barely become one
@pytest.mark.parametrize("resting", [False, True])
@pytest.mark.parametrize("parts", [False, True])
def test_what_is_taken_for_a_multiplier_is_nonnegative_for_random_gains(parts, resting):
    rng, taken = random.Random(20261122), 0
    for _ in range(12):
        bounds = [(F(rng.randint(-4, 2), 4), F(rng.randint(3, 9), 4)) for _ in range(2)]
        given = random_rows(rng, 4, -8, 8)
        for i in (2, 3):
            given[i][i] = str(-abs(F(given[i][i]))) if not parts else given[i][i]
        N = [[random_rows(rng, 4, 0, 3) for _ in range(2)]] if parts else []
        for raised in range(0, 60, 2):
            tried = [list(row) for row in given]
            for i in range(4 if parts else 2):
                tried[i][i] = str(F(given[i][i]) + raised)
            try:
                Pi = channels.full_block(tried, N, bounds, resting)
            except Rejected:
                continue
            taken += 1
            for _ in range(60):
                sigma = [F(rng.randint(-9, 9), 3) for _ in bounds]
                inner = [low + (high - low) * F(rng.randint(0, 6), 6) for low, high in bounds]
                y = [*sigma, *(g * v for g, v in zip(inner, sigma, strict=True))]
                assert sum(y[i] * Pi[i][j] * y[j] for i in range(4) for j in range(4)) >= 0
            break
    assert taken > 5


TAMPERED = {
    "a larger class": ("laws", "channels", 0, "sector", ["-1/2", "40"]),
    "a lower lower bound": ("laws", "channels", 0, "sector", ["-2", "1"]),
    "a slower pole": ("system", "A", [["-1/10", "0"], ["0", "-2"]]),
    "a coupling": ("system", "B", [["1", "9"], ["9", "1"]]),
    "another output": ("system", "C", [["1", "0"], ["7", "1"]]),
    "a direct term": ("system", "D", [["0", "5"], ["-5", "0"]]),
    "P is indefinite": ("proof", "P", [["1"], ["3", "4"]]),
    "P is negative": ("proof", "P", [["-1"], ["0", "4"]]),
    "P is too small": ("proof", "exponent", 9),
    "a weight is 0": ("multiplier", "lambda", ["0", "1"]),
    "a weight is negative": ("multiplier", "lambda", ["-1", "1"]),
    "too large a weight": ("multiplier", "lambda", ["90", "1"]),
    "no upper bound": ("laws", "channels", 0, "sector", ["-1/2", "finite"]),
    "a class is missing": ("laws", "channels", [nonlinearities("-1/2", 1)]),
    "repeated": ("laws", "repeated", True),
    "nonlinearities that jump": ("laws", "channels", 0, "regularity", "any"),
    "discrete time": ("system", "time", "discrete"),
    "no theorem": ("theorem", "diagonal-park"),
    "a row is missing": ("system", "C", [["1", "0"]]),
    "a weight is missing": ("multiplier", "lambda", ["1"]),
    "a key too many": ("multiplier", "theta", ["0", "0"]),
    "a nonlinearity": ("law", {"kind": "tanh", "height": "1", "rate": "1"}),
}


@pytest.mark.parametrize("what", TAMPERED)
def test_what_was_tampered_with_is_accepted_by_neither(what):
    path = TAMPERED[what]
    with pytest.raises((Rejected, Malformed)):
        complete_and_check(changed(PROOF, *path))
    accepted = json.loads(json.dumps(dict(complete_and_check(PROOF).certificate)))
    assert refused_again(changed(accepted, *path))
    with pytest.raises((Rejected, Malformed)):
        check(changed(accepted, *path))


@pytest.mark.parametrize(
    "path",
    [
        ("laws", "channels", 0, "time_varying", True),  # theta_1 is not 0
        ("system", "D", [["0", "1/100"], ["0", "0"]]),  # sigma_1 is no function of the state
        ("system", "time", "discrete"),
        ("multiplier", "theta", ["-5", "0"]),  # V > 0 fails: 1 - 5 u_1 < 0
        ("multiplier", "theta", ["1/10"]),
    ],
)
def test_popovs_terms_need_their_hypotheses(path):
    accepted = json.loads(json.dumps(dict(complete_and_check(POPOV).certificate)))
    with pytest.raises((Rejected, Malformed)):
        complete_and_check(changed(POPOV, *path))
    assert refused_again(changed(accepted, *path))


@pytest.mark.parametrize(
    "path",
    [
        ("proof", "gains", ["0", "0"]),  # stable
        ("proof", "gains", ["-6", "0"]),  # outside
        ("proof", "gains", ["-3"]),
        ("laws", {"channels": [nonlinearities(-5, 1)] * 2, "repeated": True}),  # -3 is not -2
        ("multiplier", {"lambda": ["1", "1"]}),
        ("conclusion", "0 attracts every motion"),
        ("verdict", "PROVED"),
    ],
)
def test_a_counterexample_that_is_none_is_accepted_by_neither(path):
    accepted = json.loads(json.dumps(dict(complete_and_check(COUNTER).certificate)))
    with pytest.raises((Rejected, Malformed)):
        check(changed(accepted, *path))
    assert not recheck(changed(accepted, *path)).accepted
    if path[0] != "conclusion":  # which a draft leaves open
        with pytest.raises((Rejected, Malformed)):
            complete_and_check(changed(COUNTER, *path))


# what the sign of V and of lambda keep out: each fulfils the inequality of P, and its loop is not stable
UNSTABLE = {
    # 1/(s - 1), phi in [0, 1/2], V = -x^2, lambda = 2: 2 x^2 - 2 x phi - 4 phi (x/2 - phi) = 2 x^2 - 4 x phi + 4 phi^2
    "V is negative": ("1", "1", "1", "0", "1/2", "2", "-1"),
    # x' = -x and sigma = phi: 1 + g D = 0 at g = 1, V = x^2, lambda = -1: 2 x^2 + 2 phi (2 phi - phi)
    "lambda is negative": ("-1", "0", "0", "-1", "2", "-1", "1"),
}


@pytest.mark.parametrize("what", UNSTABLE)
def test_the_inequality_of_p_alone_is_not_enough(what):
    a, b, c, d, top, weight, p = UNSTABLE[what]
    draft = {
        "verdict": "PROVED",
        "system": {"kind": "multivariable", "time": "continuous", "A": [[a]], "B": [[b]], "C": [[c]], "D": [[d]]},
        "laws": {"channels": [nonlinearities(0, top)], "repeated": False},
        "theorem": "diagonal-circle",
        "multiplier": {"lambda": [weight]},
        "proof": {"method": "matrix", "P": [[p]], "exponent": 0},
    }
    with pytest.raises(Rejected, match=r"V > 0 fails|lambda is negative"):
        complete_and_check(draft)
    head = json.loads(json.dumps(dict(complete_and_check(PROOF).certificate)))
    second = recheck({**head, **draft})
    assert not second.accepted
    assert "positive definite" in second.reason or "negative" in second.reason


def test_what_a_direct_term_with_a_cycle_assumes():
    def shown(*, slope):
        cycle = changed(PROOF, "system", "D", [["0", "1/10"], ["1/10", "0"]])
        return complete_and_check(
            changed(
                cycle, "laws", "channels", [nonlinearities("-1/2", 1, slope=slope), nonlinearities(0, 2, slope=slope)]
            )
        )

    assert shown(slope=True).assumed == ""
    assert shown(slope=False).assumed == ONE_SOLUTION
    one, two = (channels.channels({"channels": [nonlinearities(0, 1)] * m, "repeated": False}, m) for m in (1, 2))
    assert channels.ordered([[F(0), F(0)], [F(1), F(0)]], two)
    assert not channels.ordered([[F(1)]], one)


def member(rng, low, high):
    """A random continuous piecewise-linear phi with phi(0) = 0 and its chords from the origin within the bounds."""
    knots = sorted({F(rng.randint(-40, 40), 8) for _ in range(6)} | {F(0)})
    gains = [low + (high - low) * F(rng.randint(0, 16), 16) for _ in knots]
    values = [g * x for g, x in zip(gains, knots, strict=True)]

    def phi(x):
        if x <= knots[0] or x >= knots[-1]:
            return (gains[0] if x <= knots[0] else gains[-1]) * x
        i = max(j for j, knot in enumerate(knots) if knot <= x)
        share = (x - knots[i]) / (knots[i + 1] - knots[i])
        return values[i] + share * (values[i + 1] - values[i])

    return phi


@pytest.mark.parametrize("theta", [(F(1, 10), F(-1, 100)), (F(0), F(0))])
def test_v_falls_at_random_states_for_random_members(theta):
    rng = random.Random(20261122)
    bounds, P, A = ((F(-1, 2), F(1)), (F(0), F(5))), (1, 4), (-1, -2)
    slack = []
    for _ in range(400):
        nonlinearities = [member(rng, *one) for one in bounds]
        x = [F(rng.randint(-40, 40), 8) for _ in range(2)]
        if any(x):
            phi = [one(v) for one, v in zip(nonlinearities, x, strict=True)]
            rate = [a * v - w for a, v, w in zip(A, x, phi, strict=True)]
            falls = sum(2 * (p * v + t * w) * r for p, v, w, t, r in zip(P, x, phi, theta, rate, strict=True))
            slack.append(falls)
            constraint = [(w - low * v) * (high * v - w) for v, w, (low, high) in zip(x, phi, bounds, strict=True)]
            assert min(constraint) >= 0
    assert max(slack) < 0
