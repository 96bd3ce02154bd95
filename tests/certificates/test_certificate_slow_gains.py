"""Gains that change slowly: what is proved and refuted, and what both checkers reject."""

import json
import math
import random
from fractions import Fraction as F
from itertools import pairwise, product

import numpy as np
import pytest
from scipy.linalg import expm
from tampering import assert_both_reject, edited

from lure import NonlinearityClass, Sector, as_plant, certify, max_sector
from lure.analysis.certificates import parametric
from lure.analysis.certificates.balls import ramp
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.inequality.shifted_loop import ChannelSearch
from lure.analysis.questions.certify import ProofOptions
from lure.analysis.wording import class_words

gain = NonlinearityClass.varying_gain
MOVING = NonlinearityClass(sector=Sector(0, 1), time_varying=True)
A, B, C = np.array([[-0.21, -1], [1, 0]]), np.array([[-0.8], [0]]), np.array([[0, 1.0]])
# IQCbeta's slow variation: |delta| <= 1 is stable for |delta'| <= .311, unstable for some above .46 (published)
PUBLISHED = as_plant(([["-.21", "-1"], ["1", "0"]], [["-.8"], ["0"]], [["0", "1"]], [["0"]]))
# x'' + x'/2 + (1 + g) x + phi(x) = 0
SPRING = as_plant(([["0", "1"], ["-1", "-1/2"]], [["0", "0"], ["1", "1"]], [["1", "0"]] * 2, [["0", "0"]] * 2))
TURNING = as_plant(([["9/10", "-2/5"], ["2/5", "9/10"]], [["1/2"], ["0"]], [["0", "1"]], [["0"]]), dt=1)


@pytest.fixture(scope="module")
def proof():
    return dict(certify(PUBLISHED, gain(-1, 1, rate=F("0.335"))).certificate)


@pytest.fixture(scope="module")
def refutation():
    return dict(certify(PUBLISHED, gain(-1, 1, rate=F("0.42"))).certificate)


@pytest.fixture(scope="module")
def mixed():
    classes = [gain(0, 10, rate=F(1, 10)), MOVING]
    return dict(certify(SPRING, classes, ways=ProofOptions(criterion="parameter-dependent")).certificate)


@pytest.fixture(scope="module")
def sampled():
    return dict(certify(TURNING, gain(0, F(11, 100), rate=F(1, 50))).certificate)


def number(text):
    return float(F(text))


@pytest.mark.slow
def test_the_published_gain_is_proved_beyond_the_published_rate_and_refuted_below_it(proof, refutation):
    assert (proof["verdict"], proof["theorem"]) == ("PROVED", "parameter-dependent")
    assert (refutation["verdict"], refutation["proof"]["method"]) == ("REFUTED", "ramped-gains")
    for one in (proof, refutation):
        check(json.dumps(one))
        assert recheck(one).accepted


def test_the_refuting_gain_is_slow_and_its_period_has_an_eigenvalue_outside(refutation):
    gains = [number(row[0]) for row in refutation["proof"]["gains"]]
    state = np.eye(2)
    for (a, b), time in zip(pairwise([*gains, gains[0]]), map(number, refutation["proof"]["times"]), strict=True):
        assert abs(b - a) <= 0.42 * time * (1 + 1e-12)
        for k in range(400):  # exponentials in the middle of short pieces
            state = expm((A - B @ C * (a + (b - a) * (k + 0.5) / 400)) * time / 400) @ state
    assert np.abs(np.linalg.eigvals(state)).max() > 1


# Constant gains: x'' + .21 x' + (1 - .8 g) x is stable for g < 5/4.  Gains that jump: the circle criterion proves
# .469874, and at .69 some grow.
@pytest.mark.slow_for("1000-0.47-PROVED", "1000-0.7-REFUTED")
@pytest.mark.parametrize(
    ("rate", "end", "verdict"),
    [
        (F(1, 1000), "1.249", "PROVED"),
        (1000, "0.47", "PROVED"),
        (1000, "0.7", "REFUTED"),
        (F(1, 1000), "1.251", "REFUTED"),
    ],
)
def test_slow_gains_approach_constant_ones_and_fast_gains_those_that_jump(rate, end, verdict):
    assert certify(PUBLISHED, gain(0, F(end), rate=rate)).verdict.name == verdict


# x' = -(1 + g) x, V = P(g) x^2, P from 3 to 1 or from 1 to 3: -V' = 2 (1 + g) P - g' P' is 4 - 2 |g'| or 2 - 2 |g'| at
# its least; a gain that only rises, or only falls, would make it larger
@pytest.mark.parametrize(("ends", "rate", "shown"), [((3, 1), 1, True), ((3, 1), 10, False), ((1, 3), 10, False)])
def test_a_slow_gain_may_rise_and_fall(proof, ends, rate, shown):
    plant = {"A": [["-1"]], "B": [["1"]], "C": [["1"]], "D": [["0"]]}
    one = proof["laws"]["channels"][0] | {"sector": ["0", "1"], "slope": ["0", "1"], "rate": str(rate)}
    scalar = {
        **{**proof, "system": {**proof["system"], **plant}, "laws": {**proof["laws"], "channels": [one]}},
        "multiplier": {"lambda": [[]], "theta": []},
        "proof": {**proof["proof"], "degree": 1, "pieces": [1], "P": [[[str(v)]] for v in ends], "exponent": 0},
    }
    if shown:
        assert recheck(check(json.dumps(scalar), draft=True).certificate).accepted
    else:
        assert_both_reject(scalar)


def test_a_sentence_about_slow_gains_says_their_rate(proof):
    words = "time-varying odd linear phi with slope in [-1, 1], its gain at a rate of at most 0.335"
    assert class_words(proof["laws"]) == words
    assert "rates up to 67/200" in proof["hypotheses"]["class"]


@pytest.mark.thorough
def test_the_largest_factor_of_slow_gains_lies_between_a_proof_and_a_refutation():
    found = max_sector(PUBLISHED, gain(0, 1, rate=1), criterion="circle")
    assert 0.46987 < found.largest.low < found.refuted_at < 1
    assert "its gain at a rate of at most 1:" in str(found)


# Frozen at g the circle criterion proves k < 1/4 + sqrt(1 + g), so that a constant g >= 0 leaves k < 5/4; if g jumps as
# phi does, the two share k: 11 k < 5/4.
@pytest.mark.slow
def test_a_slow_gain_beside_a_nonlinearity_is_told_apart_from_one_that_jumps(mixed):
    assert mixed["verdict"] == "PROVED"
    check(json.dumps(mixed))
    assert recheck(mixed).accepted
    jumping = NonlinearityClass(sector=Sector(0, 10), time_varying=True)
    assert max_sector(SPRING, [jumping, MOVING]).largest.low < 1.25 / 11


def value(certificate, g, rate):
    """``P`` at a gain, and its derivative in time."""
    proof, (low, high) = certificate["proof"], map(number, certificate["laws"]["channels"][0]["sector"])
    d, (pieces,) = proof["degree"], proof["pieces"]
    coefficients = np.array(
        [
            [[int(half[max(i, j)][min(i, j)]) * 2.0 ** -proof["exponent"] for j in range(2)] for i in range(2)]
            for half in proof["P"]
        ]
    )
    at = (g - low) / (high - low) * pieces
    k = min(int(at), pieces - 1)
    own, s = coefficients[d * k : d * k + d + 1], at - k

    def bernstein(n):
        return [math.comb(n, i) * s**i * (1 - s) ** (n - i) for i in range(n + 1)]

    turn = d * pieces / (high - low) * rate
    return np.tensordot(bernstein(d), own, 1), turn * np.tensordot(bernstein(d - 1), np.diff(own, axis=0), 1), k


# The falsifier: members of the class, and the worst of what they may do at an instant.
@pytest.mark.slow_for("3-False")
@pytest.mark.parametrize(("share", "falls"), [(1, True), (3, False)])
def test_v_falls_for_random_gains_rates_and_nonlinearities_of_the_class_and_not_for_larger_ones(mixed, share, falls):
    random, found = np.random.default_rng(11), []
    for g, speed, d in zip(
        random.uniform(0, 10, 3000), random.choice([-0.1, 0.1], 3000), random.random(3000), strict=True
    ):
        P, turn, _ = value(mixed, g, share * speed)
        closed = np.array([[0, 1], [-1 - g - share * round(d), -0.5]])
        found.append(np.linalg.eigvalsh(P @ closed + closed.T @ P + turn).max())
    assert bool(max(found) < 0) is falls


@pytest.mark.slow
def test_in_discrete_time_v_falls_for_random_steps_of_the_gain(sampled):
    assert sampled["verdict"] == "PROVED"
    assert recheck(sampled).accepted
    random = np.random.default_rng(12)
    for g, step in zip(random.uniform(0, 0.11, 500), random.uniform(-0.02, 0.02, 500), strict=True):
        after = min(max(g + step, 0), 0.11)
        G = np.array([[0.9, -0.4], [0.4, 0.9]]) - g * np.array([[0, 0.5], [0, 0]])
        fall = value(sampled, g, 0)[0] - G.T @ value(sampled, after, 0)[0] @ G
        assert np.linalg.eigvalsh(fall).min() > 0


CHANNEL = ("laws", "channels", 0)


@pytest.mark.parametrize(
    ("path", "change"),
    [
        ((*CHANNEL, "rate"), "1"),
        ((*CHANNEL, "rate"), "0"),
        ((*CHANNEL, "rate"), "-1/3"),
        (CHANNEL, lambda laws: {**laws, "sector": ["-1", "9/8"], "slope": ["-1", "9/8"]}),
        ((*CHANNEL, "linear"), False),
        ((*CHANNEL, "time_varying"), False),
        (CHANNEL, lambda laws: {key: laws[key] for key in laws if key != "rate"}),
        (("proof", "P", 3, 0, 0), lambda v: str(-int(v))),
        (("proof", "P"), lambda v: v[:-1]),
        (("proof", "P"), lambda v: v[::-1]),
        (("proof", "degree"), lambda d: d + 1),
        (("proof", "pieces"), lambda v: [v[0] + 1]),
        (("multiplier", "lambda"), lambda v: v[:-1]),
        (("multiplier", "theta"), ["1"]),
        (("theorem",), "constant-gains"),
        (("system", "D"), [["1/100"]]),
        (("system", "A", 0, 0), "21/100"),
        (("system", "time"), "discrete"),
    ],
)
def test_a_proof_that_was_tampered_with_is_rejected_by_both(proof, path, change):
    assert_both_reject(edited(proof, *path, value=change))


@pytest.mark.parametrize(
    ("path", "change"),
    [
        (("multiplier", "lambda", 0, 0), lambda v: f"-{v}"),
        (("multiplier", "lambda", 0, 0), "0"),
        (("multiplier", "theta"), ["1/1000"]),  # phi depends on time
        (("laws", "channels", 1, "sector"), ["0", "4"]),
        (("laws", "repeated"), True),
    ],
)
def test_a_proof_about_gains_and_nonlinearities_that_was_tampered_with_is_rejected_by_both(mixed, path, change):
    assert_both_reject(edited(mixed, *path, value=change))


@pytest.mark.parametrize(
    ("path", "change"),
    [
        ((*CHANNEL, "rate"), "1/3"),
        ((*CHANNEL, "sector"), ["-1", "9/10"]),
        (("proof", "method"), "switched-gains"),  # it does not jump
        (("proof", "times", 0), lambda t: str(F(t) / 2)),
        (("proof", "times", 0), lambda t: f"-{t}"),
        (("proof", "gains"), lambda rows: [rows[0]] * len(rows)),
        (("system", "D"), [["1/10"]]),
    ],
)
def test_a_refutation_that_was_tampered_with_is_rejected_by_both(refutation, path, change):
    assert_both_reject(edited(refutation, *path, value=change))


def test_a_step_in_discrete_time_is_no_larger_than_the_rate(sampled):
    assert_both_reject(edited(sampled, *CHANNEL, "rate", value="1/2"))


# Y' = (0, 1; -t, 0) Y: its first column solves Airy's y'' = -t y; y = 1 - t^3/6 + t^6/180 - ..
def test_the_solution_of_a_ramp_is_enclosed():
    found = ramp([[F(0), F(1)], [F(0), F(0)]], [[F(0), F(1)], [F(-2), F(0)]], F(2), 128)
    term, total, k = 1.0, 0.0, 0
    while abs(term) > 1e-18:
        total, k = total + term, k + 3
        term *= -8 / (k * (k - 1))
    assert abs(found.rows[0][0] / 2**128 - total) < 1e-14
    assert 0 < found.error < 2**40
    rng = random.Random(2)
    for n in (1, 1, 1, 1, 6):  # with few bits roundings count
        first, last = ([[F(rng.randint(-9, 9), 11 * n) for _ in range(n)] for _ in range(n)] for _ in range(2))
        rough, fine = (ramp(first, last, F(9, 4), bits) for bits in (14, 200))
        both = zip(rough.rows, fine.rows, strict=True)
        apart = [sum(abs(F(x) - F(y, 2**186)) for x, y in zip(*rows, strict=True)) for rows in both]
        assert max(apart) <= rough.error


class Margins(ChannelSearch):
    """A search of which the margin is known: convex, as that of a programme, and none of what does not serve."""

    tried = 0

    def margin(self, widths):
        self.tried += 1
        return max(np.exp(-widths[0]) - np.exp(-3.7), -1e-9)

    def serves(self, widths):
        return self.margin(widths) > 0

    def proposals(self, widths, lower):
        return iter(())


@pytest.mark.parametrize("most", [3.75, math.inf])
def test_a_margin_is_followed_to_where_it_vanishes(most):
    search = Margins(*[np.zeros((1, 1))] * 4, np.zeros(1))
    search.precision = 1e-4
    found = search.largest(lambda factor: np.array([factor]), 1.0, most)
    assert 3.7 * (1 - 1e-4) < found < 3.7
    assert search.tried <= 12  # 15 by halving


# -- what the first checker makes of it, against the formulas at random points
def fractions(rows):
    return [[F(v) for v in row] for row in rows]


THREE = parametric.Plant(
    fractions([["-1", "1/2"], ["1/3", "-2"]]),
    fractions([["1", "2", "-1"], ["1/2", "-1", "3"]]),
    fractions([["1", "-1"], ["2", "1"], ["1", "3"]]),
    fractions([["0", "0", "1/4"], ["0", "0", "1/3"], ["0", "0", "0"]]),  # sigma_1 and sigma_2 see the gain
    discrete=False,
)


def test_the_forms_beside_a_gain_are_those_of_the_formulas():
    # channels 1 and 2 are functions, of which only the first has a term of Popov's; channel 3 has the gain g
    A, B, C, D = (np.array(side, dtype=float) for side in THREE[:4])
    rng, g = np.random.default_rng(2), F(5, 3)
    listed = [(0, F(-1, 2), F(2), F(3, 4), F(2, 5)), (1, F(1, 3), F(4), F(1, 5), F(0))]
    R, falls = parametric.forms(THREE, [range(2, 3)], [g], listed)
    R, falls = np.array(R, dtype=float), np.array(falls, dtype=float)
    for z in rng.normal(size=(6, 4)):
        x, phi = z[:2], z[2:]
        mu = np.array([-phi[0], -phi[1], 0])
        mu[2] = -float(g) * (C[2] @ x + D[2] @ mu)
        sigma, rate = C @ x + D @ mu, A @ x + B @ mu
        assert R @ z == pytest.approx(rate)
        held = sum(
            float(2 * w) * (p - float(low) * s) * (float(high) * s - p) + float(2 * t) * p * (C[i] @ rate)
            for p, s, (i, low, high, w, t) in zip(phi, sigma[:2], listed, strict=True)
        )
        assert z @ falls @ z == pytest.approx(-held)


def spline(d, pieces, bounds, rates, seed=3):
    rng = np.random.default_rng(seed)
    places = [*product(*(range(d * count + 1) for count in pieces))]
    at = {k: [[F(int(rng.integers(-9, 10)))]] for k in places}
    return parametric.Spline(d, pieces, [(F(a), F(b)) for a, b in bounds], [F(r) for r in rates], at)


def polynomial(coefficients, degrees, at):
    """Of Bernstein coefficients in order, at a point."""
    weights = [
        [math.comb(d, i) * s**i * (1 - s) ** (d - i) for i in range(d + 1)] for d, s in zip(degrees, at, strict=True)
    ]
    return sum(math.prod(w) * float(c[0][0]) for w, c in zip(product(*weights), coefficients, strict=True))


def of(P, box, at):
    """``P`` at a point of a box."""
    found = 0.0
    for index in product(range(P.d + 1), repeat=len(box)):
        w = math.prod(math.comb(P.d, i) * s**i * (1 - s) ** (P.d - i) for i, s in zip(index, at, strict=True))
        found += w * float(P.at[tuple(P.d * k + i for k, i in zip(box, index, strict=True))][0][0])
    return found


SCALAR = parametric.Plant(
    fractions([["-1/2"]]), fractions([["1", "2"]]), fractions([["1"], ["-1/3"]]), [[F(0)] * 2] * 2, False
)


def test_v_falls_by_what_the_formulas_say_for_gains_that_move():
    # V = P(g_1, g_2) x^2: -V' = -2 P a - sum P_j g_j', a = -1/2 - g_1 + 2 g_2/3, g_j' = +-r_j
    P = spline(2, [2, 3], [(0, 1), (-1, 2)], ["1/2", "3/5"])
    box, at, size = (1, 2), (0.3, 0.8), (3 + 1) ** 2
    found = [*parametric.flowing(SCALAR, [range(1), range(1, 2)], P, box, [])]
    g = [
        float(low + (high - low) * (F(k) + F(s)) / n)
        for (low, high), k, s, n in zip(P.bounds, box, at, P.pieces, strict=True)
    ]
    a, h = -0.5 - g[0] + 2 * g[1] / 3, 1e-6
    slopes = [
        (of(P, box, tuple(s + h * (i == j) for i, s in enumerate(at))) - of(P, box, at)) / h * n / float(high - low)
        for j, (n, (low, high)) in enumerate(zip(P.pieces, P.bounds, strict=True))
    ]
    for k, (s1, s2) in enumerate(product((1, -1), repeat=2)):
        expected = -2 * of(P, box, at) * a - s1 * 0.5 * slopes[0] - s2 * 0.6 * slopes[1]
        assert polynomial(found[size * k : size * (k + 1)], (3, 3), at) == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize(("rate", "near"), [("1/2", (0, 1, 2)), ("1", (0, 1, 2, 3)), ("9/10", (0, 1, 2))])
def test_v_falls_by_what_the_formulas_say_for_steps_to_all_pieces_within_reach(rate, near):
    # V = P(g_1, g_2) x^2, x+ = a x, g_1 within [1, 2] before; g_2 is constant
    P = spline(1, [4, 2], [(0, 4), (-1, 2)], [rate, "0"])
    plant, box, at, after = SCALAR._replace(discrete=True), (1, 1), (0.3, 0.8), 0.6
    found = [*parametric.stepped(plant, [range(1), range(1, 2)], P, box, [])]
    g = [1 + 0.3, -1 + 1.5 + 0.8 * 1.5]
    a, degrees = -0.5 - g[0] + 2 * g[1] / 3, (2, 3, 1)
    size = math.prod(d + 1 for d in degrees)
    assert len(found) == size * len(near)
    for k, piece in enumerate(near):
        expected = of(P, box, at) - a * a * of(P, (piece, 1), (after, 0.8))
        assert polynomial(found[size * k : size * (k + 1)], degrees, (*at, after)) == pytest.approx(expected)
