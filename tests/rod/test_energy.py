"""Energy of the scheme, its deflated coordinate, its Popov-Lyapunov function: identities, and signs along motions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from reference import decades, rods

from lure import AssumptionError
from lure.analysis.rod.energy import (
    deflated_coordinate,
    discrete_energy,
    energy_balance,
    energy_theta,
    lyapunov_function,
    split_state,
    zeta_weights,
)
from lure.rod import Rod, Scenario, initial_state, upwind
from lure.rod.discretisation import ORDERINGS

# c = 2, s = 2 N/3, Z = 1, d = 1/2
UNITS = {"youngs_modulus": 4, "density": 1, "length": 3, "area": 0.5, "compliance": 0.25, "exponent": 1.5, "gap": 0.1}


def states(scheme, seed, rows=1):
    """Random states with waves and penetration of the same size."""
    rng = np.random.default_rng(seed)
    waves, gap = rng.standard_normal((rows, 2 * scheme.cells)), rng.standard_normal((rows, 1))
    return np.hstack((waves, gap))[:, scheme.permutation]


def rate(scheme, y, force=0.0, body=None):
    """The right-hand side, from the matrices of the block."""
    waves = np.zeros(2 * scheme.cells) if body is None else body / (scheme.rod.density * scheme.rod.area)
    load = np.append(waves, 0.0)[scheme.permutation]
    stress = scheme.rod.nonlinearity(split_state(scheme, y)[1])
    return scheme.A @ y - scheme.b1 * stress + scheme.b2 * force + load


def derivative(function, y, direction):
    """Directional derivative by Richardson's extrapolation of central differences."""
    step = 1e-3 * np.abs(y).max() / np.abs(direction).max()
    coarse, fine = ((function(y + h * direction) - function(y - h * direction)) / (2 * h) for h in (step, step / 2))
    return float((4 * fine - coarse) / 3)


@pytest.mark.parametrize("ordering", ORDERINGS)
@pytest.mark.parametrize("form", ["corrected", "as-printed"])
@pytest.mark.parametrize("damping", [-0.4, 0.0, 0.3, 1.0, 7.0])
def test_energy_changes_by_supply_minus_dissipation(damping, form, ordering):
    scheme = upwind(Rod(**UNITS, damping=damping), 4, form=form, ordering=ordering)
    y = states(scheme, 1)[0]
    y[np.argmax(scheme.c)] = 0.7  # in contact
    force, body = 1.7, np.linspace(-1.0, 2.0, 8)
    dissipation, supply = energy_balance(scheme, y, force, body)
    change = derivative(lambda state: discrete_energy(scheme, state), y, rate(scheme, y, force, body))
    assert change == pytest.approx(float(supply - dissipation), rel=1e-8)


@given(rod=rods(), cells=st.integers(1, 30), seed=st.integers(0, 99))
def test_without_loads_and_with_a_dashpot_energy_only_falls(rod, cells, seed):
    dissipation, supply = energy_balance(upwind(rod, cells), states(upwind(rod, cells), seed))
    assert dissipation > 0
    assert supply == 0


def test_energy_is_that_of_the_rod_in_the_limit_of_fine_grids():
    # v = 1, u_x = x on (0, 3): A int (rho v^2 + E u_x^2)/2 dx + A P(z) = 0.25 (3 + 4 * 9) + 0.5 * 4 * 0.4^2.5/2.5.
    # A one-sided Riemann sum is off by 0.125 (h/2) [r1^2 - r2^2] from 0 to L, -0.125 * 12 h, and by O(h^2).
    rod, scenario = Rod(**UNITS, damping=0.3), Scenario.parse(displacement="x*x/2 - 4", velocity=1)
    schemes = [upwind(rod, cells) for cells in (1000, 2000)]
    coarse, fine = (float(discrete_energy(scheme, initial_state(scheme, scenario))) for scheme in schemes)
    exact = 9.75 + 0.8 * 0.4**2.5
    assert exact - coarse == pytest.approx(1.5 * 3 / 1000, rel=1e-2)
    assert 2 * fine - coarse == pytest.approx(exact, rel=1e-6)


@pytest.mark.parametrize("ordering", ORDERINGS)
@given(rod=rods(), cells=st.integers(1, 30))
def test_the_weights_of_zeta_are_a_left_null_vector(ordering, rod, cells):
    scheme = upwind(rod, cells, ordering=ordering)
    weights = zeta_weights(scheme)
    product, size = weights @ scheme.A.toarray(), np.abs(weights) @ np.abs(scheme.A.toarray())
    assert np.abs(product).max() <= 1e-12 * size.max()
    assert weights @ scheme.c == 1


@given(rod=rods(), cells=st.integers(1, 30))
def test_zeta_answers_to_contact_with_minus_the_residue_and_to_a_force_with_one_over_k(rod, cells):
    scheme = upwind(rod, cells)
    weights = zeta_weights(scheme)
    assert weights @ scheme.b1 == pytest.approx(rod.residue_at_zero, rel=1e-9)
    assert weights @ scheme.b2 == pytest.approx(1 / rod.damping, rel=1e-9)


@given(rod=rods(ratio=0.01) | rods(ratio=1.0) | rods(ratio=50.0), cells=st.integers(1, 12), seed=st.integers(0, 99))
def test_the_popov_lyapunov_function_falls_along_every_motion(rod, cells, seed):
    scheme = upwind(rod, cells)
    theta = energy_theta(scheme)
    y = states(scheme, seed)[0]
    y[-1] *= np.abs(zeta_weights(scheme)[:-1]).max()
    direction = rate(scheme, y)
    gradient = derivative(lambda state: lyapunov_function(scheme, state, theta), y, direction)
    size = np.abs(lyapunov_function(scheme, np.abs(y), theta)) * scheme.rate
    stress = float(rod.nonlinearity(y[-1]))
    assert gradient <= -2 * float(y[-1]) * stress + 1e-7 * size


@pytest.mark.parametrize("damping", [1e-4, 0.3, 1.0, 30.0, 1e5])
@pytest.mark.parametrize("cells", [1, 2, 9])
def test_theta_of_the_energy_is_the_least_that_makes_the_quadratic_form_nonnegative(damping, cells):
    # V' + 2 z p = -(theta/d) D - 2 (w.y) p is a quadratic form in (y, p), written out here with matrices
    rod = Rod(**UNITS, damping=damping)
    scheme, n = upwind(rod, cells), 2 * cells
    jumps = np.zeros((n + 1, n + 1))
    jumps[:n, :n] = np.eye(n, k=-1) - np.eye(n)
    jumps[0, n - 1] -= rod.reflection
    jumps[cells, n] = -2 * rod.mobility
    jumps[n, n - 1] = np.sqrt(1 - rod.reflection**2)
    inverse = np.linalg.inv(jumps)  # the form in terms of the jumps eta, in which D = |eta|^2/2
    alpha = np.append(zeta_weights(scheme)[:-1], 0.0) @ inverse
    beta = inverse[n]
    cross = np.outer(alpha, beta) + np.outer(beta, alpha)
    # V' + 2 z p = -eta^T (theta/(2d) I + cross) eta
    least = -2 * rod.mobility * np.linalg.eigvalsh(cross)[0]
    assert energy_theta(scheme) == pytest.approx(least, rel=1e-6)


def test_theta_of_the_energy_scales_with_time_and_shrinks_with_nothing_else():
    # theta is a time: halving the wave speed at the same impedances doubles it
    slow = Rod(**{**UNITS, "youngs_modulus": 2, "density": 2}, damping=0.3)
    fast = Rod(**UNITS, damping=0.3)
    assert energy_theta(upwind(slow, 5)) == pytest.approx(2 * energy_theta(upwind(fast, 5)), rel=1e-12)


@given(scale=decades(-3, 3))
def test_lyapunov_function_and_energy_are_linked_by_their_definition(scale):
    # V = (2 theta/A) E + zeta^2 k/A
    rod = Rod(**UNITS, damping=0.3)
    scheme = upwind(rod, 6)
    y, theta = scale * states(scheme, 3, rows=5), 1.25
    expected = 2 * theta / 0.5 * discrete_energy(scheme, y) + deflated_coordinate(scheme, y) ** 2 * 0.3 / 0.5
    assert lyapunov_function(scheme, y, theta) == pytest.approx(expected, rel=1e-12)


def test_no_dashpot_no_deflated_coordinate_and_a_driving_one_no_lyapunov_function():
    with pytest.raises(AssumptionError, match="needs k != 0; the damping is 0 N s/m"):
        zeta_weights(upwind(Rod(**UNITS, damping=0), 3))
    with pytest.raises(AssumptionError, match=r"needs k > 0; the damping is -0\.5 N s/m"):
        energy_theta(upwind(Rod(**UNITS, damping=-0.5), 3))
    with pytest.raises(AssumptionError, match="needs k > 0; the damping is 0 N s/m"):
        lyapunov_function(upwind(Rod(**UNITS, damping=0), 3), np.zeros(7), 1.0)
