"""The two files as text.  Of the notebook there is one source, in ``notebooks/``; a wheel holds a copy of it here."""

from __future__ import annotations

from importlib.resources import files

_NOTEBOOK, _LAW_TEST = "50-your-own-loop.py", "law_test.txt"


def notebook_script() -> str:
    """The starter notebook as a script in Jupytext's percent format."""
    package = files("lure.analysis.starters")
    packed = package.joinpath(_NOTEBOOK)
    if not packed.is_file():  # a checkout, where the notebook itself is at hand
        packed = package.joinpath("..", "..", "notebooks", _NOTEBOOK)
    return packed.read_text(encoding="utf-8")


def law_test() -> str:
    """A file for pytest that guards the sector and the slope of a law."""
    return files("lure.analysis.starters").joinpath(_LAW_TEST).read_text(encoding="utf-8")
