"""Parameters that change so that some solution grows: exact limits, one plant as an oracle, and tampering."""

from fractions import Fraction
from math import inf

import pytest
from certificate_format import FORMAT
from handwritten import nonlinearities
from tampering import assert_both_reject, edited

from lure import NonlinearityClass, Sector, certify, max_sector
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.verdict import Verdict
from lure.plants.channel_family import ChannelFamily

JUMPING, STILL = (NonlinearityClass(sector=Sector(0, 1), time_varying=jumps) for jumps in (True, False))
HALF = Fraction(1, 2)


def spring(low, high, rate, damping="1", C=((1, 0),)):
    """``x'' + d x' + a x = mu``."""
    return ChannelFamily.of_matrices([[0, 1], ["-a", f"-{damping}"]], [[0], [1]], C, None, {"a": (low, high, rate)})


def accepted(certificate):
    FORMAT.validate(dict(certificate))
    assert recheck(certificate).accepted
    assert certificate["proof"]["method"] == "members"
    return certificate


# x1+ = c (1 + p) x2, x2+ = c (1 - p) x1, p in [-1, 1]: eigenvalues +-c sqrt(1 - p^2) for a constant p, < 1 if c < 1;
# p = 1 and then -1 multiply x2 by (2 c)^2, and |x+| <= 2 c |x| whatever p does: c = 1/2 is the limit, from both sides
@pytest.mark.parametrize(("c", "verdict"), [("499/1000", Verdict.PROVED), ("501/1000", Verdict.REFUTED)])
def test_a_parameter_that_jumps_from_sample_to_sample_is_decided_on_both_sides_of_the_limit(c, verdict):
    A = [[0, f"{c}*(1 + p)"], [f"{c}*(1 - p)", 0]]
    loop = ChannelFamily.of_matrices(A, [["1/100000"], [0]], [[1, 0]], None, {"p": (-1, 1, inf)}, 1)
    found = certify(loop, [STILL])
    assert found.verdict is verdict
    if verdict is Verdict.REFUTED:
        accepted(found.certificate)


# with phi = g(t) x it is x'' + x' + (a(t) + g(t)) x = 0: the sum jumps in [1, 2 + k], or in [1, 1 + k'] with a = 1
@pytest.mark.slow
def test_gains_and_parameters_that_jump_together_do_what_one_gain_does():
    alone = max_sector(([1], [1, 1, 1]), JUMPING).refuted_at
    both, constant = (max_sector(spring(1, 2, rate), [JUMPING]) for rate in (inf, 0))
    assert both.refuted_at == pytest.approx(alone - 1, rel=1e-6)
    assert constant.refuted_at == pytest.approx(alone, rel=1e-6)
    proof = accepted(both.refutation.certificate)
    for path, value in (
        (("system", "rates"), ["1"]),
        (("system", "parameters", 0, 2), "3/2"),
        (("system", "kind"), "channel-family"),
        (("laws", "channels", 0, "time_varying"), False),
        (("laws", "channels", 0, "sector", 1), "2"),
        (("proof", "at", 0), ["3"]),
        (("proof", "times", 0), "-1"),
        (("proof", "times"), proof["proof"]["times"][:1]),
        (("proof", "gains"), [["0"]] * len(proof["proof"]["gains"])),
        (("proof", "at"), [["1"]] * len(proof["proof"]["at"])),
    ):
        assert_both_reject(edited(proof, *path, value=value))


# a lightly damped spring is pumped by its stiffness, as a child on a swing pumps itself: also at a bounded rate
@pytest.mark.slow
def test_a_parameter_that_goes_at_its_rate_refutes_and_no_faster():
    found = certify(spring(HALF, 3 * HALF, 1, "0.1"), [STILL])
    proof = accepted(found.certificate)
    assert found.verdict is Verdict.REFUTED
    assert certify(spring(HALF, 3 * HALF, Fraction(1, 10), "0.1"), [STILL]).verdict is Verdict.PROVED
    half = [str(Fraction(t) / 2) for t in proof["proof"]["times"]]
    for path, value in ((("system", "rates"), ["9/10"]), (("system", "rates"), ["0"]), (("proof", "times"), half)):
        assert_both_reject(edited(proof, *path, value=value))
    # the gain 0 closes the same loop, but where a stands in C too the loop need not go linearly: not covered
    seen = spring(HALF, 3 * HALF, 1, "0.1", C=(("a", 0),))
    assert certify(seen, [STILL]).certificate is None


# x' = a x, from a = -2 to 1 in the time t and back in 1: at its own rate a has the mean -1/2, and nothing grows; if it
# jumped at once, 1 would be held for t; likewise from 1 to -2 if it stayed where it is
@pytest.mark.slow
def test_a_parameter_on_its_way_is_followed_and_not_where_it_begins_or_ends():
    def term(power, common, a, b):
        return {"powers": [power], "common": common, "A": [[a]], "B": [[b]], "C": [[b]], "D": [["0"]]}

    terms = [term(0, "1", "0", "1"), term(1, "0", "1", "0")]
    plant = {"kind": "varying-family", "time": "continuous", "parameters": [["a", "-2", "1"]], "terms": terms}
    path = {"method": "members", "gains": [["0"], ["0"]], "times": ["4", "1"], "squarings": 4, "bits": 256}
    jumps = {
        **{"verdict": "REFUTED", "theorem": "counterexample", "multiplier": {}},
        "system": {**plant, "rates": ["inf"]},
        "laws": {"channels": [nonlinearities(0, 1)], "repeated": False},
        "proof": {**path, "at": [["1"], ["-2"]]},
    }
    shown = complete_and_check(jumps).certificate
    assert recheck(shown).accepted
    goes = edited(shown, "system", "rates", value=["3"])
    for at in ([["-2"], ["1"]], [["1"], ["-2"]]):
        assert_both_reject(edited(goes, "proof", "at", value=at))


def family(rate, terms, low="0", high="4"):
    """Of one state and one channel: for each power of p the common denominator, A, B, C, D."""
    listed = [
        {"powers": [e], "common": c, "A": [[a]], "B": [[b]], "C": [[s]], "D": [[d]]}
        for e, (c, a, b, s, d) in enumerate(terms)
    ]
    found = {"kind": "varying-family", "time": "continuous", "parameters": [["p", low, high]], "terms": listed}
    return found | {"rates": [rate]}


def drafted(system, theorem, proof, law=None):
    laws = {"channels": [law or nonlinearities(0, 1)], "repeated": False}
    verdict = "REFUTED" if theorem == "counterexample" else "PROVED"
    found = {"verdict": verdict, "system": system, "laws": laws, "theorem": theorem, "proof": proof}
    return found | {"multiplier": {}}


# x' = (p - 2) x beside phi = 0: p from 4 to 1 and back in 2 units of time each, at the rate 3/2, multiplies x by e^2
MOVES = drafted(
    family("3/2", [("1", "-2", "1", "1", "0"), ("0", "1", "0", "0", "0")]),
    "counterexample",
    {"method": "members", "at": [["4"], ["1"]], "gains": [["0"]] * 2, "squarings": 0, "bits": 128, "times": ["2", "2"]},
)
# x' = -(1 + p) x with all of it twice over a common denominator 2, P = 3 - 2 p on [0, 1]: -V' = 2 (1 + p)(3 - 2 p) +
# 2 p', 4 - 2 r at the least, r < 2; phi, which moves nothing, takes a little
LEAF = {"multiplier": {"lambda": ["1/1000"], "P": [[["3"]], [["-2"]]], "exponent": 0}}
FALLS = drafted(
    family("199/100", [("2", "-2", "0", "1", "0"), ("0", "-2", "0", "0", "0")], "0", "1"),
    "diagonal-circle",
    {"method": "boxes", "boxes": LEAF},
)


@pytest.mark.parametrize("found", [MOVES, FALLS], ids=["moves", "falls"])
def test_parameters_that_move_are_decided_by_hand(found):
    assert recheck(complete_and_check(found).certificate).accepted


@pytest.mark.slow_for("found7-edits7", "found13-edits13")
@pytest.mark.parametrize(
    ("found", "edits"),
    [
        (MOVES, {("system", "rates"): ["149/100"]}),
        (MOVES, {("system", "rates"): ["0"]}),
        (MOVES, {("proof", "times"): ["1", "2"]}),
        (MOVES, {("proof", "times"): ["2", "1"]}),
        (MOVES, {("proof", "times"): ["1/2", "1/2"]}),
        (MOVES, {("proof", "times"): ["2", "-2"]}),
        (MOVES, {("proof", "times"): ["2"]}),
        (MOVES, {("proof", "at"): [["4"], ["0"]], ("proof", "times"): ["3", "3"]}),  # 0 on the average
        (MOVES, {("proof", "at"): [["5"], ["2"]]}),
        (MOVES, {("proof", "at"): [["4"]]}),
        (MOVES, {("proof", "at"): [["4"], ["4"], ["1"]]}),
        (MOVES, {("proof", "gains"): [["0"], ["1/4"]]}),
        (MOVES, {("proof", "gains"): [["-1"], ["-1"]]}),
        (MOVES, {("proof", "gains"): [["1"], ["1"]]}),  # e^0
        (MOVES, {("laws", "channels", 0): nonlinearities(-1, 1, operator="any", time_varying=True)}),
        (MOVES, {("laws", "channels", 0): nonlinearities(0, 1, slope=True, relu=True)}),
        (MOVES, {("laws", "channels", 0): nonlinearities(0, 1, slope=True, memory="stop")}),
        (MOVES, {("system", "time"): "discrete"}),
        (MOVES, {("system", "terms", 1, "B"): [["1/100"]]}),  # what goes linearly stands in A alone
        (MOVES, {("system", "terms", 1, "C"): [["1/100"]]}),
        (MOVES, {("system", "terms", 1, "common"): "1/100"}),
        (MOVES, {("system", "terms", 1, "powers"): [2]}),
        (FALLS, {("system", "rates"): ["2"]}),
        (FALLS, {("system", "rates"): ["3"]}),
        (FALLS, {("system", "rates"): ["inf"]}),
        (FALLS, {("system", "time"): "discrete"}),
        (FALLS, {("system", "parameters", 0, 2): "1/4"}),  # P moves faster there
        (FALLS, {("proof", "boxes"): {"parameter": 0, "at": "1/2", "below": LEAF, "above": LEAF}}),
        (FALLS, {("system", "terms", 0, "common"): "-2"}),
        (FALLS, {("system", "terms", 1, "common"): "-3"}),  # it vanishes for p = 2/3
        (FALLS, {("proof", "boxes", "multiplier", "P"): [[["3"]], [["-3"]]]}),
        (FALLS, {("proof", "boxes", "multiplier", "lambda"): ["-1/1000"]}),
        (FALLS, {("proof", "boxes", "multiplier", "P", 0, 0, 0): "2"}),
    ],
)
def test_parameters_that_move_otherwise_are_not(found, edits):
    found = complete_and_check(found).certificate
    for path, value in edits.items():
        found = edited(found, *path, value=value)
    assert_both_reject(found)
