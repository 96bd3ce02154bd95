"""The command ``lure region``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lure.analysis.cli import texts
from lure.analysis.cli.certificates import check_target
from lure.analysis.cli.options import (
    Figure,
    Force,
    Json,
    Quiet,
    Seconds,
    Settings,
    Verbose,
    app,
    check_figure,
    check_seconds,
    exit_status,
    loop_named,
    option,
    print_json,
    print_note,
    print_wrapped,
    refused,
    write_certificate,
    write_figure,
)
from lure.analysis.cli.progress import progress

if TYPE_CHECKING:
    from fractions import Fraction


@app.command(help=texts.REGION)
def region(
    system: Annotated[str, typer.Argument(metavar="SYSTEM", help="A TOML file or a built-in system.")],
    set_: Settings = None,
    along: Annotated[
        str | None, option("--along", "POINTS", "Hold the largest multiple of these, as '1 1; 1 -1'.")
    ] = None,
    output: Annotated[
        Path | None, option("-o --output --certificate", "FILE", "Write the certificate of the first set.")
    ] = None,
    plot: Figure = None,
    force: Force = False,
    seconds: Seconds = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> int:
    """Print sets inside and outside of the region of attraction."""
    check_seconds(seconds)
    points = None if along is None else _points(along)
    check_figure(plot, replace=force)
    if output is not None:
        check_target(output, force=force)
    chosen = loop_named(system, set_)
    from lure.analysis.questions.regions import region as run

    with progress(quiet=quiet, verbose=verbose):
        found = run(chosen, along=points, seconds=seconds)
    if as_json:
        print_json(found.to_dict())
    else:
        print_wrapped(found.lines())
    proof = found.sets[0].proof if found.sets else None
    what = "of the first set" if found.sets else "of a set"
    write_certificate(output, proof, what, force=force, as_json=as_json, quiet=quiet)
    if plot is not None:
        write_figure(plot, found.plot, (5.2, 4.4), replace=force)
        print_note(f"Written: {plot}", as_json=as_json, quiet=quiet)
    return exit_status(found.verdict)


def _points(text: str) -> list[list[Fraction]]:
    """The points of the option, separated by semicolons."""
    from lure.errors import InputError
    from lure.plants import coefficients

    try:
        return [list(coefficients(part, "--along")) for part in text.split(";")]
    except InputError:
        raise refused(f"--along is {text!r:.60}; give points such as '1 1; 1 -1', separated by semicolons") from None
