"""The computed sector of lightly damped plants holds the true one, which fifty digits give."""

import numpy as np
import pytest
from mpmath import mp, mpc, mpf

from lure.analysis.inequality.hamiltonian import popov_largest_computed
from lure.analysis.numerics.refined import Refined, exact_dot
from lure.errors import AssumptionError

FLANKS = (-2, -1, -0.5, 0, 0.5, 1, 2)


def oscillators(count, damping, seed):
    """Modes ``r/(s^2 + 2 z w s + w^2)`` with dyadic ``w``, ``z``, ``r``: every matrix below is exact in doubles."""
    rng = np.random.default_rng(seed)
    w = rng.choice(np.arange(64, 1024), size=count, replace=False) / 64.0
    r = rng.integers(1, 65, size=count) / 64.0 * rng.choice([-1, 1], size=count)
    return np.sort(w), 2.0 ** round(np.log2(damping)), r


def matrices(w, z, r, *, mixed):
    """The block diagonal realisation, or the same in other coordinates, ``T = I + N`` with integers and ``N^2 = 0``."""
    n = 2 * len(w)
    A, B, C = np.zeros((n, n)), np.zeros(n), np.zeros(n)
    A[::2, 1::2] = np.eye(len(w))
    A[1::2, ::2], A[1::2, 1::2] = np.diag(-w * w), np.diag(-2 * z * w)
    B[1::2], C[::2] = r, 1
    if not mixed:
        return A, B, C
    N = np.zeros((n, n))
    N[n // 2 :, : n // 2] = np.random.default_rng(1).integers(-1, 2, size=(n // 2, n // 2)) * np.eye(n // 2)
    one = np.eye(n)
    return (one + N) @ A @ (one - N), (one + N) @ B, C @ (one - N)


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
        (40, 1e-9, 1, False),  # a bracket 2e-8 wide lay 1.9e-7 below the truth
        (32, 1e-11, 0, False),  # 1.1e-5 above it
        pytest.param(32, 1e-9, 2, True, marks=pytest.mark.thorough),
        (31, 1e-2, 3, True),
    ],
)
def test_the_bracket_holds_the_truth(count, damping, seed, mixed):
    with mp.workdps(50):
        w, z, r = oscillators(count, damping, seed)
        truth = Truth(w, z, r).largest()
        found = popov_largest_computed(*matrices(w, z, r, mixed=mixed)).largest
        assert mpf(found.low) <= truth <= mpf(found.high)
        assert found.high - found.low <= found.high * max(1e-7, 1e-14 / z)  # sharp from both sides


# the first mode alone has H = r/(2 i z w^2) at its resonance, exactly, beside which the others are as small as they are
def test_values_near_a_sharp_resonance_have_the_error_they_state():
    with mp.workdps(50):
        w, z, r = oscillators(20, 1e-10, 4)
        A, B, C = matrices(w, z, r, mixed=True)
        rough = [lambda omega, v, M=M: np.linalg.solve(1j * omega * np.eye(len(B)) - M, v) for M in (A, A.T)]
        refined = Refined(A, B, C, 0.0, *rough)
        for omega in (float(w[0]), float(w[7]), 3.0):
            u, turned, _ = Truth(w, z, r).cut(mpf(omega))
            value, error = refined.response(omega)
            exact = complex(u, -turned / mpf(omega))
            assert abs(value - exact) <= error <= 1e-9 * abs(exact)


def test_exact_dot_loses_nothing():
    assert exact_dot(np.array([1e16, 1.0, -1e16]), np.array([1.0, 1.0, 1.0])) == 1.0
    # (1 + 2^-30)(1 - 2^-30) - 1 = -2^-60
    assert exact_dot(np.array([1 + 2.0**-30, -1.0]), np.array([1 - 2.0**-30, 1.0])) == -(2.0**-60)


def test_a_damping_below_rounding_is_not_called_stable():
    w, z, r = oscillators(8, 1e-17, 0)
    with pytest.raises(AssumptionError, match="exact coefficients"):
        popov_largest_computed(*matrices(w, z, r, mixed=True))
