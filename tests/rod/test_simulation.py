"""Event-exact motion of the scheme against closed forms and against another solver."""

from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from depth import rarely
from simulated import DRIVEN, FLYING, PAPER, reference, rod

from lure.analysis.rod.simulation import contradictions, simulate
from lure.rod import Rod, Scenario, upwind


def disagreement(run, scheme, scenario, stiff=False):
    """Largest difference of z from the reference, relative to the largest |z|."""
    return np.abs(run.z - reference(scheme, scenario, run.t, stiff)).max() / np.abs(run.z).max()


@pytest.mark.parametrize("cells", [1, 4, 50])
def test_a_single_mode_decays_as_its_eigenvalue_says(cells):
    # The real mode of the ring: y_i = q^-i with q = (-a)^(1/2N), eigenvalue s (q - 1).  On the grid r1 = e^{m x} and
    # r2 = e^{m (2L - x)}, m = -ln(q) N/L, which u1 = (r1 + r2)/2 and u0 = -(r1 + r2)/(2 c m) give; z' = y_N.
    its = rod(gap=100)
    scheme = upwind(its, cells)
    m = float(-np.log(-its.reflection) / 6)
    waves = f"(exp({m!r}*x) + exp({m!r}*(6 - x)))"
    scenario = Scenario.parse(displacement=f"-{waves}/(4*{m!r})", velocity=f"{waves}/2")
    run = simulate(scheme, scenario, until=9.0, samples=40)
    eigenvalue = scheme.rate * np.expm1(np.log(-its.reflection) / (2 * cells))
    moved = np.exp(3 * m) * np.expm1(eigenvalue * run.t) / eigenvalue
    assert run.z == pytest.approx(run.z[0] + moved, rel=1e-13)
    assert run.error_estimate < 1e-12 * np.abs(run.z).max()


def test_a_constant_force_ends_in_the_speed_g_over_k():
    run = simulate(upwind(rod(damping=2.0, gap=1e6), 5), Scenario.parse(force=0.6), until=400.0, samples=3)
    # z is about -1e6 m and known to some roundings of that, 1e-10 m each, in a difference of 60 m
    assert (run.z[2] - run.z[1]) / 200 == pytest.approx(0.6 / 2.0, rel=1e-10)
    assert run.lyapunov is None
    assert run.rest_position is None


@pytest.mark.parametrize("cells", [1, 10, 200])
def test_the_papers_rod_released_without_contact_comes_to_rest_at_zeta(cells):
    # u0 = e/2 - e x, so r1 = c e and r2 = -c e: zeta = z + (N/(s(1+a))) (c e + a c e) = z + L e = -0.0201 + 0.0002
    run = simulate(upwind(PAPER.rod, cells), PAPER.scenario, until=2.5e-3, samples=400)
    assert run.rest_position == pytest.approx(-0.0199, abs=1e-15)
    assert run.rest_is_final
    assert run.zeta == pytest.approx(np.full(400, -0.0199), abs=1e-15)
    assert not run.contact
    assert contradictions(run) == ()


def test_the_papers_rod_is_at_rest_there_after_eight_seconds():
    # its slowest mode decays at 1/s from half the swing, 1e-4 m
    run = simulate(upwind(PAPER.rod, 1), PAPER.scenario, until=8.0, samples=5)
    assert run.z[-1] == pytest.approx(-0.0199, abs=1.01e-4 * np.exp(-8))


@pytest.mark.slow
def test_a_rod_flying_at_the_obstacle_is_stopped_by_the_impulse_that_brings_zeta_to_zero():
    # zeta(0) = -gap + (N/s) v = -gap + T v = 1 for k = Z, v = 1; no rebound, so that the rod ends at z = 0 and the
    # obstacle has given A int p dt = k zeta(0) = 1 N s
    run = simulate(upwind(rod(damping=1.0, compliance=1e-3, gap=0.5), 100), Scenario.parse(velocity=1), until=20.0)
    (contact,) = run.contacts
    assert contact.impulse == pytest.approx(1.0, rel=1e-9)
    assert contact.start == pytest.approx(0.5, rel=1e-12)
    assert run.z[-1] == pytest.approx(0.0, abs=1e-12)
    assert contradictions(run) == ()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("damping", "exponent"),
    rarely(
        product((0.4, 3.0), (0.7, 1.0, 1.5, 2.0, 3.0)),
        *((0.4, 1.0), (0.4, 2.0), (0.4, 3.0), (3.0, 0.7), (3.0, 1.5), (3.0, 2.0)),
    ),
)
def test_contact_agrees_with_another_solver(exponent, damping):
    scheme = upwind(rod(exponent=exponent, damping=damping), 6)
    run = simulate(scheme, FLYING, until=6.0, samples=121)
    assert run.contact
    assert disagreement(run, scheme, FLYING) < 1e-9
    assert run.error_estimate < 1e-10
    assert run.energy_residual < 1e-10
    assert contradictions(run) == ()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("exponent", "loads"), rarely(product((1.0, 1.5), DRIVEN), *((1.5, name) for name in DRIVEN if name != "both"))
)
def test_loads_agree_with_another_solver(exponent, loads):
    scheme = upwind(rod(exponent=exponent), 5)
    scenario = Scenario.parse(displacement="0.1*cos(x)", velocity="0.3", **DRIVEN[loads])
    run = simulate(scheme, scenario, until=4.0, samples=81)
    assert disagreement(run, scheme, scenario) < 1e-8  # the reference steps over jumps and kinks
    assert run.energy_residual < 1e-10
    assert run.loaded


@pytest.mark.slow
@pytest.mark.parametrize(
    ("compliance", "exponent"),
    [(1e-4, 1.0), *(pytest.param(*one, marks=pytest.mark.thorough) for one in ((1e-8, 1.0), (1e-7, 1.5)))],
)
def test_contact_much_stiffer_than_the_rod_agrees_with_another_solver(compliance, exponent):
    scheme = upwind(rod(compliance=compliance, exponent=exponent), 3)
    run = simulate(scheme, FLYING, until=3.0, samples=31)
    assert run.contact
    assert disagreement(run, scheme, FLYING, stiff=True) < 1e-8
    assert run.energy_residual < 1e-10


def test_contact_a_billion_times_stiffer_than_the_papers_still_closes_the_energy_account():
    system = replace(PAPER, rod=Rod(**{**PAPER.rod.exact, "compliance": Fraction(1, 10**12), "gap": Fraction(0)}))
    run = simulate(upwind(system.rod, 10), system.scenario, until=5e-3)
    assert run.contact
    assert run.energy_residual < 1e-10
    assert contradictions(run) == ()


def test_without_a_dashpot_there_is_no_zeta_and_the_energy_still_never_rises():
    run = simulate(upwind(rod(damping=0), 5), FLYING, until=20.0)
    assert run.zeta is None
    assert run.rest_position is None
    assert run.energy_increase <= run.energy_allowance
    assert run.energy_residual < 1e-12
    assert contradictions(run) == ()
    assert contradictions(replace(run, energy_increase=1e-3)) != ()


def test_a_driving_dashpot_makes_the_motion_grow_until_the_run_stops_and_says_so():
    scheme = upwind(rod(damping=-0.4), 5)
    run = simulate(scheme, Scenario.parse(velocity=-1), until=1e4)  # away from the obstacle
    growth = scheme.eigenvalues().real.max()
    assert run.ended_early.startswith("the motion has grown beyond 1e30 times its start at ")
    assert run.t[-1] < np.log(1e32) / growth
    assert not run.contact
    assert np.log(np.abs(run.z[-1] / run.z[-2])) == pytest.approx(growth * run.t[1], rel=1e-6)
    assert contradictions(run) == ()  # growth is what was shown
    assert run.energy_increase is None


@pytest.mark.parametrize("cells", [1, 10, 300])
def test_the_matched_dashpot_is_no_special_case(cells):
    run = simulate(upwind(rod(damping=1), cells), FLYING, until=9.0)
    beside = simulate(upwind(rod(damping=1 + 1e-9), cells), FLYING, until=9.0)
    assert run.z == pytest.approx(beside.z, abs=1e-8)
    assert contradictions(run) == ()
