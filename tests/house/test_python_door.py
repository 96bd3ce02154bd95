"""From Python: a plant and a nonlinearity in any form, the same names with a star, and the report."""

import json

import control
import pytest

import lure.analysis
from lure import (
    ExpressionNonlinearity,
    InputError,
    Loop,
    NonlinearityClass,
    Saturation,
    Sector,
    SlopeBounds,
    builtin_loop,
)
from lure.analysis import analyse, certify, report_on
from lure.analysis.verdict import Verdict
from lure.rod import builtin_system

THIRD = "1/(s*(s+1)*(s+2))"  # Popov: sectors [0, k] with k < 6


def starred(package):
    names = {}
    exec(f"from {package} import *", names)
    return set(names)


def test_a_star_brings_every_public_name():
    assert {"max_sector", "max_slope", "analyse", "certify", "report_on", "nonlinearity_bounds"} <= starred(
        "lure.analysis"
    )
    assert set(lure.analysis.__all__) <= starred("lure.analysis") & set(dir(lure.analysis))
    assert {"as_plant", "Loop", "Saturation", "Sector", "builtin_loop"} <= starred("lure")
    for name in lure.analysis.__all__:
        assert getattr(lure.analysis, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'max_sectr'"):
        lure.analysis.max_sectr  # noqa: B018  (the access is tested)


@pytest.mark.parametrize(
    ("nonlinearity", "words"),
    [
        (Saturation(), "odd phi with slope in [0, 1]"),
        (control.saturation_nonlinearity(1), "odd phi with slope in [0, 1]"),
        ("min(max(sigma, -1), 1)", "odd phi with slope in [0, 1]"),
        (ExpressionNonlinearity("3*sigma", sector=Sector(0, 4)), "phi"),
        (NonlinearityClass.slope_restricted(0, 5, odd=True), "odd phi with slope in [0, 5]"),
        (Sector(0, 5), "phi in the sector [0, 5]"),
        (SlopeBounds(0, 5), "phi with slope in [0, 5]"),
    ],
)
def test_questions_take_a_plant_and_a_nonlinearity(nonlinearity, words):
    found = analyse("5/(s+1)", nonlinearity)
    assert found.verdict is Verdict.PROVED
    assert words in str(found.problem.given)
    assert certify("5/(s+1)", nonlinearity).verdict is Verdict.PROVED


def test_a_sector_is_decided_as_its_class_is():
    for upper, verdict in ((5, Verdict.PROVED), (7, Verdict.REFUTED)):
        assert certify(THIRD, Sector(0, upper)).verdict is verdict
        assert certify(THIRD, NonlinearityClass(sector=Sector(0, upper))).verdict is verdict
    certificate = certify(THIRD, Sector(0, 5)).shown.certificate
    assert certificate["laws"] == certify(THIRD, NonlinearityClass(sector=Sector(0, 5))).shown.certificate["laws"]


@pytest.mark.parametrize(
    "plant",
    [Loop(THIRD, Saturation()), builtin_loop("contact"), builtin_loop("iqc-resonance"), builtin_system("paper-rod")],
)
def test_two_nonlinearities_are_one_too_many(plant):
    with pytest.raises(InputError, match="closes the loop itself and a nonlinearity is given beside it"):
        analyse(plant, Saturation())


@pytest.mark.slow
def test_a_named_plant_keeps_its_name():
    found = analyse(builtin_loop("triple-lag"), Sector(0, 7))
    assert found.problem.name == "triple-lag"
    assert found.verdict is Verdict.PROVED


@pytest.mark.usefixtures("sketched")
def test_a_report_from_python_is_the_report(tmp_path):
    found = report_on(control.tf([1], [1, 1]), Saturation(gain=2), output=tmp_path / "out")
    assert found.verdict is Verdict.PROVED
    data = json.loads((tmp_path / "out" / "report.json").read_text("utf-8"))
    assert data["conclusion"]["verdict"] == "PROVED"
    assert data["system"]["law"] is not None
    assert (tmp_path / "out" / "report.html").exists()
    assert "report_on" in data["reproduce"]["command"]


def test_a_report_of_objects_needs_no_directory(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert report_on(Loop("1/(s+1)", Saturation())).verdict is Verdict.PROVED
    assert report_on("1/(s-1)").verdict is Verdict.REFUTED
    assert report_on(builtin_loop("contact")).verdict is Verdict.PROVED
    assert not list(tmp_path.iterdir())
    (tmp_path / "mine").write_text("kept")
    with pytest.raises(InputError, match="mine"):
        report_on("1/(s+1)", Saturation(), output=tmp_path / "mine")
