"""What `lure init` writes for newcomers: a notebook about their own loop, and a test that guards their nonlinearity."""

import json
import re
from pathlib import Path

import pytest
from inner import ran_pytest, ran_python

from lure.analysis.starters import nonlinearity_test, notebook_json, notebook_script

ROOT = Path(__file__).parents[2]
NOTEBOOKS = sorted((ROOT / "notebooks").glob("[0-9]*.py"))
MARKED = re.compile(r"^# -+ change these two lines\n(.*?)^# -+\n", re.MULTILINE | re.DOTALL)


# the notebook


def test_there_is_one_source_of_the_starter_notebook():
    assert notebook_script() == (ROOT / "notebooks/50-your-own-loop.py").read_text(encoding="utf-8")
    assert not list((ROOT / "analysis/starters").glob("*loop*"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_script_becomes_the_notebook_that_jupytext_makes_of_it(path):
    jupytext, nbformat = pytest.importorskip("jupytext"), pytest.importorskip("nbformat")
    script = path.read_text(encoding="utf-8")
    made = nbformat.reads(notebook_json(script), as_version=4)
    nbformat.validate(made)
    theirs = jupytext.reads(script, fmt="py:percent")
    assert [(cell.cell_type, cell.source) for cell in made.cells] == [
        (cell.cell_type, cell.source) for cell in theirs.cells
    ]
    assert len({cell.id for cell in made.cells}) == len(made.cells) > 5


def test_code_of_the_notebooks_fits_the_boxes_of_their_pages():
    code = [(path.stem, line) for path in NOTEBOOKS for line in path.read_text("utf-8").splitlines() if line[:1] != "#"]
    assert [(name, line) for name, line in code if len(line) > 85] == []


def test_two_lines_are_marked_for_change():
    (marked,) = MARKED.findall(notebook_script())
    assert re.findall(r"^(\w+) = ", marked, re.MULTILINE) == ["PLANT", "PHI"]
    assert len(marked.splitlines()) == 2


def with_own(plant, nonlinearity):
    """The starter notebook with its two lines changed."""
    own = f"# --- change these two lines\nPLANT = {plant}\nPHI = {nonlinearity}\n# ---\n"
    return MARKED.sub(lambda _: own, notebook_script())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("plant", "nonlinearity", "said"),
    [
        # |H| < 1 but at 0, where H = 1: Re H > -1, the circle criterion for slope and sector [0, 1]
        pytest.param(
            *('"exp(-s)/(s+1)"', '__import__("lure").Tanh()', ("PROVED: 0 attracts every solution", "(certified)")),
            marks=pytest.mark.thorough,
        ),
        # unstable, with small gains too; of a function a sample is all that is known
        pytest.param(
            *("([1], [1, -1, 1])", "lambda sigma: sigma / (1 + sigma**2)", ("REFUTED: ", "(observed)")),
            marks=pytest.mark.thorough,
        ),
        # discrete time, |H| <= 2 on the circle: [0, 1/2] is inside what the circle criterion proves; Nyquist, not
        # Popov; bounds seen of a function are broken by another sample (1e-12 < 1e-9), which is said and is no stop
        ("control.tf([1], [1, -0.5], 1)", "lambda e: max(-1, min(1, e / 2))", ("PROVED: ", "Nyquist plot", "leaves")),
    ],
)
def test_the_notebook_serves_other_plants_and_laws(here, plant, nonlinearity, said):
    (here / "own.py").write_text(with_own(plant, nonlinearity), encoding="utf-8")
    status, out = ran_python("own.py")
    assert status == 0, out
    assert all(words in out for words in said)
    assert "All of it holds." not in out  # that is about the motor


def test_init_writes_the_notebook_in_both_forms_and_overwrites_nothing(lure, here):
    status, out, err = lure("init", "--notebook", "my loop.ipynb")
    assert (status, err) == (0, "")
    assert out.startswith("my loop.ipynb is written; ")
    assert out.endswith("jupyter lab 'my loop.ipynb'\n")
    written = json.loads((here / "my loop.ipynb").read_text(encoding="utf-8"))
    assert (written["nbformat"], written["nbformat_minor"]) == (4, 5)
    assert lure("init", "--notebook", "loop.py")[1].endswith("python loop.py\n")
    assert (here / "loop.py").read_text(encoding="utf-8") == notebook_script()
    (here / "loop.py").write_text("mine")
    status, _, err = lure("init", "--notebook", "loop.py")
    assert (status, err) == (2, "lure: 'loop.py' exists; give another name, or --force to replace it\n")
    assert (here / "loop.py").read_text() == "mine"
    assert lure("init", "--notebook", "loop.py", "--force")[0] == 0
    assert (here / "loop.py").read_text(encoding="utf-8") == notebook_script()


# the test of a nonlinearity


def test_the_test_passes_as_written_and_fails_where_the_bound_is_halved(lure, here):
    status, out, err = lure("init", "--test", "test_phi.py")
    assert (status, err) == (0, "")
    assert out == "test_phi.py is written; edit the nonlinearity and its bounds, then run: pytest test_phi.py\n"
    text = (here / "test_phi.py").read_text(encoding="utf-8")
    assert text == nonlinearity_test()
    (here / "test_half.py").write_text(text.replace("LOWER, UPPER = 0, 20", "LOWER, UPPER = 0, 10"), encoding="utf-8")
    status, out = ran_pytest("test_phi.py", "test_half.py")
    assert status == 1
    assert "2 failed, 2 passed" in out
    assert re.findall(r"^FAILED (\w+\.py)", out, re.MULTILINE) == ["test_half.py", "test_half.py"]
    assert "leaves the sector [0, 10]: phi(sigma)/sigma = 20" in out
    assert "leaves the slope bounds [0, 10]: slope 20" in out
    assert "X fails" in out  # the plot of it


# what is refused


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (
            ("--notebook", "loop.toml"),
            "--notebook is 'loop.toml'; give a name that ends in .ipynb or .py, such as my-loop.ipynb",
        ),
        (("--test", "law"), "--test is 'law'; give a name that ends in .py, such as test_phi.py"),
        (("--test", "no/such/test_phi.py"), "'no/such' is no directory; give a file in one that exists"),
        (("rod.toml", "--test", "a.py"), "PATH and --test do not go together; each writes a file of its own"),
        (("--loop", "--notebook", "a.py"), "--loop and --notebook do not go together"),
        (("--notebook", "a.py", "--test", "b.py"), "--notebook and --test do not go together"),
    ],
)
def test_init_refuses_in_one_sentence_and_writes_nothing(lure, here, arguments, sentence):
    status, out, err = lure("init", *arguments)
    assert (status, out) == (2, "")
    assert err.startswith(f"lure: {sentence}")
    assert err.count("\n") == 1
    assert list(here.iterdir()) == []
