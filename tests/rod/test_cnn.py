"""The scheme: the cloning templates (44)-(47), the ring they assemble to, and the three orderings (39), (42),
(48)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lure import InputError
from lure.rod import upwind
from lure.rod.cellular.gallery import rod_template
from lure.rod.cellular.network import interconnection
from lure.rod.discretisation import ORDERINGS, ordering_permutation
from lure.rod.systems import paper_rod

cells = st.integers(1, 40)
integers = st.integers(-9, 9)


def ring(N, rate, reflection):
    return interconnection(rod_template(rate, reflection), (2 * N,), "periodic").toarray()[:, :-1]


def test_the_templates_are_those_of_the_paper():
    template = rod_template(3.0, -0.5)
    before, own = template.weights
    # (47): T_1^A = -s a on the last cell, T_1^C = s; (45): T^AC = [s, -s, 0] for the cells 2..2N
    assert template.offsets == ((-1,), (0,))
    assert before(np.arange(10)).tolist() == [1.5] + [3.0] * 9
    assert own == -3.0


def test_the_ring_of_two_cells_by_hand():
    # (36) with s = 3, a = -0.5: y1' = -3 y1 + 1.5 y4, yi' = 3 y_{i-1} - 3 y_i
    expected = [[-3, 0, 0, 1.5], [3, -3, 0, 0], [0, 3, -3, 0], [0, 0, 3, -3]]
    assert ring(2, 3.0, -0.5).tolist() == expected


@given(N=cells, a=integers.filter(bool))
def test_the_ring_is_f_circulant_with_f_minus_a(N, a):
    # S = ring + I shifts the ring by one cell, and by -a where it closes: once around is S^{2N} = -a I (exact integers)
    S = ring(N, 1, a).astype(int) + np.eye(2 * N, dtype=int)
    assert np.array_equal(np.linalg.matrix_power(S.astype(object), 2 * N), -a * np.eye(2 * N, dtype=int))


def is_circulant(matrix):
    return all(np.array_equal(row, np.roll(matrix[0], i)) for i, row in enumerate(matrix))


# the paper calls the matrix circulant; it is for a = -1 only, which is k = 0
@given(N=cells, a=integers)
def test_the_ring_is_circulant_without_damping_only(N, a):
    assert is_circulant(ring(N, 2, a)) is (a == -1)


# a = 0 cuts the ring: 2N cells in a row, (M + s I)/s is the nilpotent shift, one Jordan block of size 2N
@pytest.mark.slow
@given(N=cells, rate=st.integers(1, 9))
def test_for_the_matched_rod_the_ring_is_one_jordan_block(N, rate):
    shift = (ring(N, rate, 0).astype(int) + rate * np.eye(2 * N, dtype=int)).astype(object)
    last = np.linalg.matrix_power(shift, 2 * N - 1)
    assert last[-1, 0] == rate ** (2 * N - 1)
    assert np.count_nonzero(last) == 1
    assert not np.any(last @ shift)


@given(N=cells)
def test_the_orderings_are_permutations_that_leave_each_wave_in_order(N):
    for ordering in ORDERINGS:
        permutation = ordering_permutation(N, ordering)
        assert sorted(permutation) == list(range(2 * N + 1))
        waves = permutation[permutation < 2 * N]
        assert waves.tolist() == list(range(2 * N))
    # z comes last in (39) and after the ring in (42), between the waves in (48)
    place = [ordering_permutation(N, ordering).tolist().index(2 * N) for ordering in ORDERINGS]
    assert place == [2 * N, 2 * N, N]


def test_an_unknown_ordering_is_refused_with_the_three_there_are():
    with pytest.raises(InputError, match=r"^ordering is 'eq40'; give one of eq39, eq42, eq48$"):
        ordering_permutation(3, "eq40")


# "almost a bi-diagonal lower matrix (excepting 2 elements a_{1,2N} and a_{2N+1,N})"
@given(N=st.integers(2, 40))
def test_the_matrix_in_the_ordering_39_is_bidiagonal_but_for_the_two_entries_the_paper_names(N):
    scheme = upwind(paper_rod(), N)
    A, s, a = scheme.A.toarray(), scheme.rate, scheme.rod.reflection
    inside = np.tril(np.triu(A, -1))
    others = {(int(i) + 1, int(j) + 1): float(A[i, j]) for i, j in np.argwhere(A - inside)}
    assert others == {(1, 2 * N): -s * a, (2 * N + 1, N): 1.0}
    # and the template [s, -s] holds in the rows 2..2N, which leaves rows 1 and 2N + 1
    assert np.diag(A).tolist() == [-s] * (2 * N) + [0.0]
    assert np.diag(A, -1).tolist() == [s] * (2 * N - 1) + [0.0]


# (49): z' = [1 -d 0] [y_N, p, y_{N+2}], y_{N+2}' = [s -2sd -s 0 0] [y_N, p, y_{N+2}, y_{N+3}, y_{N+4}], with mu = -p
@given(N=st.integers(2, 40))
def test_the_matrix_in_the_ordering_48_has_the_rows_of_49(N):
    scheme = upwind(paper_rod(), N, ordering="eq48")
    A, s, d = scheme.A.toarray(), scheme.rate, scheme.rod.mobility
    z, after = N, N + 1  # y_{N+1} and y_{N+2}, counted from zero
    assert {int(j): float(A[z, j]) for j in np.flatnonzero(A[z])} == {N - 1: 1.0}
    assert {int(j): float(A[after, j]) for j in np.flatnonzero(A[after])} == {N - 1: s, after: -s}
    assert {int(i): float(-scheme.b1[i]) for i in np.flatnonzero(scheme.b1)} == {z: -d, after: -2 * s * d}
    assert np.flatnonzero(scheme.c).tolist() == [z]


@given(N=cells)
def test_the_orderings_give_one_system_with_its_states_renamed(N):
    reference = upwind(paper_rod(), N)
    for ordering in ORDERINGS:
        scheme = upwind(paper_rod(), N, ordering=ordering)
        P = np.eye(2 * N + 1)[scheme.permutation]  # y_ordering = P y_39
        assert np.array_equal(scheme.A.toarray(), P @ reference.A.toarray() @ P.T)
        for name in ("b1", "b2", "c"):
            assert np.array_equal(getattr(scheme, name), P @ getattr(reference, name))


def test_the_ordering_changes_neither_the_response_nor_the_spectrum():
    s = np.array([1j, 200j, 3e4j, 1e3 + 2e4j])
    blocks = [upwind(paper_rod("0.3"), 6, ordering=ordering).block for ordering in ORDERINGS]
    for block in blocks[1:]:
        assert np.allclose(block.transfer(s), blocks[0].transfer(s), rtol=1e-12, atol=0)
        spectra = [np.sort_complex(np.linalg.eigvals(each.dense())) for each in (block, blocks[0])]
        assert np.allclose(*spectra, rtol=1e-9, atol=1e-6)
