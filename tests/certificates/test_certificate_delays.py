"""Delays known by their bound: certificates by hand, what neither checker accepts, and random members."""

import copy
from fractions import Fraction as F
from functools import cache

import numpy as np
import pytest
from certificate_format import FORMAT
from tampering import assert_both_reject, edited

from lure.analysis.certificates import frequencies
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.drafts import complete_and_check, contains
from lure.analysis.certificates.second import delays
from lure.analysis.certificates.second.opinion import recheck

INTEGRATOR = {"kind": "multivariable", "time": "continuous", "A": [["0"]], "B": [["1"]], "C": [["1"]], "D": [["0"]]}


def delay(bound, kind="delay"):
    bounds = {"sector": [str(-F(bound)), str(bound)], "slope": None, "odd": False, "linear": False}
    return bounds | {"time_varying": kind != "delay", "operator": kind}


def draft(one, theorem, proof, multiplier=None):
    laws = {"channels": [one], "repeated": False}
    found = {"verdict": "PROVED", "system": INTEGRATOR, "laws": laws, "theorem": theorem, "proof": proof}
    return found | ({"verdict": "REFUTED"} if multiplier is None else {"multiplier": multiplier})


# x' = -x(t - tau(t)) = -x - w with |w| <= h |x'|, h = 9/10: V = 3/2 x^2 and lambda = 1 leave of
# -V' - 2 (.81 (x + w)^2 - w^2) the form 1.38 x^2 - .24 x w + .38 w^2, of determinant .51
VARYING = draft(
    delay("9/10", "varying delay"),
    "diagonal-circle",
    {"method": "matrix", "P": [["3"]], "exponent": 1},
    {"lambda": ["1"]},
)
# h = 1: |m(i w)| < |1 + i w|, for 2 |sin(w/2)| in place of |m| with a distance of 1/4 at w = 2
CONSTANT = draft(delay(1), "diagonal-circle", {"method": "determinant"}, {"lambda": ["1"]})
# i w + e^(-i w tau) = 0 for w = 1 and tau = pi/2 = 1.570796...
CROSSING = draft(
    delay("1571/1000"),
    "counterexample",
    {
        "method": "delayed-gains",
        "gains": ["1"],
        "channel": 1,
        "delays": ["157/100", "1571/1000"],
        "frequencies": ["99999/100000", "100001/100000"],
    },
)
# h = 1.56 < pi/2: without delay H = 1/(1 + i w); y = 1 leaves 2 Re e^(-i w h/2) H > 0 up to w = .99, where
# tan(w h/2) < 1/w, x = 1 alone 1 - 2 Re H > 0 from w = 1 on, and between the two x + 10 y
PIECES = draft(
    delay("39/25"),
    "piecewise-circle",
    {"method": "pieces", "ends": ["99/100", "1001/1000"]},
    {"lambda": ["0"], "pieces": [[["0", "1"]], [["1", "10"]], [["1", "0"]]]},
)
# in samples .8/(z - .5), tau up to 1, without delay H = .8/(z + .3): |.8/(z - .5)| = 1 at w = .9147, beyond it x = 1
# leaves 1 - 2 Re H > 0; y = 1 leaves 2 Re e^(-i w/2) H > 0 up to w = 1.2
SAMPLES = draft(
    delay("1"),
    "piecewise-circle",
    {"method": "pieces", "ends": ["11/10", "16/5"]},
    {"lambda": ["0"], "pieces": [[["0", "1"]], [["1", "0"]]]},
)
SAMPLES["system"] = SAMPLES["system"] | {"time": "discrete", "A": [["1/2"]], "B": [["4/5"]]}
# .9/(s + 1) and |tau'| <= 1/10: the gain of the delay is at most 1/sqrt(.9) < 1/.9, whatever its bound
SLOW = draft(
    delay(100, "varying delay") | {"rate": "1/10"},
    "piecewise-circle",
    {"method": "pieces", "ends": ["1"]},
    {"lambda": ["0"], "pieces": [[["1", "0"]], [["1", "0"]]]},
)
SLOW["system"] = SLOW["system"] | {"A": [["-1"]], "B": [["9/10"]]}
# z^5 (z - 1) + 3/10 has roots outside the unit circle, as 3/10 > 2 sin(pi/22) = .2846
LATE = draft(
    delay("11/2"),
    "counterexample",
    {"method": "delayed-gains", "gains": ["1"], "channel": 1, "samples": 5},
)
LATE["system"] = LATE["system"] | {"time": "discrete", "A": [["1"]], "B": [["3/10"]]}
# T = 1/(s + 1 + exp(-s tau)): with tau = 1 |T(2i)|^2 = 1/(.5839^2 + 1.0907^2) = .6534 > .64, gamma = 4/5
GAIN = draft(
    delay(1),
    "counterexample",
    {"method": "delayed-members", "gains": ["1", "0"], "delays": ["1"], "omega": "2", "input": [["1", "0"]]},
)
GAIN["system"] = GAIN["system"] | {"A": [["-1"]], "B": [["1", "1"]], "C": [["1"], ["1"]], "D": [["0", "0"]] * 2}
THROUGH = {**delay("5/4"), "time_varying": True, "operator": "performance"}
GAIN["laws"] = {"channels": [delay(1), THROUGH], "repeated": False}
ALL = {
    "gain": GAIN,
    "varying": VARYING,
    "constant": CONSTANT,
    "crossing": CROSSING,
    "pieces": PIECES,
    "samples": SAMPLES,
    "late": LATE,
    "slow": SLOW,
}


PARTS = ("verdict", "system", "laws", "theorem", "multiplier", "proof")


@cache
def certificate(name):
    return dict(complete_and_check(copy.deepcopy(ALL[name])).certificate)


@pytest.mark.parametrize("name", ALL)
def test_both_checkers_accept(name):
    found = certificate(name)
    FORMAT.validate(found)
    assert recheck(found).accepted
    assert "tau" in check(found).facts["class"]


ONE = ("laws", "channels", 0)


@pytest.mark.parametrize(
    "change",
    [
        ("gain", "proof", "omega", "1"),
        ("gain", "proof", "omega", "-2"),
        ("gain", "proof", "delays", ["11/10"]),  # outside the class
        ("gain", "proof", "delays", ["1/2"]),
        ("gain", "proof", "delays", ["1", "1"]),
        ("gain", "proof", "gains", ["0", "0"]),
        ("gain", "proof", "gains", ["1", "1"]),
        ("gain", "proof", "input", [["0", "0"]]),
        ("gain", "proof", "input", [["1", "0"], ["1", "0"]]),
        ("gain", "laws", "channels", 1, "sector", ["-6/5", "6/5"]),
        ("gain", "laws", "channels", 1, delay("5/4")),
        ("gain", "laws", "channels", 0, "operator", "any"),
        ("gain", "system", "A", [["-2"]]),
        ("gain", "system", "D", [["1", "0"], ["0", "0"]]),
        ("gain", "system", "time", "discrete"),
        ("varying", *ONE, "sector", ["-11/10", "11/10"]),
        ("varying", "proof", "P", [["-3"]]),
        ("varying", "multiplier", "lambda", ["-1"]),
        ("varying", "system", "B", [["-1"]]),
        ("varying", "system", "D", [["1/10"]]),
        ("varying", "system", "time", "discrete"),
        ("varying", *ONE, "time_varying", False),
        ("constant", *ONE, "sector", ["-3/2", "3/2"]),
        ("constant", "system", "B", [["-1"]]),
        ("constant", *ONE, "slope", ["-1", "1"]),
        ("crossing", "proof", "gains", ["0"]),
        ("crossing", "proof", "channel", 2),
        ("crossing", *ONE, "sector", ["-157/100", "157/100"]),
        ("crossing", "proof", "delays", ["1571/1000", "1572/1000"]),
        ("crossing", "proof", "frequencies", ["11/10", "12/10"]),
        ("crossing", "system", "B", [["-1"]]),
        ("pieces", *ONE, "sector", ["-63/40", "63/40"]),  # above pi/2
        ("pieces", "proof", "ends", ["99/100", "1001/2000"]),
        ("pieces", "proof", "ends", ["1001/1000"]),
        ("pieces", "proof", "ends", ["99/100", "2"]),
        ("pieces", "multiplier", "lambda", ["1"]),
        ("pieces", "multiplier", "pieces", [[["0", "1"]], [["1", "-10"]], [["1", "0"]]]),
        ("pieces", "multiplier", "pieces", [[["0", "1"]], [["1", "10"]], [["1", "1/100"]]]),
        ("pieces", "multiplier", "pieces", [[["0", "1"]], [["1", "10"]], [["-1", "0"]]]),
        ("pieces", "multiplier", "pieces", [[["0", "1"]], [["1", "10"]], [None]]),
        ("pieces", "multiplier", "pieces", [[["0", "1"]], [["1", "0"]]]),
        ("pieces", "system", "B", [["-1"]]),
        ("pieces", "system", "D", [["1/10"]]),
        ("pieces", *ONE, "operator", "any"),
        ("slow", *ONE, "rate", "1/5"),  # .9/sqrt(.8) > 1
        ("slow", *ONE, "rate", "1"),
        ("slow", *ONE, "rate", "-1/10"),
        ("slow", *ONE, "operator", "any"),
        ("slow", *ONE, delay(100, "varying delay")),
        ("slow", "multiplier", "pieces", [[["1", "0"]], [["2", "0"]]]),
        ("slow", "multiplier", "pieces", [[["1", "1"]], [["1", "1"]]]),
        ("slow", "multiplier", "pieces", [[["1", "-1/100"]], [["1", "-1/100"]]]),
        ("slow", "multiplier", "pieces", [[None], [None]]),
        ("slow", "system", "time", "discrete"),
        ("late", "proof", "samples", 4),
        ("late", "proof", "samples", 6),
        ("late", "proof", "channel", 2),
        ("late", "proof", "gains", ["0"]),
        ("late", "system", "B", [["1/4"]]),
        ("late", "system", "time", "continuous"),
        ("late", *ONE, "operator", "any"),
        ("samples", "proof", "ends", ["11/10", "3"]),
        ("samples", "multiplier", "pieces", [[["0", "1"]], [["-1", "0"]]]),
        (
            "samples",
            "multiplier",
            "pieces",
            [[["-1/100", "1"]], [["1", "0"]]],
        ),  # F > 0, but x < 0 is for continuous time
        ("samples", "system", "B", [["-1"]]),
        ("samples", *ONE, "sector", ["-7/2", "7/2"]),  # unstable from a phase of 1.8680 samples on
        ("crossing", *ONE, "operator", "any"),
    ],
)
def test_neither_accepts_what_was_changed(change):
    name, *path, value = change
    assert_both_reject(edited(certificate(name), *path, value=value))


def test_a_smaller_majorant_is_refused_by_both(monkeypatch):
    found = certificate("constant")
    monkeypatch.setattr(frequencies, "RISE", (0, 10041, 4600, 1133))
    monkeypatch.setattr(delays, "_TOP", delays._TOP - delays.X**2 * 151)
    assert_both_reject(found)
    with pytest.raises(Rejected, match="majorant"):
        frequencies.majorised()


def test_members_stay_below_the_majorant_and_varying_ones_below_their_bound():
    # |e^(-i w tau) - 1| <= |m(i w h)|, and the energy of w against that of h sigma' for delays that jump
    rng = np.random.default_rng(1)
    omega, share = np.geomspace(1e-3, 1e3, 4000), rng.random(4000)
    top, low = (np.polyval(list(p)[::-1], 1j * omega) for p in (frequencies.RISE, frequencies.FALL))
    room = np.abs(top / low) - np.abs(np.exp(-1j * omega * share) - 1)
    assert room.min() >= 0
    least = np.abs(top / low) / np.where(omega < np.pi, 2 * np.sin(omega / 2), 2)
    assert least.max() < 1.01  # and not much above
    t = np.linspace(0, 40, 40001)
    for _ in range(20):
        a, b = rng.random(2) * 4
        sigma = np.where(t < 20, np.sin(a * t) * np.sin(b * t) * np.sin(np.pi * t / 20), 0.0)
        back = np.repeat(rng.random(41), 1000)[: len(t)] * (rng.random() < 0.5) + (t % 1) * 0.5
        w = np.interp(t - np.minimum(back, 1), t, sigma, left=0.0) - sigma
        assert (w**2).sum() <= (np.gradient(sigma, t) ** 2).sum() * 1.001


def test_no_delay_of_the_class_is_outside_the_circle_and_the_chord():
    # x (|sigma|^2 - |sigma + w|^2) + 2 Re (y e^(i w h/2) conj(sigma) w) for w = (e^(-i w tau) - 1) sigma, w h <= 2 pi
    rng = np.random.default_rng(3)
    sigma = rng.normal(size=2000) + 1j * rng.normal(size=2000)
    x, y, angle = rng.normal(size=2000), rng.random(2000), rng.uniform(0, 2 * np.pi, 2000)
    for longest, fails in ((1.0, False), (1.1, True)):  # and beyond the bound it is not so
        w = (np.exp(-1j * angle * rng.uniform(0, longest, 2000)) - 1) * sigma
        form = x * (abs(sigma) ** 2 - abs(sigma + w) ** 2) + 2 * y * (np.exp(0.5j * angle) * sigma.conj() * w).real
        assert bool(form.min() < -1e-9) is fails


def test_slow_delays_have_their_gain_and_no_smaller_one():
    rng, t, d = np.random.default_rng(4), np.linspace(0, 60, 60001), 0.6
    largest = 0.0
    for _ in range(40):
        f = rng.uniform(0.5, 6)
        sigma = np.where(t < 30, np.sin(f * t) * np.sin(rng.uniform(0.1, 2) * t), 0.0)
        late = np.abs((d * (t + rng.uniform(0, 20)) + 10) % 20 - 10)  # up and down with the slope d
        w = np.interp(t - late, t, sigma, left=0.0)
        largest = max(largest, (w**2).sum() / (sigma**2).sum())
    assert 1 < largest < 1.001 / (1 - d)


def test_beside_pieces_the_loop_at_the_lower_bounds_is_stable_in_samples_too():
    # 1/(z - a): |H| <= 2 for a = 1/2, and 1 for a = 2, so that F > 0 for both in [0, 1/10]
    known = {"sector": ["0", "1/10"], "slope": None, "odd": False, "time_varying": True, "linear": False}
    proof, multiplier = {"method": "pieces", "ends": ["16/5"]}, {"lambda": ["1"], "pieces": [[None]]}
    stable = draft(known, "piecewise-circle", proof, multiplier)
    stable["system"] = stable["system"] | {"time": "discrete", "A": [["1/2"]]}
    found = complete_and_check(stable).certificate
    assert recheck(found).accepted
    assert_both_reject(edited(found, "system", "A", value=[["2"]]))


def test_a_varying_delay_of_the_same_bound_contains_a_constant_one():
    assert contains(delay(1, "varying delay"), delay(1))
    assert not contains(delay(1), delay(1, "varying delay"))
    slow = delay(1, "varying delay") | {"rate": "1/2"}
    assert contains(slow, delay(1))
    assert contains(delay(1, "varying delay"), slow)
    assert not contains(slow, delay(1, "varying delay"))
    assert not contains(slow, slow | {"rate": "3/4"})
    assert not contains({**delay(1), "operator": "any", "time_varying": True}, delay(1))
