"""Motions as Datasets and netCDF files: values, units, attributes, the same bytes twice, and what is refused."""

import math
import sys

import numpy as np
import pytest
import xarray
from motions import other_rod, unit_rod
from refusals import refusal
from runs import thrown, thrown_dashpot, thrown_end, thrown_energy, thrown_stress, thrown_velocity

import lure
from lure.analysis.output import check_targets, written
from lure.analysis.rod.runs import Request, methods, perform, sampled_motion, write_dataset
from lure.analysis.rod.runs.methods import sampled_galerkin, sampled_scheme
from lure.analysis.rod.runs.sampled import summary_dict, summary_lines
from lure.analysis.verdict import Evidence
from lure.files import find_system
from lure.rod import Scenario, builtin_system, upwind
from lure.rod.galerkin import galerkin
from lure.rod.motion import Boundary, Numerics, exact_motion

JUMPS = (0.5, 1.0, 1.5, 2.0)
STRUCK = find_system("paper-rod", ["rod.gap=5e-5", "rod.compliance=1e-9"])


def reopened(dataset, folder):
    write_dataset(dataset, folder / "run.nc")
    with xarray.open_dataset(folder / "run.nc") as found:
        return found.load()


def quiet(t):
    """Samples that are not at a jump."""
    return np.all([np.abs(t - jump) > 1e-9 for jump in JUMPS], axis=0)


@pytest.mark.slow
def test_a_file_holds_the_motion_known_in_closed_form(tmp_path):
    found = reopened(thrown().to_xarray(301), tmp_path)
    t = found.t.values
    sure = quiet(t)
    for name, formula in [
        ("u_end", thrown_end),
        ("contact_stress", thrown_stress),
        ("v_end", thrown_velocity),
        ("v_0", thrown_dashpot),
        ("energy", thrown_energy),
    ]:
        assert found[name].values[sure] == pytest.approx(formula(t[sure]), abs=1e-12), name
    assert found.z.values == pytest.approx(found.u_end.values - 0.5, abs=1e-15)
    assert found.dashpot_force.values == pytest.approx(3.0 * found.v_0.values, abs=1e-15)


def test_the_impact_of_the_file_is_the_one_known_in_closed_form(tmp_path):
    found = reopened(thrown().to_xarray(5), tmp_path)
    assert found.impacts.item() == 1
    assert found.impact.values.tolist() == [1]
    numbers = [found[f"impact_{name}"].item() for name in ("start", "end", "impulse", "peak_stress")]
    assert numbers == pytest.approx([0.5, 1.0, 0.5, 1.0], abs=1e-12)
    assert found.impact_closed.item() == 1


@pytest.mark.parametrize("samples", [2, 101])
def test_every_series_is_the_motion_at_the_samples(samples):
    motion = exact_motion(other_rod(damping=0.7), Scenario.parse(force="sin(3*t)", displacement="0.1*x"), 7.3)
    found, t = motion.to_xarray(samples, places=7), np.linspace(0.0, 7.3, samples)
    x = np.linspace(0.0, 2.0, 7)
    assert found.t.values.tolist() == t.tolist()
    pairs = {
        "u_end": motion.end_displacement(t),
        "z": motion.z(t),
        "v_end": motion.end_velocity(t),
        "contact_stress": motion.contact_stress(t),
        "dashpot_force": motion.dashpot_force(t),
        "v_0": motion.dashpot_velocity(t),
        "energy": motion.energies(t),
        "v": motion.velocity(t[:, None], x[None, :]),
        "w": motion.strain(t[:, None], x[None, :]),
        "u": [motion.displacement(float(s), x) for s in t],
    }
    for name, values in pairs.items():
        assert found[name].values.tolist() == np.asarray(values).tolist(), name
    assert len(motion.impacts) == found.impacts.item() > 0
    assert found.attrs["energy_residual"] == motion.energy_residual
    assert found.attrs["error_estimate"] == motion.error


def test_what_was_written_is_what_is_read(tmp_path):
    dataset = thrown().to_xarray(11, places=4)
    assert reopened(dataset, tmp_path).identical(dataset)


def test_a_motion_without_contact_is_a_file_without_impacts(tmp_path):
    system = builtin_system("paper-rod")
    dataset = perform(system, Request(until=1e-3, samples=3)).run.to_xarray()
    found = reopened(dataset, tmp_path)
    assert found.identical(dataset)
    assert found.sizes["impact"] == 0
    assert found.impacts.item() == 0
    assert (found.contact_stress.values == 0).all()


def test_two_files_of_one_motion_have_the_same_bytes(tmp_path):
    for name in ("a.nc", "b.nc"):
        write_dataset(thrown().to_xarray(11, places=4), tmp_path / name)
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


def test_every_variable_has_a_unit_or_flags_and_a_meaning():
    for name, variable in thrown().to_xarray(3, places=2).variables.items():
        assert variable.attrs["long_name"], name
        assert variable.attrs.get("units") or variable.attrs["flag_meanings"], name


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("t", "s"),
        ("u_end", "m"),
        ("z", "m"),
        ("v_end", "m s-1"),
        ("contact_stress", "Pa"),
        ("dashpot_force", "N"),
        ("v_0", "m s-1"),
        ("energy", "J"),
        ("impact_impulse", "N s"),
        ("impact_peak_stress", "Pa"),
        ("x", "m"),
        ("w", "1"),
    ],
)
def test_units(name, unit):
    assert thrown().to_xarray(3, places=2)[name].attrs["units"] == unit


def test_the_attributes_tell_what_went_in_exactly():
    system = find_system("paper-rod", ["rod.gap=0.1", "force.g=0.25*sin(4*t)", "initial.u1=x"])
    attrs = perform(system, Request(until=1e-3, samples=3)).run.to_xarray().attrs
    assert attrs["title"] == "Motion of a rod against an obstacle"
    assert attrs["Conventions"] == "CF-1.11"
    assert attrs["lure_version"] == lure.__version__
    assert attrs["source"].startswith(f"lure {lure.__version__}: exact")
    assert (attrs["rod_gap"], attrs["rod_gap_exact"], attrs["rod_gap_units"]) == (0.1, "1/10", "m")
    assert (attrs["force_g"], attrs["force_f"]) == ("0.25*sin(4*t)", "0")
    assert (attrs["initial_u0"], attrs["initial_u1"]) == ("0.0001 - 0.0002*x", "x")
    assert attrs["rod_wave_speed"] == 6000.0


@pytest.mark.parametrize(
    ("request_", "subject", "evidence"),
    [
        (Request(until=1e-3, samples=3), "rod", "computed"),
        (Request(until=1e-3, samples=3, method="scheme", cells=5), "scheme", "observed"),
        (Request(until=1e-3, samples=3, method="scheme", cells=1200), "scheme", "observed"),
        (Request(until=1e-3, samples=3, method="RK45", cells=5), "scheme", "observed"),
        (Request(until=1e-3, samples=3, method="galerkin", space="P2", order=5), "Galerkin space", "observed"),
    ],
)
def test_the_file_and_the_summary_say_which_object_moved(request_, subject, evidence):
    run = perform(STRUCK, request_).run
    attrs = run.to_xarray().attrs
    assert (attrs["subject"], attrs["evidence"]) == (subject, evidence)
    said = " ".join(summary_lines(run, "name"))
    denied = subject != "rod"
    assert ("not a motion of the rod" in said) is ("not a motion of the rod" in attrs["comment"]) is denied
    assert f"One motion, {evidence}" in said


def test_the_samples_of_the_scheme_are_those_of_its_simulation():
    from lure.analysis.rod.simulation import simulate

    scheme = upwind(STRUCK.rod, 20)
    run = sampled_scheme(scheme, STRUCK.scenario, 2e-3, samples=41, places=21)
    other = simulate(scheme, STRUCK.scenario, until=2e-3, samples=41, frames=3)
    assert run.z == pytest.approx(other.z, abs=1e-15)
    assert run.energy == pytest.approx(other.energy, rel=1e-12)
    (impact,), (contact,) = run.impacts, other.contacts
    assert (impact.start, impact.end, impact.impulse) == (contact.start, contact.end, contact.impulse)
    assert impact.peak_stress == pytest.approx(contact.peak_penetration / 1e-9)  # p = z/eps
    assert run.along.v[20] == pytest.approx(other.frames_v[1], abs=1e-12)
    assert run.v_end.tolist() == run.along.v[:, -1].tolist()
    assert run.dashpot_force == pytest.approx(2e-4 * run.along.v[:, 0], abs=1e-18)


def test_the_displacement_along_the_scheme_ends_at_its_end_and_starts_at_the_data():
    run = sampled_scheme(upwind(STRUCK.rod, 20), STRUCK.scenario, 2e-3, samples=5, places=21)
    assert run.along.u[:, -1].tolist() == run.u_end.tolist()
    assert run.along.u[0] == pytest.approx(1e-4 - 2e-4 * run.along.x, abs=1e-15)  # u0, whose slope the cells hold


def test_the_displacement_along_the_scheme_has_the_velocity_as_its_rate():
    # u_i' = v_i exactly: here by central differences, error h^2 v''/6 with v'' at most (2 c N/L)^2 v
    run = sampled_scheme(upwind(STRUCK.rod, 20), STRUCK.scenario, 2.5e-4, samples=5001, places=21)
    rate = (run.along.u[2:] - run.along.u[:-2]) / (run.t[2] - run.t[0])
    away = np.abs(run.t[1:-1, None] - [run.impacts[0].start, run.impacts[0].end]).min(axis=1) > 1e-7
    assert np.abs(rate - run.along.v[1:-1])[away].max() < 5e-5


def test_the_two_ways_to_follow_the_scheme_agree(monkeypatch):
    scheme = upwind(STRUCK.rod, 40)
    short = sampled_scheme(scheme, STRUCK.scenario, 1e-3, samples=21)
    monkeypatch.setattr(methods, "in_steps", lambda *_: False)
    long = sampled_scheme(scheme, STRUCK.scenario, 1e-3, samples=21)
    assert long.z == pytest.approx(short.z, abs=1e-14)
    assert long.v_end == pytest.approx(short.v_end, abs=1e-9)
    assert long.impacts[0].start == pytest.approx(short.impacts[0].start, abs=1e-12)
    assert math.isnan(long.impacts[0].impulse)
    assert long.largest_stress == (long.stress.max(), "at the samples")
    assert short.largest_stress == (short.impacts[0].peak_stress, "over all instants")


def test_an_integrator_agrees_with_the_exact_scheme():
    scheme = upwind(STRUCK.rod, 10)
    exact = sampled_scheme(scheme, STRUCK.scenario, 1e-3, samples=21)
    run = sampled_scheme(scheme, STRUCK.scenario, 1e-3, method="DOP853", samples=21)
    assert run.z == pytest.approx(exact.z, abs=1e-10)
    assert run.v_end == pytest.approx(exact.v_end, abs=1e-6)
    assert run.error is None


@pytest.mark.slow
def test_the_impulse_of_a_galerkin_impact_is_its_integral_of_the_stress():
    run = sampled_galerkin(STRUCK.rod, STRUCK.scenario, 1e-3, space="P1", order=21, samples=2001, places=3)
    (impact,) = run.impacts
    area, step = 0.25e-4, run.t[1]
    assert impact.impulse == pytest.approx(area * step * run.stress.sum(), rel=1e-3)  # the trapezoidal rule
    assert run.along.u[:, -1] == pytest.approx(run.u_end, abs=1e-18)
    assert run.along.v[:, 0] == pytest.approx(run.v_0, abs=1e-14)


@pytest.mark.slow
def test_the_impulse_of_a_galerkin_impact_is_unknown_without_a_sample_in_flight_on_both_sides():
    system = find_system("paper-rod", ["rod.gap=0", "rod.compliance=1e-11", "initial.u1=0.05"])
    fine = sampled_galerkin(system.rod, system.scenario, 1e-3, space="P1", order=11, samples=801)
    assert len(fine.impacts) > 1
    coarse = sampled_galerkin(system.rod, system.scenario, 1e-3, space="P1", order=11, samples=2)
    assert all(math.isnan(impact.impulse) for impact in coarse.impacts)
    model = galerkin(system.rod, space="P1", order=11).simulate(system.scenario, 1e-3, samples=2)
    assert fine.impulse == pytest.approx(float(model.impulse[-1]), rel=1e-6)


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"method": "scheme", "cells": 50},
        {"method": "scheme", "cells": 1200},
        pytest.param({"method": "galerkin"}, marks=pytest.mark.slow),
        {"method": "LSODA", "cells": 20},
    ],
)
def test_a_contact_from_the_start_is_closed_when_the_end_has_left(options):
    pressed = find_system("paper-rod", ["rod.gap=-2e-4", "rod.compliance=1e-9"])  # z(0) = -1e-4 + 2e-4
    (left,) = perform(pressed, Request(until=5e-4, samples=5, **options)).run.impacts
    (cut,) = perform(pressed, Request(until=3e-5, samples=5, **options)).run.impacts
    assert (left.start, left.closed) == (0.0, True)
    assert left.end == pytest.approx(2.005e-4, rel=0.03)
    assert (cut.start, cut.end, cut.closed) == (0.0, pytest.approx(3e-5), False)


def test_a_clamped_rod_has_no_dashpot_force():
    motion = exact_motion(unit_rod(), Scenario.parse(velocity="x"), 2.0, boundary=Boundary(clamped=True))
    found = motion.to_xarray(5)
    assert "dashpot_force" not in found
    assert (found.v_0.values == 0).all()
    assert found.attrs["method_boundary_at_0"] == "clamped"


def test_a_motion_that_forgot_its_beginning_is_sampled_where_all_of_it_is_known():
    motion = exact_motion(unit_rod(), Scenario.parse(velocity=1), 20.0, numerics=Numerics(keep=3))
    run = sampled_motion(motion, 5)
    assert run.t[0] == motion.since + 2.0 > 2.0
    assert run.t[-1] == 20.0


@pytest.mark.parametrize(
    ("boundary", "damping"), [("dashpot", 2e-4), ("free", 0.0), ("matched", 1.2), ("clamped", 2e-4)]
)
def test_boundaries_change_the_damping_of_the_rod(boundary, damping):
    done = perform(builtin_system("paper-rod"), Request(until=1e-3, boundary=boundary, samples=2))
    assert done.run.rod.damping == pytest.approx(damping)
    assert done.motion.boundary.clamped is (boundary == "clamped")
    assert (done.run.rod.reflection == 0.0) is (boundary == "matched")


def test_the_printed_form_is_not_mistaken_for_the_rod():
    run = perform(builtin_system("paper-rod-figure-8"), Request(until=1e-3, samples=2)).run
    assert "as printed" in run.note
    assert run.note in run.to_xarray().attrs["note"]
    assert perform(builtin_system("paper-rod"), Request(until=1e-3, samples=14)).run.note == ""


def test_samples_that_miss_waves_are_said_to():
    # 1e-3 s are 6 transits of 1/6000 s: 13 steps are less than half a transit each, 11 are more
    said = perform(builtin_system("paper-rod"), Request(until=1e-3, samples=12)).run
    assert "the samples are 0.545 transits L/c apart" in said.to_xarray().attrs["note"]


def test_plain_data_have_no_nan():
    run = perform(STRUCK, Request(until=1e-3, samples=3, method="scheme", cells=1200)).run
    plain = summary_dict(run, "name")
    assert plain["impulse"] is None
    assert plain["impacts"][0]["peak_stress"] is None
    assert plain["largest_stress_is"] == "at the samples"
    assert run.evidence is Evidence.OBSERVED


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"until": 0.0}, "until is 0.0; give a positive number of seconds"),
        ({"until": math.inf}, "until is inf; give a positive number of seconds"),
        ({"until": 1.0, "samples": 1}, "samples is 1; give a whole number from 2 to 1000000"),
        ({"until": 1.0, "places": 1}, "fields is 1; with 2001 samples give a whole number of places from 2 to 24987"),
        ({"until": 1.0, "method": "euler"}, "method is 'euler'; give one of exact, scheme, galerkin,"),
        ({"until": 1.0, "boundary": "glued"}, "boundary is 'glued'; give one of dashpot, free, matched, clamped"),
        ({"until": 1.0, "method": "galerkin", "space": "P3"}, "space is 'P3'; give one of P1, P2, cosine"),
        ({"until": 1.0, "method": "scheme", "rigid": True}, "rigid is for the rod itself"),
        ({"until": 1.0, "method": "LSODA", "boundary": "clamped"}, "boundary clamped is for the rod itself"),
        ({"until": 1.0, "method": "galerkin", "end_damping": 1.0}, "end-damping is for the rod itself"),
        ({"until": 1.0, "cells": 5}, "cells is 5, and method exact has none"),
        ({"until": 1.0, "method": "scheme", "order": 5}, "space and order are for method galerkin"),
    ],
)
def test_requests_that_are_refused(options, sentence):
    assert refusal(Request, **options).startswith(sentence)


@pytest.mark.parametrize(
    ("request_", "sentence"),
    [
        (Request(until=1e-3, method="scheme", cells=5, places=7), "fields is 7; the scheme of 5 cells has 6 nodes"),
        (Request(until=1e-3, method="scheme", cells=1200, places=1201), "fields is 1201; above 1000 cells"),
        (Request(until=1e-3, method="RK45", cells=5, places=6), "fields is 6; method RK45 keeps the end"),
        (Request(until=1e-3, method="galerkin", space="P2", order=4), "galerkin.order is 4"),
        (Request(until=1e-3, end_damping=-1.0), "Boundary.end_damping is -1.0"),
    ],
)
def test_requests_that_a_method_refuses(request_, sentence):
    assert sentence in refusal(perform, STRUCK, request_)


def test_many_cells_take_a_force_at_the_end_and_none_along_the_rod():
    pushed = find_system("paper-rod", ["force.g=1e-4*sin(4*t)"])
    assert perform(pushed, Request(until=1e-4, method="scheme", cells=1200, samples=2)).run.z[-1] < 0
    loaded = find_system("paper-rod", ["force.f=1"])
    assert "body force" in refusal(perform, loaded, Request(until=1e-4, method="scheme", cells=1200))


@pytest.mark.parametrize("name", ["xarray", "netCDF4"])
def test_a_missing_package_is_named_with_what_installs_it(name, monkeypatch, tmp_path):
    dataset = thrown().to_xarray(3)
    monkeypatch.setitem(sys.modules, name, None)
    assert refusal(write_dataset, dataset, tmp_path / "run.nc") == (
        f'a netCDF file needs {name}: pip install "lure[netcdf]"'
    )
    if name == "xarray":
        assert refusal(thrown().to_xarray, 3) == 'a Dataset needs xarray: pip install "lure[netcdf]"'
    assert list(tmp_path.iterdir()) == []


def test_nothing_appears_when_the_block_fails(tmp_path):
    (tmp_path / "old.nc").write_text("old")
    paths = [tmp_path / "old.nc", tmp_path / "new.nc", tmp_path / "frames"]
    with pytest.raises(KeyboardInterrupt), written(paths, replace=True) as places:  # noqa: PT012  (the block is the test)
        places[paths[0]].write_text("half")
        (places[paths[2]] / "frame.png").write_text("half")
        raise KeyboardInterrupt
    assert [path.name for path in tmp_path.iterdir()] == ["old.nc"]
    assert (tmp_path / "old.nc").read_text() == "old"


def test_all_appears_when_the_block_ends(tmp_path):
    (tmp_path / "old.nc").write_text("old")
    (tmp_path / "frames").mkdir()
    paths = [tmp_path / "old.nc", tmp_path / "frames"]
    with written(paths, replace=True) as places:
        places[paths[0]].write_text("new")
        (places[paths[1]] / "frame.png").write_text("picture")
        assert (tmp_path / "old.nc").read_text() == "old"
    assert (tmp_path / "old.nc").read_text() == "new"
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["frame.png", "frames", "old.nc"]


def test_a_file_that_appeared_meanwhile_is_kept(tmp_path):
    target = tmp_path / "run.nc"

    def write():
        with written([target], replace=False) as places:
            places[target].write_text("new")
            target.write_text("of somebody else")

    assert "exists" in refusal(write)
    assert target.read_text() == "of somebody else"
    assert len(list(tmp_path.iterdir())) == 1


def test_targets_that_are_refused(tmp_path):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "x").write_text("")
    (tmp_path / "dir.nc").mkdir()
    (tmp_path / "old.nc").write_text("")

    def said(*names, replace=False):
        return refusal(check_targets, [tmp_path / name for name in names], replace=replace)

    assert "frames go to a folder that is new or empty" in said("full", replace=True)
    assert "is a directory; give the name of a file" in said("dir.nc", replace=True)
    assert "exists; give another name, or --replace" in said("old.nc")
    assert "is no directory; give a file in one that exists" in said("none/run.nc")
    assert "is given for two results" in said("a.png", "a.png")
    assert "cannot be written" in said("a\0.nc")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["dir.nc", "full", "old.nc"]
