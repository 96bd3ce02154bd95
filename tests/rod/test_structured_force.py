"""lure.rod.scheme with a force: the forced scheme against matrix exponentials, the other simulation and its
energy."""

import math
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from depth import rarely, sampled
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from lure import InputError
from lure.analysis.rod.energy import discrete_energy
from lure.analysis.rod.paper.runs import HarmonicForce, ModalBasis, modal_run
from lure.analysis.rod.simulation import simulate
from lure.expressions import Expression
from lure.expressions.exponentials import exponentials
from lure.rod import Rod, Scenario, builtin_system, initial_state, upwind
from lure.rod.scheme import structured_motion
from lure.rod.scheme.loads import force_of
from lure.rod.scheme.poisson import mean_of, poisson_weights

RELEASE = "0.0001 - 0.0002*x"
FIGURE_8 = builtin_system("paper-rod-figure-8").rod
FORCES = (
    "3e-5",
    "2e-5 if t < 0.0004 else (-1e-5 if t < 0.001 else 4e-5)",
    "2e-2*sin(4000*t)",
    "0.01*t*exp(-700*t)*cos(900*t + 1)",
    "30*(t - 0.001)**2 + max(0, 0.05*t - 1e-5)",
)


def rod_with(k=2e-4, gap=2e-5, compliance=1e-9):
    constants = {"youngs_modulus": 288e6, "density": 8, "length": 1, "area": 0.25e-4}
    return Rod(**constants, damping=k, compliance=compliance, gap=gap)


def formula(text):
    return Expression.parse(text, variables=("t",), field="force.g")


# what a sum means is what the formula says: on a piece, and past its end by continuation
@pytest.mark.parametrize(
    ("text", "inside", "continued"),
    [
        ("2*sin(4*t)", 1, "2*sin(4*t)"),
        ("exp(1 - 2*t)*cos(3*t + 1)**2*(t + 1)**3/7", 1, "exp(1 - 2*t)*cos(3*t + 1)**2*(t + 1)**3/7"),
        ("abs(t - 2) + min(t, 3) - sign(t - 5)", 4, "(t - 2) + 3 + 1"),
        ("where(t < 1 or t > 2, exp(t), -t**2)", Fraction(3, 2), "-t**2"),
        ("-(t - t) + sqrt(2)*pi*sin(t - t)", 1, "0"),
        ("exp(t - t) + tan(1)", 1, "1 + tan(1)"),
        ("max(t, 1)", Fraction(1, 2), "1"),
    ],
)
def test_a_formula_is_the_sum_of_its_exponentials(text, inside, continued):
    terms = exponentials(formula(text).tree, "t", Fraction(inside))
    t = np.linspace(-1.0, 7.0, 50)
    total = sum((weight * t**power * np.exp(rate * t) for (rate, power), weight in terms.items()), np.zeros(50))
    assert np.allclose(total, formula(continued)(t=t), rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize(
    "text", ["tanh(t)", "sin(t**2)", "exp(sin(t))", "1/(t + 1)", "sqrt(t)", "t**9", "t**(1/2)", "exp(800)*t", "tan(t)"]
)
def test_what_is_no_sum_of_exponentials_is_none(text):
    assert exponentials(formula(text).tree, "t", Fraction(1)) is None


# the average of what enters the register is the force itself, at any instant of the piece
@given(tau=st.floats(0, 300), start=st.integers(0, 10_000), force=st.sampled_from((0, 2, 3, 4)))
def test_the_average_of_the_sequence_is_the_force(tau, start, force):
    scheme = upwind(rod_with(), 100)
    found = force_of(scheme, formula(FORCES[force]), 1.0)
    clock = Fraction(start) + scheme.rate * Fraction(1, 4000)
    if tau > found.reach(clock):
        return
    first, weights = poisson_weights(mean_of(1.0, tau))
    average = float(weights @ found.entering(clock, first + weights.size)[first:])
    t = float(clock / Fraction(scheme.rate)) + np.linspace(0.0, tau, 20) / scheme.rate
    values = 2.0 * scheme.rod.input_gain * formula(FORCES[force])(t=t)
    assert average == pytest.approx(values[-1], abs=1e-12 * max(np.abs(values).max(), 1e-5))


# y' = A y + b2 g with g' = [[0, w], [-w, 0]] g, the matrices as the scheme assembles them; the end stays clear
# of the
# obstacle, or (pressed) in contact all along
@given(
    k=st.one_of(st.sampled_from((0.0, 1.2)), st.floats(0, 5)),
    N=st.integers(1, 15),
    omega=st.integers(0, 4000),
    trips=st.floats(0.01, 6),
    pressed=st.booleans(),
    form=st.sampled_from(("corrected", "as-printed")),
)
@example(k=0.0, N=3, omega=0, trips=6.0, pressed=False, form="corrected")
@settings(max_examples=sampled(12, of=40))
def test_forced_flight_and_forced_contact_are_the_augmented_exponential(k, N, omega, trips, pressed, form):
    gap, amplitude = (-1.0, 1e-3) if pressed else (1.0, 1e-3)
    rod = rod_with(k, gap, compliance=2e-8 / N)
    scheme = upwind(rod, N, form=form)
    until = trips * 2.0 * rod.travel_time
    scenario = Scenario.parse(force=f"{amplitude!r}*cos({omega!r}*t + 0.3)", displacement=RELEASE)
    run = structured_motion(scheme, scenario, min(until, rod.travel_time / 2) if pressed else until, samples=2)
    n = scheme.order
    M = np.zeros((n + 2, n + 2))
    M[:n, :n] = scheme.A.toarray() - (rod.nonlinearity.stiffness * np.outer(scheme.b1, scheme.c) if pressed else 0.0)
    M[:n, n], M[n, n + 1], M[n + 1, n] = scheme.b2, -omega, omega
    start = np.concatenate((initial_state(scheme, scenario), amplitude * np.array([math.cos(0.3), math.sin(0.3)])))
    expected = (expm(run.t[-1] * M) @ start)[:n]
    assert run.contacts == (((0.0, run.t[-1]),) if pressed else ())
    scale = np.append(np.full(n - 1, max(1.0, np.abs(expected[:-1]).max())), 1.0)
    assert (np.abs(run.state - expected) / scale).max() < 1e-11


# other code on the same scheme: the force fitted by polynomials step by step, events by its own search
@pytest.mark.slow
@given(
    force=st.sampled_from(FORCES),
    gap=st.floats(-3e-4, 1.5e-4),
    N=st.sampled_from((30, 60, 150)),
    k=st.sampled_from((0.0, 2e-4, 0.4, 1.2, 30.0)),
    form=st.sampled_from(("corrected", "as-printed")),
)
@settings(max_examples=sampled(10, of=30))
def test_the_forced_motion_is_that_of_the_event_exact_simulation(force, gap, N, k, form):
    scheme = upwind(rod_with(k, gap), N, form=form)
    scenario = Scenario.parse(force=force, displacement=RELEASE)
    until = 9.3 * scheme.rod.travel_time
    run = simulate(scheme, scenario, until=until, samples=32)
    found = structured_motion(scheme, scenario, until, samples=32)
    assert np.abs(found.z - run.z).max() < 1e-9 * np.abs(run.z).max()
    assert len(found.contacts) == len(run.contacts)
    for (begin, end), contact in zip(found.contacts, run.contacts, strict=True):
        assert begin == pytest.approx(contact.start, abs=1e-8 * until)
        assert end == pytest.approx(contact.end, abs=1e-8 * until)


# Multiply row i of the scheme by y_i and telescope.  With e = -a y_2N + 2 b g what enters the forward wave and
# q = y_N - 2 d p what enters the backward one, each in front of its wave:
#   d/dt [(h/2c) sum y^2 + 2 d P(z)] = (e^2 - y_2N^2)/2 - sum of (differences)^2/2 over both waves,
# since what the nonlinearity takes at the end, (q^2 - y_N^2)/2 = -2 d p z', is what it stores.  Times A/(2d) it is a
# power.
@pytest.mark.slow
def test_the_energy_grows_by_the_work_of_the_force_less_what_is_lost():
    rod, N = rod_with(0.3, 1e-5), 12
    scheme = upwind(rod, N)
    force = formula("2e-2*sin(4000*t) + 1e-3")
    scenario = Scenario.parse(force=force.source, displacement=RELEASE)
    until = 2.0 * rod.travel_time
    run = structured_motion(scheme, scenario, until)
    assert run.contacts

    def power(t):
        y = structured_motion(scheme, scenario, t, samples=2).state
        entering = -rod.reflection * y[2 * N - 1] + 2.0 * rod.input_gain * float(force(t=t))
        forward = np.append(entering, y[:N])
        backward = np.append(y[N - 1] - 2.0 * rod.mobility * float(rod.nonlinearity(y[-1])), y[N : 2 * N])
        lost = (np.diff(forward) ** 2).sum() + (np.diff(backward) ** 2).sum()
        return 0.5 * (entering**2 - y[2 * N - 1] ** 2 - lost)

    nodes, weights = np.polynomial.legendre.leggauss(12)
    edges = sorted({*np.linspace(0.0, until, 4).tolist(), *np.ravel(run.contacts).tolist()})
    work = 0.0
    for left, right in pairwise(edges):
        half, middle = 0.5 * (right - left), 0.5 * (right + left)
        work += half * sum(w * power(middle + half * x) for x, w in zip(nodes, weights, strict=True))
    change = float(discrete_energy(scheme, run.state) - discrete_energy(scheme, initial_state(scheme, scenario)))
    assert change == pytest.approx(rod.area / (2.0 * rod.mobility) * work, rel=1e-9)


# k v = g at rest: a constant force ends as the drift g/k of the whole rod, for every N
@pytest.mark.parametrize("N", rarely([5, 10, 3000], 3000))
def test_a_constant_force_ends_in_a_drift(N):
    scheme = upwind(rod_with(3.0, gap=10.0), N)
    run = structured_motion(scheme, Scenario.parse(force="0.6"), 0.5, samples=3)
    assert run.contacts == ()
    assert run.state[:-1] == pytest.approx(np.full(2 * N, 0.2), rel=1e-12)
    assert run.z[-1] - run.z[1] == pytest.approx(0.2 * 0.25, rel=1e-11)


# the force reaches the end through N cells, z ~ tau^(N+1) at first: contact begins where that leaves rounding behind
@pytest.mark.slow_for("90-0.0")
@pytest.mark.parametrize("k", [0.0, 1.2])
@pytest.mark.parametrize("N", [20, 90])
def test_a_rod_that_lies_against_its_obstacle_is_pushed(k, N):
    scheme, scenario = upwind(rod_with(k, gap=0.0), N), Scenario.parse(force="1e-3*(t + 1)")
    run = simulate(scheme, scenario, until=3e-3, samples=31)
    found = structured_motion(scheme, scenario, 3e-3, samples=31)
    assert len(found.contacts) == len(run.contacts)
    assert np.abs(found.z - run.z).max() < 1e-12 * run.z.max()


# figure 8 with the force that the correct b2 needs: contact after 0.68 s, for good; the other code uses eigenvectors
@pytest.mark.slow
def test_figure_8_with_the_corrected_force():
    scheme = upwind(FIGURE_8, 60)
    scenario = Scenario.parse(force="(2/60000)*sin(4*t)", displacement=RELEASE)
    run = structured_motion(scheme, scenario, 2.0, samples=201)
    force = HarmonicForce(amplitude=2 / 60000, omega=4.0)
    basis = ModalBasis(FIGURE_8, 60)
    again = modal_run(basis, Scenario.parse(displacement=RELEASE), force, form="corrected", until=2.0)
    assert np.abs(run.z - again.z[::10]).max() < 1e-11
    ((begin, end),) = run.contacts
    assert begin == pytest.approx(again.contacts[0][0], abs=1e-9)
    assert end == 2.0


@pytest.mark.slow_for("scenario2-beyond the range of ")
@pytest.mark.parametrize(
    ("scenario", "message"),
    [
        (
            Scenario.parse(force="tanh(t)"),
            r"exp, sin and cos of straight lines.*lure\.analysis\.rod\.simulation\.simulate",
        ),
        (
            Scenario.parse(force="where(sin(t) > 0, 1, 0)"),
            r"where its pieces meet.*lure\.analysis\.rod\.simulation\.simulate",
        ),
        (Scenario.parse(force="exp(20000*t)"), r"beyond the range of doubles after 0\.03\d+ s; give an earlier end"),
        (Scenario.parse(body_force="x"), r"force\.f is x; structured_motion takes no body force; lure"),
        # s = 6000 * 50 = 3e5 1/s: 6e5 1/s need more than 100 cells
        (Scenario.parse(force="sin(600000*t)"), "faster than the 50 cells are crossed; give at least 101 cells"),
    ],
)
def test_loads_that_are_not_taken_are_refused(scenario, message):
    with pytest.raises(InputError, match=message):
        structured_motion(upwind(rod_with(), 50), scenario, 0.05)
