"""The command ``lure compare``."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from analysis.cli.commands import Json, Quiet
from analysis.cli.comparing_texts import COMPARE
from analysis.cli.refused import refused
from analysis.cli.simulating import app as app

if TYPE_CHECKING:
    from analysis.comparison import Comparison
    from analysis.plots.comparison import FileKind
    from lure.systems import RodSystem

KINDS = ("svg", "png", "pdf")
NONE = "none"


@app.command(help=COMPARE)
def compare(
    system: Annotated[
        str, typer.Argument(metavar="SYSTEM", help="A built-in rod or a TOML file with one.")
    ] = "paper-rod",
    until: Annotated[
        float | None,
        typer.Option("--until", metavar="S", help="End of the motion; else that of the system.", show_default=False),
    ] = None,
    cells: Annotated[
        str, typer.Option("--cells", metavar="N,N,..", help="Cells of the scheme, or none.")
    ] = "10,50,200",
    galerkin: Annotated[
        str, typer.Option("--galerkin", metavar="SPACE:M,..", help="Galerkin spaces P1, P2, cosine, or none.")
    ] = "P1:51,P2:51,cosine:50",
    method: Annotated[str, typer.Option("--method", metavar="NAME", help="What integrates the scheme.")] = "exact",
    samples: Annotated[int, typer.Option("--samples", metavar="N", help="Instants compared, evenly spaced.")] = 2001,
    plot: Annotated[
        Path | None,
        typer.Option("--plot", metavar="FILE", help="Draw all of them: .svg, .png or .pdf.", show_default=False),
    ] = None,
    replace: Annotated[bool, typer.Option("--replace", help="Replace the figure if it exists.")] = False,
    set_: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Change a value of the system; repeatable."),
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Compare, print the table, and draw it where asked for."""
    sizes, spaces = _cells(cells), _spaces(galerkin)
    chosen = _rod_system(system, set_ or [])
    kind = _checked_plot(plot, replace=replace)
    from analysis.cli.progress import progress
    from analysis.comparison import SchemeMethod
    from analysis.comparison import compare as run

    with progress(quiet=quiet) as tell:
        found = run(
            chosen.rod,
            chosen.scenario,
            chosen.until if until is None else until,
            cells=sizes,
            galerkin=cast("Any", spaces),  # names are checked where the spaces are made
            method=cast("SchemeMethod", method),
            samples=samples,
            progress=tell,
        )
        if plot is not None and kind is not None:
            _draw(found, plot, kind, replace=replace)
    print(json.dumps(found.to_dict(), indent=2, ensure_ascii=False, allow_nan=False) if as_json else f"{found}")
    if plot is not None and not quiet:
        print(("" if as_json else "\n") + f"Written: {plot}", file=sys.stderr if as_json else sys.stdout)


def _cells(text: str) -> list[int]:
    if text.strip() == NONE:
        return []
    try:
        return [int(part) for part in text.split(",")]
    except ValueError:
        raise refused(f"--cells is {text!r:.60}; give whole numbers such as 10,50,200, or none") from None


def _spaces(text: str) -> list[tuple[str, int]]:
    if text.strip() == NONE:
        return []
    found = []
    for part in text.split(","):
        name, _, order = part.strip().partition(":")
        try:
            found.append((name, int(order)))
        except ValueError:
            raise refused(f"--galerkin is {text!r:.60}; give pairs such as P1:51,cosine:50, or none") from None
    return found


def _rod_system(reference: str, settings: list[str]) -> RodSystem:
    from lure.system_file import find_system
    from lure.systems import RodSystem

    chosen = find_system(reference, settings)
    if not isinstance(chosen, RodSystem):
        raise refused(
            f"{chosen.name} is a Lur'e loop, and lure compare moves rods; give a rod such as paper-rod, or a TOML file "
            "with a table [rod]"
        )
    if chosen.form != "corrected":
        raise refused(
            f"{chosen.name} has the form {chosen.form}, which is no scheme of its rod; give it as "
            "--set discretisation.form=corrected, with the force divided by c N/L"
        )
    return chosen


def _checked_plot(plot: Path | None, *, replace: bool) -> FileKind | None:
    """The kind of figure; a place that cannot be written to is refused before anything is computed."""
    if plot is None:
        return None
    kind = plot.suffix.lower().removeprefix(".")
    if kind not in KINDS:
        raise refused(f"--plot is {str(plot)!r:.80}; give a name that ends in .svg, .png or .pdf")
    from analysis.runs.writing import check_targets

    check_targets([plot], replace=replace)
    return cast("FileKind", kind)


def _draw(found: Comparison, plot: Path, kind: FileKind, *, replace: bool) -> None:
    from analysis.plots.comparison import comparison_file
    from analysis.runs.writing import written

    picture = comparison_file(found, kind)
    with written([plot], replace=replace) as places:
        places[plot].write_bytes(picture)
