"""The README and CONTRIBUTING: what they show is what happens, and what they name is there."""

import re
import shlex
from pathlib import Path

import pytest
from documents import run_page

from lure.analysis import popov_response
from lure.analysis.cli import main
from lure.analysis.plots import render

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
CONTRIBUTING = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
SHELL = re.findall(r"```sh\n(.*?)```", README + CONTRIBUTING, re.DOTALL)
LINES = [line.split(" #")[0].strip() for block in SHELL for line in block.split("\n")]
COMMANDS = [line for line in LINES if line.startswith("lure ")]
TARGETS = re.findall(r"^([a-z-]+):.*##", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)


def test_the_python_shown_does_what_is_shown(tmp_path):
    assert run_page(ROOT / "README.md", tmp_path) == 1


@pytest.mark.usefixtures("sketched")
def test_the_commands_shown_work_one_after_another(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert {command: main(shlex.split(command)[1:]) for command in COMMANDS} == dict.fromkeys(COMMANDS, 0)
    assert len(COMMANDS) >= 5


def test_ten_lines_are_ten_lines():
    (block,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    assert sum(line.startswith((">>>", "...")) for line in block.split("\n")) == 10


def test_every_make_target_shown_exists_and_every_one_but_two_is_shown():
    shown = set(re.findall(r"\bmake ([a-z-]+)", "\n".join(LINES)))
    assert shown == set(TARGETS) - {"help", "clean"}


@pytest.mark.parametrize("link", re.findall(r"\]\((?!https?:)([^)#]+)\)", README + CONTRIBUTING))
def test_every_file_that_is_linked_exists(link):
    assert (ROOT / link).exists()


def test_every_notebook_and_folder_is_in_the_map():
    folders = {path.parent.name for path in ROOT.glob("[a-z]*/*.py")} - {"build"}
    missing = [f"{name}/" for name in sorted(folders) if f"[`{name}/`]({name})" not in README]
    missing += [path.name for path in ROOT.glob("notebooks/*.py") if f"(notebooks/{path.name})" not in README]
    assert missing == []


@pytest.mark.usefixtures("sketched")
@pytest.mark.parametrize(
    ("answer", "command"),
    [
        ("PROVED", ["certify", "--num", "1", "--den", "1 3 2 0", "--sector", "0", "5.9", "-o", "-"]),  # Popov: up to 6
        ("REFUTED", ["certify", "--num", "1", "--den", "1 3 2 0", "--sector", "0", "6.1", "-o", "-"]),  # Routh: k < 6
        ("INCONCLUSIVE", ["report", "--set", "rod.damping=0", "-o", "undamped"]),
    ],
)
def test_the_statuses_shown_are_those_of_the_commands(answer, command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    statuses = dict(re.findall(r"^\| \*\*(\w+)\*\* \| (\d+) \|", README, re.MULTILINE))
    assert main(command) == int(statuses[answer])


NUMBER = re.compile(r"-?\d+\.?\d*")


def test_the_figure_is_small_says_what_it_shows_and_is_what_the_ten_lines_draw():
    ((words, figure),) = re.findall(r"!\[(.*?)\]\((.*?)\)", README)
    assert len(words) > 20
    kept = (ROOT / figure).read_text(encoding="utf-8")
    assert len(kept) < 200_000
    drawn = render(popov_response(([1], [1, 3, 2, 0]), k=4).plot, name="popov", size=(5.6, 4.0)).svg
    kept, drawn = ([float(number) for number in NUMBER.findall(svg)] for svg in (kept, drawn))
    assert drawn == pytest.approx(kept, abs=0.05)  # points; (ROOT / figure).write_text(drawn) renews the file
