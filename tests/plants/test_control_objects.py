"""python-control in and out: blocks, loop shifts, closed loops that simulate, and what is refused."""

import re
from fractions import Fraction

import control
import numpy as np
import pytest

from lure import (
    DeadZone,
    DelayPlant,
    ExpressionNonlinearity,
    FrequencyData,
    Loop,
    NonlinearityClass,
    RationalPlant,
    Saturation,
    Sector,
    StateSpace,
    Tanh,
    as_plant,
)
from lure.analysis import Verdict, certify, max_sector
from lure.analysis.describing import describing_hint
from lure.analysis.questions.problem import problem_of
from lure.analysis.rod.simulation import simulate
from lure.analysis.theorems.passivity import passivity_indices
from lure.errors import InputError
from lure.files.builtin import builtin_loop
from lure.loop import pole_shift, sector_shift
from lure.nonlinearities.reading import as_nonlinearity
from lure.rod import NormalCompliance, RodPlant, upwind
from lure.rod.scenario import Scenario, initial_state
from lure.rod.systems import paper_rod, rod_from_exact

POINTS = 1j * np.geomspace(0.01, 100, 40)


@pytest.mark.parametrize(
    "block",
    [
        RationalPlant([1, 2], [1, 3, 2, 0]),
        RationalPlant([2, 1], [1, 2], dt=0.5),
        StateSpace([[0, 1], [-2, -3]], [0, 1], [1, 0], 0.25),
        StateSpace([[0.5]], [1], [1], dt=2),
        upwind(paper_rod(), 3).block,
    ],
    ids=["rational", "discrete", "state space", "discrete state space", "linear"],
)
def test_a_block_comes_back_from_python_control_as_the_same_function(block):
    theirs = block.to_control()
    again = as_plant(theirs)
    assert again.transfer(POINTS) == pytest.approx(block.transfer(POINTS), rel=1e-9)
    assert theirs(POINTS) == pytest.approx(block.transfer(POINTS), rel=1e-9)
    own = getattr(block, "dt", None)
    assert theirs.dt == (0 if own is None else float(own))
    assert getattr(again, "dt", None) == own


def test_measured_data_come_back_as_they_were():
    data = FrequencyData([1, 2, 4], [1, 1j, -0.5])
    again = as_plant(data.to_control())
    assert (again.omega == data.omega).all()
    assert (again.response == data.response).all()


def test_a_dead_time_is_not_approximated_unasked():
    with pytest.raises(InputError, match=r"python-control has no dead time.*to_control\(pade=4\).*no answer of lure"):
        DelayPlant.parse("exp(-s)/(s+1)").to_control()
    for order in (0, 21, 2.0, True):
        with pytest.raises(InputError, match="a whole number from 1 to 20"):
            DelayPlant.parse("exp(-s)/(s+1)").to_control(pade=order)


# the Pade approximation of order 4 of exp(-T s) is exact up to the ninth power of T s: at |T s| <= 1/2 to about 1e-12
def test_the_approximation_of_a_dead_time_is_that_of_pade():
    block = DelayPlant.parse("(exp(-s/2) + 2*s + 3)/(s^2 + s + 1)".replace("^", "**"))
    near = 1j * np.linspace(0.01, 1, 20)
    assert block.to_control(pade=4)(near) == pytest.approx(block.transfer(near), rel=1e-10)
    far = block.to_control(pade=1)(10j) - block.transfer(10j)
    assert abs(far) > 1e-3  # and is not the dead time elsewhere


# H/(1 + 2H) for H = 1/(s^2 + s - 1) is 1/(s^2 + s + 1), which is control's own feedback
@pytest.mark.parametrize("kind", ["tf", "ss", "text"])
def test_loop_shifts_take_and_give_systems_of_python_control(kind):
    theirs = control.tf([1], [1, 1, -1])
    source = {"tf": theirs, "ss": control.ss([[-1, 1], [1, 0]], [[1], [0]], [[0, 1]], 0), "text": "1/(s^2+s-1)"}[kind]
    shifted = sector_shift(source, NonlinearityClass(sector=Sector(2, 5)))
    assert shifted.to_control()(POINTS) == pytest.approx(control.feedback(theirs, 2)(POINTS), rel=1e-12)
    assert (
        shifted.block == pole_shift(source, NonlinearityClass(sector=Sector(2, 5)), 2).block == as_plant("1/(s^2+s+1)")
    )


def test_what_is_not_rational_is_not_shifted():
    with pytest.raises(InputError, match="a loop shift needs exact coefficients, and a DelayPlant has none"):
        pole_shift("exp(-s)/(s+1)", NonlinearityClass(sector=Sector(0, 1)), 1)


# x' = -sat(x), x(0) = 3: x = 3 - t as long as x >= 1, that is up to t = 2, then exp(2 - t)
def test_a_saturated_integrator_moves_as_by_hand():
    closed = Loop(control.tf([1], [1, 0]), control.saturation_nonlinearity(1)).to_control()
    times = np.linspace(0, 5, 51)
    found = control.input_output_response(closed, times, 0, [3.0], solve_ivp_kwargs={"rtol": 1e-9, "atol": 1e-12})
    exact = np.where(times < 2, 3 - times, np.exp(2 - times))
    assert found.outputs == pytest.approx(exact, abs=1e-6)


# x[k+1] = x/2 - sat(x): 4, 2 - 1 = 1, 1/2 - 1 = -1/2, -1/4 + 1/2 = 1/4, 1/8 - 1/4 = -1/8
def test_a_sampled_loop_moves_as_by_hand():
    closed = Loop(RationalPlant([1], [1, -0.5], dt=1), Saturation()).to_control()
    found = control.input_output_response(closed, np.arange(5), 0, [4.0])
    assert found.outputs == pytest.approx([4, 1, -0.5, 0.25, -0.125], abs=1e-15)
    assert closed.dt == 1


# mu = r - phi(sigma): with the gain 3 around 1/(s+1) and r = 1, sigma tends to 1/4, and not to -1/2
def test_the_sign_is_that_of_negative_feedback_and_the_load_adds():
    closed = Loop("1/(s+1)", DeadZone(width=0.01, gain=3)).to_control()
    assert (closed.ninputs, closed.noutputs, closed.nstates) == (1, 1, 1)
    times = np.linspace(0, 10, 101)
    last = control.input_output_response(closed, times, 1.0, [0.0]).outputs[-1]
    # sigma = 1 - 3 (sigma - 0.01)
    assert last == pytest.approx(1.03 / 4, abs=1e-3)


# states of the controllable form: a step of 1/(s^2 + 3 s + 2) in a loop that a dead zone leaves open
def test_an_open_loop_answers_a_load_as_python_control_says():
    plant = control.tf([1, 4], [1, 3, 2])
    times = np.linspace(0, 4, 41)
    theirs = control.step_response(plant, times).outputs
    closed = Loop(plant, DeadZone(width=100, gain=1)).to_control()
    assert control.input_output_response(closed, times, 1.0, 0).outputs == pytest.approx(theirs, abs=2e-3)


def test_matrices_keep_their_own_states():
    scheme = upwind(paper_rod(), 2)
    closed = Loop(scheme, NormalCompliance(1.0, 1.0)).to_control()
    assert closed.nstates == scheme.block.order
    state = np.zeros(closed.nstates)
    state[0] = 1.0
    assert closed.dynamics(0, state, [0.0]) == pytest.approx(
        scheme.block.dense() @ state - scheme.block.b1 * max(float(scheme.block.c @ state), 0.0)
    )


# H = 1 + 1/(s+1), D = 1, phi = min(max(sigma, -1), 1).  For sigma >= 1: sigma = x - 1, x' = -x - 1 from x = 3, so that
# sigma = 1 is reached at x = 2, t = ln(4/3); then sigma = x/2, x' = -3x/2
def test_a_direct_term_is_solved_for_at_every_instant():
    closed = Loop("(s+2)/(s+1)", Saturation()).to_control()
    times = np.linspace(0, 2, 41)
    found = control.input_output_response(closed, times, 0, [3.0], solve_ivp_kwargs={"rtol": 1e-10, "atol": 1e-12})
    turn = np.log(4 / 3)
    exact = np.where(times < turn, 4 * np.exp(-times) - 2, np.exp(-1.5 * (times - turn)))
    assert found.outputs == pytest.approx(exact, abs=1e-7)
    # and in discrete time, with a load: x = 0, sigma + phi(sigma) = r = 1 gives sigma = 1/2
    sampled = Loop(RationalPlant([1, 1], [1, 0], dt=1), Saturation()).to_control()
    assert sampled.output(0, [0.0], [1.0]) == pytest.approx([0.5], rel=1e-12)


# two engines that share no line: ours is exact between contact and release, theirs integrates
def test_the_closed_scheme_moves_in_python_control_as_in_our_own_simulation():
    exact = {**paper_rod().exact, "gap": Fraction(0), "compliance": Fraction(1, 10**9)}
    scheme = upwind(rod_from_exact(exact), 4)
    start = Scenario.parse(force="0", displacement="0.0001*cos(3*x)")
    ours = simulate(scheme, start, until=1e-3, samples=101)
    assert ours.contact
    closed = Loop(scheme, NormalCompliance(Fraction(10**9), 1)).to_control()
    options = {"rtol": 1e-9, "atol": 1e-13}
    state = initial_state(scheme, start)
    theirs = control.input_output_response(closed, ours.t, 0, state, solve_ivp_kwargs=options)
    assert theirs.outputs == pytest.approx(ours.z, abs=1e-6 * np.abs(ours.z).max())


def test_a_loop_with_a_dead_time_closes_on_its_approximation_if_asked():
    loop = Loop("exp(-s/2)/(s+1)", Tanh())
    with pytest.raises(InputError, match="python-control has no dead time"):
        loop.to_control()
    assert loop.to_control(pade=3).nstates == 4


@pytest.mark.parametrize(
    ("loop", "message"),
    [
        (Loop("-(s+2)/(s+1)", Tanh()), r"has the direct term D = -1: .* these are \[0, 1\]"),
        (
            Loop("(s+2)/(s+1)", ExpressionNonlinearity("sigma**3/(1+sigma**2)", sector=Sector(0, 1))),
            "these are unknown",
        ),
        (Loop("3", Tanh()), "a RationalPlant without states cannot be simulated"),
        (Loop(control.frd([1, 0.5], [1, 2]), Tanh()), "a FrequencyData without states cannot be simulated"),
        (Loop(RodPlant(paper_rod()), Tanh()), "a RodPlant without states cannot be simulated"),
        (builtin_loop("third-order"), "has no nonlinearity to close the loop with"),
    ],
)
def test_loops_that_cannot_be_simulated_there_are_refused_in_one_sentence(loop, message):
    with pytest.raises(InputError, match=message):
        loop.to_control()


def test_a_named_loop_closes_too():
    closed = builtin_loop("leonov-bragin-kuznetsov").to_control()
    assert closed.nstates == 4
    assert builtin_loop("contact").to_control().dynamics(0, [1.02], [0.0]) == pytest.approx([-1.0])


def test_a_law_of_python_control_is_the_law_it_is():
    assert as_nonlinearity(control.saturation_nonlinearity(2)) == Saturation(limit=2)
    with pytest.warns(UserWarning, match="asymmetric"):  # of its own describing function, not of the nonlinearity
        uneven = control.saturation_nonlinearity(2, -1)
    assert as_nonlinearity(uneven) == Saturation(limit=2, lower_limit=-1)
    assert not as_nonlinearity(uneven).odd
    nonlinearity = Tanh()
    assert as_nonlinearity(nonlinearity) is nonlinearity


@pytest.mark.parametrize(
    ("source", "message"),
    [
        (control.relay_hysteresis_nonlinearity(1, 0.5), "relay_hysteresis_nonlinearity has a memory"),
        (control.friction_backlash_nonlinearity(0.5), "friction_backlash_nonlinearity has a memory"),
        (
            np.tanh,
            r"has no sector; a nonlinearity says in which sector it lies: give one of lure.nonlinearities, or "
            r"ExpressionNonlinearity\(",
        ),
        (None, "None has no sector"),
        (3, r"3 is a number and no nonlinearity; give the class asked about as Sector\(0, 1\)"),
    ],
)
def test_a_law_with_a_memory_or_without_a_sector_is_refused(source, message):
    with pytest.raises(InputError, match=message):
        Loop("1/(s+1)", source)


# N(A) = 2/pi (asin(1/A) + sqrt(1 - 1/A^2)/A) for the saturation at 1
def test_python_control_takes_our_laws_for_its_describing_function():
    theirs = control.describing_function(Saturation(), [2.0], num_points=2000)
    assert theirs.real == pytest.approx(2 / np.pi * (np.arcsin(0.5) + np.sqrt(0.75) / 2), rel=1e-5)


def test_questions_take_a_loop_made_of_objects_of_python_control():
    loop = Loop(control.tf([1], [1, 3, 2, 0]), control.saturation_nonlinearity(1))
    assert loop.block == as_plant("1/(s*(s+1)*(s+2))")
    assert str(problem_of(loop).nonlinearity_class) == "odd phi with slope in [0, 1]"
    assert certify(loop).verdict is Verdict.PROVED
    assert max_sector(control.tf([1], [1, 3, 2, 0])).largest.low == pytest.approx(6)


# H = 1/(s+1): Re H > 0 with infimum 0, Re 1/H = 1; 12/(s(s+1)(s+2)) with a gain of 6 is at its Hurwitz limit
def test_indices_and_hints_take_objects_of_python_control():
    found = passivity_indices(control.tf([1], [1, 1]))
    assert (found.input_feedforward.low, found.output_feedback.low) == (0, 1)
    hint = describing_hint(control.tf([12], [1, 3, 2, 0]), control.saturation_nonlinearity(1))
    assert [balance.frequency for balance in hint.balances] == [pytest.approx(np.sqrt(2))]
    assert hint.balances[0].gain == pytest.approx(0.5)
    with pytest.raises(InputError, match="passivity_indices needs exact coefficients, and a FrequencyData has none"):
        passivity_indices(control.frd([1, 1], [1, 2]))


@pytest.mark.parametrize("system", [control.tf([[[1], [1]]], [[[1, 1], [1, 2]]]), control.ss([], [], [], [[1, 2]])])
def test_several_inputs_are_refused_by_name(system):
    with pytest.raises(InputError, match=re.escape("choose a pair, e.g. sys[0, 0]")):
        Loop(system, Tanh())


def test_a_saturation_redefined_is_not_taken_for_the_saturation():
    class Tenfold(control.saturation_nonlinearity):
        def __call__(self, x):
            return 10 * super().__call__(x)

    with pytest.raises(InputError, match=r"has no sector|has a memory"):
        as_nonlinearity(Tenfold(1))
