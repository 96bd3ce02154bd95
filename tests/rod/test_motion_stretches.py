"""lure.rod.motion, round trips in which nothing happens: the numbers of compiled code that goes through each of
them."""

from fractions import Fraction

import numpy as np
import pytest
from depth import rarely
from hypothesis import given, settings
from hypothesis import strategies as st
from motions import WITH_NUMBA, unit_rod

from lure import InputError, PiecewiseLinear
from lure.rod import Scenario, builtin_system
from lure.rod.motion import Boundary, Numerics, exact_motion
from lure.rod.motion.blocks import SeriesBlock, Steps
from lure.rod.motion.event_free import EventFreeInterval
from lure.rod.motion.event_search import Walk
from lure.rod.motion.exponential_force import ExponentialForces
from lure.rod.motion.kernel_free import FROM, MOST, NEXT, UP_TO, force_at
from lure.rod.motion.motion import _problem

pytestmark = WITH_NUMBA
ON, OFF = Numerics(compiled=True), Numerics(compiled=True, stretches=False)
PLAIN = Numerics(compiled=False)
AMOUNT = st.floats(-1, 1).map(lambda x: round(x, 3))
SOFT = Boundary(nonlinearity=PiecewiseLinear([(0, 0), (Fraction(1, 10), Fraction(1, 50))], left_slope=0, right_slope=2))


def stretches(motion):
    """Those of a motion."""
    record = motion.fields.record
    return [part for part in getattr(record, "_parts", [record]) if isinstance(part, EventFreeInterval)]


def quiet_trips(motion):
    """How many round trips they cover."""
    return sum(len(part) for part in stretches(motion))


def assert_same(first, second, tolerance=1e-12):
    """Same motion, impacts and sums; at instants that no jump is likely to meet."""
    t = np.random.default_rng(3).uniform(second.since, second.until, 500)
    size = max(1.0, np.abs(second.z(t)).max())
    assert np.abs(first.z(t) - second.z(t)).max() < tolerance * size
    for name in ("wave", "returned", "push"):
        times = t / second.rod.travel_time
        off = np.abs(first.fields.at_end(times, name) - second.fields.at_end(times, name))
        assert np.quantile(off, 0.98) < 10 * tolerance * size, name
    assert first.crossings == second.crossings
    assert len(first.impacts) == len(second.impacts)
    for ours, theirs in zip(first.impacts, second.impacts, strict=True):
        assert ours.closed == theirs.closed
        assert [ours.start, ours.end] == pytest.approx([theirs.start, theirs.end], rel=1e-9)
        assert ours.impulse == pytest.approx(theirs.impulse, rel=1e-9, abs=1e-12)
        assert ours.peak_stress == pytest.approx(theirs.peak_stress, rel=1e-9, abs=1e-12)
    assert first.energy_residual < 1e-11
    assert first.error < 1e-11 * size


FORCES = (
    "0",
    "0.05*({a})",
    "0.1*({a})*sin(0.13*t)",
    "0.01*({b})*t",
    "0.1*({a})*exp(-t/40)",
    "0.02*({a})*t*exp(-t/50)*cos(0.2*t)",
    "where(t < 100, 0.05*({a}), 0.05*({b})*sin(0.01*t))",
    "({a})*(0.05 if t < 33.3 else -0.05 if t < 71 else 0.002*t - 0.00001*t**2)",
)


@st.composite
def problems(draw):
    """A rod whose end is far from the obstacle or rests on a soft one for long, a scenario, a boundary and a time."""
    rod = unit_rod(
        damping=draw(st.sampled_from([0.0, 1e-4, 3e-3, 0.3, 1.0, 7.0])),
        compliance=10.0 ** draw(st.integers(-4, 4)),
        gap=draw(st.floats(0.3, 3).map(lambda x: round(x, 3))),
    )
    a, b, c = draw(AMOUNT), draw(AMOUNT), draw(AMOUNT)
    scenario = Scenario.parse(
        displacement=f"0.1*({a})*(1 - x)",
        velocity=f"0.1*({c}) + 0.1*({b})*x*x",
        force=draw(st.sampled_from(FORCES)).format(a=a, b=b),
    )
    kind = draw(st.sampled_from(["rod", "rod", "rigid", "graph"]))
    boundary = Boundary(
        clamped=draw(st.integers(0, 3)) == 0,
        end_damping=draw(st.sampled_from([0.0, 0.2, 3.0])),
        rigid=kind == "rigid",
        nonlinearity=SOFT.nonlinearity if kind == "graph" else None,
    )
    return rod, scenario, boundary, draw(st.floats(100, 600))


@given(problem=problems())
def test_stretches_change_nothing(problem):
    rod, scenario, boundary, until = problem
    motions = [exact_motion(rod, scenario, until, boundary=boundary, numerics=how) for how in (ON, OFF)]
    assert_same(*motions)


SLOW = Boundary(nonlinearity=PiecewiseLinear([(0, 0), (1, Fraction(1, 5000))], left_slope=0, right_slope=0))


# Loops where the kernel is compiled, arrays where it is not: the same round trips without events, of the same numbers;
# in flight, in contact, and on a segment of constant stress.  Where an interval ends or begins may hang on a rounding,
# which is another on another processor: 2, 4 or 8 round trips are then gone through before it is tried again.
@pytest.mark.parametrize(
    ("boundary", "velocity", "force"),
    [
        (Boundary(), "0.002", "0.00002"),
        (Boundary(end_damping=1e-3), "0.004 + 0.001*x*x", "0.0001*sin(0.013*t)"),
        (Boundary(), "0.002", "0.0000002*t*exp(-t/800)*cos(0.005*t)"),
        (SLOW, "0.006", "0.0004 if t < 900 else -0.001"),
    ],
)
def test_loops_and_arrays_pass_over_the_same_round_trips(boundary, velocity, force):
    rod = unit_rod(damping=1e-3, compliance=1e4, gap=0.6)
    scenario = Scenario.parse(velocity=velocity, displacement="0.001*(1 - x)", force=force)
    motions = [exact_motion(rod, scenario, 2500.0, boundary=boundary, numerics=how) for how in (ON, PLAIN)]
    ours, theirs = (
        {number: part.index for part in stretches(motion) for number in range(part.number, part.number + part.count)}
        for motion in motions
    )
    both = ours.keys() & theirs.keys()
    assert [ours[number] for number in both] == [theirs[number] for number in both]
    assert len(ours.keys() ^ theirs.keys()) < 0.04 * len(both)  # two edges of 2 + 4 + 8 are 2.2 %
    assert len(both) > 1150  # of 1250
    assert len({ours[number] for number in both}) > 1  # before contact and in it
    assert SeriesBlock in {type(block) for part in stretches(motions[0]) for block in part.blocks}
    assert_same(*motions)
    for number in sorted(both)[::97]:
        first, second = (motion.fields.windows[number].end for motion in motions)
        assert first.zeta.value == pytest.approx(second.zeta.value, rel=4e-15, abs=1e-13)
        assert (first.impact is None) == (second.impact is None)
        if first.impact is not None:
            assert first.impact.impulse == pytest.approx(second.impact.impulse, rel=1e-10)
            assert first.impact.peak_stress == pytest.approx(second.impact.peak_stress, rel=1e-10)


# Round trips as a series in their number, round trips by doubling: see lure.rod.motion.blocks.
@settings(max_examples=8)
@given(problem=problems())
@pytest.mark.slow
def test_series_and_doubling_go_the_same_way(problem):
    rod, scenario, boundary, until = problem
    first = exact_motion(rod, scenario, until, boundary=boundary, numerics=PLAIN)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Steps, "length", lambda self, rows: 0)
        second = exact_motion(rod, scenario, until, boundary=boundary, numerics=PLAIN)
    assert_same(first, second)


def test_figure_8_goes_the_same_way_uncompiled_and_by_doubling(monkeypatch):
    motion, other = figure_8(0.8, ON), figure_8(0.8, PLAIN)
    assert quiet_trips(motion) == quiet_trips(other) > 2300  # of 2400
    assert_same(motion, other)
    assert motion.impacts[-1].peak_stress == pytest.approx(other.impacts[-1].peak_stress, rel=1e-12)
    assert {type(block) for part in stretches(motion) for block in part.blocks} == {SeriesBlock}
    assert {block.rows is None for part in stretches(other) for block in part.blocks} == {False}
    monkeypatch.setattr(Steps, "length", lambda self, rows: 0)
    doubled = figure_8(0.8, PLAIN)
    assert {block.rows is None for part in stretches(doubled) for block in part.blocks} == {True}
    assert quiet_trips(doubled) > 2300
    assert_same(motion, doubled)


# In the last contact z turns slowly, 32 round trips from one that is looked at to the next: all keep the bounds.
def test_bounds_hold_between_the_round_trips_that_are_looked_at(monkeypatch):
    seen, bounds = [], Walk._bounds
    monkeypatch.setattr(Walk, "_bounds", lambda *arguments: seen.append(bounds(*arguments)) or seen[-1])
    figure_8(2.0, PLAIN)
    assert max((span.last - span.first).max() for span in seen) > 30
    for span in seen:
        for low, high, first, last in zip(-span.reach[:, 0], span.reach[:, 1], span.first, span.last, strict=True):
            # the same numbers of some 1e-4, of products in another shape: the order of sums is the processor's
            edges = span.block.at(np.arange(first, last + 1), span.table)[:, : len(span.others) + 1]
            assert low <= edges.min() + 1e-16
            assert edges.max() <= high + 1e-16


# Every bound that is looked at holds: zeta at random places of random round trips of the parts it speaks of.
@settings(max_examples=10)
@given(problem=problems(), seed=st.integers(0, 99))
def test_bounds_over_parts_of_a_block_hold(problem, seed):
    rod, scenario, boundary, until = problem
    random, seen = np.random.default_rng(seed), []
    bounds = Walk._bounds

    def watched(walk, *arguments):
        seen.append((walk.steps, bounds(walk, *arguments)))
        return seen[-1][1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Walk, "_bounds", watched)
        exact_motion(rod, scenario, until, boundary=boundary, numerics=PLAIN)
    for steps, span in seen[:40]:
        n = np.floor(random.uniform(span.first, np.minimum(span.last, span.block.length - 1) + 1.0))
        states = span.block.at(np.minimum(n, span.last - 1.0), span.block.table())
        places = np.polynomial.chebyshev.chebvander(random.uniform(-1, 1, 7), steps.trip.series.shape[1] - 1)
        zeta = np.einsum("xk,pkn,in->ixp", places, steps.trip.series, states).reshape(len(n), -1)
        slack = 1e-14 * np.abs(zeta).max(axis=1)
        assert np.all(-span.reach[:, 0] - slack <= zeta.min(axis=1))
        assert np.all(span.reach[:, 1] + slack >= zeta.max(axis=1))
        assert np.all(span.tops <= span.reach[:, 1] + slack)


@pytest.mark.parametrize("force", FORCES)
@pytest.mark.parametrize("compliance", [0.1, 1e3])
def test_a_long_way_to_the_obstacle_is_a_stretch(force, compliance):
    # v(0) = 0.02 over a gap of 1: no contact before t ~ 50, 25 round trips; on the soft obstacle the end stays long
    rod = unit_rod(damping=3e-3, compliance=compliance, gap=1.0)
    scenario = Scenario.parse(velocity="0.02", displacement="0.01*x", force=force.format(a=0.005, b=-0.0005))
    motion, other = (exact_motion(rod, scenario, 400.0, numerics=how) for how in (ON, OFF))
    assert quiet_trips(motion) >= 16
    assert quiet_trips(other) == 0
    assert_same(motion, other)


def figure_8(until, numerics):
    """The paper's rod under the corrected force."""
    scenario = Scenario.parse(force=f"{2 / 60000!r}*sin(4*t)", displacement="0.0001 - 0.0002*x")
    return exact_motion(builtin_system("paper-rod-figure-8").rod, scenario, until, numerics=numerics)


@pytest.mark.slow
def test_figure_8_is_almost_all_quiet_and_unchanged():
    motion, other = figure_8(10.0, ON), figure_8(10.0, OFF)
    assert quiet_trips(motion) > 29_000  # of 30 000
    t = np.linspace(0, 10, 4001)
    assert np.abs(motion.z(t) - other.z(t)).max() < 1e-13
    for ours, theirs in zip(motion.impacts, other.impacts, strict=True):
        # z moves by 2e-5 a round trip of 3.3e-4 s past the contact, so that 1e-14 m are 2e-13 s
        assert [ours.start, ours.end] == pytest.approx([theirs.start, theirs.end], abs=3e-12)
        assert ours.impulse == pytest.approx(theirs.impulse, rel=1e-7)
        assert ours.peak_stress == pytest.approx(theirs.peak_stress, rel=1e-9)
    assert motion.energy_residual < 1e-15


def test_an_impact_that_goes_on_has_the_peak_of_its_own_time():
    # 10 s end while z still rises: the largest stress must not come from round trips after the end
    motion = figure_8(10.0, ON)
    last = motion.impacts[-1]
    t = np.linspace(last.start, 10.0, 200_001)
    assert not last.closed
    assert last.peak_stress == pytest.approx(motion.contact_stress(t).max(), rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("keep", rarely([None, 2, 70, 1500], 70, 1500))
def test_windows_made_of_stretches_are_those_of_compiled_code(keep):
    found = []
    for how in ({}, {"stretches": False}):
        seen = []
        motion = figure_8(1.0, Numerics(compiled=True, keep=keep, on_window=seen.append, **how))
        found.append((motion, seen))
    (first, ours), (second, theirs) = found
    assert len(ours) == len(theirs) == 3000
    assert first.since == second.since
    if keep is not None:
        assert len(first.fields.windows) == keep
        assert len(second.fields.windows) == keep
    pairs = [*zip(ours, theirs, strict=True)]
    pairs += zip(first.fields.windows[-70:], second.fields.windows[-70:], strict=True)
    for one, other in [*pairs[::37], *pairs[-72:]]:
        assert one.number == other.number
        assert one.wave.shape[1] == one.z.shape[1] == one.push.shape[1] == one.returned.shape[1] == 17
        assert one.edges == pytest.approx(other.edges, abs=1e-9)
        t = np.linspace(0.0, 1.0, 9) * 0.99 + 0.005
        for name, size in (("wave", 1.0), ("z", 1e-3), ("push", 1e-6), ("returned", 1.0)):
            off = _values(one, name, t) - _values(other, name, t)
            assert np.abs(off).max() < 1e-12 * size, (one.number, name)
        assert one.end.segment == other.end.segment
        assert one.end.zeta.value + one.end.zeta.rest == pytest.approx(
            other.end.zeta.value + other.end.zeta.rest, abs=1e-15
        )
        assert (one.end.impact is None) == (other.end.impact is None)
        if one.end.impact is not None:
            for name in ("start", "end", "impulse", "peak_stress"):
                assert getattr(one.end.impact, name) == pytest.approx(getattr(other.end.impact, name), rel=1e-9)
    t = np.linspace(first.since, 1.0, 301)
    assert first.z(t) == pytest.approx(second.z(t), abs=1e-14)


def _values(window, name, share):
    """A series of a window at places inside its middle piece."""
    i = len(window.wave) // 2
    return np.polynomial.chebyshev.chebval(2.0 * share - 1.0, getattr(window, name)[i])


def test_waves_energy_and_displacement_inside_a_stretch():
    motion, other = figure_8(1.0, ON), figure_8(1.0, OFF)
    x = np.linspace(0.0, 1.0, 41)
    for t in (0.21234, 0.9):
        for ours, theirs in zip(motion.waves(t, x), other.waves(t, x), strict=True):
            assert ours == pytest.approx(theirs, abs=1e-13)
        assert motion.displacement(t, x) == pytest.approx(other.displacement(t, x), abs=1e-15)
        assert motion.energy(t) == pytest.approx(other.energy(t), rel=1e-12)


def test_free_flight_against_the_closed_form():
    # k = 0: u = u1 t - 0.01 cos(pi x) cos(pi t)
    scenario = Scenario.parse(displacement="-0.01*cos(pi*x)", velocity="0.001")
    motion = exact_motion(unit_rod(damping=0.0, gap=1e3), scenario, 200_000.0, numerics=ON)
    t = np.linspace(0.0, 200_000.0, 50_001)
    assert quiet_trips(motion) > 99_990
    assert np.abs(motion.end_displacement(t) - 0.001 * t - 0.01 * np.cos(np.pi * t)).max() < 1e-12 * 200


def test_resting_contact_keeps_its_energy_over_many_periods():
    # k = 0 and a weak force: the end starts 0.5 inside a soft obstacle, of the period 2 pi sqrt(1e4) = 628
    rod = unit_rod(damping=0.0, compliance=1e4, gap=-0.5)
    scenario = Scenario.parse(velocity="0.001", displacement="0.0002*x")
    motion, other = (exact_motion(rod, scenario, 400.0, numerics=how) for how in (ON, OFF))
    assert quiet_trips(motion) > 100
    assert_same(motion, other)


def near_a_top_at_the_obstacle(extra):
    """Both motions of a mass 1 with u1 = 0.02 that a force -u1^2/2 brings to rest at t = 100, u = 1: the gap."""
    rod = unit_rod(damping=0.0, compliance=1e-2, gap=1.0)
    scenario = Scenario.parse(velocity=f"{0.02 * (1 + extra)!r}", force="-0.0002")
    return [exact_motion(rod, scenario, 250.0, numerics=how) for how in (ON, OFF)]


@pytest.mark.parametrize("extra", [1e-3, 1e-6, 1e-10, -1e-10, -1e-6, -1e-3])
def test_a_top_short_of_the_obstacle_or_beyond_it(extra):
    motion, other = near_a_top_at_the_obstacle(extra)
    assert quiet_trips(motion) >= 16
    assert_same(motion, other, tolerance=1e-11)


# v(L) falls by 0.0004 at t = 1, 3, ...; z is largest on (99, 101), where v = 0: 99 u1 - 4900 f - 1, of these doubles
# -5.7e-18, which is no contact.  On a way of 1 each of fifty round trips rounds z by up to 1.1e-16, in an order of sums
# that depends on the processor, and a motion may see a contact within that.
def test_a_top_that_grazes_the_obstacle_is_a_contact_to_rounding_or_none():
    motion, other = near_a_top_at_the_obstacle(0.0)
    top = float(99 * Fraction(0.02) - 4900 * Fraction(0.0002) - 1)
    assert -1e-17 < top < 0
    t = np.linspace(0.0, 250.0, 501)
    assert motion.z(t) == pytest.approx(other.z(t), abs=1e-12)
    for one in (motion, other):
        assert one.z([99.0, 99.7, 100.3, 101.0]) == pytest.approx([top] * 4, abs=5.5e-15)
        assert max((hit.peak_stress for hit in one.impacts), default=0.0) < 5.5e-15 / 1e-2


def test_the_sum_of_exponentials_is_the_force():
    rod = unit_rod(damping=0.3)
    text = "0.3*t**2 - t*exp(-0.2*t)*sin(0.7*t + 1) + 2 + where(t < 12, 0, 1)"
    sources = _problem(rod, Scenario.parse(force=text), 50.0, Boundary(), 16).sources
    forces = ExponentialForces(sources, 50.0)
    rest = ExponentialForces(_problem(rod, Scenario.parse(velocity="1"), 50.0, Boundary(), 16).sources, 50.0)
    assert forces.packed(1).dtype == rest.packed(1).dtype == np.float64  # compiled once for both
    assert rest.packed(1)[[FROM, UP_TO, NEXT, MOST]].tolist() == [0.0, np.inf, np.inf, 25.0]
    for number in (1, 5, 6, 7, 20):
        packed = forces.packed(number)
        # t = 12, one transit later, in round trip 6, which is neither before nor after
        assert packed[[FROM, UP_TO, NEXT, MOST]].tolist() == (
            [0.0, 13.0, 7.0, 6.0] if number <= 6 else [13.0, np.inf, np.inf, 25.0]
        )
        t = 2.0 * number + np.linspace(0.0, 0.99, 7)
        found = [force_at(packed, x, late) for late in (0.0, 2.0 * number) for x in t - 1.0 - late]
        assert found == pytest.approx(np.tile(sources.added(t)[0], 2), rel=1e-12)


@pytest.mark.parametrize(
    "loads",
    [
        {"force": "exp(-(t - 3)**2)"},
        {"body_force": "0.01*x"},
        {"force": "0.01*sin(t)*t**5/1e9"},
        {"force": "sqrt(t)*0.01"},
    ],
)
def test_other_loads_take_every_round_trip(loads):
    motion = exact_motion(unit_rod(gap=1e3), Scenario.parse(displacement="0.01*x", **loads), 100.0, numerics=ON)
    assert quiet_trips(motion) == 0


def test_the_option_is_true_or_false():
    with pytest.raises(InputError, match=r"Numerics\.stretches is 1; give True or False"):
        Numerics(stretches=1)


def test_windows_of_waves_of_full_degree_are_as_wide_as_the_others():
    # cos(4x) on a transit needs all 17 coefficients of W, and z one more, which is left out
    seen = []
    scenario = Scenario.parse(displacement="0.001*cos(4*x)", velocity="0.001*sin(5*x)")
    numerics = Numerics(compiled=True, on_window=seen.append)
    motion = exact_motion(unit_rod(damping=0.3, gap=10.0), scenario, 200.0, numerics=numerics)
    assert quiet_trips(motion) > 90
    assert {series.shape[1] for window in seen for series in (window.wave, window.z, window.push)} == {17}
    assert motion.z(2.0 * 50 + 0.3) == pytest.approx(np.polynomial.chebyshev.chebval(-0.4, seen[50].z[0]), abs=1e-14)
