"""``lure sector``: what it prints, draws and refuses, and its exit status."""

import json
import math

import numpy as np
import pytest
import typer
from depth import sampled
from matplotlib.figure import Figure

from lure.analysis.cli import main, sectors
from lure.analysis.cli.texts import SECTOR
from lure.analysis.nonlinearity import nonlinearity_bounds, search
from lure.analysis.plots.sectors import plot_nonlinearity_sector, plot_nonlinearity_slope
from lure.nonlinearities import Quantiser, Saturation


@pytest.fixture
def lure(capsys, tmp_path, monkeypatch):
    """Run a command in an empty directory; its exit status, stdout and stderr."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        status = main(("sector", *arguments))
        out, err = capsys.readouterr()
        return status, out, err

    return run


def test_a_law_on_an_interval(lure):
    status, out, err = lure("--expr", "max(x,0)**1.5", "--on", "-1", "1")
    assert (status, err) == (0, "")
    assert out.splitlines()[:2] == ["max(x,0)**1.5 for sigma in [-1, 1] (certified)", "  sector [0, 1]"]
    assert "attained at sigma = 1" in out
    assert "slope" not in out


def test_slopes_are_asked_for(lure):
    status, out, _ = lure("--expr", "where(x>1,2*x,x)", "--slope")
    assert status == 0
    assert "slope [1, inf]" in out
    assert "a jump at 1" in out
    assert "sector" not in out


@pytest.mark.slow_for("arguments4-10-is not decided")
@pytest.mark.parametrize(
    ("arguments", "status", "words"),
    [
        (("--expr", "sin(x)", "--within", "-0.25", "1"), 0, "lies within the sector [-0.25, 1] (certified)"),
        (("--expr", "sin(x)", "--within", "-0.2", "1"), 11, "leaves the sector [-0.2, 1]: phi(sigma)/sigma = -0.2172"),
        (("--expr", "x**3", "--within", "0", "inf"), 0, "lies within the sector [0, inf]"),
        (("--expr", "x**3", "--slope", "--within", "-inf", "5"), 11, "the difference quotient is"),
        (("--expr", "x*(sin(x)**2 + cos(x)**2)", "--within", "1/3", "1"), 10, "is not decided"),
        (("--expr", "sin(x**2)/2 + x", "--slope"), 10, "could not be shown"),
        (("--expr", "x/3", "--within", "0", "1/3"), 0, "lies within the sector [0, 1/3]"),
    ],
)
def test_the_exit_status_says_what_was_shown(lure, monkeypatch, arguments, status, words):
    monkeypatch.setattr(search, "MOST_BOXES", sampled(400, of=search.MOST_BOXES))  # what is undecided takes them all
    found, out, err = lure(*arguments)
    assert (found, err) == (status, "")
    assert words in " ".join(out.split())
    assert max(map(len, out.splitlines())) <= 80


def test_json_has_stdout_for_itself(lure):
    status, out, err = lure("--expr", "sin(x)", "--within", "-0.2", "1", "--json", "--plot", "law.svg")
    document = json.loads(out)
    assert status == 11
    assert err == "Written: law.svg\n"
    assert document["schema"] == "lure-sector/1"
    assert document["evidence"] == "certified"
    assert document["within"]["verdict"] == "REFUTED"
    (point,) = document["within"]["violation"]["points"]
    assert math.sin(point["double"]) / point["double"] < -0.2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "give a nonlinearity with --expr, or a file"),
        (("data.csv", "--expr", "x"), "give a nonlinearity with --expr, or a file"),
        (("--expr", "1/x"), "divides by zero"),
        (("--expr", "x", "--on", "1", "zz"), "--on has 'zz'"),
        (("--expr", "x", "--on", "1", "1e999"), "--on has '1e999'"),
        (("--expr", "x", "--on", "1", "0"), "give low < high"),
        (("--expr", "x", "--within", "2", "1"), "--within is 2 1; the first number must be smaller"),
        (("--expr", "x", "--plot", "a.bmp"), "ends in .svg or .png"),
        (("--expr", "x", "--plot", "no/a.svg"), "no directory"),
    ],
)
def test_bad_input_is_one_sentence(lure, arguments, message, tmp_path):
    status, out, err = lure(*arguments)
    assert (status, out) == (2, "")
    assert message in err
    assert err.startswith("lure: ")
    assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_a_figure_that_exists_is_kept(lure, tmp_path):
    (tmp_path / "law.png").write_bytes(b"mine")
    status, _, err = lure("--expr", "x", "--plot", "law.png")
    assert status == 2
    assert "--replace" in err
    assert (tmp_path / "law.png").read_bytes() == b"mine"
    assert lure("--expr", "x", "--plot", "law.png", "--replace")[0] == 0
    assert (tmp_path / "law.png").read_bytes()[:4] == b"\x89PNG"


def test_the_help_is_registered_and_fits_a_terminal():
    command = typer.main.get_command(sectors.app).commands["sector"]
    assert command.help.splitlines()[0] == SECTOR.splitlines()[0]
    assert max(map(len, SECTOR.splitlines())) <= 80


def test_the_law_and_its_sector_are_drawn():
    axes = plot_nonlinearity_sector("x/(1 + x**2)", nonlinearity_bounds("x/(1 + x**2)"), ax=Figure().add_subplot())
    *lines, nonlinearity = [line for line in axes.lines if len(line.get_xdata()) > 2]
    x = np.asarray(nonlinearity.get_xdata())
    assert np.allclose(nonlinearity.get_ydata(), x / (1 + x**2))
    assert sorted(np.asarray(line.get_ydata())[-1] / x[-1] for line in lines) == pytest.approx([0, 1])
    assert axes.get_xlabel() == "σ"
    assert "not attained: lower as |σ| → ∞; upper as σ → 0" in axes.texts[0].get_text()


def test_attained_points_lie_on_the_law():
    axes = plot_nonlinearity_sector(
        "x*(2 - (x - 3)**2)", nonlinearity_bounds("x*(2 - (x - 3)**2)"), ax=Figure().add_subplot()
    )
    (point,) = (line for line in axes.lines if line.get_marker() == "o")
    assert (point.get_xdata()[0], point.get_ydata()[0]) == (3, 6)


def test_jumps_are_gaps_and_a_sample_is_dashed():
    axes = plot_nonlinearity_sector(
        Quantiser(step=1), nonlinearity_bounds(Quantiser(step=1)), ax=Figure().add_subplot()
    )
    nonlinearity = max(axes.lines, key=lambda line: line.get_linewidth())
    assert np.isnan(nonlinearity.get_ydata()).sum() >= 2
    dashed = plot_nonlinearity_slope(np.tanh, nonlinearity_bounds(np.tanh, on=(-2, 2)), ax=Figure().add_subplot())
    assert any(line.get_linestyle() == "--" for line in dashed.lines)


def test_slopes_are_drawn_between_their_bounds():
    nonlinearity = Saturation(gain=2, limit=1)
    axes = plot_nonlinearity_slope(nonlinearity, nonlinearity_bounds(nonlinearity), ax=Figure().add_subplot())
    slopes = np.asarray(max(axes.lines, key=lambda line: line.get_linewidth()).get_ydata())
    assert np.nanmin(slopes) == pytest.approx(0)
    assert np.nanmax(slopes) == pytest.approx(2)
