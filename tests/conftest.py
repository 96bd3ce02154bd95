"""Settings shared by all tests, and the fixtures of those that run commands.

The profile `dev` is the default: few examples, the same in every run.  `--hypothesis-profile=thorough` draws many at
random, takes the large samples of `depth.sampled` and runs the tests marked `thorough`, which others leave out.
`--motion compiled` and `--motion plain` compute exact motions that do not choose for themselves in that way.
"""

import gc
import os
import sys

import pytest
from compiled import share_compiled
from depth import THOROUGH, thorough
from hypothesis import settings
from sketches import sketches

from lure.analysis.cli import main
from lure.rod.motion import engine

os.environ["MPLBACKEND"] = "agg"  # figures are files, also where a display is at hand

settings.register_profile("dev", max_examples=10, derandomize=True, deadline=None)
settings.register_profile(THOROUGH, max_examples=1000, deadline=None, print_blob=True)
settings.load_profile("dev")


def pytest_addoption(parser):
    """How exact motions are computed."""
    parser.addoption("--motion", choices=("plain", "compiled"), help="compute exact motions in this way")


def pytest_configure(config):
    """Put the way that was asked for in place of the choice by cost; numba optimises half, in a third less time.

    What it compiles so is kept apart, since its cache does not tell how much was optimised, and for all clones.
    """
    if config.getoption("hypothesis_profile") != THOROUGH:
        share_compiled()
    way = config.getoption("--motion")
    if way is not None:
        pays = engine.compilation_pays
        engine.compilation_pays = lambda problem, wish, seconds=0.0: pays(
            problem, (way == "compiled") if wish is None else wish, seconds
        )


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Look for no garbage while tests are collected, later not among them, and more rarely than Python would."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.set_threshold(50_000, 20, 20)
        gc.enable()


@pytest.hookimpl(trylast=True)
def pytest_sessionstart(session):
    """Of each test a process of xdist tells the outcome, not when it began or that nothing was wrong before and after.

    For a test of a millisecond the six messages take longer than the test; a report in XML needs them all.
    """
    plugins = session.config.pluginmanager.get_plugins()
    worker = next((each for each in plugins if hasattr(each, "sendevent")), None)
    if worker is None or session.config.getoption("xmlpath", None):
        return
    tell = worker.sendevent

    def tell_news(name, **news):
        passed = name == "testreport" and news["data"]["outcome"] == "passed"
        if name not in ("logstart", "logfinish") and not (passed and news["data"]["when"] != "call"):
            tell(name, **news)

    worker.sendevent = tell_news


@pytest.hookimpl(wrapper=True)
def pytest_collect_file():
    """Look for doctests in the packages alone: tests have none, and each of their modules would be collected twice."""
    return [found for found in (yield) if type(found) is pytest.Module]


def pytest_collection_modifyitems(config, items):
    """Begin with the tests of compiled code, so that one process compiles; leave thorough ones to `make thorough`.

    Files with slow tests are next, so that at the end, where processes wait for each other, all tests are short.  Slow
    ones are left to `make slow`, those in a browser to `make explore-test`, and the pages to `make docs`.
    """
    for item in items:
        if any(item.callspec.id.startswith(mark.args) for mark in item.iter_markers("slow_for")):
            item.add_marker("slow")
    marks = {item: {mark.name for mark in item.iter_markers()} for item in items}
    slow = {item.path for item in items if "slow" in marks[item]}
    items.sort(key=lambda item: (not item.path.stem.startswith("test_motion"), item.path not in slow))
    asked = config.getoption("markexpr")
    elsewhere = {name for name in ("browser", "pages") if name not in asked}
    if not thorough():
        elsewhere |= {THOROUGH, "slow"} if "slow" not in asked else {THOROUGH}
    left = [item for item in items if elsewhere & marks[item]]
    config.hook.pytest_deselected(items=left)
    gone = set(left)
    items[:] = [item for item in items if item not in gone]


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown():
    """Close the figures a test left open: others, in whatever order they run, count those of their own."""
    pyplot = sys.modules.get("matplotlib.pyplot")
    if pyplot is not None:
        pyplot.close("all")


@pytest.fixture
def sketched():
    """Reports with sketches in place of figures, for tests that look at something else."""
    with sketches():
        yield


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty directory to work in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def lure(capsys, here):
    """Run a command in an empty directory; its exit status, stdout and stderr."""

    def run(*arguments):
        status = main(arguments)
        out, err = capsys.readouterr()
        return status, out, err

    return run
