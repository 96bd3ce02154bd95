from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from analysis.energy import deflated_coordinate
from analysis.simulation import contradictions, simulate
from analysis.simulation.certify import first_root, mesh_of, peak, rounding, scan
from analysis.simulation.contact import radau_points
from analysis.simulation.flow import _added, flow
from analysis.simulation.loads import loads_of
from analysis.simulation.plan import plan_steps
from analysis.simulation.poisson import chebyshev_sequences, chebyshev_values, poisson_columns, poisson_rows
from analysis.simulation.rest import highest_ever
from analysis.simulation.ring import Inputs, ring_of, shifted
from lure import InputError, Rod, Scenario, builtin_system, initial_state, upwind
from lure.cnn import ORDERINGS

PAPER = builtin_system("paper-rod")
# c = 2, Z = 1, d = 1/2, T = 1.5, s = 2 N/3; contact as stiff as a cell of rod where compliance is h/E
UNITS = {"youngs_modulus": 4, "density": 1, "length": 3, "area": 0.5, "compliance": 0.1, "gap": 0.2}
FLYING = Scenario.parse(displacement="0.1*cos(x)", velocity="0.3 + 0.2*sin(2*x)")
DRIVEN = {
    "force": {"force": "0.4*sin(3*t)"},
    "a force that jumps": {"force": "where(t < 1.3, 0.5, -0.2)"},
    "a force with kinks": {"force": "0.4*abs(sin(3*t)) + min(t, 1)/4"},
    "body force": {"body_force": "0.2*sin(3*t)*x"},
    "both": {"force": "0.1", "body_force": "where(t < 2, 0.3, 0)*cos(x) + 0.1*t"},
}


def rod(**changes):
    return Rod(**{**UNITS, "damping": 0.4, **changes})


def reference(scheme, scenario, times, stiff=False):
    """The motion from the matrices of the block by scipy, to about 1e-11."""
    its, block, N = scheme.rod, scheme.block, scheme.cells
    A = block.A.toarray()
    x = its.length * np.concatenate((np.arange(1, N + 1), np.arange(N - 1, -1, -1))) / N

    def right_hand_side(t, y):
        load = scenario.body_force(t=t, x=x) / (its.density * its.area)
        return A @ y - block.b1 * its.law(y[-1]) + block.b2 * scenario.force(t=t) + np.append(load, 0.0)

    start = initial_state(scheme, scenario)
    method, span = ("Radau", (0, times[-1])) if stiff else ("DOP853", (0, times[-1]))
    step = np.inf if stiff else 0.1 / scheme.rate
    tolerance = 1e-11 if stiff else 1e-12
    return solve_ivp(right_hand_side, span, start, method, times, rtol=tolerance, atol=1e-13, max_step=step).y[-1]


def disagreement(run, scheme, scenario, stiff=False):
    """Largest difference of z from the reference, relative to the largest |z|."""
    return np.abs(run.z - reference(scheme, scenario, run.t, stiff)).max() / np.abs(run.z).max()


# --- against closed forms ---------------------------------------------------------------------------------------------


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
    assert (run.z[2] - run.z[1]) / 200 == pytest.approx(0.6 / 2.0, rel=1e-12)
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


def test_a_rod_flying_at_the_obstacle_is_stopped_by_the_impulse_that_brings_zeta_to_zero():
    # zeta(0) = -gap + (N/s) v = -gap + T v = 1 for k = Z, v = 1; no rebound, so that the rod ends at z = 0 and the
    # obstacle has given A int p dt = k zeta(0) = 1 N s
    run = simulate(upwind(rod(damping=1.0, compliance=1e-3, gap=0.5), 100), Scenario.parse(velocity=1), until=20.0)
    (contact,) = run.contacts
    assert contact.impulse == pytest.approx(1.0, rel=1e-9)
    assert contact.start == pytest.approx(0.5, rel=1e-12)
    assert run.z[-1] == pytest.approx(0.0, abs=1e-12)
    assert contradictions(run) == ()


# --- against another solver -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("exponent", [0.7, 1.0, 1.5, 2.0, 3.0])
@pytest.mark.parametrize("damping", [0.4, 3.0])
def test_contact_agrees_with_another_solver(exponent, damping):
    scheme = upwind(rod(exponent=exponent, damping=damping), 6)
    run = simulate(scheme, FLYING, until=6.0, samples=121)
    assert run.contact
    assert disagreement(run, scheme, FLYING) < 1e-9
    assert run.error_estimate < 1e-10
    assert run.energy_residual < 1e-10
    assert contradictions(run) == ()


@pytest.mark.parametrize("loads", DRIVEN.values(), ids=DRIVEN)
@pytest.mark.parametrize("exponent", [1.0, 1.5])
def test_loads_agree_with_another_solver(exponent, loads):
    scheme = upwind(rod(exponent=exponent), 5)
    scenario = Scenario.parse(displacement="0.1*cos(x)", velocity="0.3", **loads)
    run = simulate(scheme, scenario, until=4.0, samples=81)
    assert disagreement(run, scheme, scenario) < 1e-8  # the reference steps over jumps and kinks
    assert run.energy_residual < 1e-10
    assert run.loaded


@pytest.mark.parametrize(("compliance", "exponent"), [(1e-4, 1.0), (1e-8, 1.0), (1e-7, 1.5)])
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


# --- events -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("cells", [1, 3, 40])
@pytest.mark.parametrize("exponent", [1.0, 2.0])
def test_a_grazing_contact_is_found_or_ruled_out_on_both_sides(cells, exponent):
    its = rod(compliance=10, exponent=exponent, gap=100)
    far = simulate(upwind(its, cells), FLYING, until=6.0, samples=2)
    top = far.max_gap_coordinate + 100
    share = 1e-12 if exponent == 1.0 else 1e-8  # a law that is not linear is followed to a tolerance of 1e-9
    near, clear = (
        simulate(upwind(replace(its, gap=top * (1 + side)), cells), FLYING, until=6.0, samples=2)
        for side in (-share, share)
    )
    assert len(near.contacts) == 1
    assert near.contacts[0].peak_penetration == pytest.approx(share * top, rel=0.05, abs=1e-13)
    assert near.max_gap_coordinate == near.contacts[0].peak_penetration
    assert not clear.contact
    assert clear.max_gap_coordinate == pytest.approx(-share * top, rel=0.05, abs=1e-13)


@given(seed=st.integers(0, 10**6), cells=st.integers(1, 12))
def test_the_largest_coordinate_is_that_of_all_instants(seed, cells):
    rng = np.random.default_rng(seed)
    scenario = Scenario.parse(displacement=f"{rng.normal():.4f}*cos({rng.uniform(1, 9):.4f}*x)", velocity="0.1")
    scheme = upwind(rod(gap=float(rng.normal())), cells)
    rare, dense = (simulate(scheme, scenario, until=3.0, samples=samples) for samples in (2, 3001))
    assert rare.max_gap_coordinate == dense.max_gap_coordinate
    assert -1e-14 <= rare.max_gap_coordinate - dense.z.max() < 1e-3
    assert rare.contacts == dense.contacts


@pytest.mark.parametrize("height", [-1e-9, 1e-9])
def test_a_pair_of_crossings_is_not_stepped_over(height):
    # height - (tau - 5.3)^2 as a Poisson average: tau^2 comes from n (n - 1), tau from n
    columns = poisson_columns(16.0)
    n = np.arange(columns, dtype=float)
    sequence = height - n * (n - 1) + 2 * 5.3 * n - 5.3**2
    mesh = mesh_of(np.linspace(0, 16, 9), columns)
    root = first_root(sequence, mesh, scan(sequence, mesh), rounding(sequence, mesh))
    assert peak(sequence, mesh, -np.inf, 0.0) == pytest.approx(height, abs=1e-13)
    if height < 0:
        assert root is None
    else:
        assert root.tau == pytest.approx(5.3 - np.sqrt(height), abs=2 * root.resolution)
        assert root.resolution < 1e-7


@given(seed=st.integers(0, 10**6), left=st.floats(0, 30), width=st.floats(0.01, 2))
def test_the_bounds_on_a_piece_hold_on_all_of_it(seed, left, width):
    sequence = np.random.default_rng(seed).standard_normal(poisson_columns(40.0))
    piece = scan(sequence, mesh_of(np.array([left, left + width]), sequence.size))
    inside = poisson_rows(np.linspace(left, left + width, 200), sequence.size) @ sequence
    assert piece.lowers[0] - 1e-12 <= inside.min()
    assert inside.max() <= piece.uppers[0] + 1e-12


def test_contact_begins_and_ends_where_the_coordinate_vanishes():
    scheme = upwind(rod(), 6)
    run = simulate(scheme, FLYING, until=6.0)
    edges = np.array([instant for contact in run.contacts for instant in (contact.start, contact.end)])
    at_edges = reference(scheme, FLYING, np.concatenate(([0.0], edges)))[1:]
    assert at_edges == pytest.approx(np.zeros(edges.size), abs=1e-11)
    assert run.event_resolution < 1e-12
    inside = sum((contact.start < run.t) & (run.t < contact.end) for contact in run.contacts)
    assert (run.p > 0).tolist() == (inside > 0).tolist()


def test_a_run_that_begins_or_ends_in_contact_says_so():
    run = simulate(upwind(rod(gap=-0.1), 4), Scenario.parse(velocity="-0.05"), until=40.0)
    assert run.contacts[0].start == 0.0
    assert run.contacts[0].open
    assert run.rest_limit == min(0.0, run.rest_position)
    brief = simulate(upwind(rod(gap=-0.1), 4), Scenario.parse(), until=0.1)
    assert brief.zeta[-1] > 0.0
    assert brief.rest_limit == 0.0
    assert not brief.rest_is_final
    pressed = simulate(upwind(rod(), 4), Scenario.parse(force=0.3), until=90.0)
    assert pressed.contacts[-1].end == pytest.approx(90.0)
    assert pressed.contacts[-1].open
    assert pressed.z[-1] == pytest.approx(0.3 / 0.5 * 0.1, rel=1e-6)  # the force is carried: A z/eps = g


def test_a_release_within_the_accuracy_of_events_does_not_count_as_two_contacts():
    # The rod leaves a law that is infinitely stiff at zero, so that the collocated stress grazes zero on the way out.
    its = rod(damping=1.0, gap=-0.4901, exponent=0.7, compliance=2.0901e-5**0.7 / 2)
    scenario = Scenario.parse(displacement="0.102*sin(2.10467*x + 3.341)", velocity="-1.51*sin(1.48733*x + 0.073)")
    run = simulate(upwind(its, 3), scenario, until=20.66)
    (contact,) = run.contacts
    assert contact.end == pytest.approx(0.6566094, abs=1e-6)
    assert contact.impulse == pytest.approx(its.damping * (run.zeta[0] - run.zeta[-1]), rel=1e-9)


def test_touching_at_rest_is_no_contact():
    run = simulate(upwind(rod(gap=0), 4), Scenario.parse(), until=5.0)
    assert not run.contact
    assert run.max_gap_coordinate == 0.0
    assert contradictions(run) == ()


# --- what must hold along every motion --------------------------------------------------------------------------------


@st.composite
def motions(draw):
    """A rod with a dashpot near an obstacle, in flight or pressed."""
    exponent = draw(st.sampled_from([1.0, 1.0, 1.5, 2.0, 3.0]))
    its = rod(
        damping=10 ** draw(st.floats(-3, 3)),
        compliance=10 ** draw(st.floats(-5, 2)),
        gap=round(draw(st.floats(-0.3, 0.5)), 4),
        exponent=exponent,
    )
    wave = f"{draw(st.floats(-0.3, 0.3)):.4f}*sin({draw(st.floats(0, 6)):.4f}*x + {draw(st.floats(0, 6)):.4f})"
    velocity = f"{draw(st.floats(-1, 1)):.4f}*cos({draw(st.floats(0, 3)):.4f}*x)"
    return upwind(its, draw(st.integers(1, 20))), Scenario.parse(displacement=wave, velocity=velocity)


@settings(max_examples=60)
@given(motion=motions())
def test_no_free_motion_contradicts_the_theory(motion):
    scheme, scenario = motion
    run = simulate(scheme, scenario, until=20.0, samples=201)
    assert contradictions(run) == ()
    assert run.energy_residual < 1e-9
    assert run.error_estimate < 1e-9
    impulse = sum(contact.impulse for contact in run.contacts)
    fallen = scheme.rod.damping * (run.zeta[0] - run.zeta[-1])
    scale = scheme.rod.damping * run.zeta_allowance / 1e-12
    assert impulse == pytest.approx(fallen, rel=1e-8, abs=1e-9 * scale)


@settings(max_examples=25)
@given(motion=motions())
def test_where_no_contact_can_follow_none_does(motion):
    scheme, scenario = motion
    brief = simulate(scheme, scenario, until=6.0, samples=3)
    if brief.rest_is_final:
        longer = simulate(scheme, scenario, until=60.0, samples=3)
        assert [(c.start, c.end) for c in longer.contacts] == [(c.start, c.end) for c in brief.contacts]
        assert longer.rest_position == pytest.approx(brief.rest_position, abs=1e3 * brief.zeta_allowance)


@given(seed=st.integers(0, 10**6), cells=st.integers(1, 12), damping=st.sampled_from([0.01, 0.4, 1.0, 3.0, 90.0]))
def test_the_shift_register_bounds_every_later_coordinate(seed, cells, damping):
    ring = ring_of(upwind(rod(damping=damping), cells))
    state = np.random.default_rng(seed).standard_normal(2 * cells + 1)
    bound = highest_ever(ring, state)
    rounds = shifted(ring, state[:, None], 6 * cells + 1, Inputs()).gap.max()  # three round trips hold the largest
    settled = state[-1] + (state[:cells].sum() + ring.echo * state[cells:-1].sum()) / ring.opening
    assert bound == pytest.approx(max(rounds, settled), rel=1e-9)
    state[-1] -= bound + 1e-9 * abs(bound)  # moved down until the bound is zero
    loads = loads_of(upwind(rod(damping=damping), cells), Scenario(), 1.0, 1e-12)
    run = list(flow(plan_steps(ring, longest=64.0, tolerance=1e-11), loads, state, 400.0))
    assert not any(segment.contact for segment in run)


@given(length=st.floats(1e-3, 1e3), time=st.floats(1e-6, 1e3), mass=st.floats(1e-3, 1e3))
def test_the_motion_does_not_depend_on_the_units(length, time, mass):
    per_area = 1 / (length * time**2) * mass  # unit of stress
    scaled = Rod(
        youngs_modulus=4 * per_area,
        density=1 * mass / length**3,
        length=3 * length,
        area=0.5 * length**2,
        damping=0.4 * mass / time,
        compliance=0.1 * length / per_area,
        gap=0.2 * length,
    )
    flying = Scenario.parse(
        displacement=f"{length!r}*0.1*cos(x/{length!r})",
        velocity=f"{length / time!r}*(0.3 + 0.2*sin(2*x/{length!r}))",
    )
    run = simulate(upwind(rod(), 5), FLYING, until=6.0, samples=50)
    other = simulate(upwind(scaled, 5), flying, until=6.0 * time, samples=50)
    assert other.z / length == pytest.approx(run.z, abs=1e-11)
    assert len(other.contacts) == len(run.contacts)
    assert other.contacts[0].start / time == pytest.approx(run.contacts[0].start, rel=1e-11)
    assert other.contacts[0].impulse * time / (length * mass) == pytest.approx(run.contacts[0].impulse, rel=1e-10)
    assert other.lyapunov_theta / time == pytest.approx(run.lyapunov_theta, rel=1e-11)


@pytest.mark.parametrize("exponent", [1.0, 1.5])
def test_the_motion_does_not_depend_on_the_steps(exponent):
    scheme = upwind(rod(exponent=exponent), 5)
    ring, state = ring_of(scheme), initial_state(scheme, FLYING)
    state[-1] *= ring.rate
    loads = loads_of(scheme, FLYING, 6.0, 1e-13)
    ends = [
        list(flow(plan_steps(ring, longest=longest, tolerance=1e-12), loads, state, 6.0 * ring.rate))[-1].end
        for longest in (64.0, 10.0, 1.0)
    ]
    scale = 1e-13 if exponent == 1.0 else 1e-10
    assert ends[1] == pytest.approx(ends[0], abs=scale)
    assert ends[2] == pytest.approx(ends[0], abs=scale)


def test_all_orderings_give_the_same_motion():
    scenario = Scenario.parse(displacement="0.1*cos(x)", velocity=0.3, force="0.1*t", body_force="0.1*x")
    runs = [simulate(upwind(rod(), 5, ordering=ordering), scenario, until=6.0) for ordering in ORDERINGS]
    assert runs[0].contact
    for run in runs[1:]:
        assert np.array_equal(run.z, runs[0].z)
        assert np.array_equal(run.energy, runs[0].energy)
        assert run.contacts == runs[0].contacts


def test_as_printed_a_force_acts_as_the_corrected_one_divided_by_the_rate():
    scheme = upwind(rod(), 6)  # s = c N/L = 4
    printed = simulate(upwind(rod(), 6, form="as-printed"), Scenario.parse(force="2*sin(3*t)"), until=9.0)
    corrected = simulate(scheme, Scenario.parse(force="2*sin(3*t)/4"), until=9.0)
    assert scheme.rate == 4.0
    assert printed.contact
    assert printed.z == pytest.approx(corrected.z, abs=1e-13)
    assert printed.energy_residual < 1e-11


@pytest.mark.parametrize(
    ("name", "largest", "contacts"),
    [
        ("paper-rod-figure-8", 0.0274433232677, 1),
        ("paper-rod-figure-9", 0.0242039824881, 3),
        ("paper-rod-figure-10", -0.00211775972487, 0),
    ],
)
@pytest.mark.slow
def test_the_papers_figures_under_force(name, largest, contacts):
    # The largest z of figure 8 was confirmed with scipy's DOP853 at rtol 1e-11 over all 5 s.
    system = builtin_system(name)
    run = simulate(upwind(system.rod, system.cells, form=system.form), system.scenario, until=system.until)
    assert run.max_gap_coordinate == pytest.approx(largest, abs=1e-13)
    assert len(run.contacts) == contacts
    assert run.error_estimate < 1e-13
    assert contradictions(run) == ()


# --- dampings other than positive -------------------------------------------------------------------------------------


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


# --- what is reported -------------------------------------------------------------------------------------------------


def test_frames_carry_both_waves_and_the_boundary_conditions():
    its = rod()
    scenario = Scenario.parse(displacement="0.1*cos(x)", velocity="0.3", force="0.2*t")
    run = simulate(upwind(its, 6), scenario, until=4.0, frames=9, samples=30)
    assert run.frames_r1.shape == run.frames_r2.shape == run.frames_v.shape == (9, 7)
    assert run.frames_t == pytest.approx(np.linspace(0, 4, 9))
    assert run.frames_x == pytest.approx(np.linspace(0, 3, 7))
    r1, r2 = scenario.waves(its, run.frames_x)
    assert run.frames_r1[0, 1:] == pytest.approx(r1[1:])
    assert run.frames_r2[0, :-1] == pytest.approx(r2[:-1])
    sent = -its.reflection * run.frames_r2[:, 0] + 2 * its.input_gain * 0.2 * run.frames_t
    assert run.frames_r1[:, 0] == pytest.approx(sent)
    assert run.frames_v == pytest.approx((run.frames_r1 + run.frames_r2) / 2)
    assert simulate(upwind(its, 6), scenario, until=4.0).frames_r1.size == 0


def test_a_trajectory_is_read_only_and_says_what_it_is():
    run = simulate(upwind(rod(), 4), FLYING, until=6.0, samples=11)
    assert run.t.size == 11
    assert run.u_end == pytest.approx(run.z + 0.2)
    assert run.p == pytest.approx(np.maximum(run.z, 0) / 0.1)
    assert run.zeta[0] == pytest.approx(
        float(deflated_coordinate(upwind(rod(), 4), initial_state(upwind(rod(), 4), FLYING)))
    )
    with pytest.raises(ValueError, match="read-only"):
        run.z[0] = 1.0
    assert str(run).startswith("scheme of 4 cells up to 6 s: 1 contact, largest z = 0.0")
    assert "No contact or release is missed" in run.method


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"energy_increase": 1e-6}, "the energy rises by 1e-06 J between two samples"),
        ({"zeta_increase": 1e-6}, "the deflated coordinate zeta rises by 1e-06 m"),
        ({"lyapunov_increase": 1e-6}, "the Popov-Lyapunov function rises by 1e-06 Pa s"),
        ({"energy_increase": np.nan}, "the energy rises by nan J"),
        ({"energy_residual": 1e-3}, "the energy identity is off by 0.001 of the energies"),
        ({"energy_residual": np.nan}, "the energy identity is off by nan"),
        ({"z": np.array([0.0, 1e9])}, "|z| reaches 1e+09 m, above the bound"),
        ({"rest_position": 0.1, "rest_is_final": True}, "the rod comes to rest at z = 0.1 m, inside the obstacle"),
        ({"ended_early": "it stopped"}, "the run ended early, though the motion is bounded: it stopped"),
    ],
)
def test_each_contradiction_has_its_sentence(change, sentence):
    run = simulate(upwind(rod(), 4), FLYING, until=6.0, samples=101)
    assert contradictions(run) == ()
    (found,) = contradictions(replace(run, **change))
    assert sentence in found


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"until": 0.0}, "simulation.until is 0.0; give a positive number of seconds"),
        ({"until": np.inf}, "simulation.until is inf"),
        ({"until": True}, "simulation.until is True"),
        ({"until": "1"}, "simulation.until is '1'"),
        ({"samples": 1}, "simulation.samples is 1; give a whole number from 2"),
        ({"frames": 1}, "simulation.frames is 1; give a whole number from 2"),
        ({"tolerance": 0.0}, "simulation.tolerance is 0.0; give a number from 1e-12 to 1e-3"),
        ({"until": 1e8}, r"simulation.until is 1e\+08 s: .* 2.1e\+09 cell .* at most 9.38e\+06 s, or at most 1 cells"),
        ({"samples": 10**7}, "simulation.samples is 10000000; with 4 cells give at most"),
    ],
)
def test_a_request_that_cannot_be_met_is_refused(change, message):
    with pytest.raises(InputError, match=message):
        simulate(upwind(rod(), 4), FLYING, **{"until": 1.0, **change})


def test_too_many_cells_too_stiff_a_contact_and_undefined_data_are_refused():
    with pytest.raises(InputError, match=r"simulation.cells is 1001; give at most 1000"):
        simulate(upwind(rod(), 1001), FLYING, until=1.0)
    with pytest.raises(InputError, match=r"rod.compliance is 1e-20: .* give a larger compliance"):
        simulate(upwind(rod(compliance=1e-20), 4), FLYING, until=1.0)
    with pytest.raises(InputError, match=r"initial.u1 is inf at x = 3 m"):
        simulate(upwind(rod(), 4), Scenario.parse(velocity="1/(x - 3)"), until=1.0)
    with pytest.raises(InputError, match=r"force.g has no finite value at t = 0\.\d+ s"):
        simulate(upwind(rod(), 4), Scenario.parse(force="log(0.5 - t)"), until=1.0)


# --- the parts --------------------------------------------------------------------------------------------------------


def test_steps_end_where_a_load_changes_its_formula():
    scheme = upwind(rod(gap=100), 5)
    jumping = Scenario.parse(force="where(t < 1.3, 0.5, -0.2)")
    loads = loads_of(scheme, jumping, 9.0, 1e-12)
    segments = list(flow(plan_steps(ring_of(scheme), longest=64.0, tolerance=1e-11), loads, np.zeros(11), 30.0))
    assert len(segments) < 6
    assert min(abs(segment.stop(scheme.rate) - 1.3) for segment in segments) < 1e-15


def test_a_hundred_thousand_steps_do_not_drift():
    clock = (1e5, 0.0)
    for _ in range(100_000):
        clock = _added(clock, 0.1)
    exact = 10**5 + 10**5 * Fraction(0.1)
    assert abs(Fraction(clock[0]) + Fraction(clock[1]) - exact) < 1e-15


@pytest.mark.parametrize("length", [1e-6, 0.3, 4.0, 64.0])
def test_poisson_averages_reproduce_polynomials(length):
    columns = poisson_columns(length)
    inside = np.linspace(0, 1, 30)
    rows = poisson_rows(length * inside, columns)
    assert rows.sum(axis=1) == pytest.approx(np.ones(30), abs=1e-15)
    averages = rows @ chebyshev_sequences(8, length, columns)
    assert averages == pytest.approx(chebyshev_values(inside, 8), abs=1e-10)


def test_radau_points_are_those_of_the_literature():
    # Hairer and Wanner, Solving ODE II, section IV.5: the points of the method of order 5
    root = np.sqrt(6)
    assert radau_points(3) == pytest.approx([(4 - root) / 10, (4 + root) / 10, 1.0], abs=1e-15)
