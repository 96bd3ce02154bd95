"""lure.rod.motion where rounding decides: contact at one instant, grazing, kinks far from zero, energies, ends."""

import numpy as np
import pytest
from motions import EITHER_WAY, other_rod, unit_rod

from lure import InputError, PiecewiseLinear
from lure.rod import Scenario
from lure.rod.motion import Boundary, Numerics, exact_motion
from lure.rod.motion.pieces import Pieces
from lure.rod.motion.sources import Sources


def ringing_wave(seed):
    """Jumps as polynomials that ring about them, in pieces hardly wider than the rounding of time."""
    r = np.random.default_rng(seed)
    places = np.sort(r.uniform(0.2, 1.8, r.integers(1, 4)))
    edges, series, level = [0.0], [], r.uniform(-1, 1) * r.choice([1, 100])
    for place in places:
        series.append(np.append(level, np.zeros(16)))
        width, to = r.choice([1e-13, 5e-14, 2e-14, 3e-15, 1e-12]), r.uniform(-1, 1) * r.choice([0, 1, 100])
        ring = 0.3 * abs(to - level) * r.normal(size=17)
        ring[:2] += 0.5 * (level + to), 0.5 * (to - level)
        series.append(ring)
        edges += [place, place + width]
        level = to
    return Pieces(np.array([*edges, 2.0]), np.array([*series, np.append(level, np.zeros(16))]))


# Of these waves 0, 1, 8, 15, 20 and 22 sent the end to and fro at one instant until it was refused as chattering.
@pytest.mark.slow_for("plain")
@pytest.mark.parametrize("compiled", EITHER_WAY)
def test_no_wave_is_refused_for_going_to_and_fro_at_one_instant(monkeypatch, compiled):
    for seed in range(30):
        for rigid in (False, True):
            wave = ringing_wave(seed)
            monkeypatch.setattr(Sources, "initial_wave", lambda self, wave=wave: (wave, 0.0))
            rod = unit_rod(gap=(seed % 2) / 10, damping=0.3, compliance=10.0 ** -(seed % 12))
            numerics = Numerics(compiled=compiled)
            motion = exact_motion(rod, Scenario.parse(), 4.0, boundary=Boundary(rigid=rigid), numerics=numerics)
            assert motion.energy_residual < 1e-10
            assert motion.error < 1e-8
            assert motion.crossings < 30


@pytest.mark.slow_for("plain")
@pytest.mark.parametrize("compiled", EITHER_WAY)
def test_kinks_that_formulas_hide_do_not_look_like_chattering(compiled):
    scenario = Scenario.parse(
        displacement="0.15822777631440788*max(0,1-abs(x-0.696192851558447)*9.3937062390369)",
        velocity="0.022818469430919253*max(0,sin(18.869997437905997*x))",
        force="1.4443531216456096*max(0,sin(7.418663470078145*t))",
    )
    rod = unit_rod(gap=0.017, damping=5.0)
    numerics = Numerics(compiled=compiled)
    motion = exact_motion(rod, scenario, 4.0, boundary=Boundary(rigid=True), numerics=numerics)
    assert motion.energy_residual < 1e-12


# From rest at the obstacle, W = 2 sin(10 s) lifts z as 10 s^2: contact begins at s = 0, not where z leaves rounding.
@pytest.mark.parametrize("compiled", EITHER_WAY)
@pytest.mark.parametrize("degree", [16, 24, 32])
def test_contact_from_rest_begins_at_once(compiled, degree):
    numerics = Numerics(degree=degree, compiled=compiled)
    motion = exact_motion(unit_rod(gap=0), Scenario.parse(force="sin(10*t)"), 2.0, numerics=numerics)
    assert motion.impacts[0].start == pytest.approx(1.0, abs=6e-9)
    s = np.linspace(0, 0.5, 100)  # z' = 2 sin(10 s) - z
    expected = 2 * (np.sin(10 * s) - 10 * np.cos(10 * s) + 10 * np.exp(-s)) / 101
    assert motion.z(1 + s) == pytest.approx(expected, abs=5e-15)


# A rod at rest at z = 0, the end of a segment whose other knot is far away, stays there exactly.
@pytest.mark.parametrize("compiled", EITHER_WAY)
def test_rest_at_a_knot_is_exact_however_far_the_next_knot_is(compiled):
    nonlinearity = PiecewiseLinear([(-1000, -7000), (0, 0), (1000, 7)], left_slope=0, right_slope=0)
    numerics = Numerics(compiled=compiled)
    motion = exact_motion(
        unit_rod(gap=0), Scenario.parse(), 6.0, boundary=Boundary(nonlinearity=nonlinearity), numerics=numerics
    )
    assert not motion.z(np.linspace(0, 6, 50)).any()
    assert motion.energy_residual == 0


# Stiffness 1e9 and a wave that its series barely resolves: layers are cut where they are, not all along the wave.
@pytest.mark.parametrize("compiled", EITHER_WAY)
def test_a_stiff_law_does_not_cut_the_wave_into_layers(compiled):
    scenario = Scenario.parse(displacement="0.1*(1-x)**2 - 0.3*sin(3*(1-x))", force="-0.73*sin(7.137*t) - 0.2")
    motion = exact_motion(unit_rod(gap=0, compliance=1e-9), scenario, 8.0, numerics=Numerics(compiled=compiled))
    assert max(len(window.wave) for window in motion.fields.windows) < 250
    assert motion.energy_residual < 1e-13


@pytest.mark.parametrize("body", ["0", "0.2*sin(t + x)"])
@pytest.mark.parametrize("damping", [0.3, 1.0])
def test_energies_at_many_instants_are_those_of_the_fields(body, damping):
    scenario = Scenario.parse(
        displacement="0.1*x*(2-x)",
        velocity="0.2*cos(x)*abs(x - 0.7)",
        force="where(t < 2.2, sin(t), 0.3)",
        body_force=body,
    )
    boundary = Boundary(end_damping=0.4)
    motion = exact_motion(other_rod(damping=damping, compliance=0.01), scenario, 7.3, boundary=boundary)
    t, rod = np.array([0.0, 0.4, 1.0, 1.7, 2.5, 4.0, 6.1, 6.9, 7.3]), motion.rod
    for instant, energy in zip(t, motion.energies(t), strict=True):
        x, weights = motion.fields._quadrature(motion.fields.breaks(instant))
        v, w = motion.velocity(instant, x), motion.strain(instant, x)
        density = rod.density * v**2 + rod.youngs_modulus * w**2
        stored = rod.nonlinearity.primitive(motion.z(instant))
        assert energy == pytest.approx(rod.area * (0.5 * (weights * density).sum() + stored), rel=1e-13)
        assert motion.energy(instant) == pytest.approx(energy, rel=1e-14)
    with pytest.raises(InputError, match="t leaves the waves"):
        motion.energies([1.0, 7.4])


# u0 = h(x), at rest: E = A E/2 int h'^2 = w h0^2 for a hat of height h0 and half width 1/w, whose kinks min hides
# (int h'^2 = (h0 w)^2 2/w); k = 0 and a far obstacle keep it; k = Z lets out half of it in T at each end of x = 1/2.
def test_the_energy_of_a_hat_is_kept_between_hidden_kinks():
    scenario = Scenario.parse(displacement="0.3*max(0, 1 - abs(x - 0.5)*4.92)")
    t = np.linspace(0, 5, 41)
    motion = exact_motion(unit_rod(gap=9), scenario, 5.0)
    assert motion.energies(t) == pytest.approx(np.full(41, 4.92 * 0.3**2), rel=1e-11)
    swallowed = exact_motion(unit_rod(gap=9, damping=1), scenario, 5.0)
    expected = 4.92 * 0.3**2 * np.array([1.0, 0.5, 0.0])
    assert swallowed.energies([0.1, 1.0, 2.0]) == pytest.approx(expected, rel=1e-11, abs=1e-11)


@pytest.mark.parametrize("compiled", EITHER_WAY)
def test_progress_is_told_without_windows(compiled):
    told = []
    numerics = Numerics(on_progress=told.append, compiled=compiled)
    exact_motion(unit_rod(), Scenario.parse(velocity="x"), 1001.0, numerics=numerics)
    assert told == sorted(told)
    assert 0 < told[0] <= told[-1] <= 1001


@pytest.mark.parametrize("until", [10**400, -(10**400), float("inf"), float("nan"), 0, True])
def test_ends_that_are_no_times_are_refused(until):
    with pytest.raises(InputError, match="give a positive number of seconds"):
        exact_motion(unit_rod(), Scenario.parse(velocity="x"), until)


# Energies of 1e-320 J have lost their digits; what is left of them is no imbalance.
@pytest.mark.parametrize("compiled", EITHER_WAY)
def test_the_residual_of_energies_below_the_doubles_is_none(compiled):
    numerics = Numerics(compiled=compiled)
    motion = exact_motion(unit_rod(gap=0), Scenario.parse(velocity="1e-160*x"), 6.0, numerics=numerics)
    assert motion.energy_residual < 1e-12
