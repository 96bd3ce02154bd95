"""lure.rod.motion in contact: impacts worked out by hand, stiff and rigid obstacles, energy, the scheme and the
shift."""

import math
from fractions import Fraction

import numpy as np
import pytest
from depth import rarely
from motions import EITHER_WAY, imbalance, other_rod, unit_rod

from lure import AssumptionError, PiecewiseLinear
from lure.analysis.rod.simulation import simulate
from lure.rod import Scenario, builtin_system, upwind
from lure.rod.motion import Boundary, Numerics, exact_motion
from lure.rod.systems import rod_from_exact

THROWN = Scenario.parse(velocity="1")
LOADED = Scenario.parse(force="0.4*sin(1.3*t)", displacement="0.1*x*(2-x)", velocity="0.2*cos(x)")
STIFFNESSES = (1e6, 1.0, 0.1, 1e-3, 1e-6, 1e-9, 1e-12)


# A free bar (k = 0) of unit constants thrown with v = 1 at a rigid wall 1/2 away: contact at 1/2, stress rho c v = 1
# until the release wave is back after 2T, then v = -1 throughout; impulse 2 m v = 2.  (Saint-Venant 1867.)
def test_a_bar_rebounds_from_a_rigid_wall_after_one_round_trip():
    motion = exact_motion(unit_rod(gap=0.5), THROWN, 6.0, boundary=Boundary(rigid=True))
    (impact,) = motion.impacts
    assert (impact.start, impact.end) == pytest.approx((0.5, 2.5), abs=1e-15)
    assert (impact.impulse, impact.peak_stress) == pytest.approx((2, 1), abs=1e-14)
    assert impact.closed
    x = np.linspace(0, 1, 7)
    assert motion.velocity(2.7, x) == pytest.approx(-1, abs=1e-14)
    assert motion.z([1.0, 2.0, 3.0]) == pytest.approx([0, 0, -0.5], abs=1e-14)
    assert motion.contact_stress([0.4, 1.0, 2.4, 2.6]) == pytest.approx([0, 1, 1, 0], abs=1e-14)
    assert motion.energy(1.7) == pytest.approx(0.5, rel=1e-14)


# The same wall with p = z/eps: z = eps (1 - e^{-s/eps}) while W = 1, then W = V(s - 2) = 2 e^{-s/eps} - 1 in the second
# round trip, where z = -eps + (2 s + eps + z(2)) e^{-s/eps}, until it is zero.
@pytest.mark.parametrize("eps", [2.0, 0.3, 1e-2, 1e-4, 1e-7, 1e-10])
def test_a_bar_rebounds_from_a_compliant_wall_as_the_closed_form_says(eps):
    motion = exact_motion(unit_rod(gap=0, compliance=eps), THROWN, 4.0)
    s = eps * np.array([0.0, 0.1, 1.0, 3.0, 10.0, 40.0, 1e4])
    s = s[s <= 2]
    assert motion.z(s) == pytest.approx(-eps * np.expm1(-s / eps), abs=2e-13 * eps + 1e-16)
    top = -eps * math.expm1(-2 / eps)

    def second(s):
        return -eps + (2 * s + eps + top) * math.exp(-s / eps)

    (impact,) = motion.impacts
    if eps < 2:  # the release: second(s) = 0
        released = impact.end - 2
        assert abs(second(released)) < 1e-12 * max(eps, 1e-3)
        assert second(0.9 * released) > 0 > second(1.1 * released)
        assert motion.z(2 + 0.5 * released) == pytest.approx(second(0.5 * released), abs=1e-12 * eps + 2e-16)
    assert motion.energy(4.0) == pytest.approx(0.5, rel=1e-12)


# z - 0 <= eps in contact, and the release is late by O(eps ln(1/eps)): u after it differs by that too.
def test_the_rigid_wall_is_the_limit_at_first_order():
    rigid = exact_motion(unit_rod(gap=0.5), THROWN, 6.0, boundary=Boundary(rigid=True))
    t = np.concatenate((np.linspace(0.6, 2.4, 50), np.linspace(3.0, 4.0, 10)))
    for eps in (1e-2, 1e-4, 1e-6):
        motion = exact_motion(unit_rod(gap=0.5, compliance=eps), THROWN, 6.0)
        touching = np.abs(motion.z(t[:50]) - rigid.z(t[:50])).max()
        assert touching == pytest.approx(eps, rel=1e-6 + math.exp(-0.1 / eps))
        late = motion.z(t[50:]) - rigid.z(t[50:])
        assert np.all(np.abs(late) < 10 * eps)
        assert np.all(np.abs(late) > 0.1 * eps)


@pytest.mark.parametrize("compiled", EITHER_WAY)
@pytest.mark.parametrize("eps", STIFFNESSES)
def test_energy_is_balanced_over_ten_seconds_however_stiff_the_obstacle(eps, compiled):
    motion = exact_motion(other_rod(compliance=eps), LOADED, 10.0, numerics=Numerics(compiled=compiled))
    assert motion.impacts
    assert motion.energy_residual < 1e-13
    assert imbalance(motion) < 1e-12


@pytest.mark.parametrize("compiled", EITHER_WAY)
@pytest.mark.parametrize(
    "boundary",
    [
        Boundary(rigid=True),
        Boundary(clamped=True),
        Boundary(end_damping=0.7),
        Boundary(rigid=True, clamped=True, end_damping=0.2),
        Boundary(
            nonlinearity=PiecewiseLinear([(-1, 0), (0, 0), (Fraction(1, 10), 2), (1, 3)], left_slope=0.5, right_slope=4)
        ),
        Boundary(nonlinearity=PiecewiseLinear([(0, 0), (Fraction(1, 8), 0)], left_slope=1, right_slope=1000)),
    ],
)
def test_energy_is_balanced_with_every_boundary_condition(boundary, compiled):
    numerics = Numerics(compiled=compiled)
    motion = exact_motion(other_rod(gap=0.02), LOADED, 10.0, boundary=boundary, numerics=numerics)
    assert motion.impacts
    assert motion.energy_residual < 1e-13
    assert imbalance(motion) < 1e-12


@pytest.mark.parametrize("damping", [0.0, 1.0, 30.0])
def test_energy_is_balanced_with_any_dashpot(damping):
    assert imbalance(exact_motion(other_rod(damping=damping), LOADED, 10.0)) < 1e-12


def test_energy_is_balanced_in_the_long_contact_of_the_paper():
    system = builtin_system("paper-rod")
    for eps in ("1e6", "1", "1e-6", "1e-9", "1e-12"):
        rod = rod_from_exact({**system.rod.exact, "compliance": Fraction(eps), "gap": Fraction("0.00005")})
        motion = exact_motion(rod, system.scenario, 0.005)
        assert motion.impacts
        assert motion.energy_residual < 1e-13
        assert imbalance(motion) < 1e-12


# z' = 1 - z^2/eps has z = sqrt(eps) tanh(t/sqrt(eps)); for m = 1/2, s = sqrt(z): 2 s s' = 1 - s/c, c = eps, implicit:
# t = -2 c s - 2 c^2 ln(1 - s/c).
@pytest.mark.parametrize("eps", [1.0, 1e-2, 1e-6])
def test_power_laws_against_closed_forms(eps):
    square = exact_motion(unit_rod(gap=0, compliance=eps, exponent=2), THROWN, 4.0)
    t = math.sqrt(eps) * np.array([0.01, 0.3, 1.0, 3.0])
    t = t[t < 2]
    assert square.z(t) == pytest.approx(math.sqrt(eps) * np.tanh(t / math.sqrt(eps)), rel=1e-11)
    assert square.contact_stress(1.99) == pytest.approx(math.tanh(1.99 / math.sqrt(eps)) ** 2, rel=1e-11)
    assert imbalance(square) < 1e-11
    if eps == 1e-6:  # the layer is 1e-12 transits wide
        with pytest.raises(AssumptionError, match="give a larger compliance, or a rigid obstacle"):
            exact_motion(unit_rod(gap=0, compliance=eps, exponent=0.5), THROWN, 4.0)
        return
    root = exact_motion(unit_rod(gap=0, compliance=eps, exponent=0.5), THROWN, 4.0)
    s = eps * np.array([0.05, 0.4, 0.9])
    t = -2 * eps * s - 2 * eps**2 * np.log1p(-s / eps)
    s, t = s[t < 2], t[t < 2]
    assert root.z(t) == pytest.approx(s**2, rel=1e-9)
    assert imbalance(root) < 1e-10


@pytest.mark.slow_for("1.5")
@pytest.mark.parametrize("exponent", rarely([0.5, 1.5, 2.0, 3.0], 0.5))
def test_power_laws_keep_the_balance_through_several_impacts(exponent):
    motion = exact_motion(other_rod(exponent=exponent), LOADED, 20.0)
    assert len(motion.impacts) > 1
    assert imbalance(motion) < 1e-11
    finer = exact_motion(other_rod(exponent=exponent), LOADED, 20.0, numerics=Numerics(degree=24))
    t = np.linspace(0, 20, 500)
    assert motion.z(t) == pytest.approx(finer.z(t), abs=1e-11)


def test_a_whole_power_of_one_is_the_linear_law():
    rod = other_rod(exponent=1 + 1e-13)
    t = np.linspace(0, 10, 301)
    assert exact_motion(rod, LOADED, 10.0).z(t) == pytest.approx(
        exact_motion(other_rod(), LOADED, 10.0).z(t), abs=1e-11
    )


def test_the_law_of_the_rod_given_as_a_graph_is_the_same():
    nonlinearity = PiecewiseLinear([(0, 0)], left_slope=0, right_slope=5)
    t = np.linspace(0, 10, 301)
    ours, theirs = (
        exact_motion(other_rod(), LOADED, 10.0, boundary=b) for b in (Boundary(nonlinearity=nonlinearity), Boundary())
    )
    assert ours.z(t) == pytest.approx(theirs.z(t), abs=1e-14)
    assert len(ours.impacts) == len(theirs.impacts) > 0


# The gap is 1e-9 more, or less, than the largest displacement, which is taken from a run without obstacle.
@pytest.mark.parametrize("boundary", [Boundary(), Boundary(rigid=True)])
def test_grazing_is_told_from_contact(boundary):
    scenario = Scenario.parse(velocity="x/2", displacement="-x**2/4")
    free = exact_motion(unit_rod(gap=50), scenario, 0.999)
    peak = float(free.end_displacement(np.linspace(0, 0.999, 5000)).max())
    for shift, count in ((1e-9, 0), (-1e-9, 1)):
        motion = exact_motion(unit_rod(gap=peak + shift), scenario, 0.999, boundary=boundary)
        assert len(motion.impacts) == count


def test_a_rod_at_rest_against_the_obstacle_stays_there():
    motion = exact_motion(unit_rod(gap=0, damping=0.3), Scenario.parse(), 50.0)
    assert motion.impacts == ()
    assert np.all(motion.z(np.linspace(0, 50, 99)) == 0)
    pressed = exact_motion(
        unit_rod(gap=0, damping=0.3), Scenario.parse(force="1", displacement="-x"), 300.0, boundary=Boundary(rigid=True)
    )
    # the constant force 1 against the wall: at last p A = 1, at rest
    assert pressed.contact_stress(300.0) == pytest.approx(1, abs=1e-12)
    assert not pressed.impacts[-1].closed


def test_a_preloaded_rod_is_released_from_the_obstacle():
    motion = exact_motion(other_rod(gap=-0.3), LOADED, 10.0)
    assert motion.impacts[0].start == 0
    assert motion.contact_stress(0.0) == pytest.approx((LOADED.displacement(x=2.0) + 0.3) / 0.2, rel=1e-14)
    assert imbalance(motion) < 1e-12


def test_a_compliance_below_the_doubles_counts_as_rigid_and_says_so():
    motion = exact_motion(other_rod(compliance=1e-300), LOADED, 20.0)
    rigid = exact_motion(other_rod(), LOADED, 20.0, boundary=Boundary(rigid=True))
    t = np.linspace(0, 20, 300)
    assert "counts as rigid" in motion.note
    assert np.array_equal(motion.z(t), rigid.z(t))
    near = exact_motion(other_rod(compliance=1e-12), LOADED, 20.0)
    assert near.note == ""
    assert near.z(t) == pytest.approx(rigid.z(t), abs=1e-10)


# The scheme is of first order in the cells where the data are smooth and matched; in contact, too.
def test_the_scheme_converges_to_it_at_first_order():
    rod = unit_rod(gap=0.2, damping=0.5, compliance=0.5)
    scenario = Scenario.parse(velocity="0.3*(1 - cos(2*pi*x))", force="0.2*(1-cos(t))")
    motion = exact_motion(rod, scenario, 1.5)
    errors = []
    for cells in (50, 100, 200):
        run = simulate(upwind(rod, cells), scenario, until=1.5, samples=61)
        errors.append(float(np.abs(run.z - motion.z(run.t)).max()))
    assert 1.7 < errors[0] / errors[1] < 2.2
    assert 1.8 < errors[1] / errors[2] < 2.2
    assert errors[2] < 1e-2
