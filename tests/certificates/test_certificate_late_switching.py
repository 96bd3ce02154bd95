"""Gains that jump beside dead times: certificates by hand, what neither checker accepts, and what the search finds."""

import math
from fractions import Fraction

import numpy as np
import pytest
from certificate_format import FORMAT
from scipy import optimize
from tampering import assert_both_reject, edited

from lure import NonlinearityClass, Sector, as_plant
from lure.analysis import certify
from lure.analysis.certificates.balls import Ball, sign_of_determinant
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.counterexamples import late_switching
from lure.analysis.export.coq import coq_text
from lure.errors import InputError
from lure.plants.delay_matrix import one_channel_of

ONE, NO = [["1"]], [["0"]]


def varying(low, high):
    return {"sector": [low, high], "slope": None, "odd": False, "time_varying": True, "linear": False}


def draft(system, laws, proof):
    return {"verdict": "REFUTED", "system": system, "laws": laws, "theorem": "counterexample", "proof": proof}


def late(A, B, C, D, *parts):
    sides = {"A": A, "B": B, "C": C, "D": D, "late": [list(part) for part in parts]}
    return {"kind": "multivariable delay", "time": "continuous", **sides}


# x' = -k(t) x(t - 1), k in turn 1 and u for 1 s each: with x(t + 2) = -v x(t), X_0' = X_1/v and X_1' = -u X_0, the ends
# fit where sqrt(v u) (1 + v) = v (1 + u) sin(sqrt(u/v)).  For u = 9/5, v = 1.09135; for u = 1.70705, v = 1
def modulus(u):
    return optimize.brentq(
        lambda v: math.sqrt(v * u) * (1 + v) - v * (1 + u) * math.sin(math.sqrt(u / v)), 0.9, 1.2, xtol=1e-14
    )


TURNS = draft(
    late(NO, ONE, NO, NO, ("1", ONE)),
    {"channels": [varying("1", "9/5")], "repeated": False},
    {
        "method": "switched-gains",
        "gains": [["1"], ["9/5"]],
        "times": ["1", "1"],
        "multiplier": [str(-Fraction(modulus(1.8)) * (1 + Fraction(side, 10**9))) for side in (1, -1)],
        "bits": 128,
    },
)
# x'' + x'/5 + x = -k(t) x(t - 1), a period of 3 s: no constant gain below .24282 destabilises
SPRING = draft(
    {"kind": "delay", "terms": [["1", ["1"]]], "denominator": ["1", "1/5", "1"]},
    varying("0", "119/500"),
    {
        "method": "switched-gain",
        "gains": ["0", "119/500"],
        "times": ["53/100", "247/100"],
        "multiplier": ["-10003/10000", "-10001/10000"],
        "bits": 128,
    },
)
# x' = -x - k(t) x(t - 1): the rate of constant gains in [0, 1] is .605; rho = -.32779, and .32779 exp(.59486 15/8) = 1
SLOW = draft(
    late([["-1"]], ONE, NO, NO, ("1", ONE)),
    {"channels": [varying("0", "1")], "repeated": False},
    {
        "method": "switched-gains",
        "gains": [["0"], ["1"]],
        "times": ["3/8", "3/2"],
        "multiplier": ["-3279/10000", "-32778/100000"],
        "bits": 128,
    },
) | {"rate": "119/200"}

# the first beside x_2' = -x_2 - k_2 x_2(t - 2), k_2 = 1/2 at all times, which is stable
BESIDE = draft(
    late(
        [["0", "0"], ["0", "-1"]],
        [["1", "0"], ["0", "1"]],
        [["0", "0"], ["0", "0"]],
        [["0", "0"], ["0", "0"]],
        ("1", [["1", "0"], ["0", "0"]]),
        ("2", [["0", "0"], ["0", "1"]]),
    ),
    {"channels": [varying("1", "9/5"), varying("0", "1") | {"time_varying": False}], "repeated": False},
    {**TURNS["proof"], "gains": [["1", "1/2"], ["9/5", "1/2"]]},
)


def simulated(rates, waits, times, dt, periods):
    """How much larger a solution of ``x' = sum rates[k] x(t - waits[k])`` is after the last period."""
    steps = [round(t / dt) for t in times]
    back, n = round(max(waits) / dt), sum(steps)
    x = np.ones(back + 1 + n * periods)
    lags, which = [round(wait / dt) for wait in waits], np.repeat(np.arange(len(times)), steps)
    for t in range(back, len(x) - 1):
        row = rates[which[(t - back) % n]]
        now, later = (sum(a * x[t - lag + e] for a, lag in zip(row, lags, strict=True) if lag) for e in (0, 1))
        own = sum(a for a, lag in zip(row, lags, strict=True) if not lag)
        x[t + 1] = (x[t] * (1 + own * dt / 2) + (now + later) * dt / 2) / (1 - own * dt / 2)
    return np.abs(x[-n:]).max() / np.abs(x[-2 * n : -n]).max()


def test_a_multiplier_by_hand_is_that_of_a_simulation():
    assert modulus(1.8) == pytest.approx(1.09135, abs=1e-5)
    assert simulated([[-1.0], [-1.8]], [1.0], [1.0, 1.0], 0.005, 40) == pytest.approx(modulus(1.8), abs=1e-4)
    assert simulated([[-1.0, 0.0], [-1.0, -1.0]], [0.0, 1.0], [0.375, 1.5], 0.005, 20) == pytest.approx(
        0.32779, abs=1e-4
    )


@pytest.mark.parametrize("draft", [TURNS, SPRING, SLOW, BESIDE], ids=["turns", "spring", "slow", "beside"])
def test_both_checkers_accept_gains_that_jump_beside_dead_time(draft):
    shown = complete_and_check(draft)
    FORMAT.validate(dict(shown.certificate))
    assert recheck(shown.certificate).accepted
    assert "changes its sign" in shown.facts["growth"]
    with pytest.raises(InputError):
        coq_text(shown)


CLASS = ("laws", "channels", 0)
BEYOND = str(-Fraction(modulus(1.8)) * (1 + Fraction(1, 2**50)))  # by 1e-15, no root from there on


@pytest.mark.parametrize(
    ("draft", "edits"),
    [
        (TURNS, {(*CLASS, "sector"): ["1", "17/10"]}),  # the gain is outside
        (TURNS, {(*CLASS, "time_varying"): False}),
        (TURNS, {(*CLASS, "linear"): True}),
        (TURNS, {("proof", "gains"): [["1"], ["17/10"]]}),  # below 1.70705 no multiplier is outside
        (TURNS, {("proof", "gains"): [["9/5"], ["9/5"]]}),
        (TURNS, {("proof", "gains"): [["1"]]}),
        (TURNS, {("proof", "gains"): []}),
        (TURNS, {("proof", "multiplier"): ["-110/100", "-1092/1000"]}),  # both ends beyond it
        (TURNS, {("proof", "multiplier"): ["-109/100", "-101/100"]}),  # both before it
        (TURNS, {("proof", "multiplier"): ["-110/100", "-99/100"]}),  # inside the unit circle
        (TURNS, {("proof", "multiplier"): ["-108/100", "-110/100"]}),
        (TURNS, {("proof", "multiplier"): ["-110/100", "108/100"]}),
        (TURNS, {("proof", "multiplier"): ["108/100", "110/100"]}),  # the other sign
        (TURNS, {("proof", "times"): ["1", "99/100"]}),  # 199 parts
        (TURNS, {("proof", "times"): ["2", "0"]}),
        (TURNS, {("proof", "times"): ["3", "-1"]}),
        (TURNS, {("proof", "times"): ["1", "1", "1"]}),
        (TURNS, {("proof", "bits"): 1}),
        (TURNS, {("proof", "bits"): 64, ("proof", "multiplier"): ["-6/5", BEYOND]}),  # its sign is not shown
        (TURNS, {("proof", "gains"): [["1"], ["1"], ["9/5"]], ("proof", "times"): ["1", "0", "1"]}),
        (TURNS, {("system", "late", 0, 0): "1/2"}),
        (TURNS, {("system", "late", 0, 1): [["1/2"]]}),
        (TURNS, {("system", "late", 0): ["1", ONE, NO, NO, [["1/2"]]]}),  # a neutral equation
        (TURNS, {("proof", "squarings"): 1}),
        (SPRING, {("laws", "sector"): ["0", "237/1000"]}),
        (SPRING, {("laws", "time_varying"): False}),
        (SPRING, {("proof", "gains"): ["0", "237/1000"]}),  # .23777 is the least for this period
        (SPRING, {("proof", "gains"): ["119/500", "119/500"]}),
        (SPRING, {("proof", "times"): ["247/100", "53/100"]}),
        (SPRING, {("system", "terms", 0, 0): "3/2"}),
        (SPRING, {("system", "denominator", 1): "1/4"}),
        (SPRING, {("system", "feedback"): [["1", ["0", "1/100"]]]}),
        (SPRING, {("proof", "multiplier"): ["-10004/10000", "-10003/10000"]}),
        (SPRING, {("proof", "method"): "switched-gains"}),
        (SLOW, {("rate",): "5948/10000"}),  # |mu| exp(r P) < 1
        (SLOW, {("proof", "multiplier"): ["-33/100", "-3279/10000"]}),
        (SLOW, {("system", "A"): [["-11/10"]]}),
        (BESIDE, {("proof", "gains"): [["1", "0"], ["9/5", "1/2"]]}),  # the second gain moves
        (BESIDE, {("proof", "gains"): [["1", "1/2"], ["1", "1/2"]]}),
        (BESIDE, {("laws", "repeated"): True}),
    ],
)
def test_gains_that_jump_beside_dead_time_and_show_nothing_are_refused(draft, edits):
    shown = complete_and_check(draft).certificate
    for path, value in edits.items():
        shown = edited(shown, *path, value=value)
    assert_both_reject(shown)


def test_the_sign_of_a_determinant_is_that_of_every_matrix_of_the_ball():
    one = 2**64
    assert sign_of_determinant(Ball([[0, one], [one, 0]], 2, 64)) == -1
    assert sign_of_determinant(Ball([[one, one], [one, one + 1000]], 100, 64)) == 1
    assert sign_of_determinant(Ball([[one, one], [one, one + 1000]], 600, 64)) == 0  # 1 and 1 - 600, 1 + 400
    assert sign_of_determinant(Ball([[0, 0], [0, one]], 1, 64)) == 0
    assert sign_of_determinant(Ball([[-2, 24], [7, 7]], 6, 4)) == 0  # -182, and (4, 24; 1, 7) has 4


def test_both_checkers_agree_on_random_patterns_around_their_multipliers():
    rng = np.random.default_rng(7)
    for _ in range(4):
        n, u = int(rng.integers(1, 3)), Fraction(int(rng.integers(2, 9)), 2)
        A = [[str(Fraction(int(v), 8)) for v in row] for row in rng.integers(-9, 6, (n, n))]
        B, C = [[str(v)] for v in rng.integers(-2, 3, n)], [[str(v) for v in rng.integers(-2, 3, n)]]
        back = [[str(Fraction(int(v), 8)) for v in row] for row in rng.integers(-4, 5, (n, n))]
        system = late(A, B, [["0"] * n], NO, ("1/2", C, back), ("1", C, [["0"] * n] * n))
        for a, b in ((-9, -1), (-3, -2), (1, 2), (2, 9)):
            proof = {
                **TURNS["proof"],
                "gains": [["0"], [str(u)]],
                "times": ["1/3", "7/6"],
                "multiplier": [str(a), str(b)],
            }
            one = draft(system, {"channels": [varying("0", str(u))], "repeated": False}, proof) | {
                "numbers": "rationals"
            }
            try:
                shown = complete_and_check(one).certificate
            except ValueError:
                continue
            assert recheck(shown).accepted


@pytest.fixture
def quick(monkeypatch):
    """A few periods, and one grid of the dead times."""
    monkeypatch.setattr(late_switching, "_PERIODS", (((1.0, 1.02), 0.0), ((1.05, 1.06), 0.0)))
    monkeypatch.setattr(late_switching, "_GRIDS", 1)


# constant gains end at .24283, the circle criterion at .22128; the least for a period of 3 s is .23777
@pytest.mark.slow
@pytest.mark.usefixtures("quick")
def test_a_class_between_the_circle_criterion_and_constant_gains_is_refuted():
    spring = NonlinearityClass(sector=Sector(0, Fraction(239, 1000)), time_varying=True)
    found = certify("exp(-s)/(s^2 + s/5 + 1)", spring)
    assert found.verdict.name == "REFUTED"
    assert found.certificate["proof"]["method"] == "switched-gain"
    assert recheck(found.certificate).accepted
    assert 0.2377 < float(max(map(Fraction, found.certificate["proof"]["gains"]))) < 0.2379


# constant gains alone refute rates above .60502 (SLOW)
@pytest.mark.slow_for("moving0")
@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("moving", [(True,), (False,)])
def test_a_rate_is_bounded_by_gains_that_jump_if_they_may(moving):
    search = late_switching.LateSwitching(
        one_channel_of(as_plant("exp(-s)/(s+1)")), np.zeros(1), np.ones(1), moving, (range(1),)
    )
    found = next(search.slower(0.60502), None)
    if found is None:
        assert not any(moving)
        return
    rate, pattern = found
    assert 0.593 < rate < 0.595
    shown = complete_and_check(
        edited(SLOW, "proof", value={**SLOW["proof"], **_written(pattern)}) | {"rate": str(rate)}
    )
    assert recheck(shown.certificate).accepted


def _written(pattern):
    return {"gains": [[str(end)] for (end,) in pattern.ends], **pattern.numbers}
