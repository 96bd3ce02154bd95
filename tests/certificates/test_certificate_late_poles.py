"""Popov terms and poles at 0 beside dead times, also with late feedback: by hand, and what is rejected."""

from fractions import Fraction
from functools import cache

import pytest
from late_loops import NO, ONE, draft, late, sector
from tampering import assert_both_reject, edited

from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second.opinion import recheck

ATTRACTS = "0 attracts every motion with inputs to the block and initial functions of finite energy"
UNIT, NONE = [["1", "0"], ["0", "1"]], [["0", "0"]] * 2
ENDS = [str(end) for end in (1, 2, 3, 4, 6, 8, 12, 16)]


def proved(system, classes, weights, theta, ends=ENDS):
    multiplier = {"lambda": weights, "theta": theta, "pieces": [[None] * len(weights)] * (len(ends) + 1)}
    return draft(system, classes, "piecewise-popov", {"method": "pieces", "ends": ends}, multiplier)


def fixed(low, high, **more):
    return sector(low, high, time_varying=False, **more)


# 1/chi, chi = s + 1 - exp(-s) = 2 s + ..: Re chi = 1 - cos(w) >= 0, so that Re 1/chi >= 0 for every k
BACK = proved(late([["-1"]], ONE, ONE, NO, ("1", NO, [["1"]])), [fixed("0", "10")], ["1"], ["0"])
# diag(exp(-s)/s, G), G = exp(-s)/(s + 1): F_11/2 = 1 + cos(w)/4 - sin(w)/(2 w) > 0, and for [-1/2, 3/2] F_22/2 = 1 +
# Re G - 3/4 |G|^2 is 1 + w^2 + cos(w) - w sin(w) - 3/4 over 1 + w^2: above 5/4 - w^2/2, and above w^2 - w - 3/4
PLANT = late([["0", "0"], ["0", "-1"]], UNIT, NONE, NONE, ("1", UNIT))
BOTH = proved(PLANT, [fixed("0", "1/2"), sector("-1/2", "3/2")], ["1", "1"], ["1/4", "0"])
# shifted by (0, 1/4): F_22/2 = 1 + 3/4 Re 1/(1/G + 1/4), and |1/G + 1/4| > 1 - 1/4 for w > 0
SHIFTED = proved(PLANT, [fixed("0", "1/2"), sector("1/4", "1")], ["1", "1"], ["1/4", "0"])
# x' = mu_1 + mu_2, sigma = (x, 2 x) of 1/4 before: with the weights 2 and 1, S = [[2, 2], [2, 2]], and F = 2 diag(2, 1)
# + 2 S Re (exp(-iw/4) - 1)/iw >= [[4, 0], [0, 2]] - S/2, of the determinant 5
TIED = proved(
    late([["0"]], [["1", "1"]], NO * 2, NONE, ("1/4", [["1"], ["2"]])), [fixed("0", "1")] * 2, ["2", "1"], ["0", "0"]
)
# chi = s^2 + s (1 - exp(-s)) = 2 s^2 + .. with two states: diag(1/(s + 1 - exp(-s)), exp(-s/4)/s), two poles
TWO = proved(
    late(
        [["-1", "0"], ["0", "0"]],
        UNIT,
        [["1", "0"], ["0", "0"]],
        NONE,
        ("1/4", [["0", "0"], ["0", "1"]], NONE),
        ("1", NONE, [["1", "0"], ["0", "0"]]),
    ),
    [fixed("0", "5"), fixed("0", "1")],
    ["1", "1"],
    ["0", "0"],
)
ALL = {"back": BACK, "both": BOTH, "shifted": SHIFTED, "tied": TIED, "two": TWO}


@cache
def certificate(name):
    return dict(complete_and_check(ALL[name]).certificate)


@pytest.mark.parametrize("name", ALL)
def test_both_checkers_accept(name):
    found = certificate(name)
    assert recheck(found).accepted, recheck(found).reason
    # beside functions that depend on time too, in channels that do not show the pole
    assert found["conclusion"] == "every motion converges to the set of equilibria"
    for other in (ATTRACTS, "every motion is bounded"):
        assert not recheck(found | {"conclusion": other}).accepted


FIRST, SECOND = ("laws", "channels", 0), ("laws", "channels", 1)
DELAY = fixed("-1", "1", operator="delay")


@pytest.mark.parametrize(
    "change",
    [
        ("back", *FIRST, "time_varying", True),
        ("back", *FIRST, "sector", ["-1/100", "10"]),  # small negative gains destabilise
        ("back", "system", "C", [["-1"]]),  # residue -1/2
        ("back", "system", "late", [["1", NO, [["101/100"]]]]),  # a root s > 0
        ("back", "system", "late", [["1", NO, ONE, NO, [["1/10"]]]]),  # a neutral equation
        ("back", "multiplier", "theta", ["-1/100"]),
        ("both", *FIRST, "time_varying", True),
        ("both", *FIRST, "sector", ["-1/100", "1/2"]),
        ("both", "multiplier", "theta", ["1/4", "1/100"]),
        ("both", *SECOND, fixed("-1/2", "1/2", operator="any")),
        ("both", *SECOND, DELAY),
        ("both", "system", "D", [["0", "1/1000"], ["0", "0"]]),  # what depends on time acts on the integrator's sigma
        ("both", "system", "A", NONE),
        ("shifted", *SECOND, "sector", ["1/4", "20"]),
        ("shifted", "system", "A", [["0", "1"], ["0", "-1"]]),  # R_12 alone
        ("tied", "multiplier", "lambda", ["1", "1"]),
        ("tied", "multiplier", "lambda", ["0", "0"]),
        ("tied", "system", "late", [["1/4", [["1"], ["-2"]]]]),
        ("tied", "system", "late", [["9/4", [["1"], ["2"]]]]),  # F(0) < 0
        ("two", "system", "B", [["1", "0"], ["0", "-1"]]),
        ("two", "system", "A", [["-1", "0"], ["1", "0"]]),  # 1/s^2
    ],
    ids=lambda change: "-".join(map(str, change[:-1])),
)
def test_neither_checker_accepts_what_is_tampered_with(change):
    name, *path, value = change
    found = edited(certificate(name), *path, value=value)
    assert_both_reject(edited(found, "multiplier", "theta", value=["0", "0"]) if value is DELAY else found)


def test_beside_a_pole_at_0_linear_gains_are_refused():
    plain = complete_and_check(edited(BOTH, "multiplier", "theta", value=["0", "0"])).certificate
    linear = edited(plain, "laws", "channels", 1, value=fixed("-1/2", "1/2", linear=True))  # F > 0 all the same
    linear["multiplier"] |= {"lambda": ["1", "0"], "pieces": [[None, ["1", "0"]]] * (len(ENDS) + 1)}
    assert_both_reject(linear)


def test_what_depends_on_time_acts_on_no_output_that_shows_a_pole_at_0():
    # TIED, whose outputs both show the pole, beside exp(-s/4)/(s + 1); D_23 = 1/1000 leaves F > 0
    rows = [["1", "1", "0"], ["0", "0", "1"]], [["0", "0"]] * 3, [["0"] * 3] * 3
    plant = late([["0", "0"], ["0", "-1"]], *rows, ("1/4", [["1", "0"], ["2", "0"], ["0", "1"]]))
    three = proved(plant, [*[fixed("0", "1")] * 2, sector("0", "1/2")], ["2", "1", "1"], ["0"] * 3)
    found = complete_and_check(three).certificate
    assert recheck(found).accepted
    assert_both_reject(edited(found, "system", "D", 1, value=["0", "0", "1/1000"]))


# s H goes to w + w^2/2, w = exp(-i omega): its real part is least, -3/4, where cos omega = -1/2; with phases apart -3/2
def test_dead_times_that_are_multiples_of_one_have_one_phase_far_out():
    plant = late([["-1"]], ONE, NO, NO, ("1", ONE), ("2", [["1/2"]]))
    ends = [str(Fraction(end, 4)) for end in range(1, 513)]
    found = complete_and_check(proved(plant, [fixed("0", "1/50")], ["1"], ["9/10"], ends)).certificate
    assert recheck(found).accepted
    assert_both_reject(edited(found, "multiplier", "theta", value=["27/20"]))
