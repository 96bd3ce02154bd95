"""The scheme by general integrators: the same equations, the same motion, and no contact skipped."""

import sys
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from depth import rarely, sampled
from hypothesis import given, settings
from hypothesis import strategies as st

from lure import InputError
from lure.analysis.rod.comparison import SCHEME_METHODS, integrate
from lure.analysis.rod.comparison.legs import BAND, SchemeEquations
from lure.analysis.rod.simulation import simulate
from lure.rod import Rod, Scenario, builtin_system, upwind
from lure.rod.systems import paper_rod, rod_from_exact

RELEASE = builtin_system("paper-rod").scenario
T = paper_rod().travel_time
GENERAL = tuple(method for method in SCHEME_METHODS if method != "exact")
QUICK = ("DOP853", "LSODA", "CVODE")
CVODE = tuple(method for method in GENERAL if method.startswith("CVODE"))


def paper(**changes):
    """The paper's rod with other exact decimals."""
    return rod_from_exact({**paper_rod().exact, **{name: Fraction(value) for name, value in changes.items()}})


LOADED = Scenario.parse(force="max(0.2, 0.3 - 1000*t)*sin(4000*t)", body_force="2*x*sin(3000*t)", velocity="0.1*x")
MOTIONS = {
    "free": (paper(), RELEASE, 6e-4),
    "contact": (paper(gap="5e-5", compliance="1e-9", damping="0.3"), RELEASE, 5e-4),
    "stiff": (paper(gap="5e-5", compliance="1e-12", damping="0.3"), RELEASE, 5e-4),
    "power law": (paper(gap="5e-5", compliance="1e-13", damping="0.3", exponent="3/2"), RELEASE, 5e-4),
    "loads": (paper(gap="5e-5", compliance="1e-9", damping="0.3"), LOADED, 1.1e-3),
    "pressed": (paper(gap="-1e-5", compliance="1e-10", damping="0.3"), RELEASE, 5e-4),
}


@cache
def exact_of(name):
    """The motion of a case by the event-exact simulation."""
    rod, scenario, until = MOTIONS[name]
    return simulate(upwind(rod, 12), scenario, until=until, samples=61)


# the equations --------------------------------------------------------------------------------------------------------


@given(
    cells=st.integers(1, 6),
    form=st.sampled_from(["corrected", "as-printed"]),
    damping=st.floats(0, 3),
    seed=st.integers(0, 2**32 - 1),
)
@settings(max_examples=40, deadline=None)
def test_the_folded_equations_are_those_of_the_block(cells, form, damping, seed):
    # y' = A y + b1 mu + b2 g + f/(rho A) with A, b1, b2 of the block, put together from cloning templates
    draw = np.random.default_rng(seed)
    rod = Rod(youngs_modulus=4, density=1, length=2, area=0.5, damping=damping, compliance=0.2, gap=0.1)
    scheme = upwind(rod, cells, form=form)
    equations = SchemeEquations(scheme=scheme, scenario=Scenario.parse(force="1.5 + t", body_force="x*(2 + t)"))
    y = draw.normal(size=2 * cells + 1)
    x = rod.length * np.arange(cells + 1) / cells
    body = np.concatenate((x[1:], x[-2::-1], [0.0])) * 2.5 / (rod.density * rod.area)
    for touching in (False, True):
        mu = -y[-1] / rod.compliance if touching else 0.0
        expected = scheme.A @ y + scheme.b1 * mu + scheme.b2 * 2.0 + body
        found = equations.rate(0.5, y[equations.fold], touching=touching, span=(0.0, 1.0))
        assert found == pytest.approx(expected[equations.fold], rel=1e-12, abs=1e-11)
        assert equations.unfolded(y[equations.fold]) == pytest.approx(y, abs=0)


@pytest.mark.parametrize("cells", [1, 2, 7])
@pytest.mark.parametrize("exponent", [1, 2])
@pytest.mark.parametrize("touching", [False, True])
def test_the_jacobian_is_that_of_the_equations_and_banded(cells, exponent, touching):
    rod = Rod(youngs_modulus=4, density=1, length=2, area=0.5, damping=0.3, compliance=0.2, gap=0.1, exponent=exponent)
    equations = SchemeEquations(scheme=upwind(rod, cells), scenario=Scenario.parse())
    y = np.linspace(0.4, 1.3, 2 * cells + 1)

    def rate(state):
        return equations.rate(0.0, state, touching=touching, span=(0.0, 1.0))

    # the rates are at most quadratic in the state, so central differences are exact to rounding
    steps = 1e-3 * np.eye(y.size)
    differences = np.array([(rate(y + step) - rate(y - step)) / 2e-3 for step in steps]).T
    found = equations.jacobian(y, touching=touching).toarray()
    assert found == pytest.approx(differences, abs=1e-9)
    rows, columns = np.nonzero(found)
    assert np.abs(rows - columns).max() <= BAND


# the motion -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("method", "name"),
    [
        pytest.param(method, name, marks=[pytest.mark.thorough] * (name != "contact" and method not in QUICK))
        for method in GENERAL
        for name in MOTIONS
    ],
)
def test_every_integrator_gives_the_motion_of_the_event_exact_one(method, name):
    rod, scenario, until = MOTIONS[name]
    exact, found = exact_of(name), integrate(upwind(rod, 12), scenario, until, method=method, samples=61)
    amplitude = float(np.ptp(exact.z)) / 2
    assert np.abs(found.z - exact.z).max() < 2e-6 * amplitude
    assert np.abs(found.energy - exact.energy).max() < 2e-6 * exact.energy.max()
    assert len(found.contacts) == len(exact.contacts)
    for (start, end), contact in zip(found.contacts, exact.contacts, strict=True):
        assert (start, end) == pytest.approx((contact.start, contact.end), abs=1e-4 * T)


@pytest.mark.parametrize("name", ["free", "stiff"])
def test_the_velocity_is_the_derivative_of_z(name):
    # the trapezoidal rule on 4000 steps: its error for a wave smooth over a cell, 1/s = 1.4e-5 s, is far below 1e-3
    rod, scenario, until = MOTIONS[name]
    found = integrate(upwind(rod, 12), scenario, until, method="DOP853", samples=4001)
    travel = np.concatenate(([0.0], np.cumsum(0.5 * np.diff(found.t) * (found.velocity[1:] + found.velocity[:-1]))))
    assert np.abs(found.z - found.z[0] - travel).max() < 1e-3 * np.ptp(found.z)


@pytest.mark.parametrize("method", rarely(GENERAL, "Radau"))
def test_a_tighter_tolerance_brings_a_smaller_error(method):
    rod, scenario, until = MOTIONS["contact"]
    runs = [integrate(upwind(rod, 12), scenario, until, method=method, rtol=rtol, samples=61) for rtol in (1e-4, 1e-9)]
    errors = [np.abs(run.z - exact_of("contact").z).max() for run in runs]
    assert errors[1] < 1e-3 * errors[0]


def test_the_absolute_tolerance_is_the_users_if_given():
    rod, scenario, until = MOTIONS["free"]
    runs = [integrate(upwind(rod, 12), scenario, until, method="RK45", atol=atol, samples=3) for atol in (1.0, 1e-12)]
    assert runs[0].steps < runs[1].steps  # 1 m/s is more than any wave here: 1.2 m/s is their largest


def test_longer_steps_are_taken_where_they_are_allowed():
    # at rest after 1 ms; a quarter of a transit is 4.2e-5 s, so 0.1 s takes 2400 steps at least
    short, long = (integrate(upwind(paper(), 4), RELEASE, 0.1, longest_step=step, samples=3) for step in (None, 0.01))
    assert short.steps > 2400 > 2 * long.steps
    assert np.abs(short.z - long.z).max() < 1e-9


@pytest.mark.parametrize("method", rarely(GENERAL, "Radau", "BDF"))
@pytest.mark.parametrize(("shift", "contacts"), [(-1e-6, 1), (1e-6, 0)])
def test_a_contact_that_only_just_happens_is_found_and_none_besides(method, shift, contacts):
    # the highest point of the free motion, 1e-6 of the amplitude above or below the obstacle
    free = exact_of("free")
    peak = free.max_gap_coordinate + 0.02
    rod = paper(gap=Fraction(peak * (1.0 + shift)), compliance="1e-9")
    found = integrate(upwind(rod, 12), RELEASE, 3e-4, method=method, rtol=1e-10, samples=4)
    exact = simulate(upwind(rod, 12), RELEASE, until=3e-4, samples=4)
    assert len(found.contacts) == len(exact.contacts) == contacts
    for (start, end), contact in zip(found.contacts, exact.contacts, strict=True):
        assert end - start == pytest.approx(contact.end - contact.start, rel=0.05)


@pytest.mark.parametrize("method", rarely(GENERAL, "Radau"))
def test_a_pulse_after_a_long_rest_is_not_stepped_over(method):
    # from rest, 0.2 N for a fortieth of a transit after 40 transits
    pulse = Scenario.parse(force=f"0.1*(sign(t - {40 * T!r}) - sign(t - {40.025 * T!r}))")
    rod = paper(gap="1", damping="0.3")
    exact = simulate(upwind(rod, 8), pulse, until=43 * T, samples=44)
    found = integrate(upwind(rod, 8), pulse, 43 * T, method=method, samples=44)
    assert np.ptp(exact.z) > 1e-7
    assert np.abs(found.z - exact.z).max() < 1e-5 * np.ptp(exact.z)


@given(
    damping=st.floats(0, 3),
    gap=st.floats(0.0, 0.5),
    stiffness=st.floats(0.1, 300),
    slope=st.floats(-1, 1),
    kick=st.floats(-1, 1),
    method=st.sampled_from(["DOP853", "Radau", "LSODA"]),
)
@settings(max_examples=sampled(4, of=15), deadline=None)
def test_energy_never_rises_and_the_exact_scheme_agrees(damping, gap, stiffness, slope, kick, method):
    rod = Rod(
        youngs_modulus=1, density=1, length=1, area=1, damping=damping, compliance=1 / stiffness, gap=gap + abs(slope)
    )
    scenario = Scenario.parse(displacement=f"{slope!r}*x", velocity=f"{kick!r}*(1 - x)")
    found = integrate(upwind(rod, 6), scenario, 6.0, method=method, samples=101)
    exact = integrate(upwind(rod, 6), scenario, 6.0, method="exact", samples=101)
    size = max(abs(slope), abs(kick))
    assert np.abs(found.z - exact.z).max() <= 1e-5 * size
    assert np.diff(found.energy).max() <= 1e-6 * found.energy[0]


def test_the_last_state_comes_in_the_ordering_of_the_scheme():
    rod, scenario, until = MOTIONS["contact"]
    states = {
        ordering: integrate(upwind(rod, 12, ordering=ordering), scenario, until, method="DOP853").state
        for ordering in ("eq39", "eq48")
    }
    assert states["eq48"] == pytest.approx(states["eq39"][upwind(rod, 12, ordering="eq48").permutation], abs=0)


# d'Alembert: a force g at x = 0 sends w = g/(E A), which the free end doubles: u(t, L) = 2 c g (t - T)/(E A) up to 3 T
def test_above_1000_cells_the_exact_method_takes_a_force():
    rod = paper()
    T, end = rod.travel_time, 1.8 * rod.travel_time
    run = integrate(upwind(rod, 1001), Scenario.parse(force="1e-3"), end, method="exact", samples=10)
    pushed = 2 * 1e-3 * rod.mobility / rod.area * (run.t - T)
    assert run.u_end[run.t > 1.3 * T] == pytest.approx(pushed[run.t > 1.3 * T], rel=1e-3)
    assert run.u_end[run.t < 0.9 * T] == pytest.approx(0, abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("force", [0, "3*sin(20000*t)"])
def test_above_1000_cells_the_structured_motion_is_the_exact_one(force):
    start = Scenario.parse(displacement="0.0001 - 0.0002*x", force=force)
    scheme = upwind(paper(gap="5e-5", compliance="1e-9", damping="0.3"), 1010, ordering="eq48")
    exact = integrate(scheme, start, 1.4e-4, method="exact", samples=16)
    found = integrate(scheme, start, 1.4e-4, method="LSODA", samples=16)
    assert exact.energy is None
    assert exact.steps is None
    assert np.abs(found.z - exact.z).max() < 1e-10
    assert np.abs(found.velocity - exact.velocity).max() < 1e-5
    assert np.abs(found.state - exact.state).max() < 1e-5
    assert found.contacts[0][0] == pytest.approx(exact.contacts[0][0], abs=1e-9)


@pytest.mark.slow
def test_work_is_counted():
    rod, scenario, until = MOTIONS["free"]
    runs = {method: integrate(upwind(rod, 12), scenario, until, method=method, samples=61) for method in GENERAL}
    # an explicit method with s stages evaluates at least s times a step, an implicit multistep method at least once
    assert runs["RK45"].evaluations >= 6 * runs["RK45"].steps
    assert runs["DOP853"].evaluations >= 11 * runs["DOP853"].steps
    assert runs["LSODA"].evaluations >= runs["LSODA"].steps > 100
    assert all(runs[method].steps is None and runs[method].evaluations > 100 for method in CVODE)
    assert "61" not in str(runs["RK45"])
    assert f"{runs['RK45'].evaluations} evaluations" in str(runs["RK45"])


# refusals -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"method": "Euler"}, "method is 'Euler'; give one of exact, RK45"),
        ({"until": 0.0}, "until is 0.0; give a positive number"),
        ({"until": float("nan")}, "until is nan"),
        ({"until": 2e4}, 'fewer cells or method="exact"'),
        ({"samples": 1}, "samples is 1; give a whole number from 2"),
        ({"rtol": 1e-15}, "rtol is 1e-15; give a number from 1e-12"),
        ({"atol": 0.0}, "atol is 0.0; give a positive number in m/s"),
        ({"longest_step": -1.0}, "longest_step is -1.0; give a positive number in s"),
    ],
)
def test_what_cannot_be_run_is_refused_in_a_sentence(change, message):
    given_ = {"until": 1e-3, "method": "RK45", **change}
    until = given_.pop("until")
    with pytest.raises(InputError) as refusal:
        integrate(upwind(paper(), 10), RELEASE, until, **given_)
    assert message in str(refusal.value)


def test_a_body_force_on_very_many_cells_is_not_for_the_exact_method():
    with pytest.raises(InputError, match=r"takes no body force; .* takes any load, up to 1000 cells"):
        integrate(upwind(paper(), 1001), Scenario.parse(body_force=1), 1e-4, method="exact")


def test_a_load_that_is_not_finite_is_refused():
    with pytest.raises(InputError, match=r"force\.g is (inf|nan) at t"):
        integrate(upwind(paper(), 4), Scenario.parse(force="1/t"), 1e-4, method="RK45")


@pytest.mark.parametrize("method", CVODE)
def test_without_scikit_sundae_the_extra_is_named(monkeypatch, method):
    monkeypatch.setitem(sys.modules, "sksundae.cvode", None)
    with pytest.raises(InputError, match=r'needs scikit-sundae: pip install "lure\[cvode\]"'):
        integrate(upwind(paper(), 4), RELEASE, 1e-4, method=method)
