"""Every figure is handed out by its package, and none of it waits for matplotlib."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import lure.analysis.plots
import lure.analysis.rod.plots

PACKAGES = (lure.analysis.plots, lure.analysis.rod.plots)
DRAWN = sorted(
    (package.__name__, path.stem, node.name)
    for package in PACKAGES
    for path in Path(package.__file__).parent.glob("*.py")
    for node in ast.parse(path.read_text(encoding="utf-8")).body
    if isinstance(node, ast.FunctionDef) and node.name.startswith("plot_")
)


def test_there_are_figures():
    assert len(DRAWN) > 30


@pytest.mark.parametrize(("package", "home", "name"), DRAWN)
def test_every_figure_is_handed_out(package, home, name):
    found = getattr(sys.modules[package], name)
    assert found.__module__ == f"{package}.{home}"
    assert name in dir(sys.modules[package])


def test_what_is_not_there_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'plot_nothing'"):
        lure.analysis.plots.plot_nothing  # noqa: B018  (the access is tested)


@pytest.mark.slow
def test_every_figure_can_be_imported_first_and_without_matplotlib():
    imports = "; ".join(f"from {package} import {name}" for package, _, name in DRAWN)
    code = f"import sys; {imports}; print('matplotlib' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("False\n", "")
