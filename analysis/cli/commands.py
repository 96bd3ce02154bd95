"""The commands; each imports what it needs when it runs, so that ``lure --help`` is instant."""

from __future__ import annotations

import os
import platform
import shlex
import sys
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lure import __version__
from lure.analysis.cli import texts
from lure.analysis.cli.options import (
    Force,
    Json,
    Output,
    Quiet,
    Seconds,
    Settings,
    Verbose,
    app,
    exit_status,
    option,
)
from lure.errors import InputError, did_you_mean

if TYPE_CHECKING:
    from lure.files.system import LoopSystem
    from lure.rod.systems import RodSystem

# What is installed, for `lure doctor`.

NEEDED = (
    *("clarabel", "control", "jinja2", "matplotlib", "numpy", "pydantic", "python-flint", "rich", "scipy", "sympy"),
    *("threadpoolctl", "typer"),
)
OPTIONAL = {  # the extras of pyproject.toml that a user chooses
    "fast": ("numba",),
    "netcdf": ("netCDF4", "xarray"),
    "sweep": ("zarr", "xarray", "distributed"),
    "cvode": ("scikit-sundae",),
    "pdf": ("weasyprint",),
    "notebooks": ("ipykernel", "ipywidgets", "jsonschema", "jupytext", "nbmake"),
    "testing": ("hypothesis", "pytest"),
}


def findings() -> tuple[list[str], bool]:
    """Lines to print, and whether everything that lure needs is there."""
    versions = {name: _version(name) for name in NEEDED}
    lines = [
        f"lure {__version__}, Python {platform.python_version()} ({platform.system()} {platform.machine()})",
        "",
        "Needed",
        *(f"  {name:<14}{found or 'MISSING'}" for name, found in versions.items()),
        f"  {'BLAS':<14}{_blas() if versions['numpy'] else 'unknown'}",
        "",
        'Optional (pip install "lure[fast]" and so on)',
    ]
    for extra, names in OPTIONAL.items():
        found = ", ".join(f"{name} {_version(name) or 'missing'}" for name in names)
        lines.append(f"  {extra:<14}{found}")
    lines += [
        "",
        "Terminal",
        f"  {'stdout':<14}{_stream(terminal=sys.stdout.isatty())}, {sys.stdout.encoding}",
        f"  {'stderr':<14}{_stream(terminal=sys.stderr.isatty())}"
        + ("; progress is shown there" if sys.stderr.isatty() else "; progress is a line every half minute"),
        f"  {'colours':<14}{'off, NO_COLOR is set' if os.environ.get('NO_COLOR') else 'where the terminal has them'}",
    ]
    missing = [name for name, found in versions.items() if not found]
    lines += [
        "",
        f"Missing: {', '.join(missing)}; install lure again." if missing else "Everything lure needs is there.",
    ]
    return lines, not missing


def _version(name: str) -> str | None:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(name)
    except PackageNotFoundError:
        return None


def _blas() -> str:
    """Name and version of numpy's linear algebra, as numpy tells it."""
    import numpy as np

    try:
        library = np.show_config(mode="dicts")["Build Dependencies"]["blas"]
        return f"{library['name']} {library['version']}"
    except (KeyError, TypeError):
        return "unknown"


def _stream(*, terminal: bool) -> str:
    return "a terminal" if terminal else "not a terminal"


# What ``lure init`` writes: a system as TOML, a notebook about a loop, or a test of a nonlinearity.


def starting(
    path: Path | None, *, loop: bool, kind: str | None, notebook: Path | None, test: Path | None
) -> tuple[Path, str, str]:
    """The file to write, its text, and what to do with it then.

    Parameters
    ----------
    path : Path or None
        The TOML file, None for its usual name.
    loop : bool
        Whether it describes a plant with a nonlinearity instead of a rod.
    kind : str or None
        What else it is about.
    notebook, test : Path or None
        The other files, asked for by the options of these names.

    Raises
    ------
    InputError
        More than one file is asked for, a name that is not of its kind, or no such kind.
    """
    options = {"--kind": kind, "--notebook": notebook, "--test": test}
    named = {"PATH": path is not None, "--loop": loop} | {name: one is not None for name, one in options.items()}
    given = [name for name, asked in named.items() if asked]
    if len(given) > 1 and given not in (["PATH", "--loop"], ["PATH", "--kind"]):
        raise InputError(
            f"{' and '.join(given)} do not go together; each writes a file of its own, so run lure init twice"
        )
    if notebook is not None:
        return _notebook(notebook)
    if test is not None:
        return _test(test)
    if kind is not None:
        return _of_kind(path, kind)
    from lure.files import plant_template
    from lure.rod.file import template

    return _system(path, "plant.toml" if loop else "rod.toml", plant_template() if loop else template())


def _of_kind(path: Path | None, kind: str) -> tuple[Path, str, str]:
    from lure.files import plant_template
    from lure.files.loop import TEMPLATES
    from lure.rod.file import template

    kinds = sorted((*TEMPLATES, "contact"))
    if kind not in kinds:
        raise InputError(f"--kind is {kind!r:.40}; {did_you_mean(kind, kinds)}give one of {', '.join(kinds)}")
    return _system(path, f"{kind}.toml", template(kind) if kind == "contact" else plant_template(kind))


def _system(path: Path | None, usual: str, text: str) -> tuple[Path, str, str]:
    """A template, whose comments name the file that is written."""
    target = path or Path(usual)
    named = text.replace(f" {usual}", f" {shlex.quote(target.name)}")
    return target, named, f"edit it, then run: {_command('lure report', target)}"


def _notebook(path: Path) -> tuple[Path, str, str]:
    from lure.analysis.starters import notebook_json, notebook_script

    _demand(path, "--notebook", "my-loop.ipynb", ".ipynb", ".py")
    if path.suffix == ".py":
        return path, notebook_script(), f"change the two lines marked in it, then run: {_command('python', path)}"
    then = f"run it, change the two lines marked in it, run it again: {_command('jupyter lab', path)}"
    return path, notebook_json(notebook_script()), then


def _test(path: Path) -> tuple[Path, str, str]:
    from lure.analysis.starters import nonlinearity_test

    _demand(path, "--test", "test_phi.py", ".py")
    return path, nonlinearity_test(), f"edit the nonlinearity and its bounds, then run: {_command('pytest', path)}"


def _demand(path: Path, option: str, example: str, *endings: str) -> None:
    if path.suffix not in endings:
        ends = " or ".join(endings)
        raise InputError(f"{option} is {str(path)!r}; give a name that ends in {ends}, such as {example}")


def _command(program: str, path: Path) -> str:
    return f"{program} {shlex.quote(str(path))}"


@app.callback(invoke_without_command=True, help=texts.ROOT)
def root(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version and stop.")] = False,
) -> None:
    """Without a command: the version or the help."""
    if version:
        from lure import __version__

        print(f"lure {__version__}")
        raise typer.Exit
    if context.invoked_subcommand is None:
        print(context.get_help())


@app.command(help=texts.REPORT)
def report(
    system: Annotated[str, typer.Argument(metavar="SYSTEM", help="A built-in system or a TOML file.")] = "paper-rod",
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="Where to write; FILE.pdf writes the PDF alone.")
    ] = Path("lure-report"),
    set_: Settings = None,
    pdf: Annotated[bool, typer.Option("--pdf", help="Write report.pdf too; needs the extra lure[pdf].")] = False,
    seconds: Seconds = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> int:
    """Analyse a system, write the report and return the status that its verdict stands for."""
    settings = set_ or []
    from lure.files import find_system
    from lure.rod.systems import RodSystem

    chosen = find_system(system, settings)
    if seconds is not None and isinstance(chosen, RodSystem):
        raise InputError("--seconds limits the searches for a loop, and a report on a rod has none; leave it out")

    from lure.analysis.report.parts import to_json
    from lure.analysis.report.reporting import page_of, report_on

    changes = [part for setting in settings for part in ("--set", setting)]
    changes += [] if seconds is None else ["--seconds", f"{seconds:g}"]
    command = shlex.join(["lure", "report", system, *changes])
    out = Output(as_json=as_json, quiet=quiet, verbose=verbose)
    with out.progress() as tell:
        found = report_on(chosen, output=output, pdf=pdf, seconds=seconds, command=command, progress=tell)
    print((to_json(found.to_dict()) if as_json else str(found)).rstrip("\n"))
    out.note(f"The report is {page_of(output)}")
    return exit_status(found.verdict)


@app.command(help=texts.INIT)
def init(
    path: Annotated[
        Path | None,
        typer.Argument(
            metavar="PATH", help="The file to write; rod.toml, or plant.toml with --loop.", show_default=False
        ),
    ] = None,
    loop: Annotated[bool, typer.Option("--loop", help="A plant with a nonlinearity instead of a rod.")] = False,
    kind: Annotated[
        str | None,
        option("--kind", "KIND", "A short file: contact, delay, disturbance, memory or operator."),
    ] = None,
    notebook: Annotated[
        Path | None, option("--notebook", "FILE", "A notebook about your own loop, .ipynb or .py.")
    ] = None,
    test: Annotated[Path | None, option("--test", "FILE", "A pytest file that guards a nonlinearity, .py.")] = None,
    force: Force = False,
) -> None:
    """Write the template."""
    from lure.analysis.output import write_new

    target, text, then = starting(path, loop=loop, kind=kind, notebook=notebook, test=test)
    write_new(target, text, force=force)
    print(f"{target} is written; {then}")


@app.command(help=texts.SYSTEMS)
def systems(
    name: Annotated[
        str | None,
        typer.Argument(metavar="NAME", help="The system to show.", show_default=False),
    ] = None,
    toml: Annotated[bool, typer.Option("--toml", help="Print it as a TOML file.")] = False,
) -> None:
    """List the built-in systems, or show one."""
    from lure.files import loop_to_toml
    from lure.files.builtin import builtin_loop, loop_names
    from lure.rod.file import system_to_toml
    from lure.rod.systems import RodSystem, builtin_system, builtin_systems

    rods, loops = tuple(builtin_systems()), loop_names()
    if name is None:
        if toml:
            raise InputError("--toml needs the name of a system; give one such as: lure systems paper-rod --toml")
        listed: list[RodSystem | LoopSystem] = [*map(builtin_system, rods), *map(builtin_loop, loops)]
        for system in listed:
            print(textwrap.fill(f"{system.name:<23} {system.title}", 80, subsequent_indent=" " * 24))
        return
    if name not in (*rods, *loops):
        meant = did_you_mean(name, (*rods, *loops))
        raise InputError(f"there is no built-in system {name!r:.60}; {meant}lure systems lists them")
    chosen = builtin_system(name) if name in rods else builtin_loop(name)
    rod = isinstance(chosen, RodSystem)
    if toml:
        print(system_to_toml(chosen) if isinstance(chosen, RodSystem) else loop_to_toml(chosen), end="")
        return
    print(f"{chosen.name}: {chosen.title}\nSource: {chosen.source}")
    if not isinstance(chosen, RodSystem):
        print(f"H = {chosen.block}" if chosen.classes is None else f"Plant: {chosen.block}")
        about = chosen.nonlinearity or chosen.nonlinearity_class or chosen.classes
        print(f"{'Nonlinearity' if chosen.nonlinearity else 'Class'}: {about or 'none, every class is looked at'}")
    print(f"Report: lure report {chosen.name}")
    print(f"As a file to edit: lure systems {chosen.name} --toml > {'rod' if rod else 'plant'}.toml")


@app.command(help=texts.REPRODUCE)
def reproduce(
    what: Annotated[str, typer.Argument(metavar="WHAT", help="Only `paper` so far.")] = "paper",
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Where to write.")] = Path("lure-paper"),
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Reproduce the paper."""
    if what != "paper":
        raise InputError(f"there is nothing to reproduce under the name {what!r}; give paper")
    from lure.analysis.output import checked_target, replaced

    checked_target(output)

    from lure.analysis.rod.paper import reproduce_paper

    out = Output(as_json=as_json, quiet=quiet)
    with out.progress() as tell, replaced(output) as directory:
        table = reproduce_paper(directory, progress=tell)
        text = (directory / "paper.json").read_text(encoding="utf-8")
    print((text if as_json else str(table)).rstrip("\n"))
    out.note(f"The page is {output / 'paper.html'}")


@app.command(help=texts.DOCTOR)
def doctor() -> int:
    """Print what is installed; status 2 if something lure needs is missing."""
    lines, healthy = findings()
    print("\n".join(lines))
    return 0 if healthy else 2


@app.command(help=texts.EXPLORE)
def explore(
    system: Annotated[
        str | None,
        typer.Argument(metavar="SYSTEM", help="The loop that the page opens with.", show_default=False),
    ] = None,
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Where to write.")] = Path("lure-page"),
    quiet: Quiet = False,
) -> None:
    """Write the page."""
    from lure.analysis.explore import write_page
    from lure.files import find_system
    from lure.files.system import LoopSystem

    chosen = None if system is None else find_system(system)
    if chosen is not None and not isinstance(chosen, LoopSystem):
        raise InputError(
            f"{system} is not a loop with one block H; the page opens with such a one, or without a SYSTEM"
        )
    page = write_page(output, chosen)
    if not quiet:
        print(f"The page is {page}; open it in a browser, or put the folder on any web server")
