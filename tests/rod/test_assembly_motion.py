"""The exact motion of several contacts: by hand, against one rod, against the scheme, energy, refusals."""

import math
from fractions import Fraction as F
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from lure.errors import InputError
from lure.rod import Rod, Scenario, exact_motion
from lure.rod.assembly import RodAssembly
from lure.rod.assembly_motion import assembly_motion


def rod(damping, modulus=1, length=1, area=1, **own):
    return Rod(youngs_modulus=modulus, density=1, length=length, area=area, damping=damping, compliance=1, **own)


def rods(arrangement, *parts, compliances, gaps, **more):
    return RodAssembly(
        arrangement=arrangement, rods=parts, compliances=tuple(map(F, compliances)), gaps=tuple(map(F, gaps)), **more
    )


# Z = 1 = k: no wave comes back from the dashpot, and thrown with v = 1 the end x = L is hit by W = 1 until T = 1.  It
# touches at 0.5; then y' = W - y/eps with y = sigma - 0.5: y = (1 - e^{-10 (t - 0.5)})/10 up to 1, and then it decays
def test_a_rod_that_is_thrown_at_an_obstacle_by_hand():
    found = assembly_motion(
        rods("one-obstacle", rod(1), compliances=["1/10"], gaps=["1/2"]), (Scenario.parse(velocity=1),), 2
    )
    (contact,) = found.contacts[0]
    assert contact.start == pytest.approx(0.5, abs=1e-15)
    assert not contact.closed
    t = np.array([0.25, 0.5, 0.7, 1.0, 1.3, 2.0])
    top = (1 - math.exp(-5)) / 10
    y = np.where(t <= 1, (1 - np.exp(-10 * (t - 0.5))) / 10, top * np.exp(-10 * (t - 1)))
    assert np.allclose(found.sigma(t)[:, 0], np.where(t < 0.5, t, 0.5 + y), atol=1e-15)
    assert contact.peak_stress == pytest.approx(10 * top, rel=1e-13)
    # momentum: the impulse is int 10 y dt = int_0.5^1 (1 - e^..) + top (1 - e^{-10})
    impulse = 0.5 - top + top * (1 - math.exp(-10))
    assert contact.impulse == pytest.approx(impulse, rel=1e-13)
    assert np.allclose(found.energies([0.0, 0.4]), [0.5, 0.4], atol=1e-15)  # v(0) = 1/2: k v^2 = 1/4


PULLED = Scenario.parse(velocity="x", displacement="x**2/10", force="0.3*sin(t)")


@pytest.fixture(scope="module")
def alone():
    return exact_motion(rod("1/20", gap="1/5").replace(compliance="1/50"), PULLED, 12)


@pytest.mark.slow
def test_an_obstacle_that_is_far_away_is_none(alone):
    found = assembly_motion(rods("both-ends", rod("1/20"), compliances=[1, "1/50"], gaps=[1000, "1/5"]), (PULLED,), 12)
    t, x = np.linspace(0, 12, 301), np.linspace(0, 1, 7)
    assert np.abs(found.sigma(t)[:, 1] - alone.end_displacement(t)).max() < 1e-13
    assert np.abs(found.energies(t) - alone.energies(t)).max() < 1e-13
    assert np.abs(found.displacement(0, 7.3, x) - alone.displacement(7.3, x)).max() < 1e-13
    for own, other in zip(found.waves(0, 7.3, x), alone.waves(7.3, x), strict=True):
        assert np.abs(own - other).max() < 1e-12
    assert found.contacts[0] == ()
    starts = [[one.start for one in run] for run in (found.contacts[1], alone.impacts)]
    assert np.allclose(*starts, rtol=1e-12)
    assert len(starts[0]) == 2
    assert found.contacts[1][0].impulse == pytest.approx(alone.impacts[0].impulse, rel=1e-12)


@pytest.mark.slow
def test_two_equal_rods_that_meet_are_one_against_an_obstacle_half_way(alone):
    found = assembly_motion(
        rods("across-gap", rod("1/20"), rod("1/20"), compliances=["1/25"], gaps=["2/5"]), (PULLED, PULLED), 12
    )
    t = np.linspace(0, 12, 301)
    for end in np.moveaxis(found.ends(t)[1], -1, 0):
        assert np.abs(end - alone.end_displacement(t)).max() < 1e-13
    assert np.abs(found.energies(t) - 2 * alone.energies(t)).max() < 2e-13


@pytest.mark.slow
def test_rods_against_an_obstacle_that_does_not_move_are_each_alone(alone):
    other = rod(3, modulus=2, area=2)  # of a travel time in no rational ratio
    found = assembly_motion(
        rods("one-obstacle", rod("1/20"), other, compliances=["1/50", "1/3"], gaps=["1/5", 0]),
        (PULLED, Scenario.parse(velocity="sin(x)")),
        6,
    )
    t = np.linspace(0, 6, 201)
    assert np.abs(found.sigma(t)[:, 0] - alone.end_displacement(t)).max() < 1e-13
    single = exact_motion(other.replace(compliance="1/3"), Scenario.parse(velocity="sin(x)"), 6)
    assert np.abs(found.ends(t)[1][:, 1] - single.end_displacement(t)).max() < 1e-13


THREE = rods(
    "one-obstacle",
    rod("1/20"),
    rod(3, modulus=4, length="3/2"),
    rod("1/3", modulus=4, area=2),
    compliances=["1/30", "1/50", "1/5"],
    gaps=["1/10", "1/5", 0],
    obstacle_damping=F(2),
)
BETWEEN = rods("both-ends", rod("1/5"), compliances=["1/30", "1/50"], gaps=["1/10", "1/5"])
ACROSS = rods("across-gap", rod("1/5"), rod(1, modulus=2, area=2), compliances=["1/30"], gaps=["1/10"])


@pytest.mark.slow_for("assembly2-data2")
@pytest.mark.parametrize(
    ("assembly", "data"),
    [
        pytest.param(
            THREE,
            (PULLED, Scenario.parse(velocity="-x", displacement="x/5"), Scenario.parse(velocity="sin(x)")),
            marks=pytest.mark.slow,
        ),
        (BETWEEN, (PULLED,)),
        (ACROSS, (PULLED, Scenario.parse(velocity="sin(x)"))),
    ],
)
def test_energy_is_balanced_and_contacts_are_whole(assembly, data):
    found = assembly_motion(assembly, data, 8)
    assert found.energy_residual < 1e-12
    assert found.error < 1e-12
    for i, contacts in enumerate(found.contacts):
        for one in contacts:
            if one.closed:
                at_ends = found.sigma([one.start or one.end, one.end])[:, i] - float(assembly.gaps[i])
                assert np.abs(at_ends).max() < 1e-13
            t = np.linspace(one.start, one.end, 2001)
            force = found.forces(t)[:, i]
            assert one.impulse == pytest.approx(np.trapezoid(force, t), rel=1e-4)
            stress = found.stresses(t)[:, i].max()
            assert one.peak_stress * (1 - 1e-2) <= stress <= one.peak_stress * (1 + 1e-12)
    assert sum(map(len, found.contacts)) >= 1
    beyond = [sum(one.start <= s <= one.end for one in run) for s in (3.3, 5.1) for run in found.contacts]
    assert beyond == [int(v > 0) for row in found.forces([3.3, 5.1]) for v in row]


def scheme_sigma(assembly, velocity, cells, t):
    """`sigma` of the upwind scheme between two obstacles, thrown from rest at 0; T = Z = 1, so s = N."""
    (k,), (one,) = [float(each.damping) for each in assembly.rods], assembly.rods
    a, b = one.reflection, 1 / (1 + k)
    gaps, eps = (np.array([float(v) for v in side]) for side in (assembly.gaps, assembly.compliances))
    x = np.arange(cells + 1) / cells

    def rate(_, y):
        waves, sigma = y[:-2], y[-2:]
        p = np.maximum(sigma - gaps, 0) / eps
        before = np.roll(waves, 1)
        before[0] = -a * waves[-1] + 2 * b * p[0]
        before[cells] -= 2 * p[1]
        closing = -(before[0] + waves[-1]) / 2, waves[cells - 1] - p[1]
        return np.concatenate((cells * (before - waves), closing))

    start = np.concatenate((velocity(x[1:]), velocity(x[cells - 1 :: -1]), [0, 0]))
    return solve_ivp(rate, (0, t[-1]), start, t_eval=t, rtol=1e-6, atol=1e-8).y[-2:].T


# matched data: v(0) = 0, no strain, nothing touches at first; thrown right it meets the obstacle at L, left that at 0
@pytest.mark.parametrize(("sign", "touched"), [(1, 1), (-1, 0)])
def test_the_scheme_tends_to_it_with_the_first_power_of_the_cells(sign, touched):
    t = np.linspace(0, 2, 31)
    found = assembly_motion(BETWEEN, (Scenario.parse(velocity=f"{sign}*x**2"),), 2)
    assert [len(one) for one in found.contacts] == [1 - touched, touched]
    runs = [scheme_sigma(BETWEEN, lambda x: sign * x**2, n, t) for n in (50, 100, 200)]
    errors = [np.abs(run - found.sigma(t)).mean() for run in runs]
    assert errors[2] < 2e-3
    assert all(1.7 < coarse / fine < 2.3 for coarse, fine in pairwise(errors))


@pytest.mark.parametrize(
    ("data", "until", "why"),
    [
        ((PULLED, PULLED), 1, "there are 2 scenarios for 1 rods; give one for each"),
        ((Scenario.parse(body_force="x"),), 1, "rod 1 has a body force"),
        ((PULLED,), 0, "until is 0; give a time from 0 to 100000 s"),
        ((Scenario.parse(velocity="1/x"),), 1, "give a formula that is finite"),
    ],
)
def test_what_cannot_be_followed_is_refused(data, until, why):
    with pytest.raises(InputError, match=why):
        assembly_motion(BETWEEN, data, until)


@pytest.mark.slow
def test_questions_beyond_the_motion_are_refused():
    found = assembly_motion(BETWEEN, (PULLED,), 1)
    with pytest.raises(InputError, match=r"give times in \[0, 1\] s"):
        found.sigma(1.5)
    with pytest.raises(InputError, match=r"give places in \[0, 1\] m"):
        found.waves(0, 0.5, 1.5)
    with pytest.raises(InputError, match="there is no rod 1"):
        found.displacement(1, 0.5, 0)
    with pytest.raises(InputError, match="samples is 1"):
        found.sampled(1)
    sampled = found.sampled(5)
    assert sampled.to_xarray()["sigma"].shape == (5, 2)
    assert "a rod between two obstacles, followed for 1 s" in str(found)


# lambda T = 2e6: a boundary layer of a millionth of the travel time at each change, and p follows the wave outside it
def test_a_stiff_contact_of_steel_costs_a_few_hundred_steps():
    steel = Rod(youngs_modulus=210e9, density=7850, length=0.5, area=1e-4, damping=40, compliance="1e-18", gap="1e-4")
    thrown = Scenario.parse(velocity=1)
    one = RodAssembly(arrangement="one-obstacle", rods=(steel,), compliances=(F(1, 10**18),), gaps=(F(1, 10**4),))
    found, single = assembly_motion(one, (thrown,), 4e-4), exact_motion(steel, thrown, 4e-4)
    assert len(found.steps) < 500
    assert found.energy_residual < 1e-12
    t = np.linspace(0, 4e-4, 301)
    assert np.abs(found.ends(t)[1][:, 0] - single.end_displacement(t)).max() < 1e-15
    assert np.abs(found.stresses(t)[:, 0] - single.contact_stress(t)).max() < 1e-10 * single.impacts[0].peak_stress
    assert found.contacts[0][0].peak_stress == pytest.approx(single.impacts[0].peak_stress, rel=1e-12)
