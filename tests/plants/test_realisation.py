"""Matrices that a block was given by stay with it: for python-control, for simulations, for initial states."""

import math
from fractions import Fraction

import control
import numpy as np
import pytest
from scipy import signal

from lure import LinearBlock, Loop, RationalPlant, Saturation, Tanh, as_plant
from lure.analysis.counterexamples.confirming import tried
from lure.errors import InputError
from lure.files import parse_system
from lure.plants.realisation import Names, Realisation, companion
from lure.plants.state_space import StateSpace

A, B, C, D = [[-1.0, 3.0], [0.0, -2.0]], [[1.0], [2.0]], [[1.0, 1.0]], [[0.0]]
NAMED = control.ss(A, B, C, D, states=["slow", "fast"], inputs=["force"], outputs=["tip"], name="arm")
TOML = "[plant]\nA=[[-1,3],[0,-2]]\nB=[1,2]\nC=[1,1]\nD=0\n"
FORMS = {
    "control": NAMED,
    "scipy": signal.StateSpace(A, B, C, D),
    "tuple": (A, B, C, D),
    "texts": ([["-1", "3"], ["0", "-2"]], ["1", "2"], ["1", "1"]),
    "linear block": LinearBlock(np.array(A), np.array([1.0, 2.0]), np.zeros(2), np.array([1.0, 1.0])),
    "file": parse_system(TOML, name="arm", source="a file").block,
}


@pytest.mark.parametrize("form", FORMS)
def test_every_form_of_matrices_keeps_them(form):
    block = as_plant(FORMS[form])
    assert block == RationalPlant([3, 10], [1, 3, 2])  # C (sI - A)^-1 B = (s + 8)/((s+1)(s+2)) + 2/(s+2)
    system = block.to_control()
    assert isinstance(system, control.StateSpace)
    for kept, given in zip((system.A, system.B, system.C, system.D), (A, B, C, D), strict=True):
        np.testing.assert_array_equal(kept, given)


@pytest.mark.parametrize("form", FORMS)
def test_an_initial_state_is_that_of_the_plant_given(form):
    loop = Loop(FORMS[form], Saturation()).to_control()
    start = control.input_output_response(loop, [0, 1e-6], [0, 0], X0=[1, 2]).outputs[0]
    assert start == 3  # C x0; in the companion form it is 16


def test_names_stay_with_block_and_loop():
    block = as_plant(NAMED)
    assert block.matrices.names == Names(("slow", "fast"), "force", "tip", "arm")
    system = block.to_control()
    assert (system.state_labels, system.input_labels, system.output_labels) == (["slow", "fast"], ["force"], ["tip"])
    assert Loop(NAMED, Tanh()).to_control().state_labels == ["slow", "fast"]
    large = control.ss(-np.eye(61), np.ones((61, 1)), np.ones((1, 61)), 0, states=[f"q{i}" for i in range(61)])
    assert as_plant(large).to_control().state_labels[60] == "q60"


@pytest.mark.parametrize(
    "source",
    [
        control.tf([1], [1, 0.5], True),
        control.ss([[-0.5]], [[1]], [[1]], 0, True),
        signal.StateSpace([[-0.5]], [[1]], [[1]], [[0]], dt=True),
        signal.TransferFunction([1], [1, 0.5], dt=True),
        signal.ZerosPolesGain([], [-0.5], 1, dt=True),
        control.ss(-0.5 * np.eye(61), np.ones((61, 1)), np.ones((1, 61)), 0, True),
        "1/(z+0.5)",
    ],
)
def test_a_period_that_is_not_stated_stays_so(source):
    block = as_plant(source)
    assert block.dt == 1
    assert block.to_control().dt is True
    assert Loop(block, Saturation()).to_control().dt is True
    assert as_plant(control.tf([1], [1, 0.5], 0.25)).to_control().dt == 0.25


def coupled_oscillators(number):
    """A chain of masses, springs 1 and dampers 0.01, walls at both ends."""
    stiffness = 2 * np.eye(number) - np.eye(number, k=1) - np.eye(number, k=-1)
    rows = np.block([[np.zeros((number, number)), np.eye(number)], [-stiffness, -0.01 * stiffness]])
    push = np.eye(2 * number)[number][:, None]
    return control.ss(rows, push, push.T @ np.eye(2 * number), 0)


# exp(A h) with h = 1e-4: |pole| = exp(-0.005 lambda h), lambda >= 1 the least eigenvalue of the stiffness of two masses
def test_a_finely_sampled_plant_stays_stable():
    for number, least in ((2, 1.0), (4, 2 - 2 * math.cos(math.pi / 5))):
        plant = control.c2d(coupled_oscillators(number), 1e-4)
        block = as_plant(plant)
        radius = float(np.abs(np.linalg.eigvals(block.realisation.doubles()[0])).max())
        assert radius == pytest.approx(math.exp(-0.005 * least * 1e-4), abs=1e-12)
        np.testing.assert_array_equal(block.to_control().A, plant.A)
        rounded = np.array(companion(block).doubles()[0])  # what was simulated before
        assert np.abs(np.linalg.eigvals(rounded)).max() > 1.00001


def test_the_loop_of_a_finely_sampled_plant_is_the_loop_of_its_matrices():
    plant, steps = control.c2d(coupled_oscillators(4), 1e-4), 2000
    loop = Loop(plant, Saturation()).to_control()
    x, start = np.linspace(0.1, 0.8, 8), np.linspace(0.1, 0.8, 8)
    seen = control.input_output_response(loop, np.arange(steps) * 1e-4, np.zeros(steps), X0=start).outputs
    for value in seen:
        sigma = float((plant.C @ x)[0])
        assert value == pytest.approx(sigma, abs=1e-12)
        x = plant.A @ x - plant.B[:, 0] * np.clip(sigma, -1, 1)
    assert np.abs(seen).max() < 1


def test_coefficients_have_the_companion_form():
    block = RationalPlant([1, 3], [1, 3, 2])
    assert block.matrices is None
    assert block.realisation == Realisation(
        ((Fraction(0), Fraction(1)), (Fraction(-2), Fraction(-3))),
        (Fraction(0), Fraction(1)),
        (Fraction(3), Fraction(1)),
        Fraction(0),
    )
    with pytest.raises(InputError, match="have 2 states and the denominator has degree 1"):
        RationalPlant([1], [1, 1], matrices=block.realisation)


def test_exact_entries_stay_exact():
    third = as_plant(([["-1/3"]], ["2/7"], [1], "1/10"))
    assert third.realisation.A[0][0] == Fraction(-1, 3)
    assert third.to_dict()["matrices"]["D"] == "1/10"
    assert "matrices" not in RationalPlant([1], [1, 1]).to_dict()


@pytest.mark.parametrize(
    ("source", "gain"),
    [(control.ss([], [], [], 0), 0), (control.ss([], [], [], 2), 2), (([], [], [], 0), 0), (control.tf([3], [1]), 3)],
)
def test_a_static_gain_is_a_block(source, gain):
    block = as_plant(source)
    assert (block.order, block.feedthrough) == (0, gain)


@pytest.mark.parametrize(
    "system",
    [
        control.nlsys(
            lambda t, x, u, p: -(x**3) + u, lambda t, x, u, p: x, inputs=1, outputs=1, states=1, name="cubic"
        ),
        control.nlsys(lambda t, x, u, p: -x, name="cubic"),
    ],
)
def test_a_nonlinear_plant_is_to_be_linearised(system):
    with pytest.raises(InputError, match=r"cubic is a nonlinear system of python-control; .*control\.linearize\("):
        as_plant(system)


def test_no_state_and_no_feedthrough_is_no_system():
    with pytest.raises(InputError, match="the system is empty"):
        as_plant(([], [], []))
    assert StateSpace([[-1]], [1], [1]).to_control().dt == 0


@pytest.mark.slow
def test_a_proof_about_a_finely_sampled_plant_is_not_contradicted_by_its_simulation():
    plant = control.c2d(coupled_oscillators(2), 1e-4)  # its companion form in doubles grows within seconds
    assert tried(as_plant(plant), Saturation(), conclusion="0 attracts").contradiction is None
