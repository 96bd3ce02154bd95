"""Reports on disk: whole or not at all, and never in the place of anything else."""

import errno
import json
import os
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

import pytest

from lure.analysis import output as placing
from lure.analysis.output import checked_target, exchange, lock, replaced, write_new
from lure.errors import InputError

ROOT = Path(__file__).parents[2]


def write(directory, label):
    """A report of two files and a figure, each holding its label."""
    (directory / "report.json").write_text(json.dumps({"schema": "lure-report/1", "label": label}))
    (directory / "figures").mkdir()
    (directory / "figures" / "popov.svg").write_text(label)
    (directory / "report.html").write_text(label)


def make(target, label, then=None):
    """Write a report into the target; `then`, an error or something to call, comes before it is in place."""
    with replaced(target) as directory:
        write(directory, label)
        if isinstance(then, BaseException):
            raise then
        if then is not None:
            then()


def label(target):
    """Label of a report, after a check that all its files hold the same one."""
    labels = {
        json.loads((target / "report.json").read_text())["label"],
        (target / "figures" / "popov.svg").read_text(),
        (target / "report.html").read_text(),
    }
    assert len(labels) == 1
    return labels.pop()


def names(directory):
    return sorted(path.name for path in directory.iterdir())


@pytest.fixture(params=["exchange", "two steps"])
def way(request, monkeypatch):
    """Both ways to replace a directory: the atomic one, and the one for systems that have no other."""
    if request.param == "two steps":
        monkeypatch.setattr(placing, "exchange", lambda first, second: False)


# what is written


@pytest.mark.usefixtures("way")
def test_a_report_appears_and_is_replaced_without_leftovers(tmp_path):
    target = tmp_path / "deep" / "er" / "lure-report"
    for text in ("one", "two", "three"):
        make(target, text)
        assert label(target) == text
        assert names(target.parent) == ["lure-report"]
    assert (target.stat().st_mode & 0o777) == (target.parent.stat().st_mode & 0o777)  # as mkdir makes them, not 0700


@pytest.mark.usefixtures("way")
@pytest.mark.parametrize("error", [ValueError("x"), KeyboardInterrupt(), InputError("y"), SystemExit(3)])
def test_a_failure_leaves_the_old_report_and_nothing_else(tmp_path, error):
    target = tmp_path / "out"
    make(target, "old")
    with pytest.raises(type(error)):
        make(target, "new", error)
    assert label(target) == "old"
    assert names(tmp_path) == ["out"]


def test_a_failure_with_no_old_report_leaves_nothing(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        make(tmp_path / "out", "new", KeyboardInterrupt())
    assert names(tmp_path) == []


def test_an_empty_directory_and_a_report_of_the_paper_may_be_replaced(tmp_path):
    target = tmp_path / "out"
    target.mkdir()
    with replaced(target) as directory:
        (directory / "paper.json").write_text('{"schema": "lure-paper/1"}')
        (directory / "figure-8.png").write_bytes(b"")
    make(target, "new")
    assert label(target) == "new"


def test_what_a_file_manager_leaves_does_not_stand_in_the_way(tmp_path):
    target = tmp_path / "out"
    make(target, "old")
    (target / ".DS_Store").write_text("")
    make(target, "new")
    assert label(target) == "new"


def test_the_full_disk_is_the_users_problem_and_other_errors_are_ours(tmp_path):
    with pytest.raises(InputError, match=r"out' cannot be written \(No space left on device\); give another directory"):
        make(tmp_path / "out", "new", OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)))
    with pytest.raises(FileNotFoundError):
        make(tmp_path / "out", "new", FileNotFoundError(errno.ENOENT, "no such font", "DejaVu.ttf"))
    assert names(tmp_path) == []


def test_what_appears_in_the_target_meanwhile_is_not_overwritten(tmp_path):
    target = tmp_path / "out"
    make(target, "old")
    with pytest.raises(InputError, match=r"holds 'notes\.txt', which is not part of a report"):
        make(target, "new", lambda: (target / "notes.txt").write_text("mine"))
    assert label(target) == "old"
    assert (target / "notes.txt").read_text() == "mine"


@pytest.mark.usefixtures("way")
def test_runs_at_the_same_time_each_write_a_whole_report(tmp_path):
    target = tmp_path / "out"
    failures = []

    def run(text):
        try:
            for _ in range(10):
                make(target, text)
        except InputError as error:  # possible without exchange: another run got there between the two steps
            failures.append(error)

    threads = [threading.Thread(target=run, args=(text,)) for text in "abc"]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert label(target) in "abc"
    assert names(tmp_path) == ["out"]
    assert not failures or placing.exchange is not exchange


# what is refused


def refusal(target):
    before = names(Path.cwd())
    with pytest.raises(InputError) as caught:
        checked_target(Path(target))
    with pytest.raises(InputError), replaced(Path(target)):
        pytest.fail("nothing may be computed for a directory that cannot be written")
    assert names(Path.cwd()) == before
    return str(caught.value)


@pytest.fixture
def here(tmp_path, monkeypatch):
    home = tmp_path / "home"
    home.mkdir()
    monkeypatch.chdir(home)
    return home


@pytest.mark.parametrize("target", [".", "..", "", "/", "sub/..", "../../"])
def test_the_current_directory_and_those_above_it_are_refused(here, target):
    (here / "sub").mkdir()
    assert (
        refusal(target) == f"{str(Path(target))!r} is the current directory or above it; give a new directory with -o"
    )


def test_a_report_one_stands_in_is_refused(here, monkeypatch):
    make(here / "out", "old")
    monkeypatch.chdir(here / "out" / "figures")
    assert "is the current directory or above it" in refusal(here / "out")


def test_files_links_and_places_below_a_file_are_refused(here):
    (here / "file").write_text("")
    (here / "link").symlink_to(here.parent)
    (here / "dangling").symlink_to(here / "nowhere")
    (here / "circle").symlink_to(here / "circle")
    assert refusal("file") == "'file' is a file; give a directory with -o"
    for link in ("link", "dangling", "circle"):
        assert refusal(link) == f"'{link}' is a symbolic link; give the directory itself, or a new one, with -o"
    message = refusal("file/a/b")
    assert message.startswith("'file/a/b' cannot be created, since '")
    assert message.endswith("file' is not a directory; give another with -o")
    assert "cannot be written" in refusal("circle/out") or "cannot be created" in refusal("circle/out")


@pytest.mark.parametrize(
    ("files", "stranger"),
    [
        ({"notes.txt": "x"}, "notes.txt"),
        ({"report.html": "x"}, "report.html"),
        ({"report.json": "not json"}, "report.json"),
        ({"report.json": "[" * 100_000}, "report.json"),
        ({"report.json": '["lure-report/1"]'}, "report.json"),
        ({"report.json": '{"schema": "other/1"}'}, "report.json"),
        ({"report.json": '{"schema": "lure-report/1"}', "thesis.tex": ""}, "thesis.tex"),
        ({"report.json": '{"schema": "lure-report/1"}', "figures": ""}, "figures"),
        ({"report.json": '{"schema": "lure-report/1"}', "figures/photo.jpg": ""}, "figures"),
        ({"report.json": '{"schema": "lure-report/1"}', "figures/deep/a.svg": ""}, "figures"),
        ({"report.json": '{"schema": "lure-report/1"}', "src/a.svg": ""}, "src"),
        ({".git/config": "x"}, ".git"),
    ],
)
def test_a_directory_with_anything_that_is_no_report_is_refused(here, files, stranger):
    for name, content in files.items():
        path = here / "out" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content)
    assert refusal("out") == f"'out' holds {stranger!r}, which is not part of a report; give another directory with -o"
    assert all((here / "out" / name).read_text() == content for name, content in files.items())


def test_a_link_inside_a_report_is_refused(here):
    make(here / "out", "old")
    (here / "out" / "more.svg").symlink_to("/etc/hostname")
    assert refusal("out").startswith("'out' holds 'more.svg'")


def test_a_directory_that_cannot_be_made_is_refused_with_the_reason(here, monkeypatch):
    if Path("/proc").is_mount():  # nobody, not even root, makes directories there
        assert "'/proc/out' cannot be written (" in refusal("/proc/out")

    def deny(*_, **__):
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(Path, "mkdir", deny)
    assert refusal("out") == "'out' cannot be written (Permission denied); give another directory with -o"


def test_a_name_that_is_too_long_is_refused_with_the_reason(here):
    assert refusal("x" * 300).endswith("cannot be written (File name too long); give another directory with -o")


def test_the_check_leaves_nothing_behind(here):
    checked_target(Path("a/b"))
    assert names(here) == []


# killed

FOLDERS = [str(Path(__file__).parent), str(ROOT / "tests" / "support")]
SLOW = """
import sys, time
from pathlib import Path
sys.path[:0] = {tests!r}
from test_output import write
from lure.analysis import output as placing
from lure.analysis.output import replaced
if {two_steps}:
    placing.exchange = lambda first, second: False
    rename = Path.rename
    def slow_rename(self, other):
        rename(self, other)
        print("renamed", self.name, flush=True)
        time.sleep({pause})
    Path.rename = slow_rename
with replaced(Path({target!r})) as directory:
    write(directory, "new")
    print("written", flush=True)
    if not {two_steps}:
        time.sleep({pause})
"""


def started(target, *, two_steps=False, pause=60.0):
    script = SLOW.format(tests=FOLDERS, target=str(target), two_steps=two_steps, pause=pause)
    return subprocess.Popen([sys.executable, "-c", script], cwd=ROOT, stdout=subprocess.PIPE, text=True)


def test_kill_9_while_the_report_is_written_leaves_the_old_one_and_the_next_run_cleans_up(tmp_path):
    target = tmp_path / "out"
    make(target, "old")
    with started(target) as run:
        assert run.stdout.readline() == "written\n"
        run.send_signal(signal.SIGKILL)
    assert label(target) == "old"
    assert len(names(tmp_path)) == 2
    make(target, "next")
    assert label(target) == "next"
    assert names(tmp_path) == ["out"]


@pytest.mark.slow
def test_what_a_living_run_writes_is_not_cleaned_up_by_another(tmp_path):
    target = tmp_path / "out"
    with started(target, pause=1.0) as run:
        assert run.stdout.readline() == "written\n"
        make(target, "other")
        assert label(target) == "other"
        assert len(names(tmp_path)) == 2
    assert run.returncode == 0
    assert label(target) == "new"
    assert names(tmp_path) == ["out"]


def test_kill_9_between_the_two_renames_costs_no_report(tmp_path):
    target = tmp_path / "out"
    make(target, "old")
    with started(target, two_steps=True) as run:
        assert run.stdout.readline() == "written\n"
        assert run.stdout.readline() == "renamed out\n"
        run.send_signal(signal.SIGKILL)
    assert not target.exists()
    found = []
    make(target, "next", lambda: found.append(label(target)))
    assert found == ["old"]  # moved back before anything is written
    assert label(target) == "next"
    assert names(tmp_path) == ["out"]


def test_a_second_rename_that_fails_puts_the_old_report_back(tmp_path, monkeypatch):
    target = tmp_path / "out"
    make(target, "old")
    monkeypatch.setattr(placing, "exchange", lambda first, second: False)
    rename, moves = Path.rename, []

    def fails_once(self, other):
        moves.append(self.name)
        if moves == ["new", "out", "new"]:
            raise OSError(errno.EIO, "Input/output error")
        return rename(self, other)

    monkeypatch.setattr(Path, "rename", fails_once)
    with pytest.raises(InputError, match="Input/output error"):
        make(target, "new")
    assert label(target) == "old"
    assert names(tmp_path) == ["out"]


@pytest.mark.slow
def test_kill_9_at_any_moment_never_leaves_a_mixture(tmp_path):
    target = tmp_path / "out"
    script = SLOW.format(tests=FOLDERS, target=str(target), two_steps=False, pause=0)
    loop = script.replace("with replaced", "while True:\n  with replaced").replace("\n    ", "\n      ")
    make(target, "old")
    for turn in range(8):
        with subprocess.Popen([sys.executable, "-c", loop], cwd=ROOT, stdout=subprocess.PIPE, text=True) as run:
            assert run.stdout.readline() == "written\n"
            time.sleep(0.0137 * turn)
            run.send_signal(signal.SIGKILL)
        assert label(target) in ("old", "new")
    make(target, "last")
    assert names(tmp_path) == ["out"]


def test_hidden_directories_of_others_are_not_touched(tmp_path):
    others = [
        ".out.lure-0123456",
        ".out.lure-0123456z",
        ".output.lure-01234567",
        ".out.lure-01234567x",
        "out.lure-01234567",
    ]
    for name in others:
        (tmp_path / name).mkdir()
    (tmp_path / ".out.lure-89abcdef").mkdir()
    (tmp_path / ".out.lure-00000000").write_text("")
    make(tmp_path / "out", "new")
    assert names(tmp_path) == sorted([*others, ".out.lure-00000000", "out"])


# the system calls


def test_two_names_are_exchanged_in_one_step_or_not_at_all(tmp_path):
    make(tmp_path / "a", "a")
    make(tmp_path / "b", "b")
    done = exchange(tmp_path / "a", tmp_path / "b")
    assert done == (sys.platform == "linux")
    assert (label(tmp_path / "a"), label(tmp_path / "b")) == (("b", "a") if done else ("a", "b"))


def test_what_is_not_there_is_not_exchanged(tmp_path):
    make(tmp_path / "a", "a")
    with suppress(FileNotFoundError):
        assert not exchange(tmp_path / "a", tmp_path / "nowhere")
    assert label(tmp_path / "a") == "a"


def test_a_lock_is_held_until_it_is_released(tmp_path):
    release = lock(tmp_path, wait=True)
    assert lock(tmp_path, wait=False) is None
    release()
    again = lock(tmp_path, wait=False)
    again()


# one text file


def test_a_text_file_is_written_once_and_replaced_only_by_force(tmp_path):
    path = tmp_path / "rod.toml"
    write_new(path, "ä", force=False)
    assert path.read_text(encoding="utf-8") == "ä"
    with pytest.raises(InputError, match=r"rod\.toml' exists; give another name, or --force to replace it$"):
        write_new(path, "b", force=False)
    assert path.read_text(encoding="utf-8") == "ä"
    write_new(path, "c", force=True)
    assert path.read_text() == "c"
    write_new(tmp_path / "new.toml", "d", force=True)
    assert names(tmp_path) == ["new.toml", "rod.toml"]


@pytest.mark.parametrize("force", [False, True])
def test_a_text_file_that_cannot_be_written_is_refused(tmp_path, force):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"is a directory; give the name of a file, such as '.*rod\.toml'$"):
        write_new(tmp_path, "x", force=force)
    for place in ("no", "file"):
        with pytest.raises(InputError, match=rf"{place}' is no directory; give a file in one that exists$"):
            write_new(tmp_path / place / "rod.toml", "x", force=force)
    assert names(tmp_path) == ["file"]


def test_a_dangling_link_is_not_written_through(tmp_path):
    (tmp_path / "rod.toml").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(InputError, match="exists"):
        write_new(tmp_path / "rod.toml", "x", force=False)
    write_new(tmp_path / "rod.toml", "x", force=True)
    assert names(tmp_path) == ["rod.toml"]
