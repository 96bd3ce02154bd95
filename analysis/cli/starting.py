"""What ``lure init`` writes: a system as TOML, a notebook about a loop, or a test of a law."""

from __future__ import annotations

import shlex
from pathlib import Path

from lure.analysis.cli.progress import refused


def starting(path: Path | None, *, loop: bool, notebook: Path | None, test: Path | None) -> tuple[Path, str, str]:
    """The file to write, its text, and what to do with it then.

    Parameters
    ----------
    path : Path or None
        The TOML file, None for its usual name.
    loop : bool
        Whether it describes a plant with a nonlinearity instead of a rod.
    notebook, test : Path or None
        The other files, asked for by the options of these names.

    Raises
    ------
    refused
        An ``InputError``: more than one file is asked for, or a name that is not of its kind.
    """
    named = {"PATH": path is not None, "--loop": loop, "--notebook": notebook is not None, "--test": test is not None}
    given = [name for name, asked in named.items() if asked]
    if len(given) > 1 and given != ["PATH", "--loop"]:
        raise refused(
            f"{' and '.join(given)} do not go together; each writes a file of its own, so run lure init twice"
        )
    if notebook is not None:
        return _notebook(notebook)
    if test is not None:
        return _test(test)
    from lure.files import plant_template, template

    target = path or Path("plant.toml" if loop else "rod.toml")
    return target, plant_template() if loop else template(), f"edit it, then run: {_command('lure report', target)}"


def _notebook(path: Path) -> tuple[Path, str, str]:
    from lure.analysis.starters import notebook_json, notebook_script

    _demand(path, "--notebook", "my-loop.ipynb", ".ipynb", ".py")
    if path.suffix == ".py":
        return path, notebook_script(), f"change the two lines marked in it, then run: {_command('python', path)}"
    then = f"run it, change the two lines marked in it, run it again: {_command('jupyter lab', path)}"
    return path, notebook_json(notebook_script()), then


def _test(path: Path) -> tuple[Path, str, str]:
    from lure.analysis.starters import law_test

    _demand(path, "--test", "test_law.py", ".py")
    return path, law_test(), f"edit the law and its bounds, then run: {_command('pytest', path)}"


def _demand(path: Path, option: str, example: str, *endings: str) -> None:
    if path.suffix not in endings:
        raise refused(f"{option} is {str(path)!r}; give a name that ends in {' or '.join(endings)}, such as {example}")


def _command(program: str, path: Path) -> str:
    return f"{program} {shlex.quote(str(path))}"
