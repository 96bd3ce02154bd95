"""Simulation held against proofs: no true proof is accused, no false one passes."""

import importlib.util
from dataclasses import replace
from fractions import Fraction as F
from pathlib import Path

import numpy as np
import pytest
from depth import rarely, sampled

from lure import (
    Cubic,
    DeadZone,
    Diagonal,
    ExpressionNonlinearity,
    LeakyReLU,
    NonlinearityClass,
    PiecewiseLinear,
    Quantiser,
    RationalPlant,
    Saturation,
    Sector,
    Tanh,
    as_plant,
)
from lure.analysis import analyse, max_sector
from lure.analysis.counterexamples.confirming import balanced_starts, scales, tried
from lure.analysis.counterexamples.simulated import bracketed_root, simulate_loop
from lure.analysis.counterexamples.trajectories import BatchLoop, Finding
from lure.analysis.inequality.gains import gain_intervals
from lure.analysis.report.loop.observed import observed
from lure.analysis.report.parts import ContradictionError
from lure.analysis.verdict import Verdict
from lure.errors import InputError
from lure.files import parse_system
from lure.files.builtin import builtin_loop

ATTRACTS = "0 attracts"
LAG3 = [1, 3, 3, 1]
TRUE = {
    "noise of the integrator": ([10], [1, 10], None, Tanh()),
    "feedthrough": ([1, 2], [1, 1], None, Tanh()),
    "integrator": ([1], [1, 0], None, Tanh()),
    "integrator and lag": ([1], [1, 1, 0], None, Tanh()),
    "subnormal cycle": ([1], [1, -1], 1, Saturation(gain=F(3, 2))),
    "short of the limit 8": ([1], LAG3, None, Saturation(gain=F("7.99"))),
    "hardly damped": ([1], [1, F(1, 10**6), 1], None, Saturation(gain=1)),
    "fast": ([10**6], [1, 10**6], None, Tanh(gain=5)),
    "fast and slow": ([1], [1, 10**6, 1], None, Tanh(gain=5)),
}
FALSE = {
    "limit cycle": ([1], LAG3, None, Saturation(gain=20), Finding.OSCILLATES),
    "barely above the limit 8": ([1], LAG3, None, Saturation(gain=F("8.1")), Finding.OSCILLATES),
    "smooth limit cycle": ([1], LAG3, None, Tanh(gain=20), Finding.OSCILLATES),
    "escape from an unstable plant": ([1], [1, -1], None, Saturation(gain=2), Finding.GROWS),
    "rest elsewhere": ([-1], [1, 1], None, Tanh(gain=2), Finding.RESTS),
    "no solution": ([1, 1], [1, F(-1, 2)], 1, Quantiser(step=1), Finding.UNSOLVABLE),
    "sampled cycle": ([1], [1, -1], 1, Saturation(gain=F(5, 2)), Finding.OSCILLATES),
    "overflow": ([1], [1, F(-1, 2)], 1, DeadZone(width=1, gain=3), Finding.GROWS),
}


@pytest.mark.slow_for("hardly damped", "short of the limit 8")
@pytest.mark.parametrize("name", TRUE)
def test_a_true_proof_is_not_accused(name):
    num, den, dt, nonlinearity = TRUE[name]
    assert tried(RationalPlant(num, den, dt=dt), nonlinearity, conclusion=ATTRACTS, budget=10_000).contradiction is None


@pytest.mark.slow_for("limit cycle")
@pytest.mark.parametrize("name", rarely(FALSE, "smooth limit cycle", "barely above the limit 8", "sampled cycle"))
def test_a_false_proof_is_contradicted_by_a_solution(name):
    num, den, dt, nonlinearity, finding = FALSE[name]
    block = RationalPlant(num, den, dt=dt)
    assert tried(block, nonlinearity, conclusion=ATTRACTS).contradiction.finding is finding
    assert tried(block, nonlinearity).contradiction is None


def test_rest_at_an_equilibrium_contradicts_only_that_0_attracts():
    # phi = 0 for |sigma| <= 1: x' = -phi(x) rests wherever |x| <= 1
    block, nonlinearity = RationalPlant([1], [1, 0]), DeadZone(width=1, gain=1)
    assert tried(block, nonlinearity, conclusion="converges to equilibria").contradiction is None
    assert tried(block, nonlinearity, conclusion=ATTRACTS).contradiction.finding is Finding.RESTS


def found(text, name="loop"):
    return analyse(parse_system(text, name=name, source="a file"))


def proved_of(analysis, proof, nonlinearity_class=None):
    """An analysis that says of this loop what a proof says of another."""
    about = analysis.problem
    if nonlinearity_class is not None:
        about = replace(about, classes=Diagonal((nonlinearity_class,)), kind="class")
    return replace(analysis, problem=about, conclusion=proof.conclusion)


@pytest.fixture(scope="module")
def proof():
    return found("[plant]\nnum=[1]\nden=[1,2,1]\n[class]\nsector=[0,1]\n")


@pytest.mark.slow
def test_an_unstable_gain_of_the_class_contradicts_the_proof(proof):
    # 1/(s+1)^3 is stable for gains below 8 only
    loop = found('[plant]\nnum=[1]\nden=[1,3,3,1]\n[nonlinearity]\nkind="saturation"\ngain=20\nlimit=1\n')
    assert "went on oscillating without decay" in observed(loop).sentences[0]
    with pytest.raises(ContradictionError, match="phi = 20 sigma, for which the loop is not stable"):
        observed(proved_of(loop, proof))
    assert "phi = 20 sigma" not in str(observed(proof).sentences)


def test_what_is_said_of_the_law_alone_is_held_against_its_solutions():
    # 1/s with a dead zone rests wherever |sigma| <= 1: that 0 attracts is said of nonlinearities that vanish at 0 only
    loop = found('[plant]\nnum=[1]\nden=[1,0]\n[nonlinearity]\nkind="dead zone"\ngain=1\nwidth=1\n')
    assert loop.verdict is Verdict.PROVED
    assert "came to rest at equilibria other than 0" in observed(loop).sentences[0]
    with pytest.raises(ContradictionError, match="comes to rest at an equilibrium other than 0"):
        observed(replace(loop, conclusion=replace(loop.conclusion, attracts=True)))


@pytest.mark.slow
def test_a_certified_counterexample_of_the_class_contradicts_the_proof(proof):
    # odd nonlinearities with slope up to 1.08 are proved, merely monotone ones refuted from 1.03 on
    loop = analyse(builtin_loop("dt-6"))
    (row,) = [row for row in loop.rows if row.question == "slope" and not row.odd]
    k = F(row.witness.k) + F(1, 1000)
    assert observed(proved_of(loop, proof, NonlinearityClass.slope_restricted(0, k, odd=True))).trajectories
    with pytest.raises(ContradictionError, match="a member of the class phi with slope"):
        observed(proved_of(loop, proof, NonlinearityClass.slope_restricted(0, k)))


def test_a_root_with_a_residual_is_no_root():
    # sigma + phi(sigma) = y with a quantiser jumps over y in [0.5, 1.5)
    nonlinearity = Quantiser(step=1)
    assert bracketed_root(nonlinearity, 1.0, 0.4) == pytest.approx(0.4)
    assert bracketed_root(nonlinearity, 1.0, 1.6) == pytest.approx(0.6)
    assert np.isnan(bracketed_root(nonlinearity, 1.0, 1.0))
    with pytest.raises(InputError, match="has no solution"):
        simulate_loop(RationalPlant([1, 1], [1, F(-1, 2)], dt=1), nonlinearity, [1.0], 3.0)


# sigma + phi(sigma) = 2.5 sigma + sigma^3 has exactly one root for every y, here near y^(1/3), far below y.
@pytest.mark.parametrize("y", [1e-9, 0.3, 9.277e11, -4.1e30])
def test_the_root_of_a_steep_law_is_found_however_large_the_state(y):
    root = bracketed_root(Cubic(linear=1.5, cubic=1), 1.0, y)
    assert 2.5 * root + root**3 == pytest.approx(y, rel=1e-9)


@pytest.mark.slow
def test_a_solution_that_leaves_the_range_of_doubles_gives_no_warning():
    # 1/(s+1)^4 is unstable with every gain above 4, and the gain of the cubic grows with sigma
    found = tried(RationalPlant([1], [1, 4, 6, 4, 1]), Cubic(linear=3, cubic=1))
    assert any(run.finding is Finding.GROWS for run in found.trajectories)


@pytest.mark.slow
def test_the_class_of_no_law_is_tried_with_its_members(proof):
    assert Sector(0, 1) == proof.problem.nonlinearity_class.sector
    runs = observed(proof).trajectories
    assert {run.finding for run in runs} == {Finding.CONVERGES}
    assert all(run.t[0] == 0 and len(run.t) < 1000 for run in runs)


# many loops -----------------------------------------------------------------------------------------------------------


def plants():
    """The textbook plants of the campaign over everyday loops, those with dead time left out."""
    script = Path(__file__).parents[2] / "benchmarks" / "everyday_loops.py"
    spec = importlib.util.spec_from_file_location("everyday_plants", script)
    campaign = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(campaign)
    for name, (formula, _) in campaign.CONTINUOUS.items():
        if "exp(" not in formula:
            yield name, as_plant(formula)
    for name, (formula, _, dt) in campaign.DISCRETE.items():
        yield name, as_plant(formula, dt=float(dt))


def nonlinearities(gain, scale, *, least=0.1):
    """Nonlinearities whose largest slope is a gain; the smallest of the one that is not odd is a share of it."""
    k, s = F(gain).limit_denominator(10**6), F(scale)
    yield Saturation(gain=k, limit=k * s)
    yield Tanh(gain=k * s, scale=s)
    yield DeadZone(width=s, gain=k)
    yield LeakyReLU(negative_slope=k * F(least), positive_slope=k)
    yield PiecewiseLinear([(-2 * s, -k * s), (0, 0), (s, k * s)], left_slope=k / 20, right_slope=k / 3)


def true_loops():
    """Loops that a criterion of ours proves: gains of 95 and 40 per cent of the largest sector proved."""
    for name, block in plants():
        found = max_sector(block, search="linear")
        if found.verdict is Verdict.PROVED:
            k = min(found.largest.low, 100.0)
            conclusion = "converges to equilibria" if found.critical else ATTRACTS
            for gain, scale in ((0.95 * k, 1), (0.4 * k, F(1, 1000))):
                for nonlinearity in nonlinearities(gain, scale):
                    yield name, block, nonlinearity, conclusion


def false_loops():
    """Loops that are unstable at 0, or far from it: with 1.3 and 2.5 times the largest stable gain."""
    for name, block in plants():
        ends = [one.upper.value.middle for one in gain_intervals(block)][-1:]
        for end in (end for end in ends if 0 < end < 1e9):
            for gain, scale in ((1.3 * end, 1), (2.5 * end, F(1, 1000))):
                for nonlinearity in list(nonlinearities(gain, scale, least=0.9))[:4]:
                    yield name, block, nonlinearity


# Poles over three decades, or a root to be found at every step: some runs of these end before they have decided.
SLOW_ONES = {"spread-lags", "pi-servo", "oscillator-biproper"}


def judged_false(loops, proof):
    """Names of the loops with no solution found that contradicts; each class is contradicted by a gain."""
    missed = set()
    for name, block, nonlinearity in loops:
        classes = Diagonal((NonlinearityClass(sector=nonlinearity.sector),))
        about = replace(proof.problem, plant=block, nonlinearity=nonlinearity, classes=classes)
        with pytest.raises(ContradictionError, match="for which the loop is not stable"):
            observed(replace(proof, problem=about, gains=gain_intervals(block), rows=()))
        if tried(block, nonlinearity, conclusion=ATTRACTS).contradiction is None:
            missed.add(name)
    return missed


def accused(loops):
    return [
        f"{name}, {nonlinearity}" for name, block, nonlinearity, said in loops if contradicts(block, nonlinearity, said)
    ]


def contradicts(block, nonlinearity, said):
    return tried(block, nonlinearity, conclusion=said, budget=6_000).contradiction is not None


@pytest.mark.slow
def test_a_sample_of_false_loops_is_found(proof):
    assert judged_false(list(false_loops())[5 :: sampled(72, of=24)], proof) <= SLOW_ONES


@pytest.mark.slow
def test_a_sample_of_true_loops_is_not_accused():
    assert accused(list(true_loops())[7 :: sampled(90, of=30)]) == []


@pytest.mark.thorough
def test_a_hundred_false_loops_are_found(proof):
    loops = [loop for i, loop in enumerate(false_loops()) if i % 24 != 5][::2]
    assert len(loops) >= 100
    assert judged_false(loops, proof) <= SLOW_ONES


@pytest.mark.thorough
def test_three_hundred_true_loops_are_not_accused():
    loops = [loop for i, loop in enumerate(true_loops()) if i % 30 != 7][:320]
    assert len(loops) >= 300
    assert accused(loops) == []


def test_a_gain_that_swings_for_ever_is_started_near_its_first_bends():
    # phi(sigma)/sigma = 1 + sin(sigma)/2 changes in every decade beyond 1: the last bend says nothing of the
    # nonlinearity
    assert max(scales(ExpressionNonlinearity("sigma*(1+0.5*sin(sigma))"))) <= 100


def test_rounding_at_the_bend_where_solutions_come_to_rest_is_no_oscillation():
    # sigma' = -phi(sigma) with a contact at 1/50: a scalar equation has no oscillation, and sigma falls to 1/50
    found = observed(analyse(builtin_loop("contact")))
    assert found.trajectories
    assert all(run.finding is not Finding.OSCILLATES for run in found.trajectories)


@pytest.mark.slow
def test_a_slope_just_below_that_of_a_counterexample_is_not_accused_by_its_orbit():
    # dt-2: proved up to 1.105648654, refuted from 1.105648656: begun on the orbit of the counterexample, a solution
    # with the proved slope misses itself by 1e-9 after a period, and converges
    assert observed(analyse(builtin_loop("dt-2"))).trajectories


# 1/(s^2 + s + 1) with tanh has no balance, as no gain between 0 and 1 leaves a mode undamped; 1/(s(s + 1)(s + 2)) with
# the gain 9 of a saturation has one, where N(A) = 6
@pytest.mark.parametrize(
    ("plant", "phi", "balances"),
    [(RationalPlant([1], [1, 1, 1]), Tanh(), 0), (RationalPlant([1], [1, 3, 2, 0]), Saturation(gain=9), 1)],
)
def test_a_start_is_said_to_be_near_a_balance_only_where_there_is_one(plant, phi, balances):
    loop = BatchLoop(plant, phi, gain=F(1), budget=10**6)
    said = balanced_starts(loop, 0.1, 10).texts
    assert said.count("near an oscillation that harmonic balance suggests") == balances
    assert said[-1] == "near the least damped oscillation of one harmonic"


@pytest.mark.parametrize("den", [[1, 1, 1], [1, 3, 3, 1]])
def test_solutions_that_escape_in_finite_time_do_not_end_the_others(den):
    # With phi = sigma - sigma^3 a large sigma grows as 1/(T - t) does; a small one decays, as phi is near sigma there.
    found = tried(RationalPlant([1], den), lambda s: s - s**3)
    assert found.count(Finding.OPEN) == 0
    assert found.count(Finding.GROWS) >= 8
    assert found.count(Finding.CONVERGES) >= 3
    assert max(float(np.abs(run.sigma).max()) for run in found.trajectories) < 1e7  # drawn up to the escape
