"""Popov and circle criteria for the rod: values by hand, an independent computation, sharpness, scaling, refusals."""

import math
from fractions import Fraction

import numpy as np
import pytest
from depth import sampled
from flint import ctx
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from lure import AssumptionError, InputError, Sector
from lure.analysis.rod.popov import response_check, rod_criteria
from lure.analysis.rod.popov import rod_circle_criterion as circle_criterion
from lure.analysis.rod.popov import rod_popov_criterion as popov_criterion
from lure.analysis.verdict import INFINITE, Evidence, Verdict
from lure.rod import Rod, RodPlant, builtin_system, upwind
from lure.rod.systems import rod_from_exact

# E = rho = A = L = 1: c = Z = T = d = 1, so that k is the ratio k/Z and a = (k - 1)/(k + 1)
UNIT = {"youngs_modulus": 1, "density": 1, "length": 1, "area": 1, "compliance": 1}


def unit_rod(damping):
    return Rod(**UNIT, damping=damping)


def block_of(damping, cells):
    return RodPlant(unit_rod(damping)) if cells is None else upwind(unit_rod(damping), cells)


def least(f, lowest=1e-10, highest=60.0, points=6001):
    """Least value of f over omega > 0 by a grid that follows the resonances, then golden section around the best."""
    omega = np.unique(np.concatenate((np.geomspace(lowest, highest, points), np.linspace(lowest, highest, points))))
    values = f(omega)
    i = int(np.argmin(values))
    around = (omega[max(i - 1, 0)], omega[min(i + 1, omega.size - 1)])
    fine = minimize_scalar(
        lambda w: float(f(np.array([w]))[0]), bounds=around, method="bounded", options={"xatol": 1e-13}
    )
    return min(float(fine.fun), float(values[i]))


def needed_theta(block, upper):
    """sup over omega of (-1/k - Re H)/(-omega Im H), clipped at zero, from the transfer function alone."""

    def negative(omega):
        H = block.transfer(1j * omega)
        return (1 / upper + H.real) / (-omega * H.imag)

    return max(0.0, -least(negative))


ratios = st.floats(-6, 3).map(lambda x: 10.0**x).filter(lambda x: abs(x - 1) > 1e-3)
cell_counts = st.one_of(st.none(), st.integers(1, 1000))
uppers = st.one_of(st.just(math.inf), st.floats(-6, 6).map(lambda x: 10.0**x))


# k = 0.5: a = -1/3, 1 - a^2 = 8/9, so for every N and for the rod the smallest theta for [0, inf) is 4|a|T/(1 - a^2)
# = 3/2
# and the circle criterion reaches (1 - |a|)^2/(4 |a| d T) = (4/9)/(4/3) = 1/3.
@pytest.mark.parametrize("cells", [None, 1, 2, 10, 100_000])
def test_below_the_impedance_both_limits_are_attained_at_zero_frequency(cells):
    block = block_of(0.5, cells)
    popov, circle = popov_criterion(block, Sector(0, math.inf)), circle_criterion(block, Sector(0, 1))
    assert popov.smallest_theta.low <= 1.5 <= popov.smallest_theta.high
    assert popov.smallest_theta.width < 1e-12
    assert circle.largest.low <= 1 / 3 <= circle.largest.high
    assert circle.largest.width < 1e-12
    assert circle.verdict is Verdict.INCONCLUSIVE
    assert circle.worst_frequency == 0.0
    assert circle.margin.middle == pytest.approx(1 - 3, abs=1e-12)


# For a > 0 the rod needs 4 a T/(1 - a^2) times -min sinc = 0.21723362821122165; k = 2: a = 1/3, factor 3/2.
def test_above_the_impedance_the_rod_needs_the_least_value_of_sinc():
    result = popov_criterion(block_of(2, None), Sector(0, math.inf))
    assert result.smallest_theta.middle == pytest.approx(1.5 * 0.21723362821122165, rel=1e-9)


# N = 1, k > Z: psi stays below pi, Re H = 2 a d r sin(psi)/(omega D) > 0 at every finite frequency.
def test_one_cell_above_the_impedance_needs_no_multiplier_and_the_circle_reaches_every_sector():
    scheme = block_of(3, 1)
    assert popov_criterion(scheme, Sector(0, math.inf)).smallest_theta.high == 0.0
    assert circle_criterion(scheme, Sector(0, 1e12)).verdict is Verdict.PROVED
    unbounded = circle_criterion(scheme, Sector(0, math.inf))
    assert unbounded.largest == INFINITE
    assert unbounded.verdict is Verdict.INCONCLUSIVE  # Re H tends to zero at infinity: not strict there
    assert unbounded.worst_frequency == math.inf


# k = Z: H = d/s exactly, Re H = 0 and -omega Im H = d: the expression is 1/k + theta d at every frequency.
@pytest.mark.parametrize("cells", [None, 1, 7, 1000])
@pytest.mark.parametrize("theta", [0.0, 0.25, 3.0])
def test_the_matched_rod_has_the_margin_of_an_integrator(cells, theta):
    result = popov_criterion(block_of(1, cells), Sector(0, 2), theta=theta)
    assert result.margin.low <= 0.5 + theta <= result.margin.high
    assert result.margin.width < 1e-12
    assert result.verdict is Verdict.PROVED


@settings(max_examples=sampled(6, of=12))
@given(ratio=ratios, cells=cell_counts, upper=uppers)
def test_smallest_theta_agrees_with_a_search_over_the_transfer_function(ratio, cells, upper):
    block = block_of(ratio, cells)
    bracket = popov_criterion(block, Sector(0, upper)).smallest_theta
    found = needed_theta(block, upper)
    assert found <= bracket.high * (1 + 1e-6) + 1e-9
    assert found >= bracket.low * (1 - 1e-4) - 1e-9


@settings(max_examples=sampled(6, of=12))
@given(ratio=ratios, cells=cell_counts)
def test_circle_limit_agrees_with_a_search_over_the_transfer_function(ratio, cells):
    block = block_of(ratio, cells)
    largest = circle_criterion(block, Sector(0, 1)).largest
    lowest = least(lambda omega: block.transfer(1j * omega).real)
    if largest.low == math.inf:
        assert lowest > -1e-12
    else:
        assert lowest >= -1 / largest.low * (1 + 1e-6)
        assert lowest <= -1 / largest.high * (1 - 1e-3)


@pytest.mark.slow
@settings(max_examples=sampled(6, of=12))
@given(ratio=ratios, cells=cell_counts, upper=uppers, stretch=st.floats(0, 4))
def test_margin_is_a_lower_bound_that_is_nearly_attained(ratio, cells, upper, stretch):
    block = block_of(ratio, cells)
    theta = stretch * popov_criterion(block, Sector(0, upper)).theta
    result = popov_criterion(block, Sector(0, upper), theta=theta)

    def expression(omega):
        return 1 / upper + ((1 + 1j * omega * theta) * block.transfer(1j * omega)).real

    found = least(expression)
    scale = abs(found) + 1 / upper + 1e-9 * (1 + theta)
    assert found >= result.margin.low - 1e-6 * scale
    assert found <= result.margin.high + 1e-3 * scale or result.worst_frequency in (0.0, math.inf)


# many periods, where the reduction to the first one (notes/0004) would show if it were wrong
@pytest.mark.slow
@settings(max_examples=sampled(6, of=12))
@given(
    ratio=ratios, cells=st.one_of(st.none(), st.integers(2, 300)), stretch=st.floats(0, 4), period=st.integers(1, 40)
)
def test_no_later_period_of_the_phase_lies_below_the_margin(ratio, cells, stretch, period):
    block = block_of(ratio, cells)
    theta = stretch * popov_criterion(block, Sector(0, math.inf)).theta
    result = popov_criterion(block, Sector(0, math.inf), theta=theta)
    angle = 2 * math.pi * period + np.linspace(0, 2 * math.pi, 500)
    if cells is not None:
        angle = angle[angle < math.pi * cells * (1 - 1e-9)]
    omega = angle / 2 if cells is None else cells * np.tan(angle / (2 * cells))
    values = ((1 + 1j * omega * theta) * block.transfer(1j * omega)).real
    assert np.all(values >= result.margin.low - 1e-7 * np.abs(values) - 1e-9 * (1 + theta))


@pytest.mark.slow
@settings(max_examples=sampled(3, of=12))
@given(ratio=ratios, cells=cell_counts, upper=st.one_of(st.just(math.inf), st.floats(1e-6, 1e6)))
def test_popov_is_sharp_at_the_smallest_theta(ratio, cells, upper):
    block = block_of(ratio, cells)
    smallest = popov_criterion(block, Sector(0, upper)).smallest_theta
    above = smallest.high * (1 + 1e-6) + (1e-12 if math.isfinite(upper) else 1e-6)
    assert popov_criterion(block, Sector(0, upper), theta=above).verdict is Verdict.PROVED
    if smallest.low > 0:
        below = popov_criterion(block, Sector(0, upper), theta=smallest.low * (1 - 1e-6))
        assert below.verdict is Verdict.INCONCLUSIVE
        assert below.margin.high < 0


@pytest.mark.slow
@settings(max_examples=sampled(6, of=12))
@given(ratio=ratios, cells=cell_counts)
def test_circle_is_sharp_at_its_largest_sector(ratio, cells):
    block = block_of(ratio, cells)
    largest = circle_criterion(block, Sector(0, 1)).largest
    if math.isfinite(largest.high):
        assert circle_criterion(block, Sector(0, largest.low * (1 - 1e-6))).verdict is Verdict.PROVED
        assert circle_criterion(block, Sector(0, largest.high * (1 + 1e-6))).verdict is Verdict.INCONCLUSIVE
    else:
        assert cells == 1
        assert ratio > 1


@pytest.mark.slow
@settings(max_examples=sampled(6, of=12))
@given(ratio=ratios, cells=cell_counts, upper=uppers)
def test_popov_reaches_every_sector_and_what_holds_for_a_stiffer_obstacle_holds_for_a_softer_one(ratio, cells, upper):
    block = block_of(ratio, cells)
    result = popov_criterion(block, Sector(0, upper))
    assert result.verdict is Verdict.PROVED
    assert result.evidence is Evidence.CERTIFIED
    assert result.largest == INFINITE
    if circle_criterion(block, Sector(0, upper)).verdict is Verdict.PROVED:
        assert result.smallest_theta.low == 0.0
        assert circle_criterion(block, Sector(0, upper / 2 if math.isfinite(upper) else 1)).verdict is Verdict.PROVED


# theta scales as time, the margin as 1/sector: a rod of length lambda L has T, theta, omega scaled by lambda, d
# unchanged.
@pytest.mark.slow
@settings(max_examples=sampled(6, of=12))
@given(ratio=ratios, cells=cell_counts, stretch=st.sampled_from([Fraction(1, 1000), Fraction(1, 7), 3, 10_000]))
def test_a_longer_rod_scales_theta_and_the_circle_limit(ratio, cells, stretch):
    short, long = unit_rod(ratio), Rod(**{**UNIT, "length": stretch}, damping=ratio)
    blocks = [RodPlant(rod) if cells is None else upwind(rod, cells) for rod in (short, long)]
    one, other = (popov_criterion(block, Sector(0, math.inf)) for block in blocks)
    assert other.smallest_theta.high == pytest.approx(float(stretch) * one.smallest_theta.high, rel=1e-8)
    one, other = (circle_criterion(block, Sector(0, 1)) for block in blocks)
    assert other.largest.low == pytest.approx(one.largest.low / float(stretch), rel=1e-8)


@pytest.mark.parametrize("damping", [0, -0.5, -2])
@pytest.mark.parametrize("cells", [None, 1, 10])
@pytest.mark.parametrize("criterion", [popov_criterion, circle_criterion])
def test_no_damping_is_inconclusive_and_negative_damping_is_refuted(damping, cells, criterion):
    result = criterion(block_of(damping, cells), Sector(0, 1))
    expected = Verdict.INCONCLUSIVE if damping == 0 else Verdict.REFUTED
    assert result.verdict is expected
    assert result.margin is None
    assert (result.witness is None) == (damping == 0)
    assert ("double" in result.reason) == (damping == 0)


# the witnesses: for k = -1/2 the mode m = 0 of the scheme is real and positive; for k = -2 the gain 1 has a positive
# real pole
@pytest.mark.parametrize("cells", [1, 2, 5, 10])
def test_each_refutation_names_a_loop_that_really_is_unstable(cells):
    scheme = block_of(-0.5, cells)
    assert np.max(np.linalg.eigvals(scheme.block.dense()).real) > 1e-3
    scheme = block_of(-2, cells)
    closed = scheme.block.dense() - np.outer(scheme.b1, scheme.c)
    values = np.linalg.eigvals(closed)
    assert np.max(values[np.abs(values.imag) < 1e-9].real) > 1e-3


@pytest.mark.slow
def test_the_sign_of_a_tiny_damping_is_decided_exactly():
    tiny = Fraction(1, 10**100)
    values = {**{name: Fraction(value) for name, value in UNIT.items()}, "exponent": Fraction(1), "gap": Fraction(0)}
    verdicts = [
        popov_criterion(upwind(rod_from_exact({**values, "damping": damping}), 3), Sector(0, 1)).verdict
        for damping in (tiny, Fraction(0), -tiny)
    ]
    assert verdicts == [Verdict.PROVED, Verdict.INCONCLUSIVE, Verdict.REFUTED]


# k = 2: the circle criterion reaches 2.66..; three boxes cannot show it for 2, and must not say so
@pytest.mark.parametrize("boxes", [0, 1, 3])
def test_an_exhausted_budget_widens_the_brackets_and_proves_nothing(monkeypatch, boxes):
    block = block_of(2, None)
    sharp, smallest = circle_criterion(block, Sector(0, 2)), popov_criterion(block, Sector(0, math.inf)).smallest_theta
    assert sharp.verdict is Verdict.PROVED
    monkeypatch.setattr("lure.analysis.numerics.minimum.MAX_BOXES", boxes)
    blunt, wide = circle_criterion(block, Sector(0, 2)), popov_criterion(block, Sector(0, math.inf)).smallest_theta
    assert blunt.verdict is Verdict.INCONCLUSIVE
    assert blunt.margin.low < 0 < blunt.margin.high
    assert blunt.largest.low < sharp.largest.low
    assert blunt.largest.high >= sharp.largest.high
    assert wide.low <= smallest.low <= smallest.high <= wide.high
    assert wide.width > 1e-3


@pytest.mark.parametrize("sector", [Sector(1, 2), Sector(-1, 1), Sector(-2, 0)])
def test_a_sector_that_does_not_start_at_zero_is_refused(sector):
    with pytest.raises(AssumptionError, match="shift the loop first"):
        popov_criterion(block_of(1, 3), sector)


@pytest.mark.parametrize("theta", [-1.0, math.nan, math.inf])
def test_a_multiplier_that_is_negative_or_not_finite_is_refused(theta):
    with pytest.raises(AssumptionError, match="finite theta >= 0"):
        popov_criterion(block_of(1, 3), Sector(0, 1), theta=theta)


# With eps = 1 m/Pa, 1 - |a| = 2 k/(k + Z), 4|a|T and d = 1/48000: (1 - |a|)^2/(4 |a| d T) = 8.0000002222 Pa/m
def test_the_papers_rod_is_inside_the_circle_criterion_already():
    popov, circle, popov_rod, circle_rod = rod_criteria(upwind(builtin_system("paper-rod").rod, 10))
    assert [r.verdict for r in (popov, circle, popov_rod, circle_rod)] == [Verdict.PROVED] * 4
    assert [(r.criterion, r.model) for r in (popov, circle, popov_rod, circle_rod)] == [
        ("popov", "scheme"),
        ("circle", "scheme"),
        ("popov", "rod"),
        ("circle", "rod"),
    ]
    k, Z, T, d = 2e-4, 1.2, 1 / 6000, 1 / 48000
    size = (Z - k) / (Z + k)
    assert circle.largest.middle == pytest.approx((2 * k / (k + Z)) ** 2 / (4 * size * d * T), rel=1e-12)
    assert popov.smallest_theta.high == 0.0


@pytest.mark.slow
def test_python_control_and_the_closed_form_agree():
    check = response_check(upwind(builtin_system("paper-rod").rod, 10))
    assert check.frequencies == 200
    assert check.difference < 1e-8
    assert "skipped" not in str(check)


def test_python_control_is_not_asked_for_a_huge_scheme():
    check = response_check(upwind(builtin_system("paper-rod").rod, 100_000))
    assert check.difference is None
    assert "too long" in str(check)


def test_a_criterion_has_no_truth_value():
    with pytest.raises(TypeError, match="three answers"):
        bool(popov_criterion(block_of(1, 3), Sector(0, 1)))


# for k = 20 the least value at theta = 0.05 is -5.6608..; with series of one term the Taylor boxes claimed -5.6468..
@pytest.mark.parametrize("cap", [1, 2, 5])
def test_brackets_do_not_depend_on_the_series_length_that_a_caller_has_set(cap):
    expected = popov_criterion(block_of(20, None), Sector(0, math.inf), theta=0.05)
    before, ctx.cap = ctx.cap, cap
    try:
        found = popov_criterion(block_of(20, None), Sector(0, math.inf), theta=0.05)
    finally:
        ctx.cap = before
    assert (found.margin, found.smallest_theta) == (expected.margin, expected.smallest_theta)


# k/Z = 1e300/1e-205 and k/Z = 1e-300/1e200: both parameters are doubles, their ratio is not
@pytest.mark.slow
@pytest.mark.parametrize(
    ("modulus", "density", "area", "length", "damping", "cells"),
    [(1e-300, 1e-100, 1e-5, 1.0, 1e300, 3), (1e300, 1e100, 1.0, 1e-100, 1e-300, None)],
)
def test_a_ratio_of_damping_to_impedance_beyond_doubles_is_no_obstacle(modulus, density, area, length, damping, cells):
    rod = Rod(youngs_modulus=modulus, density=density, area=area, length=length, damping=damping, compliance=1)
    block = RodPlant(rod) if cells is None else upwind(rod, cells)
    assert popov_criterion(block, Sector(0, math.inf)).verdict is Verdict.PROVED


# smallest theta about L rho A/k = 1e20 1e10 1/1e-300 s
def test_a_multiplier_beyond_doubles_is_refused_in_one_sentence():
    rod = Rod(youngs_modulus=1e-10, density=1e10, length=1e20, area=1, damping=1e-300, compliance=1)
    with pytest.raises(InputError, match="needs for this rod exceeds the largest double"):
        popov_criterion(RodPlant(rod), Sector(0, 1))


# m < 1: the chord at zero is vertical, the nonlinearity is not locally Lipschitz, and Popov's theorem is not about it
@pytest.mark.parametrize(("exponent", "said"), [(0.5, True), (1, False), (2, False)])
@pytest.mark.parametrize("criterion", [popov_criterion, circle_criterion])
def test_the_hypotheses_say_when_the_rods_own_law_is_not_in_the_class(criterion, exponent, said):
    rod = Rod(**UNIT, damping=1, exponent=exponent)
    hypotheses = criterion(RodPlant(rod), Sector(0, math.inf)).hypotheses
    assert any("fails for this rod's own nonlinearity" in text for text in hypotheses) is said
