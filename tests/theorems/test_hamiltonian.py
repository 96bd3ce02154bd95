"""Largest sectors of plants in doubles from eigenvalues of Hamiltonian matrices: the upper end alone is certain."""

import math
from fractions import Fraction

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpc, mpf
from plants import CONTINUOUS, block

from lure import StateSpace
from lure.analysis.inequality.state_space import HamiltonianFamily, StatesInequality
from lure.analysis.theorems.popov import popov_largest
from lure.analysis.verdict import Evidence
from lure.errors import AssumptionError

FLANKS = (-2, -1, -0.5, 0, 0.5, 1, 2)


def states(plant):
    system = control.ss(plant.to_control())
    return StateSpace(system.A, system.B.ravel(), system.C.ravel(), system.D.item())


def best(plant):
    return StatesInequality(plant, Fraction(0), weighted=True).best()


@pytest.mark.parametrize("example", sorted(CONTINUOUS))
def test_the_computed_sector_agrees_with_the_certified_one(example):
    computed, certified = best(states(CONTINUOUS[example])), popov_largest(CONTINUOUS[example])
    assert computed.largest.low == pytest.approx(certified.largest.low, rel=1e-7)
    assert computed.largest.high == pytest.approx(certified.largest.high, rel=1e-7)
    assert computed.largest.high >= certified.largest.low
    assert float(computed.multiplier["theta"]) == pytest.approx(certified.theta, rel=1e-4, abs=1e-6)


# the direct term: (s^2-s+10)/(s^2+s+25) reaches 1 with theta = -3/7; -1 + 1/(s+1) stops at 1 + k D = 0
@pytest.mark.parametrize(("numerator", "denominator"), [([1, -1, 10], [1, 1, 25]), ([-1, 0], [1, 1])])
def test_a_direct_term_is_seen(numerator, denominator):
    largest = best(states(block(numerator, denominator))).largest
    assert largest.low == pytest.approx(1, rel=1e-6)
    assert largest.high >= 1


def test_floating_point_is_computed_and_says_so():
    inequality = StatesInequality(states(CONTINUOUS[1]), Fraction(0), weighted=True)
    assert inequality.grounds.evidence is Evidence.COMPUTED
    assert "not certified" in inequality.best().reason


# Re H = (1-x)/((1-x)^2+x) = -1/4 at x^2 - 5x + 5 = 0
def test_crossings_of_a_level_are_eigenvalues():
    family = HamiltonianFamily.of(states(block([1], [1, 1, 1])))
    expected = [math.sqrt((5 - math.sqrt(5)) / 2), math.sqrt((5 + math.sqrt(5)) / 2)]
    assert family.crossings(0.0, -0.25) == pytest.approx(expected, rel=1e-12)
    assert family.crossings(0.0, -0.34).size == 0


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1))
def test_the_state_basis_does_not_matter(seed):
    plant = states(CONTINUOUS[3])
    basis, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=plant.A.shape))
    turned = best(StateSpace(basis @ plant.A @ basis.T, basis @ plant.B, plant.C @ basis.T, plant.D))
    assert turned.largest.middle == pytest.approx(0.384165738677, rel=1e-7)


@pytest.mark.parametrize("pole", [0.0, 1.0])
def test_a_block_that_is_not_stable_is_refused(pole):
    with pytest.raises(AssumptionError, match="must be stable"):
        best(StateSpace([[pole]], [1], [1]))


# modes in parallel in a random basis; the time is that of a few eigenvalue problems of size four times the modes
@pytest.mark.thorough
def test_hundreds_of_states_agree_with_a_dense_sample():
    rng, modes = np.random.default_rng(1), 200
    w, zeta, gain = np.geomspace(1, 30, modes), rng.uniform(0.02, 0.2, modes), rng.normal(size=modes)
    a = np.zeros((2 * modes, 2 * modes))
    for i in range(modes):
        a[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = [[0, w[i]], [-w[i], -2 * zeta[i] * w[i]]]
    b, c = np.tile([0.0, 1.0], modes) * np.repeat(w, 2), np.repeat(gain, 2) * np.tile([1.0, 0.0], modes)
    basis, _ = np.linalg.qr(rng.normal(size=a.shape))
    answer = best(StateSpace(basis @ a @ basis.T, basis @ b, c @ basis.T))
    s = 1j * np.geomspace(0.01, 1000, 20001)
    response = sum(g * v**2 / (s**2 + 2 * z * v * s + v**2) for g, v, z in zip(gain, w, zeta, strict=True))
    least = float(np.min(((1 + float(answer.multiplier["theta"]) * s) * response).real))
    assert -1 / least == pytest.approx(answer.largest.low, rel=1e-4)
    assert -1 / least >= answer.largest.low * (1 - 1e-7)


def oscillators(count, damping, seed):
    """Modes ``r/(s^2 + 2 z w s + w^2)`` with dyadic ``w``, ``z``, ``r``: every matrix below is exact in doubles."""
    rng = np.random.default_rng(seed)
    w = rng.choice(np.arange(64, 1024), size=count, replace=False) / 64.0
    r = rng.integers(1, 65, size=count) / 64.0 * rng.choice([-1, 1], size=count)
    return np.sort(w), 2.0 ** round(np.log2(damping)), r


def damped(w, z, r, *, mixed):
    """The block diagonal realisation, or the same in other coordinates, ``T = I + N`` with integers and ``N^2 = 0``."""
    n = 2 * len(w)
    A, B, C = np.zeros((n, n)), np.zeros(n), np.zeros(n)
    A[::2, 1::2] = np.eye(len(w))
    A[1::2, ::2], A[1::2, 1::2] = np.diag(-w * w), np.diag(-2 * z * w)
    B[1::2], C[::2] = r, 1
    if not mixed:
        return StateSpace(A, B, C)
    N = np.zeros((n, n))
    N[n // 2 :, : n // 2] = np.random.default_rng(1).integers(-1, 2, size=(n // 2, n // 2)) * np.eye(n // 2)
    one = np.eye(n)
    return StateSpace((one + N) @ A @ (one - N), (one + N) @ B, C @ (one - N))


class Truth:
    """``sup over theta of inf over omega of Re[(1 + i omega theta) H(i omega)]`` by cutting planes, in 50 digits."""

    def __init__(self, w, z, r):
        self.w, self.r, self.z = [mpf(float(v)) for v in w], [mpf(float(v)) for v in r], mpf(z)

    def cut(self, omega):
        s = mpc(0, omega)
        h = sum(r / (s * s + 2 * self.z * w * s + w * w) for r, w in zip(self.r, self.w, strict=True))
        return h.real, -omega * h.imag, omega

    def lowest(self, omega, theta):
        """The minimum next to a frequency, by Newton's method with differences."""
        width = self.z * min(self.w, key=lambda w: abs(w - omega))
        step = width * mpf(10) ** -12
        for _ in range(30):
            below, here, above = (u + theta * w for u, w, _ in map(self.cut, (omega - step, omega, omega + step)))
            slope, bend = (above - below) / (2 * step), (above - 2 * here + below) / step**2
            move = -slope / bend if bend > 0 else -mp.sign(slope) * width / 4
            omega += max(-width / 2, min(width / 2, move))
            if abs(move) < width * mpf(10) ** -14:
                break
        return self.cut(omega)

    def largest(self):
        cuts = [(mpf(0), mpf(0), None)]
        cuts += [self.cut(w + t * self.z * w) for w in self.w for t in FLANKS]
        for _ in range(40):
            theta, top = upper_bound(cuts)
            low = sorted((c for c in cuts if c[2] is not None), key=lambda c: c[0] + theta * c[1])[:10]
            found = [self.lowest(omega, theta) for _, _, omega in low]
            cuts += found
            if min(u + theta * w for u, w, _ in found) > top - abs(top) * mpf(10) ** -20:
                return -1 / top
        raise AssertionError("the cutting planes did not close")


def upper_bound(cuts):
    """The greatest value of the least cut: bisection on the slope, then the crossing of the two cuts left."""
    low, high = -(mpf(10) ** 9), mpf(10) ** 9
    while True:
        (u, w), (v, x) = (min(((a + t * b, a, b) for a, b, _ in cuts))[1:] for t in (low, high))
        theta = (v - u) / (w - x)
        value, _, slope = min((a + theta * b, a, b) for a, b, _ in cuts)
        if abs(value - (u + theta * w)) <= abs(value) * mpf(10) ** -40:
            return theta, value
        low, high = (theta, high) if slope > 0 else (low, theta)


@pytest.mark.parametrize(
    ("count", "damping", "seed", "mixed"),
    [
        (12, 1e-9, 1, False),
        pytest.param(32, 1e-11, 0, False, marks=pytest.mark.thorough),
        pytest.param(32, 1e-9, 2, True, marks=pytest.mark.thorough),
        (11, 1e-2, 3, True),
    ],
)
def test_no_multiplier_reaches_the_upper_end(count, damping, seed, mixed):
    with mp.workdps(50):
        w, z, r = oscillators(count, damping, seed)
        truth = Truth(w, z, r).largest()
        high = best(damped(w, z, r, mixed=mixed)).largest.high
        assert truth <= mpf(high) <= truth * (1 + max(1e-7, 1e-14 / z))  # sharp from both sides
