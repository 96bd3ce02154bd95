"""Objects of python-control and scipy, and sampling times, become a block exactly or are refused in one sentence."""

import io
import math
from fractions import Fraction as F

import control
import numpy as np
import pytest
import scipy.io
import scipy.signal
from hypothesis import given
from hypothesis import strategies as st
from refusals import refusal

from lure import LinearBlock, builtin_loop
from lure.errors import InputError
from lure.plants import as_plant, sampling_time
from lure.plants.delay import DelayPlant
from lure.plants.frequency_data import FrequencyData
from lure.plants.rational import RationalPlant
from lure.plants.text import polynomial_of_roots
from lure.rod import builtin_system, upwind


# python-control and scipy.signal
def test_objects_of_python_control_are_taken_exactly():
    tenth = F(0.1)
    assert as_plant(control.tf([0.1], [1, 3, 2])) == RationalPlant([tenth], [1, 3, 2])
    assert as_plant(control.tf([1], [1, 0.5], 0.1)) == RationalPlant([1], [1, F(1, 2)], tenth)
    assert as_plant(control.tf([1], [1, 0.5], True)).dt == 1
    assert as_plant(control.ss(*map(np.array, ([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]], [[2]])))) == RationalPlant(
        [2, 6, 5], [1, 3, 2]
    )
    assert as_plant(control.ss([], [], [], [[3]])) == RationalPlant([3], [1])
    assert as_plant(control.rss(2, 2, 2)[0, 1]).order == 2


def test_measured_data_stay_data():
    data = as_plant(control.frd([1, 2, 3j], [3, 1, 2]))
    assert isinstance(data, FrequencyData)
    assert data.omega.tolist() == [1, 2, 3]
    assert data.response.tolist() == [2, 3j, 1]
    assert not hasattr(data, "transfer")
    assert data.to_control().frdata.ravel().tolist() == [2, 3j, 1]


@pytest.mark.parametrize(
    ("system", "said"),
    [
        (lambda: control.tf([1, 0, 0], [1, 1]), "improper"),
        (lambda: control.frd(np.ones((2, 2, 1)), [1]), "2 inputs"),
        (lambda: scipy.signal.ZerosPolesGain([], [-1 + 1j], 1), "without its conjugate"),
        (lambda: scipy.signal.TransferFunction([1, 2, 3], [1, 2]), "improper"),
        (lambda: lambda s: 1 / s, "nothing can be shown with it; give coefficients"),
        (lambda: 3, "3 is no linear block; give coefficients"),
        (lambda: None, "None is no linear block"),
        (lambda: "plant.toml", "'plant.toml' is the name of a file, and a text is a formula;"),
        (lambda: np.array([1, 2]), "is no linear block"),
        (lambda: ([1, 2, 3], [1, 2]), "improper"),
        (lambda: ([1], [0, 0]), "denominator is zero"),
        (lambda: ([[1], [2]], [1, 2]), "one input and one output"),
        (lambda: ([1], [1, -0.5], 0.1), r"sampling time may be meant, .*; give \(num, den\) and dt= beside it"),
        (lambda: (np.array([1.0]), np.array([2.0]), 1), "sampling time may be meant"),
        (
            lambda: {key: [[1]] for key in "ABCD"},
            r"no block; give what it holds, \(m\['A'\], m\['B'\], m\['C'\], m\['D'\]\)",
        ),
        (lambda: {"num": [1], "den": [1, 1]}, r"a dictionary m, .* \(m\['num'\], m\['den'\]\)"),
    ],
)
def test_systems_that_are_no_single_proper_block_are_refused(system, said):
    with pytest.raises(InputError, match=said):
        as_plant(system())


def test_objects_of_scipy_are_taken_exactly():
    assert as_plant(scipy.signal.lti([1], [1, 2, 3])) == RationalPlant([1], [1, 2, 3])
    assert as_plant(scipy.signal.dlti([1], [1, 0.5])) == RationalPlant([1], [1, F(1, 2)], 1)
    assert as_plant(scipy.signal.dlti([1], [1, 0.5], dt=0.25)).dt == F(1, 4)
    assert as_plant(scipy.signal.lti([], [-1, -2 + 1j, -2 - 1j], 2)) == RationalPlant([2], [1, 5, 9, 5])
    assert as_plant(scipy.signal.StateSpace(*map(np.array, ([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]], [[0]])))) == (
        RationalPlant([1], [1, 3, 2])
    )
    poles = scipy.signal.butter(5, [0.1, 0.2], "bandpass", output="zpk")
    assert as_plant(scipy.signal.ZerosPolesGain(*poles, dt=True)).order == 10


@given(st.lists(st.complex_numbers(max_magnitude=9, allow_nan=False, min_magnitude=1e-3), max_size=4))
def test_roots_multiply_out_to_a_polynomial_that_vanishes_at_them(half):
    roots = [root for one in half for root in ((one, one.conjugate()) if one.imag else (one,))]
    p = polynomial_of_roots(roots)
    assert len(p) == len(roots) + 1
    for root in roots:
        x, y = F(root.real), F(root.imag)
        real, imaginary = F(0), F(0)
        for c in p:  # Horner's rule in exact complex numbers
            real, imaginary = real * x - imaginary * y + c, real * y + imaginary * x
        assert (real, imaginary) == (0, 0)


def test_a_linear_block_goes_from_the_law_to_the_output():
    block = LinearBlock(
        np.array([[0.0, 1.0], [-2.0, -3.0]]), np.array([0.0, 1.0]), np.array([5.0, 5.0]), np.array([1.0, 0.0])
    )
    assert as_plant(block) == RationalPlant([1], [1, 3, 2])
    # dispersion adds no error here: the scheme with 10 cells has 21 states and its response is known in closed form
    scheme = upwind(builtin_system("paper-rod").rod, 10)
    exact = as_plant(scheme.block)
    assert exact.order == 21
    assert exact.transfer(50j) == pytest.approx(scheme.transfer(50j), rel=1e-9)


def test_a_block_passes_through_unchanged():
    for block in (RationalPlant([1], [1, 1]), FrequencyData([1.0], [1.0]), as_plant("exp(-s)/(s+1)")):
        assert as_plant(block) is block


@pytest.mark.parametrize(
    ("caller", "own", "agreed"),
    [
        (None, None, None),
        (None, 0, None),
        (0, None, None),
        (0, 0, None),
        (None, True, 1),
        (True, None, 1),
        (True, True, 1),
        (F(1, 2), True, F(1, 2)),
        (True, 0.5, F(1, 2)),
        (F(1, 10), 0.1, F(1, 10)),
        (2, None, 2),
        (np.float64(0.5), None, F(1, 2)),
    ],
)
def test_sampling_times_follow_python_control(caller, own, agreed):
    assert sampling_time(caller, own) == agreed


@pytest.mark.parametrize(
    ("caller", "own", "said"),
    [
        (0.2, 0.1, "dt is discrete time of period 0.2 but dt is in discrete time of period 0.1"),
        (1, 0, "dt is discrete time of period 1 but dt is in continuous time"),
        (True, 0, "but dt is in continuous time"),
        (0, True, "dt is continuous time but dt is in discrete time"),
        (0, 1, "dt is continuous time"),
        (-1, None, "dt is -1; give a positive period"),
        (False, None, "dt is False; give 0 or None"),
        (math.nan, None, "dt is nan; give a finite number"),
        (math.inf, None, "dt is inf"),
        ("1", None, "give a number"),
        (None, -1, "dt.dt is -1"),
    ],
)
def test_sampling_times_that_contradict_or_mean_nothing_are_refused(caller, own, said):
    assert said in refusal(sampling_time, caller, own)


@pytest.mark.parametrize(
    ("source", "dt"),
    [
        (RationalPlant([1], [1, 1]), 1),
        (RationalPlant([1], [1, 1], 1), 0),
        (control.tf([1], [1, 1], 0.1), 0.2),
        (scipy.signal.lti([1], [1, 1]), 1),
        (DelayPlant.parse("exp(-s)/(s+1)"), 1),
    ],
)
def test_mixed_sampling_times_are_refused_for_every_source(source, dt):
    assert "leave dt out or convert the system" in refusal(as_plant, source, dt=dt)


def test_what_scipy_makes_of_a_plant_in_continuous_time_is_that_plant_in_discrete_time():
    # 1/(s + 1) held for .5 s: c/(z - a) with a = exp(-.5), c = 1 - a
    sampled = [
        scipy.signal.cont2discrete(([1], [1, 1]), 0.5),
        scipy.signal.cont2discrete(tuple(np.array([[v]]) for v in (-1.0, 1.0, 1.0, 0.0)), 0.5),
    ]
    for found in map(as_plant, sampled):
        assert found.dt == F(1, 2)
        assert [*map(float, found.numerator)] == pytest.approx([1 - math.exp(-0.5)])
        assert [*map(float, found.denominator)] == pytest.approx([1, -math.exp(-0.5)])
    assert "leave dt out" in refusal(as_plant, sampled[0], dt=1)


def test_coefficients_that_matlab_saved_are_arrays_of_one_row():
    kept = io.BytesIO()
    scipy.io.savemat(kept, {"num": [1, 2], "den": [1, 3, 2, 0]})
    read = scipy.io.loadmat(kept)
    assert read["den"].shape == (1, 4)
    assert as_plant((read["num"], read["den"])) == as_plant(([1, 2], [1, 3, 2, 0]))
    assert "a block has one input and one output" in refusal(as_plant, (np.ones((2, 2)), [1, 1]))


def test_zeros_poles_and_gain_of_scipy_are_not_taken_for_matrices():
    # (s + 2)/(s + 1): one zero, one pole, gain and period have the shapes of A, B, C, D of one state
    sampled = scipy.signal.cont2discrete(([-2.0], [-1.0], 1.0), 0.5)
    assert "give scipy.signal.ZerosPolesGain(z, p, k, dt=dt)" in refusal(as_plant, sampled)
    found = as_plant(scipy.signal.ZerosPolesGain(*sampled[:3], dt=sampled[3]))
    assert (found.dt, found.transfer(1).real) == (F(1, 2), pytest.approx(2))  # H(0) = 2
    assert as_plant((np.array(-1.0), np.array(1.0), 1.0)).denominator == (1, 1)  # A of no dimension
    assert as_plant((np.array([-1.0]), np.array([1.0]), 1.0, 0.0)).denominator == (1, 1)


def test_a_loop_is_asked_for_its_block():
    with pytest.raises(
        InputError, match=r"a LoopSystem is a block and what closes the loop; give its block, loop\.block"
    ):
        as_plant(builtin_loop("ct-7"))
