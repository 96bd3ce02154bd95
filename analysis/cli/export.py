"""The command ``lure export``."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from lure.analysis.cli import texts
from lure.analysis.cli.certificates import ACCEPTED, check_target, verified
from lure.analysis.cli.options import Force, Quiet, Seconds, app, check_seconds, print_note, refused


@app.command(help=texts.EXPORT)
def export(
    certificate: Annotated[str, typer.Argument(metavar="CERTIFICATE", help="A certificate; - is standard input.")],
    coq: Annotated[bool, typer.Option("--coq", help="For Coq, 8.16 or later.")] = False,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="FILE", help="The file to write; - for standard output.")
    ] = Path("loop.v"),
    force: Force = False,
    seconds: Seconds = None,
    quiet: Quiet = False,
) -> None:
    """Write what a certificate shows for a proof assistant."""
    check_seconds(seconds)
    if not coq:
        raise refused("nothing says for which program the certificate is exported; give --coq")
    if str(output) != "-":
        _check_name(output)
        check_target(output, force=force)
    found = verified(certificate, second=False, seconds=seconds)
    if found.shown is None:
        raise refused(
            found.reason
            if found.result != "REJECTED"
            else f"the certificate is rejected: {found.reason}; export one that lure verify accepts"
        )
    assert found.result == ACCEPTED
    from lure.analysis.export import coq_text

    text = coq_text(found.shown)
    if str(output) == "-":
        sys.stdout.write(text)
        return
    from lure.analysis.output import write_new

    write_new(output, text, force=force)
    print_note(f"The proof is {output}; check it: {shlex.join(['coqc', str(output)])}", as_json=False, quiet=quiet)


def _check_name(path: Path) -> None:
    """What ``coqc`` takes as the name of a file."""
    stem = path.stem
    plain = stem.isascii() and stem.isidentifier()
    if path.suffix != ".v" or not plain:
        raise refused(
            f"--output is {str(path)!r}; coqc takes names of letters, digits and _ that end in .v, such as 'loop.v'"
        )
