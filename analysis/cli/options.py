"""What the commands share: the app, its options, what is refused before work begins, and how results leave."""

from __future__ import annotations

import json
import os
import shlex
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from lure.analysis.cli.progress import Tell, progress
from lure.errors import InputError
from lure.record import described, quantity

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Proved, Refuted
    from lure.analysis.plots import Draw
    from lure.analysis.verdict import Verdict
    from lure.files.system import LoopSystem
    from lure.rod.assembly import RodAssembly
    from lure.rod.systems import RodSystem

app = typer.Typer(
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 80},
)


def option(names: str, metavar: str, text: str, *, check: Callable[[Any], object] | None = None) -> object:
    """An option that has no default to show; its names are separated by blanks, and ``check`` may refuse its value."""
    return typer.Option(*names.split(), metavar=metavar, help=text, show_default=False, callback=check)


def _seconds(seconds: float | None) -> float | None:
    """Refuse what is no time allowed, before the command begins."""
    if seconds is not None and not 0 < seconds < 1e9:
        raise InputError(f"--seconds is {seconds:g}; give a positive number of seconds, or leave it out")
    return seconds


Json = Annotated[bool, typer.Option("--json", help="Print the results as JSON, and nothing else, on stdout.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress and no messages besides errors.")]
Seconds = Annotated[float | None, option("--seconds", "S", "Time allowed; without it no limit.", check=_seconds)]
Verbose = Annotated[bool, typer.Option("--verbose", "-v", help="Show each step and its time on stderr.")]
Settings = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Change a value of the system; repeatable.")
]
Figure = Annotated[Path | None, option("--plot", "FILE", "Draw it: .svg or .png.")]
Replace = Annotated[bool, typer.Option("--replace", help="Replace the figure if it exists.")]
Rigid = Annotated[bool, typer.Option("--rigid", help="A rigid obstacle.")]
Force = Annotated[bool, typer.Option("--force", "--replace", help="Replace files that exist.")]


def rod_named(reference: str, settings: list[str] | None, *, doing: str = "") -> RodSystem:
    """The rod that a built-in name or a TOML file stands for.

    Parameters
    ----------
    reference : str
        The name or the file.
    settings : list of str or None
        The option ``--set``.
    doing : str
        What the command does with rods, a clause of the refusal.

    Raises
    ------
    InputError
        It is a loop.
    """
    from lure.files import find_system
    from lure.rod.systems import RodSystem

    chosen = find_system(reference, settings or [])
    if isinstance(chosen, RodSystem):
        return chosen.single
    raise InputError(
        f"{chosen.name} is a Lur'e loop{doing}; give a rod such as paper-rod, or a TOML file with a table [rod]"
    )


def assembly_named(reference: str, settings: list[str] | None) -> RodAssembly | None:
    """The rods with several contacts that a TOML file stands for; None if it is about something else.

    Parameters
    ----------
    reference : str
        The file.
    settings : list of str or None
        The option ``--set``.
    """
    from lure.files import find_system
    from lure.rod.assembly import RodAssembly

    rods = getattr(find_system(reference, settings or []), "approximates", None)
    return rods if isinstance(rods, RodAssembly) else None


def loop_named(reference: str, settings: list[str] | None, *, of_rods: str = "report") -> LoopSystem:
    """The loop that a built-in name or a TOML file stands for.

    Parameters
    ----------
    reference : str
        The name or the file.
    settings : list of str or None
        The option ``--set``.
    of_rods : str
        The command that does the like with rods.

    Raises
    ------
    InputError
        It is a rod.
    """
    from lure.files import find_system
    from lure.files.system import LoopSystem

    chosen = find_system(reference, settings or [])
    if isinstance(chosen, LoopSystem):
        return chosen
    raise InputError(f"{reference} is a rod; run: lure {of_rods} {reference}")


def check_figure(plot: Path | None, *, replace: bool, kinds: Sequence[str] = (".svg", ".png")) -> None:
    """Refuse a figure that cannot be written, before anything is computed.

    Parameters
    ----------
    plot : Path or None
        The option ``--plot``.
    replace : bool
        Whether a file that exists may be replaced.
    kinds : sequence of str
        Suffixes of the files that can be drawn.

    Raises
    ------
    InputError
        Its suffix is none of these, or the place cannot be written to.
    """
    if plot is None:
        return
    if plot.suffix.lower() not in kinds:
        *others, last = kinds
        raise InputError(f"--plot is {str(plot)!r:.80}; give a name that ends in {', '.join(others)} or {last}")
    from lure.analysis.output import check_targets

    check_targets([plot], replace=replace)


def check_target(*paths: Path | None, force: bool) -> None:
    """Refuse files that exist, or are one file, before the search and not after it.

    Parameters
    ----------
    *paths : Path or None
        The files to write, if there are any.
    force : bool
        Whether they may be replaced.

    Raises
    ------
    InputError
        Two are the same; one exists, is a directory, or lies in none.
    """
    given = [path for path in paths if path is not None]
    if len(given) > 1:
        from lure.analysis.output import require_distinct

        require_distinct(given)
    for path in given:
        _check_target(path, force=force)


def _check_target(path: Path, *, force: bool) -> None:
    try:
        with suppress(FileNotFoundError, NotADirectoryError):
            path.lstat()
    except (OSError, ValueError) as error:  # a name that no file may have
        from lure.analysis.output import unwritable

        raise InputError(unwritable(path, error, "another place")) from None
    label = repr(str(path))
    if path.is_dir():
        raise InputError(f"{label} is a directory; give the name of a file, such as {str(path / 'certificate.json')!r}")
    if os.path.lexists(path) and not force:
        raise InputError(f"{label} exists; give another name, or --force to replace it")
    if not path.parent.is_dir():
        raise InputError(f"{str(path.parent)!r} is no directory; give a file in one that exists")


def print_json(data: object) -> None:
    """Print results as JSON."""
    print(json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False))


def print_wrapped(lines: Iterable[str], *, nested: int = 2) -> None:
    """Print lines of text within 80 columns, indented by two blanks where they go on, `nested` if they are indented."""
    from lure.analysis.cli.texts import wrapped

    print("\n".join(part for line in lines for part in wrapped(line, indent=nested if line.startswith(" ") else 2)))


@described(frozen=True, kw_only=True, slots=True)
class Output:
    """How a command tells what it found, as the options of these names ask."""

    as_json: bool = quantity("Whether stdout is for JSON only", default=False)
    quiet: bool = quantity("Whether nothing is said besides the results", default=False)
    verbose: bool = quantity("Whether each step is said", default=False)
    replace: bool = quantity("Whether a file that exists may be replaced", default=False)

    def progress(self) -> AbstractContextManager[Tell | None]:
        """What shows how far the work is, see :func:`lure.analysis.cli.progress.progress`."""
        return progress(quiet=self.quiet, verbose=self.verbose)

    def results(self, data: Mapping[str, object], lines: Iterable[str]) -> None:
        """The results: as JSON, or in lines of 80 columns."""
        if self.as_json:
            print_json(data)
        else:
            print_wrapped(lines)

    def note(self, message: str) -> None:
        """A message after the results, or on stderr where stdout is for JSON only."""
        if not self.quiet:
            print(message if self.as_json else f"\n{message}", file=sys.stderr if self.as_json else sys.stdout)

    def draw(self, plot: Path | None, draw: Draw, size: tuple[float, float]) -> None:
        """Draw a figure into a file that :func:`check_figure` accepts.

        Parameters
        ----------
        plot : Path or None
            The file; None where none is asked for.
        draw : callable
            Draws on the axes given as ``ax``.
        size : (float, float)
            Width and height [inch].
        """
        if plot is None:
            return
        from lure.analysis.output import written
        from lure.analysis.plots import render

        suffix = plot.suffix.lower()
        picture = render(draw, name=plot.stem, size=size, suffixes=[suffix])
        with written([plot], replace=self.replace) as places:
            places[plot].write_bytes(picture.file(suffix))

    def figure(self, plot: Path | None, draw: Draw, size: tuple[float, float]) -> None:
        """The same, and say that it is written."""
        self.draw(plot, draw, size)
        if plot is not None:
            self.note(f"Written: {plot}")

    def certificate(self, path: Path | None, shown: Proved | Refuted | None, what: str, *, begin: str = "The") -> None:
        """Write a certificate, and say of what it is and how it is checked; or that none is written: there is none.

        Parameters
        ----------
        path : Path or None
            The file; None where none is asked for.
        shown : Proved, Refuted or None
            What the checker accepted, if anything.
        what : str
            Of what it is the certificate, such as ``of the rate that is proved``.
        begin : str
            How the sentence begins, where the certificate is of something else than was asked for.
        """
        from lure.analysis.output import write_new
        from lure.analysis.questions.certify import text_of

        if path is None:
            return
        if shown is None:
            self.note(f"There is no certificate {what}; {path} is not written")
            return
        write_new(path, text_of(shown.certificate), force=self.replace)
        said = f"{begin} certificate {what} is {path}"
        self.note(f"{said}; check it: {shlex.join(['lure', 'verify', str(path)])}")


def exit_status(verdict: Verdict) -> int:
    """The exit status that a verdict stands for."""
    return {"PROVED": 0, "INCONCLUSIVE": 10, "REFUTED": 11}[str(verdict)]
