"""Runs of Python and of pytest inside the process that runs the tests: to start one takes longer than most runs do."""

import contextlib
import importlib
import io
import os
import runpy
import sys
from pathlib import Path

import pytest

OWN = ["--capture=sys", "--rootdir=.", "-c", os.devnull, "-p", "no:cacheprovider", "-p", "no:faulthandler"]


@contextlib.contextmanager
def as_if_new():
    """A folder's own modules are importable and forgotten afterwards; arguments and path are restored."""
    folder, path, arguments, modules = Path.cwd(), list(sys.path), list(sys.argv), set(sys.modules)
    sys.path.insert(0, str(folder))
    importlib.invalidate_caches()
    try:
        yield
    finally:
        sys.path[:], sys.argv[:] = path, arguments
        for name in set(sys.modules) - modules:
            file = getattr(sys.modules[name], "__file__", None)
            if file is not None and Path(file).is_relative_to(folder):
                del sys.modules[name]


def printed(run):
    """What a function returns, and all that is printed meanwhile."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
        found = run()
    return found, out.getvalue()


def ran_pytest(*arguments):
    """Status and output of pytest in the current folder; its plugins are those of lure and Hypothesis."""
    with pytest.MonkeyPatch.context() as patch, as_if_new():
        patch.setenv("COLUMNS", "80")
        for name in [name for name in os.environ if name.startswith("PYTEST_")]:
            patch.delenv(name)
        patch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
        plugins = [importlib.import_module("pytest_lure"), "hypothesispytest"]
        status, text = printed(lambda: pytest.main([*OWN, *map(str, arguments)], plugins))
    return int(status), text


def ran_python(file):
    """Status and output of a program of the current folder; its last error is the end of the output."""
    with as_if_new():
        sys.argv[:] = [str(file)]

        def run():
            try:
                runpy.run_path(str(file), run_name="__main__")
            except SystemExit as end:
                return end.code or 0
            return 0

        return printed(run)
