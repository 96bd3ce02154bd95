"""The check of a Zames-Falb multiplier: the inequality, its bounds on boxes, and what a grid would miss."""

import math
from fractions import Fraction as F

import numpy as np
import pytest
from depth import sampled
from hypothesis import given, settings
from hypothesis import strategies as st
from multipliers import left_hand_side, samples, stable_blocks
from plants import CONTINUOUS as PLANTS
from plants import block

from lure.analysis.inequality.plant import TransferPolynomials
from lure.analysis.numerics import minimum
from lure.analysis.numerics.precision import ball
from lure.analysis.theorems.kernel_search import first_order
from lure.analysis.theorems.kernels import (
    Delay,
    Gamma,
    Inequality,
    Multiplier,
    check,
    multiplier_of,
    value_at,
)
from lure.plants.rational import RationalPlant


def test_multiplier_text_and_parameters():
    multiplier = Multiplier(F("-1/4"), ((F("1/2"), Delay(F(3))), (F("-1/8"), Gamma(F(2), 3, "anticausal"))))
    assert str(multiplier) == "1 - 0.5 exp(-3 s) + 0.125 (2/(2 - s))^3 - 0.25 s"
    assert multiplier_of(multiplier.to_parameters()) == multiplier
    assert multiplier.mass == F("5/8")
    assert multiplier.admissible(odd=True)
    assert not multiplier.admissible(odd=False)


@pytest.mark.parametrize("kernel", [Gamma(F(2), 1, "causal"), Gamma(F(3), 4, "causal"), Gamma(F(3), 2, "anticausal")])
def test_gamma_kernels_are_what_their_docstring_says(kernel):
    t = np.linspace(0, 40, 400_001)
    a, n = float(kernel.rate), kernel.order
    density = a**n * t ** (n - 1) * np.exp(-a * t) / math.factorial(n - 1)
    time = t if kernel.side == "causal" else -t
    assert np.trapezoid(np.abs(density), t) == pytest.approx(1, abs=1e-7)  # mass and L1 norm
    for omega in (0.0, 0.7, 3.0):
        transform = np.trapezoid(density * np.exp(-1j * omega * time), t)
        assert kernel.at(np.array([omega]))[0] == pytest.approx(transform, abs=1e-7)


def test_the_inequality_behind_the_theorem():
    # int v(t) e(t - tau) dt <= int v e dt for monotone phi, >= -int v e dt for odd phi, and the latter fails otherwise
    rng = np.random.default_rng(0)
    k, failed = 2.0, False
    for _ in range(200):
        sigma = rng.normal(size=16)
        for nonlinearity, odd in ((lambda s: np.clip(k * s, -0.1, 3.0), False), (lambda s: k * np.tanh(s), True)):
            v = nonlinearity(sigma)
            e = sigma - v / k
            products = np.array([np.dot(v, np.roll(e, shift)) for shift in range(16)])
            assert (products <= products[0] + 1e-12).all()
            if odd:
                assert (products >= -products[0] - 1e-12).all()
    for _ in range(200):
        sigma = rng.normal(size=16)
        v = k * np.maximum(sigma, 0)
        e = sigma - v / k
        failed |= bool((np.array([np.dot(v, np.roll(e, i)) for i in range(16)]) < -np.dot(v, e) - 1e-9).any())
    assert failed


def test_park_multiplier_as_a_zames_falb_multiplier():
    # 1 + theta s - tau s^2 = tau (a - s)(b + s) with a = 3, b = 1, tau = 1/3, theta = 2/3, and mirrored
    omega = np.array([0.0, 0.5, 2.0, 30.0])
    for theta in (F("2/3"), F("-2/3")):
        found = first_order(F(3), theta * 3, 10**6)
        park = 1 + omega**2 / 3 + 1j * omega * float(theta)
        ratio = park / found.at(omega)
        assert np.abs(ratio.imag).max() < 1e-12
        assert ratio.real.min() > 0
        assert found.terms == ((F("2/3"), Gamma(F(3), 1, "causal" if theta > 0 else "anticausal")),)


@st.composite
def multipliers(draw, odd=False):
    """Legal multipliers of at most three kernels."""
    count = draw(st.integers(0, 3))
    terms = []
    for _ in range(count):
        c = F(draw(st.integers(1, 99))) / (100 * count) * (draw(st.sampled_from([1, -1])) if odd else 1)
        if draw(st.booleans()):
            terms.append((c, Delay(F(draw(st.integers(1, 60))) / 10 * draw(st.sampled_from([1, -1])))))
        else:
            side = draw(st.sampled_from(["causal", "anticausal"]))
            terms.append((c, Gamma(F(draw(st.integers(1, 60))) / 10, draw(st.integers(1, 3)), side)))
    return Multiplier(F(draw(st.integers(-20, 20))) / 10, tuple(terms))


@settings(max_examples=sampled(20, of=60), deadline=None)
@given(stable_blocks(), multipliers(odd=True), st.integers(1, 60))
def test_check_agrees_with_dense_samples(system, multiplier, tenths):
    k, plant = F(tenths) / 10, TransferPolynomials.of(system)
    found = check(plant, k, multiplier)
    omega = samples(system, [0.0 if found.where is None or math.isinf(found.where) else found.where])
    values = left_hand_side(system, k, multiplier, omega)
    scale = (np.abs(system.transfer(1j * omega)) * (1 + omega * abs(float(multiplier.theta))) + 1 / float(k)) * 2
    if found.holds:
        assert (values > -1e-12 * scale).all()
    elif math.isfinite(found.where):  # it fails there, or nearly
        assert left_hand_side(system, k, multiplier, np.array([found.where]))[0] <= 1e-6 * scale.max()
    else:  # the limit of the left-hand side with every delay at its worst phase
        d, top = system.denominator, (*[F(0)] * (system.order + 1 - len(system.numerator)), *system.numerator)
        direct = 1 / k + top[0]
        mass = sum(abs(c) for c, kernel in multiplier.terms if isinstance(kernel, Delay))
        assert direct + multiplier.theta * (top[1] - top[0] * d[1]) <= mass * abs(direct)


@settings(max_examples=sampled(15, of=40), deadline=None)
@given(stable_blocks(), multipliers(), st.integers(1, 60), st.integers(0, 400))
def test_value_from_balls_and_from_doubles(system, multiplier, tenths, hundredths):
    omega, k = F(hundredths) / 100, F(tenths) / 10
    value = value_at(TransferPolynomials.of(system), k, multiplier, omega)
    H = abs(system.transfer(1j * float(omega)))
    expected = left_hand_side(system, k, multiplier, np.array([float(omega)]))[0]
    assert float(value) == pytest.approx(expected, abs=1e-9 * (1 + H) * (1 + float(omega)) + 1e-9)


@settings(max_examples=sampled(15, of=40), deadline=None)
@given(stable_blocks(), multipliers(odd=True), st.integers(1, 60), st.sampled_from(["1/1000", "7/3", "4096"]))
def test_symmetries_of_the_inequality(system, multiplier, tenths, text):
    factor, k, plant = F(text), F(tenths) / 10, TransferPolynomials.of(system)
    found = check(plant, k, multiplier).holds
    order = system.order
    # time scale: H(s / factor)
    n = [c / factor**i for c, i in zip(system.numerator, range(len(system.numerator) - 1, -1, -1), strict=True)]
    d = [c / factor**i for c, i in zip(system.denominator, range(order, -1, -1), strict=True)]
    assert check(TransferPolynomials.of(RationalPlant(n, d)), k, multiplier.scaled(factor)).holds is found
    # gain moved from the block to the nonlinearity
    louder = RationalPlant([factor * c for c in system.numerator], system.denominator)
    assert check(TransferPolynomials.of(louder), k / factor, multiplier).holds is found
    # time reversed: H(-s), where causal and anticausal change places
    n = [c * (-1) ** i for c, i in zip(system.numerator, range(len(system.numerator) - 1, -1, -1), strict=True)]
    d = [c * (-1) ** i for c, i in zip(system.denominator, range(order, -1, -1), strict=True)]
    assert check(TransferPolynomials.of(RationalPlant(n, d)), k, multiplier.mirrored()).holds is found
    # a smaller slope is never harder
    assert not found or check(plant, k * F("2/3"), multiplier).holds


def test_the_limit_of_a_multiplier_from_both_sides():
    # M = 1 - (1/2) exp(-s): the largest k is 1/max(-Re[M H]/Re M) since Re M >= 1/2, here from a fine grid
    system, multiplier = PLANTS[3], Multiplier(F(0), ((F("1/2"), Delay(F("-17/10"))),))
    omega = samples(system)
    omega = np.unique(np.concatenate([omega, np.linspace(2.3, 2.7, 400_001), np.linspace(0.3, 0.5, 400_001)]))
    M, H = multiplier.at(omega), system.transfer(1j * omega)
    limit = 1 / np.max(-(M * H).real / M.real)
    assert check(TransferPolynomials.of(system), F(limit * (1 - 1e-7)), multiplier).holds
    assert not check(TransferPolynomials.of(system), F(limit * (1 + 1e-7)), multiplier).holds


def test_a_dip_too_narrow_for_a_grid():
    # a resonance of width 1e-9 at w = 1: Re H = -x (1 - x)/((1 - x)^2 + 1e-18 x) dips to -5e8 beside it
    system = block("-1 0 0", "1 1e-9 1")
    for multiplier in (Multiplier(F(0), ()), Multiplier(F(0), ((F("1/100"), Delay(F(1))),))):
        assert check(TransferPolynomials.of(system), F("1e-9"), multiplier).holds
        assert not check(TransferPolynomials.of(system), F("3e-9"), multiplier).holds


@pytest.mark.slow
def test_a_long_delay_meets_every_phase():
    # with delay 1000 the least value is that of Re F - 0.9 |F|, F = H + 1/k, nearly: negative though Re F > 0.45 |F|
    system, k = block("1", "1 1 1"), F("3/5")
    multiplier = Multiplier(F(0), ((F("9/10"), Delay(F(1000))),))
    omega = np.linspace(0, 10, 2_000_001)
    phase = system.transfer(1j * omega) + 1 / float(k)
    assert (phase.real > 0.46 * np.abs(phase)).all()
    assert left_hand_side(system, k, multiplier, omega).min() < -0.01
    assert not check(TransferPolynomials.of(system), k, multiplier).holds
    assert check(TransferPolynomials.of(system), k, Multiplier(F(0), ((F("9/20"), Delay(F(1000))),))).holds


def test_an_inequality_that_fades_at_infinity():
    # 1/(s + 1), k = 1, theta = -1: Re[(1 - i w)/(1 + i w)] + 1 = 2/(1 + w^2) > 0, but no eps is left
    plant = TransferPolynomials.of(block("1", "1 1"))
    assert not check(plant, F(1), Multiplier(F(-1), ())).holds
    assert check(plant, F(1), Multiplier(F("-99/100"), ())).holds


# T k |d|^2 E, the left-hand side cleared of its denominators, on a ball and at points of it
@pytest.mark.parametrize("radius", ["0", "1/100", "1"])
def test_the_inequality_on_a_ball_holds_its_values(radius):
    plant, k, middle = TransferPolynomials.of(PLANTS[3]), F(2), F(6)
    multiplier = Multiplier(F("1/3"), ((F("1/2"), Delay(F(2))), (F("-1/4"), Delay(F(-1)))))
    inequality = Inequality.of(plant, k, multiplier, F(0))
    box = inequality.at(ball(middle - F(radius)).union(ball(middle + F(radius))))
    for omega in (middle + F(i) * F(radius) / 10 for i in range(-10, 11)):
        exact = inequality.at(ball(omega))
        assert box.overlaps(exact)
        size = abs(np.polyval([float(c) for c in PLANTS[3].denominator], 1j * float(omega))) ** 2
        assert float(exact) == pytest.approx(
            float(k) * size * left_hand_side(PLANTS[3], k, multiplier, np.array([float(omega)]))[0], rel=1e-9
        )


@pytest.mark.slow
def test_mass_one_of_delays_touches_zero(monkeypatch):
    # 1 - exp(-s) vanishes at w = 0, 2 pi, ...: no eps is left, at zero, at infinity or between
    monkeypatch.setattr(minimum, "MAX_BOXES", sampled(2000, of=minimum.MAX_BOXES))  # all of them are looked at
    assert not check(
        TransferPolynomials.of(block("1", "1 1 1")), F("1/10"), Multiplier(F(0), ((F(1), Delay(F(1))),))
    ).holds
    # with theta > 0 and relative degree one infinity is safe, zero is not
    assert not check(
        TransferPolynomials.of(block("1", "1 1")), F("1/10"), Multiplier(F(9), ((F(1), Delay(F(1))),))
    ).holds
