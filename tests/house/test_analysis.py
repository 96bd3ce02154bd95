"""The main names of the package, loaded only when used."""

import subprocess
import sys

import pytest

import lure.analysis
from lure.analysis.questions import max_sector


def test_the_main_names_are_those_of_their_modules():
    assert lure.analysis.max_sector is max_sector
    assert {"analyse", "max_sector", "max_slope", "Verdict"} <= set(dir(lure.analysis))
    with pytest.raises(AttributeError, match="max_gain"):
        _ = lure.analysis.max_gain


def test_importing_the_package_loads_no_heavy_library():
    code = (
        "import sys, lure.analysis; print([m for m in ('flint', 'scipy', 'control', 'matplotlib') if m in sys.modules])"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"
