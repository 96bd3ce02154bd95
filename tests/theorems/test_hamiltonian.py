"""Popov's largest sector from eigenvalues of a Hamiltonian matrix: close to the certified one, never a verdict."""

import math

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plants import CONTINUOUS, block

from lure.analysis.inequality.hamiltonian import HamiltonianFamily, popov_largest_computed
from lure.analysis.theorems.popov import popov_largest
from lure.analysis.verdict import Evidence, Verdict
from lure.errors import AssumptionError, InputError


def arrays(plant):
    system = control.ss(plant.to_control())
    return system.A, system.B, system.C, system.D


@pytest.mark.parametrize("example", sorted(CONTINUOUS))
@pytest.mark.parametrize("sign", ["both", "nonnegative"])
def test_the_computed_sector_agrees_with_the_certified_one(example, sign):
    plant = CONTINUOUS[example]
    computed, certified = popov_largest_computed(*arrays(plant), sign=sign), popov_largest(plant, sign=sign)
    assert computed.largest.low == pytest.approx(certified.largest.low, rel=1e-7)
    assert computed.largest.high == pytest.approx(certified.largest.high, rel=1e-7)
    assert computed.theta == pytest.approx(certified.theta, rel=1e-4, abs=1e-6)


# the direct term: (s^2-s+10)/(s^2+s+25) reaches 1 with theta = -3/7; -1 + 1/(s+1) stops at 1 + k D = 0
@pytest.mark.parametrize(("numerator", "denominator"), [([1, -1, 10], [1, 1, 25]), ([-1, 0], [1, 1])])
def test_a_direct_term_is_seen(numerator, denominator):
    answer = popov_largest_computed(*arrays(block(numerator, denominator)))
    assert answer.largest.low == pytest.approx(1, rel=1e-6)
    assert answer.largest.low < 1


def test_floating_point_never_gives_a_verdict():
    answer = popov_largest_computed(*arrays(CONTINUOUS[1]))
    assert answer.verdict is Verdict.INCONCLUSIVE
    assert answer.evidence is Evidence.COMPUTED
    assert "not certified" in answer.reason


# Re H = (1-x)/((1-x)^2+x) = -1/4 at x^2 - 5x + 5 = 0
def test_crossings_of_a_level_are_eigenvalues():
    family = HamiltonianFamily.of(*arrays(block([1], [1, 1, 1])))
    expected = [math.sqrt((5 - math.sqrt(5)) / 2), math.sqrt((5 + math.sqrt(5)) / 2)]
    assert family.crossings(0.0, -0.25) == pytest.approx(expected, rel=1e-12)
    assert family.crossings(0.0, -0.34).size == 0


@given(st.integers(0, 2**32 - 1))
def test_the_state_basis_does_not_matter(seed):
    rng = np.random.default_rng(seed)
    a, b, c, d = arrays(CONTINUOUS[3])
    basis, _ = np.linalg.qr(rng.normal(size=a.shape))
    turned = popov_largest_computed(basis @ a @ basis.T, basis @ b, c @ basis.T, d)
    assert turned.largest.middle == pytest.approx(0.384165738677, rel=1e-7)


@pytest.mark.parametrize(
    ("part", "match"),
    [
        (([[0, 1]], [1], [1]), "needs A"),
        (([[-1]], [1, 2], [1]), "needs A"),
        (([[math.nan]], [1], [1]), "not finite"),
        (([[-1]], [1], [math.inf]), "not finite"),
    ],
)
def test_arrays_that_are_no_block_are_refused(part, match):
    with pytest.raises(InputError, match=match):
        popov_largest_computed(*part)


@pytest.mark.parametrize("pole", [0.0, 1.0])
def test_a_block_that_is_not_stable_is_refused(pole):
    with pytest.raises(AssumptionError, match="must be stable"):
        popov_largest_computed([[pole]], [1], [1])


# modes in parallel in a random basis; the time is that of a few eigenvalue problems of size four times the modes
@pytest.mark.parametrize("modes", [60, pytest.param(200, marks=pytest.mark.thorough)])
def test_hundreds_of_states_agree_with_a_dense_sample(modes):
    rng = np.random.default_rng(1)
    w, zeta, gain = np.geomspace(1, 30, modes), rng.uniform(0.02, 0.2, modes), rng.normal(size=modes)
    a = np.zeros((2 * modes, 2 * modes))
    for i in range(modes):
        a[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = [[0, w[i]], [-w[i], -2 * zeta[i] * w[i]]]
    b, c = np.tile([0.0, 1.0], modes) * np.repeat(w, 2), np.repeat(gain, 2) * np.tile([1.0, 0.0], modes)
    basis, _ = np.linalg.qr(rng.normal(size=a.shape))
    answer = popov_largest_computed(basis @ a @ basis.T, basis @ b, c @ basis.T)
    s = 1j * np.geomspace(0.01, 1000, 20001)
    response = sum(g * v**2 / (s**2 + 2 * z * v * s + v**2) for g, v, z in zip(gain, w, zeta, strict=True))
    least = float(np.min(((1 + answer.theta * s) * response).real))
    assert -1 / least == pytest.approx(answer.largest.low, rel=1e-4)
    assert -1 / least >= answer.largest.low * (1 - 1e-7)
