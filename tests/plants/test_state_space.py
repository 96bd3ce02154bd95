"""Dense blocks in floating point: values against exact arithmetic, with an estimate that covers the error."""

import math
from fractions import Fraction

import control
import numpy as np
import pytest
from flint import acb, acb_mat, arb, ctx
from hypothesis import given
from hypothesis import strategies as st

from lure.arrays import balanced
from lure.errors import InputError
from lure.plants import rational_block
from lure.plants.frequency_data import FrequencyData
from lure.plants.state_space import ControllerForm, StateSpace

OSCILLATOR = StateSpace([[0, 1], [-1, -0.1]], [0, 1], [1, 0])


def random_block(n, seed, scale=1.0):
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n)) * np.exp(scale * rng.standard_normal((n, n)))
    return StateSpace(A, rng.standard_normal(n), rng.standard_normal(n), rng.standard_normal())


def exact_values(block, points):
    """``H`` from the doubles of the block in balls of 300 bits, as doubles."""
    precision, ctx.prec = ctx.prec, 300
    try:
        n, values = block.order, []
        for s in points:
            rows = [[acb(-block.A[i, j]) + (acb(s.real, s.imag) if i == j else 0) for j in range(n)] for i in range(n)]
            x = acb_mat(rows).solve(acb_mat([[acb(float(b))] for b in block.B]))
            h = sum((acb(float(c)) * x[i, 0] for i, c in enumerate(block.C)), acb(block.D))
            assert h.real.rad() + h.imag.rad() < arb(1e-30) * abs(h)
            values.append(complex(float(h.real.mid()), float(h.imag.mid())))
        return np.array(values)
    finally:
        ctx.prec = precision


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("scale", [0.0, 3.0])
def test_the_error_stays_within_the_estimate_also_for_badly_scaled_matrices(seed, scale):
    block = random_block(12, seed, scale)
    omega = np.geomspace(1e-3, 1e3, 9)
    found = block.frequency_response(omega)
    away = np.abs(found.response - exact_values(block, 1j * omega))
    assert (away <= found.error).all()
    assert (found.error <= 1e-6 * np.abs(found.response)).all()  # and the estimate says something


# H = 1/(s^2 + 0.1 s + 1): at resonance H(i) = 1/(0.1 i) = -10 i.
def test_an_oscillator_has_the_response_of_its_formula():
    omega = np.array([0.0, 0.5, 1.0, 2.0, 1e3])
    found = OSCILLATOR.frequency_response(omega)
    assert found.response == pytest.approx(1 / (1 - omega**2 + 0.1j * omega), rel=1e-14)
    assert found.response[2] == pytest.approx(-10j)


# The exact error near a pole at distance 1e-9 of the axis: values of 5e8 with an error of at most 1e-6 relative.
def test_the_estimate_grows_towards_a_pole():
    block = StateSpace([[0.3, 1.0], [-2.0, -0.3 - 2e-9]], [1, 1], [1, 0])
    pole = math.sqrt(2 - 0.09)
    found = block.frequency_response([0.5 * pole, pole])
    relative = found.error / np.abs(found.response)
    assert relative[1] > 1e4 * relative[0]
    assert (np.abs(found.response - exact_values(block, 1j * found.omega)) <= found.error).all()


def test_discrete_time_is_evaluated_on_the_circle():
    block = StateSpace([[0.5]], [1], [1], 0, 0.1)
    found = block.frequency_response([0.0, 10 * math.pi])
    assert found.response == pytest.approx([2, -1 / 1.5])
    assert found.dt == block.dt == Fraction(0.1)
    assert block.to_control().dt == pytest.approx(0.1)


@given(st.integers(1, 8), st.integers(0, 10**6), st.floats(-3, 3), st.floats(0.01, 10))
def test_a_block_agrees_with_its_exact_transfer_function(n, seed, real, imaginary):
    block = random_block(n, seed)
    exact = rational_block(block.A, block.B, block.C, block.D)
    top, bottom = (  # exact complex Horner, so that cancellation in the polynomials does no harm
        _horner(side, Fraction(real), Fraction(imaginary)) for side in (exact.numerator, exact.denominator)
    )
    size = bottom[0] ** 2 + bottom[1] ** 2
    value = complex(
        float((top[0] * bottom[0] + top[1] * bottom[1]) / size), float((top[1] * bottom[0] - top[0] * bottom[1]) / size)
    )
    points = np.array([complex(real, imaginary)])
    found, error = block._values(points)
    assert abs(found[0] - value) <= 4 * error[0] + 1e-15 * abs(value)


def _horner(coefficients, x, y):
    real, imaginary = Fraction(0), Fraction(0)
    for c in coefficients:
        real, imaginary = real * x - imaginary * y + c, real * y + imaginary * x
    return real, imaginary


# x_1' = -x_1 + mu, x_j' = g x_(j-1) - x_j: H = g^(n-1)/(s+1)^n; the substitution passes 1e+480 on its way for g = 1e-4.
@pytest.mark.parametrize(("n", "g"), [(40, 1.0), (60, 1e-4), (121, 1e-4), (121, 1e-2)])
def test_a_long_chain_neither_overflows_nor_loses_its_small_gain(n, g):
    A = -np.eye(n) + g * np.eye(n, k=-1)
    block = StateSpace(A, np.eye(n)[0], np.eye(n)[-1])
    s = np.array([0.0, 0.5j, 1j])
    expected = np.exp((n - 1) * math.log(g) - n * np.log(s + 1)) if (n - 1) * math.log10(g) > -300 else 0 * s
    assert block.transfer(s) == pytest.approx(expected, rel=1e-10, abs=1e-300)


# Weak couplings 1e-8 below a full upper triangle: the substitution is rescaled while sums over it are under way.
@pytest.mark.slow
def test_rescaling_reaches_the_sums_under_way():
    rng = np.random.default_rng(5)
    n = 70
    A = np.triu(rng.standard_normal((n, n)), 1) - np.diag(1 + rng.random(n)) + 1e-8 * np.eye(n, k=-1)
    s = np.array([0.3j, 2j])
    x = ControllerForm(A, np.eye(n), 1.0).solutions(s)  # as it stands: balancing would remove the difficulty
    for entry in range(0, 36, 5):  # down to 1e-280
        assert x[entry] == pytest.approx(
            exact_values(StateSpace(A, np.eye(n)[0], np.eye(n)[entry]), s), rel=1e-9, abs=0
        )


def test_states_that_the_input_does_not_reach_are_left_out():
    assert StateSpace(np.zeros((2, 2)), [1, 0], [1, 1]).transfer(2.0) == pytest.approx(0.5)
    A = np.diag([-1.0, -2.0, 3.0])
    form = ControllerForm.of(A, np.array([1.0, 1.0, 0.0]))
    assert form.H.shape == (2, 2)
    block = StateSpace(A, [1, 1, 0], [1, 1, 1])
    assert block.transfer([0.0, 1j, 3.0]) == pytest.approx([1.5, 1 / (1 + 1j) + 1 / (2 + 1j), 1 / 4 + 1 / 5])
    assert StateSpace(A, [0, 0, 0], [1, 1, 1], 7).transfer([0.0, 2j]) == pytest.approx([7, 7])


@given(st.integers(0, 10**6), st.floats(1e-3, 1e3))
def test_the_response_does_not_depend_on_the_unit_of_time(seed, speed):
    slow = random_block(6, seed)
    fast = StateSpace(speed * slow.A, speed * slow.B, slow.C, slow.D)
    a, b = slow.frequency_response([0.7]), fast.frequency_response([0.7 * speed])
    assert abs(a.response[0] - b.response[0]) <= 100 * (a.error[0] + b.error[0])


def test_batches_and_the_shape_of_the_points_do_not_matter():
    block = random_block(80, 3)
    s = 1j * np.geomspace(0.1, 10, 60).reshape(4, 15)
    values = block.transfer(s)
    assert values.shape == (4, 15)
    assert values[2, 7] == pytest.approx(block.transfer(s[2, 7]), rel=1e-9)
    peer = control.frequency_response(block.to_control(), s.imag.ravel()).frdata.ravel()
    assert values.ravel() == pytest.approx(peer, rel=1e-8)


def test_a_pole_is_not_finite_and_refused_as_a_frequency():
    block = StateSpace([[0.0]], [1], [1])
    assert not np.isfinite(block.transfer(0.0))
    with pytest.raises(InputError, match="omega = 0 rad/s is at a pole"):
        block.frequency_response([0.0, 1.0])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (([[1, 2]], [1], [1]), "needs A \\(n, n\\).*got A \\(1, 2\\)"),
        (([[1]], [[1]], [1]), "B \\(1, 1\\)"),
        (([[1]], [1], [1, 2]), "C \\(2,\\)"),
        (([[1]], [1], [1], [0, 0]), "D \\(2,\\)"),
        ((np.empty((0, 0)), [], []), "with n >= 1"),
        (([[math.nan]], [1], [1]), "A has an entry that is not finite"),
        (([[1]], [1], [1j]), "C is not an array of real numbers"),
        (([[1]], ["x"], [1]), "B is not an array of real numbers"),
        (([[1]], [1], [1], 0, -1), "dt is -1; give a positive time"),
        (([[1]], [1], [1], 0, "x"), "give a number"),
    ],
)
def test_what_is_no_state_space_is_refused(arguments, said):
    with pytest.raises(InputError, match=said):
        StateSpace(*arguments)


def test_a_block_is_a_copy_that_cannot_be_written_to():
    A = np.array([[-1.0]])
    block = StateSpace(A, [1], [1])
    A[0, 0] = 5
    assert block.A[0, 0] == -1
    with pytest.raises(ValueError, match="read-only"):
        block.A[0, 0] = 2
    assert str(block) == "state space of order 1 in continuous time"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (([1, 2], [1]), "needs omega \\(m,\\)"),
        (([], []), "m >= 1"),
        (([2, 1], [1, 1]), "increasing"),
        (([1, 1], [1, 1]), "increasing"),
        (([-1, 1], [1, 1]), "nonnegative"),
        (([1, math.inf], [1, 1]), "finite"),
        (([1], [math.nan]), "nan"),
        (([1], ["x"]), "not an array of numbers"),
        (([1], [1], None, [1, 2]), "one value for each frequency"),
    ],
)
def test_what_is_no_frequency_data_is_refused(arguments, said):
    with pytest.raises(InputError, match=said):
        FrequencyData(*arguments)


def test_frequency_data_name_their_range():
    assert str(FrequencyData([0.5, 2], [1, 1j])) == "2 values of H from 0.5 to 2 rad/s"


def test_units_beyond_the_largest_integer_are_no_warning():
    even, units = balanced(np.array([[0.0, 1e-40], [1e40, 0.0]]))  # warnings are errors in tests
    assert units[1] / units[0] > 2.0**64
    assert 0.5 <= abs(even[0, 1]) <= 2
