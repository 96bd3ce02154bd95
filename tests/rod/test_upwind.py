"""The matrices of the scheme, its closed-form transfer function and its spectrum, each computed
again."""

import math
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from flint import acb, fmpq, fmpq_mat, fmpq_poly
from hypothesis import assume, given
from hypothesis import strategies as st
from reference import (
    Exact,
    at_high_precision,
    decades,
    point,
    ratios,
    real,
    real_part_error,
    relative_error,
    rods,
    with_damping,
)

from lure import InputError
from lure.rod import RodPlant, UpwindScheme, upwind
from lure.rod.cellular.gallery import rod_template
from lure.rod.cellular.network import interconnection
from lure.rod.systems import paper_rod, rod_from_exact

EPS = 2.0**-52
angles = st.floats(-math.pi, math.pi)
cells = st.integers(1, 1000)
DAMPINGS = ["1e-6", "2e-4", "0.6", "1.1999", "1.3", "30", "1200"]


def spectrum(matrix):
    return np.sort_complex(np.linalg.eigvals(matrix))


def test_the_scheme_with_one_cell_by_hand():
    # N = 1, s = 6000, a = (0.3 - 1.2)/1.5 = -0.6, b = 1/1.5, d = 1/48000; y = [xi1^1, xi2^0, z]
    scheme = upwind(paper_rod("0.3"), 1)
    assert scheme.rate == 6000.0
    assert np.allclose(scheme.A.toarray(), [[-6000, 3600, 0], [6000, -6000, 0], [1, 0, 0]], rtol=1e-15)
    assert np.allclose(scheme.b1, [0, 2 * 6000 / 48000, 1 / 48000], rtol=1e-15)
    assert np.allclose(scheme.b2, [2 * 6000 / 1.5, 0, 0], rtol=1e-15)
    assert scheme.c.tolist() == [0, 0, 1]


# (36), written out cell by cell for a state, a stress and a force of no special form
@pytest.mark.parametrize("N", [2, 3, 7])
def test_the_matrices_are_the_equations_of_the_corrected_36(N):
    rod = paper_rod("0.3")
    scheme = upwind(rod, N)
    y, p, g, s = np.cos(np.arange(2 * N + 1.0)), 0.7, 2.5, scheme.rate
    xi1, xi2 = y[:N], y[N : 2 * N][::-1]  # xi1[i-1] = xi1^i, xi2[i] = xi2^i
    expected = np.empty(2 * N + 1)
    for i in range(1, N + 1):
        upstream = -rod.reflection * xi2[0] + 2 * rod.input_gain * g if i == 1 else xi1[i - 2]
        expected[i - 1] = s * (upstream - xi1[i - 1])
    for i in range(N):
        upstream = xi1[N - 1] - 2 * rod.mobility * p if i == N - 1 else xi2[i + 1]
        expected[2 * N - 1 - i] = s * (upstream - xi2[i])
    expected[-1] = xi1[N - 1] - rod.mobility * p
    assert np.allclose(scheme.A @ y - scheme.b1 * p + scheme.b2 * g, expected, rtol=1e-12)


@given(N=st.integers(1, 50), ratio=st.sampled_from([0.01, 0.5, 1.0, 2.0, 100.0]))
def test_a_steady_force_ends_at_the_speed_the_dashpot_allows(N, ratio):
    # free flight under g: r1 = r2 = v everywhere and k v = g at the dashpot; the printed b2 misses the factor s
    rod = with_damping(paper_rod(), Fraction(ratio) * Fraction(6, 5))
    for form, speed in (("corrected", 1 / rod.damping), ("as-printed", rod.length / (6000 * N) / rod.damping)):
        scheme = upwind(rod, N, form=form)
        waves = np.linalg.solve(scheme.A.toarray()[:-1, :-1], -scheme.b2[:-1])
        assert np.allclose(waves, speed, rtol=1e-9)


def test_the_printed_form_differs_in_the_force_alone():
    corrected, printed = (upwind(paper_rod(), 10, form=form) for form in ("corrected", "as-printed"))
    assert printed.b2[0] == pytest.approx(2 / 1.2002, rel=1e-15)
    assert np.array_equal(corrected.b2, corrected.rate * printed.b2)
    for name in ("b1", "c"):
        assert np.array_equal(getattr(corrected, name), getattr(printed, name))
    assert (corrected.A != printed.A).nnz == 0


@given(rod=rods(), N=st.integers(1, 8), ordering=st.sampled_from(["eq39", "eq42", "eq48"]), turns=decades(-3, 1))
def test_the_closed_form_is_the_resolvent_of_the_matrices(rod, N, ordering, turns):
    scheme = upwind(rod, N, ordering=ordering)
    for s in (1j * turns / rod.travel_time, (0.3 - 1j) * turns / rod.travel_time):
        x = np.linalg.solve(s * np.eye(scheme.order) - scheme.A.toarray(), scheme.b1)
        allowed = 1e-13 * scheme.order * at_high_precision(lambda s: Exact(rod).sensitivity(s, N), s)
        # sigma = z comes after a cancellation of the waves (up to s d) when a is near 1
        allowed += 1e-13 * scheme.order * abs(rod.mobility / s / scheme.transfer(s))
        assert scheme.c @ x == pytest.approx(scheme.transfer(s), rel=allowed)
        assert scheme.block.transfer(s) == pytest.approx(scheme.transfer(s), rel=allowed)


@given(rod=rods(ratio=1.0), ratio=decades(-2, 2), N=st.integers(1, 6))
def test_the_closed_form_is_the_response_of_python_control(rod, ratio, N):
    scheme = upwind(with_damping(rod, Fraction(ratio * rod.impedance)), N)
    omega = np.array([0.01, 0.3, 1.0, 2.5, 9.0]) / rod.travel_time
    response = np.ravel(scheme.frequency_response(omega).frdata)
    assert np.allclose(response, scheme.transfer(1j * omega), rtol=1e-9, atol=0)
    assert scheme.to_control().nstates == 2 * N + 1


# what is reached: see tests/rod/test_waves.py
@given(rod=rods(), N=cells, size=decades(-12, 2), angle=st.one_of(st.just(math.pi / 2), angles))
def test_the_closed_form_is_right_to_what_its_inputs_allow(rod, N, size, angle):
    s = complex(size * math.cos(angle), size * math.sin(angle)) / rod.travel_time
    assume(rod.reflection != 0 or s.real >= 0)
    # near the circle |1 + s/rate| = 1 of the left half-plane log|q| is a small difference: N roundings of its own
    crossing = N if s.real < 0 else 0

    def compare():
        exact = Exact(rod)
        turn = abs(complex(exact.a * exact.ring(s, N)))
        extra = crossing * (1 + 2 * turn / abs(1 - turn * turn)) if turn != 1 else math.inf
        error = relative_error(upwind(rod, N).transfer(s), exact.transfer(s, N))
        return error, exact.sensitivity(s, N) + extra

    error, sensitivity = at_high_precision(compare)
    assert error <= 8 * EPS * sensitivity


@given(rod=rods(), N=cells, turns=decades(-200, -2))
def test_near_zero_the_closed_form_keeps_all_its_digits(rod, N, turns):
    s = 1j * turns / rod.travel_time
    assume(abs(s) > 1e-200)
    error = at_high_precision(
        lambda: relative_error(upwind(rod, N).transfer(s), Exact(rod).transfer(s, N)),
    )
    assert error <= 16 * EPS


@given(rod=rods(), N=cells, turns=decades(-100, -2))
def test_near_zero_the_real_part_keeps_its_digits_beside_an_imaginary_part_of_any_size(rod, N, turns):
    assume(rod.reflection != 0)
    s = 1j * turns / rod.travel_time
    error = at_high_precision(lambda: real_part_error(upwind(rod, N).transfer(s), Exact(rod).transfer(s, N)))
    assert error <= 16 * EPS


@given(rod=rods(), N=cells, size=decades(-6, 2), angle=angles)
def test_conjugate_points_give_conjugate_values(rod, N, size, angle):
    s, scheme = complex(size * math.cos(angle), size * math.sin(angle)) / rod.travel_time, upwind(rod, N)
    assert scheme.transfer(np.conj(s)) == np.conj(scheme.transfer(s))


@given(rod=rods(), N=cells, turns=decades(-6, 2), factor=decades(-3, 3))
def test_a_longer_rod_is_a_slower_one(rod, N, turns, factor):
    longer = rod_from_exact({**rod.exact, "length": rod.exact["length"] * Fraction(factor)})
    s = (1 + 1j) * turns / rod.travel_time
    assert upwind(longer, N).transfer(s / factor) == pytest.approx(factor * upwind(rod, N).transfer(s), rel=1e-10)


@given(rod=rods(), N=cells, size=decades(-3, 2), angle=st.floats(-math.pi / 2, math.pi / 2))
def test_the_scheme_takes_up_energy_at_every_complex_frequency(rod, N, size, angle):
    s = complex(size * math.cos(angle), size * math.sin(angle)) / rod.travel_time
    mobility = s * upwind(rod, N).transfer(s)
    assert mobility.real >= -1e-12 * abs(mobility)


@given(rod=rods(), N=cells)
def test_the_residue_at_zero_is_the_area_over_the_damping_for_every_number_of_cells(rod, N):
    ratio = rod.damping / rod.impedance
    s = 1e-10 / (ratio + 1 / ratio) / rod.travel_time
    assert s * upwind(rod, N).transfer(s) == pytest.approx(rod.residue_at_zero, rel=1e-9)


# q^{2N} = exp(-2N ln(1 + x/N)) = Q (1 + x^2/N + ..), x = s T, Q = e^{-2x};
# and the derivative of (1 - aQ)/(1 + aQ) with respect to Q is -2a/(1 + aQ)^2
@pytest.mark.parametrize("damping", ["2e-4", "0.6", "5"])
def test_the_scheme_tends_to_the_rod_at_first_order_with_the_constant_of_the_expansion(damping):
    rod = paper_rod(damping)
    x = np.array([0.3j, 0.2 + 1j, 2.0])
    s, a, Q = x / rod.travel_time, rod.reflection, np.exp(-2 * x)
    limit = rod.mobility / s * -2 * a * Q / (1 + a * Q) ** 2 * x**2
    errors = [N * (upwind(rod, N).transfer(s) - RodPlant(rod).transfer(s)) / limit - 1 for N in (1000, 2000, 4000)]
    assert np.max(np.abs(errors[0])) < 1e-2
    for coarse, fine in pairwise(errors):
        assert np.allclose(np.abs(fine / coarse), 0.5, rtol=1e-2)


@given(rod=rods(ratio=1.0), N=cells, size=decades(-6, 4), angle=angles)
def test_the_matched_scheme_is_an_integrator(rod, N, size, angle):
    s = complex(size * math.cos(angle), size * math.sin(angle)) / rod.travel_time
    scheme = upwind(rod, N)
    for where in (s, -scheme.rate):
        assert scheme.transfer(where) == pytest.approx(rod.mobility / where, rel=4 * EPS)


def test_nothing_overflows_however_far_from_the_origin():
    scheme = upwind(paper_rod(), 3)
    s = np.array([1e200, 1e200j, -1e200, 1e-300, -scheme.rate])
    # 1/s beyond the rate; at -rate q is infinite and H = -d/s
    expected = scheme.rod.mobility / s * [1, 1, 1, scheme.rod.residue_at_zero / scheme.rod.mobility, -1]
    assert np.allclose(scheme.transfer(s), expected, rtol=1e-12, atol=0)


# the characteristic polynomial x ((x + s)^{2N} + a s^{2N}), in rational arithmetic from the templates
@pytest.mark.parametrize("N", [1, 2, 3, 4])
@pytest.mark.parametrize("a", [Fraction(-3, 5), Fraction(0), Fraction(1, 3), Fraction(-1), Fraction(7, 2)])
def test_the_characteristic_polynomial_is_that_of_the_f_circulant_ring(N, a):
    s = Fraction(7, 3)
    ring, cells = np.zeros((2 * N, 2 * N), dtype=object), np.arange(2 * N)
    template = rod_template(s, a)
    for (offset,), weight in zip(template.offsets, template.weights, strict=True):
        ring[cells, (cells + offset) % (2 * N)] += weight(cells) if callable(weight) else weight
    assembled = interconnection(rod_template(float(s), float(a)), (2 * N,), "periodic").toarray()[:, :-1]
    assert np.allclose(ring.astype(float), assembled, rtol=1e-15, atol=0)
    matrix = fmpq_mat([[fmpq(Fraction(v).numerator, Fraction(v).denominator) for v in row] for row in ring])
    rate, f = fmpq(s.numerator, s.denominator), fmpq(a.numerator, a.denominator)
    assert matrix.charpoly() == fmpq_poly([rate, 1]) ** (2 * N) + fmpq_poly([f * rate ** (2 * N)])


@pytest.mark.parametrize("N", [1, 2, 3])
@pytest.mark.parametrize("damping", ["2e-4", "0.3", "5", "-0.3", "-7"])
def test_the_eigenvalues_are_the_roots_of_the_characteristic_polynomial(N, damping):
    scheme = upwind(paper_rod(damping), N)
    polynomial = np.poly1d([1, 1]) ** (2 * N) + scheme.rod.reflection
    roots = np.sort_complex(np.roots(polynomial.coeffs))
    assert np.allclose(np.sort_complex(scheme.eigenvalues() / scheme.rate), roots, rtol=1e-9, atol=1e-10)


# away from k = Z; near it the solver is the one that is wrong
@pytest.mark.parametrize("damping", ["2e-4", "0.1", "30", "1200", "-0.1", "0"])
def test_the_eigenvalues_of_ten_cells_are_those_of_a_solver(damping):
    scheme = upwind(paper_rod(damping), 10)
    expected = np.sort_complex(np.append(scheme.eigenvalues(), 0.0))
    assert np.allclose(spectrum(scheme.A.toarray()), expected, rtol=0, atol=1e-9 * scheme.rate)


def test_a_solver_is_lost_at_the_jordan_block_of_the_matched_rod():
    # 20 cells in a row: an entry rounded by eps moves the eigenvalues by rate * eps^(1/20) = 0.16 rate
    scheme = upwind(paper_rod("1.2"), 10)
    assert np.all(scheme.eigenvalues() == -scheme.rate)
    disturbed = scheme.A.toarray()
    disturbed[0, 19] = scheme.rate * EPS
    found = np.linalg.eigvals(disturbed)
    assert np.max(np.abs(found + scheme.rate)) > 0.1 * scheme.rate


def characteristic(scheme):
    """Relative residual of the eigenvalues in ``(1 + lambda/s)^{2N} = -a``, in 300-bit balls."""
    exact = Exact(scheme.rod)
    rate = exact.c * scheme.cells / real(scheme.rod.exact["length"])
    values = scheme.eigenvalues()
    for value in (values[0], values[scheme.cells // 2], values[scheme.cells - 1], values[-1]):
        root = (1 + point(value) / rate) ** (2 * scheme.cells)
        yield float(abs(root / -exact.a - 1))


@given(rod=rods(), N=cells)
def test_the_eigenvalues_satisfy_their_equation_for_every_number_of_cells(rod, N):
    assume(abs(rod.reflection) > 1e-9)
    # a rounding of an eigenvalue x costs 2N roundings of the power of 1 + x/s, which has size r = |a|^{1/2N}:
    # |x|/s <= 1 + r, hence (1 + r)/r roundings of 1 + x/s itself
    spread = 1 + abs(rod.reflection) ** (-1 / (2 * N))
    assert max(at_high_precision(lambda: list(characteristic(upwind(rod, N))))) < 8 * spread * (2 * N + 1) * EPS


@given(rod=rods(ratio=1.0), ratio=decades(-6, -1), N=cells)
def test_the_slow_eigenvalue_keeps_its_digits(rod, ratio, N):
    # s (|a|^{1/2N} - 1) is about -2 (k/Z)/(2T): small against s by a factor (k/Z)/N
    scheme = upwind(with_damping(rod, Fraction(ratio * rod.impedance)), N)

    def exact_value():
        exact = Exact(scheme.rod)
        rate = exact.c * N / real(scheme.rod.exact["length"])
        return rate * (((-exact.a).log() / (2 * N)).exp() - 1)

    slow = scheme.eigenvalues()[N - 1]
    assert slow.imag == 0
    assert at_high_precision(lambda: relative_error(slow, acb(exact_value()))) < 16 * EPS


# (x + s)^{2N} + a s^{2N}: sum of the eigenvalues -2Ns, product s^{2N} (1 + a), sum of the inverses -2N/(s(1 + a))
@given(rod=rods(ratio=1.0), ratio=ratios(), N=cells)
def test_the_eigenvalues_have_the_sums_and_the_product_of_their_polynomial(rod, ratio, N):
    scheme = upwind(with_damping(rod, Fraction(ratio * rod.impedance)), N)
    values, a = scheme.eigenvalues() / scheme.rate, scheme.rod.reflection
    one_plus = 2 * scheme.rod.damping * scheme.rod.input_gain
    assert len(values) == 2 * N
    assert np.sum(values) == pytest.approx(-2 * N, rel=1e-12)
    assert np.sum(np.log(np.abs(values))) == pytest.approx(math.log(one_plus), rel=1e-9, abs=1e-9)
    assert np.sum(1 / values) == pytest.approx(-2 * N / one_plus, rel=1e-9)
    assert np.all(np.abs(1 + values) == pytest.approx(abs(a) ** (1 / (2 * N)), rel=1e-12))


@given(N=cells, damping=st.sampled_from([*DAMPINGS, "0", "-0.3", "-7"]))
def test_the_eigenvalues_come_in_conjugate_pairs_in_order_of_frequency(N, damping):
    scheme = upwind(paper_rod(damping), N)
    values = scheme.eigenvalues()
    assert np.array_equal(np.sort_complex(values), np.sort_complex(np.conj(values)))
    # angles rise from -pi to pi; on the circle about -rate that is the order
    assert np.all(np.diff(np.angle(values / scheme.rate + 1)) > 0)


def test_for_positive_damping_all_waves_decay_and_without_damping_one_does_not():
    for N in (1, 2, 17, 1000):
        for damping in DAMPINGS:
            assert np.max(upwind(paper_rod(damping), N).eigenvalues().real) < 0
        undamped = upwind(paper_rod("0"), N).eigenvalues()
        assert np.count_nonzero(undamped == 0) == 1
        assert np.max(upwind(paper_rod("-0.3"), N).eigenvalues().real) > 0


def test_the_single_wave_eigenvalues_are_those_of_the_list():
    scheme = upwind(paper_rod(), 6)
    assert np.array_equal(scheme.wave_eigenvalues(np.arange(-5, 7)), scheme.eigenvalues())
    assert scheme.wave_eigenvalues(2).shape == ()


@pytest.mark.parametrize(
    ("cells", "message"),
    [
        (0, "is 0; give a whole number from 1 to 10000000"),
        (-1, "is -1; give a whole number from 1 to 10000000"),
        (True, "is True; give a whole number"),
        (2.5, r"is 2\.5; give a whole number"),
        (10.0, r"is 10\.0; give a whole number"),
        (float("nan"), "is nan; give a whole number"),
        ("10", "is '10'; give a whole number"),
        (None, "is None; give a whole number"),
        (10**9, r"is 1000000000 \(it would need about 100 GB for its matrices\); give a whole number"),
        pytest.param(10**5000, "has more than 18 digits; give a whole number", id="10^5000"),
        pytest.param(-(10**5000), "has more than 18 digits; give a whole number", id="-10^5000"),
    ],
)
def test_a_number_of_cells_out_of_range_is_refused(cells, message):
    for build in (upwind, UpwindScheme):
        with pytest.raises(InputError, match=rf"^discretisation\.cells {message}"):
            build(paper_rod(), cells)


def test_cells_may_be_a_numpy_integer_and_up_to_ten_million():
    assert upwind(paper_rod(), np.int32(7)).cells == 7
    scheme = upwind(paper_rod(), 10_000_000)
    assert np.isfinite(scheme.transfer(1j))


def test_an_unknown_form_or_ordering_is_refused_with_those_there_are():
    with pytest.raises(InputError, match=r"^discretisation\.form is 'printed'; give one of corrected, as-printed$"):
        upwind(paper_rod(), 3, form="printed")
    with pytest.raises(InputError, match=r"^ordering is '39'; give one of eq39, eq42, eq48$"):
        upwind(paper_rod(), 3, ordering="39")
