"""Constant gains around dead times whose roots coincide, or nearly do: what both checkers accept."""

import math
from fractions import Fraction

import numpy as np
import pytest
from flint import acb, acb_series, arb, fmpq, fmpq_mat
from scipy import optimize, special
from tampering import assert_both_reject, edited

from lure import as_plant
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second.late_loops import LateLoop
from lure.analysis.certificates.second.numerics import SERIES_TERMS, on_axis, working_precision
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.counterexamples.late_switching import LateRoots

# exp(-s)/(s + 1)^2 with the gain -1e-10: (d/2) exp(d/2) = .5e-5 exp(1/2) at s = -1 + d, and near by at s = -1 - d
TRUTH = 1 - 2 * special.lambertw(0.5e-5 * math.exp(0.5)).real
NONE = [["0"]]
CLOSE = {
    "verdict": "REFUTED",
    "system": {
        "kind": "multivariable delay",
        "time": "continuous",
        "A": [["0", "1"], ["-1", "-2"]],
        "B": [["0"], ["1"]],
        "C": [["0", "0"]],
        "D": NONE,
        "late": [["1", [["1", "0"]]]],
    },
    "laws": {
        "channels": [{"sector": ["-1", "0"], "slope": None, "odd": False, "time_varying": True, "linear": False}],
        "repeated": False,
    },
    "theorem": "counterexample",
    "proof": {"method": "late-turns", "gains": ["-1/10000000000"]},
    "rate": "99998351293/100000000000",
}


def test_a_rate_close_to_roots_that_nearly_coincide_is_refuted_by_both_checkers():
    assert 0 < float(Fraction(CLOSE["rate"])) - TRUTH < 2e-9
    shown = complete_and_check(CLOSE)
    assert "1 roots Re s > 0" in shown.facts["root"]
    assert recheck(shown.certificate).accepted
    assert_both_reject(edited(shown.certificate, "rate", value="99998351093/100000000000"))  # below the root


def test_a_double_root_is_found_beside_a_simple_one_farther_to_the_left():
    # Newton's steps halve near a double root and do not become as small as near the simple one at -3
    twice = "exp(-s)/((s + 1)*(s + 2))"
    plant = as_plant([[twice, "0"], ["1/(s + 3)", twice]])
    truth = optimize.brentq(lambda s: (s + 1) * (s + 2) - 0.2 * math.exp(-s), -1, 0, xtol=1e-14)
    assert LateRoots(plant).rightmost(np.array([-0.2, -0.2])) == pytest.approx(truth, abs=1e-9)


def loop(A):
    zero = fmpq_mat(len(A), len(A))
    return LateLoop(fmpq_mat(A), zero, zero, zero, ((Fraction(1), zero, zero),), ((zero, zero),), None)


def test_a_determinant_whose_pivots_may_vanish_is_not_bounded_by_its_series():
    # [[s - 1, -5], [-1/100, s - 1]] on a box around 3/2: the larger pivot may be 0, and no coefficient is known then
    with working_precision(128):
        s = acb_series([acb(arb(1.5, 1), arb(0, 1)), acb(1)])
        found = loop([[1, 5], [fmpq(1, 100), 1]]).determinant(s)
        assert all(found[k].abs_upper() == math.inf for k in range(SERIES_TERMS))
        # (s^2 + 1)(s + 2) on i [1/2, 2/3] by Taylor's formula: its range is that at the ends, within a percent
        ends = on_axis(loop([[0, 1, 0], [-1, 0, 0], [0, 0, -2]]).determinant, Fraction(1, 2), Fraction(2, 3))
    assert float(ends.real.lower()) == pytest.approx(2 * (1 - 4 / 9), rel=0.01)
    assert float(ends.real.upper()) == pytest.approx(2 * (1 - 1 / 4), rel=0.01)
