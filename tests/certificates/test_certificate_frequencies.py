"""Kernels between channels: small multipliers that prove a published plant, what neither checker accepts, a falsifier.

The plant is that of Veenman, Scherer and Koroglu (IQClab, Demo_006), which no constant gains destabilise; shown there
with one odd nonlinearity in all channels up to 5.5, and with three different ones up to 3.7.
"""

import copy
import json
from contextlib import nullcontext
from fractions import Fraction as F

import numpy as np
import pytest
from certificate_format import FORMAT
from flint import fmpq, fmpq_mat
from second_plants import assert_accepted_if, at
from tampering import assert_both_reject, changed, refused_again

from lure import NonlinearityClass, as_plant, max_slope
from lure.analysis.certificates import frequencies
from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second import frequencies as second
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.certificates.second.reading import NotShown
from lure.files.builtin import builtin_loop

SYSTEM = {
    "kind": "multivariable",
    "time": "continuous",
    "A": [["-2/5", "-1"], ["1", "0"]],
    "B": [["1/5", "1", "1/4"], ["0", "0", "0"]],
    "C": [["1", "0"], ["0", "1"], ["0", "0"]],
    "D": [["0", "0", "0"], ["0", "0", "0"], ["0", "-1", "0"]],
}
# gamma; theta; kernels: row, column, coefficient, rate, order, + causal or - anticausal; up to where they prove
KEPT = {
    "different": (
        "383/10000 0 0 / 0 839/1000 0 / 0 0 147/1000",
        "-949/100000 87/50 0",
        "3 3 9/400 1 3 -; 1 1 147/100000 2 3 +; 2 2 101/200 8 2 -; 3 3 123/1000 32 3 +; 2 2 333/1000 32 3 -; "
        "1 1 14/625 1/8 2 -; 3 3 91/100000 2 2 +; 1 1 43/25000 4 2 +",
        "41/10",
    ),
    "different, odd": (
        "83/5000 0 0 / 0 88903/100000 0 / 0 0 109/1000",
        "-9/3125 169/100 0",
        "1 1 -7/2500 64 1 +; 3 3 -167/10000 4 3 -; 1 1 -889/100000 32 3 +; 2 2 -183/10000 2 3 +; 2 2 21/100 16 3 -; "
        "1 1 91/20000 2 3 +; 2 2 473/100000 4 3 -; 2 2 519/1000 32 3 -; 3 3 919/10000 64 3 +; 2 2 137/1000 64 3 -",
        "26/5",
    ),
    "repeated": (
        "18413/1000000 0 0 / 0 4383/5000 -89/5000 / 0 0 947/10000",
        "-41/50000 71/50 0",
        "2 1 89/5000 8 3 +; 3 2 37/6250 8 3 +; 1 2 1/5000 4 3 -; 3 1 613/1000000 4 3 +; 2 2 581/1000 32 3 -; "
        "3 3 769/10000 64 3 +; 2 2 13/50 16 2 -; 1 2 137/1000000 2 3 -",
        "29/5",
    ),
    "repeated, odd": (
        "553/100000 0 0 / 0 93053/100000 -363/100000 / 0 0 3823/100000",
        "-49/10000 1 0",
        "3 1 -363/100000 16 3 -; 2 1 19/10000 8 3 +; 1 2 -137/50000 8 3 +; 1 2 101/50000 64 3 +; 2 2 203/500 64 3 -; "
        "3 3 173/5000 64 1 +; 2 2 519/1000 32 2 -; 1 2 761/1000000 8 3 -",
        "99/10",
    ),
}


def nonlinearity(top, *, odd=False, **more):
    found = {"sector": ["0", top], "slope": ["0", top], "odd": odd, "time_varying": False, "linear": False}
    return found | more


def kernels(text):
    found = []
    for i, j, c, rate, order, side in map(str.split, filter(None, text.split("; "))):
        one = {"channels": [int(i), int(j)], "coefficient": c, "rate": rate, "order": int(order)}
        found.append(one | {"side": "causal" if side == "+" else "anticausal"})
    return found


def draft(name, top=None):
    gamma, theta, listed, most = KEPT[name]
    multiplier = {"gamma": [row.split() for row in gamma.split(" / ")], "theta": theta.split()}
    return {
        "verdict": "PROVED",
        "system": SYSTEM,
        "laws": {"channels": [nonlinearity(top or most, odd="odd" in name)] * 3, "repeated": "repeated" in name},
        "theorem": "matrix-zames-falb",
        "multiplier": multiplier | {"kernels": kernels(listed)},
        "proof": {"method": "determinant"},
    }


def accepted(given):
    return json.loads(json.dumps(dict(complete_and_check(given).certificate)))


def assert_refused_by_both(name, given):
    with pytest.raises((Rejected, Malformed)):
        complete_and_check(given)
    whole = accepted(draft(name)) | given
    with pytest.raises((Rejected, Malformed)):
        check(whole)
    assert refused_again(whole)


@pytest.mark.parametrize("name", KEPT)
def test_small_multipliers_prove_more_than_was_published(name):
    shown = complete_and_check(draft(name))
    assert shown.assumed == ""
    assert shown.claim.startswith("0 attracts every motion: channel 1: all")
    assert recheck(dict(shown.certificate)).accepted
    FORMAT.validate(json.loads(json.dumps(dict(shown.certificate))))


@pytest.mark.parametrize("name", KEPT)
def test_they_prove_no_more_than_the_inequality_says(name):
    most = F(KEPT[name][3])
    assert_refused_by_both(name, draft(name, str(most * 9 / 8)))


KERNEL = ("multiplier", "kernels", 0)
TAMPERED = {
    "two nonlinearities": ("repeated", ("laws", "repeated", False)),
    "two nonlinearities, odd": ("repeated, odd", ("laws", "repeated", False)),
    "not odd": ("different, odd", ("laws", "channels", [nonlinearity("26/5")] * 3)),
    "one is not odd": ("different, odd", ("laws", "channels", 0, "odd", False)),
    "repeated, not odd": ("repeated, odd", ("laws", "channels", [nonlinearity("99/10")] * 3)),
    "one depends on time": ("different", ("laws", "channels", 1, "time_varying", True)),
    "one has no slope bounds": ("different", ("laws", "channels", 1, "slope", None)),
    "steeper": ("different", ("laws", "channels", 1, "slope", ["0", "9"])),
    "falling": ("different", ("laws", "channels", 1, "slope", ["-9", "41/10"])),
    "one jumps": ("different", ("laws", "channels", 1, "regularity", "any")),
    "no upper bound": ("different", ("laws", "channels", 1, nonlinearity("finite"))),
    "a coefficient is too large": ("different", (*KERNEL, "coefficient", "1/5")),
    "a coefficient is negative": ("different", (*KERNEL, "coefficient", "-9/400")),
    "gamma is too small": ("different", ("multiplier", "gamma", 1, ["0", "838/1000", "0"])),
    "a column is too small": ("repeated", ("multiplier", "gamma", 0, ["184/10000", "0", "0"])),
    "gamma couples": ("different", ("multiplier", "gamma", 1, ["0", "839/1000", "-1/1000"])),
    "another row": ("different", (*KERNEL, "channels", [1, 1])),
    "no such row": ("different", (*KERNEL, "channels", [4, 3])),
    "between two nonlinearities": ("different", (*KERNEL, "channels", [1, 2])),
    "another side": ("different", ("multiplier", "kernels", 2, "side", "causal")),
    "no side": ("different", (*KERNEL, "side", "both")),
    "another rate": ("different", ("multiplier", "kernels", 2, "rate", "1/8")),
    "a rate below 0": ("different", (*KERNEL, "rate", "-1")),
    "order 0": ("different", (*KERNEL, "order", 0)),
    "order 21": ("different", (*KERNEL, "order", 21)),
    "theta where sigma is no function of the state": ("different", ("multiplier", "theta", 2, "1/1000")),
    "theta": ("different", ("multiplier", "theta", 1, "-87/50")),
    "an unstable plant": ("different", ("system", "A", [["2/5", "-1"], ["1", "0"]])),
    "another gain": ("different", ("system", "B", [["1/5", "-1", "1/4"], ["0", "0", "0"]])),
    "discrete time": ("different", ("system", "time", "discrete")),
    "another method": ("different", ("proof", "method", "matrix")),
    "a key too many": ("different", ("proof", "P", [["1"]])),
    "another theorem": ("different", ("theorem", "diagonal-popov")),
}


@pytest.mark.parametrize("what", TAMPERED)
def test_what_was_tampered_with_is_accepted_by_neither(what):
    name, path = TAMPERED[what]
    assert_refused_by_both(name, changed(draft(name), *path))


# 1/(s + 1) in each of two channels, phi_i in [0, 4], lambda = 1: F = 1 + 4/(1 + x) is positive; Popov's term i omega H
# adds theta x/(1 + x), so that theta = -1 leaves (4 + 1)/(1 + x) + ..., 0 at infinity, and -9/10 is allowed
SCALAR = {
    "verdict": "PROVED",
    "system": {
        **{"kind": "multivariable", "time": "continuous", "A": [["-1", "0"], ["0", "-1"]], "D": [["0", "0"]] * 2},
        **{"B": [["1", "0"], ["0", "1"]], "C": [["1", "0"], ["0", "1"]]},
    },
    "laws": {"channels": [{**nonlinearity("4"), "slope": None}] * 2, "repeated": False},
    "theorem": "diagonal-popov",
    "multiplier": {"lambda": ["1", "1"], "theta": ["-9/10", "0"]},
    "proof": {"method": "determinant"},
}


def test_circle_and_popov_are_decided_over_frequencies_too():
    assert recheck(accepted(SCALAR)).accepted
    circle = {**SCALAR, "theorem": "diagonal-circle", "multiplier": {"lambda": ["1", "1"]}}
    assert recheck(accepted(changed(circle, "laws", "channels", 0, "time_varying", True))).accepted
    for path in (
        ("multiplier", "theta", 0, "-1"),  # F(inf) = 0
        ("multiplier", "lambda", 0, "0"),  # -9/10 x/(1 + x)
        ("multiplier", "lambda", 0, "-1"),
        ("laws", "channels", 0, "time_varying", True),
    ):
        with pytest.raises(Rejected):
            complete_and_check(changed(SCALAR, *path))
        assert refused_again(accepted(SCALAR) | changed(SCALAR, *path))


@pytest.mark.parametrize(("top", "solvable"), [("3/2", True), ("5/2", False)])
def test_with_a_cycle_in_d_the_vertices_of_the_slopes_decide(top, solvable):
    # D = (0, -1/2; -1/2, 0): det(1 + D G) = 1 - g h/4, which is positive for slopes below 2
    given = changed(SCALAR, "system", "D", [["0", "-1/2"], ["-1/2", "0"]])
    given |= {"theorem": "matrix-zames-falb", "laws": {"channels": [nonlinearity(top)] * 2, "repeated": False}}
    given["multiplier"] = {"gamma": [["1", "0"], ["0", "1"]], "theta": ["0", "0"], "kernels": []}
    if solvable:
        shown = complete_and_check(given)
        assert shown.facts["well-posed"] == "det(1 + D G) > 0 at the 4 vertices of the slopes"
        assert recheck(dict(shown.certificate)).accepted
    else:
        with pytest.raises(Rejected):
            complete_and_check(given)
        assert refused_again(accepted(changed(SCALAR, "multiplier", "theta", 0, "0")) | given)
    D = given["system"]["D"]
    plant = type(
        "Plant", (), {"A": [[F(-1)]] * 1, "B": [[F(0)] * 2], "C": [[F(0)], [F(0)]], "D": [[*map(F, r)] for r in D]}
    )
    bounds = [(F(0), F(top))] * 2
    if solvable:
        assert "vertices" in frequencies.solvable(plant, inside=True, bounds=bounds)
        with pytest.raises(Rejected, match="slopes are not within"):
            frequencies.solvable(plant, inside=False, bounds=bounds)
    else:
        with pytest.raises(Rejected, match="vanishes"):
            frequencies.solvable(plant, inside=True, bounds=bounds)


# A falsifier: for signals that are constant between 0, 1, ..., 10 and vanish beyond, int a'(M b) is a finite sum
STEPS = 10
LEVELS = np.array([0, 0.2, -0.2, 1, -1, 10, -10])


def lagged(rate, side):
    """``int int h(t - s)`` over pairs of steps, ``h = rate exp(-rate t)``: rows t, columns s; a row adds up to < 1."""
    lag = np.subtract.outer(np.arange(STEPS), np.arange(STEPS)) * side
    far = (1 - np.exp(-rate)) ** 2 / rate * np.exp(-rate * (np.maximum(lag, 1) - 1))
    return np.where(lag == 0, 1 - (1 - np.exp(-rate)) / rate, np.where(lag > 0, far, 0))


def form(multiplier):
    """``Q`` with ``int a'(M b) dt = a' Q b``, channel after channel, for kernels of order 1."""
    Q = np.kron(np.array([[float(v) for v in row] for row in multiplier.gamma]), np.eye(STEPS))
    for one in multiplier.kernels:
        rows, columns = (slice(STEPS * x, STEPS * (x + 1)) for x in (one.row, one.column))
        Q[rows, columns] -= float(one.coefficient) * lagged(float(one.rate), one.side)
    return Q


def member(rng, *, odd):
    """A random ``psi`` with slopes in [0, 1] and ``psi(0) = 0``: flat, steep or between, on four pieces a side."""
    knots = np.array([0, 0.2, 1, 3, 100])

    def side():
        slopes = rng.choice([[1, 1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 1], [0, 0, 0, 0], rng.uniform(size=4).round(1)])
        return np.concatenate([[0], np.cumsum(slopes * np.diff(knots))])

    right = side()
    left = right if odd else side()
    x, y = np.concatenate([-knots[:0:-1], knots]), np.concatenate([-left[:0:-1], right])
    return lambda sigma: np.interp(sigma, x, y)


def worst(multiplier, *, odd, repeated, rounds, rng):
    """The least ``int a'(M b)`` for ``a = psi(sigma)``, ``b = sigma - a``, of random members and signals made worse."""
    m, Q, least = len(multiplier.gamma), form(multiplier), np.inf
    for _ in range(rounds):
        psi = [member(rng, odd=odd) for _ in range(m)]
        psi = psi[:1] * m if repeated else psi

        def values(sigma, psi=psi):
            parts = np.split(sigma, m, axis=1)
            a = np.hstack([one(part) for one, part in zip(psi, parts, strict=True)])
            return np.einsum("ki,ij,kj->k", a, Q, sigma - a, optimize=True)

        start = rng.choice(LEVELS, size=(20, m)).repeat(STEPS, axis=1)
        sigma = start[values(start).argmin()]
        for _ in range(8):  # the best change of one value
            others = np.tile(sigma, (len(sigma) * len(LEVELS), 1))
            others[np.arange(len(others)), np.repeat(np.arange(len(sigma)), len(LEVELS))] = np.tile(LEVELS, len(sigma))
            found = values(others)
            sigma = others[found.argmin()]
        least = min(least, float(found.min()))
    return least


def multiplier_of(gamma, listed):
    rows = [[F(str(v)) for v in row] for row in gamma]
    given = [frequencies.Kernel(i, j, F(str(c)), F(str(a)), 1, side) for i, j, c, a, side in listed]
    return frequencies.Multiplier(rows, [F(0)] * len(rows), given)


def covers(multiplier, *, odd, repeated):
    m = len(multiplier.gamma)
    try:
        frequencies.dominant(multiplier, [odd] * m, [range(m)] if repeated else [[i] for i in range(m)], [False] * m)
    except Rejected:
        return False
    return True


WRONG = {  # right for the first class, wrong for the second: (odd, repeated)
    "negative": (([[1]], [(0, 0, -0.9, 0.7, 1)]), (True, False), (False, False)),
    "negative, anticausal": (([[1]], [(0, 0, -0.9, 0.7, -1)]), (True, True), (False, True)),
    "coupled": (([[1, -0.9], [-0.9, 1]], []), (False, True), (False, False)),
    "coupled by a kernel": (([[1, 0], [0, 1]], [(0, 1, 0.9, 2, 1)]), (False, True), (True, False)),
    "a positive entry": (([[1, 0.9], [0.9, 1]], []), (True, True), (False, True)),
    "rows are right": (([[1, -0.9], [0, 1]], [(1, 1, 0.1, 1, 1)]), (False, True), None),
    "a column is too small": (([[1, -0.9], [0, 1]], [(1, 1, 0.9, 0.2, 1)]), None, (False, True)),
    "too large": (([[1]], [(0, 0, 1.5, 1, 1)]), None, (True, True)),
}


@pytest.mark.parametrize("what", WRONG)
def test_a_multiplier_that_is_wrong_for_its_class_is_found_out_by_signals(what):
    given, right, wrong = WRONG[what]
    multiplier, rng = multiplier_of(*given), np.random.default_rng(20261122)
    for chosen, expected in ((right, True), (wrong, False)):
        if chosen is not None:
            odd, repeated = chosen
            assert covers(multiplier, odd=odd, repeated=repeated) is expected
            least = worst(multiplier, odd=odd, repeated=repeated, rounds=20, rng=rng)
            assert least > -1e-9 if expected else least < -0.01


@pytest.mark.slow
def test_what_the_checker_takes_for_a_multiplier_no_signal_refutes():
    rng, taken = np.random.default_rng(5), 0
    for _ in range(40):
        m = int(rng.integers(1, 3))
        gamma = np.diag(rng.uniform(0.5, 1.5, m)).round(2)
        gamma = gamma - (rng.uniform(-0.5, 1, (m, m)) * rng.integers(0, 2) * (1 - np.eye(m))).round(2)
        listed = [
            (*rng.integers(0, m, 2), round(rng.uniform(-0.4, 0.8), 2), rng.choice([0.3, 2]), rng.choice([1, -1]))
            for _ in range(rng.integers(0, 3))
        ]
        multiplier = multiplier_of(gamma.tolist(), [(int(i), int(j), c, a, int(s)) for i, j, c, a, s in listed])
        for odd in (False, True):
            for repeated in (False, True):
                if covers(multiplier, odd=odd, repeated=repeated):
                    taken += 1
                    assert worst(multiplier, odd=odd, repeated=repeated, rounds=2, rng=rng) > -1e-9
    assert taken > 15


# Constant gains: a = g sigma, b = (1 - g) sigma, so that int a'(M b) = g (1 - g) int sigma'(M sigma): Re M >= 0
# alone: 1 - 3 h + 3 h^* has Re = 1, 1 - .6 h - .6 h^* has Re = 1 - 1.2/(1 + omega^2), which is below 0 at omega = 0.
@pytest.mark.parametrize(
    ("listed", "right"),
    [([(0, 0, 3, 1, 1), (0, 0, -3, 1, -1)], True), ([(0, 0, 0.6, 1, 1), (0, 0, 0.6, 1, -1)], False)],
)
def test_a_constant_gain_needs_no_more_than_a_real_part(listed, right):
    given = multiplier_of([[1]], listed)
    assert frequencies.hermitian_part(given, [0]) is right
    sides = {1: "causal", -1: "anticausal"}
    kernels = [
        {"channels": [1, 1], "coefficient": str(F(str(c))), "rate": "1", "order": 1, "side": sides[side]}
        for _, _, c, _, side in listed
    ]
    value = {"gamma": [["1"]], "theta": ["0"], "kernels": kernels}
    with nullcontext() if right else pytest.raises(NotShown, match="outweigh"):
        second.read_multiplier("matrix-zames-falb", value, [True], [0], [True])
    with pytest.raises(NotShown, match="outweigh"):
        second.read_multiplier("matrix-zames-falb", value, [True], [0], [False])
    assert not covers(given, odd=True, repeated=False)
    Q = form(given)
    assert bool(np.linalg.eigvalsh(Q + Q.T).min() > -1e-9) is right


@pytest.fixture(scope="module")
def beside():
    """Fitts' plant, stable with all constant gains, not nonlinearities, beside a saturation around 8/(s+1)^3."""
    den = " + ".join(f"({c})*s^{4 - i}" for i, c in enumerate(builtin_loop("kalman-fitts").block.denominator))
    plant = as_plant([[f"s^2/({den})", "0"], ["0", "8/(s+1)^3"]])
    classes = [NonlinearityClass.constant_gain(0, 5), NonlinearityClass.slope_restricted(0, 1, odd=True)]
    return max_slope(plant, classes, criterion="zames-falb")


# Block-diagonal: the least of the parts, for 8/(s+1)^3 the gain 1, at which it oscillates.
@pytest.mark.slow
def test_a_constant_gain_beside_a_nonlinearity_is_proved_as_far_as_the_truth(beside):
    assert 0.9999 < beside.largest.low < 1 < beside.refuted_at < 1 + 1e-6
    text = json.dumps(beside.proof.certificate)
    check(text)
    assert recheck(text).accepted


@pytest.mark.slow_for("change0")
@pytest.mark.parametrize(
    "change",
    [
        {"linear": False},
        {"time_varying": True, "rate": "1/1000"},
        {"linear": False, "time_varying": True},
    ],
)
def test_a_multiplier_for_a_constant_gain_is_for_no_other_class(beside, change):
    certificate = copy.deepcopy(dict(beside.proof.certificate))
    certificate["laws"]["channels"][0] |= change
    assert_both_reject(certificate)


def test_kernels_of_a_constant_gain_with_other_signs_are_rejected_by_both(beside):
    certificate = copy.deepcopy(dict(beside.proof.certificate))
    for kernel in certificate["multiplier"]["kernels"]:
        if kernel["channels"] == [1, 1]:
            kernel["coefficient"] = str(-F(kernel["coefficient"]))
    assert_both_reject(certificate)


def lag(i, j, c, rate=1, order=1, side=1):
    return frequencies.Kernel(i, j, F(c), F(rate), order, side)


LAGS = [lag(0, 0, "1/4", 2, 2), lag(0, 0, "1/4", 2, 2, -1)]
SINGLE, PAIR = [["1"]], {"blocks": [range(2)]}
AT_1 = {"rate": F(1)}  # 2/(2 + s) weighs 2/3 and 2 at the rate 1
ALIKE, JOINT = {"operators": [(range(2), True)], **PAIR}, {"operators": [(range(2), False)], **PAIR}


# what gamma has to pay for, to the last hundredth
@pytest.mark.parametrize(
    ("gamma", "listed", "options", "holds"),
    [
        (SINGLE, [lag(0, 0, 1)], {}, True),
        (SINGLE, [lag(0, 0, "101/100")], {}, False),
        (SINGLE, [lag(0, 0, "1/2"), lag(0, 0, "51/100", 2, 3, -1)], {}, False),
        (SINGLE, [lag(0, 0, -1)], {}, False),
        (SINGLE, [lag(0, 0, -1)], {"odd": True}, True),
        (SINGLE, [lag(0, 0, "-101/100")], {"odd": True}, False),
        ([["1", "-1"], ["0", "1"]], [], PAIR, True),
        ([["1", "-1"], ["0", "1"]], [], {}, False),  # two nonlinearities
        ([["1", "1"], ["0", "1"]], [], PAIR, False),
        ([["1", "1/2"], ["0", "1"]], [], PAIR, False),
        ([["1", "1"], ["0", "1"]], [], PAIR | {"odd": True}, True),
        ([["99/100", "-1"], ["0", "1"]], [], PAIR, False),
        ([["1", "-1"], ["0", "99/100"]], [], PAIR, False),
        ([["1", "0"], ["0", "1"]], [lag(0, 1, 1)], PAIR, True),
        ([["1", "0"], ["0", "1"]], [lag(0, 1, 1)], {}, False),
        ([["1", "0"], ["0", "99/100"]], [lag(0, 1, 1)], PAIR, False),
        (SINGLE, [lag(0, 0, "1/2", 2)], AT_1, True),
        (SINGLE, [lag(0, 0, "51/100", 2)], AT_1, False),
        (SINGLE, [lag(0, 0, "1/2", 2, 1, -1)], AT_1, True),
        (SINGLE, [lag(0, 0, "51/100", 2, 1, -1)], AT_1, False),
        (SINGLE, [lag(0, 0, "1/4", 2, 2)], AT_1, True),
        (SINGLE, [lag(0, 0, "26/100", 2, 2)], AT_1, False),
        (SINGLE, [lag(0, 0, "1/100", 1)], AT_1, False),
        (SINGLE, [lag(0, 0, "1/100", 1)], {"rate": F(-1)}, False),
        (SINGLE, [lag(0, 0, "51/100", 2)], {"rate": F(-1)}, False),
        ([["1/3", "0"], ["0", "1"]], [lag(0, 1, "1/2", 2)], AT_1 | PAIR, True),
        ([["33/100", "0"], ["0", "1"]], [lag(0, 1, "1/2", 2)], AT_1 | PAIR, False),
        ([["1/3", "0"], ["0", "99/100"]], [lag(0, 1, "1/2", 2)], AT_1 | PAIR, False),
        ([["5/4"]], [lag(0, 0, "1/2", 2)], AT_1 | {"turns": [F(1, 4)]}, True),
        ([["124/100"]], [lag(0, 0, "1/2", 2)], AT_1 | {"turns": [F(1, 4)]}, False),
        ([["3/4"]], [lag(0, 0, "1/2", 2)], AT_1 | {"turns": [F(-1, 4)]}, True),
        ([["74/100"]], [lag(0, 0, "1/2", 2)], AT_1 | {"turns": [F(-1, 4)]}, False),
        # a constant gain: Re M > 0 is enough
        (SINGLE, [lag(0, 0, -5)], {"gains": True, "odd": True}, True),
        (SINGLE, [lag(0, 0, 2)], {"gains": True, "odd": True}, False),
        (SINGLE, [lag(0, 0, 9, 1, 1), lag(0, 0, -9, 1, 1, -1)], {"gains": True, "odd": True}, True),
        # operators: M = M^* > 0, of scalar ones a matrix, else a multiple of 1
        (SINGLE, LAGS, {"operators": [(range(1), False)]}, True),
        (SINGLE, LAGS[:1], {"operators": [(range(1), False)]}, False),
        (SINGLE, [lag(0, 0, "51/100", 2, 2), lag(0, 0, "51/100", 2, 2, -1)], {"operators": [(range(1), False)]}, False),
        ([["-1"]], [], {"operators": [(range(1), False)]}, False),
        ([["0"]], [], {"operators": [(range(1), False)]}, True),
        ([["1", "0"], ["0", "1"]], [], JOINT, True),
        ([["1", "0"], ["0", "2"]], [], JOINT, False),
        ([["1", "0"], ["0", "1"]], LAGS, JOINT, False),
        ([["1", "0"], ["0", "2"]], [], ALIKE, True),
        ([["1", "1/2"], ["1/2", "1"]], [], ALIKE, True),
        ([["1", "1/2"], ["1/2", "1"]], [], JOINT, False),
        ([["1", "1/2"], ["0", "1"]], [], ALIKE, False),
        ([["1", "1"], ["1", "1"]], [], ALIKE, False),
        ([["1", "0"], ["0", "1"]], [lag(0, 1, "1/4"), lag(1, 0, "1/4", 1, 1, -1)], ALIKE, True),
        ([["1", "0"], ["0", "1"]], [lag(0, 1, "1/4"), lag(1, 0, "1/4")], ALIKE, False),
        ([["1", "-1/2"], ["0", "1"]], [], PAIR | {"operators": [(range(1), False)]}, False),
        ([["1", "0"], ["-1/2", "1"]], [], PAIR | {"operators": [(range(1), True)]}, False),
    ],
)
def test_what_a_multiplier_pays_for(gamma, listed, options, holds):
    m = len(gamma)
    given = frequencies.Multiplier([[F(v) for v in row] for row in gamma], [F(0)] * m, listed)
    options = {"odd": False, "gains": False, "blocks": [range(i, i + 1) for i in range(m)]} | options
    odd, gains, blocks = [options.pop("odd")] * m, [options.pop("gains")] * m, options.pop("blocks")
    with nullcontext() if holds else pytest.raises(Rejected):
        frequencies.dominant(given, odd, blocks, gains, **options)
    written = [f"{i + 1} {j + 1} {c} {a} {order} {'+' if side > 0 else '-'}" for i, j, c, a, order, side in listed]
    if m == 2 and options.get("operators") == [(range(1), True)]:  # an operator beside a function: none is repeated
        return
    turns, rate = options.get("turns", [F(0)] * m), options.get("rate")
    value = {"gamma": gamma, "theta": [str(v) for v in turns], "kernels": kernels("; ".join(written))}
    same = [block[0] for block in blocks for _ in block]
    with nullcontext() if holds else pytest.raises(NotShown):
        again = second.read_multiplier("matrix-zames-falb", value, odd, same, gains, options.get("operators", ()), rate)
        if rate is not None:
            second.require_weights(again, [F(1)] * m, rate)


@pytest.mark.parametrize(
    ("rows", "rank", "holds"),
    [
        ([[1]], 1, True),
        ([[-1]], 1, False),
        ([[0]], 1, False),
        ([[1, 0], [0, 0]], 1, True),
        ([[1, 0], [0, 0]], 2, False),
        ([[1, 0], [0, 1]], 1, False),
        ([[1, 1], [1, 1]], 1, True),
        ([[1, 2], [2, 1]], 1, False),  # 3 and -1
        ([[2, 1], [1, 2]], 2, True),
        ([[1, 1], [0, 1]], 2, False),  # not symmetric
        ([[1]], 2, False),
        ([[2, 1, 0], [1, 2, 0], [0, 0, 0]], 2, True),
        ([[2, 1, 0], [1, 2, 0], [0, 0, -1]], 2, False),
    ],
)
def test_eigenvalues_0_are_moved_by_a_residue_with_as_many_positive_eigenvalues(rows, rank, holds):
    with nullcontext() if holds else pytest.raises(Rejected):
        frequencies.signed([[F(v) for v in row] for row in rows], rank, "M")


# M = gamma - kernels: with h = 1/(1 + i t) and its conjugate across, [[1, -c h], [-c h^*, 1]] > 0 for |c| < 1
@pytest.mark.parametrize(
    ("gamma", "kernels", "channels", "holds"),
    [
        ([[0]], [], [0], True),
        ([[0]], [(0, 0, F(-1), True)], [0], False),
        ([[1]], [(0, 0, F(9, 10), True)], [0], True),
        ([[1]], [(0, 0, F(11, 10), True)], [0], False),
        ([[1, 0], [0, 1]], [(0, 1, F(-9, 10), True), (1, 0, F(-9, 10), False)], [0, 1], True),
        ([[1, 0], [0, 1]], [(0, 1, F(-11, 10), True), (1, 0, F(-11, 10), False)], [0, 1], False),
        ([[1, 0], [0, 1]], [(0, 1, F(11, 10), True), (1, 0, F(11, 10), False)], [1], True),  # of one of them
        ([[0, 0], [0, 0]], [(0, 1, F(1), True), (1, 0, F(1), False)], [0, 1], False),
        ([[1, 1], [1, 1]], [], [0, 1], False),
        ([[2, 1], [1, 1]], [], [0, 1], True),
    ],
)
def test_where_a_multiplier_is_positive(gamma, kernels, channels, holds):
    chains = [second.Chain(j, F(1), causal, {1: [(i, c)]}) for i, j, c, causal in kernels]
    given = second.Multiplier([[F(v) for v in row] for row in gamma], [F(0)] * len(gamma), chains, frozenset())
    assert second._is_positive(given, channels) is holds


@pytest.mark.parametrize(
    "change",
    [*({"side": v} for v in ("both", None)), *({"rate": v} for v in ("0", "-1")), {"order": 21}, {"order": 0}]
    + [{"channels": v} for v in ([1], [1, 1, 1], [1, 2], [0, 1])],
)
def test_a_kernel_is_one_of_those_known(change):
    one = {"channels": [1, 1], "coefficient": "0", "rate": "1", "order": 20, "side": "causal"}
    value, given = {"gamma": [["1"]], "theta": ["0"], "kernels": [one]}, ([True], [0], [False])
    second.read_multiplier("matrix-zames-falb", value, *given)
    with pytest.raises(NotShown):
        second.read_multiplier("matrix-zames-falb", value | {"kernels": [one | change]}, *given)


@pytest.mark.parametrize(("c", "holds"), [(F(21, 100), True), (F(22, 100), False)])
def test_real_parts_of_lags_of_several_rates_add_up(c, holds):
    # 1 + 7 (1 - x/9)/(1 + x/9)^2 is at least .21634 36/(36 + x)
    assert second._has_real_part(F(1), [(F(-7), F(3), 2), (c, F(6), 1)]) is holds


# M (1 + W H) + (M - M(0)) W R/s + Theta (s C X + R), X = (s - A)^-1 B, at s = 3
@pytest.mark.parametrize("residue", [[[0, 0], [0, 0]], [[1, 2], [0, 0]], [[1, 2], [3, 4]]])
def test_what_is_realised_is_the_inequality(residue):
    A, B, C = fmpq_mat([[-1, 2], [0, -3]]), fmpq_mat([[1, 0], [1, 2]]), fmpq_mat([[1, 1], [0, 2]])
    own, D, R, s = fmpq_mat([[1, 5], [2, 0]]), fmpq_mat([[0, fmpq(1, 3)], [0, 0]]), fmpq_mat(residue), fmpq(3)
    chains = [
        second.Chain(0, F(2), True, {2: [(1, F(5))], 1: [(0, F(1)), (1, F(1, 2))]}),
        second.Chain(1, F(4), False, {3: [(0, F(7))]}),
    ]
    given = second.Multiplier([[F(3), F(1)], [F(-1), F(2)]], [F(1, 2), F(-3)], chains, frozenset())
    lag, lead, W = fmpq(2, 5), fmpq(4), fmpq_mat([[2, 0], [0, fmpq(1, 3)]])  # 2/(2 + s) and 4/(4 - s)
    M = fmpq_mat([[3 - lag, 1 - 7 * lead**3], [-1 - 5 * lag**2 - lag / 2, 2]])
    rest = fmpq_mat([[3 - 1, 1 - 7], [-1 - 5 - fmpq(1, 2), 2]])
    assert second.still(given) == rest
    X = (s * fmpq_mat([[1, 0], [0, 1]]) - A).inv() * B
    turned = fmpq_mat([[fmpq(1, 2), 0], [0, -3]]) * (s * own * X + R)
    exact = M * (fmpq_mat([[1, 0], [0, 1]]) + W * (D + C * X)) + (M - rest) * W * R / s + turned
    assert at(second._realised((A, B, C, D), own, [F(2), F(1, 3)], given, R), s) == exact


@pytest.mark.parametrize(("pole", "gain", "holds"), [(-1, "99/100", True), (-1, "101/100", False), (1, "1/100", False)])
def test_frequencies_are_of_a_loop_that_is_stable(pole, gain, holds):
    # 2 Re(1 - g/(1 + s)) > 0 for g < 1
    loop = tuple(fmpq_mat([[v]]) for v in (pole, 1, -1, 0))
    given = second.Multiplier([[F(1)]], [F(0)], [], frozenset())
    with assert_accepted_if(holds):
        second.require_frequencies(loop, loop[2], [F(gain)], given, fmpq_mat(1, 1))
