"""A report on extreme input, and what it says of a simulation that tests little."""

import json

import pytest
from depth import thorough

from lure.analysis.cli import main


@pytest.mark.parametrize(
    ("setting", "status", "skipped"),
    [
        ("rod.damping=1e300", 0, None),
        ("rod.damping=1e-100", 0, None),
        ("rod.damping=-1.1999999999", 11, None),
        ("initial.u0=1e160*x", 0, "rescale the units"),
        ("initial.u0=1e-200*x", 0, "rescale the units"),
        ("simulation.until=1e300", 0, "give at most"),
        ("rod.compliance=1e-30", 0, "give a larger compliance"),
    ],
)
@pytest.mark.slow
def test_extreme_but_legal_input_gets_its_verdict_and_an_honest_simulation(
    tmp_path, monkeypatch, request, setting, status, skipped
):
    monkeypatch.chdir(tmp_path)
    if setting != "rod.damping=1e300" or not thorough():  # its figures are written
        request.getfixturevalue("sketched")
    assert main(["report", "--set", setting, "--set", "rod.gap=0", "--quiet"]) == status
    data = json.loads((tmp_path / "lure-report" / "report.json").read_text())
    if skipped is None:
        assert data["simulation"]["agrees"] is True
        assert "energy identity" in data["simulation"]["compared"]
    else:
        assert skipped in data["simulation"]["skipped"]
        assert data["simulation"]["agrees"] is None


def test_a_dashpot_too_weak_for_doubles_is_refused_in_one_sentence(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["report", "--set", "rod.damping=1e-200", "--quiet"]) == 2
    assert "give a damping of at least 1e-150 times the impedance, or 0" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("sketched")
@pytest.mark.parametrize(
    ("settings", "compared"),
    [
        ([], ["energy identity", "Popov-Lyapunov function", "zeta", "resting place"]),
        pytest.param(["force.g=0.001"], ["energy identity"], marks=pytest.mark.slow),
        pytest.param(["rod.damping=0"], ["energy identity"], marks=pytest.mark.thorough),
        pytest.param(["rod.damping=-0.1"], ["energy identity"], marks=pytest.mark.thorough),
        (["initial.u0=0"], []),
    ],
)
def test_only_what_was_compared_is_said_to_agree(tmp_path, monkeypatch, settings, compared):
    monkeypatch.chdir(tmp_path)
    main(["report", *(word for setting in settings for word in ("--set", setting)), "--quiet"])
    simulation = json.loads((tmp_path / "lure-report" / "report.json").read_text())["simulation"]
    assert simulation["compared"] == compared
    assert simulation["agrees"] is (True if compared else None)


@pytest.mark.slow_for("1-")
@pytest.mark.usefixtures("sketched")
@pytest.mark.parametrize(("coefficient", "but"), [('"a"', "but for the parameters "), ("1", "")])
def test_which_numbers_are_taken_as_exact(tmp_path, coefficient, but):
    box = '[plant.parameters]\na = ["0.8", "1.2"]\n' if but else ""
    file = tmp_path / "own.toml"
    file.write_text(f"[plant]\nnum = [1]\nden = [1, {coefficient}]\n{box}[class]\nsector = [0, 2]\n", encoding="utf-8")
    assert main(["report", str(file), "-o", str(tmp_path / "out"), "--quiet"]) == 0
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert f"about other coefficients: {but}the numbers are taken as exact" in page
