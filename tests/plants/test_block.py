"""lure.plants.block: shapes, copies, and the transfer function of a general finite block."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import coo_array, csr_array, eye_array

from lure import InputError, LinearBlock

# sigma'' + 3 sigma' + 2 sigma = mu: H = 1/((s + 1)(s + 2))
OSCILLATOR = LinearBlock([[0, 1], [-2, -3]], [0, 1], [0, 0], [1, 0])


def known(s):
    return 1 / ((s + 1) * (s + 2))


entries = st.floats(-10, 10)


@st.composite
def blocks(draw):
    n = draw(st.integers(1, 5))
    numbers = draw(st.lists(entries, min_size=n * (n + 3), max_size=n * (n + 3)))
    return LinearBlock(np.reshape(numbers[: n * n], (n, n)), *np.reshape(numbers[n * n :], (3, n)))


@pytest.mark.parametrize("s", [0.0, 1.0, 1j, -0.5 + 2j, 1e6j])
def test_the_transfer_function_of_a_known_block(s):
    assert OSCILLATOR.transfer(s) == pytest.approx(known(s), rel=1e-13)


def test_transfer_keeps_the_shape_of_the_points():
    s = np.array([[1.0, 1j], [2j, 3.0]])
    assert OSCILLATOR.transfer(s).shape == (2, 2)
    assert np.allclose(OSCILLATOR.transfer(s), known(s), rtol=1e-13)
    assert OSCILLATOR.transfer(0.0).shape == ()


@given(block=blocks(), real=st.floats(25, 50), imag=st.floats(-50, 50))
def test_the_transfer_function_solves_its_linear_system(block, real, imag):
    # to the right of every eigenvalue, which are at most 5 * 10 in size by Gershgorin: 60 + real
    s = complex(60 + real, imag)
    x = np.linalg.solve(s * np.eye(block.order) - block.A, block.b1)
    assert block.transfer(s) == pytest.approx(block.c @ x, rel=1e-9, abs=1e-12)


@given(block=blocks(), imag=st.floats(-50, 50))
def test_conjugate_points_give_conjugate_values(block, imag):
    s = complex(70, imag)
    assert block.transfer(np.conj(s)) == pytest.approx(np.conj(block.transfer(s)), rel=1e-12, abs=1e-15)


@given(block=blocks(), imag=st.floats(-50, 50), gain=st.floats(-5, 5))
def test_the_transfer_function_is_linear_in_the_input_and_does_not_see_the_load(block, imag, gain):
    s = complex(70, imag)
    scaled = LinearBlock(block.A, gain * block.b1, 7.0 + block.b2, block.c)
    assert scaled.transfer(s) == pytest.approx(gain * block.transfer(s), rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("form", [csr_array, coo_array])
def test_a_sparse_block_is_the_same_block(form):
    sparse = LinearBlock(form(OSCILLATOR.dense()), OSCILLATOR.b1, OSCILLATOR.b2, OSCILLATOR.c)
    assert np.array_equal(sparse.dense(), OSCILLATOR.dense())
    assert sparse.transfer(2j) == OSCILLATOR.transfer(2j)
    assert sparse.A.format == "csr"


def test_entries_given_twice_in_a_sparse_matrix_add_up():
    A = coo_array(([1.0, 1.0, -3.0], ([0, 0, 1], [0, 0, 1])), shape=(2, 2))
    assert LinearBlock(A, [1, 1], [0, 0], [1, 1]).dense().tolist() == [[2, 0], [0, -3]]


def test_at_a_pole_the_value_is_not_finite_and_the_others_stand():
    integrator = LinearBlock([[0.0]], [1.0], [0.0], [1.0])
    values = integrator.transfer([0.0, 2.0])
    assert not np.isfinite(values[0])
    assert values[1] == 0.5


def test_python_control_gets_the_block_from_mu_to_sigma():
    system = OSCILLATOR.to_control()
    assert (system.nstates, system.ninputs, system.noutputs, system.dt) == (2, 1, 1, 0)
    assert system(1j) == pytest.approx(known(1j))


@pytest.mark.parametrize("omega", [[0.5], [1.0, 2.0], [1.0, 2.0, 3.0], np.array([1.0, 2.0]), 4.0])
def test_a_frequency_response_has_exactly_the_frequencies_asked_for(omega):
    # python-control reads a list of two as limits of a range of its own
    response = OSCILLATOR.frequency_response(omega)
    assert np.array_equal(response.omega, np.atleast_1d(omega))
    assert np.allclose(np.ravel(response.frdata), known(1j * np.atleast_1d(omega)), rtol=1e-12)


def test_a_block_keeps_copies_that_cannot_be_written_to():
    A, b = np.array([[-1.0]]), np.array([1.0])
    block = LinearBlock(A, b, b, b)
    A[0, 0], b[0] = 5.0, 5.0
    assert (block.A[0, 0], block.b1[0]) == (-1.0, 1.0)
    sparse = eye_array(3, format="csr")
    frozen = LinearBlock(sparse, *np.ones((3, 3)))
    sparse.data[0] = 9.0
    assert frozen.A.data[0] == 1.0
    for array in (block.A, block.b1, block.b2, block.c, frozen.A.data):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_exact_entries_become_the_nearest_doubles():
    third = Fraction(1, 3)
    assert LinearBlock([[third]], [third], [0], [1]).A[0, 0] == 1 / 3


@pytest.mark.parametrize(
    ("A", "b1", "b2", "c", "shapes"),
    [
        (np.eye(2), [1, 2, 3], [1, 2], [1, 2], r"A \(2, 2\), b1 \(3,\), b2 \(2,\), c \(2,\)"),
        (np.ones((2, 3)), [1, 2], [1, 2], [1, 2], r"A \(2, 3\), b1 \(2,\)"),
        (np.eye(2), [1, 2], [1], [1, 2], r"b2 \(1,\)"),
        (np.eye(2), [1, 2], [1, 2], [[1, 2]], r"c \(1, 2\)"),
        (np.eye(2), [[1], [2]], [1, 2], [1, 2], r"b1 \(2, 1\)"),
        (5.0, [1], [1], [1], r"A \(\)"),
        (np.ones((0, 0)), [], [], [], r"A \(0, 0\)"),
        (eye_array(3), [1, 2], [1, 2], [1, 2], r"A \(3, 3\)"),
    ],
)
def test_shapes_that_do_not_fit_are_refused_with_all_four(A, b1, b2, c, shapes):
    with pytest.raises(
        InputError, match=rf"^LinearBlock needs A \(n, n\), b1 \(n,\), b2 \(n,\), c \(n,\) with n >= 1; .*{shapes}"
    ):
        LinearBlock(A, b1, b2, c)


@pytest.mark.parametrize("name", ["A", "b1", "b2", "c"])
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_an_entry_that_is_not_finite_is_refused_by_name(name, value):
    parts = {"A": [[1.0]], "b1": [1.0], "b2": [1.0], "c": [1.0]}
    parts[name] = [[value]] if name == "A" else [value]
    with pytest.raises(InputError, match=rf"^LinearBlock\.{name} has an entry that is not finite; give finite"):
        LinearBlock(**parts)


@pytest.mark.parametrize("A", [csr_array([[math.nan]]), csr_array([[math.inf]]), [[None]], None])
def test_a_matrix_with_a_hole_is_refused(A):
    with pytest.raises(InputError, match=r"^LinearBlock\.A has an entry that is not finite; give finite numbers$"):
        LinearBlock(A, [1], [1], [1])


@pytest.mark.parametrize(
    "A", [[["1"]], [[1j]], np.array([[1j]]), csr_array([[1j]]), [[True]], "A", [[1], [2, 3]], [[10**400]]]
)
def test_what_is_not_an_array_of_real_numbers_is_refused(A):
    with pytest.raises(InputError, match=r"^LinearBlock\.A is not an array of real numbers \(.*\); give numbers$"):
        LinearBlock(A, [1], [1], [1])
