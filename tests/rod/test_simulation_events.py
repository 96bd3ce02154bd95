"""No contact of the scheme is missed: events, the bounds that find them, and the steps between them."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from simulated import FLYING, reference, rod

from lure.analysis.rod.simulation import contradictions, simulate
from lure.rod import Scenario, upwind
from lure.rod.scheme.crossing import first_root, mesh_of, peak, rounding, scan
from lure.rod.scheme.flow import _added, flow
from lure.rod.scheme.loads import loads_of
from lure.rod.scheme.poisson import chebyshev_sequences, chebyshev_values, poisson_columns, poisson_rows
from lure.rod.scheme.register import ShiftRegister
from lure.rod.scheme.steps import plan_steps, radau_points


@pytest.mark.parametrize("cells", [1, 3, 40])
@pytest.mark.parametrize("exponent", [1.0, 2.0])
def test_a_grazing_contact_is_found_or_ruled_out_on_both_sides(cells, exponent):
    its = rod(compliance=10, exponent=exponent, gap=100)
    far = simulate(upwind(its, cells), FLYING, until=6.0, samples=2)
    top = far.max_gap_coordinate + 100
    share = 1e-12 if exponent == 1.0 else 1e-8  # a nonlinearity that is not linear is followed to a tolerance of 1e-9
    near, clear = (
        simulate(upwind(replace(its, gap=top * (1 + side)), cells), FLYING, until=6.0, samples=2)
        for side in (-share, share)
    )
    assert len(near.contacts) == 1
    assert near.contacts[0].peak_penetration == pytest.approx(share * top, rel=0.05, abs=1e-13)
    assert near.max_gap_coordinate == near.contacts[0].peak_penetration
    assert not clear.contact
    assert clear.max_gap_coordinate == pytest.approx(-share * top, rel=0.05, abs=1e-13)


@pytest.mark.slow
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
    # The rod leaves a nonlinearity that is infinitely stiff at zero, so that the collocated stress grazes zero on the
    # way out.
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


def test_steps_end_where_a_load_changes_its_formula():
    scheme = upwind(rod(gap=100), 5)
    jumping = Scenario.parse(force="where(t < 1.3, 0.5, -0.2)")
    loads = loads_of(scheme, jumping, 9.0, 1e-12)
    segments = list(
        flow(plan_steps(ShiftRegister(scheme=scheme), longest=64.0, tolerance=1e-11), loads, np.zeros(11), 30.0)
    )
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
