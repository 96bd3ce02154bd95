"""The command ``lure rate``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lure.analysis.cli import texts
from lure.analysis.cli.certificates import check_target
from lure.analysis.cli.options import (
    Force,
    Json,
    Quiet,
    Seconds,
    Settings,
    Verbose,
    app,
    check_seconds,
    exit_status,
    loop_named,
    option,
    print_json,
    print_wrapped,
    refused,
    write_certificate,
)
from lure.analysis.cli.progress import progress

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Proved, Refuted
    from lure.analysis.questions.decay import RateBound
    from lure.analysis.questions.overshoot import Overshoot
    from lure.files.system import LoopSystem


@app.command(help=texts.RATE)
def rate(
    system: Annotated[str, typer.Argument(metavar="SYSTEM", help="A TOML file or a built-in system.")],
    output: Annotated[
        Path | None,
        option("-o --output --certificate", "FILE", "Write the certificate of the rate, or that there is none."),
    ] = None,
    force: Force = False,
    constant: Annotated[
        bool, typer.Option("--constant", help="Also the number c, at nine tenths of the rate; needs A, B, C.")
    ] = False,
    set_: Settings = None,
    seconds: Seconds = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> int:
    """Print the decay rate, from both sides."""
    check_seconds(seconds)
    chosen = loop_named(system, set_)
    if chosen.open:
        raise refused(
            f"{system} has no class of nonlinearities, of which a rate could be shown; give one, such as [class] with "
            "sector = [0, 1]"
        )
    if output is not None:
        check_target(output, force=force)
    from lure.analysis.questions.decay import decay_rate

    with progress(quiet=quiet, verbose=verbose) as tell:
        found = decay_rate(chosen, seconds=seconds, progress=tell)
        beside = _constant(chosen, found) if constant else None
    if as_json:
        print_json(found.to_dict() | ({"constant": beside.to_dict() if beside else None} if constant else {}))
    else:
        none = ["No number c is given, since no decay is proved."] if constant and beside is None else []
        print_wrapped([str(found), *([str(beside)] if beside else none)])
    shown, what, begin = _shown(found)
    write_certificate(output, shown, what, begin=begin, force=force, as_json=as_json, quiet=quiet)
    return exit_status(found.verdict)


def _shown(found: RateBound) -> tuple[Proved | Refuted | None, str, str]:
    """The certificate of the answer, of what it is, and how a sentence about it begins."""
    from lure.analysis.verdict import Verdict

    if found.proof and found.verdict is Verdict.PROVED:
        return found.proof, "of the rate that is proved", "The"
    other = found.verdict is Verdict.REFUTED or found.proof is None
    shown, what = (
        (found.refutation, "of the member that is no faster") if other else (found.proof, "of the bound of growth")
    )
    return shown, what if shown else "of a rate", "No decay is proved; the"


def _constant(loop: LoopSystem, found: RateBound) -> Overshoot | None:
    """The number ``c`` at nine tenths of a decay that is proved."""
    from fractions import Fraction

    from lure.analysis.questions.overshoot import overshoot
    from lure.analysis.verdict import Verdict

    if found.verdict is not Verdict.PROVED:
        return None
    rate = Fraction(f"{found.rate.high**0.9 if found.time == 'discrete' else 0.9 * found.rate.low:.6g}")
    return overshoot(loop, rate=rate)
