"""Closed loops with drawn nonlinearities: what was proved of a class is not contradicted by any member of it.

A motion that does not grow proves nothing; one that grows would show that a proof is wrong.
"""

import math
from fractions import Fraction as F

import numpy as np
import pytest
from depth import sampled
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from motions import unit_rod
from scipy.integrate import solve_ivp

from lure import RationalPlant
from lure.analysis import Verdict, max_sector, max_slope
from lure.analysis.testing.strategies import (
    lurie_blocks,
    monotone_graphs,
    monotone_members,
    sector_graphs,
    sector_members,
)
from lure.rod import Scenario
from lure.rod.motion import Boundary, exact_motion

LARGEST = 20
GROWTH = 1e-6


def proved(answer):
    """The largest proved bound as a Fraction, capped; None where nothing is proved."""
    if answer.verdict is not Verdict.PROVED or not answer.largest.low > 0:
        return None
    return F(min(answer.largest.low, LARGEST))


def companion(block):
    """``(A, c)`` of the controllable canonical form, ``b`` being the last unit vector; exact."""
    n = block.order
    a = [[F(int(j == i + 1)) for j in range(n)] for i in range(n - 1)]
    a.append([-coefficient for coefficient in reversed(block.denominator[1:])])
    return a, [*reversed(block.numerator), *[F(0)] * (n - len(block.numerator))]


def exact_steps(block, nonlinearity, state, count):
    """``sigma`` of the discrete loop ``mu = -phi(sigma)``, in exact arithmetic."""
    a, c = companion(block)
    inputs = []
    for _ in range(count):
        inputs.append(sum(p * q for p, q in zip(c, state, strict=True)))
        state = [sum(p * q for p, q in zip(row, state, strict=True)) for row in a]
        state[-1] -= nonlinearity.exact(inputs[-1])
    return inputs


def float_steps(block, nonlinearity, state, count):
    """The states of the same loop in doubles."""
    rows, c = companion(block)
    a, c = np.array(rows, dtype=float), np.array(c, dtype=float)
    x = np.array(state, dtype=float)
    before, states = 0.0, []
    for _ in range(count):
        states.append(x)
        sigma = c @ x
        phi = (
            nonlinearity
            if not hasattr(nonlinearity, "respond")
            else (nonlinearity.rising if sigma > before else nonlinearity.falling)
        )
        x, before = a @ x, sigma
        x[-1] -= phi(sigma)
    return np.array(states)


def grows(states):
    """Whether the last third of a motion reaches farther than all before."""
    sizes = np.abs(states).max(axis=1)
    cut = 2 * len(sizes) // 3
    return sizes[cut:].max() > (1 + GROWTH) * sizes[:cut].max()


def starts(data, order):
    return [F(data.draw(st.integers(-3, 3))) for _ in range(order - 1)] + [F(1)]


@pytest.mark.slow
@given(st.data(), lurie_blocks(discrete=True, order=(1, 3)))
def test_discrete_loops_with_members_of_a_proved_sector_do_not_grow(data, block):
    k = proved(max_sector(block))
    assume(k is not None)
    nonlinearity, start = data.draw(sector_graphs(0, k)), starts(data, block.order)
    states = float_steps(block, nonlinearity, start, 900)
    assert not grows(states)
    # the first steps again, without rounding
    c = np.array(companion(block)[1], dtype=float)
    exact = np.array(exact_steps(block, nonlinearity, start, 25), dtype=float)
    assert np.allclose(states[:25] @ c, exact, rtol=1e-6, atol=1e-9 * np.abs(exact).max())


@pytest.mark.slow
@given(st.data(), lurie_blocks(discrete=True, order=(1, 3)))
def test_laws_with_memory_do_not_break_what_was_proved_of_time_varying_ones(data, block):
    k = proved(max_sector(block, time_varying=True))
    assume(k is not None)
    nonlinearity, start = data.draw(sector_members(0, k, memory=True)), starts(data, block.order)
    # not compared with exact steps: where sigma repeats itself, rounding decides which graph is taken
    assert not grows(float_steps(block, nonlinearity, start, 900))


@given(st.data(), lurie_blocks(discrete=True, order=(1, 3)))
def test_a_gain_beyond_the_refuted_one_grows(data, block):
    # the measure of growth can fail: the linear loop just beyond what was refuted has a pole outside the circle
    answer = max_sector(block)
    assume(answer.refuted_at is not None)
    gain = 1.05 * answer.refuted_at
    a, c = companion(block)
    closed = np.array(a, dtype=float)
    closed[-1] -= gain * np.array(c, dtype=float)
    radius = np.abs(np.linalg.eigvals(closed)).max()
    assume(radius > 1.005)
    assert grows(float_steps(block, lambda sigma: gain * sigma, starts(data, block.order), 900))
    assert max_sector(block).largest.low <= answer.refuted_at


def motion(block, nonlinearity, start, until):
    """States of the continuous loop at evenly spaced instants."""
    rows, c = companion(block)
    a, c = np.array(rows, dtype=float), np.array(c, dtype=float)
    b = np.eye(len(c))[-1]
    found = solve_ivp(
        lambda t, x: a @ x - b * float(nonlinearity(c @ x)),
        (0, until),
        np.array(start, dtype=float),
        method="LSODA",
        rtol=1e-8,
        atol=1e-10,
        t_eval=np.linspace(0, until, 1500),
    )
    assert found.success
    return found.y.T


@pytest.mark.slow
@settings(max_examples=sampled(5, of=1000))
@given(st.data(), lurie_blocks(order=(1, 3)))
def test_continuous_loops_with_members_of_a_proved_sector_do_not_grow(data, block):
    k = proved(max_sector(block))
    assume(k is not None)
    nonlinearity = data.draw(sector_members(0, k))
    assert not grows(motion(block, nonlinearity, starts(data, block.order), 80.0))


@pytest.mark.slow  # a multiplier is searched for each block
@settings(max_examples=sampled(4, of=12))
@given(st.data(), lurie_blocks(order=(1, 3)), st.booleans())
def test_continuous_loops_with_laws_of_a_proved_slope_do_not_grow(data, block, odd):
    k = proved(max_slope(block, odd=odd))
    assume(k is not None)
    nonlinearity = data.draw(monotone_members(k, odd=odd))
    assert not grows(motion(block, nonlinearity, starts(data, block.order), 80.0))


@pytest.mark.slow
@settings(max_examples=sampled(4, of=20))
@given(st.data(), lurie_blocks(order=(2, 3), critical=True))
def test_critical_loops_stay_bounded_and_come_to_rest(data, block):
    k = proved(max_sector(block))
    assume(k is not None)
    nonlinearity = data.draw(sector_members(0, k))
    states = motion(block, nonlinearity, starts(data, block.order), 150.0)
    sizes = np.abs(states).max(axis=1)
    # a line of equilibria where phi = 0: the state may settle at its largest, but not beyond what came before
    assert sizes[1000:].max() <= 1.01 * sizes[:1000].max()


def test_the_measure_sees_growth():
    # 1/(s + 1)^3 with phi = k sigma: poles -1 + k^(1/3) exp(+-i pi/3), real part 0.016 for k = 8.4, -0.004 for k = 7.9
    block = RationalPlant([1], [1, 3, 3, 1])
    assert max_sector(block).largest.low <= 8
    assert grows(motion(block, lambda sigma: 8.4 * sigma, [0, 0, 1], 80.0))
    assert not grows(motion(block, lambda sigma: 7.9 * sigma, [0, 0, 1], 80.0))


@pytest.mark.slow
@settings(max_examples=sampled(4, of=20))
@given(
    monotone_graphs(30, scale=F(1, 10)),
    st.sampled_from(["0.3*sin(3*x)", "0.2 - x/5", "x*(1 - x)"]),
    st.sampled_from([0, F(1, 3), 1, 4]),
    st.sampled_from([0, 0.5]),
)
def test_the_rod_never_gains_energy_from_a_monotone_law(nonlinearity, displacement, damping, end_damping):
    rod = unit_rod(damping=damping, gap=F(1, 20))
    scenario = Scenario.parse(displacement=displacement)
    run = exact_motion(rod, scenario, 12.0, boundary=Boundary(nonlinearity=nonlinearity, end_damping=end_damping))
    energy = np.array([run.energy(t) for t in np.linspace(0, 12, 97)])
    assert math.isfinite(energy[0])
    assert np.diff(energy).max() <= 1e-8 * energy[0]
    if damping == 0 and end_damping == 0:
        assert np.allclose(energy, energy[0], rtol=1e-7)  # and loses none without a dashpot
