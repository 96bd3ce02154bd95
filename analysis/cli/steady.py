"""The command ``lure steady``."""

from __future__ import annotations

from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

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
    from lure.analysis.questions.steady import SteadyResponse


@app.command(help=texts.STEADY)
def steady(
    system: Annotated[
        str, typer.Argument(metavar="SYSTEM", help="A TOML file, with a table [forcing] for amplitudes.")
    ],
    amplitude: Annotated[str | None, option("--amplitude", "A", "Of the sine, in place of forcing.amplitude.")] = None,
    omega: Annotated[
        str | None, option("--omega", "W", "Its frequencies [rad/s]: 2, or 0.5,1,2, or 0.1:10:40.")
    ] = None,
    output: Annotated[
        Path | None, option("-o --output --certificate", "FILE", "Write the certificate of the answer, if it has one.")
    ] = None,
    plot: Figure = None,
    csv: Annotated[Path | None, option("--csv", "FILE", "Write the amplitudes as a table, a row a response.")] = None,
    force: Force = False,
    set_: Settings = None,
    seconds: Seconds = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> int:
    """Print whether one solution attracts all others, and how large it is."""
    check_seconds(seconds)
    chosen = loop_named(system, set_, of_rods="response")
    if chosen.open:
        raise refused(
            f"{system} has no nonlinearity and no class of them; give one, such as [class] with slope = [0, 1]"
        )
    check_figure(plot, replace=force)
    for path in (output, csv):
        if path is not None:
            check_target(path, force=force)
    from lure.analysis.questions.steady import steady_response

    given: dict[str, Any] = {} if chosen.forcing is None else chosen.forcing.stated
    if amplitude is not None:
        given["amplitude"] = _numbers(amplitude, "--amplitude")
    if omega is not None:
        given["omega"] = _frequencies(omega)
    for name, path in (("--plot", plot), ("--csv", csv)):
        if path is not None and not given:
            raise refused(f"{name} needs an input to show the response to; give [forcing], or --amplitude")
    with progress(quiet=quiet, verbose=verbose) as tell:
        found = steady_response(chosen, forcing=given or None, seconds=seconds, progress=tell)
    if as_json:
        print_json(found.to_dict())
    else:
        print_wrapped([str(found)])
    sides = {"PROVED": found.proof, "REFUTED": found.refutation}
    shown, against = sides.get(str(found.verdict)), str(found.verdict) == "REFUTED"
    what = "of the member whose differences do not decay" if against else "of the rate of attraction"
    what = what if shown else "of the answer"
    write_certificate(output, shown, what, force=force, as_json=as_json, quiet=quiet)
    if csv is not None:
        from lure.analysis.output import write_new

        write_new(csv, _table(found, str(given.get("unit", ""))), force=force)
        print_note(f"Written: {csv}", as_json=as_json, quiet=quiet)
    if plot is not None:
        from lure.analysis.plots.steady import plot_steady

        write_figure(plot, partial(plot_steady, found), (7.2, 4.4), replace=force)
    return exit_status(found.verdict)


def _table(found: SteadyResponse, unit: str) -> str:
    """The responses as comma-separated values; a bound that is not known is left empty."""
    of = f" [{unit}]".replace(",", ";").replace('"', "") if unit else ""
    lines = [f"omega [rad/s],at least{of},at most{of},computed{of},periods of the input,evidence,only bounded solution"]
    for row in found.response:
        known = row.evidence.name == "CERTIFIED"
        ends = [repr(end) if known else "" for end in (row.low, row.high)]
        cells = [repr(row.omega), *ends, repr(row.computed), str(row.periods), str(row.evidence)]
        lines.append(",".join([*cells, "yes" if row.alone and known else ""]))
    return "\n".join(lines) + "\n"


def _numbers(text: str, name: str) -> list[Fraction]:
    """Numbers separated by commas."""
    try:
        return [Fraction(part.strip()) for part in text.split(",")]
    except (ValueError, ZeroDivisionError):
        raise refused(f"{name} is {text!r:.60}; give a number such as 2, or several, 0.5,1,2") from None


def _frequencies(text: str) -> list[Fraction]:
    """A list, or from the first to the second in so many equal ratios."""
    parts = text.split(":")
    if len(parts) == 1:
        return _numbers(text, "--omega")
    try:
        low, high, count = Fraction(parts[0]), Fraction(parts[1]), int(parts[2]) if len(parts) > 2 else 25
        if len(parts) > 3 or not 0 < low < high or not 1 < count <= 1000:
            raise ValueError
    except (ValueError, ZeroDivisionError):
        raise refused(f"--omega is {text!r:.60}; give first:last:how many, such as 0.1:10:40") from None
    step = (float(high) / float(low)) ** (1 / (count - 1))
    inner = [Fraction(f"{float(low) * step**i:.4g}") for i in range(1, count - 1)]
    return [low, *inner, high]
