"""Forms, splines, pieces of the axis and gains of several channels in the second checker, by their formulas."""

import cmath
import math
from dataclasses import replace
from fractions import Fraction as F
from itertools import product
from types import SimpleNamespace
from unittest.mock import patch

import numpy as np
import pytest
from flint import acb, acb_series, arb, fmpq, fmpq_mat
from second_plants import PLAIN, asked, assert_accepted_if, of, poly, rational, rows_of, unit

from lure.analysis.certificates.second import channel_gains, parametric, pieces, powers, several
from lure.analysis.certificates.second.classes import NO_REST, NO_SOLUTION, OTHER_EQUILIBRIA, Claim, Graph
from lure.analysis.certificates.second.numerics import to_fmpq, working_precision
from lure.analysis.certificates.second.reading import NotShown
from lure.analysis.certificates.second.zero import shifted_by

TIMID = replace(PLAIN, slope=None, lower=F(-1), time_varying=True)
SEEN = replace(TIMID, operator="performance")
GAIN = replace(PLAIN, slope=None, linear=True)


# Forms


@pytest.mark.parametrize("discrete", [False, True])
def test_the_forms_of_several_channels_are_what_v_is_and_falls_by(discrete):
    A, B, C = [[-1, 2], [fmpq(1, 3), -4]], [[1, 2], [fmpq(1, 2), -1]], [[3, -1], [1, 1]]
    plant = asked(A, B, C, [[0, 0], [fmpq(1, 5), fmpq(1, 7)]], discrete=discrete)
    bounds, theta = [(F(1, 2), F(3)), (F(-1, 3), F(2))], [F(0) if discrete else F(-2, 3), F(0)]
    rows, exponent = [[40], [4, 24]], 3
    P, Pi = np.array([[5, 0.5], [0.5, 3]]), np.array([[2.0, 1, 3, -1], [1, 4, 0, 2], [3, 0, -5, 1], [-1, 2, 1, -6]])
    shifted = shifted_by(plant, bounds)
    least, whole = several._forms(
        (plant.C, bounds, discrete), shifted, (rows, exponent), fmpq_mat([[int(v) for v in row] for row in Pi]), theta
    )
    A, B, C, D = map(rows_of, shifted)
    own, t, low = rows_of(plant.C), np.diag(list(map(float, theta))), np.diag([0.5, -1 / 3])
    Q = P + own.T @ low @ t @ own
    width = np.diag([2.5, 7 / 3])
    assert rows_of(least) == pytest.approx(Q + own.T @ np.minimum(t, 0) @ width @ own)
    x, psi = np.array([2.0, -1]), np.array([3.0, 0.5])
    moved, sigma = A @ x - B @ psi, C @ x - D @ psi
    rise = moved @ Q @ moved - x @ Q @ x if discrete else 2 * x @ Q @ moved + 2 * psi @ t @ own @ moved
    both, seen = np.concatenate([x, psi]), np.concatenate([sigma, psi])
    assert both @ rows_of(whole) @ both == pytest.approx(-rise - seen @ Pi @ seen)
    assert rows_of(whole) == pytest.approx(rows_of(whole).T)


def test_multipliers_of_channels_are_their_forms():
    one = [replace(PLAIN, lower=F(low), upper=F(high), slope=None) for low, high in ((-1, 2), (1, 3))]
    plant = asked([[-1]], [[1, 1]], [[1], [1]], [[0, 0]] * 2, *one)
    v = np.array([2.0, -1, 3, 0.5])  # sigma, psi: 2 lambda psi (w sigma - psi)
    form = rows_of(several._diagonal_multiplier([F(1, 2), F(3)], plant))
    assert v @ form @ v == pytest.approx(2 * 0.5 * 3 * (3 * 2 - 3) + 2 * 3 * 0.5 * (2 * -1 - 0.5))
    free = rows_of(several._with_rate([F(2), F(-3)], F(1, 4), plant.bounds, plant))
    # turn > 0: 2 turn w sigma^2 - 2 turn psi sigma; turn < 0: -2 turn psi sigma
    assert v @ free @ v == pytest.approx(2 * 0.5 * 3 * 4 - 2 * 0.5 * 3 * 2 + 2 * 0.75 * 0.5 * -1)
    given = {"Pi": [["1"], ["2", "0"], ["1", "1", "-3"], ["0", "2", "1", "-4"]]}
    Pi, needed = several._full_block(given, plant.bounds)
    own = np.array([[1, 2, 1, 0], [2, 0, 1, 2], [1, 1, -3, 1], [0, 2, 1, -4]])
    phi = np.array([2.0, -1, 3 - 2, 0.5 - 1])  # phi = psi + l sigma
    assert v @ rows_of(Pi) @ v == pytest.approx(phi @ own @ phi)
    corners = [np.array([2.0, -1, *(np.array(g) * [2.0, -1])]) for g in product((-1, 2), (1, 3))]
    assert [v[:2] @ rows_of(M) @ v[:2] for M in needed] == pytest.approx([c @ own @ c for c in corners])
    with pytest.raises(NotShown, match="not concave"):
        several._full_block({"Pi": [*given["Pi"][:3], ["0", "2", "1", "1"]]}, plant.bounds)
    zero = [["0"] * (k + 1) for k in range(4)]
    N = [[*zero[:3], ["0", "0", "0", str(k)]] for k in (1, 2)]
    _, parted = several._full_block(given | {"N": N}, plant.bounds)
    for k, (signs, M) in enumerate(zip(((1, 1), (1, -1)), parted, strict=True), start=1):
        y = np.array([1.0, 2, 3, 0.5])  # psi and w sigma - psi, times the signs
        psi, rest = y[:2] * signs, y[2:] * signs
        seen = np.array([*((psi + rest) / [3, 2]), *psi])
        assert y @ rows_of(M) @ y == pytest.approx(seen @ rows_of(Pi) @ seen - k * 0.25)
    for bad in ([*N, N[0]], N[:1], [[*zero[:3], ["0", "0", "0", "-1"]]] * 2):
        with pytest.raises(NotShown):
            several._full_block(given | {"N": bad}, plant.bounds)


@pytest.mark.parametrize(("least", "fine"), [(F(0), True), (F(-1, 9), False), (F(1, 9), True)])
def test_a_form_of_three_is_not_negative(least, fine):
    assert several._nonnegative(fmpq_mat([[1, 1, 0], [1, 1, 0], [0, 0, to_fmpq(least)]])) is fine


@pytest.mark.parametrize(
    ("one", "direct", "theta", "holds"),
    [
        ({}, 0, 1, True),
        ({}, 1, 1, False),
        ({}, 1, 0, True),
        ({"time_varying": True}, 0, 1, False),
        ({"operator": "any"}, 0, 1, False),
        ({"time_varying": True}, 0, 0, True),
    ],
)
def test_popovs_term_is_of_a_function_of_the_states(one, direct, theta, holds):
    plant = asked([[-1]], [[1, 1]], [[1], [1]], [[0, direct], [0, 0]], replace(PLAIN, **one), PLAIN)
    with assert_accepted_if(holds):
        several._require_fitting([F(theta), F(0)], plant)


KERNEL = {"channels": [1, 1], "coefficient": "1/4", "rate": "4", "order": 1, "side": "causal"}


@pytest.mark.parametrize(
    ("one", "change", "theta", "kernels", "holds"),
    [
        ({}, {}, "0", [], True),
        ({}, {}, "1/9", [], True),
        ({}, {}, "0", [KERNEL], True),
        ({"rough": True}, {}, "0", [], False),
        ({"time_varying": True}, {}, "0", [], True),
        ({"time_varying": True}, {}, "1/9", [], False),
        ({"time_varying": True}, {}, "0", [KERNEL], False),
        ({"slope": None}, {}, "0", [KERNEL], False),
        ({"slope": None}, {}, "1/9", [], True),
        ({"upper": "inf", "slope": None}, {}, "0", [], False),
        ({"lower": F(1), "upper": F(3), "slope": (F(0), F(1))}, {}, "0", [], False),  # 1 alone
        ({}, {"D": fmpq_mat([[1]])}, "0", [], True),
        ({}, {"D": fmpq_mat([[1]])}, "1/9", [], False),
        ({}, {"D": fmpq_mat([[-2]])}, "0", [], False),
        ({}, {"discrete": True}, "0", [], False),
    ],
)
def test_which_multipliers_there_are_over_frequencies(one, change, theta, kernels, holds):
    plant = replace(asked([[-9]], [[1]], [[1]], [[0]], replace(PLAIN, **one)), **change)
    given = {"gamma": [["1"]], "theta": [theta], "kernels": kernels}
    document = SimpleNamespace(
        proof={"method": "determinant"}, theorem="matrix-zames-falb", multiplier=given, rate=None
    )
    with assert_accepted_if(holds):
        assert several._over_frequencies(document, plant) is False
        with patch.object(several, "require_frequencies") as asked_for:
            several._over_frequencies(document, plant)
        assert asked_for.call_args.args[-1] == fmpq_mat(1, 1)  # no pole at 0


# Splines: the matrix at a point, of x_1' = .. with one gain, one function beside it, and direct terms


@pytest.mark.parametrize("discrete", [False, True])
def test_a_spline_falls_by_its_bernstein_coefficients(discrete):
    A, B, C = [[-1, 2], [fmpq(1, 3), -4]], [[1, 2], [fmpq(1, 2), -1]], [[3, -1], [1, 1]]
    D = [[0, fmpq(1, 7)], [0 if not discrete else fmpq(1, 5), 0]]
    gain, one = replace(GAIN, time_varying=True, rate=F(3, 2)), replace(PLAIN, lower=F(1, 2), upper=F(3), slope=None)
    plant = asked(A, B, C, D, gain, one, discrete=discrete)
    P = {(k,): fmpq_mat([[5 + k, 1], [1, 3 - k]]) for k in range(5)}
    spline = parametric.Spline(
        degree=2, pieces=[2], ends=[(F(0), F(4))], rates=[F(3, 2)], channels=[[0]], coefficients=P
    )
    weight, theta = F(2, 5), F(0) if discrete else F(1, 3)
    assert parametric._reached(spline, (0,), discrete=discrete) == ([(0,), (1,)] if discrete else [(0,)])
    found = parametric._falls(plant, spline, (0,), (1,) if discrete else (0,), [(1, weight, theta)])
    s, q = 0.3, 0.6
    g, x, phi = 2 * s, np.array([2.0, -1]), 0.7
    a, b, c, d = map(rows_of, (plant.A, plant.B, plant.C, plant.D))
    mu = np.array([0, -phi])
    mu[0] = -g * (c[0] @ x + d[0] @ mu)
    sigma, moved = c @ x + d @ mu, a @ x + b @ mu

    def V(box, at):
        weights = [(1 - at) ** 2, 2 * at * (1 - at), at * at]
        return sum(v * rows_of(P[(2 * box + k,)]) for k, v in enumerate(weights))

    if discrete:
        rise, degrees = moved @ V(1, q) @ moved - x @ V(0, s) @ x, (2, 2)
    else:
        h = 1e-6
        slope = (V(0, s + h) - V(0, s - h)) / (2 * h) / 2  # over the length of a piece
        rise = 2 * x @ V(0, s) @ moved + x @ slope @ x * 1.5 * (2 * q - 1)
        rise, degrees = rise + 2 * float(theta) * phi * (c[1] @ moved), (3, 1)
    wanted = -rise - 2 * 0.4 * (phi - 0.5 * sigma[1]) * (3 * sigma[1] - phi)
    z = np.array([*x, phi])
    total = sum(
        math.comb(degrees[0], i) * s**i * (1 - s) ** (degrees[0] - i)
        * math.comb(degrees[1], j) * q**j * (1 - q) ** (degrees[1] - j)
        * (z @ rows_of(found[i * (degrees[1] + 1) + j]) @ z)
        for i, j in product(range(degrees[0] + 1), range(degrees[1] + 1))
    )  # fmt: skip
    assert total == pytest.approx(wanted, rel=1e-6)
    context = parametric.fmpq_mpoly_ctx.get(["s"], parametric.Ordering.lex)
    with pytest.raises(NotShown, match="higher degree"):
        parametric._bernstein([[context.gens()[0] ** 2]], [1])


def test_within_reach_are_boxes_no_farther_than_the_rate():
    for rate, near in ((F(1), [0, 1, 2]), (F(99, 100), [0, 1]), (F(0), [0])):
        spline = parametric.Spline(
            degree=1, pieces=[4], ends=[(F(0), F(4))], rates=[rate], channels=[[0]], coefficients={}
        )
        assert parametric._reached(spline, (0,), discrete=True) == [(k,) for k in near]
        assert parametric._reached(spline, (0,), discrete=False) == [(0,)]
        assert spline.piece(0, 3) == (3, 4)


@pytest.mark.parametrize(
    ("change", "other", "holds"),
    [
        ({}, {}, True),
        ({"pieces": []}, {}, False),
        ({"P": [[["1"]]]}, {}, False),
        ({"P": [[["1"]], [["-1"]]]}, {}, False),
        ({"method": "matrix"}, {}, False),
        ({"degree": 0}, {}, False),
        ({}, {"lambda": [["-1"]]}, False),
        ({}, {"lambda": [[]]}, False),
        ({}, {"lambda": [["1"], ["1"]]}, False),
        ({}, {"theta": []}, False),
        ({"pieces": [], "P": [[["1"]]]}, {"linear": (False, False), "lambda": [["1"] * 2], "theta": ["0"] * 2}, False),
        ({}, {"rough": True}, False),
        ({}, {"rate": None}, False),
        ({}, {"D": [[0, 0], [0, 1]]}, True),
        ({}, {"D": [[1, 0], [0, 0]]}, False),
        ({}, {"D": [[0, 0], [0, 1]], "theta": ["1"]}, False),
        ({}, {"theta": ["1"]}, True),
        ({}, {"theta": ["-2"]}, False),  # V = x^2 - 4 int phi with phi up to sigma
        ({}, {"function": {"time_varying": True}, "theta": ["1"]}, False),
        ({}, {"function": {"time_varying": True}}, True),
    ],
)
def test_what_a_spline_has_to_be(change, other, holds):
    linear = other.get("linear", (True, False))
    gain = replace(
        GAIN, time_varying=True, rate=other.get("rate", F(1)), linear=linear[0], rough=other.get("rough", False)
    )
    plant = asked(
        [[-4]], [[1, 1]], [[1], [1]], other.get("D", [[0, 0]] * 2), gain, replace(PLAIN, **other.get("function", {}))
    )
    given = {"lambda": other.get("lambda", [["1"]]), "theta": other.get("theta", ["0"])}
    proof = {"method": "spline", "degree": 1, "pieces": [1], "P": [[["1"]], [["1"]]], "exponent": 0}
    with assert_accepted_if(holds):
        parametric.require_parametric(SimpleNamespace(multiplier=given, proof=proof | change), plant)


# Pieces of the axis


def test_the_form_of_all_kinds_of_channels_is_that_of_complex_numbers():
    A, B = [[-1, 2, 0], [0, -3, 1], [1, 0, -2]], [[1, 0, 2, 1], [0, 1, 1, 0], [1, 1, 0, 2]]
    C = [[1, 0, 0], [0, 1, 1], [1, -1, 0], [0, 0, 2]]
    plant = asked(A, B, C, [[0] * 4] * 4)
    known = [
        pieces._Channel("", F(3), F(2, 3), F(1, 4), low=F(1, 5)),
        pieces._Channel("free", F(2), F(0), F(0), low=F(-1, 3)),
        pieces._Channel("delay", F(5, 2), F(0), F(0)),
        pieces._Channel("slow", F(1, 2), F(0), F(0), rate=F(1, 3)),
    ]
    row = [None, (F(1, 2), F(-2)), (F(-1, 4), F(2, 3)), (F(3, 4), F(1, 5))]
    d, N = pieces.numerators((plant.A, plant.B, plant.C, plant.D))
    omega, s = 1.25, 1.25j
    H = np.array(C) @ np.linalg.solve(s * np.eye(3) - np.array(A), np.array(B))
    e = np.eye(4)
    Y = [
        2 / 3 * (e[0] + 3.4 * H[0]) + s / 4 * H[0],
        (0.5 - 2j) * (e[1] + 2 * H[1]) - 0.5 * 2 / 3 * H[1],
        (2 / 3 * cmath.exp(-1j * omega * 1.25) + 0.25) * H[2] - e[2] / 8,
        -0.75 * H[3] + (0.75 + 0.2) / 2 * e[3],
    ]
    F_ = np.array(Y) + np.array(Y).conj().T

    def less(i, weight, turned=1.0):
        return weight * np.outer((turned * H[i]).conj(), turned * H[i])

    F_ = F_ - less(0, -2 * 2 / 3 * 0.2 * 3.2) - less(1, 2 * 0.5 / 3 * (2 - 1 / 3))
    F_ = F_ - less(3, 0.75 * 0.5) - less(3, 0.2 * 0.25, s)
    with working_precision(96):
        near = pieces._Loop([acb(arb(c)) for c in d.coeffs()], pieces._balls(N), [[]], discrete=False, far=False)
        found = pieces._series(near, known, row, acb_series([acb(arb(fmpq(5, 4))), acb(1)]))
        assert np.array([[complex(v[0].mid()) for v in line] for line in found]) == pytest.approx(F_)
        far = pieces._Loop(
            pieces._reversed(d, 3),
            *([[pieces._reversed(f * g, 3) for f in line] for line in N] for g in (poly(1), poly(0, 1))),
            discrete=False,
            far=True,
        )
        plain = [(one, None if pair is None else (pair[0], F(0))) for one, pair in zip(known, row, strict=True)]
        sides = [[one for one, _ in plain], [pair for _, pair in plain]]
        here, there = (
            pieces._series(loop, *sides, acb_series([acb(arb(t)), acb(1)]))
            for loop, t in ((near, fmpq(5, 4)), (far, fmpq(4, 5)))
        )
        for i, j in product(range(4), repeat=2):
            assert here[i][j][0].overlaps(there[i][j][0])


@pytest.mark.parametrize("turn", [1, 1j])
@pytest.mark.parametrize(
    ("low", "high", "holds"),
    [
        (F(0), F(99, 100), True),
        (F(0), F(101, 100), False),
        (F(99, 100), F(3, 2), False),
        (F(-99, 100), F(1, 2), True),
        (F(-101, 100), F(1, 2), False),
        (F(3, 2), F(5, 2), False),
    ],
)
def test_a_hermitian_form_is_positive_on_all_of_a_piece(turn, low, high, holds):
    # 1 beside t in every way: 1 - t^2 > 0
    for i, j in ((0, 1), (0, 2), (1, 2)):

        def series(t, i=i, j=j):
            M = [[0 * t + int(a == b) for b in range(3)] for a in range(3)]
            M[i][j], M[j][i] = t * acb(turn), t * acb(turn).conjugate()
            return M

        with working_precision(96), assert_accepted_if(holds):
            pieces._require_piece(series, low, high)
    with working_precision(96), assert_accepted_if(holds):
        pieces._require_piece(lambda t: [[1 - t * t]], low, high)


@pytest.mark.parametrize(
    ("change", "discrete", "holds"),
    [
        ({}, False, True),
        ({"ends": ["2", "1"]}, False, False),
        ({"ends": ["0", "2"]}, False, False),
        ({"ends": ["1"]}, False, False),
        ({"ends": ["1", "2", "3"]}, False, False),
        ({"lambda": ["1"]}, False, False),
        ({"pieces": [[None], [None], [None]]}, False, False),
        ({"method": "matrix"}, False, False),
        ({"pieces": [[None, ["1", "0"]]] * 2, "ends": ["1", "32/10"]}, True, True),
        ({"pieces": [[None, ["1", "0"]]] * 2, "ends": ["1", "314/100"]}, True, False),
        ({"pieces": [[None, ["1", "0"]]] * 3, "ends": ["1", "32/10"]}, True, False),
    ],
)
def test_the_pieces_of_the_axis_follow_one_another(change, discrete, holds):
    plant = asked([[0]], [[1, 1]], [[1], [1]], [[0, 0]] * 2, PLAIN, GAIN, discrete=discrete)
    given = {"lambda": ["1", "0"], "pieces": [[None, ["1", "0"]]] * 3, "method": "pieces", "ends": ["1", "2"]} | change
    sides = [{name: given[name] for name in names} for names in (("lambda", "pieces"), ("method", "ends"))]
    with assert_accepted_if(holds):
        pieces._read(SimpleNamespace(theorem="piecewise-circle", multiplier=sides[0], proof=sides[1]), plant)
    if discrete:
        popov = SimpleNamespace(theorem="piecewise-popov", multiplier=sides[0] | {"theta": ["0", "0"]}, proof=sides[1])
        with pytest.raises(NotShown, match="continuous time"):
            pieces._read(popov, plant)


# Gains


@pytest.mark.parametrize(
    ("p", "low", "high", "holds"),
    [
        (poly(2, -1), 0, 1, True),
        (poly(2, -1), 0, F(19, 10), True),
        (poly(2, -1), 0, 2, False),
        (poly(2, -1), 0, None, False),
        (poly(-1, 2), F(1, 2), None, False),
        (poly(-1, 2), F(51, 100), None, True),
        (poly(-1, 2), F(51, 100), 3, True),
        (poly(-1, 2), F(1, 3), 3, False),
        (poly(1, -2, 1), 0, 2, False),
        (poly(1, -2, 1), 2, 3, True),
        (poly("-1/2"), 0, 1, False),
        (poly(1, -3, 2), 0, 2, False),  # negative from 1/2 to 1
    ],
)
def test_a_polynomial_is_positive_between_two_numbers(p, low, high, holds):
    assert channel_gains.positive_between(p, F(low), None if high is None else F(high)) is holds


@pytest.mark.parametrize(
    ("A", "discrete", "said"),
    [
        ([[1, 0], [0, -1]], False, NO_REST),
        ([[-1, 5], [0, -1]], False, None),
        ([[0, 1], [-1, 0]], False, NO_REST),
        ([[0, 0], [0, -1]], False, OTHER_EQUILIBRIA),
        ([[0, 0], [0, 0]], False, OTHER_EQUILIBRIA),
        ([[0, 1], [0, 0]], False, NO_REST),
        ([[0, 0], [0, 1]], False, NO_REST),
        ([[1, 0], [0, 0]], True, OTHER_EQUILIBRIA),
        ([[1, 0], [0, 1]], True, OTHER_EQUILIBRIA),
        ([[1, 1], [0, 1]], True, NO_REST),
        ([[-1, 0], [0, 0]], True, NO_REST),
        ([[-1, 0], [0, 1]], True, NO_REST),
        ([[0, 1], [-1, 0]], True, NO_REST),
        ([[fmpq(9, 10), 5], [0, fmpq(-9, 10)]], True, None),
        ([[fmpq(11, 10), 0], [0, 0]], True, NO_REST),
    ],
)
def test_what_a_loop_of_gains_does(A, discrete, said):
    with assert_accepted_if(said is not None):
        assert channel_gains.unstable(fmpq_mat(A), discrete=discrete) == said


@pytest.mark.parametrize(
    ("low", "G", "holds"),
    [
        (-1, [[0, 1], [-1, 0]], True),
        (-1, [["4/5", "-3/5"], ["3/5", "4/5"]], True),
        (-1, [["4/5", "-3/5"], ["3/5", "81/100"]], False),
        (-1, [["101/100", "0"], ["0", "0"]], False),
        (-1, [["0", "0"], ["0", "-101/100"]], False),
        (-1, [["0", "101/100"], ["0", "0"]], False),
        (0, [["1/2", "1/2"], ["-1/2", "1/2"]], True),
        (0, [["1/2", "51/100"], ["-1/2", "1/2"]], False),
        (0, [["-1/100", "0"], ["0", "1/2"]], False),
        (-1, [["0", "1"]], False),
    ],
)
def test_which_matrices_a_function_of_a_block_has(low, G, holds):
    one = replace(TIMID, operator="full block", lower=F(low))
    plant = asked(
        [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        unit(3).tolist(),
        unit(3).tolist(),
        [[0] * 3] * 3,
        PLAIN,
        one,
        one,
        repeated=(0, 1, 1),
    )
    given = [[[str(v) for v in row] for row in G]]
    with assert_accepted_if(holds):
        found = channel_gains._matrices([F(1, 3), F(0), F(0)], given, plant)
        assert rows_of(found) == pytest.approx(
            np.block(
                [
                    [np.eye(1) / 3, np.zeros((1, 2))],
                    [np.zeros((2, 1)), np.array([[float(F(v)) for v in row] for row in given[0]])],
                ]
            )
        )
    for other in ([], given * 2):
        with pytest.raises(NotShown, match="one matrix for each"):
            channel_gains._matrices([F(0)] * 3, other, plant)


# x' = a x - g x
@pytest.mark.parametrize(
    ("a", "gain", "rate", "discrete", "holds"),
    [
        (1, 0, "1", False, True),
        (1, 0, "101/100", False, False),
        (1, F(1, 2), "1/2", False, True),
        (1, F(1, 2), "51/100", False, False),
        (1, 0, "0", False, False),
        (1, 0, "-1", False, False),
        (3, 0, "2", True, True),
        (3, 0, "201/100", True, False),
        (-3, 0, "2", True, True),  # at -1 of the slower loop
        (-3, 0, "201/100", True, False),
    ],
)
def test_a_solution_grows_at_a_rate(a, gain, rate, discrete, holds):
    plant = asked([[a]], [[1]], [[1]], [[0]], GAIN, discrete=discrete)
    with assert_accepted_if(holds):
        assert channel_gains._growing(plant, [F(gain)], F(rate)) == NO_REST


# x_1' = x_1 + w_1, x_2' = -x_2 + w_2, z = (x_1, x_2): no gain is finite from w_1 to z_1, others are
@pytest.mark.parametrize(
    ("places", "A", "D", "discrete", "holds"),
    [
        ([1, 1], 1, 0, False, True),
        ([1, 2], 1, 0, False, False),
        ([2, 1], 1, 0, False, False),
        ([2, 2], 1, 0, False, False),
        ([1, 1], 0, 0, False, True),
        ([1, 1], -1, 0, False, False),
        ([1, 3], 1, 0, False, False),
        ([1, 1], 1, 0, True, True),
        ([1, 1], -1, 0, True, True),
        ([1, 1], fmpq(1, 2), 0, True, False),
        ([1, 1], 2, 1, False, True),  # x_1' = 2 x_1 - g x_1/(1 + g), g = 1
        ([1, 1], fmpq(1, 3), 1, False, False),
    ],
)
def test_what_is_seen_of_a_disturbance_has_its_poles(places, A, D, discrete, holds):
    sides = [[A, 0], [0, 0 if discrete else -1]], [[1, 1, 0], [0, 0, 1]], [[1, 0], [1, 0], [0, 1]]
    plant = asked(*sides, [[D, 0, 0], [0] * 3, [0] * 3], GAIN, SEEN, SEEN, repeated=(0, 1, 1), discrete=discrete)
    gains = [str(D), "0", "0"]
    with assert_accepted_if(holds):
        channel_gains._require_unlimited(of(method="linear-gains", gains=gains, unlimited=places), plant)


MOVING = replace(PLAIN, slope=None, time_varying=True)
PACED = replace(GAIN, time_varying=True, rate=F(1, 2))


@pytest.mark.parametrize(
    ("one", "method", "discrete", "gains", "times", "D", "holds"),
    [
        (MOVING, "switched-gains", False, [0, 1], [1, 2], 0, True),
        (PLAIN, "switched-gains", False, [0, 1], [1, 2], 0, False),
        (PLAIN, "switched-gains", False, [1, 1], [1, 2], 0, True),
        (MOVING, "switched-gains", False, [0, 2], [1, 2], 0, False),
        (MOVING, "switched-gains", False, [0, 1], [1, 0], 0, False),
        (MOVING, "switched-gains", False, [0, 1], [1], 0, False),
        (MOVING, "switched-gains", False, [0, 1], [1, 2], 1, True),
        (PACED, "switched-gains", False, [0, 1], [2, 2], 0, False),
        (PACED, "ramped-gains", False, [0, 1], [2, 2], 0, True),
        (PACED, "ramped-gains", False, [0, 1], [2, F(19, 10)], 0, False),
        (PACED, "ramped-gains", False, [0, 1], [F(19, 10), 2], 0, False),
        (PACED, "ramped-gains", False, [0, 1], [2, 2], 1, False),
        (PACED, "ramped-gains", True, [0, 1], None, 0, False),
        (PACED, "switched-gains", True, [0, F(1, 2)], None, 0, True),
        (PACED, "switched-gains", True, [0, 1], None, 0, False),
    ],
)
def test_which_gains_a_class_has_in_turn(one, method, discrete, gains, times, D, holds):
    plant = asked([[1]], [[1]], [[1]], [[D]], one, discrete=discrete)
    found = {"method": method, "gains": [[str(g)] for g in gains], "bits": 64}
    found |= {} if times is None else {"times": [str(t) for t in times]}
    with assert_accepted_if(holds):
        rows, taken, ramps = channel_gains.read_jumps(found, plant)
        assert (rows, ramps) == ([[F(g)] for g in gains], method == "ramped-gains")
        assert taken == [F(t) for t in times or [1] * len(gains)]


# of one state: exp(a T) over a period, and 2^k in samples; of two states tr > 2
@pytest.mark.parametrize(
    ("steps_", "holds"),
    [
        ([([[1]], 1), ([[-1]], F(99, 100))], True),
        ([([[1]], 1), ([[-1]], F(101, 100))], False),
        ([([[F(1, 2)]], None), ([[3]], None)], True),
        ([([[F(1, 2)]], None), ([[F(19, 10)]], None)], False),
        ([([[0, 2], [0, 0]], None), ([[0, 0], [1, 0]], None)], True),  # of [[0, 0], [0, 2]]
        ([([[0, 2], [0, 0]], None), ([[0, 0], [F(2, 5), 0]], None)], False),
        ([([[0, 1], [-1, 0]], 1)], False),
    ],
)
def test_a_period_of_jumps_has_an_eigenvalue_outside(steps_, holds):
    rows = [(fmpq_mat([[to_fmpq(F(v)) for v in row] for row in M]), t) for M, t in steps_]
    with assert_accepted_if(holds):
        channel_gains.require_outside([(M, M, None if t is None else F(t)) for M, t in rows])


def test_on_pieces_the_loop_is_that_of_its_lines():
    A, B, C, D = [[-1, 2], [0, -3]], [[1, 0], [2, 1]], [[1, 1], [0, 2]], [[0, fmpq(1, 3)], [fmpq(1, 4), 0]]
    plant = asked(A, B, C, D)
    bent = Graph((F(-1), F(0), F(1)), (F(-1, 2), F(0), F(1, 2)), (F(0), F(1, 2), F(1, 2), F(1, 4)))
    for row, lines in (((0, 1), ((0, -0.5), (0.5, 0))), ((2, 0), ((0.25, 0.25), (0, -0.5)))):
        flow, seen = map(rows_of, channel_gains._on_pieces(plant, [bent, bent], row))
        x = np.array([2.0, -1])
        K, q = np.diag([k for k, _ in lines]), np.array([v for _, v in lines])
        c, d = rows_of(plant.C), rows_of(plant.D)
        sigma = np.linalg.solve(np.eye(2) + d @ K, c @ x - d @ q)  # sigma = C x - D (K sigma + q)
        assert seen @ [*x, 1] == pytest.approx(sigma)
        assert flow @ [*x, 1] == pytest.approx(rows_of(plant.A) @ x - rows_of(plant.B) @ (K @ sigma + q))


def test_a_loop_of_samples_without_solution_is_said_to_be_none():
    plant = asked([[fmpq(1, 2)]], [[1]], [[1]], [[-1]], PLAIN, discrete=True)
    proof = {"method": "linear-gains", "gains": ["1"]}
    assert channel_gains.refuted(of(**proof), plant) == NO_SOLUTION


# Forms of higher degree: x_1^2, x_1 x_2 and x_2^2 along x_1' = x_2, x_2' = -x_1 - x_2


def test_polynomials_are_those_of_their_matrices_along_a_flow():
    assert powers._basis(2, 2) == [(2, 0), (1, 1), (0, 2)]
    assert len(powers._basis(3, 4)) == 15
    G = fmpq_mat([[1, 2, -1], [2, -3, 0], [-1, 0, -1]])  # -1 x_2^4, and -1 - 1 - 3 of x_1^2 x_2^2
    assert powers._polynomial(G, powers._basis(2, 2)) == {(4, 0): 1, (3, 1): 4, (2, 2): -5, (0, 4): -1}
    A = ((F(0), F(1)), (F(-1), F(-1)))
    assert powers._along({(2, 1): fmpq(3)}, A) == {(1, 2): 6, (3, 0): -3, (2, 1): -3}
    assert powers._along({(0, 2): fmpq(1), (2, 0): fmpq(1)}, A) == {(0, 2): -2}


# x' = -(1 + g) x: V = x^4, -V' = 4 (1 + g) x^4; of two states V = x_1^4 + x_2^4 falls with -V' = 4 V
@pytest.mark.parametrize(
    ("change", "gain", "holds"),
    [
        ({}, {}, True),
        ({"P": [["-1"]]}, {}, False),
        ({"lower": [["-1"]]}, {}, False),
        ({"upper": [["1"]]}, {}, False),
        ({"power": 0}, {}, False),
        ({"power": 101}, {}, False),
        ({"method": "matrix"}, {}, False),
        ({}, {"upper": "finite"}, False),
        ({}, {"lower": F(-2)}, False),
        ({"P": [["1"], ["0", "1"]]}, {}, False),
    ],
)
def test_a_form_of_degree_four_falls_at_both_ends(change, gain, holds):
    # what a Gram matrix G has beside P A + A' P on the monomials vanishes there: of one state 0
    claim = Claim.of(replace(PLAIN, slope=None, **gain))
    proof = {"method": "powers", "power": 2, "P": [["1"]], "lower": [["0"]], "upper": [["0"]]}
    with assert_accepted_if(holds):
        powers.require_powers(rational([[-1]], [1], [1]), claim, proof | change)
    with pytest.raises(NotShown):
        powers.require_powers(rational([[1]], [1], [1]), claim, proof | change)


def test_a_form_beside_a_pole_at_0_bounds_what_a_stable_one_attracts():
    claim, proof = Claim.of(replace(PLAIN, slope=None)), {"method": "powers", "power": 2, "P": [["1"]]}
    proof |= {"lower": [["0"]], "upper": [["0"]]}
    assert powers.require_powers(rational([[-1]], [1], [1]), claim, proof) == "stable"
    assert powers.require_powers(rational([[0]], [1], [1]), claim, proof) == "critical"  # x' = -g x
