"""No Zames-Falb multiplier in continuous time reaches these slopes: weights found, checked, and checked another way."""

from dataclasses import replace
from fractions import Fraction as F
from functools import cache

import numpy as np
import pytest
from flint import fmpq_poly

from lure.analysis.inequality.polynomial import RationalInequality
from lure.analysis.numerics.minimum import nonnegative_from_zero
from lure.analysis.numerics.polynomial import to_fmpq
from lure.analysis.theorems import kernel_limit
from lure.analysis.theorems.kernel_limit import MultiplierLimit, multiplier_limit, rules_out
from lure.analysis.theorems.kernels import Delay, Gamma, Multiplier, check
from lure.errors import AssumptionError
from lure.plants.rational import RationalPlant

# Kalman and Fitts: s^2/((s + b)^2 + .81)((s + b)^2 + 1.21), b = .03.  Proved by a multiplier: .324761, odd .673854
FITTS = RationalPlant([1, 0, 0], [1, F("0.12"), F("2.0254"), F("0.121308"), F("0.98191881")])
PROVED = {False: 0.324761, True: 0.673854}


@cache
def limit(odd):
    return multiplier_limit(FITTS, odd=odd, above=PROVED[odd])


@pytest.mark.slow_for("True")
@pytest.mark.parametrize("odd", [False, True])
def test_the_limit_meets_what_is_proved(odd):
    found = limit(odd)
    assert PROVED[odd] < found.k < 1.001 * PROVED[odd]
    assert rules_out(FITTS, found)


@pytest.fixture
def few(monkeypatch):
    """A coarse comb: few harmonics, short polynomials."""
    monkeypatch.setattr(kernel_limit, "STEPS", (4,))


def coarse(odd):
    return multiplier_limit(FITTS, odd=odd, above=PROVED[odd])


def response(plant, omega):
    """``H(i w)`` in exact numbers."""
    values = []
    for coefficients in plant.numerator, plant.denominator:
        re, im = F(0), F(0)
        for c in coefficients:  # Horner at i w
            re, im = c - omega * im, omega * re
        values.append((re, im))
    (a, b), (c, d) = values
    return (a * c + b * d) / (c * c + d * d), (b * c - a * d) / (c * c + d * d)


def half_angle(found, plant, sign):
    """``g (1 + t^2)^N`` as a polynomial in ``t = tan(theta/2)``, by ``(1 + i t)^2n = (1 + t^2)^n exp(i n theta)``."""
    top = max(found.harmonics)
    square = fmpq_poly([1, 0, 1])
    total = fmpq_poly([])
    even, odd = [fmpq_poly([1])], [fmpq_poly([])]
    for _ in range(2 * top):
        even.append(even[-1] - fmpq_poly([0, 1]) * odd[-1])
        odd.append(odd[-1] + fmpq_poly([0, 1]) * even[-2])
    for n, weight in zip(found.harmonics, found.weights, strict=True):
        re, im = response(plant, n * found.base)
        x, y = (to_fmpq(weight * part) for part in (re + 1 / found.k, im))
        wave = (x * even[2 * n] + y * odd[2 * n]) * square ** (top - n)
        total += x * square**top - sign * wave
    return total


@pytest.mark.slow_for("True-1")
@pytest.mark.parametrize(("odd", "sign"), [(False, 1), (True, 1), (True, -1)])
@pytest.mark.usefixtures("few")
def test_an_exact_root_count_says_the_same(odd, sign):
    found = coarse(odd)
    p = half_angle(found, FITTS, sign)
    for half in p, p(fmpq_poly([0, -1])):
        assert nonnegative_from_zero(-half)
    lower = half_angle(replace(found, k=found.k * F("0.98")), FITTS, sign)
    if sign == 1:
        assert not all(nonnegative_from_zero(-half) for half in (lower, lower(fmpq_poly([0, -1]))))


def scaled(values, place, factor):
    return tuple(value * factor if i == place else value for i, value in enumerate(values))


def test_falsified_limits_are_refused():
    found = limit(False)
    more = (*found.harmonics[:-1], found.harmonics[-1] + 1)
    for changed in (
        {"k": found.k * F("0.999")},
        {"odd": True},
        {"weights": scaled(found.weights, 0, F(1001, 1000))},
        {"weights": scaled(found.weights, 0, -1)},
        {"weights": found.weights[1:]},
        {"weights": scaled(found.weights, 0, 0)},
        {"harmonics": more},
        {"harmonics": (found.harmonics[0], *found.harmonics[:-1])},
        {"harmonics": (0, *found.harmonics[1:])},
        {"harmonics": (), "weights": ()},
        {"base": -found.base},
        {"base": found.base * F(1001, 1000)},
        {"lower": F(1, 100)},
    ):
        assert not rules_out(FITTS, replace(found, **changed)), changed
    assert rules_out(FITTS, replace(found, k=found.k * 2))  # larger classes have no multiplier either
    other = RationalPlant([1, F(1, 100), 0], FITTS.denominator)
    assert not rules_out(other, found)


# A multiplier that proves a class cannot be ruled out for it: the weighted sum of its left-hand side is positive
def test_weights_and_multipliers_exclude_each_other():
    found = limit(True)
    s = 1j * np.array(found.frequencies)
    H = np.polyval([float(c) for c in FITTS.numerator], s) / np.polyval([float(c) for c in FITTS.denominator], s)
    weights = np.array([float(a) for a in found.weights])
    kernels = [Delay(F(5, 2)), Delay(F(-31, 7)), Gamma(F(1, 3), 2, "causal"), Gamma(F(4), 1, "anticausal")]
    for kernel in kernels:
        for sign in 1, -1:
            used = Multiplier(F(7), ((F(sign), kernel),))
            left = used.at(s.imag) * (H + 1 / float(found.k)) + 7 * s * H
            assert np.dot(weights, left.real) <= 1e-9 * np.dot(weights, np.abs(left))
            assert not check(RationalInequality.of(FITTS, F(0), "test").plant, found.k, used).holds


# phi in [-1/100, k] around H is phi + sigma/100 in [0, k + 1/100] around H/(1 - H/100)
@pytest.mark.usefixtures("few")
def test_the_class_may_begin_elsewhere():
    n, d = FITTS.numerator, FITTS.denominator
    around = RationalPlant(n, [b - (F(0), F(0), *n)[i] / 100 for i, b in enumerate(d)])
    one = multiplier_limit(FITTS, odd=False, lower=F(-1, 100), above=0.25)
    other = multiplier_limit(around, odd=False, above=0.26)
    assert 0.25 < one.k < other.k
    assert float(one.k) == pytest.approx(float(other.k) - 0.01, rel=1e-6)
    assert rules_out(FITTS, one)
    assert not rules_out(FITTS, replace(one, lower=F(0)))


@pytest.mark.usefixtures("few")
def test_there_is_none_where_every_slope_is_proved():
    assert multiplier_limit(RationalPlant([1], [1, 1]), odd=False) is None
    assert multiplier_limit(RationalPlant([2], [1]), odd=False) is None
    assert multiplier_limit(FITTS, odd=False, above=0.3, below=0.32) is None
    with pytest.raises(AssumptionError):
        multiplier_limit(RationalPlant([1], [1, -1]), odd=False)


def test_it_is_said_that_the_loop_is_another_question():
    assert "for any k from 0.3248" in str(limit(False))
    assert "another question" in str(limit(False))
    assert isinstance(limit(False), MultiplierLimit)
