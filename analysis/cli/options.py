"""What the commands share: the app, its options, what is refused before work begins, and how results leave."""

from __future__ import annotations

import difflib
import json
import shlex
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Proved, Refuted
    from lure.analysis.plots import Draw
    from lure.analysis.verdict import Verdict
    from lure.errors import InputError
    from lure.files.system import LoopSystem
    from lure.rod.assembly import RodAssembly
    from lure.rod.systems import RodSystem

app = typer.Typer(
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 80},
)


def option(names: str, metavar: str, text: str) -> object:
    """An option that has no default to show; its names are separated by blanks."""
    return typer.Option(*names.split(), metavar=metavar, help=text, show_default=False)


Json = Annotated[bool, typer.Option("--json", help="Print the results as JSON, and nothing else, on stdout.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress and no messages besides errors.")]
Seconds = Annotated[float | None, option("--seconds", "S", "Time allowed; without it no limit.")]
Verbose = Annotated[bool, typer.Option("--verbose", "-v", help="Show each step and its time on stderr.")]
Settings = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Change a value of the system; repeatable.")
]
Figure = Annotated[Path | None, option("--plot", "FILE", "Draw it: .svg or .png.")]
Replace = Annotated[bool, typer.Option("--replace", help="Replace the figure if it exists.")]
Rigid = Annotated[bool, typer.Option("--rigid", help="A rigid obstacle.")]
Force = Annotated[bool, typer.Option("--force", "--replace", help="Replace files that exist.")]


def refused(sentence: str) -> InputError:
    """The error that ends a command with status 2.

    ``import lure`` takes longer than most certificates do to check; a command that needs none of it should not wait.

    Parameters
    ----------
    sentence : str
        The field, the value found and the fix.
    """
    from lure.errors import InputError

    return InputError(sentence)


def check_seconds(seconds: float | None) -> None:
    """Refuse what is no time allowed.

    Parameters
    ----------
    seconds : float or None
        The option.

    Raises
    ------
    refused
        An ``InputError``: it is not positive, or not finite.
    """
    if seconds is not None and not 0 < seconds < 1e9:
        raise refused(f"--seconds is {seconds:g}; give a positive number of seconds, or leave it out")


def hint(word: str, names: Iterable[str]) -> str:
    """The clause ``did you mean ...?`` with the name that resembles a word, empty where none does."""
    near = difflib.get_close_matches(word, tuple(names), n=1, cutoff=0.5)
    return f"did you mean {near[0]!r}? " if near else ""


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
    refused
        An ``InputError``: it is a loop.
    """
    from lure.files import find_system
    from lure.rod.systems import RodSystem

    chosen = find_system(reference, settings or [])
    if isinstance(chosen, RodSystem):
        return chosen.single
    raise refused(
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
    refused
        An ``InputError``: it is a rod.
    """
    from lure.files import find_system
    from lure.files.system import LoopSystem

    chosen = find_system(reference, settings or [])
    if isinstance(chosen, LoopSystem):
        return chosen
    raise refused(f"{reference} is a rod; run: lure {of_rods} {reference}")


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
    refused
        An ``InputError``: its suffix is none of these, or the place cannot be written to.
    """
    if plot is None:
        return
    if plot.suffix.lower() not in kinds:
        *others, last = kinds
        raise refused(f"--plot is {str(plot)!r:.80}; give a name that ends in {', '.join(others)} or {last}")
    from lure.analysis.output import check_targets

    check_targets([plot], replace=replace)


def write_figure(plot: Path, draw: Draw, size: tuple[float, float], *, replace: bool) -> None:
    """Draw a figure into a file that :func:`check_figure` accepts.

    Parameters
    ----------
    plot : Path
        The file.
    draw : callable
        Draws on the axes given as ``ax``.
    size : (float, float)
        Width and height [inch].
    replace : bool
        Whether a file that exists may be replaced.
    """
    from lure.analysis.output import written
    from lure.analysis.plots import render

    suffix = plot.suffix.lower()
    picture = render(draw, name=plot.stem, size=size, suffixes=[suffix])
    with written([plot], replace=replace) as places:
        places[plot].write_bytes(picture.file(suffix))


def print_json(data: object) -> None:
    """Print results as JSON."""
    print(json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False))


def print_wrapped(lines: Iterable[str], *, nested: int = 2) -> None:
    """Print lines of text within 80 columns, indented by two blanks where they go on, `nested` if they are indented."""
    from lure.analysis.cli.texts import wrapped

    print("\n".join(part for line in lines for part in wrapped(line, indent=nested if line.startswith(" ") else 2)))


def print_note(message: str, *, as_json: bool, quiet: bool) -> None:
    """A message after the results, or on stderr where stdout is for JSON only."""
    if not quiet:
        print(message if as_json else f"\n{message}", file=sys.stderr if as_json else sys.stdout)


def write_certificate(
    path: Path | None,
    shown: Proved | Refuted | None,
    what: str,
    *,
    begin: str = "The",
    force: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    """Write a certificate, and say of what it is and how it is checked; or that none is written, since there is none.

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
    force : bool
        Whether a file that exists may be replaced.
    as_json, quiet : bool
        As for :func:`print_note`.
    """
    from lure.analysis.output import write_new
    from lure.analysis.questions.certify import text_of

    if path is None:
        return
    if shown is None:
        print_note(f"There is no certificate {what}; {path} is not written", as_json=as_json, quiet=quiet)
        return
    write_new(path, text_of(shown.certificate), force=force)
    said = f"{begin} certificate {what} is {path}"
    print_note(f"{said}; check it: {shlex.join(['lure', 'verify', str(path)])}", as_json=as_json, quiet=quiet)


def exit_status(verdict: Verdict) -> int:
    """The exit status that a verdict stands for."""
    return {"PROVED": 0, "INCONCLUSIVE": 10, "REFUTED": 11}[str(verdict)]
