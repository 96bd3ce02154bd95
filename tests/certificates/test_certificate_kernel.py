"""The arithmetic of the checker against python-flint, numpy and numbers worked out by hand; fast, for its mutants."""

import cmath
import math
import operator
from fractions import Fraction as F
from random import Random

import pytest
from flint import arb, arb_mat, ctx, fmpq, fmpq_mat, fmpq_poly

from lure.analysis.certificates import arithmetic as exact
from lure.analysis.certificates import balls
from lure.analysis.certificates.arithmetic import Form, Rejected, real
from lure.analysis.certificates.balls import Ball

CHANCE = Random(20)


def rational(size=9, parts=6):
    return F(CHANCE.randint(-size, size), CHANCE.randint(1, parts))


def flint_poly(p):
    return fmpq_poly([fmpq(v.numerator, v.denominator) for v in map(F, p)])


def flint_matrix(rows):
    return fmpq_mat([[fmpq(v.numerator, v.denominator) for v in map(F, row)] for row in rows])


def times(p, q):
    out = [F(0)] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            out[i + j] += F(a) * b
    return out


def at(form, omega):
    """A form at one frequency, in floating point."""
    return sum(
        complex(u, v) * omega**n * complex(math.cos(omega * tau), -math.sin(omega * tau))
        for (tau, n), (u, v) in form.items()
    )


def any_form():
    keys = [(F(CHANCE.randint(0, 2)), CHANCE.randint(0, 3)) for _ in range(4)]
    return Form({key: (rational(), rational()) for key in keys})


# -- quasi-polynomials -------------------------------------------------------------------------------------------------


def test_forms_are_added_multiplied_and_conjugated():
    for _ in range(20):
        f, g, omega = any_form(), any_form(), CHANCE.uniform(0.1, 2)
        x, y = at(f, omega), at(g, omega)
        assert at(f + g, omega) == pytest.approx(x + y)
        assert at(f * g, omega) == pytest.approx(x * y)
        assert at(f.conjugate(), omega) == pytest.approx(x.conjugate())
        assert at(f**3, omega) == pytest.approx(x**3)
        assert f + real(-1) * f == {}
    assert Form() ** 0 == real(1) == {(0, 0): (1, 0)}
    assert real(0, 0, 5) == {(0, 2): (5, 0)}
    assert real(0, 0, -1) == exact.S * exact.S
    assert real(1, 0, 1) == exact.X1


def test_parts_of_a_form_are_read_off():
    f = Form({(F(0), 2): (F(3), F(0)), (F(0), 3): (F(0), F(5)), (F(1), 4): (F(7), F(0))})
    assert (f.part(), f.part(1)) == ([0, 0, 3], [0, 0, 0, 5])
    assert (f.part(0, F(1)), f.part(1, F(1)), Form().part()) == ([0, 0, 0, 0, 7], [], [])


def test_coefficients_in_s_are_those_in_i_omega():
    for p in ([1], [0, 2], [1, 2, 3, 4, 5, 6], [0, 0, 0, 7]):
        form = sum((real(c) * exact.S**i for i, c in enumerate(p)), start=Form())
        got = exact.ascending(form)
        assert got[: len(p)] == p
        assert not any(got[len(p) :])


def test_a_polynomial_of_a_quotient_is_made_whole():
    up, down = real(1) + exact.S, real(1) + real(-1) * exact.S
    for degree in (2, 3, 5):
        p, omega = [F(2), F(-1), F(3)], 0.7
        u, v = 1 + 0.7j, 1 - 0.7j
        value = (2 * (u / v) ** 2 - (u / v) + 3) * v**degree
        assert at(exact.homogeneous(p, up, down, degree), omega) == pytest.approx(value)


# -- real polynomials --------------------------------------------------------------------------------------------------


def test_primitive_polynomials_are_coprime_integers_of_the_same_sign():
    assert exact.primitive([F(1, 2), F(-1, 3), 0]) == [3, -2]
    assert exact.primitive([4, 0, -6, 0, 0]) == [2, 0, -3]
    assert exact.primitive([]) == exact.primitive([0, 0]) == []
    assert exact.primitive([F(-5, 7)]) == [-1]


def test_values_are_those_of_horner():
    assert exact.value([1, -2, 3], F(1, 2)) == 1 - 1 + F(3, 4)
    assert exact.value([], F(5)) == 0


def test_a_chain_ends_in_the_greatest_common_divisor():
    for _ in range(30):
        common = [rational() for _ in range(CHANCE.randint(1, 3))] + [F(1)]
        p = exact.primitive(times(common, [rational(), rational(), F(2)]))
        q = exact.primitive(times(common, [rational(), F(-3)]))
        last = exact.chain(p, q)[-1]
        gcd = flint_poly(p).gcd(flint_poly(q))
        assert flint_poly(last) / flint_poly(last)[len(last) - 1] == gcd
    # Sturm's chain of x^2 - 2 by hand: 2x, then minus the remainder
    assert exact.chain([-2, 0, 1], [0, 1]) == [[-2, 0, 1], [0, 1], [1]]


def counted(zeros, q, low, high):
    """Roots given by hand, with the sign of q."""
    inside = [x for x in set(zeros) if low < x and (high is None or x < high)]
    signs = [sum(c * x**i for i, c in enumerate(q)) for x in inside]
    return sum((s > 0) - (s < 0) for s in signs)


def test_roots_are_counted_with_signs():
    for _ in range(150):
        zeros = [rational(5, 3) for _ in range(CHANCE.randint(0, 4))]
        p = [rational() or F(1)]
        for x in zeros:
            p = times(p, [-x, 1])
        for _ in range(CHANCE.randint(0, 2)):
            p = times(p, [CHANCE.randint(1, 4), 1, 1])  # no real root
        q = [rational() for _ in range(CHANCE.randint(1, 3))]
        low, high = F(-7, 4), CHANCE.choice([None, F(16, 7)])
        if not any(x in (low, high) for x in zeros):
            assert exact.roots(p, [1], low, high) == counted(zeros, [1], low, high)
            assert exact.roots(p, q, low, high) == counted(zeros, q, low, high)


def test_double_roots_are_counted_once():
    assert exact.roots(times([-1, 1], [-1, 1]), [1], F(0), None) == 1
    assert exact.roots(times([-1, 1], [-1, 1]), [1], F(0), F(2)) == 1
    assert exact.roots(times([-1, 1], [-1, 1]), [1, -2], F(0), F(2)) == -1
    assert exact.roots(times([-1, 1], [-1, 1]), [1, -1], F(0), F(2)) == 0


@pytest.mark.parametrize(
    ("p", "low", "high", "holds"),
    [
        ([], 0, None, False),
        ([1], 0, None, True),
        ([-1], 0, None, False),
        ([0, 1], 0, None, False),
        ([1, 1], 0, None, True),
        ([1, -1], 0, None, False),
        ([1, 0, -1], 0, None, False),
        ([2, -2, 1], 0, None, True),
        ([1, -2, 1], 0, None, False),
        ([1 + F(1, 2**90), -2, 1], 0, None, True),
        ([1 - F(1, 2**90), -2, 1], 0, None, False),
        ([1, 0, -2, 0, 1], 0, None, False),
        ([1 + F(1, 2**90), 0, -2, 0, 1], 0, None, True),
        ([1, 0, 0, 0, 1], 0, None, True),
        ([4, -4, 1], 3, None, True),
        ([4, -4, 1], 2, None, False),
        ([4, -4, 1], 1, None, False),
        ([1, -3, 0, 1], 0, None, False),
        ([4, -3, 0, 1], 0, None, True),
        ([1, -1], 0, 1, False),
        ([1, -1], 0, F(9, 10), True),
        ([1, -2, 1], 0, 2, False),
        ([1, -2, 1], 0, F(9, 10), True),
        ([1, -2, 1], F(11, 10), 2, True),
        ([3, -4, 1], F(5, 4), F(11, 4), False),
        ([-3, 4, -1], F(5, 4), F(11, 4), True),
        ([-3, 4, -1], F(5, 4), None, False),
        ([-3, 4, -1], F(1, 2), F(11, 4), False),
        ([1, 0, -1], 0, F(1, 2), True),
        ([1, -3, 0, 5], 0, F(1, 4), True),
        ([6, -17, 12], 0, 1, False),
        ([5, -9, 4, 2], 0, F(3, 4), True),
        ([1], 0, 5, True),
        ([F(25, 2), 0, 0, -2, *[0] * 36, F(4, 2**40)], 0, 2, False),  # 1/2 at 2, and -0.7 at 1.9
        ([0], 0, 5, False),
    ],
)
def test_signs_on_an_interval(p, low, high, holds):
    assert exact.positive(list(map(F, p)), F(low), None if high is None else F(high)) is holds


def in_s(p):
    """An ascending polynomial in s as a form."""
    return sum((real(c) * exact.S**i for i, c in enumerate(p)), start=Form())


def test_stability_is_that_of_the_roots():
    for _ in range(150):
        p, stable = [rational() or F(-2)], True
        for _ in range(CHANCE.randint(0, 3)):
            a = F(CHANCE.randint(-1, 6), 3)
            p, stable = times(p, [a, 1]), stable and a > 0
        for _ in range(CHANCE.randint(0, 2)):
            a, b = F(CHANCE.randint(-1, 6), 3), F(CHANCE.randint(0, 6), 2)
            p, stable = times(p, [b, a, 1]), stable and a > 0 and b > 0
        assert exact.hurwitz(in_s(p)) is stable, p
    assert not exact.hurwitz(Form())
    assert exact.hurwitz(real(-3))
    assert exact.hurwitz(in_s([1, 1]))
    # Routh's row of zeros: (s^2 + 1)(s + 1)
    assert not exact.hurwitz(in_s([1, 1, 1, 1]))
    # s^3 + s^2 + 2 s + c is stable for 0 < c < 2
    for c, stable in ((0, False), (F(1, 2**80), True), (2 - F(1, 2**80), True), (2, False), (2 + F(1, 2**80), False)):
        assert exact.hurwitz(in_s([c, 2, 1, 1])) is stable
        assert exact.hurwitz(in_s([-c, -2, -1, -1])) is stable


# -- matrices ----------------------------------------------------------------------------------------------------------


def encloses(X, rows):
    """Whether the ball contains the exact matrix, in the infinity norm."""
    unit = F(1, 2**X.bits)
    return (
        max(
            sum(abs(F(x) * unit - F(int(v.p), int(v.q))) for x, v in zip(row, other, strict=True))
            for row, other in zip(X.rows, rows.tolist(), strict=True)
        )
        <= X.error * unit
    )


def any_matrix(n, m):
    return [[rational() for _ in range(m)] for _ in range(n)]


def test_balls_contain_sums_and_products():
    for _ in range(20):
        A, B, C = any_matrix(3, 3), any_matrix(3, 2), any_matrix(3, 2)
        X, Y, Z = (balls.ball(M, 20) for M in (A, B, C))
        assert (X.error, Y.error, X.bits) == (3, 2, 20)
        assert encloses(X, flint_matrix(A))
        P, Q, R = balls.product(X, Y), balls.plus(Y, Z), balls.plus(Y, Z, -1)
        assert encloses(P, flint_matrix(A) * flint_matrix(B))
        assert encloses(Q, flint_matrix(B) + flint_matrix(C))
        assert encloses(R, flint_matrix(B) - flint_matrix(C))
        assert Q.error == R.error == 4
        x, y = balls.norm(X), balls.norm(Y)
        assert x == max(sum(map(abs, row)) for row in X.rows) + 3
        assert x * 2 + 3 * y <= (P.error - 3) * 2**20 + 2**20  # |X| e_Y + e_X |Y| and the rounding
        assert P.error <= (x * 2 + 3 * y >> 20) + 3
    # errors that the factors bring are not lost: (1 +- 1/2)(2 +- 1) lies within 2 +- 2.5
    half = Ball([[2]], 1, 1)
    assert balls.product(half, Ball([[4]], 2, 1)).error * F(1, 2) >= F(5, 2)
    with pytest.raises(Rejected, match="too large"):
        balls.product(Ball([[2**33]], 0, 2), Ball([[2**33]], 0, 2))
    assert balls.product(Ball([[2**29]], 0, 2), Ball([[2**29]], 0, 2)).rows == [[2**56]]
    few, whole = [[0] * 4 + [3], [0] * 5, [5, 0, 0, 7, 0], [1, 2, 3, 0, 0]], [[i, i * i + 1] for i in range(5)]
    rows = [[sum(map(operator.mul, row, column)) >> 1 for column in zip(*whole, strict=True)] for row in few]
    assert balls.product(Ball(few, 0, 1), Ball(whole, 0, 1)).rows == rows


def test_exponentials_lie_in_their_balls():
    before = ctx.prec
    ctx.prec = 600
    try:
        for n, t, bits in ((1, F(1), 60), (2, F(1, 3), 64), (3, F(5, 2), 100), (2, F(-7, 3), 80), (2, F(40), 128)):
            G = any_matrix(n, n)
            E = balls.exponential(G, t, bits)
            scaled = arb_mat([[arb(fmpq((v * t).numerator, (v * t).denominator)) for v in row] for row in G]).exp()
            unit = arb(2) ** -bits
            far = [sum((abs(scaled[i, j] - arb(E.rows[i][j]) * unit) for j in range(n)), arb(0)) for i in range(n)]
            assert all(x <= E.error * unit for x in far)
            # and the error is that of some hundred roundings, carried along by the norm
            assert E.error < 2**40 * balls.norm(E) // 2 ** (bits - 20)
    finally:
        ctx.prec = before
    assert balls.exponential([[F(0)]], F(1), 64).rows[0][0] == 2**64
    with pytest.raises(Rejected, match="too large"):
        balls.exponential([[F(2**60)]], F(1), 64)


def test_norms_and_units():
    assert balls.size([[F(1), F(-2)], [F(0), F(1, 2)]]) == 3
    assert balls.identity(2, 3) == [[1, 0, 0], [0, 1, 0]]
    assert balls.identity(2) == [[1, 0], [0, 1]]
    assert balls.dot([1, 2, 3], [4, 5, 6]) == 32


def lower(M):
    return [row[: i + 1] for i, row in enumerate(M)]


def minors(M):
    return [flint_matrix([row[:k] for row in M[:k]]).det() for k in range(1, len(M) + 1)]


def test_positive_definite_by_the_minors():
    yes = 0
    for _ in range(150):
        n = CHANCE.randint(1, 4)
        B = [[CHANCE.randint(-6, 6) for _ in range(n)] for _ in range(n)]
        shift = CHANCE.randint(-3, 3)
        M = [[sum(B[k][i] * B[k][j] for k in range(n)) + shift * (i == j) for j in range(n)] for i in range(n)]
        holds = all(m > 0 for m in minors(M))
        assert balls.positive_definite(lower(M)) is holds
        yes += holds
    assert 40 < yes < 140


def test_positive_definite_close_to_the_edge_and_in_any_scale():
    for bits in (10, 40, 100, 200):
        one = 2**bits
        assert balls.positive_definite([[one], [one, one + 1]])
        assert not balls.positive_definite([[one], [one, one]])
        assert not balls.positive_definite([[one], [one + 1, one]])
        assert balls.positive_definite([[one], [one - 1, one]])
        assert balls.positive_definite([[one**3], [0, 1]])
        assert balls.positive_definite([[1], [0, one**3], [0, 0, one]])
        # the third row depends on the first two
        assert not balls.positive_definite([[2 * one], [one, 2 * one], [3 * one, 3 * one, 6 * one]])
        assert balls.positive_definite([[2 * one], [one, 2 * one], [3 * one, 3 * one, 6 * one + 1]])
    for M in ([[0]], [[-1]], [[1], [0, 0]], [[1], [0, -1]], [[0], [0, 1]], [[1], [2, 3]], [[-1], [0, -1]]):
        assert not balls.positive_definite(M)
    assert balls.positive_definite([])


def test_positive_definite_is_undecided_too_close_to_the_edge():
    one = 2**1000
    assert not balls.positive_definite([[one], [one, one + 1]])
    assert balls.positive_definite([[one], [one, one + 2**600]])
    assert not balls.positive_definite([[2**700], [2**700, 2**700 + 1]])


# -- ranges of frequency -----------------------------------------------------------------------------------------------


def cosine(*p, tau=1):
    """p(omega) cos(tau omega), as the real part of a form."""
    return Form({(F(tau), n): (F(c), F(0)) for n, c in enumerate(p) if c})


def sine(*p, tau=1):
    return Form({(F(tau), n): (F(0), F(c)) for n, c in enumerate(p) if c})


@pytest.mark.parametrize(
    ("form", "a", "b", "order", "holds"),
    [
        (real(1) + cosine(1), 0, 3, 20, True),
        (real(1) + cosine(1), 0, F(16, 5), 20, False),  # touches 0 at pi
        (real(F(99, 100)) + cosine(1), 0, 3, 20, True),  # cos 3 = -0.98999
        (real(F(98, 100)) + cosine(1), 0, 3, 20, False),
        (sine(1), F(1, 10), 3, 24, True),
        (sine(1), 3, F(22, 7), 24, False),  # pi < 22/7
        (sine(1), 3, F(333, 106), 24, True),  # 333/106 < pi
        (sine(-1), F(22, 7), 6, 24, True),
        (sine(1, tau=-1), F(22, 7), 6, 24, True),
        (cosine(1, tau=F(1, 2)), 0, F(333, 106), 24, True),
        (cosine(1, tau=F(1, 2)), 0, F(22, 7), 24, False),
        (cosine(0, 1) + real(0, 0, 1), F(1, 10), 3, 24, True),  # x (cos x + x)
        (sine(0, 0, 1) + real(1), 0, 3, 24, True),
        (sine(0, -1) + real(1), 0, F(11, 10), 24, True),  # x sin x = 1 at 1.11416
        (sine(0, -1) + real(1), 0, F(112, 100), 24, False),
        (real(1) + cosine(1, tau=2) + sine(1), F(1, 3), 2, 30, True),
        (real(1, -1), 0, F(1, 2), 2, True),
        (real(1, -1), 0, 1, 2, False),
        (real(1, -1), F(1, 2), F(1, 2), 2, True),
        (cosine(1), 0, 1, 2, False),  # an order too small: 1 - 4 t^2/2
        (cosine(1), 0, F(1, 2), 4, True),
        # 1/6 + cos 2t against 7/6 - 2 t^2 - 4 (2 t)^3/3! at t = 1/2, which is 0
        (real(F(1, 6)) + cosine(1, tau=2), 0, F(1, 2), 3, False),
        (real(F(1, 6) + F(1, 10**9)) + cosine(1, tau=2), 0, F(1, 2), 3, True),
    ],
)
def test_signs_of_sines_and_cosines_on_a_box(form, a, b, order, holds):
    assert balls.box(form, F(a), F(b), order) is holds


def test_in_the_critical_case_a_box_is_over_omega_squared():
    # omega^2 (1 + omega): 0 at 0, and positive over omega^2
    form = real(0, 0, 1, 1)
    assert balls.box(form, F(0), F(1), 4, True)
    assert not balls.box(form, F(0), F(1), 4, False)
    assert not balls.box(real(0, 1), F(0), F(1), 4, True)
    assert not balls.box(real(0, 0, 0, 1), F(0), F(1), 4, True)
    assert not balls.box(real(0, -1, 5), F(0), F(1), 4, True)
    assert balls.box(form, F(1), F(2), 4, True)
    assert balls.box(real(1, 0, 1), F(0), F(1), 4, True)


@pytest.mark.parametrize(
    ("form", "start", "degree", "holds"),
    [
        (real(1, 0, 1), 0, 2, True),
        (real(1, 0, 1), 0, 4, False),
        (real(-1, 0, 1), 2, 2, True),
        (real(-1, 0, 1), 1, 2, False),
        (real(-1, 0, 1), F(1, 2), 2, False),
        (real(0, 0, 1) + cosine(F(99, 100)), 1, 2, True),
        (real(0, 0, 1) + cosine(1), 1, 2, False),
        (real(0, 0, 1) + cosine(0, 0, F(99, 100)), 1, 2, True),
        (real(0, 0, 1) + cosine(0, 0, 1), 1, 2, False),
        (real(0, 0, 1) + cosine(0, 0, F(1, 2)) + cosine(0, 0, F(49, 100), tau=2), 1, 2, True),
        (real(0, 0, 1) + cosine(0, 0, F(1, 2)) + cosine(0, 0, F(1, 2), tau=2), 1, 2, False),
        (real(0, 0, 1) + cosine(0, 0, F(9, 10)) + cosine(0, 0, F(9, 100), tau=2), 1, 2, True),
        (real(0, 0, 1) + cosine(0, 0, F(3, 5)) + sine(0, 0, F(3, 5)), 1, 2, True),  # |0.6 + 0.6 i| < 1
        (real(0, 0, 1) + cosine(0, 0, F(3, 4)) + sine(0, 0, F(3, 4)), 1, 2, False),
        (real(0, 0, 1) + cosine(0, 1), F(9, 8), 2, True),
        (real(0, 0, 1) + cosine(0, 1), F(7, 8), 2, False),
        (cosine(0, 0, 1), 1, 2, False),
        (real(0, 0, -1) + cosine(0, 0, F(1, 2)), 1, 2, False),
    ],
)
def test_the_part_without_delay_prevails_far_out(form, start, degree, holds):
    assert balls.tail(form, F(start), degree) is holds


# -- functions on an interval
def modelled(model, x):
    u, v = (sum(c * x**k for k, c in enumerate(side)) for side in (model.u, model.v))
    return complex(u / 2**balls.WORD, v / 2**balls.WORD)


def test_the_errors_of_models_add_up():
    Model, one = balls.Model, 2**balls.WORD
    assert Model([1], [2], 3) + Model([4, 1], [5], 6) == Model([5, 1], [7], 9)
    # 1 5 + 3 (1 + 5) units of 2^-WORD, one for the last bit, and one for each coefficient that is cut
    assert Model([one], [], 3) * Model([one], [], 5) == Model([one], [], 8 + 1 + 2 * balls.TERMS)
    assert (Model([one], [], 3) * Model([], [one], 5)).v == [one]
    assert (Model([], [one], 0) * Model([], [one], 0)).u == [-one]
    assert Model([one], [one, -one], 7).most() == 3 * one
    assert Model([one], [one], 7).conjugate() == Model([one], [-one], 7)
    assert Model([2**70, 5, -6], [2**63], 1).short() == Model([2**70], [], 1 + 5 + 6 + 2**63)
    long = Model([one] * balls.TERMS, [], 0)
    assert (long * Model([0, one], [], 0)).off >= one  # what is beyond the last coefficient


@pytest.mark.parametrize("pace", [None, F(1, 3)])
@pytest.mark.parametrize("halvings", [0, 3, 500])
def test_a_form_is_lifted_to_an_interval(pace, halvings):
    form = Form({(F(0), 0): (F(1, 3), F(-2)), (F(0), 3): (F(-1), F(1, 7))})
    form = form + Form({(F(1, 2), 1): (F(2), F(1, 5)), (F(3), 0): (F(-1, 2), F(4))})
    model = balls.Lift(F(1, 2), F(9, 4), pace)(form, halvings)
    assert 0 < model.off < 2 ** (balls.WORD - 60 if halvings < 9 else balls.WORD)
    for x in (-1.0, -0.3, 0.0, 0.7, 1.0):
        omega = 11 / 8 + 7 / 8 * x
        exact_value = sum(
            complex(*map(float, z)) * omega**n * cmath.exp((float(pace or 0) - 1j * omega) * float(tau))
            for (tau, n), z in form.items()
        )
        assert modelled(model, x) * 2.0**halvings == pytest.approx(exact_value, rel=1e-9, abs=2.0 ** (halvings - 380))


def test_far_out_what_comes_late_is_a_number_of_unknown_phase():
    # (2 omega^2 + 1)/omega^2 + e^(a tau) (3 + 4 i) omega/omega^2 from omega = 5 on: at most 7/5 e^(1/2) off
    form = Form({(F(0), 2): (F(2), F(0)), (F(0), 0): (F(1), F(0)), (F(2), 1): (F(3), F(4))})
    model = balls.outward(form, F(5), 2, F(1, 4))
    assert model.off / 2**balls.WORD == pytest.approx(7 / 5 * math.exp(0.5), rel=1e-12)
    for x in (-1.0, 0.2, 1.0):  # 1/omega is between 0 and 1/5
        assert modelled(model, x) == pytest.approx(2 + (0.1 + x / 10) ** 2)
    with pytest.raises(Rejected):
        balls.outward(form, F(5), 1, F(1, 4))


def test_what_vanishes_at_0_is_divided_by_s():
    # chi = s^2 + 3 s + 1 - e^(-s), over s: s + 3 + (1 - e^(-s))/s, which is 1 up to b/2
    turned = Form({(F(0), 2): (F(0), F(1)), (F(0), 1): (F(3), F(0)), (F(0), 0): (F(0), F(-1)), (F(1), 0): (F(0), F(1))})
    model = balls.over_s(turned, F(1, 8), 1)  # chi/i
    assert model.off / 2**balls.WORD == pytest.approx(1 / 16, rel=1e-9)
    for x in (-0.9, 0.0, 1.0):
        s = 1j * (1 + x) / 16
        assert abs(modelled(model, x) - (s * s + 3 * s + 1 - cmath.exp(-s)) / s) <= model.off / 2**balls.WORD
        assert modelled(model, x) == pytest.approx(s + 4)
