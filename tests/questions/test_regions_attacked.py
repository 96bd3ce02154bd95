"""Regions of attraction under attack: random loops, random starts; nothing that was proved is left."""

from fractions import Fraction

import numpy as np
import pytest
from depth import sampled
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import solve_continuous_are, solve_discrete_are

from lure import Saturation, as_plant
from lure.analysis import region
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.questions.region_curves import gauge
from lure.analysis.verdict import Verdict
from lure.nonlinearities import Cubic

exact = st.fractions(Fraction(1, 20), 20, max_denominator=50)


@settings(max_examples=sampled(15, of=400), deadline=None)
@given(a=exact, b=exact, k=exact, low=exact, high=exact)
def test_a_saturated_loop_with_one_state_is_exact_from_both_sides(a, b, k, low, high):
    # x' = a x - b sat(k x) between -low and high: attracted up to where a x = b high if b k > a, else not at all
    found = region(as_plant(([[a]], [b], [1], 0)), Saturation(gain=k, limit=high, lower_limit=-low))
    if b * k > a:
        assert found.sets[0].interval == found.outside[0].interval == (-b * low / a, b * high / a)
    else:
        assert (found.verdict, found.sets) == (Verdict.REFUTED if b * k < a else Verdict.INCONCLUSIVE, ())


@settings(max_examples=sampled(10, of=400), deadline=None)
@given(a=exact, b=exact, c=exact)
def test_a_cubic_loop_with_one_state_ends_at_its_square_root(a, b, c):
    # x' = -a x + b (c x)^3: zero at x^2 = a/(b c^3)
    found = region(as_plant(([[-a]], [b], [c], 0)), Cubic(cubic=-1))
    low, high = (Fraction(v) / 2 for v in found.area)
    square = a / (b * c**3)
    assert low**2 <= square <= high**2
    assert high - low <= Fraction(1, 10**12) * high


def a_loop(rng):
    """A planar loop, and its step: Runge and Kutta's, or the next state."""
    m, discrete = int(rng.integers(1, 3)), bool(rng.integers(2))
    A, B = np.round(rng.normal(size=(2, 2)), 3), np.round(rng.normal(size=(2, m)), 3)
    if discrete:
        A = np.round(A / max(abs(np.linalg.eigvals(A))) * rng.uniform(0.9, 1.4), 3)
        X = solve_discrete_are(A, B, np.eye(2), np.eye(m))
        K = np.linalg.solve(np.eye(m) + B.T @ X @ B, B.T @ X @ A)
    else:
        K = B.T @ solve_continuous_are(A, B, np.eye(2), np.eye(m))
    C = np.round(K, 3)
    plant = as_plant(
        tuple([[str(v) for v in row] for row in side] for side in (A, B, C, np.zeros((m, m)))),
        dt=1 if discrete else None,
    )
    limits = [[str(round(v, 2)) for v in rng.uniform(0.5, 3, 2)] for _ in range(m)]
    laws = [
        Saturation(limit=high, lower_limit=f"-{low}") if rng.integers(2) else Cubic(linear=1, cubic="-0.1")
        for low, high in limits
    ]

    def rate(x):
        phi = np.stack([f(s) for f, s in zip(laws, (x @ C.T).T, strict=True)], axis=1)
        return x @ A.T - phi @ B.T

    h = 0.02 / np.linalg.norm(A, 2)

    def runge_kutta(x):
        one = rate(x)
        two = rate(x + h / 2 * one)
        three = rate(x + h / 2 * two)
        return x + h / 6 * (one + 2 * two + 2 * three + rate(x + h * three))

    return plant, laws, rate if discrete else runge_kutta


@pytest.mark.parametrize("seed", range(sampled(5, of=100)))
@pytest.mark.slow
def test_solutions_of_random_loops_keep_to_what_was_proved(seed):
    rng = np.random.default_rng(seed)
    plant, laws, step = a_loop(rng)
    found = region(plant, laws)
    assert all(recheck(one.proof.certificate).accepted for one in (*found.sets, *found.outside))
    count = sampled(100, of=1000)
    for one in (one for one in found.sets if one.bounded):
        x = rng.normal(size=(count, 2))
        low, high = np.zeros(count), np.full(count, 1e-9)
        while (inside := one.values(high[:, None] * x) <= 1).any():
            low, high = np.where(inside, high, low), np.where(inside, 2 * high, high)
        x, before = low[:, None] * x, 1.0
        for _ in range(5):
            for _ in range(30):
                x = step(x)
            values = one.values(x)
            assert np.all(values <= before + 1e-9)
            before = np.minimum(values, before) if one.points is None else 1.0  # not left; no form falls on it
    for one in found.outside:
        if one.points is not None:
            x = rng.normal(size=(count, 2))
            x *= (rng.uniform(1, 3, count) / gauge(one.points)(x))[:, None]
            for _ in range(100):
                x = step(x)
                x = x[np.abs(x).max(axis=1) < 1e3]  # what is farther out has gone
            assert np.all(gauge(one.points)(x) > 1)
            continue
        Q = np.array(one.Q, dtype=float)
        x = 50 * rng.normal(size=(count, 2))
        x = x[np.einsum("ki,ij,kj->k", x, Q, x) > 1]
        for _ in range(100):
            x = step(x)
            x = x[np.abs(x).max(axis=1) < 1e100]
        assert np.all(np.einsum("ki,ij,kj->k", x, Q, x) > 1)
