"""The weak form: matrices by hand, projections, rigid motions in closed form, energy and momentum."""

import math

import numpy as np
import pytest
import sympy as sp
from depth import rarely
from hypothesis import given
from hypothesis import strategies as st

from lure import AssumptionError, Expression, InputError
from lure.rod import Rod, Scenario
from lure.rod.derivation import rod as variation
from lure.rod.derivation import vocabulary
from lure.rod.galerkin import GalerkinModel, NonuniformRod, galerkin
from lure.rod.galerkin.model import Equations

SPACES = [("P1", 7), ("P2", 7), ("cosine", 6)]
# c = 2, Z = 1, T = 3/2
UNITS = {"youngs_modulus": 4, "density": 1, "length": 3, "area": 0.5, "compliance": 0.25, "gap": 0.1}
PLAIN = {"length": 1, "area": 1, "youngs_modulus": 1, "density": 1, "damping": 0, "compliance": 1}


def formula(text):
    return Expression.parse(text, variables=("x",))


def dense(matrix):
    return matrix.toarray()


# ---- matrices


def test_p1_matrices_of_two_elements():
    # h = 3/2, rho A = 1/2, A E = 2: element mass rho A h/6 [[2, 1], [1, 2]], element stiffness A E/h [[1, -1], [-1, 1]]
    model = galerkin(Rod(**UNITS, damping=0.3), space="P1", order=3)
    np.testing.assert_allclose(dense(model.mass), np.array([[2, 1, 0], [1, 4, 1], [0, 1, 2]]) / 8, atol=1e-15)
    stiffness = np.array([[1, -1, 0], [-1, 2, -1], [0, -1, 1]]) * 4 / 3
    np.testing.assert_allclose(dense(model.stiffness), stiffness, atol=1e-15)
    np.testing.assert_array_equal(dense(model.damping), np.diag([0.3, 0, 0]))


def test_p2_matrices_of_one_element():
    # textbook: M = rho A h/30 [[4, 2, -1], [2, 16, 2], [-1, 2, 4]],
    # K = A E/(3 h) [[7, -8, 1], [-8, 16, -8], [1, -8, 7]]
    model = galerkin(Rod(**UNITS, damping=0.3), space="P2", order=3)
    np.testing.assert_allclose(dense(model.mass), np.array([[4, 2, -1], [2, 16, 2], [-1, 2, 4]]) / 20, atol=1e-15)
    stiffness = np.array([[7, -8, 1], [-8, 16, -8], [1, -8, 7]]) * 2 / 9
    np.testing.assert_allclose(dense(model.stiffness), stiffness, atol=1e-14)


def test_cosine_matrices_of_the_uniform_rod_are_diagonal_but_for_the_dashpot():
    # int cos^2 = L/2 (L for the constant), int (j pi/L)^2 sin^2 = (j pi)^2/(2 L)
    model = galerkin(Rod(**UNITS, damping=0.3), space="cosine", order=4)
    np.testing.assert_allclose(dense(model.mass), np.diag([1.5, 0.75, 0.75, 0.75]), atol=1e-14)
    expected = np.diag((np.arange(4) * math.pi) ** 2 / 3)
    np.testing.assert_allclose(dense(model.stiffness), expected, atol=1e-12)
    assert model.mass.nnz == 4
    assert model.stiffness.nnz == 3
    np.testing.assert_allclose(dense(model.damping), np.full((4, 4), 0.3))


def test_coefficients_that_vary_are_integrated_exactly():
    # A = 1 + x, E = 2 - x, rho = x^2 + 1 on one P1 element of length 1: AE = 2 + x - x^2, rho A = (1 + x)(1 + x^2).
    # int AE = 2 + 1/2 - 1/3 = 13/6; int rho A x^2 = int (x^2 + x^3 + x^4 + x^5) = 1/3 + 1/4 + 1/5 + 1/6 = 57/60,
    # int rho A x = 1/2 + 1/3 + 1/4 + 1/5 = 77/60, int rho A = 25/12.
    rod = NonuniformRod.parse(**{**PLAIN, "area": "1 + x", "youngs_modulus": "2 - x", "density": "x**2 + 1"})
    model = galerkin(rod, space="P1", order=2)
    np.testing.assert_allclose(dense(model.stiffness), 13 / 6 * np.array([[1, -1], [-1, 1]]), rtol=1e-14)
    corner, mixed, total = 57 / 60, 77 / 60 - 57 / 60, 25 / 12
    expected = [[total - corner - 2 * mixed, mixed], [mixed, corner]]
    np.testing.assert_allclose(dense(model.mass), expected, rtol=1e-14)


def test_a_break_inside_an_element_leaves_the_integrals_exact():
    # AE = 1 up to 1/3, 4 beyond: 1/3 + 8/3 = 3.  Without the cut at 1/3 Gauss' 8 points give another number.
    rod = NonuniformRod.parse(**{**PLAIN, "youngs_modulus": "1 if x < 1/3 else 4"})
    assert dense(galerkin(rod, space="P1", order=2).stiffness)[0, 0] == pytest.approx(3, rel=1e-14)


@pytest.mark.parametrize(("space", "order"), SPACES)
def test_matrices_are_sparse_and_of_the_right_kind(space, order):
    rod = NonuniformRod.parse(**{**PLAIN, "area": "exp(x)", "youngs_modulus": "1 + x*x", "density": "2 + sin(9*x)"})
    model = galerkin(rod, space=space, order=order)
    mass, stiffness = dense(model.mass), dense(model.stiffness)
    assert np.linalg.eigvalsh(mass).min() > 0
    values, vectors = np.linalg.eigh(stiffness)
    assert abs(values[0]) < 1e-12 < values[1]  # its kernel are the constants
    np.testing.assert_allclose(model.space.values([0.2, 0.9]) @ vectors[:, 0], np.full(2, vectors[0, 0]), rtol=1e-10)
    np.testing.assert_array_equal(mass, mass.T)
    if space != "cosine":
        large = galerkin(rod, space=space, order=2001)
        assert large.mass.nnz < 5 * 2001


@pytest.mark.slow
def test_matrices_and_signs_are_those_of_the_derived_weak_form():
    # the weak form derived from Hamilton's principle, tested with the two hat functions of one element of length 1
    x, t, f = vocabulary.x, vocabulary.t, variation.f
    hats = [1 - x, x]
    a = [sp.Function(f"a{i}")(t) for i in range(2)]
    motion = sum(c * hat for c, hat in zip(a, hats, strict=True))
    weak = variation.weak_form()
    numbers = {vocabulary.E: 4, vocabulary.rho: 3, vocabulary.area: 0.5, vocabulary.k: 0.3}
    model = galerkin(
        Rod(youngs_modulus=4, density=3, length=1, area=0.5, damping=0.3, compliance=1), space="P1", order=2
    )
    for i, hat in enumerate(hats):
        interior = weak.interior.subs(variation.virtual, hat).subs(variation.u, motion).subs(f, 0).doit().subs(numbers)
        inside = sp.expand(sp.integrate(sp.expand(interior), (x, 0, 1)))
        ends = (weak.left.subs(variation.virtual_left, hat.subs(x, 0))).subs(numbers)
        ends += (weak.right.subs(variation.virtual_right, hat.subs(x, 1))).subs(numbers)
        for j in range(2):
            assert float(inside.coeff(a[j].diff(t, 2))) == pytest.approx(model.mass.toarray()[i, j], rel=1e-14)
            assert float(inside.coeff(a[j])) == pytest.approx(model.stiffness.toarray()[i, j], rel=1e-14)
        ends = sp.expand(ends)
        assert float(ends.coeff(variation.velocity_left)) == pytest.approx(model.damping.toarray()[i, i])
        assert float(ends.coeff(vocabulary.g)) == -model.space.left[i]
        assert float(ends.coeff(vocabulary.p)) == model.end_area * model.space.right[i]


# ---- projections (21), (22)


@pytest.mark.parametrize(("space", "order"), [("P1", 5), ("P2", 5)])
def test_the_projection_of_data_in_the_space_is_the_data(space, order):
    rod = NonuniformRod.parse(**{**PLAIN, "area": "1 + x", "density": "exp(x)"})
    model = galerkin(rod, space=space, order=order)
    u0, u1 = ("3 + x", "2*x - 1") if space == "P1" else ("3 + x - x*x", "x*x")
    nodes = np.linspace(0, 1, order)
    a, b = model.project(formula(u0), formula(u1))
    np.testing.assert_allclose(a, formula(u0)(x=nodes), rtol=1e-12)
    np.testing.assert_allclose(b, formula(u1)(x=nodes), atol=1e-12)


@pytest.mark.parametrize(("space", "order"), SPACES)
def test_projections_are_orthogonal_and_start_the_contact_coordinate_exactly(space, order):
    # with simpler weights the residuals against every w_j, computed by another quadrature, would not vanish
    rod = NonuniformRod.parse(**{**PLAIN, "area": "1 + x", "density": "exp(x)"})
    model = galerkin(rod, space=space, order=order)
    u0, u1 = formula("sin(5*x) + abs(x - 0.3)"), formula("1 if x < 0.7 else cos(x)")
    a, b = model.project(u0, u1)
    assert model.space.right @ a == pytest.approx(math.sin(5) + 0.7, rel=1e-12)
    n = 42_000  # midpoints; 0, 0.3, 0.7, 1 and all nodes are edges
    x = (np.arange(n) + 0.5) / n
    strain = (1 + x) * (5 * np.cos(5 * x) + np.sign(x - 0.3) - model.space.slopes(x) @ a)
    speed = (1 + x) * np.exp(x) * (np.where(x < 0.7, 1.0, np.cos(x)) - model.space.values(x) @ b)
    assert np.abs(model.space.slopes(x).T @ strain / n).max() < 2e-7
    assert np.abs(model.space.values(x).T @ speed / n).max() < 1e-8


# ---- rigid motions: V_1 = span{1}, a mass point of m_R = 3/2 kg


def rigid(damping=0.0, **changes):
    return galerkin(Rod(**{**UNITS, **changes}, damping=damping), space="cosine", order=1)


@pytest.mark.parametrize("compliance", [0.25, 1e-8])
def test_a_rigid_rod_stays_in_contact_half_a_period_of_mass_and_spring(compliance):
    # m_R z'' = -(A/eps) z: contact from gap/v on, for pi sqrt(m_R eps/A); it leaves with -v
    run = rigid(compliance=compliance).simulate(Scenario.parse(velocity=0.2), 8.0)
    start, stay = 0.5, math.pi * math.sqrt(1.5 * compliance / 0.5)
    (touch,) = run.contacts
    assert (touch.start, touch.end) == pytest.approx((start, start + stay), abs=1e-9)
    assert touch.end - touch.start == pytest.approx(stay, rel=1e-5)
    assert run.u_end[-1] == pytest.approx(0.1 - 0.2 * (8 - start - stay), abs=1e-8)
    assert run.impulse[-1] == pytest.approx(2 * 1.5 * 0.2, rel=1e-8)


def test_a_power_law_gives_back_the_speed_and_stays_as_long_as_hertz_says():
    # m_R z'' = -K z^(3/2), K = A c_n: t = 2 (5 m_R/(4 K))^(2/5) v^(-1/5) int_0^1 ds/sqrt(1 - s^(5/2)),
    # the integral being (2/5) B(2/5, 1/2) = sqrt(pi) Gamma(7/5)/Gamma(9/10)
    run = rigid(exponent=1.5).simulate(Scenario.parse(velocity=0.2), 8.0)
    integral = math.sqrt(math.pi) * math.gamma(1.4) / math.gamma(0.9)
    stay = 2 * (5 * 1.5 / (4 * 0.5 * 4)) ** 0.4 * 0.2**-0.2 * integral
    (touch,) = run.contacts
    assert touch.end - touch.start == pytest.approx(stay, rel=1e-7)
    assert run.velocities[-1, 0] == pytest.approx(-0.2, rel=1e-8)


def test_a_rigid_rod_on_its_dashpot_follows_the_exponential():
    # m_R v' = -k v + g: with the sign the paper prints in (10) it would run the other way
    run = rigid(damping=0.3, gap=100).simulate(Scenario.parse(force=0.6), 10.0)
    np.testing.assert_allclose(run.velocities[:, 0], 2 * (1 - np.exp(-run.t / 5)), atol=1e-9)


@pytest.mark.parametrize("excess", [1e-8, 1e-3])
def test_a_graze_far_shorter_than_a_step_is_found(excess):
    # thrown at the obstacle against f: z = excess - (t - 1)^2 until it is met, since 3 |f|/m_R = 2.  The spring only
    # shortens the stay.  Free motion is a polynomial here, and a step as long as the run would be accepted.
    run = rigid(gap=1 - excess).simulate(Scenario.parse(velocity=2, body_force=-1), 1.9)
    (touch,) = run.contacts
    assert touch.start == pytest.approx(1 - math.sqrt(excess), abs=1e-8)
    assert 1.0 < touch.end <= 1 + math.sqrt(excess) + 1e-8


def test_a_throw_that_stops_short_of_the_obstacle_touches_nothing():
    run = rigid(gap=1 + 1e-8).simulate(Scenario.parse(velocity=2, body_force=-1), 1.9)
    assert run.contacts == ()


def test_a_pre_loaded_rod_starts_in_contact():
    # m_R z'' = -(A/eps) z from rest at z = 0.2: released after a quarter of the period
    run = rigid(gap=-0.2).simulate(Scenario(), 5.0)
    assert [(hit.start, hit.end) for hit in run.contacts] == [
        (0.0, pytest.approx(0.5 * math.pi * math.sqrt(0.75), abs=1e-9))
    ]
    assert run.velocities[-1, 0] == pytest.approx(-0.2 / math.sqrt(0.75), rel=1e-8)


def test_contact_at_the_end_of_the_run_is_cut_there():
    (touch,) = rigid().simulate(Scenario.parse(velocity=0.2), 1.0).contacts
    assert touch.end == 1.0


# ---- balances


@pytest.mark.slow_for("Radau-cosine-6", "DOP853-P2-7")
@pytest.mark.parametrize(
    ("method", "space", "order"),
    rarely(
        [(method, *one) for method in ("DOP853", "Radau") for one in SPACES], ("Radau", "P1", 7), ("Radau", "P2", 7)
    ),
)
def test_energy_and_momentum_are_accounted_for(space, order, method):
    # tested with v = 1: (int rho A u_t)' = g - k u_t(0) - A p + int f; f = x t on (0, 1), g = sin t up to t = 1 only
    rod = NonuniformRod.parse(
        **{**PLAIN, "area": "1 + x", "density": "2 - x", "damping": 0.7, "compliance": 0.05, "gap": 0.1}
    )
    model = galerkin(rod, space=space, order=order)
    scenario = Scenario.parse(velocity=0.5, force="sin(t) if t < 1 else 0", body_force="x*t")
    tolerance = 1e-10 if method == "DOP853" else 1e-8
    run = model.simulate(scenario, 2.0, samples=41, tolerance=tolerance, method=method)
    assert run.contacts
    assert run.energy_residual < 100 * tolerance
    ones = np.eye(1, order)[0] if space == "cosine" else np.ones(order)
    momentum = run.velocities @ (model.mass @ ones)
    moved = (run.coefficients - run.coefficients[0]) @ model.space.left
    given = 1 - np.cos(np.minimum(run.t, 1)) + run.t**2 / 4
    np.testing.assert_allclose(momentum - momentum[0], given - 0.7 * moved - run.impulse, atol=300 * tolerance, rtol=0)


@pytest.mark.slow
def test_both_integrators_follow_one_motion():
    model = galerkin(Rod(**UNITS, damping=0.3), space="P1", order=9)
    scenario = Scenario.parse(velocity=0.4, force="sin(3*t)")
    explicit, implicit = (
        model.simulate(scenario, 3.0, tolerance=1e-9, method=method) for method in ("DOP853", "Radau")
    )
    np.testing.assert_allclose(explicit.states, implicit.states, atol=1e-7)
    assert len(explicit.contacts) == len(implicit.contacts) > 0


@pytest.mark.parametrize("touching", [False, True])
def test_the_matrix_of_the_implicit_method_is_the_derivative_of_the_rate(touching):
    model = galerkin(Rod(**UNITS, damping=0.3, exponent=1.5), space="P2", order=5)
    equations = Equations(model=model, scenario=Scenario.parse(force="1 + t", body_force="x"))
    y, span = np.sin(np.arange(15.0) ** 2) + 0.5, (0.0, 2.0)
    assert model.space.right @ y[:5] > model.rod.gap

    def rate(state):
        return equations.rate(0.7, state, touching=touching, span=span)

    steps = 1e-5 * np.eye(15)
    columns = [(rate(y + step) - rate(y - step)) / 2e-5 for step in steps]
    jacobian = equations.jacobian(0.7, y, touching=touching, span=span)
    np.testing.assert_allclose(jacobian, np.transpose(columns), atol=1e-7)


def test_a_load_is_read_on_its_own_side_of_a_break_and_the_break_ends_a_step():
    # read at the break itself, 3*t < 1 says False for the double next to 1/3 on either side
    model = rigid(gap=1e6)
    run = model.simulate(Scenario.parse(force="1e6 if 3*t < 1 else 0"), 1.0, samples=11)
    assert run.velocities[-1, 0] == pytest.approx(1e6 / 3 / 1.5, rel=1e-11)
    assert run.steps < 30


def test_samples_do_not_steer_the_motion():
    model = galerkin(Rod(**UNITS, damping=0.3), space="P2", order=9)
    few, many = (model.simulate(Scenario.parse(velocity=0.4), 3.0, samples=n) for n in (2, 1001))
    np.testing.assert_array_equal(few.states[-1], many.states[-1])
    assert few.contacts == many.contacts


@given(space=st.sampled_from(SPACES), seed=st.integers(0, 10_000))
def test_a_uniform_rod_is_the_nonuniform_one_with_constant_formulas(space, seed):
    rng = np.random.default_rng(seed)
    numbers = dict(zip(UNITS, rng.uniform(0.2, 3, len(UNITS)), strict=True))
    rod = Rod(**numbers, damping=1.0)
    formulas = {name: f"{float(numbers[name])!r} + 0*x" for name in ("area", "youngs_modulus")}
    other = NonuniformRod.parse(**{**numbers, **formulas}, damping=1.0)
    one, two = (galerkin(each, space=space[0], order=space[1]) for each in (rod, other))
    np.testing.assert_array_equal(dense(one.mass), dense(two.mass))
    np.testing.assert_array_equal(dense(one.stiffness), dense(two.stiffness))


def test_the_energy_is_that_of_the_rod():
    # v = 1, u_x = 1 - 2x/3 on (0, 3): A int (rho v^2 + E u_x^2)/2 dx + A P(z) = 0.25 (3 + 4) + 0.5 * 4 * 0.4^2/2
    model = galerkin(Rod(**UNITS, damping=0.3), space="P2", order=5)
    a, b = model.project(formula("x - x*x/3 + 1/2"), formula("1"))
    assert float(model.energy(a, b)) == pytest.approx(1.75 + 0.16, rel=1e-13)


# ---- refusals


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"area": "x"}, r"rod\.area is 0 at x = 0 m; give a formula that is positive on the whole rod"),
        ({"density": "1/(x - 1)"}, r"rod\.density is -1 at x = 0 m"),
        ({"youngs_modulus": "log(x)"}, r"rod\.youngs_modulus is -inf at x = 0 m"),
        ({"youngs_modulus": "y"}, r"rod\.youngs_modulus.*unknown name"),
        ({"length": -1}, r"rod\.length is -1; give a positive number"),
        ({"damping": math.nan}, r"rod\.damping is nan; give a finite number"),
        ({"compliance": 0}, r"rod\.compliance is 0; give a positive number"),
        ({"gap": math.inf}, r"rod\.gap is inf; give a finite number"),
    ],
)
def test_a_rod_that_is_none_is_refused(changes, message):
    with pytest.raises(InputError, match=message):
        NonuniformRod.parse(**{**PLAIN, **changes})


def test_a_law_that_is_not_lipschitz_is_refused():
    with pytest.raises(AssumptionError, match=r"for m = 0\.5; take m >= 1"):
        galerkin(Rod(**UNITS, damping=1, exponent=0.5), order=5)


@pytest.mark.parametrize(
    ("space", "order", "message"),
    [
        ("P3", 5, r"galerkin\.space is 'P3'; give one of P1, P2, cosine"),
        ("P1", 1, r"galerkin\.order is 1; give a whole number from 2 to 20000 for P1"),
        ("P2", 4, r"galerkin\.order is 4; give an odd number for P2"),
        ("cosine", 501, r"galerkin\.order is 501; .* from 1 to 500 for cosine"),
        ("P1", 2.5, r"galerkin\.order is 2\.5; give a whole number"),
        ("P1", True, r"galerkin\.order is True; give a whole number"),
    ],
)
def test_a_space_that_is_none_is_refused(space, order, message):
    with pytest.raises(InputError, match=message):
        galerkin(Rod(**UNITS, damping=1), space=space, order=order)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"until": 0}, r"galerkin\.until is 0; give a positive number of seconds"),
        ({"until": math.nan}, r"galerkin\.until is nan"),
        ({"until": 1e9}, r"galerkin\.until is 1e\+09 s, about .* steps of the explicit method, more than 100000"),
        ({"until": 1, "samples": 1}, r"galerkin\.samples is 1; give a whole number from 2"),
        ({"until": 1, "samples": 10**8}, r"galerkin\.samples is 100000000"),
        ({"until": 1, "tolerance": 0}, r"galerkin\.tolerance is 0; give a number from 1e-13 to 1e-3"),
        ({"until": 1, "method": "LSODA"}, r"galerkin\.method is 'LSODA'; give one of DOP853, Radau"),
    ],
)
def test_a_run_that_is_none_is_refused(settings, message):
    with pytest.raises(InputError, match=message):
        galerkin(Rod(**UNITS, damping=1), order=5).simulate(Scenario.parse(velocity=1), **settings)


def test_radau_is_refused_where_its_matrices_would_be_large():
    with pytest.raises(InputError, match=r"galerkin\.order is 301; Radau factorises dense matrices, give at most 300"):
        galerkin(Rod(**UNITS, damping=1), order=301).simulate(Scenario.parse(velocity=1), 1, method="Radau")


@pytest.mark.parametrize(
    ("loads", "message"),
    [
        ({"force": "1/(t - 0.25)"}, r"force\.g is inf at t = 0\.25 s"),
        ({"body_force": "log(x - 1)"}, r"force\.f is not finite at t = 0 s somewhere on the rod"),
        ({"displacement": "log(x - 1)"}, r"initial\.u0 is nan at x = 0\.0"),
        ({"displacement": "sqrt(x)*0 + 1/(x - 3)"}, r"initial\.u0 is -?inf at x = 3 m"),
        ({"displacement": "0 if x < 2 else 1e-3"}, r"initial\.u0 jumps by 0\.001 m at x = 2 m; .* continuous"),
        ({"velocity": "sqrt(x - 1)"}, r"initial\.u1 is nan at x = "),
    ],
)
def test_loads_and_data_that_are_not_finite_are_refused(loads, message):
    model = galerkin(Rod(**UNITS, damping=1), order=5)
    with pytest.raises(InputError, match=message):
        model.simulate(Scenario.parse(**loads), 1.0)


@pytest.mark.parametrize("method", ["DOP853", "Radau"])
def test_an_obstacle_that_doubles_cannot_follow_is_refused(method):
    with pytest.raises(InputError, match=r"galerkin\.until cannot be reached: after \d+ steps"):
        galerkin(Rod(**{**UNITS, "compliance": 1e-200}, damping=1), order=5).simulate(
            Scenario.parse(velocity=1), 1.0, method=method
        )


def test_a_model_is_built_without_scipy_until_it_is_asked_for_matrices():
    model = galerkin(Rod(**UNITS, damping=1), order=5)
    assert isinstance(model, GalerkinModel)
    assert "mass" not in vars(model)
