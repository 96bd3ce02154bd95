"""Rates of decay beside known dead times, and poles from w to z: certificates, and what neither checker accepts."""

import pytest
from late_loops import INTEGRATOR, LAG, NO, ONE, draft, late, sector
from tampering import assert_both_reject, edited

from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second.opinion import recheck

# exp(-s)/(s + 1), [-1/2, 1/2]: with s - r for s 1 > e^r |H(i w - r)|/2 while e^r < 2 (1 - r), r < .314923; -1/2 has the
# root s = -r where 1 - r = e^r/2.  Were the dead time not weighed, 1/2 would be the limit
HALVES = draft(
    LAG,
    [sector("-1/2", "1/2")],
    "piecewise-circle",
    {"method": "pieces", "ends": ["1", "2"]},
    {"lambda": ["1"], "pieces": [[None]] * 3},
) | {"rate": "157/500"}
NO_FASTER = draft(LAG, [sector("-1/2", "1/2")], "counterexample", {"method": "late-turns", "gains": ["-1/2"]})
NO_FASTER |= {"rate": "63/200"}
# x' = -k x(t - 1), k in [1/5, 7/20]: s = W_0(-k), W_0(-1/5) = -.259171 and W_0(-7/20) = -.71; 2/5 has complex ones
SLOW = draft(
    INTEGRATOR,
    [sector("1/5", "7/20")],
    "piecewise-circle",
    {"method": "pieces", "ends": ["1/8", "1/4", "1/2", "1", "2", "4", "8"]},
    {"lambda": ["1"], "pieces": [[None]] * 8},
) | {"rate": "259/1000"}
# x' = -x - x(t - 1)/2 - phi(x), phi in [0, 2]: Re (i w - r + 1 + e^(r - i w)/2) > -1/2 near w = 1 up to r = .907
COMING = draft(
    late([["-1"]], ONE, ONE, NO, ("1", NO, [["-1/2"]])),
    [sector("0", "2")],
    "piecewise-circle",
    SLOW["proof"],
    SLOW["multiplier"],
) | {"rate": "9/10"}


# exp(-s)/(s + 1), slopes in [0, 1]: the root with the gain 1 is at -.605 + 1.79 i; .13 <= theta <= .37 serves
SLOPED = draft(
    LAG,
    [sector("0", "1", slope=["0", "1"], time_varying=False)],
    "piecewise-popov",
    {"method": "pieces", "ends": ["1/4", "1/2", "1", "2", "3", "4", "6", "8", "16"]},
    {"lambda": ["1"], "theta": ["1/4"], "pieces": [[None]] * 10},
) | {"rate": "23/40"}
# slopes in [0, 1/10], theta = 1/2: F/2 > 1 - e^a (1/10 + 1/2)/(1 - a) at all of these rates, and 1/10 >= a/2 up to 1/5
PAID = edited(edited(SLOPED, "laws", "channels", 0, "sector", value=["0", "1/10"]), "rate", value="1/5")
PAID = edited(edited(PAID, "laws", "channels", 0, "slope", value=["0", "1/10"]), "multiplier", "theta", value=["1/2"])


@pytest.mark.parametrize(
    "draft",
    [HALVES, NO_FASTER, SLOW, COMING, SLOPED, PAID],
    ids=["both", "slower", "lower", "inside", "slopes", "paid"],
)
def test_both_checkers_accept_rates_beside_dead_time(draft):
    shown = complete_and_check(draft)
    falls, grows = "|x(t)| <= c m exp(-{} t) for every motion", "for which x(t) exp({} t) does not tend to 0"
    rate = shown.certificate["rate"]
    assert (grows if draft["verdict"] == "REFUTED" else falls).format(rate) in shown.claim
    assert recheck(shown.certificate).accepted


@pytest.mark.parametrize(
    ("draft", "edits"),
    [
        (HALVES, {("rate",): "315/1000"}),
        (HALVES, {("proof", "ends"): [], ("multiplier", "pieces"): [[None]]}),
        (HALVES, {("system", "late", 0, 0): "101/100"}),  # e^(r T) < 2 (1 - r) ends below .314
        (NO_FASTER, {("rate",): "314/1000"}),
        (NO_FASTER, {("proof",): {"method": "late-gains", "gains": ["-1/2"]}}),
        (SLOW, {("rate",): "260/1000"}),
        (SLOW, {("laws", "channels", 0, "sector"): ["0", "7/20"]}),
        (COMING, {("rate",): "1"}),  # too fast for the criterion
        (COMING, {("system", "late"): [["1", NO, [["-1/2"]], NO, NO]]}),  # a neutral equation
        (SLOPED, {("multiplier", "theta"): ["2"]}),  # more than lambda pays for
        (SLOPED, {("multiplier", "lambda"): ["1/2"]}),
        (PAID, {("rate",): "21/100"}),  # lambda does not pay for theta, and F > 0
        (SLOPED, {("laws", "channels", 0, "slope"): None}),  # a sector alone
        (SLOPED, {("laws", "channels", 0, "time_varying"): True}),
        (SLOPED, {("rate",): "61/100"}),
    ],
)
def test_rates_beside_dead_time_that_are_not_shown_are_refused(draft, edits):
    shown = complete_and_check(draft).certificate
    for path, value in edits.items():
        shown = edited(shown, *path, value=value)
    assert_both_reject(shown)


def test_the_plant_alone_is_no_slower_than_its_poles():
    # exp(-s)/(s + 1) with the gain 0: exp(-t)
    alone = edited(NO_FASTER, "proof", "gains", value=["0"]) | {"rate": "101/100"}
    found = complete_and_check(alone).certificate
    assert recheck(found).accepted
    assert_both_reject(edited(found, "rate", value="99/100"))


def test_a_pole_at_0_beside_dead_time_has_not_the_rate_0():
    # 1 + Re exp(-i w)/(2 i w) = 1 - sin(w)/(2 w) > 0: solutions converge to equilibria, of which no rate speaks
    known = [sector("0", "1/2", time_varying=False)]
    found = draft(INTEGRATOR, known, "piecewise-circle", SLOW["proof"], SLOW["multiplier"])
    assert_both_reject({**complete_and_check(found).certificate, "rate": "0"})


def test_the_sentence_about_a_rate_beside_dead_time_speaks_of_the_past():
    shown = complete_and_check(HALVES).certificate
    assert_both_reject({**shown, "conclusion": shown["conclusion"].replace("c m", "c |x(0)|")}, stored=True)
    assert_both_reject({key: value for key, value in shown.items() if key != "rate"}, stored=True)


# exp(-s)/(s + 1) with the gain 3: s = W(-3 e) - 1 = .21400... + 2.0958... i; w_1 = mu, z_1 = sigma; z_2 = w_2/(s + 3)
def endless(gain, root, radius, between=(1, 1)):
    both = late(
        [["-1", "0"], ["0", "-3"]],
        [["1", "1", "0"], ["0", "0", "1"]],
        [["0", "0"], ["0", "0"], ["0", "1"]],
        [["0"] * 3] * 3,
    )
    both["late"] = [["1", [["1", "0"], ["1", "0"], ["0", "0"]]]]
    known = [sector("0", "4"), *[sector("-1", "1", time_varying=True) | {"operator": "performance"}] * 2]
    proof = {"method": "late-gains", "gains": [gain, "0", "0"], "unlimited": [*between], "root": root, "radius": radius}
    found = draft(both, known, "counterexample", proof)
    return found | {"laws": {"channels": known, "repeated": [1, 2]}}


ROOT = ["21400352638555/100000000000000", "209581888472440/100000000000000"]
ENDLESS = endless("3", ROOT, "1/1000000")
# s - 1 has its root sqrt(2)/10 away from 11/10 + i/10, and no component of what is left is above 1/10
WELL_OFF = {
    ("system", "A"): [["1", "0"], ["0", "-3"]],
    ("proof", "gains"): ["0", "0", "0"],
    ("proof", "root"): ["11/10", "1/10"],
    ("proof", "radius"): "113/1000",
}
RESTING = edited(endless("0", ["0", "0"], "0"), "system", "A", value=[["0", "0"], ["0", "-3"]])  # exp(-s)/s


@pytest.mark.parametrize("draft", [ENDLESS, RESTING], ids=["beyond", "on the axis"])
def test_both_checkers_accept_a_pole_from_w_to_z(draft):
    shown = complete_and_check(draft)
    assert "no L2 gain from w to z is finite for all loops of the class" in shown.claim
    assert recheck(shown.certificate).accepted


@pytest.mark.parametrize(
    ("draft", "edits"),
    [
        (ENDLESS, {("proof", "unlimited"): [2, 1]}),  # z_2 does not see it
        (ENDLESS, {("proof", "unlimited"): [1, 2]}),  # w_2 does not move it
        (ENDLESS, {("proof", "unlimited"): [2, 2]}),
        (ENDLESS, {("proof", "gains"): ["1", "0", "0"]}),
        (ENDLESS, {("proof", "gains"): ["5", "0", "0"]}),
        (ENDLESS, {("proof", "root", 0): "1/10"}),
        (ENDLESS, {("proof", "root", 1): "2"}),
        (ENDLESS, {("proof", "radius"): "0"}),
        (ENDLESS, {("proof", "radius"): "1"}),
        (ENDLESS, {("proof", "method"): "late-turns"}),
        (ENDLESS, {("system", "late", 0, 0): "1/2"}),
        (ENDLESS, {("rate",): "1/100"}),
        (ENDLESS, WELL_OFF),
        (RESTING, {("proof", "gains"): ["1", "0", "0"]}),
        (RESTING, {("proof", "unlimited"): [2, 2]}),
        (RESTING, {("system", "A"): [["-1", "0"], ["0", "-3"]]}),
    ],
)
def test_a_pole_from_w_to_z_that_is_none_is_refused(draft, edits):
    shown = complete_and_check(draft).certificate
    for path, value in edits.items():
        shown = edited(shown, *path, value=value)
    assert_both_reject(shown)
