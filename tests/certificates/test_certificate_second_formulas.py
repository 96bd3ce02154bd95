"""Formulas of the second checker against another computation, and bounds that are sharp from both sides."""

from dataclasses import replace
from fractions import Fraction as F
from itertools import product
from types import SimpleNamespace

import pytest
from flint import acb, acb_series, arb, fmpq, fmpq_mat, fmpq_poly
from second_plants import PLAIN, asked, assert_accepted_if, at, unit

from lure.analysis.certificates.second import (
    axis,
    cover,
    dead_times,
    members,
    memory,
    parts,
    pieces,
    rays,
    regions,
    theorems,
)
from lure.analysis.certificates.second.classes import SCALAR
from lure.analysis.certificates.second.curves import Arc, curve_of, require_crossed, require_one_equilibrium
from lure.analysis.certificates.second.delays import refuted_by_delay, without_delays
from lure.analysis.certificates.second.graphs import Graph as Curved
from lure.analysis.certificates.second.graphs import Loop
from lure.analysis.certificates.second.late_loops import LateLoop
from lure.analysis.certificates.second.numerics import (
    ball,
    half_plane_counts,
    nonnegative_on_circle,
    positive_on_circle,
    right_zeros,
    taylor,
    to_fmpq,
    working_precision,
)
from lure.analysis.certificates.second.reading import NotShown
from lure.analysis.certificates.second.systems import Delayed, Rational, Shifted, States

TIMID = replace(PLAIN, slope=None, lower=F(-1), time_varying=True)


# Bounds on intervals and on half-lines


# (x - 1)^k for x = omega^2, and (t - 1)^k, about 1: each power of the distance has a sign of its own
@pytest.mark.parametrize("k", range(12))
def test_taylors_formula_takes_each_power_as_it_is(k):
    power, r = fmpq_poly([-1, 1]) ** k, F(1, 4)
    with working_precision(128):
        term = cover._Term(arb(0), [arb(c) for c in power.coeffs()], [], arb(0))
        squares, _ = cover._bound([term], 1 - r, 1 + r, divided=False)
        here, wide = (acb_series([acb(t - 1), 1]) ** k for t in (arb(1), ball(1 - r).union(ball(1 + r))))
        plain = taylor(here, wide, ball(r))
        for end in (1 - r, F(1), 1 + r):
            assert squares.overlaps(ball((end * end - 1) ** k))
            assert plain.overlaps(acb(ball((end - 1) ** k)))


# 64 (x - 1)^2 + c + e cos(omega T) + o omega sin(omega T), least at omega = 1 for the T that is worst: c - |(e, o)|
@pytest.mark.parametrize(
    ("e", "o", "first", "last", "least"),
    [
        (1, 0, 2, 4, 1),  # T = pi
        (1, 0, 2, 3, F(98999, 10**5)),  # falls until -cos 3
        (1, 0, 4, 6, F(65364, 10**5)),  # rises from -cos 4
        (1, 0, 4, 11, 1),  # 3 pi; rises at both ends
        (0, 1, 4, F(11, 2), 1),  # 3 pi/2
        (0, -1, 1, 2, 1),
        (1, 1, F(16, 5), F(23, 5), F(141421, 10**5)),  # 5 pi/4
        (1, -1, 1, 3, F(141421, 10**5)),  # 3 pi/4
    ],
)
def test_whatever_the_dead_time_between_two_is(e, o, first, last, least):
    for share, holds in ((F(102, 100), True), (F(97, 100), False)):
        plain = 64 * fmpq_poly([-1, 1]) ** 2 + to_fmpq(least * share)
        with assert_accepted_if(holds):
            cover.require_whatever_delay(
                (plain, fmpq_poly([e]), fmpq_poly([o])), (F(first), F(last)), 2, critical=False
            )


# exp(-s T)/(s (s + 1)) has the real part -(cos(omega T) + sin(omega T)/omega)/(1 + x), at least -(1 + T)
@pytest.mark.parametrize(("first", "last"), [(1, 2), (F(1, 2), 2), (2, 2), (0, 2)])
def test_whatever_the_dead_time_beside_a_pole_at_0_is(first, last):
    for ease, holds in ((F(303, 100), True), (F(297, 100), False)):
        parts = fmpq_poly([0, 1, 1]) * to_fmpq(ease), fmpq_poly([0, -1]), fmpq_poly([-1])
        with assert_accepted_if(holds):
            cover.require_whatever_delay(parts, (F(first), F(last)), 2, critical=True)


# U + A cos + B omega sin from a start on: U^2 against the sizes, which are in proportion in the second row
@pytest.mark.parametrize(
    ("terms", "full", "start", "need", "holds"),
    [
        ({0: ([0, 1], []), 1: ([], [5])}, 1, F(51, 10), "positive", True),
        ({0: ([0, 1], []), 1: ([], [5])}, 1, F(49, 10), "positive", False),
        ({0: ([0, 1], []), 1: ([], [3]), 2: ([], [2])}, 1, F(51, 10), "positive", True),
        ({0: ([0, 1], []), 1: ([], [3]), 2: ([], [2])}, 1, F(49, 10), "positive", False),
        ({0: ([0, 1], []), 1: ([3], [4])}, 1, F(5), "positive", True),  # x^2 > 9 + 16 x
        ({0: ([0, 1], []), 1: ([3], [4])}, 1, F(4), "positive", False),
        ({0: ([0, -1], []), 1: ([1], [])}, 1, F(2), "positive", False),
        ({0: ([0, 1], []), 1: ([1], [])}, 2, F(2), "positive", False),  # falls short of its degree
        ({0: ([0, 1], []), 1: ([1], [])}, 2, F(2), "nonnegative", True),
        ({0: ([0, 1], []), 1: ([-1, 1], [1])}, 1, F(2), "positive", False),  # U^2 - A^2 - x B^2 = x - 1
        ({0: ([0, 1], []), 1: ([-1, 1], [1])}, 1, F(2), "nonnegative", True),
    ],
)
def test_far_out_what_comes_late_counts_by_its_size(terms, full, start, need, holds):
    sides = {F(tau): (fmpq_poly(U), fmpq_poly(V)) for tau, (U, V) in terms.items()}
    curve = axis.Curve(terms=sides, full=full, divided=False)
    assert cover._tail(curve, start, need) is holds


@pytest.mark.parametrize(("first", "late", "holds"), [(1, -1, True), (-1, 1, False), (-8, 8, False), (0, 0.75, False)])
def test_far_out_what_was_divided_counts_with_what_was_left_at_0(first, late, holds):
    # x U + level = x/2 + level against |level|, from x = 1 on
    terms = {F(0): (fmpq_poly([fmpq(1, 2)]), fmpq_poly([])), F(1): (fmpq_poly([]), fmpq_poly([]))}
    level = {F(tau): to_fmpq(F(v)) for tau, v in ((0, first), (1, late)) if v}
    curve = axis.Curve(terms=terms, full=0, divided=True, level=level)
    assert cover._tail(curve, F(1), "positive") is holds


# F at one frequency against Re[M (n conj(d) + |d|^2/w) + i omega theta n conj(d)]
@pytest.mark.parametrize("delayed", [False, True])
def test_the_inequality_on_the_axis_is_that_of_complex_numbers(delayed):
    n = ((F(0), fmpq_poly([1, 2])), (F(3, 4), fmpq_poly([fmpq(1, 3)])))
    back = ((F(1, 2), fmpq_poly([fmpq(1, 5), fmpq(1, 7)])), (F(2), fmpq_poly([fmpq(1, 9)])))
    block = Shifted(
        n=n if delayed else n[:1], d=fmpq_poly([3, 2, 1]), discrete=False, plant=None, case="stable",
        back=back if delayed else (),
    )  # fmt: skip
    late = [(F(1, 6), F(5, 4)), (F(1, 8), F(5, 4))]
    filters = [(F(1, 3), (F(2), 2, 1)), (F(-1, 4), (F(2), 1, -1)), (F(1, 5), (F(3), 1, 1))]
    multiplier = axis.kernels(F(2, 5), [*filters, *(late if delayed else [])])
    found = axis.curve(block, multiplier, F(1, 4))
    with working_precision(128):
        w = ball(F(7, 5))
        s, x = acb(0, w), w * w

        def value(p):
            return sum((acb(arb(c)) * s**k for k, c in enumerate(p.coeffs())), acb(0))

        def wait(tau):
            return (-s * ball(tau)).exp()

        top = sum((value(p) * wait(tau) for tau, p in block.n), acb(0))
        bottom = value(block.d) + sum((value(p) * wait(tau) for tau, p in block.back), acb(0))
        M = acb(1) - sum((ball(c) * (ball(a) / (ball(a) + side * s)) ** k for c, (a, k, side) in filters), acb(0))
        M -= sum((ball(c) * wait(tau) for c, tau in late if delayed), acb(0))
        cross, square = top * bottom.conjugate(), abs(bottom) ** 2
        exact = (M * (cross + square / 4) + s * ball(F(2, 5)) * cross).real * arb(multiplier.below(fmpq(49, 25)))
        total = arb(0)
        for tau, (U, V) in found.terms.items():
            angle = w * ball(tau)
            total += arb(U(fmpq(49, 25))) * angle.cos() + w * arb(V(fmpq(49, 25))) * angle.sin()
        assert total.overlaps(exact)
        assert (total - exact).abs_upper() < arb(2) ** -80 * (1 + x)
    assert found.full == 2 + 3


# Roots


@pytest.mark.parametrize(
    "factors",
    [
        [[1, 1]],
        [[-1, 1]],
        [[-1, 1], [2, 1]],
        [[1, -1, 1]],
        [[1, 1, 1], [-3, 1]],
        [[1, -1, 1], [-1, 1]],
        [[1, -1, 1], [4, -1, 1], [1, 1]],
        [[1, -1, 1], [9, -2, 1], [-1, 1]],
        [[101, -2, 100], [1, 1]],
        [[101, 2, 100], [-1, 1]],
    ],
)
def test_zeros_on_the_right_are_counted_by_the_angle(factors):
    chi = fmpq_poly([1])
    for factor in factors:
        chi *= fmpq_poly(factor)
    n = chi.degree()
    if chi[n] < 0:
        chi = -chi

    def closer(a, b):
        omega = ball(a).union(ball(b))
        return sum((arb(c) * omega**k * acb(0, 1) ** ((k - n) % 4) for k, c in enumerate(chi.coeffs())), acb(0))

    def turn(a, b):
        if a == 0:
            return closer(a, b)
        inverse = arb(0).union(1 / ball(b)) if a is None else 1 / ball(a).union(ball(b))
        return sum((arb(c) * (inverse / acb(0, 1)) ** (n - k) for k, c in enumerate(chi.coeffs())), acb(0)) / arb(
            chi[n]
        )

    with working_precision(96):
        assert right_zeros(n, turn, closer) == half_plane_counts(chi).right


def test_roots_that_lie_opposite_and_roots_beside_an_end_are_counted():
    for roots, right in (([1, -1], 1), ([1, -1, -2], 1), ([1, -1, 3, -3], 2), ([1, 1, -1, -1, 0], 2), ([-1, -1], 0)):
        p = fmpq_poly([1])
        for root in roots:
            p *= fmpq_poly([-root, 1])
        assert half_plane_counts(p).right == right
    near = fmpq_poly([1 - fmpq(1, 2**200), -1])  # inside, at either end
    for p in (near, near(fmpq_poly([0, -1]))):
        assert nonnegative_on_circle(p**2)
        assert not positive_on_circle(p**2)
        assert not nonnegative_on_circle(p)


def test_far_out_what_comes_back_late_has_any_phase():
    loop = Delayed(terms=(), d=fmpq_poly([2, 1]), back=((F(1), fmpq_poly([5])), (F(2), fmpq_poly([3]))))
    with working_precision(64):
        far = loop.turn(None, F(8))
        for k in range(16):
            s = acb(0, ball(8 + F(k, 2)))
            assert far.overlaps((s + 2 + 5 * (-s).exp() + 3 * (-2 * s).exp()) / s)


# Crossings


# s + g_1 + g_2 exp(-s) = 0 at i w: g_1 = -g_2 cos w, w = g_2 sin w; at w = 2 the gains 0.9153 and 2.1995
def crossing(first, second, band):
    late = ((F(1), fmpq_mat([[0], [1]])),)
    plant = asked([[0]], [[1, 1]], [[1], [0]], [[0, 0]] * 2, *[replace(PLAIN, upper=F(4), slope=None)] * 2, late=late)
    proof = {
        "method": "late-crossing",
        "gains": [[str(v) for v in row] for row in (first, second)],
        "frequencies": [str(v) for v in band],
        "turn": ["0", "1"],
    }
    return dead_times._crossing(SimpleNamespace(proof=proof), plant)


STEEP = F(91531514, 10**8), F(219950034, 10**8)  # -2/tan 2 and 2/sin 2


@pytest.mark.parametrize("moved", [(1, 0), (0, 1), (1, 1), (1, -2)])
def test_a_crossing_lies_inside_its_gains_and_its_frequencies(moved):
    # a box of size 1/1000 about the root is shifted by parts of its size, so that the root is inside or outside
    size = F(1, 1000)
    for by_gain, by_band, holds in (
        *((F(0), F(0), True), (F(2, 5), F(2, 5), True), (F(-2, 5), F(2, 5), True)),
        *((F(2, 5), F(-2, 5), True), (F(-2, 5), F(-2, 5), True)),
        *((F(3, 5), F(a, 5), False) for a in (-2, 0, 2)),
        *((F(-3, 5), F(a, 5), False) for a in (-2, 0, 2)),
        *((F(a, 5), F(3, 5), False) for a in (-2, 0, 2)),
        *((F(a, 5), F(-3, 5), False) for a in (-2, 0, 2)),
    ):
        ends = F(-1, 2), F(1, 2)
        rows = [[g + m * size * (by_gain + end) for g, m in zip(STEEP, moved, strict=True)] for end in ends]
        band = [2 + size * (by_band + end) for end in ends]
        with assert_accepted_if(holds):
            crossing(*rows, band)
    # between frequencies far apart Newton's step from the middle leads elsewhere
    for wide, by_gain, by_band in product(
        (10, 20, 40), (-F(7, 10), -F(11, 20), F(11, 20), F(7, 10)), (-F(2, 5), F(2, 5))
    ):
        rows = [[g + m * F(1, 100) * (by_gain + end) for g, m in zip(STEEP, moved, strict=True)] for end in ends]
        with assert_accepted_if(holds=False):
            crossing(*rows, [2 + wide * F(1, 100) * (by_band + end) for end in ends])


# 1/(s + 1)^3 times g is 1 in size at an angle above -pi for g = 7, below it for g = 9
@pytest.mark.parametrize(
    ("g", "delays", "band", "holds"),
    [
        (7, ("0", "1/10"), ("163/100", "164/100"), True),
        (7, ("1/20", "1/10"), ("163/100", "164/100"), False),  # the second comes too soon
        (7, ("0", "1/25"), ("163/100", "164/100"), False),
        (7, ("0", "1/10"), ("164/100", "165/100"), False),
        (7, ("0", "1/25"), ("8/5", "17/10"), False),  # which at 17/10 alone turns by enough
        (7, ("3/50", "7/50"), ("3/2", "33/20"), False),  # and here at 3/2 alone
        (9, ("-1/10", "1/20"), ("182/100", "183/100"), False),  # only a delay below 0 would do
    ],
)
def test_a_delay_of_the_class_turns_by_what_is_left(g, delays, band, holds):
    late = replace(TIMID, operator="delay", lower=F(-1), upper=F(1), time_varying=False)
    plant = asked([[-1, 0, 0], [1, -1, 0], [0, 1, -1]], [[g], [0], [0]], [[0, 0, 1]], [[0]], late)
    proof = {"method": "delayed-gains", "gains": ["1"], "channel": 1, "delays": list(delays), "frequencies": list(band)}
    with assert_accepted_if(holds):
        refuted_by_delay(SimpleNamespace(proof=proof), plant)


# Delays and members


def test_delays_are_taken_out_as_their_formulas_say():
    h = F(1, 2)
    kinds = {"delay": False, "varying delay": True}
    late = [replace(TIMID, operator=k, lower=F(-1), upper=h, time_varying=v) for k, v in kinds.items()]
    sides = [[-1, 2, 0], [0, -3, 1], [1, 0, -2]], [[1, 0, 2], [0, 1, 1], [1, 1, 0]], unit(3).tolist()
    direct = [[0, 0, fmpq(1, 3)], [0, 0, 0], [0, 0, 0]]
    plant = asked(*sides, direct, *late, PLAIN)
    s = fmpq(3)
    found = without_delays(plant)
    P, E = at((plant.A, plant.B, plant.C, plant.D), s), fmpq_mat([[1, 0, 0], [0, 1, 0], [0, 0, 0]])
    x = s * to_fmpq(h)
    m = (1133 * x**3 + 4751 * x**2 + 10041 * x) / (561 * x**3 + 3183 * x**2 + 8563 * x + 10000)
    seen = fmpq_mat([[m, 0, 0], [0, s, 0], [0, 0, 1]])
    assert at((found.A, found.B, found.C, found.D), s) == seen * (unit(3) + P * E).inv() * P
    assert [one.ends for one in found.nonlinearities] == [(F(-1), F(1)), (-h, h), (F(0), F(1))]
    assert [one.operator for one in found.nonlinearities] == [SCALAR, "any", ""]


@pytest.mark.parametrize("discrete", [False, True])
def test_members_close_the_loop_as_their_formulas_say(discrete):
    operator = replace(TIMID, operator="linear time-invariant", upper=F(2), lower=F(-2))
    seen = replace(TIMID, operator="performance")
    A, B = [[fmpq(-1, 2), fmpq(1, 5)], [0, fmpq(1, 3)]], [[1, 0, 2, 1], [0, 1, 1, -1]]
    C, D = [[1, 2], [0, 1], [1, 0], [1, 1]], [[0, 0, fmpq(1, 3), 0], [0, fmpq(1, 4), 0, 1], [1, 0, 0, 0], [0, 2, 1, 0]]
    plant = asked(A, B, C, D, PLAIN, operator, operator, seen, repeated=(0, 1, 1, 3), discrete=discrete)
    left, right = [(F(1, 3), F(1, 2)), (F(2), None)], [(F(-1, 2), F(1, 4)), (F(1, 5), F(1, 3))]
    found = members._closed(plant, [F(1, 2), F(0), F(0), F(0)], [([1, 2], left, right)])
    s = fmpq(3)

    def passes(c, a):
        a = None if a is None else to_fmpq(a)
        return to_fmpq(c) * (1 if a is None else (1 - a * s) / (s - a) if discrete else (s - a) / (s + a))

    K = fmpq_mat(4, 4)
    K[0, 0] = fmpq(1, 2)
    for i, u in enumerate(left, start=1):
        for j, v in enumerate(right, start=1):
            K[i, j] = passes(*u) * passes(*v)
    P = at((plant.A, plant.B, plant.C, plant.D), s)
    sigma = (unit(4) + P * K).inv() * P
    assert found[4] == [3]
    assert at(found[:4], s)[0, 0] == sigma[3, 3]


# sigma' = -sigma + u_1 + u_2 in both channels: a member u = -c sigma in one of them destabilises for c < -1
@pytest.mark.parametrize(
    ("norm", "left", "right", "gains", "holds"),
    [
        (2, ["-2", "0"], ["1", "0"], "00", True),
        (2, ["-2", "0"], ["2", "0"], "00", False),  # of norm 4
        (2, ["-2", "-1"], ["1", "0"], "00", False),  # of norm 5^(1/2)
        (2, ["-2", "0"], ["1", "1"], "00", False),
        (2, ["-2", "0"], ["1/2", "0"], "00", None),  # 0 is an eigenvalue and no more: a constant solution
        (2, ["-1/4", "0"], ["8", "0"], "00", True),
        (2, ["-2", "0"], ["1", "0"], "10", False),
        (2, ["-2", "0"], ["1", "0"], "01", False),
    ],
)
def test_members_have_the_norm_of_their_class(norm, left, right, gains, holds):
    one = replace(TIMID, operator="linear time-invariant", lower=F(-norm), upper=F(norm))
    plant = asked([[-1]], [[1, 1]], [[1], [1]], [[0, 0]] * 2, one, one, repeated=(0, 0))
    operator = {name: [[c, None] for c in side] for name, side in (("left", left), ("right", right))}
    proof = {"method": "members", "gains": list(gains), "operators": [operator]}
    if holds is None:
        assert members.refuted_by_members(SimpleNamespace(proof=proof), plant) == members.claims.OTHER_EQUILIBRIA
        return
    with assert_accepted_if(holds):
        assert members.refuted_by_members(SimpleNamespace(proof=proof), plant) == members.claims.NO_REST


# 1/(s + 1 + c), c = 1/2 of the operator: 2/3 at rest, 2/(13^(1/2)) at 1
@pytest.mark.parametrize(
    ("omega", "bound", "holds"),
    [("0", "151/100", True), ("0", "149/100", False), ("1", "181/100", True), ("1", "180/100", False)],
)
def test_a_gain_at_a_frequency_is_above_the_bound_or_not(omega, bound, holds):
    one = replace(TIMID, operator="linear time-invariant")
    seen = replace(TIMID, operator="performance", lower=-F(bound), upper=F(bound))
    plant = asked([[-1]], [[1, 1]], [[1], [1]], [[0, 0]] * 2, one, seen)
    operator = {"left": [["1/2", None]], "right": [["1", None]]}
    for pair in (["1", "0"], ["0", "1"], ["3", "-4"]):
        proof = {"method": "members", "gains": ["0", "0"], "operators": [operator], "omega": omega, "input": [pair]}
        with assert_accepted_if(holds):
            members.refuted_by_members(SimpleNamespace(proof=proof), plant)


# Pieces beside poles at 0, and Popov's terms


# s H = (1 + b s) exp(-T s)/(1 + s) has the derivative b - 1 - T at 0: 1 + 2 (b - 1 - T) > 0, plus theta
@pytest.mark.parametrize(
    ("b", "wait", "theta", "holds"),
    [
        (F(51, 100), F(0), 0, True),
        pytest.param(F(49, 100), F(0), 0, False, marks=pytest.mark.thorough),
        (F(151, 100), F(1), 0, True),
        (F(149, 100), F(1), 0, False),
        (F(26, 100), F(0), F(1, 2), True),
        (F(24, 100), F(0), F(1, 2), False),
    ],
)
def test_a_pole_at_0_has_a_first_piece_where_the_derivative_allows_it(b, wait, theta, holds):
    channel = pieces._Channel("", F(2), F(1), F(theta))
    row = fmpq_mat([[1, to_fmpq(b)]])
    late = {"late": ((wait, row),)} if wait else {}
    plant = asked([[0, 1], [0, -1]], [[0], [1]], (0 if wait else 1) * row, [[0]], replace(PLAIN, upper=F(2)), **late)
    with working_precision(128), assert_accepted_if(holds):
        pieces._past_zero(plant, [channel], LateLoop.of(plant, [F(0)]), F(1))


# C (s - A)^-1 B with C = 1: B/s for A = 0
@pytest.mark.parametrize(
    ("A", "B", "holds"),
    [
        ([[0, 0], [0, 0]], [[1, 0], [0, 1]], True),
        ([[0, 0], [1, 0]], [[1, 0], [0, 1]], False),  # 1/s^2 from the first to the second
        ([[0, 0], [0, 0]], [[1, 1], [1, 1]], False),  # of rank 1, for two poles
        ([[0, 0], [0, 0]], [[1, 2], [2, 1]], False),  # the eigenvalue -1
        ([[0, 0], [0, 0]], [[2, 1], [0, 2]], False),  # not symmetric
        ([[0, 0], [0, 0]], [[-1, 0], [0, -1]], False),
    ],
)
def test_two_poles_at_0_are_simple_and_of_one_sign(A, B, holds):
    channels = [pieces._Channel("", F(1), F(1), F(0))] * 2
    plant = asked(A, B, [[1, 0], [0, 1]], [[0, 0], [0, 0]], PLAIN, PLAIN)
    with working_precision(128), assert_accepted_if(holds):
        pieces._past_zero(plant, channels, LateLoop.of(plant, [F(0)] * 2), F(1))


@pytest.mark.parametrize(
    ("direct", "theta", "slope", "holds"),
    [
        (0, -1, (F(0), F(5)), True),
        (1, 1, (F(-5), F(5)), True),
        (-1, 1, (F(0), F(9, 10)), True),
        (-1, 1, (F(0), F(11, 10)), False),
        (-1, -1, (F(0), F(11, 10)), False),
        (1, -1, (F(-9, 10), F(2)), True),
        (1, -1, (F(-11, 10), F(2)), False),
        (-1, 1, None, False),
        (-1, 0, None, True),
    ],
)
def test_with_a_direct_term_popovs_integral_needs_slopes(direct, theta, slope, holds):
    question = SimpleNamespace(
        direct=F(direct),
        plain_direct=F(direct),
        claim=SimpleNamespace(nonlinearities=replace(PLAIN, slope=slope), lower=F(0)),
        document=SimpleNamespace(hypotheses={}),
    )
    with assert_accepted_if(holds):
        theorems._require_composed(question, F(theta))


def test_multipliers_of_which_a_weight_is_negative_are_refused():
    park = SimpleNamespace(theorem="park", document=SimpleNamespace(multiplier={"theta": "0", "tau": "-1/2"}))
    with pytest.raises(NotShown, match="tau is negative"):
        theorems.multiplier_of(park)
    state = States(A=((F(-1),),), b=(F(1),), c=(F(1),), d=F(0))
    unbounded = SimpleNamespace(
        theorem="popov",
        system=Rational(discrete=False, states=state, given=None),
        direct=F(0),
        claim=SimpleNamespace(unbounded=True, lower=F(0), nonlinearities=PLAIN),
        document=SimpleNamespace(multiplier={"theta": "-1"}),
    )
    with pytest.raises(NotShown, match="need theta >= 0"):
        theorems._by_matrix(unbounded)


# Functions beside memory, rays and parts


def test_what_popovs_terms_beside_memory_are_at_least():
    # 2 theta int phi >= theta k sigma^2, k the lower bound for theta > 0 and the upper one for theta < 0
    bounds = SimpleNamespace(bounds=[(F(1), F(2)), (F(1), F(3)), (F(-1), F(1))])
    assert memory._least([F(1), F(-1), F(2)], bounds) == fmpq_mat([[1, 0, 0], [0, -3, 0], [0, 0, -2]])


@pytest.mark.parametrize(
    ("change", "theta", "holds"),
    [
        ({}, 1, True),
        ({"discrete": True}, 1, False),
        ({"D": [[1]]}, 1, False),
        ({"varies": True}, 1, False),
        ({"varies": True}, 0, True),
    ],
)
def test_popovs_terms_beside_memory_are_of_functions_of_the_state(change, theta, holds):
    one = replace(PLAIN, time_varying=change.get("varies", False))
    plant = asked([[-1]], [[1]], [[1]], change.get("D", [[0]]), one, discrete=change.get("discrete", False))
    with assert_accepted_if(holds):
        memory._require_popov(plant, [F(theta)])


# x' = a x - phi(x), phi a ReLU: along x = -1 the gain is 0 and the rate a
@pytest.mark.parametrize(
    ("a", "gains", "state", "value", "holds"),
    [
        (1, [["0"]], "-1", "1", True),
        (1, [["1"]], "-1", "0", False),  # not the gain there
        (1, [["0"]], "1", "1", False),
        (1, [["1/2"]], "-1", "1/2", False),
        (-1, [["0"]], "-1", "-1", False),
        (-1, [], "-1", "1", False),  # no step
        (2, [["0"]], "-1", "1", False),
    ],
)
def test_a_ray_of_one_state(a, gains, state, value, holds):
    plant = asked([[a]], [[1]], [[1]], [[0]], replace(PLAIN, relu=True))
    proof = {"method": "relu-ray", "gains": gains, "state": [state], "value": value, "radius": "1/1000"}
    with assert_accepted_if(holds):
        rays.refuted_by_ray(SimpleNamespace(proof=proof), plant)


def test_other_states_are_of_a_plant_without_dead_times():
    plant = asked([[1, 2], [3, 4]], [[1], [2]], [[3, 5]], [[7]], PLAIN)
    found, S = parts._turned(plant, [["1", "1"], ["0", "2"]]), fmpq_mat([[1, 1], [0, 2]])
    assert (S * found.A, S * found.B, found.C, found.D) == (plant.A * S, plant.B, plant.C * S, plant.D)
    with pytest.raises(NotShown, match="singular"):
        parts._turned(plant, [["1", "1"], ["2", "2"]])
    with pytest.raises(NotShown, match="dead times"):
        parts._turned(replace(plant, late=((F(1), plant.C),)), [["1", "1"], ["0", "2"]])


# Curves: x_1' = -x_1 + phi(x_1), x_2' = -x_2, with phi = 0, and with 4 (x_1 - 1/2) from 1/2 on, where 2/3 is at rest

ZERO = Curved(cuts=(F(1, 2),), pieces=(fmpq_poly([]),) * 2)
BENT = Curved(cuts=(F(1, 2),), pieces=(fmpq_poly([]), fmpq_poly([-2, 4])))
BACK = Curved(cuts=(F(-1, 2),), pieces=(fmpq_poly([2, 4]), fmpq_poly([])))


def flow(graph):
    rows, seen = fmpq_mat([[-1, 0, 1], [0, -1, 0]]), fmpq_mat([[1, 0, 0]])
    return Loop(F=rows, Y=seen, D=fmpq_mat(1, 1), discrete=False, graphs=(graph,))


@pytest.mark.parametrize(("graph", "crossed"), [(ZERO, True), (BENT, False)])
def test_a_parabola_that_begins_at_a_cut_lies_beyond_it(graph, crossed):
    bulge = Arc(corners=((fmpq(1, 2), fmpq(-1)), (fmpq(1), fmpq(0)), (fmpq(1, 2), fmpq(1))))
    with assert_accepted_if(crossed):  # at (3/4, 0) x_1' is -3/4, or 1/4
        require_crossed(flow(graph), [bulge], 1)


@pytest.mark.parametrize("graph", [BENT, BACK])
@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize(("size", "alone"), [(F(3, 5), True), (F(7, 10), False)])
def test_other_equilibria_within_a_curve_are_seen(graph, turned, size, alone):
    corners = [(1, 0), (0, -1 if turned else 1), (-1, 0), (0, 1 if turned else -1), (F(1, 2), 0)]
    loop = flow(graph)
    curve = curve_of(loop, [[str(size * v) for v in corner] for corner in corners])
    assert curve.sense == (-1 if turned else 1)
    with assert_accepted_if(alone):
        require_one_equilibrium(loop, curve)


# Regions


def line(discrete):
    cube = Curved(cuts=(), pieces=(fmpq_poly([0, 1, 0, 1]),))
    rows, seen = fmpq_mat([[-1, 2, 1], [0, -3, 2]]), fmpq_mat([[1, 3, 0]])
    return Loop(F=rows, Y=seen, D=fmpq_mat(1, 1), discrete=discrete, graphs=(cube,))


def test_integrals_over_the_strip_where_they_are_bounded():
    # 2 int phi = x^2 + x^4/2 lies between x^2 and 3/2 x^2 for |x| <= 1; sigma' = C F z, C = (1, 3)
    P, z = fmpq_mat([[2, 1], [1, 5]]), fmpq_mat([[2], [-1], [3]])
    for theta, least, reach, holds in (
        *((F(1), F(1), F(1), True), (F(1), F(11, 10), F(1), False), (F(1), F(1), F(-1), False)),
        *((F(-1, 3), F(3, 2), F(1), True), (F(-1, 3), F(7, 5), F(1), False), (F(-1, 3), F(3, 2), F(6, 5), False)),
    ):
        entry = {"channel": 1, "theta": str(theta), "reach": str(reach), "least": str(least)}
        with pytest.raises(NotShown, match="does not fit"):
            regions._with_integrals(line(discrete=True), P, [entry])
        with assert_accepted_if(holds):
            below, taken, strips = regions._with_integrals(line(discrete=False), P, [entry])
            row = fmpq_mat([[1, 3]])
            assert below == P + to_fmpq(theta * least) * row.transpose() * row
            assert strips == [(row, reach)]
            rate = (row * line(discrete=False).F * z)[0, 0]
            assert (z.transpose() * taken * z)[0, 0] == 2 * to_fmpq(theta) * 3 * rate


@pytest.mark.parametrize("discrete", [False, True])
def test_what_a_disturbance_does_is_a_form_in_the_states_and_in_it(discrete):
    loop, P = line(discrete), fmpq_mat([[2, 1], [1, 5]])
    moves = regions._Moves.read(loop, {"energy": "1/2", "Bw": [["1", "2"], ["0", "3"]], "Dsigmaw": [["1", "-1"]]})
    z, w = fmpq_mat([[2], [-1], [3]]), fmpq_mat([[5], [7]])
    a, b, first, second = fmpq_mat([[1, 2, 3]]), fmpq_mat([[0, 1, -1]]), fmpq(2), fmpq(-3)
    moves.add(0, F(1, 3), (a, first), (b, second))
    x, s = fmpq_mat([[2], [-1]]), fmpq(5 - 7)
    moved = loop.F * z + fmpq_mat([[1, 2], [0, 3]]) * w
    before = (x.transpose() * P * x)[0, 0]
    rise = (moved.transpose() * P * moved)[0, 0] - before if discrete else 2 * (x.transpose() * P * moved)[0, 0]
    term = ((a * z)[0, 0] + first * s) * ((b * z)[0, 0] + second * s) * fmpq(2, 3)
    alone = (a * z)[0, 0] * (b * z)[0, 0] * fmpq(2, 3)
    whole = moves.beside(loop, P, -loop.form(P))
    both = fmpq_mat([*z.tolist(), *w.tolist()])
    assert (both.transpose() * whole * both)[0, 0] == fmpq(74) / fmpq(1, 2) - rise - term + alone
