"""The pytest plugin, in runs of pytest inside that of the tests."""

import os
import re
import subprocess
import sys
from pathlib import Path
from textwrap import dedent
from xml.etree import ElementTree

import pytest
from inner import ran_pytest

ROOT = Path(__file__).parents[2]

GUARDS = """
    import numpy as np
    import pytest
    from lure.analysis.testing import assert_in_sector, assert_monotone
    from lure import Saturation, Sector

    def test_black_box():
        assert_in_sector(np.tanh, Sector(0, 1), on=(-20, 20))

    def test_known():
        assert_in_sector(Saturation(gain=2), Sector(0, 2))

    @pytest.mark.parametrize("gain", [0.5, 2])
    def test_gain(gain):
        assert_in_sector(lambda s: gain * np.tanh(s), Sector(0, 1))

    class TestGroup:
        def test_falls(self):
            assert_monotone(np.sin)

    def test_misspelt():
        assert_in_sector("tanh(sigm)", Sector(0, 1))

    def test_backwards():
        assert_in_sector(np.tanh, Sector(0, 1), on=(1, -1))
"""


def write(name, text):
    Path(f"{name}.py").write_text(dedent(text).lstrip(), encoding="utf-8")


@pytest.fixture
def run(here):
    """pytest in an empty folder, of which this process forgets the modules; what it says."""

    def run(*arguments):
        return pytest.RunResult(0, ran_pytest(*arguments)[1].splitlines(), [], 0)

    return run


def test_a_failure_ends_at_the_assertion_of_the_test_and_its_law_is_drawn(here, run):
    write("test_guards", GUARDS)
    result = run("--lure-plots", "plots/of nonlinearities")
    result.assert_outcomes(passed=3, failed=4)
    text = result.stdout.str()
    assert "rest on" not in text
    # the last frame is the user's: nothing of ours is shown but the message
    assert not re.search(r"lure.(analysis.testing|expressions).\w+\.py:\d+", text)
    assert "E       lure.analysis.testing.NonlinearityViolation: <lambda>" not in text
    result.stdout.fnmatch_lines(
        [
            "E *NonlinearityViolation: phi leaves the sector [[]0, 1[]]: phi(sigma)/sigma = * at sigma = *",
            "E *  allowed * [[]0, 1[]]",
            "E * |*X*",
            "test_guards.py:14: NonlinearityViolation",
            "*plot of the nonlinearity*",
            "plots?of nonlinearities?test_guards-test_gain[[]2[]].svg",
        ]
    )
    saved = {path.name for path in (here / "plots/of nonlinearities").iterdir()}
    assert saved == {"test_guards-test_gain[2].svg", "test_guards-TestGroup-test_falls.svg"}
    assert all("<svg" in path.read_text(encoding="utf-8") for path in here.rglob("*.svg"))
    assert all(
        len(line) <= 90 for line in text.split("\n") if re.match("E  (?!.*(NonlinearityViolation|InputError))", line)
    )


@pytest.mark.slow
def test_a_plot_that_cannot_be_written_does_not_hide_the_failure(here, run):
    write(
        "test_it",
        """
        from lure.analysis.testing import assert_odd

        def test_even():
            assert_odd(lambda sigma: sigma**2)
        """,
    )
    (here / "plots").write_text("a file", encoding="utf-8")
    result = run("--lure-plots", "plots")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["no plot: plots*cannot be written*"])


@pytest.mark.slow
def test_what_a_pass_rests_on_is_listed_on_request(here, run):
    write("test_guards", GUARDS)
    run("--lure-evidence", "--junit-xml=out.xml").stdout.fnmatch_lines(
        [
            "*what the passed assertions about nonlinearities rest on*",
            "test_guards.py::test_black_box: tanh lies in the sector [[]0, 1[]]: no violation among * (observed)",
            "test_guards.py::test_known: Saturation lies in the sector [[]0, 2[]]: for every sigma * (certified)",
        ]
    )
    assert not list(here.rglob("*.svg"))
    xml = (here / "out.xml").read_text(encoding="utf-8")
    assert xml.count('<property name="lure"') == 3


@pytest.mark.slow
def test_a_test_is_credited_with_its_own_assertions_only(here, run):
    write(
        "test_lazy",
        """
        import numpy as np
        from lure import Sector, SlopeBounds
        import lure.analysis.testing as guard  # loads nothing yet

        def test_first():
            guard.assert_in_sector(np.tanh, Sector(0, 1))
            guard.assert_in_sector(np.tanh, Sector(0, 1))
            guard.assert_monotone(np.tanh)

        def test_none():
            pass

        def test_many():
            for i in range(1, 31):
                guard.assert_in_sector(f"{i}*sigma", Sector(0, i))
        """,
    )
    run("--junit-xml=out.xml").assert_outcomes(passed=3)
    cases = {case.get("name"): case for case in ElementTree.parse(here / "out.xml").iter("testcase")}
    credited = {name: len(case.findall("properties/property[@name='lure']")) for name, case in cases.items()}
    # a repeated assertion is listed once; of many the last 20
    assert credited == {"test_first": 2, "test_none": 0, "test_many": 20}


@pytest.mark.thorough
def test_hypothesis_shows_the_simplest_failing_law(here, run):
    write(
        "test_fuzz",
        """
        from hypothesis import given, settings
        from lure.analysis.testing import assert_in_sector
        from lure.analysis.testing.strategies import monotone_members
        from lure import Sector

        @given(monotone_members(2))
        @settings(derandomize=True, database=None, deadline=None)
        def test_wrong(nonlinearity):
            assert_in_sector(lambda sigma: nonlinearity(sigma), Sector(0, 1))
        """,
    )
    result = run("--lure-plots", "plots")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*leaves the sector*", "*nonlinearity=ExpressionNonlinearity(text='2[*]sigma',*"])
    assert [path.name for path in (here / "plots").iterdir()] == ["test_fuzz-test_wrong.svg"]


def test_unused_it_loads_nothing_and_changes_nothing(here):
    write(
        "test_it",
        """
        import sys

        def test_modules():
            ours = {name for name in sys.modules if name.split(".")[0] in ("lure", "numpy", "matplotlib")}
            assert not ours
            assert "pytest_lure" in sys.modules
        """,
    )
    paths = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")]).rstrip(os.pathsep)
    alone = {**os.environ, "PYTHONPATH": paths, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}  # what others load is theirs
    command = [sys.executable, "-m", "pytest", "-q", "-p", "pytest_lure", "--lure-plots", "plots"]
    done = subprocess.run(command, env=alone, capture_output=True, text=True, check=False)
    assert "1 passed" in done.stdout
    assert not (here / "plots").exists()


@pytest.mark.slow
def test_a_users_own_package_named_analysis_is_left_alone(here, run):
    (here / "analysis").mkdir()
    for name, text in (("analysis/__init__", ""), ("analysis/mine", "value = 3\n"), ("conftest", "")):
        write(name, text)
    write(
        "test_it",
        """
        def test_mine():
            from analysis.mine import value
            assert value == 3

        def test_failing():
            assert False
        """,
    )
    run("--lure-plots", "plots", "--lure-evidence").assert_outcomes(passed=1, failed=1)


def test_the_assertions_need_neither_pytest_nor_hypothesis():
    script = """
import sys
sys.modules["pytest"] = sys.modules["_pytest"] = sys.modules["hypothesis"] = None  # as if not installed
import numpy as np
from lure.analysis.testing import assert_in_sector
from lure import Sector
print(assert_in_sector(np.tanh, Sector(0, 1)).evidence)
try:
    import lure.analysis.testing.strategies
except ValueError as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.split("\n")[:2] == [
        "observed",
        "lure.analysis.testing.strategies needs Hypothesis: pip install hypothesis",
    ]
