"""The second checker's own numerics: roots by their side, polynomials on the circle, nonlinearities in pieces."""

import cmath
from dataclasses import replace
from fractions import Fraction as F
from itertools import product
from math import pi

import numpy as np
import pytest
from flint import acb, acb_series, arb, arb_mat, fmpq, fmpq_mat, fmpq_poly
from hypothesis import given
from hypothesis import strategies as st
from second_plants import poly

from lure.analysis.certificates.second.channels import Asked, cut, joined, stacked
from lure.analysis.certificates.second.classes import graph
from lure.analysis.certificates.second.late_loops import LateLoop, opened
from lure.analysis.certificates.second.numerics import (
    Counts,
    Laurent,
    X,
    ball,
    even_odd,
    half_plane_counts,
    nonnegative_from_zero,
    nonnegative_on_circle,
    on_axis,
    positive_from_zero,
    positive_on_circle,
    positive_roots,
    to_fmpq,
    working_precision,
)
from lure.analysis.certificates.second.reading import NotShown
from lure.analysis.certificates.second.several import _nonnegative
from lure.analysis.certificates.second.systems import Plant
from lure.analysis.certificates.second.zero import integrators_apart, leading, null_space

ONE = fmpq_poly([1])


# s + a has one root at -a; s^2 + 2 b s + c with b^2 < c two at real part -b; s^2 + c, c > 0, two on the axis.
FACTORS = {
    "left": [X + 3, X**2 + X + 5, X * 2 + 1],
    "right": [X - 2, X**2 - X + 7, X * 3 - 1],
    "axis": [X, X**2 + 2, X**2 * 5 + 1],
}


@given(st.lists(st.tuples(st.sampled_from([*FACTORS]), st.integers(0, 2), st.integers(1, 3)), max_size=5))
def test_roots_are_counted_by_their_side_with_multiplicity(chosen):
    wanted, p = dict.fromkeys(FACTORS, 0), ONE
    for side, i, power in chosen:
        factor = FACTORS[side][i]
        wanted[side] += power * factor.degree()
        p *= factor**power
    assert half_plane_counts(-p) == Counts(**wanted)


@given(st.lists(st.integers(-4, 4), min_size=1, max_size=6), st.floats(-3, 3))
def test_the_value_on_the_axis(coefficients, omega):
    p = fmpq_poly(coefficients)
    e, o = even_odd(p)
    x, s = omega * omega, 1j * omega
    value = sum(c * s**k for k, c in enumerate(coefficients))
    assert value == pytest.approx(at(e, x) + s * at(o, x), abs=1e-9 * (1 + abs(omega)) ** 6)


def at(p, x):
    return sum(int(c.p) / int(c.q) * x**k for k, c in enumerate(p.coeffs()))


def test_positive_roots_come_with_their_multiplicities():
    found = positive_roots(X**3 * (X - 2) ** 2 * (X - 1) * (X + 5) * (X**2 + 1))
    assert sorted((round(float(root.mid()), 9), m) for root, m in found) == [(1.0, 1), (2.0, 2)]


# (x - 1)^2 touches 0, x (x - 1)^2 from 0 on; x^2 - 3 x + 2 is negative between 1 and 2.
def test_signs_from_zero_on():
    assert positive_from_zero(X**2 - X + 1)
    assert not positive_from_zero((X - 1) ** 2)
    assert nonnegative_from_zero(X * (X - 1) ** 2)
    assert not nonnegative_from_zero(X**2 - 3 * X + 2)
    assert not nonnegative_from_zero(-X)


# c^2 - 1/4 changes its sign at 1/2; (c - 1/2)^2 touches 0 there; 1 - c^2 is 0 at both ends, 2 - c nowhere.
@pytest.mark.parametrize(
    ("p", "positive", "nonnegative"),
    [
        (2 - X, True, True),
        (X**2 - fmpq(1, 4), False, False),
        ((X - fmpq(1, 2)) ** 2, False, True),
        (1 - X**2, False, True),
        (X - 1, False, False),
        (fmpq_poly([]), False, True),
        ((X - 1) ** 2 * (X + 2), False, True),
        (X**3 - X + 1, True, True),  # least value 1 - 2/(3 sqrt(3)) > 0
    ],
)
def test_signs_on_the_circle(p, positive, nonnegative):
    assert (positive_on_circle(p), nonnegative_on_circle(p)) == (positive, nonnegative)


@pytest.mark.parametrize(
    ("p", "positive", "nonnegative"),
    [
        (poly(), False, True),
        (poly("-1/2"), False, False),
        (poly("1/2"), True, True),
        (poly(0, 1), False, True),
        (poly("-1/3", "1/2"), False, False),
        (poly("1/3", "-1/2"), False, False),
        (poly(-1, 1) ** 3, False, False),
        (-(poly(-1, 1) ** 2), False, False),
        (poly("1/4", 0, 1), True, True),
    ],
)
def test_signs_of_short_polynomials_from_zero_on(p, positive, nonnegative):
    assert (positive_from_zero(p), nonnegative_from_zero(p)) == (positive, nonnegative)


@pytest.mark.parametrize(
    ("p", "positive", "nonnegative"),
    [
        (poly(1, -1), False, True),
        (poly(1, 1), False, True),
        (poly("-1/2"), False, False),
        (poly("1/2"), True, True),
        (poly("1/2", 1) ** 3, False, False),
        (poly("1/2", 1) ** 2 * poly(2, 1), False, True),
        (poly("3/2", 1), True, True),
    ],
)
def test_signs_of_short_polynomials_on_the_circle(p, positive, nonnegative):
    assert (positive_on_circle(p), nonnegative_on_circle(p)) == (positive, nonnegative)


def test_roots_that_lie_opposite_near_the_axis_are_on_their_sides():
    assert half_plane_counts(poly("-1/4", 0, 1)) == Counts(1, 0, 1)
    assert half_plane_counts(poly("-1/4", 0, 1) * poly("1/9", 0, 1) ** 2 * X) == Counts(1, 5, 1)
    with pytest.raises(NotShown, match="zero polynomial"):
        half_plane_counts(poly())


# on [1/2, 3/2] s^k is (i omega)^k, from the middle and at both ends
@pytest.mark.parametrize("k", range(5))
def test_a_function_is_enclosed_on_an_interval_of_the_axis(k):
    with working_precision(128):
        found = on_axis(lambda s: s**k if k else 0 * s + 1, F(1, 2), F(3, 2))
        for omega in (F(1, 2), F(1), F(3, 2)):
            assert found.contains(acb(0, ball(omega)) ** k)
        assert found.abs_upper() < arb(2) ** (k + 1)


@given(st.lists(st.integers(-4, 4), min_size=1, max_size=6), st.integers(0, 4), st.floats(0, 3.14))
def test_the_real_part_on_the_circle(coefficients, shift, w):
    z = cmath.exp(1j * w)
    one = Laurent(fmpq_poly(coefficients), shift)
    value = sum(c * z ** (k - shift) for k, c in enumerate(coefficients))
    assert at(one.real_part(), z.real) == pytest.approx(value.real, abs=1e-8)
    assert at(one.conjugate().real_part(), z.real) == pytest.approx(value.real, abs=1e-8)
    both = one * one.conjugate() + one.scaled(F(1, 2))
    assert at(both.real_part(), z.real) == pytest.approx(abs(value) ** 2 + value.real / 2, abs=1e-7)


# z - 1/2 has its root inside, z + 1 on, z - 3 outside the unit circle; z = -1 is mapped to infinity.
def test_a_plant_in_discrete_time():
    d = (2 * X - 1) * (X + 1) ** 2 * (X - 3)
    assert Plant.of(ONE, d, discrete=True).counts == Counts(left=1, axis=2, right=1)
    assert Plant.of(ONE, (2 * X - 1) * (X - 1), discrete=True).case == "critical"
    assert Plant.of(ONE, (2 * X - 1) * (X + 1), discrete=True).case is None
    # 1/(z - 1 + 1/2 + g): stable for |1/2 - g| < 1
    plant = Plant.of(ONE, X - fmpq(1, 2), discrete=True)
    assert [plant.shifted(F(g, 2)).case for g in (-1, 0, 2, 3)] == ["critical", "stable", "stable", None]


def test_a_law_gets_the_origin_and_its_kinks():
    nonlinearity = graph([["-1", "-1"], ["2", "2"]], "0", "3")  # a line through 0 between two kinks
    assert nonlinearity.knots == (-1, 0, 2)
    assert nonlinearity.slopes == (0, 1, 1, 3)
    assert [kink[0] for kink in nonlinearity.kinks] == [-1, 2]
    assert (nonlinearity.at(F(-5)), nonlinearity.at(F(1, 2)), nonlinearity.at(F(3))) == (-1, F(1, 2), 5)
    assert sorted(set(nonlinearity.chords)) == [0, 1, 3]
    assert not nonlinearity.odd
    assert graph([["-1", "-1"], ["1", "1"]], "0", "0").odd
    assert to_fmpq(F(2, 3)) == fmpq(2, 3)


# x + 2 y + 3 z = 0 is a plane; of [[2, 4, 6], [1, 2, 5]] the null space is a line, of a matrix of full rank 0 alone
@pytest.mark.parametrize(("rows", "size"), [([[1, 2, 3]], 2), ([[2, 4, 6], [1, 2, 5]], 1), ([[1, 2], [3, 5]], 0)])
def test_a_null_space_is_what_a_matrix_takes_to_0(rows, size):
    M = fmpq_mat(rows)
    basis = null_space(M)
    assert (basis.nrows(), basis.ncols()) == (M.ncols(), size)
    if size:
        assert basis.rank() == size
        assert M * basis == fmpq_mat(M.nrows(), size)
    assert len(leading(*M.rref())) == M.ncols() - size


def test_matrices_are_put_together_and_cut():
    a, b = fmpq_mat([[1, 2]]), fmpq_mat([[3, 4], [5, 6]])
    assert stacked(a, b) == fmpq_mat([[1, 2], [3, 4], [5, 6]])
    assert cut(stacked(a, b), 1, 2) == b
    whole = joined(b, 2 * b, 3 * b, lower_left=4 * b)
    assert [[whole[i, j] / b[i % 2, j % 2] for j in (0, 2)] for i in (0, 2)] == [[1, 2], [4, 3]]


# A plant with two states, dead times 1/2 and 3/2, states that come back late, D, and mu = w - L sigma.
SIDES = {
    "A": [[F(-1), F(2, 3)], [F(-3, 2), F(-2)]],
    "B": [[F(1), F(1, 2)], [F(-2), F(3)]],
    "C": [[F(2), F(-1, 3)], [F(1, 4), F(1)]],
    "D": [[F(0), F(1, 5)], [F(-1, 2), F(2)]],
}
LATE = [(F(1, 2), [[F(0), F(5, 2)], [F(-1), F(1, 3)]]), (F(3, 2), [[F(2, 7), F(0)], [F(3), F(-1, 2)]])]
INNER = [[[F(0), F(0)], [F(1, 3), F(-3, 4)]], [[F(0), F(0)], [F(-2, 3), F(1, 5)]]]
GAINS = [F(1, 3), F(-2, 5)]


def flint(rows):
    return fmpq_mat([[to_fmpq(v) for v in row] for row in rows])


def late_plant():
    sides = {name: flint(rows) for name, rows in SIDES.items()}
    late, inner = tuple((tau, flint(rows)) for tau, rows in LATE), tuple(map(flint, INNER))
    return Asked(**sides, discrete=False, nonlinearities=(), repeated=(0, 1), late=late, inner=inner)


def closed_response(s, moved=()):
    """``H (1 + L H)^-1`` by the formulas of the plant; ``moved``: ``s e^(-s T)``, ``D_T`` and ``E_T``."""
    A, B, C, D = (np.array(SIDES[name], dtype=float) for name in "ABCD")
    waits = [(np.exp(-float(tau) * s), np.array(rows, dtype=float)) for tau, rows in LATE]
    back = s * np.eye(2) - A - sum(w * np.array(one, dtype=float) for (w, _), one in zip(waits, INNER, strict=True))
    back = back - sum(w * E for w, _, E in moved)
    H = (C + sum(w * rows for w, rows in waits) + sum(w * D_T for w, D_T, _ in moved)) @ np.linalg.solve(back, B) + D
    return H @ np.linalg.inv(np.eye(2) + np.diag([float(g) for g in GAINS]) @ H)


def numbers_of(matrix):
    return np.array([[complex(v.mid()) for v in row] for row in matrix.tolist()])


def test_a_late_plant_closed_by_gains_has_the_response_of_its_formulas():
    loop, omega, h = LateLoop.of(late_plant(), GAINS), 1.75, 1e-6
    assert numbers_of(loop.at(arb(omega))) == pytest.approx(closed_response(1j * omega))
    rows = loop.response(acb_series([acb(0, omega), acb(0, 1)]))  # in omega
    values, slopes = (np.array([[complex(f[k].mid()) for f in row] for row in rows]) for k in (0, 1))
    assert values == pytest.approx(closed_response(1j * omega))
    by_difference = (closed_response(1j * (omega + h)) - closed_response(1j * (omega - h))) / (2 * h)
    assert slopes == pytest.approx(by_difference, rel=1e-6, abs=1e-8)
    assert loop.at_any_phase(arb(1 / omega), []) is None  # the phases may be any there
    omega = 64.0
    parts = loop.at_any_phase(arb(1 / omega), [])
    waits = [1, *(np.exp(-1j * float(tau) * omega) for tau, _ in LATE)]
    true = closed_response(1j * omega)
    for i in range(2):
        for j in range(2):
            for power, side in enumerate((0, 1)):  # H, and s H less what D makes of it
                value = sum((acb(w) * part[side][i, j] for w, part in zip(waits, parts, strict=True)), acb(0))
                direct = complex(loop.D[i, j].p) / complex(loop.D[i, j].q)
                wanted = true[i, j] if not power else 1j * omega * (true[i, j] - direct)
                assert value.real.contains(arb(wanted.real, 1e-9))
                assert value.imag.contains(arb(wanted.imag, 1e-9))


def test_a_neutral_plant_closed_by_gains_has_the_response_of_its_formulas():
    D, E = [[F(1, 9), F(0)], [F(0), F(-1, 8)]], [[F(0), F(1, 7)], [F(1, 6), F(0)]]
    zero = [[F(0)] * 2] * 2
    rates = ((flint(D), flint(E)), (flint(zero), flint(zero)))
    loop, omega = LateLoop.of(replace(late_plant(), rates=rates), GAINS), 400.0
    s, tau = 1j * omega, float(LATE[0][0])
    moved = [(s * np.exp(-tau * s), *(np.array(side, dtype=float) for side in (D, E)))]
    true = closed_response(s, moved)
    assert numbers_of(loop.at(arb(omega))) == pytest.approx(true)
    rows = loop.response(acb_series([acb(0, omega), acb(0, 1)]))
    assert np.array([[complex(f[0].mid()) for f in row] for row in rows]) == pytest.approx(true)
    turn = F(-tau * omega / (2 * np.pi) % 1)  # what is late by 3/2 is apart
    parts = loop.at_any_phase(arb(1 / omega), [(turn - F(1, 100), turn + F(1, 100))])
    wait = acb(complex(np.exp(-1.5 * s)))
    for i, j in product(range(2), repeat=2):
        value = parts[0][0][i, j] + wait * parts[1][0][i, j]
        assert value.real.contains(arb(true[i, j].real, 1e-9))
        assert value.imag.contains(arb(true[i, j].imag, 1e-9))


def test_an_output_is_no_larger_than_what_comes_at_once_and_what_is_late_together():
    # H = (2 + s exp(-s)/3)/(s + 1), at the frequency 4 and at any phase
    one, zero = flint([[1]]), flint([[0]])
    loop = LateLoop(-1 * one, one, 2 * one, zero, ((F(1), zero, zero),), ((zero, flint([[F(1, 3)]])),), None)
    ((plain, _, most),) = loop.at_any_phase(arb(fmpq(1, 4)), [(F(0), F(1))])
    assert float(most[0, 0]) == pytest.approx((2 + 4 / 3) / abs(1 + 4j))
    for turn in np.exp(2j * np.pi * np.linspace(0, 1, 7)):
        assert plain[0, 0].contains(acb(complex((2 + 4j * turn / 3) / (1 + 4j))))


def test_the_angle_of_a_late_loop_is_enclosed_on_pieces_and_far_out():
    loop = LateLoop.of(late_plant(), [F(0), F(0)])
    A = np.array(SIDES["A"], dtype=float)

    def g(omega, power):
        """``det(s - M)``, over ``s^2``, or from 0 on over ``i^2``."""
        late = zip(LATE, INNER, strict=True)
        M = A + sum(np.exp(-1j * float(tau) * omega) * np.array(one, dtype=float) for (tau, _), one in late)
        return np.linalg.det(1j * omega * np.eye(2) - M) / (1j * omega**power) ** 2

    for a, b, power in ((F(0), F(1, 64), 0), (F(3), F(193, 64), 1), (None, F(50), 1)):
        enclosed = loop._turn(a, b)
        for share in np.linspace(0, 1, 40).tolist():
            omega = float(a) + share * float(b - a) if a is not None else float(b) * (1 + 3 * share)
            value = g(max(omega, 1e-12), power)
            assert enclosed.real.contains(arb(value.real, 1e-9))
            assert enclosed.imag.contains(arb(value.imag, 1e-9))
        assert enclosed.real.rad() < (1 if a is None else 0.2)


# x_0' = b mu, sigma = c x_0 beside 1/(s + 1) in the same channel: R = b c, H_1 = 1/(s + 1)
def test_integrators_are_taken_apart_where_small_gains_stabilise():
    def apart(b, c, A=((0, 0), (0, -1))):
        shifted = fmpq_mat(A), fmpq_mat([[b], [1]]), fmpq_mat([[c, 1]]), fmpq_mat([[0]])
        return integrators_apart(shifted, fmpq_mat([[2]]))

    (A, B, C, _), R = apart(fmpq(1, 10), 3, ((0, 1), (0, -1)))  # 0 has the left vector (1, 1): R = 3 (1/10 + 1)
    assert fmpq_mat([[fmpq(33, 10)]]) == R
    s = 0.4 + 0.9j
    inner = np.linalg.solve(s * np.eye(2) - numbers_of(arb_mat(A)).real, numbers_of(arb_mat(B)))
    by_hand = np.array([[3, 1]]) @ np.linalg.solve(s * np.eye(2) - np.array([[0, 1], [0, -1]]), np.array([[0.1], [1]]))
    assert numbers_of(arb_mat(C)) @ inner + 3.3 / s == pytest.approx(by_hand)
    for b, c, why in ((fmpq(-1, 10), 3, "too few positive"), (0, 3, "too few positive"), (1, 0, "too few positive")):
        with pytest.raises(NotShown, match=why):
            apart(b, c)
    with pytest.raises(NotShown, match="too few eigenvectors"):
        apart(1, 1, ((0, 1), (0, 0)))
    both = fmpq_mat(2, 2), fmpq_mat([[1, 0], [0, 1]]), fmpq_mat([[1, 0], [0, 1]]), fmpq_mat(2, 2)
    assert integrators_apart(both, fmpq_mat([[1, 0], [0, 3]]))[1] == both[1]
    with pytest.raises(NotShown, match="not symmetric"):
        integrators_apart(both, fmpq_mat([[1, 1], [0, 1]]))
    with pytest.raises(NotShown, match="too few positive"):
        integrators_apart(both, fmpq_mat([[fmpq(1, 9), 0], [0, fmpq(-1, 9)]]))


def test_a_late_loop_has_to_be_well_posed():
    plant = replace(late_plant(), D=flint([[2, 0], [0, 1]]))  # 1 + D L is singular for the gain -1/2
    with pytest.raises(NotShown, match="not well posed"):
        LateLoop.of(plant, [F(-1, 2), F(0)])


def test_states_that_come_back_late_may_be_channels_with_the_gain_1():
    wider, inner = opened(late_plant())
    assert inner == [1]  # of the second state alone
    found = LateLoop.of(wider, [*GAINS, F(1)])
    assert numbers_of(found.at(arb(0.6)))[:2, :2] == pytest.approx(closed_response(0.6j))
    D, E, zero = [[F(1, 9), F(0)], [F(0), F(-1, 8)]], [[F(0), F(0)], [F(1, 6), F(0)]], [[F(0)] * 2] * 2
    wider, inner = opened(replace(late_plant(), rates=((flint(D), flint(E)), (flint(zero), flint(zero)))))
    found, moved = LateLoop.of(wider, [*GAINS, *inner]), [np.array(side, dtype=float) for side in (D, E)]
    wanted = closed_response(0.6j, [(0.6j * np.exp(-0.6j * float(LATE[0][0])), *moved)])
    assert numbers_of(found.at(arb(0.6)))[:2, :2] == pytest.approx(wanted)


# s + K e^-s has 2 roots to the right for K between pi/2 and 5 pi/2, 2 more with every 2 pi; of s - 1 + K e^-s/10 the
# one at 1 comes back for K > 1
@pytest.mark.parametrize(
    ("a", "back", "delay", "roots"),
    [
        (0, 1, 1, 0),
        (0, F(8, 5), 1, 2),
        (0, 9, 1, 4),
        (0, 15, 1, 6),
        (0, -1, 1, 1),
        (1, F(1, 2), F(1, 10), 1),
        (1, 2, F(1, 10), 0),
        (-1, 0, 1, 0),
        (1, 0, 1, 1),
    ],
)
def test_roots_of_late_loops_are_counted(a, back, delay, roots):
    assert (roots > 1) == (back > pi / 2 and delay == 1)
    one, none = flint([[1]]), flint([[0]])
    plant = Asked(
        A=flint([[a]]), B=one, C=none, D=none, discrete=False, nonlinearities=(), repeated=(0,),
        late=((F(delay), none),), inner=(flint([[-F(back)]]),),
    )  # fmt: skip
    assert LateLoop.of(plant, [F(0)]).right_roots() == roots


@pytest.mark.parametrize(("least", "fine"), [(0, True), (F(1, 9), True), (F(-1, 9), False), (-2, False)])
def test_a_form_is_nonnegative_where_all_its_roots_are(least, fine):
    turn, lengths = fmpq_mat([[3, -4], [4, 3]]) / 5, fmpq_mat([[to_fmpq(F(least)), 0], [0, 1]])
    assert _nonnegative(turn * lengths * turn.transpose()) is fine
