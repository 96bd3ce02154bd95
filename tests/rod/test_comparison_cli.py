"""``lure compare``: the table, JSON, the figure, and what is refused before anything is computed."""

import json
import re

import pytest
import typer

from lure.analysis.cli import main
from lure.analysis.cli import rods as comparing
from lure.analysis.cli.texts import COMPARE


@pytest.fixture
def lure(capsys, tmp_path, monkeypatch):
    """Run a command in an empty directory; its exit status, stdout and stderr."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        status = main(arguments)
        out, err = capsys.readouterr()
        return status, out, err

    return run


SMALL = ("compare", "paper-rod", "--cells", "10,20", "--galerkin", "none", "--samples", "101")


def test_the_table_and_the_figure(lure, tmp_path):
    status, out, err = lure(*SMALL, "--plot", "all.svg")
    assert (status, err) == (0, "")
    assert out.startswith("The end of the rod up to 0.0025 s: amplitude")
    assert out.endswith("Written: all.svg\n")
    assert max(map(len, out.splitlines())) <= 80
    assert "numerical dissipation" in out
    assert (tmp_path / "all.svg").read_text().startswith("<?xml")
    assert [path.name for path in tmp_path.iterdir()] == ["all.svg"]


@pytest.mark.slow
def test_json_has_stdout_for_itself(lure):
    status, out, err = lure(*SMALL, "--json", "--plot", "all.png", "--until", "1e-3")
    assert (status, err) == (0, "Written: all.png\n")
    data = json.loads(out)
    assert data["until"] == 1e-3
    assert [row["size"] for row in data["rows"]] == [10, 20]
    quiet = lure(*SMALL, "--json", "-q", "--plot", "all.png", "--replace", "--until", "1e-3")
    assert quiet[0] == 0
    assert quiet[2] == ""


@pytest.mark.slow
def test_cells_spaces_method_and_settings_are_used(lure):
    arguments = ("--cells", "none", "--galerkin", "cosine:4,P1:5", "--set", "rod.gap=5e-5", "--until", "3e-4")
    data = json.loads(lure("compare", "paper-rod", *arguments, "--json")[1])
    assert [(row["family"], row["size"]) for row in data["rows"]] == [("Galerkin P1", 5), ("Galerkin cosine", 4)]
    assert data["rod"]["gap"] == 5e-5
    assert len(data["exact"]["contacts"]) == 1
    data = json.loads(lure(*SMALL, "--method", "RK45", "--json")[1])
    assert [row["integrator"] for row in data["rows"]] == ["RK45", "RK45"]
    assert data["rows"][0]["evaluations"] > data["rows"][0]["steps"] > 10


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("--cells", "10,x"), "--cells is '10,x'; give whole numbers such as 10,50,200, or none"),
        (("--cells", "10,10"), "cells is [10, 10]; give every model once"),
        (("--galerkin", "P1"), "--galerkin is 'P1'; give pairs such as P1:51,cosine:50, or none"),
        (("--galerkin", "P4:5"), "galerkin.space is 'P4'; give one of P1, P2, cosine"),
        (("--plot", "x.gif"), "--plot is 'x.gif'; give a name that ends in .svg, .png or .pdf"),
        (("--plot", "no/x.svg"), "'no' is no directory; give a file in one that exists"),
        (("--method", "euler"), "method is 'euler'; give one of exact, RK45"),
        (("--until", "nan"), "until is nan; give a positive number of seconds"),
    ],
)
def test_bad_input_is_one_sentence_and_leaves_no_file(lure, tmp_path, arguments, sentence):
    status, out, err = lure("compare", "paper-rod", *arguments)
    assert (status, out) == (2, "")
    assert err.startswith(f"lure: {sentence}")
    assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_a_figure_that_exists_is_kept_without_force(lure, tmp_path):
    (tmp_path / "all.svg").write_text("mine")
    status, _, err = lure(*SMALL, "--plot", "all.svg")
    assert status == 2
    assert "'all.svg' exists; give another name, or --replace to replace it" in err
    assert (tmp_path / "all.svg").read_text() == "mine"
    assert lure(*SMALL, "--plot", "all.svg", "--replace")[0] == 0
    assert (tmp_path / "all.svg").read_text().startswith("<?xml")


@pytest.mark.parametrize("system", ["kalman-fitts", "paper-rod-figure-8"])
def test_what_is_no_rod_or_no_scheme_of_its_rod_is_refused(lure, system):
    status, out, err = lure("compare", system)
    assert (status, out) == (2, "")
    assert system in err


def test_the_help_fits_and_its_examples_are_understood(lure):
    status, out, _ = lure("compare", "--help")
    assert status == 0
    assert max(map(len, out.splitlines())) <= 80
    command = typer.main.get_command(comparing.app).commands["compare"]
    options = {name for parameter in command.params for name in parameter.opts}
    used = set(re.findall(r"--[a-z]+", COMPARE))
    assert used
    assert used <= options
