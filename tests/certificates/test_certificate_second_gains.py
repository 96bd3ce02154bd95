"""Lyapunov matrices, gains, orders of samples and rods of the second checker, sharp from both sides."""

from dataclasses import replace
from fractions import Fraction as F
from itertools import permutations, product
from types import SimpleNamespace

import pytest
from flint import arb, arb_mat, fmpq, fmpq_mat, fmpq_poly
from second_plants import PLAIN, asked, assert_accepted_if, at, poly, rational, transfer

from lure.analysis.certificates.second import gains, matrix, structure, theorems
from lure.analysis.certificates.second.channel_gains import require_gains
from lure.analysis.certificates.second.classes import AT_REST, BOUNDED, EQUILIBRIA, SQUARE_INTEGRABLE, Claim
from lure.analysis.certificates.second.numerics import (
    ball,
    to_fmpq,
    working_precision,
)
from lure.analysis.certificates.second.orbits import Stay, Watched, _Equations, require_periodic
from lure.analysis.certificates.second.order import _steps, require_positive_on_orders, strictly_copositive
from lure.analysis.certificates.second.reading import NotShown
from lure.analysis.certificates.second.systems import (
    Delayed,
    RodData,
)

ONE, Z = fmpq_poly([1]), fmpq_poly([0, 1])


# Lyapunov matrices


@pytest.mark.parametrize("discrete", [False, True])
def test_the_form_is_what_v_falls_by(discrete):
    A, b, c, rho, w = ((F(-1), F(2)), (F(1, 3), F(-4))), (F(1), F(1, 2)), (F(3), F(-1)), F(2), F(5)
    D, theta = F(1, 7), F(0) if discrete else F(2, 3)
    rows, x, mu = [[5, 1], [1, 3]], [F(2), F(-1)], F(3)
    state = matrix.State(A=A, b=b, c=c, direct=D, rho=rho)

    def form(v):
        return sum(rows[i][j] * v[i] * v[j] for i, j in product(range(2), repeat=2))

    moved = [sum(a * v for a, v in zip(row, x, strict=True)) + k * mu for row, k in zip(A, b, strict=True)]
    sigma = sum(k * v for k, v in zip(c, x, strict=True)) + D * mu
    if discrete:  # and (xi + rho mu)^2/rho - xi^2/rho - 2 mu xi, of sigma, = rho mu^2
        rise = form(moved) - form(x) + rho * mu**2
    else:
        rise = 2 * sum(rows[i][j] * x[i] * moved[j] for i, j in product(range(2), repeat=2))
        rise += 2 * theta * -mu * (sum(k * v for k, v in zip(c, moved, strict=True)) + rho * mu)
    with working_precision(128):
        M = matrix._form(state, arb_mat(rows), 1 / w, theta, discrete=discrete)
        z = arb_mat([[ball(v)] for v in (*x, mu)])
        assert (z.transpose() * M * z)[0, 0].contains(to_fmpq(-rise + 2 * mu * (sigma + mu / w)))
        assert (M - M.transpose()).contains(arb_mat(3, 3))


@pytest.mark.parametrize(("discrete", "rate"), [(False, 0), (True, 1)])
def test_without_its_eigenvalue_0_a_plant_has_the_rest_of_its_response(discrete, rate):
    # A = rate + [[-1, 1], [2, -2]]: right vector (1, 1), left one (2, 1), residue (c x0)(l b)/3
    A, b, c = ((F(rate - 1), F(1)), (F(2), F(rate - 2))), (F(1), F(1, 2)), (F(3), F(-1))
    state = matrix.State(A=A, b=b, c=c, direct=F(1, 7), rho=F(0))
    zero = {"right": ["1", "1"], "left": ["2", "1"], "pivot": 1}
    found, s = matrix._deflated(state, zero, discrete=discrete), fmpq(5)
    assert (found.rho, found.direct) == (F(2) * F(5, 2) / 3, F(1, 7))

    def response(one):
        sides = [[to_fmpq(v) for v in row] for row in one.A], [[to_fmpq(v)] for v in one.b], [list(map(to_fmpq, one.c))]
        return at((*map(fmpq_mat, sides), fmpq_mat([[0]])), s)[0, 0]

    assert response(found) + to_fmpq(found.rho) / (s - rate) == response(state)
    for change in (
        {"right": ["1", "2"]},
        {"left": ["1", "1"]},
        {"pivot": 2},
        {"right": ["0", "0"]},
        {"left": ["0", "0"]},
    ):
        with pytest.raises(NotShown):
            matrix._deflated(state, zero | change, discrete=discrete)
    with pytest.raises(NotShown):
        matrix._deflated(state, zero, discrete=not discrete)
    twice = matrix.State(A=((F(rate), F(1)), (F(0), F(rate))), b=b, c=c, direct=F(0), rho=F(0))
    with pytest.raises(NotShown, match="not simple"):
        matrix._deflated(twice, {"right": ["1", "0"], "left": ["0", "1"], "pivot": 0}, discrete=discrete)


# 1 - k/n times ones has the eigenvalues 1 and 1 - k, so that no entry and no diagonal block shows it
@pytest.mark.parametrize("n", [2, 6, 7, 13])
@pytest.mark.parametrize(("k", "definite"), [(F(99, 100), True), (F(1), False), (F(101, 100), False)])
def test_a_full_matrix_is_definite_where_its_least_eigenvalue_says(n, k, definite):
    with working_precision(128):
        M = arb_mat([[ball(int(i == j) - k / n) for j in range(n)] for i in range(n)])
        assert matrix.positive_definite(M) is definite


# x' = a x + mu, sigma = x: V = p x^2 falls by (x, mu) [[-2 a p, 1 - p + a theta], [., 2/w + 2 theta]] (x, mu)
@pytest.mark.parametrize(
    ("a", "P", "w", "theta", "exponent", "holds"),
    [
        (-1, "1", F(9), 0, 0, True),
        (-1, "4", F(16, 9), 0, 0, False),  # 16/w against 9
        (-1, "4", F(16, 10), 0, 0, True),
        (-1, "4", F(16, 9), 0, 1, True),  # of P = 2
        (-1, "1", F(16, 9), 0, -2, False),
        (-1, "1", F(9), F(4), 0, True),  # theta^2 against 2 (2/9 + 2 theta)
        (-1, "1", F(9), F(9, 2), 0, False),
        (-1, "1", F(9), F(-1, 10), 0, True),
        (-1, "1", F(9), F(-1, 9), 0, False),
        (1, "-1", F(1, 2), 0, 0, False),  # it falls, and is negative
        (1, "1", F(1, 2), 0, 0, False),
        (-1, "1", F(9), 0, 10**7, False),
    ],
)
def test_a_matrix_of_one_state_is_sharp(a, P, w, theta, exponent, holds):
    proof = {"method": "matrix", "P": [[P]], "exponent": exponent, "zero": None}
    claim, given = Claim.of(replace(PLAIN, upper=w, slope=None)), rational([[a]], [1], [1])
    with assert_accepted_if(holds):
        assert matrix.require_matrix(given, claim, F(theta), proof) == "stable"
    if theta:
        with pytest.raises(NotShown, match="continuous time"):
            matrix.require_matrix(replace(given, discrete=True), claim, F(theta), proof)


@pytest.mark.parametrize(("b", "case"), [("1/2", "critical"), ("-1/2", None), ("0", None)])
def test_an_integrator_alone_has_a_positive_residue(b, case):
    zero = {"right": ["1"], "left": ["1"], "pivot": 0}
    with assert_accepted_if(case is not None):
        proof = {"method": "matrix", "P": [], "exponent": 0, "zero": zero}
        assert matrix.require_matrix(rational([[0]], [b], [1]), Claim.of(PLAIN), F(0), proof) == case


@pytest.mark.parametrize(
    ("discrete", "pole", "gain", "P", "start", "holds"),
    [
        (False, 1, "0", "-1", "1", True),
        (False, 1, "1/2", "-1", "1", True),
        (False, 1, "1", "-1", "1", False),
        (False, 1, "3/2", "-1", "1", False),
        (False, 1, "0", "1", "1", False),
        (False, 1, "0", "-1", "0", False),
        (False, 3, "5/2", "-1", "1", False),  # a gain beyond the class
        (True, 2, "1/2", "-1", "1", True),
        (True, 2, "3/2", "-1", "1", False),
        (True, -2, "1/2", "-1", "1", True),
    ],
)
def test_a_form_that_is_negative_and_falls_shows_growth(discrete, pole, gain, P, start, holds):
    one = replace(PLAIN, upper=F(2), slope=None)
    proof = {"method": "matrix-gain", "gain": gain, "P": [[P]], "start": [start]}
    with assert_accepted_if(holds):
        matrix.require_growth(rational([[pole]], [1], [1], discrete=discrete), one, proof)


# Gains


@pytest.mark.parametrize(
    ("n", "d", "lower", "upper", "discrete", "holds"),
    [
        ("1", "1 3 3 1", 0, F(799, 100), False, True),
        ("1", "1 3 3 1", 0, F(8), False, False),
        ("1", "1 3 3 1", 0, F(801, 100), False, False),
        ("1", "1 3 3 1", F(-1), F(1), False, False),
        ("1", "1 3 3 1", F(-99, 100), F(1), False, True),
        ("1", "1 1 1", 0, "finite", False, True),
        ("1", "1 1 1", 0, "inf", False, True),
        ("1 -1", "1 3 2", 0, "finite", False, False),
        ("-1", "1 1", 0, F(99, 100), False, True),
        ("-1", "1 1", 0, F(1), False, False),
        ("-1 0", "2 1", 0, F(199, 100), False, True),  # 1 + g H(inf) = 1 - g/2
        ("-1 0", "2 1", 0, F(2), False, False),
        ("1", "1 -1/2", 0, F(149, 100), True, True),
        ("1", "1 -1/2", 0, F(3, 2), True, False),
        ("0", "1 1", 0, F(5), False, True),
        ("0", "1 1", 0, "inf", False, False),
        ("1 0", "1 3 2", 0, "inf", False, True),
    ],
)
def test_up_to_which_gain_every_one_is_stable(n, d, lower, upper, discrete, holds):
    one = replace(PLAIN, lower=F(lower), upper=upper, slope=None, linear=True)
    with assert_accepted_if(holds):
        gains.require_every_gain_stable(transfer(n, d, discrete=discrete), one)
    with pytest.raises(NotShown, match="not linear"):
        gains.require_every_gain_stable(transfer(n, d, discrete=discrete), replace(one, linear=False))


@pytest.mark.parametrize(
    ("test", "crossings", "strict", "holds"),
    [
        (poly(1), poly(), True, True),
        (poly(1, -1), poly(), True, False),
        (poly(1), poly(), False, False),
        (poly(1, -1), poly(-1, 2), True, True),  # at 0 and 1/2
        (poly(1, -1), poly(-2, 1), True, False),
        (poly(1, -1), poly(-1, 1), True, False),
        (poly(1, -1), poly(-1, 1), False, True),
        (poly(0, 1), poly(-1, 1), True, False),
        (poly(0, 1), poly(-1, 1), False, True),
        (poly("-1/2", 1), poly(-1, 1), False, False),
        (poly(1, -1), poly(-1, 1) * poly(-2, 1), False, False),
        (poly(1, -1), poly(-1, 1) ** 2 * poly(-1, 2), False, True),
        (poly(), poly(-1, 1), True, False),
        (poly(), poly(-1, 1), False, True),
    ],
)
def test_at_every_crossing_the_gain_is_smaller(test, crossings, strict, holds):
    assert gains._at_crossings(test, crossings, strict=strict) is holds


@pytest.mark.parametrize(
    ("n", "d", "gain", "discrete", "kind"),
    [
        ("1", "1 3 3 1", 8, False, "no rest"),
        ("1", "1 3 3 1", 9, False, "no rest"),
        ("1", "1 3 3 1", 7, False, None),
        ("1", "1 3 3 1", -1, False, "equilibria"),
        ("1", "1 0 0", 0, False, "no rest"),
        ("1", "1 0 1 0", 0, False, "no rest"),
        ("1", "1 -1 0", 0, False, "no rest"),
        ("-1 0", "1 1", 1, False, None),
        ("1", "1 -1/2", F(-1, 2), True, "equilibria"),
        ("1", "1 -1/2", F(3, 2), True, "no rest"),
        ("1", "1 -1/2", F(2), True, "no rest"),
        ("1", "1 -1/2", 1, True, None),
    ],
)
def test_what_a_gain_does(n, d, gain, discrete, kind):
    with assert_accepted_if(kind is not None):
        assert gains.unstable_kind(transfer(n, d, discrete=discrete), F(gain)) == kind


@pytest.mark.parametrize(
    ("n", "d", "lower", "upper", "critical"),
    [
        ("1", "1 0", 0, F(1), True),
        ("-1", "1 0", 0, F(1), False),
        ("1", "1 1", 0, F(1), False),
        ("1", "1 1", F(-1), F(1), True),
        ("-1", "1 1", 0, F(1), True),  # -phi with -H, from the upper end on
        ("1", "1 -1", F(-1), F(1), False),
        ("1", "1 1", F(-2), F(-1), False),
        ("-1", "1 1", F(1), F(2), False),
        ("1", "1 0 0", 0, F(1), False),
        ("1 0", "-1 1", 1, F(2), False),  # 1 + g H(inf) = 0 at the lower end
    ],
)
def test_an_end_of_the_class_may_be_its_critical_case(n, d, lower, upper, critical):
    one = replace(PLAIN, lower=F(lower), upper=upper, slope=None)
    assert gains.critical_end(transfer(n, d), one) is critical


# 8/(s + 1)^3 has the root i 3^(1/2) at the gain 1; 1/(z - 1/2)^2 roots at z^2 - z + 1/4 + 3/4, cos w = 1/2
@pytest.mark.parametrize(
    ("loop", "gains_", "band", "holds"),
    [
        ("lag", (F(9, 10), F(11, 10)), (F(17, 10), F(18, 10)), True),
        ("lag", (F(9, 10), F(11, 10)), (F(18, 10), F(19, 10)), False),
        ("lag", (F(9, 10), F(11, 10)), (F(16, 10), F(17, 10)), False),
        ("lag", (F(9, 10), F(99, 100)), (F(17, 10), F(18, 10)), False),
        ("lag", (F(101, 100), F(11, 10)), (F(17, 10), F(18, 10)), False),
        ("lag", (F(11, 10), F(9, 10)), (F(17, 10), F(18, 10)), False),
        ("lag", (F(9, 10), F(11, 10)), (F(18, 10), F(17, 10)), False),
        ("lag", (F(9, 10), F(11, 10)), (F(-18, 10), F(-17, 10)), False),
        ("samples", (F(7, 10), F(8, 10)), (F(104, 100), F(105, 100)), True),
        ("samples", (F(7, 10), F(74, 100)), (F(104, 100), F(105, 100)), False),
        ("samples", (F(76, 100), F(8, 10)), (F(104, 100), F(105, 100)), False),
        ("samples", (F(7, 10), F(8, 10)), (F(105, 100), F(106, 100)), False),
        ("samples", (F(7, 10), F(8, 10)), (F(523, 100), F(524, 100)), False),  # 2 pi less
        ("quick", (F(7, 10), F(8, 10)), (F(296, 100), F(297, 100)), True),  # cos w = -197/200
        ("quick", (F(7, 10), F(8, 10)), (F(331, 100), F(332, 100)), False),  # beyond pi, where it is again
        ("small", (F(1, 10), F(1100)), (F(17, 10), F(18, 10)), True),
        ("small", (F(1, 10), F(1100)), (F(18, 10), F(19, 10)), False),
        ("late", (F(157, 100), F(158, 100)), (F(157, 100), F(158, 100)), True),
        ("late", (F(157, 100), F(15707, 10000)), (F(157, 100), F(158, 100)), False),
        ("late", (F(157, 100), F(158, 100)), (F(1571, 1000), F(158, 100)), False),
    ],
)
def test_a_gain_of_the_range_has_a_root_in_the_band(loop, gains_, band, holds):
    plant = {
        "lag": transfer("8", "1 3 3 1"),
        "small": transfer("1/100", "1 3 3 1"),
        "samples": transfer("1", "1 -1 1/4", discrete=True),
        "quick": transfer("1", "1 197/100 1/4", discrete=True),
        "late": Delayed(terms=((F(1), ONE),), d=Z),  # s + g exp(-s): pi/2
    }[loop]
    with assert_accepted_if(holds):
        gains.require_crossing(plant, gains_, band)


# Orders of samples


@pytest.mark.parametrize(("samples", "odd"), [(1, False), (2, False), (3, False), (2, True)])
def test_the_steps_between_samples_in_every_order(samples, odd):
    wanted = set()
    for order in permutations(range(samples + 1)):  # the last is 0, first where phi is odd
        if odd and order[0] != samples:
            continue
        place, zero = {point: k for k, point in enumerate(order)}, order.index(samples)
        rows = [[(zero <= j < place[i]) - (place[i] <= j < zero) for j in range(samples)] for i in range(samples)]
        for signs in product((1, -1), repeat=samples) if odd else ((1,) * samples,):
            wanted.add(tuple(tuple(s * v for v in row) for s, row in zip(signs, rows, strict=True)))
    found = list(_steps(samples, odd=odd))
    assert {tuple(map(tuple, rows)) for rows in found} == wanted
    assert len(found) == len(wanted)


@pytest.mark.parametrize(("c", "odd", "holds"), [("-99/100", False, True), ("-1", False, False), ("-1", True, False)])
def test_a_form_of_one_sample_is_positive_where_phi_and_the_rest_agree_in_sign(c, odd, holds):
    with assert_accepted_if(holds):
        require_positive_on_orders([[F(1)], [F(c), F(1)]], odd=odd)
    with pytest.raises(NotShown):
        require_positive_on_orders([[F(1)], [F(c)]], odd=odd)
    with pytest.raises(NotShown, match="1 to 4"):
        require_positive_on_orders([[F(1)]], odd=odd)


# with ones on the diagonal: a, b, c > -1 and 1 + a + b + c + (2 (1 + a) (1 + b) (1 + c))^(1/2) > 0 (K. P. Hadeler)
def test_three_steps_are_copositive_by_hadelers_formula():
    values = [fmpq(k, 10) for k in (-11, -9, -5, -1, 4)]
    for a, b, c in product(values, repeat=3):
        whole, inner = 1 + a + b + c, 2 * (1 + a) * (1 + b) * (1 + c)
        holds = min(a, b, c) > -1 and (whole > 0 or inner > whole * whole)
        assert strictly_copositive(fmpq_mat([[1, a, b], [a, 1, c], [b, c, 1]])) is bool(holds)


# The rod: Z = 6, E/L = 2, |k^2 - Z^2| = 108 for k = 12: theta from 2 108/(12 3 4) = 3/2 on, a circle up to 2 36/108

BAR = RodData(E=F(4), rho=F(1), length=F(2), area=F(3), k=F(12), cells=3)
BAR_CLASS = replace(PLAIN, slope=None)


@pytest.mark.parametrize(
    ("theorem", "rod", "one", "theta", "said"),
    [
        ("rod-energy", {}, {}, None, AT_REST),
        ("rod-energy", {"cells": None}, {"upper": "inf"}, None, AT_REST),
        ("rod-energy", {"k": F(0)}, {}, None, None),
        ("rod-energy", {}, {"time_varying": True}, None, None),
        ("rod-energy", {}, {"rough": True}, None, None),
        ("rod-energy", {}, {"lower": F(-1)}, None, None),
        ("rod-popov", {}, {}, "3/2", EQUILIBRIA),
        ("rod-popov", {"cells": None}, {}, "3/2", AT_REST),
        ("rod-popov", {}, {}, "149/100", None),
        ("rod-popov", {}, {"upper": "finite"}, "3/2", EQUILIBRIA),
        ("rod-popov", {}, {"upper": "inf"}, "3/2", None),
        ("rod-popov", {}, {"upper": "inf"}, "151/100", EQUILIBRIA),
        ("rod-popov", {}, {"time_varying": True}, "3/2", None),
        ("rod-popov", {"k": F(3)}, {}, "3/2", EQUILIBRIA),  # 2 27/(3 3 4)
        ("rod-popov", {"k": F(3)}, {}, "149/100", None),
        ("rod-popov", {"k": F(-12)}, {}, "3/2", None),
        ("rod-circle", {}, {"upper": F(66, 100)}, None, EQUILIBRIA),
        ("rod-circle", {}, {"upper": F(66, 100), "time_varying": True}, None, BOUNDED),
        ("rod-circle", {"cells": None}, {"upper": F(66, 100)}, None, AT_REST),
        ("rod-circle", {"cells": None}, {"upper": F(66, 100), "time_varying": True}, None, SQUARE_INTEGRABLE),
        ("rod-circle", {}, {"upper": F(2, 3)}, None, None),
        ("rod-circle", {}, {"upper": "finite"}, None, None),
        ("rod-circle", {"k": F(3)}, {"upper": F(66, 100)}, None, EQUILIBRIA),  # 2 9/27
        ("rod-circle", {"k": F(3)}, {"upper": F(2, 3)}, None, None),
        ("rod-circle", {"k": F(6)}, {"upper": "finite"}, None, EQUILIBRIA),
        ("rod-circle", {"k": F(6)}, {"upper": "inf"}, None, None),
        ("rod-park", {}, {}, None, None),
    ],
)
def test_what_is_shown_of_a_rod(theorem, rod, one, theta, said):
    given = SimpleNamespace(
        theorem=theorem, proof={"method": "structure"}, multiplier={} if theta is None else {"theta": theta}
    )
    with assert_accepted_if(said is not None):
        assert structure.proved(given, replace(BAR, **rod), replace(BAR_CLASS, **one)) == said


@pytest.mark.parametrize(
    ("k", "one", "holds"),
    [
        (-3, {}, True),
        (-3, {"lower": F(1, 2)}, False),
        (-12, {}, True),
        (-12, {"upper": F(0), "lower": F(-1)}, False),
        (-12, {"lower": F(2), "upper": F(3)}, True),
        (-12, {"lower": F(-2), "slope": (F(-1), F(0)), "upper": F(2)}, False),
        (-12, {"lower": F(-2), "slope": (F(2), F(3)), "upper": F(4)}, True),
        (-12, {"lower": F(0), "slope": (F(0), F(1, 2)), "upper": F(4)}, True),
        (-12, {"upper": "inf"}, True),
        (-12, {"relu": True}, False),
        (-6, {}, False),
        (3, {}, False),
        (0, {}, False),
    ],
)
def test_a_dashpot_that_drives_is_refuted(k, one, holds):
    given = SimpleNamespace(proof={"method": "structure"})
    with assert_accepted_if(holds):
        structure.refuted(given, replace(BAR, k=F(k)), replace(BAR_CLASS, **one))


def test_rods_within_bounds_are_those_of_the_corners():
    ends = [["E", "4", "5"], ["rho", "1", "1"], ["L", "1", "2"], ["A", "3", "3"], ["k", "-1", "12"]]
    family = {"kind": "rod-scheme-family", "parameters": ends, "cells": 3}
    at = {"method": "member", "at": ["4", "1", "2", "3", "0"], "proof": {"method": "structure"}}
    document = theorems.Document(
        verdict="PROVED", system=family, nonlinearities={}, nonlinearity=None, theorem="rod-energy", multiplier={},
        conclusion="", hypotheses={}, proof={},
    )  # fmt: skip
    found = [one.system for one in structure.within_bounds(document)]
    assert len(found) == 8
    assert {(one["E"], one["rho"], one["L"], one["A"], one["k"]) for one in found} == set(
        product("45", "1", "12", "3", ("-1", "12"))
    )
    assert all((one["kind"], one["cells"]) == ("rod-scheme", 3) for one in found)
    (one,) = structure.within_bounds(replace(document, verdict="REFUTED", proof=at))
    assert (one.system["L"], one.system["k"], one.proof) == ("2", "0", {"method": "structure"})
    for place in (["4", "1", "2", "3"], ["3", "1", "2", "3", "0"], ["4", "1", "2", "3", "13"]):
        with pytest.raises(NotShown):
            structure.within_bounds(replace(document, verdict="REFUTED", proof=at | {"at": place}))
    for i, entry in ((0, ["E", "5", "4"]), (0, ["E", "0", "4"]), (3, ["k", "3", "3"])):
        other = [entry if k == i else end for k, end in enumerate(ends)]
        with pytest.raises(NotShown):
            structure.within_bounds(replace(document, system=family | {"parameters": other}))


BARS = [{"E": "4", "rho": "1", "L": "2", "A": "3", "k": "12"}, {"E": "9", "rho": "1", "L": "3", "A": "5", "k": "30"}]


@pytest.mark.parametrize(
    ("arrangement", "bars", "plate", "theorem", "uppers", "changes", "holds"),
    [
        ("one-obstacle", 2, None, "rods-energy", ("1", "1"), {}, True),
        ("one-obstacle", 2, "3", "rods-energy", ("1", "inf"), {}, True),
        ("one-obstacle", 2, "0", "rods-energy", ("1", "1"), {}, False),
        ("one-obstacle", 0, None, "rods-energy", (), {}, False),
        ("one-obstacle", 2, None, "rods-energy", ("1",), {}, False),
        ("both-ends", 1, None, "rods-energy", ("1", "1"), {}, True),
        ("both-ends", 1, "3", "rods-energy", ("1", "1"), {}, False),
        ("both-ends", 2, None, "rods-energy", ("1", "1"), {}, False),
        ("across-gap", 2, None, "rods-energy", ("1",), {}, True),
        ("across-gap", 1, None, "rods-energy", ("1",), {}, False),
        ("in-a-row", 2, None, "rods-energy", ("1", "1"), {}, False),
        ("one-obstacle", 2, None, "rods-circle", ("66/100", "99/100"), {}, True),
        ("one-obstacle", 2, None, "rods-circle", ("2/3", "99/100"), {}, False),
        ("one-obstacle", 2, None, "rods-circle", ("66/100", "1"), {}, False),
        ("one-obstacle", 2, None, "rods-circle", ("66/100", "inf"), {}, False),
        ("one-obstacle", 2, None, "rods-circle", ("66/100", "99/100"), {"time_varying": True}, True),
        ("one-obstacle", 2, None, "rods-circle", ("66/100", "99/100"), {"regularity": "any"}, False),
        ("one-obstacle", 2, None, "rods-energy", ("66/100", "99/100"), {"time_varying": True}, False),
        ("one-obstacle", 2, None, "rods-energy", ("66/100", "99/100"), {"sector": ["-1/9", "1"]}, False),
        ("one-obstacle", 2, None, "rods-energy", ("1", "1"), {"regularity": "any"}, False),
        ("one-obstacle", 2, None, "rods-popov", ("1", "1"), {}, False),
    ],
)
def test_rods_with_several_contacts(arrangement, bars, plate, theorem, uppers, changes, holds):
    plain = {"slope": None, "odd": False, "time_varying": False, "linear": False}
    channels = [{"sector": ["0", upper], **plain, **changes} for upper in uppers]
    document = theorems.Document(
        verdict="PROVED",
        system={"kind": "rods", "arrangement": arrangement, "rods": BARS[:bars], "obstacle": plate},
        nonlinearities={"channels": channels, "repeated": False},
        nonlinearity=None, theorem=theorem, multiplier={}, conclusion="", hypotheses={}, proof={"method": "structure"},
    )  # fmt: skip
    with assert_accepted_if(holds):
        said = SQUARE_INTEGRABLE if theorem == "rods-circle" else structure.claims.PRESSURELESS
        assert structure.rods(document) == said
    with pytest.raises(NotShown):
        structure.rods(replace(document, verdict="REFUTED"))
    if bars:
        worn = [BARS[0] | {"k": "0"}, *BARS[1:bars]]
        with pytest.raises(NotShown):
            structure.rods(replace(document, system={**document.system, "rods": worn}))


# Periodic solutions


def test_the_equations_of_an_orbit_have_their_derivatives():
    G = [
        ((F(0), F(1), F(1, 3)), (F(-1), F(-1, 5), F(2)), (F(0),) * 3),
        ((F(-1), F(2), F(0)), (F(-2), F(0), F(1)), (F(0),) * 3),
    ]
    stays = [Stay(G=g, entry=(F(1), F(k), F(-1, 2)), watched=()) for k, g in enumerate(G)]
    for half in (False, True):
        with working_precision(192):
            equations = _Equations(2, stays, half=half)
            z = [arb(v) for v in (1, 2, -1, 0.5, 0.75, 1.25)]
            values, slopes = equations.at(z)
            first = (arb_mat([[to_fmpq(v) for v in row] for row in G[0]]) * z[4]).exp() * arb_mat([[1], [2], [1]])
            last = (arb_mat([[to_fmpq(v) for v in row] for row in G[1]]) * z[5]).exp() * arb_mat([[-1], [0.5], [1]])
            sign = -1 if half else 1
            wanted = [first[0, 0] + 1, first[1, 0] - 0.5, last[0, 0] - sign, last[1, 0] - 2 * sign, arb(0.5), arb(-1)]
            assert all(values[i, 0].overlaps(v) for i, v in enumerate(wanted))
            step = arb(2) ** -60
            for j in range(6):
                moved = equations.at([v + step * (i == j) for i, v in enumerate(z)])[0]
                for i in range(6):
                    assert abs((moved[i, 0] - values[i, 0]) / step - slopes[i, j]) < arb(2) ** -40


# y' is +-1/2, and what begins or ends at 0 is above or below it
@pytest.mark.parametrize(
    ("speed", "start", "low", "high", "enters", "leaves", "stays"),
    [
        (F(1, 2), F(0), F(0), None, 1, 0, True),
        (F(-1, 2), F(0), F(0), None, 1, 0, False),
        (F(-1, 2), F(0), F(0), None, -1, 0, False),
        (F(1, 2), F(0), F(0), None, 0, 0, False),  # said to begin between the levels
        (F(-1, 2), F(0), None, F(0), -1, 0, True),
        (F(1, 2), F(0), None, F(0), -1, 0, False),
        (F(-1, 2), F(0), None, F(0), 0, 0, False),
        (F(1, 2), F(-1, 2), None, F(0), 0, 1, True),
        (F(1, 2), F(-1, 2), None, F(0), 0, 0, False),
        (F(1, 2), F(-1, 2), None, F(0), 0, -1, False),
        (F(-1, 2), F(1, 2), F(0), None, 0, -1, True),
        (F(-1, 2), F(1, 2), F(0), None, 0, 1, False),
    ],
)
def test_at_both_ends_a_solution_is_on_its_side(speed, start, low, high, enters, leaves, stays):
    one = Watched(row=(F(1), F(0)), low=low, high=high, enters=enters, leaves=leaves)
    with working_precision(128):
        equations = _Equations(1, [Stay(G=((F(0), speed), (F(0), F(0))), entry=one.row, watched=(one,))], half=False)
        begun = arb_mat([[to_fmpq(start)], [1]])
        assert equations.on_its_piece(0, one, begun, arb(1).union(arb(1) + arb(2) ** -90)) is stays


# x_1' = 1 until x_1 = 1, and back: a saw of two stays, beside x_2' = -x_2; x'' = -x has an orbit of every size
def test_an_orbit_is_shown_where_it_is_alone():
    up, down = (((F(0), F(0), v), (F(0), F(-1), F(0)), (F(0),) * 3) for v in (F(1), F(-1)))
    stays = [Stay(G=G, entry=(F(1), F(0), level), watched=()) for G, level in ((up, F(1)), (down, F(-1)))]
    require_periodic(stays, [F(-1), F(0)], [F(2), F(2)], half=False)
    turning = Stay(G=((F(0), F(1), F(0)), (F(-1), F(0), F(0)), (F(0),) * 3), entry=(F(1), F(0), F(0)), watched=())
    for one in ([replace(stays[0], G=down), stays[1]], [turning]):
        with pytest.raises((NotShown, ZeroDivisionError)):
            require_periodic(one, [F(-1), F(0)], [F(2)] * len(one), half=len(one) == 1)
    with working_precision(256):  # a hundredth of the first radius beside the solution, what is found holds it
        for shift in product((-1, 0, 1), repeat=6):
            beside = [v + s * arb(2) ** -135 for v, s in zip((-1, 0, 1, 0, 2, 2), shift, strict=True)]
            found = _Equations(2, stays, half=False).enclosed(beside)
            assert all(one.contains(arb(v)) for one, v in zip(found, (-1, 0, 1, 0, 2, 2), strict=True))
        with pytest.raises(NotShown, match="no periodic orbit"):  # farther away than the last radius
            _Equations(2, stays, half=False).enclosed([v + arb(2) ** -28 for v in (-1, 0, 1, 0, 2, 2)])


# of (1 + i w)^3 + g the imaginary part is positive below 3^(1/2) and the real one negative above, both before for g < 8
LEAF = {"omega": ["1/2", "17/10"], "directions": [["1", "0"], ["0", "1"], ["-1", "0"]]}


@pytest.mark.parametrize(
    ("upper", "tree", "more", "holds"),
    [
        (F(15, 2), LEAF, {}, True),
        (F(77, 10), LEAF, {}, False),  # 3 1.7^2 - 1 = 7.67
        (F(81, 10), LEAF | {"omega": ["1/2", "174/100"]}, {}, False),  # nor above 8 in any way
        (F(79, 10), LEAF | {"omega": ["1/2", "173/100"]}, {}, True),
        (F(79, 10), LEAF | {"omega": ["1/2", "1733/1000"]}, {}, False),
        (F(15, 2), LEAF | {"omega": ["3/5", "17/10"]}, {}, False),
        (F(15, 2), LEAF | {"omega": ["17/10", "1/2"]}, {}, False),
        (F(15, 2), LEAF | {"directions": LEAF["directions"][:2]}, {}, False),
        (F(15, 2), LEAF | {"directions": [*LEAF["directions"][:2], ["-1"]]}, {}, False),
        (F(15, 2), LEAF | {"directions": [["1", "0"], ["0", "1"], ["1", "0"]]}, {}, False),
        (F(15, 2), {"split": [0, "4"], "parts": [LEAF, LEAF]}, {}, True),
        (F(15, 2), {"split": [0, "4"], "parts": [LEAF, LEAF | {"omega": ["3/5", "8/5"]}]}, {}, False),
        (F(15, 2), {"split": [0, "4"], "parts": [LEAF | {"omega": ["3/5", "8/5"]}, LEAF]}, {}, False),
        (F(15, 2), {"split": [0, "4"], "parts": [LEAF]}, {}, False),
        (F(15, 2), {"split": [0, "0"], "parts": [LEAF, LEAF]}, {}, False),
        (F(15, 2), {"split": [0, "15/2"], "parts": [LEAF, LEAF]}, {}, False),
        (F(15, 2), {"split": [1, "4"], "parts": [LEAF, LEAF]}, {}, False),
        (F(15, 2), LEAF, {"linear": False}, False),
        (F(15, 2), LEAF, {"time_varying": True, "rate": F(1)}, False),
        (F(15, 2), LEAF, {"lower": F(-1)}, False),
        (F(15, 2), LEAF, {"upper": "inf"}, False),
    ],
)
def test_boxes_of_gains_keep_to_one_side_at_each_frequency(upper, tree, more, holds):
    one = replace(PLAIN, **({"upper": upper, "slope": None, "linear": True} | more))
    sides = [[-1, 0, 0], [1, -1, 0], [0, 1, -1]], [[1], [0], [0]], [[0, 0, 1]], [[0]]
    document = SimpleNamespace(multiplier={}, proof={"method": "hull", "tree": tree})
    with assert_accepted_if(holds):
        require_gains(document, asked(*sides, one))
    with pytest.raises(NotShown):  # unstable without any gain
        require_gains(document, asked([[1, 0, 0], *sides[0][1:]], *sides[1:], one))
