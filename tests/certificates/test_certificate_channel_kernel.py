"""What the checker computes of channels, against answers by hand: orders, eigenvalues, weights, forms of gains."""

from contextlib import nullcontext
from fractions import Fraction as F

import numpy as np
import pytest
from handwritten import nonlinearities

from lure.analysis.certificates import channels, frequencies, pieces, several
from lure.analysis.certificates.arithmetic import Form, Malformed, Rejected


def matrix(rows):
    return [[F(v) for v in row] for row in rows]


@pytest.mark.parametrize(
    ("half", "holds"),
    [
        ([[1], [1, 1]], True),
        ([[1], [2, 1]], False),
        ([[0], [1, 1]], False),
        ([[0], [0, 1]], True),
        ([[0], [0, -1]], False),
        ([[-1]], False),
        ([[1], [1, 1], [0, 0, -1]], False),
        ([[1], [1, 1], [0, 1, 1]], False),
        ([[4], [2, 1], [2, 1, 1]], True),
    ],
)
def test_what_is_semidefinite(half, holds):
    assert channels.semidefinite(half) is holds


@pytest.mark.parametrize(
    ("A", "discrete", "zeros", "holds"),
    [
        ([[-1]], False, 0, True),
        ([[0]], False, 0, False),
        ([[0]], False, 1, True),
        ([[-1]], False, 1, False),
        ([[0, 1], [0, -1]], False, 1, True),
        ([[0, 1], [0, 1]], False, 1, False),
        ([[0, 1], [0, 0]], False, 1, False),
        ([[0, 1], [0, 0]], False, 2, True),
        ([[0, 1], [-1, 0]], False, 0, False),
        ([["1/2"]], True, 0, True),
        ([[-1]], True, 0, False),
        ([[1]], True, 1, True),
        ([[1, 1], [0, "1/2"]], True, 1, True),
        ([[1, 1], [0, "-3/2"]], True, 1, False),
        ([[1, 1], [0, 1]], True, 1, False),
        ([[1, 1], [0, -1]], True, 1, False),
    ],
)
def test_which_eigenvalues_are_inside(A, discrete, zeros, holds):
    assert channels.within(matrix(A), discrete, zeros) is holds


@pytest.mark.parametrize(
    ("rows", "rank"), [([[0]], 0), ([[1, 2], [2, 4]], 1), ([[0, 1], [1, 0]], 2), ([[0, 1, 1], [0, 1, 1], [1, 0, 0]], 2)]
)
def test_the_rank_of_a_matrix(rows, rank):
    assert channels.rank(matrix(rows)) == rank


PLAIN, ANY = nonlinearities(-1, 1), nonlinearities(-1, 1, operator="any", time_varying=True)
EACH = nonlinearities(-1, 1, operator="scalar linear time-invariant")
OUT = nonlinearities(-1, 1, operator="performance", time_varying=True)


@pytest.mark.parametrize(
    ("D", "classes", "repeated", "holds"),
    [
        ([[0]], [PLAIN], False, True),
        ([[1]], [PLAIN], False, False),
        ([[0, 1], [0, 0]], [PLAIN] * 2, False, True),
        ([[0, 0], [1, 0]], [PLAIN] * 2, False, True),
        ([[0, 1], [1, 0]], [PLAIN] * 2, False, False),
        ([[0, 1], [0, 0]], [PLAIN] * 2, True, True),
        ([[0, 1], [0, 0]], [ANY] * 2, True, False),
        ([[0, 1], [0, 0]], [ANY] * 2, False, True),
        ([[0, 1], [0, 0]], [EACH] * 2, True, True),
        ([[0, 1], [1, 0]], [EACH] * 2, True, False),
        ([[0, 1], [1, 1]], [PLAIN, OUT], False, True),
        ([[1, 0], [0, 0]], [PLAIN, OUT], False, False),
    ],
)
def test_channels_are_taken_one_after_the_other(D, classes, repeated, holds):
    asked = channels.channels({"channels": classes, "repeated": [len(D)] if repeated else False}, len(D))
    assert channels.ordered(matrix(D), asked) is holds


@pytest.mark.parametrize(
    ("weights", "classes", "sizes", "holds"),
    [
        ([1, 2], [PLAIN] * 2, [2], True),
        ([1, 2], [ANY] * 2, [2], False),
        ([2, 2], [ANY] * 2, [2], True),
        ([1, 2], [ANY] * 2, [1, 1], True),
        ([1, 2], [EACH] * 2, [2], True),
        ([1, 0], [PLAIN, OUT], [1, 1], False),
        ([0, 1], [PLAIN, OUT], [1, 1], True),
        ([1, 2, 3], [PLAIN, OUT, OUT], [1, 2], False),
    ],
)
def test_an_operator_has_one_weight(weights, classes, sizes, holds):
    asked = channels.channels({"channels": classes, "repeated": sizes}, len(classes))
    with nullcontext() if holds else pytest.raises(Rejected):
        channels.uniform([F(v) for v in weights], asked)


# sigma' Pi sigma over the gains of [0, 1]: concave in each, positive at the vertices; or with N >= 0 for each sign
@pytest.mark.parametrize(
    ("Pi", "parts", "resting", "holds"),
    [
        ([[1], [0, "-1/2"]], [], False, True),
        ([[1], [0, -1]], [], False, False),
        ([[1], [0, -1]], [], True, True),
        ([[1], [0, "-11/10"]], [], True, False),
        ([["-1/10"], [1, -1]], [], False, False),  # at the gain 0
        ([[1], [0, "1/10"]], [], False, False),  # not concave
        ([["1/10"], [0, 0]], [], False, True),
        # phi = y_1, sigma - phi = y_2: of sigma phi - phi^2 = y_1 y_2 less N, entries >= 0, is left y_1^2 + y_2^2
        ([[1], ["-1/2", 1]], [[[["0"], ["1/2", "0"]]]], False, True),
        ([[1], ["-1/2", 1]], [[[["1"], ["1/2", "0"]]]], False, False),
        ([[1], ["-1/2", 1]], [[[["0"], ["-1/2", "0"]]]], False, False),
        ([[1], ["-1/2", 1]], [[[["1"], ["1/2", "0"]]]], True, True),
        ([[1], ["-1/2", 1]], [[[["0"], ["1/2", "0"]]] * 2], False, False),
    ],
)
def test_multipliers_of_a_full_block(Pi, parts, resting, holds):
    given = [[str(v) for v in row] for row in Pi]
    with nullcontext() if holds else pytest.raises((Rejected, Malformed)):
        channels.full_block(given, parts, [(F(0), F(1))], resting)


@pytest.mark.parametrize("kind", ["delay", "full block", "play"])
def test_what_has_no_bounds_of_phi_over_sigma(kind):
    one = nonlinearities(0, 1, slope=True, memory="play") if kind == "play" else nonlinearities(-1, 1, operator=kind)
    with pytest.raises(Rejected, match="channel 1"):
        channels.channels({"channels": [one], "repeated": False}, 1).bounds(0)


# det(1 + D G) at the vertices of [0, 1], or of [1, 2] after the shift by 1
@pytest.mark.parametrize(
    ("D", "low", "inside", "holds"),
    [
        ([[1]], 0, True, True),
        ([[1]], 0, False, False),
        ([["-99/100"]], 0, True, True),
        ([[-1]], 0, True, False),
        ([[-2]], 0, True, False),
        ([["-49/100"]], 1, True, True),
        ([["-1/2"]], 1, True, False),
        ([["1/2", 1], ["-1/2", "1/2"]], 0, True, True),
        ([["1/2", 2], [2, "1/2"]], 0, True, False),
    ],
)
def test_a_loop_has_one_solution_where_determinants_are_positive(D, low, inside, holds):
    m = len(D)
    plant = channels.Plant([[F(-1)]], matrix([[0] * m]), matrix([[0]] * m), matrix(D), discrete=False)
    with nullcontext() if holds else pytest.raises(Rejected):
        frequencies.solvable(plant, inside, [(F(low), F(low + 1))] * m)


# |G x - c x| <= r |x| for all x, c the middle of the bounds and r half of their distance
@pytest.mark.parametrize(
    ("low", "G", "holds"),
    [
        (-1, [[0, 1], [1, 0]], True),
        (-1, [[0, "101/100"], [1, 0]], False),
        (-1, [[0, 1], [-1, 0]], True),
        (-1, [[1, 0], [0, -1]], True),
        (-1, [["101/100", 0], [0, 0]], False),
        (-1, [["-101/100", 0], [0, 0]], False),
        (0, [["1/2", "1/2"], ["1/2", "1/2"]], True),
        (0, [["1/2", "51/100"], ["1/2", "1/2"]], False),
        (0, [["1/2", "1/2"], ["-1/2", "1/2"]], True),
        (0, [[0, 1], [-1, 0]], False),
        (0, [[1, 0], [0, 0]], True),
        (0, [["-1/100", 0], [0, 0]], False),
    ],
)
def test_which_matrices_are_gains_of_a_full_block(low, G, holds):
    one = nonlinearities(low, 1, operator="full block")
    asked = channels.channels({"channels": [one] * 2, "repeated": True}, 2)
    given = [[[str(v) for v in row] for row in G]]
    with nullcontext() if holds else pytest.raises(Rejected):
        assert channels.matrices([F(0)] * 2, given, asked) == matrix(G)


def test_a_constant_delay_is_an_operator_on_what_its_majorant_leaves():
    # sigma_1 = x + mu_2/3 behind a delay of up to 5/2, and sigma_2 = x: with mu_1 = -sigma_1 + w_1 the first output is
    # m(h s) sigma_1, m = RISE/FALL
    A, B, C, D = (
        [[F(v) for v in row] for row in side] for side in ([[-2]], [[1, 3]], [[1], [1]], [[0, "1/3"], [0, 0]])
    )
    delay = nonlinearities("-5/2", "5/2", operator="delay")
    asked = channels.channels({"channels": [delay, PLAIN], "repeated": False}, 2)
    found, taken = channels.undelayed(channels.Plant(A, B, C, D, discrete=False), asked)
    assert (taken.families[0].operator, taken.families[0].sector) == (channels.SCALAR, (-1, 1))
    for s in (0.3 + 0.7j, 2j):
        n, (a, b, c, d) = len(found.A), (np.array(side, dtype=float) for side in found[:4])
        H = c @ np.linalg.solve(s * np.eye(n) - a, b) + d
        x = np.array([1, 3 - 1 / 3]) / (s + 3)  # x' = -3 x + w_1 + (3 - 1/3) w_2
        top, low = (np.polyval([float(v) for v in p][::-1], 2.5 * s) for p in (frequencies.RISE, frequencies.FALL))
        assert H[0] == pytest.approx(top / low * (x + np.array([0, 1 / 3])))
        assert H[1] == pytest.approx(x)


# psi = phi - l sigma in [0, w sigma], c = |theta a|: with slopes between the bounds 2 c (psi sigma - psi^2/w), else
# 2 c psi sigma, or 2 c (w sigma^2 - psi sigma) for theta a > 0
@pytest.mark.parametrize("turn", [F(3, 2), F(-3, 2)])
@pytest.mark.parametrize(("low", "slope"), [(F(-1, 2), True), (F(-1, 2), False), (F(0), True), (F(1, 3), False)])
def test_what_terms_of_popov_add_at_a_rate(turn, low, slope):
    high = F(2)
    one = nonlinearities(low, high, slope=slope)
    asked = channels.channels({"channels": [PLAIN, one], "repeated": False}, 2)
    Pi = [[F(0)] * 4 for _ in range(4)]
    several.weighed(Pi, [F(0), turn], [(F(-1), F(1)), (low, high)], asked, F(1, 5))
    c, w = abs(turn) / 5, high - low
    for sigma, phi in ((F(1), F(3)), (F(-2), F(1, 7)), (F(5), F(0))):
        psi = phi - low * sigma
        expected = psi * sigma - psi**2 / w if slope else w * sigma**2 - psi * sigma if turn > 0 else psi * sigma
        z = [F(7), sigma, F(11), phi]
        assert (
            sum(v * x * y for row, x in zip(Pi, z, strict=True) for v, y in zip(row, z, strict=True))
            == 2 * c * expected
        )


@pytest.mark.parametrize("classes", [[OUT, PLAIN], [OUT, OUT], [PLAIN, OUT, PLAIN]])
def test_the_performance_channel_is_the_last(classes):
    with pytest.raises(Malformed, match="the last"):
        channels.channels({"channels": classes, "repeated": False}, len(classes))


def test_polynomials_in_s_are_read_at_i_omega():
    p = Form({(F(0), k): (F(c), F(0)) for k, c in enumerate((2, 3, 5, 7, 11, 13))} | {(F(2), 2): (F(17), F(0))})
    found = {(F(0), k): z for k, z in enumerate(((2, 0), (0, 3), (-5, 0), (0, -7), (11, 0), (0, 13)))}
    assert pieces.on_line(p) == found | {(F(2), 2): (-17, 0)}
