"""Blocks and graphs as the checker reads them: transfer functions, realisations, the rod's scheme, points."""

import cmath
import math
from fractions import Fraction as F

import pytest
from certificate_family import on_both

from lure.analysis.certificates import balls
from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.blocks import block, coefficients, masses, multiplier, realised, scheme
from lure.analysis.certificates.states import chords, classes, deflated, inside, piecewise


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
