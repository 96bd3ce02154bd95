"""The `lure` command: what goes to which stream, with which exit status, and what is left on disk."""

import json
import os
import pty
import re
import signal
import subprocess
import sys
import tomllib
from pathlib import Path
from types import ModuleType

import pytest
from commands import names

from lure import __version__
from lure.analysis.cli import progress as progress_module
from lure.analysis.cli.commands import NEEDED, OPTIONAL
from lure.analysis.verdict import Verdict
from lure.errors import InputError
from lure.files import read_system
from lure.files.builtin import loop_names
from lure.rod.file import system_to_toml, template
from lure.rod.systems import builtin_system, builtin_systems

ROOT = Path(__file__).parents[2]

# In place of the analysis: a report that holds its system, and a paper with one claim.
STUB = """
import json

class Report:
    def __init__(self, system, command):
        from lure.analysis.verdict import Verdict
        self.system, self.command = system, command
        self.verdict = Verdict.REFUTED if system.rod.damping < 0 else Verdict.PROVED
        if system.rod.damping == 0:
            self.verdict = Verdict.INCONCLUSIVE
    def __str__(self):
        return f"{self.verdict} ({self.system.name}, θ)\\n"
    def to_dict(self):
        return {"schema": "lure-report/1", "name": self.system.name, "command": self.command}

Report.__module__, Report.__qualname__ = "lure.analysis.rod.report.model", "StabilityReport"

def build_report(system, *, progress=None, command=None):
    if progress:
        progress("a stage [red]", 0.25)
    return Report(system, command)

def write_report(report, directory):
    (directory / "figures").mkdir()
    (directory / "figures" / "popov.svg").write_text("<svg/>")
    (directory / "report.html").write_text(report.system.name)
    (directory / "report.json").write_text(json.dumps(report.to_dict(), indent=2) + "\\n")

class Table:
    def __str__(self):
        return "1 claim"

def reproduce_paper(directory, *, progress=None):
    if progress:
        progress("figure 8", 0.5)
    (directory / "paper.html").write_text("")
    (directory / "paper.json").write_text(json.dumps({"schema": "lure-paper/1"}, indent=1) + "\\n")
    return Table()
"""
RUN = "import sys, types; from lure.analysis.cli import main\n{stub}\n{patch}\nsys.exit(main())"
INSTALL = """
for name in ("lure.analysis.rod.report.build", "lure.analysis.rod.report.output", "lure.analysis.rod.paper"):
    module = types.ModuleType(name)
    module.__dict__.update(build_report=build_report, write_report=write_report, reproduce_paper=reproduce_paper)
    sys.modules[name] = module
"""


@pytest.fixture
def stub(monkeypatch):
    """The stub in place of the analysis, its functions open to further patches."""
    module = ModuleType("stub")
    module.__dict__.update(_namespace(STUB))
    for name in ("report.build", "report.output", "paper"):
        monkeypatch.setitem(sys.modules, f"lure.analysis.rod.{name}", module)
    return module


def _namespace(source):
    names = {}
    exec(source, names)
    return names


def process(*arguments, patch="", **options):
    """The command in a process of its own, with the stub and any further patch."""
    script = RUN.format(stub=STUB + INSTALL, patch=patch)
    environment = {**os.environ, "PYTHONPATH": str(ROOT), **options.pop("env", {})}
    return subprocess.Popen(
        [sys.executable, "-c", script, *arguments],
        stdout=options.pop("stdout", subprocess.PIPE),
        stderr=options.pop("stderr", subprocess.PIPE),
        env=environment,
        text=True,
        **options,
    )


# report


@pytest.mark.usefixtures("stub")
@pytest.mark.parametrize(
    ("damping", "status", "word"), [("2e-4", 0, "PROVED"), ("0", 10, "INCONCLUSIVE"), ("-1", 11, "REFUTED")]
)
def test_the_exit_status_is_the_verdict(here, lure, damping, status, word):
    assert lure("report", "--set", f"rod.damping={damping}") == (
        status,
        f"{word} (paper-rod (changed), θ)\n\nThe report is lure-report/report.html\n",
        "",
    )
    report = ["figures", "figures/popov.svg", "report.html", "report.json"]
    assert names(here) == ["lure-report", *(f"lure-report/{name}" for name in report)]


@pytest.mark.usefixtures("stub")
def test_json_is_alone_on_stdout_and_is_the_file(here, lure):
    status, out, err = lure("report", "--json", "-o", "a b", "--set", "rod.gap=0.01")
    assert status == 0
    assert out == (here / "a b" / "report.json").read_text()
    assert json.loads(out)["command"] == "lure report paper-rod --set rod.gap=0.01"
    assert err == "The report is a b/report.html\n"
    assert lure("report", "--json", "--quiet")[2] == ""


@pytest.mark.usefixtures("stub")
def test_a_file_of_ones_own_is_reported_on(here, lure):
    assert lure("init")[0] == 0
    (here / "rod.toml").write_text((here / "rod.toml").read_text().replace('"my rod"', '"steel [bold]"'))
    assert lure("report", "rod.toml")[1].startswith("PROVED (steel [bold], θ)")


def test_every_built_in_is_found_by_the_command(here, lure, stub):
    seen = []
    build = stub.build_report
    stub.build_report = lambda system, **rest: seen.append(system.name) or build(system, **rest)
    for name in builtin_systems():
        assert lure("report", name, "-q")[0] == 0
    assert seen == list(builtin_systems())


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (
            ["report", "paper-rd"],
            "there is no built-in system 'paper-rd'; did you mean 'paper-rod'? choose from those that",
        ),
        (
            ["report", "servo"],
            "there is no built-in system 'servo'; did you mean 'servo.toml'? choose from those that lure ",
        ),
        (
            ["max-sector", "1/(s+1)^3"],
            "there is no built-in system '1/(s+1)^3'; give a formula as lure max-sector --transfer '1/(s+1)^3', or as "
            "transfer = '1/(s+1)^3' below [plant] in a TOML file\n",
        ),
        (["report", "motor"], "there is no built-in system 'motor'; choose from those that lure systems lists, or "),
        (
            ["report", "mine.toml"],
            "mine.toml does not exist; `lure init --loop mine.toml` writes a loop to start from, `lure init mine.toml` "
            "a rod\n",
        ),
        (["report", "--set", "rod.dampng=1"], "--set: unknown key rod.dampng; did you mean rod.damping? [rod] takes "),
        (["report", "--set", "rod.length=-1"], "rod.length is -1; give a positive number\n"),
        (["report", "--set", "rod.length=1e999999999"], "rod.length is 1E+999999999, outside the range of double "),
        (["report", "--set", "rod.damping=-1.2"], "rod.damping is -1.2, minus the impedance of the rod: "),
        (["report", "--set", "force.g=__import__('os')"], "force.g: "),
        (["report", "--set", "discretisation.cells=1000000000"], "discretisation.cells is 1000000000 (it would need "),
        (["report", "-o", "file"], "'file' is a file; give a directory with -o\n"),
        (["report", "-o", "file/sub"], "'file/sub' cannot be created, since '"),
        (["report", "-o", "full"], "'full' holds 'thesis.tex', which is not part of a report; give another directory"),
        (["report", "-o", "."], "'.' is the current directory or above it; give a new directory with -o\n"),
        (["report", "paper-rod", "rod.toml"], "Got unexpected extra argument"),
        (["report", "--colour"], "No such option: --colour"),
        (["report", "--set"], "Option '--set' requires an argument. See lure --help.\n"),
        (["report", "--jsn"], "No such option: --jsn"),
        (["reprot"], "No such command 'reprot'."),
        (["analyze"], "No such command 'analyze'. Did you mean 'analyse'? See lure --help."),
        (["\x1b[2J"], "No such command '\\x1b[2J'."),
        (["reproduce", "figure-3"], "there is nothing to reproduce under the name 'figure-3'; give paper\n"),
        (["reproduce", "-o", "file"], "'file' is a file; give a directory with -o\n"),
        (["init", "full"], "'full' is a directory; give the name of a file, such as 'full/rod.toml'\n"),
        (["init", "file"], "'file' exists; give another name, or --force to replace it\n"),
        (["init", "no/rod.toml"], "'no' is no directory; give a file in one that exists\n"),
        (
            ["gain", "kalman-fitts", "-o", "a.json", "--witness", "./a.json"],
            "'a.json' is given for two results; give each ",
        ),
        (
            ["steady", "kalman-fitts", "--plot", "a.svg", "--csv", "a.svg", "--force"],
            "'a.svg' is given for two results;",
        ),
        (
            ["systems", "paper-rd"],
            "there is no built-in system 'paper-rd'; did you mean 'paper-rod'? lure systems lists ",
        ),
        (["systems", "--toml"], "--toml needs the name of a system; give one such as: lure systems paper-rod --toml\n"),
    ],
)
def test_bad_input_is_one_sentence_status_2_and_nothing_written(here, lure, stub, arguments, sentence):
    stub.build_report = stub.reproduce_paper = lambda *_, **__: pytest.fail("nothing may be computed for bad input")
    (here / "file").write_text("")
    (here / "full").mkdir()
    (here / "full" / "thesis.tex").write_text("")
    (here / "servo.toml").write_text("")
    before = names(here)
    status, out, err = lure(*arguments)
    assert (status, out) == (2, "")
    assert err.startswith(f"lure: {sentence}")
    assert err.count("\n") == 1
    assert err.rstrip("\n").isprintable()
    assert names(here) == before


def test_bad_input_that_only_the_analysis_notices_leaves_the_old_report(here, lure, stub):
    lure("report")
    before = (here / "lure-report" / "report.json").read_text()

    def refuse(report, directory):
        (directory / "report.html").write_text("half")
        raise InputError("rod.gap is odd")

    stub.write_report = refuse
    assert lure("report", "--set", "rod.gap=1") == (2, "", "lure: rod.gap is odd\n")
    assert (here / "lure-report" / "report.json").read_text() == before
    assert os.listdir(here) == ["lure-report"]


def test_any_other_exception_is_our_bug_and_says_so(here, lure, stub, monkeypatch):
    lure("report")
    stub.build_report = lambda *_, **__: {}["missing"]
    status, out, err = lure("report")
    assert (status, out) == (1, "")
    assert err.startswith("lure: KeyError: 'missing'\nThis is a bug in lure, not in your input: please report it")
    assert "Traceback" not in err
    monkeypatch.setenv("LURE_DEBUG", "1")
    assert "Traceback (most recent call last)" in lure("report")[2]
    assert names(here / "lure-report") == ["figures", "figures/popov.svg", "report.html", "report.json"]


def test_too_little_memory_is_bad_input(here, lure, stub):
    def exhaust(*_, **__):
        raise MemoryError

    stub.build_report = exhaust
    assert lure("report") == (2, "", "lure: not enough memory for this many cells; give fewer\n")


def test_a_verdict_is_not_mistaken_for_a_number():
    assert [verdict.name for verdict in Verdict] == ["PROVED", "REFUTED", "INCONCLUSIVE"]  # each has its own status


# interrupted


SLOW = """
import signal, time
signal.signal(signal.SIGINT, signal.default_int_handler)  # a run in the background of a shell is born deaf to it
def slow(report, directory):
    write_report(report, directory)
    print("written", file=sys.stderr, flush=True)
    time.sleep(60)
sys.modules["lure.analysis.rod.report.output"].write_report = slow
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("old", "kill", "status"),
    [
        (True, signal.SIGINT, 130),
        (False, signal.SIGKILL, -9),
        pytest.param(True, signal.SIGKILL, -9, marks=pytest.mark.thorough),
        pytest.param(False, signal.SIGINT, 130, marks=pytest.mark.thorough),
    ],
)
@pytest.mark.usefixtures("stub")
def test_an_interrupted_run_leaves_the_old_report_or_none(here, lure, kill, status, old):
    if old:
        assert lure("report", "--set", "name=old")[0] == 0
    with process("report", "--set", "name=new", patch=SLOW) as run:
        assert run.stderr.readline() == "written\n"
        run.send_signal(kill)
        out, err = run.communicate()
    assert (run.returncode, out) == (status, "")
    assert err == ("lure: interrupted\n" if kill == signal.SIGINT else "")
    assert (here / "lure-report").exists() == old
    if old:
        assert (here / "lure-report" / "report.html").read_text() == "old"
        assert json.loads((here / "lure-report" / "report.json").read_text())["name"] == "old"
    lure("report", "--set", "name=next")
    assert os.listdir(here) == ["lure-report"]
    assert (here / "lure-report" / "report.html").read_text() == "next"


@pytest.mark.slow
def test_a_reader_that_leaves_is_no_bug(here):
    with process("systems", "paper-rod", "--toml", patch="import time; time.sleep(0.2)") as run:
        run.stdout.close()
        err = run.stderr.read()
    assert (run.returncode, err) == (141, "")


@pytest.mark.slow
def test_a_terminal_without_greek_gets_a_report_all_the_same(here):
    with process("report", env={"PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"}) as run:
        out, err = run.communicate()
    assert (run.returncode, err) == (0, "")
    assert out.startswith("PROVED (paper-rod, \\u03b8)\n")


# progress


def watched(*arguments, patch="", **environment):
    """What a terminal on stderr gets to see, and the text on stdout."""
    master, slave = pty.openpty()
    with process(*arguments, stderr=slave, patch=patch, env={"TERM": "xterm", **environment}) as run:
        os.close(slave)
        seen = b""
        while True:
            try:
                chunk = os.read(master, 4096)
            except OSError:  # Linux's way to say that the other end is closed
                break
            if not chunk:
                break
            seen += chunk
        out = run.stdout.read()
    os.close(master)
    assert run.returncode == 0
    return seen.decode(), out


# The stage lasts until the bar is shown: to import what draws it can take longer than any time chosen here.
PAUSE = """
import threading
from lure.analysis.cli import progress as bars
bars.PATIENCE = 0.1
shown, show = threading.Event(), bars._Bar._show
def told(bar):
    show(bar)
    shown.set()
bars._Bar._show = told
def paused(system, *, progress=None, command=None):
    progress("a stage [red]", 0.25)
    shown.wait(60)
    return build_report(system, command=command)
sys.modules["lure.analysis.rod.report.build"].build_report = paused
"""


@pytest.mark.slow
def test_progress_is_shown_on_a_terminal_and_wiped_afterwards(here):
    seen, out = watched("report", patch=PAUSE, NO_COLOR="")
    assert "a stage [red]" in seen
    assert re.search(r"\x1b\[[0-9;]*3[0-9]", seen)  # in colour
    assert seen.endswith(("\x1b[2K", "\x1b[?25h")) or "\x1b[2K" in seen[seen.rfind("a stage") :]
    assert out.startswith("PROVED")
    assert "stage" not in out


@pytest.mark.slow
def test_no_color_is_honoured(here):
    seen, _ = watched("report", patch=PAUSE, NO_COLOR="1")
    assert "a stage [red]" in seen
    assert not re.search(r"\x1b\[[0-9;]*[349][0-9][0-9;]*m", seen)


@pytest.mark.parametrize("wish", [None, "3"])
def test_linear_algebra_has_one_thread_unless_the_user_wants_more(lure, monkeypatch, wish):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", wish or "")
    if wish is None:
        monkeypatch.delenv("OPENBLAS_NUM_THREADS")
    assert lure("systems")[0] == 0
    assert os.environ["OPENBLAS_NUM_THREADS"] == (wish or "1")


def test_a_log_gets_a_line_now_and_then(monkeypatch, capsys):
    monkeypatch.setattr(progress_module, "SIGN", 0.001)
    said = ""
    with progress_module.progress(quiet=False) as tell:
        tell("a stage", 0.5)
        while not re.search(r"^lure: a stage, 50 % done, after \d+ s$", said, re.MULTILINE):
            said += capsys.readouterr().err
    with progress_module.progress(quiet=True) as tell:
        assert tell is None


@pytest.mark.slow
def test_a_bar_waits_until_the_work_takes_long(here):
    assert watched("report", patch=PAUSE.replace("0.1", "1000").replace("60", "0.4"))[0] == ""


@pytest.mark.slow
def test_quiet_shows_no_progress_even_on_a_terminal(here):
    assert watched("report", "--quiet")[0] == ""


# the other commands


def test_init_writes_a_file_that_reports_accept_and_never_overwrites_one(here, lure):
    status, out, err = lure("init")
    assert (status, err) == (0, "")
    assert out == "rod.toml is written; edit it, then run: lure report rod.toml\n"
    assert (here / "rod.toml").read_text(encoding="utf-8") == template()
    assert read_system(here / "rod.toml").rod == builtin_system("paper-rod").rod
    (here / "rod.toml").write_text("mine")
    assert lure("init")[0] == 2
    assert (here / "rod.toml").read_text() == "mine"
    assert lure("init", "--force")[0] == 0
    assert (here / "rod.toml").read_text(encoding="utf-8") == template()
    assert "lure report 'a b.toml'" in lure("init", "a b.toml")[1]


def test_systems_lists_describes_and_writes_the_built_ins(lure):
    status, out, _ = lure("systems")
    assert status == 0
    assert re.findall(r"^\S+", out, re.MULTILINE) == [*builtin_systems(), *loop_names()]
    assert max(map(len, out.splitlines())) <= 80
    assert lure("systems", "paper-rod-figure-8")[1].startswith(
        "paper-rod-figure-8: force 2 sin 4t as printed: contact\n"
    )
    assert lure("systems", "paper-rod-figure-8", "--toml")[1] == system_to_toml(builtin_system("paper-rod-figure-8"))


@pytest.mark.usefixtures("stub")
def test_the_paper_is_reproduced_into_a_directory_that_can_be_replaced(here, lure):
    for _ in range(2):
        assert lure("reproduce", "paper") == (0, "1 claim\n\nThe page is lure-paper/paper.html\n", "")
        assert names(here) == ["lure-paper", "lure-paper/paper.html", "lure-paper/paper.json"]
    status, out, err = lure("reproduce", "--json", "-o", "p")
    assert (status, err) == (0, "The page is p/paper.html\n")
    assert json.loads(out) == {"schema": "lure-paper/1"}
    assert (here / "p" / "paper.json").read_text() == out


def test_doctor_names_every_package_lure_needs(lure):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert sorted(NEEDED) == sorted(re.match(r"[\w-]+", wanted)[0] for wanted in project["dependencies"])
    status, out, _ = lure("doctor")
    assert status == 0
    assert out.startswith(f"lure {__version__}, Python {sys.version.split()[0]}")
    assert all(re.search(rf"^  {name} +\d", out, re.MULTILINE) for name in NEEDED)
    assert re.search(r"^  BLAS +\S+ \d", out, re.MULTILINE)
    assert re.search(r"^  stderr +not a terminal; progress is a line every half minute$", out, re.MULTILINE)


def test_doctor_looks_for_what_the_extras_install():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    for extra, listed in OPTIONAL.items():
        asked = {re.split(r"[>=\[]", line)[0] for line in project["optional-dependencies"][extra]}
        assert set(listed) == asked - {"lure"}


def test_doctor_says_what_is_missing(lure, monkeypatch):
    monkeypatch.setattr("lure.analysis.cli.commands.NEEDED", ("numpy", "no-such-package"))
    status, out, _ = lure("doctor")
    assert status == 2
    assert "  no-such-package" in out
    assert out.endswith("Missing: no-such-package; install lure again.\n")


def test_the_version_is_the_packages(lure):
    assert lure("--version") == (0, f"lure {__version__}\n", "")
