"""The command ``lure gain``."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from lure.analysis.cli import texts
from lure.analysis.cli.certificates import check_target
from lure.analysis.cli.loops import Criterion
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
    write_certificate,
)
from lure.analysis.cli.progress import progress

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Proved, Refuted
    from lure.analysis.questions.gain import GainBound


@app.command(help=texts.GAIN)
def gain(
    system: Annotated[str, typer.Argument(metavar="SYSTEM", help="A TOML file with a table [performance].")],
    output: Annotated[
        Path | None,
        option("-o --output --certificate", "FILE", "Write the certificate of the bound, or that there is none."),
    ] = None,
    witness: Annotated[Path | None, option("--witness", "FILE", "Write that of the member with a large gain.")] = None,
    force: Force = False,
    criterion: Criterion = "best",
    window: Annotated[int | None, option("--window", "N", "In discrete time: constraints over N samples.")] = None,
    incremental: Annotated[
        bool, typer.Option("--incremental", help="The gain of differences of two solutions.")
    ] = False,
    worst: Annotated[
        bool, typer.Option("--worst", help="Look for disturbances with gains that jump too, of classes that may.")
    ] = False,
    energy: Annotated[
        bool, typer.Option("--energy", help="Also the energy of z after a push, and its peak for an energy of w.")
    ] = False,
    set_: Settings = None,
    seconds: Seconds = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> int:
    """Print the L2 gain from w to z, from both sides."""
    check_seconds(seconds)
    chosen = loop_named(system, set_)
    for path in (output, witness):
        if path is not None:
            check_target(path, force=force)
    from lure.analysis.questions.gain import l2_gain

    with progress(quiet=quiet, verbose=verbose) as tell:
        ways: dict[str, Any] = {"criterion": criterion, "window": window, "incremental": incremental, "worst": worst}
        found = l2_gain(chosen, **ways, seconds=seconds, progress=tell)
        if energy:
            from lure.analysis.questions.energy import energy_bounds

            beside = energy_bounds(chosen)
    if as_json:
        print_json(found.to_dict() | ({"energy": beside.to_dict()} if energy else {}))
    else:
        print_wrapped([str(found), *([str(beside)] if energy else [])])
    shown, begin = found.proof or found.refutation, "The" if found.proof else "No bound is proved; the"
    told = partial(write_certificate, force=force, as_json=as_json, quiet=quiet)
    told(output, shown, _side(found, shown), begin=begin)
    told(witness, found.refutation, _side(found, found.refutation))
    return exit_status(found.verdict)


def _side(found: GainBound, shown: Proved | Refuted | None) -> str:
    """Which side of the gain a certificate is of."""
    from lure.analysis.numerics.doubles import bound_above, bound_below
    from lure.analysis.verdict import Verdict

    if shown is None:
        return "of this side of the gain"
    if shown is found.proof:
        return f"that the gain is at most {bound_above(found.gain.high)}"
    if found.factors.verdict is Verdict.REFUTED:
        return "of the unstable member"
    return f"that a member has a gain above {bound_below(found.gain.low)}"
