"""`lure sector FILE` and the figures of measured data."""

import json
from functools import partial

import numpy as np
import pytest
from matplotlib.figure import Figure

from lure.analysis.cli import main
from lure.analysis.cli import sectors as sectors  # puts the command on the app
from lure.analysis.measured import EXAMPLE, Measurements, fit_compliance, report_from_data, sector_from_data
from lure.analysis.plots import render
from lure.analysis.plots.measured import plot_compliance, plot_measured

REPORT = report_from_data(EXAMPLE, fit=True)


@pytest.mark.slow
def test_the_command_prints_what_the_report_says(capsys):
    assert main(["sector", str(EXAMPLE), "--fit"]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    for line in str(REPORT).split("\n"):
        assert " ".join(line.split()) in printed


@pytest.mark.slow
def test_json_and_a_claim(capsys):
    assert main(["sector", str(EXAMPLE), "--json", "--within", "-1e5", "1e5"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["sector"]["upper"]["bound"] == REPORT.sector.upper.bound
    assert document["within"]["inside"] is True
    assert main(["sector", str(EXAMPLE), "--within", "0", "8e4"]) == 10
    assert "not within [0, 80000] (observed" in " ".join(capsys.readouterr().out.split())
    assert main(["sector", str(EXAMPLE), "--slope", "--within", "-1e6", "1e6"]) == 0


@pytest.mark.slow
def test_area_origin_and_columns(capsys):
    assert main(["sector", str(EXAMPLE), "--area", "25e-6", "--origin", "gap", "--force", "3", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["sector"]["unit"] == "Pa/m"
    assert document["sector"]["origin"] == pytest.approx(0.12e-3, abs=5e-6)


def test_an_element_with_memory_ends_with_status_10(tmp_path, capsys):
    u = np.concatenate([np.linspace(0, 1, 60), np.linspace(1, 0, 60)])
    force = (
        u - np.where(np.arange(120) < 60, 0, 0.3) * u * (1 - u) + 0.002 * np.random.default_rng(0).standard_normal(120)
    )
    path = tmp_path / "loop.csv"
    path.write_text("u [mm],F [N]\n" + "\n".join(f"{a},{b}" for a, b in zip(u, force, strict=True)), encoding="utf-8")
    assert main(["sector", str(path)]) == 10
    assert "the element has memory" in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["missing.csv"], "'missing.csv' is no file; give measured data, or a formula with --expr"),
        (["tanh(sigma)"], "'tanh(sigma)' is no file; give measured data, or a formula with --expr"),
        (["s" * 999], "cannot be read"),
        (["--expr", "x", "--within", "1", "-2"], "--within is 1 -2; the first number must be smaller than the second"),
        ([str(EXAMPLE), "--force", "weight"], "there is no such column; choose by name or number from 1: time [s]"),
        ([str(EXAMPLE), "--on", "0", "1"], "--on goes with --expr"),
        ([str(EXAMPLE), "--origin", "here"], "--origin is 'here'"),
        ([str(EXAMPLE), "--confidence", "95"], "confidence is 95.0"),
        (["--expr", "x", "--fit"], "go with a file of measured data"),
    ],
)
def test_what_is_refused_ends_with_status_2(options, message, capsys):
    assert main(["sector", *options]) == 2
    captured = capsys.readouterr()
    assert message in captured.err
    assert not captured.out


@pytest.mark.slow
def test_a_figure_is_written_once(tmp_path, capsys):
    path = tmp_path / "data.svg"
    assert main(["sector", str(EXAMPLE), "--plot", str(path)]) == 0
    assert f"Written: {path}" in capsys.readouterr().out
    before = path.read_bytes()
    assert main(["sector", str(EXAMPLE), "--plot", str(path)]) == 2
    assert main(["sector", str(EXAMPLE), "--plot", str(path), "--replace", "-q"]) == 0
    assert path.read_bytes() == before


def test_the_figure_shows_the_wedge_the_law_and_the_outliers():
    above, below = plot_measured(REPORT.sector, fit=REPORT.fit, ax=Figure().add_subplot())
    lines = {str(line.get_label()): line for line in above.lines}
    wedge = [line for label, line in lines.items() if label.startswith("slope")]
    for line, bound in zip(wedge, (REPORT.sector.lower.bound, REPORT.sector.upper.bound), strict=True):
        x, y = line.get_data()
        np.testing.assert_allclose(y, bound * np.asarray(x), rtol=1e-12)
    x, y = lines["mean nonlinearity"].get_data()
    np.testing.assert_allclose(y, REPORT.sector.nonlinearities[0](x), rtol=1e-12)
    x, y = lines["fitted compliance"].get_data()
    np.testing.assert_allclose(y, REPORT.fit(x), rtol=1e-12)
    data = REPORT.measurements
    rows = [outlier.index for outlier in REPORT.sector.outliers]
    np.testing.assert_array_equal(lines["2 outliers"].get_xydata(), np.c_[data.displacement[rows], data.load[rows]])
    assert (above.get_ylabel(), below.get_ylabel(), below.get_xlabel()) == (
        "force [N]",
        "residual [std. dev.]",
        "σ [m]",
    )
    assert above.get_xlim() == below.get_xlim()


def test_the_figure_of_the_fit_shows_the_interval_of_the_gap():
    fit = fit_compliance(REPORT.measurements)
    above, _ = plot_compliance(fit, ax=Figure().add_subplot())
    (band,) = above.patches
    assert (band.get_x(), band.get_x() + band.get_width()) == pytest.approx(fit.parameters["gap"].joint)


@pytest.mark.slow
def test_pictures_are_the_same_every_time_and_unbounded_sectors_can_be_drawn():
    draw = partial(plot_measured, REPORT.sector)
    assert render(draw, name="x") == render(draw, name="x")
    u = np.linspace(-1, 1, 50)
    found = sector_from_data(Measurements.from_arrays(u, u + 1))
    above, _ = plot_measured(found, ax=Figure().add_subplot())
    assert not [line for line in above.lines if str(line.get_label()).startswith("slope")]
