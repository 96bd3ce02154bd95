"""The replay of the paper's derivation: every step holds, and what is printed wrongly is seen to be wrong."""

import dataclasses
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from depth import sampled
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm
from sympy.calculus.euler import euler_equations

from lure.errors import InputError
from lure.rod import Rod
from lure.rod.derivation import (
    Misprint,
    Step,
    boundary_relations,
    characteristic_polynomial,
    conserved_mean,
    derivation,
    energy_identity,
    exact_transfer_function,
    hamilton,
    least_multiplier,
    misprints,
    popov_expression,
    popov_lyapunov,
    printed_input,
    residue_at_zero,
    rest_position,
    ring,
    rod_energy,
    stated_transfer_function,
    transfer_function,
    upwind_matrices,
    weak_form,
)
from lure.rod.derivation.rod import f, u
from lure.rod.derivation.scheme import modulus, phase
from lure.rod.derivation.vocabulary import (
    E,
    L,
    T,
    a,
    area,
    b,
    d,
    g,
    k,
    laplace,
    omega,
    p,
    residual,
    rho,
    s,
    t,
    theta,
    x,
)
from lure.rod.discretisation import upwind

Z = area * sp.sqrt(rho * E)
PAPER = {E: 288_000_000, rho: 8, area: sp.Rational(1, 40_000), k: sp.Rational(2, 10_000)}
FRACTIONS = st.fractions(Fraction(1, 9), 9, max_denominator=9)
REFLECTIONS = st.fractions(Fraction(-8, 9), Fraction(8, 9), max_denominator=9)


@pytest.fixture(scope="module")
def steps():
    return derivation(sampled(3, of=4))


@pytest.fixture(scope="module")
def table():
    return misprints()


def rational(value):
    return sp.Rational(value.numerator, value.denominator)


def altered(scheme, part, row, column, factor=-1):
    """The scheme with one entry multiplied by a factor."""
    matrix = sp.Matrix(getattr(scheme, part))
    matrix[row, column] *= factor
    return dataclasses.replace(scheme, **{part: sp.ImmutableMatrix(matrix)})


@pytest.mark.slow
def test_every_step_of_the_derivation_holds(steps):
    assert {step.title: step.residual for step in steps if not step.holds} == {}
    assert len({step.title for step in steps}) == len(steps) >= 25


@pytest.mark.slow
def test_the_steps_that_rest_on_misprints_do_not_hold_as_printed():
    failing = {step.title for step in derivation(1, form="as-printed") if not step.holds}
    assert failing == {
        "Euler-Lagrange equation, non-uniform rod",  # (1): E sigma^2 instead of sigma^2/E
        "Uniform rod with its natural boundary conditions",
        "Weak form",  # (10): + g
        "Boundary relations put into the upwind equations, N = 1..1",  # (36): 2 b g
        "Energy identity of the scheme, N = 1..1",
        "Conserved mean, N = 1..1",
    }


def test_a_step_prints_its_claim_and_what_remains_of_it():
    step = Step(title="Sum", statement="1 + 1 = 3", residual=residual(sp.Integer(1) + 1 - 3))
    assert not step.holds
    assert str(step) == "Sum: 1 + 1 = 3 [residual -1]"


def test_two_wrong_claims_in_one_step_do_not_cancel():
    assert residual(a, -a) != 0
    assert residual(sp.sin(a) ** 2 + sp.cos(a) ** 2 - 1, (a + 1) ** 2 - a**2 - 2 * a - 1) == 0


def test_the_equation_of_motion_is_the_one_sympy_derives_by_itself():
    lagrangian = rho * area * u.diff(t) ** 2 / 2 - area * E * u.diff(x) ** 2 / 2 + f * u
    (reference,) = euler_equations(lagrangian, u, [t, x])
    assert sp.expand(hamilton().equation + reference.lhs - reference.rhs) == 0


def test_the_printed_potential_energy_squares_the_modulus_in_the_wave_speed():
    # E_p = int A (E u_x)^2/2 gives rho u_tt = E^2 u_xx
    assert hamilton("as-printed").equation.coeff(u.diff(x, 2)) == -area * E**2
    assert hamilton().equation.coeff(u.diff(x, 2)) == -area * E


def test_the_boundary_conditions_have_the_signs_of_equation_8():
    motion = hamilton()
    at_left, at_right = sp.Symbol("u_x(t,0)", real=True), sp.Symbol("u_x(t,L)", real=True)
    # a push g > 0 at x = 0 compresses the end, so does contact at x = L; the dashpot pulls against the motion
    assert sp.solve(motion.left, at_left)[0].diff(g) == -1 / (area * E)
    assert sp.solve(motion.left, at_left)[0].diff(sp.Symbol("u_t(t,0)", real=True)) == k / (area * E)
    assert sp.solve(motion.right, at_right)[0].diff(p) == -1 / E


def test_with_the_printed_sign_of_the_force_the_weak_form_contradicts_equation_8():
    difference = sp.expand(weak_form("as-printed").left - weak_form().left)
    assert difference == 2 * g * sp.Symbol("v(0)", real=True)


def test_the_constants_of_the_boundary_relations_are_those_of_the_paper():
    # Z = 0.25e-4 sqrt(8 * 288e6) = 0.25e-4 * 48000 = 1.2; a = (2e-4 - 1.2)/(2e-4 + 1.2) = -1.1998/1.2002
    relations = boundary_relations()
    assert sp.nsimplify(relations.a.subs(PAPER)) == sp.Rational(-11998, 12002)
    assert sp.nsimplify(relations.b.subs(PAPER)) == sp.Rational(10_000, 12_002)
    assert sp.nsimplify(relations.d.subs(PAPER)) == sp.Rational(1, 48_000)


def test_a_force_of_the_wrong_sign_is_seen_in_the_boundary_relations():
    motion = hamilton()
    wrong = boundary_relations(dataclasses.replace(motion, left=motion.left.subs(g, -g)))
    assert sp.simplify(wrong.b + 1 / (k + Z)) == 0
    assert sp.simplify(wrong.a - boundary_relations().a) == 0


def test_the_matrices_for_two_cells_are_those_read_off_equation_36_by_hand():
    scheme = upwind_matrices(2)
    assert (
        sp.Matrix(
            [
                [-s, 0, 0, -s * a, 0],
                [s, -s, 0, 0, 0],
                [0, s, -s, 0, 0],
                [0, 0, s, -s, 0],
                [0, 1, 0, 0, 0],
            ]
        )
        == scheme.A
    )
    assert scheme.b1 == sp.Matrix([0, 0, 2 * s * d, 0, d])
    assert scheme.b2 == sp.Matrix([2 * s * b, 0, 0, 0, 0])
    assert scheme.c == sp.Matrix([0, 0, 0, 0, 1])
    assert [str(component) for component in scheme.state] == ["xi1^1", "xi1^2", "xi2^1", "xi2^0", "z"]


@pytest.mark.parametrize("form", ["corrected", "as-printed"])
@pytest.mark.parametrize("cells", [1, 2, 3, 4])
def test_the_numerical_scheme_has_the_derived_matrices(cells, form):
    # E = 4, rho = 1, A = 1/2: c = 2, Z = 1; k = 3: a = 1/2, b = 1/4; d = 1/2; L = 1: s = 2 N.  All exact in binary.
    rod = Rod(youngs_modulus=4, density=1, length=1, area=0.5, damping=3, compliance=1)
    numbers = {a: 0.5, b: 0.25, d: 0.5, s: 2 * cells}
    derived, built = upwind_matrices(cells, form=form), upwind(rod, cells, form=form)
    for name, matrix in (("A", built.A.toarray()), ("b1", built.b1), ("b2", built.b2), ("c", built.c)):
        expected = np.array(getattr(derived, name).subs(numbers), dtype=float)
        np.testing.assert_allclose(matrix.reshape(expected.shape), expected, rtol=1e-15, atol=0)


@pytest.mark.slow
@settings(max_examples=15)
@given(cells=st.integers(1, 5), reflection=REFLECTIONS, rate=FRACTIONS, point=FRACTIONS)
def test_the_closed_form_of_the_transfer_function_is_that_of_the_matrices(cells, reflection, rate, point):
    numbers = {a: rational(reflection), s: rational(rate), laplace: rational(point), d: sp.Rational(3, 7)}
    scheme = upwind_matrices(cells)
    resolved = sp.Matrix(laplace * sp.eye(2 * cells + 1) - scheme.A).subs(numbers).LUsolve(scheme.b1.subs(numbers))
    expected = (scheme.c.T * resolved)[0]
    assert stated_transfer_function(cells).subs(numbers) == expected


@pytest.mark.slow_for("A-None")
@pytest.mark.parametrize(("part", "column"), [("A", None), ("b1", 0)])
def test_no_sign_can_be_turned_in_the_ring_without_changing_the_transfer_function(part, column):
    scheme = upwind_matrices(2)
    matrix = getattr(scheme, part)
    columns = range(matrix.shape[1]) if column is None else [column]
    places = [(i, j) for i in range(5) for j in columns if matrix[i, j] != 0]
    assert len(places) == (9 if part == "A" else 2)
    for row, place in places:
        wrong = transfer_function(altered(scheme, part, row, place))
        assert sp.cancel(wrong - stated_transfer_function(2)) != 0


def test_the_printed_contact_input_turns_the_sign_of_the_transfer_function():
    scheme = dataclasses.replace(upwind_matrices(2), b1=printed_input(2))
    assert sp.cancel(transfer_function(scheme) + stated_transfer_function(2)) == 0
    assert energy_identity(scheme).residual != 0


@pytest.mark.parametrize("cells", [1, 2, 3])
def test_a_matched_dashpot_leaves_one_jordan_block(cells):
    # a = 0: the ring matrix plus s is s times a nilpotent shift, whose rank is 2N - 1: one block of size 2N
    matrix = ring(cells)[0].subs(a, 0) + s * sp.eye(2 * cells)
    assert matrix.rank() == 2 * cells - 1
    assert matrix ** (2 * cells) == sp.zeros(2 * cells)
    assert sp.expand(characteristic_polynomial(cells).subs(a, 0) - laplace * (laplace + s) ** (2 * cells)) == 0


@pytest.mark.parametrize("cells", [1, 2, 3])
def test_zero_is_double_without_dashpot_and_simple_with_it(cells):
    polynomial = sp.Poly(characteristic_polynomial(cells), laplace)
    assert polynomial.coeff_monomial(laplace) == sp.expand(s ** (2 * cells) * (1 + a))
    undamped = sp.Poly(polynomial.as_expr().subs(a, -1), laplace)
    assert undamped.coeff_monomial(laplace) == 0
    assert undamped.coeff_monomial(laplace**2) != 0


def test_the_residue_at_zero_is_the_area_over_the_damping():
    relations = boundary_relations()
    assert sp.simplify(residue_at_zero(3).subs({a: relations.a, d: relations.d}) - area / k) == 0


def test_the_transfer_function_tends_to_that_of_the_rod_like_one_over_the_number_of_cells():
    # ln q^{2N} + 2 s'T = (s'T)^2/N + ...: doubling N halves the difference
    numbers = {a: -0.5, d: 1.0, T: 1.0, laplace: 0.3 + 2.0j}
    limit = complex(exact_transfer_function().subs(numbers))
    errors = []
    for cells in (1000, 2000):
        delayed = a * (1 + laplace * T / cells) ** (-2 * cells)
        errors.append(abs(complex((d / laplace * (1 - delayed) / (1 + delayed)).subs(numbers)) - limit))
    assert errors[0] / errors[1] == pytest.approx(2, rel=0.01)


@pytest.mark.parametrize("cells", [1, 2, 3])
def test_the_energy_of_the_free_scheme_falls_by_the_jumps_and_the_reflection(cells):
    rate = energy_identity(cells).rate.subs(g, 0)
    # minus half the jumps minus (1 - a^2)/2 y_{2N}^2: a quadratic form in the waves and p, of one sign iff |a| <= 1
    fall = sp.hessian(-rate, (*upwind_matrices(cells).state[:-1], p)).subs(d, 1)
    assert fall.subs(a, sp.Rational(1, 2)).is_positive_definite
    assert fall.subs(a, -1).is_positive_semidefinite
    assert not fall.subs(a, -2).is_positive_semidefinite


def test_no_sign_can_be_turned_in_the_scheme_without_breaking_the_energy_identity():
    scheme = upwind_matrices(2)
    for part in ("A", "b1", "b2"):
        matrix = getattr(scheme, part)
        for row in range(matrix.shape[0]):
            for column in range(matrix.shape[1]):
                if matrix[row, column] != 0:
                    assert energy_identity(altered(scheme, part, row, column)).residual != 0, (part, row, column)


@pytest.mark.slow_for("popov_lyapunov")
@pytest.mark.parametrize("balance", [energy_identity, conserved_mean, popov_lyapunov])
def test_a_contact_law_of_the_wrong_strength_breaks_each_balance(balance):
    scheme = upwind_matrices(2)
    assert balance(scheme).residual == 0
    assert balance(altered(scheme, "b1", 2, 0, factor=sp.Rational(1, 2))).residual != 0


def test_the_conserved_mean_is_the_left_null_vector_of_the_matrix():
    scheme = upwind_matrices(3)
    gradient = sp.Matrix([conserved_mean(3).function.diff(component) for component in scheme.state])
    assert sp.simplify(gradient.T * scheme.A) == sp.zeros(1, 7)
    assert sp.simplify((gradient.T * scheme.b1)[0] - residue_at_zero(3)) == 0


def test_the_free_scheme_comes_to_rest_where_the_mean_says():
    # independent of sympy: exp(t A) y(0) for c = L = 1, k = Z/3 (a = -1/2), N = 40
    cells = 40
    relations = {a: -0.5, b: 0.75, d: 1.0, s: float(cells)}
    A = np.diag(np.r_[np.full(2 * cells, -40.0), 0.0]) + np.diag(np.r_[np.full(2 * cells - 1, 40.0), 0.0], -1)
    A[0, 2 * cells - 1], A[-1, cells - 1] = 20.0, 1.0
    start = np.sin(np.arange(2 * cells + 1.0))
    mean = start[-1] + (start[:cells].sum() + 0.5 * start[cells:-1].sum()) / (40 * 0.5)
    assert (expm(200.0 * A) @ start)[-1] == pytest.approx(mean, rel=1e-9)
    small = conserved_mean(2)
    values = dict(zip(upwind_matrices(2).state, (1, 2, 3, 4, 5), strict=True)) | relations
    # z + (y1 + y2 + (y3 + y4)/2)/(40 * 1/2) = 5 + (3 + 3.5)/20
    assert float(small.function.subs(values)) == pytest.approx(5 + 6.5 / 20)


def test_the_printed_rod_comes_to_rest_at_plus_half_the_compression():
    # released at rest, u0 = e/2 - e x: u_rest = u0(0) = +e/2, whereas the paper names u0(1) = -e/2 as stationary
    at_rest = rest_position().subs(sp.Symbol("int(u1)", real=True), 0)
    assert at_rest == sp.Symbol("u0(0)", real=True)


def test_the_energy_of_the_rod_balances_only_with_the_right_sign_of_the_force():
    balance = rod_energy()
    assert balance.residual == 0
    assert dataclasses.replace(balance, rate=balance.rate.subs(g, -g)).residual != 0


@given(
    reflection=st.floats(-0.99, 0.99),
    radius=st.floats(0.01, 1),
    angle=st.floats(-7, 7),
    frequency=st.floats(0.01, 100),
    multiplier=st.floats(-5, 5),
)
def test_the_closed_popov_expression_is_the_real_part(reflection, radius, angle, frequency, multiplier):
    numbers = {a: reflection, modulus: radius, phase: angle, omega: frequency, theta: multiplier, d: 1.0}
    delayed = reflection * radius * np.exp(-1j * angle)
    direct = ((1 + 1j * frequency * multiplier) / (1j * frequency) * (1 - delayed) / (1 + delayed)).real
    scale = (1 / frequency + abs(multiplier)) / abs(1 + delayed) ** 2
    assert float(popov_expression().closed.subs(numbers)) == pytest.approx(direct, abs=1e-13 * scale)


def test_a_wrong_sign_in_the_popov_expression_is_seen():
    expression = popov_expression()
    assert expression.residual == 0
    assert dataclasses.replace(expression, closed=expression.closed.subs(phase, -phase)).residual != 0


def test_the_least_multiplier_is_sharp_at_low_frequency():
    # a = -1/2, T = 1: theta = 4 (1/2)/(1 - 1/4) = 8/3
    critical = least_multiplier().subs({a: sp.Rational(-1, 2), T: 1})
    assert critical == sp.Rational(8, 3)
    rod = popov_expression().closed.subs({modulus: 1, phase: 2 * omega, a: sp.Rational(-1, 2), d: 1})
    values = [float(rod.subs({omega: 1e-3, theta: factor * critical})) for factor in (0.999, 1.001)]
    assert values[0] < 0 < values[1]


@pytest.mark.slow
def test_no_row_of_the_misprint_table_vanishes(table):
    assert all(isinstance(row, Misprint) for row in table)
    assert [row.where for row in table if row.difference == 0] == []
    assert all(row.explanation.endswith(".") for row in table)


@pytest.mark.parametrize(
    ("where", "difference"),
    [
        ("(1)", "A*E*u_x**2*(E - 1)/2"),
        ("(10), (20)", "2*g*v(0)"),
        ("(11)", "2*v(0)*Integral(g(y), (y, 0, t))"),
        ("(14), force", "2*g*w1(0)"),
        ("(36) row 1, (38) b2, (47) I_1", "-2*b*g*(s - 1)"),
        ("(38) b1, row N+1", "4*d*p*s"),
        ("(38) b1, row 2N+1", "2*d*p"),
        ("(37) xi1^N", "2*d*p(z(0))"),
        ("(37) xi2^0", "(a - 1)*(c*u0_x(0) - u1(0))/a"),
        ("(43)", "p*(d + 1)"),
        ("end of section 4.2, 'circulant'", "s*(a + 1)"),
        ("(50)", "1"),
        ("(50), gap", "1"),
    ],
)
def test_a_misprint_is_off_by_what_was_found_by_hand(table, where, difference):
    (row,) = [row for row in table if row.where == where]
    assert str(row.difference) == difference


def test_without_its_dot_the_bound_of_lemma_3_2_would_forbid_a_rod_to_rest_elsewhere(table):
    (row,) = [row for row in table if row.where == "end of the proof of Lemma 3.2, first integral"]
    (motion,) = row.printed.atoms(sp.Function)
    place = sp.Symbol("C")
    assert row.printed.subs(motion, place).doit() == place**2 * L  # with E_m = 0
    assert row.corrected.subs(motion, place).doit() == 0
    assert row.corrected.subs(motion, t).doit() == L  # u = t: twice the kinetic energy L/2


def test_the_cnn_matrix_is_circulant_only_without_dashpot(table):
    (row,) = [row for row in table if "circulant" in row.where]
    assert sp.solve(row.difference.subs(a, boundary_relations().a), k) == [0]
    matrix, shift = ring(2)
    ordinary, twisted = shift.subs(sp.Symbol("f", real=True), 1), shift.subs(sp.Symbol("f", real=True), -a)
    assert matrix * twisted - twisted * matrix == sp.zeros(4)
    commutator = matrix * ordinary - ordinary * matrix
    assert commutator.subs(a, -1) == sp.zeros(4)
    assert {sp.factor(entry) for entry in commutator} - {0} == {s * (a + 1), -s * (a + 1)}


def test_the_corrected_displacement_starts_where_figure_6_does(table):
    (row,) = [row for row in table if row.where == "(50)"]
    at_tip = {x: 1, sp.Symbol("e", real=True): 2e-4}
    assert float(row.corrected.subs(at_tip)) == pytest.approx(-1e-4)
    assert float(row.printed.subs(at_tip)) == pytest.approx(0.9999)


def test_correcting_displacement_and_gap_together_leaves_the_gap_coordinate_alone(table):
    displacement, gap = (next(row for row in table if row.where == where) for where in ("(50)", "(50), gap"))
    z_printed, z_corrected = displacement.printed - gap.printed, displacement.corrected - gap.corrected
    assert sp.expand(z_printed - z_corrected) == 0


def test_the_stationary_solution_differs_by_the_stretch_of_the_rod(table):
    (row,) = [row for row in table if row.where == "below (28)"]
    ends = sp.Symbol("u0(L)", real=True) - sp.Symbol("u0(0)", real=True)
    assert sp.expand(row.difference.subs(sp.Symbol("int(u1)", real=True), 0) - ends) == 0


def test_a_misprint_prints_as_one_sentence_with_its_reason(table):
    assert str(table[0]).startswith("(1): printed A*E**2*u_x**2/2, correct A*E*u_x**2/2. A sigma^2/2")


@pytest.mark.parametrize("cells", [0, -1, 13, 2.0, "3", True, None])
def test_a_number_of_cells_out_of_range_is_refused(cells):
    with pytest.raises(InputError, match=r"cells is .*; the symbolic derivation takes an integer from 1 to 12"):
        derivation(cells)


@pytest.mark.parametrize("function", [derivation, upwind_matrices])
def test_an_unknown_form_is_refused(function):
    with pytest.raises(InputError, match="form is 'printed'; choose 'corrected' or 'as-printed'"):
        function(1, form="printed")


def test_importing_lure_does_not_import_the_derivation():
    script = "import sys, lure; sys.exit(any(name.startswith('lure.rod.derivation') for name in sys.modules))"
    assert subprocess.run([sys.executable, "-c", script], cwd=Path(__file__).parents[2], check=False).returncode == 0
