"""Certificates where no polynomial decides: covers for dead time, structure and energy for the rod."""

import cmath
import itertools
import math
import random
from fractions import Fraction

import numpy as np
import pytest
from depth import sampled
from hypothesis import given
from hypothesis import strategies as st
from late_loops import value
from sharpness import CLOSE, assert_sharp

from lure.analysis.certificates.arithmetic import Form, Rejected, S, real
from lure.analysis.certificates.balls import WORD, Lift, Model, above, box, tail, turning
from lure.analysis.certificates.checker import Proved, check
from lure.analysis.certificates.covers import ORDER, CoverTests, Uncovered, cover, quick_reach
from lure.analysis.certificates.drafts import completed
from lure.analysis.certificates.pieces import Axis, Member, minors, on_piece
from lure.analysis.certificates.proposals import certified
from lure.analysis.rod.certificates import circle_bound, popov_theta
from lure.analysis.rod.theory import RodTheory
from lure.analysis.theorems.other_plants import largest
from lure.errors import AssumptionError
from lure.plants.delay import DelayPlant
from lure.rod.discretisation import upwind
from lure.rod.systems import builtin_system
from lure.rod.transfer import RodPlant


def test_what_stands_for_a_function_on_an_interval_is_off_by_no_more_than_it_says():
    rng = random.Random(20261123)

    def drawn(most):
        return Form(
            {
                (Fraction(rng.randint(-9, 9), 4), rng.randint(0, most)): (
                    Fraction(rng.randint(-99, 99), 7),
                    Fraction(k),
                )
                for k in range(-2, 3)
            }
        )

    for _ in range(sampled(8, of=400)):
        F, G, start, halvings = drawn(9), drawn(4), Fraction(rng.randint(0, 50), 8), rng.randint(-5, 20)
        end = start + Fraction(rng.randint(1, 64), rng.choice((1, 16)))
        near = Lift(start, end)
        found = near(F, halvings) * near(G).conjugate() + near(F, halvings)
        for x in (Fraction(-1), Fraction(3, 10), Fraction(1)):
            w = float((start + end) / 2 + x * (end - start) / 2)
            true = value(F, w) / 2**halvings * (value(G, w).conjugate() + 1)
            sides = [float(sum(c * x**k for k, c in enumerate(side)) / 2**WORD) for side in (found.u, found.v)]
            assert abs(complex(*sides) - true) <= found.off / 2**WORD + 1e-10 * (1 + abs(true))

    # Taylor's formula is cut off: 8^32/32! = 3e-7
    turn = Lift(Fraction(0), Fraction(16)).turn(Fraction(1))
    sides = [float(sum(side)) / 2**WORD for side in (turn.u, turn.v)]
    assert abs(complex(*sides) - cmath.exp(-16j)) <= turn.off / 2**WORD + 1e-12


@pytest.mark.parametrize("tau", [1, -2])
def test_a_sign_is_shown_as_far_as_it_goes_and_no_farther(tau):
    # 1/2 + cos(tau omega) > 0 for |tau| omega < 2 pi/3 = 2.0944
    F = Form({(Fraction(tau), 0): (Fraction(1), Fraction(0)), (Fraction(0), 0): (Fraction(1, 2), Fraction(0))})
    inside, outside = (Fraction(v, 10**4 * abs(tau)) for v in (20943, 20944))
    assert above(Lift(Fraction(0), inside)(F))
    assert not above(Lift(Fraction(0), outside)(F))
    assert above(Model([11], [], 10))
    assert not above(Model([10], [], 10))


def test_far_out_lower_powers_of_late_parts_count_by_their_size_at_the_start():
    # omega^2 > 5 omega cos(omega) from 5 on; by leading coefficients alone no start below 5000 would do
    F = Form({(Fraction(0), 2): (Fraction(1), Fraction(0)), (Fraction(1), 1): (Fraction(5), Fraction(0))})
    F[Fraction(2), 2] = (Fraction(1, 10), Fraction(0))
    assert tail(F, Fraction(6), 2)
    assert not tail(F, Fraction(4), 2)


@pytest.mark.parametrize(("k", "start", "holds"), [("13/10", 60, True), ("13/10", 20, False), ("27/20", 10**6, False)])
def test_late_parts_that_do_not_decay_count_with_their_phases(k, start, holds):
    # |1 + z^3/3|^2/k + Re (z/2)(1 + z^-3/3), z = exp(-i w/3): -3/4 is the least of Re (z/2)/(1 + z^3/3), so that it is
    # above 0 for k < 4/3; at z = -1 it is 4/9 (1/k - 3/4), .0085 for 1.3, of which 1/w may take as much
    parts = {
        "0": (Fraction(10, 9) / Fraction(k), 2),
        "1": (Fraction(2, 3) / Fraction(k), 2),
        "2/3": (Fraction(1, 6), 2),
    }
    F = Form({(Fraction(tau), n): (c, Fraction(0)) for tau, (c, n) in parts.items()})
    F[Fraction(1, 3), 2] = (Fraction(1, 2), Fraction(0))
    F[Fraction(1, 3), 1] = (Fraction(1, 3), Fraction(0))
    assert turning(F, Fraction(start), 2) is holds
    assert not tail(F, Fraction(10**6), 2)


@pytest.mark.parametrize(
    ("kind", "piece", "theta", "late", "most"),
    [
        # H = (s/2) exp(-s/100)/(s (1 + exp(-3 s)/5) + 1): at infinity |H| <= (1/2)/(4/5) = 5/8, with all phases
        ("", (0, 0), 0, (Fraction(1, 2), 1), Fraction(8, 5)),
        # Re (x + i y)(1 + w H) with 3/5 + 4i/5, of modulus at most 7/5
        ("scaled", (Fraction(3, 5), Fraction(4, 5)), 0, (Fraction(1, 2), 1), Fraction(24, 35)),
        # 1 + (w + theta s) H with H = exp(-s/100)/(s + ..), theta = 799/1000: s H alone has 5/4 of it at infinity
        ("", (0, 0), Fraction(799, 1000), (1, 0), Fraction(10)),
        ("", (0, 0), Fraction(801, 1000), (1, 0), Fraction(0)),
    ],
)
def test_far_out_the_quotient_of_what_comes_late_is_in_a_disc(kind, piece, theta, late, most):
    d = real(1) + S + Form({(Fraction(3), 0): (Fraction(1, 5), Fraction(0))}) * S
    size, power = late
    N = Form({(Fraction(1, 100), 0): (Fraction(size), Fraction(0))}) * (S if power else real(1))

    def shown(width, start=Fraction(10**7), d=d):
        member = Member(kind, Fraction(width), Fraction(not kind), Fraction(theta), Fraction(0))
        axis = Axis(d, [[N]], d, [[N]], [], 1, [member], True, None).over(lambda form: form)
        return on_piece(axis, [[*map(Fraction, piece)]], start, None) == ""

    if most:
        assert shown(most * Fraction(999, 1000))
        assert not shown(most * Fraction(999, 1000), start=Fraction(1))
    assert not shown(max(most, 1) * Fraction(1001, 1000)) or most == 10  # there theta decides
    assert not shown(Fraction(1, 100), d=d + Form({(Fraction(3), 0): (Fraction(9, 10), Fraction(0))}) * S)


@pytest.mark.parametrize("beta", [-33, -31])
def test_far_out_all_bernstein_coefficients_count(beta):
    # 1 + beta u + 2.5 u^2, u in [0, 1] being 1/omega: .2 or .4 at 1, and below 0 at -beta/5
    F = Form({(Fraction(0), n): (Fraction(c, 10), Fraction(0)) for n, c in ((2, 10), (1, beta), (0, 25))})
    F[Fraction(1), 2] = (Fraction(1, 10**6), Fraction(0))
    assert not turning(F, Fraction(1), 2)
    F[Fraction(0), 1] = (Fraction(-19, 10), Fraction(0))  # of which the second one is 1 - 19/20
    assert turning(F, Fraction(1), 2)


# 1 + Re H > 0, H = c s exp(-s)/(s + 1), with exp(1/2) c at the rate 1/2; 1 > h^2 |s H|^2, H = exp(-s)/2/(s + 1)
@pytest.mark.parametrize(
    ("kind", "size", "bound", "pace", "holds"),
    [
        ("", "60/100", "0", "1/2", True),
        ("", "62/100", "0", "1/2", False),  # exp(-1/2) = .6065
        ("slow", "1/2", "14/10", None, True),  # 1 - h^2/4 far out
        ("slow", "1/2", "25/10", None, False),
    ],
)
def test_far_out_what_is_late_has_its_size(kind, size, bound, pace, holds):
    member = Member(kind, Fraction(1), Fraction(not kind), Fraction(0), Fraction(bound))
    d, N = real(1) + S, Form({(Fraction(1), 0): (Fraction(size), Fraction(0))}) * (real(1) if kind else S)
    axis = Axis(d, [[N]], d, [[N]], [], 1, [member], True, pace and Fraction(pace)).over(lambda form: form)
    piece = [(Fraction(0), Fraction(bool(kind)))]
    assert (on_piece(axis, piece, Fraction(1000), None) == "") is holds


@pytest.mark.parametrize("size", ["1/2", "2"])
def test_far_out_all_channels_count(size):
    # diag(s exp(-s)/2, c s exp(-s))/(s + 1): 1 + Re H > 0 for c < 1
    wait, d, none = Form({(Fraction(1), 0): (Fraction(1), Fraction(0))}), real(1) + S, Form()
    sizes = [Fraction(1, 2), Fraction(size)]
    N = [[wait * S * real(c) if i == j else none for j in range(2)] for i, c in enumerate(sizes)]
    members = [Member("", Fraction(1), Fraction(1), Fraction(0), Fraction(0))] * 2
    axis = Axis(d, N, d, N, [], 1, members, True, None).over(lambda form: form)
    assert (on_piece(axis, [(Fraction(0), Fraction(0))] * 2, Fraction(1000), None) == "") is (size != "2")


def test_the_form_of_all_kinds_of_channels_is_that_of_complex_numbers():
    rng, omega, s = random.Random(5), 1.25, 1.25j
    d, e = real(3) + S + S * S, np.eye(4)
    N = [
        [Form({(Fraction(t, 3), t): (Fraction(rng.randint(-9, 9), 7), Fraction(0)) for t in (0, 1)}) for _ in e]
        for _ in e
    ]
    kinds = [
        Member("", Fraction(3), Fraction(2, 3), Fraction(1, 4), Fraction(0), Fraction(-1, 5)),
        Member("scaled", Fraction(2), Fraction(0), Fraction(0), Fraction(0), Fraction(-1, 3)),
        Member("delay", Fraction(1), Fraction(0), Fraction(0), Fraction(5, 2)),
        Member("slow", Fraction(1, 2), Fraction(0), Fraction(0), Fraction(1, 3)),
    ]
    piece = [(0, 0), (Fraction(1, 2), -2), (Fraction(-1, 4), Fraction(2, 3)), (Fraction(3, 4), Fraction(1, 5))]
    axis = Axis(d, N, d, N, [], 2, kinds, True, None).over(lambda form: form)
    found = minors(axis, [tuple(map(Fraction, pair)) for pair in piece])
    H, below = np.array([[value(f, omega) for f in row] for row in N]) / value(d, omega), abs(value(d, omega)) ** 2
    Y = [
        2 / 3 * (e[0] + 2.6 * H[0]) + s / 4 * H[0],
        (0.5 - 2j) * (e[1] + 2 * H[1]) - 0.5 * 2 / 3 * H[1],
        (2 / 3 * cmath.exp(-1j * omega * 1.25) + 0.25) * H[2] - e[2] / 8,
        -0.75 * H[3] + (0.75 + 0.2) / 2 * e[3],
    ]
    whole = np.array(Y) + np.array(Y).conj().T
    squares = [-2 * 2 / 3 * 0.2 * 2.8, -2 * 0.5 / 3 * (2 - 1 / 3), 0, -0.75 / 2 - 0.2 * omega**2 / 9]
    whole = whole + sum(v * np.outer(h.conj(), h) for v, h in zip(squares, H, strict=True))
    for k, minor in enumerate(found, 1):
        wanted = np.linalg.det(whole[:k, :k]) * below**k
        assert value(minor, omega) == pytest.approx(wanted)


# exp(-s T)/(s + 1): the circle criterion reaches -1/inf Re H.
@pytest.mark.slow
@pytest.mark.parametrize(
    "text",
    [
        pytest.param("exp(-s/2)/(s + 1)", marks=pytest.mark.thorough),
        "exp(-0.3*s)/(s*(s + 1))",
        pytest.param("(1 + exp(-s))/(s + 2)^2", marks=pytest.mark.thorough),
        pytest.param("2/(s + 3) + exp(-2*s)/(s + 1)", marks=pytest.mark.slow),
    ],
)
def test_blocks_with_dead_time_are_certified_by_covers(text):
    block = DelayPlant.parse(text.replace("^", "**"))
    for criterion in ("circle", "popov"):
        try:
            answer = largest(block, criterion)
        except AssumptionError:
            continue
        found = assert_sharp(block, answer) if math.isfinite(answer.largest.low) else certified(block, answer)
        assert found.proved.certificate["proof"]["method"] == "cover"
        assert len(found.proved.certificate["proof"]["boxes"]) < 200


@pytest.mark.parametrize("cells", [1, 10, 200])
def test_the_scheme_of_the_rod_is_certified_by_structure(cells):
    scheme = upwind(builtin_system("paper-rod").rod, cells)
    theory = RodTheory(scheme)
    popov = certified(scheme, theory.largest("popov"))
    assert popov.upper == "inf"
    circle = certified(scheme, theory.largest("circle"))
    bound = circle_bound(scheme.rod)
    assert bound * (1 - CLOSE) < circle.upper < bound
    with pytest.raises(Rejected):
        completed(next(theory.drafts(theory.largest("circle"), bound))[1])
    energy = check(completed(theory.proof()))
    assert isinstance(energy, Proved)
    assert energy.theorem == "rod-energy"


def test_the_rod_itself_is_certified_by_its_energy():
    block = RodPlant(builtin_system("paper-rod").rod)
    proved = check(completed(RodTheory(block).proof()))
    assert proved.certificate["system"]["kind"] == "rod"
    assert proved.certificate["laws"]["sector"] == ["0", "inf"]


def test_a_matched_dashpot_takes_any_multiplier():
    # Z = A sqrt(rho E) = 1/2 exactly
    rod = builtin_system("paper-rod").rod
    matched = type(rod)(
        youngs_modulus=4, density=1, length=1, area=Fraction(1, 4), damping=Fraction(1, 2), compliance=1
    )
    assert popov_theta(matched) == Fraction(5, 4) * Fraction(1, 2)  # of the travel time L sqrt(rho/E)
    assert circle_bound(matched) is None
    scheme = upwind(matched, 5)
    assert certified(scheme, RodTheory(scheme).largest("popov")).upper == "inf"


def test_a_rod_that_does_not_damp_has_no_multiplier():
    rod = builtin_system("paper-rod").rod
    free = type(rod)(youngs_modulus=4, density=1, length=1, area=1, damping=0, compliance=1)
    with pytest.raises(AssumptionError, match="positive"):
        popov_theta(free)


def test_boxes_are_neighbours_that_pass_and_end_where_the_tail_begins():
    def reach(a, most):
        return min(most, Fraction(1, 8) if a < 2 else Fraction(1))

    found = cover(CoverTests(reach, lambda a, b: False, lambda a: a >= 5, Fraction(1)))
    boxes = [[Fraction(end) for end in box] for box in found]
    assert boxes[0][0] == 0
    assert 5 <= boxes[-1][1] < 6
    assert all(one[1] == two[0] for one, two in itertools.pairwise(boxes))
    assert all(b - a <= reach(a, 1) for a, b in boxes)


def test_where_the_quick_test_would_need_tiny_boxes_the_slow_one_is_asked():
    def reach(a, most):
        return Fraction(1, 2**20) if 1 <= a < Fraction(3, 2) else most

    def inside(a, b):
        return b - a <= Fraction(1, 8)

    boxes = cover(CoverTests(reach, inside, lambda a: a >= 2, Fraction(1)))
    widths = {Fraction(b) - Fraction(a) for a, b in boxes if 1 <= Fraction(a) < Fraction(3, 2)}
    assert widths <= {Fraction(1, 16), Fraction(1, 4)}
    assert len(boxes) < 20


@pytest.mark.parametrize(
    ("fails", "reason"), [("inside", "does not pass"), ("beyond", "not outweighed"), ("length", "up to")]
)
def test_no_cover_is_no_proof(fails, reason):
    tests = CoverTests(
        lambda a, most: Fraction(1, 2**11 if fails == "length" else 2**20),
        lambda a, b: fails != "inside",
        lambda a: fails != "beyond" and a >= 2,
        Fraction(1),
    )
    with pytest.raises(Uncovered, match=reason):
        cover(tests)


@given(
    delays=st.lists(st.fractions(Fraction(1, 10), 5, max_denominator=20), min_size=1, max_size=2, unique=True),
    numbers=st.lists(st.fractions(-5, 5, max_denominator=10), min_size=9, max_size=9),
    left=st.fractions(0, 10, max_denominator=64),
)
def test_what_passes_the_quick_test_passes_the_checkers(delays, numbers, left):
    # the polynomial below Re F is built twice, in balls and in rationals: a length that is long enough must serve both
    u, v = iter(numbers), iter(reversed(numbers))
    F = Form({(Fraction(0), n): (abs(next(u)) + 1, Fraction(0)) for n in range(3)})
    F = F + Form({(tau, n): (next(u), next(v)) for tau in delays for n in range(3)})
    length = quick_reach(F, left, Fraction(16), critical=False)
    if length > Fraction(1, 2**20):
        assert box(F, left, left + length, ORDER)
