"""lure.rod.motion, the kernel compiled and as it stands: the same numbers, whatever is kept and however it is cut in
chunks."""

import os
import subprocess
import sys
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from motions import WITH_NUMBA, other_rod, unit_rod

from lure import InputError, PiecewiseLinear
from lure.rod import Scenario, builtin_system
from lure.rod.motion import Boundary, Numerics, compilation, engine, exact_motion, motion_windows
from lure.rod.motion.exponential_force import ExponentialForces
from lure.rod.motion.kernel_run import force_panels, run, run_powers
from lure.rod.motion.kernel_series import growth
from lure.rod.motion.motion import _problem
from lure.rod.motion.record import Windows, record_of
from lure.rod.motion.sources import Panels, load_of_a_block

PLAIN, COMPILED = Numerics(compiled=False), Numerics(compiled=True)
LOADED = Scenario.parse(force="0.4*sin(1.3*t)", displacement="0.1*x*(2-x)", velocity="0.2*cos(x)")
AMOUNT = st.floats(-1, 1).map(lambda x: round(x, 3))


def differences(first, second):
    """Largest differences of ``z`` and of the stress, at 400 instants that no event is likely to meet."""
    t = np.random.default_rng(3).uniform(second.since, second.until, 400)
    return np.abs(first.z(t) - second.z(t)).max(), np.quantile(
        np.abs(first.contact_stress(t) - second.contact_stress(t)), 0.98
    )


@st.composite
def problems(draw):
    """A rod, a scenario, a boundary and a time."""
    rod = unit_rod(
        damping=draw(st.sampled_from([0.0, 1e-4, 0.3, 1.0, 7.0])),
        compliance=10.0 ** draw(st.integers(-12, 3)),
        gap=draw(st.floats(0, 0.5).map(lambda x: round(x, 3))),
    )
    a, b, c, d, e = (draw(AMOUNT) for _ in range(5))
    force = draw(
        st.sampled_from(["0", f"({e})*sin(3*t)", f"({e})*sin(t) + where(t < 1.7, 0.3, 0)", f"({e})*exp(-(t - 3)**2)"])
    )
    scenario = Scenario.parse(
        displacement=f"0.1*({a})*(sin(3*x) - sin(3)) + 0.1*({b})*(1 - x)**2",
        velocity=f"({c}) + ({d})*abs(x - 0.3)",
        force=force,
    )
    graph = PiecewiseLinear([(0, 0), (Fraction(1, 10), 2)], left_slope=0, right_slope=draw(st.sampled_from([0, 50])))
    kind = draw(st.sampled_from(["rod", "rigid", "graph"]))
    boundary = Boundary(
        clamped=draw(st.booleans()),
        end_damping=draw(st.sampled_from([0.0, 0.2, 3.0])),
        rigid=kind == "rigid",
        nonlinearity=graph if kind == "graph" else None,
    )
    return rod, scenario, boundary, draw(st.floats(0.5, 14))


# Impacts shorter than 1e-7 may be told from grazing by one path only; how contact enlarges rounding is bounded by 1e-9.
@WITH_NUMBA
@given(case=problems())
def test_compiled_and_plain_give_the_same_motion(case):
    rod, scenario, boundary, until = case
    ours = exact_motion(rod, scenario, until, boundary=boundary, numerics=COMPILED)
    theirs = exact_motion(rod, scenario, until, boundary=boundary, numerics=PLAIN)
    assert (ours.compiled, theirs.compiled) == (True, False)
    place, stress = differences(ours, theirs)
    assert place < 1e-12
    assert stress < 1e-9
    assert ours.energy_residual < 1e-12
    first, second = ([i for i in m.impacts if i.impulse > 1e-7 and i.end - i.start > 1e-7] for m in (ours, theirs))
    assert len(first) == len(second)
    for a, b in zip(first, second, strict=True):
        assert (a.impulse, a.peak_stress) == pytest.approx((b.impulse, b.peak_stress), rel=1e-8, abs=1e-9)
        assert (a.start, a.closed) == (pytest.approx(b.start, abs=1e-8), b.closed)


# Numba takes 15 s for the kernel with power laws; as it stands, hypergeometric functions are its measure elsewhere.
@WITH_NUMBA
@pytest.mark.thorough
@pytest.mark.parametrize("exponent", [0.5, 1.5, 2.0])
def test_power_laws_are_the_same_compiled(exponent):
    rod = other_rod(compliance=1e-3, exponent=exponent)
    ours, theirs = (exact_motion(rod, LOADED, 12.0, numerics=n) for n in (COMPILED, PLAIN))
    assert (ours.compiled, theirs.compiled) == (True, False)
    place, stress = differences(ours, theirs)
    assert place < 1e-13
    assert stress < 1e-10
    assert [i.closed for i in ours.impacts] == [i.closed for i in theirs.impacts] != []
    for a, b in zip(ours.impacts, theirs.impacts, strict=True):
        assert (a.start, a.impulse, a.peak_stress) == pytest.approx((b.start, b.impulse, b.peak_stress), rel=1e-11)


SAME_CODE = """
import numpy as np
from lure.rod import Scenario
from motions import other_rod
from lure.rod.motion import Numerics, exact_motion
scenario = Scenario.parse(force="0.4*sin(1.3*t)", displacement="0.1*x*(2-x)", velocity="0.2*cos(x)")
motion = exact_motion(other_rod(compliance=1e-3), scenario, 12.0, numerics=Numerics(compiled=True))
print(motion.z(np.linspace(0, 12, 50)).tobytes().hex(), len(motion.impacts), motion.energy_residual)
"""


# LLVM reorders nothing without fast-math: the last bit agrees, or sums that vector units split differ in it.
@pytest.mark.slow
@WITH_NUMBA
def test_the_engine_is_the_same_code_without_compilation():
    path = os.pathsep.join([str(Path(__file__).parents[1] / "support"), *sys.path])
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": path}
    run = subprocess.run([sys.executable, "-c", SAME_CODE], capture_output=True, text=True, env=environment, check=True)
    z, impacts, residual = run.stdout.split()
    motion = exact_motion(other_rod(compliance=1e-3), LOADED, 12.0, numerics=COMPILED)
    assert np.frombuffer(bytes.fromhex(z)) == pytest.approx(motion.z(np.linspace(0, 12, 50)), abs=1e-15)
    assert (int(impacts), float(residual)) == (len(motion.impacts), pytest.approx(motion.energy_residual, abs=1e-14))


@WITH_NUMBA
@pytest.mark.parametrize(("windows", "pieces"), [(1, 600), (7, 700), (500, 5000)])
def test_chunks_do_not_matter(monkeypatch, windows, pieces):
    rod = other_rod(compliance=1e-3)
    whole = exact_motion(rod, LOADED, 150.0, numerics=COMPILED)
    monkeypatch.setattr(engine, "_WINDOWS", windows)
    monkeypatch.setattr(engine, "_PIECES", pieces)
    cut = exact_motion(rod, LOADED, 150.0, numerics=COMPILED)
    assert cut.impacts == whole.impacts != ()
    t = np.linspace(0, 150, 3000)
    for name in ("z", "contact_stress", "end_velocity"):
        assert np.array_equal(getattr(cut, name)(t), getattr(whole, name)(t))
    assert (cut.energy_residual, cut.error, cut.crossings) == (whole.energy_residual, whole.error, whole.crossings)


@pytest.mark.slow
@WITH_NUMBA
def test_room_grows_for_a_round_trip_of_very_many_pieces(monkeypatch):
    scenario = Scenario.parse(force="0.3*sin(700*t)", velocity="0.4")
    whole = exact_motion(unit_rod(gap=0.1), scenario, 9.0, numerics=COMPILED)
    assert max(len(window.wave) for window in whole.fields.windows) > 200
    monkeypatch.setattr(engine, "_PIECES", 50)
    cut = exact_motion(unit_rod(gap=0.1), scenario, 9.0, numerics=COMPILED)
    assert np.array_equal(cut.z(np.linspace(0, 9, 999)), whole.z(np.linspace(0, 9, 999)))
    assert differences(whole, exact_motion(unit_rod(gap=0.1), scenario, 9.0, numerics=PLAIN))[0] < 1e-12


@WITH_NUMBA
def test_memory_does_not_grow_with_the_time():
    rod = other_rod(compliance=0.05)
    sizes = []
    for until in (2000.0, 20_000.0):
        motion = exact_motion(rod, LOADED, until, numerics=Numerics(keep=5, compiled=True))
        record = motion.fields.record
        assert len(record) == 5
        sizes.append(record.coef.nbytes)
    assert sizes[1] < 2 * sizes[0]


# k = 0 and a free end: u = -0.01 cos(pi x) cos(pi t) for ever, 0.01 cos(pi t) at x = 1.  Pressed by the force 0.2
# against p = z, the rod comes to rest at z = 0.2.
@pytest.mark.slow
@WITH_NUMBA
def test_a_hundred_thousand_round_trips_without_drift():
    scenario = Scenario.parse(displacement="-0.01*cos(pi*x)")
    motion = exact_motion(unit_rod(), scenario, 200_000.0, numerics=Numerics(keep=4, compiled=True))
    t = np.linspace(motion.since, 200_000, 501)
    assert motion.end_displacement(t) == pytest.approx(0.01 * np.cos(np.pi * (t - 199_990)), abs=1e-13)
    pressed = exact_motion(
        unit_rod(damping=0.3, gap=0.1), Scenario.parse(force="0.2"), 200_000.0, numerics=Numerics(keep=4, compiled=True)
    )
    assert pressed.z([199_999.0, 200_000.0]) == pytest.approx([0.2, 0.2], abs=1e-12)
    assert pressed.energy_residual < 1e-10


@WITH_NUMBA
@pytest.mark.parametrize("boundary", [Boundary(), Boundary(rigid=True)])
def test_grazing_is_told_from_contact(boundary):
    scenario = Scenario.parse(velocity="x/2", displacement="-x**2/4")
    free = exact_motion(unit_rod(gap=50), scenario, 0.999, numerics=COMPILED)
    peak = float(free.end_displacement(np.linspace(0, 0.999, 5000)).max())
    for shift, count in ((1e-9, 0), (-1e-9, 1)):
        motion = exact_motion(unit_rod(gap=peak + shift), scenario, 0.999, boundary=boundary, numerics=COMPILED)
        assert len(motion.impacts) == count


@WITH_NUMBA
def test_the_paper_rod_under_the_corrected_force_goes_the_same_way_for_two_tenths_of_a_second():
    system = builtin_system("paper-rod")
    scenario = Scenario.parse(force="(2/60000)*sin(4*t)", displacement=str(system.scenario.displacement))
    ours, theirs = (exact_motion(system.rod, scenario, 0.2, numerics=n) for n in (COMPILED, PLAIN))
    assert differences(ours, theirs)[0] < 1e-15


@WITH_NUMBA
def test_refusals_are_the_same():
    with pytest.raises(InputError, match=r"wave in round trip 0 is 1e\+200 m/s"):
        exact_motion(unit_rod(), Scenario.parse(velocity="1e200*x"), 9.0, numerics=COMPILED)
    with pytest.raises(InputError, match="more than 5000 pieces in one round trip"):
        exact_motion(unit_rod(), Scenario.parse(force="sin(100000*t)"), 9.0, numerics=COMPILED)
    with pytest.raises(InputError, match=r"force\.g has no finite value"):
        exact_motion(unit_rod(), Scenario.parse(force="log(4 - t)"), 9.0, numerics=COMPILED)
    late = exact_motion(unit_rod(), Scenario.parse(force="log(4.001 - t)"), 4.0, numerics=COMPILED)
    assert np.isfinite(late.z(4.0))


@WITH_NUMBA
def test_a_record_and_its_windows_are_the_same():
    motion = exact_motion(other_rod(), LOADED, 30.0, numerics=COMPILED)
    record = motion.fields.record
    again = record_of(tuple(Windows(record)), record.share)
    t = np.linspace(0, 30, 501)
    for name in ("wave", "returned", "push", "z"):
        assert np.array_equal(record.at(t, name), again.at(t, name))
    assert np.array_equal(record.marks, again.marks)
    assert [window.number for window in Windows(record)[3:6]] == [3, 4, 5]
    assert sum((window.impacts for window in Windows(record)), ()) == tuple(i for i in motion.impacts if i.closed)
    numbers = [window.number for window in motion_windows(other_rod(), LOADED, 30.0)]
    assert numbers == list(range(15))


def values_of(table, owner, place):
    """Of panels at places in a block."""
    x = (2 * place - table[owner, 0] - table[owner, 1]) / (table[owner, 1] - table[owner, 0])
    return np.array([np.polynomial.chebyshev.chebval(a, row[4:21]) for a, row in zip(x, table[owner], strict=True)])


# A pulse, a sine, a parabola, hidden kinks, a decay: at random instants the panels have the values of the formula.
@pytest.mark.parametrize("force", ["exp(-((t - 41.3)/0.3)**2)", "sin(7*t)", "2 + t**2", "max(sin(t), 0)", "exp(-t)"])
def test_panels_hold_the_load(force):
    problem = _problem(other_rod(), Scenario.parse(force=force), 100.0, Boundary(), 16)
    panels = Panels(sources=problem.sources, transits=problem.transits, scale=0.0)
    for block in range(4):
        table, heads = panels.of(block)
        table, place = (
            table.reshape(-1, 38)[: heads[1]],
            np.random.default_rng(4).uniform(0, min(32, 100 - 32 * block), 1000),
        )
        owner = np.searchsorted(table[:, 1], place)
        expected = problem.sources.added(32.0 * block + place)[0]
        assert values_of(table, owner, place) == pytest.approx(expected, abs=3e-13 * np.abs(expected).max())


# Slow forces, which degree 16 resolves over 32 transits; sin(t), on parts of them; a fast one, which is left to arrays.
@pytest.mark.parametrize(
    ("force", "count"), [("sin(0.05*t)", 1), ("2 + t**2", 1), ("exp(-t/20)*cos(0.05*t + 1)", 1), ("sin(t)", 16)]
)
def test_the_panels_of_the_kernel_hold_a_sum_of_exponentials(force, count):
    cases = [_problem(other_rod(), Scenario.parse(force=g), 200.0, Boundary(), 16) for g in (force, "sin(40*t)")]
    kernel, (table, heads) = engine.Engine(cases[0], wish=False), load_of_a_block(16)
    packed, fast = (ExponentialForces(problem.sources, 200.0).packed(0) for problem in cases)
    for block in (0, 3):
        assert force_panels(kernel.f, kernel.q, (table, heads), packed, block)
        panels = table.reshape(-1, 38)[: heads[1]]
        assert (heads[0], len(panels), panels[-1, 1]) == (block, count + (block == 0), 32.0)
        assert block or panels[0, :3].tolist() == [0.0, 1.0, 0.0]  # the force is not yet there
        assert panels[1:, 0].tolist() == panels[:-1, 1].tolist()
        t = np.random.default_rng(4).uniform(0.0 if block else 1.0, 32.0, 400)
        expected = cases[0].sources.added(32.0 * block + t)[0]
        found = values_of(panels, np.searchsorted(panels[:, 1], t), t)
        # the phase of sin(t) is known to the rounding of t, up to 1.4e-14
        assert found == pytest.approx(expected, abs=(4e-15 if count == 1 else 2e-14) * np.abs(expected).max())
        assert panels[:, 21:] == pytest.approx(np.abs(panels[:, 4:21]) @ growth(16).T, rel=1e-14)
        assert not force_panels(kernel.f, kernel.q, (table, heads), fast, block)


def test_compilation_is_chosen_where_it_pays(monkeypatch):
    problem = SimpleNamespace(transits=100.0, nonlinearity=SimpleNamespace(segments=[SimpleNamespace(power=1.0)]))
    monkeypatch.setattr(compilation, "find_spec", lambda _: object())
    monkeypatch.setattr(compilation, "_KERNELS", {})
    monkeypatch.setattr(
        compilation, "compiled_kernel", lambda function: "with" if function is run_powers else "without"
    )
    for left, kept, pays in ((0.5, True, False), (3.0, True, True), (3.0, False, False), (45.0, False, True)):
        monkeypatch.setattr(compilation, "_on_disk", lambda made, kept=kept: kept and made == "without")
        assert compilation.compilation_pays(problem, None, left) is pays
        assert compilation.compilation_pays(problem, False, left) is False
        assert compilation.compilation_pays(problem, True, left) is True
    problem.nonlinearity.segments[0].power = 2.0
    monkeypatch.setattr(compilation, "_on_disk", lambda made: made == "without")
    assert compilation.compilation_pays(problem, None, 3.0) is False  # what is on disk knows no power laws
    monkeypatch.setattr(compilation, "_KERNELS", {run: SimpleNamespace(signatures=[()])})
    assert compilation.compilation_pays(problem, None, 3.0) is False
    problem.nonlinearity.segments[0].power = 1.0
    assert compilation.compilation_pays(problem, None) is True
    monkeypatch.setattr(compilation, "_KERNELS", {})
    monkeypatch.setattr(compilation, "find_spec", lambda _: None)
    assert compilation.compilation_pays(problem, None, 45.0) is False
    with pytest.raises(InputError, match=r'needs numba: pip install "lure\[fast\]"'):
        compilation.compilation_pays(problem, True)


# The body force takes every round trip through the kernel; a piece that is said to cost 10 s makes up its mind at once.
@WITH_NUMBA
def test_a_motion_that_takes_long_is_compiled_on_the_way(monkeypatch):
    scenario = Scenario.parse(body_force="0.01*sin(t)", velocity="0.2*cos(x)")
    plain = exact_motion(other_rod(), scenario, 20.0, numerics=PLAIN)
    exact_motion(other_rod(), scenario, 0.1, numerics=COMPILED)  # compiles, or loads what was compiled
    kernels = dict(compilation._KERNELS)
    monkeypatch.setattr(compilation, "_KERNELS", {})
    monkeypatch.setattr(engine, "_FEW_WINDOWS", 3)
    monkeypatch.setattr(engine, "_PIECE", 10.0)
    monkeypatch.setattr(engine, "compiled_kernel", lambda function: kernels[function])
    monkeypatch.setattr(compilation, "compiled_kernel", lambda function: kernels[function])
    motion = exact_motion(other_rod(), scenario, 20.0)
    assert motion.compiled
    assert motion.crossings == plain.crossings > 0
    assert differences(motion, plain)[0] < 1e-13
    monkeypatch.setattr(engine, "_PIECE", 1e-9)
    assert not exact_motion(other_rod(), scenario, 20.0).compiled
