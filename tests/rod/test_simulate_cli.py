"""The command `lure simulate`: what it writes and says, and that what it refuses leaves nothing behind."""

import json
import sys

import numpy as np
import pytest
import xarray
from commands import names

from lure.files import find_system
from lure.rod.motion import exact_motion

STRIKE = ("--set", "rod.gap=5e-5", "--set", "rod.compliance=1e-9")
SHORT = ("--until", "5e-4", "--samples", "21")
GOLDEN = {
    ("--method", "exact"): "the rod itself",
    ("--method", "scheme", "--cells", "12"): "the upwind scheme of 12 cells",
    ("--method", "LSODA", "--cells", "11"): "the upwind scheme of 11 cells",
    (
        "--method",
        "galerkin",
        "--space",
        "cosine",
        "--order",
        "9",
    ): "the Galerkin space cosine of dimension 9, not the rod",
}


@pytest.mark.slow
def test_the_file_holds_the_motion_of_the_rod(lure, here):
    status, out, err = lure("simulate", "paper-rod", *SHORT, *STRIKE, "-o", "run.nc", "--fields", "5")
    assert (status, err) == (0, "")
    assert out.endswith("\nWritten: run.nc\n")
    assert names(here) == ["run.nc"]
    system = find_system("paper-rod", ["rod.gap=5e-5", "rod.compliance=1e-9"])
    motion, t = exact_motion(system.rod, system.scenario, 5e-4), np.linspace(0, 5e-4, 21)
    with xarray.open_dataset("run.nc") as found:
        assert found.z.values.tolist() == motion.z(t).tolist()
        assert found.contact_stress.values.tolist() == motion.contact_stress(t).tolist()
        assert found.v.values.tolist() == motion.velocity(t[:, None], np.linspace(0, 1, 5)).tolist()
        assert found.impact_impulse.values.tolist() == [motion.impacts[0].impulse]
        assert found.attrs["title"].startswith("paper-rod (changed): ")
        assert found.attrs["rod_gap_exact"] == "1/20000"


@pytest.mark.parametrize(("options", "moved"), GOLDEN.items())
def test_the_summary_says_what_moved(lure, options, moved):
    status, out, err = lure("simulate", "paper-rod", *SHORT, *STRIKE, *options)
    said = " ".join(out.split())
    assert (status, err) == (0, "")
    assert said.startswith(f"paper-rod (changed) up to 0.0005 s: {moved}")
    assert "Contact: once, first at 0.0001" in said
    assert ("it is not a motion of the rod" in said) is (moved != "the rod itself")
    assert max(map(len, out.splitlines())) <= 80


def test_ends_that_are_not_those_of_the_system_are_said(lure):
    def said(*options):
        return " ".join(lure("simulate", "paper-rod", *SHORT, *options)[1].split())

    assert "Ends:" not in said()
    assert "Ends: x = 0 is free, k = 0." in said("--boundary", "free", "--method", "scheme")
    rigid = said("--boundary", "clamped", "--rigid", "--end-damping", "0.5")
    assert "Ends: x = 0 is clamped, the obstacle is rigid, x = L has a dashpot of 0.5 N s/m." in rigid


def test_json_is_plain_and_alone(lure, here):
    status, out, err = lure("simulate", "paper-rod", *SHORT, *STRIKE, "--json", "-o", "run.nc")
    found = json.loads(out)
    assert (status, err) == (0, "Written: run.nc\n")
    assert found["attributes"]["subject"] == "rod"
    assert found["attributes"]["evidence"] == "computed"
    assert len(found["impacts"]) == 1
    assert found["largest_stress"] == found["impacts"][0]["peak_stress"] > 0
    assert names(here) == ["run.nc"]


def test_quiet_is_only_the_summary(lure):
    _, out, err = lure("simulate", "paper-rod", *SHORT, "-o", "run.nc", "-q")
    assert "Written" not in out + err
    assert "Contact: none" in out


@pytest.mark.slow
def test_two_runs_write_the_same_bytes(lure, here):
    for name in ("a", "b"):
        drawn = ("--plot", f"{name}.svg", "--span", "0", "4e-4")
        assert lure("simulate", "paper-rod", *SHORT, *STRIKE, "-o", f"{name}.nc", *drawn)[0] == 0
    assert len(names(here)) == 4
    assert (here / "a.nc").read_bytes() == (here / "b.nc").read_bytes()
    assert (here / "a.svg").read_bytes() == (here / "b.svg").read_bytes()


def test_without_an_end_the_system_gives_it(lure):
    status, out, _ = lure("simulate", "paper-rod", "--method", "scheme", "--samples", "2")
    assert status == 0
    assert "paper-rod up to 0.0025 s: the upwind scheme of 10 cells" in " ".join(out.split())


def test_a_file_that_exists_is_replaced_with_force_only(lure, here):
    (here / "run.nc").write_text("old")
    status, _, err = lure("simulate", "paper-rod", *SHORT, "-o", "run.nc")
    assert (status, err) == (2, "lure: 'run.nc' exists; give another name, or --replace to replace it\n")
    assert (here / "run.nc").read_text() == "old"
    assert lure("simulate", "paper-rod", *SHORT, "-o", "run.nc", "--replace")[0] == 0
    with xarray.open_dataset("run.nc") as found:
        assert found.sizes["t"] == 21


@pytest.mark.slow
def test_fields_kept_for_a_picture_only_are_not_in_the_file(lure):
    drawn = ("--method", "scheme", "--space-time", "run.png")
    assert lure("simulate", "paper-rod", *SHORT, *drawn, "-o", "run.nc")[0] == 0
    with xarray.open_dataset("run.nc") as found:
        assert "x" not in found.sizes


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (
            ("kalman-fitts",),
            "kalman-fitts is a Lur'e loop, and lure simulate follows rods; give a rod such as paper-rod",
        ),
        (("paper-rot",), "there is no built-in system 'paper-rot'; did you mean 'paper-rod'?"),
        (("paper-rod", "--method", "euler"), "method is 'euler'; give one of exact, scheme, galerkin, LSODA,"),
        (("paper-rod", "--until", "0"), "until is 0.0; give a positive number of seconds"),
        (("paper-rod", "--until", "nan"), "until is nan; give a positive number of seconds"),
        (("paper-rod", "--until", "-1"), "until is -1.0; give a positive number of seconds"),
        (("paper-rod", "--samples", "1"), "samples is 1; give a whole number from 2 to 1000000"),
        (("paper-rod", "--fields", "-3"), "fields is -3; with 2001 samples"),
        (("paper-rod", "-o", "none/run.nc"), "'none' is no directory; give a file in one that exists"),
        (("paper-rod", "-o", "run.csv"), "output is 'run.csv', and netCDF is written; give a name that ends in .nc"),
        (("paper-rod", "--plot", "run.bmp"), "plot is 'run.bmp'; give a name that ends in .svg or .png"),
        (("paper-rod", "--animation", "run.avi"), "animation is 'run.avi'; give a name that ends in .gif or .mp4"),
        (("paper-rod", "--plot", "a.png", "--space-time", "a.png"), "'a.png' is given for two results"),
        (("paper-rod", "--span", "0", "1e-3"), "span is the interval of time to draw; give plot,"),
        (
            ("paper-rod", "--plot", "a.png", "--span", "0", "1"),
            "span is 0 to 1 s; give two instants in order in [0, 0.00",
        ),
        (("paper-rod", "--plot", "a.png", "--span", "1e-3", "1e-3"), "span is 0.001 to 0.001 s; give two instants"),
        (("paper-rod", "--method", "galerkin", "--rigid"), "rigid is for the rod itself; leave it out"),
        (("paper-rod", "--boundary", "glued"), "boundary is 'glued'; give one of dashpot, free, matched, clamped"),
        (("paper-rod", "--end-damping", "-1"), "Boundary.end_damping is -1.0"),
        (("paper-rod", "--rigid", "--set", "rod.gap=-1"), "initial.u0 and rod.gap put the end"),
        (("paper-rod", "--method", "galerkin", "--order", "1"), "galerkin.order is 1"),
        (
            ("paper-rod", "--method", "LSODA", "--animation", "run.gif"),
            "method LSODA with 10 cells keeps the end of the rod",
        ),
        (
            ("paper-rod", "--method", "scheme", "--cells", "1200", "--set", "force.f=1"),
            "force.f is 1; structured_motion takes no body force",
        ),
        (
            ("paper-rod", "--until", "1", "--space-time", "run.png", "--span", "0", "0.5"),
            "span is 0 to 0.5 s, 3e+03 transits of the rod; a picture shows the waves of at most 80",
        ),
        (
            ("paper-rod", "--method", "scheme", "--samples", "11", "--animation", "frames", "-o", "run.nc"),
            "samples is 11, 0.67 in a transit of the rod; for its waves to be seen give at least 61",
        ),
    ],
)
def test_what_is_refused_is_one_sentence_and_leaves_nothing(lure, here, arguments, sentence):
    status, out, err = lure("simulate", *arguments)
    assert (status, out) == (2, "")
    assert err.startswith(f"lure: {sentence}")
    assert err.count("\n") == 1
    assert names(here) == []


def test_a_missing_package_is_said_before_anything_is_computed(lure, here, monkeypatch):
    monkeypatch.setitem(sys.modules, "netCDF4", None)
    status, out, err = lure("simulate", "paper-rod", "--until", "1e6", "-o", "run.nc")
    assert (status, out, err) == (2, "", 'lure: a netCDF file needs netCDF4: pip install "lure[netcdf]"\n')
    assert names(here) == []


def test_missing_ffmpeg_is_said_before_anything_is_computed(lure, here, monkeypatch):
    monkeypatch.setenv("PATH", str(here))
    status, out, err = lure("simulate", "paper-rod", "--until", "1e6", "--animation", "run.mp4")
    assert (status, out) == (2, "")
    assert "MP4 needs ffmpeg, which is not on PATH; give a name that ends in .gif" in err
    assert names(here) == []


def test_a_read_only_directory_is_refused(lure, here, monkeypatch):
    from pathlib import Path

    def refuse(self, **_options):
        raise PermissionError(13, "Permission denied", str(self))

    monkeypatch.setattr(Path, "touch", refuse)
    status, out, err = lure("simulate", "paper-rod", *SHORT, "-o", "run.nc")
    assert (status, out) == (2, "")
    assert err == "lure: 'run.nc' cannot be written (Permission denied); give another place\n"


def test_a_disk_that_fills_leaves_nothing(lure, here, monkeypatch):
    def fill(self, path, **_options):
        path.write_bytes(b"half")
        raise OSError(28, "No space left on device", str(path))

    monkeypatch.setattr(xarray.Dataset, "to_netcdf", fill)
    status, _, err = lure("simulate", "paper-rod", *SHORT, "-o", "run.nc")
    assert (status, err) == (2, "lure: 'run.nc' cannot be written (No space left on device); give another place\n")
    assert names(here) == []


def test_an_interrupted_run_leaves_nothing(lure, here, monkeypatch):
    def interrupt(self, path, **_options):
        path.write_bytes(b"half")
        raise KeyboardInterrupt

    monkeypatch.setattr(xarray.Dataset, "to_netcdf", interrupt)
    assert lure("simulate", "paper-rod", *SHORT, "-o", "run.nc")[0] == 130
    assert names(here) == []


def test_the_help_names_every_method(lure):
    from lure.analysis.rod.runs.request import METHODS

    status, out, _ = lure("simulate", "--help")
    assert status == 0
    assert all(method in out for method in METHODS)
    assert max(map(len, out.splitlines())) <= 80
