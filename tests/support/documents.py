"""Documents that are run: what a page of documentation shows is done, in its order, in a folder of its own.

A block of code says by its language what is done with it:

- ``python`` with prompts: a doctest; one namespace a page,
- ``console``: each ``$`` line is a command, what follows is what it prints; status 0 unless ``$ echo $?`` follows,
- any language with ``:caption: FILE``: written to FILE, for what follows.

Numbers are compared to five digits and white space is one space, since the last digits depend on the versions of the
libraries of a search; ``...`` stands for anything.
"""

import contextlib
import doctest
import io
import os
import re
import shlex
import subprocess
import sys
import textwrap
from dataclasses import dataclass
from pathlib import Path

from inner import ran_pytest

NUMBER = re.compile(r"\d+\.\d+")
PROGRESS = re.compile(r"^lure: .*after \d+ s\n", re.MULTILINE)  # what a slow machine prints besides
FENCE = re.compile(r" *(`{3,})\s*(.*?)\s*")
OPTION = re.compile(r" *:([\w-]+):\s*(.*?)\s*")
# Making the environment: the one that runs the tests is that one.
SETUP = re.compile(r"(?:python3? -m venv|\. \S*/activate$|(?:python -m )?pip install|make\b)")
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE | doctest.IGNORE_EXCEPTION_DETAIL


@dataclass(frozen=True)
class Block:
    """One block of code of a page: its language, the file it is (or None), its text and the line where it begins."""

    language: str
    file: str | None
    text: str
    line: int


def rounded(text):
    """On one line, numbers to five digits: the last ones depend on the versions of the search's libraries."""
    return NUMBER.sub(lambda match: f"{float(match.group()):.5g}", " ".join(text.split()))


def blocks(page):
    """The blocks of code of a page, in order; directives other than ``{code-block}`` are looked through."""
    found, around, inside = [], [], None
    for number, line in enumerate(page.splitlines(), 1):
        fence = FENCE.fullmatch(line)
        ticks, words = fence.groups() if fence else ("", "")
        if inside is not None:
            if ticks and not words and len(ticks) >= len(inside[0]):
                found.append(block(*inside[1:]))
                inside = None
            else:
                inside[-1].append(line)
        elif ticks and not words and around:
            assert around.pop() == ticks, f"line {number}: a fence that closes nothing"
        elif ticks and words.startswith("{") and not words.startswith("{code-block}"):
            around.append(ticks)
        elif ticks:
            inside = (ticks, words.removeprefix("{code-block}").strip(), number, [])
    assert inside is None, f"line {inside[2]}: a fence that nothing closes"
    assert not around, "a directive that nothing closes"
    return found


def block(language, line, lines):
    """One block from what its fence says and the lines within, options first."""
    options = {}
    while lines and (option := OPTION.fullmatch(lines[0])):
        options[option[1]] = option[2]
        lines = lines[1:]
    if options and lines and not lines[0].strip():
        lines = lines[1:]
    file = options.get("caption", "").strip("`") or None
    return Block(language, file, textwrap.dedent("\n".join(lines) + "\n"), line)


def runnable(block):
    """Whether a block is run, or written to a file, rather than read only."""
    return block.language in {"python", "console"} or block.file is not None


def commands(text):
    """The commands of a ``console`` block, each with what it is shown to print."""
    parts = re.split(r"^\$ ", text.replace("\\\n", " "), flags=re.MULTILINE)
    assert not parts[0].strip(), f"output without a command: {parts[0]}"
    return [part.partition("\n")[::2] for part in parts[1:]]


def same(shown, printed):
    """Whether what a page shows is what was printed, to five digits."""
    return doctest.OutputChecker().check_output(rounded(shown) + "\n", rounded(printed) + "\n", FLAGS)


class Rounded(doctest.OutputChecker):
    """Doctests compared to five digits."""

    def check_output(self, want, got, optionflags):
        return super().check_output(want, got, optionflags) or same(want, got)


class Page:
    """One page being run: the status of its last command and the names its Python has defined."""

    def __init__(self, name):
        self.name, self.status, self.names = name, 0, {"__name__": "__main__"}

    def run(self, block):
        """Do what a block asks for; an AssertionError says where the page and the world differ."""
        where = f"{self.name}:{block.line}"
        if block.file is not None:
            Path(block.file).parent.mkdir(parents=True, exist_ok=True)
            Path(block.file).write_text(block.text, encoding="utf-8")
        elif block.language == "console":
            shown = commands(block.text)
            for i, (command, output) in enumerate(shown):
                self.command(command, output, where, checked=i + 1 < len(shown) and shown[i + 1][0] == "echo $?")
        else:
            self.doctest(block, where)

    def command(self, command, shown, where, *, checked):
        """Run one command and compare what it prints, if the page shows that."""
        if SETUP.match(command):
            return
        if command == "echo $?":
            printed = str(self.status)
        else:
            self.status, printed = called(shlex.split(command, comments=True))
            assert checked or self.status == 0, f"{where}: {command} ended with {self.status}\n{printed}"
        assert not shown.strip() or same(shown, printed), (
            f"{where}: {command}\n--- shown\n{shown}\n--- printed\n{printed}"
        )

    def doctest(self, block, where):
        """Run one block with prompts."""
        said = io.StringIO()
        test = doctest.DocTestParser().get_doctest(block.text, self.names, where, self.name, block.line)
        assert test.examples, f"{where}: a block of Python has prompts, or a file as its caption"
        runner = doctest.DocTestRunner(checker=Rounded(), optionflags=FLAGS, verbose=False)
        done = runner.run(test, out=said.write, clear_globs=False)
        self.names = test.globs
        assert done.failed == 0, said.getvalue()


def called(words):
    """Status and output of a command: `lure` and `pytest` in this process, `python` in one of its own."""
    if words[0] == "lure":
        from lure.analysis.cli import main

        out = io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
            status = main(words[1:])
        return status, PROGRESS.sub("", out.getvalue())
    if words[0] == "pytest":
        return ran_pytest(*words[1:])
    assert words[0] == "python", f"no command of ours: {words[0]}"
    environment = {**os.environ, "MPLBACKEND": "Agg", "COLUMNS": "80"}
    done = subprocess.run([sys.executable, *words[1:]], capture_output=True, text=True, env=environment, check=False)
    return done.returncode, done.stdout + done.stderr


def run_page(page, folder):
    """Run the blocks of a page in ``folder``.

    Parameters
    ----------
    page : Path
        A Markdown file.
    folder : Path
        Where its commands run and its files are written.

    Returns
    -------
    int
        How many blocks were run.
    """
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    running = Page(page.name)
    wanted = list(filter(runnable, blocks(page.read_text(encoding="utf-8"))))
    with contextlib.chdir(folder):
        for block in wanted:
            running.run(block)
            pyplot.close("all")
    return len(wanted)
