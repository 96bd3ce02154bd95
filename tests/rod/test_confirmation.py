"""The functionals of the rod along its exact motion: zeta, energy, the Popov-Lyapunov functional."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from motions import NODES, WEIGHTS, other_rod, unit_rod

from lure.analysis.rod.confirmation import Track, lyapunov_theta, rod_energy, rod_lyapunov, rod_zeta
from lure.analysis.rod.confirmation.functionals import lyapunov_weights, track_z, zeta_gain
from lure.analysis.rod.confirmation.rod_side import balance
from lure.analysis.rod.energy import deflated_coordinate
from lure.errors import AssumptionError
from lure.rod import Scenario, upwind
from lure.rod.motion import exact_motion, motion_windows
from lure.rod.scenario import initial_state

DATA = Scenario.parse(displacement="0.05*x - 0.03*x**2", velocity="0.3*sin(3*x) + 0.2")


def track_of(rod, scenario, trips):
    """Whole round trips, the last of the stream left out because it is cut off."""
    windows = motion_windows(rod, scenario, (trips + 0.25) * 2 * rod.travel_time)
    return Track(rod=rod, scenario=scenario, windows=tuple(windows)[:trips])


def fields_at(motion, t, weigh):
    """``int_0^L weigh(x, v, w) dx`` from the fields, by Gauss panels between the kinks of the waves."""
    edges = motion.fields.breaks(t / motion.rod.travel_time)
    half = np.diff(edges)[:, None] / 2
    x = edges[:-1, None] + half * (NODES + 1)
    v, w = motion.velocity(np.full(x.shape, t), x), motion.strain(np.full(x.shape, t), x)
    return float((weigh(x, v, w) * half * WEIGHTS).sum())


# zeta = u(t, 0) - gap + (rho A/k) int v dx, with u(t, 0) = u(t, L) - int w dx: the other form of its docstring, from
# the fields along the rod instead of the waves at its end.
@pytest.mark.parametrize("damping", [0.05, 0.3, 1.0, 3.0])
def test_zeta_is_the_place_of_the_dashpot_plus_momentum_over_k(damping):
    rod = other_rod(damping=damping, gap=0.05)
    track = track_of(rod, DATA, 6)
    motion = exact_motion(rod, DATA, track.reached)
    t = np.array([0.0, 0.3, 0.9, 1.4, 3.1, 7.77, 11.2])
    expected = [
        motion.z(s) - fields_at(motion, s, lambda x, v, w: w) + 0.5 / damping * fields_at(motion, s, lambda x, v, w: v)
        for s in t
    ]
    assert rod_zeta(track, t) == pytest.approx(expected, abs=1e-13 / min(damping, 1))
    assert motion.impacts


def test_zeta_is_constant_in_free_flight_and_not_in_contact():
    free, touching = (
        rod_zeta(track_of(other_rod(gap=gap, damping=0.3), DATA, 40), np.linspace(0, 80, 999)) for gap in (10.0, 0.05)
    )
    assert np.abs(free - free[0]).max() < 1e-12 * abs(free[0])
    assert touching[0] - touching[-1] > 0.1


@pytest.mark.parametrize("compliance", [10.0, 0.2, 1e-4])
@pytest.mark.parametrize("damping", [0.05, 0.3, 1.0, 3.0])
def test_zeta_falls_by_the_impulse_over_k_in_each_contact(damping, compliance):
    rod = other_rod(damping=damping, compliance=compliance, gap=0.05)
    track = track_of(rod, DATA, 10)
    motion = exact_motion(rod, DATA, track.reached)
    assert motion.impacts
    for impact in motion.impacts:
        before, after = rod_zeta(track, [impact.start, impact.end])
        # rho_0 int p dt = (A/k) int p dt: the impulse is A int p dt
        assert before - after == pytest.approx(impact.impulse / damping, abs=1e-12)
        assert impact.impulse > 1e-5


# Riemann sums over cells of length h at their right (forward wave) or left (backward wave) end are off by h/2 times the
# difference of the ends: order 1 in h, so that halving h halves the error.
def test_zeta_of_the_scheme_tends_to_that_of_the_rod_at_first_order():
    rod = other_rod(damping=0.3, gap=0.05)
    exact = float(rod_zeta(track_of(rod, DATA, 1), [0.0])[0])
    errors = []
    for cells in (50, 100, 200, 400):
        scheme = upwind(rod, cells)
        errors.append(float(deflated_coordinate(scheme, initial_state(scheme, DATA))) - exact)
    assert np.array(errors[:-1]) / np.array(errors[1:]) == pytest.approx([2, 2, 2], rel=0.01)
    assert abs(errors[-1]) > 1e-6


@pytest.mark.parametrize(("damping", "exponent"), [(0.0, 1), (0.3, 1), (1.0, 1), (-0.2, 1), (0.3, 1.5)])
def test_the_energy_is_that_of_the_fields_and_changes_by_what_the_dashpot_takes(damping, exponent):
    rod = other_rod(damping=damping, gap=0.05, exponent=exponent)
    track = track_of(rod, DATA, 8)
    motion = exact_motion(rod, DATA, track.reached)
    t = np.linspace(0, track.reached, 33)
    energy = rod_energy(track, t)
    assert energy == pytest.approx([motion.energy(s) for s in t], rel=2e-12)
    # E' = -k v(t, 0)^2, by Gauss between the kinks of the wave that reaches the dashpot, T after they left x = L
    edges = {s for s in t}
    for window in motion.fields.windows:
        edges |= {2 * window.number + edge + lag for edge in window.edges for lag in (-1, 0, 1)}
    edges = np.array(sorted(edge for edge in edges if 0 <= edge <= track.reached))
    half = np.diff(edges)[:, None] / 2
    velocity = motion.dashpot_velocity(edges[:-1, None] + half * (NODES + 1))
    lost = damping * float((velocity**2 * half * WEIGHTS).sum())
    assert energy[0] - energy[-1] == pytest.approx(lost, rel=1e-9, abs=1e-12 * energy[0])


def test_the_multiplier_has_its_closed_form():
    for damping, expected in ((0.05, 400.0), (0.3, 1 / 0.09), (1.0, 1.0), (3.0, 3.0)):  # T = Z = 1, d = 1/2
        rod = other_rod(damping=damping)
        eta = zeta_gain(rod) * (1 + abs(rod.reflection)) / rod.mobility
        assert lyapunov_theta(rod) == pytest.approx(expected, rel=1e-14)
        # theta = d eta + 2 d Q(0), as derived
        assert rod.mobility * (eta + 2 * lyapunov_weights(rod).leaving) == pytest.approx(expected, rel=1e-13)


# V' = -2 z p - eta z'^2 - (squares): what is left after the first two terms must not rise either, and must fall.
@pytest.mark.slow
@given(
    ratio=st.floats(-2.5, 1.5),
    stiffness=st.floats(-2, 5),
    gap=st.floats(-0.02, 0.1),
    slope=st.floats(-0.2, 0.2),
    push=st.floats(-0.5, 1),
)
def test_the_lyapunov_functional_falls_by_more_than_its_derivation_says(ratio, stiffness, gap, slope, push):
    rod = unit_rod(damping=10**ratio, compliance=10**-stiffness, gap=gap)
    scenario = Scenario.parse(displacement=f"{slope:.4f}*x*(1-x)", velocity=f"{push:.4f}*(1+cos(4*x))")
    track = track_of(rod, scenario, 4)
    t = np.linspace(0, track.reached, 81)
    functional = rod_lyapunov(track, t)
    eta = zeta_gain(rod) * (1 + abs(rod.reflection)) / rod.mobility
    paid = np.zeros(len(t))
    motion = exact_motion(rod, scenario, track.reached)
    cuts = {2 * w.number + edge for w in motion.fields.windows for edge in w.edges} | set(t.tolist())
    edges = np.array(sorted(cut for cut in cuts if cut <= track.reached))
    half = np.diff(edges)[:, None] / 2
    at = edges[:-1, None] + half * (NODES + 1)
    z, speed = motion.z(at), motion.end_velocity(at)
    rate = 2 * z * rod.nonlinearity(z) + eta * speed**2
    owed = np.concatenate(([0.0], np.cumsum((rate * half * WEIGHTS).sum(axis=1))))
    paid = functional[0] - functional
    assert np.all(paid >= owed[np.searchsorted(edges, t)] - 1e-9 * functional.max())
    assert np.diff(functional).max() <= 1e-11 * functional.max()


def test_the_functional_is_not_the_energy_in_disguise():
    # in free flight the energy stands still while the wave is away from the dashpot: a pulse that leaves x = 0 at once
    rod = other_rod(damping=0.3, gap=0.1)
    pulse = Scenario.parse(displacement="0.01*sin(5*pi*x)**2 if x < 0.2 else 0")
    track = track_of(rod, pulse, 2)
    t = np.array([0.2, 0.8])
    assert np.diff(rod_energy(track, t)) == pytest.approx([0], abs=1e-15)
    assert np.diff(rod_lyapunov(track, t))[0] < -0.1 * rod_lyapunov(track, t)[0]


def test_what_needs_damping_says_so():
    still, growing = (track_of(other_rod(damping=damping, gap=1), DATA, 2) for damping in (0, -0.1))
    with pytest.raises(AssumptionError, match="needs k != 0"):
        rod_zeta(still, [0.0])
    for track in (still, growing):
        with pytest.raises(AssumptionError, match="needs k > 0"):
            rod_lyapunov(track, [0.0])
    assert math.isfinite(rod_zeta(growing, [1.0])[0])


def test_a_track_gives_the_motion_at_edges_and_between():
    rod = other_rod(damping=0.3, gap=0.05)
    track = track_of(rod, DATA, 12)
    motion = exact_motion(rod, DATA, track.reached)
    t = np.sort(np.concatenate([2 * w.number + w.edges for w in track.windows] + [np.linspace(0, 24, 500)]))
    assert track_z(track, t) == pytest.approx(motion.z(t), abs=1e-14)


def test_the_balance_of_a_motion_whose_last_round_trip_is_cut_off_under_load_holds():
    rod, pushed = other_rod(damping=0.3), Scenario.parse(velocity="0.2*cos(9*x)", force="0.3 + 0.2*sin(9*t)")
    for until in (5.3, 8.01):
        windows = tuple(motion_windows(rod, pushed, until * rod.travel_time))
        assert windows[-1].edges[-1] < 1.5
        assert windows[-1].push[-1].any()  # in contact, so that V differs from W
        assert balance(Track(rod=rod, scenario=pushed, windows=windows)) < 1e-13
