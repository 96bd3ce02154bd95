"""Parts of the second checker by themselves: each value is worked out here, and mutants lived until it was."""

import math
from dataclasses import replace
from fractions import Fraction as F
from types import SimpleNamespace

import pytest
from flint import acb, acb_mat, acb_series, arb, arb_mat, arb_series, fmpq, fmpq_mat, fmpq_poly
from second_plants import PLAIN, asked, at

from lure.analysis.certificates.second import boxes, cover, frequencies, matrix, members, pieces
from lure.analysis.certificates.second.classes import SCALAR, Claim, Graph, require_member
from lure.analysis.certificates.second.counterexamples import _power
from lure.analysis.certificates.second.curves import Arc, curve_of, require_crossed
from lure.analysis.certificates.second.delays import without_delays
from lure.analysis.certificates.second.graphs import Graph as Curved
from lure.analysis.certificates.second.graphs import Loop, positive_inside
from lure.analysis.certificates.second.late_loops import LateLoop
from lure.analysis.certificates.second.numerics import (
    ball,
    half_plane_counts,
    nonnegative_on_circle,
    positive_roots,
    working_precision,
)
from lure.analysis.certificates.second.orbits import Stay, Watched, _Equations, stays_of
from lure.analysis.certificates.second.order import strictly_copositive
from lure.analysis.certificates.second.pace import kernel_weights, popov_terms
from lure.analysis.certificates.second.question import read_kernels, require_legal
from lure.analysis.certificates.second.reading import NotShown
from lure.analysis.certificates.second.systems import RodData, States
from lure.analysis.certificates.second.windows import read_forms
from lure.analysis.certificates.second.zero import require_one_solution, shifted_by

# Loops with dead time

LATE = LateLoop(
    A=fmpq_mat([[-1, 2], [0, -3]]),
    B=fmpq_mat([[1, 0], [1, 2]]),
    C=fmpq_mat([[1, 1], [0, 2]]),
    D=fmpq_mat([[0, fmpq(1, 3)], [0, 0]]),
    late=(
        (F(1), fmpq_mat([[0, fmpq(1, 2)], [1, 0]]), fmpq_mat([[1, 0], [0, 1]])),
        (F(2), fmpq_mat([[fmpq(1, 4), 0], [0, 1]]), fmpq_mat([[0, 1], [1, 0]])),
    ),
    rates=(
        (fmpq_mat([[fmpq(1, 5), 0], [fmpq(1, 7), 0]]), fmpq_mat([[0, 0], [fmpq(1, 6), 0]])),
        (fmpq_mat(2, 2), fmpq_mat(2, 2)),
    ),
    pace=F(1, 8),
)


@pytest.mark.parametrize("omega", [F(63, 10), F(97, 10), F(20)])
def test_all_ways_to_the_response_of_a_late_loop_agree(omega):
    with working_precision(128):
        whole, s = LATE.at(ball(omega)), acb(0, ball(omega))
        series = LATE.response(acb_series([s, acb(1)]))
        below = LATE.determinant(acb_series([s, acb(1)]))[0]
        turn = LATE._turn(omega, omega) * s**2
        assert below.overlaps(turn)
        turns = -omega / F(math.tau)
        arcs = [(turns - F(1, 1000), turns + F(1, 1000))]
        plain, *rest = LATE.at_any_phase(1 / ball(omega), arcs)
        for i in range(2):
            for j in range(2):
                assert series[i][j][0].overlaps(whole[i, j])
                assert (LATE.determinant(acb_series([s, acb(1)]), (i, j))[0] / below).overlaps(whole[i, j])
                about = plain[0][i, j] + sum((one[0][i, j] * (-s * 2).exp() for one in rest), acb(0))
                assert about.overlaps(whole[i, j])
                if i == 0:  # s H without the direct term is asked for in rows without x' alone
                    about = plain[1][i, j] + sum((one[1][i, j] * (-s * 2).exp() for one in rest), acb(0))
                    assert about.overlaps((whole[i, j] - acb(arb(LATE.D[i, j]))) * s)


@pytest.mark.parametrize(("omega", "wait"), [(8, 1), (8, -1), (6, 1), (6, -1)])
def test_a_state_that_comes_back_has_any_phase(omega, wait):
    zero = fmpq_mat([[0]])
    one = fmpq_mat([[1]])
    loop = LateLoop(-1 * one, one, one, zero, ((F(1), fmpq(1, 2) * one, zero),), ((zero, zero),), None)
    with working_precision(128):
        (plain, *_), _ = loop.at_any_phase(1 / ball(F(omega)), [])
        assert plain[0, 0].overlaps(1 / (acb(0, omega) + 1 - acb(wait) / 2))


def test_a_late_loop_at_rest_has_the_determinants_of_the_axis_at_0():
    loop = replace(LATE, pace=None)
    with working_precision(128):
        zero = acb_series([acb(0), acb(1)])
        for border in (None, (0, 1), (1, 0)):
            assert loop.determinant(zero, border)[0].overlaps(acb(arb(loop.at_rest(border))))


def _form(h=(), plain=(), turned=(), kinds=("", ""), pairs=(None, None), width=1, theta=0, rate=F(0)):
    """Whether the form of two channels is positive, entries (i, j): value given of H with and without dead time."""

    def side(entries):
        return acb_mat([[acb(dict(entries).get((i, j), 0)) for j in range(2)] for i in range(2)])

    weight = [F(int(pair is None)) for pair in pairs]
    known = [pieces._Channel(kind, F(width), w, F(theta), rate) for kind, w in zip(kinds, weight, strict=True)]
    with working_precision(64):
        return pieces._above([(side(plain), side(())), (side(h), side(turned))], known, pairs, arb(0))


SLOW, FREE, LAG = ("slow", ""), ("free", ""), ("delay", "")
ONE, HALF = ((F(1), F(0)), None), ((F(0), F(1)), None)


@pytest.mark.parametrize(
    ("given", "limit"),
    [
        (lambda v: {"h": [((0, 0), v)]}, 1),  # 2 (1 - |h|)
        (lambda v: {"plain": [((0, 0), -v)]}, 1),
        (lambda v: {"h": [((0, 1), v)]}, 2),  # 4 > |h|^2
        (lambda v: {"h": [((1, 0), v)]}, 2),
        (lambda v: {"h": [((0, 1), v), ((1, 0), v)]}, 1),
        (lambda v: {"plain": [((0, 1), v)], "h": [((0, 1), v)]}, 1),
        (lambda v: {"turned": [((0, 0), v)], "theta": F(1, 2)}, 2),
        (lambda v: {"h": [((0, 0), v)], "width": 2}, 0.5),
        (lambda v: {"h": [((0, 0), v)], "kinds": FREE, "pairs": ONE, "width": 2}, 0.5),  # 2 - 4 |h|
        (lambda v: {"h": [((0, 0), v)], "kinds": LAG, "pairs": ONE}, 1),  # 1 - |h|^2
        (lambda v: {"h": [((0, 0), v)], "kinds": SLOW, "pairs": ONE, "rate": F(1, 2)}, 0.5**0.5),  # 1 - 2 |h|^2
        (lambda v: {"h": [((0, 0), v)], "kinds": SLOW, "pairs": HALF, "width": 2}, 0.5),  # 1 - 2 |h|
        (lambda v: {"turned": [((0, 0), v)], "kinds": SLOW, "pairs": HALF, "width": 2}, 0.5),  # 1 - 4 |s h|^2
    ],
)
def test_the_form_whatever_the_phases_is_sharp(given, limit):
    if "turned" in given(1) and "kinds" in given(1):  # |s h| is looked at where |h| is not 0
        assert _form(**given(0.9 * limit))
    assert _form(**given(0.99 * limit))
    assert not _form(**given(1.01 * limit))


def test_far_out_a_polynomial_is_read_from_its_highest_power():
    u, p = fmpq(1, 3), fmpq_poly([2, 3, 5])
    s = acb(0, 1) / acb(arb(u))  # u^2 p(i/u)
    value = (acb(2) + 3 * s + 5 * s * s) * arb(u) ** 2
    found = pieces._value(pieces._reversed(p, 2), acb(arb(u)))
    assert found.overlaps(value)
    assert pieces._value(pieces._reversed(p, 3), acb(arb(u))).overlaps(value * arb(u))


def test_a_loop_whose_response_is_not_known_has_no_form():
    unknown = SimpleNamespace(response=lambda _s: None)
    loop = pieces._Loop([acb(1)], [[[acb(0)]]], [[]], discrete=False, far=False, closed=unknown)
    with working_precision(64):
        assert pieces._series(loop, [], [], acb_series([acb(1), acb(1)])) is None


# Covers: one term U cos(T w) + V w sin(T w) - 2 level (sin(T w/2)/w)^2


@pytest.mark.parametrize("divided", [False, True])
def test_balls_and_series_of_a_term_agree(divided):
    with working_precision(128):
        tau = F(3, 2)
        level = arb(2) if divided else arb(0)
        term = cover._Term(ball(tau), [arb(1), arb(-2)], [arb(3), arb(1)], level)
        w = arb(1) / 3
        x, sine = w * w, (w * ball(tau)).sin()
        exact = (1 - 2 * x) * (w * ball(tau)).cos() + (3 + x) * (sine / w if divided else w * sine)
        exact -= 2 * level * ((w * ball(tau) / 2).sin() / w) ** 2
        assert cover._series([term], arb_series([w, 1]), divided=divided)[0].overlaps(exact)
        if divided:
            assert cover._value([term], w).overlaps(exact)
        wide, middle = cover._bound([term], F(0) if divided else F(1, 4), F(1), divided=divided)
        assert middle.contains(middle.mid())
        assert wide.overlaps(exact)
        beside, _ = cover._bound([term], F(0), F(1, 100), divided=divided)
        assert abs(beside - (1 + (3 * ball(tau) - level * ball(tau) ** 2 / 2 if divided else 0))) < arb(0.01)


# cos(8 w) on [0, pi/4] has every value; odd powers of the distance from the middle have both signs
def test_taylors_formula_holds_at_both_ends():
    with working_precision(128):
        term = cover._Term(ball(F(8)), [arb(1)], [], arb(0))
        for low, high in ((F(0), F(1, 4)), (F(1, 8), F(3, 8)), (F(1, 4), F(1, 2))):
            wide, _ = cover._bound([term], low, high, divided=False)
            for k in range(9):
                assert wide.overlaps((8 * ball(low + (high - low) * k / 8)).cos())


# Roots beside the axis


@pytest.mark.parametrize("sign", [1, -1])
def test_roots_far_nearer_to_the_axis_than_the_first_precision_are_counted(sign):
    eps = fmpq(1, 2**200)
    near = (fmpq_poly([-sign * eps, 1])) ** 2 + 1
    counts = half_plane_counts(near)
    assert (counts.left, counts.axis, counts.right) == ((0, 0, 2) if sign > 0 else (2, 0, 0))
    beside = (fmpq_poly([-1, 1])) ** 2 + sign * eps  # 1 +- i eps^(1/2), or 1 +- eps^(1/2)
    assert len(positive_roots(beside)) == (0 if sign > 0 else 2)


@pytest.mark.parametrize(
    ("p", "holds"), [([], True), ([1], True), ([-1], False), ([0, 1], False), ([0, 0, 1], True), ([1, -1], True)]
)
def test_what_is_nonnegative_on_the_circle(p, holds):  # p(c) for c in [-1, 1]
    assert nonnegative_on_circle(fmpq_poly(p)) is holds


@pytest.mark.parametrize("rate", ["1/2", None])
def test_an_all_pass_has_modulus_one(rate):
    # -a + (1 - a^2)/(z - a) = (1 - a z)/(z - a), at z = 3 of a = 1/2: -1/5
    one = replace(PLAIN, operator=SCALAR, lower=F(-1), upper=F(1), time_varying=False)
    plant = asked([[0]], [[1]], [[1]], [[0]], one, discrete=True)
    parts = [([0], [(F(1), None)], [(F(1), None if rate is None else F(rate))])]
    A = members._closed(plant, [F(0)], parts)[0]
    factor = fmpq(1) if rate is None else fmpq(-1, 5)
    d = fmpq_poly([0, 1]) if rate is None else fmpq_poly([0, fmpq(-1, 2), 1])
    value = d(fmpq(3)) * (1 + factor / 3)  # the characteristic polynomial is that of 1 + H W, times those of both
    assert A.charpoly()(fmpq(3)) == value


# Multipliers


@pytest.mark.parametrize(("c", "holds"), [(-7, True), (-9, False), (F(9, 10), True), (F(11, 10), False)])
def test_the_real_part_of_a_double_lag_is_least_at_minus_an_eighth(c, holds):
    # Re (1 + i t)^-2 = (1 - x)/(1 + x)^2, x = t^2: 1 at 0 and -1/8 at 3
    assert frequencies._has_real_part(F(1), [(F(c), F(3), 2)]) is holds


def test_kernels_beside_integrators_are_integrated():
    # (h^n - 1)/s for h = a/(a + s): -c times that, from a residue R; at s = 3 of a = 2: h = 2/5
    chains = [
        frequencies.Chain(0, F(2), True, {2: [(1, F(5))], 1: [(0, F(1))]}),
        frequencies.Chain(1, F(4), False, {2: [(0, F(7))]}),
    ]
    given = frequencies.Multiplier([[F(0)] * 2] * 2, [F(0)] * 2, chains, frozenset())
    residue = [[fmpq(1), fmpq(2)], [fmpq(3), fmpq(4)]]
    found = at((*frequencies._integrated(given, residue), fmpq_mat(2, 2)), fmpq(3))
    lag, lead = fmpq(2, 5), fmpq(-4, -4 + 3)  # of -a in the place of a
    into = {0: (lag, fmpq(1), fmpq(5)), 1: (lead, fmpq(0), fmpq(7))}
    first = [-(into[0][0] - 1) / 3 * v for v in residue[0]]
    second = [-(lead**2 - 1) / 3 * 7 * v for v in residue[1]]
    assert [found[0, k] for k in range(2)] == [a + b for a, b in zip(first, second, strict=True)]
    assert [found[1, k] for k in range(2)] == [-(lag**2 - 1) / 3 * 5 * v for v in residue[0]]
    alone = frequencies.Multiplier([[F(1)]], [F(0)], [frequencies.Chain(0, F(2), True, {1: [(0, F(1))]})], frozenset())
    assert frequencies._integrated(alone, [[fmpq(1)]]) == tuple(fmpq_mat([[v]]) for v in (-2, 2, fmpq(1, 2)))


def test_an_operator_has_one_multiplier_for_all_of_its_channels():
    def kernels(*coefficients):
        return [
            {"channels": [i, i], "coefficient": c, "rate": "1", "order": 1, "side": side}
            for i, c in enumerate(coefficients, start=1)
            for side in ("causal", "anticausal")
        ]

    value = {"gamma": [["1", "0"], ["0", "1"]], "theta": ["0", "0"], "kernels": kernels("1/4", "1/4")}
    given = [False] * 2, (0, 0), [False] * 2, [([0, 1], False)]
    frequencies.read_multiplier("matrix-zames-falb", value, *given)
    with pytest.raises(NotShown, match="several multipliers"):
        frequencies.read_multiplier("matrix-zames-falb", value | {"kernels": kernels("1/4", "1/8")}, *given)


@pytest.mark.parametrize("rate", ["0", "-1"])
def test_a_kernel_decays(rate):
    kernel = {"coefficient": "1/2", "rate": "1", "order": 1, "side": "causal"}
    assert read_kernels({"theta": "0", "kernels": [kernel]})[1] == [(F(1, 2), (F(1), 1, 1))]
    with pytest.raises(NotShown, match="rate of a kernel"):
        read_kernels({"theta": "0", "kernels": [kernel | {"rate": rate}]})


@pytest.mark.parametrize(
    ("coefficients", "strict", "masses", "legal"),
    [
        (["1/2", "1/2"], False, None, True),
        (["1/2", "1/2"], True, None, False),
        (["1/2", "1/3"], True, None, True),
        (["1/2", "2/3"], False, None, False),
        (["1/2", "-1/3"], False, None, False),
        (["1/2"], False, ["9/10", "11/10"], False),
        (["1/2"], False, ["9/10", "1"], True),
    ],
)
def test_how_large_a_multiplier_may_be(coefficients, strict, masses, legal):
    numbers = [F(c) for c in coefficients], Claim.of(PLAIN)
    weighted = None if masses is None else [F(v) for v in masses]
    if legal:
        require_legal(*numbers, strict=strict, masses=weighted)
        return
    with pytest.raises(NotShown):
        require_legal(*numbers, strict=strict, masses=weighted)


def test_the_masses_of_a_kernel_at_a_rate():
    # int |c| h(t) e^(-+ a t) = |c| (b/(b +- a))^n; theta takes theta a from one and gives it to the other
    one, other = kernel_weights(F(1), [(F(-1, 2), (F(2), 1, 1))], F(1))
    assert (one, other) == (F(-2, 3), F(2))
    assert kernel_weights(F(3), [], F(2)) == [-6, 6]
    one, other = kernel_weights(F(0), [(F(1, 2), (F(2), 2, -1))], F(1))
    assert (one, other) == (F(2), F(2, 9))


@pytest.mark.parametrize("turn", [F(1, 3), F(-1, 3), F(2)])
@pytest.mark.parametrize("sloped", [False, True])
def test_popovs_terms_at_a_rate_are_the_least_there_are(turn, sloped):
    # 2 turn (2 int psi - v) for psi(1) = v: 2 int psi is 0 to w, and with slopes in [0, w] v^2/w to 2 v - v^2/w
    w = F(3)
    p, q, r = popov_terms(turn, w, sloped=sloped)
    for v in (F(0), F(1), F(2), F(3)):
        ends = (v * v / w, 2 * v - v * v / w) if sloped else (F(0), w)
        assert p + 2 * q * v + r * v * v == max(2 * turn * (twice - v) for twice in ends)


@pytest.mark.parametrize(
    ("ratio", "size"), [(F(10), F(3, 2)), (F(1, 10), F(3, 2)), (F(10), F(2, 3)), (F(1, 10), F(3)), (F(9), F(3))]
)
def test_between_which_powers_a_ratio_lies(ratio, size):
    k = _power(ratio, size)
    low, high = sorted((size**k, size ** (k + (1 if size > 1 else -1))))
    assert low <= ratio < high


def test_in_samples_a_varying_delay_sees_how_sigma_changes():
    # (1 - 1/z) H/(1 + H) with H = k/z: (1 - 1/z) k/(z + k), which is 2/39 at z = 3 for k = 1/4
    late = replace(PLAIN, operator="varying delay", lower=F(-1), upper=F(1), slope=None, time_varying=True)
    sides = [[0, 0], [0, 0]], [[1, 0], [0, fmpq(1, 4)]], [[1, 0], [0, 1]], [[0, 0], [0, 0]]
    found = without_delays(asked(*sides, PLAIN, late, discrete=True))
    assert at((found.A, found.B, found.C, found.D), fmpq(3)) == fmpq_mat([[fmpq(1, 3), 0], [0, fmpq(2, 39)]])
    assert found.nonlinearities[1].ends == (F(-1), F(1))


# Windows


@pytest.mark.parametrize(
    "kinds", [("monotone", "monotone"), ("monotone", "sector"), ("sector", "monotone"), ("rising", "odd")]
)
def test_a_channel_has_no_two_forms_about_different_bounds(kinds):
    given = [{"kind": kind, "channels": [1], "rows": [["1"]]} for kind in kinds]
    one = replace(PLAIN, odd=True)
    plant = asked([[0]], [[1]], [[1]], [[0]], one, discrete=True)
    for alone in given:
        read_forms([alone], plant, 1, over_time=False)
    with pytest.raises(NotShown, match="stands twice"):
        read_forms(given, plant, 1, over_time=False)


def test_copositive_in_every_face():
    assert strictly_copositive(fmpq_mat([[1, 2], [2, 1]]))
    assert not strictly_copositive(fmpq_mat([[1, -1], [-1, fmpq(9, 10)]]))
    assert not strictly_copositive(fmpq_mat([[-1]]))
    low, high = fmpq(-49, 100), fmpq(-51, 100)  # all entries 1 beside -1/2: (1, 1, 1) gives 0
    assert strictly_copositive(fmpq_mat([[1 if i == j else low for j in range(3)] for i in range(3)]))
    assert not strictly_copositive(fmpq_mat([[1 if i == j else high for j in range(3)] for i in range(3)]))


# Shifts


def test_a_shifted_loop_is_that_of_its_gains():
    sides = [[-1, 1], [0, -2]], [[1, 0], [2, 1]], [[1, 0], [1, 1]], [[0, fmpq(1, 2)], [fmpq(1, 3), 0]]
    plant, lower = asked(*sides), fmpq_mat([[2, 0], [0, -1]])
    H = at((plant.A, plant.B, plant.C, plant.D), fmpq(3))
    one = fmpq_mat([[1, 0], [0, 1]])
    assert at(shifted_by(plant, [(F(2), F(3)), (F(-1), F(0))]), fmpq(3)) == (one + H * lower).inv() * H
    state = States(A=((F(-1), F(1)), (F(0), F(-2))), b=(F(1), F(2)), c=(F(1), F(0)), d=F(1, 2))
    rational = SimpleNamespace(states=state)
    h = at((plant.A, fmpq_mat([[1], [2]]), fmpq_mat([[1, 0]]), fmpq_mat([[fmpq(1, 2)]])), fmpq(3))[0, 0]
    for shifted in matrix._shifted(rational, F(2)):
        A, b, c = fmpq_mat([[fmpq(v.numerator, v.denominator) for v in row] for row in shifted.A]), shifted.b, shifted.c
        B, C = (
            fmpq_mat([[fmpq(v.numerator, v.denominator)] for v in b]),
            fmpq_mat([[fmpq(v.numerator, v.denominator) for v in c]]),
        )
        direct = fmpq(shifted.direct.numerator, shifted.direct.denominator)
        form = at((A, B, C, fmpq_mat(1, 1)), fmpq(3))[0, 0]
        assert direct + form == h / (1 + 2 * h)


@pytest.mark.parametrize(
    ("low", "high", "holds"), [(F(1), F(19, 10), True), (F(1), F(21, 10), False), (F(-1), F(19, 10), True)]
)
def test_sigma_less_half_of_phi_has_one_solution_for_slopes_below_two(low, high, holds):
    one = replace(PLAIN, lower=low, upper=high, slope=(low, high))
    plant = asked([[-1]], [[1]], [[1]], [[fmpq(-1, 2)]], one)
    if holds:
        require_one_solution(plant, [(low, high)])
        return
    with pytest.raises(NotShown):
        require_one_solution(plant, [(low, high)])


def test_the_form_of_a_loop_that_is_an_integrator_alone():
    state = matrix.State(A=(), b=(), c=(), direct=F(0), rho=F(2))
    with working_precision(64):
        nothing = arb_mat(0, 0)
        assert matrix._form(state, nothing, F(1, 2), F(3), discrete=False)[0, 0] == 13  # 2/w + 2 theta rho
        assert matrix._form(state, nothing, F(1, 2), F(0), discrete=True)[0, 0] == -1  # 2/w - rho


@pytest.mark.parametrize(("where", "definite"), [(None, True), (0, False), (6, False)])
def test_every_part_of_a_large_matrix_has_to_be_definite(where, definite):
    M = arb_mat([[(-1 if i == where else 1) if i == j else 0 for j in range(7)] for i in range(7)])
    assert matrix.positive_definite(M) is definite


def test_the_states_of_a_rod():
    # c = Z = s = 2, d = 1/2, a = (1/2 - 2)/(1/2 + 2) = -3/5: y_1' = -s (a y_2 + y_1), y_2' = s (y_1 - y_2 + 2 d mu)
    rod = RodData(E=F(4), rho=F(1), length=F(1), area=F(1), k=F(1, 2), cells=1)
    found = rod.states().states
    assert ((-2, F(6, 5), 0), (2, -2, 0), (1, 0, 0)) == found.A
    assert (found.b, found.c, found.d) == ((0, 2, F(1, 2)), (0, 0, 1), 0)


# Parameters


def test_one_plant_of_a_box_has_its_numerator():
    terms = [((0,), ["0", "1", "2"]), ((1,), ["0", "3", "0"])]
    plants = boxes.Plants(
        discrete=False,
        box=((F(0), F(2)),),
        degrees=(1,),
        terms=tuple((e, [F(v) for v in top], [F(1), F(0), F(5)] if e == (0,) else [F(0)] * 3) for e, top in terms),
    )
    assert plants.at([F(2)])["numerator"] == ["7", "2"]
    assert plants.at([F(2)])["denominator"] == ["1", "0", "5"]
    assert plants.at([F(-1, 3)])["numerator"] == ["2"]


# Members


@pytest.mark.parametrize(
    ("rate", "discrete"), [("1", True), ("-1", True), ("3/2", True), ("0", False), ("-1/2", False)]
)
def test_an_all_pass_is_stable(rate, discrete):
    assert members._pairs([["1", "1/2"]], 1, discrete=discrete) == [(F(1), F(1, 2))]
    with pytest.raises(NotShown, match="not stable"):
        members._pairs([["1", rate]], 1, discrete=discrete)


def test_the_response_of_a_member_in_samples():
    # z = (1 - t^2 + 2 i t)/(1 + t^2) = 3/5 + 4/5 i at t = 1/2: 1/(z - 1/2) = 1/(1/10 + 4/5 i) = 2/13 - 16/13 i
    loop = tuple(fmpq_mat([[v]]) for v in (fmpq(1, 2), 1, 1, 0))
    assert members._response(loop, [[F(1), F(0)]], F(1, 2), discrete=True) == [fmpq(2, 13), fmpq(-16, 13)]
    assert members._response(loop, [[F(1), F(0)]], None, discrete=True) == [fmpq(-2, 3), 0]
    # i t = 2 i: 1/(2 i - 1/2) = (-1/2 - 2 i)/(17/4)
    assert members._response(loop, [[F(1), F(0)]], F(2), discrete=False) == [fmpq(-2, 17), fmpq(-8, 17)]


def test_each_disturbance_enters_by_its_own_channel():
    two = replace(PLAIN, operator="performance", lower=F(-1), upper=F(1), time_varying=True)
    plant = asked([[-1, 0], [0, -2]], [[1, 0], [0, 1]], [[1, 0], [0, 1]], [[0, 0], [0, 0]], two, two, repeated=(0, 0))
    A, B, C, D, own = members._closed(plant, [F(0), F(0)], [])
    assert own == [0, 1]
    assert (A, B, C, D) == (plant.A, plant.B, plant.C, plant.D)


# Nonlinearities and curves


def test_a_double_root_inside_is_seen():
    assert not positive_inside(fmpq_poly([1, -2, 1]), F(0), F(2))
    assert positive_inside(fmpq_poly([1, -2, 1]), F(1), F(2))
    assert positive_inside(fmpq_poly([2, -2, 1]), F(0), F(2))


@pytest.mark.parametrize(("limits", "clip"), [((-1, 2), (F(0), F(1), F(-1), F(2))), ((1, 2), None), ((-2, -1), None)])
def test_limits_lie_on_both_sides_of_0(limits, clip):
    flat = [fmpq_poly([v]) for v in limits]
    assert Curved(cuts=(F(-1), F(2)), pieces=(flat[0], fmpq_poly([0, 1]), flat[1])).clip == clip


@pytest.mark.parametrize(
    ("slopes", "fits"), [((0, F(1, 2), 0), True), ((0, F(3, 2), 0), False), ((F(3, 2), F(1, 2), 0), False)]
)
def test_with_a_direct_term_every_piece_has_a_solution(slopes, fits):
    k = F(slopes[1])
    phi = Graph((F(-1), F(0), F(1)), (-k, F(0), k), (F(slopes[0]), k, k, F(slopes[2])))
    state = States(A=((F(-1),),), b=(F(1),), c=(F(1),), d=F(-1))
    if fits:
        assert len(stays_of(state, phi, [0, 1], half=False)) == 2
        return
    with pytest.raises(NotShown, match="slope is not positive"):
        stays_of(state, phi, [0, 1], half=False)


@pytest.mark.parametrize(
    ("change", "member"),
    [({}, True), ({"upper": F(1)}, False), ({"slope": (F(0), F(1))}, False), ({"slope": (F(1, 2), F(2))}, False)],
)
def test_tanh_has_all_of_its_bounds_in_the_class(change, member):
    one = replace(PLAIN, **({"upper": F(2), "slope": (F(0), F(2))} | change))
    if member:
        require_member({"kind": "tanh", "height": "2", "rate": "1"}, one)
        return
    with pytest.raises(NotShown, match="not in the class"):
        require_member({"kind": "tanh", "height": "2", "rate": "1"}, one)


# y = sin t is below -1/2 between 7 pi/6 and 11 pi/6 = 5.7596, and rises there
@pytest.mark.parametrize(("duration", "stays"), [(F(18, 5), True), (F(23, 4), False)])
def test_a_solution_leaves_in_its_direction(duration, stays):
    G = ((F(0), F(1), F(0)), (F(-1), F(0), F(0)), (F(0), F(0), F(0)))
    one = Watched(row=(F(1), F(0), F(0)), low=F(-1, 2), high=None, enters=0, leaves=-1)
    with working_precision(128):
        equations = _Equations(2, [Stay(G=G, entry=one.row, watched=(one,))], half=False)
        assert equations.on_its_piece(0, one, arb_mat([[0], [1], [1]]), ball(duration)) is stays


def flow(rows, *graphs, seen=((0, 1),)):
    m = len(graphs)
    Y = fmpq_mat([[*row, *[0] * m] for row in seen])
    return Loop(F=fmpq_mat(rows), Y=Y, D=fmpq_mat(m, m), discrete=False, graphs=graphs)


ZERO, RAMP = Curved(cuts=(F(1, 2),), pieces=(fmpq_poly([]),) * 2), fmpq_poly([-2, 4])
BENT = Curved(cuts=(F(1, 2),), pieces=(fmpq_poly([]), RAMP))  # 0, and from 1/2 on 4 (y - 1/2)
UP = Arc(corners=((fmpq(1), fmpq(-1)), (fmpq(1), fmpq(1))))  # x_1 = 1, upwards: to its left x_1 falls


@pytest.mark.parametrize(("graphs", "crossed"), [((ZERO, ZERO), True), ((BENT, ZERO), False), ((ZERO, BENT), False)])
def test_an_edge_is_crossed_on_each_piece(graphs, crossed):
    loop = flow([[-1, 0, 1, 1], [0, -1, 0, 0]], *graphs, seen=((0, 1), (0, 1)))  # x_1' = -x_1 + phi_1 + phi_2
    if crossed:
        require_crossed(loop, [UP], 1)
        return
    with pytest.raises(NotShown, match="not crossed"):
        require_crossed(loop, [UP], 1)


SQUARE = [["1", "0"], ["0", "1"], ["-1", "0"], ["0", "-1"], ["1/2", "0"]]


@pytest.mark.parametrize(
    ("change", "goes"),
    [
        ({}, True),
        ({4: ["1/2", "1/10"]}, False),  # not on the ray of the start
        ({2: ["1/10", "1"]}, False),  # back
        ({2: ["1/10", "1"], 3: ["-1", "0"], 4: ["0", "-1"], 5: ["1/2", "0"]}, False),
    ],
)
def test_a_curve_turns_in_one_sense_and_ends_on_its_ray(change, goes):
    rows = [list(row) for row in SQUARE]
    for k, row in sorted(change.items()):
        rows[k : k + 1] = [row]
    if goes:
        assert curve_of(flow([[-1, 0, 1], [0, -1, 0]], ZERO), rows).factor == F(1, 2)
        return
    with pytest.raises(NotShown):
        curve_of(flow([[-1, 0, 1], [0, -1, 0]], ZERO), rows)
