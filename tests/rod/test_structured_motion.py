"""lure.rod.scheme.structured_motion: the scheme against its obstacle, event to event."""

import math

import numpy as np
import pytest
from depth import sampled
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from lure import InputError
from lure.analysis.rod.energy import discrete_energy
from lure.analysis.rod.simulation import simulate
from lure.expressions import Expression
from lure.rod import Rod, Scenario, builtin_system, initial_state, upwind
from lure.rod.scheme import crossing, structured_motion
from lure.rod.scheme import motion as runs
from lure.rod.scheme.contact import EventFreeInterval, halved
from lure.rod.scheme.poisson import parted
from lure.rod.scheme.register import RegisterState, ShiftRegister

DATA = builtin_system("paper-rod").scenario


def rod_with(k, gap, compliance=3e-10, exponent=1):
    constants = {"youngs_modulus": 288e6, "density": 8, "length": 1, "area": 0.25e-4}
    return Rod(**constants, damping=k, compliance=compliance, exponent=exponent, gap=gap)


# in contact the scheme is linear: y' = (A - c_n b1 c) y, with b1 and c as lure.rod.discretisation assembles them
@given(k=st.just(0.0) | st.floats(1e-9, 5), N=st.integers(1, 20), share=st.floats(0, 1), seed=st.integers(0, 999))
def test_a_stretch_of_contact_is_the_matrix_exponential(k, N, share, seed):
    rod = rod_with(k, 0.0, compliance=2e-8 / N)  # kappa = 0.17
    scheme = upwind(rod, N)
    y = np.random.default_rng(seed).normal(size=2 * N + 1)
    kappa = rod.mobility * rod.nonlinearity.stiffness / scheme.rate
    start = RegisterState(register=ShiftRegister(scheme=scheme), waves=y[:-1], gap=float(y[-1]))
    press = EventFreeInterval(start=start, length=2 * N, kappa=kappa)
    tau = share * press.length
    closed = (scheme.A.toarray() - rod.nonlinearity.stiffness * np.outer(scheme.b1, scheme.c)) / scheme.rate
    scale = np.append(np.ones(2 * N), scheme.rate)
    expected = expm(tau * scale[:, None] * closed / scale) @ y
    after = press.after(parted(tau))
    assert np.abs(np.append(after.waves, after.gap) - expected).max() < 1e-12 * max(1.0, tau)
    assert np.allclose(press.end_at(parted(tau)), (expected[-1], expected[N - 1]), rtol=0, atol=1e-12 * max(1.0, tau))


# other code on the same scheme: Poisson tables step by step, events by its own search, N <= 1000
@pytest.mark.slow
@given(
    gap=st.floats(-3e-4, 1.5e-4),
    velocity=st.integers(-15, 15),
    N=st.sampled_from((30, 60, 150)),
    k=st.sampled_from((0.0, 2e-4, 0.4, 1.2, 30.0)),
    ordering=st.sampled_from(("eq39", "eq48")),
)
@settings(max_examples=sampled(12, of=30))
def test_the_motion_is_that_of_the_event_exact_simulation(gap, velocity, N, k, ordering):
    scenario = Scenario(
        displacement=DATA.displacement,
        velocity=Expression.parse(repr(velocity / 10), variables=("x",), field="initial.u1"),
    )
    scheme = upwind(rod_with(k, gap, compliance=1e-9), N, ordering=ordering)
    until = 9.3 * scheme.rod.travel_time
    run = simulate(scheme, scenario, until=until, samples=32)
    found = structured_motion(scheme, scenario, until, samples=32)
    assert np.abs(found.z - run.z).max() < 1e-10 * np.abs(run.z).max()
    assert len(found.contacts) == len(run.contacts)
    for (begin, end), seen in zip(found.contacts, run.contacts, strict=True):
        assert begin == pytest.approx(seen.start, abs=1e-9 * until)
        assert end == pytest.approx(seen.end, abs=1e-9 * until)
    z = np.flatnonzero(scheme.c)[0]
    assert found.state[z] == pytest.approx(found.z[-1], rel=1e-12, abs=1e-18)


# T: the rod strikes with velocity v a spring so stiff that it is a wall against 1/(d c_n): contact lasts a round trip,
# 2T, and it leaves with -v (a free rod against a wall, k = 0)
@pytest.mark.slow
def test_a_rod_that_hits_a_wall_turns_round_in_a_round_trip():
    rod = rod_with(0.0, 0.01, compliance=1e-12)
    T, N = rod.travel_time, 20_000
    scheme = upwind(rod, N)
    run = structured_motion(scheme, np.append(np.ones(2 * N), -0.01), 0.015, samples=16)
    ((begin, end),) = run.contacts
    assert begin == pytest.approx(0.01, rel=1e-9)
    assert end - begin == pytest.approx(2 * T, rel=0.03)
    assert run.state[:-1].mean() == pytest.approx(-1.0, rel=0.01)


@pytest.mark.slow
@given(gap=st.floats(-2e-4, 1e-4), N=st.integers(2, 4000), k=st.floats(0, 3))
@settings(max_examples=sampled(10, of=20))
def test_contact_gives_no_energy(gap, N, k):
    scheme = upwind(rod_with(k, gap, compliance=2e-9 if N > 10 else 1e-7), N)
    start = initial_state(scheme, DATA)
    energies = [float(discrete_energy(scheme, start))]
    for _ in range(4):
        start = structured_motion(scheme, start, 1.7 * scheme.rod.travel_time, samples=2).state
        energies.append(float(discrete_energy(scheme, start)))
    assert np.all(np.diff(energies) <= 1e-12 * energies[0])


def test_where_the_run_is_cut_does_not_matter():
    scheme = upwind(rod_with(2e-4, 2e-5), 3000)
    whole = structured_motion(scheme, DATA, 8e-4, samples=3)
    first = structured_motion(scheme, DATA, 4e-4, samples=2)
    second = structured_motion(scheme, first.state, 4e-4, samples=2)
    assert whole.contacts
    assert np.abs(second.state - whole.state)[:-1].max() < 1e-9
    assert whole.z[-1] == pytest.approx(second.z[-1], rel=1e-9)
    assert whole.z[1] == pytest.approx(first.z[-1], rel=1e-9)


# a spring softer than the rod, held by the dashpot: contact lasts the whole run
def test_a_run_that_ends_in_contact_says_so():
    scheme = upwind(rod_with(1e3, -1e-4, compliance=1e-7), 100)
    run = structured_motion(scheme, np.append(np.zeros(200), 1e-4), 2e-3, samples=5)
    assert run.contacts == ((0.0, 2e-3),)
    assert np.all(run.z > 0)
    assert np.ptp(run.z) > 1e-6


@pytest.mark.slow
def test_one_hundred_thousand_cells_in_contact():
    scheme = upwind(rod_with(2e-4, 0.0), 100_000)
    run = structured_motion(scheme, DATA, 5e-4, samples=11)
    coarse = structured_motion(upwind(scheme.rod, 50_000), DATA, 5e-4, samples=11)
    assert len(run.contacts) == len(coarse.contacts) == 1
    assert run.contacts[0][0] == pytest.approx(coarse.contacts[0][0], rel=1e-3)
    assert np.abs(run.z - coarse.z).max() < 0.01 * np.abs(run.z).max()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: structured_motion(upwind(rod_with(1, 0), 50), DATA, math.inf), "until is inf"),
        (lambda: structured_motion(upwind(rod_with(1, 0), 50), DATA, 1.0, samples=1), "samples is 1"),
        (lambda: structured_motion(upwind(rod_with(1, 0, exponent=2), 50), DATA, 1.0), "exponent is 2"),
        (lambda: structured_motion(upwind(rod_with(-0.1, 0), 50), DATA, 1.0), "takes no negative one"),
        # d c_n L/c = (1/48000) / 1e-12 / 6000 = 3472.2..; with so many cells the register gains 3.0 a round trip
        (lambda: structured_motion(upwind(rod_with(1, 0, 1e-12), 3472), DATA, 1.0), "give at least 3473$"),
        (lambda: structured_motion(upwind(rod_with(1, 0), 50), np.ones(3), 1.0), r"give a state \(101,\)"),
    ],
)
def test_what_cannot_be_moved_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


# matched dashpot, stiff spring: z falls by many powers of ten a round trip, far below the values of the register; it is
# contact for as long as rounding of the first values, 1e-16 of them, can tell
def test_a_contact_that_fades_is_followed_down_to_rounding():
    scheme = upwind(rod_with(1.2, -1e-5, compliance=1 / 2848348800.0), 11)
    until = 20 * scheme.rod.travel_time
    start = np.append(np.ones(22), 1e-9)
    found = structured_motion(scheme, start, until, samples=801)
    closed = scheme.A.toarray() - scheme.rod.nonlinearity.stiffness * np.outer(scheme.b1, scheme.c)
    step = expm(until / 800 * closed)
    states = [start]
    for _ in range(800):
        states.append(step @ states[-1])
    expected = np.array(states)[:, -1]
    assert np.abs(found.z - expected).max() < 1e-12 * expected.max()
    ((begin, end),) = found.contacts
    assert begin == 0.0
    assert end > found.t[expected > 1e-14 * expected.max()][-1]


# where the bounds settle too little, the stretch is halved until they do
def test_a_stretch_too_long_to_decide_is_halved(monkeypatch):
    scheme = upwind(rod_with(2e-4, 2e-5), 60)
    whole = structured_motion(scheme, DATA, 1e-3, samples=5)
    halvings = []
    monkeypatch.setattr(runs, "halved", lambda length: halvings.append(length) or halved(length))
    monkeypatch.setattr(crossing, "_EFFORT", 12)
    parts = structured_motion(scheme, DATA, 1e-3, samples=5)
    assert halvings
    assert len(parts.contacts) == len(whole.contacts) == 1
    assert parts.contacts[0] == pytest.approx(whole.contacts[0], rel=1e-11)
    assert np.abs(parts.z - whole.z).max() < 1e-12 * np.abs(whole.z).max()
    with pytest.raises(InputError, match="cannot be told from rounding"):
        halved(1)
