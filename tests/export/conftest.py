"""The lemmas that files for Coq begin with, compiled once for all files with the same ones."""

from functools import cache

import pytest
from replayed import common


@pytest.fixture(scope="session")
def library(tmp_path_factory):
    """The folder in which the lemmas that a file begins with are compiled."""
    return cache(lambda lemmas: common(tmp_path_factory.mktemp("coq"), lemmas))
