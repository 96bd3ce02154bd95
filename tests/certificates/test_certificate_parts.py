"""Certificates about loops side by side: by hand, of each kind of part, and what neither checker accepts."""

import copy
import json

import pytest
from certificate_format import FORMAT
from flint import fmpq, fmpq_mat
from handwritten import nonlinearities
from second_plants import assert_accepted_if, at
from tampering import changed

from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.checker import Proved, Refuted, check
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second import channels, classes
from lure.analysis.certificates.second import parts as second
from lure.analysis.certificates.second.numerics import from_descending
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.certificates.second.reading import Document, NotShown, numbers

# three loops, the states of the second around those of the first: diag(1/(s + 1), 1/(s + 2)), 1/(s (s + 1)) and
# (s + 3)/(s + 1), of the states (1, 4), (2, 3) and 5 and of the channels (1, 3), 2 and 4
SYSTEM = {
    "kind": "multivariable",
    "time": "continuous",
    "A": [["-1", *"0000"], ["0", "0", "1", "0", "0"], ["0", "0", "-1", *"00"], [*"000", "-2", "0"], [*"0000", "-1"]],
    "B": [["1", *"000"], [*"0000"], ["0", "1", *"00"], [*"00", "1", "0"], [*"000", "1"]],
    "C": [["1", *"0000"], ["0", "1", *"000"], [*"000", "1", "0"], [*"0000", "2"]],
    "D": [[*"0000"], [*"0000"], [*"0000"], [*"000", "1"]],
}
# V = x_1^2 + 4 x_2^2, as in the tests of certificates about channels
PAIR = {
    "channels": [1, 3],
    "states": [1, 4],
    "kind": "multivariable",
    "theorem": "diagonal-circle",
    "multiplier": {"lambda": ["1", "1"]},
    "proof": {"method": "matrix", "P": [["1"], ["0", "4"]], "exponent": 0},
}
# 1/(s^2 + s): Re (1 + theta i omega) n d* + |d|^2/k is x ((theta - 1) + (1 + x)/k), for theta = 1 and k = 9 over x:
# (1 + x)/9 + 0, which the checker multiplies by w = 9
INTEGRATOR = {
    "channels": [2],
    "states": [2, 3],
    "kind": "transfer",
    "theorem": "popov",
    "multiplier": {"theta": "1"},
    "proof": {"method": "polynomial", "variable": "omega^2", "coefficients": ["1", "1"], "limits": ["1", "1"]},
}
# (s + 3)/(s + 1), slope in [0, 2]: 2 Re n d* + |d|^2 = 2 (x + 3) + x + 1 = 7 + 3 x
DIRECT = {
    "channels": [4],
    "states": [5],
    "kind": "transfer",
    "theorem": "circle",
    "multiplier": {},
    "proof": {"method": "polynomial", "variable": "omega^2", "coefficients": ["7", "3"], "limits": ["7", "3"]},
}
PROOF = {
    "verdict": "PROVED",
    "system": SYSTEM,
    "laws": {
        "channels": [
            nonlinearities("-1/2", 1),
            nonlinearities(0, 9),
            nonlinearities(0, 5),
            nonlinearities(0, 2, slope=True),
        ],
        "repeated": False,
    },
    "theorem": "parts",
    "multiplier": {},
    "proof": {"method": "parts", "parts": [PAIR, INTEGRATOR, DIRECT]},
}
# without the integrator: A_23 = 0 and A_22 = -1 leave sigma_2 a mode that nothing moves
STABLE = copy.deepcopy(PROOF)
STABLE["system"]["A"][1] = ["0", "-1", "0", "0", "0"]
STABLE["proof"]["parts"][1] |= {
    "theorem": "circle",
    "multiplier": {},
    # n = 0 and d = (s + 1)^2: |d|^2 = 1 + 2 x + x^2
    "proof": {"method": "polynomial", "variable": "omega^2", "coefficients": ["1", "2", "1"], "limits": ["1", "1"]},
}
# the gain -2 of the class [-2, 9] in channel 2: s^2 + s - 2 = (s + 2)(s - 1)
COUNTER = {
    "verdict": "REFUTED",
    "system": SYSTEM,
    "laws": {
        "channels": [nonlinearities("-1/2", 1), nonlinearities(-2, 9), nonlinearities(0, 5), nonlinearities(0, 2)],
        "repeated": False,
    },
    "theorem": "counterexample",
    "multiplier": {},
    "proof": {
        "method": "part",
        "channels": [2],
        "states": [2, 3],
        "kind": "transfer",
        "proof": {"method": "linear-gain", "gain": "-2"},
    },
}
# dead times: exp(-s)/(s + 1) in [0, 1], Re e^(-i w)(1 - i w) >= -1 - x/2 against 1 + x, beside 1/(s + 2)
LATE = {
    "verdict": "PROVED",
    "system": {
        "kind": "multivariable delay",
        "time": "continuous",
        "A": [["-1", "0"], ["0", "-2"]],
        "B": [["1", "0"], ["0", "1"]],
        "C": [["0", "0"], ["0", "1"]],
        "D": [["0", "0"], ["0", "0"]],
        "late": [["1", [["1", "0"], ["0", "0"]]]],
    },
    "laws": {"channels": [nonlinearities(0, "1/2"), nonlinearities(0, 5)], "repeated": False},
    "theorem": "parts",
    "multiplier": {},
    "proof": {
        "method": "parts",
        "parts": [
            {
                **{"channels": [1], "states": [1], "kind": "delay", "theorem": "circle", "multiplier": {}},
                "proof": {"method": "cover", "boxes": [["0", "1"], ["1", "2"], ["2", "3"]], "order": 20},
            },
            {
                **{"channels": [2], "states": [2], "kind": "multivariable", "theorem": "diagonal-circle"},
                "multiplier": {"lambda": ["1"]},
                "proof": {"method": "matrix", "P": [["4"]], "exponent": 0},
            },
        ],
    },
}


# a cascade: 1/(s + 2), of channel 3 and state 4, drives the rest, whose first loop drives the last
CASCADE = {**copy.deepcopy(STABLE), "theorem": "cascade"}
CASCADE["proof"]["parts"] = [
    {
        **{"channels": [3], "states": [4], "kind": "multivariable", "theorem": "diagonal-circle"},
        "multiplier": {"lambda": ["1"]},
        "proof": {"method": "matrix", "P": [["4"]], "exponent": 0},
    },
    {
        **{"channels": [1], "states": [1], "kind": "multivariable", "theorem": "diagonal-circle"},
        "multiplier": {"lambda": ["1"]},
        "proof": {"method": "matrix", "P": [["1"]], "exponent": 0},
    },
    CASCADE["proof"]["parts"][1],
    CASCADE["proof"]["parts"][2],
]
for side, i, j in (("A", 0, 3), ("B", 0, 2), ("C", 3, 0), ("A", 4, 3), ("B", 4, 0)):
    CASCADE["system"][side][i][j] = "7"
# in states z, x_4 = z_4 + z_1
TURNED = copy.deepcopy(STABLE)
TURNED["proof"]["basis"] = [[str(int(i == j or (i, j) == (3, 0))) for j in range(5)] for i in range(5)]
TURNED["system"]["A"][3] = ["1", "0", "0", "-2", "0"]  # S diag(-1, .., -2) S^-1: -z_1 - 2 (x_4 - x_1) = x_1 - 2 x_4
TURNED["system"]["B"][3] = ["1", "0", "1", "0"]
TURNED["system"]["C"][2] = ["-1", "0", "0", "1", "0"]


def both(draft):
    """What both checkers say of a draft; the certificate keeps the schema, and is read again as it was."""
    shown = complete_and_check(draft)
    certificate = json.loads(json.dumps(dict(shown.certificate)))
    FORMAT.validate(certificate)
    assert check(certificate) == shown
    opinion = recheck(certificate)
    assert opinion.accepted, opinion.reason
    return shown


def refused(draft):
    """Whether neither checker accepts a draft, the second with the conclusion that the whole one has."""
    with pytest.raises((Rejected, Malformed)):
        complete_and_check(draft)
    hopeful = {
        **{"format": "lure-certificate/1", "convention": "sigma = H mu, mu = -phi(sigma)", "numbers": "rationals"},
        **{"law": None, "hypotheses": {"class": "all"}, **draft},
    }
    ends = ("0 attracts every motion", "every motion converges to the set of equilibria", "every motion is bounded")
    moves = "a loop of the class has a motion that does not converge to an equilibrium"
    return not any(recheck({**hopeful, "conclusion": end}).accepted for end in (*ends, moves))


@pytest.mark.parametrize(
    ("draft", "conclusion"),
    [
        (PROOF, "every motion converges to the set of equilibria"),
        (STABLE, "0 attracts every motion"),
        (CASCADE, "0 attracts every motion"),
        (TURNED, "0 attracts every motion"),
        (LATE, "0 attracts every motion with inputs to the block and initial functions of finite energy"),
        (changed(STABLE, "laws", "channels", 0, "time_varying", True), "0 attracts every motion"),
    ],
)
def test_parts_by_hand_are_accepted_by_both_checkers(draft, conclusion):
    shown = both(draft)
    assert isinstance(shown, Proved)
    assert shown.certificate["conclusion"] == conclusion


def test_one_part_by_matrices_and_by_its_own_several_kind_is_the_same_loop():
    matrices = {"kind": "state-space", "proof": {"method": "matrix", "P": [["1"]], "exponent": 0, "zero": None}}
    draft = copy.deepcopy(PROOF)
    draft["proof"]["parts"][2] |= matrices
    assert isinstance(both(draft), Proved)


def test_what_a_part_assumes_the_whole_assumes():
    # sigma + phi(sigma) = y with phi in the sector [0, 2] alone may have several solutions
    shown = both(changed(PROOF, "laws", "channels", 3, "slope", None))
    assert shown.assumed == "in channel 4 sigma + D phi(sigma) = y, D = 1, has exactly one solution sigma for every y"
    assert not both(PROOF).assumed


def test_gains_that_depend_on_time_are_no_constant_ones():
    constant = changed(STABLE, "laws", "channels", 1, nonlinearities(0, 9, linear=True))
    constant["proof"]["parts"][1] |= {"theorem": "hurwitz", "multiplier": {}, "proof": {"method": "polynomial"}}
    assert both(constant).certificate["conclusion"] == "0 attracts every motion"
    assert refused(changed(constant, "laws", "channels", 1, "time_varying", True))


def test_a_member_of_one_part_refutes_the_whole():
    shown = both(COUNTER)
    assert isinstance(shown, Refuted)
    assert shown.facts["part"] == "the loop of channel 2 does not touch the others"
    assert shown.facts["class"].startswith("channel 1: ")  # of the whole


def test_a_nonlinearity_may_be_repeated_over_parts_and_an_operator_on_all_its_channels_may_not():
    same = changed(
        STABLE,
        "laws",
        {"channels": [nonlinearities(0, 1)] * 3 + [nonlinearities(0, 2, slope=True)], "repeated": [3, 1]},
    )
    assert "one nonlinearity in the channels 1 to 3" in both(same).facts["class"]
    operator = nonlinearities("-1/4", "1/4", operator="any", time_varying=True)
    draft = changed(
        STABLE, "laws", {"channels": [operator] * 3 + [nonlinearities(0, 2, slope=True)], "repeated": [3, 1]}
    )
    draft["proof"]["parts"][1] |= {
        **{"kind": "multivariable", "theorem": "diagonal-circle", "multiplier": {"lambda": ["1"]}},
        "proof": {"method": "matrix", "P": [["1"], ["0", "1"]], "exponent": 0},
    }
    assert refused(draft)
    assert isinstance(both(changed(draft, "laws", "repeated", False)), Proved)


PARTS, UNIT = ("proof", "parts"), [["1", "0"], ["0", "1"]]


@pytest.mark.parametrize(
    "draft",
    [
        changed(PROOF, "system", "A", 0, 1, "1/1000"),  # entries that join parts
        changed(PROOF, "system", "B", 1, 0, "1/1000"),
        changed(PROOF, "system", "C", 3, 0, "1/1000"),
        changed(PROOF, "system", "D", 0, 3, "1/1000"),
        changed(LATE, "system", "late", 0, 1, 1, 0, "1/1000"),
        changed(PROOF, *PARTS, [PAIR, INTEGRATOR]),  # a part is missing, or there twice
        changed(PROOF, *PARTS, [PAIR, INTEGRATOR, DIRECT, DIRECT]),
        changed(PROOF, *PARTS, [PAIR]),
        changed(PROOF, *PARTS, 2, "states", [4]),  # states of another part
        changed(PROOF, *PARTS, 0, "channels", [3, 1]),
        changed(PROOF, *PARTS, 0, "states", [1, 4, 9]),
        changed(PROOF, *PARTS, 2, "kind", "delay"),
        changed(PROOF, *PARTS, 0, "kind", "transfer"),
        changed(PROOF, *PARTS, 1, "kind", "multivariable"),
        changed(PROOF, *PARTS, 1, "multiplier", {"theta": "9/10"}),  # proofs that fail
        changed(PROOF, *PARTS, 0, "proof", "P", [["-1"], ["0", "4"]]),
        changed(PROOF, "laws", "channels", 2, nonlinearities(0, 50)),
        changed(PROOF, "laws", "channels", 1, "time_varying", True),
        changed(PROOF, *PARTS, 2, "theorem", "parts"),
        changed(PROOF, "theorem", "diagonal-circle"),
        changed(PROOF, "multiplier", {"lambda": ["1", "1", "1", "1"]}),
        changed(PROOF, "law", {"kind": "tanh", "height": "1", "rate": "1"}),
        changed(COUNTER, "proof", "proof", "gain", "-3"),  # outside the class
        changed(COUNTER, "proof", "channels", [4]),
        changed(COUNTER, "proof", "states", [2]),
        changed(COUNTER, "system", "A", 1, 0, "1/1000"),
        changed(COUNTER, "proof", "proof", COUNTER["proof"]),
        changed(COUNTER, "verdict", "PROVED"),
        {**PROOF, "rate": "1/10"},
        {**CASCADE, "theorem": "parts"},
        changed(CASCADE, *PARTS, CASCADE["proof"]["parts"][::-1]),  # another order
        changed(CASCADE, "system", "A", 3, 0, "1/1000"),
        changed(CASCADE, "system", "D", 3, 0, "1/1000"),  # at once
        changed(CASCADE, "laws", "channels", 2, nonlinearities(0, "inf")),
        {**PROOF, "theorem": "cascade"},  # a pole at 0
        {**LATE, "theorem": "cascade"},
        changed(TURNED, "proof", "basis", 3, 0, "2"),
        changed(TURNED, "proof", "basis", 3, ["1", "0", "0", "0", "0"]),
    ],
)
def test_what_does_not_fit_is_refused_by_both_checkers(draft):
    assert refused(draft)


def document(draft, **more):
    """What the second checker reads."""
    given = {"law": None, "conclusion": "", "hypotheses": {}, **draft, **more}
    return Document(nonlinearities=given.pop("laws"), nonlinearity=given.pop("law"), **given)


WHOLE = {**LATE["proof"]["parts"][1], "channels": [1, 2], "states": [1, 2], "kind": "multivariable delay"}
STATE = changed(PROOF, *PARTS, 2, "kind", "state-space")
LATE_PAIR = changed(LATE, *PARTS, 0, "kind", "multivariable delay")


# 2/(s + 1) + 1 of the states and channels that are named, in the order in which they stand
@pytest.mark.parametrize(
    ("draft", "place", "system"),
    [
        (PROOF, 0, {"A": [["-1", "0"], ["0", "-2"]], "B": UNIT, "C": UNIT, "D": [["0", "0"]] * 2}),
        (PROOF, 1, {"numerator": ["1"], "denominator": ["1", "1", "0"]}),
        (PROOF, 2, {"numerator": ["1", "3"], "denominator": ["1", "1"]}),
        (STABLE, 1, {"numerator": ["0"], "denominator": ["1", "2", "1"]}),
        (CASCADE, 1, {"A": [["-1"]], "B": [["1"]], "C": [["1"]], "D": [["0"]]}),
        (CASCADE, 3, {"numerator": ["1", "3"], "denominator": ["1", "1"]}),
        (TURNED, 0, {"A": [["-1", "0"], ["0", "-2"]], "B": UNIT, "C": UNIT, "D": [["0", "0"]] * 2}),
        (STATE, 2, {"A": [["-1"]], "b": ["1"], "c": ["2"], "d": "1"}),
        (LATE, 0, {"terms": [["1", ["1"]]], "denominator": ["1", "1"]}),
        (LATE_PAIR, 0, {"A": [["-1"]], "B": [["1"]], "C": [["0"]], "D": [["0"]], "late": [["1", [["1"]]]]}),
    ],
)
def test_the_second_checker_takes_the_same_parts(draft, place, system):
    found, stated = second.documents(document(draft))[place], draft["proof"]["parts"][place]
    time = {} if stated["kind"] == "delay" else {"time": "continuous"}
    assert found.system == {"kind": stated["kind"], **time, **system}
    assert (found.theorem, found.multiplier, found.proof) == tuple(
        stated[k] for k in ("theorem", "multiplier", "proof")
    )
    own = [draft["laws"]["channels"][i - 1] for i in stated["channels"]]
    several = stated["kind"].startswith("multivariable")
    assert found.nonlinearities == ({"channels": own, "repeated": [1] * len(own)} if several else own[0])


@pytest.mark.parametrize(
    ("draft", "more"),
    [
        (PROOF, {"rate": "1/10"}),
        (PROOF, {"law": {"kind": "tanh", "height": "1", "rate": "1"}}),
        (PROOF, {"verdict": "OPEN"}),
        (PROOF, {"theorem": "counterexample"}),
        (PROOF, {"multiplier": {"lambda": ["1"]}}),
        (COUNTER, {"multiplier": {"lambda": ["1"]}}),
        (COUNTER, {"theorem": "parts"}),
        (COUNTER, {"verdict": "PROVED"}),
        (changed(STATE, *PARTS, 2, "states", [0]), {}),
        (changed(STATE, *PARTS, 2, "states", [6]), {}),
        (changed(STATE, *PARTS, 2, "states", []), {}),
        (changed(STATE, *PARTS, 0, "states", [4, 1]), {}),
        (changed(LATE, *PARTS, 0, "kind", "state-space"), {}),
        (changed(LATE, *PARTS, 0, "kind", "multivariable"), {}),
        (changed(LATE, *PARTS, 1, "kind", "multivariable delay"), {}),
        (changed(LATE, *PARTS, 1, "kind", "delay"), {}),
        (changed(LATE, "system", "late", [["1", UNIT, [["0", "1"], ["0", "0"]]]]), {}),  # what comes back joins
        (changed(LATE, *PARTS, [WHOLE]), {}),  # which is no part
        (changed(CASCADE, "laws", "channels", 2, nonlinearities(0, "inf")), {}),
        (changed(CASCADE, "laws", "channels", 2, nonlinearities(0, "finite")), {}),
        (changed(CASCADE, "laws", "channels", 2, nonlinearities("-inf", 1)), {}),
        (changed(CASCADE, "laws", "channels", 2, nonlinearities(0, 5) | {"regularity": "any"}), {}),
        (changed(CASCADE, *PARTS, CASCADE["proof"]["parts"][::-1]), {}),
        (changed(CASCADE, "system", "D", 3, 0, "1/1000"), {}),
    ],
)
def test_the_second_checker_takes_no_others(draft, more):
    with pytest.raises(NotShown):
        second.documents(document(draft, **more))


def test_a_part_keeps_its_dead_times():
    one, other, none = [["1", "0"], ["0", "0"]], [["0", "0"], ["0", "1/2"]], [["0", "0"]] * 2
    for own in ([one], [other], [one, none], [none, other]):  # for the outputs, and for what comes back
        whole = changed(LATE, "system", "late", [["1", *own], ["2", *[none] * len(own)]])
        proof = {"method": "part", "channels": [1, 2], "states": [1, 2], "kind": "multivariable delay", "proof": {}}
        given = {"verdict": "REFUTED", "theorem": "counterexample", "proof": proof}
        (found,) = second.documents(document(whole, **given))
        assert found.system["late"] == [["1", *own]]


@pytest.mark.parametrize(
    ("theorem", "said", "found"),
    [
        ("parts", ["ATTRACTS", "ATTRACTS"], "ATTRACTS"),
        ("parts", ["GAINS", "GAINS"], "ATTRACTS"),
        ("parts", ["ATTRACTS", "EQUILIBRIA"], "EQUILIBRIA"),
        ("parts", ["BOUNDED", "EQUILIBRIA"], "BOUNDED"),
        ("parts", ["ATTRACTS", "DELAYED", "GAINS"], "DELAYED"),
        ("parts", ["DELAYED", "EQUILIBRIA"], None),
        ("parts", ["ATTRACTS", "GAIN"], None),
        ("parts", ["NO_REST", "ATTRACTS"], None),
        ("cascade", ["ATTRACTS", "GAINS"], "ATTRACTS"),
        ("cascade", ["ATTRACTS", "EQUILIBRIA"], None),
        ("cascade", ["EQUILIBRIA", "EQUILIBRIA"], None),
    ],
)
def test_of_the_whole_the_weakest_follows(theorem, said, found):
    given = document(LATE, theorem=theorem), [getattr(classes, one) for one in said]
    with assert_accepted_if(found is not None):
        assert second.together(*given) == getattr(classes, str(found))
    if found == "DELAYED":
        wide = changed(LATE, "laws", "channels", 1, nonlinearities(0, "finite"))
        with pytest.raises(NotShown, match="no upper bound"):
            second.together(document(wide, theorem=theorem), given[1])


def test_the_numerator_of_a_part_is_that_of_its_matrices():
    A, B, C = fmpq_mat([[1, 2, 0], [3, -1, 5], [0, 7, 2]]), fmpq_mat([[1], [0], [4]]), fmpq_mat([[2, 1, -3]])
    for direct in (fmpq(0), fmpq(5, 3)):
        top = from_descending(numbers(second._top(A, B, C, direct, A.charpoly())))
        exact = at((A, B, C, fmpq_mat([[direct]])), fmpq(3))[0, 0]
        assert top(fmpq(3)) == exact * A.charpoly()(fmpq(3))


@pytest.mark.parametrize(
    ("kind", "together"), [("any", True), ("full block", True), (classes.SCALAR, False), ("delay", False)]
)
def test_an_operator_of_several_channels_is_in_one_part(kind, together):
    law = nonlinearities(-1, 1, operator=kind, time_varying=kind in ("any", "full block"))
    one = changed(LATE, "laws", {"channels": [law] * 2, "repeated": [2]})
    asked = channels.read(document(one))
    second._require_whole_operators(asked, [0, 1])
    for channel in (0, 1):
        with assert_accepted_if(not together):
            second._require_whole_operators(asked, [channel])
