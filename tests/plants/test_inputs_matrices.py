"""Matrices become their exact transfer function, every hidden mode kept; what does not fit is refused."""

import math
from fractions import Fraction as F

import numpy as np
import pytest
from flint import fmpq, fmpq_mat
from hypothesis import given
from hypothesis import strategies as st
from plants import value
from refusals import refusal

from lure.errors import InputError
from lure.plants import as_plant, rational_block
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace
from lure.rod import builtin_system, upwind

COMPANION = ([[0, 1], [-2, -3]], [0, 1], [1, 0])  # 1/(s^2 + 3 s + 2)


def test_matrices_become_the_exact_transfer_function():
    assert as_plant(COMPANION) == RationalPlant([1], [1, 3, 2])
    assert as_plant((*COMPANION, 2)) == RationalPlant([2, 6, 5], [1, 3, 2])
    assert as_plant(([["-1/3"]], ["1"], [F(2, 7)])) == RationalPlant([F(2, 7)], [1, F(1, 3)])
    assert as_plant((-1, 1, 1)) == RationalPlant([1], [1, 1])
    assert as_plant(([], [], [], 2)) == RationalPlant([2], [1])


# Indirect control with r = c = 1: the zero eigenvalue does not reach sigma = xi - x.
def test_a_mode_that_the_output_does_not_see_stays_in_the_block():
    assert as_plant(([[-1, 1], [0, 0]], [0, 1], [-1, 1])) == RationalPlant([1, 0], [1, 1, 0])
    assert as_plant(([[-1, 0], [0, 5]], [1, 0], [1, 1])) == RationalPlant([1, -5], [1, -4, -5])


ENTRIES = st.integers(-3, 3)


@st.composite
def systems(draw, largest=5):
    n = draw(st.integers(1, largest))
    vector = st.lists(ENTRIES, min_size=n, max_size=n)
    return draw(st.lists(vector, min_size=n, max_size=n)), draw(vector), draw(vector), draw(ENTRIES)


@given(systems(), st.fractions(-5, 5, max_denominator=11))
def test_the_block_of_matrices_has_the_value_of_the_resolvent(system, point):
    A, b, c, d = system
    n = len(A)
    q = fmpq(point.numerator, point.denominator)
    resolvent = fmpq_mat(n, n, [q * (i == j) - A[i][j] for i in range(n) for j in range(n)])
    if resolvent.det() == 0:
        return
    x = resolvent.solve(fmpq_mat(n, 1, b))
    expected = sum((c[i] * x[i, 0] for i in range(n)), fmpq(d))
    found = value(rational_block(A, b, c, d), point)
    assert (found.numerator, found.denominator) == (int(expected.p), int(expected.q))


@given(systems(4), st.integers(-4, 4), st.integers(1, 5))
def test_a_change_of_basis_changes_nothing(system, shear, scale):
    A, b, c, d = (np.array(part, dtype=object) for part in system)
    n = len(b)
    T, inverse = (np.array([[F(int(i == j)) for j in range(n)] for i in range(n)], dtype=object) for _ in range(2))
    T[0, 0], inverse[0, 0] = F(scale), F(1, scale)
    if n > 1:  # T = diag(scale, 1, ...) with shear in the corner, and its inverse
        T[0, n - 1], inverse[0, n - 1] = F(shear), -F(shear, scale)
    assert (T.dot(inverse) == np.eye(n, dtype=int)).all()
    assert rational_block(T.dot(A).dot(inverse), T.dot(b), c.dot(inverse), d.item()) == rational_block(*system)


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        (([[0, 1]], [0, 1], [1, 0]), "A is not square: it has 1 row, and A\\[0\\] has 2 entries"),
        (([[0, 1], [-2, -3]], [[1, 0]], [[0], [1]]), "B is 1 x 2 and C is 2 x 1, as if C stood before B; give"),
        ((np.eye(2), np.ones((1, 2)), np.ones((2, 1)), 0), "as if C stood before B"),
        (([[0, 1], [2]], [0, 1], [1, 0]), "A\\[1\\] has 1 entry"),
        (([[0, 1], 2], [0, 1], [1, 0]), "mixes numbers and lists"),
        (([[0, 1], [-2, -3]], [0, 1, 2], [1, 0]), "B is 1 x 3 and A is 2 x 2; give 2 entries"),
        (([[0, 1], [-2, -3]], [0, 1], [1, 0], [0, 0]), "D has 2 entries"),
        (([[0, math.nan], [-2, -3]], [0, 1], [1, 0]), "A\\[0\\]\\[1\\] is nan; give a finite number"),
        (([[0, 1], [-2, -3]], [0, math.inf], [1, 0]), "B\\[1\\] is inf"),
        (([[0, 1j], [-2, -3]], [0, 1], [1, 0]), "complex coefficient"),
        (([], [], []), "the system is empty"),
        (("1", "1", "1"), "give A as a list of rows"),
        ((1, 2, 3, 4, 5, 6), "a system of 6 parts is unknown"),
        ((1,), "a system of 1 parts is unknown"),
    ],
)
def test_matrices_that_do_not_fit_are_refused(parts, said):
    with pytest.raises(InputError, match=said):
        as_plant(parts)


def test_sixty_states_are_exact_and_sixty_one_are_not():
    rng = np.random.default_rng(1)
    for n, kind in ((60, RationalPlant), (61, StateSpace)):
        A, b, c = rng.standard_normal((n, n)) - 20 * np.eye(n), rng.standard_normal(n), rng.standard_normal(n)
        block = as_plant((A, b, c, 0.5))
        assert isinstance(block, kind)
        assert block.order == n
        direct = c @ np.linalg.solve(1j * np.eye(n) - A, b) + 0.5
        assert block.transfer(1j) == pytest.approx(direct, rel=1e-9)


def test_large_matrices_may_be_lists_or_sparse_and_a_limit_is_named():
    A = [[F(-1) * (i == j) for j in range(61)] for i in range(61)]
    assert as_plant((A, [1] * 61, [1] * 61)).transfer(0) == pytest.approx(61)
    assert "5001 states" in refusal(as_plant, (np.zeros((5001, 1)), [1], [1]))
    assert "not square" in refusal(as_plant, (np.zeros((70, 71)), np.ones(70), np.ones(70)))
    scheme = upwind(builtin_system("paper-rod").rod, 40)
    large = as_plant(scheme.block)
    assert isinstance(large, StateSpace)
    assert large.transfer(100j) == pytest.approx(scheme.transfer(100j), rel=1e-9)
