"""Kernels of one function of a plant with dead time, of neutral type too: certificates by hand, and what is refused."""

import copy
from fractions import Fraction
from functools import cache

import pytest
from certificate_format import FORMAT
from late_loops import LAG, NO, ONE, draft, late, sector
from tampering import assert_both_reject, edited

from lure.analysis.certificates.arithmetic import Form
from lure.analysis.certificates.balls import turning
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second.opinion import recheck

CLASS, KERNEL = ("laws", "channels", 0), ("multiplier", "kernels", 0)


def slope(low, high, **more):
    return sector(low, high, slope=[low, high], time_varying=False, **more)


def kernel(coefficient, rate, order=1, side="causal"):
    return {"coefficient": coefficient, "rate": rate, "order": order, "side": side}


def proof(*ends):
    return {"method": "pieces", "ends": [*map(str, ends)]}


# 1/(s^2 + s/5 + 4) + exp(-s)/8: beside the resonance Re H = -.92, so that the circle criterion ends at .798; linear
# gains end at 3.6545.  M = 1 - .9 (10/(10 + s))^2 is small below 4 and lags behind by little
ECHO = late([["0", "1"], ["-4", "-1/5"]], [["0"], ["1"]], [["1", "0"]], NO)
ECHO["late"] = [["1", [["1/2", "1/40"]], [["0", "0"], ["0", "0"]], [["0", "1/8"]], [["0", "0"], ["0", "0"]]]]
KERNELS = draft(
    ECHO,
    [slope("0", "3")],
    "late-zames-falb",
    proof(*(Fraction(i, 2) for i in range(1, 33))),
    {"lambda": ["1"], "theta": ["0"], "kernels": [kernel("9/10", "10", 2)]},
)
# 1/(s + 1 + s exp(-s)/2) is positive real; with a kernel F/2 = Re M (1 + 3 H)
BELOW = draft(
    late([["-1"]], ONE, ONE, NO, ("1", NO, NO, NO, [["-1/2"]])),
    [slope("0", "3", odd=True)],
    "late-zames-falb",
    proof(*(Fraction(i, 2) for i in range(1, 33))),
    {"lambda": ["1"], "theta": ["1/100"], "kernels": [kernel("-1/4", "1", 1, "anticausal")]},
)
# exp(-s)/(s + 1), |H| <= 1: F/2 = Re (1 - H/2)^* M (1 + H/2) is about 1 - |H|^2/4 > 0
AROUND = draft(
    LAG,
    [slope("-1/2", "1/2")],
    "late-zames-falb",
    proof(1, 2, 4, 8),
    {"lambda": ["1"], "theta": ["0"], "kernels": [kernel("1/10", "2")]},
)
ALL = {"kernels": KERNELS, "below": BELOW, "around": AROUND}


@cache
def certificate(name):
    return dict(complete_and_check(copy.deepcopy(ALL[name])).certificate)


@pytest.mark.parametrize("name", ALL)
def test_both_checkers_accept(name):
    found = certificate(name)
    FORMAT.validate(found)
    assert recheck(found).accepted, recheck(found).reason
    attracts = "0 attracts every motion with inputs to the block and initial functions of finite energy"
    assert check(found).certificate["conclusion"] == attracts


@pytest.mark.parametrize(
    "change",
    [
        ("kernels", *CLASS, slope("0", "37/10")),  # a linear gain of 3.6545 puts a root on the axis
        ("kernels", *CLASS, sector("0", "3", time_varying=False)),  # a sector says nothing of slopes
        ("kernels", *CLASS, "slope", ["-1", "3"]),
        ("kernels", *CLASS, "slope", ["0", "4"]),
        ("kernels", *CLASS, "time_varying", True),
        ("kernels", *CLASS, "linear", True),
        ("kernels", *KERNEL, "coefficient", "11/10"),
        ("kernels", *KERNEL, "coefficient", "1/10"),  # F < 0 beside the resonance
        ("kernels", *KERNEL, "coefficient", "-9/10"),
        ("kernels", *KERNEL, "side", "anticausal"),
        ("kernels", *KERNEL, "side", "both"),
        ("kernels", *KERNEL, "rate", "0"),
        ("kernels", *KERNEL, "rate", "-10"),
        ("kernels", *KERNEL, "order", 0),
        ("kernels", *KERNEL, "order", 21),
        ("kernels", *KERNEL, {"coefficient": "9/10", "delay": "1/10"}),
        ("kernels", *KERNEL, 7),
        ("kernels", "multiplier", "kernels", "none"),
        ("kernels", "multiplier", "kernels", []),  # the circle criterion
        ("kernels", "multiplier", "lambda", ["1/2"]),
        ("kernels", "multiplier", "lambda", ["-1"]),
        ("kernels", "multiplier", "theta", ["1/10"]),  # sigma echoes phi, and has no derivative
        ("kernels", "multiplier", {"lambda": ["1"], "kernels": [kernel("9/10", "10", 2)]}),
        ("kernels", "proof", proof()),
        ("kernels", "theorem", "matrix-zames-falb"),
        ("kernels", "theorem", "piecewise-popov"),
        ("kernels", "system", "A", [["0", "1"], ["0", "-1/5"]]),  # a pole at 0
        ("kernels", "system", "A", [["0", "1"], ["-4", "1/5"]]),
        ("kernels", "system", "D", [["-1/3"]]),  # 1 + k D = 0
        ("kernels", "system", "late", 0, 3, [["0", "3/8"]]),  # 1 - 3 (3/8) < 0 far out
        ("below", "system", "late", 0, 4, [["-1"]]),  # not less than 1
        ("below", "system", "late", 0, 4, [["-5/4"]]),
        ("below", *CLASS, "odd", False),
        ("below", *CLASS, slope("-1", "3", odd=True)),  # the gain -1 puts a root at 0
        ("around", *CLASS, slope("-11/10", "1/2")),  # the gain -1 puts a root at 0
        ("around", *CLASS, slope("-1/2", "23/10")),  # and 2.2618 one on the axis
        ("around", "system", "A", NO),
    ],
    ids=lambda change: "-".join(map(str, change[:-1])),
)
def test_neither_checker_accepts_what_is_tampered_with(change):
    name, *path, value = change
    assert_both_reject(edited(certificate(name), *path, value=value))


def test_neither_checker_has_kernels_without_dead_time_at_a_rate_or_of_two_channels():
    found = certificate("around")
    plain = {name: value for name, value in found["system"].items() if name != "late"} | {"kind": "multivariable"}
    assert_both_reject(found | {"system": plain})
    assert_both_reject(found | {"rate": "1/100"})
    two = late([["-1", "0"], ["0", "-1"]], *([["1", "0"], ["0", "1"]],) * 2, [["0", "0"]] * 2, ("1", [["0", "0"]] * 2))
    wider = edited(found | {"system": two}, "laws", "channels", value=[slope("0", "1/2")] * 2)
    for key in ("lambda", "theta"):
        wider = edited(wider, "multiplier", key, value=found["multiplier"][key] * 2)
    assert_both_reject(wider)


@pytest.mark.parametrize(("beside", "holds"), [(100, True), (-25, True), (-30, False), (-100, False)])
def test_far_out_what_falls_with_the_frequency_counts_with_its_sign(beside, holds):
    # omega^4 (2 + cos omega) + b omega^2 from 5 on: over omega^4 it is at least 1 + b/25, or 1 where b > 0
    one, half = Fraction(1), Fraction(1, 2)
    F = Form({(0 * one, 4): (2 * one, 0 * one), (0 * one, 2): (one * beside, 0 * one)})
    F |= {(one, 4): (half, 0 * one), (-one, 4): (half, 0 * one)}
    assert turning(Form(F), Fraction(5) if beside != -25 else Fraction(51, 10), 4) is holds


def test_kernels_that_cancel_have_their_masses_still():
    found = edited(certificate("around"), *CLASS, "odd", value=True)
    pair = [kernel("1/3", "2"), kernel("-1/3", "2")]
    alone = edited(found, "multiplier", "kernels", value=pair)  # M = 1, masses 2/3
    assert recheck(complete_and_check(alone).certificate).accepted
    assert_both_reject(edited(found, "multiplier", "kernels", value=pair * 2))  # M = 1, masses 4/3
