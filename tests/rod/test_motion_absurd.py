"""lure.rod.motion on absurd but legal inputs: right, checked against something, or refused in one sentence."""

import math
import re
from fractions import Fraction

import numpy as np
import pytest
from depth import rarely
from motions import imbalance, other_rod, unit_rod

from lure import AssumptionError, InputError
from lure.rod import Scenario
from lure.rod.motion import Boundary, Numerics, exact_motion

LOADED = Scenario.parse(force="0.4*sin(1.3*t)", displacement="0.1*x*(2-x)", velocity="0.2*cos(x)")
RIGID = Boundary(rigid=True)


def finite(motion, count=60):
    """Values at the end of the rod, all of them finite."""
    t = np.linspace(motion.since, motion.until, count)
    for values in (motion.z(t), motion.contact_stress(t), motion.end_velocity(t)):
        assert np.isfinite(values).all()
    return motion.z(t)


# A stress of z/eps <= 1e-9 changes the motion by no more than that times d T per transit.
@pytest.mark.parametrize("eps", ["1e12", "1e100", "1e300"])
def test_an_obstacle_of_nothing_is_no_obstacle(eps):
    free = exact_motion(other_rod(gap=99), LOADED, 20.0)
    soft = exact_motion(other_rod(compliance=Fraction(eps)), LOADED, 20.0)
    assert finite(soft) + 0.1 == pytest.approx(finite(free) + 99, abs=1e-9)


@pytest.mark.parametrize("eps", ["1e-13", "1e-100", "1e-300"])
def test_an_obstacle_of_everything_is_rigid_and_said_to_be(eps):
    stiff = exact_motion(other_rod(compliance=Fraction(eps)), LOADED, 20.0)
    assert "counts as rigid" in stiff.note
    assert np.array_equal(finite(stiff), finite(exact_motion(other_rod(), LOADED, 20.0, boundary=RIGID)))


# Linear gain, gap 0: the motion is of the first degree in the data, whatever their size.
@pytest.mark.parametrize("size", ["1e-300", "1e-150", "1e80", "1e99"])
@pytest.mark.parametrize("boundary", [Boundary(), RIGID])
def test_the_size_of_the_data_is_a_unit_and_no_more(size, boundary):
    one, other = (
        exact_motion(
            other_rod(gap=0), Scenario.parse(force=f"{n}*sin(t)", velocity=f"{n}*cos(x)"), 8.0, boundary=boundary
        )
        for n in (1, size)
    )
    assert len(one.impacts) == len(other.impacts) == 1
    assert finite(other) / float(size) == pytest.approx(finite(one), abs=1e-12)


# Time, length and mass may be measured in any unit: c, Z and d change, the numbers of the motion do not.
@pytest.mark.parametrize(("modulus", "density"), [(1e-16, 1), (1e18, 1), (1e40, 1e-40), (1e-8, 1e8), (1, 1e300)])
def test_transits_of_hours_or_nanoseconds_are_transits(modulus, density):
    one, T = exact_motion(unit_rod(gap=0.1), Scenario.parse(velocity="1 + x"), 9.0), math.sqrt(density / modulus)
    stiffness = math.sqrt(density * modulus) / T  # d/eps T = 1
    rod = unit_rod(youngs_modulus=modulus, density=density, gap=0.1, compliance=1 / stiffness)
    other = exact_motion(rod, Scenario.parse(velocity=f"{1 / T!r}*(1 + x)"), 9 * T)
    assert len(one.impacts) == len(other.impacts) == 1
    assert finite(other) == pytest.approx(finite(one), abs=1e-13)
    assert other.impacts[0].end / T == pytest.approx(one.impacts[0].end, rel=1e-13)


@pytest.mark.parametrize("gap", ["-1e10", "-1", "-1e-3", "0", "1e-300", "1e-17", "1e10", "1e200"])
def test_any_gap(gap):
    motion = exact_motion(other_rod(gap=Fraction(gap)), LOADED, 6.0)
    z = finite(motion)
    assert z[0] == pytest.approx(-float(gap), rel=1e-14)
    assert bool(motion.impacts) == (float(gap) < 1)
    if float(gap) < 0:
        assert motion.impacts[0].start == 0
    if abs(float(gap)) < 1e3:
        assert imbalance(motion) < 1e-11


# k = 1e300 is a clamp; k = 1e-300 is none; k near -Z sends back 2/(1 + k) times what arrives, until it is too much.
def test_any_dashpot():
    clamped = exact_motion(other_rod(), LOADED, 9.0, boundary=Boundary(clamped=True))
    for k in ("1e300", "-1e300", "1e18"):
        assert finite(exact_motion(other_rod(damping=Fraction(k)), LOADED, 9.0)) == pytest.approx(
            finite(clamped), abs=1e-13
        )
    undamped = finite(exact_motion(other_rod(damping=0), LOADED, 9.0))
    assert finite(exact_motion(other_rod(damping=Fraction("1e-300")), LOADED, 9.0)) == pytest.approx(
        undamped, abs=1e-13
    )
    rod = other_rod(damping=Fraction("-0.999999"))
    assert rod.reflection == pytest.approx(-1999999, rel=1e-9)
    assert imbalance(exact_motion(rod, LOADED, 6.0)) < 1e-9
    with pytest.raises(InputError, match=r"the wave in round trip \d+ is .* more than 1e\+100"):
        exact_motion(other_rod(damping=Fraction("-0.999999999999999")), LOADED, 60.0)


def test_a_thread_and_an_end_dashpot_without_measure():
    thin = exact_motion(
        other_rod(area=Fraction("1e-300"), damping=0), Scenario.parse(force="1e-300*sin(t)", velocity="0.2"), 9.0
    )
    thick = exact_motion(other_rod(area=1, damping=0), Scenario.parse(force="sin(t)", velocity="0.2"), 9.0)
    assert finite(thin) == pytest.approx(finite(thick), abs=1e-13)
    held = exact_motion(other_rod(), LOADED, 9.0, boundary=Boundary(end_damping=1e300))
    assert finite(held) == pytest.approx(-0.1, abs=1e-15)


@pytest.mark.parametrize("until", [1e-9, 1e-3, 0.5, 1.0, math.nextafter(2, 0), 2.0, math.nextafter(2, 3), 4.0, 6.0])
@pytest.mark.parametrize("boundary", [Boundary(), RIGID])
def test_any_end_agrees_with_a_longer_motion(until, boundary):
    short, long = (exact_motion(other_rod(), LOADED, u, boundary=boundary) for u in (until, 7.3))
    t = np.linspace(0, until, 33)
    finite(short)
    assert short.z(t) == pytest.approx(long.z(t), abs=1e-14)
    assert short.contact_stress(t[:-1]) == pytest.approx(long.contact_stress(t[:-1]), abs=1e-12)


# T = 0.0505..: six transits come out as 6.000000000000001 of them.
def test_a_whole_number_of_round_trips_in_awkward_units():
    rod = unit_rod(youngs_modulus=884.56806745267, density=2.2607, gap=0.2)
    for trips in (2, 3, 5, 6, 7, 10, 12):
        motion = exact_motion(rod, Scenario.parse(velocity="1"), trips * rod.travel_time)
        finite(motion)
        assert all(len(window.wave) for window in motion.fields.windows)


# Places that formulas hide: a jump of strain at sqrt(2), a hat 1/50 wide, a spike, endless slopes.  u(L, t) is known by
# d'Alembert before the first echo: u0(L - ct) - u0 terms for v = 0, 1/c int u1 for u0 = 0.
@pytest.mark.parametrize(
    ("displacement", "velocity"),
    [
        ("0.01*abs(x - sqrt(2))", "0"),
        ("0.01*where(x*x < 2, x, sqrt(2))", "0"),
        ("0.01*max(0, 1 - abs(x - 1.2345)*50)", "0"),
        ("0.01*max(0, 1 - abs(x/2 - 0.5)*4.923796972836177)", "0"),
        ("0.01*exp(-((x - 0.7)*300)**2)", "0"),
        ("0.01*exp(-1000000*x)", "0"),
        ("0", "0.01*sqrt(x)"),
        ("0", "0.01*max(sin(5*x), 0.3)"),
        ("0", "0.01*sign(cos(7*x))"),
    ],
)
def test_hidden_kinks_and_narrow_features_of_the_initial_data(displacement, velocity):
    rod, scenario = other_rod(gap=40), Scenario.parse(displacement=displacement, velocity=velocity)
    motion = exact_motion(rod, scenario, 1.0)
    t = np.sort(np.random.default_rng(3).uniform(0, 1, 301))
    u0 = scenario.displacement
    nodes = np.linspace(0, 2, 2_000_001)
    travelled = np.concatenate(([0.0], np.cumsum(scenario.velocity(x=(nodes[1:] + nodes[:-1]) / 2)) * 1e-6))
    brought = (travelled[-1] - np.interp(2 - 2 * t, nodes, travelled)) / 2
    assert motion.end_displacement(t) == pytest.approx(u0(x=2 - 2 * t) + brought, abs=5e-14 + 6e-9 * (velocity != "0"))


def test_an_endless_slope_is_met_within_the_error_reported():
    motion = exact_motion(other_rod(gap=40), Scenario.parse(displacement="0.1*sqrt(x)"), 1.0)
    t = np.linspace(0, 1, 501)
    error = np.abs(motion.end_displacement(t) - 0.1 * np.sqrt(2 - 2 * t)).max()
    assert 1e-12 < error <= motion.error < 1e-7


# For t - T of the matched rod z' = g(t - T), so that u(t, L) is the integral of g.
@pytest.mark.parametrize(
    ("force", "integral"),
    [
        ("where(t < 1, 1, 0)", lambda s: np.minimum(s, 1)),
        ("where(t < 2, 1, -1)", lambda s: np.where(s < 2, s, 4 - s)),
        ("where(t < 3, 0, 1)", lambda s: np.maximum(s - 3, 0)),
        ("t**0.5", lambda s: s**1.5 / 1.5),
        ("abs(t - pi)**0.5", lambda s: (math.pi**1.5 - np.sign(math.pi - s) * np.abs(math.pi - s) ** 1.5) / 1.5),
        ("max(0, 1 - 200*abs(t - 1.7321))", lambda s: np.where(s < 1.72, 0, np.where(s > 1.74, 0.005, np.nan))),
        ("sin(3000*t)", lambda s: (1 - np.cos(3000 * s)) / 3000),
        ("sign(sin(9*t))", lambda s: np.arccos(np.cos(9 * s)) / 9),
        (
            "min(t, exp(-t))",
            lambda s: np.where(s < 0.567, s**2 / 2, 0.5671432904097838**2 / 2 + 0.5671432904097838 - np.exp(-s)),
        ),
    ],
)
def test_forces_with_edges_anywhere_and_of_any_speed(force, integral):
    motion = exact_motion(unit_rod(damping=1, gap=40), Scenario.parse(force=force), 7.0)
    t = np.linspace(1, 7, 331)
    expected = integral(t - 1)
    known = np.isfinite(expected)
    assert motion.end_displacement(t[known]) == pytest.approx(expected[known], abs=2e-13)
    assert motion.error < 1e-10


@pytest.mark.parametrize(
    ("arguments", "refusal"),
    [
        ({"scenario": Scenario.parse(force="sin(1000000*t)")}, InputError),
        ({"scenario": Scenario.parse(force="1/(t - 0.5)")}, InputError),
        ({"scenario": Scenario.parse(velocity="1e101*x")}, InputError),
        ({"scenario": Scenario.parse(body_force="exp(1000*t)")}, InputError),
        ({"until": 1e-10}, InputError),
        ({"until": 5e-324}, InputError),
        ({"until": True}, InputError),
        ({"until": "3"}, InputError),
        ({"until": -math.inf}, InputError),
        ({"rod": {"gap": -1}, "boundary": RIGID}, InputError),
        ({"rod": {"exponent": Fraction("0.01")}}, AssumptionError),
        ({"rod": {"exponent": 2, "compliance": Fraction("1e-300")}}, AssumptionError),
    ],
)
def test_what_cannot_be_done_is_refused_in_one_sentence(arguments, refusal):
    with pytest.raises(refusal) as caught:
        exact_motion(
            other_rod(**arguments.get("rod", {})),
            arguments.get("scenario", LOADED),
            arguments.get("until", 6.0),
            boundary=arguments.get("boundary"),
        )
    assert re.search(r"give|change|follow", str(caught.value))
    assert "\n" not in str(caught.value)


@pytest.mark.slow_for("0.2-0.2", "0.2-1.1")
@pytest.mark.parametrize("exponent", rarely(["0.2", "0.3", "0.9", "1.1", "10", "50", "500"], "0.3", "0.9"))
@pytest.mark.parametrize("eps", ["0.2", "1e20", "1e300"])
def test_any_power_at_any_compliance_that_doubles_resolve(exponent, eps):
    motion = exact_motion(other_rod(exponent=Fraction(exponent), compliance=Fraction(eps)), LOADED, 6.0)
    finite(motion)
    assert motion.impacts
    assert imbalance(motion) < 1e-11


@pytest.mark.parametrize("compiled", [True, False])
def test_an_end_too_deep_for_its_energy_is_refused(compiled):
    with pytest.raises(InputError, match=r"^initial.u0 and rod.gap put the end at z = 1e\+160 m"):
        exact_motion(unit_rod(gap=0), Scenario.parse(displacement="1e160"), 1.0, numerics=Numerics(compiled=compiled))
