"""The second checker on Lyapunov matrices and on the rod and its scheme, sharp on both sides of every limit."""

import pytest
from handwritten import (
    AT_REST,
    BOUNDED,
    EQUILIBRIA,
    accepted,
    nonlinearities,
    proved,
    refuted,
    rod,
    state_space,
    transfer,
)

from lure.analysis.certificates.second import recheck


def matrix(rows, zero=None, exponent=0):
    return {"method": "matrix", "P": [[str(v) for v in row] for row in rows], "exponent": exponent, "zero": zero}


# 1/(s + 1), P = p: [[2 p, 1 - p], [., 2/w]] > 0 iff (1 - p)^2 < 4 p/w; w = 8, p = 2: 1 = 1.
def test_a_lyapunov_matrix_of_order_one():
    system = state_space([[-1]], [1], [1])
    assert accepted(proved(system, nonlinearities(0, 7), "circle", {}, matrix([[2]])))
    assert accepted(proved(system, nonlinearities(0, 7, time_varying=True), "circle", {}, matrix([[16]], exponent=3)))
    assert not accepted(proved(system, nonlinearities(0, 8), "circle", {}, matrix([[2]])))
    assert not accepted(proved(system, nonlinearities(0, 8), "circle", {}, matrix([[-1]])))
    assert not accepted(proved(system, nonlinearities(0, 7), "circle", {}, matrix([[2]]), EQUILIBRIA))


# 1/(s (s + 1)) = 1/s - 1/(s + 1), deflated A = -1, b = 1, c = -1, rho = 1, P = 1:
# [[2, theta - 2], [., 2/w]]; theta = 0: w < 1; theta = 2: every finite w.
@pytest.mark.parametrize(
    ("theta", "w", "good"), [(0, "99/100", True), (0, "1", False), (2, "1000000", True), (1, "5", False)]
)
def test_a_lyapunov_matrix_in_the_critical_case(theta, w, good):
    zero = {"right": ["1", "0"], "left": ["1", "1"], "pivot": 0}
    for system in (transfer([1], [1, 1, 0]), state_space([[0, 1], [0, -1]], [0, 1], [1, 0])):
        certificate = proved(
            system, nonlinearities(0, w), "popov", {"theta": str(theta)}, matrix([[1]], zero), EQUILIBRIA
        )
        assert accepted(certificate) is good
        for wrong in ({"right": ["1", "1"]}, {"left": ["1", "0"]}, {"pivot": 1}):
            assert not accepted({**certificate, "proof": matrix([[1]], {**zero, **wrong})})
        assert not accepted({**certificate, "proof": matrix([[1], [0, 1]])})


# 1/(z - 1/2), P = 1: [[3/4, 1/2], [., 2/w - 1]] > 0 iff w < 3/2; 1/(z - 1): 2/w - 1 > 0 iff w < 2.
def test_lyapunov_matrices_in_discrete_time():
    stable = state_space([["1/2"]], [1], [1], time="discrete")
    assert accepted(proved(stable, nonlinearities(0, "149/100"), "circle", {}, matrix([[1]])))
    assert not accepted(proved(stable, nonlinearities(0, "3/2"), "circle", {}, matrix([[1]])))
    integrator, zero = transfer([1], [1, -1], "discrete"), {"right": ["1"], "left": ["1"], "pivot": 0}
    assert accepted(proved(integrator, nonlinearities(0, "199/100"), "circle", {}, matrix([], zero), EQUILIBRIA))
    assert not accepted(proved(integrator, nonlinearities(0, 2), "circle", {}, matrix([], zero), EQUILIBRIA))


# (s + 2)/(s + 1) = 1 + 1/(s + 1) in [1, k]: shifted by 1 it is 1/2 + (1/4)/(s + 3/2); b = c = 1/2 or b = 1, c = 1/4.
def test_the_factor_of_a_direct_term_may_be_on_either_side():
    system = transfer([1, 2], [1, 1])
    for p in ("2", "4", "32"):  # p b = c up to the factor 1/p in P: p = 1 for b = c, 1/4 and 4 for the others
        assert accepted(proved(system, nonlinearities(1, 9), "circle", {}, matrix([[p]], exponent=2)))
    assert not accepted(proved(system, nonlinearities(1, 9), "circle", {}, matrix([["1000000"]])))


# n = 20 equal lags in parallel: A = -I, b = c = 1, P = I: P b = c, so that M = diag(2 .., 2/w) for every w.
def test_a_larger_lyapunov_matrix():
    n = 20
    A = [[-int(i == j) for j in range(n)] for i in range(n)]
    system, P = state_space(A, [1] * n, [1] * n), [[int(i == j) for j in range(i + 1)] for i in range(n)]
    assert accepted(proved(system, nonlinearities(0, 10**9), "circle", {}, matrix(P)))
    P[n - 1][0] = 1  # I + e_n e_1' + e_1 e_n' is singular
    assert not accepted(proved(system, nonlinearities(0, 10**9), "circle", {}, matrix(P)))


# The scheme with k = Z, E = rho = L = A = 1 and one cell: y1' = -y1, y2' = y1 - y2 + 2 mu, z' = y1 + mu, so that
# l = (1, 0, 1), rho = 1, deflated A = [[-1, 0], [1, -1]], b = (0, 2), c = (-1, 0).  With P = theta = 1 the matrix is
# [[2, -1, 0], [-1, 2, -2], [0, -2, 2/w + 2]]: its determinant 6/w - 2 is positive for w < 3.
@pytest.mark.parametrize(("w", "good"), [("299/100", True), ("3", False)])
def test_the_scheme_of_the_rod_by_a_matrix(w, good):
    scheme = {"kind": "rod-scheme", "E": "1", "rho": "1", "L": "1", "A": "1", "k": "1", "cells": 1}
    zero = {"right": ["0", "0", "1"], "left": ["1", "0", "1"], "pivot": 2}
    proof = matrix([[1], [0, 1]], zero)
    certificate = proved(scheme, nonlinearities(0, w), "popov", {"theta": "1"}, proof, EQUILIBRIA)
    assert accepted(certificate) is good
    assert not accepted({**certificate, "system": {**scheme, "E": "2"}})  # sqrt(rho E) is irrational
    assert not accepted({**certificate, "system": {**scheme, "k": "2"}})  # then l is (1, -1/3, 4/3)


STRUCTURE = {"method": "structure"}
RESTING = "every motion of finite energy comes to rest, and the pressure of every contact is square integrable"


# L |k^2 - Z^2|/(k A E) = (36/25 - 1/25000000)/(36/25) = 35999999/36000000 s.
@pytest.mark.parametrize(("theta", "good"), [("35999999/36000000", True), ("35999998/36000000", False)])
def test_popov_for_the_scheme(theta, good):
    certificate = proved(rod(), nonlinearities(0, "finite"), "rod-popov", {"theta": theta}, STRUCTURE, EQUILIBRIA)
    assert accepted(certificate) is good
    assert accepted({**certificate, "laws": nonlinearities(0, 1)}) is good
    assert not accepted({**certificate, "laws": nonlinearities(0, "inf")})
    assert not accepted({**certificate, "system": rod(cells=None)})  # of the rod another sentence follows
    assert accepted({**certificate, "system": rod(cells=None), "conclusion": AT_REST}) is good
    assert not accepted({**certificate, "laws": nonlinearities(-1, 1)})
    assert accepted({**certificate, "laws": nonlinearities(0, "inf"), "multiplier": {"theta": "1"}})


# (E/L) k^2/(Z^2 - k^2) = 11.52/(36/25 - 1/25000000) = 288000000/35999999.
@pytest.mark.parametrize(("k", "good"), [(8, True), ("288000000/35999999", False), ("finite", False)])
def test_the_circle_criterion_for_the_scheme(k, good):
    certificate = proved(rod(), nonlinearities(0, k), "rod-circle", {}, STRUCTURE, EQUILIBRIA)
    assert accepted(certificate) is good
    varying = {**certificate, "laws": nonlinearities(0, k, time_varying=True)}
    assert not accepted(varying)
    assert accepted({**varying, "conclusion": BOUNDED}) is good
    itself = {**varying, "system": rod(cells=None), "conclusion": RESTING}
    assert accepted(itself) is good  # of the rod; the end may stop where a time-varying phi is not 0
    assert not accepted({**itself, "conclusion": AT_REST})
    matched = {
        **certificate,
        "system": rod("6/5"),
        "laws": nonlinearities(0, "finite"),
    }  # k = Z reflects nothing: Re H = 0
    assert accepted(matched)


@pytest.mark.slow
def test_the_energy_of_a_scheme_of_a_hundred_thousand_cells():
    assert recheck(proved(rod(cells=100_000), nonlinearities(0, "inf"), "rod-energy", {}, STRUCTURE, AT_REST)).accepted


@pytest.mark.parametrize("cells", [None, 1, 2, 7])
def test_the_energy_of_the_rod(cells):
    certificate = proved(rod(cells=cells), nonlinearities(0, "inf"), "rod-energy", {}, STRUCTURE, AT_REST)
    assert accepted(certificate)
    for k in ("0", "-1/5000"):
        assert not accepted({**certificate, "system": rod(k, cells=cells)})
    assert not accepted({**certificate, "laws": nonlinearities(0, "inf", time_varying=True)})
    assert not accepted({**certificate, "laws": nonlinearities("-1/10", "inf")})
    assert not accepted({**certificate, "conclusion": EQUILIBRIA})


# Z = 6/5: -Z < k < 0 grows with phi = 0; k < -Z grows with every positive gain.
def test_a_dashpot_that_drives():
    for cells in (None, 10):
        assert accepted(refuted(rod("-1/5000", cells), nonlinearities(0, 1), STRUCTURE))
        assert not accepted(refuted(rod("-1/5000", cells), nonlinearities("1/10", 1), STRUCTURE))
        assert accepted(refuted(rod("-2", cells), nonlinearities("1/10", "inf"), STRUCTURE))
        assert not accepted(refuted(rod("-2", cells), nonlinearities(-1, 0), STRUCTURE))
        for k in ("0", "-6/5", "1"):
            assert not accepted(refuted(rod(k, cells), nonlinearities(0, 1), STRUCTURE))


# 1/(s - 1), P = -1, w = 1/2: M = [[2, 2], [2, 4]] > 0 although nothing is stable; -1/s: corner 2/w > 0, residue -1;
# diag(1, 1/2), b = (1, 1), c = (1, 0): [[3 p/4, -p/2], [., 2/w - 1 - p]], p = 1/1024.
def test_hypotheses_of_matrices_that_nothing_else_would_catch():
    assert not accepted(proved(state_space([[1]], [1], [1]), nonlinearities(0, "1/2"), "circle", {}, matrix([[-1]])))
    zero = {"right": ["1"], "left": ["1"], "pivot": 0}
    assert accepted(proved(transfer([1], [1, 0]), nonlinearities(0, 9), "circle", {}, matrix([], zero), EQUILIBRIA))
    assert not accepted(
        proved(transfer([-1], [1, 0]), nonlinearities(0, 9), "circle", {}, matrix([], zero), EQUILIBRIA)
    )
    two = state_space([[1, 0], [0, "1/2"]], [1, 1], [1, 0], time="discrete")
    both = {"right": ["1", "0"], "left": ["1", "0"], "pivot": 0}
    for w, good in (("199/100", True), ("21/10", False)):
        proof = matrix([[1]], both, exponent=10)
        assert accepted(proved(two, nonlinearities(0, w), "circle", {}, proof, EQUILIBRIA)) is good
