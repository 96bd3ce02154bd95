"""What holds along every motion of the scheme: theory, units, steps, orderings, and the paper's figures."""

from functools import cache

import numpy as np
import pytest
from depth import sampled
from hypothesis import given, settings
from hypothesis import strategies as st
from simulated import FLYING, rod

from lure.analysis.rod.simulation import contradictions, simulate
from lure.rod import Rod, Scenario, builtin_system, initial_state, upwind
from lure.rod.discretisation import ORDERINGS
from lure.rod.scheme.flow import flow
from lure.rod.scheme.loads import loads_of
from lure.rod.scheme.register import Inputs, RegisterState, ShiftRegister, shifted
from lure.rod.scheme.steps import plan_steps


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


@settings(max_examples=sampled(12, of=60))
@given(motion=motions())
@pytest.mark.slow
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


@pytest.mark.slow
@settings(max_examples=sampled(6, of=25))
@given(motion=motions())
def test_where_no_contact_can_follow_none_does(motion):
    scheme, scenario = motion
    brief = simulate(scheme, scenario, until=6.0, samples=3)
    if brief.rest_is_final:
        longer = simulate(scheme, scenario, until=60.0, samples=3)
        spans = [[time for c in run.contacts for time in (c.start, c.end)] for run in (longer, brief)]
        assert spans[0] == pytest.approx(spans[1], rel=1e-12)
        assert longer.rest_position == pytest.approx(brief.rest_position, abs=1e3 * brief.zeta_allowance)


@given(seed=st.integers(0, 10**6), cells=st.integers(1, 12), damping=st.sampled_from([0.01, 0.4, 1.0, 3.0, 90.0]))
def test_the_shift_register_bounds_every_later_coordinate(seed, cells, damping):
    ring = ShiftRegister(scheme=upwind(rod(damping=damping), cells))
    state = np.random.default_rng(seed).standard_normal(2 * cells + 1)
    bound = RegisterState(register=ring, waves=state[:-1], gap=float(state[-1])).largest_gap()
    rounds = shifted(ring, state[:, None], 6 * cells + 1, Inputs()).gap.max()  # three round trips hold the largest
    settled = state[-1] + (state[:cells].sum() + ring.echo * state[cells:-1].sum()) / ring.opening
    assert bound == pytest.approx(max(rounds, settled), rel=1e-9)
    state[-1] -= bound + 1e-9 * abs(bound)  # moved down until the bound is zero
    loads = loads_of(upwind(rod(damping=damping), cells), Scenario(), 1.0, 1e-12)
    run = list(flow(plan_steps(ring, longest=64.0, tolerance=1e-11), loads, state, 400.0))
    assert not any(segment.contact for segment in run)


@cache
def flown():
    return simulate(upwind(rod(), 5), FLYING, until=6.0, samples=50)


@pytest.mark.slow
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
    run, other = flown(), simulate(upwind(scaled, 5), flying, until=6.0 * time, samples=50)
    assert other.z / length == pytest.approx(run.z, abs=1e-11)
    assert len(other.contacts) == len(run.contacts)
    assert other.contacts[0].start / time == pytest.approx(run.contacts[0].start, rel=1e-11)
    assert other.contacts[0].impulse * time / (length * mass) == pytest.approx(run.contacts[0].impulse, rel=1e-10)
    assert other.lyapunov_theta / time == pytest.approx(run.lyapunov_theta, rel=1e-11)


@pytest.mark.slow_for("1.5")
@pytest.mark.parametrize("exponent", [1.0, 1.5])
def test_the_motion_does_not_depend_on_the_steps(exponent):
    scheme = upwind(rod(exponent=exponent), 5)
    ring, state = ShiftRegister(scheme=scheme), initial_state(scheme, FLYING)
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
        pytest.param("paper-rod-figure-9", 0.0242039824881, 3, marks=pytest.mark.thorough),
        pytest.param("paper-rod-figure-10", -0.00211775972487, 0, marks=pytest.mark.thorough),
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
