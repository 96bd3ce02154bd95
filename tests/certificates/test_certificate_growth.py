"""Linear gains refuted by a quadratic form that falls and is negative somewhere: sharp, in both checkers."""

import json
from fractions import Fraction

import numpy as np
import pytest
from certificate_family import COUPLED, nonlinearities, refutation, transfer
from hypothesis import given
from hypothesis import strategies as st
from tampering import refused_again

from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.checker import Refuted, check
from lure.analysis.certificates.drafts import complete_and_check, completed
from lure.analysis.certificates.growth import growth_proof
from lure.analysis.certificates.riccati import Lyapunov
from lure.analysis.certificates.second import recheck
from lure.errors import AssumptionError

FORM = {"method": "matrix-gain", "gain": "5/2", "P": [["0"], ["-1", "0"]], "start": ["1", "1"]}
SAMPLED = transfer("1", "1 -1/2", "discrete")
LAG = transfer("1", "1 3 3 1")


def both(system, given, proof):
    """The answer of the first checker, which is that of the second."""
    try:
        found = complete_and_check(refutation(system, given, proof))
    except (Rejected, Malformed):
        found = None
    made = dict(found.certificate) if found is not None else None
    if made is None:  # the second checker reads no drafts
        whole = completed(refutation(COUPLED, nonlinearities(0, 9), FORM))
        made = {**whole, "system": system, "laws": given, "proof": proof}
    assert recheck(json.dumps(made)).accepted is (found is not None), recheck(made).reason
    return isinstance(found, Refuted)


# -(A'P + PA) = [[2, -3], [-3, 2 g]] for P = [[0, -1], [-1, 0]]: positive definite exactly for g > 9/4.
@pytest.mark.parametrize(
    ("gain", "good"), [("9/4", False), (str(Fraction(9, 4) + Fraction(1, 2**60)), True), ("9", True), ("10", False)]
)
def test_the_form_is_sharp_and_the_gain_is_in_the_class(gain, good):
    assert both(COUPLED, nonlinearities(0, 9), {**FORM, "gain": gain}) is good
    assert both(COUPLED, nonlinearities(0, 9, slope=True, odd=True, linear=True), {**FORM, "gain": gain}) is good
    assert not both(COUPLED, nonlinearities(0, 9, slope=["0", "2"]), {**FORM, "gain": gain})


# x(t+1) = (1/2 - g) x(t) and V = -x^2: V falls exactly for |1/2 - g| > 1.
@pytest.mark.parametrize(
    ("gain", "good"), [("3/2", False), ("151/100", True), ("-1/2", False), ("-51/100", True), ("1/2", False)]
)
def test_the_form_is_sharp_in_discrete_time(gain, good):
    proof = {"method": "matrix-gain", "gain": gain, "P": [["-1"]], "start": ["1"]}
    assert both(SAMPLED, nonlinearities(-1, 2), proof) is good


@pytest.mark.parametrize(
    "change",
    [
        {"start": ["1", "-1"]},  # V = 2
        {"start": ["1", "0"]},  # V = 0
        {"start": ["0", "0"]},
        {"start": ["1"]},
        {"start": ["1", "1", "1"]},
        {"start": []},
        {"P": [["0"], ["1", "0"]]},
        {"P": [["1"], ["0", "1"]]},  # proves nothing of the sort: V > 0
        {"P": [["0"], ["-1/2", "0"]]},
        {"P": [["0"]]},
        {"P": [["0"], ["-1", "0"], ["0", "0", "-1"]]},
        {"gain": "0"},  # stable
        {"gain": "inf"},
        {"exponent": 0},
    ],
)
def test_a_form_that_shows_no_growth_is_refused(change):
    assert not both(COUPLED, nonlinearities(0, 9), {**FORM, **change})


def test_a_loop_without_a_solution_is_no_growing_one():
    # H = -1 + 1/(s + 1)
    system = {"kind": "state-space", "time": "continuous", "A": [["-1"]], "b": ["1"], "c": ["1"], "d": "-1"}
    proof = {"method": "matrix-gain", "P": [["-1"]], "start": ["1"]}
    # x' = -(1 + g/(1 - g)) x = -x/(1 - g): stable for g < 1 and growing for g > 1
    assert not both(system, nonlinearities(0, 3), {**proof, "gain": "1"})
    assert not both(system, nonlinearities(0, 3), {**proof, "gain": "1/2"})
    assert both(system, nonlinearities(0, 3), {**proof, "gain": "2"})


# 1/(s + 1)^3 is stable for gains below 8.
@pytest.mark.parametrize("above", [1e-12, 1e-9, 1e-3, 10.0])
def test_a_form_is_found_just_above_the_largest_stable_gain(above):
    gain = Fraction(8 * (1 + above))
    proof = growth_proof(LAG, gain)
    assert both(LAG, nonlinearities(0, str(gain)), proof)
    for below in (Fraction(8), Fraction(8) - Fraction(1, 10**9), Fraction(0)):
        assert not both(LAG, nonlinearities(0, 9), {**proof, "gain": str(below)})
        with pytest.raises(AssumptionError, match=r"stable|limit"):
            growth_proof(LAG, below)


@given(st.data())
def test_a_changed_form_next_to_the_limit_is_refused(data):
    whole = completed(refutation(LAG, nonlinearities(0, 9), growth_proof(LAG, Fraction(8001, 1000))))
    rows, kind = whole["proof"]["P"], data.draw(st.sampled_from(["digit", "sign", "start", "gain"]))
    i = data.draw(st.integers(0, len(rows) - 1))
    j = data.draw(st.integers(0, i))
    if kind == "digit":
        digits = rows[i][j].lstrip("-")
        other = data.draw(st.sampled_from([d for d in "123456789" if d != digits[0]]))
        rows[i][j] = rows[i][j].replace(digits, other + digits[1:])
    elif kind == "sign":
        rows[i][j] = str(-int(rows[i][j]))
    elif kind == "start":  # the eigenvector of the real root
        whole["proof"]["start"] = ["1", "-3", "9"]
    else:
        whole["proof"]["gain"] = data.draw(st.sampled_from(["8", "7999/1000", "-1/2", "0"]))
    if kind == "digit":  # far from the eigenvector's direction another form may prove growth as well
        assert accepted(whole) is recheck(whole).accepted
        return
    with pytest.raises(Rejected):
        check(whole)
    assert refused_again(whole)


def accepted(whole):
    try:
        check(whole)
    except Rejected:
        return False
    return True


@pytest.mark.parametrize("discrete", [False, True])
def test_the_equation_of_lyapunov_is_solved(discrete):
    rng = np.random.default_rng(3)
    A, F = rng.standard_normal((9, 9)), rng.standard_normal((9, 9))
    F = F + F.T
    X = Lyapunov.of(A, discrete=discrete).solution(F)
    left = X - A.T @ X @ A if discrete else -(A.T @ X + X @ A)
    assert np.abs(left - F).max() < 1e-11 * np.abs(X).max()


# 1/(s + 1)^3 is stable below 8; 1/(z - 1/2)^3 below r^3 = 0.276.., |1/2 + r exp(i pi/3)| = 1: r^2 + r/2 = 3/4.
@pytest.mark.parametrize(("discrete", "gain"), [(False, Fraction(801, 100)), (True, Fraction(277, 1000))])
def test_states_in_very_different_units_and_a_dense_basis(discrete, gain):
    pole, turn = 0.5 if discrete else -1.0, np.linalg.qr(np.random.default_rng(1).standard_normal((3, 3)))[0]
    units = np.array([2.0**20, 1.0, 2.0**-20])
    A = turn @ np.array([[pole, 1, 0], [0, pole, 1], [0, 0, pole]]) @ turn.T * units[:, None] / units[None, :]
    b, c = (turn @ [0, 0, 1]) * units, ([1, 0, 0] @ turn.T) / units
    rows, top, side = ([[str(Fraction(v)) for v in row] for row in np.atleast_2d(part).tolist()] for part in (A, b, c))
    time = "discrete" if discrete else "continuous"
    system = {"kind": "state-space", "time": time, "A": rows, "b": top[0], "c": side[0], "d": "0"}
    assert both(system, nonlinearities(0, 20), growth_proof(system, gain))
    with pytest.raises(AssumptionError, match="stable"):
        growth_proof(system, gain * Fraction(99, 100))
