"""Blocks and graphs as the checker reads them: transfer functions, realisations, the rod's scheme, points."""

import cmath
import math
from fractions import Fraction as F

import pytest
from certificate_family import on_both

from lure.analysis.certificates import balls
from lure.analysis.certificates.arithmetic import IllPosed, Malformed, Rejected
from lure.analysis.certificates.blocks import (
    block,
    coefficients,
    critical_end,
    linear,
    masses,
    multiplier,
    paced,
    powers,
    realised,
    rod,
    scheme,
    shifted,
)
from lure.analysis.certificates.states import Family, chords, classes, deflated, inside, piecewise


def at(form, omega):
    """A form at one frequency, in floating point."""
    return sum(
        complex(u, v) * omega**n * complex(math.cos(omega * tau), -math.sin(omega * tau))
        for (tau, n), (u, v) in form.items()
    )


def system(numerator, denominator, time="continuous"):
    return {
        "kind": "transfer",
        "time": time,
        "numerator": [str(F(c)) for c in numerator],
        "denominator": [str(F(c)) for c in denominator],
    }


@pytest.mark.parametrize("time", ["continuous", "discrete"])
@pytest.mark.parametrize("lower", [F(0), F(1, 3), F(-3, 2)])
@pytest.mark.parametrize(("top", "bottom"), [([2], [3, 1, 4]), ([2, -1], [1, 5]), ([1, 2, 3], [2, 0, 5])])
def test_block_and_realisation_are_the_transfer_function(time, lower, top, bottom):
    B = block(system(top, bottom, time))
    A, b, c, d, discrete = realised(system(top, bottom, time), lower)
    assert discrete is B.discrete is (time == "discrete")
    omega = 0.4
    s = 1j * omega
    at_ = (1 + s) / (1 - s) if discrete else s
    value = sum(v * at_**i for i, v in enumerate(reversed(top))) / sum(
        v * at_**i for i, v in enumerate(reversed(bottom))
    )
    assert at(B.n, omega) / at(B.d, omega) == pytest.approx(value)
    assert B.order == len(b) == len(bottom) - 1
    assert B.direct == (F(top[0], bottom[0]) if len(top) == len(bottom) else 0)
    n = len(b)
    grid = [[at_ * (i == j) - float(A[i][j]) for j in range(n)] for i in range(n)]
    # c (z - A)^-1 b + d by Cramer's rule, n <= 2
    if n == 1:
        state = [float(b[0]) / grid[0][0]]
    else:
        det = grid[0][0] * grid[1][1] - grid[0][1] * grid[1][0]
        state = [
            (float(b[0]) * grid[1][1] - float(b[1]) * grid[0][1]) / det,
            (float(b[1]) * grid[0][0] - float(b[0]) * grid[1][0]) / det,
        ]
    shifted = value / (1 + float(lower) * value)
    assert sum(float(v) * x for v, x in zip(c, state, strict=True)) + float(d) == pytest.approx(shifted)
    whole = {
        "kind": "state-space",
        "time": time,
        **{"A": [[str(v) for v in row] for row in realised(system(top, bottom, time), F(0))[0]]},
        **{"b": [str(v) for v in realised(system(top, bottom, time), F(0))[1]]},
        **{"c": [str(v) for v in realised(system(top, bottom, time), F(0))[2]]},
        "d": str(realised(system(top, bottom, time), F(0))[3]),
    }
    A2, b2, c2, d2, _ = realised(whole, lower)  # the shift in state space agrees with that of the coefficients
    assert (d2, sum(A2[i][i] for i in range(n))) == (d, sum(A[i][i] for i in range(n)))
    assert balls.dot(c2, b2) == balls.dot(c, b)


def test_the_scheme_of_the_rod_by_hand():
    # E = 4, rho = 9, L = 3, A = 1/2, k = 5: Z = 3, s = Z N/(A rho L) = 2/3, a = (k - Z)/(k + Z) = 1/4, d = A/Z = 1/6
    rod = {"kind": "rod-scheme", "E": "4", "rho": "9", "L": "3", "A": "1/2", "k": "5", "cells": 3}
    A, b, c = scheme(rod)
    s, a = F(2, 3), F(1, 4)
    by_hand = [
        [-s, 0, 0, 0, 0, -s * a, 0],
        [s, -s, 0, 0, 0, 0, 0],
        [0, s, -s, 0, 0, 0, 0],
        [0, 0, s, -s, 0, 0, 0],
        [0, 0, 0, s, -s, 0, 0],
        [0, 0, 0, 0, s, -s, 0],
        [0, 0, 1, 0, 0, 0, 0],
    ]
    assert by_hand == A
    assert b == [0, 0, 0, F(2, 9), 0, 0, F(1, 6)]
    assert c == [0, 0, 0, 0, 0, 0, 1]
    assert len(scheme({**rod, "cells": 1000})[1]) == 2001
    assert scheme({**rod, "k": "3"})[0][0][5] == 0
    for part in ({"cells": 1001}, {"k": "-3"}, {"E": "5"}):
        with pytest.raises(Rejected, match="irrational, N exceeds 1000, or k = -Z"):
            scheme({**rod, **part})


def test_degrees_to_400_are_read():
    assert len(coefficients(system([1], [1] * 401))[1]) == 401
    with pytest.raises(Malformed, match="has degree 401, and a certificate holds one of at most 400"):
        coefficients(system([1], [1] * 402))


def test_the_zero_eigenvalue_is_split_off_by_any_state_that_it_moves():
    # 1/(s(s + 1)(s + 2)) with x = (y'' + 3 y' + 2 y, y' + 3 y, y): A x0 = 0 for x0 = (2, 3, 1), l = (1, 0, 0)
    A, b, c = [[0, 0, 0], [1, 0, -2], [0, 1, -3]], [1, 0, 0], [0, 0, 1]
    zero = {"right": ["2", "3", "1"], "left": ["1", "0", "0"]}
    for pivot, rest in enumerate(([1, 2], [0, 2], [0, 1])):
        small, beta, gamma, rho = deflated(
            [[F(v) for v in row] for row in A], [F(v) for v in b], [F(v) for v in c], {**zero, "pivot": pivot}
        )
        x = [F(v) for v in (2, 3, 1)]
        assert small == [[A[i][j] - x[i] / x[pivot] * A[pivot][j] for j in rest] for i in rest]
        assert (sum(small[i][i] for i in range(2)), rho) == (-3, F(1, 2))  # the roots -1, -2 and the residue 1/2
        assert small[0][0] * small[1][1] - small[0][1] * small[1][0] == 2
        assert beta == [b[i] - x[i] / x[pivot] * b[pivot] for i in rest]
        assert gamma == [c[i] - F(1, 2) * (i == 0) for i in rest]


def test_laws_through_points():
    nonlinearity = piecewise([["-2", "-1"], ["0", "0"], ["1", "3"], ["2", "3"]], "5", "-1")
    assert nonlinearity.slopes == [5, F(1, 2), 3, 0, -1]
    assert [nonlinearity.at(F(x)) for x in (-4, -2, -1, 0, 1, 2, 4)] == [-11, -1, F(-1, 2), 0, 3, 3, 1]
    assert nonlinearity.at(F(1, 2)) == F(3, 2)
    # next to 0 and far out, and the chords to the knots -2, 1, 2
    assert sorted(chords(nonlinearity)) == sorted([5, F(1, 2), 3, -1, F(1, 2), 3, F(3, 2)])


@pytest.mark.parametrize(
    ("points", "left", "right", "given", "inside"),
    [
        ([["0", "0"]], "1", "1", {}, True),
        ([["0", "0"]], "1", "1", {"odd": True, "linear": True}, True),
        ([["0", "0"]], "1", "0", {"odd": True}, False),
        ([["0", "0"]], "1", "0", {"linear": True}, False),
        ([["0", "0"]], "1", "0", {}, True),
        ([["0", "0"]], "1", "9/8", {}, False),
        ([["0", "0"]], "-1/8", "1", {}, False),
        ([["-1", "-1"], ["0", "0"], ["1", "1"]], "0", "0", {"odd": True}, True),
        ([["-1", "-1"], ["0", "0"], ["1", "1/2"]], "0", "0", {"odd": True}, False),
        ([["-1", "-1"], ["0", "0"], ["2", "1"]], "0", "0", {"odd": True}, False),
        ([["-2", "-1"], ["-1", "-1"], ["0", "0"], ["1", "1"], ["2", "3/2"]], "0", "0", {"odd": True}, False),
        ([["-1", "-1"], ["0", "0"], ["1", "1"], ["2", "1"]], "0", "0", {"odd": True}, True),
        ([["0", "0"], ["1", "1"], ["2", "0"]], "0", "0", {}, True),
        ([["0", "0"], ["1", "1"], ["2", "0"]], "0", "0", {"slope": ["0", "1"]}, False),
        ([["0", "0"], ["1", "1"], ["2", "0"]], "0", "0", {"slope": ["-1", "1"]}, True),
        ([["0", "0"], ["1", "0"], ["2", "2"]], "0", "0", {}, True),
        ([["0", "0"], ["1", "0"], ["2", "9/4"]], "0", "0", {}, False),
        ([["0", "0"], ["1", "0"], ["2", "2"]], "0", "0", {"slope": ["0", "1"]}, False),
    ],
)
def test_membership_in_the_class_of_chords_from_0_to_1(points, left, right, given, inside):
    whole = {"sector": ["0", "1"], "slope": None, "odd": False, "time_varying": False, "linear": False, **given}
    assert piecewise(points, left, right).member(classes(whole)) is inside


PI = F(884279719003555, 281474976710656)  # the double, 1.2e-16 below pi
NEAR = F(1, 10**9)


@pytest.mark.parametrize(
    ("start", "t", "sides", "stays"),
    [
        # y = sin s up to pi: off the lower side and back to it
        ((0, 1), PI, (0, 2), True),
        ((0, 1), PI, (0, math.inf), True),
        ((0, 1), PI, (0, 1 + NEAR), True),
        ((0, 1), PI, (0, 1), False),
        ((0, 1), PI, (0, 1 - NEAR), False),
        ((0, 1), PI, (0, F(1, 2)), False),
        ((0, 1), PI, (-math.inf, 2), True),
        ((0, 1), PI, (-math.inf, 1), False),
        ((0, 1), 2 * PI, (0, 2), False),
        ((0, 1), 2 * PI, (-1 - NEAR, 1 + NEAR), True),
        ((0, 1), 2 * PI, (-1, 2), False),
        # y = -sin s: off the upper side and back
        ((0, -1), PI, (-2, 0), True),
        ((0, -1), PI, (-math.inf, 0), True),
        ((0, -1), PI, (-1 - NEAR, 0), True),
        ((0, -1), PI, (-1, 0), False),
        ((0, -1), 2 * PI, (-2, 0), False),
        # on the wrong way at the start
        ((0, -1), PI, (0, 2), False),
        ((0, 1), PI, (-2, 0), False),
        # from a side and to the other: y = -cos s
        ((-1, 0), PI, (-1, 1), False),  # it touches both
        ((F(-3, 5), F(4, 5)), 2 * F(927295218001612, 10**15), (F(-3, 5), 2), True),
        ((F(-3, 5), F(4, 5)), 2 * F(927295218001612, 10**15), (F(-3, 5), 1), True),  # up to 0.9999999 at most
        # in the middle
        ((0, 1), F(7, 2), (F(-2, 5), 2), True),  # sin 3.5 = -0.3508
        ((0, 1), F(4), (F(-2, 5), 2), False),
        ((1, 0), PI / 2, (0, 2), True),
        ((1, 0), PI / 2, (0, 1), False),  # at rest on the side
        ((-1, 0), PI / 2, (-2, 0), True),
    ],
)
def test_a_swing_stays_between_two_sides(start, t, sides, stays):
    G = [[F(0), F(1), F(0)], [F(-1), F(0), F(0)], [F(0), F(0), F(0)]]
    X = balls.ball([[F(start[0])], [F(start[1])], [F(1)]], 128)
    assert inside(G, X, (t, F(1, 10**12)), on_both(tuple(x if abs(x) == math.inf else F(x) for x in sides))) is stays
    if stays:  # in other units of time
        fast = [[7 * v for v in row] for row in G]
        ends = tuple(x if abs(x) == math.inf else F(x) for x in sides)
        assert inside(fast, X, (t / 7, F(1, 10**13)), on_both(ends))


def test_a_swing_known_with_too_large_an_error_stays_nowhere():
    G, X = [[F(0), F(1), F(0)], [F(-1), F(0), F(0)], [F(0), F(0), F(0)]], balls.ball([[F(0)], [F(1)], [F(1)]], 128)
    for error, stays in ((2**100, True), (2**126, False)):
        assert inside(G, X._replace(error=error), (F(2), F(1, 10**12)), on_both((F(-1), F(5, 4)))) is stays
    # nor for a time that is not known
    assert not inside(G, X, (F(1), F(1)), on_both((F(-1), F(2))))
    assert not inside(G, X, (F(1, 4), F(3, 10)), on_both((F(-1), F(2))))


# 2/(2 + s) weighs 2/3 and 2 at the rate 1, 2/(2 - s) the other way round; theta pays for the first, and takes as much
@pytest.mark.parametrize(
    ("data", "discrete", "rate", "found"),
    [
        ({"theta": "1/4", "kernels": [("1/2", "causal")]}, False, None, ("1/2", "1/2")),
        ({"theta": "1/4", "kernels": [("1/2", "causal")]}, False, 1, ("1/12", "5/4")),
        ({"theta": "1/4", "kernels": [("1/2", "causal")]}, False, "1/2", ("11/40", "19/24")),
        ({"theta": "1/4", "kernels": [("-1/2", "anticausal")]}, False, 1, ("3/4", "7/12")),
        ({"theta": "-1/4", "kernels": [("1/2", "causal"), ("1/2", "anticausal")]}, False, 1, ("19/12", "13/12")),
        ({"taps": [[2, "-1/3"]]}, True, None, ("1/3", "1/3")),
        ({"taps": [[2, "-1/3"]]}, True, "1/2", ("1/12", "4/3")),
        ({"taps": [[-1, "1/3"], [2, "1/3"]]}, True, "1/2", ("3/4", "3/2")),
    ],
)
def test_masses_at_a_rate(data, discrete, rate, found):
    if not discrete:
        names = ("coefficient", "side")
        listed = [dict(zip(names, one, strict=True)) | {"rate": "2", "order": 1} for one in data["kernels"]]
        data = data | {"kernels": listed}
    assert masses(data, discrete, None if rate is None else F(rate)) == tuple(map(F, found))


def test_kernels_are_those_of_their_transfer_functions():
    kernels = [
        {"coefficient": "1/8", "rate": "1", "order": 2, "side": "causal"},
        {"coefficient": "-1/5", "rate": "3", "order": 1, "side": "anticausal"},
        {"coefficient": "1/7", "rate": "1", "order": 1, "side": "anticausal"},
        {"coefficient": "1/3", "delay": "1/2"},
        {"coefficient": "1/9", "delay": "-2"},
    ]
    H = block(system([1], [1, 1]))
    m, p, e, r, odd = multiplier("zames-falb", {"theta": "2/5", "kernels": kernels}, H, unbounded=False)
    assert odd
    assert not r
    for omega in (0.3, 1.7):
        s = 1j * omega
        lags = 1 / 8 / (1 + s) ** 2 - 3 / 5 / (3 - s) + 1 / 7 / (1 - s)
        expected = 1 - lags - cmath.exp(-s / 2) / 3 - cmath.exp(2 * s) / 9
        assert at(m, omega) / at(p, omega) == pytest.approx(expected)
        assert at(e, omega) / at(p, omega) == pytest.approx(0.4 * s)


def test_taps_are_powers_of_z():
    H = block(system([1], [2, 1], "discrete"))
    m, p, *_, odd = multiplier("zames-falb", {"taps": [[1, "1/3"], [-2, "1/4"], [3, "1/5"]]}, H, unbounded=False)
    assert not odd
    for omega in (0.3, 1.7):
        z = (1 + 1j * omega) / (1 - 1j * omega)
        assert at(m, omega) / at(p, omega) == pytest.approx(1 - 1 / z / 3 - z**2 / 4 - z**-3 / 5)


def value(coefficients, at):
    """A polynomial with descending coefficients."""
    return sum(float(F(c)) * at ** (len(coefficients) - 1 - i) for i, c in enumerate(coefficients))


# on the axis |1 + s|^2 = (1 + s)(1 - s): with z = (1 + s)/(1 - s) the steps are z - 1, 1 - 1/z and 1 + 1/z
def test_multipliers_are_those_of_the_theorems():
    H, sampled = block(system([1], [1, 1])), block(system([1], [2, 1], "discrete"))
    for omega in (0.3, -1.7):
        s, z = 1j * omega, (1 + 1j * omega) / (1 - 1j * omega)
        for name, data, B, expected in (
            ("circle", {}, H, (1, 0, 0, False)),
            ("popov", {"theta": "-2"}, H, (1 - 2 * s, 0, 0, False)),
            ("off-axis-circle", {"alpha": "2"}, H, (1 + 2j, 0, 0, False)),
            ("park", {"theta": "-2", "tau": "3"}, H, (1 - 2 * s / (1 + 3 * omega**2), 0, 0, False)),
            ("jury-lee", {"q": "3"}, sampled, (1, 3 * (z - 1), 3 * abs(z - 1) ** 2 / 2, False)),
            ("tsypkin", {"q": "3"}, sampled, (1, 3 * (1 - 1 / z), 0, False)),
            ("tsypkin-odd", {"q": "3"}, sampled, (1, 3 * (1 + 1 / z), 0, True)),
        ):
            m, p, e, r, odd = multiplier(name, data, B, unbounded=False)
            found = [at(form, omega) / at(p, omega) for form in (m, e, r)]
            assert found == pytest.approx([complex(v) for v in expected[:3]]), name
            assert odd is expected[3]
        M = [[F((3 * i + 5 * j) % 7 + min(i, j)) for j in range(6)] for i in range(6)]
        for T in (1, 2, 3):
            *three, over = powers([row[: 2 * T] for row in M[: 2 * T]])
            for form, (i, j) in zip(three, ((0, 0), (0, T), (T, T)), strict=True):
                whole = sum(float(M[i + h][j + k]) * z ** (k - h) for h in range(T) for k in range(T))
                assert at(form, omega) / at(over, omega) == pytest.approx(whole)


LATE_REST = {"kind": "delay", "terms": [["1", ["1"]]], "denominator": ["1", "0"]}


@pytest.mark.parametrize(
    ("name", "data", "given", "unbounded"),
    [
        ("popov", {"theta": "-1/9"}, LATE_REST, False),
        ("park", {"theta": "1", "tau": "-1/9"}, system([1], [1, 1]), False),
        ("tsypkin", {"q": "-1/9"}, system([1], [2, 1], "discrete"), False),
        ("jury-lee", {"q": "-1/9"}, system([1], [2, 1], "discrete"), False),
        ("jury-lee", {"q": "1/9"}, system([1], [2, 1], "discrete"), True),
        ("zames-falb", {"taps": [[1, "3/4"], [2, "-26/100"]]}, system([1], [2, 1], "discrete"), False),
        ("zames-falb", {"taps": [[1, "3/4"], [2, "-1/4"]]}, system([1], [2, 1], "discrete"), True),
        ("circle", {"theta": "1"}, system([1], [1, 1]), False),
        ("none", {}, system([1], [1, 1]), False),
    ],
)
def test_multipliers_of_no_theorem_are_refused(name, data, given, unbounded):
    with pytest.raises((Rejected, Malformed)):
        multiplier(name, data, block(given), unbounded)
    for fine in ({"q": "0"}, {"taps": [[1, "3/4"], [2, "-1/4"]]}):
        theorem = "jury-lee" if "q" in fine else "zames-falb"
        multiplier(theorem, fine, block(system([1], [2, 1], "discrete")), unbounded="q" in fine)


@pytest.mark.parametrize("rate", [F(1, 3), F(3, 2)])
def test_at_a_rate_a_plant_is_that_of_the_weighted_signals(rate):
    top, bottom = [2, -1, 3], [1, 5, 7]
    for time in ("continuous", "discrete"):
        point = 0.3 + 0.4j
        moved = float(rate) * point if time == "discrete" else point - float(rate)
        expected = value(top, moved) / value(bottom, moved)
        one = paced(system(top, bottom, time), rate)
        assert value(one["numerator"], point) / value(one["denominator"], point) == pytest.approx(expected)
        term = {"powers": [0], **{k: [str(c) for c in v] for k, v in (("numerator", top), ("denominator", bottom))}}
        (one,) = paced({"kind": "family", "time": time, "terms": [term]}, rate)["terms"]
        assert value(one["numerator"], point) / value(one["denominator"], point) == pytest.approx(expected)
        A, share = [["1", "2"], ["3", "4"]], 1 if time == "continuous" else 1 / rate
        shifted = [[share * F(v) + (i == j) * rate * (time == "continuous") for j, v in enumerate(row)]
                   for i, row in enumerate(A)]  # fmt: skip
        for kind in ("multivariable", "multivariable delay", "state-space", "channel-family", "varying-family"):
            side = "b" if kind == "state-space" else "B"
            given = {"kind": kind, "time": time, "A": A, side: ["5", "6"] if side == "b" else [["5"], ["6"]]}
            within = {"common": "2", "A": A, "B": given.get("B")}
            one = paced(given | {"terms": [within]}, rate)
            if "family" in kind:
                (one,) = one["terms"]
                both = [[share * F(v) + 2 * rate * (i == j) * (time == "continuous") for j, v in enumerate(row)]
                        for i, row in enumerate(A)]  # fmt: skip
                assert [[F(v) for v in row] for row in one["A"]] == both
            else:
                assert [[F(v) for v in row] for row in one["A"]] == shifted
            flat = one[side] if side == "b" else [v for (v,) in one[side]]
            assert [F(v) for v in flat] == [5 * share, 6 * share]
    for wrong in ({"kind": "delay"}, {"kind": "rod"}, None):
        with pytest.raises((Rejected, Malformed)):
            paced(wrong, rate)
    with pytest.raises(Rejected, match="a rate is positive"):
        paced(system([1], [2, 1], "discrete"), F(0))


def late(bottom, *feedback, top="1", delay="1"):
    """``top e^(-s delay)/(bottom + sum q e^(-s T))``."""
    given = {"kind": "delay", "terms": [[delay, [top]]], "denominator": [str(F(c)) for c in bottom]}
    return given | ({"feedback": [[T, [str(F(c)) for c in q]] for T, q in feedback]} if feedback else {})


# roots of d + l n by hand: all inside, one at 0 with a residue n(0)/d'(0) > 0, or neither
@pytest.mark.parametrize(
    ("given", "lower", "critical"),
    [
        (system([1], [1, 1]), 0, False),
        (system([1], [1, -1]), 0, None),
        (system([1], [1, -1]), 2, False),
        (system([1], [1, -1]), 1, True),
        (system([-1], [1, 1]), 1, None),  # a pole at 0 with a residue < 0
        (system([1], [1, 1, 0]), 0, True),
        (system([1, 0], [1, 1, 0]), 0, None),  # the residue is 0
        (system([1], [1, 0, 0]), 0, None),
        (system([1], [1, 0, 1]), 0, None),
        (system([1], [1, 0, 1, 0]), 0, None),
        (system([-1, 1], [1, 1]), 1, None),  # 1 + l H(inf) = 0
        (system([1], [2, 1], "discrete"), 0, False),
        (system([1], [1, -1], "discrete"), 0, True),
        (system([-1], [1, -1], "discrete"), 0, None),
        (system([1], [1, 1], "discrete"), 0, None),  # a root at z = -1
        (system([1], [2, 1], "discrete"), 1, None),  # 2 z + 2
        (system([1], [1, 2], "discrete"), 0, None),
        (system([-1], [2, -1], "discrete"), 1, None),
        (LATE_REST, 0, True),
        (LATE_REST, 1, False),  # s + l e^-s: l < pi/2
        (LATE_REST, 1.6, None),
        (late([1, 1], top="1"), 2.25, False),  # s + 1 + l e^-s: l < 2.2618
        (late([1, 1], top="1"), 2.27, None),
        (late([1, 3, 1], ("1", ["-1"])), 0, True),
        (late([1, 3, 1], ("1", ["-1"])) | {"terms": [["1", ["1", "0"]]]}, 0, None),  # the residue is 0
        (late([1, 0], top="-1"), 0, None),
        (late([1, 0], ("1", ["3/2"])), 0, False),  # s + q e^-s: q < pi/2
        (late([1, 0], ("1", ["8/5"])), 0, None),
        (late([1, 1], ("1", ["-1"])), 0, True),  # s + 1 - e^-s, s (2 - ..): the residue 1/2
        (late([1, 1], ("1", ["-1"]), top="-1"), 0, None),
        (late([1, 1], ("1", ["-11/10"])), 0, None),
        (late([1, -1], ("1/2", ["1"])), 0, True),  # s - 1 + e^(-T s), of slope 1 - T at 0, with a root > 0 for T > 1
        (late([1, -1], ("2", ["1"])), 0, None),
        (late([1, -1], ("2", ["1"]), top="-1"), 0, None),
        (late([1, -1], ("1", ["1"])), 0, None),
        (late([1, 3, 3, 1], ("1", ["1/2"])), 0, False),
        (late([-1, -3, -1], ("1", ["-1/2"])), 0, False),
        (late([1, -3, 1], ("1", ["1/2"])), 0, None),
    ],
)
def test_roots_of_the_shifted_loop(given, lower, critical):
    if critical is None:
        with pytest.raises(Rejected):
            shifted(block(given), F(lower))
        return
    d, found, _ = shifted(block(given), F(lower))
    assert found is critical
    assert at(d, 0.3) == pytest.approx(at(block(given).d, 0.3) + lower * at(block(given).n, 0.3))


# d + g n for all gains: 1/(s + 1)^3 below 8; (1 - s)/(s + 1) loses its degree at 1; 1/(s - 1) needs 1; -1/(s + 1) < 1;
# (s - 1)/(s^2 + 2 s + 5) in (-2, 5); 1/(2 z + 1) for |g + 1| < 2; 1/(4 z^2 + 1) for |g + 1| < 4
@pytest.mark.parametrize(
    ("given", "low", "high", "holds"),
    [
        (system([1], [1, 3, 3, 1]), 0, "799/100", True),
        (system([1], [1, 3, 3, 1]), 0, 8, False),
        (system([1], [1, 3, 3, 1]), 0, math.inf, False),
        (system([1], [1, 1]), 0, math.inf, True),
        (system([1], [1, 2, 1]), 0, math.inf, True),
        (system([1, 1], [1, 2, 5]), 0, math.inf, True),
        (system([1, -1], [1, 2, 5]), 0, math.inf, False),
        (system([1, -1], [1, 2, 5]), 0, 5, False),
        (system([1, -1], [1, 2, 5]), -1, "49/10", True),
        (system([1, -1], [1, 2, 5]), -2, "49/10", False),
        (system([-1, 1], [1, 1]), 0, "99/100", True),
        (system([-1, 1], [1, 1]), 0, 1, False),
        (system([-1], [1, 1]), 0, "99/100", True),
        (system([-1], [1, 1]), 0, 1, False),
        (system([1], [1, -1]), 1, 2, False),
        (system([1], [1, -1]), "101/100", 2, True),
        (system([1], [2, 1], "discrete"), 0, "99/100", True),
        (system([1], [2, 1], "discrete"), 0, 1, False),
        (system([-1], [2, 1], "discrete"), 0, "299/100", True),
        (system([-1], [2, 1], "discrete"), 0, 3, False),
        (system([1], [4, 0, 1], "discrete"), 0, "299/100", True),
        (system([1], [4, 0, 1], "discrete"), 0, 3, False),
        (system([1, 0], [1, 0, 1]), 0, 1, False),
        (system([1], [1, 1]), -math.inf, 1, False),
        (LATE_REST, 0, 1, False),
    ],
)
def test_every_constant_gain_of_an_interval(given, low, high, holds):
    B = block(given)
    ends = tuple(v if v in (math.inf, -math.inf) else F(v) for v in (low, high))
    whole = Family(ends, (-math.inf, math.inf), (False, False), False, False, True)
    if holds:
        assert linear(B, whole)
    else:
        with pytest.raises(Rejected):
            linear(B, whole)
    with pytest.raises(Rejected):
        linear(B, whole._replace(linear=False))


@pytest.mark.parametrize(
    ("given", "ends", "critical"),
    [
        (system([1], [1, 1, 0]), (0, 1), True),
        (system([1], [1, 1, 0]), (-1, 0), False),  # from above the residue has the other sign
        (system([-1], [1, 1, 0]), (-1, 0), True),
        (system([1], [1, -1]), (1, 2), True),
        (system([1], [1, -1]), (0, 1), False),
        (system([-1], [1, 1]), (0, 1), True),
        (system([-1], [1, 1]), (1, 2), False),
        (system([1], [1, 1]), (0, 1), False),
        (system([1], [1, 1, 0]), (-math.inf, math.inf), False),
        (system([1], [1, 0, 0]), (0, 1), False),
    ],
)
def test_ends_of_the_class_that_are_critical(given, ends, critical):
    ends = [v if abs(v) == math.inf else F(v) for v in ends]
    assert critical_end(block(given), *ends) is critical


@pytest.mark.parametrize(
    "given",
    [
        late([1, 1], top="1", delay="-1"),
        late([1], top="1"),
        late([0, 1, 1]),
        late([1, 1], ("0", ["1"])),
        late([1, 1], ("-1", ["1"])),
        late([1, 1], ("1", ["1/2", "1"])),  # of the degree of d
        late([1, 1], ("1", ["1"]), ("1", ["1"])),
        LATE_REST | {"terms": []},
        LATE_REST | {"terms": [["1", ["1"]]] * 2},
        LATE_REST | {"terms": [["1", ["1", "1"]]]},
        LATE_REST | {"feedback": []},
        LATE_REST | {"feedback": None},
        system([1, 1, 1], [1, 1]),
        system([1], [0, 1]),
        system([1], [1, 1], "sometimes"),
        system([1], [1, 1]) | {"kind": "family"},
    ],
)
def test_blocks_that_are_not_proper_are_refused(given):
    with pytest.raises((Rejected, Malformed)):
        block(given)


@pytest.mark.parametrize("name", ["E", "rho", "L", "A"])
def test_a_rod_has_positive_constants(name):
    given = {"kind": "rod", "E": "4", "rho": "9", "L": "3", "A": "1/2", "k": "-5"}
    assert rod(given) == (4, 9, 3, F(1, 2), -5, 0)
    for wrong in ("0", "-1"):
        with pytest.raises(Malformed):
            rod(given | {name: wrong})
    with pytest.raises(Rejected, match="begin at 0"):
        realised(given | {"kind": "rod-scheme", "cells": 2}, F(1, 9))
    ill = {"kind": "state-space", "time": "continuous", "A": [["-1"]], "b": ["1"], "c": ["1"], "d": "-2"}
    with pytest.raises(IllPosed):
        realised(ill, F(1, 2))
    with pytest.raises(IllPosed):
        realised(system([-2, 1], [1, 1]), F(1, 2))
