"""Every figure is handed out by `lure.analysis.plots`, and none of it waits for matplotlib."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import lure.analysis.plots

FOLDER = Path(lure.analysis.plots.__file__).parent
DRAWN = sorted(
    (path.stem, node.name)
    for path in FOLDER.glob("*.py")
    for node in ast.parse(path.read_text(encoding="utf-8")).body
    if isinstance(node, ast.FunctionDef) and node.name.startswith("plot_")
)


def test_there_are_figures():
    assert len(DRAWN) > 30


@pytest.mark.parametrize(("home", "name"), DRAWN)
def test_every_figure_is_handed_out(home, name):
    found = getattr(lure.analysis.plots, name)
    assert found.__module__ == f"lure.analysis.plots.{home}"
    assert name in dir(lure.analysis.plots)


def test_what_is_not_there_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'plot_nothing'"):
        lure.analysis.plots.plot_nothing  # noqa: B018


def test_every_figure_can_be_imported_first_and_without_matplotlib():
    names = ", ".join(name for _, name in DRAWN)
    code = f"import sys; from lure.analysis.plots import {names}; print('matplotlib' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("False\n", "")
