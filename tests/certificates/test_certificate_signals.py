"""What a disturbance gets through a loop from rest: certificates by hand, and what neither checker accepts."""

import cmath
from fractions import Fraction

import pytest
from handwritten import draft, loop, nonlinearities, operator
from tampering import assert_both_reject, edited

from lure.analysis.certificates import signals
from lure.analysis.certificates.arithmetic import ZERO, Form, Rejected
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second.opinion import recheck

RELU = nonlinearities(0, 1, slope=True, relu=True)


def signal(system, classes, inputs, slopes, **flow):
    proof = {"method": "signal", "slopes": slopes, "inputs": [[str(w)] for w in inputs], **flow}
    return draft(system, classes, "counterexample", {}, proof)


# x' = -x - max(x, 0) + w, z = x: with w = 1 for 1/4, x = (1 - e^(-2 t))/2; with w = -1 it is 0 after T = ln(2 -
# e^(-1/2))/2 = .16589828287559313, then x = -(1 - e^(-t)) for 1/4.  int z^2 = .0099434719 of int w^2 = .66589828:
# gamma = .12219828 = 1/8.18342; were x > 0 followed without the ReLU, 1/8.03926
T = "16589828287559313212713/100000000000000000000000"
LAG = loop([[-1]], [[1, 1]], [[1], [1]], [[0, 0], [0, 0]])
FLOW = {"times": ["1/4", T, "1/4"], "sides": [[1], [1], [0]], "scale": "4", "bits": 256}
PUSHED = signal(LAG, [RELU, operator("performance", "819/100")], [1, -1, -1], [["0", "1"]], **FLOW)
# the same where z = x + w/2 sees w: with w = 1 for 1/4 int z^2 = .00364020 + int x + 1/16, int x = .02663267, in all
# .09277287 of 1/4: gamma = .609173 = 1/1.641570
SEEN = signal(
    loop([[-1]], [[1, 1]], [[1], [1]], [[0, 0], [0, "1/2"]]),
    [RELU, operator("performance", "1642/1000")],
    [1],
    [["0", "1"]],
    **FLOW | {"times": ["1/4"], "sides": [[1]]},
)
# x' = -x - mu_2, phi_2 = max(phi_1, 0), phi_1 = max(x, 0): the same as the first step of PUSHED, gamma = 1/8.28719
LAYERS = signal(
    loop([[-1]], [[0, 1, 1]], [[1], [0], [1]], [[0, 0, 0], [-1, 0, 0], [0, 0, 0]]),
    [RELU, RELU, operator("performance", "829/100")],
    [1],
    [["0", "1"]] * 2,
    **FLOW | {"times": ["1/4"], "sides": [[1, 1]]},
)
# slopes that jump: 0 for x rising, 1 while it falls; x = 1 - e^(-t) up to 1/4, .2211992, then 0 after ln(1 + 2 x)/2 =
# .1831537: int z^2 = .0043362 + .0027209 = .0070571 of .4331537: 1/7.83443
JUMPS = signal(
    LAG,
    [nonlinearities(0, 1, time_varying=True), operator("performance", "784/100")],
    [1, -1],
    [[["0", "0"], ["1", "1"]]],
    **FLOW | {"times": ["1/4", "1831536536/10000000000"], "sides": [[1], [1]]},
)
# x+ = x/2 - max(x, 0) + w, z = x: w = 1, 0, 0 gives x = 0, 1, -1/2: 5/4, sqrt(5/4) = 1/.894427
MAP = loop([["1/2"]], [[1, 1]], [[1], [1]], [[0, 0], [0, 0]], "discrete")
SAMPLES = signal(MAP, [RELU, operator("performance", "895/1000")], [1, 0, 0], [["0", "1"]])
# z = x + w/2 in the same: 1/2, 1, -1/2: 3/2 = 1/.816497^2
DIRECT = edited(SAMPLES, "system", "D", value=[["0", "0"], ["0", "1/2"]])
DIRECT = edited(DIRECT, "laws", "channels", 1, value=operator("performance", "817/1000"))
# sigma_1 = w: phi_1 = max(w, 0) moves x+ = x/2 + phi_1, z = x; w = -1 is not seen: 1, 1/2 of 2, sqrt(5/8) = 1/1.264911
AT_ONCE = signal(
    loop([["1/2"]], [[-1, 0]], [[0], [1]], [[0, 1], [0, 0]], "discrete"),
    [RELU, operator("performance", "1265/1000")],
    [1, -1, 0],
    [["0", "1"]],
)
GAIN = ("laws", "channels", -1)
ACCEPTED = {
    "pushed": PUSHED,
    "seen": SEEN,
    "layers": LAYERS,
    "jumps": JUMPS,
    "samples": SAMPLES,
    "direct": DIRECT,
    "at once": AT_ONCE,
}


@pytest.mark.parametrize("name", ACCEPTED)
def test_both_checkers_accept_a_signal_by_hand(name):
    shown = complete_and_check(ACCEPTED[name])
    assert shown.certificate["conclusion"] == "the L2 gain from w to z is above gamma in a loop of the class"
    assert recheck(dict(shown.certificate)).accepted


@pytest.mark.parametrize(
    ("name", "edits"),
    [
        # a little more than comes through
        ("pushed", {GAIN: operator("performance", "818/100")}),
        ("seen", {GAIN: operator("performance", "1641/1000")}),
        ("layers", {GAIN: operator("performance", "828/100")}),
        ("jumps", {GAIN: operator("performance", "783/100")}),
        ("samples", {GAIN: operator("performance", "894/1000")}),
        ("direct", {GAIN: operator("performance", "816/1000")}),
        ("at once", {GAIN: operator("performance", "1264/1000")}),
        # sides, of which some are wrong, with what would come through then
        ("pushed", {GAIN: operator("performance", "805/100"), ("proof", "sides"): [[0]] * 3}),
        ("pushed", {("proof", "sides"): [[1], [0], [0]]}),
        ("pushed", {("proof", "sides"): [[1], [1], [1]]}),
        ("layers", {GAIN: operator("performance", "82/10"), ("proof", "sides"): [[0, 0]]}),
        ("layers", {GAIN: operator("performance", "82/10"), ("proof", "sides"): [[1, 0]]}),
        ("pushed", {("proof", "sides"): [[1], [1], [2]]}),
        ("pushed", {("proof", "sides"): [[1], [1]]}),
        ("pushed", {("proof", "sides"): [[1], [1], []]}),
        # slopes that are none of the class
        ("pushed", {("proof", "slopes"): [["0", "1/2"]], GAIN: operator("performance", "9")}),
        ("pushed", {("proof", "slopes"): [["0", "0"]], GAIN: operator("performance", "9")}),
        ("pushed", {("proof", "slopes"): [["-1", "0"]], GAIN: operator("performance", "9")}),
        ("pushed", {("proof", "slopes"): [[["0", "0"], ["0", "1"], ["0", "1"]]], GAIN: operator("performance", "9")}),
        ("pushed", {("proof", "slopes"): []}),
        ("jumps", {("laws", "channels", 0): nonlinearities(0, 1)}),
        ("jumps", {("laws", "channels", 0): nonlinearities(0, "1/2", time_varying=True)}),
        ("jumps", {("laws", "channels", 0): nonlinearities("1/2", 1, time_varying=True)}),
        ("jumps", {("laws", "channels", 0): nonlinearities(0, 1, time_varying=True, linear=True, rate="1")}),
        ("jumps", {("proof", "slopes"): [[["0", "0"]]]}),
        ("samples", {("proof", "slopes"): [["0", "0"]]}),
        ("samples", {("laws", "channels", 0): nonlinearities(0, 1, slope=True, odd=True)}),
        ("samples", {("laws", "channels", 0): nonlinearities(0, 1, linear=True)}),
        ("samples", {("laws", "channels", 0): operator("any", 1)}),
        ("samples", {("laws", "channels", 0): nonlinearities(0, 1, slope=True, memory="play")}),
        # steps
        ("pushed", {("proof", "times"): ["0", T, "1/4"]}),
        ("pushed", {("proof", "times"): ["-1/4", T, "1/4"]}),
        ("pushed", {("proof", "times"): ["1/2", T, "1/4"]}),  # too long
        ("pushed", {("proof", "times"): ["1/4", "1/4"]}),
        ("pushed", {("proof", "scale"): "-4"}),
        ("pushed", {("proof", "inputs"): [["0"], ["0"], ["0"]]}),
        ("pushed", {("proof", "inputs"): []}),
        ("samples", {("proof", "inputs"): [["0"]] * 3}),
        ("samples", {("proof", "inputs"): [["1", "0"]] * 3}),
        # another loop: more damping, phi_2 on its own output, phi_1 on that of phi_2
        ("pushed", {("system", "A"): [["-11/10"]]}),
        ("pushed", {("system", "C"): [["1"], ["9/10"]]}),
        ("layers", {("system", "D"): [["0"] * 3, ["-1", "1/9", "0"], ["0"] * 3]}),
        ("layers", {("system", "D"): [["0", "1/9", "0"], ["-1", "0", "0"], ["0"] * 3]}),
        ("samples", {("system", "D"): [["1/9", "0"], ["0", "0"]]}),
        ("samples", {("laws", "channels"): [RELU, RELU]}),
    ],
)
def test_neither_accepts_another_signal(name, edits):
    found = complete_and_check(ACCEPTED[name]).certificate
    for path, value in edits.items():
        found = edited(found, *path, value=value)
    assert_both_reject(found)


# one ReLU in both layers: with slopes 1 in the one and 0 in the other it would be two
def test_one_function_in_two_channels_has_the_same_slopes():
    both = edited(LAYERS, "laws", "channels", value=lambda one: [nonlinearities(0, 1, time_varying=True)] * 2 + one[2:])
    both = edited(both, "proof", "slopes", value=[["1", "1"], ["0", "0"]])
    both = edited(both, *GAIN, value=operator("performance", 9))
    assert recheck(complete_and_check(both).certificate).accepted
    assert_both_reject(both | {**complete_and_check(both).certificate, "laws": {**both["laws"], "repeated": [2, 1]}})


def test_the_first_checker_follows_no_step_in_which_w_is_too_large():
    with pytest.raises(Rejected, match="a step is too long"):
        complete_and_check(edited(PUSHED, "proof", "scale", value="1/4"))


def test_sums_with_dead_times_are_enclosed_and_differentiated():
    # 5 s^3 e^(-2 s) + 7 s
    form = Form({(Fraction(2), 3): (Fraction(5), ZERO), (ZERO, 1): (Fraction(7), ZERO)})
    first = {(Fraction(2), 2): 15, (Fraction(2), 3): -10, (ZERO, 0): 7}
    assert signals.slope(form) == Form({key: (Fraction(c), ZERO) for key, c in first.items()})
    s = 0.5 - 1.5j
    value = 5 * s**3 * cmath.exp(-2 * s) + 7 * s
    low, high = signals.at_point(form, Fraction(1, 2), Fraction(-3, 2))
    assert float(low) == pytest.approx(max(abs(value.real), abs(value.imag)))
    assert float(high) == pytest.approx(abs(value.real) + abs(value.imag))
