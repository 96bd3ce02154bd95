"""Functions of the frequency as multipliers in discrete time: operators and constant gains, against the truth."""

from functools import cache

import numpy as np
import pytest
from tampering import assert_both_reject, edited

from lure import NonlinearityClass, as_plant, max_sector
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.second.opinion import recheck

INVARIANT, GAIN = (
    NonlinearityClass.norm_bounded(1, dynamics="linear time-invariant"),
    NonlinearityClass.constant_gain(-1, 1),
)
# det(1 + H Delta) = 1 - a b Delta_1 Delta_2, a = 1/(z - 1/2), b = (z - 1)/(z - 1/2): |a b|^2 = 2 u/(u + 1/4)^2, where
# u = 1 - cos, is largest at u = 1/4, |a b| = sqrt 2 there; with constant weights it is max |a| max |b| = 2 (4/3)
PLANT = as_plant([["0", "1/(z-0.5)"], ["(z-1)/(z-0.5)", "0"]], dt=1)


PARTS = ("verdict", "system", "laws", "theorem", "multiplier", "proof")


@cache
def bound(one):
    return max_sector(PLANT, [one, INVARIANT])


@pytest.mark.slow
def test_scalings_of_two_operators_meet_the_counterexample():
    found = bound(INVARIANT)
    assert found.criterion == "matrix-scalings"
    assert found.largest.low == pytest.approx(2**-0.25, rel=2e-4)
    assert found.refuted_at == pytest.approx(2**-0.25, rel=1e-6)
    constant = max(one.largest.low for one in found.answers if one.criterion == "diagonal-circle")
    assert constant == pytest.approx((3 / 8) ** 0.5, rel=1e-6)


@pytest.mark.slow
def test_a_constant_gain_beside_an_operator_has_scalings_of_either_sign():
    # g in [-1, k], |Delta| <= k: with g = -1 stable while k sqrt 2 < 1
    found = bound(GAIN)
    assert found.criterion == "matrix-scalings"
    assert found.largest.low == pytest.approx(0.5**0.5, rel=1e-4)
    assert found.refuted_at == pytest.approx(0.5**0.5, rel=1e-6)


def test_random_members_of_what_is_proved_are_stable():
    # mu = -S (v - a sigma), v+ = a v + (1 - a^2) sigma: all-passes of first order times +-r
    rng, r = np.random.default_rng(3), bound(INVARIANT).largest.low
    A, B, C, D = PLANT.doubles()
    for _ in range(300):
        a, S = rng.uniform(-1, 1, 2), np.diag(r * rng.choice([-1, 1], 2))
        sigma = np.linalg.solve(np.eye(2) - D @ S @ np.diag(a), np.hstack([C, -D @ S]))
        mu = S @ np.diag(a) @ sigma - np.hstack([np.zeros((2, len(A))), S])
        top = np.hstack([A, np.zeros((len(A), 2))]) + B @ mu
        low = np.diag(1 - a**2) @ sigma + np.hstack([np.zeros((2, len(A))), np.diag(a)])
        assert np.abs(np.linalg.eigvals(np.vstack([top, low]))).max() < 1


@pytest.mark.parametrize(
    "change",
    [
        ("laws", "channels", 1, "sector", ["-9/10", "9/10"]),
        ("laws", "channels", 1, "operator", "any"),
        ("multiplier", "theta", ["1", "0"]),
        ("multiplier", "gamma", 0, 0, "-1"),
        ("multiplier", "kernels", []),
        ("theorem", "matrix-zames-falb"),
        ("system", "time", "continuous"),
    ],
)
def test_neither_accepts_what_was_changed(change):
    *path, value = change
    assert_both_reject(edited(bound(INVARIANT).proof.certificate, *path, value=value))


def test_both_checkers_accept_and_a_sector_has_no_kernels():
    found = bound(GAIN).proof.certificate
    check(found)
    assert recheck(found).accepted
    assert_both_reject(edited(found, "laws", "channels", 0, "linear", value=False))
