"""The README: what it shows is what happens, and what it names is there (its Python runs as a doctest)."""

import re
import shlex
from pathlib import Path

import pytest
from documents import rounded

from analysis.cli import main

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
LINES = [
    line.split(" #")[0].strip()
    for block in re.findall(r"```sh\n(.*?)```", README, re.DOTALL)
    for line in block.split("\n")
]
# the paper's reproduction takes a minute and has tests of its own
COMMANDS = [line for line in LINES if line.startswith("lure ") and "reproduce" not in line]
STATUSES = re.findall(r"^\| (\d+) \|.*`(lure [^`]+)`", README, re.MULTILINE)
TARGETS = re.findall(r"^([a-z-]+):.*##", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)


def test_the_report_shown_is_the_report_printed(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (shown,) = re.findall(r"```text\n(.*?)```", README, re.DOTALL)
    assert main(["report"]) == 0
    # the residual of the energy identity is rounding: its digits differ from one machine to the next
    printed, shown = (re.sub(r"within \S+;", "within rounding;", text) for text in (capsys.readouterr().out, shown))
    assert printed == shown


def test_the_commands_shown_work_one_after_another(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert {command: main(shlex.split(command)[1:]) for command in COMMANDS} == dict.fromkeys(COMMANDS, 0)
    assert len(COMMANDS) >= 5
    assert {command: main(shlex.split(command)[1:]) for _, command in STATUSES} == {
        command: int(status) for status, command in STATUSES
    }
    assert [status for status, _ in STATUSES] == ["10", "11"]


@pytest.mark.parametrize("block", re.findall(r"^\$ (.*\n(?:[^$`].*\n)+)", README, re.MULTILINE))
def test_the_answers_shown_are_the_answers_printed(block, capsys):
    command, shown = block.split("\n", 1)
    assert main(shlex.split(command)[1:]) == 0
    assert rounded(capsys.readouterr().out).startswith(rounded(shown))


def test_every_make_target_shown_exists_and_every_one_but_two_is_shown():
    shown = set(re.findall(r"\bmake ([a-z-]+)", "\n".join(LINES)))
    assert shown == set(TARGETS) - {"help", "clean"}


@pytest.mark.parametrize("link", re.findall(r"\]\((?!https?:)([^)#]+)\)", README))
def test_every_file_that_is_linked_exists(link):
    assert (ROOT / link).exists()


def test_every_notebook_and_folder_is_in_the_map():
    folders = {path.parent.name for path in ROOT.glob("[a-z]*/*.py")} - {"build"}
    missing = [f"{name}/" for name in sorted(folders) if f"[`{name}/`]({name})" not in README]
    missing += [path.name for path in ROOT.glob("notebooks/*.py") if f"(notebooks/{path.name})" not in README]
    assert missing == []


def test_the_figure_is_small_and_says_what_it_shows():
    ((words, figure),) = re.findall(r"!\[(.*?)\]\((.*?)\)", README)
    assert len(words) > 20
    assert (ROOT / figure).stat().st_size < 200_000
