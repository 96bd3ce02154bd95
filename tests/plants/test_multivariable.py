"""Plants with several inputs and outputs: what becomes one, its shapes, and the realisation of a transfer matrix."""

import pickle
from fractions import Fraction as F

import control
import numpy as np
import pytest
import scipy.signal
from hypothesis import given
from hypothesis import strategies as st

from lure import InputError, Loop, RationalPlant, Tanh
from lure.plants import as_plant
from lure.plants.conversion import one_channel
from lure.plants.multivariable import MultivariablePlant

A2, SHAPES = [[0, 1], [-2, -3]], "2 inputs and 2 outputs"
POINTS = np.array([0.3, 1j, 2 - 1j])


def test_matrices_of_any_shape_are_taken_exactly():
    plant = as_plant((A2, [["1/3", 0], [0, 1]], [[1, 0], [0, 1]], [[0, 0], ["0.1", 0]]))
    assert (plant.order, plant.inputs, plant.outputs, plant.dt) == (2, 2, 2, None)
    assert (plant.B[0][0], plant.D[1][0]) == (F(1, 3), F(1, 10))
    assert pickle.loads(pickle.dumps(plant)) == plant
    wide = as_plant((A2, [[0, 1], [1, 0]], [1, 0]), dt=0.5)
    assert (wide.inputs, wide.outputs, wide.dt, wide.C) == (2, 1, F(1, 2), ((1, 0),))
    assert as_plant(([[-1]], [[1, 2]], [[1], [3]])).D == ((0, 0), (0, 0))
    assert as_plant(([], [], [], [[1, 2]])).inputs == 2
    assert isinstance(as_plant((A2, [[0], [1]], [[1, 0]])), RationalPlant)  # one channel is what it was


def test_one_entry_of_the_transfer_matrix_is_that_of_the_matrices():
    plant = as_plant((A2, [[1, 0], [0, 1]], [[1, 0], [0, 1]]))
    # (sI - A)^-1 = [[s + 3, 1], [-2, s]] / (s^2 + 3 s + 2)
    assert plant.channel(0, 0) == RationalPlant([1, 3], [1, 3, 2])
    assert plant.channel(1, 0) == RationalPlant([-2], [1, 3, 2])


def test_objects_of_python_control_and_scipy_keep_their_response():
    for system in (control.rss(4, 2, 3), control.drss(3, 3, 2), control.ss([], [], [], [[1, 2]])):
        plant = as_plant(system)
        assert (plant.inputs, plant.outputs) == (system.ninputs, system.noutputs)
        for s in POINTS:
            assert plant.transfer(s) == pytest.approx(system(s), abs=1e-9)
            assert plant.to_control()(s) == pytest.approx(system(s), abs=1e-9)
    tf = control.tf([[[1], [1]], [[1], [2]]], [[[1, 1], [1, 2]], [[1, 2], [1, 3, 2]]])
    assert as_plant(tf).transfer(POINTS)[1] == pytest.approx(tf(1j))
    assert as_plant(scipy.signal.StateSpace([[1.0]], [[1.0, 2.0]], [[1.0]], [[0.0, 0.0]])).inputs == 2
    tall = as_plant(scipy.signal.TransferFunction([[1.0, 0.0], [0.0, 2.0]], [1.0, 1.0]))
    assert tall.transfer(1.0).ravel() == pytest.approx([1 / 2, 1])  # s/(s + 1) and 2/(s + 1) at s = 1


def test_a_transfer_matrix_is_realised_minimally():
    # residues at -1: diag(1, 2), rank 2; at -2: [[0, 1], [1, -2]], rank 2; so four states
    assert as_plant([["1/(s+1)", "1/(s+2)"], ["1/(s+2)", "2/((s+1)*(s+2))"]]).order == 4
    assert as_plant([["1/(s+1)", "1/(s+1)"], ["1/(s+1)", "1/(s+1)"]]).order == 1  # residue of rank 1
    gain = as_plant([["1/s", 2], ["0", "1/3"]])
    assert (gain.order, gain.D) == (1, ((0, 2), (0, F(1, 3))))
    assert as_plant([["1/(z-0.5)", "1"]], dt=0.5).dt == F(1, 2)


@given(st.lists(st.lists(st.integers(-3, 3), min_size=4, max_size=4), min_size=2, max_size=2), st.integers(1, 3))
def test_a_realisation_has_the_response_of_its_entries(tops, pole):
    entries = [
        [RationalPlant([row[j], row[j + 1]], [1, pole + j, (i + 1) * pole + 5]) for j in (0, 2)]
        for i, row in enumerate(tops)
    ]
    plant = as_plant(entries)
    for s in POINTS:
        wanted = [[entry.transfer(s) for entry in row] for row in entries]
        assert plant.transfer(s) == pytest.approx(np.array(wanted, dtype=complex).reshape(2, 2), abs=1e-9)


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ((A2, [[0, 1], [1, 0]], [1, 0], [[1]]), "D is 1 x 1, and the plant has 2 inputs and 1 outputs"),
        ((A2, [[0, 1], [1, float("nan")]], [1, 0]), r"B\[1\]\[1\] is nan"),
        ((A2, [[0, 1], [1, 0]], [[1, 0, 0], [0, 1, 0]]), "C is 2 x 3, and A has 2 rows; give A"),
        ((A2, [[0, 1], [1, 0], [1, 1]], [[1, 0], [0, 1]]), "B is 3 x 2, and A has 2 rows; give A"),
        ([["1/(s+1)", "0"], ["0"]], "differ in length"),
        ([["1/(s+1)", "0"], ["0", "1/(z-2)"]], "both in s|partly|in z"),
        ([["(s-1)/((s-1)*(s+2))", "0"], ["0", "1/s"]], r"transfer\[0\]\[0\] has a factor common"),
        ([["exp(-s)", "0"], ["0", "1/(s+1)"]], r"transfer\[0\]\[0\] has dead time and is not strictly proper"),
        ([["exp(-s)/(s+1)", "0"], ["0", "1/(z-0.5)"]], "in discrete time, and another entry has dead time"),
        ([["(s+1)*exp(-s)/((s+1)*(s+2))", "0"], ["0", "1/s"]], r"transfer\[0\]\[0\] has a factor common"),
        (control.frd(np.ones((2, 2, 1)), [1]), "the data have 2 inputs"),
        (control.rss(201, 2, 2, strictly_proper=True), "stop at 200 states"),
    ],
)
def test_what_is_no_such_plant_is_refused_in_a_sentence(source, said):
    with pytest.raises(InputError, match=said):
        as_plant(source)


def test_what_is_about_one_nonlinearity_says_so():
    several = control.rss(2, 2, 2)
    for door in (one_channel, lambda system: Loop(system, Tanh())):
        with pytest.raises(InputError, match=r"2 inputs and 2 outputs: .* choose a pair, e.g. sys\[0, 0\]"):
            door(several)


def test_matrices_that_do_not_fit_are_no_plant():
    with pytest.raises(InputError, match="do not fit"):
        MultivariablePlant(((F(1),),), ((F(1), F(2)),), ((F(1),),), ((F(0),),))
