"""lure.analysis.numerics.exact_matrix and lure.analysis.numerics.exact_matrix: the classical critical cases, the
rod's scheme, and exactness."""

import math
from fractions import Fraction

import numpy as np
import pytest
from flint import fmpq, fmpq_mat, fmpz_mat
from hypothesis import given
from hypothesis import strategies as st

from lure import AssumptionError, InputError, LinearBlock
from lure.analysis.numerics.exact_matrix import exact_zero_eigenvalue, null_space, zero_eigenvalue, zero_multiplicity
from lure.analysis.verdict import Evidence
from lure.rod import upwind
from lure.rod.systems import paper_rod

PRIME = 2**61 - 1  # the first that is tried


def companion(numerator, denominator):
    """Controllable form of a strictly proper fraction, coefficients in descending powers, the leading one 1."""
    n = len(denominator) - 1
    A = [[Fraction(int(j == i + 1)) for j in range(n)] for i in range(n - 1)]
    A.append([-Fraction(value) for value in denominator[:0:-1]])
    c = [Fraction(value) for value in numerator[::-1]] + [Fraction(0)] * (n - len(numerator))
    return A, [0] * (n - 1) + [1], c


# the table of the critical case: residue = numerator(0)/(denominator without its factor s)(0)
@pytest.mark.parametrize(
    ("numerator", "denominator", "residue"),
    [
        ([1], [1, 0], 1),
        ([1], [1, 1, 0], 1),
        ([1], [1, 3, 2, 0], Fraction(1, 2)),
        ([1], [1, 1, 1, 0], 1),
        ([1], [1, Fraction("0.1"), 1, 0], 1),
        ([1, 2], [1, 1, 0], 2),
        ([1, 1], [1, 2, 0], Fraction(1, 2)),
    ],
)
def test_the_textbook_cases_have_a_simple_zero_with_a_positive_residue(numerator, denominator, residue):
    found = exact_zero_eigenvalue(*companion(numerator, denominator))
    assert (found.algebraic, found.geometric, found.residue) == (1, 1, residue)
    assert found.critical
    assert found.require() is found
    assert found.evidence is Evidence.CERTIFIED


# Lur'e's indirect control x' = -x + xi, xi' = mu, sigma = r xi - c x: H = (r s + r - c)/(s (s + 1)), residue r - c
@pytest.mark.parametrize(
    ("r", "c", "residue", "reason"),
    [
        (2, 1, 1, r"^the eigenvalue 0 is simple and the residue of H at 0 is 1 > 0$"),
        (1, 2, -1, r"^the residue of H at 0 is -1, and the critical case needs a positive one: .*right half-plane$"),
        (1, 1, 0, r"^the eigenvalue 0 is simple but unobservable \(c\^T r = 0\): "),
    ],
)
def test_indirect_control_is_accepted_or_refused_by_its_residue(r, c, residue, reason):
    found = exact_zero_eigenvalue([[-1, 1], [0, 0]], [0, 1], [-c, r])
    assert found.residue == residue
    assert found.observable is (residue != 0)
    assert found.controllable is True
    assert found.critical is (residue > 0)
    if not found.critical:
        with pytest.raises(AssumptionError, match=reason):
            found.require()


def test_a_zero_that_the_input_does_not_reach_is_refused():
    # xi' = 0: sigma = x + xi, and xi stays where it starts
    found = exact_zero_eigenvalue([[-1, 0], [0, 0]], [1, 0], [1, 1])
    assert (found.observable, found.controllable, found.residue) == (True, False, 0)
    with pytest.raises(AssumptionError, match=r"^the eigenvalue 0 is simple but uncontrollable \(l\^T b = 0\): "):
        found.require()


# (s + 1)/s^2: every gain k > 0 gives s^2 + k s + k, which is stable, and phi = sigma exp(-|sigma|) escapes all the same
def test_a_double_zero_with_one_eigenvector_is_refused():
    found = exact_zero_eigenvalue(*companion([1, 1], [1, 0, 0]))
    assert (found.algebraic, found.geometric, found.residue) == (2, 1, None)
    assert found.observable is found.controllable is None
    with pytest.raises(
        AssumptionError, match=r"^the eigenvalue 0 is double, with one eigenvector only, and the critical"
    ):
        found.require()


def test_a_double_zero_with_two_eigenvectors_is_refused():
    found = exact_zero_eigenvalue([[0, 0, 0], [0, 0, 0], [0, 0, -1]], [1, 1, 1], [1, 1, 1])
    assert (found.algebraic, found.geometric, found.residue) == (2, 2, None)
    with pytest.raises(AssumptionError, match=r"^the eigenvalue 0 is double, with 2 independent eigenvectors, and"):
        found.require()


def test_a_block_without_a_zero_eigenvalue_is_not_the_critical_case():
    found = exact_zero_eigenvalue([[-1, 2], [0, -3]], [1, 1], [1, 1])
    assert (found.algebraic, found.geometric, found.residue) == (0, 0, None)
    with pytest.raises(AssumptionError, match=r"^A has no eigenvalue 0: this is not the critical case"):
        found.require()
    assert str(found).endswith("use the criterion for a Hurwitz A.")


def test_a_matrix_of_zeros_is_all_zero_eigenvalue():
    found = exact_zero_eigenvalue(np.zeros((4, 4), dtype=int), [1] * 4, [1] * 4)
    assert (found.algebraic, found.geometric) == (4, 4)
    assert "of multiplicity 4" in found.reason


# the entry (1, 2N) of the ring is the double e nearest to -s a; with a' = -e/s the left null vector is
# 1/(s (1 + a')) on the forward wave, -a' times that on the backward wave and 1 at z:
# residue b1_z - a' b1_wave/(s (1 + a'))
@pytest.mark.parametrize("N", [1, 2, 10, 50])
@pytest.mark.parametrize("damping", ["1e-6", "2e-4", "1.2", "5", "1200", "-0.3", "-5"])
def test_the_scheme_has_a_simple_zero_with_the_exact_residue_of_its_doubles(N, damping):
    scheme = upwind(paper_rod(damping), N)
    found = zero_eigenvalue(scheme.block)
    A = scheme.A.toarray()
    s, e = Fraction(scheme.rate), Fraction(float(A[0, 2 * N - 1]))
    ratio = e / s  # -a'
    wave, end = Fraction(float(scheme.b1[N])), Fraction(float(scheme.b1[-1]))
    assert (found.order, found.algebraic, found.geometric) == (2 * N + 1, 1, 1)
    assert found.residue == end + wave / s * ratio / (1 - ratio)
    # 1 + a = 2k/(k + Z) loses digits when a is rounded
    loss = 1 + 1 / abs(1 + scheme.rod.reflection)
    assert float(found.residue) == pytest.approx(scheme.rod.residue_at_zero, rel=1e-15 * loss)
    assert found.critical is (float(damping) > 0)


@pytest.mark.parametrize("N", [1, 2, 10, 50])
def test_the_scheme_without_damping_has_a_double_zero(N):
    # a = -1 is exact, so the doubles say so too
    found = zero_eigenvalue(upwind(paper_rod("0"), N).block)
    assert (found.algebraic, found.geometric) == (2, 1)
    assert not found.critical


def test_the_ordering_of_the_states_does_not_matter():
    found = {zero_eigenvalue(upwind(paper_rod(), 5, ordering=name).block).residue for name in ("eq39", "eq42", "eq48")}
    assert len(found) == 1


@pytest.mark.slow
@pytest.mark.parametrize(("damping", "algebraic"), [("2e-4", 1), ("1.2", 1), ("0", 2)])
def test_two_hundred_cells_are_decided_exactly(damping, algebraic):
    found = zero_eigenvalue(upwind(paper_rod(damping), 200).block)
    assert (found.order, found.geometric, found.algebraic) == (401, 1, algebraic)


small = st.integers(-3, 3)


@st.composite
def matrices(draw, largest=6):
    n = draw(st.integers(1, largest))
    rank = draw(st.integers(0, n))
    left = draw(st.lists(small, min_size=n * rank, max_size=n * rank))
    right = draw(st.lists(small, min_size=n * rank, max_size=n * rank))
    return np.reshape(left, (n, rank)).astype(int) @ np.reshape(right, (rank, n)).astype(int)


def order_of_zero(coefficients):
    return next(i for i, value in enumerate(coefficients) if value != 0)


# the definitions, in rational arithmetic of another kind: rank by Gauss, characteristic polynomial over the rationals
@given(matrix=matrices())
def test_the_multiplicities_are_those_of_the_definitions(matrix):
    n = len(matrix)
    found = exact_zero_eigenvalue(matrix, [1] * n, [1] * n)
    rational = fmpq_mat(fmpz_mat(matrix.tolist()))
    assert found.geometric == n - rational.rank()
    assert found.algebraic == order_of_zero(rational.charpoly().coeffs())


# s H(s) at s = 10^-30 in rational arithmetic is the residue to about 30 digits
@given(matrix=matrices(), vectors=st.lists(small, min_size=12, max_size=12))
def test_the_residue_is_the_limit_of_s_times_the_transfer_function(matrix, vectors):
    n = len(matrix)
    b, c = vectors[:n], vectors[6 : 6 + n]
    found = exact_zero_eigenvalue(matrix, b, c)
    if found.residue is None:
        assert found.algebraic != 1
        return
    s = fmpq(1, 10**30)
    resolvent = fmpq_mat(n, n, [s * (i == j) - int(matrix[i, j]) for i in range(n) for j in range(n)])
    x = resolvent.solve(fmpq_mat(n, 1, b))
    value = s * sum((c[i] * x[i, 0] for i in range(n)), fmpq(0))
    assert abs(Fraction(int(value.p), int(value.q)) - found.residue) < Fraction(1, 10**15)


@given(
    matrix=matrices(4),
    vectors=st.lists(small, min_size=8, max_size=8),
    seed=st.integers(0, 100),
    size=st.integers(1, 9),
)
def test_the_answer_does_not_depend_on_the_basis_and_follows_the_units(matrix, vectors, seed, size):
    n = len(matrix)
    b, c = np.array(vectors[:n]), np.array(vectors[4 : 4 + n])
    rng = np.random.default_rng(seed)
    upper = np.triu(rng.integers(-2, 3, (n, n)), 1) + np.eye(n, dtype=int)
    inverse = np.rint(np.linalg.inv(upper)).astype(int)
    assert np.array_equal(upper @ inverse, np.eye(n, dtype=int))
    one = exact_zero_eigenvalue(matrix, b, c)
    # x = upper y, and time in units of 1/size
    other = exact_zero_eigenvalue(size * (inverse @ matrix @ upper), size * (inverse @ b), c @ upper)
    assert (one.algebraic, one.geometric) == (other.algebraic, other.geometric)
    assert other.residue == (None if one.residue is None else size * one.residue)


@given(matrix=matrices())
def test_the_null_space_is_one(matrix):
    integers = fmpz_mat(matrix.tolist())
    basis = null_space(integers)
    assert (integers * basis).is_zero()
    assert basis.ncols() == basis.rank() == len(matrix) - integers.rank()


@pytest.mark.parametrize("size", [1, 2, 5, 64])
def test_one_jordan_block_has_the_multiplicity_of_its_size(size):
    found = exact_zero_eigenvalue(np.eye(size, k=1, dtype=int), [1] * size, [1] * size)
    assert (found.algebraic, found.geometric) == (size, 1)


# modulo the prime that is tried first these have too small a rank, or too large a multiplicity
@pytest.mark.parametrize(
    ("matrix", "geometric", "algebraic"),
    [
        ([[PRIME, 0], [0, -1]], 0, 0),
        ([[PRIME, 0, 0], [0, -1, 0], [0, 0, 0]], 1, 1),
        ([[1, 1], [1, 1 + PRIME]], 0, 0),
        ([[0, 1, 0], [0, 0, 0], [0, 0, PRIME]], 1, 2),
    ],
)
def test_a_prime_that_divides_a_minor_is_found_out(matrix, geometric, algebraic):
    n = len(matrix)
    found = exact_zero_eigenvalue(matrix, [1] * n, [1] * n)
    assert (found.geometric, found.algebraic) == (geometric, algebraic)
    integers = fmpz_mat(matrix)
    assert null_space(integers).ncols() == geometric
    assert zero_multiplicity(integers, geometric) == algebraic


# eigvals returns 1e-17 or 1e-9 here where the answer is yes or no
@pytest.mark.parametrize("gap", [Fraction(1, 10**40), Fraction(2) ** -1074])
def test_almost_zero_is_not_zero(gap):
    found = exact_zero_eigenvalue([[0, 1, 0], [0, -gap, 1], [0, 0, -1]], [0, 0, 1], [1, 0, 0])
    assert (found.algebraic, found.residue) == (1, 1 / gap)
    assert exact_zero_eigenvalue([[0, 1, 0], [0, 0, 1], [0, 0, -1]], [0, 0, 1], [1, 0, 0]).algebraic == 2


def test_doubles_mean_the_doubles_they_are():
    # 0.1 + 0.2 is not the double 0.3: as doubles the rows are independent, as decimals they are not
    rows = [[0.1, 0.2, 0.1 + 0.2], [0.1, 0.2, 0.3], [0, 0, 0]]
    assert exact_zero_eigenvalue(rows, [1] * 3, [1] * 3).geometric == 1
    decimals = [[Fraction("0.1"), Fraction("0.2"), Fraction("0.3")]] * 2 + [[0, 0, 0]]
    assert exact_zero_eigenvalue(decimals, [1] * 3, [1] * 3).geometric == 2


def test_a_block_and_its_entries_give_the_same_answer():
    block = LinearBlock([[0.0, 1.0], [0.0, -0.3]], [0.0, 1.0], [0.0, 0.0], [0.7, 1.0])
    assert zero_eigenvalue(block) == exact_zero_eigenvalue(block.A, block.b1, block.c)
    assert zero_eigenvalue(block).residue == Fraction(0.7) / Fraction(0.3)


def test_a_hundred_states_of_random_doubles_are_quick():
    rng = np.random.default_rng(7)
    A = rng.standard_normal((100, 100))
    A[:, 40] = 0
    found = exact_zero_eigenvalue(A, rng.standard_normal(100), rng.standard_normal(100))
    assert (found.geometric, found.algebraic) == (1, 1)


@pytest.mark.parametrize("states", [101, pytest.param(401, marks=pytest.mark.thorough)])
def test_hundreds_of_states_of_random_doubles_are_decided(states):
    rng = np.random.default_rng(7)
    A = rng.standard_normal((states, states))
    A[40] = A[41]  # a zero that no entry shows
    b, c = rng.standard_normal(states), rng.standard_normal(states)
    found = exact_zero_eigenvalue(A, b, c)
    assert (found.geometric, found.algebraic) == (1, 1)
    s = 1e-6
    assert float(found.residue) == pytest.approx(s * c @ np.linalg.solve(s * np.eye(states) - A, b), rel=1e-2)


@pytest.mark.parametrize(
    ("A", "b", "c", "message"),
    [
        ([[1, 2]], [1], [1], r"got A \(1, 2\), b \(1,\), c \(1,\)"),
        ([[1]], [1, 2], [1], r"got A \(1, 1\), b \(2,\), c \(1,\)"),
        ([[1, 2], [3]], [1, 2], [1, 2], r"got A \(2,\)"),
        (np.ones((0, 0)), [], [], r"got A \(0, 0\)"),
    ],
)
def test_shapes_that_do_not_fit_are_refused(A, b, c, message):
    with pytest.raises(
        InputError, match=rf"^zero_eigenvalue needs A \(n, n\), b \(n,\), c \(n,\) with n >= 1; {message}"
    ):
        exact_zero_eigenvalue(A, b, c)


@pytest.mark.parametrize(
    ("value", "message"),
    [(math.nan, "is nan; give a finite number"), (math.inf, "is inf; give a finite"), ("1", "is '1'; give a number")],
)
def test_an_entry_that_is_not_a_number_is_refused_by_place(value, message):
    with pytest.raises(InputError, match=rf"^A\[0, 1\] {message}"):
        exact_zero_eigenvalue([[0, value], [0, 0]], [1, 1], [1, 1])
    with pytest.raises(InputError, match=rf"^b\[1\] {message}"):
        exact_zero_eigenvalue([[0, 0], [0, 0]], [1, value], [1, 1])
    with pytest.raises(InputError, match=rf"^c\[0\] {message}"):
        exact_zero_eigenvalue([[0, 0], [0, 0]], [1, 1], [value, 1])


@pytest.mark.slow
def test_too_many_states_are_refused_with_the_limit():
    with pytest.raises(InputError, match=r"^zero_eigenvalue is for at most 1000 states; got 1001: "):
        zero_eigenvalue(upwind(paper_rod(), 500).block)
    with pytest.raises(InputError, match=r"got 2000001: "):  # before anything of that size squared is made
        zero_eigenvalue(upwind(paper_rod(), 1_000_000).block)
