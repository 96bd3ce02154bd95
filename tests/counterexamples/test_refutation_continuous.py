"""Periodic orbits in continuous time: published counterexamples, proofs that must fail, and simulations."""

import json
import math
from dataclasses import replace
from fractions import Fraction as F
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tampering import assert_both_reject, edited

from lure.analysis.certificates.refutations import accepted_witness
from lure.analysis.certificates.second import recheck
from lure.analysis.counterexamples import graphs, oscillation
from lure.analysis.counterexamples.balance import Balance, Wave
from lure.analysis.counterexamples.channel_orbits import Course, Found, Graphs
from lure.analysis.counterexamples.graphs import best_graphs
from lure.analysis.counterexamples.linear import companion, realisation
from lure.analysis.counterexamples.oscillation import oscillation_witness, sector_witness, wave_witness
from lure.analysis.counterexamples.piecewise import Flow, Itinerary, PiecewiseLoop, proved, refined, returns, saturation
from lure.analysis.counterexamples.search import accept_escape, accept_orbit_continuous
from lure.analysis.counterexamples.simulated import simulate_loop
from lure.analysis.verdict import Evidence
from lure.errors import InputError
from lure.nonlinearities import PiecewiseLinear, Saturation, Tanh
from lure.nonlinearities.piecewise_linear import Graph
from lure.plants.rational import RationalPlant

DAMPING = F("0.03")
FITTS = RationalPlant(
    [1, 0, 0], np.polymul([1, 2 * DAMPING, DAMPING**2 + F("0.81")], [1, 2 * DAMPING, DAMPING**2 + F("1.21")])
)
FITTS_SEED = (-0.8568501753859451, 1.5659435663914607, 0.5061096169300414, -1.061805076491118)
# x1' = -x2 - 10 phi, x2' = x1 - 10.1 phi, x3' = x4, x4' = -x3 - x4 + phi, sigma = x1 - 10.1 x3 - 0.1 x4, mu = -phi
BRAGIN = (
    [[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 1], [0, 0, -1, -1]],
    [10, F("10.1"), 0, -1],
    [1, 0, F("-10.1"), F("-0.1")],
)
BRAGIN_BLOCK = RationalPlant([F("10.1"), 10, 0, 0], np.polymul([1, 0, 1], [1, 1, 1]))


def test_the_matrices_and_the_block_of_the_second_counterexample_are_one():
    system = realisation(BRAGIN)
    for s in (2.0, 1j / 2, 1 + 3j):
        A = np.array([[float(v) for v in row] for row in system.A])
        b, c = (np.array([float(v) for v in side]) for side in (system.b, system.c))
        assert c @ np.linalg.solve(s * np.eye(4) - A, b) == pytest.approx(complex(BRAGIN_BLOCK.transfer(s)), rel=1e-12)


@pytest.mark.slow
def test_fitts_orbit_with_tanh_is_accepted_as_observed():
    witness = accept_orbit_continuous(FITTS, Tanh(scale=F("0.01")), FITTS_SEED, 11.917)
    assert (witness.kind, witness.evidence, witness.k) == ("simulated orbit", Evidence.OBSERVED, 100)
    assert witness.data["period"] == pytest.approx(11.917, abs=1e-3)


def test_fitts_orbit_with_a_saturation_of_the_same_slope_is_proved():
    witness = accept_orbit_continuous(FITTS, Saturation(gain=100), FITTS_SEED, 11.917)
    assert (witness.kind, witness.evidence, witness.k) == ("periodic orbit", Evidence.CERTIFIED, 100)
    assert witness.data["period"] == pytest.approx(11.917, abs=1e-3)
    assert witness.odd
    assert witness.slope_restricted


def test_a_loop_that_comes_to_rest_is_not_accepted():
    assert accept_orbit_continuous(FITTS, Saturation(gain=1), FITTS_SEED, 11.917) is None
    assert accept_orbit_continuous(RationalPlant([1], [1, 3, 3, 1]), np.tanh, [1, 2, 3], 6.0) is None


def test_bragin_leonov_kuznetsov_orbit_is_proved_from_a_distant_state():
    witness = accept_orbit_continuous(BRAGIN, Saturation(gain=1), (0, -20, 0, 0), 9.0)
    assert (witness.evidence, witness.k) == (Evidence.CERTIFIED, 1)


@pytest.mark.parametrize(("block", "reached"), [(FITTS, 1.52), (BRAGIN_BLOCK, 0.40)])
@pytest.mark.slow
def test_both_counterexamples_are_found_and_proved(block, reached):
    witness = found(block)
    assert (witness.kind, witness.evidence, witness.odd) == ("periodic orbit", Evidence.CERTIFIED, True)
    assert witness.k < reached
    assert_an_orbit(block, witness)
    assert oscillation_witness(block, odd=True, k=F(reached)).k <= reached
    assert oscillation_witness(block, odd=True, k=F(witness.k) / 2) is None


# The published third example, s^2/(s^4 + .2 s^3 + 6 s^2 + .1 s + 1): all slopes up to 2.2526 are proved stable; with
# two kinks the orbits of saturations begin at 703.9, with four at 4.938.  Fitts's: odd slopes up to .6738 are proved,
# all up to .3247; half waves of odd nonlinearities begin at 1.4994.
THIRD = RationalPlant([1, 0, 0], [1, F("0.2"), 6, F("0.1"), 1])


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("block", "odd", "proved_up_to", "reached"),
    [
        pytest.param(FITTS, False, 0.3247, 0.5449, id="saturated earlier on one side"),
        pytest.param(FITTS, True, 0.6738, 0.95, id="an odd nonlinearity without half waves"),
        pytest.param(THIRD, True, 2.2526, 4.05, id="six kinks"),
    ],
)
def test_staircases_oscillate_at_smaller_slopes(block, odd, proved_up_to, reached):
    witness = wave_witness(block, odd=odd)
    assert (witness.kind, witness.evidence, witness.odd) == ("periodic orbit", Evidence.CERTIFIED, odd)
    assert proved_up_to < witness.k < reached
    assert_an_orbit(block, witness)


# 1/(s + 1)^3 has a root at i sqrt(3) with the gain 8: for sigma = cos(sqrt(3) t) the least slope of a graph is 8.
# x'' + .2 x' + x = -phi(x'): H = s/(s^2 + .2 s + 1), and no slope >= 0 lets it oscillate; what is missed is paid for.
@pytest.mark.parametrize(
    ("n", "d", "omega", "price", "cost"),
    [([1], [1, 3, 3, 1], math.sqrt(3), 1e3, 8.0), ([1, 0], [1, "0.2", 1], 1.0, 7.0, 7.0)],
)
def test_the_best_graph_for_a_wave_is_a_linear_programme(n, d, omega, price, cost):
    system = companion(RationalPlant(n, [F(v) for v in d]))
    A, b = np.array(system.A, dtype=float), np.array(system.b, dtype=float)[:, None]
    c, none = np.array(system.c, dtype=float)[None], np.zeros((1, 1))
    balance = Balance(A, b, c, none, np.zeros(1), np.ones(1), [range(1)], [True], (1, 3), [0])
    found = best_graphs(balance, Wave(1.0, omega, np.array([[1.0 + 0j, 0.0]]), ()), price)
    assert found.cost == pytest.approx(cost, rel=1e-3)
    assert found.wave.alpha == pytest.approx(cost if cost == 8 else 0.0, abs=1e-2)
    if cost == 8:
        assert found.wave.sides[0][0] == (True, pytest.approx(np.array([])))
    steep = best_graphs(balance, Wave(1.0, omega, np.array([[1.0 + 0j, 0.0]]), ()), price, points=4)
    assert steep.cost == pytest.approx(cost, rel=1e-3)  # the first harmonic of what lies below k sigma is below k


# The same plant with its sign reversed: staircases of slope in [0, k] oscillate from 1.342 on, all k < .364 are proved.
# In the sector [0, k] alone the graph may be steep.
@pytest.mark.slow
def test_graphs_of_a_sector_oscillate_at_smaller_gains(monkeypatch):
    monkeypatch.setattr(oscillation, "_POINTS", (4,))
    monkeypatch.setattr(graphs, "_BEST", 1)
    block = RationalPlant([-1, 0, 0], [1, F("0.2"), 6, F("0.1"), 1])
    witness = accepted_witness(block, sector_witness(block))
    assert (witness.kind, witness.odd, witness.slope_restricted) == ("periodic orbit", True, False)
    assert 0.364 < witness.k < 1.342
    assert_an_orbit(block, witness)
    certificate = witness.refutation.certificate
    assert recheck(json.dumps(certificate)).accepted
    k = certificate["laws"]["sector"][1]
    for change in ({"sector": ["0", str(F(k) * F(999, 1000))]}, {"slope": ["0", k]}):
        assert_both_reject({**certificate, "laws": {**certificate["laws"], **change}})
    points = certificate["proof"]["points"]
    lower = [[x, str(F(w) * F(99, 100))] for x, w in points]
    assert_both_reject(edited(certificate, "proof", "points", value=lower))


# Not bounded, the graph of the second of these waves has 1 + D slope = -.19, and with D = -.3 -.65: no loop at all,
# and InputError ended the whole answer.
@pytest.mark.parametrize(
    ("n", "first", "end"), [(["0.1", "0.02", "1.6", "0.01", "0.1"], 20, 0), (["-0.3", "0", "1", "0", "-0.1"], 0, 20)]
)
def test_graphs_of_a_sector_keep_the_loop_well_posed(n, first, end):
    system = companion(RationalPlant([F(v) for v in n], [1, F("0.2"), 6, F("0.1"), 1]))
    A, b = np.array(system.A, dtype=float), np.array(system.b, dtype=float)[:, None]
    c, D = np.array(system.c, dtype=float)[None], np.array([[float(system.d)]])
    balance = Balance(A, b, c, D, np.zeros(1), np.ones(1), [range(1)], [True], (1, 3), [0])
    wave = list(graphs._drawn(balance))[1]
    values, at = best_graphs(balance, wave, 100.0, points=8).slopes, graphs._Points(balance, wave, 8).at
    steps = 1 + D[0, 0] * np.diff(values, prepend=0.0) / at[0]
    assert steps.min() == pytest.approx(0.05)
    points = [(F(-2), -F(end)), (F(-1), -F(first)), (F(0), F(0)), (F(1), F(first)), (F(2), F(end))]
    steep, nowhere = Graphs.through([(points, F(0), F(0))], [1]), Course([], [], [], half=True)
    assert oscillation._shown(system, Found(F(1), steep, [], nowhere)) is None


def test_up_to_order_three_there_is_nothing_to_be_found():
    assert wave_witness(RationalPlant([1], [1, 2, 2, 1]), odd=False) is None
    assert sector_witness(RationalPlant([1], [1, 2, 2, 1])) is None
    assert sector_witness(RationalPlant([1, 0, 0], [1, 4, 6, 4, 1])) is None  # nor without two resonances


@cache
def found(block):
    return oscillation_witness(block, odd=True)


def assert_an_orbit(block, witness):
    """The witness, integrated by a general method: back at the first state after one period."""
    points = [(F(x), F(y)) for x, y in witness.data["points"]]
    nonlinearity = PiecewiseLinear(
        points, left_slope=F(witness.data["left_slope"]), right_slope=F(witness.data["right_slope"])
    )
    assert float((nonlinearity.slope_bounds if witness.slope_restricted else nonlinearity.sector).upper) <= witness.k
    assert nonlinearity.odd == witness.odd
    system = companion(block)
    A = np.array([[float(v) for v in row] for row in system.A])
    b, c = (np.array([float(v) for v in side]) for side in (system.b, system.c))
    x0 = np.array(witness.data["state"])
    run = solve_ivp(
        lambda _, x: A @ x - b * float(nonlinearity(c @ x)),
        (0, witness.data["period"]),
        x0,
        method="DOP853",
        rtol=1e-10,
        atol=1e-12,
        max_step=0.05,
    )
    assert np.abs(run.y[:, -1] - x0).max() < 1e-6 * np.abs(x0).max()


# 1/(s+1)^3: Popov reaches the Hurwitz limit 8, so no nonlinearity with slope below 8 oscillates; for (s+1)/(s^2+2s)
# every nonlinearity is harmless, and the first plant of the continuous set is absolutely stable for slopes up to its
# Hurwitz limit.
@pytest.mark.slow_for("top0-bottom0", "top2-bottom2")
@pytest.mark.parametrize(
    ("top", "bottom"),
    [([1], [1, 3, 3, 1]), ([1, 1], [1, 2, 0]), ([1, F("-0.2"), F("-0.1")], [1, 2, 1, 1])],
)
def test_nothing_is_found_where_nothing_is(top, bottom):
    assert oscillation_witness(RationalPlant(top, bottom), odd=True) is None


def test_discrete_time_and_unstable_loops_have_no_witness_here():
    assert oscillation_witness(RationalPlant([1], [1, F(1, 2)], dt=1), odd=True) is None
    assert oscillation_witness(RationalPlant([1], [1, -1]), odd=True) is None
    assert oscillation_witness(RationalPlant([3], [1]), odd=True) is None


# With y = sigma + d phi the loop of H + d and phi is that of H and psi, psi(y) = phi(sigma): s turns into s/(1 + d s).
@pytest.mark.slow
def test_feedthrough_is_absorbed():
    d = F(1, 4)
    bottom = BRAGIN_BLOCK.denominator
    shifted = RationalPlant(np.polyadd([d * c for c in bottom], list(BRAGIN_BLOCK.numerator)), bottom)
    plain, through = (found(block) for block in (BRAGIN_BLOCK, shifted))
    assert through.evidence is Evidence.CERTIFIED
    assert through.k == pytest.approx(plain.k / (1 - float(d) * plain.k), rel=1e-3)


@pytest.fixture(scope="module")
def orbit():
    loop = PiecewiseLoop.of(companion(FITTS), saturation(F(5), F(0)))
    passages = Flow(loop).passages(-5 * np.array(FITTS_SEED), 2000)
    i, j = returns(passages)
    middle = i + (j - i) // 2
    half = Itinerary(
        pieces=tuple(p.piece for p in passages[i:middle]),
        durations=tuple(F(p.duration) for p in passages[i:middle]),
        state=tuple(F(v) for v in passages[i].state),
        half=True,
    )
    return loop, refined(loop, half)


def test_the_orbit_is_proved_as_half_and_as_whole(orbit):
    loop, half = orbit
    assert proved(loop, half)
    mirrored = tuple(loop.mirrored(p) for p in half.pieces)
    whole = Itinerary(pieces=half.pieces + mirrored, durations=half.durations * 2, state=half.state, half=False)
    assert proved(loop, whole)
    assert whole.period == pytest.approx(half.period, rel=1e-15)


def test_what_is_not_the_orbit_is_not_proved(orbit):
    loop, half = orbit
    assert not proved(loop, replace(half, durations=tuple(t * F(101, 100) for t in half.durations)))
    assert not proved(loop, replace(half, state=tuple(v * F(101, 100) for v in half.state)))
    assert not proved(loop, replace(half, half=False))  # does not close
    assert not proved(loop, replace(half, pieces=tuple(2 - p for p in half.pieces)))  # the mirror image of the pieces
    assert not proved(loop, replace(half, pieces=(0, 2)))  # no neighbours
    weaker = PiecewiseLoop.of(companion(FITTS), saturation(F(3), F(0)))
    assert not proved(weaker, half)
    one_sided = PiecewiseLoop.of(companion(FITTS), Graph.through([(F(-1), F(-5)), (F(1), F(5))], F(0), F(1, 100)))
    assert not proved(one_sided, half)  # not odd


def test_an_orbit_that_would_leave_its_pieces_is_not_proved():
    # Closure and levels hold as before, but beyond half the orbit's peak the nonlinearity turns up again.
    loop = PiecewiseLoop.of(companion(FITTS), saturation(F(5), F(0)))
    passages = Flow(loop).passages(-5 * np.array(FITTS_SEED), 2000)
    settled = simulate_loop(FITTS, loop.nonlinearity, passages[-2].state, 20.0)
    level = F(float(np.abs(settled.sigma).max()) / 2)
    assert level > 1
    nonlinearity = Graph.through([(-level, F(-5)), (F(-1), F(-5)), (F(1), F(5)), (level, F(5))], F(1), F(1))
    i, j = returns(passages)
    pieces = tuple({0: 1, 1: 2, 2: 3}[p.piece] for p in passages[i:j])
    durations = tuple(F(p.duration) for p in passages[i:j])
    state = tuple(F(v) for v in passages[i].state)
    candidate = Itinerary(pieces=pieces, durations=durations, state=state, half=False)
    bent = PiecewiseLoop.of(companion(FITTS), nonlinearity)
    assert refined(bent, candidate) is not None
    assert not proved(bent, refined(bent, candidate))


@pytest.mark.slow
def test_escape_from_a_double_zero_is_observed():
    def nonlinearity(sigma):
        return sigma * np.exp(-np.abs(sigma))

    witness = accept_escape(RationalPlant([1, 1], [1, 0, 0]), nonlinearity, (1, 5), 2000)
    assert (witness.kind, witness.evidence) == ("simulated orbit", Evidence.OBSERVED)
    assert accept_escape(RationalPlant([1, 1], [1, 2, 0]), nonlinearity, (1, 5), 2000) is None


@pytest.mark.slow
def test_piecewise_flow_agrees_with_an_integrator():
    nonlinearity = Graph.through([(F(-2), F(-1)), (F(-1), F(-1)), (F(1), F(2)), (F(3), F(2))], F(1, 2), F(1, 3))
    for block in (FITTS, RationalPlant([1, 2, 5], [1, 1, 4]), RationalPlant([1], [1, 3, 2, 0])):
        x0 = np.linspace(3, -4, block.order)
        exact = simulate_loop(block, nonlinearity, x0, 15.0, samples=151)
        general = simulate_loop(block, lambda sigma: nonlinearity(sigma), x0, 15.0, samples=151)
        scale = np.abs(general.states).max()
        assert np.abs(exact.states - general.states).max() < 1e-5 * scale
        assert np.abs(exact.sigma - general.sigma).max() < 1e-5 * np.abs(general.sigma).max()


# y+ = y/2 + 2 u + (23/25) u_prev with the nonlinearity of benchmarks: u = (192/415, 192/415, -1) repeats.
def test_discrete_recursion_repeats_a_known_orbit():
    block = RationalPlant([2, F(23, 25)], [1, F(-1, 2), 0], dt=1)
    nonlinearity = PiecewiseLinear(
        [(F(-36864, 72625), F(-192, 415)), (F(0), F(0)), (F(192, 175), F(1))], left_slope=0, right_slope=0
    )
    u = np.array([192 / 415, 192 / 415, -1.0] * 40)
    x = np.zeros(2)
    A, b = np.array([[0, 1], [0, 0.5]]), np.array([0, 1.0])
    for value in u:  # the linear part driven by the orbit forgets where it began
        x = A @ x + b * value
    motion = simulate_loop(block, nonlinearity, x, 9.0)
    assert motion.sigma[:3] == pytest.approx(motion.sigma[3:6], rel=1e-12)
    assert -nonlinearity(motion.sigma[:3]) == pytest.approx(u[:3], rel=1e-12)


def test_bad_input_is_refused_in_one_sentence():
    block = RationalPlant([1], [1, 1])
    with pytest.raises(InputError, match="1 finite number"):
        simulate_loop(block, np.tanh, [1, 2], 1.0)
    with pytest.raises(InputError, match="positive time"):
        simulate_loop(block, np.tanh, [1], 0.0)
    with pytest.raises(InputError, match="not well posed"):
        PiecewiseLoop.of(companion(RationalPlant([-1, 0], [1, 1])), saturation(F(2), F(0)))
    with pytest.raises(InputError, match="straight line"):
        PiecewiseLoop.of(companion(block), Graph.through([], F(1), F(1)))
    with pytest.raises(InputError, match="A \\(n, n\\)"):
        realisation(([[1, 2]], [1], [1]))
