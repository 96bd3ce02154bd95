"""The two files as text.  Of the notebook there is one source, in ``notebooks/``; a wheel holds a copy of it here."""

from __future__ import annotations

import json
import re
from importlib.resources import files

# From Jupytext's percent format to a Jupyter notebook, for scripts of our own; Jupytext need not be installed.

_CELL = re.compile(r"^# %%(.*)\n", re.MULTILINE)
_METADATA = {
    "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
    "language_info": {"name": "python"},
}


def notebook_json(script: str) -> str:
    """A script in percent format as the text of an ``.ipynb`` file, format 4.5, without outputs.

    Parameters
    ----------
    script : str
        A header, then cells: ``# %%`` begins code, ``# %% [markdown]`` prose in comments.
    """
    _header, *parts = _CELL.split(script)
    pairs = zip(parts[::2], parts[1::2], strict=True)
    cells = [_cell(number, kind.strip(), body) for number, (kind, body) in enumerate(pairs, 1)]
    notebook = {"cells": cells, "metadata": _METADATA, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(notebook, indent=1, ensure_ascii=False) + "\n"


def _cell(number: int, kind: str, body: str) -> dict[str, object]:
    lines = body.strip("\n").split("\n")
    if kind.startswith("[markdown]"):  # what follows are its metadata
        text = "\n".join(re.sub(r"^# ?", "", line) for line in lines)
        return _filled("markdown", number, text)
    return {**_filled("code", number, "\n".join(lines)), "execution_count": None, "outputs": []}


def _filled(kind: str, number: int, text: str) -> dict[str, object]:
    return {"cell_type": kind, "id": f"cell-{number}", "metadata": {}, "source": text.splitlines(keepends=True)}


_NOTEBOOK, _NONLINEARITY_TEST = "50-your-own-loop.py", "nonlinearity_test.txt"


def notebook_script() -> str:
    """The starter notebook as a script in Jupytext's percent format."""
    package = files("lure.analysis.starters")
    packed = package.joinpath(_NOTEBOOK)
    if not packed.is_file():  # a checkout, where the notebook itself is at hand
        packed = package.joinpath("..", "..", "notebooks", _NOTEBOOK)
    return packed.read_text(encoding="utf-8")


def nonlinearity_test() -> str:
    """A file for pytest that guards the sector and the slope of a nonlinearity."""
    return files("lure.analysis.starters").joinpath(_NONLINEARITY_TEST).read_text(encoding="utf-8")
