"""Several nonlinearities where the answer is known, from both sides, and attacks on what is proved.

The plants are small and their numbers are eighths; a thorough run draws a thousand of each kind.
"""

from itertools import product

import numpy as np
import pytest
from depth import sampled
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.linalg import block_diag, expm

from lure import Diagonal, NonlinearityClass, Sector, as_plant, max_sector, max_slope
from lure.analysis.certificates.second.opinion import recheck

FEW = settings(max_examples=sampled(1, of=1000))
SEEDS, TIMES = st.integers(0, 2**32 - 1), pytest.mark.parametrize("discrete", [False, True])
FAR = 1e4  # beyond it a factor is as good as any: searches end at 1e6
KINDS = {
    "time-varying": lambda top: NonlinearityClass(sector=Sector(0, top), time_varying=True),
    "sector": lambda top: NonlinearityClass(sector=Sector(0, top)),
    "slope": lambda top: NonlinearityClass.slope_restricted(0, top),
    "odd": lambda top: NonlinearityClass.slope_restricted(0, top, odd=True),
}
ANY = st.sampled_from(sorted(KINDS))


def eighths(values):
    return np.round(8 * np.asarray(values)) / 8


def growth(A, discrete):
    """The largest real part of the eigenvalues, in discrete time the largest modulus less 1."""
    values = np.linalg.eigvals(A)
    return float(np.abs(values).max() - 1) if discrete else float(values.real.max())


def settled(A, discrete, room):
    """A matrix near to it whose modes decay: shifted, in discrete time made smaller."""
    if discrete:
        return np.round(A * (1 - room) / max(np.abs(np.linalg.eigvals(A)).max(), 1e-3) * 64) / 64
    return A - eighths(np.linalg.eigvals(A).real.max() + room + 0.1) * np.eye(len(A))


def drawn(seed, n, m, discrete):
    """A stable plant of eighths with n states and m channels."""
    rng = np.random.default_rng(seed)
    A = settled(eighths(rng.normal(size=(n, n))), discrete, rng.uniform(0.1, 0.8))
    B, C = eighths(rng.normal(size=(n, m))), eighths(rng.normal(size=(m, n)))
    assume(B.any(axis=0).all() and C.any(axis=1).all() and growth(A, discrete) < -0.02)
    return A, B, C


def asked(parts, classes, discrete):
    """The largest factor, both certificates seen by the second checker too."""
    plant = as_plant(parts, dt=1 if discrete else None)
    first = classes.classes[0] if isinstance(classes, Diagonal) else classes[0]
    found = (max_sector if first.slope is None else max_slope)(plant, classes)
    shown = [one for one in (found.proof, found.refutation) if one is not None]
    assert all(recheck(dict(one.certificate)).accepted for one in shown)
    return found


def ends(found):
    return found.largest.low, np.inf if found.refuted_at is None else found.refuted_at


def agree(found, low, high, rel=1e-3):
    """What is proved is no weaker than is known, and what is known to be stable is not refuted, nor conversely."""
    proved, refuted = ends(found)
    assert min(low, FAR) * (1 - rel) <= proved <= high * (1 + 1e-9)
    assert low * (1 - 1e-9) <= refuted
    assert refuted <= high * (1 + rel) or high > FAR


# Channels that do not interact: a solution for the classes is one of each channel, so that the answer is the least of
# theirs, and sigma_i -> s_i sigma_i, mu_i -> mu_i/s_i makes of phi_i in [0, k] one in [0, k/s_i^2].
@TIMES
@FEW
@given(seeds=st.lists(SEEDS, min_size=2, max_size=3), kind=ANY, scale=st.permutations([0.5, 1.0, 2.0]))
def test_channels_that_do_not_interact_have_the_least_of_their_answers(discrete, seeds, kind, scale):
    one = KINDS[kind]
    parts = [drawn(seed, 1 + seed % 3, 1, discrete) for seed in seeds]
    alone = [ends(asked(part, [one(1)], discrete)) for part in parts]
    A, B, C = (block_diag(*side) for side in zip(*parts, strict=True))
    turn, scale = np.random.default_rng(seeds[0]).permutation(len(parts)), np.array(scale[: len(parts)])
    plant = (A, B[:, turn] * scale, scale[:, None] * C[turn])
    found = asked(plant, [one(1 / s**2) for s in scale], discrete)
    agree(found, min(low for low, _ in alone), min(high for _, high in alone))


# Two channels with mu_1/2 + mu_2/2 = mu and the same sigma: with phi in both it is the loop of phi, and the mean of
# phi_1 and phi_2 is of their class.
@TIMES
@FEW
@given(seed=SEEDS, kind=ANY)
def test_a_duplicated_channel_changes_nothing(discrete, seed, kind):
    one = KINDS[kind](1)
    A, B, C = drawn(seed, 1 + seed % 3, 1, discrete)
    low, high = ends(asked((A, B, C), [one], discrete))
    agree(asked((A, np.hstack([B, B]) / 2, np.vstack([C, C])), [one] * 2, discrete), low, high)


# A Metzler (in discrete time nonnegative), B, C >= 0, and mu = -phi fed back with the other sign: |x| is at most the
# solution with phi = alpha sigma, which is stable up to 1/rho(G(0)) (1/rho(G(1))), whatever depends on time.
@TIMES
@FEW
@given(seed=SEEDS, kind=ANY)
def test_an_internally_positive_plant_has_the_answer_of_its_linear_gain(discrete, seed, kind):
    rng = np.random.default_rng(seed)
    n, m = rng.integers(2, 6), rng.integers(2, 4)
    A = settled(rng.integers(0, 9, (n, n)) / 8, discrete, rng.uniform(0.1, 0.8))
    B, C = rng.integers(0, 5, (n, m)) / 4, rng.integers(0, 5, (m, n)) / 4
    assume(growth(A, discrete) < -0.02)
    gain = C @ np.linalg.solve(discrete * np.eye(n) - A, B)
    largest = np.abs(np.linalg.eigvals(gain)).max()
    assume(largest > 1e-3)
    agree(asked((A, -B, C), [KINDS[kind](1)] * m, discrete), 1 / largest, 1 / largest)


# A = A', C = B': passive in continuous time, so that no factor ends it.  In discrete time A - B G B' is symmetric for
# all gains, |.|^2 falls for every class as long as it is > -1 at the largest, and equal gains are beyond.
@TIMES
@FEW
@given(seed=SEEDS, kind=ANY)
def test_a_symmetric_plant_has_the_answer_of_equal_gains(discrete, seed, kind):
    rng = np.random.default_rng(seed)
    n, m = rng.integers(2, 5), rng.integers(2, 4)
    A, B = rng.integers(-8, 9, (n, n)), rng.integers(-4, 5, (n, m)) / 4
    A = settled((A + A.T) / 8, discrete, rng.uniform(0.1, 0.8))
    assume(growth(A, discrete) < -0.02 and B.any())
    largest = np.linalg.eigvalsh(B.T @ np.linalg.solve(np.eye(n) + A, B)).max() if discrete else 0
    exact = 1 / largest if largest > 0 else np.inf
    agree(asked((A, B, B.T), [KINDS[kind](1)] * m, discrete), exact, exact)


# H = h(s) M, M = Q diag(mu) Q* normal: with Lambda = 1 the inequality is 1/alpha + Re mu_i h > 0 for each mu_i, and the
# circle criterion proves no less; equal constant gains are det(1 + g mu_i h) = 0 for each.
@TIMES
@FEW
@given(seed=SEEDS, m=st.integers(2, 3))
def test_a_normal_matrix_times_a_scalar_splits_over_its_eigenvalues(discrete, seed, m):
    A, b, c = drawn(seed, 1 + seed % 2, 1, discrete)
    row = eighths(np.random.default_rng(seed).normal(size=m))
    M = np.array([np.roll(row, i) for i in range(m)])  # circulant
    own = np.linalg.eigvals(M)
    assume(np.abs(own[:, None] - own + np.eye(m)).min() > 0.1)  # where roots are double, boxes of gains end earlier
    one, plant = np.eye(m), (np.kron(A, np.eye(m)), np.kron(b, np.eye(m)), np.kron(c, M))
    omega = np.linspace(-np.pi, np.pi, 4001)
    points = np.exp(1j * omega) if discrete else 1j * np.tan(omega / 2)
    h = (c @ np.linalg.solve(points[:, None, None] * np.eye(len(A)) - A, b.astype(complex)))[:, 0, 0]
    least = min((value * h).real.min() for value in own)
    assume(least < -1e-3)
    found = asked(plant, [KINDS["time-varying"](1)] * m, discrete)
    agree(found, -1 / least * (1 - 1e-6), np.inf)
    proved, refuted = ends(
        asked(plant, Diagonal((NonlinearityClass.constant_gain(0, 1),) * m, repeated=True), discrete)
    )
    grown = [growth(np.kron(A, one) - k * np.kron(b @ c, M), discrete) for k in np.linspace(0, 0.999 * proved, 50)]
    assert max(grown) < 0
    assert refuted <= 2 * FAR or proved > FAR or growth(np.kron(A, one) - 2 * FAR * np.kron(b @ c, M), discrete) < 0
    assert proved >= 0.99 * refuted or refuted > FAR


# -- attacks: nothing that is proved is destabilised
def gains_of(rng, m, top, count):
    """(count, m) gains in [0, top], many of them at the ends."""
    inside = rng.uniform(0, top, (count, m))
    return np.where(rng.random((count, m)) < 0.6, np.where(rng.random((count, m)) < 0.5, 0, top), inside)


def jumps(parts, top, rng, discrete):
    """The largest multiplier over a period, per step, of gains that jump at random, and of those that jump back."""
    A, B, C = parts
    most = 0.0
    for count in (1, 2, 2, 3, 4, 6):
        whole = np.eye(len(A))
        for g in gains_of(rng, B.shape[1], top, count):
            closed = A - B @ np.diag(g) @ C
            whole = (closed if discrete else expm(closed * rng.exponential(2 / (1e-9 + np.abs(A).max())))) @ whole
        most = max(most, np.abs(np.linalg.eigvals(whole)).max())
    return most


def pieces(rng, top, odd):
    """A continuous piecewise linear function through 0 with slopes in [0, top], straight beyond its corners."""
    corners = np.sort(rng.exponential(1.0, 4))
    at, slopes = np.concatenate([[0], corners]), gains_of(rng, 2, top, 4)
    up, down = (np.concatenate([[0], np.cumsum(np.diff(at) * side)]) for side in slopes.T)
    down = up if odd else down
    x, y = np.concatenate([-at[:0:-1], at]), np.concatenate([-down[:0:-1], up])
    beyond = rng.choice([0, top], 2) if not odd else np.full(2, rng.choice([0, top]))

    def phi(sigma):
        near = np.interp(sigma, x, y)
        return near + beyond[0] * np.minimum(sigma - x[0], 0) + beyond[1] * np.maximum(sigma - x[-1], 0)

    return phi


def simulated(parts, phis, rng, discrete, steps=400):
    """The largest state of the second half by that of the first, at most over 20 initial states of all sizes."""
    A, B, C = parts
    x = rng.normal(size=(20, len(A))) * np.geomspace(0.1, 1e3, 20)[:, None]
    step = 1.0 if discrete else 1 / (1 + np.abs(A).sum(axis=1).max() + np.abs(B @ C).sum())

    def moved(x):
        sigma = x @ C.T
        return x @ A.T - np.stack([phi(sigma[:, i]) for i, phi in enumerate(phis)], axis=1) @ B.T

    sizes = [np.linalg.norm(x, axis=1)]
    for _ in range(steps):
        if discrete:
            x = moved(x)
        else:  # Runge and Kutta's method of order 4
            k1 = moved(x)
            k2 = moved(x + step / 2 * k1)
            k3 = moved(x + step / 2 * k2)
            x = x + step / 6 * (k1 + 2 * k2 + 2 * k3 + moved(x + step * k3))
        sizes.append(np.linalg.norm(x, axis=1))
    sizes = np.array(sizes)
    return (sizes[steps // 2 :].max(axis=0) / sizes[: steps // 2].max(axis=0)).max()


@TIMES
@FEW
@given(seed=SEEDS, kind=ANY)
def test_no_member_destabilises_what_is_proved(discrete, seed, kind):
    rng = np.random.default_rng(seed)
    m = 2
    parts = A, B, C = drawn(seed, 2 + seed % 3, m, discrete)
    classes = [KINDS[kind](1)] * m
    repeated = "slope" in kind and seed % 2
    proved, _ = ends(asked(parts, Diagonal(tuple(classes), repeated=True) if repeated else classes, discrete))
    top = min(proved, FAR)
    constant = [np.full(m, t) for t in np.linspace(0, top, 30)] + [] if repeated else [*gains_of(rng, m, top, 60)]
    assert max(growth(A - B @ np.diag(g) @ C, discrete) for g in constant) < 1e-9
    if kind == "time-varying":
        assert max(jumps(parts, top, rng, discrete) for _ in range(20)) < 1 + 1e-9
    for _ in range(3):
        phis = [pieces(rng, top, kind == "odd") for _ in range(m)]
        assert simulated(parts, phis[:1] * m if repeated else phis, rng, discrete) < 1.5


# 1/(s + 1)^3 in both channels is stable up to 8: a claim that is wrong by 5 % does not survive
def test_the_attacks_see_what_is_not_stable():
    rng = np.random.default_rng(1)
    A, B, C = np.array([[0.0, 1, 0], [0, 0, 1], [-1, -3, -3]]), np.array([[0.0], [0], [1]]), np.array([[1.0, 0, 0]])
    both = block_diag(A, A), block_diag(B, B), block_diag(C, C)
    assert max(jumps(both, 8.4, rng, False) for _ in range(20)) > 1
    assert max(growth(both[0] - both[1] @ np.diag(g) @ both[2], False) for g in product((0, 8.4), repeat=2)) > 0
    assert simulated(both, [lambda sigma: 12 * sigma] * 2, rng, False) > 1.5
