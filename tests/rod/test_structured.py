"""lure.rod.scheme: time jumps of the f-circulant ring by two ways, and the first contact of a free flight."""

import math

import flint
import numpy as np
import pytest
from depth import rarely
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from lure import InputError
from lure.analysis.numerics.precision import working_precision
from lure.analysis.rod.energy import deflated_coordinate, discrete_energy
from lure.analysis.rod.simulation import simulate
from lure.expressions import Expression
from lure.rod import Rod, Scenario, builtin_system, initial_state, upwind
from lure.rod.scheme import first_contact, free_flight
from lure.rod.scheme.poisson import Mean, mean_of, poisson_weights
from lure.rod.systems import paper_rod

PAPER = builtin_system("paper-rod")
Z = 1.2  # N s/m, impedance of the paper's rod
DAMPINGS = st.one_of(st.sampled_from((0.0, Z, 2e-4, 1e9)), st.floats(1e-300, 10.0), st.floats(-0.5, -1e-300))


def rod_with(k, gap=0.02):
    return Rod(youngs_modulus=288e6, density=8, length=1, area=0.25e-4, damping=k, compliance=1, gap=gap)


def scaled(scheme, state):
    """States with s z in place of z, so that all entries are velocities."""
    out = np.array(state)
    out[..., np.flatnonzero(scheme.c)[0]] *= scheme.rate
    return out


def by_expm(scheme, state, tau):
    A = scheme.A.toarray() / scheme.rate
    z = int(np.flatnonzero(scheme.c)[0])
    A[z] *= scheme.rate
    return expm(tau * A) @ scaled(scheme, state)


@given(
    k=DAMPINGS,
    N=st.integers(1, 25),
    tau=st.one_of(st.sampled_from((0.0, 1e-9)), st.floats(0.0, 150.0)),
    seed=st.integers(0, 10**6),
    ordering=st.sampled_from(("eq39", "eq48")),
)
@example(k=0.0, N=1, tau=0.0, seed=1, ordering="eq39")
@example(k=Z, N=25, tau=50.0, seed=1, ordering="eq39")
def test_both_ways_are_the_matrix_exponential(k, N, tau, seed, ordering):
    scheme = upwind(rod_with(k), N, ordering=ordering)
    start = np.random.default_rng(seed).normal(size=2 * N + 1)
    start[np.flatnonzero(scheme.c)] /= scheme.rate
    flight, t = free_flight(scheme, start), tau / scheme.rate
    expected = by_expm(scheme, start, scheme.rate * t)
    allowed = 1e-12 * max(10.0, float(np.abs(expected).max()))
    assert np.abs(scaled(scheme, flight.state(t, way="poisson")) - expected).max() < allowed
    if flight.modes is not None:
        assert np.abs(scaled(scheme, flight.state(t, way="modes")) - expected).max() < allowed
        assert flight.discrepancy(t) < allowed
    z, wave = flight.end(t)
    assert abs(z * scheme.rate - scheme.c @ expected) < allowed
    assert abs(wave - expected[N - 1]) < allowed


def test_the_modes_are_left_where_the_echo_is_faint_or_missing():
    for k, use in ((Z, False), (1.1 * Z, False), (0.5 * Z, True), (0.0, True), (1e9, True)):
        flight = free_flight(upwind(rod_with(k), 5), np.ones(11))
        assert (flight.modes is not None) is use
    with pytest.raises(InputError, match=r"outside 0\.1 <= \|a\| <= 10"):
        free_flight(upwind(rod_with(Z), 5), np.ones(11)).state(1.0, way="modes")


# w_n from its definition, exp(n ln tau - tau - ln Gamma(n+1)), with 400 bits
@pytest.mark.parametrize(
    "mean", [Mean(whole=0, rest=0.25), Mean(whole=7, rest=-0.5), Mean(whole=6 * 10**8, rest=0.125)]
)
def test_poisson_weights_are_those_of_the_definition(mean):
    first, weights = poisson_weights(mean)
    with working_precision(400):
        tau = flint.arb(mean.whole) + flint.arb(mean.rest)
        for n in {first, first + weights.size // 3, first + weights.size // 2, round(mean.value)}:
            exact = float((flint.arb(n) * tau.log() - tau - flint.arb(n + 1).lgamma()).exp())
            assert weights[n - first] == pytest.approx(exact, rel=2e-14)
    assert weights.sum() == pytest.approx(1.0, abs=1e-14)
    assert (np.arange(first, first + weights.size) - mean.whole) @ weights == pytest.approx(mean.rest, abs=1e-9)


def test_the_mean_is_not_rounded():
    mean = mean_of(1e9 + 1.0, 1.0 + 2.0**-52)
    assert mean.whole == 10**9 + 1
    assert mean.rest == pytest.approx((1e9 + 1.0) * 2.0**-52, rel=1e-15)


# two jumps are one: the time of the second is a whole number of cells, so that nothing is rounded
@given(k=DAMPINGS, N=st.integers(1, 3000), cells=st.integers(0, 10**7), seed=st.integers(0, 99))
def test_a_jump_is_as_good_as_two(k, N, cells, seed):
    scheme = upwind(Rod(youngs_modulus=1, density=1, length=N, area=1, damping=abs(k), compliance=1), N)
    assert scheme.rate == 1.0
    flight = free_flight(scheme, np.random.default_rng(seed).normal(size=2 * N + 1))
    whole = scaled(scheme, flight.state(float(2 * cells)))
    halves = scaled(scheme, free_flight(scheme, flight.state(float(cells))).state(float(cells)))
    assert np.abs(whole - halves).max() <= 1e-11 * (1.0 + np.abs(whole).max() + math.sqrt(N))


@given(k=st.floats(1e-3, 100.0), N=st.integers(1, 2000), seed=st.integers(0, 99))
def test_energy_falls_and_the_deflated_coordinate_stays(k, N, seed):
    scheme = upwind(rod_with(k, gap=1e9), N)
    start = np.random.default_rng(seed).normal(size=2 * N + 1)
    start[-1] = -1e9
    flight = free_flight(scheme, start)
    states = np.array([flight.state(t) for t in np.array([0.0, 0.1, 1.0, 3.0, 50.0]) * scheme.rod.travel_time])
    energy = discrete_energy(scheme, states)
    assert np.all(np.diff(energy) <= 1e-12 * energy[0])
    assert energy[-1] < energy[0]
    states[:, -1] += 1e9
    zeta = deflated_coordinate(scheme, states)
    assert np.allclose(zeta, zeta[0], rtol=0, atol=1e-6)


# without a dashpot what one wave loses the other gains: the sum over the ring stays, and z drifts at its mean
def test_without_damping_the_mean_wave_never_dies():
    N = 64
    scheme = upwind(rod_with(0.0), N)
    waves = np.random.default_rng(3).normal(size=2 * N)
    flight = free_flight(scheme, np.append(waves, -0.02))
    state = flight.state(3600.0)
    assert np.allclose(state[:-1], waves.mean(), atol=1e-12)
    assert state[-1] == pytest.approx(-0.02 + waves.mean() * 3600.0, abs=5 * PAPER.rod.travel_time)


# H has the residue A/k at 0, so an impulse of stress moves z by A/k in the end: for every N the same
@pytest.mark.parametrize("k", [2e-4, 0.3, Z, 50.0])
def test_the_residue_does_not_depend_on_the_number_of_cells(k):
    for N in (1, 10, 1000, 100_000):
        scheme = upwind(rod_with(k), N)
        state = free_flight(scheme, scheme.b1).state(1e5)
        assert state[-1] == pytest.approx(0.25e-4 / k, rel=1e-10)
        assert np.abs(state[:-1]).max() < 1e-12 * scheme.rate


# every wave leaves a matched rod: N cells forward, N back
def test_a_matched_rod_is_silent_after_its_waves_have_left():
    flight = free_flight(upwind(rod_with(Z), 500), PAPER.scenario)
    T = PAPER.rod.travel_time
    assert np.abs(flight.state(0.5 * T)[:-1]).max() > 0.1
    assert np.abs(flight.state(4 * T)[:-1]).max() < 1e-12


def test_the_motion_is_that_of_the_event_exact_simulation():
    scheme = upwind(PAPER.rod, 200)
    run = simulate(scheme, PAPER.scenario, until=2e-3, samples=41)
    z, _ = free_flight(scheme, PAPER.scenario).end(run.t)
    assert np.abs(z - run.z).max() < 1e-12 * np.abs(run.z).max()


def test_one_hundred_thousand_cells_fly_for_a_second():
    flight = free_flight(upwind(PAPER.rod, 100_000), PAPER.scenario)
    assert flight.discrepancy(1.0) < 1e-13
    assert first_contact(flight, 1.0) is None
    z, wave = flight.end(np.linspace(0.0, 1.0, 101))
    state = flight.state(1.0)
    assert abs(state[-1] - z[-1]) < 1e-15
    assert abs(state[99_999] - wave[-1]) < 1e-12
    assert np.abs(z + 0.02).max() <= 1e-4 * (1 + 1e-9)


def test_any_time_is_one_jump():
    flight = free_flight(upwind(PAPER.rod, 1000), PAPER.scenario)
    assert np.isfinite(flight.state(1e290)).all()
    assert flight.state(1e290)[-1] == pytest.approx(flight.state(1e5)[-1], rel=1e-12)


# the paper's data: the end swings up from z = -1e-4 - gap by almost 2e-4
@pytest.mark.slow
@given(share=st.floats(0.02, 0.9), N=st.sampled_from((3, 10, 80)), k=st.sampled_from((0.0, 2e-4, 0.4, Z, 30.0)))
@settings(max_examples=25)
def test_the_first_contact_is_where_the_event_exact_simulation_sees_it(share, N, k):
    scheme = upwind(rod_with(k, gap=-1e-4 + 2e-4 * share), N)
    until = 4 * scheme.rod.travel_time
    run = simulate(scheme, PAPER.scenario, until=until, samples=3)
    found = first_contact(free_flight(scheme, PAPER.scenario), until)
    assert (found is not None) is run.contact
    if run.contact:
        assert found == pytest.approx(run.contacts[0].start, rel=1e-9)


# the bound that excludes contact for ever, against a hundred round trips of the register itself
@given(k=st.one_of(st.sampled_from((0.0, Z)), st.floats(1e-3, 50.0)), N=st.integers(1, 30), seed=st.integers(0, 999))
def test_the_bound_for_all_times_is_the_largest_value_of_the_register(k, N, seed):
    rng = np.random.default_rng(seed)
    held = free_flight(upwind(rod_with(k), N), rng.normal(size=2 * N + 1) + rng.normal()).start
    waves, gap, values = held.waves.copy(), held.gap, [held.gap]
    for _ in range(100 * 2 * N):
        gap += waves[N - 1]
        waves = np.concatenate(([held.register.echo * waves[-1]], waves[:-1]))
        values.append(gap)
    bound, largest = held.largest_gap(100), max(values)
    allowed = 1e-9 * (1.0 + np.abs(values).max())
    assert np.abs(held.gaps(np.arange(len(values))) - values).max() < allowed
    assert largest <= bound + allowed
    if held.register.echo**100 < 1e-12:  # it is approached by then, from one side or the other
        assert bound <= max(largest, values[-1]) + allowed


# the first swing; later the rod of this gap would touch, since it comes to rest higher still
@pytest.mark.slow
@pytest.mark.parametrize("N", rarely([50, 2000], 2000))
def test_a_graze_is_seen_from_both_sides(N):
    T, gap = PAPER.rod.travel_time, 0.02
    times = np.linspace(0.9 * T, 1.1 * T, 2001)
    z, _ = free_flight(upwind(PAPER.rod, N), PAPER.scenario).end(times)
    height = float(z.max()) + gap
    for shift, touches in ((1e-6, False), (-1e-6, True)):
        scheme = upwind(rod_with(2e-4, gap=height * (1 + shift)), N)
        found = first_contact(free_flight(scheme, PAPER.scenario), 1.3 * T)
        assert (found is not None) is touches
        if touches:
            assert found == pytest.approx(times[np.argmax(z)], rel=0.02)


# a drift with k = 0: mean wave v, z = -gap + v t plus a swing; contact comes after many round trips
def test_a_late_contact_is_found():
    scheme = upwind(rod_with(0.0), 2000)
    flight = free_flight(scheme, np.append(np.full(4000, 1.5), -0.02))  # uniform waves stay: z = -0.02 + 1.5 t
    assert first_contact(flight, 1.0) == pytest.approx(0.02 / 1.5, rel=1e-11)
    assert first_contact(flight, 0.0133) is None


def test_contact_at_the_start_is_contact():
    assert first_contact(free_flight(upwind(rod_with(1.0, gap=-1.0), 5), PAPER.scenario), 1.0) == 0.0


def growing(t):
    return free_flight(upwind(rod_with(-0.5), 4), np.ones(9)).state(t)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: free_flight(upwind(PAPER.rod, 3), np.ones(6)), r"shape \(6,\).*give a state \(7,\)"),
        (lambda: free_flight(upwind(PAPER.rod, 3), np.full(7, np.nan)), "not finite"),
        (
            lambda: free_flight(
                upwind(PAPER.rod, 3), Scenario(force=Expression.parse("1", variables=("t",), field="g"))
            ),
            "takes no loads",
        ),
        (lambda: free_flight(upwind(PAPER.rod, 3), np.ones(7)).state(-1.0), r"time is -1\.0"),
        (lambda: free_flight(upwind(PAPER.rod, 3), np.ones(7)).state(math.inf), "time is inf"),
        (lambda: free_flight(upwind(PAPER.rod, 3), np.ones(7)).state(1.0, way="fft"), "give auto, modes or poisson"),
        (lambda: free_flight(upwind(PAPER.rod, 3), np.ones(7)).state(1e12, way="poisson"), "too wide a window"),
        (lambda: first_contact(free_flight(upwind(PAPER.rod, 3), np.ones(7)), 0.0), r"until is 0\.0"),
        (lambda: growing(1e6), "grown beyond"),
    ],
)
def test_what_cannot_be_answered_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_the_initial_state_is_the_scenario_s():
    scheme = upwind(PAPER.rod, 12, ordering="eq48")
    assert np.allclose(
        free_flight(scheme, PAPER.scenario).state(0.0), initial_state(scheme, PAPER.scenario), atol=1e-14
    )
    assert paper_rod() == PAPER.rod
