"""lure.rod.motion in its limits: rigid obstacle, grazing, dashpots that keep everything or take everything."""

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest
from motions import imbalance, other_rod, unit_rod
from scipy.optimize import brentq

from lure.rod import Scenario, builtin_system
from lure.rod.motion import Boundary, Numerics, exact_motion
from lure.rod.systems import rod_from_exact

THROWN = Scenario.parse(velocity="1")
LOADED = Scenario.parse(force="0.4*sin(1.3*t)", displacement="0.1*x*(2-x)", velocity="0.2*cos(x)")

# The bar thrown with v = 1 at p = z/eps (unit constants, k = 0, contact at t = 1/2, s = t - 5/2, e^(-2/eps) left out):
# z = eps (1 - e^-(t - 1/2)/eps) up to 5/2; then W = 2 e^(-s/eps) - 1 and z = -eps + (2 s + 2 eps) e^(-s/eps), which is
# zero at s = sigma eps with 2 sigma + 2 = e^sigma.  Free again, z = -s + eps (sigma + 2 e^-sigma); 2 e^-sigma = 1/(1 +
# sigma).  int p = 2 + eps [-1 - sigma + 4 - 2 e^-sigma (2 + sigma)] = 2 + eps (2 - sigma - 1/(1 + sigma)).
SIGMA = brentq(lambda s: 2 * s + 2 - math.exp(s), 1, 3)


@pytest.mark.parametrize("eps", ["1e-2", "1e-3", "1e-5", "1e-7", "1e-9"])
def test_the_rigid_limit_is_of_first_order_in_place_instant_and_impulse(eps):
    e = float(eps)
    rigid = exact_motion(unit_rod(gap=0.5), THROWN, 4.4, boundary=Boundary(rigid=True))
    motion = exact_motion(unit_rod(gap=0.5, compliance=Fraction(eps)), THROWN, 4.4)
    (impact,), (limit,) = motion.impacts, rigid.impacts
    assert (impact.start, limit.start) == pytest.approx((0.5, 0.5), abs=4e-16)
    assert (impact.end - limit.end) / e == pytest.approx(SIGMA, abs=1e-9 + 2e-15 / e)
    assert (impact.impulse - limit.impulse) / e == pytest.approx(2 - SIGMA - 1 / (1 + SIGMA), abs=1e-9 + 4e-15 / e)
    t = np.concatenate((np.linspace(0, 4.4, 500), 2.5 + e * np.linspace(0, 40, 500)))
    late = np.abs(motion.z(t) - rigid.z(t)).max() / e
    assert late == pytest.approx(SIGMA + 1 / (1 + SIGMA), abs=1e-9 + 4e-15 / e)
    assert motion.z(2.0) / e == pytest.approx(1, abs=1e-9 + 1e-15 / e)


# Against p = z^m/eps the end rests where z^m = eps while W = 1: the limit is of order 1/m in eps.
@pytest.mark.parametrize("exponent", ["0.5", "1.5", "2", "3"])
def test_the_rigid_limit_of_a_power_law_is_of_order_one_over_m(exponent):
    for eps in ("1e-3", "1e-4"):
        rod = unit_rod(gap=0.5, compliance=Fraction(eps), exponent=Fraction(exponent))
        motion = exact_motion(rod, THROWN, 2.4)
        assert motion.z(2.4) == pytest.approx(float(eps) ** (1 / float(exponent)), rel=1e-7)


# Two contacts under loads: what the compliance changes is proportional to it, in the places and in the instants.
def test_the_rigid_limit_is_of_first_order_under_loads_too():
    rigid = exact_motion(other_rod(), LOADED, 10.0, boundary=Boundary(rigid=True))
    t = np.linspace(0, 10, 401)
    changes = []
    for eps in ("1e-5", "1e-6", "1e-7"):
        motion = exact_motion(other_rod(compliance=Fraction(eps)), LOADED, 10.0)
        assert len(motion.impacts) == len(rigid.impacts) == 2
        instants = max(abs(a.start - b.start) for a, b in zip(motion.impacts, rigid.impacts, strict=True))
        instants = max(instants, *(abs(a.end - b.end) for a, b in zip(motion.impacts, rigid.impacts, strict=True)))
        changes.append((np.abs(motion.z(t) - rigid.z(t)).max() / float(eps), instants / float(eps)))
    for before, after in itertools.pairwise(changes):
        assert after == pytest.approx(before, rel=1e-3)
        assert min(after) > 0.1


# u0 = 0, u1 = x - 1/2: W = 1/2 - t up to t = 1, so u(t, L) = (t - t^2)/2 is largest at t = 1/2, where it is 1/8.
# With a gap short of that by h the end would be beyond it for |t - 1/2| < sqrt(2 h).  A rigid obstacle lets go where W
# changes sign, at 1/2, after the impulse int W = h.
@pytest.mark.parametrize("part", [1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("rigid", [False, True])
def test_grazing_within_a_part_in_1e12_is_told_from_a_miss(part, rigid):
    scenario, height = Scenario.parse(velocity="x - 0.5"), 0.125 * part
    gap = Fraction(1, 8)
    boundary = Boundary(rigid=rigid)
    missed = exact_motion(unit_rod(gap=gap * (1 + Fraction(part))), scenario, 1.0, boundary=boundary)
    assert missed.impacts == ()
    assert missed.z(0.5) == pytest.approx(-height, abs=2e-16)
    hit = exact_motion(unit_rod(gap=gap * (1 - Fraction(part))), scenario, 1.0, boundary=boundary)
    (impact,) = hit.impacts
    width = math.sqrt(2 * height)
    blur = 2e-16 / width  # z has rounding errors, and crosses at the speed width
    assert impact.start == pytest.approx(0.5 - width, abs=blur)
    assert impact.end == pytest.approx(0.5 if rigid else 0.5 + width, abs=blur + width**2)
    if rigid:
        assert impact.impulse == pytest.approx(height, abs=4e-16)


def test_exact_touch_is_no_contact():
    hit = exact_motion(unit_rod(gap=Fraction(1, 8)), Scenario.parse(velocity="x - 0.5"), 1.0)
    assert hit.impacts == ()
    assert hit.z(0.5) == pytest.approx(0, abs=1e-16)


@pytest.mark.parametrize("eps", ["1e6", "1", "1e-4", "1e-12", "rigid"])
def test_without_a_dashpot_the_energy_stays_through_sixty_round_trips(eps):
    system = builtin_system("paper-rod")
    changes = {"damping": Fraction(0), "gap": Fraction("0.00005"), "compliance": Fraction(eps if eps != "rigid" else 1)}
    rod = rod_from_exact({**system.rod.exact, **changes})
    until = 120 * rod.travel_time
    for clamped, least in ((False, 1), (True, 30)):  # free at both ends the rod flies away; clamped it comes back
        boundary = Boundary(rigid=eps == "rigid", clamped=clamped)
        motion = exact_motion(rod, system.scenario, until, boundary=boundary, numerics=Numerics(keep=8))
        start = exact_motion(rod, system.scenario, rod.travel_time, boundary=boundary).energy(0.0)
        assert len(motion.impacts) >= least
        assert motion.energy(until) == pytest.approx(start, rel=1e-11)
        assert motion.energy_residual < 1e-12


@pytest.mark.parametrize("rigid", [False, True])
def test_with_the_matched_dashpot_no_wave_is_left_after_two_transits_contact_or_not(rigid):
    rod = unit_rod(damping=1, gap=0.1, compliance=0.3)
    motion = exact_motion(rod, Scenario.parse(velocity="1 + x"), 30.0, boundary=Boundary(rigid=rigid))
    assert motion.impacts
    t = np.linspace(2, 30, 200)
    forward, _ = motion.waves(t, np.ones(200))
    assert np.all(forward == 0)
    # from then on z' = -z/eps: e^(-28/0.3) of it is left
    assert abs(motion.end_velocity(30.0)) < 1e-30
    assert np.all(motion.velocity(np.full(9, 29.9), np.linspace(0, 1, 9)) == pytest.approx(0, abs=1e-30))
    assert imbalance(motion) < 1e-12


def test_a_matched_dashpot_at_the_far_end_takes_all_that_arrives_in_contact_too():
    # k_L = Z and no contact: r2(t, L) = 0 exactly; in contact r2 = -d p alone
    motion = exact_motion(unit_rod(gap=0.2), THROWN, 9.0, boundary=Boundary(end_damping=1.0))
    t = np.linspace(0.01, 8.9, 300)
    _, backward = motion.waves(t, np.ones(300))
    assert motion.impacts
    assert np.all(backward[motion.contact_stress(t) == 0] == 0)
    touching = motion.contact_stress(t) > 0
    assert backward[touching] == pytest.approx(-motion.contact_stress(t[touching]), rel=1e-12, abs=1e-15)


# Pressed by a force that shakes, 1 + 2 sin(omega t), on a rod with a matched dashpot, W = g(t - 1): contact opens and
# closes once in each period, and each time is known.
def test_every_one_of_many_contacts_in_a_round_trip_is_listed():
    omega = 40 * math.pi
    rod = unit_rod(damping=1, gap=0)
    scenario = Scenario.parse(force=f"1 + 2*sin({omega!r}*t)")
    motion = exact_motion(rod, scenario, 3.0, boundary=Boundary(rigid=True))
    # from z = 0: released where W = 0, at omega (t - 1) = 7 pi/6; back where int W = 0 again
    assert len(motion.impacts) == 40
    period = 2 * math.pi / omega
    for n, impact in enumerate(motion.impacts[:39]):
        assert impact.end == pytest.approx(1 + (n + 7 / 12) * period, abs=1e-12)
    back = brentq(lambda x: (x - 7 * math.pi / 6) - 2 * (math.cos(x) - math.cos(7 * math.pi / 6)), 4.5, 7.5)
    assert motion.impacts[3].start == pytest.approx(1 + (2 + back / (2 * math.pi)) * period, abs=1e-12)
