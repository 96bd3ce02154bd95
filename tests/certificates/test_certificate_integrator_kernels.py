"""Kernels beside integrators: a certificate by hand, what neither checker accepts, and both sides of a factor."""

import copy
from functools import cache

import numpy as np
import pytest
from certificate_format import FORMAT
from tampering import assert_both_reject, edited

from lure import NonlinearityClass, as_plant, max_slope
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.inequality.kernels import Kernel

SLOPE = {"sector": ["0", "1/2"], "slope": ["0", "1/2"], "odd": False, "time_varying": False, "linear": False}
# H = R/s, R = (2, 1; 1, 2), W = 1/2, M = diag(5 - h, 4), h = 1/(1 + s): M(0) W R = 2 R, and (M - M(0))/s = diag(h, 0),
# so that F = (5 - Re h + Re h, h/4; h*/4, 4), positive definite as |h| <= 1
PROVED = {
    "verdict": "PROVED",
    "system": {
        **{"kind": "multivariable", "time": "continuous", "A": [["0", "0"], ["0", "0"]]},
        **{"B": [["2", "1"], ["1", "2"]], "C": [["1", "0"], ["0", "1"]], "D": [["0", "0"], ["0", "0"]]},
    },
    "laws": {"channels": [SLOPE, SLOPE], "repeated": False},
    "theorem": "matrix-zames-falb",
    "multiplier": {
        "gamma": [["5", "0"], ["0", "4"]],
        "theta": ["0", "0"],
        "kernels": [{"channels": [1, 1], "coefficient": "1", "rate": "1", "order": 1, "side": "causal"}],
    },
    "proof": {"method": "determinant"},
}


@cache
def certificate():
    return dict(complete_and_check(copy.deepcopy(PROVED)).certificate)


KERNEL = ("multiplier", "kernels", 0)


@pytest.mark.parametrize("side", ["causal", "anticausal"])
@pytest.mark.parametrize("order", [1, 3])
def test_both_checkers_accept(side, order):
    kernel = PROVED["multiplier"]["kernels"][0] | {"side": side, "order": order}
    given = edited(certificate(), *KERNEL, value=kernel)
    found = dict(complete_and_check({key: given[key] for key in PROVED}).certificate)
    FORMAT.validate(found)
    assert recheck(found).accepted
    assert found["conclusion"] == "every motion converges to the set of equilibria"


@pytest.mark.parametrize(
    "change",
    [
        (*KERNEL, "coefficient", "2"),  # M(0) W R is not symmetric
        (*KERNEL, "coefficient", "5"),  # M(0) is singular
        (*KERNEL, "coefficient", "-1"),
        (*KERNEL, "channels", [1, 2]),
        ("multiplier", "gamma", [["0", "0"], ["0", "-1"]]),
        ("laws", "channels", 1, "slope", None),
        ("laws", "channels", 0, "slope", None),
        ("laws", "channels", 1, "time_varying", True),
        ("laws", "channels", 1, "slope", ["-1", "1/2"]),
        ("system", "B", [["2", "1"], ["2", "2"]]),
        ("system", "B", [["-2", "-1"], ["-1", "-2"]]),
        ("system", "B", [["1", "2"], ["2", "1"]]),  # R has a negative eigenvalue
        ("system", "A", [["0", "1"], ["0", "0"]]),
        ("system", "A", [["0", "0"], ["0", "1/100"]]),
    ],
)
def test_neither_accepts_what_was_changed(change):
    *path, value = change
    assert_both_reject(edited(certificate(), *path, value=value))


def test_a_kernel_after_an_integrator():
    omega = np.array([0.0, 1e-7, 0.3, 5.0, np.inf])
    for side in (1, -1):
        one = Kernel(0, 0, 1, 2, 3, side)
        direct = (one.at(omega[2:4]) - 1) / (1j * omega[2:4])
        found = one.integrated(omega)
        assert found[2:4] == pytest.approx(direct)
        assert found[0] == pytest.approx(-side * 3 / 2)  # -n/a for (a/(a + s))^n
        assert found[1] == pytest.approx(found[0], abs=1e-6)
        assert found[4] == 0


@pytest.mark.thorough
def test_an_integrator_beside_a_plant_for_which_kernels_are_needed():
    # ct-6 of the published table and a small 1/s: no linear gain destabilises below 83.614
    top = "9.432*(s^2+15.6*s+147.8)*(s^2+2.356*s+56.21)*(s^2-0.332*s+26.15)"
    low = "(s^2+2.588*s+90.9)*(s^2+11.79*s+113.7)*(s^2+14.84*s+84.05)*(s+8.83)"
    found = max_slope(as_plant(f"{top}/({low})+0.01/s"), [NonlinearityClass.slope_restricted(0, 1, odd=True)])
    assert found.criterion == "matrix-zames-falb"
    assert found.largest.low == pytest.approx(83.61403, rel=1e-5)
    assert found.largest.low < found.refuted_at < 83.61405


@pytest.mark.slow
def test_two_coupled_integrators_whose_residue_is_not_symmetric():
    # R = (1, 2; 1, 3) needs weights 1 and 2; without coupling of the rest the channels are lags, which do no harm
    rows = [["1/s+1/(s+1)", "2/s"], ["1/s", "3/s+1/(s+2)"]]
    asked = [NonlinearityClass.slope_restricted(0, 1)] * 2
    found = max_slope(as_plant(rows), asked, criterion="matrix-zames-falb")
    assert found.largest.low > 1e3
    assert recheck(found.proof.certificate).accepted
    assert "converges to the set of equilibria" in str(found)
