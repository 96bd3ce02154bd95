"""Orders of convergence in H1 x L2, from both sides, and agreement with the exact motion and with the scheme."""

import functools
import math

import numpy as np
import pytest
import sympy as sp
from depth import rarely

from lure import Expression, InputError
from lure.analysis.rod.simulation import simulate
from lure.rod import Rod, Scenario, builtin_system, exact_motion, upwind
from lure.rod.galerkin import KnownState, NonuniformRod, convergence, exact_state, formula_state, galerkin, state_error

# c = 2, Z = 1, T = 3/2
ROD = Rod(youngs_modulus=4, density=1, length=3, area=0.5, damping=0.3, compliance=0.25, gap=5)
FAMILIES = {"P1": (33, 65, 129), "P2": (33, 65, 129), "cosine": (16, 32, 64)}
SHORT = {"P1": (9, 17, 33), "P2": (9, 17, 33), "cosine": (12, 24, 48)}
# H1 and, for the velocity, L2: k and k + 1 for elements of degree k.  The slope of cosines is zero at both ends and
# that of the rod is not: their coefficients fall like j^-2, so that the slope is off by m^-1/2.  The velocity inherits
# the error of the trace at the dashpot, m^-1.
ORDERS = {"P1": (1, 2), "P2": (2, 3), "cosine": (0.5, 1)}
x, t = sp.symbols("x t", real=True)


def text(expression):
    return str(sp.nsimplify(expression)).replace("E", "e")


def manufactured(motion, area, modulus, density, damping):
    """Loads and data under which ``motion`` solves the equations, whatever it does at x = 1."""
    flux = area * modulus * motion.diff(x)
    return Scenario.parse(
        force=text((damping * motion.diff(t) - flux).subs(x, 0)),
        body_force=text(density * area * motion.diff(t, 2) - flux.diff(x)),
        displacement=text(motion.subs(t, 0)),
        velocity=text(motion.diff(t).subs(t, 0)),
    )


def tapered(gap, compliance=1.0):
    area, modulus, density = (1 + x / 2) ** 2, 1 + x * x, 2 - x
    rod = NonuniformRod.parse(
        length=1,
        area=text(area),
        youngs_modulus=text(modulus),
        density=text(density),
        damping=0.75,
        compliance=compliance,
        gap=gap,
    )
    return rod, (area, modulus, density, sp.Rational(3, 4))


def family(rod, space, orders):
    return [galerkin(rod, space=space, order=order) for order in orders[space]]


def assert_orders(result, space):
    h1, l2 = ORDERS[space]
    assert result.h1_orders == pytest.approx(np.full(2, h1), abs=0.1)
    assert result.l2_orders == pytest.approx(np.full(2, l2), abs=0.25)
    assert result.h1_orders[-1] == pytest.approx(h1, abs=0.06)
    assert result.l2_orders[-1] == pytest.approx(l2, abs=0.16)


@functools.cache
def smooth_flight():
    """Smooth data, released: the end stays free, the wave has met the dashpot by 0.9 s and both ends by 1.95 s."""
    scenario = Scenario.parse(displacement="(x*(3 - x))**4/25")
    return scenario, exact_motion(ROD, scenario, 5.0)


@pytest.mark.slow
@pytest.mark.parametrize("space", rarely(FAMILIES, "P2"))
def test_the_order_against_the_exact_motion(space):
    scenario, motion = smooth_flight()
    result = convergence(family(ROD, space, FAMILIES), scenario, exact_state(motion, 0.9), until=0.9)
    assert_orders(result, space)


@pytest.mark.slow_for("cosine", "P1", "P2")
@pytest.mark.parametrize("space", FAMILIES)
def test_the_order_for_a_rod_whose_coefficients_vary(space):
    # u_x(t, 1) = 0 and u < gap: free.  u_x(t, 0) and the loads do not vanish.
    motion = sp.sin(2 * t + 1) * sp.cos(x - 1)
    rod, coefficients = tapered(gap=2)
    scenario = manufactured(motion, *coefficients)
    known = formula_state(Expression.parse(text(motion), variables=("t", "x")), 0.8, 1.0)
    assert_orders(convergence(family(rod, space, SHORT), scenario, known, until=0.8), space)


@pytest.mark.slow
@pytest.mark.parametrize("space", rarely(FAMILIES, "cosine", "P2"))
def test_the_order_for_a_rod_that_stays_in_contact(space):
    # u = gap + S cos x, S > 0: E(1) u_x = -2 S sin 1 must be -(1/eps) S cos 1, so eps = cot(1)/2
    motion = sp.Rational(1, 5) + (1 + sp.sin(2 * t + 1) / 3) * sp.cos(x)
    rod, coefficients = tapered(gap=0.2, compliance=0.5 / math.tan(1))
    scenario = manufactured(motion, *coefficients)
    known = formula_state(Expression.parse(text(motion), variables=("t", "x")), 0.8, 1.0)
    models = family(rod, space, SHORT)
    assert_orders(convergence(models, scenario, known, until=0.8), space)
    (touch,) = models[0].simulate(scenario, 0.8).contacts
    assert (touch.start, touch.end) == (0.0, 0.8)


def test_without_a_dashpot_one_cosine_moves_alone_and_exactly():
    # u = cos(pi x/3) cos(2 pi t/3) is the first elastic mode of the free-free rod
    rod = Rod(**{**{name: float(value) for name, value in ROD.exact.items()}, "damping": 0})
    model = galerkin(rod, space="cosine", order=5)
    run = model.simulate(Scenario.parse(displacement="cos(pi*x/3)"), 4.0)
    np.testing.assert_allclose(run.u_end, -np.cos(2 * math.pi * run.t / 3), atol=1e-8)
    np.testing.assert_allclose(run.coefficients[:, [0, 2, 3, 4]], 0, atol=1e-9)


def test_a_layered_rod_is_exact_if_a_node_falls_on_the_interface():
    # E = 1 | 2, u = S(t) phi(x) with E phi' = 1 - x: phi is quadratic on each side, hence in P2 for an even number of
    # elements; f = S'' phi + S.  With an odd number the kink lies inside an element.
    phi = "where(x < 1/2, x - x*x/2, 3/16 + x/2 - x*x/4)"
    rod = NonuniformRod.parse(
        length=1, area=1, youngs_modulus="where(x < 1/2, 1, 2)", density=1, damping=0.5, compliance=1, gap=2
    )
    scenario = Scenario.parse(displacement=phi, force="-cos(t)", body_force=f"cos(t)*(1 - {phi})")
    motion = Expression.parse(f"cos(t)*{phi}", variables=("t", "x"))
    known = formula_state(motion, 1.0, 1.0)
    errors = []
    for order in (5, 7):
        model = galerkin(rod, space="P2", order=order)
        run = model.simulate(scenario, 1.0, samples=2)
        errors.append(state_error(model, run.coefficients[-1], run.velocities[-1], known))
    assert errors[0].h1 < 1e-8
    assert errors[0].l2 < 1e-8
    assert errors[1].h1 > 1e-2


@pytest.mark.slow
@pytest.mark.parametrize(("space", "low", "high"), [("P1", 0.2, 0.5), ("cosine", 0.4, 0.6)])
def test_behind_a_kink_the_order_drops_to_what_it_is(space, low, high):
    # the paper's rod, released: u_x jumps at both ends at t = 0 and the jumps travel; no space bends to them
    system = builtin_system("paper-rod")
    until = 0.4 * system.rod.travel_time
    known = exact_state(exact_motion(system.rod, system.scenario, 5 * system.rod.travel_time), until)
    result = convergence(family(system.rod, space, FAMILIES), system.scenario, known, until=until)
    assert low < result.h1_orders.mean() < high


@pytest.mark.slow
def test_the_end_of_the_rod_converges_to_the_exact_motion():
    scenario, motion = smooth_flight()
    misses = []
    for order in (65, 129):
        run = galerkin(ROD, space="P2", order=order).simulate(scenario, 3.0, samples=61)
        misses.append(np.abs(run.u_end - motion.end_displacement(run.t)).max())
    assert misses[1] < 2e-5  # of a motion of size 1
    assert misses[0] / misses[1] > 8


@pytest.mark.slow
def test_scheme_and_galerkin_have_one_limit_in_flight_and_through_a_contact():
    # the upwind scheme is of first order: its distance halves with its cells
    rod = Rod(youngs_modulus=1, density=1, length=1, area=1, damping=0.3, compliance=0.05, gap=0.03)
    scenario = Scenario.parse(displacement="8*(x*(1 - x))**4", force="sin(t)**4/2")
    run = galerkin(rod, space="P2", order=121).simulate(scenario, 1.4, samples=141)
    early = run.t < 0.3
    flight, contact, touched = [], [], []
    for cells in (100, 200, 400, 800):
        scheme = simulate(upwind(rod, cells), scenario, until=1.4, samples=141)
        apart = np.abs(scheme.u_end - run.u_end)
        flight.append(apart[early].max())
        contact.append(apart.max())
        touched.append([(touch.start, touch.end) for touch in scheme.contacts])
    assert len(run.contacts) == 1
    assert np.log2(np.divide(flight[:-1], flight[1:]))[-1] == pytest.approx(1, abs=0.1)
    assert np.log2(np.divide(contact[:-1], contact[1:]))[-1] == pytest.approx(1, abs=0.15)
    (touch,) = run.contacts
    extrapolated = 2 * np.array(touched[-1]) - np.array(touched[-2])
    np.testing.assert_allclose(extrapolated, [(touch.start, touch.end)], atol=2e-3)


@pytest.mark.slow
def test_contact_begins_when_the_exact_motion_reaches_the_obstacle():
    scenario, motion = smooth_flight()
    rod = Rod(**{**{name: float(value) for name, value in ROD.exact.items()}, "gap": 0.5})
    touch, *_ = galerkin(rod, space="P2", order=129).simulate(scenario, 1.5).contacts
    assert float(motion.end_displacement(touch.start)) == pytest.approx(0.5, abs=1e-5)
    assert motion.end_displacement(np.linspace(0, touch.start - 1e-4, 999)).max() < 0.5


@pytest.mark.slow
def test_p1_p2_and_cosines_have_one_limit_through_contact():
    rod = Rod(youngs_modulus=1, density=1, length=1, area=1, damping=0.3, compliance=0.05, gap=0.03)
    scenario = Scenario.parse(displacement="8*(x*(1 - x))**4")
    ends = [
        galerkin(rod, space=space, order=order).simulate(scenario, 1.4, samples=29).u_end
        for space, order in (("P2", 121), ("P1", 161), ("cosine", 120))
    ]
    size = np.abs(ends[0]).max()
    assert np.abs(ends[1] - ends[0]).max() < 5e-3 * size
    assert np.abs(ends[2] - ends[0]).max() < 2e-2 * size


def test_the_distance_in_numbers():
    # from rest at 0 on (0, 3): int (2x)^2 dx = 36 and 6^2/3 = 12; int 2^2 dx = 12
    known = KnownState(slope=lambda x: 2 * x, velocity=lambda x: 2 + 0 * x, end=6.0)
    error = state_error(galerkin(ROD, order=3), np.zeros(3), np.zeros(3), known)
    assert (error.h1, error.l2) == pytest.approx((math.sqrt(48), math.sqrt(12)), rel=1e-14)


def test_a_family_that_does_not_grow_is_refused():
    scenario, motion = smooth_flight()
    models = [galerkin(ROD, order=order) for order in (9, 9)]
    with pytest.raises(InputError, match=r"give at least two spaces, each finer than the one before"):
        convergence(models, scenario, exact_state(motion, 0.9), until=0.9)
