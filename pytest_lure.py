"""The pytest plugin of lure: plots of violated nonlinearities as files, and what the passed assertions rest on.

pytest loads this module at the start of every run in an environment that has lure.  It therefore imports nothing but
pytest, stands outside the packages (a project of the user's may well have a package named ``analysis``), and does
nothing for a test that does not use :mod:`lure.analysis.testing`.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from lure.analysis.testing.result import History, Violation

_HOME = "lure.analysis.testing.result"
_PROPERTY = "lure"
_LONGEST_NAME = 120


def pytest_addoption(parser: pytest.Parser) -> None:
    """The options ``--lure-plots`` and ``--lure-evidence``."""
    group = parser.getgroup("lure", "nonlinearities and their sectors (lure)")
    group.addoption(
        "--lure-plots",
        metavar="DIR",
        default=None,
        help="save a plot of each nonlinearity that violates its assertion in DIR, an SVG file named after the test",
    )
    group.addoption(
        "--lure-evidence",
        action="store_true",
        help="list what the passed assertions rest on: certified, or observed among so many values",
    )


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None, object, object]:
    """Keep, as properties of the test, what its assertions about nonlinearities rest on."""
    history = _history()
    before = history.total if history is not None else 0
    try:
        return (yield)
    finally:
        history = _history()
        if history is not None and history.total > before:
            item.user_properties += [(_PROPERTY, text) for text in dict.fromkeys(map(str, history.since(before)))]


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Save the plots of the violations that ended a test, and say where they are."""
    report = yield
    directory = item.config.getoption("--lure-plots")
    if directory is not None and call.excinfo is not None:
        for i, violation in enumerate(_violations(call.excinfo.value)):
            path = Path(directory) / f"{_file_name(item.nodeid)}{f'-{i + 1}' if i else ''}.svg"
            report.sections.append(("plot of the nonlinearity", _saved(violation, path)))
    return report


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """The list of ``--lure-evidence``."""
    if not config.getoption("--lure-evidence"):
        return
    lines = [
        f"{report.nodeid}: {text}"
        for report in terminalreporter.getreports("passed")
        if report.when == "call"
        for name, text in report.user_properties
        if name == _PROPERTY
    ]
    terminalreporter.section("what the passed assertions about nonlinearities rest on")
    for line in lines or ["no assertion about a nonlinearity passed"]:
        terminalreporter.line(line)


def _history() -> History | None:
    """The record of passed assertions, None as long as nothing asserted anything."""
    return getattr(sys.modules.get(_HOME), "HISTORY", None)


def _violations(error: BaseException) -> Iterator[Violation]:
    """The violation of an error, or of each error of a group."""
    if isinstance(error, BaseExceptionGroup):
        for part in error.exceptions:
            yield from _violations(part)
        return
    ours = getattr(sys.modules.get(_HOME), "NonlinearityViolation", None)
    if ours is not None and isinstance(error, ours) and error.violation is not None:
        yield error.violation


def _saved(violation: Violation, path: Path) -> str:
    """Where the plot is, or why there is none: a plot that cannot be made does not hide the failure."""
    try:
        violation.save(path)
    except OSError as error:
        return f"no plot: {path} cannot be written ({error.strerror})"
    return str(path)


def _file_name(nodeid: str) -> str:
    """A test's name as the name of a file."""
    return re.sub(r"[^\w.\[\]-]+", "_", nodeid.replace(".py::", "-").replace("::", "-"))[-_LONGEST_NAME:]
