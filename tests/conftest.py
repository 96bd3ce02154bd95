"""Settings shared by all tests, and the fixtures of those that run commands.

The profile `dev` is the default: few examples, the same in every run.  `--hypothesis-profile=ci` draws many at random.
"""

import os

import pytest
from hypothesis import settings

from analysis.cli import main

os.environ["MPLBACKEND"] = "agg"  # figures are files, also where a display is at hand

settings.register_profile("dev", max_examples=40, derandomize=True, deadline=None)
settings.register_profile("ci", max_examples=1000, deadline=None, print_blob=True)
settings.load_profile("dev")


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
